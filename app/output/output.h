/* output.h - what a run leaves in its directory.
 *
 *   DIR/snapshot_NNNN.hdf  DIR/snapshots.hdf.series  DIR/history.csv  DIR/checkpoint.kith (and .previous)
 *   DIR/offenders.hdf (of a run that went wrong)
 *   DIR/report.json        DIR/plot.*                  DIR/probes.h5    DIR/contacts.csv  DIR/growth.csv
 *
 * All ranks write snapshots together (snapshot.h), by id if the order must be the same for any
 * number of ranks. Checkpoints are written by rank 0: on the same number of ranks a restart is bitwise
 * identical, on another number nodes go to the rank of their cell. All of these are collective. */
#ifndef KITH_APP_OUTPUT_OUTPUT_H
#define KITH_APP_OUTPUT_OUTPUT_H

#include <jansson.h>
#include "app/output/contacts.h"
#include "app/output/growth.h"
#include "app/output/history.h"
#include "app/output/probes.h"
#include "app/simulation/simulation.h"

struct kith_output {
  char directory[512];
  int lock; /* descriptor of the directory, which this run alone writes to; 0: not locked */
  int n_snapshots;
  size_t capacity;
  double *times;      /* of the snapshots written */
  bool from_previous; /* restored from the last checkpoint but one: the last is damaged */
  struct kith_history history;
  struct kith_probes *probes;     /* NULL: the scene has none */
  struct kith_contacts *contacts; /* NULL: the scene has none */
  struct kith_growth growth;
};

/* Opens the directory, which rank 0 creates with its parents, and the tables in it. No other run may write
 * there until it is closed. A run that goes on from a `checkpoint` in that directory
 * (NULL: from none) continues the tables, and deletes snapshots that it has yet to write. Otherwise the
 * checkpoint of an earlier run is refused unless it may be overwritten, and all that is left of that run is
 * deleted. The status is of this rank alone. */
kith_status kith_output_open(struct kith_output *output, struct kith_simulation *simulation,
                             const char *directory, const char *checkpoint, bool overwrite);
/* The time of the next snapshot, a multiple of output.every; infinite if only the first and last are wanted.
 * It follows from the time alone, so that a restart has it, too, with another output.every as well. */
double kith_output_next(const struct kith_scene *scene, double time);
/* The time that the next step of a run to `until` must not pass: the `next` snapshot, unless only a tiny last
 * step would follow it. */
double kith_output_step_end(const struct kith_scene *scene, double next, double until);
/* Writes a snapshot under the next number, and the list of those that are there. */
kith_status kith_output_snapshot(struct kith_output *output, const struct kith_simulation *simulation);
/* After a failure: writes a snapshot DIR/offenders.hdf of the node with this id and all that it shares a
 * support with; deletes the other nodes. *written: false if there is no such node, or its reach is not
 * finite. */
kith_status kith_output_offenders(const struct kith_output *output, struct kith_simulation *simulation,
                                  int64_t id, bool *written);
kith_status kith_output_close(struct kith_output *output);
/* Writes JSON, which it takes over. NO_MEMORY, and nothing is written, if jansson lacked memory for something
 * since kith_json_watch. */
kith_status kith_json_write(const char *path, json_t *json);
void kith_json_watch(void);
/* Writes a JSON array of the events of all ranks, whose clocks were aligned (kith_profile_align). Each
 * appends its own to the file, in turn, which must be visible to all. All learn of a failure. */
kith_status kith_trace_write(struct kith_ranks *ranks, const struct kith_profile *profile, const char *path);

kith_status kith_output_checkpoint(struct kith_output *output, struct kith_simulation *simulation,
                                   const struct kith_conservation_baseline *baseline);
/* Fills a fresh simulation from a checkpoint, or, if that is damaged or not there, with a warning from the
 * one before it: fields, clock, neighbor lists. BAD_FILE if both are damaged, BAD_INPUT if it is of another
 * dimension or scene. `output` gets its snapshot times. */
kith_status kith_output_restore(struct kith_output *output, const char *path,
                                struct kith_simulation *simulation,
                                struct kith_conservation_baseline *baseline);

#endif
