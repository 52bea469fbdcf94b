/* report.h - what a run was, what it cost and how accurate it is: DIR/report.json for programs, a table for
 * people.
 *
 * Single values are the list below; beside them the file has
 *   norms.{density,velocity,pressure,energy,speed}.{l1,l2,linf}, and the single numbers of norms.h but
 *                                        shock_side; null without an exact solution
 *   measures.<name>                      those the scene requests (measure.h)
 *   stages.<path>.{seconds,calls}        of rank 0; of several ranks also {min,mean,max} of their seconds.
 *                                        Those of the first level, set-up, start, step, output, comparison
 *                                        and pictures, sum up to program_seconds
 *   fom.<name>                           figures of merit, over the seconds of the steps alone
 *   block_steps                          null without block time steps: ideal, achieved, and of each of
 *                                        `levels` step, nodes, ticks, updates, seconds (integrator/levels.h)
 *   ledger.<name>                        counts of the connectivity lifecycle, of all ranks, and bytes
 *   ledger.boundaries.<kind>[-<axis>].{created,culled,kept}   ghosts of each boundary
 *   ranks_detail.<name>[.{min,mean,max}] what each rank, also a single one, did and sent; largest_imbalance
 *                                        is null if no check followed the first one
 * Counts are those since the start of the scene, over all restarts: steps, pair_evaluations, those of ledger
 * and of remote ghosts. Seconds, rates, stages, block_steps, messages, message_bytes and collective_calls are
 * those of this process alone.
 * A number that is not finite is null.
 *
 * A stage in which ranks exchange data includes waiting: what a rank has more than the least of the ranks. */
#ifndef KITH_APP_OUTPUT_REPORT_H
#define KITH_APP_OUTPUT_REPORT_H

#include <jansson.h>
#include <stdio.h>
#include "app/simulation/simulation.h"
#include "validation/measure.h"
#include "validation/norms.h"

/* A value over all ranks. */
struct kith_spread {
  double min, mean, max;
};

/* Who made a report, when and how. */
struct kith_provenance {
  char host[64], date[32];
  char *command; /* owned */
};
/* Describes this process and moment, and a program started by these words. NO_MEMORY. */
kith_status kith_provenance_take(struct kith_provenance *provenance, char *const *arguments);

/* Figures of merit: of all ranks and threads; bytes: the least that the steps move, as counted by stages. */
struct kith_fom {
  double updates_per_second, per_core, pairs_per_second, bytes_per_update;
};
/* Prints "FOM node-updates/s = ...": the last line of run and bench. */
void kith_fom_print(const struct kith_fom *fom);

/* Single values: kind, member, key, value, unit, doc. A value is an expression of m (simulation), it
 * (integrator), b (baseline), p (provenance), now (totals), held (frozen nodes), sum (over ranks: nodes, row
 * entries, pair evaluations, cpu seconds, updates, pairs, nodes of gas) and wall (seconds). Changes, drifts:
 * the largest over the run (simulation.h). */
#define KITH_REPORT_LIST(X)                                                                               \
  X(TEXT, scene, "scene", m->scene->name, "", "name of the scene")                                        \
  X(COUNT, dimension, "dimension", NDIM, "", "1, 2 or 3")                                                 \
  X(TEXT, package, "package", m->package.ops->name, "", "hydro package")                                  \
  X(TEXT, packages, "packages", m->packages, "", "all packages, in the order in which rates add up")      \
  X(TEXT, kernel, "kernel", kith_kernel_facts[m->package.kernel].name, "", "")                            \
  X(TEXT, scheme, "scheme", it->scheme->name, "", "time integration")                                     \
  X(COUNT, ranks, "ranks", kith_ranks_size(m->nodes->ranks), "", "processes")                             \
  X(COUNT, threads, "threads", omp_get_max_threads(), "", "threads of each process")                      \
  X(COUNT, nodes, "nodes", (int64_t)sum[0], "", "internal nodes of all ranks, at the end")                \
  X(COUNT, gas_nodes, "gas_nodes", (int64_t)sum[6], "",                                                   \
    "those but the ones behind the faces of inflows and outflows")                                        \
  X(COUNT, frozen_nodes, "frozen_nodes", held != NULL ? held->n_internal : 0, "",                         \
    "nodes of frozen regions and barriers, which are not among nodes")                                    \
  X(COUNT, steps, "steps", (int64_t)it->step, "", "steps since the start of the scene")                   \
  X(REAL, time, "time", it->time, "scene", "time at the end")                                             \
  X(REAL, wall_seconds, "wall_seconds", wall, "s", "of start, steps and all output")                      \
  X(REAL, cpu_seconds, "cpu_seconds", sum[3], "s", "likewise, processor time of all ranks and threads")   \
  X(REAL, node_updates_per_second, "node_updates_per_second", sum[4] / fmax(wall, 1e-9), "1/s",           \
    "nodes * steps of this process, with block steps updates of active nodes, / wall_seconds")            \
  X(REAL, pairs_per_node, "pairs_per_node", 0.5 * sum[1] / fmax(sum[0], 1), "",                           \
    "half the row entries per node, at the end")                                                          \
  X(REAL, pair_evaluations, "pair_evaluations", sum[2], "", "evaluations of a pair function")             \
  X(REAL, energy_drift, "energy_drift", b->energy_drift, "", "relative change of the total energy")       \
  X(REAL, momentum_drift, "momentum_drift", b->momentum_drift, "",                                        \
    "change of the momentum over sum m max(|v|, c), along momentum_axes")                                 \
  X(COUNT, momentum_axes, "momentum_axes", kith_simulation_momentum_axes(m), "",                          \
    "number of axes along which no wall and no external force changes the momentum")                      \
  X(REAL, angular_momentum_drift, "angular_momentum_drift", b->angular_drift, "",                         \
    "likewise, of the angular momentum about the center")                                                 \
  X(REAL, kinetic_start, "kinetic.start", b->totals.kinetic, "scene", "kinetic energy at the start")      \
  X(REAL, kinetic_end, "kinetic.end", now.kinetic, "scene", "kinetic energy at the end")                  \
  X(REAL, kinetic_rebound, "kinetic.rebound",                                                             \
    b->totals.kinetic > 0 ? b->kinetic_rebound / b->totals.kinetic : NAN, "",                             \
    "largest rise of the kinetic energy above an earlier minimum, over kinetic.start; null if that is 0") \
  X(REAL, largest_mach, "velocity_over_sound.largest", b->velocity_over_sound, "",                        \
    "largest |v| / c of a node, over the run")                                                            \
  X(REAL, final_mach, "velocity_over_sound.end", now.velocity_over_sound, "", "the same at the end")      \
  X(COUNT, floors, "floors", 0, "", "values raised to a floor: always 0, since a run stops instead")      \
  X(REAL, program_seconds, "program_seconds", 0, "s", "since the program began, pictures included")       \
  X(TEXT, version, "version", kith_version(), "", "version of kith")                                      \
  X(TEXT, commit, "commit", kith_commit(), "", "commit of the sources, null outside of a repository")     \
  X(TEXT, host, "host", p->host, "", "host of rank 0")                                                    \
  X(TEXT, date, "date", p->date, "", "date and time of the start, ISO 8601, UTC")                         \
  X(TEXT, command, "command", p->command, "", "command line, as a shell takes it")                        \
  X(TEXT, compiler, "compiler", kith_compiler(), "", "")                                                  \
  X(TEXT, flags, "flags", kith_flags(), "", "flags of the compiler")

/* Texts and arrays are borrowed. A text that is NULL is null in the file. */
struct kith_report {
#define KITH_REPORT_TEXT const char *
#define KITH_REPORT_COUNT int64_t
#define KITH_REPORT_REAL double
#define X(kind, member, key, value, unit, doc) KITH_REPORT_##kind member;
  KITH_REPORT_LIST(X)
#undef X
  struct kith_fom fom;
  struct kith_levels levels; /* of all ranks */
  bool compared;             /* with an exact solution: norms are there */
  struct kith_norms norms;
  const bool *measured; /* [KITH_N_MEASURES] */
  double measure[KITH_N_MEASURES];
  int n_stages, n_counters;
  const struct kith_stage *stages; /* of the profile, in tree order */
  const struct kith_counter *counters;
  struct kith_spread
      *stage_spread;             /* [n_stages] seconds, 0 where a rank lacks a stage; NULL: one rank; owned */
  json_t *ledger, *ranks_detail; /* objects; owned, may be NULL */
};

/* Collects all but norms, measures, stages and ranks_detail. updates, pairs: of nodes and pairs of this rank,
 * in the steps of this process. The provenance is borrowed. Collective. */
void kith_report_collect(struct kith_report *out, const struct kith_simulation *simulation,
                         const struct kith_conservation_baseline *baseline,
                         const struct kith_provenance *provenance, double updates, double pairs,
                         double wall_seconds, double cpu_seconds);

/* Adds the stages until now, and ranks_detail: nodes, entries and ghosts of the last neighbor lists, and what
 * was sent per step. traffic: of the steps. Collective. */
kith_status kith_report_detail_ranks(struct kith_report *report, const struct kith_simulation *simulation,
                                     const struct kith_traffic *traffic, uint64_t n_steps,
                                     double largest_imbalance);
void kith_report_clear(struct kith_report *report);
/* Writes DIR/report.json, whole or not at all. */
kith_status kith_report_write(const struct kith_report *report, const char *path);
/* Prints the closing table of at most 100 columns; names that are too long are cut. `all`: of all stages,
 * with their counters and those of every rank, and what ranks_detail has. (report_print.c) */
void kith_report_print(const struct kith_report *report, bool all, FILE *out);

#endif
