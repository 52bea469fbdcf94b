/* contacts.h - DIR/contacts.csv: after each step, of each pair of materials that a scene names, how their
 * nodes meet. The lists are managed neighbor lists (list.h) with nodes of one material as targets, frozen
 * ones not, and of the other as sources. */
#ifndef KITH_APP_OUTPUT_CONTACTS_H
#define KITH_APP_OUTPUT_CONTACTS_H

#include "app/simulation/simulation.h"

struct kith_contacts; /* opaque; NULL: a scene without contacts, which all functions accept */

/* Opens the table. BAD_FILE as in history.h. */
kith_status kith_contacts_create(struct kith_contacts **out, const struct kith_simulation *simulation,
                                 const char *directory, bool restarted);
/* Appends a row for each pair of materials: nodes of the first that have one of the other in their support or
 * lie in its, pairs of such nodes, their least distance, and the largest speed at which two approach. Then
 * how often the list was built and why it was now. Collective. */
kith_status kith_contacts_sample(struct kith_contacts *contacts);
/* Writes to the disk what is still in buffers. */
kith_status kith_contacts_sync(struct kith_contacts *contacts);
kith_status kith_contacts_destroy(struct kith_contacts **contacts);

#endif
