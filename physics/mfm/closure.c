/* Closed faces: equation (2) of faces.h, one vector per node, all axes in one solve. */
#include <math.h>
#include <string.h>
#include <sunlinsol/sunlinsol_pcg.h>
#include "lib/comm/vector.h"
#include "lib/core/vec.h"
#include "physics/mfm/faces.h"

static const double surface_share =
    0.12; /* |sum A| / sum |A|: a smooth surface has more, with the usual neighbors 0.24 */
static const double tolerance = 1e-14; /* of |sum A| / sum |A|, root mean square over the nodes */

static const struct kith_pairwise_spec face_weight = {"face_weight", 1, false,
                                                      "the face of SPH, by which faces are closed"};

/* x_j - x_i, j displaced by shift s. */
static void separation(const struct mfm_faces *f, kith_index i, kith_index j, int s, double d[NDIM]) {
  const double *x = f->nodes->position->f64;
  for (int a = 0; a < NDIM; ++a)
    d[a] = x[(size_t)j * NDIM + a] + (f->nodes->shifts.n > 1 ? f->nodes->shifts.by[s][a] : 0) -
           x[(size_t)i * NDIM + a];
}

/* a_ij of pair p: the face that SPH would give it; none where a barrier parts the pair. */
static double weight_of(const struct mfm_faces *f, size_t p) {
  const kith_index *pair = f->graph.pairs.node[p];
  if (f->barrier != NULL && kith_norm(f->area->value + p * NDIM) == 0) return 0;
  const uint16_t *shift = f->graph.pairs.shift;
  double sum = 0, d[NDIM];
  separation(f, pair[0], pair[1], shift != NULL ? shift[p] : 0, d);
  const double r = sqrt(kith_dot(d, d));
  for (int end = 0; end < 2; ++end) {
    const double h = f->nodes->support->f64[pair[end]], volume = kith_ball() * kith_pow_dim(h) / f->neighbors;
    double w, g;
    if (r >= h) continue;
    kith_kernel_value(f->kernel, r / h, &w, &g);
    sum -= volume * volume * kith_kernel_constant(f->kernel) / (kith_pow_dim(h) * h * h) * g * r;
  }
  return sum;
}

/* Is the missing face of node i a free surface? It is if no neighbor lies in its direction within 53 degrees
 * (measured inside a gas: within 42). */
static bool is_surface(const struct mfm_faces *f, kith_index i, const double *missing) {
  const struct kith_rows *links = &f->links;
  const double least2 = 0.36 * kith_dot(missing, missing);
  for (size_t e = links->first[i]; e < links->first[i + 1]; ++e) {
    double d[NDIM];
    separation(f, i, links->node[e], kith_row_shift(links, e), d);
    const double along = kith_dot(d, missing);
    if (along > 0 && along * along >= least2 * kith_dot(d, d)) return false;
  }
  return true;
}

/* Rows of the linked nodes: those of pairs with a weight. */
static kith_status link_nodes(struct mfm_faces *f) {
  const struct kith_rows *rows = &f->graph.rows;
  const uint32_t *of_row = f->graph.pairs.of_row;
  struct kith_rows *links = &f->links;
  KITH_TRY(kith_pairwise_prepare(&f->graph.pairs, &face_weight, &f->weight));
  KITH_TRY(kith_rows_reserve(links, rows->n));
#pragma omp parallel for schedule(static)
  for (size_t p = 0; p < f->graph.pairs.n; ++p) f->weight->value[p] = weight_of(f, p);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < rows->n; ++i) {
    size_t n = 0;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) n += f->weight->value[of_row[e]] > 0;
    links->first[i + 1] = n;
  }
  KITH_TRY(kith_rows_sum(links));
  KITH_TRY(kith_rows_shift(links, rows->shift != NULL ? rows->zero : -1));
  KITH_TRY(kith_reserve(&f->link_weight, &f->link_capacity, links->first[rows->n], sizeof *f->link_weight));
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < rows->n; ++i) {
    size_t at = links->first[i];
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      if (!(f->weight->value[of_row[e]] > 0)) continue;
      links->node[at] = rows->node[e];
      if (links->shift != NULL) links->shift[at] = rows->shift[e];
      f->link_weight[at++] = f->weight->value[of_row[e]];
    }
  }
  return KITH_OK;
}

/* The right-hand side - sum A, the diagonal sum a (negative where the node stays open), and 1 / sum |A| into
 * scale[n][NDIM]. */
static void equations(struct mfm_faces *f, double *restrict scale) {
  const struct kith_rows *rows = &f->graph.rows;
#pragma omp parallel for schedule(dynamic, 128)
  for (kith_index i = 0; i < rows->n; ++i) {
    double sum[NDIM] = {0}, whole = 0, weights = 0;
    for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
      const size_t p = f->graph.pairs.of_row[e];
      const double sign = kith_pair_starts(&f->graph, i, e) ? 1 : -1;
      for (int a = 0; a < NDIM; ++a) sum[a] -= sign * f->area->value[p * NDIM + a];
      whole += kith_norm(f->area->value + p * NDIM);
    }
    for (size_t e = f->links.first[i]; e < f->links.first[i + 1]; ++e) weights += f->link_weight[e];
    const bool surface = (f->barrier != NULL && f->barrier->u8[i]) ||
                         (!(kith_norm(sum) <= surface_share * whole) && is_surface(f, i, sum));
    f->diagonal[i] = surface || weights == 0 ? -1 : weights;
    for (int a = 0; a < NDIM; ++a) {
      f->open[(size_t)i * NDIM + a] = f->diagonal[i] < 0 ? 0 : sum[a];
      scale[(size_t)i * NDIM + a] = 1 / KITH_MAX(whole, 1e-300);
    }
  }
}

/* z_i = sum_j a_ij (v_i - v_j). */
static int laplacian(void *context, N_Vector v, N_Vector z) {
  struct mfm_faces *f = context;
  const struct kith_rows *links = &f->links;
  double *restrict shift = f->shift->f64, *restrict out = kith_vector_numbers(z, 0);
  if (f->graph.rows.n > 0)
    memcpy(shift, kith_vector_numbers(v, 0), (size_t)f->graph.rows.n * NDIM * sizeof *shift);
  kith_halo_refresh(f->halo, f->nodes, &f->shift, 1);
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < f->graph.rows.n; ++i) {
    double sum[NDIM];
    for (int a = 0; a < NDIM; ++a) sum[a] = fabs(f->diagonal[i]) * shift[(size_t)i * NDIM + a];
    for (size_t e = links->first[i]; f->diagonal[i] > 0 && e < links->first[i + 1]; ++e)
      for (int a = 0; a < NDIM; ++a) sum[a] -= f->link_weight[e] * shift[(size_t)links->node[e] * NDIM + a];
    for (int a = 0; a < NDIM; ++a) out[(size_t)i * NDIM + a] = sum[a];
  }
  return 0;
}

/* z = r / sum a. */
static int jacobi(void *context, N_Vector r, N_Vector z, sunrealtype unused_tolerance, int side) {
  const struct mfm_faces *f = context;
  const double *restrict in = kith_vector_numbers(r, 0);
  double *restrict out = kith_vector_numbers(z, 0);
  (void)unused_tolerance, (void)side;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < f->graph.rows.n; ++i)
    for (int a = 0; a < NDIM; ++a)
      out[(size_t)i * NDIM + a] = in[(size_t)i * NDIM + a] / fabs(f->diagonal[i]);
  return 0;
}

/* --- solving --- */

/* What a solution needs; made on all ranks before any of them begins. */
struct solver {
  struct kith_vectors *vectors;
  N_Vector scale, solution;
  SUNLinearSolver pcg;
};

static kith_status create(struct solver *s, struct mfm_faces *f, int iterations) {
  const size_t n = (size_t)f->graph.rows.n;
  KITH_TRY(link_nodes(f));
  KITH_TRY(kith_reserve(&f->open, &f->open_capacity, n * NDIM, sizeof *f->open));
  KITH_TRY(kith_reserve(&f->diagonal, &f->diagonal_capacity, n, sizeof *f->diagonal));
  s->scale = kith_vector_clone(s->vectors), s->solution = kith_vector_clone(s->vectors);
  if (s->solution != NULL)
    s->pcg = SUNLinSol_PCG(s->solution, SUN_PREC_LEFT, iterations, s->vectors->context);
  if (s->scale == NULL || s->pcg == NULL) KITH_FAIL(NO_MEMORY, "no memory to close faces");
  return KITH_OK;
}

static void destroy(struct solver *s) {
  if (s->pcg != NULL) SUNLinSolFree(s->pcg);
  if (s->scale != NULL) N_VDestroy(s->scale);
  if (s->solution != NULL) N_VDestroy(s->solution);
  kith_vectors_destroy(&s->vectors);
}

/* The shifts l of all nodes, from zero. The number of all numbers is `all`. */
static kith_status solve(const struct solver *s, struct mfm_faces *f, double all) {
  equations(f, kith_vector_numbers(s->scale, 0));
  N_VConst(0, s->solution);
  SUNLinSolSetATimes(s->pcg, f, laplacian);
  SUNLinSolSetPreconditioner(s->pcg, f, NULL, jacobi);
  SUNLinSolSetScalingVectors(s->pcg, s->scale, NULL);
  SUNLinSolSetZeroGuess(s->pcg, SUNTRUE);
  int error = SUNLinSolInitialize(s->pcg);
  if (error == 0) error = SUNLinSolSetup(s->pcg, NULL);
  if (error == 0) error = SUNLinSolSolve(s->pcg, NULL, s->solution, s->vectors->view, tolerance * sqrt(all));
  if (f->graph.rows.n > 0)
    memcpy(f->shift->f64, kith_vector_numbers(s->solution, 0),
           (size_t)f->graph.rows.n * NDIM * sizeof(double));
  kith_halo_refresh(f->halo, f->nodes, &f->shift, 1);
  if (error == 0 || error == SUNLS_RES_REDUCED) return KITH_OK;
  return kith_fail(error < 0 ? KITH_INTERNAL : KITH_DIVERGED, "faces cannot be closed: the solver gave %d",
                   error);
}

/* A_ij += a_ij (l_i - l_j). */
static void apply(struct mfm_faces *f) {
  const double *restrict shift = f->shift->f64;
#pragma omp parallel for schedule(static)
  for (size_t p = 0; p < f->graph.pairs.n; ++p) {
    const kith_index *pair = f->graph.pairs.node[p];
    for (int a = 0; a < NDIM; ++a)
      f->area->value[p * NDIM + a] +=
          f->weight->value[p] * (shift[(size_t)pair[0] * NDIM + a] - shift[(size_t)pair[1] * NDIM + a]);
  }
}

kith_status mfm_faces_close(struct mfm_faces *f) {
  struct kith_ranks *ranks = f->nodes->ranks;
  uint64_t all = (uint64_t)f->graph.rows.n;
  if (all == 0 && ranks == NULL) return KITH_OK;
  kith_ranks_sum_counts(ranks, &all, 1);
  /* On a line it takes as many iterations as there are nodes. */
  const int most = (int)KITH_MIN(100 + 2 * all, INT32_MAX);
  const struct kith_vector_part part = {&f->open, (int64_t)f->graph.rows.n * NDIM};
  struct solver solver = {0};
  kith_status status = kith_vectors_create(&solver.vectors, ranks, 1, &part);
  if (status == KITH_OK) status = create(&solver, f, most);
  if (status == KITH_OK && solver.vectors->lacking)
    status = kith_fail(KITH_NO_MEMORY, "no memory to close faces");
  status = kith_ranks_allreduce_status(ranks, status);
  if (status == KITH_OK) status = kith_ranks_allreduce_status(ranks, solve(&solver, f, (double)all * NDIM));
  destroy(&solver);
  if (status == KITH_OK) apply(f);
  return status;
}
