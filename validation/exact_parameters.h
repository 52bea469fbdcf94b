/* exact_parameters.h - private to the members of the family: what they share. */
#ifndef KITH_VALIDATION_EXACT_PARAMETERS_H
#define KITH_VALIDATION_EXACT_PARAMETERS_H

#include "validation/exact.h"

/* OK if `holds` and the value is finite, else BAD_INPUT with one line: member, parameter, value, allowed
 * range. */
kith_status kith_exact_require(bool holds, const char *member, const char *parameter, double value,
                               const char *range);

/* The destroy of members that own one block of memory. */
void kith_exact_destroy(void **self);

/* Energy per unit mass of an ideal gas; 0 in a vacuum. */
static inline double kith_exact_energy(double gamma, double density, double pressure) {
  return density > 0 ? pressure / density / (gamma - 1) : 0;
}

#endif
