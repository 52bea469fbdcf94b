/* test_exact.c - exact solutions except riemann and sedov: against constants computed elsewhere, jump
 * conditions, Euler's equations and equations of diffusion by differences. */
#include "tests/unit/validation/exact_oracles.h"

#include <string.h>

#include "tests/unit/exact_settings.h"

typedef struct kith_exact_state state;
typedef struct exact_parameters parameters;

/* ---- radial solutions ---- */

static void test_noh(void) {
  const parameters p = {.gamma = {5. / 3}, .density = {1}, .pressure = {1e-6}, .velocity = {1}};
  const struct kith_exact_ops *const ops = &kith_exact_noh;
  void *self = NULL;
  CHECK_OK(exact_create(&self, ops, &p));
  const double plateau[] = {4, 16, 64}, pressure[] = {4. / 3, 16. / 3, 64. / 3};
  CHECK_CLOSE(ops->shock(self, 0.6), 0.2, 1e-15);
  for (int sign = -1; sign <= 1; sign += 2) {
    const state in = at(ops, self, sign * 0.1999, 0.6), out = at(ops, self, sign * 0.4, 0.6);
    CHECK_CLOSE(in.density, plateau[NDIM - 1], 1e-12);
    CHECK_CLOSE(in.pressure, pressure[NDIM - 1], 1e-12);
    CHECK_CLOSE(out.density, pow(2.5, NDIM - 1), 1e-14 * 7);
    CHECK(in.velocity[0] == 0 && out.velocity[0] == -sign && out.pressure == 1e-6);
  }
  state cold = at(ops, self, 0.2 * (1 + 1e-14), 0.6), hot = at(ops, self, 0.2 * (1 - 1e-14), 0.6);
  cold.pressure = cold.energy = 0;
  check_shock(&cold, &hot, 1. / 3);
  const state start = at(ops, self, 0, 0);
  CHECK(start.density == 1 && start.velocity[0] == 0);
  kith_free(&self);
}

/* ---- vortices ---- */

static struct kith_exact_state at_angle(const void *self, const double *center, double r, double angle,
                                        double time) {
  double x[NDIM] = {0};
  struct kith_exact_state s;
  for (int a = 0; a < NDIM; ++a) x[a] = center[a] + (a == 0 ? r * cos(angle) : a == 1 ? r * sin(angle) : 7);
  kith_exact_gresho.state(self, x, time, &s);
  return s;
}

/* The published profile, in any direction and at any height of a column; and the balance of pressure and
 * rotation. */
static void test_gresho_profile(void) {
  static const double radius[] = {0, 0.1, 0.2, 0.3, 0.4, 0.6}, speed[] = {0, 0.5, 1, 0.5, 0, 0};
  const double pressure[] = {5, 5.125, 5.5, 4.125 + 4 * log(1.5), 5.7725887222397812, 5.7725887222397812};
  parameters p = {.gamma = {5. / 3}, .density = {1}, .pressure = {5}};
  for (int a = 0; a < NDIM; ++a) p.center[a] = 0.25 * (a + 1);
  void *self = NULL;
  CHECK_OK(exact_create(&self, &kith_exact_gresho, &p));
  CHECK(kith_exact_gresho.vortex && kith_exact_gresho.shock == NULL);
  CHECK(kith_exact_about(&kith_exact_gresho, self)->center[NDIM - 1] == p.center[NDIM - 1]);
  for (int k = 0; k < 6; ++k)
    for (int turn = 0; turn < 7; ++turn) {
      const state s = at_angle(self, p.center, radius[k], 0.9 * turn, 2.5 * turn);
      const double c = cos(0.9 * turn), d = sin(0.9 * turn), v[3] = {s.velocity[0], s.velocity[NDIM > 1], 0};
      /* tolerance: a few roundings of numbers of order 1, also below */
      CHECK_CLOSE(-v[0] * d + v[1] * c, speed[k], 1e-14);
      CHECK_CLOSE(v[0] * c + v[1] * d, 0, 1e-14);
      CHECK(NDIM < 3 || s.velocity[NDIM - 1] == 0);
      CHECK_CLOSE(s.pressure, pressure[k], 1e-14 * 6);
      CHECK(s.density == 1);
      CHECK_CLOSE(s.energy, 1.5 * pressure[k], 1e-14 * 9);
    }
  /* dP/dr = rho v^2 / r by differences, away from kinks; truncation is d^2 P''' / 6 with P''' = 8 / r^3,
   * round-off about 1e-15 P / d. */
  for (int k = 1; k < 50; ++k) {
    const double r = 0.01 * k + 0.005, d = 1e-5;
    const state s = at_angle(self, p.center, r, 0.3, 0), e = at_angle(self, p.center, r + d, 0.3, 0),
                w = at_angle(self, p.center, r - d, 0.3, 0);
    double v2 = 0;
    for (int a = 0; a < NDIM; ++a) v2 += s.velocity[a] * s.velocity[a];
    CHECK_CLOSE((e.pressure - w.pressure) / (2 * d), v2 / r, 1.01 * d * d * 8 / (6 * r * r * r) + 2e-9);
  }
  kith_free(&self);
}

/* Twice the density has twice the pressure differences. A vortex that is carried leaves at one face and
 * enters at the other. */
static void test_gresho_carried(void) {
  parameters still = {.gamma = {1.4}, .density = {2}, .pressure = {3}}, moving = still;
  void *a = NULL, *b = NULL;
  for (int k = 0; k < NDIM; ++k) moving.uniform_velocity[k] = k == 0 ? 3 : -0.5, moving.period[k] = 1;
  CHECK_OK(exact_create(&a, &kith_exact_gresho, &still));
  CHECK_OK(exact_create(&b, &kith_exact_gresho, &moving));
  CHECK_CLOSE(at(&kith_exact_gresho, a, 0.2, 0).pressure, 3 + 2 * 0.5, 1e-14);
  uint64_t seed = 4;
  for (int k = 0; k < 200; ++k) {
    double x[NDIM], y[NDIM];
    const double time = 0.1 * k;
    state s, t;
    for (int c = 0; c < NDIM; ++c) {
      x[c] = check_random(&seed) - 0.5;
      y[c] = x[c] + moving.uniform_velocity[c] * time;
      y[c] -= floor(y[c] + 0.5);
    }
    kith_exact_gresho.state(a, x, 0, &s);
    kith_exact_gresho.state(b, y, time, &t);
    /* the position is rounded to about 60 lengths; slopes are up to 5 */
    for (int c = 0; c < NDIM; ++c)
      CHECK_CLOSE(t.velocity[c], s.velocity[c] + moving.uniform_velocity[c], 1e-12);
    CHECK_CLOSE(t.pressure, s.pressure, 1e-12);
  }
  KITH_FREE(&a, &b);
}

/* Position and speed that are compared: along axis 0, outwards, around the axis. */
static void test_places_and_speeds(void) {
  const double x[3] = {4, 6, 15}, v[3] = {2, -1, 0.5};
  struct kith_exact_gas about = {.gamma = 2};
  for (int a = 0; a < NDIM; ++a) about.center[a] = 1 + a;
  const double radial[] = {3, 5, 13}, outwards[] = {2, 0.4, 8. / 13};
  CHECK(kith_exact_place(&kith_exact_riemann, NULL, x, 0) == 4 &&
        kith_exact_speed(&kith_exact_riemann, NULL, x, 0, v) == 2);
  CHECK_CLOSE(kith_exact_place(&kith_exact_noh, &about, x, 0), radial[NDIM - 1], 1e-14);
  CHECK_CLOSE(kith_exact_speed(&kith_exact_noh, &about, x, 0, v), outwards[NDIM - 1], 1e-14);
  CHECK(kith_exact_speed(&kith_exact_noh, &about, about.center, 0, v) == 0);
  if (NDIM == 1) return;
  CHECK_CLOSE(kith_exact_place(&kith_exact_gresho, &about, x, 0), 5, 1e-14); /* at any height */
  CHECK_CLOSE(kith_exact_speed(&kith_exact_gresho, &about, x, 0, v), (3 * -1 - 4 * 2) / 5., 1e-14);
  CHECK(kith_exact_speed(&kith_exact_gresho, &about, about.center, 0, v) == 0);
}

/* ---- smooth solutions ---- */

/* The residuals of Euler's equations are of the order of the amplitude squared. */
static void test_acoustic_wave(void) {
  const struct kith_exact_ops *const ops = kith_exact_find("acoustic_wave");
  CHECK(ops == &kith_exact_acoustic_wave && ops->shock == NULL);
  parameters p = {.gamma = {5. / 3},
                  .density = {2},
                  .pressure = {3},
                  .amplitude = 1e-6,
                  .wavelength = 0.5,
                  .origin = 0.1,
                  .uniform_velocity = {0.7}};
  void *self = NULL;
  CHECK_OK(exact_create(&self, ops, &p));
  const double c = sqrt(5. / 3 * 3 / 2), d = 1e-4;
  const state crest = at(ops, self, 0.1 + 0.125, 0);
  CHECK_CLOSE(crest.density, 2 * (1 + 1e-6), 1e-15);
  CHECK_CLOSE(crest.velocity[0], 0.7 + 1e-6 * c, 1e-15);
  CHECK_CLOSE(at(ops, self, 0.1 + 0.125 + (c + 0.7) * 3.3, 3.3).density, crest.density, 1e-14); /* travels */
  CHECK_CLOSE(at(ops, self, 0.6 + 0.125, 0).density, crest.density, 1e-15);                     /* repeats */
  for (int i = 0; i < 8; ++i) {
    const double x = 0.3 + 0.06 * i;
    const state s = at(ops, self, x, 1), e = at(ops, self, x + d, 1), w = at(ops, self, x - d, 1);
    const state n = at(ops, self, x, 1 + d), q = at(ops, self, x, 1 - d);
    const double u = s.velocity[0], ux = (e.velocity[0] - w.velocity[0]) / (2 * d);
    /* Terms are of order 1e-6 (2 pi / 0.5). A^2, differences (d k)^2 / 6 and round-off / d sum to 1e-11. */
    CHECK_CLOSE((n.density - q.density + u * (e.density - w.density)) / (2 * d) + s.density * ux, 0, 2e-10);
    CHECK_CLOSE(
        (n.velocity[0] - q.velocity[0]) / (2 * d) + u * ux + (e.pressure - w.pressure) / (2 * d * s.density),
        0, 2e-10);
    CHECK_CLOSE(
        (n.pressure - q.pressure + u * (e.pressure - w.pressure)) / (2 * d) + 5. / 3 * s.pressure * ux, 0,
        1e-9);
  }
  kith_free(&self);
}

static void test_uniform(void) {
  parameters p = {.gamma = {1.4}, .density = {2}, .pressure = {3}};
  for (int a = 0; a < NDIM; ++a) p.uniform_velocity[a] = a + 1;
  void *self = NULL;
  CHECK_OK(exact_create(&self, &kith_exact_uniform, &p));
  const state s = at(&kith_exact_uniform, self, 7, 9);
  CHECK(s.density == 2 && s.pressure == 3 && s.velocity[NDIM - 1] == NDIM);
  CHECK_CLOSE(s.energy, 3.75, 1e-15);
  kith_free(&self);
}

/* ---- the family ---- */

static parameters valid_parameters(void) {
  return (parameters){.gamma = {1.4, 1.4},
                      .density = {1, 1},
                      .velocity = {1, 0},
                      .pressure = {1, 1},
                      .amplitude = 0.01,
                      .wavelength = 1};
}

/* Refused, with a message that names the solution, the parameter and its value. */
static void check_refused(const struct kith_exact_ops *ops, parameters p, const char *name,
                          const char *value) {
  void *self = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, exact_create(&self, ops, &p));
  CHECK(self == NULL);
  CHECK(strstr(kith_failure(), name) != NULL && strstr(kith_failure(), ops->name) != NULL);
  CHECK(strstr(kith_failure(), value) != NULL && strstr(kith_failure(), "must be") != NULL);
}

/* Values that do not fit together; single values are tested for all solutions by conformance_exact.c. */
static void test_refusals(void) {
  parameters p = valid_parameters();
  p.amplitude = 0.8, check_refused(&kith_exact_acoustic_wave, p, "amplitude", "0.8");
  p = valid_parameters(), p.density[1] = 0, check_refused(&kith_exact_riemann, p, "pressure[1]", "is 1,");
  p = valid_parameters(), p.density[0] = p.density[1] = p.pressure[0] = p.pressure[1] = 0;
  check_refused(&kith_exact_riemann, p, "density[1]", "is 0,");
}

/* ---- solutions that are carried: density waves, squares, vortices ---- */

static void test_carried(void) {
  parameters p = {.gamma = {1.4},
                  .density = {2, 1},
                  .pressure = {2.5},
                  .amplitude = 0.5,
                  .wavelength = 2,
                  .origin = 0.25};
  for (int a = 0; a < NDIM; ++a)
    p.uniform_velocity[a] = 0.5, p.side[a] = 0.5, p.center[a] = 0.5, p.period[a] = 1;
  void *wave = NULL, *square = NULL;
  CHECK_OK(exact_create(&wave, &kith_exact_entropy_wave, &p));
  /* a quarter of a wave from the origin */
  CHECK_CLOSE(at(&kith_exact_entropy_wave, wave, 0.75, 0).density, 3, 1e-14);
  CHECK_CLOSE(at(&kith_exact_entropy_wave, wave, 0.75, 4).density, 3, 1e-14); /* carried by one wavelength */
  CHECK_CLOSE(at(&kith_exact_entropy_wave, wave, 1.0, 0.5).density, 3, 1e-14);
  CHECK_CLOSE(at(&kith_exact_entropy_wave, wave, 1.75, 0).density, 1, 1e-14);
  for (int i = 1; i < 20; ++i) check_euler(&kith_exact_entropy_wave, wave, 0.1 * i, 0.3, 0.2, 1.4, 1);
  kith_free(&wave);
  CHECK_OK(exact_create(&square, &kith_exact_square, &p));
  double x[NDIM];
  state s;
  for (int a = 0; a < NDIM; ++a) x[a] = 0.26;
  kith_exact_square.state(square, x, 0, &s);
  CHECK(s.density == 2 && s.pressure == 2.5 && s.velocity[NDIM - 1] == 0.5 &&
        s.energy == 2.5 / 2 / (1.4 - 1));
  kith_exact_square.state(square, x, 0.04, &s); /* its edge is at 0.27 now */
  CHECK(s.density == 1);
  kith_exact_square.state(square, x, 2, &s); /* back at its start */
  CHECK(s.density == 2);
  x[NDIM - 1] = 0.24;
  kith_exact_square.state(square, x, 0, &s);
  CHECK(s.density == 1);
  x[NDIM - 1] = 2.74;
  kith_exact_square.state(square, x, 0, &s);
  CHECK(s.density == 2); /* the period is 1 */
  kith_free(&square);
}

/* Pressure balances rotation, the entropy is uniform, and far away gas is at rest. */
static void test_yee(void) {
  parameters p = {.gamma = {1.4}, .amplitude = 5};
  void *self = NULL;
  CHECK_OK(exact_create(&self, &kith_exact_yee, &p));
  for (int i = 1; i < 40; ++i) {
    const double r = 0.1 * i, h = 1e-5;
    const state s = at(&kith_exact_yee, self, r, 3);
    const double v = s.velocity[NDIM > 1], rise = at(&kith_exact_yee, self, r + h, 3).pressure -
                                                  at(&kith_exact_yee, self, r - h, 3).pressure;
    CHECK_CLOSE(rise / (2 * h), s.density * v * v / r, 1e-9); /* truncation h^2, round-off 1e-16 / h */
    CHECK_CLOSE(s.pressure, pow(s.density, 1.4), 1e-14);
    CHECK(s.velocity[0] == 0 && v > 0);
  }
  CHECK_CLOSE(at(&kith_exact_yee, self, 1, 0).velocity[NDIM > 1], 5 / (2 * M_PI), 1e-15); /* b r / 2 pi */
  CHECK_CLOSE(at(&kith_exact_yee, self, 0, 0).pressure, pow(1 - 10 * M_E / (11.2 * M_PI * M_PI), 3.5), 1e-14);
  const state far = at(&kith_exact_yee, self, 9, 0);
  CHECK_CLOSE(far.density, 1, 1e-15);
  CHECK_CLOSE(far.velocity[NDIM > 1], 0, 1e-15);
  kith_free(&self);
  p.amplitude = 20; /* negative temperature at the center */
  CHECK_STATUS(KITH_BAD_INPUT, exact_create(&self, &kith_exact_yee, &p));
}

/* ---- the two blasts: a table of a numerical reference ---- */

static void test_two_blasts(void) {
  const struct kith_exact_ops *ops = &kith_exact_two_blasts;
  parameters p = {.gamma = {1.4}, .end_time = 0.01};
  void *self = NULL, *left = NULL;
  if (NDIM > 1) return; /* the same in every dimension, and slow */
  CHECK_OK(exact_create(&self, ops, &p));
  CHECK(at(ops, self, 0.05, 0).pressure == 1000 && at(ops, self, 0.5, 0).pressure == 0.01);
  CHECK(at(ops, self, 0.95, 0).pressure == 100 && at(ops, self, 0.95, 0).density == 1);
  /* Until the waves meet or return from the walls, the left one is a Riemann problem. */
  const parameters tube = {
      .gamma = {1.4, 1.4}, .density = {1, 1}, .pressure = {1000, .01}, .interface_position = .1};
  CHECK_OK(exact_create(&left, &kith_exact_riemann, &tube));
  for (int i = 0; i <= 20; ++i) { /* between contact and shock, except a cell or two at both */
    const double contact = 0.1 + 19.5975 * 0.005, shock = 0.1 + 23.5175 * 0.005;
    const double x = contact + 0.004 + (shock - contact - 0.008) * i / 20;
    const state s = at(ops, self, x, 0.005), e = at(&kith_exact_riemann, left, x, 0.005);
    CHECK_CLOSE(s.pressure, e.pressure, 0.002 * e.pressure); /* ripples behind the shock */
    CHECK_CLOSE(s.density, e.density, 0.01 * e.density);
    CHECK_CLOSE(s.velocity[0], e.velocity[0], 0.002 * e.velocity[0]);
    CHECK(at(ops, self, shock + 0.005 + 0.01 * i, 0.005).pressure == 0.01); /* undisturbed */
  }
  kith_free(&left);
  /* between two stored times, and after the last */
  const state late = at(ops, self, 0.3, 1), last = at(ops, self, 0.3, 0.01);
  CHECK(late.density == last.density && late.pressure == last.pressure);
  CHECK(at(ops, self, -1, 0.01).density > 0 && at(ops, self, 2, 0.005).density > 0);
  kith_free(&self);
  p.end_time = -1, check_refused(ops, p, "end_time", "-1");
  p.end_time = 1e9; /* too many steps */
  CHECK_STATUS(KITH_BAD_INPUT, exact_create(&self, ops, &p));
}

/* ---- diffusion ---- */

static double energy_at(const struct kith_exact_ops *ops, const void *self, double x, double time) {
  return at(ops, self, x, time).energy;
}
static double transverse_at(const struct kith_exact_ops *ops, const void *self, double x, double time) {
  return at(ops, self, x, time).velocity[NDIM > 1];
}

/* dA/dt = diffusivity d^2A/dx^2 + heated (dv/dx)^2 by differences: truncation (pi h)^2 / 12 = 8e-9,
 * round-off 1e-16 / h^2 = 1e-8. */
static void check_diffusion_equation(double (*value)(const struct kith_exact_ops *, const void *, double,
                                                     double),
                                     const struct kith_exact_ops *ops, const void *self, double diffusivity,
                                     double heated) {
  const double h = 1e-4, t = 0.3;
  for (double x = -0.91; x < 1; x += 0.17) {
    const double here = value(ops, self, x, t);
    const double rate = (value(ops, self, x, t + h) - value(ops, self, x, t - h)) / (2 * h);
    const double bend = (value(ops, self, x + h, t) - 2 * here + value(ops, self, x - h, t)) / (h * h);
    const double shear = (transverse_at(ops, self, x + h, t) - transverse_at(ops, self, x - h, t)) / (2 * h);
    CHECK_CLOSE(rate, diffusivity * bend + heated * shear * shear, 1e-7);
  }
}

static void check_decaying_wave(const char *wanted, double viscosity) {
  const struct kith_exact_ops *ops = &kith_exact_decaying_wave;
  void *settings, *wave;
  CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_exact_member, ops->name), wanted));
  CHECK_OK(kith_exact_create(&wave, ops, settings));
  CHECK_CLOSE(energy_at(ops, wave, 1, 0), 3.5, 1e-15);
  CHECK_CLOSE(at(ops, wave, 1, 7).density, 2, 0);
  check_diffusion_equation(energy_at, ops, wave, 0.2, viscosity);
  if (NDIM > 1) check_diffusion_equation(transverse_at, ops, wave, viscosity, 0);
  if (NDIM > 1) CHECK_CLOSE(transverse_at(ops, wave, 1, 0), 0.4, 1e-15);
  if (NDIM > 1) CHECK_CLOSE(energy_at(ops, wave, 1, 1e3), 3 + 0.25 * 0.4 * 0.4, 1e-14); /* all is heat */
  KITH_FREE(&wave, &settings);
}

/* With viscosity 0.4 both exponentials of the heat of the shear wave are the same. */
static void test_decaying_wave(void) {
#define WAVE(viscosity)                                                       \
  check_decaying_wave(                                                        \
      "density=2 pressure=1 energy=3 energy_amplitude=0.5 diffusivity=0.2 "   \
      "velocity_amplitude=0.4 wavelength=2 origin=0.5 viscosity=" #viscosity, \
      NDIM > 1 ? viscosity : 0)
  WAVE(0.1);
  WAVE(0.4);
  WAVE(0.7);
#undef WAVE
}

/* A wall that runs to the left has the mirror image of the shock before one that runs to the right; mass,
 * momentum and energy pass it unchanged. */
static void test_hugoniot(void) {
  const struct kith_exact_ops *ops = &kith_exact_hugoniot;
  const struct kith_member member = kith_family_member(kith_exact_member, ops->name);
  void *settings[2], *self[2];
  CHECK_OK(kith_settings_create(&settings[0], member,
                                "density=9 sound_speed=4 slope=1.5 velocity=0.5 interface_position=2"));
  CHECK_OK(kith_settings_create(&settings[1], member,
                                "density=9 sound_speed=4 slope=1.5 velocity=-0.5 interface_position=-2"));
  for (int k = 0; k < 2; ++k) CHECK_OK(kith_exact_create(&self[k], ops, settings[k]));
  CHECK_CLOSE(ops->shock(self[0], 0.1), 2 + 0.475, 1e-14);
  CHECK_CLOSE(ops->shock(self[1], 0.1), -2 - 0.475, 1e-14);
  for (double x = 2.03; x < 3; x += 0.04) {
    const struct kith_exact_state right = at(ops, self[0], x, 0.1), left = at(ops, self[1], -x, 0.1);
    CHECK(left.density == right.density && left.pressure == right.pressure && left.energy == right.energy &&
          left.velocity[0] == -right.velocity[0]);
    CHECK((right.density > 9) == (x < 2.475));
  }
  const struct kith_exact_state behind = at(ops, self[0], 2.4, 0.1);
  CHECK_CLOSE(behind.density * (4.75 - 0.5), 9 * 4.75, 1e-13);
  CHECK_CLOSE(behind.pressure, 9 * 4.75 * 0.5, 1e-13);
  CHECK_CLOSE(behind.energy, 0.5 * behind.pressure * (1 / 9. - 1 / behind.density), 1e-14);
  for (int k = 0; k < 2; ++k) kith_free(&self[k]), kith_free(&settings[k]);
}

/* At the contact temperature and heat flux are continuous, and no heat is lost. */
static void test_slabs(void) {
  const struct kith_exact_ops *ops = &kith_exact_slabs;
  const double d = 1e-5, heat[2] = {0.5 * 2, 4 * 0.25}; /* density times c_v */
  const double conductivity[2] = {0.3, 0.02};
  void *settings, *slabs;
  CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_exact_member, ops->name),
                                "density=0.5,4 pressure=1 energy=6,0.5 conductivity=0.3,0.02 "
                                "specific_heat=2,0.25 interface_position=0.02"));
  CHECK_OK(kith_exact_create(&slabs, ops, settings));
  CHECK(energy_at(ops, slabs, 0.01, 0) == 6 && energy_at(ops, slabs, 0.03, 0) == 0.5);
  const double left[] = {energy_at(ops, slabs, 0.02 - d, 0.3) / 2,
                         energy_at(ops, slabs, 0.02 - 2 * d, 0.3) / 2};
  const double right[] = {energy_at(ops, slabs, 0.02 + d, 0.3) / 0.25,
                          energy_at(ops, slabs, 0.02 + 2 * d, 0.3) / 0.25};
  CHECK_CLOSE(2 * left[0] - left[1], 2 * right[0] - right[1], 1e-11);
  CHECK_CLOSE(conductivity[0] * (left[1] - left[0]), conductivity[1] * (right[0] - right[1]), 1e-8 * d);
  double lost = 0;
  for (double x = -4 + 0.0005; x < 4; x += 0.001) {
    const int side = x > 0.02;
    const double c = side ? 0.25 : 2, now = energy_at(ops, slabs, x, 0.3), then = energy_at(ops, slabs, x, 0);
    lost += heat[side] / c * (now - then) * 0.001;
  }
  CHECK_CLOSE(lost, 0, 1e-6); /* a sum over the middles of cells, one of which has the jump */
  CHECK(at(ops, slabs, 0.5, 1).density == 4);
  KITH_FREE(&slabs, &settings);
}

int main(void) {
  test_noh();
  if (NDIM > 1) { /* conformance_exact.c tests that vortices are refused in 1-D */
    test_gresho_profile();
    test_gresho_carried();
    test_yee();
  }
  test_places_and_speeds();
  test_acoustic_wave();
  test_uniform();
  test_carried();
  test_two_blasts();
  test_decaying_wave();
  test_hugoniot();
  test_slabs();
  test_refusals();
  return check_failed();
}
