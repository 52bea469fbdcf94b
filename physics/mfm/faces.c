/* Faces between nodes: fields, requirements, memory, and what one-point faces need of a node. */
#include "physics/mfm/faces.h"

#include <math.h>
#include "lib/core/vec.h"

kith_status mfm_faces_init(struct mfm_faces *f) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  const struct kith_field_row fields[] = {
      {!integrated, KITH_SPEC(SYMMETRIC, WORK, "face_matrix", "V M^-1 of one-point faces"), &f->matrix},
      {integrated, KITH_SPEC(SCALAR, WORK, "face_quadrature", "sqrt(V) / s of integrated faces"),
       &f->quadrature},
      {integrated, KITH_SPEC(SCALAR, WORK, "face_stretch", "stretch of integrated faces, less 1"),
       &f->stretch},
      {0}};
  return kith_nodes_fields(f->nodes, fields);
}

void mfm_faces_clear(struct mfm_faces *f) {
  kith_rows_clear(&f->holders);
  kith_free(&f->value);
  *f = (struct mfm_faces){0};
}

struct kith_requirements mfm_faces_requirements(const struct mfm_faces *f) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  return (struct kith_requirements){
      .rows = true, .overlap = integrated, .overlap_pairs = integrated, .ghost_rows = integrated};
}

bool mfm_invert(const double *m, double *inverse) {
  return kith_invert_symmetric(m, 0.05 / kith_pow_dim(NDIM), inverse);
}

static const struct kith_pairwise_spec face_area = {"face_area", NDIM, false,
                                                    "vector area, from one end to the other"};

/* Makes the graph of integrated faces, and computes their areas. */
static kith_status areas(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  f->graph.rows = connectivity->overlap;
  f->graph.rows.n = f->nodes->n_internal;
  f->graph.pairs = connectivity->overlap_pairs;
  f->graph.canonical = connectivity->canonical;
  const kith_status status = kith_pairwise_prepare(&f->graph.pairs, &face_area, &f->area);
  KITH_TRY(kith_ranks_allreduce_status(f->nodes->ranks, status));
  return mfm_faces_integrate(f, connectivity);
}

kith_status mfm_faces_build(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  kith_status status;
  KITH_STAGE(status, f->profile, "faces", areas(f, connectivity));
  return status;
}
