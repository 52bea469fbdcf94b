#include "boundaries/distributed.h"

#include <omp.h>
#include <stdio.h>
#include <string.h>

enum { BUNCH = 64 }; /* candidates tested together */

/* What a rank tells of a cell that is not empty. */
struct place {
  double reach;
  struct kith_box box;
};

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

/* ---- who is sent where ---- */

static const struct place nowhere = {.reach = -1};

static void include(struct place *to, const struct place *from) {
  if (!(from->reach >= 0)) return;
  if (!(to->reach >= 0)) to->box = kith_box_empty();
  kith_box_include(&to->box, from->box.lower);
  kith_box_include(&to->box, from->box.upper);
  to->reach = KITH_MAX(to->reach, from->reach);
}

static struct place place_of(const struct kith_nodes *nodes, kith_index i) {
  struct place p = {nodes->reach->f64[i], kith_box_empty()};
  kith_box_include(&p.box, nodes->position->f64 + (size_t)i * NDIM);
  return p;
}

/* Cells of this rank, by home. Each thread has cells of its own; boxes and largest reaches have no order. */
static kith_status own_places(const struct distributed *d, const struct kith_nodes *nodes,
                              struct place **places, size_t *n) {
  const int64_t *home = d->home->i64;
  const int threads = nodes->n_internal > 10000 ? omp_get_max_threads() : 1;
  int64_t cells = 0;
#pragma omp parallel for schedule(static) reduction(max : cells) num_threads(threads)
  for (kith_index i = 0; i < nodes->n_internal; ++i) cells = KITH_MAX(cells, home[i] + 1);
  const size_t all = (size_t)cells * (size_t)threads;
  struct place *place = NULL;
  KITH_TRY(kith_resize(&place, 0, all, sizeof *place));
  for (size_t c = 0; c < all; ++c) place[c] = nowhere;
#pragma omp parallel num_threads(threads)
  {
    struct place *mine = place + (size_t)cells * (size_t)omp_get_thread_num();
#pragma omp for schedule(static)
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      const struct place p = place_of(nodes, i);
      include(&mine[home[i]], &p);
    }
  }
  for (size_t c = (size_t)cells; c < all; ++c) include(&place[c % (size_t)cells], &place[c]);
  *n = (size_t)cells;
  *places = place;
  return KITH_OK;
}

/* Those that are not empty. */
static size_t pack_places(struct place *place, size_t n) {
  size_t left = 0;
  for (size_t c = 0; c < n; ++c)
    if (place[c].reach >= 0) place[left++] = place[c];
  return left;
}

static double box_distance2(const struct kith_box *a, const struct kith_box *b) {
  double s = 0;
  for (int k = 0; k < NDIM; ++k) {
    const double gap = KITH_MAX(KITH_MAX(a->lower[k] - b->upper[k], b->lower[k] - a->upper[k]), 0.0);
    s += gap * gap;
  }
  return s;
}

/* d^2 <= (f r)^2, no tighter than rounding could make it. */
static bool within(double d2, double factor, double r) {
  return d2 <= factor * factor * r * r * (1 + 1e-14);
}

/* Does a node, or a bunch of them, reach a place? */
static bool reaches(const struct place *from, const struct place *to, double factor) {
  return from->reach >= 0 &&
         within(box_distance2(&from->box, &to->box), factor, KITH_MAX(from->reach, to->reach));
}

/* What may be sent: all but frozen nodes and their images; in bunches of consecutive nodes. */
struct candidates {
  kith_index n;  /* nodes and ghosts */
  uint8_t *kept; /* [n] 1: not to be sent; then, per rank, 2: sent */
  int bunches;
  uint8_t *hit; /* [bunches] does it hold one that is sent? */
  struct place *bunch, all;
};

static void mark_frozen(const struct kith_nodes *nodes, uint8_t *frozen) {
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    for (kith_index k = 0; k < block->count; ++k)
      frozen[block->first + k] = block->control == NULL || frozen[block->control[k]];
  }
}

static kith_status gather_candidates(struct candidates *c, const struct kith_nodes *nodes) {
  c->n = kith_nodes_count(nodes);
  c->bunches = (c->n + BUNCH - 1) / BUNCH;
  c->all = nowhere;
  KITH_TRY(kith_resize(&c->hit, 0, (size_t)c->bunches, 1));
  KITH_TRY(kith_resize(&c->kept, 0, (size_t)c->n, 1));
  KITH_TRY(kith_resize(&c->bunch, 0, (size_t)c->bunches, sizeof *c->bunch));
  mark_frozen(nodes, c->kept);
#pragma omp parallel for schedule(static) if (c->bunches > 64)
  for (int b = 0; b < c->bunches; ++b) {
    c->bunch[b] = nowhere;
    for (kith_index i = b * BUNCH; i < KITH_MIN(c->n, (b + 1) * BUNCH); ++i) {
      const struct place p = place_of(nodes, i);
      if (!c->kept[i]) include(&c->bunch[b], &p);
    }
  }
  for (int b = 0; b < c->bunches; ++b) include(&c->all, &c->bunch[b]);
  return KITH_OK;
}

static void mark_bunch(const struct candidates *c, const struct kith_nodes *nodes, int b,
                       const struct place *there, int n, double factor) {
  c->hit[b] = 0;
  for (int k = 0; k < n; ++k) {
    if (!reaches(&c->bunch[b], &there[k], factor)) continue;
    for (kith_index i = b * BUNCH; i < KITH_MIN(c->n, (b + 1) * BUNCH); ++i) {
      if (c->kept[i] != 0) continue;
      const double d2 = kith_box_distance2(&there[k].box, nodes->position->f64 + (size_t)i * NDIM);
      if (within(d2, factor, KITH_MAX(nodes->reach->f64[i], there[k].reach))) c->kept[i] = 2, c->hit[b] = 1;
    }
  }
}

/* Counts the marked ones of each list (send NULL), or places them: place[list] is where the next one goes. */
static void sweep(const struct candidates *c, const struct kith_nodes *nodes, int64_t *place,
                  kith_index *send) {
  for (int b = 0; b < c->bunches; ++b)
    for (kith_index i = b * BUNCH; c->hit[b] && i < KITH_MIN(c->n, (b + 1) * BUNCH); ++i) {
      if (c->kept[i] != 2) continue;
      const int64_t at = place[nodes->list->u8[i]]++;
      if (send == NULL) continue;
      send[at] = i;
      c->kept[i] = 0;
    }
}

/* The marked ones, list by list; the marks go. */
static kith_status collect(struct candidates *c, const struct kith_nodes *nodes, struct peer *peer,
                           int64_t *count) {
  int64_t place[KITH_MAX_LISTS], total = 0;
  sweep(c, nodes, count, NULL);
  for (int l = 0; l < nodes->n_lists; ++l) place[l] = total, total += count[l];
  KITH_TRY(kith_resize(&peer->send, 0, (size_t)total, sizeof *peer->send));
  sweep(c, nodes, place, peer->send);
  peer->n_send = (kith_index)total;
  return KITH_OK;
}

/* The list for one rank, whose places are there[0 .. n - 1]; those that are far from all of ours are passed over. */
static kith_status list_for(struct candidates *c, const struct kith_nodes *nodes, struct place *there,
                            size_t n, double factor, struct peer *peer, int64_t *count) {
  int near = 0;
  struct place whole = nowhere;
  for (size_t k = 0; k < n; ++k)
    if (reaches(&c->all, &there[k], factor)) include(&whole, &there[k]), there[near++] = there[k];
  peer->n_send = 0;
  if (near == 0) return KITH_OK;
#pragma omp parallel for schedule(dynamic, 16) if (c->bunches > 64)
  for (int b = 0; b < c->bunches; ++b) /* most are far from all of that rank */
    mark_bunch(c, nodes, b, there, reaches(&c->bunch[b], &whole, factor) ? near : 0, factor);
  return collect(c, nodes, peer, count);
}

/* All places of all ranks; what each of them gets: d->peer[rank].send and to[rank][list]. */
static kith_status make_lists(struct distributed *d, const struct kith_nodes *nodes, double factor,
                              struct candidates *c, char *places, const size_t *part, int64_t *to) {
  const int size = kith_ranks_size(nodes->ranks), me = kith_ranks_rank(nodes->ranks);
  for (int r = 0; r < size; ++r) {
    struct peer *peer = &d->peer[d->n_peers++];
    *peer = (struct peer){.rank = r};
    if (r == me) continue;
    KITH_TRY(list_for(c, nodes, (struct place *)(places + part[r]),
                      (part[r + 1] - part[r]) / sizeof(struct place), factor, peer,
                      to + (size_t)r * (size_t)nodes->n_lists));
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
  struct candidates candidates;
  struct place *own;
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
  KITH_TRY(gather_candidates(&t->candidates, nodes));
  KITH_TRY(own_places(d, nodes, &t->own, n_own));
  *n_own = pack_places(t->own, *n_own);
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
  kith_free(&t.candidates.kept);
  kith_free(&t.candidates.bunch);
  kith_free(&t.candidates.hit);
  kith_free(&t.own);
  kith_free(&t.places);
  kith_free(&t.part);
  kith_free(&t.to);
  kith_free(&t.from);
  return status;
}

/* ---- two layers ---- */

/* Square of the distance between boxes, or images of them. */
static double image_distance2(const struct kith_cells *cells, const struct kith_box *a,
                              const struct kith_box *b) {
  double s = 0;
  for (int k = 0; k < NDIM; ++k) {
    const double length = cells->upper[k] - cells->lower[k];
    const double up = b->lower[k] - a->upper[k], down = a->lower[k] - b->upper[k];
    double gap = KITH_MAX(KITH_MAX(up, down), 0.0);
    if (cells->periodic[k]) gap = KITH_MIN(gap, KITH_MAX(length + KITH_MIN(up, down), 0.0));
    s += gap * gap;
  }
  return s;
}

static double widest(const struct distributed *d, const struct place *own, const struct place *all,
                     size_t n) {
  double reach = own->reach;
  for (size_t k = 0; k < n; ++k)
    if (all[k].reach > reach && within(image_distance2(d->cells, &own->box, &all[k].box), 1, all[k].reach))
      reach = all[k].reach;
  return reach;
}

kith_status kith_distributed_widen(struct kith_boundary *boundary, struct kith_nodes *nodes) {
  const struct distributed *d = boundary->self;
  struct place *own = NULL, *all = NULL;
  char *gathered = NULL;
  size_t n = 0;
  size_t *part = NULL;
  kith_status status = kith_resize(&part, 0, (size_t)kith_ranks_size(nodes->ranks) + 1, sizeof *part);
  if (status == KITH_OK) status = own_places(d, nodes, &own, &n);
  status = kith_ranks_agree(nodes->ranks, status);
  if (status == KITH_OK) status = kith_ranks_gather(nodes->ranks, own, n * sizeof *own, &gathered, part);
  if (status == KITH_OK) {
    all = (struct place *)gathered;
    const size_t n_all = part[kith_ranks_size(nodes->ranks)] / sizeof *all;
    for (size_t c = 0; c < n; ++c)
      if (own[c].reach >= 0) own[c].reach = widest(d, &own[c], all, n_all);
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
