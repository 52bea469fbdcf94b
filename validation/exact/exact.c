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

const struct kith_exact_gas *kith_exact_about(const struct kith_exact_ops *ops, const void *self) {
  return ops->radial ? self : NULL;
}

void kith_exact_offset(const struct kith_exact_gas *about, const double *x, double time, double offset[3]) {
  offset[0] = offset[1] = offset[2] = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = x[a] - about->center[a] - about->uniform_velocity[a] * time;
    offset[a] = about->period[a] > 0 ? d - about->period[a] * rint(d / about->period[a]) : d;
  }
}

/* Vector to x from the center, or the axis of a vortex. */
static void offset_of(const struct kith_exact_ops *ops, const struct kith_exact_gas *about, const double *x,
                      double time, double offset[3]) {
  kith_exact_offset(about, x, time, offset);
  if (ops != NULL && ops->vortex) offset[2] = 0;
}

double kith_exact_place(const struct kith_exact_ops *ops, const struct kith_exact_gas *about, const double *x,
                        double time) {
  double d[3];
  if (about == NULL) return x[0];
  offset_of(ops, about, x, time, d);
  return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

double kith_exact_speed(const struct kith_exact_ops *ops, const struct kith_exact_gas *about, const double *x,
                        double time, const double *velocity) {
  if (about == NULL) return velocity[NDIM > 1 && ops != NULL && ops->transverse];
  const double r = kith_exact_place(ops, about, x, time);
  double d[3], v[3] = {0}, s = 0;
  if (r <= 0) return 0;
  offset_of(ops, about, x, time, d);
  for (int a = 0; a < NDIM; ++a) v[a] = velocity[a] - about->uniform_velocity[a];
  if (ops != NULL && ops->vortex)
    s = v[1] * d[0] - v[0] * d[1];
  else
    for (int a = 0; a < NDIM; ++a) s += v[a] * d[a];
  return s / r;
}
