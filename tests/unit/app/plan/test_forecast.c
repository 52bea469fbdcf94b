/* What the plan predicts for ranks, against brute force over all nodes, images and ranks.
 * tests/mpi/planned.sh compares it with runs. */
#include "tests/check.h"
#include "app/plan/forecast.h"
#include "lib/domain/cell_bounds.h"
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
    "until: 1\n";

struct world {
  struct kith_scene *scene;
  struct kith_simulation *simulation;
};

static void make(struct world *w, const char *x, const char *setting) {
  char scene[1024];
  const int resolution = NDIM == 1 ? 40 : NDIM == 2 ? 16 : 8;
  const char *overrides[] = {setting};
  snprintf(scene, sizeof scene, text, NDIM, resolution, x);
  CHECK_OK(kith_scene_parse(&w->scene, "box", scene, strlen(scene), setting != NULL, overrides));
  CHECK_OK(kith_simulation_create(&w->simulation, w->scene, NULL, false));
  CHECK_OK(kith_simulation_start(w->simulation));
}

static void clear(struct world *w) {
  kith_simulation_destroy(&w->simulation);
  kith_scene_destroy(&w->scene);
}

/* The predicted map: by the work of rows, until it stays. */
static struct kith_partition *map_of(const struct kith_simulation *m, struct kith_cells *cells, int n_ranks) {
  struct kith_partition *partition = NULL;
  bool periodic[NDIM], changed = true;
  for (int a = 0; a < NDIM; ++a) periodic[a] = kith_boundary_wraps(m->scene->boundary[a].lower);
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

/* Is y near a cell of the rank? */
static bool is_near(const struct kith_partition *map, const struct kith_cell_bounds *bounds, int rank,
                    const double *y, double search_radius) {
  for (int64_t c = 0; c < map->cells->n; ++c)
    if (map->owner[c] == rank && kith_cell_bounds_near(&bounds[c], y, search_radius, 1)) return true;
  return false;
}

/* Images of j across the faces: shifted by n lengths, or, in x of a box with walls, mirrored. */
static double count_of(const struct kith_simulation *m, const struct kith_partition *map,
                       const struct kith_cell_bounds *bounds, int rank, kith_index j, bool walls) {
  const double *x = m->nodes->position->f64 + (size_t)j * NDIM;
  double n = 0, y[NDIM];
  int shift[NDIM];
  for (int a = 0; a < NDIM; ++a) shift[a] = -1;
  for (int a = 0; a < NDIM;) {
    for (int k = 0; k < NDIM; ++k) y[k] = x[k] + shift[k];
    if (walls && shift[0] != 0) y[0] = shift[0] < 0 ? -x[0] : 2 - x[0];
    n += is_near(map, bounds, rank, y, m->nodes->search_radius->f64[j]);
    for (a = 0; a < NDIM && ++shift[a] > 1; ++a) shift[a] = -1;
  }
  return n;
}

/* Every image of every node against every cell. */
static double brute_ghosts(const struct kith_simulation *m, int n_ranks, bool walls) {
  struct kith_cells cells;
  struct kith_partition *map = map_of(m, &cells, n_ranks);
  struct kith_cell_bounds *bounds = NULL;
  int64_t *home = NULL;
  double n = 0;
  CHECK_OK(kith_resize(&home, 0, (size_t)m->nodes->n_internal, sizeof *home));
  for (kith_index j = 0; j < m->nodes->n_internal; ++j)
    home[j] = kith_cells_of(&cells, m->nodes->position->f64 + (size_t)j * NDIM);
  CHECK_OK(kith_cell_bounds_of_nodes(m->nodes, home, (size_t)cells.n, &bounds));
  for (kith_index j = 0; j < m->nodes->n_internal; ++j)
    for (int r = 0; r < n_ranks; ++r)
      if (map->owner[home[j]] != r) n += count_of(m, map, bounds, r, j, walls);
  kith_partition_destroy(&map);
  kith_free(&bounds);
  kith_free(&home);
  return n / n_ranks;
}

static void check_ghosts(bool walls) {
  for (int n = 1; n <= 5; n += 2) {
    struct world w = {0};
    struct kith_forecast f;
    make(&w, walls ? "reflecting" : "periodic", NULL);
    CHECK_OK(kith_forecast_ranks(w.simulation, n, "kd", &f));
    CHECK_CLOSE(f.ghosts, brute_ghosts(w.simulation, n, walls), 1e-9);
    CHECK(f.most_ghosts >= f.ghosts);
    CHECK(f.imbalance >= 1 && f.most_peers < n && f.peers <= f.most_peers && (n == 1) == (f.peers == 0));
    clear(&w);
  }
}

static void check_refused(void) {
  struct world w = {0};
  struct kith_forecast f;
  make(&w, "periodic", NULL);
  CHECK_STATUS(KITH_BAD_INPUT, kith_forecast_ranks(w.simulation, 2, "kdd", &f));
  CHECK_STATUS(KITH_BAD_INPUT, kith_forecast_ranks(w.simulation, 16385, "kd", &f));
  clear(&w);
}

int main(void) {
  check_ghosts(false);
  check_ghosts(true);
  check_refused();
  return check_failed();
}
