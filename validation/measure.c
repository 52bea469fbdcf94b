/* Measures of a state that need no exact solution. */
#include "validation/measure.h"

#include <math.h>
#include <stdlib.h>

static double volume(const struct kith_measured *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

/* ---- viscosity ---- */

/* nu, by the decay of a mode: of vortices, or of a shear wave. */
static double viscosity(const struct kith_measured *m, bool vortices) {
  const int y = NDIM > 1;
  const double *lower = m->domain.lower, k = 2 * M_PI / (m->domain.upper[0] - lower[0]);
  double flow = 0, norm = 0, mass = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double kx = k * (x[0] - lower[0]), ky = k * (x[y] - lower[y]);
    const double e[] = {vortices ? sin(kx) * cos(ky) : 0, vortices ? -cos(kx) * sin(ky) : sin(kx)};
    flow += volume(m, i) * (v[0] * e[0] + v[y] * e[1]);
    norm += volume(m, i) * (e[0] * e[0] + e[1] * e[1]);
    mass += m->nodes->mass[i];
  }
  const double start = 2 * sqrt(m->kinetic_start / mass);
  return NDIM > 1 ? log(start / (flow / norm)) / ((vortices ? 2 : 1) * k * k * m->time) : NAN;
}

static kith_status shear_viscosity(const struct kith_measured *m, double *value) {
  *value = viscosity(m, false);
  return KITH_OK;
}

static kith_status vortex_viscosity(const struct kith_measured *m, double *value) {
  *value = viscosity(m, true);
  return KITH_OK;
}

/* ---- modes at an interface ---- */

/* Distance from the nearer layer, at 1/4 or 3/4 of a box of side 1; from the middle of the domain. */
static double from_layer(double y, double side) {
  (void)side;
  return fabs(KITH_MIN(y, 1 - y) - 0.25);
}
static double from_middle(double y, double side) {
  return fabs(y - 0.5 * side);
}

/* 2 |sum w v_y exp(i k x)| / sum w, w = V exp(-k distance). */
static double amplitude(const struct kith_measured *m, double k, double (*distance)(double y, double side)) {
  const int y = NDIM > 1;
  const double *lower = m->domain.lower, side = m->domain.upper[y] - lower[y];
  double s = 0, c = 0, d = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double along = k * (x[0] - lower[0]), w = volume(m, i) * exp(-k * distance(x[y] - lower[y], side));
    s += w * v[y] * sin(along);
    c += w * v[y] * cos(along);
    d += w;
  }
  return NDIM > 1 ? 2 * hypot(s, c) / d : NAN;
}

static kith_status mcnally(const struct kith_measured *m, double *value) {
  *value = amplitude(m, 4 * M_PI, from_layer);
  return KITH_OK;
}

static kith_status growth(const struct kith_measured *m, double *value) {
  *value = amplitude(m, 2 * M_PI / (m->domain.upper[0] - m->domain.lower[0]), from_middle);
  if (m->start != NULL) *value = acosh(*value / m->start[KITH_MEASURE_growth]) / m->time;
  return KITH_OK;
}

/* ---- the ring ---- */

static kith_status spread(const struct kith_measured *m, double *value) {
  double mass = 0, sum = 0, squares = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (kith_index i = 0; i < m->nodes->n; ++i) {
      const double r = sqrt(kith_distance2(m->nodes->position + (size_t)i * NDIM, m->center));
      if (pass == 0)
        mass += m->nodes->mass[i], sum += m->nodes->mass[i] * r;
      else
        squares += m->nodes->mass[i] * (r - sum / mass) * (r - sum / mass);
    }
  *value = sqrt(squares / mass) / (m->start != NULL ? m->start[KITH_MEASURE_spread] : 1);
  return KITH_OK;
}

/* ---- separation: nodes in the order of x, each against the next ones that are near enough along x ---- */

struct place {
  double x[NDIM], spacing;
};

static int by_x(const void *a, const void *b) {
  const double x = ((const struct place *)a)->x[0], y = ((const struct place *)b)->x[0];
  return (x > y) - (x < y);
}

static kith_status separation(const struct kith_measured *m, double *value) {
  struct place *p = NULL;
  const kith_index n = m->nodes->n;
  double widest = 0, least = INFINITY;
  KITH_TRY(kith_resize(&p, 0, (size_t)n, sizeof *p));
  for (kith_index i = 0; i < n; ++i) {
    for (int a = 0; a < NDIM; ++a) p[i].x[a] = m->nodes->position[i * NDIM + a];
    p[i].spacing = pow(volume(m, i), 1.0 / NDIM);
    widest = KITH_MAX(widest, p[i].spacing);
  }
  if (n > 0) qsort(p, (size_t)n, sizeof *p, by_x);
  for (kith_index i = 0; i < n; ++i)
    for (kith_index j = i + 1; j < n && p[j].x[0] - p[i].x[0] <= least * widest; ++j)
      least = KITH_MIN(least, 2 * sqrt(kith_distance2(p[i].x, p[j].x)) / (p[i].spacing + p[j].spacing));
  kith_free(&p);
  *value = n > 1 ? least : NAN;
  return KITH_OK;
}

static kith_status transmitted(const struct kith_measured *m, double *value) {
  const double middle = 0.5 * (m->domain.lower[0] + m->domain.upper[0]);
  double heat = 0, area = 1;
  for (int a = 1; a < NDIM; ++a) area *= m->domain.upper[a] - m->domain.lower[a];
  for (kith_index i = 0; i < m->nodes->n; ++i)
    if (m->nodes->position[(size_t)i * NDIM] > middle) heat += m->nodes->mass[i] * m->nodes->energy[i];
  *value = heat / area - (m->start != NULL ? m->start[KITH_MEASURE_transmitted] : 0);
  return KITH_OK;
}

/* ---- the list ---- */

const char *const kith_measure_names[KITH_N_MEASURES] = {
#define X(name, doc) #name,
    KITH_MEASURE_LIST(X)
#undef X
};

kith_status kith_measure_take(enum kith_measure which, const struct kith_measured *m, double *value) {
  static kith_status (*const take[KITH_N_MEASURES])(const struct kith_measured *, double *) = {
#define X(name, doc) name,
      KITH_MEASURE_LIST(X)
#undef X
  };
  return take[which](m, value);
}
