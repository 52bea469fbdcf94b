/* dimension.h - the dimension of a scene, for what starts the program of that dimension. */
#ifndef KITH_APP_SCENE_DIMENSION_H
#define KITH_APP_SCENE_DIMENSION_H

#include "lib/core/base.h"

/* The row of the parameter, for this and for the scene's own table. */
#define KITH_DIMENSION_PARAM "dimension", KITH_PARAM_INTEGER, NULL, "[1, 3]", "number of dimensions"

/* Of the file with the overrides applied, without reading the rest. BAD_INPUT with one line. */
kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension);

#endif
