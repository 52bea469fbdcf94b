/* Faces between nodes: their fields, and integrated faces.
 *
 * A_ij = sum_k (P_ik grad P_jk - P_jk grad P_ik) is a product of sparse matrices: row i is summed into one
 * accumulator per node, k by k over the nodes that the support of i holds, j over those whose support holds
 * k. */
#include "physics/mfm/faces.h"

#include <math.h>
#include <string.h>
#include "lib/core/keyed.h"
#include "lib/core/lanes.h"
#include "lib/core/vec.h"

kith_status kith_mfm_faces_init(struct mfm_faces *f) {
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

void kith_mfm_faces_clear(struct mfm_faces *f) {
  kith_rows_clear(&f->holders);
  kith_free(&f->value);
  *f = (struct mfm_faces){0};
}

struct kith_requirements kith_mfm_faces_requirements(const struct mfm_faces *f) {
  const bool integrated = f->form == MFM_FACES_INTEGRATED;
  return (struct kith_requirements){
      .rows = true, .overlap = integrated, .overlap_pairs = integrated, .ghost_rows = integrated};
}

/* --- integrated faces --- */

static const struct kith_pairwise_spec face_area = {"face_area", NDIM, false,
                                                    "vector area, from one end to the other"};

/* Bound of the stretch of faces less 1, (1) of faces.h: lattices need up to 0.09; nodes at the surface of a
 * gas, which have partners on one side only, would get far too much. */
static const double most_stretch = 0.25;

struct pass {
  struct mfm_faces *faces;
  const struct kith_connectivity *connectivity;
};

/* Returns C / H^d. */
static inline double height(const struct mfm_faces *f, double support) {
  return kith_kernel_constant(f->kernel) / kith_pow_dim(support);
}

/* Is k a node of the quadrature? A ghost that is no neighbor of an internal node is not: its row may be
 * incomplete. */
static inline bool is_quadrature_node(const struct mfm_faces *f, const struct kith_rows *rows, kith_index k) {
  for (size_t e = rows->first[k]; k >= f->nodes->n_internal && e < rows->first[k + 1]; ++e)
    if (rows->node[e] < f->nodes->n_internal) return true;
  return k < f->nodes->n_internal;
}

/* Computes sqrt(V) / s at x_k, and counts the holders of k, k among them. */
KITH_INLINE void partition_chunk(enum kith_kernel kernel, const struct pass *pass, kith_index begin,
                                 kith_index end, struct kith_scratch *s) {
  (void)s;
  struct mfm_faces *f = pass->faces;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const double *restrict h = f->nodes->support->f64;
  for (kith_index k = begin; k < end; ++k) {
    double w, g, d[NDIM];
    kith_kernel_value(kernel, 0, &w, &g);
    double sum = w * height(f, h[k]);
    size_t count = 1;
    for (size_t e = rows->first[k]; e < rows->first[k + 1]; ++e) {
      const kith_index j = rows->node[e];
      const double r2 = kith_entry_separation(f->nodes, rows, k, e, d);
      if (!(r2 < h[j] * h[j])) continue;
      kith_kernel_value(kernel, sqrt(r2) / h[j], &w, &g);
      sum += w * height(f, h[j]);
      ++count;
    }
    f->quadrature->f64[k] = sqrt(kith_ball() * kith_pow_dim(h[k]) / f->neighbors) / sum;
    f->holders.first[k + 1] = is_quadrature_node(f, rows, k) ? count : 0;
  }
}

/* Lists j, whose support holds k at the distance d, as holder `at` of k. */
KITH_INLINE void add_holder(enum kith_kernel kernel, const struct mfm_faces *f, kith_index k, kith_index j,
                            double r2, const double *restrict d, size_t at) {
  const double h = f->nodes->support->f64[j], c = f->quadrature->f64[k] * height(f, h);
  double w, g, *value = f->value + at * KITH_LANES;
  kith_kernel_value(kernel, sqrt(r2) / h, &w, &g);
  f->holders.node[at] = j;
  memset(value, 0, KITH_LANES * sizeof *value);
  value[0] = c * w;
  for (int a = 0; a < NDIM; ++a) value[1 + a] = -c * g * d[a] / (h * h);
}

/* Lists the holders of k and their values: k itself, then those of its row. */
KITH_INLINE void holders_chunk(enum kith_kernel kernel, const struct pass *pass, kith_index begin,
                               kith_index end, struct kith_scratch *s) {
  (void)s;
  struct mfm_faces *f = pass->faces;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const double *restrict h = f->nodes->support->f64;
  for (kith_index k = begin; k < end; ++k) {
    size_t at = f->holders.first[k];
    if (f->holders.first[k + 1] == at) continue;
    double d[NDIM] = {0};
    if (rows->shift != NULL) f->holders.shift[at] = (uint16_t)rows->zero;
    add_holder(kernel, f, k, k, 0, d, at++);
    for (size_t e = rows->first[k]; e < rows->first[k + 1]; ++e) {
      const kith_index j = rows->node[e];
      const double r2 = kith_entry_separation(f->nodes, rows, k, e, d);
      if (!(r2 < h[j] * h[j])) continue;
      if (rows->shift != NULL) f->holders.shift[at] = rows->shift[e];
      add_holder(kernel, f, k, j, r2, d, at++);
    }
  }
}

/* Returns the position of i among the holders of k, or of the first above it; they ascend except the first,
 * which is k. In canonical order they do not ascend: returns the position of i, or the end. */
KITH_INLINE size_t holder_position(const struct mfm_faces *f, bool canonical, kith_index k, kith_index i) {
  size_t from = f->holders.first[k] + 1;
  const size_t to = f->holders.first[k + 1];
  if (!canonical) return kith_lower_bound(f->holders.node, from, to, i);
  while (from < to && f->holders.node[from] != i) ++from;
  return from;
}

/* Adds what k contributes to the faces of i with the nodes above it; in canonical order, in which i may be a
 * ghost, with all nodes. */
KITH_INLINE void add_node(const struct mfm_faces *f, bool canonical, kith_index i, kith_index k,
                          kith_lanes *restrict sum) {
  const size_t self = f->holders.first[k], end = f->holders.first[k + 1];
  const kith_lanes *restrict value = (const kith_lanes *)f->value;
  if (self == end) return; /* no node of the quadrature */
  const size_t found = k == i ? self : holder_position(f, canonical, k, i);
  if (found == end || f->holders.node[found] != i) return; /* the support of i does not hold k */
  const kith_lanes mine = value[found];
  if (canonical || k > i) sum[k] += mine[0] * value[self] - value[self][0] * mine;
  for (size_t e = canonical ? self + 1 : k == i ? holder_position(f, false, k, i) : found + 1; e < end; ++e)
    sum[f->holders.node[e]] += mine[0] * value[e] - value[e][0] * mine;
}

/* Clears the sums that k has added to. Clearing the overlap row of i would not do: where pairs are excluded
 * it lacks some. */
KITH_INLINE void clear_node(const struct mfm_faces *f, kith_index k, kith_lanes *restrict sum) {
  sum[k] = (kith_lanes){0};
  for (size_t e = f->holders.first[k]; e < f->holders.first[k + 1]; ++e)
    sum[f->holders.node[e]] = (kith_lanes){0};
}

/* Computes the faces of pairs that start at i. In canonical order all quadrature nodes of both supports are
 * on this rank and in order, whether i is internal or a ghost. */
KITH_INLINE void product_chunk(const struct pass *pass, bool canonical, kith_index begin, kith_index end,
                               struct kith_scratch *s) {
  const struct mfm_faces *f = pass->faces;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const struct kith_pairs *pairs = &f->graph.pairs;
  kith_lanes *sum = (kith_lanes *)s->lane; /* sum of each node; 0 between rows */
  for (kith_index i = begin; i < end; ++i) {
    if (pairs->first[i] == pairs->first[i + 1]) continue;
    add_node(f, canonical, i, i, sum);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      add_node(f, canonical, i, rows->node[e], sum);
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p)
      for (int a = 0; a < NDIM; ++a) f->area->value[p * NDIM + a] = sum[pairs->node[p][1]][1 + a];
    clear_node(f, i, sum);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) clear_node(f, rows->node[e], sum);
  }
}

/* --- faces where images are shifts, not ghosts: each has a sum of its own --- */

/* The sums of the overlap row of i, by (node, shift). */
struct image_sums {
  size_t n;
  uint64_t *key; /* [n] ascending */
  kith_lanes *sum;
};

static uint64_t image_key(kith_index node, int shift) {
  return (uint64_t)node << 16 | (uint64_t)shift;
}

/* Returns where the sum of (node, shift) is; n if it has none: rounding may leave out a node at the edge of
 * the support. */
static size_t image_position(const struct image_sums *sums, kith_index node, int shift) {
  const uint64_t key = image_key(node, shift);
  const kith_index n = (kith_index)sums->n, at = kith_key_bound(sums->key, sizeof key, 0, n, key);
  return at < n && sums->key[at] == key ? (size_t)at : sums->n;
}

/* Adds what the image `by` of k contributes to the faces of i. */
static void add_image(const struct mfm_faces *f, kith_index i, kith_index k, int by,
                      const struct image_sums *sums) {
  const struct kith_rows *holders = &f->holders;
  const size_t self = holders->first[k], end = holders->first[k + 1];
  const kith_lanes *restrict value = (const kith_lanes *)f->value;
  const int zero = holders->zero;
  size_t found = self;
  while (found < end && (holders->node[found] != i || holders->shift[found] != 2 * zero - by)) ++found;
  if (found == end) return; /* the support of i does not hold k, or k is no node of the quadrature */
  const kith_lanes mine = value[found];
  for (size_t e = self; e < end; ++e) {
    const size_t at = image_position(sums, holders->node[e], holders->shift[e] + by - zero);
    if (at < sums->n) sums->sum[at] += mine[0] * value[e] - value[e][0] * mine; /* i itself has no sum */
  }
}

static void image_product(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct pass *pass = context;
  const struct mfm_faces *f = pass->faces;
  const struct kith_rows *rows = &pass->connectivity->rows, *overlap = &pass->connectivity->overlap;
  const struct kith_pairs *pairs = &f->graph.pairs;
  uint64_t *key[2];
  for (int k = 0; k < 2; ++k) key[k] = (uint64_t *)kith_scratch_lane(s, KITH_LANES + k);
  for (kith_index i = begin; i < end; ++i) {
    if (pairs->first[i] == pairs->first[i + 1]) continue;
    const size_t first = overlap->first[i];
    struct image_sums sums = {.n = overlap->first[i + 1] - first, .sum = (kith_lanes *)s->lane};
    memset(sums.sum, 0, sums.n * sizeof *sums.sum);
    for (size_t k = 0; k < sums.n; ++k)
      key[0][k] = image_key(overlap->node[first + k], overlap->shift[first + k]);
    sums.key = kith_keys_sort(key[0], key[1], sums.n);
    add_image(f, i, i, rows->zero, &sums);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
      add_image(f, i, rows->node[e], rows->shift[e], &sums);
    for (size_t p = pairs->first[i]; p < pairs->first[i + 1]; ++p) {
      const size_t at = image_position(&sums, pairs->node[p][1], pairs->shift[p]);
      for (int a = 0; a < NDIM; ++a) f->area->value[p * NDIM + a] = sums.sum[at][1 + a];
    }
  }
}

/* --- stretching --- */

/* Sets the stretch of the faces of i, less 1, by which the trace of sum A (x_j - x_i) is that of 2 V. */
static void stretch_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct pass *pass = context;
  const struct mfm_faces *f = pass->faces;
  const struct kith_rows *rows = &f->graph.rows;
  const double *h = f->nodes->support->f64;
  (void)s;
  for (kith_index i = begin; i < end; ++i) {
    double trace = 0;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const size_t p = f->graph.pairs.of_row[e];
      double d[NDIM];
      kith_entry_separation(f->nodes, rows, i, e, d);
      const double sign = kith_pair_starts(&f->graph, i, e) ? 1 : -1, *area = f->area->value + p * NDIM;
      for (int a = 0; a < NDIM; ++a) trace += sign * area[a] * d[a];
    }
    const double wanted = 2 * NDIM * kith_ball() * kith_pow_dim(h[i]) / f->neighbors;
    f->stretch->f64[i] = KITH_MIN(KITH_MAX(wanted / trace, 1 - most_stretch), 1 + most_stretch) - 1;
  }
}

/* Stretches the faces. A frozen node has no rates, and so no sum of its faces: it takes the stretch of its
 * partner. */
static void stretch(struct mfm_faces *f) {
  kith_halo_refresh(f->halo, f->nodes, &f->stretch, 1);
#pragma omp parallel for schedule(static)
  for (size_t p = 0; p < f->graph.pairs.n; ++p) {
    const kith_index *pair = f->graph.pairs.node[p];
    double more = 0;
    for (int end = 0; end < 2; ++end)
      more += 0.5 * f->stretch->f64[pair[kith_node_is_frozen(f->nodes, pair[end]) ? 1 - end : end]];
    for (int a = 0; a < NDIM; ++a) f->area->value[p * NDIM + a] *= 1 + more;
  }
}

KITH_KERNEL_CHUNKS(partition_chunk)
KITH_KERNEL_CHUNKS(holders_chunk)

KITH_HOT static void product(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct pass *pass = context;
  if (pass->connectivity->canonical)
    product_chunk(pass, true, begin, end, s);
  else
    product_chunk(pass, false, begin, end, s);
}

/* Refreshes the quadrature of ghosts. Every rank has all frozen nodes, but not the rows of all: what matters
 * of them and their images is computed here, as the control of an image may be far from the gas of this
 * rank. */
static void refresh_quadrature(struct pass *pass) {
  struct mfm_faces *f = pass->faces;
  kith_halo_refresh(f->halo, f->nodes, &f->quadrature, 1);
  for (kith_index k = f->nodes->n_internal; k < pass->connectivity->rows.n; ++k)
    if (kith_node_is_frozen(f->nodes, k)) partition_chunk_of[f->kernel](pass, k, k + 1, NULL);
}

/* Makes the lists of holders. */
static kith_status find_holders(struct pass *pass) {
  struct mfm_faces *f = pass->faces;
  const kith_index n = pass->connectivity->rows.n;
  const struct kith_rows *rows = &pass->connectivity->rows;
  KITH_TRY(kith_rows_sum(&f->holders, kith_rows_zero(rows)));
  KITH_TRY(kith_reserve(&f->value, &f->value_capacity, f->holders.first[n] * KITH_LANES, sizeof *f->value));
  return kith_traverse(n, holders_chunk_of[f->kernel], pass, 1, 0, f->profile);
}

/* Makes the graph of integrated faces, and computes their areas. */
static kith_status build(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  struct pass pass = {f, connectivity};
  const kith_index n = connectivity->rows.n;
  f->graph.rows = connectivity->overlap;
  f->graph.rows.n = f->nodes->n_internal;
  f->graph.pairs = connectivity->overlap_pairs;
  f->graph.canonical = connectivity->canonical;
  kith_status status = kith_pairwise_prepare(&f->graph.pairs, &face_area, &f->area);
  if (status == KITH_OK) status = kith_rows_reserve(&f->holders, n);
  if (status == KITH_OK) status = kith_traverse(n, partition_chunk_of[f->kernel], &pass, 1, 0, f->profile);
  KITH_TRY(kith_ranks_allreduce_status(f->nodes->ranks, status));
  refresh_quadrature(&pass);
  status = find_holders(&pass);
  if (status == KITH_OK)
    status = connectivity->rows.shift == NULL
                 ? kith_traverse(f->graph.pairs.starts, product, &pass, KITH_LANES, (size_t)n, f->profile)
                 : kith_traverse(f->graph.pairs.starts, image_product, &pass, KITH_LANES + 2,
                                 kith_rows_longest(&connectivity->overlap), f->profile);
  if (status == KITH_OK) status = kith_traverse(f->nodes->n_internal, stretch_chunk, &pass, 1, 0, f->profile);
  KITH_TRY(kith_ranks_allreduce_status(f->nodes->ranks, status));
  stretch(f);
  return KITH_OK;
}

kith_status kith_mfm_faces_build(struct mfm_faces *f, const struct kith_connectivity *connectivity) {
  kith_status status;
  KITH_STAGE(status, f->profile, "faces", build(f, connectivity));
  return status;
}
