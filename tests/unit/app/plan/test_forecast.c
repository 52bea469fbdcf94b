/* test_forecast.c - ghosts and imbalance that the plan predicts for ranks. Oracle: brute force over all
 * nodes, images and ranks. A plan from a smaller simulation is compared with one from the scene itself.
 * tests/mpi/planned.sh compares plans with runs. */
#include "tests/check.h"
#include "app/plan/forecast.h"
#include "lib/core/vec.h"
#include "lib/domain/decomposition.h"
#include <math.h>
#include <string.h>

static const char text[] =
    "scene: box\n"
    "dimension: %d\n"
    "resolution: %d\n"
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"
    "boundaries: {x: %s, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions: [{material: gas, lattice: cubic, density: 1, pressure: 1, jitter: 0.2}]\n"
    "connectivity: {cull: false}\n"
    "until: 1\n";

static const struct kith_step_cost cost = {
    .seconds = 1, .rehearsal = {.kept = 1}, .machine = {.bandwidth = 1}};

struct world {
  struct kith_scene *scene;
  struct kith_simulation *simulation;
};

/* A forecast with cells of the supports at the start; `from` has the nodes: of the scene itself or of another
 * one. */
static kith_status forecast(const struct world *w, const struct world *from, int n, const char *partitioner,
                            struct kith_forecast *f) {
  struct kith_cells cells;
  CHECK_OK(kith_forecast_cells(from->simulation, n, &cells));
  return kith_forecast_ranks(w->scene, from->simulation, from == w ? &cells : NULL, &cost, n, partitioner, f);
}

static void make(struct world *w, const char *x, const char *setting) {
  char scene[1024];
  const int resolution = NDIM == 1 ? 40 : NDIM == 2 ? 16 : 8;
  const char *overrides[] = {"regions.0.jitter=0", setting}; /* with a setting: a lattice */
  snprintf(scene, sizeof scene, text, NDIM, resolution, x);
  CHECK_OK(kith_scene_parse(&w->scene, "box", scene, strlen(scene), setting != NULL ? 2 : 0, overrides));
  CHECK_OK(kith_simulation_create(&w->simulation, w->scene, NULL, NULL, false));
  CHECK_OK(kith_simulation_start(w->simulation));
}

static void clear(struct world *w) {
  kith_simulation_destroy(&w->simulation);
  kith_scene_destroy(&w->scene);
}

/* The predicted map: updated by the work of rows until it does not change. */
static struct kith_partition *map_of(const struct kith_simulation *m, struct kith_cells *cells, int n_ranks) {
  struct kith_partition *partition = NULL;
  bool periodic[NDIM], changed = true;
  for (int a = 0; a < NDIM; ++a) periodic[a] = kith_boundary_wraps(m->scene->boundary[a].side[0]);
  CHECK_OK(kith_decomposition_cells(cells, m->nodes, &m->scene->domain, periodic,
                                    (int64_t)m->scene->partition.cells * n_ranks));
  CHECK_OK(kith_partition_create(&partition, cells, n_ranks, "kd"));
  double *work = NULL;
  CHECK_OK(kith_resize(&work, 0, (size_t)cells->n, sizeof *work));
  for (kith_index i = 0; i < m->nodes->n_internal; ++i) {
    const size_t *first = m->connectivity->rows.first;
    work[kith_cells_of(cells, m->nodes->position->f64 + (size_t)i * NDIM)] +=
        (double)(first[i + 1] - first[i]) + 1;
  }
  for (int k = 0; changed && k < 20; ++k) CHECK_OK(kith_partition_update(partition, work, &changed));
  kith_free(&work);
  return partition;
}

/* Is an image at y, with this search radius, a neighbor of a node of the rank? */
static bool is_near(const struct kith_simulation *m, const int32_t *owner, int rank, const double *y,
                    double search_radius) {
  const struct kith_nodes *nodes = m->nodes;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double r = fmax(search_radius, nodes->search_radius->f64[i]);
    if (owner[i] == rank && kith_distance2(nodes->position->f64 + (size_t)i * NDIM, y) <= r * r) return true;
  }
  return false;
}

/* The boxes around the nodes of each cell, and their largest search radii; 0: no nodes. */
struct boxes {
  struct kith_cells cells;
  struct kith_partition *map;
  struct kith_box *box;
  double *radius;
};

static void make_boxes(struct boxes *b, const struct kith_simulation *m, int n_ranks) {
  const struct kith_nodes *nodes = m->nodes;
  b->map = map_of(m, &b->cells, n_ranks);
  CHECK_OK(kith_resize(&b->box, 0, (size_t)b->cells.n, sizeof *b->box));
  CHECK_OK(kith_resize(&b->radius, 0, (size_t)b->cells.n, sizeof *b->radius));
  for (int64_t c = 0; c < b->cells.n; ++c) b->box[c] = kith_box_empty();
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    const int64_t c = kith_cells_of(&b->cells, x);
    kith_box_include(&b->box[c], x);
    b->radius[c] = fmax(b->radius[c], nodes->search_radius->f64[i]);
  }
}

static void clear_boxes(struct boxes *b) {
  kith_partition_destroy(&b->map);
  KITH_FREE(&b->box, &b->radius);
}

/* Is an image at y, with this search radius, sent to the rank (halo.h)? */
static bool is_sent(const struct boxes *b, int rank, const double *y, double search_radius) {
  for (int64_t c = 0; c < b->cells.n; ++c) {
    const double r = fmax(search_radius, b->radius[c]);
    double d2 = 0;
    if (b->map->owner[c] != rank || !(b->radius[c] > 0)) continue;
    for (int a = 0; a < NDIM; ++a) {
      const double gap = fmax(fmax(b->box[c].lower[a] - y[a], y[a] - b->box[c].upper[a]), 0);
      d2 += gap * gap;
    }
    if (d2 <= r * r) return true;
  }
  return false;
}

/* Counts images of j that the rank needs, or is sent: shifted by one length or, along x between walls,
 * mirrored. */
static double count_of(const struct kith_simulation *m, const int32_t *owner, const struct boxes *sent,
                       int rank, kith_index j, bool walls) {
  const double *x = m->nodes->position->f64 + (size_t)j * NDIM, radius = m->nodes->search_radius->f64[j];
  double n = 0, y[NDIM];
  int shift[NDIM];
  for (int a = 0; a < NDIM; ++a) shift[a] = -1;
  for (int a = 0; a < NDIM;) {
    for (int k = 0; k < NDIM; ++k) y[k] = x[k] + shift[k];
    if (walls && shift[0] != 0) y[0] = shift[0] < 0 ? -x[0] : 2 - x[0];
    n += sent != NULL ? is_sent(sent, rank, y, radius) : is_near(m, owner, rank, y, radius);
    for (a = 0; a < NDIM && ++shift[a] > 1; ++a) shift[a] = -1;
  }
  return n;
}

/* The mean number of ghosts per rank: every image of every node against every node, or every box. */
static double brute_ghosts(const struct kith_simulation *m, int n_ranks, bool walls, bool made) {
  struct boxes boxes = {0};
  int32_t *owner = NULL;
  double n = 0;
  make_boxes(&boxes, m, n_ranks);
  CHECK_OK(kith_resize(&owner, 0, (size_t)m->nodes->n_internal, sizeof *owner));
  for (kith_index j = 0; j < m->nodes->n_internal; ++j)
    owner[j] = boxes.map->owner[kith_cells_of(&boxes.cells, m->nodes->position->f64 + (size_t)j * NDIM)];
  for (kith_index j = 0; j < m->nodes->n_internal; ++j)
    for (int r = 0; r < n_ranks; ++r)
      if (owner[j] != r) n += count_of(m, owner, made ? &boxes : NULL, r, j, walls);
  clear_boxes(&boxes);
  kith_free(&owner);
  return n / n_ranks;
}

static void check_ghosts(bool walls) {
  for (int n = 1; n <= 5; n += 2) {
    struct world w = {0};
    struct kith_forecast f;
    make(&w, walls ? "reflecting" : "periodic", NULL);
    CHECK_OK(forecast(&w, &w, n, "kd", &f));
    CHECK_CLOSE(f.ghosts, brute_ghosts(w.simulation, n, walls, false), 1e-9);
    CHECK(f.most_ghosts >= f.ghosts);
    CHECK(f.imbalance >= 1 && f.most_peers < n && f.peers <= f.most_peers && (n == 1) == (f.peers == 0));
    clear(&w);
  }
}

/* The supports on the left are half as large as those on the right, whose ranks need nodes that need none of
 * theirs. */
static void check_made(bool walls) {
  const double spacing = NDIM == 1 ? 0.02 : NDIM == 2 ? 0.05 : 0.1;
  char setting[256];
  snprintf(setting, sizeof setting,
           "regions=[{material: gas, where: {x: [0, 0.5]}, lattice: cubic, density: 1, pressure: 1, "
           "spacing: %g}, {material: gas, where: {x: [0.5, 1]}, lattice: cubic, density: 1, pressure: 1, "
           "spacing: %g}]",
           spacing, 2 * spacing);
  for (int n = 2; n <= 5; ++n) {
    struct world w = {0};
    struct kith_forecast f;
    make(&w, walls ? "reflecting" : "periodic", setting);
    CHECK_OK(forecast(&w, &w, n, "kd", &f));
    CHECK_CLOSE(f.made, brute_ghosts(w.simulation, n, walls, true), 1e-9);
    CHECK(f.made >= f.ghosts);
    clear(&w);
  }
}

static void check_refused(void) {
  struct world w = {0};
  struct kith_forecast f;
  make(&w, "periodic", NULL);
  CHECK_STATUS(KITH_BAD_INPUT, forecast(&w, &w, 2, "kdd", &f));
  CHECK_STATUS(KITH_BAD_INPUT, forecast(&w, &w, 16385, "kd", &f));
  clear(&w);
}

/* A plan from a smaller simulation, whose nodes have the same neighbors, against one from the scene
 * itself. */
static void check_coarse_plan(const char *x, int n, double ghosts, double most_ghosts) {
  const char *setting = NDIM == 1 ? "resolution=200" : NDIM == 2 ? "resolution=60" : "resolution=20";
  struct world w = {0}, coarse = {0};
  struct kith_forecast f, from_coarse;
  make(&w, x, setting);
  make(&coarse, x, "scene=coarse");
  CHECK_OK(forecast(&w, &w, n, "kd", &f));
  CHECK_OK(forecast(&w, &coarse, n, "kd", &from_coarse));
  CHECK_CLOSE(from_coarse.ghosts, f.ghosts, ghosts * f.ghosts);
  CHECK_CLOSE(from_coarse.most_ghosts, f.most_ghosts, most_ghosts * f.most_ghosts);
  CHECK_CLOSE(from_coarse.imbalance, f.imbalance, 0.1);
  CHECK(fabs(from_coarse.peers - f.peers) <= 1);
  clear(&w), clear(&coarse);
}

int main(void) {
  /* Cells of 8 ranks cut the lattice evenly; borders between 3 ranks have steps, which the smaller simulation
   * does not show. */
  check_coarse_plan("periodic", 8, 0.02, 0.15);
  check_coarse_plan("reflecting", 8, 0.02, 0.15);
  check_coarse_plan("periodic", 3, 0.25, 0.25);
  check_ghosts(false);
  check_ghosts(true);
  check_made(false);
  check_made(true);
  check_refused();
  return check_failed();
}
