#include "physics/sph/sph.h"

/* Lanes of scratch behind the values of the pairs: x_ij . x_ij, v_ij . x_ij, x.G.x at both ends, x_ij. */
enum { R2 = SPH_PAIR_VALUES, VX, SLOPE_I, SLOPE_J, SEPARATION, LANES = SEPARATION + NDIM };

/* Van Leer's limiter of two slopes, 4 r / (1 + r)^2 with r their ratio: 0 if they differ in sign, 1 if they are equal. */
static inline double limiter(double slope_i, double slope_j) {
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  return product > 0 ? 4 * product / (sum * sum) : 0;
}

struct pair_constants {
  double alpha, beta, constant;
  double spacings; /* H in mean node spacings */
};

/* C / H^(d + 2) g(q): the factor of x_ij in grad_i W. */
KITH_INLINE double gradient_factor(enum kith_kernel kernel, double constant, double q,
                                   double inverse_support) {
  double w, g;
  kith_kernel_value(kernel, q, &w, &g);
  return constant * g * kith_pow_dim(inverse_support) * inverse_support * inverse_support;
}

/* What the arithmetic of a pair needs of one end. */
struct end {
  double inverse_support, psi, excess, mass, density, sound;
};

/* `at`: 32 bits, so that the loads of several nodes become one gather; the records of 10^8 nodes fit. */
KITH_INLINE struct end end_of(const double *restrict record, kith_index at) {
  return (struct end){record[at + SPH_INVERSE], record[at + SPH_PSI],     record[at + SPH_EXCESS],
                      record[at + SPH_MASS],    record[at + SPH_DENSITY], record[at + SPH_SOUND]};
}

/* One pair: (3) - (5), with r2 = x_ij . x_ij, vx = v_ij . x_ij and the slopes x.G.x of the velocity at both ends.
 * The force on i is force x_ij, what i gets of its work is heat x_ij . v_ji; j gets the opposite and the rest. */
KITH_INLINE void sph_pair(enum kith_kernel kernel, bool limited, struct pair_constants c, struct end i,
                          struct end j, double r2, double vx, double slope_i, double slope_j, double *force,
                          double *heat, double *signal) {
  const double r = sqrt(r2), inverse_r = 1 / KITH_MAX(r, 1e-30);
  const double qi = r * i.inverse_support, qj = r * j.inverse_support;
  const double gi = gradient_factor(kernel, c.constant, qi, i.inverse_support);
  const double gj = gradient_factor(kernel, c.constant, qj, j.inverse_support);

  double jump = vx; /* v_ij . x_ij between the velocities that the viscosity sees */
  if (limited) {
    const double closer =
        5 * KITH_MIN(c.spacings * KITH_MAX(qi, qj) - 1, 0.0); /* than the mean spacing, in fifths of it */
    const double phi = limiter(slope_i, slope_j) * KITH_MAX(1 - closer * closer, 0.0);
    jump = KITH_MAX(vx - 0.5 * phi * (slope_i + slope_j), vx); /* never more than the whole jump */
  }
  const double mu = vx < 0 ? KITH_MIN(jump, 0.0) * inverse_r : 0;
  const double sound = 0.5 * (i.sound + j.sound);
  const double viscosity = (c.beta * mu - c.alpha * sound) * mu / (i.density + j.density); /* Pi / 2 */

  const double fi = -i.psi * (j.mass - i.excess) * gi, fj = -j.psi * (i.mass - j.excess) * gj;
  const double fq = -i.mass * j.mass * viscosity * (gi + gj);
  *force = fi + fj + fq;
  *heat = fi + 0.5 * fq;
  *signal = r2 > 0 && gi + gj < 0 ? KITH_MAX(c.alpha, 1.0) * sound - c.beta * mu : 0;
}

/* Geometry of the pairs of i with n nodes partner[0], partner[stride], ...: axis by axis, so that every loop is a plain one. */
KITH_INLINE void load_geometry(bool limited, const double *restrict record, kith_index i,
                               const kith_index *restrict partner, size_t stride, size_t n,
                               struct kith_scratch *s) {
  double *restrict r2 = kith_scratch_lane(s, R2), *restrict vx = kith_scratch_lane(s, VX);
  double *restrict slope_i = kith_scratch_lane(s, SLOPE_I), *restrict slope_j = kith_scratch_lane(s, SLOPE_J);
  const double *self = record + (size_t)i * SPH_RECORD;
  for (int a = 0; a < NDIM; ++a) {
    double *restrict x = kith_scratch_lane(s, SEPARATION + a);
    const double xi = self[SPH_X + a], vi = self[SPH_V + a];
    for (size_t k = 0; a == 0 && k < n; ++k) r2[k] = vx[k] = 0;
#pragma omp simd
    for (size_t k = 0; k < n; ++k) {
      const kith_index j = partner[k * stride] * SPH_RECORD;
      x[k] = xi - record[j + SPH_X + a];
      r2[k] += x[k] * x[k];
      vx[k] += (vi - record[j + SPH_V + a]) * x[k];
    }
  }
  for (int a = 0, m = 0; limited && a < NDIM; ++a)
    for (int b = a; b < NDIM; ++b, ++m) {
      const double *restrict xa = kith_scratch_lane(s, SEPARATION + a);
      const double *restrict xb = kith_scratch_lane(s, SEPARATION + b);
      const double twice = a == b ? 1 : 2, shear = self[SPH_GRADIENT + m];
      for (size_t k = 0; m == 0 && k < n; ++k) slope_i[k] = slope_j[k] = 0;
#pragma omp simd
      for (size_t k = 0; k < n; ++k) {
        const double xx = twice * xa[k] * xb[k];
        slope_i[k] += shear * xx;
        slope_j[k] += record[partner[k * stride] * SPH_RECORD + SPH_GRADIENT + m] * xx;
      }
    }
}

/* force, heat, signal of the same pairs. */
KITH_INLINE void evaluate_row(enum kith_kernel kernel, bool limited, const struct sph_pass *pass,
                              kith_index i, const kith_index *restrict partner, size_t stride, size_t n,
                              struct kith_scratch *s) {
  const struct pair_constants c = {pass->package->alpha, pass->package->beta, pass->constant, pass->spacings};
  const double *restrict record = pass->sph->record;
  load_geometry(limited, record, i, partner, stride, n, s);
  const double *restrict r2 = kith_scratch_lane(s, R2), *restrict vx = kith_scratch_lane(s, VX);
  const double *restrict slope_i = kith_scratch_lane(s, SLOPE_I), *restrict slope_j =
                                                                      kith_scratch_lane(s, SLOPE_J);
  double *restrict force = kith_scratch_lane(s, SPH_FORCE), *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                   *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
  const struct end self = end_of(record, i * SPH_RECORD);
#pragma omp simd
  for (size_t k = 0; k < n; ++k)
    sph_pair(kernel, limited, c, self, end_of(record, partner[k * stride] * SPH_RECORD), r2[k], vx[k],
             slope_i[k], slope_j[k], &force[k], &heat[k], &signal[k]);
}

/* The pairs whose lower end is a node of the chunk, into the pairwise field. */
KITH_INLINE void pairs_chunk(enum kith_kernel kernel, bool limited, const struct sph_pass *pass,
                             kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_pairs *pairs = &pass->connectivity->pairs;
  for (kith_index i = begin; i < end; ++i) {
    const size_t first = pairs->first[i], n = pairs->first[i + 1] - first;
    evaluate_row(kernel, limited, pass, i, &pairs->node[first][1], 2, n, s);
    s->count[0] += n;
    double *restrict value = pass->sph->pair.value + first * SPH_PAIR_VALUES;
    for (size_t k = 0; k < n; ++k)
      for (int m = 0; m < SPH_PAIR_VALUES; ++m) value[k * SPH_PAIR_VALUES + m] = kith_scratch_lane(s, m)[k];
  }
}

/* The same lanes for the whole row of i, from the pairwise field: the upper end of a pair gets the rest of the work.
 * Of the geometry the sums need x_ij and v_ij . x_ij (of the work pass: only x_ij). */
KITH_INLINE void load_row(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const uint32_t *restrict pair = pass->connectivity->pairs.of_row + first;
  const kith_index *restrict row = rows->node + first;
  const double *restrict value = pass->sph->pair.value;
  double *restrict force = kith_scratch_lane(s, SPH_FORCE), *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                   *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
  load_geometry(false, pass->sph->record, i, row, 1, n, s);
  for (size_t k = 0; k < n; ++k) {
    const double *v = value + (size_t)pair[k] * SPH_PAIR_VALUES;
    force[k] = v[SPH_FORCE];
    heat[k] = row[k] > i ? v[SPH_HEAT] : v[SPH_FORCE] - v[SPH_HEAT];
    signal[k] = v[SPH_SIGNAL];
  }
}

/* Sums of one row: acceleration and signal, and the energy rate if it is thermal. */
KITH_INLINE void sum_force(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_package *package = pass->package;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t n = rows->first[i + 1] - rows->first[i];
  const double *self = pass->sph->record + (size_t)i * SPH_RECORD, *restrict vx = kith_scratch_lane(s, VX);
  const double *restrict force = kith_scratch_lane(s, SPH_FORCE),
                         *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                         *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
  double fastest = self[SPH_SOUND], rate = 0;
#pragma omp simd reduction(max : fastest) reduction(+ : rate)
  for (size_t k = 0; k < n; ++k) {
    fastest = KITH_MAX(fastest, signal[k]);
    rate -= heat[k] * vx[k];
  }
  for (int a = 0; a < NDIM; ++a) {
    const double *restrict x = kith_scratch_lane(s, SEPARATION + a);
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t k = 0; k < n; ++k) sum += force[k] * x[k];
    package->hydro->acceleration->f64[(size_t)i * NDIM + a] = sum / self[SPH_MASS];
  }
  pass->sph->signal->f64[i] = fastest;
  if (!package->compatible) package->hydro->energy_rate->f64[i] = rate / self[SPH_MASS];
}

/* Sums of one row: rate and slope of the compatible energy. */
KITH_INLINE void sum_work(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_package *package = pass->package;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t n = rows->first[i + 1] - rows->first[i];
  const kith_index *restrict row = rows->node + rows->first[i];
  const double *restrict v = package->velocity_base->f64, *restrict acceleration =
                                                              package->hydro->acceleration->f64;
  const double *restrict heat = kith_scratch_lane(s, SPH_HEAT);
  double rate = 0, slope = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double *restrict x = kith_scratch_lane(s, SEPARATION + a);
    const double vi = v[(size_t)i * NDIM + a], ai = acceleration[(size_t)i * NDIM + a];
#pragma omp simd reduction(+ : rate, slope)
    for (size_t k = 0; k < n; ++k) {
      const double hx = heat[k] * x[k];
      rate += hx * (v[row[k] * NDIM + a] - vi);
      slope += hx * (acceleration[row[k] * NDIM + a] - ai);
    }
  }
  const double mass = package->hydro->mass->f64[i];
  package->hydro->energy_rate->f64[i] = rate / mass;
  package->energy_slope->f64[i] = slope / mass;
}

KITH_INLINE void nodes_chunk(enum kith_kernel kernel, bool limited, const struct sph_pass *pass,
                             kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  for (kith_index i = begin; i < end; ++i) {
    if (pass->package->traversal == KITH_TRAVERSE_PAIRS) {
      load_row(pass, i, s);
    } else {
      const size_t n = rows->first[i + 1] - rows->first[i];
      evaluate_row(kernel, limited, pass, i, rows->node + rows->first[i], 1, n, s);
      s->count[0] += n;
    }
    if (pass->work)
      sum_work(pass, i, s);
    else
      sum_force(pass, i, s);
  }
}

#define X(name, ...)                                                                 \
  KITH_HOT static void pairs_##name(void *context, kith_index begin, kith_index end, \
                                    struct kith_scratch *s) {                        \
    const struct sph_pass *pass = context;                                           \
    if (pass->sph->shear != NULL)                                                    \
      pairs_chunk(KITH_KERNEL_##name, true, pass, begin, end, s);                    \
    else                                                                             \
      pairs_chunk(KITH_KERNEL_##name, false, pass, begin, end, s);                   \
  }                                                                                  \
  KITH_HOT static void nodes_##name(void *context, kith_index begin, kith_index end, \
                                    struct kith_scratch *s) {                        \
    const struct sph_pass *pass = context;                                           \
    if (pass->sph->shear != NULL)                                                    \
      nodes_chunk(KITH_KERNEL_##name, true, pass, begin, end, s);                    \
    else                                                                             \
      nodes_chunk(KITH_KERNEL_##name, false, pass, begin, end, s);                   \
  }
KITH_KERNEL_LIST(X)
#undef X

/* Runs one of the passes above under the name of a stage. */
static kith_status run(struct sph_pass *pass, const kith_chunk_pass *chunk, const char *stage) {
  struct kith_package *package = pass->package;
  uint64_t count[4];
  kith_profile_begin(package->profile, stage);
  const kith_status status =
      kith_traverse(package->hydro->nodes->n_internal, chunk[package->kernel], pass, LANES,
                    kith_rows_longest(&pass->connectivity->rows), count, package->profile);
  kith_profile_end(package->profile);
  package->pair_evaluations += count[0];
  return status;
}

static const kith_chunk_pass pairs_pass[] = {
#define X(name, ...) pairs_##name,
    KITH_KERNEL_LIST(X)
#undef X
};
static const kith_chunk_pass nodes_pass[] = {
#define X(name, ...) nodes_##name,
    KITH_KERNEL_LIST(X)
#undef X
};

kith_status sph_pack(struct sph_pass *pass) {
  const struct kith_hydro *hydro = pass->package->hydro;
  const struct sph *sph = pass->sph;
  const struct kith_nodes *nodes = hydro->nodes;
  const kith_index n = kith_nodes_count(nodes);
  if (n > INT32_MAX / SPH_RECORD)
    KITH_FAIL(UNSUPPORTED,
              "%d nodes and ghosts in one process: records are addressed with 32 bits, at most %d", n,
              INT32_MAX / SPH_RECORD);
  if (pass->sph->record_capacity < (size_t)n) {
    const size_t capacity = (size_t)n + (size_t)n / 32; /* ghosts come and go */
    KITH_TRY(kith_resize(&pass->sph->record, 0, capacity, SPH_RECORD * sizeof(double)));
    pass->sph->record_capacity = capacity;
  }
  kith_profile_begin(pass->package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    double *record = sph->record + (size_t)i * SPH_RECORD;
    const size_t at = (size_t)i * NDIM;
    for (int a = 0; a < NDIM; ++a) {
      record[SPH_X + a] = nodes->position->f64[at + a];
      record[SPH_V + a] = hydro->velocity->f64[at + a];
    }
    const double density = hydro->density->f64[i], mass = hydro->mass->f64[i];
    record[SPH_INVERSE] = 1 / nodes->support->f64[i];
    record[SPH_PSI] = mass * hydro->pressure->f64[i] / (density * density);
    record[SPH_EXCESS] = sph->excess->f64[i];
    record[SPH_MASS] = mass;
    record[SPH_DENSITY] = density;
    record[SPH_SOUND] = hydro->sound_speed->f64[i];
    for (int k = 0; sph->shear != NULL && k < SPH_SHEAR; ++k)
      record[SPH_GRADIENT + k] = sph->shear->f64[(size_t)i * SPH_SHEAR + k];
  }
  kith_profile_end(pass->package->profile);
  return KITH_OK;
}

kith_status sph_force(struct sph_pass *pass) {
  pass->work = false;
  if (pass->package->traversal == KITH_TRAVERSE_PAIRS) {
    KITH_TRY(kith_pairwise_prepare(&pass->sph->pair, pass->connectivity, SPH_PAIR_VALUES));
    KITH_TRY(run(pass, pairs_pass, "pairs"));
  }
  return run(pass, nodes_pass, "force");
}

kith_status sph_work(struct sph_pass *pass) {
  pass->work = true;
  return run(pass, nodes_pass, "work");
}
