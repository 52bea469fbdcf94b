/* matrix.h - many runs, each a process of its own, and what was measured in them: a file that only grows.
 *
 * DIR/points.csv has one line per finished run: its key, the program's version, what it was, and every metric. The key is a hash of the
 * scene's text, the dimension, the settings and the number of threads. A run whose key is in the file, by the same version, is not run
 * again: what was interrupted goes on, and a matrix may grow. A line is written at once, and a part of a line (a full disk, a lost
 * machine) is dropped when the file is opened. Runs that failed are lines too, with the reason; take out the line to try again.
 *
 * Of each run stay DIR/runs/NAME/report.json and history.csv, and DIR/runs/NAME.log. */
#ifndef KITH_APP_MATRIX_H
#define KITH_APP_MATRIX_H

#include "app/csv.h"
#include "app/process.h"

/* name here, where it is in a report, what to call it on an axis */
#define KITH_METRIC_LIST(X)                                                                        \
  X(cpu_seconds, "cpu_seconds", "CPU-seconds")                                                     \
  X(wall_seconds, "wall_seconds", "seconds")                                                       \
  X(pair_evaluations, "pair_evaluations", "pair evaluations")                                      \
  X(nodes, "nodes", "nodes")                                                                       \
  X(steps, "steps", "steps")                                                                       \
  X(time, "time", "time at the end")                                                               \
  X(energy_drift, "energy_drift", "drift of energy")                                               \
  X(momentum_drift, "momentum_drift", "drift of momentum")                                         \
  X(angular_momentum_drift, "angular_momentum_drift", "drift of angular momentum")                 \
  X(kinetic.start, "kinetic.start", "kinetic energy at the start")                                 \
  X(kinetic.end, "kinetic.end", "kinetic energy at the end")                                       \
  X(kinetic.change, "kinetic.end", "change of the kinetic energy")                                 \
  X(kinetic.rebound, "kinetic.rebound", "rise of the kinetic energy")                              \
  X(velocity_over_sound.largest, "velocity_over_sound.largest", "largest velocity over sound")     \
  X(velocity_over_sound.end, "velocity_over_sound.end", "largest velocity over sound, at the end") \
  X(density.l1, "norms.density.l1", "L1 error of density")                                         \
  X(density.l2, "norms.density.l2", "L2 error of density")                                         \
  X(density.linf, "norms.density.linf", "largest error of density")                                \
  X(velocity.l1, "norms.velocity.l1", "L1 error of velocity")                                      \
  X(velocity.l2, "norms.velocity.l2", "L2 error of velocity")                                      \
  X(velocity.linf, "norms.velocity.linf", "largest error of velocity")                             \
  X(pressure.l1, "norms.pressure.l1", "L1 error of pressure")                                      \
  X(pressure.l2, "norms.pressure.l2", "L2 error of pressure")                                      \
  X(pressure.linf, "norms.pressure.linf", "largest error of pressure")                             \
  X(energy.l1, "norms.energy.l1", "L1 error of energy")                                            \
  X(energy.l2, "norms.energy.l2", "L2 error of energy")                                            \
  X(energy.linf, "norms.energy.linf", "largest error of energy")                                   \
  X(speed.l1, "norms.speed.l1", "L1 error of the azimuthal velocity")                              \
  X(speed.l2, "norms.speed.l2", "L2 error of the azimuthal velocity")                              \
  X(speed.linf, "norms.speed.linf", "largest error of the azimuthal velocity")                     \
  X(blip, "norms.blip", "pressure blip at the contact")                                            \
  X(shock, "norms.shock_radius", "error of the shock's place")                                     \
  X(density_peak, "norms.density_peak", "density peak")                                            \
  X(floors, "floors", "values lifted to a floor")
enum {
#define X(name, path, doc) +1
  KITH_N_METRICS = 0 KITH_METRIC_LIST(X)
#undef X
};
/* Two follow from two numbers, NaN where one is missing: `shock` is |shock_radius / shock_exact - 1|, kinetic.change is |end / start - 1|. */
struct kith_metric {
  const char *name, *path, *doc;
};
extern const struct kith_metric kith_metrics[KITH_N_METRICS];
/* Position, or -1. */
int kith_metric_find(const char *name);
/* "density.l1|..." for messages. */
extern const char kith_metric_words[];

enum { KITH_JOB_SETTINGS = 64, KITH_JOB_SETTING = 256, KITH_METHOD_TEXT = 96 };

struct kith_job {
  const char *scene;                                 /* path, borrowed */
  int dimension, ranks, n_settings;                  /* ranks: 0 or 1: one process */
  char setting[KITH_JOB_SETTINGS][KITH_JOB_SETTING]; /* key=value, as --set takes them */
  char method[KITH_METHOD_TEXT];                     /* what people call it */
  double x;                                          /* where it stands: resolution, or value of a knob */
};
/* Adds key=value, or, for the key `ranks`, says on how many processes it is run; BAD_INPUT if it does not fit. */
kith_status kith_job_set(struct kith_job *job, const char *key, const char *value);

struct kith_point {
  uint64_t key;
  char method[KITH_METHOD_TEXT], why[256]; /* why: of a failure */
  double x;
  bool failed;
  double value[KITH_N_METRICS]; /* NaN: not in the report */
};

struct kith_matrix {
  struct kith_programs programs;
  char directory[KITH_PATH];
  int threads;
  double cpu_limit; /* seconds for a run; 0: none */
  int lock;
  FILE *file;
  int n;
  struct kith_point *point; /* all of this version that are in the file */
};

/* Makes DIR and opens DIR/points.csv; BAD_FILE if that cannot be, or another process has it. */
kith_status kith_matrix_open(struct kith_matrix **out, const char *directory, int threads, double cpu_limit);
void kith_matrix_close(struct kith_matrix **matrix);
uint64_t kith_matrix_key(const struct kith_matrix *matrix, const struct kith_job *job);
/* View, until the next run; NULL: not run yet. */
const struct kith_point *kith_matrix_find(const struct kith_matrix *matrix, uint64_t key);
/* Runs the job and keeps the point. A run that fails is a point; an error is what keeps points from being kept. */
kith_status kith_matrix_run(struct kith_matrix *matrix, const struct kith_job *job, struct kith_point *point);
/* Starts `verb` (run, or plan, which is of one process) of a job with its words into `log`. */
kith_status kith_job_start(const struct kith_matrix *matrix, const struct kith_job *job, const char *verb,
                           const char *directory, const char *log, int *code);
/* What `kith plan` says of a job: its exit code, with the reason if that is not 0, and the seconds that it expects (NaN: unknown).
 * Nothing is written. */
kith_status kith_job_plan(const struct kith_programs *programs, int threads, const struct kith_job *job,
                          int *code, double *seconds, char why[256]);
/* Why a program stopped: the last line of a log that starts with "kith: ", or the code. */
void kith_log_reason(const char *log, int code, char why[256]);

#endif
