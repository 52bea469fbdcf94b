/* uniform: the undisturbed state, moving at uniform_velocity. */
#include "validation/exact/exact_parameters.h"

static const struct kith_param params[] = {KITH_EXACT_GAMMA,
                                           KITH_EXACT_DENSITY("of the gas"),
                                           KITH_EXACT_PRESSURE("[0, inf)", "of the gas"),
                                           KITH_EXACT_VELOCITY,
                                           {0}};

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kith_exact_gas *gas = self;
  (void)x, (void)time;
  *out = kith_exact_moving(gas, gas->density, gas->pressure);
}

const struct kith_exact_ops kith_exact_uniform = {
    .name = "uniform",
    .doc = "the same state everywhere and always",
    KITH_SETTINGS(params, kith_exact_gas),
    .derive = kith_exact_derive_moving,
    .state = state,
};
