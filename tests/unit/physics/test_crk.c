/* test_crk.c - package crk. Oracle: sums over all images of all nodes (sph_world.h), with corrected kernels
 * by elimination of the full moment matrix and of its derivative, and forces and work by the sums of the
 * header. Also identities of corrected kernels, gas at rest, and nodes in lines and flat bars. */
#include "tests/unit/physics/sph_world.h"

/* Sums of a few hundred terms; moment matrices of random nodes have conditions of 1e2 and more. */
static const double round_off = 1e-10;

/* Coefficients c of W^R = (c_0 + c . x) W, and their derivatives along each axis. */
enum { ROWS = NDIM + 1 };
struct kernels {
  double c[MOST][ROWS], dc[MOST][NDIM][ROWS];
  double change[MOST], smooth[MOST]; /* the change of spacing, and s of equation (5) */
  double evened[MOST];               /* s of truth_even */
};
static const double self_weight = NDIM < 3 ? 1.5 : 2;

/* A world with package crk. */
static void create(struct world *w, const int *cells, enum side side, double jitter, const struct method *m,
                   uint64_t seed) {
  world_create(w, cells, side, jitter, m, seed);
  world_viscous(w, "crk", m);
}

/* ---- the oracle ---- */

static double volume(const struct world *w, double support) {
  return oracle_ball() * pow(support, NDIM) / w->package.neighbors;
}

/* W, and the factor of x in its gradient; both are means over the supports of the pair. */
static void kernel_of(const struct world *w, double hi, double hj, double r, double *value, double *factor) {
  const double c = w->kernel.constant;
  *value =
      c / 2 * (oracle_w(&w->kernel, r / hi) / pow(hi, NDIM) + oracle_w(&w->kernel, r / hj) / pow(hj, NDIM));
  *factor =
      c / 2 *
      (oracle_g(&w->kernel, r / hi) / pow(hi, NDIM + 2) + oracle_g(&w->kernel, r / hj) / pow(hj, NDIM + 2));
}

/* c solves M c = (1, 0, ..) with M = sum_j V_j W p p and p = (1, x), whose second moments are made more
 * isotropic; dc solves M dc = -dM c. */
static void truth_kernel(const struct world *w, const struct truth *t, int i, struct kernels *out) {
  double m[ROWS][ROWS] = {{0}}, dm[NDIM][ROWS][ROWS] = {{{0}}}, copy[ROWS][ROWS];
  double flux[NDIM] = {0}, change2 = 0, trace = 0;
  m[0][0] = self_weight * t->self * volume(w, t->support[i]) * w->kernel.constant / pow(t->support[i], NDIM) *
            oracle_w(&w->kernel, 0);
  const double own = m[0][0];
  for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
    const struct partner *p = &t->partners.partner[k];
    double value, factor, base[ROWS] = {1};
    kernel_of(w, t->support[i], t->support[p->node], p->r, &value, &factor);
    value *= volume(w, t->support[p->node]), factor *= volume(w, t->support[p->node]);
    const double hi = t->support[i], hj = t->support[p->node], g = oracle_g(&w->kernel, p->r / hi);
    trace += g * p->r * p->r;
    for (int a = 0; a < NDIM; ++a) {
      base[a + 1] = p->x[a];
      flux[a] += g * p->x[a] * 2 * (hi - hj) / (hi + hj);
    }
    for (int a = 0; a < ROWS; ++a)
      for (int b = 0; b < ROWS; ++b) {
        m[a][b] += value * base[a] * base[b];
        for (int c = 0; c < NDIM; ++c)
          dm[c][a][b] += factor * base[c + 1] * base[a] * base[b] +
                         value * ((a == c + 1) * base[b] + (b == c + 1) * base[a]);
      }
  }
  for (int c = 0; c < NDIM; ++c) dm[c][0][c + 1] += own, dm[c][c + 1][0] += own; /* x W of i itself */
  double second[NDIM][NDIM];
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) second[a][b] = m[a + 1][b + 1];
  out->evened[i] = truth_even(second);
  for (int a = 0; a < NDIM; ++a)
    for (int b = 0; b < NDIM; ++b) m[a + 1][b + 1] = second[a][b];
  memset(out->c[i], 0, sizeof out->c[i]);
  out->c[i][0] = 1;
  memcpy(copy, m, sizeof m);
  truth_solve(ROWS, copy, 1, (double(*)[1])out->c[i]);
  for (int c = 0; c < NDIM; ++c) {
    for (int a = 0; a < ROWS; ++a) {
      out->dc[i][c][a] = 0;
      for (int b = 0; b < ROWS; ++b) out->dc[i][c][a] -= dm[c][a][b] * out->c[i][b];
    }
    memcpy(copy, m, sizeof m);
    truth_solve(ROWS, copy, 1, (double(*)[1])out->dc[i][c]);
  }
  for (int a = 0; a < NDIM; ++a) change2 += flux[a] * flux[a];
  const double spacing = t->support[i] / pow(w->package.neighbors / oracle_ball(), 1.0 / NDIM);
  /* |grad ln H| if neighbors are evenly distributed */
  out->change[i] = NDIM * spacing * sqrt(change2) / fabs(trace);
  out->smooth[i] = 1 / (1 + pow(out->change[i] / 0.4, 4));
}

/* Gradient of the corrected kernel with coefficients c, dc at separation x; the node may be an image with
 * these signs. */
static void corrected(const double *c, double (*dc)[ROWS], const double *sign, const double *x, double value,
                      double factor, double *gradient) {
  double crk_a = c[0];
  for (int a = 0; a < NDIM; ++a) crk_a += c[a + 1] * sign[a] * x[a];
  for (int a = 0; a < NDIM; ++a) {
    double change = dc[a][0] + c[a + 1];
    for (int b = 0; b < NDIM; ++b) change += dc[a][b + 1] * sign[b] * x[b];
    gradient[a] = sign[a] * change * value + crk_a * factor * x[a];
  }
}

/* The factor of x in -P V^2 / Omega (grad W)(H) of node k, with pressure P. */
static double sph_push(const struct world *w, const struct truth *t, int k, double pressure, double r) {
  const double h = t->support[k], v = volume(w, h);
  return -pressure * v * v / t->omega[k] * w->kernel.constant * oracle_g(&w->kernel, r / h) /
         pow(h, NDIM + 2);
}

/* Forces, energy rates and signal speeds. */
static void crk_rates(const struct world *w, struct truth *t, struct kernels *kernels) {
  const double *v = w->hydro.velocity->f64, one[3] = {1, 1, 1};
  const bool viscous = w->viscosity.name != KITH_VISCOSITY_NONE;
  const double alpha = viscous ? w->viscosity.alpha : 0, beta = viscous ? w->viscosity.beta : 0;
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double force[NDIM] = {0}, heat = 0, signal = t->sound[i];
    for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
      const struct partner *p = &t->partners.partner[k];
      const int j = p->node;
      double value, factor, gi[NDIM], gj[NDIM], back[NDIM], f[NDIM], ff = 0, vv = 0, fv = 0;
      if (p->r >= fmax(t->support[i], t->support[j])) continue;
      kernel_of(w, t->support[i], t->support[j], p->r, &value, &factor);
      for (int a = 0; a < NDIM; ++a) back[a] = -p->x[a];
      corrected(kernels->c[i], kernels->dc[i], one, p->x, value, factor, gi);
      corrected(kernels->c[j], kernels->dc[j], p->sign, back, value, factor, gj);
      const double mu = truth_jump(w, t, i, p), sound = (t->sound[i] + t->sound[j]) / 2;
      const double rho = 2 / (1 / t->density[i] + 1 / t->density[j]);
      const double q = rho * truth_viscous(w, t, i, j, mu);
      const double smooth = fmin(kernels->smooth[i], kernels->smooth[j]);
      const double volumes = volume(w, t->support[i]) * volume(w, t->support[j]);
      const double pi = truth_tension(w, t, i, p, t->pressure[i]),
                   pj = truth_tension(w, t, i, p, t->pressure[j]), total = pi + pj + q;
      for (int a = 0; a < NDIM; ++a) {
        f[a] = -0.5 * smooth * volumes * total * (gi[a] - gj[a]);
        const double jump = p->sign[a] * v[j * NDIM + a] - v[i * NDIM + a];
        force[a] += f[a];
        ff += f[a] * f[a], vv += jump * jump, fv += f[a] * jump;
      }
      const double cosine = ff * vv > 0 ? fv / sqrt(ff) / sqrt(vv) : 0;
      const double shared = fv < 0 ? pi + pj : total; /* cooling is not of Q */
      const double d = (pj - pi) / shared;
      const double steep = fabs(cosine) + (1 - fabs(cosine)) * fmax(0, 1 - d * d); /* 0: no work */
      const double share = 0.5 + (steep > 0 ? d * cosine / (2 * steep) : 0);
      heat += share * fv;
      const double own = sph_push(w, t, i, pi, p->r), other = sph_push(w, t, j, pj, p->r),
                   central = -volumes * q * factor;
      for (int a = 0; a < NDIM; ++a) {
        const double jump = p->sign[a] * v[j * NDIM + a] - v[i * NDIM + a];
        force[a] += (1 - smooth) * (own + other + central) * p->x[a];
        heat += (1 - smooth) * (own + 0.5 * central) * p->x[a] * jump;
      }
      if (p->r > 0) signal = fmax(signal, fmax(1, (1 + 0.6 * alpha) / 1.6) * sound - beta * mu);
    }
    const double mass = w->hydro.mass->f64[i];
    for (int a = 0; a < NDIM; ++a) t->acceleration[i][a] = force[a] / mass;
    truth_energy(w, t, i, heat);
    t->signal[i] = signal;
  }
}

static void crk_truth(const struct world *w, struct truth *t, struct kernels *kernels) {
  truth_density(w, t);
  for (int i = 0; i < w->nodes->n_internal; ++i)
    t->density[i] = w->hydro.mass->f64[i] / volume(w, t->support[i]);
  truth_close(w, t);
  truth_gradient(w, t);
  for (int i = 0; i < w->nodes->n_internal; ++i) truth_kernel(w, t, i, kernels);
  crk_rates(w, t, kernels);
}

/* ---- comparisons ---- */

static const double *field(const struct world *w, const char *name) {
  return kith_nodes_field_named(w->nodes, name)->f64;
}

static void check_kernels(const struct world *w, const struct kernels *k) {
  static double crk_a[MOST], slope[MOST * NDIM], gradient[MOST * NDIM], tensor[MOST * NDIM * NDIM];
  const int n = w->nodes->n_internal;
  for (int i = 0; i < n; ++i) {
    crk_a[i] = k->c[i][0];
    for (int a = 0; a < NDIM; ++a) {
      slope[i * NDIM + a] = k->c[i][a + 1];
      gradient[i * NDIM + a] = k->dc[i][a][0] + k->c[i][a + 1];
      for (int b = 0; b < NDIM; ++b) tensor[(i * NDIM + b) * NDIM + a] = k->dc[i][a][b + 1];
    }
  }
  CHECK_FIELD(field(w, "kernel_scale"), crk_a, n, round_off);
  CHECK_FIELD(field(w, "kernel_slope"), slope, n * NDIM, round_off);
  CHECK_FIELD(field(w, "kernel_scale_gradient"), gradient, n * NDIM, round_off);
  CHECK_FIELD(field(w, "kernel_slope_gradient"), tensor, n * NDIM * NDIM, round_off);
  CHECK_FIELD(field(w, "spacing_change"), k->change, n, round_off);
}

/* sum V W^R = 1, sum V W^R x = 0, sum V grad W^R = 0, sum V grad W^R x = -1, with the coefficients of the
 * package. */
static void check_exact(const struct world *w, const struct truth *t, const struct kernels *kernels) {
  const double *A = field(w, "kernel_scale"), *C = field(w, "kernel_slope"),
               *dA = field(w, "kernel_scale_gradient"), *dC = field(w, "kernel_slope_gradient");
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    if (kernels->evened[i] > 0) continue; /* its neighbors lie almost in a line or a plane */
    const double h = w->nodes->support->f64[i],
                 one = oracle_w(&w->kernel, 0) * w->kernel.constant / pow(h, NDIM);
    double sum = self_weight * t->self * volume(w, h) * one * A[i], first[NDIM] = {0}, g[NDIM] = {0},
           gx[NDIM][NDIM] = {{0}};
    double size = 1 / h;
    for (int a = 0; a < NDIM; ++a)
      g[a] = self_weight * t->self * volume(w, h) * one * dA[i * NDIM + a], size += fabs(g[a]);
    for (size_t k = t->partners.first[i]; k < t->partners.first[i + 1]; ++k) {
      const struct partner *p = &t->partners.partner[k];
      const double hj = w->nodes->support->f64[p->node], v = volume(w, hj);
      double value, factor, crk_a = A[i];
      kernel_of(w, h, hj, p->r, &value, &factor);
      for (int a = 0; a < NDIM; ++a) crk_a += C[i * NDIM + a] * p->x[a];
      sum += v * crk_a * value;
      for (int a = 0; a < NDIM; ++a) {
        double change = dA[i * NDIM + a];
        for (int b = 0; b < NDIM; ++b) change += dC[(i * NDIM + b) * NDIM + a] * p->x[b];
        const double one_of = v * (change * value + crk_a * factor * p->x[a]);
        first[a] += v * crk_a * value * p->x[a];
        g[a] += one_of;
        size += fabs(one_of);
        for (int b = 0; b < NDIM; ++b) gx[a][b] += one_of * p->x[b];
      }
    }
    CHECK_CLOSE(sum, 1, 1e-12);
    for (int a = 0; a < NDIM; ++a) {
      CHECK_CLOSE(first[a], 0, 1e-12 * h);
      CHECK_CLOSE(g[a], 0, 1e-12 * size); /* rounding is relative to the largest terms */
      for (int b = 0; b < NDIM; ++b) CHECK_CLOSE(gx[a][b], a == b ? -1 : 0, 1e-12 * size * h);
    }
  }
}

static void check_world(const struct method *m, enum side side, const int *cells, int form, uint64_t seed) {
  (void)form;
  static struct kernels kernels;
  struct world w;
  struct truth t = {0};
  create(&w, cells, side, 0.3, m, seed);
  if (m->balsara == KITH_BALSARA_SLOW) world_shear(&w);
  if (side == REFLECTING && NDIM > 1 && cells[0] > 3) world_touch_face(&w);
  world_prepare(&w, &t, &seed);
  crk_truth(&w, &t, &kernels);
  CHECK_OK(world_evaluate(&w));
  const int n = w.nodes->n_internal;
  check_kernels(&w, &kernels);
  check_exact(&w, &t, &kernels);
  CHECK_FIELD(w.hydro.density->f64, t.density, n, round_off);
  CHECK_FIELD(w.hydro.acceleration->f64, &t.acceleration[0][0], n * NDIM, round_off);
  CHECK_FIELD(w.hydro.energy_rate->f64, t.rate, n, round_off);
  CHECK_FIELD(field(&w, "signal"), t.signal, n, round_off);
  truth_check_kick(&w, &t, round_off);
  CHECK(w.package.fallbacks == 0);
  if (side != REFLECTING) world_momentum(&w, 1, 1e-13); /* single forces are of order 1 */
  truth_clear(&t);
  world_destroy(&w);
}

/* Uniform gas on a lattice is at rest; on displaced nodes forces are small beside P / (rho spacing) = 2/3. */
static void check_rest(double jitter, double most) {
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_GATHER, true, 1, 2,
                           KITH_BALSARA_NONE};
  struct world w;
  create(&w, world_boxes[0], PERIODIC, jitter, &m, 3);
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    w.hydro.mass->f64[i] = 2;
    for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] = 0;
    w.hydro.energy->f64[i] = 1;
  }
  for (int l = 0; l < 3; ++l) w.hydro.material[l] = w.hydro.material[0];
  CHECK_OK(kith_integrator_start(&w.it));
  CHECK(largest(w.hydro.acceleration->f64, w.nodes->n_internal * NDIM) <= most);
  world_destroy(&w);
}

/* If every other node is displaced by 1e-6, forces restore the lattice: this is the purpose of the self
 * weight. */
static void check_sawtooth(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k) {
    const struct method m = {(enum kith_kernel)k, KITH_VISCOSITY_NONE, KITH_TRAVERSE_GATHER, true, 0, 0,
                             KITH_BALSARA_NONE};
    const int cells[3] = {8, 4, 4};
    struct world w;
    create(&w, cells, PERIODIC, 0, &m, 3);
    for (int i = 0; i < w.nodes->n_internal; ++i) {
      double *x = &w.nodes->position->f64[i * NDIM];
      w.hydro.mass->f64[i] = 1;
      w.hydro.energy->f64[i] = 1;
      for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] = 0;
      x[0] += (int)floor(x[0]) % 2 == 0 ? 1e-6 : -1e-6;
    }
    for (int l = 0; l < 3; ++l) w.hydro.material[l] = w.hydro.material[0];
    CHECK_OK(kith_integrator_start(&w.it));
    for (int i = 0; i < w.nodes->n_internal; ++i)
      CHECK((int)floor(w.nodes->position->f64[i * NDIM]) % 2 == 0 ? w.hydro.acceleration->f64[i * NDIM] < 0
                                                                  : w.hydro.acceleration->f64[i * NDIM] > 0);
    world_destroy(&w);
  }
}

/* Above 1-D, nodes on a line have no gradient of the velocity: results are finite, and such nodes are
 * counted. */
static void check_collinear(void) {
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_GATHER, true, 1, 2,
                           KITH_BALSARA_NONE};
  const int line[3] = {40, 1, 1};
  struct world w;
  create(&w, line, OPEN, 0, &m, 3);
  for (int l = 0; l < 3; ++l) w.hydro.material[l] = w.hydro.material[0];
  CHECK_OK(kith_integrator_start(&w.it));
  w.package.fallbacks = 0;
  CHECK_OK(world_evaluate(&w));
  CHECK(w.package.fallbacks == (NDIM == 1 ? 0u : 40u)); /* of the velocity gradient */
  for (int k = 0; k < 40 * NDIM; ++k) CHECK(isfinite(w.hydro.acceleration->f64[k]));
  world_momentum(&w, 1, 1e-13); /* single forces are of order 1 */
  world_destroy(&w);
}

/* A flattened bar, whose moments are made more isotropic. Moments are summed over all partners. */
static void check_flat(void) {
#if NDIM > 1
  const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_GATHER, true, 1, 2,
                           KITH_BALSARA_NONE};
  const int bar[3] = {16, 2, 2};
  int whole = 0, part = 0, most = 0;
  for (double flat = 1; flat > (NDIM == 2 ? 0.02 : 0.06); flat *= 0.8) {
    struct world w;
    struct truth t = {0};
    create(&w, bar, OPEN, 0.2, &m, 3);
    for (int i = 0; i < w.nodes->n_internal; ++i)
      for (int a = 1; a < NDIM; ++a) w.nodes->position->f64[i * NDIM + a] *= flat;
    truth_density(&w, &t);
    world_root(&w, &t);
    CHECK_OK(world_evaluate(&w));
    CHECK(w.package.fallbacks == 0);
    const double *A = field(&w, "kernel_scale"), *C = field(&w, "kernel_slope");
    for (int i = 0; i < w.nodes->n_internal; ++i) {
      double m0 = self_weight * t.self * volume(&w, t.support[i]) * w.kernel.constant /
                  pow(t.support[i], NDIM) * oracle_w(&w.kernel, 0);
      double m1[NDIM] = {0}, m2[NDIM][NDIM] = {{0}}, b[NDIM][1], solved[NDIM][NDIM];
      for (size_t k = t.partners.first[i]; k < t.partners.first[i + 1]; ++k) {
        const struct partner *p = &t.partners.partner[k];
        double value, factor;
        kernel_of(&w, t.support[i], t.support[p->node], p->r, &value, &factor);
        value *= volume(&w, t.support[p->node]);
        m0 += value;
        for (int a = 0; a < NDIM; ++a) {
          m1[a] += value * p->x[a];
          for (int c = 0; c < NDIM; ++c) m2[a][c] += value * p->x[a] * p->x[c];
        }
      }
      const double s = truth_even(m2);
      ++*(s == 0 ? &whole : s < 0.9 ? &part : &most);
      for (int a = 0; a < NDIM; ++a) b[a][0] = -m1[a];
      memcpy(solved, m2, sizeof m2);
      truth_solve(NDIM, solved, 1, b);
      double sum = m0;
      for (int a = 0; a < NDIM; ++a) sum += b[a][0] * m1[a];
      CHECK_CLOSE(A[i], 1 / sum, 1e-12 / m0);
      for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(C[i * NDIM + a], b[a][0] / sum, 1e-12 / (m0 * flat));
    }
    truth_clear(&t);
    world_destroy(&w);
  }
  CHECK(whole > 20 && part > 20 && most > 20);
#endif
}

/* Two nodes among their images. */
static void check_two(void) {
  const struct method m = {KITH_KERNEL_cubic, KITH_VISCOSITY_LIMITED, KITH_TRAVERSE_PAIRS, true, 1, 2,
                           KITH_BALSARA_NONE};
  const int two[3] = {2, 1, 1};
  struct world w;
  create(&w, two, PERIODIC, 0.1, &m, 1);
  CHECK_OK(kith_integrator_start(&w.it));
  world_momentum(&w, 1, 1e-13); /* single forces are of order 1 */
  world_destroy(&w);
}

/* Settings that crk lacks are refused. */
static void check_refused(void) {
  static const char *const wrong[] = {"viscosity.name=cullen-dehnen", "conduction=1"};
  for (int k = 0; k < 2; ++k) {
    void *settings = NULL;
    CHECK_STATUS(KITH_BAD_INPUT,
                 kith_settings_create(&settings, kith_family_member(kith_package_member, "crk"), wrong[k]));
    CHECK(settings == NULL && strstr(kith_failure(), "crk") != NULL);
  }
}

int main(void) {
  worlds(check_world);
  check_rest(0, 1e-12);
  check_rest(0.2, 0.3);
  check_sawtooth();
  check_collinear();
  check_flat();
  check_two();
  check_refused();
  return check_failed();
}
