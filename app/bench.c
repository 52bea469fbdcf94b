#include "app/bench.h"

#include <omp.h>
#include <stdio.h>
#include <string.h>
#include "app/bench_ranks.h"
#include "app/bench_reference.h"
#include "app/version.h"

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
  int threads, n_settings;
  const char *settings[3];
};

enum { MOST_STAGES = 48 };

/* Own time of the stages of the step, in ns per node and step; the sum of all, and of the step itself. */
struct stages {
  int n;
  char path[MOST_STAGES][64];
  double ns[MOST_STAGES], sum, step;
  double plain_density, plain_force; /* reference loops on the same rows */
};

struct figures {
  double updates, neighbors, rebuilds, energy_drift;
  struct stages stages;
  struct kith_bytes bytes[KITH_MODEL_STRUCTURES];
  double nodes;
};

static void take_stages(const struct kith_profile *profile, double updates, struct stages *out) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  *out = (struct stages){0};
  for (int k = 0; k < n; ++k) {
    if (strcmp(stage[k].path, "step") == 0) out->step = 1e9 * stage[k].seconds / updates;
    if (strncmp(stage[k].path, "step/", 5) != 0 || out->n == MOST_STAGES) continue;
    snprintf(out->path[out->n], sizeof out->path[0], "%s", stage[k].path + 5);
    out->sum += out->ns[out->n++] = 1e9 * stage[k].self_seconds / updates;
  }
}

static void print_line(const char *what, double one, double all, bool both) {
  printf("  %-40s %12.1f", what, one);
  if (both) printf(" %12.1f %8.2f", all, one / all);
  printf("\n");
}

/* One thread and all threads beside each other. */
static void print_stages(const struct stages *one, const struct stages *all, int threads) {
  const bool both = threads > 1;
  printf("\n  %-40s %12s", "ns per node and step, own time of a stage", "1 thread");
  if (both) printf(" %4d threads %8s", threads, "ratio");
  printf("\n");
  for (int k = 0; k < one->n; ++k) print_line(one->path[k], one->ns[k], k < all->n ? all->ns[k] : 0, both);
  print_line("outside of any stage", one->step - one->sum, all->step - all->sum, false);
  print_line("step", one->step, all->step, both);
  if (!(one->plain_density > 0)) return;
  print_line("reference: plain density loop", one->plain_density, all->plain_density, both);
  print_line("reference: plain force loop", one->plain_force, all->plain_force, both);
}

static void print_bytes(const struct figures *f) {
  double total = 0, pairwise = 0;
  printf("\n  bytes per node:");
  for (int k = 0; k < KITH_MODEL_STRUCTURES; ++k) {
    const double each = (double)f->bytes[k].bytes / f->nodes;
    printf(" %s %.0f,", f->bytes[k].name, each);
    total += each;
    if (strcmp(f->bytes[k].name, "pairwise") == 0) pairwise = each;
  }
  printf(" all but pairwise %.0f\n", total - pairwise);
}

static kith_status time_steps(struct kith_model *m, const struct kith_options *options, uint64_t *steps,
                              double *seconds) {
  struct kith_integrator *it = &m->integrator;
  const uint64_t wanted = options->steps >= 0 ? (uint64_t)options->steps : 10;
  KITH_TRY(kith_model_start(m));
  const double start = kith_seconds();
  while (it->step < wanted && it->time < m->scene->until) KITH_TRY(kith_integrator_step(it, m->scene->until));
  *seconds = kith_seconds() - start;
  *steps = it->step;
  return KITH_OK;
}

static void take_figures(const struct kith_model *m, const struct kith_profile *profile, uint64_t steps,
                         double seconds, struct figures *out) {
  out->nodes = m->nodes->n_internal;
  out->updates = out->nodes * (double)steps / seconds;
  out->neighbors = (double)m->integrator.ledger.last_entries / out->nodes;
  out->rebuilds = (double)m->integrator.ledger.lifecycles - 1;
  take_stages(profile, out->nodes * (double)steps, &out->stages);
  kith_model_bytes(m, out->bytes);
}

static kith_status run_row(const struct kith_options *options, const struct row *row, bool reference,
                           struct figures *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 4];
  int n = 0;
  for (int k = 0; k < row->n_settings; ++k) overrides[n++] = row->settings[k];
  for (int k = 0; k < options->n_overrides; ++k) overrides[n++] = options->overrides[k];
  struct kith_scene *scene = NULL;
  struct kith_profile *profile = NULL;
  struct kith_model *m = NULL;
  uint64_t steps = 0;
  double seconds = 0;
  omp_set_num_threads(row->threads);
  kith_status status = kith_scene_parse(&scene, "bench", scene_text, sizeof scene_text - 1, n, overrides);
  if (status == KITH_OK) status = kith_profile_create(&profile, row->threads, false);
  if (status == KITH_OK) status = kith_model_create(&m, scene, profile, false);
  if (status == KITH_OK) {
    const struct kith_totals before = kith_hydro_totals(&m->hydro);
    status = time_steps(m, options, &steps, &seconds);
    const struct kith_totals after = kith_hydro_totals(&m->hydro);
    out->energy_drift = (after.kinetic + after.internal) / (before.kinetic + before.internal) - 1;
  }
  if (status == KITH_OK) take_figures(m, profile, steps, seconds, out);
  if (status == KITH_OK && reference) {
    kith_reference_loops(m, &out->stages.plain_density, &out->stages.plain_force);
    out->stages.plain_density *= 1e9, out->stages.plain_force *= 1e9;
  }
  kith_model_destroy(&m);
  kith_profile_destroy(&profile);
  kith_scene_destroy(&scene);
  return status;
}

static void print_row(const struct row *row, const struct figures *f) {
  printf("  %-36s %7d %11.3g %10.0f %9.0f %12.1f %13.1e\n", row->what, row->threads, f->updates,
         1e9 / f->updates, f->rebuilds, f->neighbors, f->energy_drift);
  fflush(stdout);
}

static void print_triad(int all) {
  double triad;
  omp_set_num_threads(1);
  if (kith_reference_triad(&triad) == KITH_OK)
    printf("\n  reference: triad on one thread %.1f GB/s", 1e-9 * triad);
  omp_set_num_threads(all);
  if (kith_reference_triad(&triad) == KITH_OK) printf(", on %d %.1f GB/s\n", all, 1e-9 * triad);
}

/* A row that cannot run ends the bench; *f is filled and printed. */
static bool bench_row(const struct kith_options *options, const struct row *row, bool reference,
                      struct figures *f) {
  const bool ran = run_row(options, row, reference, f) == KITH_OK;
  if (ran)
    print_row(row, f);
  else
    fprintf(stderr, "kith: %s\n", kith_failure());
  return ran;
}

/* The packages beside the default one, each on one thread and on all. */
static bool bench_packages(const struct kith_options *options, int all) {
  for (const struct kith_package_ops *const *p = kith_package_all() + 1; *p != NULL; ++p) {
    char setting[64], what[64];
    struct figures f[2] = {{0}};
    snprintf(setting, sizeof setting, "method.package=%s", (*p)->name);
    snprintf(what, sizeof what, "package %s, thermal", (*p)->name);
    printf("\n");
    for (int k = 0; k < (all > 1 ? 2 : 1); ++k) {
      const struct row row = {what, k == 0 ? 1 : all, 1, {setting}};
      if (!bench_row(options, &row, false, &f[k])) return false;
    }
    print_stages(&f[0].stages, &f[1].stages, all);
    print_bytes(&f[0]);
  }
  return true;
}

enum kith_exit kith_bench(const struct kith_options *options) {
  if (options->ranks > 1) return kith_bench_ranks(options);
  if (options->subject != NULL) {
    fprintf(stderr, "kith: bench %.60s: a scene is for --ranks N; without, the case is always the same\n",
            options->subject);
    return KITH_EXIT_USAGE;
  }
  const int all = omp_get_max_threads();
  const struct row rows[] = {
      {"thermal, rows rebuilt each step", 1, 0, {NULL}},
      {"thermal, rows rebuilt each step", all, 0, {NULL}},
      {"thermal, traversal pairs", 1, 1, {"traversal=pairs"}},
      {"compatible", 1, 1, {"method.energy=compatible"}},
      {"compatible, traversal pairs", 1, 2, {"method.energy=compatible", "traversal=pairs"}},
      {"thermal, displacement, skin 0.05",
       1,
       2,
       {"connectivity.rebuild=displacement", "connectivity.skin=0.05"}},
      {"thermal, displacement, skin 0.1",
       1,
       2,
       {"connectivity.rebuild=displacement", "connectivity.skin=0.1"}},
      {"thermal, displacement, skin 0.2",
       1,
       2,
       {"connectivity.rebuild=displacement", "connectivity.skin=0.2"}},
  };
  enum { ROWS = sizeof rows / sizeof rows[0] };
  struct figures f[ROWS] = {{0}};
  printf("kith bench: 3-D Sedov, kith %s, %s\n\n", kith_version(), kith_build());
  printf("  %-36s %7s %11s %10s %9s %12s %13s\n", "case", "threads", "updates/s", "ns/update", "rebuilds",
         "row entries", "energy drift");
  for (int k = 0; k < ROWS; ++k) {
    if (k == 1 && all == 1) continue;
    if (!bench_row(options, &rows[k], k < 2, &f[k])) return KITH_EXIT_FAILED;
  }
  print_stages(&f[0].stages, &f[1].stages, all);
  print_bytes(&f[0]);
  if (!bench_packages(options, all)) return KITH_EXIT_FAILED;
  print_triad(all);
  return KITH_EXIT_OK;
}
