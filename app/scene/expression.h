/* expression.h - a number or a formula in x, y, z, r, t from a scene, evaluated by muParser. */
#ifndef KITH_APP_SCENE_EXPRESSION_H
#define KITH_APP_SCENE_EXPRESSION_H

#include "lib/core/base.h"

struct kith_expression; /* opaque */

/* Parses a formula. BAD_INPUT with the parser's reason and the place in the formula. x, y, z, r, t, pi, e and
 * the functions of muParser are known. Coordinates beyond the dimension are 0. r = |x|. t is the time: 0
 * until it is set. */
kith_status kith_expression_create(struct kith_expression **out, const char *formula);
void kith_expression_destroy(struct kith_expression **expression);
/* Value at x[n], n from 1 to 3; BAD_INPUT if it is not finite. Not thread-safe on one object. */
kith_status kith_expression_at(struct kith_expression *expression, int n, const double *x, double *value);
/* Sets t for all evaluations that follow; `expression` may be NULL. */
void kith_expression_time(struct kith_expression *expression, double time);
/* Does the formula contain t? NULL: no. */
bool kith_expression_is_timed(const struct kith_expression *expression);
/* The value of a formula without variables; NaN if it has some, or is not finite, or if it is NULL. */
double kith_expression_constant(struct kith_expression *expression);

#endif
