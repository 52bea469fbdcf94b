/* Stand-ins for the families that a scene looks up by name. */
#include <string.h>
#include "boundaries/boundary.h"
#include "lib/neighbor/search.h"
static const struct kith_boundary_ops standin_reflecting = {.name = "reflecting"}, standin_periodic = {.name = "periodic"}, standin_constant = {.name = "constant"};
static const struct kith_search_ops standin_tree = {.name = "tree"}, standin_grid = {.name = "grid"}, standin_brute = {.name = "brute"};
const struct kith_boundary_ops *const *kith_boundary_all(void) {
  static const struct kith_boundary_ops *const all[] = {&standin_reflecting, &standin_periodic, &standin_constant, NULL};
  return all;
}
const struct kith_boundary_ops *kith_boundary_find(const char *name) {
  for (const struct kith_boundary_ops *const *p = kith_boundary_all(); *p != NULL; ++p)
    if (strcmp((*p)->name, name) == 0) return *p;
  return NULL;
}
const struct kith_search_ops *kith_search_find(const char *name) {
  static const struct kith_search_ops *const all[] = {&standin_tree, &standin_grid, &standin_brute, NULL};
  for (const struct kith_search_ops *const *p = all; *p != NULL; ++p)
    if (strcmp((*p)->name, name) == 0) return *p;
  return NULL;
}
