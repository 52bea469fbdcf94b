/* Inflow and outflow: how their zones move, what enters and leaves, what the gas gets from outside. */
#include "integrator/flow.h"

#include <math.h>
#include <string.h>
#include "lib/connectivity/traversal.h"

/* Indices of the sums. */
enum { MASS, ENERGY, MOMENTUM, SUMS = MOMENTUM + NDIM };

/* Returns how far node i is outside of the face. */
static double depth_of(const struct kith_integrator *it, const struct kith_boundary *b, kith_index i) {
  const double x = it->nodes->position->f64[(size_t)i * NDIM + (size_t)b->axis];
  return b->at_upper ? x - b->upper : b->lower - x;
}

/* Adds `sign` times mass, energy and momentum of node i to the sums. */
static void add_to_sums(const struct kith_integrator *it, kith_index i, double sign, struct kith_sum *sums) {
  const double m = sign * it->hydro->mass->f64[i], *v = it->hydro->velocity->f64 + (size_t)i * NDIM;
  kith_sum_add(&sums[MASS], m);
  kith_sum_add(&sums[ENERGY], 0.5 * m * kith_dot(v, v));
  kith_sum_add(&sums[ENERGY], m * it->hydro->energy->f64[i]);
  for (int a = 0; a < NDIM; ++a) kith_sum_add(&sums[MOMENTUM + a], m * v[a]);
}

/* ---- inflow ---- */

/* Gives node i the state at the face at `time`, if that changes. volume: of nodes of the zone. */
static kith_status impose_state(struct kith_integrator *it, const struct kith_boundary *b,
                                const struct kith_field *volume, kith_index i, double time) {
  const struct kith_nodes *nodes = it->nodes;
  struct kith_flow_state state;
  if (it->flow.state == NULL || ((const struct kith_flow_settings *)b->settings)->density == NULL)
    return KITH_OK;
  KITH_TRY(it->flow.state(it->flow.context, b, nodes->list->u8[i], nodes->position->f64 + (size_t)i * NDIM,
                          time, &state));
  it->hydro->mass->f64[i] = state.density * volume->f64[i];
  it->hydro->energy->f64[i] = state.energy;
  memcpy(it->hydro->velocity->f64 + (size_t)i * NDIM, state.velocity, sizeof state.velocity);
  return KITH_OK;
}

/* Returns when node i, which has passed the face in the last step, did so: it may be nearly a step ago. */
static double time_at_face(const struct kith_integrator *it, const struct kith_boundary *b, kith_index i) {
  const double inwards =
      -kith_flow_outwards(b) * it->hydro->velocity->f64[(size_t)i * NDIM + (size_t)b->axis];
  return inwards > 0 ? fmax(it->time + depth_of(it, b, i) / inwards, it->time - it->dt) : it->time;
}

/* Makes node `to` the successor of node `from`: a copy, as far behind as the zone is deep. */
static kith_status make_successor(struct kith_integrator *it, const struct kith_boundary *b, kith_index to,
                                  kith_index from) {
  const struct kith_nodes *nodes = it->nodes;
  for (int f = 0; f < nodes->n_fields; ++f) {
    char *data = nodes->fields[f]->data;
    const size_t size = kith_field_node_size(nodes->fields[f]);
    memcpy(data + (size_t)to * size, data + (size_t)from * size, size);
  }
  for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)to * NDIM + (size_t)a] += b->zone[a];
  nodes->id->i64[to] += it->flow.id_stride;
  if (depth_of(it, b, to) > 0) return KITH_OK;
  const int64_t id = nodes->id->i64[from];
  KITH_FAIL_NODE(DIVERGED, id,
                 "node %lld passes the zone of an %s, %g deep, within a step: a shorter step is required",
                 (long long)id, b->ops->name, kith_flow_deepest(b));
}

static kith_status enter(struct kith_integrator *it, const struct kith_boundary *b, struct kith_sum *sums,
                         uint64_t *changes) {
  struct kith_nodes *nodes = it->nodes;
  const struct kith_field *volume = kith_nodes_field_named(nodes, KITH_ZONE_VOLUME);
  const uint8_t flag = kith_flow_flag(b);
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (nodes->flag->u8[i] == flag) KITH_TRY(impose_state(it, b, volume, i, it->time));
  for (int l = 0; l < nodes->n_lists; ++l) {
    const struct kith_node_list *list = &nodes->lists[l];
    const kith_index end = list->first + list->count;
    kith_index entering = 0, next;
    for (kith_index i = list->first; i < end; ++i) {
      const double depth = depth_of(it, b, i);
      entering += nodes->flag->u8[i] == flag && depth <= 0;
      if (nodes->flag->u8[i] == KITH_GAS && depth > 0.5 * nodes->support->f64[i])
        KITH_FAIL_NODE(DIVERGED, nodes->id->i64[i], "node %lld leaves through the %s on axis %d",
                       (long long)nodes->id->i64[i], b->ops->name, b->axis);
    }
    if (entering == 0) continue;
    *changes += 1;
    KITH_TRY(kith_nodes_append(nodes, l, entering, &next));
    for (kith_index i = list->first; i < end; ++i) {
      if (nodes->flag->u8[i] != flag || depth_of(it, b, i) > 0) continue;
      KITH_TRY(make_successor(it, b, next++, i));
      KITH_TRY(impose_state(it, b, volume, i, time_at_face(it, b, i)));
      nodes->flag->u8[i] = KITH_GAS;
      add_to_sums(it, i, 1, sums);
    }
  }
  return KITH_OK;
}

/* ---- outflow ---- */

/* Flags gas that leaves through the face, or comes back, and deletes nodes behind the zone. */
static kith_status leave(struct kith_integrator *it, const struct kith_boundary *b, struct kith_sum *sums,
                         uint64_t *changes) {
  struct kith_nodes *nodes = it->nodes;
  uint8_t *dead = NULL;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    uint8_t *flag = &nodes->flag->u8[i], zone = kith_flow_flag(b);
    const double depth = depth_of(it, b, i);
    if (*flag == (depth > 0 ? KITH_GAS : zone)) {
      add_to_sums(it, i, depth > 0 ? -1 : 1, sums);
      *flag = depth > 0 ? zone : KITH_GAS;
      *changes += 1;
    }
    if (*flag != zone || depth <= kith_flow_deepest(b)) continue;
    if (dead == NULL) KITH_TRY(kith_resize(&dead, 0, (size_t)nodes->n_internal, 1));
    dead[i] = 1;
  }
  if (dead == NULL) return KITH_OK;
  *changes += 1;
  const kith_status status = kith_nodes_delete(nodes, dead);
  kith_free(&dead);
  return status;
}

/* Does i or its partner j, x_j - x_i away, reach the other? Rows hold more, by the skin of lists and by what
 * supports may grow, and gas must not depend on that. */
static bool is_significant(const struct kith_nodes *nodes, kith_index i, kith_index j, const double *x) {
  double d[NDIM];
  for (int a = 0; a < NDIM; ++a) d[a] = x[a] / nodes->stretch[a];
  return kith_norm(d) <= fmax(nodes->support->f64[i], nodes->support->f64[j]);
}

/* Sets the rates dv/dt, outwards, and du/dt at which waves change node i of the zone of b (flow.h). Partners
 * count as 1 / |x_ij|^2: one that is far cannot outweigh one that i is about to run into. If they are all
 * beside i, nearly as deep, as at the tip of a jet, the difference of depths is no measure: divided by it,
 * noise would grow faster than steps can follow. */
static void waves(const struct kith_integrator *it, const struct kith_boundary *b, kith_index i,
                  double *acceleration, double *heating) {
  const struct kith_rows *rows = &it->connectivity->rows;
  const struct kith_hydro *hydro = it->hydro;
  const double *v = hydro->velocity->f64 + b->axis, *pressure = hydro->pressure->f64,
               c = hydro->sound_speed->f64[i], density = hydro->density->f64[i],
               gamma = kith_material_gamma(&hydro->material[it->nodes->list->u8[i]], density,
                                           hydro->energy->f64[i]);
  double moment = 0, count = 0, dv = 0, du = 0;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index j = rows->node[e];
    double x[NDIM];
    const double square = kith_entry_separation(it->nodes, rows, i, e, x);
    const double inwards = -kith_flow_outwards(b) * x[b->axis];
    if (!is_significant(it->nodes, i, j, x)) continue;
    count += 1; /* on all sides: of what is beside i round-off decides whether it is further in */
    if (inwards <= 0) continue;
    const double closing = kith_flow_outwards(b) * (v[(size_t)j * NDIM] - v[(size_t)i * NDIM]),
                 w = 0.25 * (gamma + 1) * fmax(0, closing), speed = w + sqrt(w * w + c * c);
    moment += inwards * inwards / square; /* of even partners count / (2 NDIM) */
    dv += inwards / square * speed * closing;
    du += inwards / square * closing * 0.5 * (pressure[i] + pressure[closing > 0 ? j : i]);
  }
  moment = fmax(moment, 0.1 * count);
  *acceleration = moment > 0 ? dv / moment : 0;
  *heating = moment > 0 ? du / (moment * density) : 0;
}

/* Sets the rates of node i in the zone of an outflow (flow.h). by_pairs: the part of the package's
 * acceleration through the face that is left; remains: that of its other rates. */
static void pass_waves(const struct kith_integrator *it, const struct kith_boundary *b, kith_index i) {
  const struct kith_hydro *hydro = it->hydro;
  const double far = ((const struct kith_flow_settings *)b->settings)->pressure_far,
               depth = depth_of(it, b, i) / kith_flow_deepest(b), by_pairs = fmax(0, 1 - 4 * depth),
               remains = fmax(0, fmin(1, 2 - 4 * depth)),
               pull = far > 0 ? 0.25 / (b->upper - b->lower) * (hydro->pressure->f64[i] - far) /
                                    hydro->density->f64[i]
                              : 0;
  double *a = hydro->acceleration->f64 + (size_t)i * NDIM, *rate = &hydro->energy_rate->f64[i];
  double acceleration, heating;
  waves(it, b, i, &acceleration, &heating);
  const double through = by_pairs * a[b->axis] + kith_flow_outwards(b) * (1 - by_pairs) * acceleration;
  for (int k = 0; k < NDIM; ++k) a[k] *= remains;
  a[b->axis] = through + kith_flow_outwards(b) * remains * pull;
  *rate = remains * *rate + (1 - remains) * heating;
}

/* ---- all faces ---- */

kith_status kith_flow_exchange(struct kith_integrator *it) {
  struct kith_sum sums[SUMS] = {0};
  uint64_t changes = 0;
  struct kith_shared parts[1 + SUMS] = {{KITH_SHARE_SUM, 1, &changes}};
  bool any = false;
  kith_status status = KITH_OK;
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (!kith_boundary_passes(b->ops)) continue;
    any = true;
    if (status == KITH_OK) status = (b->ops->enters ? enter : leave)(it, b, sums, &changes);
  }
  if (!any) return KITH_OK;
  for (int k = 0; k < SUMS; ++k) parts[1 + k] = kith_sum_shared(&sums[k]);
  KITH_TRY(kith_ranks_agree(it->nodes->ranks, status, 1 + SUMS, parts));
  if (changes == 0) return KITH_OK;
  struct kith_through *through = &it->hydro->through;
  through->mass += kith_sum_value(&sums[MASS]);
  through->energy += kith_sum_value(&sums[ENERGY]);
  for (int a = 0; a < NDIM; ++a) through->momentum[a] += kith_sum_value(&sums[MOMENTUM + a]);
  it->nodes->positions += 1;
  it->due = KITH_BECAUSE_entity_change;
  return KITH_OK;
}

/* Is node i beyond a mirror? */
static bool is_beyond(const struct kith_integrator *it, kith_index i) {
  const double *x = it->nodes->position->f64 + (size_t)i * NDIM;
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (b->ops->enforce != NULL && !b->ops->wraps &&
        ((b->at_lower && x[b->axis] < b->lower) || (b->at_upper && x[b->axis] > b->upper)))
      return true;
  }
  return false;
}

/* Adds `sign` times the potential energy of node i to `lifted`. */
static void add_potential(struct kith_integrator *it, kith_index i, double sign) {
  const struct kith_hydro *hydro = it->hydro;
  const double *x = it->nodes->position->f64 + (size_t)i * NDIM;
  kith_sum_add(&it->flow.lifted,
               sign * hydro->mass->f64[i] * kith_external_force_potential(&hydro->external_force, x));
}

kith_status kith_flow_mirror(struct kith_integrator *it) {
  const struct kith_hydro *hydro = it->hydro;
  kith_index *node = NULL, n = 0;
  size_t capacity = 0;
  kith_status status = KITH_OK;
  if (!kith_external_force_acts(&hydro->external_force))
    return kith_boundaries_mirror(it->boundaries, it->nodes);
  for (kith_index i = 0; status == KITH_OK && i < it->nodes->n_internal; ++i) {
    if (!is_beyond(it, i)) continue;
    status = kith_grow(&node, &capacity, (size_t)n, (size_t)n + 1, sizeof *node);
    if (status == KITH_OK) add_potential(it, node[n++] = i, -1);
  }
  if (status == KITH_OK) status = kith_boundaries_mirror(it->boundaries, it->nodes);
  for (kith_index k = 0; status == KITH_OK && k < n; ++k) {
    const size_t at = (size_t)node[k] * NDIM;
    double *a = hydro->acceleration->f64 + at;
    add_potential(it, node[k], 1);
    memcpy(a, it->package->pair_acceleration->f64 + at, NDIM * sizeof *a);
    kith_external_force_add(&hydro->external_force, it->nodes->position->f64 + at, a);
  }
  kith_free(&node);
  return status;
}

static void sum_outside(struct kith_integrator *it) {
  const struct kith_hydro *hydro = it->hydro;
  struct kith_sum sums[SUMS] = {0};
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    const double *force = hydro->outside_force->f64 + (size_t)i * NDIM, power = hydro->outside_power->f64[i];
    if (!kith_node_is_gas(it->nodes, i) || (power == 0 && kith_dot(force, force) == 0)) continue;
    kith_sum_add(&sums[ENERGY], power);
    for (int a = 0; a < NDIM; ++a) kith_sum_add(&sums[MOMENTUM + a], force[a]);
  }
  kith_sum_ranks(it->nodes->ranks, sums, SUMS);
  it->flow.rate.energy = kith_sum_value(&sums[ENERGY]);
  for (int a = 0; a < NDIM; ++a) it->flow.rate.momentum[a] = kith_sum_value(&sums[MOMENTUM + a]);
}

/* Sets the rates of node i in the zone of b. */
static void set_rates(struct kith_integrator *it, const struct kith_boundary *b, kith_index i) {
  double *a = it->hydro->acceleration->f64 + (size_t)i * NDIM;
  if (b->ops->leaves) {
    pass_waves(it, b, i);
  } else {
    memset(a, 0, NDIM * sizeof *a);
    it->hydro->energy_rate->f64[i] = 0;
  }
}

void kith_flow_rates(struct kith_integrator *it) {
  if (it->hydro->outside_force == NULL || it->kick.blocks != NULL) return;
  sum_outside(it);
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (!kith_boundary_passes(b->ops)) continue;
    for (kith_index i = 0; i < it->nodes->n_internal; ++i)
      if (it->nodes->flag->u8[i] == kith_flow_flag(b)) set_rates(it, b, i);
  }
}

void kith_flow_tick(struct kith_integrator *it, const struct kith_block_steps *s) {
  struct kith_hydro *hydro = it->hydro;
  struct kith_sum *got = it->flow.got, later[1 + NDIM] = {0}, *opens = s->ends ? later : got;
  const double time = s->ends ? 1 : s->tick * KITH_TICKS;
  if (hydro->outside_force == NULL) return;
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    if (it->nodes->activity->u8[i] == KITH_IDLE || !kith_node_is_gas(it->nodes, i)) continue;
    kith_sum_add(&got[0], hydro->outside_power->f64[i]);
    kith_sum_add(&opens[0], time * s->outside_power->f64[i]);
    for (size_t a = 0; a < NDIM; ++a) {
      kith_sum_add(&got[1 + a], hydro->outside_force->f64[(size_t)i * NDIM + a]);
      kith_sum_add(&opens[1 + a], time * s->outside->f64[(size_t)i * NDIM + a]);
    }
  }
  if (!s->ends) return;
  kith_sum_ranks(it->nodes->ranks, got, 1 + NDIM);
  kith_sum_ranks(it->nodes->ranks, later, 1 + NDIM);
  hydro->through.energy += kith_sum_value(&got[0]), it->flow.rate.energy = kith_sum_value(&later[0]);
  for (int a = 0; a < NDIM; ++a) {
    hydro->through.momentum[a] += kith_sum_value(&got[1 + a]);
    it->flow.rate.momentum[a] = kith_sum_value(&later[1 + a]);
  }
  memset(got, 0, sizeof it->flow.got);
}
