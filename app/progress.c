#include "app/progress.h"

#include <math.h>
#include <string.h>
#include <unistd.h>
#include "app/text.h"

void kith_progress_start(int done, int all, const struct kith_job *job, bool quiet) {
  if (quiet || !isatty(STDERR_FILENO)) return;
  fprintf(stderr, "\r\033[K[%d/%d] %s at %.6g runs", done + 1, all, job->method, job->x);
  fflush(stderr);
}

void kith_progress_point(int done, int all, const struct kith_point *p, int metric, double left, bool quiet) {
  char text[32];
  if (quiet) return;
  fprintf(stderr, "%s[%d/%d] %s at %.6g: ", isatty(STDERR_FILENO) ? "\r\033[K" : "", done, all, p->method,
          p->x);
  if (p->failed)
    fprintf(stderr, "failed: %s", p->why);
  else
    fprintf(stderr, "%s %.4g, %.3g CPU-s", kith_metrics[metric].name, p->value[metric], p->value[0]);
  if (done < all && isfinite(left)) fprintf(stderr, "; about %s left", kith_text_seconds(text, left));
  fputc('\n', stderr);
}
