/* checkpoint_file.h - the file of a checkpoint: what writing (checkpoint_write.c) and reading (checkpoint.c)
 * share. Private to lib/io. */
#ifndef KITH_IO_CHECKPOINT_FILE_H
#define KITH_IO_CHECKPOINT_FILE_H

#include <stdio.h>
#include <string.h>

#include "lib/io/atomic_file.h"
#include "lib/nodes/nodes.h"

enum { MARK = 0x01020304, VERSION = 1, CHUNK = 1 << 18, MOST_COMPONENTS = 64 };
enum group { GROUP_SCENE, GROUP_LISTS, GROUP_FIELD, GROUP_ARRAY };

struct header {
  char magic[8];
  uint32_t mark, version, dimension, sections;
  uint64_t table, size, table_checksum, zero, checksum;
};
struct section {
  char name[56];
  uint32_t group, type;
  uint64_t components, rows, bytes, checksum;
};
struct stored_list {
  char name[32];
  int64_t first, count;
};
_Static_assert(sizeof(struct header) == 64, "the header is 64 bytes");
_Static_assert(sizeof(struct section) == 96, "an entry of the table is 96 bytes");
_Static_assert(sizeof(struct stored_list) == 48, "a list is 48 bytes");
_Static_assert(sizeof(struct kith_node_list) == 40, "a new member of a list must be added to stored_list");

struct kith_checkpoint {
  struct kith_atomic_file *out; /* writing */
  FILE *in;                     /* reading */
  char *path, *scene;           /* owned */
  struct header header;
  struct section *section; /* [header.sections] */
  size_t capacity;
  bool broken;  /* a put failed: it must not be committed */
  char tail[8]; /* of the section that is being written: bytes of an incomplete word */
  size_t n_tail;
  char chunk[CHUNK]; /* values of other ranks, or what is verified */
};

/* Checksum of whole words, continued from h. Each word enters through one-to-one functions of h, so two files
 * that differ in one word never agree. Multiplier: the one of 64-bit FNV; the shift carries high bits
 * down. */
static inline uint64_t checksum(uint64_t h, const void *data, size_t bytes) {
  for (size_t k = 0; k < bytes; k += 8) {
    uint64_t word;
    memcpy(&word, (const char *)data + k, 8);
    h = (h ^ word) * UINT64_C(0x100000001b3);
    h ^= h >> 29;
  }
  return h;
}
static const uint64_t checksum_start = UINT64_C(0xcbf29ce484222325);

static inline size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}
static inline size_t type_size(uint32_t type) {
  return type == KITH_U8 ? 1 : 8;
}

#define KITH_CHECKPOINT_MAGIC "kithckpt"

/* Empty, with its path. */
kith_status kith_checkpoint_file_create(struct kith_checkpoint **out, const char *path);
/* Closes what is open, removes a temporary file, and frees *c. */
void kith_checkpoint_file_destroy(struct kith_checkpoint **c);
/* NULL if there is none. */
struct section *kith_checkpoint_file_find(const struct kith_checkpoint *c, enum group group,
                                          const char *name);

#endif
