/* conformance_storage.c - every storage of lists returns the rows that it was given, or their upper halves:
 * random ragged and empty rows, and those of a lattice, twice in the same memory. Compressed rows of a
 * lattice that is sorted along the curve must take 1.5 bytes per entry at most, against the 4 bytes of an
 * index. */
#include "lib/connectivity/storage/storage.h"

#include <stdlib.h>
#include "lib/core/choices.h"
#include "tests/unit/oracle.h"

/* Makes ascending rows of fewer than `most` entries among `n` nodes, every seventh of them empty; the gaps
 * between entries grow with `spread`. */
static void make_rows(struct kith_rows *rows, kith_index n, int most, int spread, uint64_t *state) {
  CHECK_OK(kith_rows_reserve(rows, n));
  for (kith_index t = 0; t < n; ++t)
    rows->first[t + 1] = t % 7 == 3 ? 0 : (size_t)(check_random(state) * most);
  CHECK_OK(kith_rows_sum(rows, -1));
  for (kith_index t = 0; t < n; ++t) {
    kith_index entry = (kith_index)(check_random(state) * n) - 1;
    for (size_t e = rows->first[t]; e < rows->first[t + 1]; ++e) {
      entry += 1 + (kith_index)(pow(check_random(state), 8) * spread);
      rows->node[e] = entry;
    }
  }
}

static void copy_rows(struct kith_rows *to, const struct kith_rows *from) {
  CHECK_OK(kith_rows_reserve(to, from->n));
  memcpy(to->first, from->first, ((size_t)from->n + 1) * sizeof *to->first);
  for (kith_index t = from->n; t > 0; --t) to->first[t] -= to->first[t - 1]; /* back to lengths */
  CHECK_OK(kith_rows_sum(to, -1));
  if (from->first[from->n] > 0) memcpy(to->node, from->node, from->first[from->n] * sizeof *to->node);
}

static void returns_rows(struct kith_stored *stored, const struct kith_rows *rows, const kith_index *node) {
  kith_index *space = malloc((stored->longest + 1) * sizeof *space);
  CHECK(stored->n == rows->n && stored->entries == rows->first[rows->n]);
  for (kith_index t = 0; t < rows->n; ++t) {
    size_t n, k = 0;
    const kith_index *row = stored->ops->row(stored, t, space, &n);
    bool same = true;
    for (size_t e = rows->first[t]; e < rows->first[t + 1]; ++e)
      if (!stored->ops->upper || rows->node[e] >= node[t]) {
        same = same && k < n && row[k] == rows->node[e];
        ++k;
      }
    CHECK(same && k == n);
  }
  free(space);
}

static void conforms(const char *words) {
  struct kith_rows rows = {0};
  struct kith_stored stored;
  uint64_t state = 2;
  CHECK_OK(kith_stored_create(&stored, words));
  CHECK(kith_stored_bytes(&stored) == 0);   /* nothing was built yet */
  for (int round = 0; round < 3; ++round) { /* rounds use the memory again */
    const kith_index n = round == 1 ? 0 : 1500 - 500 * round;
    kith_index *node = malloc(((size_t)n + 1) * sizeof *node);
    for (kith_index t = 0; t < n; ++t) node[t] = n - t;
    make_rows(&rows, n, round == 0 ? 90 : 20, round == 0 ? 3000000 : 20, &state);
    copy_rows(&stored.rows, &rows);
    CHECK_OK(kith_stored_keep(&stored, node));
    returns_rows(&stored, &rows, node);
    CHECK(kith_stored_bytes(&stored) >= (stored.ops->upper ? 0 : rows.first[n]));
    free(node);
  }
  kith_stored_clear(&stored);
  kith_rows_clear(&rows);
}

/* Returns the bytes per entry of the rows of a cubic lattice whose nodes are sorted along the curve. */
static double bytes_of(const char *words, double search_radius, int n) {
  struct kith_nodes *nodes = oracle_lattice(1, n, search_radius / n);
  struct kith_stored stored;
  kith_index *node = calloc((size_t)nodes->n_internal, sizeof *node);
  CHECK_OK(kith_search_sort_nodes(nodes, NULL));
  struct kith_connectivity *c =
      oracle_build(nodes, kith_search_find("tree"), (struct kith_requirements){.rows = true}, NULL);
  CHECK_OK(kith_stored_create(&stored, words));
  copy_rows(&stored.rows, &c->rows);
  for (kith_index i = 0; i < nodes->n_internal; ++i) node[i] = i;
  CHECK_OK(kith_stored_keep(&stored, node));
  returns_rows(&stored, &c->rows, node);
  const double bytes = (double)kith_stored_bytes(&stored) / (double)stored.entries;
  kith_stored_clear(&stored);
  kith_connectivity_destroy(&c);
  kith_nodes_destroy(&nodes);
  free(node);
  return bytes;
}

int main(void) {
  char name[64];
  for (const struct kith_storage_ops *const *ops = kith_storage_all(); *ops != NULL; ++ops) {
    kith_choices_format((*ops)->name, name, sizeof name);
    conforms(name);
  }
  conforms("padded:width=5");
  const double radius = NDIM == 1 ? 25.5 : NDIM == 2 ? 3.2 : 2.47;
  const int n = NDIM == 1 ? 5000 : NDIM == 2 ? 80 : 22;
  CHECK(bytes_of("compressed", radius, n) <= 1.5);
  CHECK(bytes_of("csr", radius, n) > 4);
  return check_failed();
}
