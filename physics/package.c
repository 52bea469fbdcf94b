/* What all packages share: fields, refreshing ghosts, the time-step limit. */
#include "physics/package.h"

#include <math.h>
#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_package_##name,
KITH_FAMILY(kith_package, KITH_PACKAGE_LIST(X))
KITH_FAMILY_OF(kith_added, kith_package_ops, KITH_ADDED_PACKAGE_LIST(X))
#undef X

/* Refuses too few neighbors: (1) of density.h has no solution if the node's own term exceeds the sum. */
static kith_status check_neighbors(const struct kith_package *package) {
  double w0, g0;
  kith_kernel_value(package->kernel, 0, &w0, &g0);
  const double least = 1.2 * kith_ball() * kith_kernel_constant(package->kernel) * w0; /* own term: 1 / 1.2 */
  if (!(package->neighbors >= least))
    KITH_FAIL(BAD_INPUT, "method.neighbors: %g is too few for kernel %s in %d-D, at least %.3g",
              package->neighbors, kith_kernel_facts[package->kernel].name, NDIM, least);
  return KITH_OK;
}

static const enum kith_limit limit_of_added[] = {
#define X(name) KITH_LIMIT_##name,
    KITH_ADDED_PACKAGE_LIST(X)
#undef X
};

struct kith_package_traits kith_package_traits(const struct kith_package_ops *ops, const void *settings) {
  return ops->traits != NULL ? ops->traits(settings) : (struct kith_package_traits){0};
}

kith_status kith_package_init(struct kith_package *package) {
  const bool external = kith_external_force_acts(&package->hydro->external_force);
  KITH_TRY(check_neighbors(package));
  KITH_TRY(kith_params_check(package->ops->params, package->ops->name, package->settings));
  const struct kith_field_row fields[] = {
      {true,
       {"velocity_divergence", KITH_SCALAR, KITH_F64, package->recompute ? KITH_KEPT : KITH_OWN_KEPT,
        "VelocityDivergence", "div v"},
       &package->velocity_divergence},
      {true, KITH_SPEC(SCALAR, OWN_KEPT, "signal", "signal speed of the Courant condition"),
       &package->signal},
      {external, KITH_SPEC(VECTOR, OWN_KEPT, "pair_acceleration", "dv/dt without the external force"),
       &package->pair_acceleration},
      {package->compatible,
       KITH_SPEC(SCALAR, OWN_KEPT, "energy_correction", "du/dt by the predicted velocity"),
       &package->energy_correction},
      {0}};
  package->pair_acceleration = package->hydro->acceleration;
  KITH_TRY(kith_nodes_fields(package->hydro->nodes, fields));
  for (int k = 0; k < KITH_ADDED_PACKAGES; ++k)
    if (kith_added_all()[k] == package->ops) package->limit = limit_of_added[k];
  package->self_weight = kith_kernel_self_weight(package->kernel, package->neighbors);
  if (package->ops->self_size > 0) KITH_TRY(kith_resize(&package->self, 0, 1, package->ops->self_size));
  return package->ops->create != NULL ? package->ops->create(package) : KITH_OK;
}

void kith_package_clear(struct kith_package *package) {
  if (package->self != NULL && package->ops->destroy != NULL) package->ops->destroy(package);
  KITH_FREE(&package->self, &package->border.chunk, &package->needed);
  package->border = (struct kith_border){0};
  package->needed_capacity = 0;
}

struct kith_requirements kith_package_requirements(const struct kith_package *package) {
  if (package->ops->requirements != NULL) return package->ops->requirements(package);
  return (struct kith_requirements){.rows = true, .ghost_rows = package->recompute};
}

kith_status kith_package_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                  const struct kith_kick *kick) {
  for (struct kith_package *p = package; p != NULL; p = p->next) {
    kith_status status;
    if (p->ops->evaluate == NULL) continue;
    KITH_STAGE(status, p->profile, p->ops->name, p->ops->evaluate(p, connectivity, kick));
    KITH_TRY(status);
    if (p == package) continue;
    package->pair_evaluations += p->pair_evaluations;
    p->pair_evaluations = 0;
  }
  return KITH_OK;
}

void kith_package_start_refresh(struct kith_package *package, int n, struct kith_field *const *fields) {
  kith_profile_begin(package->profile, "refresh");
  kith_halo_start_exchange(package->hydro->halo, package->hydro->nodes, fields, n);
  kith_profile_end(package->profile);
}

const char *kith_limit_name(enum kith_limit limit) {
  static const char *const names[] = {
#define X(name) #name,
      KITH_LIMIT_LIST(X)
#undef X
  };
  return names[limit];
}

/* A node moves no farther in a step than this many times cfl h, relative to gas and walls that it might meet.
 * Signal speeds are those of pairs, so cold gas that flies towards a wall, or towards other gas, has none of
 * that collision until it is there, and would be in the midst of it a step later. Of 90 runs of `kith stress
 * collision collision-block` 34 stopped without this limit, 10 with 3 and none with 2; it is lower since
 * single runs of other bodies stopped with 2. */
static const double farthest = 1.5;

/* Returns the square of the velocity of node i relative to what it might meet. */
static double speed2(const struct kith_hydro *hydro, kith_index i) {
  double sum = 0;
  for (size_t a = 0; a < NDIM; ++a) {
    const double v = hydro->velocity->f64[(size_t)i * NDIM + a] - hydro->rest_velocity[a];
    sum += v * v;
  }
  return sum;
}

static void shorten(struct kith_timestep_limit *limit, double dt, enum kith_limit reason) {
  if (dt < limit->dt) limit->dt = dt, limit->reason = reason;
}

struct kith_timestep_limit kith_package_limit_of_node(const struct kith_package *package, kith_index i,
                                                      double cfl) {
  const struct kith_hydro *hydro = package->hydro;
  const double h = hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double a = kith_norm(hydro->acceleration->f64 + (size_t)i * NDIM),
               divergence = fabs(package->velocity_divergence->f64[i]), speed = sqrt(speed2(hydro, i));
  const double u = hydro->energy->f64[i], cooling = -hydro->energy_rate->f64[i];
  struct kith_timestep_limit limit = {cfl * h / package->signal->f64[i], hydro->nodes->id->i64[i],
                                      KITH_LIMIT_courant};
  shorten(&limit, 0.8 * cfl * sqrt(h / a), KITH_LIMIT_acceleration);
  shorten(&limit, cfl / divergence, KITH_LIMIT_compression);
  shorten(&limit, farthest * cfl * h / speed, KITH_LIMIT_displacement);
  /* Only where the energy has to stay positive: an isothermal gas may lose all of it. */
  const bool limits = hydro->material[hydro->nodes->list->u8[i]].eos->energy_positive;
  if (limits && u > kith_hydro_energy_round_off(hydro, i)) {
    /* P |div v| / rho is what an expansion takes from u, or soon will. */
    const double work = KITH_MAX(hydro->pressure->f64[i], 0) * divergence;
    shorten(&limit, cfl * hydro->density->f64[i] * u / work, KITH_LIMIT_compression);
    if (cooling > 0) shorten(&limit, cfl * u / cooling, KITH_LIMIT_cooling);
  }
  const double added_cfl = package->added_cfl > 0 ? KITH_MIN(cfl, package->added_cfl) : cfl;
  for (const struct kith_package *p = package->next; p != NULL; p = p->next)
    if (p->ops->longest_step != NULL) shorten(&limit, added_cfl * p->ops->longest_step(p, i), p->limit);
  return limit;
}

/* Does node i surely allow more than dt? Tests the same conditions without roots and quotients, with room for
 * rounding, which is enough for most nodes. */
static bool allows_more(const struct kith_package *package, kith_index i, double cfl, double dt) {
  const struct kith_hydro *hydro = package->hydro;
  const double h = hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel), more = 1.0001 * dt,
               a = kith_norm(hydro->acceleration->f64 + (size_t)i * NDIM), u = hydro->energy->f64[i],
               divergence = fabs(package->velocity_divergence->f64[i]);
  return package->next == NULL && more * package->signal->f64[i] < cfl * h &&
         more * (more * a) < 0.64 * cfl * cfl * h && more * divergence < cfl &&
         more * more * speed2(hydro, i) < farthest * farthest * cfl * cfl * h * h &&
         (u <= 0 || (-more * hydro->energy_rate->f64[i] < cfl * u &&
                     more * divergence * hydro->pressure->f64[i] < cfl * u * hydro->density->f64[i]));
}

struct kith_timestep_limit kith_package_limit_of_rank(const struct kith_package *package, double cfl) {
  const kith_index n = package->hydro->nodes->n_internal;
  const struct kith_timestep_limit none = {INFINITY, -1, KITH_LIMIT_nothing};
  struct kith_timestep_limit best = none;
#pragma omp parallel
  {
    struct kith_timestep_limit mine = none; /* not best: another thread may be writing that already */
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < n; ++i) {
      if (allows_more(package, i, cfl, mine.dt)) continue;
      const struct kith_timestep_limit timestep_limit = kith_package_limit_of_node(package, i, cfl);
      if (timestep_limit.dt < mine.dt || (timestep_limit.dt == mine.dt && timestep_limit.node < mine.node))
        mine = timestep_limit;
    }
#pragma omp critical(kith_timestep_limit) /* a minimum with ties by id: the order does not matter */
    if (mine.dt < best.dt || (mine.dt == best.dt && mine.node < best.node)) best = mine;
  }
  return best;
}

struct kith_timestep_limit kith_package_timestep_limit(const struct kith_package *package, double cfl) {
  struct kith_timestep_limit limit = kith_package_limit_of_rank(package, cfl);
  const struct kith_shared shared = {KITH_SHARE_LEAST, KITH_LIMIT_WORDS, &limit};
  kith_ranks_agree(package->hydro->nodes->ranks, KITH_OK, 1, &shared);
  return limit;
}

size_t kith_package_bytes(const struct kith_package *package) {
  size_t bytes = 0;
  for (const struct kith_package *p = package; p != NULL; p = p->next) {
    bytes += p->ops->bytes != NULL ? p->ops->bytes(p) : 0;
    bytes += p->border.capacity + p->needed_capacity;
  }
  return bytes;
}
