#include "physics/package.h"

#include "lib/core/family.h"

#define X(name) &kith_package_##name,
KITH_FAMILY(kith_package, KITH_PACKAGE_LIST(X))
#undef X

kith_status kith_package_init(struct kith_package *package) {
  struct kith_nodes *nodes = package->hydro->nodes;
  const struct kith_field_spec base = {"velocity_base", KITH_VECTOR, KITH_F64,
                                       KITH_WORK,       NULL,        "where the kick started"};
  const struct kith_field_spec expansion = {"expansion", KITH_SCALAR,          KITH_F64,
                                            KITH_STATE,  "VelocityDivergence", "div v"};
  const struct kith_field_spec slope = {"energy_slope", KITH_SCALAR, KITH_F64,
                                        KITH_STATE,     NULL,        "d(du/dt)/dt of a kick"};
  KITH_TRY(kith_nodes_field(nodes, &base, &package->velocity_base));
  KITH_TRY(kith_nodes_field(nodes, &expansion, &package->expansion));
  package->energy_slope = NULL;
  if (package->compatible) KITH_TRY(kith_nodes_field(nodes, &slope, &package->energy_slope));
  package->self_weight = kith_kernel_self_weight(package->kernel, package->neighbors);
  return package->ops->create(package);
}

void kith_package_clear(struct kith_package *package) {
  if (package->self != NULL) package->ops->destroy(package);
}
