/* test_lattice.c - lattices: sites, volumes, nearest neighbors (against the geometry of ideal lattices),
 * periodicity and mirrors (brute force over images), counts at the limits of rounding, stiffness, jitter, and
 * what is refused. */
#include "app/initial/lattice.h"
#include "tests/check.h"

#include <stdlib.h>

static const enum kith_lattice every[4] = {KITH_LATTICE_CUBIC, KITH_LATTICE_BCC, KITH_LATTICE_FCC,
                                           KITH_LATTICE_HCP};
enum { N_KINDS = 4 };

static struct kith_box box_of(double lower, const double *side) {
  struct kith_box box;
  for (int a = 0; a < NDIM; ++a) {
    box.lower[a] = lower;
    box.upper[a] = lower + side[a];
  }
  return box;
}

/* Edges of a cell whose volume is its number of sites, from its geometry (see each line). Returns the number
 * of sites. */
static int ideal_cell(enum kith_lattice kind, double *side) {
  for (int a = 0; a < 3; ++a) side[a] = 1;
  if (NDIM == 1 || kind == KITH_LATTICE_CUBIC) return 1;
  if (NDIM == 2) {
    /* triangular: area sqrt(3)/2 a^2 */
    const double a = kind == KITH_LATTICE_BCC ? sqrt(2.0) : sqrt(2 / sqrt(3.0));
    side[0] = a, side[1] = kind == KITH_LATTICE_BCC ? a : sqrt(3.0) * a;
    return 2;
  }
  if (kind == KITH_LATTICE_HCP) { /* close-packed spheres of diameter a: volume a^3 / sqrt(2) each */
    const double a = pow(2, 1. / 6);
    side[0] = a, side[1] = sqrt(3.0) * a, side[2] = sqrt(8. / 3) * a;
    return 4;
  }
  const int n = kind == KITH_LATTICE_BCC ? 2 : 4;
  for (int a = 0; a < 3; ++a) side[a] = cbrt(n);
  return n;
}

/* Returns the distance to the nearest site across periodic faces, and counts sites at this distance. */
static double nearest(const struct kith_lattice_fit *fit, int64_t i, int *count) {
  double x[NDIM], y[NDIM], least = INFINITY;
  kith_lattice_site(fit, i, x);
  *count = 0;
  for (int64_t j = 0; j < fit->sites; ++j) {
    if (j == i) continue;
    kith_lattice_site(fit, j, y);
    double r2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double side = fit->box.upper[a] - fit->box.lower[a], d = x[a] - y[a];
      r2 += (d - side * round(d / side)) * (d - side * round(d / side));
    }
    const double r = sqrt(r2);
    if (r < least * (1 - 1e-9)) *count = 0;
    if (r < least * (1 + 1e-9)) ++*count;
    least = KITH_MIN(least, r);
  }
  return least;
}

/* Nearest neighbors in ideal lattices: 2 in 1-D, 4 and 6 in 2-D, 6, 8, 12, 12 in 3-D. */
static void ideal(enum kith_lattice kind, double s) {
  static const double distance[3][N_KINDS] = {
      {1, 1, 1, 1},
      {1, 1, 0, 1.0745699318235418},
      {1, 1.0911236359717214, 1.1224620483093730, 1.1224620483093730}};
  static const int neighbors[3][N_KINDS] = {{2, 2, 2, 2}, {4, 4, 0, 6}, {6, 8, 12, 12}};
  double side[3];
  const int per_cell = ideal_cell(kind, side);
  for (int a = 0; a < 3; ++a) side[a] *= (3 + a) * s;
  const struct kith_box box = box_of(-0.37, side);
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, kind, &box, s));
  CHECK(fit.sites == per_cell * (NDIM == 1 ? 3 : NDIM == 2 ? 12 : 60));
  CHECK_CLOSE(fit.site_volume, kith_pow_dim(s), 1e-14 * kith_pow_dim(s)); /* round-off of a few products */
  for (int64_t i = 0; i < fit.sites; ++i) {
    int count;
    /* positions are of order 30 s */
    CHECK_CLOSE(nearest(&fit, i, &count), distance[NDIM - 1][kind] * s, 1e-13 * s);
    CHECK(count == neighbors[NDIM - 1][kind]);
  }
}

/* The sum of a kernel over all images within its support, by brute force. */
static double kernel_sum(const struct kith_lattice_fit *fit, const double *x, double support) {
  double sum = 0, y[NDIM];
  int images[3] = {0, 0, 0};
  for (int a = 0; a < NDIM; ++a) images[a] = 1 + (int)(support / (fit->box.upper[a] - fit->box.lower[a]));
  for (int64_t j = 0; j < fit->sites; ++j) {
    kith_lattice_site(fit, j, y);
    for (int ix = -images[0]; ix <= images[0]; ++ix)
      for (int iy = -images[1]; iy <= images[1]; ++iy)
        for (int iz = -images[2]; iz <= images[2]; ++iz) {
          const int image[3] = {ix, iy, iz};
          double r2 = 0;
          for (int a = 0; a < NDIM; ++a) {
            const double d = y[a] + image[a] * (fit->box.upper[a] - fit->box.lower[a]) - x[a];
            r2 += d * d;
          }
          const double q = sqrt(r2) / support;
          if (q < 1) sum += (1 - q) * (1 - q) * (1 - q) * (1 - q) * (1 + 4 * q);
        }
  }
  return sum;
}

/* All sites see the same lattice across periodic faces, also if cells are stretched. */
static void continues(enum kith_lattice kind) {
  const double side[3] = {1.0, 0.83, 0.71};
  const struct kith_box box = box_of(0.2, side);
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, kind, &box, NDIM == 1 ? 0.07 : 0.21));
  double x[NDIM];
  kith_lattice_site(&fit, 0, x);
  const double first = kernel_sum(&fit, x, 0.5);
  for (int64_t i = 0; i < fit.sites; ++i) {
    kith_lattice_site(&fit, i, x);
    CHECK_CLOSE(kernel_sum(&fit, x, 0.5), first, 1e-12 * first); /* some hundred terms */
  }
}

/* Is x, moved into the box, a site? */
static bool is_site(const struct kith_lattice_fit *fit, const double *x) {
  double y[NDIM];
  for (int64_t j = 0; j < fit->sites; ++j) {
    double off = 0;
    kith_lattice_site(fit, j, y);
    for (int a = 0; a < NDIM; ++a) {
      const double side = fit->box.upper[a] - fit->box.lower[a], d = x[a] - y[a];
      off = fmax(off, fabs(d - side * round(d / side)));
    }
    if (off < 1e-12) return true; /* edges are of order 1 */
  }
  return false;
}

/* Sites that are mirrored along `axis` and moved sideways by `glide` cells are sites. */
static void mirrored(enum kith_lattice kind, int axis, const double *glide) {
  const double side[3] = {1.0, 0.83, 0.71};
  const struct kith_box box = box_of(0.2, side);
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, kind, &box, NDIM == 1 ? 0.07 : 0.17));
  for (int64_t i = 0; i < fit.sites; ++i) {
    double x[NDIM];
    kith_lattice_site(&fit, i, x);
    x[axis] = box.lower[axis] + box.upper[axis] - x[axis];
    for (int a = 0; a < NDIM; ++a) x[a] += glide[a] * (box.upper[a] - box.lower[a]) / (double)fit.cells[a];
    CHECK(is_site(&fit, x));
  }
}

static void mirrors(void) {
  static const double none[3] = {0, 0, 0}, y[3] = {0, 0.5, 0}, x[3] = {0.5, 0, 0}, z[3] = {0, 0, 0.5};
  for (int a = 0; a < NDIM; ++a) mirrored(KITH_LATTICE_CUBIC, a, none);
#if KITH_NDIM == 2
  mirrored(KITH_LATTICE_BCC, 0, y);
  mirrored(KITH_LATTICE_BCC, 1, x);
  mirrored(KITH_LATTICE_HCP, 0, y);
  mirrored(KITH_LATTICE_HCP, 1, x);
#elif KITH_NDIM == 3
  static const double bcc[3][3] = {{0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}};
  for (int a = 0; a < NDIM; ++a) mirrored(KITH_LATTICE_BCC, a, bcc[a]);
  mirrored(KITH_LATTICE_FCC, 0, y);
  mirrored(KITH_LATTICE_FCC, 1, z);
  mirrored(KITH_LATTICE_FCC, 2, x);
  mirrored(KITH_LATTICE_HCP, 0, y);
  mirrored(KITH_LATTICE_HCP, 1, z);
#endif
  (void)x, (void)y, (void)z;
}

/* Layers along each axis are symmetric about the middle, and away from faces; for cubic in a box around 0 to
 * the last bit. */
static void centered(enum kith_lattice kind) {
  struct kith_box box;
  for (int a = 0; a < NDIM; ++a) box.upper[a] = 0.5 + 0.1 * a, box.lower[a] = -box.upper[a];
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, kind, &box, 0.09));
  double sum[NDIM] = {0}, x[NDIM], y[NDIM];
  for (int64_t i = 0; i < fit.sites; ++i) {
    kith_lattice_site(&fit, i, x);
    for (int a = 0; a < NDIM; ++a) {
      sum[a] += x[a];
      CHECK(x[a] > box.lower[a] + 0.01 && x[a] < box.upper[a] - 0.01);
    }
    kith_lattice_site(&fit, fit.sites - 1 - i, y);
    for (int a = 0; a < NDIM; ++a) CHECK(kind != KITH_LATTICE_CUBIC || x[a] == -y[a]);
  }
  for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(sum[a], 0, 1e-12 * (double)fit.sites);
}

/* L / dx differs from an integer by round-off, the number of cells must not. */
static void exact_counts(void) {
  static const double spacing[] = {0.1,     0.05,    0.02,    0.01,     0.003, 1. / 3, 1. / 7,
                                   1. / 48, 1. / 49, 1. / 60, 1. / 121, 0.7,   1e-5};
  static const double lower[] = {0, -0.5, 0.1, -1. / 3, 7.3};
  for (size_t k = 0; k < sizeof spacing / sizeof spacing[0]; ++k) {
    double sum = 0;
    for (int n = 1; n <= 300; ++n) {
      sum += spacing[k]; /* with another rounding than n * spacing */
      for (size_t l = 0; l < sizeof lower / sizeof lower[0]; ++l) {
        struct kith_box box;
        for (int a = 0; a < NDIM; ++a) {
          box.lower[a] = lower[l];
          box.upper[a] = lower[l] + (a == 0 ? n * spacing[k] : sum);
        }
        struct kith_lattice_fit fit;
        CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, spacing[k]));
        for (int a = 0; a < NDIM; ++a) CHECK(fit.cells[a] == n);
      }
    }
  }
}

/* Halves are rounded up, whatever the round-off, so that both sides of a jump agree. */
static void halves(void) {
  for (int n = 1; n <= 200; ++n) {
    struct kith_box box;
    for (int a = 0; a < NDIM; ++a) box.lower[a] = 0.3, box.upper[a] = 0.3 + (n + 0.5) * 0.01;
    struct kith_lattice_fit fit;
    CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 0.01));
    for (int a = 0; a < NDIM; ++a) CHECK(fit.cells[a] == n + 1);
  }
}

static void balanced(void) {
  struct kith_box box;
  struct kith_lattice_fit fit;
  for (int a = 0; a < NDIM; ++a) box.lower[a] = 0, box.upper[a] = a == 0 ? 1 : 0.0435;
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 0.01));
  CHECK_OK(kith_lattice_balance(&fit, 1e-2 * 1e-2 * 1e-2));
  if (NDIM == 3) CHECK(fit.cells[0] == 118); /* 100 * 4.35^2 / 4^2 = 118.3 */
  if (NDIM == 3) CHECK(fit.sites == 118 * 16);
  for (int a = 0; a < NDIM; ++a) box.upper[a] = 1.005;
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 0.05));
  const int64_t before = fit.sites;
  CHECK_OK(kith_lattice_balance(&fit, 1e-3 * kith_pow_dim(0.05))); /* there is a long axis in 1-D only */
  CHECK(NDIM == 1 ? fit.sites > before : fit.sites == before);
}

/* A glass is uniform (its kernel sums are nearly equal), no two sites are close together, and distances to
 * nearest sites vary. */
static void glass(void) {
  double side[3] = {20, 10, 10}, least = INFINITY, most = 0, sum = 0, squares = 0, first = 0;
  const struct kith_box box = box_of(-3, side);
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_GLASS, &box, 1));
  CHECK(fit.sites == (NDIM == 1 ? 20 : NDIM == 2 ? 200 : 2000));
  for (int64_t i = 0; i < fit.sites; i += NDIM == 3 ? 7 : 1) {
    int count;
    double x[NDIM];
    const double r = nearest(&fit, i, &count);
    kith_lattice_site(&fit, i, x);
    for (int a = 0; a < NDIM; ++a) CHECK(box.lower[a] <= x[a] && x[a] < box.upper[a]);
    const double density = kernel_sum(&fit, x, 2.4) - 1; /* without the site itself */
    if (i == 0) first = density;
    least = KITH_MIN(least, r), most = KITH_MAX(most, r);
    sum += density / first - 1, squares += (density / first - 1) * (density / first - 1);
  }
  const double n = (double)(NDIM == 3 ? (fit.sites + 6) / 7 : fit.sites), mean = sum / n;
  /* 0.93 to 1.09: between those of a cubic and of a close-packed lattice */
  CHECK(least > 0.9 && most < 1.1);
  CHECK(sqrt(squares / n - mean * mean) < 0.006); /* 0.002 to 0.004 */
  if (NDIM > 1) CHECK(most > least + 0.01);
  /* A region that is thinner than a cell, or halves one, would be squeezed. */
  CHECK_STATUS(NDIM > 1 ? KITH_BAD_INPUT : KITH_OK, kith_lattice_fit(&fit, KITH_LATTICE_GLASS, &box, 4));
  CHECK_STATUS(NDIM > 1 ? KITH_BAD_INPUT : KITH_OK,
               kith_lattice_fit(&fit, KITH_LATTICE_GLASS, &box, 1. / 1.5));
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_GLASS, &box, 1.05));
}

/* Signs agree with disturbances that grow or decay in runs (`kith stress rest-cubic-2d` and others). Oracle
 * for the square lattice: the second derivative of the kernel, sum of W'' (A/r)^2 + W' (2 B/r - A^2/r^3). */
static void stiffness(void) {
  static const struct {
    enum kith_lattice kind;
    double neighbors[2];
    bool stiff;
  } known[] = {{KITH_LATTICE_CUBIC, {12, 32}, true}, {KITH_LATTICE_CUBIC, {18, 60}, false},
               {KITH_LATTICE_HCP, {18, 60}, true},   {KITH_LATTICE_HCP, {28, 32}, false},
               {KITH_LATTICE_BCC, {12, 60}, true},   {KITH_LATTICE_BCC, {16, 45}, false}};
  for (size_t k = 0; k < sizeof known / sizeof *known; ++k) {
    const double s =
        kith_lattice_stiffness(known[k].kind, KITH_KERNEL_wendland_c2, known[k].neighbors[NDIM == 3]);
    CHECK(NDIM == 1 ? isinf(s) : known[k].stiff ? s > 0.02 : s < -0.02);
  }
#if KITH_NDIM == 2
  const double support = sqrt(20 / 3.14159265358979323846);
  double along = 0, across = 0, sum = 0;
  for (int k = -4; k <= 4; ++k)
    for (int l = -4; l <= 4; ++l) {
      const double r2 = k * k + l * l, r = sqrt(r2), q = r / support, t = 1 - q;
      if (q >= 1) continue;
      sum += t * t * t * t * (1 + 4 * q);
      if (r == 0) continue;
      const double first = -20 * q * t * t * t / support,
                   second = (60 * q * t * t - 20 * t * t * t) / (support * support);
      const double a = k * k - l * l, b = 2 * k * l; /* x.e.x of the two strains; |e x|^2 = r^2 */
      along += second * a * a / r2 + first * (2 * r - a * a / (r2 * r));
      across += second * b * b / r2 + first * (2 * r - b * b / (r2 * r));
    }
  CHECK_CLOSE(kith_lattice_stiffness(KITH_LATTICE_CUBIC, KITH_KERNEL_wendland_c2, 20),
              fmin(along, across) / sum, 1e-5); /* fourth derivatives times 1e-6 */
#endif
}

static void jitter(void) {
  const double side[3] = {1, 1, 1};
  const struct kith_box box = box_of(0, side);
  struct kith_lattice_fit fit;
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 0.5));
  double sum = 0, square = 0, largest = 0;
  const int n = 20000;
  for (int id = 0; id < n; ++id) {
    double x[NDIM], again[NDIM], other[NDIM];
    for (int a = 0; a < NDIM; ++a) x[a] = again[a] = other[a] = 0.5;
    kith_lattice_jitter(&fit, 0.25, 7, id, x);
    kith_lattice_jitter(&fit, 0.25, 7, id, again);
    kith_lattice_jitter(&fit, 0.25, 8, id, other);
    for (int a = 0; a < NDIM; ++a) {
      CHECK(x[a] == again[a]);
      CHECK(x[a] != other[a]);
      sum += x[a] - 0.5;
      square += (x[a] - 0.5) * (x[a] - 0.5);
      largest = fmax(largest, fabs(x[a] - 0.5));
    }
  }
  CHECK(largest <= 0.25 && largest > 0.249);
  CHECK_CLOSE(sum / (n * NDIM), 0, 5 * 0.25 / sqrt(3.0 * n)); /* 5 standard deviations of the mean */
  CHECK_CLOSE(square / (n * NDIM), 0.25 * 0.25 / 3, 0.03 * 0.25 * 0.25); /* uniform: a^2 / 3; 10 deviations */
  double edge[NDIM];
  for (int id = 0; id < 100; ++id) {
    for (int a = 0; a < NDIM; ++a) edge[a] = id % 2 ? 0.99 : 0.01;
    kith_lattice_jitter(&fit, 0.25, 1, id, edge);
    for (int a = 0; a < NDIM; ++a) CHECK(edge[a] >= 0 && edge[a] <= 1);
  }
}

static void refusals(void) {
  const double side[3] = {1, 1, 1};
  const struct kith_box box = box_of(0, side);
  struct kith_lattice_fit fit;
  CHECK_STATUS(KITH_BAD_INPUT, kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 1e-12));
  CHECK_STATUS(KITH_BAD_INPUT, kith_lattice_fit(&fit, KITH_LATTICE_CUBIC, &box, 1e-300));
  CHECK_STATUS(NDIM == 2 ? KITH_BAD_INPUT : KITH_OK, kith_lattice_fit(&fit, KITH_LATTICE_FCC, &box, 0.1));
  CHECK_OK(kith_lattice_fit(&fit, KITH_LATTICE_BCC, &box, 50)); /* coarser than the box: one cell */
  for (int a = 0; a < NDIM; ++a) CHECK(fit.cells[a] == 1);
}

/* Spacings and supports scale with powers of two to the last bit, so everything that follows from them does,
 * too. */
static void roots_scale(void) {
  for (int k = -40; k <= 40; ++k) {
    const double v = 0.1 + 0.01 * abs(k), root = kith_root_dim(v);
    CHECK_CLOSE(kith_pow_dim(root), v, 1e-15 * NDIM * v);
    CHECK(kith_root_dim(ldexp(v, k * NDIM)) == ldexp(root, k));
  }
}

int main(void) {
  roots_scale();
  for (int k = 0; k < N_KINDS; ++k) {
    if (NDIM == 2 && every[k] == KITH_LATTICE_FCC) continue;
    ideal(every[k], 0.3);
    continues(every[k]);
    centered(every[k]);
  }
  mirrors();
  exact_counts();
  halves();
  balanced();
  glass();
  stiffness();
  jitter();
  refusals();
  return check_failed();
}
