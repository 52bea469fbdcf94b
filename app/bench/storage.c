/* storage.c - what storages of neighbor lists cost: bytes, the time to build a list and of a sum over its
 * rows, over the number of neighbors and how ragged rows are. */
#include "app/bench/storage.h"

#include <math.h>
#include <stdio.h>
#include <time.h>

/* m (1 - q)^4 (1 + 4 q) over a row, as anybody would write it. */
struct pass {
  const struct kith_simulation *simulation;
  double *sum; /* [targets] */
};
static void add_row(void *context, const struct kith_neighbors *neighbors, struct kith_tally *tally) {
  const struct pass *pass = context;
  const struct kith_simulation *m = pass->simulation;
  const double *x = m->nodes->position->f64, *mass = m->hydro.mass->f64;
  const size_t i = (size_t)neighbors->node;
  const double inverse = 1 / m->nodes->support->f64[i];
  double sum = mass[i];
  (void)tally;
  for (size_t k = 0; k < neighbors->n; ++k) {
    const size_t j = (size_t)neighbors->source[k];
    const double q = sqrt(kith_distance2(x + i * NDIM, x + j * NDIM)) * inverse;
    if (q < 1) sum += mass[j] * (1 - q) * (1 - q) * (1 - q) * (1 - q) * (1 + 4 * q);
  }
  pass->sum[neighbors->target] = sum;
}

static double cpu_seconds(void) {
  return (double)clock() / CLOCKS_PER_SEC;
}

/* Best of three: a build and a pass, in ns of processor time a node. */
static kith_status time_list(struct kith_list *list, const struct pass *pass, double *build, double *visit) {
  enum kith_rebuild_reason why;
  const double per_node = 1e9 / list->spec.targets.nodes->n_internal;
  *build = *visit = INFINITY;
  for (int repeat = 0; repeat < 3; ++repeat) {
    const double start = cpu_seconds();
    KITH_TRY(kith_list_update(list, &why));
    const double built = cpu_seconds();
    KITH_TRY(kith_list_visit_all(list, add_row, (void *)(uintptr_t)pass, NULL, 0));
    *build = KITH_MIN(*build, per_node * (built - start));
    *visit = KITH_MIN(*visit, per_node * (cpu_seconds() - built));
  }
  return KITH_OK;
}

static kith_status print_row(struct kith_list_spec spec, const char *storage, bool ragged,
                             const struct pass *pass, double csr[2]) {
  struct kith_list *list = NULL;
  double build, visit;
  spec.storage = storage;
  kith_status status = kith_list_create(&list, &spec);
  if (status == KITH_OK) status = time_list(list, pass, &build, &visit);
  if (status == KITH_OK) {
    const struct kith_stored *s = &list->stored;
    const double bytes = (double)kith_stored_bytes(s), entries = (double)s->entries;
    if (csr[0] == 0) csr[0] = build, csr[1] = visit;
    printf("  %-17s %8s %10.1f %8zu %12.3f %11.0f %9.0f %9.0f %11.3f %10.3f\n", storage,
           ragged ? "yes" : "no", entries / s->n, s->longest, bytes / entries, bytes / s->n, build, visit,
           build / csr[0], visit / csr[1]);
    fflush(stdout);
  }
  kith_list_destroy(&list);
  return status;
}

/* Radii of `factor` supports; where rows are ragged, every eighth node has twice as large a one. */
static void fill_radii(const struct kith_nodes *nodes, struct kith_field *radius, double factor,
                       bool ragged) {
  for (kith_index i = 0; i < kith_nodes_count(nodes); ++i)
    radius->f64[i] = nodes->support->f64[i] * factor * (ragged && i % 8 == 0 ? 2 : 1);
}

static kith_status bench(struct kith_simulation *m, struct kith_search *search, struct pass *pass) {
  static const char *const storages[] = {"csr", "padded", "padded:width=64", "half", "compressed"};
  static const struct kith_field_spec spec_of_radius = {
      "list_radius", KITH_SCALAR, KITH_F64, KITH_DERIVED, NULL, "radius of the lists of bench"};
  struct kith_field *radius;
  KITH_TRY(kith_nodes_field(m->nodes, &spec_of_radius, &radius));
  KITH_TRY(kith_resize(&pass->sum, 0, (size_t)m->nodes->n_internal, sizeof(double)));
  search->radius = radius;
  struct kith_excluder self;
  struct kith_list_spec spec = kith_list_spec_among(m->nodes, search, &self, NULL);
  spec.radius = spec_of_radius.name;
  printf("\n  storage of lists  %8s %10s %8s %12s %11s %9s %9s %11s %10s\n", "ragged", "neighbors", "longest",
         "bytes/entry", "bytes/node", "build ns", "pass ns", "build/csr", "pass/csr");
  for (int size = -1; size <= 1; ++size)
    for (int ragged = 0; ragged < 2; ++ragged) {
      double csr[2] = {0};
      fill_radii(m->nodes, radius, pow(2, (double)size / NDIM), ragged);
      ++m->nodes->positions;
      for (size_t k = 0; k < sizeof storages / sizeof *storages; ++k)
        KITH_TRY(print_row(spec, storages[k], ragged, pass, csr));
    }
  return KITH_OK;
}

kith_status kith_bench_storage(struct kith_simulation *simulation) {
  struct kith_search *search;
  struct pass pass = {.simulation = simulation};
  KITH_TRY(kith_search_create(&search, simulation->search->ops, simulation->nodes));
  const kith_status status = bench(simulation, search, &pass);
  kith_search_destroy(&search);
  kith_free(&pass.sum);
  return status;
}
