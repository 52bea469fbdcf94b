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
  struct kith_exact_gas gas;
  double speed;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_DENSITY("undisturbed"),
    {"velocity", KITH_PARAM_NUMBER, NULL, "(0, inf)", "speed of the inflow", KITH_INTO(struct noh, speed),
     .given = true},
    KITH_EXACT_PRESSURE("[0, inf)", "ahead of the shock"),
    KITH_EXACT_CENTER,
    {0}};

static double noh_shock(const void *self, double time) {
  const struct noh *noh = self;
  return (noh->gas.gamma - 1) / 2 * noh->speed * time;
}

static void noh_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct noh *noh = self;
  const struct kith_exact_gas *gas = &noh->gas;
  double d[3];
  kith_exact_offset(gas, x, time, d);
  const double r = kith_norm(d);
  if (r < noh_shock(self, time)) {
    *out = (struct kith_exact_state){.energy = noh->speed * noh->speed / 2};
    out->density = gas->density * kith_pow_dim((gas->gamma + 1) / (gas->gamma - 1));
    out->pressure = (gas->gamma - 1) * out->density * out->energy;
    return;
  }
  /* r = 0 gets here at time 0 only: no direction, so no velocity. */
  const double crowding = r > 0 ? 1 + noh->speed * time / r : 1;
  *out = kith_exact_moving(gas, gas->density * kith_pow_dim(crowding) / crowding, gas->pressure);
  for (int a = 0; r > 0 && a < NDIM; ++a) out->velocity[a] = -noh->speed * d[a] / r;
}

const struct kith_exact_ops kith_exact_noh = {
    .name = "noh",
    .doc = "cold gas imploding onto a plane, a line or a point",
    KITH_SETTINGS(params, noh),
    .derive = kith_exact_derive_gas,
    .state = noh_state,
    .shock = noh_shock,
    .radial = true,
};
