/* What the plan predicts for ranks, against brute force over all nodes, images and ranks.
 * tests/mpi/planned.sh compares it with runs. */
#include "tests/check.h"
#include "app/plan/forecast.h"
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
  for (int k = 0; changed && k < 20; ++k) CHECK_OK(kith_partition_update(partition, work, NULL, &changed));
  kith_free(&work);
  return partition;
}

/* Does a node of the rank reach y, or y it? */
static bool needed(const struct kith_simulation *m, const struct kith_partition *map, int rank,
                   const double *y, double search_radius) {
  const struct kith_nodes *nodes = m->nodes;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    const double r = fmax(search_radius, nodes->search_radius->f64[i]);
    if (kith_distance2(x, y) <= r * r && map->owner[kith_cells_of(map->cells, x)] == rank) return true;
  }
  return false;
}

/* Images of j across the faces: shifted by n lengths, or, in x of a box with walls, mirrored. */
static double count_of(const struct kith_simulation *m, const struct kith_partition *map, int rank,
                       kith_index j, bool walls) {
  const double *x = m->nodes->position->f64 + (size_t)j * NDIM;
  double n = 0, y[NDIM];
  int shift[NDIM];
  for (int a = 0; a < NDIM; ++a) shift[a] = -1;
  for (int a = 0; a < NDIM;) {
    for (int k = 0; k < NDIM; ++k) y[k] = x[k] + shift[k];
    if (walls && shift[0] != 0) y[0] = shift[0] < 0 ? -x[0] : 2 - x[0];
    n += needed(m, map, rank, y, m->nodes->search_radius->f64[j]);
    for (a = 0; a < NDIM && ++shift[a] > 1; ++a) shift[a] = -1;
  }
  return n;
}

static double brute_kept(const struct kith_simulation *m, int n_ranks, bool walls) {
  struct kith_cells cells;
  struct kith_partition *map = map_of(m, &cells, n_ranks);
  double n = 0;
  for (kith_index j = 0; j < m->nodes->n_internal; ++j)
    for (int r = 0; r < n_ranks; ++r)
      if (map->owner[kith_cells_of(map->cells, m->nodes->position->f64 + (size_t)j * NDIM)] != r)
        n += count_of(m, map, r, j, walls);
  kith_partition_destroy(&map);
  return n / n_ranks;
}

static void predict(struct world *w, int n_ranks, double lists, struct kith_step_traffic *traffic,
                    struct kith_forecast *f) {
  CHECK_OK(kith_step_traffic(w->simulation, lists, traffic));
  CHECK_OK(kith_forecast_ranks(w->simulation, n_ranks, "kd", traffic, f));
}

static void check_ghosts(bool walls) {
  for (int n = 1; n <= 5; n += 2) {
    struct world w = {0};
    struct kith_step_traffic traffic;
    struct kith_forecast f;
    make(&w, walls ? "reflecting" : "periodic", NULL);
    predict(&w, n, 1, &traffic, &f);
    CHECK_CLOSE(f.kept, brute_kept(w.simulation, n, walls), 1e-12);
    CHECK(f.made >= f.kept && f.most_made >= f.made && f.imbalance >= 1 && f.most_peers < n);
    if (n == 1) CHECK(f.made == 0 && f.messages == 0 && f.bytes == 0 && f.most_peers == 0);
    clear(&w);
  }
}

/* Two ranks are peers of each other: of every list one message with ghosts and one back, and one for every
 * refresh. sph: density and pressure once. */
static void check_traffic(void) {
  struct world w = {0};
  struct kith_step_traffic h, lasting;
  struct kith_forecast f;
  make(&w, "periodic", NULL);
  predict(&w, 2, 1, &h, &f);
  CHECK(h.culls && h.lists == 1 && h.refreshes == 1);
  CHECK_CLOSE(f.messages, 2 + h.refreshes, 1e-12);
  CHECK_CLOSE(f.bytes, f.made * (h.creation_bytes + 1) + f.kept * h.refresh_bytes, 1e-12 * f.bytes);
  CHECK(w.simulation->hydro.halo == NULL);
  clear(&w);
  make(&w, "periodic", "connectivity.rebuild=displacement");
  CHECK_OK(kith_step_traffic(w.simulation, 0.25, &lasting));
  /* What is refreshed where no lists are made: position, support, velocity and energy more. */
  CHECK_CLOSE(lasting.refreshes, h.refreshes + 0.75, 1e-12);
  CHECK_CLOSE(lasting.refresh_bytes, h.refresh_bytes + 0.75 * 8 * (2 * NDIM + 2), 1e-12 * h.refresh_bytes);
  clear(&w);
  make(&w, "periodic", "connectivity.cull=false");
  predict(&w, 2, 1, &h, &f);
  CHECK(!h.culls && f.kept == f.made);
  CHECK_CLOSE(f.messages, 1 + h.refreshes, 1e-12);
  clear(&w);
}

static void check_refused(void) {
  struct world w = {0};
  struct kith_step_traffic h;
  struct kith_forecast f;
  make(&w, "periodic", NULL);
  CHECK_OK(kith_step_traffic(w.simulation, 1, &h));
  CHECK_STATUS(KITH_BAD_INPUT, kith_forecast_ranks(w.simulation, 2, "kdd", &h, &f));
  CHECK_STATUS(KITH_BAD_INPUT, kith_forecast_ranks(w.simulation, 16385, "kd", &h, &f));
  clear(&w);
}

int main(void) {
  check_ghosts(false);
  check_ghosts(true);
  check_traffic();
  check_refused();
  return check_failed();
}
