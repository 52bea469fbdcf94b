/* symmetry.h - what the nodes of a scene, as laid, show of its symmetry: taken from the nodes, not from the words of the scene. */
#ifndef KITH_APP_SYMMETRY_H
#define KITH_APP_SYMMETRY_H

#include "lib/core/vec.h"
#include "physics/hydro.h"

struct kith_symmetry {
  bool mirrored[NDIM]; /* the state is its own image in the middle plane of this axis */
  int dimension;       /* the state varies along the first so many axes only, and moves along them only; at least 1 */
};

/* Places to 1e-6 of the box, values to 1e-9. Mirrors: every node has an image of the same list, mass, energy and mirrored velocity. Dimension: the values of
 * nodes at the same place along the first axes agree; nodes that share such a place with no other (a jittered lattice) show nothing: NDIM.
 * O(n log n). */
kith_status kith_symmetry_find(struct kith_symmetry *symmetry, const struct kith_hydro *hydro,
                               const struct kith_box *box);

#endif
