/* added_world.h - for tests: a world (sph_world.h) with packages that add to the rates of its hydro
 * package. */
#ifndef KITH_TEST_PHYSICS_ADDED_WORLD_H
#define KITH_TEST_PHYSICS_ADDED_WORLD_H

#include "tests/unit/physics/sph_world.h"

struct added {
  struct kith_package package;
  void *settings;
};

/* Appends a package to those of the world. It must come after the last change of w->package. */
static inline void added_attach(struct added *added, struct world *w, const char *name,
                                const char *assignments) {
  struct kith_package *last = &w->package;
  while (last->next != NULL) last = last->next;
  CHECK_OK(kith_settings_create(&added->settings, kith_family_member(kith_added_member, name), assignments));
  added->package = (struct kith_package){.ops = kith_added_find(name),
                                         .hydro = &w->hydro,
                                         .kernel = last->kernel,
                                         .neighbors = last->neighbors,
                                         .compatible = last->compatible,
                                         .settings = added->settings,
                                         .traversal = last->traversal};
  CHECK_OK(kith_package_init(&added->package));
  last->next = &added->package;
}

/* Removes all added packages. */
static inline void added_detach(struct world *w, int n, struct added *added) {
  w->package.next = NULL;
  for (int k = 0; k < n; ++k) {
    kith_package_clear(&added[k].package);
    kith_free(&added[k].settings);
  }
}

#endif
