#include "physics/sph/sph.h"

#include <math.h>

static kith_status register_fields(struct kith_package *package, struct sph *sph) {
  struct kith_nodes *nodes = package->hydro->nodes;
  const bool limited = package->viscosity == KITH_VISCOSITY_LIMITED;
  const bool rising = package->viscosity == KITH_VISCOSITY_CULLEN_DEHNEN;
  const bool balsara = package->balsara != KITH_BALSARA_NONE;
  const struct {
    bool wanted;
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {true, {"excess", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "grad-h mass X"}, &sph->excess},
      {limited,
       {"shear", KITH_SYMMETRIC, KITH_F64, KITH_WORK, NULL, "symmetric part of dv_a/dx_b"},
       &sph->shear},
      {rising || balsara, {"curl", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "|curl v|"}, &sph->curl},
      {rising, {"compression", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "d(div v)/dt"}, &sph->compression},
      {rising,
       {"viscosity", KITH_SCALAR, KITH_F64, KITH_KEPT, "Viscosity", "strength of the viscosity"},
       &sph->strength},
      {rising || balsara,
       {"viscosity_factor", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "what multiplies the viscosity"},
       &sph->factor},
  };
  for (size_t k = 0; k < sizeof table / sizeof table[0]; ++k)
    if (table[k].wanted) KITH_TRY(kith_nodes_field(nodes, &table[k].spec, table[k].field));
  sph->full = sph->factor != NULL || package->conduction > 0;
  return KITH_OK;
}

static kith_status sph_create(struct kith_package *package) {
  struct sph *sph = NULL;
  KITH_TRY(kith_resize(&sph, 0, 1, sizeof *sph));
  package->self = sph;
  return register_fields(package, sph);
}

static void sph_destroy(struct kith_package *package) {
  kith_free(&package->self);
}

static struct kith_requirements sph_requirements(const struct kith_package *package) {
  return (struct kith_requirements){
      .rows = true, .pairs = package->traversal == KITH_TRAVERSE_PAIRS, .ghost_rows = package->recompute};
}

/* (6): the strength of node i, which was s when it was last evaluated. */
static double strength(const struct kith_package *package, kith_index i, double s) {
  const struct sph *sph = package->self;
  const double h = package->hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double c = package->hydro->sound_speed->f64[i], divergence = package->expansion->f64[i];
  const double d2 = divergence * divergence, curl = sph->curl->f64[i];
  const double rate = divergence < 0 ? fmax(0, -sph->compression->f64[i]) * d2 / (d2 + curl * curl) : 0;
  const double wanted = fmin(1, 10 * h * h * rate / fmax(c * c, 1e-300));
  if (wanted >= s) return wanted;
  const double signal = fmax(package->signal->f64[i], c);
  return wanted + (s - wanted) * exp(-0.1 * signal * package->interval / h);
}

static double balsara(const struct kith_package *package, kith_index i) {
  const struct sph *sph = package->self;
  const double h = package->hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double divergence = fabs(package->expansion->f64[i]);
  const double sum = divergence + sph->curl->f64[i] + 1e-4 * package->hydro->sound_speed->f64[i] / h;
  const double factor = sum > 0 ? divergence / sum : 1;
  return package->balsara == KITH_BALSARA_SQUARED ? factor * factor : factor;
}

/* What multiplies the viscosity of nodes begin .. end - 1. */
static void set_factors(struct kith_package *package, kith_index begin, kith_index end) {
  const struct sph *sph = package->self;
  if (sph->factor == NULL) return;
#pragma omp parallel for schedule(static)
  for (kith_index i = begin; i < end; ++i) {
    double factor = 1;
    if (sph->strength != NULL) factor = sph->strength->f64[i] = strength(package, i, sph->strength->f64[i]);
    if (package->balsara != KITH_BALSARA_NONE) factor *= balsara(package, i);
    sph->factor->f64[i] = factor;
  }
}

static kith_status sph_evaluate(struct kith_package *package, struct kith_connectivity *connectivity) {
  const struct kith_hydro *hydro = package->hydro;
  const struct sph *sph = package->self;
  const struct kith_density_wanted wanted = {
      .excess = sph->excess, .shear = sph->shear, .curl = sph->curl, .compression = sph->compression};
  KITH_TRY(kith_connectivity_fresh(connectivity, hydro->nodes));
  if (sph->compression != NULL) kith_package_post(package, 1, &(struct kith_field *){hydro->acceleration});
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_hydro_close(hydro);
  set_factors(package, 0, hydro->nodes->n_internal);
  struct kith_field *between[7] = {hydro->nodes->support, hydro->density, hydro->pressure, hydro->sound_speed,
                                   sph->excess};
  int n = 5;
  if (sph->shear != NULL) between[n++] = sph->shear;
  if (sph->factor != NULL) between[n++] = sph->factor;
  if (package->recompute) {
    kith_hydro_close_remote(hydro);
    set_factors(package, kith_nodes_first_remote(hydro->nodes), kith_nodes_count(hydro->nodes));
    kith_nodes_refresh_images(hydro->nodes, between, n);
  } else
    kith_package_post(package, n, between);
  return sph_pairs(package, connectivity);
}

const struct kith_package_ops kith_package_sph = {
    .name = "sph",
    .doc = "density-energy SPH with grad-h terms and artificial viscosity",
    .create = sph_create,
    .destroy = sph_destroy,
    .requirements = sph_requirements,
    .evaluate = sph_evaluate,
};
