/* child.h - child processes. */
#ifndef KITH_IO_CHILD_H
#define KITH_IO_CHILD_H

#include <sys/types.h>

/* Waits until a child ends, through signals. Returns its exit code (0 to 255), or -N if signal N ended it. */
int kith_child_wait(pid_t child);

/* Calls work(of) in a child process without standard error, and returns as kith_child_wait does. This is for
 * what may end the process: HDF5 1.10 cannot close a file that it cannot write, and does not always survive
 * a lack of memory. What `work` changes is seen here only in shared memory. If no child can be started,
 * `work` is called in this process. Cost: a fork. */
int kith_child_run(int (*work)(void *), void *of);

#endif
