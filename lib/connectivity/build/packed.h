/* packed.h - packed nodes and their distance test.
 *
 * Exact ties. Every distance in lib/connectivity is the plain sum of squared differences, axis 0 first, and
 * is compared by <=. The sources here are compiled without contraction to fused multiply-add
 * (CMakeLists.txt), so d2(i, j) = d2(j, i) bitwise, on every instruction set, and a lattice whose spacing
 * equals the search radius is decided the same way everywhere. */
#ifndef KITH_CONNECTIVITY_BUILD_PACKED_H
#define KITH_CONNECTIVITY_BUILD_PACKED_H

#include "lib/neighbor/search.h"

/* A few hundred nodes side by side, ascending in node index (those of each image shift by themselves) unless
 * rows are unsorted. Slots beyond n, up to 64 * words, hold NaN, which no test accepts. */
struct kith_packed {
  int n, words, capacity; /* words = ceil(n / 64) */
  kith_index *node;
  uint16_t *shift; /* which images they are */
  double *coordinate[NDIM], *radius2;
};
/* Room for n; keeps those that there are. */
kith_status kith_packed_reserve(struct kith_packed *packed, size_t n);
void kith_packed_clear(struct kith_packed *packed);
/* A view of words from .. to - 1. */
static inline struct kith_packed kith_packed_part(const struct kith_packed *packed, int from, int to) {
  struct kith_packed part = {.n = 64 * (to - from),
                             .words = to - from,
                             .node = packed->node + 64 * from,
                             .shift = packed->shift + 64 * from,
                             .radius2 = packed->radius2 + 64 * from};
  for (int a = 0; a < NDIM; ++a) part.coordinate[a] = packed->coordinate[a] + 64 * from;
  return part;
}
/* Sets n and words, and fills the rest of the last word. */
void kith_packed_close(struct kith_packed *packed, int n);
/* Bit p of hit[words]: d2(x, p) <= max(radius2, radius2_p). Returns the number of bits set. */
int kith_packed_hits(const struct kith_packed *packed, const double *x, double radius2, uint64_t *hit);
/* Keeps the bits of nodes whose closest point on the segment from x to y lies strictly between the ends:
 * (x_p - x).(y - x) > 0 and (x_p - y).(x - y) > 0. */
void kith_packed_between(const struct kith_packed *packed, const double *x, const double *y, uint64_t *hit);
/* Writes the nodes of the bits set, in order. */
void kith_packed_extract(const kith_index *node, int words, const uint64_t *hit, kith_index *restrict out);
/* Writes the shifts of the bits set, in order. */
void kith_packed_extract_shifts(const uint16_t *shift, int words, const uint64_t *hit,
                                uint16_t *restrict out);
/* Writes the slots of a run within range of the box, d2(box, slot) <= max(radius2, radius2_slot), ascending;
 * returns how many. Rounding is monotone, so d2(box, slot) <= d2(x, slot), as computed, for all x in the box:
 * no neighbor is lost. */
size_t kith_box_slots(const struct kith_search *search, struct kith_run run, const struct kith_box *box,
                      double radius2, kith_index *slot);
/* Appends what kith_box_slots finds, where slots are nodes. The caller has reserved room for the whole run
 * and KITH_PACKED_ROOM more nodes, which is overwritten. */
enum { KITH_PACKED_ROOM = 16 };
void kith_packed_add(struct kith_packed *packed, const struct kith_search *search, struct kith_run run,
                     const struct kith_box *box, double radius2);

#endif
