#include "boundaries/images.h"

#include <math.h>

enum { CHUNK = 4096 };

/* One axis as the ghosts of one boundary see it. Sides: 0 lower, 1 upper. */
struct line {
  const struct kith_boundary *boundary;
  bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign, double *shift);
  double factor;        /* f */
  double x_min, x_max;  /* of all present nodes */
  double reach;         /* max f R of all present nodes */
  double wanted[2];     /* max over internal nodes of f R - depth */
  double sticks_out[2]; /* max over internal nodes of -depth, at least 0 */
  double slack;
};

/* Ghosts-to-be of one image: hits of chunk c are node[c * CHUNK] .. + count[c] - 1, ascending. */
struct hits {
  kith_index n, chunks; /* present nodes; chunks of them */
  kith_index *node;     /* [n] */
  kith_index *count;    /* [chunks] */
  kith_index *place;    /* [chunks] */
};

static bool measure_present(struct line *line, const struct kith_nodes *nodes) {
  const kith_index n = kith_nodes_count(nodes);
  const double *restrict x = nodes->position->f64 + line->boundary->axis, *restrict radius =
                                                                              nodes->reach->f64;
  double low = INFINITY, high = -INFINITY, reach = 0;
  bool lost = false;
#pragma omp parallel for schedule(static) reduction(min                                          \
                                                    : low) reduction(max                         \
                                                                     : high, reach) reduction(|| \
                                                                                              : lost)
  for (kith_index i = 0; i < n; ++i) {
    const double xi = x[(size_t)i * NDIM];
    low = KITH_MIN(low, xi);
    high = KITH_MAX(high, xi);
    reach = KITH_MAX(reach, radius[i]);
    lost = lost || !(fabs(xi) < INFINITY && radius[i] < INFINITY);
  }
  line->x_min = low;
  line->x_max = high;
  line->reach = line->factor * reach;
  return !lost;
}

static void measure_internal(struct line *line, const struct kith_nodes *nodes) {
  const double *restrict x = nodes->position->f64 + line->boundary->axis, *restrict radius =
                                                                              nodes->reach->f64;
  const double lower = line->boundary->lower, upper = line->boundary->upper, factor = line->factor;
  double below = -INFINITY, above = -INFINITY, left = 0, right = 0;
#pragma omp parallel for schedule(static) reduction(max : below, above, left, right)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double xi = x[(size_t)i * NDIM], r = factor * radius[i];
    below = KITH_MAX(below, r - (xi - lower));
    above = KITH_MAX(above, r - (upper - xi));
    left = KITH_MAX(left, lower - xi);
    right = KITH_MAX(right, xi - upper);
  }
  line->wanted[0] = below, line->wanted[1] = above;
  line->sticks_out[0] = left, line->sticks_out[1] = right;
  line->slack = 1e-12 * (fabs(lower) + fabs(upper) + line->reach);
}

/* Depth outside of the face of image n: sign * (x_ghost - face), the face and sign of n's side. */
static double depth_of(const struct line *line, int n, double ghost) {
  return n > 0 ? ghost - line->boundary->upper : line->boundary->lower - ghost;
}

/* May anyone need image n? The smallest depth of its ghosts against the largest limit. */
static bool is_needed(const struct line *line, int n) {
  double sign, shift;
  if (!line->image_of(line->boundary, n, &sign, &shift)) return false;
  const double depth =
      KITH_MIN(depth_of(line, n, sign * line->x_min + shift), depth_of(line, n, sign * line->x_max + shift));
  const int side = n > 0;
  return depth <= KITH_MAX(line->wanted[side], line->reach + line->sticks_out[side]) + line->slack;
}

/* Every other image of a side is 2 L farther, so when two in a row are not needed, none beyond is. */
static bool is_side_done(const struct line *line, int n) {
  return !is_needed(line, n) && !is_needed(line, n > 0 ? n + 1 : n - 1);
}

static void find_hits(const struct line *line, const struct kith_nodes *nodes, int n, double sign,
                      double shift, struct hits *hits) {
  const double *restrict x = nodes->position->f64 + line->boundary->axis, *restrict radius =
                                                                              nodes->reach->f64;
  const int side = n > 0;
  const double factor = line->factor, out = line->sticks_out[side] + line->slack;
  const double wanted = line->wanted[side] + line->slack;
#pragma omp parallel for schedule(static)
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index begin = c * CHUNK, end = KITH_MIN(begin + CHUNK, hits->n);
    kith_index *hit = hits->node + begin;
    kith_index count = 0;
    for (kith_index i = begin; i < end; ++i) {
      const double depth = depth_of(line, n, sign * x[(size_t)i * NDIM] + shift);
      hit[count] = i; /* kept if it counts: count never exceeds i - begin */
      count += depth <= wanted || depth <= factor * radius[i] + out;
    }
    hits->count[c] = count;
  }
}

/* The hits of one list, ascending: counted, placed, filled. *control is owned by the caller. */
static kith_status hits_of_list(const struct hits *hits, const uint8_t *list_of, int list,
                                kith_index **control, kith_index *total) {
#pragma omp parallel for schedule(static)
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index *hit = hits->node + (size_t)c * CHUNK;
    kith_index count = 0;
    for (kith_index k = 0; k < hits->count[c]; ++k) count += list_of[hit[k]] == list;
    hits->place[c] = count;
  }
  kith_index sum = 0;
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index count = hits->place[c];
    hits->place[c] = sum;
    sum += count;
  }
  *total = sum;
  KITH_TRY(kith_resize(control, 0, (size_t)sum, sizeof **control));
  if (sum == 0) return KITH_OK;
#pragma omp parallel for schedule(static)
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index *hit = hits->node + (size_t)c * CHUNK;
    kith_index place = hits->place[c];
    for (kith_index k = 0; k < hits->count[c]; ++k)
      if (list_of[hit[k]] == list) (*control)[place++] = hit[k];
  }
  return KITH_OK;
}

static kith_status add_image(const struct line *line, struct kith_nodes *nodes, int n, struct hits *hits) {
  if (!is_needed(line, n)) return KITH_OK;
  const int axis = line->boundary->axis;
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .boundary = line->boundary->index};
  for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1, block.image.shift[a] = 0;
  (void)line->image_of(line->boundary, n, &block.image.sign[axis], &block.image.shift[axis]);
  find_hits(line, nodes, n, block.image.sign[axis], block.image.shift[axis], hits);
  for (int list = 0; list < nodes->n_lists; ++list) {
    block.list = list;
    block.control = NULL;
    KITH_TRY(hits_of_list(hits, nodes->list->u8, list, &block.control, &block.count));
    if (block.count > 0) KITH_TRY(kith_nodes_add_ghosts(nodes, &block));
  }
  return KITH_OK;
}

static kith_status add_images(const struct line *line, struct kith_nodes *nodes, struct hits *hits) {
  hits->n = kith_nodes_count(nodes);
  hits->chunks = (hits->n + CHUNK - 1) / CHUNK;
  KITH_TRY(kith_resize(&hits->node, 0, (size_t)hits->n, sizeof *hits->node));
  KITH_TRY(kith_resize(&hits->count, 0, (size_t)hits->chunks, sizeof *hits->count));
  KITH_TRY(kith_resize(&hits->place, 0, (size_t)hits->chunks, sizeof *hits->place));
  for (int n = 1; !is_side_done(line, -n) || !is_side_done(line, n); ++n) {
    KITH_TRY(add_image(line, nodes, -n, hits));
    KITH_TRY(add_image(line, nodes, n, hits));
  }
  return KITH_OK;
}

kith_status kith_images_ghosts(const struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double reach_factor,
                               bool (*image_of)(const struct kith_boundary *boundary, int n, double *sign,
                                                double *shift)) {
  if (nodes->n_internal == 0) return KITH_OK;
  struct line line = {.boundary = boundary, .image_of = image_of, .factor = reach_factor};
  if (!measure_present(&line, nodes))
    KITH_FAIL(DIVERGED, "the position or reach of a node is not finite (axis %d)", boundary->axis);
  measure_internal(&line, nodes);
  if (!is_side_done(&line, -KITH_MOST_IMAGES - 1) || !is_side_done(&line, KITH_MOST_IMAGES + 1))
    KITH_FAIL(DIVERGED, "reach %g, nodes in [%g, %g]: more than %d images across axis %d of length %g",
              line.reach, line.x_min, line.x_max, KITH_MOST_IMAGES, boundary->axis,
              boundary->upper - boundary->lower);
  struct hits hits = {0};
  const kith_status status = add_images(&line, nodes, &hits);
  kith_free(&hits.node);
  kith_free(&hits.count);
  kith_free(&hits.place);
  return status;
}

kith_status kith_images_lost(const struct kith_boundary *boundary, const struct kith_nodes *nodes,
                             kith_index i) {
  KITH_FAIL(DIVERGED, "node %lld is at %g on axis %d, far outside of [%g, %g]", (long long)nodes->id->i64[i],
            nodes->position->f64[(size_t)i * NDIM + boundary->axis], boundary->axis, boundary->lower,
            boundary->upper);
}
