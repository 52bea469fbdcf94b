/* Weights of the nodes that a deposit heats. */
#include "app/initial/deposits.h"

#include <math.h>
#include "lib/comm/sum.h"

/* Relative difference below which distances are equal: round-off must not split a shell of lattice sites. */
static const double tolerance = 1e-9;

static double distance_from(const struct kith_deposit *deposit, const struct kith_scene *scene,
                            const struct kith_nodes *nodes, kith_index i) {
  return kith_scene_distance(scene, nodes->position->f64 + (size_t)i * NDIM, deposit->center, NULL);
}

static double cubic_spline(double q) {
  const double t = 2 - q;
  return q >= 2 ? 0 : q >= 1 ? 0.25 * t * t * t : 1 - q * q * (1.5 - 0.75 * q);
}

/* Returns the least distance of a gas node of any rank from the center. Sets *spacing to the spacing of this
 * node; if several are as near, to that of the node with the least id: their order does not matter. */
static double nearest(const struct kith_deposit *deposit, const struct kith_scene *scene,
                      const struct kith_hydro *hydro, double *spacing) {
  struct kith_ranks *ranks = hydro->nodes->ranks;
  struct {
    double r;
    int64_t id;
    double spacing;
  } node = {INFINITY, INT64_MAX, 0};
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    if (!kith_node_is_gas(hydro->nodes, i)) continue;
    const double r = distance_from(deposit, scene, hydro->nodes, i);
    const int64_t id = hydro->nodes->id->i64[i];
    if (!(r < node.r || (r == node.r && id < node.id))) continue;
    node.r = r;
    node.id = id;
    node.spacing = kith_root_dim(hydro->mass->f64[i] / hydro->density->f64[i]);
  }
  const struct kith_shared shared = {KITH_SHARE_LEAST, sizeof node / 8, &node};
  kith_ranks_agree(ranks, KITH_OK, 1, &shared);
  *spacing = node.spacing;
  return node.r;
}

static double heated_radius(const struct kith_deposit *deposit, double least, double spacing) {
  if (deposit->shape == KITH_DEPOSIT_POINT) return least + tolerance * spacing;
  if (deposit->radius > 0) return deposit->radius;
  return deposit->spacings * spacing * (deposit->shape == KITH_DEPOSIT_KERNEL ? 2 : 1);
}

/* The weight of a node of gas. */
static double weight(const struct kith_deposit *deposit, const struct kith_scene *scene,
                     const struct kith_nodes *nodes, kith_index i, double radius) {
  const double r = distance_from(deposit, scene, nodes, i);
  if (deposit->shape == KITH_DEPOSIT_KERNEL) return cubic_spline(2 * r / radius);
  return r <= radius * (1 + tolerance) ? 1 : 0;
}

static kith_status add_deposit(const struct kith_deposit *deposit, const struct kith_scene *scene,
                               const struct kith_hydro *hydro) {
  const struct kith_nodes *nodes = hydro->nodes;
  double spacing = 0;
  const double least = nearest(deposit, scene, hydro, &spacing),
               radius = heated_radius(deposit, least, spacing);
  if (isinf(least))
    return kith_config_fail(deposit->node, NULL, "no node takes it: all are frozen, or of barriers");
  struct kith_sum sum = {0}; /* of m w over the gas of all ranks */
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (kith_node_is_gas(nodes, i))
      kith_sum_add(&sum, hydro->mass->f64[i] * weight(deposit, scene, nodes, i, radius));
  kith_sum_ranks(nodes->ranks, &sum, 1);
  const double all = kith_sum_value(&sum);
  if (!(all > 0))
    return kith_config_fail(deposit->node, NULL, "no node is within %g of its center; the nearest is at %g",
                            radius, least);
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (kith_node_is_gas(nodes, i))
      hydro->energy->f64[i] += deposit->energy * weight(deposit, scene, nodes, i, radius) / all;
  return KITH_OK;
}

kith_status kith_deposits_add(const struct kith_scene *scene, struct kith_hydro *hydro, double time) {
  for (int k = 0; k < scene->n_deposits; ++k) {
    if (scene->deposit[k].time != time) continue;
    KITH_TRY(add_deposit(&scene->deposit[k], scene, hydro));
    if (time > 0) hydro->through.energy += scene->deposit[k].energy;
  }
  return KITH_OK;
}

double kith_deposits_next(const struct kith_scene *scene, double time) {
  double next = INFINITY;
  for (int k = 0; k < scene->n_deposits; ++k)
    if (scene->deposit[k].time > time) next = KITH_MIN(next, scene->deposit[k].time);
  return next;
}
