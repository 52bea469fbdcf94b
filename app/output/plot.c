/* plot.c - data files and the picture of a run. */
#include "app/output/plot.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "app/output/figure.h"

enum { MOST_NODES = 20000, CURVE = 2000, PANELS = 4, COLUMNS = 1 + PANELS };

/* The range of places, and of each panel's values of nodes. */
struct range {
  double lower, upper;
};
struct frame {
  const double *center; /* NULL: planar */
  struct range place, nodes[PANELS];
};

static void include(struct range *r, double value) {
  if (!isfinite(value)) return;
  r->lower = KITH_MIN(r->lower, value);
  r->upper = KITH_MAX(r->upper, value);
}

static kith_status open_data(struct kith_atomic_file **out, const struct frame *frame, const char *directory,
                             const char *name) {
  char path[KITH_PATH + 16];
  if (strlen(directory) >= KITH_PATH) KITH_FAIL(BAD_FILE, "%s: the path is too long", directory);
  snprintf(path, sizeof path, "%.*s/%s", KITH_PATH, directory, name);
  KITH_TRY(kith_atomic_file_open(out, path));
  fprintf((*out)->stream, "# %s density velocity pressure energy\n", frame->center != NULL ? "r" : "x");
  return KITH_OK;
}

static void put_row(FILE *f, const double row[COLUMNS]) {
  for (int k = 0; k < COLUMNS; ++k) fprintf(f, "%.8g%c", row[k], k + 1 < COLUMNS ? ' ' : '\n');
}

static double place_of(const struct kith_plot *p, const double *center, kith_index i) {
  return kith_exact_place(p->exact, center, p->nodes.position + (size_t)i * NDIM);
}

/* The node of stretch k of `stretches`, by golden sections: no pattern with that of a lattice. */
static kith_index picked(kith_index n, kith_index stretches, kith_index k) {
  const int64_t first = (int64_t)n * k / stretches, next = (int64_t)n * (k + 1) / stretches;
  return (kith_index)(first + (int64_t)((double)(next - first) * fmod(k * 0.6180339887498949, 1)));
}

static kith_status write_nodes(const struct kith_plot *p, struct frame *frame, const char *directory) {
  struct kith_atomic_file *file;
  const kith_index n = p->nodes.n, shown = KITH_MIN(n, (kith_index)MOST_NODES);
  KITH_TRY(open_data(&file, frame, directory, "profile.dat"));
  for (kith_index k = 0; k < shown; ++k) {
    const kith_index i = picked(n, shown, k);
    const double *x = p->nodes.position + (size_t)i * NDIM, *v = p->nodes.velocity + (size_t)i * NDIM;
    const double row[COLUMNS] = {place_of(p, frame->center, i), p->nodes.density[i],
                                 kith_exact_speed(p->exact, frame->center, x, v), p->nodes.pressure[i],
                                 p->nodes.energy[i]};
    put_row(file->stream, row);
    for (int j = 0; j < PANELS && row[0] <= frame->place.upper; ++j) include(&frame->nodes[j], row[1 + j]);
  }
  return kith_atomic_file_commit(&file, false);
}

/* On a ray to a corner: in a periodic box the images of the center are farthest there. */
static kith_status write_curve(const struct kith_plot *p, const struct frame *frame, const char *directory) {
  const double *center = frame->center, lower = center != NULL ? 0 : frame->place.lower;
  struct kith_atomic_file *file;
  KITH_TRY(open_data(&file, frame, directory, "exact.dat"));
  for (int k = 0; k <= CURVE && p->exact != NULL; ++k) {
    const double place = lower + (frame->place.upper - lower) * k / CURVE;
    const bool diagonal = NDIM > 1 && center != NULL;
    struct kith_exact_state state;
    double x[NDIM] = {0};
    for (int a = 0; a < NDIM && center != NULL; ++a) x[a] = center[a];
    x[0] += diagonal ? M_SQRT1_2 * place : place;
    if (diagonal) x[NDIM > 1] += M_SQRT1_2 * place;
    p->exact->state(p->solution, x, p->time, &state);
    const double row[COLUMNS] = {place, state.density, kith_exact_speed(p->exact, center, x, state.velocity),
                                 state.pressure, state.energy};
    put_row(file->stream, row);
  }
  return kith_atomic_file_commit(&file, false);
}

static struct frame frame_of(const struct kith_plot *p) {
  struct frame frame = {.place = {INFINITY, -INFINITY}};
  if (p->exact != NULL) frame.center = kith_exact_center(p->exact, p->solution);
  for (int j = 0; j < PANELS; ++j) frame.nodes[j] = frame.place;
  for (kith_index i = 0; i < p->nodes.n; ++i) include(&frame.place, place_of(p, frame.center, i));
  if (!(frame.place.lower < frame.place.upper)) { /* no node, or all at one place */
    const double middle = isfinite(frame.place.lower) ? frame.place.lower : 0;
    frame.place = (struct range){middle - 0.5, middle + 0.5};
  }
  if (frame.center != NULL) {
    const double shock = p->exact->shock != NULL ? p->exact->shock(p->solution, p->time) : 0;
    frame.place.lower = 0;
    if (shock > 0) frame.place.upper = KITH_MIN(frame.place.upper, 1.6 * shock);
  }
  return frame;
}

/* Between these bounds gnuplot shows all: the nodes, and the curve as far as it goes beyond them by no more
 * than half their span (a decade on a logarithmic axis): the energy in the center of a blast has no bound. */
static struct range widest(struct range n, bool logarithmic) {
  if (n.lower > n.upper) n = (struct range){0, 1};
  if (logarithmic) return (struct range){0.1 * n.lower, 10 * n.upper};
  const double size = KITH_MAX(fabs(n.lower), fabs(n.upper)), span = n.upper - n.lower;
  const double room = span > 1e-10 * size ? 0.5 * span : KITH_MAX(0.1 * size, 0.1);
  return (struct range){n.lower - room, n.upper + room};
}

static void draw_panel(struct kith_figure *g, const struct kith_plot *p, const struct frame *frame, int j) {
  static const char *const names[] = {"density", "velocity", "pressure", "specific energy"},
                           *const speeds[] = {"velocity", "radial velocity", "azimuthal velocity"},
                           *const places[] = {"x", "distance from the center", "distance from the axis"};
  const struct kith_norms *l = p->norms;
  const double l1[] = {l ? l->density.l1 : 0, l ? l->velocity.l1 : 0, l ? l->pressure.l1 : 0,
                       l ? l->energy.l1 : 0};
  const int geometry = p->exact != NULL && p->exact->vortex ? 2 : frame->center != NULL;
  const bool logarithmic =
      j == PANELS - 1 && frame->nodes[j].lower > 0 && frame->nodes[j].upper > 1e4 * frame->nodes[j].lower;
  const bool any = frame->nodes[j].lower <= frame->nodes[j].upper; /* gnuplot stops at nothing to draw */
  const struct range y = widest(frame->nodes[j], logarithmic);
  char title[40] = "";
  if (l != NULL) snprintf(title, sizeof title, "L1 error %.3g", l1[j]);
  kith_figure_panel(g, title, places[geometry], j == 1 ? speeds[geometry] : names[j], false);
  fprintf(
      g->file->stream,
      "%sset logscale y\nset xrange [%.9g:%.9g]\nset yrange [%.9g%s:%s%.9g]\n"
      "plot NaN notitle, 'profile.dat' using 1:%d with points pt 7 ps %s lc rgb '#0072b2' title 'nodes', \\\n"
      "  'exact.dat' using 1:%d with lines lw 1.5 lc rgb '#d55e00' title 'exact'\n",
      logarithmic ? "" : "un", frame->place.lower, frame->place.upper, y.lower, any ? "<*" : "",
      any ? "*<" : "", y.upper, j + 2, p->nodes.n > 4000 ? "0.2" : "0.5", j + 2);
}

kith_status kith_plot_write(const struct kith_plot *plot, const char *directory) {
  struct frame frame = frame_of(plot);
  struct kith_figure figure;
  char title[256];
  int used = snprintf(title, sizeof title, "%.150s    %d-D,  t = %.4g,  %lld nodes", plot->scene, NDIM,
                      plot->time, (long long)plot->nodes.n);
  if (plot->resolution > 0)
    snprintf(title + used, sizeof title - (size_t)used, ",  resolution %.4g", plot->resolution);
  KITH_TRY(write_nodes(plot, &frame, directory));
  KITH_TRY(write_curve(plot, &frame, directory));
  KITH_TRY(kith_figure_open(&figure, directory, "plot", title, 2, 2));
  for (int j = 0; j < PANELS; ++j) draw_panel(&figure, plot, &frame, j);
  return kith_figure_close(&figure);
}
