/* launch.h - several processes: started by mpirun, or starting it. */
#ifndef KITH_APP_LAUNCH_H
#define KITH_APP_LAUNCH_H

#include "app/options.h"
#include "lib/core/ranks.h"

/* *ranks: the processes of this run, NULL if it is one. If --ranks asks for several and nobody started them, this process becomes
 * mpirun with the same words, and does not come back. BAD_INPUT: another number was started than asked for.
 * Threads: without --threads and OMP_NUM_THREADS the ranks of a machine share its cores. */
kith_status kith_launch(struct kith_ranks **ranks, const struct kith_options *options);

#endif
