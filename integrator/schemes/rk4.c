/* Scheme rk4: the classical Runge-Kutta scheme of fourth order. The first stage has the rates of the last
 * step's end; the other three and the end are evaluated by the lists of the start. */
#include <string.h>
#include "integrator/step.h"

enum { STAGES = 4 };

/* The start, and sums of rates times dt: fields, so that they are as long as the state on every rank. */
struct rk4 {
  struct kith_field *start, *position, *velocity, *energy;
};

static kith_status create(struct kith_integrator *it) {
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct rk4)));
  struct rk4 *rk4 = it->self;
  const struct {
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {{"position_base", KITH_POSITION, KITH_F64, KITH_WORK, NULL, "position at the start"}, &rk4->start},
      {{"position_sum", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "change of position in the step"},
       &rk4->position},
      {{"velocity_sum", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "change of velocity in the step"},
       &rk4->velocity},
      {{"energy_sum", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "change of energy in the step"}, &rk4->energy},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k)
    KITH_TRY(kith_nodes_field(it->nodes, &table[k].spec, table[k].field));
  return KITH_OK;
}

static void destroy(struct kith_integrator *it) {
  kith_free(&it->self);
}

/* to = from + dt rate. */
static void combine(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from,
                    const struct kith_field *rate, double dt) {
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < nodes->n_internal * to->components; ++k)
    to->f64[k] = from->f64[k] + dt * rate->f64[k];
}

static void clear(const struct kith_nodes *nodes, struct kith_field *field) {
  memset(field->data, 0, (size_t)nodes->n_internal * kith_field_node_size(field));
}

static void begin(struct kith_integrator *it) {
  const struct rk4 *rk4 = it->self;
  kith_field_copy(it->nodes, rk4->start, it->nodes->position);
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  clear(it->nodes, rk4->position);
  clear(it->nodes, rk4->velocity);
  clear(it->nodes, rk4->energy);
}

/* Adds the rates at hand, in the time dt, to the sums. */
static void add(struct kith_integrator *it, double dt) {
  const struct rk4 *rk4 = it->self;
  combine(it->nodes, rk4->position, rk4->position, it->hydro->velocity, dt);
  combine(it->nodes, rk4->velocity, rk4->velocity, it->hydro->acceleration, dt);
  combine(it->nodes, rk4->energy, rk4->energy, it->hydro->energy_rate, dt);
}

/* The state is that of the start, moved for a time dt by these rates. Positions first: their rate may be the
 * velocity. */
static void move(struct kith_integrator *it, const struct kith_field *v, const struct kith_field *a,
                 const struct kith_field *u, double dt) {
  const struct rk4 *rk4 = it->self;
  combine(it->nodes, it->nodes->position, rk4->start, v, dt);
  combine(it->nodes, it->hydro->velocity, it->kick.velocity_base, a, dt);
  combine(it->nodes, it->hydro->energy, it->energy_base, u, dt);
}

static kith_status advance(struct kith_integrator *it, double *step) {
  static const double weight[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6}, at[] = {0, 0.5, 0.5, 1, 1};
  const double dt = *step;
  const struct kith_hydro *hydro = it->hydro;
  const struct rk4 *rk4 = it->self;
  begin(it);
  for (int stage = 0; stage < STAGES; ++stage) {
    add(it, weight[stage] * dt);
    if (stage + 1 < STAGES)
      move(it, hydro->velocity, hydro->acceleration, hydro->energy_rate, at[stage + 1] * dt);
    else
      move(it, rk4->position, rk4->velocity, rk4->energy, 1);
    kith_drift_supports(it, (at[stage + 1] - at[stage]) * dt);
    KITH_TRY(kith_integrator_evaluate(it));
  }
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_rk4 = {
    .name = "rk4",
    .doc = "the classical Runge-Kutta scheme of fourth order; four evaluations a step; thermal energy only",
    .evaluations = STAGES,
    .incompatible =
        "energies that follow from kicks are no rate of the state, and rates are what it combines",
    .stages = true,
    .create = create,
    .destroy = destroy,
    .advance = advance};
