/* conformance_package.c - every package, with its default settings and with every choice of its parameters:
 * momentum and energy are conserved to round-off, and rates do not depend on the order of nodes, the
 * traversal, the threads, the frame of reference or on whether neighbors are nodes or ghosts. New members and
 * choices are covered without changes here. The oracles are these invariances; the equations of each package
 * are tested by its own tests. */
#include "tests/unit/choices_of.h"
#include "tests/unit/physics/invariances.h"

/* The number of nodes is divisible by 3, for three equal lists; the box is thinner than the supports along
 * one axis. */
static const int box[3] = {NDIM == 1 ? 15 : NDIM == 2 ? 7 : 5, NDIM == 2 ? 6 : 4, 3};

/* A package with settings, and how it is evaluated. */
struct variant {
  const char *package, *settings;
  struct method method;
};

static void create(struct world *w, const struct variant *v, const int *cells, enum side side,
                   double jitter) {
  world_create(w, cells, side, jitter, &v->method, 77);
  world_package(w, v->package, &v->method, v->settings);
}

/* Sums in another order, relative to the largest value. */
static const double round_off = 1e-10;

static void compare(const char *what, double tolerance, const struct variant *v, const struct rates *got,
                    const struct rates *wanted) {
  const int before = check_failures;
  CHECK(got->n == wanted->n);
  CHECK_FIELD(got->acceleration, wanted->acceleration, wanted->n * NDIM, tolerance);
  CHECK_FIELD(got->rate, wanted->rate, wanted->n, tolerance);
  CHECK_FIELD(got->signal, wanted->signal, wanted->n, tolerance);
  CHECK_FIELD(got->density, wanted->density, wanted->n, tolerance);
  if (check_failures > before)
    fprintf(stderr, "%s: package %s %s, %s, %s energy\n", what, v->package, v->settings,
            v->method.traversal == KITH_TRAVERSE_PAIRS ? "pairs" : "gather",
            v->method.compatible ? "compatible" : "thermal");
}

/* Rates of the box that all others are compared with. */
static struct rates rates_of(const struct variant *v) {
  struct world w;
  struct rates r;
  create(&w, v, box, PERIODIC, 0.3);
  evaluate(&w);
  store_rates(&r, &w);
  world_destroy(&w);
  return r;
}

/* --- conservation --- */

static double mechanical_energy(const struct world *w) {
  const struct kith_totals t = kith_hydro_totals(&w->hydro);
  return t.kinetic + t.internal;
}

/* With `gather` each end evaluates the pair by itself, so this tests the symmetry of the pair function under
 * exchange of i and j: -f, q_j, q_i. Compatible energies also keep sum m (v^2 / 2 + u) in kicks of any
 * length. */
static void check_conservation(const struct variant *v, enum side side) {
  struct world w;
  create(&w, v, box, side, 0.3);
  evaluate(&w);
  check_rates_conserve(&w);
  const double before = mechanical_energy(&w), parts[] = {0.3, 0.1, 0.2};
  for (int k = 0; v->method.compatible && k < 3; ++k) {
    kith_kick(&w.it, parts[k]);
    CHECK_CLOSE(mechanical_energy(&w) / before, 1, 1e-14);
  }
  world_destroy(&w);
}

static void check_steps(const struct variant *v, const char *scheme, enum side side) {
  struct world w;
  create(&w, v, box, side, 0.2);
  check_steps_conserve(&w, scheme);
  world_destroy(&w);
}

/* --- invariance --- */

/* A common velocity changes nothing. */
static void check_galilean(const struct variant *v, const struct rates *wanted) {
  const double common[3] = {3, -2, 1};
  struct world w;
  struct rates r;
  create(&w, v, box, PERIODIC, 0.3);
  for (int i = 0; i < w.nodes->n_internal; ++i)
    for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] += common[a];
  evaluate(&w);
  store_rates(&r, &w);
  compare("Galilean invariance", round_off, v, &r, wanted);
  world_destroy(&w);
}

/* Nodes in reverse order within each list, so that pairs start at the other end. */
static void check_permutation(const struct variant *v, const struct rates *wanted) {
  struct world w, from;
  struct rates r;
  create(&w, v, box, PERIODIC, 0.3);
  create(&from, v, box, PERIODIC, 0.3);
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    const struct kith_node_list *list = &w.nodes->lists[w.nodes->list->u8[i]];
    const int k = list->first + list->count - 1 - (i - list->first);
    w.nodes->id->i64[i] = 100 + k;
    w.hydro.mass->f64[i] = from.hydro.mass->f64[k], w.hydro.energy->f64[i] = from.hydro.energy->f64[k];
    for (int a = 0; a < NDIM; ++a) {
      w.nodes->position->f64[i * NDIM + a] = from.nodes->position->f64[k * NDIM + a];
      w.hydro.velocity->f64[i * NDIM + a] = from.hydro.velocity->f64[k * NDIM + a];
    }
  }
  evaluate(&w);
  store_rates(&r, &w);
  compare("permutation", round_off, v, &r, wanted);
  world_destroy(&from);
  world_destroy(&w);
}

static void check_threads(const struct variant *v) {
  struct world w[2];
  for (int k = 0; k < 2; ++k) create(&w[k], v, box, PERIODIC, 0.3);
  check_threads_agree(w);
  for (int k = 0; k < 2; ++k) world_destroy(&w[k]);
}

/* A periodic box has the rates of a half of a box twice as long, and a reflecting box those of a half of a
 * periodic box that also holds its mirror image. */
static void check_doubled(const struct variant *v, enum side side) {
  const int twice[3] = {2 * box[0], box[1], box[2]};
  struct world w, d;
  struct rates one, two;
  create(&w, v, box, side, 0.3);
  create(&d, v, twice, PERIODIC, 0.3);
  const int n = w.nodes->n_internal;
  /* nodes 2 i and 2 i + 1 of d are images of node i of w */
  CHECK(n % 3 == 0 && d.nodes->n_internal == 2 * n);
  for (int k = 0; k < 2 * n; ++k) {
    const int i = k / 2, image = k % 2;
    d.hydro.mass->f64[k] = w.hydro.mass->f64[i], d.hydro.energy->f64[k] = w.hydro.energy->f64[i];
    for (int a = 0; a < NDIM; ++a) {
      const double x = w.nodes->position->f64[i * NDIM + a], u = w.hydro.velocity->f64[i * NDIM + a];
      const bool mirrored = side == REFLECTING && a == 0 && image == 1;
      d.nodes->position->f64[k * NDIM + a] = mirrored               ? d.length[0] - x
                                             : a == 0 && image == 1 ? x + w.length[0]
                                                                    : x;
      d.hydro.velocity->f64[k * NDIM + a] = mirrored ? -u : u;
    }
    d.nodes->id->i64[k] = 100 + image * n + i;
  }
  evaluate(&w);
  evaluate(&d);
  store_rates(&one, &w);
  store_rates(&two, &d);
  two.n = n; /* the first half, with the ids of w */
  compare(side == PERIODIC ? "doubled box" : "mirrored box", round_off, v, &two, &one);
  world_destroy(&d);
  world_destroy(&w);
}

/* --- the smallest boxes --- */

/* Without nodes; a node without neighbors, which has no support; a node among its own images, on which no
 * force acts. */
static void check_few(const struct variant *v) {
  const int none[3] = {0, 1, 1}, one[3] = {1, 1, 1};
  struct world w;
  create(&w, v, none, OPEN, 0);
  evaluate(&w);
  CHECK_OK(kith_integrator_start(&w.it));
  world_destroy(&w);
  create(&w, v, one, OPEN, 0);
  CHECK_STATUS(KITH_DIVERGED, kith_integrator_start(&w.it));
  CHECK(strstr(kith_failure(), "support") != NULL);
  world_destroy(&w);
  create(&w, v, one, PERIODIC, 0);
  evaluate(&w);
  for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(w.hydro.acceleration->f64[a], 0, 1e-13);
  CHECK_CLOSE(w.hydro.energy_rate->f64[0], 0, 1e-13);
  world_destroy(&w);
}

/* Nodes of one material have bitwise identical rates in whichever list they are, while the others are
 * empty. */
static void check_empty_lists(const struct variant *v) {
  struct rates r[3];
  int n = 1;
  for (int a = 0; a < NDIM; ++a) n *= box[a];
  for (int l = 0; l < 3; ++l) {
    const int counts[3] = {l == 0 ? n : 0, l == 1 ? n : 0, l == 2 ? n : 0};
    struct world w;
    world_create_lists(&w, box, counts, PERIODIC, 0.3, &v->method, 5);
    world_package(&w, v->package, &v->method, v->settings);
    for (int k = 0; k < 3; ++k) w.hydro.material[k] = material_of("ideal", "gamma=1.4");
    evaluate(&w);
    store_rates(&r[l], &w);
    world_destroy(&w);
  }
  CHECK(memcmp(&r[0], &r[1], sizeof r[0]) == 0 && memcmp(&r[0], &r[2], sizeof r[0]) == 0);
}

/* --- consistency --- */

/* Long waves on a lattice: dv/dt is -grad P / rho, and du/dt is -P div v / rho, except for the smoothing over
 * a support (1.3 % at most). */
static void check_wave(const struct variant *v) {
  const int cells[3] = {24, NDIM == 2 ? 6 : 2, 2};
  const double k = 2 * M_PI / cells[0];
  struct world w;
  double sum[2] = {0}, norm[2] = {0};
  create(&w, v, cells, PERIODIC, 0);
  for (int l = 0; l < 3; ++l) w.hydro.material[l] = material_of("ideal", "gamma=1.4");
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    const double x = w.nodes->position->f64[i * NDIM];
    w.hydro.mass->f64[i] = 2;
    w.hydro.energy->f64[i] = 1 + 0.01 * sin(k * x);
    for (int a = 0; a < NDIM; ++a) w.hydro.velocity->f64[i * NDIM + a] = a == 0 ? 0.001 * sin(k * x) : 0;
  }
  evaluate(&w);
  for (int i = 0; i < w.nodes->n_internal; ++i) {
    const double phase = cos(k * w.nodes->position->f64[i * NDIM]);
    const double wanted[] = {-0.4 * 0.01 * k * phase, -0.4 * w.hydro.energy->f64[i] * 0.001 * k * phase};
    const double got[] = {w.hydro.acceleration->f64[i * NDIM], w.hydro.energy_rate->f64[i]};
    for (int q = 0; q < 2; ++q) sum[q] += got[q] * wanted[q], norm[q] += wanted[q] * wanted[q];
  }
  for (int q = 0; q < 2; ++q) CHECK_CLOSE(sum[q] / norm[q], 1, 0.03);
  world_destroy(&w);
}

/* Round-off does not decide whether nodes at the edge of a support have a signal speed: on an even line whose
 * supports are of two spacings, moves by 1e-13 to either side change no signal speed by more. */
static void check_edge(const struct variant *v) {
  struct rates r[2];
  for (int k = 0; k < 2; ++k) {
    struct world w;
    double half, slope;
    create(&w, v, box, PERIODIC, k == 0 ? 1e-13 : -1e-13);
    kith_kernel_value(w.package.kernel, 0.5, &half, &slope);
    w.package.neighbors = 2 * kith_kernel_constant(w.package.kernel) *
                          (kith_kernel_self_weight(w.package.kernel, w.package.neighbors) + 2 * half);
    evaluate(&w);
    store_rates(&r[k], &w);
    CHECK_CLOSE(w.nodes->support->f64[0], 2, 1e-8);
    world_destroy(&w);
  }
  CHECK_FIELD(r[0].signal, r[1].signal, r[0].n, 1e-7);
}

/* An evaluation leaves the fields of nodes that are not active as they are: here of every other one, to which
 * other values were given before. Pressures and sound speeds follow from density and energy alone and may be
 * computed for more nodes. */
static void check_idle(const struct variant *v) {
  struct world w;
  create(&w, v, box, PERIODIC, 0.3);
  const int n = w.nodes->n_internal;
  if (kith_package_traits(w.package.ops, w.settings).all_rows != NULL) { /* it never has idle nodes */
    world_destroy(&w);
    return;
  }
  CHECK_OK(kith_nodes_mark_activity(w.nodes));
  memset(w.nodes->activity->u8, KITH_ACTIVE, (size_t)n);
  evaluate(&w);
  for (int i = 0; i < n; i += 2) w.nodes->activity->u8[i] = KITH_IDLE;
  CHECK_OK(kith_lifecycle(&w.it, KITH_BECAUSE_requested));
  double *before[MOST] = {NULL};
  for (int f = 0; f < w.nodes->n_fields; ++f) {
    const struct kith_field *field = w.nodes->fields[f];
    const int parts = field->components;
    if (field->spec.type != KITH_F64 || field == w.hydro.pressure || field == w.hydro.sound_speed) continue;
    before[f] = malloc((size_t)(n * parts) * sizeof(double));
    for (int k = 0; k < n * parts; ++k) {
      if (k / parts % 2 == 0 && field->spec.role != KITH_STATE) field->f64[k] *= 1.001;
      before[f][k] = field->f64[k];
    }
  }
  CHECK_OK(w.package.ops->evaluate(&w.package, w.connectivity, &w.it.kick));
  for (int f = 0; f < w.nodes->n_fields; free(before[f++])) {
    const int parts = w.nodes->fields[f]->components;
    int changed = 0;
    for (int k = 0; before[f] != NULL && k < n * parts; ++k)
      changed += k / parts % 2 == 0 && w.nodes->fields[f]->f64[k] != before[f][k];
    if (changed > 0) fprintf(stderr, "%d values of idle nodes: %s\n", changed, w.nodes->fields[f]->spec.name);
    CHECK(changed == 0);
  }
  world_destroy(&w);
}

/* --- all variants --- */

static void check_variant(const char *package, const char *settings, int number) {
  static const char *const schemes[] = {"leapfrog", "rk2", "cheap-rk2", "verlet"};
  const int before = check_failures;
  struct variant v = {
      package,
      settings,
      {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_NONE, KITH_TRAVERSE_GATHER, true, 0, 0, KITH_BALSARA_NONE}};
  const struct rates gather = rates_of(&v);
  check_conservation(&v, (enum side)((number + 1) % 3));
  check_conservation(&v, PERIODIC);
  check_threads(&v);
  v.method.compatible = false;
  check_conservation(&v, PERIODIC);
  check_wave(&v);
  v.method.compatible = true, v.method.traversal = KITH_TRAVERSE_PAIRS;
  const struct rates pairs = rates_of(&v);
  compare("traversals", 1e-13, &v, &pairs, &gather);
  CHECK(pairs.evaluations < gather.evaluations); /* pairs are evaluated once */
  check_conservation(&v, (enum side)(number % 3));
  check_threads(&v);
  check_steps(&v, schemes[number % 4], (enum side)((number + 2) % 3));
  check_steps(&v, schemes[(number + 1) % 4], PERIODIC);
  check_galilean(&v, &pairs);
  check_permutation(&v, &pairs);
  check_doubled(&v, PERIODIC);
  if (NDIM == 1) check_doubled(&v, REFLECTING); /* oracles of single packages reflect along all axes */
  check_few(&v);
  check_empty_lists(&v);
  check_idle(&v);
  if (NDIM == 1) check_edge(&v);
  if (check_failures > before) fprintf(stderr, "package %s, settings '%s'\n", package, settings);
}

/* Every choice of every parameter, one at a time, with defaults for the others; `all`: the last one of each
 * that is no default. */
static void check_choices(const char *package, const char *prefix, const struct kith_param *params,
                          int *number, char *all, size_t size) {
  char text[256] = "", choice[64];
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    if (p->kind == KITH_PARAM_MAP) {
      snprintf(text, sizeof text, "%s%s.", prefix, p->key);
      check_choices(package, text, p->params, number, all, size);
      continue;
    }
    int k = 0;
    for (; choice_of(p, k, choice, sizeof choice); ++k) {
      snprintf(text, sizeof text, "%s%s=%s", prefix, p->key, choice);
      check_variant(package, text, (*number)++);
    }
    if (k > 0) snprintf(all + strlen(all), size - strlen(all), " %s", text);
  }
}

int main(void) {
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p) {
    int number = 1;
    char all[512] = "";
    CHECK((*p)->cfl > 0 && (*p)->cfl <= 1 && (*p)->spacings >= 0); /* defaults are in range */
    check_variant((*p)->name, "", 0);
    check_choices((*p)->name, "", (*p)->params, &number, all, sizeof all);
    if (number > 2) check_variant((*p)->name, all, number);
  }
  return check_failed();
}
