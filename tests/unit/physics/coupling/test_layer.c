/* test_layer.c - a porous layer between two slabs passes the fraction f of heat and of momentum. Oracle: the
 * exact solution for a layer with f times the conductivity and viscosity (Laplace transform, method of
 * images), whose initial state is halfway between those of the slabs. */
#include "tests/unit/scenario.h"

static const char slabs[] =
    "resolution: {1d: 40, 2d: 30, 3d: 20}\n"
    "domain: {lower: [-1, 0, 0], upper: [1, 1, 1], across: {1d: 1, 2d: 8, 3d: 6}}\n"
    "boundaries: {x: reflecting, y: periodic, z: periodic}\n"
    "materials: {solid: {eos: isothermal, sound_speed: 1.0e-9}}\n" /* nearly no pressure */
    "regions:\n"
    "  - {material: solid, lattice: cubic, where: {x: [-1, -0.1]}, density: 1, energy: 1,\n"
    "     velocity: [1.0e-4, 0, 0]}\n"
    "  - {material: solid, lattice: cubic, where: {x: [-0.1, 0.1]}, density: 1, energy: 0.5,\n"
    "     velocity: [0.5e-4, 0, 0]}\n"
    "  - {material: solid, lattice: cubic, where: {x: [0.1, 1]}, density: 1, energy: 0}\n"
    "method: {kernel: wendland-c4, neighbors: {1d: 6, 2d: 30, 3d: 100}, energy: thermal}\n"
    "packages: [{name: conduction, conductivity: 1}, {name: viscosity, dynamic: 1}]\n"
    "scheme: {name: rk2}\nuntil: 0.02\n";

/* The inverse Laplace transform of exp(-z sqrt(s)) / s^(3/2). */
static double inverse(double z, double t) {
  return 2 * sqrt(t / M_PI) * exp(-z * z / (4 * t)) - z * erfc(z / (2 * sqrt(t)));
}

/* What has passed the middle of the layer, from two half spaces and a layer between them. */
static double passed(double f, double t) {
  const double b = 1 / sqrt(f), r = (1 - b) / (1 + b);
  double sum = 0, sign = 1;
  for (int n = 0; n < 100; ++n, sign *= -r) sum += sign * inverse((2 * n + 1) * 0.1 * b, t);
  return sum / (1 + b);
}

/* Energy and momentum of the right half, per area. */
static void contents(const struct scenario *s, double out[2]) {
  const struct kith_hydro *hydro = &s->simulation->hydro;
  double area = 1;
  for (int a = 1; a < NDIM; ++a) area *= s->scene->domain.upper[a] - s->scene->domain.lower[a];
  out[0] = out[1] = 0;
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    if (hydro->nodes->position->f64[i * NDIM] < 0) continue;
    out[0] += hydro->mass->f64[i] * hydro->energy->f64[i] / area;
    out[1] += hydro->mass->f64[i] * hydro->velocity->f64[i * NDIM] / (1e-4 * area);
  }
}

static void check_layer(double f, const char *settings) {
  struct scenario s = {0};
  double before[2], after[2];
  if (scenario_open(&s, slabs, "regions.1.porosity=%g %s", f, settings)) {
    contents(&s, before);
    if (scenario_run(&s, 10000)) {
      contents(&s, after);
      for (int k = 0; k < 2; ++k) {
        const double wanted = f > 0 ? passed(f, 0.02) : 0;
        CHECK_CLOSE(after[k] - before[k], wanted, (NDIM == 3 ? 0.05 : 0.02) * wanted + (k == 1) * 1e-9);
      }
    }
  }
  scenario_close(&s);
}

int main(void) {
  check_layer(0.25, "traversal=pairs");
  if (NDIM == 3) return check_failed(); /* 80 times the cost */
  check_layer(0, "traversal=pairs");
  check_layer(0.25, "traversal=gather method.package=mfm");
  check_layer(0.5, "method.package=crk");
  check_layer(1, "");
  return check_failed();
}
