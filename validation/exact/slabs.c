/* slabs: two half spaces of different temperature and conductivity in touch, planar along axis 0, at rest.
 *
 *   T = T_s + (T_side - T_s) erf(|x[0] - interface| / (2 sqrt(chi_side t))),   T = u / c_v,
 *   T_s = (b_left T_left + b_right T_right) / (b_left + b_right),   b = sqrt(k rho c_v),  chi = k / (rho c_v)
 *
 * (Carslaw and Jaeger 1959, Conduction of Heat in Solids, section 2.15, without resistance at the contact):
 * the temperature of the contact does not change, the flow of heat is continuous. The gas stays at rest if
 * its pressure does not depend on its energy (isothermal). */
#include "validation/exact/exact_parameters.h"

struct slabs {
  double density[2], pressure[2], energy[2], conductivity[2], specific_heat[2], interface_position;
};
#define IN(member) KITH_INTO(struct slabs, member)
static const struct kith_param params[] = {
    {"density", KITH_PARAM_SIDES, NULL, "(0, inf)", "[left, right]", IN(density)},
    {"pressure", KITH_PARAM_SIDES, NULL, "[0, inf)", "[left, right]", IN(pressure)},
    {"energy", KITH_PARAM_SIDES, NULL, "[0, inf)", "at the start, per unit mass: [left, right]", IN(energy),
     .given = true},
    {"conductivity", KITH_PARAM_SIDES, NULL, "(0, inf)", "[left, right]", IN(conductivity), .given = true},
    {"specific_heat", KITH_PARAM_SIDES, "1", "(0, inf)", "[left, right]", IN(specific_heat)},
    {"interface_position", KITH_PARAM_NUMBER, NULL, "", "x of the contact", IN(interface_position)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct slabs *s = settings;
  const struct kith_exact_region *half[2];
  if (!kith_exact_halves(scene, half)) return;
  for (int side = 0; side < 2; ++side) {
    s->density[side] = half[side]->density;
    s->pressure[side] = half[side]->pressure;
  }
  s->interface_position = half[0]->upper[0];
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct slabs *s = self;
  const double from = x[0] - s->interface_position;
  const int side = from > 0;
  double weight[2], hot[2];
  for (int k = 0; k < 2; ++k) {
    weight[k] = sqrt(s->conductivity[k] * s->density[k] * s->specific_heat[k]);
    hot[k] = s->energy[k] / s->specific_heat[k];
  }
  const double contact = (weight[0] * hot[0] + weight[1] * hot[1]) / (weight[0] + weight[1]);
  const double diffusivity = s->conductivity[side] / (s->density[side] * s->specific_heat[side]);
  const double part = time > 0 ? erf(fabs(from) / (2 * sqrt(diffusivity * time))) : 1;
  *out = (struct kith_exact_state){.density = s->density[side], .pressure = s->pressure[side]};
  out->energy = s->specific_heat[side] * (contact + (hot[side] - contact) * part);
}

const struct kith_exact_ops kith_exact_slabs = {
    .name = "slabs",
    .doc = "two half spaces of different temperature and conductivity in touch",
    KITH_SETTINGS(params, slabs),
    .derive = derive,
    .derived_from =
        "two regions of constant state that touch in a plane x = const and reach across the domain, without "
        "external forces",
    .state = state,
    .not_ideal = true,
};
