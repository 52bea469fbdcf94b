/* shifts.c - the table of periodic images that are no ghosts. */
#include "lib/nodes/shifts.h"

void kith_shifts_drop(struct kith_shifts *shifts) {
  shifts->n = 1, shifts->zero = 0;
  for (int a = 0; a < NDIM; ++a) shifts->most[a] = 0, shifts->length[a] = 0;
}

void kith_shifts_clear(struct kith_shifts *shifts) {
  KITH_FREE(&shifts->by, &shifts->image);
  *shifts = (struct kith_shifts){0};
}

size_t kith_shifts_bytes(const struct kith_shifts *shifts) {
  return shifts->by_capacity * sizeof *shifts->by + shifts->image_capacity * sizeof *shifts->image;
}

/* Fills in shift s: how far it displaces a node, and the number of that image. */
static void fill(struct kith_shifts *shifts, int s) {
  int rest = s;
  shifts->image[s] = 0;
  for (int a = 0; a < NDIM; ++a) {
    const int wide = 2 * shifts->most[a] + 1, k = rest % wide - shifts->most[a];
    shifts->by[s][a] = k * shifts->length[a];
    shifts->image[s] += k * (INT64_C(1) << 16 * a);
    rest /= wide;
  }
}

kith_status kith_shifts_add(struct kith_shifts *shifts, int axis, int most, double length) {
  double all = 1;
  shifts->most[axis] = most, shifts->length[axis] = length;
  for (int a = 0; a < NDIM; ++a) all *= 2.0 * shifts->most[a] + 1;
  if (all > KITH_MOST_SHIFTS)
    KITH_FAIL(DIVERGED, "%.0f periodic images, %d along axis %d of length %g: an entry can number %d", all,
              most, axis, length, KITH_MOST_SHIFTS);
  shifts->n = (int)all, shifts->zero = (shifts->n - 1) / 2;
  KITH_TRY(kith_reserve(&shifts->by, &shifts->by_capacity, (size_t)shifts->n, sizeof *shifts->by));
  KITH_TRY(kith_reserve(&shifts->image, &shifts->image_capacity, (size_t)shifts->n, sizeof *shifts->image));
  for (int s = 0; s < shifts->n; ++s) fill(shifts, s);
  return KITH_OK;
}
