/* Packing, sending and unpacking of nodes; copies of all nodes ordered by id. */
#include "lib/nodes/migrate.h"

#include <math.h>
#include <string.h>

/* A packed node: its fields, one after the other, each padded to 8-byte words. */
static size_t words_of(const struct kith_nodes *nodes) {
  size_t words = 0;
  for (int f = 0; f < nodes->n_fields; ++f) words += (kith_field_node_size(nodes->fields[f]) + 7) / 8;
  return words;
}

static void load_node(const struct kith_nodes *nodes, kith_index i, int64_t *to) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const size_t size = kith_field_node_size(nodes->fields[f]);
    to[(size - 1) / 8] = 0;
    memcpy(to, (const char *)nodes->fields[f]->data + (size_t)i * size, size);
    to += (size + 7) / 8;
  }
}

static void unload(struct kith_nodes *nodes, kith_index i, const int64_t *from) {
  for (int f = 0; f < nodes->n_fields; ++f) {
    const size_t size = kith_field_node_size(nodes->fields[f]);
    memcpy((char *)nodes->fields[f]->data + (size_t)i * size, from, size);
    from += (size + 7) / 8;
  }
}

/* Nodes to send and to receive: counts [rank][list], and packed nodes in this order. */
struct transport {
  size_t words, n_counts; /* of a node; ranks times lists */
  int64_t *to, *from;     /* [n_counts] */
  int64_t *out, *in;      /* words */
  int64_t n_out, n_in;    /* nodes */
  struct kith_message *message;
};

static void transport_clear(struct transport *t) {
  KITH_FREE(&t->to, &t->from, &t->out, &t->in, &t->message);
}

/* Fills `out` rank by rank, list by list, node by node; nodes with to[i] == stay, this rank, are left out. */
static kith_status load_all(struct transport *t, const struct kith_nodes *nodes, const int32_t *to,
                            int stay) {
  int64_t *place = NULL;
  const size_t size = (size_t)kith_ranks_size(nodes->ranks), lists = (size_t)nodes->n_lists;
  t->n_counts = size * lists, t->words = words_of(nodes);
  KITH_TRY(kith_resize(&t->to, 0, t->n_counts, sizeof *t->to));
  KITH_TRY(kith_resize(&t->from, 0, t->n_counts, sizeof *t->from));
  KITH_TRY(kith_resize(&t->message, 0, 2 * size, sizeof *t->message));
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (to[i] != stay) ++t->to[(size_t)to[i] * lists + nodes->list->u8[i]];
  KITH_TRY(kith_resize(&place, 0, t->n_counts, sizeof *place));
  for (size_t k = 0; k < t->n_counts; ++k) place[k] = t->n_out, t->n_out += t->to[k];
  const kith_status status = kith_resize(&t->out, 0, (size_t)t->n_out * t->words, sizeof *t->out);
  for (kith_index i = 0; status == KITH_OK && i < nodes->n_internal; ++i)
    if (to[i] != stay)
      load_node(nodes, i, t->out + (size_t)place[(size_t)to[i] * lists + nodes->list->u8[i]]++ * t->words);
  kith_free(&place);
  return status;
}

/* Messages to or from all ranks: parts of the packed nodes. */
static void fill_messages(const struct transport *t, int size, const int64_t *count, int64_t *data,
                          struct kith_message *message) {
  const int lists = (int)t->n_counts / size;
  for (int r = 0; r < size; ++r) {
    size_t words = 0;
    for (int l = 0; l < lists; ++l) words += (size_t)count[r * lists + l] * t->words;
    message[r] = (struct kith_message){r, data, words * sizeof *data};
    if (words > 0) data += words;
  }
}

/* ---- migration ---- */

static kith_status remove_leaving(struct kith_nodes *nodes, const int32_t *to, int me) {
  uint8_t *gone = NULL;
  KITH_TRY(kith_resize(&gone, 0, (size_t)nodes->n_internal, 1));
  for (kith_index i = 0; i < nodes->n_internal; ++i) gone[i] = to[i] != me;
  const kith_status status = kith_nodes_delete(nodes, gone);
  kith_free(&gone);
  return status;
}

/* Appends the nodes that came to their lists, rank by rank. */
static kith_status unpack_arrivals(const struct transport *t, struct kith_nodes *nodes) {
  const size_t lists = (size_t)nodes->n_lists;
  for (size_t l = 0; l < lists; ++l) {
    int64_t count = 0;
    kith_index place;
    for (size_t k = l; k < t->n_counts; k += lists) count += t->from[k];
    if (count > INT32_MAX)
      KITH_FAIL(UNSUPPORTED, "%lld nodes of one list move to one rank", (long long)count);
    KITH_TRY(kith_nodes_append(nodes, (int)l, (kith_index)count, &place));
    const int64_t *at = t->in;
    for (size_t k = 0; k < t->n_counts; ++k) /* `at` passes over all lists of all ranks */
      for (int64_t n = 0; n < t->from[k]; ++n, at += t->words)
        if (k % lists == l) unload(nodes, place++, at);
  }
  return KITH_OK;
}

static kith_status migrate(struct transport *t, struct kith_nodes *nodes, const int32_t *to, int n_neighbors,
                           const int32_t *neighbor) {
  struct kith_ranks *ranks = nodes->ranks;
  const int me = kith_ranks_rank(ranks), size = kith_ranks_size(ranks);
  KITH_TRY(kith_ranks_must(ranks, load_all(t, nodes, to, me)));
  kith_ranks_tell(ranks, n_neighbors, neighbor, t->to, t->from, nodes->n_lists);
  for (size_t k = 0; k < t->n_counts; ++k) t->n_in += t->from[k];
  KITH_TRY(kith_ranks_must(ranks, kith_resize(&t->in, 0, (size_t)t->n_in * t->words, sizeof *t->in)));
  struct kith_message *in = t->message + size;
  fill_messages(t, size, t->to, t->out, t->message);
  fill_messages(t, size, t->from, t->in, in);
  KITH_TRY(kith_ranks_must(ranks, kith_ranks_exchange(ranks, size, t->message, size, in)));
  if (t->n_out > 0) KITH_TRY(remove_leaving(nodes, to, me));
  if (t->n_in > 0) ++nodes->positions;
  return t->n_in > 0 ? unpack_arrivals(t, nodes) : KITH_OK;
}

kith_status kith_nodes_migrate(struct kith_nodes *nodes, const int32_t *to, int n_neighbors,
                               const int32_t *neighbor, uint64_t *moved) {
  struct transport t = {0};
  kith_nodes_drop_ghosts(nodes);
  const kith_status status = migrate(&t, nodes, to, n_neighbors, neighbor);
  if (moved != NULL) *moved = (uint64_t)t.n_out;
  transport_clear(&t);
  return status;
}

/* ---- copies ---- */

kith_status kith_nodes_counts(const struct kith_nodes *nodes, int64_t **counts) {
  int64_t mine[KITH_MAX_LISTS];
  for (int l = 0; l < nodes->n_lists; ++l) mine[l] = nodes->lists[l].count;
  char *all = NULL;
  const kith_status status =
      kith_ranks_gather(nodes->ranks, mine, (size_t)nodes->n_lists * sizeof *mine, &all, NULL);
  *counts = (int64_t *)all;
  return status;
}

kith_status kith_nodes_all_left(struct kith_ranks *ranks, uint64_t before, uint64_t after) {
  if (after == before) return KITH_OK;
  return kith_ranks_allreduce_status(ranks,
                                     kith_fail(KITH_INTERNAL, "of %llu nodes %llu are left after a migration",
                                               (unsigned long long)before, (unsigned long long)after));
}

kith_status kith_nodes_sort_by_id(struct kith_nodes *nodes) {
  return kith_nodes_sort(nodes, (const uint64_t *)nodes->id->i64, NULL);
}

/* Divides the range of all ids into a part for each rank, and sends each node to the rank of its part. */
static kith_status send_by_id(struct kith_nodes *copy) {
  const int parts = kith_ranks_size(copy->ranks);
  const int64_t *id = copy->id->i64;
  double ends[2] = {-INFINITY, -INFINITY}; /* minus the smallest, the largest */
  int32_t *to = NULL;
  for (kith_index i = 0; i < copy->n_internal; ++i) {
    ends[0] = KITH_MAX(ends[0], -(double)id[i]);
    ends[1] = KITH_MAX(ends[1], (double)id[i]);
  }
  kith_ranks_max(copy->ranks, ends, 2);
  const double width = (ends[0] + ends[1] + 1) / parts;
  KITH_TRY(
      kith_ranks_allreduce_status(copy->ranks, kith_resize(&to, 0, (size_t)copy->n_internal, sizeof *to)));
  for (kith_index i = 0; i < copy->n_internal; ++i)
    to[i] = KITH_MIN((int32_t)(((double)id[i] + ends[0]) / width), parts - 1);
  uint64_t count[] = {(uint64_t)copy->n_internal, 0};
  const kith_status status = kith_nodes_migrate(copy, to, 0, NULL, NULL);
  kith_free(&to);
  count[1] = (uint64_t)copy->n_internal;
  KITH_TRY(kith_ranks_agree(copy->ranks, status, 1, &(struct kith_shared){KITH_SHARE_SUM, 2, count}));
  return kith_nodes_all_left(copy->ranks, count[0], count[1]);
}

kith_status kith_nodes_by_id(const struct kith_nodes *nodes, struct kith_nodes **out) {
  *out = NULL;
  kith_status status = kith_ranks_allreduce_status(nodes->ranks, kith_nodes_copy(out, nodes, false));
  if (status == KITH_OK) (*out)->ranks = nodes->ranks;
  if (status == KITH_OK && nodes->ranks != NULL) status = send_by_id(*out);
  if (status == KITH_OK) status = kith_ranks_allreduce_status(nodes->ranks, kith_nodes_sort_by_id(*out));
  if (status != KITH_OK) kith_nodes_destroy(out);
  return status;
}
