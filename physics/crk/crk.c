#include "physics/crk/crk.h"

/* What it does not have is refused, not ignored. */
static kith_status check(const struct kith_package *package) {
  if (package->viscosity == KITH_VISCOSITY_CULLEN_DEHNEN)
    KITH_FAIL(
        BAD_INPUT,
        "method.viscosity.name: package crk has none, monaghan and limited; cullen_dehnen is of package sph");
  if (package->balsara != KITH_BALSARA_NONE)
    KITH_FAIL(BAD_INPUT, "method.viscosity.balsara: package crk has no such factor; package sph has");
  if (package->conduction > 0)
    KITH_FAIL(BAD_INPUT, "method.conduction: package crk conducts no heat; package sph does");
  return KITH_OK;
}

static kith_status crk_create(struct kith_package *package) {
  struct kith_nodes *nodes = package->hydro->nodes;
  struct crk *crk = NULL;
  KITH_TRY(check(package));
  KITH_TRY(kith_resize(&crk, 0, 1, sizeof *crk));
  package->self = crk;
  const struct {
    struct kith_field_spec spec;
    struct kith_field **field;
  } table[] = {
      {{"kernel_scale", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "A of the corrected kernel"}, &crk->scale},
      {{"kernel_slope", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "C"}, &crk->slope},
      {{"kernel_scale_gradient", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dA + C"}, &crk->scale_gradient},
      {{"kernel_slope_gradient", KITH_TENSOR, KITH_F64, KITH_WORK, NULL, "dC_b/dx_c"}, &crk->slope_gradient},
      {{"shear", KITH_SYMMETRIC, KITH_F64, KITH_WORK, NULL, "symmetric part of dv_a/dx_b"}, &crk->shear},
  };
  const int wanted = package->viscosity == KITH_VISCOSITY_LIMITED ? 5 : 4;
  for (int k = 0; k < wanted; ++k) KITH_TRY(kith_nodes_field(nodes, &table[k].spec, table[k].field));
  return KITH_OK;
}

static void crk_destroy(struct kith_package *package) {
  kith_free(&package->self);
}

static struct kith_requirements crk_requirements(const struct kith_package *package) {
  return (struct kith_requirements){.rows = true, .pairs = package->traversal == KITH_TRAVERSE_PAIRS};
}

static kith_status crk_evaluate(struct kith_package *package, struct kith_connectivity *connectivity) {
  const struct kith_hydro *hydro = package->hydro;
  const struct crk *crk = package->self;
  const struct kith_density_wanted wanted = {.shear = crk->shear};
  KITH_TRY(kith_connectivity_fresh(connectivity, hydro->nodes));
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_package_post(package, 1, &(struct kith_field *){hydro->nodes->support});
  KITH_TRY(crk_moments(package, connectivity));
  kith_hydro_close(hydro);
  struct kith_field *const between[] = {hydro->density, hydro->pressure,     hydro->sound_speed,  crk->scale,
                                        crk->slope,     crk->scale_gradient, crk->slope_gradient, crk->shear};
  kith_package_post(package, crk->shear != NULL ? 8 : 7, between);
  return crk_pairs(package, connectivity);
}

const struct kith_package_ops kith_package_crk = {
    .name = "crk",
    .doc = "conservative reproducing kernels: linear fields exactly, forces and energy conserved",
    .create = crk_create,
    .destroy = crk_destroy,
    .requirements = crk_requirements,
    .evaluate = crk_evaluate,
};
