#include "physics/kernel.h"

#include <string.h>

const struct kith_kernel_facts kith_kernel_facts[KITH_N_KERNELS] = {
#define X(name, words, c1, c2, c3, s1, s2, s3) {words, {c1, c2, c3}, {s1, s2, s3}},
    KITH_KERNEL_LIST(X)
#undef X
};

enum kith_kernel kith_kernel_find(const char *name) {
  for (int k = 0; k < KITH_N_KERNELS; ++k)
    if (strcmp(kith_kernel_facts[k].name, name) == 0) return (enum kith_kernel)k;
  return KITH_N_KERNELS;
}

double kith_kernel_neighbors(enum kith_kernel k) {
  const double spacings = 1.2544; /* 2 sigma in node spacings: 60 neighbors for Wendland C2 in 3-D */
  return kith_ball() * kith_pow_dim(spacings * kith_kernel_support(k));
}
