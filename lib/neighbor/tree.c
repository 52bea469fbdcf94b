/* tree.c - a tree over space-filling-curve order.
 *
 * Slots follow the Morton curve of a cube around the nodes. Where two slots that follow one another differ in
 * a high bit of their keys, a large cell of the curve ends: cutting at the highest bits first until at most
 * BUCKET nodes are left makes the leaves, as a tree with one bit per level would. Every 8 leaves in a row are
 * a cell of the next level, and so on. Each cell knows the tight box of its nodes and their largest radius; 8
 * cells are tested at once.
 *
 * If the nodes lie along the curve already but for a few, slots keep the order of the nodes: nothing is
 * sorted, boxes stay tight, and candidates come in ascending node index. kith_search_cube tells the curve.
 *
 * Internal nodes are one part, all ghosts another; append adds a part. Each part is a tree of its own.
 * update O(n); coarse O(log n + found). */
#include "lib/core/key.h"
#include "lib/neighbor/keyed.h"
#include "lib/neighbor/search.h"

enum {
  BUCKET = 12,     /* most nodes of a leaf, that is, of a group */
  WIDTH = 8,       /* cells tested at once */
  MAX_LEVELS = 11, /* 8^11 > 2^31 */
  MESSY = 16,      /* slots are sorted if more than n / MESSY nodes are out of order */
  SLICE = 8192,    /* slots that one thread cuts into leaves */
};

struct octet {
  double lower[NDIM][WIDTH], upper[NDIM][WIDTH], radius2[WIDTH];
};

struct part {
  kith_index leaf, n_leaves; /* leaves: first[leaf] .. first[leaf + n_leaves], the last one being the end */
  int levels;                /* level 0: leaves */
  kith_index octet[MAX_LEVELS], cells[MAX_LEVELS]; /* by level: first octet, number of cells */
};

struct tree {
  int n_parts, parts_capacity;
  struct part *part;
  kith_index n_octets, octets_capacity, n_leaves,
      leaves_capacity; /* n_leaves counts the end of each part too */
  struct octet *octet;
  kith_index *first; /* slot */
  /* Scratch of an update. */
  kith_index capacity, sort_capacity;
  uint64_t *key;
  uint16_t *rank; /* of the cut behind a slot: the higher the earlier */
  uint8_t *cut;   /* a leaf ends behind this slot */
  struct kith_keyed *item[2];
};

static kith_status tree_create(struct kith_search *search) {
  return kith_resize(&search->self, 0, 1, sizeof(struct tree));
}

static void tree_destroy(struct kith_search *search) {
  struct tree *tree = search->self;
  kith_free(&tree->part);
  kith_free(&tree->octet);
  kith_free(&tree->first);
  kith_free(&tree->key);
  kith_free(&tree->rank);
  kith_free(&tree->cut);
  for (int k = 0; k < 2; ++k) kith_free(&tree->item[k]);
  kith_free(&search->self);
}

/* Order. */

static void find_keys(const struct kith_search *search, kith_index begin, kith_index n, uint64_t *key) {
  const double *x = search->nodes->position->f64 + (size_t)begin * NDIM;
  double lower[NDIM], upper[NDIM], inverse_cell[NDIM];
  kith_search_cube(x, n, lower, upper);
  for (int a = 0; a < NDIM; ++a)
    inverse_cell[a] = (double)(UINT64_C(1) << KITH_KEY_BITS) / (upper[a] - lower[a]);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) key[i] = kith_key_of_position(x + (size_t)i * NDIM, lower, inverse_cell);
}

static kith_index count_descents(const uint64_t *key, kith_index n) {
  kith_index descents = 0;
#pragma omp parallel for schedule(static) reduction(+ : descents)
  for (kith_index i = 1; i < n; ++i) descents += key[i] < key[i - 1];
  return descents;
}

static kith_status reserve_sort(struct tree *tree, kith_index n) {
  if (n <= tree->sort_capacity) return KITH_OK;
  for (int k = 0; k < 2; ++k) KITH_TRY(kith_resize(&tree->item[k], 0, (size_t)n, sizeof **tree->item));
  tree->sort_capacity = n;
  return KITH_OK;
}

static kith_status sort_slots(struct kith_search *search, kith_index begin, kith_index n) {
  struct tree *tree = search->self;
  KITH_TRY(reserve_sort(tree, n));
  struct kith_keyed *item = tree->item[0];
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) item[i] = (struct kith_keyed){tree->key[i], begin + i};
  KITH_TRY(kith_keyed_sort(item, tree->item[1], (size_t)n));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) tree->key[i] = item[i].key, search->node[begin + i] = item[i].node;
  return KITH_OK;
}

/* Fills slots begin .. begin + n - 1 with the nodes of these numbers, along the curve. */
static kith_status order_slots(struct kith_search *search, kith_index begin, kith_index n) {
  struct tree *tree = search->self;
  find_keys(search, begin, n, tree->key);
  if (count_descents(tree->key, n) > n / MESSY) return sort_slots(search, begin, n);
  for (kith_index i = 0; i < n; ++i) search->node[begin + i] = begin + i;
  return KITH_OK;
}

/* Leaves. */

/* The cut between slots i and i + 1: the highest bit in which their keys differ; equal keys are cut by slot
 * number. */
static inline uint16_t rank_of(const uint64_t *key, kith_index i) {
  const uint64_t differing = key[i] ^ key[i + 1];
  const int bits = differing ? 64 - __builtin_clzll(differing) : 0;
  return (uint16_t)(bits << 5 | __builtin_ctz((unsigned)i + 1));
}

/* Is the largest range without a higher cut around this one too long for a leaf? Then it is cut here. */
static inline bool is_cut(const uint16_t *rank, kith_index n, kith_index i) {
  const uint16_t mine = rank[i];
  kith_index lower = i, upper = i + 1;
  while (lower > 0 && upper - lower < BUCKET && rank[lower - 1] < mine) --lower;
  while (upper < n - 1 && upper - lower < BUCKET && rank[upper] <= mine) ++upper;
  return upper - lower + 1 > BUCKET;
}

static kith_status reserve_scratch(struct tree *tree, kith_index n) {
  if (n <= tree->capacity) return KITH_OK;
  KITH_TRY(kith_resize(&tree->key, 0, (size_t)n, sizeof *tree->key));
  KITH_TRY(kith_resize(&tree->rank, 0, (size_t)n, sizeof *tree->rank));
  KITH_TRY(kith_resize(&tree->cut, 0, (size_t)n, sizeof *tree->cut));
  tree->capacity = n;
  return KITH_OK;
}

static kith_status reserve_leaves(struct tree *tree, kith_index more) {
  const kith_index wanted = tree->n_leaves + more;
  if (wanted <= tree->leaves_capacity) return KITH_OK;
  const kith_index room = wanted + wanted / 4;
  KITH_TRY(kith_resize(&tree->first, (size_t)tree->n_leaves, (size_t)room, sizeof *tree->first));
  tree->leaves_capacity = room;
  return KITH_OK;
}

static void mark_cuts(struct tree *tree, kith_index n) {
#pragma omp parallel
  {
#pragma omp for schedule(static)
    for (kith_index i = 0; i < n - 1; ++i) tree->rank[i] = rank_of(tree->key, i);
#pragma omp for schedule(static)
    for (kith_index i = 0; i < n - 1; ++i) tree->cut[i] = is_cut(tree->rank, n, i);
  }
  tree->cut[n - 1] = 1;
}

/* Leaves of slots begin .. begin + n - 1, n > 0. */
static kith_status cut_leaves(struct tree *tree, struct part *part, kith_index begin, kith_index n) {
  mark_cuts(tree, n);
  kith_index leaves = 0;
  for (kith_index i = 0; i < n; ++i) leaves += tree->cut[i];
  KITH_TRY(reserve_leaves(tree, leaves + 1));
  part->leaf = tree->n_leaves;
  part->n_leaves = leaves;
  kith_index *first = tree->first + part->leaf;
  *first++ = begin;
  for (kith_index i = 0; i < n; ++i) {
    *first = begin + i + 1;
    first += tree->cut[i];
  }
  tree->n_leaves += leaves + 1;
  return KITH_OK;
}

/* Boxes. */

static void empty_cells(struct octet *octet) {
  for (int k = 0; k < WIDTH; ++k) {
    for (int a = 0; a < NDIM; ++a) octet->lower[a][k] = INFINITY, octet->upper[a][k] = -INFINITY;
    octet->radius2[k] = -1;
  }
}

static void enclose_slots(const struct kith_search *search, kith_index begin, kith_index end,
                          struct octet *octet, int k) {
  for (int a = 0; a < NDIM; ++a) {
    const double *x = search->coordinate[a];
    double lower = x[begin], upper = x[begin];
    for (kith_index s = begin + 1; s < end; ++s) lower = KITH_MIN(lower, x[s]), upper = KITH_MAX(upper, x[s]);
    octet->lower[a][k] = lower, octet->upper[a][k] = upper;
  }
  double radius2 = search->radius2[begin];
  for (kith_index s = begin + 1; s < end; ++s) radius2 = KITH_MAX(radius2, search->radius2[s]);
  octet->radius2[k] = radius2;
}

static void enclose_cells(const struct octet *children, int n, struct octet *octet, int k) {
  for (int c = 0; c < n; ++c) {
    for (int a = 0; a < NDIM; ++a) {
      octet->lower[a][k] = KITH_MIN(octet->lower[a][k], children->lower[a][c]);
      octet->upper[a][k] = KITH_MAX(octet->upper[a][k], children->upper[a][c]);
    }
    octet->radius2[k] = KITH_MAX(octet->radius2[k], children->radius2[c]);
  }
}

static kith_status plan_levels(struct tree *tree, struct part *part) {
  part->levels = 0;
  for (kith_index cells = part->n_leaves;; cells = (cells + WIDTH - 1) / WIDTH) {
    const int l = part->levels++;
    part->octet[l] = tree->n_octets;
    part->cells[l] = cells;
    tree->n_octets += (cells + WIDTH - 1) / WIDTH;
    if (cells <= WIDTH) break;
  }
  if (tree->n_octets <= tree->octets_capacity) return KITH_OK;
  const kith_index room = tree->n_octets + tree->n_octets / 4;
  KITH_TRY(kith_resize(&tree->octet, (size_t)part->octet[0], (size_t)room, sizeof *tree->octet));
  tree->octets_capacity = room;
  return KITH_OK;
}

static kith_status enclose(const struct kith_search *search, struct part *part) {
  struct tree *tree = search->self;
  KITH_TRY(plan_levels(tree, part));
  const kith_index *first = tree->first + part->leaf;
  for (int l = 0; l < part->levels; ++l) {
    const kith_index cells = part->cells[l], octets = (cells + WIDTH - 1) / WIDTH;
#pragma omp parallel for schedule(static) if (octets > 64)
    for (kith_index o = 0; o < octets; ++o) {
      struct octet *octet = &tree->octet[part->octet[l] + o];
      empty_cells(octet);
      for (kith_index c = o * WIDTH, k = 0; k < WIDTH && c < cells; ++c, ++k)
        if (l == 0)
          enclose_slots(search, first[c], first[c + 1], octet, k);
        else
          enclose_cells(&tree->octet[part->octet[l - 1] + c], WIDTH, octet, k);
    }
  }
  return KITH_OK;
}

/* Building. */

static kith_status add_part(struct kith_search *search, kith_index begin, kith_index n) {
  struct tree *tree = search->self;
  if (n == 0) return KITH_OK;
  if (tree->n_parts == tree->parts_capacity) {
    const int capacity = KITH_MAX(8, 2 * tree->parts_capacity);
    KITH_TRY(kith_resize(&tree->part, (size_t)tree->n_parts, (size_t)capacity, sizeof *tree->part));
    tree->parts_capacity = capacity;
  }
  struct part *part = &tree->part[tree->n_parts];
  KITH_TRY(reserve_scratch(tree, n));
  KITH_TRY(order_slots(search, begin, n));
  kith_search_pack(search, begin, n);
  KITH_TRY(cut_leaves(tree, part, begin, n));
  KITH_TRY(enclose(search, part));
  ++tree->n_parts;
  const kith_index *first = tree->first + part->leaf;
  for (kith_index l = 0; l < part->n_leaves; ++l)
    KITH_TRY(kith_search_group(search, first[l], first[l + 1] - first[l]));
  return KITH_OK;
}

static kith_status tree_update(struct kith_search *search) {
  struct tree *tree = search->self;
  tree->n_parts = 0;
  tree->n_octets = tree->n_leaves = 0;
  KITH_TRY(add_part(search, 0, search->n_internal));
  return add_part(search, search->n_internal, search->n - search->n_internal);
}

static kith_status tree_append(struct kith_search *search, kith_index old_n) {
  return add_part(search, old_n, search->n - old_n);
}

/* Asking. */

struct question {
  struct kith_box box;
  double radius2; /* of the masters if it counts, else -1 */
  double cell;    /* factor of the cells' own radii squared: counts, or not */
};

/* One bit for each of the 8 cells that may interact with the box. */
static inline unsigned ask(const struct octet *octet, const struct question *q) {
  unsigned mask = 0;
  for (int k = 0; k < WIDTH; ++k) {
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double below = octet->lower[a][k] - q->box.upper[a], above = q->box.lower[a] - octet->upper[a][k];
      const double d = KITH_MAX(KITH_MAX(below, above), 0.0);
      d2 += d * d;
    }
    const double limit = KITH_MAX(q->cell * octet->radius2[k], q->radius2);
    mask |= (unsigned)(d2 <= limit) << k;
  }
  return mask;
}

static inline unsigned valid(kith_index cells, kith_index octet) {
  const kith_index left = cells - octet * WIDTH;
  return left >= WIDTH ? (1u << WIDTH) - 1 : (1u << left) - 1;
}

/* Leaves next to one another are one run. */
static inline kith_status take_leaves(const kith_index *first, unsigned mask, struct kith_runs *runs) {
  while (mask) {
    const int k = __builtin_ctz(mask), count = __builtin_ctz(~(mask >> k));
    KITH_TRY(kith_runs_add(runs, first[k], first[k + count] - first[k]));
    mask &= mask + (1u << k);
  }
  return KITH_OK;
}

/* Depth first, so that slots ascend: mask[l] holds the cells of octet at[l] that are still to be visited. */
KITH_HOT static kith_status ask_part(const struct tree *tree, const struct part *part,
                                     const struct question *q, struct kith_runs *runs) {
  unsigned mask[MAX_LEVELS];
  kith_index at[MAX_LEVELS];
  const kith_index *first = tree->first + part->leaf;
  const int top = part->levels - 1;
  at[top] = 0;
  mask[top] = ask(&tree->octet[part->octet[top]], q) & valid(part->cells[top], 0);
  for (int l = top; l <= top;) {
    if (l == 0) {
      KITH_TRY(take_leaves(first + at[0] * WIDTH, mask[0], runs));
      mask[0] = 0;
    }
    if (mask[l] == 0) {
      ++l;
      continue;
    }
    const kith_index child = at[l] * WIDTH + __builtin_ctz(mask[l]);
    mask[l] &= mask[l] - 1;
    --l;
    at[l] = child;
    mask[l] = ask(&tree->octet[part->octet[l] + child], q) & valid(part->cells[l], child);
  }
  return KITH_OK;
}

static kith_status tree_coarse(const struct kith_search *search, const struct kith_box *box, double radius,
                               enum kith_search_mode mode, struct kith_runs *runs) {
  const struct tree *tree = search->self;
  const double loose = 1 + KITH_SEARCH_SLACK;
  const struct question q = {.box = *box,
                             .radius2 = mode == KITH_SCATTER ? -1 : radius * radius * loose,
                             .cell = mode == KITH_GATHER ? 0 : loose};
  for (int p = 0; p < tree->n_parts; ++p) KITH_TRY(ask_part(tree, &tree->part[p], &q, runs));
  return KITH_OK;
}

static size_t tree_bytes(const struct kith_search *search) {
  const struct tree *tree = search->self;
  const size_t scratch = sizeof *tree->key + sizeof *tree->rank + sizeof *tree->cut;
  return sizeof *tree + (size_t)tree->parts_capacity * sizeof *tree->part +
         (size_t)tree->octets_capacity * sizeof *tree->octet +
         (size_t)tree->leaves_capacity * sizeof *tree->first + (size_t)tree->capacity * scratch +
         2 * (size_t)tree->sort_capacity * sizeof **tree->item;
}

const struct kith_search_ops kith_search_tree = {
    .name = "tree",
    .doc = "space-filling-curve order, leaves of a few nodes, tight boxes in a tree eight wide: the default",
    .create = tree_create,
    .destroy = tree_destroy,
    .update = tree_update,
    .append = tree_append,
    .coarse = tree_coarse,
    .bytes = tree_bytes,
};
