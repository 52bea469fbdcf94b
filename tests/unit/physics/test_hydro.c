/* test_hydro.c - the state that packages share: pressures and sound speeds (against formulas), totals
 * (against long double sums, and bitwise for 1 to 3 threads), and unphysical values, each of which must be
 * found and named. */
#include <omp.h>
#include <string.h>
#include "lib/core/vec.h"
#include "physics/hydro.h"
#include "tests/check.h"
#include "tests/unit/materials.h"

static const char *const names[] = {"gas", "water"};

struct state {
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
};

static struct state make_state(kith_index n0, kith_index n1) {
  struct state s = {0};
  uint64_t seed = 12;
  CHECK_OK(kith_nodes_create(&s.nodes, 2, names));
  CHECK_OK(kith_hydro_init(&s.hydro, s.nodes));
  CHECK_OK(kith_nodes_append(s.nodes, 0, n0, NULL));
  CHECK_OK(kith_nodes_append(s.nodes, 1, n1, NULL));
  s.hydro.material[0] = material_of("ideal", "gamma=1.4");
  s.hydro.material[1] = material_of("isothermal", "sound_speed=3");
  for (kith_index i = 0; i < n0 + n1; ++i) {
    s.nodes->id->i64[i] = 50000 + i;
    for (int a = 0; a < NDIM; ++a) {
      s.nodes->position->f64[i * NDIM + a] = check_random(&seed);
      s.hydro.velocity->f64[i * NDIM + a] = check_random(&seed) - 0.4;
    }
    s.hydro.mass->f64[i] = 0.1 + pow(10, 3 * check_random(&seed));
    s.hydro.energy->f64[i] = check_random(&seed);
    s.hydro.density->f64[i] = 1 + check_random(&seed);
    s.hydro.sound_speed->f64[i] = 1 + check_random(&seed);
  }
  for (int a = 0; a < NDIM; ++a) s.hydro.center[a] = 0.4 + 0.1 * a;
  return s;
}

static bool identical(const struct kith_totals *a, const struct kith_totals *b) {
  return memcmp(a, b, sizeof *a) == 0;
}

static void check_totals(kith_index n0, kith_index n1) {
  struct state s = make_state(n0, n1);
  long double mass = 0, kinetic = 0, internal = 0, scale = 0, momentum[NDIM] = {0};
  long double angular[3] = {0}, angular_scale = 0, fastest = 0;
  for (kith_index i = 0; i < n0 + n1; ++i) {
    const long double m = s.hydro.mass->f64[i];
    long double v2 = 0;
    for (int a = 0; a < NDIM; ++a) {
      const long double v = s.hydro.velocity->f64[i * NDIM + a];
      v2 += v * v;
      momentum[a] += m * v;
    }
    const double *const x = s.nodes->position->f64 + i * NDIM, *const v = s.hydro.velocity->f64 + i * NDIM;
    const long double r[3] = {(long double)x[0] - 0.4, NDIM > 1 ? (long double)x[NDIM > 1] - 0.5 : 0,
                              NDIM > 2 ? (long double)x[NDIM - 1] - (0.4 + 0.1 * 2) : 0};
    const long double w[3] = {v[0], NDIM > 1 ? v[NDIM > 1] : 0, NDIM > 2 ? v[NDIM - 1] : 0};
    const long double turn[3] = {r[1] * w[2] - r[2] * w[1], r[2] * w[0] - r[0] * w[2],
                                 r[0] * w[1] - r[1] * w[0]};
    for (int a = 0; a < 3; ++a) angular[a] += m * turn[a];
    angular_scale += m * sqrtl(turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2]);
    fastest = fmaxl(fastest, sqrtl(v2) / s.hydro.sound_speed->f64[i]);
    mass += m, kinetic += m * v2 / 2, internal += m * s.hydro.energy->f64[i],
        scale += m * fmaxl(sqrtl(v2), s.hydro.sound_speed->f64[i]);
  }
  const int threads = omp_get_max_threads();
  struct kith_totals t[3];
  for (int k = 0; k < 3; ++k) {
    omp_set_num_threads(k + 1);
    t[k] = kith_hydro_totals(&s.hydro);
  }
  omp_set_num_threads(threads);
  CHECK(identical(&t[0], &t[1]) && identical(&t[0], &t[2]));
  /* A running sum of at most 4096 positive terms errs by less than 4096 / 2 roundings, usually by their
   * square root. */
  CHECK_CLOSE(t[0].mass, (double)mass, 1e-13 * (double)mass);
  CHECK_CLOSE(t[0].kinetic, (double)kinetic, 1e-13 * (double)kinetic);
  CHECK_CLOSE(t[0].internal, (double)internal, 1e-13 * (double)internal);
  CHECK_CLOSE(t[0].momentum_scale, (double)scale, 1e-13 * (double)scale);
  for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(t[0].momentum[a], (double)momentum[a], 1e-13 * (double)scale);
  for (int a = 0; a < 3; ++a) CHECK_CLOSE(t[0].angular[a], (double)angular[a], 1e-13 * (double)angular_scale);
  CHECK_CLOSE(t[0].angular_scale, (double)angular_scale, 1e-13 * (double)angular_scale);
  CHECK_CLOSE(t[0].velocity_over_sound, (double)fastest, 1e-15 * (double)fastest);
  kith_nodes_destroy(&s.nodes);
}

/* Gas without a sound speed: the Mach number is 0 at rest, and infinite in any motion. */
static void check_without_sound(void) {
  struct state s = make_state(3, 0);
  for (int i = 0; i < 3; ++i) s.hydro.sound_speed->f64[i] = 0;
  for (int k = 0; k < 3 * NDIM; ++k) s.hydro.velocity->f64[k] = 0;
  CHECK(kith_hydro_totals(&s.hydro).velocity_over_sound == 0);
  s.hydro.velocity->f64[NDIM] = 1e-9;
  CHECK(isinf(kith_hydro_totals(&s.hydro).velocity_over_sound));
  kith_nodes_destroy(&s.nodes);
}

static void check_eos(void) {
  struct state s = make_state(5, 4);
  kith_hydro_evaluate_eos(&s.hydro);
  for (int i = 0; i < 9; ++i) {
    const double rho = s.hydro.density->f64[i], u = s.hydro.energy->f64[i];
    CHECK_CLOSE(s.hydro.pressure->f64[i], i < 5 ? 0.4 * rho * u : 9 * rho, 1e-14);
    CHECK_CLOSE(s.hydro.sound_speed->f64[i], i < 5 ? sqrt(1.4 * 0.4 * u) : 3, 1e-14);
  }
  kith_nodes_destroy(&s.nodes);
}

/* Breaks `value` of node i: the message must contain `word` and name this node, even if a later one is wrong,
 * too. */
static void check_broken(struct state *s, double *value, double wrong, kith_index i, const char *word) {
  char id[32];
  const kith_index later = KITH_MIN(i + 700, s->nodes->n_internal - 1);
  const double good = *value, good_later = s->hydro.density->f64[later];
  *value = wrong;
  if (later > i) s->hydro.density->f64[later] = -1;
  CHECK_STATUS(word != NULL ? KITH_DIVERGED : KITH_OK, kith_hydro_physical(&s->hydro));
  snprintf(id, sizeof id, "node %d ", 50000 + i);
  if (word != NULL) CHECK(strstr(kith_failure(), word) != NULL && strstr(kith_failure(), id) != NULL);
  *value = good, s->hydro.density->f64[later] = good_later;
}

static void check_physical(void) {
  struct state s = make_state(900, 600);
  const struct kith_hydro *h = &s.hydro;
  CHECK_OK(kith_hydro_physical(h));
  for (int k = 0; k < 3; ++k) {
    const kith_index i = k == 0 ? 0 : k == 1 ? 450 : 1200;
    const kith_index component = i * NDIM + k % NDIM;
    check_broken(&s, &s.nodes->position->f64[component], NAN, i, "position");
    check_broken(&s, &h->velocity->f64[component], -INFINITY, i, "velocity");
    check_broken(&s, &h->acceleration->f64[component], NAN, i, "acceleration");
    check_broken(&s, &h->energy->f64[i], INFINITY, i, "energy is not finite");
    check_broken(&s, &h->energy->f64[i], NAN, i, "energy is not finite");
    check_broken(&s, &h->density->f64[i], 0, i, "density");
    check_broken(&s, &h->density->f64[i], -1, i, "density");
    check_broken(&s, &h->density->f64[i], NAN, i, "density");
    check_broken(&s, &h->density->f64[i], INFINITY, i, "density");
    const double *v = h->velocity->f64 + i * NDIM;
    if (i < 900) check_broken(&s, &h->energy->f64[i], -1e-14 * kith_dot(v, v), i, "energy is negative");
  }
  /* The energy of an isothermal gas has no effect, so it may be negative; zero is allowed for all. */
  check_broken(&s, &h->energy->f64[1499], -1, 1499, NULL);
  h->energy->f64[3] = 0;
  CHECK_OK(kith_hydro_physical(h));
  /* So is what the round-off of the kinetic energy takes from it. */
  double *v = h->velocity->f64 + 3 * NDIM;
  h->energy->f64[3] = -1e-16 * kith_dot(v, v);
  CHECK_OK(kith_hydro_physical(h));
  for (int a = 0; a < NDIM; ++a) v[a] = 0;
  check_broken(&s, &h->energy->f64[3], -1e-300, 3, "energy is negative");
  kith_nodes_destroy(&s.nodes);
}

int main(void) {
  check_totals(0, 0);
  check_totals(1, 0);
  check_totals(4000, 96);
  check_totals(4096, 1);
  check_totals(9000, 12000);
  check_without_sound();
  check_eos();
  check_physical();
  return check_failed();
}
