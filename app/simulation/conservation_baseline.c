/* Relative changes of conserved quantities since the start of a run. */
#include "app/simulation/conservation_baseline.h"

#include <math.h>

struct kith_conservation_baseline kith_conservation_baseline_of(const struct kith_totals *first) {
  return (struct kith_conservation_baseline){
      .totals = *first, .kinetic_least = first->kinetic, .velocity_over_sound = first->velocity_over_sound};
}

static bool is_wall(const struct kith_simulation *simulation, int axis) {
  const struct kith_boundary_ops *lower = simulation->scene->boundary[axis].lower,
                                 *upper = simulation->scene->boundary[axis].upper;
  return (lower != NULL && !lower->wraps) || (upper != NULL && !upper->wraps);
}

/* Nothing gives momentum along this axis. */
static bool keeps_momentum(const struct kith_simulation *simulation, int axis) {
  const struct kith_external_force *external_force = &simulation->hydro.external_force;
  return !is_wall(simulation, axis) && external_force->gravity[axis] == 0 && external_force->mass == 0;
}

static bool can_turn(const struct kith_simulation *simulation) {
  bool can = NDIM > 1;
  for (int a = 0; a < NDIM; ++a)
    can = can && !is_wall(simulation, a) && simulation->hydro.external_force.gravity[a] == 0;
  for (int k = 0; k < simulation->scene->n_regions; ++k) can = can && !simulation->scene->region[k].frozen;
  return can;
}

/* sum m |.| of now or then, whichever is larger. */
static double scale(double now, double then) {
  return fmax(fmax(now, then), 1e-300);
}

/* What is kept: see hydro.h. */
static double energy_of(const struct kith_totals *t) {
  return t->kinetic + t->internal + t->potential - t->work;
}

void kith_conservation_baseline_update(struct kith_conservation_baseline *baseline,
                                       const struct kith_simulation *simulation,
                                       const struct kith_totals *now) {
  const struct kith_totals *then = &baseline->totals;
  const double e0 = energy_of(then), e = fmax(fabs(e0), fabs(now->work - then->work));
  const double energy = fabs(energy_of(now) - e0) / (e > 0 ? e : 1);
  double momentum = 0, angular2 = 0;
  for (int a = 0; a < NDIM; ++a)
    if (keeps_momentum(simulation, a)) momentum = fmax(momentum, fabs(now->momentum[a] - then->momentum[a]));
  for (int a = 0; a < 3; ++a)
    angular2 += (now->angular[a] - then->angular[a]) * (now->angular[a] - then->angular[a]);
  momentum /= scale(now->momentum_scale, then->momentum_scale);
  const double angular =
      can_turn(simulation) ? sqrt(angular2) / scale(now->angular_scale, then->angular_scale) : NAN;
  baseline->energy_drift = fmax(baseline->energy_drift, energy);
  baseline->momentum_drift = fmax(baseline->momentum_drift, momentum);
  baseline->angular_drift = isnan(angular) ? NAN : fmax(baseline->angular_drift, angular);
  baseline->kinetic_least = fmin(baseline->kinetic_least, now->kinetic);
  baseline->kinetic_rebound = fmax(baseline->kinetic_rebound, now->kinetic - baseline->kinetic_least);
  baseline->velocity_over_sound = fmax(baseline->velocity_over_sound, now->velocity_over_sound);
}
