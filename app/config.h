/* config.h - a YAML file as a tree with line numbers, and typed reading with one clear message for what is wrong.
 *
 *   file.yaml:12: method.kernl: unknown key; did you mean 'kernel'?
 *   file.yaml:7: scheme.cfl: -1 is out of range (0, 1]
 *
 * Parsed by libyaml. Overrides "a.b.c=value" (value is YAML) are applied to the tree; their place reads "--set a.b.c".
 * Each read marks its node as known; kith_config_finish refuses what nobody has read. */
#ifndef KITH_APP_CONFIG_H
#define KITH_APP_CONFIG_H

#include "lib/core/base.h"

/* Where a value stands, for messages: view of the config's strings. */
struct kith_place {
  const char *file;
  int line;
};

#endif
