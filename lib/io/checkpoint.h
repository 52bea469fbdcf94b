/* checkpoint.h - everything a run needs to go on bit for bit: all KITH_STATE fields of the internal nodes, the lists,
 * and named extra data (numbers, arrays, text) of the integrator, policies and boundaries.
 *
 *   writing   kith_checkpoint_open_new(&c, path, fingerprint) ; put...; kith_checkpoint_commit(&c)
 *   reading   kith_checkpoint_open(&c, path); nodes; read...; kith_checkpoint_close(&c)
 *
 * A file is written under a temporary name, synced, and renamed by commit; the previous one is kept as PATH.previous. So a full disk
 * or a kill at any moment leaves the last good one usable. A cut file, another dimension or another scene
 * is refused with BAD_FILE / BAD_INPUT and a clear line. A checksum over all data is verified before anything is used. */
#ifndef KITH_IO_CHECKPOINT_H
#define KITH_IO_CHECKPOINT_H

#include "lib/nodes/nodes.h"

struct kith_checkpoint;

/* `scene`: the effective scene text; stored whole, compared on reading by the caller through kith_checkpoint_scene. */
kith_status kith_checkpoint_open_new(struct kith_checkpoint **out, const char *path, const char *scene);
kith_status kith_checkpoint_put_nodes(struct kith_checkpoint *c, const struct kith_nodes *nodes);
kith_status kith_checkpoint_put_f64(struct kith_checkpoint *c, const char *name, const double *values, size_t n);
kith_status kith_checkpoint_put_i64(struct kith_checkpoint *c, const char *name, const int64_t *values, size_t n);
/* Closes, syncs, renames; frees *c in any case. */
kith_status kith_checkpoint_commit(struct kith_checkpoint **c);
/* Gives up: removes the temporary file. */
void kith_checkpoint_abandon(struct kith_checkpoint **c);

kith_status kith_checkpoint_open(struct kith_checkpoint **out, const char *path);
const char *kith_checkpoint_scene(const struct kith_checkpoint *c); /* view */
/* `nodes` must have the same lists; fields that are registered and missing in the file are BAD_FILE, and the other way round. Present nodes are replaced. */
kith_status kith_checkpoint_nodes(struct kith_checkpoint *c, struct kith_nodes *nodes);
/* Length of a named array, SIZE_MAX if it is not there. */
size_t kith_checkpoint_length(const struct kith_checkpoint *c, const char *name);
kith_status kith_checkpoint_f64(struct kith_checkpoint *c, const char *name, double *values, size_t n);
kith_status kith_checkpoint_i64(struct kith_checkpoint *c, const char *name, int64_t *values, size_t n);
void kith_checkpoint_close(struct kith_checkpoint **c);

#endif
