/* Blast energy: weights of the nodes around a center, and their sum over all ranks. */
#include "app/initial/deposit.h"

#include <stdlib.h>

/* Relative difference below which distances are equal: round-off must not split a shell of lattice sites. */
static const double tolerance = 1e-9;

static double distance(const struct kith_deposit *deposit, const struct kith_scene *scene, const double *x) {
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    double d = x[a] - deposit->center[a];
    const double side = scene->domain.upper[a] - scene->domain.lower[a];
    if (kith_boundary_wraps(scene->boundary[a].lower)) d -= side * round(d / side);
    r2 += d * d;
  }
  return sqrt(r2);
}

static double cubic_spline(double q) {
  const double t = 2 - q;
  return q >= 2 ? 0 : q >= 1 ? 0.25 * t * t * t : 1 - q * q * (1.5 - 0.75 * q);
}

/* Least distance of a node of any rank, and the spacing there. */
static double nearest(const struct kith_deposit *deposit, const struct kith_scene *scene,
                      const struct kith_hydro *hydro, double *spacing) {
  struct kith_ranks *ranks = hydro->nodes->ranks;
  double least = INFINITY;
  int64_t id = INT64_MAX;
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    const double r = distance(deposit, scene, hydro->nodes->position->f64 + i * NDIM);
    if (r >= least) continue;
    least = r;
    id = hydro->nodes->id->i64[i];
    *spacing = pow(hydro->mass->f64[i] / hydro->density->f64[i], 1.0 / NDIM);
  }
  kith_ranks_broadcast(ranks, kith_ranks_minloc(ranks, least, id), spacing, sizeof *spacing);
  kith_ranks_min(ranks, &least, 1);
  return least;
}

/* Radius of what is heated. */
static double heated_radius(const struct kith_deposit *deposit, double least, double spacing) {
  if (deposit->shape == KITH_DEPOSIT_POINT) return least + tolerance * spacing;
  if (deposit->radius > 0) return deposit->radius;
  return deposit->spacings * spacing * (deposit->shape == KITH_DEPOSIT_KERNEL ? 2 : 1);
}

static double weight(const struct kith_deposit *deposit, double r, double radius) {
  if (deposit->shape == KITH_DEPOSIT_KERNEL) return cubic_spline(2 * r / radius);
  return r <= radius * (1 + tolerance) ? 1 : 0;
}

struct term {
  int64_t id;
  double value;
};

static int by_id(const void *a, const void *b) {
  const int64_t p = ((const struct term *)a)->id, q = ((const struct term *)b)->id;
  return (p > q) - (p < q);
}

/* The sum of n terms of this rank and those of the others, in the order of ids: the same on any number of
 * ranks. */
static kith_status sum_by_id(struct kith_ranks *ranks, const struct term *mine, size_t n, double *sum) {
  char *bytes = NULL;
  size_t *part = NULL;
  const size_t size = (size_t)kith_ranks_size(ranks);
  kith_status status = kith_ranks_allreduce_status(ranks, kith_resize(&part, 0, size + 1, sizeof *part));
  if (status == KITH_OK) status = kith_ranks_gather(ranks, mine, n * sizeof *mine, &bytes, part);
  const size_t all = status == KITH_OK ? part[size] / sizeof *mine : 0;
  struct term *term = (struct term *)bytes;
  if (all > 1) qsort(term, all, sizeof *term, by_id);
  *sum = 0;
  for (size_t k = 0; k < all; ++k) *sum += term[k].value;
  kith_free(&part);
  kith_free(&bytes);
  return status;
}

/* sum m w over the nodes of all ranks. */
static kith_status sum_weights(const struct kith_deposit *deposit, const struct kith_scene *scene,
                               const struct kith_hydro *hydro, double radius, double *sum) {
  const struct kith_nodes *nodes = hydro->nodes;
  struct term *term = NULL;
  size_t n = 0;
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks,
                                       kith_resize(&term, 0, (size_t)nodes->n_internal, sizeof *term)));
  *sum = 0;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double w = weight(deposit, distance(deposit, scene, nodes->position->f64 + i * NDIM), radius);
    if (w > 0) term[n++] = (struct term){nodes->id->i64[i], hydro->mass->f64[i] * w};
    *sum += hydro->mass->f64[i] * w;
  }
  kith_status status = KITH_OK;
  if (nodes->ranks != NULL || nodes->image != NULL) status = sum_by_id(nodes->ranks, term, n, sum);
  kith_free(&term);
  return status;
}

static kith_status add(const struct kith_deposit *deposit, const struct kith_scene *scene,
                       const struct kith_hydro *hydro) {
  const kith_index n = hydro->nodes->n_internal;
  const double *x = hydro->nodes->position->f64;
  double spacing = 0, sum = 0;
  const double least = nearest(deposit, scene, hydro, &spacing),
               radius = heated_radius(deposit, least, spacing);
  KITH_TRY(sum_weights(deposit, scene, hydro, radius, &sum));
  if (!(sum > 0))
    KITH_FAIL_AT(&deposit->location, "energy: no node is within %g of its center; the nearest is at %g",
                 radius, least);
  for (kith_index i = 0; i < n; ++i)
    hydro->energy->f64[i] +=
        deposit->energy * weight(deposit, distance(deposit, scene, x + i * NDIM), radius) / sum;
  return KITH_OK;
}

kith_status kith_deposits_add(const struct kith_scene *scene, const struct kith_hydro *hydro) {
  for (int k = 0; k < scene->n_deposits; ++k) KITH_TRY(add(&scene->deposit[k], scene, hydro));
  return KITH_OK;
}
