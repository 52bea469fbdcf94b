/* forms.h - model no more than a scene needs: cheaper forms of a scene, what each would cost, and what it gives up.
 *
 * Which forms there are follows from the state as laid (symmetry.h) and from the words of the scene:
 *   fewer dimensions   the state varies along the first axes only
 *   mirrors            the state is its own image: a half, a quarter, an octant, with its part of a blast's energy
 *   lists that last    the same forces from lists that are made again only when a node has moved through the skin
 *   one-point faces    no overlap, no ghost rows
 *   fewer neighbors    two thirds of them
 *   thermal energy     no second pass over the pairs
 * and at last all together that save and give up nothing. Ratios above 1 are shown too: that form does not pay here. Each is planned by a program of its own (matrix.h), with all of its pilots. */
#ifndef KITH_APP_FORMS_H
#define KITH_APP_FORMS_H

#include "app/model.h"
#include "app/options.h"

/* Prints the table. `seconds`: what the scene costs as it is. Forms that cannot be planned are left out. */
kith_status kith_forms_show(const struct kith_options *options, const struct kith_model *model, double until,
                            double seconds);

#endif
