#include "validation/exact_parameters.h"

#include <math.h>

static const struct kith_exact_ops *const members[] = {
#define X(name) &kith_exact_##name,
    KITH_EXACT_LIST(X)
#undef X
        NULL};

/* Members' own names have no '_'. */
static bool same_name(const char *own, const char *asked) {
  while (*own != '\0' && *own == (*asked == '_' ? '-' : *asked)) ++own, ++asked;
  return *own == *asked;
}

const struct kith_exact_ops *kith_exact_find(const char *name) {
  const struct kith_exact_ops *const *member = members;
  while (*member != NULL && !same_name((*member)->name, name)) ++member;
  return *member;
}

const struct kith_exact_ops *const *kith_exact_all(void) {
  return members;
}

kith_status kith_exact_require(bool holds, const char *member, const char *parameter, double value,
                               const char *range) {
  if (holds && isfinite(value)) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution %s: %s is %g, must be %s", member, parameter, value, range);
}

void kith_exact_destroy(void **self) {
  kith_free(self);
}
