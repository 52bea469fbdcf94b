/* Norms of a run against its exact solution: volume-weighted sums, shock radius, peaks, contact. */
#include "validation/norms.h"

#include <math.h>
#include <string.h>
#include "lib/comm/sum.h"
#include "lib/core/vec.h"

enum { BINS = 1 << 16 };             /* half of them on each side of the exact shock */
static const double peak_bin = 0.01; /* of the largest distance of a node */

struct measure {
  const struct kith_exact_ops *ops;
  const void *solution;
  double time, shock;
  const struct kith_exact_gas *about; /* NULL: along axis 0 */
  const struct kith_window *window;
  const struct kith_profile_view *nodes;
};

static const double *place(const struct measure *m, kith_index i) {
  return &m->nodes->position[(size_t)i * NDIM];
}

static double volume(const struct measure *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

bool kith_window_has(const struct kith_window *w, const struct kith_exact_ops *ops,
                     const struct kith_exact_gas *about, const double *x, double time) {
  static const struct kith_exact_gas origin;
  const double r = kith_exact_place(ops, about != NULL ? about : &origin, x, time);
  return w->x[0] <= x[0] && x[0] <= w->x[1] && w->r[0] <= r && r <= w->r[1];
}

static bool inside(const struct measure *m, kith_index i) {
  return kith_window_has(m->window, m->ops, m->about, place(m, i), m->time);
}

/* Where node i stands on the line along which the solution varies, and its speed along that, or around. */
static double coordinate(const struct measure *m, kith_index i) {
  return kith_exact_place(m->ops, m->about, place(m, i), m->time);
}

static double speed(const struct measure *m, kith_index i, const double *velocity) {
  return kith_exact_speed(m->ops, m->about, place(m, i), m->time, velocity);
}

static kith_status finite_nodes(const struct kith_profile_view *nodes) {
  const struct {
    const char *name;
    const double *value;
    size_t components;
    bool positive;
  } field[] = {{"position", nodes->position, NDIM, false},
               {"velocity", nodes->velocity, NDIM, false},
               {"mass", nodes->mass, 1, true},
               {"density", nodes->density, 1, true},
               {"pressure", nodes->pressure, 1, false},
               {"energy", nodes->energy, 1, false}};
  for (size_t f = 0; f < sizeof field / sizeof field[0]; ++f)
    for (size_t i = 0; i < (size_t)nodes->n * field[f].components; ++i)
      if (!isfinite(field[f].value[i]) || (field[f].positive && field[f].value[i] <= 0))
        KITH_FAIL(DIVERGED, "norms: node %lld has %s %g",
                  nodes->id != NULL ? (long long)nodes->id[i / field[f].components]
                                    : (long long)(i / field[f].components),
                  field[f].name, field[f].value[i]);
  return KITH_OK;
}

enum { FIELDS = 5 }; /* density, velocity, pressure, energy, speed */

enum { VOLUMES, FIRST, SECOND = FIRST + FIELDS, SUMS = SECOND + FIELDS }; /* sums of V, V d, V d^2 */

struct sums {
  struct kith_sum sum[SUMS];
  double linf[FIELDS];
  uint64_t nodes;
};

static void add_sums(struct sums *s, const struct sums *more) {
  for (int k = 0; k < SUMS; ++k) kith_sum_join(&s->sum[k], &more->sum[k]);
  for (int q = 0; q < FIELDS; ++q) s->linf[q] = KITH_MAX(s->linf[q], more->linf[q]);
  s->nodes += more->nodes;
}

/* The exact state at node i, and the velocity of the node: both 0 along axes where the exact one is not
 * known. */
static struct kith_exact_state exact_at(const struct measure *m, kith_index i, double velocity[NDIM]) {
  struct kith_exact_state exact;
  m->ops->state(m->solution, place(m, i), m->time, &exact);
  for (int a = 0; a < NDIM; ++a) {
    velocity[a] = isnan(exact.velocity[a]) ? 0 : m->nodes->velocity[(size_t)i * NDIM + (size_t)a];
    if (isnan(exact.velocity[a])) exact.velocity[a] = 0;
  }
  return exact;
}

static void add_node(struct sums *s, const struct measure *m, kith_index i) {
  const struct kith_profile_view *n = m->nodes;
  double velocity[NDIM];
  const struct kith_exact_state exact = exact_at(m, i, velocity);
  const double v = volume(m, i);
  const double d[FIELDS] = {fabs(n->density[i] - exact.density),
                            sqrt(kith_distance2(velocity, exact.velocity)),
                            fabs(n->pressure[i] - exact.pressure), fabs(n->energy[i] - exact.energy),
                            fabs(speed(m, i, velocity) - speed(m, i, exact.velocity))};
  kith_sum_add(&s->sum[VOLUMES], v);
  for (int q = 0; q < FIELDS; ++q) {
    kith_sum_add(&s->sum[FIRST + q], v * d[q]);
    kith_sum_add(&s->sum[SECOND + q], v * d[q] * d[q]);
    s->linf[q] = KITH_MAX(s->linf[q], d[q]);
  }
  ++s->nodes;
}

/* Sets norm[FIELDS]; returns the number of nodes of all ranks in the window. */
static uint64_t sum_nodes(const struct measure *m, struct kith_norm *norm) {
  struct sums total = {0};
#pragma omp parallel
  {
    struct sums own = {0};
#pragma omp for schedule(static)
    for (kith_index i = 0; i < m->nodes->n; ++i)
      if (inside(m, i)) add_node(&own, m, i);
#pragma omp critical(norms)
    add_sums(&total, &own);
  }
  kith_sum_ranks(m->nodes->ranks, total.sum, SUMS);
  kith_ranks_max(m->nodes->ranks, total.linf, FIELDS);
  kith_ranks_sum_counts(m->nodes->ranks, &total.nodes, 1);
  const double all = kith_sum_value(&total.sum[VOLUMES]);
  for (int q = 0; q < FIELDS; ++q)
    norm[q] = (struct kith_norm){kith_sum_value(&total.sum[FIRST + q]) / all,
                                 sqrt(kith_sum_value(&total.sum[SECOND + q]) / all), total.linf[q]};
  return total.nodes;
}

/* Sums over the nodes of a bin: of m, V, V times place, V times speed. They are integers, whose sums do not
 * depend on order; exact sums of 2^16 bins would take 150 MB. A term is rounded to a multiple of `unit`, of
 * which a sum of all nodes has less than 2^63. */
enum { MASS, VOLUME, MOMENT, FLOW, QUANTITIES };

struct bins {
  int64_t (*sum)[QUANTITIES]; /* [BINS], owned */
  double unit[QUANTITIES];
};

static double of_bin(const struct bins *bins, int k, int quantity) {
  return (double)bins->sum[k][quantity] * bins->unit[quantity];
}

static double bin_place(const struct bins *bins, int k) {
  return of_bin(bins, k, MOMENT) / of_bin(bins, k, VOLUME);
}

static double bin_speed(const struct bins *bins, int k) {
  return of_bin(bins, k, FLOW) / of_bin(bins, k, VOLUME);
}

/* Sets what node i adds to its bin; returns its place. */
static double bin_terms(const struct measure *m, kith_index i, double *term) {
  const double s = coordinate(m, i), v = volume(m, i);
  term[MASS] = m->nodes->mass[i], term[VOLUME] = v, term[MOMENT] = v * s;
  term[FLOW] = v * speed(m, i, &m->nodes->velocity[(size_t)i * NDIM]);
  return s;
}

static void choose_units(struct bins *bins, const struct measure *m) {
  double most[QUANTITIES] = {0}, term[QUANTITIES];
  uint64_t nodes = (uint64_t)m->nodes->n;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    if (!inside(m, i)) continue;
    bin_terms(m, i, term);
    for (int q = 0; q < QUANTITIES; ++q) most[q] = KITH_MAX(most[q], fabs(term[q]));
  }
  kith_ranks_max(m->nodes->ranks, most, QUANTITIES);
  kith_ranks_sum_counts(m->nodes->ranks, &nodes, 1);
  for (int q = 0; q < QUANTITIES; ++q)
    bins->unit[q] = most[q] > 0 ? ldexp(1, ilogb(most[q]) + ilogb((double)nodes) + 2 - 62) : 1;
}

/* Fills BINS bins of this width, the middle of them at `origin`; those at the ends take all that is
 * beyond. */
static void fill_bins(struct bins *bins, const struct measure *m, double origin, double width) {
  double term[QUANTITIES];
  memset(bins->sum, 0, BINS * sizeof *bins->sum);
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    if (!inside(m, i)) continue;
    const double s = bin_terms(m, i, term), k = floor((s - origin) / width) + BINS / 2;
    int64_t *sum = bins->sum[k < 0 ? 0 : k > BINS - 1 ? BINS - 1 : (int)k];
    for (int q = 0; q < QUANTITIES; ++q) sum[q] += llrint(term[q] / bins->unit[q]);
  }
  kith_ranks_sum_counts(m->nodes->ranks, (uint64_t *)bins->sum, BINS * QUANTITIES);
}

/* Mean spacing of the nodes within `distance` of the exact shock; 0 if there are none. *mass: mean mass. */
static double spacing_near_shock(const struct measure *m, double distance, double *mass) {
  struct kith_sum sum[2] = {{{0}, 0}}; /* volume, mass */
  uint64_t count = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i)
    if (inside(m, i) && fabs(coordinate(m, i) - m->shock) <= distance)
      kith_sum_add(&sum[0], volume(m, i)), kith_sum_add(&sum[1], m->nodes->mass[i]), ++count;
  kith_sum_ranks(m->nodes->ranks, sum, 2);
  kith_ranks_sum_counts(m->nodes->ranks, &count, 1);
  *mass = count > 0 ? kith_sum_value(&sum[1]) / (double)count : *mass;
  return count > 0 ? kith_root_dim(kith_sum_value(&sum[0]) / (double)count) : 0;
}

/* Exact state at an offset from the exact shock: returns its density; *speed: its outward speed. */
static double density_beside(const struct measure *m, double offset, double *speed) {
  double x[NDIM] = {0};
  for (int a = 0; m->about != NULL && a < NDIM; ++a) x[a] = m->about->center[a]; /* blasts rest */
  x[0] += m->shock + offset;
  struct kith_exact_state s;
  m->ops->state(m->solution, x, m->time, &s);
  *speed = s.velocity[0];
  return s.density;
}

/* The place where the speed first rises through `level`, going inwards: from the highest bin if out is 1,
 * else from the lowest. 0: nowhere. */
static double crossing(const struct bins *bins, int out, double level) {
  int before = -1;
  for (int n = 0; n < BINS; ++n) {
    const int k = out > 0 ? BINS - 1 - n : n;
    if (bins->sum[k][VOLUME] <= 0) continue;
    if (out * bin_speed(bins, k) >= level) {
      if (before < 0) return 0; /* the window begins behind the shock */
      const double s =
          (level - out * bin_speed(bins, before)) / (out * (bin_speed(bins, k) - bin_speed(bins, before)));
      return bin_place(bins, before) + s * (bin_place(bins, k) - bin_place(bins, before));
    }
    before = k;
  }
  return 0;
}

/* Radius that the gas inside `place` had before the blast, from its part of the mass of the window; 0 if the
 * window is no ball, or the gas ahead is not of one density. */
static double swept_radius(const struct measure *m, double place) {
  const double radius = m->window->r[1];
  struct kith_sum sum[2] = {{{0}, 0}}; /* mass inside, all */
  double speed;
  if (m->about == NULL || m->window->r[0] > 0 || !isfinite(radius)) return 0;
  const double edge = density_beside(m, radius - m->shock, &speed);
  if (fabs(edge / density_beside(m, 1e-6 * m->shock, &speed) - 1) > 1e-9) return 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    if (!inside(m, i)) continue;
    kith_sum_add(&sum[1], m->nodes->mass[i]);
    if (coordinate(m, i) <= place) kith_sum_add(&sum[0], m->nodes->mass[i]);
  }
  kith_sum_ranks(m->nodes->ranks, sum, 2);
  return radius * kith_root_dim(kith_sum_value(&sum[0]) / kith_sum_value(&sum[1]));
}

static void find_shock(const struct measure *m, struct bins *bins, double width, double mass,
                       struct kith_norms *norms) {
  fill_bins(bins, m, m->shock, width);
  double below, above, peak = -INFINITY;
  const double low = density_beside(m, -1e-6 * width, &below), high = density_beside(m, 1e-6 * width, &above);
  const int out = high < low ? 1 : -1;
  norms->shock_side = m->ops->star != NULL ? out : 0;
  const double ahead = out > 0 ? above : -below, behind = out > 0 ? below : -above;
  for (int k = 0; k < BINS; ++k)
    if (bins->sum[k][VOLUME] > 0) peak = KITH_MAX(peak, out * bin_speed(bins, k));
  const double level = (ahead + KITH_MIN(peak, behind)) / 2;
  if (level > ahead) norms->shock_radius = crossing(bins, out, level);
  if (norms->shock_radius == 0) return;
  norms->shock_offset = out * (norms->shock_radius - m->shock) / kith_root_dim(mass / KITH_MIN(low, high));
  norms->shock_swept = swept_radius(m, norms->shock_radius);
}

static void measure_peaks(const struct measure *m, struct bins *bins, double width, struct kith_norms *out) {
  if (m->about == NULL) {
    for (kith_index i = 0; i < m->nodes->n; ++i)
      if (inside(m, i)) out->density_peak = KITH_MAX(out->density_peak, m->nodes->density[i]);
    kith_ranks_max(m->nodes->ranks, &out->density_peak, 1);
    return;
  }
  double farthest = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i)
    if (inside(m, i)) farthest = KITH_MAX(farthest, coordinate(m, i));
  kith_ranks_max(m->nodes->ranks, &farthest, 1);
  fill_bins(bins, m, 0, KITH_MAX(width, peak_bin * farthest));
  for (int k = 0; k < BINS; ++k) {
    if (bins->sum[k][VOLUME] <= 0) continue;
    out->density_peak = KITH_MAX(out->density_peak, of_bin(bins, k, MASS) / of_bin(bins, k, VOLUME));
    out->speed_peak = KITH_MAX(out->speed_peak, fabs(bin_speed(bins, k)));
  }
}

static double contact_pressure_error(const struct measure *m) {
  const struct kith_exact_star star = m->ops->star(m->solution);
  if (star.pressure == 0) return 0;
  double worst = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double d = place(m, i)[0] - star.interface - star.velocity * m->time; /* from the contact */
    const double wave = (star.tail[d > 0] - star.velocity) * m->time;
    if (fabs(d) > 0.5 * fabs(wave) || !inside(m, i)) continue;
    worst = KITH_MAX(worst, fabs((m->nodes->pressure[i] - star.pressure) / star.pressure));
  }
  kith_ranks_max(m->nodes->ranks, &worst, 1);
  return worst;
}

static struct kith_norms compare(const struct measure *m, struct bins *bins) {
  static const struct kith_norm none = {NAN, NAN, NAN};
  struct kith_norm norm[FIELDS];
  const uint64_t count = sum_nodes(m, norm);
  for (int q = 0; q < FIELDS && count == 0; ++q) norm[q] = none; /* no node is in the window */
  struct kith_norms norms = {.density = norm[0],
                             .velocity = norm[1],
                             .pressure = norm[2],
                             .energy = norm[3],
                             .speed = norm[4],
                             .vortex = m->ops->vortex,
                             .carried = m->about != NULL && kith_norm(m->about->uniform_velocity) > 0,
                             .nodes = count,
                             .shock_exact = m->shock};
  const double *inside = m->ops->radial ? m->window->r : m->window->x;
  norms.shock_outside = m->shock != 0 && !(m->shock >= inside[0] && m->shock <= inside[1]);
  if (count == 0) return norms;
  double mass = 0;
  const double mean = spacing_near_shock(m, INFINITY, &mass), near = spacing_near_shock(m, 4 * mean, &mass);
  const double spacing = near > 0 ? near : mean;
  choose_units(bins, m);
  if (m->shock != 0) find_shock(m, bins, spacing, mass, &norms);
  measure_peaks(m, bins, spacing, &norms);
  if (m->ops->star != NULL) norms.contact_pressure_error = contact_pressure_error(m);
  return norms;
}

kith_status kith_norms_measure(struct kith_norms *out, const struct kith_exact_ops *ops, const void *solution,
                               double time, const struct kith_window *window,
                               const struct kith_profile_view *nodes) {
  const double shock = ops->shock == NULL ? 0 : ops->shock(solution, time);
  const struct measure m = {ops, solution, time, shock, kith_exact_about(ops, solution), window, nodes};
  struct bins bins = {0};
  kith_status status = finite_nodes(nodes);
  if (status == KITH_OK) status = kith_resize(&bins.sum, 0, BINS, sizeof *bins.sum);
  status = kith_ranks_allreduce_status(nodes->ranks, status);
  if (status == KITH_OK) *out = compare(&m, &bins);
  kith_free(&bins.sum);
  return status;
}

struct differences {
  struct kith_sum of[3], both[3]; /* of density, velocity and energy: differences, sums of both */
};

static void add_difference(struct differences *d, const struct measure *m, kith_index i) {
  const struct kith_profile_view *n = m->nodes;
  double velocity[NDIM];
  const struct kith_exact_state exact = exact_at(m, i, velocity);
  const double fast = kith_norm(velocity),
               of[] = {fabs(n->density[i] - exact.density), sqrt(kith_distance2(velocity, exact.velocity)),
                       fabs(n->energy[i] - exact.energy)},
               both[] = {fabs(n->density[i]) + fabs(exact.density), fast + kith_norm(exact.velocity),
                         fabs(n->energy[i]) + fabs(exact.energy) + fast * fast};
  for (int q = 0; q < 3; ++q) {
    kith_sum_add(&d->of[q], volume(m, i) * of[q]);
    kith_sum_add(&d->both[q], volume(m, i) * both[q]);
  }
}

double kith_norms_mismatch(const char **name, const struct kith_exact_ops *ops, const void *solution,
                           bool blast, const struct kith_window *window,
                           const struct kith_profile_view *nodes) {
  static const char *const names[] = {"density", "velocity", "energy"};
  const struct measure m = {ops, solution, 0, 0, kith_exact_about(ops, solution), window, nodes};
  struct differences all = {0};
  double most = 0;
#pragma omp parallel
  {
    struct differences own = {0};
#pragma omp for schedule(static)
    for (kith_index i = 0; i < nodes->n; ++i)
      if (inside(&m, i)) add_difference(&own, &m, i);
#pragma omp critical(norms)
    for (int q = 0; q < 3; ++q)
      kith_sum_join(&all.of[q], &own.of[q]), kith_sum_join(&all.both[q], &own.both[q]);
  }
  kith_sum_ranks(nodes->ranks, all.of, 3);
  kith_sum_ranks(nodes->ranks, all.both, 3);
  for (int q = 0; q < (blast ? 2 : 3); ++q) {
    const double both = kith_sum_value(&all.both[q]), part = both > 0 ? kith_sum_value(&all.of[q]) / both : 0;
    if (part > most) most = part, *name = names[q];
  }
  return most;
}
