/* internal.h - private to this room: packed nodes and their distance test, scratch memory, the builders.
 *
 * Exact ties. Every distance of this room is the plain sum of squared differences, axis 0 first, and is
 * compared by <=. The sources here are compiled without contraction to fused multiply-add (CMakeLists.txt),
 * so d2(i, j) = d2(j, i) to the last bit, on every instruction set, and a lattice whose spacing equals the
 * reach is decided the same way everywhere. */
#ifndef KITH_CONNECTIVITY_INTERNAL_H
#define KITH_CONNECTIVITY_INTERNAL_H

#include "lib/connectivity/connectivity.h"

/* A few hundred nodes side by side, ascending in node index. Places beyond n, up to 64 * words, hold NaN:
 * never hit. */
struct kith_packed {
  int n, words, capacity; /* words = ceil(n / 64) */
  kith_index *node;
  double *coordinate[NDIM], *radius2;
};
kith_status kith_packed_reserve(struct kith_packed *packed, size_t n);
/* Sets n and words, and fills the rest of the last word. */
void kith_packed_close(struct kith_packed *packed, int n);
void kith_packed_clear(struct kith_packed *packed);
/* Bit p of hit[words]: d2(x, p) <= max(radius2, radius2_p). Returns the number of hits. */
int kith_packed_hits(const struct kith_packed *packed, const double *x, double radius2, uint64_t *hit);
/* Keeps the bits of nodes whose closest point on the segment from x to y lies strictly between the ends:
 * (x_p - x).(y - x) > 0 and (x_p - y).(x - y) > 0. Returns how many are left. */
int kith_packed_between(const struct kith_packed *packed, const double *x, const double *y, uint64_t *hit);
/* Writes the nodes of the hits, ascending. */
void kith_packed_extract(const kith_index *node, int words, const uint64_t *hit, kith_index *restrict out);
/* Writes the slots of a run that reach the box, d2(box, slot) <= max(radius2, radius2_slot), ascending;
 * returns how many. Rounding is monotone, so d2(box, slot) <= d2(x, slot), as computed, for all x in the box:
 * nothing is lost. */
size_t kith_box_slots(const struct kith_search *search, struct kith_run run, const struct kith_box *box,
                      double radius2, kith_index *slot);

/* A growing array of 64-bit words. */
struct kith_words {
  size_t n, capacity;
  uint64_t *word;
};

/* What one thread needs for itself. */
struct kith_worker {
  struct kith_runs runs;
  struct kith_packed near;
  uint64_t *key[3]; /* candidates as node << 32 | slot: internal, ghost, spare for merging */
  kith_index *slot; /* [keys_capacity] */
  size_t keys_capacity;
  uint64_t *hit, *allowed; /* [near.words] */
  size_t hit_capacity, allowed_capacity;
  uint64_t *bitmap, *touched; /* a set of nodes, and which words of it are not 0; both 0 between uses */
  size_t bitmap_capacity, touched_capacity;
  size_t candidates;
};

enum {
  KITH_CHUNKS = 256,
  KITH_FEW = 1000, /* nodes: for fewer, waking threads costs more than they save */
};

/* Memory that is kept from build to build. Chunks are fixed shares of the masters: their buffers do not
 * depend on which thread filled them. */
struct kith_connectivity_scratch {
  int n_workers;
  struct kith_worker *worker;
  struct kith_words chunk[KITH_CHUNKS];
  uint32_t *cursor; /* [rows.n] */
  size_t cursor_capacity;
  size_t *span_first; /* overlap: [rows.n + 1] */
  kith_index *span;   /* word of the bitmap */
  uint64_t *span_bits;
  size_t span_first_capacity, span_capacity, span_bits_capacity;
  double *couple; /* memory of pairs.f_couple */
  size_t couple_capacity;
};

/* Room for `count` elements, with a little to spare if it must grow; contents are lost. */
kith_status kith_room(void *p, size_t *capacity, size_t count, size_t size);
kith_status kith_rows_room(struct kith_rows *rows, kith_index n);
/* first[i + 1] holds the length of row i: sums them up and makes room for the entries. */
kith_status kith_rows_sum(struct kith_rows *rows);
/* The threads' scratch, for at least as many threads as may run now. */
kith_status kith_workers_room(struct kith_connectivity_scratch *scratch);

/* What every builder gets. */
struct kith_build {
  struct kith_connectivity *connectivity;
  const struct kith_nodes *nodes;
  const struct kith_search *search;
  const struct kith_excluder *excluders;
};
/* `ghosts`: rows of ghosts too. */
kith_status kith_rows_build(const struct kith_build *build, bool ghosts);
/* Ghosts are the last rows: drops theirs. */
void kith_rows_strip(struct kith_rows *rows, kith_index n_internal);
kith_status kith_pairs_build(const struct kith_build *build);
/* of_row from rows, first and nothing else. */
kith_status kith_pairs_of_row(struct kith_connectivity *connectivity);
/* Needs rows of ghosts; overlap rows of the first `n` nodes. */
kith_status kith_overlap_build(const struct kith_build *build, kith_index n);
kith_status kith_intersection_build(const struct kith_build *build);

/* First entry of a row that is >= j. Without branches: where it ends cannot be foretold. */
static inline size_t kith_lower_bound(const kith_index *node, size_t from, size_t to, kith_index j) {
  if (from == to) return from;
  const kith_index *at = node + from;
  for (size_t n = to - from; n > 1; n -= n / 2) at += at[n / 2 - 1] < j ? n / 2 : 0;
  return (size_t)(at - node) + (*at < j);
}

#endif
