#include "app/report.h"

#include <inttypes.h>
#include <string.h>
#include "lib/io/atomic_file.h"
#include "lib/io/json.h"

/* The file. Members end with ",\n", the last one of an object with "\n". */

static void put_text(FILE *f, const char *key, const char *text, const char *end) {
  fprintf(f, "  \"%s\": ", key);
  kith_json_string(f, text);
  fputs(end, f);
}

static void put_number(FILE *f, const char *key, double value) {
  fprintf(f, "  \"%s\": ", key);
  kith_json_number(f, value);
  fputs(",\n", f);
}

static void put_count(FILE *f, const char *key, uint64_t count) {
  fprintf(f, "  \"%s\": %" PRIu64 ",\n", key, count);
}

static void put_norm(FILE *f, const char *name, const struct kith_norm *norm) {
  fprintf(f, "    \"%s\": {\"l1\": ", name);
  kith_json_number(f, norm->l1);
  fputs(", \"l2\": ", f);
  kith_json_number(f, norm->l2);
  fputs(", \"linf\": ", f);
  kith_json_number(f, norm->linf);
  fputs("},\n", f);
}

static void put_norms(FILE *f, const struct kith_report *r) {
  const struct kith_norms *n = &r->norms;
  if (!r->compared) {
    fputs("  \"norms\": null,\n", f);
    return;
  }
  fputs("  \"norms\": {\n", f);
  put_norm(f, "density", &n->density);
  put_norm(f, "velocity", &n->velocity);
  put_norm(f, "pressure", &n->pressure);
  put_norm(f, "energy", &n->energy);
  put_norm(f, "speed", &n->speed);
  fprintf(f, "    \"nodes\": %" PRId64 ",\n  ", (int64_t)n->nodes);
  put_number(f, "blip", n->blip), fputs("  ", f);
  put_number(f, "shock_radius", n->shock_radius), fputs("  ", f);
  put_number(f, "shock_exact", n->shock_exact), fputs("  ", f);
  put_number(f, "density_peak", n->density_peak), fputs("    \"speed_peak\": ", f);
  kith_json_number(f, n->speed_peak);
  fputs("\n  },\n", f);
}

static void put_measures(FILE *f, const struct kith_report *r) {
  const char *comma = "";
  fputs("  \"measures\": {", f);
  for (int k = 0; k < KITH_N_MEASURES; ++k) {
    if (r->measured == NULL || !r->measured[k]) continue;
    fprintf(f, "%s\"%s\": ", comma, kith_measure_names[k]);
    kith_json_number(f, r->measure[k]);
    comma = ", ";
  }
  fputs("},\n", f);
}

/* Members of an object. */
static void put_spread(FILE *f, const char *before, const struct kith_spread *spread) {
  fprintf(f, "%s\"min\": ", before), kith_json_number(f, spread->least);
  fputs(", \"mean\": ", f), kith_json_number(f, spread->mean);
  fputs(", \"max\": ", f), kith_json_number(f, spread->most);
}

/* The last member of the file. */
static void put_ranks(FILE *f, const struct kith_report *r) {
  const struct kith_ranks_detail *d = r->ranks_detail;
  fputs("  \"ranks_detail\": ", f);
  if (d == NULL) {
    fputs("null\n", f);
    return;
  }
  const struct kith_report_entry entry[] = {{"collectives_per_step", d->collectives_per_step},
                                            {"remote_ghosts_created", d->created},
                                            {"remote_ghosts_culled", d->culled},
                                            {"remote_ghosts_kept", d->kept},
                                            {"remote_ghosts_last", d->last_kept},
                                            {"remote_ghosts_last_needed", d->last_needed},
                                            {"nodes_migrated", d->migrated},
                                            {"repartitions", d->repartitions}};
  fputs("{\n", f);
#define X(name, doc) put_spread(f, "    \"" #name "\": {", &d->name), fputs("},\n", f);
  KITH_RANKS_SPREAD_LIST(X)
#undef X
  for (size_t k = 0; k < sizeof entry / sizeof *entry; ++k) {
    fprintf(f, "%s    \"%s\": ", k > 0 ? ",\n" : "", entry[k].name);
    kith_json_number(f, entry[k].value);
  }
  fputs("\n  }\n", f);
}

static void put_stages(FILE *f, const struct kith_report *r) {
  fputs("  \"stages\": {", f);
  for (int s = 0; s < r->n_stages; ++s) {
    fputs(s > 0 ? ",\n    " : "\n    ", f);
    kith_json_string(f, r->stages[s].path);
    fputs(": {\"seconds\": ", f);
    kith_json_number(f, r->stages[s].seconds);
    fprintf(f, ", \"calls\": %" PRIu64, r->stages[s].calls);
    if (r->stage_times != NULL) {
      const struct kith_stage_times *t = r->stage_times;
      put_spread(f, ", ", &(struct kith_spread){t->least[s], t->mean[s], t->most[s]});
    }
    fputc('}', f);
  }
  fputs(r->n_stages > 0 ? "\n  },\n" : "},\n", f);
}

static void put_ledger(FILE *f, const struct kith_report *r) {
  fputs("  \"ledger\": {", f);
  for (int k = 0; k < r->n_ledger; ++k) {
    fputs(k > 0 ? ",\n    " : "\n    ", f);
    kith_json_string(f, r->ledger[k].name);
    fputs(": ", f);
    kith_json_number(f, r->ledger[k].value);
  }
  fputs(r->n_ledger > 0 ? "\n  },\n" : "},\n", f);
}

static void put_run(FILE *f, const struct kith_report *r) {
  put_text(f, "scene", r->scene, ",\n");
  fprintf(f, "  \"dimension\": %d,\n", r->dimension);
  put_text(f, "package", r->package, ",\n");
  put_text(f, "kernel", r->kernel, ",\n");
  put_text(f, "scheme", r->scheme, ",\n");
  fprintf(f, "  \"ranks\": %d,\n  \"threads\": %d,\n", r->ranks, r->threads);
  put_count(f, "nodes", r->nodes);
  put_count(f, "steps", r->steps);
  put_number(f, "time", r->time);
  put_number(f, "wall_seconds", r->wall_seconds);
  put_number(f, "cpu_seconds", r->cpu_seconds);
  put_number(f, "node_updates_per_second", r->node_updates_per_second);
  put_number(f, "pairs_per_node", r->pairs_per_node);
  put_number(f, "pair_evaluations", r->pair_evaluations);
  put_number(f, "energy_drift", r->energy_drift);
  put_number(f, "momentum_drift", r->momentum_drift);
  put_number(f, "angular_momentum_drift", r->angular_momentum_drift);
  fputs("  \"kinetic\": {\"start\": ", f);
  kith_json_number(f, r->kinetic.start);
  fputs(", \"end\": ", f);
  kith_json_number(f, r->kinetic.end);
  fputs(", \"rebound\": ", f);
  kith_json_number(f, r->kinetic.rebound);
  fputs("},\n  \"velocity_over_sound\": {\"largest\": ", f);
  kith_json_number(f, r->velocity_over_sound.largest);
  fputs(", \"end\": ", f);
  kith_json_number(f, r->velocity_over_sound.end);
  fputs("},\n", f);
}

kith_status kith_report_write(const struct kith_report *report, const char *path) {
  struct kith_atomic_file *file;
  KITH_TRY(kith_atomic_file_open(&file, path));
  FILE *f = file->stream;
  fputs("{\n", f);
  put_run(f, report);
  put_norms(f, report);
  put_measures(f, report);
  put_stages(f, report);
  put_ledger(f, report);
  put_count(f, "floors", report->floors);
  put_text(f, "version", report->version, ",\n");
  put_text(f, "compiler", report->compiler, ",\n");
  put_text(f, "flags", report->flags, ",\n");
  put_ranks(f, report);
  fputs("}\n", f);
  return kith_atomic_file_commit(&file, false);
}

/* The table. */

static const char *shown(const char *text) {
  return text != NULL ? text : "-";
}

static void print_run(const struct kith_report *r, FILE *f) {
  fprintf(f, "%.60s  %d-D, %" PRIu64 " nodes, %" PRIu64 " steps to t = %.6g", shown(r->scene), r->dimension,
          r->nodes, r->steps, r->time);
  if (r->rejected > 0) fprintf(f, ", %" PRIu64 " more rejected", r->rejected);
  fputc('\n', f);
  fprintf(f, "  %.20s, %.20s, %.20s; %d rank%s x %d thread%s\n", shown(r->package), shown(r->kernel),
          shown(r->scheme), r->ranks, r->ranks == 1 ? "" : "s", r->threads, r->threads == 1 ? "" : "s");
}

static void print_norms(const struct kith_norms *n, FILE *f) {
  const struct {
    const char *name;
    const struct kith_norm *norm;
  } rows[] = {{"density", &n->density},
              {"velocity", &n->velocity},
              {"pressure", &n->pressure},
              {"energy", &n->energy},
              {"azimuthal", &n->speed}};
  fprintf(f, "\n  against exact %18s %12s %12s   (%" PRId64 " nodes)\n", "L1", "L2", "Linf",
          (int64_t)n->nodes);
  for (int k = 0; k < (n->vortex ? 5 : 4); ++k)
    fprintf(f, "    %-16s %13.4e %12.4e %12.4e\n", rows[k].name, rows[k].norm->l1, rows[k].norm->l2,
            rows[k].norm->linf);
  if (n->shock_exact > 0 && n->shock_radius <= 0)
    fprintf(f, "    no shock found, exact %.5g\n", n->shock_exact);
  if (n->shock_exact > 0 && n->shock_radius > 0)
    fprintf(f, "    shock at %.5g, exact %.5g (%+.2f %%)\n", n->shock_radius, n->shock_exact,
            100 * (n->shock_radius / n->shock_exact - 1));
  if (n->blip > 0) fprintf(f, "    pressure blip at the contact %.2f %%\n", 100 * n->blip);
  if (n->vortex) fprintf(f, "    peak of the azimuthal velocity %.5g\n", n->speed_peak);
  if (n->density_peak > 0 && !n->vortex) fprintf(f, "    density peak %.5g\n", n->density_peak);
}

static void print_measures(const struct kith_report *r, FILE *f) {
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (r->measured != NULL && r->measured[k])
      fprintf(f, "    %s %.5g\n", kith_measure_names[k], r->measure[k]);
}

/* Gas at rest that no shock will move. */
static bool at_rest(const struct kith_report *r) {
  return r->compared && r->kinetic.start == 0 && r->norms.shock_exact == 0;
}

/* Beyond energy and momentum, only what the scene is about. */
static void print_conservation(const struct kith_report *r, FILE *f) {
  const bool vortex = r->compared && r->norms.vortex;
  fprintf(f, "\n  drift of energy %.2e, of momentum %.2e", r->energy_drift, r->momentum_drift);
  if (vortex)
    fprintf(f, ", of angular momentum %.2e\n  kinetic energy %.4g of %.4g, rebound %.2e",
            r->angular_momentum_drift, r->kinetic.end, r->kinetic.start, r->kinetic.rebound);
  if (at_rest(r))
    fprintf(f, "\n  largest velocity %.2e of sound, %.2e at the end", r->velocity_over_sound.largest,
            r->velocity_over_sound.end);
  if (r->floors > 0) fprintf(f, "\n  %" PRIu64 " values lifted to a floor", r->floors);
  fputc('\n', f);
}

/* Share: of the wall time. Names are indented by depth; one that is too long is cut. */
static void print_stages(const struct kith_report *r, FILE *f) {
  enum { WIDTH = 36 };
  if (r->n_stages == 0) return;
  fprintf(f, "\n  %-*s %12s %12s %8s %12s%s\n", WIDTH, "stage", "calls", "seconds", "share", "ns/update",
          r->stage_times != NULL ? "  max/mean" : "");
  const double updates = (double)r->nodes * (double)r->steps;
  for (int s = 0; s < r->n_stages; ++s) {
    const struct kith_stage *stage = &r->stages[s];
    if (stage->depth > 2 || (stage->depth > 0 && strncmp(stage->path, "step/", 5) != 0))
      continue; /* --profile shows all */
    const int indent = KITH_MIN(2 * stage->depth, WIDTH - 8), room = WIDTH - indent;
    fprintf(f, "  %*s%-*.*s %12" PRIu64 " %12.4f ", indent, "", room, room, stage->name, stage->calls,
            stage->seconds);
    fprintf(f, "%6.1f %% ", r->wall_seconds > 0 ? 100 * stage->seconds / r->wall_seconds : 0.0);
    fprintf(f, "%12.1f", updates > 0 ? 1e9 * stage->seconds / updates : 0.0);
    if (r->stage_times != NULL && r->stage_times->mean[s] > 0)
      fprintf(f, "%10.2f", r->stage_times->most[s] / r->stage_times->mean[s]);
    fputc('\n', f);
  }
}

static void print_cost(const struct kith_report *r, FILE *f) {
  fprintf(f, "\n  %.3f s wall, %.3f s cpu; %.3g node updates/s, %.1f pairs per node, %.3g pair evaluations\n",
          r->wall_seconds, r->cpu_seconds, r->node_updates_per_second, r->pairs_per_node,
          r->pair_evaluations);
}

static double entry_of(const struct kith_report *r, const char *name) {
  for (int k = 0; k < r->n_ledger; ++k)
    if (strcmp(r->ledger[k].name, name) == 0) return r->ledger[k].value;
  return 0;
}

/* What the ranks had to do with each other. */
static void print_ranks(const struct kith_report *r, FILE *f) {
  if (r->ranks == 1) return;
  fprintf(f, "  %.4g messages of %.4g bytes in the mean; ghosts of other ranks: %.4g made, %.4g kept\n",
          entry_of(r, "messages"), entry_of(r, "message_bytes") / KITH_MAX(entry_of(r, "messages"), 1),
          entry_of(r, "remote_ghosts_created"), entry_of(r, "remote_ghosts_kept"));
  fprintf(f, "  %.4g nodes migrated, %.4g new maps", entry_of(r, "nodes_migrated"),
          entry_of(r, "repartitions"));
  if (entry_of(r, "work_imbalance") > 0)
    fprintf(f, ", work of the busiest rank %.3f of the mean", entry_of(r, "work_imbalance"));
  fputc('\n', f);
}

void kith_report_print(const struct kith_report *report, FILE *out) {
  print_run(report, out);
  if (report->compared) print_norms(&report->norms, out);
  print_measures(report, out);
  print_conservation(report, out);
  print_stages(report, out);
  print_cost(report, out);
  print_ranks(report, out);
}
