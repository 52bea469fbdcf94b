/* test_norms.c - error norms, against sums by hand and in long double; and the measured shock, against exact
 * profiles that are smeared by a known width. */
#include "tests/check.h"
#include "validation/norms.h"
#include "tests/unit/exact_settings.h"
#include "lib/core/vec.h"

#include <omp.h>
#include <string.h>

struct cloud {
  struct kith_profile_view view;
  double *position, *velocity, *mass, *density, *pressure, *energy; /* owned */
};

static void cloud_init(struct cloud *c, kith_index n) {
  memset(c, 0, sizeof *c);
  const size_t count = (size_t)n;
  CHECK_OK(kith_resize(&c->position, 0, count, NDIM * sizeof(double)));
  CHECK_OK(kith_resize(&c->velocity, 0, count, NDIM * sizeof(double)));
  CHECK_OK(kith_resize(&c->mass, 0, count, sizeof(double)));
  CHECK_OK(kith_resize(&c->density, 0, count, sizeof(double)));
  CHECK_OK(kith_resize(&c->pressure, 0, count, sizeof(double)));
  CHECK_OK(kith_resize(&c->energy, 0, count, sizeof(double)));
  c->view = (struct kith_profile_view){n,           c->position, c->velocity, c->mass, c->density,
                                       c->pressure, c->energy,   NULL,        NULL};
}

static void cloud_clear(struct cloud *c) {
  double **const field[] = {&c->position, &c->velocity, &c->mass, &c->density, &c->pressure, &c->energy};
  for (size_t i = 0; i < sizeof field / sizeof field[0]; ++i) kith_free(field[i]);
}

/* Node i gets the exact state at its position; its volume is given. */
static void set_exact(struct cloud *c, kith_index i, const struct kith_exact_ops *ops, const void *self,
                      double time, double volume) {
  struct kith_exact_state s;
  ops->state(self, &c->position[i * NDIM], time, &s);
  memcpy(&c->velocity[i * NDIM], s.velocity, sizeof s.velocity);
  c->density[i] = s.density, c->pressure[i] = s.pressure, c->energy[i] = s.energy;
  c->mass[i] = s.density * volume;
}

static struct kith_norms measure(const struct cloud *c, const struct kith_exact_ops *ops, const void *self,
                                 double time, struct kith_window window) {
  struct kith_norms norms = {0};
  CHECK_OK(kith_norms_measure(&norms, ops, self, time, &window, &c->view));
  return norms;
}

static void *create_solution(const struct kith_exact_ops *ops, struct exact_parameters p) {
  void *self = NULL;
  CHECK_OK(exact_create(&self, ops, &p));
  return self;
}

static void *gas_at_rest(void) {
  return create_solution(&kith_exact_uniform,
                         (struct exact_parameters){.gamma = {2}, .density = {1}, .pressure = {1}});
}

static const struct kith_window all = {{-INFINITY, INFINITY}, {0, INFINITY}};

/* Three nodes of volumes 1, 3 and 4; the energy of the solution is 1. */
static void check_mismatch(const struct cloud *c, const void *self, const char *expected, double part) {
  const char *name = "none";
  const double found = kith_norms_mismatch(&name, &kith_exact_uniform, self, false, &all, &c->view);
  CHECK_CLOSE(found, part, 1e-15);
  CHECK(strcmp(name, expected) == 0);
  name = "none"; /* of a blast the energy does not count */
  const double blast = kith_norms_mismatch(&name, &kith_exact_uniform, self, true, &all, &c->view);
  CHECK_CLOSE(blast, strcmp(expected, "energy") == 0 ? 0 : part, 1e-15);
}

static void test_by_hand(void) {
  struct cloud c;
  cloud_init(&c, 3);
  const double density[] = {1, 2, 0.5}, volume[] = {1, 3, 4}, pressure[] = {1, 0, 3}, energy[] = {1, 1, 1.5};
  for (int i = 0; i < 3; ++i) {
    c.position[i * NDIM] = i;
    c.density[i] = density[i], c.mass[i] = density[i] * volume[i];
    c.pressure[i] = pressure[i], c.energy[i] = energy[i];
  }
  for (int a = 0; a < NDIM; ++a) c.velocity[2 * NDIM + a] = 2; /* length 2 sqrt(NDIM) */
  void *self = gas_at_rest();
  struct kith_norms n = measure(&c, &kith_exact_uniform, self, 0, all);
  CHECK(n.nodes == 3 && n.contact_pressure_error == 0 && n.shock_radius == 0 && n.shock_exact == 0 &&
        n.density_peak == 2);
  CHECK_CLOSE(n.density.l1, (3 * 1 + 4 * 0.5) / 8, 1e-15);
  CHECK_CLOSE(n.density.l2, sqrt((3 * 1 + 4 * 0.25) / 8), 1e-15);
  CHECK_CLOSE(n.density.linf, 1, 0);
  CHECK_CLOSE(n.velocity.l1, 4 * 2 * sqrt(NDIM) / 8, 1e-15);
  CHECK_CLOSE(n.velocity.l2, sqrt(4. * 4 * NDIM / 8), 1e-15);
  CHECK_CLOSE(n.speed.l1, 4 * 2 / 8., 1e-15); /* along axis 0 only */
  CHECK(n.speed_peak == 0 && !n.vortex);
  CHECK_CLOSE(n.pressure.l1, (3 * 1 + 4 * 2) / 8., 1e-15);
  CHECK_CLOSE(n.pressure.linf, 2, 0);
  CHECK_CLOSE(n.energy.l2, sqrt(4 * 0.25 / 8), 1e-15);
  for (int a = 0; a < NDIM; ++a) { /* any component counts */
    check_mismatch(&c, self, "velocity", 4 * 2 / (4 * 2.));
    if (a < NDIM - 1) c.velocity[2 * NDIM + a] = 0;
  }
  for (int a = 0; a < NDIM; ++a) c.velocity[2 * NDIM + a] = 0;
  check_mismatch(&c, self, "density", (3 * 1 + 4 * 0.5) / (1 * 2 + 3 * 3 + 4 * 1.5));
  for (int i = 0; i < 3; ++i) c.density[i] = 1, c.mass[i] = volume[i];
  check_mismatch(&c, self, "energy", 4 * 0.5 / (1 * 2 + 3 * 2 + 4 * 2.5));
  c.energy[2] = 1;
  check_mismatch(&c, self, "none", 0);
  for (int i = 0; i < 3; ++i) c.density[i] = density[i], c.mass[i] = density[i] * volume[i];
  /* Windows include their edges: node 1 is on both. */
  struct kith_window w = {{1, 1}, {0, INFINITY}};
  n = measure(&c, &kith_exact_uniform, self, 0, w);
  CHECK(n.nodes == 1 && n.density.l1 == 1 && n.pressure.l1 == 1 && n.density_peak == 2);
  w = (struct kith_window){{-INFINITY, INFINITY}, {1.5, 2.5}};
  CHECK(measure(&c, &kith_exact_uniform, self, 0, w).nodes == 1);
  c.position[2 * NDIM + NDIM - 1] += 1; /* the distance depends on the last axis */
  CHECK(measure(&c, &kith_exact_uniform, self, 0, w).nodes == (NDIM == 1 ? 0 : 1));
  w.r[0] = 2.1;
  CHECK(measure(&c, &kith_exact_uniform, self, 0, w).nodes == (NDIM == 1 ? 0 : 1));
  w.x[1] = 1.5; /* both conditions must hold */
  CHECK(measure(&c, &kith_exact_uniform, self, 0, w).nodes == 0);
  n = measure(&c, &kith_exact_uniform, self, 0, (struct kith_window){{-INFINITY, INFINITY}, {5, 6}});
  CHECK(n.nodes == 0 && isnan(n.density.l1) && isnan(n.density.l2) && isnan(n.density.linf) &&
        n.density_peak == 0);
  c.view.n = 0;
  CHECK(measure(&c, &kith_exact_uniform, self, 0, all).nodes == 0);
  kith_free(&self);
  cloud_clear(&c);
}

/* A Riemann problem whose velocity across x is derived; where it is not known, it does not count. */
static void test_across(void) {
  for (int known = 0; known < 2 && NDIM > 1; ++known) {
    struct kith_exact_scene scene = {.n_regions = 2, .upper = {2}};
    double settings[EXACT_NUMBERS];
    void *self = NULL;
    struct cloud c;
    exact_fill(settings, &kith_exact_riemann, &(struct exact_parameters){0});
    for (int k = 0; k < 2; ++k) {
      scene.region[k] = (struct kith_exact_region){
          .gamma = 1.4, .density = 1, .pressure = 1, .lower = {k}, .upper = {k + 1}};
      scene.region[k].velocity[NDIM - 1] = known ? 3.0 - 4 * k : NAN;
    }
    kith_exact_riemann.derive(settings, &scene);
    CHECK_OK(kith_exact_create(&self, &kith_exact_riemann, settings));
    cloud_init(&c, 2);
    for (kith_index i = 0; i < 2; ++i) {
      c.position[i * NDIM] = 0.5 + (double)i;
      set_exact(&c, i, &kith_exact_riemann, self, 0.1, 1);
      c.velocity[i * NDIM + NDIM - 1] = (i == 0 ? 3 : -1) + 2;
    }
    const char *name = "none";
    CHECK_CLOSE(measure(&c, &kith_exact_riemann, self, 0.1, all).velocity.l1, known ? 2 : 0, 1e-14);
    CHECK_CLOSE(kith_norms_mismatch(&name, &kith_exact_riemann, self, false, &all, &c.view),
                known ? 4. / (5 + 1 + 3 + 1) : 0, 1e-14);
    kith_free(&self);
    cloud_clear(&c);
  }
}

static void test_refusals(void) {
  struct cloud c;
  cloud_init(&c, 5);
  void *self = gas_at_rest();
  struct kith_norms n = {.nodes = 77};
  double *const field[] = {c.position, c.velocity, c.mass, c.density, c.pressure, c.energy};
  const double bad[] = {NAN, INFINITY, 0, -1, NAN, NAN};
  for (int f = 0; f < 6; ++f) {
    for (int i = 0; i < 5; ++i) set_exact(&c, i, &kith_exact_uniform, self, 0, 1);
    field[f][f < 2 ? 3 * NDIM + NDIM - 1 : 3] = bad[f];
    CHECK_STATUS(KITH_DIVERGED, kith_norms_measure(&n, &kith_exact_uniform, self, 0, &all, &c.view));
    CHECK(strstr(kith_failure(), "node 3") != NULL && n.nodes == 77);
    field[f][f < 2 ? 3 * NDIM + NDIM - 1 : 3] = 1;
  }
  kith_free(&self);
  cloud_clear(&c);
}

static bool identical(const struct kith_norms *a, const struct kith_norms *b) {
  return memcmp(&a->density, &b->density, 5 * sizeof(struct kith_norm)) == 0;
}

/* Sums in blocks agree with long double, and are bitwise identical for any number of threads. */
static void test_blocks(void) {
  void *self = gas_at_rest();
  const kith_index sizes[] = {1, 1023, 1024, 1025, 10001};
  uint64_t seed = 3;
  for (int k = 0; k < 5; ++k) {
    struct cloud c;
    cloud_init(&c, sizes[k]);
    long double sum = 0, sum2 = 0, volume = 0;
    for (kith_index i = 0; i < sizes[k]; ++i) {
      for (int a = 0; a < NDIM; ++a) c.position[i * NDIM + a] = check_random(&seed);
      c.density[i] = 0.5 + check_random(&seed), c.mass[i] = 0.1 + check_random(&seed);
      c.pressure[i] = 2 * check_random(&seed), c.energy[i] = check_random(&seed);
      const long double v = (long double)c.mass[i] / c.density[i], d = fabsl((long double)c.pressure[i] - 1);
      volume += v, sum += v * d, sum2 += v * d * d;
    }
    omp_set_num_threads(1);
    const struct kith_norms one = measure(&c, &kith_exact_uniform, self, 0, all);
    for (int threads = 2; threads <= 4; ++threads) {
      omp_set_num_threads(threads);
      const struct kith_norms many = measure(&c, &kith_exact_uniform, self, 0, all);
      CHECK(identical(&one, &many) && many.nodes == (uint64_t)sizes[k]);
    }
    CHECK_CLOSE(one.pressure.l1, (double)(sum / volume), 1e-14); /* round-off of 1e4 terms in blocks */
    CHECK_CLOSE(one.pressure.l2, (double)sqrtl(sum2 / volume), 1e-14);
    cloud_clear(&c);
  }
  kith_free(&self);
}

/* ---- smeared profiles ---- */

enum { SAMPLES = 2001 };

/* Density and speed along axis 0 at lower + k step, smeared by a Gaussian of width sigma. */
struct profile {
  double lower, step, density[SAMPLES], speed[SAMPLES];
};

static struct kith_exact_state exact_at(const struct kith_exact_ops *ops, const void *self, double d,
                                        double time) {
  struct kith_exact_state s;
  double x[NDIM] = {0};
  for (int a = 0; ops->radial && a < NDIM; ++a) x[a] = kith_exact_about(ops, self)->center[a];
  x[0] += d;
  ops->state(self, x, time, &s);
  return s;
}

static void smear(struct profile *p, const struct kith_exact_ops *ops, const void *self, double time,
                  double lower, double upper, double sigma) {
  p->lower = lower, p->step = (upper - lower) / (SAMPLES - 1);
  for (int k = 0; k < SAMPLES; ++k) {
    double density = 0, speed = 0, weight = 0;
    for (int i = -100; i <= 100; ++i) { /* 4 sigma on both sides */
      const double s = i / 25., w = exp(-s * s / 2);
      const struct kith_exact_state exact = exact_at(ops, self, lower + k * p->step + s * sigma, time);
      density += w * exact.density, speed += w * exact.velocity[0], weight += w;
    }
    p->density[k] = density / weight, p->speed[k] = speed / weight;
  }
}

/* Interpolates an array of p at d. */
static double profile_at(const struct profile *p, const double *value, double d) {
  const double s = KITH_MIN(KITH_MAX((d - p->lower) / p->step, 0.0), SAMPLES - 1.0);
  const int k = KITH_MIN((int)s, SAMPLES - 2);
  return value[k] + (s - k) * (value[k + 1] - value[k]);
}

/* A lattice of `side` nodes across [-half, half] along each axis; nodes are displaced at random by up to half
 * of `jitter` spacings. */
static void lattice(struct cloud *c, int side, double half, double jitter) {
  const double h = 2 * half / side;
  uint64_t seed = 8;
  kith_index n = 1;
  for (int a = 0; a < NDIM; ++a) n *= side;
  cloud_init(c, n);
  for (kith_index i = 0; i < n; ++i) {
    kith_index rest = i;
    for (int a = 0; a < NDIM; ++a, rest /= side)
      c->position[i * NDIM + a] = -half + h * (rest % side + 0.5 + jitter * (check_random(&seed) - 0.5));
    c->mass[i] = kith_pow_dim(h);
  }
}

/* Equal volumes: nodes stay, and masses follow the density. */
static void fill_planar(struct cloud *c, const struct profile *p) {
  for (kith_index i = 0; i < c->view.n; ++i) {
    c->density[i] = profile_at(p, p->density, c->position[i * NDIM]);
    c->velocity[i * NDIM] = profile_at(p, p->speed, c->position[i * NDIM]);
    c->mass[i] *= c->density[i];
  }
}

/* Equal masses: each node moves along its radius to where the smeared blast has the mass that it enclosed. */
static void fill_radial(struct cloud *c, const struct profile *p, const double *center) {
  static double mass[SAMPLES];
  mass[0] = 0;
  for (int k = 1; k < SAMPLES; ++k) {
    const double volume = kith_pow_dim(k * p->step) - kith_pow_dim((k - 1) * p->step);
    mass[k] = mass[k - 1] + volume * (p->density[k] + p->density[k - 1]) / 2;
  }
  for (kith_index i = 0; i < c->view.n; ++i) {
    double *const x = &c->position[i * NDIM], r = kith_norm(x), held = kith_pow_dim(r);
    int k = 0;
    while (k < SAMPLES - 2 && mass[k + 1] < held) ++k;
    const double moved = p->step * (k + (held - mass[k]) / (mass[k + 1] - mass[k]));
    const double speed = profile_at(p, p->speed, moved);
    for (int a = 0; a < NDIM; ++a) {
      c->velocity[i * NDIM + a] = speed * x[a] / r;
      x[a] = center[a] + x[a] * moved / r;
    }
    c->density[i] = profile_at(p, p->density, moved);
  }
}

static void test_planar_shock(void) {
  struct exact_parameters p = {.gamma = {1.4, 1.4}, .density = {1, .125}, .pressure = {1, .1}};
  const struct kith_window window = {{-0.45, 0.45}, {0, INFINITY}};
  static struct profile profile;
  for (int way = 0; way < 2; ++way) {
    void *self = create_solution(&kith_exact_riemann, p);
    for (int width = 1; width <= 3; ++width) {
      const double h = 1. / (NDIM == 3 ? 40 : 100), sigma = 0.5 * width * h;
      struct cloud c;
      smear(&profile, &kith_exact_riemann, self, 0.2, -0.5, 0.5, sigma);
      lattice(&c, NDIM == 3 ? 40 : 100, 0.5, 0.2);
      fill_planar(&c, &profile);
      const struct kith_norms n = measure(&c, &kith_exact_riemann, self, 0.2, window);
      CHECK_CLOSE(n.shock_exact, (way == 0 ? 1 : -1) * .350432, 1e-6);
      CHECK_CLOSE(n.shock_radius, n.shock_exact, 0.01 * fabs(n.shock_exact)); /* the promise of the header */
      CHECK(n.shock_offset * (fabs(n.shock_radius) - fabs(n.shock_exact)) > 0); /* positive if ahead */
      CHECK(n.shock_swept == 0);
      CHECK_CLOSE(n.density_peak, 1, 0.01);
      const struct kith_window left = {{-0.3, 0.3}, {0, INFINITY}};
      CHECK(!n.shock_outside && measure(&c, &kith_exact_riemann, self, 0.2, left).shock_outside);
      cloud_clear(&c);
    }
    kith_free(&self);
    p.density[0] = .125, p.density[1] = 1, p.pressure[0] = .1, p.pressure[1] = 1; /* now to the left */
  }
}

static void check_radial(const struct kith_exact_ops *ops, const struct exact_parameters *p, double time,
                         double half, double smearing) {
  static struct profile profile;
  void *self = create_solution(ops, *p);
  struct cloud c;
  smear(&profile, ops, self, time, 0, half, smearing * ops->shock(self, time));
  lattice(&c, NDIM == 3 ? 50 : 128, half, 0.1);
  fill_radial(&c, &profile, p->center);
  const struct kith_window window = {{-INFINITY, INFINITY}, {0, 0.45}};
  const struct kith_norms n = measure(&c, ops, self, time, window);
  CHECK_CLOSE(n.shock_radius, n.shock_exact, 0.01 * n.shock_exact); /* the promise of the header */
  /* the density of Noh's gas ahead varies above 1-D */
  CHECK((n.shock_swept > 0) == (NDIM == 1 || ops == &kith_exact_sedov));
  if (ops == &kith_exact_sedov) { /* masses are those of the lattice, in gas of density 1 */
    const double spacing = half / (NDIM == 3 ? 25 : 64);
    CHECK_CLOSE(n.shock_offset, (n.shock_radius - n.shock_exact) / spacing, 1e-10);
    double swept = 0; /* nodes were on a lattice of this spacing */
    for (int k = 0; (k + 1) * profile.step < n.shock_radius; ++k)
      swept += (kith_pow_dim((k + 1) * profile.step) - kith_pow_dim(k * profile.step)) *
               (profile.density[k] + profile.density[k + 1]) / 2;
    /* within whole nodes */
    CHECK_CLOSE(n.shock_swept, pow(swept, 1. / NDIM), (NDIM == 1 ? 0.6 : 0.25) * spacing);
    CHECK(n.shock_swept < n.shock_radius - 0.2 * smearing * n.shock_exact);
  }
  /* A node that is thrown out of the center raises the level to half of the exact speed at most. */
  for (int a = 0; a < NDIM; ++a) c.position[a] = p->center[a] + 0.001, c.velocity[a] = 1e3;
  CHECK_CLOSE(measure(&c, ops, self, time, window).shock_radius, n.shock_exact, 0.015 * n.shock_exact);
  double peak = 0;
  for (int k = 0; k * profile.step < 0.45; ++k) peak = KITH_MAX(peak, profile.density[k]);
  CHECK(n.density_peak <= peak * (1 + 1e-12));    /* it is a mean */
  CHECK_CLOSE(n.density_peak, peak, 0.15 * peak); /* over a bin one spacing wide, of a peak about two wide */
  cloud_clear(&c);
  kith_free(&self);
}

static void test_radial_shock(void) {
  struct exact_parameters blast = {.gamma = {5. / 3}, .density = {1}, .pressure = {1e-6}, .blast_energy = 1};
  struct exact_parameters noh = {.gamma = {5. / 3}, .density = {1}, .velocity = {1}};
  const double when[] = {.15, .07, .05}; /* R is about 0.35 */
  for (int a = 0; a < NDIM; ++a) blast.center[a] = noh.center[a] = 0.3 - a;
  for (int width = 1; width <= 3; ++width) { /* up to 1 spacing in 3-D */
    check_radial(&kith_exact_sedov, &blast, when[NDIM - 1], 0.5, 0.017 * width);
    check_radial(&kith_exact_noh, &noh, 0.9, 1.8, 0.03 * width); /* gas within 0.3 came from within 1.2 */
  }
}

/* Norms, shock and peaks are the same wherever in a periodic box, of side 1, the center is, and if all is
 * carried along. */
static void check_moved(const struct kith_exact_ops *ops, const struct exact_parameters *p, double time) {
  struct kith_norms n[2];
  double u[NDIM], settings[EXACT_NUMBERS];
  for (int a = 0; a < NDIM; ++a) u[a] = ops->vortex ? 3 - 4 * a : 0;
  for (int moved = 0; moved < 2; ++moved) {
    struct cloud c;
    uint64_t seed = 7;
    exact_fill(settings, ops, p);
    struct kith_exact_gas *gas = (struct kith_exact_gas *)settings;
    for (int a = 0; a < NDIM; ++a) {
      gas->period[a] = 1;
      if (moved && ops->vortex) gas->uniform_velocity[a] = u[a];
      if (moved && !ops->vortex) gas->center[a] = 0.5; /* a corner */
    }
    void *self = NULL;
    CHECK_OK(kith_exact_create(&self, ops, settings));
    cloud_init(&c, 3000);
    for (kith_index i = 0; i < c.view.n; ++i) {
      for (int a = 0; a < NDIM; ++a) {
        const double x =
            check_random(&seed) - 0.5 + (moved ? gas->center[a] + gas->uniform_velocity[a] * time : 0);
        c.position[i * NDIM + a] = x - floor(x + 0.5);
      }
      set_exact(&c, i, ops, self, time, 1. / 3000);
      c.density[i] *= 1 + 0.1 * check_random(&seed), c.pressure[i] += check_random(&seed);
      for (int a = 0; a < NDIM; ++a) c.velocity[i * NDIM + a] += 0.1 * check_random(&seed);
    }
    n[moved] = measure(&c, ops, self, time, (struct kith_window){{-INFINITY, INFINITY}, {0.05, 0.35}});
    CHECK(n[moved].carried == (moved && ops->vortex));
    cloud_clear(&c);
    kith_free(&self);
  }
  CHECK(n[0].nodes == n[1].nodes && n[0].nodes > 100);
  CHECK_CLOSE(n[1].density.l1, n[0].density.l1, 1e-11 * n[0].density.l1);
  CHECK_CLOSE(n[1].velocity.l1, n[0].velocity.l1, 1e-11 * n[0].velocity.l1);
  CHECK_CLOSE(n[1].speed.l1, n[0].speed.l1, 1e-11 * n[0].speed.l1);
  CHECK_CLOSE(n[1].speed_peak, n[0].speed_peak, 1e-11 * n[0].speed_peak);
  CHECK_CLOSE(n[1].density_peak, n[0].density_peak, 1e-11 * n[0].density_peak);
  CHECK_CLOSE(n[1].shock_radius, n[0].shock_radius, 1e-11);
  CHECK((n[0].shock_radius > 0) == (ops->shock != NULL));
}

static void test_moved(void) {
  const struct exact_parameters blast = {.gamma = {1.4}, .density = {1}, .blast_energy = 1};
  const struct exact_parameters vortex = {.gamma = {1.4}, .density = {1}, .pressure = {5}, .amplitude = 5};
  const double when[] = {.12, .05, .03};
  check_moved(&kith_exact_sedov, &blast, when[NDIM - 1]); /* a shock at about 0.3 */
  if (NDIM == 1) return;
  check_moved(&kith_exact_gresho, &vortex, 1.7);
  check_moved(&kith_exact_yee, &vortex, 1.7);
}

/* Bins of the density peak, in any unit of length: two nodes share a bin (mean by volume), the third is
 * second densest; the farthest sets their width. */
static void check_peak_bins(double unit) {
  void *self = create_solution(&kith_exact_noh,
                               (struct exact_parameters){.gamma = {1.4}, .density = {1}, .velocity = {1}});
  struct cloud c;
  cloud_init(&c, 4);
  const double place[] = {0.0101, -0.0149, 0.0151, 0.5}, density[] = {9, 1, 4, 1}, volume[] = {1, 3, 1, 1};
  for (int i = 0; i < 4; ++i) {
    c.position[i * NDIM] = place[i] * unit;
    c.density[i] = density[i];
    c.mass[i] =
        density[i] * volume[i] * 1e-12 * kith_pow_dim(unit); /* the spacing is far below the bin of 0.005 */
  }
  /* neither 9 nor (9 + 3) / 4 */
  CHECK_CLOSE(measure(&c, &kith_exact_noh, self, 0, all).density_peak, 4, 1e-14);
  c.density[2] = 2, c.mass[2] *= 0.5;
  CHECK_CLOSE(measure(&c, &kith_exact_noh, self, 0, all).density_peak, 3, 1e-14);
  cloud_clear(&c);
  kith_free(&self);
}

static void test_contact_pressure_error(void) {
  const double time = 0.2;
  void *self = create_solution(
      &kith_exact_riemann,
      (struct exact_parameters){
          .gamma = {1.4, 1.4}, .density = {1, .125}, .pressure = {1, .1}, .interface_position = 3});
  const struct kith_exact_star star = kith_exact_riemann.star(self);
  const double contact = 3 + star.velocity * time;
  struct cloud c;
  cloud_init(&c, 5);
  /* half of the distances to waves: 0.0998, 0.0825; the last node is in the rarefaction */
  const double offset[] = {-0.09, 0.08, -0.101, 0.085, -0.25};
  for (int i = 0; i < 5; ++i) {
    c.position[i * NDIM] = contact + offset[i];
    set_exact(&c, i, &kith_exact_riemann, self, time, 1);
  }
  struct kith_norms n = measure(&c, &kith_exact_riemann, self, time, all);
  CHECK(n.contact_pressure_error < 1e-14 && n.density.linf == 0 && n.velocity.linf == 0 &&
        n.pressure.l2 == 0);
  for (int i = 2; i < 5; ++i) c.pressure[i] *= 3; /* nearer to a wave than to the contact */
  CHECK(measure(&c, &kith_exact_riemann, self, time, all).contact_pressure_error < 1e-14);
  c.pressure[0] *= 0.93, c.pressure[1] *= 1.05;
  CHECK_CLOSE(measure(&c, &kith_exact_riemann, self, time, all).contact_pressure_error, 0.07, 1e-14);
  const struct kith_window right = {{contact, contact + 1}, {0, INFINITY}};
  CHECK_CLOSE(measure(&c, &kith_exact_riemann, self, time, right).contact_pressure_error, 0.05, 1e-14);
  /* At first the region between the waves is narrow, and node 0 is outside of it. */
  n = measure(&c, &kith_exact_riemann, self, 1e-3, all);
  CHECK(n.contact_pressure_error == 0);
  cloud_clear(&c);
  kith_free(&self);
}

/* Around a vortex, motion across it or along its axis counts in the velocity, not in the speed; the window is
 * a cylinder. */
static void test_vortex(void) {
  void *self = create_solution(&kith_exact_gresho,
                               (struct exact_parameters){.gamma = {1.4}, .density = {1}, .pressure = {5}});
  struct cloud c;
  cloud_init(&c, 4);
  for (int i = 0; i < 4; ++i) { /* 0.1 to 0.4 from the axis, at heights 0, 2, 4, 6 */
    c.position[i * NDIM] = 0.1 * (i + 1) * 0.6, c.position[i * NDIM + (NDIM > 1)] = 0.1 * (i + 1) * 0.8;
    if (NDIM == 3) c.position[i * NDIM + NDIM - 1] = 2 * i;
    set_exact(&c, i, &kith_exact_gresho, self, 0, 1e-9); /* bins are narrower than distances */
  }
  struct kith_norms n = measure(&c, &kith_exact_gresho, self, 0, all);
  CHECK(n.nodes == 4 && n.velocity.linf == 0 && n.speed.linf == 0 && n.vortex && n.shock_exact == 0);
  CHECK_CLOSE(n.speed_peak, 1, 1e-14);
  CHECK_CLOSE(n.density_peak, 1, 1e-14);
  c.velocity[0] += 0.3 * 0.6, c.velocity[NDIM > 1] += 0.3 * 0.8; /* node 0: outwards; node 1: slower */
  c.velocity[NDIM] += 0.4 * 0.8, c.velocity[NDIM + (NDIM > 1)] -= 0.4 * 0.6;
  n = measure(&c, &kith_exact_gresho, self, 0, all);
  CHECK_CLOSE(n.velocity.l1, 0.7 / 4, 1e-15);
  CHECK_CLOSE(n.speed.l1, 0.4 / 4, 1e-15);
  CHECK_CLOSE(n.speed.l2, sqrt(0.16 / 4), 1e-15);
  CHECK_CLOSE(n.speed_peak, 0.6, 1e-14);
  const struct kith_window ring = {{-INFINITY, INFINITY}, {0.15, 0.35}};
  CHECK(measure(&c, &kith_exact_gresho, self, 0, ring).nodes == 2);
  cloud_clear(&c);
  kith_free(&self);
}

/* Without nodes at the shock, with all nodes behind it, or with a single node, no shock is found. */
static void test_no_shock_seen(void) {
  void *self = create_solution(&kith_exact_sedov,
                               (struct exact_parameters){.gamma = {1.4}, .density = {1}, .blast_energy = 1});
  struct cloud c;
  lattice(&c, 8, 0.1, 0);
  for (kith_index i = 0; i < c.view.n; ++i) c.density[i] = 1;
  CHECK(measure(&c, &kith_exact_sedov, self, 1, all).shock_radius == 0); /* at rest */
  for (kith_index i = 0; i < c.view.n; ++i) {
    const double *const x = &c.position[i * NDIM];
    for (int a = 0; a < NDIM; ++a) c.velocity[i * NDIM + a] = 5 * x[a] / kith_norm(x);
  }
  CHECK(measure(&c, &kith_exact_sedov, self, 1, all).shock_radius == 0); /* all nodes are behind the shock */
  c.view.n = 1;
  CHECK(measure(&c, &kith_exact_sedov, self, 1, all).shock_radius == 0);
  CHECK(measure(&c, &kith_exact_sedov, self, 0, all).shock_radius == 0); /* before the blast */
  cloud_clear(&c);
  kith_free(&self);
}

int main(void) {
  test_by_hand();
  test_across();
  test_refusals();
  test_blocks();
  test_planar_shock();
  test_radial_shock();
  test_moved();
  check_peak_bins(1);
  check_peak_bins(1e-12);
  test_contact_pressure_error();
  if (NDIM > 1) test_vortex();
  test_no_shock_seen();
  return check_failed();
}
