/* plot.c - what a picture shows, its data files, and the script of its panels. */
#include "app/output/pictures/plot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/output/pictures/field.h"
#include "app/output/pictures/figure.h"
#include "app/output/pictures/map.h"
#include "lib/comm/ranks.h"
#include "lib/core/vec.h"

enum { MOST_NODES = 20000, CURVE = 2000, BINS = 60 };

/* A panel: which value of the nodes it shows, as a curve or a map. */
struct panel {
  enum kith_picture_field field;
  bool error, map;
  struct kith_range nodes, exact; /* of a curve: range of the values that are shown */
};

struct picture {
  const struct kith_plot *plot;
  char prefix[48];                    /* of the data files */
  struct kith_exact_gas around;       /* a center that the scene wants */
  const struct kith_exact_gas *about; /* NULL: curves over x */
  struct kith_picture_axes axes[2];   /* of curves, of maps */
  double middle[NDIM];
  struct kith_range place;
  bool tube; /* the nodes fill a box that is long in x alone */
  int n, columns;
  struct panel panel[KITH_PICTURE_PANELS];
  int n_curves, curve[KITH_PICTURE_PANELS]; /* the panels that are curves */
  int64_t total, before;                    /* nodes of all ranks, and of those before this one */
  char *rows;    /* [n_rows][1 + n_curves] place and values of nodes that are shown; owned */
  size_t n_rows; /* of all ranks */
  double mean[BINS][2 + KITH_PICTURE_PANELS]; /* sums of V, V times place, V times value of each curve */
  struct kith_map plane;                      /* of maps */
  float *pixels[KITH_PICTURE_PANELS];         /* owned */
};

/* Extends a range to those of all ranks. */
static void join(const struct picture *f, struct kith_range *r) {
  kith_ranks_min(f->plot->nodes.ranks, &r->lower, 1);
  kith_ranks_max(f->plot->nodes.ranks, &r->upper, 1);
}

/* ---- values ---- */

static double field_of(const struct picture *f, const struct panel *panel, const double *x,
                       const struct kith_exact_state *s) {
  return kith_picture_value(&f->axes[panel->map], panel->field, x, f->plot->time, s);
}

static double value_of(const struct picture *f, const struct panel *panel, kith_index i) {
  const struct kith_plot *p = f->plot;
  const double *x = p->nodes.position + (size_t)i * NDIM;
  struct kith_exact_state node = {p->nodes.density[i], {0}, p->nodes.pressure[i], p->nodes.energy[i]}, exact;
  for (int a = 0; a < NDIM; ++a) node.velocity[a] = p->nodes.velocity[(size_t)i * NDIM + a];
  if (!panel->error) return field_of(f, panel, x, &node);
  p->exact->state(p->solution, x, p->time, &exact);
  return field_of(f, panel, x, &node) - field_of(f, panel, x, &exact);
}

static double place_of(const struct picture *f, kith_index i) {
  return kith_exact_place(f->plot->exact, f->about, f->plot->nodes.position + (size_t)i * NDIM,
                          f->plot->time);
}

/* Picks a node from part k of `stretches` equal parts of n nodes. Its place in the part follows the golden
 * section, so that the picked nodes make no pattern with a lattice. */
static kith_index picked(kith_index n, kith_index stretches, kith_index k) {
  const int64_t first = (int64_t)n * k / stretches, next = (int64_t)n * (k + 1) / stretches;
  return (kith_index)(first + (int64_t)((double)(next - first) * fmod(k * 0.6180339887498949, 1)));
}

/* ---- what is shown ---- */

static void add_panel(struct picture *f, enum kith_picture_field field, bool error, bool map) {
  if (f->n == KITH_PICTURE_PANELS || (error && f->plot->exact == NULL)) return;
  if (!map) f->curve[f->n_curves++] = f->n;
  f->panel[f->n++] = (struct panel){field, error, map, KITH_NO_RANGE, KITH_NO_RANGE};
}

/* Does the exact solution vary across x, so that no curve over x shows it? This is tried at the places of 200
 * nodes of each rank. */
static bool varies_across(const struct picture *f) {
  const struct kith_plot *p = f->plot;
  const kith_index n = p->nodes.n, asked = KITH_MIN(n, (kith_index)200);
  bool varies = false;
  for (kith_index k = 0; k < asked && p->exact != NULL && f->about == NULL; ++k) {
    const double *x = p->nodes.position + (size_t)picked(n, asked, k) * NDIM;
    struct kith_exact_state here, beside;
    p->exact->state(p->solution, x, p->time, &here);
    p->exact->state(p->solution, (const double[3]){x[0]}, p->time, &beside);
    varies = varies || fabs(here.density - beside.density) > 1e-9 * fabs(here.density) ||
             fabs(here.pressure - beside.pressure) > 1e-9 * fabs(here.pressure);
  }
  return kith_ranks_any(p->nodes.ranks, varies);
}

/* Chooses the panels: those that the scene names; else, if the exact solution varies in the plane, maps of
 * density and pressure with their errors; else four curves, or, without an exact solution, a map of the
 * density unless the nodes fill a tube. About the center of an exact solution two maps stand beside the
 * curves: of what it is about, and of its error. */
static void choose_panels(struct picture *f) {
  const struct kith_picture *wanted = f->plot->picture;
  const struct kith_exact_ops *exact = f->plot->exact;
  const bool chosen = wanted->kind != KITH_PICTURE_AUTO,
             plane = !chosen && wanted->fields.n == 0 && varies_across(f),
             maps = NDIM > 1 && (chosen ? wanted->kind >= KITH_PICTURE_MAP : exact == NULL && !f->tube),
             both = NDIM > 1 && !chosen && f->about != NULL && wanted->fields.n == 0;
  for (int k = 0; k < wanted->fields.n; ++k)
    add_panel(f, wanted->fields.panel[k].field, wanted->fields.panel[k].error, maps);
  for (int k = 0; k < 4 && plane; ++k)
    add_panel(f, k < 2 ? KITH_PICTURE_DENSITY : KITH_PICTURE_PRESSURE, k % 2 == 1, true);
  for (int k = 0; k <= KITH_PICTURE_ENERGY && wanted->fields.n == 0 && !plane && !(maps && k > 0); ++k) {
    add_panel(f, (enum kith_picture_field)k, false, maps);
    if (both && k % 2 == 1)
      add_panel(f, exact->vortex ? KITH_PICTURE_VELOCITY : KITH_PICTURE_DENSITY, k > 1, true);
  }
  f->columns = both || f->n > 4 ? 3 : f->n > 1 ? 2 : 1;
}

static void choose_places(struct picture *f) {
  const struct kith_plot *p = f->plot;
  struct kith_range box[NDIM];
  double wide = 0;
  f->place = KITH_NO_RANGE;
  for (int a = 0; a < NDIM; ++a) {
    box[a] = KITH_NO_RANGE;
    for (kith_index i = 0; i < p->nodes.n; ++i)
      kith_range_include(&box[a], p->nodes.position[(size_t)i * NDIM + a]);
    join(f, &box[a]);
    f->middle[a] = 0.5 * (box[a].lower + box[a].upper);
    if (fabs(f->middle[a]) < 1e-9 * (box[a].upper - box[a].lower)) f->middle[a] = 0; /* a title has it */
    wide = KITH_MAX(wide, a > 0 ? box[a].upper - box[a].lower : 0);
  }
  f->tube = box[0].upper - box[0].lower > 5 * wide;
  memcpy(f->around.center, f->middle, sizeof f->middle);
  if (p->exact != NULL) f->about = kith_exact_about(p->exact, p->solution);
  if (p->picture->kind == KITH_PICTURE_RADIAL && f->about == NULL) f->about = &f->around;
  if (p->picture->kind == KITH_PICTURE_PROFILE) f->about = NULL;
  for (int map = 0; map < 2; ++map)
    f->axes[map] = (struct kith_picture_axes){p->exact, f->about, map == 1 && f->about == NULL};
  for (kith_index i = 0; i < p->nodes.n; ++i) kith_range_include(&f->place, place_of(f, i));
  join(f, &f->place);
  if (!(f->place.lower < f->place.upper)) { /* no node, or all at one place */
    const double middle = isfinite(f->place.lower) ? f->place.lower : 0;
    f->place = (struct kith_range){middle - 0.5, middle + 0.5};
  }
  if (f->about != NULL) {
    const double shock =
        p->exact != NULL && p->exact->shock != NULL ? p->exact->shock(p->solution, p->time) : 0;
    f->place.lower = 0;
    if (shock > 0) f->place.upper = KITH_MIN(f->place.upper, 1.6 * shock);
  }
}

/* ---- what the nodes of all ranks give ---- */

static kith_status count_nodes(struct picture *f) {
  const struct kith_profile_view *nodes = &f->plot->nodes;
  const int64_t mine = nodes->n;
  char *counts = NULL;
  KITH_TRY(kith_ranks_gather(nodes->ranks, &mine, sizeof mine, &counts, NULL));
  for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) {
    if (r < kith_ranks_rank(nodes->ranks)) f->before += ((const int64_t *)counts)[r];
    f->total += ((const int64_t *)counts)[r];
  }
  kith_free(&counts);
  return KITH_OK;
}

/* Collects at most MOST_NODES nodes on rank 0, from each rank in proportion to its nodes. */
static kith_status collect_nodes(struct picture *f) {
  const struct kith_profile_view *nodes = &f->plot->nodes;
  const int64_t most = KITH_MIN(f->total, (int64_t)MOST_NODES), all = KITH_MAX(f->total, 1);
  const kith_index shown = (kith_index)((f->before + nodes->n) * most / all - f->before * most / all);
  const size_t columns = (size_t)f->n_curves + 1, bytes = (size_t)shown * columns * sizeof(double);
  double *mine = NULL;
  const kith_status status = kith_resize(&mine, 0, (size_t)shown * columns, sizeof *mine);
  for (kith_index k = 0; k < shown && status == KITH_OK; ++k) {
    const kith_index i = picked(nodes->n, shown, k);
    double *row = mine + (size_t)k * columns;
    row[0] = place_of(f, i);
    for (int j = 0; j < f->n_curves; ++j) row[1 + j] = value_of(f, &f->panel[f->curve[j]], i);
  }
  kith_status agreed = kith_ranks_allreduce_status(nodes->ranks, status);
  if (agreed == KITH_OK) agreed = kith_ranks_gather(nodes->ranks, mine, bytes, &f->rows, NULL);
  f->n_rows = (size_t)most;
  kith_free(&mine);
  return agreed;
}

static void collect_means(struct picture *f) {
  const struct kith_profile_view *nodes = &f->plot->nodes;
  for (kith_index i = 0; i < nodes->n && NDIM > 1; ++i) {
    const double place = place_of(f, i), volume = nodes->mass[i] / nodes->density[i],
                 part = (place - f->place.lower) / (f->place.upper - f->place.lower);
    if (!(part >= 0 && part <= 1 && isfinite(volume))) continue;
    double *bin = f->mean[KITH_MIN((int)(part * BINS), BINS - 1)];
    bin[0] += volume, bin[1] += volume * place;
    for (int j = 0; j < f->n_curves; ++j) bin[2 + j] += volume * value_of(f, &f->panel[f->curve[j]], i);
  }
  kith_ranks_sum(nodes->ranks, f->mean[0], BINS * (2 + KITH_PICTURE_PANELS));
}

/* Chooses the plane of maps: that of the scene, else across z through the center of the exact solution, which
 * may be in a corner of the domain, or through the middle. */
static void choose_plane(struct picture *f) {
  const struct kith_picture *wanted = f->plot->picture;
  const bool column = f->plot->exact != NULL && f->plot->exact->vortex; /* has no center along z */
  int normal = 2;
  double at = NDIM < 3 ? NAN : f->about != NULL && !column ? f->about->center[NDIM - 1] : f->middle[NDIM - 1];
  for (int a = 0; a < NDIM; ++a)
    if (isfinite(wanted->plane[a])) normal = a, at = wanted->plane[a];
  f->plane = kith_map_of(&f->plot->nodes, normal, wanted->kind == KITH_PICTURE_MAP ? NAN : at);
}

/* Errors are shown where they count: in the window of the exact solution. */
static bool is_shown(const struct picture *f, const struct panel *panel, kith_index i) {
  const struct kith_plot *p = f->plot;
  return !panel->error || kith_window_has(p->window, p->exact, kith_exact_about(p->exact, p->solution),
                                          p->nodes.position + (size_t)i * NDIM, p->time);
}

static kith_status collect_pixels(struct picture *f, int k) {
  const struct kith_profile_view *nodes = &f->plot->nodes;
  double *of = NULL;
  kith_status status = kith_resize(&of, 0, (size_t)nodes->n + 1, sizeof *of);
  if (status == KITH_OK)
    status = kith_resize(&f->pixels[k], 0, (size_t)f->plane.pixels[0] * (size_t)f->plane.pixels[1],
                         sizeof *f->pixels[k]);
  for (kith_index i = 0; i < nodes->n && status == KITH_OK; ++i)
    of[i] = is_shown(f, &f->panel[k], i) ? value_of(f, &f->panel[k], i) : NAN;
  status = kith_ranks_allreduce_status(nodes->ranks, status);
  if (status == KITH_OK) status = kith_map_draw(&f->plane, nodes, of, f->pixels[k]);
  kith_free(&of);
  return status;
}

static kith_status collect(struct picture *f) {
  KITH_TRY(count_nodes(f));
  choose_places(f);
  choose_panels(f);
  KITH_TRY(collect_nodes(f));
  collect_means(f);
  if (NDIM > 1) choose_plane(f);
  for (int k = 0; k < f->n; ++k)
    if (f->panel[k].map) KITH_TRY(collect_pixels(f, k));
  return KITH_OK;
}

/* ---- data of curves ---- */

static kith_status open_data(struct kith_atomic_file **out, const struct picture *f, const char *directory,
                             const char *name) {
  static const char *const word[] = {
#define X(name, word, label) #word,
      KITH_PICTURE_FIELDS(X)
#undef X
  };
  char path[KITH_PATH + 80];
  snprintf(path, sizeof path, "%.*s/%s%s", KITH_PATH, directory, f->prefix, name);
  KITH_TRY(kith_atomic_file_open(out, path));
  fputs(f->about != NULL ? "# r" : "# x", (*out)->stream);
  for (int j = 0; j < f->n_curves; ++j) {
    const struct panel *panel = &f->panel[f->curve[j]];
    fprintf((*out)->stream, " %s%s", word[panel->field], panel->error ? "-error" : "");
  }
  fputc('\n', (*out)->stream);
  return KITH_OK;
}

static kith_status write_nodes(struct picture *f, const char *directory) {
  const size_t columns = (size_t)f->n_curves + 1;
  struct kith_atomic_file *file;
  KITH_TRY(open_data(&file, f, directory, "profile.dat"));
  for (size_t k = 0; k < f->n_rows; ++k) {
    const double *row = (const double *)f->rows + k * columns;
    fprintf(file->stream, "%.8g", row[0]);
    for (int j = 0; j < f->n_curves; ++j) {
      fprintf(file->stream, " %.8g", row[1 + j]);
      if (row[0] <= f->place.upper) kith_range_include(&f->panel[f->curve[j]].nodes, row[1 + j]);
    }
    fputc('\n', file->stream);
  }
  return kith_atomic_file_commit(&file, false);
}

static kith_status write_means(const struct picture *f, const char *directory) {
  struct kith_atomic_file *file;
  KITH_TRY(open_data(&file, f, directory, "mean.dat"));
  for (int b = 0; b < BINS; ++b) {
    const double *bin = f->mean[b];
    if (!(bin[0] > 0)) continue;
    fprintf(file->stream, "%.8g", bin[1] / bin[0]);
    for (int j = 0; j < f->n_curves; ++j) fprintf(file->stream, " %.8g", bin[2 + j] / bin[0]);
    fputc('\n', file->stream);
  }
  return kith_atomic_file_commit(&file, false);
}

/* Writes the exact curve. About a center it is taken along a diagonal, on which the images of a periodic box
 * are farthest away. */
static kith_status write_curve(struct picture *f, const char *directory) {
  const struct kith_plot *p = f->plot;
  const struct kith_exact_gas *about = f->about;
  const bool diagonal = NDIM > 1 && about != NULL;
  struct kith_atomic_file *file;
  KITH_TRY(open_data(&file, f, directory, "exact.dat"));
  for (int k = 0; k <= CURVE && p->exact != NULL; ++k) {
    const double place = f->place.lower + (f->place.upper - f->place.lower) * k / CURVE;
    struct kith_exact_state state;
    double x[NDIM] = {0};
    for (int a = 0; a < NDIM && about != NULL; ++a)
      x[a] = about->center[a] + about->uniform_velocity[a] * p->time;
    x[0] += diagonal ? M_SQRT1_2 * place : place;
    if (diagonal) x[NDIM > 1] += M_SQRT1_2 * place;
    p->exact->state(p->solution, x, p->time, &state);
    fprintf(file->stream, "%.8g", place);
    for (int j = 0; j < f->n_curves; ++j) {
      struct panel *panel = &f->panel[f->curve[j]];
      const double value = panel->error ? 0 : field_of(f, panel, x, &state);
      fprintf(file->stream, " %.8g", value);
      kith_range_include(&panel->exact, value);
    }
    fputc('\n', file->stream);
  }
  return kith_atomic_file_commit(&file, false);
}

/* ---- panels ---- */

static void put_name(char name[96], const struct picture *f, const struct panel *panel) {
  snprintf(name, 96, "%s%s", panel->error ? "error of the " : "",
           kith_picture_label(&f->axes[panel->map], panel->field));
}

static void put_title(char title[96], const struct picture *f, const struct panel *panel) {
  const struct kith_norms *l = f->plot->norms;
  put_name(title, f, panel);
  if (l == NULL || panel->field > KITH_PICTURE_ENERGY || panel->map) return;
  const struct kith_norm *const norm[] = {&l->density, &l->velocity, &l->pressure, &l->energy};
  kith_text_add(title, 96, ", L1 error %.3g", norm[panel->field]->l1);
}

/* The range of a panel: that of nodes and of the exact curve, with some room. The curve may have no bound, as
 * the energy in the center of a blast. So the range ends at three times the span of the nodes beyond them, or
 * at a decade beyond them on a logarithmic axis. */
static struct kith_range widest(const struct panel *panel, bool logarithmic) {
  struct kith_range n = panel->nodes, all = n;
  if (!(n.lower <= n.upper)) return (struct kith_range){0, 1};
  kith_range_include(&all, panel->exact.lower), kith_range_include(&all, panel->exact.upper);
  if (logarithmic)
    return (struct kith_range){KITH_MAX(all.lower, 0.1 * n.lower) / 1.5,
                               KITH_MIN(all.upper, 10 * n.upper) * 1.5};
  const double size = KITH_MAX(fabs(n.lower), fabs(n.upper)), span = n.upper - n.lower;
  const double most = span > 1e-10 * size ? 3 * span : KITH_MAX(size, 1);
  n = (struct kith_range){KITH_MAX(all.lower, n.lower - most), KITH_MIN(all.upper, n.upper + most)};
  return kith_range_with_room(n);
}

/* Colors and styles of gnuplot. */
#define NODES (NDIM > 1 ? "#8fb8de" : "#0072b2")
#define EXACT "lines lw 2 lc rgb '#d55e00'"
#define MEANS "points pt 6 ps 0.7 lw 1.5 lc rgb 'black'"

static void draw_curve(struct kith_figure *g, const struct picture *f, const struct panel *panel,
                       int column) {
  const struct kith_plot *p = f->plot;
  const bool logarithmic = panel->field == KITH_PICTURE_ENERGY && panel->nodes.lower > 0 &&
                           panel->nodes.upper > 1e4 * panel->nodes.lower,
             vortex = p->exact != NULL && p->exact->vortex;
  const struct kith_range y = widest(panel, logarithmic);
  const char *size = f->total > 4000 ? "0.2" : NDIM > 1 ? "0.35" : "0.5";
  char title[96], label[96];
  put_title(title, f, panel);
  put_name(label, f, panel);
  kith_text_add(label, sizeof label, " (code units)");
  kith_figure_panel(g, title,
                    f->about == NULL ? "x (code units)"
                    : vortex         ? "distance from the axis (code units)"
                                     : "distance from the center (code units)",
                    label);
  fprintf(g->file->stream,
          "%sset xtics %g\nset ytics autofreq\n"
          "set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\n"
          "plot NaN, '%sprofile.dat' using 1:%d with points pt 7 ps %s lc rgb '%s'",
          logarithmic ? "set logscale y\n" : "", kith_range_tics(f->place), f->place.lower, f->place.upper,
          y.lower, y.upper, f->prefix, column, size, NODES);
  if (p->exact != NULL)
    fprintf(g->file->stream, ", \\\n  '%sexact.dat' using 1:%d with " EXACT, f->prefix, column);
  if (NDIM > 1) fprintf(g->file->stream, ", \\\n  '%smean.dat' using 1:%d with " MEANS, f->prefix, column);
  fputc('\n', g->file->stream);
}

static void draw_map(struct kith_figure *g, const struct picture *f, int k) {
  const struct panel *panel = &f->panel[k];
  const struct kith_picture *wanted = f->plot->picture;
  const struct kith_map *map = &f->plane;
  const bool chosen = k == 0 && isfinite(wanted->range[0]);
  char file[80], title[96], labels[2][32];
  snprintf(file, sizeof file, "%smap_%d.bin", f->prefix, k + 1);
  put_title(title, f, panel);
  if (NDIM == 3 && map->normal >= 0)
    kith_text_add(title, sizeof title, " at %c = %.3g", "xyz"[map->normal], map -> at);
  if (NDIM == 3 && map->normal < 0)
    kith_text_add(title, sizeof title, ", mean along %c", "xyz"[3 - map->across[0] - map->across[1]]);
  kith_text_add(title, sizeof title, " (code units)");
  for (int a = 0; a < 2; ++a) snprintf(labels[a], sizeof labels[a], "%c (code units)", "xyz"[map->across[a]]);
  const struct kith_figure_map drawn = {
      .file = file,
      .title = title,
      .labels = {labels[0], labels[1]},
      .pixels = {map->pixels[0], map->pixels[1]},
      .lower = {map->lower[0], map->lower[1]},
      .size = {map->size[0], map->size[1]},
      .value = f->pixels[k],
      .has_sign = panel->error || panel->field >= KITH_PICTURE_VELOCITY_X,
      .colors = {chosen ? wanted->range[0] : NAN, chosen ? wanted->range[1] : NAN}};
  kith_figure_map(g, &drawn);
}

/* The layout of panels; a lone map has the shape of its plane. */
static struct kith_figure_layout layout_of(const struct picture *f) {
  struct kith_figure_layout l = {
      .rows = (f->n + f->columns - 1) / f->columns, .columns = f->columns, .width = 500, .height = 440};
  const int *pixels = f->plane.pixels;
  if (f->n_curves > 0)
    l.legend = 34;
  else if (f->n > 1) /* flat maps stand close together */
    l.height = KITH_MAX(200, KITH_MIN(110 + 340 * pixels[1] / pixels[0], l.height));
  else
    l.width = 760, l.height = KITH_MAX(260, KITH_MIN(130 + 560 * pixels[1] / pixels[0], 1200));
  return l;
}

static void draw_legend(struct kith_figure *g, const struct picture *f) {
  kith_figure_legend(g);
  fprintf(g->file->stream, "NaN with points pt 7 ps 0.7 lc rgb '%s' title 'nodes'%s%s\n", NODES,
          f->plot->exact != NULL ? ", NaN with " EXACT " title 'exact'" : "",
          NDIM > 1 ? ", NaN with " MEANS " title 'means in bins'" : "");
}

static kith_status draw(struct picture *f, const char *directory) {
  const struct kith_plot *plot = f->plot;
  struct kith_figure figure;
  char title[256];
  snprintf(title, sizeof title, "%.150s    %d-D,  t = %.4g,  %lld nodes,  resolution %.4g", plot->scene, NDIM,
           plot->time, (long long)f->total, plot->resolution);
  if (f->n_curves > 0) {
    KITH_TRY(write_nodes(f, directory));
    if (NDIM > 1) KITH_TRY(write_means(f, directory));
    KITH_TRY(write_curve(f, directory));
  }
  const struct kith_figure_layout layout = layout_of(f);
  KITH_TRY(kith_figure_open(&figure, directory, plot->frame != NULL ? plot->frame : "plot", title, &layout));
  figure.png_only = plot->frame != NULL;
  for (int k = 0, column = 1; k < f->n; ++k) {
    if (f->panel[k].map)
      draw_map(&figure, f, k);
    else
      draw_curve(&figure, f, &f->panel[k], ++column);
  }
  if (f->n_curves > 0) draw_legend(&figure, f);
  return kith_figure_close(&figure);
}

kith_status kith_plot_write(const struct kith_plot *plot, const char *directory) {
  struct picture f = {.plot = plot};
  if (strlen(directory) >= KITH_PATH) KITH_FAIL(BAD_FILE, "%s: the path is too long", directory);
  if (plot->frame != NULL) snprintf(f.prefix, sizeof f.prefix, "%.40s_", plot->frame);
  kith_status status = collect(&f);
  if (status == KITH_OK && kith_ranks_rank(plot->nodes.ranks) == 0) status = draw(&f, directory);
  kith_free(&f.rows);
  for (int k = 0; k < f.n; ++k) kith_free(&f.pixels[k]);
  return status;
}
