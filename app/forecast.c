#include "app/forecast.h"

#include <math.h>
#include <string.h>
#include "lib/domain/share.h"
#include "lib/domain/shell.h"

enum { MOST_RANKS = 16384, MOST_RANKS_OF_A_NODE = 512 };

/* ---- habits ---- */

/* Calls of kith_ranks_*, as the stages are written (tests/mpi/planned.sh compares the sum with runs): of a list, and more for each boundary;
 * of an evaluation; of a step with what is told of it. */
enum { OF_A_LIST = 19, OF_A_BOUNDARY = 2, OF_AN_EVALUATION = 4, OF_A_STEP = 9 };

struct notes {
  double calls, bytes;
};

static void take_notes(void *context, struct kith_nodes *nodes, struct kith_field *const *fields,
                       int n_fields) {
  struct notes *notes = context;
  (void)nodes;
  notes->calls += 1;
  for (int f = 0; f < n_fields; ++f) notes->bytes += (double)kith_field_node_size(fields[f]);
}

static void nothing_arrives(void *context, struct kith_nodes *nodes) {
  (void)context, (void)nodes;
}

/* One evaluation, with new lists or with those that are there. */
static kith_status listen(struct kith_model *m, const char *due, struct notes *notes) {
  *notes = (struct notes){0};
  m->nodes->exchange =
      (struct kith_exchange){.post = take_notes, .finish = nothing_arrives, .context = notes};
  m->integrator.due = due;
  const kith_status status = kith_integrator_rates(&m->integrator);
  m->nodes->exchange = (struct kith_exchange){0};
  return status;
}

kith_status kith_step_habits(struct kith_model *m, double lists, struct kith_step_habits *out) {
  const double evaluations = m->integrator.evaluations, later = evaluations - lists;
  const struct kith_requirements *built = &m->connectivity->built;
  struct kith_field *fields[KITH_MAX_FIELDS];
  struct notes fresh, lasting = {0};
  KITH_TRY(listen(m, "plan", &fresh));
  if (later > 0) KITH_TRY(listen(m, NULL, &lasting));
  *out = (struct kith_step_habits){.lists = lists,
                                   .refreshes = lists * fresh.calls + later * lasting.calls,
                                   .refresh_bytes = lists * fresh.bytes + later * lasting.bytes,
                                   .collectives = lists * (OF_A_LIST + OF_A_BOUNDARY * m->boundaries.n) +
                                                  evaluations * OF_AN_EVALUATION + OF_A_STEP,
                                   .culls = m->integrator.cull && !built->ghost_rows && !built->overlap};
  const int n = kith_nodes_ghost_fields(m->nodes, fields);
  for (int f = 0; f < n; ++f) out->creation_bytes += (double)kith_field_node_size(fields[f]);
  return KITH_OK;
}

/* ---- outlook ---- */

struct place { /* of a cell: the box around its nodes, and their largest reach; reach < 0: no nodes */
  struct kith_box box;
  double reach;
};

struct kith_outlook {
  const struct kith_model *model;
  struct kith_cells cells;
  struct place *place; /* [cells.n] */
  double *work;        /* [cells.n] */
  double reach;        /* the largest of all */
  double factor;       /* f */
  double places;       /* cells that are not empty */
  double test;         /* seconds to test one of them */
  int n_ranks;
};

int64_t kith_outlook_cells(const struct kith_outlook *outlook) {
  return outlook->cells.n;
}

/* What a rank would have. */
struct load {
  double nodes, made, kept;
  double sent, sent_kept;          /* nodes, each as often as it goes */
  double to, from, to_kept, peers; /* ranks */
};

static void fill_cells(struct kith_outlook *o) {
  const struct kith_nodes *nodes = o->model->nodes;
  const struct kith_rows *rows = &o->model->connectivity->rows;
  for (int64_t c = 0; c < o->cells.n; ++c) o->place[c] = (struct place){kith_box_empty(), -1};
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    const int64_t c = kith_cells_of(&o->cells, x);
    kith_box_include(&o->place[c].box, x);
    o->place[c].reach = fmax(o->place[c].reach, nodes->reach->f64[i]);
    o->reach = fmax(o->reach, nodes->reach->f64[i]);
    o->work[c] += 1 + (double)(rows->first[i + 1] - rows->first[i]);
  }
}

/* How long it takes to look whether places are near. */
static void time_tests(struct kith_outlook *o) {
  const double start = kith_seconds();
  double nearest = INFINITY;
  for (int64_t c = 0; c < o->cells.n; ++c) {
    if (o->place[c].reach < 0) continue;
    o->places += 1;
    nearest = fmin(nearest, kith_box_distance2(&o->place[c].box, o->cells.lower));
  }
  o->test = nearest < INFINITY ? (kith_seconds() - start) / o->places : 0;
}

static kith_status look(struct kith_outlook *o, int n_ranks) {
  const struct kith_model *m = o->model;
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->boundary[a].lower == &kith_boundary_periodic;
  KITH_TRY(kith_share_cells(&o->cells, m->nodes, &m->scene->domain, periodic,
                            (int64_t)m->scene->partition.cells * n_ranks));
  KITH_TRY(kith_resize(&o->place, 0, (size_t)o->cells.n, sizeof *o->place));
  KITH_TRY(kith_resize(&o->work, 0, (size_t)o->cells.n, sizeof *o->work));
  o->n_ranks = n_ranks;
  o->factor = m->connectivity->built.overlap ? 2 : 1;
  fill_cells(o);
  time_tests(o);
  return KITH_OK;
}

kith_status kith_outlook_create(struct kith_outlook **out, const struct kith_model *model, int n_ranks) {
  *out = NULL;
  if (n_ranks > MOST_RANKS) KITH_FAIL(BAD_INPUT, "no forecast for more than %d ranks", MOST_RANKS);
  if (model->scene->partition.recompute)
    KITH_FAIL(BAD_INPUT, "partition.ghosts: there is no forecast of recompute; exchange has one");
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  (*out)->model = model;
  const kith_status status = look(*out, n_ranks);
  if (status != KITH_OK) kith_outlook_destroy(out);
  return status;
}

void kith_outlook_destroy(struct kith_outlook **outlook) {
  if (*outlook == NULL) return;
  kith_free(&(*outlook)->place);
  kith_free(&(*outlook)->work);
  kith_free(outlook);
}

/* ---- who is sent where ---- */

struct targets {
  int n;
  bool full; /* there are more */
  struct {
    int32_t rank;
    int shift[NDIM];
  } of[MOST_RANKS_OF_A_NODE];
};

static void aim(struct targets *t, int32_t rank, const int *shift) {
  for (int k = 0; k < t->n; ++k)
    if (t->of[k].rank == rank && memcmp(t->of[k].shift, shift, sizeof t->of[k].shift) == 0) return;
  t->full = t->n == MOST_RANKS_OF_A_NODE;
  if (t->full) return;
  t->of[t->n].rank = rank;
  memcpy(t->of[t->n++].shift, shift, sizeof t->of[0].shift);
}

/* Is the image of x that is displaced by -shift lengths, so that it stands where cell c sees it, within reach of c? */
static bool reaches(const struct kith_outlook *o, const double *x, double reach, int64_t c,
                    const int *shift) {
  const struct place *p = &o->place[c];
  double d2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double y = x[a] - shift[a] * (o->cells.upper[a] - o->cells.lower[a]);
    const double d = fmax(0, fmax(p->box.lower[a] - y, y - p->box.upper[a]));
    d2 += d * d;
  }
  const double r = o->factor * fmax(reach, p->reach);
  return p->reach >= 0 && d2 <= r * r;
}

/* All cells around x, box by box of the unfolded grid. */
static void find_targets(const struct kith_outlook *o, const int32_t *owner, const double *x, double reach,
                         int32_t own, struct targets *t) {
  const struct kith_cells *g = &o->cells;
  int64_t low[NDIM], high[NDIM], k[NDIM];
  t->n = 0, t->full = false;
  for (int a = 0; a < NDIM; ++a) {
    low[a] = (int64_t)floor((x[a] - o->factor * o->reach - g->lower[a]) / g->edge[a]);
    high[a] = (int64_t)floor((x[a] + o->factor * o->reach - g->lower[a]) / g->edge[a]);
    if (!g->periodic[a]) { /* images are outside */
      low[a] = KITH_MIN(KITH_MAX(low[a], 0), g->count[a] - 1);
      high[a] = KITH_MAX(KITH_MIN(high[a], g->count[a] - 1), 0);
    }
    k[a] = low[a];
  }
  for (bool more = true; more;) {
    int64_t inside[NDIM];
    int shift[NDIM];
    for (int a = 0; a < NDIM; ++a) {
      shift[a] = (int)floor((double)k[a] / (double)g->count[a]);
      inside[a] = k[a] - shift[a] * g->count[a];
    }
    const int64_t c = kith_cells_at(g, inside);
    if (owner[c] != own && reaches(o, x, reach, c, shift)) aim(t, owner[c], shift);
    more = false;
    for (int a = 0; a < NDIM && !more; ++a) {
      more = k[a] < high[a];
      k[a] = more ? k[a] + 1 : low[a];
    }
  }
}

enum { MADE = 1, KEPT = 2 }; /* of a pair of ranks */

/* The rank of every node and image; -1: of a frozen one, which all have. */
static void find_ranks(const struct kith_outlook *o, const int32_t *owner, int32_t *rank) {
  const struct kith_nodes *nodes = o->model->nodes;
  for (kith_index i = 0; i < nodes->n_internal; ++i)
    rank[i] = owner[kith_cells_of(&o->cells, nodes->position->f64 + (size_t)i * NDIM)];
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    for (kith_index k = 0; k < block->count; ++k)
      rank[block->first + k] = block->control != NULL ? rank[block->control[k]] : -1;
  }
}

/* Periodic images are found from their nodes, in any number; mirror images are those that the lists have. */
static void mark_periodic(const struct kith_model *m, uint8_t *periodic) {
  for (int b = 0; b < m->nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &m->nodes->blocks[b];
    const bool all = m->boundaries.boundary[block->boundary]->ops == &kith_boundary_periodic;
    for (kith_index k = 0; k < block->count; ++k)
      periodic[block->first + k] = all || (block->control != NULL && periodic[block->control[k]]);
  }
}

static kith_status count_made(const struct kith_outlook *o, const int32_t *owner, const int32_t *rank,
                              const uint8_t *periodic, struct load *load, uint8_t *meets) {
  const struct kith_nodes *nodes = o->model->nodes;
  for (kith_index i = 0; i < kith_nodes_count(nodes); ++i) {
    struct targets t;
    if (rank[i] < 0 || periodic[i]) continue;
    struct load *own = &load[rank[i]];
    find_targets(o, owner, nodes->position->f64 + (size_t)i * NDIM, nodes->reach->f64[i], rank[i], &t);
    if (t.full) KITH_FAIL(UNSUPPORTED, "a node is sent to more than %d ranks", MOST_RANKS_OF_A_NODE);
    own->nodes += i < nodes->n_internal, own->sent += t.n;
    for (int k = 0; k < t.n; ++k) {
      load[t.of[k].rank].made += 1;
      meets[(size_t)rank[i] * (size_t)o->n_ranks + (size_t)t.of[k].rank] |= MADE;
    }
  }
  return KITH_OK;
}

/* ---- who is kept ---- */

/* The nodes, rank by rank. */
static void sort_by_rank(const struct kith_outlook *o, const int32_t *rank, const struct load *load,
                         kith_index *order, kith_index *first) {
  first[0] = 0;
  for (int r = 0; r < o->n_ranks; ++r) first[r + 1] = first[r] + (kith_index)load[r].nodes;
  for (kith_index i = 0; i < o->model->nodes->n_internal; ++i) order[first[rank[i]]++] = i;
  for (int r = o->n_ranks; r > 0; --r) first[r] = first[r - 1];
  first[0] = 0;
}

/* Rank by rank all partners that are not its own, each once: seen[j] is 1 + the last rank that met j. */
static void count_rows(const struct kith_outlook *o, const int32_t *rank, const kith_index *order,
                       int32_t *seen, struct load *load, uint8_t *meets) {
  const struct kith_rows *rows = &o->model->connectivity->rows;
  for (kith_index k = 0; k < o->model->nodes->n_internal; ++k) {
    const kith_index i = order[k];
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const kith_index j = rows->node[e];
      if (rank[j] < 0 || rank[j] == rank[i] || seen[j] == rank[i] + 1) continue;
      seen[j] = rank[i] + 1;
      load[rank[i]].kept += 1, load[rank[j]].sent_kept += 1;
      meets[(size_t)rank[j] * (size_t)o->n_ranks + (size_t)rank[i]] |= KEPT;
    }
  }
}

/* Scratch, a value for each node and image but for `first`. */
struct marks {
  int32_t *rank, *seen;
  uint8_t *periodic;
  kith_index *order, *first; /* first: [ranks + 1] */
};

static kith_status marks_room(const struct kith_outlook *o, struct marks *m) {
  const size_t n = (size_t)kith_nodes_count(o->model->nodes);
  KITH_TRY(kith_resize(&m->rank, 0, n, sizeof *m->rank));
  KITH_TRY(kith_resize(&m->seen, 0, n, sizeof *m->seen));
  KITH_TRY(kith_resize(&m->periodic, 0, n, 1));
  KITH_TRY(kith_resize(&m->order, 0, n, sizeof *m->order));
  return kith_resize(&m->first, 0, (size_t)o->n_ranks + 1, sizeof *m->first);
}

static void marks_clear(struct marks *m) {
  kith_free(&m->rank);
  kith_free(&m->seen);
  kith_free(&m->periodic);
  kith_free(&m->order);
  kith_free(&m->first);
}

static kith_status count_ghosts(const struct kith_outlook *o, const int32_t *owner, bool culls,
                                struct load *load, uint8_t *meets) {
  struct marks m = {0};
  kith_status status = marks_room(o, &m);
  if (status == KITH_OK) {
    find_ranks(o, owner, m.rank);
    mark_periodic(o->model, m.periodic);
    status = count_made(o, owner, m.rank, m.periodic, load, meets);
  }
  if (status == KITH_OK && culls) {
    sort_by_rank(o, m.rank, load, m.order, m.first);
    count_rows(o, m.rank, m.order, m.seen, load, meets);
  }
  marks_clear(&m);
  return status;
}

static void count_peers(const struct kith_outlook *o, const uint8_t *meets, struct load *load) {
  const size_t n = (size_t)o->n_ranks;
  for (size_t k = 0; k < n * n; ++k) {
    const uint8_t there = meets[k], back = meets[k % n * n + k / n];
    load[k / n].to += (there & MADE) != 0, load[k / n].from += (back & MADE) != 0;
    load[k / n].to_kept += (there & KEPT) != 0;
    load[k / n].peers += (there | back) != 0;
  }
}

static kith_status load_ranks(const struct kith_outlook *o, const int32_t *owner, bool culls,
                              struct load *load) {
  const size_t n = (size_t)o->n_ranks;
  uint8_t *meets = NULL; /* [from][to] */
  KITH_TRY(kith_resize(&meets, 0, n * n, 1));
  memset(load, 0, n * sizeof *load);
  const kith_status status = count_ghosts(o, owner, culls, load, meets);
  count_peers(o, meets, load);
  for (size_t r = 0; !culls && r < n; ++r)
    load[r].kept = load[r].made, load[r].sent_kept = load[r].sent, load[r].to_kept = load[r].to;
  kith_free(&meets);
  return status;
}

/* ---- one partitioner ---- */

static void add_up(const struct kith_outlook *o, const struct load *load, const struct kith_step_habits *h,
                   struct kith_forecast *f) {
  for (int r = 0; r < o->n_ranks; ++r) {
    const struct load *l = &load[r];
    const double messages = h->lists * (l->to + (h->culls ? l->from : 0)) + h->refreshes * l->to_kept;
    const double bytes =
        h->lists * (l->sent * h->creation_bytes + (h->culls ? l->made : 0)) + h->refresh_bytes * l->sent_kept;
    f->made += l->made / o->n_ranks, f->most_made = fmax(f->most_made, l->made);
    f->kept += l->kept / o->n_ranks, f->most_peers = fmax(f->most_peers, l->peers);
    f->messages += messages / o->n_ranks, f->most_messages = fmax(f->most_messages, messages);
    f->bytes += bytes / o->n_ranks, f->most_bytes = fmax(f->most_bytes, bytes);
  }
}

static void take_time(const struct kith_outlook *o, const struct kith_step_habits *h,
                      const struct kith_costs *c, struct kith_forecast *f) {
  const struct kith_network *net = &c->network;
  const double places = h->lists * o->places;
  f->seconds.work = c->work * f->work;
  f->seconds.ghosts = c->ghost * f->most_made;
  f->seconds.places = places * (sizeof(struct place) / net->bandwidth + o->test);
  f->seconds.network =
      net->latency * (f->most_messages + h->collectives * log2(o->n_ranks)) + f->most_bytes / net->bandwidth;
  f->seconds.step = f->seconds.work + f->seconds.ghosts + f->seconds.places + f->seconds.network;
}

static kith_status look_at_map(const struct kith_outlook *o, const struct kith_partition *partition,
                               const struct kith_step_habits *habits, struct kith_forecast *out) {
  struct kith_partition_figures all;
  struct kith_rank_figures *rank = NULL;
  struct load *load = NULL;
  kith_status status = kith_resize(&load, 0, (size_t)o->n_ranks, sizeof *load);
  if (status == KITH_OK) status = kith_resize(&rank, 0, (size_t)o->n_ranks, sizeof *rank);
  if (status == KITH_OK) status = kith_partition_figures(partition, o->work, NULL, rank, &all);
  if (status == KITH_OK) status = load_ranks(o, partition->owner, habits->culls, load);
  if (status == KITH_OK) {
    *out = (struct kith_forecast){.imbalance = all.imbalance, .work = all.largest_weight};
    add_up(o, load, habits, out);
  }
  kith_free(&load);
  kith_free(&rank);
  return status;
}

kith_status kith_outlook_forecast(const struct kith_outlook *o, const char *partitioner,
                                  const struct kith_step_habits *habits, const struct kith_costs *costs,
                                  struct kith_forecast *out) {
  struct kith_partition *partition = NULL;
  KITH_TRY(kith_partition_create(&partition, &o->cells, o->n_ranks, partitioner));
  kith_status status = kith_partition_settle(partition, o->work);
  if (status == KITH_OK) status = look_at_map(o, partition, habits, out);
  if (status == KITH_OK) take_time(o, habits, costs, out);
  kith_partition_destroy(&partition);
  return status;
}
