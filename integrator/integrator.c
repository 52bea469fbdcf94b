#include "integrator/integrator.h"

#include <math.h>
#include <string.h>

enum { MAX_GROWTHS = 40 };

kith_status kith_integrator_init(struct kith_integrator *it) {
  const struct kith_field_spec energy = {"energy_base", KITH_SCALAR, KITH_F64,
                                         KITH_WORK,     NULL,        "energy where the kick started"};
  if (it->package->compatible && it->scheme->incompatible != NULL)
    KITH_FAIL(BAD_INPUT, "scheme %s cannot keep a compatible energy: %s", it->scheme->name,
              it->scheme->incompatible);
  KITH_TRY(kith_nodes_field(it->nodes, &energy, &it->energy_base));
  it->evaluations = it->scheme->evaluations;
  if (it->scheme->create != NULL) KITH_TRY(it->scheme->create(it));
  if (kith_rebuilds_lasting(it->rebuilds)) {
    static const char *const names[] = {"built_x", "built_y", "built_z"};
    for (int a = 0; a < NDIM; ++a) {
      const struct kith_field_spec built = {names[a],  KITH_SCALAR, KITH_F64,
                                            KITH_KEPT, NULL,        "where the lists were made from"};
      KITH_TRY(kith_nodes_field(it->nodes, &built, &it->built[a]));
    }
    const struct kith_field_spec reach = {"built_reach", KITH_SCALAR, KITH_F64,
                                          KITH_KEPT,     NULL,        "reach the lists were made with"};
    const struct kith_field_spec support = {"built_support", KITH_SCALAR, KITH_F64,
                                            KITH_KEPT,       NULL,        "support the lists were made with"};
    KITH_TRY(kith_nodes_field(it->nodes, &reach, &it->built_reach));
    KITH_TRY(kith_nodes_field(it->nodes, &support, &it->built_support));
  }
  return KITH_OK;
}

void kith_integrator_clear(struct kith_integrator *it) {
  if (it->self != NULL) it->scheme->destroy(it);
  kith_free(&it->keep);
  kith_free(&it->renumber);
}

void kith_field_copy(const struct kith_nodes *nodes, struct kith_field *to, const struct kith_field *from) {
  const kith_index n = nodes->n_internal * to->components;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < n; ++k) to->f64[k] = from->f64[k];
}

void kith_kick_velocity(struct kith_integrator *it, double dt) {
  const kith_index n = it->nodes->n_internal * NDIM;
  double *restrict v = it->hydro->velocity->f64;
  const double *restrict a = it->hydro->acceleration->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < n; ++k) v[k] += dt * a[k];
}

void kith_kick_energy(struct kith_integrator *it, double dt) {
  double *restrict u = it->hydro->energy->f64;
  const double *restrict rate = it->hydro->energy_rate->f64;
  const double *restrict slope = it->package->energy_slope != NULL ? it->package->energy_slope->f64 : NULL;
  const double late = it->package->kicked + 0.5 * dt;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    u[i] += dt * (rate[i] + (slope != NULL ? late * slope[i] : 0));
  it->package->kicked += dt;
}

void kith_drift_supports(struct kith_integrator *it, double dt) {
  double *restrict h = it->nodes->support->f64;
  const double *restrict expansion = it->package->expansion->f64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    h[i] *= exp(fmax(-0.2, fmin(0.2, dt * expansion[i] / NDIM)));
  it->nodes->positions += 1;
  it->clock += dt;
}

void kith_drift(struct kith_integrator *it, const struct kith_field *velocity, double dt) {
  double *restrict x = it->nodes->position->f64;
  const double *restrict v = velocity->f64;
#pragma omp parallel for simd schedule(static)
  for (kith_index k = 0; k < it->nodes->n_internal * NDIM; ++k) x[k] += dt * v[k];
  kith_drift_supports(it, dt);
}

/* Stages only refresh ghost values. */
static void refresh(struct kith_integrator *it) {
  struct kith_field *const fields[] = {it->nodes->position, it->nodes->support, it->hydro->velocity,
                                       it->hydro->energy};
  kith_profile_begin(it->profile, "refresh");
  kith_nodes_post_ghosts(it->nodes, fields, 4); /* the first sweep awaits them */
  kith_profile_end(it->profile);
  it->ledger.refreshes += 1;
}

static kith_status run_lifecycle(struct kith_integrator *it, const char *reason) {
  kith_profile_begin(it->profile, "lifecycle");
  const kith_status status = kith_lifecycle(it, reason);
  kith_profile_end(it->profile);
  return status;
}

static kith_status run_package(struct kith_integrator *it) {
  kith_profile_begin(it->profile, it->package->ops->name);
  const kith_status status = it->package->ops->evaluate(it->package, it->connectivity);
  kith_profile_end(it->profile);
  return status;
}

kith_status kith_integrator_rates(struct kith_integrator *it) {
  const char *reason = it->due;
  kith_boundaries_move(it->boundaries, it->clock);
  kith_profile_begin(it->profile, "due");
  kith_status status = kith_ranks_agree(it->nodes->ranks, kith_hydro_finite(it->hydro));
  if (status == KITH_OK && reason == NULL) status = kith_rebuilds_due(it->rebuilds, it->nodes, &reason);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->due = NULL;
  it->ledger.evaluations += 1;
  if (reason != NULL)
    KITH_TRY(run_lifecycle(it, reason));
  else
    refresh(it);
  /* A support that grows beyond what the lists cover needs new lists: known only when the density is. */
  for (int growth = 0; (status = run_package(it)) == KITH_REACH; ++growth) {
    if (growth == MAX_GROWTHS)
      return kith_ranks_agree(it->nodes->ranks,
                              kith_fail(KITH_DIVERGED, "a support does not converge: %s after %d rebuilds",
                                        kith_failure(), growth));
    it->ledger.support_rebuilds += 1;
    KITH_TRY(run_lifecycle(it, "support"));
  }
  return status;
}

/* `moved`: what came before the rates went. Agreed. */
static kith_status after_rates(struct kith_integrator *it, kith_status moved) {
  kith_profile_begin(it->profile, "control");
  kith_status status = moved == KITH_OK ? kith_hydro_physical(it->hydro) : moved;
  status = kith_ranks_agree(it->nodes->ranks, status);
  if (status == KITH_OK) it->vote = kith_package_vote(it->package, it->cfl);
  kith_profile_end(it->profile);
  return status;
}

kith_status kith_integrator_start(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "start");
  kith_field_copy(it->nodes, it->package->velocity_base, it->hydro->velocity);
  it->package->kicked = it->package->interval = 0;
  kith_status status = kith_integrator_rates(it);
  if (status == KITH_OK) status = after_rates(it, KITH_OK);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->vote.dt *= 0.1; /* a first step from cold gas is too long: nothing has told the neighbors yet */
  return KITH_OK;
}

/* What the lists were made from, then the present. Nodes were in their places then: they are not to be put back again. */
kith_status kith_integrator_remake(struct kith_integrator *it, struct kith_field *position,
                                   struct kith_field *support) {
  struct kith_nodes *nodes = it->nodes;
  const bool holding = it->holding;
  kith_field_copy(nodes, position, nodes->position);
  kith_field_copy(nodes, support, nodes->support);
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] = it->built[a]->f64[i];
  kith_field_copy(nodes, nodes->support, it->built_support);
  it->holding = true, it->resuming = true;
  const kith_status status = run_lifecycle(it, "first build");
  it->holding = holding, it->resuming = false;
  kith_field_copy(nodes, nodes->position, position);
  kith_field_copy(nodes, nodes->support, support);
  nodes->positions += 1;
  return status;
}

kith_status kith_integrator_resume(struct kith_integrator *it) {
  it->clock = it->time;
  if (it->built_reach == NULL)
    return kith_rebuilds_snapshot(it->rebuilds, it->nodes); /* due anyway, and not the first */
  return kith_integrator_remake(it, it->package->velocity_base, it->energy_base);
}

/* The next step: the vote, no more than a quarter longer than the last, landing on `until`. Says what limited it. */
static double next_dt(struct kith_integrator *it, double until) {
  struct kith_vote vote = it->fixed_dt > 0 ? (struct kith_vote){it->fixed_dt, -1, "fixed"} : it->vote;
  if (it->fixed_dt <= 0 && it->accurate_dt > 0 && it->accurate_dt < vote.dt)
    vote = (struct kith_vote){it->accurate_dt, -1, "accuracy"};
  if (it->fixed_dt <= 0 && it->dt > 0 && vote.dt > KITH_GROWTH * it->dt)
    vote = (struct kith_vote){KITH_GROWTH * it->dt, -1, "growth"};
  const double left = until - it->time;
  if (vote.dt >= left)
    vote = (struct kith_vote){left, -1, "end"};
  else if (vote.dt > 0.5 * left)
    vote = (struct kith_vote){0.5 * left, -1, "end"}; /* two equal steps, not one and a crumb */
  it->limiter = vote.reason;
  it->limiting_node = vote.node;
  return vote.dt;
}

kith_status kith_integrator_step(struct kith_integrator *it, double until) {
  const double wanted = next_dt(it, until);
  double dt = wanted;
  if (!(dt > 0) || !isfinite(dt) || until + 1e-3 * dt == until)
    return kith_ranks_agree(
        it->nodes->ranks, kith_fail(KITH_DIVERGED, "the time step collapsed to %g at time %g: node %lld, %s",
                                    dt, it->time, (long long)it->limiting_node, it->limiter));
  kith_profile_begin(it->profile, "step");
  it->package->interval = dt / KITH_MAX(it->evaluations, 1);
  it->clock = it->time;
  kith_status status = it->scheme->step(it, &dt);
  kith_boundaries_move(it->boundaries, it->clock);
  if (status == KITH_OK)
    status = after_rates(it, kith_boundaries_enforce(it->boundaries, it->nodes, NULL, true));
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->time = dt >= wanted && dt >= until - it->time ? until : it->time + dt;
  it->dt = dt;
  it->step += 1;
  return KITH_OK;
}

/* What all ranks do together. */
static void copy_common(struct kith_ledger *to, const struct kith_ledger *from) {
  to->lifecycles = from->lifecycles, to->support_rebuilds = from->support_rebuilds;
  to->refreshes = from->refreshes, to->evaluations = from->evaluations, to->rejected = from->rejected;
  memcpy(to->because, from->because, sizeof to->because);
}

struct kith_ledger kith_ledger_of_all(const struct kith_ledger *ledger, struct kith_ranks *ranks) {
  uint64_t word[sizeof *ledger / sizeof(uint64_t)];
  struct kith_ledger all;
  memcpy(word, ledger, sizeof word);
  kith_ranks_sum_counts(ranks, word, (int)(sizeof word / sizeof *word));
  memcpy(&all, word, sizeof all);
  copy_common(&all, ledger);
  return all;
}

struct kith_ledger kith_ledger_share(const struct kith_ledger *all, const struct kith_ranks *ranks) {
  struct kith_ledger share = {0};
  if (kith_ranks_rank(ranks) == 0) return *all;
  copy_common(&share, all);
  return share;
}

size_t kith_integrator_bytes(const struct kith_integrator *it) {
  const size_t own = it->scheme->bytes != NULL ? it->scheme->bytes(it) : 0;
  return own + it->keep_capacity + it->renumber_capacity * sizeof *it->renumber;
}
