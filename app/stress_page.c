/* What a stress writes: the page with its table and panels, and the points. */
#include <math.h>
#include <string.h>
#include "app/stress.h"
#include "app/svg.h"
#include "app/version.h"
#include "lib/io/atomic_file.h"

enum { ACROSS = 3 };

struct pages {
  int n;
  const struct kith_ladder *ladder;
  struct kith_series series[KITH_STRESS_METHODS];
  struct kith_dot dot[KITH_STRESS_METHODS][KITH_RUNGS];
};

static void rung_name(const struct kith_rung *rung, char text[64]) {
  if (rung->name != NULL)
    snprintf(text, 64, "%s", rung->name);
  else
    snprintf(text, 64, "%.6g", rung->x);
}

static void fill(struct pages *p, const struct kith_ladder *l) {
  char rung[64];
  for (int m = 0; m < kith_n_stress_methods; ++m) {
    for (int k = 0; k < l->n; ++k) {
      struct kith_dot *d = &p->dot[m][k];
      *d = (struct kith_dot){.x = l->sweep->rung[k].x, .y = l->shown[m][k], .failed = l->point[m][k].failed};
      if (d->y == 0) d->y = NAN; /* nothing to see on a logarithmic axis */
      rung_name(&l->sweep->rung[k], rung);
      if (d->failed)
        snprintf(d->title, sizeof d->title, "%s at %s failed: %.200s", kith_stress_methods[m].name, rung,
                 l->point[m][k].why);
      else
        snprintf(d->title, sizeof d->title, "%s at %s: %.4g, %s", kith_stress_methods[m].name, rung,
                 l->shown[m][k], l->pass[m][k] ? "passes" : "does not pass");
    }
    p->series[m] =
        (struct kith_series){.label = kith_stress_methods[m].name, .style = m, .n = l->n, .dot = p->dot[m]};
  }
}

static void put_panel(FILE *f, struct pages *p, const struct kith_ladder *l, double left, double top) {
  const char *names[KITH_RUNGS];
  char title[128], y_label[160];
  for (int k = 0; k < l->n; ++k) names[k] = l->sweep->rung[k].name;
  fill(p, l);
  snprintf(title, sizeof title, "%s (%s, %d-D)", l->sweep->name, l->sweep->scene, l->sweep->dimension);
  snprintf(y_label, sizeof y_label, "%s%s", kith_metrics[kith_metric_find(l->sweep->metric)].doc,
           l->sweep->gate == KITH_OF_FIRST ? ", over the first" : "");
  const struct kith_panel panel = {
      .title = title,
      .x_label = l->sweep->knob,
      .y_label = y_label,
      .n = kith_n_stress_methods,
      .series = p->series,
      .n_names = names[0] != NULL ? l->n : 0,
      .names = names,
      .level = l->sweep->bound,
      .level_label = l->sweep->gate == KITH_AT_LEAST ? "gate: above" : "gate: below"};
  kith_panel_write(f, &panel, left, top);
}

static void put_svg(FILE *f, struct pages *p) {
  const double width = ACROSS * KITH_PANEL_WIDTH;
  const int rows = (p->n + ACROSS - 1) / ACROSS;
  fill(p, &p->ladder[0]);
  const double legend = kith_legend_write(NULL, kith_n_stress_methods, p->series, 60, 0, width - 80);
  kith_svg_open(f, width, rows * KITH_PANEL_HEIGHT + legend, "metric against knob");
  kith_legend_write(f, kith_n_stress_methods, p->series, 60, 0, width - 80);
  for (int k = 0; k < p->n; ++k)
    put_panel(f, p, &p->ladder[k], k % ACROSS * KITH_PANEL_WIDTH,
              legend + (double)(k / ACROSS) * KITH_PANEL_HEIGHT);
  fputs("</svg>\n", f);
}

/* --- the page --- */

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>kith stress</title>\n<style>\n"
    "body{font:15px/1.5 'DejaVu Sans',Helvetica,Arial,sans-serif;color:#1f2328;background:#fff;margin:2em auto;max-width:1310px;"
    "padding:0 1em}\n"
    "h1{font-size:1.5em;margin:0}h2{font-size:1.2em;margin:2em 0 .4em;border-bottom:1px solid #d5d9de}\n"
    ".note{color:#4a5058;font-size:.9em}svg{max-width:100%;height:auto}\n"
    "table{border-collapse:collapse;margin:.6em 0;font-size:.9em}\n"
    "th,td{padding:.2em .8em;text-align:left;border-bottom:1px solid #e6e8eb}th{border-bottom:2px solid #8a9099}\n"
    "td.all{color:#0b6e3f}td.none{color:#b3261e;font-weight:bold}.wide{overflow-x:auto}\n"
    "</style></head><body>\n<h1>Where methods stop working</h1>\n";

static void put_table(FILE *f, const struct pages *p) {
  char text[160];
  fputs(
      "<h2>What still passes</h2>\n<div class=\"wide\"><table class=\"answers\"><tr><th>sweep</th><th>knob</th>",
      f);
  for (int m = 0; m < kith_n_stress_methods; ++m) fprintf(f, "<th>%s</th>", kith_stress_methods[m].name);
  fputs("<th>gate</th><th>why this gate</th></tr>\n", f);
  for (int k = 0; k < p->n; ++k) {
    const struct kith_ladder *l = &p->ladder[k];
    fprintf(f, "<tr><td>%s</td><td>%s</td>", l->sweep->name, l->sweep->knob);
    for (int m = 0; m < kith_n_stress_methods; ++m) {
      kith_ladder_answer(l, m, text);
      fprintf(f, "<td class=\"%s\">",
              strncmp(text, "all", 3) == 0    ? "all"
              : strncmp(text, "none", 4) == 0 ? "none"
                                              : "some");
      kith_xml_text(f, text);
      fputs("</td>", f);
    }
    kith_sweep_gate_text(l->sweep, text);
    fputs("<td>", f), kith_xml_text(f, text), fputs("</td><td>", f), kith_xml_text(f, l->sweep->reason),
        fputs("</td></tr>\n", f);
  }
  fputs("</table></div>\n", f);
}

static void put_failures(FILE *f, const struct pages *p) {
  char rung[64];
  fputs(
      "<h2>What does not pass, and why</h2>\n<div class=\"wide\"><table class=\"failures\"><tr><th>sweep</th><th>method</th>"
      "<th>knob</th><th>why</th></tr>\n",
      f);
  for (int k = 0; k < p->n; ++k)
    for (int m = 0; m < kith_n_stress_methods; ++m)
      for (int r = 0; r < p->ladder[k].n; ++r) {
        const struct kith_ladder *l = &p->ladder[k];
        if (l->pass[m][r]) continue;
        rung_name(&l->sweep->rung[r], rung);
        fprintf(f, "<tr><td>%s</td><td>%s</td><td>%s</td><td>", l->sweep->name, kith_stress_methods[m].name,
                rung);
        if (l->point[m][r].failed)
          kith_xml_text(f, l->point[m][r].why);
        else
          fprintf(f, "%s %.4g", l->sweep->metric, l->shown[m][r]);
        fputs("</td></tr>\n", f);
      }
  fputs("</table></div>\n", f);
}

static void put_page(FILE *f, struct pages *p) {
  fputs(head, f);
  fprintf(
      f,
      "<p class=\"note\">kith %s. One knob of one scene is turned from mild to hard, for every method. The table has the values that "
      "pass: &ldquo;to 0.6&rdquo; is the ladder up to there. Crosses at the upper edge: the run failed.</p>\n",
      kith_version());
  put_table(f, p);
  fputs("<h2>Metric against knob</h2>\n", f);
  put_svg(f, p);
  put_failures(f, p);
  fputs("</body></html>\n", f);
}

static void put_csv(FILE *f, struct pages *p) {
  char rung[64];
  fputs("sweep,knob,method,value,metric,judged,gate,bound,verdict,why\n", f);
  for (int k = 0; k < p->n; ++k)
    for (int m = 0; m < kith_n_stress_methods; ++m)
      for (int r = 0; r < p->ladder[k].n; ++r) {
        static const char *const gates[] = {"at most", "at least", "of first at most"};
        const struct kith_ladder *l = &p->ladder[k];
        rung_name(&l->sweep->rung[r], rung);
        fprintf(f, "%s,\"%s\",%s,\"%s\",%s,%.9g,%s,%.9g,%s,", l->sweep->name, l->sweep->knob,
                kith_stress_methods[m].name, rung, l->sweep->metric, l->shown[m][r], gates[l->sweep->gate],
                l->sweep->bound,
                l->point[m][r].failed ? "failed"
                : l->pass[m][r]       ? "passes"
                                      : "beyond");
        kith_csv_quoted(f, l->point[m][r].why);
        fputc('\n', f);
      }
}

static kith_status write_file(struct pages *p, const char *directory, const char *name,
                              void (*put)(FILE *, struct pages *)) {
  char path[KITH_PATH + 32];
  struct kith_atomic_file *file;
  snprintf(path, sizeof path, "%s/%s", directory, name);
  KITH_TRY(kith_atomic_file_open(&file, path));
  put(file->stream, p);
  return kith_atomic_file_commit(&file, false);
}

kith_status kith_stress_write(int n, const struct kith_ladder *ladders, const char *directory) {
  struct pages *p = NULL;
  KITH_TRY(kith_resize(&p, 0, 1, sizeof *p));
  p->n = n, p->ladder = ladders;
  kith_status status = write_file(p, directory, "stress.csv", put_csv);
  if (status == KITH_OK) status = write_file(p, directory, "stress.svg", put_svg);
  if (status == KITH_OK) status = write_file(p, directory, "stress.html", put_page);
  kith_free(&p);
  return status;
}
