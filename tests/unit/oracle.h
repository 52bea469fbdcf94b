/* oracle.h - nodes for tests of connectivity, and its slow oracle: loops over all nodes that apply the
 * definitions of neighbor, overlap and intersection directly, without search or rows. */
#ifndef KITH_TEST_ORACLE_H
#define KITH_TEST_ORACLE_H

#include <stdlib.h>
#include <string.h>
#include "lib/connectivity/connectivity.h"
#include "lib/nodes/nodes.h"
#include "tests/check.h"

/* Sums d^2 axis by axis, in the order of the library. volatile prevents fused multiply-adds, which round
 * differently. */
static inline double oracle_distance2(const struct kith_nodes *nodes, int i, int j) {
  double sum = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = nodes->position->f64[i * NDIM + a] - nodes->position->f64[j * NDIM + a];
    volatile const double square = d * d;
    sum = sum + square;
  }
  return sum;
}
/* Is node k within the support of node i? */
static inline bool oracle_supports(const struct kith_nodes *nodes, int i, int k) {
  const double search_radius = nodes->search_radius->f64[i];
  return oracle_distance2(nodes, i, k) <= search_radius * search_radius;
}
/* The pair of i and j, neither displaced, by the row of i, or if it has none by that of j; pairs.n if there
 * is none. */
static inline size_t oracle_pair(const struct kith_connectivity *c, kith_index i, kith_index j) {
  const struct kith_rows *rows = &c->rows;
  const kith_index end = c->canonical ? c->n_internal : rows->n, row = i < end ? i : j,
                   other = i < end ? j : i;
  if (row >= end) return c->pairs.n;
  for (size_t e = rows->first[row]; e < rows->first[row + 1]; ++e)
    if (rows->node[e] == other && kith_row_shift(rows, e) == rows->zero) return c->pairs.of_row[e];
  return c->pairs.n;
}
static inline bool oracle_rejected(const struct kith_excluder *chain, const struct kith_nodes *nodes, int i,
                                   int j) {
  const struct kith_selection all = {.nodes = nodes};
  const struct kith_candidate candidate = {&all, &all, i, j, nodes->shifts.zero};
  for (; chain; chain = chain->next)
    if (chain->ops->reject(chain, &candidate)) return true;
  return false;
}
static inline bool oracle_near(const struct kith_nodes *nodes, const struct kith_excluder *chain, int i,
                               int j) {
  return i != j && (oracle_supports(nodes, i, j) || oracle_supports(nodes, j, i)) &&
         !oracle_rejected(chain, nodes, i, j);
}
static inline bool oracle_neighbors(const struct kith_nodes *nodes, const struct kith_excluder *chain, int i,
                                    int j) {
  return (kith_node_active(nodes, i) || kith_node_active(nodes, j)) && oracle_near(nodes, chain, i, j);
}
static inline bool oracle_overlap(const struct kith_nodes *nodes, const struct kith_excluder *chain, int i,
                                  int j) {
  if (i == j || oracle_rejected(chain, nodes, i, j)) return false;
  if (oracle_neighbors(nodes, chain, i, j)) return true;
  for (int k = 0; k < kith_nodes_count(nodes); ++k)
    if (k != i && k != j && oracle_supports(nodes, i, k) && oracle_supports(nodes, j, k) &&
        !oracle_rejected(chain, nodes, i, k) && !oracle_rejected(chain, nodes, j, k))
      return true;
  return false;
}
static inline bool oracle_between(const struct kith_nodes *nodes, int i, int j, int k) {
  const double *x = nodes->position->f64;
  double from_i = 0, from_j = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double e = x[j * NDIM + a] - x[i * NDIM + a];
    volatile const double p = (x[k * NDIM + a] - x[i * NDIM + a]) * e,
                          q = (x[k * NDIM + a] - x[j * NDIM + a]) * -e;
    from_i += p, from_j += q;
  }
  return from_i > 0 && from_j > 0;
}
static inline bool oracle_in_intersection(const struct kith_nodes *nodes, const struct kith_excluder *chain,
                                          bool on_segment, int i, int j, int k) {
  if (k == i || k == j) return true;
  return oracle_near(nodes, chain, i, k) && oracle_near(nodes, chain, j, k) &&
         (!on_segment || oracle_between(nodes, i, j, k));
}

/* Checks that a row holds exactly the nodes k < count that satisfy the predicate, in ascending order. */
#define ORACLE_ROW(rows, row, count, k, predicate)                                                           \
  do {                                                                                                       \
    size_t oracle_e_ = (rows)->first[row];                                                                   \
    bool oracle_same_ = true;                                                                                \
    for (int k = 0; k < (count); ++k)                                                                        \
      if (predicate) {                                                                                       \
        oracle_same_ = oracle_same_ && oracle_e_ < (rows)->first[(row) + 1] && (rows)->node[oracle_e_] == k; \
        ++oracle_e_;                                                                                         \
      }                                                                                                      \
    CHECK(oracle_same_ &&oracle_e_ == (rows)->first[(row) + 1]);                                             \
  } while (0)

/* Checks the pairs of the first `n` rows: they are the entries j > i of each row, in order, and each entry
 * refers to its pair. */
static inline void oracle_check_pairs(const struct kith_rows *rows, const struct kith_pairs *pairs,
                                      kith_index n) {
  size_t p = 0;
  for (kith_index i = 0; i < n; ++i) {
    CHECK(pairs->first[i] == p);
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e], *ends = pairs->node[pairs->of_row[e]];
      CHECK(ends[0] == KITH_MIN(i, j) && ends[1] == KITH_MAX(i, j));
      if (j > i) CHECK(pairs->of_row[e] == p++);
    }
  }
  CHECK(p == pairs->n && pairs->first[n] == p);
}

/* Compares all rows and pairs that were built with the definitions. Cost O(N^3). */
static inline void oracle_check(const struct kith_connectivity *c, const struct kith_nodes *nodes,
                                const struct kith_excluder *chain) {
  const int n = kith_nodes_count(nodes), stored = c->built.ghost_rows ? n : nodes->n_internal;
  CHECK(c->rows.n == stored);
  for (int i = 0; i < stored; ++i) ORACLE_ROW(&c->rows, i, n, j, oracle_neighbors(nodes, chain, i, j));
  if (c->built.overlap)
    for (int i = 0; i < stored; ++i) ORACLE_ROW(&c->overlap, i, n, j, oracle_overlap(nodes, chain, i, j));
  if (c->built.overlap_pairs) oracle_check_pairs(&c->overlap, &c->overlap_pairs, nodes->n_internal);
  if (!c->built.pairs) return;
  oracle_check_pairs(&c->rows, &c->pairs, stored);
  size_t next = 0;
  for (int i = 0; i < stored; ++i)
    for (int j = i + 1; j < n; ++j) {
      const bool is_pair = oracle_neighbors(nodes, chain, i, j);
      const size_t p = is_pair ? next++ : c->pairs.n;
      CHECK(oracle_pair(c, i, j) == p && oracle_pair(c, j, i) == p);
      if (is_pair && c->built.intersection)
        ORACLE_ROW(&c->intersection, p, n, k,
                   oracle_in_intersection(nodes, chain, c->built.on_segment, i, j, k));
    }
}

/* Are two connectivities bitwise identical? */
static inline bool oracle_identical_rows(const struct kith_rows *a, const struct kith_rows *b) {
  if (a->n != b->n) return false;
  if (a->n == 0) return true;
  return memcmp(a->first, b->first, ((size_t)a->n + 1) * sizeof *a->first) == 0 &&
         (a->first[a->n] == 0 || memcmp(a->node, b->node, a->first[a->n] * sizeof *a->node) == 0) &&
         (a->shift == NULL) == (b->shift == NULL) &&
         (a->shift == NULL || memcmp(a->shift, b->shift, a->first[a->n] * sizeof *a->shift) == 0);
}
/* `n`: the number of rows that have pairs. */
static inline bool oracle_identical_pairs(const struct kith_pairs *a, const struct kith_pairs *b,
                                          const struct kith_rows *rows, kith_index n) {
  if (a->n != b->n || a->starts != b->starts) return false;
  if (memcmp(a->first, b->first, ((size_t)n + 1) * sizeof *a->first) != 0) return false;
  return a->n == 0 || (memcmp(a->node, b->node, a->n * sizeof *a->node) == 0 &&
                       memcmp(a->of_row, b->of_row, rows->first[n] * sizeof *a->of_row) == 0);
}
static inline bool oracle_identical(const struct kith_connectivity *a, const struct kith_connectivity *b) {
  if (!oracle_identical_rows(&a->rows, &b->rows) || !oracle_identical_rows(&a->overlap, &b->overlap))
    return false;
  if (!oracle_identical_rows(&a->intersection, &b->intersection)) return false;
  if (a->built.overlap_pairs != b->built.overlap_pairs || a->built.pairs != b->built.pairs) return false;
  if (a->built.overlap_pairs &&
      !oracle_identical_pairs(&a->overlap_pairs, &b->overlap_pairs, &a->overlap, a->n_internal))
    return false;
  return !a->built.pairs || oracle_identical_pairs(&a->pairs, &b->pairs, &a->rows, a->rows.n);
}

/* A connectivity that was built with this search, and is valid. */
static inline struct kith_connectivity *oracle_build(const struct kith_nodes *nodes,
                                                     const struct kith_search_ops *ops,
                                                     struct kith_requirements need,
                                                     struct kith_excluder *chain) {
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  CHECK_OK(kith_search_create(&search, ops, nodes));
  CHECK_OK(kith_search_update(search));
  CHECK_OK(kith_connectivity_create(&connectivity));
  CHECK_OK(kith_connectivity_build(connectivity, nodes, search, need, chain, NULL));
  CHECK_OK(kith_connectivity_valid(connectivity, nodes));
  if (ops->sweep != NULL && need.rows)
    CHECK_OK(kith_connectivity_complete(connectivity, search, chain != NULL));
  kith_search_destroy(&search);
  return connectivity;
}

/* Builds everything with every search, without and with rows of ghosts, with whole intersections and those on
 * the segment: the oracle agrees, and searches are bitwise identical. Returns the number of pairs. */
static inline size_t oracle_conforms(const struct kith_nodes *nodes, struct kith_excluder *chain) {
  size_t pairs = 0;
  for (int variant = 0; variant < 4; ++variant) {
    const struct kith_requirements need = {.rows = true,
                                           .pairs = true,
                                           .overlap_pairs = true,
                                           .intersection = true,
                                           .ghost_rows = variant & 1,
                                           .on_segment = variant & 2};
    struct kith_connectivity *first = oracle_build(nodes, kith_search_find("brute"), need, chain);
    oracle_check(first, nodes, chain);
    for (const struct kith_search_ops *const *ops = kith_search_all(); *ops != NULL; ++ops) {
      struct kith_connectivity *other = oracle_build(nodes, *ops, need, chain);
      CHECK(oracle_identical(first, other));
      kith_connectivity_destroy(&other);
    }
    if (variant == 0) pairs = first->pairs.n;
    kith_connectivity_destroy(&first);
  }
  return pairs;
}

/* Creates lists of count[l] nodes at random places in the unit box, with search radii between `search_radius`
 * and search_radius * ratio. */
static inline struct kith_nodes *oracle_random(int n_lists, const int *count, double search_radius,
                                               double ratio, uint64_t *state) {
  static const char *const names[] = {"gas", "dust", "rock"};
  struct kith_nodes *nodes;
  CHECK_OK(kith_nodes_create(&nodes, n_lists, names));
  for (int l = 0; l < n_lists; ++l) {
    kith_index first;
    CHECK_OK(kith_nodes_append(nodes, l, count[l], &first));
    for (int i = first; i < first + count[l]; ++i) {
      for (int a = 0; a < NDIM; ++a) nodes->position->f64[i * NDIM + a] = check_random(state);
      nodes->search_radius->f64[i] = search_radius * pow(ratio, check_random(state));
      nodes->id->i64[i] = 1000 * l + i - first;
    }
  }
  ++nodes->positions;
  return nodes;
}

/* Creates a cubic lattice of n^NDIM nodes with spacing 1 / n and equal search radii; lattice points are dealt
 * out to the lists in turn. */
static inline struct kith_nodes *oracle_lattice(int n_lists, int n, double search_radius) {
  int total = 1, count[3] = {0};
  for (int a = 0; a < NDIM; ++a) total *= n;
  for (int k = 0; k < total; ++k) ++count[k % n_lists];
  uint64_t state = 1;
  struct kith_nodes *nodes = oracle_random(n_lists, count, search_radius, 1, &state);
  int next[3] = {0};
  for (int k = 0; k < total; ++k) {
    const int i = nodes->lists[k % n_lists].first + next[k % n_lists]++;
    for (int a = 0, rest = k; a < NDIM; ++a, rest /= n)
      nodes->position->f64[i * NDIM + a] = (rest % n + 0.5) / n;
  }
  ++nodes->positions;
  return nodes;
}

/* Adds ghosts: images, along axis a, of all present nodes (ghosts too) that come within `depth` of the unit
 * box, shifted by 1 (periodic) or reflected at 0 and 1. */
static inline void oracle_ghosts(struct kith_nodes *nodes, int axis, bool mirror, double depth) {
  const int n = kith_nodes_count(nodes);
  for (int side = 0; side < 2; ++side)
    for (int l = 0; l < nodes->n_lists; ++l) {
      struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .boundary = axis, .list = l};
      for (int a = 0; a < NDIM; ++a) block.image.sign[a] = 1;
      block.image.sign[axis] = mirror ? -1 : 1;
      block.image.shift[axis] = mirror ? 2 * side : 2 * side - 1;
      CHECK_OK(kith_resize(&block.control, 0, (size_t)n + 1, sizeof *block.control));
      for (int i = 0; i < n; ++i) {
        const double x =
            block.image.sign[axis] * nodes->position->f64[i * NDIM + axis] + block.image.shift[axis];
        if (nodes->list->u8[i] == l && x >= -depth && x <= 1 + depth && (side ? x >= 1 : x <= 0))
          block.control[block.count++] = i;
      }
      if (block.count > 0)
        CHECK_OK(kith_nodes_add_ghosts(nodes, &block));
      else
        kith_free(&block.control);
    }
}

#endif
