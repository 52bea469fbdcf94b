/* Equations of state against thermodynamics: P = rho^2 du/drho and c^2 = dP/drho along an isentrope, both by
 * differences. */
#include <string.h>
#include "physics/eos.h"
#include "tests/check.h"

static const struct kith_eos_parameters cases[] = {{.gamma = 1.4, .sound_speed = 0.7, .stiffness = 0},
                                                   {.gamma = 5. / 3, .sound_speed = 3, .stiffness = 0.5},
                                                   {.gamma = 4.4, .sound_speed = 100, .stiffness = 6}};

static void state(const struct kith_eos_ops *eos, const struct kith_eos_parameters *p, double density,
                  double energy, double *pressure, double *sound_speed) {
  eos->state(p, 1, &density, &energy, pressure, sound_speed);
}

/* u along the isentrope du = P / rho^2 drho from (density, energy) to `to`, by one step of Runge and Kutta's
 * fourth order. */
static double isentrope(const struct kith_eos_ops *eos, const struct kith_eos_parameters *p, double density,
                        double energy, double to) {
  const double d = to - density, rho[] = {density, density + d / 2, density + d / 2, to};
  double k[4], pressure, c;
  for (int s = 0; s < 4; ++s) {
    state(eos, p, rho[s], energy + (s == 0 ? 0 : s == 3 ? d * k[2] : d / 2 * k[s - 1]), &pressure, &c);
    k[s] = pressure / (rho[s] * rho[s]);
  }
  return energy + d / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]);
}

static void check_sound_speed(const struct kith_eos_ops *eos, const struct kith_eos_parameters *p) {
  uint64_t seed = 3;
  for (int s = 0; s < 50; ++s) {
    const double density = pow(10, 4 * check_random(&seed) - 2), d = 1e-4 * density;
    double pressure, c, above, below, unused;
    const double energy = eos->energy(p, density, 10 * check_random(&seed));
    state(eos, p, density, energy, &pressure, &c);
    state(eos, p, density + d, isentrope(eos, p, density, energy, density + d), &above, &unused);
    state(eos, p, density - d, isentrope(eos, p, density, energy, density - d), &below, &unused);
    /* Truncation (d / rho)^2 times a cubic in gamma; cancellation 1e-16 / 1e-4 of the terms of P, gamma P0
     * among them. */
    CHECK_CLOSE((above - below) / (2 * d), c * c, 1e-6 * c * c + 1e-10 * p->gamma * p->stiffness / density);
  }
}

static void check_round_trip(const struct kith_eos_ops *eos, const struct kith_eos_parameters *p) {
  for (double density = 1e-3; density < 2e3; density *= 10)
    for (double wanted = 0; wanted < 2e3; wanted = 10 * wanted + 1e-3) {
      double pressure, c;
      state(eos, p, density, eos->energy(p, density, wanted), &pressure, &c);
      /* Stiffened: P is a difference of terms as large as gamma P0. */
      if (eos != &kith_eos_isothermal)
        CHECK_CLOSE(pressure, wanted, 1e-15 * 4 * (wanted + p->gamma * p->stiffness));
      CHECK(c >= 0 && isfinite(c));
    }
}

/* Numbers by hand. */
static void check_values(void) {
  const struct kith_eos_parameters p = {.gamma = 1.5, .sound_speed = 2, .stiffness = 3};
  const double density[] = {2, 4, 1}, energy[] = {6, 0, -1};
  double pressure[3], c[3];
  kith_eos_ideal.state(&p, 3, density, energy, pressure, c);
  CHECK_CLOSE(pressure[0], 6, 1e-15);
  CHECK_CLOSE(c[0], sqrt(4.5), 1e-15);
  CHECK(pressure[1] == 0 && c[1] == 0);
  CHECK(pressure[2] == -0.5 && c[2] == 0); /* out of range: c^2 < 0 */
  kith_eos_isothermal.state(&p, 3, density, energy, pressure, c);
  for (int k = 0; k < 3; ++k) CHECK(pressure[k] == 4 * density[k] && c[k] == 2);
  CHECK(kith_eos_isothermal.energy(&p, 2, 8) == 0);
  kith_eos_stiffened.state(&p, 3, density, energy, pressure, c);
  CHECK_CLOSE(pressure[0], 1.5, 1e-14);
  CHECK_CLOSE(c[0], sqrt(1.5 * 4.5 / 2), 1e-14);
  CHECK_CLOSE(pressure[1], -4.5, 1e-14); /* tension: P + P0 < 0, and c^2 < 0 */
  CHECK(c[1] == 0);
  CHECK(kith_eos_ideal.energy_positive && kith_eos_stiffened.energy_positive &&
        !kith_eos_isothermal.energy_positive);
  kith_eos_ideal.state(&p, 0, density, energy, NULL, NULL); /* nothing to do */
}

static void check_names(void) {
  int n = 0;
  for (const struct kith_eos_ops *const *all = kith_eos_all(); *all != NULL; ++all, ++n) {
    CHECK(kith_eos_find((*all)->name) == *all);
    CHECK((*all)->doc != NULL && (*all)->doc[0] != '\0');
  }
  CHECK(n == 3);
  CHECK(kith_eos_find("ideal") == &kith_eos_ideal && kith_eos_find("none") == NULL &&
        kith_eos_find("") == NULL);
}

int main(void) {
  check_names();
  check_values();
  for (const struct kith_eos_ops *const *all = kith_eos_all(); *all != NULL; ++all)
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k) {
      check_round_trip(*all, &cases[k]);
      check_sound_speed(*all, &cases[k]);
    }
  return check_failed();
}
