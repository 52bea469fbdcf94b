/* vector.h - the state as a vector of SUNDIALS: position, velocity and energy of the internal nodes, in this order.
 *
 * One vector of a set is the view: its numbers are those of the fields themselves, wherever they lie, so a solver that works on it
 * works on the nodes. All vectors cloned from it have memory of their own, without ghosts. Lengths are those of the nodes when
 * the set was made: another number of internal nodes wants another set.
 *
 * Elements are worked on by all threads; sums are exact (sum.h), and so depend neither on the number of threads nor on that of ranks. */
#ifndef KITH_INTEGRATOR_VECTOR_H
#define KITH_INTEGRATOR_VECTOR_H

#include <sundials/sundials_nvector.h>
#include "physics/hydro.h"

enum kith_vector_part { KITH_VECTOR_POSITION, KITH_VECTOR_VELOCITY, KITH_VECTOR_ENERGY, KITH_VECTOR_PARTS };

struct kith_vectors {
  SUNContext context;                          /* for all objects of SUNDIALS that use the vectors */
  struct kith_field *field[KITH_VECTOR_PARTS]; /* borrowed */
  struct kith_ranks *ranks;                    /* borrowed; sums and lengths are those of all ranks */
  kith_index nodes;                            /* internal ones, of this rank */
  int64_t length;                              /* numbers of a vector, all ranks together */
  N_Vector view;
  size_t bytes; /* of all clones that live */
};

/* Collective. Owned by the caller. All vectors and solvers that were made with it go first. */
kith_status kith_vectors_create(struct kith_vectors **out, const struct kith_hydro *hydro);
void kith_vectors_destroy(struct kith_vectors **vectors);
/* Is this the set for the nodes that there are, on all ranks? NULL is none. Collective. */
bool kith_vectors_fit(const struct kith_vectors *vectors, const struct kith_nodes *nodes);

/* The numbers of one part. View. */
double *kith_vector_numbers(N_Vector vector, enum kith_vector_part part);
/* A new vector, NULL without memory. N_VDestroy when done. */
N_Vector kith_vector_clone(const struct kith_vectors *vectors);
/* Of the numbers of one vector. */
size_t kith_vector_bytes(const struct kith_hydro *hydro);

#endif
