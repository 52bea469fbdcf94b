/* A step of the integration. */
#include "integrator/step.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "integrator/flow.h"
#include "integrator/lifecycle.h"
#include "integrator/window.h"

enum { MAX_GROWTHS = 40 };

static bool has_blocks(const struct kith_integrator *it) {
  return kith_scheme_has_blocks(it->scheme, it->settings);
}

/* ---- lists and rates ---- */

static bool faces_move(const struct kith_boundaries *boundaries) {
  for (int b = 0; b < boundaries->n; ++b)
    if (kith_boundary_face_velocity(boundaries->boundary[b]->ops, boundaries->boundary[b]->settings) != 0)
      return true;
  return false;
}

/* Sets *reason to why a rebuild is due, or to none. At the start of a step policies decide, for lists that
 * serve until `ahead`; inside of one a rebuild is due if nodes moved further than the lists cover. */
static kith_status check_lists(struct kith_integrator *it, enum kith_rebuild_reason *reason) {
  struct kith_rebuilds *rebuilds = it->rebuilds;
  bool covered = false;
  if (it->pending == KITH_OK) it->pending = kith_hydro_finite(it->hydro);
  *reason = it->due;
  if (*reason == KITH_BECAUSE_none && !it->holding) *reason = kith_rebuilds_certain(rebuilds);
  if (*reason != KITH_BECAUSE_none) return KITH_OK; /* ranks agree on `pending` in the lifecycle */
  const kith_status mine = it->pending;
  it->pending = KITH_OK;
  if (!it->holding) {
    rebuilds->cover.ahead = it->ahead;
    const kith_status status = kith_rebuilds_check(rebuilds, it->nodes, mine, reason);
    rebuilds->cover.ahead = 0;
    return status;
  }
  KITH_TRY(faces_move(it->boundaries) ? kith_ranks_allreduce_status(it->nodes->ranks, mine)
                                      : kith_rebuilds_covered(rebuilds, it->nodes, mine, &covered));
  if (covered) return KITH_OK;
  *reason = KITH_BECAUSE_stage;
  return kith_rebuilds_allow(rebuilds, it->nodes, -1, "nodes moved too far within a step");
}

/* Rebuilds the lists, again and again as long as they show sleeping nodes that wake (window.h). */
static kith_status rebuild_lists(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  KITH_TRY(kith_lifecycle(it, reason));
  while (it->follows) {
    KITH_TRY(kith_lifecycle_close(it));
    if (!kith_window_meets(it)) break;
    KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_requested));
  }
  return KITH_OK;
}

/* Rebuilds the lists if that is due. evaluates: the caller evaluates the packages at once, by which ranks
 * agree on the status. */
static kith_status rebuild_if_due(struct kith_integrator *it, bool evaluates) {
  enum kith_rebuild_reason reason = KITH_BECAUSE_none;
  kith_status status;
  kith_boundaries_move(it->boundaries, it->clock);
  KITH_STAGE(status, it->profile, "due", check_lists(it, &reason));
  KITH_TRY(status);
  it->due = KITH_BECAUSE_none;
  it->fresh = false;
  if (reason == KITH_BECAUSE_none) return KITH_OK;
  KITH_TRY(rebuild_lists(it, reason));
  return evaluates ? KITH_OK : kith_lifecycle_close(it);
}

/* Starts to copy node values to ghosts, which is enough where lists are not new. */
static void refresh(struct kith_integrator *it) {
  struct kith_field *const fields[] = {it->nodes->position, it->nodes->support, it->hydro->velocity,
                                       it->hydro->energy};
  kith_profile_begin(it->profile, "refresh");
  kith_halo_start_exchange(it->hydro->halo, it->nodes, fields, 4); /* finished by the first sweep */
  kith_profile_end(it->profile);
  it->ledger.refreshes += 1;
}

static uint64_t active_nodes(const struct kith_integrator *it) {
  uint64_t active = 0;
#pragma omp parallel for schedule(static) reduction(+ : active) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k)
    active += kith_node_active(it->nodes, kith_near_node(it, k));
  return active;
}

kith_status kith_integrator_evaluate(struct kith_integrator *it) {
  it->fresh = it->fresh && it->positions == it->nodes->positions;
  if (it->holding && !it->fresh) KITH_TRY(rebuild_if_due(it, true));
  const bool fresh = it->fresh;
  if (!fresh) refresh(it);
  it->fresh = false;
  it->ledger.evaluations += 1, it->ledger.updates += active_nodes(it);
  kith_status status;
  /* A support may outgrow the lists, which is known only after the density pass: then lists are remade. */
  for (int growth = 0;
       (status = kith_package_evaluate(it->package, it->connectivity, &it->kick)) == KITH_OUTGROWN;
       ++growth) {
    if (!fresh) KITH_TRY(kith_rebuilds_allow(it->rebuilds, it->nodes, kith_failed_node(), kith_failure()));
    if (growth == MAX_GROWTHS)
      return kith_ranks_allreduce_status(
          it->nodes->ranks,
          kith_fail_node(KITH_DIVERGED, kith_failed_node(),
                         "a support does not converge: %s after %d rebuilds", kith_failure(), growth));
    KITH_TRY(rebuild_lists(it, KITH_BECAUSE_support));
    it->fresh = false;
  }
  if (status == KITH_OK) status = kith_lifecycle_close(it);
  if (status == KITH_OK) kith_flow_rates(it);
  return status;
}

kith_status kith_integrator_rates(struct kith_integrator *it) {
  KITH_TRY(rebuild_if_due(it, true));
  return kith_integrator_evaluate(it);
}

/* ---- the step ---- */

/* Agrees with all ranks on status, next time-step limit, wishes and summary after a step. */
static kith_status agree(struct kith_integrator *it, kith_status status) {
  struct kith_hydro_sums sums;
  uint64_t count[] = {(uint64_t)it->nodes->n_internal, (uint64_t)it->nodes->n_ghost,
                      it->ledger.last_row_entries,
                      it->decomposition != NULL ? it->decomposition->migrated : 0};
  struct kith_shared parts[4 + KITH_HYDRO_PARTS] = {{KITH_SHARE_LEAST, KITH_LIMIT_WORDS, &it->timestep_limit},
                                                    {KITH_SHARE_MAX, KITH_WISHES, it->wish},
                                                    {KITH_SHARE_SUM, 4, count},
                                                    kith_sum_shared(&it->flow.lifted)};
  int n = 4;
  if (it->ask != NULL) it->ask(it->asker, it->wish);
  if (it->summarizes) kith_hydro_sum(it->hydro, &sums);
  if (it->summarizes) n += kith_hydro_share(&sums, parts + n);
  KITH_TRY(kith_ranks_agree(it->nodes->ranks, status != KITH_OK ? status : it->pending, n, parts));
  it->hydro->through.energy += kith_sum_value(&it->flow.lifted);
  it->flow.lifted = (struct kith_sum){0};
  if (!it->summarizes) return KITH_OK;
  it->summary =
      (struct kith_summary){kith_hydro_totals_of(it->hydro, &sums), count[0], count[1], count[2], count[3]};
  return KITH_OK;
}

/* Checks the state and sets the limit of the next step. `moved` is the status so far. Ranks agree. */
static kith_status after_rates(struct kith_integrator *it, kith_status moved) {
  kith_profile_begin(it->profile, "control");
  kith_status status = moved == KITH_OK ? kith_hydro_physical(it->hydro) : moved;
  if (status == KITH_OK) it->timestep_limit = kith_package_limit_of_rank(it->package, it->cfl);
  status = agree(it, status);
  if (status == KITH_OK && has_blocks(it)) it->timestep_limit.dt = it->planned;
  kith_profile_end(it->profile);
  return status;
}

/* Sets the velocity of what nodes might meet, from the totals at the start. */
static void set_rest_velocity(struct kith_integrator *it, const struct kith_totals *first) {
  double *const velocity = it->hydro->rest_velocity;
  const bool held = kith_boundaries_held(it->boundaries) != NULL || it->package->barrier != NULL;
  for (int a = 0; a < NDIM; ++a)
    velocity[a] = !held && first->mass > 0 ? first->momentum[a] / first->mass : 0;
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (b->ops->mirrors || b->ops->face_velocity != NULL)
      velocity[b->axis] = kith_boundary_face_velocity(b->ops, b->settings);
  }
}

/* Tells hydro where the zones of outflows end, whose last nodes lack partners. */
static void set_zone_ends(struct kith_integrator *it) {
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (!b->ops->leaves) continue;
    double *zone = it->hydro->zone_ends[b->axis][b->at_upper];
    zone[0] = b->at_upper ? b->upper : b->lower;
    zone[1] = zone[0] + kith_flow_outwards(b) * kith_flow_deepest(b);
  }
}

kith_status kith_integrator_start(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "start");
  set_zone_ends(it);
  if (it->step == 0) {
    const struct kith_totals first = kith_hydro_totals(it->hydro);
    set_rest_velocity(it, &first);
  }
  kith_field_copy(it->nodes, it->kick.velocity_base, it->hydro->velocity);
  kith_field_copy(it->nodes, it->energy_base, it->hydro->energy);
  it->kick.time = it->kick.lead = it->kick.evaluation_dt = 0;
  it->clock = it->time;
  if (it->nodes->activity != NULL)
    memset(it->nodes->activity->u8, KITH_ACTIVE, (size_t)it->nodes->n_internal);
  kith_status status = kith_integrator_rates(it);
  if (it->energy_rate_last != NULL) kith_field_copy(it->nodes, it->energy_rate_last, it->hydro->energy_rate);
  if (status == KITH_OK && has_blocks(it)) status = it->scheme->start(it);
  kith_status mine = KITH_OK;
  if (status == KITH_OK && it->follows) {
    mine = kith_hydro_physical(it->hydro); /* while all are awake */
    kith_window_begin(it);
  }
  if (status == KITH_OK) status = after_rates(it, mine);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  /* From cold gas the first step would be too long: no signal has reached the neighbors yet. */
  if (!has_blocks(it)) it->timestep_limit.dt *= 0.1;
  return KITH_OK;
}

kith_status kith_integrator_resume(struct kith_integrator *it, const struct kith_totals *first) {
  it->clock = it->time;
  set_zone_ends(it);
  set_rest_velocity(it, first);
  if (!kith_rebuilds_lasting(it->rebuilds))
    return kith_rebuilds_snapshot(it->rebuilds, it->nodes); /* due in every step, but not as first_build */
  /* Overwrites both fields, which no node that sleeps needs: there is no window with Verlet lists. */
  return kith_lifecycle_remake(it, it->kick.velocity_base, it->energy_base);
}

/* Returns the length of the next step: the limit by the state, at most KITH_GROWTH times the last step,
 * landing on `until`. Records what limited it. */
static double next_dt(struct kith_integrator *it, double until) {
  struct kith_timestep_limit limit = it->timestep_limit;
  const double left = until - it->time;
  if (it->fixed_dt > 0)
    limit = (struct kith_timestep_limit){it->fixed_dt, -1, KITH_LIMIT_fixed};
  else {
    if (it->accurate_dt > 0 && it->accurate_dt < limit.dt)
      limit = (struct kith_timestep_limit){it->accurate_dt, -1, KITH_LIMIT_accuracy};
    if (it->dt > 0 && limit.dt > KITH_GROWTH * it->dt && !has_blocks(it))
      limit = (struct kith_timestep_limit){KITH_GROWTH * it->dt, -1, KITH_LIMIT_growth};
  }
  const bool last = limit.dt >= left * (1 - 1e-9); /* round-off of many equal steps may leave a little more */
  if (limit.dt > 0.5 * left)                       /* two equal steps, not one and a tiny last one */
    limit = (struct kith_timestep_limit){last ? left : 0.5 * left, -1, KITH_LIMIT_end};
  it->limiter = limit.reason;
  it->limiting_node = limit.node;
  return limit.dt;
}

/* Returns how long the lists of a step must serve. In a scheme that may repeat a step this must not depend on
 * the dt that it is cut down to. */
static double look_ahead(const struct kith_integrator *it, double dt) {
  if (!it->scheme->stages) return 0;
  if (!it->scheme->retries || it->fixed_dt > 0 || it->dt <= 0) return dt;
  return KITH_GROWTH * it->dt;
}

static kith_status take_step(struct kith_integrator *it, double *dt) {
  if (it->scheme->predict != NULL) KITH_TRY(it->scheme->predict(it, *dt));
  it->ahead = look_ahead(it, *dt);
  if (!has_blocks(it)) /* block steps make lists at the first tick */
    KITH_TRY(rebuild_if_due(it, it->scheme->predict != NULL));
  it->holding = it->scheme->stages;
  const kith_status status = it->scheme->advance(it, dt);
  it->holding = false, it->ahead = 0;
  return status;
}

kith_status kith_integrator_step(struct kith_integrator *it, double until) {
  if (until != it->until) it->every = until - it->time, it->until = until;
  const double wanted = next_dt(it, until);
  double dt = wanted;
  if (!(dt > 0) || !isfinite(dt) || until + 1e-3 * dt == until) {
    char node[32] = ""; /* a given step is of no node */
    if (it->limiting_node >= 0) snprintf(node, sizeof node, "node %lld, ", (long long)it->limiting_node);
    return kith_ranks_allreduce_status(
        it->nodes->ranks,
        kith_fail_node(KITH_DIVERGED, it->limiting_node,
                       "the time step collapsed to %g at time %g: %s%s; such steps never reach %g", dt,
                       it->time, node, kith_limit_name(it->limiter), until));
  }
  kith_profile_begin(it->profile, "step");
  it->kick.evaluation_dt = dt / KITH_MAX(it->evaluations, 1);
  it->clock = it->time;
  kith_status status = take_step(it, &dt);
  kith_boundaries_move(it->boundaries, it->clock);
  if (status == KITH_OK && it->follows) kith_window_follow(it);
  if (status == KITH_OK) status = after_rates(it, kith_flow_mirror(it)); /* puts nodes beyond mirrors back */
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->time = dt >= wanted && dt >= until - it->time ? until : it->time + dt;
  it->dt = dt;
  it->step += 1;
  return KITH_OK;
}
