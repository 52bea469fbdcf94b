/* test_images.c - images of whole lattices: in a periodic lattice each node has the density of an infinite
 * one (oracle: lattice vectors), also with a single node in the box. Images are bitwise identical for any
 * number of threads, and the same for any order of nodes. */
#include "tests/check.h"
#include "boundaries/boundary.h"
#include <omp.h>
#include <string.h>

/* The sum of (1 - (r/R)^2)^3 over all nodes and ghosts within R of x. */
static double density(const struct kith_nodes *nodes, const double *x, double radius, int *within) {
  double sum = 0;
  *within = 0;
  for (kith_index j = 0; j < kith_nodes_count(nodes); ++j) {
    const double q = kith_distance2(x, nodes->position->f64 + j * NDIM) / (radius * radius);
    if (q > 1) continue;
    sum += (1 - q) * (1 - q) * (1 - q);
    ++*within;
  }
  return sum;
}

/* The same sum over the vectors of an infinite lattice. */
static double lattice_density(double radius, double spacing, int *within) {
  const int range = (int)(radius / spacing) + 1, edge = 2 * range + 1;
  double sum = 0;
  *within = 0;
  for (int k = 0; k < (NDIM == 1 ? edge : NDIM == 2 ? edge * edge : edge * edge * edge); ++k) {
    int square = 0;
    for (int a = 0, rest = k; a < NDIM; ++a, rest /= edge)
      square += (rest % edge - range) * (rest % edge - range);
    const double q = square * spacing * spacing / (radius * radius);
    if (q > 1) continue;
    sum += (1 - q) * (1 - q) * (1 - q);
    ++*within;
  }
  return sum;
}

/* A periodic lattice of `cells` nodes along each axis. With cells = 1 the box is thinner than a support. */
static void check_lattice_density(int cells, double search_radius) {
  static const char *const names[] = {"only"};
  const double spacing = 1.0 / cells;
  struct kith_nodes *nodes = NULL;
  struct kith_boundaries all = {0};
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  const kith_index n = NDIM == 1 ? cells : NDIM == 2 ? cells * cells : cells * cells * cells;
  CHECK_OK(kith_nodes_append(nodes, 0, n, NULL));
  for (kith_index i = 0; i < n; ++i) {
    nodes->search_radius->f64[i] = search_radius * spacing;
    for (int a = 0, k = i; a < NDIM; ++a, k /= cells)
      nodes->position->f64[i * NDIM + a] = (k % cells) * spacing;
  }
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(&all, &kith_boundary_periodic, a, 0, 1, true, true));
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, NULL));
  int wanted, within;
  const double rho = lattice_density(search_radius * spacing, spacing, &wanted);
  for (kith_index i = 0; i < n; ++i) {
    CHECK_CLOSE(density(nodes, nodes->position->f64 + i * NDIM, search_radius * spacing, &within) / rho, 1,
                1e-12); /* round-off of sums */
    CHECK(within == wanted);
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

/* Many nodes and their ghosts, whose values follow their controls after these have moved. */
static struct kith_nodes *many_nodes(int threads, struct kith_boundaries *all) {
  static const char *const names[] = {"a", "b", "c"};
  struct kith_nodes *nodes = NULL;
  uint64_t seed = 77;
  omp_set_num_threads(threads);
  CHECK_OK(kith_nodes_create(&nodes, 3, names));
  for (int l = 0; l < 3; ++l) CHECK_OK(kith_nodes_append(nodes, l, 9001, NULL));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    nodes->id->i64[i] = i;
    nodes->search_radius->f64[i] = 0.02 + 0.05 * check_random(&seed);
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[i * NDIM + a] = check_random(&seed);
  }
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(all, a == 0 ? &kith_boundary_reflecting : &kith_boundary_periodic, a, 0, 1,
                                 true, true));
  CHECK_OK(kith_boundaries_ghosts(all, nodes, 1, NULL));
  for (kith_index i = 0; i < nodes->n_internal * NDIM; ++i)
    nodes->position->f64[i] += 0.01 * (check_random(&seed) - 0.5);
  kith_nodes_refresh_images(nodes, &nodes->position, 1);
  return nodes;
}

static void check_threads(void) {
  struct kith_boundaries all[2] = {0};
  struct kith_nodes *one = many_nodes(1, &all[0]), *two = many_nodes(2, &all[1]);
  const size_t n = (size_t)kith_nodes_count(one);
  CHECK(one->n_ghost > 2000 && one->n_ghost == two->n_ghost && one->n_blocks == two->n_blocks);
  CHECK(memcmp(one->position->f64, two->position->f64, n * NDIM * sizeof(double)) == 0);
  CHECK(memcmp(one->id->i64, two->id->i64, n * sizeof(int64_t)) == 0);
  double worst = 0;
  for (int b = 0; b < one->n_blocks; ++b)
    for (kith_index k = 0; k < one->blocks[b].count * NDIM; ++k) {
      const struct kith_ghost_block *block = &one->blocks[b];
      const int a = (int)(k % NDIM);
      const double x = one->position->f64[block->control[k / NDIM] * NDIM + a],
                   y = one->position->f64[block->first * NDIM + k];
      worst = fmax(worst, fabs(block->image.sign[a] * x + block->image.shift[a] - y));
    }
  CHECK(worst <= 1e-15); /* one rounding of a number below 2 */
  for (int k = 0; k < 2; ++k) kith_boundaries_clear(&all[k]);
  kith_nodes_destroy(&one);
  kith_nodes_destroy(&two);
}

/* Sorts each list by this coordinate, or by id if axis is -1. */
static void sort_along(struct kith_nodes *nodes, int axis) {
  const size_t n = (size_t)nodes->n_internal;
  uint64_t *key = NULL;
  CHECK_OK(kith_resize(&key, 0, n, sizeof *key));
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    key[i] = axis < 0 ? (uint64_t)nodes->id->i64[i]
                      : (uint64_t)(1e9 * (1 + nodes->position->f64[i * NDIM + axis]));
  CHECK_OK(kith_nodes_sort(nodes, key, NULL));
  kith_free(&key);
}

/* A number that depends on the ghosts, but not on their order. */
static uint64_t checksum(const struct kith_nodes *nodes) {
  uint64_t sum = (uint64_t)nodes->n_ghost;
  for (kith_index g = nodes->n_internal; g < kith_nodes_count(nodes); ++g) {
    uint64_t word = (uint64_t)nodes->id->i64[g] + 1;
    for (int a = 0; a < NDIM; ++a) {
      uint64_t bits;
      memcpy(&bits, &nodes->position->f64[g * NDIM + a], sizeof bits);
      word = (word ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
      word ^= word >> 29;
    }
    sum += word;
  }
  return sum;
}

/* Ghosts are the same whether successive nodes are close together or not, and also if the order changes after
 * nodes were measured. */
static void check_order(void) {
  struct kith_boundaries all = {0};
  struct kith_nodes *nodes = many_nodes(1, &all);
  /* wide supports in the middle, which reach beyond each face */
  for (kith_index i = 0; i < nodes->n_internal; i += 5000) {
    nodes->search_radius->f64[i] = 0.6;
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[i * NDIM + a] = 0.45 + 1e-6 * i;
  }
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, NULL)); /* nodes have moved since the ghosts were made */
  const uint64_t wanted = checksum(nodes);
  for (int a = 0; a < NDIM; ++a) {
    kith_nodes_drop_ghosts(nodes);
    sort_along(nodes, a);
    CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, NULL));
    CHECK(checksum(nodes) == wanted);
    kith_nodes_drop_ghosts(nodes);
    kith_boundaries_measure(&all, nodes, 1);
    sort_along(nodes, -1);
    CHECK_OK(kith_boundaries_make_ghosts(&all, nodes, 1, NULL, KITH_OK));
    CHECK(checksum(nodes) == wanted);
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  omp_set_num_threads(1);
  check_lattice_density(1, 2.5);
  check_lattice_density(1, 0.5);
  check_lattice_density(2, 3.3);
  check_lattice_density(5, 2.43);
  check_lattice_density(7, 1.9);
  check_threads();
  check_order();
  return check_failed();
}
