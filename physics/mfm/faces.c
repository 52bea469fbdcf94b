#include "physics/mfm/faces.h"

#include <math.h>
#include <string.h>
#include "lib/core/vec.h"

kith_status mfm_room(void *p, size_t *capacity, size_t count, size_t size) {
  if (count <= *capacity) return KITH_OK;
  *capacity = 0;
  KITH_TRY(kith_resize(p, 0, count + count / 16, size));
  *capacity = count + count / 16;
  return KITH_OK;
}

kith_status mfm_faces_init(struct mfm_faces *faces) {
  const struct kith_field_spec matrix = {"face_matrix", KITH_SYMMETRIC, KITH_F64,
                                         KITH_WORK,     NULL,           "V M^-1 of one-point faces"};
  const struct kith_field_spec quadrature = {
      "face_quadrature", KITH_SCALAR, KITH_F64, KITH_WORK, NULL, "sqrt(V) / s of integrated faces"};
  const struct kith_field_spec stretch = {"face_stretch", KITH_SCALAR, KITH_F64,
                                          KITH_WORK,      NULL,        "stretch of integrated faces, less 1"};
  const struct kith_field_spec shift = {"face_shift", KITH_VECTOR, KITH_F64,
                                        KITH_WORK,    NULL,        "what closes faces"};
  if (faces->form == KITH_FACES_ONE_POINT) KITH_TRY(kith_nodes_field(faces->nodes, &matrix, &faces->matrix));
  if (faces->form == KITH_FACES_INTEGRATED)
    KITH_TRY(kith_nodes_field(faces->nodes, &quadrature, &faces->quadrature));
  if (faces->form == KITH_FACES_INTEGRATED)
    KITH_TRY(kith_nodes_field(faces->nodes, &stretch, &faces->stretch));
  if (faces->closed) KITH_TRY(kith_nodes_field(faces->nodes, &shift, &faces->shift));
  return KITH_OK;
}

static size_t rows_bytes(const struct mfm_faces *f) {
  return f->numbered.capacity * sizeof *f->numbered.node + f->numbered.first_capacity * sizeof(size_t) +
         f->numbered.of_row_capacity * sizeof(uint32_t) + f->cursor_capacity * sizeof(uint32_t) +
         f->links.first_capacity * sizeof(size_t) +
         f->links.node_capacity * (sizeof(kith_index) + sizeof(double));
}

size_t mfm_faces_bytes(const struct mfm_faces *f) {
  return rows_bytes(f) + f->holders_capacity * sizeof(size_t) + f->holder_capacity * sizeof(kith_index) +
         (f->area_capacity + f->edge_capacity + f->value_capacity + f->weight_capacity + f->open_capacity +
          f->diagonal_capacity + f->scale_capacity) *
             sizeof(double);
}

void mfm_faces_clear(struct mfm_faces *f) {
  void *const owned[] = {
      &f->numbered.node, &f->numbered.first, &f->numbered.of_row, &f->edge,   &f->cursor, &f->area,
      &f->holders,       &f->holder,         &f->value,           &f->weight, &f->open,   &f->links.first,
      &f->links.node,    &f->links.weight,   &f->diagonal,        &f->scale};
  for (size_t k = 0; k < sizeof owned / sizeof owned[0]; ++k) kith_free(owned[k]);
  *f = (struct mfm_faces){0};
}

struct kith_requirements mfm_faces_requirements(const struct mfm_faces *faces) {
  const bool integrated = faces->form == KITH_FACES_INTEGRATED;
  return (struct kith_requirements){
      .rows = true, .pairs = !integrated, .overlap = integrated, .ghost_rows = integrated};
}

bool mfm_invert(const double *m, double *inverse) {
  const double good = 0.05; /* of the determinant of a ball's */
#if NDIM == 1
  const double det = m[0], ball = m[0];
  const double adjugate[] = {1};
#elif NDIM == 2
  const double det = m[0] * m[2] - m[1] * m[1], ball = 0.25 * (m[0] + m[2]) * (m[0] + m[2]);
  const double adjugate[] = {m[2], -m[1], m[0]};
#else
  const double mean = (m[0] + m[3] + m[5]) / 3, ball = mean * mean * mean;
  const double adjugate[] = {m[3] * m[5] - m[4] * m[4], m[2] * m[4] - m[1] * m[5], m[1] * m[4] - m[2] * m[3],
                             m[0] * m[5] - m[2] * m[2], m[1] * m[2] - m[0] * m[4], m[0] * m[3] - m[1] * m[1]};
  const double det = m[0] * adjugate[0] + m[1] * adjugate[1] + m[2] * adjugate[2];
#endif
  const bool regular = det > good * ball;
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) inverse[k] = regular ? adjugate[k] / det : 0;
  return regular;
}

/* --- which pairs have a face --- */

/* Numbers the pairs of internal nodes in overlap rows. As i ascends it meets the pairs of a lower j in their order: a cursor gives them. */
static kith_status number(struct mfm_faces *f, const struct kith_rows *rows, kith_index n) {
  struct kith_pairs *pairs = &f->numbered;
  pairs->canonical = false;
  pairs->starts = n;
  KITH_TRY(mfm_room(&pairs->first, &pairs->first_capacity, (size_t)n + 1, sizeof *pairs->first));
  KITH_TRY(mfm_room(&pairs->of_row, &pairs->of_row_capacity, rows->first[n], sizeof *pairs->of_row));
  KITH_TRY(mfm_room(&f->cursor, &f->cursor_capacity, (size_t)n, sizeof *f->cursor));
  if (rows->first[n] > UINT32_MAX)
    KITH_FAIL(UNSUPPORTED, "%zu faces: a process can number 2^31", rows->first[n] / 2);
  size_t p = 0;
  for (kith_index i = 0; i < n; ++i) {
    pairs->first[i] = f->cursor[i] = (uint32_t)p;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      pairs->of_row[e] = rows->node[e] < i ? f->cursor[rows->node[e]]++ : (uint32_t)p++;
  }
  pairs->first[n] = pairs->n = p;
  KITH_TRY(mfm_room(&pairs->node, &pairs->capacity, p, sizeof *pairs->node));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    const size_t count = pairs->first[i + 1] - pairs->first[i], start = rows->first[i + 1] - count;
    for (size_t k = 0; k < count; ++k) {
      pairs->node[pairs->first[i] + k][0] = i;
      pairs->node[pairs->first[i] + k][1] = rows->node[start + k];
    }
  }
  return KITH_OK;
}

/* All pairs of the overlap. */
static kith_status number_overlap(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  const struct kith_rows *rows = &connectivity->overlap;
  if (connectivity->canonical) return kith_pairs_canonical(&f->numbered, rows, f->nodes);
  return number(f, rows, f->nodes->n_internal);
}

static kith_status prepare(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  const bool fresh = f->area != NULL && f->graph.generation == connectivity->generation;
  const kith_index n = f->nodes->n_internal;
  f->graph.rows = f->form == KITH_FACES_INTEGRATED ? connectivity->overlap : connectivity->rows;
  f->graph.rows.n = n;
  if (f->form == KITH_FACES_ONE_POINT)
    f->graph.pairs = connectivity->pairs;
  else {
    if (!fresh) KITH_TRY(number_overlap(f, connectivity));
    f->graph.pairs = f->numbered;
  }
  f->graph.canonical = connectivity->canonical;
  f->graph.generation = connectivity->generation;
  f->graph.positions = connectivity->positions;
  f->graph.ghosts = connectivity->ghosts;
  f->graph.built = (struct kith_requirements){.rows = true, .pairs = true};
  return mfm_room(&f->area, &f->area_capacity, f->graph.pairs.n * NDIM, sizeof *f->area);
}

/* --- one-point --- */

/* The factor of x_j - x_i in the face of SPH, -V^2 C / H^(d + 2), without g. */
static inline double central(const struct mfm_faces *f, double inverse_support) {
  const double volume_h = kith_ball() / f->neighbors, h = 1 / inverse_support; /* V / H^d */
  return -kith_kernel_constant(f->kernel) * volume_h * volume_h * kith_pow_dim(h) * inverse_support *
         inverse_support;
}

KITH_INLINE void one_point_chunk(enum kith_kernel kernel, const struct mfm_faces *f, kith_index begin,
                                 kith_index end) {
  const double *restrict x = f->nodes->position->f64, *restrict h = f->nodes->support->f64;
  const double *restrict matrix = f->matrix->f64;
  const uint8_t *barrier = f->barrier != NULL ? f->barrier->u8 : NULL;
  for (kith_index i = begin; i < end; ++i) {
    const size_t first = f->graph.pairs.first[i], n = f->graph.pairs.first[i + 1] - first;
    const kith_index(*restrict pair)[2] = f->graph.pairs.node + first;
    double *restrict area = f->area + first * NDIM;
#pragma omp simd
    for (size_t k = 0; k < n; ++k) {
      const kith_index j = pair[k][1];
      double d[NDIM], r2 = 0, wi, gi, wj, gj;
      for (int a = 0; a < NDIM; ++a) {
        d[a] = x[j * NDIM + a] - x[i * NDIM + a];
        r2 += d[a] * d[a];
      }
      /* A barrier is the mirror of who looks at it: it has the volume and the matrix of the other end. */
      const kith_index li = barrier != NULL && barrier[i] ? j : i, lj = barrier != NULL && barrier[j] ? i : j;
      const double r = sqrt(r2), inverse_i = 1 / h[li], inverse_j = 1 / h[lj];
      kith_kernel_value(kernel, r * inverse_i, &wi, &gi);
      kith_kernel_value(kernel, r * inverse_j, &wj, &gj);
      const double *mi = matrix + li * KITH_SYMMETRIC_SIZE, *mj = matrix + lj * KITH_SYMMETRIC_SIZE;
      const double along =
          (mi[0] > 0 ? 0 : central(f, inverse_i) * gi) + (mj[0] > 0 ? 0 : central(f, inverse_j) * gj);
      double sum[NDIM];
      for (int a = 0; a < NDIM; ++a) sum[a] = along * d[a];
      for (int a = 0, m = 0; a < NDIM; ++a)
        for (int b = a; b < NDIM; ++b, ++m) {
          const double both = wi * mi[m] + wj * mj[m];
          sum[a] += both * d[b];
          if (b != a) sum[b] += both * d[a];
        }
      for (int a = 0; a < NDIM; ++a) area[k * NDIM + a] = sum[a];
    }
  }
}

#define X(name, ...)                                                                     \
  KITH_HOT static void one_point_##name(void *context, kith_index begin, kith_index end, \
                                        struct kith_scratch *s) {                        \
    (void)s;                                                                             \
    const struct mfm_faces *f = context;                                                 \
    one_point_chunk(KITH_KERNEL_##name, f, begin, end);                                  \
  }
KITH_KERNEL_LIST(X)
#undef X

static kith_status one_point(struct mfm_faces *f) {
  static const kith_chunk_pass chunk[] = {
#define X(name, ...) one_point_##name,
      KITH_KERNEL_LIST(X)
#undef X
  };
  return kith_traverse(f->graph.pairs.starts, chunk[f->kernel], f, 1, 0, NULL, f->profile);
}

kith_status mfm_faces_edges(struct mfm_faces *f) {
  const struct kith_rows *rows = &f->graph.rows;
  KITH_TRY(mfm_room(&f->edge, &f->edge_capacity, rows->first[rows->n] * NDIM, sizeof *f->edge));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < rows->n; ++i)
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const size_t p = f->graph.pairs.of_row[e];
      const bool starts = kith_pair_starts(&f->graph.pairs, p, i, rows->node[e]);
      for (int a = 0; a < NDIM; ++a)
        f->edge[e * NDIM + a] = starts ? f->area[p * NDIM + a] : -f->area[p * NDIM + a];
    }
  return KITH_OK;
}

kith_status mfm_faces_build(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  kith_profile_begin(f->profile, "faces");
  kith_status status = prepare(f, connectivity);
  if (status == KITH_OK)
    status = f->form == KITH_FACES_ONE_POINT ? one_point(f) : mfm_faces_integrate(f, connectivity);
  kith_profile_end(f->profile);
  KITH_TRY(status);
  if (!f->closed) return KITH_OK;
  kith_profile_begin(f->profile, "closure");
  status = mfm_faces_close(f);
  kith_profile_end(f->profile);
  return status;
}
