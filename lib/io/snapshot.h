/* snapshot.h - one HDF5 file that ParaView (VTKHDF 1.0, UnstructuredGrid of vertices) and yt (Gadget layout)
 * both open.
 *
 * PartType0 holds every field of the internal nodes that has an `output` name; SmoothingLength is the
 * support. Vectors are [n][3] and tensors [n][9], zeros behind in 1-D and 2-D; Description says what they
 * are. VTKHDF hard-links the same data sets, and has cells, 17 bytes a node. Header is that of
 * Gadget; BoxSize, of which it has one, is the longest side of the box. Units says that all units are 1 (the
 * scene's own); yt's reader of Gadget files assumes kpc whatever they say, app/python/kith.py teaches it.
 * Run: attributes Dimension, Time, Step, BoxLower, BoxUpper, Periodic (of each axis), MaterialNames (one a
 * line), and the notes. Frozen nodes stand behind the internal ones of their list; NodeFlags tells them.
 * ParaView knows the layout by the extension, so PATH ends in .hdf.
 *
 * With several ranks, rank 0 creates the file with all metadata; then all ranks write the values of their own
 * nodes to their places in it: no rank holds more than its own nodes and one more field of them. Nodes
 * are stored list by list, rank by rank, in memory order. The layout depends on the numbers of nodes only:
 * not on the number of ranks. */
#ifndef KITH_IO_SNAPSHOT_H
#define KITH_IO_SNAPSHOT_H

#include "lib/core/vec.h"
#include "lib/nodes/nodes.h"

/* A name and a text about the run, written as an attribute of Run, or as a data set of Run if the text is too
 * long for an attribute (above 60000 bytes). A list of notes is ended by a NULL name. */
struct kith_note {
  const char *name, *text;
};

struct kith_snapshot_info {
  double time;
  uint64_t step;
  struct kith_box box;
  bool periodic[NDIM];
  const struct kith_nodes *frozen; /* the same on all ranks; NULL: none */
  const struct kith_note *notes;   /* NULL: none */
};

/* BAD_FILE with the path and the reason. Collective: all ranks give the same path, which must be visible to
 * all, and the same `info`. All return the same status. */
kith_status kith_snapshot_write(const char *path, const struct kith_nodes *nodes,
                                const struct kith_snapshot_info *info);
#endif
