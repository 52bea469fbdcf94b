/* Package `magma2`: SPH with gradients by matrix inversion and Roe-type dissipation of what a linear
 * reconstruction leaves of the differences, of the family of MAGMA2 (Rosswog 2020, MNRAS 498, 4230; 2025,
 * arXiv 2411.19228).
 *
 * Supports and volumes V by number density, rho_i = m_i / V_i: exact where masses jump on an even lattice.
 * With d = x_j - x_i, and the weights w_ij and the moments M_i of slope.h,
 *     N_i = V_i w_ij M_i^-1 d,  sum_j N_i . (v_j - v_i) = V_i div v, exactly for linear v             (1)
 *     m_i dv_i/dt = - sum_j (P_i N_i + P_j N_j + (1/2) Q_ij a_ij d)                                   (2)
 *     m_i du_i/dt = - sum_j (P_i N_i + (1/4) Q_ij a_ij d) . (v_j - v_i) + sum_j K_ij                  (3)
 * Were M_i isotropic, P_i N_i would be the term with Omega of the Lagrangian (sph.c). MAGMA2 has the weights
 * W(r / H_i) in M_i and N_i. N is not along d, but sum_j d N_i = V_i 1 has no torque: with Q along d, angular
 * momentum is kept, too. Where M is close to singular, an isotropic one takes its place.
 *     Q_ij = 2 rho_i rho_j / (rho_i + rho_j) q_ij,
 *     q_ij = -s alpha c_mean mu + beta mu^2, less in shear: see viscosity.h                           (4)
 *     K_ij = a_K (P_i + P_j) / 2 a_ij r {P_j - P_i} / (rho_i c_i + rho_j c_j)                         (5)
 *     a_ij = d . (N_i + N_j) / r^2
 * with {} of kith_pressure_heat. With alpha = 1, Q / 2 is what Roe's solver adds to the mean pressure; with
 * a_K = 1, K is the work at the face that this solver moves. The term of beta is for strong shocks. MAGMA2's
 * viscosity switch by entropy is not taken over: all pairs have alpha, and Balsara's factor.
 * Negative pressures are multiplied by t of tension.h. With t along d alone angular momentum would be kept to
 * round-off, as it is in gas, but turning water was torn sooner (spinning-square.yaml).
 *
 * With the weights w(r / H_i) errors were larger: by half in Toro's problem 3, a third in Sod's tube and
 * two blasts, a sixth in Sedov's blast in 1-D, a tenth in 3-D. With the mean pressure of the pair times
 * N_i + N_j in (2), Toro 3 stops with a negative energy if (3) has the work of this force; if it has that
 * of P_i, sheared shocks and expansions lose 15 and 46 %, and angular momentum is not kept. Dissipation of
 * pressure evens out contacts and noise, but errors in strong shocks grow:
 *                                                    a_K =   0    0.3     1
 *     error of the pressure at the contact of Sod's tube,
 *         400 nodes of equal spacing                       .66    .14   .085
 *         200 nodes of equal masses                       .068   .038   .027
 *     Sedov 72^2, L1 of the velocity                      .111   .098   .088
 *     noisy-box.yaml, velocity_over_sound                 .029   .020   .023
 *     two blasts, L1 of the density                       .020   .024   .029
 *     Toro 3, L1 of the density                           .016   .020   .022
 * MAGMA2's conduction of u by (|P_i - P_j| / rho)^(1/2), measured with w(r / H_i), did as much for contacts
 * of equal masses, nothing for those of equal spacing, and had larger errors in two blasts.
 *
 * Passes: density -> equation of state, Balsara's factor -> ghosts -> slopes -> ghosts -> packing -> force
 * [pairs]. */
#include "physics/passes/density.h"
#include "physics/passes/slope.h"
#include "physics/passes/viscosity.h"

struct magma2_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
  double pressure_dissipation;
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct magma2_settings, KITH_VISCOSITY_STEADY_LIST, "1"), {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)},
    {"pressure_dissipation", KITH_PARAM_NUMBER, "1", "[0, inf)",
     "heat that evens out what reconstruction leaves of pressure differences; 1: that of Roe's solver",
     KITH_INTO(struct magma2_settings, pressure_dissipation)},
    {0}};

/* The fields of a packed particle. */
enum {
  MAGMA2_PRESSURE = KITH_PACKED_VISCOUS,
  MAGMA2_SWITCH, /* Balsara's factor */
  MAGMA2_MATRIX, /* V M^-1, upper triangle */
  MAGMA2_SLOPE = MAGMA2_MATRIX + KITH_SYMMETRIC_SIZE,
  MAGMA2_PACKED = MAGMA2_SLOPE + NDIM
};

struct magma2 {
  struct kith_field *matrix; /* V M^-1 */
  struct kith_field *slope;  /* dP/dx; NULL without dissipation of pressures */
  struct kith_viscosity_fields viscosity;
};

/* What all pairs share. */
struct magma2_constants {
  struct kith_viscosity_constants viscosity;
  double dissipation;
};

/* Evaluates a pair: (1) - (5). */
KITH_INLINE void pair_magma2(enum kith_kernel kernel, const void *constants, const double *restrict i,
                             const double *restrict j, double *restrict out) {
  const struct magma2_constants *c = constants;
  const struct kith_viscous_pair p = kith_viscous_pair(&c->viscosity, i, j);
  double d[NDIM], ni[NDIM], nj[NDIM], along_i = 0, along_j = 0;
  const double hi = i[KITH_PACKED_INVERSE], hj = J(KITH_PACKED_INVERSE), inverse = 2 * hi * hj / (hi + hj),
               w = kith_pair_weight(kernel, p.r, inverse);
  for (int a = 0; a < NDIM; ++a) d[a] = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
  kith_symmetric_times(w, i + MAGMA2_MATRIX, 1, d, ni); /* w V M^-1 d of (1) */
  kith_symmetric_times(w, &J(MAGMA2_MATRIX), KITH_STRIDE, d, nj);
  for (int a = 0; a < NDIM; ++a) along_i += d[a] * ni[a], along_j += d[a] * nj[a];
  const double area = (along_i + along_j) * p.inverse_r * p.inverse_r;
  const double pi = kith_tension(p.closer, i[MAGMA2_PRESSURE]),
               pj = kith_tension(p.closer, J(MAGMA2_PRESSURE)),
               q = kith_viscous_pressure(&c->viscosity, &p, i[KITH_PACKED_DENSITY], J(KITH_PACKED_DENSITY),
                                         0.5 * (i[MAGMA2_SWITCH] + J(MAGMA2_SWITCH)));
  const double evened = c->dissipation * kith_pressure_heat(i, j, MAGMA2_PRESSURE, MAGMA2_SLOPE, area * p.r);
  double heat_i = evened, heat_j = -evened;
  for (int a = 0; a < NDIM; ++a) { /* (2), (3) */
    const double v = J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a], fi = -pi * ni[a], fj = -pj * nj[a],
                 fq = -0.5 * q * area * d[a];
    OUT(KITH_FORCE + a) = fi + fj + fq;
    heat_i += (fi + 0.5 * fq) * v, heat_j += (fj + 0.5 * fq) * v;
  }
  OUT(KITH_HEAT) = heat_i;
  OUT(KITH_PARTNER_HEAT) = heat_j;
  OUT(KITH_SIGNAL) = p.r * inverse < KITH_SIGNAL_EDGE ? p.signal : 0;
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct magma2 *m = package->self;
  kith_viscosity_pack(hydro, &m->viscosity, i, packed);
  packed[MAGMA2_PRESSURE] = hydro->pressure->f64[i];
  packed[MAGMA2_SWITCH] = kith_viscosity_factor(&m->viscosity, i);
  for (int k = 0; k < KITH_SYMMETRIC_SIZE; ++k)
    packed[MAGMA2_MATRIX + k] = m->matrix->f64[(size_t)i * KITH_SYMMETRIC_SIZE + k];
  for (int a = 0; a < NDIM; ++a)
    packed[MAGMA2_SLOPE + a] = m->slope != NULL ? m->slope->f64[(size_t)i * NDIM + a] : 0;
}

static void copy_corrections(const double *restrict i, double *restrict j) {
  const double h = i[KITH_PACKED_INVERSE] / J(KITH_PACKED_INVERSE), scale = kith_pow_dim(h);
  for (int k = MAGMA2_MATRIX; k < MAGMA2_SLOPE; ++k) J(k) = i[k] * scale;
}

KITH_FORCE_FORM(pair_magma2, MAGMA2_PACKED, pack, copy_corrections)

static kith_status magma2_create(struct kith_package *package) {
  struct magma2 *m = package->self;
  const struct magma2_settings *settings = package->settings;
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(SYMMETRIC, WORK, "matrix", "V M^-1"), &m->matrix},
      {settings->pressure_dissipation > 0, KITH_SPEC(VECTOR, WORK, "pressure_slope", "dP/dx"), &m->slope},
      {0}};
  KITH_TRY(kith_viscosity_create(package, &settings->viscosity, &m->viscosity));
  return kith_nodes_fields(package->hydro->nodes, fields);
}

static kith_status magma2_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                   const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct magma2 *m = package->self;
  const struct magma2_settings *settings = package->settings;
  const struct kith_density_wanted wanted = {.curl = m->viscosity.curl, .shear = m->viscosity.shear};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_hydro_evaluate_eos(hydro);
  struct kith_field *const state[] = {hydro->nodes->support, hydro->density, hydro->pressure,
                                      hydro->sound_speed};
  kith_package_start_refresh(package, 4, state);
  KITH_TRY(kith_slope(package, connectivity, hydro->pressure, m->matrix, m->slope));
  struct kith_field *between[4] = {m->matrix};
  int n = kith_viscosity_exchanged(&m->viscosity, 1, between);
  if (m->slope != NULL) between[n++] = m->slope;
  kith_balsara_factors(package, &settings->viscosity, &m->viscosity, 0, hydro->nodes->n_internal);
  const struct magma2_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .dissipation = settings->pressure_dissipation};
  return kith_force(
      package, connectivity, kick,
      &(struct kith_force_pass){
          .form = &pair_magma2_form, .constants = &constants, .exchanged = between, .n_exchanged = n});
}

const struct kith_package_ops kith_package_magma2 = {
    .name = "magma2",
    .doc = "SPH with gradients by matrix inversion and Roe-type dissipation of reconstructed differences",
    .self_size = sizeof(struct magma2),
    .create = magma2_create,
    .evaluate = magma2_evaluate,
    .spacings = NDIM == 2 ? 1.33 : 0, /* 20 neighbors, as crk */
    .cfl = NDIM == 3 ? 0.4 : 0.3,     /* as sph */
    KITH_SETTINGS(params, magma2_settings),
};
