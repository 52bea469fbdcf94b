/* Norms of a run against its exact solution: volume-weighted sums, shock radius, peaks, contact. */
#include "validation/norms.h"

#include <math.h>
#include <string.h>
#include "lib/core/vec.h"

enum { BLOCK = 1024 };   /* nodes per partial sum */
enum { BINS = 1 << 16 }; /* half of them on each side of the exact shock */
static const double peak_bin = 0.005;

struct measure {
  const struct kith_exact_ops *ops;
  const void *solution;
  double time, shock;
  const double *center; /* NULL: along axis 0 */
  const struct kith_window *window;
  const struct kith_profile_view *nodes;
};

static const double *place(const struct measure *m, kith_index i) {
  return &m->nodes->position[(size_t)i * NDIM];
}

static double volume(const struct measure *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

static bool inside(const struct measure *m, kith_index i) {
  static const double origin[NDIM];
  const struct kith_window *w = m->window;
  const double *x = place(m, i), r = kith_exact_place(m->ops, m->center != NULL ? m->center : origin, x);
  return w->x[0] <= x[0] && x[0] <= w->x[1] && w->r[0] <= r && r <= w->r[1];
}

/* Where node i stands on the line along which the solution varies, and its speed along that, or around. */
static double coordinate(const struct measure *m, kith_index i) {
  return kith_exact_place(m->ops, m->center, place(m, i));
}

static double speed(const struct measure *m, kith_index i, const double *velocity) {
  return kith_exact_speed(m->ops, m->center, place(m, i), velocity);
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
        KITH_FAIL(DIVERGED, "norms: node %zu has %s %g", i / field[f].components, field[f].name,
                  field[f].value[i]);
  return KITH_OK;
}

enum { FIELDS = 5 }; /* density, velocity, pressure, energy, speed */

struct sums {
  double volume;
  kith_index nodes;
  struct kith_norm field[FIELDS];
};

static void add_sums(struct sums *s, const struct sums *more) {
  s->volume += more->volume;
  s->nodes += more->nodes;
  for (int q = 0; q < FIELDS; ++q) {
    s->field[q].l1 += more->field[q].l1;
    s->field[q].l2 += more->field[q].l2;
    s->field[q].linf = KITH_MAX(s->field[q].linf, more->field[q].linf);
  }
}

static void add_node(struct sums *s, const struct measure *m, kith_index i) {
  const struct kith_profile_view *n = m->nodes;
  struct kith_exact_state exact;
  m->ops->state(m->solution, place(m, i), m->time, &exact);
  const double *velocity = &n->velocity[(size_t)i * NDIM], v = volume(m, i);
  const double d[FIELDS] = {fabs(n->density[i] - exact.density),
                            sqrt(kith_distance2(velocity, exact.velocity)),
                            fabs(n->pressure[i] - exact.pressure), fabs(n->energy[i] - exact.energy),
                            fabs(speed(m, i, velocity) - speed(m, i, exact.velocity))};
  struct sums own = {.volume = v, .nodes = 1};
  for (int q = 0; q < FIELDS; ++q) own.field[q] = (struct kith_norm){v * d[q], v * d[q] * d[q], d[q]};
  add_sums(s, &own);
}

static kith_status sum_blocks(const struct measure *m, struct sums *total) {
  const kith_index n = m->nodes->n, blocks = n / BLOCK + (n % BLOCK > 0);
  struct sums *part = NULL;
  KITH_TRY(kith_resize(&part, 0, (size_t)blocks, sizeof *part));
#pragma omp parallel for schedule(static)
  for (kith_index b = 0; b < blocks; ++b)
    for (kith_index i = b * BLOCK; i < n && i - b * BLOCK < BLOCK; ++i)
      if (inside(m, i)) add_node(&part[b], m, i);
  *total = (struct sums){0};
  for (kith_index b = 0; b < blocks; ++b) add_sums(total, &part[b]);
  kith_free(&part);
  for (int q = 0; q < FIELDS && total->nodes > 0; ++q) {
    total->field[q].l1 /= total->volume;
    total->field[q].l2 = sqrt(total->field[q].l2 / total->volume);
  }
  return KITH_OK;
}

struct bin {
  double mass, volume, moment, flow; /* sums of m, V, V times place, V times speed */
};

static double bin_speed(const struct bin *b) {
  return b->flow / b->volume;
}

/* BINS bins of this width, the middle of them at `origin`; the two at the ends take all that lies beyond. */
static void fill_bins(struct bin *bin, const struct measure *m, double origin, double width) {
  memset(bin, 0, BINS * sizeof *bin);
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    if (!inside(m, i)) continue;
    const double s = coordinate(m, i), v = volume(m, i);
    const double k = floor((s - origin) / width) + BINS / 2;
    struct bin *b = &bin[k < 0 ? 0 : k > BINS - 1 ? BINS - 1 : (int)k];
    b->mass += m->nodes->mass[i];
    b->volume += v;
    b->moment += v * s;
    b->flow += v * speed(m, i, &m->nodes->velocity[(size_t)i * NDIM]);
  }
}

/* Mean spacing of the nodes within `distance` of the exact shock; 0 if there are none. *mass: their mean. */
static double spacing_near_shock(const struct measure *m, double distance, double *mass) {
  double sum = 0, masses = 0;
  kith_index count = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i)
    if (inside(m, i) && fabs(coordinate(m, i) - m->shock) <= distance)
      sum += volume(m, i), masses += m->nodes->mass[i], ++count;
  *mass = count > 0 ? masses / count : *mass;
  return count > 0 ? pow(sum / count, 1.0 / NDIM) : 0;
}

/* Exact state beside the exact shock: its density, and its outward speed. */
static double density_beside(const struct measure *m, double offset, double *speed) {
  double x[NDIM] = {0};
  for (int a = 0; m->center != NULL && a < NDIM; ++a) x[a] = m->center[a];
  x[0] += m->shock + offset;
  struct kith_exact_state s;
  m->ops->state(m->solution, x, m->time, &s);
  *speed = s.velocity[0];
  return s.density;
}

/* Inwards, from the highest bin if out is 1, else from the lowest: where the speed rises through `level`. */
static double crossing(const struct bin *bin, int out, double level) {
  const struct bin *before = NULL;
  for (int k = 0; k < BINS; ++k) {
    const struct bin *b = &bin[out > 0 ? BINS - 1 - k : k];
    if (b->volume <= 0) continue;
    if (out * bin_speed(b) >= level) {
      if (before == NULL) return 0; /* the window begins behind the shock */
      const double s = (level - out * bin_speed(before)) / (out * (bin_speed(b) - bin_speed(before)));
      const double place = before->moment / before->volume;
      return place + s * (b->moment / b->volume - place);
    }
    before = b;
  }
  return 0;
}

static void find_shock(const struct measure *m, struct bin *bin, double width, double mass,
                       struct kith_norms *norms) {
  fill_bins(bin, m, m->shock, width);
  double below, above, peak = -INFINITY;
  const double low = density_beside(m, -1e-6 * width, &below), high = density_beside(m, 1e-6 * width, &above);
  const int out = high < low ? 1 : -1;
  const double ahead = out > 0 ? above : -below, behind = out > 0 ? below : -above;
  for (int k = 0; k < BINS; ++k)
    if (bin[k].volume > 0) peak = KITH_MAX(peak, out * bin_speed(&bin[k]));
  const double level = (ahead + KITH_MIN(peak, behind)) / 2;
  if (level > ahead) norms->shock_radius = crossing(bin, out, level);
  if (norms->shock_radius != 0)
    norms->shock_offset =
        out * (norms->shock_radius - m->shock) / pow(mass / KITH_MIN(low, high), 1.0 / NDIM);
}

static void measure_peaks(const struct measure *m, struct bin *bin, double width, struct kith_norms *out) {
  if (m->center == NULL) {
    for (kith_index i = 0; i < m->nodes->n; ++i)
      if (inside(m, i)) out->density_peak = KITH_MAX(out->density_peak, m->nodes->density[i]);
    return;
  }
  fill_bins(bin, m, 0, KITH_MAX(width, peak_bin));
  for (int k = 0; k < BINS; ++k) {
    if (bin[k].volume <= 0) continue;
    out->density_peak = KITH_MAX(out->density_peak, bin[k].mass / bin[k].volume);
    out->speed_peak = KITH_MAX(out->speed_peak, fabs(bin_speed(&bin[k])));
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
  return worst;
}

kith_status kith_norms_measure(struct kith_norms *out, const struct kith_exact_ops *ops, const void *solution,
                               double time, const struct kith_window *window,
                               const struct kith_profile_view *nodes) {
  KITH_TRY(finite_nodes(nodes));
  const double shock = ops->shock == NULL ? 0 : ops->shock(solution, time);
  const double *center = kith_exact_center(ops, solution);
  const struct measure m = {ops, solution, time, shock, center, window, nodes};
  struct sums sums;
  KITH_TRY(sum_blocks(&m, &sums));
  struct kith_norms norms = {.density = sums.field[0],
                             .velocity = sums.field[1],
                             .pressure = sums.field[2],
                             .energy = sums.field[3],
                             .speed = sums.field[4],
                             .vortex = ops->vortex,
                             .nodes = sums.nodes,
                             .shock_exact = shock};
  const double *inside = ops->radial ? window->r : window->x;
  norms.shock_outside = shock != 0 && !(shock >= inside[0] && shock <= inside[1]);
  if (sums.nodes > 0) {
    double mass = 0;
    const double mean = spacing_near_shock(&m, INFINITY, &mass),
                 near = spacing_near_shock(&m, 4 * mean, &mass);
    const double spacing = near > 0 ? near : mean;
    struct bin *bin = NULL;
    KITH_TRY(kith_resize(&bin, 0, BINS, sizeof *bin));
    if (shock != 0) find_shock(&m, bin, spacing, mass, &norms);
    measure_peaks(&m, bin, spacing, &norms);
    if (ops->star != NULL) norms.contact_pressure_error = contact_pressure_error(&m);
    kith_free(&bin);
  } else { /* nothing was compared: no number passes for that */
    static const struct kith_norm none = {NAN, NAN, NAN};
    norms.density = norms.velocity = norms.pressure = norms.energy = norms.speed = none;
  }
  *out = norms;
  return KITH_OK;
}
