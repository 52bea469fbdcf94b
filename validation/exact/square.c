/* square: gas of one pressure and one velocity u that is denser inside of a box (a slab, a square, a cube)
 * than outside; an exact solution of Euler's equations, carried along and brought back by a period > 0.
 *
 *   rho = density[0] where |x[a] - center[a] - u[a] t| < side[a] / 2 for all a, else density[1] */
#include "validation/exact/exact_parameters.h"

struct square {
  struct kith_exact_gas gas;
  double density[2], side[NDIM];
};
#define IN(member) KITH_INTO(struct square, member)
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    {"density", KITH_PARAM_SIDES, NULL, "(0, inf)", "[inside, outside]", IN(density)},
    KITH_EXACT_PRESSURE("[0, inf)", "of the gas"),
    KITH_EXACT_VELOCITY,
    KITH_EXACT_CENTER,
    KITH_EXACT_PERIOD,
    {"side", KITH_PARAM_VECTOR, NULL, "(0, inf)", "sides of the box", IN(side)},
    {0}};

/* The first of two regions is the box, the second is around it. */
static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct square *s = settings;
  const struct kith_exact_region *box = &scene->region[0];
  kith_exact_derive_moving(settings, scene);
  if (scene->n_regions != 2) return;
  s->density[0] = box->density, s->density[1] = scene->region[1].density;
  for (int a = 0; a < NDIM; ++a) {
    const bool all = !isfinite(box->upper[a] - box->lower[a]); /* the box spans the domain along this axis */
    const double *lower = all ? scene->lower : box->lower, *upper = all ? scene->upper : box->upper;
    s->side[a] = (all ? 2 : 1) * (upper[a] - lower[a]);
    s->gas.center[a] = 0.5 * (lower[a] + upper[a]);
  }
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct square *s = self;
  double d[3];
  bool inside = true;
  kith_exact_offset(&s->gas, x, time, d);
  for (int a = 0; a < NDIM; ++a) inside = inside && fabs(d[a]) < 0.5 * s->side[a];
  *out = kith_exact_moving(&s->gas, s->density[inside ? 0 : 1], s->gas.pressure);
}

const struct kith_exact_ops kith_exact_square = {
    .name = "square",
    .doc = "a denser box in gas of the same pressure, at rest or carried along",
    KITH_SETTINGS(params, square),
    .derive = derive,
    .state = state,
};
