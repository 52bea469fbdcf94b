/* bench.c - `kith bench`: node updates per second, and for each stage its self time (without the stages below
 * it), also per row entry, the bytes that it has to move, and how its speed compares with the bandwidth of
 * memory and with plain loops that are timed in the same session.
 *
 * The case is a Sedov blast with 10^6 nodes (100^3; --set resolution=N): every node in each step, doubles,
 * adaptive supports (60 neighbors in 3-D), Wendland C2, nodes in the order of the curve. 10 steps (--steps
 * N) after the first rates are timed. Every package is run, or that of --set method.package=NAME: with its
 * defaults on one thread and on all threads, and with the other traversal on one thread. Ratios to the
 * reference loops can be compared between machines.
 *
 * The last line is the figure of merit of the first package, with its defaults on all threads.
 *
 * Bytes (counter "bytes") are the least that the data layout of a stage moves: each array that it needs is
 * counted once, with its ghosts. The share of the triad says how far a stage is from its memory bound. */
#include "app/cli/options.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/output/report.h"
#include "lib/core/version.h"

#if NDIM == 1
#define SIZE "dimension: 1\nresolution: 1000000\nmethod: {kernel: wendland-c2}\n"
#elif NDIM == 2
#define SIZE "dimension: 2\nresolution: 1000\nmethod: {kernel: wendland-c2}\n"
#else
#define SIZE "dimension: 3\nresolution: 100\nmethod: {kernel: wendland-c2, neighbors: 60}\n"
#endif
static const char scene_text[] = "scene: bench\n" SIZE
                                 "domain: {lower: [-0.5, -0.5, -0.5], upper: [0.5, 0.5, 0.5]}\n"
                                 "boundaries: {x: periodic, y: periodic, z: periodic}\n"
                                 "materials: {gas: {eos: ideal, gamma: 1.6666666666666667}}\n"
                                 "regions: [{material: gas, lattice: cubic, density: 1, pressure: 1e-6}]\n"
                                 "energy: {energy: 1, center: [0, 0, 0], over: kernel, spacings: 2.4}\n"
                                 "until: 0.05\n";

/* Results of one run. */
struct figures {
  double updates, per_second, rebuilds, energy_drift;
  double candidates, entries, pairs; /* per node and step; pairs: pair evaluations */
  double plain_density, plain_force; /* ns per node of the reference loops on the same rows */
  enum kith_traversal traversal;
  struct kith_fom fom;
  struct kith_profile *profile; /* owned */
};

/* ---- reference loops, as anybody could have written them ---- */

/* Bytes per second of a[i] = b[i] + 3 c[i], 2^24 doubles, 24 bytes counted an element; best of five. */
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

/* (1 - q)^3 / H^(d + 2), 0 outside of the support; left = 1 - q, inverse = 1 / H */
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

/* Times a sum over the rows of each node, in which nothing is stored: nanoseconds per node, best of three. */
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
  return 1e9 * best / m->nodes->n_internal;
}

static kith_status time_steps(struct kith_simulation *m, const struct kith_options *options,
                              struct figures *out) {
  struct kith_integrator *it = &m->integrator;
  const uint64_t wanted = options->steps >= 0 ? (uint64_t)options->steps : 10;
  const struct kith_totals before = kith_hydro_totals(&m->hydro);
  KITH_TRY(kith_simulation_start(m));
  const uint64_t evaluated = m->package.pair_evaluations, updated = it->ledger.updates,
                 rebuilt = it->ledger.lifecycles;
  const double start = kith_seconds();
  while (it->step < wanted && it->time < m->scene->until) KITH_TRY(kith_simulation_step(m, m->scene->until));
  const double seconds = kith_seconds() - start,
               updates = it->nodes->activity != NULL ? (double)(it->ledger.updates - updated)
                                                     : (double)m->nodes->n_internal * (double)it->step;
  const struct kith_totals after = kith_hydro_totals(&m->hydro);
  static const char lists[] = "step/lifecycle/connectivity";
  out->updates = updates, out->per_second = updates / seconds;
  out->rebuilds = (double)(it->ledger.lifecycles - rebuilt);
  out->energy_drift = (after.kinetic + after.internal) / (before.kinetic + before.internal) - 1;
  out->traversal = m->package.traversal;
  out->candidates = kith_profile_counted(m->profile, lists, "candidates") / updates;
  out->entries = kith_profile_counted(m->profile, lists, "row entries") / updates;
  out->pairs = (double)(m->package.pair_evaluations - evaluated) / updates;
  out->fom = (struct kith_fom){out->per_second, out->per_second / omp_get_max_threads(),
                               out->pairs * out->per_second,
                               kith_profile_counted(m->profile, "step/", "bytes") / updates};
  return KITH_OK;
}

/* Reads the scene of a case: with each `setting` that is not NULL, then those of the command line. */
static kith_status read_scene(const struct kith_options *options, const char *const setting[2],
                              struct kith_scene **scene) {
  const char *overrides[KITH_MAX_OVERRIDES + 2];
  int n = 0;
  for (int k = 0; k < 2 && setting[k] != NULL; ++k) overrides[n++] = setting[k];
  for (int k = 0; k < options->n_overrides; ++k) overrides[n++] = options->overrides[k];
  return kith_scene_parse(scene, "bench", scene_text, sizeof scene_text - 1, n, overrides);
}

/* Does the scene of a case have the package and traversal of its settings, or those of the command line? */
static kith_status is_case(const struct kith_options *options, const char *const setting[2], bool *is) {
  struct kith_scene *scene = NULL;
  KITH_TRY(read_scene(options, setting, &scene));
  *is = strcmp(scene->method.package.name, strchr(setting[0], '=') + 1) == 0 &&
        (setting[1] == NULL || strcmp(scene->traversal, strchr(setting[1], '=') + 1) == 0);
  kith_scene_destroy(&scene);
  return KITH_OK;
}

/* Runs a case. `loops`: the reference loops are timed too, on the rows of the last step. */
static kith_status run_case(const struct kith_options *options, const char *const setting[2], int threads,
                            bool loops, struct figures *out) {
  struct kith_scene *scene = NULL;
  struct kith_simulation *m = NULL;
  omp_set_num_threads(threads);
  kith_status status = read_scene(options, setting, &scene);
  if (status == KITH_OK) status = kith_profile_create(&out->profile, threads, false);
  if (status == KITH_OK) status = kith_simulation_create(&m, scene, NULL, out->profile, false);
  if (status == KITH_OK) status = time_steps(m, options, out);
  if (status == KITH_OK && loops)
    out->plain_density = time_of(m, plain_density), out->plain_force = time_of(m, plain_force);
  kith_simulation_destroy(&m);
  kith_scene_destroy(&scene);
  return status;
}

/* Runs a case and prints its line. Without a `base` the case times its own reference loops. */
static kith_status bench_case(const struct kith_options *options, const char *const setting[2], int threads,
                              const struct figures *base, struct figures *f) {
  char what[64];
  KITH_TRY(run_case(options, setting, threads, base == NULL, f));
  if (base == NULL) base = f;
  snprintf(what, sizeof what, "%s%s %s", strchr(setting[0], '=') + 1, setting[1] != NULL ? "," : "",
           setting[1] != NULL ? setting[1] : "");
  printf("  %-40s %7d %11.3g %10.0f %10.2f %9.0f %13.1e\n", what, threads, f->per_second, 1e9 / f->per_second,
         1e9 / f->per_second / (base->plain_density + base->plain_force), f->rebuilds, f->energy_drift);
  fflush(stdout);
  return KITH_OK;
}

static void print_line(const char *what, const struct figures *f, double ns, double bytes, double plain,
                       double triad, double ns_all) {
  printf("  %-28s %8.1f", what, ns);
  kith_text_cell(stdout, 8, 2, bytes > 0 ? ns / f->entries : 0);
  kith_text_cell(stdout, 7, 0, bytes);
  kith_text_cell(stdout, 7, 2, bytes / ns);
  kith_text_cell(stdout, 8, 3, bytes / ns / triad);
  kith_text_cell(stdout, 10, 2, plain > 0 ? ns / plain : 0);
  if (ns_all > 0) printf(" %10.1f %8.2f", ns_all, ns / ns_all);
  printf("\n");
}

/* Nanoseconds per node and step of a stage: its own, or with the stages below it. 0 if there is no stage. */
static double ns_of(const struct figures *f, int stage, bool own) {
  const struct kith_stage *of;
  if (f == NULL || stage >= kith_profile_stages(f->profile, &of)) return 0;
  return 1e9 * (own ? of[stage].self_seconds : of[stage].seconds) / f->updates;
}

/* Prints the stages on one thread, beside triad and reference loops, and on all (NULL if there is one). */
static void print_stages(const char *package, const struct figures *one, const struct figures *all,
                         double triad, int threads) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(one->profile, &stage);
  double traffic = 0, rows = 0;
  int step = 0;
  while (step < n && strcmp(stage[step].path, "step") != 0) ++step;
  double rest = ns_of(one, step, false);
  printf("\n  %-28s %8s %8s %7s %7s %8s %10s", package, "self ns", "ns/entry", "bytes", "GB/s", "of triad",
         "over plain");
  if (all != NULL) printf(" %2d threads %8s", threads, "speed-up");
  printf("\n");
  for (int k = step + 1; k < n && stage[k].depth > 0; ++k) { /* those below the step */
    const char *path = stage[k].path + strlen("step/"), *name = stage[k].name;
    const bool lists = strncmp(path, "lifecycle/", 10) == 0, density = strcmp(name, "density") == 0,
               force = !lists && (strcmp(name, "force") == 0 || strcmp(name, "pairs") == 0);
    const double ns = ns_of(one, k, true),
                 bytes = kith_profile_counted(one->profile, stage[k].path, "bytes") / one->updates;
    if (lists && strcmp(name, "rows") == 0) rows = ns;
    print_line(path, one, ns, bytes, density * one->plain_density + force * one->plain_force, triad,
               ns_of(all, k, true));
    rest -= ns, traffic += bytes;
  }
  print_line("outside of any stage", one, rest, 0, 0, triad, 0);
  print_line("step", one, ns_of(one, step, false), traffic, one->plain_density + one->plain_force, triad,
             ns_of(all, step, false));
  print_line("reference: plain density", one, one->plain_density, 0, 0, triad,
             all != NULL ? all->plain_density : 0);
  print_line("reference: plain force", one, one->plain_force, 0, 0, triad,
             all != NULL ? all->plain_force : 0);
  printf(
      "  a node and step: %.2f candidates, %.3f ns each in rows; %.2f row entries, hit rate %.4f;"
      " %.2f pair evaluations\n\n",
      one->candidates, rows / one->candidates, one->entries, one->entries / one->candidates, one->pairs);
}

/* Runs and prints the cases of a package, unless the command line sets another package. Sets *fom unless it
 * was set by a package before. */
static kith_status bench_package(const struct kith_options *options, const char *package, int all,
                                 double triad, struct kith_fom *fom) {
  struct figures f[3] = {0}; /* on one thread, on all, by the other traversal */
  char setting[64];
  bool is;
  snprintf(setting, sizeof setting, "method.package=%s", package);
  KITH_TRY(is_case(options, (const char *[2]){setting}, &is));
  if (!is) return KITH_OK;
  kith_status status = bench_case(options, (const char *[2]){setting}, 1, NULL, &f[0]);
  if (status == KITH_OK && all > 1)
    status = bench_case(options, (const char *[2]){setting}, all, NULL, &f[1]);
  const char *traversal = f[0].traversal == KITH_TRAVERSE_PAIRS ? "traversal=gather" : "traversal=pairs";
  if (status == KITH_OK) status = is_case(options, (const char *[2]){setting, traversal}, &is);
  if (status == KITH_OK && is)
    status = bench_case(options, (const char *[2]){setting, traversal}, 1, &f[0], &f[2]);
  if (status == KITH_OK) print_stages(package, &f[0], all > 1 ? &f[1] : NULL, triad, all);
  if (fom->updates_per_second == 0) *fom = f[all > 1].fom;
  for (int k = 0; k < 3; ++k) kith_profile_destroy(&f[k].profile);
  return status;
}

static kith_status bench(const struct kith_options *options, int all) {
  double one, many = 0;
  struct kith_fom first = {0};
  struct kith_scene *scene = NULL;
  KITH_TRY(read_scene(options, (const char *[2]){NULL}, &scene)); /* before anything is measured */
  const double until = scene->until, resolution = scene->resolution;
  kith_scene_destroy(&scene);
  if (options->steps == 0 || !(until > 0))
    KITH_FAIL(BAD_INPUT, "%s 0: there is nothing to time", options->steps == 0 ? "--steps" : "--set until");
  omp_set_num_threads(1);
  KITH_TRY(reference_triad(&one));
  omp_set_num_threads(all);
  if (all > 1) KITH_TRY(reference_triad(&many));
  printf("kith bench: %d-D Sedov, resolution %g, kith %s, %s, %s\n", NDIM, resolution, kith_version(),
         kith_compiler(), kith_flags());
  printf("  reference: triad on 1 thread %.2f GB/s", 1e-9 * one);
  if (all > 1) printf(", on %d %.2f GB/s", all, 1e-9 * many);
  printf("\n\n");
  printf("  %-40s %7s %11s %10s %10s %9s %13s\n", "case", "threads", "updates/s", "ns/update", "over plain",
         "rebuilds", "energy drift");
  for (const struct kith_package_ops *const *p = kith_package_all(); *p != NULL; ++p)
    KITH_TRY(bench_package(options, (*p)->name, all, 1e-9 * one, &first));
  kith_fom_print(&first);
  return KITH_OK;
}

enum kith_exit kith_bench(const struct kith_options *options) {
  const kith_status status = bench(options, omp_get_max_threads());
  if (status == KITH_OK) return KITH_EXIT_OK;
  fprintf(stderr, "kith: %s\n", kith_failure());
  return status == KITH_BAD_INPUT ? KITH_EXIT_USAGE : KITH_EXIT_FAILED;
}
