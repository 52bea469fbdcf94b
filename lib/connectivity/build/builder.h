/* builder.h - builders of lists, what they are given, and scratch memory that is kept from build to build.
 *
 * Rows of neighbors are built in two passes over the groups of the search, parallel over groups: the first
 * tests distances and counts, the second fills in. The result depends neither on the number of threads nor on
 * which search was used.
 *
 * Overlap row i holds the neighbors of i, and every j for which there is a node k (internal or ghost, also i
 * or j) with |x_i - x_k| <= R_i and |x_j - x_k| <= R_j. Symmetric, self excluded, ascending. Complete if
 * ghosts reach twice as far as for neighbors (boundary.h, factor 2).
 *
 * The intersection of a pair is the common neighbors of its nodes, and both; optionally only those whose
 * closest point on the segment from i to j lies strictly between the ends. One row a pair, ascending. */
#ifndef KITH_CONNECTIVITY_BUILD_BUILDER_H
#define KITH_CONNECTIVITY_BUILD_BUILDER_H

#include "lib/connectivity/build/packed.h"
#include "lib/connectivity/excluders/excluder.h"
#include "lib/connectivity/pairs.h"

/* The memory of one thread. */
struct kith_worker {
  struct kith_runs runs;
  struct kith_packed near;
  uint64_t *key; /* candidates as node << 32 | slot, three arrays: internal, ghost, spare for merging */
  uint64_t *hit, *idle;       /* [near.words] */
  uint64_t *bitmap, *touched; /* a set of nodes, and which words of it are not 0; both 0 between uses */
  kith_index *found;          /* what a query of the search has found */
  size_t key_capacity, hit_capacity, idle_capacity, bitmap_capacity, touched_capacity, found_capacity;
  size_t candidates;
};

/* Chunks are fixed shares of the groups: their contents do not depend on which thread filled them. */
enum { KITH_ROW_CHUNKS = 256 };
struct kith_builder {
  int threads;
  struct kith_worker *worker; /* [threads] */
  struct kith_words {
    size_t n, capacity;
    size_t expected; /* words that a build is expected to need, by those before it */
    uint64_t *word;  /* in the memory of kith_nodes_work, or `own` if that is too little */
    uint64_t *own;
  } chunk[KITH_ROW_CHUNKS]; /* what the first pass over groups leaves for the second */
  /* For each node the set of nodes whose support holds it, as non-empty 64-bit words of a bitmap over the
   * nodes: their numbers, and their bits. */
  struct kith_rows spans;
  uint64_t *bits;
  size_t bits_capacity;
  kith_index *filled; /* entries of the rows of idle nodes so far */
  size_t filled_capacity;
  struct kith_extent idle[KITH_ROW_CHUNKS]; /* of the idle nodes of each chunk */
};
/* Makes workers for as many threads as may run now. */
kith_status kith_builder_reserve(struct kith_builder *scratch);
void kith_builder_clear(struct kith_builder *scratch);
size_t kith_builder_bytes(const struct kith_builder *scratch);

/* Which sources are neighbors of a target, with a radius R of each node (kith_search::radius).
 *   number           |x_ij| <= a number
 *   gather, scatter, gather_scatter    |x_ij| <= R_i, <= R_j, <= either
 *   boxes            the boxes x -+ R of both share a point: |x_ij| <= R_i + R_j along each axis */
#define KITH_CUTOFF_LIST(X) X(number) X(gather) X(scatter) X(gather_scatter) X(boxes)
enum kith_cutoff {
  KITH_CUTOFF_missing,
#define X(name) KITH_CUTOFF_##name,
  KITH_CUTOFF_LIST(X)
#undef X
};

/* What every builder is given. */
struct kith_build {
  const struct kith_selection *targets, *sources;
  const struct kith_nodes *nodes;   /* of the sources */
  const struct kith_search *search; /* of the sources */
  const struct kith_shifts *shifts; /* images of the sources, which are the targets too; NULL: none */
  struct kith_extent all;           /* of the sources; known if there are images */
  struct kith_excluder *excluders;  /* chain or NULL */
  struct kith_builder *scratch;
  enum kith_cutoff cutoff;
  double number;         /* the cutoff; of boxes the largest R of a source, else unused */
  bool self;             /* a node may be its own neighbor */
  bool unsorted;         /* entries of a row may come in any order */
  bool selected;         /* some nodes are not active */
  const kith_index *row; /* [nodes of the targets] ordinal of a target, -1: none; NULL: nodes are targets */
  kith_index rows;       /* how many rows `row` numbers */
  const kith_index *column; /* [nodes of the sources] ordinal of a source, -1: none; NULL: all are sources */
  kith_status (*when_marked)(void *context); /* connectivity.h; NULL: nothing to do */
  void *context;
};
/* Is every node of a group a target, with its own index as its row? It is in the rows of packages. */
static inline bool kith_build_all_targets(const struct kith_build *build) {
  return build->row == NULL && !build->selected;
}
static inline kith_index kith_build_row(const struct kith_build *build, kith_index i) {
  return build->row != NULL ? build->row[i] : i;
}
static inline bool kith_build_is_target(const struct kith_build *build, kith_index i) {
  return kith_build_row(build, i) >= 0 && (!build->selected || kith_node_active(build->nodes, i));
}
/* Clears the bits of nodes that the chain rejects as partners of i in this phase; returns how many are left.
 * i is displaced by shift `from` itself. */
int kith_build_exclude(const struct kith_build *build, enum kith_phase phase, kith_index i, int from,
                       const struct kith_packed *near, uint64_t *hit);
/* Number of the zero shift. */
static inline int kith_build_zero(const struct kith_build *build) {
  return build->shifts != NULL ? build->shifts->zero : 0;
}
/* Component a of shift s, in the metric of the supports. */
static inline double kith_build_shift(const struct kith_build *build, int s, int a) {
  return build->shifts->by[s][a] / build->nodes->stretch[a];
}
/* Distances to image s of a source are computed by moving the source by s, or the target by -s. In
 * reproducible mode it is the source, as if a ghost were there; else the source for half of the shifts, so
 * that the distances from i to j and from j to i are bitwise equal. */
static inline bool kith_build_moves_source(const struct kith_build *build, int s) {
  return build->nodes->image != NULL || s >= build->shifts->zero;
}
/* |x_j + shift s - x_i|^2. */
static inline double kith_build_distance2(const struct kith_build *build, kith_index i, kith_index j, int s) {
  const double *xi = build->nodes->position->f64 + (size_t)i * NDIM,
               *xj = build->nodes->position->f64 + (size_t)j * NDIM;
  if (build->shifts == NULL) return kith_distance2(xi, xj);
  const double *by = build->shifts->by[s];
  const bool moves = kith_build_moves_source(build, s);
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = moves ? xj[a] + by[a] - xi[a] : xj[a] - (xi[a] - by[a]);
    d2 += d * d;
  }
  return d2;
}

/* Rows of neighbors, ascending unless `unsorted`: of the targets, or if build->row is NULL of internal nodes
 * (rows->n = n_internal), of ghosts too if targets->ghosts; ghosts have none while nodes are idle.
 * *candidates: how many distances were tested. */
kith_status kith_rows_build(struct kith_rows *rows, const struct kith_build *build, size_t *candidates);
/* Overlap rows of the first `n` nodes. Needs the rows of ghosts. (overlap.c) */
kith_status kith_overlap_build(struct kith_rows *overlap, const struct kith_rows *rows, kith_index n,
                               const struct kith_build *build);
/* Which common nodes, of which pairs: as in connectivity.h. */
struct kith_intersection_spec {
  bool on_segment;
  const struct kith_field *obstacles, *barriers;
};
/* UNSUPPORTED beyond 2^31 pairs. (intersection.c) */
kith_status kith_intersection_build(struct kith_rows *intersection, const struct kith_rows *rows,
                                    const struct kith_pairs *pairs, struct kith_intersection_spec spec,
                                    const struct kith_build *build);

#endif
