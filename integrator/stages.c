#include "integrator/stages.h"

#include <math.h>

static kith_status keep_lists(struct kith_stages *s, struct kith_integrator *it) {
  static const char *const names[] = {"stage_built_x", "stage_built_y", "stage_built_z"};
  for (int a = 0; a < NDIM; ++a) {
    const struct kith_field_spec built = {
        names[a],  KITH_SCALAR, KITH_F64,
        KITH_WORK, NULL,        "where the lists were made from, at the start of the step"};
    KITH_TRY(kith_nodes_field(it->nodes, &built, &s->built[a]));
  }
  const struct kith_field_spec reach = {"stage_built_reach", KITH_SCALAR, KITH_F64,
                                        KITH_WORK,           NULL,        "reach of the lists, then"};
  const struct kith_field_spec support = {
      "stage_built_support", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "support they were made with, then"};
  KITH_TRY(kith_nodes_field(it->nodes, &reach, &s->built_reach));
  return kith_nodes_field(it->nodes, &support, &s->built_support);
}

kith_status kith_stages_init(struct kith_stages *s, struct kith_integrator *it) {
  const struct {
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {{"position_base", KITH_POSITION, KITH_F64, KITH_WORK, NULL, "position at the start"}, &s->position},
      {{"support_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "support at the start"}, &s->support},
      {{"expansion_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "div v at the start"}, &s->expansion},
      {{"acceleration_base", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dv/dt at the start"}, &s->acceleration},
      {{"energy_rate_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "du/dt at the start"}, &s->energy_rate},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k)
    KITH_TRY(kith_nodes_field(it->nodes, &table[k].spec, table[k].field));
  return kith_rebuilds_lasting(it->rebuilds) ? keep_lists(s, it) : KITH_OK;
}

static void keep_state(struct kith_stages *s, struct kith_integrator *it) {
  kith_field_copy(it->nodes, s->position, it->nodes->position);
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  kith_field_copy(it->nodes, s->support, it->nodes->support);
  kith_field_copy(it->nodes, s->expansion, it->package->expansion);
  kith_field_copy(it->nodes, s->acceleration, it->hydro->acceleration);
  kith_field_copy(it->nodes, s->energy_rate, it->hydro->energy_rate);
}

static void restore_state(struct kith_stages *s, struct kith_integrator *it) {
  kith_field_copy(it->nodes, it->nodes->position, s->position);
  kith_field_copy(it->nodes, it->hydro->velocity, it->package->velocity_base);
  kith_field_copy(it->nodes, it->hydro->energy, it->energy_base);
  kith_field_copy(it->nodes, it->nodes->support, s->support);
  it->nodes->positions += 1;
}

/* Will the lists last as long as the longest step that may come? That does not depend on what the step will be cut down to. */
static kith_status lists_due(struct kith_stages *s, struct kith_integrator *it, const char **reason) {
  if (!kith_rebuilds_lasting(it->rebuilds)) return kith_rebuilds_due(it->rebuilds, it->nodes, reason);
  kith_drift(it, it->hydro->velocity, it->fixed_dt > 0 ? it->fixed_dt : KITH_GROWTH * it->dt);
  const kith_status status = kith_rebuilds_due(it->rebuilds, it->nodes, reason);
  restore_state(s, it);
  return status;
}

kith_status kith_stages_begin(struct kith_stages *s, struct kith_integrator *it) {
  keep_state(s, it);
  KITH_TRY(lists_due(s, it, &it->due));
  if (it->due != NULL) {
    KITH_TRY(kith_lifecycle_settle(it));
    keep_state(s, it);
  }
  for (int a = 0; s->built_reach != NULL && a < NDIM; ++a)
    kith_field_copy(it->nodes, s->built[a], it->built[a]);
  if (s->built_reach != NULL) {
    kith_field_copy(it->nodes, s->built_reach, it->built_reach);
    kith_field_copy(it->nodes, s->built_support, it->built_support);
  }
  it->package->kicked = 0;
  it->holding = true;
  s->due = it->due;
  s->lifecycles = it->ledger.lifecycles;
  return KITH_OK;
}

kith_status kith_stages_rates(struct kith_stages *s, struct kith_integrator *it, double time) {
  kith_field_copy(it->nodes, it->nodes->support, s->support);
  kith_field_copy(it->nodes, it->package->expansion, s->expansion);
  it->clock = it->time;
  kith_drift_supports(it, time);
  return kith_integrator_rates(it);
}

kith_status kith_stages_again(struct kith_stages *s, struct kith_integrator *it) {
  it->due = s->due;
  if (s->due != NULL || s->built_reach == NULL || it->ledger.lifecycles == s->lifecycles) return KITH_OK;
  for (int a = 0; a < NDIM; ++a) kith_field_copy(it->nodes, it->built[a], s->built[a]);
  kith_field_copy(it->nodes, it->built_reach, s->built_reach);
  kith_field_copy(it->nodes, it->built_support, s->built_support);
  /* The rates of the start are kept: their fields are free. */
  KITH_TRY(kith_integrator_remake(it, it->hydro->acceleration, it->hydro->energy_rate));
  s->lifecycles = it->ledger.lifecycles;
  return KITH_OK;
}

kith_status kith_stages_restore(struct kith_stages *s, struct kith_integrator *it) {
  restore_state(s, it);
  KITH_TRY(kith_stages_again(s, it));
  kith_field_copy(it->nodes, it->hydro->acceleration, s->acceleration);
  kith_field_copy(it->nodes, it->hydro->energy_rate, s->energy_rate);
  return KITH_OK;
}

void kith_stages_end(struct kith_integrator *it) {
  it->holding = false;
  it->due = NULL;
}

void kith_stages_copy_rates(const struct kith_integrator *it, N_Vector rates) {
  const struct kith_field *const rate[] = {it->hydro->velocity, it->hydro->acceleration,
                                           it->hydro->energy_rate};
  for (int part = 0; part < KITH_VECTOR_PARTS; ++part) {
    double *to = kith_vector_numbers(rates, part);
    const double *from = rate[part]->f64;
    const kith_index n = it->nodes->n_internal * rate[part]->components;
#pragma omp parallel for simd schedule(static)
    for (kith_index k = 0; k < n; ++k) to[k] = from[k];
  }
}

/* Energy per mass where the center of mass rests. */
static double common_energy(const struct kith_hydro *hydro) {
  const struct kith_totals t = kith_hydro_totals(hydro);
  if (!(t.mass > 0)) return 0;
  return fmax(0, (t.kinetic + t.internal - 0.5 * kith_dot(t.momentum, t.momentum) / t.mass) / t.mass);
}

/* What has no tolerance has no scale, and any weight will do. */
static double weight(double tolerance) {
  return tolerance > 0 ? 1 / tolerance : 1;
}

void kith_stages_weights(const struct kith_integrator *it, N_Vector state, N_Vector weights) {
  const double e = common_energy(it->hydro), rtol = it->stepping.rtol, atol = it->stepping.atol;
  const double *h = it->nodes->support->f64, *c = it->hydro->sound_speed->f64,
               *u = kith_vector_numbers(state, KITH_VECTOR_ENERGY);
  double *wx = kith_vector_numbers(weights, KITH_VECTOR_POSITION),
         *wv = kith_vector_numbers(weights, KITH_VECTOR_VELOCITY),
         *wu = kith_vector_numbers(weights, KITH_VECTOR_ENERGY);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    const double x = weight((rtol + atol) * h[i]), v = weight(rtol * c[i] + atol * sqrt(2 * e));
    for (int a = 0; a < NDIM; ++a) wx[(size_t)i * NDIM + a] = x, wv[(size_t)i * NDIM + a] = v;
    wu[i] = weight(rtol * fabs(u[i]) + atol * e);
  }
}
