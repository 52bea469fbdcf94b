/* validate_same.h - do two runs end in the same state? Compares the particles of two snapshots. */
#ifndef KITH_APP_VALIDATE_SAME_H
#define KITH_APP_VALIDATE_SAME_H

#include "lib/core/base.h"

struct kith_same {
  double difference; /* of the worst field: largest difference over largest value; 0: the same bits */
  char field[64];    /* its name */
};

/* Two snapshots (snapshot.h), all fields of PartType0. `by_nodes`: node by node, wherever it is stored; else as they are stored, to the
 * last bit, and the same time. Another number of nodes, other ids or other fields: the difference is infinite. BAD_FILE: a file that is
 * not there, or no snapshot. */
kith_status kith_same_snapshots(const char *a, const char *b, bool by_nodes, struct kith_same *same);

#endif
