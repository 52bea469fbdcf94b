/* What charts read: tables, points of other codes, suites; and the file of points, after a kill too. */
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include "app/others.h"
#include "app/suite.h"
#include "app/version.h"
#include "tests/check.h"

static char place[] = "chart-test-XXXXXX";
static char path[256];

static const char *put(const char *name, const char *text) {
  snprintf(path, sizeof path, "%s/%s", place, name);
  FILE *f = fopen(path, "w");
  CHECK(f != NULL);
  if (f != NULL) fputs(text, f), fclose(f);
  return path;
}

static bool said(const char *words) {
  const bool found = strstr(kith_failure(), words) != NULL;
  if (!found) fprintf(stderr, "no '%s' in: %s\n", words, kith_failure());
  return found;
}

static void check_csv(void) {
  struct kith_csv *csv;
  put("a.csv",
      "# a comment\nname,\"a \"\"b\"\" c\",x\r\n\nu,\"two\nlines, and a comma\",1\r\nv,,2\n# the end\nw,x,3");
  CHECK(kith_csv_read(&csv, path, false) == KITH_OK);
  CHECK(csv->n_columns == 3 && csv->n_rows == 3);
  CHECK(kith_csv_column(csv, "a \"b\" c") == 1 && kith_csv_column(csv, "b") == -1);
  CHECK(strcmp(kith_csv_at(csv, 0, 1), "two\nlines, and a comma") == 0);
  CHECK(strcmp(kith_csv_at(csv, 0, 2), "1") == 0 && kith_csv_at(csv, 1, 1)[0] == '\0');
  CHECK(strcmp(kith_csv_at(csv, 2, 2), "3") == 0 && csv->line[1] == 4 && csv->line[2] == 6);
  kith_csv_destroy(&csv);
  CHECK(kith_csv_read(&csv, path, true) == KITH_OK);
  CHECK(csv->n_rows == 2 && strcmp(csv->text + csv->whole, "w,x,3") == 0);
  kith_csv_destroy(&csv);
  CHECK(kith_csv_read(&csv, put("b.csv", "a,b\n1,2\n3\n"), false) == KITH_BAD_INPUT &&
        said("b.csv:3: 1 fields, but there are 2"));
  CHECK(kith_csv_read(&csv, put("b.csv", "a,b\n1,\"2\n"), false) == KITH_BAD_INPUT &&
        said("b.csv:2: a quote that does not end"));
  CHECK(kith_csv_read(&csv, put("b.csv", ""), false) == KITH_BAD_INPUT && said("no line of column names"));
  CHECK(kith_csv_read(&csv, "nowhere.csv", false) == KITH_BAD_INPUT && said("nowhere.csv: No such file"));
}

static void check_many_rows(void) {
  struct kith_csv *csv;
  snprintf(path, sizeof path, "%s/many.csv", place);
  FILE *f = fopen(path, "w");
  CHECK(f != NULL);
  if (f == NULL) return;
  fputs("a,b\n", f);
  for (int k = 0; k < 1000; ++k) fprintf(f, "%d,%d\n", k, 2 * k);
  fclose(f);
  CHECK(kith_csv_read(&csv, path, false) == KITH_OK);
  CHECK(csv->n_rows == 1000);
  for (int k = 0; k < csv->n_rows; ++k)
    CHECK(atoi(kith_csv_at(csv, k, 0)) == k && atoi(kith_csv_at(csv, k, 1)) == 2 * k);
  kith_csv_destroy(&csv);
}

static void check_others(void) {
  static const char names[] = "scene,code,machine,resolution,cpu_seconds,norm,value,dimension\n";
  struct kith_others o;
  char text[512];
  snprintf(text, sizeof text,
           "%ssod,A,m,10,1.5,density.l1,0.1,3\nsod,B,m,10,1,density.l1,0.1,1\nnoh,A,m,10,1,blip,1,3\n",
           names);
  CHECK(kith_others_read(&o, put("o.csv", text), "sod", 3) == KITH_OK);
  CHECK(o.n == 1 && strcmp(o.other[0].code, "A") == 0 && o.other[0].cpu_seconds == 1.5 &&
        o.other[0].version[0] == '\0');
  kith_others_clear(&o);
  snprintf(text, sizeof text, "%ssod,A,m,10,-1,density.l1,0.1,3\n", names);
  CHECK(kith_others_read(&o, put("o.csv", text), "sod", 3) == KITH_BAD_INPUT &&
        said("o.csv:2: cpu_seconds: '-1' is not"));
  snprintf(text, sizeof text, "%ssod,A,m,10,1,density.l9,0.1,3\n", names);
  CHECK(kith_others_read(&o, put("o.csv", text), "sod", 3) == KITH_BAD_INPUT && said("norm: 'density.l9'"));
  CHECK(kith_others_read(&o, put("o.csv", "scene,code\n"), "sod", 3) == KITH_BAD_INPUT &&
        said("no column 'machine'"));
}

static bool has(const struct kith_job *job, const char *setting) {
  for (int k = 0; k < job->n_settings; ++k)
    if (strcmp(job->setting[k], setting) == 0) return true;
  return false;
}

static void check_suite(const struct kith_programs *programs) {
  struct kith_suite *s;
  struct kith_job job;
  const char *overrides[] = {"scheme.cfl=0.25"};
  put("s.yaml",
      "scene: sod\ndimension: 1\nsettings: {method: {viscosity: {alpha: 2}}, regions.0.velocity: [1, 'x + 1', 0]}\n"
      "methods:\n  - {name: one}\n  - {name: two, settings: {method.energy: thermal}}\n"
      "matrix: {method.kernel: [cubic, quintic, wendland-c2], method.neighbors: [4, 5], resolution: [50, 20, 100]}\n"
      "norms: [blip, pressure.l2]\n");
  CHECK(kith_suite_read(&s, programs, path, 1, overrides) == KITH_OK);
  if (s == NULL) return;
  CHECK(s->n_methods == 12 && s->n_resolutions == 3 && s->resolution[0] == 20 && s->dimension == 1);
  CHECK(s->n_norms == 2 && strcmp(kith_metrics[s->norm[1]].name, "pressure.l2") == 0);
  CHECK(kith_suite_job(s, 9, 50, &job) == KITH_OK); /* 9 = two, quintic, 5 */
  CHECK(strcmp(job.method, "two quintic neighbors 5") == 0);
  CHECK(has(&job, "method.viscosity.alpha=2") && has(&job, "regions.0.velocity=[1, 'x + 1', 0]") &&
        has(&job, "scheme.cfl=0.25"));
  CHECK(has(&job, "method.energy=thermal") && has(&job, "method.kernel=quintic") &&
        has(&job, "method.neighbors=5"));
  CHECK(has(&job, "resolution=50") && job.n_settings == 7);
  kith_suite_destroy(&s);
}

static void check_wrong_suites(const struct kith_programs *programs) {
  static const char *const cases[][2] = {
      {"scene: sodd\nmatrix: {resolution: [5]}\n", "s.yaml:1: scene: 'sodd'"},
      {"scene: sod\n\nmatrix: {resolution: []}\n", "s.yaml:3: matrix.resolution: an empty list"},
      {"scene: sod\nmatrix: {method.kernel: [cubic]}\n", "matrix.resolution: missing"},
      {"scene: sod\nmatrix: {resolution: [5, x]}\n", "'x' is not a number"},
      {"scene: sod\nmatrix: {resolution: [5, 5]}\n", "is there twice"},
      {"scene: sod\nmatrix: {resolution: 5}\n", "s.yaml:2: matrix.resolution"},
      {"scene: sod\nmethods: []\nmatrix: {resolution: [5]}\n", "without methods"},
      {"scene: sod\nmethods: [{nam: x}]\nmatrix: {resolution: [5]}\n", "did you mean 'name'"},
      {"scene: sod\nmethods: [{name: x}, {name: x}]\nmatrix: {resolution: [5]}\n",
       "the name of another method"},
      {"scene: sod\nmatrix: {resolution: [5]}\nnorms: [densty.l1]\n", "did you mean 'density.l1'"},
      {"scene: sod\nmatrix: {resolution: [5]}\nnorms: [density.l1]\ntargets: [1, 2]\n",
       "2 targets for 1 norms"},
      {"scene: sod\nmatrix: {resolution: [5]}\nothers: no.csv\n", "'no.csv' cannot be read"},
      {"scene: sod\nmatrix: {resolution: [5]}\nsuite: a/b\n", "cannot name a directory"},
      {"scene: sod\nmatrx: {resolution: [5]}\nmatrix: {resolution: [5]}\n", "did you mean 'matrix'"},
  };
  struct kith_suite *s;
  for (size_t k = 0; k < sizeof cases / sizeof *cases; ++k) {
    put("s.yaml", cases[k][0]);
    CHECK(kith_suite_read(&s, programs, path, 0, NULL) == KITH_BAD_INPUT && s == NULL && said(cases[k][1]));
  }
}

static size_t size_of(const char *file) {
  struct stat status;
  return stat(file, &status) == 0 ? (size_t)status.st_size : 0;
}

/* A file as an earlier process left it: two points, one of another version, and a part of a line. */
static void check_points(void) {
  struct kith_matrix *m, *other;
  char directory[128], file[160];
  snprintf(directory, sizeof directory, "%s/points", place);
  snprintf(file, sizeof file, "%s/points.csv", directory);
  CHECK(kith_matrix_open(&m, directory, 1, 0) == KITH_OK);
  CHECK(m->n == 0 && size_of(file) > 0);
  CHECK(kith_matrix_open(&other, directory, 1, 0) == KITH_BAD_FILE && other == NULL &&
        said("another process"));
  kith_matrix_close(&m);
  FILE *f = fopen(file, "a");
  CHECK(f != NULL);
  if (f == NULL) return;
  for (int row = 0; row < 2; ++row) {
    fprintf(f, "00000000000000a%d,%s,\"a \"\"b\"\"\",50,%s,\"why\",\"x=1\"", row,
            row == 0 ? kith_version() : "0.0.1", row == 0 ? "failed" : "ok");
    for (int k = 0; k < KITH_N_METRICS; ++k) fprintf(f, ",%d", k);
    fputc('\n', f);
  }
  fflush(f);
  const size_t whole = size_of(file);
  fprintf(f, "00000000000000b1,%s,\"half", kith_version());
  fclose(f);
  CHECK(kith_matrix_open(&m, directory, 1, 0) == KITH_OK);
  if (m == NULL) return;
  CHECK(m->n == 1 && size_of(file) == whole);
  const struct kith_point *p = kith_matrix_find(m, 0xa0);
  CHECK(p != NULL && p->failed && strcmp(p->method, "a \"b\"") == 0 && strcmp(p->why, "why") == 0 &&
        p->value[3] == 3);
  CHECK(kith_matrix_find(m, 0xa1) == NULL && kith_matrix_find(m, 0xb1) == NULL);
  kith_matrix_close(&m);
  put("points/points.csv", "a,b\n1,2\n");
  CHECK(kith_matrix_open(&m, directory, 1, 0) == KITH_BAD_FILE && said("take another directory"));
}

/* Every setting, the scene's text and the threads count. */
static void check_keys(void) {
  struct kith_matrix m = {.threads = 1};
  struct kith_job a = {.scene = put("scene.yaml", "x: 1\n"), .dimension = 1}, b;
  CHECK(kith_job_set(&a, "k", "1") == KITH_OK);
  const uint64_t key = kith_matrix_key(&m, &a);
  b = a;
  CHECK(kith_matrix_key(&m, &b) == key);
  b.dimension = 2;
  CHECK(kith_matrix_key(&m, &b) != key);
  b = a, b.setting[0][2] = '2';
  CHECK(kith_matrix_key(&m, &b) != key);
  m.threads = 2;
  CHECK(kith_matrix_key(&m, &a) != key);
  m.threads = 1;
  put("scene.yaml", "x: 2\n");
  CHECK(kith_matrix_key(&m, &a) != key);
}

int main(void) {
  struct kith_programs programs;
  CHECK(mkdtemp(place) != NULL);
  CHECK(kith_programs_find(&programs) == KITH_OK);
  check_csv();
  check_many_rows();
  check_others();
  check_suite(&programs);
  check_wrong_suites(&programs);
  check_points();
  check_keys();
  char command[64];
  snprintf(command, sizeof command, "rm -rf %s", place);
  CHECK(system(command) == 0);
  return check_failed();
}
