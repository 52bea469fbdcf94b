#include "lib/core/lanes.h"
#include "physics/sph/sph.h"

enum { LANES = SPH_PAIR_VALUES };

/* x.S.x of a symmetric matrix by its upper triangle. */
static inline double project(const double *s, const double *x) {
  double sum = 0;
  for (int a = 0, k = 0; a < NDIM; ++a)
    for (int b = a; b < NDIM; ++b) sum += (a == b ? 1 : 2) * s[k++] * x[a] * x[b];
  return sum;
}

/* Van Leer's limiter of two slopes, 4 r / (1 + r)^2 with r their ratio: 0 if they differ in sign, 1 if they are equal. */
static inline double limiter(double slope_i, double slope_j) {
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  return product > 0 ? 4 * product / (sum * sum) : 0;
}

struct pair_constants {
  double alpha, beta, constant;
  double spacings; /* H in mean node spacings */
};

/* One pair: (3) - (5). The force on i is force x_ij, what i gets of its work is heat x_ij . v_ji; j gets the opposite and the rest. */
__attribute__((always_inline)) static inline void sph_pair(enum kith_kernel kernel, bool limited,
                                                           const struct pair_constants *c, const struct sph_record *i,
                                                           const struct sph_record *j, double *force, double *heat,
                                                           double *signal) {
  double x[NDIM], r2 = 0, vx = 0;
  for (int a = 0; a < NDIM; ++a) {
    x[a] = i->x[a] - j->x[a];
    r2 += x[a] * x[a];
    vx += (i->v[a] - j->v[a]) * x[a];
  }
  const double r = sqrt(r2), inverse_r = 1 / fmax(r, 1e-30);
  const double qi = r * i->inverse_support, qj = r * j->inverse_support;
  double w, gi, gj;
  kith_kernel_value(kernel, qi, &w, &gi);
  kith_kernel_value(kernel, qj, &w, &gj);
  gi *= c->constant * kith_pow_dim(i->inverse_support) * i->inverse_support * i->inverse_support;
  gj *= c->constant * kith_pow_dim(j->inverse_support) * j->inverse_support * j->inverse_support;

  double jump = vx; /* v_ij . x_ij between the velocities that the viscosity sees */
  if (limited) {
    const double slope_i = project(i->shear, x), slope_j = project(j->shear, x);
    const double closer = 5 * fmin(c->spacings * fmax(qi, qj) - 1, 0.0); /* than the mean spacing, in fifths of it */
    const double phi = limiter(slope_i, slope_j) * fmax(1 - closer * closer, 0.0);
    jump = fmax(vx - 0.5 * phi * (slope_i + slope_j), vx); /* never more than the whole jump */
  }
  const double mu = vx < 0 ? fmin(jump, 0.0) * inverse_r : 0;
  const double sound = 0.5 * (i->sound_speed + j->sound_speed);
  const double viscosity = (c->beta * mu - c->alpha * sound) * mu / (i->density + j->density); /* Pi / 2 */

  const double fi = -i->psi * (j->mass - i->excess) * gi, fj = -j->psi * (i->mass - j->excess) * gj;
  const double fq = -i->mass * j->mass * viscosity * (gi + gj);
  *force = fi + fj + fq;
  *heat = fi + 0.5 * fq;
  *signal = r2 > 0 && (gi < 0 || gj < 0) ? fmax(c->alpha, 1.0) * sound - c->beta * mu : 0;
}

/* force, heat, signal of i with n nodes partner[0], partner[stride], ... into lanes, padded with zeros. */
__attribute__((always_inline)) static inline void evaluate_row(enum kith_kernel kernel, bool limited,
                                                               const struct sph_pass *pass, kith_index i,
                                                               const kith_index *partner, size_t stride, size_t n,
                                                               struct kith_scratch *s) {
  const struct kith_package *package = pass->package;
  const struct pair_constants c = {package->alpha, package->beta, kith_kernel_constant(kernel),
                                   pow(package->neighbors / kith_ball(), 1.0 / NDIM)};
  const struct sph_record *restrict record = pass->sph->record;
  double *restrict force = kith_scratch_lane(s, SPH_FORCE), *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                   *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
  const struct sph_record self = record[i];
#pragma omp simd
  for (size_t k = 0; k < n; ++k)
    sph_pair(kernel, limited, &c, &self, &record[partner[k * stride]], &force[k], &heat[k], &signal[k]);
}

/* The pairs whose lower end is a node of the chunk, into the pairwise field. */
__attribute__((always_inline)) static inline void pairs_chunk(enum kith_kernel kernel, bool limited,
                                                              const struct sph_pass *pass, kith_index begin,
                                                              kith_index end, struct kith_scratch *s) {
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

/* The same lanes for the whole row of i, from the pairwise field: the upper end of a pair gets the rest of the work. */
static inline void load_row(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t first = rows->first[i], n = rows->first[i + 1] - first;
  const uint32_t *restrict pair = pass->connectivity->pairs.of_row + first;
  const kith_index *restrict row = rows->node + first;
  const double *restrict value = pass->sph->pair.value;
  double *restrict force = kith_scratch_lane(s, SPH_FORCE), *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                   *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
#pragma omp simd
  for (size_t k = 0; k < n; ++k) {
    const double *v = value + (size_t)pair[k] * SPH_PAIR_VALUES;
    force[k] = v[SPH_FORCE];
    heat[k] = row[k] > i ? v[SPH_HEAT] : v[SPH_FORCE] - v[SPH_HEAT];
    signal[k] = v[SPH_SIGNAL];
  }
}

/* Sums of one row: acceleration and signal, and the energy rate if it is thermal. */
static inline void sum_force(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_package *package = pass->package;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t n = rows->first[i + 1] - rows->first[i];
  const kith_index *restrict row = rows->node + rows->first[i];
  const struct sph_record *restrict record = pass->sph->record;
  const double *restrict force = kith_scratch_lane(s, SPH_FORCE), *restrict heat = kith_scratch_lane(s, SPH_HEAT),
                         *restrict signal = kith_scratch_lane(s, SPH_SIGNAL);
  const struct sph_record *self = &record[i];
  double fastest = 0, rate = 0;
#pragma omp simd reduction(max : fastest)
  for (size_t k = 0; k < n; ++k) fastest = fmax(fastest, signal[k]);
  for (int a = 0; a < NDIM; ++a) {
    double sum = 0, xi = self->x[a], vi = self->v[a];
#pragma omp simd reduction(+ : sum, rate)
    for (size_t k = 0; k < n; ++k) {
      const struct sph_record *j = &record[row[k]];
      const double x = xi - j->x[a];
      sum += force[k] * x;
      rate += heat[k] * x * (j->v[a] - vi);
    }
    package->hydro->acceleration->f64[(size_t)i * NDIM + a] = sum / self->mass;
  }
  pass->sph->signal->f64[i] = fmax(fastest, self->sound_speed);
  if (!package->compatible) package->hydro->energy_rate->f64[i] = rate / self->mass;
}

/* Sums of one row: rate and slope of the compatible energy. */
static inline void sum_work(const struct sph_pass *pass, kith_index i, struct kith_scratch *s) {
  const struct kith_package *package = pass->package;
  const struct kith_rows *rows = &pass->connectivity->rows;
  const size_t n = rows->first[i + 1] - rows->first[i];
  const kith_index *restrict row = rows->node + rows->first[i];
  const struct sph_record *restrict record = pass->sph->record;
  const double *restrict v = package->velocity_base->f64, *restrict acc = package->hydro->acceleration->f64;
  const double *restrict heat = kith_scratch_lane(s, SPH_HEAT);
  double rate = 0, slope = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double xi = record[i].x[a], vi = v[(size_t)i * NDIM + a], ai = acc[(size_t)i * NDIM + a];
#pragma omp simd reduction(+ : rate, slope)
    for (size_t k = 0; k < n; ++k) {
      const double hx = heat[k] * (xi - record[row[k]].x[a]);
      rate += hx * (v[(size_t)row[k] * NDIM + a] - vi);
      slope += hx * (acc[(size_t)row[k] * NDIM + a] - ai);
    }
  }
  package->hydro->energy_rate->f64[i] = rate / record[i].mass;
  package->energy_slope->f64[i] = slope / record[i].mass;
}

__attribute__((always_inline)) static inline void nodes_chunk(enum kith_kernel kernel, bool limited,
                                                              const struct sph_pass *pass, kith_index begin,
                                                              kith_index end, struct kith_scratch *s) {
  const struct kith_rows *rows = &pass->connectivity->rows;
  for (kith_index i = begin; i < end; ++i) {
    if (pass->package->traversal == KITH_TRAVERSE_PAIRS) {
      load_row(pass, i, s);
    } else {
      const size_t n = rows->first[i + 1] - rows->first[i];
      evaluate_row(kernel, limited, pass, i, rows->node + rows->first[i], 1, n, s);
      s->count[0] += n;
    }
    if (pass->work) sum_work(pass, i, s);
    else sum_force(pass, i, s);
  }
}

#define X(name, ...)                                                                                          \
  KITH_HOT static void pairs_##name(void *context, kith_index begin, kith_index end, struct kith_scratch *s) { \
    const struct sph_pass *pass = context;                                                                    \
    if (pass->sph->gradient != NULL) pairs_chunk(KITH_KERNEL_##name, true, pass, begin, end, s);              \
    else pairs_chunk(KITH_KERNEL_##name, false, pass, begin, end, s);                                         \
  }                                                                                                           \
  KITH_HOT static void nodes_##name(void *context, kith_index begin, kith_index end, struct kith_scratch *s) { \
    const struct sph_pass *pass = context;                                                                    \
    if (pass->sph->gradient != NULL) nodes_chunk(KITH_KERNEL_##name, true, pass, begin, end, s);              \
    else nodes_chunk(KITH_KERNEL_##name, false, pass, begin, end, s);                                         \
  }
KITH_KERNEL_LIST(X)
#undef X

/* Runs one of the passes above under the name of a stage. */
static kith_status run(struct sph_pass *pass, const kith_chunk_pass *chunk, const char *stage) {
  struct kith_package *package = pass->package;
  uint64_t count[4];
  kith_profile_begin(package->profile, stage);
  const kith_status status = kith_traverse(package->hydro->nodes->n_internal, chunk[package->kernel], pass, LANES,
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
  if (pass->sph->record_capacity < (size_t)n) {
    KITH_TRY(kith_resize(&pass->sph->record, 0, (size_t)nodes->capacity, sizeof *sph->record));
    pass->sph->record_capacity = (size_t)nodes->capacity;
  }
  kith_profile_begin(pass->package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < n; ++i) {
    struct sph_record *record = &sph->record[i];
    const size_t at = (size_t)i * NDIM;
    for (int a = 0; a < NDIM; ++a) record->x[a] = nodes->position->f64[at + a], record->v[a] = hydro->velocity->f64[at + a];
    record->inverse_support = 1 / nodes->support->f64[i];
    record->mass = hydro->mass->f64[i];
    record->density = hydro->density->f64[i];
    record->sound_speed = hydro->sound_speed->f64[i];
    record->psi = record->mass * hydro->pressure->f64[i] / (record->density * record->density);
    record->excess = sph->omega->f64[i];
    for (int a = 0, k = 0; sph->gradient != NULL && a < NDIM; ++a)
      for (int b = a; b < NDIM; ++b)
        record->shear[k++] = 0.5 * (sph->gradient->f64[at * NDIM + a * NDIM + b] + sph->gradient->f64[at * NDIM + b * NDIM + a]);
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
