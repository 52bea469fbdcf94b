/* bench_reference.h - loops that anybody could have written: what a figure is measured by. */
#ifndef KITH_APP_BENCH_REFERENCE_H
#define KITH_APP_BENCH_REFERENCE_H

#include "app/model.h"

/* Bytes per second of a[i] = b[i] + 3 c[i] over 3 arrays of 2^24 doubles, 24 bytes counted an element; best of five. */
kith_status kith_reference_triad(double *bytes_per_second);
/* Seconds per node of a plain density sum, and of a plain viscous force sum, over the rows of a model: one scalar loop each, fixed supports,
 * nothing kept between them; best of three. */
void kith_reference_loops(const struct kith_model *model, double *density, double *force);

#endif
