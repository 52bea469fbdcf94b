/* The lifecycle of connectivity, in the order in which it happens. */
#include "integrator/lifecycle.h"

#include <math.h>
#include <string.h>

void kith_lifecycle_demands(const struct kith_integrator *it, struct kith_demand demand[KITH_DEMANDS]) {
  memset(demand, 0, KITH_DEMANDS * sizeof *demand);
  demand[0] = (struct kith_demand){"lifecycle", "culling", {.rows = true}};
  int n = 1;
  for (const struct kith_package *p = it->package; p != NULL; p = p->next)
    demand[n++] = (struct kith_demand){p->ops->name,
                                       p->ops->couple != NULL                ? "f_couple"
                                       : p->traversal == KITH_TRAVERSE_PAIRS ? "pairs"
                                                                             : "gather",
                                       kith_package_requirements(p)};
}

/* Nothing is built that is not required. */
static struct kith_requirements requirements(const struct kith_integrator *it) {
  struct kith_requirements need = {0};
  struct kith_demand demand[KITH_DEMANDS];
  kith_lifecycle_demands(it, demand);
  for (int k = 0; k < KITH_DEMANDS; ++k) need = kith_requirements_or(need, demand[k].need);
  return need;
}

static void velocity_of(const void *velocity, kith_index i, double *v) {
  memcpy(v, ((const struct kith_field *)velocity)->f64 + (size_t)i * NDIM, NDIM * sizeof *v);
}

/* The mean velocity along axes where a common drift is no displacement, 0 along the others. */
static void common_velocity(const struct kith_integrator *it, double c[NDIM]) {
  kith_mean_vector(it->nodes, velocity_of, it->hydro->velocity, c);
  for (int b = 0; b < it->boundaries->n; ++b) {
    const struct kith_boundary *boundary = it->boundaries->boundary[b];
    for (int a = 0; a < NDIM; ++a)
      if (boundary->ops->held_nodes != NULL ||
          (boundary->ops->has_faces && !boundary->ops->wraps && boundary->axis == a))
        c[a] = 0;
  }
}

/* w_i of lifecycle.h: how fast node i moves away from its position, a common drift excluded. */
static double speed_of(const struct kith_integrator *it, kith_index i, const double *c) {
  const double *a = it->hydro->acceleration->f64 + (size_t)i * NDIM;
  double w[NDIM];
  for (int k = 0; k < NDIM; ++k) w[k] = it->hydro->velocity->f64[(size_t)i * NDIM + k] - c[k];
  return kith_norm(w) + 0.5 * it->ahead * kith_norm(a);
}

/* Adds m_i of lifecycle.h, for the motion during `ahead`. */
static void add_motion(const struct kith_integrator *it) {
  const struct kith_nodes *nodes = it->nodes;
  double c[NDIM], fastest = 0;
  common_velocity(it, c);
#pragma omp parallel for schedule(static) reduction(max : fastest)
  for (kith_index i = 0; i < nodes->n_internal; ++i) fastest = KITH_MAX(fastest, speed_of(it, i, c));
  kith_ranks_max(nodes->ranks, &fastest, 1);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    nodes->search_radius->f64[i] +=
        KITH_MIN(1.01 * it->ahead * (speed_of(it, i, c) + fastest), 0.25 * nodes->support->f64[i]);
}

void kith_lifecycle_search_radii(const struct kith_integrator *it) {
  const struct kith_nodes *nodes = it->nodes;
  if (it->resuming) { /* bitwise identical to what it was */
    kith_field_copy(nodes, nodes->search_radius, it->built.search_radius);
    return;
  }
  const double *velocity_divergence = it->package->velocity_divergence->f64;
  const struct kith_block_steps *blocks = it->kick.blocks;
  const double longest = KITH_MAX(it->dt, it->ahead);
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    const double h = nodes->support->f64[i],
                 dt = blocks != NULL ? blocks->tick * blocks->step->f64[i] : longest;
    const double change = dt * (2 * fabs(velocity_divergence[i]) / NDIM +
                                dt * kith_norm(it->hydro->acceleration->f64 + (size_t)i * NDIM) / h);
    nodes->search_radius->f64[i] = (1 + it->skin + KITH_MIN(change, 0.1)) * h;
  }
  if (it->ahead > 0) add_motion(it);
}

/* Keeps nodes that are close in space close in memory. Due only every so many lifecycles, and done only if
 * the order is lost. */
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
  KITH_TRY(kith_halo_extend(it->hydro->halo, it->nodes));
  KITH_TRY(kith_boundaries_ghosts(it->boundaries, it->nodes, 2, it->profile));
  kith_lifecycle_search_radii(it);
  kith_halo_refresh(it->hydro->halo, it->nodes, &it->nodes->search_radius, 1);
  return KITH_OK;
}

/* A support that cannot find its neighbors would grow, and images with it, until memory ends. */
static kith_status bound_ghosts(const struct kith_integrator *it) {
  enum { MOST = NDIM == 3 ? 1000 : NDIM == 2 ? 400 : 100 }; /* a node, and a neighbor that is wanted */
  const struct kith_nodes *nodes = it->nodes;
  kith_index widest = 0;
  if (nodes->n_ghost <= MOST * (nodes->n_internal + it->package->neighbors)) return KITH_OK;
  for (kith_index i = 1; i < nodes->n_internal; ++i)
    if (nodes->support->f64[i] > nodes->support->f64[widest]) widest = i;
  KITH_FAIL(DIVERGED, "%d nodes have %d images: the support of node %lld, %g, does not find its neighbors",
            nodes->n_internal, nodes->n_ghost, (long long)nodes->id->i64[widest],
            nodes->support->f64[widest]);
}

static kith_status ghosts(struct kith_integrator *it) {
  const int factor = it->need.overlap ? 2 : 1;
  kith_status status;
  KITH_STAGE(status, it->profile, "ghosts",
             it->package->recompute ? ghosts_with_rows(it)
                                    : kith_boundaries_ghosts(it->boundaries, it->nodes, factor, it->profile));
  KITH_TRY(kith_ranks_allreduce_status(it->nodes->ranks, status == KITH_OK ? bound_ghosts(it) : status));
  for (int b = 0; b < it->boundaries->n; ++b)
    it->ledger.boundary[b].created += (uint64_t)it->boundaries->boundary[b]->made;
  it->ledger.ghosts_created += (uint64_t)it->nodes->n_ghost;
  return KITH_OK;
}

/* What packages make of the new pairs. */
static kith_status couple(struct kith_integrator *it) {
  const size_t before = it->connectivity->pairs.n;
  kith_status status = KITH_OK;
  for (struct kith_package *p = it->package; p != NULL && status == KITH_OK; p = p->next)
    if (p->ops->couple != NULL)
      KITH_STAGE(status, it->profile, p->ops->name, p->ops->couple(p, it->connectivity));
  it->ledger.pairs_cut += before - it->connectivity->pairs.n;
  return status;
}

/* Ghosts that no internal node needs go, unless rows of ghosts or overlap are wanted. A rank without ghosts
 * may have images that others want. */
static bool may_cull(const struct kith_integrator *it) {
  return it->cull && !it->need.ghost_rows && !it->need.overlap &&
         (it->nodes->n_ghost > 0 || it->nodes->ranks != NULL);
}

/* What this rank needs, and what others need of it. */
static kith_status mark(struct kith_integrator *it) {
  struct kith_nodes *nodes = it->nodes;
  if (nodes->n_ghost > 0) memset(it->scratch.keep, 0, (size_t)nodes->n_ghost);
  kith_connectivity_mark_ghosts(it->connectivity, nodes, it->scratch.keep);
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    if (it->boundaries->boundary[block->boundary]->ops->keeps_ghosts)
      memset(it->scratch.keep + (block->first - nodes->n_internal), 1, (size_t)block->count);
  }
  return kith_halo_cull_remote(it->hydro->halo, nodes, it->scratch.keep);
}

/* Ghosts that went, by boundary, from the blocks as they were and the renumbering. */
static void count_culled(struct kith_integrator *it, const struct kith_ghost_block *block, int n_blocks) {
  for (int b = 0; b < n_blocks; ++b) {
    const kith_index *restrict renumber = it->scratch.renumber + block[b].first;
    uint64_t culled = 0;
#pragma omp parallel for simd schedule(static) reduction(+ : culled)
    for (kith_index g = 0; g < block[b].count; ++g) culled += renumber[g] < 0;
    it->ledger.boundary[block[b].boundary].culled += culled;
    it->ledger.ghosts_culled += culled;
  }
}

/* Memory, and the blocks as they are. */
static kith_status prepare_cull(struct kith_integrator *it, struct kith_ghost_block **blocks) {
  const struct kith_nodes *nodes = it->nodes;
  const size_t ghosts = (size_t)nodes->n_ghost, all = (size_t)kith_nodes_count(nodes);
  KITH_TRY(kith_reserve(&it->scratch.keep, &it->scratch.keep_capacity, ghosts, 1));
  KITH_TRY(kith_reserve(&it->scratch.renumber, &it->scratch.renumber_capacity, all, sizeof(kith_index)));
  KITH_TRY(kith_resize(blocks, 0, (size_t)nodes->n_blocks, sizeof **blocks));
  if (nodes->n_blocks > 0) memcpy(*blocks, nodes->blocks, (size_t)nodes->n_blocks * sizeof **blocks);
  return KITH_OK;
}

static kith_status cull(struct kith_integrator *it) {
  struct kith_nodes *nodes = it->nodes;
  struct kith_ghost_block *blocks = NULL;
  const kith_index before = nodes->n_ghost;
  const int n_blocks = nodes->n_blocks;
  kith_profile_begin(it->profile, "cull");
  kith_status status = prepare_cull(it, &blocks);
  status = kith_ranks_allreduce_status(nodes->ranks, status); /* mark() communicates with other ranks */
  if (status == KITH_OK) status = mark(it);
  if (status == KITH_OK) status = kith_nodes_cull_ghosts(nodes, it->scratch.keep, it->scratch.renumber);
  if (status == KITH_OK) kith_halo_remap(it->hydro->halo, it->scratch.renumber);
  if (status == KITH_OK) count_culled(it, blocks, n_blocks);
  kith_free(&blocks);
  kith_profile_count(it->profile, "culled", before - nodes->n_ghost);
  kith_profile_end(it->profile);
  return status;
}

/* What the lists were made from: a restart makes them again. */
static void remember(struct kith_integrator *it) {
  const double *restrict x = it->nodes->position->f64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) it->built.x[a]->f64[i] = x[(size_t)i * NDIM + a];
  kith_field_copy(it->nodes, it->built.search_radius, it->nodes->search_radius);
  kith_field_copy(it->nodes, it->built.support, it->nodes->support);
}

/* The ledger, what a restart needs, checks; last the canonical order, when nothing needs rows sorted by index
 * any more. */
static kith_status ready(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  struct kith_ledger *ledger = &it->ledger;
  const struct kith_connectivity *c = it->connectivity;
  ledger->ghosts_kept += (uint64_t)it->nodes->n_ghost;
  for (int b = 0; b < it->nodes->n_blocks; ++b)
    ledger->boundary[it->nodes->blocks[b].boundary].kept += (uint64_t)it->nodes->blocks[b].count;
  ledger->lifecycles += 1;
  ledger->last_row_entries =
      c->rows.n > 0 ? c->rows.first[it->nodes->n_internal] : 0; /* of nodes, not of ghosts */
  ledger->last_pairs = c->pairs.n;
  ledger->row_entries += ledger->last_row_entries;
  ledger->pairs += ledger->last_pairs;
  ledger->overlap_pairs += c->overlap_pairs.n;
  ledger->last_ghosts = (uint64_t)it->nodes->n_ghost;
  ledger->because[reason] += 1;
  if (it->built.search_radius != NULL) remember(it);
  if (it->decomposition != NULL && c->rows.n > 0)
    kith_decomposition_measure(it->decomposition, it->nodes, c->rows.first);
  if (it->check && !kith_ledger_closes(ledger)) KITH_FAIL(INTERNAL, "the ledger does not close");
  if (it->check) KITH_TRY(kith_connectivity_valid(c, it->nodes));
  return it->canonical ? kith_connectivity_canonical(it->connectivity, it->nodes) : KITH_OK;
}

/* The nodes that are not active, and have an active neighbor. */
static void mark_touched(const struct kith_nodes *nodes, const struct kith_rows *rows) {
  uint8_t *activity = nodes->activity->u8;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (activity[i] != KITH_ACTIVE)
      activity[i] = rows->n > 0 && rows->first[i + 1] > rows->first[i] ? KITH_TOUCHED : KITH_IDLE;
}

/* Puts nodes back where boundaries want them, on the ranks that own their cells (the work of the last lists
 * tells who has too much), and in order if that is due. */
static kith_status redistribute(struct kith_integrator *it) {
  struct kith_nodes *nodes = it->nodes;
  kith_status status = kith_boundaries_enforce(it->boundaries, nodes, NULL, false);
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, status));
  if (it->decomposition != NULL)
    KITH_STAGE(status, it->profile, "migrate", kith_decomposition_redistribute(it->decomposition, nodes));
  KITH_TRY(status);
  return kith_ranks_allreduce_status(nodes->ranks, reorder(it));
}

/* With nodes where they are now. */
static kith_status update_search(struct kith_integrator *it) {
  struct kith_search *search = it->search;
  const char *const *name = search->ops->counters;
  KITH_TRY(it->near.only ? kith_search_update_selected(search, it->near.node, it->near.n)
                         : kith_search_update(search));
  for (int k = 0; name != NULL && name[k] != NULL; ++k)
    kith_profile_count(it->profile, name[k], (double)search->count[k]);
  return KITH_OK;
}

/* What a rank does alone may fail on it alone: where the next stage talks to others, all agree first. */
static kith_status run(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  struct kith_nodes *nodes = it->nodes;
  kith_status status;
  it->need = requirements(it);
  if (!it->holding) KITH_TRY(redistribute(it));
  if (it->holding && it->kick.blocks != NULL && !it->near.only)
    KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, reorder(it)));
  if (it->near.only) KITH_TRY(it->near.find(it));
  kith_lifecycle_search_radii(it);
  if (it->near.only)
    kith_nodes_drop_ghosts(nodes);
  else
    KITH_TRY(ghosts(it));
  KITH_STAGE(status, it->profile, "neighbors", update_search(it));
  if (status == KITH_OK)
    KITH_STAGE(
        status, it->profile, "connectivity",
        kith_connectivity_build(it->connectivity, nodes, it->search, it->need, it->excluders, it->profile));
  it->ledger.candidates += it->connectivity->candidates;
  if (status == KITH_OK && it->check && it->search->ops->sweep != NULL)
    status = kith_connectivity_complete(it->connectivity, it->search, it->excluders != NULL);
  if (nodes->activity != NULL) mark_touched(nodes, &it->connectivity->rows);
  if (status == KITH_OK) status = couple(it);
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, status));
  const kith_index before = kith_nodes_count(nodes);
  if (may_cull(it)) KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, cull(it)));
  if (kith_nodes_count(nodes) < before)
    KITH_STAGE(status, it->profile, "patch",
               kith_connectivity_patch(it->connectivity, nodes, it->scratch.renumber, before));
  if (status == KITH_OK) status = ready(it, reason);
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, status));
  it->fresh = true, it->positions = nodes->positions;
  return kith_rebuilds_snapshot(it->rebuilds, nodes);
}

kith_status kith_lifecycle(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  kith_status status;
  KITH_STAGE(status, it->profile, "lifecycle", run(it, reason));
  return status;
}

/* What the lists were made from, then the present. Nodes were in their places then, and stay there. */
kith_status kith_lifecycle_remake(struct kith_integrator *it, struct kith_field *position,
                                  struct kith_field *support) {
  struct kith_nodes *nodes = it->nodes;
  const bool holding = it->holding;
  kith_field_copy(nodes, position, nodes->position);
  kith_field_copy(nodes, support, nodes->support);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] = it->built.x[a]->f64[i];
  kith_field_copy(nodes, nodes->support, it->built.support);
  it->holding = true, it->resuming = true;
  const kith_status status = kith_lifecycle(it, KITH_BECAUSE_requested);
  it->holding = holding, it->resuming = false, it->fresh = false;
  kith_field_copy(nodes, nodes->position, position);
  kith_field_copy(nodes, nodes->support, support);
  nodes->positions += 1;
  return status;
}
