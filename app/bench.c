#include "app/bench.h"

#include <omp.h>
#include <stdio.h>
#include <string.h>
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

struct figures {
  double updates, seconds, neighbors, rebuilds, energy_drift;
};


static void print_bytes(const struct kith_model *m) {
  struct kith_bytes bytes[KITH_MODEL_STRUCTURES];
  kith_model_bytes(m, bytes);
  double total = 0, pairwise = 0;
  printf("\n  bytes per node");
  for (int k = 0; k < KITH_MODEL_STRUCTURES; ++k) {
    const double each = (double)bytes[k].bytes / m->nodes->n_internal;
    printf("  %s %.0f", bytes[k].name, each);
    total += each;
    if (strcmp(bytes[k].name, "pairwise") == 0) pairwise = each;
  }
  printf("  all %.0f, without pairwise %.0f\n", total, total - pairwise);
}

/* Self time of every stage of the step, in ns per node and step; that of the reference loops beside it. */
static void print_stages(const struct kith_profile *profile, const struct kith_model *m, uint64_t steps) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  const double updates = (double)m->nodes->n_internal * (double)steps;
  double density, force, whole = 0, stages = 0;
  printf("\n  %-44s %12s %8s\n", "stage (its own time)", "ns per node", "share");
  for (int k = 0; k < n; ++k)
    if (strcmp(stage[k].path, "step") == 0) whole = stage[k].seconds;
  for (int k = 0; k < n; ++k) {
    if (strncmp(stage[k].path, "step/", 5) != 0) continue;
    printf("  %-44s %12.1f %7.1f%%\n", stage[k].path + 5, 1e9 * stage[k].self_seconds / updates, 100 * stage[k].self_seconds / whole);
    stages += stage[k].self_seconds;
  }
  printf("  %-44s %12.1f %7.1f%%\n", "outside of any stage", 1e9 * (whole - stages) / updates, 100 * (whole - stages) / whole);
  kith_reference_loops(m, &density, &force);
  printf("  reference: plain density loop %.0f ns per node, plain force loop %.0f ns per node\n", 1e9 * density, 1e9 * force);
}

static kith_status time_steps(struct kith_model *m, const struct kith_options *options, uint64_t *steps, double *seconds) {
  struct kith_integrator *it = &m->integrator;
  const uint64_t wanted = options->steps >= 0 ? (uint64_t)options->steps : 10;
  KITH_TRY(kith_integrator_start(it));
  const double start = kith_seconds();
  while (it->step < wanted && it->time < m->scene->until) KITH_TRY(kith_integrator_step(it, m->scene->until));
  *seconds = kith_seconds() - start;
  *steps = it->step;
  return KITH_OK;
}

static kith_status run_row(const struct kith_options *options, const struct row *row, bool show, struct figures *out) {
  const char *overrides[KITH_MAX_OVERRIDES + 4];
  int n = 0;
  for (int k = 0; k < row->n_settings; ++k) overrides[n++] = row->settings[k];
  for (int k = 0; k < options->n_overrides; ++k) overrides[n++] = options->overrides[k];
  struct kith_scene *scene = NULL;
  struct kith_profile *profile = NULL;
  struct kith_model *m = NULL;
  uint64_t steps = 0;
  omp_set_num_threads(row->threads);
  kith_status status = kith_scene_parse(&scene, "bench", scene_text, sizeof scene_text - 1, n, overrides);
  if (status == KITH_OK) status = kith_profile_create(&profile, row->threads, false);
  if (status == KITH_OK) status = kith_model_create(&m, scene, profile, false);
  if (status == KITH_OK) {
    const struct kith_totals before = kith_hydro_totals(&m->hydro);
    status = time_steps(m, options, &steps, &out->seconds);
    const struct kith_totals after = kith_hydro_totals(&m->hydro);
    out->energy_drift = (after.kinetic + after.internal) / (before.kinetic + before.internal) - 1;
  }
  if (status == KITH_OK) {
    out->updates = (double)m->nodes->n_internal * (double)steps / out->seconds;
    out->neighbors = (double)m->integrator.ledger.last_entries / m->nodes->n_internal;
    out->rebuilds = (double)m->integrator.ledger.lifecycles - 1;
    if (show) {
      print_stages(profile, m, steps);
      print_bytes(m);
    }
  }
  kith_model_destroy(&m);
  kith_profile_destroy(&profile);
  kith_scene_destroy(&scene);
  return status;
}

enum kith_exit kith_bench(const struct kith_options *options) {
  const int all = omp_get_max_threads();
  const struct row rows[] = {
      {"thermal, rebuilt each step", 1, 0, {NULL}},
      {"thermal, rebuilt each step", all, 0, {NULL}},
      {"compatible, rebuilt each step", 1, 1, {"method.energy=compatible"}},
      {"compatible, gather", 1, 2, {"method.energy=compatible", "traversal=gather"}},
      {"thermal, pairs", 1, 1, {"traversal=pairs"}},
      {"thermal, displacement, skin 0.05", 1, 2, {"connectivity.rebuild=displacement", "connectivity.skin=0.05"}},
      {"thermal, displacement, skin 0.1", 1, 2, {"connectivity.rebuild=displacement", "connectivity.skin=0.1"}},
      {"thermal, displacement, skin 0.2", 1, 2, {"connectivity.rebuild=displacement", "connectivity.skin=0.2"}},
  };
  double triad;
  printf("kith bench: 3-D Sedov, %s, %s\n", kith_version(), kith_build());
  for (size_t k = 0; k < sizeof rows / sizeof rows[0]; ++k) {
    struct figures f;
    if (k == 1 && all == 1) continue;
    if (run_row(options, &rows[k], k == 0, &f) != KITH_OK) {
      fprintf(stderr, "kith: %s\n", kith_failure());
      return KITH_EXIT_FAILED;
    }
    if (k == 0)
      printf("\n  %-34s %7s %12s %10s %9s %11s %12s\n", "case", "threads", "updates/s", "ns/update", "rebuilds", "row entries",
             "energy drift");
    printf("  %-34s %7d %12.3g %10.0f %9.0f %11.1f %12.1e\n", rows[k].what, rows[k].threads, f.updates, 1e9 / f.updates, f.rebuilds,
           f.neighbors, f.energy_drift);
    fflush(stdout);
  }
  omp_set_num_threads(1);
  if (kith_reference_triad(&triad) == KITH_OK) printf("\n  reference: triad on one thread %.1f GB/s", 1e-9 * triad);
  omp_set_num_threads(all);
  if (kith_reference_triad(&triad) == KITH_OK) printf(", on %d threads %.1f GB/s\n", all, 1e-9 * triad);
  return KITH_EXIT_OK;
}
