/* field.c - fields of pictures by their names in a scene. */
#include "app/output/pictures/field.h"

#include "lib/core/vec.h"

double kith_picture_value(const struct kith_picture_axes *axes, enum kith_picture_field field,
                          const double *x, double time, const struct kith_exact_state *s) {
  switch (field) {
    case KITH_PICTURE_DENSITY:
      return s->density;
    case KITH_PICTURE_PRESSURE:
      return s->pressure;
    case KITH_PICTURE_ENERGY:
      return s->energy;
    case KITH_PICTURE_VELOCITY:
      return axes->speed ? kith_norm(s->velocity)
                         : kith_exact_speed(axes->exact, axes->about, x, time, s->velocity);
    default: {
      const int axis = (int)field - KITH_PICTURE_VELOCITY_X;
      return axis < NDIM ? s->velocity[axis] : 0;
    }
  }
}

const char *kith_picture_label(const struct kith_picture_axes *axes, enum kith_picture_field field) {
  static const char *const label[] = {
#define X(name, word, label) label,
      KITH_PICTURE_FIELDS(X)
#undef X
  };
  const bool vortex = axes->exact != NULL && axes->exact->vortex;
  if (field != KITH_PICTURE_VELOCITY) return label[field];
  if (axes->about != NULL) return vortex ? "azimuthal velocity" : "radial velocity";
  return axes->speed ? "speed" : label[field];
}
