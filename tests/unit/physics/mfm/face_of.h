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

static inline void one_point_face(const struct mfm_faces *f, kith_index i, kith_index j, double r,
                                  const double *d, double *area) {
  const double *support = f->nodes->support->f64, *matrix = f->matrix->f64;
  switch (f->kernel) { /* the kernel is a compile-time constant, as in the package */
#define X(name, ...)                                                                                       \
  case KITH_KERNEL_##name:                                                                                 \
    mfm_one_point_face(KITH_KERNEL_##name, r, d, 1 / support[i], matrix + (size_t)i * KITH_SYMMETRIC_SIZE, \
                       1 / support[j], matrix + (size_t)j * KITH_SYMMETRIC_SIZE, 1, area);                 \
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
  double d[NDIM], r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = f->nodes->position->f64[(size_t)j * NDIM + a] - f->nodes->position->f64[(size_t)i * NDIM + a];
    r2 += d[a] * d[a];
  }
  one_point_face(f, i, j, sqrt(r2), d, area);
}

#endif
