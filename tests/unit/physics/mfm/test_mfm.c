/* test_mfm.c - package mfm. Oracle: sums over the faces of each node, with states, gradients and limiters
 * computed here from every image of every node (sph_world.h); the faces themselves are the package's, and
 * tested by test_mfm_faces.c. Also linear pressure, whose gradient is exact, and nodes on a line. */
#include "physics/mfm/riemann.h"
#include "tests/unit/physics/mfm/face_of.h"
#include "tests/unit/physics/sph_world.h"

/* The second box is thinner than most supports. */
static const int boxes[][3] = {{NDIM == 1   ? 14
                                : NDIM == 2 ? 7
                                            : 4,
                                NDIM == 2 ? 6 : 4, 3},
                               {3, NDIM == 3 ? 2 : 3, 3}};

struct form {
  enum mfm_faces_form faces;
  bool compatible;
  enum kith_traversal traversal;
  enum kith_kernel kernel;
};

/* A world with package mfm. */
static void mfm_create(struct world *w, const int *cells, enum side side, double jitter, const struct form *f,
                       uint64_t seed) {
  const struct method m = {f->kernel, KITH_VISCOSITY_NONE, f->traversal, f->compatible, 0,
                           0,         KITH_BALSARA_NONE};
  world_create(w, cells, side, jitter, &m, seed);
  char text[64];
  snprintf(text, sizeof text, "faces=%s", f->faces == MFM_FACES_ONE_POINT ? "one-point" : "integrated");
  world_package(w, "mfm", &m, text);
}

static const struct mfm_faces *faces_of(const struct world *w) {
  return w->package.self;
}

/* ---- the oracle ---- */

struct mfm_truth {
  struct truth t;
  struct partners far; /* partners within twice the supports, for integrated faces */
  double pressure_slope[MOST][NDIM], exchange[MOST];
  double kept[MOST]; /* s of (6) */
};

static void gradient_of(const struct world *w, struct mfm_truth *m, int i, const double *q, double *slope) {
  const struct partners *p = &m->t.partners;
  double moment[NDIM][NDIM] = {{0}}, flux[NDIM][NDIM] = {{0}};
  for (size_t k = p->first[i]; k < p->first[i + 1]; ++k) {
    const struct partner *one = &p->partner[k];
    const double mean = (m->t.support[i] + m->t.support[one->node]) / 2, near = one->r / mean;
    const double weight =
        (NDIM == 1 ? oracle_w(&w->kernel, near) : -oracle_g(&w->kernel, near)) / (mean * mean);
    for (int a = 0; a < NDIM; ++a) {
      flux[a][0] -= weight * (q[one->node] - q[i]) * one->x[a];
      for (int b = 0; b < NDIM; ++b) moment[a][b] += weight * one->x[a] * one->x[b];
    }
  }
  truth_even(moment);
  truth_solve(NDIM, moment, NDIM, flux);
  for (int a = 0; a < NDIM; ++a) slope[a] = flux[a][0];
}

/* L of equation (4), by its bounds. */
static double limit(double slope, double difference) {
  const double low = fmin(-difference, 1.5 * difference), high = fmax(-difference, 1.5 * difference);
  return fmin(fmax(slope, low), high);
}

/* The state at the face: extrapolated from `node` (or its image with these signs) along d, limited by the
 * differences `change`. */
static struct mfm_side state_of(const struct world *w, const struct mfm_truth *m, int node,
                                const double *sign, const double *d, const double *n, const double *change) {
  const struct kith_material *material = &w->hydro.material[w->nodes->list->u8[node]];
  double pressure = 0, u = 0;
  for (int a = 0; a < NDIM; ++a) {
    pressure += m->pressure_slope[node][a] * sign[a] * d[a];
    for (int b = 0; b < NDIM; ++b) u += n[a] * sign[a] * m->t.gradient[node][a][b] * sign[b] * d[b];
  }
  struct mfm_side s = {
      .gamma = material_value(material, "sound_speed") > 0 ? 1 : material_value(material, "gamma")};
  const double elastic = m->t.density[node] * m->t.sound[node] * m->t.sound[node] / s.gamma; /* P + P0 */
  s.inverse_gamma = 1 / s.gamma;
  s.density = m->t.density[node];
  const double more = fmax(0.5 * limit(pressure, change[0]), -0.5 * elastic);
  s.pressure = m->t.pressure[node] + more;
  s.sound = sqrt(s.gamma * (elastic + more) / s.density);
  s.velocity = -0.5 * change[1] + 0.5 * limit(u, change[1]);
  return s;
}

/* The partner of i at row entry e. */
static const struct partner *partner_at(const struct world *w, const struct mfm_truth *m, int i,
                                        kith_index j) {
  const double *x = w->nodes->position->f64;
  const int node = (int)(w->nodes->id->i64[j] - 100);
  for (size_t k = m->far.first[i]; k < m->far.first[i + 1]; ++k) {
    if (m->far.partner[k].node != node) continue;
    double miss = 0;
    for (int a = 0; a < NDIM; ++a) miss += fabs(x[i * NDIM + a] - x[j * NDIM + a] - m->far.partner[k].x[a]);
    if (miss < 1e-9) return &m->far.partner[k];
  }
  CHECK(false);
  return NULL;
}

static double stiffness_of(const struct world *w, int i) {
  return material_value(&w->hydro.material[w->nodes->list->u8[i]], "stiffness");
}

/* Equations (1) to (3), (5) to (6), with the faces of the package. */
static void sum_faces(const struct world *w, struct mfm_truth *m, int i) {
  const struct mfm_faces *f = faces_of(w);
  const double *v = w->hydro.velocity->f64, one[3] = {1, 1, 1};
  double force[NDIM] = {0}, rate = 0, signal = m->t.sound[i];
  const struct kith_rows *rows = rows_of_faces(f, w->it.connectivity);
  for (size_t e = rows->first[i]; e < rows->first[i + 1]; ++e) {
    const kith_index j = rows->node[e];
    double area[NDIM], n[NDIM], d[NDIM], back[NDIM], du = 0;
    face_of(f, w->it.connectivity, i, e, area);
    const double size = kith_norm(area);
    if (size == 0) continue;
    const struct partner *p = partner_at(w, m, i, j);
    if (p == NULL) return;
    for (int a = 0; a < NDIM; ++a) {
      n[a] = area[a] / size, d[a] = -p->x[a], back[a] = p->x[a];
      du += n[a] * (p->sign[a] * v[p->node * NDIM + a] - v[i * NDIM + a]);
    }
    const double dp = m->t.pressure[p->node] - m->t.pressure[i];
    const double there[] = {dp, du}, from[] = {-dp, -du};
    struct mfm_side l = state_of(w, m, i, one, d, n, there),
                    r = state_of(w, m, p->node, p->sign, back, n, from);
    const double ci = m->t.sound[i], cj = m->t.sound[p->node], mean_c = (ci + cj) / 2;
    const double approach = l.velocity - r.velocity, most = 0.2 * mean_c * fmin(1, mean_c / du);
    if (du > 0 && approach > most) /* (5) */
      l.velocity -= (approach - most) / 2, r.velocity += (approach - most) / 2;
    const double least = (m->kept[i] + m->kept[p->node]) / 4 * (-du - 8 * mean_c);
    if (least > 0 && approach < least) /* (5a) */
      l.velocity += (least - approach) / 2, r.velocity -= (least - approach) / 2;
    const double left = l.velocity - r.velocity, limited = copysign(fmin(fabs(left), 0.1 * mean_c), left),
                 less = (1 - (m->kept[i] + m->kept[p->node]) / 2) * limited; /* (6) */
    l.velocity -= less / 2, r.velocity += less / 2;
    struct mfm_star star = mfm_riemann(l, r);
    const double zero_i = stiffness_of(w, i), zero_j = stiffness_of(w, p->node);
    const double pi = m->t.pressure[i] + zero_i, pj = m->t.pressure[p->node] + zero_j;
    star.pressure = truth_tension(w, &m->t, i, p, star.pressure);
    if (star.pressure < 0) star.velocity = 0;
    signal = fmax(signal, 0.5 * (m->t.sound[i] + m->t.sound[p->node]) + fmax(0, -du));
    double heat = 0, heat_j = 0;
    for (int a = 0; a < NDIM; ++a) {
      const double push = -star.pressure * area[a], vj = p->sign[a] * v[p->node * NDIM + a];
      const double mean = (v[i * NDIM + a] + vj) / 2, star_v = mean + star.velocity * n[a];
      force[a] += push;
      heat += push * (star_v - v[i * NDIM + a]), heat_j += push * (vj - star_v);
    }
    rate += heat;
    /* Equation (3). */
    const double times_i = du > ci && pi < pj ? fmax(1, 4 * ci / du) : 4,
                 times_j = du > cj && pj < pi ? fmax(1, 4 * cj / du) : 4;
    if (heat < 0 && star.pressure + zero_i > times_i * pi)
      rate -= heat * (1 - times_i * pi / (star.pressure + zero_i));
    if (heat_j < 0 && star.pressure + zero_j > times_j * pj)
      rate += heat_j * (1 - times_j * pj / (star.pressure + zero_j));
  }
  for (int a = 0; a < NDIM; ++a) m->t.acceleration[i][a] = force[a] / w->hydro.mass->f64[i];
  truth_energy(w, &m->t, i, rate);
  m->t.signal[i] = signal;
}

/* s of (6), by the antisymmetric part of the velocity gradient. */
static double kept_of(const struct world *w, const struct mfm_truth *m, int i) {
  double divergence = 0, curl2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    divergence += m->t.gradient[i][a][a];
    for (int b = 0; b < a; ++b) {
      const double turn = m->t.gradient[i][a][b] - m->t.gradient[i][b][a];
      curl2 += turn * turn;
    }
  }
  const double h = m->t.support[i] / kith_kernel_support(w->package.kernel);
  const double compressed = fabs(divergence) + 3e-3 * m->t.sound[i] / h;
  const double factor = compressed / (compressed + sqrt(curl2));
  return factor < 1.0 / 16 ? 16 * factor * factor : factor;
}

/* All but the faces. */
static void truth_states(const struct world *w, struct mfm_truth *m) {
  const int n = w->nodes->n_internal;
  double widest = 0;
  for (int i = 0; i < n; ++i) {
    m->t.density[i] = w->hydro.mass->f64[i] * m->t.number[i];
    widest = fmax(widest, m->t.support[i]);
  }
  truth_close(w, &m->t);
  truth_gradient(w, &m->t);
  partners_find(&m->far, w, 2.3 * widest);
  for (int i = 0; i < n; ++i) {
    gradient_of(w, m, i, m->t.pressure, m->pressure_slope[i]);
    m->kept[i] = kept_of(w, m, i);
  }
}

static void truth_clear_all(struct mfm_truth *m) {
  free(m->far.partner);
  truth_clear(&m->t);
}

/* ---- the checks ---- */

static const double round_off = 1e-11; /* as for package sph */

/* away: by how many lengths of the box a node stands outside of it, alone. */
static void check_world(const struct form *form, enum side side, const int *cells, double away,
                        uint64_t seed) {
  struct world w;
  static struct mfm_truth m;
  memset(&m, 0, sizeof m);
  mfm_create(&w, cells, side, 0.3, form, seed);
  w.nodes->position->f64[0] -= away * w.length[0];
  world_prepare(&w, &m.t, &seed);
  CHECK_OK(world_evaluate(&w));
  truth_states(&w, &m);
  const int n = w.nodes->n_internal;
  for (int i = 0; i < n; ++i) sum_faces(&w, &m, i);
  CHECK_FIELD(w.hydro.density->f64, m.t.density, n, round_off);
  CHECK_FIELD(w.hydro.pressure->f64, m.t.pressure, n, round_off);
  CHECK_FIELD(kith_nodes_field_named(w.nodes, "pressure_slope")->f64, &m.pressure_slope[0][0], n * NDIM,
              round_off);
  CHECK_FIELD(w.hydro.acceleration->f64, &m.t.acceleration[0][0], n * NDIM, round_off);
  CHECK_FIELD(w.hydro.energy_rate->f64, m.t.rate, n, round_off);
  CHECK_FIELD(w.package.signal->f64, m.t.signal, n, round_off);
  truth_check_kick(&w, &m.t, round_off);
  if (side == PERIODIC) world_momentum(&w, 0, 1e-12);
  truth_clear_all(&m);
  world_destroy(&w);
}

static void check_worlds(void) {
  uint64_t seed = 1;
  for (int side = OPEN; side <= REFLECTING; ++side)
    for (int k = 0; k < 8; ++k) {
      const struct form form = {(enum mfm_faces_form)(k & 1), (k & 2) != 0,
                                k & 4 ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER,
                                (enum kith_kernel)((k + side) % KITH_N_KERNELS)};
      const int *cells = boxes[side != OPEN && (k + side) % 3 == 0];
      if (NDIM == 3 && (k + k / 4 + side) % 2 != 0) continue; /* half of them, to save time */
      check_world(&form, side, cells, 0, ++seed);
    }
  for (int k = 0; k < 2; ++k) {
    const struct form form = {MFM_FACES_ONE_POINT, true, k == 0 ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER,
                              KITH_KERNEL_quintic};
    check_world(&form, OPEN, boxes[0], 2, ++seed);
  }
}

/* Makes all lists an ideal gas at rest, of pressure p + g . x. */
static void make_gas(struct world *w, double pressure, const double *g) {
  const struct kith_material gas = material_of("ideal", "gamma=1.6666666666666667");
  for (int l = 0; l < 3; ++l) w->hydro.material[l] = gas;
  memset(w->hydro.velocity->f64, 0, (size_t)(w->nodes->n_internal * NDIM) * sizeof(double));
  world_base(w);
  CHECK_OK(kith_integrator_start(&w->it)); /* computes densities */
  for (int i = 0; i < w->nodes->n_internal; ++i) {
    double p = pressure;
    for (int a = 0; a < NDIM; ++a) p += g[a] * w->nodes->position->f64[i * NDIM + a];
    w->hydro.energy->f64[i] = p / (2. / 3 * w->hydro.density->f64[i]);
  }
  CHECK_OK(world_evaluate(w));
}

/* The gradient of a linear pressure is exact on any nodes, also at the edge of an open box. */
static void check_linear(enum kith_kernel kernel) {
  const double g[3] = {0.07, -0.05, 0.03};
  const struct form form = {MFM_FACES_ONE_POINT, true, KITH_TRAVERSE_PAIRS, kernel};
  struct world w;
  mfm_create(&w, boxes[0], OPEN, 0.2, &form, 5);
  make_gas(&w, 2, g);
  for (int i = 0; i < w.nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) /* tolerance: round-off 1e-16 P times a condition of 60, and sums */
      CHECK_CLOSE(kith_nodes_field_named(w.nodes, "pressure_slope")->f64[i * NDIM + a], g[a], 1e-12);
  CHECK(w.package.fallbacks == 0);
  world_destroy(&w);
}

/* Between nodes with predicted energies below 0, too, the heats of a pair are the work of its force. */
static void check_below_zero(void) {
  const double g[3] = {0};
  const struct form form = {MFM_FACES_ONE_POINT, true, KITH_TRAVERSE_PAIRS, KITH_KERNEL_cubic};
  struct world w;
  mfm_create(&w, boxes[0], OPEN, 0.2, &form, 5);
  make_gas(&w, -2, g);
  uint64_t seed = 7;
  for (int k = 0; k < w.nodes->n_internal * NDIM; ++k) w.hydro.velocity->f64[k] = check_random(&seed);
  world_base(&w);
  CHECK_OK(world_evaluate(&w));
  double sum = 0, scale = 0;
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    const double mass = w.hydro.mass->f64[i], heat = mass * w.hydro.energy_rate->f64[i],
                 work =
                     mass * kith_dot(w.hydro.velocity->f64 + i * NDIM, w.hydro.acceleration->f64 + i * NDIM);
    sum += heat + work, scale += fabs(heat) + fabs(work);
  }
  CHECK_CLOSE(sum, 0, 1e-13 * scale);
  world_destroy(&w);
}

/* Gas that expands loses heat at about the rate P div v, however cold it is: faces whose reconstructed
 * velocities approach each other take no more (without (5) a million times as much). */
static void check_cold_expansion(void) {
  const double g[3] = {0}, pressure = 1e-10;
  const struct form form = {MFM_FACES_ONE_POINT, true, KITH_TRAVERSE_PAIRS, KITH_KERNEL_cubic};
  struct world w;
  mfm_create(&w, boxes[0], OPEN, 0.2, &form, 5);
  make_gas(&w, pressure, g);
  for (int k = 0; k < w.nodes->n_internal * NDIM; ++k) {
    const double x = w.nodes->position->f64[k];
    w.hydro.velocity->f64[k] = x * x; /* all x > 0: nodes recede, the faster the farther out */
  }
  world_base(&w);
  CHECK_OK(world_evaluate(&w));
  double most = 0;
  for (int i = 0; i < w.nodes->n_internal; ++i)
    most = fmax(most, -w.hydro.energy_rate->f64[i] * w.hydro.density->f64[i] / pressure);
  CHECK(most < 100);
  world_destroy(&w);
}

/* Above 1-D, nodes on a line have no gradient of the velocity. */
static void check_line(void) {
  const int cells[3] = {9, 1, 1};
  const struct form form = {MFM_FACES_ONE_POINT, true, KITH_TRAVERSE_PAIRS, KITH_KERNEL_cubic};
  struct world w;
  mfm_create(&w, cells, OPEN, 0, &form, 5);
  /* the stiffened material is so thin that it is torn apart */
  for (int l = 0; l < w.nodes->n_lists; ++l) w.hydro.material[l].cut = true;
  CHECK_OK(kith_integrator_start(&w.it));
  CHECK(NDIM == 1 ? w.package.fallbacks == 0 : w.package.fallbacks >= 9);
  for (int k = 0; k < w.nodes->n_internal * NDIM; ++k) CHECK(isfinite(w.hydro.acceleration->f64[k]));
  world_destroy(&w);
}

int main(void) {
  check_worlds();
  for (int k = 0; k < KITH_N_KERNELS; ++k) check_linear((enum kith_kernel)k);
  check_below_zero();
  check_cold_expansion();
  check_line();
  return check_failed();
}
