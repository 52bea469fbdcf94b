#include "app/symmetry.h"

#include <math.h>
#include <stdlib.h>

struct place {
  uint64_t key;
  kith_index node;
};

/* 21 bits of each of the first `axes` coordinates; `flip` is mirrored, -1: none. The odd shift keeps lattices off the edges of the cells. */
static uint64_t key_of(const struct kith_box *box, const double *x, int axes, int flip) {
  uint64_t key = 0;
  for (int a = 0; a < axes; ++a) {
    const double at = a == flip ? box->lower[a] + box->upper[a] - x[a] : x[a];
    const double cells =
        floor((at - box->lower[a]) / (box->upper[a] - box->lower[a]) * 0x1p20 + 0.3719173) + 0x1p19;
    key = key << 21 | (uint64_t)fmin(fmax(cells, 0), 0x1p21 - 1);
  }
  return key;
}

static int by_key(const void *a, const void *b) {
  const struct place *p = a, *q = b;
  return p->key != q->key ? (p->key > q->key) - (p->key < q->key) : (p->node > q->node) - (p->node < q->node);
}

static void sort_places(struct place *place, const struct kith_hydro *hydro, const struct kith_box *box,
                        int axes) {
  const kith_index n = hydro->nodes->n_internal;
  for (kith_index i = 0; i < n; ++i)
    place[i] = (struct place){key_of(box, hydro->nodes->position->f64 + (size_t)i * NDIM, axes, -1), i};
  qsort(place, (size_t)n, sizeof *place, by_key);
}

static bool near(double a, double b, double size) {
  return fabs(a - b) <= 1e-9 * size;
}

/* The same list, mass, energy and velocity, but for the sign of the velocity along `flip`. */
static bool alike(const struct kith_hydro *hydro, kith_index i, kith_index j, int flip, double speed) {
  const double *v = hydro->velocity->f64 + (size_t)i * NDIM, *w = hydro->velocity->f64 + (size_t)j * NDIM;
  for (int a = 0; a < NDIM; ++a)
    if (!near(v[a], a == flip ? -w[a] : w[a], speed)) return false;
  const double mass = hydro->mass->f64[i], energy = hydro->energy->f64[i];
  return hydro->nodes->list->u8[i] == hydro->nodes->list->u8[j] && near(mass, hydro->mass->f64[j], mass) &&
         near(energy, hydro->energy->f64[j], fabs(energy));
}

static bool mirrored(const struct kith_hydro *hydro, const struct kith_box *box, const struct place *place,
                     int axis, double speed) {
  const kith_index n = hydro->nodes->n_internal;
  for (kith_index i = 0; i < n; ++i) {
    const struct place wanted = {key_of(box, hydro->nodes->position->f64 + (size_t)i * NDIM, NDIM, axis), 0};
    kith_index low = 0;
    for (kith_index high = n; low < high;) { /* the first with this key */
      const kith_index middle = low + (high - low) / 2;
      if (place[middle].key < wanted.key)
        low = middle + 1;
      else
        high = middle;
    }
    if (low == n || place[low].key != wanted.key || !alike(hydro, i, place[low].node, axis, speed))
      return false;
  }
  return true;
}

/* Does nothing change along the axes behind the first `axes`, and nothing move along them? */
static bool varies_only(const struct kith_hydro *hydro, const struct place *place, int axes, double speed) {
  const kith_index n = hydro->nodes->n_internal;
  kith_index shared = 0;
  for (kith_index k = 0; k < n; ++k) {
    for (int a = axes; a < NDIM; ++a)
      if (!near(hydro->velocity->f64[(size_t)place[k].node * NDIM + a], 0, speed)) return false;
    if (k == 0 || place[k].key != place[k - 1].key) continue;
    if (!alike(hydro, place[k].node, place[k - 1].node, -1, speed)) return false;
    ++shared;
  }
  return shared > n / 2;
}

kith_status kith_symmetry_find(struct kith_symmetry *symmetry, const struct kith_hydro *hydro,
                               const struct kith_box *box) {
  const kith_index n = hydro->nodes->n_internal;
  struct place *place = NULL;
  double speed = 0;
  *symmetry = (struct kith_symmetry){.dimension = NDIM};
  KITH_TRY(kith_resize(&place, 0, (size_t)n, sizeof *place));
  for (kith_index k = 0; k < n * NDIM; ++k) speed = fmax(speed, fabs(hydro->velocity->f64[k]));
  sort_places(place, hydro, box, NDIM);
  for (int a = 0; a < NDIM; ++a) symmetry->mirrored[a] = n > 0 && mirrored(hydro, box, place, a, speed);
  for (int axes = NDIM - 1; axes >= 1; --axes) {
    sort_places(place, hydro, box, axes);
    if (!varies_only(hydro, place, axes, speed)) break;
    symmetry->dimension = axes;
  }
  kith_free(&place);
  return KITH_OK;
}
