/* Pairwise fields. */
#include "lib/connectivity/connectivity.h"

kith_status kith_pairwise_prepare(struct kith_pairwise *field, const struct kith_connectivity *connectivity,
                                  int components) {
  if (components < 1) KITH_FAIL(INTERNAL, "a pairwise field of %d components", components);
  const size_t need = connectivity->pairs.n * (size_t)components;
  if (need > field->capacity) {
    const size_t capacity = need + need / 32; /* pairs come and go */
    field->capacity = field->n = 0;
    KITH_TRY(kith_resize(&field->value, 0, capacity, sizeof *field->value));
    field->capacity = capacity;
  }
  field->components = components;
  field->n = connectivity->pairs.n;
  field->generation = connectivity->generation;
  return KITH_OK;
}

kith_status kith_pairwise_fresh(const struct kith_pairwise *field,
                                const struct kith_connectivity *connectivity) {
  if (field->components < 1) KITH_FAIL(STALE, "a pairwise field was never prepared");
  if (field->generation != connectivity->generation)
    KITH_FAIL(STALE, "a pairwise field belongs to connectivity %llu, there is %llu",
              (unsigned long long)field->generation, (unsigned long long)connectivity->generation);
  return KITH_OK;
}

void kith_pairwise_clear(struct kith_pairwise *field) {
  kith_free(&field->value);
  *field = (struct kith_pairwise){0};
}
