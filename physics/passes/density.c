/* The density pass: supports by Newton's method, sums of masses, velocity gradients. */
#include "physics/passes/density.h"

#include <math.h>
#include <string.h>
#include "lib/core/lanes.h"

/* Lanes of scratch: separations x_j - x_i, distances, weights. */
enum { SEPARATION = 0, DISTANCE = NDIM, WEIGHT, LANES };

/* The iteration ends with a Newton step of ln H that is below this. Omega is that before the last step; the
 * noise that this makes is below a sound wave of amplitude 1e-6. */
static const double tolerance = 1e-7;
static const int max_iterations = 60;

/* What the chunks read. */
struct density_pass {
  struct kith_package *package;
  const struct kith_connectivity *connectivity;
  struct kith_density_wanted wanted;
  double constant;        /* of the kernel */
  double volume;          /* volume of a support over that of a sphere with radius H */
  bool equal_masses;      /* all masses are equal, or count as such */
  const uint8_t *barrier; /* NULL: there is none */
};

/* Computes squares of distances in the metric of the supports. */
static void squares_in_metric(const struct kith_nodes *nodes, size_t n, struct kith_scratch *s) {
  double *restrict r2 = kith_scratch_lane(s, DISTANCE);
  for (size_t k = 0; k < n; ++k) {
    r2[k] = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double d = kith_scratch_lane(s, SEPARATION + a)[k] / nodes->stretch[a];
      r2[k] += d * d;
    }
  }
}

/* Loads separations and distances of the row of i; padding stands far outside of any support. Functions that
 * do not depend on the kernel are not inlined: they would be compiled once per kernel. */
KITH_HOT static size_t load_row(const struct kith_nodes *nodes, const struct kith_rows *rows, kith_index i,
                                struct kith_scratch *s) {
  const size_t n = rows->first[i + 1] - rows->first[i], padded = kith_lanes_padded(n);
  double *restrict r = kith_scratch_lane(s, DISTANCE);
  kith_row_separations(nodes, rows, i, kith_scratch_lane(s, SEPARATION), s->width, r);
  if (nodes->stretched != NULL) squares_in_metric(nodes, n, s);
#pragma omp simd
  for (size_t k = 0; k < n; ++k) r[k] = sqrt(r[k]);
  for (size_t k = n; k < padded; ++k) r[k] = 16 * nodes->search_radius->f64[i];
  return padded;
}

/* Corrects the sums of node i, with support h, for the barriers among its partners. A barrier node of volume
 * V counts as V / V_i nodes like i, where V_i is the volume of a node with support h; but as one node at
 * most, since a barrier node close to much finer gas would otherwise count as all the neighbors that a node
 * wants. masses: weights of the nodes; NULL: all are 1. Returns by how much the sum of w falls with ln H
 * because V_i grows with H. */
KITH_INLINE double wall_sums(enum kith_kernel kernel, const struct density_pass *pass, kith_index i, double h,
                             const double *restrict masses, const struct kith_scratch *s, double *sum_w,
                             double *sum_q2g) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  const double *restrict support = pass->package->hydro->nodes->support->f64;
  const double *restrict r = kith_scratch_lane(s, DISTANCE);
  double fall = 0;
  if (pass->barrier == NULL) return 0;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index k = rows->node[e];
    if (!pass->barrier[k]) continue;
    double w, g;
    const double q = r[e - rows->first[i]] / h, volume = kith_pow_dim(support[k] / h),
                 count = fmin(volume, 1);
    const double like_i = masses != NULL ? count * masses[i] : count, own = masses != NULL ? masses[k] : 1;
    kith_kernel_value(kernel, q, &w, &g);
    *sum_w += (like_i - own) * w;
    *sum_q2g += (like_i - own) * q * q * g; /* so that a uniform gas beside a wall is at rest */
    if (volume < 1) fall += NDIM * like_i * w;
  }
  return fall;
}

/* Sums w and q^2 g over the row and the node itself; weight[k] = -g >= 0, for the gradients. */
KITH_INLINE void kernel_sums(enum kith_kernel kernel, double self, size_t n, const double *restrict r,
                             double *restrict weight, double inverse_support, double *sum_w,
                             double *sum_q2g) {
  double w0, g0, sw = 0, sg = 0;
  kith_kernel_value(kernel, 0, &w0, &g0);
#pragma omp simd reduction(+ : sw, sg)
  for (size_t k = 0; k < n; ++k) {
    double w, g;
    const double q = r[k] * inverse_support;
    kith_kernel_value(kernel, q, &w, &g);
    weight[k] = -g;
    sw += w;
    sg += q * q * g;
  }
  *sum_w = self * w0 + sw;
  *sum_q2g = sg;
}

/* Solves (1) for H in (0, search radius], from the guess *support. C sum w(r / H) grows with H, so the root
 * is unique, but for the part of barriers, which may fall: beside them it is a root near the guess. Returns
 * false if it lies beyond the search radius (*support is then what to try with new connectivity), or if there
 * is none (*support is NaN). */
KITH_INLINE bool solve_support(enum kith_kernel kernel, const struct density_pass *pass, kith_index i,
                               size_t n, double search_radius, double *support, double *sum_w,
                               double *sum_q2g, struct kith_scratch *s) {
  const double wanted = pass->package->neighbors / (kith_ball() * pass->constant);
  double lower = 0, upper = search_radius, h = KITH_MIN(*support, search_radius);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    kernel_sums(kernel, pass->package->self_weight, n, kith_scratch_lane(s, DISTANCE),
                kith_scratch_lane(s, WEIGHT), 1 / h, sum_w, sum_q2g);
    const double fall = wall_sums(kernel, pass, i, h, NULL, s, sum_w, sum_q2g);
    const double step = (wanted - *sum_w) / KITH_MAX(-*sum_q2g - fall, 1e-3 * *sum_w); /* Newton's, of ln H */
    if (fabs(step) < tolerance) { /* after this step the error of H and of the sum is of order step^2 */
      *support = KITH_MIN(h * (1 + step), search_radius);
      *sum_w = wanted;
      return true;
    }
    s->count[KITH_COUNT_ITERATIONS] += 1;
    if (step > 0)
      lower = h;
    else
      upper = h;
    const double newton = h * (1 + KITH_MAX(-0.3, KITH_MIN(step, 0.4)));
    if (step > 0 && h >= search_radius) {
      *support = newton;
      return false;
    }
    h = newton > lower && newton < upper                    ? newton
        : newton >= search_radius && upper >= search_radius ? search_radius
                                                            : 0.5 * (lower + upper);
  }
  *support = NAN;
  return false;
}

/* Sums m w and m q^2 g over the row and the node itself. */
KITH_INLINE void mass_sums(enum kith_kernel kernel, const struct density_pass *pass, kith_index i,
                           double inverse_support, struct kith_scratch *s, double *sum_mw, double *sum_mq2g) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  const kith_index *restrict row = rows->node + rows->first[i];
  const size_t n = rows->first[i + 1] - rows->first[i];
  const double *restrict mass = pass->package->hydro->mass->f64, *restrict r = kith_scratch_lane(s, DISTANCE);
  double w0, g0, sw = 0, sg = 0;
  kith_kernel_value(kernel, 0, &w0, &g0);
#pragma omp simd reduction(+ : sw, sg)
  for (size_t k = 0; k < n; ++k) {
    double w, g;
    const double q = r[k] * inverse_support, m = mass[row[k]];
    kith_kernel_value(kernel, q, &w, &g);
    sw += m * w;
    sg += m * q * q * g;
  }
  *sum_mw = mass[i] * pass->package->self_weight * w0 + sw;
  *sum_mq2g = sg;
  wall_sums(kernel, pass, i, 1 / inverse_support, mass, s, sum_mw, sum_mq2g);
}

/* Replaces the differences d for barriers among the four entries from k on. A barrier has the mirror image of
 * the vector of i, so the difference is twice the component of that vector along x_ij, reversed. */
KITH_INLINE void mirror(const uint8_t *barrier, const kith_index *four, size_t k, const double *vi,
                        const struct kith_scratch *s, kith_lanes *d) {
  for (size_t l = 0; l < KITH_LANES; ++l) {
    if (!barrier[four[l]]) continue;
    const double r = kith_scratch_lane(s, DISTANCE)[k + l];
    double along = 0;
    for (int a = 0; a < NDIM; ++a) along += vi[a] * kith_scratch_lane(s, SEPARATION + a)[k + l];
    for (int a = 0; a < NDIM; ++a)
      d[a][l] = -2 * along * kith_scratch_lane(s, SEPARATION + a)[k + l] / (r * r);
  }
}

/* Computes the gradient of a vector field at node i. Returns false, with a zero gradient, if moments have no
 * inverse. Padding has no weight. */
KITH_INLINE bool linear_gradient(const struct density_pass *pass, const struct kith_field *field,
                                 kith_index i, const struct kith_scratch *s, double *gradient) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  const kith_index *restrict row = rows->node + rows->first[i];
  const size_t n = rows->first[i + 1] - rows->first[i];
  const double *restrict v = field->f64, *restrict vi = v + (size_t)i * NDIM;
  kith_lanes moment[KITH_SYMMETRIC_SIZE] = {{0}}, flux[NDIM][NDIM] = {{{0}}};
  for (size_t k = 0; k < n; k += KITH_LANES) {
    const kith_lanes w = *(const kith_lanes *)(kith_scratch_lane(s, WEIGHT) + k);
    kith_index room[KITH_LANES];
    const kith_index *four = kith_lanes_entries(row, k, n, room);
    kith_lanes x[NDIM], wx[NDIM], d[KITH_VECTOR_LANES];
    kith_lanes_vector(v, four, d);
    for (int a = 0; a < NDIM; ++a) d[a] -= vi[a];
    if (pass->barrier != NULL) mirror(pass->barrier, four, k, vi, s, d);
    for (int a = 0; a < NDIM; ++a) {
      x[a] = *(const kith_lanes *)(kith_scratch_lane(s, SEPARATION + a) + k);
      wx[a] = w * x[a];
    }
    for (int a = 0, m = 0; a < NDIM; ++a)
      for (int b = a; b < NDIM; ++b) moment[m++] += wx[a] * x[b];
    for (int a = 0; a < NDIM; ++a)
      for (int b = 0; b < NDIM; ++b) flux[a][b] += d[a] * wx[b];
  }
  double m[KITH_SYMMETRIC_SIZE], inverse[KITH_SYMMETRIC_SIZE];
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k) m[k] = kith_lanes_total(&moment[k]);
  const bool regular = kith_invert_symmetric(m, 1e-6, inverse);
  for (int a = 0; a < NDIM; ++a) {
    double sum[NDIM];
    for (int b = 0; b < NDIM; ++b) sum[b] = kith_lanes_total(&flux[a][b]), gradient[a * NDIM + b] = 0;
    kith_symmetric_add(inverse, sum, gradient + a * NDIM);
  }
  return regular;
}

/* Sets density, X and Omega of node i from its sums; without another loop over the row if all masses are
 * equal. */
KITH_INLINE void set_density(enum kith_kernel kernel, const struct density_pass *pass, kith_index i,
                             double support, double sum_w, double sum_q2g, struct kith_scratch *s) {
  const double mass = pass->package->hydro->mass->f64[i], omega = -sum_q2g / (NDIM * sum_w);
  double sum_mw = mass * sum_w, sum_mq2g = mass * sum_q2g;
  if (pass->wanted.grad_h_term != NULL) {
    if (!pass->equal_masses) mass_sums(kernel, pass, i, 1 / support, s, &sum_mw, &sum_mq2g);
    pass->wanted.grad_h_term->f64[i] = -(NDIM * sum_mw + sum_mq2g) / (NDIM * sum_w) / omega;
  }
  if (pass->wanted.omega != NULL) pass->wanted.omega->f64[i] = omega;
  pass->package->hydro->density->f64[i] = pass->constant * sum_mw / (pass->volume * kith_pow_dim(support));
}

/* Computes the velocity gradient of node i, and stores what is wanted of it. */
KITH_HOT static void set_gradients(const struct density_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_density_wanted *wanted = &pass->wanted;
  double gradient[NDIM * NDIM], divergence = 0;
  if (!linear_gradient(pass, pass->package->hydro->velocity, i, s, gradient))
    s->count[KITH_COUNT_FALLBACKS] += 1;
  for (int a = 0; a < NDIM; ++a) divergence += gradient[a * NDIM + a];
  pass->package->velocity_divergence->f64[i] = divergence;
  if (wanted->curl != NULL) wanted->curl->f64[i] = kith_curl(gradient);
  if (wanted->shear != NULL) {
    double *shear = wanted->shear->f64 + (size_t)i * KITH_SYMMETRIC_SIZE;
    for (int a = 0; a < NDIM; ++a)
      for (int b = a; b < NDIM; ++b) *shear++ = 0.5 * (gradient[a * NDIM + b] + gradient[b * NDIM + a]);
  }
  for (int k = 0; wanted->gradient != NULL && k < NDIM * NDIM; ++k)
    wanted->gradient->f64[(size_t)i * (NDIM * NDIM) + k] = gradient[k];
  if (wanted->compression == NULL) return;
  double rate = 0, change[NDIM * NDIM];
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) rate -= gradient[a * NDIM + b] * gradient[b * NDIM + a];
  linear_gradient(pass, pass->package->hydro->acceleration, i, s, change);
  for (int a = 0; a < NDIM; ++a) rate += change[a * NDIM + a];
  wanted->compression->f64[i] = rate;
}

KITH_INLINE void density_chunk(enum kith_kernel kernel, const struct density_pass *pass, kith_index begin,
                               kith_index end, struct kith_scratch *s) {
  const struct kith_nodes *nodes = pass->package->hydro->nodes;
  for (kith_index i = begin; i < end; ++i) {
    if (i >= nodes->n_internal && !pass->package->needed[i - nodes->n_internal]) continue;
    double *support = &nodes->support->f64[i], sum_w = 0, sum_q2g = 0;
    const size_t padded = load_row(nodes, &pass->connectivity->rows, i, s);
    s->count[KITH_COUNT_EVALUATIONS] += padded;
    if (!solve_support(kernel, pass, i, padded, nodes->search_radius->f64[i], support, &sum_w, &sum_q2g, s)) {
      s->count[KITH_COUNT_OUTGROWN] += 1;
      continue;
    }
    set_density(kernel, pass, i, *support, sum_w, sum_q2g, s);
    set_gradients(pass, i, s);
  }
}

KITH_KERNEL_CHUNKS(density_chunk)

/* Returns a neighbor of node i at the same place, or -1. */
static kith_index at_same_place(const struct kith_nodes *nodes, const struct kith_rows *rows, kith_index i) {
  const double *x = nodes->position->f64;
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e)
    if (kith_row_shift(rows, e) == rows->zero &&
        memcmp(x + (size_t)i * NDIM, x + (size_t)rows->node[e] * NDIM, NDIM * sizeof *x) == 0)
      return rows->node[e];
  return -1;
}

/* Fails, naming the first node without a solution: one whose support does not converge, else one whose
 * support has to grow beyond its search radius. */
static kith_status unsolved(const struct kith_nodes *nodes, const struct kith_rows *rows) {
  const double *support = nodes->support->f64, *search_radius = nodes->search_radius->f64;
  kith_index first = -1;
  for (kith_index i = 0; i < nodes->n_internal && (first < 0 || !isnan(support[first])); ++i)
    if (isnan(support[i]) || (first < 0 && support[i] > search_radius[i])) first = i;
  if (first < 0) KITH_FAIL(INTERNAL, "a support was counted as unsolved, and all are solved");
  const double *x = nodes->position->f64 + (size_t)first * NDIM;
  const kith_index same = at_same_place(nodes, rows, first);
  const kith_status status = isnan(support[first]) ? KITH_DIVERGED : KITH_OUTGROWN;
  char why[96] = "";
  if (same >= 0)
    snprintf(why, sizeof why, ": node %lld is at the same place", (long long)nodes->id->i64[same]);
  else if (rows->first[first + 1] - rows->first[first] + 1 >= (size_t)kith_nodes_count(nodes))
    snprintf(why, sizeof why, " though all nodes that are left (%lld) are in it",
             (long long)kith_nodes_count(nodes));
  const int64_t id = nodes->id->i64[first];
  return kith_fail_node(status, id, "the support of node %lld at (%g, %g, %g) %s %g%s", (long long)id, x[0],
                        NDIM > 1 ? x[NDIM > 1 ? 1 : 0] : 0.0, NDIM > 2 ? x[NDIM - 1] : 0.0,
                        isnan(support[first]) ? "does not converge within" : "outgrew", search_radius[first],
                        why);
}

/* Do all nodes of all ranks, and frozen ones, have the same mass? All ranks have to sum in the same way.
 * Masses change only where ghosts are made again. */
static bool equal_masses(struct kith_hydro *hydro) {
  const kith_index n = kith_nodes_count(hydro->nodes);
  const double *m = hydro->mass->f64;
  bool equal = true;
  if (hydro->masses_of != hydro->nodes->ghosts) {
#pragma omp parallel for simd schedule(static) reduction(&& : equal)
    for (kith_index i = 0; i < n; ++i) equal = equal && m[i] == m[0];
    hydro->equal_here = equal, hydro->masses_of = hydro->nodes->ghosts;
  }
  return hydro->equal_here && (hydro->nodes->ranks == NULL || hydro->equal_masses);
}

/* Recomputes the remote ghosts that internal nodes read, as their owners do, from their own rows. The owners
 * report failures. */
static kith_status recompute(const struct density_pass *pass, struct kith_node_sweep sweep) {
  struct kith_package *package = pass->package;
  const struct kith_nodes *nodes = package->hydro->nodes;
  const kith_index first = kith_nodes_first_remote(nodes);
  KITH_TRY(kith_reserve(&package->needed, &package->needed_capacity, (size_t)nodes->n_ghost, 1));
  if (nodes->n_ghost > 0) memset(package->needed, 0, (size_t)nodes->n_ghost);
  kith_connectivity_mark_ghosts(pass->connectivity, nodes, package->needed);
  sweep.stage = "recompute";
  return kith_package_sweep_ghosts(package, &sweep, first, kith_nodes_count(nodes) - first);
}

kith_status kith_density(struct kith_package *package, const struct kith_connectivity *connectivity,
                         const struct kith_density_wanted *wanted) {
  const struct kith_nodes *nodes = package->hydro->nodes;
  KITH_TRY(kith_connectivity_provides(connectivity, nodes, kith_package_requirements(package)));
  if (wanted->compression != NULL) {
    KITH_TRY(kith_ranks_finish_agree(nodes->ranks));
    kith_package_start_refresh(package, 1, &(struct kith_field *){package->hydro->acceleration});
  }
  struct density_pass pass = {.package = package,
                              .connectivity = connectivity,
                              .wanted = *wanted,
                              .constant = kith_kernel_constant(package->kernel),
                              .volume = nodes->volume,
                              .equal_masses = wanted->own_masses || equal_masses(package->hydro),
                              .barrier = package->barrier != NULL ? package->barrier->u8 : NULL};
  /* Values that only the node itself reads or writes: support (both), search radius, mass, density,
   * divergence; what is wanted. */
  const int scalars = 6 + (wanted->grad_h_term != NULL) + (wanted->omega != NULL) + (wanted->curl != NULL) +
                      (wanted->compression != NULL) + (wanted->shear != NULL) * KITH_SYMMETRIC_SIZE +
                      (wanted->gradient != NULL ? NDIM * NDIM : 0);
  const struct kith_node_sweep sweep = {.stage = "density",
                                        .rows = &connectivity->rows,
                                        .chunk = density_chunk_of[package->kernel],
                                        .context = &pass,
                                        .lanes = LANES,
                                        .width = kith_rows_longest(&connectivity->rows),
                                        .iterates = true,
                                        .begins = true,
                                        .shared = 8 * NDIM * (wanted->compression != NULL ? 3 : 2),
                                        .own = 8 * scalars};
  uint64_t count[KITH_COUNTS];
  kith_status status = kith_package_sweep(package, &sweep, count);
  if (status == KITH_OK && package->recompute) status = recompute(&pass, sweep);
  if (status == KITH_OK && count[KITH_COUNT_OUTGROWN] > 0) status = unsolved(nodes, &connectivity->rows);
  return kith_ranks_start_agree(nodes->ranks, status, 0, NULL);
}
