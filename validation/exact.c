#include "validation/exact_parameters.h"

#include "lib/core/family.h"

#include <math.h>

#define X(name) &kith_exact_##name,
KITH_FAMILY(kith_exact, KITH_EXACT_LIST(X))
#undef X

kith_status kith_exact_require(bool holds, const char *member, const char *parameter, double value,
                               const char *range) {
  if (holds && isfinite(value)) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution %s: %s is %g, must be %s", member, parameter, value, range);
}

void kith_exact_destroy(void **self) {
  kith_free(self);
}
