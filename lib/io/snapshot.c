/* snapshot.c - the layout of a snapshot, written through HDF5. */
#include "lib/io/snapshot.h"

#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include "lib/io/atomic_file.h"
#include "lib/io/child.h"
#include "lib/nodes/migrate.h"

enum { CELL_DATA = 3 }; /* data sets of the cells */

/* What the child process of rank 0 finds out while it makes the file, in memory shared with its parent. */
struct layout {
  int error;       /* errno of the first failure */
  char failed[96]; /* what was written then; empty: none */
  haddr_t end;     /* bytes of the file */
  haddr_t place[]; /* of the values in the file: of each field, of the flags, of the cells */
};

/* HDF5 returns negative handles after a failure, and calls with such a handle fail as well. So no call is
 * checked by itself, and the layout below reads as a list: HDF5 calls note_failure for each failure. */
struct writer {
  const struct kith_atomic_file *out;
  const struct kith_nodes *nodes;
  const struct kith_snapshot_info *info;
  size_t n; /* nodes of all ranks, and frozen ones */
  hid_t file, particles, vtk, point_data;
  int descriptor; /* of the file */
  struct layout *layout;
  void *room;      /* for the widest field of this rank's nodes */
  const char *now; /* what is being written, for messages */
};

/* Rows of the file. */
struct part {
  size_t total;                  /* nodes of all ranks, and frozen ones */
  size_t first[KITH_MAX_LISTS];  /* row of the first node of a list of this rank */
  size_t frozen[KITH_MAX_LISTS]; /* likewise of frozen nodes, which rank 0 writes */
};

static herr_t note_failure(hid_t stack, void *writer) {
  struct writer *w = writer;
  (void)stack;
  if (w->layout->failed[0] != '\0') return 0;
  w->layout->error = errno;
  snprintf(w->layout->failed, sizeof w->layout->failed, "%s", w->now);
  return 0;
}

static void attribute(struct writer *w, hid_t owner, const char *name, hid_t type, hsize_t n,
                      const void *values) {
  const hid_t space = n == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &n, NULL);
  w->now = name;
  const hid_t id = H5Acreate2(owner, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  H5Awrite(id, type, values);
  H5Aclose(id);
  H5Sclose(space);
}

/* n 0: a single value. The type of the attribute is that of `values`. */
#define PUT(w, owner, name, n, values)             \
  attribute(w, owner, name,                        \
            _Generic(*(values), double             \
                     : H5T_NATIVE_DOUBLE, uint32_t \
                     : H5T_NATIVE_UINT32, int64_t  \
                     : H5T_NATIVE_INT64),          \
            n, values)

/* A text type of fixed length without a terminating zero, as the reader of VTK expects it. Names and comments
 * of a scene may have letters beyond ASCII; texts without any stay ASCII, which more readers know. */
static hid_t text_type(const char *text) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, KITH_MAX(strlen(text), (size_t)1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  for (const char *c = text; *c != '\0'; ++c)
    if ((unsigned char)*c > 127) H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

static void put_text(struct writer *w, hid_t owner, const char *name, const char *text) {
  const hid_t type = text_type(text);
  attribute(w, owner, name, type, 0, text);
  H5Tclose(type);
}

/* rows x columns; columns 0: one-dimensional. The new data set is left open.
 * It is allocated at once and has no creation time, so that files of the same nodes are bitwise identical,
 * whichever rank writes the values. */
static hid_t new_data(struct writer *w, hid_t owner, const char *name, hid_t type, size_t rows,
                      size_t columns) {
  const hsize_t shape[2] = {rows, columns};
  const hid_t space = H5Screate_simple(columns == 0 ? 1 : 2, shape, NULL);
  const hid_t how = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(how, false);
  H5Pset_alloc_time(how, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(how, H5D_FILL_TIME_NEVER);
  w->now = name;
  const hid_t id = H5Dcreate2(owner, name, type, space, H5P_DEFAULT, how, H5P_DEFAULT);
  H5Pclose(how);
  H5Sclose(space);
  return id;
}

/* One row, which all ranks know. */
static void put_data(struct writer *w, hid_t owner, const char *name, hid_t type, const void *value) {
  const hid_t id = new_data(w, owner, name, type, 1, 0);
  H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, value);
  H5Dclose(id);
}

static hid_t group(struct writer *w, hid_t owner, const char *name) {
  w->now = name;
  return H5Gcreate2(owner, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
}

/* Columns in the file: 0 for a scalar, 3 or 9 for what has an index per axis. */
static size_t columns_of(const struct kith_field *field) {
  return field->spec.kind == KITH_SCALAR ? 0 : field->spec.kind == KITH_TENSOR ? 9 : 3;
}

static hid_t native_type(enum kith_type type) {
  return type == KITH_F64 ? H5T_NATIVE_DOUBLE : type == KITH_I64 ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT8;
}

/* Closes a data set. Returns where its values begin in the file; HADDR_UNDEF if it has none. */
static haddr_t close_data(hid_t data) {
  const haddr_t place = H5Dget_offset(data);
  H5Dclose(data);
  return place;
}

static haddr_t lay_out_field(struct writer *w, const struct kith_field *field, size_t n) {
  const char *name = field->spec.output;
  const hid_t data = new_data(w, w->particles, name, native_type(field->spec.type), n, columns_of(field));
  put_text(w, data, "Description", field->spec.doc != NULL ? field->spec.doc : "");
  const bool points = field->spec.kind == KITH_POSITION;
  H5Lcreate_hard(w->particles, name, points ? w->vtk : w->point_data, points ? "Points" : name, H5P_DEFAULT,
                 H5P_DEFAULT);
  return close_data(data);
}

static const struct kith_field_spec node_flags = {
    .type = KITH_U8, .output = "NodeFlags", .doc = "0 internal, 1 frozen, 2 frozen and a barrier"};

/* Have nodes flags of their own? */
static bool has_flags(const struct kith_nodes *nodes) {
  const struct kith_field *flag = kith_nodes_field_named(nodes, "flag");
  return flag != NULL && flag->spec.output != NULL;
}

/* One VERTEX cell (type 1 of VTK) a node. */
static void lay_out_cells(struct writer *w, size_t n, haddr_t place[CELL_DATA]) {
  static const char *const counts[] = {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"};
  const int64_t count = (int64_t)n;
  for (int k = 0; k < 3; ++k) put_data(w, w->vtk, counts[k], H5T_NATIVE_INT64, &count);
  place[0] = close_data(new_data(w, w->vtk, "Connectivity", H5T_NATIVE_INT64, n, 0));
  place[1] = close_data(new_data(w, w->vtk, "Offsets", H5T_NATIVE_INT64, n + 1, 0));
  place[2] = close_data(new_data(w, w->vtk, "Types", H5T_NATIVE_UINT8, n, 0));
}

/* Six particle types, of which type 0 is used. No attribute Code, no root group Parameters: yt stumbles over
 * them. */
static void write_header(struct writer *w) {
  static const char *const flags[] = {"Flag_Sfr",    "Flag_Cooling",  "Flag_StellarAge",
                                      "Flag_Metals", "Flag_Feedback", "Flag_Entropy_ICs"};
  static const char *const zeros[] = {"Redshift", "Omega0", "OmegaLambda"};
  const struct kith_snapshot_info *info = w->info;
  const hid_t header = group(w, w->file, "Header");
  const uint32_t low[6] = {(uint32_t)w->n}, high[6] = {(uint32_t)((uint64_t)w->n >> 32)};
  const int64_t flag = 0, files = 1;
  const double mass[6] = {0}, one = 1; /* mass 0: each particle has its own */
  double side = 0;
  for (int a = 0; a < NDIM; ++a) side = KITH_MAX(side, info->box.upper[a] - info->box.lower[a]);
  PUT(w, header, "NumPart_ThisFile", 6, low);
  PUT(w, header, "NumPart_Total", 6, low);
  PUT(w, header, "NumPart_Total_HighWord", 6, high);
  PUT(w, header, "MassTable", 6, mass);
  PUT(w, header, "NumFilesPerSnapshot", 0, &files);
  PUT(w, header, "Time", 0, &info->time);
  for (size_t k = 0; k < sizeof zeros / sizeof *zeros; ++k) PUT(w, header, zeros[k], 0, mass);
  PUT(w, header, "BoxSize", 0, &side);
  PUT(w, header, "HubbleParam", 0, &one);
  PUT(w, header, "Flag_DoublePrecision", 0, &files);
  for (size_t k = 0; k < sizeof flags / sizeof *flags; ++k) PUT(w, header, flags[k], 0, &flag);
  H5Gclose(header);
}

static void write_units(struct writer *w) {
  static const char *const names[] = {"UnitLength_in_cm",
                                      "UnitMass_in_g",
                                      "UnitVelocity_in_cm_per_s",
                                      "UnitTime_in_s",
                                      "Unit length in cgs (U_L)",
                                      "Unit mass in cgs (U_M)",
                                      "Unit time in cgs (U_t)",
                                      "Unit current in cgs (U_I)",
                                      "Unit temperature in cgs (U_T)"};
  const hid_t units = group(w, w->file, "Units");
  const double one = 1;
  for (size_t k = 0; k < sizeof names / sizeof *names; ++k) PUT(w, units, names[k], 0, &one);
  put_text(w, units, "Description", "code units: those of the scene, whatever they are");
  H5Gclose(units);
}

static void write_note(struct writer *w, hid_t run, const struct kith_note *note) {
  enum { MOST = 60000 };
  if (strlen(note->text) <= MOST) {
    put_text(w, run, note->name, note->text);
    return;
  }
  const hid_t type = text_type(note->text);
  put_data(w, run, note->name, type, note->text);
  H5Tclose(type);
}

static void write_run(struct writer *w) {
  const struct kith_nodes *nodes = w->nodes;
  const struct kith_snapshot_info *info = w->info;
  const hid_t run = group(w, w->file, "Run");
  const int64_t dimension = NDIM, step = (int64_t)info->step;
  uint32_t periodic[NDIM];
  for (int a = 0; a < NDIM; ++a) periodic[a] = info->periodic[a];
  char materials[KITH_MAX_LISTS * (sizeof nodes->lists[0].name + 1)] = "";
  for (int l = 0; l < nodes->n_lists; ++l) {
    if (l > 0) strcat(materials, "\n");
    strcat(materials, nodes->lists[l].name);
  }
  PUT(w, run, "Dimension", 0, &dimension);
  PUT(w, run, "Step", 0, &step);
  PUT(w, run, "Time", 0, &info->time);
  PUT(w, run, "BoxLower", NDIM, info->box.lower);
  PUT(w, run, "BoxUpper", NDIM, info->box.upper);
  PUT(w, run, "Periodic", NDIM, periodic);
  put_text(w, run, "MaterialNames", materials);
  for (const struct kith_note *note = info->notes; note != NULL && note->name != NULL; ++note)
    write_note(w, run, note);
  H5Gclose(run);
}

static void lay_out_all(struct writer *w) {
  const struct kith_nodes *nodes = w->nodes;
  const size_t n = w->n;
  w->particles = group(w, w->file, "PartType0");
  w->vtk = group(w, w->file, "VTKHDF");
  w->point_data = group(w, w->vtk, "PointData");
  write_header(w);
  write_units(w);
  write_run(w);
  PUT(w, w->vtk, "Version", 2, ((const int64_t[]){1, 0}));
  put_text(w, w->vtk, "Type", "UnstructuredGrid");
  for (int f = 0; f < nodes->n_fields; ++f)
    if (nodes->fields[f]->spec.output != NULL) w->layout->place[f] = lay_out_field(w, nodes->fields[f], n);
  if (!has_flags(nodes))
    w->layout->place[nodes->n_fields] = lay_out_field(w, &(struct kith_field){.spec = node_flags}, n);
  lay_out_cells(w, n, w->layout->place + nodes->n_fields + 1);
  H5Gclose(w->point_data);
  H5Gclose(w->vtk);
  H5Gclose(w->particles);
}

static kith_status failed(const struct writer *w) {
  KITH_FAIL(BAD_FILE, "%s: cannot write: %s", w->out->path, strerror(errno != 0 ? errno : EIO));
}

/* Writes everything but the values. Returns 1 if HDF5 cannot even start, else 0. */
static int lay_out(void *writer) {
  struct writer *w = writer;
  w->now = "the beginning of the file";
  errno = 0;
  const bool ready = H5open() >= 0 && H5Eset_auto2(H5E_DEFAULT, note_failure, w) >= 0;
  w->file = H5Fcreate(w->out->temporary, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  lay_out_all(w);
  w->now = "the end of the file";
  H5Fflush(w->file, H5F_SCOPE_LOCAL);
  H5Fget_eoa(w->file, &w->layout->end);
  H5Fclose(w->file);
  return !ready;
}

/* Makes the file, but for the values, in a process of its own (child.h), and makes room for the values. */
static kith_status lay_out_apart(struct writer *w) {
  const struct layout *layout = w->layout;
  int ended = kith_child_run(lay_out, w);
  /* Ended by a signal though nothing had failed: it came from outside, and the file can be begun again. */
  if (ended < 0 && layout->error == 0 && layout->failed[0] == '\0') ended = kith_child_run(lay_out, w);
  errno = layout->error;
  if (errno != 0) return failed(w);
  if (layout->failed[0] != '\0')
    KITH_FAIL(BAD_FILE, "%s: cannot write: HDF5 failed at %s", w->out->path, layout->failed);
  if (ended < 0) KITH_FAIL(BAD_FILE, "%s: cannot write: signal %d ended HDF5", w->out->path, -ended);
  if (ended > 0) KITH_FAIL(BAD_FILE, "%s: cannot write: HDF5 does not start", w->out->path);
  errno = posix_fallocate(w->descriptor, 0, (off_t)layout->end);
  return errno == 0 ? KITH_OK : failed(w);
}

/* ---- values: each rank writes its own rows, contiguous in each list, without waiting for others ---- */

static kith_status write_rows(const struct writer *w, haddr_t place, size_t first, size_t n, size_t size,
                              const void *values) {
  return kith_write_at(w->descriptor, values, n * size, place + first * size) == 0 ? KITH_OK : failed(w);
}

/* Vectors of NDIM into 3, tensors of NDIM x NDIM into 3 x 3; the rest is zero. */
static void pad(double *wide, const struct kith_field *field, size_t n, size_t columns) {
  const size_t components = (size_t)field->components;
#pragma omp parallel for schedule(static)
  for (size_t i = 0; i < n; ++i) {
    for (size_t k = 0; k < columns; ++k) wide[i * columns + k] = 0;
    for (size_t k = 0; k < components; ++k)
      wide[i * columns + (columns == 9 ? k / NDIM * 3 + k % NDIM : k)] = field->f64[i * components + k];
  }
}

/* Writes a field: the nodes that a rank has of a list are contiguous in the file, from row first[list] on.
 * `values` NULL: zeros. */
static kith_status fill_lists(const struct writer *w, haddr_t place, const struct kith_nodes *nodes,
                              const struct kith_field *field, const size_t *first, const char *values) {
  const size_t columns = columns_of(field), size = columns > 0 ? 8 * columns : kith_field_node_size(field);
  if (values == NULL) values = memset(w->room, 0, (size_t)nodes->n_internal * size);
  if (columns > (size_t)field->components && values != w->room) {
    pad(w->room, field, (size_t)nodes->n_internal, columns);
    values = w->room;
  }
  for (int l = 0; l < nodes->n_lists; ++l) {
    const struct kith_node_list *list = &nodes->lists[l];
    KITH_TRY(write_rows(w, place, first[l], (size_t)list->count, size, values + (size_t)list->first * size));
  }
  return KITH_OK;
}

/* Writes the fields that the nodes `like` have, of `nodes`: the same, or the frozen ones. Frozen nodes may
 * lack fields that were registered after they were set apart; these are zero in the file. */
static kith_status fill_fields(const struct writer *w, const struct kith_nodes *like,
                               const struct kith_nodes *nodes, const size_t *first) {
  for (int k = 0; k < like->n_fields; ++k) {
    if (like->fields[k]->spec.output == NULL) continue;
    const struct kith_field *field = kith_nodes_field_named(nodes, like->fields[k]->spec.name);
    KITH_TRY(fill_lists(w, w->layout->place[k], nodes, field != NULL ? field : like->fields[k], first,
                        field != NULL ? field->data : NULL));
  }
  if (has_flags(like)) return KITH_OK;
  const struct kith_field flags = {.spec = node_flags, .components = 1},
                          *barrier = kith_nodes_field_named(nodes, "barrier");
  uint8_t *flag = memset(w->room, nodes != like, (size_t)nodes->n_internal);
  for (kith_index i = 0; i < nodes->n_internal && nodes != like && barrier != NULL; ++i)
    if (barrier->u8[i]) flag[i] = KITH_BARRIER;
  return fill_lists(w, w->layout->place[like->n_fields], nodes, &flags, first, w->room);
}

/* Writes the cells of n nodes from row `first` on, and if `last` is set the offset behind the last cell. */
static kith_status fill_cells(const struct writer *w, const haddr_t place[CELL_DATA], size_t first, size_t n,
                              bool last) {
  int64_t *number = w->room;
  for (size_t i = 0; i < n + last; ++i) number[i] = (int64_t)(first + i);
  KITH_TRY(write_rows(w, place[0], first, n, 8, number));
  KITH_TRY(write_rows(w, place[1], first, n + last, 8, number));
  memset(number, 1, n);
  return write_rows(w, place[2], first, n, 1, number);
}

static kith_status fill_all(const struct writer *w, const struct kith_nodes *nodes,
                            const struct kith_nodes *frozen, const struct part *part) {
  const haddr_t *cells = w->layout->place + nodes->n_fields + 1;
  KITH_TRY(fill_fields(w, nodes, nodes, part->first));
  for (int l = 0; l < nodes->n_lists; ++l)
    KITH_TRY(fill_cells(w, cells, part->first[l], (size_t)nodes->lists[l].count, false));
  if (kith_ranks_rank(nodes->ranks) != 0) return KITH_OK;
  if (frozen != NULL) KITH_TRY(fill_fields(w, nodes, frozen, part->frozen));
  for (int l = 0; l < nodes->n_lists && frozen != NULL; ++l)
    KITH_TRY(fill_cells(w, cells, part->frozen[l], (size_t)frozen->lists[l].count, false));
  return fill_cells(w, cells, part->total, 0, true);
}

/* Writes the values of this rank. Ranks other than 0, which commits the file, sync what they wrote, since
 * they may be on other machines. */
static kith_status fill(struct writer *w, const struct kith_nodes *nodes, const struct kith_nodes *frozen,
                        const struct part *part) {
  const kith_index held = frozen != NULL ? frozen->n_internal : 0;
  const bool first = kith_ranks_rank(nodes->ranks) == 0;
  size_t columns = 1;
  for (int k = 0; k < nodes->n_fields; ++k)
    if (nodes->fields[k]->spec.output != NULL) columns = KITH_MAX(columns, columns_of(nodes->fields[k]));
  KITH_TRY(kith_resize(&w->room, 0, (size_t)KITH_MAX(nodes->n_internal, held) * columns + 1, 8));
  if (!first) w->descriptor = open(w->out->temporary, O_WRONLY | O_NOFOLLOW | O_CLOEXEC);
  if (w->descriptor < 0) return failed(w);
  kith_status status = fill_all(w, nodes, frozen, part);
  if (!first && fsync(w->descriptor) != 0 && status == KITH_OK) status = failed(w);
  if (!first) close(w->descriptor);
  return status;
}

static kith_status find_part(struct part *part, const struct kith_nodes *nodes,
                             const struct kith_nodes *frozen) {
  const int me = kith_ranks_rank(nodes->ranks), size = kith_ranks_size(nodes->ranks);
  int64_t *count = NULL;
  KITH_TRY(kith_nodes_counts(nodes, &count));
  for (int l = 0; l < nodes->n_lists; ++l) {
    for (int r = 0; r < size; ++r) {
      if (r == me) part->first[l] = part->total;
      part->total += (size_t)count[r * nodes->n_lists + l];
    }
    part->frozen[l] = part->total;
    if (frozen != NULL) part->total += (size_t)frozen->lists[l].count;
  }
  kith_free(&count);
  return KITH_OK;
}

static kith_status write_file(struct kith_atomic_file **file, const struct kith_nodes *nodes,
                              const struct kith_snapshot_info *info) {
  const bool first = kith_ranks_rank(nodes->ranks) == 0;
  struct part part = {0};
  struct writer w = {
      .out = *file, .nodes = nodes, .info = info, .descriptor = first ? fileno((*file)->stream) : -1};
  const size_t places = (size_t)nodes->n_fields + 1 + CELL_DATA,
               bytes = sizeof *w.layout + places * sizeof *w.layout->place;
  kith_status status = find_part(&part, nodes, info->frozen);
  w.n = part.total;
  w.layout = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (w.layout == MAP_FAILED) status = kith_fail(KITH_NO_MEMORY, "no memory to write %s", (*file)->path);
  if (status == KITH_OK && first) status = lay_out_apart(&w);
  status = kith_ranks_allreduce_status(nodes->ranks, status);
  if (status == KITH_OK) {
    kith_ranks_broadcast(nodes->ranks, w.layout, bytes);
    status = kith_ranks_allreduce_status(nodes->ranks, fill(&w, nodes, info->frozen, &part));
  }
  if (w.layout != MAP_FAILED) munmap(w.layout, bytes);
  kith_free(&w.room);
  KITH_TRY(status);
  return kith_ranks_allreduce_status(nodes->ranks, first ? kith_atomic_file_commit(file, false) : KITH_OK);
}

kith_status kith_snapshot_write(const char *path, const struct kith_nodes *nodes,
                                const struct kith_snapshot_info *info) {
  const bool first = kith_ranks_rank(nodes->ranks) == 0;
  struct kith_atomic_file *file;
  kith_status status = first ? kith_atomic_file_open(&file, path) : kith_atomic_file_join(&file, path);
  status = kith_ranks_allreduce_status(nodes->ranks, status);
  if (status == KITH_OK) status = write_file(&file, nodes, info);
  kith_atomic_file_abandon(&file);
  return status;
}
