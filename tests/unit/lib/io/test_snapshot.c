/* test_snapshot.c - snapshots have the layout that ParaView 5.11 and yt 4.1 need, and known values: read back
 * with HDF5. Also failures while writing, which must leave the old file. */
#include <hdf5.h>
#include <pthread.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#include "lib/io/snapshot.h"
#include "physics/hydro.h"
#include "tests/unit/files.h"

enum { GAS = 5, WALL = 3, N = GAS + WALL };

/* Node i has position i + a / 10 on axis a, velocity -(i + a / 10), density 100 + i, id 1000 + i; and there
 * are ghosts, which must not be written. */
static struct kith_nodes *make_nodes(kith_index gas, kith_index wall) {
  static const char *const names[2] = {"gas", "wall"};
  static const struct kith_field_spec stress = {"stress", KITH_TENSOR, KITH_F64, KITH_DERIVED, "Stress", "S"};
  struct kith_nodes *nodes = NULL;
  struct kith_hydro hydro = {0};
  struct kith_field *tensor = NULL;
  CHECK_OK(kith_nodes_create(&nodes, 2, names));
  CHECK_OK(kith_hydro_init(&hydro, nodes));
  CHECK_OK(kith_nodes_field(nodes, &stress, &tensor));
  if (gas > 0) CHECK_OK(kith_nodes_append(nodes, 0, gas, NULL));
  if (wall > 0) CHECK_OK(kith_nodes_append(nodes, 1, wall, NULL));
  for (kith_index i = 0; i < gas + wall; ++i) {
    for (int a = 0; a < NDIM; ++a) {
      nodes->position->f64[i * NDIM + a] = i + a / 10.0;
      hydro.velocity->f64[i * NDIM + a] = -i - a / 10.0;
      for (int b = 0; b < NDIM; ++b) tensor->f64[(i * NDIM + a) * NDIM + b] = 100 * i + 10 * a + b;
    }
    hydro.density->f64[i] = 100 + i;
    nodes->id->i64[i] = 1000 + i;
  }
  if (gas > 0) {
    struct kith_ghost_block ghost = {.kind = KITH_GHOST_FROZEN, .list = 0, .count = 1};
    CHECK_OK(kith_nodes_add_ghosts(nodes, &ghost));
  }
  return nodes;
}

static const struct kith_snapshot_info info = {
    .time = 0.25,
    .step = 17,
    .box = {.lower = {-1}, .upper = {2}},
    .periodic = {[NDIM - 1] = true},
    .notes = (const struct kith_note[]){
        {"Version", "0.1.0"}, {"Empty", ""}, {"Letters", "\xc3\xa9"}, {NULL, NULL}}};

static void read_all(hid_t file, const char *name, hid_t type, size_t rows, size_t columns, void *values) {
  hsize_t shape[2] = {0, 0};
  const hid_t data = H5Dopen2(file, name, H5P_DEFAULT), space = H5Dget_space(data);
  if (data < 0) fprintf(stderr, "no data set %s\n", name);
  CHECK(H5Sget_simple_extent_ndims(space) == (columns > 0 ? 2 : 1));
  H5Sget_simple_extent_dims(space, shape, NULL);
  CHECK(shape[0] == rows && (columns == 0 || shape[1] == columns));
  if (shape[0] == rows && (columns == 0 || shape[1] == columns) && rows > 0)
    CHECK(H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
  H5Sclose(space), H5Dclose(data);
}

static void check_particles(hid_t file) {
  double x[N][3], v[N][3], rho[N], s[N][9];
  int64_t id[N];
  uint8_t material[N], flag[N];
  read_all(file, "PartType0/Coordinates", H5T_NATIVE_DOUBLE, N, 3, x);
  read_all(file, "PartType0/Velocities", H5T_NATIVE_DOUBLE, N, 3, v);
  read_all(file, "PartType0/Density", H5T_NATIVE_DOUBLE, N, 0, rho);
  read_all(file, "PartType0/Stress", H5T_NATIVE_DOUBLE, N, 9, s);
  read_all(file, "PartType0/ParticleIDs", H5T_NATIVE_INT64, N, 0, id);
  read_all(file, "PartType0/MaterialIDs", H5T_NATIVE_UINT8, N, 0, material);
  read_all(file, "PartType0/NodeFlags", H5T_NATIVE_UINT8, N, 0, flag);
  for (int i = 0; i < N; ++i) {
    CHECK(flag[i] == 0);
    for (int a = 0; a < 3; ++a) {
      CHECK(x[i][a] == (a < NDIM ? i + a / 10.0 : 0) && v[i][a] == (a < NDIM ? -i - a / 10.0 : 0));
      for (int b = 0; b < 3; ++b) CHECK(s[i][3 * a + b] == (a < NDIM && b < NDIM ? 100 * i + 10 * a + b : 0));
    }
    CHECK(rho[i] == 100 + i && id[i] == 1000 + i && material[i] == (i >= GAS));
  }
  static const char *const wanted[] = {"Masses", "Pressure", "InternalEnergy", "SmoothingLength"};
  for (int k = 0; k < 4; ++k) {
    char name[64];
    snprintf(name, sizeof name, "PartType0/%s", wanted[k]);
    read_all(file, name, H5T_NATIVE_DOUBLE, N, 0, rho);
  }
}

static void check_cells(hid_t file, size_t n) {
  static const char *const counts[] = {"VTKHDF/NumberOfPoints", "VTKHDF/NumberOfCells",
                                       "VTKHDF/NumberOfConnectivityIds"};
  int64_t count, number[N + 1];
  uint8_t types[N];
  for (int k = 0; k < 3; ++k) {
    read_all(file, counts[k], H5T_NATIVE_INT64, 1, 0, &count);
    CHECK(count == (int64_t)n);
  }
  read_all(file, "VTKHDF/Offsets", H5T_NATIVE_INT64, n + 1, 0, number);
  for (size_t i = 0; i <= n; ++i) CHECK(number[i] == (int64_t)i);
  read_all(file, "VTKHDF/Connectivity", H5T_NATIVE_INT64, n, 0, number);
  read_all(file, "VTKHDF/Types", H5T_NATIVE_UINT8, n, 0, types);
  for (size_t i = 0; i < n; ++i) CHECK(number[i] == (int64_t)i && types[i] == 1);
}

/* Both names refer to one object, whose reference count is 2. */
static void check_linked(hid_t file, const char *particle, const char *vtk) {
  H5O_info_t a, b;
  CHECK(H5Oget_info_by_name(file, particle, &a, H5P_DEFAULT) >= 0 &&
        H5Oget_info_by_name(file, vtk, &b, H5P_DEFAULT) >= 0);
  CHECK(a.addr == b.addr && a.rc == 2);
}

struct text {
  char s[64];
  bool variable, utf8;
};

static struct text text_of(hid_t file, const char *object, const char *name) {
  struct text t = {.s = ""};
  const hid_t a = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT), type = H5Aget_type(a);
  CHECK(a >= 0 && H5Tget_class(type) == H5T_STRING && H5Tget_size(type) < sizeof t.s);
  t.variable = H5Tis_variable_str(type) > 0;
  t.utf8 = H5Tget_cset(type) == H5T_CSET_UTF8;
  CHECK(!t.variable && H5Aread(a, type, t.s) >= 0);
  H5Tclose(type), H5Aclose(a);
  return t;
}

/* Returns the number of values; 0 for a scalar. */
static int numbers(hid_t file, const char *object, const char *name, double *values) {
  const hid_t a = H5Aopen_by_name(file, object, name, H5P_DEFAULT, H5P_DEFAULT), space = H5Aget_space(a);
  const int n = H5Sget_simple_extent_type(space) == H5S_SCALAR ? 0 : (int)H5Sget_simple_extent_npoints(space);
  if (a < 0) fprintf(stderr, "no attribute %s of %s\n", name, object);
  CHECK(a >= 0 && n <= 6 && H5Aread(a, H5T_NATIVE_DOUBLE, values) >= 0);
  H5Sclose(space), H5Aclose(a);
  return n;
}

static void check_attributes(hid_t file) {
  double v[6];
  CHECK(numbers(file, "VTKHDF", "Version", v) == 2 && v[0] == 1 && v[1] == 0);
  CHECK(strcmp(text_of(file, "VTKHDF", "Type").s, "UnstructuredGrid") == 0);
  CHECK(numbers(file, "Header", "NumPart_ThisFile", v) == 6 && v[0] == N && v[1] == 0 && v[5] == 0);
  CHECK(numbers(file, "Header", "NumPart_Total", v) == 6 && v[0] == N);
  CHECK(numbers(file, "Header", "NumPart_Total_HighWord", v) == 6 && v[0] == 0);
  CHECK(numbers(file, "Header", "MassTable", v) == 6 && v[0] == 0);
  CHECK(numbers(file, "Header", "BoxSize", v) == 0 && v[0] == 3); /* yt needs a scalar */
  CHECK(numbers(file, "Header", "Flag_DoublePrecision", v) == 0 && v[0] == 1);
  CHECK(numbers(file, "Header", "Time", v) == 0 && v[0] == 0.25);
  CHECK(numbers(file, "Header", "NumFilesPerSnapshot", v) == 0 && v[0] == 1);
  CHECK(numbers(file, "Units", "UnitLength_in_cm", v) == 0 && v[0] == 1);
  CHECK(numbers(file, "Run", "BoxLower", v) == NDIM && v[0] == -1);
  CHECK(numbers(file, "Run", "BoxUpper", v) == NDIM && v[0] == 2);
  CHECK(numbers(file, "Run", "Periodic", v) == NDIM && v[NDIM - 1] == 1);
  CHECK(numbers(file, "Run", "Step", v) == 0 && v[0] == 17);
  CHECK(numbers(file, "Run", "Dimension", v) == 0 && v[0] == NDIM);
  CHECK(strcmp(text_of(file, "Run", "Version").s, "0.1.0") == 0 &&
        text_of(file, "Run", "Empty").s[0] == '\0');
  CHECK(!text_of(file, "Run", "Version").utf8 && text_of(file, "Run", "Letters").utf8);
  CHECK(strcmp(text_of(file, "Run", "MaterialNames").s, "gas\nwall") == 0);
  CHECK(strcmp(text_of(file, "PartType0/Density", "Description").s, "mass per unit volume") == 0);
  CHECK(H5Aexists_by_name(file, "Header", "Code", H5P_DEFAULT) == 0); /* yt would misread files with these */
  CHECK(H5Lexists(file, "Parameters", H5P_DEFAULT) == 0);
}

static void layout(void) {
  static unsigned char a[1 << 17], b[1 << 17];
  struct kith_nodes *nodes = make_nodes(GAS, WALL);
  CHECK_OK(kith_snapshot_write(path_in("a.hdf"), nodes, &info));
  const hid_t file = H5Fopen(path_in("a.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
  CHECK(file >= 0);
  check_particles(file);
  check_cells(file, N);
  check_attributes(file);
  check_linked(file, "PartType0/Coordinates", "VTKHDF/Points");
  check_linked(file, "PartType0/Velocities", "VTKHDF/PointData/Velocities");
  check_linked(file, "PartType0/ParticleIDs", "VTKHDF/PointData/ParticleIDs");
  CHECK(H5Lexists(file, "VTKHDF/PointData/Coordinates", H5P_DEFAULT) == 0);
  CHECK(H5Fget_obj_count(file, H5F_OBJ_ALL) == 1); /* this test closes what it opens */
  H5Fclose(file);
  sleep(1); /* a time stamp in the file would differ now */
  CHECK_OK(kith_snapshot_write(path_in("b.hdf"), nodes, &info));
  const size_t n = load(path_in("a.hdf"), a, sizeof a);
  CHECK(n < 40000); /* reserved space is released: 8 nodes need little more than the names */
  CHECK(n > 1000 && n < sizeof a && load(path_in("b.hdf"), b, sizeof b) == n && memcmp(a, b, n) == 0);
  kith_nodes_destroy(&nodes);
}

/* Frozen nodes follow the internal nodes of their list, with flags; fields that they lack are zero. */
static void frozen(void) {
  static const struct kith_field_spec barrier = {"barrier", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, ""},
                                      later = {"later", KITH_SCALAR, KITH_F64, KITH_STATE, "Later", ""};
  enum { ALL = N + 2 };
  struct kith_nodes *nodes = make_nodes(GAS, WALL), *held = make_nodes(1, 1);
  struct kith_snapshot_info with = info;
  struct kith_field *field;
  double rho[ALL], value[ALL];
  uint8_t flag[ALL], material[ALL];
  with.frozen = held;
  CHECK_OK(kith_nodes_field(held, &barrier, &field));
  field->u8[1] = 1;
  CHECK_OK(kith_nodes_field(nodes, &later, &field));
  for (int i = 0; i < N; ++i) field->f64[i] = 7;
  CHECK_OK(kith_snapshot_write(path_in("frozen.hdf"), nodes, &with));
  const hid_t file = H5Fopen(path_in("frozen.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
  read_all(file, "PartType0/Density", H5T_NATIVE_DOUBLE, ALL, 0, rho);
  read_all(file, "PartType0/Later", H5T_NATIVE_DOUBLE, ALL, 0, value);
  read_all(file, "PartType0/NodeFlags", H5T_NATIVE_UINT8, ALL, 0, flag);
  read_all(file, "PartType0/MaterialIDs", H5T_NATIVE_UINT8, ALL, 0, material);
  for (int i = 0; i < ALL; ++i) {
    const bool wall = i > GAS, still = i == GAS || i == ALL - 1;
    CHECK(flag[i] == (still ? 1 + wall : 0) && material[i] == wall && value[i] == (still ? 0 : 7));
    CHECK(rho[i] == 100 + (i == GAS ? 0 : i == ALL - 1 ? 1 : i - wall));
  }
  H5Fclose(file);
  kith_nodes_destroy(&held);
  kith_nodes_destroy(&nodes);
}

static void empty(void) {
  struct kith_nodes *nodes = make_nodes(0, 0);
  struct kith_snapshot_info plain = info;
  plain.notes = NULL;
  CHECK_OK(kith_snapshot_write(path_in("empty.hdf"), nodes, &plain));
  const hid_t file = H5Fopen(path_in("empty.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
  check_cells(file, 0);
  read_all(file, "PartType0/Coordinates", H5T_NATIVE_DOUBLE, 0, 3, NULL);
  H5Fclose(file);
  kith_nodes_destroy(&nodes);
}

/* A text that is too long for an attribute. */
static void long_note(void) {
  static char text[100001], back[100001];
  memset(text, 'x', sizeof text - 1);
  struct kith_nodes *nodes = make_nodes(1, 0);
  struct kith_snapshot_info noted = info;
  noted.notes = (const struct kith_note[]){{"Scene", text}, {NULL, NULL}};
  CHECK_OK(kith_snapshot_write(path_in("long.hdf"), nodes, &noted));
  const hid_t file = H5Fopen(path_in("long.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(file, "Run/Scene", H5P_DEFAULT), type = H5Dget_type(data);
  CHECK(H5Tget_size(type) == 100000 && H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, back) >= 0);
  CHECK(memcmp(text, back, sizeof text) == 0);
  H5Tclose(type), H5Dclose(data), H5Fclose(file);
  kith_nodes_destroy(&nodes);
}

/* A missing directory, and a full disk at many sizes: the message is one line, the old file stays, HDF5 stays
 * usable and prints nothing. */
static void failures(void) {
  struct kith_nodes *nodes = make_nodes(2000, 0);
  struct rlimit old, limit;
  H5E_auto2_t before, after;
  void *with;
  H5Eget_auto2(H5E_DEFAULT, &before, &with);
  CHECK_STATUS(KITH_BAD_FILE, kith_snapshot_write(path_in("no/such/a.hdf"), nodes, &info));
  signal(SIGXFSZ, SIG_IGN);
  getrlimit(RLIMIT_FSIZE, &old);
  /* up to more than the 131072 + 2000 * 80 bytes that are reserved */
  for (rlim_t bytes = 0; bytes < 290000; bytes += 9777) {
    limit = old, limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
    const kith_status status = kith_snapshot_write(path_in("a.hdf"), nodes, &info);
    setrlimit(RLIMIT_FSIZE, &old);
    CHECK(status == KITH_BAD_FILE && strstr(kith_failure(), "a.hdf: cannot write") != NULL);
    CHECK(access(path_in("a.hdf.partial"), F_OK) != 0);
    const hid_t file = H5Fopen(path_in("a.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
    CHECK(file >= 0);
    check_cells(file, N);
    H5Fclose(file);
  }
  H5Eget_auto2(H5E_DEFAULT, &after, &with);
  CHECK(before == after);
  CHECK(H5Fget_obj_count((hid_t)H5F_OBJ_ALL, H5F_OBJ_ALL) == 0);
  CHECK_OK(kith_snapshot_write(path_in("a.hdf"), nodes, &info));
  kith_nodes_destroy(&nodes);
}

/* A writing process that is killed before it has written anything is started again, once. */
static int *kills; /* how many are still to be killed, in shared memory */
static void killed(void) {
  if (*kills == 0) return;
  --*kills;
  raise(SIGKILL);
}

static void killed_processes(void) {
  struct kith_nodes *nodes = make_nodes(N, 0);
  kills = mmap(NULL, sizeof *kills, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  *kills = 0;
  CHECK(pthread_atfork(NULL, NULL, killed) == 0);
  for (int n = 0; n < 3; ++n) {
    *kills = n;
    const kith_status status = kith_snapshot_write(path_in("a.hdf"), nodes, &info);
    CHECK(*kills == 0 && status == (n < 2 ? KITH_OK : KITH_BAD_FILE));
    const hid_t file = H5Fopen(path_in("a.hdf"), H5F_ACC_RDONLY, H5P_DEFAULT);
    check_cells(file, N);
    H5Fclose(file);
  }
  CHECK(strstr(kith_failure(), "a.hdf: cannot write: signal 9 ended HDF5") != NULL);
  munmap(kills, sizeof *kills);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  static const char *const files[] = {"a.hdf", "b.hdf", "frozen.hdf", "empty.hdf", "long.hdf"};
  directory_make();
  layout();
  frozen();
  empty();
  long_note();
  failures();
  killed_processes();
  directory_remove(sizeof files / sizeof *files, files);
  return check_failed();
}
