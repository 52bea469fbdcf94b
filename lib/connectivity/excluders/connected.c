/* Excluders of what belongs together: nodes with equal tags, of certain materials, or joined by a bond. */
#include <stdlib.h>
#include <string.h>
#include "lib/connectivity/excluders/excluder.h"

/* --- connected: tags --- */

struct connected {
  char field[32];
};
static const struct kith_param connected_params[] = {
    {"field", KITH_PARAM_NAME, NULL, "", "integers; 0 and below: no tag", KITH_INTO(struct connected, field)},
    {0}};

static int64_t tag_of(const struct kith_field *field, kith_index i) {
  return field->spec.type == KITH_I64 ? field->i64[i] : field->u8[i];
}

/* self: the fields of targets and sources. */
static kith_status find_tags(struct kith_excluder *excluder, const struct kith_selection *targets,
                             const struct kith_selection *sources) {
  const struct kith_selection *of[2] = {targets, sources};
  const char *name = ((const struct connected *)excluder->settings)->field;
  if (excluder->self == NULL) KITH_TRY(kith_resize(&excluder->self, 0, 2, sizeof(struct kith_field *)));
  const struct kith_field **tag = excluder->self;
  for (int k = 0; k < 2; ++k) {
    tag[k] = kith_nodes_field_named(of[k]->nodes, name);
    if (tag[k] == NULL) KITH_FAIL(BAD_INPUT, "excluder connected: nodes have no field '%s'", name);
    if (tag[k]->spec.type == KITH_F64)
      KITH_FAIL(BAD_INPUT, "excluder connected: field '%s' is no tag: tags are integers", name);
  }
  return KITH_OK;
}

static bool same_tag(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const struct kith_field *const *tag = excluder->self;
  const int64_t mine = tag_of(tag[0], c->i);
  return mine > 0 && mine == tag_of(tag[1], c->j);
}

static void free_self(struct kith_excluder *excluder) {
  kith_free(&excluder->self);
}

const struct kith_excluder_ops kith_excluder_connected = {
    .name = "connected",
    .doc = "pairs of nodes with equal tags: in one rigid body, one chain, or of barriers (field=barrier)",
    KITH_SETTINGS(connected_params, connected),
    .phase = KITH_NARROW, /* a distance costs less than a call */
    .setup = find_tags,
    .reject = same_tag,
    .clear = free_self};

/* --- materials --- */

struct materials {
  char of[32], and[32];
};
static const struct kith_param materials_params[] = {
    {"of", KITH_PARAM_NAME, NULL, "", "a material", KITH_INTO(struct materials, of)},
    {"and", KITH_PARAM_NAME, "", "", "another; none: the same", KITH_INTO(struct materials, and)},
    {0}};

/* The list of a material among the targets and among the sources; -1: they have none of it. */
struct lists {
  int of_targets, of_sources;
};

static int list_named(const struct kith_nodes *nodes, const char *name) {
  int l = nodes->n_lists - 1;
  while (l >= 0 && strcmp(nodes->lists[l].name, name) != 0) --l;
  return l;
}

/* self: the lists of the two. */
static kith_status find_lists(struct kith_excluder *excluder, const struct kith_selection *targets,
                              const struct kith_selection *sources) {
  const struct materials *m = excluder->settings;
  const char *const name[] = {m->of, m->and[0] != '\0' ? m->and : m->of};
  if (excluder->self == NULL) KITH_TRY(kith_resize(&excluder->self, 0, 2, sizeof(struct lists)));
  struct lists *list = excluder->self;
  for (int k = 0; k < 2; ++k) {
    list[k] = (struct lists){list_named(targets->nodes, name[k]), list_named(sources->nodes, name[k])};
    if (list[k].of_targets < 0 && list[k].of_sources < 0)
      KITH_FAIL(BAD_INPUT, "excluder materials: there is no material '%s'", name[k]);
  }
  return KITH_OK;
}

static bool of_materials(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const struct lists *list = excluder->self;
  const int i = c->targets->nodes->list->u8[c->i], j = c->sources->nodes->list->u8[c->j];
  return (i == list[0].of_targets && j == list[1].of_sources) ||
         (i == list[1].of_targets && j == list[0].of_sources);
}

const struct kith_excluder_ops kith_excluder_materials = {
    .name = "materials",
    .doc = "pairs of nodes of two materials, which then pass through each other; or of one, as a rigid body",
    KITH_SETTINGS(materials_params, materials),
    .phase = KITH_BROAD,
    .setup = find_lists,
    .reject = of_materials,
    .clear = free_self};

/* --- bonds --- */

struct sorted_bonds {
  size_t n, capacity;
  int64_t (*id)[2]; /* the lower one first, ascending */
};

static int compare(const void *a, const void *b) {
  const int64_t *p = a, *q = b;
  return p[0] != q[0] ? (p[0] > q[0]) - (p[0] < q[0]) : (p[1] > q[1]) - (p[1] < q[1]);
}

static kith_status sort_bonds(struct kith_excluder *excluder, const struct kith_selection *targets,
                              const struct kith_selection *sources) {
  const struct kith_bonds *bonds = excluder->context;
  (void)targets, (void)sources;
  if (bonds == NULL) KITH_FAIL(BAD_INPUT, "excluder bonds: a program gives them, a scene cannot");
  if (excluder->self == NULL) KITH_TRY(kith_resize(&excluder->self, 0, 1, sizeof(struct sorted_bonds)));
  struct sorted_bonds *sorted = excluder->self;
  KITH_TRY(kith_reserve(&sorted->id, &sorted->capacity, bonds->n, sizeof *sorted->id));
  sorted->n = bonds->n;
  for (size_t k = 0; k < bonds->n; ++k) {
    sorted->id[k][0] = KITH_MIN(bonds->id[k][0], bonds->id[k][1]);
    sorted->id[k][1] = KITH_MAX(bonds->id[k][0], bonds->id[k][1]);
  }
  if (bonds->n > 0) qsort(sorted->id, sorted->n, sizeof *sorted->id, compare);
  return KITH_OK;
}

static bool bonded(const struct kith_excluder *excluder, const struct kith_candidate *c) {
  const struct sorted_bonds *sorted = excluder->self;
  const int64_t i = c->targets->nodes->id->i64[c->i], j = c->sources->nodes->id->i64[c->j],
                key[2] = {KITH_MIN(i, j), KITH_MAX(i, j)};
  return sorted->n > 0 && bsearch(key, sorted->id, sorted->n, sizeof *sorted->id, compare) != NULL;
}

static void free_bonds(struct kith_excluder *excluder) {
  KITH_FREE(&((struct sorted_bonds *)excluder->self)->id, &excluder->self);
}

const struct kith_excluder_ops kith_excluder_bonds = {
    .name = "bonds",
    .doc = "pairs of nodes that are joined by a bond, which a program defines",
    .phase = KITH_NARROW,
    .setup = sort_bonds,
    .reject = bonded,
    .clear = free_bonds};
