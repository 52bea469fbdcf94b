/* hugoniot: a wall, at the start at x[0] = interface_position, runs with velocity U into a solid at rest,
 * without pressure, whose shocks run with u_s = c0 + s u_p. Mass, momentum and energy that pass the shock,
 * u_s t ahead of where the wall was, say what is behind it:
 *
 *   velocity U,  density rho u_s / (u_s - |U|),  pressure rho u_s |U|,  energy U^2 / 2
 *
 * (Rice, McQueen and Walsh 1958, Solid State Phys. 6, 1): the equation of state of Mie and Grueneisen has
 * just these shocks. */
#include "validation/exact/exact_parameters.h"

struct hugoniot {
  double density, sound_speed, slope, velocity, interface_position;
};
#define IN(member) KITH_INTO(struct hugoniot, member)
static const struct kith_param params[] = {
    {"density", KITH_PARAM_NUMBER, NULL, "(0, inf)", "of the solid", IN(density)},
    {"sound_speed", KITH_PARAM_NUMBER, NULL, "(0, inf)", "c0 of the solid", IN(sound_speed), .given = true},
    {"slope", KITH_PARAM_NUMBER, NULL, "[1, inf)",
     "s in shock speed = c0 + s times the speed of the material", IN(slope), .given = true},
    {"velocity", KITH_PARAM_NUMBER, NULL, "", "U, of the wall", IN(velocity)},
    {"interface_position", KITH_PARAM_NUMBER, NULL, "", "x of the wall at the start", IN(interface_position)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct hugoniot *h = settings;
  const bool at_upper = scene->axis[0].open[0]; /* the other side of a piston is open */
  h->density = scene->region[0].density;
  h->interface_position = (at_upper ? scene->upper : scene->lower)[0];
  const double velocity = scene->axis[0].velocity;
  if (at_upper ? velocity < 0 : velocity > 0) h->velocity = velocity; /* a wall that recedes has no shock */
}

static double shock_speed(const struct hugoniot *h) {
  return h->sound_speed + h->slope * fabs(h->velocity);
}

static double shock(const void *self, double time) {
  const struct hugoniot *h = self;
  return h->interface_position + copysign(shock_speed(h), h->velocity) * time;
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct hugoniot *h = self;
  const double speed = shock_speed(h), u = fabs(h->velocity);
  *out = (struct kith_exact_state){.density = h->density};
  if (copysign(1, h->velocity) * (x[0] - h->interface_position) < speed * time)
    *out = (struct kith_exact_state){
        h->density * speed / (speed - u), {h->velocity}, h->density * speed * u, 0.5 * u * u};
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
