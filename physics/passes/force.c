/* The force pass except for the pair function: packing, loading, both traversals, sums, barriers, external
 * forces. */
#include "physics/passes/force.h"

#include <math.h>
#include <string.h>

/* --- loading --- */

/* The packed particle of node or ghost i: whole groups of lanes. */
KITH_INLINE double *packed_particle(const struct kith_force_pass *pass, kith_index i) {
  return pass->packed + (size_t)i * kith_lanes_padded((size_t)pass->n_packed);
}

void kith_force_shift(const struct kith_force_pass *pass, const uint16_t *shift, size_t n,
                      struct kith_scratch *s) {
  const struct kith_shifts *shifts = &pass->package->hydro->nodes->shifts;
  for (size_t k = 0; k < n; ++k)
    for (int a = 0; a < NDIM && shift[k] != shifts->zero; ++a)
      kith_lane(s, KITH_PACKED_X + a)[k] += shifts->by[shift[k]][a];
}

void kith_force_mirror(const struct kith_force_pass *pass, kith_index i, const kith_index *partner, size_t n,
                       struct kith_scratch *s) {
  const double *self = packed_particle(pass, i);
  for (size_t k = 0; k < n; ++k) {
    if (!pass->barrier[partner[k]]) continue;
    double along = 0, r2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double x = self[KITH_PACKED_X + a] - kith_lane(s, KITH_PACKED_X + a)[k];
      along += x * self[KITH_PACKED_V + a];
      r2 += x * x;
    }
    for (int a = 0; a < NDIM; ++a)
      kith_lane(s, KITH_PACKED_V + a)[k] =
          pass->no_slip ? -self[KITH_PACKED_V + a]
                        : self[KITH_PACKED_V + a] -
                              2 * along / r2 * (self[KITH_PACKED_X + a] - kith_lane(s, KITH_PACKED_X + a)[k]);
    for (int m = KITH_PACKED_OWN; m < pass->n_packed; ++m) kith_lane(s, m)[k] = self[m];
  }
}

/* The values of the edge of pair p, from i to partner k of the block. */
KITH_INLINE void load_edge(const struct kith_force_pass *pass, size_t p, bool starts, size_t k,
                           struct kith_scratch *s) {
  const size_t edges = (size_t)pass->edges;
  for (size_t m = 0; m < edges; ++m) {
    const double value = pass->edge->value[p * edges + m];
    kith_force_edges(pass, s)[m * KITH_STRIDE + k] = starts ? value : -value;
  }
}

/* A barrier: a wall at rest does no work, so i gets all of -f . v_i, and no heat besides; one of volume V
 * counts as V / V_i nodes like i, unless the pair function accounts for that. */
KITH_INLINE void walls(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict row,
                       size_t n, double *restrict out) {
  const double *restrict support = pass->package->hydro->nodes->support->f64,
                         *restrict v = pass->package->hydro->velocity->f64 + (size_t)i * NDIM;
  for (size_t k = 0; pass->barrier != NULL && k < n; ++k) {
    if (!pass->barrier[row[k]]) continue;
    const double count = pass->walls_known ? 1 : kith_pow_dim(support[row[k]] / support[i]);
    double heat = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double f = out[(size_t)a * KITH_STRIDE + k] *= count;
      heat -= f * v[a];
    }
    out[KITH_HEAT * KITH_STRIDE + k] = heat;
  }
}

/* n entries of row i from the pairwise field; the end at which a pair does not start gets -f and q_j. */
KITH_INLINE void recall(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                        double *restrict out) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const uint32_t *restrict pair = pairs->of_row + first;
  const double *restrict value = pass->pair->value;
  const size_t known = pass->connectivity->rows.first[pass->package->hydro->nodes->n_internal] - first;
  for (size_t k = 0; k < n; ++k) {
    if (k + KITH_AHEAD < known) __builtin_prefetch(value + (size_t)pair[k + KITH_AHEAD] * KITH_PAIR_VALUES);
    const double *v = value + (size_t)pair[k] * KITH_PAIR_VALUES;
    const bool starts = kith_pair_starts(pass->connectivity, i, first + k);
    for (int a = 0; a < NDIM; ++a) out[(size_t)a * KITH_STRIDE + k] = starts ? v[a] : -v[a];
    out[KITH_HEAT * KITH_STRIDE + k] = v[starts ? KITH_HEAT : KITH_PARTNER_HEAT];
    out[KITH_SIGNAL * KITH_STRIDE + k] = v[KITH_SIGNAL];
  }
}

/* --- summing --- */

struct sums {
  double force[NDIM], heat, signal;
  double impulse[NDIM + 1], opening[NDIM + 1]; /* with block steps: force, then heat */
  double outside[NDIM + 1];                    /* by what is no gas: force, then power */
  double outside_opening[NDIM + 1];            /* with block steps: the opening part of that */
};

/* With block steps: the weights of the n pairs from entry `first` on of row i, (1) of block_steps.h, as parts
 * that close the last interval of a pair and open its next. */
KITH_INLINE void weigh_block(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                             kith_lanes *restrict closing, kith_lanes *restrict opening) {
  const struct kith_block_steps *b = pass->kick->blocks;
  const kith_index *restrict row = pass->connectivity->rows.node + first;
  const double t = b->last->f64[i], d = b->step->f64[i], after = b->next->f64[i], now = b->now;
  kith_lanes last[KITH_BLOCK / KITH_LANES];
  for (size_t k = 0; k < n; k += KITH_LANES) {
    kith_index room[KITH_LANES];
    const kith_index *four = kith_lanes_entries(row, k, n, room);
    const double *from[KITH_LANES];
    kith_lanes ticks[KITH_LANES];
    for (size_t l = 0; l < KITH_LANES; ++l) from[l] = pass->ticks + (size_t)four[l] * KITH_LANES;
    kith_lanes_transpose(from, ticks);
    last[k / KITH_LANES] = ticks[0];
    closing[k / KITH_LANES] = ticks[1], opening[k / KITH_LANES] = ticks[2];
  }
  double *restrict lasts = (double *)last, *restrict closes = (double *)closing,
                   *restrict opens = (double *)opening;
#pragma omp simd
  for (size_t k = 0; k < kith_lanes_padded(n); ++k) {
    closes[k] = now - KITH_MAX(t, lasts[k]) - 0.5 * KITH_MIN(d, closes[k]);
    opens[k] = 0.5 * KITH_MIN(after, opens[k]);
  }
}

/* Adds forces and heats of n entries, whole lanes, and with block steps the weighted ones. */
KITH_INLINE void add_block(const struct kith_force_pass *pass, bool weighs, size_t n,
                           const double *restrict out, const kith_lanes *restrict closing,
                           const kith_lanes *restrict opening, struct sums *sums) {
  kith_lanes force[NDIM + 1] = {{0}}, ended[NDIM + 1] = {{0}}, begun[NDIM + 1] = {{0}};
  for (size_t k = 0; k < n; k += KITH_LANES)
    for (int a = 0; a <= NDIM; ++a) {
      const kith_lanes value = *(const kith_lanes *)(out + (size_t)(KITH_FORCE + a) * KITH_STRIDE + k);
      force[a] += value;
      if (weighs) ended[a] += closing[k / KITH_LANES] * value;
      if (weighs) begun[a] += opening[k / KITH_LANES] * value;
    }
  for (int a = 0; a < NDIM; ++a) sums->force[a] += kith_lanes_total(&force[a]);
  sums->heat += kith_lanes_total(&force[NDIM]);
  for (int a = 0; weighs && a <= NDIM; ++a) {
    sums->impulse[a] += pass->kick->blocks->tick * kith_lanes_total(&ended[a]);
    sums->opening[a] += kith_lanes_total(&begun[a]) / KITH_TICKS;
  }
}

/* Part of force and heat of n entries passes; signal speeds stay. */
KITH_INLINE void couple(const struct kith_force_pass *pass, size_t first, size_t n, double *restrict out) {
  for (size_t k = 0; pass->f_couple != NULL && k < n; ++k) {
    const double f = pass->f_couple[pass->connectivity->pairs.of_row[first + k]];
    for (int m = 0; m <= KITH_HEAT; ++m) out[(size_t)m * KITH_STRIDE + k] *= f;
  }
}

/* What partners that are no gas give to i: hydro.h. closing, opening: the weights of the pairs; NULL: 1, and
 * nothing opens. */
KITH_INLINE void add_outside(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict row,
                             size_t n, const double *restrict out, const double *restrict closing,
                             const double *restrict opening, struct sums *sums) {
  const double *restrict v = pass->package->hydro->velocity->f64 + (size_t)i * NDIM;
  for (size_t k = 0; k < n; ++k) {
    if (pass->flag[row[k]] == KITH_GAS) continue;
    double given[NDIM + 1] = {[NDIM] = out[KITH_HEAT * KITH_STRIDE + k]};
    for (int a = 0; a < NDIM; ++a) {
      given[a] = out[(size_t)(KITH_FORCE + a) * KITH_STRIDE + k];
      given[NDIM] += given[a] * v[a];
    }
    for (int a = 0; a <= NDIM; ++a) {
      sums->outside[a] += (closing != NULL ? closing[k] : 1) * given[a];
      sums->outside_opening[a] += (opening != NULL ? opening[k] : 0) * given[a];
    }
  }
}

/* The block of n entries from `first` on of row i. */
KITH_INLINE void sum_block(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                           double *restrict out, struct sums *sums) {
  const kith_index *row = pass->connectivity->rows.node + first;
  couple(pass, first, n, out);
  walls(pass, i, row, n, out);
  const double *restrict signal = out + KITH_SIGNAL * KITH_STRIDE;
  double fastest = sums->signal;
#pragma omp simd reduction(max : fastest)
  for (size_t k = 0; k < n; ++k) fastest = KITH_MAX(fastest, signal[k]);
  sums->signal = fastest;
  for (size_t k = n; k < kith_lanes_padded(n); ++k)
    for (int a = 0; a <= NDIM; ++a) out[(size_t)(KITH_FORCE + a) * KITH_STRIDE + k] = 0;
  if (pass->ticks == NULL) {
    if (pass->flag != NULL) add_outside(pass, i, row, n, out, NULL, NULL, sums);
    add_block(pass, false, n, out, NULL, NULL, sums);
    return;
  }
  kith_lanes closing[KITH_BLOCK / KITH_LANES], opening[KITH_BLOCK / KITH_LANES];
  weigh_block(pass, i, first, n, closing, opening);
  if (pass->flag != NULL)
    add_outside(pass, i, row, n, out, (const double *)closing, (const double *)opening, sums);
  add_block(pass, true, n, out, closing, opening, sums);
}

/* Ends the node, after the last package: (2) of block_steps.h. The present acceleration is that of the
 * external force at the last activity. */
static void end_blocks(const struct kith_force_pass *pass, kith_index i) {
  const struct kith_block_steps *b = pass->kick->blocks;
  const struct kith_package *package = pass->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const bool active = kith_node_active(hydro->nodes, i),
             external = package->pair_acceleration != hydro->acceleration;
  const double base = b->tick * KITH_TICKS, since = b->tick * (b->now - b->last->f64[i]),
               middle = since - 0.5 * b->tick * b->step->f64[i],
               later = b->ends ? 0 : 0.5 * b->tick * b->next->f64[i], *restrict p = hydro->velocity->f64 + at,
               *restrict k = b->impulse->f64 + at, *restrict opening = b->opening->f64 + at;
  double *restrict w = b->velocity->f64 + at, *all = hydro->acceleration->f64 + at,
                   *pairs = package->pair_acceleration->f64 + at, *restrict v = b->velocity_last->f64 + at;
  double g[NDIM] = {0}, closing_work = 0, opening_work = 0, slope = 0, fall = 0;
  if (external && active)
    kith_external_force_add(&hydro->external_force, hydro->nodes->position->f64 + at, g);
  for (int a = 0; a < NDIM; ++a) {
    const double o = base * opening[a], last = external ? active ? all[a] : all[a] - pairs[a] : 0,
                 ahead = w[a] + middle * last - p[a];
    fall += active ? last * (0.5 * (v[a] + p[a]) - w[a] - (middle - 0.5 * since) * last) : last * (k[a] + o);
    closing_work += k[a] * (ahead + 0.5 * k[a]);
    opening_work += opening[a] * (ahead + k[a]);
    slope += o * opening[a];
    if (active) v[a] = w[a] + k[a] + middle * g[a];
    w[a] += k[a] + (b->ends ? 0 : o) + (active ? (middle + later) * g[a] : 0);
    if (external && active) all[a] = pairs[a] + g[a];
  }
  double *const u = &b->energy->f64[i], *const begun = &b->opening_heat->f64[i];
  *u += b->heat->f64[i] - (package->compatible ? closing_work : 0);
  if (b->fall != NULL && package->compatible) {
    *u += active ? since * fall + b->fall->f64[i] : 0;
    b->fall->f64[i] = active ? 0 : b->fall->f64[i] + since * fall;
  }
  if (active) b->energy_last->f64[i] = *u;
  *begun -= package->compatible ? opening_work : 0;
  if (!b->ends) *u += base * (*begun - (package->compatible ? 0.5 * slope : 0));
  if (!active) return;
  const double rate = hydro->energy_rate->f64[i];
  b->rate_slope->f64[i] = since > 0 ? (rate - b->rate_last->f64[i]) / since : 0;
  b->rate_last->f64[i] = rate;
}

/* The same from the sums of forces and heats, where all pairs have one weight. */
static void weigh_sums(const struct kith_block_steps *b, kith_index i, struct sums *sums) {
  const double closing = b->now - b->last->f64[i] - 0.5 * b->step->f64[i], opening = 0.5 * b->next->f64[i];
  for (int a = 0; a <= NDIM; ++a) {
    const double value = a < NDIM ? sums->force[a] : sums->heat;
    sums->impulse[a] = b->tick * closing * value;
    sums->opening[a] = opening / KITH_TICKS * value;
    sums->outside_opening[a] = opening * sums->outside[a];
    sums->outside[a] *= closing;
  }
}

KITH_INLINE void store_blocks(const struct kith_force_pass *pass, kith_index i, struct sums *sums) {
  const struct kith_block_steps *b = pass->kick->blocks;
  if (b->alike) weigh_sums(b, i, sums);
  struct kith_package *package = pass->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const double mass = hydro->mass->f64[i];
  const bool adds = package->ops->longest_step != NULL, active = kith_node_active(hydro->nodes, i);
  double *all = hydro->acceleration->f64 + at, *pairs = package->pair_acceleration->f64 + at;
  double *impulse = b->impulse->f64 + at, *opening = b->opening->f64 + at;
  for (int a = 0; a < NDIM; ++a) {
    if (active && !adds && all != pairs) all[a] -= pairs[a];
    if (active) pairs[a] = (adds ? pairs[a] : 0) + sums->force[a] / mass;
    impulse[a] = (adds ? impulse[a] : 0) + sums->impulse[a] / mass;
    opening[a] = (adds ? opening[a] : 0) + sums->opening[a] / mass;
  }
  double *const heat = &b->heat->f64[i], *const later = &b->opening_heat->f64[i],
                *const rate = &hydro->energy_rate->f64[i], *const signal = &package->signal->f64[i];
  *heat = (adds ? *heat : 0) + sums->impulse[NDIM] / mass;
  *later = (adds ? *later : 0) + sums->opening[NDIM] / mass;
  if (active) *rate = (adds ? *rate : 0) + sums->heat / mass;
  for (int a = 0; pass->flag != NULL && a <= NDIM; ++a) {
    double *closed = a < NDIM ? hydro->outside_force->f64 + at + a : hydro->outside_power->f64 + i,
           *opened = a < NDIM ? b->outside->f64 + at + a : b->outside_power->f64 + i;
    *closed = (adds ? *closed : 0) + b->tick * sums->outside[a];
    *opened = (adds ? *opened : 0) + sums->outside_opening[a] / KITH_TICKS;
  }
  if (!adds) *signal = active ? sums->signal : KITH_MAX(*signal, sums->signal);
  if (pass->is_last) end_blocks(pass, i);
}

/* What (1) of package.h needs: from the sums of the first package, to which the others add, and the last
 * ends it. In between the acceleration is the external force of the last evaluation, if there is one. */
KITH_INLINE void store(const struct kith_force_pass *pass, kith_index i, const struct sums *sums) {
  struct kith_package *package = pass->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const double mass = hydro->mass->f64[i], *restrict velocity = hydro->velocity->f64 + at,
               *restrict base = pass->kick->velocity_base->f64 + at;
  double *all = hydro->acceleration->f64 + at, *pairs = package->pair_acceleration->f64 + at, correction = 0;
  const bool adds = package->ops->longest_step != NULL, external = pairs != all;
  for (int a = 0; a < NDIM; ++a) {
    if (!adds && external) all[a] -= pairs[a];
    pairs[a] = adds ? pairs[a] + sums->force[a] / mass : sums->force[a] / mass;
  }
  const double rate = sums->heat / mass;
  hydro->energy_rate->f64[i] = adds ? hydro->energy_rate->f64[i] + rate : rate;
  if (!adds) package->signal->f64[i] = sums->signal;
  if (pass->flag != NULL) {
    double *force = hydro->outside_force->f64 + at, *power = &hydro->outside_power->f64[i];
    for (int a = 0; a < NDIM; ++a) force[a] = (adds ? force[a] : 0) + sums->outside[a];
    *power = (adds ? *power : 0) + sums->outside[NDIM];
  }
  if (!pass->is_last) return;
  for (int a = 0; a < NDIM; ++a)
    correction -= pairs[a] * (base[a] + pass->kick->lead * (external ? all[a] : 0) - velocity[a]);
  if (external) {
    memcpy(all, pairs, NDIM * sizeof *all);
    kith_external_force_add(&hydro->external_force, hydro->nodes->position->f64 + at, all);
  }
  if (package->compatible) package->energy_correction->f64[i] = correction;
}

/* --- chunks --- */

/* Traversal `pairs`, first half: the pairs that start at a node of the chunk, into the pairwise field. */
KITH_HOT static void pairs_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const double *restrict out = kith_force_values(pass, s);
  for (kith_index i = begin; i < end; ++i)
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; p += KITH_BLOCK) {
      const size_t n = KITH_MIN(pairs->first[i + 1] - p, (size_t)KITH_BLOCK);
      kith_index partner[KITH_BLOCK];
      for (size_t k = 0; k < n; ++k) partner[k] = pairs->node[p + k][1];
      for (size_t q = p + KITH_AHEAD; q < KITH_MIN(p + KITH_AHEAD + n, pairs->n); ++q)
        kith_force_prefetch(packed_particle(pass, pairs->node[q][1]), (size_t)pass->n_packed);
      for (size_t k = 0; pass->edges > 0 && k < n; ++k) load_edge(pass, p + k, true, k, s);
      pass->evaluate(pass, i, partner, kith_shifts_at(pairs->shift, pass->connectivity->rows.zero, p, n), n,
                     n, s);
      double *restrict value = pass->pair->value + p * KITH_PAIR_VALUES;
      for (size_t k = 0; k < n; ++k)
        for (int m = 0; m < KITH_PAIR_VALUES; ++m)
          value[k * KITH_PAIR_VALUES + m] = out[(size_t)m * KITH_STRIDE + k];
    }
}

/* The values of the n pairs from entry `first` of row i on, evaluated anew. */
KITH_INLINE void gather(const struct kith_force_pass *pass, kith_index i, size_t first, size_t n,
                        struct kith_scratch *s) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  const struct kith_rows *rows = &pass->connectivity->rows;
  for (size_t k = 0; pass->edges > 0 && k < n; ++k)
    load_edge(pass, pairs->of_row[first + k], kith_pair_starts(pass->connectivity, i, first + k), k, s);
  pass->evaluate(pass, i, rows->node + first, kith_shifts_at(rows->shift, rows->zero, first, n), n,
                 rows->first[rows->n] - first, s);
}

/* The sums of each node of the chunk: second half of `pairs`, or all of `gather`. */
KITH_HOT static void nodes_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const bool kept = pass->package->traversal == KITH_TRAVERSE_PAIRS;
  double *out = kith_force_values(pass, s);
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
    if (pass->kick->blocks != NULL)
      store_blocks(pass, i, &sums);
    else
      store(pass, i, &sums);
  }
}

/* --- driving --- */

static const struct kith_pairwise_spec pair_force = {"pair_force", KITH_PAIR_VALUES, false,
                                                     "force, heat of both ends, signal speed"};

/* What weights of pairs need of node i; frozen nodes have the longest step. */
static void pack_ticks(const struct kith_block_steps *b, kith_index i, double *restrict ticks) {
  const bool frozen = b->step->f64[i] == 0;
  ticks[0] = b->last->f64[i];
  ticks[1] = frozen ? KITH_TICKS : b->step->f64[i];
  ticks[2] = frozen ? KITH_TICKS : b->next->f64[i];
}

/* Packs particles begin .. end - 1. */
static void pack(void *context, kith_index begin, kith_index end) {
  const struct kith_force_pass *pass = context;
  struct kith_package *package = pass->package;
  const struct kith_nodes *nodes = package->hydro->nodes;
  const uint8_t *activity =
      nodes->activity != NULL ? nodes->activity->u8 : NULL; /* idle nodes are in no row */
  const kith_index internal = nodes->n_internal;
  kith_profile_begin(package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index from = begin; from < end; from += KITH_STRETCH) {
    const kith_index to = KITH_MIN(from + KITH_STRETCH, end),
                     stop = to <= internal ? kith_stretch_end(nodes, from, to) : to;
    for (kith_index i = from; i < stop; ++i)
      if (activity == NULL || i >= internal || activity[i] != KITH_IDLE) {
        pass->pack(package, i, packed_particle(pass, i));
        if (pass->ticks != NULL) pack_ticks(pass->kick->blocks, i, pass->ticks + (size_t)i * KITH_LANES);
      }
  }
  kith_profile_count(package->profile, "bytes",
                     16.0 * (double)kith_lanes_padded((size_t)pass->n_packed) * (end - begin));
  kith_profile_end(package->profile);
}

kith_status kith_force(struct kith_force_pass *pass) {
  struct kith_package *package = pass->package;
  const struct kith_hydro *hydro = package->hydro;
  const struct kith_nodes *nodes = hydro->nodes;
  const kith_index all = kith_nodes_count(nodes), internal = nodes->n_internal;
  const bool kept = package->traversal == KITH_TRAVERSE_PAIRS;
  const double evaluated = 8.0 * pass->edges * (double)pass->connectivity->pairs.n, /* bytes */
      values = kept ? 8.0 * KITH_PAIR_VALUES * (double)pass->connectivity->pairs.n : 0,
               of_row = kept || pass->edges > 0 ? 4.0 * (double)pass->connectivity->rows.first[internal] : 0;
  const struct kith_node_sweep pairs = {
      .stage = "pairs",
      .rows = &pass->connectivity->rows,
      .chunk = pairs_chunk,
      .context = pass,
      .touched = true,
      .lanes = (int)kith_lanes_padded((size_t)pass->n_packed) + pass->edges + KITH_PAIR_VALUES,
      .width = KITH_STRIDE,
      .arrived = pack,
      .shared = 8 * (int)kith_lanes_padded((size_t)pass->n_packed),
      .pairwise = evaluated + values};
  struct kith_node_sweep sums = pairs;
  sums.stage = "force", sums.chunk = nodes_chunk;
  sums.touched = pass->kick->blocks != NULL; /* else what is not active keeps its rates */
  /* m, c, heat, signal, correction; v, its base, the accelerations, which are read and written */
  sums.own = 8 * (5 + NDIM * (package->pair_acceleration != hydro->acceleration ? 6 : 4));
  sums.shared = kept ? 0 : pairs.shared, sums.pairwise = of_row + (kept ? values : evaluated);
  pass->barrier = package->barrier != NULL ? package->barrier->u8 : NULL;
  pass->flag = hydro->outside_force != NULL ? nodes->flag->u8 : NULL;
  pass->f_couple = kith_connectivity_factors(&pass->connectivity->pairs);
  pass->is_last = true;
  for (const struct kith_package *p = package->next; p != NULL; p = p->next)
    pass->is_last = pass->is_last && p->ops->evaluate == NULL;
  const bool weighs = pass->kick->blocks != NULL && !pass->kick->blocks->alike;
  const size_t packed = (size_t)all * kith_lanes_padded((size_t)pass->n_packed);
  KITH_TRY(kith_nodes_work(nodes, (packed + (weighs ? (size_t)all * KITH_LANES : 0)) * sizeof(double),
                           &pass->packed));
  pass->ticks = weighs ? pass->packed + packed : NULL;
  pack(pass, 0, kith_halo_pending(hydro->halo) ? kith_nodes_first_remote(nodes) : all);
  if (pass->edge != NULL) KITH_TRY(kith_pairwise_fresh(&pass->connectivity->pairs, pass->edge));
  if (kept) {
    KITH_TRY(kith_pairwise_prepare(&pass->connectivity->pairs, &pair_force, &pass->pair));
    KITH_TRY(kith_package_sweep(package, &pairs, NULL));
    /* Canonical pairs that start at ghosts, whose values have arrived by now. */
    KITH_TRY(
        kith_package_sweep_ghosts(package, &pairs, internal, pass->connectivity->pairs.starts - internal));
    KITH_TRY(kith_pairwise_fresh(&pass->connectivity->pairs, pass->pair));
  }
  return kith_package_sweep(package, &sums, NULL);
}
