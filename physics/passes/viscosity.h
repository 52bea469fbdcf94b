/* viscosity.h - artificial viscosity: its parameters, and what pair functions that use it begin with, the
 * geometry of a pair and the limited velocity difference.
 *
 *     mu_ij = min(0, D_ij) / |x_ij|,  D_ij = v_ij . x_ij
 * which is 0 for pairs that separate. A limited viscosity sees the difference that is left between the
 * velocities after both have been extrapolated to the middle of the pair:
 *     D_ij = max(v_ij . x_ij - phi (x_ij.G_i.x_ij + x_ij.G_j.x_ij) / 2, v_ij . x_ij)
 * where G is the linear-exact velocity gradient, and phi is the product of three factors (the first two are
 * those of Frontiere, Raskin and Owen 2017, JCoPh 332, 160, eqs. 48-50):
 *   - van Leer's limiter 4 r / (1 + r)^2 of the ratio r of both slopes;
 *   - max(0, 1 - (5 (s - 1))^2) for pairs at a distance of s < 1 mean node spacings of the denser end; they
 *     have exp(-(5 (s - 1))^2);
 *   - 1 / (1 + max(5 J_c^2, 4 min(|J_rho|, |J_rho + 2 J_c|)^3 min(1, M^2))), J_c = (c_i - c_j) / (c_i + c_j),
 *     J_rho the same of the density, M = |v_ij . x_ij| / (|x_ij| c_mean), which is ours. J_rho + 2 J_c is, to
 *     first order, the jump of the modulus rho c^2. In a shock the sound speed jumps, or, if gamma is near 1,
 *     density and modulus do, which at a contact do not jump together. So a pair has nearly the viscosity
 *     without a limiter, and there is no noise behind the shock; smooth flow and vortices keep the limiter. M
 *     leaves light nodes alone that swing beside heavy ones, where sums of masses have jumps of both.
 * Figures for these choices, and for that of w below: page on methods, Viscosity.
 *
 * The signal speed of a pair is max(1, (1 + 0.6 alpha) / 1.6) c_mean - beta mu; it grows with alpha beyond 1
 * as in Monaghan (1992, ARA&A 30, 543).
 *
 * The viscous pressure of a pair is q times a mean density, with
 *     q = -s alpha c_mean mu + beta mu (mu + (1 - w) min(-mu, 0.05 c_mean)),  w = min(1, 20 s)
 * where s is the mean of Balsara's factors of both nodes, or of switches, or of their products. In their
 * sources switches leave the quadratic term alone (w = 1; Cullen and Dehnen 2010, MNRAS 408, 669), and
 * Balsara's factor multiplies both (settings `balsara` and `squared`). Limiters leave a part of any flow
 * that changes over a few supports, and the quadratic term of it damps shear. So (ours, setting `slow`) only
 * w is left of the part of mu that is much slower than sound. In shear s is a few percent; in noise and
 * shocks it exceeds 1/20.
 * The functions have no loops over pairs: they vectorize in the loops of their callers. */
#ifndef KITH_PHYSICS_PASSES_VISCOSITY_H
#define KITH_PHYSICS_PASSES_VISCOSITY_H

#include <float.h>
#include "lib/core/choices.h"
#include "lib/core/symmetric.h"
#include "physics/passes/force.h"
#include "physics/passes/tension.h"

/* name, choice in a scene, doc. KITH_VISCOSITY_STEADY_LIST: forms without a switch, which need nothing else
 * of a package. */
#define KITH_VISCOSITY_STEADY_LIST(X)                      \
  X(NONE, none, "none: for flows without shocks")          \
  X(MONAGHAN, monaghan, "on every approaching pair alike") \
  X(LIMITED, limited,                                      \
    "on the velocity difference that limited gradients leave: little in smooth flow; the default")
#define KITH_VISCOSITY_LIST(X)    \
  KITH_VISCOSITY_STEADY_LIST(X)   \
  X(CULLEN_DEHNEN, cullen_dehnen, \
    "on every approaching pair, with a coefficient that rises ahead of a shock and decays behind it")
enum kith_viscosity {
#define X(name, word, doc) KITH_VISCOSITY_##name,
  KITH_VISCOSITY_LIST(X)
#undef X
};

/* Balsara's factor. SLOW: on the linear term, and on slow differences in the quadratic one; else on both, as
 * in its source. */
#define KITH_BALSARA_LIST(X) X(NONE, none) X(SLOW, slow) X(FACTOR, balsara) X(SQUARED, squared)
enum kith_balsara {
#define X(name, word) KITH_BALSARA_##name,
  KITH_BALSARA_LIST(X)
#undef X
};
#define KITH_BALSARA_CHOICE(name, word) "|" #word

/* What a scene sets; the settings of a package have it as their member `viscosity`. */
struct kith_viscosity_settings {
  enum kith_viscosity name;
  double alpha, beta;
  enum kith_balsara balsara;
};
#define KITH_VISCOSITY_PARAM(type, key, kind, value, range, doc) \
  { #key, KITH_PARAM_##kind, value, range, doc, KITH_INTO(type, viscosity.key), .needs = "name!=none" }
/* Rows of a parameter table for the settings `type`; list: the forms that it has, one of the lists above;
 * linear: the default of alpha. */
#define KITH_VISCOSITY_PARAMS(type, list, linear)                                                            \
  {"name",     KITH_PARAM_CHOICE,                                                                            \
   "limited",  list(KITH_AS_LISTED_CHOICE),                                                                  \
   "its form", KITH_INTO(type, viscosity.name)},                                                             \
      KITH_VISCOSITY_PARAM(type, balsara, CHOICE, "slow", KITH_BALSARA_LIST(KITH_BALSARA_CHOICE),            \
                           "Balsara's factor, for less viscosity in shear: on the linear term, and on slow " \
                           "differences in the quadratic one; on both terms; or its square on both"),        \
      KITH_VISCOSITY_PARAM(type, alpha, NUMBER, linear, "[0, inf)", "linear coefficient"),                   \
      KITH_VISCOSITY_PARAM(type, beta, NUMBER, "2", "[0, inf)", "quadratic coefficient")

/* What all pairs share. */
struct kith_viscosity_constants {
  double alpha, beta; /* 0 without viscosity */
  double signal;      /* the signal speed of a pair at rest, over its sound speed */
  double spacings;    /* H in mean node spacings */
  double limited;     /* 1: the velocity difference is limited */
  double slow, ramp;  /* of kith_viscous_term */
};
static inline struct kith_viscosity_constants kith_viscosity_constants(
    const struct kith_viscosity_settings *settings, double neighbors) {
  static const double slow[] = {
      [KITH_BALSARA_SLOW] = 0.05, [KITH_BALSARA_FACTOR] = DBL_MAX, [KITH_BALSARA_SQUARED] = DBL_MAX};
  const bool viscous = settings->name != KITH_VISCOSITY_NONE;
  const double alpha = viscous ? settings->alpha : 0;
  return (struct kith_viscosity_constants){.alpha = alpha,
                                           .beta = viscous ? settings->beta : 0,
                                           .signal = KITH_MAX((1 + 0.6 * alpha) / 1.6, 1.0),
                                           .spacings = kith_root_dim(neighbors / kith_ball()),
                                           .limited = settings->name == KITH_VISCOSITY_LIMITED,
                                           .slow = slow[settings->balsara],
                                           .ramp = settings->balsara == KITH_BALSARA_SLOW ? 20 : 1};
}

/* Do these settings have Balsara's factor? In 1-D there is no shear. */
static inline bool kith_viscosity_balsara(const struct kith_viscosity_settings *settings) {
  return NDIM > 1 && settings->name != KITH_VISCOSITY_NONE && settings->balsara != KITH_BALSARA_NONE;
}

/* The fields of the viscosity; NULL: these settings need none. */
struct kith_viscosity_fields {
  struct kith_field *shear;  /* of a limited viscosity: the symmetric part of dv_a/dx_b */
  struct kith_field *curl;   /* |curl v| */
  struct kith_field *factor; /* what multiplies the viscosity: Balsara's factor, a switch or both */
};
static inline kith_status kith_viscosity_create(const struct kith_package *package,
                                                const struct kith_viscosity_settings *settings,
                                                struct kith_viscosity_fields *fields) {
  const bool switched = settings->name == KITH_VISCOSITY_CULLEN_DEHNEN || kith_viscosity_balsara(settings);
  const enum kith_role role = package->recompute ? KITH_WORK : KITH_OWN_WORK;
  return kith_nodes_fields(
      package->hydro->nodes,
      (struct kith_field_row[]){
          {settings->name == KITH_VISCOSITY_LIMITED,
           KITH_SPEC(SYMMETRIC, WORK, "shear", "symmetric part of dv_a/dx_b"), &fields->shear},
          {switched, {"curl", KITH_SCALAR, KITH_F64, role, NULL, "|curl v|"}, &fields->curl},
          {switched, KITH_SPEC(SCALAR, WORK, "viscosity_factor", "what multiplies the viscosity"),
           &fields->factor},
          {0}});
}
/* Adds those that ghosts need to the n fields in `exchanged`; returns how many these are then. */
static inline int kith_viscosity_exchanged(const struct kith_viscosity_fields *fields, int n,
                                           struct kith_field **exchanged) {
  if (fields->shear != NULL) exchanged[n++] = fields->shear;
  if (fields->factor != NULL) exchanged[n++] = fields->factor;
  return n;
}
/* What multiplies the viscosity of node i. */
static inline double kith_viscosity_factor(const struct kith_viscosity_fields *fields, kith_index i) {
  return fields->factor != NULL ? fields->factor->f64[i] : 1;
}

/* The first fields of a packed particle. */
enum {
  KITH_PACKED_INVERSE = KITH_PACKED_OWN, /* 1 / H */
  KITH_PACKED_DENSITY,
  KITH_PACKED_SOUND,
  KITH_PACKED_SHEAR, /* symmetric part of the velocity gradient, upper triangle: x.G.x needs no more */
  KITH_PACKED_VISCOUS = KITH_PACKED_SHEAR + KITH_SYMMETRIC_SIZE
};
/* Packs them; without a shear it is 0. */
static inline void kith_viscosity_pack(const struct kith_hydro *hydro,
                                       const struct kith_viscosity_fields *fields, kith_index i,
                                       double *restrict packed) {
  const struct kith_field *shear = fields->shear;
  kith_force_pack(hydro, i, packed);
  packed[KITH_PACKED_INVERSE] = 1 / hydro->nodes->support->f64[i];
  packed[KITH_PACKED_DENSITY] = hydro->density->f64[i];
  packed[KITH_PACKED_SOUND] = hydro->sound_speed->f64[i];
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k)
    packed[KITH_PACKED_SHEAR + k] = shear != NULL ? shear->f64[(size_t)i * KITH_SYMMETRIC_SIZE + k] : 0;
}

/* Returns Balsara's factor (Balsara 1995, JCoPh 121, 357):
 *     (|div v| + e) / (|div v| + |curl v| + e)
 * e is in the numerator, too: what gradients do not see, zigzags and slow noise, keeps its viscosity. */
KITH_INLINE double kith_balsara(double divergence, double curl, double e) {
  const double sum = fabs(divergence) + curl + e;
  return sum > 0 ? (fabs(divergence) + e) / sum : 1;
}
/* Sets the factors of the active nodes among begin .. end - 1, if there are any, to Balsara's with
 * e = 1e-3 c / h, h = 2 sigma, or its square; to 1 without. */
static inline void kith_balsara_factors(const struct kith_package *package,
                                        const struct kith_viscosity_settings *settings,
                                        const struct kith_viscosity_fields *fields, kith_index begin,
                                        kith_index end) {
  const struct kith_nodes *nodes = package->hydro->nodes;
  const double *restrict support = nodes->support->f64, *restrict c = package->hydro->sound_speed->f64,
                         *restrict divergence = package->velocity_divergence->f64;
  const double widths = kith_kernel_support(package->kernel); /* of h in a support */
  const bool some = kith_viscosity_balsara(settings), squared = settings->balsara == KITH_BALSARA_SQUARED;
  if (fields->factor == NULL) return;
#pragma omp parallel for schedule(static)
  for (kith_index from = begin; from < end; from += KITH_STRETCH) {
    const kith_index stop = kith_stretch_end(nodes, from, end);
    for (kith_index i = from; i < stop; ++i) {
      if (!kith_node_active(nodes, i)) continue;
      const double e = 1e-3 * c[i] / (support[i] / widths),
                   factor = some ? kith_balsara(divergence[i], fields->curl->f64[i], e) : 1;
      fields->factor->f64[i] = squared ? factor * factor : factor;
    }
  }
}

struct kith_viscous_pair {
  double x, y, z;                      /* x_ij; y, z: anything in fewer dimensions */
  double r, vx, qi, qj;                /* |x_ij|, v_ij . x_ij, r / H of both */
  double mu, sound;                    /* mean sound speed */
  double signal;                       /* signal speed; 0 for two nodes at the same place */
  double inverse_r, inverse_densities; /* 1 / r, or a large number; 1 / (rho_i + rho_j) */
  double closer;                       /* min(0, s - 1) */
};

KITH_INLINE struct kith_viscous_pair kith_viscous_pair(const struct kith_viscosity_constants *c,
                                                       const double *restrict i, const double *restrict j) {
  enum { X = KITH_PACKED_X, Y = X + (NDIM > 1 ? 1 : 0), Z = X + (NDIM > 2 ? 2 : 0) };
  struct kith_viscous_pair p = {.x = i[X] - J(X), .y = i[Y] - J(Y), .z = i[Z] - J(Z)};
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a);
    r2 += d * d;
    p.vx += d * (i[KITH_PACKED_V + a] - J(KITH_PACKED_V + a));
  }
  p.r = sqrt(r2);
  p.qi = p.r * i[KITH_PACKED_INVERSE], p.qj = p.r * J(KITH_PACKED_INVERSE);

  const double slope_i = kith_symmetric_form(i + KITH_PACKED_SHEAR, 1, p.x, p.y, p.z),
               slope_j = kith_symmetric_form(&J(KITH_PACKED_SHEAR), KITH_STRIDE, p.x, p.y, p.z);
  const double product = slope_i * slope_j, sum = slope_i + slope_j;
  const double ci = i[KITH_PACKED_SOUND], cj = J(KITH_PACKED_SOUND), sounds = ci + cj,
               di = i[KITH_PACKED_DENSITY], dj = J(KITH_PACKED_DENSITY), densities = di + dj,
               fast = KITH_MAX(sounds, 1e-100), inverse = 1 / (densities * fast),
               inverse_sounds = inverse * densities;
  p.inverse_r = 1 / KITH_MAX(p.r, 1e-100), p.inverse_densities = inverse * fast;
  /* Over r^2, so that the division of van Leer's limiter need not wait for 1 / r. */
  const double heated = (ci - cj) * inverse_sounds, denser = (di - dj) * p.inverse_densities,
               pressed = KITH_MIN(fabs(denser), fabs(denser + 2 * heated)), speed = p.vx * inverse_sounds,
               front = KITH_MAX(5 * heated * heated * r2,
                                pressed * pressed * pressed * KITH_MIN(4 * r2, 16 * speed * speed));
  const double van_leer = product > 0 ? 4 * product * r2 / KITH_MAX(sum * sum * (r2 + front), DBL_MIN) : 0;
  p.closer = kith_closer(c->spacings, KITH_MAX(p.qi, p.qj));
  const double near = 5 * p.closer, phi = van_leer * KITH_MAX(1 - near * near, 0.0);
  const double limited = KITH_MAX(p.vx - 0.5 * phi * sum, p.vx);
  const double difference = c->limited > 0 ? limited : p.vx;
  p.mu = p.vx < 0 ? KITH_MIN(difference, 0.0) * p.inverse_r : 0;

  p.sound = 0.5 * sounds;
  p.signal = r2 > 0 ? c->signal * p.sound - c->beta * p.mu : 0;
  return p;
}

/* Returns q of a pair; s: mean of what multiplies the viscosity of both nodes. */
KITH_INLINE double kith_viscous_term(const struct kith_viscosity_constants *c,
                                     const struct kith_viscous_pair *p, double s) {
  const double less = (1 - KITH_MIN(1.0, c->ramp * s)) * KITH_MIN(-p->mu, c->slow * p->sound);
  return (c->beta * (p->mu + less) - c->alpha * s * p->sound) * p->mu;
}
/* Returns Q = 2 rho_i rho_j / (rho_i + rho_j) q, a pressure. */
KITH_INLINE double kith_viscous_pressure(const struct kith_viscosity_constants *c,
                                         const struct kith_viscous_pair *p, double density_i,
                                         double density_j, double s) {
  return 2 * density_i * density_j * p->inverse_densities * kith_viscous_term(c, p, s);
}

/* Returns the heat from j to i by which pressures even out at a face of this area, for packed particles
 * with the pressure and its slope (slope.h) at these fields. Between the states at the middle of a pair
 * Roe's solver moves the face with - {P_j - P_i} / (rho_i c_i + rho_j c_j); the work of the mean pressure at
 * it is this heat. {} is what van Leer's limiter leaves of the difference, between 0 and all of it. */
KITH_INLINE double kith_pressure_heat(const double *restrict i, const double *restrict j, int pressure,
                                      int slope, double area) {
  const double pi = i[pressure], pj = J(pressure),
               impedances = i[KITH_PACKED_DENSITY] * i[KITH_PACKED_SOUND] +
                            J(KITH_PACKED_DENSITY) * J(KITH_PACKED_SOUND);
  double si = 0, sj = 0;
  for (int a = 0; a < NDIM; ++a) {
    const double d = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
    si += i[slope + a] * d, sj += J(slope + a) * d;
  }
  const double product = si * sj, sum = si + sj, van_leer = product > 0 ? 4 * product / (sum * sum) : 0,
               jump = pj - pi, left = jump - 0.5 * van_leer * sum,
               difference = KITH_MAX(KITH_MIN(left, KITH_MAX(jump, 0.0)), KITH_MIN(jump, 0.0));
  return 0.5 * KITH_MAX(pi + pj, 0.0) * area * difference / KITH_MAX(impedances, 1e-300);
}

#endif
