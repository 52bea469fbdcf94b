/* test_kernel.c - kernels: shapes, edges, constants, self weights and neighbor numbers. Oracle
 * (kernel_oracle.h): B-splines by recurrence, Wendland functions by integration, quadrature, and sums over
 * lattices. */
#include <string.h>
#include "tests/unit/physics/kernel_oracle.h"
#include "tests/check.h"

static double value(enum kith_kernel k, double q) {
  double w, g;
  kith_kernel_value(k, q, &w, &g);
  return w;
}

static double slope(enum kith_kernel k, double q) {
  double w, g;
  kith_kernel_value(k, q, &w, &g);
  return g;
}

static double value_of(const void *kernel, double q) {
  return value(*(const enum kith_kernel *)kernel, q);
}

/* Compares with the oracle; both are sums of at most 12 products of order 1. */
static void check_shape(enum kith_kernel k, const struct oracle_kernel *oracle) {
  CHECK_CLOSE(value(k, 0), oracle_w(oracle, 0), 1e-14);
  for (int s = 1; s <= 1200; ++s) {
    const double q = s / 1000.0, d = 1e-4;
    CHECK_CLOSE(value(k, q), oracle_w(oracle, q), 1e-13);
    CHECK_CLOSE(q * slope(k, q), q * oracle_g(oracle, q), 1e-13);
    CHECK(slope(k, q) <= 0);
    CHECK(value(k, q) >= 0 && value(k, q) <= value(k, q - 1e-3));
    /* Truncation is d^2 w''' / 6, where w''' is up to 400, also across knots. */
    CHECK_CLOSE((value(k, q + d) - value(k, q - d)) / (2 * d), q * slope(k, q), 1e-6);
  }
}

static void check_edges(enum kith_kernel k) {
  const double outside[] = {1, nextafter(1, 2), 1.5, 16, 1e6};
  for (int s = 0; s < 5; ++s) {
    CHECK(value(k, outside[s]) == 0);
    CHECK(slope(k, outside[s]) == 0);
  }
  const double knots[] = {0.2, 1. / 3, 0.5, 0.6, 2. / 3, 1};
  for (int s = 0; s < 6; ++s) { /* w', g and g' are below 200 */
    CHECK_CLOSE(value(k, knots[s] - 1e-13), value(k, knots[s] + 1e-13), 1e-10);
    CHECK_CLOSE(slope(k, knots[s] - 1e-13), slope(k, knots[s] + 1e-13), 1e-10);
  }
  const double tiny[] = {0, 1e-300, 1e-18, 1e-14, 1e-10, 1e-6};
  for (int s = 0; s < 6; ++s) { /* a pair multiplies it by q, and q g vanishes */
    CHECK(isfinite(slope(k, tiny[s])));
    CHECK(fabs(tiny[s] * slope(k, tiny[s])) <= 100 * tiny[s] + 1e-14);
  }
}

static void check_constants(enum kith_kernel k, const struct oracle_kernel *oracle) {
  CHECK_CLOSE(oracle_sphere() * kith_kernel_constant(k) * oracle_quadrature(value_of, &k, NDIM - 1), 1,
              1e-13);
  CHECK_CLOSE(kith_kernel_constant(k), oracle->constant, 1e-13 * oracle->constant);
  CHECK_CLOSE(kith_kernel_support(k), oracle->spread, 0.51e-6);     /* the library has six digits */
  const double most = k == KITH_KERNEL_quartic ? 1.247978 : 1.2544; /* 67 neighbors in 3-D, not 68 */
  CHECK_CLOSE(kith_kernel_neighbors(k, 0), oracle_ball() * pow(most * oracle->spread, NDIM),
              4e-6 * kith_kernel_neighbors(k, 0));
}

/* The lattice with one node per unit volume has density 1. kith_kernel_gradient_sum is H / d times the
 * derivative of the density by H at constant C / H^d, here by differences (truncation: 2e-8). */
static void check_self_weight(enum kith_kernel k, const struct oracle_kernel *oracle) {
  const double usual = kith_kernel_neighbors(k, 0);
  for (int s = 0; s < 6; ++s) {
    const double neighbors = usual * (0.9 + 0.25 * s), support = pow(neighbors / oracle_ball(), 1.0 / NDIM);
    const double weight = kith_kernel_self_weight(k, neighbors);
    const double sum = weight * oracle_w(oracle, 0) + oracle_lattice_others(oracle, support);
    CHECK_CLOSE(sum * oracle->constant / pow(support, NDIM), 1, 1e-12);
    const double wider = oracle_lattice_others(oracle, support * (1 + 1e-4)),
                 narrower = oracle_lattice_others(oracle, support * (1 - 1e-4));
    CHECK_CLOSE(kith_kernel_gradient_sum(k, neighbors),
                (wider - narrower) / 2e-4 * oracle->constant / (NDIM * pow(support, NDIM)), 1e-7);
    /* The equation is solved for the weight of the node itself, whose density is W(0) = C / H^d: it corrects
     * a few per cent of that, most with few neighbors. */
    CHECK(weight > 0.5 && weight < 1.2);
    if (kith_kernel_facts[k].most_neighbors > 0) CHECK_CLOSE(weight, 1, 0.1); /* splines */
  }
}

/* The pairing limit: 2 sigma of the kernel holds equally many nodes in all dimensions. */
static void check_pairing(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k) {
    const struct oracle_kernel oracle = oracle_kernel((enum kith_kernel)k);
    const double got = kith_kernel_most_neighbors((enum kith_kernel)k);
    CHECK(kith_kernel_neighbors((enum kith_kernel)k, 0) <= got);
    const double most = kith_kernel_facts[k].most_neighbors;
    CHECK(isinf(got) == (most == 0));
    if (most == 0) continue;
    if (NDIM == 3) CHECK_CLOSE(got, most, 1e-9);
    /* From H / spacing over 2 sigma back to the number in 3-D; both spreads have six digits. */
    const double spacings = pow(got / oracle_ball(), 1. / NDIM) / oracle.spread;
    CHECK_CLOSE(4 * M_PI / 3 * pow(spacings * kith_kernel_facts[k].support[2], 3), most, 1e-5 * most);
  }
  CHECK(kith_kernel_unpaired(1) == KITH_KERNEL_wendland_c2);
  CHECK(kith_kernel_unpaired(kith_kernel_neighbors(KITH_KERNEL_wendland_c4, 0)) == KITH_KERNEL_wendland_c4);
  enum kith_kernel last = KITH_KERNEL_wendland_c2;
  for (int k = last; k < KITH_N_KERNELS; ++k)
    if (kith_kernel_facts[k].most_neighbors == 0) last = (enum kith_kernel)k;
  CHECK(kith_kernel_unpaired(1000) == last);
}

/* Figures of Dehnen and Aly (2012), and the default of kernel.h. */
static void check_figures(void) {
  CHECK(kith_kernel_facts[KITH_KERNEL_cubic].most_neighbors == 55 &&
        kith_kernel_facts[KITH_KERNEL_quartic].most_neighbors == 67 &&
        kith_kernel_facts[KITH_KERNEL_quintic].most_neighbors == 190);
  if (NDIM == 3) CHECK_CLOSE(kith_kernel_neighbors(KITH_KERNEL_wendland_c2, 0), 60, 0.1);
}

int main(void) {
  check_figures();
  check_pairing();
  for (int k = 0; k < KITH_N_KERNELS; ++k) {
    const struct oracle_kernel oracle = oracle_kernel((enum kith_kernel)k);
    check_shape((enum kith_kernel)k, &oracle);
    check_edges((enum kith_kernel)k);
    check_constants((enum kith_kernel)k, &oracle);
    check_self_weight((enum kith_kernel)k, &oracle);
  }
  return check_failed();
}
