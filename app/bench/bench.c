/* bench.c - `kith bench`: node updates per second, stage by stage, beside reference loops of the same
 * session.
 *
 * The case: 3-D Sedov, 100^3 nodes (--set resolution=N), every node each step, double, adaptive supports of
 * 60 neighbors, Wendland C2, 10 steps (--steps N) after the first rates, nodes in curve order. Rows of the
 * table: thermal energy with neighbor lists rebuilt each step, and with other settings; the other packages.
 * Rows with a table of stages run on one thread and on all, the others on one. Absolute figures hold for one
 * machine and one moment; ratios to the reference loops can be compared. */
#include "app/cli/options.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/simulation/simulation.h"

static const char scene_text[] =
    "scene: bench\n"
    "dimension: 3\n"
    "resolution: 100\n"
    "domain: {lower: [-0.5, -0.5, -0.5], upper: [0.5, 0.5, 0.5]}\n"
    "boundaries: {x: periodic, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.6666666666666667}}\n"
    "regions: [{material: gas, lattice: cubic, density: 1, pressure: 1e-6}]\n"
    "energy: {energy: 1, center: [0, 0, 0], over: kernel, spacings: 2.4}\n"
    "method: {kernel: wendland-c2, neighbors: 60, energy: thermal}\n"
    "until: 0.05\n";

struct row {
  const char *what;
  bool stages;            /* on all threads too, with a table of stages */
  const char *setting[2]; /* key=value or NULL */
};

enum { MOST_STAGES = 48 };

/* One run; own times of the stages of a step in ns per node and step. */
struct figures {
  double nodes, updates, neighbors, rebuilds, energy_drift;
  int n_stages;
  char path[MOST_STAGES][64];
  double ns[MOST_STAGES], sum, step;
  double plain_density, plain_force; /* reference loops on the same rows */
  struct kith_bytes bytes[KITH_SIMULATION_STRUCTURES];
};

/* ---- loops that anybody could have written: what a figure is measured by ---- */

/* Bytes per second of a[i] = b[i] + 3 c[i] over 3 arrays of 2^24 doubles, 24 bytes counted an element; best
 * of five. */
static kith_status reference_triad(double *bytes_per_second) {
  enum { N = 1 << 24 };
  double *a = NULL, best = INFINITY;
  KITH_TRY(kith_resize(&a, 0, 3 * (size_t)N, sizeof *a));
  const double *b = a + N, *c = b + N;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const double start = kith_seconds();
#pragma omp parallel for schedule(static)
    for (int i = 0; i < N; ++i) a[i] = b[i] + 3 * c[i];
    best = KITH_MIN(best, kith_seconds() - start);
  }
  *bytes_per_second = 24.0 * N / best;
  kith_free(&a);
  return KITH_OK;
}

static double plain_density(const struct kith_simulation *m, kith_index i) {
  const struct kith_rows *rows = &m->connectivity->rows;
  const double *x = m->nodes->position->f64, *mass = m->hydro.mass->f64,
               inverse = 1 / m->nodes->support->f64[i];
  double sum = mass[i];
  for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
    const kith_index j = rows->node[k];
    const double q = sqrt(kith_distance2(x + (size_t)i * NDIM, x + (size_t)j * NDIM)) * inverse;
    if (q < 1) sum += mass[j] * (1 - q) * (1 - q) * (1 - q) * (1 - q) * (1 + 4 * q);
  }
  return sum;
}

/* (1 - q)^3 / H^(d + 2), 0 outside */
static inline double slope(double left, double inverse) {
  return left > 0 ? left * left * left * kith_pow_dim(inverse) * inverse * inverse : 0;
}

static double plain_force(const struct kith_simulation *m, kith_index i) {
  const struct kith_rows *rows = &m->connectivity->rows;
  const struct kith_hydro *h = &m->hydro;
  const double *x = m->nodes->position->f64, *v = h->velocity->f64, *p = h->pressure->f64,
               *rho = h->density->f64;
  double sum[NDIM] = {0}, rate = 0;
  for (size_t k = rows->first[i]; k < rows->first[i + 1]; ++k) {
    const kith_index j = rows->node[k];
    double d[NDIM], r2 = 0, vx = 0;
    for (int a = 0; a < NDIM; ++a) {
      d[a] = x[(size_t)i * NDIM + a] - x[(size_t)j * NDIM + a];
      r2 += d[a] * d[a];
      vx += (v[(size_t)i * NDIM + a] - v[(size_t)j * NDIM + a]) * d[a];
    }
    const double r = sqrt(r2), hi = 1 / m->nodes->support->f64[i], hj = 1 / m->nodes->support->f64[j];
    const double gi = slope(1 - r * hi, hi), gj = slope(1 - r * hj, hj);
    const double mu = vx < 0 ? vx / r : 0, sound = 0.5 * (h->sound_speed->f64[i] + h->sound_speed->f64[j]);
    const double viscosity = (2 * mu * mu - sound * mu) / (rho[i] + rho[j]);
    const double f = h->mass->f64[j] *
                     (p[i] / (rho[i] * rho[i]) * gi + p[j] / (rho[j] * rho[j]) * gj + viscosity * (gi + gj));
    for (int a = 0; a < NDIM; ++a) sum[a] += f * d[a];
    rate -= f * vx;
  }
  return rate + kith_norm(sum);
}

/* Seconds per node of a sum over the rows of a simulation: one scalar loop, fixed supports, nothing kept;
 * best of three. */
static double time_of(const struct kith_simulation *m,
                      double (*node)(const struct kith_simulation *, kith_index)) {
  double best = INFINITY;
  for (int repeat = 0; repeat < 3; ++repeat) {
    double sink = 0;
    const double start = kith_seconds();
#pragma omp parallel for schedule(static) reduction(+ : sink)
    for (kith_index i = 0; i < m->nodes->n_internal; ++i) sink += node(m, i);
    const double seconds = kith_seconds() - start;
    if (isfinite(sink)) best = KITH_MIN(best, seconds); /* the sum is used, so the loop stays */
  }
  return best / m->nodes->n_internal;
}

/* ---- one run ---- */

static void take_stages(const struct kith_profile *profile, double updates, struct figures *out) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  for (int k = 0; k < n; ++k) {
    if (strcmp(stage[k].path, "step") == 0) out->step = 1e9 * stage[k].seconds / updates;
    if (strncmp(stage[k].path, "step/", 5) != 0 || out->n_stages == MOST_STAGES) continue;
    snprintf(out->path[out->n_stages], sizeof out->path[0], "%s", stage[k].path + 5);
    out->sum += out->ns[out->n_stages++] = 1e9 * stage[k].self_seconds / updates;
  }
}

static kith_status time_steps(struct kith_simulation *m, const struct kith_options *options,
                              struct figures *out) {
  struct kith_integrator *it = &m->integrator;
  const uint64_t wanted = options->steps >= 0 ? (uint64_t)options->steps : 10;
  const struct kith_totals before = kith_hydro_totals(&m->hydro);
  KITH_TRY(kith_simulation_start(m));
  const double start = kith_seconds();
  while (it->step < wanted && it->time < m->scene->until) KITH_TRY(kith_integrator_step(it, m->scene->until));
  const double seconds = kith_seconds() - start, n = m->nodes->n_internal, updates = n * (double)it->step;
  const struct kith_totals after = kith_hydro_totals(&m->hydro);
  *out = (struct figures){
      .nodes = n,
      .updates = updates / seconds,
      .neighbors = (double)it->ledger.last_row_entries / n,
      .rebuilds = (double)it->ledger.lifecycles - 1,
      .energy_drift = (after.kinetic + after.internal) / (before.kinetic + before.internal) - 1};
  take_stages(m->profile, updates, out);
  kith_simulation_bytes(m, out->bytes);
  return KITH_OK;
}

static kith_status run_row(const struct kith_options *options, const struct row *row, int threads,
                           bool reference, struct figures *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 2];
  int n = 0;
  struct kith_scene *scene = NULL;
  struct kith_profile *profile = NULL;
  struct kith_simulation *m = NULL;
  for (int k = 0; k < 2 && row->setting[k] != NULL; ++k) overrides[n++] = row->setting[k];
  for (int k = 0; k < options->n_overrides; ++k) overrides[n++] = options->overrides[k];
  omp_set_num_threads(threads);
  kith_status status = kith_scene_parse(&scene, "bench", scene_text, sizeof scene_text - 1, n, overrides);
  if (status == KITH_OK) status = kith_profile_create(&profile, threads, false);
  if (status == KITH_OK) status = kith_simulation_create(&m, scene, profile, false);
  if (status == KITH_OK) status = time_steps(m, options, out);
  if (status == KITH_OK && reference)
    out->plain_density = time_of(m, plain_density), out->plain_force = time_of(m, plain_force);
  kith_simulation_destroy(&m);
  kith_profile_destroy(&profile);
  kith_scene_destroy(&scene);
  return status;
}

/* ---- tables ---- */

static void print_line(const char *what, double one, double all, bool both) {
  printf("  %-40s %12.1f", what, one);
  if (both) printf(" %12.1f %8.2f", all, one / all);
  printf("\n");
}

/* One thread and all threads beside each other, and the memory. */
static void print_stages(const char *what, const struct figures *one, const struct figures *all,
                         int threads) {
  const bool both = threads > 1;
  double bytes = 0;
  printf("\n  %s\n  %-40s %12s", what, "ns per node and step, own time of a stage", "1 thread");
  if (both) printf(" %4d threads %8s", threads, "ratio");
  printf("\n");
  for (int k = 0; k < one->n_stages; ++k)
    print_line(one->path[k], one->ns[k], k < all->n_stages ? all->ns[k] : 0, both);
  print_line("outside of any stage", one->step - one->sum, all->step - all->sum, false);
  print_line("step", one->step, all->step, both);
  if (one->plain_density > 0) {
    print_line("reference: plain density loop", 1e9 * one->plain_density, 1e9 * all->plain_density, both);
    print_line("reference: plain force loop", 1e9 * one->plain_force, 1e9 * all->plain_force, both);
  }
  printf("  bytes per node:");
  for (int k = 0; k < KITH_SIMULATION_STRUCTURES; ++k) {
    bytes += (double)one->bytes[k].bytes / one->nodes;
    printf(" %s %.0f,", one->bytes[k].name, (double)one->bytes[k].bytes / one->nodes);
  }
  printf(" in all %.0f\n", bytes);
}

/* Runs a row on one thread, and on all if stages are wanted; prints it. A row that cannot run ends the
 * bench. */
static kith_status bench_row(const struct kith_options *options, const struct row *row, int all,
                             bool reference, struct figures f[2]) {
  const int threads[] = {1, all};
  for (int k = 0; k < (row->stages && all > 1 ? 2 : 1); ++k) {
    KITH_TRY(run_row(options, row, threads[k], reference, &f[k]));
    printf("  %-36s %7d %11.3g %10.0f %9.0f %12.1f %13.1e\n", row->what, threads[k], f[k].updates,
           1e9 / f[k].updates, f[k].rebuilds, f[k].neighbors, f[k].energy_drift);
    fflush(stdout);
  }
  return KITH_OK;
}

#define LISTS "connectivity.rebuild=displacement"
static const struct row rows[] = {
    {"thermal, rows rebuilt each step", true, {NULL}},
    {"thermal, traversal pairs", false, {"traversal=pairs"}},
    {"compatible", false, {"method.energy=compatible"}},
    {"compatible, traversal pairs", false, {"method.energy=compatible", "traversal=pairs"}},
    {"thermal, displacement, skin 0.05", false, {LISTS, "connectivity.skin=0.05"}},
    {"thermal, displacement, skin 0.1", false, {LISTS, "connectivity.skin=0.1"}},
    {"thermal, displacement, skin 0.2", false, {LISTS, "connectivity.skin=0.2"}}};

static kith_status bench(const struct kith_options *options, int all) {
  struct figures first[2] = {{0}}, f[2] = {{0}};
  printf("kith bench: 3-D Sedov, kith %s, %s, %s\n\n", kith_version, kith_compiler, kith_flags);
  printf("  %-36s %7s %11s %10s %9s %12s %13s\n", "case", "threads", "updates/s", "ns/update", "rebuilds",
         "row entries", "energy drift");
  for (size_t k = 0; k < sizeof rows / sizeof *rows; ++k)
    KITH_TRY(bench_row(options, &rows[k], all, k == 0, k == 0 ? first : f));
  print_stages(rows[0].what, &first[0], &first[1], all);
  for (const struct kith_package_ops *const *p = kith_package_all() + 1; *p != NULL; ++p) {
    char setting[64], what[64];
    snprintf(setting, sizeof setting, "method.package=%s", (*p)->name);
    snprintf(what, sizeof what, "package %s, thermal", (*p)->name);
    printf("\n");
    const struct row row = {what, true, {setting}};
    KITH_TRY(bench_row(options, &row, all, false, f));
    print_stages(what, &f[0], &f[1], all);
  }
  double one, both;
  omp_set_num_threads(1);
  KITH_TRY(reference_triad(&one));
  omp_set_num_threads(all);
  KITH_TRY(reference_triad(&both));
  printf("\n  reference: triad on one thread %.1f GB/s, on %d %.1f GB/s\n", 1e-9 * one, all, 1e-9 * both);
  return KITH_OK;
}

enum kith_exit kith_bench(const struct kith_options *options) {
  if (bench(options, omp_get_max_threads()) == KITH_OK) return KITH_EXIT_OK;
  fprintf(stderr, "kith: %s\n", kith_failure());
  return KITH_EXIT_FAILED;
}
