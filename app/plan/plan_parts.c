/* Lines and stages of `kith plan`. */
#include "app/plan/plan_parts.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"

void kith_plan_line(const char *label, const char *format, ...) {
  char text[2048], indented[32];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  snprintf(indented, sizeof indented, "  %s", label);
  kith_text_wrapped(stdout, 16, indented, text);
}

bool kith_plan_measured(const struct kith_stage *stage) {
  return stage->depth == 0 && strcmp(stage->path, "start") != 0;
}
