/* Faces between nodes: which pairs have one, memory, one-point faces. */
#include "physics/mfm/faces.h"

#include <math.h>
#include "lib/core/vec.h"

kith_status mfm_faces_init(struct mfm_faces *f) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  const struct kith_field_row fields[] = {
      {!integrated,
       {"face_matrix", KITH_SYMMETRIC, KITH_F64, KITH_WORK, NULL, "V M^-1 of one-point faces"},
       &f->matrix},
      {integrated,
       {"face_quadrature", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "sqrt(V) / s of integrated faces"},
       &f->quadrature},
      {integrated,
       {"face_stretch", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "stretch of integrated faces, less 1"},
       &f->stretch},
      {0}};
  return kith_nodes_fields(f->nodes, fields);
}

size_t mfm_faces_bytes(const struct mfm_faces *f) {
  return kith_rows_bytes(&f->holders) + f->value_capacity * sizeof(double);
}

void mfm_faces_clear(struct mfm_faces *f) {
  kith_rows_clear(&f->holders);
  kith_free(&f->value);
  *f = (struct mfm_faces){0};
}

struct kith_requirements mfm_faces_requirements(const struct mfm_faces *f) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  return (struct kith_requirements){.rows = true,
                                    .pairs = !integrated,
                                    .overlap = integrated,
                                    .overlap_pairs = integrated,
                                    .ghost_rows = integrated};
}

bool mfm_invert(const double *m, double *inverse) {
  return kith_invert_symmetric(m, 0.05 / kith_pow_dim(NDIM), inverse);
}

/* --- one-point --- */

/* The factor of x_j - x_i in the face of SPH, -V^2 C / H^(d + 2), without g. */
static inline double central(const struct mfm_faces *f, double h, double inverse_h) {
  const double volume_h = kith_ball() / f->neighbors; /* V / H^d */
  return -kith_kernel_constant(f->kernel) * volume_h * volume_h * kith_pow_dim(h) * inverse_h * inverse_h;
}

/* `shifted` is a constant, so that loops without shifts do not know of them. */
KITH_INLINE void one_point_faces(enum kith_kernel kernel, const struct mfm_faces *f, kith_index begin,
                                 kith_index end, bool shifted) {
  const double *restrict x = f->nodes->position->f64, *restrict h = f->nodes->support->f64;
  const double *restrict matrix = f->matrix->f64;
  const uint8_t *barrier = f->barrier != NULL ? f->barrier->u8 : NULL;
  for (kith_index i = begin; i < end; ++i) {
    const size_t first = f->graph.pairs.first[i], n = f->graph.pairs.first[i + 1] - first;
    const kith_index(*restrict pair)[2] = f->graph.pairs.node + first;
    const uint16_t *restrict shift = shifted ? f->graph.pairs.shift + first : NULL;
    double(*by)[NDIM] = f->nodes->shifts.by, *restrict area = f->area->value + first * NDIM;
#pragma omp simd
    for (size_t k = 0; k < n; ++k) {
      const kith_index j = pair[k][1];
      double d[NDIM], r2 = 0, wi, gi, wj, gj;
      for (int a = 0; a < NDIM; ++a) {
        d[a] = x[j * NDIM + a] + (shifted ? by[shift[k]][a] : 0) - x[i * NDIM + a];
        r2 += d[a] * d[a];
      }
      /* A barrier is a mirror image of the other end: it has its volume and matrix. */
      const kith_index li = barrier != NULL && barrier[i] ? j : i, lj = barrier != NULL && barrier[j] ? i : j;
      const double r = sqrt(r2), inverse_i = 1 / h[li], inverse_j = 1 / h[lj];
      kith_kernel_value(kernel, r * inverse_i, &wi, &gi);
      kith_kernel_value(kernel, r * inverse_j, &wj, &gj);
      const double *mi = matrix + li * KITH_SYMMETRIC_SIZE, *mj = matrix + lj * KITH_SYMMETRIC_SIZE;
      const double along =
          (mi[0] > 0 ? 0 : central(f, h[li], inverse_i) * gi) +
          (mj[0] > 0 ? 0 : central(f, h[lj], inverse_j) * gj);
      double sum[NDIM];
      for (int a = 0; a < NDIM; ++a) sum[a] = along * d[a];
      for (int a = 0, m = 0; a < NDIM; ++a)
        for (int b = a; b < NDIM; ++b, ++m) {
          const double both = mfm_weight(wi, gi) * mi[m] + mfm_weight(wj, gj) * mj[m];
          sum[a] += both * d[b];
          if (b != a) sum[b] += both * d[a];
        }
      for (int a = 0; a < NDIM; ++a) area[k * NDIM + a] = sum[a];
    }
  }
}

KITH_INLINE void one_point_chunk(enum kith_kernel kernel, const struct mfm_faces *f, kith_index begin,
                                 kith_index end, struct kith_scratch *s) {
  (void)s;
  if (f->graph.pairs.shift != NULL)
    one_point_faces(kernel, f, begin, end, true);
  else
    one_point_faces(kernel, f, begin, end, false);
}

KITH_KERNEL_CHUNKS(one_point_chunk)

/* --- all of them --- */

static const struct kith_pairwise_spec face_area = {"face_area", NDIM, false,
                                                    "vector area, from one end to the other"};

/* The graph of the faces, and their areas. */
static kith_status areas(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  f->graph.rows = integrated ? connectivity->overlap : connectivity->rows;
  f->graph.rows.n = f->nodes->n_internal;
  f->graph.pairs = integrated ? connectivity->overlap_pairs : connectivity->pairs;
  f->graph.canonical = connectivity->canonical;
  const kith_status status = kith_pairwise_prepare(&f->graph.pairs, &face_area, &f->area);
  if (integrated) { /* among ranks */
    KITH_TRY(kith_ranks_allreduce_status(f->nodes->ranks, status));
    return mfm_faces_integrate(f, connectivity);
  }
  KITH_TRY(status);
  kith_profile_count(f->profile, "bytes", /* x, H, matrix; pairs and areas */
                     8.0 * (NDIM + 1 + KITH_SYMMETRIC_SIZE) * kith_nodes_count(f->nodes) +
                         8.0 * (1 + NDIM) * (double)f->graph.pairs.n);
  return kith_traverse(f->graph.pairs.starts, one_point_chunk_of[f->kernel], f, 1, 0, NULL, f->profile);
}

kith_status mfm_faces_build(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  kith_profile_begin(f->profile, "faces");
  const kith_status status = areas(f, connectivity);
  kith_profile_end(f->profile);
  return kith_ranks_allreduce_status(f->nodes->ranks, status);
}
