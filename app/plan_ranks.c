#include "app/plan_ranks.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "lib/domain/share.h"
#include "lib/domain/shell.h"

enum { MOST_MAPS = 20, MOST_RANKS_OF_A_NODE = 128 };

struct place { /* of a cell: the box around its nodes, and their largest reach; reach < 0: no nodes */
  struct kith_box box;
  double reach;
};

struct outlook {
  const struct kith_model *model;
  struct kith_cells cells;
  struct place *place; /* [cells.n] */
  double *work;        /* [cells.n] */
  double reach;        /* the largest of all */
  double factor;       /* f */
  int n_ranks;
};

/* What a rank would have. */
struct load {
  double nodes, ghosts, sends, peers;
};

static kith_status look(struct outlook *o, int n_ranks) {
  const struct kith_model *m = o->model;
  const struct kith_nodes *nodes = m->nodes;
  const struct kith_rows *rows = &m->connectivity->rows;
  bool periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) periodic[a] = m->scene->boundary[a].lower == &kith_boundary_periodic;
  KITH_TRY(kith_share_cells(&o->cells, nodes, &m->scene->domain, periodic,
                            (int64_t)m->scene->partition.cells * n_ranks));
  KITH_TRY(kith_resize(&o->place, 0, (size_t)o->cells.n, sizeof *o->place));
  KITH_TRY(kith_resize(&o->work, 0, (size_t)o->cells.n, sizeof *o->work));
  o->n_ranks = n_ranks;
  o->factor = m->connectivity->built.overlap ? 2 : 1;
  for (int64_t c = 0; c < o->cells.n; ++c) o->place[c] = (struct place){kith_box_empty(), -1};
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    const int64_t c = kith_cells_of(&o->cells, x);
    kith_box_include(&o->place[c].box, x);
    o->place[c].reach = fmax(o->place[c].reach, nodes->reach->f64[i]);
    o->reach = fmax(o->reach, nodes->reach->f64[i]);
    o->work[c] += 1 + (double)(rows->first[i + 1] - rows->first[i]);
  }
  return KITH_OK;
}

/* --- who is sent where --- */

struct targets {
  int n;
  struct {
    int32_t rank;
    int shift[NDIM];
  } of[MOST_RANKS_OF_A_NODE];
};

static void aim(struct targets *t, int32_t rank, const int *shift) {
  for (int k = 0; k < t->n; ++k)
    if (t->of[k].rank == rank && memcmp(t->of[k].shift, shift, sizeof t->of[k].shift) == 0) return;
  if (t->n == MOST_RANKS_OF_A_NODE) return;
  t->of[t->n].rank = rank;
  memcpy(t->of[t->n++].shift, shift, sizeof t->of[0].shift);
}

/* Is the image of x that is displaced by -shift lengths, so that it stands where cell c sees it, within reach of c? */
static bool reaches(const struct outlook *o, const double *x, double reach, int64_t c, const int *shift) {
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
static void find_targets(const struct outlook *o, const int32_t *owner, const double *x, double reach,
                         int32_t own, struct targets *t) {
  const struct kith_cells *g = &o->cells;
  int64_t low[NDIM], high[NDIM], k[NDIM];
  t->n = 0;
  for (int a = 0; a < NDIM; ++a) {
    low[a] = (int64_t)floor((x[a] - o->factor * o->reach - g->lower[a]) / g->edge[a]);
    high[a] = (int64_t)floor((x[a] + o->factor * o->reach - g->lower[a]) / g->edge[a]);
    if (!g->periodic[a]) low[a] = KITH_MAX(low[a], 0), high[a] = KITH_MIN(high[a], g->count[a] - 1);
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

static kith_status load_ranks(const struct outlook *o, const int32_t *owner, struct load *load) {
  const struct kith_nodes *nodes = o->model->nodes;
  const size_t n = (size_t)o->n_ranks;
  uint8_t *meets = NULL; /* [from][to] */
  KITH_TRY(kith_resize(&meets, 0, n * n, 1));
  memset(load, 0, n * sizeof *load);
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    struct targets t;
    const double *x = nodes->position->f64 + (size_t)i * NDIM;
    const int32_t own = owner[kith_cells_of(&o->cells, x)];
    find_targets(o, owner, x, nodes->reach->f64[i], own, &t);
    load[own].nodes += 1, load[own].sends += t.n;
    for (int k = 0; k < t.n; ++k) {
      load[t.of[k].rank].ghosts += 1;
      meets[(size_t)own * n + (size_t)t.of[k].rank] = 1;
    }
  }
  for (size_t k = 0; k < n * n; ++k) load[k / n].peers += meets[k] | meets[k % n * n + k / n];
  kith_free(&meets);
  return KITH_OK;
}

/* --- one partitioner --- */

static kith_status settle(struct kith_partition *partition, const double *work) {
  bool changed = true;
  for (int k = 0; changed && k < MOST_MAPS; ++k)
    KITH_TRY(kith_partition_update(partition, work, NULL, &changed));
  return KITH_OK;
}

static void print_line(const struct outlook *o, const char *name, const struct load *load,
                       const struct kith_partition_figures *map) {
  struct load sum = {0}, most = {0};
  for (int r = 0; r < o->n_ranks; ++r) {
    sum.ghosts += load[r].ghosts, most.ghosts = fmax(most.ghosts, load[r].ghosts);
    most.sends = fmax(most.sends, load[r].sends), most.peers = fmax(most.peers, load[r].peers);
    sum.nodes += load[r].nodes;
  }
  printf("    %-12s %9.3f %9lld %9.2f %10.0f %10.0f %9.0f %12.1f\n", name, map->imbalance,
         (long long)map->cut_faces, sum.ghosts / fmax(sum.nodes, 1), sum.ghosts / o->n_ranks, most.ghosts,
         most.peers, most.sends * 8 / 1024);
}

static kith_status show_map(const struct outlook *o, const struct kith_partition *partition) {
  struct kith_partition_figures all;
  struct kith_rank_figures *rank = NULL;
  struct load *load = NULL;
  kith_status status = kith_resize(&load, 0, (size_t)o->n_ranks, sizeof *load);
  if (status == KITH_OK) status = kith_resize(&rank, 0, (size_t)o->n_ranks, sizeof *rank);
  if (status == KITH_OK) status = kith_partition_figures(partition, o->work, NULL, rank, &all);
  if (status == KITH_OK) status = load_ranks(o, partition->owner, load);
  if (status == KITH_OK) print_line(o, partition->ops->name, load, &all);
  kith_free(&load);
  kith_free(&rank);
  return status;
}

static kith_status show_partitioner(const struct outlook *o, const struct kith_partitioner_ops *ops) {
  struct kith_partition *partition = NULL;
  KITH_TRY(kith_partition_create(&partition, &o->cells, o->n_ranks, ops->name));
  kith_status status = settle(partition, o->work);
  if (status == KITH_OK) status = show_map(o, partition);
  kith_partition_destroy(&partition);
  return status;
}

kith_status kith_plan_ranks(const struct kith_model *model, int n_ranks) {
  struct outlook o = {.model = model};
  kith_status status = look(&o, n_ranks);
  if (status == KITH_OK)
    printf(
        "\n  on %d ranks: %lld cells, %.1f nodes and %.0f row entries a rank\n"
        "    %-12s %9s %9s %9s %10s %10s %9s %12s\n    %-12s %9s %9s %9s %10s %10s %9s %12s\n",
        n_ranks, (long long)o.cells.n, (double)model->nodes->n_internal / n_ranks,
        (double)model->integrator.ledger.last_entries / n_ranks, "", "largest", "cut", "ghosts", "ghosts",
        "ghosts", "peers", "KiB a scalar", "partitioner", "over mean", "faces", "a node", "mean", "largest",
        "largest", "sent");
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); status == KITH_OK && *p != NULL;
       ++p)
    if ((*p)->needs == NULL) status = show_partitioner(&o, *p);
  kith_free(&o.place);
  kith_free(&o.work);
  return status;
}
