/* messages.c - to be preloaded: at the n-th MPI call of a rank of kith an MPI error occurs, or the rank ends.
 *
 *   KITH_FAULT_N      n; 0: none
 *   KITH_FAULT_RANK   the rank (0)
 *   KITH_FAULT_HOW    error: an MPI error; abort: the rank aborts; kill: it is killed
 *   KITH_FAULT_COUNT  a file to which the number of calls is written at the end */
#include <mpi.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static long count;

static void count_call(void) {
  const char *n = getenv("KITH_FAULT_N"), *how = getenv("KITH_FAULT_HOW"), *which = getenv("KITH_FAULT_RANK");
  int rank;
  if (n == NULL || how == NULL || PMPI_Comm_rank(MPI_COMM_WORLD, &rank) != MPI_SUCCESS) return;
  if (rank != (which != NULL ? atoi(which) : 0) || ++count != atol(n)) return;
  if (strcmp(how, "error") == 0) MPI_Comm_call_errhandler(MPI_COMM_WORLD, MPI_ERR_OTHER);
  if (strcmp(how, "abort") == 0) abort();
  if (strcmp(how, "kill") == 0) raise(SIGKILL);
}

#define CALLS(X)                                                                                            \
  X(Comm_dup, (MPI_Comm c, MPI_Comm * d), (c, d))                                                           \
  X(Comm_split_type, (MPI_Comm c, int t, int k, MPI_Info i, MPI_Comm *d), (c, t, k, i, d))                  \
  X(Allreduce, (const void *s, void *r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c), (s, r, n, t, o, c))   \
  X(Iallreduce, (const void *s, void *r, int n, MPI_Datatype t, MPI_Op o, MPI_Comm c, MPI_Request *q),      \
    (s, r, n, t, o, c, q))                                                                                  \
  X(Bcast, (void *b, int n, MPI_Datatype t, int r, MPI_Comm c), (b, n, t, r, c))                            \
  X(Alltoall, (const void *s, int n, MPI_Datatype t, void *r, int m, MPI_Datatype u, MPI_Comm c),           \
    (s, n, t, r, m, u, c))                                                                                  \
  X(Allgather, (const void *s, int n, MPI_Datatype t, void *r, int m, MPI_Datatype u, MPI_Comm c),          \
    (s, n, t, r, m, u, c))                                                                                  \
  X(Allgatherv,                                                                                             \
    (const void *s, int n, MPI_Datatype t, void *r, const int m[], const int d[], MPI_Datatype u,           \
     MPI_Comm c),                                                                                           \
    (s, n, t, r, m, d, u, c))                                                                               \
  X(Send, (const void *b, int n, MPI_Datatype t, int p, int g, MPI_Comm c), (b, n, t, p, g, c))             \
  X(Recv, (void *b, int n, MPI_Datatype t, int p, int g, MPI_Comm c, MPI_Status *s), (b, n, t, p, g, c, s)) \
  X(Isend, (const void *b, int n, MPI_Datatype t, int p, int g, MPI_Comm c, MPI_Request *r),                \
    (b, n, t, p, g, c, r))                                                                                  \
  X(Irecv, (void *b, int n, MPI_Datatype t, int p, int g, MPI_Comm c, MPI_Request *r),                      \
    (b, n, t, p, g, c, r))                                                                                  \
  X(Wait, (MPI_Request * r, MPI_Status * s), (r, s))                                                        \
  X(Waitall, (int n, MPI_Request r[], MPI_Status s[]), (n, r, s))                                           \
  X(Testall, (int n, MPI_Request r[], int *f, MPI_Status s[]), (n, r, f, s))
#define X(name, parameters, arguments) \
  int MPI_##name parameters {          \
    count_call();                      \
    return PMPI_##name arguments;      \
  }
CALLS(X)
#undef X

int MPI_Finalize(void) {
  const char *path = getenv("KITH_FAULT_COUNT");
  count_call();
  FILE *f = path != NULL && count > 0 ? fopen(path, "w") : NULL;
  if (f != NULL) fprintf(f, "%ld\n", count), fclose(f);
  return PMPI_Finalize();
}
