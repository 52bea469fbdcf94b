/* snapshot_diff.h - do two runs end in the same state? Compares the particles of two snapshots. */
#ifndef KITH_APP_STUDY_SNAPSHOT_DIFF_H
#define KITH_APP_STUDY_SNAPSHOT_DIFF_H

#include "lib/core/base.h"

struct kith_snapshot_diff {
  double difference; /* of the worst field: largest difference over largest value; 0: bitwise identical */
  char field[64];    /* its name */
};

/* Two snapshots (lib/io/snapshot.h), all fields of PartType0. `by_nodes`: node by node, wherever it is
 * stored; else bitwise, as they are stored, and the same time. Another number of nodes, other ids or other
 * fields: the difference is infinite. BAD_FILE: a file that is not there, or no snapshot. */
kith_status kith_snapshot_diff_files(const char *a, const char *b, bool by_nodes,
                                     struct kith_snapshot_diff *same);

#endif
