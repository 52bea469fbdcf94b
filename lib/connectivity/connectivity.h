/* connectivity.h - who interacts with whom: rows, pairs, overlap, intersection, made from one search.
 *
 * Significant: |x_i - x_j| <= R_i or <= R_j, self excluded; R is the nodes' `reach`. Ghosts count as nodes of their own,
 * so a control node and its images are different partners.
 *
 *   rows          CSR: row i holds the significant neighbors of i, ascending. Rows of internal nodes; of ghosts too
 *                 if ghost_rows is required (then rows are symmetric), else ghosts have empty rows.
 *   pairs         each interaction once, (i, j) with i < j, in lexicographic order. So i is internal; j may be a ghost.
 *                 Ghost-ghost pairs exist if and only if ghost_rows is required.
 *   of_row        for each entry of the rows, the pair it belongs to; made if pairs are required.
 *   f_couple      one factor per pair, NULL after a build until someone needs it (then 1); a package may cut a pair with 0.
 *                 A patch carries it over.
 *   overlap       row i: all neighbors of i, and every j whose support shares a node with i's: there is a node k (internal or
 *                 ghost, also i or j) with |x_i - x_k| <= R_i and |x_j - x_k| <= R_j. Symmetric, self excluded, ascending.
 *                 Stored for the nodes that have rows. Complete if ghosts reach twice as far (boundary.h, f = 2).
 *   intersection  of a pair: the nodes that are neighbors of both ends, and both ends; optionally only those whose closest
 *                 point on the segment from i to j lies strictly between the ends. Ascending.
 *
 * Rows are built in two passes over the groups of the search (test, fill), parallel over groups; the result does not depend
 * on the number of threads, nor on which search was used. Exact ties count: distances are plain sums of squares compared
 * by <=, the same to the last bit in both directions and on every instruction set (internal.h).
 *
 * Patching: when ghosts are culled, everything is renumbered and nothing is rebuilt. The result is identical, byte for
 * byte, to a build on the culled nodes
 *   rows, pairs, of_row, f_couple, intersection    for any set of kept ghosts (they are facts about two or three kept nodes)
 *   overlap, rows of internal nodes only           if every ghost in the row of an internal node is kept (mark_ghosts)
 *   overlap with ghost_rows                        if every ghost in the row of any kept node is kept: a removed ghost may have
 *                                                  been the only node that two supports share
 * Excluders must then tell nodes by their fields and not by their index. */
#ifndef KITH_CONNECTIVITY_CONNECTIVITY_H
#define KITH_CONNECTIVITY_CONNECTIVITY_H

#include "lib/core/profile.h"
#include "lib/neighbor/search.h"
#include "lib/nodes/nodes.h"

/* What packages and schemes ask for; OR them. Nothing that is not asked for is built. */
struct kith_requirements {
  bool rows, pairs, ghost_rows, overlap, intersection;
  bool on_segment; /* filter of the intersection; OR drops it if someone wants all common nodes */
};
struct kith_requirements kith_requirements_or(struct kith_requirements a, struct kith_requirements b);

/* Compressed rows: entries of row i are node[first[i]] .. node[first[i + 1] - 1]. */
struct kith_rows {
  kith_index n;
  size_t *first;    /* [n + 1] */
  kith_index *node; /* [first[n]] */
  size_t rows_capacity, entries_capacity;
};

struct kith_pairs {
  size_t n, capacity;
  bool canonical; /* see kith_connectivity_canonical; else as above */
  kith_index
      starts; /* nodes 0 .. starts - 1 may have pairs that start at them: internal ones; canonical pairs: ghosts too */
  kith_index (*node)[2]; /* [n] (i, j), which starts at i; i < j unless canonical */
  size_t *first;         /* [starts + 1 at least] pairs that start at i: first[i] .. first[i + 1] - 1 */
  uint32_t *of_row;      /* [rows.first[rows.n]] */
  double *f_couple;      /* [n] or NULL */
  size_t first_capacity, of_row_capacity;
};

struct kith_connectivity {
  struct kith_requirements built; /* what there is */
  bool canonical;                 /* and in which order */
  struct kith_rows rows;
  struct kith_pairs pairs;
  struct kith_rows overlap;
  struct kith_rows intersection; /* one row per pair (2^31 at most) */
  uint64_t generation;           /* counts builds and patches: pairwise fields are stamped with it */
  uint64_t positions, ghosts;    /* generations of the nodes it was made from */
  size_t candidates;             /* distance tests of the last build */
  struct kith_connectivity_scratch *scratch; /* private: memory kept from build to build */
};

/* Rejects candidates: the pair is significant only if no excluder of the chain rejects it. Broad: before the distance
 * test, on whole runs never, on nodes only. Narrow: after it. `reject` is symmetric in i and j. Thread-safe. */
enum kith_phase { KITH_BROAD, KITH_NARROW };
struct kith_excluder {
  const char *name;
  enum kith_phase phase;
  bool (*reject)(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j);
  const void *context;              /* borrowed */
  const struct kith_excluder *next; /* chain, borrowed */
};

kith_status kith_connectivity_create(struct kith_connectivity **out);
void kith_connectivity_destroy(struct kith_connectivity **connectivity);

/* Builds what `need` asks for. The search must be fresh (else STALE). Memory is reused from build to build.
 * excluders: chain or NULL. profile: stages rows, pairs, overlap, intersection; may be NULL. */
kith_status kith_connectivity_build(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    const struct kith_search *search, struct kith_requirements need,
                                    const struct kith_excluder *excluders, struct kith_profile *profile);

/* keep[g] = 1 for every ghost n_internal + g in the row of an internal node; the others are left as they are. */
void kith_connectivity_mark_ghosts(const struct kith_connectivity *connectivity,
                                   const struct kith_nodes *nodes, uint8_t *keep);
/* Renumbers after kith_nodes_cull_ghosts: renumber[old index] is the new one, or -1. */
kith_status kith_connectivity_patch(struct kith_connectivity *connectivity, const struct kith_nodes *nodes,
                                    const kith_index *renumber, kith_index old_count);

/* STALE if it was made from other ghosts. (Positions may move while a list lasts: the rebuild policy decides.) */
kith_status kith_connectivity_fresh(const struct kith_connectivity *connectivity,
                                    const struct kith_nodes *nodes);
/* All invariants: sorted, in range, symmetric where stored, pairs = rows, of_row, f_couple, intersection. INTERNAL names the first breach. */
kith_status kith_connectivity_valid(const struct kith_connectivity *connectivity,
                                    const struct kith_nodes *nodes);

/* Rows, overlap and pairs in canonical order, one that depends on no rank, search or culling. The last thing done to a map: neither patched
 * nor valid afterwards; factors and intersections, which were told by the old numbers of the pairs, are gone.
 *   rows, overlap   by the id of the partner, then by which image it is (kith_nodes_number_images)
 *   pairs           each interaction of an internal node once. Who starts a pair is evaluated as its first end, on all ranks the same one: of two
 *                   nodes the one with the lower id, also where it is a ghost; of a node and an image, its own or another's, the
 *                   node; of a node and a frozen one the node. The pairs of an internal node are in the order of its row; those of a
 *                   ghost, which are with internal nodes only, are not. There are none between ghosts. */
kith_status kith_connectivity_canonical(struct kith_connectivity *connectivity,
                                        const struct kith_nodes *nodes);
/* Such pairs, and of_row, of rows in canonical order; those of internal nodes are read. */
kith_status kith_pairs_canonical(struct kith_pairs *pairs, const struct kith_rows *rows,
                                 const struct kith_nodes *nodes);
/* Does pair p of node i and its partner j start at i? */
static inline bool kith_pair_starts(const struct kith_pairs *pairs, size_t p, kith_index i, kith_index j) {
  return pairs->canonical ? pairs->node[p][0] == i : i < j;
}

/* The pair of i and j in either order, or pairs.n if there is none. O(log row). */
size_t kith_connectivity_pair(const struct kith_connectivity *connectivity, kith_index i, kith_index j);
/* Makes f_couple (all 1) if it is not there. */
kith_status kith_connectivity_couple(struct kith_connectivity *connectivity);

/* A pairwise field: k values per pair, aligned with the pair list, dead after a rebuild or patch. */
struct kith_pairwise {
  int components;
  size_t n, capacity;
  uint64_t generation;
  double *value; /* [n][components] */
};
/* Sized to the present pairs; values are not cleared. Memory is reused. */
kith_status kith_pairwise_prepare(struct kith_pairwise *field, const struct kith_connectivity *connectivity,
                                  int components);
kith_status kith_pairwise_fresh(const struct kith_pairwise *field,
                                const struct kith_connectivity *connectivity);
void kith_pairwise_clear(struct kith_pairwise *field);

size_t kith_connectivity_bytes(const struct kith_connectivity *connectivity);

#endif
