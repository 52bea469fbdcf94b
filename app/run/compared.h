/* compared.h - the nodes of a run that exact solutions are compared with, that are measured and drawn. */
#ifndef KITH_APP_RUN_COMPARED_H
#define KITH_APP_RUN_COMPARED_H

#include "app/simulation/simulation.h"
#include "validation/measure.h"
#include "validation/norms.h"

/* Zero but for the simulation at first. */
struct kith_compared {
  struct kith_simulation *simulation; /* borrowed */
  struct kith_nodes *gas;             /* copy of this rank's nodes that are compared; NULL: all are */
};

/* Copies the nodes that are compared, if these are not all nodes: those behind the faces of inflows are left
 * out, and nodes that have left a periodic box since lists were made, or within a base step, are put back.
 * Collective. */
kith_status kith_compared_take(struct kith_compared *compared);
/* Frees the copy. */
void kith_compared_clear(struct kith_compared *compared);

/* View of these nodes, which has those of the other ranks, too; valid until they change. */
struct kith_profile_view kith_compared_view(const struct kith_compared *compared);

/* Takes a measure. start: what was measured then; NULL: this is the start, or an amplitude is wanted.
 * Collective. */
double kith_compared_measure(const struct kith_compared *compared, enum kith_measure which,
                             const double *start);

/* Draws a picture to the directory, in place of what steps need; a warning on stderr if it cannot be drawn.
 * frame: name of one picture of many; NULL: the last one. norms: NULL: not shown. Collective. */
void kith_compared_draw(const struct kith_compared *compared, const char *directory, const char *frame,
                        const struct kith_norms *norms);

#endif
