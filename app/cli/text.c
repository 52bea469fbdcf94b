/* text.c - wrapped text and quantities with units. */
#include "app/cli/text.h"

#include <stdarg.h>
#include <stdbool.h>
#include <string.h>

void kith_text_wrapped(int indent, const char *label, const char *text) {
  const size_t room = (size_t)(KITH_TEXT_WIDTH - indent);
  const char *p = text;
  do {
    size_t length = strlen(p);
    if (length > room) {
      for (length = room; length > 0 && p[length] != ' ';) --length;
      if (length == 0) length = room; /* a word that is too long is cut */
    }
    printf("%-*s%.*s\n", indent, p == text ? label : "", (int)length, p);
    p += length;
    p += strspn(p, " ");
  } while (*p != '\0');
}

void kith_text_add(char *text, size_t size, const char *format, ...) {
  const size_t used = strlen(text);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text + used, size - used, format, arguments);
  va_end(arguments);
}

void kith_text_join(char *text, size_t size, const char *between, const char *format, ...) {
  va_list arguments;
  if (text[0] != '\0') kith_text_add(text, size, "%s", between);
  const size_t used = strlen(text);
  va_start(arguments, format);
  vsnprintf(text + used, size - used, format, arguments);
  va_end(arguments);
}

void kith_text_line(const char *label, const char *format, ...) {
  char text[2048], indented[32];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  snprintf(indented, sizeof indented, "  %s", label);
  kith_text_wrapped(16, indented, text);
}

const char *kith_text_bytes(char text[32], double bytes) {
  static const char *const unit[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  int u = 0;
  for (; u < 4 && bytes >= 1024; ++u) bytes /= 1024;
  snprintf(text, 32, "%.*f %s", u == 0 ? 0 : 1, bytes, unit[u]);
  return text;
}

const char *kith_text_seconds(char text[32], double seconds) {
  if (seconds < 1e-3)
    snprintf(text, 32, "%.3g us", 1e6 * seconds);
  else if (seconds < 1)
    snprintf(text, 32, "%.3g ms", 1e3 * seconds);
  else if (seconds < 120)
    snprintf(text, 32, "%.3g s", seconds);
  else if (seconds < 7200)
    snprintf(text, 32, "%.1f min", seconds / 60);
  else
    snprintf(text, 32, "%.3g h", seconds / 3600);
  return text;
}

void kith_text_word(FILE *out, const char *word) {
  const bool plain = word[0] != '\0' && strspn(word,
                                               "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                               "0123456789-_=./:,+%@") == strlen(word);
  if (!plain) fputc('\'', out);
  for (const char *c = word; *c != '\0'; ++c) fputs(*c == '\'' ? "'\\''" : (char[]){*c, '\0'}, out);
  if (!plain) fputc('\'', out);
}

void kith_text_cell(FILE *out, int width, int digits, double value) {
  if (value > 0)
    fprintf(out, " %*.*f", width, digits, value);
  else
    fprintf(out, " %*s", width, "-");
}
