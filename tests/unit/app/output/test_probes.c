/* test_probes.c - probes.h5 and contacts.csv. Oracles: linear fields, whose values and gradients must be
 * exact at any point among disordered nodes; a fit over all images of all nodes, at periodic and reflecting
 * faces; brute force over all pairs, for contacts. Also series that a restart continues, points with too few
 * nodes, and pictures. */
#include <dirent.h>
#include <hdf5.h>
#include <omp.h>
#include <unistd.h>

#include "app/output/output.h"
#include "app/output/pictures/probe_plot.h"
#include "tests/unit/files.h"
#include "tests/unit/oracle.h"
#include "tests/unit/scenario.h"
#include "tests/unit/solve.h"

static const char box[] = SCENARIO_UNIT
    "resolution: {1d: 40, 2d: 10, 3d: 6}\n"
    "materials: {gas: {gamma: 1.4}, other: {gamma: 1.4}}\n"
    "arrangement: equal-spacing\n"
    "regions:\n"
    "  - {material: gas, where: {x: [0, 0.5]}, jitter: 0.3, lattice: cubic, density: 1, pressure: 1}\n"
    "  - {material: other, where: {x: [0.5, 1]}, jitter: 0.3, lattice: cubic, density: 1, pressure: 1}\n"
    "connectivity: {contacts: [{of: gas, with: other}]}\n"
    "probes:\n"
    "  - {name: center, at: [0.5, 0.5, 0.5], gradients: true}\n"
    "  - {name: line, at: [0.01, 0.02, 0.03], along: [0.9, 0.9, 0.9], spacing: 0.1, gradients: true}\n"
    "  - {name: slice, at: [0, 0, 0.5], along: [1, 0, 0], across: [0, 1, 0], spacing: 0.25, every: 2}\n"
    "  - {name: grid, at: [0, 0, 0], along: [1, 0, 0], across: [0, 1, 0], up: [0, 0, 1], spacing: 0.5}\n"
    "until: 1\n";

/* Reads sample k of a column, [n][components]; returns the number of samples. */
static size_t read_column(const char *probe, const char *column, hsize_t k, double *values, hsize_t size) {
  char name[96];
  hsize_t shape[3] = {0, 1, 1};
  snprintf(name, sizeof name, "%s/%s", probe, column);
  const hid_t file = H5Fopen(path_in("probes.h5"), H5F_ACC_RDONLY, H5P_DEFAULT),
              data = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(data);
  H5Sget_simple_extent_dims(space, shape, NULL);
  const hsize_t from[3] = {k}, one[3] = {1, shape[1], shape[2]}, n = shape[1] * shape[2];
  const hid_t sample = H5Screate_simple(1, &n, NULL);
  CHECK(k < shape[0] && n == size);
  H5Sselect_hyperslab(space, H5S_SELECT_SET, from, NULL, one, NULL);
  CHECK(H5Dread(data, H5T_NATIVE_DOUBLE, sample, space, H5P_DEFAULT, values) >= 0);
  H5Sclose(sample);
  H5Sclose(space);
  H5Dclose(data);
  H5Fclose(file);
  return shape[0];
}

/* A linear function, one for each f. */
static double linear(int f, const double *x) {
  double value = 2 + f;
  for (int a = 0; a < NDIM; ++a) value += (0.3 + 0.1 * f - 0.5 * a) * x[a];
  return value;
}

static void make_linear(const struct scenario *s) {
  const struct kith_hydro *h = &s->simulation->hydro;
  for (kith_index i = 0; i < h->nodes->n_internal; ++i) {
    const double *x = h->nodes->position->f64 + (size_t)i * NDIM;
    h->density->f64[i] = linear(0, x), h->pressure->f64[i] = linear(1, x), h->energy->f64[i] = linear(2, x);
    for (int a = 0; a < NDIM; ++a) h->velocity->f64[(size_t)i * NDIM + a] = linear(3 + a, x);
  }
}

/* All sides are open, so points are inside of the gas or near its edge. */
static void check_linear(const char *storage) {
  static const char *const names[] = {"density", "pressure", "energy"};
  struct scenario s = {0};
  struct kith_probes *probes;
  if (scenario_open(&s, box, "connectivity.storage=%s", storage)) {
    CHECK_OK(scenario_start(&s));
    make_linear(&s);
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, false));
    CHECK_OK(kith_probes_sample(probes, false));
    CHECK_OK(kith_probes_destroy(&probes));
    const struct kith_probe *line = &s.scene->probe[1];
    const int n = line->points[0];
    double value[128], gradient[400];
    CHECK(n >= 10 && n <= 17);
    for (int f = 0; f < 3; ++f) {
      char name[64];
      CHECK(read_column("line", names[f], 0, value, (hsize_t)n) == 1);
      snprintf(name, sizeof name, "%s_gradient", names[f]);
      read_column("line", name, 0, gradient, 3 * (hsize_t)n);
      for (int i = 0; i < n; ++i) {
        double x[NDIM];
        for (int a = 0; a < NDIM; ++a) x[a] = line->at[a] + 0.9 * i / (n - 1);
        CHECK_CLOSE(value[i], linear(f, x), 1e-12);
        for (int a = 0; a < 3; ++a)
          CHECK_CLOSE(gradient[3 * i + a], a < NDIM ? 0.3 + 0.1 * f - 0.5 * a : 0, 1e-12);
      }
    }
    read_column("line", "velocity", 0, gradient, 3 * (hsize_t)n);
    for (int a = 0; a < NDIM; ++a) CHECK_CLOSE(gradient[a], linear(3 + a, line->at), 1e-12);
    read_column("center", "velocity_gradient", 0, gradient, 9);
    for (int a = 0; a < NDIM; ++a)
      for (int b = 0; b < NDIM; ++b) CHECK_CLOSE(gradient[3 * a + b], 0.3 + 0.1 * (3 + a) - 0.5 * b, 1e-12);
  }
  scenario_close(&s);
}

/* --- images --- */

static int rows_of(const char *name, double row[][8], int most, int columns) {
  char line[400];
  int n = 0;
  FILE *f = fopen(path_in(name), "r");
  CHECK(f != NULL);
  while (f != NULL && n < most && fgets(line, sizeof line, f) != NULL) {
    char *at = line, *end;
    if (line[0] == '#' || line[0] == '\n') continue;
    for (int k = 0; k < columns; ++k, at = end) {
      row[n][k] = strtod(at, &end);
      CHECK(end > at);
    }
    CHECK(*at == '\n'); /* nothing follows */
    ++n;
  }
  if (f != NULL) fclose(f);
  return n;
}

/* A series with an error; a line at two times beside the exact solution; planes of pixels. */
static void check_curves(const struct kith_scene *scene) {
  static double row[256][8];
  const struct kith_probe *line = &scene->probe[1];
  const double center[3] = {0.5, 0.5, 0.5}, slope = NDIM == 1 ? 0.9 : 0.9 * sqrt(NDIM);
  CHECK(rows_of("probe_center.dat", row, 256, 3) == 2);
  for (int k = 0; k < 2; ++k) {
    CHECK_CLOSE(row[k][0], 0.25 * k, 1e-9);
    CHECK_CLOSE(row[k][1], linear(1, center) - 1, 1e-8);
    CHECK(row[k][2] == 0);
  }
  const int n = line->points[0];
  CHECK(rows_of("probe_line.dat", row, 256, 5) == 2 * n);
  for (int i = 0; i < 2 * n; ++i) {
    const double part = i % n / (n - 1.0);
    double x[3] = {0};
    for (int a = 0; a < NDIM; ++a) x[a] = line->at[a] + 0.9 * part;
    CHECK_CLOSE(row[i][0], slope * part + (NDIM == 1 ? 0.01 : 0), 1e-8);
    CHECK_CLOSE(row[i][1], linear(0, x), 1e-8);
    CHECK_CLOSE(row[i][2], linear(3, x), 1e-8);
    CHECK(row[i][3] == 1 && row[i][4] == 0);
  }
}

static void check_pixels(const char *name, const struct kith_probe *probe, double height) {
  float value[400] = {0};
  const int n[2] = {probe->points[0], probe->points[1]};
  CHECK(load(path_in(name), value, sizeof value) == (size_t)(n[0] * n[1]) * sizeof *value);
  for (int j = 0; j < n[1]; ++j)
    for (int i = 0; i < n[0]; ++i) {
      const double x[3] = {i / (n[0] - 1.0), j / (n[1] - 1.0), height};
      CHECK_CLOSE(value[j * n[0] + i], linear(0, x), 1e-6);
    }
}

static void clear_pictures(void) {
  DIR *all = opendir(directory);
  for (const struct dirent *entry; (entry = readdir(all)) != NULL;)
    if (strncmp(entry->d_name, "probe_", 6) == 0) unlink(path_in(entry->d_name));
  closedir(all);
}

static void check_pictures(void) {
  struct scenario s = {0};
  struct kith_probes *probes;
  void *exact = NULL;
  if (scenario_open(&s, box, "%s",
                    "exact.name=uniform probes.0.plot=pressure-error probes.1.plot=[density,velocity_x] "
                    "probes.2.plot=false probes.3.plot=true")) {
    CHECK_OK(scenario_start(&s));
    make_linear(&s);
    CHECK_OK(kith_exact_create(&exact, s.scene->exact.ops, s.scene->exact.settings));
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, false));
    CHECK_OK(kith_probes_sample(probes, true));
    s.simulation->integrator.time = 0.25, s.simulation->integrator.step = 1;
    CHECK_OK(kith_probes_sample(probes, true));
    CHECK_OK(kith_probes_publish(probes));
    CHECK_OK(kith_probes_draw(s.scene, exact, directory));
    check_curves(s.scene);
    CHECK(access(path_in("probe_slice.gp"), F_OK) != 0); /* no picture is wanted */
    CHECK(access(path_in("probe_grid.gp"), F_OK) == 0);
    if (NDIM > 1) check_pixels("probe_grid_1.bin", &s.scene->probe[3], 0.5);
    CHECK_OK(kith_probes_destroy(&probes));
    clear_pictures();
    kith_free(&exact);
    unlink(path_in("probes.h5"));
    CHECK_STATUS(KITH_BAD_FILE, kith_probes_draw(s.scene, NULL, directory));
    CHECK(strstr(kith_failure(), "probes.h5: cannot read center/time") != NULL);
  }
  scenario_close(&s);
}

/* Is it a node or a frozen node, not an image? */
static bool has_values(const struct kith_nodes *nodes, kith_index j) {
  return j < nodes->n_internal || kith_nodes_ghost_block(nodes, j)->kind == KITH_GHOST_FROZEN;
}

/* The oracle: a component of velocity and its gradient at x by a linear fit over all nodes, frozen ones too,
 * and their images -1, 0 and 1 along each axis: shifted along x and z, mirrored along y. */
static void oracle_at(const struct scenario *s, const double *x, int component, double out[NDIM + 1]) {
  const struct kith_hydro *h = &s->simulation->hydro;
  double m[NDIM + 1][NDIM + 1] = {{0}}, sum[NDIM + 1][1] = {{0}};
  int image[3];
  for (kith_index j = 0; j < kith_nodes_count(h->nodes); ++j)
    for (image[0] = has_values(h->nodes, j) ? -1 : 2; image[0] <= 1; ++image[0])
      for (image[1] = NDIM > 1 ? -1 : 0; image[1] <= (NDIM > 1); ++image[1])
        for (image[2] = NDIM > 2 ? -1 : 0; image[2] <= (NDIM > 2); ++image[2]) {
          double term[NDIM + 1] = {1}, r2 = 0, w, g, v = h->velocity->f64[(size_t)j * NDIM + component];
          for (int a = 0; a < NDIM; ++a) {
            const double own = h->nodes->position->f64[(size_t)j * NDIM + a];
            double y = own + image[a];
            if (a == 1 && image[a] != 0) y = (image[a] > 0 ? 2 : 0) - own;
            if (a == 1 && image[a] != 0 && component == 1) v = -v;
            term[1 + a] = y - x[a];
            r2 += pow(term[1 + a] / h->nodes->stretch[a], 2);
          }
          const double support = h->nodes->support->f64[j];
          if (!(r2 < support * support)) continue;
          kith_kernel_value(s->simulation->package.kernel, sqrt(r2) / support, &w, &g);
          w *= h->mass->f64[j] / (h->density->f64[j] * kith_pow_dim(support));
          for (int k = 0; k <= NDIM; ++k) {
            for (int l = 0; l <= NDIM; ++l) m[k][l] += w * term[k] * term[l];
            sum[k][0] += w * term[k] * v;
          }
        }
  truth_solve(NDIM + 1, m, 1, sum);
  for (int k = 0; k <= NDIM; ++k) out[k] = sum[k][0];
}

static void check_images(const char *settings) {
  struct scenario s = {0};
  struct kith_probes *probes;
  if (scenario_open(&s, box, "boundaries.x=periodic boundaries.y=reflecting boundaries.z=periodic%s",
                    settings)) {
    CHECK_OK(scenario_start(&s));
    CHECK_OK(scenario_steps(&s, 2));
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; ++i)
      for (int a = 0; a < NDIM; ++a) {
        const double *x = s.simulation->nodes->position->f64 + (size_t)i * NDIM;
        s.simulation->hydro.velocity->f64[(size_t)i * NDIM + a] = sin(3 * x[0] + a) + x[NDIM - 1] * x[0];
      }
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, false));
    CHECK_OK(kith_probes_sample(probes, true));
    CHECK_OK(kith_probes_publish(probes));
    const struct kith_probe *slice = &s.scene->probe[2];
    const int n = slice->points[0] * slice->points[1];
    double first[400], again[400], wanted[NDIM + 1];
    read_column("slice", "velocity", 0, first, 3 * (hsize_t)n);
    for (int i = 0; i < n; ++i) {
      const int at[3] = {i / slice->points[1], i % slice->points[1], 2};
      double x[NDIM];
      for (int a = 0; a < NDIM; ++a) x[a] = 0.25 * at[a];
      for (int a = 0; a < NDIM; ++a) {
        oracle_at(&s, x, a, wanted);
        CHECK_CLOSE(first[3 * i + a], wanted[0], 1e-12);
      }
    }
    omp_set_num_threads(1); /* must be bitwise identical */
    for (int k = 0; k < 2; ++k) {
      s.simulation->integrator.step += 1;
      CHECK_OK(kith_probes_sample(probes, true));
    }
    CHECK(read_column("slice", "velocity", 0, again, 3 * (hsize_t)n) == 1); /* what a crash would leave */
    CHECK_OK(kith_probes_publish(probes));
    CHECK(read_column("slice", "velocity", 2, again, 3 * (hsize_t)n) == 3);
    CHECK(memcmp(first, again, 3 * (size_t)n * sizeof *first) == 0);
    /* While lists are kept, nodes may leave the box: a period away they give the same values. */
    for (kith_index i = 0; i < s.simulation->nodes->n_internal; i += 2)
      s.simulation->nodes->position->f64[(size_t)i * NDIM] += i % 4 == 0 ? 1 : -1;
    s.simulation->nodes->positions += 1;
    s.simulation->integrator.step += 1;
    CHECK_OK(kith_probes_sample(probes, true));
    CHECK_OK(kith_probes_publish(probes));
    CHECK(read_column("slice", "velocity", 3, again, 3 * (hsize_t)n) == 4);
    for (int i = 0; i < 3 * n; ++i) CHECK_CLOSE(again[i], first[i], 1e-12);
    omp_set_num_threads(2);
    CHECK_OK(kith_probes_destroy(&probes));
  }
  scenario_close(&s);
}

/* --- series --- */

static void check_series(void) {
  struct scenario s = {0};
  struct kith_probes *probes;
  double value[400], step;
  if (scenario_open(&s, box, "scheme.dt=0.0001")) {
    CHECK_OK(scenario_start(&s));
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, false));
    CHECK_OK(kith_probes_sample(probes, false));
    for (int k = 0; k < 5; ++k) {
      CHECK_OK(scenario_steps(&s, 1));
      CHECK_OK(kith_probes_sample(probes, k == 4));
    }
    CHECK_OK(kith_probes_destroy(&probes));
    CHECK(read_column("center", "step", 5, &step, 1) == 6 && step == 5);
    CHECK(read_column("slice", "step", 3, &step, 1) == 4 && step == 5); /* 0, 2, 4 and the last */
    read_column("grid", "density", 0, value, NDIM == 1 ? 3 : NDIM == 2 ? 9 : 27);
    /* A restart at step 5 keeps the sample that was taken since the run ended, until it takes one. */
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, true));
    CHECK_OK(kith_probes_publish(probes));
    CHECK_OK(kith_probes_destroy(&probes));
    CHECK(read_column("slice", "step", 3, &step, 1) == 4 && step == 5);
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, true));
    for (int k = 0; k < 2; ++k) {
      CHECK_OK(scenario_steps(&s, 1));
      CHECK_OK(kith_probes_sample(probes, k == 1));
    }
    CHECK_OK(kith_probes_destroy(&probes));
    CHECK(read_column("center", "step", 7, &step, 1) == 8 && step == 7);
    CHECK(read_column("slice", "step", 3, &step, 1) == 5 && step == 6);
    /* One at step 3 drops what is later. */
    s.simulation->integrator.step = 3;
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, true));
    CHECK_OK(kith_probes_publish(probes));
    CHECK_OK(kith_probes_destroy(&probes));
    CHECK(read_column("center", "step", 3, &step, 1) == 4 && step == 3);
    CHECK(read_column("slice", "step", 1, &step, 1) == 2 && step == 2);
    /* A file of other probes cannot be continued; a missing file is created. */
    const double at = s.scene->probe[0].at[0];
    for (int other = 0; other < 3; ++other) { /* a point elsewhere, no gradients, another name */
      s.scene->probe[0].at[0] = other == 0 ? at + 0.01 : at;
      if (other > 0) s.scene->probe[0].gradients = false;
      if (other > 1) strcpy(s.scene->probe[0].name, "middle");
      CHECK_STATUS(KITH_BAD_FILE, kith_probes_create(&probes, s.simulation, directory, true));
      CHECK(strstr(kith_failure(), "it has other probes than the scene") != NULL);
      CHECK_OK(kith_probes_destroy(&probes));
    }
    CHECK(truncate(path_in("probes.h5"), 1000) == 0);
    CHECK_STATUS(KITH_BAD_FILE, kith_probes_create(&probes, s.simulation, directory, true));
    CHECK(strstr(kith_failure(), "HDF5 cannot continue it") != NULL);
    CHECK_OK(kith_probes_destroy(&probes));
    unlink(path_in("probes.h5"));
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, true));
    CHECK_OK(kith_probes_sample(probes, true));
    CHECK_OK(kith_probes_destroy(&probes));
    CHECK(read_column("middle", "step", 0, &step, 1) == 1 && step == 3);
  }
  scenario_close(&s);
}

/* Too few nodes for a gradient, and none at all. */
static void check_sparse(void) {
  struct scenario s = {0};
  struct kith_probes *probes;
  double value[3], gradient[3];
  if (scenario_open(&s, box, "probes.0.at=[0.9,0.9,0.9]")) {
    CHECK_OK(scenario_start(&s));
    struct kith_nodes *nodes = s.simulation->nodes;
    for (kith_index i = 0; i < nodes->n_internal; ++i)
      for (int a = 0; a < NDIM; ++a) nodes->position->f64[(size_t)i * NDIM + a] = i == 0 ? 0.89 : -50;
    ++nodes->positions;
    s.simulation->hydro.pressure->f64[0] = 7;
    CHECK_OK(kith_probes_create(&probes, s.simulation, directory, false));
    CHECK_OK(kith_probes_sample(probes, false));
    CHECK_OK(kith_probes_destroy(&probes));
    read_column("center", "pressure", 0, value, 1);
    read_column("center", "pressure_gradient", 0, gradient, 3);
    CHECK(fabs(value[0] - 7) < 1e-14 && isnan(gradient[0]));
    double line[32];
    read_column("line", "pressure", 0, line, (hsize_t)s.scene->probe[1].points[0]);
    CHECK(isnan(line[0]));
  }
  scenario_close(&s);
}

/* --- contacts --- */

/* The distance of two nodes where supports are spheres. */
static double in_half_axes(const struct kith_nodes *nodes, kith_index i, kith_index j) {
  double sum = 0;
  for (int a = 0; a < NDIM; ++a)
    sum += pow((nodes->position->f64[(size_t)i * NDIM + a] - nodes->position->f64[(size_t)j * NDIM + a]) /
                   nodes->stretch[a],
               2);
  return sqrt(sum);
}

static void check_contacts(const char *settings) {
  struct scenario s = {0};
  struct kith_contacts *contacts;
  char line[256], why[32];
  if (scenario_open(&s, box, "%s", settings)) {
    CHECK_OK(scenario_start(&s));
    CHECK_OK(kith_contacts_create(&contacts, s.simulation, directory, false));
    for (int k = 0; k < 3; ++k) {
      CHECK_OK(scenario_steps(&s, 1));
      CHECK_OK(kith_contacts_sample(contacts));
    }
    CHECK_OK(kith_contacts_destroy(&contacts));
    const struct kith_nodes *nodes = s.simulation->nodes;
    const double *h = nodes->support->f64;
    double wanted[3] = {0, 0, INFINITY}, found[3];
    int builds, steps;
    for (kith_index i = 0; i < nodes->n_internal; ++i) {
      bool meets = false;
      for (kith_index j = 0; nodes->list->u8[i] == 0 && j < kith_nodes_count(nodes); ++j) {
        const double r = sqrt(oracle_distance2(nodes, i, j));
        if (nodes->list->u8[j] != 1 || !(in_half_axes(nodes, i, j) <= fmax(h[i], h[j]))) continue;
        meets = true, wanted[1] += 1, wanted[2] = fmin(wanted[2], r);
      }
      wanted[0] += meets;
    }
    FILE *file = fopen(path_in("contacts.csv"), "r");
    for (int k = 0; k < 4; ++k) CHECK(fgets(line, sizeof line, file) != NULL);
    fclose(file);
    CHECK(sscanf(line, "%d,%*[^,],gas,other,%lf,%lf,%lf,%*[^,],%d,%31s", &steps, &found[0], &found[1],
                 &found[2], &builds, why) == 6);
    for (int k = 0; k < 3; ++k) CHECK_CLOSE(found[k], wanted[k], 1e-14);
    CHECK(wanted[0] > 0 && steps == 3);
    const bool kept = kith_rebuilds_lasting(&s.simulation->rebuilds);
    CHECK(builds == (kept ? 1 : 3) && (strcmp(why, "none") == 0) == kept);
  }
  scenario_close(&s);
}

int main(void) {
  static const char *const files[] = {"probes.h5", "contacts.csv"};
  directory_make();
  check_linear("csr");
  check_linear("compressed");
  check_pictures();
  check_images("");
  check_images(" method.stretch=[1.5,1,1.2]");
  /* Frozen nodes reach farther than the gas. */
  check_images(" arrangement= regions.1.frozen=true regions.1.spacing=0.25");
  check_series();
  check_sparse();
  check_contacts("connectivity.storage=padded");
  check_contacts("method.stretch=[2,1,1.5]");
  check_contacts("connectivity.rebuild=displacement boundaries.x=periodic scheme.dt=0.0001");
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
