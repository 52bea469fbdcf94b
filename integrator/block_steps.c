/* Block time steps: the ticks of a base step. */
#include "integrator/block_steps.h"

#include <math.h>
#include <string.h>
#include "integrator/lifecycle.h"
#include "integrator/step.h"
#include "lib/core/random.h"

enum {
  GROWTH = 2,      /* of a node's step, from one to the next */
  FEW = 4,         /* fewer active nodes than this part of all are looked up, with what is near them */
  NEW_SEARCH = 40, /* what a new search costs for each node, in candidates */
};
static const double tolerated = 1.2; /* times the limit: a step is cut short only if it is longer than that */
static const double start = 0.1;     /* the first steps: nothing has told the neighbors yet */

struct blocks {
  struct kith_block_steps steps; /* what packages see: first */
  struct kith_block_settings settings;
  struct kith_field *wanted;                      /* ticks: by the node's own limits; d if it is not active */
  struct kith_field *due;                         /* the tick of the next activity */
  struct kith_field *position_base, *moved;       /* where it was at the tick of the last kick */
  struct kith_field *support_base, *density_base; /* at the last activity */
  double planned;                                 /* length of the next base step */
  /* For ticks that are local. The supports of all nodes lie in a box, and nodes do not move farther than
   * `slack`, less what their search radii grow, until they are taken in again. Candidates for each neighbor
   * when all nodes were, and how many more there have been since, because nodes have moved. */
  struct kith_box supports;
  double slack, candidates, wasted;
};

static struct blocks *blocks_of(const struct kith_integrator *it) {
  return it->self;
}

kith_status kith_block_steps_create(struct kith_integrator *it, struct kith_block_settings settings) {
  KITH_TRY(kith_nodes_mark_activity(it->nodes));
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct blocks)));
  struct blocks *b = it->self;
  b->settings = settings;
#define SCALAR(name, role, doc) \
  { name, KITH_SCALAR, KITH_F64, role, NULL, doc }
#define VECTOR(name, role, doc) \
  { name, KITH_VECTOR, KITH_F64, role, NULL, doc }
  const struct kith_field_row fields[] = {
      {true, SCALAR("tick_last", KITH_STATE, "tick of the last activity"), &b->steps.last},
      {true, SCALAR("tick_step", KITH_STATE, "the step then, in ticks"), &b->steps.step},
      {true, SCALAR("tick_next", KITH_STATE, "the step that an active node takes now"), &b->steps.next},
      {true, SCALAR("tick_wanted", KITH_STATE, "the same without regard to neighbors"), &b->wanted},
      {true, SCALAR("tick_due", KITH_WORK, "tick of the next activity"), &b->due},
      {true, SCALAR("tick_moved", KITH_WORK, "tick of the last kick"), &b->moved},
      {true, {"position_base", KITH_POSITION, KITH_F64, KITH_WORK, NULL, "position then"}, &b->position_base},
      {true, SCALAR("support_base", KITH_WORK, "support at the last activity"), &b->support_base},
      {true, SCALAR("density_base", KITH_WORK, "density at the last activity"), &b->density_base},
      {true, VECTOR("velocity_last", KITH_WORK, "velocity at the last activity"), &b->steps.velocity_last},
      {true, SCALAR("energy_last", KITH_WORK, "energy at the last activity"), &b->steps.energy_last},
      {true, VECTOR("impulse", KITH_WORK, "of pairs, at this tick"), &b->steps.impulse},
      {true, SCALAR("impulse_heat", KITH_WORK, "of pairs, at this tick"), &b->steps.heat},
      {true, VECTOR("opening", KITH_KEPT, "impulse of the next base step, per time"), &b->steps.opening},
      {true, SCALAR("opening_heat", KITH_KEPT, "the same of the energy"), &b->steps.opening_heat},
      {true, SCALAR("rate_last", KITH_KEPT, "du/dt at the last activity"), &b->steps.rate_last},
      {true, SCALAR("rate_slope", KITH_KEPT, "change of du/dt since then"), &b->steps.rate_slope},
      {0}};
#undef SCALAR
#undef VECTOR
  KITH_TRY(kith_nodes_fields(it->nodes, fields));
  b->steps.velocity = it->kick.velocity_base, b->steps.energy = it->energy_base;
  return KITH_OK;
}

void kith_block_steps_destroy(struct kith_integrator *it) {
  it->kick.blocks = NULL;
  kith_free(&it->near.node);
  it->near.capacity = 0;
  kith_free(&it->self);
}

double kith_block_steps_planned(const struct kith_integrator *it) {
  return blocks_of(it)->planned;
}

/* --- how long steps are --- */

/* The largest power of two that is no more than this many ticks. */
static double power_of_two(double ticks) {
  int exponent;
  if (!(ticks < KITH_TICKS)) return KITH_TICKS;
  frexp(ticks, &exponent);
  return ldexp(1, exponent - 1);
}

/* The largest power of two that divides tick n: where steps of that length end. */
static double aligned(double n) {
  const int64_t whole = (int64_t)n;
  return whole == 0 ? KITH_TICKS : (double)(whole & -whole);
}

/* Numbers in [0, 1) that depend on node and time alone. */
static double random_of(const struct kith_integrator *it, kith_index i, double salt) {
  const struct blocks *b = blocks_of(it);
  const uint64_t x = b->settings.seed + (uint64_t)it->nodes->id->i64[i] * UINT64_C(0x9e3779b97f4a7c15) +
                     (uint64_t)(b->steps.now + salt) * UINT64_C(0xd1342543de82ef95) +
                     it->step * UINT64_C(0x2545f4914f6cdd1d);
  return (double)(kith_mixed_bits(x) >> 11) / 9007199254740992.0;
}

/* The longest step that the state of node i allows; a fixed step is the base step, and random ones are
 * shorter by up to 2^5. */
static double limit_of(const struct kith_integrator *it, kith_index i) {
  const struct blocks *b = blocks_of(it);
  const double limit = it->fixed_dt > 0 ? INFINITY : kith_package_limit_of_node(it->package, i, it->cfl).dt;
  if (b->settings.seed == 0) return limit;
  return KITH_MIN(limit, it->fixed_dt > 0 ? it->fixed_dt : INFINITY) * exp2(-5 * random_of(it, i, 0.25));
}

/* Least and largest of the longest steps that nodes allow now, of all ranks. */
static void range_of_limits(const struct kith_integrator *it, double factor, double *least, double *most) {
  const struct blocks *b = blocks_of(it);
  double low = INFINITY, high = 0;
#pragma omp parallel for schedule(static) reduction(min : low) reduction(max : high)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    const double growth = b->steps.tick > 0 ? GROWTH * b->steps.tick * b->steps.step->f64[i] : INFINITY;
    const double dt = KITH_MIN(factor * limit_of(it, i), growth);
    b->wanted->f64[i] = dt;
    low = KITH_MIN(low, dt), high = KITH_MAX(high, dt);
  }
  double both[] = {-low, high};
  kith_ranks_max(it->nodes->ranks, both, 2);
  *least = -both[0], *most = both[1];
}

/* The length of a base step that costs least per time: a part of what is left until the next output, no
 * longer than `longest`. Steps are rounded down to powers of two of it, so a shorter one may suit more nodes.
 * A tick costs about as much as an update of a tenth of the nodes, whatever it updates. */
static double cheapest_base(const struct kith_integrator *it, double longest, double left) {
  enum { PARTS = 8, LENGTHS = 3 * PARTS }; /* of an octave; all that are tried */
  const double *restrict wanted = blocks_of(it)->wanted->f64, fewest = left > 0 ? ceil(left / longest) : 1;
  uint64_t updates[LENGTHS + 1] = {0};
  double length[LENGTHS], ticks[LENGTHS] = {0}, best = longest, least = INFINITY;
  for (int k = 0; k < LENGTHS; ++k) {
    const double shorter = exp2((double)k / PARTS);
    length[k] = left > 0 ? left / ceil(fewest * shorter) : longest / shorter;
    uint64_t sum = 0;
    double most = 0;
#pragma omp parallel for schedule(static) reduction(+ : sum) reduction(max : most)
    for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
      const double steps = KITH_TICKS / power_of_two(wanted[i] / length[k] * KITH_TICKS);
      sum += (uint64_t)steps;
      most = KITH_MAX(most, steps);
    }
    updates[k] = sum, ticks[k] = most;
  }
  updates[LENGTHS] = (uint64_t)it->nodes->n_internal;
  kith_ranks_sum_counts(it->nodes->ranks, updates, LENGTHS + 1);
  kith_ranks_max(it->nodes->ranks, ticks, LENGTHS);
  for (int k = 0; k < LENGTHS; ++k) {
    const double cost = ((double)updates[k] + 0.1 * ticks[k] * (double)updates[LENGTHS]) / length[k];
    if (cost < least) least = cost, best = length[k];
  }
  return best;
}

/* The next base step, from `time` on: it lands on the next output, after that on one as far away again. */
static void plan(struct kith_integrator *it, double time, double factor) {
  struct blocks *b = blocks_of(it);
  double least, most, left = it->until - time;
  range_of_limits(it, factor, &least, &most);
  if (!(left > 1e-9 * it->every)) left = it->every;
  const double longest = KITH_MIN(most, ldexp(least, b->settings.levels));
  b->planned = it->fixed_dt > 0    ? it->fixed_dt
               : isfinite(longest) ? cheapest_base(it, longest, left)
               : left > 0          ? left
                                   : longest;
  const double tick = b->planned / KITH_TICKS;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    b->wanted->f64[i] = isfinite(tick) ? power_of_two(b->wanted->f64[i] / tick) : KITH_TICKS;
}

/* The steps that active nodes want at tick n, inside of a base step. */
static void want(struct kith_integrator *it) {
  struct blocks *b = blocks_of(it);
  const double most = aligned(b->steps.now);
#pragma omp parallel for schedule(static) if (it->near.n > KITH_FEW)
  for (kith_index k = 0; k < it->near.n; ++k) {
    const kith_index i = it->near.node[k];
    b->wanted->f64[i] = KITH_MIN(power_of_two(limit_of(it, i) / b->steps.tick),
                                 KITH_MIN(most, GROWTH * b->steps.step->f64[i]));
  }
}

/* The shortest step that a node or ghost of this rank wants; frozen ones want none. */
static double finest_wanted(const struct kith_integrator *it) {
  const double *restrict wanted = blocks_of(it)->wanted->f64, *restrict step = blocks_of(it)->steps.step->f64;
  const kith_index n = it->near.only ? it->near.n : kith_nodes_count(it->nodes);
  double finest = KITH_TICKS;
#pragma omp parallel for schedule(static) reduction(min : finest) if (n > KITH_FEW)
  for (kith_index k = 0; k < n; ++k) {
    const kith_index i = kith_near_node(it, k);
    finest = KITH_MIN(finest, step[i] > 0 ? wanted[i] : KITH_TICKS);
  }
  return finest;
}

/* By the neighbors: at most `ratio` times what any of them wants. */
static void limit_by_neighbors(struct kith_integrator *it) {
  struct blocks *b = blocks_of(it);
  const struct kith_rows *rows = &it->connectivity->rows;
  const double *restrict wanted = b->wanted->f64, *restrict step = b->steps.step->f64;
  const double allowed = b->settings.ratio * finest_wanted(it); /* whoever the neighbors are */
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    double finest = INFINITY;
    b->steps.next->f64[i] = wanted[i];
    if (wanted[i] <= allowed || !kith_node_active(it->nodes, i)) continue;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (step[rows->node[e]] > 0) finest = KITH_MIN(finest, wanted[rows->node[e]]);
    b->steps.next->f64[i] = KITH_MIN(wanted[i], b->settings.ratio * finest);
  }
  kith_halo_refresh(it->hydro->halo, it->nodes, &b->steps.next, 1);
}

/* Have all nodes of all ranks the same steps? Then all pairs have the same weight. Frozen ones have any. */
static bool alike(const struct kith_integrator *it) {
  const struct kith_nodes *nodes = it->nodes;
  const struct kith_block_steps *s = &blocks_of(it)->steps;
  const double *restrict last = s->last->f64, *restrict step = s->step->f64, *restrict next = s->next->f64;
  double range[] = {-INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY, -INFINITY};
#pragma omp parallel for schedule(static) reduction(max : range[:6])
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double value[] = {last[i], step[i], next[i]};
    for (int k = 0; k < 3; ++k) {
      range[k] = KITH_MAX(range[k], value[k]);
      range[3 + k] = KITH_MAX(range[3 + k], -value[k]);
    }
  }
  kith_ranks_max(nodes->ranks, range, 6);
  return range[0] == -range[3] && range[1] == -range[4] && range[2] == -range[5];
}

/* Node i is active after this many ticks at the latest. */
static void wake_in(struct blocks *b, kith_index i, double ticks) {
  b->due->f64[i] = KITH_MIN(b->due->f64[i], b->steps.now + ticks);
}

/* After an evaluation: what the new rates allow, and what the steps of active neighbors do. */
static void wake(struct kith_integrator *it, kith_index i) {
  struct blocks *b = blocks_of(it);
  const struct kith_rows *rows = &it->connectivity->rows;
  const double step = b->steps.step->f64[i], own = power_of_two(tolerated * limit_of(it, i) / b->steps.tick);
  if (own < step && isfinite(b->settings.ratio)) wake_in(b, i, own);
  if (b->settings.seed != 0 && random_of(it, i, 0.5) < 0.1) wake_in(b, i, aligned(b->steps.now));
  if (b->steps.last->f64[i] == b->steps.now) return;
  double finest = INFINITY;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index j = rows->node[e];
    if (kith_node_active(it->nodes, j)) finest = KITH_MIN(finest, b->steps.next->f64[j]);
  }
  if (step > b->settings.ratio * finest) wake_in(b, i, finest);
}

/* --- a tick --- */

/* Of the support of node i, in a time `since` its last activity. */
static double growth_of(const struct kith_integrator *it, kith_index i, double since) {
  const double divergence = it->package->velocity_divergence->f64[i];
  return divergence != 0 ? exp(fmax(-0.2, fmin(0.2, since * divergence / NDIM))) : 1;
}

/* From each node's last activity to the present tick; positions from the last kick. Of the nodes of it->near
 * the active ones, the idle ones, or both. */
static void predict(struct kith_integrator *it, bool active, bool idle) {
  struct blocks *b = blocks_of(it);
  const struct kith_block_steps *s = &b->steps;
  double *restrict x = it->nodes->position->f64, *restrict v = it->hydro->velocity->f64;
  const double *restrict w = s->velocity->f64, *restrict last = s->velocity_last->f64,
                         *restrict base = b->position_base->f64,
                         *restrict acceleration = it->hydro->acceleration->f64;
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index n = 0; n < kith_near_count(it); ++n) {
    const kith_index i = kith_near_node(it, n);
    if (!(it->nodes->activity->u8[i] == KITH_ACTIVE ? active : idle)) continue;
    const double since = s->tick * (s->now - s->last->f64[i]), dt = s->tick * (s->now - b->moved->f64[i]);
    for (size_t k = (size_t)i * NDIM; k < (size_t)(i + 1) * NDIM; ++k) {
      x[k] = base[k] + dt * w[k];
      v[k] = last[k] + since * acceleration[k];
    }
    it->hydro->energy->f64[i] = s->energy_last->f64[i] + since * (it->hydro->energy_rate->f64[i] +
                                                                  0.5 * since * s->rate_slope->f64[i]);
    const double growth = growth_of(it, i, since);
    it->nodes->support->f64[i] = b->support_base->f64[i] * growth;
    it->hydro->density->f64[i] = b->density_base->f64[i] / kith_pow_dim(growth);
  }
  it->nodes->positions += 1;
}

/* The box around node i, this far to each side. */
static void include_support(struct kith_box *box, const struct kith_integrator *it, kith_index i,
                            double radius) {
  for (int a = 0; a < NDIM; ++a) {
    const double x = it->nodes->position->f64[(size_t)i * NDIM + a];
    box->lower[a] = KITH_MIN(box->lower[a], x - radius), box->upper[a] = KITH_MAX(box->upper[a], x + radius);
  }
}

/* The nodes whose step ends now are active: it->near. */
static kith_status activate(struct kith_integrator *it) {
  const struct blocks *b = blocks_of(it);
  const kith_index n = it->nodes->n_internal;
  KITH_TRY(kith_grow(&it->near.node, &it->near.capacity, 0, (size_t)n + 1, sizeof *it->near.node));
  it->near.n = 0;
  for (kith_index i = 0; i < n; ++i) {
    const bool active = b->due->f64[i] <= b->steps.now;
    it->nodes->activity->u8[i] = active ? KITH_ACTIVE : KITH_IDLE;
    it->near.node[it->near.n] = i;
    it->near.n += active;
  }
  it->clock = it->time + b->steps.now * b->steps.tick;
  return KITH_OK;
}

/* Are active nodes few, and has the search cost less than a new one would? Then it may pay to look up what is
 * near them. */
static bool are_few(const struct kith_integrator *it) {
  const kith_index all = it->nodes->n_internal;
  return !blocks_of(it)->steps.ends && it->near.n <= all / FEW &&
         blocks_of(it)->wasted <= NEW_SEARCH * (double)all;
}

/* May active nodes, or what is near them, have to do with a ghost? */
static bool reach_boundaries(const struct kith_integrator *it) {
  const struct blocks *b = blocks_of(it);
  struct kith_box inside = kith_box_empty(), reach = inside, supports = b->supports;
  for (kith_index k = 0; k < it->near.n; ++k) {
    const kith_index i = it->near.node[k];
    include_support(&inside, it, i, b->slack);
    include_support(&reach, it, i, b->slack + it->nodes->search_radius->f64[i]);
  }
  for (int a = 0; a < NDIM; ++a) supports.lower[a] -= b->slack, supports.upper[a] += b->slack;
  return kith_boundaries_reach(it->boundaries, &inside, &reach, &supports);
}

/* it->near: active nodes, and those that they may interact with. Again when a support has grown. */
static kith_status find_near(struct kith_integrator *it) {
  kith_lifecycle_search_radii(it);
  KITH_TRY(
      kith_search_near(it->search, blocks_of(it)->slack, &it->near.node, &it->near.capacity, &it->near.n));
  for (kith_index k = 0; k < it->near.n; ++k)
    if (it->nodes->activity->u8[it->near.node[k]] == KITH_TOUCHED)
      it->nodes->activity->u8[it->near.node[k]] = KITH_IDLE;
  predict(it, false, true);
  return KITH_OK;
}

/* Predicts active nodes, and all others too or leaves it to the lifecycle to find those that matter. */
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

/* Counts the updates by the length of the step that they end. */
static void count_levels(const struct kith_integrator *it) {
#define OF(n) "updates, base step / " #n
  static const char *const name[] = {OF(1),      OF(2),      OF(4),      OF(8),     OF(16),    OF(32),
                                     OF(64),     OF(128),    OF(256),    OF(512),   OF(1024),  OF(2048),
                                     OF(4096),   OF(8192),   OF(16384),  OF(32768), OF(65536), OF(131072),
                                     OF(262144), OF(524288), OF(1048576)};
#undef OF
  enum { LEVELS = sizeof name / sizeof *name };
  const double *restrict step = blocks_of(it)->steps.step->f64;
  uint64_t count[LEVELS] = {0};
  if (it->profile == NULL) return;
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    if (kith_node_active(it->nodes, i)) count[KITH_MIN(ilogb(KITH_TICKS / step[i]), LEVELS - 1)] += 1;
  }
  for (int level = 0; level < LEVELS; ++level)
    if (count[level] > 0) kith_profile_count(it->profile, name[level], (double)count[level]);
}

/* After the evaluation: active nodes begin their next step. `first`: boundaries may have moved nodes. */
static void close_tick(struct kith_integrator *it, bool first) {
  struct blocks *b = blocks_of(it);
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
    if (activity != KITH_IDLE || first) {
      memcpy(b->position_base->f64 + (size_t)i * NDIM, it->nodes->position->f64 + (size_t)i * NDIM,
             NDIM * sizeof(double));
      b->moved->f64[i] = s->now;
    }
    if (s->ends) continue; /* all nodes are taken in anew */
    if (activity != KITH_IDLE) wake(it, i);
    const double radius = it->nodes->search_radius->f64[i], left = s->tick * (b->due->f64[i] - s->now);
    slack = KITH_MAX(slack, left * kith_norm(s->velocity->f64 + (size_t)i * NDIM) +
                                radius * fmax(0, growth_of(it, i, left) - 1));
    include_support(&supports, it, i, radius);
  }
  b->slack = slack, b->supports = supports;
}

/* The next tick at which a node is active, on any rank. */
static double next_tick(const struct kith_integrator *it) {
  const struct blocks *b = blocks_of(it);
  double next = KITH_TICKS;
#pragma omp parallel for simd schedule(static) reduction(min : next)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) next = KITH_MIN(next, b->due->f64[i]);
  next = -next;
  kith_ranks_max(it->nodes->ranks, &next, 1);
  return -next;
}

/* Lists, steps and rates of the active nodes, at tick `now`. The first lists of a base step put nodes back in
 * their places and on their ranks. */
static kith_status evaluate(struct kith_integrator *it, bool first) {
  struct blocks *b = blocks_of(it);
  kith_boundaries_move(it->boundaries, it->clock);
  it->kick.blocks = &b->steps;
  it->holding = !first;
  KITH_TRY(kith_lifecycle(it, it->near.only ? KITH_BECAUSE_selected : KITH_BECAUSE_always));
  it->holding = true; /* until the end of the base step */
  limit_by_neighbors(it);
  b->steps.alike = b->steps.ends && alike(it); /* else seldom, and not worth a look */
  return kith_integrator_evaluate(it);
}

/* How many candidates more there were than right after all nodes were taken in. */
static void judge_search(struct kith_integrator *it) {
  struct blocks *b = blocks_of(it);
  const double entries = (double)it->ledger.last_row_entries,
               candidates = (double)it->connectivity->candidates;
  if (it->near.only)
    b->wasted += fmax(0, candidates - b->candidates * entries);
  else
    b->candidates = entries > 0 ? candidates / entries : 0, b->wasted = 0;
}

static kith_status run_tick(struct kith_integrator *it, double n) {
  struct blocks *b = blocks_of(it);
  const bool first = b->steps.now == 0;
  kith_profile_begin(it->profile, "predict");
  b->steps.now = n, b->steps.ends = n == KITH_TICKS;
  kith_status status = predict_nodes(it, first);
  status = kith_ranks_allreduce_status(it->nodes->ranks, status);
  if (status == KITH_OK && b->steps.ends)
    plan(it, it->time + KITH_TICKS * b->steps.tick, 1);
  else if (status == KITH_OK)
    want(it);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  KITH_TRY(evaluate(it, first));
  kith_profile_begin(it->profile, "kick");
  count_levels(it);
  close_tick(it, first);
  judge_search(it);
  kith_profile_end(it->profile);
  return KITH_OK;
}

/* --- a base step --- */

kith_status kith_block_steps_start(struct kith_integrator *it) {
  struct blocks *b = blocks_of(it);
  b->steps.now = b->steps.tick = 0, b->steps.ends = true;
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    b->steps.last->f64[i] = 0, b->steps.step->f64[i] = 1;
    it->nodes->activity->u8[i] = KITH_ACTIVE;
  }
  kith_field_copy(it->nodes, b->steps.velocity, it->hydro->velocity);
  kith_field_copy(it->nodes, b->steps.energy, it->hydro->energy);
  plan(it, it->time, start);
  const kith_status status = evaluate(it, false);
  it->holding = it->near.only = false, it->kick.blocks = NULL;
  return status;
}

void kith_block_steps_begin(struct kith_integrator *it, double dt) {
  struct blocks *b = blocks_of(it);
  struct kith_block_steps *s = &b->steps;
  s->now = 0, s->tick = dt / KITH_TICKS, s->ends = false;
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
    b->due->f64[i] = s->step->f64[i], b->moved->f64[i] = 0;
    const double own = power_of_two(tolerated * limit_of(it, i) / s->tick);
    if (own < s->step->f64[i] && it->step > 0 && isfinite(b->settings.ratio)) wake_in(b, i, own);
    it->nodes->activity->u8[i] = KITH_IDLE;
  }
  kith_field_copy(it->nodes, s->velocity, it->hydro->velocity);
  kith_field_copy(it->nodes, s->energy, it->hydro->energy);
  kith_field_copy(it->nodes, b->position_base, it->nodes->position);
}

kith_status kith_block_steps_advance(struct kith_integrator *it) {
  struct blocks *b = blocks_of(it);
  kith_status status = KITH_OK;
  while (status == KITH_OK && b->steps.now < KITH_TICKS) {
    const double n = next_tick(it);
    if (n >= b->steps.now + 1)
      status = run_tick(it, n);
    else
      status =
          kith_fail(KITH_DIVERGED, "a time step collapsed below %g at time %g", b->steps.tick, it->clock);
  }
  it->holding = it->near.only = false, it->kick.blocks = NULL;
  if (status != KITH_OK) return status;
  kith_field_copy(it->nodes, it->hydro->velocity, b->steps.velocity);
  kith_field_copy(it->nodes, it->hydro->energy, b->steps.energy);
  return KITH_OK;
}
