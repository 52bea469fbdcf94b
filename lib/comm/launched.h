/* launched.h - what launchers of processes tell in the environment. */
#ifndef KITH_COMM_LAUNCHED_H
#define KITH_COMM_LAUNCHED_H

/* Processes that mpirun, mpiexec or srun started together, this one among them; 1: it was started alone. */
int kith_launched(void);

#endif
