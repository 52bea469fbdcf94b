/* Every equation of state of the family, for many values of its own parameters, against thermodynamics:
 * c^2 = dP/drho along an isentrope (which du = P / rho^2 drho defines), by differences; energy() is the
 * inverse of the pressure; the effective gamma says how the bulk modulus grows along the isentrope; nothing
 * positive becomes negative. Then numbers by hand. */
#include "tests/unit/materials.h"

static void state(const struct kith_material *m, double density, double energy, double *pressure, double *c) {
  m->eos->state(m->settings, 1, &density, &energy, pressure, c);
}

/* u along the isentrope from (density, energy) to `to`, by one step of Runge and Kutta's fourth order. */
static double isentrope(const struct kith_material *m, double density, double energy, double to) {
  const double d = to - density, rho[] = {density, density + d / 2, density + d / 2, to};
  double k[4], pressure, c;
  for (int s = 0; s < 4; ++s) {
    state(m, rho[s], energy + (s == 0 ? 0 : s == 3 ? d * k[2] : d / 2 * k[s - 1]), &pressure, &c);
    k[s] = pressure / (rho[s] * rho[s]);
  }
  return energy + d / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]);
}

/* The part of the pressure that the energy gives: of a stiffened gas P + gamma P0, the largest term of P. */
static double thermal_pressure(const struct kith_material *m, double density, double energy) {
  double once, twice, c;
  state(m, density, energy, &once, &c);
  state(m, density, 2 * energy, &twice, &c);
  return fabs(twice - once);
}

static void check_isentrope(const struct kith_material *m) {
  uint64_t seed = 3;
  const double gamma = m->eos->effective_gamma(m->settings);
  CHECK(gamma >= 1 && isfinite(gamma));
  for (int s = 0; s < 50; ++s) {
    const double density = pow(10, 4 * check_random(&seed) - 2), d = 1e-4 * density;
    double p, c, p_above, p_below, c_above, c_below;
    const double energy = m->eos->energy(m->settings, density, 0.01 + 10 * check_random(&seed));
    state(m, density, energy, &p, &c);
    state(m, density + d, isentrope(m, density, energy, density + d), &p_above, &c_above);
    state(m, density - d, isentrope(m, density, energy, density - d), &p_below, &c_below);
    /* Truncation (d / rho)^2 times a cubic in gamma; cancellation 1e-16 / 1e-4 of the terms of P. */
    const double rounding = 1e-10 * thermal_pressure(m, density, energy) / density;
    CHECK_CLOSE((p_above - p_below) / (2 * d), c * c, 1e-6 * c * c + rounding);
    /* rho c^2 = gamma P + a constant: d(rho c^2) = gamma dP */
    const double modulus = (density + d) * c_above * c_above - (density - d) * c_below * c_below;
    CHECK_CLOSE(modulus / (2 * d), gamma * c * c, 1e-5 * c * c * gamma + gamma * rounding);
  }
}

/* The pressure that energy() is made for comes back, unless the energy has no effect on it. */
static void check_inverse(const struct kith_material *m) {
  for (double density = 1e-3; density < 2e3; density *= 10) {
    double cold, hot, c;
    state(m, density, 1, &cold, &c);
    state(m, density, 2, &hot, &c);
    CHECK(m->eos->energy_positive == (hot > cold)); /* else no bound on the energy means anything */
    for (double wanted = 0; wanted < 2e3; wanted = 10 * wanted + 1e-3) {
      const double energy = m->eos->energy(m->settings, density, wanted);
      double pressure;
      state(m, density, energy, &pressure, &c);
      if (hot > cold) CHECK_CLOSE(pressure, wanted, 4e-15 * (wanted + thermal_pressure(m, density, energy)));
      CHECK(c >= 0 && isfinite(c) && isfinite(energy) && energy >= 0);
      if (m->eos->gamma_law)
        CHECK_CLOSE(wanted, (m->eos->effective_gamma(m->settings) - 1) * density * energy, 1e-14 * wanted);
    }
    for (double energy = 1e-3; energy < 2e3;
         energy *= 10) { /* positive energy, positive pressure and speed */
      state(m, density, energy, &hot, &c);
      CHECK(c > 0 || hot < 0); /* tension, which only a condensed material bears */
      CHECK(!m->eos->gamma_law || hot > 0);
    }
    state(m, density, -1e6, &cold, &c); /* out of the physical range, but a number */
    CHECK(isfinite(cold) && c >= 0);
  }
}

/* n nodes at once are n times one, and none is none. */
static void check_arrays(const struct kith_material *m) {
  enum { N = 1000 };
  static double density[N], energy[N], pressure[N], c[N];
  uint64_t seed = 5;
  for (int i = 0; i < N; ++i) density[i] = 0.1 + check_random(&seed), energy[i] = 3 * check_random(&seed) - 1;
  m->eos->state(m->settings, N, density, energy, pressure, c);
  for (int i = 0; i < N; ++i) {
    double p1, c1;
    state(m, density[i], energy[i], &p1, &c1);
    CHECK(memcmp(&p1, &pressure[i], sizeof p1) == 0 && memcmp(&c1, &c[i], sizeof c1) == 0);
  }
  m->eos->state(m->settings, 0, density, energy, NULL, NULL);
}

/* All values of a list that are in the range of a parameter, of each parameter in turn. */
static void conform(const struct kith_eos_ops *eos) {
  static const char *const values[] = {"0", "0.5", "1.0001", "1.4", "1.6666666666666667", "4.4", "6", "100"};
  struct kith_material m = material_of(eos->name, NULL);
  int tried = 0;
  for (const struct kith_param *p = eos->params; p != NULL && p->key != NULL; ++p)
    for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) {
      char assignment[64];
      double value;
      if (kith_param_parse(p, values[k], &value) != KITH_OK) continue;
      snprintf(assignment, sizeof assignment, "%s=%s", p->key, values[k]);
      m = material_of(eos->name, assignment);
      CHECK(material_value(&m, p->key) == value);
      if (value < 50 || p->kind != KITH_PARAM_NUMBER || strcmp(p->key, "gamma") != 0)
        check_isentrope(&m), check_inverse(&m);
      check_arrays(&m), ++tried;
    }
  if (eos->params == NULL) check_isentrope(&m), check_inverse(&m), check_arrays(&m);
  CHECK(eos->params == NULL || tried >= 3);
  CHECK(kith_eos_find(eos->name) == eos && eos->doc != NULL && eos->doc[0] != '\0');
}

/* Numbers by hand. */
static void check_values(void) {
  const struct kith_material ideal = material_of("ideal", "gamma=1.5"),
                             isothermal = material_of("isothermal", "sound_speed=2"),
                             stiffened = material_of("stiffened", "gamma=1.5 stiffness=3");
  const double density[] = {2, 4, 1}, energy[] = {6, 0, -1};
  double pressure[3], c[3];
  ideal.eos->state(ideal.settings, 3, density, energy, pressure, c);
  CHECK_CLOSE(pressure[0], 6, 1e-15);
  CHECK_CLOSE(c[0], sqrt(4.5), 1e-15);
  CHECK(pressure[1] == 0 && c[1] == 0);
  CHECK(pressure[2] == -0.5 && c[2] == 0); /* out of range: c^2 < 0 */
  isothermal.eos->state(isothermal.settings, 3, density, energy, pressure, c);
  for (int k = 0; k < 3; ++k) CHECK(pressure[k] == 4 * density[k] && c[k] == 2);
  CHECK(isothermal.eos->energy(isothermal.settings, 2, 8) == 0);
  stiffened.eos->state(stiffened.settings, 3, density, energy, pressure, c);
  CHECK_CLOSE(pressure[0], 1.5, 1e-14);
  CHECK_CLOSE(c[0], sqrt(1.5 * 4.5 / 2), 1e-14);
  CHECK_CLOSE(pressure[1], -4.5, 1e-14); /* tension: P + P0 < 0, and c^2 < 0 */
  CHECK(c[1] == 0);
  CHECK(kith_eos_find("none") == NULL && kith_eos_find("") == NULL);
}

int main(void) {
  int n = 0;
  check_values();
  for (const struct kith_eos_ops *const *all = kith_eos_all(); *all != NULL; ++all, ++n) conform(*all);
  CHECK(n >= 3);
  return check_failed();
}
