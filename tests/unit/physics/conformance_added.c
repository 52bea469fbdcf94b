/* conformance_added.c - every added package, on top of every hydro package: momentum and energy are conserved
 * to round-off, and rates do not depend on traversal, threads, frame of reference or the order of packages.
 * Packages that add rates raise the entropy and add exactly nothing to gas of one velocity and temperature;
 * packages that couple pairs change nothing if no node is damaged. The oracle is in each case the same gas
 * without the package, or evaluated in another way. */
#include "tests/unit/physics/added_world.h"
#include "tests/unit/physics/invariances.h"

static const int box[3] = {NDIM == 1 ? 15 : NDIM == 2 ? 7 : 5, NDIM == 2 ? 6 : 4, 3};
enum { ADDED = KITH_ADDED_PACKAGES };

/* The packages after the hydro package: `member` numbers members of the family. */
struct variant {
  const char *hydro;
  int n, member[ADDED];
  struct method method;
};

/* Coefficients that make the added rates about as large as those of the gas. */
static void settings_of(const struct kith_package_ops *ops, char *text, size_t size) {
  text[0] = '\0';
  for (const struct kith_param *p = ops->params; p != NULL && p->key != NULL; ++p)
    if (p->fallback == NULL) snprintf(text + strlen(text), size - strlen(text), " %s=0.7", p->key);
}

static void attach(struct world *w, const struct variant *v, struct added added[ADDED]) {
  char text[200];
  world_package(w, v->hydro, &v->method, "");
  for (int k = 0; k < v->n; ++k) {
    const struct kith_package_ops *ops = kith_added_all()[v->member[k]];
    settings_of(ops, text, sizeof text);
    added_attach(&added[k], w, ops->name, text);
  }
}

static bool couples(const struct variant *v) {
  bool any = false;
  for (int k = 0; k < v->n; ++k) any = any || kith_added_all()[v->member[k]]->couple != NULL;
  return any;
}

/* Leaves out packages that add rates. */
static struct variant without_rates(const struct variant *v) {
  struct variant out = *v;
  out.n = 0;
  for (int k = 0; k < v->n; ++k)
    if (kith_added_all()[v->member[k]]->evaluate == NULL) out.member[out.n++] = v->member[k];
  return out;
}

/* A few nodes are sound, a few broken, most between; or all are sound. */
static void create_damaged(struct world *w, const struct variant *v, enum side side,
                           struct added added[ADDED], bool sound) {
  static const struct kith_field_spec spec = {"damage", KITH_SCALAR, KITH_F64, KITH_STATE, NULL, "D"};
  struct kith_field *damage;
  world_create(w, box, side, 0.3, &v->method, 77);
  if (couples(v)) {
    CHECK_OK(kith_nodes_field(w->nodes, &spec, &damage));
    for (int i = 0; i < w->nodes->n_internal; ++i) {
      const double d = 1.2 * fmod(0.618 * (double)w->nodes->id->i64[i], 1) - 0.1;
      damage->f64[i] = sound ? 0 : fmin(fmax(d, 0), 1);
    }
  }
  attach(w, v, added);
}

static void create(struct world *w, const struct variant *v, enum side side, struct added added[ADDED]) {
  create_damaged(w, v, side, added, false);
}

static void destroy(struct world *w, const struct variant *v, struct added added[ADDED]) {
  added_detach(w, v->n, added);
  world_destroy(w);
}

static struct rates rates_of(const struct variant *v, const double *common) {
  struct added added[ADDED];
  struct world w;
  struct rates r;
  create(&w, v, PERIODIC, added);
  for (int k = 0; common != NULL && k < w.nodes->n_internal * NDIM; ++k)
    w.hydro.velocity->f64[k] += common[k % NDIM];
  evaluate(&w);
  store_rates(&r, &w);
  destroy(&w, v, added);
  return r;
}

/* Tolerances cover the round-off of sums, relative to the largest value. */
static void compare(const struct rates *got, const struct rates *wanted, double tolerance) {
  CHECK_FIELD(got->acceleration, wanted->acceleration, wanted->n * NDIM, tolerance);
  CHECK_FIELD(got->rate, wanted->rate, wanted->n, tolerance);
}

/* ---- conservation ---- */

static void check_conservation(const struct variant *v, enum side side, const char *scheme) {
  struct added added[ADDED];
  struct world w;
  create(&w, v, side, added);
  evaluate(&w);
  check_rates_conserve(&w);
  check_steps_conserve(&w, scheme);
  destroy(&w, v, added);
}

/* What it adds raises the entropy: sum m du/T > 0, where T = u. */
static void check_second_law(const struct variant *v) {
  const struct variant alone = without_rates(v);
  struct added added[ADDED];
  struct world w;
  double entropy = 0;
  const struct rates with = rates_of(v, NULL), without = rates_of(&alone, NULL);
  create(&w, v, PERIODIC, added);
  for (int i = 0; i < w.nodes->n_internal; ++i)
    entropy += w.hydro.mass->f64[i] * (with.rate[i] - without.rate[i]) / w.hydro.energy->f64[i];
  CHECK(entropy > 0);
  destroy(&w, v, added);
}

/* With one velocity and temperature, rates are bitwise those of the hydro package. */
static void check_uniform_gas(const struct variant *v) {
  const struct variant alone = without_rates(v);
  const struct variant *const variant[] = {v, &alone};
  struct rates r[2];
  for (int k = 0; k < 2; ++k) {
    struct added added[ADDED];
    struct world w;
    create(&w, variant[k], PERIODIC, added);
    for (int i = 0; i < w.nodes->n_internal; ++i) {
      w.hydro.energy->f64[i] = 1.3;
      for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] = 0.5 + a;
    }
    evaluate(&w);
    store_rates(&r[k], &w);
    destroy(&w, variant[k], added);
  }
  compare(&r[0], &r[1], 0);
}

/* Coupling changes the forces of damaged nodes; if all nodes are sound, rates are bitwise those without
 * it. */
static void check_coupled(const struct variant *v) {
  const struct variant alone = {.hydro = v->hydro, .method = v->method};
  const struct rates damaged = rates_of(v, NULL), wanted = rates_of(&alone, NULL);
  struct added added[ADDED];
  struct world w;
  struct rates sound;
  create_damaged(&w, v, PERIODIC, added, true);
  evaluate(&w);
  store_rates(&sound, &w);
  destroy(&w, v, added);
  compare(&sound, &wanted, 0);
  CHECK(memcmp(damaged.acceleration, wanted.acceleration, sizeof wanted.acceleration) != 0);
}

/* ---- invariance ---- */

static void check_threads(const struct variant *v) {
  struct added added[2][ADDED];
  struct world w[2];
  for (int k = 0; k < 2; ++k) create(&w[k], v, PERIODIC, added[k]);
  check_threads_agree(w);
  for (int k = 0; k < 2; ++k) destroy(&w[k], v, added[k]);
}

/* ---- the time step ---- */

/* Multiplies the coefficients of a package: what its table has no default for. */
static void multiply_coefficients(struct added *added, double factor) {
  for (const struct kith_param *p = added->package.ops->params; p != NULL && p->key != NULL; ++p) {
    double *coefficient = (double *)((char *)added->settings + p->offset);
    for (size_t k = 0; p->fallback == NULL && k < p->size / sizeof *coefficient; ++k)
      coefficient[k] *= factor;
  }
}

/* The limit is the least over all nodes and packages, and names the package. */
static void check_limit(const struct variant *v) {
  struct added added[ADDED];
  struct world w;
  create(&w, v, PERIODIC, added);
  const struct kith_package_ops *ops = added[0].package.ops;
  evaluate(&w);
  const double alone = (w.package.next = NULL, kith_package_timestep_limit(&w.package, 0.3).dt);
  w.package.next = &added[0].package;
  multiply_coefficients(&added[0], 1e3);
  double least = INFINITY;
  for (int i = 0; ops->longest_step != NULL && i < w.nodes->n_internal; ++i)
    least = fmin(least, 0.3 * ops->longest_step(&added[0].package, i));
  const struct kith_timestep_limit limit = kith_package_timestep_limit(&w.package, 0.3);
  CHECK(limit.dt == fmin(least, alone));
  CHECK(ops->longest_step == NULL ||
        (least < alone && strcmp(kith_limit_name(limit.reason), ops->name) == 0));
  w.package.added_cfl = 0.1; /* bounds the Courant number of added packages alone */
  const double bounded = kith_package_timestep_limit(&w.package, 0.3).dt;
  CHECK(ops->longest_step != NULL ? fabs(bounded - least / 3) <= 1e-14 * least : bounded == limit.dt);
  w.package.added_cfl = 1;
  CHECK(kith_package_timestep_limit(&w.package, 0.3).dt == limit.dt);
  multiply_coefficients(&added[0], 0); /* without diffusion there is no limit */
  CHECK(v->n > 1 || kith_package_timestep_limit(&w.package, 0.3).dt == alone);
  destroy(&w, v, added);
}

/* ---- all packages ---- */

static void check_variant(struct variant v, int number) {
  static const char *const schemes[] = {"leapfrog", "rk2", "cheap-rk2", "verlet"};
  const double common[3] = {3, -2, 1};
  const int before = check_failures;
  const struct rates gather = rates_of(&v, NULL), moving = rates_of(&v, common);
  compare(&moving, &gather, 1e-10);
  check_conservation(&v, (enum side)(number % 3), schemes[number % 4]);
  if (without_rates(&v).n < v.n) {
    check_second_law(&v);
    check_uniform_gas(&v);
    check_limit(&v);
  } else {
    check_coupled(&v);
  }
  v.method.traversal = KITH_TRAVERSE_PAIRS;
  const struct rates pairs = rates_of(&v, NULL);
  compare(&pairs, &gather, 1e-13);
  check_conservation(&v, (enum side)((number + 1) % 3), schemes[(number + 1) % 4]);
  check_threads(&v);
  struct variant other = v; /* in reverse order */
  for (int k = 0; k < v.n; ++k) other.member[k] = v.member[v.n - 1 - k];
  const struct rates reversed = rates_of(&other, NULL);
  compare(&reversed, &pairs, 1e-13);
  if (check_failures > before)
    fprintf(stderr, "%d packages on %s, the first is %s\n", v.n, v.hydro,
            kith_added_all()[v.member[0]]->name);
}

int main(void) {
  int number = 0;
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p) {
    struct variant v = {.hydro = (*p)->name,
                        .n = 1,
                        .method = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_NONE, KITH_TRAVERSE_GATHER, true,
                                   0, 0, KITH_BALSARA_NONE}};
    CHECK(kith_added_find((*p)->name) == NULL && (*p)->longest_step == NULL);
    for (v.member[0] = 0; v.member[0] < ADDED; ++v.member[0]) check_variant(v, number++);
    for (v.n = 0; v.n < ADDED; ++v.n) v.member[v.n] = v.n;
    if (v.n > 1) check_variant(v, number++);
  }
  return check_failed();
}
