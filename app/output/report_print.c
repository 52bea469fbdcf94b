/* The closing table of a run, for people. */
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/output/report.h"

/* The number `name` of an object; 0 if it is not there. */
static double at(const json_t *object, const char *name) {
  return json_number_value(json_object_get(object, name));
}

static void print_run(const struct kith_report *r, FILE *f) {
  fprintf(f, "%.30s  %" PRId64 "-D, %" PRId64 " nodes", r->scene, r->dimension, r->nodes);
  if (r->gas_nodes != r->nodes) fprintf(f, " (%" PRId64 " of gas)", r->gas_nodes);
  if (r->frozen_nodes > 0) fprintf(f, " and %" PRId64 " frozen", r->frozen_nodes);
  fprintf(f, ", %" PRId64 " step%s to t = %.6g", r->steps, r->steps == 1 ? "" : "s", r->time);
  if (at(r->ledger, "rejected_steps") > 0)
    fprintf(f, ", %.0f more rejected", at(r->ledger, "rejected_steps"));
  fputc('\n', f);
  fprintf(f, "  %.20s, %.20s, %.20s; %" PRId64 " rank%s x %" PRId64 " thread%s\n", r->package, r->kernel,
          r->scheme, r->ranks, r->ranks == 1 ? "" : "s", r->threads, r->threads == 1 ? "" : "s");
}

static void print_norms(const struct kith_norms *n, FILE *f) {
  static const char *const names[] = {"density", "velocity", "pressure", "energy", "azimuthal"};
  const struct kith_norm norm[] = {n->density, n->velocity, n->pressure, n->energy, n->speed};
  const char *side = n->shock_side == 0 ? "" : n->shock_side > 0 ? "right-going " : "left-going ";
  if (n->nodes == 0) {
    fprintf(f, "\n  against exact: no node is in exact.window\n");
    return;
  }
  fprintf(f, "\n  against exact %18s %12s %12s   (%" PRIu64 " nodes)\n", "L1", "L2", "Linf", n->nodes);
  for (int k = 0; k < (n->vortex ? 5 : 4); ++k)
    fprintf(f, "    %-16s %13.4e %12.4e %12.4e\n", names[k], norm[k].l1, norm[k].l2, norm[k].linf);
  if (n->shock_exact != 0 && n->shock_radius == 0)
    fprintf(f, "    no %sshock found, exact %.5g\n", side, n->shock_exact);
  if (n->shock_exact != 0 && n->shock_radius != 0)
    fprintf(f, "    %sshock at %.5g, exact %.5g (%+.2f %%, %+.2f spacings)\n", side, n->shock_radius,
            n->shock_exact, 100 * (n->shock_radius / n->shock_exact - 1), n->shock_offset);
  if (n->shock_swept > 0)
    fprintf(f, "    shock by the mass overrun %.5g (%+.2f %%)\n", n->shock_swept,
            100 * (n->shock_swept / n->shock_exact - 1));
  if (n->shock_outside)
    fprintf(f, "    the exact shock is outside of exact.window: the errors above do not include it\n");
  if (n->contact_pressure_error > 0)
    fprintf(f, "    pressure error at the contact %.2f %%\n", 100 * n->contact_pressure_error);
  if (n->vortex) fprintf(f, "    peak of the azimuthal velocity %.5g\n", n->speed_peak);
  if (n->density_peak > 0 && !n->vortex) fprintf(f, "    density peak %.5g\n", n->density_peak);
}

/* Prints an error relative to a sum; NaN: there is none. */
static void print_momentum(const char *name, double error, const char *scale, FILE *f) {
  if (isnan(error))
    fprintf(f, "\n  %s: walls or external forces change it", name);
  else
    fprintf(f, "\n  %s %.2e of sum %s", name, error, scale);
}

/* Prints errors of energy and momentum, and of what a scene is about: a vortex, gas at rest without a
 * shock. */
static void print_conservation(const struct kith_report *r, FILE *f) {
  const bool vortex = r->compared && r->norms.vortex,
             at_rest = r->compared && r->kinetic_start == 0 && r->norms.shock_exact == 0;
  fprintf(f, "\n  conservation errors: energy %.2e of the largest of total, work and kinetic energy",
          r->energy_drift);
  print_momentum("momentum", r->momentum_axes > 0 ? r->momentum_drift : NAN, "m max(|v|, c)", f);
  if (vortex &&
      !r->norms.carried) /* else it changes where gas leaves through one face and enters at another */
    print_momentum("angular momentum", r->angular_momentum_drift, "m |r x v|", f);
  if (vortex)
    fprintf(f, "\n  kinetic energy %.4g of %.4g, rebound %.2e", r->kinetic_end, r->kinetic_start,
            r->kinetic_rebound);
  if (at_rest)
    fprintf(f, "\n  largest velocity %.2e of sound, %.2e at the end", r->largest_mach, r->final_mach);
  fputc('\n', f);
}

static void print_counters(const struct kith_report *r, const struct kith_stage *stage, FILE *f) {
  const char *path = stage != NULL ? stage->path : "";
  for (int c = 0; c < r->n_counters; ++c)
    if (strcmp(r->counters[c].path, path) == 0)
      fprintf(f, "  %*s. %s %.10g\n", stage != NULL ? 2 * stage->depth + 2 : 0, "", r->counters[c].name,
              r->counters[c].total);
}

static double bytes_of(const struct kith_report *r, const struct kith_stage *stage) {
  for (int c = 0; c < r->n_counters; ++c)
    if (strcmp(r->counters[c].path, stage->path) == 0 && strcmp(r->counters[c].name, "bytes") == 0)
      return r->counters[c].total;
  return 0;
}

/* Prints the upper levels of stages, or all: with bytes and the imbalance of threads, or the seconds of all
 * ranks, and counters. Shares are of the seconds of the program; ns per update are those of steps. Names are
 * indented by depth, and cut where they are too long. */
static void print_stages(const struct kith_report *r, bool all, FILE *f) {
  enum { WIDTH = 36 };
  const struct kith_spread *spread = r->stage_spread;
  const double updates = r->node_updates_per_second * r->wall_seconds,
               program = KITH_MAX(r->program_seconds, 1e-9);
  double rest = program;
  if (r->n_stages == 0) return;
  fprintf(f, "\n  %-*s %9s %11s %7s %10s", WIDTH, "stage", "calls", "seconds", "share", "ns/update");
  if (all && spread == NULL) fprintf(f, " %8s %7s %9s", "B/update", "GB/s", "imbalance");
  if (all && spread != NULL) fprintf(f, " %11s %11s %11s", "min", "mean", "max");
  fprintf(f, "%s\n", spread != NULL ? "  max/mean" : "");
  for (int s = 0; s < r->n_stages; ++s) {
    const struct kith_stage *stage = &r->stages[s];
    if (!all && (stage->depth > 2 || (stage->depth > 0 && strncmp(stage->path, "step/", 5) != 0))) continue;
    const double per_update = updates > 0 && strncmp(stage->path, "step", 4) == 0 ? 1 / updates : 0;
    const int indent = KITH_MIN(2 * stage->depth, WIDTH - 8), room = WIDTH - indent;
    fprintf(f, "  %*s%-*.*s %9" PRIu64 " %11.5f %5.1f %%", indent, "", room, room, stage->name, stage->calls,
            stage->seconds, 100 * stage->seconds / program);
    kith_text_cell(f, 10, 1, 1e9 * per_update * stage->seconds);
    if (all && spread == NULL) {
      const double bytes = bytes_of(r, stage);
      kith_text_cell(f, 8, 0, per_update * bytes);
      kith_text_cell(f, 7, 2, bytes > 0 ? 1e-9 * bytes / stage->self_seconds : 0);
      kith_text_cell(f, 9, 2, stage->imbalance);
    }
    if (all && spread != NULL)
      fprintf(f, " %11.5f %11.5f %11.5f", spread[s].min, spread[s].mean, spread[s].max);
    if (spread != NULL && spread[s].mean > 0) fprintf(f, "%10.2f", spread[s].max / spread[s].mean);
    fputc('\n', f);
    if (all) print_counters(r, stage, f);
    if (stage->depth == 0) rest -= stage->seconds;
  }
  fprintf(f, "  %-*s %9s %11.5f %5.1f %%\n", WIDTH, "outside of any stage", "", rest, 100 * rest / program);
  fprintf(f, "  %-*s %9s %11.5f %5.1f %%\n", WIDTH, "program", "", program, 100.0);
  if (spread != NULL)
    fprintf(f, "  calls, seconds and shares%s are those of rank 0\n", all ? ", and counts (.)," : "");
  if (all) print_counters(r, NULL, f);
}

/* Prints what the levels of block time steps took, or only what they saved. */
static void print_levels(const struct kith_levels *levels, bool all, FILE *f) {
  const struct kith_level sum = kith_levels_sum(levels);
  const double ideal = kith_levels_ideal(levels), achieved = kith_levels_achieved(levels);
  if (!(sum.ticks > 0)) return;
  fprintf(f, "\n  block time steps: with all nodes active at each tick %.3g times as many updates,\n", ideal);
  fprintf(f, "  %.3g times the time (achieved over ideal: %.0f %%)\n", achieved, 100 * achieved / ideal);
  if (!all) return;
  fprintf(f, "  %-22s %11s %10s %8s %11s %7s %10s %7s\n", "level", "step", "nodes", "ticks", "updates",
          "share", "seconds", "share");
  for (int l = 0, n = kith_levels_used(levels); l < n; ++l) {
    const struct kith_level *level = &levels->level[l];
    char name[32] = "base step";
    if (l > 0) snprintf(name, sizeof name, "base step / %d", 1 << l);
    fprintf(f, "  %-22s %11.4g %10.1f %8.0f %11.0f %5.1f %% %10.4f %5.1f %%\n", name,
            ldexp(levels->time / levels->base_steps, -l), level->held / levels->time, level->ticks,
            level->updates, 100 * level->updates / sum.updates, level->seconds,
            100 * level->seconds / sum.seconds);
  }
}

/* Seconds and messages are those of this process, after a restart too; counts are sums over all steps. */
static void print_cost(const struct kith_report *r, FILE *f) {
  fprintf(f, "\n  steps and output: %.3f s wall, %.3f s cpu", r->wall_seconds, r->cpu_seconds);
  if (r->ranks > 1)
    fprintf(f, "; %.4g messages of %.4g bytes in the mean", at(r->ledger, "messages"),
            at(r->ledger, "message_bytes") / KITH_MAX(at(r->ledger, "messages"), 1));
  fprintf(f, "\n  %.1f pairs per node at the end, %.3g pair evaluations since the start of the scene\n",
          r->pairs_per_node, r->pair_evaluations);
  if (r->ranks == 1) return;
  fprintf(f, "  %.4g remote ghosts created since then, %.4g of them kept\n",
          at(r->ranks_detail, "remote_ghosts_created"), at(r->ranks_detail, "remote_ghosts_kept"));
  fprintf(f, "  %.4g nodes migrated, %.4g repartitions", at(r->ranks_detail, "nodes_migrated"),
          at(r->ranks_detail, "repartitions"));
  if (at(r->ledger, "work_imbalance") > 0)
    fprintf(f, ", work of the busiest rank %.3f of the mean at the last check",
            at(r->ledger, "work_imbalance"));
  if (at(r->ranks_detail, "largest_imbalance") > 0)
    fprintf(f, ", at most %.3f", at(r->ranks_detail, "largest_imbalance"));
  fputc('\n', f);
}

/* Large numbers, as of bytes, have all their digits. */
static void print_cell(double value, FILE *f) {
  fprintf(f, value < 1e5 ? " %10.5g" : " %10.0f", value);
}

static void print_ranks_detail(json_t *detail, FILE *f) {
  const char *key;
  json_t *value;
  fprintf(f, "\n  %-24s %10s %10s %10s %9s\n", "of a rank", "min", "mean", "max", "max/mean");
  json_object_foreach(detail, key, value) {
    if (!(at(value, "max") > 0)) continue;
    fprintf(f, "  %-24s", key);
    print_cell(at(value, "min"), f), print_cell(at(value, "mean"), f), print_cell(at(value, "max"), f);
    fprintf(f, " %9.3f\n", at(value, "max") / at(value, "mean"));
  }
  fprintf(f, "\n  of all ranks together\n");
  json_object_foreach(detail, key, value) {
    if (!json_is_number(value)) continue;
    fprintf(f, "  %-24s", key);
    print_cell(json_number_value(value), f);
    fputc('\n', f);
  }
}

void kith_fom_print(const struct kith_fom *fom) {
  printf("FOM node-updates/s = %.4g (per core %.4g, pairs/s %.4g, bytes/update %.0f)\n",
         fom->updates_per_second, fom->per_core, fom->pairs_per_second, fom->bytes_per_update);
}

void kith_report_print(const struct kith_report *report, bool all, FILE *out) {
  print_run(report, out);
  bool judged = report->compared;
  if (report->compared) print_norms(&report->norms, out);
  for (int k = 0; k < KITH_N_MEASURES; ++k) judged = judged || report->measured[k];
  if (!judged) fputs("\n  no exact solution to compare with (exact.name; kith list exact)\n", out);
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (report->measured[k] && isfinite(report->measure[k]))
      fprintf(out, "    %s %.5g\n", kith_measure_names[k], report->measure[k]);
    else if (report->measured[k])
      fprintf(out, "    %s none: there is nothing to measure at the end\n", kith_measure_names[k]);
  print_conservation(report, out);
  print_stages(report, all, out);
  print_levels(&report->levels, all, out);
  print_cost(report, out);
  if (all && report->ranks > 1) print_ranks_detail(report->ranks_detail, out);
}
