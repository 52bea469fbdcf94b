/* exact_settings.h - for tests: the parameters of all exact solutions in one struct; a member's settings from
 * it and back, by key. */
#ifndef KITH_TESTS_EXACT_SETTINGS_H
#define KITH_TESTS_EXACT_SETTINGS_H

#include <string.h>
#include "tests/check.h"
#include "validation/exact/exact.h"

struct exact_parameters {
  double gamma[2], density[2], velocity[2], pressure[2]; /* [0]: undisturbed, or left, or inside */
  double uniform_velocity[NDIM], center[NDIM], period[NDIM], side[NDIM];
  double interface_position, blast_energy, omega, end_time, amplitude, wavelength, origin;
};

#define EXACT_ROW(key) \
  { #key, KITH_PARAM_OTHER, "", "", "", KITH_INTO(struct exact_parameters, key), .params = NULL }
static const struct kith_param exact_rows[] = {EXACT_ROW(gamma),
                                               EXACT_ROW(density),
                                               EXACT_ROW(velocity),
                                               EXACT_ROW(pressure),
                                               EXACT_ROW(uniform_velocity),
                                               EXACT_ROW(center),
                                               EXACT_ROW(period),
                                               EXACT_ROW(side),
                                               EXACT_ROW(interface_position),
                                               EXACT_ROW(blast_energy),
                                               EXACT_ROW(omega),
                                               EXACT_ROW(end_time),
                                               EXACT_ROW(amplitude),
                                               EXACT_ROW(wavelength),
                                               EXACT_ROW(origin),
                                               {0}};

/* As create of the family, from the parameters that the member has. */
static inline kith_status exact_create(void **self, const struct kith_exact_ops *ops,
                                       const struct exact_parameters *p) {
  double settings[64] = {0};
  CHECK(ops->settings_size <= sizeof settings);
  for (const struct kith_param *row = ops->params; row->key != NULL; ++row) {
    const struct kith_param *from = kith_params_find(exact_rows, row->key);
    CHECK(from != NULL && from->size >= row->size);
    if (from != NULL) memcpy((char *)settings + row->offset, (const char *)p + from->offset, row->size);
  }
  return kith_exact_create(self, ops, settings);
}

/* What settings say; 0 for parameters that the member has not. One number stands for both sides. */
static inline struct exact_parameters exact_parameters_of(const struct kith_exact_ops *ops,
                                                          const void *settings) {
  struct exact_parameters p = {0};
  for (const struct kith_param *row = ops->params; row->key != NULL; ++row) {
    const struct kith_param *to = kith_params_find(exact_rows, row->key);
    CHECK(to != NULL && to->size >= row->size);
    if (to != NULL) memcpy((char *)&p + to->offset, (const char *)settings + row->offset, row->size);
  }
  return p;
}

#endif
