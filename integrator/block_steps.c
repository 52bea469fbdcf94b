/* Block time steps: the ticks of a base step. */
#include "integrator/block_steps.h"

#include <math.h>
#include <string.h>
#include "integrator/flow.h"
#include "integrator/lifecycle.h"
#include "integrator/step.h"

enum {
  FEW = 2,          /* a tick may be local if at most n / FEW of n nodes are active */
  NEW_SEARCH = 160, /* cost of a new search with reordering, per node, in candidates */
};
static const double first_step_factor = 0.1; /* no signal has reached the neighbors yet */

kith_status kith_block_steps_create(struct kith_integrator *it, struct kith_block_settings settings) {
  KITH_TRY(kith_nodes_mark_activity(it->nodes));
  it->search->fresh_cells = true;
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct kith_blocks)));
  struct kith_blocks *b = it->self;
  b->settings = settings;
  b->swings = kith_package_traits(it->package->ops, it->package->settings).swings;
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(SCALAR, STATE, "tick_last", "tick of the last activity"), &b->steps.last},
      {true, KITH_SPEC(SCALAR, STATE, "tick_step", "the step then, in ticks"), &b->steps.step},
      {true, KITH_SPEC(SCALAR, STATE, "tick_next", "the step that an active node takes now"), &b->steps.next},
      {true, KITH_SPEC(SCALAR, STATE, "tick_wanted", "the same without regard to neighbors"), &b->wanted},
      {true, KITH_SPEC(SCALAR, WORK, "tick_due", "tick of the next activity"), &b->due},
      {true, KITH_SPEC(POSITION, WORK, "position_base", "position at the last activity"), &b->position_base},
      {true, KITH_SPEC(SCALAR, WORK, "support_base", "support at the last activity"), &b->support_base},
      {true, KITH_SPEC(SCALAR, WORK, "density_base", "density at the last activity"), &b->density_base},
      {true, KITH_SPEC(VELOCITY, WORK, "velocity_last", "velocity at the last activity"),
       &b->steps.velocity_last},
      {true, KITH_SPEC(SCALAR, WORK, "energy_last", "energy at the last activity"), &b->steps.energy_last},
      {true, KITH_SPEC(VECTOR, WORK, "impulse", "of pairs, at this tick"), &b->steps.impulse},
      {true, KITH_SPEC(SCALAR, WORK, "impulse_heat", "of pairs, at this tick"), &b->steps.heat},
      {true, KITH_SPEC(VECTOR, KEPT, "opening", "impulse of the next base step, per time"),
       &b->steps.opening},
      {true, KITH_SPEC(SCALAR, KEPT, "opening_heat", "the same of the energy"), &b->steps.opening_heat},
      {kith_external_force_acts(&it->hydro->external_force),
       KITH_SPEC(SCALAR, WORK, "fall_missed", "by kicks between ticks"), &b->steps.fall},
      {it->hydro->outside_force != NULL,
       KITH_SPEC(VECTOR, OWN_WORK, "outside_opening", "of partners that are no gas"), &b->steps.outside},
      {it->hydro->outside_force != NULL,
       KITH_SPEC(SCALAR, OWN_WORK, "outside_opening_power", "the same of the energy"),
       &b->steps.outside_power},
      {true, KITH_SPEC(SCALAR, KEPT, "rate_last", "du/dt at the last activity"), &b->steps.rate_last},
      {true, KITH_SPEC(SCALAR, KEPT, "rate_slope", "slope of du/dt before then"), &b->steps.rate_slope},
      {0}};
  KITH_TRY(kith_nodes_fields(it->nodes, fields));
  b->steps.velocity = it->kick.velocity_base, b->steps.energy = it->energy_base;
  return KITH_OK;
}

void kith_block_steps_destroy(struct kith_integrator *it) {
  kith_free(&kith_blocks_of(it)->soonest);
}

/* --- a tick --- */

/* Returns how far a node moves along an axis in a time `since` its last activity, by component k of v and
 * dv/dt then. The velocity is not w of physics/block_steps.h: w has got half of the impulse of a pair with a
 * long step at once, while impulses that balance it may come in parts, by pairs with shorter steps. */
static inline double displacement_of(const struct kith_integrator *it, size_t k, double since) {
  return since *
         (kith_blocks_of(it)->steps.velocity_last->f64[k] + 0.5 * since * it->hydro->acceleration->f64[k]);
}

/* Predicts nodes of it->near, the active ones, the idle ones or both, from their last activity to the present
 * tick. The next step of an active node depends on its pressure and sound speed. Without a prediction these
 * would be of the last tick at which the equation of state was evaluated: idle nodes are skipped by chunks,
 * so which tick that was depends on the order of nodes in memory, and on ranks. */
static void predict(struct kith_integrator *it, bool active, bool idle) {
  struct kith_blocks *b = kith_blocks_of(it);
  const struct kith_block_steps *s = &b->steps;
  double *restrict x = it->nodes->position->f64, *restrict v = it->hydro->velocity->f64;
  const double *restrict last = s->velocity_last->f64, *restrict base = b->position_base->f64,
                         *restrict acceleration = it->hydro->acceleration->f64;
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index n = 0; n < kith_near_count(it); ++n) {
    const kith_index i = kith_near_node(it, n);
    if (!(it->nodes->activity->u8[i] == KITH_ACTIVE ? active : idle)) continue;
    const double since = s->tick * (s->now - s->last->f64[i]);
    for (size_t k = (size_t)i * NDIM; k < (size_t)(i + 1) * NDIM; ++k) {
      x[k] = base[k] + displacement_of(it, k, since);
      v[k] = last[k] + since * acceleration[k];
    }
    it->hydro->energy->f64[i] = s->energy_last->f64[i] + since * (it->hydro->energy_rate->f64[i] +
                                                                  0.5 * since * s->rate_slope->f64[i]);
    const double growth = kith_support_growth(since, it->package->velocity_divergence->f64[i]);
    it->nodes->support->f64[i] = b->support_base->f64[i] * growth;
    it->hydro->density->f64[i] = b->density_base->f64[i] / kith_pow_dim(growth);
    if (it->nodes->activity->u8[i] == KITH_ACTIVE) kith_hydro_evaluate_eos_of(it->hydro, i);
  }
  it->nodes->positions += 1;
}

/* Sets the position of node i at its last activity from its present one. */
static void place_base(struct kith_integrator *it, kith_index i) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const double since = b->steps.tick * (b->steps.now - b->steps.last->f64[i]);
  for (size_t k = (size_t)i * NDIM; k < (size_t)(i + 1) * NDIM; ++k)
    b->position_base->f64[k] = it->nodes->position->f64[k] - displacement_of(it, k, since);
}

/* Extends the box by `radius` to each side of node i. */
static void include_support(struct kith_box *box, const struct kith_integrator *it, kith_index i,
                            double radius) {
  for (int a = 0; a < NDIM; ++a) {
    const double x = it->nodes->position->f64[(size_t)i * NDIM + a];
    box->lower[a] = KITH_MIN(box->lower[a], x - radius), box->upper[a] = KITH_MAX(box->upper[a], x + radius);
  }
}

/* Activates the nodes whose step ends now, and lists them in it->near. */
static kith_status activate(struct kith_integrator *it) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const kith_index n = it->nodes->n_internal;
  KITH_TRY(kith_grow(&it->near.node, &it->near.capacity, 0, (size_t)n + 1, sizeof *it->near.node));
  it->near.n = 0;
  if (n > 0) memset(it->nodes->activity->u8, KITH_IDLE, (size_t)n);
  for (kith_index from = 0; from < n; from += KITH_STRETCH) {
    if (b->soonest[from / KITH_STRETCH] > b->steps.now) continue;
    for (kith_index i = from; i < KITH_MIN(from + KITH_STRETCH, n); ++i) {
      if (b->due->f64[i] > b->steps.now) continue;
      it->nodes->activity->u8[i] = KITH_ACTIVE;
      it->near.node[it->near.n++] = i;
    }
  }
  it->clock = it->time + b->steps.now * b->steps.tick;
  return KITH_OK;
}

/* Are active nodes few, and have candidates that are no neighbors any more (count_wasted_candidates) cost
 * less than a new search would? Then it may pay to search only near the active nodes. */
static bool are_few(const struct kith_integrator *it) {
  const kith_index all = it->nodes->n_internal;
  return !kith_blocks_of(it)->steps.ends && it->near.n <= all / FEW &&
         kith_blocks_of(it)->wasted <= NEW_SEARCH * (double)all;
}

/* May active nodes, or nodes near them, interact with a ghost? */
static bool reach_boundaries(const struct kith_integrator *it) {
  const struct kith_blocks *b = kith_blocks_of(it);
  struct kith_box inside = kith_box_empty(), reach = inside, supports = b->supports;
  for (kith_index k = 0; k < it->near.n; ++k) {
    const kith_index i = it->near.node[k];
    include_support(&inside, it, i, b->slack);
    include_support(&reach, it, i, b->slack + it->nodes->search_radius->f64[i]);
  }
  for (int a = 0; a < NDIM; ++a) supports.lower[a] -= b->slack, supports.upper[a] += b->slack;
  return kith_boundaries_reach(it->boundaries, &inside, &reach, &supports);
}

/* Extends it->near by the nodes that active ones may interact with, and predicts these. Called again when a
 * support has grown. */
static kith_status find_near(struct kith_integrator *it) {
  kith_lifecycle_search_radii(it);
  KITH_TRY(kith_search_near(it->search, kith_blocks_of(it)->slack, &it->near.node, &it->near.capacity,
                            &it->near.n));
  for (kith_index k = 0; k < it->near.n; ++k)
    if (it->nodes->activity->u8[it->near.node[k]] == KITH_TOUCHED)
      it->nodes->activity->u8[it->near.node[k]] = KITH_IDLE;
  predict(it, false, true);
  return KITH_OK;
}

/* Predicts active nodes. If they are few and far from boundaries, the lifecycle finds and predicts the others
 * that matter; else all nodes are predicted. */
static kith_status predict_nodes(struct kith_integrator *it, bool first) {
  KITH_TRY(activate(it));
  const bool few = !first && are_few(it);
  it->near.only = few, it->near.find = find_near;
  predict(it, true, !few);
  if (!few) return KITH_OK;
  kith_lifecycle_search_radii(it);
  it->near.only = !reach_boundaries(it);
  if (!it->near.only) predict(it, false, true);
  return KITH_OK;
}

/* Counts updates by the length of the step that they end. */
static void count_updates(struct kith_integrator *it) {
  const struct kith_block_steps *s = &kith_blocks_of(it)->steps;
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    if (kith_node_active(it->nodes, i))
      kith_levels_add_update(&it->levels, (s->now - s->last->f64[i]) / KITH_TICKS, KITH_TICKS * s->tick);
  }
}

/* Begins the next step of active nodes, after the evaluation. `first`: the first tick of a base step, at
 * which boundaries may have moved nodes. */
static void close_tick(struct kith_integrator *it, bool first) {
  struct kith_blocks *b = kith_blocks_of(it);
  struct kith_block_steps *s = &b->steps;
  double slack = it->near.only ? b->slack : 0;
  struct kith_box supports = it->near.only ? b->supports : kith_box_empty();
#pragma omp declare reduction(join              \
                              : struct kith_box \
                              : kith_box_join(&omp_out, &omp_in)) initializer(omp_priv = kith_box_empty())
#pragma omp parallel for schedule(static) reduction(max      \
                                                    : slack) \
    reduction(join                                           \
              : supports) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    const uint8_t activity = it->nodes->activity->u8[i];
    if (activity == KITH_ACTIVE) {
      s->last->f64[i] = s->now, s->step->f64[i] = b->wanted->f64[i] = s->next->f64[i];
      b->due->f64[i] = s->now + s->next->f64[i];
      b->support_base->f64[i] = it->nodes->support->f64[i];
      b->density_base->f64[i] = it->hydro->density->f64[i];
    }
    if (activity == KITH_ACTIVE || first) place_base(it, i);
    if (s->ends) continue; /* the next base step searches anew among all nodes */
    if (activity != KITH_IDLE) kith_blocks_wake(it, i);
    const double radius = it->nodes->search_radius->f64[i], left = s->tick * (b->due->f64[i] - s->now);
    const double speed = kith_norm(s->velocity_last->f64 + (size_t)i * NDIM) +
                         s->tick * (b->due->f64[i] - s->last->f64[i]) *
                             kith_norm(it->hydro->acceleration->f64 + (size_t)i * NDIM);
    const double growth = kith_support_growth(left, it->package->velocity_divergence->f64[i]);
    slack = KITH_MAX(slack, left * speed + radius * fmax(0, growth - 1));
    include_support(&supports, it, i, radius);
  }
  b->slack = slack, b->supports = supports;
}

/* Updates `soonest` where it may have changed. Ranks agree on a failure when they make the next lists. */
static void update_soonest(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  const kith_index n = it->nodes->n_internal, stretches = (n + KITH_STRETCH - 1) / KITH_STRETCH;
  const double *restrict due = b->due->f64;
  if (it->pending == KITH_OK) /* else keep the earlier failure */
    it->pending = kith_reserve(&b->soonest, &b->soonest_capacity, (size_t)stretches, sizeof *b->soonest);
  if (it->pending != KITH_OK) return;
#pragma omp parallel for schedule(static) if (!it->near.only)
  for (kith_index s = 0; s < stretches; ++s) {
    const kith_index from = s * KITH_STRETCH, stop = KITH_MIN(from + KITH_STRETCH, n);
    if (it->near.only && kith_stretch_end(it->nodes, from, n) == from) continue;
    b->soonest[s] = KITH_TICKS;
    for (kith_index i = from; i < stop; ++i) b->soonest[s] = KITH_MIN(b->soonest[s], due[i]);
  }
}

/* Returns the next tick at which a node of any rank is active. */
static double next_tick(const struct kith_integrator *it) {
  const kith_index n = it->nodes->n_internal;
  double next = it->pending == KITH_OK ? KITH_TICKS : kith_blocks_of(it)->steps.now + 1;
  for (kith_index s = 0; it->pending == KITH_OK && s * KITH_STRETCH < n; ++s)
    next = KITH_MIN(next, kith_blocks_of(it)->soonest[s]);
  next = -next;
  kith_ranks_max(it->nodes->ranks, &next, 1);
  return -next;
}

/* Sets the next steps of active nodes and evaluates their rates. */
static kith_status evaluate(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  kith_blocks_limit_by_neighbors(it);
  b->steps.alike = b->steps.ends && kith_blocks_alike(it); /* else rare, and not tested */
  KITH_TRY(kith_integrator_evaluate(it));
  kith_flow_tick(it, &b->steps);
  return KITH_OK;
}

/* Makes the lists at tick `now`. At the first tick of a base step nodes are also wrapped and migrate. */
static kith_status make_tick_lists(struct kith_integrator *it, bool first) {
  kith_boundaries_move(it->boundaries, it->clock);
  it->kick.blocks = &kith_blocks_of(it)->steps;
  it->holding = !first;
  KITH_TRY(kith_lifecycle(it, it->near.only ? KITH_BECAUSE_selected : KITH_BECAUSE_always));
  KITH_TRY(kith_lifecycle_close(it));
  it->holding = true; /* until the end of the base step */
  return KITH_OK;
}

/* Adds up the candidates of the search beyond those right after a search among all nodes. */
static void count_wasted_candidates(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  const double entries = (double)it->ledger.last_row_entries,
               candidates = (double)it->connectivity->candidates;
  if (it->near.only)
    b->wasted += fmax(0, candidates - b->candidates * entries);
  else
    b->candidates = entries > 0 ? candidates / entries : 0, b->wasted = 0;
}

static kith_status run_tick(struct kith_integrator *it, double n) {
  struct kith_blocks *b = kith_blocks_of(it);
  const bool first = b->steps.now == 0;
  kith_profile_begin(it->profile, "predict");
  b->steps.now = n, b->steps.ends = n == KITH_TICKS;
  const kith_status status = it->pending == KITH_OK ? predict_nodes(it, first) : it->pending;
  if (status != KITH_OK)
    it->pending = status, it->near.only = false, it->near.n = 0; /* agreed on with the lists */
  if (b->steps.ends)
    kith_blocks_plan(it, it->time + KITH_TICKS * b->steps.tick, 1);
  else
    kith_blocks_want(it);
  kith_profile_end(it->profile);
  KITH_TRY(make_tick_lists(it, first));
  KITH_TRY(evaluate(it));
  if (b->steps.ends) kith_blocks_shorten(it);
  kith_profile_begin(it->profile, "kick");
  count_updates(it);
  close_tick(it, first);
  count_wasted_candidates(it);
  update_soonest(it);
  kith_profile_end(it->profile);
  return KITH_OK;
}

/* --- a base step --- */

kith_status kith_block_steps_start(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  b->steps.now = b->steps.tick = 0, b->steps.ends = true;
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    b->steps.last->f64[i] = 0, b->steps.step->f64[i] = 1;
    it->nodes->activity->u8[i] = KITH_ACTIVE;
  }
  kith_field_copy(it->nodes, b->steps.velocity, it->hydro->velocity);
  kith_field_copy(it->nodes, b->steps.energy, it->hydro->energy);
  kith_blocks_plan(it, it->time, first_step_factor);
  it->kick.blocks = &b->steps;
  kith_halo_refresh(it->hydro->halo, it->nodes,
                    (struct kith_field *[]){b->steps.last, b->steps.step, b->wanted}, 3);
  const kith_status status = evaluate(it); /* with the lists of the first rates */
  it->kick.blocks = NULL;
  return status;
}

void kith_block_steps_begin(struct kith_integrator *it, double dt) {
  struct kith_blocks *b = kith_blocks_of(it);
  struct kith_block_steps *s = &b->steps;
  s->now = 0, s->tick = dt / KITH_TICKS, s->ends = false;
  it->levels.base_steps += 1, it->levels.time += dt;
  kith_through_add(&it->hydro->through, dt, &it->flow.rate);
  kith_field_copy(it->nodes, s->velocity_last, it->hydro->velocity);
  kith_field_copy(it->nodes, s->energy_last, it->hydro->energy);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    const double *opening = s->opening->f64 + (size_t)i * NDIM,
                 work = 0.5 * dt * dt * kith_dot(opening, opening);
    double g[NDIM] = {0};
    if (kith_external_force_acts(&it->hydro->external_force))
      kith_external_force_add(&it->hydro->external_force, it->nodes->position->f64 + (size_t)i * NDIM, g);
    for (int a = 0; a < NDIM; ++a)
      it->hydro->velocity->f64[(size_t)i * NDIM + a] +=
          dt * opening[a] + 0.5 * s->tick * s->next->f64[i] * g[a];
    it->hydro->energy->f64[i] += dt * s->opening_heat->f64[i] - (it->package->compatible ? work : 0);
    s->last->f64[i] = 0, s->step->f64[i] = b->wanted->f64[i] = s->next->f64[i];
    b->support_base->f64[i] = it->nodes->support->f64[i];
    b->density_base->f64[i] = it->hydro->density->f64[i];
    b->due->f64[i] = s->step->f64[i];
    if (s->fall != NULL) s->fall->f64[i] = 0;
    if (it->step > 0) kith_blocks_wake_by_limit(it, i);
    it->nodes->activity->u8[i] = KITH_IDLE;
  }
  kith_field_copy(it->nodes, s->velocity, it->hydro->velocity);
  kith_field_copy(it->nodes, s->energy, it->hydro->energy);
  kith_field_copy(it->nodes, b->position_base, it->nodes->position);
}

kith_status kith_block_steps_advance(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  kith_status status = KITH_OK;
  update_soonest(it);
  while (status == KITH_OK && b->steps.now < KITH_TICKS) {
    const double n = next_tick(it), since = kith_seconds();
    if (n >= b->steps.now + 1)
      status = run_tick(it, n);
    else
      status = kith_ranks_allreduce_status(
          it->nodes->ranks,
          kith_fail(KITH_DIVERGED, "a time step collapsed below %g at time %g", b->steps.tick, it->clock));
    kith_levels_add_tick(&it->levels, n / KITH_TICKS, kith_seconds() - since);
  }
  it->holding = it->near.only = false, it->kick.blocks = NULL;
  if (status != KITH_OK) return status;
  kith_field_copy(it->nodes, it->hydro->velocity, b->steps.velocity);
  kith_field_copy(it->nodes, it->hydro->energy, b->steps.energy);
  return KITH_OK;
}
