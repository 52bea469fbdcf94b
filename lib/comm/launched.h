/* launched.h - what launchers of processes tell in the environment. */
#ifndef KITH_COMM_LAUNCHED_H
#define KITH_COMM_LAUNCHED_H

/* Processes that were started together with this one by mpirun, mpiexec or srun. */
int kith_launched(void);

#endif
