/* halo.c - messages between neighbors: bounds of cells, send lists, remote ghosts and their values. */
#include "lib/domain/halo.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include "lib/domain/ghost_candidates.h"

struct peer {
  int rank;
  kith_index n_send, n_recv, first; /* ghosts from it: first .. first + n_recv - 1 */
  kith_index *send;                 /* [n_send] nodes and images, by list and index; owned */
};

struct kith_halo {
  struct kith_ranks *ranks;                 /* borrowed */
  struct kith_decomposition *decomposition; /* borrowed */
  /* Bounds of cells that are sent to neighbors and received from them, in the order of the shell; numbers of
   * ghosts of each list that go to each rank and come from it. */
  struct kith_bounds *bounds_out, *bounds_in;
  int64_t *count_out, *count_in; /* [ranks][lists], one block */
  size_t count_capacity;
  int n_peers;
  struct peer *peer; /* [n_peers] ascending ranks: neighbors that are sent to or send */
  /* One message to and from each peer, in parts of whole 8-byte words: part k has size[k] bytes a node. */
  int n_parts;
  size_t size[KITH_MAX_FIELDS];
  struct kith_field *field[KITH_MAX_FIELDS]; /* whose values are exchanged */
  struct kith_message *out, *in;             /* [ranks], one block */
  char *buffer;
  size_t capacity;
  bool pending, culled; /* culled: since ghosts were made */
  struct kith_halo_traffic traffic;
};

static void forget_peers(struct kith_halo *halo) {
  for (int p = 0; p < halo->n_peers; ++p) kith_free(&halo->peer[p].send);
  halo->n_peers = 0;
}

kith_status kith_halo_create(struct kith_halo **out, struct kith_ranks *ranks,
                             struct kith_decomposition *decomposition) {
  const size_t size = (size_t)kith_ranks_size(ranks);
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  struct kith_halo *halo = *out;
  halo->ranks = ranks;
  halo->decomposition = decomposition;
  kith_status status = kith_resize(&halo->peer, 0, size, sizeof *halo->peer);
  if (status == KITH_OK) status = kith_resize(&halo->out, 0, 2 * size, sizeof *halo->out);
  if (status != KITH_OK)
    kith_halo_destroy(out);
  else
    halo->in = halo->out + size;
  return status;
}

void kith_halo_destroy(struct kith_halo **halo) {
  if (*halo == NULL) return;
  forget_peers(*halo);
  KITH_FREE(&(*halo)->peer, &(*halo)->out, &(*halo)->count_out, &(*halo)->bounds_out, &(*halo)->bounds_in,
            &(*halo)->buffer);
  kith_free(halo);
}

/* ---- messages ---- */

static size_t part_size(const struct kith_halo *halo, int part, kith_index n) {
  return ((size_t)n * halo->size[part] + 7) / 8 * 8;
}

static size_t message_size(const struct kith_halo *halo, kith_index n) {
  size_t bytes = 0;
  for (int k = 0; k < halo->n_parts; ++k) bytes += part_size(halo, k, n);
  return bytes;
}

/* Divides the buffer among all messages that go out and come in. */
static kith_status lay_out(struct kith_halo *halo) {
  size_t total = 0, at = 0;
  for (int p = 0; p < halo->n_peers; ++p)
    total += message_size(halo, halo->peer[p].n_send) + message_size(halo, halo->peer[p].n_recv);
  KITH_TRY(kith_reserve(&halo->buffer, &halo->capacity, total, 1));
  for (int way = 0; way < 2; ++way)
    for (int p = 0; p < halo->n_peers; ++p) {
      const struct peer *peer = &halo->peer[p];
      const size_t bytes = message_size(halo, way == 0 ? peer->n_send : peer->n_recv);
      *(way == 0 ? &halo->out[p] : &halo->in[p]) =
          (struct kith_message){peer->rank, total > 0 ? halo->buffer + at : NULL, bytes};
      at += bytes;
    }
  return KITH_OK;
}

/* to[k] = from[at[k]], values of `size` bytes. */
static inline void gather(char *restrict to, const char *restrict from, const kith_index *at,
                          kith_index begin, kith_index end, size_t size) {
  for (kith_index k = begin; k < end; ++k) memcpy(to + (size_t)k * size, from + (size_t)at[k] * size, size);
}

/* Called by all threads of a team. The sizes of most fields are known to the compiler. */
static void pack_share(const struct kith_halo *halo, const struct peer *peer, char *to) {
  const int threads = omp_get_num_threads(), me = omp_get_thread_num();
  const kith_index begin = kith_part_start(peer->n_send, me, threads),
                   end = kith_part_start(peer->n_send, me + 1, threads);
  for (int f = 0; f < halo->n_parts; ++f) {
    const char *from = halo->field[f]->data;
    const size_t size = halo->size[f], scalar = sizeof(double), vector = NDIM * sizeof(double);
    if (size == scalar)
      gather(to, from, peer->send, begin, end, scalar);
    else if (size == vector)
      gather(to, from, peer->send, begin, end, vector);
    else
      gather(to, from, peer->send, begin, end, size);
    to += part_size(halo, f, peer->n_send);
  }
}

static void pack_peer(const struct kith_halo *halo, const struct peer *peer, char *to) {
#pragma omp parallel if (message_size(halo, peer->n_send) > 1 << 16)
  pack_share(halo, peer, to);
}

static void unpack_peer(const struct kith_halo *halo, const struct peer *peer, const char *from) {
  for (int f = 0; f < halo->n_parts && peer->n_recv > 0; ++f) {
    memcpy((char *)halo->field[f]->data + (size_t)peer->first * halo->size[f], from,
           (size_t)peer->n_recv * halo->size[f]);
    from += part_size(halo, f, peer->n_recv);
  }
}

/* Other ranks wait for these values: without memory for them all ranks must end. */
static void start_values(struct kith_halo *halo, struct kith_field *const *fields, int n_fields) {
  uint64_t bytes = 0;
  halo->n_parts = n_fields;
  for (int f = 0; f < n_fields; ++f) {
    halo->field[f] = fields[f];
    bytes += halo->size[f] = kith_field_node_size(fields[f]);
  }
  ++*(halo->culled ? &halo->traffic.kept : &halo->traffic.created);
  *(halo->culled ? &halo->traffic.kept_bytes : &halo->traffic.created_bytes) += bytes;
  halo->pending = true;
  kith_status status = lay_out(halo);
  for (int p = 0; status == KITH_OK && p < halo->n_peers; ++p)
    pack_peer(halo, &halo->peer[p], halo->out[p].data);
  if (status == KITH_OK)
    status = kith_ranks_start_exchange(halo->ranks, halo->n_peers, halo->out, halo->n_peers, halo->in);
  kith_ranks_must(halo->ranks, status);
}

void kith_halo_start_exchange(struct kith_halo *halo, struct kith_nodes *nodes,
                              struct kith_field *const *fields, int n_fields) {
  kith_halo_finish_exchange(halo);
  kith_nodes_refresh_images(nodes, fields, n_fields);
  if (halo == NULL) return;
  start_values(halo, fields, n_fields);
}

void kith_halo_finish_exchange(struct kith_halo *halo) {
  if (!kith_halo_pending(halo)) return;
  kith_ranks_finish_exchange(halo->ranks);
  for (int p = 0; p < halo->n_peers; ++p) unpack_peer(halo, &halo->peer[p], halo->in[p].data);
  halo->pending = false;
}

void kith_halo_refresh(struct kith_halo *halo, struct kith_nodes *nodes, struct kith_field *const *fields,
                       int n_fields) {
  kith_halo_start_exchange(halo, nodes, fields, n_fields);
  kith_halo_finish_exchange(halo);
}

bool kith_halo_pending(const struct kith_halo *halo) {
  return halo != NULL && halo->pending;
}

struct kith_halo_traffic kith_halo_traffic(const struct kith_halo *halo) {
  return halo != NULL ? halo->traffic : (struct kith_halo_traffic){0};
}

/* ---- neighbors ---- */

kith_status kith_halo_surround(struct kith_halo *halo, double reach) {
  bool changed;
  if (halo == NULL) return KITH_OK;
  const struct kith_shell *shell = &halo->decomposition->shell;
  kith_status status = kith_decomposition_surround(halo->decomposition, reach, &changed);
  if (!changed) return KITH_OK;
  if (status == KITH_OK)
    status = kith_resize(&halo->bounds_out, 0, (size_t)shell->send_first[shell->n_neighbors],
                         sizeof *halo->bounds_out);
  if (status == KITH_OK)
    status = kith_resize(&halo->bounds_in, 0, (size_t)shell->n_ghosts, sizeof *halo->bounds_in);
  return kith_ranks_must(halo->ranks, status);
}

/* Tells neighbors the bounds of the own cells that are their ghost cells, and learns those of the ghost cells
 * of this rank. own [own cells]; NULL: no nodes that need any others. */
static void exchange_bounds(struct kith_halo *halo, const struct kith_bounds *own) {
  const struct kith_decomposition *d = halo->decomposition;
  const struct kith_shell *shell = &d->shell;
  const size_t size = sizeof(struct kith_bounds);
  ++halo->traffic.told, halo->traffic.cell_bytes += size;
  for (int64_t k = 0; k < shell->send_first[shell->n_neighbors]; ++k)
    halo->bounds_out[k] = own != NULL ? own[d->place[shell->send[k]]] : kith_nowhere;
  for (int k = 0; k < shell->n_neighbors; ++k) {
    const int64_t send = shell->send_first[k], receive = shell->receive_first[k];
    halo->out[k] = (struct kith_message){shell->neighbor[k], halo->bounds_out + send,
                                         (size_t)(shell->send_first[k + 1] - send) * size};
    halo->in[k] = (struct kith_message){shell->neighbor[k], halo->bounds_in + receive,
                                        (size_t)(shell->receive_first[k + 1] - receive) * size};
  }
  kith_ranks_must(halo->ranks, kith_ranks_exchange(halo->ranks, shell->n_neighbors, halo->out,
                                                   shell->n_neighbors, halo->in));
}

/* Numbers of ghosts that are sent: none so far. */
static void clear_counts(struct kith_halo *halo, int n_lists) {
  const size_t n = (size_t)kith_ranks_size(halo->ranks) * (size_t)n_lists;
  kith_ranks_must(halo->ranks,
                  kith_reserve(&halo->count_out, &halo->count_capacity, 2 * n, sizeof *halo->count_out));
  halo->count_in = halo->count_out + n;
  memset(halo->count_out, 0, n * sizeof *halo->count_out);
}

static void exchange_counts(struct kith_halo *halo, int n_lists) {
  const struct kith_shell *shell = &halo->decomposition->shell;
  ++halo->traffic.told, halo->traffic.told_bytes += (uint64_t)n_lists * sizeof *halo->count_out;
  kith_ranks_tell(halo->ranks, shell->n_neighbors, shell->neighbor, halo->count_out, halo->count_in, n_lists);
}

static kith_status own_bounds(const struct kith_halo *halo, const struct kith_candidates *candidates,
                              const struct kith_nodes *nodes, struct kith_bounds **own) {
  *own = NULL;
  return kith_bounds_find(candidates, nodes, halo->decomposition->home->i64,
                          (size_t)halo->decomposition->n_own, own);
}

/* ---- ghosts ---- */

/* The nodes and images that each neighbor gets, and how many of each list. */
static kith_status make_send_lists(struct kith_halo *halo, const struct kith_nodes *nodes, double factor,
                                   struct kith_candidates *candidates) {
  const struct kith_shell *shell = &halo->decomposition->shell;
  const size_t lists = (size_t)nodes->n_lists;
  clear_counts(halo, nodes->n_lists);
  for (int k = 0; k < shell->n_neighbors; ++k) {
    struct peer *peer = &halo->peer[halo->n_peers++];
    *peer = (struct peer){.rank = shell->neighbor[k]};
    KITH_TRY(kith_candidates_near(candidates, nodes, halo->bounds_in + shell->receive_first[k],
                                  (size_t)(shell->receive_first[k + 1] - shell->receive_first[k]), factor,
                                  &peer->send, &peer->n_send, halo->count_out + (size_t)peer->rank * lists));
  }
  return KITH_OK;
}

/* Blocks of remote ghosts as neighbors announced them; peers without a message are dropped. */
static kith_status add_blocks(struct kith_halo *halo, struct kith_nodes *nodes, int boundary) {
  int left = 0;
  for (int p = 0; p < halo->n_peers; ++p) {
    struct peer peer = halo->peer[p];
    peer.first = kith_nodes_count(nodes);
    for (int l = 0; l < nodes->n_lists; ++l) {
      const int64_t count = halo->count_in[(size_t)peer.rank * (size_t)nodes->n_lists + (size_t)l];
      const struct kith_ghost_block block = {
          .kind = KITH_GHOST_REMOTE, .boundary = boundary, .list = l, .count = (kith_index)count};
      KITH_TRY(kith_nodes_add_ghosts(nodes, &block));
    }
    peer.n_recv = kith_nodes_count(nodes) - peer.first;
    halo->peer[p].send = NULL; /* it has one owner, whatever fails */
    if (peer.n_send + peer.n_recv > 0) halo->peer[left++] = peer;
  }
  halo->n_peers = left;
  return KITH_OK;
}

void kith_halo_abstain(struct kith_halo *halo, const struct kith_nodes *nodes) {
  if (halo == NULL) return;
  forget_peers(halo);
  exchange_bounds(halo, NULL);
  clear_counts(halo, nodes->n_lists);
  exchange_counts(halo, nodes->n_lists);
}

void kith_halo_add_ghosts(struct kith_halo *halo, struct kith_nodes *nodes, int boundary, double factor) {
  struct kith_field *fields[KITH_MAX_FIELDS];
  struct kith_candidates candidates = {0};
  struct kith_bounds *own;
  if (halo == NULL) return;
  forget_peers(halo);
  halo->culled = false;
  kith_ranks_must(halo->ranks, kith_candidates_gather(&candidates, nodes));
  kith_ranks_must(halo->ranks, own_bounds(halo, &candidates, nodes, &own));
  exchange_bounds(halo, own);
  kith_ranks_must(halo->ranks, make_send_lists(halo, nodes, factor, &candidates));
  exchange_counts(halo, nodes->n_lists);
  kith_ranks_must(halo->ranks, add_blocks(halo, nodes, boundary));
  start_values(halo, fields, kith_nodes_ghost_fields(nodes, fields));
  kith_halo_finish_exchange(halo);
  kith_free(&own);
  kith_candidates_clear(&candidates);
}

void kith_halo_extend(struct kith_halo *halo, struct kith_nodes *nodes) {
  struct kith_bounds *own, *wide = NULL;
  if (halo == NULL) return;
  const struct kith_decomposition *d = halo->decomposition;
  const size_t n_own = (size_t)d->n_own;
  kith_ranks_must(halo->ranks, own_bounds(halo, NULL, nodes, &own));
  kith_ranks_must(halo->ranks, kith_resize(&wide, 0, n_own, sizeof *wide));
  exchange_bounds(halo, own);
#pragma omp parallel
  {
#pragma omp for schedule(dynamic, 16)
    for (size_t c = 0; c < n_own; ++c) {
      wide[c] = own[c];
      if (!(own[c].search_radius >= 0)) continue;
      wide[c].search_radius =
          fmax(kith_bounds_widest(&own[c], &d->cells, own, n_own),
               kith_bounds_widest(&own[c], &d->cells, halo->bounds_in, (size_t)d->shell.n_ghosts));
    }
#pragma omp for schedule(static)
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      nodes->search_radius->f64[i] = wide[d->home->i64[i]].search_radius;
  }
  KITH_FREE(&own, &wide);
}

/* ---- culling ---- */

/* Shortens the send list to what its receiver keeps; images on it stay (keep NULL: nothing does). */
static void trim_list(struct peer *peer, const struct kith_nodes *nodes, const uint8_t *wanted,
                      uint8_t *keep) {
  kith_index left = 0;
  for (kith_index k = 0; k < peer->n_send; ++k) {
    if (!wanted[k]) continue;
    const kith_index i = peer->send[k];
    if (keep != NULL && i >= nodes->n_internal) keep[i - nodes->n_internal] = 1;
    peer->send[left++] = i;
  }
  peer->n_send = left;
}

void kith_halo_mark_sent(const struct kith_halo *halo, const struct kith_nodes *nodes, uint8_t *mark,
                         uint8_t bits) {
  for (int p = 0; halo != NULL && p < halo->n_peers; ++p) {
    const struct peer *peer = &halo->peer[p];
    for (kith_index k = 0; k < peer->n_send; ++k)
      if (peer->send[k] >= nodes->n_internal) mark[peer->send[k] - nodes->n_internal] |= bits;
  }
}

/* A flag for each ghost goes back to where its node came from: `in` is sent, `out` received. The buffer had
 * space for values already. */
void kith_halo_start_cull(struct kith_halo *halo, const struct kith_nodes *nodes, const uint8_t *keep) {
  if (halo == NULL) return;
  halo->n_parts = 1, halo->size[0] = 1;
  halo->culled = true, ++halo->traffic.created, ++halo->traffic.created_bytes;
  kith_ranks_must(halo->ranks, lay_out(halo));
  for (int p = 0; p < halo->n_peers; ++p) {
    const struct kith_message *flags = &halo->in[p];
    const struct peer *peer = &halo->peer[p];
    if (flags->bytes > 0) memset(flags->data, 0, flags->bytes);
    if (peer->n_recv > 0 && keep != NULL)
      memcpy(flags->data, keep + (peer->first - nodes->n_internal), (size_t)peer->n_recv);
  }
  kith_ranks_must(halo->ranks,
                  kith_ranks_start_exchange(halo->ranks, halo->n_peers, halo->in, halo->n_peers, halo->out));
}

void kith_halo_finish_cull(struct kith_halo *halo, const struct kith_nodes *nodes, uint8_t *keep) {
  if (halo == NULL) return;
  kith_ranks_finish_exchange(halo->ranks);
  for (int p = 0; p < halo->n_peers; ++p) trim_list(&halo->peer[p], nodes, halo->out[p].data, keep);
}

void kith_halo_remap(struct kith_halo *halo, const kith_index *renumber) {
  for (int p = 0; halo != NULL && p < halo->n_peers; ++p) {
    struct peer *peer = &halo->peer[p];
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
