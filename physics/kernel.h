/* kernel.h - smoothing kernels of compact support, one family.
 *
 *   W(r, H) = C / H^d w(q),  q = r / H,  w(q >= 1) = 0
 *   grad_i W = C / H^(d + 2) g(q) x_ij,  g = w'(q) / q  (finite at 0, <= 0),  x_ij = x_i - x_j
 *
 * H is the radius of the support. `support` is H / (2 sigma), sigma the standard deviation of the kernel
 * (Dehnen and Aly 2012): the length 2 sigma is comparable between kernels, and is what the Courant condition
 * uses. Splines: M4, M5, M6 (Schoenberg). Wendland functions have one form in 1-D and another in 2-D and
 * 3-D. */
#ifndef KITH_PHYSICS_KERNEL_H
#define KITH_PHYSICS_KERNEL_H

#include <math.h>
#include "lib/core/vec.h"

/* identifier, name, doc, most neighbors in 3-D before nodes pair up (0: they never do; Dehnen and Aly 2012,
 * found by relaxing noisy lattices), C in 1-D, 2-D, 3-D, H / (2 sigma) in 1-D, 2-D, 3-D */
#define KITH_KERNEL_LIST_WITH(X, argument)                                                                  \
  X(argument, cubic, "cubic", "spline M4: the shortest support; pairs up if given many neighbors", 55,      \
    8. / 3, 80 / (7 * M_PI), 16 / M_PI, 1.732051, 1.778002, 1.825742)                                       \
  X(argument, quartic, "quartic", "spline M5: smoother, for more neighbors", 67, 3125. / 768,               \
    46875 / (2398 * M_PI), 15625 / (512 * M_PI), 1.936492, 1.977173, 2.018932)                              \
  X(argument, quintic, "quintic", "spline M6: the smoothest of the splines", 190, 243. / 40,                \
    15309 / (478 * M_PI), 2187 / (40 * M_PI), 2.121320, 2.158130, 2.195775)                                 \
  X(argument, wendland_c2, "wendland-c2", "never clumps, however many neighbors: the default", 0, 5. / 4,   \
    7 / M_PI, 21 / (2 * M_PI), 1.620185, 1.897367, 1.936492)                                                \
  X(argument, wendland_c4, "wendland-c4", "never clumps; smoother, for about 100 neighbors in 3-D", 0,      \
    3. / 2, 9 / M_PI, 495 / (32 * M_PI), 1.936492, 2.171241, 2.207940)                                      \
  X(argument, wendland_c6, "wendland-c6", "never clumps; the smoothest, for about 200 neighbors in 3-D", 0, \
    55. / 32, 78 / (7 * M_PI), 1365 / (64 * M_PI), 2.207940, 2.415229, 2.449490)
#define KITH_KERNEL_LIST(X) KITH_KERNEL_LIST_WITH(KITH_KERNEL_WITHOUT_, X)
#define KITH_KERNEL_WITHOUT_(X, ...) X(__VA_ARGS__)

enum kith_kernel {
#define X(name, ...) KITH_KERNEL_##name,
  KITH_KERNEL_LIST(X)
#undef X
      KITH_N_KERNELS
};

struct kith_kernel_facts {
  const char *name, *doc;
  double most_neighbors;          /* in 3-D; 0: any number */
  double constant[3], support[3]; /* by dimension - 1 */
};
extern const struct kith_kernel_facts kith_kernel_facts[KITH_N_KERNELS];

static inline double kith_kernel_constant(enum kith_kernel k) {
  return kith_kernel_facts[k].constant[NDIM - 1];
}
static inline double kith_kernel_support(enum kith_kernel k) {
  return kith_kernel_facts[k].support[NDIM - 1];
}

/* Returns the default number of neighbors (ball H^d n): for so many node spacings in 2 sigma (0: the usual
 * 1.2544, which are 60 neighbors for Wendland C2 in 3-D), but no more than kith_kernel_most_neighbors. */
double kith_kernel_neighbors(enum kith_kernel k, double spacings);
/* Returns the number of neighbors beyond which nodes pair up, INFINITY if they never do. The figures are for
 * 3-D; in 1-D and 2-D the same number of nodes along 2 sigma is taken. */
double kith_kernel_most_neighbors(enum kith_kernel k);
/* Returns a kernel with which nodes never pair up: the last of the list whose default is no more than these
 * neighbors, else the first. */
enum kith_kernel kith_kernel_unpaired(double neighbors);

/* Returns the weight of a node in its own sum, close to 1, that makes the density of an ideal lattice (line,
 * triangular, face-centered) exact: Wendland functions overestimate it with few neighbors (Dehnen and Aly
 * 2012, section 2.6; here solved, not fitted). */
double kith_kernel_self_weight(enum kith_kernel k, double neighbors);
/* Returns -(1 / d) sum_j V x_ij . grad_i W over this lattice, which is 1 for an integral: the fraction of a
 * diffusive flow that gradients of the kernel give (physics/passes/diffusion.h). */
double kith_kernel_gradient_sum(enum kith_kernel k, double neighbors);

static inline double kith_cube_(double a) {
  return a * a * a;
}
static inline double kith_fourth_(double a) {
  return (a * a) * (a * a);
}

/* Computes w(q) and g(q). With a compile-time constant `k` the switch vanishes and loops vectorize. */
KITH_INLINE void kith_kernel_value(enum kith_kernel k, double q, double *w, double *g) {
  const double a = KITH_MAX(1 - q, 0.0);
  *w = *g = NAN;
  switch (k) { /* without a default: the compiler warns of a kernel that is not here */
    case KITH_N_KERNELS:
      return;
    case KITH_KERNEL_cubic: {
      const double b = KITH_MAX(0.5 - q, 0.0);
      *w = kith_cube_(a) - 4 * kith_cube_(b);
      *g = (12 * b * b - 3 * a * a) / KITH_MAX(q, 1e-12);
      return;
    }
    case KITH_KERNEL_quartic: {
      const double b = KITH_MAX(0.6 - q, 0.0), c = KITH_MAX(0.2 - q, 0.0);
      *w = kith_fourth_(a) - 5 * kith_fourth_(b) + 10 * kith_fourth_(c);
      *g = (20 * kith_cube_(b) - 4 * kith_cube_(a) - 40 * kith_cube_(c)) / KITH_MAX(q, 1e-12);
      return;
    }
    case KITH_KERNEL_quintic: {
      const double b = KITH_MAX(2. / 3 - q, 0.0), c = KITH_MAX(1. / 3 - q, 0.0);
      *w = a * kith_fourth_(a) - 6 * b * kith_fourth_(b) + 15 * c * kith_fourth_(c);
      *g = (30 * kith_fourth_(b) - 5 * kith_fourth_(a) - 75 * kith_fourth_(c)) / KITH_MAX(q, 1e-12);
      return;
    }
    case KITH_KERNEL_wendland_c2:
      *w = NDIM == 1 ? kith_cube_(a) * (1 + 3 * q) : kith_fourth_(a) * (1 + 4 * q);
      *g = NDIM == 1 ? -12 * a * a : -20 * kith_cube_(a);
      return;
    case KITH_KERNEL_wendland_c4:
      *w = NDIM == 1 ? a * kith_fourth_(a) * (1 + q * (5 + 8 * q))
                     : a * a * kith_fourth_(a) * (1 + q * (6 + 35. / 3 * q));
      *g = NDIM == 1 ? -14 * kith_fourth_(a) * (1 + 4 * q) : -56. / 3 * a * kith_fourth_(a) * (1 + 5 * q);
      return;
    case KITH_KERNEL_wendland_c6: {
      const double a4 = kith_fourth_(a);
      *w = NDIM == 1 ? kith_cube_(a) * a4 * (1 + q * (7 + q * (19 + 21 * q)))
                     : a4 * a4 * (1 + q * (8 + q * (25 + 32 * q)));
      *g = NDIM == 1 ? -6 * a * a * a4 * (3 + q * (18 + 35 * q))
                     : -22 * kith_cube_(a) * a4 * (1 + q * (7 + 16 * q));
      return;
    }
  }
}

/* Returns C / H^(d + 2) g(q), the factor of x_ij in grad_i W, with C = kith_kernel_constant(k). */
KITH_INLINE double kith_kernel_gradient(enum kith_kernel k, double constant, double q,
                                        double inverse_support) {
  double w, g;
  kith_kernel_value(k, q, &w, &g);
  return constant * g * kith_pow_dim(inverse_support) * inverse_support * inverse_support;
}

#endif
