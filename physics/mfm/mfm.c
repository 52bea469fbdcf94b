#include "physics/mfm/mfm.h"

static kith_status mfm_create(struct kith_package *package) {
  struct kith_nodes *nodes = package->hydro->nodes;
  const struct kith_field_spec velocity = {"velocity_slope", KITH_TENSOR, KITH_F64,
                                           KITH_WORK,        NULL,        "dv_a/dx_b"};
  const struct kith_field_spec density = {"density_slope", KITH_VECTOR, KITH_F64,
                                          KITH_WORK,       NULL,        "d rho/dx"};
  const struct kith_field_spec pressure = {"pressure_slope", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, "dP/dx"};
  struct mfm *mfm = NULL;
  KITH_TRY(kith_resize(&mfm, 0, 1, sizeof *mfm));
  package->self = mfm;
  mfm->faces = (struct mfm_faces){.form = package->faces,
                                  .closed = package->closed,
                                  .nodes = nodes,
                                  .kernel = package->kernel,
                                  .neighbors = package->neighbors,
                                  .profile = package->profile};
  KITH_TRY(kith_nodes_field(nodes, &velocity, &mfm->velocity_slope));
  KITH_TRY(kith_nodes_field(nodes, &density, &mfm->density_slope));
  KITH_TRY(kith_nodes_field(nodes, &pressure, &mfm->pressure_slope));
  return mfm_faces_init(&mfm->faces);
}

static void mfm_destroy(struct kith_package *package) {
  struct mfm *mfm = package->self;
  mfm_faces_clear(&mfm->faces);
  kith_free(&package->self);
}

static struct kith_requirements mfm_requirements(const struct kith_package *package) {
  return mfm_faces_requirements(&((const struct mfm *)package->self)->faces);
}

static kith_status mfm_evaluate(struct kith_package *package, struct kith_connectivity *connectivity) {
  const struct kith_hydro *hydro = package->hydro;
  struct mfm *mfm = package->self;
  const struct kith_density_wanted wanted = {.gradient = mfm->velocity_slope};
  KITH_TRY(kith_connectivity_fresh(connectivity, hydro->nodes));
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_hydro_close(hydro);
  struct kith_field *const state[] = {hydro->nodes->support, hydro->density, hydro->pressure,
                                      hydro->sound_speed, mfm->velocity_slope};
  kith_package_post(package, 5, state);
  KITH_TRY(mfm_gradients(package, connectivity));
  struct kith_field *const slopes[] = {mfm->density_slope, mfm->pressure_slope, mfm->faces.matrix};
  kith_package_refresh(package, mfm->faces.matrix != NULL ? 3 : 2, slopes);
  mfm->faces.profile = package->profile;
  mfm->faces.barrier = package->barrier;
  KITH_TRY(mfm_faces_build(&mfm->faces, connectivity));
  return mfm_pairs(package);
}

static size_t mfm_bytes(const struct kith_package *package) {
  return mfm_faces_bytes(&((const struct mfm *)package->self)->faces);
}

const struct kith_package_ops kith_package_mfm = {
    .name = "mfm",
    .doc = "meshless finite mass: a Riemann solver on faces that move with the gas; no viscosity",
    .create = mfm_create,
    .destroy = mfm_destroy,
    .requirements = mfm_requirements,
    .dear = true,
    .evaluate = mfm_evaluate,
    .bytes = mfm_bytes,
};
