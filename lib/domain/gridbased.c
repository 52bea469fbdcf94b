/* gridbased.c - a Cartesian mesh of ranks whose corners move: the topology stays, the shapes follow the load.
 *
 * Begau and Sutmann, Comput. Phys. Commun. 190, 51 (2015). Every corner is pulled towards the middles of the up to
 * 2^NDIM ranks around it, harder by those with more load than their mean, so that they shrink:
 *
 *   move = STEP / n  sum over the n ranks r around of (load_r / mean - 1) (unit vector to the middle of r)
 *
 * in units of the regular spacing of each axis,
 * and half of that, and so on, until the mesh is valid. On a face of the box that is not periodic a corner stays in
 * that face. An update is 2^NDIM rounds, one for each color of corners (odd and even places along the axes), so that
 * no two that share a rank's edge go at once. A round is halved, too, until the sum of squares of the loads does
 * not rise, and left out if that does not help.
 *
 * A rank's shape is its NDIM! simplices about one diagonal (the same diagonal everywhere, so that faces fit). The mesh
 * is valid if all of them have a positive volume: then they cover the box once. A cell belongs to the first rank
 * in whose closed shape its midpoint is. All this in whole numbers of 1/unit of a cell: exact, without rounding. */
#include "lib/domain/partition.h"

#include <string.h>

enum { SHAPE_CORNERS = 1 << NDIM, SIMPLICES = NDIM == 3 ? 6 : NDIM, HALVINGS = 3 };
/* The box has this many bits at most: products of NDIM differences of up to four boxes fit into 64. */
enum { LENGTH_BITS = NDIM == 3 ? 18 : NDIM == 2 ? 28 : 50, UNIT_BITS = 20 };
static const double STEP = 1;

/* Along these axes from corner to corner; the second half of them is left-handed. */
#if NDIM == 1
static const int PATH[SIMPLICES][NDIM] = {{0}};
#elif NDIM == 2
static const int PATH[SIMPLICES][NDIM] = {{0, 1}, {1, 0}};
#else
static const int PATH[SIMPLICES][NDIM] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};
#endif

struct mesh {
  int ranks[NDIM];
  int64_t corners[NDIM], n_corners; /* distinct ones: no last one on a periodic axis */
  int64_t unit, length[NDIM];       /* of a cell; of the box */
  int64_t *corner;                  /* [n_corners][NDIM] owned */
  int64_t *trial;                   /* [n_corners][NDIM] owned */
};

struct shape {
  int64_t corner[SHAPE_CORNERS][NDIM];
};

/* ---- geometry ---- */

/* NDIM! times the signed volume. */
static int64_t volume(const int64_t *const *v) {
  int64_t d[NDIM][NDIM];
  for (int k = 0; k < NDIM; ++k)
    for (int a = 0; a < NDIM; ++a) d[k][a] = v[k + 1][a] - v[0][a];
#if NDIM == 1
  return d[0][0];
#elif NDIM == 2
  return d[0][0] * d[1][1] - d[0][1] * d[1][0];
#else
  return d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
         d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
         d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
#endif
}

/* The vertices of simplex s; returns its orientation in a regular mesh. */
static int simplex(const struct shape *shape, int s, const int64_t **v) {
  int at = 0;
  v[0] = shape->corner[0];
  for (int k = 0; k < NDIM; ++k) {
    at |= 1 << PATH[s][k];
    v[k + 1] = shape->corner[at];
  }
  return NDIM > 1 && s >= SIMPLICES / 2 ? -1 : 1;
}

static bool is_valid(const struct shape *shape) {
  for (int s = 0; s < SIMPLICES; ++s) {
    const int64_t *v[NDIM + 1];
    const int orientation = simplex(shape, s, v);
    if (orientation * volume(v) <= 0) return false;
  }
  return true;
}

static bool contains(const struct shape *shape, const int64_t *x) {
  for (int s = 0; s < SIMPLICES; ++s) {
    const int64_t *v[NDIM + 1];
    const int orientation = simplex(shape, s, v);
    bool inside = true;
    for (int k = 0; k <= NDIM && inside; ++k) {
      const int64_t *vertex = v[k];
      v[k] = x;
      inside = orientation * volume(v) >= 0;
      v[k] = vertex;
    }
    if (inside) return true;
  }
  return false;
}

/* ---- the mesh ---- */

/* Place i of the corners, which may be an image; what to add to the corner there. Returns its number. */
static int64_t corner_number(const struct mesh *mesh, const int64_t *i, int64_t *shift) {
  int64_t number = 0;
  for (int a = NDIM - 1; a >= 0; --a) {
    const bool periodic = mesh->corners[a] == mesh->ranks[a];
    const int64_t around = !periodic ? 0 : i[a] < 0 ? -1 : i[a] >= mesh->corners[a];
    shift[a] = around * mesh->length[a];
    number = number * mesh->corners[a] + i[a] - around * mesh->corners[a];
  }
  return number;
}

/* Of the rank at place i of the mesh, which may be an image. */
static struct shape shape_at(const struct mesh *mesh, const int64_t *corner, const int64_t *i) {
  struct shape shape;
  for (int k = 0; k < SHAPE_CORNERS; ++k) {
    int64_t at[NDIM], shift[NDIM];
    for (int a = 0; a < NDIM; ++a) at[a] = i[a] + (k >> a & 1);
    const int64_t number = corner_number(mesh, at, shift);
    for (int a = 0; a < NDIM; ++a) shape.corner[k][a] = corner[number * NDIM + a] + shift[a];
  }
  return shape;
}

/* The rank number k around corner i: its place in the mesh. -1: there is none. */
static int rank_around(const struct mesh *mesh, const int64_t *i, int k, int64_t *place) {
  int64_t rank = 0;
  for (int a = NDIM - 1; a >= 0; --a) {
    place[a] = i[a] - (k >> a & 1);
    const bool periodic = mesh->corners[a] == mesh->ranks[a],
               inside = place[a] >= 0 && place[a] < mesh->ranks[a];
    if (!inside && !periodic) return -1;
    rank = rank * mesh->ranks[a] + (place[a] < 0 ? mesh->ranks[a] - 1 : place[a]);
  }
  return (int)rank;
}

static void place_of(const int64_t *counts, int64_t number, int64_t *i) {
  for (int a = 0; a < NDIM; ++a) {
    i[a] = number % counts[a];
    number /= counts[a];
  }
}

/* ---- cells ---- */

/* Gives the rank all cells whose midpoint is in its shape and that have no owner yet. */
static void fill(const struct mesh *mesh, const struct kith_cells *cells, const struct shape *shape, int rank,
                 int32_t *owner) {
  int64_t first[NDIM], extent[NDIM], n = 1; /* cells whose midpoints are in the bounding box */
  for (int a = 0; a < NDIM; ++a) {
    int64_t low = INT64_MAX, high = INT64_MIN;
    for (int k = 0; k < SHAPE_CORNERS; ++k) {
      low = KITH_MIN(low, shape->corner[k][a]);
      high = KITH_MAX(high, shape->corner[k][a]);
    }
    first[a] = (low + mesh->length[a]) / mesh->unit - cells->count[a]; /* floor, also below zero */
    extent[a] = (high + mesh->length[a]) / mesh->unit - cells->count[a] - first[a] + 1;
    n *= extent[a];
  }
  for (int64_t number = 0; number < n; ++number) {
    int64_t k[NDIM], x[NDIM];
    place_of(extent, number, k);
    for (int a = 0; a < NDIM; ++a) {
      k[a] += first[a];
      x[a] = k[a] * mesh->unit + mesh->unit / 2;
      k[a] = (k[a] + 2 * cells->count[a]) % cells->count[a];
    }
    const int64_t c = kith_cells_at(cells, k);
    if (owner[c] < 0 && contains(shape, x)) owner[c] = rank;
  }
}

static void fill_all(const struct mesh *mesh, const int64_t *corner, const struct kith_cells *cells,
                     int32_t *owner) {
  int64_t ranks[NDIM], n_ranks = 1;
  for (int a = 0; a < NDIM; ++a) n_ranks *= ranks[a] = mesh->ranks[a];
  for (int64_t c = 0; c < cells->n; ++c) owner[c] = -1;
  for (int64_t rank = 0; rank < n_ranks; ++rank) {
    int64_t i[NDIM];
    place_of(ranks, rank, i);
    const struct shape shape = shape_at(mesh, corner, i);
    fill(mesh, cells, &shape, (int)rank, owner);
  }
}

/* ---- moves ---- */

static void middle_of(const struct shape *shape, double *middle) {
  for (int a = 0; a < NDIM; ++a) {
    double sum = 0;
    for (int k = 0; k < SHAPE_CORNERS; ++k) sum += (double)shape->corner[k][a];
    middle[a] = sum / SHAPE_CORNERS;
  }
}

/* How far corner i wants to go. */
static void pull_of(const struct mesh *mesh, const double *load, const int64_t *i, double *move) {
  int64_t shift[NDIM], place[NDIM];
  const int64_t *here = &mesh->corner[corner_number(mesh, i, shift) * NDIM];
  double spacing[NDIM], mean = 0, n = 0;
  for (int a = 0; a < NDIM; ++a) {
    spacing[a] = (double)mesh->length[a] / mesh->ranks[a];
    move[a] = 0;
  }
  for (int k = 0; k < SHAPE_CORNERS; ++k) {
    const int rank = rank_around(mesh, i, k, place);
    if (rank >= 0) mean += load[rank], ++n;
  }
  mean /= n;
  for (int k = 0; k < SHAPE_CORNERS && mean > 0; ++k) {
    const int rank = rank_around(mesh, i, k, place);
    if (rank < 0) continue;
    const struct shape shape = shape_at(mesh, mesh->corner, place);
    double to[NDIM];
    middle_of(&shape, to);
    for (int a = 0; a < NDIM; ++a) to[a] = (to[a] - (double)here[a]) / spacing[a];
    const double pull = (load[rank] / mean - 1) / kith_norm(to) * STEP / n;
    for (int a = 0; a < NDIM; ++a) move[a] += pull * to[a] * spacing[a];
  }
  for (int a = 0; a < NDIM; ++a) /* faces of the box */
    if (mesh->corners[a] > mesh->ranks[a] && (i[a] == 0 || i[a] == mesh->ranks[a])) move[a] = 0;
}

static bool valid_around(const struct mesh *mesh, const int64_t *i) {
  for (int k = 0; k < SHAPE_CORNERS; ++k) {
    int64_t place[NDIM];
    if (rank_around(mesh, i, k, place) < 0) continue;
    const struct shape shape = shape_at(mesh, mesh->trial, place);
    if (!is_valid(&shape)) return false;
  }
  return true;
}

/* Moves a corner of the trial mesh, less far if need be. Half a box out at most: its numbers must stay small. */
static void move_corner(const struct mesh *mesh, const int64_t *i, double *move) {
  int64_t shift[NDIM];
  const int64_t number = corner_number(mesh, i, shift);
  const int64_t *from = &mesh->corner[number * NDIM];
  int64_t *to = &mesh->trial[number * NDIM];
  for (int halving = 0; halving < HALVINGS; ++halving) {
    bool near = true;
    for (int a = 0; a < NDIM; ++a) {
      to[a] = from[a] + (int64_t)move[a];
      near = near && 2 * to[a] >= -mesh->length[a] && 2 * to[a] <= 3 * mesh->length[a];
      move[a] *= 0.5;
    }
    if (near && valid_around(mesh, i)) return;
  }
  for (int a = 0; a < NDIM; ++a) to[a] = from[a];
}

/* Moves the corners of one color, numbered by odd and even places, of the trial mesh. */
static void move_color(const struct mesh *mesh, const double *load, int color, double scale) {
  for (int64_t k = 0; k < mesh->n_corners * NDIM; ++k) mesh->trial[k] = mesh->corner[k];
  for (int64_t number = 0; number < mesh->n_corners; ++number) {
    int64_t i[NDIM];
    double move[NDIM];
    place_of(mesh->corners, number, i);
    int own = 0;
    for (int a = 0; a < NDIM; ++a) own |= (int)(i[a] & 1) << a;
    if (own != color) continue;
    pull_of(mesh, load, i, move);
    for (int a = 0; a < NDIM; ++a) move[a] *= scale;
    move_corner(mesh, i, move);
  }
}

/* The work of every rank; returns the sum of its squares. */
static double loads_of(const struct kith_partition *partition, const double *weight, const int32_t *owner,
                       double *load) {
  double squares = 0;
  for (int r = 0; r < partition->n_ranks; ++r) load[r] = 0;
  for (int64_t c = 0; c < partition->cells->n; ++c) load[owner[c]] += weight[c];
  for (int r = 0; r < partition->n_ranks; ++r) squares += load[r] * load[r];
  return squares;
}

/* One round: all corners of a color, less far if that is no gain, or not at all. load[] and `squares` follow. */
static void round_of(const struct kith_partition *partition, const double *weight, int color, int32_t *owner,
                     double *load, double *trial_load, double *squares) {
  struct mesh *mesh = partition->self;
  double scale = 1;
  for (int halving = 0; halving < HALVINGS; ++halving, scale *= 0.5) {
    move_color(mesh, load, color, scale);
    fill_all(mesh, mesh->trial, partition->cells, owner);
    const double trial = loads_of(partition, weight, owner, trial_load);
    if (trial > *squares) continue;
    *squares = trial;
    memcpy(load, trial_load, sizeof *load * (size_t)partition->n_ranks);
    int64_t *moved = mesh->trial;
    mesh->trial = mesh->corner;
    mesh->corner = moved;
    return;
  }
}

/* ---- the member ---- */

static kith_status gridbased_first(struct kith_partition *partition, int32_t *owner) {
  struct mesh *mesh = partition->self;
  const struct kith_cells *cells = partition->cells;
  kith_partition_mesh(cells, partition->n_ranks, mesh->ranks);
  int64_t longest = 1;
  for (int a = 0; a < NDIM; ++a) longest = KITH_MAX(longest, cells->count[a]);
  int bits = UNIT_BITS;
  while (bits > 0 && longest << bits > INT64_C(1) << LENGTH_BITS) --bits;
  mesh->unit = INT64_C(1) << bits;
  mesh->n_corners = 1;
  for (int a = 0; a < NDIM; ++a) {
    mesh->length[a] = cells->count[a] * mesh->unit;
    mesh->corners[a] = mesh->ranks[a] + (cells->periodic[a] ? 0 : 1);
    mesh->n_corners *= mesh->corners[a];
    if (bits == 0 || mesh->length[a] < mesh->ranks[a])
      KITH_FAIL(UNSUPPORTED, "gridbased: %d ranks on %lld cells of axis %d are too many to tell apart",
                mesh->ranks[a], (long long)cells->count[a], a);
  }
  const size_t n = (size_t)mesh->n_corners * NDIM;
  KITH_TRY(kith_resize(&mesh->corner, 0, n, sizeof *mesh->corner));
  KITH_TRY(kith_resize(&mesh->trial, 0, n, sizeof *mesh->trial));
  for (int64_t number = 0; number < mesh->n_corners; ++number) {
    int64_t i[NDIM];
    place_of(mesh->corners, number, i);
    for (int a = 0; a < NDIM; ++a) mesh->corner[number * NDIM + a] = i[a] * mesh->length[a] / mesh->ranks[a];
  }
  fill_all(mesh, mesh->corner, cells, owner);
  return KITH_OK;
}

static kith_status gridbased_update(struct kith_partition *partition, const double *weight,
                                    const double *face_weight, int32_t *owner) {
  (void)face_weight;
  const struct mesh *mesh = partition->self;
  double *load = NULL;
  KITH_TRY(kith_resize(&load, 0, 2 * (size_t)partition->n_ranks, sizeof *load));
  double squares = loads_of(partition, weight, owner, load);
  for (int color = 0; color < SHAPE_CORNERS; ++color)
    round_of(partition, weight, color, owner, load, load + partition->n_ranks, &squares);
  fill_all(mesh, mesh->corner, partition->cells, owner); /* the last trial may have been no gain */
  kith_free(&load);
  return KITH_OK;
}

static void gridbased_clear(struct kith_partition *partition) {
  struct mesh *mesh = partition->self;
  kith_free(&mesh->corner);
  kith_free(&mesh->trial);
}

const struct kith_partitioner_ops kith_partitioner_gridbased = {
    .name = "gridbased",
    .doc = "a Cartesian mesh of ranks whose corners move",
    .state_size = sizeof(struct mesh),
    .first = gridbased_first,
    .update = gridbased_update,
    .clear = gridbased_clear,
};
