/* list.c - a neighbor list from its specification, kept as long as it holds. */
#include "lib/connectivity/list.h"

#include <math.h>
#include <string.h>

/* --- specifications --- */

struct kith_list_spec kith_list_spec_among(const struct kith_nodes *nodes, struct kith_search *search,
                                           struct kith_excluder *self, struct kith_excluder *others) {
  *self = (struct kith_excluder){.ops = &kith_excluder_self, .next = others};
  return (struct kith_list_spec){.targets = {.nodes = nodes, .search = search},
                                 .sources = {.nodes = nodes, .search = search},
                                 .cutoff = KITH_CUTOFF_gather_scatter,
                                 .radius = nodes->search_radius->spec.name,
                                 .excluders = self,
                                 .storage = kith_storage_csr.name,
                                 .rebuild = kith_rebuild_always.name};
}

static kith_status check_selection(const struct kith_selection *selection, const char *who) {
  if (selection->nodes == NULL) KITH_FAIL(BAD_INPUT, "neighbor list: no %s are given", who);
  if (selection->search == NULL) KITH_FAIL(BAD_INPUT, "neighbor list: the %s have no search", who);
  if (selection->search->nodes != selection->nodes)
    KITH_FAIL(BAD_INPUT, "neighbor list: the search of the %s belongs to other nodes", who);
  return KITH_OK;
}

static kith_status check_radius(const struct kith_list_spec *spec, const struct kith_selection *selection,
                                const char *who) {
  const char *known = selection->search->radius->spec.name;
  if (strcmp(known, spec->radius) == 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "neighbor list: the cutoff is field '%s', but the search of the %s knows '%s'",
            spec->radius, who, known);
}

static kith_status check_cutoff(const struct kith_list_spec *spec) {
#define X(name) " " #name
  if (spec->cutoff == KITH_CUTOFF_missing)
    KITH_FAIL(BAD_INPUT, "neighbor list: no cutoff is given; there are:" KITH_CUTOFF_LIST(X));
#undef X
  if (spec->cutoff == KITH_CUTOFF_number) {
    if (spec->radius != NULL)
      KITH_FAIL(BAD_INPUT, "neighbor list: the cutoff is a number and field '%s'", spec->radius);
    if (!(spec->number > 0 && spec->number < INFINITY))
      KITH_FAIL(BAD_INPUT, "neighbor list: the cutoff %g is not above 0", spec->number);
    return KITH_OK;
  }
  if (spec->radius == NULL) KITH_FAIL(BAD_INPUT, "neighbor list: the cutoff needs a field of radii");
  if (spec->number != 0)
    KITH_FAIL(BAD_INPUT, "neighbor list: the cutoff is field '%s' and the number %g", spec->radius,
              spec->number);
  if (spec->cutoff != KITH_CUTOFF_scatter) KITH_TRY(check_radius(spec, &spec->targets, "targets"));
  return spec->cutoff != KITH_CUTOFF_gather ? check_radius(spec, &spec->sources, "sources") : KITH_OK;
}

/* BAD_INPUT, by name, for what is missing or contradictory in what builders of rows need. */
static kith_status check(const struct kith_list_spec *spec) {
  KITH_TRY(check_selection(&spec->targets, "targets"));
  KITH_TRY(check_selection(&spec->sources, "sources"));
  if (spec->targets.nodes == spec->sources.nodes && spec->targets.search != spec->sources.search)
    KITH_FAIL(BAD_INPUT, "neighbor list: targets and sources are of the same nodes, but of two searches");
  for (int a = 0; a < NDIM; ++a)
    if (spec->targets.nodes->stretch[a] != spec->sources.nodes->stretch[a])
      KITH_FAIL(BAD_INPUT, "neighbor list: supports of targets and sources differ in shape");
  return check_cutoff(spec);
}

kith_status kith_list_spec_prepare(const struct kith_list_spec *spec, struct kith_builder *scratch,
                                   struct kith_build *build) {
  const struct kith_excluder *first = spec->excluders;
  KITH_TRY(check(spec));
  KITH_TRY(kith_excluder_setup(spec->excluders, &spec->targets, &spec->sources));
  KITH_TRY(kith_builder_reserve(scratch));
  *build = (struct kith_build){
      .targets = &spec->targets,
      .sources = &spec->sources,
      .nodes = spec->sources.nodes,
      .search = spec->sources.search,
      .excluders = first != NULL && first->ops->self ? first->next : spec->excluders,
      .scratch = scratch,
      .cutoff = spec->cutoff,
      .number =
          spec->cutoff == KITH_CUTOFF_boxes ? kith_search_largest_radius(spec->sources.search) : spec->number,
      .self = first == NULL || !first->ops->self, /* elsewhere in the chain it is asked as the others are */
      .unsorted = spec->unsorted};
  if (spec->targets.nodes != spec->sources.nodes || build->nodes->shifts.n == 1) return KITH_OK;
  build->shifts = &build->nodes->shifts;
  build->all = (struct kith_extent){kith_box_around(build->search->position->f64, build->search->n),
                                    kith_search_largest_radius(build->search)};
  return KITH_OK;
}

/* --- a list --- */

/* Can lists be kept by this policy? Policies compare supports with search radii (policies/cover.h). */
static kith_status check_rebuild(const struct kith_list_spec *spec) {
  const char *judged = spec->sources.nodes->search_radius->spec.name;
  if (spec->targets.nodes != spec->sources.nodes)
    KITH_FAIL(BAD_INPUT, "neighbor list: rebuild policy '%s' follows one set of nodes; between two: always",
              spec->rebuild);
  if (spec->radius == NULL || strcmp(spec->radius, judged) != 0)
    KITH_FAIL(BAD_INPUT,
              "neighbor list: rebuild policy '%s' follows supports within field '%s'; with another "
              "cutoff: always",
              spec->rebuild, judged);
  return KITH_OK;
}

/* Can the storage keep such rows? Half of a row is enough only if the other half is in other rows. */
static kith_status check_storage(const struct kith_list_spec *spec, const struct kith_storage_ops *storage) {
  const struct kith_selection *t = &spec->targets, *s = &spec->sources;
  if (storage->ascending && spec->unsorted)
    KITH_FAIL(BAD_INPUT, "neighbor list: storage %s needs sorted rows", storage->name);
  if (!storage->upper) return KITH_OK;
  if (t->nodes != s->nodes || t->lists != s->lists || t->chosen != s->chosen || t->context != s->context)
    KITH_FAIL(BAD_INPUT, "neighbor list: storage %s needs targets that are the sources", storage->name);
  if (spec->cutoff == KITH_CUTOFF_gather || spec->cutoff == KITH_CUTOFF_scatter)
    KITH_FAIL(BAD_INPUT, "neighbor list: storage %s needs a cutoff that is the same for both of a pair",
              storage->name);
  for (const struct kith_excluder *e = spec->excluders; e != NULL; e = e->next)
    if (e->ops->halves)
      KITH_FAIL(BAD_INPUT, "neighbor list: storage %s and excluder %s would leave a quarter of the rows",
                storage->name, e->ops->name);
  return KITH_OK;
}

static kith_status create(struct kith_list *list, const struct kith_list_spec *spec) {
  list->spec = *spec;
  KITH_TRY(check(spec));
  if (spec->storage == NULL) KITH_FAIL(BAD_INPUT, "neighbor list: no storage is given");
  if (spec->rebuild == NULL) KITH_FAIL(BAD_INPUT, "neighbor list: no rebuild policy is given");
  KITH_TRY(kith_stored_create(&list->stored, spec->storage));
  KITH_TRY(check_storage(spec, list->stored.ops));
  KITH_TRY(kith_rebuilds_create(&list->rebuilds, spec->rebuild, spec->period));
  return kith_rebuilds_lasting(&list->rebuilds) ? check_rebuild(spec) : KITH_OK;
}

kith_status kith_list_create(struct kith_list **out, const struct kith_list_spec *spec) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  const kith_status status = create(*out, spec);
  if (status != KITH_OK) kith_list_destroy(out);
  return status;
}

void kith_list_destroy(struct kith_list **list) {
  struct kith_list *l = *list;
  if (l == NULL) return;
  KITH_FREE(&l->target, &l->row, &l->column);
  kith_stored_clear(&l->stored);
  kith_rebuilds_clear(&l->rebuilds);
  kith_builder_clear(&l->scratch);
  kith_free(list);
}

/* Numbers the selected ones of the first `n` nodes: the ordinals of all nodes. */
static kith_status number(const struct kith_selection *selection, kith_index n, kith_index **ordinal,
                          size_t *capacity, kith_index *count) {
  const kith_index all = kith_nodes_count(selection->nodes);
  KITH_TRY(kith_reserve(ordinal, capacity, (size_t)all, sizeof **ordinal));
  *count = 0;
  for (kith_index i = 0; i < all; ++i) (*ordinal)[i] = i < n && kith_selects(selection, i) ? (*count)++ : -1;
  return KITH_OK;
}

static kith_status number_both(struct kith_list *l) {
  const struct kith_selection *t = &l->spec.targets, *s = &l->spec.sources;
  const kith_index n = t->ghosts ? kith_nodes_count(t->nodes) : t->nodes->n_internal;
  KITH_TRY(number(t, n, &l->row, &l->rows_capacity, &l->n_targets));
  KITH_TRY(kith_reserve(&l->target, &l->targets_capacity, (size_t)l->n_targets, sizeof *l->target));
  for (kith_index i = 0; i < n; ++i)
    if (l->row[i] >= 0) l->target[l->row[i]] = i;
  return number(s, kith_nodes_count(s->nodes), &l->column, &l->columns_capacity, &l->n_sources);
}

static kith_status make_rows(struct kith_list *l) {
  struct kith_build build;
  size_t candidates;
  struct kith_search *const search[2] = {l->spec.targets.search, l->spec.sources.search};
  for (int k = 0; k < 2; ++k)
    if (kith_search_fresh(search[k]) != KITH_OK) KITH_TRY(kith_search_update(search[k]));
  KITH_TRY(kith_list_spec_prepare(&l->spec, &l->scratch, &build));
  build.row = l->row, build.rows = l->n_targets, build.column = l->column;
  KITH_TRY(kith_reserve(&l->stored.rows.node, &l->stored.rows.entries_capacity,
                        (size_t)l->n_targets * (size_t)l->spec.expected, sizeof(kith_index)));
  KITH_TRY(kith_rows_build(&l->stored.rows, &build, &candidates));
  if (build.shifts != NULL && !l->stored.ops->shifts)
    KITH_FAIL(UNSUPPORTED, "neighbor list: storage %s holds no image shifts: csr and half do",
              l->stored.ops->name);
  return kith_stored_keep(&l->stored, l->target);
}

static kith_status build_list(struct kith_list *l) {
  const struct kith_nodes *nodes = l->spec.sources.nodes;
  l->built = false;
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, number_both(l)));
  uint64_t count[] = {(uint64_t)l->n_targets, (uint64_t)l->n_sources};
  kith_ranks_sum_counts(nodes->ranks, count, 2);
  if (count[0] > 0 && count[1] == 0 && l->builds == 0) /* later they may have left */
    return kith_ranks_allreduce_status(
        nodes->ranks, kith_fail(KITH_BAD_INPUT, "neighbor list: no node is a source of %llu targets",
                                (unsigned long long)count[0]));
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, make_rows(l)));
  if (kith_rebuilds_lasting(&l->rebuilds)) KITH_TRY(kith_rebuilds_snapshot(&l->rebuilds, nodes));
  l->ghosts[0] = l->spec.targets.nodes->ghosts, l->ghosts[1] = nodes->ghosts;
  l->built = true, l->invalidated = false;
  l->builds += 1;
  return KITH_OK;
}

/* Were nodes or ghosts added or removed since it was made? */
static bool is_older(const struct kith_list *l) {
  return l->ghosts[0] != l->spec.targets.nodes->ghosts || l->ghosts[1] != l->spec.sources.nodes->ghosts;
}

kith_status kith_list_update(struct kith_list *l, enum kith_rebuild_reason *why) {
  const struct kith_nodes *nodes = l->spec.sources.nodes;
  *why = KITH_BECAUSE_none;
  if (!l->built)
    *why = KITH_BECAUSE_first_build;
  else if (l->invalidated)
    *why = KITH_BECAUSE_requested;
  else if (kith_ranks_any(nodes->ranks, is_older(l)))
    *why = KITH_BECAUSE_entity_change;
  else if (!kith_rebuilds_lasting(&l->rebuilds)) /* there is no snapshot that others could look at */
    *why = KITH_BECAUSE_always;
  else
    KITH_TRY(kith_rebuilds_check(&l->rebuilds, nodes, KITH_OK, why));
  return *why != KITH_BECAUSE_none ? build_list(l) : KITH_OK;
}

void kith_list_invalidate(struct kith_list *list) {
  list->invalidated = true;
}

kith_status kith_list_current(const struct kith_list *l) {
  if (!l->built) KITH_FAIL(STALE, "the neighbor list was not built yet");
  if (l->invalidated) KITH_FAIL(STALE, "the neighbor list is invalidated");
  if (is_older(l)) KITH_FAIL(STALE, "the neighbor list was made from other nodes or ghosts");
  return KITH_OK;
}

/* --- iteration --- */

static struct kith_tally empty_tally(const struct kith_reducer *reducer, int n) {
  struct kith_tally tally = {.reducer = reducer};
  for (int k = 0; k < n; ++k) tally.extreme[k] = reducer[k].kind == KITH_LEAST ? INFINITY : -INFINITY;
  return tally;
}

static void join_tally(struct kith_tally *to, const struct kith_tally *from, int n) {
  for (int k = 0; k < n; ++k) {
    kith_sum_join(&to->sum[k], &from->sum[k]);
    to->extreme[k] = to->reducer[k].kind == KITH_LEAST ? KITH_MIN(to->extreme[k], from->extreme[k])
                                                       : KITH_MAX(to->extreme[k], from->extreme[k]);
  }
}

static void finish_tally(struct kith_ranks *ranks, struct kith_tally *all, struct kith_reducer *reducer,
                         int n) {
  kith_sum_ranks(ranks, all->sum, n);
  for (int k = 0; k < n; ++k) {
    reducer[k].value = reducer[k].kind <= KITH_SUM ? kith_sum_value(&all->sum[k]) : all->extreme[k];
    if (reducer[k].kind == KITH_LEAST) kith_ranks_min(ranks, &reducer[k].value, 1);
    if (reducer[k].kind == KITH_MOST) kith_ranks_max(ranks, &reducer[k].value, 1);
  }
}

/* Adds up what is found over the targets of this rank. */
static kith_status visit_targets(const struct kith_list *l, kith_list_visit visit, void *context,
                                 struct kith_tally *all, int n) {
  bool failed = false;
#pragma omp parallel reduction(|| : failed) if (l->n_targets > KITH_FEW)
  {
    struct kith_tally mine = empty_tally(all->reducer, n);
    kith_index *space = NULL;
    failed = kith_resize(&space, 0, l->stored.longest + 1, sizeof *space) != KITH_OK;
#pragma omp for schedule(dynamic, 64)
    for (kith_index t = 0; t < l->n_targets; ++t) {
      struct kith_neighbors neighbors = {.target = t, .node = l->target[t]};
      if (failed) continue;
      neighbors.source = l->stored.ops->row(&l->stored, t, space, &neighbors.n);
      if (l->stored.rows.shift != NULL) neighbors.shift = l->stored.rows.shift + l->stored.rows.first[t];
      visit(context, &neighbors, &mine);
    }
#pragma omp critical
    join_tally(all, &mine, n);
    kith_free(&space);
  }
  if (failed) KITH_FAIL(NO_MEMORY, "no memory for a row of %zu", l->stored.longest);
  return KITH_OK;
}

kith_status kith_list_visit_all(const struct kith_list *l, kith_list_visit visit, void *context,
                                struct kith_reducer *reducer, int n) {
  struct kith_ranks *ranks = l->spec.sources.nodes->ranks;
  if (n > KITH_MAX_REDUCERS) KITH_FAIL(BAD_INPUT, "%d reducers: at most %d", n, KITH_MAX_REDUCERS);
  struct kith_tally all = empty_tally(reducer, n);
  kith_status status = kith_list_current(l);
  if (status == KITH_OK) status = visit_targets(l, visit, context, &all, n);
  KITH_TRY(n > 0 ? kith_ranks_allreduce_status(ranks, status) : status);
  if (n > 0) finish_tally(ranks, &all, reducer, n);
  return KITH_OK;
}
