/* test_plot.c - the data and script of a picture: what the files contain, against a solution defined here;
 * names of scenes that could do harm in a script; a missing gnuplot. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/cli/process.h"
#include "app/output/pictures/figure.h"
#include "app/output/pictures/plot.h"
#include "tests/unit/files.h"

static char text[4 << 20];

static const char *text_of(const char *name) {
  text[load(path_in(name), text, sizeof text - 1)] = '\0';
  return text;
}

/* Counts rows of five numbers after one title; returns the last row, and the smallest and largest
 * position. */
static int rows(const char *name, double last[5], double *least, double *most) {
  int n = 0;
  *least = INFINITY, *most = -INFINITY;
  for (const char *line = strchr(text_of(name), '\n') + 1; *line != '\0';
       line = strchr(line, '\n') + 1, ++n) {
    CHECK(sscanf(line, "%lf %lf %lf %lf %lf", last, last + 1, last + 2, last + 3, last + 4) == 5);
    *least = fmin(*least, last[0]), *most = fmax(*most, last[0]);
  }
  return n;
}

/* A solution for this test: radial about (1, 0, 0), v = r outwards, density 1 + r. */
static const struct kith_exact_gas solution = {.center = {1}};
static void state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  double r = 0;
  (void)self, (void)time;
  for (int a = 0; a < NDIM; ++a) r += (x[a] - solution.center[a]) * (x[a] - solution.center[a]);
  *out = (struct kith_exact_state){.density = 1 + sqrt(r), .pressure = 2, .energy = 3};
  for (int a = 0; a < NDIM; ++a) out->velocity[a] = x[a] - solution.center[a];
}
static double shock(const void *self, double time) {
  return (void)self, time;
}
static const struct kith_exact_ops radial = {
    .name = "radial", .state = state, .shock = shock, .radial = true};
static const struct kith_exact_ops turning = {
    .name = "turning", .state = state, .radial = true, .vortex = true};
static const struct kith_exact_ops planar = {.name = "planar", .state = state};

static const struct kith_picture usual = {.plane = {NAN, NAN, NAN}, .range = {NAN, NAN}};
/* Density 1 + y. */
static void state_across(const void *self, const double *x, double time, struct kith_exact_state *out) {
  state(self, x, time, out);
  out->density = 1 + (NDIM > 1 ? x[NDIM > 1] : 0);
}
static void state_along(const void *self, const double *x, double time, struct kith_exact_state *out) {
  state(self, x, time, out);
  out->density = 1 + x[0];
}
static const struct kith_exact_ops along = {.name = "along", .state = state_along};
static const struct kith_exact_ops across = {.name = "across", .state = state_across};

static int occurrences(const char *in_text, const char *word) {
  int n = 0;
  for (const char *at = in_text; (at = strstr(at, word)) != NULL; ++at) ++n;
  return n;
}

enum { MANY = 50001 };
static double *position, *velocity, *scalar;

static const struct kith_window everywhere = {{-INFINITY, INFINITY}, {0, INFINITY}};
static struct kith_plot sample(kith_index n, const struct kith_exact_ops *exact) {
  for (size_t k = 0; k < (size_t)n * NDIM; ++k) position[k] = velocity[k] = 0;
  for (kith_index i = 0; i < n; ++i) {
    position[(size_t)i * NDIM] = 1 + (i + 0.5) / n, velocity[(size_t)i * NDIM] = -2, scalar[i] = 1 + i % 2;
  }
  return (struct kith_plot){.scene = "test",
                            .picture = &usual,
                            .time = 0.5,
                            .resolution = 10,
                            .exact = exact,
                            .solution = &solution,
                            .window = &everywhere,
                            .nodes = {n, position, velocity, scalar, scalar, scalar, scalar, NULL, NULL}};
}

static void contents(void) {
  double last[5], least, most;
  struct kith_plot p = sample(100, &radial);
  CHECK_OK(kith_plot_write(&p, directory));
  CHECK(rows("profile.dat", last, &least, &most) == 100);
  CHECK_CLOSE(last[0], 0.995, 1e-7); /* 8 digits are written */
  CHECK(last[1] == 2 && fabs(last[2] + 2) < 1e-7 && last[4] == 2);
  CHECK(rows("exact.dat", last, &least, &most) > 1000);
  CHECK_CLOSE(least, 0, 0);
  CHECK_CLOSE(most, 0.8, 1e-7); /* 1.6 shock radii */
  CHECK_CLOSE(last[1], 1.8, 1e-7);
  CHECK_CLOSE(last[2], 0.8, 1e-7);
  for (int a = 1; a < NDIM; ++a) /* a velocity 3 along y is azimuthal, one along z is not */
    for (int i = 0; i < 100; ++i) velocity[(size_t)i * NDIM + a] = a == 1 ? 3 : 50;
  p.exact = &turning;
  CHECK_OK(kith_plot_write(&p, directory));
  CHECK(strstr(text_of("plot.gp"), "azimuthal velocity") != NULL);
  rows("profile.dat", last, &least, &most);
  CHECK_CLOSE(last[0], 0.995, 1e-7);
  if (NDIM > 1) CHECK_CLOSE(last[2], 3, 1e-7);
  rows("exact.dat", last, &least, &most);
  CHECK_CLOSE(most, 0.995, 1e-7);               /* no shock that ends it */
  if (NDIM > 1) CHECK_CLOSE(last[2], 0, 1e-15); /* this solution moves outwards */
  p.exact = &planar;
  CHECK_OK(kith_plot_write(&p, directory));
  rows("exact.dat", last, &least, &most);
  CHECK_CLOSE(least, 1.005, 1e-7); /* the range of the nodes */
  CHECK_CLOSE(most, 1.995, 1e-7);
  for (int k = 0; k < 3 && NDIM == 3; ++k) { /* a center is at z = 0, the axis of a vortex everywhere */
    const double z[3][2] = {{0, 1}, {0, 1}, {-1, 1 + 4e-16}};
    for (int i = 0; i < 100; ++i) position[(size_t)i * NDIM + NDIM - 1] = z[k][i % 2];
    p.exact = k == 0 ? &radial : &turning;
    CHECK_OK(kith_plot_write(&p, directory));
    CHECK(strstr(text_of("plot.gp"), k == 1 ? " at z = 0.5 (" : " at z = 0 (") != NULL);
  }
}

/* What is drawn if the scene does not say. */
static void default_pictures(void) {
  const struct {
    const struct kith_exact_ops *exact;
    int curves, maps;
  } cases[] = {{&along, 4, 0},
               {&radial, 4, NDIM > 1 ? 2 : 0},
               {&across, NDIM > 1 ? 0 : 4, NDIM > 1 ? 4 : 0},
               {NULL, NDIM > 1 ? 0 : 4, NDIM > 1 ? 1 : 0}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    const struct kith_plot p = sample(50, cases[k].exact);
    for (kith_index i = 0; i < 50 && NDIM > 1; ++i) position[(size_t)i * NDIM + 1] = i % 7; /* not a tube */
    CHECK_OK(kith_plot_write(&p, directory));
    text_of("plot.gp");
    CHECK(occurrences(text, "profile.dat") == cases[k].curves &&
          occurrences(text, " binary ") == cases[k].maps);
  }
  for (int flat = 0; flat < 2 && NDIM > 1; ++flat) { /* rows of flat maps are low */
    const struct kith_plot p = sample(50, &across);
    int width = 0, height = 0;
    for (kith_index i = 0; i < 50; ++i) position[(size_t)i * NDIM + 1] = (flat ? 0.05 : 1) * (i % 7);
    CHECK_OK(kith_plot_write(&p, directory));
    CHECK(sscanf(strstr(text_of("plot.gp"), "pngcairo noenhanced size "), "%*s %*s %*s %d,%d", &width,
                 &height) == 2);
    CHECK(width == 1000 && (height < 900) == flat);
  }
}

/* Pixels of a map that no node colors. */
static int blank_pixels(const char *name) {
  FILE *f = fopen(path_in(name), "r");
  int n = 0;
  CHECK(f != NULL);
  for (float value; f != NULL && fread(&value, sizeof value, 1, f) == 1;) n += isnan(value);
  if (f != NULL) fclose(f);
  return n;
}

/* Maps of errors leave out the nodes outside of the window of the solution; other maps have all nodes. */
static void errors_in_window(void) {
  static const struct kith_window half = {{-INFINITY, 25}, {0, INFINITY}};
  int blank[2][4]; /* without and with a window: of each map */
  for (int windowed = 0; windowed < 2 && NDIM > 1; ++windowed) {
    struct kith_plot p = sample(50, &across);
    if (windowed) p.window = &half;
    for (kith_index i = 0; i < 50; ++i) /* a spacing apart along x */
      position[(size_t)i * NDIM] = i, position[(size_t)i * NDIM + 1] = i % 7;
    CHECK_OK(kith_plot_write(&p, directory));
    for (int k = 0; k < 4; ++k) {
      char name[16];
      snprintf(name, sizeof name, "map_%d.bin", k + 1);
      blank[windowed][k] = blank_pixels(name);
    }
  }
  int more = 0;
  for (int k = 0; k < 4 && NDIM > 1; ++k) more += blank[1][k] > blank[0][k];
  CHECK(more == (NDIM > 1 ? 2 : 0));
}

/* Of many nodes 20000 are drawn, all different, over the whole range, the same ones each time. */
static void thinned(void) {
  double last[5], least, most, before = -INFINITY;
  struct kith_picture curves = usual;
  struct kith_plot p = sample(MANY, NULL);
  curves.kind = KITH_PICTURE_PROFILE;
  p.picture = &curves;
  CHECK_OK(kith_plot_write(&p, directory));
  CHECK(rows("profile.dat", last, &least, &most) == 20000 && least < 1.0001 && most > 1.9999);
  char *first = strdup(text_of("profile.dat"));
  for (const char *line = strchr(text, '\n') + 1; *line != '\0'; line = strchr(line, '\n') + 1) {
    const double place = strtod(line, NULL);
    CHECK(place > before);
    before = place;
  }
  CHECK_OK(kith_plot_write(&p, directory));
  CHECK(strcmp(first, text_of("profile.dat")) == 0);
  CHECK(rows("exact.dat", last, &least, &most) == 0);
  free(first);
}

/* gnuplot draws the picture, whatever the name of the scene and however odd the values; without gnuplot there
 * is a one-line message. */
static void drawing(void) {
  struct kith_plot p = sample(50, &radial);
  char *path = strdup(getenv("PATH") != NULL ? getenv("PATH") : "");
  p.scene = "it's `touch plot-was-here` \"$(x)\" \\ {/=9 a} \n @x %d";
  CHECK_OK(kith_plot_write(&p, directory));
  kith_status status = kith_gnuplot_run(directory, "plot");
  struct stat png = {0};
  if (status == KITH_OK) { /* else gnuplot is not installed */
    CHECK(stat(path_in("plot.png"), &png) == 0 && png.st_size > 10000);
    CHECK(stat(path_in("plot.pdf"), &png) == 0 && png.st_size > 10000);
    CHECK(access(path_in("plot.log"), F_OK) != 0);
    CHECK(access(path_in("plot-was-here"), F_OK) != 0);
    for (kith_index n = 0; n < 3; ++n) { /* no nodes; one; values that are not finite */
      p = sample(n, n == 1 ? &planar : n == 2 ? NULL : &radial);
      if (n == 2) scalar[0] = NAN, scalar[1] = INFINITY;
      CHECK_OK(kith_plot_write(&p, directory));
      CHECK_OK(kith_gnuplot_run(directory, "plot"));
    }
    p = sample(0, NULL);
    CHECK_OK(kith_plot_write(&p, directory));
    CHECK_OK(kith_gnuplot_run(directory, "plot"));
    FILE *f = fopen(path_in("plot.gp"), "w");
    CHECK(f != NULL && fputs("plot nonsense(\n", f) >= 0 && fclose(f) == 0);
    CHECK_STATUS(KITH_BAD_FILE, kith_gnuplot_run(directory, "plot"));
    CHECK(strstr(kith_failure(), "plot.log") != NULL && strlen(text_of("plot.log")) > 0);
  } else {
    CHECK(status == KITH_UNSUPPORTED);
  }
  setenv("PATH", "/nonexistent", 1);
  CHECK_STATUS(KITH_UNSUPPORTED, kith_gnuplot_run(directory, "plot"));
  CHECK(strstr(kith_failure(), "gnuplot cannot be run") != NULL && access(path_in("plot.log"), F_OK) != 0);
  setenv("PATH", path, 1);
  CHECK_STATUS(KITH_BAD_FILE, kith_gnuplot_run("no/such/place", "plot"));
  free(path);
}

/* Bounds of a range must differ as they are written, with 9 digits, however flat a curve is. */
static void flat_ranges(void) {
  for (int k = 0; k < 18; ++k) {
    const struct kith_range r = kith_range_with_room((struct kith_range){1.5, 1.5 + 3 * pow(10, -k)});
    char lower[32], upper[32];
    snprintf(lower, sizeof lower, "%.9g", r.lower), snprintf(upper, sizeof upper, "%.9g", r.upper);
    CHECK(strcmp(lower, upper) != 0);
  }
}

/* So must those of the colors of a map, all of whose values are the same. */
static void flat_colors(void) {
  static const double values[] = {1e-30, 1, 1e10, 1e30};
  for (size_t k = 0; k < sizeof values / sizeof *values && NDIM > 1; ++k) {
    const struct kith_plot p = sample(50, NULL);
    char lower[32] = "", upper[32] = "";
    for (kith_index i = 0; i < 50; ++i) position[(size_t)i * NDIM + 1] = i % 7, scalar[i] = values[k];
    CHECK_OK(kith_plot_write(&p, directory));
    const char *range = strstr(text_of("plot.gp"), "set cbrange [");
    CHECK(range != NULL && sscanf(range, "set cbrange [%31[^:]:%31[^]]", lower, upper) == 2);
    CHECK(strcmp(lower, upper) != 0);
  }
}

int main(void) {
  static const char *const files[] = {"profile.dat", "exact.dat", "mean.dat",  "plot.gp",
                                      "plot.png",    "plot.pdf",  "map_1.bin", "map_2.bin",
                                      "map_3.bin",   "map_4.bin", "map_6.bin"};
  directory_make();
  CHECK_OK(kith_resize(&position, 0, MANY * NDIM, sizeof *position));
  CHECK_OK(kith_resize(&velocity, 0, MANY * NDIM, sizeof *velocity));
  CHECK_OK(kith_resize(&scalar, 0, MANY, sizeof *scalar));
  flat_ranges();
  flat_colors();
  contents();
  default_pictures();
  errors_in_window();
  thinned();
  drawing();
  kith_free(&position), kith_free(&velocity), kith_free(&scalar);
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
