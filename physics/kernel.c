/* Kernels: their constants, default numbers of neighbors, self weights. */
#include "physics/kernel.h"

const struct kith_kernel_facts kith_kernel_facts[KITH_N_KERNELS] = {
#define X(name, words, doc, most, c1, c2, c3, s1, s2, s3) {words, doc, most, {c1, c2, c3}, {s1, s2, s3}},
    KITH_KERNEL_LIST(X)
#undef X
};

/* Returns the number of neighbors of a kernel with this many node spacings in 2 sigma. */
static double neighbors_of(enum kith_kernel k, double spacings) {
  return kith_ball() * kith_pow_dim(spacings * kith_kernel_support(k));
}

double kith_kernel_most_neighbors(enum kith_kernel k) {
  const struct kith_kernel_facts *facts = &kith_kernel_facts[k];
  if (facts->most_neighbors <= 0) return INFINITY;
  return neighbors_of(k, cbrt(3 * facts->most_neighbors / (4 * M_PI)) / facts->support[2]);
}

double kith_kernel_neighbors(enum kith_kernel k, double spacings) {
  return fmin(neighbors_of(k, spacings > 0 ? spacings : 1.2544), kith_kernel_most_neighbors(k));
}

enum kith_kernel kith_kernel_unpaired(double neighbors) {
  int best = -1;
  for (int k = 0; k < KITH_N_KERNELS; ++k)
    if (kith_kernel_facts[k].most_neighbors <= 0 &&
        (best < 0 || kith_kernel_neighbors((enum kith_kernel)k, 0) <= neighbors))
      best = k;
  return (enum kith_kernel)best;
}

/* Sets x to node b of cell c of the ideal lattice with one node per unit volume. */
static void lattice_node(const int *c, int b, double *x) {
#if NDIM == 1
  (void)b;
  x[0] = c[0];
#elif NDIM == 2 /* rows of spacing s, sqrt(3) s / 2 apart: s^2 sqrt(3) / 2 = 1 */
  const double s = sqrt(2 / sqrt(3));
  x[0] = s * (c[0] + 0.5 * b);
  x[1] = s * sqrt(3) * (c[1] + 0.5 * b);
#else           /* four nodes in a cube of side 4^(1/3) */
  const double a = cbrt(4);
  for (int k = 0; k < NDIM; ++k) x[k] = a * (c[k] + (b > 0 && b != k + 1 ? 0.5 : 0.0));
#endif
}

/* Sums w and -q^2 g over the other nodes of the ideal lattice within a support. */
static void lattice_sums(enum kith_kernel k, double support, double *sum_w, double *sum_q2g) {
  const int nodes_per_cell = NDIM == 1 ? 1 : NDIM == 2 ? 2 : 4, cells = (int)ceil(support) + 1;
  *sum_w = *sum_q2g = 0;
  for (int c0 = -cells; c0 <= cells; ++c0)
    for (int c1 = NDIM > 1 ? -cells : 0; c1 <= (NDIM > 1 ? cells : 0); ++c1)
      for (int c2 = NDIM > 2 ? -cells : 0; c2 <= (NDIM > 2 ? cells : 0); ++c2)
        for (int b = 0; b < nodes_per_cell; ++b) {
          const int c[] = {c0, c1, c2};
          double x[NDIM], w, g;
          lattice_node(c, b, x);
          const double q = kith_norm(x) / support;
          if (q == 0) continue;
          kith_kernel_value(k, q, &w, &g);
          *sum_w += w, *sum_q2g -= q * q * g;
        }
}

double kith_kernel_self_weight(enum kith_kernel k, double neighbors) {
  double w, g, others, ignored;
  lattice_sums(k, kith_root_dim(neighbors / kith_ball()), &others, &ignored);
  kith_kernel_value(k, 0, &w, &g);
  return (neighbors / (kith_ball() * kith_kernel_constant(k)) - others) / w;
}

double kith_kernel_gradient_sum(enum kith_kernel k, double neighbors) {
  double ignored, sum;
  lattice_sums(k, kith_root_dim(neighbors / kith_ball()), &ignored, &sum);
  return kith_kernel_constant(k) * kith_ball() / (neighbors * NDIM) * sum;
}
