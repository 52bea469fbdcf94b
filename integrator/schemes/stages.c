/* The stages of a step made by a solver of SUNDIALS. */
#include "integrator/schemes/stages.h"

#include <math.h>
#include "integrator/lifecycle.h"

kith_status kith_stages_init(struct kith_stages *s, struct kith_integrator *it) {
  const struct {
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {{"position_base", KITH_POSITION, KITH_F64, KITH_WORK, NULL, "position at the start"}, &s->position},
      {{"support_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "support at the start"}, &s->support},
      {{"expansion_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "div v at the start"},
       &s->velocity_divergence},
      {{"acceleration_base", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dv/dt at the start"}, &s->acceleration},
      {{"energy_rate_base", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "du/dt at the start"}, &s->energy_rate},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k)
    KITH_TRY(kith_nodes_field(it->nodes, &table[k].spec, table[k].field));
  static const char *const names[] = {"stage_built_radius", "stage_built_support", "stage_built_x",
                                      "stage_built_y", "stage_built_z"};
  return kith_built_fields(&s->built, it->nodes, names, KITH_WORK);
}

static void keep_state(struct kith_stages *s, struct kith_integrator *it) {
  kith_field_copy(it->nodes, s->position, it->nodes->position);
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  kith_field_copy(it->nodes, s->support, it->nodes->support);
  kith_field_copy(it->nodes, s->velocity_divergence, it->package->velocity_divergence);
  kith_field_copy(it->nodes, s->acceleration, it->hydro->acceleration);
  kith_field_copy(it->nodes, s->energy_rate, it->hydro->energy_rate);
}

static void restore_state(struct kith_stages *s, struct kith_integrator *it) {
  kith_field_copy(it->nodes, it->nodes->position, s->position);
  kith_field_copy(it->nodes, it->hydro->velocity, it->kick.velocity_base);
  kith_field_copy(it->nodes, it->hydro->energy, it->energy_base);
  kith_field_copy(it->nodes, it->nodes->support, s->support);
  it->nodes->positions += 1;
}

void kith_stages_begin(struct kith_stages *s, struct kith_integrator *it) {
  keep_state(s, it);
  kith_built_copy(it->nodes, &s->built, &it->built);
  it->kick.time = 0;
  s->lifecycles = it->ledger.lifecycles;
}

kith_status kith_stages_rates(struct kith_stages *s, struct kith_integrator *it, double time) {
  kith_field_copy(it->nodes, it->nodes->support, s->support);
  kith_field_copy(it->nodes, it->package->velocity_divergence, s->velocity_divergence);
  it->clock = it->time;
  kith_drift_supports(it, time);
  return kith_integrator_evaluate(it);
}

kith_status kith_stages_again(struct kith_stages *s, struct kith_integrator *it) {
  if (it->ledger.lifecycles == s->lifecycles) return KITH_OK;
  kith_built_copy(it->nodes, &it->built, &s->built);
  /* The rates of the start are kept: their fields are free. */
  KITH_TRY(kith_lifecycle_remake(it, it->hydro->acceleration, it->hydro->energy_rate));
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

kith_status kith_stages_vectors(struct kith_vectors **out, const struct kith_hydro *hydro) {
  struct kith_field *const field[KITH_VECTOR_PARTS] = {hydro->nodes->position, hydro->velocity,
                                                       hydro->energy};
  struct kith_vector_part part[KITH_VECTOR_PARTS];
  for (int p = 0; p < KITH_VECTOR_PARTS; ++p)
    part[p] =
        (struct kith_vector_part){&field[p]->f64, (int64_t)hydro->nodes->n_internal * field[p]->components};
  return kith_vectors_create(out, hydro->nodes->ranks, KITH_VECTOR_PARTS, part);
}

bool kith_stages_fit(const struct kith_vectors *vectors, const struct kith_nodes *nodes) {
  return !kith_ranks_any(nodes->ranks,
                         vectors == NULL || vectors->part[KITH_VECTOR_ENERGY].length != nodes->n_internal);
}

size_t kith_stages_vector_bytes(const struct kith_hydro *hydro) {
  return (size_t)hydro->nodes->n_internal * (2 * NDIM + 1) * sizeof(double);
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

void kith_stages_weights(const struct kith_integrator *it, const struct kith_tolerances *tolerances,
                         N_Vector state, N_Vector weights) {
  const double e = common_energy(it->hydro), rtol = tolerances->rtol, atol = tolerances->atol;
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
