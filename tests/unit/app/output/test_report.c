/* test_report.c - report.json has every value of the list at its key, and those of the objects of a run; the
 * table fits into 100 columns; the profile; the trace. */
#include <math.h>
#include <stdlib.h>
#include <unistd.h>
#include "app/output/report.h"
#include "app/output/output.h"
#include "tests/unit/scenario.h"

static char path[] = "report-test-XXXXXX";

static json_t *written(const struct kith_report *report) {
  json_error_t error;
  CHECK_OK(kith_report_write(report, path));
  json_t *json = json_load_file(path, JSON_REJECT_DUPLICATES, &error);
  if (json == NULL) fprintf(stderr, "%d: %s\n", error.line, error.text);
  CHECK(json != NULL);
  return json;
}

/* Finds a value; `key` is a path whose parts are separated by '|'. */
static const json_t *at(const json_t *json, const char *key) {
  char part[128];
  for (const char *next = key; json != NULL && next != NULL; key = next + 1) {
    next = strchr(key, '|');
    snprintf(part, sizeof part, "%.*s", (int)(next != NULL ? next - key : (long)strlen(key)), key);
    json = json_object_get(json, part);
  }
  if (json == NULL) fprintf(stderr, "no key %s\n", key);
  CHECK(json != NULL);
  return json;
}

static void check_number(const json_t *json, const char *key, double value) {
  const json_t *number = at(json, key);
  const bool right =
      isfinite(value) ? json_number_value(number) == value && json_is_number(number) : json_is_null(number);
  if (!right) fprintf(stderr, "%s is not %.17g\n", key, value);
  CHECK(right);
}

static const struct kith_stage stages[] = {
    {.path = "step", .name = "step", .calls = 210, .seconds = 12.25},
    {.path = "step/connectivity", .name = "connectivity", .depth = 1, .calls = 35, .seconds = 3.5},
    {.path = "step/connectivity/a name that is far too long for the table it stands in",
     .name = "a name that is far too long for the table it stands in",
     .depth = 2,
     .calls = INT64_MAX,
     .seconds = 9.75},
};
static const struct kith_counter counters[] = {{"pairs", "step/connectivity", 4.25e6}, {"restarts", "", 2}};
static const bool measured[KITH_N_MEASURES] = {
    [KITH_MEASURE_mcnally] = true, [KITH_MEASURE_separation] = true};

static struct kith_report sample(void) {
  return (struct kith_report){.scene = "so\"d\\ \n\t\x01 \xc3\xa9",
                              .package = "sph",
                              .kernel = "wendland-c2",
                              .scheme = "leapfrog",
                              .dimension = NDIM,
                              .ranks = 1,
                              .threads = 2,
                              .nodes = 24000,
                              .gas_nodes = 23000,
                              .frozen_nodes = 64,
                              .steps = 210,
                              .time = 0.2,
                              .wall_seconds = 12.5,
                              .program_seconds = 13,
                              .cpu_seconds = 24.5,
                              .node_updates_per_second = 4.1e5,
                              .pairs_per_node = 30.25,
                              .pair_evaluations = 3.1e9,
                              .energy_drift = -1.5e-13,
                              .momentum_drift = INFINITY,
                              .momentum_axes = 2,
                              .angular_momentum_drift = 0.0625,
                              .kinetic_start = 0.5,
                              .kinetic_end = 0.25,
                              .kinetic_rebound = NAN,
                              .largest_mach = 0.75,
                              .final_mach = 0.125,
                              .measured = measured,
                              .measure = {[KITH_MEASURE_mcnally] = 0.125, [KITH_MEASURE_separation] = NAN},
                              .levels = {.time = 0.5,
                                         .base_steps = 2,
                                         .whole = 0.5,
                                         .level = {{.ticks = 2, .seconds = 1, .updates = 4, .held = 1.5},
                                                   {.ticks = 1, .seconds = 0.25, .updates = 2, .held = 0.5}}},
                              .compared = true,
                              .norms = {.density = {0.1, 0.2, 0.3},
                                        .velocity = {1e-300, 5e-324, 1.7e308},
                                        .pressure = {NAN, 0, -0.0},
                                        .energy = {1.0 / 3, 2, 3},
                                        .speed = {7, 8, 9},
                                        .speed_peak = 0.875,
                                        .nodes = 23000,
                                        .contact_pressure_error = 0.01,
                                        .shock_radius = 0.349,
                                        .shock_exact = 0.35,
                                        .shock_offset = -0.25,
                                        .shock_swept = 0.3475,
                                        .density_peak = 3.9},
                              .n_stages = 3,
                              .stages = stages,
                              .n_counters = 2,
                              .counters = counters,
                              .ledger = json_pack("{s:f, s:i}", "ghosts_created", 5e12, "odd \"name\"", 3),
                              .floors = INT64_MAX,
                              .version = "0.1.0",
                              .compiler = NULL,
                              .flags = ""};
}

/* Every value of the list is at its key. */
static void keys(void) {
  struct kith_report r = sample();
  json_t *json = written(&r);
#define CHECK_TEXT(key, value) \
  CHECK((value) == NULL ? json_is_null(at(json, key)) : strcmp(json_string_value(at(json, key)), value) == 0)
#define CHECK_COUNT(key, value) CHECK(json_integer_value(at(json, key)) == (value))
#define CHECK_REAL(key, value) check_number(json, key, value)
#define X(kind, member, key, value, unit, doc)     \
  {                                                \
    char parts[] = key, *dot = strchr(parts, '.'); \
    if (dot != NULL) *dot = '|';                   \
    CHECK_##kind(parts, r.member);                 \
  }
  KITH_REPORT_LIST(X)
#undef X
  check_number(json, "velocity_over_sound|end", 0.125);
  check_number(json, "measures|mcnally", 0.125), check_number(json, "measures|separation", NAN);
  CHECK(json_object_size(at(json, "measures")) == 2);
  check_number(json, "norms|density|l1", 0.1), check_number(json, "norms|density|linf", 0.3);
  check_number(json, "norms|velocity|l1", 1e-300), check_number(json, "norms|velocity|l2", 5e-324);
  check_number(json, "norms|velocity|linf", 1.7e308), check_number(json, "norms|pressure|l1", NAN);
  check_number(json, "norms|energy|l1", 1.0 / 3), check_number(json, "norms|speed|l1", 7);
  check_number(json, "norms|speed_peak", 0.875), check_number(json, "norms|nodes", 23000);
  check_number(json, "norms|contact_pressure_error", 0.01), check_number(json, "norms|density_peak", 3.9);
  check_number(json, "norms|shock_radius", 0.349), check_number(json, "norms|shock_exact", 0.35);
  check_number(json, "norms|shock_offset", -0.25), check_number(json, "norms|shock_swept", 0.3475);
  check_number(json, "stages|step|seconds", 12.25), check_number(json, "stages|step|calls", 210);
  check_number(json, "stages|step/connectivity|calls", 35);
  /* 6 updates instead of 4 nodes at 3 ticks, in 1 + 0.25 seconds instead of 3 times the least of 0.5. */
  check_number(json, "block_steps|ideal", 2), check_number(json, "block_steps|achieved", 1.2);
  const json_t *levels = at(json, "block_steps|levels");
  CHECK(json_array_size(levels) == 2);
  check_number(json_array_get(levels, 0), "step", 0.25), check_number(json_array_get(levels, 0), "nodes", 3);
  check_number(json_array_get(levels, 1), "step", 0.125), check_number(json_array_get(levels, 1), "nodes", 1);
  check_number(json_array_get(levels, 1), "updates", 2), check_number(json_array_get(levels, 1), "ticks", 1);
  check_number(json_array_get(levels, 0), "seconds", 1);
  check_number(json, "ledger|ghosts_created", 5e12), check_number(json, "ledger|odd \"name\"", 3);
  CHECK(json_is_null(at(json, "ranks_detail")));
  json_decref(json);
  kith_report_clear(&r);
}

static json_t *detail_of_two(void) {
  return json_pack("{s:{s:i,s:i,s:i},s:i,s:f}", "nodes", "min", 10, "mean", 11, "max", 1234567,
                   "remote_ghosts_kept", 77, "largest_imbalance", 1.25);
}

/* With several ranks each stage has the seconds of all ranks. */
static void ranks(void) {
  static const struct kith_spread spread[3] = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  struct kith_report r = sample();
  r.ranks_detail = detail_of_two();
  CHECK_OK(kith_resize(&r.stage_spread, 0, 3, sizeof *spread));
  memcpy(r.stage_spread, spread, sizeof spread);
  json_t *json = written(&r);
  check_number(json, "stages|step/connectivity|mean", 5), check_number(json, "stages|step|max", 3);
  check_number(json, "ranks_detail|nodes|min", 10), check_number(json, "ranks_detail|nodes|mean", 11);
  check_number(json, "ranks_detail|remote_ghosts_kept", 77);
  json_decref(json);
  kith_report_clear(&r);
}

static void empty_report(void) {
  const struct kith_report report = {.scene = "odd \xff", .measured = measured};
  json_t *json = written(&report);
  CHECK(json_is_null(at(json, "norms")) && json_is_null(at(json, "package")) &&
        json_is_null(at(json, "scene")));
  CHECK(json_object_size(at(json, "stages")) == 0 && json_object_size(at(json, "ledger")) == 0);
  json_decref(json);
  CHECK_STATUS(KITH_BAD_FILE, kith_report_write(&report, "no/such/report.json"));
  CHECK_STATUS(KITH_BAD_FILE, kith_report_write(&report, "/dev/full"));
}

/* Values from the objects of a run. */
static void collected(void) {
  static const char box[] = SCENARIO_UNIT
      "resolution: {1d: 40, 2d: 12, 3d: 6}\n"
      "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
      "materials: {gas: {gamma: 1.4}}\n"
      "regions: [{material: gas, jitter: 0.3, lattice: cubic, density: 1, pressure: 1}]\n"
      "until: 1\n";
  struct scenario s = {0};
  struct kith_report r;
  if (scenario_open(&s, box, "%s", "") && scenario_run(&s, 3)) {
    const struct kith_conservation_baseline baseline = kith_conservation_baseline_of(&s.start);
    const struct kith_ledger *l = &s.simulation->integrator.ledger;
    const double n = s.simulation->nodes->n_internal;
    struct kith_provenance provenance;
    const struct kith_traffic none = {0};
    CHECK_OK(kith_provenance_take(&provenance, (char *[]){"kith", "run", "it's one", "--set=a=[1]", NULL}));
    kith_report_collect(&r, s.simulation, &baseline, &provenance, 2 * n, 5 * n, 2.0, 3.0);
    CHECK_OK(kith_report_detail_ranks(&r, s.simulation, &none, 3, 0));
    json_t *json = written(&r);
    check_number(json, "ranks_detail|largest_imbalance", NAN); /* no check found any, and none is below 1 */
    check_number(json, "steps", 3), check_number(json, "nodes", n), check_number(json, "cpu_seconds", 3);
    check_number(json, "node_updates_per_second", n * 2 / 2.0), check_number(json, "dimension", NDIM);
    check_number(json, "kinetic|start", s.start.kinetic);
    check_number(json, "ledger|pairs", (double)l->pairs),
        check_number(json, "ledger|lifecycles", (double)l->lifecycles);
    check_number(json, "ledger|rebuilds_because_first_build", 1);
    CHECK(json_number_value(at(json, "ledger|rebuilds_because_always")) >= 3); /* three steps */
    const double created = json_number_value(at(json, "ledger|ghosts_created"));
    CHECK(created > 0 && created == json_number_value(at(json, "ledger|ghosts_culled")) +
                                        json_number_value(at(json, "ledger|ghosts_kept")));
    const char *name;
    json_t *boundary;
    double of_boundaries = 0;
    json_object_foreach((json_t *)at(json, "ledger|boundaries"), name, boundary) {
      const double made = json_number_value(at(boundary, "created"));
      CHECK(made == json_number_value(at(boundary, "culled")) + json_number_value(at(boundary, "kept")));
      of_boundaries += made;
    }
    CHECK(of_boundaries == created);
    CHECK(json_number_value(at(json, "ledger|bytes_nodes")) > 8 * n);
    const char *command = json_string_value(at(json, "command")), *date = json_string_value(at(json, "date"));
    CHECK(strcmp(command, "kith run 'it'\\''s one' '--set=a=[1]'") == 0);
    CHECK(strlen(json_string_value(at(json, "host"))) > 0 && strlen(date) == 20 && date[10] == 'T');
    const double fom = json_number_value(at(json, "fom|node_updates_per_second"));
    CHECK_CLOSE(fom * 2.5, json_number_value(at(json, "fom|pairs_per_second")), 1e-12 * fom);
    json_decref(json);
    kith_free(&provenance.command);
    kith_report_clear(&r);
  }
  scenario_close(&s);
}

/* No line exceeds 100 columns or ends with a blank. */
static void table(void) {
  struct kith_report report = sample();
  char *text = NULL;
  size_t size = 0;
  struct kith_report plain = report;
  plain.scene = "a scene whose name is so long that nobody would ever type it twice in a row, or even once";
  FILE *f = open_memstream(&text, &size);
  kith_report_print(&plain, false, f);
  const long tube = ftell(f);
  plain.norms.vortex = true;
  kith_report_print(&plain, false, f);
  plain.norms.carried = true; /* has no meaningful angular momentum */
  kith_report_print(&plain, false, f);
  plain.norms = (struct kith_norms){.nodes = 1};
  plain.kinetic_start = 0;
  kith_report_print(&plain, false, f);
  plain.compared = false, plain.n_stages = 0, plain.momentum_axes = 0, plain.gas_nodes = plain.nodes;
  kith_report_print(&plain, false, f);
  const long measures = ftell(f);
  plain.measured = (const bool[KITH_N_MEASURES]){0};
  kith_report_print(&plain, false, f);
  fclose(f);
  for (const char *line = text; *line != '\0';) {
    const size_t length = strcspn(line, "\n");
    if (length > 100) fprintf(stderr, "%zu columns: %.*s\n", length, (int)length, line);
    CHECK(length <= 100 && (length == 0 || line[length - 1] != ' '));
    line += length + (line[length] == '\n');
  }
  CHECK(strstr(text, "density") != NULL && strstr(text, "1.0000e-01") != NULL && strstr(text, "210") != NULL);
  /* Only what the scene is about: angular momentum of a vortex, velocity of gas at rest. */
  const char *vortex = strstr(text, "angular momentum 6.25e-02"),
             *rest = strstr(text, "velocity 7.50e-01 of sound");
  CHECK(vortex != NULL && vortex > text + tube && strstr(vortex + 1, "angular momentum") == NULL);
  CHECK(rest != NULL && rest > vortex && strstr(rest + 30, "of sound") == NULL);
  const char *changed = strstr(text, "momentum: walls or external forces change it"),
             *alone = strstr(text, "no exact solution to compare with");
  CHECK(changed > rest && strstr(text, " nodes (23000 of gas) and 64 frozen, ") < text + tube &&
        alone > text + measures);
  CHECK(strstr(changed, " of gas)") == NULL && strstr(changed, "momentum 0") == NULL);
  CHECK(strstr(text, "azimuthal") > text + tube && strstr(text, "0.25 of 0.5") != NULL);
  CHECK(strstr(text, "  connectivity") != NULL);
  free(text);
  kith_report_clear(&report);
}

/* All stages, also of other roots, with threads and counters or with the seconds of all ranks. */
static void profile(void) {
  struct kith_report r = sample();
  struct kith_stage start = {.path = "start/rows", .name = "rows", .depth = 1, .calls = 7, .imbalance = 1.5};
  char *text = NULL;
  size_t size = 0;
  FILE *f = open_memstream(&text, &size);
  kith_report_print(&r, true, f);
  r.n_stages = 1, r.stages = &start, r.ranks_detail = detail_of_two(), r.ranks = 2;
  CHECK_OK(kith_resize(&r.stage_spread, 0, 1, sizeof *r.stage_spread));
  *r.stage_spread = (struct kith_spread){0.25, 0.5, 0.75};
  kith_report_print(&r, false, f);
  fflush(f);
  CHECK(strstr(text, ". pairs 4250000\n") != NULL && strstr(text, "\n  . restarts 2\n") != NULL);
  CHECK(strstr(text, "    rows ") == NULL && strstr(text, "of all ranks") == NULL);
  CHECK(strstr(text, "\n  calls, seconds and shares are those of rank 0\n") > strstr(text, ". restarts 2"));
  r.wall_seconds = 0; /* no division by zero */
  kith_report_print(&r, true, f);
  kith_free(&r.stage_spread);
  r.ranks = 1;
  kith_report_print(&r, true, f);
  fclose(f);
  const char *row = strstr(text, "    rows ");
  CHECK(row != NULL && strstr(row, " 0.25000     0.50000     0.75000      1.50\n") != NULL);
  CHECK(strstr(row, ", at most 1.250\n") != NULL && strstr(row, "         11    1234567 ") != NULL);
  CHECK(strstr(row, "  of all ranks together\n") != NULL);
  CHECK(strstr(row, "  remote_ghosts_kept               77\n") != NULL &&
        strstr(row, "  0.0 %          -        -       -      1.50\n") != NULL);
  row = strstr(row + 1, "    rows ");
  CHECK(row != NULL && strstr(row, " 1.50\n") != NULL);
  CHECK(strstr(text, "level ") != NULL && strstr(text, "base step / 2 ") != NULL);
  CHECK(strstr(text, "achieved over ideal: 60 %") != NULL);
  free(text);
  kith_report_clear(&r);
}

/* The file is complete, or not created. */
static void trace(void) {
  struct kith_profile *p = NULL;
  CHECK_OK(kith_profile_create(&p, 2, true));
  kith_profile_begin(p, "step");
  CHECK_OK(kith_trace_write(NULL, p, path));
  json_t *json = json_load_file(path, JSON_REJECT_DUPLICATES, NULL);
  CHECK(json_array_size(json) == 4); /* names of the process and of its threads, and one event */
  json_decref(json);
  CHECK_STATUS(KITH_BAD_FILE, kith_trace_write(NULL, p, "no/such/folder/trace.json"));
  CHECK_STATUS(KITH_BAD_FILE, kith_trace_write(NULL, p, "/dev/full"));
  kith_profile_destroy(&p);
}

int main(void) {
  CHECK(mkstemp(path) >= 0);
  keys();
  ranks();
  empty_report();
  collected();
  table();
  profile();
  trace();
  unlink(path);
  return check_failed();
}
