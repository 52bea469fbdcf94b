/* Equation of state from a file: pressures over densities and energies. The file, with # comments, has a line
 * of densities, a line of energies, and for each density a line of pressures, one for each energy. Numbers
 * must rise along each line, and pressures must not fall with the density; else the line and value are named.
 *
 * Between the given values P is a monotone cubic in the energy at four densities, then a monotone cubic
 * through these in the density (Fritsch and Butland 1984, SIAM J. Sci. Stat. Comput. 5, 300): continuous with
 * its derivatives, from which c^2 = dP/drho + P / rho^2 dP/du; exact where P is linear in both, of third
 * order elsewhere. Beyond the edges the table has the values at the edges, and a run that gets there
 * stops. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "physics/eos.h"

struct table {
  char file[200];
  int rows, columns;
  double number[]; /* density[rows], energy[columns], pressure[rows][columns], its slope along the energy */
};
static const struct kith_param params[] = {
    {"file", KITH_PARAM_NAME, NULL, "", "file of the table; relative to the folder of the scene",
     KITH_INTO(struct table, file)},
    {0}};

static const double *density_of(const struct table *t) {
  return t->number;
}
static const double *energy_of_column(const struct table *t) {
  return t->number + t->rows;
}
static const double *pressure_of(const struct table *t, int row) {
  return t->number + t->rows + t->columns + (size_t)row * (size_t)t->columns;
}
static const double *slope_of(const struct table *t, int row) {
  return pressure_of(t, t->rows + row);
}

/* --- the spline --- */

/* A value and its derivative by the energy. */
struct value {
  double p, du;
};

static struct value secant(struct value a, struct value b, double h) {
  return (struct value){(b.p - a.p) / h, (b.du - a.du) / h};
}

/* Returns the slope between secants a and b, on lengths g and h: their weighted harmonic mean. */
static struct value middle_slope(struct value a, struct value b, double g, double h) {
  const double part = (1 + h / (g + h)) / 3, sum = part * b.p + (1 - part) * a.p;
  if (!(a.p * b.p > 0)) return (struct value){0, 0};
  const double d = a.p * b.p / sum;
  return (struct value){d, (a.du * b.p + a.p * b.du - d * (part * b.du + (1 - part) * a.du)) / sum};
}

/* Returns the slope at one end of an interval with secant s from that at the other end: that of a parabola,
 * limited so that values rise. */
static struct value end_slope(struct value s, struct value other) {
  const double d = 2 * s.p - other.p;
  return d < 0         ? (struct value){0, 0}
         : d > 3 * s.p ? (struct value){3 * s.p, 3 * s.du}
                       : (struct value){d, 2 * s.du - other.du};
}

/* Returns the interval of x[n] that holds `at`, which is first moved to the nearest edge if outside. */
static int interval(const double *x, int n, double *at) {
  int low = 0, high = n - 1;
  *at = KITH_MIN(KITH_MAX(*at, x[0]), x[n - 1]);
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    *(x[middle] <= *at ? &low : &high) = middle;
  }
  return low;
}

/* Returns the cubic between a and b, with slopes da and db, at the fraction t of the length h. *slope: its
 * derivative. */
static double cubic(double a, double b, double da, double db, double h, double t, double *slope) {
  const double s = (b - a) / h, q = da + db - 2 * s, r = 3 * s - 2 * da - db;
  *slope = da + t * (2 * r + 3 * t * q);
  return a + h * t * (da + t * (r + t * q));
}

static double evaluate(const struct table *t, double density, double energy, double *drho, double *du) {
  const double *rho = density_of(t), *u = energy_of_column(t);
  const int i = interval(rho, t->rows, &density), j = interval(u, t->columns, &energy);
  const int first = KITH_MAX(i - 1, 0), last = KITH_MIN(i + 2, t->rows - 1);
  const double width = u[j + 1] - u[j], part = (energy - u[j]) / width, h = rho[i + 1] - rho[i];
  struct value row[4], s[3], below, above;
  for (int k = first; k <= last; ++k) {
    const double *p = pressure_of(t, k) + j, *m = slope_of(t, k) + j;
    row[k - i + 1].p = cubic(p[0], p[1], m[0], m[1], width, part, &row[k - i + 1].du);
  }
  for (int k = first; k < last; ++k)
    s[k - i + 1] = secant(row[k - i + 1], row[k - i + 2], rho[k + 1] - rho[k]);
  below = above = s[1];
  if (i > 0) below = middle_slope(s[0], s[1], rho[i] - rho[i - 1], h);
  if (last == i + 2) above = middle_slope(s[1], s[2], h, rho[i + 2] - rho[i + 1]);
  if (i == 0) below = end_slope(s[1], above);
  if (last < i + 2) above = end_slope(s[1], below);
  const double at = (density - rho[i]) / h;
  double ignored;
  *du = cubic(row[1].du, row[2].du, below.du, above.du, h, at, &ignored);
  return cubic(row[1].p, row[2].p, below.p, above.p, h, at, drho);
}

/* --- the file --- */

struct reader {
  FILE *file;
  const char *name;
  int line;
  char *text;     /* the present line; owned, as is `number` */
  double *number; /* all numbers so far, as in struct table without slopes */
  size_t room, n, capacity;
};

/* Reads the numbers of the next line that has any. */
static kith_status read_line(struct reader *r, int *count) {
  *count = 0;
  while (*count == 0 && getline(&r->text, &r->room, r->file) >= 0) {
    char *p = r->text, *end;
    ++r->line;
    p[strcspn(p, "#\n")] = '\0';
    for (double value; value = strtod(p, &end), end != p && isfinite(value); p = end, ++*count) {
      KITH_TRY(kith_grow(&r->number, &r->capacity, r->n, r->n + 1, sizeof value));
      r->number[r->n++] = value;
    }
    p += strspn(p, " \t\r");
    if (*p != '\0') KITH_FAIL(BAD_INPUT, "%s:%d: '%.40s' is not a number", r->name, r->line, p);
  }
  if (*count == 0 && !feof(r->file)) KITH_FAIL(BAD_FILE, "%s: %s", r->name, strerror(errno));
  return KITH_OK;
}

/* Checks that each number of the last line is above the one before it (before = 1), or not below that of the
 * line before, `before` places earlier. */
static kith_status check_rises(const struct reader *r, const char *what, int count, int before) {
  for (const double *x = r->number + r->n - count + (before == 1); x < r->number + r->n; ++x)
    if (!(*x > x[-before] || (before > 1 && *x == x[-before])))
      KITH_FAIL(BAD_INPUT, "%s:%d: %s %g does not rise from %g, %s", r->name, r->line, what, *x, x[-before],
                before == 1 ? "the number before it" : "that of the density before");
  return KITH_OK;
}

static kith_status read_table(struct reader *r, int *rows, int *columns) {
  *rows = *columns = 1;
  for (int k = 0; k < 2 + *rows; ++k) {
    const char *what = k == 0 ? "density" : k == 1 ? "energy" : "pressure";
    int count;
    KITH_TRY(read_line(r, &count));
    if (k == 0) *rows = count;
    if (k == 1) *columns = count;
    if (count < 2 || (k > 1 && count != *columns))
      KITH_FAIL(BAD_INPUT, "%s:%d: %d numbers (%s), wanted %s%d", r->name, r->line, count, what,
                k > 1 ? "" : "at least ", k > 1 ? *columns : 2);
    KITH_TRY(check_rises(r, what, count, 1));
    if (k > 2) KITH_TRY(check_rises(r, what, count, count));
  }
  if (!(r->number[0] > 0)) KITH_FAIL(BAD_INPUT, "%s: density %g is not above 0", r->name, r->number[0]);
  int more;
  KITH_TRY(read_line(r, &more));
  if (more > 0)
    KITH_FAIL(BAD_INPUT, "%s:%d: more lines of pressures than densities, %d", r->name, r->line, *rows);
  return KITH_OK;
}

static void make_slopes(struct table *t) {
  const double *u = energy_of_column(t);
  for (int k = 0; k < t->rows; ++k) {
    const double *p = pressure_of(t, k);
    double *m = t->number + (slope_of(t, k) - t->number);
    const int n = t->columns;
    for (int j = 0; j < n; ++j) {
      const struct value left = {j > 0 ? (p[j] - p[j - 1]) / (u[j] - u[j - 1]) : 0, 0},
                         right = {j + 1 < n ? (p[j + 1] - p[j]) / (u[j + 1] - u[j]) : 0, 0};
      m[j] = j > 0 && j + 1 < n ? middle_slope(left, right, u[j] - u[j - 1], u[j + 1] - u[j]).p
                                : left.p + right.p;
    }
    if (n < 3) continue;
    m[0] = end_slope((struct value){m[0], 0}, (struct value){m[1], 0}).p;
    m[n - 1] = end_slope((struct value){m[n - 1], 0}, (struct value){m[n - 2], 0}).p;
  }
}

static kith_status load(void **settings, const char *folder) {
  const struct table *named = *settings;
  char name[4096];
  int rows, columns;
  snprintf(name, sizeof name, "%s%s", named->file[0] == '/' ? "" : folder, named->file);
  struct reader r = {.file = fopen(name, "r"), .name = name};
  if (r.file == NULL) KITH_FAIL(BAD_INPUT, "%s: %s", name, strerror(errno));
  char mark[3]; /* what editors may put in front of UTF-8 */
  if (fread(mark, 1, 3, r.file) != 3 || memcmp(mark, "\xef\xbb\xbf", 3) != 0) rewind(r.file);
  kith_status status = read_table(&r, &rows, &columns);
  const size_t all = sizeof *named + (r.n + (size_t)rows * (size_t)columns) * sizeof *r.number;
  if (status == KITH_OK) status = kith_resize(settings, sizeof *named, all, 1);
  if (status == KITH_OK) {
    struct table *t = *settings;
    t->rows = rows, t->columns = columns;
    memcpy(t->number, r.number, r.n * sizeof *r.number);
    make_slopes(t);
  }
  fclose(r.file);
  free(r.text);
  kith_free(&r.number);
  return status;
}

/* --- the equation --- */

static void state(const void *settings, kith_index n, const double *density, const double *energy,
                  double *pressure, double *sound_speed) {
  for (kith_index i = 0; i < n; ++i) {
    double drho, du;
    pressure[i] = evaluate(settings, density[i], energy[i], &drho, &du);
    sound_speed[i] = sqrt(KITH_MAX(drho + pressure[i] / (density[i] * density[i]) * du, 0.0));
  }
}

/* Returns the energy by bisection; that of the nearest edge if the table does not reach the pressure. */
static double energy_of(const void *settings, double density, double pressure) {
  const struct table *t = settings;
  double low = energy_of_column(t)[0], high = energy_of_column(t)[t->columns - 1], middle, drho, du;
  while ((middle = 0.5 * (low + high)) > low && middle < high)
    *(evaluate(t, density, middle, &drho, &du) < pressure ? &low : &high) = middle;
  return high;
}

static const char *outside(const void *settings, double density, double energy) {
  const struct table *t = settings;
  const double *rho = density_of(t), *u = energy_of_column(t);
  if (!(density >= rho[0] && density <= rho[t->rows - 1])) return "its density is outside of the table";
  return energy >= u[0] && energy <= u[t->columns - 1] ? NULL : "its energy is outside of the table";
}

const struct kith_eos_ops kith_eos_table = {
    .name = "table",
    .doc = "pressures from a file: lines of densities, of energies, and of pressures for each density",
    KITH_SETTINGS(params, table),
    .load = load,
    .state = state,
    .energy = energy_of,
    .outside = outside};
