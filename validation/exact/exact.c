/* The family of exact solutions: creating one from checked settings; places and speeds along its line. */
#include "validation/exact/exact.h"

#include "lib/core/family.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define X(name) &kith_exact_##name,
KITH_FAMILY(kith_exact, KITH_EXACT_LIST(X))
#undef X

kith_status kith_exact_create(void **self, const struct kith_exact_ops *ops, const void *settings) {
  char who[64];
  char *copy = NULL;
  *self = NULL;
  snprintf(who, sizeof who, "exact solution %s", ops->name);
  KITH_TRY(kith_params_check(ops->params, who, settings));
  if (ops->vortex && NDIM == 1)
    KITH_FAIL(BAD_INPUT, "exact solution %s: a vortex needs 2 or 3 dimensions", ops->name);
  if (ops->check != NULL) KITH_TRY(ops->check(settings));
  if (ops->create != NULL) return ops->create(self, settings);
  KITH_TRY(kith_resize(&copy, 0, ops->settings_size, 1));
  memcpy(copy, settings, ops->settings_size);
  *self = copy;
  return KITH_OK;
}

const double *kith_exact_center(const struct kith_exact_ops *ops, const void *self) {
  return ops->radial ? ((const struct kith_exact_gas *)self)->center : NULL;
}

double kith_exact_place(const struct kith_exact_ops *ops, const double *center, const double *x) {
  if (center == NULL) return x[0];
  double r2 = 0;
  for (int a = 0; a < NDIM && !(a == 2 && ops != NULL && ops->vortex); ++a)
    r2 += (x[a] - center[a]) * (x[a] - center[a]);
  return sqrt(r2);
}

double kith_exact_speed(const struct kith_exact_ops *ops, const double *center, const double *x,
                        const double *velocity) {
  if (center == NULL) return velocity[NDIM > 1 && ops != NULL && ops->transverse];
  const double r = kith_exact_place(ops, center, x);
  double s = 0;
  if (r <= 0) return 0;
  if (NDIM > 1 && ops != NULL && ops->vortex)
    s = velocity[NDIM > 1] * (x[0] - center[0]) - velocity[0] * (x[NDIM > 1] - center[NDIM > 1]);
  else
    for (int a = 0; a < NDIM; ++a) s += velocity[a] * (x[a] - center[a]);
  return s / r;
}
