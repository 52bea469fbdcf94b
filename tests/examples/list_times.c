/* list_times.c - costs of the members of the families search and storage, on about N nodes (list_times [N]).
 *
 * Searches, on clouds whose supports differ by factors of 1, 10 and 1000, with about 60 neighbors everywhere,
 * and one where a thousandth of the nodes have supports 10 times as large. Times of: updates from scratch,
 * after small displacements of all nodes or of every hundredth; rows; a sum over neighbors by rows, and by a
 * sweep over cells.
 * Storages, with a half, once and twice the neighbors, in rows of equal or different length: bytes, the time
 * to build a list and that of a sum over its rows. Times are nanoseconds of processor time per node, so that
 * OMP_NUM_THREADS=1 gives the clearest numbers. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include "lib/connectivity/list.h"
#include "lib/core/random.h"

/* Ratio of the largest to the smallest support. In a mixed cloud one node in a thousand has the large one. */
struct cloud {
  double ratio;
  bool mixed;
};

/* Unless mixed, spacings grow with the distance from the center, as s |xi|^power, up to the corners. */
static void place_node(struct kith_nodes *nodes, kith_index i, kith_index side, struct cloud cloud) {
  const double s = 2.0 / side, power = cloud.mixed ? 0 : log(cloud.ratio) / log(side),
               support = NDIM == 3 ? 2.43 : 4;
  double *x = nodes->position->f64 + (size_t)i * NDIM, r2 = 0;
  kith_index rest = i;
  for (int a = 0; a < NDIM; ++a, rest /= side) {
    x[a] = s * (rest % side + 0.5 + 0.3 * kith_random(1, i, a)) - 1;
    r2 += x[a] * x[a];
  }
  const double stretch = pow(KITH_MAX(sqrt(r2), 0.5 * s), power);
  for (int a = 0; a < NDIM; ++a) x[a] *= stretch;
  nodes->search_radius->f64[i] = support * s * stretch * pow(1 + power, 1.0 / NDIM);
  if (cloud.mixed && i % 1000 == 0) nodes->search_radius->f64[i] *= cloud.ratio;
  nodes->id->i64[i] = i;
}

/* Nodes are in curve order, as in runs. */
static kith_status make_cloud(struct kith_nodes **out, kith_index side, struct cloud cloud) {
  const kith_index n = (kith_index)kith_pow_dim(side);
  kith_index first;
  KITH_TRY(kith_nodes_create(out, 1, (const char *const[]){"cloud"}));
  KITH_TRY(kith_nodes_append(*out, 0, n, &first));
  for (kith_index i = 0; i < n; ++i) place_node(*out, i, side, cloud);
  return kith_search_sort_nodes(*out, NULL);
}

/* Moves every `stride`-th node by up to a fraction of its radius along each axis, and changes its radius. */
static void move_nodes(struct kith_nodes *nodes, kith_index stride, int round) {
  for (kith_index i = 0; i < nodes->n_internal; i += stride) {
    double *radius = &nodes->search_radius->f64[i];
    for (int a = 0; a < NDIM; ++a)
      nodes->position->f64[i * NDIM + a] +=
          0.02 * *radius * kith_random((uint64_t)round, nodes->id->i64[i], a);
    *radius *= 1 + 0.002 * kith_random((uint64_t)round, nodes->id->i64[i], NDIM);
  }
  ++nodes->positions;
}

/* (1 - q)^4 (1 + 4 q), 0 outside */
static inline double weight(double d2, double inverse2) {
  const double q = sqrt(d2 * inverse2), left = q < 1 ? 1 - q : 0;
  return left * left * left * left * (1 + 4 * q);
}

struct sums {
  const struct kith_search *search;
  double *row, *slot; /* [n] by node: from rows, from a sweep; by slot */
  double *sweep;
};

static void add_row(void *context, const struct kith_neighbors *neighbors, struct kith_tally *tally) {
  const struct sums *sums = context;
  const struct kith_nodes *nodes = sums->search->nodes;
  const double *x = nodes->position->f64, radius = nodes->search_radius->f64[neighbors->node];
  double sum = weight(0, 0);
  (void)tally;
  for (size_t k = 0; k < neighbors->n; ++k)
    sum += weight(kith_distance2(x + (size_t)neighbors->node * NDIM, x + (size_t)neighbors->source[k] * NDIM),
                  1 / (radius * radius));
  sums->row[neighbors->node] = sum;
}

/* The three events of a sweep for the same sum: sums begin, pairs are added, sums are stored. */
static kith_status begin_sums(void *context, const struct kith_run *run, int n) {
  const struct sums *sums = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p) sums->slot[p] = 0;
  return KITH_OK;
}

/* Adds a run of nodes, which may contain p, to the target in slot p; if these are of coarser levels, p is
 * added to them too. */
KITH_HOT static void add_searches_run(const struct sums *sums, kith_index p, struct kith_run run,
                                      bool coarser) {
  const struct kith_search *s = sums->search;
  const double *restrict radius2 = s->radius2, *c[NDIM], inverse2 = 1 / radius2[p];
  double *restrict slot = sums->slot, sum = 0, x[NDIM];
  for (int a = 0; a < NDIM; ++a) c[a] = s->coordinate[a] + run.first, x[a] = s->coordinate[a][p];
#pragma omp simd reduction(+ : sum)
  for (kith_index q = 0; q < run.count; ++q) {
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) d2 += (c[a][q] - x[a]) * (c[a][q] - x[a]);
    sum += weight(d2, inverse2);
  }
  slot[p] += sum;
  if (!coarser) return;
#pragma omp simd
  for (kith_index q = 0; q < run.count; ++q) {
    double d2 = 0;
    for (int a = 0; a < NDIM; ++a) d2 += (c[a][q] - x[a]) * (c[a][q] - x[a]);
    slot[run.first + q] += weight(d2, 1 / radius2[run.first + q]);
  }
}

static kith_status add_cell(void *context, const struct kith_cell *cell) {
  for (kith_index t = 0; t < cell->targets; ++t)
    for (int r = 0; r < cell->n_active; ++r)
      add_searches_run(context, cell->target[t], cell->active[r], r < cell->n_coarser);
  return KITH_OK;
}

static kith_status end_sums(void *context, const struct kith_run *run, int n) {
  const struct sums *sums = context;
  for (int r = 0; r < n; ++r)
    for (kith_index p = run[r].first; p < run[r].first + run[r].count; ++p)
      sums->sweep[sums->search->node[p]] = sums->slot[p];
  return KITH_OK;
}

static double cpu_seconds(void) {
  return (double)clock() / CLOCKS_PER_SEC;
}

enum { SCRATCH, MOVED, SELECTED, ROWS, PASS, SWEEP, TIMES };
static const char *const time_names[] = {"scratch", "moved", "1 %", "rows", "pass", "sweep"};

/* Stores the least of the measured times, in nanoseconds of processor time per node. */
static kith_status clocked(kith_status status, double start, kith_index n, double *least) {
  const double ns = 1e9 * (cpu_seconds() - start) / n;
  *least = *least > 0 ? KITH_MIN(*least, ns) : ns;
  return status;
}

static kith_status time_rows(struct kith_search *search, struct sums *sums, double *neighbors, double *ns) {
  struct kith_excluder self;
  const struct kith_list_spec spec = kith_list_spec_among(search->nodes, search, &self, NULL);
  const kith_index n = search->nodes->n_internal;
  struct kith_list *list = NULL;
  enum kith_rebuild_reason why;
  kith_status status = kith_list_create(&list, &spec);
  for (int repeat = 0; repeat < 3 && status == KITH_OK; ++repeat) {
    double start = cpu_seconds();
    status = clocked(kith_list_update(list, &why), start, n, &ns[ROWS]);
    start = cpu_seconds();
    if (status == KITH_OK)
      status = clocked(kith_list_visit_all(list, add_row, sums, NULL, 0), start, n, &ns[PASS]);
  }
  if (status == KITH_OK) *neighbors = (double)list->stored.entries / n;
  kith_list_destroy(&list);
  return status;
}

static kith_status time_search(struct kith_search *search, struct kith_nodes *nodes, struct sums *sums,
                               uint64_t count[KITH_SEARCH_COUNTERS], double *neighbors, double *ns) {
  static const struct kith_sweep events = {begin_sums, add_cell, end_sums};
  const kith_index n = nodes->n_internal;
  kith_index *hundredth = NULL, many = 0;
  double start = cpu_seconds();
  KITH_TRY(clocked(kith_search_update(search), start, n, &ns[SCRATCH]));
  for (int round = 1; round <= 3; ++round) {
    move_nodes(nodes, 1, round);
    start = cpu_seconds();
    KITH_TRY(clocked(kith_search_update(search), start, n, &ns[MOVED]));
    for (int k = 0; k < KITH_SEARCH_COUNTERS; ++k) count[k] += search->count[k];
  }
  KITH_TRY(kith_resize(&hundredth, 0, (size_t)n / 100 + 1, sizeof *hundredth));
  for (kith_index i = 0; i < n; i += 100) hundredth[many++] = i;
  kith_status status = KITH_OK;
  for (int round = 4; round <= 6 && status == KITH_OK; ++round) {
    move_nodes(nodes, 100, round);
    start = cpu_seconds();
    status = clocked(kith_search_update_selected(search, hundredth, many), start, n, &ns[SELECTED]);
  }
  kith_free(&hundredth);
  if (status == KITH_OK) status = time_rows(search, sums, neighbors, ns);
  start = cpu_seconds();
  if (status == KITH_OK && search->ops->sweep != NULL)
    status = clocked(kith_search_sweep(search, &events, sums), start, n, &ns[SWEEP]);
  return status;
}

/* Returns INTERNAL if sums of the sweep and of rows differ by more than the round-off of another order. */
static kith_status print_search(const char *what, struct cloud cloud, const struct kith_search *search,
                                const struct sums *sums, const uint64_t count[KITH_SEARCH_COUNTERS],
                                double neighbors, const double *ns) {
  double apart = 0;
  printf("  %-26s %5.0f%s %9.1f", what, cloud.ratio, cloud.mixed ? " mixed" : "      ", neighbors);
  for (int t = 0; t < TIMES; ++t)
    if (ns[t] > 0)
      printf(" %8.1f", ns[t]);
    else
      printf(" %8s", "-");
  printf(" %11.0f\n", (double)kith_search_bytes(search) / search->n);
  for (int k = 0; search->ops->counters != NULL && search->ops->counters[k] != NULL; ++k)
    printf("%s%llu %s", k == 0 ? "    three updates: " : ", ", (unsigned long long)count[k],
           search->ops->counters[k]);
  if (search->ops->sweep != NULL) {
    for (kith_index i = 0; i < search->n; ++i)
      apart = KITH_MAX(apart, fabs(sums->sweep[i] / sums->row[i] - 1));
    printf("; sums of the sweep and of rows differ by %.1e\n", apart);
  }
  fflush(stdout);
  if (!(apart <= 1e-12)) KITH_FAIL(INTERNAL, "%s: sums of the sweep and of rows differ by %g", what, apart);
  return KITH_OK;
}

static kith_status time_member(const char *words, kith_index side, struct cloud cloud, struct sums *sums) {
  char name[32];
  int k = 0;
  struct kith_nodes *nodes = NULL;
  struct kith_search *search = NULL;
  void *settings = NULL;
  uint64_t count[KITH_SEARCH_COUNTERS] = {0};
  double neighbors = 0, ns[TIMES] = {0};
  snprintf(name, sizeof name, "%.*s", (int)strcspn(words, ":"), words);
  while (kith_search_all()[k] != kith_search_find(name)) ++k;
  kith_status status = kith_settings_create(&settings, kith_search_member(k),
                                            words[strlen(name)] == ':' ? words + strlen(name) + 1 : NULL);
  if (status == KITH_OK) status = make_cloud(&nodes, side, cloud);
  if (status == KITH_OK) status = kith_search_create(&search, kith_search_all()[k], nodes);
  if (status == KITH_OK) {
    search->settings = settings, sums->search = search;
    status = time_search(search, nodes, sums, count, &neighbors, ns);
  }
  if (status == KITH_OK) status = print_search(words, cloud, search, sums, count, neighbors, ns);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
  kith_free(&settings);
  return status;
}

static kith_status time_searches(kith_index side) {
  static const char *const searches[] = {"tree", "grid", "spacetree", "spacetree:layout=scattered"};
  static const struct cloud cloud[] = {{1, false}, {10, false}, {1000, false}, {10, true}};
  const size_t all = (size_t)kith_pow_dim(side);
  struct sums sums = {0};
  KITH_TRY(kith_resize(&sums.row, 0, 3 * all, sizeof *sums.row));
  sums.slot = sums.row + all, sums.sweep = sums.slot + all;
  printf("  search: ns a node           supports   neighbors");
  for (int t = 0; t < TIMES; ++t) printf(" %8s", time_names[t]);
  printf("  bytes/node\n");
  kith_status status = KITH_OK;
  for (size_t r = 0; r < sizeof cloud / sizeof *cloud; ++r)
    for (size_t k = 0; k < sizeof searches / sizeof *searches && status == KITH_OK; ++k)
      status = time_member(searches[k], side, cloud[r], &sums);
  kith_free(&sums.row);
  return status;
}

/* ---- storages ---- */

static kith_status time_storage(struct kith_list_spec spec, bool ragged, struct sums *sums, double csr[2]) {
  struct kith_list *list = NULL;
  double ns[2] = {0}; /* of building, and of a sum over the rows */
  enum kith_rebuild_reason why;
  const kith_index n = sums->search->nodes->n_internal;
  kith_status status = kith_list_create(&list, &spec);
  for (int repeat = 0; repeat < 3 && status == KITH_OK; ++repeat) {
    double start = cpu_seconds();
    status = clocked(kith_list_update(list, &why), start, n, &ns[0]);
    start = cpu_seconds();
    if (status == KITH_OK)
      status = clocked(kith_list_visit_all(list, add_row, sums, NULL, 0), start, n, &ns[1]);
  }
  if (status == KITH_OK) {
    const struct kith_stored *s = &list->stored;
    const double bytes = (double)kith_stored_bytes(s), entries = (double)s->entries;
    if (csr[0] == 0) csr[0] = ns[0], csr[1] = ns[1];
    printf("  %-17s %8s %10.1f %8zu %12.3f %11.0f %9.0f %9.0f %11.3f %10.3f\n", spec.storage,
           ragged ? "yes" : "no", entries / s->n, s->longest, bytes / entries, bytes / s->n, ns[0], ns[1],
           ns[0] / csr[0], ns[1] / csr[1]);
    fflush(stdout);
  }
  kith_list_destroy(&list);
  return status;
}

/* Radii are `factor` times those of the cloud; in ragged rows, those of every eighth node are doubled. */
static kith_status time_radii(struct kith_nodes *nodes, struct kith_search *search, double factor,
                              bool ragged, struct sums *sums) {
  static const char *const storages[] = {"csr", "padded", "padded:width=64", "half", "compressed"};
  struct kith_excluder self;
  struct kith_list_spec spec = kith_list_spec_among(nodes, search, &self, NULL);
  double csr[2] = {0}, *radius = nodes->search_radius->f64;
  for (kith_index i = 0; i < nodes->n_internal; ++i) radius[i] *= factor * (ragged && i % 8 == 0 ? 2 : 1);
  ++nodes->positions;
  for (size_t k = 0; k < sizeof storages / sizeof *storages; ++k) {
    spec.storage = storages[k];
    KITH_TRY(time_storage(spec, ragged, sums, csr));
  }
  for (kith_index i = 0; i < nodes->n_internal; ++i) radius[i] /= factor * (ragged && i % 8 == 0 ? 2 : 1);
  return KITH_OK;
}

static kith_status time_storages(kith_index side) {
  struct kith_nodes *nodes = NULL;
  struct kith_search *search = NULL;
  struct sums sums = {0};
  kith_status status = make_cloud(&nodes, side, (struct cloud){1, false});
  if (status == KITH_OK) status = kith_search_create(&search, kith_search_find("tree"), nodes);
  if (status == KITH_OK) status = kith_resize(&sums.row, 0, (size_t)nodes->n_internal, sizeof *sums.row);
  sums.search = search;
  printf("\n  storage of lists  %8s %10s %8s %12s %11s %9s %9s %11s %10s\n", "ragged", "neighbors", "longest",
         "bytes/entry", "bytes/node", "build ns", "pass ns", "build/csr", "pass/csr");
  for (int size = -1; size <= 1; ++size)
    for (int ragged = 0; ragged < 2 && status == KITH_OK; ++ragged)
      status = time_radii(nodes, search, pow(2, (double)size / NDIM), ragged, &sums);
  kith_search_destroy(&search);
  kith_nodes_destroy(&nodes);
  kith_free(&sums.row);
  return status;
}

int main(int argc, char **argv) {
  const kith_index side = (kith_index)lround(pow(argc > 1 ? atof(argv[1]) : 1e5, 1.0 / NDIM));
  kith_status status = time_searches(side);
  if (status == KITH_OK) status = time_storages(side);
  if (status != KITH_OK) fprintf(stderr, "%s\n", kith_failure());
  return status != KITH_OK;
}
