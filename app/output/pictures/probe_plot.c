/* probe_plot.c - time series, profiles and maps of what probes saw. */
#include "app/output/pictures/probe_plot.h"

#include <math.h>
#include "app/output/pictures/field.h"
#include "app/output/pictures/figure.h"
#include "lib/core/vec.h"
#include "lib/io/series.h"

enum { TIMES = 5, COLUMNS = 4 };

struct picture {
  const struct kith_scene *scene;
  const struct kith_probe *probe;
  const void *solution; /* exact; NULL: there is none */
  const char *directory;
  struct kith_picture_axes axes;
  char file[KITH_PATH + 16], name[48];
  int edge[3], n_edges; /* those with more than one point */
  double *time;         /* [samples], owned */
  size_t samples;
  double *column[COLUMNS]; /* owned; of a sample, or of all samples of a point */
  float *pixels;           /* owned; of one map at a time */
  struct kith_range place, range[KITH_PICTURE_PANELS];
};

/* ---- what was sampled ---- */

/* Loads the columns of a sample; sample -1: of all samples. */
static kith_status load(struct picture *f, int64_t sample) {
  static const char *const name[COLUMNS] = {"density", "pressure", "energy", "velocity"};
  size_t n, each;
  for (int c = 0; c < COLUMNS; ++c)
    KITH_TRY(kith_series_read(f->file, f->probe->name, name[c], sample, &f->column[c], &n, &each));
  return KITH_OK;
}

/* The place of a row of what is loaded. Rows are points; of a probe of one point they are samples. */
static void position_of(const struct picture *f, size_t row, double x[NDIM]) {
  kith_probe_point(f->probe, f->n_edges > 0 ? (int)row : 0, x);
}

static struct kith_exact_state exact_at(const struct picture *f, const double *x, double time) {
  struct kith_exact_state s;
  f->axes.exact->state(f->solution, x, time, &s);
  return s;
}

static double value_at(const struct picture *f, int k, size_t row, double time) {
  const enum kith_picture_field field = f->probe->picture.panel[k].field;
  struct kith_exact_state s = {f->column[0][row], {0}, f->column[1][row], f->column[2][row]};
  double x[NDIM];
  for (int a = 0; a < NDIM; ++a) s.velocity[a] = f->column[3][3 * row + (size_t)a];
  position_of(f, row, x);
  const double value = kith_picture_value(&f->axes, field, x, time, &s);
  if (!f->probe->picture.panel[k].error) return value;
  s = exact_at(f, x, time);
  return value - kith_picture_value(&f->axes, field, x, time, &s);
}

/* ---- curves ---- */

/* The axis in whose direction an edge goes. -1 if there is none: then places are distances from its
 * beginning. */
static int axis_of(const struct picture *f, int edge) {
  int axis = -1;
  for (int a = 0; a < NDIM; ++a) {
    const double d = f->probe->edge[edge][a];
    if (d < 0 || (d > 0 && axis >= 0)) return -1;
    if (d > 0) axis = a;
  }
  return axis;
}

static double step_of(const struct picture *f, int edge) {
  return kith_norm(f->probe->edge[edge]) / (f->probe->points[edge] - 1);
}

static double begin_of(const struct picture *f, int edge) {
  const int axis = axis_of(f, edge);
  return axis < 0 ? 0 : f->probe->at[axis];
}

static void label_of(const struct picture *f, int edge, char label[48]) {
  static const char *const name[] = {"along", "across", "up"};
  const int axis = axis_of(f, edge);
  if (axis < 0)
    snprintf(label, 48, "distance %s (code units)", name[edge]);
  else
    snprintf(label, 48, "%c (code units)", "xyz"[axis]);
}

static void put_row(struct picture *f, FILE *out, double place, size_t row, double time) {
  const struct kith_picture_fields *fields = &f->probe->picture;
  double x[NDIM];
  kith_range_include(&f->place, place);
  fprintf(out, "%.9g", place);
  for (int k = 0; k < fields->n; ++k) {
    const double value = value_at(f, k, row, time);
    kith_range_include(&f->range[k], value);
    fprintf(out, " %.9g", value);
  }
  position_of(f, row, x);
  for (int k = 0; k < fields->n && f->axes.exact != NULL; ++k) {
    const struct kith_exact_state s = exact_at(f, x, time);
    const double value =
        fields->panel[k].error ? 0 : kith_picture_value(&f->axes, fields->panel[k].field, x, time, &s);
    kith_range_include(&f->range[k], value);
    fprintf(out, " %.9g", value);
  }
  fputc('\n', out);
}

static int times_of(const struct picture *f) {
  return f->n_edges == 0 ? 1 : (int)KITH_MIN(f->samples, (size_t)TIMES);
}

static size_t sample_of(const struct picture *f, int k) {
  const int times = times_of(f);
  return times > 1 ? (f->samples - 1) * (size_t)k / (size_t)(times - 1) : f->samples - 1;
}

static kith_status put_rows(struct picture *f, FILE *out) {
  const int edge = f->edge[0];
  if (f->n_edges == 0) KITH_TRY(load(f, -1));
  for (size_t k = 0; k < f->samples && f->n_edges == 0; ++k) put_row(f, out, f->time[k], k, f->time[k]);
  for (int k = 0; k < times_of(f) && f->n_edges > 0; ++k) {
    const size_t sample = sample_of(f, k);
    KITH_TRY(load(f, (int64_t)sample));
    fprintf(out, "%s# t = %.9g\n", k > 0 ? "\n\n" : "", f->time[sample]);
    for (int i = 0; i < f->probe->points[edge]; ++i)
      put_row(f, out, begin_of(f, edge) + i * step_of(f, edge), (size_t)i, f->time[sample]);
  }
  return KITH_OK;
}

static kith_status write_curves(struct picture *f) {
  char path[KITH_PATH + 80];
  struct kith_atomic_file *file;
  snprintf(path, sizeof path, "%s/%s.dat", f->directory, f->name);
  KITH_TRY(kith_atomic_file_open(&file, path));
  const kith_status status = put_rows(f, file->stream);
  if (status == KITH_OK) return kith_atomic_file_commit(&file, false);
  kith_atomic_file_abandon(&file);
  return status;
}

/* Colors of the times, from light to dark. */
static const char *const shade[TIMES] = {"#c6dbef", "#9ecae1", "#6baed6", "#3182bd", "#08519c"};
#define EXACT "with lines dt 2 lw 1.5 lc rgb '#d55e00'"

static void draw_curves(struct kith_figure *g, const struct picture *f, int panel, const char *title) {
  const struct kith_picture_fields *fields = &f->probe->picture;
  const struct kith_range y =
      isfinite(f->range[panel].lower) ? kith_range_with_room(f->range[panel]) : (struct kith_range){0, 1};
  const int times = times_of(f);
  char label[48] = "time (code units)";
  if (f->n_edges > 0) label_of(f, f->edge[0], label);
  kith_figure_panel(g, title, label, title);
  fprintf(g->file->stream, "set xtics %g\nset xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\nplot ",
          kith_range_tics(f->place), f->place.lower, f->place.upper, y.lower, y.upper);
  for (int k = 0; k < times; ++k)
    fprintf(g->file->stream, "%s'%s.dat' index %d using 1:%d with linespoints pt 7 ps 0.3 lw 1.5 lc rgb '%s'",
            k > 0 ? ", \\\n  " : "", f->name, k, 2 + panel, shade[TIMES - times + k]);
  if (f->axes.exact != NULL)
    fprintf(g->file->stream, ", \\\n  '%s.dat' index %d using 1:%d " EXACT, f->name, times - 1,
            2 + fields->n + panel);
  fputc('\n', g->file->stream);
}

static void draw_legend(struct kith_figure *g, const struct picture *f) {
  const int times = times_of(f);
  FILE *out = g->file->stream;
  kith_figure_legend(g);
  for (int k = 0; k < times; ++k) {
    fprintf(out, "%sNaN with lines lw 2 lc rgb '%s' title ", k > 0 ? ", " : "", shade[TIMES - times + k]);
    if (f->n_edges == 0)
      fputs("'run'", out);
    else
      fprintf(out, "'t = %.4g'", f->time[sample_of(f, k)]);
  }
  fputs(f->axes.exact != NULL ? ", NaN " EXACT " title 'exact'\n" : "\n", out);
}

/* ---- maps ---- */

static void draw_map(struct kith_figure *g, const struct picture *f, int panel, const char *title) {
  const int *n = f->probe->points, *edge = f->edge;
  const int stride[3] = {n[1] * n[2], n[2], 1}, middle = f->n_edges > 2 ? n[2] / 2 : 0;
  const double time = f->time[f->samples - 1];
  char file[80], labels[2][48];
  for (int j = 0; j < n[edge[1]]; ++j)
    for (int i = 0; i < n[edge[0]]; ++i) {
      const int row = i * stride[edge[0]] + j * stride[edge[1]] + middle;
      f->pixels[(size_t)j * (size_t)n[edge[0]] + (size_t)i] = (float)value_at(f, panel, (size_t)row, time);
    }
  snprintf(file, sizeof file, "%s_%d.bin", f->name, panel + 1);
  const enum kith_picture_field field = f->probe->picture.panel[panel].field;
  struct kith_figure_map map = {
      .file = file,
      .title = title,
      .labels = {labels[0], labels[1]},
      .value = f->pixels,
      .has_sign = f->probe->picture.panel[panel].error || field >= KITH_PICTURE_VELOCITY_X,
      .colors = {NAN, NAN}};
  for (int k = 0; k < 2; ++k) {
    label_of(f, edge[k], labels[k]);
    map.pixels[k] = n[edge[k]];
    map.size[k] = step_of(f, edge[k]);
    map.lower[k] = begin_of(f, edge[k]) - 0.5 * map.size[k];
  }
  kith_figure_map(g, &map);
}

/* ---- a probe ---- */

static void draw_panels(struct kith_figure *g, const struct picture *f) {
  const struct kith_picture_fields *fields = &f->probe->picture;
  for (int k = 0; k < fields->n; ++k) {
    char title[96];
    snprintf(title, sizeof title, "%s%s%s (code units)", fields->panel[k].error ? "error of the " : "",
             kith_picture_label(&f->axes, fields->panel[k].field),
             f->n_edges > 2 ? " in the middle of up" : "");
    if (f->n_edges > 1)
      draw_map(g, f, k, title);
    else
      draw_curves(g, f, k, title);
  }
  if (f->n_edges < 2) draw_legend(g, f);
}

/* The layout of panels; that of a map is as high as its plane. */
static struct kith_figure_layout layout_of(const struct picture *f) {
  const int n = f->probe->picture.n, columns = n > 4 ? 3 : n > 1 ? 2 : 1;
  struct kith_figure_layout l = {(n + columns - 1) / columns, columns, 500, 440, 34};
  if (f->n_edges < 2) return l;
  const double side[2] = {kith_norm(f->probe->edge[f->edge[0]]), kith_norm(f->probe->edge[f->edge[1]])};
  l.height = (int)KITH_MAX(220, KITH_MIN(150 + 350 * side[1] / side[0], 1000));
  l.legend = 0;
  return l;
}

static kith_status draw(struct picture *f) {
  const struct kith_figure_layout layout = layout_of(f);
  struct kith_figure figure;
  char title[256];
  if (f->n_edges < 2) KITH_TRY(write_curves(f));
  if (f->n_edges > 1) {
    const int *n = f->probe->points;
    KITH_TRY(load(f, (int64_t)f->samples - 1));
    KITH_TRY(kith_resize(&f->pixels, 0, (size_t)n[f->edge[0]] * (size_t)n[f->edge[1]], sizeof *f->pixels));
  }
  if (!(f->place.lower < f->place.upper)) f->place.lower -= 0.5, f->place.upper += 0.5;
  snprintf(title, sizeof title, "%.150s, probe %s    %d-D,  t = %.4g", f->scene->name, f->probe->name, NDIM,
           f->time[f->samples - 1]);
  KITH_TRY(kith_figure_open(&figure, f->directory, f->name, title, &layout));
  draw_panels(&figure, f);
  return kith_figure_close(&figure);
}

static kith_status draw_probe(const struct kith_scene *scene, const struct kith_probe *probe,
                              const void *solution, const char *directory) {
  struct picture f = {
      .scene = scene, .probe = probe, .solution = solution, .directory = directory, .place = KITH_NO_RANGE};
  size_t each;
  for (int k = 0; k < KITH_PICTURE_PANELS; ++k) f.range[k] = KITH_NO_RANGE;
  for (int k = 0; k < 3; ++k)
    if (probe->points[k] > 1) f.edge[f.n_edges++] = k;
  if (solution != NULL)
    f.axes.exact = scene->exact.ops, f.axes.about = kith_exact_about(f.axes.exact, solution);
  f.axes.speed = f.axes.about == NULL && (solution == NULL || f.n_edges > 1);
  snprintf(f.name, sizeof f.name, "probe_%s", probe->name);
  if (snprintf(f.file, sizeof f.file, "%s/probes.h5", directory) >= KITH_PATH)
    KITH_FAIL(BAD_FILE, "%s: the path is too long", directory);
  kith_status status = kith_series_read(f.file, probe->name, "time", -1, &f.time, &f.samples, &each);
  if (status == KITH_OK && f.samples > 0) status = draw(&f);
  KITH_FREE(&f.time, &f.pixels);
  for (int c = 0; c < COLUMNS; ++c) kith_free(&f.column[c]);
  return status;
}

kith_status kith_probes_draw(const struct kith_scene *scene, const void *solution, const char *directory) {
  for (int k = 0; k < scene->n_probes; ++k)
    if (scene->probe[k].picture.n > 0) KITH_TRY(draw_probe(scene, &scene->probe[k], solution, directory));
  return KITH_OK;
}
