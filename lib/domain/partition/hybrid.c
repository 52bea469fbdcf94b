/* hybrid.c - partitioned as a graph once, then balanced by diffusion.
 *
 * The first map and the first update are those of `graph`; all later updates diffuse. */
#include "lib/domain/partition/partition.h"

struct hybrid {
  struct kith_diffusion diffusion; /* must come first: `diffusion` uses this part */
  bool diffuse;                    /* at the next update */
};

static kith_status hybrid_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  struct hybrid *self = partition->self;
  if (self->diffuse) return kith_partitioner_diffusion.update(partition, weight, owner);
  KITH_TRY(kith_partitioner_graph.update(partition, weight, owner));
  self->diffuse = true;
  return KITH_OK;
}

static kith_status hybrid_first(struct kith_partition *partition, int32_t *owner) {
  return kith_partitioner_graph.update(partition, NULL, owner);
}

static size_t hybrid_state(const struct kith_partition *partition, int64_t *word) {
  const struct hybrid *self = partition->self;
  if (word != NULL) *word = self->diffuse;
  return 1;
}

static kith_status hybrid_restore(struct kith_partition *partition, const int64_t *word) {
  struct hybrid *self = partition->self;
  if (*word != 0 && *word != 1) KITH_FAIL(BAD_FILE, "partitioner 'hybrid': its state is damaged");
  self->diffuse = *word == 1;
  return KITH_OK;
}

const struct kith_partitioner_ops kith_partitioner_hybrid = {
    .name = "hybrid",
    .doc = "partitioned as a graph once, then diffusion",
#ifndef KITH_SCOTCH
    .needs = "Scotch (Debian: libptscotch-dev)", /* as graph */
#endif
    .state_size = sizeof(struct hybrid),
    .first = hybrid_first,
    .update = hybrid_update,
    .state = hybrid_state,
    .restore = hybrid_restore,
};
