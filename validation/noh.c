/* noh: cold gas of uniform density runs at speed v0 onto a plane, a line or a point (NDIM = j = 1, 2, 3),
 * both sides of the plane. W. F. Noh, J. Comput. Phys. 72 (1987) 78. A shock at R = (gamma - 1) v0 t / 2
 * brings it to rest:
 *
 *   r < R:  rho = rho0 ((gamma + 1) / (gamma - 1))^j,  v = 0,  energy = v0^2 / 2
 *   r > R:  rho = rho0 (1 + v0 t / r)^(j - 1),         v = -v0 (x - center) / r,  P = P0 as given
 *
 * exact for P0 = 0; a tiny P0 only keeps the gas ahead from being cold to the last bit, and is not
 * compressed. Reads gamma[0] > 1, density[0] > 0, pressure[0] >= 0, velocity[0] = v0 > 0, center. */
#include "validation/exact_parameters.h"
#include "lib/core/vec.h"

#include <math.h>

struct noh {
  double gamma, density, pressure, speed, center[NDIM];
};

static kith_status noh_create(void **self, const struct kith_exact_parameters *p) {
  const char *const member = "noh";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  KITH_TRY(kith_exact_require(p->velocity[0] > 0, member, "velocity[0]", p->velocity[0], "above 0 (inward)"));
  for (int a = 0; a < NDIM; ++a) KITH_TRY(kith_exact_require(true, member, "center", p->center[a], "finite"));
  struct noh *noh = NULL;
  KITH_TRY(kith_resize(&noh, 0, 1, sizeof *noh));
  *noh = (struct noh){p->gamma[0], p->density[0], p->pressure[0], p->velocity[0], {0}};
  for (int a = 0; a < NDIM; ++a) noh->center[a] = p->center[a];
  *self = noh;
  return KITH_OK;
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
    .create = noh_create,
    .destroy = kith_exact_destroy,
    .state = noh_state,
    .shock = noh_shock,
    .center = noh_center,
};
