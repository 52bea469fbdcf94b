/* snapshot.h - one HDF5 file that ParaView (VTKHDF 1.0, UnstructuredGrid of vertices) and yt (Gadget layout) both open.
 *
 * PartType0 holds every field of the nodes that has an `output` name, internal nodes only, plus Coordinates, SmoothingLength
 * (the support H), ParticleIDs and MaterialIDs; VTKHDF hard-links the same data sets. Vectors are [n][3], padded with zeros in 1-D and
 * 2-D. Header as Gadget has it. Group Run: attributes with provenance (strings), the box, the scene's text.
 * Written to a temporary name, synced, renamed. */
#ifndef KITH_IO_SNAPSHOT_H
#define KITH_IO_SNAPSHOT_H

#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

/* Provenance: name and text, written as attributes of Run; ended by a NULL name. */
struct kith_note {
  const char *name, *text;
};

struct kith_snapshot_info {
  double time;
  uint64_t step;
  struct kith_box box;
  const struct kith_note *notes;
};

/* BAD_FILE with the path and the reason. */
kith_status kith_snapshot_write(const char *path, const struct kith_nodes *nodes, const struct kith_snapshot_info *info);
/* DIR/snapshots.hdf.series for ParaView: file names (relative) and times. */
kith_status kith_snapshot_series(const char *path, int n, const char *const *files, const double *times);

#endif
