/* The key output.plot: true, false, or which picture; and the fields of any picture. */
#include "app/scene/scene_parts.h"
#include "lib/core/choices.h"

#include <math.h>

#define IN(member) KITH_INTO(struct kith_picture, member)
static const struct kith_param plane_params[] = {
    {"x", KITH_PARAM_NUMBER, "", "", "the plane is across x, at this x", IN(plane[0])},
    {"y", KITH_PARAM_NUMBER, "", "", "the plane is across y, at this y", IN(plane[1])},
    {"z", KITH_PARAM_NUMBER, "", "", "the plane is across z, at this z", IN(plane[2])},
    {0}};
const struct kith_param kith_picture_params[] = {
    {"kind", KITH_PARAM_CHOICE, "auto", KITH_PICTURE_KINDS(KITH_AS_LISTED_CHOICE),
     "auto: curves beside an exact solution, maps without one, both about a center", IN(kind)},
    {"field", KITH_PARAM_OTHER, "", KITH_PICTURE_FIELDS(KITH_AS_LISTED_CHOICE),
     "one or a list of up to 8; FIELD-error: its difference from the exact solution; maps show it "
     "in exact.window",
     .params = NULL},
    {"plane", KITH_PARAM_MAP, "", "",
     "plane of a slice, or line of sight of a map; none: z, through the center or the middle",
     KITH_BELOW(plane_params, MAP)},
    {"range", KITH_PARAM_INTERVAL, "", "", "range of the colors of the first map; none: that of its values",
     IN(range)},
    {"frames", KITH_PARAM_BOOL, "false", "", "frame_NNNN.png of each snapshot: a movie", IN(frames)},
    {0}};

#define WITH_ERROR(name, word, label) "|" #word "|" #word "-error"
static kith_status read_field(struct kith_picture_fields *fields, const struct kith_config_node *node) {
  static const struct kith_param field = {"field", KITH_PARAM_CHOICE,  NULL, KITH_PICTURE_FIELDS(WITH_ERROR),
                                          "",      .size = sizeof(int)};
  int choice;
  KITH_TRY(kith_param_value(&field, node, &choice));
  if (fields->n == KITH_PICTURE_PANELS)
    return kith_config_fail(node, NULL, "more than %d fields in a picture", KITH_PICTURE_PANELS);
  fields->panel[fields->n].field = (enum kith_picture_field)(choice / 2);
  fields->panel[fields->n++].error = choice % 2 == 1;
  return KITH_OK;
}

kith_status kith_scene_fields(const struct kith_scene *scene, const struct kith_config_node *node,
                              struct kith_picture_fields *fields) {
  const bool list = node != NULL && node->kind == KITH_CONFIG_LIST;
  if (node != NULL && !list) KITH_TRY(read_field(fields, node));
  for (const struct kith_config_node *k = list ? node->first : NULL; k != NULL; k = k->next)
    KITH_TRY(read_field(fields, k));
  for (int k = 0; k < fields->n; ++k)
    if (fields->panel[k].error && kith_config_at(scene->config, "exact") == NULL)
      return kith_config_fail(node, NULL, "an error, and the scene has no exact solution");
  return KITH_OK;
}

/* Refuses plane and colors for curves, and kinds that this dimension does not have, unless kind or dimension
 * was chosen in a later layer. */
static kith_status check_maps(const struct kith_picture *p, const struct kith_config_node *node,
                              const struct kith_config_node *dimension) {
  const bool maps = NDIM > 1 && p->kind != KITH_PICTURE_PROFILE && p->kind != KITH_PICTURE_RADIAL,
             plane = isfinite(p->plane[0]) || isfinite(p->plane[1]) || isfinite(p->plane[2]);
  const struct {
    bool idle;
    const char *key, *why;
  } rows[] = {
      {NDIM < 3 && p->kind == KITH_PICTURE_SLICE, "kind", "a slice is of a 3-D scene"},
      {NDIM < 2 && p->kind == KITH_PICTURE_MAP, "kind", "a map is of a 2-D or 3-D scene"},
      {plane && !(NDIM == 3 && maps), "plane", "means nothing but for a slice or a map of a 3-D scene"},
      {isfinite(p->range[0]) && !maps, "range", "means nothing without a map: 1-D and curves have none"}};
  for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k) {
    const struct kith_config_node *given = kith_config_child(node, rows[k].key);
    if (rows[k].idle && !kith_config_is_older(given, dimension) &&
        !kith_config_is_older(given, kith_config_child(node, "kind")))
      return kith_config_fail(given, NULL, "%s", rows[k].why);
  }
  return KITH_OK;
}

kith_status kith_scene_picture(struct kith_scene *scene, const struct kith_config_node *node) {
  static const struct kith_param plot = {"plot", KITH_PARAM_BOOL, "true", "", "", .size = sizeof(bool)};
  struct kith_picture *picture = &scene->output.picture;
  *picture = (struct kith_picture){.plane = {NAN, NAN, NAN}, .range = {NAN, NAN}};
  scene->output.plot = true;
  if (node == NULL) return KITH_OK;
  if (node->kind != KITH_CONFIG_MAP) return kith_param_value(&plot, node, &scene->output.plot);
  KITH_TRY(kith_params_read(kith_picture_params, node, picture));
  KITH_TRY(kith_scene_fields(scene, kith_config_child(node, "field"), &picture->fields));
  if (isfinite(picture->plane[0]) + isfinite(picture->plane[1]) + isfinite(picture->plane[2]) > 1)
    return kith_config_fail(kith_config_child(node, "plane"), NULL, "one axis, across which the plane is");
  return check_maps(picture, node, kith_config_at(scene->config, "dimension"));
}
