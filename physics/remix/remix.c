/* Package `remix`: densities that follow the flow, and reproducing kernels, after REMIX (Sandnes et al. 2025,
 * arXiv 2407.18587).
 *
 * A sum over neighbors smears the density where the spacing of nodes jumps. Here each node has a volume V of
 * its own that follows the flow. It starts as m / rho of the scene, or else as that of the sum. From one
 * evaluation to the next, a time dt later, with div v of density.h,
 *     V *= exp(dt (div v_before + div v) / 2) (V_even / V)^(1 - exp(-a_V s dt c_signal / h))          (1)
 *     V_even = ball H^d / neighbors, h = 2 sigma, s = 1 / (1 + (change / 0.2)^4 + (surface / 0.05)^4)
 *     surface = max(0, 1 - m0) max(0, 1 - 4 P / (rho c^2))
 * The last factor draws V to the sum, with a_V = 1 in a sound crossing, where the spacing does not change
 * from node to node (change, m0: moments.h). REMIX draws it by m0 - 1, which is not 0 beside a contact.
 * Neither is it drawn at the free surface of water or copper, where m0 is 0.5 to 0.75 and V_even up to a
 * third too large: that much tension tears nodes off (inputs/spinning-square.yaml). Gas, whose pressure falls
 * no faster than its density, has surface = 0.
 * V stays between V_even / 8 and 8 V_even: no jump of the spacing explains more. Where light gas met heavy
 * gas at speed it grew to 6000 V_even, and the faces of such nodes took more heat from them than they had.
 * With V, the corrected kernels W^R of moments.h and D = grad W^R_ij - grad W^R_ji,
 *     m_i dv_i/dt = - sum_j (1/2) V_i V_j (P_i + P_j + Q_ij) D                                        (2)
 *     m_i du_i/dt = - sum_j (1/2) V_i V_j (P_i + e Q_ij) D . (v_j - v_i) + sum_j K_ij                 (3)
 * which is the work of each node on its own volume. Negative pressures are multiplied by t of tension.h. e is
 * 1/2, but P_i / (P_i + P_j) where Q cools a pair, as it may because D does not point along it: a node that
 * has no pressure has no heat to give. Q is (4) of magma2.c. K is (5) of magma2.c with the area
 * 2 V_i V_j |grad W|, instead of REMIX's diffusion of u and rho.
 *
 * Largest error of the pressure at contacts in 1-D:
 *                              equal masses 8 : 1,    equal masses,       equal spacing,
 *                              at rest, 100 nodes     Sod, 200 nodes      Sod, 400 nodes
 *     sph                             .64                 .092                 .59
 *     crk                             .61                 .041                 .55
 *     mfm                             .27                 .030                 .10
 *     magma2                          .24                 .027                 .085
 *     remix                           .049                .051                 .072
 *     remix without K                 .41                 .048                 .80
 *     remix with a_V = 0              .081                .20                  .072
 * With V drawn by m0 - 1 (a_V = 0.1) these errors were .117, .097 and .172. Strong shocks are less accurate:
 * in Toro's problem 3 L1 of the density is .026 (sph: .020).
 *
 * Passes: density -> volumes, equation of state -> ghosts -> moments -> ghosts -> packing -> force
 * [pairs]. */
#include <math.h>
#include "physics/crk/moments.h"

struct remix_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
  double pressure_dissipation, relaxation;
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct remix_settings, KITH_VISCOSITY_STEADY_LIST, "1"), {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)},
    {"pressure_dissipation", KITH_PARAM_NUMBER, "1", "[0, inf)",
     "heat that evens out what reconstruction leaves of pressure differences; 1: that of Roe's solver",
     KITH_INTO(struct remix_settings, pressure_dissipation)},
    {"relaxation", KITH_PARAM_NUMBER, "1", "[0, inf)",
     "how fast volumes relax to those of the number density; 1: within a sound crossing of h",
     KITH_INTO(struct remix_settings, relaxation)},
    {0}};

/* The fields of a packed particle. */
enum {
  REMIX_PRESSURE = KITH_PACKED_VISCOUS,
  REMIX_VOLUME,
  REMIX_SWITCH,                      /* Balsara's factor */
  REMIX_SLOPE,                       /* dP/dx */
  REMIX_KERNEL = REMIX_SLOPE + NDIM, /* moments.h */
  REMIX_PACKED = REMIX_KERNEL + CRK_COEFFICIENTS
};

struct remix {
  struct crk_moments moments;
  /* State, as last evaluated: V (0: not yet known), div v, `surface` of (1). */
  struct kith_field *volume, *expansion, *surface;
  struct kith_viscosity_fields viscosity;
};

/* What all pairs share. */
struct remix_constants {
  struct kith_viscosity_constants viscosity;
  double kernel, dissipation;
};

/* Evaluates a pair: (2), (3). */
KITH_INLINE void pair_remix(enum kith_kernel kernel, const void *constants, const double *restrict i,
                            const double *restrict j, double *restrict out) {
  const struct remix_constants *c = constants;
  const struct kith_viscous_pair p = kith_viscous_pair(&c->viscosity, i, j);
  const double inverse_i = i[KITH_PACKED_INVERSE], inverse_j = J(KITH_PACKED_INVERSE),
               scale_i = kith_pow_dim(inverse_i), scale_j = kith_pow_dim(inverse_j),
               volumes = 0.5 * c->kernel * i[REMIX_VOLUME] * J(REMIX_VOLUME);
  double wi, gi, wj, gj, d[NDIM];
  kith_kernel_value(kernel, p.qi, &wi, &gi);
  kith_kernel_value(kernel, p.qj, &wj, &gj);
  /* V_i V_j W, and V_i V_j grad W = g x. */
  const double w = volumes * (wi * scale_i + wj * scale_j),
               g = volumes * (gi * scale_i * inverse_i * inverse_i + gj * scale_j * inverse_j * inverse_j);
  crk_gradient(&p, w, g, i + REMIX_KERNEL, &J(REMIX_KERNEL), d);

  const double pi = kith_tension(p.closer, i[REMIX_PRESSURE]), pj = kith_tension(p.closer, J(REMIX_PRESSURE)),
               q = kith_viscous_pressure(&c->viscosity, &p, i[KITH_PACKED_DENSITY], J(KITH_PACKED_DENSITY),
                                         0.5 * (i[REMIX_SWITCH] + J(REMIX_SWITCH)));
  double growth = 0; /* of both volumes together */
  for (int a = 0; a < NDIM; ++a) {
    OUT(KITH_FORCE + a) = -0.5 * (pi + pj + q) * d[a];
    growth += 0.5 * d[a] * (J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a]);
  }
  const double evened = c->dissipation * kith_pressure_heat(i, j, REMIX_PRESSURE, REMIX_SLOPE, -2 * g * p.r);
  const double share = growth > 0 && KITH_MIN(pi, pj) >= 0 && pi + pj > 0 ? pi / (pi + pj) : 0.5;
  OUT(KITH_HEAT) = evened - (pi + share * q) * growth;
  OUT(KITH_PARTNER_HEAT) = -evened - (pj + (1 - share) * q) * growth;
  OUT(KITH_SIGNAL) = KITH_HAS_SIGNAL(p.qi, p.qj) ? p.signal : 0;
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct remix *remix = package->self;
  kith_viscosity_pack(hydro, &remix->viscosity, i, packed);
  kith_crk_moments_pack(&remix->moments, i, packed + REMIX_KERNEL);
  packed[REMIX_SWITCH] = kith_viscosity_factor(&remix->viscosity, i);
  packed[REMIX_PRESSURE] = hydro->pressure->f64[i];
  packed[REMIX_VOLUME] = hydro->mass->f64[i] / hydro->density->f64[i];
  for (int a = 0; a < NDIM; ++a) packed[REMIX_SLOPE + a] = remix->moments.slope->f64[(size_t)i * NDIM + a];
}

static void copy_corrections(const double *restrict i, double *restrict j) {
  for (int k = REMIX_KERNEL; k < REMIX_PACKED; ++k) J(k) = i[k];
}

KITH_FORCE_FORM(pair_remix, REMIX_PACKED, pack, copy_corrections)

static kith_status remix_create(struct kith_package *package) {
  struct remix *remix = package->self;
  const struct remix_settings *settings = package->settings;
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(SCALAR, KEPT, "volume", "that follows the flow"), &remix->volume},
      {true, KITH_SPEC(SCALAR, KEPT, "expansion", "div v when the volume was evaluated"), &remix->expansion},
      {true, KITH_SPEC(SCALAR, KEPT, "surface", "0 but at the surface of a liquid"), &remix->surface},
      {true, KITH_SPEC(SCALAR, WORK, "kernel_sum", "of neighbors and itself, 1 but at a surface"),
       &remix->moments.kernel_sum},
      {true, KITH_SPEC(VECTOR, WORK, "pressure_slope", "dP/dx"), &remix->moments.slope},
      {0}};
  remix->moments.value = package->hydro->pressure;
  KITH_TRY(kith_viscosity_create(package, &settings->viscosity, &remix->viscosity));
  KITH_TRY(kith_nodes_fields(package->hydro->nodes, fields));
  return kith_crk_moments_init(&remix->moments, package->hydro->nodes);
}

/* Sets the volumes of nodes that have none yet from their densities, where these are known. */
static void start_volumes(const struct kith_hydro *hydro, struct kith_field *volume) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i)
    if (volume->f64[i] == 0 && hydro->density->f64[i] > 0)
      volume->f64[i] = hydro->mass->f64[i] / hydro->density->f64[i];
}

/* Sets `surface` of (1) of the active nodes, for the next evaluation: pressures may be predicted by then. */
static void find_surfaces(const struct kith_hydro *hydro, const struct remix *remix) {
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    if (!kith_node_active(hydro->nodes, i)) continue;
    const double c = hydro->sound_speed->f64[i], stiffness = hydro->density->f64[i] * c * c;
    remix->surface->f64[i] = stiffness > 0 ? KITH_MAX(0, 1 - remix->moments.kernel_sum->f64[i]) *
                                                 KITH_MAX(0, 1 - 4 * hydro->pressure->f64[i] / stiffness)
                                           : 0;
  }
}

static const double most = 8; /* V / V_even */

/* Advances volumes by (1), and sets the densities that follow. */
static void follow_volumes(const struct kith_package *package, const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct remix *remix = package->self;
  const struct remix_settings *settings = package->settings;
  const struct kith_block_steps *b = kick->blocks;
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    if (!kith_node_active(hydro->nodes, i)) continue;
    double *const volume = &remix->volume->f64[i], *const before = &remix->expansion->f64[i];
    const double support = hydro->nodes->support->f64[i], h = support / kith_kernel_support(package->kernel),
                 even = kith_ball() * kith_pow_dim(support) / package->neighbors,
                 dt = b != NULL ? b->tick * (b->now - b->last->f64[i]) : kick->evaluation_dt,
                 now = package->velocity_divergence->f64[i];
    if (*volume == 0) *volume = even;
    if (dt > 0) {
      const double s = 1 / (1 + pow(remix->moments.change->f64[i] / 0.2, 4) +
                            pow(remix->surface->f64[i] / 0.05, 4)),
                   crossings = dt * package->signal->f64[i] / h;
      *volume *= exp(0.5 * dt * (*before + now));
      *volume *= pow(even / *volume, -expm1(-settings->relaxation * s * crossings));
      *volume = KITH_MIN(KITH_MAX(*volume, even / most), even * most);
    }
    *before = now;
    hydro->density->f64[i] = hydro->mass->f64[i] / *volume;
  }
}

static kith_status remix_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                  const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct remix *remix = package->self;
  const struct crk_moments *m = &remix->moments;
  const struct remix_settings *settings = package->settings;
  const struct kith_density_wanted wanted = {
      .omega = m->omega, .curl = remix->viscosity.curl, .shear = remix->viscosity.shear};
  start_volumes(hydro, remix->volume);
  KITH_TRY(kith_density(package, connectivity, &wanted));
  KITH_TRY(kith_ranks_finish_agree(hydro->nodes->ranks)); /* volumes have a history */
  follow_volumes(package, kick);
  kith_hydro_evaluate_eos(hydro);
  struct kith_field *const state[] = {hydro->nodes->support, hydro->density, hydro->pressure};
  kith_package_start_refresh(package, 3, state);
  KITH_TRY(kith_crk_moments_evaluate(package, m, connectivity));
  find_surfaces(hydro, remix);
  struct kith_field *between[8] = {hydro->sound_speed, m->slope, m->a, m->c, m->a_gradient, m->c_gradient};
  const int n = kith_viscosity_exchanged(&remix->viscosity, 6, between);
  kith_balsara_factors(package, &settings->viscosity, &remix->viscosity, 0, hydro->nodes->n_internal);
  const struct remix_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .kernel = kith_kernel_constant(package->kernel),
      .dissipation = settings->pressure_dissipation};
  return kith_force(
      package, connectivity, kick,
      &(struct kith_force_pass){
          .form = &pair_remix_form, .constants = &constants, .exchanged = between, .n_exchanged = n});
}

static struct kith_package_traits remix_traits(const void *settings) {
  (void)settings;
  return (struct kith_package_traits){.history = "the volume of a node"};
}

const struct kith_package_ops kith_package_remix = {
    .name = "remix",
    .doc = "densities that follow the flow, with reproducing kernels: for contacts where the spacing jumps",
    .self_size = sizeof(struct remix),
    .create = remix_create,
    .evaluate = remix_evaluate,
    .traits = remix_traits,
    .spacings = NDIM == 2 ? 1.33 : 0, /* as crk */
    .cfl = NDIM == 3 ? 0.4 : 0.3,
    KITH_SETTINGS(params, remix_settings),
};
