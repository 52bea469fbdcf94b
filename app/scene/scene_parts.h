/* scene_parts.h - the parts of a scene: their tables of parameters, and the functions that read them. Private
 * to app/scene/scene*.c. */
#ifndef KITH_APP_SCENE_SCENE_PARTS_H
#define KITH_APP_SCENE_SCENE_PARTS_H

#include "app/scene/params.h"
#include "app/scene/scene_data.h"

extern const struct kith_param kith_domain_params[], kith_boundaries_params[], kith_materials_params[];
extern const struct kith_param kith_potential_params[];
extern const struct kith_param kith_region_params[], kith_deposit_params[], kith_exact_params[];
extern const struct kith_param kith_picture_params[];
extern const struct kith_param kith_probe_params[], kith_contact_params[];

/* Each function reads the part at `node` into the scene; parts that it depends on were read before. */
kith_status kith_scene_domain(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_boundaries(struct kith_scene *scene, const struct kith_config_node *node);
/* Checks the external forces, gravity and potential, which were read before. */
kith_status kith_scene_forces(struct kith_scene *scene, const struct kith_config_node *root);
kith_status kith_scene_materials(struct kith_scene *scene, const struct kith_config_node *node);
/* Finds a material by the name that `node` gives. */
kith_status kith_scene_material(const struct kith_scene *scene, const struct kith_config_node *node,
                                int *material);
kith_status kith_scene_regions(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_deposits(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_probes(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_contacts(struct kith_scene *scene, const struct kith_config_node *node);
kith_status kith_scene_exact(struct kith_scene *scene, const struct kith_config_node *node);
/* Reads one field of a picture, or a list of them; node NULL: none. */
kith_status kith_scene_fields(const struct kith_scene *scene, const struct kith_config_node *node,
                              struct kith_picture_fields *fields);
kith_status kith_scene_picture(struct kith_scene *scene, const struct kith_config_node *node);
void kith_scene_boundaries_clear(struct kith_scene *scene);

#endif
