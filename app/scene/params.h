/* params.h - reading the parameters of a table (lib/core/param.h) from a map of a scene.
 *
 * A map is checked against the table, keys that are not in it are refused, and the table is printed as the
 * reference of the scene. Any single value may also be given by dimension: {1d: 100, 2d: 40, 3d: 20}. */
#ifndef KITH_APP_SCENE_PARAMS_H
#define KITH_APP_SCENE_PARAMS_H

#include <stdio.h>
#include "app/scene/config.h"
#include "lib/core/param.h"

/* The row of the key `dimension`, which the scene's own table has too. kith_scene_dimension reads its value
 * from a file, with overrides applied, and nothing else: it decides which program reads the rest. */
#define KITH_DIMENSION_PARAM "dimension", KITH_PARAM_INTEGER, NULL, "[1, 3]", "number of dimensions"
kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension);

/* Reads all rows from a map into *base (zero where nothing was read before). map NULL: every default. What
 * *base owns stays, to be freed by its owner, also after a failure. With a row of kind MEMBER the parameters
 * of the chosen member are read too, over settings that are there already. Parameters of other members of the
 * family are refused, or, if the member was chosen in a later layer than they were given, dropped. */
kith_status kith_params_read(const struct kith_param *params, const struct kith_config_node *map, void *base);
/* BAD_INPUT unless it is a map; the message has the key that names a member, or, where there is none, all
 * keys. */
kith_status kith_params_want_map(const struct kith_param *params, const struct kith_config_node *node);
/* Reads one row from a map. */
kith_status kith_param_read(const struct kith_param *param, const struct kith_config_node *map, void *base);
/* Reads one value, which may be an entry of a list, as a row says. */
kith_status kith_param_value(const struct kith_param *param, const struct kith_config_node *node, void *into);

/* Compares a scene now with one then: BAD_INPUT names the first key that differs, with both values. '-' and
 * '_' in names are the same, and so are 16 and 16.0, a default and nothing; keys that are not state may
 * differ. */
kith_status kith_config_compare(const struct kith_param *params, const struct kith_config_node *now,
                                const struct kith_config_node *then);

/* Destroys the formulas that the struct at `base` (NULL: nothing) owns. */
void kith_params_clear_formulas(const struct kith_param *params, void *base);

/* Prints a table as commented YAML, which is itself a scene but for the required keys. `what` the keys are of
 * stands in the first line. */
void kith_params_reference(const struct kith_param *params, const char *what, FILE *file);

#endif
