/* screen.h - progress while a run goes on: one redrawn line on a terminal, plain rows otherwise. */
#ifndef KITH_APP_CLI_SCREEN_H
#define KITH_APP_CLI_SCREEN_H

#include <stdio.h>
#include "integrator/integrator.h"

struct kith_screen {
  FILE *out;
  bool terminal, quiet;
  double started, last_shown;
  double from, until; /* times: for the ETA */
  uint64_t rows;
};

void kith_screen_init(struct kith_screen *screen, FILE *out, bool quiet, double from, double until);
/* After every step; shows what is due (10 times a second on a terminal, every 2 seconds or so otherwise, and
 * the last one). */
void kith_screen_step(struct kith_screen *screen, const struct kith_integrator *integrator, bool last);
/* Ends the redrawn line, so that what follows starts on a line of its own. */
void kith_screen_end(struct kith_screen *screen);

#endif
