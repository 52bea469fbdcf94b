/* two-blasts: gas of density 1 at rest between walls at x = 0 and 1, pressure 1000 up to 0.1, 100 beyond 0.9
 * and 0.01 in between (Woodward and Colella, J. Comput. Phys. 54 (1984) 115). Two blasts run into each other;
 * the state of interest is that of 0.038.
 *
 * There is no exact solution: this is that of lagrange.h, kept at equal times from 0 to `end_time` and
 * interpolated between them with the gas, so that contacts stay sharp; shocks are so only at the times kept,
 * of which end_time is one. With 800 cells density is good to 1 % (4000 cells differ by that), places of
 * shocks and contacts to 0.001, but for two or three cells beside each contact, where the violent start
 * leaves a wrong density. Beyond end_time: the last state. Takes half a second to create. */
#include "validation/exact/exact_parameters.h"
#include "validation/exact/lagrange.h"

#include <math.h>
#include <string.h>

enum { CELLS = 800, KEPT = 40, FIELDS = 3 };

struct settings {
  double gamma, end_time;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA(settings),
    {"end_time", KITH_PARAM_NUMBER, NULL, "[0, inf)", "computed until then",
     KITH_INTO(struct settings, end_time), .unit = "time"},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  *(struct settings *)settings = (struct settings){scene->region[0].gamma, scene->until};
}

struct two_blasts {
  double gamma, end;
  int n;        /* cells */
  double *face; /* [KEPT + 1][n + 1] */
  double *cell; /* [KEPT + 1][FIELDS][n]: volume, velocity, pressure */
};

static void blasts_destroy(void **self) {
  struct two_blasts *b = *self;
  if (b == NULL) return;
  kith_free(&b->face);
  kith_free(&b->cell);
  kith_free(self);
}

static void keep(struct two_blasts *b, int k, const struct kith_lagrange *flow) {
  const double *const field[FIELDS] = {flow->volume, flow->velocity, flow->pressure};
  const size_t n = (size_t)b->n;
  memcpy(b->face + (size_t)k * (n + 1), flow->face, (n + 1) * sizeof(double));
  for (int q = 0; q < FIELDS; ++q)
    memcpy(b->cell + ((size_t)k * FIELDS + q) * n, field[q], n * sizeof(double));
}

static kith_status compute(struct two_blasts *b, struct kith_lagrange *flow) {
  const size_t n = (size_t)flow->n;
  b->n = flow->n;
  KITH_TRY(kith_resize(&b->face, 0, (KEPT + 1) * (n + 1), sizeof(double)));
  KITH_TRY(kith_resize(&b->cell, 0, (KEPT + 1) * FIELDS * n, sizeof(double)));
  for (int k = 0; k <= KEPT; ++k) {
    KITH_TRY(kith_lagrange_run(flow, k < KEPT ? b->end * k / KEPT : b->end));
    keep(b, k, flow);
  }
  return KITH_OK;
}

static kith_status blasts_create(void **self, const void *settings) {
  const struct settings *p = settings;
  static const struct kith_slab slabs[] = {{0, 1, 0, 1000}, {0.1, 1, 0, 0.01}, {0.9, 1, 0, 100}};
  struct two_blasts *b = NULL;
  struct kith_lagrange *flow = NULL;
  void *made;
  KITH_TRY(kith_resize(&b, 0, 1, sizeof *b));
  made = b;
  b->gamma = p->gamma, b->end = p->end_time;
  kith_status status = kith_lagrange_create(&flow, b->gamma, 3, slabs, 1, CELLS);
  if (status == KITH_OK) status = compute(b, flow);
  kith_lagrange_destroy(&flow);
  if (status != KITH_OK) blasts_destroy(&made);
  *self = made;
  return status;
}

/* Between two of the kept times: `early`, and `part` of the way to the next. */
struct moment {
  const struct two_blasts *b;
  int early;
  double part;
};

static double face_at(const struct moment *m, int i) {
  const double *face = m->b->face + (size_t)m->early * (size_t)(m->b->n + 1) + i;
  return (1 - m->part) * face[0] + m->part * face[m->b->n + 1];
}

static double value_at(const struct moment *m, int q, int i) {
  const size_t n = (size_t)m->b->n;
  const double *value = m->b->cell + ((size_t)m->early * FIELDS + q) * n + (size_t)i;
  return (1 - m->part) * value[0] + m->part * value[FIELDS * n];
}

static struct moment moment_of(const struct two_blasts *b, double time) {
  const double at = b->end > 0 ? KITH_MIN(time / b->end, 1.0) * KEPT : 0;
  const int early = KITH_MIN((int)at, KEPT - 1);
  return (struct moment){b, early, at - early};
}

/* The cell that holds x; outside of the walls the one beside them. */
static int cell_of(const struct moment *m, double x) {
  int low = 0, high = m->b->n;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    if (face_at(m, middle) <= x)
      low = middle;
    else
      high = middle;
  }
  return low;
}

static void blasts_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct two_blasts *b = self;
  const struct moment m = moment_of(b, time);
  const int i = cell_of(&m, x[0]), l = KITH_MAX(i - 1, 0), r = KITH_MIN(i + 1, b->n - 1);
  const double lower = face_at(&m, i), upper = face_at(&m, i + 1);
  const double s = KITH_MIN(KITH_MAX((x[0] - lower) / (upper - lower), 0.0), 1.0) - 0.5;
  double value[FIELDS];
  for (int q = 0; q < FIELDS; ++q) {
    const double own = value_at(&m, q, i);
    value[q] = own + s * kith_lagrange_slope(value_at(&m, q, l), own, value_at(&m, q, r));
  }
  *out = (struct kith_exact_state){.density = 1 / value[0], .velocity = {value[1]}, .pressure = value[2]};
  out->energy = kith_exact_energy(b->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_two_blasts = {
    .name = "two-blasts",
    .doc = "two blasts that meet between walls; a reference of our own finite volumes",
    KITH_SETTINGS(params, settings),
    .derive = derive,
    .create = blasts_create,
    .destroy = blasts_destroy,
    .state = blasts_state,
};
