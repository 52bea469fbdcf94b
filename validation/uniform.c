/* uniform: the undisturbed state, moving at uniform_velocity.
 * Reads gamma[0] > 1, density[0] > 0, pressure[0] >= 0, uniform_velocity. */
#include "validation/exact_parameters.h"

#include <math.h>

static kith_status uniform_create(void **self, const struct kith_exact_parameters *p) {
  const char *const member = "uniform";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  for (int a = 0; a < NDIM; ++a)
    KITH_TRY(kith_exact_require(true, member, "uniform_velocity", p->uniform_velocity[a], "finite"));
  struct kith_exact_state *state = NULL;
  KITH_TRY(kith_resize(&state, 0, 1, sizeof *state));
  state->density = p->density[0];
  state->pressure = p->pressure[0];
  state->energy = kith_exact_energy(p->gamma[0], state->density, state->pressure);
  for (int a = 0; a < NDIM; ++a) state->velocity[a] = p->uniform_velocity[a];
  *self = state;
  return KITH_OK;
}

static void uniform_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  (void)x, (void)time;
  *out = *(const struct kith_exact_state *)self;
}

const struct kith_exact_ops kith_exact_uniform = {
    .name = "uniform",
    .doc = "the same state everywhere and always",
    .create = uniform_create,
    .destroy = kith_exact_destroy,
    .state = uniform_state,
};
