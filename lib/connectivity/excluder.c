#include "lib/connectivity/excluder.h"

static bool same_i64(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j) {
  (void)nodes;
  const int64_t *tag = ((const struct kith_field *)context)->i64;
  return tag[i] > 0 && tag[i] == tag[j];
}

static bool same_u8(const void *context, const struct kith_nodes *nodes, kith_index i, kith_index j) {
  (void)nodes;
  const uint8_t *tag = ((const struct kith_field *)context)->u8;
  return tag[i] > 0 && tag[i] == tag[j];
}

kith_status kith_excluder_connected(struct kith_excluder *out, const struct kith_field *tag,
                                    const struct kith_excluder *next) {
  if (tag->spec.type == KITH_F64)
    KITH_FAIL(BAD_INPUT, "field '%s' is no tag: tags are whole numbers", tag->spec.name);
  /* Narrow: a distance costs less than a call. */
  *out = (struct kith_excluder){.name = "connected",
                                .phase = KITH_NARROW,
                                .reject = tag->spec.type == KITH_I64 ? same_i64 : same_u8,
                                .context = tag,
                                .next = next};
  return KITH_OK;
}
