/* Images of nodes across the faces of one axis: which are needed, and their ghost blocks or shifts. */
#include "boundaries/images.h"

#include <math.h>

enum { CHUNK = 4096 };

/* Extent of the nodes along the axis of one boundary. */
struct line {
  const struct kith_boundary *boundary;
  double factor;        /* f */
  double x_min, x_max;  /* of all present nodes */
  double search_radius; /* max f R of all present nodes */
  double slack;
};

/* Nodes that get a ghost by one image, ascending: count[c] of them in chunk c, from node[c * CHUNK] on. */
struct hits {
  kith_index n, chunks; /* present nodes; chunks of them */
  kith_index *node;     /* [n], in the memory of kith_nodes_work */
  kith_index *count;    /* [chunks], behind them */
};

void kith_images_measure(struct kith_boundary *boundary, const struct kith_nodes *nodes,
                         double radius_factor) {
  const double *restrict x = nodes->position->f64 + boundary->axis;
  const double *restrict radius = nodes->search_radius->f64;
  const double lower = boundary->lower, upper = boundary->upper;
  double low = INFINITY, high = -INFINITY, widest = 0, below = -INFINITY, above = -INFINITY;
  int lost = 0;
#pragma omp parallel for schedule(static) reduction(min                  \
                                                    : low) reduction(max \
                                                                     : high, widest, below, above, lost)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double xi = x[(size_t)i * NDIM], r = radius_factor * radius[i];
    low = KITH_MIN(low, xi), high = KITH_MAX(high, xi);
    widest = KITH_MAX(widest, r);
    below = KITH_MAX(below, r - (xi - lower));
    above = KITH_MAX(above, r - (upper - xi));
    lost = KITH_MAX(lost, !(fabs(xi) < INFINITY && r < INFINITY));
  }
  boundary->range.low = low, boundary->range.high = high, boundary->range.search_radius = widest;
  boundary->range.finite = !lost;
  boundary->most[KITH_IMAGES_WANTED] = below, boundary->most[KITH_IMAGES_WANTED + 1] = above;
  boundary->most[KITH_IMAGES_OUT] = KITH_MAX(lower - low, 0.0);
  boundary->most[KITH_IMAGES_OUT + 1] = KITH_MAX(high - upper, 0.0);
}

/* Returns the line of the internal nodes, as given, and of the ghosts that earlier boundaries made. */
static struct line line_of(const struct kith_boundary *boundary, const struct kith_nodes *nodes,
                           double factor, double low, double high, double widest) {
  const double *restrict x = nodes->position->f64 + boundary->axis;
  const double *restrict radius = nodes->search_radius->f64;
#pragma omp parallel for schedule(static) reduction(min : low) reduction(max : high, widest)
  for (kith_index i = nodes->n_internal; i < kith_nodes_count(nodes); ++i) {
    low = KITH_MIN(low, x[(size_t)i * NDIM]);
    high = KITH_MAX(high, x[(size_t)i * NDIM]);
    widest = KITH_MAX(widest, factor * radius[i]);
  }
  const double slack = 1e-12 * (fabs(boundary->lower) + fabs(boundary->upper) + widest);
  return (struct line){boundary, factor, low, high, widest, slack};
}

/* What decides whether a node gets a ghost by one image. */
struct test {
  double sign, shift; /* depth outside of the face on the image's side = sign * x + shift */
  double wanted, out;
};

static struct test test_of(const struct line *line, int n) {
  const int side = n > 0;
  double sign, shift;
  if (!line->boundary->ops->image_of(line->boundary, n, &sign, &shift))
    return (struct test){0, INFINITY, 0, 0}; /* no image: nothing passes */
  return (struct test){.sign = side ? sign : -sign,
                       .shift = side ? shift - line->boundary->upper : line->boundary->lower - shift,
                       .wanted = line->boundary->most[KITH_IMAGES_WANTED + side] + line->slack,
                       .out = line->boundary->most[KITH_IMAGES_OUT + side] + line->slack};
}

static inline bool passes(const struct test *test, double x, double r) {
  const double depth = test->sign * x + test->shift;
  return depth <= test->wanted || depth <= r + test->out;
}

/* May any node need image n? Tests the outermost nodes with the largest search radius. */
static bool is_needed(const struct line *line, int n) {
  const struct test test = test_of(line, n);
  return passes(&test, line->x_min, line->search_radius) || passes(&test, line->x_max, line->search_radius);
}

/* Are image n and all beyond it unneeded? Images n and n + 2 are 2 L apart, so two unneeded ones in a row
 * suffice. */
static bool is_side_done(const struct line *line, int n) {
  return !is_needed(line, n) && !is_needed(line, n > 0 ? n + 1 : n - 1);
}

/* Finds the nodes that need image n. */
static void find_hits(const struct line *line, const struct kith_nodes *nodes, int n,
                      const struct hits *hits) {
  const double *restrict x = nodes->position->f64 + line->boundary->axis;
  const double *restrict radius = nodes->search_radius->f64;
  const struct test test = test_of(line, n);
  const double factor = line->factor;
#pragma omp parallel for schedule(static) if (hits->chunks > 1)
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index begin = c * CHUNK, end = KITH_MIN(begin + CHUNK, hits->n);
    kith_index *restrict hit = hits->node + begin, count = 0;
    for (kith_index i = begin; i < end; ++i) { /* no branch: i is kept if it passes */
      hit[count] = i;
      count += passes(&test, x[(size_t)i * NDIM], factor * radius[i]);
    }
    hits->count[c] = count;
  }
}

/* Copies the hits of one list to `control` (NULL: only counts them), ascending; returns their number. */
static kith_index hits_of_list(const struct hits *hits, const uint8_t *list_of, int list,
                               kith_index *control) {
  kith_index n = 0;
  for (kith_index c = 0; c < hits->chunks; ++c) {
    const kith_index *hit = hits->node + (size_t)c * CHUNK, *end = hit + hits->count[c];
    for (; hit < end; ++hit) {
      if (list_of[*hit] != list) continue;
      if (control != NULL) control[n] = *hit;
      ++n;
    }
  }
  return n;
}

kith_status kith_images_add(struct kith_nodes *nodes, const struct kith_ghost_block *block, int axis, int n) {
  const int64_t one = axis == 0 ? 1 : axis == 1 ? 1 << 16 : INT64_C(1) << 32;
  const kith_index first = kith_nodes_count(nodes);
  KITH_TRY(kith_nodes_add_ghosts(nodes, block));
  for (kith_index k = 0; nodes->image != NULL && k < block->count; ++k)
    nodes->image->i64[first + k] += n * one;
  return KITH_OK;
}

/* Appends the ghosts by image n, a block for each list. */
static kith_status add_image(const struct line *line, struct kith_nodes *nodes, int n,
                             const struct hits *hits) {
  if (!is_needed(line, n)) return KITH_OK;
  find_hits(line, nodes, n, hits);
  const int axis = line->boundary->axis;
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .boundary = line->boundary->index};
  for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1, block.image.shift[a] = 0;
  (void)line->boundary->ops->image_of(line->boundary, n, &block.image.sign[axis], &block.image.shift[axis]);
  if (block.image.sign[axis] < 0)
    block.image.velocity[axis] =
        2 * kith_boundary_face_velocity(line->boundary->ops, line->boundary->settings);
  for (int list = 0; list < nodes->n_lists; ++list) {
    block.list = list;
    block.control = NULL;
    block.count = hits_of_list(hits, nodes->list->u8, list, NULL);
    KITH_TRY(kith_resize(&block.control, 0, (size_t)block.count, sizeof *block.control));
    hits_of_list(hits, nodes->list->u8, list, block.control);
    KITH_TRY(kith_images_add(nodes, &block, axis, n));
  }
  return KITH_OK;
}

/* Nodes are those that were present when the axis was begun: an image is no image of an image. */
static kith_status add_images(const struct line *line, struct kith_nodes *nodes) {
  const size_t n_nodes = (size_t)kith_nodes_count(nodes), chunks = (n_nodes + CHUNK - 1) / CHUNK;
  struct hits hits = {.n = (kith_index)n_nodes, .chunks = (kith_index)chunks};
  KITH_TRY(kith_nodes_work(nodes, (n_nodes + chunks) * sizeof *hits.node, &hits.node));
  hits.count = hits.node + n_nodes;
  for (int n = 1; !is_side_done(line, -n) || !is_side_done(line, n); ++n) {
    KITH_TRY(add_image(line, nodes, -n, &hits));
    KITH_TRY(add_image(line, nodes, n, &hits));
  }
  return KITH_OK;
}

static kith_status not_finite(const struct line *line) {
  KITH_FAIL(DIVERGED, "the position or search radius of a node is not finite (axis %d)",
            line->boundary->axis);
}

static kith_status too_many(const struct line *line) {
  KITH_FAIL(DIVERGED,
            "search radius %g, nodes in [%g, %g]: more than %d images across axis %d; a support is too wide, "
            "or a node far outside of [%g, %g]",
            line->search_radius, line->x_min, line->x_max, KITH_MOST_IMAGES, line->boundary->axis,
            line->boundary->lower, line->boundary->upper);
}

/* Indices into boundary->most where images are shifts: minus the lowest coordinate, the highest one, the
 * largest f R, and 1 if one of these is not finite; of the nodes of all ranks. */
enum { MINUS_LOW, HIGH, WIDEST, LOST };

/* The shifts of all ranks are the same: earlier ghosts lie where internal nodes do along the axis, or are
 * frozen, which every rank has. */
kith_status kith_images_shifts(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double radius_factor) {
  if (nodes->n_internal == 0 && nodes->ranks == NULL) return KITH_OK;
  const struct line line = line_of(boundary, nodes, radius_factor, -boundary->most[MINUS_LOW],
                                   boundary->most[HIGH], boundary->most[WIDEST]);
  if (boundary->most[LOST] > 0) return not_finite(&line);
  const double length = boundary->upper - boundary->lower, spread = KITH_MAX(line.x_max - line.x_min, 0.0),
               far = (spread + line.search_radius) * (1 + 1e-12);
  if (!(far < KITH_MOST_IMAGES * length)) return too_many(&line);
  ++nodes->ghosts;
  return kith_shifts_add(&nodes->shifts, boundary->axis, (int)(far / length), length);
}

void kith_images_measure_shifts(struct kith_boundary *boundary, const struct kith_nodes *nodes,
                                double radius_factor) {
  kith_images_measure(boundary, nodes, radius_factor);
  boundary->most[MINUS_LOW] = -boundary->range.low, boundary->most[HIGH] = boundary->range.high;
  boundary->most[WIDEST] = boundary->range.search_radius, boundary->most[LOST] = !boundary->range.finite;
}

kith_status kith_images_ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double radius_factor) {
  if (nodes->n_internal == 0 && nodes->ranks == NULL) return KITH_OK;
  const struct line line = line_of(boundary, nodes, radius_factor, boundary->range.low, boundary->range.high,
                                   boundary->range.search_radius);
  if (!boundary->range.finite) return not_finite(&line);
  if (kith_nodes_count(nodes) == 0) return KITH_OK;
  if (!is_side_done(&line, -KITH_MOST_IMAGES - 1) || !is_side_done(&line, KITH_MOST_IMAGES + 1))
    return too_many(&line);
  return add_images(&line, nodes);
}

/* ---- enforcing ---- */

kith_status kith_images_enforce(struct kith_boundary *boundary, struct kith_nodes *nodes) {
  const double *x = nodes->position->f64 + boundary->axis;
  const double far = KITH_MOST_IMAGES * fabs(boundary->upper - boundary->lower);
  /* The interval for nodes: unbounded on a side that does not act, half-open if the boundary wraps. */
  const double upper = boundary->ops->wraps ? nextafter(boundary->upper, -INFINITY) : boundary->upper;
  const double low = boundary->at_lower ? boundary->lower : -INFINITY,
               high = boundary->at_upper ? upper : INFINITY;
  kith_index lost = INT32_MAX;
  bool any = false;
  if (!(low < high))
    KITH_FAIL(DIVERGED, "the faces of the %s boundary on axis %d are at %g and %g: no room for nodes",
              boundary->ops->name, boundary->axis, boundary->lower, boundary->upper);
#pragma omp parallel for schedule(static) reduction(min : lost) reduction(|| : any)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double xi = x[(size_t)i * NDIM];
    if (xi >= low && xi <= high) continue;
    if (!(xi >= low - far && xi <= high + far)) {
      lost = KITH_MIN(lost, i);
      continue;
    }
    boundary->ops->put_back(boundary, nodes, i);
    any = true;
  }
  if (any) ++nodes->positions;
  if (lost < INT32_MAX)
    KITH_FAIL_NODE(DIVERGED, nodes->id->i64[lost], "node %lld is at %g on axis %d, far outside of [%g, %g]",
                   (long long)nodes->id->i64[lost], x[(size_t)lost * NDIM], boundary->axis, boundary->lower,
                   boundary->upper);
  return KITH_OK;
}
