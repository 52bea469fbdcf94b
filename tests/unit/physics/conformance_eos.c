/* conformance_eos.c - every equation of state, for many values of its parameters, against thermodynamics: c^2
 * = dP/drho along an isentrope (defined by du = P / rho^2 drho), by differences; energy() inverts the
 * pressure; gamma is the growth of the bulk modulus along the isentrope; nothing positive becomes negative.
 * Then values known by hand, and tables. */
#include "tests/unit/choices_of.h"
#include "tests/unit/files.h"
#include "tests/unit/materials.h"

static void state(const struct kith_material *m, double density, double energy, double *pressure, double *c) {
  m->eos->state(m->settings, 1, &density, &energy, pressure, c);
}

/* u along the isentrope from (density, energy) to `to`, by one step of the classical Runge-Kutta method of
 * fourth order. */
static double isentrope(const struct kith_material *m, double density, double energy, double to) {
  const double d = to - density, rho[] = {density, density + d / 2, density + d / 2, to};
  double k[4], pressure, c;
  for (int s = 0; s < 4; ++s) {
    state(m, rho[s], energy + (s == 0 ? 0 : s == 3 ? d * k[2] : d / 2 * k[s - 1]), &pressure, &c);
    k[s] = pressure / (rho[s] * rho[s]);
  }
  return energy + d / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]);
}

/* The part of the pressure that is due to energy; for a stiffened gas P + gamma P0, the largest term of P. */
static double thermal_pressure(const struct kith_material *m, double density, double energy) {
  double once, twice, c;
  state(m, density, energy, &once, &c);
  state(m, density, 2 * energy, &twice, &c);
  return fabs(twice - once);
}

/* Is the state in the range of the material, and not torn apart? */
static bool covers(const struct kith_material *m, double density, double energy) {
  double p, c;
  state(m, density, energy, &p, &c);
  return c > 0 && kith_material_outside(m, density, energy, p, c) == NULL;
}

static void check_isentrope(const struct kith_material *m) {
  uint64_t seed = 3;
  int covered = 0;
  for (int s = 0; s < 200; ++s) {
    const double density = pow(10, 4 * check_random(&seed) - 2), d = 1e-4 * density;
    double p, c, p_above, p_below, c_above, c_below;
    const double energy = kith_material_energy(m, density, 0.01 + 10 * check_random(&seed));
    const double gamma = kith_material_gamma(m, density, energy);
    if (!covers(m, density - d, energy) || !covers(m, 1.3 * density, energy) || gamma >= 20)
      continue; /* too near a pole, or too steep for differences */
    ++covered;
    state(m, density, energy, &p, &c);
    state(m, density + d, isentrope(m, density, energy, density + d), &p_above, &c_above);
    state(m, density - d, isentrope(m, density, energy, density - d), &p_below, &c_below);
    CHECK(gamma >= 1 && isfinite(gamma));
    /* Tolerance: truncation is (d / rho)^2 times a cubic in gamma; cancellation is 1e-16 / 1e-4 of the terms
     * of P. */
    const double rounding =
        1e-10 * (thermal_pressure(m, density, energy) / density + fabs(p) / density + c * c);
    CHECK_CLOSE((p_above - p_below) / (2 * d), c * c,
                (m->eos->power_law != NULL ? 2e-6 : 1e-4) * c * c + rounding);
    /* rho c^2 = gamma P + constant, so d(rho c^2) = gamma dP. */
    const double modulus = (density + d) * c_above * c_above - (density - d) * c_below * c_below;
    if (gamma > 1) /* not at the ends of its range, where differences are one-sided */
      CHECK_CLOSE(modulus / (2 * d), gamma * c * c, 1e-5 * c * c * gamma + gamma * rounding);
    if (m->eos->power_law == NULL) continue;
    const struct kith_power_law law = m->eos->power_law(m->settings);
    CHECK_CLOSE(density * c * c, law.gamma * (p + law.stiffness),
                1e-14 * (density * c * c + law.gamma * fabs(p)) + rounding);
  }
  CHECK(covered >= 20);
}

/* energy() returns the energy of the wanted pressure, unless energy has no effect on the pressure. */
static void check_inverse(const struct kith_material *m) {
  for (double density = 1e-3; density < 2e3; density *= 10) {
    double cold, hot, c;
    state(m, density, 1, &cold, &c);
    state(m, density, 2, &hot, &c);
    CHECK(m->eos->barotropic == !(hot > cold));
    for (double wanted = 0; wanted < 2e3; wanted = 10 * wanted + 1e-3) {
      const double energy = kith_material_energy(m, density, wanted);
      double pressure;
      state(m, density, energy, &pressure, &c);
      if (hot > cold) CHECK_CLOSE(pressure, wanted, 4e-15 * (wanted + thermal_pressure(m, density, energy)));
      CHECK(c >= 0 && isfinite(c) && isfinite(energy) && (energy >= 0 || !m->eos->energy_positive));
    }
    /* positive energy: positive pressure and sound speed, or tension, which only condensed materials bear */
    for (double energy = 1e-3; energy < 2e3; energy *= 10) {
      state(m, density, energy, &hot, &c);
      CHECK(c > 0 || hot < 0 || !covers(m, density, energy));
      if (hot < 0) {
        struct kith_material gas = *m;
        gas.cut = true;
        kith_material_state(&gas, 1, &density, &energy, &hot, &c);
        CHECK(hot == 0 && c == 0 && kith_material_outside(&gas, density, energy, hot, c) == NULL);
      }
    }
    state(m, density, -1e6, &cold, &c); /* outside of the physical range, but finite */
    CHECK(isfinite(cold) && c >= 0);
  }
}

/* A call for n nodes is bitwise equal to n calls for one; 0 nodes are allowed. */
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

/* --- tables --- */

static kith_status load_table(struct kith_material *table) {
  char file[128];
  void *settings;
  snprintf(file, sizeof file, "file=%s", path_in("a.table"));
  CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_eos_member, "table"), file));
  const kith_status status = kith_eos_table.load(&settings, "");
  if (status != KITH_OK) kith_free(&settings);
  *table = (struct kith_material){.eos = &kith_eos_table, .settings = settings};
  return status;
}

/* Writes and loads a table of `m` at n densities and energies between these, with unequal spacing. */
static struct kith_material table_of(const struct kith_material *m, int n, double rho0, double rho1,
                                     double u0, double u1) {
  FILE *file = fopen(path_in("a.table"), "w");
  struct kith_material table;
  for (int row = -2; row < n; ++row) {
    for (int k = 0; k < n; ++k) {
      const double at = k / (n - 1.0), stretched = at * (0.8 + 0.2 * at);
      const double rho = row == -2 ? rho0 + (rho1 - rho0) * stretched : 0, u = u0 + (u1 - u0) * stretched;
      double value = row == -2 ? rho : u, c;
      const double part = row / (n - 1.0);
      if (row >= 0) state(m, rho0 + (rho1 - rho0) * part * (0.8 + 0.2 * part), u, &value, &c);
      fprintf(file, " %.17g", value);
    }
    fprintf(file, row == 0 ? "   # the first density\n" : "\n");
  }
  fclose(file);
  CHECK_OK(load_table(&table));
  return table;
}

/* The largest errors of P and c over the table, relative to the largest values. */
static void table_errors(const struct kith_material *m, int n, double *of_p, double *of_c) {
  struct kith_material table = table_of(m, n, 0.8, 1.6, 0, 2);
  uint64_t seed = 9;
  double largest_p = 0, largest_c = 0;
  *of_p = *of_c = 0;
  for (int k = 0; k < 2000; ++k) {
    const double density = 0.8 + 0.8 * check_random(&seed), energy = 2 * check_random(&seed);
    double p, c, q, d;
    state(m, density, energy, &p, &c);
    state(&table, density, energy, &q, &d);
    *of_p = fmax(*of_p, fabs(p - q)), *of_c = fmax(*of_c, fabs(c - d));
    largest_p = fmax(largest_p, fabs(p)), largest_c = fmax(largest_c, c);
    CHECK_CLOSE(kith_material_energy(&table, density, q), energy, 1e-13);
  }
  *of_p /= largest_p, *of_c /= largest_c;
  kith_free(&table.settings);
}

static void check_refused_table(const char *text, const char *line, const char *value) {
  struct kith_material table;
  write_text(path_in("a.table"), text);
  CHECK_STATUS(KITH_BAD_INPUT, load_table(&table));
  CHECK(check_says(path_in("a.table")) && check_says(line) && check_says(value));
}

static void check_tables(void) {
  directory_make();
  const struct kith_material solid = material_of("mie-grueneisen", NULL),
                             gas = material_of("stiffened", "gamma=3 stiffness=0.1");
  double p[3], c[3];
  for (int k = 0; k < 3; ++k) table_errors(&solid, 10 << k, &p[k], &c[k]);
  /* second order for P; c has kinks at the edges and at rho0 */
  CHECK(p[2] < 1e-5 && p[0] / p[1] > 4 && p[1] / p[2] > 4 && c[1] / c[2] > 1.8);
  table_errors(&gas, 4, &p[0], &c[0]); /* linear in density and energy, so exact */
  CHECK(p[0] < 1e-14 && c[0] < 1e-13);
  struct kith_material table = table_of(&solid, 60, 0.01, 1.9, 0, 20);
  check_isentrope(&table), check_arrays(&table);
  /* outside: finite values, and a reason */
  const double density[] = {0.02, 2, 1, 1}, energy[] = {1, 1, 21, -1};
  for (int k = 0; k < 4; ++k) {
    state(&table, density[k], energy[k], p, c);
    CHECK(isfinite(p[0]) && c[0] >= 0);
    const char *reason = kith_material_outside(&table, density[k], energy[k], p[0], c[0]);
    CHECK(k == 0 ? reason == NULL : reason != NULL && strstr(reason, k == 1 ? "density" : "energy") != NULL);
  }
  kith_free(&table.settings);
  write_text(path_in("a.table"),
             "\xef\xbb\xbf" /* what editors put in front of UTF-8 */ "1 2\n0 1\n1 2\n2 3\n");
  CHECK_OK(load_table(&table));
  kith_free(&table.settings);
  check_refused_table("1 2\n0 1\n1 2\n# comment\n2 0.5\n", ":5:", "0.5"); /* falls along the energy */
  check_refused_table("1 2\n0 1\n1 2\n0.7 3\n", ":4:", "0.7");            /* falls along the density */
  check_refused_table("1 1\n0 1\n1 2\n2 3\n", ":1:", "density 1");
  check_refused_table("1 2\n0 -1\n1 2\n2 3\n", ":2:", "energy -1");
  check_refused_table("0 2\n0 1\n1 2\n2 3\n", "", "density 0");
  check_refused_table("1 2\n0 1\n1 x\n2 3\n", ":3:", "'x'");
  check_refused_table("1 2\n0 1\n1 nan\n2 3\n", ":3:", "nan");
  check_refused_table("1 2\n0 1\n1 2 3\n2 3\n", ":3:", "3 numbers");
  check_refused_table("1 2\n0 1\n1 2\n", ":3:", "0 numbers");
  check_refused_table("1 2\n0 1\n1 2\n2 3\n3 4\n", ":5:", "more lines of pressures than densities, 2");
  check_refused_table("", ":0:", "0 numbers");
  directory_remove(1, (const char *const[]){"a.table"});
  CHECK_STATUS(KITH_BAD_INPUT, load_table(&table));
  CHECK(check_says(path_in("a.table")));
}

/* Sets each parameter in turn to all values of a list that its range allows. */
static void conform(const struct kith_eos_ops *eos) {
  CHECK(kith_eos_find(eos->name) == eos && eos->doc != NULL && eos->doc[0] != '\0');
  if (eos->load != NULL) return; /* see check_tables */
  static const char *const values[] = {"0", "0.5", "1.0001", "1.4", "1.6666666666666667", "4.4", "6", "100"};
  struct kith_material m = material_of(eos->name, NULL);
  int tried = 0;
  for (const struct kith_param *p = eos->params; p != NULL && p->key != NULL; ++p)
    for (size_t k = 0; k < sizeof values / sizeof values[0]; ++k) {
      char assignment[64];
      double value;
      if (p->kind != KITH_PARAM_NUMBER || kith_param_parse(p, values[k], &value) != KITH_OK) continue;
      snprintf(assignment, sizeof assignment, "%s=%s", p->key, values[k]);
      m = material_of(eos->name, assignment);
      CHECK(material_value(&m, p->key) == value);
      if (value < 50) /* exponents above 50 are too steep for differences */
        check_isentrope(&m), check_inverse(&m);
      check_arrays(&m), ++tried;
    }
  for (const struct kith_param *p = eos->params; p != NULL && p->key != NULL; ++p) {
    char choice[64], assignment[128];
    for (int k = 0; p->kind != KITH_PARAM_NUMBER && choice_of(p, k, choice, sizeof choice); ++k) {
      snprintf(assignment, sizeof assignment, "%s=%s", p->key, choice);
      m = material_of(eos->name, assignment);
      check_isentrope(&m), check_inverse(&m), check_arrays(&m), ++tried;
    }
  }
  if (eos->params == NULL) check_isentrope(&m), check_inverse(&m), check_arrays(&m);
  CHECK(eos->params == NULL || tried >= 3);
}

/* Values known by hand. */
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
  CHECK(kith_material_energy(&isothermal, 2, 8) == 0);
  stiffened.eos->state(stiffened.settings, 3, density, energy, pressure, c);
  CHECK_CLOSE(pressure[0], 1.5, 1e-14);
  CHECK_CLOSE(c[0], sqrt(1.5 * 4.5 / 2), 1e-14);
  CHECK_CLOSE(pressure[1], -4.5, 1e-14); /* tension: P + P0 < 0 and c^2 < 0 */
  CHECK(c[1] == 0);
  CHECK(kith_material_outside(&stiffened, 4, 0, pressure[1], c[1]) != NULL);
  CHECK(kith_eos_find("none") == NULL && kith_eos_find("") == NULL);
  const struct kith_material water = material_of("tait", "density=2 sound_speed=3 exponent=7 pressure=0.5");
  water.eos->state(water.settings, 2, density, energy, pressure, c);
  CHECK(pressure[0] == 0.5 && c[0] == 3);
  CHECK_CLOSE(pressure[1], 0.5 + 2 * 9 / 7. * 127, 1e-12);
  CHECK_CLOSE(c[1], 3 * 8, 1e-13);
  /* Copper: shocks move at 3.94 + 1.489 u, whatever their strength. */
  const struct kith_material copper =
      material_of("mie-grueneisen", "density=8.93 sound_speed=3.94 slope=1.489 gamma=1.99");
  for (double u = 0.01; u < 10; u *= 2) {
    const double shock = 3.94 + 1.489 * u;
    state(&copper, 8.93 * shock / (shock - u), 0.5 * u * u, pressure, c);
    CHECK_CLOSE(pressure[0], 8.93 * shock * u, 1e-13 * pressure[0]);
    CHECK(c[0] > shock - u); /* subsonic behind the shock */
  }
  CHECK_CLOSE(kith_material_gamma(&copper, 8.93 * 1.001, 0), 4 * 1.489 - 1, 0.03); /* of a weak shock */
  CHECK(strstr(kith_material_outside(&copper, 8.93 * 3.1, 0, 1, 1), "compressed") != NULL);
  /* That bears no tension: round-off at rest tears nothing, a stretch of 1e-6 does. */
  struct kith_material torn = copper;
  const double stretched[] = {8.93 * (1 - 1e-14), 8.93 * (1 - 1e-6)}, none[] = {0, 0};
  torn.cut = true;
  kith_material_state(&torn, 2, stretched, none, pressure, c);
  CHECK_CLOSE(c[0], 3.94, 1e-12);
  CHECK(pressure[0] == 0 && pressure[1] == 0 && c[1] == 0);
}

int main(void) {
  int n = 0;
  check_values();
  for (const struct kith_eos_ops *const *all = kith_eos_all(); *all != NULL; ++all, ++n) conform(*all);
  CHECK(n >= 6);
  check_tables();
  return check_failed();
}
