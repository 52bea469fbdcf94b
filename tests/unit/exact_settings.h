/* exact_settings.h - for tests: the parameters that tests of exact solutions name, in one struct; a member's
 * settings from it and back, by key. What a member has beside these comes from its own table. */
#ifndef KITH_TESTS_EXACT_SETTINGS_H
#define KITH_TESTS_EXACT_SETTINGS_H

#include <math.h>
#include <stdlib.h>
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

enum { EXACT_NUMBERS = 64 };

/* A number of a range "(a, b]", where one end at most is infinite. */
static inline double exact_in_range(const char *range) {
  if (range[0] == '\0') return 0.5;
  const double lower = strtod(range + 1, NULL), upper = strtod(strchr(range, ',') + 1, NULL);
  return isinf(upper) ? lower + 0.5 : isinf(lower) ? upper - 0.5 : 0.5 * (lower + upper);
}

/* The member's settings; keys that are not in the struct have their default, or some value of their range. */
static inline void exact_fill(double settings[EXACT_NUMBERS], const struct kith_exact_ops *ops,
                              const struct exact_parameters *p) {
  memset(settings, 0, EXACT_NUMBERS * sizeof *settings);
  CHECK(ops->settings_size <= EXACT_NUMBERS * sizeof *settings);
  CHECK_OK(kith_params_defaults(ops->params, settings));
  for (const struct kith_param *row = ops->params; row->key != NULL; ++row) {
    const struct kith_param *from = kith_params_find(exact_rows, row->key);
    double *into = (double *)((char *)settings + row->offset);
    CHECK(from == NULL || from->size >= row->size);
    if (from != NULL) memcpy(into, (const char *)p + from->offset, row->size);
    for (size_t k = 0; from == NULL && row->fallback == NULL && k < row->size / sizeof *into; ++k)
      into[k] = exact_in_range(row->allowed);
  }
}

/* As create of the family. */
static inline kith_status exact_create(void **self, const struct kith_exact_ops *ops,
                                       const struct exact_parameters *p) {
  double settings[EXACT_NUMBERS];
  exact_fill(settings, ops, p);
  return kith_exact_create(self, ops, settings);
}

/* What settings say; 0 for parameters that the member has not. One number stands for both sides. */
static inline struct exact_parameters exact_parameters_of(const struct kith_exact_ops *ops,
                                                          const void *settings) {
  struct exact_parameters p = {0};
  for (const struct kith_param *row = ops->params; row->key != NULL; ++row) {
    const struct kith_param *to = kith_params_find(exact_rows, row->key);
    CHECK(to == NULL || to->size >= row->size);
    if (to != NULL) memcpy((char *)&p + to->offset, (const char *)settings + row->offset, row->size);
  }
  return p;
}

#endif
