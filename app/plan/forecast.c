/* What each of many ranks would have of a scene, what it would tell others, and how long a step would
 * take. */
#include "app/plan/forecast.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "app/initial/initial_conditions.h"
#include "app/initial/region.h"
#include "lib/domain/decomposition.h"
#include "lib/domain/ghost_candidates.h"
#include "lib/domain/partition/shell.h"

enum { MOST_RANKS = 16384 };
enum { SHELLS = 64 };   /* ranks whose neighbors are counted, from which means are taken */
enum { TEMPLATES = 8 }; /* nodes of a region whose neighbors are taken as those of all its nodes */
/* A ring are the cells around a cell: up to so many layers of them, so many cells along an axis, and in all.
 * */
enum { MOST_LAYERS = 4, SIDE = 2 * MOST_LAYERS + 1 };
enum { RING = NDIM == 1 ? SIDE : NDIM == 2 ? SIDE * SIDE : SIDE * SIDE * SIDE };
static const double MOST_POINTS = 1 << 22; /* sample points of an outline, if it has fewer cells */
static const double MOST_MAP_SECONDS = 60;

/* Ghosts are counted in two ways. MADE: all that are made, near cells. KEPT: those in rows, which culling
 * keeps. */
enum way { MADE, KEPT, WAYS };

struct model {
  const struct kith_simulation *simulation; /* of the scene, or of one with fewer nodes */
  const struct kith_scene *scene;
  const struct kith_step_cost *cost;
  int n_ranks;
  double factor, widest; /* ghosts are up to `factor` search radii away; the largest such distance */
  struct kith_cells cells;
  struct kith_partition *partition;
  double *nodes, *work;                      /* [cells.n] number of nodes, work */
  double *load, *ghosts[WAYS], *peers[WAYS]; /* [n_ranks] */
  uint8_t *exchanges;                        /* [n_ranks][n_ranks] a bit for each way */
  /* Of a scene that is laid out: */
  int64_t *home; /* [n_internal] the cell of each node */
  int32_t *owner,
      *seen; /* [all nodes] their rank, -1 of frozen ones, which every rank has; last rank that needed it */
  kith_index *first, *next; /* [n_ranks], [n_internal]: lists of the nodes of each rank; -1: the end */
  /* Of a scene that is outlined: */
  double *site_volume; /* [regions] volume of a node */
  int32_t *region;     /* [cells.n] the region that fills the cell */
  double *spacing;     /* [cells.n] spacing of its nodes */
  double *reach;       /* [cells.n] how far from the cell its nodes need others */
  double *vector;   /* [template[last]][NDIM] from nodes of the simulation to their neighbors, in spacings */
  size_t *template; /* [regions TEMPLATES + 1] where the neighbors of each such node begin in `vector` */
  double *radius;   /* [regions] search radius in spacings */
};

static double spacing_of(const struct model *o, kith_index i) {
  const struct kith_hydro *h = &o->simulation->hydro;
  return kith_root_dim(h->mass->f64[i] / h->density->f64[i]);
}

static const struct kith_rows *rows_of(const struct model *o) {
  const struct kith_connectivity *c = o->simulation->connectivity;
  return c->built.overlap ? &c->overlap : &c->rows;
}

static void add_ghost(struct model *o, enum way way, int32_t rank, int32_t of, double n) {
  o->ghosts[way][rank] += n;
  o->exchanges[(size_t)rank * (size_t)o->n_ranks + (size_t)of] |= (uint8_t)(1 << way);
}

/* ---- scenes that are laid out ---- */

static kith_status fill_cells(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t *first = o->simulation->connectivity->rows.first;
  KITH_TRY(kith_resize(&o->home, 0, (size_t)nodes->n_internal, sizeof *o->home));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const int64_t c = o->home[i] = kith_cells_of(&o->cells, nodes->position->f64 + (size_t)i * NDIM);
    o->nodes[c] += 1, o->work[c] += 1 + (double)(first[i + 1] - first[i]);
    o->widest = fmax(o->widest, o->factor * nodes->search_radius->f64[i]);
  }
  return KITH_OK;
}

/* Finds the rank of each node; an image belongs to the rank of its node. */
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
  const struct kith_rows *rows = rows_of(o);
  for (int32_t rank = 0; rank < o->n_ranks; ++rank)
    for (kith_index i = o->first[rank]; i >= 0; i = o->next[i])
      for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
        const kith_index j = rows->node[k];
        if (o->owner[j] < 0 || o->owner[j] == rank || o->seen[j] == rank) continue;
        o->seen[j] = rank;
        add_ghost(o, KEPT, rank, o->owner[j], 1);
      }
}

/* Counts the candidates near the cells of each rank, as a run chooses them. A cell belongs to one rank, so
 * its bounds are replaced by kith_nowhere once they were taken. */
static kith_status count_made(struct model *o, struct kith_candidates *candidates, struct kith_bounds *bounds,
                              struct kith_bounds *near) {
  for (int32_t rank = 0; rank < o->n_ranks; ++rank) {
    int64_t count[KITH_MAX_LISTS] = {0};
    kith_index *send = NULL, n_send;
    size_t n = 0;
    for (kith_index i = o->first[rank]; i >= 0; i = o->next[i]) {
      struct kith_bounds *cell = &bounds[o->home[i]];
      if (cell->search_radius >= 0) near[n++] = *cell, *cell = kith_nowhere;
    }
    KITH_TRY(
        kith_candidates_near(candidates, o->simulation->nodes, near, n, o->factor, &send, &n_send, count));
    for (kith_index k = 0; k < n_send; ++k)
      if (o->owner[send[k]] != rank) add_ghost(o, MADE, rank, o->owner[send[k]], 1);
    kith_free(&send);
  }
  return KITH_OK;
}

static kith_status count_laid_out(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t cells = (size_t)o->cells.n;
  struct kith_candidates candidates = {0};
  struct kith_bounds *bounds = NULL, *near = NULL;
  KITH_TRY(find_owners(o));
  count_ghosts(o);
  kith_status status = kith_candidates_gather(&candidates, nodes);
  if (status == KITH_OK) status = kith_bounds_find(&candidates, nodes, o->home, cells, &bounds);
  if (status == KITH_OK) status = kith_resize(&near, 0, cells, sizeof *near);
  if (status == KITH_OK) status = count_made(o, &candidates, bounds, near);
  kith_candidates_clear(&candidates);
  KITH_FREE(&bounds, &near);
  return status;
}

/* ---- outlines ---- */

static int region_at(const struct kith_scene *scene, const double *x, kith_status *status) {
  int last = -1;
  for (int r = 0; r < scene->n_regions && *status == KITH_OK; ++r) {
    bool holds = false;
    *status = kith_region_holds(&scene->region[r], x, &holds);
    if (holds) last = r;
  }
  return last;
}

/* Adds to a cell the nodes of a volume in it, with their spacing, by the region at x. The displacement of the
 * region is evaluated at x, although it is the place after it. */
static kith_status outline_at(struct model *o, const double *x, int64_t cell, double volume) {
  double place[NDIM], stretch = 1;
  kith_status status = KITH_OK;
  const int r = region_at(o->scene, x, &status);
  if (status != KITH_OK || r < 0) return status;
  memcpy(place, x, sizeof place);
  const double site = kith_root_dim(o->site_volume[r]);
  if (kith_region_displace(&o->scene->region[r], &o->scene->domain, 1e-3 * site, place, &stretch) != KITH_OK)
    stretch = 1;
  o->nodes[cell] += volume / (o->site_volume[r] * stretch);
  o->region[cell] = r, o->spacing[cell] = site * kith_root_dim(stretch);
  o->reach[cell] = (o->factor * o->radius[r] - 0.5) * o->spacing[cell];
  o->widest = fmax(o->widest, o->factor * o->radius[r] * o->spacing[cell]);
  return KITH_OK;
}

/* Outlines all cells, sampled in their middle or, if they are few, at more points. */
static kith_status outline(struct model *o) {
  const int per_axis = o->cells.n > 1 << 16 ? 1 : 4, samples = (int)kith_pow_dim(per_axis);
  const double neighbors = o->simulation->package.neighbors;
  double volume = 1.0 / samples;
  for (int a = 0; a < NDIM; ++a) volume *= o->cells.edge[a];
  for (int64_t c = 0; c < o->cells.n; ++c) {
    int64_t k[NDIM];
    double x[NDIM];
    kith_grid_place(o->cells.count, c, k);
    for (int s = 0; s < samples; ++s) {
      for (int a = 0, rest = s; a < NDIM; ++a, rest /= per_axis)
        x[a] = o->cells.lower[a] + o->cells.edge[a] * ((double)k[a] + (rest % per_axis + 0.5) / per_axis);
      KITH_TRY(outline_at(o, x, c, volume));
    }
    o->work[c] = o->nodes[c] * (1 + neighbors);
  }
  return KITH_OK;
}

/* Appends the neighbors of node i, in spacings, to the templates. */
static kith_status take_template(struct model *o, kith_index i, size_t *capacity, size_t *n) {
  const struct kith_rows *rows = rows_of(o);
  const double *x = o->simulation->nodes->position->f64, scale = 1 / spacing_of(o, i);
  const size_t more = rows->first[i + 1] - rows->first[i];
  KITH_TRY(kith_grow(&o->vector, capacity, *n, *n + more, NDIM * sizeof *o->vector));
  for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k, ++*n)
    for (int a = 0; a < NDIM; ++a) {
      const double d = x[(size_t)rows->node[k] * NDIM + (size_t)a] - x[(size_t)i * NDIM + (size_t)a],
                   period = o->scene->period[a];
      o->vector[*n * NDIM + (size_t)a] = scale * (period > 0 ? remainder(d, period) : d);
    }
  return KITH_OK;
}

/* Takes the neighbors of up to TEMPLATES nodes of each region, from all parts of the simulation. */
static kith_status take_templates(struct model *o) {
  const struct kith_nodes *nodes = o->simulation->nodes;
  const size_t regions = (size_t)o->scene->n_regions;
  size_t capacity = 0, n = 0;
  kith_status status = KITH_OK;
  KITH_TRY(kith_resize(&o->template, 0, regions * TEMPLATES + 1, sizeof *o->template));
  KITH_TRY(kith_resize(&o->radius, 0, regions, sizeof *o->radius));
  for (size_t t = 0; t < regions * TEMPLATES; o->template[++t] = n) {
    const int64_t part = (int64_t)(t % TEMPLATES), all = nodes->n_internal;
    const int region = (int)(t / TEMPLATES);
    for (int64_t i = all * part / TEMPLATES; i < all * (part + 1) / TEMPLATES && status == KITH_OK; ++i) {
      if (region_at(o->scene, nodes->position->f64 + (size_t)i * NDIM, &status) != region) continue;
      const double radius = nodes->search_radius->f64[i] / spacing_of(o, (kith_index)i);
      o->radius[region] = fmax(o->radius[region], radius);
      if (status == KITH_OK) status = take_template(o, (kith_index)i, &capacity, &n);
      break;
    }
  }
  return status;
}

/* ---- borders ---- */

/* The cells around a cell, in as many layers as its nodes reach. */
struct ring {
  int layers, side, n_others;
  struct {
    int s;
    uint8_t place[NDIM];
  } other[RING];       /* the cells of other ranks */
  int32_t owner[RING]; /* rank of each; -1: there is no cell */
  double reach[RING];  /* of these cells */
  uint8_t image[RING]; /* a bit for each axis along which a mirror shows the cell */
};

/* Cell k of an axis, which may be beyond its ends: then wrapped, mirrored, or -1. */
static int64_t behind(const struct model *o, int axis, int64_t k, uint8_t *image) {
  const int64_t count = o->cells.count[axis], mirrored = k < 0 ? -1 - k : 2 * count - 1 - k;
  if (k >= 0 && k < count) return k;
  if (o->cells.periodic[axis]) return ((k % count) + count) % count;
  const struct kith_boundary_ops *side = o->scene->boundary[axis].side[k < 0 ? 0 : 1];
  *image |= (uint8_t)(1 << axis);
  return side != NULL && side->mirrors && mirrored >= 0 && mirrored < count ? mirrored : -1;
}

static void look_around(const struct model *o, int64_t c, struct ring *ring) {
  const int32_t *owner = o->partition->owner, own = owner[c];
  int64_t at[NDIM], k[NDIM][SIDE], number;
  uint8_t image[NDIM][SIDE] = {0}, place[NDIM] = {0};
  ring->layers = 1, ring->n_others = 0;
  for (int a = 0; a < NDIM; ++a)
    ring->layers = KITH_MAX(ring->layers, (int)ceil(fmin(o->reach[c] / o->cells.edge[a], MOST_LAYERS)));
  ring->side = 2 * ring->layers + 1;
  kith_grid_place(o->cells.count, c, at);
  for (int a = 0; a < NDIM; ++a)
    for (int l = 0; l < ring->side; ++l) k[a][l] = behind(o, a, at[a] + l - ring->layers, &image[a][l]);
  const int n = (int)kith_pow_dim(ring->side);
  for (int s = 0; s < n; ++s) {
    bool there = true;
    number = ring->image[s] = 0;
    for (int a = NDIM - 1; a >= 0; --a) {
      there = there && k[a][place[a]] >= 0;
      number = number * o->cells.count[a] + k[a][place[a]];
      ring->image[s] |= image[a][place[a]];
    }
    ring->owner[s] = there ? owner[number] : -1;
    ring->reach[s] = there ? o->reach[number] : 0;
    if (there && ring->owner[s] != own) {
      ring->other[ring->n_others].s = s;
      memcpy(ring->other[ring->n_others++].place, place, sizeof place);
    }
    for (int a = 0; a < NDIM && ++place[a] == ring->side; ++a) place[a] = 0;
  }
}

/* The ranks that have a point as a ghost so far. A rank may have several mirror images of it: a code stands
 * for a rank and the axes along which its image is mirrored. */
struct receivers {
  int n;
  int32_t of[RING];
};

static void add_receiver(struct model *o, const struct ring *ring, int s, enum way way, int32_t own, double n,
                         struct receivers *receivers) {
  const int32_t code = ring->owner[s] * (1 << NDIM) + ring->image[s];
  if (ring->owner[s] < 0 || ring->owner[s] == own) return;
  for (int k = 0; k < receivers->n; ++k)
    if (receivers->of[k] == code) return;
  receivers->of[receivers->n++] = code;
  add_ghost(o, way, ring->owner[s], own, n);
}

/* Counts a point of cell c, at t in edges, as a ghost of the ranks whose cells are within its reach or have
 * it within theirs. */
static void count_in_reach(struct model *o, const struct ring *ring, int64_t c, const double *t, double n) {
  struct receivers receivers = {0};
  double d2[NDIM][SIDE];
  for (int a = 0; a < NDIM; ++a)
    for (int k = 0; k < ring->side; ++k) {
      const double d = k > ring->layers   ? k - ring->layers - t[a]
                       : k < ring->layers ? t[a] + ring->layers - k - 1
                                          : 0;
      d2[a][k] = d * d * o->cells.edge[a] * o->cells.edge[a];
    }
  for (int m = 0; m < ring->n_others; ++m) {
    const int s = ring->other[m].s;
    const double reach = fmax(o->reach[c], ring->reach[s]);
    double sum = 0;
    for (int a = 0; a < NDIM; ++a) sum += d2[a][ring->other[m].place[a]];
    if (sum < reach * reach) add_receiver(o, ring, s, MADE, o->partition->owner[c], n, &receivers);
  }
}

/* Counts such a point as a ghost of the ranks in whose cells the neighbors of a node there would be. */
static void count_in_rows(struct model *o, const struct ring *ring, int64_t c, const double *t, size_t one,
                          double n) {
  struct receivers receivers = {0};
  for (size_t v = o->template[one]; v < o->template[one + 1]; ++v) {
    int s = 0;
    for (int a = NDIM - 1; a >= 0; --a) {
      const int k = (int)floor(t[a] + o->vector[v * NDIM + (size_t)a] * o->spacing[c] / o->cells.edge[a]);
      s = s * ring->side + KITH_MAX(-ring->layers, KITH_MIN(ring->layers, k)) + ring->layers;
    }
    add_receiver(o, ring, s, KEPT, o->partition->owner[c], n, &receivers);
  }
}

/* Counts ghosts of an outline at points of each cell, which are at other places in each cell, so that those
 * of all cells together sample a cell finely. */
static void count_borders(struct model *o) {
  static const double golden[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
  const int samples = (int)fmin(fmax(MOST_POINTS / (double)o->cells.n, 1), 64);
  struct ring ring;
  for (int64_t c = 0; c < o->cells.n; ++c) {
    if (!(o->nodes[c] > 0)) continue;
    look_around(o, c, &ring);
    for (int s = 0; s < samples && ring.n_others > 0; ++s) {
      const int64_t number = c * samples + s;
      double t[NDIM];
      for (int a = 0; a < NDIM; ++a) t[a] = fmod((double)number * golden[a], 1);
      count_in_reach(o, &ring, c, t, o->nodes[c] / samples);
      count_in_rows(o, &ring, c, t, (size_t)o->region[c] * TEMPLATES + (size_t)(number % TEMPLATES),
                    o->nodes[c] / samples);
    }
  }
}

static void count_peers(struct model *o) {
  const size_t n = (size_t)o->n_ranks;
  for (size_t r = 0; r < n; ++r)
    for (size_t q = 0; q < n; ++q)
      for (enum way way = MADE; way < WAYS; ++way)
        o->peers[way][r] += ((o->exchanges[r * n + q] | o->exchanges[q * n + r]) >> way & 1) != 0;
}

/* ---- times ---- */

/* Finds the mean numbers, over some ranks, of neighbors that a rank talks to when lists are rebuilt, and of
 * cells that it sends to them. */
static kith_status measure_shells(const struct model *o, double *neighbors, double *cells) {
  struct kith_shell shell = {0};
  int n = 0;
  *neighbors = *cells = 0;
  for (int r = 0; r < o->n_ranks; r += (o->n_ranks + SHELLS - 1) / SHELLS, ++n) {
    KITH_TRY(kith_shell_build(&shell, o->partition, r, 1.25 * o->widest));
    *neighbors += shell.n_neighbors, *cells += (double)shell.send_first[shell.n_neighbors];
  }
  kith_shell_clear(&shell);
  *neighbors /= n, *cells /= n;
  return KITH_OK;
}

/* Sets times, messages and bytes of a step (forecast.h): a rank computes its part of the work, and for ghosts
 * the stages that treat them as nodes. */
static kith_status take_times(const struct model *o, struct kith_forecast *f) {
  const struct kith_step_cost *cost = o->cost;
  const struct kith_rehearsal *rehearsal = &cost->rehearsal;
  const struct kith_machine *machine = &cost->machine;
  const int n = o->n_ranks, cores = machine->cores > 0 ? KITH_MIN(n, machine->cores) : n;
  double work = 0, nodes = 0, neighbors, cells, slowest = 0, sum = 0;
  KITH_TRY(measure_shells(o, &neighbors, &cells));
  for (int r = 0; r < n; ++r) work += o->load[r];
  for (int64_t c = 0; c < o->cells.n; ++c) nodes += o->nodes[c];
  for (int r = 0; r < n; ++r) {
    const double part = o->load[r] / work,
                 items = (part * nodes + o->ghosts[KEPT][r]) / (nodes + cost->images),
                 messages = rehearsal->told * neighbors + rehearsal->created * o->peers[MADE][r] +
                            rehearsal->kept * o->peers[KEPT][r],
                 bytes = rehearsal->told_bytes * neighbors + rehearsal->cell_bytes * cells +
                         rehearsal->created_bytes * fmax(o->ghosts[MADE][r], o->ghosts[KEPT][r]) +
                         rehearsal->kept_bytes * o->ghosts[KEPT][r],
                 seconds =
                     cost->seconds * ((1 - cost->ghost_stage_part) * part + cost->ghost_stage_part * items) +
                     messages * machine->latency + bytes / machine->bandwidth;
    slowest = fmax(slowest, seconds), sum += seconds;
    f->messages += messages / n, f->bytes += bytes / n;
  }
  f->seconds = fmax(slowest, sum / cores) + rehearsal->collectives * machine->collective * ceil(log2(n)) +
               2 * rehearsal->balance_checks * 8 * (double)o->cells.n / machine->bandwidth;
  f->efficiency = cost->seconds / (cores * f->seconds);
  return KITH_OK;
}

/* ---- forecasts ---- */

static kith_status allocate(struct model *o) {
  const size_t cells = (size_t)o->cells.n, n = (size_t)o->n_ranks;
  KITH_TRY(kith_resize(&o->nodes, 0, 2 * cells, sizeof *o->nodes));
  KITH_TRY(kith_resize(&o->load, 0, (1 + 2 * WAYS) * n, sizeof *o->load));
  KITH_TRY(kith_resize(&o->exchanges, 0, n * n, 1));
  o->work = o->nodes + cells;
  for (size_t way = MADE; way < WAYS; ++way)
    o->ghosts[way] = o->load + (1 + way) * n, o->peers[way] = o->load + (1 + WAYS + way) * n;
  return KITH_OK;
}

/* Maps cells to ranks. UNSUPPORTED, at once, where that would take the partitioner minutes. */
static kith_status map(struct model *o, const char *partitioner) {
  char name[32];
  snprintf(name, sizeof name, "%.*s", (int)strcspn(partitioner, ":"), partitioner);
  const struct kith_partitioner_ops *ops = kith_partitioner_find(name);
  const double seconds = ops != NULL ? ops->seconds_per_cell * (double)o->cells.n * log2(o->n_ranks) : 0;
  if (seconds > MOST_MAP_SECONDS)
    KITH_FAIL(UNSUPPORTED, "%s: each rank would take about %.0f s for a map of %lld cells; not planned", name,
              seconds, (long long)o->cells.n);
  KITH_TRY(kith_partition_create(&o->partition, &o->cells, o->n_ranks, partitioner));
  return kith_partition_converge(o->partition, o->work);
}

static kith_status predict(struct model *o, const char *partitioner, struct kith_forecast *f) {
  const double n = o->n_ranks;
  KITH_TRY(map(o, partitioner));
  if (o->spacing == NULL)
    KITH_TRY(count_laid_out(o));
  else
    count_borders(o);
  count_peers(o);
  if (!(o->cost->rehearsal.kept > 0)) /* no ghost is culled */
    o->ghosts[KEPT] = o->ghosts[MADE], o->peers[KEPT] = o->peers[MADE];
  *f = (struct kith_forecast){
      .cells = (double)o->cells.n,
      .imbalance = kith_partition_loads(o->partition, o->partition->owner, o->work, o->load)};
  for (int r = 0; r < o->n_ranks; ++r) {
    f->made += o->ghosts[MADE][r] / n;
    f->ghosts += o->ghosts[KEPT][r] / n, f->most_ghosts = fmax(f->most_ghosts, o->ghosts[KEPT][r]);
    f->peers += o->peers[KEPT][r] / n, f->most_peers = fmax(f->most_peers, o->peers[KEPT][r]);
  }
  return take_times(o, f);
}

static void clear(struct model *o) {
  KITH_FREE(&o->nodes, &o->load, &o->exchanges, &o->home, &o->owner, &o->first, &o->region, &o->spacing,
            &o->template, &o->vector, &o->radius, &o->site_volume);
  kith_partition_destroy(&o->partition);
}

/* Makes the cells of an outlined scene, and estimates what is in them. */
static kith_status outline_cells(struct model *o) {
  const double neighbors = o->simulation->package.neighbors;
  double sites, least = INFINITY;
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) periodic[a] = o->scene->period[a] > 0;
  KITH_TRY(take_templates(o));
  KITH_TRY(kith_resize(&o->site_volume, 0, (size_t)o->scene->n_regions, sizeof *o->site_volume));
  KITH_TRY(kith_initial_conditions_outline(o->scene, o->site_volume, &sites));
  for (int r = 0; r < o->scene->n_regions; ++r) least = KITH_MIN(least, o->site_volume[r]);
  KITH_TRY(kith_cells_init(&o->cells, o->scene->domain.lower, o->scene->domain.upper, periodic,
                           0.5 * kith_root_dim(neighbors / kith_ball() * least),
                           KITH_MIN((int64_t)o->scene->partition.cells * o->n_ranks, 1 << 22)));
  KITH_TRY(allocate(o));
  KITH_TRY(kith_resize(&o->region, 0, (size_t)o->cells.n, sizeof *o->region));
  KITH_TRY(kith_resize(&o->spacing, 0, 2 * (size_t)o->cells.n, sizeof *o->spacing));
  o->reach = o->spacing + o->cells.n;
  return outline(o);
}

kith_status kith_forecast_cells(const struct kith_simulation *m, int n_ranks, struct kith_cells *cells) {
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->period[a] > 0;
  return kith_decomposition_cells(cells, m->nodes, &m->scene->domain, periodic,
                                  (int64_t)m->scene->partition.cells * n_ranks);
}

kith_status kith_forecast_ranks(const struct kith_scene *scene, const struct kith_simulation *m,
                                const struct kith_cells *cells, const struct kith_step_cost *cost,
                                int n_ranks, const char *partitioner, struct kith_forecast *out) {
  struct model o = {.simulation = m,
                    .scene = scene,
                    .cost = cost,
                    .n_ranks = n_ranks,
                    .factor = (m->connectivity->built.overlap ? 2 : 1) * m->nodes->longest};
  if (n_ranks > MOST_RANKS) KITH_FAIL(BAD_INPUT, "no forecast for more than %d ranks", MOST_RANKS);
  if (scene->partition.recompute)
    KITH_FAIL(BAD_INPUT, "partition.ghosts: there is no forecast of recompute; exchange has one");
  if (cells != NULL) o.cells = *cells;
  kith_status status = cells == NULL ? outline_cells(&o) : allocate(&o);
  if (cells != NULL && status == KITH_OK) status = fill_cells(&o);
  if (status == KITH_OK) status = predict(&o, partitioner, out);
  clear(&o);
  return status;
}
