/* partners.h - the partners that a node evaluates in a pass over pairs, block by block.
 *
 * A pair of two nodes of one tile is evaluated once, by the node of lower index, and given to both: so a node
 * leaves out the partners in its tile that come before it. */
#ifndef KITH_PHYSICS_PASSES_PARTNERS_H
#define KITH_PHYSICS_PASSES_PARTNERS_H

#include <string.h>
#include "lib/connectivity/rows.h"

enum { KITH_BLOCK = 128 }; /* partners whose pairs are evaluated together */

/* Partners that node i evaluates: the entries of its row before its tile, and those from i on. Of these the
 * nodes of the tile (positions given .. given_end - 1) get the results, too. */
struct kith_partners {
  kith_index i;
  size_t first, before; /* entries `first` to first + before - 1 */
  size_t rest, n;       /* and n - before entries from `rest` on */
  size_t given, given_end;
};

/* Up to KITH_BLOCK partners, from position `begin` on. */
struct kith_partner_block {
  const struct kith_partners *of;
  size_t begin, n;
  const kith_index *node;
  const uint16_t *shift;
};

/* Returns the row entry of partner k of the block. */
KITH_INLINE size_t kith_partner_entry(const struct kith_partner_block *b, size_t k) {
  const size_t position = b->begin + k, before = b->of->before;
  return position < before ? b->of->first + position : b->of->rest + (position - before);
}

/* Returns the partners of node i in the tile of nodes tile .. tile_end - 1. The row ascends. */
KITH_INLINE struct kith_partners kith_partners_of(const struct kith_rows *rows, kith_index i, kith_index tile,
                                                  kith_index tile_end) {
  const kith_index *restrict node = rows->node;
  const size_t first = rows->first[i], end = rows->first[i + 1];
  const size_t rest = kith_lower_bound(node, first, end, i);
  size_t lower = first, given = rest, outside = end;
  while (lower < rest && node[lower] < tile) ++lower;
  while (given < end && node[given] == i) ++given; /* images of i itself */
  while (outside > given && node[outside - 1] >= tile_end) --outside;
  const size_t before = lower - first;
  return (struct kith_partners){
      i, first, before, rest, before + (end - rest), before + (given - rest), before + (outside - rest)};
}

/* Memory for a block whose partners are not consecutive in the row. */
struct kith_partner_room {
  kith_index node[KITH_BLOCK];
  uint16_t shift[KITH_BLOCK];
};

KITH_INLINE struct kith_partner_block kith_partner_block_at(const struct kith_rows *rows,
                                                            const struct kith_partners *of, size_t begin,
                                                            struct kith_partner_room *room) {
  struct kith_partner_block b = {of, begin, KITH_MIN(of->n - begin, (size_t)KITH_BLOCK), NULL, NULL};
  const size_t lower = begin < of->before ? KITH_MIN(of->before - begin, b.n) : 0,
               e = kith_partner_entry(&b, 0);
  if (lower == 0 || lower == b.n) {
    b.node = rows->node + e;
    b.shift = kith_shifts_at(rows->shift, rows->zero, e, b.n);
    return b;
  }
  for (size_t k = 0; k < lower; ++k) room->node[k] = rows->node[e + k];
  for (size_t k = lower; k < b.n; ++k) room->node[k] = rows->node[of->rest + k - lower];
  b.node = room->node;
  if (rows->shift == NULL) return b;
  memcpy(room->shift, rows->shift + e, lower * sizeof *room->shift);
  memcpy(room->shift + lower, rows->shift + of->rest, (b.n - lower) * sizeof *room->shift);
  b.shift = kith_shifts_at(room->shift, rows->zero, 0, b.n);
  return b;
}

#endif
