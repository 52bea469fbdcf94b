/* uniform: the undisturbed state, moving at uniform_velocity. */
#include "validation/exact/exact_parameters.h"

struct uniform {
  double gamma, density, pressure, uniform_velocity[NDIM];
};
static const struct kith_param params[] = {KITH_EXACT_GAMMA(uniform),
                                           KITH_EXACT_DENSITY(uniform, "of the gas"),
                                           KITH_EXACT_PRESSURE(uniform, "[0, inf)", "of the gas"),
                                           KITH_EXACT_VELOCITY(uniform),
                                           {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct uniform *u = settings;
  u->gamma = scene->region[0].gamma;
  u->density = scene->region[0].density;
  u->pressure = scene->region[0].pressure;
  kith_exact_derive_velocity(u->uniform_velocity, scene);
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct uniform *u = self;
  (void)x, (void)time;
  *out = (struct kith_exact_state){.density = u->density, .pressure = u->pressure};
  out->energy = kith_exact_energy(u->gamma, u->density, u->pressure);
  for (int a = 0; a < NDIM; ++a) out->velocity[a] = u->uniform_velocity[a];
}

const struct kith_exact_ops kith_exact_uniform = {
    .name = "uniform",
    .doc = "the same state everywhere and always",
    KITH_SETTINGS(params, uniform),
    .derive = derive,
    .state = state,
};
