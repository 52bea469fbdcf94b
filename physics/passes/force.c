/* The force pass without the pair function: packing, loading, both traversals, tiles, sums, barriers. */
#include "physics/passes/force.h"

#include <string.h>

/* --- loading --- */

/* Returns the packed particle of node or ghost i, padded to whole groups of lanes. */
KITH_INLINE double *packed_particle(const struct kith_force_pass *pass, kith_index i) {
  return pass->packed + (size_t)i * kith_lanes_padded((size_t)pass->form->n_packed);
}

void kith_force_shift(const struct kith_force_pass *pass, const uint16_t *shift, size_t n,
                      struct kith_scratch *s) {
  const struct kith_shifts *shifts = &pass->package->hydro->nodes->shifts;
  for (size_t k = 0; k < n; ++k)
    for (int a = 0; a < NDIM && shift[k] != shifts->zero; ++a)
      kith_lane(s, KITH_PACKED_X + a)[k] += shifts->by[shift[k]][a];
}

void kith_force_correct_frozen(const struct kith_force_pass *pass, kith_index i, const kith_index *partner,
                               size_t n, struct kith_scratch *s) {
  const double *self = packed_particle(pass, i);
  for (size_t k = 0; k < n; ++k)
    if (pass->flag[partner[k]] == KITH_FROZEN) pass->form->copy_corrections(self, s->lane + k);
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
    for (int m = KITH_PACKED_OWN; m < pass->form->n_packed; ++m) kith_lane(s, m)[k] = self[m];
  }
}

/* --- partners --- */

/* Loads the values of the edges from i to its partners. */
KITH_INLINE void load_edges(const struct kith_force_pass *pass, const struct kith_partner_block *b,
                            struct kith_scratch *s) {
  const size_t edges = (size_t)pass->edges;
  double *restrict to = kith_force_edges(pass, s);
  for (size_t k = 0; edges > 0 && k < b->n; ++k) {
    const size_t e = kith_partner_entry(b, k), p = pass->connectivity->pairs.of_row[e];
    const bool starts = kith_pair_starts(pass->connectivity, b->of->i, e);
    for (size_t m = 0; m < edges; ++m) {
      const double value = pass->edge->value[p * edges + m];
      to[m * KITH_STRIDE + k] = starts ? value : -value;
    }
  }
}

/* Corrects pairs with barriers: a wall at rest does no work, so i gets all of -f . v_i, and no other heat;
 * one of volume V counts as V / V_i nodes like i. */
KITH_INLINE void correct_barriers(const struct kith_force_pass *pass, kith_index i,
                                  const kith_index *restrict row, size_t n, double *restrict out) {
  const double *restrict support = pass->package->hydro->nodes->support->f64,
                         *restrict v = pass->package->hydro->velocity->f64 + (size_t)i * NDIM;
  for (size_t k = 0; pass->barrier != NULL && k < n; ++k) {
    if (!pass->barrier[row[k]]) continue;
    const double count = kith_pow_dim(support[row[k]] / support[i]);
    double heat = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double f = out[(size_t)a * KITH_STRIDE + k] *= count;
      heat -= f * v[a];
    }
    out[KITH_HEAT * KITH_STRIDE + k] = heat;
  }
}

/* --- summing --- */

/* Computes the weights (1) of block_steps.h of the n pairs of i with these nodes, as parts that close the
 * last interval of a pair and open its next. */
KITH_INLINE void weigh_block(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict row,
                             size_t n, kith_lanes *restrict closing, kith_lanes *restrict opening) {
  const struct kith_block_steps *b = pass->rates.kick->blocks;
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

/* Adds forces and heats of n entries, padded to whole lanes, and with block steps the weighted ones. */
KITH_INLINE void add_block(const struct kith_force_pass *pass, bool weighs, size_t n,
                           const double *restrict out, const kith_lanes *restrict closing,
                           const kith_lanes *restrict opening, struct kith_pair_sums *sums) {
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
    sums->impulse[a] += pass->rates.kick->blocks->tick * kith_lanes_total(&ended[a]);
    sums->opening[a] += kith_lanes_total(&begun[a]) / KITH_TICKS;
  }
}

/* Multiplies forces and heats by the f_couple of their pairs; signal speeds stay. */
KITH_INLINE void couple(const struct kith_force_pass *pass, const struct kith_partner_block *b,
                        double *restrict out) {
  for (size_t k = 0; pass->f_couple != NULL && k < b->n; ++k) {
    const double f = pass->f_couple[pass->connectivity->pairs.of_row[kith_partner_entry(b, k)]];
    for (int m = 0; m <= KITH_PARTNER_HEAT; ++m) out[(size_t)m * KITH_STRIDE + k] *= f;
  }
}

/* Adds what partners that are no gas give to i (hydro.h). closing, opening: the weights of the pairs; NULL:
 * 1, and nothing opens. */
KITH_INLINE void add_outside(const struct kith_force_pass *pass, kith_index i, const kith_index *restrict row,
                             size_t n, const double *restrict out, const double *restrict closing,
                             const double *restrict opening, struct kith_pair_sums *sums) {
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

/* --- tiles --- */

/* The nodes of a tile, and what each has been given by pairs with earlier nodes of the tile: forces (on the
 * other end, so of opposite sign) and the heat. With block steps the weighted ones are in the second and
 * third group of lanes; else, if nodes have flags, what non-gas nodes give is in the second. */
struct tile {
  kith_index begin;
  size_t groups;
  kith_lanes *given; /* [nodes][groups] */
  double *signal;    /* [nodes] */
};
static size_t groups_of(const struct kith_force_pass *pass) {
  return pass->ticks != NULL ? 3 : pass->flag != NULL ? 2 : 1;
}

/* Makes a tile, in scratch after the lanes of the pass. */
static struct tile tile_of(const struct kith_force_pass *pass, kith_index begin, kith_index end,
                           const struct kith_scratch *s) {
  struct tile t = {begin, groups_of(pass), (kith_lanes *)kith_scratch_lane(s, pass->lanes), NULL};
  const size_t n = (size_t)(end - begin);
  t.signal = (double *)(t.given + n * t.groups);
  memset(t.given, 0, n * (t.groups * sizeof *t.given + sizeof *t.signal));
  return t;
}

/* Gives partners from .. to - 1 of the block their side of the pairs. closing, opening: their weights; NULL
 * without block steps. */
KITH_INLINE void give(const struct kith_force_pass *pass, const struct tile *t,
                      const struct kith_partner_block *b, size_t from, size_t to, const double *restrict out,
                      const double *restrict closing, const double *restrict opening) {
  const double *restrict signal = out + KITH_SIGNAL * KITH_STRIDE;
  const bool outside = pass->flag != NULL && pass->flag[b->of->i] != KITH_GAS;
  for (size_t k = from; k < to; k += KITH_LANES) {
    const double *value[KITH_LANES] = {out + k, out + k, out + k, out + k};
    kith_lanes node[KITH_LANES];
    for (size_t a = 0; a < NDIM; ++a) value[a] = out + (KITH_FORCE + a) * KITH_STRIDE + k;
    value[NDIM] = out + KITH_PARTNER_HEAT * KITH_STRIDE + k;
    kith_lanes_transpose(value, node);
    for (size_t l = 0; l < KITH_LANES && k + l < to; ++l) {
      const size_t j = (size_t)(b->node[k + l] - t->begin);
      kith_lanes *given = t->given + j * t->groups;
      given[0] += node[l];
      if (closing != NULL) given[1] += closing[k + l] * node[l], given[2] += opening[k + l] * node[l];
      if (outside) given[1] += node[l];
      t->signal[j] = KITH_MAX(t->signal[j], signal[k + l]);
    }
  }
}

/* Adds to the sums of node i what it has been given. */
KITH_INLINE void receive(const struct kith_force_pass *pass, const struct tile *t, kith_index i,
                         struct kith_pair_sums *sums) {
  const size_t j = (size_t)(i - t->begin);
  const kith_lanes *given = t->given + j * t->groups;
  for (int a = 0; a < NDIM; ++a) sums->force[a] -= given[0][a];
  sums->heat += given[0][NDIM];
  sums->signal = KITH_MAX(sums->signal, t->signal[j]);
  for (int a = 0; pass->ticks != NULL && a <= NDIM; ++a) {
    const double sign = a < NDIM ? -1 : 1;
    sums->impulse[a] += sign * pass->rates.kick->blocks->tick * given[1][a];
    sums->opening[a] += sign / KITH_TICKS * given[2][a];
  }
  if (pass->flag == NULL) return;
  const double *restrict v = pass->package->hydro->velocity->f64 + (size_t)i * NDIM;
  sums->outside[NDIM] += given[1][NDIM];
  for (int a = 0; a < NDIM; ++a) {
    sums->outside[a] -= given[1][a];
    sums->outside[NDIM] -= given[1][a] * v[a];
  }
}

/* Sums the block for its node, and gives the pairs to the partners that lie in the tile. */
KITH_INLINE void sum_block(const struct kith_force_pass *pass, const struct kith_partner_block *b,
                           const struct tile *tile, double *restrict out, struct kith_pair_sums *sums) {
  const struct kith_partners *of = b->of;
  const size_t n = b->n, from = KITH_MAX(of->given, b->begin), to = KITH_MIN(of->given_end, b->begin + n);
  const double *restrict signal = out + KITH_SIGNAL * KITH_STRIDE;
  kith_lanes weight[2][KITH_BLOCK / KITH_LANES];
  const bool weighs = pass->ticks != NULL;
  const double *closing = weighs ? (const double *)weight[0] : NULL,
               *opening = weighs ? (const double *)weight[1] : NULL;
  couple(pass, b, out);
  correct_barriers(pass, of->i, b->node, n, out);
  if (weighs) weigh_block(pass, of->i, b->node, n, weight[0], weight[1]);
  if (from < to) give(pass, tile, b, from - b->begin, to - b->begin, out, closing, opening);
  double fastest = sums->signal;
#pragma omp simd reduction(max : fastest)
  for (size_t k = 0; k < n; ++k) fastest = KITH_MAX(fastest, signal[k]);
  sums->signal = fastest;
  for (size_t k = n; k < kith_lanes_padded(n); ++k)
    for (int a = 0; a <= NDIM; ++a) out[(size_t)(KITH_FORCE + a) * KITH_STRIDE + k] = 0;
  if (pass->flag != NULL) add_outside(pass, of->i, b->node, n, out, closing, opening, sums);
  add_block(pass, weighs, n, out, weight[0], weight[1], sums);
}

/* --- chunks --- */

/* Prefetches the partners of a node some way ahead that lie outside of its tile; and a few nodes of the tile,
 * each once: after a quarter of it all are cached. To prefetch these for each partner takes a tenth of the
 * pass. */
enum { PACE = 4 };
KITH_INLINE void prefetch(const struct kith_force_pass *pass, const struct kith_partners *of,
                          const uint8_t *activity, kith_index begin, kith_index end) {
  const kith_index *restrict node = pass->connectivity->rows.node;
  const size_t n_packed = (size_t)pass->form->n_packed, outside = of->rest + of->given_end - of->before;
  for (size_t e = of->first; e < of->first + of->before; ++e)
    kith_force_prefetch(packed_particle(pass, node[e]), n_packed);
  for (size_t e = outside; e < of->rest + of->n - of->before; ++e)
    kith_force_prefetch(packed_particle(pass, node[e]), n_packed);
  const kith_index next = begin + PACE * (of->i - begin);
  for (kith_index j = next; j < KITH_MIN(next + PACE, end); ++j)
    if (activity == NULL || activity[j] != KITH_IDLE) kith_force_prefetch(packed_particle(pass, j), n_packed);
}

/* Prefetches as much as row i has of the entries some rows behind it. */
KITH_INLINE void prefetch_row(const struct kith_rows *rows, kith_index i) {
  enum { ENTRIES = 256, LINE = 64 / sizeof(kith_index) };
  const size_t end = KITH_MIN(rows->first[i + 1] + ENTRIES, rows->first[rows->n]);
  for (size_t e = rows->first[i] + ENTRIES; e < end; e += LINE) __builtin_prefetch(rows->node + e);
}

/* Evaluates the pairs of a node with its partners and sums them. tile: that of the node, or NULL. */
KITH_INLINE void sum_partners(const struct kith_force_pass *pass, const struct kith_partners *of,
                              const struct tile *tile, struct kith_scratch *s, struct kith_pair_sums *sums) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  double *out = kith_force_values(pass, s);
  for (size_t k = 0; k < of->n; k += KITH_BLOCK) {
    struct kith_partner_room room;
    const struct kith_partner_block b = kith_partner_block_at(rows, of, k, &room);
    load_edges(pass, &b, s);
    pass->form->evaluate[pass->package->kernel](
        pass, of->i, b.node, b.shift, b.n, tile != NULL ? b.n : rows->first[rows->n] - (of->first + k), s);
    sum_block(pass, &b, tile, out, sums);
  }
}

/* Sums nodes begin .. end - 1, each over its whole row. */
KITH_HOT static void gather_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const size_t *first = pass->connectivity->rows.first;
  for (kith_index i = begin; i < end; ++i) {
    struct kith_pair_sums sums = {.signal = pass->package->hydro->sound_speed->f64[i]};
    const struct kith_partners all = {
        .i = i, .rest = first[i], .n = first[i + 1] - first[i], .first = first[i]};
    sum_partners(pass, &all, NULL, s, &sums);
    kith_rates_store(&pass->rates, i, &sums);
  }
}

enum { AHEAD = 2 }; /* nodes to prefetch ahead: the time that memory takes to answer */

/* Sums nodes begin .. end - 1 as a tile. With block steps idle nodes have empty rows and are skipped. */
KITH_HOT static void tile_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_force_pass *pass = context;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const uint8_t *activity = pass->ticks != NULL ? pass->package->hydro->nodes->activity->u8 : NULL;
  while (activity != NULL && begin < end && activity[begin] == KITH_IDLE) ++begin;
  while (activity != NULL && begin < end && activity[end - 1] == KITH_IDLE) --end;
  const struct tile tile = tile_of(pass, begin, end, s);
  struct kith_partners next[AHEAD + 1]; /* of node i at i mod (AHEAD + 1) */
  for (kith_index i = begin; i < end + AHEAD; ++i) {
    if (i < end) {
      prefetch_row(rows, i);
      next[i % (AHEAD + 1)] = kith_partners_of(rows, i, begin, end);
      prefetch(pass, &next[i % (AHEAD + 1)], activity, begin, end);
    }
    const kith_index now = i - AHEAD;
    if (now < begin || (activity != NULL && activity[now] == KITH_IDLE)) continue;
    struct kith_pair_sums sums = {.signal = pass->package->hydro->sound_speed->f64[now]};
    sum_partners(pass, &next[now % (AHEAD + 1)], &tile, s, &sums);
    receive(pass, &tile, now, &sums);
    kith_rates_store(&pass->rates, now, &sums);
  }
}

/* --- driving --- */

/* Packs what weights of pairs need of node i; frozen nodes have the longest step. */
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
  if (begin == end) return;
  (begin == 0 ? kith_profile_begin : kith_profile_resume)(package->profile, "pack");
#pragma omp parallel for schedule(static)
  for (kith_index from = begin; from < end; from += KITH_STRETCH) {
    const kith_index to = KITH_MIN(from + KITH_STRETCH, end),
                     stop = to <= internal ? kith_stretch_end(nodes, from, to) : to;
    for (kith_index i = from; i < stop; ++i)
      if (activity == NULL || i >= internal || activity[i] != KITH_IDLE) {
        pass->form->pack(package, i, packed_particle(pass, i));
        if (pass->ticks != NULL)
          pack_ticks(pass->rates.kick->blocks, i, pass->ticks + (size_t)i * KITH_LANES);
      }
  }
  kith_profile_count(package->profile, "bytes",
                     16.0 * (double)kith_lanes_padded((size_t)pass->form->n_packed) * (end - begin));
  kith_profile_end(package->profile);
}

/* Returns the number of nodes of a tile: so many that most pairs lie within one, so few that threads share
 * the tiles evenly and the caches hold them. */
static kith_index tile_size(kith_index n) {
  return KITH_CHUNK * KITH_MAX(1, KITH_MIN(64, n / (64 * KITH_CHUNK)));
}

kith_status kith_force(struct kith_package *package, const struct kith_connectivity *connectivity,
                       const struct kith_kick *kick, struct kith_force_pass *pass) {
  const struct kith_hydro *hydro = package->hydro;
  const struct kith_nodes *nodes = hydro->nodes;
  const kith_index all = kith_nodes_count(nodes), internal = nodes->n_internal;
  const size_t size = kith_lanes_padded((size_t)pass->form->n_packed);
  pass->package = package, pass->connectivity = connectivity;
  pass->barrier = package->barrier != NULL ? package->barrier->u8 : NULL;
  pass->flag = hydro->outside_force != NULL ? nodes->flag->u8 : NULL;
  pass->f_couple = kith_connectivity_factors(&connectivity->pairs);
  pass->rates = kith_rates_of(package, kick);
  const bool weighs = kick->blocks != NULL && !kick->blocks->alike;
  const size_t packed = (size_t)all * size;
  KITH_TRY(kith_nodes_work(nodes, (packed + (weighs ? (size_t)all * KITH_LANES : 0)) * sizeof(double),
                           &pass->packed));
  pass->ticks = weighs ? pass->packed + packed : NULL;
  pack(pass, 0, internal);
  if (pass->n_exchanged > 0) kith_package_start_refresh(package, pass->n_exchanged, pass->exchanged);
  pack(pass, internal, kith_halo_pending(hydro->halo) ? kith_nodes_first_remote(nodes) : all);
  if (pass->edge != NULL) KITH_TRY(kith_pairwise_fresh(&connectivity->pairs, pass->edge));
  const bool tiled = package->traversal == KITH_TRAVERSE_PAIRS && !connectivity->canonical &&
                     !(weighs && pass->flag != NULL);
  pass->lanes = (int)size + pass->edges + KITH_PAIR_VALUES;
  const kith_index chunk = tiled ? tile_size(internal) : KITH_CHUNK;
  const size_t given = tiled ? (size_t)chunk * (groups_of(pass) * KITH_LANES + 1) : 0;
  const struct kith_node_sweep sums = {
      .stage = "force",
      .rows = &connectivity->rows,
      .chunk = tiled ? tile_chunk : gather_chunk,
      .chunk_size = chunk,
      .context = pass,
      .touched = kick->blocks != NULL, /* without block steps only active nodes get new rates */
      .whole = tiled && weighs,
      .lanes = pass->lanes + (int)(given / KITH_STRIDE + 1),
      .width = KITH_STRIDE,
      .arrived = pack,
      .shared = 8 * (int)size,
      /* m, c, heat, signal, correction; v, its base, the accelerations, which are read and written */
      .own = 8 * (5 + NDIM * (package->pair_acceleration != hydro->acceleration ? 6 : 4)),
      .pairwise = pass->edges > 0 ? 8.0 * pass->edges * (double)connectivity->pairs.n +
                                        4.0 * (double)connectivity->rows.first[internal]
                                  : 0};
  return kith_package_sweep(package, &sums, NULL);
}
