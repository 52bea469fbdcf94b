/* dimension.c - reads the one parameter that decides which program reads the rest. */
#include "app/scene/dimension.h"

#include "app/scene/params.h"

kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension) {
  static const struct kith_param param = {KITH_DIMENSION_PARAM, .size = sizeof(int)};
  struct kith_config *config;
  KITH_TRY(kith_config_read(&config, path));
  kith_status status = KITH_OK;
  for (int k = 0; k < n_overrides && status == KITH_OK; ++k)
    status = kith_config_override(config, overrides[k]);
  if (status == KITH_OK) status = kith_param_read(&param, config->root, dimension);
  kith_config_destroy(&config);
  return status;
}
