/* search.c - what all neighbor searches share: runs, slots, generations, queries at a position. */
#include "lib/neighbor/search.h"

#include "lib/core/family.h"
#include "lib/core/sfc_key.h"

#include <stdlib.h>
#include <string.h>

void kith_runs_clear(struct kith_runs *runs) {
  kith_free(&runs->run);
  *runs = (struct kith_runs){0};
}

bool kith_extent_join(struct kith_extent *a, const struct kith_extent *b, double most) {
  struct kith_extent both = {a->box, KITH_MAX(a->radius, b->radius)};
  kith_box_join(&both.box, &b->box);
  const double larger = KITH_MAX(kith_box_volume(&a->box, a->radius), kith_box_volume(&b->box, b->radius));
  if (!(kith_box_volume(&both.box, both.radius) <= most * larger)) return false;
  *a = both;
  return true;
}

/* The family. */

#define X(name) &kith_search_##name,
KITH_FAMILY(kith_search, KITH_SEARCH_LIST(X))
#undef X

/* Creation. */

kith_status kith_search_create(struct kith_search **out, const struct kith_search_ops *ops,
                               const struct kith_nodes *nodes) {
  *out = NULL;
  if (ops == NULL) KITH_FAIL(BAD_INPUT, "there is no such neighbor search");
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  struct kith_search *search = *out;
  search->ops = ops;
  search->nodes = nodes;
  search->radius = nodes->search_radius;
  search->ghosts = UINT64_MAX; /* stale */
  const kith_status status =
      ops->state_size > 0 ? kith_resize(&search->self, 0, 1, ops->state_size) : KITH_OK;
  if (status != KITH_OK) kith_free(out);
  return status;
}

void kith_search_destroy(struct kith_search **search) {
  struct kith_search *s = *search;
  if (!s) return;
  if (s->ops->clear != NULL) s->ops->clear(s);
  for (int a = 0; a < NDIM; ++a) kith_free(&s->coordinate[a]);
  KITH_FREE(&s->self, &s->node, &s->radius2, &s->group, &s->near);
  kith_free(search);
}

/* Updates: stale until the member has succeeded. */

/* Room for n slots. */
static kith_status reserve_slots(struct kith_search *search, kith_index n) {
  if (n <= search->capacity) return KITH_OK;
  const size_t keep = (size_t)search->capacity, wanted = KITH_MIN((size_t)n + (size_t)n / 8, INT32_MAX);
  KITH_TRY(kith_resize(&search->node, keep, wanted, sizeof *search->node));
  for (int a = 0; a < NDIM; ++a) KITH_TRY(kith_resize(&search->coordinate[a], keep, wanted, sizeof(double)));
  KITH_TRY(kith_resize(&search->radius2, keep, wanted, sizeof(double)));
  KITH_TRY(kith_resize(&search->near, keep, wanted + 1, 1));
  search->capacity = (kith_index)wanted;
  return KITH_OK;
}

/* Where nodes are in the metric of their supports. */
static void place(struct kith_search *search) {
  const struct kith_nodes *nodes = search->nodes;
  const double *restrict x = nodes->position->f64;
  search->position = nodes->stretched != NULL ? nodes->stretched : nodes->position;
  if (nodes->stretched == NULL) return;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < search->n; ++i)
    for (size_t a = 0; a < NDIM; ++a)
      nodes->stretched->f64[(size_t)i * NDIM + a] = x[(size_t)i * NDIM + a] / nodes->stretch[a];
}

static void stamp(struct kith_search *search) {
  search->positions = search->nodes->positions;
  search->order = search->nodes->order;
  search->ghosts = search->nodes->ghosts;
}

kith_status kith_search_update(struct kith_search *search) {
  search->ghosts = UINT64_MAX;
  search->n = search->n_internal = search->n_groups = 0;
  search->in_order = false;
  memset(search->count, 0, sizeof search->count);
  KITH_TRY(reserve_slots(search, kith_nodes_count(search->nodes)));
  search->n = kith_nodes_count(search->nodes);
  search->n_internal = search->nodes->n_internal;
  place(search);
  KITH_TRY(search->ops->update(search));
  stamp(search);
  return KITH_OK;
}

kith_status kith_search_update_selected(struct kith_search *search, const kith_index *nodes,
                                        kith_index count) {
  const struct kith_nodes *present = search->nodes;
  if (search->ghosts == UINT64_MAX || search->order != present->order ||
      (present->n_ghost > 0 && search->ghosts != present->ghosts))
    KITH_FAIL(STALE, "nodes were added, removed or reordered since the last update of the %s search",
              search->ops->name);
  search->ghosts = UINT64_MAX;
  memset(search->count, 0, sizeof search->count);
  search->n = kith_nodes_count(present);
  while (search->n_groups > 0 && search->group[search->n_groups - 1].first >= search->n) --search->n_groups;
  place(search);
  KITH_TRY(search->ops->update_selected(search, nodes, count));
  stamp(search);
  return KITH_OK;
}

kith_status kith_search_fresh(const struct kith_search *search) {
  if (search->ghosts != search->nodes->ghosts)
    KITH_FAIL(STALE, "nodes or ghosts were added or removed since the last update of the %s search",
              search->ops->name);
  if (search->positions != search->nodes->positions)
    KITH_FAIL(STALE, "nodes moved since the last update of the %s search", search->ops->name);
  return KITH_OK;
}

/* Queries. */

/* The extent of the active internal nodes of a group; radius < 0: there are none. */
static struct kith_extent active_of(const struct kith_search *search, struct kith_run group) {
  const struct kith_nodes *nodes = search->nodes;
  struct kith_extent active = {kith_box_empty(), -1};
  for (kith_index slot = group.first; slot < group.first + group.count; ++slot) {
    const kith_index i = search->node[slot];
    if (i < nodes->n_internal && kith_node_active(nodes, i))
      kith_extent_include(&active, search->position->f64 + (size_t)i * NDIM, search->radius->f64[i]);
  }
  return active;
}

/* Marks the slots that these active nodes may interact with. */
static kith_status mark_near(struct kith_search *search, struct kith_extent active, double slack,
                             struct kith_runs *runs) {
  for (int a = 0; a < NDIM; ++a) active.box.lower[a] -= slack, active.box.upper[a] += slack;
  runs->n = 0;
  KITH_TRY(search->ops->coarse(search, &active.box, active.radius, KITH_GATHER_SCATTER, runs));
  for (int r = 0; r < runs->n; ++r)
    for (kith_index slot = runs->run[r].first; slot < runs->run[r].first + runs->run[r].count; ++slot)
#pragma omp atomic write
      search->near[slot] = 1;
  return KITH_OK;
}

int kith_search_next_awake(const struct kith_search *search, int group, int end) {
  enum { GROUPS = 16 }; /* at a time */
  if (!search->in_order) return group;
  for (int next; group < end; group = next) {
    next = KITH_MIN(group + GROUPS, end);
    const kith_index end_slot = search->group[next - 1].first + search->group[next - 1].count;
    if (end_slot > search->n_internal ||
        !kith_all_zero(search->nodes->activity->u8, search->group[group].first, end_slot))
      break;
  }
  return group;
}

/* Marks the slots near active nodes of groups first .. end - 1. Groups that are close share one query. */
static kith_status mark_near_groups(struct kith_search *search, int first, int end, double slack,
                                    struct kith_runs *runs) {
  struct kith_extent open = {.radius = -1};
  for (int g = kith_search_next_awake(search, first, end); g < end;
       g = kith_search_next_awake(search, g + 1, end)) {
    const struct kith_extent next = active_of(search, search->group[g]);
    if (next.radius < 0 || (open.radius >= 0 && kith_extent_join(&open, &next, 1.3))) continue;
    if (open.radius >= 0) KITH_TRY(mark_near(search, open, slack, runs));
    open = next;
  }
  return open.radius >= 0 ? mark_near(search, open, slack, runs) : KITH_OK;
}

kith_status kith_search_near(struct kith_search *search, double slack, kith_index **found, size_t *capacity,
                             kith_index *count) {
  enum { GROUPS = 64 }; /* that one thread looks at together */
  int status = KITH_OK;
  if (search->n > 0) memset(search->near, 0, (size_t)search->n);
#pragma omp parallel reduction(max : status) if (search->n > KITH_FEW)
  {
    struct kith_runs runs = {0};
    kith_status mine = KITH_OK;
#pragma omp for schedule(dynamic, 1)
    for (int g = 0; g < search->n_groups; g += GROUPS)
      if (mine == KITH_OK)
        mine = mark_near_groups(search, g, KITH_MIN(g + GROUPS, search->n_groups), slack, &runs);
    kith_runs_clear(&runs);
    status = (int)mine;
  }
  if (status != KITH_OK) /* the text is that of another thread */
    return kith_fail((kith_status)status, "no memory to find the nodes near active ones");
  KITH_TRY(kith_grow(found, capacity, 0, (size_t)search->n_internal + 1, sizeof **found));
  *count = 0;
  for (kith_index from = 0; from < search->n; from += KITH_STRETCH) {
    const kith_index stop = KITH_MIN(from + KITH_STRETCH, search->n);
    if (kith_all_zero(search->near, from, stop)) continue;
    for (kith_index slot = from; slot < stop; ++slot) {
      (*found)[*count] = search->node[slot]; /* written in any case, kept if it counts */
      *count += search->near[slot] && search->node[slot] < search->n_internal;
    }
  }
  return KITH_OK;
}

static bool within(const struct kith_search *search, kith_index slot, const double *x, double radius2,
                   enum kith_search_mode mode) {
  double y[NDIM];
  for (int a = 0; a < NDIM; ++a) y[a] = search->coordinate[a][slot];
  const double d2 = kith_distance2(x, y);
  return (mode != KITH_SCATTER && d2 <= radius2) || (mode != KITH_GATHER && d2 <= search->radius2[slot]);
}

static int compare_indices(const void *a, const void *b) {
  const kith_index p = *(const kith_index *)a, q = *(const kith_index *)b;
  return (p > q) - (p < q);
}

kith_status kith_search_at(const struct kith_search *search, const double *x, double radius,
                           enum kith_search_mode mode, kith_index **found, size_t *capacity,
                           kith_index *count) {
  KITH_TRY(kith_search_fresh(search));
  if (!(radius >= 0)) KITH_FAIL(BAD_INPUT, "a search radius of %g", radius);
  struct kith_box box;
  double y[NDIM];
  for (int a = 0; a < NDIM; ++a) box.lower[a] = box.upper[a] = y[a] = x[a] / search->nodes->stretch[a];
  struct kith_runs runs = {0};
  size_t n = 0;
  kith_status status = search->ops->coarse(search, &box, radius, mode, &runs);
  for (int r = 0; status == KITH_OK && r < runs.n; ++r) {
    const kith_index first = runs.run[r].first, end = first + runs.run[r].count;
    status = kith_grow(found, capacity, n, n + (size_t)runs.run[r].count, sizeof **found);
    for (kith_index slot = first; status == KITH_OK && slot < end; ++slot)
      if (within(search, slot, y, radius * radius, mode)) (*found)[n++] = search->node[slot];
  }
  if (n > 1) qsort(*found, n, sizeof **found, compare_indices);
  *count = (kith_index)n;
  kith_runs_clear(&runs);
  return status;
}

kith_status kith_search_sweep(const struct kith_search *search, const struct kith_sweep *sweep,
                              void *context) {
  KITH_TRY(kith_search_fresh(search));
  if (search->ops->sweep == NULL)
    KITH_FAIL(UNSUPPORTED, "the %s search has no cells to sweep over", search->ops->name);
  return search->ops->sweep(search, sweep, context);
}

size_t kith_search_bytes(const struct kith_search *search) {
  const size_t slot = sizeof *search->node + (NDIM + 1) * sizeof(double) + sizeof *search->near;
  return sizeof *search + search->ops->state_size + (size_t)search->capacity * slot +
         search->groups_capacity * sizeof *search->group +
         (search->ops->bytes != NULL ? search->ops->bytes(search) : 0);
}

struct kith_box kith_box_around(const double *x, kith_index n) {
  struct kith_box box = kith_box_empty();
  double *least = box.lower, *most = box.upper;
#pragma omp parallel for schedule(static) reduction(min             \
                                                    : least[:NDIM]) \
    reduction(max                                                   \
              : most[:NDIM]) if (n > KITH_FEW_COPIES)
  for (kith_index i = 0; i < n; ++i)
    for (int a = 0; a < NDIM; ++a) {
      const double v = x[(size_t)i * NDIM + a];
      least[a] = KITH_MIN(least[a], v), most[a] = KITH_MAX(most[a], v);
    }
  return box;
}

double kith_search_largest_radius(const struct kith_search *search) {
  const double *radius = search->radius->f64;
  double largest = 0;
#pragma omp parallel for schedule(static) reduction(max : largest) if (search->n > KITH_FEW_COPIES)
  for (kith_index i = 0; i < search->n; ++i) largest = KITH_MAX(largest, radius[i]);
  return largest;
}

void kith_search_cube(const double *x, kith_index n, double *lower, double *upper) {
  const struct kith_box box = kith_box_around(x, n);
  double extent = 0;
  int exponent = 0;
  for (int a = 0; a < NDIM; ++a) extent = KITH_MAX(extent, box.upper[a] - box.lower[a]);
  if (extent > 0 && extent < INFINITY) frexp(extent, &exponent);
  const double unit = ldexp(1, exponent); /* > extent */
  for (int a = 0; a < NDIM; ++a) {
    lower[a] = n > 0 ? floor(box.lower[a] / unit) * unit : 0;
    upper[a] = lower[a] + 2 * unit;
  }
}

kith_status kith_search_sort_nodes(struct kith_nodes *nodes, bool *sorted) {
  uint64_t *key = NULL;
  double lower[NDIM], upper[NDIM];
  KITH_TRY(kith_resize(&key, 0, (size_t)nodes->n_internal, sizeof *key));
  kith_search_cube(nodes->position->f64, nodes->n_internal, lower, upper);
  kith_sfc_keys(nodes->position->f64, nodes->n_internal, lower, upper, key);
  const kith_status status = kith_nodes_sort(nodes, key, sorted);
  kith_free(&key);
  return status;
}

/* For members. */

void kith_search_pack(struct kith_search *search, kith_index first, kith_index count) {
#pragma omp parallel for schedule(static) if (count > KITH_FEW_COPIES)
  for (kith_index slot = first; slot < first + count; ++slot) kith_search_pack_slot(search, slot);
}

kith_status kith_search_group(struct kith_search *search, kith_index first, kith_index count) {
  const size_t n = (size_t)search->n_groups;
  KITH_TRY(kith_grow(&search->group, &search->groups_capacity, n, n + 1, sizeof *search->group));
  search->group[search->n_groups++] = (struct kith_run){first, count};
  return KITH_OK;
}
