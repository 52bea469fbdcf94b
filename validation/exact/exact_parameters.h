/* exact_parameters.h - private to the members of the family: parameters and formulas that several have. */
#ifndef KITH_VALIDATION_EXACT_EXACT_PARAMETERS_H
#define KITH_VALIDATION_EXACT_EXACT_PARAMETERS_H

#include <math.h>
#include "validation/exact/exact.h"

/* Rows of a table of parameters that are members of struct kith_exact_gas. */
#define KITH_EXACT_ROW(key, kind, fallback, range, text) \
  { #key, KITH_PARAM_##kind, fallback, range, text, KITH_INTO(struct kith_exact_gas, key) }
#define KITH_EXACT_GAMMA KITH_EXACT_ROW(gamma, NUMBER, NULL, "(1, inf)", "ratio of specific heats")
#define KITH_EXACT_DENSITY(text) KITH_EXACT_ROW(density, NUMBER, NULL, "(0, inf)", text)
#define KITH_EXACT_PRESSURE(range, text) KITH_EXACT_ROW(pressure, NUMBER, NULL, range, text)
#define KITH_EXACT_CENTER KITH_EXACT_ROW(center, VECTOR, "[0, 0, 0]", "", "center of the symmetry")
#define KITH_EXACT_VELOCITY \
  KITH_EXACT_ROW(uniform_velocity, VECTOR, "[0, 0, 0]", "", "added to all velocities")
#define KITH_EXACT_PERIOD                                 \
  KITH_EXACT_ROW(period, VECTOR, "[0, 0, 0]", "[0, inf)", \
                 "sides of the periodic box that it is carried through; 0: none")

/* Does the region have all of the domain across axis 0, and nothing but other gas acts on it? */
static inline bool kith_exact_spans(const struct kith_exact_scene *scene,
                                    const struct kith_exact_region *region) {
  bool spans = !scene->forced && !region->irregular;
  for (int a = 1; a < NDIM; ++a) {
    const double close = 1e-12 * (scene->upper[a] - scene->lower[a]);
    spans =
        spans && region->lower[a] <= scene->lower[a] + close && region->upper[a] >= scene->upper[a] - close;
  }
  return spans;
}

/* Sets half[2] to the left and the right one of two regions that touch along axis 0 and reach across the
 * domain, in whatever order the scene has them. Along axis 0 they may end before it does: then windows leave
 * out their ends. False if the scene does not have two such regions. */
static inline bool kith_exact_halves(const struct kith_exact_scene *scene,
                                     const struct kith_exact_region *half[2]) {
  const struct kith_exact_region *first = &scene->region[0], *second = &scene->region[1];
  const bool swapped = first->lower[0] > second->lower[0] || first->upper[0] > second->upper[0];
  half[0] = swapped ? second : first, half[1] = swapped ? first : second;
  return scene->n_regions == 2 &&
         fabs(half[0]->upper[0] - half[1]->lower[0]) <= 1e-12 * (scene->upper[0] - scene->lower[0]) &&
         kith_exact_spans(scene, half[0]) && kith_exact_spans(scene, half[1]);
}

static inline double kith_exact_ideal_gamma(const struct kith_exact_region *region) {
  return region->stiffness == 0 && !region->barotropic ? region->gamma : NAN;
}

/* derive() of a gas: the values of the first region, and the sides of the domain along its periodic axes. */
static inline void kith_exact_derive_gas(void *settings, const struct kith_exact_scene *scene) {
  struct kith_exact_gas *gas = settings;
  gas->gamma = kith_exact_ideal_gamma(&scene->region[0]);
  gas->density = scene->region[0].density;
  gas->pressure = scene->region[0].pressure;
  for (int a = 0; a < NDIM; ++a)
    if (scene->axis[a].periodic) gas->period[a] = scene->upper[a] - scene->lower[a];
}
/* derive() of a gas that moves: kith_exact_derive_gas, and the velocity of the first region. */
static inline void kith_exact_derive_moving(void *settings, const struct kith_exact_scene *scene) {
  struct kith_exact_gas *gas = settings;
  kith_exact_derive_gas(settings, scene);
  for (int a = 0; a < NDIM; ++a) gas->uniform_velocity[a] = scene->region[0].velocity[a];
}

/* Energy per unit mass of an ideal gas; 0 in a vacuum. */
static inline double kith_exact_energy(double gamma, double density, double pressure) {
  return density > 0 ? pressure / density / (gamma - 1) : 0;
}

/* The gas in its uniform motion, with this density and pressure. */
static inline struct kith_exact_state kith_exact_moving(const struct kith_exact_gas *gas, double density,
                                                        double pressure) {
  struct kith_exact_state state = {.density = density, .pressure = pressure};
  state.energy = kith_exact_energy(gas->gamma, density, pressure);
  for (int a = 0; a < NDIM; ++a) state.velocity[a] = gas->uniform_velocity[a];
  return state;
}

/* The gas in its uniform motion, turning counterclockwise as well, with angular velocity `turn`. */
static inline struct kith_exact_state kith_exact_turning(const struct kith_exact_gas *gas, double density,
                                                         double pressure, const double *offset, double turn) {
  struct kith_exact_state state = kith_exact_moving(gas, density, pressure);
  state.velocity[0] -= turn * offset[1];
  state.velocity[NDIM > 1 ? 1 : 0] += turn * offset[0];
  return state;
}

#endif
