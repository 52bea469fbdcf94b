/* Block time steps: how long they are. */
#include "integrator/block_lengths.h"

#include <math.h>
#include "lib/connectivity/traversal.h"
#include "lib/core/random.h"

enum {
  GROWTH = 2,   /* a step is at most this many times the last one of its node */
  HEAVY = 4,    /* neighbors of more than this many times a node's mass may throw it */
  HEAVIER = 10, /* beside neighbors of more than this many times its mass it may swing */
  SELDOM = 4    /* the step of a swinging node may grow only every so many base steps */
};
/* A step limit is multiplied by this, then rounded down to a power of two of the base step, so steps are 0.6
 * to 1.2 of the limit. That saves an eighth of the updates of Sedov's blast in 3-D. Errors of density and
 * velocity stay within 2 % of those with a global step, in 2-D too; in 1-D Sod's density would lose 12 %. */
static const double limit_factor = NDIM == 1 ? 1 : 1.2;
static const double wake_factor = 1.2; /* a step is cut short only if it exceeds its limit by this factor */

/* A node whose limit falls short of a power of two by round-off alone takes that step: the limits of nodes of
 * gas at rest differ by round-off, and so do successive base steps, which are equal parts of one time. */
static const double round_off = 1e-9;

/* Returns the largest power of two up to this many ticks, at most KITH_TICKS. */
static double power_of_two(double ticks) {
  int exponent;
  if (!(ticks < KITH_TICKS)) return KITH_TICKS;
  frexp((1 + 2 * round_off) * ticks, &exponent);
  return ldexp(1, exponent - 1);
}

/* Returns the largest power of two that divides tick n: steps up to that length may begin there. */
static double aligned(double n) {
  const int64_t whole = (int64_t)n;
  return whole == 0 ? KITH_TICKS : (double)(whole & -whole);
}

/* Returns the Courant number of the longest step, before rounding: at most the stable one of the package,
 * unless the scene sets a larger one. */
static double longest_cfl(const struct kith_integrator *it) {
  const double stable = it->package->ops->stable_cfl, longest = limit_factor * it->cfl;
  return stable > 0 ? KITH_MIN(longest, KITH_MAX(stable, it->cfl)) : longest;
}

/* Returns a random number in [0, 1) that depends only on node, time, `salt` and the seed. */
static double random_of(const struct kith_integrator *it, kith_index i, double salt) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const uint64_t x = b->settings.seed + (uint64_t)it->nodes->id->i64[i] * UINT64_C(0x9e3779b97f4a7c15) +
                     (uint64_t)(4 * b->steps.now + salt) * UINT64_C(0xd1342543de82ef95) +
                     it->step * UINT64_C(0x2545f4914f6cdd1d);
  return (double)(kith_mixed_bits(x) >> 11) / 9007199254740992.0;
}

/* Returns the longest step that node i may take, before rounding. With a fixed step there is no limit; random
 * steps are shorter by a factor of up to 2^5. */
static double limit_of(const struct kith_integrator *it, kith_index i) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const double limit =
      it->fixed_dt > 0 ? INFINITY : kith_package_limit_of_node(it->package, i, longest_cfl(it)).dt;
  if (b->settings.seed == 0) return limit;
  return KITH_MIN(limit, it->fixed_dt > 0 ? it->fixed_dt : INFINITY) * exp2(-5 * random_of(it, i, 1));
}

/* Returns the largest mass of the nodes that boundaries of this rank have taken out of the run: these push
 * others without being stepped. */
static double heaviest_held(const struct kith_integrator *it) {
  double heaviest = 0;
  const struct kith_nodes *held = kith_boundaries_held(it->boundaries);
  const struct kith_field *mass =
      held != NULL ? kith_nodes_field_named(held, it->hydro->mass->spec.name) : NULL;
  for (kith_index i = 0; mass != NULL && i < held->n_internal; ++i)
    heaviest = KITH_MAX(heaviest, mass->f64[i]);
  return heaviest;
}

/* Sets `wanted` of each node to its longest step, in units of time; returns the least and the largest of all
 * ranks, and notes whether masses are even. */
static void range_of_limits(const struct kith_integrator *it, double factor, double *least, double *most) {
  struct kith_blocks *b = kith_blocks_of(it);
  double low = INFINITY, high = 0, light = INFINITY, heavy = heaviest_held(it);
#pragma omp parallel for schedule(static) reduction(min : low, light) reduction(max : high, heavy)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    const double growth = b->steps.tick > 0 ? GROWTH * b->steps.tick * b->steps.step->f64[i] : INFINITY;
    const double dt = KITH_MIN(factor * limit_of(it, i), growth);
    b->wanted->f64[i] = dt;
    low = KITH_MIN(low, dt), high = KITH_MAX(high, dt);
    light = KITH_MIN(light, it->hydro->mass->f64[i]), heavy = KITH_MAX(heavy, it->hydro->mass->f64[i]);
  }
  double range[] = {-low, high, -light, heavy};
  kith_ranks_max(it->nodes->ranks, range, 4);
  *least = -range[0], *most = isfinite(*least) ? range[1] : INFINITY; /* no nodes, no limits */
  b->even = range[3] <= HEAVY * -range[2];
}

/* Returns the length of a base step that costs least per time. It is a part of what is left until the next
 * output, no longer than `longest` and at least half as long: since steps are rounded down to powers of two
 * of it, a shorter one may suit more nodes. A tick costs about as much as an update of a tenth of the nodes,
 * however few it updates. */
static double cheapest_base(const struct kith_integrator *it, double longest, double left) {
  enum { LENGTHS = 8 }; /* lengths that are tried, equally spaced in their logarithm */
  const double *restrict wanted = kith_blocks_of(it)->wanted->f64,
                         fewest = left > 0 ? ceil((1 - round_off) * left / longest) : 1;
  uint64_t updates[LENGTHS + 1] = {0};
  double length[LENGTHS], ticks[LENGTHS] = {0}, best = longest, least = INFINITY;
  for (int k = 0; k < LENGTHS; ++k) {
    const double shorter = exp2((double)k / LENGTHS);
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
    if (cost < (1 - round_off) * least) least = cost, best = length[k];
  }
  return best;
}

void kith_blocks_plan(struct kith_integrator *it, double time, double factor) {
  struct kith_blocks *b = kith_blocks_of(it);
  double least, most, left = it->until - time;
  range_of_limits(it, factor, &least, &most);
  if (!(left > 1e-9 * it->every)) left = it->every;
  const double longest = KITH_MIN(most, ldexp(least, b->settings.levels));
  it->planned = it->fixed_dt > 0    ? it->fixed_dt
                : isfinite(longest) ? cheapest_base(it, longest, left)
                : left > 0          ? left
                                    : longest;
  const double tick = it->planned / KITH_TICKS;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    b->wanted->f64[i] = isfinite(tick) ? power_of_two(b->wanted->f64[i] / tick) : KITH_TICKS;
}

void kith_blocks_shorten(struct kith_integrator *it) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const double tick = it->planned / KITH_TICKS;
  double excess = 0; /* the largest of: next step of a node over what its rates now allow */
#pragma omp parallel for schedule(static) reduction(max : excess)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    excess = KITH_MAX(excess, tick * b->steps.next->f64[i] / limit_of(it, i));
  kith_ranks_max(it->nodes->ranks, &excess, 1);
  if (excess > b->settings.ratio) it->planned /= excess;
}

void kith_blocks_want(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  const double most = aligned(b->steps.now);
#pragma omp parallel for schedule(static) if (it->near.n > KITH_FEW)
  for (kith_index k = 0; k < it->near.n; ++k) {
    const kith_index i = it->near.node[k];
    b->wanted->f64[i] = KITH_MIN(power_of_two(limit_of(it, i) / b->steps.tick),
                                 KITH_MIN(most, GROWTH * b->steps.step->f64[i]));
  }
}

/* Returns the shortest step that a node or ghost of this rank wants. Frozen nodes (step 0) want none. */
static double finest_wanted(const struct kith_integrator *it) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const double *restrict wanted = b->wanted->f64, *restrict step = b->steps.step->f64;
  const kith_index n = it->near.only ? it->near.n : kith_nodes_count(it->nodes);
  double finest = KITH_TICKS;
#pragma omp parallel for schedule(static) reduction(min : finest) if (n > KITH_FEW)
  for (kith_index k = 0; k < n; ++k) {
    const kith_index i = kith_near_node(it, k);
    finest = KITH_MIN(finest, step[i] > 0 ? wanted[i] : KITH_TICKS);
  }
  return finest;
}

/* Returns what the neighbor at entry e accelerates node i by after a time dt, if both move on as they do:
 * m_j c_i^2 / rho_i |grad W|. */
static double neighbor_acceleration(const struct kith_integrator *it, kith_index i, size_t e, double dt) {
  const struct kith_hydro *hydro = it->hydro;
  const struct kith_nodes *nodes = it->nodes;
  const struct kith_rows *rows = &it->connectivity->rows;
  const size_t own = (size_t)i * NDIM, other = (size_t)rows->node[e] * NDIM;
  const double divergence = it->package->velocity_divergence->f64[i], c = hydro->sound_speed->f64[i],
               support = nodes->support->f64[i] * exp(dt * divergence / NDIM);
  double x[NDIM], w, g;
  kith_entry_separation(nodes, rows, i, e, x);
  for (size_t a = 0; a < NDIM; ++a)
    x[a] += dt * (hydro->velocity->f64[other + a] - hydro->velocity->f64[own + a]);
  const double r = kith_norm(x);
  kith_kernel_value(it->package->kernel, KITH_MIN(1, r / support), &w, &g);
  return hydro->mass->f64[rows->node[e]] * c * c / hydro->density->f64[i] *
         kith_kernel_constant(it->package->kernel) * fabs(g) * r /
         (kith_pow_dim(support) * support * support);
}

/* Returns the length up to which the step of node i may grow if it swings (raise_signal_speeds in sph.c). A
 * swing is stiff for a part of its period only; with longer steps in between, swings do not die out. */
static double after_swing(const struct kith_integrator *it, kith_index i, double tick) {
  const struct kith_block_steps *s = &kith_blocks_of(it)->steps;
  const bool may_grow = s->tick == 0 || (s->ends && it->step % SELDOM == 0);
  return may_grow ? INFINITY : power_of_two(KITH_MAX(1, s->step->f64[i] * (s->tick / tick)));
}

/* Returns the longest of the steps d, d / 2, ... at whose end heavy neighbors add no more to the acceleration
 * of i than the limit of accelerations allows. Else one that comes within the support of a light node would
 * throw it with more energy than it has. */
static double before_impact(const struct kith_integrator *it, kith_index i, double d) {
  const struct kith_blocks *b = kith_blocks_of(it);
  const struct kith_rows *rows = &it->connectivity->rows;
  const double *restrict mass = it->hydro->mass->f64,
                         tick = b->steps.ends ? it->planned / KITH_TICKS : b->steps.tick,
                         h = it->nodes->support->f64[i] / kith_kernel_support(it->package->kernel),
                         most = 0.64 * it->cfl * it->cfl * h;
  double heaviest = 0;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    if (mass[rows->node[e]] <= HEAVY * mass[i]) continue;
    heaviest = KITH_MAX(heaviest, mass[rows->node[e]]);
    const double now = neighbor_acceleration(it, i, e, 0);
    while (d > 1 && (d * tick) * (d * tick) * (neighbor_acceleration(it, i, e, d * tick) - now) > most)
      d *= 0.5;
  }
  if (b->swings && heaviest > HEAVIER * mass[i]) d = KITH_MIN(d, after_swing(it, i, tick));
  return d;
}

void kith_blocks_limit_by_neighbors(struct kith_integrator *it) {
  struct kith_blocks *b = kith_blocks_of(it);
  const struct kith_rows *rows = &it->connectivity->rows;
  const double *restrict wanted = b->wanted->f64, *restrict step = b->steps.step->f64;
  const double allowed = b->settings.ratio * finest_wanted(it); /* whichever neighbors a node has */
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    double *const next = &b->steps.next->f64[i], finest = INFINITY;
    *next = wanted[i];
    if (!kith_node_active(it->nodes, i)) continue;
    if (!b->even) *next = before_impact(it, i, *next);
    if (*next <= allowed) continue;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      if (step[rows->node[e]] > 0) finest = KITH_MIN(finest, wanted[rows->node[e]]);
    *next = KITH_MIN(*next, b->settings.ratio * finest);
  }
  kith_halo_refresh(it->hydro->halo, it->nodes, &b->steps.next, 1);
}

bool kith_blocks_alike(const struct kith_integrator *it) {
  const struct kith_nodes *nodes = it->nodes;
  const struct kith_block_steps *s = &kith_blocks_of(it)->steps;
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

/* Makes node i active after this many ticks at the latest. */
static void wake_in(struct kith_blocks *b, kith_index i, double ticks) {
  b->due->f64[i] = KITH_MIN(b->due->f64[i], b->steps.now + ticks);
}

void kith_blocks_wake_by_limit(struct kith_integrator *it, kith_index i) {
  struct kith_blocks *b = kith_blocks_of(it);
  const double own = power_of_two(wake_factor * limit_of(it, i) / b->steps.tick);
  if (own < b->steps.step->f64[i] && isfinite(b->settings.ratio)) wake_in(b, i, own);
}

void kith_blocks_wake(struct kith_integrator *it, kith_index i) {
  struct kith_blocks *b = kith_blocks_of(it);
  const struct kith_rows *rows = &it->connectivity->rows;
  const double step = b->steps.step->f64[i];
  kith_blocks_wake_by_limit(it, i);
  if (b->settings.seed != 0 && random_of(it, i, 2) < 0.1) wake_in(b, i, aligned(b->steps.now));
  if (b->steps.last->f64[i] == b->steps.now) return;
  double finest = INFINITY;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index j = rows->node[e];
    if (kith_node_active(it->nodes, j)) finest = KITH_MIN(finest, b->steps.next->f64[j]);
  }
  if (step > b->settings.ratio * finest) wake_in(b, i, finest);
}
