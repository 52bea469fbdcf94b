/* Package `mfm`: meshless finite mass, a Riemann solver on faces that move with the gas (Hopkins
 * 2015, MNRAS 450, 53).
 *
 * Supports and volumes by number density, rho_i = m_i n_i (density.h); faces A_ij from i to j (faces.h); the
 * contact of the two gases at a face gives P* and S* (riemann.h). Nothing crosses a face that moves with the
 * contact, so masses are fixed:
 *     m_i dv_i/dt = - sum_j P*_ij A_ij                                                    (1)
 *     m_i du_i/dt = - sum_j P*_ij A_ij . (v*_ij - v_i),  v* = (v_i + v_j) / 2 + S* A_ij / |A_ij|    (2)
 * S* is relative to the mean velocity, so results are Galilean invariant. Negative P* are multiplied by t of
 * tension.h, and have no S* in (2): it would take heat from the node of lower pressure, and energies would
 * drift apart until liquids are torn.
 * The heat that a face takes from a node is limited by the pressure of the node: if h_i < 0 and P* > 4 P_i,
 * its partner gives
 *     (1 - 4 P_i / P*) |h_i|                                                              (3)
 * without which the energy of a cold node beside a hot one, accelerated beyond the speed of the face, would
 * become negative. It is 0 where pressures are within a factor 4. Where P_i < P_j and the nodes recede from
 * each other with dv > c_i, the 4 is max(1, 4 c_i / dv): in gas that expands faster than sound pressures fall
 * steeply from node to node, and each node shall cool by its own.
 *
 * Pressure and velocity at the middle of a pair are reconstructed from linear-exact gradients of P and of
 * the velocity along the face. With the difference D = q_j - q_i of each and the slope a = grad q_i . (x_j -
 * x_i),
 *     q_i' = q_i + L(a, D) / 2,  L = a within -D and 1.5 D                                 (4)
 * the limiter of pairs of Hopkins 2015, psi_1 = 1/2, psi_2 = 1/4, without that of nodes, which he has
 * before it; the pressure loses no more than half. Chosen by experiment: with L between 0 and D errors are
 * 1.24 times as large in Sod's tube of equal masses (1-D, 200 nodes), 1.09 in Gresho's vortex (32^2), 1.10
 * in Sedov's blast (2-D, 60), 19 in Kidder's capsule (2-D), .93 in Sod's tube in 2-D; with L up to 2 D
 * .95, .95, .99, .98 and 1.06.
 *
 * The reconstructed velocities (4) of nodes that recede from each other, dv > 0 along the face, approach each
 * other by no more than
 *     0.2 c min(1, c / dv),  c = (c_i + c_j) / 2                                           (5)
 * In gas so cold that dv >> c, the P* of such a face would come from their difference, not from P, and it
 * would take more heat from both nodes than an expansion does: in gas that streams into a vacuum entropies
 * fell by orders of magnitude, and energies became negative. In flows below the speed of sound velocities
 * never get as far. Those of nodes that approach each other, -dv > 8 c, approach by no less than
 *     0.5 s (-dv - 8 c),  s of (6)                                                        (5a)
 * Where two rows of nodes meet head on, each has most of its slope from the other, so reconstruction would
 * leave no difference between them. Without a shock the gas between them is compressed like a spring: for
 * gamma below 1.2, where little pressure comes of it, until the time step collapses.
 *
 * What is left of the difference of the velocities along the face, D = v_l - v_r, is diminished by
 *     (1 - s) max(-0.1 c, min(D, 0.1 c)),  s = the mean of b min(1, 16 b)                  (6)
 * with Balsara's factors b of both nodes (viscosity.h, e = 3e-3 c / h): of its part that is much slower than
 * sound only s is left. Hopkins has no such factor. Slopes are means over a support, so reconstruction leaves
 * a part of any flow that changes over a few supports, and what the solver makes of it, rho c D / 2, damps
 * vortices and shear. In shear b is a few percent; in noise and shocks it exceeds 1/16 and is kept.
 * Without the factor; with s = b; with (6); with 4 instead of 16; with s = b, e = 1e-3 c / h:
 *     Kelvin-Helmholtz, amplitude (.148 is right)                 .032   .127   .137   .139
 *     growth of a shear layer, 32 nodes (exact .873; sph .871)    .250   .838   .858   .861   .851
 *     Gresho, 50^2, L1 of the velocity (sph .061, crk .039)       .122   .037   .037   .044
 *     Yee's vortex, L1 of the speed (sph .0082, crk .0073)        .0083  .0076  .0076  .0086
 *     noise after five crossings (sph .0067, crk .0027)           .0021  .0029  .0029  .0029  .0035
 * With 12 or 20 they change by 3 % at most, with a limit of 0.05 c to 0.5 c by 6 %. If (1 - s) took
 * all of D, a sheared shock of Noh would be .39 spacings ahead instead of .29.
 *
 * The density is that of the node, where Hopkins reconstructs it too: nothing but the impedances rho c of
 * both sides depends on it, and through them P* and S* only as far as the reconstructed states differ. This
 * bounds the damping of a node: at small jumps sum_j A q_i q_j / (q_i + q_j) / m_i <= c_i sum_j A / V_i,
 * whatever its partners weigh, as in even gas, with which the Courant condition copes. A density that was
 * reconstructed across a contact of 1000 : 1 makes the thin side up to 750 times as heavy, and it grows from
 * round-off.
 *
 * Passes: density -> equation of state -> ghosts -> slopes, moments -> ghosts -> integrated faces ->
 * packing -> force [pairs]. */
#include <math.h>
#include "lib/core/lanes.h"
#include "lib/core/vec.h"
#include "physics/mfm/faces.h"
#include "physics/mfm/riemann.h"
#include "physics/passes/density.h"
#include "physics/passes/viscosity.h"

struct mfm {
  struct mfm_faces faces; /* first: tests read it */
  struct kith_field *velocity_slope, *pressure_slope;
};

struct mfm_settings {
  enum mfm_faces_form faces;
};
#define AS_CHOICE(name, word) "|" #word
static const struct kith_param params[] = {
    {"faces", KITH_PARAM_CHOICE, "one-point", MFM_FACES_LIST(AS_CHOICE),
     "from the gradients at both nodes, or summed over the nodes that two supports share",
     KITH_INTO(struct mfm_settings, faces)},
    {0}};

/* --- the pair function --- */

/* The fields of a packed particle, followed by an integrated face, or by what one-point faces need. */
enum {
  MFM_DENSITY = KITH_PACKED_OWN,
  MFM_PRESSURE,
  MFM_SOUND,
  MFM_GAMMA, /* of the material */
  MFM_INVERSE_GAMMA,
  MFM_INVERSE_DENSITY,
  MFM_INVERSE_SUPPORT,
  MFM_SWITCH, /* s of (6) */
  MFM_PRESSURE_SLOPE,
  MFM_VELOCITY_SLOPE = MFM_PRESSURE_SLOPE + NDIM, /* [a][b] = dv_a / dx_b */
  MFM_PACKED = MFM_VELOCITY_SLOPE + NDIM * NDIM,
  MFM_MATRIX = MFM_PACKED,
  MFM_PACKED_ONE_POINT = MFM_MATRIX + KITH_SYMMETRIC_SIZE,
  MFM_AREA = (MFM_PACKED + KITH_LANES - 1) / KITH_LANES * KITH_LANES
};

/* Returns L of (4). */
KITH_INLINE double limited(double slope, double difference) {
  const double most = fabs(difference), sign = difference > 0 ? 1 : -1;
  return sign * KITH_MAX(KITH_MIN(sign * slope, 1.5 * most), -most);
}

/* Returns rho c^2 / gamma: the pressure of an ideal gas, the pressure above -P0 of a stiffened gas. */
KITH_INLINE double above_vacuum(double density, double sound, double inverse_gamma) {
  return density * sound * sound * inverse_gamma;
}

/* Returns `node`, whose velocity is that along the face, reconstructed at the middle of the pair from the
 * slopes and differences towards the other end. */
KITH_INLINE struct mfm_side reconstruct(struct mfm_side node, double above, double inverse_density,
                                        const double *slope, const double *difference) {
  const double more = 0.5 * KITH_MAX(limited(slope[0], difference[0]), -above);
  node.pressure += more;
  node.velocity += 0.5 * limited(slope[1], difference[1]);
  node.sound = sqrt(node.gamma * (above + more) * inverse_density);
  return node;
}

/* Returns (3), which `node` gets back of the `heat` that it loses; own, partner: pressures above -P0. */
KITH_INLINE double heat_returned(struct mfm_side node, double receding, double own, double partner,
                                 double face, double heat) {
  const bool cools = receding > node.sound && own < partner;
  const double most = own * (cools ? KITH_MAX(1, 4 * node.sound / receding) : 4),
               total = face + own - node.pressure;
  return total > most ? KITH_MAX(-heat, 0.0) * (1 - most / total) : 0;
}

/* Evaluates the pair with this vector area of its face; closer: tension.h; near: it has a signal speed. */
KITH_INLINE void flux(double closer, bool near, const double *face, const double *restrict i,
                      const double *restrict j, double *restrict out) {
  double d[NDIM], n[NDIM], area2 = 0, slope_i[2] = {0}, slope_j[2] = {0}, du = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
    area2 += face[a] * face[a];
  }
  const double area = sqrt(area2), per_area = 1 / KITH_MAX(area, 1e-300);
  for (int a = 0; a < NDIM; ++a) n[a] = face[a] * per_area;
  for (int a = 0; a < NDIM; ++a) {
    slope_i[0] += i[MFM_PRESSURE_SLOPE + a] * d[a], slope_j[0] -= J(MFM_PRESSURE_SLOPE + a) * d[a];
    du += n[a] * (J(KITH_PACKED_V + a) - i[KITH_PACKED_V + a]);
    for (int b = 0; b < NDIM; ++b) {
      slope_i[1] += i[MFM_VELOCITY_SLOPE + a * NDIM + b] * n[a] * d[b];
      slope_j[1] -= J(MFM_VELOCITY_SLOPE + a * NDIM + b) * n[a] * d[b];
    }
  }
  const double dp = J(MFM_PRESSURE) - i[MFM_PRESSURE], there[] = {dp, du}, back[] = {-dp, -du};
  const double above_i = above_vacuum(i[MFM_DENSITY], i[MFM_SOUND], i[MFM_INVERSE_GAMMA]),
               above_j = above_vacuum(J(MFM_DENSITY), J(MFM_SOUND), J(MFM_INVERSE_GAMMA));
  const struct mfm_side node_i = {i[MFM_DENSITY], -0.5 * du,    i[MFM_PRESSURE],
                                  i[MFM_SOUND],   i[MFM_GAMMA], i[MFM_INVERSE_GAMMA]},
                        node_j = {J(MFM_DENSITY), 0.5 * du,     J(MFM_PRESSURE),
                                  J(MFM_SOUND),   J(MFM_GAMMA), J(MFM_INVERSE_GAMMA)};
  struct mfm_side l = reconstruct(node_i, above_i, i[MFM_INVERSE_DENSITY], slope_i, there),
                  r = reconstruct(node_j, above_j, J(MFM_INVERSE_DENSITY), slope_j, back);
  const double sound = 0.5 * (node_i.sound + node_j.sound), slow = 0.1 * sound,
               s = 0.5 * (i[MFM_SWITCH] + J(MFM_SWITCH)), jump = l.velocity - r.velocity;
  const double most = du > sound ? 0.2 * sound * sound / du : 0.2 * sound; /* (5) */
  const double least = 0.5 * s * (-du - 8 * sound);                        /* (5a) */
  const double limited = du > 0 ? KITH_MIN(jump, most) : least > 0 ? KITH_MAX(jump, least) : jump;
  const double less = (1 - s) * KITH_MAX(-slow, KITH_MIN(limited, slow)); /* (6) */
  const double change = 0.5 * (limited - less - jump);
  l.velocity += change, r.velocity -= change;
  struct mfm_star star = mfm_riemann(l, r);
  star.pressure = kith_tension(closer, star.pressure);
  for (int a = 0; a < NDIM; ++a) OUT(KITH_FORCE + a) = -star.pressure * face[a];
  const double work = -0.5 * star.pressure * area * du,
               exchanged = KITH_MAX(star.pressure, 0.0) * area * star.velocity, heat_i = work - exchanged,
               heat_j = work + exchanged;
  const double given = heat_returned(node_i, du, above_i, above_j, star.pressure, heat_i) -
                       heat_returned(node_j, du, above_j, above_i, star.pressure, heat_j); /* by j to i */
  OUT(KITH_HEAT) = heat_i + given;
  OUT(KITH_PARTNER_HEAT) = heat_j - given;
  OUT(KITH_SIGNAL) = near ? 0.5 * (i[MFM_SOUND] + J(MFM_SOUND)) + KITH_MAX(-du, 0.0) : 0;
}

/* Returns s - 1 of tension.h, 0 at most, at a distance r; constants: H in mean node spacings. */
KITH_INLINE double closer_of(const void *constants, double r, const double *restrict i,
                             const double *restrict j) {
  return kith_closer(*(const double *)constants,
                     r * KITH_MAX(i[MFM_INVERSE_SUPPORT], J(MFM_INVERSE_SUPPORT)));
}

KITH_INLINE void pair_one_point(enum kith_kernel kernel, const void *constants, const double *restrict i,
                                const double *restrict j, double *restrict out) {
  double d[NDIM], face[NDIM], r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
    r2 += d[a] * d[a];
  }
  const double r = sqrt(r2), hi = i[MFM_INVERSE_SUPPORT], hj = J(MFM_INVERSE_SUPPORT);
  mfm_one_point_face(kernel, r, d, i[MFM_INVERSE_SUPPORT], i + MFM_MATRIX, J(MFM_INVERSE_SUPPORT),
                     &J(MFM_MATRIX), KITH_STRIDE, face);
  flux(closer_of(constants, r, i, j), r * 2 * hi * hj / (hi + hj) < KITH_SIGNAL_EDGE, face, i, j, out);
}

KITH_INLINE void pair_integrated(enum kith_kernel kernel, const void *constants, const double *restrict i,
                                 const double *restrict j, double *restrict out) {
  double face[NDIM], r2 = 0, area2 = 0;
  (void)kernel;
  for (int a = 0; a < NDIM; ++a) {
    const double d = J(KITH_PACKED_X + a) - i[KITH_PACKED_X + a];
    r2 += d * d;
    face[a] = J(MFM_AREA + a);
    area2 += face[a] * face[a];
  }
  const double inverse = KITH_MIN(i[MFM_INVERSE_SUPPORT], J(MFM_INVERSE_SUPPORT)),
               scale = kith_pow_dim(inverse) / inverse; /* a shared node may be at both edges */
  flux(closer_of(constants, sqrt(r2), i, j), area2 * scale * scale > 1e-48, face, i, j, out);
}

static void pack(const struct kith_package *package, kith_index i, double *restrict packed) {
  const struct kith_hydro *hydro = package->hydro;
  const struct mfm *mfm = package->self;
  const size_t at = (size_t)i * NDIM;
  kith_force_pack(hydro, i, packed);
  for (int a = 0; a < NDIM; ++a) packed[MFM_PRESSURE_SLOPE + a] = mfm->pressure_slope->f64[at + a];
  for (int k = 0; k < NDIM * NDIM; ++k)
    packed[MFM_VELOCITY_SLOPE + k] = mfm->velocity_slope->f64[at * NDIM + k];
  const double *gradient = packed + MFM_VELOCITY_SLOPE, support = hydro->nodes->support->f64[i];
  double divergence = 0;
  for (int a = 0; a < NDIM; ++a) divergence += gradient[a * NDIM + a];
  const double e = 3e-3 * hydro->sound_speed->f64[i] * kith_kernel_support(package->kernel) / support;
  const double factor = kith_balsara(divergence, kith_curl(gradient), e);
  packed[MFM_SWITCH] = factor * KITH_MIN(1.0, 16 * factor);
  packed[MFM_DENSITY] = hydro->density->f64[i];
  packed[MFM_PRESSURE] = hydro->pressure->f64[i];
  packed[MFM_SOUND] = hydro->sound_speed->f64[i];
  const struct kith_material *material = &hydro->material[hydro->nodes->list->u8[i]];
  /* A predicted energy may be below 0: two pressures without sound would drive a contact without limit. */
  if (material->eos->power_law != NULL)
    packed[MFM_PRESSURE] =
        KITH_MAX(packed[MFM_PRESSURE], -material->eos->power_law(material->settings).stiffness);
  packed[MFM_GAMMA] = kith_material_gamma(material, hydro->density->f64[i], hydro->energy->f64[i]);
  packed[MFM_INVERSE_GAMMA] = 1 / packed[MFM_GAMMA];
  packed[MFM_INVERSE_DENSITY] = 1 / packed[MFM_DENSITY];
  packed[MFM_INVERSE_SUPPORT] = 1 / support;
  if (mfm->faces.matrix == NULL) return;
  for (int m = 0; m < KITH_SYMMETRIC_SIZE; ++m)
    packed[MFM_MATRIX + m] = mfm->faces.matrix->f64[(size_t)i * KITH_SYMMETRIC_SIZE + m];
}

static void copy_one_point_corrections(const double *restrict i, double *restrict j) {
  const double h = i[MFM_INVERSE_SUPPORT] / J(MFM_INVERSE_SUPPORT), scale = kith_pow_dim(h);
  for (int k = MFM_MATRIX; k < MFM_PACKED_ONE_POINT; ++k) J(k) = i[k] * scale;
}

KITH_FORCE_FORM(pair_one_point, MFM_PACKED_ONE_POINT, pack, copy_one_point_corrections)
KITH_FORCE_FORM(pair_integrated, MFM_PACKED, pack, NULL)

/* --- fields, passes --- */

static kith_status mfm_create(struct kith_package *package) {
  const struct kith_hydro *hydro = package->hydro;
  const struct mfm_settings *settings = package->settings;
  struct mfm *mfm = package->self;
  const struct kith_field_row fields[] = {
      {true, KITH_SPEC(TENSOR, WORK, "velocity_slope", "dv_a/dx_b"), &mfm->velocity_slope},
      {true, KITH_SPEC(VECTOR, WORK, "pressure_slope", "dP/dx"), &mfm->pressure_slope},
      {0}};
  if (settings->faces == MFM_FACES_INTEGRATED && package->barrier != NULL)
    KITH_FAIL(BAD_INPUT,
              "method.faces: integrated faces leave the side of a barrier open; take one-point faces");
  mfm->faces = (struct mfm_faces){.form = settings->faces,
                                  .nodes = hydro->nodes,
                                  .kernel = package->kernel,
                                  .neighbors = package->neighbors};
  KITH_TRY(kith_nodes_fields(hydro->nodes, fields));
  return kith_mfm_faces_init(&mfm->faces);
}

static void mfm_destroy(struct kith_package *package) {
  kith_mfm_faces_clear(&((struct mfm *)package->self)->faces);
}

static struct kith_requirements mfm_requirements(const struct kith_package *package) {
  return kith_mfm_faces_requirements(&((const struct mfm *)package->self)->faces);
}

static kith_status mfm_evaluate(struct kith_package *package, struct kith_connectivity *connectivity,
                                const struct kith_kick *kick) {
  const struct kith_hydro *hydro = package->hydro;
  struct mfm *mfm = package->self;
  const struct kith_density_wanted wanted = {.gradient = mfm->velocity_slope};
  KITH_TRY(kith_density(package, connectivity, &wanted));
  kith_hydro_evaluate_eos(hydro);
  struct kith_field *const state[] = {hydro->nodes->support, hydro->density, hydro->pressure,
                                      hydro->sound_speed, mfm->velocity_slope};
  kith_package_start_refresh(package, 5, state);
  KITH_TRY(kith_slope(package, connectivity, hydro->pressure, mfm->faces.matrix, mfm->pressure_slope));
  struct kith_field *const slopes[] = {mfm->pressure_slope, mfm->faces.matrix};
  const int n_slopes = mfm->faces.matrix != NULL ? 2 : 1;
  const double spacings = kith_root_dim(package->neighbors / kith_ball());
  struct kith_force_pass force = {
      .form = &pair_one_point_form, .constants = &spacings, .exchanged = slopes, .n_exchanged = n_slopes};
  if (mfm->faces.form == MFM_FACES_INTEGRATED) {
    kith_profile_begin(package->profile, "refresh");
    kith_halo_refresh(hydro->halo, hydro->nodes, slopes, n_slopes);
    kith_profile_end(package->profile);
    force.form = &pair_integrated_form, force.n_exchanged = 0;
    mfm->faces.profile = package->profile;
    mfm->faces.halo = hydro->halo;
    KITH_TRY(kith_mfm_faces_build(&mfm->faces, connectivity));
    connectivity = &mfm->faces.graph;
    force.edges = NDIM, force.edge = mfm->faces.area;
  }
  return kith_force(package, connectivity, kick, &force);
}

static size_t mfm_bytes(const struct kith_package *package) {
  const struct mfm_faces *f = &((const struct mfm *)package->self)->faces;
  return kith_rows_bytes(&f->holders) + f->value_capacity * sizeof *f->value;
}

static struct kith_package_traits mfm_traits(const void *settings) {
  const struct mfm_settings *mfm = settings;
  if (mfm->faces != MFM_FACES_INTEGRATED) return (struct kith_package_traits){0};
  return (struct kith_package_traits){
      .all_rows = "integrated faces",
      .uncoupled =
          "integrated faces reach beyond neighbors, between which porosity and damage act; take "
          "one-point faces",
      .cheaper = "method.faces=one-point: no overlap lists; a larger closure error on disordered nodes"};
}

const struct kith_package_ops kith_package_mfm = {
    .name = "mfm",
    .doc = "meshless finite mass: a Riemann solver on faces that move with the gas; no viscosity",
    .self_size = sizeof(struct mfm),
    .create = mfm_create,
    .destroy = mfm_destroy,
    .requirements = mfm_requirements,
    .evaluate = mfm_evaluate,
    .spacings = NDIM == 3   ? 1.22 /* 55 neighbors: with fewer gas at rest gives way on bcc lattices */
                : NDIM == 2 ? 1.33 /* 20 neighbors: half of the noise of 18 */
                            : 0,
    .cfl = NDIM == 3 ? 0.4 : 0.3,
    .stable_cfl = NDIM == 1 ? 0.38 : 0.4, /* noise grows from 0.42, 0.45, 0.46 in 1-D, 2-D, 3-D on, with block
                                            * time steps from 0.40 (1-D) and 0.41 (3-D) */
    .bytes = mfm_bytes,
    .traits = mfm_traits,
    KITH_SETTINGS(params, mfm_settings),
};
