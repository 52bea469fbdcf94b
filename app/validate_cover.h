/* validate_cover.h - few combinations in which every pair of values of two factors occurs.
 *
 * All combinations of 5 factors are thousands; what fails does so, as a rule, by two of them together. Rows are made one
 * at a time: each begins with the first pair that has not occurred, and gives the other factors, one after the other, the
 * value that adds the most new pairs (of these the one that was used least). That is the greedy way of Cohen, Dalal, Fredman and
 * Patton, IEEE Trans. Softw. Eng. 23, 437 (1997), without its dice. At least the product of the two largest factors. */
#ifndef KITH_APP_VALIDATE_COVER_H
#define KITH_APP_VALIDATE_COVER_H

#include "lib/core/base.h"

enum { KITH_COVER_FACTORS = 8 };

/* Factor f has values 0 .. count[f] - 1, count[f] >= 1. (*row)[r * n_factors + f], 0 <= r < *n_rows, is memory of kith_resize.
 * BAD_INPUT: fewer than two factors, or more than KITH_COVER_FACTORS. */
kith_status kith_cover(int n_factors, const int *count, int **row, int *n_rows);

#endif
