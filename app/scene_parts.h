/* scene_parts.h - the parts that scene.c is read by: tables of keys and what reads them. Only for
 * app/scene*.c. */
#ifndef KITH_APP_SCENE_PARTS_H
#define KITH_APP_SCENE_PARTS_H

#include "app/keys.h"
#include "app/scene.h"

extern const struct kith_key kith_domain_keys[], kith_boundaries_keys[], kith_materials_keys[];
extern const struct kith_key kith_potential_keys[];
extern const struct kith_key kith_region_keys[], kith_deposit_keys[], kith_exact_keys[];

/* Each reads the part below `node` into the scene; what it rests on (domain, materials, ...) was read before.
 */
kith_status kith_scene_domain(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_boundaries(struct kith_scene *scene, const struct kith_config_node *node);
/* Forces from outside: gravity, whose numbers are there already, and potential. */
kith_status kith_scene_forces(struct kith_scene *scene, const struct kith_config_node *root);
kith_status kith_scene_materials(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_regions(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_deposits(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_exact(struct kith_scene *scene, const struct kith_config_node *node);
void kith_scene_regions_clear(struct kith_scene *scene);

/* The value of a constant expression; NaN if it depends on the place. */
double kith_constant_value(struct kith_expression *expression);

#endif
