/* closure.h - closed faces: the correction (2) of faces.h, solved by conjugate gradients. */
#ifndef KITH_PHYSICS_MFM_CLOSURE_H
#define KITH_PHYSICS_MFM_CLOSURE_H

#include "physics/mfm/faces.h"

/* Corrects the areas so that those of each node sum to zero. Collective; DIVERGED if the solver does. */
kith_status mfm_faces_close(struct mfm_faces *faces);

#endif
