/* test_history.c - history.csv has the values of the objects, read by the names of its columns, and a restart
 * continues it; and the series of snapshots. */
#include <jansson.h>
#include <unistd.h>
#include "app/output/output.h"
#include "tests/unit/files.h"
#include "tests/unit/scenario.h"

static const char box[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 12, 3d: 6}\n"
    "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
    "materials: {gas: {gamma: 1.4}}\n"
    "regions: [{material: gas, jitter: 0.3, lattice: cubic, density: 1, pressure: 1, velocity: [0.3, 0.2, "
    "0.1]}]\n"
    "until: 1\n";

/* A table that was read: the first row has the names, all are split into cells. */
enum { MOST_ROWS = 8, MOST_COLUMNS = 32 };
struct table {
  char text[8192], *cell[MOST_ROWS][MOST_COLUMNS];
  int n_rows, n_columns; /* without the row of names */
};

static void read_table(struct table *t, const char *path) {
  *t = (struct table){.n_rows = -1};
  CHECK(load(path, t->text, sizeof t->text - 1) > 0);
  for (char *rest = t->text, *line; (line = strsep(&rest, "\n")) != NULL && line[0] != '\0';) {
    int n = 0;
    for (char *c; n < MOST_COLUMNS && (c = strsep(&line, ",")) != NULL;) t->cell[t->n_rows + 1][n++] = c;
    CHECK(++t->n_rows == 0 || n == t->n_columns);
    t->n_columns = n;
  }
}

static int column_of(const struct table *t, const char *name) {
  int k = t->n_columns - 1;
  while (k >= 0 && strcmp(t->cell[0][k], name) != 0) --k;
  return k;
}

static const char *cell(const struct table *t, int row, const char *name) {
  const int column = column_of(t, name);
  if (column < 0) fprintf(stderr, "no column %s\n", name);
  CHECK(column >= 0 && row < t->n_rows);
  return column >= 0 && row < t->n_rows ? t->cell[row + 1][column] : "";
}

static double value(const struct table *csv, int row, const char *name) {
  return strtod(cell(csv, row, name), NULL);
}

/* Compares the row of a step with the objects after it. */
static void check_row(const struct table *csv, int row, const struct scenario *s,
                      const struct kith_totals *now) {
  static const char *const momentum[] = {"momentum_x", "momentum_y", "momentum_z"}, *const angular[] = {
                                                                                        "angular_x",
                                                                                        "angular_y",
                                                                                        "angular_z"};
  const struct kith_simulation *m = s->simulation;
  const struct kith_integrator *it = &m->integrator;
  CHECK(value(csv, row, "step") == (double)it->step && value(csv, row, "time") == it->time);
  CHECK(value(csv, row, "dt") == it->dt);
  CHECK(strcmp(cell(csv, row, "limiter"), kith_limit_name(it->limiter)) == 0);
  CHECK(value(csv, row, "kinetic") == now->kinetic && value(csv, row, "internal") == now->internal);
  CHECK(value(csv, row, "potential") == now->potential && value(csv, row, "work") == now->work);
  CHECK(value(csv, row, "total") == now->kinetic + now->internal + now->potential - now->work);
  for (int a = 0; a < 3; ++a) {
    CHECK((column_of(csv, momentum[a]) >= 0) == (a < NDIM));
    CHECK((column_of(csv, angular[a]) >= 0) == (NDIM == 3 || (NDIM == 2 && a == 2)));
    if (a < NDIM) CHECK(value(csv, row, momentum[a]) == now->momentum[a]);
    if (column_of(csv, angular[a]) >= 0) CHECK(value(csv, row, angular[a]) == now->angular[a]);
  }
  CHECK(value(csv, row, "velocity_over_sound") == now->velocity_over_sound);
  CHECK(value(csv, row, "nodes") == m->nodes->n_internal && value(csv, row, "ghosts") == m->nodes->n_ghost);
  CHECK(value(csv, row, "entries") == (double)it->ledger.last_row_entries);
  CHECK(value(csv, row, "rebuilds") == (double)it->ledger.lifecycles && value(csv, row, "seconds") >= 0);
  int columns = 0;
#define X(name, least, ...) columns += NDIM >= (least);
  KITH_HISTORY_LIST(X)
#undef X
  CHECK(csv->n_columns == columns);
}

static void steps(void) {
  struct scenario s = {0};
  struct kith_history history = {0};
  struct table csv;
  struct kith_totals now;
  if (scenario_open(&s, box, "%s", "") && scenario_run(&s, 0)) {
    CHECK_OK(kith_history_open(&history, directory, s.simulation, false));
    s.simulation->integrator.summarizes = true;
    for (int k = 0; k < 4; ++k) {
      CHECK_OK(scenario_steps(&s, 1));
      now = kith_hydro_totals(&s.simulation->hydro);
      CHECK_OK(kith_history_row(&history, s.simulation));
      read_table(&csv, path_in("history.csv"));
      CHECK(csv.n_rows == k + 1);
      check_row(&csv, k, &s, &now);
    }
    CHECK_OK(kith_csv_log_close(&history.steps));
    s.simulation->integrator.step = 2; /* a restart from there */
    CHECK_OK(kith_history_open(&history, directory, s.simulation, true));
    CHECK_OK(kith_csv_log_close(&history.steps));
    read_table(&csv, path_in("history.csv"));
    CHECK(csv.n_rows == 2 && value(&csv, 1, "step") == 2);
  }
  scenario_close(&s);
}

/* The series lists names and times of the snapshots that exist. */
static void series(void) {
  struct scenario s = {0};
  struct kith_output output = {0};
  json_error_t error;
  if (scenario_open(&s, box, "%s", "") && scenario_run(&s, 1)) {
    CHECK_OK(kith_output_open(&output, s.simulation, directory, NULL, true));
    for (int k = 0; k < 3; ++k) CHECK_OK(kith_output_snapshot(&output, s.simulation));
    unlink(path_in("snapshot_0001.hdf"));
    CHECK_OK(kith_output_snapshot(&output, s.simulation));
    json_t *json = json_load_file(path_in("snapshots.hdf.series"), 0, &error);
    const json_t *files = json_object_get(json, "files"), *last = json_array_get(files, 2);
    CHECK(strcmp(json_string_value(json_object_get(json, "file-series-version")), "1.0") == 0);
    CHECK(json_array_size(files) == 3);
    CHECK(strcmp(json_string_value(json_object_get(last, "name")), "snapshot_0003.hdf") == 0);
    CHECK(json_number_value(json_object_get(last, "time")) == s.simulation->integrator.time);
    json_decref(json);
    CHECK_OK(kith_output_close(&output));
  }
  scenario_close(&s);
}

int main(void) {
  static const char *const files[] = {"history.csv", "snapshots.hdf.series", "snapshot_0000.hdf",
                                      "snapshot_0002.hdf", "snapshot_0003.hdf"};
  directory_make();
  steps();
  series();
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
