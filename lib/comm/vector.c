/* Vectors of SUNDIALS over a few arrays: operations on elements, exact sums. */
#include "lib/comm/vector.h"

#include <math.h>
#include <string.h>
#include "lib/comm/sum.h"

struct content {
  struct kith_vectors *set;
  double *own[KITH_VECTOR_MAX_PARTS]; /* NULL: the caller's */
};

static struct kith_vectors *set_of(N_Vector v) {
  return ((const struct content *)v->content)->set;
}

double *kith_vector_numbers(N_Vector v, int part) {
  const struct content *c = v->content;
  return c->own[part] != NULL ? c->own[part] : *c->set->part[part].numbers;
}

static void destroy(N_Vector v) {
  struct content *c = v->content;
  if (v == c->set->spare) return;
  if (c->own[0] != NULL) c->set->bytes -= (size_t)c->set->own * sizeof(double);
  for (int part = 0; part < c->set->parts; ++part) kith_free(&c->own[part]);
  kith_free(&v->content);
  N_VFreeEmpty(v);
}

static const struct _generic_N_Vector_Ops operations;

/* A vector without numbers of its own. */
static N_Vector make(struct kith_vectors *set) {
  N_Vector v = N_VNewEmpty(set->context);
  if (v == NULL) return NULL;
  if (kith_resize(&v->content, 0, 1, sizeof(struct content)) != KITH_OK) {
    N_VFreeEmpty(v);
    return NULL;
  }
  ((struct content *)v->content)->set = set;
  *v->ops = operations;
  return v;
}

/* A vector with numbers of its own; NULL without memory. */
static N_Vector new_vector(N_Vector of) {
  N_Vector v = make(set_of(of));
  if (v == NULL) return NULL;
  struct content *c = v->content;
  kith_status status = KITH_OK;
  /* One number more: an empty set has vectors too. */
  for (int part = 0; status == KITH_OK && part < c->set->parts; ++part)
    status = kith_resize(&c->own[part], 0, (size_t)c->set->part[part].length + 1, sizeof(double));
  if (c->own[0] != NULL) c->set->bytes += (size_t)c->set->own * sizeof(double);
  if (status == KITH_OK) return v;
  destroy(v);
  return NULL;
}

static N_Vector clone(N_Vector of) {
  struct kith_vectors *set = set_of(of);
  const N_Vector v = new_vector(of);
  set->lacking |= v == NULL;
  return v != NULL ? v : set->spare;
}

static N_Vector_ID identity(N_Vector v) {
  (void)v;
  return SUNDIALS_NVEC_CUSTOM;
}

static sunindextype count(N_Vector v) {
  return (sunindextype)set_of(v)->length; /* int, where SUNDIALS was built so */
}

/* Defines name(parameters): z[k] = expression in k and, as declared, x[k] and y[k], for all k; all may be the
 * same vector. */
#define ELEMENTS(name, parameters, declare, expression)                                                    \
  static void name parameters {                                                                            \
    for (int part = 0; part < set_of(zv)->parts; ++part) {                                                 \
      double *z = kith_vector_numbers(zv, part);                                                           \
      const int64_t n = set_of(zv)->part[part].length;                                                     \
      declare;                                                                                             \
      _Pragma("omp parallel for simd schedule(static)") for (int64_t k = 0; k < n; ++k) z[k] = expression; \
    }                                                                                                      \
  }
#define X_ONLY const double *x = kith_vector_numbers(xv, part)
#define X_AND_Y const double *x = kith_vector_numbers(xv, part), *y = kith_vector_numbers(yv, part)

ELEMENTS(linear_sum, (double a, N_Vector xv, double b, N_Vector yv, N_Vector zv), X_AND_Y, a *x[k] + b * y[k])
ELEMENTS(constant, (double c, N_Vector zv), (void)0, c)
ELEMENTS(product, (N_Vector xv, N_Vector yv, N_Vector zv), X_AND_Y, x[k] * y[k])
ELEMENTS(quotient, (N_Vector xv, N_Vector yv, N_Vector zv), X_AND_Y, x[k] / y[k])
ELEMENTS(scaled, (double c, N_Vector xv, N_Vector zv), X_ONLY, c *x[k])
ELEMENTS(magnitude, (N_Vector xv, N_Vector zv), X_ONLY, fabs(x[k]))
ELEMENTS(inverse, (N_Vector xv, N_Vector zv), X_ONLY, 1 / x[k])
ELEMENTS(shifted, (N_Vector xv, double b, N_Vector zv), X_ONLY, x[k] + b)

/* z = sum of c_j x_j, in the order of j; z may be x_0. */
static int combination(int n_vectors, double *c, N_Vector *xv, N_Vector zv) {
  enum { RUN = 512 };
  for (int part = 0; part < set_of(zv)->parts; ++part) {
    double *z = kith_vector_numbers(zv, part);
    const int64_t n = set_of(zv)->part[part].length, runs = (n + RUN - 1) / RUN;
#pragma omp parallel for schedule(static)
    for (int64_t r = 0; r < runs; ++r) {
      const int64_t begin = r * RUN;
      const int here = (int)KITH_MIN(n - begin, RUN);
      double sum[RUN] = {0};
      for (int j = 0; j < n_vectors; ++j) {
        const double *x = kith_vector_numbers(xv[j], part) + begin;
        for (int k = 0; k < here; ++k) sum[k] += c[j] * x[k];
      }
      memcpy(z + begin, sum, (size_t)here * sizeof *sum);
    }
  }
  return 0;
}

enum { FEW = 4096 }; /* numbers: for fewer, waking threads costs more than they save */

/* sum of x y, (x y)^2 or |x| over all numbers. */
enum sum { PRODUCTS, SQUARES, MAGNITUDES };
static void sum_part(enum sum what, const double *x, const double *y, int64_t n, struct kith_sum *total) {
#pragma omp parallel if (n > FEW)
  {
    struct kith_sum mine = {0};
#pragma omp for schedule(static) nowait
    for (int64_t k = 0; k < n; ++k) {
      const double term = what == MAGNITUDES ? fabs(x[k]) : x[k] * y[k];
      kith_sum_add(&mine, what == SQUARES ? term * term : term);
    }
#pragma omp critical(kith_vector_sum)
    kith_sum_join(total, &mine);
  }
}

static double sum(enum sum what, N_Vector xv, N_Vector yv) {
  struct kith_sum total = {0};
  for (int part = 0; part < set_of(xv)->parts; ++part)
    sum_part(what, kith_vector_numbers(xv, part), kith_vector_numbers(yv, part),
             set_of(xv)->part[part].length, &total);
  kith_sum_ranks(set_of(xv)->ranks, &total, 1);
  return kith_sum_value(&total);
}

static double dot(N_Vector x, N_Vector y) {
  return sum(PRODUCTS, x, y);
}
static double l1_norm(N_Vector x) {
  return sum(MAGNITUDES, x, x);
}
static double weighted_norm(N_Vector x, N_Vector w) {
  return sqrt(sum(SQUARES, x, w));
}
static double mean_norm(N_Vector x, N_Vector w) {
  return sqrt(sum(SQUARES, x, w) / (double)KITH_MAX(set_of(x)->length, 1));
}

/* The largest |x|, or the largest -x, at least `most`; infinite if any x is not a number. */
static double extreme(N_Vector xv, bool negative, double most) {
  for (int part = 0; part < set_of(xv)->parts; ++part) {
    const double *x = kith_vector_numbers(xv, part);
    const int64_t n = set_of(xv)->part[part].length;
#pragma omp parallel for simd schedule(static) reduction(max : most)
    for (int64_t k = 0; k < n; ++k)
      most = KITH_MAX(most, x[k] != x[k] ? INFINITY : negative ? -x[k] : fabs(x[k]));
  }
  kith_ranks_max(set_of(xv)->ranks, &most, 1);
  return most;
}

static double largest(N_Vector x) {
  return extreme(x, false, 0);
}
static double least(N_Vector x) {
  return -extreme(x, true, -INFINITY);
}

static const struct _generic_N_Vector_Ops operations = {.nvgetvectorid = identity,
                                                        .nvclone = clone,
                                                        .nvdestroy = destroy,
                                                        .nvgetlength = count,
                                                        .nvlinearsum = linear_sum,
                                                        .nvconst = constant,
                                                        .nvprod = product,
                                                        .nvdiv = quotient,
                                                        .nvscale = scaled,
                                                        .nvabs = magnitude,
                                                        .nvinv = inverse,
                                                        .nvaddconst = shifted,
                                                        .nvdotprod = dot,
                                                        .nvmaxnorm = largest,
                                                        .nvwrmsnorm = mean_norm,
                                                        .nvmin = least,
                                                        .nvwl2norm = weighted_norm,
                                                        .nvl1norm = l1_norm,
                                                        .nvlinearcombination = combination};

bool kith_sundials_create(SUNContext *context) {
#if SUNDIALS_VERSION_MAJOR >= 7
  return SUNContext_Create(SUN_COMM_NULL, context) == 0 && SUNContext_ClearErrHandlers(*context) == 0;
#else
  return SUNContext_Create(NULL, context) == 0;
#endif
}

void kith_sundials_quiet(int code, const char *module, const char *function, char *message, void *data) {
  (void)code, (void)module, (void)function, (void)message, (void)data;
}

kith_status kith_vectors_create(struct kith_vectors **out, struct kith_ranks *ranks, int n_parts,
                                const struct kith_vector_part *part) {
  struct kith_vectors *set = NULL;
  uint64_t all = 0;
  *out = NULL;
  for (int p = 0; p < n_parts; ++p) all += (uint64_t)part[p].length;
  kith_status status = kith_resize(&set, 0, 1, sizeof *set);
  if (status == KITH_OK) {
    *set = (struct kith_vectors){.ranks = ranks, .parts = n_parts, .own = (int64_t)all};
    memcpy(set->part, part, (size_t)n_parts * sizeof *part);
    if (kith_sundials_create(&set->context)) set->view = make(set), set->spare = make(set);
    if (set->view == NULL || set->spare == NULL) status = kith_fail(KITH_NO_MEMORY, "no vectors of SUNDIALS");
  }
  status = kith_ranks_allreduce_status(ranks, status);
  if (status != KITH_OK) {
    kith_vectors_destroy(&set);
    return status;
  }
  kith_ranks_sum_counts(ranks, &all, 1);
  set->length = (int64_t)all;
  *out = set;
  return KITH_OK;
}

void kith_vectors_destroy(struct kith_vectors **vectors) {
  if (*vectors == NULL) return;
  const N_Vector own[] = {(*vectors)->view, (*vectors)->spare};
  (*vectors)->spare = NULL;
  for (int k = 0; k < 2; ++k)
    if (own[k] != NULL) destroy(own[k]);
  if ((*vectors)->context != NULL) SUNContext_Free(&(*vectors)->context);
  kith_free(vectors);
}

N_Vector kith_vector_clone(const struct kith_vectors *vectors) {
  return new_vector(vectors->view);
}
