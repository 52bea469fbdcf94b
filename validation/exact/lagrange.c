/* Finite volumes in the mass coordinate: slopes, faces, update, start. */
#include <math.h>
#include "validation/exact/lagrange.h"

static const double courant = 0.4;
enum { ITERATIONS = 2, ARRAYS = 6 };

/* The arrays of a step, each with room for a ghost cell at both ends: value[-1 .. n]. */
struct step {
  double *slope_v, *slope_u, *slope_p; /* per cell */
  double *impedance;                   /* density times sound speed */
  double *u, *p;                       /* of the faces: [0 .. n] */
  double dt;
};

static struct step step_of(const struct kith_lagrange *f) {
  double *array[ARRAYS];
  for (int k = 0; k < ARRAYS; ++k) array[k] = f->work + (size_t)k * (f->n + 2) + 1;
  return (struct step){array[0], array[1], array[2], array[3], array[4], array[5], 0};
}

static void slopes(const struct kith_lagrange *f, const struct step *s) {
  const int last = f->n - 1;
  for (int i = 0; i < f->n; ++i) {
    const int l = KITH_MAX(i - 1, 0), r = KITH_MIN(i + 1, last);
    s->impedance[i] = sqrt(f->gamma * f->pressure[i] / f->volume[i]);
    s->slope_v[i] = kith_lagrange_slope(f->volume[l], f->volume[i], f->volume[r]);
    s->slope_u[i] = kith_lagrange_slope(f->velocity[l], f->velocity[i], f->velocity[r]);
    s->slope_p[i] = kith_lagrange_slope(f->pressure[l], f->pressure[i], f->pressure[r]);
  }
  /* At a wall the velocity goes on to that of the mirror image; the rest has no slope there. */
  s->slope_u[0] = kith_lagrange_slope(-f->velocity[0], f->velocity[0], f->velocity[KITH_MIN(1, last)]);
  s->slope_u[last] =
      kith_lagrange_slope(f->velocity[KITH_MAX(last - 1, 0)], f->velocity[last], -f->velocity[last]);
}

/* Of cell i at its upper (side 1) or lower (-1) face, half a step later; the plain cell where that would be
 * no gas. */
struct gas {
  double v, u, p;
};

static struct gas at_face(const struct kith_lagrange *f, const struct step *s, int i, double side) {
  const double half = 0.5 * s->dt / f->mass[i], c2 = s->impedance[i] * s->impedance[i];
  const struct gas g = {f->volume[i] + 0.5 * side * s->slope_v[i] + half * s->slope_u[i],
                        f->velocity[i] + 0.5 * side * s->slope_u[i] - half * s->slope_p[i],
                        f->pressure[i] + 0.5 * side * s->slope_p[i] - half * c2 * s->slope_u[i]};
  if (g.v > 0 && g.p > 0) return g;
  return (struct gas){f->volume[i], f->velocity[i], f->pressure[i]};
}

/* How much the velocity changes through the wave that leads from g to the pressure p, and by how much more
 * per pressure. */
static double jump(const struct gas *g, double gamma, double p, double *slope) {
  const double w2 = 0.5 / g->v * ((gamma + 1) * p + (gamma - 1) * g->p),
               w = sqrt(w2); /* mass flow through it */
  *slope = (1 - (p - g->p) * (gamma + 1) / (4 * g->v * w2)) / w;
  return (p - g->p) / w;
}

/* Newton's method from the pressure between two sound waves: the sum of the jumps rises and is concave in
 * p. */
static void star(const struct gas *l, const struct gas *r, double gamma, double *u, double *p) {
  const double a = sqrt(gamma * l->p / l->v), b = sqrt(gamma * r->p / r->v);
  const double floor = 1e-12 * KITH_MIN(l->p, r->p);
  double q = KITH_MAX((b * l->p + a * r->p + a * b * (l->u - r->u)) / (a + b), floor), left, right;
  for (int k = 0; k < ITERATIONS; ++k) {
    const double miss = l->u - r->u - jump(l, gamma, q, &left) - jump(r, gamma, q, &right);
    q = KITH_MAX(q + miss / (left + right), floor);
  }
  *p = q;
  *u = 0.5 * (l->u + r->u - jump(l, gamma, q, &left) + jump(r, gamma, q, &right));
}

static void fluxes(const struct kith_lagrange *f, const struct step *s) {
  const int n = f->n;
  for (int i = 1; i < n; ++i) {
    const struct gas l = at_face(f, s, i - 1, 1), r = at_face(f, s, i, -1);
    star(&l, &r, f->gamma, &s->u[i], &s->p[i]);
  }
  const struct gas first = at_face(f, s, 0, -1), last = at_face(f, s, n - 1, 1);
  const struct gas before = {first.v, -first.u, first.p}, behind = {last.v, -last.u, last.p};
  star(&before, &first, f->gamma, &s->u[0], &s->p[0]);
  star(&last, &behind, f->gamma, &s->u[n], &s->p[n]);
  s->u[0] = s->u[n] = 0;
}

static kith_status update(struct kith_lagrange *f, const struct step *s) {
  double worst = 1;
  for (int i = 0; i <= f->n; ++i) f->face[i] += s->dt * s->u[i];
  for (int i = 0; i < f->n; ++i) {
    const double a = s->dt / f->mass[i];
    f->volume[i] += a * (s->u[i + 1] - s->u[i]);
    f->velocity[i] -= a * (s->p[i + 1] - s->p[i]);
    f->energy[i] -= a * (s->p[i + 1] * s->u[i + 1] - s->p[i] * s->u[i]);
    f->pressure[i] = (f->gamma - 1) * (f->energy[i] - 0.5 * f->velocity[i] * f->velocity[i]) / f->volume[i];
    worst = KITH_MIN(worst, KITH_MIN(f->volume[i], f->pressure[i]));
  }
  if (!(worst > 0)) KITH_FAIL(DIVERGED, "reference solution: no gas left in a cell at time %g", f->time);
  return KITH_OK;
}

kith_status kith_lagrange_run(struct kith_lagrange *f, double time) {
  struct step s = step_of(f);
  while (f->time < time) {
    slopes(f, &s);
    double rate = 0;
    for (int i = 0; i < f->n; ++i) rate = KITH_MAX(rate, s.impedance[i] / f->mass[i]);
    const double left = time - f->time;
    s.dt = KITH_MIN(courant / rate, left);
    fluxes(f, &s);
    KITH_TRY(update(f, &s));
    f->time = s.dt < left ? f->time + s.dt : time;
  }
  return KITH_OK;
}

/* ---- start ---- */

static void fill(struct kith_lagrange *f, const struct kith_slab *slab, double end, int first, int count) {
  const double width = (end - slab->from) / count;
  for (int i = first; i < first + count; ++i) {
    f->face[i] = slab->from + (i - first) * width;
    f->face[i + 1] = i + 1 < first + count ? f->face[i] + width : end;
    f->mass[i] = slab->density * width;
    f->volume[i] = 1 / slab->density;
    f->velocity[i] = slab->velocity;
    f->pressure[i] = slab->pressure;
    f->energy[i] = slab->pressure / slab->density / (f->gamma - 1) + 0.5 * slab->velocity * slab->velocity;
  }
}

static kith_status make_room(struct kith_lagrange *f) {
  const size_t n = (size_t)f->n;
  double **const array[] = {&f->mass, &f->volume, &f->velocity, &f->energy, &f->pressure};
  KITH_TRY(kith_resize(&f->face, 0, n + 1, sizeof(double)));
  for (size_t k = 0; k < sizeof array / sizeof array[0]; ++k)
    KITH_TRY(kith_resize(array[k], 0, n, sizeof(double)));
  return kith_resize(&f->work, 0, ARRAYS * (n + 2), sizeof(double));
}

/* Cells of slab k: its share by mass, at least one. */
static int share(int n_slabs, const struct kith_slab *slab, double end, int cells, int k) {
  double total = 0, own = 0;
  for (int j = 0; j < n_slabs; ++j) {
    const double mass = slab[j].density * ((j + 1 < n_slabs ? slab[j + 1].from : end) - slab[j].from);
    total += mass;
    if (j == k) own = mass;
  }
  return KITH_MAX(1, (int)lround(cells * own / total));
}

kith_status kith_lagrange_create(struct kith_lagrange **out, double gamma, int n_slabs,
                                 const struct kith_slab *slab, double end, int cells) {
  *out = NULL;
  struct kith_lagrange *f = NULL;
  KITH_TRY(kith_resize(&f, 0, 1, sizeof *f));
  f->gamma = gamma;
  for (int k = 0; k < n_slabs; ++k) f->n += share(n_slabs, slab, end, cells, k);
  kith_status status = make_room(f);
  for (int k = 0, first = 0; status == KITH_OK && k < n_slabs; ++k) {
    const int count = share(n_slabs, slab, end, cells, k);
    fill(f, &slab[k], k + 1 < n_slabs ? slab[k + 1].from : end, first, count);
    first += count;
  }
  if (status != KITH_OK) kith_lagrange_destroy(&f);
  *out = f;
  return status;
}

void kith_lagrange_destroy(struct kith_lagrange **flow) {
  struct kith_lagrange *f = *flow;
  if (f == NULL) return;
  double **const array[] = {&f->face, &f->mass, &f->volume, &f->velocity, &f->energy, &f->pressure, &f->work};
  for (size_t k = 0; k < sizeof array / sizeof array[0]; ++k) kith_free(array[k]);
  kith_free(flow);
}
