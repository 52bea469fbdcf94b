/* The force pass except for the pair function: packing, loading, both traversals, sums, barriers, external
 * forces, the work. */
#include "physics/passes/force.h"

/* --- loading --- */

/* All fields of n partners. */
KITH_INLINE void load(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict partner,
                      size_t stride, size_t n, struct kith_scratch *s) {
  const double *restrict packed = pass->package->packed;
  const int n_packed = pass->n_packed;
  kith_index at[KITH_BLOCK];
#pragma omp simd
  for (size_t k = 0; k < n; ++k) at[k] = partner[k * stride] * n_packed;
  for (int m = 0; m < n_packed; ++m) {
    double *restrict lane = kith_lane(s, m);
#pragma omp simd
    for (size_t k = 0; k < n; ++k) lane[k] = packed[at[k] + m];
  }
  if (pass->barrier == NULL) return;
  const double *self = packed + (size_t)i * n_packed;
  for (size_t k = 0; k < n; ++k) {
    if (!pass->barrier[partner[k * stride]]) continue;
    double along = 0, r2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double x = self[KITH_PACKED_X + a] - kith_lane(s, KITH_PACKED_X + a)[k];
      along += x * self[KITH_PACKED_V + a];
      r2 += x * x;
    }
    for (int a = 0; a < NDIM; ++a)
      kith_lane(s, KITH_PACKED_V + a)[k] =
          self[KITH_PACKED_V + a] -
          2 * along / r2 * (self[KITH_PACKED_X + a] - kith_lane(s, KITH_PACKED_X + a)[k]);
    for (int m = KITH_PACKED_OWN; m < n_packed; ++m) kith_lane(s, m)[k] = self[m];
  }
}

/* The values of the edge of pair p, from i to partner k of the block. */
KITH_INLINE void load_edge(const struct kith_force_pass *pass, size_t p, bool starts, size_t k,
                           struct kith_scratch *s) {
  const size_t edges = (size_t)pass->edges;
  for (size_t m = 0; m < edges; ++m) {
    const double value = pass->edge[p * edges + m];
    kith_lane(s, pass->n_packed + (int)m)[k] = starts ? value : -value;
  }
}

/* Differences v_j - v_i of a vector field. A wall at rest does no work, so i gets all of
 * f . v_i: with the share 1/2 that is v_j = -v_i. */
KITH_INLINE void velocity_differences(const struct kith_force_pass *pass, const double *restrict v,
                                      kith_index i, const kith_index *restrict row, size_t n, double *first) {
  for (int a = 0; a < NDIM; ++a) {
    const double vi = v[(size_t)i * NDIM + a];
    double *restrict lane = first + (size_t)a * KITH_STRIDE;
#pragma omp simd
    for (size_t k = 0; k < n; ++k) lane[k] = v[row[k] * NDIM + a] - vi;
    for (size_t k = 0; pass->barrier != NULL && k < n; ++k)
      if (pass->barrier[row[k]]) lane[k] = -2 * vi;
  }
}

/* A barrier: half of the work, no heat; one of volume V counts as V / V_i nodes like i, unless the pair
 * function accounts for that. */
KITH_INLINE void walls(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict row,
                       size_t n, double *restrict out) {
  const double *restrict support = pass->package->hydro->nodes->support->f64;
  for (size_t k = 0; pass->barrier != NULL && k < n; ++k) {
    if (!pass->barrier[row[k]]) continue;
    const double count = pass->walls_known ? 1 : kith_pow_dim(support[row[k]] / support[i]);
    for (int a = 0; a < NDIM; ++a) out[(size_t)a * KITH_STRIDE + k] *= count;
    out[KITH_ENERGY_SHARE * KITH_STRIDE + k] = 0.5;
    out[KITH_EXCHANGE * KITH_STRIDE + k] = 0;
  }
}

/* n entries of row i from the pairwise field; the end at which a pair does not start gets -f, 1 - e, -g. */
KITH_INLINE void recall(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                        double *restrict out) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const uint32_t *restrict pair = pairs->of_row + first;
  const kith_index *restrict row = pass->connectivity->rows.node + first;
  const double *restrict value = pass->package->pair.value;
  for (size_t k = 0; k < n; ++k) {
    const double *v = value + (size_t)pair[k] * KITH_PAIR_VALUES;
    const bool starts = kith_pair_starts(pass->connectivity, pair[k], i, row[k]);
    for (int a = 0; a < NDIM; ++a) out[(size_t)a * KITH_STRIDE + k] = starts ? v[a] : -v[a];
    out[KITH_ENERGY_SHARE * KITH_STRIDE + k] = starts ? v[KITH_ENERGY_SHARE] : 1 - v[KITH_ENERGY_SHARE];
    out[KITH_EXCHANGE * KITH_STRIDE + k] = starts ? v[KITH_EXCHANGE] : -v[KITH_EXCHANGE];
    out[KITH_SIGNAL * KITH_STRIDE + k] = v[KITH_SIGNAL];
  }
}

/* --- summing --- */

struct sums {
  double force[NDIM], rate, slope, signal;
};

KITH_INLINE double sum_work(size_t n, const double *restrict out,
                            const double *restrict velocity_difference) {
  const double *restrict share = out + KITH_ENERGY_SHARE * KITH_STRIDE;
  double work = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double *restrict f = out + (size_t)a * KITH_STRIDE, *restrict v = velocity_difference +
                                                                            (size_t)a * KITH_STRIDE;
#pragma omp simd reduction(+ : work)
    for (size_t k = 0; k < n; ++k) work += share[k] * f[k] * v[k];
  }
  return work;
}

KITH_INLINE double sum_lane(size_t n, const double *restrict lane) {
  double sum = 0;
#pragma omp simd reduction(+ : sum)
  for (size_t k = 0; k < n; ++k) sum += lane[k];
  return sum;
}

/* The block of n entries from `first` on of row i. */
KITH_INLINE void sum_block(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                           double *restrict out, struct sums *sums) {
  const struct kith_package *package = pass->package;
  const kith_index *restrict row = pass->connectivity->rows.node + first;
  double *velocity_difference = out + (size_t)KITH_VELOCITY_DIFFERENCE * KITH_STRIDE,
         *acceleration_difference = out + (size_t)KITH_ACCELERATION_DIFFERENCE * KITH_STRIDE;
  walls(pass, i, row, n, out);
  if (pass->work) {
    velocity_differences(pass, pass->kick->velocity_base->f64, i, row, n, velocity_difference);
    velocity_differences(pass, package->hydro->acceleration->f64, i, row, n, acceleration_difference);
    sums->rate += sum_work(n, out, velocity_difference) + sum_lane(n, out + KITH_EXCHANGE * KITH_STRIDE);
    sums->slope += sum_work(n, out, acceleration_difference);
    return;
  }
  const double *restrict signal = out + KITH_SIGNAL * KITH_STRIDE;
  double fastest = sums->signal;
#pragma omp simd reduction(max : fastest)
  for (size_t k = 0; k < n; ++k) fastest = KITH_MAX(fastest, signal[k]);
  sums->signal = fastest;
  for (int a = 0; a < NDIM; ++a) sums->force[a] += sum_lane(n, out + (size_t)a * KITH_STRIDE);
  if (package->compatible) return;
  velocity_differences(pass, package->hydro->velocity->f64, i, row, n, velocity_difference);
  sums->rate += sum_work(n, out, velocity_difference) + sum_lane(n, out + KITH_EXCHANGE * KITH_STRIDE);
}

KITH_INLINE void store(const struct kith_force_pass *pass, kith_index i, const struct sums *sums) {
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

/* --- chunks --- */

/* Traversal `pairs`, first half: the pairs that start at a node of the chunk, into the pairwise field. */
KITH_HOT static void pairs_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const double *restrict out = kith_lane(s, pass->n_packed + pass->edges);
  for (kith_index i = begin; i < end; ++i)
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; p += KITH_BLOCK) {
      const size_t n = KITH_MIN(pairs->first[i + 1] - p, (size_t)KITH_BLOCK);
      load(pass, i, &pairs->node[p][1], 2, n, s);
      for (size_t k = 0; pass->edges > 0 && k < n; ++k) load_edge(pass, p + k, true, k, s);
      pass->evaluate(pass, i, n, s);
      double *restrict value = pass->package->pair.value + p * KITH_PAIR_VALUES;
      for (size_t k = 0; k < n; ++k)
        for (int m = 0; m < KITH_PAIR_VALUES; ++m)
          value[k * KITH_PAIR_VALUES + m] = out[(size_t)m * KITH_STRIDE + k];
    }
}

/* The values of the n pairs from entry `first` of row i on, evaluated anew. */
KITH_INLINE void gather(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                        struct kith_scratch *s) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const kith_index *restrict row = pass->connectivity->rows.node + first;
  load(pass, i, row, 1, n, s);
  for (size_t k = 0; pass->edges > 0 && k < n; ++k) {
    const size_t p = pairs->of_row[first + k];
    load_edge(pass, p, kith_pair_starts(pass->connectivity, p, i, row[k]), k, s);
  }
  pass->evaluate(pass, i, n, s);
}

/* The sums of each node of the chunk: second half of `pairs`, or all of `gather`. */
KITH_HOT static void nodes_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const bool kept = pass->package->traversal == KITH_TRAVERSE_PAIRS;
  double *out = kith_lane(s, pass->n_packed + pass->edges);
  for (kith_index i = begin; i < end; ++i) {
    struct sums sums = {.signal = pass->package->hydro->sound_speed->f64[i]};
    for (size_t first = rows->first[i]; first < rows->first[i + 1]; first += KITH_BLOCK) {
      const size_t n = KITH_MIN(rows->first[i + 1] - first, (size_t)KITH_BLOCK);
      if (kept)
        recall(pass, i, first, n, out);
      else
        gather(pass, i, first, n, s);
      sum_block(pass, i, first, n, out, &sums);
    }
    store(pass, i, &sums);
  }
}

/* --- driving --- */

/* Packs particles begin .. end - 1. */
static void pack(void *context, kith_index begin, kith_index end) {
  const struct kith_force_pass *pass = context;
  struct kith_package *package = pass->package;
  kith_profile_begin(package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = begin; i < end; ++i)
    pass->pack(package, i, package->packed + (size_t)i * (size_t)pass->n_packed);
  kith_profile_end(package->profile);
}

kith_status kith_force(struct kith_force_pass *pass) {
  struct kith_package *package = pass->package;
  const struct kith_hydro *hydro = package->hydro;
  const struct kith_nodes *nodes = hydro->nodes;
  const kith_index all = kith_nodes_count(nodes), internal = nodes->n_internal;
  const struct kith_node_sweep pairs = {.stage = "pairs",
                                        .rows = &pass->connectivity->rows,
                                        .chunk = pairs_chunk,
                                        .context = pass,
                                        .lanes = pass->n_packed + pass->edges + KITH_FORCE_LANES,
                                        .width = KITH_STRIDE,
                                        .arrived = pack};
  struct kith_node_sweep sums = pairs;
  sums.stage = "force", sums.chunk = nodes_chunk;
  pass->barrier = package->barrier != NULL ? package->barrier->u8 : NULL;
  pass->work = false;
  if (all > INT32_MAX / pass->n_packed) /* so that loads of several nodes become one gather */
    KITH_FAIL(UNSUPPORTED,
              "%d nodes and ghosts in one process: packed particles are addressed with 32 bits, at most %d",
              all, INT32_MAX / pass->n_packed);
  KITH_TRY(kith_reserve(&package->packed, &package->packed_capacity, (size_t)all * (size_t)pass->n_packed,
                        sizeof(double)));
  pack(pass, 0, kith_halo_pending(hydro->halo) ? kith_nodes_first_remote(nodes) : all);
  const bool kept = package->traversal == KITH_TRAVERSE_PAIRS;
  if (kept) {
    KITH_TRY(kith_pairwise_prepare(&package->pair, pass->connectivity, KITH_PAIR_VALUES));
    KITH_TRY(kith_package_sweep(package, &pairs, NULL));
    /* Canonical pairs that start at ghosts, whose values have arrived by now. */
    KITH_TRY(
        kith_package_sweep_ghosts(package, &pairs, internal, pass->connectivity->pairs.starts - internal));
  }
  KITH_TRY(kith_package_sweep(package, &sums, NULL));
  if (kith_external_force_acts(&hydro->external_force))
    kith_external_force_acceleration(&hydro->external_force, internal, nodes->position->f64,
                                     hydro->acceleration->f64);
  if (!package->compatible) return KITH_OK;
  if (kept) KITH_TRY(kith_pairwise_fresh(&package->pair, pass->connectivity));
  kith_package_start_refresh(package, 2,
                             (struct kith_field *[]){pass->kick->velocity_base, hydro->acceleration});
  pass->work = true;
  sums.stage = "work", sums.arrived = NULL;
  return kith_package_sweep(package, &sums, NULL);
}
