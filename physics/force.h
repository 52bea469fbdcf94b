/* force.h - the skeleton of every package: records of nodes, rows of partners in lanes, and the pair force, written once.
 *
 * A package writes one function of a pair and hands it to kith_force_pairs_chunk and kith_force_nodes_chunk, once per kernel;
 * everything here is inlined into those, so that the function is compiled into the loops. It reads
 *     i[m]      member m of the record of i
 *     J(m)      member m of the record of j, its partner; beyond the record: members of the edge from i to j, if there are any
 * and gives, through OUT(m),
 *     KITH_FORCE + a    f_a: the force on i; j gets -f
 *     KITH_SHARE        e: the part of i in the work f . (v_j - v_i) of the pair; j gets 1 - e
 *     KITH_EXCHANGE     g: heat that i gets from j besides; j gets -g
 *     KITH_SIGNAL       the signal speed of the pair
 * Exchanging i and j must give -f, 1 - e, -g to round-off. Then
 *     m_i dv_i/dt = sum_j f,   m_i du_i/dt = sum_j e f . (v_j - v_i) + g
 * conserve momentum and energy whatever the forces are; see package.h for both forms of the energy.
 *
 * Traversal `pairs` evaluates each pair once, keeps KITH_PAIR_VALUES doubles, and each node then sums its row; `gather` evaluates the
 * whole row of each node. Both sum in row order, so no result depends on the number of threads. Canonical pairs (connectivity.h) may start at
 * a ghost, whose record is as good as that of a node.
 *
 * A barrier node (package.h) is a wall to whoever looks at it: it answers i with i's own state, the velocity mirrored about the line that
 * joins them; it does no work and conducts no heat. */
#ifndef KITH_PHYSICS_FORCE_H
#define KITH_PHYSICS_FORCE_H

#include "lib/connectivity/traversal.h"
#include "physics/package.h"

/* The first members of every record. */
enum { KITH_RECORD_X = 0, KITH_RECORD_V = NDIM, KITH_RECORD_OWN = 2 * NDIM };
enum { KITH_FORCE, KITH_SHARE = NDIM, KITH_EXCHANGE, KITH_SIGNAL, KITH_PAIR_VALUES };

/* Lanes: rows are worked on in blocks; a lane holds one member for all partners of a block. The stride is no power of two: lanes would
 * fall onto each other in the cache. */
enum { KITH_BLOCK = 128, KITH_STRIDE = KITH_BLOCK + 8, KITH_MOST_MEMBERS = 48 };
/* Lanes behind those of members and edge: what a pair gives, differences of velocity and of acceleration. */
enum { KITH_JUMP = KITH_PAIR_VALUES, KITH_JERK = KITH_JUMP + NDIM, KITH_FORCE_LANES = KITH_JERK + NDIM };

KITH_INLINE double *kith_lane(const struct kith_scratch *s, int k) {
  return s->lane + (size_t)k * KITH_STRIDE;
}

#define J(m) j[(m)*KITH_STRIDE]
#define OUT(m) out[(m)*KITH_STRIDE]
typedef void kith_pair_function(enum kith_kernel kernel, const void *constants, const double *restrict i,
                                const double *restrict j, double *restrict out);

/* Writes the record of node or ghost i. */
typedef void kith_force_record(const struct kith_package *package, kith_index i, double *restrict record);

/* One sweep over all pairs: what its chunks read. */
struct kith_force_pass {
  struct kith_package *package;
  kith_force_record *pack;
  const struct kith_connectivity *connectivity;
  const struct kith_rows *rows; /* who interacts; traversal `pairs`: the rows of the connectivity */
  const void *constants;        /* handed to the pair function */
  const double *edge; /* [entries of rows][edges], NULL without edge members; traversal `gather` only */
  bool walls_known;   /* what a pair gives knows how large a wall is */
  /* The rest is filled by kith_force. */
  int members;
  const uint8_t *barrier; /* [nodes] or NULL */
  bool work;              /* sums rate and slope of the compatible energy instead of accelerations */
};

/* The first members of the record of node i. */
static inline void kith_force_pack(const struct kith_hydro *hydro, kith_index i, double *restrict record) {
  for (int a = 0; a < NDIM; ++a) {
    record[KITH_RECORD_X + a] = hydro->nodes->position->f64[(size_t)i * NDIM + a];
    record[KITH_RECORD_V + a] = hydro->velocity->f64[(size_t)i * NDIM + a];
  }
}

/* --- loading --- */

/* Members 0 .. members - 1 of n partners, and of the edges to them. */
KITH_INLINE void kith_force_load(const struct kith_force_pass *pass, int members, int edges, kith_index i,
                                 const kith_index *restrict partner, size_t stride, size_t n,
                                 const double *restrict edge, struct kith_scratch *s) {
  const double *restrict record = pass->package->record;
  kith_index at[KITH_BLOCK];
#pragma omp simd
  for (size_t k = 0; k < n; ++k) at[k] = partner[k * stride] * members;
  for (int m = 0; m < members; ++m) {
    double *restrict lane = kith_lane(s, m);
#pragma omp simd
    for (size_t k = 0; k < n; ++k) lane[k] = record[at[k] + m];
  }
  for (int m = 0; m < edges; ++m) {
    double *restrict lane = kith_lane(s, members + m);
    for (size_t k = 0; k < n; ++k) lane[k] = edge[k * (size_t)edges + (size_t)m];
  }
  if (pass->barrier == NULL) return;
  const double *self = record + (size_t)i * members;
  for (size_t k = 0; k < n; ++k) {
    if (!pass->barrier[partner[k * stride]]) continue;
    double along = 0, r2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double x = self[KITH_RECORD_X + a] - kith_lane(s, KITH_RECORD_X + a)[k];
      along += x * self[KITH_RECORD_V + a];
      r2 += x * x;
    }
    for (int a = 0; a < NDIM; ++a)
      kith_lane(s, KITH_RECORD_V + a)[k] =
          self[KITH_RECORD_V + a] -
          2 * along / r2 * (self[KITH_RECORD_X + a] - kith_lane(s, KITH_RECORD_X + a)[k]);
    for (int m = KITH_RECORD_OWN; m < members; ++m) kith_lane(s, m)[k] = self[m];
  }
}

/* Differences v_j - v_i of a vector field. A wall at rest takes all of f . v_i: with half the work, v_j = -v_i. */
KITH_INLINE void kith_force_jumps(const struct kith_force_pass *pass, const double *restrict v, kith_index i,
                                  const kith_index *restrict row, size_t n, double *first) {
  for (int a = 0; a < NDIM; ++a) {
    const double vi = v[(size_t)i * NDIM + a];
    double *restrict lane = first + (size_t)a * KITH_STRIDE;
#pragma omp simd
    for (size_t k = 0; k < n; ++k) lane[k] = v[row[k] * NDIM + a] - vi;
    for (size_t k = 0; pass->barrier != NULL && k < n; ++k)
      if (pass->barrier[row[k]]) lane[k] = -2 * vi;
  }
}

/* --- evaluating --- */

/* n <= KITH_BLOCK pairs of i, into the lanes behind members and edges. In canonical order whole vectors are evaluated, with old numbers behind
 * the last pair: the compiler may fuse other products and sums in the rest of a loop than in its body, and what a pair gives must not
 * depend on its place, which depends on the ranks. */
KITH_INLINE void kith_force_evaluate(kith_pair_function *pair, enum kith_kernel kernel, int members,
                                     int edges, const struct kith_force_pass *pass, kith_index i, size_t n,
                                     struct kith_scratch *s) {
  const double *restrict self = pass->package->record + (size_t)i * members, *restrict j = s->lane;
  double *restrict out = kith_lane(s, members + edges);
  const size_t lanes = pass->connectivity->canonical ? (n + 7) / 8 * 8 : n;
#pragma omp simd
  for (size_t k = 0; k < lanes; ++k) pair(kernel, pass->constants, self, j + k, out + k);
  s->count[0] += n;
}

/* A wall: half of the work, no heat; and of volume V it counts as V / V_i nodes like i, unless walls are known. */
KITH_INLINE void kith_force_walls(const struct kith_force_pass *pass, kith_index i,
                                  const kith_index *restrict row, size_t n, double *restrict out) {
  const double *restrict support = pass->package->hydro->nodes->support->f64;
  for (size_t k = 0; pass->barrier != NULL && k < n; ++k) {
    if (!pass->barrier[row[k]]) continue;
    const double count = pass->walls_known ? 1 : kith_pow_dim(support[row[k]] / support[i]);
    for (int a = 0; a < NDIM; ++a) out[(size_t)a * KITH_STRIDE + k] *= count;
    out[KITH_SHARE * KITH_STRIDE + k] = 0.5;
    out[KITH_EXCHANGE * KITH_STRIDE + k] = 0;
  }
}

/* n entries of row i from the pairwise field: the end that a pair does not start at gets the rest of everything. */
KITH_INLINE void kith_force_take(const struct kith_force_pass *pass, bool canonical, kith_index i,
                                 size_t first, size_t n, double *restrict out) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const uint32_t *restrict pair = pairs->of_row + first;
  const kith_index *restrict row = pass->rows->node + first;
  const double *restrict value = pass->package->pair.value;
  for (size_t k = 0; k < n; ++k) {
    const double *v = value + (size_t)pair[k] * KITH_PAIR_VALUES;
    const bool starts = canonical ? pairs->node[pair[k]][0] == i : row[k] > i;
    for (int a = 0; a < NDIM; ++a) out[(size_t)a * KITH_STRIDE + k] = starts ? v[a] : -v[a];
    out[KITH_SHARE * KITH_STRIDE + k] = starts ? v[KITH_SHARE] : 1 - v[KITH_SHARE];
    out[KITH_EXCHANGE * KITH_STRIDE + k] = starts ? v[KITH_EXCHANGE] : -v[KITH_EXCHANGE];
    out[KITH_SIGNAL * KITH_STRIDE + k] = v[KITH_SIGNAL];
  }
}

KITH_INLINE void kith_force_recall(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                                   double *restrict out) {
  if (pass->connectivity->pairs.canonical)
    kith_force_take(pass, true, i, first, n, out);
  else
    kith_force_take(pass, false, i, first, n, out);
}

/* --- summing --- */

struct kith_force_sums {
  double force[NDIM], rate, slope, signal;
};

KITH_INLINE double kith_force_sum_work(size_t n, const double *restrict out, const double *restrict jump) {
  const double *restrict share = out + KITH_SHARE * KITH_STRIDE;
  double work = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double *restrict f = out + (size_t)a * KITH_STRIDE, *restrict v = jump + (size_t)a * KITH_STRIDE;
#pragma omp simd reduction(+ : work)
    for (size_t k = 0; k < n; ++k) work += share[k] * f[k] * v[k];
  }
  return work;
}

KITH_INLINE double kith_force_sum(size_t n, const double *restrict lane) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (size_t k = 0; k < n; ++k) sum += lane[k];
  return sum;
}

/* The block of n entries from `first` on of row i. */
KITH_INLINE void kith_force_sum_block(const struct kith_force_pass *pass, kith_index i, size_t first,
                                      size_t n, double *restrict out, struct kith_force_sums *sums) {
  const struct kith_package *package = pass->package;
  const kith_index *restrict row = pass->rows->node + first;
  double *jump = out + (size_t)KITH_JUMP * KITH_STRIDE, *jerk = out + (size_t)KITH_JERK * KITH_STRIDE;
  kith_force_walls(pass, i, row, n, out);
  if (pass->work) {
    kith_force_jumps(pass, package->velocity_base->f64, i, row, n, jump);
    kith_force_jumps(pass, package->hydro->acceleration->f64, i, row, n, jerk);
    sums->rate += kith_force_sum_work(n, out, jump) + kith_force_sum(n, out + KITH_EXCHANGE * KITH_STRIDE);
    sums->slope += kith_force_sum_work(n, out, jerk);
    return;
  }
  const double *restrict signal = out + KITH_SIGNAL * KITH_STRIDE;
  double fastest = sums->signal;
#pragma omp simd reduction(max : fastest)
  for (size_t k = 0; k < n; ++k) fastest = KITH_MAX(fastest, signal[k]);
  sums->signal = fastest;
  for (int a = 0; a < NDIM; ++a) sums->force[a] += kith_force_sum(n, out + (size_t)a * KITH_STRIDE);
  if (package->compatible) return;
  kith_force_jumps(pass, package->hydro->velocity->f64, i, row, n, jump);
  sums->rate += kith_force_sum_work(n, out, jump) + kith_force_sum(n, out + KITH_EXCHANGE * KITH_STRIDE);
}

KITH_INLINE void kith_force_store(const struct kith_force_pass *pass, kith_index i,
                                  const struct kith_force_sums *sums) {
  struct kith_package *package = pass->package;
  const double mass = package->hydro->mass->f64[i];
  if (pass->work || !package->compatible) package->hydro->energy_rate->f64[i] = sums->rate / mass;
  if (pass->work) {
    package->energy_slope->f64[i] = sums->slope / mass;
    return;
  }
  for (int a = 0; a < NDIM; ++a)
    package->hydro->acceleration->f64[(size_t)i * NDIM + a] = sums->force[a] / mass;
  package->signal->f64[i] = sums->signal;
}

/* --- chunks: what a package instantiates --- */

/* Traversal `pairs`, first half: the pairs that start at a node of the chunk, into the pairwise field. */
KITH_INLINE void kith_force_pairs_chunk(kith_pair_function *pair, enum kith_kernel kernel, int members,
                                        const struct kith_force_pass *pass, kith_index begin, kith_index end,
                                        struct kith_scratch *s) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const double *restrict out = kith_lane(s, members);
  for (kith_index i = begin; i < end; ++i)
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; p += KITH_BLOCK) {
      const size_t n = KITH_MIN(pairs->first[i + 1] - p, (size_t)KITH_BLOCK);
      kith_force_load(pass, members, 0, i, &pairs->node[p][1], 2, n, NULL, s);
      kith_force_evaluate(pair, kernel, members, 0, pass, i, n, s);
      double *restrict value = pass->package->pair.value + p * KITH_PAIR_VALUES;
      for (size_t k = 0; k < n; ++k)
        for (int m = 0; m < KITH_PAIR_VALUES; ++m)
          value[k * KITH_PAIR_VALUES + m] = out[(size_t)m * KITH_STRIDE + k];
    }
}

/* The sums of each node of the chunk: second half of `pairs`, or all of `gather`. */
KITH_INLINE void kith_force_nodes_chunk(kith_pair_function *pair, enum kith_kernel kernel, int members,
                                        int edges, const struct kith_force_pass *pass, kith_index begin,
                                        kith_index end, struct kith_scratch *s) {
  const struct kith_rows *rows = pass->rows;
  const bool recall = pass->package->traversal == KITH_TRAVERSE_PAIRS;
  double *out = kith_lane(s, members + edges);
  for (kith_index i = begin; i < end; ++i) {
    struct kith_force_sums sums = {.signal = pass->package->hydro->sound_speed->f64[i]};
    for (size_t first = rows->first[i]; first < rows->first[i + 1]; first += KITH_BLOCK) {
      const size_t n = KITH_MIN(rows->first[i + 1] - first, (size_t)KITH_BLOCK);
      if (recall) {
        kith_force_recall(pass, i, first, n, out);
      } else {
        const double *edge = edges > 0 ? pass->edge + first * (size_t)edges : NULL;
        kith_force_load(pass, members, edges, i, rows->node + first, 1, n, edge, s);
        kith_force_evaluate(pair, kernel, members, edges, pass, i, n, s);
      }
      kith_force_sum_block(pass, i, first, n, out, &sums);
    }
    kith_force_store(pass, i, &sums);
  }
}

/* Both traversals of the function pair_FORM with one kernel: pairs_FORM_NAME and nodes_FORM_NAME. */
#define KITH_FORCE_CHUNKS(form, name, members)                                                \
  KITH_HOT static void pairs_##form##_##name(void *pass, kith_index begin, kith_index end,    \
                                             struct kith_scratch *s) {                        \
    kith_force_pairs_chunk(pair_##form, KITH_KERNEL_##name, members, pass, begin, end, s);    \
  }                                                                                           \
  KITH_HOT static void nodes_##form##_##name(void *pass, kith_index begin, kith_index end,    \
                                             struct kith_scratch *s) {                        \
    kith_force_nodes_chunk(pair_##form, KITH_KERNEL_##name, members, 0, pass, begin, end, s); \
  }

/* --- driving: in force.c --- */

/* Makes the records and runs the passes: forces (accelerations, signal speeds, thermal energy rates), then, if the energy is compatible, ghosts and
 * the work. pairs, nodes: one chunk per kernel (pairs: NULL if the package only gathers). members, edges: as instantiated. UNSUPPORTED if
 * there are 2^31 doubles of records. */
kith_status kith_force(struct kith_force_pass *pass, const kith_chunk_pass *pairs,
                       const kith_chunk_pass *nodes, int members, int edges);

#endif
