/* What a node gets from its pairs: its rates, and with block steps its impulses. */
#include "physics/passes/rates.h"

#include <string.h>

struct kith_rates kith_rates_of(struct kith_package *package, const struct kith_kick *kick) {
  struct kith_rates rates = {package, kick, .adds = package->limit != KITH_LIMIT_nothing, .is_last = true};
  for (const struct kith_package *p = package->next; p != NULL; p = p->next)
    rates.is_last = rates.is_last && p->ops->evaluate == NULL;
  return rates;
}

/* Completes node i after the last package by (2) of block_steps.h, with its names: w is the velocity that the
 * node drifts with, p the one that pairs saw, k the closing impulse, v the velocity at the last activity. A
 * touched node gets impulses and keeps its rates. Until now hydro->acceleration of active nodes is the
 * external force at their last activity. */
static void end_blocks(const struct kith_rates *rates, kith_index i) {
  const struct kith_block_steps *b = rates->kick->blocks;
  const struct kith_package *package = rates->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const bool active = kith_node_active(hydro->nodes, i),
             external = package->pair_acceleration != hydro->acceleration;
  /* Durations: of a base step; since the last activity; since the middle of the step; to that of the next. */
  const double base = b->tick * KITH_TICKS, since = b->tick * (b->now - b->last->f64[i]),
               middle = since - 0.5 * b->tick * b->step->f64[i],
               later = b->ends ? 0 : 0.5 * b->tick * b->next->f64[i], *restrict p = hydro->velocity->f64 + at,
               *restrict k = b->impulse->f64 + at, *restrict opening = b->opening->f64 + at;
  double *restrict w = b->velocity->f64 + at, *all = hydro->acceleration->f64 + at,
                   *pairs = package->pair_acceleration->f64 + at, *restrict v = b->velocity_last->f64 + at;
  double g[NDIM] = {0}, closing_work = 0, opening_work = 0, slope = 0, fall = 0;
  if (external && active)
    kith_external_force_add(&hydro->external_force, hydro->nodes->position->f64 + at, g);
  for (int a = 0; a < NDIM; ++a) {
    /* The external force at the last activity; by how much the velocity is ahead of the prediction. */
    const double last = external ? active ? all[a] : all[a] - pairs[a] : 0;
    const double o = base * opening[a], ahead = w[a] + middle * last - p[a];
    fall += active ? last * (0.5 * (v[a] + p[a]) - w[a] - (middle - 0.5 * since) * last) : last * (k[a] + o);
    /* The closing part gives the state at n. */
    closing_work += k[a] * (ahead + 0.5 * k[a]);
    if (active) v[a] = w[a] + k[a] + middle * g[a];
    /* The opening part begins the next drift; that of the next base step waits until its length is known. */
    opening_work += opening[a] * (ahead + k[a]);
    slope += o * opening[a];
    w[a] += k[a] + (b->ends ? 0 : o) + (active ? (middle + later) * g[a] : 0);
    if (external && active) all[a] = pairs[a] + g[a];
  }
  /* The energy at n: closing heat less closing work, and what the fall of the prediction lacks. */
  double *const u = &b->energy->f64[i], *const begun = &b->opening_heat->f64[i];
  *u += b->heat->f64[i] - (package->compatible ? closing_work : 0);
  if (b->fall != NULL && package->compatible) {
    *u += active ? since * fall + b->fall->f64[i] : 0;
    b->fall->f64[i] = active ? 0 : b->fall->f64[i] + since * fall;
  }
  if (active) b->energy_last->f64[i] = *u;
  /* That of the next drift: opening heat less opening work, whose part by k^2 / 2 grows with the step. */
  *begun -= package->compatible ? opening_work : 0;
  if (!b->ends) *u += base * (*begun - (package->compatible ? 0.5 * slope : 0));
  if (!active) return;
  const double rate = hydro->energy_rate->f64[i];
  b->rate_slope->f64[i] = since > 0 ? (rate - b->rate_last->f64[i]) / since : 0;
  b->rate_last->f64[i] = rate;
}

/* Weights the sums of forces and heats, where all pairs have the same weight. */
static void weigh_sums(const struct kith_block_steps *b, kith_index i, struct kith_pair_sums *sums) {
  const double closing = b->now - b->last->f64[i] - 0.5 * b->step->f64[i], opening = 0.5 * b->next->f64[i];
  for (int a = 0; a <= NDIM; ++a) {
    const double value = a < NDIM ? sums->force[a] : sums->heat;
    sums->impulse[a] = b->tick * closing * value;
    sums->opening[a] = opening / KITH_TICKS * value;
    sums->outside_opening[a] = opening * sums->outside[a];
    sums->outside[a] *= closing;
  }
}

static void store_blocks(const struct kith_rates *rates, kith_index i, struct kith_pair_sums *sums) {
  const struct kith_block_steps *b = rates->kick->blocks;
  if (b->alike) weigh_sums(b, i, sums);
  struct kith_package *package = rates->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const double mass = hydro->mass->f64[i];
  const bool adds = rates->adds, active = kith_node_active(hydro->nodes, i);
  double *all = hydro->acceleration->f64 + at, *pairs = package->pair_acceleration->f64 + at;
  double *impulse = b->impulse->f64 + at, *opening = b->opening->f64 + at;
  for (int a = 0; a < NDIM; ++a) {
    if (active && !adds && all != pairs) all[a] -= pairs[a];
    if (active) pairs[a] = (adds ? pairs[a] : 0) + sums->force[a] / mass;
    impulse[a] = (adds ? impulse[a] : 0) + sums->impulse[a] / mass;
    opening[a] = (adds ? opening[a] : 0) + sums->opening[a] / mass;
  }
  double *const heat = &b->heat->f64[i], *const later = &b->opening_heat->f64[i],
                *const rate = &hydro->energy_rate->f64[i], *const signal = &package->signal->f64[i];
  *heat = (adds ? *heat : 0) + sums->impulse[NDIM] / mass;
  *later = (adds ? *later : 0) + sums->opening[NDIM] / mass;
  if (active) *rate = (adds ? *rate : 0) + sums->heat / mass;
  for (int a = 0; hydro->outside_force != NULL && a <= NDIM; ++a) {
    double *closed = a < NDIM ? hydro->outside_force->f64 + at + a : hydro->outside_power->f64 + i,
           *opened = a < NDIM ? b->outside->f64 + at + a : b->outside_power->f64 + i;
    *closed = (adds ? *closed : 0) + b->tick * sums->outside[a];
    *opened = (adds ? *opened : 0) + sums->outside_opening[a] / KITH_TICKS;
  }
  if (!adds) *signal = active ? sums->signal : KITH_MAX(*signal, sums->signal);
  if (rates->is_last) end_blocks(rates, i);
}

/* Stores what (1) of package.h needs: the first package sets the sums, the others add to them, the last
 * completes them. In between the acceleration is the external force of the last evaluation, if there is
 * one. */
static void store(const struct kith_rates *rates, kith_index i, const struct kith_pair_sums *sums) {
  struct kith_package *package = rates->package;
  const struct kith_hydro *hydro = package->hydro;
  const size_t at = (size_t)i * NDIM;
  const double mass = hydro->mass->f64[i], *restrict velocity = hydro->velocity->f64 + at,
               *restrict base = rates->kick->velocity_base->f64 + at;
  double *all = hydro->acceleration->f64 + at, *pairs = package->pair_acceleration->f64 + at, correction = 0;
  const bool adds = rates->adds, external = pairs != all;
  for (int a = 0; a < NDIM; ++a) {
    if (!adds && external) all[a] -= pairs[a];
    pairs[a] = adds ? pairs[a] + sums->force[a] / mass : sums->force[a] / mass;
  }
  const double rate = sums->heat / mass;
  hydro->energy_rate->f64[i] = adds ? hydro->energy_rate->f64[i] + rate : rate;
  if (!adds) package->signal->f64[i] = sums->signal;
  if (hydro->outside_force != NULL) {
    double *force = hydro->outside_force->f64 + at, *power = &hydro->outside_power->f64[i];
    for (int a = 0; a < NDIM; ++a) force[a] = (adds ? force[a] : 0) + sums->outside[a];
    *power = (adds ? *power : 0) + sums->outside[NDIM];
  }
  if (!rates->is_last) return;
  for (int a = 0; a < NDIM; ++a)
    correction -= pairs[a] * (base[a] + rates->kick->lead * (external ? all[a] : 0) - velocity[a]);
  if (external) {
    memcpy(all, pairs, NDIM * sizeof *all);
    kith_external_force_add(&hydro->external_force, hydro->nodes->position->f64 + at, all);
  }
  if (package->compatible) package->energy_correction->f64[i] = correction;
}

void kith_rates_store(const struct kith_rates *rates, kith_index i, struct kith_pair_sums *sums) {
  if (rates->kick->blocks != NULL)
    store_blocks(rates, i, sums);
  else
    store(rates, i, sums);
}
