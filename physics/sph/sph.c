#include "physics/sph/sph.h"

#include <math.h>

static kith_status sph_create(struct kith_package *package) {
  struct kith_nodes *nodes = package->hydro->nodes;
  double w0, g0;
  kith_kernel_value(package->kernel, 0, &w0, &g0);
  const double least =
      1.2 * kith_ball() * kith_kernel_constant(package->kernel) * w0; /* the node alone gives 1 / 1.2 of it */
  if (!(package->neighbors >= least))
    KITH_FAIL(BAD_INPUT, "method.neighbors: %g is too few for kernel %s in %d-D, at least %.3g",
              package->neighbors, kith_kernel_facts[package->kernel].name, NDIM, least);
  struct sph *sph = NULL;
  KITH_TRY(kith_resize(&sph, 0, 1, sizeof *sph));
  package->self = sph;
  const struct kith_field_spec excess = {"excess", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "grad-h mass X"};
  const struct kith_field_spec signal = {"signal",   KITH_SCALAR, KITH_F64,
                                         KITH_STATE, NULL,        "signal speed of the Courant condition"};
  const struct kith_field_spec shear = {"shear",   KITH_SYMMETRIC, KITH_F64,
                                        KITH_WORK, NULL,           "symmetric part of dv_a/dx_b"};
  KITH_TRY(kith_nodes_field(nodes, &excess, &sph->excess));
  KITH_TRY(kith_nodes_field(nodes, &signal, &sph->signal));
  if (package->viscosity == KITH_VISCOSITY_LIMITED) KITH_TRY(kith_nodes_field(nodes, &shear, &sph->shear));
  return KITH_OK;
}

static void sph_destroy(struct kith_package *package) {
  struct sph *sph = package->self;
  kith_free(&sph->record);
  kith_pairwise_clear(&sph->pair);
  kith_free(&package->self);
}

static struct kith_requirements sph_requirements(const struct kith_package *package) {
  return (struct kith_requirements){.rows = true, .pairs = package->traversal == KITH_TRAVERSE_PAIRS};
}

static void refresh(struct kith_package *package, int n, struct kith_field *const *fields) {
  kith_profile_begin(package->profile, "refresh");
  kith_nodes_refresh_ghosts(package->hydro->nodes, fields, n);
  kith_profile_end(package->profile);
}

/* Masses never change, but nodes may come and go. */
static bool equal_masses(const struct kith_hydro *hydro) {
  const kith_index n = kith_nodes_count(hydro->nodes);
  const double *m = hydro->mass->f64;
  bool equal = true;
#pragma omp parallel for simd schedule(static) reduction(&& : equal)
  for (kith_index i = 0; i < n; ++i) equal = equal && m[i] == m[0];
  return equal;
}

static kith_status sph_evaluate(struct kith_package *package, struct kith_connectivity *connectivity) {
  const struct kith_hydro *hydro = package->hydro;
  struct kith_nodes *nodes = hydro->nodes;
  struct sph *sph = package->self;
  struct sph_pass pass = {.package = package,
                          .sph = sph,
                          .connectivity = connectivity,
                          .constant = kith_kernel_constant(package->kernel),
                          .equal_masses = equal_masses(hydro),
                          .spacings = pow(package->neighbors / kith_ball(), 1.0 / NDIM)};
  KITH_TRY(kith_connectivity_fresh(connectivity, nodes));
  KITH_TRY(sph_density(&pass));
  kith_hydro_close(hydro);
  struct kith_field *const between[] = {nodes->support,     hydro->density, hydro->pressure,
                                        hydro->sound_speed, sph->excess,    sph->shear};
  refresh(package, sph->shear != NULL ? 6 : 5, between);
  KITH_TRY(sph_pack(&pass));
  KITH_TRY(sph_force(&pass));
  if (!package->compatible) return KITH_OK;
  struct kith_field *const kicked[] = {package->velocity_base, hydro->acceleration};
  refresh(package, 2, kicked);
  return sph_work(&pass);
}

/* The vote of node i: Courant with h = 2 sigma, acceleration, compression, loss of energy. */
static struct kith_vote vote_of(const struct kith_package *package, kith_index i, double cfl) {
  const struct kith_hydro *hydro = package->hydro;
  const struct sph *sph = package->self;
  const double h = hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double a = kith_norm(hydro->acceleration->f64 + (size_t)i * NDIM),
               divergence = fabs(package->expansion->f64[i]);
  const double slope = package->energy_slope != NULL ? package->energy_slope->f64[i] : 0;
  const double u = hydro->energy->f64[i], cooling = -(hydro->energy_rate->f64[i] + package->kicked * slope);
  struct kith_vote vote = {cfl * h / sph->signal->f64[i], hydro->nodes->id->i64[i], "courant"};
  if (0.8 * cfl * sqrt(h / a) < vote.dt) vote.dt = 0.8 * cfl * sqrt(h / a), vote.reason = "acceleration";
  if (cfl / divergence < vote.dt) vote.dt = cfl / divergence, vote.reason = "compression";
  if (u > 0 && cooling > 0 && cfl * u / cooling < vote.dt)
    vote.dt = cfl * u / cooling, vote.reason = "cooling";
  return vote;
}

static struct kith_vote sph_vote(const struct kith_package *package, double cfl) {
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
#pragma omp critical(sph_vote) /* a minimum with ties by id: the order does not matter */
    if (mine.dt < best.dt || (mine.dt == best.dt && mine.node < best.node)) best = mine;
  }
  return best;
}

static size_t sph_pairwise_bytes(const struct kith_package *package) {
  const struct sph *sph = package->self;
  return sph->pair.capacity * sizeof *sph->pair.value;
}

static size_t sph_bytes(const struct kith_package *package) {
  const struct sph *sph = package->self;
  return sph->record_capacity * SPH_RECORD * sizeof *sph->record + sph_pairwise_bytes(package);
}

const struct kith_package_ops kith_package_sph = {
    .name = "sph",
    .doc =
        "density-energy SPH with grad-h terms; viscosity monaghan or limited; energy compatible or thermal",
    .create = sph_create,
    .destroy = sph_destroy,
    .requirements = sph_requirements,
    .evaluate = sph_evaluate,
    .vote = sph_vote,
    .bytes = sph_bytes,
    .pairwise_bytes = sph_pairwise_bytes,
};
