#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* posix_spawn_file_actions_addchdir_np */
#endif
#include "app/plot.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "lib/io/atomic_file.h"

enum { MOST_NODES = 20000, CLOUD = 4000, CURVE = 2000, PANELS = 4, COLUMNS = 1 + PANELS };

/* What is shown: the range of places, and of each panel's values for the nodes and the curve. */
struct range {
  double lower, upper;
};
struct frame {
  const double *center; /* NULL: planar */
  struct range place, nodes[PANELS], curve[PANELS], shown[PANELS];
  bool logarithmic[PANELS];
};

extern char **environ;

static void include(struct range *r, double value) {
  if (!isfinite(value)) return;
  r->lower = KITH_MIN(r->lower, value);
  r->upper = KITH_MAX(r->upper, value);
}

static kith_status open_in(struct kith_atomic_file **out, const char *directory, const char *name) {
  char path[4096];
  const int length = snprintf(path, sizeof path, "%s/%s", directory, name);
  if (length < 0 || (size_t)length >= sizeof path) KITH_FAIL(BAD_FILE, "%s: the path is too long", directory);
  return kith_atomic_file_open(out, path);
}

static void put_row(FILE *f, const double row[COLUMNS]) {
  for (int k = 0; k < COLUMNS; ++k) fprintf(f, "%.8g%c", row[k], k + 1 < COLUMNS ? ' ' : '\n');
}

/* Nodes. */

static double place_of(const struct kith_plot *p, const double *center, kith_index i) {
  return kith_exact_place(p->exact, center, p->nodes.position + (size_t)i * NDIM);
}

static void node_row(const struct kith_plot *p, const double *center, kith_index i, double row[COLUMNS]) {
  const double *x = p->nodes.position + (size_t)i * NDIM, *v = p->nodes.velocity + (size_t)i * NDIM;
  row[0] = place_of(p, center, i);
  row[1] = p->nodes.density[i];
  row[2] = kith_exact_speed(p->exact, center, x, v);
  row[3] = p->nodes.pressure[i];
  row[4] = p->nodes.energy[i];
}

/* The node of stretch k of `stretches`: one of it, picked by the finisher of splitmix64. */
static kith_index picked(kith_index n, kith_index stretches, kith_index k) {
  const int64_t first = (int64_t)n * k / stretches, next = (int64_t)n * (k + 1) / stretches;
  uint64_t z = (uint64_t)k + UINT64_C(0x9e3779b97f4a7c15);
  z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
  z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
  return (kith_index)(first + (int64_t)((z ^ (z >> 31)) % (uint64_t)(next - first)));
}

static kith_status write_nodes(const struct kith_plot *p, struct frame *frame, const char *directory) {
  struct kith_atomic_file *file;
  const kith_index n = p->nodes.n, shown = KITH_MIN(n, (kith_index)MOST_NODES);
  KITH_TRY(open_in(&file, directory, "profile.dat"));
  fprintf(file->stream, "# %s density velocity pressure energy\n", frame->center != NULL ? "r" : "x");
  for (kith_index k = 0; k < shown; ++k) {
    double row[COLUMNS];
    node_row(p, frame->center, picked(n, shown, k), row);
    put_row(file->stream, row);
    for (int j = 0; j < PANELS && row[0] <= frame->place.upper; ++j) include(&frame->nodes[j], row[1 + j]);
  }
  return kith_atomic_file_commit(&file, false);
}

/* The exact curve. */

/* On a ray from the center it goes towards a corner: in a periodic box the images of the center are farthest there. */
static void curve_row(const struct kith_plot *p, const double *center, double place, double row[COLUMNS]) {
  double x[NDIM] = {0};
  struct kith_exact_state state;
  for (int a = 0; a < NDIM && center != NULL; ++a) x[a] = center[a];
  const bool diagonal = NDIM > 1 && center != NULL;
  x[0] += diagonal ? M_SQRT1_2 * place : place;
  if (diagonal) x[NDIM > 1] += M_SQRT1_2 * place;
  p->exact->state(p->solution, x, p->time, &state);
  const double speed = kith_exact_speed(p->exact, center, x, state.velocity);
  const double values[COLUMNS] = {place, state.density, speed, state.pressure, state.energy};
  memcpy(row, values, sizeof values);
}

static kith_status write_curve(const struct kith_plot *p, struct frame *frame, const char *directory) {
  struct kith_atomic_file *file;
  KITH_TRY(open_in(&file, directory, "exact.dat"));
  fprintf(file->stream, "# %s density velocity pressure energy\n", frame->center != NULL ? "r" : "x");
  for (int k = 0; k <= CURVE && p->exact != NULL; ++k) {
    double row[COLUMNS];
    const double lower = frame->center != NULL ? 0 : frame->place.lower;
    curve_row(p, frame->center, lower + (frame->place.upper - lower) * k / CURVE, row);
    put_row(file->stream, row);
    for (int j = 0; j < PANELS; ++j) include(&frame->curve[j], row[1 + j]);
  }
  return kith_atomic_file_commit(&file, false);
}

/* The frame. */

static struct frame frame_of(const struct kith_plot *p) {
  struct frame frame = {.place = {INFINITY, -INFINITY}};
  if (p->exact != NULL && p->exact->center != NULL) frame.center = p->exact->center(p->solution);
  for (int j = 0; j < PANELS; ++j) frame.nodes[j] = frame.curve[j] = frame.place;
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

/* All nodes are shown, and the curve as far as it goes beyond them by no more than half their span (a decade
 * on a logarithmic axis): the energy in the center of a blast has no bound. */
static void choose_range(struct frame *frame, int j) {
  struct range n = frame->nodes[j];
  const struct range c = frame->curve[j];
  if (n.lower > n.upper) n = c.lower > c.upper ? (struct range){0, 1} : c;
  frame->logarithmic[j] = j == PANELS - 1 && n.lower > 0 && n.upper > 1e4 * n.lower;
  const double span = n.upper - n.lower;
  if (frame->logarithmic[j]) {
    frame->shown[j] = (struct range){0.5 * n.lower, 2 * n.upper};
    if (c.upper > n.upper) frame->shown[j].upper = 2 * KITH_MIN(c.upper, 10 * n.upper);
    return;
  }
  if (c.upper > n.upper) n.upper = KITH_MIN(c.upper, n.upper + 0.5 * span);
  if (c.lower < n.lower) n.lower = KITH_MAX(c.lower, n.lower - 0.5 * span);
  const double size = KITH_MAX(fabs(n.lower), fabs(n.upper));
  const double margin =
      n.upper - n.lower > 1e-9 * size && size > 0 ? 0.07 * (n.upper - n.lower) : KITH_MAX(0.1 * size, 0.1);
  frame->shown[j] = (struct range){n.lower - margin, n.upper + margin};
}

/* The script. */

/* In single quotes gnuplot takes all as it is; a quote is doubled. What is not printable becomes a blank. */
static void put_quoted(FILE *f, const char *text) {
  fputc('\'', f);
  for (const char *s = text; *s != '\0'; ++s) {
    if (*s == '\'') fputc('\'', f);
    fputc((unsigned char)*s < ' ' || *s == 0x7f ? ' ' : *s, f);
  }
  fputc('\'', f);
}

static void put_title(FILE *f, const struct kith_plot *p) {
  fputs("heading = ", f);
  put_quoted(f, p->scene);
  fprintf(f, " . '    %d-D,  t = %.4g,  %lld nodes", NDIM, p->time, (long long)p->nodes.n);
  if (p->resolution > 0) fprintf(f, ",  resolution %.4g", p->resolution);
  fputs("'\n", f);
  if (p->norms != NULL)
    fprintf(
        f,
        "heading = heading . \"\\n\" . 'L1:  density %.3g,  velocity %.3g,  pressure %.3g,  energy %.3g'\n",
        p->norms->density.l1, p->norms->velocity.l1, p->norms->pressure.l1, p->norms->energy.l1);
}

static void put_ranges(FILE *f, const struct frame *frame, const struct kith_plot *p) {
  const double margin = frame->center != NULL ? 0 : 0.015 * (frame->place.upper - frame->place.lower);
  const bool vortex = p->exact != NULL && p->exact->vortex;
  fprintf(f, "place = '%s'\n",
          vortex                  ? "distance from the axis"
          : frame->center != NULL ? "distance from the center"
                                  : "x");
  fprintf(f, "speed = '%s'\n",
          vortex                  ? "azimuthal velocity"
          : frame->center != NULL ? "radial velocity"
                                  : "velocity");
  fprintf(f, "set xrange [%.9g:%.9g]\n", frame->place.lower - margin, frame->place.upper + margin);
  fputs("array lower[4]\narray upper[4]\narray logarithmic[4]\n", f);
  for (int j = 0; j < PANELS; ++j)
    fprintf(f, "lower[%d] = %.9g; upper[%d] = %.9g; logarithmic[%d] = %d\n", j + 1, frame->shown[j].lower,
            j + 1, frame->shown[j].upper, j + 1, frame->logarithmic[j]);
  const kith_index shown = KITH_MIN(p->nodes.n, (kith_index)MOST_NODES);
  fprintf(f, "dot = %s\nthin = %d # for the SVG, where each dot is an object\n",
          shown > CLOUD ? "0.2"
          : shown > 600 ? "0.4"
                        : "0.6",
          shown > CLOUD ? 4 : 1);
}

static const char style[] =
    "names = 'density velocity pressure energy'\n"
    "label(k) = k == 2 ? speed : k == 4 ? 'specific energy' : word(names, k)\n"
    "node_color = '#2a6fb0'\n"
    "curve_color = '#e4572e'\n"
    "set style line 1 lc rgb '#e3e6ea' lw 0.6\n"
    "set border 3 lc rgb '#8a9099' lw 0.8\n"
    "set tics nomirror textcolor rgb '#3c424a' scale 0.6\n"
    "set grid back ls 1\n"
    "set format '%g'\n"
    "set lmargin 10\n"
    "set rmargin 2.5\n"
    "set key off\n";

static const char panels[] =
    "do for [format in 'png svg'] {\n"
    "  if (format eq 'png') { set terminal pngcairo noenhanced size 1400,1000 font 'Sans,13' linewidth 1.3 }\n"
    "  else { set terminal svg noenhanced size 1400,1000 font 'Sans,15' linewidth 1.3 background '#ffffff' }\n"
    "  set output 'plot.' . format\n"
    "  every = format eq 'svg' ? thin : 1\n"
    "  set multiplot layout 2,2 margins 0.065,0.985,0.065,0.895 spacing 0.075,0.085\n"
    "  do for [k = 1:4] {\n"
    "    if (k == 1) { set label 1 heading at screen 0.065,0.972 left font ',16' textcolor rgb '#1f2328' }\n"
    "    else { unset label 1 }\n"
    "    if (logarithmic[k]) { set logscale y; set ytics 100; set mytics 1 }\n"
    "    else { unset logscale y; set ytics autofreq; set mytics default }\n"
    "    set yrange [lower[k]:upper[k]]\n"
    "    set label 2 label(k) at graph 0.0,1.035 left textcolor rgb '#1f2328'\n"
    "    if (k > 2) { set xlabel place offset 0,0.4 textcolor rgb '#3c424a' } else { unset xlabel }\n"
    "    if (k == 2) { set key at screen 0.985,0.975 right top horizontal samplen 2 } else { set key off }\n"
    "    plot ";

/* Few dots lie over the curve; of a thick cloud nothing would be seen but dots, so there the curve lies over
 * it. */
static const char next[] = ", \\\n         ";
static const char dots[] =
    "'profile.dat' every every using 1:(column(k + 1)) with points pt 7 ps dot lc rgb node_color notitle, \\\n"
    "         keyentry with points pt 7 ps 0.8 lc rgb node_color title 'nodes'";
static const char curve[] =
    "'exact.dat' using 1:(column(k + 1)) with lines lw 1.5 lc rgb curve_color title 'exact'";

static kith_status write_script(const struct kith_plot *p, const struct frame *frame, const char *directory) {
  struct kith_atomic_file *file;
  KITH_TRY(open_in(&file, directory, "plot.gp"));
  FILE *f = file->stream;
  fputs("# gnuplot plot.gp\n", f);
  put_title(f, p);
  put_ranges(f, frame, p);
  fputs(style, f);
  fputs(panels, f);
  const bool has_dots = p->nodes.n > 0, has_curve = p->exact != NULL, cloud = p->nodes.n > CLOUD;
  if (has_curve && !cloud) fputs(curve, f);
  if (has_curve && has_dots && !cloud) fputs(next, f);
  if (has_dots) fputs(dots, f);
  if (has_curve && has_dots && cloud) fputs(next, f);
  if (has_curve && cloud) fputs(curve, f);
  if (!has_dots && !has_curve) fputs("NaN notitle", f);
  fputs("\n  }\n  unset multiplot\n  set output\n}\n", f);
  return kith_atomic_file_commit(&file, false);
}

kith_status kith_plot_write(const struct kith_plot *plot, const char *directory) {
  struct frame frame = frame_of(plot);
  KITH_TRY(write_nodes(plot, &frame, directory));
  KITH_TRY(write_curve(plot, &frame, directory));
  for (int j = 0; j < PANELS; ++j) choose_range(&frame, j);
  return write_script(plot, &frame, directory);
}

/* gnuplot. */

/* In `directory`, without a shell, its words into plot.log. 0 or an error number. */
static int spawn(pid_t *child, const char *directory) {
  char *const arguments[] = {(char[]){"gnuplot"}, (char[]){"plot.gp"}, NULL};
  posix_spawn_file_actions_t actions;
  int error = posix_spawn_file_actions_init(&actions);
  if (error != 0) return error;
  error = posix_spawn_file_actions_addchdir_np(&actions, directory);
  if (error == 0) error = posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  if (error == 0)
    error = posix_spawn_file_actions_addopen(&actions, 1, "plot.log", O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (error == 0) error = posix_spawn_file_actions_adddup2(&actions, 1, 2);
  if (error == 0) error = posix_spawnp(child, arguments[0], &actions, NULL, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

/* The log is kept only if there is something to read in it. */
static kith_status settle(const char *directory, int result) {
  char path[4096];
  snprintf(path, sizeof path, "%s/plot.log", directory);
  if (result == 0) {
    unlink(path);
    return KITH_OK;
  }
  KITH_FAIL(BAD_FILE, "gnuplot could not draw %s/plot.gp: see plot.log there", directory);
}

kith_status kith_plot_draw(const char *directory) {
  pid_t child;
  int result;
  if (access(directory, X_OK) != 0) KITH_FAIL(BAD_FILE, "%s: no directory to draw in", directory);
  const int error = spawn(&child, directory);
  if (error != 0) {
    settle(directory, 0);
    KITH_FAIL(UNSUPPORTED, "no picture: gnuplot cannot be run (%s); plot.gp is in %s", strerror(error),
              directory);
  }
  while (waitpid(child, &result, 0) < 0)
    if (errno != EINTR) KITH_FAIL(BAD_FILE, "no picture: gnuplot was lost: %s", strerror(errno));
  return settle(directory, result);
}
