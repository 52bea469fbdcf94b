#include "physics/sweep.h"

/* Rows are in the order of indices, in which remote ghosts are last, or in canonical order. */
static bool looks_beyond(const struct kith_rows *rows, kith_index i, kith_index first_remote, bool sorted) {
  const size_t begin = rows->first[i], end = rows->first[i + 1];
  if (begin == end) return false;
  if (sorted) return rows->node[end - 1] >= first_remote;
  for (size_t e = begin; e < end; ++e)
    if (rows->node[e] >= first_remote) return true;
  return false;
}

/* package->border: 1 for chunks in which a node has a remote ghost in its row. */
static kith_status find_border(struct kith_package *package, const struct kith_rows *rows) {
  const struct kith_nodes *nodes = package->hydro->nodes;
  const kith_index n = nodes->n_internal, first_remote = kith_nodes_first_remote(nodes);
  const kith_index chunks = (n + KITH_CHUNK - 1) / KITH_CHUNK;
  const bool sorted = nodes->image == NULL;
  if (package->border_of == rows->node && package->border_ghosts == nodes->ghosts) return KITH_OK;
  package->border_of = NULL;
  if ((size_t)chunks > package->border_capacity) {
    package->border_capacity = 0;
    KITH_TRY(kith_resize(&package->border, 0, (size_t)chunks + (size_t)chunks / 8, 1));
    package->border_capacity = (size_t)chunks + (size_t)chunks / 8;
  }
#pragma omp parallel for schedule(static)
  for (kith_index c = 0; c < chunks; ++c) {
    bool beyond = false;
    for (kith_index i = c * KITH_CHUNK; i < KITH_MIN(n, (c + 1) * KITH_CHUNK) && !beyond; ++i)
      beyond = looks_beyond(rows, i, first_remote, sorted);
    package->border[c] = beyond;
  }
  package->border_of = rows->node, package->border_ghosts = nodes->ghosts;
  return KITH_OK;
}

/* Chunks that are alike, or all: part NULL. */
static kith_status run(struct kith_package *package, const struct kith_sweep *sweep,
                       const struct kith_part *part, uint64_t count[4]) {
  uint64_t now[4] = {0};
  if (part != NULL && part->wanted == 1)
    kith_profile_resume(package->profile, sweep->stage);
  else
    kith_profile_begin(package->profile, sweep->stage);
  const kith_status status =
      kith_traverse_part(package->hydro->nodes->n_internal, part, sweep->chunk, sweep->context, sweep->lanes,
                         sweep->width, now, package->profile);
  if (sweep->counter != NULL)
    kith_profile_count(package->profile, sweep->counter, (double)now[sweep->counted]);
  kith_profile_end(package->profile);
  for (int k = 0; k < 4; ++k) count[k] += now[k];
  return status;
}

static void await(struct kith_package *package, const struct kith_sweep *sweep) {
  struct kith_nodes *nodes = package->hydro->nodes;
  kith_profile_begin(package->profile, "refresh");
  kith_nodes_await_ghosts(nodes);
  kith_profile_end(package->profile);
  if (sweep->arrived != NULL)
    sweep->arrived(sweep->context, kith_nodes_first_remote(nodes), kith_nodes_count(nodes));
}

kith_status kith_package_sweep(struct kith_package *package, const struct kith_sweep *sweep,
                               uint64_t count[4]) {
  struct kith_nodes *nodes = package->hydro->nodes;
  for (int k = 0; k < 4; ++k) count[k] = 0;
  if (!nodes->exchange.under_way) return run(package, sweep, NULL, count);
  struct kith_part part = {.ranks = nodes->ranks};
  kith_status status = find_border(package, sweep->rows);
  part.chunk = package->border;
  if (status == KITH_OK) status = run(package, sweep, &part, count);
  await(package, sweep);
  KITH_TRY(status);
  part.wanted = 1;
  return run(package, sweep, &part, count);
}
