/* nodes.c - node lists, fields, growth. Reordering and deletion are in order.c, ghosts in ghosts.c. */
#include "lib/nodes/nodes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

struct kith_work {
  char *data;
  size_t capacity;
};

kith_status kith_nodes_work(const struct kith_nodes *nodes, size_t bytes, void *p) {
  struct kith_work *work = nodes->work;
  KITH_TRY(kith_reserve(&work->data, &work->capacity, bytes, 1));
  memcpy(p, &work->data, sizeof work->data);
  return KITH_OK;
}

size_t kith_nodes_work_bytes(const struct kith_nodes *nodes) {
  return nodes->work->capacity;
}

void kith_nodes_free_work(const struct kith_nodes *nodes) {
  kith_free(&nodes->work->data);
  nodes->work->capacity = 0;
}

size_t kith_field_node_size(const struct kith_field *field) {
  return (size_t)field->components * (field->spec.type == KITH_U8 ? 1 : 8);
}

static kith_status register_standing(struct kith_nodes *nodes) {
  static const struct kith_field_spec spec[] = {
      {"position", KITH_POSITION, KITH_F64, KITH_STATE, "Coordinates", "position"},
      {"support", KITH_SCALAR, KITH_F64, KITH_STATE, "SmoothingLength", "radius of the kernel's support"},
      KITH_SPEC(SCALAR, WORK, "search_radius", "radius that the connectivity is built with"),
      {"id", KITH_SCALAR, KITH_I64, KITH_STATE, "ParticleIDs", "global id"},
      {"list", KITH_SCALAR, KITH_U8, KITH_DERIVED, "MaterialIDs",
       "number of the material, from 0, in MaterialNames"}};
  struct kith_field **const field[] = {&nodes->position, &nodes->support, &nodes->search_radius, &nodes->id,
                                       &nodes->list};
  for (size_t k = 0; k < sizeof spec / sizeof *spec; ++k)
    KITH_TRY(kith_nodes_field(nodes, &spec[k], field[k]));
  return KITH_OK;
}

kith_status kith_nodes_create(struct kith_nodes **out, int n_lists, const char *const *names) {
  *out = NULL;
  if (n_lists < 1 || n_lists > KITH_MAX_LISTS)
    KITH_FAIL(BAD_INPUT, "%d node lists: allowed are 1 to %d", n_lists, KITH_MAX_LISTS);
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  struct kith_nodes *nodes = *out;
  nodes->n_lists = n_lists;
  kith_shifts_drop(&nodes->shifts);
  for (int a = 0; a < NDIM; ++a) nodes->stretch[a] = 1;
  nodes->longest = nodes->volume = 1;
  for (int l = 0; l < n_lists; ++l)
    snprintf(nodes->lists[l].name, sizeof nodes->lists[l].name, "%s", names[l]);
  kith_status status = kith_resize(&nodes->work, 0, 1, sizeof *nodes->work);
  if (status == KITH_OK) status = register_standing(nodes);
  if (status != KITH_OK) kith_nodes_destroy(out);
  return status;
}

static kith_status copy_fields(struct kith_nodes *copy, const struct kith_nodes *nodes, bool all_fields) {
  for (int l = 0; l < nodes->n_lists; ++l) KITH_TRY(kith_nodes_append(copy, l, nodes->lists[l].count, NULL));
  for (int f = 0; f < nodes->n_fields; ++f) {
    const struct kith_field *from = nodes->fields[f];
    struct kith_field *to;
    if (!all_fields && from->spec.output == NULL) continue;
    KITH_TRY(kith_nodes_field(copy, &from->spec, &to));
    if (nodes->n_internal > 0)
      memcpy(to->data, from->data, (size_t)nodes->n_internal * kith_field_node_size(from));
  }
  return KITH_OK;
}

kith_status kith_nodes_copy(struct kith_nodes **out, const struct kith_nodes *nodes, bool all_fields) {
  const char *names[KITH_MAX_LISTS];
  for (int l = 0; l < nodes->n_lists; ++l) names[l] = nodes->lists[l].name;
  KITH_TRY(kith_nodes_create(out, nodes->n_lists, names));
  const kith_status status = copy_fields(*out, nodes, all_fields);
  if (status != KITH_OK) kith_nodes_destroy(out);
  return status;
}

void kith_nodes_drop_ghosts(struct kith_nodes *nodes) {
  if (nodes->n_blocks == 0 && nodes->shifts.n == 1) return;
  kith_shifts_drop(&nodes->shifts);
  for (int b = 0; b < nodes->n_blocks; ++b) kith_free(&nodes->blocks[b].control);
  nodes->n_blocks = 0;
  nodes->n_ghost = 0;
  ++nodes->ghosts;
}

void kith_nodes_destroy(struct kith_nodes **nodes) {
  if (*nodes == NULL) return;
  kith_nodes_drop_ghosts(*nodes);
  kith_shifts_clear(&(*nodes)->shifts);
  if ((*nodes)->work != NULL) kith_free(&(*nodes)->work->data);
  KITH_FREE(&(*nodes)->work, &(*nodes)->blocks);
  for (int f = 0; f < (*nodes)->n_fields; ++f) {
    KITH_FREE(&(*nodes)->fields[f]->data, &(*nodes)->fields[f]);
  }
  kith_free(nodes);
}

/* Is a field what this specification requires? It may have been given ghosts since it was registered. */
static bool fits_spec(const struct kith_field_spec *field, const struct kith_field_spec *spec) {
  const bool has_ghosts = (field->role == KITH_KEPT && spec->role == KITH_OWN_KEPT) ||
                          (field->role == KITH_WORK && spec->role == KITH_OWN_WORK);
  return field->kind == spec->kind && field->type == spec->type &&
         (field->role == spec->role || has_ghosts) &&
         strcmp(field->output != NULL ? field->output : "", spec->output != NULL ? spec->output : "") == 0;
}

static kith_index capacity_of(const struct kith_nodes *nodes, const struct kith_field *field) {
  return kith_field_is_own(field) ? nodes->own_capacity : nodes->capacity;
}

/* There is room for one node more, because kith_lanes_vector loads a vector with what follows it. */
static kith_status move_field(struct kith_field *field, kith_index keep, kith_index capacity) {
  return kith_resize(&field->data, (size_t)keep, (size_t)capacity + 1, kith_field_node_size(field));
}

kith_status kith_nodes_fields(struct kith_nodes *nodes, const struct kith_field_row *table) {
  for (; table->spec.name != NULL; ++table)
    if (table->wanted) KITH_TRY(kith_nodes_field(nodes, &table->spec, table->out));
  return KITH_OK;
}

struct kith_field *kith_nodes_field_named(const struct kith_nodes *nodes, const char *name) {
  for (int f = 0; f < nodes->n_fields; ++f)
    if (strcmp(nodes->fields[f]->spec.name, name) == 0) return nodes->fields[f];
  return NULL;
}

kith_status kith_nodes_field(struct kith_nodes *nodes, const struct kith_field_spec *spec,
                             struct kith_field **out) {
  static const int components[] = {[KITH_SCALAR] = 1,           [KITH_VECTOR] = NDIM,
                                   [KITH_TENSOR] = NDIM * NDIM, [KITH_SYMMETRIC] = NDIM * (NDIM + 1) / 2,
                                   [KITH_POSITION] = NDIM,      [KITH_VELOCITY] = NDIM};
  struct kith_field *field = kith_nodes_field_named(nodes, spec->name);
  if (field != NULL) {
    if (!fits_spec(&field->spec, spec))
      KITH_FAIL(INTERNAL, "field '%s' is registered with another specification", spec->name);
    *out = field;
    return KITH_OK;
  }
  if (spec->type != KITH_F64 && spec->kind != KITH_SCALAR)
    KITH_FAIL(INTERNAL, "field '%s': only scalars may be integers", spec->name);
  if (nodes->n_fields == KITH_MAX_FIELDS)
    KITH_FAIL(INTERNAL, "no room for field '%s': there are %d", spec->name, KITH_MAX_FIELDS);
  KITH_TRY(kith_resize(&field, 0, 1, sizeof *field));
  field->spec = *spec;
  field->components = components[spec->kind];
  const kith_status status = move_field(field, 0, capacity_of(nodes, field));
  if (status != KITH_OK) {
    kith_free(&field);
    return status;
  }
  nodes->fields[nodes->n_fields++] = field;
  *out = field;
  return KITH_OK;
}

kith_status kith_nodes_stretch(struct kith_nodes *nodes, const double stretch[NDIM]) {
  static const struct kith_field_spec stretched =
      KITH_SPEC(VECTOR, WORK, "stretched", "position in units of the half axes of supports");
  for (int a = 0; a < NDIM; ++a)
    if (!(stretch[a] >= 1 && isfinite(stretch[a])))
      KITH_FAIL(BAD_INPUT, "a half axis of %g supports: at least 1", stretch[a]);
  nodes->longest = nodes->volume = 1;
  for (int a = 0; a < NDIM; ++a) {
    nodes->stretch[a] = stretch[a], nodes->volume *= stretch[a];
    nodes->longest = KITH_MAX(nodes->longest, stretch[a]);
  }
  return kith_nodes_field(nodes, &stretched, &nodes->stretched);
}

kith_status kith_nodes_number_images(struct kith_nodes *nodes) {
  static const struct kith_field_spec image = {
      "image", KITH_SCALAR, KITH_I64, KITH_DERIVED, NULL, "which image of its node a ghost is"};
  return kith_nodes_field(nodes, &image, &nodes->image);
}

kith_status kith_nodes_mark_activity(struct kith_nodes *nodes) {
  static const struct kith_field_spec activity = {"activity", KITH_SCALAR, KITH_U8,
                                                  KITH_WORK,  NULL,        "idle, touched or active"};
  return kith_nodes_field(nodes, &activity, &nodes->activity);
}

kith_status kith_nodes_flag(struct kith_nodes *nodes) {
  static const struct kith_field_spec flag = {
      "flag",
      KITH_SCALAR,
      KITH_U8,
      KITH_STATE,
      "NodeFlags",
      "0 internal, 1 frozen, 2 a frozen barrier; behind a face that gas passes: 3, 4 of x, 5, 6 of y ..."};
  return kith_nodes_field(nodes, &flag, &nodes->flag);
}

kith_status kith_nodes_give_ghosts(struct kith_nodes *nodes, struct kith_field *field) {
  if (!kith_field_is_own(field)) return KITH_OK;
  KITH_TRY(move_field(field, nodes->n_internal, nodes->capacity));
  field->spec.role = field->spec.role == KITH_OWN_KEPT ? KITH_KEPT : KITH_WORK;
  return KITH_OK;
}

static kith_status move_fields(struct kith_nodes *nodes, bool own, kith_index capacity) {
  const kith_index keep = own ? nodes->n_internal : kith_nodes_count(nodes);
  for (int f = 0; f < nodes->n_fields; ++f)
    if (kith_field_is_own(nodes->fields[f]) == own) KITH_TRY(move_field(nodes->fields[f], keep, capacity));
  return KITH_OK;
}

static kith_status shrink(struct kith_nodes *nodes, bool own, kith_index count, kith_index *capacity) {
  const int64_t wanted = (int64_t)count + count / 8;
  if (wanted >= *capacity) return KITH_OK;
  *capacity = (kith_index)wanted; /* a field that cannot be moved has more */
  return move_fields(nodes, own, *capacity);
}

kith_status kith_nodes_shrink(struct kith_nodes *nodes) {
  KITH_TRY(shrink(nodes, true, nodes->n_internal, &nodes->own_capacity));
  return shrink(nodes, false, kith_nodes_count(nodes), &nodes->capacity);
}

static kith_status grow(struct kith_nodes *nodes, bool own, int64_t wanted, kith_index *capacity) {
  if (wanted > INT32_MAX) KITH_FAIL(UNSUPPORTED, "%lld nodes: more than an index counts", (long long)wanted);
  if (wanted <= *capacity) return KITH_OK;
  const int64_t ahead = KITH_MAX(wanted, (int64_t)*capacity + *capacity / 8);
  const kith_index larger = (kith_index)KITH_MIN(ahead, INT32_MAX);
  KITH_TRY(move_fields(nodes, own, larger));
  *capacity = larger;
  return KITH_OK;
}

kith_status kith_nodes_grow(struct kith_nodes *nodes, kith_index internal, kith_index ghosts) {
  const int64_t wanted = (int64_t)nodes->n_internal + internal;
  KITH_TRY(grow(nodes, true, wanted, &nodes->own_capacity));
  return grow(nodes, false, wanted + nodes->n_ghost + ghosts, &nodes->capacity);
}

/* Inserts `count` zeros at index `at` of one field with n nodes. */
static void open_hole(struct kith_field *field, kith_index n, kith_index at, kith_index count) {
  const size_t size = kith_field_node_size(field);
  char *hole = (char *)field->data + (size_t)at * size;
  memmove(hole + (size_t)count * size, hole, (size_t)(n - at) * size);
  memset(hole, 0, (size_t)count * size);
}

kith_status kith_nodes_append(struct kith_nodes *nodes, int list, kith_index count, kith_index *first) {
  if (list < 0 || list >= nodes->n_lists || count < 0)
    KITH_FAIL(INTERNAL, "cannot append %d nodes to list %d of %d", count, list, nodes->n_lists);
  kith_nodes_drop_ghosts(nodes);
  KITH_TRY(kith_nodes_grow(nodes, count, 0));
  const kith_index at = nodes->lists[list].first + nodes->lists[list].count;
  if (first != NULL) *first = at;
  if (count == 0) return KITH_OK;
#pragma omp parallel for schedule(static) if (nodes->n_internal - at + count > KITH_FEW_COPIES)
  for (int f = 0; f < nodes->n_fields; ++f) open_hole(nodes->fields[f], nodes->n_internal, at, count);
  for (kith_index i = at; i < at + count; ++i) {
    nodes->id->i64[i] = -1;
    nodes->list->u8[i] = (uint8_t)list;
  }
  nodes->lists[list].count += count;
  for (int l = list + 1; l < nodes->n_lists; ++l) nodes->lists[l].first += count;
  nodes->n_internal += count;
  ++nodes->order, ++nodes->ghosts;
  return KITH_OK;
}

size_t kith_nodes_bytes(const struct kith_nodes *nodes) {
  size_t bytes = sizeof *nodes + nodes->blocks_capacity * sizeof *nodes->blocks +
                 kith_shifts_bytes(&nodes->shifts) + nodes->work->capacity;
  for (int f = 0; f < nodes->n_fields; ++f)
    bytes += sizeof *nodes->fields[f] +
             (size_t)capacity_of(nodes, nodes->fields[f]) * kith_field_node_size(nodes->fields[f]);
  for (int b = 0; b < nodes->n_blocks; ++b)
    if (nodes->blocks[b].control != NULL) bytes += (size_t)nodes->blocks[b].count * sizeof(kith_index);
  return bytes;
}
