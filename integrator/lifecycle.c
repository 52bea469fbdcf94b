/* The lifecycle of connectivity, in the order in which it happens. */
#include <math.h>
#include <string.h>
#include "boundaries/distributed.h"
#include "integrator/integrator.h"
#include "lib/connectivity/shield.h"

void kith_lifecycle_demands(const struct kith_integrator *it, struct kith_demand demand[KITH_DEMANDS]) {
  demand[0] = (struct kith_demand){"lifecycle", "culling", {.rows = true}};
  demand[1] = (struct kith_demand){it->package->ops->name,
                                   it->package->traversal == KITH_TRAVERSE_PAIRS ? "pairs" : "gather",
                                   it->package->ops->requirements(it->package)};
  demand[2] = (struct kith_demand){"shield", "barriers", {0}};
  if (it->package->barrier != NULL)
    demand[2].need =
        (struct kith_requirements){.rows = true, .pairs = true, .intersection = true, .on_segment = true};
}

/* Nothing is built that no one asked for. */
static struct kith_requirements requirements(const struct kith_integrator *it) {
  struct kith_requirements need = {0};
  struct kith_demand demand[KITH_DEMANDS];
  kith_lifecycle_demands(it, demand);
  for (int k = 0; k < KITH_DEMANDS; ++k) need = kith_requirements_or(need, demand[k].need);
  return need;
}

/* The radius that lists are made with: the support, a skin, and for rates that change within a step twice what the support
 * grew in it. Too little costs a rebuild when the density is known, too much costs pairs. */
static void set_reach(const struct kith_integrator *it) {
  const struct kith_nodes *nodes = it->nodes;
  if (it->resuming) { /* bit for bit what it was */
    kith_field_copy(nodes, nodes->reach, it->built_reach);
    return;
  }
  const double *expansion = it->package->expansion->f64, rate = 2 * it->dt / NDIM;
#pragma omp parallel for simd schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    nodes->reach->f64[i] = (1 + it->skin + KITH_MIN(rate * fabs(expansion[i]), 0.1)) * nodes->support->f64[i];
}

/* Keeps nodes that are close in space close in memory. Due only every so many lifecycles, and done only if the order is lost. */
static kith_status reorder(struct kith_integrator *it) {
  if (it->reorder_every == 0 || it->since_reorder++ % (uint64_t)it->reorder_every != 0) return KITH_OK;
  kith_index *order = NULL;
  bool sorted;
  double lower[NDIM], upper[NDIM];
  kith_profile_begin(it->profile, "reorder");
  kith_status status = kith_resize(&order, 0, (size_t)it->nodes->n_internal, sizeof *order);
  kith_search_cube(it->nodes->position->f64, it->nodes->n_internal, lower,
                   upper); /* so that the tree need not sort */
  if (status == KITH_OK) status = kith_nodes_curve_order(it->nodes, lower, upper, order, &sorted);
  if (status == KITH_OK && !sorted) {
    status = kith_nodes_reorder(it->nodes, order);
    it->ledger.reorders += 1;
  }
  kith_free(&order);
  kith_profile_end(it->profile);
  return status;
}

/* Two layers of ghosts, so that those of the first have all that is in their own support. */
static kith_status ghosts_with_rows(struct kith_integrator *it) {
  struct kith_boundary *last = it->boundaries->boundary[it->boundaries->n - 1];
  KITH_TRY(kith_distributed_widen(last, it->nodes));
  KITH_TRY(kith_boundaries_ghosts(it->boundaries, it->nodes, 2, it->profile));
  set_reach(it);
  kith_nodes_refresh_ghosts(it->nodes, &it->nodes->reach, 1);
  return KITH_OK;
}

static kith_status ghosts(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "ghosts");
  const kith_status status =
      it->package->recompute
          ? ghosts_with_rows(it)
          : kith_boundaries_ghosts(it->boundaries, it->nodes, it->need.overlap ? 2 : 1, it->profile);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  for (int b = 0; b < it->nodes->n_blocks; ++b)
    it->ledger.boundary[it->nodes->blocks[b].boundary].created += (uint64_t)it->nodes->blocks[b].count;
  it->ledger.created += (uint64_t)it->nodes->n_ghost;
  return KITH_OK;
}

static kith_status neighbors(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "neighbors");
  const kith_status status = kith_search_update(it->search);
  kith_profile_end(it->profile);
  return status;
}

static kith_status connectivity(struct kith_integrator *it) {
  kith_profile_begin(it->profile, "connectivity");
  const kith_status status =
      kith_connectivity_build(it->connectivity, it->nodes, it->search, it->need, it->excluders, it->profile);
  kith_profile_count(it->profile, "candidates", (double)it->connectivity->candidates);
  kith_profile_end(it->profile);
  it->ledger.candidates += it->connectivity->candidates;
  return status;
}

/* Barriers cut pairs. A barrier's nodes stand apart by its spacing, which its support is a multiple of. */
static kith_status shield(struct kith_integrator *it) {
  const double spacings = pow(it->package->neighbors / kith_ball(), 1.0 / NDIM);
  size_t cut = 0;
  if (it->package->barrier == NULL) return KITH_OK;
  kith_profile_begin(it->profile, "shield");
  const kith_status status = kith_connectivity_shield(it->connectivity, it->nodes, it->package->barrier,
                                                      (NDIM == 3 ? 0.72 : 0.51) / spacings, &cut);
  kith_profile_count(it->profile, "cut", (double)cut);
  kith_profile_end(it->profile);
  it->ledger.cut += cut;
  return status;
}

/* Ghosts that no internal node needs go, unless rows of ghosts or overlap are wanted. A rank without ghosts may have images that
 * others want. */
static bool may_cull(const struct kith_integrator *it) {
  return it->cull && !it->need.ghost_rows && !it->need.overlap &&
         (it->nodes->n_ghost > 0 || it->nodes->ranks != NULL);
}

static kith_status cull_room(struct kith_integrator *it, size_t ghosts, size_t all) {
  if (it->keep_capacity < ghosts) {
    it->keep_capacity = 0;
    KITH_TRY(kith_resize(&it->keep, 0, ghosts + ghosts / 4, 1));
    it->keep_capacity = ghosts + ghosts / 4;
  }
  if (it->renumber_capacity < all) {
    it->renumber_capacity = 0;
    KITH_TRY(kith_resize(&it->renumber, 0, all + all / 16, sizeof *it->renumber));
    it->renumber_capacity = all + all / 16;
  }
  return KITH_OK;
}

/* What this rank needs, and what others need of it. */
static kith_status mark(struct kith_integrator *it) {
  struct kith_nodes *nodes = it->nodes;
  if (nodes->n_ghost > 0) memset(it->keep, 0, (size_t)nodes->n_ghost);
  kith_connectivity_mark_ghosts(it->connectivity, nodes, it->keep);
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    if (it->boundaries->boundary[block->boundary]->ops->keeps_ghosts)
      memset(it->keep + (block->first - nodes->n_internal), 1, (size_t)block->count);
  }
  return kith_boundaries_trim(it->boundaries, nodes, it->keep);
}

/* *culled: the lists must be patched with it->renumber. */
static kith_status cull(struct kith_integrator *it, bool *culled) {
  struct kith_nodes *nodes = it->nodes;
  const size_t ghosts_before = (size_t)nodes->n_ghost;
  *culled = false;
  if (!may_cull(it)) return KITH_OK;
  KITH_TRY(kith_ranks_agree(nodes->ranks, cull_room(it, ghosts_before, (size_t)kith_nodes_count(nodes))));
  kith_profile_begin(it->profile, "cull");
  kith_status status = mark(it);
  if (status == KITH_OK) status = kith_nodes_cull_ghosts(nodes, it->keep, it->renumber);
  if (status == KITH_OK) kith_boundaries_renumbered(it->boundaries, it->renumber);
  kith_profile_count(it->profile, "culled", (double)ghosts_before - (double)nodes->n_ghost);
  kith_profile_end(it->profile);
  KITH_TRY(status);
  it->ledger.culled += ghosts_before - (uint64_t)nodes->n_ghost;
  *culled = (size_t)nodes->n_ghost < ghosts_before;
  return KITH_OK;
}

static kith_status patch(struct kith_integrator *it, kith_index before) {
  kith_profile_begin(it->profile, "patch");
  const kith_status status = kith_connectivity_patch(it->connectivity, it->nodes, it->renumber, before);
  kith_profile_end(it->profile);
  return status;
}

/* What the lists were made from: a restart makes them again. */
static void remember(struct kith_integrator *it) {
  const double *restrict x = it->nodes->position->f64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) it->built[a]->f64[i] = x[(size_t)i * NDIM + a];
  kith_field_copy(it->nodes, it->built_reach, it->nodes->reach);
  kith_field_copy(it->nodes, it->built_support, it->nodes->support);
}

/* Stamps, the ledger; rows in canonical order, when nothing needs them by index any more. */
static kith_status ready(struct kith_integrator *it, const char *reason) {
  struct kith_ledger *ledger = &it->ledger;
  const struct kith_connectivity *c = it->connectivity;
  ledger->kept += (uint64_t)it->nodes->n_ghost;
  for (int b = 0; b < it->nodes->n_blocks; ++b)
    ledger->boundary[it->nodes->blocks[b].boundary].kept += (uint64_t)it->nodes->blocks[b].count;
  for (int b = 0; b < it->boundaries->n; ++b)
    ledger->boundary[b].culled = ledger->boundary[b].created - ledger->boundary[b].kept;
  ledger->lifecycles += 1;
  ledger->last_entries =
      c->rows.n > 0 ? c->rows.first[it->nodes->n_internal] : 0; /* of nodes, not of ghosts */
  ledger->last_pairs = c->pairs.n;
  ledger->row_entries += ledger->last_entries;
  ledger->pairs += ledger->last_pairs;
  ledger->ghosts = (uint64_t)it->nodes->n_ghost;
  if (strcmp(reason, "first build") == 0) ledger->because[0] += 1;
  for (int k = 0; kith_rebuild_all()[k] != NULL; ++k)
    if (strcmp(reason, kith_rebuild_all()[k]->name) == 0) ledger->because[1 + k] += 1;
  if (it->built_reach != NULL) remember(it);
  if (it->share != NULL && c->rows.n > 0) kith_share_measure(it->share, it->nodes, c->rows.first);
  if (it->check) KITH_TRY(kith_connectivity_valid(c, it->nodes));
  return it->canonical ? kith_connectivity_canonical(it->connectivity, it->nodes) : KITH_OK;
}

/* Nodes go to the ranks that have their cells. The work of the last lists tells who has too much. */
static kith_status migrate(struct kith_integrator *it) {
  if (it->share == NULL) return KITH_OK;
  kith_profile_begin(it->profile, "migrate");
  const kith_status status = kith_share_settle(it->share, it->nodes);
  kith_profile_end(it->profile);
  return status;
}

kith_status kith_lifecycle_settle(struct kith_integrator *it) {
  KITH_TRY(
      kith_ranks_agree(it->nodes->ranks, kith_boundaries_enforce(it->boundaries, it->nodes, NULL, false)));
  KITH_TRY(migrate(it));
  return kith_ranks_agree(it->nodes->ranks, reorder(it));
}

/* What a rank does alone may fail on it alone: where the next stage talks to others, all agree first. */
kith_status kith_lifecycle(struct kith_integrator *it, const char *reason) {
  struct kith_ranks *ranks = it->nodes->ranks;
  bool culled;
  it->need = requirements(it);
  if (!it->holding) KITH_TRY(kith_lifecycle_settle(it));
  set_reach(it);
  KITH_TRY(ghosts(it));
  kith_status status = neighbors(it);
  if (status == KITH_OK) status = connectivity(it);
  if (status == KITH_OK) status = shield(it);
  KITH_TRY(kith_ranks_agree(ranks, status));
  const kith_index before = kith_nodes_count(it->nodes);
  KITH_TRY(kith_ranks_agree(ranks, cull(it, &culled)));
  if (culled) status = patch(it, before);
  if (status == KITH_OK) status = ready(it, reason);
  KITH_TRY(kith_ranks_agree(ranks, status));
  return kith_rebuilds_snapshot(it->rebuilds, it->nodes);
}
