/* exact_parameters.h - private to the members of the family: parameters and formulas that several have. */
#ifndef KITH_VALIDATION_EXACT_EXACT_PARAMETERS_H
#define KITH_VALIDATION_EXACT_EXACT_PARAMETERS_H

#include <math.h>
#include "validation/exact/exact.h"

/* Rows of a table; `type` is the tag of the member's settings. */
#define KITH_EXACT_GAMMA(type) \
  { "gamma", KITH_PARAM_NUMBER, NULL, "(1, inf)", "ratio of specific heats", KITH_INTO(struct type, gamma) }
#define KITH_EXACT_DENSITY(type, text) \
  { "density", KITH_PARAM_NUMBER, NULL, "(0, inf)", text, KITH_INTO(struct type, density), .unit = "density" }
#define KITH_EXACT_PRESSURE(type, range, text) \
  { "pressure", KITH_PARAM_NUMBER, NULL, range, text, KITH_INTO(struct type, pressure), .unit = "pressure" }
#define KITH_EXACT_CENTER(type)                                                                      \
  {                                                                                                  \
    "center", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "of the symmetry", KITH_INTO(struct type, center), \
        .unit = "length"                                                                             \
  }
#define KITH_EXACT_VELOCITY(type)                                           \
  {                                                                         \
    "uniform_velocity", KITH_PARAM_VECTOR, "[0, 0, 0]", "", "of the whole", \
        KITH_INTO(struct type, uniform_velocity), .unit = "velocity"        \
  }
#define KITH_EXACT_PERIOD(type)                                                                          \
  {                                                                                                      \
    "period", KITH_PARAM_VECTOR, "[0, 0, 0]", "[0, inf)",                                                \
        "sides of the periodic box that it is carried through; 0: none", KITH_INTO(struct type, period), \
        .unit = "length"                                                                                 \
  }

/* Sides of the domain along its periodic axes. */
static inline void kith_exact_derive_period(double *period, const struct kith_exact_scene *scene) {
  for (int a = 0; a < NDIM; ++a)
    if (scene->axis[a].periodic) period[a] = scene->upper[a] - scene->lower[a];
}

static inline void kith_exact_derive_velocity(double *velocity, const struct kith_exact_scene *scene) {
  for (int a = 0; a < NDIM; ++a) velocity[a] = scene->region[0].velocity[a];
}

/* x from a center that is carried along, to its nearest image in a periodic box: component a. */
static inline double kith_exact_carried(double x, double center, double velocity, double period,
                                        double time) {
  const double d = x - center - velocity * time;
  return period > 0 ? d - period * round(d / period) : d;
}

/* Energy per unit mass of an ideal gas; 0 in a vacuum. */
static inline double kith_exact_energy(double gamma, double density, double pressure) {
  return density > 0 ? pressure / density / (gamma - 1) : 0;
}

#endif
