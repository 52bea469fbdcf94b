/* test_initial_conditions.c - nodes that a scene creates: numbers, masses, positions, states, regions,
 * deposits, jitter (against counts and formulas known by hand), and scenes that are refused. */
#include <stdlib.h>
#include <string.h>
#include "app/initial/deposits.h"
#include "app/initial/initial_conditions.h"
#include "tests/check.h"
#include "tests/unit/materials.h"

enum { MAX = 4 };

/* A scene that is built by hand, and the nodes that it creates. */
struct hand_scene {
  struct kith_scene scene;
  struct kith_region region[MAX];
  struct kith_config_node node[MAX]; /* of the regions */
  struct kith_deposit deposit[MAX];
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
  uint8_t *frozen;
  double zone[NDIM][2][NDIM];
};

static struct kith_expression *formula(const char *text) {
  struct kith_expression *f = NULL;
  CHECK_OK(kith_expression_create(&f, text));
  return f;
}

/* A cube [lower, upper]^NDIM of one ideal gas, without regions. */
static void open_scene(struct hand_scene *s, double lower, double upper, double resolution) {
  memset(s, 0, sizeof *s);
  s->scene.resolution = resolution;
  s->scene.region = s->region;
  s->scene.deposit = s->deposit;
  for (int a = 0; a < NDIM; ++a) s->scene.domain.lower[a] = lower, s->scene.domain.upper[a] = upper;
  s->scene.n_materials = 2;
  for (int m = 0; m < 2; ++m) {
    snprintf(s->scene.material_name[m], sizeof s->scene.material_name[m], "gas%d", m);
    s->scene.material[m] = material_of("ideal", m == 0 ? "gamma=1.4" : "gamma=1.6666666666666667");
  }
}

/* Adds a region that covers the domain, at rest, with P = 1. */
static struct kith_region *add(struct hand_scene *s, enum kith_lattice lattice, const char *density) {
  struct kith_region *region = &s->region[s->scene.n_regions++];
  region->lattice = lattice;
  region->density = formula(density);
  region->pressure = formula("1");
  for (int a = 0; a < NDIM; ++a) {
    region->where.extent[a][0] = -INFINITY, region->where.extent[a][1] = INFINITY;
    region->velocity[a] = formula("0");
  }
  struct kith_config_node *node = &s->node[s->scene.n_regions - 1];
  node->location = (struct kith_source_location){.file = "hand.yaml", .line = 10 * s->scene.n_regions};
  region->node = node;
  return region;
}

static void replace(struct kith_expression **old, const char *text) {
  kith_expression_destroy(old);
  *old = text ? formula(text) : NULL;
}

static kith_status run(struct hand_scene *s) {
  int64_t total;
  return kith_initial_conditions(&s->nodes, &s->hydro, &s->scene, NULL, 50, &s->frozen, s->zone, &total);
}

/* Without nodes nothing else can be tested. */
static void must_run(struct hand_scene *s) {
  CHECK_OK(run(s));
  if (!s->nodes) exit(check_failed());
}

static void close_scene(struct hand_scene *s) {
  for (int k = 0; k < s->scene.n_regions; ++k) {
    kith_expression_destroy(&s->region[k].density);
    kith_expression_destroy(&s->region[k].pressure);
    kith_expression_destroy(&s->region[k].energy);
    kith_expression_destroy(&s->region[k].where.inside);
    for (int a = 0; a < NDIM; ++a) kith_expression_destroy(&s->region[k].velocity[a]);
  }
  kith_nodes_destroy(&s->nodes);
  kith_free(&s->frozen);
}

/* The next call must fail with BAD_INPUT, name both texts, and leave nothing behind. */
static void refuses(struct hand_scene *s, const char *first, const char *second) {
  CHECK_STATUS(KITH_BAD_INPUT, run(s));
  CHECK(check_says(first) && check_says(second));
  CHECK(!s->nodes && !s->frozen);
  close_scene(s);
}

/* One region: numbers, masses, ids, supports, and energies from the pressure. */
static void one_region(void) {
  struct hand_scene s;
  open_scene(&s, -0.5, 0.5, NDIM == 3 ? 12 : 48);
  add(&s, KITH_LATTICE_CUBIC, "2");
  replace(&s.region[0].velocity[0], "x + r");
  must_run(&s);
  const kith_index n = s.nodes->n_internal;
  CHECK(n == (NDIM == 1 ? 48 : NDIM == 2 ? 48 * 48 : 12 * 12 * 12));
  CHECK(s.nodes->lists[0].count == n && s.nodes->lists[1].count == 0);
  CHECK(strcmp(s.nodes->lists[1].name, "gas1") == 0);
  CHECK_CLOSE(kith_hydro_totals(&s.hydro).mass, 2, 1e-12);
  CHECK(!s.frozen);
  for (kith_index i = 0; i < n; ++i) {
    const double *x = s.nodes->position->f64 + i * NDIM;
    CHECK(s.nodes->id->i64[i] == i);
    CHECK(s.hydro.density->f64[i] == 2);
    CHECK_CLOSE(s.hydro.energy->f64[i], 1 / (0.4 * 2), 1e-14);
    CHECK_CLOSE(s.hydro.velocity->f64[i * NDIM], x[0] + kith_norm(x), 1e-15);
    /* 50 nodes of volume 1 / n are in the ball of radius H */
    CHECK_CLOSE(kith_ball() * kith_pow_dim(s.nodes->support->f64[i]) * n, 50, 1e-11);
  }
  CHECK(material_value(&s.hydro.material[1], "gamma") == 5. / 3);
  close_scene(&s);
}

static const double jump_resolution = NDIM == 1 ? 999 : NDIM == 2 ? 150 : 60;

/* Two halves of a long box with densities 8 : 1; it is `across` spacings wide. */
static void open_jump(struct hand_scene *s, enum kith_lattice lattice, enum kith_arrangement arrangement,
                      double across) {
  open_scene(s, -1, 1, jump_resolution);
  s->scene.arrangement = arrangement;
  for (int a = 1; a < NDIM; ++a)
    s->scene.domain.lower[a] = 0, s->scene.domain.upper[a] = across / jump_resolution;
  add(s, lattice, "1")->where.extent[0][1] = 0;
  add(s, lattice, "0.125")->where.extent[0][0] = 0;
}

/* Layers of cells are whole, so masses differ by half a layer: at worst 2 %, with 25 layers on the sparse
 * side (bcc in 3-D). */
static void equal_masses(enum kith_lattice lattice, double across) {
  struct hand_scene s;
  open_jump(&s, lattice, KITH_EQUAL_MASS, across);
  must_run(&s);
  const kith_index n = s.nodes->n_internal;
  const double volume = pow(across / jump_resolution, NDIM - 1), wanted = pow(jump_resolution, -NDIM);
  double low = INFINITY, high = 0;
  for (kith_index i = 0; i < n; ++i) {
    low = fmin(low, s.hydro.mass->f64[i]);
    high = fmax(high, s.hydro.mass->f64[i]);
  }
  CHECK(high / low < 1.02);
  CHECK_CLOSE(kith_hydro_totals(&s.hydro).mass, 1.125 * volume, 1e-12 * volume);
  CHECK_CLOSE(low / wanted, 1, 0.15); /* 8 cells across: each of two axes rounds by up to 1/16 */
  close_scene(&s);
}

static void equal_spacings(enum kith_lattice lattice, double across) {
  struct hand_scene s;
  open_jump(&s, lattice, KITH_EQUAL_SPACING, across);
  must_run(&s);
  const kith_index half = s.nodes->n_internal / 2;
  for (kith_index i = 0; i < half; ++i) {
    CHECK(s.hydro.mass->f64[i] == 8 * s.hydro.mass->f64[i + half]);
    const double *x = s.nodes->position->f64 + i * NDIM, *y = x + half * NDIM;
    CHECK_CLOSE(x[0], y[0] - 1, 1e-15); /* positions are of order 1 */
    for (int a = 1; a < NDIM; ++a) CHECK(x[a] == y[a]);
  }
  close_scene(&s);
}

#if KITH_NDIM == 1
#define BALL "(x - 0.5)^2"
#elif KITH_NDIM == 2
#define BALL "(x - 0.5)^2 + (y - 0.5)^2"
#else
#define BALL "(x - 0.5)^2 + (y - 0.5)^2 + (z - 0.5)^2"
#endif

/* A ball and its surroundings fill the domain: no site twice, none missing. */
static void ball_and_rest(void) {
  struct hand_scene s;
  open_scene(&s, 0, 1, NDIM == 1 ? 101 : 21);
  s.scene.arrangement = KITH_EQUAL_SPACING;
  for (int k = 0; k < 2; ++k) {
    struct kith_region *region = add(&s, KITH_LATTICE_CUBIC, k == 0 ? "1" : "3");
    region->material = 1 - k;
    /* sites on the surface */
    region->where.inside = formula(k == 0 ? BALL " < (5/21)^2" : BALL " >= (5/21)^2");
  }
  s.region[1].frozen = true;
  must_run(&s);
  const kith_index n = s.nodes->n_internal;
  CHECK(n == (NDIM == 1 ? 101 : NDIM == 2 ? 21 * 21 : 21 * 21 * 21));
  CHECK(s.nodes->lists[0].count > 0 && s.nodes->lists[1].count > 0);
  for (kith_index i = 0; i < n; ++i) {
    double r2 = 0;
    for (int a = 0; a < NDIM; ++a) r2 += pow(s.nodes->position->f64[i * NDIM + a] - 0.5, 2);
    const bool outer = i < s.nodes->lists[0].count;
    CHECK(outer ? sqrt(r2) > 5. / 21 - 1e-9 : sqrt(r2) < 5. / 21 + 1e-9);
    CHECK_CLOSE(s.hydro.mass->f64[i] * n, outer ? 3 : 1, 1e-13);
    CHECK(s.frozen[i] == outer);
    CHECK(s.nodes->list->u8[i] == !outer);
    CHECK_CLOSE(s.hydro.energy->f64[i], outer ? 1 / (0.4 * 3) : 1.5, 1e-14);
  }
  close_scene(&s);
}

/* Formulas that complement each other, with sites where they change. */
static void complements(void) {
  struct hand_scene s;
  open_scene(&s, -1, 1, NDIM == 1 ? 50.5 : 7.5); /* odd counts: sites at 0 */
  add(&s, KITH_LATTICE_CUBIC, "1")->where.inside = formula("x + y < 0");
  add(&s, KITH_LATTICE_CUBIC, "1")->where.inside = formula("x + y >= 0");
  must_run(&s);
  CHECK(s.nodes->n_internal == (NDIM == 1 ? 101 : NDIM == 2 ? 225 : 3375));
  close_scene(&s);
}

/* The mass is rho(x) times the volume of a cell; the mean density sets the spacing relative to another
 * region. */
static void graded(void) {
  struct hand_scene s;
  open_scene(&s, 0, 2, NDIM == 3 ? 16 : 64);
  add(&s, KITH_LATTICE_CUBIC, "1 + 0.5*sin(2*pi*x)")->where.extent[0][1] = 1;
  add(&s, KITH_LATTICE_CUBIC, "1")->where.extent[0][0] = 1;
  must_run(&s);
  const kith_index n = s.nodes->n_internal, half = n / 2;
  CHECK(n == (NDIM == 1 ? 128 : NDIM == 2 ? 128 * 128 : 32 * 32 * 32)); /* the mean density is 1 */
  for (kith_index i = 0; i < half; ++i) {
    const double rho = 1 + 0.5 * sin(2 * acos(-1.0) * s.nodes->position->f64[i * NDIM]);
    CHECK_CLOSE(s.hydro.mass->f64[i] / s.hydro.mass->f64[half], rho, 1e-13);
    CHECK_CLOSE(s.hydro.density->f64[i], rho, 1e-14);
  }
  /* the midpoint sum of a sine over its period is exact */
  CHECK_CLOSE(kith_hydro_totals(&s.hydro).mass, pow(2, NDIM), 1e-12 * 8);
  close_scene(&s);
}

static void jittered(void) {
  struct hand_scene plain, moved, again;
  struct hand_scene *all[3] = {&plain, &moved, &again};
  for (int k = 0; k < 3; ++k) {
    open_scene(all[k], 0, 1, NDIM == 1 ? 200 : 15);
    struct kith_region *region = add(all[k], KITH_LATTICE_BCC, "1");
    region->jitter = k == 0 ? 0 : 0.5;
    region->seed = 42;
    must_run(all[k]);
  }
  const kith_index n = plain.nodes->n_internal;
  const double spacing = pow(1. / n, 1. / NDIM);
  bool any = false;
  for (kith_index i = 0; i < n * NDIM; ++i) {
    const double x = moved.nodes->position->f64[i], off = fabs(x - plain.nodes->position->f64[i]);
    CHECK(off <= 0.5 * spacing * (1 + 1e-12));
    CHECK(x >= 0 && x <= 1);
    CHECK(x == again.nodes->position->f64[i]);
    any = any || off > 0.45 * spacing;
  }
  CHECK(any);
  for (int k = 0; k < 3; ++k) close_scene(all[k]);
}

static void own_spacing(void) {
  struct hand_scene s;
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1")->where.extent[0][1] = 0.5;
  add(&s, KITH_LATTICE_CUBIC, "7")->where.extent[0][0] = 0.5;
  s.region[1].spacing = 0.05; /* denser, without effect on the other region */
  must_run(&s);
  const kith_index first = NDIM == 1 ? 5 : NDIM == 2 ? 50 : 500;
  CHECK(s.nodes->n_internal == first + 10 * (NDIM == 1 ? 1 : NDIM == 2 ? 20 : 400));
  close_scene(&s);
}

/* The energy of all nodes; here the background has none. */
static double deposited(const struct hand_scene *s) {
  double sum = 0;
  for (kith_index i = 0; i < s->nodes->n_internal; ++i)
    sum += s->hydro.mass->f64[i] * s->hydro.energy->f64[i];
  return sum;
}

static struct kith_deposit *blast(struct hand_scene *s, enum kith_deposit_shape shape, double center) {
  static const struct kith_config_node node = {.location = {.file = "hand.yaml", .line = 77}};
  struct kith_deposit *deposit = &s->deposit[s->scene.n_deposits++];
  *deposit = (struct kith_deposit){.energy = 3, .shape = shape, .node = &node};
  for (int a = 0; a < NDIM; ++a) deposit->center[a] = center;
  return deposit;
}

/* Returns the number of nodes with energy; the sum must be right, and energies symmetric about 0. */
static int heated(struct hand_scene *s) {
  must_run(s);
  CHECK_CLOSE(deposited(s), 3, 3e-14); /* 1e-14 of the energy: round-off of sums */
  int count = 0;
  const kith_index n = s->nodes->n_internal;
  for (kith_index i = 0; i < n; ++i) {
    count += s->hydro.energy->f64[i] > 0;
    CHECK_CLOSE(s->hydro.energy->f64[i], s->hydro.energy->f64[n - 1 - i], 1e-13 * s->hydro.energy->f64[i]);
  }
  return count;
}

static struct kith_deposit *cold_box(struct hand_scene *s, double resolution, enum kith_deposit_shape shape,
                                     double center) {
  open_scene(s, -0.5, 0.5, resolution);
  add(s, KITH_LATTICE_CUBIC, "1");
  replace(&s->region[0].pressure, "0");
  return blast(s, shape, center);
}

static void deposits(void) {
  static const kith_index corners[3] = {2, 4, 8};
  struct hand_scene s;
  cold_box(&s, 15, KITH_DEPOSIT_POINT, 0);
  CHECK(heated(&s) == 1); /* a node at the center */
  close_scene(&s);
  cold_box(&s, 14, KITH_DEPOSIT_POINT, 0);
  CHECK(heated(&s) == corners[NDIM - 1]); /* all nearest nodes */
  close_scene(&s);
  cold_box(&s, 14, KITH_DEPOSIT_POINT, 0.5);
  for (int a = 0; a < NDIM; ++a) s.scene.period[a] = s.scene.domain.upper[a] - s.scene.domain.lower[a];
  CHECK(heated(&s) == corners[NDIM - 1]); /* also around a corner of a periodic box */
  close_scene(&s);
  cold_box(&s, 15, KITH_DEPOSIT_BALL, 0)->radius = 3. / 15;    /* nodes exactly on the sphere belong to it */
  CHECK(heated(&s) == (NDIM == 1 ? 7 : NDIM == 2 ? 29 : 123)); /* lattice points with |k| <= 3 */
  close_scene(&s);
  cold_box(&s, 15, KITH_DEPOSIT_BALL, 0)->spacings = 3;
  CHECK(heated(&s) == (NDIM == 1 ? 7 : NDIM == 2 ? 29 : 123));
  close_scene(&s);
}

/* Away from 0 equal distances differ by round-off; shells of nodes stay complete. */
static void whole_shells(void) {
  static const int in_ball[3] = {7, 29, 123}, corners[3] = {2, 4, 8};
  for (int n = 9; n <= 24; ++n) {
    struct hand_scene s;
    open_scene(&s, 0.1, 1.1, n);
    add(&s, KITH_LATTICE_CUBIC, "1");
    replace(&s.region[0].pressure, "0");
    blast(&s, n % 2 ? KITH_DEPOSIT_BALL : KITH_DEPOSIT_POINT, 0.6)->radius = 3. / n;
    CHECK(heated(&s) == (n % 2 ? in_ball : corners)[NDIM - 1]);
    close_scene(&s);
  }
}

/* The specific energy is the cubic spline of the distance, whose support is 2 h = 4.8 spacings. */
static void kernel_deposit(void) {
  struct hand_scene s;
  cold_box(&s, 15, KITH_DEPOSIT_KERNEL, 0)->spacings = 2.4;
  heated(&s);
  double center = 0;
  for (kith_index i = 0; i < s.nodes->n_internal; ++i)
    if (kith_norm(s.nodes->position->f64 + i * NDIM) < 1e-9) center = s.hydro.energy->f64[i];
  CHECK(center > 0);
  for (kith_index i = 0; i < s.nodes->n_internal; ++i) {
    const double q = kith_norm(s.nodes->position->f64 + i * NDIM) * 15 / 2.4;
    const double w = (pow(fmax(2 - q, 0), 3) - 4 * pow(fmax(1 - q, 0), 3)) / 4; /* M4 by truncated powers */
    CHECK_CLOSE(s.hydro.energy->f64[i] / center, w, 1e-13);
  }
  close_scene(&s);
  cold_box(&s, 14, KITH_DEPOSIT_KERNEL, 0)->radius = 0.34;
  heated(&s);
  for (kith_index i = 0; i < s.nodes->n_internal; ++i)
    CHECK((s.hydro.energy->f64[i] > 0) == (kith_norm(s.nodes->position->f64 + i * NDIM) < 0.34));
  close_scene(&s);
  cold_box(&s, 14, KITH_DEPOSIT_BALL, 0)->radius = 0.01;
  refuses(&s, "hand.yaml:77", "no node is within 0.01");
}

/* Nodes of two spacings are as near the center of a later deposit, whose radius is in spacings: that of the
 * least id counts, in whatever order ranks or a reordering have put the nodes. */
static void equal_distances(void) {
  struct hand_scene s;
  int heated[2] = {0};
  open_scene(&s, -1, 1, 8);
  for (int k = 0; k < 2; ++k) {
    struct kith_region *region = add(&s, KITH_LATTICE_CUBIC, "1");
    region->spacing = k == 0 ? 0.125 : 0.25;
    region->where.extent[0][0] = k - 1, region->where.extent[0][1] = k;
    replace(&region->pressure, "0");
  }
  blast(&s, KITH_DEPOSIT_BALL, 0)->spacings = 2;
  s.deposit->center[0] = NDIM / 32., s.deposit->time = 1;
  must_run(&s);
  const kith_index n = s.nodes->n_internal;
  kith_index *order = NULL;
  CHECK_OK(kith_resize(&order, 0, (size_t)n, sizeof *order));
  for (kith_index i = 0; i < n; ++i) order[i] = n - 1 - i;
  for (int turned = 0; turned < 2; ++turned) {
    if (turned) CHECK_OK(kith_nodes_reorder(s.nodes, order));
    for (kith_index i = 0; i < n; ++i) s.hydro.energy->f64[i] = 0;
    CHECK_OK(kith_deposits_add(&s.scene, &s.hydro, 1));
    for (kith_index i = 0; i < n; ++i) heated[turned] += s.hydro.energy->f64[i] > 0;
  }
  CHECK(heated[0] > 0 && heated[1] == heated[0]);
  kith_free(&order);
  close_scene(&s);
}

static void state_errors(void) {
  static const struct {
    const char *density, *pressure, *energy, *line, *says;
  } wrong[] = {
      {"x - 0.2", "1", NULL, "hand.yaml:10", "density is"},
      {"0", "1", NULL, "hand.yaml:10", "density is 0"},
      {"1/(x - x)", "1", NULL, "hand.yaml:10", "density: formula"},
      {"1", "-1", NULL, "hand.yaml:10", "pressure is -1 at ("},
      {"1", "log(x - 0.5)", NULL, "hand.yaml:10", "pressure: formula"},
      {"1", NULL, "x - 0.5", "hand.yaml:10", "energy is -"},
      {"1", NULL, "sqrt(x - 0.5)", "hand.yaml:10", "energy: formula"},
      {"1e-308", "1e10", NULL, "hand.yaml:10", "energy is inf"},
  };
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; ++k) {
    struct hand_scene s;
    open_scene(&s, 0, 1, 10);
    add(&s, KITH_LATTICE_CUBIC, wrong[k].density);
    replace(&s.region[0].pressure, wrong[k].pressure);
    replace(&s.region[0].energy, wrong[k].energy);
    refuses(&s, wrong[k].line, wrong[k].says);
  }
  struct hand_scene s;
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1");
  replace(&s.region[0].velocity[NDIM - 1], "1/0");
  refuses(&s, "hand.yaml:10", "velocity along");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1");
  s.scene.material[0] = material_of("isothermal", "sound_speed=2"); /* its pressure is 4 there */
  refuses(&s, "hand.yaml:10", "pressure is not what its eos has");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1"); /* a solid that is pressed to four times its density, frozen or not */
  replace(&s.region[0].pressure, NULL);
  replace(&s.region[0].energy, "0.1");
  s.region[0].frozen = true;
  s.scene.material[0] = material_of("mie-grueneisen", "density=0.25 slope=1.5");
  refuses(&s, "hand.yaml:10", "it is compressed beyond what the Hugoniot of its material allows (density 1,");
  for (int torn = 0; torn < 2; ++torn) { /* a stiffened gas bears tension, down to -stiffness */
    open_scene(&s, 0, 1, 10);
    add(&s, KITH_LATTICE_CUBIC, "1");
    replace(&s.region[0].pressure, torn ? "-3.1" : "-2.9");
    s.scene.material[0] = material_of("stiffened", "gamma=2 stiffness=3");
    if (torn) {
      refuses(&s, "hand.yaml:10", "pressure is -3.1 at (");
    } else {
      must_run(&s);
      CHECK_CLOSE(s.hydro.energy->f64[0], 3.1, 1e-15);
      close_scene(&s);
    }
  }
}

static void overlaps(void) {
  struct hand_scene s;
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "x - 2");
  s.node[0].location = (struct kith_source_location){.file = "--set"};
  refuses(&s, "--set ", "density is -"); /* an override has no line */
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1")->where.extent[0][1] = 0.52; /* less than a spacing too far */
  add(&s, KITH_LATTICE_CUBIC, "1")->where.extent[0][0] = 0.42;
  refuses(&s, "hand.yaml:10", "line 20");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1")->where.inside = formula("r < 0.3");
  add(&s, KITH_LATTICE_CUBIC, "1");
  refuses(&s, "hand.yaml:10", "line 20");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1");
  add(&s, KITH_LATTICE_CUBIC, "1");
  refuses(&s, "hand.yaml:10", "line 20");
}

static void empty_and_huge(void) {
  struct hand_scene s;
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1");
  add(&s, KITH_LATTICE_CUBIC, "1")->where.extent[0][0] = 1; /* outside of the domain */
  refuses(&s, "hand.yaml:20", "domain");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1")->where.inside = formula("x > 3");
  refuses(&s, "hand.yaml:10", "no node");
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_CUBIC, "1 + x")->where.inside = formula("x > 3");
  refuses(&s, "hand.yaml:10", "too thin");
  open_scene(&s, 0, 1, 1e30);
  add(&s, KITH_LATTICE_CUBIC, "1");
  refuses(&s, "hand.yaml:10", "more than");
  open_scene(&s, 0, 1, 10);
  s.scene.domain.upper[0] = INFINITY;
  add(&s, KITH_LATTICE_CUBIC, "1");
  refuses(&s, "hand.yaml:10", "not bounded");
  open_scene(&s, 0, 1, NDIM == 1 ? 7e8 : NDIM == 2 ? 27000 : 890); /* one fits, both do not */
  add(&s, KITH_LATTICE_CUBIC, "1");
  add(&s, KITH_LATTICE_CUBIC, "1");
  refuses(&s, "nodes", "more than");
  if (NDIM != 2) return;
  open_scene(&s, 0, 1, 10);
  add(&s, KITH_LATTICE_FCC, "1");
  refuses(&s, "hand.yaml:10", "2-D");
}

int main(void) {
  one_region();
  const double widths[] = {12, 12.6, 16, 20};
  const enum kith_lattice lattice[] = {KITH_LATTICE_CUBIC, KITH_LATTICE_BCC, KITH_LATTICE_HCP};
  for (int k = 0; k < 12; ++k) {
    equal_masses(lattice[k % 3], widths[k / 3]);
    equal_spacings(lattice[k % 3], widths[k / 3]);
  }
  ball_and_rest();
  complements();
  graded();
  jittered();
  own_spacing();
  deposits();
  whole_shells();
  kernel_deposit();
  equal_distances();
  state_errors();
  overlaps();
  empty_and_huge();
  return check_failed();
}
