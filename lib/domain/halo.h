/* halo.h - ghosts of nodes that other ranks own, and the exchange of their values.
 *
 * Who is sent. Every rank tells its neighbors, for each of its cells that may matter to them, the box around
 * the nodes in it and their largest search radius R. Node or image j is sent to the rank of a cell if
 *     d(x_j, box) <= f max(R_j, R of the cell),
 * f = 1, or 2 when overlap is required: whatever a node of that rank may interact with is there. Where images
 * are shifts (lib/nodes/shifts.h), d is that of the nearest image, and the node itself is sent, once; nothing
 * is sent to where it came from, so that no node of a rank is a ghost of it. Frozen nodes
 * and their images are not sent: every rank has all of them. Remote ghosts are the last ghosts: rank by rank,
 * and list by list, in the order of their nodes.
 *
 * Culling. A rank tells the owners which of its ghosts it keeps; the owners shorten their send lists, and
 * keep the images that are on them.
 *
 * Pairs between ranks are evaluated, and counted, on both, each for its own node: a ghost never receives a
 * contribution. Refreshing any set of fields takes one message to each rank with which ghosts are shared.
 *
 * Neighbors. An image is no nearer to the nodes of another rank than its node is, over periodic sides, as
 * long as both are on the inner side of mirrors. So nodes of two cells have to do with each other only if the
 * cells are within
 *     reach = f max R + 2 (how far nodes are out of their cells) + (what images gain on their nodes),
 * a maximum over all ranks. The ranks within it are the neighbors (partition/shell.h): no message goes to any
 * other, and the number of ranks does not matter. One support as large as the scene makes all ranks
 * neighbors.
 *
 * A halo of NULL stands for one process: there are no remote ghosts, images alone are refreshed. Functions
 * that exchange are called by all ranks together, and send messages to neighbors only. A rank that fails
 * while others wait for it ends all. */
#ifndef KITH_DOMAIN_HALO_H
#define KITH_DOMAIN_HALO_H

#include "lib/domain/decomposition.h"

struct kith_halo; /* opaque */

/* decomposition (borrowed) has the cells and knows in which one a node is. */
kith_status kith_halo_create(struct kith_halo **out, struct kith_ranks *ranks,
                             struct kith_decomposition *decomposition);
void kith_halo_destroy(struct kith_halo **halo);

/* Neighbors are those within this reach, the same on all ranks, from here on. No communication. */
kith_status kith_halo_surround(struct kith_halo *halo, double reach);
/* Appends the remote ghosts, as blocks of this boundary. factor: f. */
void kith_halo_add_ghosts(struct kith_halo *halo, struct kith_nodes *nodes, int boundary, double factor);
/* Instead, on a rank that has failed: it gets and sends nothing. */
void kith_halo_abstain(struct kith_halo *halo, const struct kith_nodes *nodes);
/* For ghosts whose rows are complete: raises the search radius of each internal node i to the largest R_j
 * that a node j within max(R_i, R_j) of it may have. Ghosts made with it and with f = 2 then hold all
 * partners of i, and all that lie within R_j of a partner j,
 *     d(x_k, x_i) <= max(R_i, R_j) + R_j <= 2 R'_i. */
void kith_halo_extend(struct kith_halo *halo, struct kith_nodes *nodes);

/* Before a cull, in two halves. keep[ghost] is what this rank needs at the start; after finish it includes
 * the images that others need. NULL: a rank that has failed, and needs nothing. No other exchange in
 * between. */
void kith_halo_start_cull(struct kith_halo *halo, const struct kith_nodes *nodes, const uint8_t *keep);
void kith_halo_finish_cull(struct kith_halo *halo, const struct kith_nodes *nodes, uint8_t *keep);
/* Sets these bits in the marks of all images that other ranks were told of. No communication. */
void kith_halo_mark_sent(const struct kith_halo *halo, const struct kith_nodes *nodes, uint8_t *mark,
                         uint8_t bits);
/* After the cull: renumber[old index] is the new index or -1. */
void kith_halo_remap(struct kith_halo *halo, const kith_index *renumber);

/* Gives all ghosts the values of these fields that their nodes have: image ghosts as
 * kith_nodes_refresh_images does, then remote ghosts. Bitwise identical for any number of threads. */
void kith_halo_refresh(struct kith_halo *halo, struct kith_nodes *nodes, struct kith_field *const *fields,
                       int n_fields);
/* The same in two halves. After start, image ghosts have their values; after finish (which does nothing if no
 * exchange is pending), remote ghosts too. In between, these fields of remote ghosts must not be read. A
 * start finishes an earlier exchange first. */
void kith_halo_start_exchange(struct kith_halo *halo, struct kith_nodes *nodes,
                              struct kith_field *const *fields, int n_fields);
void kith_halo_finish_exchange(struct kith_halo *halo);
/* Was an exchange started and not finished? */
bool kith_halo_pending(const struct kith_halo *halo);

/* Since it was created, for each neighbor and each peer (a neighbor with which ghosts are shared), whether
 * there is one or not: what many ranks would say can be counted by one. */
#define KITH_HALO_TRAFFIC_LIST(X)                                       \
  X(told, "messages to a neighbor: bounds of cells, numbers of ghosts") \
  X(told_bytes, "bytes of these, without bounds")                       \
  X(cell_bytes, "bytes for a cell whose bounds a neighbor is told")     \
  X(created, "messages to a peer about ghosts as they were made")       \
  X(created_bytes, "bytes of these for a ghost")                        \
  X(kept, "messages to a peer about ghosts that were kept by the cull") \
  X(kept_bytes, "bytes of these for a ghost")
struct kith_halo_traffic {
#define X(name, doc) uint64_t name;
  KITH_HALO_TRAFFIC_LIST(X)
#undef X
};
struct kith_halo_traffic kith_halo_traffic(const struct kith_halo *halo);

#endif
