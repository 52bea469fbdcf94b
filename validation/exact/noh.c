/* noh: cold gas of uniform density runs at speed v0 onto a plane, a line or a point (NDIM = j = 1, 2, 3),
 * both sides of the plane. W. F. Noh, J. Comput. Phys. 72 (1987) 78. A shock at R = (gamma - 1) v0 t / 2
 * brings it to rest:
 *
 *   r < R:  rho = rho0 ((gamma + 1) / (gamma - 1))^j,  v = 0,  energy = v0^2 / 2
 *   r > R:  rho = rho0 (1 + v0 t / r)^(j - 1),         v = -v0 (x - center) / r,  P = P0 as given
 *
 * exact for P0 = 0; a tiny P0 only keeps the gas ahead from being cold to the last bit, and is not
 * compressed. */
#include "lib/core/vec.h"
#include "validation/exact/exact_parameters.h"

struct noh {
  double gamma, density, pressure, speed, center[NDIM];
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA(noh),
    KITH_EXACT_DENSITY(noh, "undisturbed"),
    {"velocity", KITH_PARAM_NUMBER, NULL, "(0, inf)", "speed of the inflow", KITH_INTO(struct noh, speed),
     .unit = "velocity"},
    KITH_EXACT_PRESSURE(noh, "[0, inf)", "ahead of the shock"),
    KITH_EXACT_CENTER(noh),
    {0}};

/* The speed at a point away from the center, which is the origin. */
static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct noh *noh = settings;
  double x[NDIM], v[NDIM];
  noh->gamma = scene->region[0].gamma;
  noh->density = scene->region[0].density;
  noh->pressure = scene->region[0].pressure;
  for (int a = 0; a < NDIM; ++a) { /* somewhere between the origin and the farther face */
    const double lower = scene->lower[a], upper = scene->upper[a];
    x[a] = (0.6 + 0.1 * a) * (fabs(lower) > fabs(upper) ? lower : upper);
  }
  scene->velocity(scene->context, x, v);
  noh->speed = kith_norm(v);
}

static double noh_shock(const void *self, double time) {
  const struct noh *noh = self;
  return (noh->gamma - 1) / 2 * noh->speed * time;
}

static const double *noh_center(const void *self) {
  return ((const struct noh *)self)->center;
}

static void noh_behind(const struct noh *noh, struct kith_exact_state *out) {
  out->density = noh->density * kith_pow_dim((noh->gamma + 1) / (noh->gamma - 1));
  out->energy = noh->speed * noh->speed / 2;
  out->pressure = (noh->gamma - 1) * out->density * out->energy;
}

static void noh_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct noh *noh = self;
  const double r = sqrt(kith_distance2(x, noh->center));
  *out = (struct kith_exact_state){0};
  if (r < noh_shock(self, time)) {
    noh_behind(noh, out);
    return;
  }
  /* r = 0 gets here at time 0 only: no direction, so no velocity. */
  const double crowding = r > 0 ? 1 + noh->speed * time / r : 1;
  out->density = noh->density * kith_pow_dim(crowding) / crowding;
  out->pressure = noh->pressure;
  out->energy = kith_exact_energy(noh->gamma, out->density, out->pressure);
  if (r > 0)
    for (int a = 0; a < NDIM; ++a) out->velocity[a] = -noh->speed * (x[a] - noh->center[a]) / r;
}

const struct kith_exact_ops kith_exact_noh = {
    .name = "noh",
    .doc = "cold gas imploding onto a plane, a line or a point",
    KITH_SETTINGS(params, noh),
    .derive = derive,
    .state = noh_state,
    .shock = noh_shock,
    .center = noh_center,
};
