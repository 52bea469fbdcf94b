/* others.h - points of other codes, measured elsewhere: a CSV file that is drawn beside.
 *
 *   columns: scene code machine resolution cpu_seconds norm value, and perhaps dimension, version
 *
 * One line for each norm of each run; norms are named as in matrix.h. */
#ifndef KITH_APP_OTHERS_H
#define KITH_APP_OTHERS_H

#include "app/csv.h"

struct kith_other {
  const char *code, *version, *machine, *norm; /* views of the file */
  double resolution, cpu_seconds, value;
};
struct kith_others {
  struct kith_csv *csv; /* owned */
  int n;
  struct kith_other *other; /* owned; of the scene that was asked for */
};

/* Reads all, keeps those of `scene` and (where the column is there) of `dimension`. BAD_INPUT with the line for what is missing or no
 * number. */
kith_status kith_others_read(struct kith_others *out, const char *path, const char *scene, int dimension);
void kith_others_clear(struct kith_others *others);

#endif
