/* Sweeps: which chunks need remote ghosts; the others run while these are on their way. */
#include "physics/passes/sweep.h"

/* Does row i hold a remote ghost? These have the highest indices: a sorted row has them at its end. */
static bool has_remote(const struct kith_rows *rows, kith_index i, kith_index first_remote, bool sorted) {
  const size_t begin = rows->first[i], end = rows->first[i + 1];
  if (begin == end) return false;
  if (sorted) return rows->node[end - 1] >= first_remote;
  for (size_t e = begin; e < end; ++e)
    if (rows->node[e] >= first_remote) return true;
  return false;
}

static kith_status find_border(struct kith_border *border, const struct kith_nodes *nodes,
                               const struct kith_rows *rows) {
  const kith_index n = nodes->n_internal, first_remote = kith_nodes_first_remote(nodes);
  const kith_index chunks = (n + KITH_CHUNK - 1) / KITH_CHUNK;
  const bool sorted = nodes->image == NULL; /* canonical rows, which need the images, do not ascend */
  if (border->rows == rows->node && border->ghosts == nodes->ghosts) return KITH_OK;
  border->rows = NULL;
  KITH_TRY(kith_reserve(&border->chunk, &border->capacity, (size_t)chunks, 1));
#pragma omp parallel for schedule(static)
  for (kith_index c = 0; c < chunks; ++c) {
    bool remote = false;
    for (kith_index i = c * KITH_CHUNK; i < KITH_MIN(n, (c + 1) * KITH_CHUNK) && !remote; ++i)
      remote = has_remote(rows, i, first_remote, sorted);
    border->chunk[c] = remote;
  }
  border->rows = rows->node, border->ghosts = nodes->ghosts;
  return KITH_OK;
}

static double traffic(const struct kith_node_sweep *sweep, const struct kith_nodes *nodes) {
  const size_t internal = (size_t)nodes->n_internal, entries = sweep->rows->first[internal];
  return (double)sweep->shared * kith_nodes_count(nodes) + (double)sweep->own * nodes->n_internal +
         sweep->pairwise + (double)(entries * sizeof(kith_index) + internal * sizeof(size_t));
}

/* Runs the chunks of `part`; adds to count. */
static kith_status run(const struct kith_package *package, const struct kith_node_sweep *sweep,
                       const struct kith_part *part, uint64_t count[KITH_COUNTS]) {
  struct kith_profile *profile = package->profile;
  uint64_t now[KITH_COUNTS] = {0};
  const bool again = part->wanted == 1;
  (again ? kith_profile_resume : kith_profile_begin)(profile, sweep->stage);
  if (!again) kith_profile_count(profile, "bytes", traffic(sweep, package->hydro->nodes));
  const kith_status status = kith_traverse_part(package->hydro->nodes->n_internal, part, sweep->chunk,
                                                sweep->context, sweep->lanes, sweep->width, now, profile);
  if (sweep->iterates) kith_profile_count(profile, "iterations", (double)now[KITH_COUNT_ITERATIONS]);
  kith_profile_end(profile);
  for (int k = 0; k < KITH_COUNTS; ++k) count[k] += now[k];
  return status;
}

/* Runs first the chunks without remote ghosts, then, when these have arrived, the others. */
static kith_status run_parts(struct kith_package *package, const struct kith_node_sweep *sweep,
                             uint64_t count[KITH_COUNTS]) {
  const struct kith_nodes *nodes = package->hydro->nodes;
  struct kith_part part = {.activity = nodes->activity != NULL ? nodes->activity->u8 : NULL,
                           .least = sweep->touched ? KITH_TOUCHED : KITH_ACTIVE,
                           .whole = sweep->whole,
                           .size = sweep->chunk_size};
  if (!kith_halo_pending(package->hydro->halo)) return run(package, sweep, &part, count);
  kith_status status = find_border(&package->border, nodes, sweep->rows);
  part.chunk = package->border.chunk, part.ranks = nodes->ranks;
  if (status == KITH_OK) status = run(package, sweep, &part, count);
  kith_profile_begin(package->profile, "refresh");
  kith_halo_finish_exchange(package->hydro->halo);
  kith_profile_end(package->profile);
  if (sweep->arrived != NULL)
    sweep->arrived(sweep->context, kith_nodes_first_remote(nodes), kith_nodes_count(nodes));
  KITH_TRY(status);
  part.wanted = 1;
  return run(package, sweep, &part, count);
}

kith_status kith_package_sweep(struct kith_package *package, const struct kith_node_sweep *sweep,
                               uint64_t count[KITH_COUNTS]) {
  uint64_t sum[KITH_COUNTS] = {0};
  kith_status status = sweep->begins ? KITH_OK : kith_ranks_finish_agree(package->hydro->nodes->ranks);
  if (status == KITH_OK)
    status = run_parts(package, sweep, sum);
  else
    kith_halo_finish_exchange(package->hydro->halo);
  package->pair_evaluations += sum[KITH_COUNT_EVALUATIONS];
  package->support_iterations += sum[KITH_COUNT_ITERATIONS];
  package->fallbacks += sum[KITH_COUNT_FALLBACKS];
  for (int k = 0; count != NULL && k < KITH_COUNTS; ++k) count[k] = sum[k];
  return status;
}

kith_status kith_package_sweep_ghosts(struct kith_package *package, const struct kith_node_sweep *sweep,
                                      kith_index first, kith_index n) {
  const struct kith_part part = {.first = first};
  uint64_t count[KITH_COUNTS] = {0};
  if (n == 0) return KITH_OK;
  kith_profile_begin(package->profile, sweep->stage);
  const kith_status status = kith_traverse_part(n, &part, sweep->chunk, sweep->context, sweep->lanes,
                                                sweep->width, count, package->profile);
  kith_profile_end(package->profile);
  package->pair_evaluations += count[KITH_COUNT_EVALUATIONS];
  return status;
}
