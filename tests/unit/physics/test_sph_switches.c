/* test_sph_switches.c - what reduces viscosity, and what carries heat, in package sph: Balsara's factor, the
 * switch of Cullen and Dehnen, conduction, dissipation of pressure. Oracles: the same gas with the term
 * switched off, exact sums of heat, and shear and compression, whose limits are known. */
#include "physics/passes/viscosity.h"
#include "tests/unit/scenario.h"

static const char box[] =
    "dimension: {1d: 1, 2d: 2, 3d: 3}\nresolution: {1d: 40, 2d: 20, 3d: 10}\n"
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}\nboundaries: {x: periodic, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions:\n  - {material: gas, lattice: cubic, density: 1, pressure: 1, velocity: [0, 0, 0]}\n"
    "until: 0.2\nmethod: {energy: thermal, viscosity: {name: monaghan}}\n";

/* Heating of the two halves of the box, x < 0.5 and beyond, at the start. */
struct heating {
  double left, right;
};
static struct heating heating(const char *settings) {
  struct scenario s = {0};
  struct heating sum = {0};
  if (scenario_open(&s, box, "%s", settings) && scenario_run(&s, 0)) {
    const struct kith_hydro *h = &s.simulation->hydro;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i)
      *(s.simulation->nodes->position->f64[(size_t)i * NDIM] < 0.5 ? &sum.left : &sum.right) +=
          h->mass->f64[i] * h->energy_rate->f64[i];
  }
  scenario_close(&s);
  return sum;
}

/* Heating of the whole box. Since sum m du/dt + m v . dv/dt = 0, it is what the motion loses. */
static double loss(const char *settings) {
  const struct heating h = heating(settings);
  return h.left + h.right;
}

#if NDIM > 1
#define SHEAR "regions.0.velocity=[0,sin(2*pi*x),0] method.viscosity.beta=0 "
/* In shear the divergence is zero to round-off. What is left is e / (curl + e), which is larger with the wide
 * supports of 3-D. */
static void check_shear(void) {
  const double sph = loss(SHEAR "method.viscosity.balsara=none"),
               crk = loss(SHEAR "method.viscosity.balsara=none method.package=crk");
  const double left = NDIM == 3 ? 0.06 : 0.02;
  CHECK(sph > 0.01 && crk > 0.01);
  CHECK(loss(SHEAR) < left * sph);
  CHECK(loss(SHEAR "method.viscosity.balsara=balsara") < left * sph);
  CHECK(loss(SHEAR "method.viscosity.balsara=squared") < left * sph);
  CHECK(loss(SHEAR "method.package=crk") < left * crk);
#define SLOW_SHEAR "regions.0.velocity=[0,0.2*sin(2*pi*x),0] method.viscosity.alpha=0 "
  CHECK(loss(SLOW_SHEAR) < 0.5 * loss(SLOW_SHEAR "method.viscosity.balsara=none"));
}
#endif

/* In shear alone SLOW leaves nothing of a difference below 0.05 c, and takes 0.05 c from a fast one; half of
 * this where 20 s is 1/2; nothing without a curl. Switches alone leave the quadratic term. */
static void check_term(void) {
  const double alpha = 1.5, beta = 2, c = 2;
  struct kith_viscosity_settings settings = {KITH_VISCOSITY_LIMITED, alpha, beta, KITH_BALSARA_SLOW};
  struct kith_viscosity_constants constants = kith_viscosity_constants(&settings, 40);
  const struct kith_viscous_pair slow = {.mu = -0.03, .sound = c}, fast = {.mu = -1, .sound = c};
  CHECK_CLOSE(kith_viscous_term(&constants, &slow, 0), 0, 1e-16);
  CHECK_CLOSE(kith_viscous_term(&constants, &fast, 0), beta * 0.9, 1e-15);
  CHECK_CLOSE(kith_viscous_term(&constants, &fast, 1.0 / 40), beta * 0.95 + alpha * c / 40, 1e-15);
  CHECK_CLOSE(kith_viscous_term(&constants, &fast, 0.25), beta + alpha * c / 4, 1e-15);
  CHECK_CLOSE(kith_viscous_term(&constants, &slow, 1), beta * 0.03 * 0.03 + alpha * c * 0.03, 1e-15);
  settings.balsara = KITH_BALSARA_NONE, constants = kith_viscosity_constants(&settings, 40);
  CHECK_CLOSE(kith_viscous_term(&constants, &fast, 0.01), beta + 0.01 * alpha * c, 1e-15);
  settings.balsara = KITH_BALSARA_FACTOR, constants = kith_viscosity_constants(&settings, 40);
  CHECK_CLOSE(kith_viscous_term(&constants, &fast, 0.25), 0.25 * (beta + alpha * c), 1e-15);
}

#define CONVERGING "regions.0.velocity=[-sin(2*pi*x),0,0] "
/* Without a curl the factor is 1. */
static void check_compression(void) {
  const double none = loss(CONVERGING "method.viscosity.balsara=none"), slow = loss(CONVERGING),
               one = loss(CONVERGING "method.viscosity.balsara=squared");
  CHECK(none > 0.01);
  CHECK_CLOSE(slow, none, 1e-12 * none);
  CHECK_CLOSE(one, none, 1e-12 * none);
  /* by symmetry pressure does no net work at the start */
  CHECK_CLOSE(loss(CONVERGING "method.viscosity.name=none"), 0, 1e-13);
  CHECK(loss(CONVERGING "method.viscosity.name=limited") < 0.5 * none);
}

/* Hot and cold gas of equal density: heat flows to the cold side and its sum is zero; at equal pressures none
 * flows. */
static void check_conduction(void) {
#define HALVES "regions.0.pressure=x<0.5?2:1 "
  const struct heating without = heating(HALVES), with = heating(HALVES "method.conduction=1");
  CHECK(with.right > without.right + 0.05 && with.left < without.left - 0.05);
  CHECK_CLOSE(with.left + with.right, 0, 1e-13); /* round-off of sums of order 1 */
  CHECK_CLOSE(loss("method.conduction=1"), 0, 1e-13);
}

/* In converging gas of two temperatures, dissipation of pressure moves heat from the hot to the cold half,
 * and its sum is zero; at equal pressures it moves none, however fast the gas converges. */
static void check_pressures(void) {
#define INVISCID CONVERGING "method.viscosity.name=none "
#define DISSIPATION "method.pressure_dissipation=1"
  const struct heating even = heating(INVISCID), halves = heating(INVISCID HALVES),
                       even_with = heating(INVISCID DISSIPATION),
                       halves_with = heating(INVISCID HALVES DISSIPATION);
  CHECK_CLOSE(even_with.right, even.right, 1e-13);
  CHECK_CLOSE(even_with.left, even.left, 1e-13);
  CHECK(halves_with.right > halves.right + 0.01);
  CHECK_CLOSE(halves_with.left + halves_with.right, halves.left + halves.right, 1e-13); /* round-off */
}

/* In tension, too: pressures that differ by rounding move no heat that counts. */
static void check_tension(void) {
  static const char stretched[] = INVISCID
      "materials.gas.eos=stiffened "
      "materials.gas.gamma=2 materials.gas.stiffness=4 "
      "regions.0.pressure=-1+1e-12*sin(6*pi*x)";
  struct scenario s[2] = {{0}};
  for (int on = 0; on < 2; ++on) {
    CHECK(scenario_open(&s[on], box, "%s method.pressure_dissipation=%d", stretched, on) &&
          scenario_run(&s[on], 0));
  }
  for (kith_index i = 0; check_failures == 0 && i < s[0].simulation->nodes->n_internal; ++i)
    CHECK_CLOSE(s[1].simulation->hydro.energy_rate->f64[i], s[0].simulation->hydro.energy_rate->f64[i], 1e-9);
  for (int on = 0; on < 2; ++on) scenario_close(&s[on]);
}

/* The switch is 0 in gas at rest, large where a shock arises, and 0 where gas has always expanded. */
static void check_cullen_dehnen(void) {
  static const char shock[] = "regions.0.velocity=[-1.5*sin(2*pi*x),0,0] method.viscosity.name=cullen-dehnen";
  struct scenario s = {0};
  scenario_open(&s, box, "method.viscosity.name=cullen-dehnen");
  if (scenario_run(&s, 3)) {
    const double *viscosity_switch = scenario_field(&s, "viscosity")->f64;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) CHECK(fabs(viscosity_switch[i]) < 1e-12);
  }
  scenario_close(&s);
  scenario_open(&s, box, "%s", shock);
  double largest = 0, behind = 0;
  if (scenario_run(&s, 30)) {
    const double *viscosity_switch = scenario_field(&s, "viscosity")->f64;
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i) {
      largest = fmax(largest, viscosity_switch[i]);
      CHECK(viscosity_switch[i] >= 0 && viscosity_switch[i] <= 1);
    }
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i)
      if (fabs(s.simulation->nodes->position->f64[(size_t)i * NDIM] - 0.5) < 0.1)
        behind = fmax(behind, viscosity_switch[i]);
    CHECK(largest > 0.5);
    CHECK(behind < 1e-3 * largest); /* where gas expands */
  }
  scenario_close(&s);
}

int main(void) {
#if NDIM > 1
  check_shear();
#endif
  check_term();
  check_compression();
  check_conduction();
  check_pressures();
  check_tension();
  check_cullen_dehnen();
  return check_failed();
}
