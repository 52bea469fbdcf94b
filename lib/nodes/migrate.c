/* Packing, sending and unpacking of nodes; copies of all nodes ordered by id. */
#include "lib/nodes/migrate.h"

#include <string.h>

/* A packed node: its fields, one after the other, each padded to 8-byte words. */
struct layout {
  int n_fields;
  struct kith_field *field[KITH_MAX_FIELDS]; /* borrowed */
  size_t words;
};

static void add_field(struct layout *layout, struct kith_field *field) {
  layout->field[layout->n_fields++] = field;
  layout->words += (kith_field_node_size(field) + 7) / 8;
}

static void load(const struct layout *layout, kith_index i, int64_t *to) {
  for (int f = 0; f < layout->n_fields; ++f) {
    const size_t size = kith_field_node_size(layout->field[f]);
    to[(size - 1) / 8] = 0;
    memcpy(to, (const char *)layout->field[f]->data + (size_t)i * size, size);
    to += (size + 7) / 8;
  }
}

static void unload(const struct layout *layout, kith_index i, const int64_t *from) {
  for (int f = 0; f < layout->n_fields; ++f) {
    const size_t size = kith_field_node_size(layout->field[f]);
    memcpy((char *)layout->field[f]->data + (size_t)i * size, from, size);
    from += (size + 7) / 8;
  }
}

/* Nodes to send and to receive: counts [rank][list], and packed nodes in this order. */
struct transport {
  int size, lists;
  int64_t *to, *from;  /* [rank][list] */
  int64_t *out, *in;   /* words */
  int64_t n_out, n_in; /* nodes */
  struct kith_message *message;
};

static void transport_clear(struct transport *t) {
  kith_free(&t->to);
  kith_free(&t->from);
  kith_free(&t->out);
  kith_free(&t->in);
  kith_free(&t->message);
}

static kith_status transport_init(struct transport *t, const struct kith_nodes *nodes) {
  t->size = kith_ranks_size(nodes->ranks);
  t->lists = nodes->n_lists;
  const size_t counts = (size_t)t->size * (size_t)t->lists;
  KITH_TRY(kith_resize(&t->to, 0, counts, sizeof *t->to));
  KITH_TRY(kith_resize(&t->from, 0, counts, sizeof *t->from));
  return kith_resize(&t->message, 0, 2 * (size_t)t->size, sizeof *t->message);
}

/* Fills `out` rank by rank, list by list, node by node; nodes with to[i] == stay, this rank, are left out. */
static kith_status load_all(struct transport *t, const struct kith_nodes *nodes, const struct layout *layout,
                            const int32_t *to, int stay) {
  int64_t *place = NULL, sum = 0;
  const size_t counts = (size_t)t->size * (size_t)t->lists;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    if (to[i] != stay) ++t->to[(size_t)to[i] * (size_t)t->lists + nodes->list->u8[i]];
  KITH_TRY(kith_resize(&place, 0, counts, sizeof *place));
  for (size_t k = 0; k < counts; ++k) place[k] = sum, sum += t->to[k];
  t->n_out = sum;
  const kith_status status = kith_resize(&t->out, 0, (size_t)sum * layout->words, sizeof *t->out);
  for (kith_index i = 0; status == KITH_OK && i < nodes->n_internal; ++i)
    if (to[i] != stay)
      load(layout, i,
           t->out + (size_t)place[(size_t)to[i] * (size_t)t->lists + nodes->list->u8[i]]++ * layout->words);
  kith_free(&place);
  return status;
}

/* Messages to and from all ranks, in parts of the packed nodes; returns how many nodes they hold. */
static int64_t part_out(const struct transport *t, const struct layout *layout, const int64_t *count,
                        int64_t *words, struct kith_message *message) {
  size_t at = 0;
  for (int r = 0; r < t->size; ++r) {
    size_t n = 0;
    for (int l = 0; l < t->lists; ++l) n += (size_t)count[r * t->lists + l];
    message[r] =
        (struct kith_message){r, words != NULL ? words + at * layout->words : NULL, n * layout->words * 8};
    at += n;
  }
  return (int64_t)at;
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

/* At the end of each list, rank by rank. */
static kith_status unpack_arrivals(const struct transport *t, struct kith_nodes *nodes,
                                   const struct layout *layout) {
  for (int l = 0; l < t->lists; ++l) {
    int64_t count = 0, at = 0;
    kith_index place;
    for (int r = 0; r < t->size; ++r) count += t->from[(size_t)r * (size_t)t->lists + (size_t)l];
    if (count > INT32_MAX)
      KITH_FAIL(UNSUPPORTED, "%lld nodes of one list move to one rank", (long long)count);
    KITH_TRY(kith_nodes_append(nodes, l, (kith_index)count, &place));
    for (int k = 0; k < t->size * t->lists; ++k) { /* `at` passes over all lists of all ranks */
      const bool mine = k % t->lists == l;
      for (int64_t n = 0; mine && n < t->from[k]; ++n)
        unload(layout, place++, t->in + (size_t)(at + n) * layout->words);
      at += t->from[k];
    }
  }
  return KITH_OK;
}

static kith_status count_all(const struct kith_nodes *nodes, uint64_t before, uint64_t out, uint64_t in) {
  uint64_t balance[] = {before - out + in, (uint64_t)nodes->n_internal, out, in};
  kith_ranks_sum_counts(nodes->ranks, balance, 4);
  if (balance[0] != balance[1] || balance[2] != balance[3])
    KITH_FAIL(INTERNAL, "of %llu nodes %llu are left after a migration", (unsigned long long)balance[0],
              (unsigned long long)balance[1]);
  return KITH_OK;
}

static kith_status migrate(struct transport *t, struct kith_nodes *nodes, const int32_t *to) {
  struct kith_ranks *ranks = nodes->ranks;
  const int me = kith_ranks_rank(ranks);
  const uint64_t before = (uint64_t)nodes->n_internal;
  struct layout layout = {0};
  for (int f = 0; f < nodes->n_fields; ++f) add_field(&layout, nodes->fields[f]);
  kith_status status = transport_init(t, nodes);
  if (status == KITH_OK) status = load_all(t, nodes, &layout, to, me);
  KITH_TRY(kith_ranks_allreduce_status(ranks, status));
  kith_ranks_all_to_all(ranks, t->to, t->from, t->lists);
  struct kith_message *in = t->message + t->size;
  t->n_in = part_out(t, &layout, t->from, NULL, in);
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, kith_resize(&t->in, 0, (size_t)t->n_in * layout.words, sizeof *t->in)));
  part_out(t, &layout, t->to, t->out, t->message);
  part_out(t, &layout, t->from, t->in, in);
  KITH_TRY(kith_ranks_exchange(ranks, t->size, t->message, t->size, in));
  status = t->n_out > 0 ? remove_leaving(nodes, to, me) : KITH_OK;
  if (status == KITH_OK && t->n_in > 0) status = unpack_arrivals(t, nodes, &layout);
  if (t->n_in > 0) ++nodes->positions;
  KITH_TRY(kith_ranks_allreduce_status(ranks, status));
  return count_all(nodes, before, (uint64_t)t->n_out, (uint64_t)t->n_in);
}

kith_status kith_nodes_migrate(struct kith_nodes *nodes, const int32_t *to, uint64_t *moved) {
  struct transport t = {0};
  kith_nodes_drop_ghosts(nodes);
  const kith_status status = migrate(&t, nodes, to);
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

/* Each list by id. */
static kith_status sort_by_id(struct kith_nodes *whole) {
  kith_index *order = NULL;
  bool sorted = true;
  kith_status status = kith_resize(&order, 0, (size_t)whole->n_internal, sizeof *order);
  if (status == KITH_OK)
    status = kith_nodes_order_by(whole, (const uint64_t *)whole->id->i64, order, &sorted);
  if (status == KITH_OK && !sorted) status = kith_nodes_reorder(whole, order);
  kith_free(&order);
  return status;
}

/* The ids of all ranks: *first .. *first + *span - 1. */
static kith_status range_of_ids(const struct kith_nodes *nodes, int64_t *first, uint64_t *span) {
  int64_t mine[2] = {INT64_MAX, INT64_MIN}, last = INT64_MIN;
  char *all = NULL;
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    mine[0] = KITH_MIN(mine[0], nodes->id->i64[i]);
    mine[1] = KITH_MAX(mine[1], nodes->id->i64[i]);
  }
  KITH_TRY(kith_ranks_gather(nodes->ranks, mine, sizeof mine, &all, NULL));
  const int64_t *ends = (const int64_t *)all;
  *first = INT64_MAX;
  for (int r = 0; r < kith_ranks_size(nodes->ranks); ++r) {
    *first = KITH_MIN(*first, ends[2 * r]);
    last = KITH_MAX(last, ends[2 * r + 1]);
  }
  *span = last < *first ? 1 : (uint64_t)last - (uint64_t)*first + 1;
  kith_free(&all);
  return KITH_OK;
}

/* To the rank that has the id's range; all to rank 0 if there is only one range. */
static kith_status send_by_id(struct kith_nodes *copy, int ranges) {
  int64_t first;
  uint64_t span;
  int32_t *to = NULL;
  KITH_TRY(range_of_ids(copy, &first, &span));
  const uint64_t width = (span - 1) / (uint64_t)ranges + 1;
  KITH_TRY(
      kith_ranks_allreduce_status(copy->ranks, kith_resize(&to, 0, (size_t)copy->n_internal, sizeof *to)));
  for (kith_index i = 0; i < copy->n_internal; ++i)
    to[i] = (int32_t)(((uint64_t)copy->id->i64[i] - (uint64_t)first) / width);
  const kith_status status = kith_nodes_migrate(copy, to, NULL);
  kith_free(&to);
  return status;
}

static kith_status copy_by_id(const struct kith_nodes *nodes, int ranges, struct kith_nodes **out) {
  *out = NULL;
  kith_status status = kith_ranks_allreduce_status(nodes->ranks, kith_nodes_copy(out, nodes, false));
  if (status == KITH_OK) (*out)->ranks = nodes->ranks;
  if (status == KITH_OK && nodes->ranks != NULL) status = send_by_id(*out, ranges);
  if (status == KITH_OK) status = kith_ranks_allreduce_status(nodes->ranks, sort_by_id(*out));
  if (status != KITH_OK) kith_nodes_destroy(out);
  return status;
}

kith_status kith_nodes_deal(const struct kith_nodes *nodes, struct kith_nodes **dealt) {
  return copy_by_id(nodes, kith_ranks_size(nodes->ranks), dealt);
}

kith_status kith_nodes_gather(const struct kith_nodes *nodes, struct kith_nodes **whole) {
  KITH_TRY(copy_by_id(nodes, 1, whole));
  if (kith_ranks_rank(nodes->ranks) != 0) kith_nodes_destroy(whole);
  return KITH_OK;
}
