/* Schemes: how the state is advanced. Each ends with the rates of its last evaluation. */
#include "integrator/integrator.h"
#include "lib/core/family.h"

#include <string.h>

/* Kick, drift, kick. The force sees velocities and energies that are predicted to the end of the step; one evaluation. */
static kith_status leapfrog_step(struct kith_integrator *it, double *step) {
  const double dt = *step;
  struct kith_hydro *hydro = it->hydro;
  struct kith_field *base = it->package->velocity_base;
  kith_profile_begin(it->profile, "kick");
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_field_copy(it->nodes, base, hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, hydro->energy);
  kith_drift(it, base, dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_profile_end(it->profile);
  KITH_TRY(kith_integrator_rates(it));
  kith_profile_begin(it->profile, "kick");
  kith_field_copy(it->nodes, hydro->velocity, base);
  kith_field_copy(it->nodes, hydro->energy, it->energy_base);
  it->package->kicked = 0;
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  kith_profile_end(it->profile);
  return KITH_OK;
}

/* From the state at the start, by the rates at hand: half a step to the middle, positions with the velocity of the start. */
static void to_middle(struct kith_integrator *it, double dt) {
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  kith_drift(it, it->hydro->velocity, 0.5 * dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
}

/* From the state at the start, by the rates of the middle: the whole step, positions with the velocity of the middle. Positions go on
 * from where the lifecycle may have wrapped or mirrored them, half a step with the velocity of the start from theirs. */
static void to_end(struct kith_integrator *it, double dt) {
  kith_drift_supports(it, 0.5 * dt);
  double *restrict x = it->nodes->position->f64;
  const double *restrict v0 = it->package->velocity_base->f64, *restrict v = it->hydro->velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < it->nodes->n_internal * NDIM; ++k) x[k] += dt * (v[k] - 0.5 * v0[k]);
  kith_field_copy(it->nodes, it->hydro->velocity, it->package->velocity_base);
  kith_field_copy(it->nodes, it->hydro->energy, it->energy_base);
  it->package->kicked = 0;
  kith_kick_energy(it, dt);
  kith_kick_velocity(it, dt);
}

/* Midpoint: rates at the start, a half step, rates in the middle, the whole step with them. */
static kith_status rk2_step(struct kith_integrator *it, double *dt) {
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  it->package->kicked = 0;
  KITH_TRY(kith_integrator_rates(it));
  to_middle(it, *dt);
  KITH_TRY(kith_integrator_rates(it));
  to_end(it, *dt);
  return KITH_OK;
}

/* Midpoint with one evaluation: the half step is made with the rates of the last middle. */
static kith_status cheap_rk2_step(struct kith_integrator *it, double *dt) {
  to_middle(it, *dt);
  KITH_TRY(kith_integrator_rates(it));
  to_end(it, *dt);
  return KITH_OK;
}

/* Drift, kick, drift, and one evaluation in the middle: with velocities and energies that the rates of the last middle predict for
 * it. Both drifts end with the velocity of their end of the step, so the scheme without viscosity is reversible (position Verlet). */
static kith_status verlet_step(struct kith_integrator *it, double *step) {
  const double dt = *step;
  struct kith_hydro *hydro = it->hydro;
  struct kith_field *base = it->package->velocity_base;
  kith_field_copy(it->nodes, base, hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, hydro->energy);
  kith_drift(it, base, 0.5 * dt);
  kith_kick_energy(it, 0.5 * dt);
  kith_kick_velocity(it, 0.5 * dt);
  KITH_TRY(kith_integrator_rates(it));
  kith_field_copy(it->nodes, hydro->velocity, base);
  kith_field_copy(it->nodes, hydro->energy, it->energy_base);
  it->package->kicked = 0;
  kith_kick_energy(it, dt);
  kith_kick_velocity(it, dt);
  kith_drift(it, hydro->velocity, 0.5 * dt);
  return KITH_OK;
}

/* ---- the classical scheme of fourth order ---- */

enum { RK4_STAGES = 4 };

/* Sums of rates times dt, and how far nodes are from where they started: fields, so that they follow their nodes through mirrors,
 * wraps and reorderings. */
struct rk4 {
  struct kith_field *position, *velocity, *energy, *moved;
};

static kith_status rk4_create(struct kith_integrator *it) {
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct rk4)));
  struct rk4 *sum = it->self;
  const struct {
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {{"position_sum", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "change of position in the step"},
       &sum->position},
      {{"velocity_sum", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "change of velocity in the step"},
       &sum->velocity},
      {{"energy_sum", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "change of energy in the step"}, &sum->energy},
      {{"moved", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "way from the start of the step"}, &sum->moved},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k)
    KITH_TRY(kith_nodes_field(it->nodes, &table[k].spec, table[k].field));
  return KITH_OK;
}

static void rk4_destroy(struct kith_integrator *it) {
  kith_free(&it->self);
}

/* to = from + dt rate. */
static void advance(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from,
                    const struct kith_field *rate, double dt) {
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < nodes->n_internal * to->components; ++k)
    to->f64[k] = from->f64[k] + dt * rate->f64[k];
}

static void clear(const struct kith_nodes *nodes, struct kith_field *field) {
  memset(field->data, 0, (size_t)nodes->n_internal * kith_field_node_size(field));
}

static void rk4_begin(struct kith_integrator *it) {
  const struct rk4 *sum = it->self;
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  clear(it->nodes, sum->position);
  clear(it->nodes, sum->velocity);
  clear(it->nodes, sum->energy);
  clear(it->nodes, sum->moved);
}

/* Adds the rates at hand, in the time dt, to the sums. */
static void rk4_add(struct kith_integrator *it, double dt) {
  const struct rk4 *sum = it->self;
  advance(it->nodes, sum->position, sum->position, it->hydro->velocity, dt);
  advance(it->nodes, sum->velocity, sum->velocity, it->hydro->acceleration, dt);
  advance(it->nodes, sum->energy, sum->energy, it->hydro->energy_rate, dt);
}

/* The state is that of the start, moved for a time dt by these rates. Positions first: their rate may be the velocity. */
static void rk4_move(struct kith_integrator *it, const struct kith_field *v, const struct kith_field *a,
                     const struct kith_field *u, double dt) {
  double *restrict x = it->nodes->position->f64, *restrict moved = ((struct rk4 *)it->self)->moved->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < it->nodes->n_internal * NDIM; ++k) {
    const double way = dt * v->f64[k];
    x[k] += way - moved[k];
    moved[k] = way;
  }
  advance(it->nodes, it->hydro->velocity, it->package->velocity_base, a, dt);
  advance(it->nodes, it->hydro->energy, it->energy_base, u, dt);
}

/* The first stage has the rates of the last step's end. */
static kith_status rk4_step(struct kith_integrator *it, double *step) {
  static const double weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, at[] = {0, 0.5, 0.5, 1, 1};
  const double dt = *step;
  const struct kith_hydro *hydro = it->hydro;
  const struct rk4 *sum = it->self;
  rk4_begin(it);
  for (int stage = 0; stage < RK4_STAGES; ++stage) {
    rk4_add(it, weight[stage] * dt);
    if (stage + 1 < RK4_STAGES)
      rk4_move(it, hydro->velocity, hydro->acceleration, hydro->energy_rate, at[stage + 1] * dt);
    else
      rk4_move(it, sum->position, sum->velocity, sum->energy, 1);
    kith_drift_supports(it, (at[stage + 1] - at[stage]) * dt);
    KITH_TRY(kith_integrator_rates(it));
  }
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_leapfrog = {.name = "leapfrog",
                                                     .doc = "kick, drift, kick; one evaluation a step",
                                                     .evaluations = 1,
                                                     .step = leapfrog_step};
const struct kith_scheme_ops kith_scheme_rk2 = {.name = "rk2",
                                                .doc = "midpoint; two evaluations a step",
                                                .evaluations = 2,

                                                .step = rk2_step};
const struct kith_scheme_ops kith_scheme_cheap_rk2 = {
    .name = "cheap-rk2",
    .doc = "midpoint that starts from the rates of the last middle; one evaluation a step",
    .evaluations = 1,

    .step = cheap_rk2_step};
const struct kith_scheme_ops kith_scheme_verlet = {
    .name = "verlet",
    .doc = "position Verlet: drift, kick, drift; one evaluation a step, in its middle",
    .evaluations = 1,
    .step = verlet_step};
const struct kith_scheme_ops kith_scheme_rk4 = {
    .name = "rk4",
    .doc = "the classical Runge-Kutta scheme of fourth order; four evaluations a step; thermal energy only",
    .evaluations = 4,
    .incompatible =
        "energies that follow from kicks are no rate of the state, and rates are what it combines",
    .create = rk4_create,
    .destroy = rk4_destroy,
    .step = rk4_step};

#define X(name) &kith_scheme_##name,
KITH_FAMILY(kith_scheme, KITH_SCHEME_LIST(X))
#undef X
