/* gridbased.c - a Cartesian mesh of ranks whose corners move: the topology stays, the shapes follow the load.
 *
 * Begau and Sutmann, Comput. Phys. Commun. 190, 51 (2015). Every corner is pulled towards the centers of the
 * up to 2^NDIM ranks around it, more strongly by those with more than their mean load, so that they shrink:
 *
 *   move = step / n  sum over the n ranks r around of (load_r / mean - 1) (unit vector to the center of r)
 *
 * in units of the regular spacing of each axis; half of that, and so on, until the mesh is valid. A corner on
 * a face of the box stays in it, periodic or not. An update has 2^NDIM rounds, one for each color of corners
 * (odd and even positions along the axes), so that no two corners of a rank's edge move at once. A round that
 * raises the sum of squares of the loads is undone, and the step of the color halved, down to 1 / 8;
 * otherwise it is doubled, up to `step`.
 *
 * The shape of a rank consists of NDIM! simplices about one diagonal, the same everywhere. The mesh is valid
 * if all of them have a positive volume: then they cover the box exactly once. A cell belongs to the first
 * rank whose closed shape contains its midpoint. All this is computed in integers: exact. */
#include "lib/domain/partition/partition.h"

#include <string.h>

enum { SHAPE_CORNERS = 1 << NDIM, SIMPLICES = NDIM == 3 ? 6 : NDIM, HALVINGS = 3 };
/* The box has this many bits at most: sums of products of NDIM lengths fit into 63. */
enum { LENGTH_BITS = NDIM == 3 ? 20 : NDIM == 2 ? 30 : 50, UNIT_BITS = 20 };

static const double LEAST_STEP = 1.0 / 8;

struct gridbased {
  double step;
};
static const struct kith_param gridbased_params[] = {
    {"step", KITH_PARAM_NUMBER, "2", "[0.125, 16]",
     "longest step of a corner; steps above 2 overshoot, and cut more faces",
     KITH_INTO(struct gridbased, step)},
    {0}};

/* The corners of a shape that are the vertices of its simplices, of which every second is left-handed. The
 * first NDIM! of them, and NDIM + 1 vertices of each, are those of NDIM dimensions. */
static const int VERTEX[6][4] = {{0, 1, 3, 7}, {0, 2, 3, 7}, {0, 2, 6, 7},
                                 {0, 1, 5, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};

struct mesh {
  int64_t ranks[NDIM], corners[NDIM], n_corners;
  int64_t unit, length[NDIM]; /* of a cell; of the box */
  int64_t *corner, *trial;    /* [n_corners][NDIM] owned */
  double step[SHAPE_CORNERS]; /* of each color */
};

struct shape {
  int64_t corner[SHAPE_CORNERS][NDIM];
};

/* ---- geometry ---- */

/* NDIM! times the volume of simplex s, positive as in a regular mesh; its vertex number `moved` is at x (-1:
 * none is). */
static int64_t volume(const struct shape *shape, int s, int moved, const int64_t *x) {
  const int64_t *v[NDIM + 1];
  int64_t d[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}; /* edges; of length 1 along axes that are not there */
  for (int k = 0; k <= NDIM; ++k) v[k] = k == moved ? x : shape->corner[VERTEX[s][k]];
  for (int k = 0; k < NDIM; ++k)
    for (int a = 0; a < NDIM; ++a) d[k][a] = v[k + 1][a] - v[0][a];
  const int64_t signed_volume = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) +
                                d[0][1] * (d[1][2] * d[2][0] - d[1][0] * d[2][2]) +
                                d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
  return s % 2 == 0 ? signed_volume : -signed_volume;
}

static bool is_valid(const struct shape *shape) {
  int s = 0;
  while (s < SIMPLICES && volume(shape, s, -1, NULL) > 0) ++s;
  return s == SIMPLICES;
}

static bool contains(const struct shape *shape, const int64_t *x) {
  for (int s = 0; s < SIMPLICES; ++s) {
    int k = 0;
    while (k <= NDIM && volume(shape, s, k, x) >= 0) ++k;
    if (k > NDIM) return true;
  }
  return false;
}

/* ---- the mesh ---- */

/* The shape of the rank at position i of the mesh. */
static struct shape shape_at(const struct mesh *mesh, const int64_t *corner, const int64_t *i) {
  struct shape shape;
  for (int k = 0; k < SHAPE_CORNERS; ++k) {
    int64_t at[NDIM];
    for (int a = 0; a < NDIM; ++a) at[a] = i[a] + (k >> a & 1);
    memcpy(shape.corner[k], &corner[kith_grid_number(mesh->corners, at) * NDIM], sizeof shape.corner[k]);
  }
  return shape;
}

/* Is there a rank number k around corner i? Then its position in the mesh. */
static bool place_around(const struct mesh *mesh, const int64_t *i, int k, int64_t *place) {
  bool inside = true;
  for (int a = 0; a < NDIM; ++a) {
    place[a] = i[a] - (k >> a & 1);
    inside = inside && place[a] >= 0 && place[a] < mesh->ranks[a];
  }
  return inside;
}

/* Are all shapes around corner i valid, with these corners of the mesh? */
static bool valid_around(const struct mesh *mesh, const int64_t *corner, const int64_t *i) {
  for (int k = 0; k < SHAPE_CORNERS; ++k) {
    int64_t place[NDIM];
    if (!place_around(mesh, i, k, place)) continue;
    const struct shape shape = shape_at(mesh, corner, place);
    if (!is_valid(&shape)) return false;
  }
  return true;
}

/* ---- cells ---- */

/* Assigns all cells to the first rank whose shape holds their midpoint. */
static void fill(const struct mesh *mesh, const int64_t *corner, const struct kith_partition *partition,
                 int32_t *owner) {
  const struct kith_cells *cells = partition->cells;
  for (int64_t c = 0; c < cells->n; ++c) owner[c] = -1;
  for (int rank = 0; rank < partition->n_ranks; ++rank) {
    int64_t k[NDIM], x[NDIM], first[NDIM], extent[NDIM], n = 1; /* of the bounding box, in cells */
    kith_grid_place(mesh->ranks, rank, k);
    const struct shape shape = shape_at(mesh, corner, k);
    for (int a = 0; a < NDIM; ++a) {
      int64_t low = INT64_MAX, high = INT64_MIN;
      for (int j = 0; j < SHAPE_CORNERS; ++j) {
        low = KITH_MIN(low, shape.corner[j][a]);
        high = KITH_MAX(high, shape.corner[j][a]);
      }
      first[a] = low / mesh->unit;
      n *= extent[a] = KITH_MIN(high / mesh->unit + 1, cells->count[a]) - first[a];
    }
    for (int64_t number = 0; number < n; ++number) {
      kith_grid_place(extent, number, k);
      for (int a = 0; a < NDIM; ++a) {
        k[a] += first[a];
        x[a] = k[a] * mesh->unit + mesh->unit / 2;
      }
      const int64_t c = kith_grid_number(cells->count, k);
      if (owner[c] < 0 && contains(&shape, x)) owner[c] = rank;
    }
  }
}

/* ---- moves ---- */

/* The displacement of corner i. */
static void pull_of(const struct mesh *mesh, const double *load, const int64_t *i, double step,
                    double *move) {
  const int64_t *here = &mesh->corner[kith_grid_number(mesh->corners, i) * NDIM];
  int64_t place[NDIM];
  double spacing[NDIM], mean = 0, n = 0;
  for (int a = 0; a < NDIM; ++a) {
    spacing[a] = (double)mesh->length[a] / (double)mesh->ranks[a];
    move[a] = 0;
  }
  for (int k = 0; k < SHAPE_CORNERS; ++k)
    if (place_around(mesh, i, k, place)) mean += load[kith_grid_number(mesh->ranks, place)], ++n;
  mean /= n;
  for (int k = 0; k < SHAPE_CORNERS && mean > 0; ++k) {
    if (!place_around(mesh, i, k, place)) continue;
    const struct shape shape = shape_at(mesh, mesh->corner, place);
    double to[NDIM] = {0}; /* the middle */
    for (int j = 0; j < SHAPE_CORNERS * NDIM; ++j)
      to[j % NDIM] +=
          (double)(shape.corner[j / NDIM][j % NDIM] - here[j % NDIM]) / SHAPE_CORNERS / spacing[j % NDIM];
    const double pull = step / n * (load[kith_grid_number(mesh->ranks, place)] / mean - 1) / kith_norm(to);
    for (int a = 0; a < NDIM; ++a) move[a] += pull * to[a] * spacing[a];
  }
  for (int a = 0; a < NDIM; ++a)
    if (i[a] == 0 || i[a] == mesh->ranks[a]) move[a] = 0; /* a face of the box */
}

/* Moves a corner of the trial mesh by `move`, or a half or a quarter of it, or not at all. */
static void move_corner(const struct mesh *mesh, const int64_t *i, double *move) {
  const int64_t number = kith_grid_number(mesh->corners, i);
  const int64_t *from = &mesh->corner[number * NDIM];
  int64_t *to = &mesh->trial[number * NDIM];
  for (int halving = 0; halving < HALVINGS; ++halving) {
    for (int a = 0; a < NDIM; ++a) {
      const double x = (double)from[a] + move[a];
      to[a] = (int64_t)KITH_MIN(KITH_MAX(x, 0), (double)mesh->length[a]);
      move[a] *= 0.5;
    }
    if (valid_around(mesh, mesh->trial, i)) return;
  }
  for (int a = 0; a < NDIM; ++a) to[a] = from[a];
}

/* Odd and even places along the axes: corners of the same color have no rank in common. */
static int color_of(const int64_t *i) {
  int color = 0;
  for (int a = 0; a < NDIM; ++a) color |= (int)(i[a] & 1) << a;
  return color;
}

/* Moves the corners of one color of the trial mesh. */
static void move_color(const struct mesh *mesh, const double *load, int color) {
  memcpy(mesh->trial, mesh->corner, (size_t)mesh->n_corners * NDIM * sizeof *mesh->trial);
  for (int64_t number = 0; number < mesh->n_corners; ++number) {
    int64_t i[NDIM];
    double move[NDIM];
    kith_grid_place(mesh->corners, number, i);
    if (color_of(i) != color) continue;
    pull_of(mesh, load, i, mesh->step[color], move);
    move_corner(mesh, i, move);
  }
}

/* The work of every rank; returns the sum of its squares. */
static double loads_of(const struct kith_partition *partition, const double *weight, const int32_t *owner,
                       double *load) {
  double squares = 0;
  kith_partition_loads(partition, owner, weight, load);
  for (int r = 0; r < partition->n_ranks; ++r) squares += load[r] * load[r];
  return squares;
}

/* ---- the member ---- */

static kith_status gridbased_first(struct kith_partition *partition, int32_t *owner) {
  struct mesh *mesh = partition->self;
  const struct kith_cells *cells = partition->cells;
  int ranks[NDIM], bits = UNIT_BITS;
  kith_partition_mesh(cells, partition->n_ranks, NDIM, ranks);
  mesh->n_corners = 1;
  for (int color = 0; color < SHAPE_CORNERS; ++color) mesh->step[color] = 1;
  for (int a = 0; a < NDIM; ++a) {
    mesh->ranks[a] = ranks[a];
    mesh->n_corners *= mesh->corners[a] = ranks[a] + 1;
    while (bits > 0 && cells->count[a] << bits > INT64_C(1) << LENGTH_BITS) --bits;
  }
  mesh->unit = INT64_C(1) << bits;
  for (int a = 0; a < NDIM; ++a) {
    mesh->length[a] = cells->count[a] * mesh->unit;
    if (bits == 0 || mesh->length[a] < mesh->ranks[a])
      KITH_FAIL(UNSUPPORTED,
                "partitioner 'gridbased': %d ranks on %lld cells of axis %d are more than it can resolve",
                ranks[a], (long long)cells->count[a], a);
  }
  const size_t n = (size_t)mesh->n_corners * NDIM;
  KITH_TRY(kith_resize(&mesh->corner, 0, n, sizeof *mesh->corner));
  KITH_TRY(kith_resize(&mesh->trial, 0, n, sizeof *mesh->trial));
  for (int64_t number = 0; number < mesh->n_corners; ++number) {
    int64_t *i = &mesh->corner[number * NDIM];
    kith_grid_place(mesh->corners, number, i);
    for (int a = 0; a < NDIM; ++a) i[a] = i[a] * mesh->length[a] / mesh->ranks[a];
  }
  fill(mesh, mesh->corner, partition, owner);
  return KITH_OK;
}

/* A round for each color moves all of its corners, or none if that does not help. */
static kith_status gridbased_update(struct kith_partition *partition, const double *weight, int32_t *owner) {
  struct mesh *mesh = partition->self;
  const size_t n = (size_t)partition->n_ranks;
  const double most = ((const struct gridbased *)partition->settings)->step;
  double *load = NULL;
  KITH_TRY(kith_resize(&load, 0, 2 * n, sizeof *load));
  double *trial_load = load + n, squares = loads_of(partition, weight, owner, load);
  for (int color = 0; color < SHAPE_CORNERS; ++color) {
    move_color(mesh, load, color);
    fill(mesh, mesh->trial, partition, owner);
    const double trial = loads_of(partition, weight, owner, trial_load), step = mesh->step[color];
    const bool gain = trial <= squares;
    mesh->step[color] = gain ? KITH_MIN(2 * step, most) : KITH_MAX(0.5 * step, LEAST_STEP);
    if (!gain) continue;
    int64_t *before = mesh->corner;
    mesh->corner = mesh->trial, mesh->trial = before;
    memcpy(load, trial_load, n * sizeof *load);
    squares = trial;
  }
  fill(mesh, mesh->corner, partition, owner); /* the last trial may have been undone */
  kith_free(&load);
  return KITH_OK;
}

/* Corners and steps. */
static size_t gridbased_state(const struct kith_partition *partition, int64_t *word) {
  const struct mesh *mesh = partition->self;
  const size_t n = (size_t)mesh->n_corners * NDIM;
  if (word != NULL) memcpy(word, mesh->corner, n * sizeof *word);
  if (word != NULL) memcpy(word + n, mesh->step, sizeof mesh->step);
  return n + SHAPE_CORNERS;
}

/* Are these the corners of a mesh that covers the box exactly once? */
static bool is_mesh(const struct mesh *mesh, const int64_t *corner) {
  int64_t i[NDIM];
  bool covers = true;
  for (int64_t number = 0; number < mesh->n_corners; ++number) {
    kith_grid_place(mesh->corners, number, i);
    for (int a = 0; a < NDIM; ++a) {
      const int64_t x = corner[number * NDIM + a], least = i[a] == mesh->ranks[a] ? mesh->length[a] : 0;
      covers = covers && x >= least && x <= (i[a] == 0 ? 0 : mesh->length[a]);
    }
  }
  for (int64_t number = 0; number < mesh->n_corners && covers; ++number) {
    kith_grid_place(mesh->corners, number, i);
    covers = valid_around(mesh, corner, i);
  }
  return covers;
}

static kith_status gridbased_restore(struct kith_partition *partition, const int64_t *word) {
  struct mesh *mesh = partition->self;
  const size_t n = (size_t)mesh->n_corners * NDIM;
  double step[SHAPE_CORNERS];
  memcpy(step, word + n, sizeof step);
  bool sound = is_mesh(mesh, word);
  for (int color = 0; color < SHAPE_CORNERS; ++color)
    sound = sound && step[color] >= LEAST_STEP && step[color] < INFINITY;
  if (!sound) KITH_FAIL(BAD_FILE, "partitioner 'gridbased': the corners of its mesh are damaged");
  memcpy(mesh->corner, word, n * sizeof *word);
  memcpy(mesh->step, step, sizeof step);
  return KITH_OK;
}

static void gridbased_clear(struct kith_partition *partition) {
  struct mesh *mesh = partition->self;
  KITH_FREE(&mesh->corner, &mesh->trial);
}

const struct kith_partitioner_ops kith_partitioner_gridbased = {
    .name = "gridbased",
    .doc = "a Cartesian mesh of ranks whose corners move",
    KITH_SETTINGS(gridbased_params, gridbased),
    .state_size = sizeof(struct mesh),
    .first = gridbased_first,
    .update = gridbased_update,
    .state = gridbased_state,
    .restore = gridbased_restore,
    .clear = gridbased_clear,
};
