/* sph_world.h - for tests of packages: a "world" of up to 160 nodes of three materials, and the oracle
 * ("truth"), which evaluates the equations of package sph directly: slow sums over every node with every
 * image of every node, enumerated here. It uses no search, rows, ghosts or kernels of the library.
 *
 *   n_i = sum_j W(r_ij, H_i), ball H_i^d n_i = neighbors, rho_i = sum_j m_j W(r_ij, H_i), where the node
 *   itself has its self weight; if nodes move and H follows, drho_i = sum_j (m_j - X_i) dW_ij, where
 *   X = (H / (d n)) drho/dH / Omega, Omega = 1 + (H / (d n)) dn/dH */
#ifndef KITH_TEST_PHYSICS_SPH_WORLD_H
#define KITH_TEST_PHYSICS_SPH_WORLD_H

#include <stdlib.h>
#include <string.h>
#include "integrator/lifecycle.h"
#include "integrator/step.h"
#include "physics/passes/viscosity.h"
#include "tests/unit/physics/kernel_oracle.h"
#include "tests/check.h"
#include "tests/unit/materials.h"

enum side { OPEN, PERIODIC, REFLECTING };
enum { MOST = 160 };

struct method {
  enum kith_kernel kernel;
  enum kith_viscosity viscosity;
  enum kith_traversal traversal;
  bool compatible;
  double alpha, beta;
  enum kith_balsara balsara;
};

struct world {
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
  struct kith_package package;
  void *settings;                           /* settings of the package */
  struct kith_viscosity_settings viscosity; /* those of `settings`; coefficients are 0 without viscosity */
  struct kith_boundaries boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  struct kith_rebuilds rebuilds;
  struct kith_integrator it;
  enum side side;
  double length[NDIM]; /* the box is from 0 to length */
  struct oracle_kernel kernel;
};

/* ---- the world ---- */

static inline void world_destroy(struct world *w) {
  kith_integrator_clear(&w->it);
  kith_package_clear(&w->package);
  kith_free(&w->settings);
  kith_boundaries_clear(&w->boundaries);
  kith_rebuilds_clear(&w->rebuilds);
  kith_connectivity_destroy(&w->connectivity);
  kith_search_destroy(&w->search);
  kith_nodes_destroy(&w->nodes);
}

/* Replaces the package of the world by `name`, with "key=value" settings. */
static inline void world_package(struct world *w, const char *name, const struct method *m,
                                 const char *assignments) {
  kith_package_clear(&w->package);
  kith_free(&w->settings);
  CHECK_OK(kith_settings_create(&w->settings, kith_family_member(kith_package_member, name), assignments));
  w->package =
      (struct kith_package){.ops = kith_package_find(name),
                            .hydro = &w->hydro,
                            .kernel = m->kernel,
                            .neighbors = kith_kernel_neighbors(m->kernel, kith_package_find(name)->spacings),
                            .compatible = m->compatible,
                            .settings = w->settings,
                            .traversal = m->traversal};
  CHECK_OK(kith_package_init(&w->package));
}

/* Does so for a package with viscosity, whose settings come from the method. */
static inline void world_viscous(struct world *w, const char *name, const struct method *m) {
  static const char *const names[] = {
#define X(constant, word, doc) #word,
      KITH_VISCOSITY_LIST(X)
#undef X
  };
  static const char *const factors[] = {
#define X(constant, word) #word,
      KITH_BALSARA_LIST(X)
#undef X
  };
  const bool none = m->viscosity == KITH_VISCOSITY_NONE;
  char text[200];
  w->viscosity =
      (struct kith_viscosity_settings){m->viscosity, none ? 0 : m->alpha, none ? 0 : m->beta, m->balsara};
  snprintf(text, sizeof text,
           "viscosity.name=%s viscosity.alpha=%.17g viscosity.beta=%.17g viscosity.balsara=%s",
           names[m->viscosity], m->alpha, m->beta, none ? "none" : factors[m->balsara]);
  world_package(w, name, m, text);
}

static inline void world_objects(struct world *w, const struct method *m) {
  const double none[NDIM] = {0};
  world_viscous(w, "sph", m);
  CHECK_OK(kith_rebuilds_create(&w->rebuilds, "always", none));
  CHECK_OK(kith_search_create(&w->search, kith_search_find("tree"), w->nodes));
  CHECK_OK(kith_connectivity_create(&w->connectivity));
  w->it = (struct kith_integrator){.nodes = w->nodes,
                                   .hydro = &w->hydro,
                                   .package = &w->package,
                                   .boundaries = &w->boundaries,
                                   .search = w->search,
                                   .connectivity = w->connectivity,
                                   .rebuilds = &w->rebuilds,
                                   .scheme = kith_scheme_find("leapfrog"),
                                   .cfl = 0.3,
                                   .skin = 0.05,
                                   .cull = true,
                                   .check = true};
  CHECK_OK(kith_integrator_init(&w->it));
  for (int a = 0; a < NDIM && w->side != OPEN; ++a)
    CHECK_OK(kith_boundaries_add(&w->boundaries,
                                 kith_boundary_find(w->side == PERIODIC ? "periodic" : "reflecting"), a, 0,
                                 w->length[a], true, true));
}

/* Creates cells[a] nodes along axis a, one in each unit cube, at most `jitter` off its center along each
 * axis; in three lists of different materials with `counts` nodes each; masses 1 to 8, energies 1 to 2,
 * velocities within 1. Lists and masses are spread over the box. */
static inline void world_create_lists(struct world *w, const int *cells, const int *counts, enum side side,
                                      double jitter, const struct method *m, uint64_t seed) {
  static const char *const names[] = {"gas", "cold", "water"};
  memset(w, 0, sizeof *w);
  w->side = side;
  w->kernel = oracle_kernel(m->kernel);
  CHECK_OK(kith_nodes_create(&w->nodes, 3, names));
  CHECK_OK(kith_hydro_init(&w->hydro, w->nodes));
  w->hydro.material[0] = material_of("ideal", "gamma=1.6666666666666667");
  w->hydro.material[1] = material_of("isothermal", "sound_speed=1.2");
  w->hydro.material[2] = material_of("stiffened", "gamma=2.5 stiffness=0.3");
  for (int a = 0; a < NDIM; ++a) w->length[a] = cells[a];
  for (int l = 0; l < 3; ++l) CHECK_OK(kith_nodes_append(w->nodes, l, counts[l], NULL));
  const int n = w->nodes->n_internal;
  for (int i = 0; i < n; ++i) {
    int cell = i * 7919 % n; /* 7919 is prime, so each cell is used once */
    for (int a = 0; a < NDIM; cell /= cells[a], ++a) {
      w->nodes->position->f64[i * NDIM + a] = cell % cells[a] + 0.5 + jitter * (2 * check_random(&seed) - 1);
      w->hydro.velocity->f64[i * NDIM + a] = 2 * check_random(&seed) - 1;
    }
    w->hydro.mass->f64[i] = pow(8, check_random(&seed));
    w->hydro.energy->f64[i] = 1 + check_random(&seed);
    w->nodes->support->f64[i] = 2;
    w->nodes->id->i64[i] = 100 + i;
  }
  world_objects(w, m);
}

static inline void world_create(struct world *w, const int *cells, enum side side, double jitter,
                                const struct method *m, uint64_t seed) {
  int n = 1;
  for (int a = 0; a < NDIM; ++a) n *= cells[a];
  const int counts[3] = {n / 3, (n + 1) / 3, (n + 2) / 3};
  world_create_lists(w, cells, counts, side, jitter, m, seed);
}

/* Rebuilds neighbor lists and evaluates rates, with the present supports and velocities. */
static inline kith_status world_evaluate(struct world *w) {
  w->nodes->positions += 1;
  CHECK_OK(kith_lifecycle(&w->it, KITH_BECAUSE_requested));
  return w->package.ops->evaluate(&w->package, w->connectivity, &w->it.kick);
}

static inline void world_base(struct world *w) {
  kith_field_copy(w->nodes, w->it.kick.velocity_base, w->hydro.velocity);
}

/* ---- the oracle ---- */

/* An image of `node`: its separation x = x_i - x_image, its distance, and the signs of its vector
 * components. */
struct partner {
  int node;
  bool itself; /* an image of i */
  double x[NDIM], r, sign[NDIM];
};

struct partners {
  size_t first[MOST + 1], capacity;
  struct partner *partner;
};

static inline double image_of(const struct world *w, int a, double x, int image) {
  const double moved = w->side == REFLECTING && image % 2 != 0 ? w->length[a] - x : x;
  return moved + image * w->length[a];
}

/* Lists all partners within `range` of every node. Uses the memory of `p` again; the caller frees
 * p->partner. */
static inline void partners_find(struct partners *p, const struct world *w, double range) {
  const double *x = w->nodes->position->f64;
  const int n = w->nodes->n_internal;
  int most[3] = {0};
  for (int a = 0; a < NDIM && w->side != OPEN; ++a) most[a] = (int)ceil(range / w->length[a]) + 1;
  size_t count = 0;
  for (int i = 0; i < n; ++i) {
    p->first[i] = count;
    for (int j = 0; j < n; ++j)
      for (int k0 = -most[0]; k0 <= most[0]; ++k0)
        for (int k1 = -most[1]; k1 <= most[1]; ++k1)
          for (int k2 = -most[2]; k2 <= most[2]; ++k2) {
            const int image[3] = {k0, k1, k2};
            struct partner one = {.node = j, .itself = i == j};
            double r2 = 0;
            for (int a = 0; a < NDIM; ++a) {
              one.x[a] = x[i * NDIM + a] - image_of(w, a, x[j * NDIM + a], image[a]);
              one.sign[a] = w->side == REFLECTING && image[a] % 2 != 0 ? -1 : 1;
              r2 += one.x[a] * one.x[a];
            }
            if (r2 > range * range || (i == j && k0 == 0 && k1 == 0 && k2 == 0)) continue;
            one.r = sqrt(r2);
            if (count == p->capacity) {
              p->capacity = 2 * p->capacity + 4096;
              p->partner = realloc(p->partner, p->capacity * sizeof *p->partner);
            }
            p->partner[count++] = one;
          }
  }
  p->first[n] = count;
}

/* What the equations yield for internal nodes. */
struct truth {
  double support[MOST], number[MOST], density[MOST], omega[MOST], grad_h_term[MOST], pressure[MOST],
      sound[MOST];
  double gradient[MOST][NDIM][NDIM], acceleration[MOST][NDIM], rate[MOST], correction[MOST], signal[MOST];
  double self; /* the self weight */
  struct partners partners;
};

/* What is left between i and a partner of a pressure: a tension grows from 0 at 6/7 of a mean spacing of the
 * denser end to all of it at one. */
static inline double truth_tension(const struct world *w, const struct truth *t, int i,
                                   const struct partner *p, double pressure) {
  const double support = fmin(t->support[i], t->support[p->node]),
               spacing = support / pow(w->package.neighbors / oracle_ball(), 1.0 / NDIM),
               part = 7 * p->r / spacing - 6;
  return pressure >= 0 ? pressure : pressure * fmax(0, fmin(1, part));
}

static inline double truth_sum(const struct world *w, const struct truth *t, int i, double support,
                               double *log_slope) {
  double sum = t->self * oracle_w(&w->kernel, 0), slope = 0;
  for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
    const double q = t->partners.partner[k].r / support;
    if (q >= 1) continue;
    sum += oracle_w(&w->kernel, q);
    slope -= q * q * oracle_g(&w->kernel, q);
  }
  *log_slope = slope; /* d sum / d ln H */
  return sum;
}

/* Finds the support to round-off, by Newton's method within a bracket; returns -1 if it is beyond `range`. */
static inline double truth_root(const struct world *w, const struct truth *t, int i, double range) {
  const double wanted = w->package.neighbors / (oracle_ball() * w->kernel.constant);
  double lower = 0, upper = range, slope, h = fmin(w->nodes->support->f64[i], range);
  if (truth_sum(w, t, i, range, &slope) < wanted) return -1;
  for (int k = 0; k < 200 && upper - lower > 1e-16 * upper; ++k) {
    const double miss = wanted - truth_sum(w, t, i, h, &slope);
    if (miss > 0)
      lower = h;
    else
      upper = h;
    if (slope > 0 && fabs(miss) < 1e-15 * wanted) break;
    const double next = h * (1 + miss / fmax(slope, 1e-300));
    h = next > lower && next < upper ? next : 0.5 * (lower + upper);
  }
  return h;
}

/* Computes supports from scratch, and all that follows from positions and masses. */
static inline void truth_density(const struct world *w, struct truth *t) {
  const int n = w->nodes->n_internal;
  const double *m = w->hydro.mass->f64;
  /* the mean density is one node per unit volume */
  double range = 1.2 * pow(w->package.neighbors / oracle_ball(), 1.0 / NDIM);
  t->self = (w->package.neighbors / (oracle_ball() * w->kernel.constant) -
             oracle_lattice_others(&w->kernel, pow(w->package.neighbors / oracle_ball(), 1.0 / NDIM))) /
            oracle_w(&w->kernel, 0);
  for (int i = 0; i < n;) {
    if (i == 0) partners_find(&t->partners, w, range);
    t->support[i] = truth_root(w, t, i, range);
    if (t->support[i] > 0)
      ++i;
    else
      range *= 1.3, i = 0;
  }
  for (int i = 0; i < n; ++i) {
    const double h = t->support[i], scale = w->kernel.constant / pow(h, NDIM);
    double sw = t->self * oracle_w(&w->kernel, 0), smw = m[i] * sw, dw = 0, dmw = 0; /* d: H d/dH of w */
    for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
      const struct partner *p = &t->partners.partner[k];
      const double q = p->r / h, wq = oracle_w(&w->kernel, q), d = -q * q * oracle_g(&w->kernel, q);
      sw += wq, smw += m[p->node] * wq, dw += d, dmw += m[p->node] * d;
    }
    t->number[i] = scale * sw;
    t->density[i] = scale * smw;
    const double dn = scale * (dw - NDIM * sw), drho = scale * (dmw - NDIM * smw); /* H d/dH */
    t->omega[i] = 1 + dn / (NDIM * t->number[i]);
    t->grad_h_term[i] = drho / (NDIM * t->number[i]) / t->omega[i];
  }
}

/* Pressure and sound speed, by the formulas that the headers of equations of state give. */
static inline void truth_close(const struct world *w, struct truth *t) {
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    const struct kith_material *m = &w->hydro.material[w->nodes->list->u8[i]];
    const double gamma = material_value(m, "gamma"), c0 = material_value(m, "sound_speed");
    const double rho = t->density[i], u = w->hydro.energy->f64[i], p0 = material_value(m, "stiffness");
    if (c0 > 0)
      t->pressure[i] = c0 * c0 * rho, t->sound[i] = c0;
    else
      t->pressure[i] = (gamma - 1) * rho * u - gamma * p0,
      t->sound[i] = sqrt(fmax(gamma * (t->pressure[i] + p0) / rho, 0));
  }
}

/* G = argmin of sum of -g(q) |v_j - v_i - G (x_j - x_i)|^2. */
static inline void truth_gradient(const struct world *w, struct truth *t) {
  const double *v = w->hydro.velocity->f64;
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double moment[NDIM][NDIM] = {{0}}, flux[NDIM][NDIM] = {{0}};
    for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
      const struct partner *p = &t->partners.partner[k];
      const double weight = -oracle_g(&w->kernel, p->r / t->support[i]);
      for (int a = 0; a < NDIM; ++a)
        for (int b = 0; b < NDIM; ++b) {
          moment[a][b] += weight * p->x[a] * p->x[b];
          flux[a][b] += weight * p->x[a] * (v[i * NDIM + b] - p->sign[b] * v[p->node * NDIM + b]);
        }
    }
    truth_solve(NDIM, moment, NDIM, flux);
    for (int a = 0; a < NDIM; ++a)
      for (int b = 0; b < NDIM; ++b) t->gradient[i][a][b] = flux[b][a];
  }
}

/* Projects the gradient of the partner's image: x . G x. */
static inline double truth_project(const double gradient[NDIM][NDIM], const double *sign, const double *x) {
  double sum = 0;
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) sum += x[a] * sign[a] * gradient[a][b] * sign[b] * x[b];
  return sum;
}

/* mu of equation (5): the velocity difference that the viscosity sees, over the distance; 0 unless the pair
 * approaches. */
static inline double truth_jump(const struct world *w, const struct truth *t, int i,
                                const struct partner *p) {
  const double *v = w->hydro.velocity->f64;
  const double one[3] = {1, 1, 1};
  double vx = 0;
  for (int a = 0; a < NDIM; ++a) vx += (v[i * NDIM + a] - p->sign[a] * v[p->node * NDIM + a]) * p->x[a];
  if (vx >= 0 || p->r == 0) return 0;
  if (w->viscosity.name == KITH_VISCOSITY_MONAGHAN) return vx / p->r;
  const double si = truth_project(t->gradient[i], one, p->x),
               sj = truth_project(t->gradient[p->node], p->sign, p->x);
  const double ratio = si / sj, van_leer = ratio > 0 ? 4 * ratio / ((1 + ratio) * (1 + ratio)) : 0;
  const double spacing =
      fmin(t->support[i], t->support[p->node]) / pow(w->package.neighbors / oracle_ball(), 1.0 / NDIM);
  const double close = p->r < spacing ? 5 * (1 - p->r / spacing) : 0,
               heat_jump = (t->sound[i] - t->sound[p->node]) / (t->sound[i] + t->sound[p->node]),
               rho = t->density[i], other = t->density[p->node], mass_jump = (rho - other) / (rho + other),
               pressed = fmin(fabs(mass_jump), fabs(mass_jump + 2 * heat_jump)),
               mach = 2 * vx / p->r / (t->sound[i] + t->sound[p->node]),
               front = fmax(5 * pow(heat_jump, 2), 4 * pow(pressed, 3) * fmin(1, mach * mach)),
               phi = close < 1 ? van_leer * (1 - close * close) / (1 + front) : 0;
  const double jump = vx - phi * (si + sj) / 2;
  return fmin(0, fmax(jump, vx)) / p->r;
}

/* Shear that changes along x, with a hundredth of the noise: Balsara's factor is small but where the shear
 * turns. */
static inline void world_shear(struct world *w) {
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double *v = w->hydro.velocity->f64 + i * NDIM;
    for (int a = 0; a < NDIM; ++a) v[a] *= 0.01;
    v[NDIM - 1] += NDIM > 1 ? sin(2 * M_PI * w->nodes->position->f64[i * NDIM] / w->length[0]) : 0;
  }
}

/* Balsara's factor of node i, or its square; 1 without, and in 1-D. */
static inline double truth_balsara(const struct world *w, const struct truth *t, int i) {
  const double e = 1e-3 * t->sound[i] * kith_kernel_support(w->package.kernel) / t->support[i];
  double divergence = 0, curl2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    divergence += t->gradient[i][a][a];
    for (int b = 0; b < a; ++b) curl2 += pow(t->gradient[i][a][b] - t->gradient[i][b][a], 2);
  }
  const double factor = (fabs(divergence) + e) / (fabs(divergence) + sqrt(curl2) + e);
  static const int power[] = {[KITH_BALSARA_SLOW] = 1, [KITH_BALSARA_FACTOR] = 1, [KITH_BALSARA_SQUARED] = 2};
  return NDIM == 1 ? 1 : pow(factor, power[w->viscosity.balsara]);
}

/* The viscous pressure over the density of two nodes. */
static inline double truth_viscous(const struct world *w, const struct truth *t, int i, int j, double mu) {
  const double c = (t->sound[i] + t->sound[j]) / 2, s = (truth_balsara(w, t, i) + truth_balsara(w, t, j)) / 2;
  const bool viscous = w->viscosity.name != KITH_VISCOSITY_NONE,
             both =
                 w->viscosity.balsara == KITH_BALSARA_FACTOR || w->viscosity.balsara == KITH_BALSARA_SQUARED;
  double square = mu * mu;
  if (both) square *= s;
  if (w->viscosity.balsara == KITH_BALSARA_SLOW && s < 0.05)
    square -= (1 - 20 * s) * fabs(mu) * fmin(fabs(mu), 0.05 * c); /* of slow differences only 20 s is left */
  return viscous ? w->viscosity.beta * square - s * w->viscosity.alpha * c * mu : 0;
}

/* Equation (1) of package.h, from the heat of node i per time and its acceleration. */
static inline void truth_energy(const struct world *w, struct truth *t, int i, double heat) {
  const double *v = w->hydro.velocity->f64, *base = w->it.kick.velocity_base->f64;
  t->rate[i] = heat / w->hydro.mass->f64[i], t->correction[i] = 0;
  for (int a = 0; a < NDIM; ++a)
    t->correction[i] -= t->acceleration[i][a] * (base[i * NDIM + a] - v[i * NDIM + a]);
}

/* Equations (3) to (5), and the signal speed for the time step. */
static inline void truth_rates(const struct world *w, struct truth *t) {
  const double *m = w->hydro.mass->f64, *v = w->hydro.velocity->f64;
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double force[NDIM] = {0}, work = 0, signal = t->sound[i];
    for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
      const struct partner *p = &t->partners.partner[k];
      const int j = p->node;
      const double hi = t->support[i], hj = t->support[j];
      if (p->r >= fmax(hi, hj) || p->r == 0) continue;
      const double gi = w->kernel.constant / pow(hi, NDIM + 2) * oracle_g(&w->kernel, p->r / hi);
      const double gj = w->kernel.constant / pow(hj, NDIM + 2) * oracle_g(&w->kernel, p->r / hj);
      const double mu = truth_jump(w, t, i, p), sound = (t->sound[i] + t->sound[j]) / 2,
                   rho = (t->density[i] + t->density[j]) / 2;
      const double pi = truth_viscous(w, t, i, j, mu) / rho;
      const double fi = m[i] * truth_tension(w, t, i, p, t->pressure[i]) / (t->density[i] * t->density[i]) *
                        (m[j] - t->grad_h_term[i]) * gi;
      const double fj = m[j] * truth_tension(w, t, i, p, t->pressure[j]) / (t->density[j] * t->density[j]) *
                        (m[i] - t->grad_h_term[j]) * gj;
      const double fq = m[i] * m[j] * pi * (gi + gj) / 2;
      signal = fmax(signal, fmax(1, (1 + 0.6 * w->viscosity.alpha) / 1.6) * sound - w->viscosity.beta * mu);
      for (int a = 0; a < NDIM; ++a) {
        force[a] -= (fi + fj + fq) * p->x[a];
        work += (fi + fq / 2) * p->x[a] * (v[i * NDIM + a] - p->sign[a] * v[j * NDIM + a]);
      }
    }
    for (int a = 0; a < NDIM; ++a) t->acceleration[i][a] = force[a] / m[i];
    truth_energy(w, t, i, work);
    /* light nodes beside heavy ones oscillate faster; the mean mass is density over number */
    const double beyond = fmax(0, t->grad_h_term[i] - m[i]) * t->number[i] / t->density[i];
    t->signal[i] = signal * sqrt(1 + 8 * beyond);
  }
}

/* Evaluates everything, from positions, masses, energies and velocities alone. Free it with truth_clear. */
static inline void truth_all(const struct world *w, struct truth *t) {
  truth_density(w, t);
  truth_close(w, t);
  truth_gradient(w, t);
  truth_rates(w, t);
}

static inline void truth_clear(struct truth *t) {
  free(t->partners.partner);
  memset(t, 0, sizeof *t);
}

/* Sets supports to their exact roots: then the package changes them by round-off only, and all sums can be
 * compared to round-off. */
static inline void world_root(struct world *w, const struct truth *t) {
  memcpy(w->nodes->support->f64, t->support, (size_t)w->nodes->n_internal * sizeof(double));
}

static inline double largest(const double *value, int n) {
  double most = 0;
  for (int k = 0; k < n; ++k) most = fmax(most, fabs(value[k]));
  return most;
}

/* Compares a field with the oracle; the tolerance is relative to the largest value. */
#define CHECK_FIELD(field, wanted, count, tolerance)                                                 \
  do {                                                                                               \
    const double scale_ = largest((wanted), (count));                                                \
    for (int k_ = 0; k_ < (count); ++k_) CHECK_CLOSE((field)[k_], (wanted)[k_], (tolerance)*scale_); \
  } while (0)

/* Compares the energy correction, which packages with compatible energies have. */
static inline void truth_check_kick(const struct world *w, const struct truth *t, double tolerance) {
  if (w->package.compatible)
    CHECK_FIELD(w->package.energy_correction->f64, t->correction, w->nodes->n_internal, tolerance);
}

/* Supports are roots, and kicks start from another velocity than forces see. */
static inline void world_prepare(struct world *w, struct truth *t, uint64_t *seed) {
  truth_density(w, t);
  world_root(w, t);
  for (int k = 0; k < w->nodes->n_internal * NDIM; ++k)
    w->it.kick.velocity_base->f64[k] = w->hydro.velocity->f64[k] + 0.3 * (check_random(seed) - 0.5);
}

/* Puts node 0 on a face, where its image coincides with it. */
static inline void world_touch_face(struct world *w) {
  for (int a = 0; a < NDIM; ++a) w->nodes->position->f64[a] = a == 0 ? 0 : 0.5 * w->length[a];
}

/* Boxes of worlds; the second one is thinner than most supports. */
static const int world_boxes[][3] = {{NDIM == 1 ? 14 : NDIM == 2 ? 7 : 5, NDIM == 2 ? 6 : 4, 4}, {3, 3, 3}};

/* Calls `check` for methods with every kernel, on all sides. */
static inline void worlds(void (*check)(const struct method *m, enum side side, const int *cells, int form,
                                        uint64_t seed)) {
  static const enum kith_viscosity viscosity[] = {KITH_VISCOSITY_MONAGHAN, KITH_VISCOSITY_LIMITED,
                                                  KITH_VISCOSITY_NONE, KITH_VISCOSITY_LIMITED};
  uint64_t seed = 1;
  for (int k = 0; k < KITH_N_KERNELS; ++k)
    for (int side = OPEN; side <= REFLECTING; ++side)
      for (int form = 0; form < 8; ++form) {
        const struct method m = {(enum kith_kernel)k,
                                 viscosity[form % 4],
                                 form & 2 ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER,
                                 (form & 4) != 0,
                                 form & 1 ? 1.7 : 0.6,
                                 form & 4 ? 2.2 : 0,
                                 (enum kith_balsara)((form / 2 + k + side) % 4)};
        const int *cells = world_boxes[(form + k) % 2];
        if (NDIM == 3 && (form + k + side) % 3 != 0) continue;   /* a third of them, to save time */
        if (side == OPEN && cells[0] == 3 && NDIM < 3) continue; /* too few nodes */
        check(&m, (enum side)side, cells, form, ++seed);
      }
}

/* Checks that forces sum to 0, relative to the sum of their magnitudes plus `least`. */
static inline void world_momentum(const struct world *w, double least, double tolerance) {
  for (int a = 0; a < NDIM; ++a) {
    double sum = 0, scale = least;
    for (int i = 0; i < w->nodes->n_internal; ++i) {
      const double f = w->hydro.mass->f64[i] * w->hydro.acceleration->f64[i * NDIM + a];
      sum += f, scale += fabs(f);
    }
    CHECK_CLOSE(sum, 0, tolerance * scale);
  }
}

#endif
