/* Measures of a state that need no exact solution. */
#include "validation/measure.h"

#include <math.h>
#include <stdlib.h>

static double volume(const struct kith_measured *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

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

static double shear_viscosity(const struct kith_measured *m) {
  return viscosity(m, false);
}

static double vortex_viscosity(const struct kith_measured *m) {
  return viscosity(m, true);
}

/* 2 |sum w v_y exp(i k x)| / sum w, w = V exp(-k distance), the distance from the nearer of two layers, at
 * 1/4 and 3/4 of a box of side 1, or from the middle of the domain. */
static double amplitude(const struct kith_measured *m, double k, bool two_layers) {
  const int y = NDIM > 1;
  const double *lower = m->domain.lower, middle = 0.5 * (m->domain.upper[y] - lower[y]);
  double s = 0, c = 0, d = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double along = k * (x[0] - lower[0]), up = x[y] - lower[y];
    const double distance = fabs(two_layers ? KITH_MIN(up, 1 - up) - 0.25 : up - middle);
    const double w = volume(m, i) * exp(-k * distance);
    s += w * v[y] * sin(along);
    c += w * v[y] * cos(along);
    d += w;
  }
  return NDIM > 1 ? 2 * hypot(s, c) / d : NAN;
}

static double mcnally(const struct kith_measured *m) {
  return amplitude(m, 4 * M_PI, true);
}

static double growth(const struct kith_measured *m) {
  const double now = amplitude(m, 2 * M_PI / (m->domain.upper[0] - m->domain.lower[0]), false);
  return m->start != NULL ? acosh(now / m->start[KITH_MEASURE_growth]) / m->time : now;
}

static double spread(const struct kith_measured *m) {
  double mass = 0, sum = 0, squares = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (kith_index i = 0; i < m->nodes->n; ++i) {
      const double r = sqrt(kith_distance2(m->nodes->position + (size_t)i * NDIM, m->center));
      if (pass == 0)
        mass += m->nodes->mass[i], sum += m->nodes->mass[i] * r;
      else
        squares += m->nodes->mass[i] * (r - sum / mass) * (r - sum / mass);
    }
  return sqrt(squares / mass) / (m->start != NULL ? m->start[KITH_MEASURE_spread] : 1);
}

/* Nodes in the order of x, each against the next ones that are near enough along x. */
struct place {
  double x[NDIM], spacing;
};

static int by_x(const void *a, const void *b) {
  const double x = ((const struct place *)a)->x[0], y = ((const struct place *)b)->x[0];
  return (x > y) - (x < y);
}

/* Owned by the caller; NULL without memory. */
static struct place *places_by_x(const struct kith_measured *m) {
  struct place *p = NULL;
  const kith_index n = m->nodes->n;
  if (kith_resize(&p, 0, (size_t)n, sizeof *p) != KITH_OK) return NULL;
  for (kith_index i = 0; i < n; ++i) {
    for (int a = 0; a < NDIM; ++a) p[i].x[a] = m->nodes->position[i * NDIM + a] - m->domain.lower[a];
    p[i].spacing = pow(volume(m, i), 1.0 / NDIM);
  }
  qsort(p, (size_t)n, sizeof *p, by_x);
  return p;
}

static double separation(const struct kith_measured *m) {
  const kith_index n = m->nodes->n;
  struct place *p = n < 2 ? NULL : places_by_x(m);
  double widest = 0, least = INFINITY;
  if (p == NULL) return NAN;
  for (kith_index i = 0; i < n; ++i) widest = KITH_MAX(widest, p[i].spacing);
  for (kith_index i = 0; i < n; ++i)
    for (kith_index j = i + 1; j < n && p[j].x[0] - p[i].x[0] <= least * widest; ++j)
      least = KITH_MIN(least, 2 * sqrt(kith_distance2(p[i].x, p[j].x)) / (p[i].spacing + p[j].spacing));
  kith_free(&p);
  return least;
}

static double asymmetry(const struct kith_measured *m) {
  const kith_index n = m->nodes->n;
  struct place *p = NDIM == 1 || n == 0 ? NULL : places_by_x(m);
  double farthest = 0, spacing = 0;
  if (p == NULL) return NAN;
  for (kith_index i = 0; i < n; ++i) {
    struct place image = p[i];
    image.x[0] = p[i].x[NDIM > 1], image.x[NDIM > 1] = p[i].x[0];
    kith_index low = 0, high = n; /* the first one that is not left of the image; from there both ways */
    while (low < high) {
      const kith_index middle = low + (high - low) / 2;
      if (p[middle].x[0] < image.x[0])
        low = middle + 1;
      else
        high = middle;
    }
    double nearest = INFINITY;
    for (kith_index k = low; k < n && p[k].x[0] - image.x[0] < nearest; ++k)
      nearest = KITH_MIN(nearest, sqrt(kith_distance2(p[k].x, image.x)));
    for (kith_index k = low; k > 0 && image.x[0] - p[k - 1].x[0] < nearest; --k)
      nearest = KITH_MIN(nearest, sqrt(kith_distance2(p[k - 1].x, image.x)));
    farthest = KITH_MAX(farthest, nearest), spacing += p[i].spacing / n;
  }
  kith_free(&p);
  return farthest / spacing;
}

static double transmitted(const struct kith_measured *m) {
  const double middle = 0.5 * (m->domain.lower[0] + m->domain.upper[0]);
  double heat = 0, area = 1;
  for (int a = 1; a < NDIM; ++a) area *= m->domain.upper[a] - m->domain.lower[a];
  for (kith_index i = 0; i < m->nodes->n; ++i)
    if (m->nodes->position[(size_t)i * NDIM] > middle) heat += m->nodes->mass[i] * m->nodes->energy[i];
  return heat / area - (m->start != NULL ? m->start[KITH_MEASURE_transmitted] : 0);
}

static double shock_angle(const struct kith_measured *m) {
  enum { SECTORS = 180 };
  const double length = m->domain.upper[0] - m->domain.lower[0], degree = acos(-1.0) / 180;
  double mass[SECTORS] = {0}, size[SECTORS] = {0}, least = INFINITY, most = 0, before = NAN;
  for (kith_index i = 0; NDIM > 1 && i < m->nodes->n; ++i) {
    const double x = m->nodes->position[(size_t)i * NDIM] - m->domain.lower[0],
                 y = m->nodes->position[(size_t)i * NDIM + (NDIM > 1)] - m->domain.lower[NDIM > 1],
                 r = sqrt(x * x + y * y), sector = 2 * atan2(y, x) / degree;
    if (!(r > 0.3 * length && r < 0.8 * length && sector >= 0 && sector < SECTORS)) continue;
    mass[(int)sector] += m->nodes->mass[i], size[(int)sector] += volume(m, i);
  }
  for (int k = 0; k < SECTORS; ++k)
    if (size[k] > 0) least = fmin(least, mass[k] / size[k]), most = fmax(most, mass[k] / size[k]);
  for (int k = 0, last = 0; k < SECTORS; ++k) {
    const double now = mass[k] / size[k], middle = 0.5 * (least + most);
    if (!(size[k] > 0)) continue;
    if (before >= middle && now < middle)
      return 0.5 * (last + 0.5 + (k - last) * (before - middle) / (before - now));
    before = now, last = k;
  }
  return NAN;
}

const char *const kith_measure_names[KITH_N_MEASURES] = {
#define X(name, doc) #name,
    KITH_MEASURE_LIST(X)
#undef X
};

double kith_measure_take(enum kith_measure which, const struct kith_measured *m) {
  static double (*const take[KITH_N_MEASURES])(const struct kith_measured *) = {
#define X(name, doc) name,
      KITH_MEASURE_LIST(X)
#undef X
  };
  return take[which](m);
}
