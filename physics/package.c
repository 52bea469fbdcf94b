#include "physics/package.h"

#include <math.h>
#include <string.h>
#include "lib/core/family.h"

#define X(name) &kith_package_##name,
KITH_FAMILY(kith_package, KITH_PACKAGE_LIST(X))
#undef X

/* (1) of density.h has no solution if the node alone is too much. */
static kith_status check_neighbors(const struct kith_package *package) {
  double w0, g0;
  kith_kernel_value(package->kernel, 0, &w0, &g0);
  const double least =
      1.2 * kith_ball() * kith_kernel_constant(package->kernel) * w0; /* the node alone gives 1 / 1.2 of it */
  if (!(package->neighbors >= least))
    KITH_FAIL(BAD_INPUT, "method.neighbors: %g is too few for kernel %s in %d-D, at least %.3g",
              package->neighbors, kith_kernel_facts[package->kernel].name, NDIM, least);
  return KITH_OK;
}

kith_status kith_package_init(struct kith_package *package) {
  KITH_TRY(check_neighbors(package));
  struct kith_nodes *nodes = package->hydro->nodes;
  const struct kith_field_spec base = {"velocity_base", KITH_VELOCITY, KITH_F64,
                                       KITH_WORK,       NULL,          "where the kick started"};
  const struct kith_field_spec expansion = {"expansion", KITH_SCALAR,          KITH_F64,
                                            KITH_KEPT,   "VelocityDivergence", "div v"};
  const struct kith_field_spec slope = {"energy_slope", KITH_SCALAR, KITH_F64,
                                        KITH_KEPT,      NULL,        "d(du/dt)/dt of a kick"};
  KITH_TRY(kith_nodes_field(nodes, &base, &package->velocity_base));
  const struct kith_field_spec signal = {"signal",  KITH_SCALAR, KITH_F64,
                                         KITH_KEPT, NULL,        "signal speed of the Courant condition"};
  KITH_TRY(kith_nodes_field(nodes, &expansion, &package->expansion));
  KITH_TRY(kith_nodes_field(nodes, &signal, &package->signal));
  package->energy_slope = NULL;
  if (package->compatible) KITH_TRY(kith_nodes_field(nodes, &slope, &package->energy_slope));
  package->self_weight = kith_kernel_self_weight(package->kernel, package->neighbors);
  return package->ops->create(package);
}

void kith_package_clear(struct kith_package *package) {
  if (package->self != NULL) package->ops->destroy(package);
  kith_free(&package->border);
  package->border_capacity = 0;
  package->border_of = NULL;
  kith_free(&package->needed);
  package->needed_capacity = 0;
  kith_free(&package->record);
  package->record_capacity = 0;
  kith_pairwise_clear(&package->pair);
}

void kith_package_post(struct kith_package *package, int n, struct kith_field *const *fields) {
  kith_profile_begin(package->profile, "refresh");
  kith_nodes_post_ghosts(package->hydro->nodes, fields, n);
  kith_profile_end(package->profile);
}

void kith_package_refresh(struct kith_package *package, int n, struct kith_field *const *fields) {
  kith_profile_begin(package->profile, "refresh");
  kith_nodes_refresh_ghosts(package->hydro->nodes, fields, n);
  kith_profile_end(package->profile);
}

/* The vote of node i: Courant with h = 2 sigma, acceleration, compression, loss of energy. */
static struct kith_vote vote_of(const struct kith_package *package, kith_index i, double cfl) {
  const struct kith_hydro *hydro = package->hydro;
  const double h = hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double a = kith_norm(hydro->acceleration->f64 + (size_t)i * NDIM),
               divergence = fabs(package->expansion->f64[i]);
  const double slope = package->energy_slope != NULL ? package->energy_slope->f64[i] : 0;
  const double u = hydro->energy->f64[i], cooling = -(hydro->energy_rate->f64[i] + package->kicked * slope);
  struct kith_vote vote = {cfl * h / package->signal->f64[i], hydro->nodes->id->i64[i], "courant"};
  if (0.8 * cfl * sqrt(h / a) < vote.dt) vote.dt = 0.8 * cfl * sqrt(h / a), vote.reason = "acceleration";
  if (cfl / divergence < vote.dt) vote.dt = cfl / divergence, vote.reason = "compression";
  if (u > 0 && cooling > 0 && cfl * u / cooling < vote.dt)
    vote.dt = cfl * u / cooling, vote.reason = "cooling";
  return vote;
}

/* Reasons are constants of the program: between ranks they go as their numbers. */
static const char *const reasons[] = {"nothing", "courant", "acceleration", "compression", "cooling"};

/* The smallest vote of all ranks. */
static struct kith_vote vote_of_all(struct kith_ranks *ranks, struct kith_vote mine) {
  if (ranks == NULL) return mine;
  struct {
    double dt;
    int64_t node, reason;
  } ballot = {mine.dt, mine.node, 0};
  for (size_t k = 0; k < sizeof reasons / sizeof *reasons; ++k)
    if (strcmp(reasons[k], mine.reason) == 0) ballot.reason = (int64_t)k;
  kith_ranks_broadcast(ranks, kith_ranks_least(ranks, mine.dt, mine.node), &ballot, sizeof ballot);
  return (struct kith_vote){ballot.dt, ballot.node, reasons[ballot.reason]};
}

struct kith_vote kith_package_vote(const struct kith_package *package, double cfl) {
  const kith_index n = package->hydro->nodes->n_internal;
  struct kith_vote best = {INFINITY, -1, "nothing"};
#pragma omp parallel
  {
    struct kith_vote mine = best;
#pragma omp for schedule(static) nowait
    for (kith_index i = 0; i < n; ++i) {
      const struct kith_vote vote = vote_of(package, i, cfl);
      if (vote.dt < mine.dt || (vote.dt == mine.dt && vote.node < mine.node)) mine = vote;
    }
#pragma omp critical(kith_vote) /* a minimum with ties by id: the order does not matter */
    if (mine.dt < best.dt || (mine.dt == best.dt && mine.node < best.node)) best = mine;
  }
  return vote_of_all(package->hydro->nodes->ranks, best);
}

size_t kith_package_pairwise_bytes(const struct kith_package *package) {
  return package->pair.capacity * sizeof *package->pair.value;
}

size_t kith_package_bytes(const struct kith_package *package) {
  const size_t own = package->ops->bytes != NULL ? package->ops->bytes(package) : 0;
  return own + package->record_capacity * sizeof *package->record + kith_package_pairwise_bytes(package);
}
