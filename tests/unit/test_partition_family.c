/* The invariants of distributed grids, for every partitioner with each of its words, on its first map and behind two repartitions.
 * Numbers are those of the reference that this follows (R4 to R27); `cells`, `shell`, `partition`, `balance`, `gridbased` are the other tests:
 *
 *   R4   test_maps: own cells of all ranks are the product of the counts     R5   test_maps: ghosts by brute force; shell: the example of 1000 cells
 *   R6   test_maps: own and ghost cells are two lists, each ascending        R7   test_maps: rank of a position, before and after
 *   R8   test_maps: exactly one rank has the cell of a position; cells       R9   test_maps, cells: faces, beside them, outside, NaN
 *   R10  cells: d next to c if c next to d, image by image                   R11  test_maps: the forward halves of all ranks' cells meet each pair once; cells
 *   R12  does not apply: both sides of a pair between ranks are computed, nothing is sent back
 *   R13  test_maps: lists match place by place from both sides               R14  test_maps: neighbor ranks are unique and symmetric
 *   R15  test_refused: nothing has changed; partition: `changed` and the counter of maps tell the truth
 *   R16  does not apply: no callback; nodes move after the map has changed, and the old cells are not asked for
 *   R17  test_refused, partition: weights; balance: bounds                   R18  test_refused, test_faces: face weights. One number for a face, which
 *                                                                                 its two cells share: it cannot be asymmetric
 *   R19  test_start_maps                                                     R20  test_words: each word of each member; test_maps runs them
 *   R21  test_words: unknown commands, for every member                      R22  does not apply: maps are replicated, so that any position can be asked
 *                                                                                 for at any time (test_maps asks for all)
 *   R23  test_names; partition: the list, members without their library      R24  cells: the linear number, 64 bits, the same everywhere
 *   R25  does not apply: no member takes more than weights; a cell is where its midpoint is
 *   R26  test_switch; balance: hybrid                                        R27  gridbased: colors */
#include "lib/domain/shell.h"

#include <stdlib.h>
#include <string.h>

#include "tests/unit/partition_world.h"

enum { MOST_RANKS = 64, MOST_CELLS = 64, MOST_TEXTS = 40, SHIFTS = NDIM == 1 ? 3 : NDIM == 2 ? 9 : 27 };

/* ---- a world in whole numbers: cells have edge 1, the box begins at 0 ---- */

/* Does cell d, displaced by `shift` boxes, touch cell c, and is it not c itself? */
static bool touches(const struct kith_cells *cells, int64_t c, int64_t d, const int *shift) {
  bool same = true;
  for (int a = 0; a < NDIM; ++a) {
    const int64_t m = cells->count[a], apart = d % m + shift[a] * m - c % m;
    if (llabs(apart) > 1 || (shift[a] != 0 && !cells->periodic[a])) return false;
    same = same && apart == 0;
    c /= m, d /= m;
  }
  return !same;
}

static void shift_of(int code, int *shift) {
  for (int a = 0; a < NDIM; ++a, code /= 3) shift[a] = code % 3 - 1;
}

static int code_of(const int *shift) {
  int code = 0;
  for (int a = NDIM - 1; a >= 0; --a) code = 3 * code + shift[a] + 1;
  return code;
}

/* near[c][d]: some image of d touches c. */
static void find_near(const struct kith_cells *cells, bool (*near)[MOST_CELLS]) {
  for (int64_t c = 0; c < cells->n; ++c)
    for (int64_t d = 0; d < cells->n; ++d) {
      near[c][d] = false;
      for (int code = 0; code < SHIFTS; ++code) {
        int shift[NDIM];
        shift_of(code, shift);
        near[c][d] = near[c][d] || touches(cells, c, d, shift);
      }
    }
}

/* ---- members and words ---- */

/* Every available member, alone and with each of its words. */
static int find_texts(char (*text)[64]) {
  int n = 0;
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    snprintf(text[n++], 64, "%s", (*p)->name);
    for (int w = 0; (*p)->words != NULL && (*p)->words[w] != NULL; ++w)
      snprintf(text[n++], 64, "%s:%s", (*p)->name, (*p)->words[w]);
  }
  snprintf(text[n++], 64, "diffusion:willebeek,fixed");
  snprintf(text[n++], 64, "diffusion:second-order,fixed,morton");
  CHECK(n <= MOST_TEXTS);
  return n;
}

static struct kith_partition *make(const struct kith_cells *cells, int n_ranks, const char *text) {
  struct kith_partition *partition = NULL;
  CHECK_OK(kith_partition_create(&partition, cells, n_ranks, text));
  if (partition == NULL) exit(1);
  return partition;
}

static bool same_map(const struct kith_partition *p, const int32_t *owner) {
  return memcmp(p->owner, owner, (size_t)p->cells->n * sizeof *owner) == 0;
}

static void keep_map(const struct kith_partition *p, int32_t *owner) {
  memcpy(owner, p->owner, (size_t)p->cells->n * sizeof *owner);
}

/* ---- maps ---- */

static void check_totals(const struct kith_cells *cells, const struct kith_shell *shell, int n_ranks) {
  int64_t product = 1, sum = 0;
  for (int a = 0; a < NDIM; ++a) product *= cells->count[a];
  for (int r = 0; r < n_ranks; ++r) sum += shell[r].n_cells;
  CHECK(sum == product);
}

/* A ghost is every foreign cell that touches an own one, once, in the list of its owner; nothing else. */
static void check_ghosts(const struct kith_partition *partition, const struct kith_shell *shell,
                         bool (*near)[MOST_CELLS]) {
  int times[MOST_CELLS] = {0};
  for (int64_t i = 0; i < shell->n_cells; ++i) {
    CHECK(i == 0 || shell->cell[i] > shell->cell[i - 1]);
    CHECK(partition->owner[shell->cell[i]] == shell->rank);
  }
  for (int k = 0; k < shell->n_neighbors; ++k) {
    CHECK(shell->neighbor[k] != shell->rank && (k == 0 || shell->neighbor[k] > shell->neighbor[k - 1]));
    for (int64_t i = shell->receive_first[k]; i < shell->receive_first[k + 1]; ++i) {
      ++times[shell->receive[i]];
      CHECK(i == shell->receive_first[k] || shell->receive[i] > shell->receive[i - 1]);
      CHECK(partition->owner[shell->receive[i]] == shell->neighbor[k]);
    }
  }
  for (int64_t d = 0; d < partition->cells->n; ++d) {
    bool wanted = false;
    for (int64_t i = 0; i < shell->n_cells && partition->owner[d] != shell->rank; ++i)
      wanted = wanted || near[shell->cell[i]][d];
    CHECK(times[d] == wanted);
  }
}

/* All ranks sweep their own cells over the forward half: each unordered pair of images is met once, by one of them. */
static void check_half_shells(const struct kith_cells *cells, const struct kith_shell *shell, int n_ranks) {
  static int8_t met[MOST_CELLS][MOST_CELLS][SHIFTS];
  memset(met, 0, sizeof met);
  for (int r = 0; r < n_ranks; ++r)
    for (int64_t i = 0; i < shell[r].n_cells; ++i) {
      struct kith_cell_image image[KITH_CELL_NEIGHBORS];
      int n_forward = 0;
      kith_cells_neighbors(cells, shell[r].cell[i], image, &n_forward);
      for (int k = 0; k < n_forward; ++k) ++met[shell[r].cell[i]][image[k].cell][code_of(image[k].shift)];
    }
  for (int64_t c = 0; c < cells->n; ++c)
    for (int64_t d = 0; d < cells->n; ++d)
      for (int code = 0; code < SHIFTS; ++code) {
        int shift[NDIM];
        shift_of(code, shift);
        CHECK(met[c][d][code] + met[d][c][SHIFTS - 1 - code] == touches(cells, c, d, shift));
      }
}

/* The cell of a position in whole numbers: wrapped or clamped; -1: no number. */
static int64_t cell_of(const struct kith_cells *cells, const double *x) {
  int64_t c = 0;
  for (int a = NDIM - 1; a >= 0; --a) {
    const int64_t m = cells->count[a];
    if (!isfinite(x[a])) return -1;
    int64_t k = (int64_t)floor(x[a]);
    if (cells->periodic[a]) k = (k % m + m) % m;
    c = c * m + KITH_MIN(KITH_MAX(k, 0), m - 1);
  }
  return c;
}

static void check_positions(const struct kith_partition *partition, const struct kith_shell *shell) {
  const struct kith_cells *cells = partition->cells;
  uint64_t random = 5;
  for (int k = 0; k < 200; ++k) {
    double x[NDIM];
    for (int a = 0; a < NDIM; ++a) {
      const double end = (double)cells->count[a], face = floor(check_random(&random) * (end + 1));
      const double kinds[] = {check_random(&random) * end,          face, nextafter(face, INFINITY),
                              nextafter(KITH_MAX(face, 1), 0),      -0.5, end + 0.25,
                              (3 * check_random(&random) - 1) * end};
      x[a] = kinds[(size_t)(check_random(&random) * 7)];
    }
    if (k == 7) x[0] = NAN;
    if (k == 8) x[NDIM - 1] = -INFINITY;
    const int64_t c = cell_of(cells, x);
    int owners = 0, owner = -1;
    for (int r = 0; r < partition->n_ranks; ++r)
      for (int64_t i = 0; i < shell[r].n_cells; ++i)
        if (shell[r].cell[i] == c) ++owners, owner = r;
    CHECK(owners == (c >= 0) && kith_partition_rank_of(partition, x) == owner);
  }
}

static void check_map(const struct kith_partition *partition, bool (*near)[MOST_CELLS]) {
  struct kith_shell shell[MOST_RANKS] = {{0}};
  for (int r = 0; r < partition->n_ranks; ++r) {
    CHECK_OK(kith_shell_build(&shell[r], partition, r));
    check_ghosts(partition, &shell[r], near);
  }
  check_totals(partition->cells, shell, partition->n_ranks);
  check_both_sides(shell, partition->n_ranks);
  check_half_shells(partition->cells, shell, partition->n_ranks);
  check_positions(partition, shell);
  for (int r = 0; r < partition->n_ranks; ++r) kith_shell_clear(&shell[r]);
}

/* Two weights that pull to different ends. */
static void weights(const struct kith_cells *cells, int kind, double *weight) {
  for (int64_t c = 0; c < cells->n; ++c) {
    const double at = (double)(kind == 0 ? c : cells->n - 1 - c) / (double)cells->n;
    weight[c] = 1 + 20 * exp(-6 * at);
  }
}

static void check_text(const struct kith_cells *cells, int n_ranks, const char *text) {
  static bool near[MOST_CELLS][MOST_CELLS];
  double weight[MOST_CELLS];
  find_near(cells, near);
  struct kith_partition *partition = make(cells, n_ranks, text);
  check_map(partition, near);
  for (int kind = 0; kind < 2; ++kind) {
    bool changed;
    weights(cells, kind, weight);
    CHECK_OK(kith_partition_update(partition, weight, NULL, &changed));
    check_map(partition, near);
  }
  if (check_failures > 0) {
    fprintf(stderr, "  %s, %d ranks, %d cells\n", text, n_ranks, (int)cells->n);
    exit(1);
  }
  kith_partition_destroy(&partition);
}

/* 1, 2, 3 and more cells an axis, open and periodic; more ranks than cells. */
static void test_maps(void) {
  const struct {
    int count[3], periodic;
  } world[] = {{{1, 1, 1}, 7}, {{2, 2, 2}, 7}, {{3, 3, 3}, 7},
               {{3, 2, 1}, 5}, {{6, 3, 2}, 0}, {{5, 1, 4}, 2}};
  const int ranks[] = {1, 2, 3, 4, 7, 8, 64};
  char text[MOST_TEXTS][64];
  const int n_texts = find_texts(text);
  for (size_t w = 0; w < sizeof world / sizeof world[0]; ++w) {
    const struct kith_cells cells = grid(world[w].count, world[w].periodic);
    for (size_t r = 0; r < sizeof ranks / sizeof ranks[0]; ++r)
      for (int t = 0; t < n_texts; ++t) check_text(&cells, ranks[r], text[t]);
  }
}

/* ---- what is refused changes nothing ---- */

static void test_refused(void) {
  const int count[] = {5, 4, 3};
  const struct kith_cells cells = grid(count, 2);
  const double bad[] = {-1, -1e-300, NAN, INFINITY};
  char text[MOST_TEXTS][64];
  const int n_texts = find_texts(text);
  double weight[MOST_CELLS], face_weight[MOST_CELLS * NDIM];
  for (int t = 0; t < n_texts; ++t) {
    struct kith_partition *partition = make(&cells, 3, text[t]), *twin = make(&cells, 3, text[t]);
    int32_t before[MOST_CELLS], *const place = partition->owner;
    bool changed;
    keep_map(partition, before);
    for (int k = 0; k < 4; ++k) {
      weights(&cells, 0, weight);
      weight[cells.n / 2] = bad[k];
      CHECK_STATUS(KITH_BAD_INPUT, kith_partition_update(partition, weight, NULL, &changed));
      CHECK(!changed);
      for (int64_t f = 0; f < cells.n * NDIM; ++f) face_weight[f] = 1;
      face_weight[cells.n * NDIM - 1] = bad[k];
      CHECK_STATUS(KITH_BAD_INPUT, kith_partition_update(partition, NULL, face_weight, &changed));
      CHECK(!changed);
    }
    CHECK(partition->owner == place && partition->generation == 1 && same_map(partition, before));
    weights(&cells, 0, weight); /* nor does it matter later that something was refused */
    CHECK_OK(kith_partition_update(partition, weight, NULL, &changed));
    CHECK_OK(kith_partition_update(twin, weight, NULL, &changed));
    CHECK(same_map(partition, twin->owner));
    kith_partition_destroy(&partition);
    kith_partition_destroy(&twin);
  }
}

/* Only members that divide a graph look at the weights of faces; for the others they might as well not be there. */
static void test_faces(void) {
  const int count[] = {5, 4, 3};
  const struct kith_cells cells = grid(count, 0);
  uint64_t random = 9;
  double weight[MOST_CELLS], face_weight[MOST_CELLS * NDIM];
  weights(&cells, 0, weight);
  for (int64_t f = 0; f < cells.n * NDIM; ++f) face_weight[f] = check_random(&random);
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL || *p == &kith_partitioner_graph || *p == &kith_partitioner_hybrid) continue;
    struct kith_partition *with = make(&cells, 4, (*p)->name), *without = make(&cells, 4, (*p)->name);
    bool changed;
    CHECK_OK(kith_partition_update(with, weight, face_weight, &changed));
    CHECK_OK(kith_partition_update(without, weight, NULL, &changed));
    CHECK(same_map(with, without->owner));
    kith_partition_destroy(&with);
    kith_partition_destroy(&without);
  }
}

/* ---- names, words, start maps ---- */

static void check_unknown(const struct kith_cells *cells, const char *text, const char *what,
                          const char *named) {
  struct kith_partition *partition = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_partition_create(&partition, cells, 2, text));
  CHECK(partition == NULL && strstr(kith_failure(), what) != NULL && strstr(kith_failure(), named) != NULL);
}

/* What a partition calls itself makes another like it; what is no name is refused, with all names. */
static void test_names(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  const char *const wrong[] = {"metis", "", "KD", "kd ", "kdd", "k", ":fixed"};
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    CHECK(kith_partitioner_find((*p)->name) == *p);
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k)
      check_unknown(&cells, wrong[k], "unknown partitioner", (*p)->name);
    if ((*p)->needs != NULL) continue;
    struct kith_partition *made = make(&cells, 2, (*p)->name), *again = make(&cells, 2, made->ops->name);
    CHECK(made->ops == *p && again->ops == *p && same_map(made, again->owner));
    kith_partition_destroy(&made);
    kith_partition_destroy(&again);
  }
}

/* Words that a member knows are taken, any other is refused with those that it knows, and nothing changes at once. */
static void test_words(void) {
  const int count[] = {4, 4, 4};
  const struct kith_cells cells = grid(count, 0);
  const char *const wrong[] = {"", "fast", "set mu 3", "fixed ", "cart,", "synchronize"};
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    if ((*p)->needs != NULL) continue;
    const bool has_words = (*p)->words != NULL;
    struct kith_partition *partition = make(&cells, 3, (*p)->name);
    int32_t before[MOST_CELLS];
    keep_map(partition, before);
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
      char text[80];
      const char *named = has_words ? (*p)->words[0] : "takes no commands";
      snprintf(text, sizeof text, "%s:%s", (*p)->name, wrong[k]);
      check_unknown(&cells, text, (*p)->name, named);
      CHECK_STATUS(KITH_BAD_INPUT, kith_partition_command(partition, wrong[k]));
      CHECK(strstr(kith_failure(), named) != NULL);
    }
    for (int w = 0; has_words && (*p)->words[w] != NULL; ++w)
      CHECK_OK(kith_partition_command(partition, (*p)->words[w]));
    CHECK(same_map(partition, before) && partition->generation == 1);
    kith_partition_destroy(&partition);
  }
}

/* Members that begin with the map of another one. */
static void test_start_maps(void) {
  const int count[] = {7, 3, 2};
  const struct kith_cells cells = grid(count, 0);
  const char *const like[][2] = {
      {"diffusion", "cart"}, {"diffusion:cart", "cart"}, {"diffusion:morton", "morton"}, {"hybrid", "graph"}};
  for (size_t k = 0; k < sizeof like / sizeof like[0]; ++k)
    for (int n_ranks = 1; n_ranks <= 8; ++n_ranks) {
      if (k == 3 && kith_partitioner_graph.needs != NULL) continue;
      struct kith_partition *one = make(&cells, n_ranks, like[k][0]),
                            *other = make(&cells, n_ranks, like[k][1]);
      CHECK(same_map(one, other->owner));
      kith_partition_destroy(&one);
      kith_partition_destroy(&other);
    }
}

/* A word for what is next is obeyed at the next update: ownership is the same right after it. A graph is followed by diffusion. */
static void test_switch(void) {
  if (kith_partitioner_hybrid.needs != NULL) return;
  const struct {
    const char *word;
    bool graph;
  } turn[] = {{"toggle", false}, {"toggle", true}, {NULL, false},
              {"graph", true},   {"toggle", true}, {"diffusion", false}};
  const int count[] = {6, 4, 2};
  const struct kith_cells cells = grid(count, 0);
  double weight[MOST_CELLS];
  int32_t before[MOST_CELLS];
  bool changed;
  struct kith_partition *hybrid = make(&cells, 4, "hybrid"), *graph = make(&cells, 4, "graph"),
                        *diffusion = make(&cells, 4, "diffusion");
  for (size_t k = 0; k < sizeof turn / sizeof turn[0]; ++k) {
    weights(&cells, k % 2, weight);
    keep_map(hybrid, before);
    if (turn[k].word != NULL) CHECK_OK(kith_partition_command(hybrid, turn[k].word));
    CHECK(same_map(hybrid, before));
    struct kith_partition *next = turn[k].graph ? graph : diffusion; /* goes on from the same map */
    memcpy(next->owner, before, (size_t)cells.n * sizeof *before);
    CHECK_OK(kith_partition_update(hybrid, weight, NULL, &changed));
    CHECK_OK(kith_partition_update(next, weight, NULL, &changed));
    CHECK(same_map(hybrid, next->owner));
  }
  kith_partition_destroy(&hybrid);
  kith_partition_destroy(&graph);
  kith_partition_destroy(&diffusion);
}

int main(void) {
  test_maps();
  test_refused();
  test_faces();
  test_names();
  test_words();
  test_start_maps();
  test_switch();
  return check_failed();
}
