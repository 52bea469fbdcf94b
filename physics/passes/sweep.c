/* Sweeps: which chunks need remote ghosts, and running the others while these are on their way. */
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
  const bool sorted = nodes->image == NULL;
  if (border->rows == rows->node && border->ghosts == nodes->ghosts) return KITH_OK;
  border->rows = NULL;
  if ((size_t)chunks > border->capacity) {
    border->capacity = 0;
    KITH_TRY(kith_resize(&border->chunk, 0, (size_t)chunks + (size_t)chunks / 8, 1));
    border->capacity = (size_t)chunks + (size_t)chunks / 8;
  }
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

void kith_border_clear(struct kith_border *border) {
  kith_free(&border->chunk);
  *border = (struct kith_border){0};
}

/* The chunks of `part`, or all: NULL. Adds to count. */
static kith_status run(const struct kith_node_sweep *sweep, const struct kith_nodes *nodes,
                       const struct kith_part *part, struct kith_profile *profile, uint64_t count[4]) {
  uint64_t now[4] = {0};
  if (part != NULL && part->wanted == 1)
    kith_profile_resume(profile, sweep->stage);
  else
    kith_profile_begin(profile, sweep->stage);
  const kith_status status = kith_traverse_part(nodes->n_internal, part, sweep->chunk, sweep->context,
                                                sweep->lanes, sweep->width, now, profile);
  if (sweep->counter != NULL) kith_profile_count(profile, sweep->counter, (double)now[sweep->counted]);
  kith_profile_end(profile);
  for (int k = 0; k < 4; ++k) count[k] += now[k];
  return status;
}

static void finish_exchange(const struct kith_node_sweep *sweep, const struct kith_hydro *hydro,
                            struct kith_profile *profile) {
  kith_profile_begin(profile, "refresh");
  kith_halo_finish_exchange(hydro->halo);
  kith_profile_end(profile);
  if (sweep->arrived != NULL)
    sweep->arrived(sweep->context, kith_nodes_first_remote(hydro->nodes), kith_nodes_count(hydro->nodes));
}

kith_status kith_node_sweep_run(const struct kith_node_sweep *sweep, const struct kith_hydro *hydro,
                                struct kith_border *border, struct kith_profile *profile, uint64_t count[4]) {
  const struct kith_nodes *nodes = hydro->nodes;
  for (int k = 0; k < 4; ++k) count[k] = 0;
  if (!kith_halo_pending(hydro->halo)) return run(sweep, nodes, NULL, profile, count);
  kith_status status = find_border(border, nodes, sweep->rows);
  struct kith_part part = {.chunk = border->chunk, .ranks = nodes->ranks};
  if (status == KITH_OK) status = run(sweep, nodes, &part, profile, count);
  finish_exchange(sweep, hydro, profile);
  KITH_TRY(status);
  part.wanted = 1;
  return run(sweep, nodes, &part, profile, count);
}
