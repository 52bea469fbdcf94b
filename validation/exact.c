#include "validation/exact_parameters.h"

#include "lib/core/family.h"

#include <math.h>

#define X(name) &kith_exact_##name,
KITH_FAMILY(kith_exact, KITH_EXACT_LIST(X))
#undef X

kith_status kith_exact_require(bool holds, const char *member, const char *parameter, double value,
                               const char *range) {
  if (holds && isfinite(value)) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution %s: %s is %g, must be %s", member, parameter, value, range);
}

double kith_exact_place(const struct kith_exact_ops *ops, const double *center, const double *x) {
  if (center == NULL) return x[0];
  double r2 = 0;
  for (int a = 0; a < NDIM && !(a == 2 && ops->vortex); ++a) r2 += (x[a] - center[a]) * (x[a] - center[a]);
  return sqrt(r2);
}

double kith_exact_speed(const struct kith_exact_ops *ops, const double *center, const double *x,
                        const double *velocity) {
  if (center == NULL) return velocity[0];
  const double r = kith_exact_place(ops, center, x);
  double s = 0;
  if (r <= 0) return 0;
  if (NDIM > 1 && ops->vortex)
    s = velocity[NDIM > 1] * (x[0] - center[0]) - velocity[0] * (x[NDIM > 1] - center[NDIM > 1]);
  else
    for (int a = 0; a < NDIM; ++a) s += velocity[a] * (x[a] - center[a]);
  return s / r;
}

void kith_exact_destroy(void **self) {
  kith_free(self);
}
