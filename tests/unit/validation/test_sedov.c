/* test_sedov.c - Sedov's blast in gas whose density falls as a power of r: standard, singular and vacuum
 * case. Oracles: published constants, and laws that are independent of similarity: mass and energy behind the
 * shock by quadrature, jump conditions, and Euler's equations by differences. */
#include "tests/unit/validation/exact_oracles.h"

#include <gsl/gsl_integration.h>
#include <string.h>

#include "lib/core/vec.h"
#include "tests/unit/exact_settings.h"

typedef struct kith_exact_state state;
typedef struct exact_parameters parameters;

static const struct kith_exact_ops *const sedov = &kith_exact_sedov;

struct blast {
  const void *self;
  double time;
  bool energy;
};

static double shell(double r, void *context) {
  const struct blast *b = context;
  const state s = at(sedov, b->self, r, b->time);
  const double area = NDIM * kith_ball() * kith_pow_dim(r) / r, v = s.velocity[0];
  return area * s.density * (b->energy ? s.energy + v * v / 2 : 1);
}

/* The radius of the void, by bisection; 0 if there is none. */
static double void_of(const void *self, double time) {
  double low = 1e-6 * sedov->shock(self, time), high = sedov->shock(self, time) * (1 - 1e-9);
  if (at(sedov, self, low, time).density > 0) return 0;
  while (high - low > 1e-15 * high && 0.5 * (low + high) > low && 0.5 * (low + high) < high)
    *(at(sedov, self, 0.5 * (low + high), time).density > 0 ? &high : &low) = 0.5 * (low + high);
  return high;
}

/* Integral behind the shock; QAGS handles powers at the ends of the interval. */
static double integral(const void *self, double time, bool energy) {
  gsl_integration_workspace *work = gsl_integration_workspace_alloc(2000);
  struct blast context = {self, time, energy};
  gsl_function f = {shell, &context};
  double sum = 0, error;
  CHECK(gsl_integration_qags(&f, void_of(self, time), sedov->shock(self, time), 0, 1e-8, 2000, work, &sum,
                             &error) == 0);
  gsl_integration_workspace_free(work);
  return sum;
}

static void *solve(double gamma, double omega, double energy, double density) {
  const parameters p = {.gamma = {gamma}, .density = {density}, .omega = omega, .blast_energy = energy};
  void *self = NULL;
  CHECK_OK(exact_create(&self, sedov, &p));
  return self;
}

static double singular(double gamma) {
  return (NDIM * (3 - gamma) + 2 * gamma - 2) / (gamma + 1);
}

/* Kamm and Timmes: energies for which the shock is at these radii at time 1, and the ratio of the void's
 * radius to that of the shock. (In 1-D and 2-D their values for uniform gas are wrong in the fifth digit;
 * test_exact.c has better ones.) */
static void constants(void) {
  static const struct {
    int dimension;
    double omega, energy, radius, empty;
  } table[] = {{2, 5. / 3, 2.45749, 0.75, 0},
               {2, 1.7, 2.67315, 0.75, 0.154090},
               {3, 0, 0.851072, 1, 0},
               {3, 7. / 3, 4.90875, 1, 0},
               {3, 2.4, 5.45670, 1, 0.272644}};
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k) {
    if (table[k].dimension != NDIM) continue;
    void *self = solve(1.4, table[k].omega, table[k].energy, 1);
    if (self == NULL) continue;
    /* tolerance: six digits of the energy, and half of that in r */
    CHECK_CLOSE(sedov->shock(self, 1) / table[k].radius, 1, 2e-6);
    CHECK_CLOSE(void_of(self, 1) / table[k].radius, table[k].empty, 1e-6); /* the digits that are given */
    kith_free(&self);
  }
}

/* The shock speed and jump conditions, mass and energy behind the shock to the tolerance 1e-8 of the
 * quadrature (measured: 1e-11), and Euler's equations. */
static void laws(double gamma, double omega) {
  const double density = 1.7, energy = 0.3, time = 0.07, j = NDIM;
  void *self = solve(gamma, omega, energy, density);
  if (self == NULL) return;
  const double r = sedov->shock(self, time), speed = 2 * r / ((j + 2 - omega) * time);
  CHECK_CLOSE((sedov->shock(self, time * (1 + 1e-6)) - sedov->shock(self, time * (1 - 1e-6))) / (2e-6 * time),
              speed, 1e-8 * speed);
  const state ahead = at(sedov, self, r * (1 + 1e-13), time), edge = at(sedov, self, r * (1 - 1e-15), time);
  CHECK_CLOSE(ahead.density, density * pow(r, -omega), 1e-11 * ahead.density);
  CHECK(ahead.pressure == 0 && ahead.velocity[0] == 0);
  check_shock(&ahead, &edge, speed);
  const double swept = density * j * kith_ball() * pow(r, j - omega) / (j - omega);
  CHECK_CLOSE(integral(self, time, false) / swept, 1, 1e-8);
  CHECK_CLOSE(integral(self, time, true) / energy, 1, 1e-8);
  const double empty = void_of(self, time);
  for (int i = 1; i < 20; ++i) {
    const double x = empty + (r - empty) * i / 20;
    const state s = at(sedov, self, x, time);
    if (s.density > 1e-90 && s.pressure > 0)
      check_euler(sedov, self, x, time, (empty > 0 ? 0.5 : 1) * (x - empty), gamma, NDIM);
  }
  if (empty > 0) {
    const state s = at(sedov, self, 0.5 * empty, time);
    CHECK(s.density == 0 && s.pressure == 0 && s.energy == 0 && s.velocity[0] == 0);
  }
  kith_free(&self);
}

/* The cases join continuously: slightly below and above the singular gradient. */
static void continuity(void) {
  for (int k = 0; k < 2 && NDIM > 1; ++k) {
    const double step = k == 0 ? 1e-8 : -1e-8, omega = singular(1.4);
    void *exact = solve(1.4, omega, 1, 1), *near = solve(1.4, omega + step, 1, 1);
    if (exact == NULL || near == NULL) return;
    for (int i = 10; i < 20; ++i) {
      const state s = at(sedov, exact, 0.05 * i * sedov->shock(exact, 1), 1),
                  t = at(sedov, near, 0.05 * i * sedov->shock(near, 1), 1);
      CHECK_CLOSE(s.density / t.density, 1, 1e-6); /* the step 1e-8, amplified inwards */
      CHECK_CLOSE(s.pressure / t.pressure, 1, 1e-6);
    }
    kith_free(&exact);
    kith_free(&near);
  }
}

static void places(void) {
  const double omegas[] = {0.5, NDIM > 1 ? singular(1.4) : 0.9, NDIM > 1 ? singular(1.4) + 0.05 : 0.99};
  for (int k = 0; k < 3; ++k) {
    void *self = solve(1.4, omegas[k], 1, 1);
    state s;
    const double center[NDIM] = {0};
    if (self == NULL) continue;
    for (int time = 0; time < 2; ++time) {
      sedov->state(self, center, time, &s);
      CHECK(isfinite(s.density) && isfinite(s.pressure) && isfinite(s.energy) && kith_norm(s.velocity) == 0);
    }
    kith_free(&self);
  }
}

/* A blast that is released later is the same, that much later; before, the gas is undisturbed. */
static void later(void) {
  const parameters now = {.gamma = {1.4}, .density = {1.7}, .pressure = {0.1}, .blast_energy = 0.3};
  parameters then = now;
  void *self[2] = {NULL, NULL};
  then.start = 0.25; /* with the times below exact in binary */
  CHECK_OK(exact_create(&self[0], sedov, &now));
  CHECK_OK(exact_create(&self[1], sedov, &then));
  for (int k = 1; k < 8 && self[1] != NULL; ++k) {
    const double time = 0.125 * k, r = 0.1 * k;
    const state s = at(sedov, self[0], r, time), t = at(sedov, self[1], r, time + 0.25),
                before = at(sedov, self[1], r, 0.03 * k);
    CHECK(memcmp(&s, &t, sizeof s) == 0);
    CHECK(sedov->shock(self[0], time) == sedov->shock(self[1], time + 0.25));
    CHECK(before.density == 1.7 && before.pressure == 0.1 && before.velocity[0] == 0);
    CHECK(sedov->shock(self[1], 0.03 * k) == 0);
  }
  kith_free(&self[0]);
  kith_free(&self[1]);
}

static void refusals(void) {
  static const double wrong[] = {-0.1, NDIM, NDIM + 5, NAN};
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
    void *self = NULL;
    const parameters p = {.gamma = {1.4}, .density = {1}, .omega = wrong[k], .blast_energy = 1};
    CHECK_STATUS(KITH_BAD_INPUT, exact_create(&self, sedov, &p));
    CHECK(self == NULL && strstr(kith_failure(), "omega") != NULL);
  }
}

int main(void) {
  static const double gamma[] = {1.2, 1.4, 5. / 3, 3};
  constants();
  for (size_t g = 0; g < sizeof gamma / sizeof gamma[0]; ++g) {
    const double omega = singular(gamma[g]);
    laws(gamma[g], 0.5);
    if (NDIM == 1) laws(gamma[g], 0.9);
    if (NDIM == 1 || omega >= NDIM) continue;
    if (omega > 0.1) laws(gamma[g], omega - 0.1);
    if (omega >= 0) laws(gamma[g], omega);
    if (omega + 0.05 < NDIM) laws(gamma[g], omega + 0.05);
  }
  if (NDIM == 3) laws(7.5, 0); /* a void in uniform gas */
  continuity();
  places();
  later();
  refusals();
  return check_failed();
}
