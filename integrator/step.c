/* A step of the integration. */
#include "integrator/step.h"

#include <math.h>
#include "integrator/lifecycle.h"

enum { MAX_GROWTHS = 40 };

/* ---- lists and rates ---- */

/* Is a rebuild due, for lists that serve until `ahead`? */
static kith_status rebuild_if_due(struct kith_integrator *it) {
  enum kith_rebuild_reason reason = it->due;
  kith_boundaries_move(it->boundaries, it->clock);
  kith_profile_begin(it->profile, "due");
  kith_status status = kith_ranks_allreduce_status(it->nodes->ranks, kith_hydro_finite(it->hydro));
  it->rebuilds->cover.ahead = it->ahead;
  if (status == KITH_OK && reason == KITH_BECAUSE_none)
    status = kith_rebuilds_check(it->rebuilds, it->nodes, &reason);
  it->rebuilds->cover.ahead = 0;
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->due = KITH_BECAUSE_none;
  it->fresh = false;
  return reason != KITH_BECAUSE_none ? kith_lifecycle(it, reason) : KITH_OK;
}

static bool faces_move(const struct kith_boundaries *boundaries) {
  for (int b = 0; b < boundaries->n; ++b) {
    const struct kith_boundary *boundary = boundaries->boundary[b];
    if (kith_boundary_face_velocity(boundary->ops, boundary->settings) != 0) return true;
  }
  return false;
}

/* The lists may miss pairs, and no policy rebuilds them. */
static kith_status stale(const struct kith_integrator *it, const char *why) {
  return kith_fail(
      KITH_STALE,
      "%s, and policy %s does not rebuild the lists: choose displacement or always, or a larger skin", why,
      it->rebuilds->policy[0].ops->name);
}

/* Inside a step: do the lists still serve? */
static kith_status check_stage(struct kith_integrator *it) {
  kith_boundaries_move(it->boundaries, it->clock);
  kith_profile_begin(it->profile, "due");
  const kith_status status = kith_ranks_allreduce_status(it->nodes->ranks, kith_hydro_finite(it->hydro));
  const bool serve =
      status != KITH_OK || (!faces_move(it->boundaries) && kith_rebuilds_covered(it->rebuilds, it->nodes));
  kith_profile_end(it->profile);
  if (serve) return status;
  if (!kith_rebuilds_cover(it->rebuilds)) return stale(it, "nodes moved too far within a step");
  return kith_lifecycle(it, KITH_BECAUSE_stage);
}

/* Ghosts get the values of their nodes: all that is needed where lists are not new. */
static void refresh(struct kith_integrator *it) {
  struct kith_field *const fields[] = {it->nodes->position, it->nodes->support, it->hydro->velocity,
                                       it->hydro->energy};
  kith_profile_begin(it->profile, "refresh");
  kith_halo_start_exchange(it->hydro->halo, it->nodes, fields, 4); /* finished by the first sweep */
  kith_profile_end(it->profile);
  it->ledger.refreshes += 1;
}

static kith_status run_package(struct kith_integrator *it) {
  kith_profile_begin(it->profile, it->package->ops->name);
  const kith_status status = it->package->ops->evaluate(it->package, it->connectivity, &it->kick);
  kith_profile_end(it->profile);
  return status;
}

kith_status kith_integrator_evaluate(struct kith_integrator *it) {
  it->fresh = it->fresh && it->positions == it->nodes->positions;
  if (it->holding && !it->fresh) KITH_TRY(check_stage(it));
  const bool fresh = it->fresh;
  if (!fresh) refresh(it);
  it->fresh = false;
  it->ledger.evaluations += 1;
  kith_status status;
  /* A support that grows beyond what the lists cover needs new lists: known only when the density is. */
  for (int growth = 0; (status = run_package(it)) == KITH_OUTGROWN; ++growth) {
    if (!fresh && !kith_rebuilds_cover(it->rebuilds)) return stale(it, kith_failure());
    if (growth == MAX_GROWTHS)
      return kith_ranks_allreduce_status(
          it->nodes->ranks, kith_fail(KITH_DIVERGED, "a support does not converge: %s after %d rebuilds",
                                      kith_failure(), growth));
    KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_support));
    it->fresh = false;
  }
  return status;
}

kith_status kith_integrator_rates(struct kith_integrator *it) {
  KITH_TRY(rebuild_if_due(it));
  return kith_integrator_evaluate(it);
}

/* ---- the step ---- */

/* Checks the state, and what it allows for the next step. `moved`: how it went before. Agreed. */
static kith_status after_rates(struct kith_integrator *it, kith_status moved) {
  kith_profile_begin(it->profile, "control");
  kith_status status = moved == KITH_OK ? kith_hydro_physical(it->hydro) : moved;
  status = kith_ranks_allreduce_status(it->nodes->ranks, status);
  if (status == KITH_OK) it->timestep_limit = kith_package_timestep_limit(it->package, &it->kick, it->cfl);
  kith_profile_end(it->profile);
  return status;
}

kith_status kith_integrator_start(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "start");
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  it->kick.time = it->kick.evaluation_dt = 0;
  kith_status status = kith_integrator_rates(it);
  if (status == KITH_OK) status = after_rates(it, KITH_OK);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->timestep_limit.dt *=
      0.1; /* a first step from cold gas is too long: nothing has told the neighbors yet */
  return KITH_OK;
}

kith_status kith_integrator_resume(struct kith_integrator *it) {
  it->clock = it->time;
  if (!kith_rebuilds_lasting(it->rebuilds))
    return kith_rebuilds_snapshot(it->rebuilds, it->nodes); /* due anyway, and not the first */
  return kith_lifecycle_remake(it, it->kick.velocity_base, it->energy_base);
}

/* The length of the next step: the limit by the state, no more than a quarter longer than the last, landing
 * on `until`. Says what limited it. */
static double next_dt(struct kith_integrator *it, double until) {
  struct kith_timestep_limit timestep_limit =
      it->fixed_dt > 0 ? (struct kith_timestep_limit){it->fixed_dt, -1, KITH_LIMIT_fixed}
                       : it->timestep_limit;
  if (it->fixed_dt <= 0 && it->accurate_dt > 0 && it->accurate_dt < timestep_limit.dt)
    timestep_limit = (struct kith_timestep_limit){it->accurate_dt, -1, KITH_LIMIT_accuracy};
  if (it->fixed_dt <= 0 && it->dt > 0 && timestep_limit.dt > KITH_GROWTH * it->dt)
    timestep_limit = (struct kith_timestep_limit){KITH_GROWTH * it->dt, -1, KITH_LIMIT_growth};
  const double left = until - it->time;
  if (timestep_limit.dt >= left)
    timestep_limit = (struct kith_timestep_limit){left, -1, KITH_LIMIT_end};
  else if (timestep_limit.dt > 0.5 * left)
    timestep_limit = (struct kith_timestep_limit){
        0.5 * left, -1, KITH_LIMIT_end}; /* two equal steps, not one and a tiny last one */
  it->limiter = timestep_limit.reason;
  it->limiting_node = timestep_limit.node;
  return timestep_limit.dt;
}

/* How long the lists of a step must serve. Where it may be repeated that must not depend on what it is cut
 * down to. */
static double look_ahead(const struct kith_integrator *it, double dt) {
  if (!it->scheme->stages) return 0;
  if (!it->scheme->retries || it->fixed_dt > 0 || it->dt <= 0) return dt;
  return KITH_GROWTH * it->dt;
}

static kith_status take_step(struct kith_integrator *it, double *dt) {
  if (it->scheme->predict != NULL) it->scheme->predict(it, *dt);
  it->ahead = look_ahead(it, *dt);
  KITH_TRY(rebuild_if_due(it));
  it->holding = it->scheme->stages;
  const kith_status status = it->scheme->advance(it, dt);
  it->holding = false, it->ahead = 0;
  return status;
}

kith_status kith_integrator_step(struct kith_integrator *it, double until) {
  const double wanted = next_dt(it, until);
  double dt = wanted;
  if (!(dt > 0) || !isfinite(dt) || until + 1e-3 * dt == until)
    return kith_ranks_allreduce_status(
        it->nodes->ranks,
        kith_fail(KITH_DIVERGED, "the time step collapsed to %g at time %g: node %lld, %s", dt, it->time,
                  (long long)it->limiting_node, kith_limit_name(it->limiter)));
  kith_profile_begin(it->profile, "step");
  it->kick.evaluation_dt = dt / KITH_MAX(it->evaluations, 1);
  it->clock = it->time;
  kith_status status = take_step(it, &dt);
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
