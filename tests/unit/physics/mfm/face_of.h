/* face_of.h - for tests: the vector area of a face as package mfm computes it, in both forms. */
#ifndef KITH_TEST_PHYSICS_MFM_FACE_OF_H
#define KITH_TEST_PHYSICS_MFM_FACE_OF_H

#include <math.h>
#include "physics/mfm/faces.h"

/* The rows whose entries have faces. */
static inline const struct kith_rows *rows_of_faces(const struct mfm_faces *f,
                                                    const struct kith_connectivity *connectivity) {
  return f->form == MFM_FACES_INTEGRATED ? &f->graph.rows : &connectivity->rows;
}

static inline void one_point_part(const struct mfm_faces *f, kith_index k, double r, const double *d,
                                  double *part) {
  const double inverse = 1 / f->nodes->support->f64[k];
  const double *matrix = f->matrix->f64 + (size_t)k * KITH_SYMMETRIC_SIZE;
  switch (f->kernel) { /* the kernel is a compile-time constant, as in the package */
#define X(name, ...)                                                        \
  case KITH_KERNEL_##name:                                                  \
    mfm_one_point_part(KITH_KERNEL_##name, r, d, inverse, matrix, 1, part); \
    break;
    KITH_KERNEL_LIST(X)
#undef X
    default:
      break;
  }
}

/* The face from i to the node at entry e of its row. */
static inline void face_of(const struct mfm_faces *f, const struct kith_connectivity *connectivity,
                           kith_index i, size_t e, double *area) {
  const kith_index j = rows_of_faces(f, connectivity)->node[e];
  if (f->form == MFM_FACES_INTEGRATED) {
    const double *value = f->area->value + (size_t)f->graph.pairs.of_row[e] * NDIM;
    for (int a = 0; a < NDIM; ++a) area[a] = (j > i ? 1 : -1) * value[a];
    return;
  }
  double d[NDIM], other[NDIM], r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = f->nodes->position->f64[(size_t)j * NDIM + a] - f->nodes->position->f64[(size_t)i * NDIM + a];
    r2 += d[a] * d[a];
  }
  one_point_part(f, i, sqrt(r2), d, area);
  one_point_part(f, j, sqrt(r2), d, other);
  const double vi = pow(f->nodes->support->f64[i], NDIM), vj = pow(f->nodes->support->f64[j], NDIM);
  for (int a = 0; a < NDIM; ++a) /* no volume counts as more than 16 of the other */
    area[a] = fmin(vi, 16 * vj) / vi * area[a] + fmin(vj, 16 * vi) / vj * other[a];
}

#endif
