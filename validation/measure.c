/* Measures of a state that need no exact solution. */
#include "validation/measure.h"

#include <math.h>
#include <stdlib.h>
#include "lib/comm/sum.h"

static double volume(const struct kith_measured *m, kith_index i) {
  return m->nodes->mass[i] / m->nodes->density[i];
}

/* Values of sums over all ranks. */
static void values_of(const struct kith_measured *m, struct kith_sum *sum, int n, double *value) {
  kith_sum_ranks(m->nodes->ranks, sum, n);
  for (int k = 0; k < n; ++k) value[k] = kith_sum_value(&sum[k]);
}

/* The wave number of one wave along x. */
static double longest_wave(const struct kith_measured *m) {
  return 2 * M_PI / (m->domain.upper[0] - m->domain.lower[0]);
}

/* nu from the decay of a mode, of vortices or of a shear wave, whatever its phase; at the start its
 * amplitude. NaN where the flow has no such mode: 1e-6 of the speeds may be round-off. */
static double viscosity(const struct kith_measured *m, bool vortices) {
  enum { PHASES = 4, VOLUME = PHASES, SQUARES, SUMS };
  const int y = NDIM > 1, waves = vortices ? 2 : 1; /* axes along which the flow varies */
  const double *lower = m->domain.lower, k = longest_wave(m);
  struct kith_sum sum[SUMS] = {{{0}, 0}};
  double value[SUMS], squares = 0;
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    for (int p = 0; p < 2 * waves; ++p) {
      const double kx = k * (x[0] - lower[0]) + M_PI_2 * (p % 2),
                   ky = k * (x[y] - lower[y]) + M_PI_2 * (p / 2);
      const double flow = vortices ? v[0] * sin(kx) * cos(ky) - v[y] * cos(kx) * sin(ky) : v[y] * sin(kx);
      kith_sum_add(&sum[p], volume(m, i) * flow);
    }
    kith_sum_add(&sum[VOLUME], volume(m, i));
    kith_sum_add(&sum[SQUARES], volume(m, i) * (v[0] * v[0] + v[y] * v[y]));
  }
  values_of(m, sum, SUMS, value);
  for (int p = 0; p < PHASES; ++p) squares += value[p] * value[p];
  const double now = 2 * sqrt(squares) / value[VOLUME];
  if (NDIM == 1 || !(now > 1e-6 * sqrt(value[SQUARES] / value[VOLUME]))) return NAN;
  if (m->start == NULL) return now;
  const double start = m->start[vortices ? KITH_MEASURE_vortex_viscosity : KITH_MEASURE_shear_viscosity];
  return log(start / now) / (waves * k * k * m->time);
}

static double shear_viscosity(const struct kith_measured *m) {
  return viscosity(m, false);
}

static double vortex_viscosity(const struct kith_measured *m) {
  return viscosity(m, true);
}

/* Amplitude of a mode: 2 |sum w v_y exp(i k x)| / sum V exp(-n k distance), w = V exp(-k distance), distance
 * from the nearer of two layers, at 1/4 and 3/4 of the domain, or from its middle. */
static double amplitude(const struct kith_measured *m, double k, bool two_layers, int n) {
  const int y = NDIM > 1;
  const double *lower = m->domain.lower, side = m->domain.upper[y] - lower[y];
  struct kith_sum sum[3] = {{{0}, 0}};
  double value[3]; /* sine, cosine, weight */
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *x = m->nodes->position + (size_t)i * NDIM, *v = m->nodes->velocity + (size_t)i * NDIM;
    const double along = k * (x[0] - lower[0]), up = x[y] - lower[y];
    const double distance = fabs(two_layers ? KITH_MIN(up, side - up) - 0.25 * side : up - 0.5 * side);
    const double w = volume(m, i) * exp(-k * distance);
    kith_sum_add(&sum[0], w * v[y] * sin(along));
    kith_sum_add(&sum[1], w * v[y] * cos(along));
    kith_sum_add(&sum[2], volume(m, i) * exp(-n * k * distance));
  }
  values_of(m, sum, 3, value);
  return NDIM > 1 ? 2 * hypot(value[0], value[1]) / value[2] : NAN;
}

static double mcnally(const struct kith_measured *m) {
  return amplitude(m, 2 * longest_wave(m), true, 1);
}

/* Exact for a mode v_y ~ exp(-k |y|). */
static double ripple(const struct kith_measured *m) {
  return amplitude(m, longest_wave(m), false, 2);
}

/* Root of the mean square of the speeds, by volume. */
static double mean_speed(const struct kith_measured *m) {
  struct kith_sum sum[2] = {{{0}, 0}};
  double value[2]; /* squared speeds, volume */
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double *v = m->nodes->velocity + (size_t)i * NDIM;
    for (int a = 0; a < NDIM; ++a) kith_sum_add(&sum[0], volume(m, i) * v[a] * v[a]);
    kith_sum_add(&sum[1], volume(m, i));
  }
  values_of(m, sum, 2, value);
  return sqrt(value[0] / value[1]);
}

/* A mode that starts with 1e-12 of the speeds may be round-off, whose rate means nothing. */
static double growth(const struct kith_measured *m) {
  const double now = amplitude(m, longest_wave(m), false, 1);
  if (m->start == NULL) return now;
  const double start = m->start[KITH_MEASURE_growth];
  return start > 1e-12 * mean_speed(m) ? acosh(now / start) / m->time : NAN;
}

static double spread(const struct kith_measured *m) {
  struct kith_sum sum[3] = {{{0}, 0}};
  double value[3]; /* mass, mass times radius, mass times its squared distance from the mean radius */
  for (int pass = 0; pass < 2; ++pass) {
    for (kith_index i = 0; i < m->nodes->n; ++i) {
      const double r = sqrt(kith_distance2(m->nodes->position + (size_t)i * NDIM, m->center)),
                   mass = m->nodes->mass[i], off = pass > 0 ? r - value[1] / value[0] : 0;
      if (pass == 0) kith_sum_add(&sum[0], mass), kith_sum_add(&sum[1], mass * r);
      if (pass == 1) kith_sum_add(&sum[2], mass * off * off);
    }
    values_of(m, sum + 2 * pass, 2 - pass, value + 2 * pass);
  }
  return sqrt(value[2] / value[0]) / (m->start != NULL ? m->start[KITH_MEASURE_spread] : 1);
}

/* --- nodes against all others --- */

struct place {
  double x[NDIM], spacing;
};

/* A search: the nodes of this rank, in the order of x, meet those that are near enough along x, which are its
 * own and those of the other ranks; these go around. */
struct search {
  const struct kith_measured *m;
  kith_index n;
  struct place *place;   /* [n], owned */
  struct place *room[2]; /* for those of another rank, owned */
  double *nearest;       /* [n] for asymmetry: least distance of a node from the image of each; owned */
  double widest, least;  /* for separation: largest spacing of all ranks; least distance, in spacings */
};

static int by_x(const void *a, const void *b) {
  const double x = ((const struct place *)a)->x[0], y = ((const struct place *)b)->x[0];
  return (x > y) - (x < y);
}

static kith_status open_search(struct search *s, size_t most) {
  const struct kith_profile_view *nodes = s->m->nodes;
  KITH_TRY(kith_resize(&s->place, 0, (size_t)s->n, sizeof *s->place));
  KITH_TRY(kith_resize(&s->nearest, 0, (size_t)s->n, sizeof *s->nearest));
  for (int k = 0; k < 2 && nodes->ranks != NULL; ++k)
    KITH_TRY(kith_resize(&s->room[k], 0, most, sizeof *s->room[k]));
  for (kith_index i = 0; i < s->n; ++i) {
    for (int a = 0; a < NDIM; ++a)
      s->place[i].x[a] = nodes->position[(size_t)i * NDIM + a] - s->m->domain.lower[a];
    s->place[i].spacing = kith_root_dim(volume(s->m, i));
    s->nearest[i] = INFINITY;
    s->widest = KITH_MAX(s->widest, s->place[i].spacing);
  }
  if (s->n > 0) qsort(s->place, (size_t)s->n, sizeof *s->place, by_x);
  return KITH_OK;
}

/* Sends the nodes of all ranks around: in step k this rank meets those of the rank that is k before it. */
static kith_status go_round(struct search *s, const int64_t *count,
                            void (*meet)(struct search *s, const struct place *other, kith_index n)) {
  struct kith_ranks *ranks = s->m->nodes->ranks;
  const int me = kith_ranks_rank(ranks), size = kith_ranks_size(ranks);
  struct place *now = s->place;
  meet(s, now, s->n);
  for (int k = 1; k < size; ++k) {
    const int64_t here = count[(me - k + 1 + size) % size], coming = count[(me - k + size) % size];
    const struct kith_message out = {(me + 1) % size, now, (size_t)here * sizeof *now},
                              in = {(me - 1 + size) % size, s->room[k % 2], (size_t)coming * sizeof *now};
    KITH_TRY(kith_ranks_exchange(ranks, 1, &out, 1, &in));
    now = s->room[k % 2];
    meet(s, now, (kith_index)coming);
  }
  return KITH_OK;
}

/* Lets the nodes of this rank meet those of all ranks. *total: nodes of all ranks. */
static kith_status search_all(struct search *s, uint64_t *total,
                              void (*meet)(struct search *s, const struct place *other, kith_index n)) {
  struct kith_ranks *ranks = s->m->nodes->ranks;
  const int64_t mine = s->n;
  char *counts = NULL;
  KITH_TRY(kith_ranks_gather(ranks, &mine, sizeof mine, &counts, NULL));
  const int64_t *count = (const int64_t *)counts;
  size_t most = 0;
  *total = 0;
  for (int r = 0; r < kith_ranks_size(ranks); ++r)
    *total += (uint64_t)count[r], most = KITH_MAX(most, (size_t)count[r]);
  kith_status status = kith_ranks_allreduce_status(ranks, open_search(s, most));
  if (status == KITH_OK) kith_ranks_max(ranks, &s->widest, 1);
  if (status == KITH_OK) status = go_round(s, count, meet);
  kith_free(&counts);
  return status;
}

static void close_search(struct search *s) {
  KITH_FREE(&s->place, &s->nearest, &s->room[0], &s->room[1]);
}

static void meet_nodes(struct search *s, const struct place *other, kith_index n) {
  const struct place *p = s->place;
  for (kith_index i = 0, first = 0; i < s->n; ++i) {
    const double reach = s->least * s->widest;
    while (first < n && other[first].x[0] < p[i].x[0] - reach) ++first;
    for (kith_index j = first; j < n && other[j].x[0] - p[i].x[0] <= s->least * s->widest; ++j)
      if (&other[j] != &p[i])
        s->least = KITH_MIN(s->least,
                            2 * sqrt(kith_distance2(p[i].x, other[j].x)) / (p[i].spacing + other[j].spacing));
  }
}

static double separation(const struct kith_measured *m) {
  struct search s = {.m = m, .n = m->nodes->n, .least = INFINITY};
  uint64_t total = 0;
  const kith_status status = search_all(&s, &total, meet_nodes);
  kith_ranks_min(m->nodes->ranks, &s.least, 1);
  close_search(&s);
  return status == KITH_OK && total > 1 ? s.least : NAN;
}

static void meet_images(struct search *s, const struct place *other, kith_index n) {
  for (kith_index i = 0; i < s->n; ++i) {
    struct place image = s->place[i];
    image.x[0] = s->place[i].x[NDIM > 1], image.x[NDIM > 1] = s->place[i].x[0];
    kith_index low = 0, high = n; /* the first node that is not left of the image; from there both ways */
    while (low < high) {
      const kith_index middle = low + (high - low) / 2;
      if (other[middle].x[0] < image.x[0])
        low = middle + 1;
      else
        high = middle;
    }
    double *nearest = &s->nearest[i];
    for (kith_index k = low; k < n && other[k].x[0] - image.x[0] < *nearest; ++k)
      *nearest = KITH_MIN(*nearest, sqrt(kith_distance2(other[k].x, image.x)));
    for (kith_index k = low; k > 0 && image.x[0] - other[k - 1].x[0] < *nearest; --k)
      *nearest = KITH_MIN(*nearest, sqrt(kith_distance2(other[k - 1].x, image.x)));
  }
}

static double asymmetry(const struct kith_measured *m) {
  struct search s = {.m = m, .n = NDIM > 1 ? m->nodes->n : 0};
  struct kith_sum sum = {0};
  uint64_t total = 0;
  double farthest = 0, spacings;
  const kith_status status = search_all(&s, &total, meet_images);
  for (kith_index i = 0; i < s.n && status == KITH_OK; ++i) {
    farthest = KITH_MAX(farthest, s.nearest[i]);
    kith_sum_add(&sum, s.place[i].spacing);
  }
  kith_ranks_max(m->nodes->ranks, &farthest, 1);
  values_of(m, &sum, 1, &spacings);
  close_search(&s);
  return status == KITH_OK && total > 0 ? farthest / (spacings / (double)total) : NAN;
}

static double transmitted(const struct kith_measured *m) {
  const double middle = 0.5 * (m->domain.lower[0] + m->domain.upper[0]);
  const double round_off = 1e-9 * (m->domain.upper[0] - m->domain.lower[0]);
  struct kith_sum sum = {0};
  double heat, area = 1;
  for (int a = 1; a < NDIM; ++a) area *= m->domain.upper[a] - m->domain.lower[a];
  for (kith_index i = 0; i < m->nodes->n; ++i) {
    const double x = m->nodes->position[(size_t)i * NDIM] - middle,
                 heat_of = m->nodes->mass[i] * m->nodes->energy[i];
    kith_sum_add(&sum, heat_of * (fabs(x) < round_off ? 0.5 : x > 0));
  }
  values_of(m, &sum, 1, &heat);
  return heat / area - (m->start != NULL ? m->start[KITH_MEASURE_transmitted] : 0);
}

/* Densities of gas without a shock differ by less than this part, by noise and round-off. */
static const double least_jump = 0.05;

static double shock_angle(const struct kith_measured *m) {
  enum { SECTORS = 180 };
  const double length = m->domain.upper[0] - m->domain.lower[0], degree = M_PI / 180;
  struct kith_sum sums[2 * SECTORS] = {{{0}, 0}}; /* masses, then volumes */
  double value[2 * SECTORS], least = INFINITY, most = 0, before = NAN;
  const double *mass = value, *size = value + SECTORS;
  for (kith_index i = 0; NDIM > 1 && i < m->nodes->n; ++i) {
    const double x = m->nodes->position[(size_t)i * NDIM] - m->domain.lower[0],
                 y = m->nodes->position[(size_t)i * NDIM + (NDIM > 1)] - m->domain.lower[NDIM > 1],
                 r = sqrt(x * x + y * y), sector = 2 * atan2(y, x) / degree;
    if (!(r > 0.3 * length && r < 0.8 * length && sector >= 0 && sector < SECTORS)) continue;
    kith_sum_add(&sums[(int)sector], m->nodes->mass[i]);
    kith_sum_add(&sums[SECTORS + (int)sector], volume(m, i));
  }
  values_of(m, sums, 2 * SECTORS, value);
  for (int k = 0; k < SECTORS; ++k)
    if (size[k] > 0) least = fmin(least, mass[k] / size[k]), most = fmax(most, mass[k] / size[k]);
  if (!(most > (1 + least_jump) * least)) return NAN;
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
