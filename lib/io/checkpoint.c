/* checkpoint.c - the file of a checkpoint. Rank 0 writes it section by section; in reading everything is
 * verified before anything is used. */
#include "lib/io/checkpoint.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include "lib/io/atomic_file.h"
#include "lib/nodes/migrate.h"

#define MAGIC "kithckpt"
enum { MARK = 0x01020304, VERSION = 1, CHUNK = 1 << 18, MOST_COMPONENTS = 64 };
enum group { GROUP_SCENE, GROUP_LISTS, GROUP_FIELD, GROUP_ARRAY };

struct header {
  char magic[8];
  uint32_t mark, version, dimension, sections;
  uint64_t table, size, table_checksum, zero, checksum;
};
struct section {
  char name[56];
  uint32_t group, type;
  uint64_t components, rows, bytes, checksum;
};
struct stored_list {
  char name[32];
  int64_t first, count;
};
_Static_assert(sizeof(struct header) == 64, "the header is 64 bytes");
_Static_assert(sizeof(struct section) == 96, "an entry of the table is 96 bytes");
_Static_assert(sizeof(struct stored_list) == 48, "a list is 48 bytes");
_Static_assert(sizeof(struct kith_node_list) == 40, "a new member of a list must be added to stored_list");

struct kith_checkpoint {
  struct kith_atomic_file *out; /* writing */
  FILE *in;                     /* reading */
  char *scene;                  /* owned */
  struct header header;
  struct section *section; /* [header.sections] */
  size_t capacity;
  kith_status status; /* of writing: after a failure nothing more is written, and it cannot be committed */
  char tail[8];       /* of the section that is being written: bytes of an incomplete word */
  size_t n_tail;
  char chunk[CHUNK]; /* values of other ranks, or what is verified */
  char path[];
};

/* Checksum of whole words, continued from h. Each word enters through one-to-one functions of h, so two files
 * that differ in one word never agree. Multiplier: the one of 64-bit FNV; the shift carries high bits
 * down. */
static uint64_t checksum(uint64_t h, const void *data, size_t bytes) {
  for (size_t k = 0; k < bytes; k += 8) {
    uint64_t word;
    memcpy(&word, (const char *)data + k, 8);
    h = (h ^ word) * UINT64_C(0x100000001b3);
    h ^= h >> 29;
  }
  return h;
}

static const uint64_t checksum_start = UINT64_C(0xcbf29ce484222325);

static size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

static size_t type_size(uint32_t type) {
  return type == KITH_U8 ? 1 : 8;
}

void kith_checkpoint_close(struct kith_checkpoint **c) {
  if (*c == NULL) return;
  kith_atomic_file_abandon(&(*c)->out);
  if ((*c)->in != NULL) fclose((*c)->in);
  kith_free(&(*c)->scene);
  kith_free(&(*c)->section);
  kith_free(c);
}

static kith_status create(struct kith_checkpoint **out, const char *path) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + strlen(path) + 1));
  strcpy((*out)->path, path);
  return KITH_OK;
}

/* NULL if there is none. */
static const struct section *find(const struct kith_checkpoint *c, enum group group, const char *name) {
  for (uint32_t s = 0; s < c->header.sections; ++s)
    if (c->section[s].group == group && strcmp(c->section[s].name, name) == 0) return &c->section[s];
  return NULL;
}

/* ---- writing ---- */

static void write_bytes(struct kith_checkpoint *c, const void *data, size_t bytes) {
  if (c->status == KITH_OK && bytes > 0 && fwrite(data, 1, bytes, c->out->stream) != bytes)
    c->status = kith_fail(KITH_BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
}

static void begin_section(struct kith_checkpoint *c, enum group group, const char *name, enum kith_type type,
                          size_t components, size_t rows) {
  const size_t n = c->header.sections;
  if (c->status != KITH_OK) return;
  if (name[0] == '\0' || strlen(name) >= sizeof c->section->name || find(c, group, name) != NULL)
    c->status =
        kith_fail(KITH_INTERNAL, "checkpoint: '%s' is too long a name, empty, or was put before", name);
  else
    c->status = kith_grow(&c->section, &c->capacity, n, n + 1, sizeof *c->section);
  if (c->status != KITH_OK) return;
  c->section[n] = (struct section){.group = group,
                                   .type = type,
                                   .components = components,
                                   .rows = rows,
                                   .bytes = padded(rows * components * type_size(type)),
                                   .checksum = checksum_start};
  strcpy(c->section[n].name, name);
  c->n_tail = 0;
  ++c->header.sections;
}

static void write_words(struct kith_checkpoint *c, const void *data, size_t bytes) {
  if (c->status != KITH_OK) return;
  struct section *s = &c->section[c->header.sections - 1];
  s->checksum = checksum(s->checksum, data, bytes);
  write_bytes(c, data, bytes);
}

/* Of the section that was begun last; any number of bytes, whole words of them at once. */
static void add_bytes(struct kith_checkpoint *c, const char *data, size_t bytes) {
  for (; bytes > 0 && c->n_tail % 8 != 0; --bytes) c->tail[c->n_tail++] = *data++;
  if (c->n_tail == 8) {
    write_words(c, c->tail, 8);
    c->n_tail = 0;
  }
  const size_t whole = bytes / 8 * 8;
  write_words(c, data, whole);
  if (bytes > whole) memcpy(c->tail, data + whole, bytes - whole), c->n_tail = bytes - whole;
}

static kith_status end_section(struct kith_checkpoint *c) {
  memset(c->tail + c->n_tail, 0, 8 - c->n_tail);
  if (c->n_tail > 0) write_words(c, c->tail, 8);
  return c->status;
}

static kith_status put(struct kith_checkpoint *c, enum group group, const char *name, enum kith_type type,
                       size_t components, size_t rows, const void *data) {
  begin_section(c, group, name, type, components, rows);
  add_bytes(c, data, rows * components * type_size(type));
  return end_section(c);
}

/* Nodes: list by list, rank by rank. */
static size_t sum_of(const struct kith_nodes *nodes, const int64_t *counts, int list) {
  size_t sum = 0;
  for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) sum += (size_t)counts[r * nodes->n_lists + list];
  return sum;
}

/* Whatever went wrong on rank 0, the others are heard to the end, piece by piece. */
static kith_status put_field(struct kith_checkpoint *c, enum group group, const struct kith_nodes *nodes,
                             const struct kith_field *field, const int64_t *counts) {
  const size_t size = kith_field_node_size(field);
  const int me = kith_ranks_rank(nodes->ranks);
  size_t rows = 0;
  for (int l = 0; l < nodes->n_lists; ++l) rows += sum_of(nodes, counts, l);
  if (c != NULL) begin_section(c, group, field->spec.name, field->spec.type, (size_t)field->components, rows);
  for (int l = 0; l < nodes->n_lists; ++l)
    for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) {
      char *mine = (char *)field->data + (size_t)nodes->lists[l].first * size;
      size_t bytes = me == 0 || me == r ? (size_t)counts[r * nodes->n_lists + l] * size : 0;
      for (size_t n; bytes > 0; bytes -= n, mine += n) {
        char *piece = me == r ? mine : c->chunk;
        n = KITH_MIN(bytes, (size_t)CHUNK);
        kith_ranks_send_to_root(nodes->ranks, r, piece, n);
        if (me == 0) add_bytes(c, piece, n);
      }
    }
  return c != NULL ? end_section(c) : KITH_OK;
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
    status = put_field(c, GROUP_FIELD, nodes, nodes->fields[f], counts);
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
  KITH_TRY(create(out, path));
  struct kith_checkpoint *c = *out;
  c->status = kith_atomic_file_open(&c->out, path);
  write_bytes(c, &c->header, sizeof c->header); /* zeros until commit */
  const kith_status status = put(c, GROUP_SCENE, "scene", KITH_U8, 1, strlen(scene), scene);
  if (status != KITH_OK) kith_checkpoint_close(out);
  return status;
}

kith_status kith_checkpoint_put(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                const void *values, size_t n) {
  return put(c, GROUP_ARRAY, name, type, 1, n, values);
}

static kith_status write_table(struct kith_checkpoint *c) {
  struct header *h = &c->header;
  const size_t bytes = h->sections * sizeof *c->section;
  if (c->status != KITH_OK) KITH_FAIL(BAD_FILE, "%s: not written: an earlier part of it failed", c->path);
  memcpy(h->magic, MAGIC, sizeof h->magic);
  h->mark = MARK, h->version = VERSION, h->dimension = NDIM;
  h->table = sizeof *h;
  for (uint32_t s = 0; s < h->sections; ++s) h->table += c->section[s].bytes;
  h->size = h->table + bytes;
  h->table_checksum = checksum(checksum_start, c->section, bytes);
  h->checksum = checksum(checksum_start, h, sizeof *h - 8);
  write_bytes(c, c->section, bytes);
  if (c->status == KITH_OK && fseek(c->out->stream, 0, SEEK_SET) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
  write_bytes(c, h, sizeof *h);
  return c->status;
}

kith_status kith_checkpoint_commit(struct kith_checkpoint **c) {
  kith_status status = write_table(*c);
  if (status == KITH_OK) status = kith_atomic_file_commit(&(*c)->out, true);
  kith_checkpoint_close(c);
  return status;
}

/* ---- reading ---- */

static kith_status read_at(struct kith_checkpoint *c, uint64_t offset, void *data, size_t bytes) {
  if (fseek(c->in, (long)offset, SEEK_SET) != 0 || (bytes > 0 && fread(data, 1, bytes, c->in) != bytes))
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path,
              feof(c->in) ? "the file is cut short" : strerror(errno));
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
  const struct header *h = &c->header;
  if (size < sizeof *h)
    KITH_FAIL(BAD_FILE, "%s: not a checkpoint: %llu bytes", c->path, (unsigned long long)size);
  KITH_TRY(read_at(c, 0, &c->header, sizeof *h));
  if (memcmp(h->magic, MAGIC, sizeof h->magic) != 0) KITH_FAIL(BAD_FILE, "%s: not a checkpoint", c->path);
  if (h->mark != MARK) KITH_FAIL(BAD_FILE, "%s: written by a machine of another byte order", c->path);
  if (h->version != VERSION)
    KITH_FAIL(BAD_FILE, "%s: checkpoint version %u, this program reads %d", c->path, h->version, VERSION);
  if (h->checksum != checksum(checksum_start, h, sizeof *h - 8))
    KITH_FAIL(BAD_FILE, "%s: damaged: checksum of the header", c->path);
  if (h->dimension != NDIM)
    KITH_FAIL(BAD_INPUT, "%s: a %u-D checkpoint, this program is %d-D", c->path, h->dimension, NDIM);
  if (h->size != size)
    KITH_FAIL(BAD_FILE, "%s: damaged: %llu bytes of %llu", c->path, (unsigned long long)size,
              (unsigned long long)h->size);
  if (h->table > size || size - h->table != (uint64_t)h->sections * sizeof *c->section)
    KITH_FAIL(BAD_FILE, "%s: damaged: table of %u sections", c->path, h->sections);
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
  KITH_TRY(kith_resize(&c->section, 0, h->sections, sizeof *c->section));
  KITH_TRY(read_at(c, h->table, c->section, bytes));
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

static kith_status verify(struct kith_checkpoint *c) {
  uint64_t offset = sizeof c->header;
  for (const struct section *s = c->section; s < c->section + c->header.sections; ++s) {
    uint64_t sum = checksum_start;
    for (uint64_t end = offset + s->bytes, n; offset < end; offset += n) {
      n = KITH_MIN((uint64_t)CHUNK, end - offset);
      KITH_TRY(read_at(c, offset, c->chunk, n));
      sum = checksum(sum, c->chunk, n);
    }
    if (sum != s->checksum) KITH_FAIL(BAD_FILE, "%s: damaged: checksum of '%s'", c->path, s->name);
  }
  return KITH_OK;
}

/* Without the padding. */
static kith_status read_section(struct kith_checkpoint *c, const struct section *s, void *data) {
  uint64_t offset = sizeof c->header;
  for (const struct section *t = c->section; t < s; ++t) offset += t->bytes;
  return read_at(c, offset, data, s->rows * s->components * type_size(s->type));
}

static const char *type_name(uint32_t type) {
  return type == KITH_F64 ? "f64" : type == KITH_I64 ? "i64" : "u8";
}

/* The section of this name and shape; rows SIZE_MAX: any number. */
static kith_status expect(const struct kith_checkpoint *c, const struct section **out, enum group group,
                          const char *name, uint32_t type, size_t components, size_t rows) {
  const struct section *s = find(c, group, name);
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
  KITH_TRY(create(out, path));
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
  KITH_TRY(kith_nodes_delete(nodes, NULL));
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
      KITH_TRY(read_section(c, find(c, GROUP_FIELD, nodes->fields[f]->spec.name), nodes->fields[f]->data));
  return KITH_OK;
}

size_t kith_checkpoint_length(const struct kith_checkpoint *c, const char *name) {
  const struct section *s = find(c, GROUP_ARRAY, name);
  return s == NULL ? SIZE_MAX : (size_t)s->rows;
}

kith_status kith_checkpoint_get(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                void *values, size_t n) {
  const struct section *s = NULL;
  KITH_TRY(expect(c, &s, GROUP_ARRAY, name, type, 1, n));
  return read_section(c, s, values);
}
