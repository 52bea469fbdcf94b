/* screen.c - the progress line of a run. */
#include "app/cli/screen.h"

#include <unistd.h>

void kith_screen_init(struct kith_screen *screen, FILE *out, bool quiet, double from, double until) {
  *screen = (struct kith_screen){.out = out,
                                 .terminal = isatty(fileno(out)) != 0,
                                 .quiet = quiet,
                                 .started = kith_seconds(),
                                 .from = from,
                                 .until = until};
}

static void clock_text(char *text, size_t size, double seconds) {
  const long s = (long)(seconds + 0.5);
  if (s >= 3600)
    snprintf(text, size, "%ldh%02ldm", s / 3600, s / 60 % 60);
  else
    snprintf(text, size, "%ldm%02lds", s / 60, s % 60);
}

void kith_screen_step(struct kith_screen *screen, const struct kith_integrator *it, bool last) {
  const double now = kith_seconds(), wait = screen->terminal ? 0.1 : 2.0;
  if (screen->quiet || (!last && now - screen->last_shown < wait)) return;
  screen->last_shown = now;
  const double done =
      screen->until > screen->from ? (it->time - screen->from) / (screen->until - screen->from) : 1;
  char eta[32];
  clock_text(eta, sizeof eta, done > 0 ? (now - screen->started) * (1 - done) / done : 0);
  if (screen->rows++ == 0)
    fprintf(screen->out, "%8s  %-12s %-11s %-14s %12s %10s %6s  %s\n", "step", "time", "dt", "limited by",
            "node", "ghosts", "done", "ETA");
  fprintf(screen->out, "%s%8llu  %-12.6g %-11.4g %-14s %12lld %10d %5.1f%%  %-8s%s",
          screen->terminal ? "\r" : "", (unsigned long long)it->step, it->time, it->dt,
          kith_limit_name(it->limiter), (long long)it->limiting_node, it->nodes->n_ghost, 100 * done, eta,
          screen->terminal ? "" : "\n");
  fflush(screen->out);
}

void kith_screen_end(struct kith_screen *screen) {
  if (!screen->quiet && screen->terminal && screen->rows > 0) fputc('\n', screen->out);
}
