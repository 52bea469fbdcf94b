/* The state of the time integration: fields, kicks and drifts; the family of schemes. */
#include "integrator/integrator.h"

#include "lib/core/family.h"

#define X(name) &kith_scheme_##name,
KITH_FAMILY(kith_scheme, KITH_SCHEME_LIST(X))
#undef X

kith_status kith_integrator_init(struct kith_integrator *it) {
  static const char *const names[] = {"built_radius", "built_support", "built_x", "built_y", "built_z"};
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(VELOCITY, OWN_WORK, "velocity_base", "velocity at the start of the kick"),
       &it->kick.velocity_base},
      {true, KITH_SPEC(SCALAR, OWN_WORK, "energy_base", "energy at the start of the kick"), &it->energy_base},
      {!it->scheme->stages && !kith_scheme_has_blocks(it->scheme, it->settings),
       KITH_SPEC(SCALAR, OWN_KEPT, "energy_rate_last", "du/dt, one evaluation earlier"),
       &it->energy_rate_last},
      {it->follows,
       {"window_even", KITH_SCALAR, KITH_U8, KITH_WORK, NULL, "is it disturbed, or near such nodes?"},
       &it->reached[0]},
      {it->follows,
       {"window_odd", KITH_SCALAR, KITH_U8, KITH_WORK, NULL, "the same, a neighbor further"},
       &it->reached[1]},
      {0}};
  if (it->settings != NULL) KITH_TRY(kith_params_check(it->scheme->params, it->scheme->name, it->settings));
  it->kick = (struct kith_kick){0};
  if (it->follows) KITH_TRY(kith_nodes_mark_activity(it->nodes));
  KITH_TRY(kith_nodes_fields(it->nodes, fields));
  it->evaluations = it->scheme->evaluations;
  if (it->scheme->create != NULL) KITH_TRY(it->scheme->create(it));
  const bool lasting = kith_rebuilds_lasting(it->rebuilds);
  if (lasting || it->scheme->retries)
    KITH_TRY(kith_built_fields(&it->built, it->nodes, names, lasting ? KITH_OWN_KEPT : KITH_OWN_WORK));
  if (it->scheme->stages) it->rebuilds->keeps_cover = true;
  it->rebuilds->cover.velocity = it->hydro->velocity;
  it->rebuilds->cover.velocity_divergence = it->package->velocity_divergence;
  return KITH_OK;
}

void kith_integrator_clear(struct kith_integrator *it) {
  if (it->self != NULL && it->scheme->destroy != NULL) it->scheme->destroy(it);
  KITH_FREE(&it->self, &it->near.node);
  it->near.capacity = 0;
  KITH_FREE(&it->scratch.keep, &it->scratch.renumber);
  it->scratch.keep_capacity = it->scratch.renumber_capacity = 0;
}

size_t kith_integrator_bytes(const struct kith_integrator *it) {
  const size_t own = it->scheme->bytes != NULL ? it->scheme->bytes(it) : 0;
  return own + it->near.capacity * sizeof *it->near.node + it->scratch.keep_capacity +
         it->scratch.renumber_capacity * sizeof *it->scratch.renumber;
}

kith_status kith_built_fields(struct kith_built *built, struct kith_nodes *nodes, const char *const names[5],
                              enum kith_role role) {
  for (int k = 0; k < 2 + NDIM; ++k) {
    struct kith_field **field = k == 0 ? &built->search_radius : k == 1 ? &built->support : &built->x[k - 2];
    const struct kith_field_spec spec = {names[k], KITH_SCALAR, KITH_F64,
                                         role,     NULL,        "what the lists were made from"};
    KITH_TRY(kith_nodes_field(nodes, &spec, field));
  }
  return KITH_OK;
}

void kith_built_copy(const struct kith_nodes *nodes, const struct kith_built *to,
                     const struct kith_built *from) {
  for (int a = 0; a < NDIM; ++a) kith_field_copy(nodes, to->x[a], from->x[a]);
  kith_field_copy(nodes, to->search_radius, from->search_radius);
  kith_field_copy(nodes, to->support, from->support);
}

void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from) {
  const size_t n = (size_t)nodes->n_internal * (size_t)to->components;
#pragma omp parallel for simd schedule(static)
  for (size_t k = 0; k < n; ++k) to->f64[k] = from->f64[k];
}

/* For nodes begin .. end - 1: v += dt A, u += dt rate. */
static void kick_by_rates(struct kith_integrator *it, double dt, kith_index begin, kith_index end) {
  double *restrict u = it->hydro->energy->f64, *restrict v = it->hydro->velocity->f64;
  const double *restrict rate = it->hydro->energy_rate->f64, *restrict a = it->hydro->acceleration->f64;
#pragma omp simd
  for (kith_index i = begin; i < end; ++i) u[i] += dt * rate[i];
#pragma omp simd
  for (size_t k = (size_t)begin * NDIM; k < (size_t)end * NDIM; ++k) v[k] += dt * a[k];
}

/* For nodes begin .. end - 1: v += dt A, u by (1) of package.h, for gas. `late`: t + dt / 2 of (1). */
static void kick(struct kith_integrator *it, double dt, double late, kith_index begin, kith_index end) {
  const struct kith_package *package = it->package;
  double *u = it->hydro->energy->f64;
  kick_by_rates(it, dt, begin, end);
  if (!package->compatible) return;
  const double *restrict correction = package->energy_correction->f64;
  const double *restrict a = package->pair_acceleration->f64;
  for (kith_index i = begin; i < end; ++i)
    if (kith_node_is_gas(it->nodes, i))
      u[i] += dt * (correction[i] - late * kith_dot(a + (size_t)i * NDIM, a + (size_t)i * NDIM));
}

static void finish_kick(struct kith_integrator *it, double dt) {
  it->kick.time += dt;
  kith_through_add(&it->hydro->through, dt, &it->flow.rate);
}

void kith_kick(struct kith_integrator *it, double dt) {
  const double late = it->kick.time + 0.5 * dt;
#pragma omp parallel for schedule(static)
  for (kith_index from = 0; from < it->nodes->n_internal; from += KITH_STRETCH)
    kick(it, dt, late, from, kith_stretch_end(it->nodes, from, it->nodes->n_internal));
  finish_kick(it, dt);
}

void kith_drift_supports(struct kith_integrator *it, double dt) {
  double *restrict h = it->nodes->support->f64;
  const double *restrict velocity_divergence = it->package->velocity_divergence->f64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    h[i] *= kith_support_growth(dt, velocity_divergence[i]);
  it->nodes->positions += 1;
  it->clock += dt;
}

void kith_drift(struct kith_integrator *it, double dt) {
  double *restrict x = it->nodes->position->f64;
  const double *restrict v = it->hydro->velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (size_t k = 0; k < (size_t)it->nodes->n_internal * NDIM; ++k) x[k] += dt * v[k];
  kith_drift_supports(it, dt);
}

void kith_predict(struct kith_integrator *it, double drift, double dt, double later) {
  const kith_index n = it->nodes->n_internal;
  double *x = it->nodes->position->f64, *u = it->hydro->energy->f64, *v = it->hydro->velocity->f64,
         *u0 = it->energy_base->f64, *v0 = it->kick.velocity_base->f64,
         *last = it->scheme->stages ? NULL : it->energy_rate_last->f64;
  const double *rate = it->hydro->energy_rate->f64;
  const double more = it->dt > 0 ? dt * later / it->dt : 0;
  it->kick.lead = dt;
#pragma omp parallel for schedule(static)
  for (kith_index from = 0; from < n; from += KITH_STRETCH) {
    const kith_index all = KITH_MIN(from + KITH_STRETCH, n), end = kith_stretch_end(it->nodes, from, n);
#pragma omp simd
    for (size_t k = (size_t)from * NDIM; k < (size_t)all * NDIM; ++k) x[k] += drift * v[k];
#pragma omp simd
    for (size_t k = (size_t)from * NDIM; k < (size_t)end * NDIM; ++k) v0[k] = v[k];
#pragma omp simd
    for (kith_index i = from; i < end; ++i) u0[i] = u[i];
    kick_by_rates(it, dt, from, end);
    if (last == NULL) continue;
#pragma omp simd
    for (kith_index i = from; i < end; ++i) {
      u[i] += more * (rate[i] - last[i]);
      last[i] = rate[i];
    }
  }
  kith_drift_supports(it, drift);
}

void kith_correct(struct kith_integrator *it, double dt) {
  const kith_index n = it->nodes->n_internal;
  double *u = it->hydro->energy->f64, *v = it->hydro->velocity->f64;
  const double *u0 = it->energy_base->f64, *v0 = it->kick.velocity_base->f64;
  it->kick.time = 0;
#pragma omp parallel for schedule(static)
  for (kith_index from = 0; from < n; from += KITH_STRETCH) {
    const kith_index end = kith_stretch_end(it->nodes, from, n);
#pragma omp simd
    for (size_t k = (size_t)from * NDIM; k < (size_t)end * NDIM; ++k) v[k] = v0[k];
#pragma omp simd
    for (kith_index i = from; i < end; ++i) u[i] = u0[i];
    kick(it, dt, 0.5 * dt, from, end);
  }
  finish_kick(it, dt);
}
