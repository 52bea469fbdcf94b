#include "boundaries/distributed.h"

#include <stdio.h>
#include <string.h>

#include "boundaries/places.h"

struct peer {
  int rank;
  kith_index n_send, n_recv, first; /* ghosts from it: first .. first + n_recv - 1 */
  kith_index *send;                 /* [n_send] nodes and images, by list and index; owned */
};

/* Fields whose values are under way. */
struct selection {
  int n_fields;
  struct kith_field *field[KITH_MAX_FIELDS];
};

struct distributed {
  const struct kith_field *home;  /* borrowed */
  const struct kith_cells *cells; /* borrowed */
  struct selection selection;
  int n_peers;
  struct peer *peer; /* ascending ranks: those that are sent to or send */
  struct kith_message *out, *in;
  char *buffer;
  size_t capacity;
};

static void forget_peers(struct distributed *d) {
  for (int p = 0; p < d->n_peers; ++p) kith_free(&d->peer[p].send);
  d->n_peers = 0;
}

static void destroy(struct kith_boundary *boundary) {
  struct distributed *d = boundary->self;
  if (d == NULL) return;
  forget_peers(d);
  kith_free(&d->peer);
  kith_free(&d->out);
  kith_free(&d->in);
  kith_free(&d->buffer);
  kith_free(&boundary->self);
}

/* ---- values ---- */

static size_t padded(size_t bytes) {
  return (bytes + 7) / 8 * 8;
}

static size_t message_size(kith_index n, struct kith_field *const *fields, int n_fields) {
  size_t bytes = 0;
  for (int f = 0; f < n_fields; ++f) bytes += padded((size_t)n * kith_field_node_size(fields[f]));
  return bytes;
}

/* A share of the buffer for every message that goes out, and one for every one that comes. */
static kith_status lay_out(struct distributed *d, size_t (*size)(const void *context, kith_index n),
                           const void *context) {
  size_t total = 0, at = 0;
  for (int p = 0; p < d->n_peers; ++p)
    total += size(context, d->peer[p].n_send) + size(context, d->peer[p].n_recv);
  if (total > d->capacity) {
    d->capacity = 0;
    KITH_TRY(kith_resize(&d->buffer, 0, total + total / 8, 1));
    d->capacity = total + total / 8;
  }
  for (int way = 0; way < 2; ++way)
    for (int p = 0; p < d->n_peers; ++p) {
      const struct peer *peer = &d->peer[p];
      struct kith_message *m = way == 0 ? &d->out[p] : &d->in[p];
      const size_t bytes = size(context, way == 0 ? peer->n_send : peer->n_recv);
      *m = (struct kith_message){peer->rank, total > 0 ? d->buffer + at : NULL, bytes};
      at += bytes;
    }
  return KITH_OK;
}

static void pack(char *to, const struct kith_field *field, const kith_index *node, kith_index n) {
  const size_t size = kith_field_node_size(field);
#pragma omp parallel for schedule(static) if ((size_t)n * size > 1 << 16)
  for (kith_index k = 0; k < n; ++k)
    memcpy(to + (size_t)k * size, (const char *)field->data + (size_t)node[k] * size, size);
}

static size_t size_of_values(const void *context, kith_index n) {
  const struct selection *s = context;
  return message_size(n, s->field, s->n_fields);
}

static void pack_peer(const struct peer *peer, const struct selection *s, char *to) {
  for (int f = 0; f < s->n_fields; ++f) {
    pack(to, s->field[f], peer->send, peer->n_send);
    to += padded((size_t)peer->n_send * kith_field_node_size(s->field[f]));
  }
}

static void unpack_peer(const struct peer *peer, const struct selection *s, const char *from) {
  for (int f = 0; f < s->n_fields; ++f) {
    const size_t size = kith_field_node_size(s->field[f]), bytes = (size_t)peer->n_recv * size;
    if (bytes > 0) memcpy((char *)s->field[f]->data + (size_t)peer->first * size, from, bytes);
    from += padded(bytes);
  }
}

static kith_status send(struct distributed *d, struct kith_nodes *nodes) {
  KITH_TRY(lay_out(d, size_of_values, &d->selection));
  for (int p = 0; p < d->n_peers; ++p) pack_peer(&d->peer[p], &d->selection, d->out[p].data);
  return kith_ranks_post(nodes->ranks, d->n_peers, d->out, d->n_peers, d->in);
}

/* Others wait for these values: without memory for them there is nothing left to agree on. */
static void post(void *context, struct kith_nodes *nodes, struct kith_field *const *fields, int n_fields) {
  struct distributed *d = context;
  d->selection.n_fields = n_fields;
  memcpy(d->selection.field, fields, (size_t)n_fields * sizeof *fields);
  if (send(d, nodes) == KITH_OK) return;
  fprintf(stderr, "kith: rank %d: %s\n", kith_ranks_rank(nodes->ranks), kith_failure());
  kith_ranks_abort(nodes->ranks, 1);
}

static void finish(void *context, struct kith_nodes *nodes) {
  struct distributed *d = context;
  kith_ranks_finish(nodes->ranks);
  for (int p = 0; p < d->n_peers; ++p) unpack_peer(&d->peer[p], &d->selection, d->in[p].data);
}

/* ---- ghosts ---- */

/* All places of all ranks; what each of them gets: d->peer[rank].send and to[rank][list]. */
static kith_status make_lists(struct distributed *d, const struct kith_nodes *nodes, double factor,
                              struct kith_candidates *c, char *places, const size_t *part, int64_t *to) {
  const int size = kith_ranks_size(nodes->ranks), me = kith_ranks_rank(nodes->ranks);
  for (int r = 0; r < size; ++r) {
    struct peer *peer = &d->peer[d->n_peers++];
    *peer = (struct peer){.rank = r};
    if (r == me) continue;
    KITH_TRY(kith_candidates_near(c, nodes, (struct kith_place *)(places + part[r]),
                                  (part[r + 1] - part[r]) / sizeof(struct kith_place), factor, &peer->send,
                                  &peer->n_send, to + (size_t)r * (size_t)nodes->n_lists));
  }
  return KITH_OK;
}

/* Blocks of remote ghosts as the others announced them; peers without a message go. */
static kith_status add_blocks(struct distributed *d, const struct kith_boundary *boundary,
                              struct kith_nodes *nodes, const int64_t *from) {
  int left = 0;
  for (int p = 0; p < d->n_peers; ++p) {
    struct peer peer = d->peer[p];
    peer.first = kith_nodes_count(nodes);
    for (int l = 0; l < nodes->n_lists; ++l) {
      const int64_t count = from[(size_t)peer.rank * (size_t)nodes->n_lists + (size_t)l];
      const struct kith_ghost_block block = {
          .kind = KITH_GHOST_REMOTE, .boundary = boundary->index, .list = l, .count = (kith_index)count};
      KITH_TRY(kith_nodes_add_ghosts(nodes, &block));
    }
    peer.n_recv = kith_nodes_count(nodes) - peer.first;
    d->peer[p].send = NULL; /* it has one owner, whatever fails */
    if (peer.n_send + peer.n_recv > 0) d->peer[left++] = peer;
  }
  d->n_peers = left;
  return KITH_OK;
}

struct talk {
  struct kith_candidates candidates;
  struct kith_place *own;
  char *places; /* of all ranks */
  size_t *part;
  int64_t *to, *from; /* [rank][list] */
};

static kith_status prepare_talk(struct talk *t, const struct distributed *d, const struct kith_nodes *nodes,
                                size_t *n_own) {
  const size_t size = (size_t)kith_ranks_size(nodes->ranks), lists = (size_t)nodes->n_lists;
  KITH_TRY(kith_resize(&t->part, 0, size + 1, sizeof *t->part));
  KITH_TRY(kith_resize(&t->to, 0, size * lists, sizeof *t->to));
  KITH_TRY(kith_resize(&t->from, 0, size * lists, sizeof *t->from));
  KITH_TRY(kith_candidates_gather(&t->candidates, nodes));
  KITH_TRY(kith_places_of_cells(nodes, d->home, &t->own, n_own));
  *n_own = kith_places_pack(t->own, *n_own);
  return KITH_OK;
}

static kith_status make_ghosts(struct talk *t, struct kith_boundary *boundary, struct kith_nodes *nodes,
                               double factor) {
  struct distributed *d = boundary->self;
  struct kith_field *fields[KITH_MAX_FIELDS];
  size_t n_own = 0;
  KITH_TRY(kith_ranks_agree(nodes->ranks, prepare_talk(t, d, nodes, &n_own)));
  KITH_TRY(kith_ranks_gather(nodes->ranks, t->own, n_own * sizeof *t->own, &t->places, t->part));
  KITH_TRY(kith_ranks_agree(nodes->ranks,
                            make_lists(d, nodes, factor, &t->candidates, t->places, t->part, t->to)));
  kith_ranks_all_to_all(nodes->ranks, t->to, t->from, nodes->n_lists);
  KITH_TRY(kith_ranks_agree(nodes->ranks, add_blocks(d, boundary, nodes, t->from)));
  post(d, nodes, fields, kith_nodes_ghost_fields(nodes, fields));
  finish(d, nodes);
  return KITH_OK;
}

static kith_status ghosts(struct kith_boundary *boundary, struct kith_nodes *nodes, double factor) {
  struct talk t = {0};
  forget_peers(boundary->self);
  const kith_status status = make_ghosts(&t, boundary, nodes, factor);
  kith_candidates_clear(&t.candidates);
  kith_free(&t.own);
  kith_free(&t.places);
  kith_free(&t.part);
  kith_free(&t.to);
  kith_free(&t.from);
  return status;
}

/* ---- two layers ---- */

kith_status kith_distributed_widen(struct kith_boundary *boundary, struct kith_nodes *nodes) {
  const struct distributed *d = boundary->self;
  struct kith_place *own = NULL, *all = NULL;
  char *gathered = NULL;
  size_t n = 0;
  size_t *part = NULL;
  kith_status status = kith_resize(&part, 0, (size_t)kith_ranks_size(nodes->ranks) + 1, sizeof *part);
  if (status == KITH_OK) status = kith_places_of_cells(nodes, d->home, &own, &n);
  status = kith_ranks_agree(nodes->ranks, status);
  if (status == KITH_OK) status = kith_ranks_gather(nodes->ranks, own, n * sizeof *own, &gathered, part);
  if (status == KITH_OK) {
    all = (struct kith_place *)gathered;
    const size_t n_all = part[kith_ranks_size(nodes->ranks)] / sizeof *all;
#pragma omp parallel for schedule(dynamic, 16)
    for (size_t c = 0; c < n; ++c)
      if (own[c].reach >= 0) own[c].reach = kith_place_widest(&own[c], d->cells, all, n_all);
    for (kith_index i = 0; i < nodes->n_internal; ++i) nodes->reach->f64[i] = own[d->home->i64[i]].reach;
  }
  kith_free(&gathered);
  kith_free(&part);
  kith_free(&own);
  return status;
}

/* ---- culling ---- */

static size_t size_of_flags(const void *context, kith_index n) {
  (void)context;
  return padded((size_t)n);
}

/* Shortens the list to what its receiver keeps; images on it stay. */
static void trim_list(struct peer *peer, const struct kith_nodes *nodes, const uint8_t *wanted,
                      uint8_t *keep) {
  kith_index left = 0;
  for (kith_index k = 0; k < peer->n_send; ++k) {
    if (!wanted[k]) continue;
    const kith_index i = peer->send[k];
    if (i >= nodes->n_internal) keep[i - nodes->n_internal] = 1;
    peer->send[left++] = i;
  }
  peer->n_send = left;
}

static kith_status trim(struct kith_boundary *boundary, struct kith_nodes *nodes, uint8_t *keep) {
  struct distributed *d = boundary->self;
  KITH_TRY(kith_ranks_agree(nodes->ranks, lay_out(d, size_of_flags, NULL)));
  for (int p = 0; p < d->n_peers; ++p) { /* flags go back to where the nodes came from */
    struct kith_message *flags = &d->in[p];
    const struct peer *peer = &d->peer[p];
    if (flags->bytes > 0) memset(flags->data, 0, flags->bytes);
    if (peer->n_recv > 0) memcpy(flags->data, keep + (peer->first - nodes->n_internal), (size_t)peer->n_recv);
  }
  KITH_TRY(kith_ranks_exchange(nodes->ranks, d->n_peers, d->in, d->n_peers, d->out));
  for (int p = 0; p < d->n_peers; ++p) trim_list(&d->peer[p], nodes, d->out[p].data, keep);
  return KITH_OK;
}

static void renumbered(struct kith_boundary *boundary, const kith_index *renumber) {
  struct distributed *d = boundary->self;
  for (int p = 0; p < d->n_peers; ++p) {
    struct peer *peer = &d->peer[p];
    kith_index left = 0, first = peer->first;
    for (kith_index k = 0; k < peer->n_send; ++k) peer->send[k] = renumber[peer->send[k]];
    for (kith_index k = 0; k < peer->n_recv; ++k) {
      const kith_index now = renumber[peer->first + k];
      if (now >= 0 && left++ == 0) first = now;
    }
    peer->first = first;
    peer->n_recv = left;
  }
}

/* ---- the boundary ---- */

kith_status kith_distributed_init(struct kith_boundary *boundary, struct kith_nodes *nodes,
                                  const struct kith_field *home, const struct kith_cells *cells) {
  const size_t size = (size_t)kith_ranks_size(nodes->ranks);
  struct distributed *d = NULL;
  KITH_TRY(kith_resize(&d, 0, 1, sizeof *d));
  boundary->self = d;
  d->home = home;
  d->cells = cells;
  KITH_TRY(kith_resize(&d->peer, 0, size, sizeof *d->peer));
  KITH_TRY(kith_resize(&d->out, 0, size, sizeof *d->out));
  KITH_TRY(kith_resize(&d->in, 0, size, sizeof *d->in));
  nodes->exchange = (struct kith_exchange){.post = post, .finish = finish, .context = d};
  return KITH_OK;
}

const struct kith_boundary_ops kith_boundary_distributed = {
    .name = "distributed",
    .doc = "nodes of other ranks",
    .ghosts = ghosts,
    .trim = trim,
    .renumbered = renumbered,
    .destroy = destroy,
};
