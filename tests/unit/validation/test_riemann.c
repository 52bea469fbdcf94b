/* test_riemann.c - Riemann problems, against constants computed elsewhere, conservation laws (by quadrature)
 * and, for pairs of materials, jump conditions, their own equations of state and isentropes integrated
 * through them. */
#include "tests/unit/validation/exact_oracles.h"
#include "tests/unit/exact_settings.h"
#include "tests/unit/materials.h"

#include <gsl/gsl_integration.h>
#include <string.h>

typedef struct kith_exact_state state;
typedef struct exact_parameters parameters;

static parameters two_states(double gamma, const double *left, const double *right) {
  return (parameters){.gamma = {gamma, gamma},
                      .density = {left[0], right[0]},
                      .velocity = {left[1], right[1]},
                      .pressure = {left[2], right[2]}};
}

static void *riemann_of(const parameters *p) {
  void *self = NULL;
  CHECK_OK(exact_create(&self, &kith_exact_riemann, p));
  return self;
}

struct constants {
  double gamma, left[3], right[3], pressure, velocity, density[2], head, tail, shock;
};

/* The table of reference constants; 0: not in the table. */
static const struct constants table[] = {
    {1.4, {1, 0, 1}, {.125, 0, .1}, .303130, .927453, {.426319, .265574}, -1.18322, -.070273, 1.75216},
    {5. / 3, {1, 0, 1}, {.125, 0, .1}, .293945, .841195, {.479689, .229806}, -1.29099, -.169401, 1.84447},
    {1.4, {1, 0, 1}, {.25, 0, .1795}, .429346, .673103, {.546663, .457328}, 0, 0, 1.48474},
    {5. / 3, {1, 0, 1}, {.25, 0, .1795}, .421735, .614215, {.595695, .409402}, 0, 0, 1.57753},
    {1.4, {1, -2, .4}, {1, 2, .4}, 1.89387e-3, 0, {.0218521, .0218521}, -2.74833, -.348331, 0},
    {5. / 3, {1, -2, .4}, {1, 2, .4}, 8.32e-5, 0, {.0061792, .0061792}, -2.8165, -.14983, 0},
    {1.4, {1, 0, 1000}, {1, 0, .01}, 460.894, 19.5975, {.575062, 5.99924}, 0, 0, 23.5175},
    {1.4, {1, 0, .01}, {1, 0, 100}, 46.095, -6.19633, {5.99242, .575113}, 0, 0, 0},
    {1.4,
     {5.99924, 19.5975, 460.894},
     {5.99242, -6.19633, 46.0950},
     1691.65,
     8.68977,
     {14.2823, 31.0426},
     .789594,
     .789594,
     12.2508},
    {5. / 3,
     {1, 0, .1 * 2 / 3},
     {1e-3, 0, 1e-10 * 2 / 3},
     5.15578e-4,
     .621839,
     {.0540793, .004},
     0,
     0,
     .829118},
    {1.4, {.445, .698, 3.528}, {.5, 0, .571}, 2.4661, 1.52872, {.344568, 1.30408}, 0, 0, 2.47932},
};

/* The table has 4 to 7 digits: one unit in the fifth is required (1-2-3 at 5/3 has three digits of p*). */
static void check_digits(double got, double wanted, double scale) {
  const double unit = fabs(wanted) < 1e-4 ? 1e-3 : 1e-5;
  if (wanted != 0) CHECK_CLOSE(got, wanted, KITH_MAX(unit * fabs(wanted), 1e-6 * scale));
}

static void test_riemann_table(void) {
  for (size_t i = 0; i < sizeof table / sizeof table[0]; ++i) {
    const struct constants *c = &table[i];
    const parameters p = two_states(c->gamma, c->left, c->right);
    void *self = riemann_of(&p);
    const struct kith_exact_star star = kith_exact_riemann.star(self);
    check_digits(star.pressure, c->pressure, 0);
    check_digits(star.velocity, c->velocity, 0);
    if (c->velocity == 0) CHECK_CLOSE(star.velocity, 0, 1e-13); /* symmetric: round-off only */
    for (int k = 0; k < 2; ++k) check_digits(star.density[k], c->density[k], 0);
    check_digits(star.head[0], c->head, 1);
    check_digits(star.tail[0], c->tail, 1); /* six decimals */
    if (c->shock != 0) check_digits(kith_exact_riemann.shock(self, 1), c->shock, 0);
    kith_free(&self);
    CHECK(self == NULL);
  }
}

struct content {
  const void *self;
  double time;
  int which; /* 0: mass, 1: momentum, 2: energy */
};

static double content_at(double x, void *context) {
  const struct content *c = context;
  const state s = at(&kith_exact_riemann, c->self, x, c->time);
  const double v = s.velocity[0];
  return c->which == 0 ? s.density : c->which == 1 ? s.density * v : s.density * (s.energy + v * v / 2);
}

/* Integral over [lower, upper], piece by piece between the edges of waves. */
static double total(struct content c, double lower, double upper, gsl_integration_workspace *work) {
  const struct kith_exact_star star = kith_exact_riemann.star(c.self);
  const double cut[] = {lower,
                        star.interface + star.head[0] * c.time,
                        star.interface + star.tail[0] * c.time,
                        star.interface + star.velocity * c.time,
                        star.interface + star.tail[1] * c.time,
                        star.interface + star.head[1] * c.time,
                        upper};
  gsl_function f = {content_at, &c};
  double sum = 0;
  for (int i = 0; i < 6; ++i) {
    double part = 0, error;
    CHECK(cut[i] <= cut[i + 1]);
    if (cut[i] < cut[i + 1])
      gsl_integration_qag(&f, cut[i], cut[i + 1], 0, 1e-11, 200, GSL_INTEG_GAUSS31, work, &part, &error);
    sum += part;
  }
  return sum;
}

/* The content of a box that no wave has left changes only by the fluxes of the undisturbed states. */
static void check_conservation(const parameters *p, gsl_integration_workspace *work) {
  void *self = riemann_of(p);
  if (self == NULL) return;
  const double time = 0.7;
  double half_width = 1, flux[2][3], held[2][3];
  const struct kith_exact_star star = kith_exact_riemann.star(self);
  for (int k = 0; k < 2; ++k) {
    const double d = p->density[k], v = p->velocity[k], pressure = p->pressure[k];
    const double energy = pressure / (p->gamma[k] - 1) + d * v * v / 2;
    const double stored[] = {d, d * v, energy},
                 passed[] = {d * v, d * v * v + pressure, v * (energy + pressure)};
    memcpy(held[k], stored, sizeof stored);
    memcpy(flux[k], passed, sizeof passed);
    half_width = KITH_MAX(half_width, 1.5 * time * fabs(star.head[k]));
  }
  const double x0 = p->interface_position;
  for (int q = 0; q < 3; ++q) {
    const double wanted = half_width * (held[0][q] + held[1][q]) + time * (flux[0][q] - flux[1][q]);
    const double scale =
        half_width * (fabs(held[0][q]) + fabs(held[1][q])) + time * (fabs(flux[0][q]) + fabs(flux[1][q]));
    /* quadrature to 1e-11 of each piece */
    CHECK_CLOSE(total((struct content){self, time, q}, x0 - half_width, x0 + half_width, work), wanted,
                1e-9 * scale);
  }
  kith_free(&self);
}

static parameters random_problem(uint64_t *seed) {
  parameters p = {.interface_position = check_random(seed) - 0.5};
  for (int k = 0; k < 2; ++k) {
    p.gamma[k] = 1.1 + 2 * check_random(seed);
    p.density[k] = pow(10, 4 * check_random(seed) - 2);
    p.pressure[k] = pow(10, 8 * check_random(seed) - 4);
    p.velocity[k] = 6 * check_random(seed) - 3;
  }
  return p;
}

static void test_riemann_conservation(void) {
  gsl_integration_workspace *work = gsl_integration_workspace_alloc(200);
  uint64_t seed = 11;
  for (int i = 0; i < 200; ++i) {
    const parameters p = random_problem(&seed);
    check_conservation(&p, work);
  }
  const double gas[] = {1, 0.3, 1}, none[] = {0, 0, 0}, away[] = {1, 40, 1}, thin[] = {1e-2, 0, 1e-10};
  const double cold_left[] = {1, 1, 0}, cold_right[] = {2, -1, 0}, hot[] = {1, 0, 1};
  const double *const pairs[][2] = {
      {gas, none}, {none, gas}, {gas, away}, {hot, thin}, {cold_left, cold_right}, {hot, cold_right}};
  for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i) {
    const parameters p = two_states(1.4, pairs[i][0], pairs[i][1]);
    check_conservation(&p, work);
  }
  gsl_integration_workspace_free(work);
}

static void test_riemann_contacts(void) {
  const struct kith_exact_ops *const ops = &kith_exact_riemann;
  /* A contact at rest stays sharp, without a shock. */
  parameters p = two_states(1.4, (const double[]){1, 0, 2}, (const double[]){8, 0, 2});
  p.interface_position = 0.25;
  void *self = riemann_of(&p);
  CHECK(ops->shock(self, 1) == 0);
  CHECK(at(ops, self, 0.2499, 5).density == 1 && at(ops, self, 0.2501, 5).density == 8);
  CHECK_CLOSE(at(ops, self, 0.2501, 5).velocity[0], 0, 1e-14);
  kith_free(&self);
  for (int i = 1; i <= 200; ++i) { /* also if it moves: p* may be one bit above the pressure */
    p = two_states(1.4, (const double[]){1, i / 7., i / 3.}, (const double[]){1. / i, i / 7., i / 3.});
    p.gamma[1] = 1.1 + i / 100.;
    self = riemann_of(&p);
    CHECK(ops->shock(self, 1) == 0);
    CHECK_CLOSE(kith_exact_riemann.star(self).velocity, i / 7., 1e-13);
    kith_free(&self);
  }
  /* The initial state, and no velocity across the axis. */
  p = two_states(1.4, (const double[]){1, 3, 2}, (const double[]){8, -1, 5});
  self = riemann_of(&p);
  const state left = at(ops, self, -1e-300, 0), right = at(ops, self, 0, 0);
  CHECK(left.density == 1 && left.pressure == 2 && left.velocity[0] == 3 && left.energy == 2 / (1.4 - 1));
  CHECK(right.density == 8 && right.velocity[0] == -1);
  for (int a = 1; a < NDIM; ++a) CHECK(right.velocity[a] == 0);
  kith_free(&self);
  /* Pressure ratio 1e10: the strong shock compresses by (gamma+1)/(gamma-1). */
  p = two_states(1.4, (const double[]){1, 0, 1e10}, (const double[]){1, 0, 1});
  self = riemann_of(&p);
  CHECK_CLOSE(kith_exact_riemann.star(self).density[1], 6, 1e-7); /* off by O(p/p*) */
  kith_free(&self);
}

static void test_riemann_extremes(void) {
  const struct kith_exact_ops *const ops = &kith_exact_riemann;
  /* Vacuum on the right: the edge moves at 2 c / (gamma - 1), and at the interface u = c = 2 c0 / (gamma +
   * 1). */
  parameters p = two_states(1.4, (const double[]){1, 0, 1}, (const double[]){0, 0, 0});
  void *self = riemann_of(&p);
  const double c0 = sqrt(1.4);
  CHECK_CLOSE(kith_exact_riemann.star(self).tail[0], 5 * c0, 1e-13);
  CHECK_CLOSE(at(ops, self, 0, 1).velocity[0], c0 / 1.2, 1e-14);
  CHECK_CLOSE(at(ops, self, 0, 1).density, pow(1 / 1.2, 5), 1e-14);
  CHECK(at(ops, self, 5.01 * c0, 1).density == 0 && at(ops, self, 5.01 * c0, 1).energy == 0);
  CHECK(ops->shock(self, 1) == 0);
  kith_free(&self);
  /* Gases that separate leave a vacuum between -v + 5 c0 and v - 5 c0. */
  p = two_states(1.4, (const double[]){1, -7, 1}, (const double[]){1, 7, 1});
  self = riemann_of(&p);
  const struct kith_exact_star star = kith_exact_riemann.star(self);
  CHECK(star.pressure == 0 && star.density[0] == 0 && star.density[1] == 0);
  CHECK_CLOSE(star.tail[0], -7 + 5 * c0, 1e-13);
  CHECK_CLOSE(star.tail[1], 7 - 5 * c0, 1e-13);
  CHECK(at(ops, self, 0.1, 1).density == 0 && at(ops, self, 0.1, 1).velocity[0] == 0.1);
  kith_free(&self);
  /* Soft gases that nearly separate: the pressure between the waves is below the range of doubles, but waves
   * stay in order. */
  p = (parameters){.gamma = {1.005, 1.1}, .density = {1, 1}, .pressure = {1, 1e-6}, .velocity = {0, 400}};
  self = riemann_of(&p);
  const struct kith_exact_star hole = kith_exact_riemann.star(self);
  CHECK(hole.head[0] < hole.tail[0] && hole.tail[0] <= hole.velocity && hole.velocity <= hole.tail[1]);
  for (int i = 0; i <= 400; ++i)
    CHECK(isfinite(at(ops, self, i, 1).energy) && at(ops, self, i, 1).density >= 0);
  kith_free(&self);
  /* Nearly isothermal gas in a vacuum gets so thin that 1 / density is beyond the range of doubles. */
  p = two_states(1.0001, (const double[]){2, -0.5, 1e-6}, (const double[]){0, 0, 0});
  self = riemann_of(&p);
  bool thin = false;
  for (int i = -200; i <= 200; ++i) {
    const state s = at(ops, self, 1e-4 * i, 1);
    CHECK(isfinite(s.energy) && isfinite(s.pressure));
    thin = thin || (s.density > 0 && s.density < 1e-309);
  }
  CHECK(thin);
  kith_free(&self);
  /* The only shock moves to the left. */
  p = two_states(1.4, (const double[]){.125, 0, .1}, (const double[]){1, 0, 1});
  self = riemann_of(&p);
  CHECK_CLOSE(ops->shock(self, 0.2), -0.2 * 1.75216, 1e-5);
  kith_free(&self);
  /* Cold streams collide: Noh's planar state, with the shock at (gamma - 1) / 2. */
  p = two_states(5. / 3, (const double[]){1, 1, 0}, (const double[]){1, -1, 0});
  self = riemann_of(&p);
  CHECK_CLOSE(ops->shock(self, 1), 1. / 3, 1e-14);
  CHECK_CLOSE(at(ops, self, 0.1, 1).density, 4, 1e-13);
  kith_free(&self);
}

/* At the limit of separation, from both sides, waves are in order and all values finite. */
static void test_riemann_verge(void) {
  uint64_t seed = 21;
  for (int i = 0; i < 2000; ++i) {
    parameters p = random_problem(&seed);
    double escape = 0;
    for (int k = 0; k < 2; ++k) {
      p.pressure[k] = pow(10, 40 * check_random(&seed) - 20);
      escape += 2 / (p.gamma[k] - 1) * sqrt(p.gamma[k] * p.pressure[k] / p.density[k]);
    }
    p.velocity[0] = escape * (check_random(&seed) - 0.5);
    p.velocity[1] = p.velocity[0] + escape * (1 - pow(10, -16 * check_random(&seed)));
    p.interface_position = 0;
    void *self = riemann_of(&p);
    if (self == NULL) continue;
    const struct kith_exact_star star = kith_exact_riemann.star(self);
    const double slack = 1e-12 * escape; /* round-off of speeds */
    CHECK(star.head[0] <= star.tail[0] + slack && star.tail[0] <= star.velocity + slack);
    CHECK(star.velocity <= star.tail[1] + slack && star.tail[1] <= star.head[1] + slack);
    for (int step = -1; step <= 41; ++step) {
      const state s =
          at(&kith_exact_riemann, self, star.head[0] + step / 40. * (star.head[1] - star.head[0]), 1);
      CHECK(s.density >= 0 && s.pressure >= 0 && isfinite(s.density) && isfinite(s.pressure));
      CHECK(isfinite(s.energy) && isfinite(s.velocity[0]));
    }
    for (int k = 0; k < 2; ++k) /* the last position inside each wave */
      CHECK(isfinite(at(&kith_exact_riemann, self, nextafter(star.tail[k], star.head[k]), 1).energy));
    kith_free(&self);
  }
}

/* --- waves, by equation of state --- */

/* Follows the isentrope through a state to this density: energy, and velocity with du = c / rho drho, by the
 * classical Runge-Kutta method. */
static void follow_isentrope(const struct kith_material *m, state *s, double density) {
  enum { STEPS = 400 };
  const double d = (density - s->density) / STEPS;
  double p, c;
  for (int k = 0; k < STEPS; ++k) {
    double work[4], push[4];
    for (int r = 0; r < 4; ++r) {
      const double rho = s->density + (r == 0 ? 0 : r == 3 ? d : d / 2);
      const double u = s->energy + (r == 0 ? 0 : r == 3 ? d * work[2] : d / 2 * work[r - 1]);
      kith_material_state(m, 1, &rho, &u, &p, &c);
      work[r] = p / (rho * rho), push[r] = c / rho;
    }
    s->energy += d / 6 * (work[0] + 2 * work[1] + 2 * work[2] + work[3]);
    s->velocity[0] += d / 6 * (push[0] + 2 * push[1] + 2 * push[2] + push[3]);
    s->density += d;
  }
  kith_material_state(m, 1, &s->density, &s->energy, &s->pressure, &c);
}

static void check_side(const void *self, const struct kith_material *m, int k, int *shocks, int *fans) {
  const struct kith_exact_star star = kith_exact_riemann.star(self);
  const double sign = k == 0 ? -1 : 1, head = star.head[k], tail = star.tail[k],
               far = 1e-7 * (fabs(head) + 1);
  const state ahead = at(&kith_exact_riemann, self, head + sign * far, 1);
  const state behind = at(&kith_exact_riemann, self, 0.5 * (tail + star.velocity), 1);
  double p, c;
  kith_material_state(m, 1, &behind.density, &behind.energy, &p, &c);
  CHECK_CLOSE(p, behind.pressure, 1e-11 * (fabs(p) + behind.density * c * c));
  CHECK_CLOSE(behind.pressure, star.pressure, 1e-13 * (fabs(p) + behind.density * c * c));
  if (head == tail) {
    check_shock(&ahead, &behind, head);
    ++*shocks;
    return;
  }
  ++*fans;
  for (int i = 1; i <= 4; ++i) {
    const double speed = head + (tail - head) * (i < 4 ? i / 4. : 1 + 1e-9);
    const state s = at(&kith_exact_riemann, self, speed, 1);
    state followed = ahead;
    followed.velocity[0] *= sign;
    follow_isentrope(m, &followed, s.density);
    kith_material_state(m, 1, &s.density, &s.energy, &p, &c);
    const double scale = s.density * c * c;
    CHECK_CLOSE(followed.velocity[0], sign * s.velocity[0], 1e-7 * c);
    CHECK_CLOSE(followed.energy, s.energy, 1e-7 * c * c);
    CHECK_CLOSE(followed.pressure, s.pressure, 1e-7 * scale);
    CHECK_CLOSE(sign * s.velocity[0] + c, sign * speed, 1e-7 * c); /* a characteristic */
  }
}

static void test_riemann_materials(void) {
  static const char *const pairs[9][4] = {
      {"ideal", "gamma=1.6", "ideal", "gamma=1.2"},
      {"stiffened", "gamma=4.4 stiffness=0.6", "stiffened", "gamma=4.4 stiffness=0.6"},
      {"stiffened", "gamma=4.4 stiffness=0.6", "ideal", "gamma=1.4"},
      {"stiffened", "gamma=2 stiffness=3", "stiffened", "gamma=6 stiffness=0.5"},
      {"isothermal", "sound_speed=1", "isothermal", "sound_speed=3"},
      {"tait", "sound_speed=1.5", "tait", "density=2 sound_speed=4 exponent=3 pressure=0.1"},
      {"tait", "sound_speed=1.5", "isothermal", "sound_speed=1"},
      {"tait", "sound_speed=1.5", "ideal", "gamma=1.4"},
      {"stiffened", "gamma=4.4 stiffness=0.6", "isothermal", "sound_speed=1"}};
  uint64_t seed = 31;
  int shocks = 0, fans = 0;
  for (int problem = 0; problem < 360; ++problem) {
    const char *const *pair = pairs[problem % 9];
    double settings[EXACT_NUMBERS], c;
    struct kith_exact_scene scene = {.n_regions = 2};
    struct kith_material m[2];
    double tension = INFINITY; /* half of what both can bear */
    for (int k = 0; k < 2; ++k) {
      m[k] = material_of(pair[2 * k], pair[2 * k + 1]);
      tension = fmin(tension, 0.5 * m[k].eos->power_law(m[k].settings).stiffness);
    }
    for (int k = 0; k < 2; ++k) {
      struct kith_exact_region *r = &scene.region[k];
      for (int a = 0; a < NDIM; ++a) r->lower[a] = -1, r->upper[a] = 1;
      r->lower[0] = k - 1, r->upper[0] = k;
      r->density =
          (0.95 + 0.35 * check_random(&seed)) * (strstr(pair[2 * k + 1], "density=2") != NULL ? 2 : 1);
      r->velocity[0] = 0.4 * (check_random(&seed) - 0.5);
      r->energy = kith_material_energy(&m[k], r->density, pow(10, 3 * check_random(&seed) - 2) - tension);
      kith_material_state(&m[k], 1, &r->density, &r->energy, &r->pressure, &c);
      const struct kith_power_law law = m[k].eos->power_law(m[k].settings);
      r->gamma = law.gamma, r->stiffness = law.stiffness, r->barotropic = m[k].eos->barotropic;
    }
    void *self = NULL;
    CHECK_OK(kith_params_defaults(kith_exact_riemann.params, settings));
    kith_exact_riemann.derive(settings, &scene);
    CHECK_OK(kith_exact_create(&self, &kith_exact_riemann, settings));
    if (self == NULL) continue;
    for (int k = 0; k < 2; ++k) check_side(self, &m[k], k, &shocks, &fans);
    kith_free(&self);
  }
  CHECK(shocks > 100 && fans > 100);
  /* Water that is pulled apart bears tension, up to its stiffness. */
  parameters p = two_states(4.4, (const double[]){1, -0.02, 0}, (const double[]){1, 0.02, 0});
  double settings[EXACT_NUMBERS];
  void *self = NULL;
  for (int faster = 0; faster < 2; ++faster) {
    exact_fill(settings, &kith_exact_riemann, &p);
    for (int k = 0; k < 2; ++k)
      ((double *)((char *)settings + kith_params_find(kith_exact_riemann.params, "stiffness")->offset))[k] =
          0.6;
    if (faster == 0) {
      CHECK_OK(kith_exact_create(&self, &kith_exact_riemann, settings));
      CHECK_CLOSE(kith_exact_riemann.star(self).pressure, -0.02 * sqrt(4.4 * 0.6), 2e-3); /* -rho c u */
      kith_free(&self);
    } else {
      CHECK_STATUS(KITH_BAD_INPUT, kith_exact_create(&self, &kith_exact_riemann, settings));
      CHECK(self == NULL && strstr(kith_failure(), "torn") != NULL);
    }
    p.velocity[0] = -3, p.velocity[1] = 3;
  }
  /* A barotropic gas with a density has a pressure. */
  p = two_states(1.4, (const double[]){1, 0, 1}, (const double[]){0.5, 0, 0});
  exact_fill(settings, &kith_exact_riemann, &p);
  ((char *)settings)[kith_params_find(kith_exact_riemann.params, "barotropic")->offset] = 1;
  CHECK_STATUS(KITH_BAD_INPUT, kith_exact_create(&self, &kith_exact_riemann, settings));
  CHECK(self == NULL && strstr(kith_failure(), "pressure[1] is -stiffness") != NULL);
}

int main(void) {
  test_riemann_materials();
  test_riemann_table();
  test_riemann_conservation();
  test_riemann_contacts();
  test_riemann_extremes();
  test_riemann_verge();
  return check_failed();
}
