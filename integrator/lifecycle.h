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
 * not active stay as they are: g_i = 0. For lists that
 * must serve a step of several stages (integrator->ahead = dt > 0) m_i covers the motion within it,
 *     m_i = 1.01 dt (w_i + max_k w_k),    w = |v - c| + dt |a| / 2,   at most H_i / 4,
 * with c the mean velocity along axes where a common drift is no displacement (policies/cover.h). Too little
 * costs a rebuild within the step, too much costs pairs. */
#ifndef KITH_INTEGRATOR_LIFECYCLE_H
#define KITH_INTEGRATOR_LIFECYCLE_H

#include "integrator/integrator.h"

/* Who requires what, and why: what the connectivity is built from. */
struct kith_demand {
  const char *who, *why;
  struct kith_requirements need;
};
enum { KITH_DEMANDS = 2 + KITH_ADDED_PACKAGES }; /* those without a package are zero */
void kith_lifecycle_demands(const struct kith_integrator *integrator,
                            struct kith_demand demand[KITH_DEMANDS]);

/* The whole of it, from the present positions. Where integrator->holding, nodes stay in their places. Where
 * integrator->near.only, these nodes are far from all boundaries: they alone are taken in anew, and there are
 * no ghosts. Collective. What became of other ranks is known when it is closed, or where an evaluation of the
 * packages follows at once, when that returns (kith_ranks_start_agree). */
kith_status kith_lifecycle(struct kith_integrator *integrator, enum kith_rebuild_reason reason);
/* After kith_lifecycle has returned OK: the failure of another rank. INTERNAL: nodes are lost. Collective. */
kith_status kith_lifecycle_close(struct kith_integrator *integrator);

/* Sets R_i of the nodes that integrator->near names. */
void kith_lifecycle_search_radii(const struct kith_integrator *integrator);

/* Rebuilds the lists that were made from integrator->built, bitwise identical. The two fields (NDIM and 1
 * numbers a node) are overwritten. Collective. */
kith_status kith_lifecycle_remake(struct kith_integrator *integrator, struct kith_field *vector_scratch,
                                  struct kith_field *scalar_scratch);

#endif
