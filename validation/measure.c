/* Measures of a state that need no exact solution. */
#include "validation/measure.h"

#include <math.h>
#include <stdlib.h>

static double volume(const struct kith_measured *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

/* ---- viscosity ---- */

static void shear_mode(double kx, double ky, double e[2]) {
  (void)ky;
  e[0] = 0, e[1] = sin(kx);
}

static void vortex_mode(double kx, double ky, double e[2]) {
  e[0] = sin(kx) * cos(ky), e[1] = -cos(kx) * sin(ky);
}

/* nu, by the decay of a mode whose wavenumber squared is `squares` k^2. */
static double viscosity(const struct kith_measured *m, void (*mode)(double, double, double[2]),
                        double squares) {
  const int y = NDIM > 1;
  const double *lower = m->domain.lower, k = 2 * M_PI / (m->domain.upper[0] - lower[0]);
  double flow = 0, norm = 0, mass = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    double e[2];
    mode(k * (x[0] - lower[0]), k * (x[y] - lower[y]), e);
    flow += volume(m, i) * (v[0] * e[0] + v[y] * e[1]);
    norm += volume(m, i) * (e[0] * e[0] + e[1] * e[1]);
    mass += m->nodes->mass[i];
  }
  const double start = 2 * sqrt(m->kinetic_start / mass);
  return NDIM > 1 ? log(start / (flow / norm)) / (squares * k * k * m->time) : NAN;
}

kith_status kith_measure_shear_viscosity(const struct kith_measured *m, double *value) {
  *value = viscosity(m, shear_mode, 1);
  return KITH_OK;
}

kith_status kith_measure_vortex_viscosity(const struct kith_measured *m, double *value) {
  *value = viscosity(m, vortex_mode, 2);
  return KITH_OK;
}

kith_status kith_measure_mcnally(const struct kith_measured *m, double *value) {
  const int y_axis = NDIM > 1;
  double s = 0, c = 0, d = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double along = 4 * M_PI * (x[0] - m->domain.lower[0]), y = x[y_axis] - m->domain.lower[y_axis];
    const double w = volume(m, i) * exp(-4 * M_PI * fabs(KITH_MIN(y, 1 - y) - 0.25));
    s += w * v[y_axis] * sin(along);
    c += w * v[y_axis] * cos(along);
    d += w;
  }
  *value = NDIM > 1 ? 2 * hypot(s, c) / d : NAN;
  return KITH_OK;
}

/* ---- what is compared with the start ---- */

static double mode_amplitude(const struct kith_measured *m) {
  const int y_axis = NDIM > 1;
  const double *lower = m->domain.lower, *upper = m->domain.upper;
  const double k = 2 * M_PI / (upper[0] - lower[0]), middle = 0.5 * (lower[y_axis] + upper[y_axis]);
  double s = 0, c = 0, d = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double along = k * (x[0] - lower[0]), w = volume(m, i) * exp(-k * fabs(x[y_axis] - middle));
    s += w * v[y_axis] * sin(along);
    c += w * v[y_axis] * cos(along);
    d += w;
  }
  return NDIM > 1 ? 2 * hypot(s, c) / d : NAN;
}

kith_status kith_measure_growth(const struct kith_measured *m, double *value) {
  *value = mode_amplitude(m);
  if (m->start != NULL) *value = acosh(*value / m->start[KITH_MEASURE_growth]) / m->time;
  return KITH_OK;
}

static double deviation(const struct kith_measured *m) {
  double mass = 0, sum = 0, squares = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (kith_index i = 0; i < m->nodes->n; ++i) {
      const double r = sqrt(kith_distance2(m->nodes->position + (size_t)i * NDIM, m->center));
      if (pass == 0)
        mass += m->nodes->mass[i], sum += m->nodes->mass[i] * r;
      else
        squares += m->nodes->mass[i] * (r - sum / mass) * (r - sum / mass);
    }
  return sqrt(squares / mass);
}

kith_status kith_measure_spread(const struct kith_measured *m, double *value) {
  *value = deviation(m) / (m->start != NULL ? m->start[KITH_MEASURE_spread] : 1);
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

static double least_ratio(const struct place *p, kith_index n, double widest) {
  double least = INFINITY;
  for (kith_index i = 0; i < n; ++i)
    for (kith_index j = i + 1; j < n && p[j].x[0] - p[i].x[0] <= least * widest; ++j)
      least = KITH_MIN(least, 2 * sqrt(kith_distance2(p[i].x, p[j].x)) / (p[i].spacing + p[j].spacing));
  return least;
}

kith_status kith_measure_separation(const struct kith_measured *m, double *value) {
  struct place *place = NULL;
  const kith_index n = m->nodes->n;
  double widest = 0;
  *value = NAN;
  if (n < 2) return KITH_OK;
  KITH_TRY(kith_resize(&place, 0, (size_t)n, sizeof *place));
  for (kith_index i = 0; i < n; ++i) {
    for (int a = 0; a < NDIM; ++a) place[i].x[a] = m->nodes->position[i * NDIM + a];
    place[i].spacing = pow(volume(m, i), 1.0 / NDIM);
    widest = KITH_MAX(widest, place[i].spacing);
  }
  qsort(place, (size_t)n, sizeof *place, by_x);
  *value = least_ratio(place, n, widest);
  kith_free(&place);
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
#define X(name, doc) kith_measure_##name,
      KITH_MEASURE_LIST(X)
#undef X
  };
  return take[which](m, value);
}
