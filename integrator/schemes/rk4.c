/* Scheme rk4: the classical Runge-Kutta scheme of fourth order. The first stage takes the rates of the end of
 * the last step; the other three and the end are evaluated with the lists of the start. */
#include <string.h>
#include "integrator/step.h"

enum { STAGES = 4, PARTS = 3 };

/* For position, velocity and energy: the state, its rates, the state at the start, and the sums of rates
 * times dt. The sums are fields, so that they have the length of the state on every rank. Positions come
 * first, as their rate is the velocity. */
struct rk4 {
  struct kith_field *state[PARTS], *rate[PARTS], *start[PARTS], *sum[PARTS];
};

static kith_status create(struct kith_integrator *it) {
  static const struct kith_field_spec position =
      KITH_SPEC(POSITION, OWN_WORK, "position_base", "position at the start");
  static const struct kith_field_spec sums[PARTS] = {
      KITH_SPEC(VECTOR, OWN_WORK, "position_sum", "change of position in the step"),
      KITH_SPEC(VECTOR, OWN_WORK, "velocity_sum", "change of velocity in the step"),
      KITH_SPEC(SCALAR, OWN_WORK, "energy_sum", "change of energy in the step")};
  const struct kith_hydro *hydro = it->hydro;
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct rk4)));
  struct rk4 *y = it->self;
  *y = (struct rk4){.state = {it->nodes->position, hydro->velocity, hydro->energy},
                    .rate = {hydro->velocity, hydro->acceleration, hydro->energy_rate},
                    .start = {NULL, it->kick.velocity_base, it->energy_base}};
  for (int p = 0; p < PARTS; ++p) KITH_TRY(kith_nodes_field(it->nodes, &sums[p], &y->sum[p]));
  return kith_nodes_field(it->nodes, &position, &y->start[0]);
}

static void combine(const struct kith_nodes *nodes, struct kith_field *const *to,
                    struct kith_field *const *from, struct kith_field *const *rate, double dt) {
  for (int p = 0; p < PARTS; ++p) {
    const size_t n = (size_t)nodes->n_internal * (size_t)to[p]->components;
#pragma omp parallel for simd schedule(static)
    for (size_t k = 0; k < n; ++k) to[p]->f64[k] = from[p]->f64[k] + dt * rate[p]->f64[k];
  }
}

static kith_status advance(struct kith_integrator *it, double *step) {
  static const double weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, at[] = {0, 0.5, 0.5, 1, 1};
  const double dt = *step;
  const struct kith_nodes *nodes = it->nodes;
  const struct rk4 *y = it->self;
  for (int p = 0; p < PARTS; ++p) {
    kith_field_copy(nodes, y->start[p], y->state[p]);
    memset(y->sum[p]->data, 0, (size_t)nodes->n_internal * kith_field_node_size(y->sum[p]));
  }
  for (int stage = 0; stage < STAGES; ++stage) {
    const bool last = stage + 1 == STAGES;
    combine(nodes, y->sum, y->sum, y->rate, weight[stage] * dt);
    kith_through_add(&it->hydro->through, weight[stage] * dt, &it->flow.rate);
    combine(nodes, y->state, y->start, last ? y->sum : y->rate, last ? 1 : at[stage + 1] * dt);
    kith_drift_supports(it, (at[stage + 1] - at[stage]) * dt);
    KITH_TRY(kith_integrator_evaluate(it));
  }
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_rk4 = {
    .name = "rk4",
    .doc = "the classical Runge-Kutta scheme of fourth order; four evaluations a step; thermal energy only",
    .evaluations = STAGES,
    .thermal_only = true,
    .stages = true,
    .create = create,
    .advance = advance};
