/* The family of schemes. */
#include "integrator/scheme.h"

#include "lib/core/family.h"

#define X(name) &kith_scheme_##name,
KITH_FAMILY(kith_scheme, KITH_SCHEME_LIST(X))
#undef X
