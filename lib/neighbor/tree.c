/* tree.c - a tree over space-filling-curve order.
 *
 * Slots follow the Morton curve of a cube around the nodes. Where two slots that follow one another differ in
 * a high bit of their keys, a large cell of the curve ends: cutting at the highest bits first until at most
 * BUCKET nodes are left makes the leaves, as a tree with one bit per level would. Cutting the sequence of
 * leaves in the same way until at most 8 are left makes the next level, an octet of cells each, and so on to
 * the root. Each cell knows the tight box of its nodes and their largest radius; the 8 cells of an octet are
 * tested at once.
 *
 * If most nodes lie along the curve already (MESSY), slots keep the order of the nodes: nothing is sorted,
 * boxes stay fairly tight, and candidates come in ascending node index. kith_search_cube gives the cube of
 * the curve.
 *
 * Internal nodes are one part, all ghosts another. Each part is a tree of its own. While nodes along the
 * curve keep their numbers, some updates keep their leaves and octets, too, and make boxes anew: from step to
 * step nodes move little, and a tree is right wherever they are. Not if the caller wants fresh cells.
 * update O(n); update_selected O(selected log n) and a look at each leaf; coarse O(log n + found). */
#include "lib/core/sfc_key.h"
#include "lib/core/keyed.h"
#include "lib/neighbor/search.h"

#include <string.h>

#ifdef __x86_64__
#include <immintrin.h>
#endif

enum {
  BUCKET = 10, /* most nodes of a leaf, that is, of a group */
  WIDTH = 8,   /* cells of an octet */
  BATCH = 32,  /* octets tested before their children are visited */
  MESSY = 6,   /* slots are sorted if more than n / MESSY steps go back along the curve */
  KEPT = 8,    /* updates that keep the leaves of internal nodes before these are cut again */
  DEEPEST = 32 /* levels, most: each has at most half of the cells of the one below it */
};

struct octet {
  double lower[NDIM][WIDTH], upper[NDIM][WIDTH], radius2[WIDTH];
};

struct part {
  kith_index root;
  int levels; /* level 0 knows leaves */
};

/* The tree of internal nodes as it was last cut, in their own order. */
struct kept {
  int updates; /* that may still keep it */
  uint64_t order;
  kith_index n_octets, n_leaves;
  struct part part;
};

struct tree {
  int n_parts;
  struct part part[2];
  struct kept kept;
  kith_index n_octets, n_leaves;
  size_t octets_capacity, children_capacity, leaves_capacity;
  struct octet *octet; /* level by level, and an empty one behind each */
  kith_index *child;   /* of octet o: octets of the level below, at level 0 leaves,
                        * child[o] .. child[o + 1] - 1 */
  kith_index *leaf;    /* its slots: leaf[l] .. leaf[l + 1] - 1; an empty one behind those of a part */
  /* Scratch of an update: kith_nodes_work. */
  uint64_t *key;
  uint16_t *rank;             /* of the cut behind a slot or cell: the higher the earlier */
  uint8_t *cut;               /* it ends a cell of the next level */
  struct kith_keyed *item[2]; /* to sort */
  size_t sort_capacity;
  /* Scratch of selected updates. */
  kith_index *slot; /* of a node; if slots were sorted */
  uint8_t *moved;   /* [leaves] 1: a node in it has moved */
  size_t slots_capacity, moved_capacity;
  bool sorted;
};

static void tree_clear(struct kith_search *search) {
  struct tree *tree = search->self;
  KITH_FREE(&tree->item[0], &tree->item[1], &tree->octet, &tree->child, &tree->leaf, &tree->slot,
            &tree->moved);
}

/* Order. */

/* How many steps go back along the curve. Steps are between adjacent slots, and over ever longer strides, so
 * that the rows of a lattice, each of which follows the curve, are not taken for the curve. */
static kith_index count_steps_back(const uint64_t *key, kith_index n) {
  kith_index back = 0;
  for (kith_index stride = 1; stride <= n / 8; stride *= 16) {
#pragma omp parallel for schedule(static) reduction(+ : back)
    for (kith_index i = stride; i < n; ++i) back += key[i] < key[i - stride];
  }
  return back;
}

static kith_status sort_slots(struct kith_search *search, kith_index begin, kith_index n) {
  struct tree *tree = search->self;
  KITH_TRY(kith_keyed_grow(tree->item, &tree->sort_capacity, (size_t)n));
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
  const double *x = search->position->f64 + (size_t)begin * NDIM;
  double lower[NDIM], upper[NDIM];
  kith_search_cube(x, n, lower, upper);
  kith_sfc_keys(x, n, lower, upper, tree->key);
  if (count_steps_back(tree->key, n) > n / MESSY) {
    tree->sorted = true;
    return sort_slots(search, begin, n);
  }
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) search->node[begin + i] = begin + i;
  return KITH_OK;
}

/* Cells: ranges of slots, and ranges of cells of the level below. */

/* The cut between slots i and i + 1: the highest bit in which their keys differ; equal keys are cut by slot
 * number. */
static inline uint16_t rank_of(const uint64_t *key, kith_index i) {
  const uint64_t differing = key[i] ^ key[i + 1];
  const int bits = differing ? 64 - __builtin_clzll(differing) : 0;
  return (uint16_t)(bits << 5 | __builtin_ctz((unsigned)i + 1));
}

/* Consider the longest range around this cut that no higher cut divides. If it is too long for a cell, it is
 * cut here. */
static inline bool is_cut(const uint16_t *rank, kith_index n, kith_index i, kith_index most) {
  const uint16_t mine = rank[i];
  kith_index lower = i, upper = i + 1;
  while (lower > 0 && upper - lower < most && rank[lower - 1] < mine) --lower;
  while (upper < n - 1 && upper - lower < most && rank[upper] <= mine) ++upper;
  return upper - lower + 1 > most;
}

/* Cuts n elements, at least one, into ranges of at most `most`; returns their number. */
static kith_index cut_ranges(struct tree *tree, kith_index n, kith_index most) {
  kith_index ranges = 1;
#pragma omp parallel for schedule(static) reduction(+ : ranges) if (n > KITH_FEW_COPIES)
  for (kith_index i = 0; i < n - 1; ++i) ranges += tree->cut[i] = is_cut(tree->rank, n, i, most);
  tree->cut[n - 1] = 1;
  if (most == BUCKET || n == 1 || ranges <= (n + 1) / 2) return ranges;
  /* A lopsided tree would have too many levels: cut at equal numbers instead. */
  for (kith_index i = 0; i < n - 1; ++i) tree->cut[i] = i % most == most - 1;
  return (n + most - 1) / most;
}

/* first[k], k = 0 .. ranges: where range k begins, counted from `base`. Only the cuts between ranges stay in
 * `rank`. */
static void list_ranges(struct tree *tree, kith_index n, kith_index base, kith_index *first) {
  *first = base;
  for (kith_index i = 0, k = 0; i < n; ++i)
    if (tree->cut[i]) tree->rank[k++] = tree->rank[i], first[k] = base + i + 1;
}

static kith_status reserve_scratch(const struct kith_search *search, kith_index n) {
  struct tree *tree = search->self;
  const size_t bytes = (size_t)n * (sizeof *tree->key + sizeof *tree->rank + sizeof *tree->cut);
  KITH_TRY(kith_nodes_work(search->nodes, bytes, &tree->key));
  tree->rank = (uint16_t *)(tree->key + n);
  tree->cut = (uint8_t *)(tree->rank + n);
  return KITH_OK;
}

/* Leaves of slots begin .. begin + n - 1. */
static kith_status cut_leaves(struct tree *tree, kith_index begin, kith_index n, kith_index *leaves) {
#pragma omp parallel for schedule(static) if (n > KITH_FEW_COPIES)
  for (kith_index i = 0; i < n - 1; ++i) tree->rank[i] = rank_of(tree->key, i);
  *leaves = cut_ranges(tree, n, BUCKET);
  const size_t old_n = (size_t)tree->n_leaves, new_n = old_n + (size_t)*leaves + 1;
  KITH_TRY(kith_grow(&tree->leaf, &tree->leaves_capacity, old_n, new_n, sizeof *tree->leaf));
  list_ranges(tree, n, begin, tree->leaf + tree->n_leaves);
  tree->n_leaves += *leaves + 1;
  return KITH_OK;
}

/* Boxes. */

static void enclose_leaf(const struct kith_search *search, kith_index begin, kith_index end,
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

static void enclose_octet(const struct octet *child, int n, struct octet *octet, int k) {
  for (int c = 0; c < n; ++c) {
    for (int a = 0; a < NDIM; ++a) {
      octet->lower[a][k] = c == 0 ? child->lower[a][c] : KITH_MIN(octet->lower[a][k], child->lower[a][c]);
      octet->upper[a][k] = c == 0 ? child->upper[a][c] : KITH_MAX(octet->upper[a][k], child->upper[a][c]);
    }
    octet->radius2[k] = c == 0 ? child->radius2[c] : KITH_MAX(octet->radius2[k], child->radius2[c]);
  }
}

static void enclose_level(const struct kith_search *search, int level, kith_index first, kith_index octets) {
  const struct tree *tree = search->self;
#pragma omp parallel for schedule(static) if (octets > 64)
  for (kith_index o = first; o < first + octets; ++o)
    for (kith_index c = tree->child[o], k = 0; c < tree->child[o + 1]; ++c, ++k)
      if (level == 0)
        enclose_leaf(search, tree->leaf[c], tree->leaf[c + 1], &tree->octet[o], k);
      else
        enclose_octet(&tree->octet[c], tree->child[c + 1] - tree->child[c], &tree->octet[o], k);
}

static void enclose_part(const struct kith_search *search, const struct part *part) {
  const struct tree *tree = search->self;
  kith_index first[DEEPEST], octets[DEEPEST];
  const int top = part->levels - 1;
  first[top] = part->root, octets[top] = 1;
  for (int l = top; l > 0; --l) {
    first[l - 1] = tree->child[first[l]];
    octets[l - 1] = tree->child[first[l] + octets[l]] - first[l - 1];
  }
  for (int l = 0; l <= top; ++l) enclose_level(search, l, first[l], octets[l]);
}

/* Makes a level from the n cells from `below` on: leaves at level 0, octets above. Its number of octets:
 * *octets. */
static kith_status add_level(const struct kith_search *search, int level, kith_index below, kith_index n,
                             kith_index *octets) {
  struct tree *tree = search->self;
  const kith_index first = tree->n_octets;
  *octets = cut_ranges(tree, n, WIDTH);
  tree->n_octets += *octets + 1;
  const size_t old_n = (size_t)first, new_n = (size_t)tree->n_octets;
  KITH_TRY(kith_grow(&tree->octet, &tree->octets_capacity, old_n, new_n, sizeof *tree->octet));
  KITH_TRY(kith_grow(&tree->child, &tree->children_capacity, old_n, new_n, sizeof *tree->child));
  list_ranges(tree, n, below, tree->child + first);
  enclose_level(search, level, first, *octets);
  return KITH_OK;
}

/* Building. */

static kith_status build_levels(struct kith_search *search, kith_index leaf, kith_index n,
                                struct part *part) {
  struct tree *tree = search->self;
  part->levels = 0;
  for (kith_index below = leaf, octets; part->levels == 0 || n > 1; n = octets) {
    part->root = tree->n_octets;
    KITH_TRY(add_level(search, part->levels++, below, n, &octets));
    below = part->root;
  }
  return KITH_OK;
}

/* Leaves are groups. */
static kith_status add_groups(struct kith_search *search, kith_index first, kith_index leaves) {
  const kith_index *leaf = ((struct tree *)search->self)->leaf + first;
  for (kith_index l = 0; l < leaves; ++l) KITH_TRY(kith_search_group(search, leaf[l], leaf[l + 1] - leaf[l]));
  return KITH_OK;
}

/* A tree of nodes begin .. begin + n - 1 in the slots of these numbers. */
static kith_status add_part(struct kith_search *search, kith_index begin, kith_index n) {
  struct tree *tree = search->self;
  if (n == 0) return KITH_OK;
  KITH_TRY(reserve_scratch(search, n));
  KITH_TRY(order_slots(search, begin, n));
  kith_search_pack(search, begin, n);
  const kith_index first = tree->n_leaves;
  kith_index leaves;
  KITH_TRY(cut_leaves(tree, begin, n, &leaves));
  KITH_TRY(build_levels(search, first, leaves, &tree->part[tree->n_parts++]));
  return add_groups(search, first, leaves);
}

/* Internal nodes, with the leaves of the last update if they may be kept. */
static kith_status add_internal(struct kith_search *search) {
  struct tree *tree = search->self;
  struct kept *kept = &tree->kept;
  const uint64_t order = search->nodes->order;
  tree->sorted = false;
  if (kept->updates > 0 && kept->order == order) {
    --kept->updates;
    tree->n_parts = 1, tree->part[0] = kept->part;
    tree->n_octets = kept->n_octets, tree->n_leaves = kept->n_leaves;
    kith_search_pack(search, 0, search->n_internal);
    enclose_part(search, &kept->part);
    return add_groups(search, 0, kept->n_leaves - 1);
  }
  kept->updates = 0;
  tree->n_parts = 0, tree->n_octets = tree->n_leaves = 0;
  KITH_TRY(add_part(search, 0, search->n_internal));
  if (tree->n_parts == 1 && !tree->sorted && !search->fresh_cells)
    *kept = (struct kept){KEPT, order, tree->n_octets, tree->n_leaves, tree->part[0]};
  return KITH_OK;
}

static kith_status tree_update(struct kith_search *search) {
  struct tree *tree = search->self;
  KITH_TRY(add_internal(search));
  search->in_order = !tree->sorted;
  KITH_TRY(add_part(search, search->n_internal, search->n - search->n_internal));
  if (!tree->sorted) return KITH_OK;
  KITH_TRY(kith_reserve(&tree->slot, &tree->slots_capacity, (size_t)search->n, sizeof *tree->slot));
#pragma omp parallel for schedule(static)
  for (kith_index slot = 0; slot < search->n; ++slot) tree->slot[search->node[slot]] = slot;
  return KITH_OK;
}

/* Selected updates: nodes keep their slots, and boxes are made anew from the leaves that have moved. */

/* Did anything in octet o of this level move? */
static bool enclose_again(const struct kith_search *search, int level, kith_index o) {
  const struct tree *tree = search->self;
  bool any = false;
  for (kith_index c = tree->child[o], k = 0; c < tree->child[o + 1]; ++c, ++k) {
    if (!(level == 0 ? tree->moved[c] : enclose_again(search, level - 1, c))) continue;
    any = true;
    if (level == 0)
      enclose_leaf(search, tree->leaf[c], tree->leaf[c + 1], &tree->octet[o], k);
    else
      enclose_octet(&tree->octet[c], tree->child[c + 1] - tree->child[c], &tree->octet[o], k);
  }
  return any;
}

static kith_status tree_update_selected(struct kith_search *search, const kith_index *nodes,
                                        kith_index count) {
  struct tree *tree = search->self;
  KITH_TRY(kith_reserve(&tree->moved, &tree->moved_capacity, (size_t)tree->n_leaves + 1, 1));
  memset(tree->moved, 0, (size_t)tree->n_leaves + 1);
  if (search->n == search->n_internal) tree->n_parts = search->n > 0; /* ghosts, if any, are gone */
#pragma omp parallel for schedule(static) if (count > KITH_FEW)
  for (kith_index k = 0; k < count; ++k) {
    const kith_index slot = tree->sorted ? tree->slot[nodes[k]] : nodes[k];
    kith_search_pack_slot(search, slot);
#pragma omp atomic write
    tree->moved[kith_lower_bound(tree->leaf, 0, (size_t)tree->n_leaves, slot + 1) - 1] = 1;
  }
  for (int p = 0; p < tree->n_parts; ++p) enclose_again(search, tree->part[p].levels - 1, tree->part[p].root);
  return KITH_OK;
}

/* Queries. */

struct query {
  struct kith_box box;
  double radius2; /* of the targets if it counts, else -1 */
  double cell;    /* factor of the squared radii of cells; 0: they do not count */
  void (*test)(const struct tree *tree, const kith_index *octets, int n, const struct query *q,
               unsigned *mask);
};

static inline double larger(double a, double b) {
  return a > b ? a : b;
}

/* One bit for each of the 8 cells that may interact with the box. Written for the vectorizer. */
static inline unsigned test_cells(const struct octet *restrict octet, const struct query *restrict q) {
  double d2[WIDTH] = {0};
  for (int a = 0; a < NDIM; ++a) {
    const double lower = q->box.lower[a], upper = q->box.upper[a];
#pragma omp simd
    for (int k = 0; k < WIDTH; ++k) {
      const double d = larger(larger(octet->lower[a][k] - upper, lower - octet->upper[a][k]), 0);
      d2[k] += d * d;
    }
  }
  const double radius2 = q->radius2, cell = q->cell;
  int bit[WIDTH];
#pragma omp simd
  for (int k = 0; k < WIDTH; ++k) bit[k] = d2[k] <= larger(cell * octet->radius2[k], radius2) ? 1 << k : 0;
  int mask = 0;
#pragma omp simd reduction(| : mask)
  for (int k = 0; k < WIDTH; ++k) mask |= bit[k];
  return (unsigned)mask;
}

/* Which of its 8 cells an octet has. */
static inline unsigned present(const struct tree *tree, kith_index o) {
  return (1u << (tree->child[o + 1] - tree->child[o])) - 1;
}

/* mask[k]: the cells of octet k that may interact with the box. */
KITH_HOT static void test_octets(const struct tree *tree, const kith_index *octets, int n,
                                 const struct query *q, unsigned *mask) {
  for (int k = 0; k < n; ++k) mask[k] = test_cells(&tree->octet[octets[k]], q) & present(tree, octets[k]);
}

#ifdef __x86_64__
/* The same with masks, which the compiler does not use by itself. */
__attribute__((target("avx512f"))) static void test_octets_wide(const struct tree *tree,
                                                                const kith_index *octets, int n,
                                                                const struct query *q, unsigned *mask) {
  const __m512d zero = _mm512_setzero_pd(), radius2 = _mm512_set1_pd(q->radius2),
                cell = _mm512_set1_pd(q->cell);
  for (int k = 0; k < n; ++k) {
    const struct octet *octet = &tree->octet[octets[k]];
    __m512d d2 = zero;
    for (int a = 0; a < NDIM; ++a) {
      const __m512d above = _mm512_sub_pd(_mm512_loadu_pd(octet->lower[a]), _mm512_set1_pd(q->box.upper[a])),
                    below = _mm512_sub_pd(_mm512_set1_pd(q->box.lower[a]), _mm512_loadu_pd(octet->upper[a])),
                    d = _mm512_max_pd(_mm512_max_pd(above, below), zero), square = _mm512_mul_pd(d, d);
      d2 = a == 0 ? square : _mm512_add_pd(d2, square);
    }
    const __m512d within = _mm512_max_pd(_mm512_mul_pd(cell, _mm512_loadu_pd(octet->radius2)), radius2);
    mask[k] = _mm512_cmp_pd_mask(d2, within, _CMP_LE_OQ) & present(tree, octets[k]);
  }
}
#endif

/* Adjacent leaves are one run. */
static inline kith_status take_leaves(const kith_index *leaf, unsigned mask, struct kith_runs *runs) {
  while (mask) {
    const int k = __builtin_ctz(mask), count = __builtin_ctz(~(mask >> k));
    KITH_TRY(kith_runs_add(runs, leaf[k], leaf[k + count] - leaf[k]));
    mask &= mask + (1u << k);
  }
  return KITH_OK;
}

/* Visits n ascending octets of a level. A batch is tested before its children are visited: independent tests
 * overlap in time. */
static kith_status visit(const struct tree *tree, int level, const kith_index *octets, int n,
                         const struct query *q, struct kith_runs *runs) {
  unsigned mask[BATCH];
  for (int from = 0; from < n; from += BATCH) {
    const int batch = KITH_MIN(BATCH, n - from);
    const kith_index *octet = octets + from;
    q->test(tree, octet, batch, q, mask);
    if (level == 0) {
      for (int k = 0; k < batch; ++k)
        KITH_TRY(take_leaves(tree->leaf + tree->child[octet[k]], mask[k], runs));
      continue;
    }
    kith_index children[BATCH * WIDTH];
    int m = 0;
    for (int k = 0; k < batch; ++k)
      for (unsigned left = mask[k]; left != 0; left &= left - 1)
        children[m++] = tree->child[octet[k]] + __builtin_ctz(left);
    KITH_TRY(visit(tree, level - 1, children, m, q, runs));
  }
  return KITH_OK;
}

static kith_status tree_coarse(const struct kith_search *search, const struct kith_box *box, double radius,
                               enum kith_search_mode mode, struct kith_runs *runs) {
  const struct tree *tree = search->self;
  const double loose = 1 + KITH_SEARCH_SLACK;
  struct query q = {.box = *box,
                    .radius2 = mode == KITH_SCATTER ? -1 : radius * radius * loose,
                    .cell = mode == KITH_GATHER ? 0 : loose,
                    .test = test_octets};
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f")) q.test = test_octets_wide;
#endif
  for (int p = 0; p < tree->n_parts; ++p)
    KITH_TRY(visit(tree, tree->part[p].levels - 1, &tree->part[p].root, 1, &q, runs));
  return KITH_OK;
}

static size_t tree_bytes(const struct kith_search *search) {
  const struct tree *tree = search->self;
  return tree->octets_capacity * sizeof *tree->octet + tree->children_capacity * sizeof *tree->child +
         tree->leaves_capacity * sizeof *tree->leaf + 2 * tree->sort_capacity * sizeof **tree->item +
         tree->slots_capacity * sizeof *tree->slot + tree->moved_capacity;
}

const struct kith_search_ops kith_search_tree = {
    .name = "tree",
    .doc = "space-filling-curve order, leaves of a few nodes, tight boxes in a tree eight wide: the default",
    .state_size = sizeof(struct tree),
    .clear = tree_clear,
    .update = tree_update,
    .update_selected = tree_update_selected,
    .coarse = tree_coarse,
    .bytes = tree_bytes,
};
