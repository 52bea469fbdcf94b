/* The stages of a step made by a solver of SUNDIALS. */
#include "integrator/schemes/stages.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "integrator/lifecycle.h"

enum { MOST_HALVINGS = 10 };

/* Fields that a repeated step starts from: the state, its rates, the sound speed, the growth of supports. */
enum { POSITION, SUPPORT, VELOCITY, ENERGY, ACCELERATION, ENERGY_RATE, SOUND_SPEED, DIVERGENCE };

kith_status kith_stages_create(struct kith_integrator *it, size_t size, int n_vectors,
                               const struct kith_solver *solver) {
  static const char *const names[] = {"stage_built_radius", "stage_built_support", "stage_built_x",
                                      "stage_built_y", "stage_built_z"};
  static const struct kith_field_spec start[KITH_START_FIELDS] = {
      [POSITION] = KITH_SPEC(POSITION, OWN_WORK, "position_base", "position at the start"),
      [SUPPORT] = KITH_SPEC(SCALAR, OWN_WORK, "support_base", "support at the start"),
      [ACCELERATION] = KITH_SPEC(VECTOR, OWN_WORK, "acceleration_base", "dv/dt at the start"),
      [ENERGY_RATE] = KITH_SPEC(SCALAR, OWN_WORK, "energy_rate_base", "du/dt at the start"),
      [SOUND_SPEED] = KITH_SPEC(SCALAR, OWN_WORK, "sound_speed_base", "sound speed at the start"),
      [DIVERGENCE] = KITH_SPEC(SCALAR, OWN_WORK, "expansion_base", "div v at the start")};
  struct kith_field *const present[KITH_START_FIELDS] = {
      it->nodes->position,     it->nodes->support,
      it->hydro->velocity,     it->hydro->energy,
      it->hydro->acceleration, it->hydro->energy_rate,
      it->hydro->sound_speed,  it->package->velocity_divergence};
  KITH_TRY(kith_resize(&it->self, 0, 1, size));
  struct kith_stages *s = it->self;
  s->solver = solver, s->size = size, s->n_vectors = n_vectors;
  memcpy(s->present, present, sizeof present);
  s->start[VELOCITY] = it->kick.velocity_base, s->start[ENERGY] = it->energy_base; /* all schemes have them */
  for (int k = 0; k < KITH_START_FIELDS; ++k)
    if (s->start[k] == NULL) KITH_TRY(kith_nodes_field(it->nodes, &start[k], &s->start[k]));
  return kith_built_fields(&s->built, it->nodes, names, KITH_OWN_WORK);
}

void kith_stages_forget(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  if (s->vectors != NULL && s->vectors->lacking)
    s->memory = NULL; /* SUNDIALS cannot free what is incomplete */
  s->solver->forget(it);
  kith_vectors_destroy(&s->vectors);
}

/* Sets the solver up with stderr silenced: SUNDIALS takes an error handler only after it has made its memory.
 * It keeps the stream that it found until then and flushes it later, so this one is never closed. */
static bool set_up_silently(struct kith_integrator *it) {
  const struct kith_stages *s = it->self;
  static FILE *nowhere;
  FILE *const told = stderr;
  if (nowhere == NULL) nowhere = fopen("/dev/null", "w");
  if (nowhere != NULL) stderr = nowhere;
  const bool ready = s->solver->set_up(it);
  stderr = told;
  return ready;
}

size_t kith_stages_bytes(const struct kith_integrator *it) {
  const struct kith_stages *s = it->self;
  const size_t vector = (size_t)it->nodes->n_internal * (2 * NDIM + 1) * sizeof(double);
  return s->size + (s->vectors != NULL ? s->vectors->bytes : (size_t)s->n_vectors * vector);
}

/* Makes vectors that view the fields, and a solver, for the present number of nodes, unless they fit: some
 * nodes may have migrated. */
static kith_status fit(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  struct kith_field *const field[] = {it->nodes->position, it->hydro->velocity, it->hydro->energy};
  struct kith_vector_part part[KITH_VECTOR_PARTS];
  const bool fits =
      s->vectors != NULL && s->vectors->part[KITH_VECTOR_ENERGY].length == it->nodes->n_internal;
  if (!kith_ranks_any(it->nodes->ranks, !fits)) return KITH_OK;
  kith_stages_forget(it);
  for (int p = 0; p < KITH_VECTOR_PARTS; ++p)
    part[p] =
        (struct kith_vector_part){&field[p]->f64, (int64_t)it->nodes->n_internal * field[p]->components};
  KITH_TRY(kith_vectors_create(&s->vectors, it->nodes->ranks, KITH_VECTOR_PARTS, part));
  const bool ready = set_up_silently(it) && !s->vectors->lacking;
  if (!ready) kith_stages_forget(it);
  return kith_ranks_allreduce_status(
      it->nodes->ranks, ready ? KITH_OK : kith_fail(KITH_NO_MEMORY, "%s cannot be set up", s->solver->name));
}

static kith_status attempt(struct kith_integrator *it, double *dt) {
  const struct kith_stages *s = it->self;
  const kith_status status = s->solver->solve(it, dt);
  if (s->vectors->lacking) KITH_FAIL(NO_MEMORY, "no memory for the vectors of %s", s->solver->name);
  return status;
}

kith_status kith_stages_begin(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  KITH_TRY(fit(it));
  for (int k = 0; k < KITH_START_FIELDS; ++k) kith_field_copy(it->nodes, s->start[k], s->present[k]);
  kith_built_copy(it->nodes, &s->built, &it->built);
  s->through = it->flow.rate;
  it->kick.time = 0;
  s->lifecycles = it->ledger.lifecycles;
  return KITH_OK;
}

kith_status kith_stages_rates(struct kith_integrator *it, double time) {
  struct kith_stages *s = it->self;
  kith_field_copy(it->nodes, it->nodes->support, s->start[SUPPORT]);
  kith_field_copy(it->nodes, it->package->velocity_divergence, s->start[DIVERGENCE]);
  it->clock = it->time;
  kith_drift_supports(it, time);
  return s->status = kith_integrator_evaluate(it);
}

kith_status kith_stages_again(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  if (it->ledger.lifecycles == s->lifecycles) return KITH_OK;
  kith_built_copy(it->nodes, &it->built, &s->built);
  /* The rates of the start are saved, so their fields serve as scratch. */
  KITH_TRY(kith_lifecycle_remake(it, it->hydro->acceleration, it->hydro->energy_rate));
  s->lifecycles = it->ledger.lifecycles;
  return KITH_OK;
}

static kith_status restore(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  for (int k = 0; k < ACCELERATION; ++k) kith_field_copy(it->nodes, s->present[k], s->start[k]);
  it->nodes->positions += 1;
  KITH_TRY(kith_stages_again(it));
  for (int k = ACCELERATION; k < DIVERGENCE; ++k) kith_field_copy(it->nodes, s->present[k], s->start[k]);
  it->flow.rate = s->through;
  return KITH_OK;
}

kith_status kith_stages_try(struct kith_integrator *it, bool shorter, double *dt) {
  const struct kith_stages *s = it->self;
  kith_status status = attempt(it, dt);
  for (int k = 0; k < MOST_HALVINGS && status == KITH_DIVERGED && shorter; ++k) {
    KITH_TRY(restore(it));
    *dt *= 0.5;
    it->ledger.rejected_steps += 1;
    status = attempt(it, dt);
    it->limiter = s->solver->cut, it->limiting_node = -1;
  }
  return status;
}

void kith_stages_copy_rates(const struct kith_integrator *it, N_Vector rates) {
  const struct kith_hydro *hydro = it->hydro;
  const struct kith_field *const rate[] = {hydro->velocity, hydro->acceleration, hydro->energy_rate};
  for (int part = 0; part < KITH_VECTOR_PARTS; ++part) {
    double *to = kith_vector_numbers(rates, part);
    const double *from = rate[part]->f64;
    const size_t n = (size_t)it->nodes->n_internal * (size_t)rate[part]->components;
#pragma omp parallel for simd schedule(static)
    for (size_t k = 0; k < n; ++k) to[k] = from[k];
  }
}

/* Returns the energy per mass in the frame of the center of mass. */
static double common_energy(const struct kith_hydro *hydro) {
  const struct kith_totals t = kith_hydro_totals(hydro);
  if (!(t.mass > 0)) return 0;
  return fmax(0, (t.kinetic + t.internal - 0.5 * kith_dot(t.momentum, t.momentum) / t.mass) / t.mass);
}

/* Returns 1 / tolerance; without a tolerance there is no scale, and any weight will do. */
static double weight(double tolerance) {
  return tolerance > 0 ? 1 / tolerance : 1;
}

static const double rounding = 1e-12; /* relative to c^2: a thousand times what energies are rounded by */

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
    wu[i] = weight(fmax(rtol * fabs(u[i]) + atol * e, rounding * c[i] * c[i]));
  }
}
