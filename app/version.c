#include "app/version.h"

const char *kith_version(void) {
  return "0.1.0";
}
