/* output.h - what a run leaves in its directory: snapshots, their series, history, checkpoints; and how a run is restored.
 *
 * Of several ranks all write snapshots together (snapshot.h): nodes list by list, rank by rank, or, if the order must be the same for all, by
 * id. Checkpoints are written by rank 0 (with who had how many nodes: on the same number of ranks a restart finds all as it was; on another
 * number nodes go where their cells are). All of these are collective.
 *
 *   DIR/snapshot_NNNN.hdf  DIR/snapshots.hdf.series  DIR/history.csv  DIR/checkpoint.kith (and .previous)  DIR/report.json  DIR/plot.*
 *   DIR/balance.csv, of several ranks: a row for every look at the balance */
#ifndef KITH_APP_OUTPUT_H
#define KITH_APP_OUTPUT_H

#include "app/history.h"
#include "app/model.h"

struct kith_output {
  char directory[512];
  int n_snapshots, capacity;
  double *times;  /* of the snapshots written */
  double next;    /* when the next snapshot is due */
  uint64_t looks; /* at the balance, written */
  struct kith_history *history;
  double started; /* kith_seconds when the process began the run */
};

/* What a run started from: drifts are measured against it, also after a restart. Nothing but double, for checkpoints. */
struct kith_origin {
  struct kith_totals totals;
  double energy_drift, momentum_drift, angular_drift; /* largest so far, relative */
  double kinetic_least, kinetic_rebound; /* so far: least, and largest rise above the least until then */
  double velocity_over_sound;            /* largest so far */
  double measure[KITH_N_MEASURES];       /* what measures are compared with */
};

/* Creates the directory (parents too). BAD_FILE if it cannot be written: found before anything runs. */
kith_status kith_output_directory(struct kith_output *output, const char *directory);
/* Begins the history in it. `restarted`: keep what is there up to the model's step. */
kith_status kith_output_open(struct kith_output *output, const struct kith_model *model, bool restarted);
/* Snapshot under the next number, and the series of those that are there (a restart may have begun in another directory). */
kith_status kith_output_snapshot(struct kith_output *output, const struct kith_model *model);
/* A row of history after a step. */
kith_status kith_output_step(struct kith_output *output, const struct kith_model *model,
                             const struct kith_totals *totals);
/* A row of balance.csv if the lists of this step looked at the balance. */
kith_status kith_output_balance(struct kith_output *output, const struct kith_model *model);
kith_status kith_output_checkpoint(struct kith_output *output, const struct kith_model *model,
                                   const struct kith_origin *origin);
kith_status kith_output_close(struct kith_output *output);

/* Fills a fresh model from a checkpoint: fields, clock, lists. BAD_FILE if it is damaged, BAD_INPUT if it is of
 * another dimension or scene. `output` gets its snapshot times. */
kith_status kith_output_restore(struct kith_output *output, const char *path, struct kith_model *model,
                                struct kith_origin *origin);

/* The origin of a run that begins: its first totals. */
struct kith_origin kith_origin_of(const struct kith_totals *first);
/* Largest drifts so far. Energy: kinetic + internal + potential - work of moving walls. Momentum counts along axes without walls and pull.
 * Angular momentum has none (NaN) in 1-D, with a wall, with frozen nodes, which turn what meets them, and in uniform gravity. */
void kith_origin_follow(struct kith_origin *origin, const struct kith_model *model,
                        const struct kith_totals *now);

#endif
