#include "app/deposit.h"

#include <string.h>
#include "app/region.h"

/* Relative: distances this close are equal, so that a lattice's shells of nodes are never split by round-off.
 */
static const double close_by = 1e-9;

static double distance(const struct kith_deposit *deposit, const struct kith_scene *scene, const double *x) {
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    double d = x[a] - deposit->center[a];
    const struct kith_boundary_ops *ops = scene->boundary[a].lower;
    const double side = scene->domain.upper[a] - scene->domain.lower[a];
    if (ops && strcmp(ops->name, "periodic") == 0) d -= side * round(d / side);
    r2 += d * d;
  }
  return sqrt(r2);
}

static double cubic_spline(double q) {
  const double t = 2 - q;
  return q >= 2 ? 0 : q >= 1 ? 0.25 * t * t * t : 1 - q * q * (1.5 - 0.75 * q);
}

/* Least distance of a node, and the spacing there. */
static double nearest(const struct kith_deposit *deposit, const struct kith_scene *scene,
                      const struct kith_hydro *hydro, double *spacing) {
  double least = INFINITY;
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    const double r = distance(deposit, scene, hydro->nodes->position->f64 + i * NDIM);
    if (r >= least) continue;
    least = r;
    *spacing = pow(hydro->mass->f64[i] / hydro->density->f64[i], 1.0 / NDIM);
  }
  return least;
}

/* Radius of what is heated. */
static double reach(const struct kith_deposit *deposit, double least, double spacing) {
  if (deposit->shape == KITH_DEPOSIT_POINT) return least + close_by * spacing;
  if (deposit->radius > 0) return deposit->radius;
  return deposit->spacings * spacing * (deposit->shape == KITH_DEPOSIT_KERNEL ? 2 : 1);
}

static double weight(const struct kith_deposit *deposit, double r, double radius) {
  if (deposit->shape == KITH_DEPOSIT_KERNEL) return cubic_spline(2 * r / radius);
  return r <= radius * (1 + close_by) ? 1 : 0;
}

kith_status kith_deposit_add(const struct kith_deposit *deposit, const struct kith_scene *scene,
                             const struct kith_hydro *hydro) {
  const kith_index n = hydro->nodes->n_internal;
  const double *x = hydro->nodes->position->f64;
  double spacing = 0, sum = 0;
  const double least = nearest(deposit, scene, hydro, &spacing), radius = reach(deposit, least, spacing);
  for (kith_index i = 0; i < n; ++i)
    sum += hydro->mass->f64[i] * weight(deposit, distance(deposit, scene, x + i * NDIM), radius);
  if (!(sum > 0))
    return kith_place_fail(&deposit->place,
                           "energy: no node is within %g of its center; the nearest is at %g", radius, least);
  for (kith_index i = 0; i < n; ++i)
    hydro->energy->f64[i] +=
        deposit->energy * weight(deposit, distance(deposit, scene, x + i * NDIM), radius) / sum;
  return KITH_OK;
}
