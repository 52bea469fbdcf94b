/* child.h - child processes. */
#ifndef KITH_IO_CHILD_H
#define KITH_IO_CHILD_H

#include <sys/types.h>

/* Waits until a child ends, through signals. Returns its exit code (0 to 255), or -N if signal N ended it. */
int kith_child_wait(pid_t child);

/* work(of) in a child process whose standard error is shut; returns as kith_child_wait does. For what may
 * bring the program down: HDF5 1.10 cannot close a file that it cannot write, nor always survive a lack of
 * memory. Only memory that is shared comes back. Where there can be no other process it works in this one.
 * Cost: a fork. */
int kith_child_run(int (*work)(void *), void *of);

#endif
