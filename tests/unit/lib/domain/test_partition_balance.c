/* test_partition_balance.c - how well each partitioner balances loads, against bounds that follow from its
 * method (reasons are given with each), and what its updates must never do. Loads are summed here, cell by
 * cell. */
#include "lib/domain/partition/partition.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/lib/domain/cell_box.h"
#include "tests/unit/lib/domain/partition_world.h"

enum { MOST_CELLS = 4096, MOST_RANKS = 64, KINDS = 4 };

/* A box of about a thousand cells, open or periodic. */
static struct kith_cells thousand_cells(bool periodic) {
  const int count[3][3] = {{1000, 0, 0}, {40, 25, 0}, {12, 10, 9}};
  return grid(count[NDIM - 1], periodic ? ~0 : 0);
}

/* Kinds: equal; a blast in a corner (a dense shell around an empty ball); random from 1 to 10; all weight in
 * one cell. */
static void weights(const struct kith_cells *cells, int kind, double *weight) {
  uint64_t random = 11;
  for (int64_t c = 0; c < cells->n; ++c) {
    const struct kith_box box = cell_box(cells, c);
    double r2 = 0;
    for (int a = 0; a < NDIM; ++a) r2 += box.lower[a] * box.lower[a] / (cells->upper[a] * cells->upper[a]);
    const double r = sqrt(r2), shell = (r - 0.5) / 0.1;
    const double values[KINDS] = {1, (r < 0.4 ? 0.02 : 1) + 10 * exp(-shell * shell),
                                  1 + 9 * check_random(&random), c == cells->n / 3};
    weight[c] = values[kind];
  }
}

struct rank_figures {
  double weight;
  int64_t cells;
};
struct load_figures {
  double mean_weight, largest_weight, imbalance;
};

static struct load_figures load_figures(const struct kith_partition *partition, const double *weight,
                                        struct rank_figures *rank) {
  struct load_figures all = {0};
  double load[MOST_RANKS];
  memset(rank, 0, sizeof *rank * (size_t)partition->n_ranks);
  for (int64_t c = 0; c < partition->cells->n; ++c) {
    rank[partition->owner[c]].weight += weight == NULL ? 1 : weight[c];
    ++rank[partition->owner[c]].cells;
  }
  for (int r = 0; r < partition->n_ranks; ++r) {
    all.mean_weight += rank[r].weight / partition->n_ranks;
    all.largest_weight = KITH_MAX(all.largest_weight, rank[r].weight);
  }
  all.imbalance = kith_partition_loads(partition, partition->owner, weight, load);
  for (int r = 0; r < partition->n_ranks; ++r) CHECK(load[r] == rank[r].weight);
  CHECK_CLOSE(all.imbalance, all.mean_weight > 0 ? all.largest_weight / all.mean_weight : 1, 1e-12);
  return all;
}

static bool update(struct kith_partition *partition, const double *weight) {
  bool changed = false;
  CHECK_OK(kith_partition_update(partition, weight, &changed));
  return changed;
}

/* Adds the work of an empty cell, as partitioners do. */
static void effective_weights(const struct kith_cells *cells, const double *weight, double *effective) {
  double total = 0;
  for (int64_t c = 0; c < cells->n; ++c) total += weight[c];
  for (int64_t c = 0; c < cells->n; ++c)
    effective[c] = weight[c] + KITH_EMPTY_CELL * total / (double)cells->n;
}

/* The largest load is at most `factor` times the mean plus `most_cells` times the heaviest cell. */
static void check_bound(const struct kith_cells *cells, const char *text, double factor, double most_cells) {
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64};
  for (int r = 0; r < 7; ++r) {
    struct kith_partition *partition = partition_of(cells, ranks[r], text);
    for (int kind = 0; kind < KINDS; ++kind) {
      static double weight[MOST_CELLS], effective[MOST_CELLS];
      struct rank_figures rank[MOST_RANKS];
      weights(cells, kind, weight);
      update(partition, weight);
      if (partition->ops != &kith_partitioner_graph) /* graph continues from the present map */
        CHECK(!update(partition, weight));           /* equal weights keep the map */
      effective_weights(cells, weight, effective);
      const struct load_figures all = load_figures(partition, effective, rank);
      double heaviest = 0;
      for (int64_t c = 0; c < cells->n; ++c) heaviest = KITH_MAX(heaviest, effective[c]);
      const double bound = factor * all.mean_weight + most_cells * heaviest;
      CHECK(all.largest_weight <= bound * (1 + 1e-12)); /* rounding of sums in another order */
      if (check_failures > 0) {
        fprintf(stderr, "  %s, %d ranks, weights %d: %g of %g\n", text, ranks[r], kind, all.largest_weight,
                bound);
        exit(1);
      }
    }
    kith_partition_destroy(&partition);
  }
}

static void test_bounds(void) {
  for (int periodic = 0; periodic < 2; ++periodic) {
    const struct kith_cells cells = thousand_cells(periodic);
    /* The mean load, and half a cell at both ends of the interval. */
    check_bound(&cells, "morton", 1, 1);
    check_bound(&cells, "hilbert", 1, 1);
    /* A cut can miss its place by half a cell, whose load is shared by the ranks beyond it: 1 for the last
     * cut, at least 2, 3, 5, 9 ... for those before. The sum is 1.13 cells. */
    check_bound(&cells, "kd", 1, 1.13);
    if (kith_partitioner_p4est.needs == NULL) check_bound(&cells, "p4est", 1, 1);
    /* Scotch aims at 5 % and promises nothing: twice that, and a cell and a half, which cannot be divided. */
    if (kith_partitioner_graph.needs == NULL) check_bound(&cells, "graph", 1.1, 1.5);
  }
}

/* Blocks differ by one layer along each axis at most, and updates do not move them. */
static void test_cart(void) {
  const struct kith_cells cells = thousand_cells(false);
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64};
  for (int r = 0; r < 7; ++r) {
    static double weight[MOST_CELLS];
    struct rank_figures rank[MOST_RANKS];
    struct kith_partition *partition = partition_of(&cells, ranks[r], "cart");
    int mesh[NDIM], product = 1;
    kith_partition_mesh(&cells, ranks[r], NDIM, mesh);
    int64_t least = 1, most = 1;
    for (int a = 0; a < NDIM; ++a) {
      product *= mesh[a];
      least *= cells.count[a] / mesh[a];
      most *= (cells.count[a] + mesh[a] - 1) / mesh[a];
    }
    CHECK(product == ranks[r]);
    load_figures(partition, NULL, rank);
    for (int p = 0; p < ranks[r]; ++p) CHECK(rank[p].cells >= least && rank[p].cells <= most);
    weights(&cells, 1, weight);
    CHECK(!update(partition, weight) && partition->generation == 1);
    kith_partition_destroy(&partition);
  }
}

/* Meshes are as compact as balance allows: slabs are not preferred because their largest block is one layer
 * smaller. */
static void test_meshes(void) {
  const struct {
    int cells[3], n_ranks, mesh[3];
  } wanted[] = {{{127, 127, 0}, 64, {8, 8, 0}}, {{127, 64, 0}, 8, {4, 2, 0}}, {{100, 3, 0}, 8, {8, 1, 0}},
                {{25, 25, 25}, 64, {4, 4, 4}},  {{12, 12, 12}, 8, {2, 2, 2}}, {{64, 4, 4}, 8, {8, 1, 1}},
                {{40, 40, 10}, 16, {4, 4, 1}}};
  for (size_t k = 0; k < sizeof wanted / sizeof wanted[0]; ++k) {
    double lower[NDIM], upper[NDIM];
    bool periodic[NDIM];
    int mesh[NDIM];
    struct kith_cells cells;
    if ((wanted[k].cells[2] > 0) != (NDIM == 3) || NDIM == 1) continue;
    for (int a = 0; a < NDIM; ++a) lower[a] = 0, upper[a] = wanted[k].cells[a], periodic[a] = false;
    CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1, INT32_MAX));
    kith_partition_mesh(&cells, wanted[k].n_ranks, NDIM, mesh);
    for (int a = 0; a < NDIM; ++a) CHECK(mesh[a] == wanted[k].mesh[a]);
  }
}

/* Curves: along Hilbert's, successive cells share a face where the box is a power of two wide; those of
 * Morton and p4est fill each block of 2^NDIM cells before the next. The order is read from a map with one
 * rank per cell. */
static void test_curves(void) {
  double lower[NDIM], upper[NDIM];
  const bool periodic[NDIM] = {false};
  for (int a = 0; a < NDIM; ++a) lower[a] = 0, upper[a] = 8;
  struct kith_cells cells;
  CHECK_OK(kith_cells_init(&cells, lower, upper, periodic, 1, MOST_CELLS));
  struct kith_partition *hilbert = partition_of(&cells, (int)cells.n, "hilbert");
  static int64_t cell[MOST_CELLS];
  for (int64_t c = 0; c < cells.n; ++c) cell[hilbert->owner[c]] = c;
  for (int64_t k = 1; k < cells.n; ++k) {
    bool faces = false;
    for (int side = 0; side < 2 * NDIM; ++side)
      faces = faces || kith_cells_beside(&cells, cell[k], side / 2, side % 2 * 2 - 1) == cell[k - 1];
    CHECK(faces);
  }
  kith_partition_destroy(&hilbert);
  const char *const names[] = {"morton", "p4est"};
  for (int k = 0; k < 2; ++k) {
    if (kith_partitioner_find(names[k])->needs != NULL) continue;
    struct kith_partition *partition = partition_of(&cells, (int)cells.n, names[k]);
    for (int64_t c = 0; c < cells.n; ++c) { /* a block of 2^NDIM cells has successive owners */
      int64_t at[NDIM];
      kith_grid_place(cells.count, c, at);
      for (int a = 0; a < NDIM; ++a) at[a] -= at[a] % 2;
      CHECK(partition->owner[c] >> NDIM == partition->owner[kith_grid_number(cells.count, at)] >> NDIM);
    }
    kith_partition_destroy(&partition);
  }
}

/* An update of graph starts from the present map, so that a small change of weights moves few cells. */
static void test_graph_stays(void) {
  if (kith_partitioner_graph.needs != NULL) return;
  const struct kith_cells cells = thousand_cells(false);
  static double weight[MOST_CELLS];
  static int32_t before[MOST_CELLS];
  struct kith_partition *partition = partition_of(&cells, 8, "graph");
  weights(&cells, 2, weight);
  for (int k = 0; k < 3; ++k) update(partition, weight);
  memcpy(before, partition->owner, (size_t)cells.n * sizeof *before);
  weight[0] *= 1.5;
  update(partition, weight);
  int64_t moved = 0;
  for (int64_t c = 0; c < cells.n; ++c) moved += before[c] != partition->owner[c];
  CHECK(moved < cells.n / 4); /* with newly numbered parts, seven of eight would move */
  kith_partition_destroy(&partition);
}

/* ---- diffusion ---- */

/* One update: the largest load never rises; the sum of squares falls if anything moves; only cells at borders
 * move, and only to a neighboring rank; no rank loses its last cell. */
static void check_update(struct kith_partition *partition, const double *weight) {
  static int32_t before[MOST_CELLS];
  static double effective[MOST_CELLS];
  struct rank_figures old[MOST_RANKS], rank[MOST_RANKS];
  const struct kith_cells *cells = partition->cells;
  memcpy(before, partition->owner, (size_t)cells->n * sizeof *before);
  effective_weights(cells, weight, effective);
  const struct load_figures first = load_figures(partition, effective, old);
  const bool changed = update(partition, weight);
  const struct load_figures all = load_figures(partition, effective, rank);
  CHECK(all.largest_weight <= first.largest_weight * (1 + 1e-12)); /* rounding of sums in another order */
  double squares = 0;
  for (int r = 0; r < partition->n_ranks; ++r) {
    squares += rank[r].weight * rank[r].weight - old[r].weight * old[r].weight;
    CHECK(rank[r].cells > 0 || old[r].cells == 0);
  }
  CHECK(changed ? squares < 0 : squares == 0);
  for (int64_t c = 0; c < cells->n; ++c) {
    if (before[c] == partition->owner[c]) continue;
    bool beside = false;
    for (int side = 0; side < 2 * NDIM; ++side) {
      const int64_t d = kith_cells_beside(cells, c, side / 2, side % 2 * 2 - 1);
      beside = beside || (d >= 0 && before[d] == partition->owner[c]);
    }
    CHECK(beside);
  }
}

/* Are the ranks of each two adjacent cells in the table? With `note`, adds them. */
static bool neighbors_are_in(const struct kith_partition *partition, bool (*table)[MOST_RANKS], bool note) {
  bool all = true;
  for (int64_t c = 0; c < partition->cells->n; ++c) {
    struct kith_cell_image neighbor[KITH_CELL_NEIGHBORS];
    const int n = kith_cells_neighbors(partition->cells, c, neighbor, NULL);
    for (int k = 0; k < n; ++k) {
      const int p = partition->owner[c], q = partition->owner[neighbor[k].cell];
      if (note) table[p][q] = true;
      all = all && (table[p][q] || p == q);
    }
  }
  return all;
}

/* Two kinds of weights, one after the other: the imbalance falls with both, and each update keeps the
 * rules. */
static void check_diffusion(const struct kith_cells *cells, int n_ranks, const char *text) {
  static double weight[MOST_CELLS];
  static bool table[MOST_RANKS][MOST_RANKS];
  struct rank_figures rank[MOST_RANKS];
  const bool fixed = strstr(text, "fixed") != NULL;
  struct kith_partition *partition = partition_of(cells, n_ranks, text);
  memset(table, 0, sizeof table);
  neighbors_are_in(partition, table, true);
  for (int kind = 2; kind > 0; --kind) { /* first random, then the blast */
    weights(cells, kind, weight);
    const double first = load_figures(partition, weight, rank).imbalance;
    for (int k = 0; k < 8; ++k) {
      check_update(partition, weight);
      CHECK(!fixed || neighbors_are_in(partition, table, false));
    }
    const double last = load_figures(partition, weight, rank).imbalance;
    CHECK(last < first || first < 1.05);
    if (check_failures > 0)
      fprintf(stderr, "  %s, %d ranks, weights %d: %g, then %g\n", text, n_ranks, kind, first, last);
  }
  kith_partition_destroy(&partition);
}

static void test_diffusion(void) {
  const char *const texts[] = {"diffusion",
                               "diffusion:flow=willebeek",
                               "diffusion:flow=second-order",
                               "diffusion:start=morton",
                               "diffusion:neighbors=fixed",
                               "diffusion:flow=willebeek neighbors=fixed",
                               "diffusion:flow=second-order neighbors=fixed start=morton"};
  const int ranks[2][3] = {{2, 7, 64}, {3, 4, 8}};
  for (int periodic = 0; periodic < 2; ++periodic) {
    const struct kith_cells cells = thousand_cells(periodic);
    for (size_t t = 0; t < sizeof texts / sizeof texts[0]; ++t)
      for (int r = 0; r < 3 && check_failures == 0; ++r)
        check_diffusion(&cells, ranks[periodic][r], texts[t]);
  }
}

/* Equal loads cause no flow, and neither do zero weights. */
static void test_diffusion_at_rest(void) {
  const struct kith_cells cells = thousand_cells(true);
  static double weight[MOST_CELLS];
  struct kith_partition *partition = partition_of(&cells, 2, "diffusion");
  CHECK(!update(partition, NULL));
  CHECK(!update(partition, weight));
  weights(&cells, 1, weight);
  CHECK(update(partition, weight));
  kith_partition_destroy(&partition);
}

/* ---- gridbased ---- */

/* The sum of squares of loads never rises, and is lower at the end. The mesh keeps its topology: in 1-D,
 * ranks are intervals in order. */
static void test_gridbased(void) {
  const int ranks[] = {2, 3, 4, 7, 8, 64};
  for (int periodic = 0; periodic < 2; ++periodic)
    for (int r = 0; r < 6; ++r) {
      const struct kith_cells cells = thousand_cells(periodic);
      static double weight[MOST_CELLS], effective[MOST_CELLS];
      struct rank_figures rank[MOST_RANKS];
      struct kith_partition *partition = partition_of(&cells, ranks[r], "gridbased");
      weights(&cells, 1, weight);
      effective_weights(&cells, weight, effective);
      const double first = load_figures(partition, effective, rank).imbalance;
      double squares = INFINITY;
      for (int k = 0; k < 10; ++k) {
        double sum = 0;
        update(partition, weight);
        load_figures(partition, effective, rank);
        for (int p = 0; p < ranks[r]; ++p) sum += rank[p].weight * rank[p].weight;
        CHECK(sum <= squares * (1 + 1e-12)); /* rounding of sums in another order */
        squares = sum;
      }
      const double last = load_figures(partition, effective, rank).imbalance;
      CHECK(last < first);
      for (int64_t c = 1; NDIM == 1 && !periodic && c < cells.n; ++c)
        CHECK(partition->owner[c] >= partition->owner[c - 1]);
      kith_partition_destroy(&partition);
    }
}

/* ---- a strong peak ---- */

/* A peak 21 times as heavy as the rest, with 256 cells per rank as in runs: the imbalance after some updates.
 * Members that cut the box need one update (graph to what Scotch aims at). The others move borders by one
 * layer per update, so that they need more, the more layers a rank has; 0: not tested, for 20 of 256 layers
 * in 1-D. Where 20 updates are not enough, the bound is the excess that was measured, and a third more. */
static const struct {
  const char *text;
  int updates;
  double bound[3][2]; /* by dimension; 8 and 64 ranks */
} PEAK[] = {{"kd", 1, {{1.03, 1.03}, {1.03, 1.03}, {1.03, 1.03}}},
            {"morton", 1, {{1.03, 1.03}, {1.04, 1.04}, {1.04, 1.04}}},
            {"hilbert", 1, {{1.03, 1.03}, {1.04, 1.04}, {1.04, 1.04}}},
            {"p4est", 1, {{1.03, 1.03}, {1.04, 1.04}, {1.04, 1.04}}},
            {"graph", 1, {{1.1, 1.1}, {1.1, 1.1}, {1.1, 1.1}}},
            {"gridbased", 20, {{1.03, 0}, {1.03, 1.07}, {1.03, 1.05}}},
            {"diffusion:flow=willebeek", 20, {{0, 0}, {1.03, 2.1}, {1.03, 1.04}}},
            {"diffusion", 20, {{0, 0}, {1.03, 1.5}, {1.03, 1.03}}},
            {"diffusion:flow=second-order", 20, {{0, 0}, {1.03, 1.5}, {1.03, 1.03}}},
            {"diffusion:neighbors=fixed", 20, {{0, 0}, {1.03, 1.5}, {1.03, 1.03}}},
            {"hybrid", 5, {{1.05, 1.06}, {1.03, 1.05}, {1.03, 1.03}}}};

static double peak(const struct kith_cells *cells, int64_t c) {
  const struct kith_box box = cell_box(cells, c);
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) r2 += 0.25 * (box.lower[a] + box.upper[a]) * (box.lower[a] + box.upper[a]);
  return 1 + 20 * exp(-r2 / 0.01);
}

static void test_peak(void) {
  static double weight[MOST_RANKS * 300];
  const bool periodic[3] = {true, true, true};
  for (int k = 0; k < 2; ++k) {
    const int n_ranks = k == 0 ? 8 : 64;
    double lower[NDIM], upper[NDIM];
    struct kith_cells cells;
    struct rank_figures rank[MOST_RANKS];
    for (int a = 0; a < NDIM; ++a) lower[a] = -0.5, upper[a] = 0.5;
    CHECK_OK(
        kith_cells_init(&cells, lower, upper, periodic, pow(256 * n_ranks, -1.0 / NDIM), MOST_RANKS * 300));
    for (int64_t c = 0; c < cells.n; ++c) weight[c] = peak(&cells, c);
    for (size_t m = 0; m < sizeof PEAK / sizeof PEAK[0]; ++m) {
      const double bound = PEAK[m].bound[NDIM - 1][k];
      struct kith_partition *partition = NULL;
      if (bound == 0 || kith_partition_create(&partition, &cells, n_ranks, PEAK[m].text) == KITH_UNSUPPORTED)
        continue;
      for (int u = 0; u < PEAK[m].updates; ++u) update(partition, weight);
      const double reached = load_figures(partition, weight, rank).imbalance;
      CHECK(reached <= bound);
      if (reached > bound) fprintf(stderr, "  %s, %d ranks: %g\n", PEAK[m].text, n_ranks, reached);
      kith_partition_destroy(&partition);
    }
  }
}

int main(void) {
  test_bounds();
  test_cart();
  test_meshes();
  test_curves();
  test_graph_stays();
  test_diffusion();
  test_diffusion_at_rest();
  test_gridbased();
  test_peak();
  return check_failed();
}
