/* probes.c - least squares at points, from exact sums over the nodes near each point and its images. */
#include "app/output/probes.h"

#include <math.h>
#include <string.h>
#include <sundials/sundials_dense.h>
#include <unistd.h>
#include "lib/io/atomic_file.h"
#include "lib/io/series.h"

/* TERMS: unknowns of a field, its value and gradient. VALUES: at a node, scalars, then the velocity. SUMS:
 * the moments of equation (1) in probes.h, then its right-hand sides. */
enum {
  TERMS = NDIM + 1,
  SCALARS = 3,
  VALUES = SCALARS + NDIM,
  MOMENTS = TERMS * (TERMS + 1) / 2,
  SUMS = MOMENTS + TERMS * VALUES,
  CHUNK = 64 /* points that are summed up together */
};

/* The columns of the file; those of gradients are the second half. */
static const struct kith_series_column columns[] = {
    {"density", "", 1},
    {"pressure", "", 1},
    {"energy", "per unit mass", 1},
    {"velocity", "zeros behind in 1-D and 2-D", 3},
    {"density_gradient", "", 3},
    {"pressure_gradient", "", 3},
    {"energy_gradient", "", 3},
    {"velocity_gradient", "row of each component of the velocity, column of each axis", 9}};
enum { COLUMNS = sizeof columns / sizeof *columns };

/* A probe of the scene and its points. */
struct set {
  const struct kith_probe *probe;
  struct kith_nodes *points;   /* internal nodes; their images are ghosts */
  struct kith_field *mirror;   /* 1; of an image -1 along axes in which it is mirrored */
  struct kith_field *velocity; /* 0; of an image the velocity of its mirror */
  struct kith_search *search;  /* of the points */
  struct kith_list *list;
  struct kith_rows images; /* targets of each point: itself and its images */
  struct kith_series series;
  double *at;              /* [n][3] */
  double *column[COLUMNS]; /* of the present sample */
  uint64_t sampled;        /* 1 + step of the last sample; 0: none yet */
};

struct kith_probes {
  struct kith_simulation *simulation; /* borrowed */
  struct kith_search *search;         /* of the nodes, by their supports */
  struct kith_boundaries faces;       /* boundaries that have images; borrowed */
  const struct kith_field *barrier;   /* flag of barrier nodes; NULL: there are none */
  struct kith_sum (*sums)[SUMS];      /* [CHUNK] */
  double (*guess)[VALUES][TERMS];     /* [CHUNK] subtracted from the values: see sample_chunk */
  int n;
  struct set *set;
  char path[640];
  struct kith_atomic_file *file; /* on rank 0: the copy that grows; NULL: as published, or not begun */
  bool published;
  uint64_t begun; /* step at which the run started, or started again */
};

/* --- creation --- */

/* Chooses nodes and frozen nodes without barriers; every rank has all frozen nodes, so rank 0 takes them. */
static bool is_source(const void *context, const struct kith_nodes *nodes, kith_index i) {
  const struct kith_probes *p = context;
  if (p->barrier != NULL && p->barrier->u8[i]) return false;
  if (i < nodes->n_internal) return true;
  if (kith_ranks_rank(nodes->ranks) != 0) return false;
  return kith_nodes_ghost_block(nodes, i)->kind == KITH_GHOST_FROZEN;
}

static void place_points(struct set *s) {
  for (kith_index i = 0; i < s->points->n_internal; ++i) {
    double *x = s->points->position->f64 + (size_t)i * NDIM;
    kith_probe_point(s->probe, i, x);
    for (int a = 0; a < NDIM; ++a) s->at[3 * (size_t)i + a] = x[a], s->mirror->f64[(size_t)i * NDIM + a] = 1;
    s->points->id->i64[i] = i;
  }
  ++s->points->positions;
}

static kith_status make_points(struct set *s) {
  static const char *const name[] = {"points"};
  static const struct kith_field_spec mirror = {"mirror", KITH_VECTOR, KITH_F64, KITH_STATE, NULL, "sign"},
                                      drift = {"drift",    KITH_VELOCITY, KITH_F64,
                                               KITH_STATE, NULL,          "velocity of an image at rest"};
  const int *n = s->probe->points;
  kith_index first;
  KITH_TRY(kith_nodes_create(&s->points, 1, name));
  KITH_TRY(kith_nodes_field(s->points, &mirror, &s->mirror));
  KITH_TRY(kith_nodes_field(s->points, &drift, &s->velocity));
  KITH_TRY(kith_nodes_append(s->points, 0, n[0] * n[1] * n[2], &first));
  KITH_TRY(kith_resize(&s->at, 0, 3 * (size_t)s->points->n_internal, sizeof *s->at));
  place_points(s);
  return KITH_OK;
}

static kith_status make_set(const struct kith_probes *p, struct set *s, const struct kith_probe *probe) {
  const struct kith_simulation *m = p->simulation;
  s->probe = probe;
  KITH_TRY(make_points(s));
  if (m->nodes->stretched != NULL) KITH_TRY(kith_nodes_stretch(s->points, m->nodes->stretch));
  const size_t n = (size_t)s->points->n_internal;
  s->series = (struct kith_series){.name = probe->name,
                                   .n = n,
                                   .points = s->at,
                                   .shape = {probe->points[0], probe->points[1], probe->points[2]},
                                   .n_columns = probe->gradients ? COLUMNS : COLUMNS / 2,
                                   .column = columns};
  for (int k = 0; k < s->series.n_columns; ++k)
    KITH_TRY(kith_resize(&s->column[k], 0, n * (size_t)columns[k].components, sizeof(double)));
  KITH_TRY(kith_search_create(&s->search, m->search->ops, s->points));
  const struct kith_list_spec spec = {.targets = {.nodes = s->points, .search = s->search, .ghosts = true},
                                      .sources = {m->nodes, p->search, .chosen = is_source, .context = p},
                                      .cutoff = KITH_CUTOFF_scatter,
                                      .radius = m->nodes->support->spec.name,
                                      .storage = m->scene->connectivity.storage,
                                      .rebuild = kith_rebuild_always.name,
                                      .expected = (kith_index)m->package.neighbors};
  return kith_list_create(&s->list, &spec);
}

/* Copies the published file, which goes on in the copy. */
static kith_status copy_published(const struct kith_probes *p) {
  enum { PIECE = 1 << 16 };
  static char piece[PIECE];
  FILE *from = fopen(p->path, "rb"), *to = p->file->stream;
  bool whole = from != NULL;
  for (size_t n = 1; whole && n > 0;) {
    n = fread(piece, 1, PIECE, from);
    whole = fwrite(piece, 1, n, to) == n && !ferror(from);
  }
  if (from != NULL) fclose(from);
  return whole && fflush(to) == 0 ? KITH_OK : kith_fail(KITH_BAD_FILE, "%s: cannot copy it", p->path);
}

static kith_status create_series(const struct kith_probes *p) {
  struct kith_series *series = NULL;
  KITH_TRY(kith_resize(&series, 0, (size_t)p->n, sizeof *series));
  for (int k = 0; k < p->n; ++k) series[k] = p->set[k].series;
  const kith_status status = kith_series_create(p->file->temporary, series, p->n);
  kith_free(&series);
  return status;
}

static kith_status open_file(struct kith_probes *p) {
  KITH_TRY(kith_atomic_file_open(&p->file, p->path));
  const kith_status status = p->published ? copy_published(p) : create_series(p);
  if (status != KITH_OK) kith_atomic_file_abandon(&p->file);
  return status;
}

kith_status kith_probes_create(struct kith_probes **out, struct kith_simulation *m, const char *directory,
                               bool restarted) {
  *out = NULL;
  if (m->scene->n_probes == 0) return KITH_OK;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  struct kith_probes *p = *out;
  p->simulation = m;
  KITH_TRY(kith_resize(&p->set, 0, (size_t)m->scene->n_probes, sizeof *p->set));
  KITH_TRY(kith_resize(&p->sums, 0, CHUNK, sizeof *p->sums));
  KITH_TRY(kith_resize(&p->guess, 0, CHUNK, sizeof *p->guess));
  KITH_TRY(kith_search_create(&p->search, m->search->ops, m->nodes));
  p->search->radius = m->nodes->support;
  p->barrier = kith_nodes_field_named(m->nodes, "barrier");
  for (int b = 0; b < m->boundaries.n; ++b)
    if (m->boundaries.boundary[b]->ops->image_of != NULL)
      p->faces.boundary[p->faces.n++] = m->boundaries.boundary[b];
  for (; p->n < m->scene->n_probes; ++p->n) KITH_TRY(make_set(p, &p->set[p->n], &m->scene->probe[p->n]));
  snprintf(p->path, sizeof p->path, "%s/probes.h5", directory);
  p->begun = m->integrator.step;
  p->published = restarted && access(p->path, F_OK) == 0; /* a restart may write elsewhere */
  /* A new file is made with the first sample: nothing is left behind if another rank fails before it. */
  if (kith_ranks_rank(m->nodes->ranks) != 0 || !p->published) return KITH_OK;
  KITH_TRY(open_file(p));
  for (int k = 0; k < p->n; ++k) {
    const kith_status status = kith_series_resume(p->file->temporary, &p->set[k].series, p->begun);
    if (status == KITH_BAD_INPUT)
      KITH_FAIL(BAD_FILE, "%s: damaged, or it has other probes than the scene: move it away, or give -o DIR",
                p->path);
    if (status == KITH_BAD_FILE)
      KITH_FAIL(BAD_FILE, "%s: HDF5 cannot continue it: it is damaged, or memory or the disk is short",
                p->path);
    KITH_TRY(status);
  }
  return KITH_OK;
}

kith_status kith_probes_publish(struct kith_probes *p) {
  if (p == NULL || p->file == NULL) return KITH_OK;
  p->published = true;
  return kith_atomic_file_commit(&p->file, false);
}

kith_status kith_probes_destroy(struct kith_probes **probes) {
  struct kith_probes *p = *probes;
  if (p == NULL) return KITH_OK;
  const bool sampled = p->n > 0 && p->set[0].sampled > 0;
  const kith_status status = sampled ? kith_probes_publish(p) : KITH_OK;
  kith_atomic_file_abandon(&p->file);
  for (int k = 0; p->set != NULL && k < p->simulation->scene->n_probes; ++k) {
    struct set *s = &p->set[k];
    kith_list_destroy(&s->list);
    kith_search_destroy(&s->search);
    kith_nodes_destroy(&s->points);
    kith_rows_clear(&s->images);
    kith_free(&s->at);
    for (int c = 0; c < COLUMNS; ++c) kith_free(&s->column[c]);
  }
  KITH_FREE(&p->set, &p->sums, &p->guess);
  kith_search_destroy(&p->search);
  kith_free(probes);
  return status;
}

/* --- the sums of a point --- */

/* How far nodes and frozen nodes reach, at most: [0] by their supports, along the longest axis of these,
 * [1 + b] outside of face b. */
static void measure_reach(const struct kith_probes *p, double reach[1 + KITH_MAX_BOUNDARIES]) {
  const struct kith_nodes *nodes = p->simulation->nodes;
  memset(reach, 0, (1 + KITH_MAX_BOUNDARIES) * sizeof *reach);
  for (kith_index i = 0; i < kith_nodes_count(nodes); ++i) {
    if (!is_source(p, nodes, i)) continue;
    reach[0] = KITH_MAX(reach[0], nodes->support->f64[i]);
    for (int b = 0; b < p->faces.n; ++b) {
      const struct kith_boundary *face = p->faces.boundary[b];
      const double x = nodes->position->f64[(size_t)i * NDIM + (size_t)face->axis];
      if (face->at_lower) reach[1 + b] = KITH_MAX(reach[1 + b], face->lower - x);
      if (face->at_upper) reach[1 + b] = KITH_MAX(reach[1 + b], x - face->upper);
    }
  }
  reach[0] *= nodes->longest;
  kith_ranks_max(nodes->ranks, reach, 1 + p->faces.n);
}

static void set_radius(struct kith_nodes *points, double radius) {
  for (kith_index g = 0; g < kith_nodes_count(points); ++g) points->search_radius->f64[g] = 1.25 * radius;
}

/* Makes images of the points wherever a support may reach through a face, beyond which nodes may be: on each
 * axis for itself, since gas that crosses a long box in a step would be many widths outside of a thin one. */
static kith_status make_images(struct kith_probes *p, struct set *s) {
  struct kith_nodes *points = s->points;
  double reach[1 + KITH_MAX_BOUNDARIES];
  measure_reach(p, reach);
  kith_nodes_drop_ghosts(points);
  ++points->positions;
  for (int b = 0; b < p->faces.n; ++b) {
    struct kith_boundary *face = p->faces.boundary[b];
    set_radius(points, reach[0] + reach[1 + b]);
    kith_boundaries_measure(&p->faces, points, 1);
    KITH_TRY(face->ops->ghosts(face, points, 1));
  }
  set_radius(points, reach[0]);
  KITH_TRY(kith_rows_reserve(&s->images, points->n_internal));
  size_t *first = s->images.first;
  memset(first, 0, ((size_t)points->n_internal + 1) * sizeof *first);
  for (kith_index g = 0; g < kith_nodes_count(points); ++g) ++first[points->id->i64[g] + 1];
  KITH_TRY(kith_rows_sum(&s->images, -1));
  /* Moves first[k + 1] to where row k begins. */
  for (kith_index g = kith_nodes_count(points) - 1; g >= 0; --g)
    s->images.node[--first[points->id->i64[g] + 1]] = g;
  memmove(first, first + 1, (size_t)points->n_internal * sizeof *first);
  first[points->n_internal] = (size_t)kith_nodes_count(points);
  return KITH_OK;
}

/* Adds node j to the sums of a point, whose image g sees it. scale: of lengths. */
static void add_node(const struct kith_probes *p, const struct set *s, kith_index g, kith_index j,
                     double scale, double (*guess)[TERMS], struct kith_sum *sums) {
  const struct kith_simulation *m = p->simulation;
  const struct kith_hydro *hydro = &m->hydro;
  const double *x = m->nodes->position->f64 + (size_t)j * NDIM, *v = hydro->velocity->f64 + (size_t)j * NDIM,
               *y = s->points->position->f64 + (size_t)g * NDIM, *sign = s->mirror->f64 + (size_t)g * NDIM,
               *moves = s->velocity->f64 + (size_t)g * NDIM;
  const double h = m->nodes->support->f64[j];
  double d[NDIM], term[TERMS] = {1}, weight, slope,
                  value[VALUES] = {hydro->density->f64[j], hydro->pressure->f64[j], hydro->energy->f64[j]};
  for (int a = 0; a < NDIM; ++a) d[a] = (x[a] - y[a]) / m->nodes->stretch[a];
  kith_kernel_value(m->package.kernel, kith_norm(d) / h, &weight, &slope);
  weight *= hydro->mass->f64[j] / (hydro->density->f64[j] * kith_pow_dim(h));
  for (int a = 0; a < NDIM; ++a) {
    term[1 + a] = sign[a] * (x[a] - y[a]) / scale;
    value[SCALARS + a] = sign[a] * (v[a] - moves[a]);
  }
  for (int k = 0; k < TERMS; ++k)
    for (int l = k; l < TERMS; ++l) kith_sum_add(sums++, weight * term[k] * term[l]);
  for (int f = 0; f < VALUES; ++f) {
    for (int k = 0; k < TERMS; ++k) value[f] -= guess[f][k] * term[k];
    for (int k = 0; k < TERMS; ++k) kith_sum_add(sums++, weight * term[k] * value[f]);
  }
}

static void add_point(const struct kith_probes *p, const struct set *s, kith_index i, double scale,
                      double (*guess)[TERMS], kith_index *space, struct kith_sum *sums) {
  for (size_t e = s->images.first[i]; e < s->images.first[i + 1]; ++e) {
    const kith_index g = s->images.node[e];
    size_t n;
    const kith_index *node = s->list->stored.ops->row(&s->list->stored, s->list->row[g], space, &n);
    for (size_t k = 0; k < n; ++k) add_node(p, s, g, node[k], scale, guess, sums);
  }
}

/* --- the solution --- */

/* Cholesky factors of the moments, scaled to 1 on the diagonal by size[k]. false: there is no gradient. */
static bool factorize(const double *sum, double *column[TERMS], double size[TERMS]) {
  for (int k = 0; k < TERMS; ++k)
    for (int l = k; l < TERMS; ++l) column[k][l] = *sum++;
  for (int k = 0; k < TERMS; ++k) size[k] = 1 / sqrt(column[k][k]);
  for (int k = 0; k < TERMS; ++k)
    for (int l = k; l < TERMS; ++l) column[k][l] *= size[k] * size[l];
  bool regular = SUNDlsMat_densePOTRF(column, TERMS) == 0;
  for (int k = 0; k < TERMS; ++k) regular = regular && column[k][k] > 1e-5;
  return regular;
}

/* Solves for value and gradient of one field: `right` becomes the solution. */
static void solve(double *column[TERMS], const double size[TERMS], double right[TERMS]) {
  for (int k = 0; k < TERMS; ++k) right[k] *= size[k];
  SUNDlsMat_densePOTRS(column, TERMS, right);
  for (int k = 0; k < TERMS; ++k) right[k] *= size[k];
}

static bool is_behind_face(const struct kith_probes *p, const double *x) {
  for (int b = 0; b < p->faces.n; ++b) {
    const struct kith_boundary *face = p->faces.boundary[b];
    const double slack = 1e-9 * (face->upper - face->lower);
    if (face->at_lower && x[face->axis] < face->lower - slack) return true;
    if (face->at_upper && x[face->axis] > face->upper + slack) return true;
  }
  return false;
}

/* Stores value and gradient of a field at point i in the columns of the file. */
static void put(const struct set *s, size_t i, int field, const double solution[TERMS], double scale) {
  const bool scalar = field < SCALARS;
  const size_t k = scalar ? 0 : (size_t)(field - SCALARS);
  const int c = scalar ? field : SCALARS;
  s->column[c][i * (size_t)columns[c].components + k] = solution[0];
  if (!s->probe->gradients) return;
  double *gradient = s->column[COLUMNS / 2 + c] + i * (size_t)columns[COLUMNS / 2 + c].components + 3 * k;
  for (int a = 0; a < NDIM; ++a) gradient[a] = solution[1 + a] / scale;
}

/* Adds the solution of these sums to the guess, and stores that in the columns. */
static void finish_point(const struct kith_probes *p, const struct set *s, size_t i,
                         const struct kith_sum *sums, double scale, double (*guess)[TERMS]) {
  double sum[SUMS], factor[TERMS][TERMS] = {{0}}, *column[TERMS], size[TERMS] = {0};
  for (int k = 0; k < TERMS; ++k) column[k] = factor[k];
  for (int k = 0; k < SUMS; ++k) sum[k] = kith_sum_value(&sums[k]);
  const bool hidden = is_behind_face(p, s->points->position->f64 + i * NDIM);
  const bool regular = !hidden && factorize(sum, column, size);
  for (int f = 0; f < VALUES; ++f) {
    double solution[TERMS];
    memcpy(solution, sum + MOMENTS + f * TERMS, sizeof solution);
    if (regular) solve(column, size, solution);
    if (!regular) solution[0] = hidden || !(sum[0] > 0) ? NAN : solution[0] / sum[0];
    for (int k = 0; k < (regular ? TERMS : 1); ++k) guess[f][k] += solution[k];
    memcpy(solution, guess[f], sizeof solution);
    for (int k = 1; k < TERMS && !regular; ++k) solution[k] = NAN;
    put(s, i, f, solution, scale);
  }
}

static kith_status add_points(struct kith_probes *p, const struct set *s, kith_index begin, kith_index end) {
  const double scale = s->points->search_radius->f64[0];
  bool failed = false;
  memset(p->sums, 0, CHUNK * sizeof *p->sums);
#pragma omp parallel reduction(|| : failed)
  {
    kith_index *space = NULL;
    failed = kith_resize(&space, 0, s->list->stored.longest + 1, sizeof *space) != KITH_OK;
#pragma omp for schedule(dynamic, 1)
    for (kith_index i = begin; i < end; ++i)
      if (!failed) add_point(p, s, i, scale, p->guess[i - begin], space, p->sums[i - begin]);
    kith_free(&space);
  }
  if (failed) KITH_FAIL(NO_MEMORY, "no memory for a row of probes");
  return KITH_OK;
}

/* Samples some points. Solves twice: what the first solution leaves of the values is small, and so is the
 * error of the second. */
static kith_status sample_chunk(struct kith_probes *p, const struct set *s, kith_index begin,
                                kith_index end) {
  struct kith_ranks *ranks = p->simulation->nodes->ranks;
  const double scale = s->points->search_radius->f64[0];
  memset(p->guess, 0, CHUNK * sizeof *p->guess);
  for (int pass = 0; pass < 2; ++pass) {
    KITH_TRY(kith_ranks_allreduce_status(ranks, add_points(p, s, begin, end)));
    kith_sum_ranks(ranks, p->sums[0], (int)(end - begin) * SUMS);
    for (kith_index i = begin; i < end; ++i)
      finish_point(p, s, (size_t)i, p->sums[i - begin], scale, p->guess[i - begin]);
  }
  return KITH_OK;
}

static kith_status append(struct kith_probes *p, const struct set *s) {
  const struct kith_integrator *it = &p->simulation->integrator;
  const uint64_t before = p->begun % (uint64_t)s->probe->every;
  kith_status status = KITH_OK;
  if (p->file == NULL) KITH_TRY(open_file(p));
  /* What was the last state before a restart is between samples now that the run has gone on. */
  if (s->sampled == 0 && before > 0)
    status = kith_series_resume(p->file->temporary, &s->series, p->begun - before);
  if (status == KITH_OK)
    status = kith_series_append(p->file->temporary, &s->series, it->time, it->step,
                                (const double *const *)s->column);
  if (status != KITH_OK) kith_atomic_file_abandon(&p->file);
  return status;
}

static kith_status sample(struct kith_probes *p, struct set *s) {
  const struct kith_integrator *it = &p->simulation->integrator;
  struct kith_ranks *ranks = p->simulation->nodes->ranks;
  enum kith_rebuild_reason why;
  KITH_TRY(kith_ranks_allreduce_status(ranks, make_images(p, s)));
  KITH_TRY(kith_list_update(s->list, &why));
  for (kith_index i = 0; i < s->points->n_internal; i += CHUNK)
    KITH_TRY(sample_chunk(p, s, i, KITH_MIN(i + CHUNK, s->points->n_internal)));
  const kith_status status =
      kith_ranks_allreduce_status(ranks, kith_ranks_rank(ranks) == 0 ? append(p, s) : KITH_OK);
  s->sampled = it->step + 1;
  return status;
}

kith_status kith_probes_sample(struct kith_probes *p, bool last) {
  for (int k = 0; p != NULL && k < p->n; ++k) {
    const uint64_t step = p->simulation->integrator.step;
    struct set *s = &p->set[k];
    const bool is_due = last || step % (uint64_t)s->probe->every == 0;
    if (is_due && s->sampled != step + 1) KITH_TRY(sample(p, s));
  }
  return KITH_OK;
}
