/* checkpoint.c - reading of checkpoints: everything is verified before anything is used. */
#include "lib/io/checkpoint.h"

#include <errno.h>
#include <sys/stat.h>

#include "lib/io/checkpoint_file.h"

static const char *type_name(uint32_t type) {
  return type == KITH_F64 ? "f64" : type == KITH_I64 ? "i64" : "u8";
}

void kith_checkpoint_close(struct kith_checkpoint **c) {
  kith_checkpoint_file_destroy(c);
}

static kith_status read_bytes(struct kith_checkpoint *c, void *data, size_t bytes) {
  if (bytes > 0 && fread(data, 1, bytes, c->in) != bytes)
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path,
              ferror(c->in) ? strerror(errno) : "the file is cut short");
  return KITH_OK;
}

static kith_status open_for_reading(struct kith_checkpoint *c, uint64_t *size) {
  struct stat present;
  c->in = fopen(c->path, "rb");
  if (c->in == NULL || fstat(fileno(c->in), &present) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, strerror(errno));
  if (!S_ISREG(present.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a regular file", c->path);
  *size = (uint64_t)present.st_size;
  return KITH_OK;
}

static kith_status read_header(struct kith_checkpoint *c, uint64_t size) {
  struct header *h = &c->header;
  uint32_t sections;
  if (size < sizeof *h)
    KITH_FAIL(BAD_FILE, "%s: not a checkpoint: %llu bytes", c->path, (unsigned long long)size);
  KITH_TRY(read_bytes(c, h, sizeof *h));
  sections = h->sections;
  h->sections = 0; /* until the table is there */
  if (memcmp(h->magic, KITH_CHECKPOINT_MAGIC, sizeof h->magic) != 0)
    KITH_FAIL(BAD_FILE, "%s: not a checkpoint", c->path);
  if (h->mark != MARK) KITH_FAIL(BAD_FILE, "%s: written by a machine of another byte order", c->path);
  if (h->version != VERSION)
    KITH_FAIL(BAD_FILE, "%s: checkpoint version %u, this program reads %d", c->path, h->version, VERSION);
  h->sections = sections;
  const uint64_t sum = checksum(checksum_start, h, sizeof *h - 8);
  h->sections = 0;
  if (h->checksum != sum) KITH_FAIL(BAD_FILE, "%s: damaged: checksum of the header", c->path);
  if (h->dimension != NDIM)
    KITH_FAIL(BAD_INPUT, "%s: a %u-D checkpoint, this program is %d-D", c->path, h->dimension, NDIM);
  if (h->size != size)
    KITH_FAIL(BAD_FILE, "%s: damaged: %llu bytes of %llu", c->path, (unsigned long long)size,
              (unsigned long long)h->size);
  if (h->table > size || size - h->table != (uint64_t)sections * sizeof *c->section)
    KITH_FAIL(BAD_FILE, "%s: damaged: table of %u sections", c->path, sections);
  KITH_TRY(kith_resize(&c->section, 0, sections, sizeof *c->section));
  h->sections = sections;
  return KITH_OK;
}

/* bytes == padded(rows * components * size of the type), without overflow, within `available`. */
static bool plausible(const struct section *s, uint64_t available) {
  if (memchr(s->name, '\0', sizeof s->name) == NULL || s->name[0] == '\0') return false;
  if (s->group > GROUP_ARRAY || s->type > KITH_U8 || s->bytes > available) return false;
  if (s->components == 0 || s->components > MOST_COMPONENTS) return false;
  const uint64_t size = s->components * type_size(s->type);
  return s->rows <= s->bytes / size && padded(s->rows * size) == s->bytes;
}

static kith_status read_table(struct kith_checkpoint *c) {
  const struct header *h = &c->header;
  const size_t bytes = h->sections * sizeof *c->section;
  uint64_t offset = sizeof *h;
  if (fseek(c->in, (long)h->table, SEEK_SET) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, strerror(errno));
  KITH_TRY(read_bytes(c, c->section, bytes));
  if (checksum(checksum_start, c->section, bytes) != h->table_checksum)
    KITH_FAIL(BAD_FILE, "%s: damaged: checksum of the table", c->path);
  for (uint32_t s = 0; s < h->sections; ++s) {
    if (offset > h->table || !plausible(&c->section[s], h->table - offset))
      KITH_FAIL(BAD_FILE, "%s: damaged: section %u", c->path, s);
    offset += c->section[s].bytes;
  }
  if (offset != h->table) KITH_FAIL(BAD_FILE, "%s: damaged: the sections do not fill it", c->path);
  return KITH_OK;
}

static kith_status verify_section(struct kith_checkpoint *c, const struct section *s) {
  uint64_t sum = checksum_start;
  for (uint64_t done = 0; done < s->bytes; done += CHUNK) {
    const size_t bytes = (size_t)KITH_MIN((uint64_t)CHUNK, s->bytes - done);
    KITH_TRY(read_bytes(c, c->chunk, bytes));
    sum = checksum(sum, c->chunk, bytes);
  }
  if (sum != s->checksum) KITH_FAIL(BAD_FILE, "%s: damaged: checksum of '%s'", c->path, s->name);
  return KITH_OK;
}

static kith_status verify(struct kith_checkpoint *c) {
  kith_status status = KITH_OK;
  if (fseek(c->in, sizeof c->header, SEEK_SET) != 0)
    status = kith_fail(KITH_BAD_FILE, "%s: cannot read", c->path);
  for (uint32_t s = 0; s < c->header.sections && status == KITH_OK; ++s)
    status = verify_section(c, &c->section[s]);
  return status;
}

/* `bytes`: without the padding. */
static kith_status read_section(struct kith_checkpoint *c, const struct section *s, void *data) {
  uint64_t offset = sizeof c->header;
  for (const struct section *t = c->section; t < s; ++t) offset += t->bytes;
  if (fseek(c->in, (long)offset, SEEK_SET) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, strerror(errno));
  return read_bytes(c, data, s->rows * s->components * type_size(s->type));
}

/* The section of this name and shape; rows SIZE_MAX: any number. */
static kith_status expect(const struct kith_checkpoint *c, const struct section **out, enum group group,
                          const char *name, uint32_t type, size_t components, size_t rows) {
  const struct section *s = kith_checkpoint_file_find(c, group, name);
  if (s == NULL) KITH_FAIL(BAD_FILE, "%s: '%s' is missing", c->path, name);
  if (s->type != type || s->components != components || (rows != SIZE_MAX && s->rows != rows))
    KITH_FAIL(BAD_FILE, "%s: '%s' is %llu x %llu %s, wanted %lld x %zu %s", c->path, name,
              (unsigned long long)s->rows, (unsigned long long)s->components, type_name(s->type),
              rows == SIZE_MAX ? -1LL : (long long)rows, components, type_name(type));
  *out = s;
  return KITH_OK;
}

static kith_status read_scene(struct kith_checkpoint *c) {
  const struct section *s = NULL;
  KITH_TRY(expect(c, &s, GROUP_SCENE, "scene", KITH_U8, 1, SIZE_MAX));
  KITH_TRY(kith_resize(&c->scene, 0, s->rows + 1, 1));
  return read_section(c, s, c->scene);
}

kith_status kith_checkpoint_open(struct kith_checkpoint **out, const char *path) {
  uint64_t size = 0;
  KITH_TRY(kith_checkpoint_file_create(out, path));
  kith_status status = open_for_reading(*out, &size);
  if (status == KITH_OK) status = read_header(*out, size);
  if (status == KITH_OK) status = read_table(*out);
  if (status == KITH_OK) status = verify(*out);
  if (status == KITH_OK) status = read_scene(*out);
  if (status != KITH_OK) kith_checkpoint_close(out);
  return status;
}

const char *kith_checkpoint_scene(const struct kith_checkpoint *c) {
  return c->scene;
}

/* The stored lists: those of `nodes`, one behind the other. */
static kith_status read_lists(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                              struct stored_list *lists, size_t *total) {
  const struct section *s = NULL;
  KITH_TRY(expect(c, &s, GROUP_LISTS, "lists", KITH_U8, sizeof *lists, SIZE_MAX));
  if (s->rows != (size_t)nodes->n_lists)
    KITH_FAIL(BAD_INPUT, "%s: it has %llu node lists, the scene %d", c->path, (unsigned long long)s->rows,
              nodes->n_lists);
  KITH_TRY(read_section(c, s, lists));
  *total = 0;
  for (int l = 0; l < nodes->n_lists; ++l) {
    if (strncmp(lists[l].name, nodes->lists[l].name, sizeof lists[l].name) != 0)
      KITH_FAIL(BAD_INPUT, "%s: node list %d is '%.32s', in the scene '%s'", c->path, l, lists[l].name,
                nodes->lists[l].name);
    if (lists[l].count < 0 || lists[l].count > INT32_MAX - (int64_t)*total ||
        lists[l].first != (int64_t)*total)
      KITH_FAIL(BAD_FILE, "%s: damaged: node list '%s'", c->path, nodes->lists[l].name);
    *total += (size_t)lists[l].count;
  }
  return KITH_OK;
}

/* Every state field is in the file with its shape, and the file has no other. */
static kith_status match_fields(const struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                size_t total) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const struct kith_field *field = nodes->fields[f];
    const struct section *s = NULL;
    if (!kith_field_lasts(field)) continue;
    KITH_TRY(
        expect(c, &s, GROUP_FIELD, field->spec.name, field->spec.type, (size_t)field->components, total));
  }
  for (uint32_t k = 0; k < c->header.sections; ++k) {
    const struct section *s = &c->section[k];
    const struct kith_field *field = s->group == GROUP_FIELD ? kith_nodes_field_named(nodes, s->name) : NULL;
    if (s->group == GROUP_FIELD && (field == NULL || !kith_field_lasts(field)))
      KITH_FAIL(BAD_FILE, "%s: it has the field '%s', which this scene does not use", c->path, s->name);
  }
  return KITH_OK;
}

static kith_status replace_nodes(struct kith_nodes *nodes, const struct stored_list *lists) {
  uint8_t *dead = NULL;
  if (nodes->n_internal > 0) {
    KITH_TRY(kith_resize(&dead, 0, (size_t)nodes->n_internal, 1));
    memset(dead, 1, (size_t)nodes->n_internal);
    const kith_status status = kith_nodes_delete(nodes, dead);
    kith_free(&dead);
    KITH_TRY(status);
  }
  for (int l = 0; l < nodes->n_lists; ++l)
    if (lists[l].count > 0) KITH_TRY(kith_nodes_append(nodes, l, (kith_index)lists[l].count, NULL));
  return KITH_OK;
}

kith_status kith_checkpoint_nodes(struct kith_checkpoint *c, struct kith_nodes *nodes) {
  struct stored_list lists[KITH_MAX_LISTS];
  size_t total = 0;
  KITH_TRY(read_lists(c, nodes, lists, &total));
  KITH_TRY(match_fields(c, nodes, total));
  KITH_TRY(replace_nodes(nodes, lists));
  ++nodes->positions;
  for (int f = 0; f < nodes->n_fields; ++f)
    if (kith_field_lasts(nodes->fields[f]))
      KITH_TRY(read_section(c, kith_checkpoint_file_find(c, GROUP_FIELD, nodes->fields[f]->spec.name),
                            nodes->fields[f]->data));
  return KITH_OK;
}

size_t kith_checkpoint_length(const struct kith_checkpoint *c, const char *name) {
  const struct section *s = kith_checkpoint_file_find(c, GROUP_ARRAY, name);
  return s == NULL ? SIZE_MAX : (size_t)s->rows;
}

static kith_status read_array(struct kith_checkpoint *c, const char *name, enum kith_type type, void *values,
                              size_t n) {
  const struct section *s = NULL;
  KITH_TRY(expect(c, &s, GROUP_ARRAY, name, type, 1, n));
  return read_section(c, s, values);
}

kith_status kith_checkpoint_f64(struct kith_checkpoint *c, const char *name, double *values, size_t n) {
  return read_array(c, name, KITH_F64, values, n);
}

kith_status kith_checkpoint_i64(struct kith_checkpoint *c, const char *name, int64_t *values, size_t n) {
  return read_array(c, name, KITH_I64, values, n);
}
