/* checkpoint.c - the file of a checkpoint. Rank 0 writes it section by section; in reading everything is
 * verified before anything is used, and no rank has more of it in memory than its own nodes. */
#include "lib/io/checkpoint.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "lib/io/atomic_file.h"
#include "lib/nodes/migrate.h"

#define MAGIC "kithckpt"
enum { MARK = 0x01020304, VERSION = 6, CHUNK = 1 << 18, MOST_COMPONENTS = 64 };
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
/* A section, and where its values begin. */
struct entry {
  struct section head;
  size_t at;
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
  struct kith_ranks *ranks; /* reading; NULL: this process alone. Borrowed */
  int fd;                   /* the file to read, and its size; -1: not open */
  size_t size;
  int n_entries;
  size_t capacity;
  struct entry *entry;                     /* owned */
  struct stored_list part[KITH_MAX_LISTS]; /* the stored nodes of each list that this rank took */
  char *scene;                             /* owned */
  char chunk[CHUNK];                       /* of the file, or values of other ranks */
  char path[];
};

/* Checksum of the words of block `number`. Each word changes h by a one-to-one function, so two blocks that
 * differ in one word never agree. Start and multiplier are those of 64-bit FNV; the shift carries high bits
 * down. */
static uint64_t checksum_of(const char *data, size_t bytes, size_t number) {
  uint64_t h = UINT64_C(0xcbf29ce484222325) + number;
  for (size_t k = 0; k < bytes; k += 8) {
    uint64_t word;
    memcpy(&word, data + k, 8);
    h = (h ^ word) * UINT64_C(0x100000001b3);
    h ^= h >> 29;
  }
  return h;
}

/* Bytes of the values of a section. */
static size_t bytes_of(const struct section *s) {
  return s->rows * s->components * (s->type == KITH_U8 ? 1 : 8);
}

/* Bytes in whole words. */
static size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

void kith_checkpoint_close(struct kith_checkpoint **c) {
  if (*c == NULL) return;
  kith_atomic_file_abandon(&(*c)->out);
  if ((*c)->fd >= 0) close((*c)->fd);
  KITH_FREE(&(*c)->entry, &(*c)->scene);
  kith_free(c);
}

static kith_status create(struct kith_checkpoint **out, const char *path) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out + strlen(path) + 1));
  strcpy((*out)->path, path);
  (*out)->fd = -1;
  return KITH_OK;
}

static kith_status open_file(struct kith_checkpoint *c, const char *path) {
  struct stat present = {0};
  c->fd = open(path, O_RDONLY | O_CLOEXEC);
  if (c->fd < 0 || fstat(c->fd, &present) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, strerror(errno));
  if (!S_ISREG(present.st_mode)) KITH_FAIL(BAD_FILE, "%s: not a regular file", c->path);
  c->size = (size_t)present.st_size;
  return KITH_OK;
}

static kith_status read_at(const struct kith_checkpoint *c, size_t at, void *data, size_t bytes) {
  for (size_t done = 0; done < bytes;) {
    const ssize_t n = pread(c->fd, (char *)data + done, bytes - done, (off_t)(at + done));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      KITH_FAIL(BAD_FILE, "%s: cannot read: %s", c->path, n < 0 ? strerror(errno) : "it was cut short");
    done += (size_t)n;
  }
  return KITH_OK;
}

/* Checksum of the first `bytes` of the file: the sum over blocks, of which each rank reads its share. */
static kith_status checksum(struct kith_checkpoint *c, size_t bytes, uint64_t *sum) {
  const size_t size = (size_t)kith_ranks_size(c->ranks);
  kith_status status = KITH_OK;
  *sum = 0;
  for (size_t k = (size_t)kith_ranks_rank(c->ranks); k * CHUNK < bytes && status == KITH_OK; k += size) {
    const size_t n = KITH_MIN(bytes - k * CHUNK, (size_t)CHUNK);
    status = read_at(c, k * CHUNK, c->chunk, n);
    *sum += checksum_of(c->chunk, n, k);
  }
  KITH_TRY(kith_ranks_allreduce_status(c->ranks, status));
  kith_ranks_sum_counts(c->ranks, sum, 1);
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

/* Returns the number of nodes of a list on all ranks. counts[rank][list] */
static size_t sum_of(const struct kith_nodes *nodes, const int64_t *counts, int list) {
  size_t sum = 0;
  for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) sum += (size_t)counts[r * nodes->n_lists + list];
  return sum;
}

/* Writes a field: nodes list by list, rank by rank. Those of other ranks come to rank 0 piece by piece. It
 * receives all of them even if it has failed, since the others wait until they have sent. */
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

/* Appends the checksum, of the file as it is read back, and commits. */
static kith_status finish(struct kith_checkpoint *c) {
  if (c->status != KITH_OK) KITH_FAIL(BAD_FILE, "%s: not written: an earlier part of it failed", c->path);
  if (fflush(c->out->stream) != 0) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", c->path, strerror(errno));
  uint64_t sum;
  KITH_TRY(open_file(c, c->out->temporary));
  KITH_TRY(checksum(c, c->size, &sum));
  write_bytes(c, &sum, sizeof sum);
  return c->status == KITH_OK ? kith_atomic_file_commit(&c->out, true) : c->status;
}

kith_status kith_checkpoint_commit(struct kith_checkpoint **c) {
  const kith_status status = finish(*c);
  kith_checkpoint_close(c);
  return status;
}

/* ---- reading ---- */

static kith_status read_header(struct kith_checkpoint *c, const char *path, struct header *h) {
  KITH_TRY(open_file(c, path));
  if (c->size >= sizeof *h + 8) KITH_TRY(read_at(c, 0, h, sizeof *h));
  if (c->size < sizeof *h + 8 || memcmp(h->magic, MAGIC, sizeof h->magic) != 0)
    KITH_FAIL(BAD_FILE, "%s: not a checkpoint", c->path);
  if (h->mark != MARK) KITH_FAIL(BAD_FILE, "%s: written by a machine of another byte order", c->path);
  if (h->version != VERSION)
    KITH_FAIL(BAD_FILE, "%s: checkpoint version %u, this program reads %d", c->path, h->version, VERSION);
  return KITH_OK;
}

static kith_status verify(struct kith_checkpoint *c, const struct header *h) {
  uint64_t sum = 0, stored = 0;
  KITH_TRY(checksum(c, (c->size - 8) / 8 * 8, &sum));
  KITH_TRY(read_at(c, c->size - 8, &stored, sizeof stored));
  if (c->size % 8 != 0 || sum != stored)
    KITH_FAIL(BAD_FILE, "%s: damaged or cut short: its checksum is wrong", c->path);
  if (h->dimension != NDIM)
    KITH_FAIL(BAD_INPUT, "%s: a %u-D checkpoint, this program is %d-D", c->path, h->dimension, NDIM);
  return KITH_OK;
}

/* Is it a section that ends before the checksum? `left`: bytes from its beginning to the checksum. */
static bool is_section(const struct section *s, size_t left) {
  if (memchr(s->name, '\0', sizeof s->name) == NULL || s->name[0] == '\0') return false;
  return s->group <= GROUP_ARRAY && s->type <= KITH_U8 && s->components > 0 &&
         s->components <= MOST_COMPONENTS && s->rows <= left && bytes_of(s) <= left - sizeof *s;
}

static kith_status read_contents(struct kith_checkpoint *c) {
  for (size_t at = sizeof(struct header), left; (left = c->size - 8 - at) > 0;) {
    struct entry e = {.at = at + sizeof e.head};
    if (left >= sizeof e.head) KITH_TRY(read_at(c, at, &e.head, sizeof e.head));
    if (left < sizeof e.head || !is_section(&e.head, left))
      KITH_FAIL(BAD_FILE, "%s: damaged: its sections do not fill it", c->path);
    KITH_TRY(kith_grow(&c->entry, &c->capacity, (size_t)c->n_entries, (size_t)c->n_entries + 1, sizeof e));
    c->entry[c->n_entries++] = e;
    at = e.at + padded(bytes_of(&e.head));
  }
  return KITH_OK;
}

/* Finds a section by its name; NULL if there is none. */
static const struct entry *find(const struct kith_checkpoint *c, enum group group, const char *name) {
  for (const struct entry *e = c->entry; e < c->entry + c->n_entries; ++e)
    if (e->head.group == group && strcmp(e->head.name, name) == 0) return e;
  return NULL;
}

static kith_status read_values(const struct kith_checkpoint *c, const struct entry *e, void *data) {
  return read_at(c, e->at, data, bytes_of(&e->head));
}

/* Finds the section of this name, which must have this shape; rows SIZE_MAX: any number of rows. */
static kith_status expect(const struct kith_checkpoint *c, const struct entry **out, enum group group,
                          const char *name, uint32_t type, size_t components, size_t rows) {
  const struct entry *e = find(c, group, name);
  if (e == NULL) KITH_FAIL(BAD_FILE, "%s: '%s' is missing", c->path, name);
  const struct section *s = &e->head;
  if (s->type != type || s->components != components || (rows != SIZE_MAX && s->rows != rows))
    KITH_FAIL(BAD_FILE, "%s: '%s' has not the type and the size that this scene gives it", c->path, name);
  *out = e;
  return KITH_OK;
}

static kith_status read_scene(struct kith_checkpoint *c) {
  const struct entry *e = NULL;
  KITH_TRY(expect(c, &e, GROUP_SCENE, "scene", KITH_U8, 1, SIZE_MAX));
  KITH_TRY(kith_resize(&c->scene, 0, e->head.rows + 1, 1));
  return read_values(c, e, c->scene);
}

static kith_status open_verified(struct kith_checkpoint **out, const char *path, struct kith_ranks *ranks) {
  struct header header = {0};
  kith_status status = create(out, path);
  if (status == KITH_OK) status = read_header(*out, path, &header);
  KITH_TRY(kith_ranks_allreduce_status(ranks, status));
  struct kith_checkpoint *c = *out;
  c->ranks = ranks;
  KITH_TRY(kith_ranks_allreduce_status(ranks, verify(c, &header)));
  status = read_contents(c);
  if (status == KITH_OK) status = read_scene(c);
  return kith_ranks_allreduce_status(ranks, status);
}

kith_status kith_checkpoint_open(struct kith_checkpoint **out, const char *path, struct kith_ranks *ranks) {
  const kith_status status = open_verified(out, path, ranks);
  if (status != KITH_OK) kith_checkpoint_close(out);
  return status;
}

const char *kith_checkpoint_scene(const struct kith_checkpoint *c) {
  return c->scene;
}

/* Reads the stored lists, and checks that they are those of `nodes`, one behind the other. */
static kith_status read_lists(struct kith_checkpoint *c, const struct kith_nodes *nodes, size_t *total) {
  const struct entry *e = NULL;
  struct stored_list *lists = c->part;
  KITH_TRY(expect(c, &e, GROUP_LISTS, "lists", KITH_U8, sizeof *lists, SIZE_MAX));
  if (e->head.rows != (size_t)nodes->n_lists)
    KITH_FAIL(BAD_INPUT, "%s: it has %llu node lists, the scene %d", c->path,
              (unsigned long long)e->head.rows, nodes->n_lists);
  KITH_TRY(read_values(c, e, lists));
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

/* Reduces c->part to the nodes that this rank takes of each list: those that it had by counts[rank][list], or
 * an equal part if that is NULL. */
static kith_status take_part(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                             const int64_t *counts) {
  const int me = kith_ranks_rank(c->ranks), size = kith_ranks_size(c->ranks);
  for (int l = 0; l < nodes->n_lists; ++l) {
    struct stored_list *part = &c->part[l];
    const int64_t all = part->count;
    int64_t begin = all * me / size, end = all * (me + 1) / size, sum = 0;
    for (int r = 0; counts != NULL && r < size; ++r) {
      const int64_t count = counts[r * nodes->n_lists + l];
      if (count < 0 || count > all - sum)
        KITH_FAIL(BAD_FILE, "%s: damaged: how many nodes its ranks had", c->path);
      if (r == me) begin = sum, end = sum + count;
      sum += count;
    }
    if (counts != NULL && sum != all)
      KITH_FAIL(BAD_FILE, "%s: damaged: how many nodes its ranks had", c->path);
    part->first += begin, part->count = end - begin;
  }
  return KITH_OK;
}

/* Checks that the file has every field that lasts, with its shape, and no other field. */
static kith_status match_fields(const struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                size_t total) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const struct kith_field *field = nodes->fields[f];
    const struct entry *e = NULL;
    if (!kith_field_lasts(nodes, field)) continue;
    KITH_TRY(
        expect(c, &e, GROUP_FIELD, field->spec.name, field->spec.type, (size_t)field->components, total));
  }
  for (const struct entry *e = c->entry; e < c->entry + c->n_entries; ++e) {
    const struct kith_field *field =
        e->head.group == GROUP_FIELD ? kith_nodes_field_named(nodes, e->head.name) : NULL;
    if (e->head.group == GROUP_FIELD && (field == NULL || !kith_field_lasts(nodes, field)))
      KITH_FAIL(BAD_FILE, "%s: it has the field '%s', which this scene does not use", c->path, e->head.name);
  }
  return KITH_OK;
}

static kith_status replace_nodes(struct kith_nodes *nodes, const struct stored_list *part) {
  KITH_TRY(kith_nodes_delete(nodes, NULL));
  for (int l = 0; l < nodes->n_lists; ++l)
    if (part[l].count > 0) KITH_TRY(kith_nodes_append(nodes, l, (kith_index)part[l].count, NULL));
  ++nodes->positions;
  return KITH_OK;
}

static kith_status read_part(const struct kith_checkpoint *c, const struct kith_nodes *nodes,
                             const struct kith_field *field, const struct entry *e) {
  const size_t size = kith_field_node_size(field);
  for (int l = 0; l < nodes->n_lists; ++l)
    KITH_TRY(read_at(c, e->at + (size_t)c->part[l].first * size,
                     (char *)field->data + (size_t)nodes->lists[l].first * size,
                     (size_t)c->part[l].count * size));
  return KITH_OK;
}

kith_status kith_checkpoint_nodes(struct kith_checkpoint *c, struct kith_nodes *nodes,
                                  const int64_t *counts) {
  size_t total = 0;
  KITH_TRY(read_lists(c, nodes, &total));
  KITH_TRY(match_fields(c, nodes, total));
  KITH_TRY(take_part(c, nodes, counts));
  KITH_TRY(replace_nodes(nodes, c->part));
  for (int f = 0; f < nodes->n_fields; ++f)
    if (kith_field_lasts(nodes, nodes->fields[f]))
      KITH_TRY(read_part(c, nodes, nodes->fields[f], find(c, GROUP_FIELD, nodes->fields[f]->spec.name)));
  return KITH_OK;
}

kith_status kith_checkpoint_get_field(struct kith_checkpoint *c, const struct kith_nodes *nodes,
                                      const struct kith_field *field) {
  const struct entry *e = NULL, *id = NULL;
  KITH_TRY(expect(c, &id, GROUP_FIELD, "id", KITH_I64, 1, SIZE_MAX));
  KITH_TRY(expect(c, &e, GROUP_ARRAY, field->spec.name, field->spec.type, 1, id->head.rows));
  return read_part(c, nodes, field, e);
}

size_t kith_checkpoint_length(const struct kith_checkpoint *c, const char *name) {
  const struct entry *e = find(c, GROUP_ARRAY, name);
  return e == NULL ? SIZE_MAX : (size_t)e->head.rows;
}

kith_status kith_checkpoint_get(struct kith_checkpoint *c, const char *name, enum kith_type type,
                                void *values, size_t n) {
  const struct entry *e = NULL;
  KITH_TRY(expect(c, &e, GROUP_ARRAY, name, type, 1, n));
  return read_values(c, e, values);
}
