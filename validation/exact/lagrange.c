/* Finite volumes in the mass coordinate: slopes, faces, update, start. */
#include <math.h>
#include "validation/exact/lagrange.h"

static const double courant = 0.4;
enum { ITERATIONS = 2 };

static void slopes(struct kith_lagrange *f) {
  struct kith_cell *first = f->cell, *last = f->cell + f->n - 1;
  for (struct kith_cell *c = first; c <= last; ++c) {
    const struct kith_cell *l = c > first ? c - 1 : c, *r = c < last ? c + 1 : c;
    /* At a wall the velocity goes on to that of the mirror image; the rest has no slope there. */
    const double before = c > first ? l->velocity : -c->velocity,
                 behind = c < last ? r->velocity : -c->velocity;
    c->impedance = sqrt(f->gamma * c->pressure / c->volume);
    c->slope_v = kith_lagrange_slope(l->volume, c->volume, r->volume);
    c->slope_u = kith_lagrange_slope(before, c->velocity, behind);
    c->slope_p = kith_lagrange_slope(l->pressure, c->pressure, r->pressure);
  }
}

/* A cell at its upper (side 1) or lower (-1) face, half a step later; the plain cell where that would be no
 * gas. */
struct gas {
  double v, u, p;
};

static struct gas at_face(const struct kith_cell *c, double dt, double side) {
  const double half = 0.5 * dt / c->mass, c2 = c->impedance * c->impedance;
  const struct gas g = {c->volume + 0.5 * side * c->slope_v + half * c->slope_u,
                        c->velocity + 0.5 * side * c->slope_u - half * c->slope_p,
                        c->pressure + 0.5 * side * c->slope_p - half * c2 * c->slope_u};
  return g.v > 0 && g.p > 0 ? g : (struct gas){c->volume, c->velocity, c->pressure};
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
static void star(const struct gas *l, const struct gas *r, double gamma, struct kith_cell *face) {
  const double a = sqrt(gamma * l->p / l->v), b = sqrt(gamma * r->p / r->v);
  const double floor = 1e-12 * KITH_MIN(l->p, r->p);
  double q = KITH_MAX((b * l->p + a * r->p + a * b * (l->u - r->u)) / (a + b), floor), left, right;
  for (int k = 0; k < ITERATIONS; ++k) {
    const double miss = l->u - r->u - jump(l, gamma, q, &left) - jump(r, gamma, q, &right);
    q = KITH_MAX(q + miss / (left + right), floor);
  }
  face->face_p = q;
  face->face_u = 0.5 * (l->u + r->u - jump(l, gamma, q, &left) + jump(r, gamma, q, &right));
}

static void fluxes(struct kith_lagrange *f, double dt) {
  struct kith_cell *cell = f->cell;
  for (int i = 0; i <= f->n; ++i) { /* behind the walls is the mirror image */
    const bool lower = i == 0, upper = i == f->n;
    struct gas l = at_face(&cell[lower ? 0 : i - 1], dt, lower ? -1 : 1);
    struct gas r = at_face(&cell[upper ? i - 1 : i], dt, upper ? 1 : -1);
    if (lower) l.u = -l.u;
    if (upper) r.u = -r.u;
    star(&l, &r, f->gamma, &cell[i]);
  }
  cell[0].face_u = cell[f->n].face_u = 0;
}

static kith_status update(struct kith_lagrange *f, double dt) {
  double worst = 1;
  for (struct kith_cell *c = f->cell; c < f->cell + f->n; ++c) {
    const double a = dt / c->mass;
    c->face += dt * c->face_u;
    c->volume += a * (c[1].face_u - c->face_u);
    c->velocity -= a * (c[1].face_p - c->face_p);
    c->energy -= a * (c[1].face_p * c[1].face_u - c->face_p * c->face_u);
    c->pressure = (f->gamma - 1) * (c->energy - 0.5 * c->velocity * c->velocity) / c->volume;
    worst = KITH_MIN(worst, KITH_MIN(c->volume, c->pressure));
  }
  if (!(worst > 0)) KITH_FAIL(DIVERGED, "reference solution: no gas left in a cell at time %g", f->time);
  return KITH_OK;
}

kith_status kith_lagrange_run(struct kith_lagrange *f, double time) {
  while (f->time < time) {
    slopes(f);
    double rate = 0;
    for (int i = 0; i < f->n; ++i) rate = KITH_MAX(rate, f->cell[i].impedance / f->cell[i].mass);
    const double left = time - f->time, dt = KITH_MIN(courant / rate, left);
    fluxes(f, dt);
    KITH_TRY(update(f, dt));
    f->time = dt < left ? f->time + dt : time;
  }
  return KITH_OK;
}

/* ---- start ---- */

/* Where slab k of n ends. */
static double end_of(int n, const struct kith_slab *slab, double end, int k) {
  return k + 1 < n ? slab[k + 1].from : end;
}

kith_status kith_lagrange_create(struct kith_lagrange **out, double gamma, int n_slabs,
                                 const struct kith_slab *slab, double end, int cells) {
  double total = 0;
  *out = NULL;
  for (int k = 0; k < n_slabs; ++k) total += slab[k].density * (end_of(n_slabs, slab, end, k) - slab[k].from);
  /* Each slab may have half a cell more than its share, or one instead of none. */
  const size_t most = (size_t)cells + (size_t)n_slabs + 1;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + most * sizeof *(*out)->cell));
  struct kith_lagrange *f = *out;
  f->gamma = gamma;
  for (int k = 0; k < n_slabs; ++k) {
    const struct kith_slab *s = &slab[k];
    const double length = end_of(n_slabs, slab, end, k) - s->from;
    const int count = KITH_MAX(1, (int)lround(cells * (s->density * length) / total));
    for (int i = 0; i < count; ++i)
      f->cell[f->n++] = (struct kith_cell){
          .face = s->from + i * (length / count),
          .mass = s->density * (length / count),
          .volume = 1 / s->density,
          .velocity = s->velocity,
          .pressure = s->pressure,
          .energy = s->pressure / s->density / (gamma - 1) + 0.5 * s->velocity * s->velocity};
  }
  f->cell[f->n].face = end;
  return KITH_OK;
}
