/* Two problems without an exact solution.
 *
 * two-blasts: gas of density 1 at rest between walls at x = 0 and 1, pressure 1000 up to 0.1, 100 beyond 0.9
 * and 0.01 in between (Woodward and Colella, J. Comput. Phys. 54 (1984) 115); of interest is time 0.038.
 *
 * shu-osher: a shock of Mach number 3 runs from x = -4 into gas of density 1 + sin(5 x) / 5 and pressure 1 up
 * to 5, where there is a wall, which it does not reach by time 1.8 (Shu and Osher, J. Comput. Phys. 83 (1989)
 * 32). The gas behind it began at -12, and has left the wall there.
 *
 * This is what our own solver of Euler's equations in one dimension finds. Finite volumes in the coordinate m
 * of mass, so that contacts stay what they are at the start, faces between cells:
 *
 *   dv/dt = du/dm,   du/dt = -dp/dm,   de/dt = -d(pu)/dm,   v = 1 / density, e = energy + u^2 / 2
 *
 * B. van Leer, J. Comput. Phys. 32 (1979) 101, made simple: limited slopes of v, u, p; states of the faces
 * predicted for the middle of the step along them; at each face a Riemann problem between two gases, by
 * Newton's iterations in which both waves are jumps.
 *
 * States are kept at equal times from 0 to `end_time`, and interpolated between these with the gas: contacts
 * stay sharp; later times have the last one. Two blasts have 800 cells: density is good to 1 %, places of
 * shocks and contacts to 0.001, but for two or three cells beside each contact; half a second to create. Shu
 * and Osher's have 2000: the L1 of the density from x = -2.5 to 2.8 is good to 0.005 (first order: 1000
 * differ by 0.0068 from 6000, 2000 by 0.0032); most of a second. */
#include "validation/exact/exact_parameters.h"

#include <string.h>

enum { KEPT = 40, ITERATIONS = 2, MOST_STEPS = 100000, FIRST_STEPS = 1000 };
static const double courant = 0.4;

/* Specific volume, velocity and pressure, or their differences across a cell. */
struct gas {
  double v, u, p;
};

/* A cell and its lower face. */
struct cell {
  double face, mass; /* place of the face; mass of the cell */
  struct gas gas;
  double energy; /* per unit mass, with the kinetic one */
  /* During a step: slopes, mass flow of a sound wave; velocity and pressure of the lower face. */
  struct gas slope;
  double impedance, face_u, face_p;
};

struct flow {
  double gamma, time;
  int n, steps;       /* cells; steps that were taken */
  struct cell cell[]; /* [n + 1]: the last one is only the upper face of the one before */
};

/* Uniform gas, at rest or moving, from `from` to the next slab's `from`. */
struct slab {
  double from, density, velocity, pressure;
};

/* The limited slope of b, per cell, between its neighbors a and c. */
static double limited(double a, double b, double c) {
  const double left = b - a, right = c - b, center = 0.5 * (c - a);
  const double least = KITH_MIN(2 * fabs(left), 2 * fabs(right));
  return left * right <= 0 ? 0 : copysign(KITH_MIN(least, fabs(center)), center);
}

static struct gas slope_of(const struct gas *a, const struct gas *b, const struct gas *c) {
  return (struct gas){limited(a->v, b->v, c->v), limited(a->u, b->u, c->u), limited(a->p, b->p, c->p)};
}

static void slopes(struct flow *f) {
  struct cell *first = f->cell, *last = f->cell + f->n - 1;
  for (struct cell *c = first; c <= last; ++c) { /* walls show mirror images */
    struct gas before = c > first ? c[-1].gas : c->gas, behind = c < last ? c[1].gas : c->gas;
    if (c == first) before.u = -before.u;
    if (c == last) behind.u = -behind.u;
    c->impedance = sqrt(f->gamma * c->gas.p / c->gas.v);
    c->slope = slope_of(&before, &c->gas, &behind);
  }
}

/* State at the upper (1) or lower (-1) face half a step later; that of the cell where it would be no gas. */
static struct gas at_face(const struct cell *c, double dt, double side) {
  const double half = 0.5 * dt / c->mass, c2 = c->impedance * c->impedance;
  const struct gas g = {c->gas.v + 0.5 * side * c->slope.v + half * c->slope.u,
                        c->gas.u + 0.5 * side * c->slope.u - half * c->slope.p,
                        c->gas.p + 0.5 * side * c->slope.p - half * c2 * c->slope.u};
  return g.v > 0 && g.p > 0 ? g : c->gas;
}

/* The change of velocity through the wave from g to pressure p, and its derivative. */
static double jump(const struct gas *g, double gamma, double p, double *slope) {
  const double w2 = 0.5 / g->v * ((gamma + 1) * p + (gamma - 1) * g->p);
  const double w = sqrt(w2); /* mass flow through it */
  *slope = (1 - (p - g->p) * (gamma + 1) / (4 * g->v * w2)) / w;
  return (p - g->p) / w;
}

/* Finds pressure and velocity of a face by Newton's method, from the pressure between two sound waves: the
 * jumps are concave in p. */
static void star(const struct gas *l, const struct gas *r, double gamma, struct cell *face) {
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

static void fluxes(struct flow *f, double dt) {
  struct cell *cell = f->cell;
  for (int i = 0; i <= f->n; ++i) {
    const bool lower = i == 0, upper = i == f->n;
    struct gas l = at_face(&cell[lower ? 0 : i - 1], dt, lower ? -1 : 1);
    struct gas r = at_face(&cell[upper ? i - 1 : i], dt, upper ? 1 : -1);
    if (lower) l.u = -l.u;
    if (upper) r.u = -r.u;
    star(&l, &r, f->gamma, &cell[i]);
  }
  cell[0].face_u = cell[f->n].face_u = 0;
}

static kith_status update(struct flow *f, double dt) {
  double worst = 1;
  for (struct cell *c = f->cell; c < f->cell + f->n; ++c) {
    const double a = dt / c->mass;
    c->face += dt * c->face_u;
    c->gas.v += a * (c[1].face_u - c->face_u);
    c->gas.u -= a * (c[1].face_p - c->face_p);
    c->energy -= a * (c[1].face_p * c[1].face_u - c->face_p * c->face_u);
    c->gas.p = (f->gamma - 1) * (c->energy - 0.5 * c->gas.u * c->gas.u) / c->gas.v;
    worst = KITH_MIN(worst, KITH_MIN(c->gas.v, c->gas.p));
  }
  if (!(worst > 0)) KITH_FAIL(DIVERGED, "reference solution: no gas left in a cell at time %g", f->time);
  return KITH_OK;
}

/* Advances to `time`. DIVERGED if a volume or a pressure is not positive. BAD_INPUT after too many steps, or
 * soon if steps like the first ones would be by far too many until `end`. */
static kith_status run(struct flow *f, double time, double end) {
  while (f->time < time) {
    slopes(f);
    double rate = 0;
    for (int i = 0; i < f->n; ++i) rate = KITH_MAX(rate, f->cell[i].impedance / f->cell[i].mass);
    const bool hopeless = f->steps == FIRST_STEPS && FIRST_STEPS * end > 1.5 * MOST_STEPS * f->time;
    if (hopeless || ++f->steps > MOST_STEPS)
      KITH_FAIL(BAD_INPUT, "end_time: the reference solution takes more than %d steps until %g", MOST_STEPS,
                end);
    const double left = time - f->time, dt = KITH_MIN(courant / rate, left);
    fluxes(f, dt);
    KITH_TRY(update(f, dt));
    f->time = dt < left ? f->time + dt : time;
  }
  return KITH_OK;
}

/* Makes cells of about the same mass, whole ones in each slab, the last of which ends at `end`. */
static kith_status lay_out(struct flow **out, double gamma, int n_slabs, const struct slab *slab, double end,
                           int cells) {
  double total = 0;
  *out = NULL;
  for (int k = 0; k < n_slabs; ++k)
    total += slab[k].density * ((k + 1 < n_slabs ? slab[k + 1].from : end) - slab[k].from);
  /* Each slab may have half a cell more than its share, or one instead of none. */
  const size_t most = (size_t)cells + (size_t)n_slabs + 1;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + most * sizeof *(*out)->cell));
  struct flow *f = *out;
  f->gamma = gamma;
  for (const struct slab *s = slab; s < slab + n_slabs; ++s) {
    const double length = (s + 1 < slab + n_slabs ? s[1].from : end) - s->from;
    const int count = KITH_MAX(1, (int)lround(cells * (s->density * length) / total));
    for (int i = 0; i < count; ++i)
      f->cell[f->n++] =
          (struct cell){.face = s->from + i * (length / count),
                        .mass = s->density * (length / count),
                        .gas = {1 / s->density, s->velocity, s->pressure},
                        .energy = s->pressure / s->density / (gamma - 1) + 0.5 * s->velocity * s->velocity};
  }
  f->cell[f->n].face = end;
  return KITH_OK;
}

struct settings {
  struct kith_exact_gas gas; /* gamma alone */
  double end_time;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    {"end_time", KITH_PARAM_NUMBER, NULL, "[0, inf)", "time until which it is computed",
     KITH_INTO(struct settings, end_time)},
    {0}};

static void derive(void *settings, const struct kith_exact_scene *scene) {
  kith_exact_derive_gas(settings, scene);
  ((struct settings *)settings)->end_time = scene->until;
}

struct kept_flow {
  struct settings settings;
  int n;              /* cells */
  struct cell cell[]; /* [KEPT + 1][n + 1] */
};

static kith_status keep(void **self, const struct settings *p, int n_slabs, const struct slab *slabs,
                        double end, int cells) {
  struct flow *flow = NULL;
  KITH_TRY(lay_out(&flow, p->gas.gamma, n_slabs, slabs, end, cells));
  const size_t row = ((size_t)flow->n + 1) * sizeof *flow->cell;
  kith_status status = kith_resize(self, 0, 1, sizeof(struct kept_flow) + (KEPT + 1) * row);
  struct kept_flow *b = *self;
  if (status == KITH_OK) b->settings = *p, b->n = flow->n;
  for (int k = 0; status == KITH_OK && k <= KEPT; ++k) {
    status = run(flow, k < KEPT ? p->end_time * k / KEPT : p->end_time, p->end_time);
    memcpy(b->cell + (size_t)k * ((size_t)b->n + 1), flow->cell, row);
  }
  kith_free(&flow);
  if (status != KITH_OK) kith_free(self);
  return status;
}

static kith_status create_two_blasts(void **self, const void *settings) {
  static const struct slab slabs[] = {{0, 1, 0, 1000}, {0.1, 1, 0, 0.01}, {0.9, 1, 0, 100}};
  return keep(self, settings, 3, slabs, 1, 800);
}

static kith_status create_shu_osher(void **self, const void *settings) {
  enum { WAVES = 1000 };
  struct slab slabs[1 + WAVES] = {{-12, 3.857143, 2.629369, 10.333333}};
  for (int k = 0; k < WAVES; ++k)
    slabs[1 + k] = (struct slab){-4 + 9.0 * k / WAVES, 1 + 0.2 * sin(5 * (-4 + 9 * (k + 0.5) / WAVES)), 0, 1};
  return keep(self, settings, 1 + WAVES, slabs, 5, 2000);
}

/* Cell i, interpolated between two kept times; `at`: time in units of their distance. */
static struct cell cell_at(const struct kept_flow *b, double at, int i) {
  const int k = KITH_MIN((int)at, KEPT - 1);
  const double part = at - k;
  const struct cell *early = b->cell + (size_t)k * ((size_t)b->n + 1) + i, *late = early + b->n + 1;
#define BETWEEN(member) ((1 - part) * early->member + part * late->member)
  return (struct cell){.face = BETWEEN(face), .gas = {BETWEEN(gas.v), BETWEEN(gas.u), BETWEEN(gas.p)}};
#undef BETWEEN
}

static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct kept_flow *b = self;
  const double end = b->settings.end_time, at = end > 0 ? KITH_MIN(time / end, 1.0) * KEPT : 0;
  int i = 0, high = b->n; /* the cell that holds x; outside of the walls the one beside them */
  while (high - i > 1) {
    const int middle = (i + high) / 2;
    *(cell_at(b, at, middle).face <= x[0] ? &i : &high) = middle;
  }
  const struct cell left = cell_at(b, at, KITH_MAX(i - 1, 0)), cell = cell_at(b, at, i);
  const struct cell next = cell_at(b, at, i + 1), right = i + 1 < b->n ? next : cell;
  const struct gas gas = cell.gas, slope = slope_of(&left.gas, &gas, &right.gas);
  const double s = KITH_MIN(KITH_MAX((x[0] - cell.face) / (next.face - cell.face), 0.0), 1.0) - 0.5;
  *out = kith_exact_moving(&b->settings.gas, 1 / (gas.v + s * slope.v), gas.p + s * slope.p);
  out->velocity[0] = gas.u + s * slope.u;
}

const struct kith_exact_ops kith_exact_two_blasts = {
    .name = "two-blasts",
    .doc = "two blasts that meet between walls; a reference of our own finite volumes",
    KITH_SETTINGS(params, settings),
    .derive = derive,
    .create = create_two_blasts,
    .state = state,
};

const struct kith_exact_ops kith_exact_shu_osher = {
    .name = "shu-osher",
    .doc = "a shock that runs into waves of density; a reference of our own finite volumes",
    KITH_SETTINGS(params, settings),
    .derive = derive,
    .create = create_shu_osher,
    .state = state,
};
