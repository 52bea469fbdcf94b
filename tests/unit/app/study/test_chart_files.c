/* test_chart_files.c - files that charts and stress sweeps read: results of other codes, suites, sweeps, and
 * measures of a report; wrong ones are refused with their line. */
#include <glob.h>
#include <math.h>
#include <string.h>
#include "app/study/study.h"
#include "tests/unit/files.h"

static const struct kith_options none;

static const char *write_file(const char *name, const char *text) {
  const char *const path = path_in(name);
  write_text(path, text);
  return path;
}

/* Reads a suite; the study holds one at a time. */
static kith_status read_suite(struct kith_study *study, const char *subject) {
  kith_study_clear(study);
  return kith_suite_read(study, subject);
}

static void check_reference_codes(struct kith_study *study) {
#define WITH(code) \
  "scene: sod\nresolution: [5]\nnorms: [density.l1, pressure.l1]\nreference_codes:\n  - {" code "}\n"
  CHECK_OK(read_suite(
      study, write_file("o.yaml", WITH("code: A, machine: 'x, \"y\"', resolution: 10, cpu_seconds: 1.5, "
                                       "norms: {density.l1: 0.1, velocity.l2: 3}"))));
  const struct kith_suite s = *study->suite;
  CHECK(s.n_codes == 1 && strcmp(s.code->name, "A") == 0 && strcmp(s.code->machine, "x, \"y\"") == 0);
  CHECK(s.code->cpu_seconds == 1.5 && s.code->norm[0] == 0.1 && isnan(s.code->norm[1]) &&
        s.code->version[0] == '\0');
  static const char *const wrong[][2] = {
      {WITH("code: A, machine: m, resolution: 10, cpu_seconds: -1, norms: {density.l1: 1}"),
       "-1 is out of range"},
      {WITH("code: A, machine: m, resolution: 10, cpu_seconds: 1, norms: {density.l9: 1}"),
       "none of our norms"},
      {WITH("code: A, machine: m, resolution: 10, cpu_seconds: 1, norms: {density.l1: x}"),
       "'x' is not a number"},
      {WITH("code: A, resolution: 10, cpu_seconds: 1, norms: {density.l1: 1}"),
       "o.yaml:5: reference_codes.0.machine"}};
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k)
    CHECK(read_suite(study, write_file("o.yaml", wrong[k][0])) == KITH_BAD_INPUT && check_says(wrong[k][1]));
}

static bool has(const struct kith_job *job, const char *setting) {
  const char *at = strstr(job->settings, setting);
  return at != NULL && (at == job->settings || at[-1] == '\n') && at[strlen(setting)] == '\n';
}

static int lines(const char *text) {
  int n = 0;
  for (; *text != '\0'; ++text) n += *text == '\n';
  return n;
}

static void check_suite(struct kith_study *study) {
  const struct kith_options options = {.n_overrides = 1, .overrides = {"scheme.cfl=0.25"}};
  const char *const path =
      write_file("s.yaml",
                 "scene: sod\ndimension: 1\nsettings: {method: {viscosity: {alpha: 2}}, "
                 "regions.0.velocity: [1, 'x + 1', 0]}\n"
                 "methods:\n  - {name: one}\n  - {name: two, settings: {method.energy: thermal, ranks: 3}}\n"
                 "resolution: [20, 50, 100]\nnorms: [contact_pressure_error, pressure.l2]\n");
  study->options = &options;
  CHECK_OK(read_suite(study, path));
  struct kith_suite s = *study->suite;
  CHECK(s.n_methods == 2 && s.n_values == 3 && s.dimension == 1 && strcmp(s.name, "s") == 0);
  CHECK(s.n_measures == 2 && strcmp(s.measure[1], "norms.pressure.l2") == 0);
  const struct kith_job *job = &s.job[3];
  CHECK(job[0].x == 20 && job[1].x == 50 && strcmp(job[2].value, "100") == 0);
  CHECK(strcmp(job->label, "two") == 0 && job->ranks == 3 && job->dimension == 1 && job->line == 6);
  CHECK(has(job, "method.viscosity.alpha=2") && has(job, "regions.0.velocity=[1, 'x + 1', 0]") &&
        has(job, "scheme.cfl=0.25"));
  CHECK(has(job, "method.energy=thermal") && has(&job[1], "resolution=50") && lines(job->settings) == 5);
  study->options = &none;
  CHECK_OK(read_suite(study, "sod-1d")); /* by name */
  s = *study->suite;
  CHECK(s.n_methods >= 3 && s.n_measures == 3 && s.target[1] > 0 && strcmp(s.scene, "sod") == 0);
}

static void check_wrong_suites(struct kith_study *study) {
  static const char *const cases[][2] = {
      {"scene: sodd\nresolution: [5]\n", "s.yaml:1: scene: no scene 'sodd'; did you mean 'sod'"},
      {"scene: sod\n\nresolution: []\n", "s.yaml:3: resolution: an empty list"},
      {"scene: sod\nmethods: [{name: x}]\n", "resolution: missing"},
      {"scene: sod\nresolution: [5, x]\n", "'x' is not a number"},
      {"scene: sod\nresolution: [5, 5]\n", "5 after 5: resolutions ascend"},
      {"scene: sod\nresolution: [9, 5]\n", "5 after 9: resolutions ascend"},
      {"scene: sod\nresolution: 5\n", "s.yaml:2: resolution"},
      {"scene: sod\nmethods: []\nresolution: [5]\n", "methods: an empty list"},
      {"scene: sod\nmethods: [{nam: x}]\nresolution: [5]\n", "did you mean 'name'"},
      {"scene: sod\nmethods: [{name: x}, {name: x}]\nresolution: [5]\n", "'x' is there twice"},
      {"scene: sod\nresolution: [5]\nnorms: [densty.l1]\n", "did you mean 'density.l1'"},
      {"scene: sod\nresolution: [5]\nnorms: [density.l1]\ntargets: [1, 2]\n", "2 targets for 1 norms"},
      {"scene: ./no.yaml\nresolution: [5]\n", "'./no.yaml' cannot be read"},
      {"scene: sod\nresoluton: [5]\nresolution: [5]\n", "did you mean 'resolution'"},
      {"scene: sod\nresolution: [5]\nsettings: {ranks: 0}\n", "ranks=0: not one of 1 to"},
      {"scene: sod\nresolution: [5]\ndimension: 4\n", "4 is out of range"},
  };
  const struct kith_options options = {.n_overrides = 1, .overrides = {"resolution=6"}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    CHECK(read_suite(study, write_file("s.yaml", cases[k][0])) == KITH_BAD_INPUT && check_says(cases[k][1]));
  }
  const char *const path = write_file("s.yaml", "scene: sod\nresolution: [5]\n");
  study->options = &options;
  CHECK(read_suite(study, path) == KITH_BAD_INPUT && check_says("--set resolution: this is what is varied"));
  study->options = &none;
}

static kith_status read_sweeps(struct kith_study *study, const char *text, const char *only) {
  kith_study_clear(study);
  return kith_sweeps_read(study, write_file("w.yaml", text), only);
}

#define SWEEP(name, rest)                                                             \
  "  - {name: " name                                                                  \
  ", parameter: p, scene: sod, dimension: 1, measure: shock, at_most: 1, reason: r, " \
  "settings: {until: 1}, " rest "}\n"

static void check_sweeps(struct kith_study *study) {
  static const char *const wrong[][2] = {
      {"methods: [{name: a}]\n", "sweeps: missing"},
      {"sweeps:\n" SWEEP("x", "at_least: 1, values: {scheme.cfl: [0.1]}"), "needs one bound"},
      {"sweeps:\n" SWEEP("x", "values: {scheme.cfl: [0.1], until: [1]}"), "2 keys; a sweep varies one"},
      {"sweeps:\n" SWEEP("x", "values: {scheme.cfl: []}"), "an empty list"},
      {"sweeps:\n" SWEEP("x", "values: [{value: 1}]"), "settings: missing"},
      {"sweeps:\n" SWEEP("x", "valus: [1]"), "did you mean 'values'"}};
  CHECK_OK(
      read_sweeps(study,
                  "methods: [{name: a}, {name: b, settings: {scheme.dt: 1}}]\nsweeps:\n" SWEEP(
                      "one", "values: {scheme.cfl: [0.3, 0.2]}")
                      SWEEP("two", "of_first: true, values: [{value: u v, settings: {a: 1, b: [2, 3]}}]"),
                  NULL));
  const struct kith_suite *sweeps = study->suite;
  CHECK(study->n == 2 && sweeps[0].n_methods == 2 && sweeps[0].n_values == 2 && !sweeps[0].named_values);
  CHECK(sweeps[0].job[3].x == 0.2 && strcmp(sweeps[0].job[3].label, "b") == 0 && isnan(sweeps[0].at_least));
  CHECK(has(&sweeps[0].job[3], "until=1") && has(&sweeps[0].job[3], "scheme.dt=1") &&
        has(&sweeps[0].job[3], "scheme.cfl=0.2"));
  CHECK(sweeps[1].named_values && sweeps[1].of_first && has(&sweeps[1].job[0], "b?=[2, 3]"));
  CHECK(read_sweeps(study, "sweeps:\n" SWEEP("one", "values: {until: [1]}"), "ones") == KITH_BAD_INPUT &&
        check_says("did you mean 'one'"));
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k)
    CHECK(read_sweeps(study, wrong[k][0], NULL) == KITH_BAD_INPUT && check_says(wrong[k][1]));
}

/* The shipped sweeps and suites can be read. */
static void check_shipped(struct kith_study *study) {
  char file[KITH_PATH + 32];
  glob_t suites;
  snprintf(file, sizeof file, "%s/suites/*.yaml", study->programs.inputs);
  CHECK(glob(file, 0, NULL, &suites) == 0 && suites.gl_pathc >= 10);
  for (size_t k = 0; k < suites.gl_pathc; ++k) CHECK_OK(read_suite(study, suites.gl_pathv[k]));
  globfree(&suites);
  kith_study_clear(study);
  snprintf(file, sizeof file, "%s/stress/sweeps.yaml", study->programs.inputs);
  CHECK_OK(kith_sweeps_read(study, file, NULL));
  CHECK(study->n >= 18);
  for (int k = 0; k < study->n; ++k) CHECK(study->suite[k].n_methods >= 7 && study->suite[k].n_values >= 4);
}

static void check_measures(void) {
  const char *report =
      write_file("report.json",
                 "{\"steps\": 12, \"norms\": {\"shock_radius\": 0.9, \"shock_exact\": 1.2, \"l1\": null}}");
  double value;
  CHECK(kith_report_measure(report, "steps", &value) == KITH_OK && value == 12);
  CHECK(kith_report_measure(report, "steps / norms.shock_exact", &value) == KITH_OK &&
        fabs(value - 10) < 1e-14);
  CHECK(kith_report_measure(report, "shock", &value) == KITH_OK && fabs(value - 0.25) < 1e-14);
  CHECK(kith_report_measure(report, "norms.shock_exact / steps - 1", &value) == KITH_OK &&
        fabs(value - 0.9) < 1e-14);
  CHECK(kith_report_measure(report, "norms.l1", &value) == KITH_BAD_FILE);
  CHECK(kith_report_measure(report, "norms", &value) == KITH_BAD_FILE);
  CHECK(kith_report_measure(report, "steps.l1", &value) == KITH_BAD_FILE && isnan(value));
  CHECK(kith_report_measure("no/such/report.json", "steps", &value) == KITH_BAD_FILE);
  CHECK(kith_report_measure(report, "steps / nothing", &value) == KITH_BAD_FILE &&
        check_says("nothing is not there"));
}

int main(void) {
  static const char *const files[] = {"o.yaml", "s.yaml", "w.yaml", "report.json"};
  struct kith_study study = {.options = &none};
  directory_make();
  CHECK(kith_programs_find(&study.programs) == KITH_OK);
  check_reference_codes(&study);
  check_suite(&study);
  check_wrong_suites(&study);
  check_sweeps(&study);
  check_shipped(&study);
  check_measures();
  kith_study_clear(&study);
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
