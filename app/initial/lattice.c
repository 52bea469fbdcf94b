/* Lattices: cells that fit a box, their sites, jitter. */
#include "app/initial/lattice.h"

#include <math.h>
#include "app/initial/glass.h"
#include "lib/core/random.h"
#include "lib/core/vec.h"

/* Cells of the lattices: sides for unit volume of a node, and sites; n = 0: not in this dimension. A glass
 * has sites of its own. */
struct cell {
  double side[NDIM];
  int n;
  double site[4][NDIM];
};

static const struct cell cells[] = {
#if KITH_NDIM == 1
    [KITH_LATTICE_CUBIC... KITH_LATTICE_GLASS] = {{1}, 1, {{0.5}}}, /* evenly spaced, a glass is at rest */
#elif KITH_NDIM == 2
    [KITH_LATTICE_CUBIC] = {{1, 1}, 1, {{0.5, 0.5}}},
    [KITH_LATTICE_BCC] = {{1.4142135623730950488, 1.4142135623730950488}, 2, {{0.25, 0.25}, {0.75, 0.75}}},
    [KITH_LATTICE_HCP] = {{1.0745699318235418522, 1.8612097182041991979}, 2, {{0.25, 0.25}, {0.75, 0.75}}},
    [KITH_LATTICE_GLASS] = {{KITH_GLASS_SIDE, KITH_GLASS_SIDE}, KITH_GLASS_SITES, {{0}}},
#else
    [KITH_LATTICE_CUBIC] = {{1, 1, 1}, 1, {{0.5, 0.5, 0.5}}},
    [KITH_LATTICE_BCC] = {{1.2599210498948731648, 1.2599210498948731648, 1.2599210498948731648},
                          2,
                          {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.75}}},
    [KITH_LATTICE_FCC] = {{1.5874010519681994748, 1.5874010519681994748, 1.5874010519681994748},
                          4,
                          {{0.25, 0.25, 0.25}, {0.75, 0.75, 0.25}, {0.75, 0.25, 0.75}, {0.25, 0.75, 0.75}}},
    [KITH_LATTICE_HCP] =
        {{1.1224620483093729814, 1.9441612972396656054, 1.8329728493314701685},
         4,
         {{0.25, 5. / 6, 0.25}, {0.75, 1. / 3, 0.25}, {0.25, 1. / 6, 0.75}, {0.75, 2. / 3, 0.75}}},
    [KITH_LATTICE_GLASS] = {{KITH_GLASS_SIDE, KITH_GLASS_SIDE, KITH_GLASS_SIDE}, KITH_GLASS_SITES, {{0}}},
#endif
};

static double extent(const struct kith_box *box, int axis) {
  return box->upper[axis] - box->lower[axis];
}

/* Rounds a number of cells along an axis, at least 1. A half is rounded up even if round-off made it a little
 * less. More than KITH_MAX_SITES are refused later. */
static int64_t whole(double cells_wanted) {
  const double n = floor(cells_wanted * (1 + 1e-9) + 0.5), most = 1e18; /* fits an int64_t */
  return n < 1 ? 1 : n > most ? (int64_t)most : (int64_t)n;
}

static kith_status count_sites(struct kith_lattice_fit *fit) {
  double sites = cells[fit->kind].n, volume = 1;
  for (int a = 0; a < NDIM; ++a) {
    sites *= (double)fit->cells[a];
    volume *= extent(&fit->box, a);
  }
  if (sites > KITH_MAX_SITES)
    KITH_FAIL(BAD_INPUT, "%.6g nodes are more than the %.0e allowed", sites, (double)KITH_MAX_SITES);
  fit->sites = (int64_t)sites;
  fit->site_volume = volume / sites;
  return KITH_OK;
}

kith_status kith_lattice_fit(struct kith_lattice_fit *out, enum kith_lattice kind, const struct kith_box *box,
                             double spacing) {
  if (cells[kind].n == 0) KITH_FAIL(BAD_INPUT, "this lattice does not exist in %d-D", NDIM);
  out->kind = kind;
  out->site = NDIM > 1 && kind == KITH_LATTICE_GLASS ? kith_glass_sites() : cells[kind].site;
  out->box = *box;
  for (int a = 0; a < NDIM; ++a) {
    const double side = cells[kind].side[a] * spacing, wanted = extent(box, a) / side;
    out->cells[a] = whole(wanted);
    if (NDIM > 1 && kind == KITH_LATTICE_GLASS && fabs((double)out->cells[a] / wanted - 1) > 0.1)
      KITH_FAIL(
          BAD_INPUT,
          "lattice glass: a cell is %d spacings, %.4g, and the region has %.3g of them along %c: give it "
          "whole cells, to a tenth, or take another lattice",
          KITH_GLASS_SIDE, side, wanted, "xyz"[a]);
  }
  return count_sites(out);
}

/* The axis with more than twice the cells of any other, where those have at least 2; or -1. */
static int long_axis(const struct kith_lattice_fit *fit) {
  int longest = 0;
  for (int a = 1; a < NDIM; ++a)
    if (fit->cells[a] > fit->cells[longest]) longest = a;
  for (int a = 0; a < NDIM; ++a)
    if (a != longest && (fit->cells[a] < 2 || 2 * fit->cells[a] >= fit->cells[longest])) return -1;
  return longest;
}

kith_status kith_lattice_balance(struct kith_lattice_fit *fit, double volume) {
  const int axis = long_axis(fit);
  if (axis < 0) return KITH_OK;
  fit->cells[axis] = whole((double)fit->cells[axis] * fit->site_volume / volume);
  return count_sites(fit);
}

/* Measures places from the middle of the box, so that sites on both sides of it mirror each other exactly. */
void kith_lattice_site(const struct kith_lattice_fit *fit, int64_t site, double *x) {
  const int per_cell = cells[fit->kind].n;
  const double *offset = fit->site[site % per_cell];
  int64_t rest = site / per_cell;
  for (int a = NDIM - 1; a >= 0; --a) {
    const double n = (double)fit->cells[a], at = (double)(rest % fit->cells[a]) + offset[a];
    x[a] = 0.5 * (fit->box.lower[a] + fit->box.upper[a]) + extent(&fit->box, a) * ((2 * at - n) / (2 * n));
    rest /= fit->cells[a];
  }
}

void kith_lattice_jitter(const struct kith_lattice_fit *fit, double largest, uint64_t seed, int64_t id,
                         double *x) {
  for (int a = 0; a < NDIM; ++a) {
    x[a] += largest * kith_random(seed, id, a);
    if (x[a] < fit->box.lower[a]) x[a] = 2 * fit->box.lower[a] - x[a];
    if (x[a] > fit->box.upper[a]) x[a] = 2 * fit->box.upper[a] - x[a];
  }
}

/* A strain of exp(+-angle) along two axes, or, if `between`, along the directions halfway between them. */
struct shear {
  int axis[2];
  bool between;
  double angle;
};

static double sheared_r2(const struct shear *shear, const double *x) {
  const double u = x[shear->axis[0]], v = x[shear->axis[1]], grow = exp(shear->angle),
               c = 0.5 * (grow + 1 / grow), s = 0.5 * (grow - 1 / grow);
  const double p = shear->between ? c * u + s * v : grow * u, q = shear->between ? s * u + c * v : v / grow;
  double r2 = p * p + q * q;
  for (int a = 0; a < NDIM; ++a)
    if (a != shear->axis[0] && a != shear->axis[1]) r2 += x[a] * x[a];
  return r2;
}

/* The kernel sum at a site of a sheared lattice of spacing 1. */
static double sheared_sum(const struct cell *cell, enum kith_kernel kernel, double support,
                          const struct shear *shear) {
  double sum = 0;
  int reach[3] = {0, 0, 0};
  for (int a = 0; a < NDIM; ++a) reach[a] = 2 + (int)(support / cell->side[a]);
  for (int k = -reach[0]; k <= reach[0]; ++k)
    for (int l = -reach[1]; l <= reach[1]; ++l)
      for (int m = -reach[2]; m <= reach[2]; ++m)
        for (int site = 0; site < cell->n; ++site) {
          const int at[3] = {k, l, m};
          double x[NDIM], w, g;
          for (int a = 0; a < NDIM; ++a)
            x[a] = cell->side[a] * (at[a] + cell->site[site][a] - cell->site[0][a]);
          kith_kernel_value(kernel, sqrt(sheared_r2(shear, x)) / support, &w, &g);
          sum += w;
        }
  return sum;
}

double kith_lattice_stiffness(enum kith_lattice kind, enum kith_kernel kernel, double neighbors) {
  static const double angle = 1e-3; /* its square, 1e-6, is the error */
  double least = INFINITY;
  const struct cell *cell = &cells[kind];
  const double support = kith_root_dim(neighbors / kith_ball());
  if (cell->n == 0 || kind == KITH_LATTICE_GLASS) return INFINITY;
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < a; ++b)
      for (int between = 0; between < 2; ++between) {
        double sum[3];
        for (int k = 0; k < 3; ++k)
          sum[k] = sheared_sum(cell, kernel, support, &(struct shear){{b, a}, between == 1, (k - 1) * angle});
        least = KITH_MIN(least, (sum[0] - 2 * sum[1] + sum[2]) / (angle * angle * sum[1]));
      }
  return least;
}
