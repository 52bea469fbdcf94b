/* What a run will cost: evaluations that are timed, short runs with fewer nodes; and what each of many ranks
 * would have. */
#include "app/plan/forecast.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "integrator/lifecycle.h"
#include "lib/domain/cell_bounds.h"
#include "lib/domain/decomposition.h"
#include "lib/domain/partition/partition.h"

enum { MOST_RANKS = 16384, MOST_RANKS_OF_A_NODE = 512 };

/* ---- one process ---- */

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

static kith_status steps_of(struct kith_simulation *m, int k, double until, double limit,
                            struct kith_calibration *out) {
  struct kith_integrator *it = &m->integrator;
  double first;
  KITH_TRY(kith_simulation_start(m));
  KITH_TRY(kith_evaluation_measure(m, &first));
  const bool blocks = kith_scheme_has_blocks(it->scheme, it->settings);
  const uint64_t evaluations = it->ledger.evaluations, updates = it->ledger.updates;
  const double start = seconds_now();
  while (it->time < until) {
    KITH_TRY(kith_integrator_step(it, until));
    if (seconds_now() - start > limit) KITH_FAIL(DIVERGED, "a calibration run exceeds %.3g s", limit);
  }
  const double of_node = (double)(it->ledger.updates - updates) / m->nodes->n_internal,
               all = blocks ? of_node : (double)(it->ledger.evaluations - evaluations);
  out->steps[k] = blocks ? of_node : (double)it->step;
  out->growth = (seconds_now() - start) / fmax(all, 1) / first;
  return KITH_OK;
}

static kith_status run(const struct kith_options *o, int k, double until, double limit,
                       struct kith_calibration *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  char resolution[64];
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  memcpy(overrides, o->overrides, sizeof o->overrides);
  snprintf(resolution, sizeof resolution, "resolution=%.10g", out->resolution[k]);
  overrides[o->n_overrides] = resolution;
  KITH_TRY(kith_scene_read(&scene, o->subject, o->n_overrides + 1, overrides));
  kith_status status = kith_simulation_create(&m, scene, NULL, false);
  if (status == KITH_OK) status = steps_of(m, k, until, limit, out);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

/* Whole and even, where that makes little difference: lattices and centers may need it. */
static double rounded(double resolution) {
  return resolution > 10 ? 2 * round(0.5 * resolution) : resolution;
}

kith_status kith_calibration_run(struct kith_calibration *out, const struct kith_options *options,
                                 double resolution, double until, double cost, double budget) {
  const double part = fmin(pow(budget / cost, 1.0 / (NDIM + 1)), 0.8);
  *out =
      (struct kith_calibration){.resolution = {rounded(0.7 * part * resolution), rounded(part * resolution)}};
  for (int k = 0; k < 2; ++k) KITH_TRY(run(options, k, until, 10 * budget, out));
  const double slope = (out->steps[1] - out->steps[0]) / (out->resolution[1] - out->resolution[0]);
  out->expected = out->steps[1] + fmax(slope, 0) * (resolution - out->resolution[1]);
  return KITH_OK;
}

/* ---- the model ---- */

/* Of a node or image. */
struct mark {
  int32_t rank;  /* -1: of a frozen one, which all have */
  bool periodic; /* an image across periodic faces */
};

struct model {
  const struct kith_simulation *simulation;
  int n_ranks;
  struct kith_cells cells;
  int64_t *home;                   /* [n_internal] the cell of each node */
  struct kith_cell_bounds *bounds; /* [cells.n] */
  double *work, *rank_work;        /* [cells.n], [n_ranks] */
  double search_radius;            /* the largest of all */
  double factor;                   /* f of cell_bounds.h */
  struct kith_partition *partition;
  const int32_t *owner; /* [cells.n] its map */
  struct mark *mark;    /* of all nodes */
  double *made, *peers; /* [n_ranks] ghosts, ranks that it exchanges with */
  uint8_t *meets;       /* [from][to] */
};

static kith_status fill_cells(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t *first = o->simulation->connectivity->rows.first;
  KITH_TRY(kith_resize(&o->home, 0, (size_t)nodes->n_internal, sizeof *o->home));
  KITH_TRY(kith_resize(&o->work, 0, (size_t)o->cells.n, sizeof *o->work));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    o->home[i] = kith_cells_of(&o->cells, nodes->position->f64 + (size_t)i * NDIM);
    o->work[o->home[i]] += 1 + (double)(first[i + 1] - first[i]);
    o->search_radius = fmax(o->search_radius, nodes->search_radius->f64[i]);
  }
  return kith_cell_bounds_of_nodes(nodes, o->home, (size_t)o->cells.n, &o->bounds);
}

/* ---- who is sent where ---- */

struct targets {
  int n;
  bool full; /* there are more */
  struct {
    int32_t rank;
    int shift[NDIM];
  } of[MOST_RANKS_OF_A_NODE];
};

static void aim(struct targets *t, int32_t rank, const int *shift) {
  for (int k = 0; k < t->n; ++k)
    if (t->of[k].rank == rank && memcmp(t->of[k].shift, shift, sizeof t->of[k].shift) == 0) return;
  t->full = t->n == MOST_RANKS_OF_A_NODE;
  if (t->full) return;
  t->of[t->n].rank = rank;
  memcpy(t->of[t->n++].shift, shift, sizeof t->of[0].shift);
}

/* The ranks that node x is sent to: all cells around it are tested, also images of cells across periodic
 * faces. */
static void find_targets(const struct model *o, const double *x, double search_radius, int32_t own,
                         struct targets *t) {
  const struct kith_cells *g = &o->cells;
  int64_t low[NDIM], count[NDIM], n = 1;
  t->n = 0, t->full = false;
  for (int a = 0; a < NDIM; ++a) {
    int64_t high = (int64_t)floor((x[a] + o->factor * o->search_radius - g->lower[a]) / g->edge[a]);
    low[a] = (int64_t)floor((x[a] - o->factor * o->search_radius - g->lower[a]) / g->edge[a]);
    if (!g->periodic[a]) { /* images are outside */
      low[a] = KITH_MIN(KITH_MAX(low[a], 0), g->count[a] - 1);
      high = KITH_MAX(KITH_MIN(high, g->count[a] - 1), 0);
    }
    n *= count[a] = high - low[a] + 1;
  }
  for (int64_t number = 0; number < n; ++number) {
    int64_t k[NDIM];
    int shift[NDIM];
    double y[NDIM]; /* the image of x that stands where the cell sees it */
    kith_grid_place(count, number, k);
    for (int a = 0; a < NDIM; ++a) {
      k[a] += low[a];
      shift[a] = (int)floor((double)k[a] / (double)g->count[a]);
      k[a] -= shift[a] * g->count[a];
      y[a] = x[a] - shift[a] * (g->upper[a] - g->lower[a]);
    }
    const int64_t c = kith_grid_number(g->count, k);
    if (o->owner[c] != own && kith_cell_bounds_near(&o->bounds[c], y, search_radius, o->factor))
      aim(t, o->owner[c], shift);
  }
}

static void mark_nodes(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  struct mark *mark = o->mark;
  for (kith_index i = 0; i < nodes->n_internal; ++i) mark[i].rank = o->owner[o->home[i]];
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    const bool wraps = o->simulation->boundaries.boundary[block->boundary]->ops->wraps;
    for (kith_index k = 0; k < block->count; ++k) {
      const struct mark *control = block->control != NULL ? &mark[block->control[k]] : NULL;
      mark[block->first + k] = (struct mark){.rank = control != NULL ? control->rank : -1,
                                             .periodic = wraps || (control != NULL && control->periodic)};
    }
  }
}

/* Periodic images are found from their nodes, as many as there are; mirror images are those in the lists. */
static kith_status count_ghosts(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t n = (size_t)o->n_ranks;
  for (kith_index i = 0; i < kith_nodes_count(nodes); ++i) {
    struct targets t;
    const int32_t rank = o->mark[i].rank;
    if (rank < 0 || o->mark[i].periodic) continue;
    find_targets(o, nodes->position->f64 + (size_t)i * NDIM, nodes->search_radius->f64[i], rank, &t);
    if (t.full) KITH_FAIL(UNSUPPORTED, "a node is sent to more than %d ranks", MOST_RANKS_OF_A_NODE);
    for (int k = 0; k < t.n; ++k) {
      o->made[t.of[k].rank] += 1;
      o->meets[(size_t)rank * n + (size_t)t.of[k].rank] = 1;
    }
  }
  for (size_t k = 0; k < n * n; ++k) o->peers[k / n] += o->meets[k] | o->meets[k % n * n + k / n];
  return KITH_OK;
}

/* ---- one partitioner ---- */

static kith_status predict(struct model *o, const char *partitioner, struct kith_forecast *f) {
  const size_t n = (size_t)o->n_ranks;
  KITH_TRY(fill_cells(o));
  KITH_TRY(kith_partition_create(&o->partition, &o->cells, o->n_ranks, partitioner));
  KITH_TRY(kith_partition_converge(o->partition, o->work));
  o->owner = o->partition->owner;
  KITH_TRY(kith_resize(&o->mark, 0, (size_t)kith_nodes_count(o->simulation->nodes), sizeof *o->mark));
  KITH_TRY(kith_resize(&o->rank_work, 0, 3 * n, sizeof *o->rank_work));
  KITH_TRY(kith_resize(&o->meets, 0, n * n, 1));
  o->made = o->rank_work + n, o->peers = o->made + n;
  mark_nodes(o);
  KITH_TRY(count_ghosts(o));
  *f = (struct kith_forecast){.imbalance =
                                  kith_partition_loads(o->partition, o->owner, o->work, o->rank_work)};
  for (size_t r = 0; r < n; ++r) {
    f->ghosts += o->made[r] / (double)n, f->most_ghosts = fmax(f->most_ghosts, o->made[r]);
    f->peers += o->peers[r] / (double)n, f->most_peers = fmax(f->most_peers, o->peers[r]);
  }
  return KITH_OK;
}

kith_status kith_forecast_ranks(const struct kith_simulation *m, int n_ranks, const char *partitioner,
                                struct kith_forecast *out) {
  struct model o = {.simulation = m, .n_ranks = n_ranks, .factor = m->connectivity->built.overlap ? 2 : 1};
  bool periodic[NDIM];
  if (n_ranks > MOST_RANKS) KITH_FAIL(BAD_INPUT, "no forecast for more than %d ranks", MOST_RANKS);
  if (m->scene->partition.recompute)
    KITH_FAIL(BAD_INPUT, "partition.ghosts: there is no forecast of recompute; exchange has one");
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->period[a] > 0;
  KITH_TRY(kith_decomposition_cells(&o.cells, m->nodes, &m->scene->domain, periodic,
                                    (int64_t)m->scene->partition.cells * n_ranks));
  const kith_status status = predict(&o, partitioner, out);
  void *const owned[] = {&o.home, &o.bounds, &o.work, &o.rank_work, &o.mark, &o.meets};
  for (size_t k = 0; k < sizeof owned / sizeof *owned; ++k) kith_free(owned[k]);
  kith_partition_destroy(&o.partition);
  return status;
}
