/* What a run will cost: evaluations that are timed, short runs with fewer nodes; and what each of many ranks
 * would have. */
#include "app/plan/forecast.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "app/initial/initial_conditions.h"
#include "app/initial/region.h"
#include "integrator/lifecycle.h"
#include "lib/domain/decomposition.h"
#include "lib/domain/partition/partition.h"

enum { MOST_RANKS = 16384 };

/* Processor time where there is one thread: other programs do not count. */
static double seconds_now(void) {
  struct timespec t;
  if (omp_get_max_threads() > 1) return kith_seconds();
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

kith_status kith_evaluation_measure(struct kith_simulation *simulation, double *seconds) {
  struct kith_integrator *it = &simulation->integrator;
  const double start = seconds_now();
  double before = start;
  *seconds = INFINITY;
  for (int k = 0; k < 3 && before - start < 0.5; ++k) {
    if (kith_rebuilds_lasting(it->rebuilds)) KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_requested));
    KITH_TRY(kith_integrator_rates(it));
    const double now = seconds_now();
    *seconds = fmin(*seconds, now - before);
    before = now;
  }
  return KITH_OK;
}

static kith_status steps_of(struct kith_simulation *m, double until, double limit,
                            struct kith_calibration *out) {
  struct kith_integrator *it = &m->integrator;
  double first;
  KITH_TRY(kith_simulation_start(m));
  KITH_TRY(kith_evaluation_measure(m, &first));
  const bool parts = it->nodes->activity != NULL; /* not all nodes are updated at a time */
  const uint64_t evaluations = it->ledger.evaluations, updates = it->ledger.updates;
  const double start = seconds_now();
  while (it->time < until) {
    KITH_TRY(kith_integrator_step(it, until));
    if (seconds_now() - start > limit) KITH_FAIL(DIVERGED, "a calibration run exceeds %.3g s", limit);
  }
  const double of_node = (double)(it->ledger.updates - updates) / m->nodes->n_internal,
               all = parts ? of_node : (double)(it->ledger.evaluations - evaluations);
  out->steps = parts ? of_node : (double)it->step;
  out->growth = (seconds_now() - start) / fmax(all, 1) / first;
  return KITH_OK;
}

static kith_status run(const struct kith_options *o, double until, double limit,
                       struct kith_calibration *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  char resolution[64];
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  memcpy(overrides, o->overrides, sizeof o->overrides);
  snprintf(resolution, sizeof resolution, "resolution=%.10g", out->resolution);
  overrides[o->n_overrides] = resolution;
  KITH_TRY(kith_scene_read(&scene, o->subject, o->n_overrides + 1, overrides));
  kith_status status = kith_simulation_create(&m, scene, NULL, NULL, false);
  if (status == KITH_OK) status = steps_of(m, until, limit, out);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 double resolution, double until, double cost, double budget) {
  const double part = fmin(pow(budget / cost, 1.0 / (NDIM + 1)), 0.8);
  /* Whole and even, where that makes little difference: lattices and centers may need it. */
  const double lower = part * resolution;
  *out = (struct kith_calibration){.resolution = lower > 10 ? 2 * round(0.5 * lower) : lower};
  KITH_TRY(run(options, until, 10 * budget, out));
  out->expected = out->steps * resolution / out->resolution;
  return KITH_OK;
}

struct model {
  const struct kith_simulation *simulation; /* NULL: outlined */
  double *nodes, *reach;                    /* [cells.n] then: nodes, and how far ghosts are from it */
  int n_ranks;
  struct kith_cells cells;
  struct kith_partition *partition;
  double *work, *rank_work; /* [cells.n], [n_ranks] */
  int64_t *home;            /* [n_internal] the cell of each node */
  int32_t *owner,
      *seen; /* of all nodes: their rank, -1 of frozen ones, which all have; last rank that needs it */
  kith_index *first, *next; /* [n_ranks], [n_internal]: the nodes of a rank; -1: no more */
  double *ghosts, *peers;   /* [n_ranks] */
  uint8_t *meets;           /* [n_ranks][n_ranks] */
};

static kith_status fill_cells(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t *first = o->simulation->connectivity->rows.first;
  KITH_TRY(kith_resize(&o->home, 0, (size_t)nodes->n_internal, sizeof *o->home));
  KITH_TRY(kith_resize(&o->work, 0, (size_t)o->cells.n, sizeof *o->work));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    o->home[i] = kith_cells_of(&o->cells, nodes->position->f64 + (size_t)i * NDIM);
    o->work[o->home[i]] += 1 + (double)(first[i + 1] - first[i]);
  }
  return KITH_OK;
}

/* An image belongs to the rank of its node. */
static kith_status find_owners(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t all = (size_t)kith_nodes_count(nodes);
  KITH_TRY(kith_resize(&o->owner, 0, 2 * all, sizeof *o->owner));
  KITH_TRY(kith_resize(&o->first, 0, (size_t)(o->n_ranks + nodes->n_internal), sizeof *o->first));
  o->seen = o->owner + all, o->next = o->first + o->n_ranks;
  for (int r = 0; r < o->n_ranks; ++r) o->first[r] = -1;
  for (kith_index i = nodes->n_internal - 1; i >= 0; --i) {
    const int32_t rank = o->owner[i] = o->partition->owner[o->home[i]];
    o->next[i] = o->first[rank];
    o->first[rank] = i;
  }
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    for (kith_index k = 0; k < block->count; ++k)
      o->owner[block->first + k] = block->control != NULL ? o->owner[block->control[k]] : -1;
  }
  for (size_t i = 0; i < all; ++i) o->seen[i] = -1;
  return KITH_OK;
}

static void count_ghosts(struct model *o) {
  const struct kith_connectivity *c = o->simulation->connectivity;
  const struct kith_rows *rows = c->built.overlap ? &c->overlap : &c->rows;
  const size_t n = (size_t)o->n_ranks;
  for (int32_t rank = 0; rank < o->n_ranks; ++rank)
    for (kith_index i = o->first[rank]; i >= 0; i = o->next[i])
      for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
        const kith_index j = rows->node[k];
        if (o->owner[j] < 0 || o->owner[j] == rank || o->seen[j] == rank) continue;
        o->seen[j] = rank;
        o->ghosts[rank] += 1;
        o->meets[(size_t)rank * n + (size_t)o->owner[j]] = 1;
      }
}

/* ---- outlines ---- */

enum {
  POINTS = 3,
  AROUND = NDIM == 1   ? 5
           : NDIM == 2 ? 25
                       : 125
}; /* two layers of cells: as far as it goes */

/* Nodes and support of a cell of this volume, by the region at x. A displacement is taken where it ends. */
static kith_status outline_at(struct model *o, const struct kith_scene *scene, double neighbors,
                              const double *site_volume, const double *x, int64_t cell, double volume) {
  for (int r = 0; r < scene->n_regions; ++r) {
    const struct kith_region *region = &scene->region[r];
    double place[NDIM], stretch = 1;
    bool holds;
    KITH_TRY(kith_region_holds(region, x, &holds));
    if (!holds) continue;
    memcpy(place, x, sizeof place);
    const double spacing = pow(site_volume[r], 1.0 / NDIM);
    if (kith_region_displace(region, &scene->domain, 1e-3 * spacing, place, &stretch) != KITH_OK) stretch = 1;
    const double of_node = site_volume[r] * stretch;
    o->nodes[cell] += volume / of_node;
    o->reach[cell] = (pow(neighbors / kith_ball(), 1.0 / NDIM) - 0.5) * pow(of_node, 1.0 / NDIM);
  }
  return KITH_OK;
}

/* Cells are sampled in their middle; few cells, in more points. */
static kith_status outline(struct model *o, const struct kith_scene *scene, double neighbors,
                           const double *site_volume) {
  const int per_axis = o->cells.n > 1 << 16 ? 1 : 4, samples = (int)kith_pow_dim(per_axis);
  double volume = 1.0 / samples;
  for (int a = 0; a < NDIM; ++a) volume *= o->cells.edge[a];
  KITH_TRY(kith_resize(&o->nodes, 0, 3 * (size_t)o->cells.n, sizeof *o->nodes));
  o->reach = o->nodes + o->cells.n, o->work = o->reach + o->cells.n;
  for (int64_t c = 0; c < o->cells.n; ++c) {
    int64_t k[NDIM];
    double x[NDIM];
    kith_grid_place(o->cells.count, c, k);
    for (int s = 0; s < samples; ++s) {
      for (int a = 0, rest = s; a < NDIM; ++a, rest /= per_axis)
        x[a] = o->cells.lower[a] + o->cells.edge[a] * ((double)k[a] + (rest % per_axis + 0.5) / per_axis);
      KITH_TRY(outline_at(o, scene, neighbors, site_volume, x, c, volume));
    }
    o->work[c] = o->nodes[c] * (1 + neighbors);
  }
  return KITH_OK;
}

/* The cells of other ranks around c, as offsets, with their ranks; returns how many. */
static int others_around(const struct model *o, int64_t c, int (*offset)[NDIM], int32_t *rank) {
  int64_t at[NDIM], k[NDIM];
  int n = 0, layers = 1;
  for (int a = 0; a < NDIM; ++a)
    if (o->reach[c] > o->cells.edge[a]) layers = 2;
  const int side = 2 * layers + 1, around = (int)kith_pow_dim(side);
  kith_grid_place(o->cells.count, c, at);
  for (int s = 0; s < around; ++s) {
    bool inside = true;
    for (int a = 0, rest = s; a < NDIM; ++a, rest /= side) {
      const int64_t count = o->cells.count[a];
      offset[n][a] = rest % side - layers;
      k[a] = at[a] + offset[n][a];
      if (o->cells.periodic[a]) k[a] = (k[a] % count + count) % count;
      inside = inside && k[a] >= 0 && k[a] < count;
    }
    if (!inside) continue;
    rank[n] = o->partition->owner[kith_grid_number(o->cells.count, k)];
    n += rank[n] != o->partition->owner[c];
  }
  return n;
}

/* Point t, in edges, of a cell: is it within `reach` of the cell at this offset? */
static bool sees(const struct kith_cells *cells, const double *t, const int *offset, double reach) {
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = offset[a] > 0 ? offset[a] - t[a] : offset[a] < 0 ? t[a] - offset[a] - 1 : 0;
    r2 += d * d * cells->edge[a] * cells->edge[a];
  }
  return r2 < reach * reach;
}

/* Points stand elsewhere in each cell, so that their mean over cells knows parts of a third. */
static void count_borders(struct model *o) {
  static const double golden[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const int samples = (int)kith_pow_dim(POINTS);
  int offset[AROUND][NDIM];
  int32_t rank[AROUND], met[AROUND];
  for (int64_t c = 0; c < o->cells.n; ++c) {
    const int n = o->nodes[c] > 0 ? others_around(o, c, offset, rank) : 0;
    for (int s = 0; s < samples && n > 0; ++s) {
      double t[NDIM];
      int n_met = 0;
      for (int a = 0, rest = s; a < NDIM; ++a, rest /= POINTS)
        t[a] = (rest % POINTS + fmod((double)c * golden[a], 1)) / POINTS;
      for (int k = 0; k < n; ++k) {
        bool known = false;
        for (int j = 0; j < n_met; ++j) known = known || met[j] == rank[k];
        if (known || !sees(&o->cells, t, offset[k], o->reach[c])) continue;
        met[n_met++] = rank[k];
        o->ghosts[rank[k]] += o->nodes[c] / samples;
        o->meets[(size_t)rank[k] * (size_t)o->n_ranks + (size_t)o->partition->owner[c]] = 1;
      }
    }
  }
}

static void count_peers(struct model *o) {
  const size_t n = (size_t)o->n_ranks;
  for (size_t r = 0; r < n; ++r)
    for (size_t q = 0; q < n; ++q) {
      if (!o->meets[r * n + q]) continue;
      o->peers[r] += 1;
      if (!o->meets[q * n + r]) o->peers[q] += 1;
    }
}

static kith_status predict(struct model *o, const char *partitioner, struct kith_forecast *f) {
  const size_t n = (size_t)o->n_ranks;
  if (o->simulation != NULL) KITH_TRY(fill_cells(o));
  KITH_TRY(kith_partition_create(&o->partition, &o->cells, o->n_ranks, partitioner));
  KITH_TRY(kith_partition_converge(o->partition, o->work));
  if (o->simulation != NULL) KITH_TRY(find_owners(o));
  KITH_TRY(kith_resize(&o->rank_work, 0, 3 * n, sizeof *o->rank_work));
  KITH_TRY(kith_resize(&o->meets, 0, n * n, 1));
  o->ghosts = o->rank_work + n, o->peers = o->ghosts + n;
  o->simulation != NULL ? count_ghosts(o) : count_borders(o);
  count_peers(o);
  *f = (struct kith_forecast){
      .imbalance = kith_partition_loads(o->partition, o->partition->owner, o->work, o->rank_work)};
  for (size_t r = 0; r < n; ++r) {
    f->ghosts += o->ghosts[r] / (double)n, f->most_ghosts = fmax(f->most_ghosts, o->ghosts[r]);
    f->peers += o->peers[r] / (double)n, f->most_peers = fmax(f->most_peers, o->peers[r]);
  }
  return KITH_OK;
}

static void clear(struct model *o) {
  void *const owned[] = {&o->nodes, &o->home, &o->rank_work, &o->owner, &o->first, &o->meets};
  for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k) kith_free(owned[k]);
  kith_partition_destroy(&o->partition);
}

kith_status kith_forecast_ranks(const struct kith_simulation *m, int n_ranks, const char *partitioner,
                                struct kith_forecast *out) {
  struct model o = {.simulation = m, .n_ranks = n_ranks};
  bool periodic[NDIM];
  if (n_ranks > MOST_RANKS) KITH_FAIL(BAD_INPUT, "no forecast for more than %d ranks", MOST_RANKS);
  if (m->scene->partition.recompute)
    KITH_FAIL(BAD_INPUT, "partition.ghosts: there is no forecast of recompute; exchange has one");
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->period[a] > 0;
  KITH_TRY(kith_decomposition_cells(&o.cells, m->nodes, &m->scene->domain, periodic,
                                    (int64_t)m->scene->partition.cells * n_ranks));
  const kith_status status = predict(&o, partitioner, out);
  kith_free(&o.work);
  clear(&o);
  return status;
}

kith_status kith_forecast_outline(const struct kith_scene *scene, double neighbors, int n_ranks,
                                  const char *partitioner, struct kith_forecast *out) {
  struct model o = {.n_ranks = n_ranks};
  bool periodic[NDIM];
  double *site_volume = NULL, sites, least = INFINITY;
  if (n_ranks > MOST_RANKS) KITH_FAIL(BAD_INPUT, "no forecast for more than %d ranks", MOST_RANKS);
  for (int a = 0; a < NDIM; ++a) periodic[a] = scene->period[a] > 0;
  KITH_TRY(kith_resize(&site_volume, 0, (size_t)scene->n_regions, sizeof *site_volume));
  kith_status status = kith_initial_conditions_outline(scene, site_volume, &sites);
  for (int r = 0; r < scene->n_regions; ++r) least = KITH_MIN(least, site_volume[r]);
  if (status == KITH_OK)
    status = kith_cells_init(&o.cells, scene->domain.lower, scene->domain.upper, periodic,
                             0.5 * pow(neighbors / kith_ball() * least, 1.0 / NDIM),
                             KITH_MIN((int64_t)scene->partition.cells * n_ranks, 1 << 22));
  if (status == KITH_OK) status = outline(&o, scene, neighbors, site_volume);
  if (status == KITH_OK) status = predict(&o, partitioner, out);
  kith_free(&site_volume);
  clear(&o);
  return status;
}
