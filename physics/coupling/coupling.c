/* Package `coupling`: the fraction of force and heat that passes between two nodes. It has no rates: it fills
 * the pairwise field f_couple when lists are rebuilt, by (1) of connectivity.h, and the force pass multiplies
 * all forces and heats of pairs by it. Both ends have the same factor, so energy and momentum are conserved.
 *
 *   barrier    a wall of nodes (force.h) cuts the pairs across it, f = 0
 *   damage D   of a node: the fraction 1 - D passes; a region has D = 1 - porosity (1 - damage)
 *
 * A layer with damage D conducts heat, and drags by viscosity, as one with 1 - D times the coefficient:
 * factors act like resistances in series, f = n / sum 1 / (1 - D), over the nodes from one end to the other.
 * A layer of 2 or 10 spacings in 1-D (inputs/layer.yaml, porosity 0.05 to 1) passes 0.997 to 0.999 of the
 * heat that it should; with the two ends alone one of 2 spacings passes 1.025 at 0.05, with
 * (1 - D_i)(1 - D_j) one of 10 passes 0.58 at 0.25. Pressure passes in part, too: a gas at rest moves into a
 * damaged place until its pressure there is p / (1 - D). Densities and gradients ignore the factors. A porous
 * barrier (D < 1) stays a wall, and passes the fraction f of the pairs across it; it stores no heat. */
#include "physics/package.h"

struct coupling {
  const struct kith_field *damage; /* NULL: nothing but barriers */
};

static kith_status create(struct kith_package *package) {
  struct coupling *coupling = package->self;
  coupling->damage = kith_nodes_field_named(package->hydro->nodes, "damage");
  if (package->barrier == NULL && coupling->damage == NULL)
    KITH_FAIL(BAD_INPUT,
              "packages: coupling has nothing to couple: no region has barrier, porosity or damage");
  return KITH_OK;
}

static struct kith_requirements requirements(const struct kith_package *package) {
  const struct kith_field *damage = ((const struct coupling *)package->self)->damage;
  return (struct kith_requirements){.rows = true,
                                    .pairs = true,
                                    .intersection = true,
                                    .on_segment = true,
                                    .obstacles = damage != NULL ? damage : package->barrier,
                                    .barriers = package->barrier};
}

/* Fills f_couple. Thicknesses are in supports, of which a node spacing is a fraction. */
static kith_status couple(struct kith_package *package, struct kith_connectivity *connectivity) {
  const double spacings = kith_root_dim(package->neighbors / kith_ball());
  const struct coupling *coupling = package->self;
  const size_t before = connectivity->pairs.n;
  KITH_TRY(kith_connectivity_couple(
      connectivity, package->hydro->nodes,
      &(struct kith_coupling){.barrier = package->barrier != NULL ? package->barrier->u8 : NULL,
                              .damage = coupling->damage != NULL ? coupling->damage->f64 : NULL,
                              .thickness = (NDIM == 3 ? 0.72 : 0.51) / spacings}));
  kith_profile_count(package->profile, "cut", (double)(before - connectivity->pairs.n));
  return KITH_OK;
}

const struct kith_package_ops kith_package_coupling = {
    .name = "coupling",
    .doc = "barriers, porous layers and damage: a fraction of force and heat passes, none across a barrier",
    .self_size = sizeof(struct coupling),
    .create = create,
    .requirements = requirements,
    .couple = couple,
};
