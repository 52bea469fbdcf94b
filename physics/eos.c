/* The family of equations of state; members are in eos/. */
#include "physics/eos.h"
#include "lib/core/family.h"

#define X(name) &kith_eos_##name,
KITH_FAMILY(kith_eos, KITH_EOS_LIST(X))
#undef X
