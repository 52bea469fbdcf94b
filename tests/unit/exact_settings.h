/* exact_settings.h - for tests of exact solutions: one struct of the parameters that these tests set, and
 * functions that copy them by key into the settings of a solution and back. Parameters that the struct lacks
 * get the defaults of the solution. */
#ifndef KITH_TESTS_EXACT_SETTINGS_H
#define KITH_TESTS_EXACT_SETTINGS_H

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "tests/check.h"
#include "validation/exact/exact.h"

struct exact_parameters {
  double gamma[2], density[2], velocity[2], pressure[2]; /* [0]: undisturbed, left or inside */
  double uniform_velocity[NDIM], center[NDIM], period[NDIM], side[NDIM];
  double interface_position, blast_energy, omega, start, end_time, amplitude, wavelength, origin, focus_time;
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
                                               EXACT_ROW(start),
                                               EXACT_ROW(end_time),
                                               EXACT_ROW(amplitude),
                                               EXACT_ROW(wavelength),
                                               EXACT_ROW(origin),
                                               EXACT_ROW(focus_time),
                                               {0}};

enum { EXACT_NUMBERS = 64 };

/* Returns a number inside a range like "(a, b]", one end of which may be infinite. */
static inline double exact_in_range(const char *range) {
  if (range[0] == '\0') return 0.5;
  const double lower = strtod(range + 1, NULL), upper = strtod(strchr(range, ',') + 1, NULL);
  return isinf(upper) ? lower + 0.5 : isinf(lower) ? upper - 0.5 : 0.5 * (lower + upper);
}

/* Fills the settings of a solution. Keys that the struct lacks get their default, or a number inside their
 * range. */
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

/* Creates the solution, as kith_exact_create does, with these parameters. */
static inline kith_status exact_create(void **self, const struct kith_exact_ops *ops,
                                       const struct exact_parameters *p) {
  double settings[EXACT_NUMBERS];
  exact_fill(settings, ops, p);
  return kith_exact_create(self, ops, settings);
}

/* Copies settings back into the struct; parameters that the solution lacks are 0. Where a setting is a single
 * number, only [0] is set. */
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
