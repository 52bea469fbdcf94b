/* The window: which nodes are disturbed, and which are evaluated. */
#include "integrator/window.h"

/* Neighbors that a signal passes in one evaluation: by density, gradients and forces. */
enum { LAYERS = 3 };
/* Velocities below this part of the sound speed c, and rates below it in units of c and H, are gas at rest.
 * The round-off of forces on lattices is some 1e-14. */
static const double quiet = 1e-11;
/* A motion in a step below this part of H makes no new neighbor that counts: at the edge of a support forces
 * fall with the square of the distance from it, or faster. */
static const double still = 1e-6;

static bool is_disturbed(const struct kith_integrator *it, kith_index i) {
  const struct kith_hydro *hydro = it->hydro;
  const double c = hydro->sound_speed->f64[i], h = it->nodes->support->f64[i], u = hydro->energy->f64[i],
               v = kith_norm(hydro->velocity->f64 + (size_t)i * NDIM),
               a = kith_norm(hydro->acceleration->f64 + (size_t)i * NDIM);
  return !(v <= quiet * c && a * h <= quiet * c * c &&
           fabs(hydro->energy_rate->f64[i]) * h <= quiet * fabs(u) * c);
}

/* Is node i a neighbor of its own image in a face that moves? If it sleeps, no list shows that. */
static bool meets_face(const struct kith_integrator *it, kith_index i) {
  for (int k = 0; k < it->boundaries->n; ++k) {
    const struct kith_boundary *b = it->boundaries->boundary[k];
    if (kith_boundary_face_velocity(b->ops, b->settings) == 0) continue;
    const double x = it->nodes->position->f64[(size_t)i * NDIM + (size_t)b->axis];
    if (2 * (b->at_lower ? x - b->lower : b->upper - x) < it->nodes->support->f64[i]) return true;
  }
  return false;
}

static bool moves(const struct kith_integrator *it, kith_index i) {
  if (meets_face(it, i)) return true;
  const double v = kith_norm(it->hydro->velocity->f64 + (size_t)i * NDIM);
  return v * it->kick.evaluation_dt * it->evaluations > still * it->nodes->support->f64[i];
}

/* Marks in `to` the nodes that `from` marks, and their neighbors. */
static void add_neighbors(const struct kith_integrator *it, const uint8_t *restrict from,
                          uint8_t *restrict to) {
  const struct kith_rows *rows = &it->connectivity->rows;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    to[i] = from[i];
    for (size_t e = rows->first[i]; e < rows->first[i + 1] && !to[i]; ++e) to[i] = from[rows->node[e]];
  }
}

/* Returns marks of the nodes so near to one of the `sources` that an evaluation of a step may see it. */
static const uint8_t *reached(const struct kith_integrator *it,
                              bool (*sources)(const struct kith_integrator *, kith_index)) {
  struct kith_field *const *field = it->reached;
  const int layers = LAYERS * it->evaluations;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) field[0]->u8[i] = sources(it, i);
  for (int k = 0; k < layers; ++k) {
    kith_halo_refresh(it->hydro->halo, it->nodes, &field[k % 2], 1);
    add_neighbors(it, field[k % 2]->u8, field[(k + 1) % 2]->u8);
  }
  return field[layers % 2]->u8;
}

static void stop(const struct kith_field *rate, kith_index i) {
  for (int a = 0; rate != NULL && a < rate->components; ++a)
    rate->f64[(size_t)i * (size_t)rate->components + (size_t)a] = 0;
}

void kith_window_begin(struct kith_integrator *it) {
  const struct kith_package *package = it->package;
  const uint8_t *awake = reached(it, is_disturbed);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    if (awake[i]) continue;
    it->nodes->activity->u8[i] = KITH_IDLE;
    stop(it->hydro->acceleration, i);
    stop(it->hydro->energy_rate, i);
    stop(package->pair_acceleration, i);
    stop(package->energy_correction, i);
    stop(package->velocity_divergence, i);
    for (size_t k = (size_t)i * NDIM; k < (size_t)(i + 1) * NDIM; ++k) /* -0 becomes 0, as by a kick */
      it->kick.velocity_base->f64[k] = it->hydro->velocity->f64[k] += 0;
  }
}

/* Wakes the marked nodes; returns whether there are any on this rank that slept. */
static bool wake(const struct kith_integrator *it, const uint8_t *marked) {
  uint8_t *activity = it->nodes->activity->u8;
  int woken = 0;
#pragma omp parallel for schedule(static) reduction(| : woken)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i) {
    if (!marked[i] || activity[i] == KITH_ACTIVE) continue;
    activity[i] = KITH_ACTIVE;
    woken = 1;
  }
  return woken;
}

void kith_window_follow(struct kith_integrator *it) {
  wake(it, reached(it, is_disturbed));
}

bool kith_window_meets(struct kith_integrator *it) {
  return kith_ranks_any(it->nodes->ranks, wake(it, reached(it, moves)));
}

double kith_window_at_rest(const struct kith_integrator *it, double dt) {
  const kith_index n = it->nodes->n_internal;
  const double *x = it->nodes->position->f64;
  double fastest = 0;
  kith_index unreached = 0;
  struct kith_box disturbed = kith_box_empty();
  for (kith_index i = 0; i < n; ++i) {
    if (!is_disturbed(it, i)) continue;
    fastest = fmax(fastest,
                   kith_norm(it->hydro->velocity->f64 + (size_t)i * NDIM) + it->hydro->sound_speed->f64[i]);
    kith_box_include(&disturbed, x + (size_t)i * NDIM);
  }
  for (kith_index i = 0; i < n; ++i) {
    bool outside = false;
    for (int a = 0; a < NDIM; ++a)
      outside = outside || x[(size_t)i * NDIM + a] < disturbed.lower[a] - 2 * fastest * dt ||
                x[(size_t)i * NDIM + a] > disturbed.upper[a] + 2 * fastest * dt;
    unreached += outside;
  }
  return n > 0 ? (double)unreached / n : 0;
}
