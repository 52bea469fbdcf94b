/* checkpoint.c - the file of a checkpoint. Rank 0 writes it section by section; in reading everything is
 * verified before anything is used. */
#include "lib/io/checkpoint.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include "lib/io/atomic_file.h"
#include "lib/nodes/migrate.h"

#define MAGIC "kithckpt"
enum { MARK = 0x01020304, VERSION = 2, CHUNK = 1 << 18, MOST_COMPONENTS = 64 };
enum group { GROUP_SCENE, GROUP_LISTS, GROUP_FIELD, GROUP_ARRAY };

struct header {
  char magic[8];
  uint32_t mark, version, dimension, zero;
};
struct section {
  char name[56];
  uint32_t group, type;
  uint64_t components, rows;
};
struct stored_list {
  char name[32];
  int64_t first, count;
};
_Static_assert(sizeof(struct header) == 24, "the header is 24 bytes");
_Static_assert(sizeof(struct section) == 80, "the head of a section is 80 bytes");
_Static_assert(sizeof(struct stored_list) == 48, "a list is 48 bytes");
_Static_assert(sizeof(struct kith_node_list) == 40, "a new member of a list must be added to stored_list");

struct kith_checkpoint {
  struct kith_atomic_file *out; /* writing */
  kith_status status; /* of writing: after a failure nothing more is written, and it cannot be committed */
  char *map;          /* the whole file, once it is there */
  size_t size;
  char *scene;       /* owned */
  char chunk[CHUNK]; /* values of other ranks */
  char path[];
};

/* Checksum of whole words. Each enters through one-to-one functions of h, so two files that differ in one
 * word never agree. Start and multiplier: those of 64-bit FNV; the shift carries high bits down. */
static uint64_t checksum(const char *data, size_t bytes) {
  uint64_t h = UINT64_C(0xcbf29ce484222325);
  for (size_t k = 0; k < bytes; k += 8) {
    uint64_t word;
    memcpy(&word, data + k, 8);
    h = (h ^ word) * UINT64_C(0x100000001b3);
    h ^= h >> 29;
  }
  return h;
}

/* Bytes of the values of a section, and with the zeros behind them. */
static size_t bytes_of(const struct section *s) {
  return s->rows * s->components * (s->type == KITH_U8 ? 1 : 8);
}

static size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

void kith_checkpoint_close(struct kith_checkpoint **c) {
  if (*c == NULL) return;
  kith_atomic_file_abandon(&(*c)->out);
  if ((*c)->map != NULL) munmap((*c)->map, (*c)->size);
  kith_free(&(*c)->scene);
  kith_free(c);
}

static kith_status create(struct kith_checkpoint **out, const char *path) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + strlen(path) + 1));
  strcpy((*out)->path, path);
  return KITH_OK;
}

/* ---- writing ---- */

static void write_bytes(struct kith_checkpoint *c, const void *data, size_t bytes) {
  if (c->status != KITH_OK || bytes == 0) return;
  if (fwrite(data, 1, bytes, c->out->stream) != bytes)
    c->status = kith_fail(KITH_BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
}

static struct section begin_section(struct kith_checkpoint *c, enum group group, const char *name,
                                    enum kith_type type, size_t components, size_t rows) {
  struct section s = {.group = group, .type = type, .components = components, .rows = rows};
  if (name[0] == '\0' || strlen(name) >= sizeof s.name)
    c->status = kith_fail(KITH_INTERNAL, "checkpoint: '%s' is too long a name, or empty", name);
  snprintf(s.name, sizeof s.name, "%s", name);
  write_bytes(c, &s, sizeof s);
  return s;
}

static kith_status end_section(struct kith_checkpoint *c, const struct section *s) {
  write_bytes(c, (const char[8]){0}, padded(bytes_of(s)) - bytes_of(s));
  return c->status;
}

static kith_status put(struct kith_checkpoint *c, enum group group, const char *name, enum kith_type type,
                       size_t components, size_t rows, const void *data) {
  const struct section s = begin_section(c, group, name, type, components, rows);
  write_bytes(c, data, bytes_of(&s));
  return end_section(c, &s);
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
  struct section s;
  for (int l = 0; l < nodes->n_lists; ++l) rows += sum_of(nodes, counts, l);
  if (c != NULL)
    s = begin_section(c, group, field->spec.name, field->spec.type, (size_t)field->components, rows);
  for (int l = 0; l < nodes->n_lists; ++l)
    for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) {
      char *mine = (char *)field->data + (size_t)nodes->lists[l].first * size;
      size_t bytes = me == 0 || me == r ? (size_t)counts[r * nodes->n_lists + l] * size : 0;
      for (size_t n; bytes > 0; bytes -= n, mine += n) {
        char *piece = me == r ? mine : c->chunk;
        n = KITH_MIN(bytes, (size_t)CHUNK);
        kith_ranks_send_to_root(nodes->ranks, r, piece, n);
        if (me == 0) write_bytes(c, piece, n);
      }
    }
  return c != NULL ? end_section(c, &s) : KITH_OK;
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
    if (!kith_field_lasts(nodes, nodes->fields[f])) continue;
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
  const struct header header = {.magic = MAGIC, .mark = MARK, .version = VERSION, .dimension = NDIM};
  KITH_TRY(create(out, path));
  struct kith_checkpoint *c = *out;
  c->status = kith_atomic_file_open(&c->out, path);
  write_bytes(c, &header, sizeof header);
  const kith_status status = put(c, GROUP_SCENE, "scene", KITH_U8, 1, strlen(scene), scene);
  if (status != KITH_OK) kith_checkpoint_close(out);
  return status;
}

kith_status kith_checkpoint_put(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                const void *values, size_t n) {
  return put(c, GROUP_ARRAY, name, type, 1, n, values);
}

static kith_status map_file(struct kith_checkpoint *c, const char *path) {
  struct stat present;
  const int fd = open(path, O_RDONLY | O_CLOEXEC);
  const bool there = fd >= 0 && fstat(fd, &present) == 0, regular = there && S_ISREG(present.st_mode);
  const size_t size = regular ? (size_t)present.st_size : 0;
  void *map = size > 0 ? mmap(NULL, size, PROT_READ, MAP_PRIVATE, fd, 0) : NULL;
  const int why = errno;
  if (fd >= 0) close(fd);
  if (!there || map == MAP_FAILED) KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, strerror(why));
  if (!regular) KITH_FAIL(BAD_FILE, "%s: not a regular file", c->path);
  c->map = map, c->size = size;
  return KITH_OK;
}

/* The checksum is that of the file as it can be read. */
static kith_status finish(struct kith_checkpoint *c) {
  if (c->status != KITH_OK) KITH_FAIL(BAD_FILE, "%s: not written: an earlier part of it failed", c->path);
  if (fflush(c->out->stream) != 0) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
  KITH_TRY(map_file(c, c->out->temporary));
  const uint64_t sum = checksum(c->map, c->size);
  write_bytes(c, &sum, sizeof sum);
  return c->status == KITH_OK ? kith_atomic_file_commit(&c->out, true) : c->status;
}

kith_status kith_checkpoint_commit(struct kith_checkpoint **c) {
  const kith_status status = finish(*c);
  kith_checkpoint_close(c);
  return status;
}

/* ---- reading ---- */

/* The section behind s, or the first one of s is NULL; NULL: there is none. */
static const struct section *next_section(const struct kith_checkpoint *c, const struct section *s) {
  const char *at = s != NULL ? (const char *)(s + 1) + padded(bytes_of(s)) : c->map + sizeof(struct header);
  return at < c->map + c->size - 8 ? (const void *)at : NULL;
}

/* Is it a section that ends before the checksum? */
static bool is_section(const struct kith_checkpoint *c, const struct section *s) {
  const size_t left = (size_t)(c->map + c->size - 8 - (const char *)s);
  if (left < sizeof *s || memchr(s->name, '\0', sizeof s->name) == NULL || s->name[0] == '\0') return false;
  return s->group <= GROUP_ARRAY && s->type <= KITH_U8 && s->components > 0 &&
         s->components <= MOST_COMPONENTS && s->rows <= left && bytes_of(s) <= left - sizeof *s;
}

static kith_status verify(struct kith_checkpoint *c) {
  const struct header *h = (const void *)c->map;
  uint64_t sum = 0;
  if (c->size < sizeof *h + 8 || memcmp(h->magic, MAGIC, sizeof h->magic) != 0)
    KITH_FAIL(BAD_FILE, "%s: not a checkpoint", c->path);
  if (h->mark != MARK) KITH_FAIL(BAD_FILE, "%s: written by a machine of another byte order", c->path);
  if (h->version != VERSION)
    KITH_FAIL(BAD_FILE, "%s: checkpoint version %u, this program reads %d", c->path, h->version, VERSION);
  memcpy(&sum, c->map + c->size - 8, 8);
  if (c->size % 8 != 0 || sum != checksum(c->map, c->size - 8))
    KITH_FAIL(BAD_FILE, "%s: damaged or cut short: its checksum is wrong", c->path);
  if (h->dimension != NDIM)
    KITH_FAIL(BAD_INPUT, "%s: a %u-D checkpoint, this program is %d-D", c->path, h->dimension, NDIM);
  for (const struct section *s = next_section(c, NULL); s != NULL; s = next_section(c, s))
    if (!is_section(c, s)) KITH_FAIL(BAD_FILE, "%s: damaged: its sections do not fill it", c->path);
  return KITH_OK;
}

/* NULL if there is none. */
static const struct section *find(const struct kith_checkpoint *c, enum group group, const char *name) {
  const struct section *s = next_section(c, NULL);
  while (s != NULL && !(s->group == group && strcmp(s->name, name) == 0)) s = next_section(c, s);
  return s;
}

static void read_section(const struct section *s, void *data) {
  if (bytes_of(s) > 0) memcpy(data, s + 1, bytes_of(s));
}

/* The section of this name and shape; rows SIZE_MAX: any number. */
static kith_status expect(const struct kith_checkpoint *c, const struct section **out, enum group group,
                          const char *name, uint32_t type, size_t components, size_t rows) {
  const struct section *s = find(c, group, name);
  if (s == NULL) KITH_FAIL(BAD_FILE, "%s: '%s' is missing", c->path, name);
  if (s->type != type || s->components != components || (rows != SIZE_MAX && s->rows != rows))
    KITH_FAIL(BAD_FILE, "%s: '%s' has not the type and the size that this scene gives it", c->path, name);
  *out = s;
  return KITH_OK;
}

static kith_status read_scene(struct kith_checkpoint *c) {
  const struct section *s = NULL;
  KITH_TRY(expect(c, &s, GROUP_SCENE, "scene", KITH_U8, 1, SIZE_MAX));
  KITH_TRY(kith_resize(&c->scene, 0, s->rows + 1, 1));
  read_section(s, c->scene);
  return KITH_OK;
}

kith_status kith_checkpoint_open(struct kith_checkpoint **out, const char *path) {
  KITH_TRY(create(out, path));
  kith_status status = map_file(*out, path);
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
  read_section(s, lists);
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
    if (!kith_field_lasts(nodes, field)) continue;
    KITH_TRY(
        expect(c, &s, GROUP_FIELD, field->spec.name, field->spec.type, (size_t)field->components, total));
  }
  for (const struct section *s = next_section(c, NULL); s != NULL; s = next_section(c, s)) {
    const struct kith_field *field = s->group == GROUP_FIELD ? kith_nodes_field_named(nodes, s->name) : NULL;
    if (s->group == GROUP_FIELD && (field == NULL || !kith_field_lasts(nodes, field)))
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
    if (kith_field_lasts(nodes, nodes->fields[f]))
      read_section(find(c, GROUP_FIELD, nodes->fields[f]->spec.name), nodes->fields[f]->data);
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
  read_section(s, values);
  return KITH_OK;
}
