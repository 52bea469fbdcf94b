/* test_stretch.c - supports that are ellipsoids. Oracle: the same nodes with spherical supports: if both
 * nodes and supports are strained by powers of 2, rows, supports and densities are bitwise identical, and
 * pressure forces are those of the strained gradient. */
#include "tests/unit/physics/sph_world.h"

static void strain(struct world *w, const double *by) {
  double volume = 1;
  for (int a = 0; a < NDIM; ++a) {
    volume *= by[a];
    w->boundaries.boundary[a]->upper = w->length[a] *= by[a];
    for (int i = 0; i < w->nodes->n_internal; ++i) w->nodes->position->f64[i * NDIM + a] *= by[a];
  }
  for (int i = 0; i < w->nodes->n_internal; ++i) w->hydro.mass->f64[i] *= volume;
  CHECK_OK(kith_nodes_stretch(w->nodes, by));
}

static void rest(struct world *w) {
  for (int i = 0; i < w->nodes->n_internal * NDIM; ++i) w->hydro.velocity->f64[i] = 0;
}

static void against_spheres(const char *search, const double *by) {
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_NONE, KITH_TRAVERSE_GATHER, true, 0, 0,
                           KITH_BALSARA_NONE};
  const int cells[] = {NDIM == 1 ? 24 : NDIM == 2 ? 9 : 5, NDIM == 2 ? 9 : 5, 5};
  struct world w[2];
  for (int k = 0; k < 2; ++k) {
    world_create(&w[k], cells, PERIODIC, 0.3, &m, 7);
    world_package(&w[k], "sph", &m, "conduction=1"); /* so that both evaluate all fields */
    rest(&w[k]);
    if (k == 1) strain(&w[k], by);
    kith_search_destroy(&w[k].search);
    CHECK_OK(kith_search_create(&w[k].search, kith_search_find(search), w[k].nodes));
    w[k].it.search = w[k].search;
    for (int again = 0; again < 3; ++again) { /* supports may outgrow search radii at first */
      const kith_status status = world_evaluate(&w[k]);
      CHECK(status == KITH_OK || status == KITH_OUTGROWN);
    }
    CHECK_OK(world_evaluate(&w[k]));
  }
  const struct kith_rows *rows[2] = {&w[0].connectivity->rows, &w[1].connectivity->rows};
  for (kith_index i = 0; i < w[0].nodes->n_internal; ++i) {
    CHECK(rows[0]->first[i + 1] == rows[1]->first[i + 1]);
    CHECK(w[0].nodes->support->f64[i] == w[1].nodes->support->f64[i]);
    CHECK(w[0].hydro.density->f64[i] == w[1].hydro.density->f64[i]);
    for (int a = 0; a < NDIM; ++a) {
      const double round = w[0].hydro.acceleration->f64[i * NDIM + a],
                   strained = w[1].hydro.acceleration->f64[i * NDIM + a] * by[a];
      CHECK(fabs(strained - round) <= 1e-11 * (1 + fabs(round)));
    }
  }
  for (int k = 0; k < 2; ++k) world_destroy(&w[k]);
}

static void refusals(void) {
  const struct method m = {KITH_KERNEL_cubic, KITH_VISCOSITY_NONE, KITH_TRAVERSE_GATHER, true, 0, 0,
                           KITH_BALSARA_NONE};
  const int cells[] = {6, 6, 6};
  const double flat[] = {0.5, 1, 1};
  struct world w;
  world_create(&w, cells, OPEN, 0, &m, 1);
  CHECK(kith_nodes_stretch(w.nodes, flat) == KITH_BAD_INPUT);
  world_package(&w, "sph", &m, "stretch=[2,1,1]");
  CHECK(w.nodes->stretch[0] == 2);
  const struct kith_requirements overlap = {.overlap = true};
  CHECK_OK(kith_search_update(w.search));
  CHECK(kith_connectivity_build(w.connectivity, w.nodes, w.search, overlap, NULL, NULL) == KITH_UNSUPPORTED);
  world_destroy(&w);
}

int main(void) {
  static const double by[][3] = {{2, 1, 1}, {1, 4, 2}, {4, 4, 4}};
  const struct kith_search_ops *const *all = kith_search_all();
  for (int s = 0; all[s] != NULL; ++s)
    for (int k = 0; k < 3; ++k)
      if (NDIM < 3 || k == s % 3) against_spheres(all[s]->name, by[k]); /* in 3-D fewer, to save time */
  refusals();
  return check_failed();
}
