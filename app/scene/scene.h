/* scene.h - a scene file, read and checked: what the rest of the program is built from.
 *
 * Each key is read in one place, by a row of a table (lib/core/param.h) with default, range and meaning; the
 * reference of a scene (kith list scene) and the error messages come from the same tables. Everything that
 * can be wrong in the file is found here, before anything runs, but for what needs nodes (app/initial).
 *
 * One file serves all dimensions: axes beyond NDIM are ignored, and any single value may be {1d: .., 2d: ..,
 * 3d: ..}. A key without a value (`skin:`, `--set skin=`) is as if it were not given. */
#ifndef KITH_APP_SCENE_SCENE_H
#define KITH_APP_SCENE_SCENE_H

#include <stdio.h>
#include "app/scene/scene_data.h"

/* Reads and checks a scene. overrides: "key=value". BAD_INPUT: one line with file:line, key, value,
 * allowed. */
kith_status kith_scene_read(struct kith_scene **out, const char *path, int n_overrides,
                            const char *const *overrides);
/* Reads a scene from memory; `name` stands for the file. */
kith_status kith_scene_parse(struct kith_scene **out, const char *name, const char *text, size_t length,
                             int n_overrides, const char *const *overrides);
void kith_scene_destroy(struct kith_scene **scene);
/* Checks that the scene can run to the time `until`. BAD_INPUT if a piston is through the domain before, or
 * if there would be more than 9998 snapshots. */
kith_status kith_scene_check_until(const struct kith_scene *scene, double until);
/* BAD_INPUT that names the first key of which `text`, the scene of a checkpoint, has another value. */
kith_status kith_scene_check_same(const struct kith_scene *scene, const char *text);
/* Writes the partitioner with its parameters, as kith_partition_create takes it. */
void kith_scene_partitioner(const struct kith_scene *scene, char *text, size_t size);
/* Prints every key with default, range and meaning, as commented YAML. */
void kith_scene_reference(FILE *file);

#endif
