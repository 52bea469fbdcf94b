/* traversal.h - how passes walk over nodes: chunks of consecutive nodes, shared out among threads.
 *
 * A pass is a function of a chunk; its inner loop runs over the row of one node. Two forms of every sum over
 * pairs exist and agree to round-off:
 *   pairs    a pair within a chunk (a tile) is evaluated once and given to both ends (physics/passes/force.h)
 *   gather   each node evaluates its whole row and keeps its own side
 * In both a chunk is summed by one thread, in a fixed order, so results do not depend on the number of
 * threads. */
#ifndef KITH_CONNECTIVITY_TRAVERSAL_H
#define KITH_CONNECTIVITY_TRAVERSAL_H

#include "lib/connectivity/connectivity.h"
#include "lib/core/lanes.h"

/* One thread's memory: `lane[k]`, arrays of `width` doubles each, aligned; and counters, summed at the
 * end. */
struct kith_scratch {
  size_t width;
  double *lane;
  uint64_t count[4];
};

static inline double *kith_scratch_lane(const struct kith_scratch *s, int k) {
  return s->lane + (size_t)k * s->width;
}

/* x_j - x_i of the entries of row i as seen from i, and the squares of their lengths: lanes.h. */
KITH_INLINE void kith_row_separations(const struct kith_nodes *nodes, const struct kith_rows *rows,
                                      kith_index i, double *restrict to, size_t stride, double *restrict r2) {
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const kith_index *node = rows->node + first;
  const uint16_t *shift = kith_shifts_at(rows->shift, rows->zero, first, n);
  const double *x = nodes->position->f64;
  if (shift == NULL) /* compiled apart: it does not pay for shifts */
    kith_lanes_separations(x, i, node, NULL, NULL, n, to, stride, r2);
  else
    kith_lanes_separations(x, i, node, shift, nodes->shifts.by, n, to, stride, r2);
}

/* Sets d = x_j - x_i for entry e of row i alone; returns its square. */
static inline double kith_entry_separation(const struct kith_nodes *nodes, const struct kith_rows *rows,
                                           kith_index i, size_t e, double d[NDIM]) {
  const double *xi = nodes->position->f64 + (size_t)i * NDIM,
               *xj = nodes->position->f64 + (size_t)rows->node[e] * NDIM,
               *by = rows->shift != NULL ? nodes->shifts.by[rows->shift[e]] : NULL;
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = (by != NULL ? xj[a] + by[a] : xj[a]) - xi[a];
    r2 += d[a] * d[a];
  }
  return r2;
}

typedef void (*kith_chunk_pass)(void *context, kith_index begin, kith_index end,
                                struct kith_scratch *scratch);

/* Runs `pass` over nodes 0 .. n - 1. Each thread has `lanes` arrays of at least `width` doubles (rounded up).
 * Busy times of the threads go to the present stage of `profile`. */
kith_status kith_traverse(kith_index n, kith_chunk_pass pass, void *context, int lanes, size_t width,
                          struct kith_profile *profile);

enum { KITH_CHUNK = 128 }; /* nodes */
/* A pass over some of the nodes: those that take part in an evaluation, and of these, while messages are
 * under way, those that need no values of other ranks. {0}: all nodes. */
struct kith_part {
  kith_index first;        /* of the n nodes; 0 where activity or chunk is given */
  const uint8_t *activity; /* [n] of the nodes; NULL: all take part */
  uint8_t least;           /* nodes with at least this activity, which is not idle, take part */
  bool whole;              /* the pass is called for whole chunks in which any node takes part, and skips the
                            * others itself; false: for each run of nodes that take part */
  kith_index size; /* of the chunks that the pass is called for, a multiple of KITH_CHUNK; 0: KITH_CHUNK */
  const uint8_t *chunk;     /* [n / KITH_CHUNK, rounded up] of chunks of that size; NULL: all are wanted */
  uint8_t wanted;           /* chunks are run where the largest of these values is `wanted` */
  struct kith_ranks *ranks; /* for kith_ranks_progress between chunks; may be NULL */
};
/* As kith_traverse, over a part. count[4] gets the sums of the counters of all threads; NULL: not wanted. */
kith_status kith_traverse_part(kith_index n, const struct kith_part *part, kith_chunk_pass pass,
                               void *context, int lanes, size_t width, uint64_t *count,
                               struct kith_profile *profile);

#endif
