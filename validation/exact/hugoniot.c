/* hugoniot: a wall at x[0] = 0 runs with speed U into a solid at rest, without pressure, whose shocks run
 * with u_s = c0 + s u_p. Mass, momentum and energy that pass the shock, at u_s t, say what is behind it:
 *
 *   velocity U,  density rho u_s / (u_s - U),  pressure rho u_s U,  energy U^2 / 2
 *
 * (Rice, McQueen and Walsh 1958, Solid State Phys. 6, 1): the equation of state of Mie and Grueneisen has
 * just these shocks. */
#include "validation/exact/exact_parameters.h"

struct hugoniot {
  double density, sound_speed, slope, velocity;
};
#define IN(member) KITH_INTO(struct hugoniot, member)
static const struct kith_param params[] = {
    {"density", KITH_PARAM_NUMBER, NULL, "(0, inf)", "of the solid", IN(density)},
    {"sound_speed", KITH_PARAM_NUMBER, NULL, "(0, inf)", "c0 of the solid", IN(sound_speed)},
    {"slope", KITH_PARAM_NUMBER, NULL, "[1, inf)",
     "s in shock speed = c0 + s times the speed of the material", IN(slope)},
    {"velocity", KITH_PARAM_NUMBER, NULL, "(0, inf)", "speed U of the wall", IN(velocity)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  ((struct hugoniot *)settings)->density = scene->region[0].density;
}

static double shock(const void *self, double time) {
  const struct hugoniot *h = self;
  return (h->sound_speed + h->slope * h->velocity) * time;
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct hugoniot *h = self;
  const double speed = shock(self, 1), u = h->velocity;
  *out = (struct kith_exact_state){.density = h->density};
  if (x[0] < speed * time)
    *out =
        (struct kith_exact_state){h->density * speed / (speed - u), {u}, h->density * speed * u, 0.5 * u * u};
}

const struct kith_exact_ops kith_exact_hugoniot = {
    .name = "hugoniot",
    .doc = "the shock before a wall that runs into a solid, linear in its speed",
    KITH_SETTINGS(params, hugoniot),
    .derive = derive,
    .state = state,
    .shock = shock,
    .not_ideal = true,
};
