/* materials.h - for tests: an equation of state with settings from "key=value" text, and its parameters by
 * key. */
#ifndef KITH_TESTS_MATERIALS_H
#define KITH_TESTS_MATERIALS_H

#include <string.h>
#include "physics/hydro.h"
#include "tests/check.h"

/* Creates a material. Equal settings are stored once and are never freed. Tabulated equations of state cannot
 * be created this way. */
static inline struct kith_material material_of(const char *eos, const char *assignments) {
  enum { MOST = 256 };
  static void *settings[MOST];
  static const struct kith_eos_ops *of[MOST];
  const struct kith_member member = kith_family_member(kith_eos_member, eos);
  void *made;
  int k = 0;
  CHECK_OK(kith_settings_create(&made, member, assignments));
  while (k < MOST - 1 && of[k] != NULL &&
         (of[k] != kith_eos_find(eos) || memcmp(settings[k], made, member.settings_size) != 0))
    ++k;
  CHECK(k < MOST - 1);
  if (of[k] != NULL)
    kith_free(&made);
  else
    of[k] = kith_eos_find(eos), settings[k] = made;
  return (struct kith_material){.eos = of[k], .settings = settings[k]};
}

/* Returns the value of a parameter; 0 if the equation of state has none of this name. */
static inline double material_value(const struct kith_material *material, const char *key) {
  const struct kith_param *param = kith_params_find(material->eos->params, key);
  return param == NULL ? 0 : *(const double *)((const char *)material->settings + param->offset);
}

#endif
