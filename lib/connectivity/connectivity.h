/* connectivity.h - who interacts with whom: rows, pairs, overlap and intersection, made from one search.
 *
 * Significant: |x_i - x_j| <= R_i or <= R_j, self excluded; R is the nodes' search radius. Ghosts count as
 * nodes of their own, so a control node and its images are different partners. So are images that are no
 * ghosts but shifts of a node (rows.h): all that is below has them; images of i itself may be in row i.
 *
 *   rows           row i holds the significant neighbors of i, ascending. Rows of internal nodes; of ghosts
 *                  too if ghost_rows is required (then rows are symmetric). Else there are no rows of ghosts:
 *                  a pass that reads them asks kith_connectivity_provides first, which refuses by name.
 *   pairs          each interaction once (pairs.h). Ghost-ghost pairs exist if and only if ghost_rows is
 *                  required. f_couple, a lasting pairwise field, is a factor of each pair.
 *   overlap        rows of all nodes whose support shares a node with that of i (builder.h), for the nodes
 *                  that have rows.
 *   overlap_pairs  each overlap of an internal node once, as pairs.
 *   intersection   the common neighbors of each pair, and both ends (builder.h).
 *
 * Exact ties count: distances are plain sums of squares compared by <=, bitwise equal in both directions and
 * on every instruction set (packed.h).
 *
 * Patching: when ghosts are culled, everything is renumbered and nothing is rebuilt. The result is bitwise
 * identical to a build on the culled nodes
 *   rows, pairs, f_couple, intersection      for any set of kept ghosts: they are facts about kept nodes
 *   intersection with obstacles, if no node  if every ghost in the row of an internal node is kept
 *   is idle; overlap, rows of internal       (kith_connectivity_mark_ghosts)
 *   nodes only
 *   overlap with ghost_rows                  if every ghost in the row of any kept node is kept: a removed
 *                                            ghost may have been the only node that two supports share
 * Excluders must then tell nodes apart by their fields and not by their index. */
#ifndef KITH_CONNECTIVITY_CONNECTIVITY_H
#define KITH_CONNECTIVITY_CONNECTIVITY_H

#include "lib/connectivity/list.h"
#include "lib/core/profile.h"

/* What packages and schemes require; OR them. Nothing is built that is not required. */
struct kith_requirements {
  bool rows, pairs, ghost_rows, overlap, overlap_pairs, intersection;
  bool on_segment; /* only common nodes that are beside the segment (builder.h); OR: if none needs all */
  /* Fields, U8 or F64, that are not 0 at the nodes for which intersections are searched, and at nodes whose
   * pairs need none. A pair holds its ends alone if its first node is no obstacle and has none in its row, or
   * if an end is a barrier. NULL, or with ghost_rows: all pairs have their common neighbors; OR: all, if two
   * fields differ. */
  const struct kith_field *obstacles, *barriers;
};
struct kith_requirements kith_requirements_or(struct kith_requirements a, struct kith_requirements b);

struct kith_connectivity {
  struct kith_requirements built; /* what is there */
  bool canonical;                 /* rows and pairs are in canonical order */
  kith_index n, n_internal;       /* nodes it was made from, ghosts included; internal ones */
  struct kith_rows rows;
  struct kith_pairs pairs;
  struct kith_rows overlap;
  struct kith_pairs overlap_pairs;
  struct kith_rows intersection; /* one row for each pair (2^31 at most) */
  uint64_t ghosts;               /* generation of those it was made from */
  /* Called in a build as soon as it is known which ghosts rows will hold (rows.wanted; not if ghosts have
   * rows or nodes are idle), before entries are filled in: ranks can tell each other meanwhile. NULL: nothing
   * to do. */
  kith_status (*when_marked)(void *context);
  void *context;     /* borrowed */
  size_t candidates; /* distance tests of the last build */
  struct kith_builder scratch;
};

kith_status kith_connectivity_create(struct kith_connectivity **out);
void kith_connectivity_destroy(struct kith_connectivity **connectivity);
/* Memory besides pairwise fields. */
size_t kith_connectivity_bytes(const struct kith_connectivity *connectivity);

/* Builds what `need` requires, with rows that are a neighbor list of the nodes and themselves (list.h). STALE
 * if the search is. excluders: chain or NULL; BAD_INPUT if one makes rows that are not symmetric. profile:
 * stages rows, overlap, overlap pairs, pairs, intersection; may be NULL. While nodes are idle there are the
 * rows, pairs and intersections of active ones (build.c). UNSUPPORTED if rows of ghosts or overlap are
 * required then, or overlap or intersection of supports that are ellipsoids. On failure nothing is there. */
kith_status kith_connectivity_build(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    struct kith_search *search, struct kith_requirements need,
                                    struct kith_excluder *excluders, struct kith_profile *profile);

/* keep[g] = 1 for every ghost n_internal + g in the row of an internal node; the others are left as they
 * are. */
void kith_connectivity_mark_ghosts(const struct kith_connectivity *connectivity,
                                   const struct kith_nodes *nodes, uint8_t *keep);
/* Renumbers after kith_nodes_cull_ghosts: renumber[old index] is the new one, or -1. UNSUPPORTED in canonical
 * order. (patch.c) */
kith_status kith_connectivity_patch(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    const kith_index *renumber, kith_index old_count);

/* The factor of each pair; not fresh: 1 for all. (coupling.c) */
extern const struct kith_pairwise_spec kith_f_couple;
/* The values of f_couple for the present pairs; NULL: 1 for all. */
const double *kith_connectivity_factors(const struct kith_pairs *pairs);

/* What the coupling of nodes depends on: arrays of all nodes and ghosts, borrowed. */
struct kith_coupling {
  const uint8_t *barrier; /* 1: the node is a wall; NULL: there is none */
  const double *damage;   /* D in [0, 1]: a node passes 1 - D of what it would; NULL: 0 for all */
  double thickness;       /* of layers of nodes, in supports */
};
/* Fills f_couple by the nodes k from i to j, which are i, j and what stands between them,
 *     f_ij = n / sum_k 1 / (1 - D_k),                                                              (1)
 * the harmonic mean: they are resistances in series. 1 if i or j is a barrier. A node of the intersection
 * stands between i and j if its closest point on the segment lies strictly between the ends, and nearer than
 * `thickness` times its support. Among nodes s apart no segment crosses a layer without one within s /
 * sqrt(2) in 3-D, s / 2 in 2-D; a larger thickness would count nodes on one side that come that close.
 *
 * A barrier with D = 1, or any if there is no D, that stands between i and j cuts the pair: it is removed,
 * and the overlap stays as it is. Needs pairs and intersection (else UNSUPPORTED). (coupling.c) */
kith_status kith_connectivity_couple(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                     const struct kith_coupling *by);

/* STALE if it was made from other ghosts. Positions may have changed, because Verlet lists are kept for
 * several steps: when they must be rebuilt is for the rebuild policy to decide. */
kith_status kith_connectivity_fresh(const struct kith_connectivity *connectivity,
                                    const struct kith_nodes *nodes);
/* To be called once before each pass: STALE as above; UNSUPPORTED, by name, if the pass needs something that
 * is not there, such as rows of ghosts. */
kith_status kith_connectivity_provides(const struct kith_connectivity *connectivity,
                                       const struct kith_nodes *nodes, struct kith_requirements need);
/* Checks all invariants: entries are in range, sorted, and symmetric where both rows are stored; pairs and
 * of_row agree with the rows, overlap_pairs with the overlap; values of lasting pairwise fields are finite;
 * an intersection holds the ends of its pair and common neighbors. In canonical order only pairs and
 * overlap_pairs are checked. INTERNAL names the first breach. Serial: a check, not a stage. (valid.c) */
kith_status kith_connectivity_valid(const struct kith_connectivity *connectivity,
                                    const struct kith_nodes *nodes);

/* Compares the rows with what a sweep over the cells of the search finds (search.h): each node must be a
 * target of one cell, and have as many interactions as its row has entries, each once. Distances that
 * rounding may decide do not count, nor do rows of nodes that are not active. excluded: rows may lack what
 * excluders reject. To be called before ghosts are culled: STALE if the search is. INTERNAL names the first
 * breach. Serial: a check, not a stage. (valid.c) */
kith_status kith_connectivity_complete(const struct kith_connectivity *connectivity,
                                       const struct kith_search *search, bool excluded);

/* Rows, overlap and their pairs in canonical order, one that depends on no rank, search or culling. The last
 * thing done to a connectivity: it cannot be patched afterwards. f_couple is carried over; other pairwise
 * fields and intersections, which refer to the old numbers of the pairs, are gone. (canonical.c)
 *   rows, overlap   by the id of the partner, then by which image it is (kith_nodes_number_images, shifts)
 *   pairs           each interaction of an internal node once. The node that starts a pair is evaluated as
 *                   its first end, on all ranks the same one: of two nodes the one with the lower id, also
 *                   where it is a ghost; of a node and an image, its own or another's, the node; of a node
 *                   and a frozen one the node. The pairs of an internal node are in the order of its row;
 *                   those of a ghost, which are with internal nodes only, ascend in the index of the partner.
 *                   There are none between ghosts. */
kith_status kith_connectivity_canonical(struct kith_connectivity *connectivity,
                                        const struct kith_nodes *nodes);

/* Does the pair of entry e of row i start at i, that is, is i its first end? */
static inline bool kith_pair_starts(const struct kith_connectivity *connectivity, kith_index i, size_t e) {
  const struct kith_rows *rows = &connectivity->rows;
  const kith_index j = rows->node[e];
  if (connectivity->canonical) return connectivity->pairs.node[connectivity->pairs.of_row[e]][0] == i;
  return i < j || (i == j && rows->shift[e] > rows->zero);
}

#endif
