/* checkpoint_write.c - writing of checkpoints, section by section, by rank 0. */
#include <errno.h>

#include "lib/io/checkpoint.h"
#include "lib/io/checkpoint_file.h"
#include "lib/nodes/migrate.h"

static kith_status write_bytes(struct kith_checkpoint *c, const void *data, size_t bytes) {
  if (bytes > 0 && fwrite(data, 1, bytes, c->out->stream) != bytes)
    KITH_FAIL(BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
  return KITH_OK;
}

static kith_status new_section(struct kith_checkpoint *c, struct section **out, enum group group,
                               const char *name) {
  if (name[0] == '\0' || strlen(name) >= sizeof(*out)->name ||
      kith_checkpoint_file_find(c, group, name) != NULL)
    KITH_FAIL(INTERNAL, "checkpoint: '%s' is too long a name, empty, or was put before", name);
  if (c->header.sections == c->capacity) {
    KITH_TRY(kith_resize(&c->section, c->capacity, 2 * c->capacity + 16, sizeof *c->section));
    c->capacity = 2 * c->capacity + 16;
  }
  *out = &c->section[c->header.sections++];
  strcpy((*out)->name, name);
  (*out)->group = group;
  return KITH_OK;
}

static kith_status begin_section(struct kith_checkpoint *c, enum group group, const char *name,
                                 enum kith_type type, size_t components, size_t rows) {
  struct section *s = NULL;
  KITH_TRY(new_section(c, &s, group, name));
  s->type = type;
  s->components = components;
  s->rows = rows;
  s->bytes = padded(rows * components * type_size(type));
  s->checksum = checksum_start;
  c->n_tail = 0;
  return KITH_OK;
}

static kith_status write_words(struct kith_checkpoint *c, const void *data, size_t bytes) {
  struct section *s = &c->section[c->header.sections - 1];
  s->checksum = checksum(s->checksum, data, bytes);
  return write_bytes(c, data, bytes);
}

/* Of the section that was begun last; any number of bytes, whole words of them at once. */
static kith_status add_bytes(struct kith_checkpoint *c, const char *data, size_t bytes) {
  for (; bytes > 0 && c->n_tail % 8 != 0; --bytes) c->tail[c->n_tail++] = *data++;
  if (c->n_tail == 8) {
    KITH_TRY(write_words(c, c->tail, 8));
    c->n_tail = 0;
  }
  const size_t whole = bytes / 8 * 8;
  KITH_TRY(write_words(c, data, whole));
  if (bytes > whole) memcpy(c->tail, data + whole, bytes - whole), c->n_tail = bytes - whole;
  return KITH_OK;
}

static kith_status end_section(struct kith_checkpoint *c) {
  if (c->n_tail == 0) return KITH_OK;
  memset(c->tail + c->n_tail, 0, 8 - c->n_tail);
  return write_words(c, c->tail, 8);
}

static kith_status write_section(struct kith_checkpoint *c, enum group group, const char *name,
                                 enum kith_type type, size_t components, size_t rows, const void *data) {
  KITH_TRY(begin_section(c, group, name, type, components, rows));
  KITH_TRY(add_bytes(c, data, rows * components * type_size(type)));
  return end_section(c);
}

static kith_status put(struct kith_checkpoint *c, enum group group, const char *name, enum kith_type type,
                       size_t components, size_t rows, const void *data) {
  const kith_status status = write_section(c, group, name, type, components, rows, data);
  if (status != KITH_OK) c->broken = true;
  return status;
}

/* ---- nodes: list by list, rank by rank ---- */

static size_t sum_of(const struct kith_nodes *nodes, const int64_t *counts, int list) {
  size_t sum = 0;
  for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) sum += (size_t)counts[r * nodes->n_lists + list];
  return sum;
}

/* `bytes` of another rank, piece by piece; whatever went wrong before, that rank is heard to the end. */
static kith_status take_in(struct kith_checkpoint *c, struct kith_ranks *ranks, int from, size_t bytes,
                           kith_status status) {
  for (size_t done = 0, n; done < bytes; done += n) {
    n = KITH_MIN(bytes - done, (size_t)CHUNK);
    kith_ranks_send_to_root(ranks, from, c->chunk, n);
    if (status == KITH_OK) status = add_bytes(c, c->chunk, n);
  }
  return status;
}

static void give_away(struct kith_ranks *ranks, char *data, size_t bytes) {
  for (size_t done = 0, n; done < bytes; done += n) {
    n = KITH_MIN(bytes - done, (size_t)CHUNK);
    kith_ranks_send_to_root(ranks, kith_ranks_rank(ranks), data + done, n);
  }
}

/* Rank 0 has begun the section, or failed in that. */
static kith_status add_field(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                             const struct kith_field *field, const int64_t *counts, kith_status status) {
  const size_t size = kith_field_node_size(field);
  const int me = kith_ranks_rank(nodes->ranks);
  for (int l = 0; l < nodes->n_lists; ++l)
    for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) {
      const size_t bytes = (size_t)counts[r * nodes->n_lists + l] * size;
      if (bytes == 0 || (me != 0 && me != r)) continue;
      char *mine = (char *)field->data + (size_t)nodes->lists[l].first * size;
      if (me > 0)
        give_away(nodes->ranks, mine, bytes);
      else if (r > 0)
        status = take_in(c, nodes->ranks, r, bytes, status);
      else if (status == KITH_OK)
        status = add_bytes(c, mine, bytes);
    }
  return status;
}

static kith_status put_field(struct kith_checkpoint *c, enum group group, const struct kith_nodes *nodes,
                             const struct kith_field *field, const int64_t *counts) {
  size_t rows = 0;
  kith_status status = KITH_OK;
  for (int l = 0; l < nodes->n_lists; ++l) rows += sum_of(nodes, counts, l);
  if (c != NULL)
    status = begin_section(c, group, field->spec.name, field->spec.type, (size_t)field->components, rows);
  status = add_field(c, nodes, field, counts, status);
  if (status == KITH_OK && c != NULL) status = end_section(c);
  if (status != KITH_OK) c->broken = true;
  return status;
}

static kith_status put_lists(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                             const int64_t *counts) {
  struct stored_list lists[KITH_MAX_LISTS] = {0};
  int64_t first = 0;
  for (int l = 0; l < nodes->n_lists; ++l) {
    memcpy(lists[l].name, nodes->lists[l].name, sizeof lists[l].name);
    lists[l].first = first;
    lists[l].count = (int64_t)sum_of(nodes, counts, l);
    first += lists[l].count;
  }
  return put(c, GROUP_LISTS, "lists", KITH_U8, sizeof *lists, (size_t)nodes->n_lists, lists);
}

kith_status kith_checkpoint_put_nodes(struct kith_checkpoint *c, const struct kith_nodes *nodes) {
  int64_t *counts = NULL;
  KITH_TRY(kith_nodes_counts(nodes, &counts));
  kith_status status = c != NULL ? put_lists(c, nodes, counts) : KITH_OK;
  for (int f = 0; f < nodes->n_fields; ++f) {
    if (!kith_field_lasts(nodes->fields[f])) continue;
    const kith_status put = put_field(c, GROUP_FIELD, nodes, nodes->fields[f], counts);
    if (status == KITH_OK) status = put;
  }
  kith_free(&counts);
  return status;
}

kith_status kith_checkpoint_put_field(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                      const struct kith_field *field) {
  int64_t *counts = NULL;
  KITH_TRY(kith_nodes_counts(nodes, &counts));
  const kith_status status = put_field(c, GROUP_ARRAY, nodes, field, counts);
  kith_free(&counts);
  return status;
}

kith_status kith_checkpoint_open_new(struct kith_checkpoint **out, const char *path, const char *scene) {
  KITH_TRY(kith_checkpoint_file_create(out, path));
  struct kith_checkpoint *c = *out;
  kith_status status = kith_atomic_file_open(&c->out, path);
  if (status == KITH_OK) status = write_bytes(c, &c->header, sizeof c->header); /* zeros until commit */
  if (status == KITH_OK) status = put(c, GROUP_SCENE, "scene", KITH_U8, 1, strlen(scene), scene);
  if (status != KITH_OK) kith_checkpoint_close(out);
  return status;
}

kith_status kith_checkpoint_put_f64(struct kith_checkpoint *c, const char *name, const double *values,
                                    size_t n) {
  return put(c, GROUP_ARRAY, name, KITH_F64, 1, n, values);
}

kith_status kith_checkpoint_put_i64(struct kith_checkpoint *c, const char *name, const int64_t *values,
                                    size_t n) {
  return put(c, GROUP_ARRAY, name, KITH_I64, 1, n, values);
}

static kith_status write_table(struct kith_checkpoint *c) {
  struct header *h = &c->header;
  const size_t bytes = h->sections * sizeof *c->section;
  if (c->broken) KITH_FAIL(BAD_FILE, "%s: not written: an earlier part of it failed", c->path);
  memcpy(h->magic, KITH_CHECKPOINT_MAGIC, sizeof h->magic);
  h->mark = MARK, h->version = VERSION, h->dimension = NDIM;
  h->table = sizeof *h;
  for (uint32_t s = 0; s < h->sections; ++s) h->table += c->section[s].bytes;
  h->size = h->table + bytes;
  h->table_checksum = checksum(checksum_start, c->section, bytes);
  h->checksum = checksum(checksum_start, h, sizeof *h - 8);
  KITH_TRY(write_bytes(c, c->section, bytes));
  if (fseek(c->out->stream, 0, SEEK_SET) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
  return write_bytes(c, h, sizeof *h);
}

kith_status kith_checkpoint_commit(struct kith_checkpoint **c) {
  kith_status status = write_table(*c);
  if (status == KITH_OK) status = kith_atomic_file_commit(&(*c)->out, true);
  kith_checkpoint_close(c);
  return status;
}

void kith_checkpoint_abandon(struct kith_checkpoint **c) {
  kith_checkpoint_close(c);
}
