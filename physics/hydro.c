/* The hydro state: external forces, fields, equations of state, checks of the physical range, conserved
 * totals. */
#include "physics/hydro.h"

#include <math.h>

double kith_external_force_potential(const struct kith_external_force *external_force, const double *x) {
  double along = 0, d2 = external_force->softening * external_force->softening;
  for (int a = 0; a < NDIM; ++a) {
    along += external_force->gravity[a] * (x[a] - external_force->origin[a]);
    d2 += (x[a] - external_force->center[a]) * (x[a] - external_force->center[a]);
  }
  return external_force->mass > 0 ? -along - external_force->mass / sqrt(d2) : -along;
}

void kith_external_force_add(const struct kith_external_force *external_force, const double *x,
                             double *acceleration) {
  const double d2 =
      kith_distance2(x, external_force->center) + external_force->softening * external_force->softening;
  const double attraction = external_force->mass > 0 ? external_force->mass / (d2 * sqrt(d2)) : 0;
  for (int a = 0; a < NDIM; ++a)
    acceleration[a] += external_force->gravity[a] - attraction * (x[a] - external_force->center[a]);
}

kith_status kith_hydro_init(struct kith_hydro *hydro, struct kith_nodes *nodes) {
#define ROW(kind, role, name, output, doc) \
  { true, {#name, KITH_##kind, KITH_F64, KITH_##role, output, doc}, &hydro->name }
  const struct kith_field_row table[] = {
      ROW(SCALAR, STATE, mass, "Masses", "mass of the node"),
      ROW(VELOCITY, STATE, velocity, "Velocities", "velocity"),
      ROW(SCALAR, STATE, energy, "InternalEnergy", "internal energy per unit mass"),
      ROW(SCALAR, KEPT, density, "Density", "mass per unit volume"),
      ROW(SCALAR, KEPT, pressure, "Pressure", "pressure"),
      ROW(SCALAR, KEPT, sound_speed, "SoundSpeed", "adiabatic sound speed"),
      ROW(VECTOR, OWN_KEPT, acceleration, "Accelerations", "dv/dt"),
      ROW(SCALAR, OWN_KEPT, energy_rate, NULL, "du/dt"),
      {0}};
#undef ROW
  *hydro = (struct kith_hydro){.nodes = nodes, .masses_of = UINT64_MAX};
  return kith_nodes_fields(nodes, table);
}

/* Evaluates the equation of state of nodes first .. first + count - 1. Skips chunks of idle nodes, whose
 * pressure is not used. */
static void evaluate_eos(const struct kith_hydro *hydro, int list, kith_index first, kith_index count) {
  enum { CHUNK = 256 };
  const struct kith_material *material = &hydro->material[list];
  const struct kith_field *activity = hydro->nodes->activity;
#pragma omp parallel for schedule(static) if (count > CHUNK)
  for (kith_index i = first; i < first + count; i += CHUNK) {
    const kith_index n = KITH_MIN(CHUNK, first + count - i);
    if (activity == NULL || !kith_all_zero(activity->u8, i, i + n))
      kith_material_state(material, n, hydro->density->f64 + i, hydro->energy->f64 + i,
                          hydro->pressure->f64 + i, hydro->sound_speed->f64 + i);
  }
}

void kith_hydro_evaluate_eos(const struct kith_hydro *hydro) {
  for (int l = 0; l < hydro->nodes->n_lists; ++l)
    evaluate_eos(hydro, l, hydro->nodes->lists[l].first, hydro->nodes->lists[l].count);
}

void kith_hydro_evaluate_eos_of(const struct kith_hydro *hydro, kith_index i) {
  kith_material_state(&hydro->material[hydro->nodes->list->u8[i]], 1, hydro->density->f64 + i,
                      hydro->energy->f64 + i, hydro->pressure->f64 + i, hydro->sound_speed->f64 + i);
}

void kith_hydro_evaluate_eos_remote(const struct kith_hydro *hydro) {
  for (int b = 0; b < hydro->nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &hydro->nodes->blocks[b];
    if (block->kind == KITH_GHOST_REMOTE) evaluate_eos(hydro, block->list, block->first, block->count);
  }
}

/* Returns what is not finite in the state of node i from which rates are computed, or NULL. */
static const char *not_finite(const struct kith_hydro *hydro, kith_index i) {
  double moving = 0;
  for (int a = 0; a < NDIM; ++a)
    moving += fabs(hydro->nodes->position->f64[(size_t)i * NDIM + (size_t)a]) +
              fabs(hydro->velocity->f64[(size_t)i * NDIM + (size_t)a]);
  if (!isfinite(moving)) return "its position or velocity is not finite";
  if (!isfinite(hydro->energy->f64[i])) return "its energy is not finite";
  if (!isfinite(hydro->nodes->support->f64[i])) return "its support is not finite";
  return NULL;
}

/* Is node i at the end of the zone of an outflow, so that its support is in part beyond that end, and no gas
 * is in it? */
static bool ends_zone(const struct kith_hydro *hydro, kith_index i) {
  const struct kith_nodes *nodes = hydro->nodes;
  const int side = nodes->flag != NULL ? nodes->flag->u8[i] - KITH_ZONE : -1;
  if (side < 0) return false;
  const size_t axis = (size_t)side / 2;
  const double *zone = hydro->zone_ends[axis][side % 2], x = nodes->position->f64[(size_t)i * NDIM + axis],
               reach = nodes->support->f64[i] * nodes->stretch[axis];
  return zone[0] != zone[1] && fabs(x - zone[0]) > reach && fabs(x - zone[1]) < reach;
}

/* Returns what is wrong with the state or the rates of node i, or NULL. */
static const char *unphysical(const struct kith_hydro *hydro, kith_index i) {
  const char *wrong = not_finite(hydro, i);
  if (wrong != NULL) return wrong;
  for (int a = 0; a < NDIM; ++a)
    if (!isfinite(hydro->acceleration->f64[(size_t)i * NDIM + (size_t)a]))
      return "its acceleration is not finite";
  if (!(hydro->density->f64[i] > 0) || !isfinite(hydro->density->f64[i]))
    return "its density is not a positive number";
  if (ends_zone(hydro, i)) return NULL;
  const double u = hydro->energy->f64[i];
  const bool zero = u < 0 && u > -kith_hydro_energy_round_off(hydro, i);
  return kith_material_outside(&hydro->material[hydro->nodes->list->u8[i]], hydro->density->f64[i],
                               zero ? 0 : u, hydro->pressure->f64[i], hydro->sound_speed->f64[i]);
}

/* Fails with DIVERGED, naming the first internal node with which something is wrong. */
static kith_status check(const struct kith_hydro *hydro,
                         const char *(*wrong)(const struct kith_hydro *, kith_index)) {
  const struct kith_nodes *nodes = hydro->nodes;
  kith_index first = nodes->n_internal;
#pragma omp parallel for schedule(static) reduction(min : first)
  for (kith_index begin = 0; begin < nodes->n_internal; begin += KITH_STRETCH) {
    const kith_index end =
        kith_stretch_end(nodes, begin, nodes->n_internal); /* idle ones have been checked */
    for (kith_index i = begin; i < end; ++i)
      if (wrong(hydro, i) != NULL) first = KITH_MIN(first, i);
  }
  if (first == nodes->n_internal) return KITH_OK;
  const double *x = nodes->position->f64 + (size_t)first * NDIM;
  const int64_t id = nodes->id->i64[first];
  KITH_FAIL_NODE(DIVERGED, id, "node %lld at (%g, %g, %g): %s (density %g, energy %g)", (long long)id, x[0],
                 NDIM > 1 ? x[NDIM > 1 ? 1 : 0] : 0.0, NDIM > 2 ? x[NDIM - 1] : 0.0, wrong(hydro, first),
                 hydro->density->f64[first], hydro->energy->f64[first]);
}

kith_status kith_hydro_finite(const struct kith_hydro *hydro) {
  return check(hydro, not_finite);
}

kith_status kith_hydro_physical(const struct kith_hydro *hydro) {
  return check(hydro, unphysical);
}

kith_status kith_hydro_flag(struct kith_hydro *hydro) {
  const struct kith_field_row table[] = {
      {true, KITH_SPEC(VECTOR, OWN_WORK, "outside_force", "of partners that are no gas"),
       &hydro->outside_force},
      {true, KITH_SPEC(SCALAR, OWN_WORK, "outside_power", "dE/dt by partners that are no gas"),
       &hydro->outside_power},
      {0}};
  KITH_TRY(kith_nodes_flag(hydro->nodes));
  return kith_nodes_fields(hydro->nodes, table);
}

enum {
  MASS = 0,
  KINETIC,
  INTERNAL,
  POTENTIAL,
  SCALE,
  ANGULAR_SCALE,
  MOMENTUM,
  ANGULAR = MOMENTUM + NDIM,
  SUMS = ANGULAR + 3
};

enum { CHUNK = 128 }; /* nodes whose terms are summed together */

/* Computes (x - center) x v, with components along x, y, z. */
static inline void moment(const struct kith_hydro *hydro, kith_index i, const double *v, double out[3]) {
  double d[3] = {0}, w[3] = {0};
  for (int a = 0; a < NDIM; ++a)
    d[a] = hydro->nodes->position->f64[(size_t)i * NDIM + (size_t)a] - hydro->center[a], w[a] = v[a];
  for (int a = 0; a < 3; ++a) out[a] = d[(a + 1) % 3] * w[(a + 2) % 3] - d[(a + 2) % 3] * w[(a + 1) % 3];
}

/* Writes the terms of node i as entry k of a chunk; returns its |v| / c. */
static inline double node_terms(const struct kith_hydro *hydro, kith_index i, double term[SUMS][CHUNK],
                                int k) {
  const double *v = hydro->velocity->f64 + (size_t)i * NDIM, m = hydro->mass->f64[i], v2 = kith_dot(v, v);
  double turn[3];
  moment(hydro, i, v, turn);
  term[MASS][k] = m;
  term[KINETIC][k] = 0.5 * m * v2;
  term[INTERNAL][k] = m * hydro->energy->f64[i];
  term[SCALE][k] = m * KITH_MAX(sqrt(v2), hydro->sound_speed->f64[i]);
  term[ANGULAR_SCALE][k] = m * sqrt(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
  for (int a = 0; a < NDIM; ++a) term[MOMENTUM + a][k] = m * v[a];
  for (int a = 0; a < 3; ++a) term[ANGULAR + a][k] = m * turn[a];
  return v2 > 0 ? sqrt(v2) / hydro->sound_speed->f64[i] : 0;
}

/* Adds the gas of a chunk to the sums; returns its largest |v| / c. */
static double add_chunk(const struct kith_hydro *hydro, kith_index begin, kith_index end, bool forced,
                        struct kith_sum *sums) {
  double term[SUMS][CHUNK], fastest = 0;
  int n = 0;
  for (kith_index i = begin; i < end; ++i) {
    if (!kith_node_is_gas(hydro->nodes, i)) continue;
    const double speed = node_terms(hydro, i, term, n), *x = hydro->nodes->position->f64 + (size_t)i * NDIM;
    fastest = KITH_MAX(fastest, speed);
    if (forced)
      term[POTENTIAL][n] = hydro->mass->f64[i] * kith_external_force_potential(&hydro->external_force, x);
    ++n;
  }
  for (int k = 0; k < SUMS; ++k)
    if (forced || k != POTENTIAL) kith_sum_add_all(&sums[k], term[k], n);
  return fastest;
}

_Static_assert((int)SUMS < (int)KITH_HYDRO_PARTS, "the sums, and the largest velocity");

void kith_hydro_sum(const struct kith_hydro *hydro, struct kith_hydro_sums *all) {
  const bool forced = kith_external_force_acts(&hydro->external_force);
  double fastest = 0;
  memset(all, 0, sizeof *all);
#pragma omp parallel reduction(max : fastest)
  {
    struct kith_sum mine[SUMS] = {0};
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < hydro->nodes->n_internal; i += CHUNK) {
      const double speed = add_chunk(hydro, i, KITH_MIN(i + CHUNK, hydro->nodes->n_internal), forced, mine);
      fastest = KITH_MAX(fastest, speed);
    }
#pragma omp critical(kith_totals)
    for (int k = 0; k < SUMS; ++k) kith_sum_join(&all->sum[k], &mine[k]);
  }
  all->fastest = fastest;
}

int kith_hydro_share(struct kith_hydro_sums *sums, struct kith_shared *parts) {
  for (int k = 0; k < SUMS; ++k) parts[k] = kith_sum_shared(&sums->sum[k]);
  parts[SUMS] = (struct kith_shared){KITH_SHARE_MAX, 1, &sums->fastest};
  return SUMS + 1;
}

struct kith_totals kith_hydro_totals_of(const struct kith_hydro *hydro, const struct kith_hydro_sums *all) {
  double total[SUMS];
  for (int k = 0; k < SUMS; ++k) total[k] = kith_sum_value(&all->sum[k]);
  struct kith_totals t = {.mass = total[MASS],
                          .kinetic = total[KINETIC],
                          .internal = total[INTERNAL],
                          .potential = total[POTENTIAL],
                          .momentum_scale = total[SCALE],
                          .angular_scale = total[ANGULAR_SCALE],
                          .through = hydro->through,
                          .velocity_over_sound = all->fastest};
  for (int a = 0; a < NDIM; ++a)
    t.momentum[a] = total[MOMENTUM + a], t.work += hydro->wall[a] * (t.momentum[a] - t.through.momentum[a]);
  for (int a = 0; a < 3; ++a) t.angular[a] = total[ANGULAR + a];
  return t;
}

struct kith_totals kith_hydro_totals(const struct kith_hydro *hydro) {
  struct kith_hydro_sums sums;
  struct kith_shared parts[KITH_HYDRO_PARTS];
  kith_hydro_sum(hydro, &sums);
  kith_ranks_agree(hydro->nodes->ranks, KITH_OK, kith_hydro_share(&sums, parts), parts);
  return kith_hydro_totals_of(hydro, &sums);
}
