/* Package `sph`: density-energy SPH with grad-h terms and artificial viscosity.
 *
 * Supports follow from the number density, densities from the sum of masses. X and Omega are those of
 * density.h, as are equations (1) and (2). With
 *     psi_i = m_i P_i / rho_i^2
 * the Lagrangian gives (Hopkins 2013, MNRAS 428, 2840; m_j - X_i = m / Omega for equal masses)
 *     m_i dv_i/dt = - sum_j [psi_i (m_j - X_i) grad_i W(H_i) + psi_j (m_i - X_j) grad_i W(H_j)
 *                            + m_i m_j Pi_ij grad_i W_mean]                                            (3)
 *     m_i du_i/dt =   sum_j [psi_i (m_j - X_i) v_ij . grad_i W(H_i)
 *                            + (1/2) m_i m_j Pi_ij v_ij . grad_i W_mean]                               (4)
 *     Pi_ij = q_ij / rho_mean,  q_ij = -s alpha c_mean mu + beta mu^2, less in shear                   (5)
 * with mu and q of viscosity.h (Monaghan 1997, JCoPh 136, 298). s is Balsara's factor (viscosity.h), times
 * the switch of (6) if there is one. Negative pressures are multiplied by t of tension.h.
 *
 * Setting viscosity.name `cullen-dehnen`: the switch s follows the compression rate (Cullen and Dehnen 2010,
 *     MNRAS 408, 669; in the form of Price et al. 2018, PASA 35, e031, eqs. 45-48). With h = 2 sigma and
 *     A = max(0, -d(div v)/dt) (div v)^2 / ((div v)^2 + (curl v)^2) where div v < 0, else 0,
 *     s_local = min(1, 10 h^2 A / c^2)                                                                 (6)
 *     s rises to s_local at once, and decays to it in the time h / (0.1 v_signal).
 * Setting conduction, a_u, adds the heat
 *     m_i m_j a_u v_u (u_i - u_j) / rho_mean |x_ij . grad W_mean| / |x_ij|,
 *     v_u = sqrt(|P_i - P_j| / rho_mean)                                                               (7)
 *     (Price 2008, JCoPh 227, 10040), which is none where the pressure is even.
 * Setting pressure_dissipation, a_P, adds the heat, from j to i,
 *     a_P |f_ij . v_ij| (P_j - P_i) / (|P_i| + |P_j| + rho_mean^2 Pi_ij)                               (8)
 *     For a_P = 1/2 this is what crk's shares of the work move (eq. 7 there), but for their cosine. Forces
 *     along x_ij let nodes that a shock has pressed together in one direction slide past each other (page on
 *     methods, Sedov), and (8) damps the pressures of this noise. It is off, since it spreads contacts.
 * Setting density `nodes`: rho_i = m_i n_i, and in (3) and (4) psi_i (m_i - X_i), psi_j (m_j - X_j) with X as
 *     of equal masses, so m_i - X_i = m_i / Omega_i: the Lagrangian of these densities. Where masses jump on
 *     an even lattice, the sum of masses smears the density but not the energies, so there is a ridge of
 *     pressure, which acts as a tension. With `nodes` there is none; but shocks that start at such a contact
 *     are less accurate (page on methods), so it is not the default.
 * Setting stretch: supports are ellipsoids with half axes s_a H (a fixed tensor). W depends on |x_ij| in
 *     their metric M = diag(1 / s_a^2), so grad_i W = W' / (H |x_ij|_M) M x_ij. The viscosity ignores it.
 *
 * Passes: density -> equation of state, switches -> ghosts -> packing -> force [pairs]. */
#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

enum { SPH_DENSITY_MASSES, SPH_DENSITY_NODES };
struct sph_settings {
  struct kith_viscosity_settings viscosity; /* first: tests read it */
  int density;
  double conduction, pressure_dissipation, stretch[NDIM];
};
static const struct kith_param viscosity_params[] = {
    KITH_VISCOSITY_PARAMS(struct sph_settings, KITH_VISCOSITY_LIST, "1"), {0}};
static const struct kith_param params[] = {
    {"viscosity", KITH_PARAM_MAP, "", "", "artificial viscosity", KITH_BELOW(viscosity_params, MAP)},
    {"density", KITH_PARAM_CHOICE, "masses", "masses|nodes",
     "sum of the masses in the support; or a node's mass over its volume, for contacts of unequal masses",
     KITH_INTO(struct sph_settings, density)},
    {"conduction", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "coefficient of heat conduction where the pressure jumps; 1 is usual",
     KITH_INTO(struct sph_settings, conduction)},
    {"pressure_dissipation", KITH_PARAM_NUMBER, "0", "[0, inf)",
     "heat that evens out pressures, over a pair's work; 2 halves the noise behind blasts in 2-D and 3-D",
     KITH_INTO(struct sph_settings, pressure_dissipation)},
    {"stretch", KITH_PARAM_VECTOR, "[1, 1, 1]", "[1, inf)",
     "half axes of supports in units of the shortest one, along x, y, z: ellipsoids of one shape",
     KITH_INTO(struct sph_settings, stretch)},
    {0}};

/* The fields of a packed particle. */
enum {
  SPH_PSI = KITH_PACKED_VISCOUS, /* m P / rho^2 */
  SPH_GRAD_H_TERM,               /* X */
  SPH_MASS,
  SPH_SIMPLE,              /* number of fields without switches */
  SPH_SWITCH = SPH_SIMPLE, /* s */
  SPH_ENERGY,
  SPH_FULL /* number of all fields */
};

struct sph {
  bool full;      /* particles are packed with all fields */
  bool all_terms; /* pairs have stretched supports, own masses, (7) or (8) */
  struct kith_field *grad_h_term;
  struct kith_viscosity_fields viscosity;            /* with s, if there is a switch */
  struct kith_field *compression, *viscosity_switch; /* d(div v)/dt; s of (6), state. NULL without a switch */
};

/* What all pairs share. */
struct sph_constants {
  struct kith_viscosity_constants viscosity;
  double conduction, pressure_dissipation;
  bool own;             /* density is `nodes` */
  double kernel;        /* C of the kernel */
  const double *metric; /* [NDIM] diagonal of M */
};

/* --- the pair function --- */

/* Evaluates a pair: (3) - (5); full: with switches; all: also stretched supports, own masses, (7) and (8). */
KITH_INLINE void sph_pair(enum kith_kernel kernel, bool full, bool all, const struct sph_constants *c,
                          const double *restrict i, const double *restrict j, double *restrict out) {
  struct kith_viscous_pair p = kith_viscous_pair(&c->viscosity, i, j);
  double along[NDIM], r2 = 0, apart = p.r; /* M x_ij; x_ij . M x_ij / |x_ij| */
  for (int a = 0; a < NDIM; ++a) along[a] = i[KITH_PACKED_X + a] - J(KITH_PACKED_X + a);
  if (all) {
    p.vx = 0;
    for (int a = 0; a < NDIM; ++a) {
      r2 += c->metric[a] * along[a] * along[a];
      along[a] *= c->metric[a];
      p.vx += along[a] * (i[KITH_PACKED_V + a] - J(KITH_PACKED_V + a));
    }
    apart = r2 / KITH_MAX(p.r, DBL_MIN);
    p.qi = sqrt(r2) * i[KITH_PACKED_INVERSE], p.qj = sqrt(r2) * J(KITH_PACKED_INVERSE);
  }
  const double gi = kith_kernel_gradient(kernel, c->kernel, p.qi, i[KITH_PACKED_INVERSE]);
  const double gj = kith_kernel_gradient(kernel, c->kernel, p.qj, J(KITH_PACKED_INVERSE));
  const double s = full ? 0.5 * (i[SPH_SWITCH] + J(SPH_SWITCH)) : 1,
               viscosity = kith_viscous_term(&c->viscosity, &p, s) * p.inverse_densities; /* Pi / 2 */

  /* (3): pressure of i, pressure of j, viscosity; all along x_ij. */
  const double masses = i[SPH_MASS] * J(SPH_MASS);
  const bool own = all && c->own;
  const double fi = -kith_tension(p.closer, i[SPH_PSI]) *
                    ((own ? i[SPH_MASS] : J(SPH_MASS)) - i[SPH_GRAD_H_TERM]) * gi,
               fj = -kith_tension(p.closer, J(SPH_PSI)) *
                    ((own ? J(SPH_MASS) : i[SPH_MASS]) - J(SPH_GRAD_H_TERM)) * gj,
               fq = -masses * viscosity * (gi + gj);
  const double force = fi + fj + fq;
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = force * along[a];

  /* (4): the work of each node's own pressure, and half of the viscosity's. */
  double heat = 0;
  if (all) {
    const double rho_i = i[KITH_PACKED_DENSITY], rho_j = J(KITH_PACKED_DENSITY),
                 pi = i[SPH_PSI] * rho_i * rho_i / i[SPH_MASS], pj = J(SPH_PSI) * rho_j * rho_j / J(SPH_MASS),
                 densities = rho_i + rho_j, jump = pj - pi,
                 speed = sqrt(2 * fabs(jump) / densities),                         /* (7) */
        pressures = fabs(pi) + fabs(pj) + 0.5 * viscosity * densities * densities; /* (8) */
    heat = c->conduction * masses * speed * (i[SPH_ENERGY] - J(SPH_ENERGY)) * apart * (gi + gj) / densities +
           c->pressure_dissipation * fabs(force * p.vx) * jump / KITH_MAX(pressures, DBL_MIN);
  }
  OUT(KITH_HEAT) = heat - (fi + 0.5 * fq) * p.vx;
  OUT(KITH_PARTNER_HEAT) = -heat - (fj + 0.5 * fq) * p.vx;
  OUT(KITH_SIGNAL) = KITH_HAS_SIGNAL(p.qi, p.qj) ? p.signal : 0;
}

KITH_INLINE void pair_simple(enum kith_kernel kernel, const void *constants, const double *restrict i,
                             const double *restrict j, double *restrict out) {
  sph_pair(kernel, false, false, constants, i, j, out);
}
KITH_INLINE void pair_full(enum kith_kernel kernel, const void *constants, const double *restrict i,
                           const double *restrict j, double *restrict out) {
  sph_pair(kernel, true, false, constants, i, j, out);
}
KITH_INLINE void pair_all(enum kith_kernel kernel, const void *constants, const double *restrict i,
                          const double *restrict j, double *restrict out) {
  sph_pair(kernel, true, true, constants, i, j, out);
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct sph *sph = package->self;
  const double density = hydro->density->f64[i], mass = hydro->mass->f64[i];
  kith_viscosity_pack(hydro, &sph->viscosity, i, packed);
  packed[SPH_PSI] = mass * hydro->pressure->f64[i] / (density * density);
  packed[SPH_GRAD_H_TERM] = sph->grad_h_term->f64[i];
  packed[SPH_MASS] = mass;
  if (!sph->full) return;
  packed[SPH_SWITCH] = kith_viscosity_factor(&sph->viscosity, i);
  packed[SPH_ENERGY] = hydro->energy->f64[i];
}

static void copy_corrections(const double *restrict i, double *restrict j) {
  J(SPH_GRAD_H_TERM) = i[SPH_GRAD_H_TERM] * J(SPH_MASS) / i[SPH_MASS];
}

KITH_FORCE_FORM(pair_simple, SPH_SIMPLE, pack, copy_corrections)
KITH_FORCE_FORM(pair_full, SPH_FULL, pack, copy_corrections)
KITH_FORCE_FORM(pair_all, SPH_FULL, pack, copy_corrections)

static kith_status forces(struct kith_package *package, const struct kith_connectivity *connectivity,
                          const struct kith_kick *kick, int n, struct kith_field *const *exchanged) {
  const struct sph *sph = package->self;
  const struct sph_settings *settings = package->settings;
  const struct kith_nodes *nodes = package->hydro->nodes;
  double metric[NDIM];
  for (int a = 0; a < NDIM; ++a) metric[a] = 1 / (nodes->stretch[a] * nodes->stretch[a]);
  const struct sph_constants constants = {
      .viscosity = kith_viscosity_constants(&settings->viscosity, package->neighbors),
      .conduction = settings->conduction,
      .pressure_dissipation = settings->pressure_dissipation,
      .own = settings->density == SPH_DENSITY_NODES,
      .kernel = kith_kernel_constant(package->kernel) / nodes->volume,
      .metric = metric};
  return kith_force(package, connectivity, kick,
                    &(struct kith_force_pass){.form = sph->all_terms ? &pair_all_form
                                                      : sph->full    ? &pair_full_form
                                                                     : &pair_simple_form,
                                              .constants = &constants,
                                              .exchanged = exchanged,
                                              .n_exchanged = n});
}

/* --- fields, switches, passes --- */

static bool is_stretched(const struct sph_settings *settings) {
  bool stretched = false;
  for (int a = 0; a < NDIM; ++a) stretched = stretched || settings->stretch[a] != 1;
  return stretched;
}

static kith_status sph_create(struct kith_package *package) {
  struct sph *sph = package->self;
  const struct sph_settings *settings = package->settings;
  const bool rising = settings->viscosity.name == KITH_VISCOSITY_CULLEN_DEHNEN;
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(SCALAR, WORK, "grad_h_term", "grad-h mass X"), &sph->grad_h_term},
      {rising, KITH_SPEC(SCALAR, WORK, "compression", "d(div v)/dt"), &sph->compression},
      {rising,
       {"viscosity", KITH_SCALAR, KITH_F64, KITH_KEPT, "Viscosity", "viscosity switch"},
       &sph->viscosity_switch},
      {0}};
  sph->all_terms = settings->conduction > 0 || settings->pressure_dissipation > 0 || is_stretched(settings) ||
                   settings->density == SPH_DENSITY_NODES;
  KITH_TRY(kith_viscosity_create(package, &settings->viscosity, &sph->viscosity));
  sph->full = sph->viscosity.factor != NULL || sph->all_terms;
  if (is_stretched(settings)) KITH_TRY(kith_nodes_stretch(package->hydro->nodes, settings->stretch));
  if (rising) KITH_TRY(kith_nodes_give_ghosts(package->hydro->nodes, package->hydro->acceleration));
  return kith_nodes_fields(package->hydro->nodes, fields);
}

/* Returns the viscosity switch (6) of node i, which was s at the last evaluation, a time dt ago. */
static double viscosity_switch(const struct kith_package *package, double dt, kith_index i, double s) {
  const struct sph *sph = package->self;
  const double h = package->hydro->nodes->support->f64[i] / kith_kernel_support(package->kernel);
  const double c = package->hydro->sound_speed->f64[i], divergence = package->velocity_divergence->f64[i];
  const double d2 = divergence * divergence, curl = sph->viscosity.curl->f64[i];
  const double rate = divergence < 0 ? fmax(0, -sph->compression->f64[i]) * d2 / (d2 + curl * curl) : 0;
  const double wanted = fmin(1, 10 * h * h * rate / fmax(c * c, 1e-300));
  if (wanted >= s) return wanted;
  const double signal = fmax(package->signal->f64[i], c);
  return wanted + (s - wanted) * exp(-0.1 * signal * dt / h);
}

/* Sets the factors of the viscosity of the active nodes among begin .. end - 1: Balsara's factor, times the
 * switch if there is one. */
static void set_factors(struct kith_package *package, const struct kith_kick *kick, kith_index begin,
                        kith_index end) {
  const struct kith_nodes *nodes = package->hydro->nodes;
  const struct sph *sph = package->self;
  const struct sph_settings *settings = package->settings;
  const struct kith_block_steps *b = kick->blocks;
  kith_balsara_factors(package, &settings->viscosity, &sph->viscosity, begin, end);
  if (sph->viscosity_switch == NULL) return;
#pragma omp parallel for schedule(static)
  for (kith_index i = begin; i < end; ++i) {
    if (!kith_node_active(nodes, i)) continue;
    const double dt = b != NULL ? b->tick * (b->now - b->last->f64[i]) : kick->evaluation_dt;
    double *const s = &sph->viscosity_switch->f64[i];
    *s = viscosity_switch(package, dt, i, *s);
    sph->viscosity.factor->f64[i] *= *s;
  }
}

/* Raises the signal speed of light nodes beside heavy ones, for the time step alone. Light nodes with heavy
 * ones at the edge of their support have X_i > m_i: by (3) they attract each other while the heavy ones push
 * them away, and they swing faster than sound would. Leapfrog with too long a step takes heat from one and
 * gives it to another until one has none. The factor, for active nodes, is sqrt(1 + 8 (X_i - m_i) / mean m),
 * mean m = rho_i V_i with the volume V_i of a node. In 1-D contacts of 10 : 1 to 100 : 1 then run; those of
 * 300 : 1 and 1000 : 1 stop at some resolutions, with 16 instead of 8 at fewer, for 40 % more steps. */
static void raise_signal_speeds(struct kith_package *package) {
  const struct kith_hydro *hydro = package->hydro;
  const double *restrict h = hydro->nodes->support->f64, *restrict rho = hydro->density->f64,
                         *restrict mass = hydro->mass->f64;
  const double part = hydro->nodes->volume * kith_ball() / package->neighbors; /* volume of a node over H^d */
#pragma omp parallel for schedule(static)
  for (kith_index i = 0; i < hydro->nodes->n_internal; ++i) {
    const double beyond = ((const struct sph *)package->self)->grad_h_term->f64[i] - mass[i];
    if (beyond > 0 && kith_node_active(hydro->nodes, i))
      package->signal->f64[i] *= sqrt(1 + 8 * beyond / (rho[i] * part * kith_pow_dim(h[i])));
  }
}

static kith_status sph_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  const struct kith_nodes *nodes = hydro->nodes;
  const struct sph *sph = package->self;
  const struct sph_settings *settings = package->settings;
  const struct kith_density_wanted wanted = {.grad_h_term = sph->grad_h_term,
                                             .own_masses = settings->density == SPH_DENSITY_NODES,
                                             .shear = sph->viscosity.shear,
                                             .curl = sph->viscosity.curl,
                                             .compression = sph->compression};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_hydro_evaluate_eos(hydro);
  if (sph->viscosity_switch != NULL) KITH_TRY(kith_ranks_finish_agree(nodes->ranks)); /* it has a history */
  set_factors(package, kick, 0, nodes->n_internal);
  struct kith_field *between[7] = {nodes->support, hydro->density, hydro->pressure, hydro->sound_speed,
                                   sph->grad_h_term};
  const int n = kith_viscosity_exchanged(&sph->viscosity, 5, between);
  if (package->recompute) {
    kith_hydro_evaluate_eos_remote(hydro);
    set_factors(package, kick, kith_nodes_first_remote(nodes), kith_nodes_count(nodes));
    kith_nodes_refresh_images(hydro->nodes, between, n);
  }
  KITH_TRY(forces(package, connectivity, kick, package->recompute ? 0 : n, between));
  if (!wanted.own_masses && !hydro->equal_here) raise_signal_speeds(package);
  return KITH_OK;
}

static struct kith_package_traits sph_traits(const void *settings) {
  const bool rising = ((const struct sph_settings *)settings)->viscosity.name == KITH_VISCOSITY_CULLEN_DEHNEN;
  const bool stretched = is_stretched(settings);
  return (struct kith_package_traits){
      .recomputes = !stretched,
      .elastic = true,
      .swings = ((const struct sph_settings *)settings)->density == SPH_DENSITY_MASSES,
      .all_rows = stretched ? "stretched supports" : NULL,
      .no_between = stretched ? "stretch" : NULL,
      .history = rising ? "viscosity cullen-dehnen" : NULL};
}

const struct kith_package_ops kith_package_sph = {
    .name = "sph",
    .doc = "density-energy SPH with grad-h terms and artificial viscosity",
    .self_size = sizeof(struct sph),
    .create = sph_create,
    .evaluate = sph_evaluate,
    .traits = sph_traits,
    .cfl = NDIM == 3 ? 0.4 : 0.3, /* at 0.5 the blast in 3-D is 3 % off; noise in 2-D grows with it */
    KITH_SETTINGS(params, sph_settings),
};
