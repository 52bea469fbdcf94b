/* figure.c - writes a script for gnuplot and has it drawn. */
#include "app/output/pictures/figure.h"

void kith_figure_put_quoted(FILE *f, const char *text) {
  fputc('\'', f);
  for (const char *s = text; *s != '\0'; ++s) fputc((unsigned char)*s < ' ' ? ' ' : *s == '\'' ? '`' : *s, f);
  fputc('\'', f);
}

enum { TITLE = 40 };

static int height_of(const struct kith_figure_layout *l) {
  return TITLE + l->rows * l->height + l->legend;
}

kith_status kith_figure_open(struct kith_figure *g, const char *directory, const char *name,
                             const char *title, const struct kith_figure_layout *layout) {
  char path[KITH_PATH + 40];
  *g = (struct kith_figure){.layout = *layout};
  snprintf(g->directory, sizeof g->directory, "%s", directory);
  snprintf(g->name, sizeof g->name, "%s", name);
  snprintf(path, sizeof path, "%s/%s.gp", directory, name);
  KITH_TRY(kith_atomic_file_open(&g->file, path));
  FILE *f = g->file->stream;
  const int width = layout->columns * layout->width, height = height_of(layout);
  fprintf(f,
          "# gnuplot %s.gp draws %s.png, then %s.pdf\n"
          "if (!exists('pdf')) pdf = 0\n"
          "if (pdf) set terminal pdfcairo noenhanced size %.2f,%.2f font 'Sans,12'; set output '%s.pdf'\n"
          "if (!pdf) set terminal pngcairo noenhanced size %d,%d font 'Sans,12'; set output '%s.png'\n"
          "set colorsequence podo\nset grid lt 1 lw 0.5 lc rgb '#dde1e6'\n"
          "set border 3 lc rgb '#30343a'\nset tics nomirror\nunset key\nset multiplot title ",
          name, name, name, width / 110.0, height / 110.0, name, width, height, name);
  kith_figure_put_quoted(f, title);
  fputs(" font 'Sans,13'\n", f);
  return KITH_OK;
}

void kith_figure_panel(struct kith_figure *g, const char *title, const char *x_label, const char *y_label) {
  FILE *f = g->file->stream;
  const char *const words[] = {title, x_label, y_label}, *const what[] = {"title", "xlabel", "ylabel"};
  const struct kith_figure_layout *l = &g->layout;
  const int row = g->n_panels / l->columns, column = g->n_panels % l->columns;
  const double height = height_of(l);
  ++g->n_panels;
  fprintf(f, "set origin %.6f,%.6f\nset size %.6f,%.6f\n", (double)column / l->columns,
          1 - (TITLE + (row + 1) * l->height) / height, 1.0 / l->columns, l->height / height);
  for (int k = 0; k < 3; ++k) {
    fprintf(f, "set %s ", what[k]);
    kith_figure_put_quoted(f, words[k]);
    fputc('\n', f);
  }
  fputs("unset logscale\nset format '%g'\nset autoscale\n", f);
}

void kith_figure_legend(struct kith_figure *g) {
  fprintf(g->file->stream,
          "set origin 0,0\nset size 1,%.6f\nset margins 0,0,0,0\nunset title\nunset xlabel\nunset ylabel\n"
          "unset tics\nunset grid\nunset border\nunset logscale\nset xrange [0:1]\nset yrange [0:1]\n"
          "set key center center horizontal samplen 2.5 font 'Sans,11'\nplot ",
          (double)g->layout.legend / height_of(&g->layout));
}

void kith_range_include(struct kith_range *r, double value) {
  if (!isfinite(value)) return;
  r->lower = KITH_MIN(r->lower, value);
  r->upper = KITH_MAX(r->upper, value);
}

struct kith_range kith_range_with_room(struct kith_range r) {
  /* Pictures have 9 digits: bounds that agree in all of them are none, and gnuplot stops. */
  const double size = KITH_MAX(fabs(r.lower), fabs(r.upper)), flat = KITH_MAX(0.1 * size, 1e-12),
               room = r.upper - r.lower > 1e-8 * size ? 0.06 * (r.upper - r.lower) : flat;
  return (struct kith_range){r.lower - room, r.upper + room};
}

double kith_range_tics(struct kith_range r) {
  const double step = (r.upper - r.lower) / 5, power = pow(10, floor(log10(step)));
  return step > 0 ? power * (step < 1.5 * power   ? 1
                             : step < 3.5 * power ? 2
                             : step < 7.5 * power ? 5
                                                  : 10)
                  : 1;
}

static kith_status write_pixels(const struct kith_figure *g, const struct kith_figure_map *map) {
  char path[KITH_PATH + 80];
  struct kith_atomic_file *file;
  snprintf(path, sizeof path, "%s/%s", g->directory, map->file);
  KITH_TRY(kith_atomic_file_open(&file, path));
  fwrite(map->value, sizeof *map->value, (size_t)map->pixels[0] * (size_t)map->pixels[1],
         file->stream); /* a short write fails at commit */
  return kith_atomic_file_commit(&file, false);
}

static struct kith_range colors_of(const struct kith_figure_map *map) {
  struct kith_range colors = KITH_NO_RANGE;
  if (isfinite(map->colors.lower)) colors = map->colors;
  for (size_t p = 0; !isfinite(map->colors.lower) && p < (size_t)map->pixels[0] * (size_t)map->pixels[1]; ++p)
    kith_range_include(&colors, map->value[p]);
  if (map->has_sign && !isfinite(map->colors.lower))
    colors.upper = KITH_MAX(fabs(colors.lower), fabs(colors.upper)), colors.lower = -colors.upper;
  /* 9 digits are written, as in kith_range_with_room. */
  const double size = KITH_MAX(fabs(colors.lower), fabs(colors.upper));
  if (!(colors.upper - colors.lower > 1e-8 * size)) colors.upper = colors.lower + KITH_MAX(1, 1e-6 * size);
  return isfinite(colors.lower) ? colors : (struct kith_range){0, 1};
}

void kith_figure_map(struct kith_figure *g, const struct kith_figure_map *map) {
  static const char rising[] =
      "0 '#440154', 1 '#472d7b', 2 '#3b528b', 3 '#2c728e', 4 '#21918c', 5 '#28ae80', "
      "6 '#5ec962', 7 '#addc30', 8 '#fde725'",
                    signs[] = "0 '#2166ac', 1 '#67a9cf', 2 '#f7f7f7', 3 '#ef8a62', 4 '#b2182b'";
  const struct kith_range colors = colors_of(map);
  const double *lower = map->lower, *size = map->size, wide = map->pixels[0] * size[0],
               high = map->pixels[1] * size[1], longest = KITH_MAX(wide, high),
               step = kith_range_tics((struct kith_range){0, longest}),
               span = (high < 0.35 * longest ? 1.6 : 1) * (colors.upper - colors.lower);
  if (g->status == KITH_OK) g->status = write_pixels(g, map);
  kith_figure_panel(g, map->title, map->labels[0], map->labels[1]);
  fprintf(
      g->file->stream,
      "set size ratio -1\nset palette defined (%s)\nset cbtics %g\n"
      "set cbrange [%.9g:%.9g]\nset xtics %g\nset ytics %g\nset xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\n"
      "plot '%s' binary array=(%d,%d) format='%%float' dx=%.9g dy=%.9g origin=(%.9g,%.9g) with image\n"
      "set size noratio\n",
      map->has_sign ? signs : rising, kith_range_tics((struct kith_range){0, span}), colors.lower,
      colors.upper, step, step, lower[0], lower[0] + wide, lower[1], lower[1] + high, map->file,
      map->pixels[0], map->pixels[1], size[0], size[1], lower[0] + 0.5 * size[0], lower[1] + 0.5 * size[1]);
}

kith_status kith_figure_close(struct kith_figure *g) {
  fputs("unset multiplot\nset output\n", g->file->stream);
  if (!g->png_only) fprintf(g->file->stream, "if (!pdf) reset; pdf = 1; load '%s.gp'\n", g->name);
  if (g->status != KITH_OK) kith_atomic_file_abandon(&g->file);
  KITH_TRY(g->status);
  KITH_TRY(kith_atomic_file_commit(&g->file, false));
  if (kith_gnuplot_run(g->directory, g->name) != KITH_OK)
    fprintf(stderr, "kith: warning: %s\n", kith_failure());
  return KITH_OK;
}
