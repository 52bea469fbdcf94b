/* field.h - what of a state a picture shows, and how it is called there. */
#ifndef KITH_APP_OUTPUT_PICTURES_FIELD_H
#define KITH_APP_OUTPUT_PICTURES_FIELD_H

#include "app/scene/picture.h"
#include "validation/exact/exact.h"

/* What a picture calls velocity. */
struct kith_picture_axes {
  const struct kith_exact_ops *exact; /* NULL: none */
  const double *center;               /* NULL: none */
  bool speed;                         /* the absolute value, not the component along x or about the center */
};

double kith_picture_value(const struct kith_picture_axes *axes, enum kith_picture_field field,
                          const double *x, const struct kith_exact_state *state);
const char *kith_picture_label(const struct kith_picture_axes *axes, enum kith_picture_field field);

#endif
