/* half_shell.c - linked cells on a distributed grid: points that repel each other within the edge of a cell,
 * in a periodic box of few cells. Each rank has the points in its cells. For each pair of cells, the rank of
 * the first one evaluates all pairs of points, once: only the forward half of the neighboring cells is
 * visited. Forces on points of ghost cells are sent back to their ranks, by the same lists. The result is
 * compared with the sum over all pairs of points and images. Runs on any number of ranks: mpirun -n 4
 * half_shell hilbert; see app/manual/library.md. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "lib/comm/ranks.h"
#include "lib/domain/partition/shell.h"

enum { POINTS = 300, COUNT = 3, MOST = 150 }; /* points; cells per axis, at least 3; points in a cell */

/* The points of a cell and the forces on them. */
struct cell {
  int64_t n;
  double x[MOST][NDIM], force[MOST][NDIM];
};

struct world {
  struct kith_ranks *ranks;
  struct kith_cells cells;
  struct kith_partition *partition;
  struct kith_shell shell;
  struct cell *cell, *out; /* [cells]: own ones and ghosts have points; cells to send */
  struct kith_message *to, *from;
  double x[POINTS][NDIM]; /* all points, on every rank, to compare */
};

/* The repulsion of two points at a distance vector d, which is 0 beyond one edge. */
static void repel(const struct world *w, const double *d, double *force, double *back) {
  const double r = sqrt(kith_dot(d, d)), edge = w->cells.edge[0];
  for (int a = 0; a < NDIM && r < edge; ++a) {
    const double f = (1 / r - 1 / edge) * d[a];
    force[a] += f;
    if (back != NULL) back[a] -= f;
  }
}

static kith_status put_points(struct world *w) {
  int64_t own;
  for (int i = 0; i < POINTS; ++i) {
    for (int a = 0; a < NDIM; ++a) w->x[i][a] = fmod((i + 1) * sqrt(2 + 3 * a), 1);
    /* it is on another rank */
    if (kith_shell_find(&w->shell, w->partition, w->x[i], &own) != KITH_OK) continue;
    struct cell *cell = &w->cell[w->shell.cell[own]];
    if (cell->n == MOST) KITH_FAIL(BAD_INPUT, "more than %d points in a cell", MOST);
    memcpy(cell->x[cell->n++], w->x[i], sizeof w->x[i]);
  }
  return KITH_OK;
}

/* Sends whole cells, packed in `out`, to neighbors: own cells that are their ghosts, or, with `back`, ghosts
 * to their owners. `in` receives. */
static kith_status exchange(struct world *w, bool back, struct cell *in) {
  const struct kith_shell *s = &w->shell;
  const int64_t *send = back ? s->receive : s->send, *send_first = back ? s->receive_first : s->send_first,
                *receive_first = back ? s->send_first : s->receive_first;
  for (int64_t k = 0; k < send_first[s->n_neighbors]; ++k) w->out[k] = w->cell[send[k]];
  for (int k = 0; k < s->n_neighbors; ++k) {
    w->to[k] = (struct kith_message){s->neighbor[k], w->out + send_first[k],
                                     (size_t)(send_first[k + 1] - send_first[k]) * sizeof *in};
    w->from[k] = (struct kith_message){s->neighbor[k], in + receive_first[k],
                                       (size_t)(receive_first[k + 1] - receive_first[k]) * sizeof *in};
  }
  return kith_ranks_exchange(w->ranks, s->n_neighbors, w->to, s->n_neighbors, w->from);
}

/* All pairs of points of two cells, the second one shifted; within one cell each pair once. */
static void add_pairs(const struct world *w, struct cell *c, struct cell *d, const int *shift) {
  for (int64_t i = 0; i < c->n; ++i)
    for (int64_t j = c == d ? i + 1 : 0; j < d->n; ++j) {
      double apart[NDIM];
      for (int a = 0; a < NDIM; ++a) apart[a] = c->x[i][a] - (d->x[j][a] + (shift != NULL ? shift[a] : 0));
      repel(w, apart, c->force[i], d->force[j]);
    }
}

static kith_status add_forces(struct world *w, struct cell *in) {
  const struct kith_shell *s = &w->shell;
  KITH_TRY(exchange(w, false, in));
  for (int64_t k = 0; k < s->n_ghosts; ++k) w->cell[s->receive[k]] = in[k];
  for (int64_t k = 0; k < s->n_cells; ++k) {
    struct kith_cell_image image[KITH_CELL_NEIGHBORS];
    int forward;
    struct cell *cell = &w->cell[s->cell[k]];
    kith_cells_neighbors(&w->cells, s->cell[k], image, &forward);
    add_pairs(w, cell, cell, NULL);
    for (int n = 0; n < forward; ++n) add_pairs(w, cell, &w->cell[image[n].cell], image[n].shift);
  }
  KITH_TRY(exchange(w, true, in));
  for (int64_t k = 0; k < s->send_first[s->n_neighbors]; ++k)
    for (int64_t i = 0; i < in[k].n; ++i)
      for (int a = 0; a < NDIM; ++a) w->cell[s->send[k]].force[i][a] += in[k].force[i][a];
  return KITH_OK;
}

/* The largest difference from the sum over all points and their nearest images, relative to the largest
 * force. */
static double difference(const struct world *w) {
  double most[2] = {0}; /* difference, force */
  for (int64_t k = 0; k < w->shell.n_cells; ++k) {
    const struct cell *cell = &w->cell[w->shell.cell[k]];
    for (int64_t i = 0; i < cell->n; ++i) {
      double force[NDIM] = {0};
      for (int j = 0; j < POINTS; ++j) {
        double d[NDIM];
        for (int a = 0; a < NDIM; ++a) d[a] = cell->x[i][a] - w->x[j][a], d[a] -= nearbyint(d[a]);
        if (kith_dot(d, d) > 0) repel(w, d, force, NULL);
      }
      for (int a = 0; a < NDIM; ++a) {
        most[0] = KITH_MAX(most[0], fabs(force[a] - cell->force[i][a]));
        most[1] = KITH_MAX(most[1], fabs(force[a]));
      }
    }
  }
  kith_ranks_max(w->ranks, most, 2);
  return most[0] / most[1];
}

static kith_status run(struct world *w, const char *partitioner, double *off) {
  const double lower[3] = {0}, upper[3] = {1, 1, 1};
  const bool periodic[3] = {true, true, true};
  struct cell *in = NULL;
  const int size = kith_ranks_size(w->ranks);
  KITH_TRY(kith_cells_init(&w->cells, lower, upper, periodic, 1.0 / COUNT, 1000));
  KITH_TRY(kith_partition_create(&w->partition, &w->cells, size, partitioner));
  KITH_TRY(kith_shell_build(&w->shell, w->partition, kith_ranks_rank(w->ranks), 0));
  const size_t most = (size_t)w->cells.n * KITH_CELL_NEIGHBORS; /* a cell may go to several ranks */
  KITH_TRY(kith_resize(&w->cell, 0, (size_t)w->cells.n, sizeof *w->cell));
  KITH_TRY(kith_resize(&w->out, 0, most, sizeof *w->out));
  KITH_TRY(kith_resize(&w->to, 0, 2 * (size_t)size, sizeof *w->to));
  w->from = w->to + size;
  KITH_TRY(put_points(w));
  kith_status status = kith_resize(&in, 0, most, sizeof *in);
  if (status == KITH_OK) status = add_forces(w, in);
  kith_free(&in);
  *off = difference(w);
  return status;
}

int main(int argc, char **argv) {
  struct world world = {0};
  double off = INFINITY;
  kith_status status = kith_ranks_create(&world.ranks);
  if (status == KITH_OK) status = run(&world, argc > 1 ? argv[1] : "hilbert", &off);
  if (status != KITH_OK) fprintf(stderr, "%s\n", kith_failure());
  if (kith_ranks_rank(world.ranks) == 0)
    printf("%d points in %d cells on %d ranks: half shells differ from the full sum by %.1e\n", POINTS,
           (int)world.cells.n, kith_ranks_size(world.ranks), off);
  kith_free(&world.cell);
  kith_free(&world.out);
  kith_free(&world.to);
  kith_shell_clear(&world.shell);
  kith_partition_destroy(&world.partition);
  kith_ranks_destroy(&world.ranks);
  return status == KITH_OK && off < 1e-12 ? 0 : 1;
}
