/* Storage `compressed`: a row is its differences, each in as many bytes of 7 bits as it takes, lowest bits
 * first, 128 added to all but the last byte (LEB128). The first one is that of the target, with its sign in
 * the lowest bit; of the others, which are at least 1, 1 is left out. */
#include "lib/connectivity/storage/storage.h"

struct compressed {
  uint32_t *first;        /* [targets + 1] where the bytes of a row begin */
  const kith_index *node; /* of a target; borrowed */
  uint8_t *byte;
  size_t rows_capacity, bytes_capacity;
};

static inline size_t put(uint8_t *out, uint32_t value) {
  size_t n = 0;
  for (; value > 127; value >>= 7, ++n)
    if (out != NULL) out[n] = (uint8_t)(value | 128);
  if (out != NULL) out[n] = (uint8_t)value;
  return n + 1;
}

/* The bytes of a row, into `out` if that is not NULL; returns how many. */
static size_t pack(const kith_index *entry, size_t n, kith_index target, uint8_t *out) {
  size_t used = 0;
  for (size_t k = 0; k < n; ++k) {
    const int64_t gap = k == 0 ? (int64_t)entry[0] - target : entry[k] - entry[k - 1] - 1;
    const uint32_t value = k > 0 ? (uint32_t)gap : gap < 0 ? (uint32_t)(-2 * gap - 1) : (uint32_t)(2 * gap);
    used += put(out != NULL ? out + used : NULL, value);
  }
  return used;
}

static kith_status keep(struct kith_stored *stored, const kith_index *node) {
  struct kith_rows *rows = &stored->rows;
  const kith_index n = rows->n;
  uint64_t all = 0;
  if (stored->self == NULL) KITH_TRY(kith_resize(&stored->self, 0, 1, sizeof(struct compressed)));
  struct compressed *c = stored->self;
  c->node = node;
  KITH_TRY(kith_reserve(&c->first, &c->rows_capacity, (size_t)n + 1, sizeof *c->first));
#pragma omp parallel for schedule(static) if (n > KITH_FEW)
  for (kith_index t = 0; t < n; ++t)
    c->first[t] =
        (uint32_t)pack(rows->node + rows->first[t], rows->first[t + 1] - rows->first[t], node[t], NULL);
  for (kith_index t = 0; t < n; ++t) {
    const uint32_t length = c->first[t];
    c->first[t] = (uint32_t)all, all += length;
  }
  if (all > UINT32_MAX)
    KITH_FAIL(UNSUPPORTED, "storage compressed: rows of %g GB, it can hold 4", 1e-9 * (double)all);
  c->first[n] = (uint32_t)all;
  KITH_TRY(kith_reserve(&c->byte, &c->bytes_capacity, all, 1));
#pragma omp parallel for schedule(static) if (n > KITH_FEW)
  for (kith_index t = 0; t < n; ++t)
    pack(rows->node + rows->first[t], rows->first[t + 1] - rows->first[t], node[t], c->byte + c->first[t]);
  kith_rows_clear(rows);
  return KITH_OK;
}

/* Most differences are a byte: its branch is predicted. */
static const kith_index *row(const struct kith_stored *stored, kith_index t, kith_index *space, size_t *n) {
  const struct compressed *c = stored->self;
  const uint8_t *at = c->byte + c->first[t], *end = c->byte + c->first[t + 1];
  kith_index entry = c->node[t], *out = space;
  while (at < end) {
    uint32_t value = *at++;
    if (value > 127) {
      value &= 127;
      for (int shift = 7;; shift += 7) {
        value |= (uint32_t)(*at & 127) << shift;
        if (*at++ < 128) break;
      }
    }
    if (out == space)
      entry += value % 2 != 0 ? -(kith_index)(value / 2) - 1 : (kith_index)(value / 2);
    else
      entry += (kith_index)value + 1;
    *out++ = entry;
  }
  *n = (size_t)(out - space);
  return space;
}

static size_t bytes(const struct kith_stored *stored) {
  const struct compressed *c = stored->self;
  return ((size_t)stored->n + 1) * sizeof *c->first + c->first[stored->n];
}

static void clear(struct kith_stored *stored) {
  struct compressed *c = stored->self;
  KITH_FREE(&c->first, &c->byte);
}

const struct kith_storage_ops kith_storage_compressed = {
    .name = "compressed",
    .doc = "differences along the curve, a byte for most: a quarter of the memory, unpacked row by row",
    .ascending = true,
    .keep = keep,
    .row = row,
    .bytes = bytes,
    .clear = clear};
