/* integrated.h - integrated faces: the second form of faces.h. */
#ifndef KITH_PHYSICS_MFM_INTEGRATED_H
#define KITH_PHYSICS_MFM_INTEGRATED_H

#include "physics/mfm/faces.h"

/* Areas of all pairs of the graph, which are those of the overlap. Supports of ghosts are refreshed.
 * Collective. */
kith_status mfm_faces_integrate(struct mfm_faces *faces, const struct kith_connectivity *connectivity);

#endif
