/* family.h - what every family shares: all members, and the one of a name.
 *
 *   #define X(name) &kith_eos_##name,
 *   KITH_FAMILY(kith_eos, KITH_EOS_LIST(X))
 *   #undef X
 *
 * defines kith_eos_all(), kith_eos_find(name) and kith_eos_member(k), which hides the family's type from code
 * that reads parameters of any family. The members are constants of type struct PREFIX_ops with at least
 *
 *   const char *name, *doc;
 *   const struct kith_param *params;   its own parameters (param.h), NULL: none
 *   size_t settings_size;              of the struct that they fill
 *
 * In names '-' and '_' are the same letter (choices.h). */
#ifndef KITH_CORE_FAMILY_H
#define KITH_CORE_FAMILY_H

#include <string.h>
#include "lib/core/choices.h"
#include "lib/core/param.h"

#define KITH_FAMILY(prefix, ...) KITH_FAMILY_OF(prefix, prefix##_ops, __VA_ARGS__)
/* For members of type struct TYPE, which two families share. */
#define KITH_FAMILY_OF(prefix, type, ...)                                   \
  const struct type *const *prefix##_all(void) {                            \
    static const struct type *const all[] = {__VA_ARGS__ NULL};             \
    return all;                                                             \
  }                                                                         \
  const struct type *prefix##_find(const char *name) {                      \
    for (const struct type *const *p = prefix##_all(); *p != NULL; ++p)     \
      if (kith_name_is((*p)->name, name, strlen(name))) return *p;          \
    return NULL;                                                            \
  }                                                                         \
  struct kith_member prefix##_member(int k) {                               \
    const struct type *m = prefix##_all()[k];                               \
    return m != NULL ? KITH_MEMBER(m) : (struct kith_member){.name = NULL}; \
  }

#endif
