/* test_tubes.c - shipped shock tubes are the problems that they are named after: pressure and velocity
 * between the waves, and shock speeds, agree with tables computed elsewhere; and nothing from the ends
 * reaches their windows. */
#include <string.h>
#include "app/scene/scene.h"
#include "tests/check.h"
#include "tests/unit/exact_settings.h"

struct tube {
  const char *name;
  /* between the waves; speed of the shock that ops->shock returns; 0: none */
  double pressure, velocity, shock;
};

static const struct tube tubes[] = {
    {"sod", .303130, .927453, 1.75216},
    {"sph-sod", .429346, .673103, 1.48474},
    {"lax", 2.4661, 1.52872, 2.47932},
    {"toro-1", .4662936, 1.360906, 2.153234},
    {"toro-2", 1.89387e-3, 0, 0},
    {"toro-3", 460.894, 19.5975, 23.5175},
    {"toro-4", 46.095, -6.19633, -7.437476},
    {"toro-5", 1691.65, 8.68977, 12.2508},
    {"leblanc", 5.15578e-4, .621839, .829118},
    {"free-expansion", 0, 0, 0},
    {"water-tube", .4557602, .2316035, 1.967415}, /* by quadrature of isentropes */
    {"tait-tube", .4607264, .2364020, 1.948911},
    {"isothermal-tube", .3457801, 1.061952, 1.663202},
};

/* Returns NULL if the scene is refused. */
static struct kith_scene *read(const char *name, const char *more) {
  char path[512], dimension[32];
  snprintf(path, sizeof path, KITH_INPUTS "/%s.yaml", name);
  snprintf(dimension, sizeof dimension, "dimension=%d", NDIM);
  const char *const overrides[] = {dimension, more};
  struct kith_scene *scene = NULL;
  kith_scene_read(&scene, path, 2, overrides);
  return scene;
}

/* Sound from an end cannot have reached the window; a wall causes none in gas at rest. */
static void check_window(const struct kith_scene *s) {
  const struct kith_window *w = &s->exact.window;
  const struct exact_parameters held = exact_parameters_of(s->exact.ops, s->exact.settings), *p = &held;
  if (!isfinite(w->x[0])) return;
  for (int k = 0; k < 2; ++k) {
    const double sign = k == 0 ? 1 : -1, sound = sqrt(p->gamma[k] * p->pressure[k] / p->density[k]);
    const bool wall = s->boundary[0].side[k] != NULL;
    if (wall && p->velocity[k] == 0) continue;
    const double end = k == 0 ? s->domain.lower[0] : s->domain.upper[0];
    const double reached = end + (p->velocity[k] + sign * sound) * s->until;
    CHECK(sign * (w->x[k] - reached) >= 0);
  }
}

static void check_tube(const struct tube *tube) {
  struct kith_scene *scene = read(tube->name, "output.plot=false");
  CHECK(scene != NULL);
  if (scene == NULL) return;
  void *solution = NULL;
  CHECK(strcmp(scene->name, tube->name) == 0);
  CHECK_OK(kith_exact_create(&solution, scene->exact.ops, scene->exact.settings));
  const struct kith_exact_star star = kith_exact_riemann.star(solution);
  CHECK_CLOSE(star.pressure, tube->pressure, 1e-5 * tube->pressure); /* tables have five digits or more */
  if (tube->pressure > 0) CHECK_CLOSE(star.velocity, tube->velocity, 1e-5 * fabs(tube->velocity) + 1e-13);
  const double shock = scene->exact.ops->shock(solution, scene->until);
  const double wanted =
      tube->shock == 0 ? 0
                       : exact_parameters_of(scene->exact.ops, scene->exact.settings).interface_position +
                             tube->shock * scene->until;
  CHECK_CLOSE(shock, wanted, 1e-5 * fabs(tube->shock) * scene->until);
  check_window(scene);
  kith_free(&solution);
  kith_scene_destroy(&scene);
}

/* Without gas on one side there is a vacuum, if that side is open; with walls no exact solution is
 * derived. */
static void vacuum(void) {
  struct kith_scene *s = read("free-expansion", "regions.0.where.x=[-0.5, 0]");
  CHECK(s == NULL); /* there is also a gap before the wall on the left */
  s = read("free-expansion", "boundaries.x=reflecting");
  CHECK(s == NULL); /* gas would return from the wall */
  s = read("free-expansion", "regions.0.velocity=[0.5,0,0]");
  CHECK(s != NULL);
  if (s == NULL) return;
  const struct exact_parameters held = exact_parameters_of(s->exact.ops, s->exact.settings), *p = &held;
  void *solution = NULL;
  CHECK(p->density[0] == 1 && p->velocity[0] == 0.5 && p->density[1] == 0 && p->pressure[1] == 0);
  CHECK_OK(kith_exact_create(&solution, s->exact.ops, s->exact.settings));
  CHECK_CLOSE(kith_exact_riemann.star(solution).tail[0], 0.5 + 5 * sqrt(1.4), 1e-13); /* 2 c / (gamma - 1) */
  kith_free(&solution);
  kith_scene_destroy(&s);
}

int main(void) {
  for (size_t k = 0; k < sizeof tubes / sizeof tubes[0]; ++k) check_tube(&tubes[k]);
  vacuum();
  return check_failed();
}
