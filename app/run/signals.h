/* signals.h - how a run is stopped from outside, and the process that watches over ranks.
 *
 * INT, TERM, HUP, USR1 and USR2 stop a run after the present step: it writes a checkpoint and a snapshot and
 * ends with code 1. One that comes a second later, or before the first step, ends it at once. Ranks that
 * `kith run --ranks N` starts hear of it through the process that started them. */
#ifndef KITH_APP_RUN_SIGNALS_H
#define KITH_APP_RUN_SIGNALS_H

#include "app/cli/options.h"

/* Makes broken pipes and files that may not grow errors of their writes, not the end; a crash is one line. */
void kith_signals_ignore(void);
/* From now on signals stop the run after a step. */
void kith_signals_catch(void);
/* Has a signal come? */
bool kith_signals_stop(void);

/* Runs this program with the same words under mpirun, on `ranks` ranks, and waits. Signals go on to all of
 * them. *code: the exit code; FAILED, with a message, if a rank ended without a word. */
kith_status kith_signals_launch(int ranks, char *const *words, enum kith_exit *code);

#endif
