/* snapshot.h - one HDF5 file that ParaView (VTKHDF 1.0, UnstructuredGrid of vertices) and yt (Gadget layout)
 * both open.
 *
 * PartType0 holds every field of the nodes that has an `output` name, internal nodes only; among them,
 * always, Coordinates, SmoothingLength (the support H), ParticleIDs and MaterialIDs. Vectors are [n][3] and
 * tensors [n][9], padded with zeros in 1-D and 2-D; each data set says in its attribute Description what it
 * is. VTKHDF hard-links the same data sets: nothing is stored twice but for 17 bytes a node of cells. Header
 * is as Gadget has it. BoxSize is the scalar 0: readers then take the bounds of the data, which also holds
 * for negative coordinates and boxes that are no cubes; where an axis has no width, in 1-D and 2-D, yt needs
 * yt.load(..., bounding_box=...). Units says that all units are 1 (the scene's own). Run: attributes
 * Dimension, Time, Step, BoxLower, BoxUpper, MaterialNames (one a line), and the notes. Written to a
 * temporary name, synced, renamed. ParaView knows the layout by the extension, so PATH ends in .hdf.
 *
 * Of several ranks, rank 0 makes the file with all that is in it but the values of the nodes, which then all write into
 * their places, through the MPI-IO of HDF5: no rank has more than its own nodes and one more field of them. Nodes stand list by list,
 * rank by rank, as they lie. Which byte is where depends on their numbers alone: neither on that of ranks nor on there being MPI. */
#ifndef KITH_IO_SNAPSHOT_H
#define KITH_IO_SNAPSHOT_H

#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

/* Provenance: name and text, written as attributes of Run; a text above 60000 bytes, which no attribute
 * holds, becomes a data set of Run. The list is ended by a NULL name; NULL notes: none. */
struct kith_note {
  const char *name, *text;
};

struct kith_snapshot_info {
  double time;
  uint64_t step;
  struct kith_box box;
  const struct kith_note *notes;
};

/* BAD_FILE with the path and the reason. Collective: all ranks give the same path, which all must see, and the same `info`. Rank 0
 * reserves the room before HDF5 begins: a full disk is found then. All agree on what happened, but for an MPI-IO that cannot open the file on some
 * ranks only: ranks.h tells what comes then. */
kith_status kith_snapshot_write(const char *path, const struct kith_nodes *nodes,
                                const struct kith_snapshot_info *info);
/* DIR/snapshots.hdf.series for ParaView: file names (relative) and times. */
kith_status kith_snapshot_series(const char *path, int n, const char *const *files, const double *times);

#endif
