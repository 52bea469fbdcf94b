/* lifecycle.h - the lifecycle of ghosts, searches and connectivity, in one function.
 *
 *   requirements -> nodes wrapped -> search radii -> nodes migrated, reordered -> ghosts -> neighbors ->
 *   connectivity -> cull -> patch -> ready
 *
 * Several ranks agree before nodes move and ghosts are made, before a second layer of ghosts if there is one,
 * and at the end.
 *
 * Search radii. R_i = (1 + skin + g_i) H_i + m_i, where g_i = dt (2 |div v| / d + dt |a| / H) is twice the
 * relative change of the support in a step (the last one, or the one ahead if that is longer) and what a
 * force may add to it, at most 0.1: a support that outgrows R_i costs a lifecycle. Supports of nodes that are
 * not active do not change: g_i = 0. For lists that must serve a step of several stages (integrator->ahead =
 * dt > 0) m_i covers the motion within it,
 *     m_i = 1.01 dt (w_i + max_k w_k),    w = |v - c| + dt |a| / 2,   at most H_i / 4,
 * with c the mean velocity along axes where a common drift is no displacement (policies/cover.h). Too little
 * costs a rebuild within the step, too much costs pairs. */
#ifndef KITH_INTEGRATOR_LIFECYCLE_H
#define KITH_INTEGRATOR_LIFECYCLE_H

#include "integrator/integrator.h"

/* Runs the lifecycle from the present positions. If integrator->holding, nodes are neither wrapped nor moved
 * to other ranks. If integrator->near.only, its nodes are far from all boundaries: only they are updated in
 * the search, and there are no ghosts. Collective. Failures of other ranks are returned by
 * kith_lifecycle_close, or by an evaluation of the packages if that follows at once
 * (kith_ranks_start_agree). */
kith_status kith_lifecycle(struct kith_integrator *integrator, enum kith_rebuild_reason reason);
/* Ends a lifecycle that returned OK: returns the failure of another rank; INTERNAL: nodes are lost.
 * Collective. */
kith_status kith_lifecycle_close(struct kith_integrator *integrator);

/* Sets R_i of the nodes that the present step or tick concerns (kith_near_node). Collective if
 * integrator->ahead > 0. */
void kith_lifecycle_search_radii(const struct kith_integrator *integrator);

/* Rebuilds the lists that were made from integrator->built, bitwise identical. The two fields (NDIM and 1
 * numbers a node) are overwritten. Collective. */
kith_status kith_lifecycle_remake(struct kith_integrator *integrator, struct kith_field *vector_scratch,
                                  struct kith_field *scalar_scratch);

#endif
