/* The lifecycle of connectivity, in the order in which it happens. */
#include "integrator/lifecycle.h"

#include <math.h>
#include <string.h>
#include "lib/nodes/migrate.h"

/* Returns the union of what packages require, and rows to cull by: nothing else is built. */
static struct kith_requirements requirements(const struct kith_integrator *it) {
  struct kith_requirements need = {.rows = true};
  for (const struct kith_package *p = it->package; p != NULL; p = p->next)
    need = kith_requirements_or(need, kith_package_requirements(p));
  return need;
}

static void velocity_of(const void *velocity, kith_index i, double *v) {
  memcpy(v, ((const struct kith_field *)velocity)->f64 + (size_t)i * NDIM, NDIM * sizeof *v);
}

/* Sets c to the mean velocity along axes where a common drift is no displacement, 0 along the others. */
static void common_velocity(const struct kith_integrator *it, double c[NDIM]) {
  kith_mean_vector(it->nodes, velocity_of, it->hydro->velocity, c);
  for (int b = 0; b < it->boundaries->n; ++b) {
    const struct kith_boundary *boundary = it->boundaries->boundary[b];
    for (int a = 0; a < NDIM; ++a)
      if (boundary->held != NULL ||
          (boundary->ops->has_faces && !boundary->ops->wraps && boundary->axis == a))
        c[a] = 0;
  }
}

/* Returns w_i of lifecycle.h: the speed of node i beyond a common drift. */
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
  if (it->resuming) { /* so that the lists are bitwise the same */
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
    const double growth = kith_node_active(nodes, i) ? KITH_MIN(change, 0.1) : 0;
    nodes->search_radius->f64[i] = (1 + it->skin + growth) * h;
  }
  if (it->ahead > 0) add_motion(it);
}

/* Sorts nodes along a curve, so that nodes close in space are close in memory. Considered only every so many
 * lifecycles, and done only if the order is lost. */
static kith_status reorder(struct kith_integrator *it) {
  const bool due = it->since_reorder == 0 || it->since_reorder >= (uint64_t)it->reorder_every;
  it->since_reorder = due ? 1 : it->since_reorder + 1;
  if (it->reorder_every == 0 || !due) return KITH_OK;
  bool sorted = true;
  kith_profile_begin(it->profile, "reorder");
  const kith_status status = kith_search_sort_nodes(it->nodes, &sorted);
  it->ledger.reorders += !sorted;
  kith_profile_end(it->profile);
  return status;
}

static double ghost_factor(const struct kith_integrator *it) {
  return (it->need.overlap ? 2 : 1) * it->nodes->longest;
}

/* Makes two layers of ghosts, so that ghosts of the first have all neighbors in their own support. */
static kith_status ghosts_with_rows(struct kith_integrator *it, kith_status status) {
  struct kith_shared parts[KITH_MAX_BOUNDARIES];
  kith_halo_extend(it->hydro->halo, it->nodes);
  kith_boundaries_measure(it->boundaries, it->nodes, 2);
  status = kith_ranks_agree(it->nodes->ranks, status, kith_boundaries_share(it->boundaries, parts), parts);
  status = kith_boundaries_make_ghosts(it->boundaries, it->nodes, 2, it->profile, status);
  kith_lifecycle_search_radii(it);
  kith_halo_refresh(it->hydro->halo, it->nodes, &it->nodes->search_radius, 1);
  return status;
}

/* Fails if there are too many images: a support that cannot find its neighbors would grow, and images with
 * it, until memory ends. Remote ghosts count as neither nodes nor images: some are images, which their own
 * ranks compare with their nodes. */
static kith_status bound_ghosts(const struct kith_integrator *it) {
  enum { MOST = NDIM == 3 ? 1000 : NDIM == 2 ? 400 : 100 }; /* most images per node and wanted neighbor */
  const struct kith_nodes *nodes = it->nodes;
  double images = (double)nodes->n_internal * (nodes->shifts.n - 1), of = nodes->n_internal;
  kith_index widest = 0;
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    if (block->kind == KITH_GHOST_IMAGE) images += block->count;
    if (block->kind == KITH_GHOST_FROZEN) of += block->count;
  }
  if (images <= MOST * (of + it->package->neighbors) || nodes->n_internal == 0) return KITH_OK;
  for (kith_index i = 1; i < nodes->n_internal; ++i)
    if (nodes->support->f64[i] > nodes->support->f64[widest]) widest = i;
  const int64_t id = nodes->id->i64[widest];
  KITH_FAIL_NODE(DIVERGED, id,
                 "%.0f nodes have %.0f images: the support of node %lld, %g, does not find its neighbors", of,
                 images, (long long)id, nodes->support->f64[widest]);
}

static kith_status ghosts(struct kith_integrator *it, kith_status status) {
  KITH_STAGE(status, it->profile, "ghosts",
             it->package->recompute ? ghosts_with_rows(it, status)
                                    : kith_boundaries_make_ghosts(it->boundaries, it->nodes, ghost_factor(it),
                                                                  it->profile, status));
  if (status == KITH_OK) status = bound_ghosts(it);
  for (int b = 0; b < it->boundaries->n; ++b)
    it->ledger.boundary[b].created += (uint64_t)it->boundaries->boundary[b]->made;
  it->ledger.ghosts_created += (uint64_t)it->nodes->n_ghost;
  return status;
}

/* Lets packages couple or cut the new pairs. */
static kith_status couple(struct kith_integrator *it) {
  const size_t before = it->connectivity->pairs.n;
  kith_status status = KITH_OK;
  for (struct kith_package *p = it->package; p != NULL && status == KITH_OK; p = p->next)
    if (p->ops->couple != NULL)
      KITH_STAGE(status, it->profile, p->ops->name, p->ops->couple(p, it->connectivity));
  it->ledger.pairs_cut += before - it->connectivity->pairs.n;
  return status;
}

/* May ghosts that no internal node needs be culled? Not if rows of ghosts or overlap are required. A rank
 * without ghosts takes part, as it may have images that others need. */
static bool may_cull(const struct kith_integrator *it) {
  return it->cull && !it->need.ghost_rows && !it->need.overlap &&
         (it->nodes->n_ghost > 0 || it->nodes->ranks != NULL);
}

/* Keeps all ghosts if few could be culled: to renumber the lists costs more than these ghosts do. Images that
 * other ranks may need are not among those few. */
static void keep_few(const struct kith_halo *halo, const struct kith_nodes *nodes, uint8_t *keep) {
  enum { WORTH_A_CULL = 16 /* one ghost of so many */, SENT = 2 /* a bit of a mark */ };
  kith_index kept = 0;
  kith_halo_mark_sent(halo, nodes, keep, SENT);
#pragma omp parallel for simd schedule(static) reduction(+ : kept) if (nodes->n_ghost > KITH_FEW)
  for (kith_index g = 0; g < nodes->n_ghost; ++g) kept += keep[g] != 0, keep[g] &= ~SENT;
  if (nodes->n_ghost - kept < nodes->n_ghost / WORTH_A_CULL) memset(keep, 1, (size_t)nodes->n_ghost);
}

/* Marks the ghosts that this rank needs, and sends that to other ranks. Called while rows are built, unless
 * packages cut them afterwards: then the messages travel while entries are filled in. */
static kith_status tell_marks(void *integrator) {
  struct kith_integrator *it = integrator;
  const struct kith_nodes *nodes = it->nodes;
  KITH_TRY(kith_reserve(&it->scratch.keep, &it->scratch.keep_capacity, (size_t)nodes->n_ghost, 1));
  if (nodes->n_ghost > 0) memset(it->scratch.keep, 0, (size_t)nodes->n_ghost);
  kith_connectivity_mark_ghosts(it->connectivity, nodes, it->scratch.keep);
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    if (block->kind == KITH_GHOST_FROZEN)
      memset(it->scratch.keep + (block->first - nodes->n_internal), 1, (size_t)block->count);
  }
  if (nodes->n_ghost > 0) keep_few(it->hydro->halo, nodes, it->scratch.keep);
  kith_halo_start_cull(it->hydro->halo, nodes, it->scratch.keep);
  it->scratch.told = true;
  return KITH_OK;
}

/* Counts culled ghosts by boundary, from the blocks before the cull and the renumbering. */
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

/* Reserves memory, and copies the present blocks. */
static kith_status prepare_cull(struct kith_integrator *it, struct kith_ghost_block **blocks) {
  const struct kith_nodes *nodes = it->nodes;
  const size_t all = (size_t)kith_nodes_count(nodes);
  KITH_TRY(kith_reserve(&it->scratch.renumber, &it->scratch.renumber_capacity, all, sizeof(kith_index)));
  KITH_TRY(kith_resize(blocks, 0, (size_t)nodes->n_blocks, sizeof **blocks));
  if (nodes->n_blocks > 0) memcpy(*blocks, nodes->blocks, (size_t)nodes->n_blocks * sizeof **blocks);
  return KITH_OK;
}

static kith_status cull(struct kith_integrator *it, kith_status status) {
  struct kith_nodes *nodes = it->nodes;
  struct kith_ghost_block *blocks = NULL;
  const kith_index before = nodes->n_ghost;
  const int n_blocks = nodes->n_blocks;
  kith_profile_begin(it->profile, "cull");
  if (status == KITH_OK) status = prepare_cull(it, &blocks);
  if (status == KITH_OK && !it->scratch.told) status = tell_marks(it);
  if (!it->scratch.told) kith_halo_start_cull(it->hydro->halo, nodes, NULL);
  it->scratch.told = false;
  kith_halo_finish_cull(it->hydro->halo, nodes, status == KITH_OK ? it->scratch.keep : NULL);
  if (status == KITH_OK && before > 0 && memchr(it->scratch.keep, 0, (size_t)before) != NULL) {
    status = kith_nodes_cull_ghosts(nodes, it->scratch.keep, it->scratch.renumber);
    if (status == KITH_OK) kith_halo_remap(it->hydro->halo, it->scratch.renumber);
    if (status == KITH_OK) count_culled(it, blocks, n_blocks);
  }
  kith_free(&blocks);
  kith_profile_count(it->profile, "culled", before - nodes->n_ghost);
  kith_profile_end(it->profile);
  return status;
}

/* Stores what the lists were made from: a restart makes them again. */
static void remember(struct kith_integrator *it) {
  const double *restrict x = it->nodes->position->f64;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < it->nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) it->built.x[a]->f64[i] = x[(size_t)i * NDIM + a];
  kith_field_copy(it->nodes, it->built.search_radius, it->nodes->search_radius);
  kith_field_copy(it->nodes, it->built.support, it->nodes->support);
}

/* Fills the ledger, stores what a restart needs, and checks. Canonical order comes last, when nothing needs
 * rows sorted by index any more. */
static kith_status ready(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  struct kith_ledger *ledger = &it->ledger;
  const struct kith_connectivity *c = it->connectivity;
  ledger->ghosts_kept += (uint64_t)it->nodes->n_ghost;
  for (int b = 0; b < it->nodes->n_blocks; ++b)
    ledger->boundary[it->nodes->blocks[b].boundary].kept += (uint64_t)it->nodes->blocks[b].count;
  ledger->lifecycles += 1;
  ledger->last_row_entries =
      c->rows.n > 0 ? c->rows.first[it->nodes->n_internal] : 0; /* without the rows of ghosts */
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
  if (!it->canonical) return KITH_OK;
  KITH_TRY(kith_connectivity_canonical(it->connectivity, it->nodes));
  return it->check ? kith_connectivity_valid(c, it->nodes) : KITH_OK;
}

/* Marks nodes that are not active but have an active neighbor as touched. */
static void mark_touched(const struct kith_integrator *it) {
  const struct kith_rows *rows = &it->connectivity->rows;
  uint8_t *activity = it->nodes->activity->u8;
#pragma omp parallel for schedule(static) if (kith_near_count(it) > KITH_FEW)
  for (kith_index k = 0; k < kith_near_count(it); ++k) {
    const kith_index i = kith_near_node(it, k);
    if (activity[i] != KITH_ACTIVE)
      activity[i] = rows->n > 0 && rows->first[i + 1] > rows->first[i] ? KITH_TOUCHED : KITH_IDLE;
  }
}

/* What ranks reduce before nodes move and ghosts are made. Largest values: search radius, distance outside of
 * a cell, mass, minus the mass. Sums: nodes that leave their rank, those that go to no neighbor, all. */
enum { WIDEST, OUTSIDE, HEAVIEST, LIGHTEST, MAXIMA };
enum { LEAVING, FAR, NODES, SUMS };
struct reduced_values {
  double most[MAXIMA];
  uint64_t sum[SUMS];
};

static kith_status local_extremes(const struct kith_integrator *it, struct reduced_values *reduced) {
  const struct kith_nodes *nodes = it->nodes;
  const double *radius = nodes->search_radius->f64, *mass = it->hydro->mass->f64;
  double widest = 0, heaviest = -INFINITY, lightest = INFINITY;
  int broken = 0;
#pragma omp parallel for simd schedule(static) reduction(max : widest, heaviest) reduction(min : lightest) \
    reduction(| : broken)
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    broken |= !(radius[i] < INFINITY);
    widest = KITH_MAX(widest, radius[i]);
    heaviest = KITH_MAX(heaviest, mass[i]);
    lightest = KITH_MIN(lightest, mass[i]);
  }
  reduced->most[WIDEST] = widest, reduced->most[HEAVIEST] = heaviest, reduced->most[LIGHTEST] = -lightest;
  reduced->sum[NODES] = (uint64_t)nodes->n_internal;
  if (!broken) return KITH_OK;
  kith_index first = 0;
  while (radius[first] < INFINITY) ++first;
  const int64_t id = nodes->id->i64[first];
  KITH_FAIL_NODE(DIVERGED, id, "the search radius of node %lld is not finite", (long long)id);
}

/* Updates the search with the present positions. */
static kith_status update_search(struct kith_integrator *it) {
  struct kith_search *search = it->search;
  const char *const *name = search->ops->counters;
  KITH_TRY(it->near.only ? kith_search_update_selected(search, it->near.node, it->near.n)
                         : kith_search_update(search));
  for (int k = 0; name != NULL && name[k] != NULL; ++k)
    kith_profile_count(it->profile, name[k], (double)search->count[k]);
  return KITH_OK;
}

/* Exchanges all that ranks have to know before ghosts are made, in one call. */
static kith_status agree(struct kith_integrator *it, struct reduced_values *reduced, kith_status status) {
  const struct kith_decomposition *d = it->decomposition;
  struct kith_shared parts[2 + KITH_MAX_BOUNDARIES] = {{KITH_SHARE_MAX, MAXIMA, reduced->most},
                                                       {KITH_SHARE_SUM, SUMS, reduced->sum}};
  kith_boundaries_measure(it->boundaries, it->nodes, ghost_factor(it));
  if (d == NULL) return status;
  if (status == KITH_OK) status = local_extremes(it, reduced);
  if (it->holding)
    reduced->most[OUTSIDE] = kith_decomposition_outside(d, it->nodes);
  else
    reduced->most[OUTSIDE] = d->outside, reduced->sum[LEAVING] = d->leaving, reduced->sum[FAR] = d->far;
  KITH_STAGE(status, it->profile, "allreduce",
             kith_ranks_agree(it->nodes->ranks, status, 2 + kith_boundaries_share(it->boundaries, parts + 2),
                              parts));
  KITH_TRY(status);
  it->hydro->equal_masses = reduced->most[HEAVIEST] == -reduced->most[LIGHTEST];
  return kith_halo_surround(it->hydro->halo,
                            (it->package->recompute ? 2 : ghost_factor(it)) * reduced->most[WIDEST] +
                                2 * reduced->most[OUTSIDE] + kith_boundaries_gain(it->boundaries));
}

/* Moves nodes to the ranks that own their cells. `most` of the boundaries is kept: it is of the nodes of all
 * ranks. */
static kith_status migrate(struct kith_integrator *it, const struct reduced_values *reduced) {
  double most[KITH_MAX_BOUNDARIES][KITH_BOUNDARY_MAXIMA];
  kith_status status;
  KITH_STAGE(status, it->profile, "migrate",
             kith_decomposition_move(it->decomposition, it->nodes, reduced->sum[LEAVING], reduced->sum[FAR]));
  if (status != KITH_OK || reduced->sum[LEAVING] == 0) return status;
  const int n = KITH_MIN(it->boundaries->n, KITH_MAX_BOUNDARIES);
  for (int b = 0; b < n; ++b) memcpy(most[b], it->boundaries->boundary[b]->most, sizeof most[b]);
  kith_boundaries_measure(it->boundaries, it->nodes, ghost_factor(it));
  for (int b = 0; b < n; ++b) memcpy(it->boundaries->boundary[b]->most, most[b], sizeof most[b]);
  return KITH_OK;
}

/* Wraps nodes (mirrors act at the end of the step), finds their ranks (by the work of the last lists) and
 * search radii. Ranks agree. */
static kith_status prepare(struct kith_integrator *it, struct reduced_values *reduced) {
  kith_status status = it->pending;
  it->pending = KITH_OK;
  if (!it->holding && status == KITH_OK) status = kith_boundaries_wrap(it->boundaries, it->nodes);
  if (!it->holding && it->decomposition != NULL)
    status = kith_decomposition_assign(it->decomposition, it->nodes, status);
  kith_lifecycle_search_radii(it);
  return agree(it, reduced, status);
}

/* Moves nodes to their ranks, reorders them if that is due, then makes ghosts. */
static kith_status place(struct kith_integrator *it, const struct reduced_values *reduced) {
  kith_status status = it->holding || it->decomposition == NULL ? KITH_OK : migrate(it, reduced);
  if (status == KITH_OK && (!it->holding || it->kick.blocks != NULL)) status = reorder(it);
  return ghosts(it, status);
}

/* Finds the nodes of a local tick and drops all ghosts, as these nodes are far from boundaries. The next
 * lifecycle of all nodes, which is rare then, reorders nodes. */
static kith_status place_near(struct kith_integrator *it) {
  kith_status status;
  it->since_reorder = (uint64_t)it->reorder_every;
  KITH_STAGE(status, it->profile, "near", it->near.find(it));
  KITH_TRY(status);
  kith_lifecycle_search_radii(it);
  kith_nodes_drop_ghosts(it->nodes);
  return KITH_OK;
}

/* Builds rows, pairs and what else is required, and lets packages couple pairs. */
static kith_status build_connectivity(struct kith_integrator *it) {
  kith_status status;
  bool early = it->nodes->ranks != NULL && may_cull(it);
  for (const struct kith_package *p = it->package; p != NULL; p = p->next)
    early = early && p->ops->couple == NULL; /* which may cut rows */
  it->connectivity->when_marked = early ? tell_marks : NULL, it->connectivity->context = it;
  KITH_STAGE(status, it->profile, "connectivity",
             kith_connectivity_build(it->connectivity, it->nodes, it->search, it->need, it->excluders,
                                     it->profile));
  if (status == KITH_OK && it->check && it->search->ops->sweep != NULL)
    status = kith_connectivity_complete(it->connectivity, it->search, it->excluders != NULL);
  if (status == KITH_OK && it->nodes->activity != NULL) mark_touched(it);
  return status == KITH_OK ? couple(it) : status;
}

/* Lets policies take a snapshot, and starts to agree on the status and the number of nodes. */
static kith_status begin_closing(struct kith_integrator *it, const struct reduced_values *reduced,
                                 kith_status status) {
  it->count[0] = reduced->sum[NODES], it->count[1] = (uint64_t)it->nodes->n_internal;
  const struct kith_shared parts[] = {{KITH_SHARE_SUM, 1, &it->count[1]}, kith_rebuilds_shared(it->rebuilds)};
  if (status == KITH_OK) status = kith_rebuilds_take(it->rebuilds, it->nodes);
  return kith_ranks_start_agree(it->nodes->ranks, status, 2, parts);
}

kith_status kith_lifecycle_close(struct kith_integrator *it) {
  KITH_TRY(kith_ranks_finish_agree(it->nodes->ranks));
  if (it->decomposition == NULL) return KITH_OK;
  return kith_nodes_all_left(it->nodes->ranks, it->count[0], it->count[1]);
}

/* Runs the stages: requirements, ghosts, neighbors, connectivity, cull, patch, ready. Ranks agree before
 * ghosts are made and at the end. A rank that fails in between does only what others wait for. */
static kith_status run_stages(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  struct kith_nodes *nodes = it->nodes;
  struct reduced_values reduced = {0};
  it->need = requirements(it);
  kith_halo_finish_exchange(it->hydro->halo);
  KITH_TRY(it->near.only ? KITH_OK : prepare(it, &reduced));
  kith_status status = it->near.only ? place_near(it) : place(it, &reduced);
  if (status == KITH_OK) KITH_STAGE(status, it->profile, "neighbors", update_search(it));
  if (status == KITH_OK) status = build_connectivity(it);
  const kith_index before = kith_nodes_count(nodes);
  if (may_cull(it)) status = cull(it, status);
  if (status == KITH_OK && kith_nodes_count(nodes) < before)
    KITH_STAGE(status, it->profile, "patch",
               kith_connectivity_patch(it->connectivity, nodes, it->scratch.renumber, before));
  if (status == KITH_OK) status = ready(it, reason);
  it->fresh = true, it->positions = nodes->positions;
  return begin_closing(it, &reduced, status);
}

kith_status kith_lifecycle(struct kith_integrator *it, enum kith_rebuild_reason reason) {
  kith_status status;
  KITH_STAGE(status, it->profile, "lifecycle", run_stages(it, reason));
  return status;
}

/* Puts nodes where the lists were made, makes them, and puts nodes back. Nodes were in the box then, so none
 * is wrapped. */
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
  kith_status status = kith_lifecycle(it, KITH_BECAUSE_requested);
  if (status == KITH_OK) status = kith_lifecycle_close(it);
  it->holding = holding, it->resuming = false, it->fresh = false;
  kith_field_copy(nodes, nodes->position, position);
  kith_field_copy(nodes, nodes->support, support);
  nodes->positions += 1;
  if (status == KITH_OK) kith_cover_measure(&it->rebuilds->cover, nodes); /* drift is measured from here on */
  return status;
}
