/* checkpoint.h - everything that a run needs to continue bitwise identically: all fields of the internal
 * nodes that last (kith_field_lasts in nodes.h), the lists, and named extra data (numbers, arrays, text) of
 * the integrator, policies and boundaries.
 *
 *   writing   kith_checkpoint_open_new(&c, path, scene); put...; kith_checkpoint_commit(&c)
 *   reading   kith_checkpoint_open(&c, path, ranks); nodes; read...; kith_checkpoint_close(&c)
 *
 * Written as an atomic file that keeps the previous one (atomic_file.h): a full disk or a kill at any moment
 * leaves the last good one usable. What is damaged, of another dimension or another scene is refused with a
 * line before anything is used.
 *
 * Not HDF5, because reading must survive damage: of 24000 small files with one to four random bytes changed
 * or the end cut off, HDF5 1.10.8 hung on six. Here a checksum covers every byte, and every length is bounded
 * by the size of the file:
 *
 *   header    24 bytes: magic "kithckpt", u32 byte-order mark 0x01020304, u32 version 6,
 *             u32 dimension, u32 zero
 *   sections  one after the other: name[56] ended and filled by zeros, u32 group, u32 type, u64 components,
 *             u64 rows, then the values, padded with zeros to whole words
 *   checksum  u64, of all words before: the sum over blocks of 256 KiB, which ranks share
 *
 * Groups: 0 scene, 1 lists, 2 fields, 3 named arrays; types: those of kith_type. A list is a row of 6 words:
 * name[32], first, count. Numbers are in the byte order of the machine. Of several ranks, rank 0 writes,
 * piece by piece: nodes list by list, rank by rank. In reading, every rank reads its part of each field. */
#ifndef KITH_IO_CHECKPOINT_H
#define KITH_IO_CHECKPOINT_H

#include "lib/nodes/nodes.h"

struct kith_checkpoint;

/* `scene`: the effective scene text; the reader compares it. A name is 1 to 55 bytes long, and put once; a
 * put that failed makes the commit fail too. */
kith_status kith_checkpoint_open_new(struct kith_checkpoint **out, const char *path, const char *scene);
/* Collective; `c` is NULL on all ranks but 0. A failure is known to rank 0 only. */
kith_status kith_checkpoint_put_nodes(struct kith_checkpoint *c, const struct kith_nodes *nodes);
/* One more scalar field as a named array, [nodes of all ranks], which a reader may use or not. Collective, as
 * above. */
kith_status kith_checkpoint_put_field(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                      const struct kith_field *field);
/* A named array. */
kith_status kith_checkpoint_put(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                const void *values, size_t n);
/* Closes, syncs, renames; frees *c in any case. */
kith_status kith_checkpoint_commit(struct kith_checkpoint **c);
/* A file that is being written is given up. Frees *c; accepts a pointer to NULL. */
void kith_checkpoint_close(struct kith_checkpoint **c);

/* Collective over `ranks` (NULL: one process), which share the work of the checksum. The status is agreed
 * on. */
kith_status kith_checkpoint_open(struct kith_checkpoint **out, const char *path, struct kith_ranks *ranks);
const char *kith_checkpoint_scene(const struct kith_checkpoint *c); /* view */
/* `nodes` must have the same lists (else BAD_INPUT) and the same fields that last (else BAD_FILE). Present
 * nodes are replaced, ghosts are dropped, other fields are zero. This rank gets the nodes that it had when
 * counts[rank][list] (kith_nodes_counts) were those of its ranks; NULL: an equal part of each list. Of this
 * rank alone. On failure, but for NO_MEMORY or if the file cannot be read any more, the nodes are as they
 * were. */
kith_status kith_checkpoint_nodes(struct kith_checkpoint *c, struct kith_nodes *nodes, const int64_t *counts);
/* What kith_checkpoint_put_field wrote, of the nodes that kith_checkpoint_nodes has read. */
kith_status kith_checkpoint_get_field(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                      const struct kith_field *field);
/* Length of a named array, SIZE_MAX if it is not there. */
size_t kith_checkpoint_length(const struct kith_checkpoint *c, const char *name);
/* `type` and `n` must be those of the array (else BAD_FILE). */
kith_status kith_checkpoint_get(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                void *values, size_t n);

#endif
