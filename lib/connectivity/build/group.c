/* Groups of targets, and the candidates that they share: of internal nodes whole runs, if the search is in
 * order, else slots, sorted by node. */
#include "lib/connectivity/build/group.h"

#include <math.h>

struct kith_group kith_group_of(const struct kith_build *build, kith_index first, kith_index count) {
  const struct kith_search *search = build->targets->search;
  const double *restrict own = search->radius->f64, *c[NDIM];
  const kith_index *restrict node = search->node;
  const bool all = kith_build_all_targets(build);
  for (int a = 0; a < NDIM; ++a) c[a] = search->coordinate[a];
  struct kith_extent extent = {kith_box_empty(), 0};
  kith_index targets = 0;
  for (kith_index slot = first; slot < first + count; ++slot) {
    double x[NDIM];
    if (!all && !kith_build_is_target(build, node[slot])) continue;
    for (int a = 0; a < NDIM; ++a) x[a] = c[a][slot];
    kith_extent_include(&extent, x, own[node[slot]]);
    ++targets;
  }
  if (build->cutoff == KITH_CUTOFF_number) extent.radius = build->number;
  if (build->cutoff == KITH_CUTOFF_boxes)
    extent.radius = sqrt(NDIM) * (1 + KITH_SEARCH_SLACK) * (extent.radius + build->number);
  return (struct kith_group){{first, count}, targets, extent};
}

bool kith_group_join(struct kith_group *a, const struct kith_group *b) {
  const kith_index slots = b->run.first + b->run.count - a->run.first;
  if (slots > KITH_GROUP_SLOTS || a->targets + b->targets > KITH_GROUP_SIZE) return false;
  if (!kith_extent_join(&a->extent, &b->extent, 1.5)) return false;
  a->run.count = slots, a->targets += b->targets;
  return true;
}

bool kith_group_serves_idle(const struct kith_build *build, const struct kith_group *group) {
  return build->selected && !build->targets->ghosts &&
         build->targets->search->node[group->run.first] >= build->nodes->n_internal;
}

static bool is_source(const struct kith_build *build, kith_index node, bool idle) {
  if (build->column != NULL && build->column[node] < 0) return false;
  return !idle || (node < build->nodes->n_internal && !kith_node_active(build->nodes, node));
}

/* For a search in order: packs the internal nodes, which are at the beginning of the runs. *first_run: the
 * run where the ghosts begin. */
static kith_status pack_in_order(struct kith_worker *worker, const struct kith_search *search,
                                 const struct kith_group *group, int *first_run) {
  struct kith_packed *near = &worker->near;
  const double radius2 = group->extent.radius * group->extent.radius;
  size_t all = KITH_PACKED_ROOM;
  for (int r = 0; r < worker->runs.n; ++r) all += (size_t)worker->runs.run[r].count;
  KITH_TRY(kith_packed_reserve(near, (size_t)near->n + all));
  for (; *first_run < worker->runs.n; ++*first_run) {
    struct kith_run *run = &worker->runs.run[*first_run];
    const kith_index internal = KITH_MIN(run->count, search->n_internal - run->first);
    if (internal > 0)
      kith_packed_add(near, search, (struct kith_run){run->first, internal}, &group->extent.box, radius2);
    if (internal == run->count) continue;
    if (internal > 0) *run = (struct kith_run){search->n_internal, run->count - internal};
    break;
  }
  return KITH_OK;
}

/* Finds the slots of the runs from first_run on that are within range of the box, and makes keys of them,
 * which sort by node: key[0][n[0]] of internal nodes, key[1][n[1]] of ghosts. Each of the two nearly ascends
 * already. key[2] is for sorting them; before that it holds the slots. */
static kith_status collect(struct kith_worker *worker, const struct kith_build *build,
                           const struct kith_group *group, int first_run, uint64_t *key[3], size_t n[2]) {
  const struct kith_search *search = build->search;
  const double radius2 = group->extent.radius * group->extent.radius;
  size_t all = 0, within = 0;
  for (int r = first_run; r < worker->runs.n; ++r) all += (size_t)worker->runs.run[r].count;
  KITH_TRY(kith_reserve(&worker->key, &worker->key_capacity, 3 * all, sizeof *worker->key));
  for (int k = 0; k < 3; ++k) key[k] = worker->key + (size_t)k * all;
  kith_index *slot = (kith_index *)key[2];
  for (int r = first_run; r < worker->runs.n; ++r)
    within += kith_box_slots(search, worker->runs.run[r], &group->extent.box, radius2, slot + within);
  const bool idle = kith_group_serves_idle(build, group);
  if (build->column != NULL || idle) {
    const size_t all_within = within;
    within = 0;
    for (size_t k = 0; k < all_within; ++k) /* `within` is never ahead of k */
      slot[within] = slot[k], within += is_source(build, search->node[slot[k]], idle);
  }
  uint64_t *inner = key[0], *outer = key[1];
  for (size_t k = 0; k < within; ++k) {
    const kith_index node = search->node[slot[k]];
    *inner = *outer = (uint64_t)node << 32 | (uint64_t)slot[k];
    inner += node < build->nodes->n_internal, outer += node >= build->nodes->n_internal;
  }
  n[0] = (size_t)(inner - key[0]), n[1] = (size_t)(outer - key[1]);
  return KITH_OK;
}

/* Packs the slots of n sorted keys, from position `from` on, and fills in `self` for those that are
 * targets. */
static void pack(struct kith_packed *near, const struct kith_search *search, const uint64_t *key, int from,
                 int n, struct kith_run targets, int *self) {
  for (int p = 0; p < n; ++p) {
    const kith_index slot = (kith_index)(key[p] & 0xffffffffu);
    near->node[from + p] = (kith_index)(key[p] >> 32);
    for (int a = 0; a < NDIM; ++a) near->coordinate[a][from + p] = search->coordinate[a][slot];
    near->radius2[from + p] = search->radius2[slot];
    const kith_index m = slot - targets.first;
    if (m >= 0 && m < targets.count) self[m] = from + p;
  }
}

/* Makes the candidates from position `from` on images s of their nodes. The positions behind them, up to
 * whole words, will count as candidates that no test accepts: they get node 0. */
static void shift_packed(struct kith_packed *near, const struct kith_build *build, int s, int from) {
  for (int p = from; p < 64 * near->words; ++p) near->shift[p] = (uint16_t)s;
  for (int p = near->n; p < 64 * near->words; ++p) near->node[p] = 0;
  for (int a = 0; a < NDIM && kith_build_moves_source(build, s); ++a)
    for (int p = from; p < near->n; ++p) near->coordinate[a][p] += kith_build_shift(build, s, a);
}

/* Adds the sources that are candidates of the group, as images s. self[m]: the position of target m among the
 * candidates; it is not written if the target is not one of them, as with coordinates that are not a
 * number. */
static kith_status add_candidates(struct kith_worker *worker, const struct kith_build *build,
                                  const struct kith_group *group, int s, int *self) {
  static const enum kith_search_mode modes[] = {[KITH_CUTOFF_number] = KITH_GATHER,
                                                [KITH_CUTOFF_gather] = KITH_GATHER,
                                                [KITH_CUTOFF_scatter] = KITH_SCATTER,
                                                [KITH_CUTOFF_gather_scatter] = KITH_GATHER_SCATTER,
                                                [KITH_CUTOFF_boxes] = KITH_GATHER};
  const struct kith_search *search = build->search;
  const bool same = build->targets->search == search;
  const struct kith_run targets = {group->run.first,
                                   same && s == kith_build_zero(build) ? group->run.count : 0};
  struct kith_packed *near = &worker->near;
  const int from = near->n;
  uint64_t *key[3];
  size_t n[2];
  int first_run = 0;
  worker->runs.n = 0;
  KITH_TRY(search->ops->coarse(search, &group->extent.box, group->extent.radius, modes[build->cutoff],
                               &worker->runs));
  if (search->in_order && build->column == NULL && !kith_group_serves_idle(build, group)) {
    KITH_TRY(pack_in_order(worker, search, group, &first_run));
    const size_t end = (size_t)near->n;
    for (size_t p = kith_lower_bound(near->node, (size_t)from, end, targets.first);
         p < end && near->node[p] < targets.first + targets.count; ++p)
      self[near->node[p] - targets.first] = (int)p;
  }
  const int packed = near->n;
  KITH_TRY(collect(worker, build, group, first_run, key, n));
  KITH_TRY(kith_packed_reserve(near, (size_t)packed + n[0] + n[1]));
  /* Sorted keys may end in key[2], so each part is packed before the next one is sorted. */
  for (int part = 0; part < 2; ++part)
    pack(near, search, build->unsorted ? key[part] : kith_keys_sort(key[part], key[2], n[part]),
         packed + (part == 0 ? 0 : (int)n[0]), (int)n[part], targets, self);
  kith_packed_close(near, packed + (int)(n[0] + n[1]));
  if (modes[build->cutoff] == KITH_GATHER) /* radii of sources do not count */
    for (int p = from; p < near->n; ++p) near->radius2[p] = -1;
  if (build->shifts != NULL) shift_packed(near, build, s, from);
  return KITH_OK;
}

/* Moves the group by minus shift s, so that sources are as far from it as their images s are from the group.
 * Are any near? The box is widened by more than rounding. */
static bool sees_image(const struct kith_build *build, struct kith_extent *group, int s) {
  struct kith_box *box = &group->box;
  for (int a = 0; a < NDIM; ++a) {
    const double by = kith_build_shift(build, s, a),
                 slack = 1e-14 * (fabs(box->lower[a]) + fabs(box->upper[a]) + fabs(by));
    box->lower[a] -= by + slack, box->upper[a] -= by - slack;
  }
  return kith_box_near(box, &build->all.box,
                       KITH_MAX(group->radius, build->all.radius) * (1 + KITH_SEARCH_SLACK));
}

kith_status kith_group_candidates(struct kith_worker *worker, const struct kith_build *build,
                                  const struct kith_group *group, int *self) {
  for (kith_index m = 0; m < group->run.count; ++m) self[m] = -1;
  worker->near.n = 0;
  if (build->shifts == NULL) return add_candidates(worker, build, group, 0, self);
  for (int s = 0; s < build->shifts->n; ++s) {
    struct kith_group seen = *group;
    if (s != build->shifts->zero && !sees_image(build, &seen.extent, s)) continue;
    KITH_TRY(add_candidates(worker, build, &seen, s, self));
    worker->near.n = 64 * worker->near.words;
  }
  return KITH_OK;
}
