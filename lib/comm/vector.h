/* vector.h - vectors of SUNDIALS over a few arrays, on several ranks.
 *
 * A set says how many parts its vectors have and how long they are on this rank. One vector of a set is the
 * view: its numbers are the caller's own arrays, wherever they lie at the time, so a solver that works on it
 * works on them. All vectors cloned from it have memory of their own.
 *
 * Elements are worked on by all threads; sums are exact (sum.h), and so depend neither on the number of
 * threads nor on that of ranks. */
#ifndef KITH_COMM_VECTOR_H
#define KITH_COMM_VECTOR_H

#include <sundials/sundials_nvector.h>
#include "lib/comm/ranks.h"

enum { KITH_VECTOR_MAX_PARTS = 3 };

struct kith_vector_part {
  double *const *numbers; /* address of the caller's pointer, which may change */
  int64_t length;         /* numbers on this rank */
};

struct kith_vectors {
  SUNContext context; /* for all objects of SUNDIALS that use the vectors */
  int parts;
  struct kith_vector_part part[KITH_VECTOR_MAX_PARTS];
  struct kith_ranks *ranks; /* borrowed; sums and lengths are those of all ranks */
  int64_t own, length;      /* numbers of a vector: of this rank, of all ranks together */
  N_Vector view;
  size_t bytes; /* of all clones that live */
  /* N_VClone of SUNDIALS does not survive a clone that there is no memory for. It gets this one then, which
   * has the numbers of the view, and `lacking` is true: whatever was computed is worth nothing. */
  N_Vector spare;
  bool lacking;
};

/* A context that prints nothing: errors are codes that the caller looks at. False: no memory. Up to version 6
 * each solver has a handler of its own beside it, KITH_QUIET(ERKStepSetErrHandlerFn, solver). */
bool kith_sundials_create(SUNContext *context);
void kith_sundials_quiet(int code, const char *module, const char *function, char *message, void *data);
#if SUNDIALS_VERSION_MAJOR >= 7
#define KITH_QUIET(set_handler, solver) 0
#else
#define KITH_QUIET(set_handler, solver) set_handler(solver, kith_sundials_quiet, NULL)
#endif

/* Owned by the caller; all vectors and solvers that were made with it go first. Collective; the status is
 * agreed on. */
kith_status kith_vectors_create(struct kith_vectors **out, struct kith_ranks *ranks, int parts,
                                const struct kith_vector_part *part);
void kith_vectors_destroy(struct kith_vectors **vectors);

/* The numbers of one part. View. */
double *kith_vector_numbers(N_Vector vector, int part);
/* A new vector, NULL without memory. N_VDestroy when done. */
N_Vector kith_vector_clone(const struct kith_vectors *vectors);

#endif
