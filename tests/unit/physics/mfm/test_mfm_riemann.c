/* test_mfm_riemann.c - the approximate Riemann solver of package mfm. Oracle: the exact solver
 * (validation/exact), and limits that are known: contacts, cold gas, vacuum, isothermal and stiffened gas. */
#include "physics/mfm/riemann.h"
#include "tests/check.h"
#include "tests/unit/exact_settings.h"

static struct mfm_side make_side(double density, double velocity, double pressure, double gamma) {
  return (struct mfm_side){density, velocity, pressure, sqrt(gamma * pressure / density), gamma, 1 / gamma};
}

static struct kith_exact_star exact_star(struct mfm_side l, struct mfm_side r) {
  const struct exact_parameters p = {.gamma = {l.gamma, r.gamma},
                                     .density = {l.density, r.density},
                                     .velocity = {l.velocity, r.velocity},
                                     .pressure = {l.pressure, r.pressure}};
  void *self;
  CHECK_OK(exact_create(&self, &kith_exact_riemann, &p));
  const struct kith_exact_star star = kith_exact_riemann.star(self);
  kith_free(&self);
  return star;
}

/* Discontinuities of shock tubes, as a run has them in its first steps only. The tolerances are the measured
 * errors of P* (relative) and of S* (relative to the velocities of the problem), rounded up. */
static void check_tubes(void) {
  const struct {
    double left[3], right[3], gamma, pressure, velocity;
  } tube[] = {
      {{1, 0, 1}, {.125, 0, .1}, 1.4, 0.03, 0.015},    /* Sod */
      {{1, 0, 1}, {.125, 0, .1}, 5. / 3, 0.03, 0.01},  /* Sod, gamma 5/3 */
      {{1, 0, 1}, {.25, 0, .1795}, 1.4, 0.006, 0.002}, /* weaker than Sod */
      {{1, -2, .4}, {1, 2, .4}, 1.4, 0.2, 1e-15},      /* 1-2-3: P* is 0.005 of P */
      {{1, 0, 1000}, {1, 0, .01}, 1.4, 0.08, 0.02},    /* a blast */
      {{1, 0, .01}, {1, 0, 100}, 1.4, 0.08, 0.02},     /* a blast from the right */
      {{5.99924, 19.5975, 460.894}, {5.99242, -6.19633, 46.095}, 1.4, 0.02, 0.05}, /* two shocks */
      {{.445, .698, 3.528}, {.5, 0, .571}, 1.4, 0.004, 0.002},                     /* Lax */
      {{1, 0.1, 1}, {1, -0.1, 1}, 1.4, 1e-14, 1e-15}, /* equal gases collide: exact */
      {{1, -0.5, 1}, {1, 0.5, 1}, 1.4, 1e-3, 1e-15},  /* equal gases separate */
  };
  for (size_t k = 0; k < sizeof tube / sizeof tube[0]; ++k) {
    const struct mfm_side l = make_side(tube[k].left[0], tube[k].left[1], tube[k].left[2], tube[k].gamma);
    const struct mfm_side r = make_side(tube[k].right[0], tube[k].right[1], tube[k].right[2], tube[k].gamma);
    const struct kith_exact_star want = exact_star(l, r);
    const struct mfm_star got = mfm_riemann(l, r);
    const double scale = fabs(l.velocity) + fabs(r.velocity) + fmax(l.sound, r.sound);
    CHECK_CLOSE(got.pressure / want.pressure, 1, tube[k].pressure);
    CHECK_CLOSE((got.velocity - want.velocity) / scale, 0, tube[k].velocity);
  }
}

/* Random states within a factor exp(`spread`) of each other, with two gammas. */
static void check_random_states(double spread, double mean_bound, double most_bound) {
  uint64_t seed = 1;
  double mean = 0, most = 0;
  enum { STATES = 500 };
  for (int k = 0; k < STATES; ++k) {
    struct mfm_side s[2];
    for (int e = 0; e < 2; ++e) {
      const double density = exp(spread * (check_random(&seed) - 0.5));
      const double pressure = exp(2 * spread * (check_random(&seed) - 0.5));
      s[e] = make_side(density, spread * sqrt(pressure / density) * (check_random(&seed) - 0.5), pressure,
                       1.2 + 0.6 * check_random(&seed));
    }
    const struct kith_exact_star want = exact_star(s[0], s[1]);
    const double error = fabs(mfm_riemann(s[0], s[1]).pressure / want.pressure - 1);
    mean += error / STATES;
    most = fmax(most, error);
  }
  CHECK_CLOSE(mean, 0, mean_bound);
  CHECK_CLOSE(most, 0, most_bound);
}

/* Exchanged and mirrored sides give the mirrored result, and a contact stays as it is, to the last bit. */
static void check_symmetry(void) {
  uint64_t seed = 5;
  for (int k = 0; k < 200; ++k) {
    const struct mfm_side l = make_side(check_random(&seed) + 0.01, 4 * check_random(&seed) - 2,
                                        check_random(&seed), 1.1 + check_random(&seed));
    const struct mfm_side r = make_side(100 * check_random(&seed) + 0.01, 4 * check_random(&seed) - 2,
                                        check_random(&seed), 1.1 + check_random(&seed));
    struct mfm_side back_l = r, back_r = l, still = r;
    back_l.velocity = -r.velocity, back_r.velocity = -l.velocity;
    const struct mfm_star there = mfm_riemann(l, r), back = mfm_riemann(back_l, back_r);
    CHECK(there.pressure == back.pressure && there.velocity == -back.velocity);
    still.velocity = l.velocity, still.pressure = l.pressure;
    const struct mfm_star contact = mfm_riemann(l, still);
    CHECK(contact.pressure == l.pressure && contact.velocity == l.velocity);
  }
}

/* Cold gas against cold gas: P* = (gamma + 1) / 2 rho w^2, where w is the speed of the gas relative to the
 * contact, which two equal streams share. */
static void check_cold(void) {
  for (double pressure = 1e-2; pressure > 1e-30; pressure *= 1e-4) {
    const struct mfm_star star = mfm_riemann(make_side(2, 3, pressure, 1.4), make_side(2, -3, pressure, 1.4));
    /* weaker shocks differ from the strong limit by at most rho w c */
    CHECK_CLOSE(star.pressure, 1.2 * 2 * 9, 2 * 3 * sqrt(1.4 * pressure / 2) + 2 * pressure + 1e-14);
    CHECK(star.velocity == 0);
  }
  const struct mfm_star none = mfm_riemann(make_side(2, 3, 0, 1.4), make_side(2, -3, 0, 1.4));
  CHECK_CLOSE(none.pressure, 1.2 * 2 * 9, 1e-14);
  const struct mfm_star apart = mfm_riemann(make_side(2, -3, 0, 1.4), make_side(1, 3, 0, 1.4));
  CHECK(apart.pressure == 0 && isfinite(apart.velocity));
  const struct mfm_star rest = mfm_riemann(make_side(2, 1, 0, 1.4), make_side(1, 1, 0, 1.4));
  CHECK(rest.pressure == 0 && rest.velocity == 1);
}

/* Gases that separate faster than they can expand leave a vacuum; below that speed the pressure is small. */
static void check_vacuum(void) {
  for (double speed = 0.5; speed < 1e6; speed *= 1.7) {
    const struct mfm_star star = mfm_riemann(make_side(1, -speed, 1, 5. / 3), make_side(1, speed, 1, 5. / 3));
    CHECK(star.pressure >= -1e-15 && star.velocity == 0); /* P - rho c^2 / gamma is rounded */
    if (speed > 3.9) CHECK(star.pressure <= 1e-14);       /* 2 c / (gamma - 1) = 3.87 */
  }
}

/* A stiffened gas is an ideal one with P + P0 instead of P. */
static void check_stiffened(void) {
  const double stiffness = 3;
  struct mfm_side l = make_side(1, 0.7, 5, 2.5), r = make_side(0.4, -0.2, 3.5, 2.5);
  const struct mfm_star ideal = mfm_riemann(l, r);
  l.pressure -= stiffness, r.pressure -= stiffness;
  const struct mfm_star stiff = mfm_riemann(l, r);
  CHECK_CLOSE(stiff.pressure + stiffness, ideal.pressure, 1e-14);
  CHECK_CLOSE(stiff.velocity, ideal.velocity, 1e-15);
  l.velocity = -1e3, r.velocity = 1e3; /* torn apart: tension, but not below -P0 */
  CHECK_CLOSE(mfm_riemann(l, r).pressure, -stiffness, 1e-14);
}

static double mass_flux(struct mfm_side s, double w) {
  const double cx = fmax(-s.gamma * w, 1e-5 * s.sound);
  return mfm_mass_flux(s, w, s.sound, cx / s.sound, 1 / cx);
}

/* gamma = 1 is an isothermal gas: in a shock q^2 = rho P*, in a rarefaction P* = P exp(w / c). */
static void check_isothermal(void) {
  const struct mfm_side gas = {2, 0, 2 * 1.5 * 1.5, 1.5, 1, 1};
  for (double w = 0.1; w < 20; w *= 2) {
    const double q = mass_flux(gas, w);
    CHECK_CLOSE(q * q / (2 * (gas.pressure + q * w)), 1, 1e-14);
  }
  for (double w = 0.1; w < 1; w *= 2) /* the cubic term is too small by x^3 / 192 */
    CHECK_CLOSE((gas.pressure - mass_flux(gas, -w) * w) / (gas.pressure * exp(-w / 1.5)), 1,
                pow(w / 1.5, 3) / 100);
}

int main(void) {
  check_tubes();
  check_random_states(0.1, 2e-6, 4e-5);
  check_random_states(1, 2e-3, 4e-2);
  check_symmetry();
  check_cold();
  check_vacuum();
  check_stiffened();
  check_isothermal();
  return check_failed();
}
