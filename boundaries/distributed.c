/* Distributed: ghosts of nodes that other ranks own, which the halo makes (lib/domain/halo.h). It comes last
 * in the list of boundaries, and sends nodes as well as the images made by the boundaries before it. */
#include "boundaries/boundary.h"

#include "lib/domain/halo.h"

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double radius_factor) {
  kith_halo_add_ghosts(boundary->self, nodes, boundary->index, radius_factor);
  return KITH_OK;
}

static void abstain(struct kith_boundary *boundary, struct kith_nodes *nodes) {
  kith_halo_abstain(boundary->self, nodes);
}

const struct kith_boundary_ops kith_boundary_distributed = {
    .name = "distributed",
    .doc = "nodes of other ranks",
    .ghosts = ghosts,
    .abstain = abstain,
};
