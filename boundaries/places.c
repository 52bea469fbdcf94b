#include "boundaries/places.h"

#include <omp.h>
#include <string.h>

enum { BUNCH = 64 }; /* candidates tested together */

static const struct kith_place nowhere = {.reach = -1};

static void include(struct kith_place *to, const struct kith_place *from) {
  if (!(from->reach >= 0)) return;
  if (!(to->reach >= 0)) to->box = kith_box_empty();
  kith_box_include(&to->box, from->box.lower);
  kith_box_include(&to->box, from->box.upper);
  to->reach = KITH_MAX(to->reach, from->reach);
}

static struct kith_place place_of(const struct kith_nodes *nodes, kith_index i) {
  struct kith_place p = {nodes->reach->f64[i], kith_box_empty()};
  kith_box_include(&p.box, nodes->position->f64 + (size_t)i * NDIM);
  return p;
}

/* Each thread has cells of its own; boxes and largest reaches have no order. */
kith_status kith_places_of_cells(const struct kith_nodes *nodes, const struct kith_field *homes,
                                 struct kith_place **places, size_t *n) {
  const int64_t *home = homes->i64;
  const int threads = nodes->n_internal > 10000 ? omp_get_max_threads() : 1;
  int64_t cells = 0;
#pragma omp parallel for schedule(static) reduction(max : cells) num_threads(threads)
  for (kith_index i = 0; i < nodes->n_internal; ++i) cells = KITH_MAX(cells, home[i] + 1);
  const size_t all = (size_t)cells * (size_t)threads;
  struct kith_place *place = NULL;
  KITH_TRY(kith_resize(&place, 0, all, sizeof *place));
  for (size_t c = 0; c < all; ++c) place[c] = nowhere;
#pragma omp parallel num_threads(threads)
  {
    struct kith_place *mine = place + (size_t)cells * (size_t)omp_get_thread_num();
#pragma omp for schedule(static)
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      const struct kith_place p = place_of(nodes, i);
      include(&mine[home[i]], &p);
    }
  }
  for (size_t c = (size_t)cells; c < all; ++c) include(&place[c % (size_t)cells], &place[c]);
  *n = (size_t)cells;
  *places = place;
  return KITH_OK;
}

size_t kith_places_pack(struct kith_place *place, size_t n) {
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
static bool reaches(const struct kith_place *from, const struct kith_place *to, double factor) {
  return from->reach >= 0 &&
         within(box_distance2(&from->box, &to->box), factor, KITH_MAX(from->reach, to->reach));
}

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

double kith_place_widest(const struct kith_place *own, const struct kith_cells *cells,
                         const struct kith_place *all, size_t n) {
  double reach = own->reach;
  for (size_t k = 0; k < n; ++k)
    if (all[k].reach > reach && within(image_distance2(cells, &own->box, &all[k].box), 1, all[k].reach))
      reach = all[k].reach;
  return reach;
}

/* ---- who is sent where ---- */

static void mark_frozen(const struct kith_nodes *nodes, uint8_t *frozen) {
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    for (kith_index k = 0; k < block->count; ++k)
      frozen[block->first + k] = block->control == NULL || frozen[block->control[k]];
  }
}

kith_status kith_candidates_gather(struct kith_candidates *c, const struct kith_nodes *nodes) {
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
      const struct kith_place p = place_of(nodes, i);
      if (!c->kept[i]) include(&c->bunch[b], &p);
    }
  }
  for (int b = 0; b < c->bunches; ++b) include(&c->all, &c->bunch[b]);
  return KITH_OK;
}

static void mark_bunch(const struct kith_candidates *c, const struct kith_nodes *nodes, int b,
                       const struct kith_place *there, int n, double factor) {
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
static void sweep(const struct kith_candidates *c, const struct kith_nodes *nodes, int64_t *place,
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
static kith_status collect(struct kith_candidates *c, const struct kith_nodes *nodes, kith_index **send,
                           kith_index *n_send, int64_t *count) {
  int64_t place[KITH_MAX_LISTS], total = 0;
  sweep(c, nodes, count, NULL);
  for (int l = 0; l < nodes->n_lists; ++l) place[l] = total, total += count[l];
  KITH_TRY(kith_resize(send, 0, (size_t)total, sizeof **send));
  sweep(c, nodes, place, *send);
  *n_send = (kith_index)total;
  return KITH_OK;
}

/* Places that are far from all of ours are passed over. */
kith_status kith_candidates_near(struct kith_candidates *c, const struct kith_nodes *nodes,
                                 struct kith_place *there, size_t n, double factor, kith_index **send,
                                 kith_index *n_send, int64_t *count) {
  int near = 0;
  struct kith_place whole = nowhere;
  for (size_t k = 0; k < n; ++k)
    if (reaches(&c->all, &there[k], factor)) include(&whole, &there[k]), there[near++] = there[k];
  *n_send = 0;
  if (near == 0) return KITH_OK;
#pragma omp parallel for schedule(dynamic, 16) if (c->bunches > 64)
  for (int b = 0; b < c->bunches; ++b) /* most are far from all of that rank */
    mark_bunch(c, nodes, b, there, reaches(&c->bunch[b], &whole, factor) ? near : 0, factor);
  return collect(c, nodes, send, n_send, count);
}

void kith_candidates_clear(struct kith_candidates *c) {
  kith_free(&c->kept);
  kith_free(&c->bunch);
  kith_free(&c->hit);
}
