/* snapshot.c - the layout of a snapshot, written through HDF5. */
#include "lib/io/snapshot.h"

#include <fcntl.h>
#include <hdf5.h>
#include <string.h>
#include <unistd.h>
#include "lib/nodes/migrate.h"
#include "lib/io/atomic_file.h"

/* HDF5 handles are numbers, negative after a failure. No call is skipped then, so that the layout below reads
 * as a list: calls of HDF5 with a negative handle fail as well, and HDF5 tells note_failure of each. */
struct writer {
  const struct kith_atomic_file *out;
  hid_t file, particles, vtk, point_data;
  void *room; /* for the widest field of this rank's nodes */
  const char *now;
  char failed[96]; /* what was written at the first failure; empty: none */
};

/* Rows of the file. */
struct part {
  size_t total;                  /* nodes of all ranks, and frozen ones */
  size_t first[KITH_MAX_LISTS];  /* row of the first node of a list of this rank */
  size_t frozen[KITH_MAX_LISTS]; /* the same of frozen nodes, which rank 0 writes */
};

static herr_t note_failure(hid_t stack, void *writer) {
  struct writer *w = writer;
  (void)stack;
  if (w->failed[0] == '\0') snprintf(w->failed, sizeof w->failed, "%s", w->now);
  return 0;
}

static kith_status outcome(const struct writer *w) {
  if (w->failed[0] == '\0') return KITH_OK;
  KITH_FAIL(BAD_FILE, "%s: cannot write: HDF5 failed at %s", w->out->path, w->failed);
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

/* Fixed length without the zero: what VTK's reader compares, and what every reader gets as bytes. */
static hid_t text_type(const char *text) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, KITH_MAX(strlen(text), (size_t)1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
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

static void lay_out_field(struct writer *w, const struct kith_field *field, size_t n) {
  const char *name = field->spec.output;
  const hid_t data = new_data(w, w->particles, name, native_type(field->spec.type), n, columns_of(field));
  put_text(w, data, "Description", field->spec.doc != NULL ? field->spec.doc : "");
  H5Dclose(data);
  const bool points = field->spec.kind == KITH_POSITION;
  H5Lcreate_hard(w->particles, name, points ? w->vtk : w->point_data, points ? "Points" : name, H5P_DEFAULT,
                 H5P_DEFAULT);
}

static const struct kith_field_spec node_flags = {
    .type = KITH_U8, .output = "NodeFlags", .doc = "0 internal, 1 frozen, 2 frozen and a barrier"};

/* One VERTEX cell (type 1 of VTK) a node. */
static void lay_out_cells(struct writer *w, size_t n) {
  static const char *const counts[] = {"NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"};
  const int64_t count = (int64_t)n;
  for (int k = 0; k < 3; ++k) put_data(w, w->vtk, counts[k], H5T_NATIVE_INT64, &count);
  H5Dclose(new_data(w, w->vtk, "Connectivity", H5T_NATIVE_INT64, n, 0));
  H5Dclose(new_data(w, w->vtk, "Offsets", H5T_NATIVE_INT64, n + 1, 0));
  H5Dclose(new_data(w, w->vtk, "Types", H5T_NATIVE_UINT8, n, 0));
}

/* Six particle types, of which type 0 is used. No attribute Code, no root group Parameters: yt stumbles over
 * them. */
static void write_header(struct writer *w, size_t n, const struct kith_snapshot_info *info) {
  static const char *const flags[] = {"Flag_Sfr",    "Flag_Cooling",  "Flag_StellarAge",
                                      "Flag_Metals", "Flag_Feedback", "Flag_Entropy_ICs"};
  static const char *const zeros[] = {"Redshift", "Omega0", "OmegaLambda"};
  const hid_t header = group(w, w->file, "Header");
  const uint32_t low[6] = {(uint32_t)n}, high[6] = {(uint32_t)((uint64_t)n >> 32)};
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

static void write_run(struct writer *w, const struct kith_nodes *nodes,
                      const struct kith_snapshot_info *info) {
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

static void lay_out_all(struct writer *w, const struct kith_nodes *nodes, size_t n,
                        const struct kith_snapshot_info *info) {
  w->particles = group(w, w->file, "PartType0");
  w->vtk = group(w, w->file, "VTKHDF");
  w->point_data = group(w, w->vtk, "PointData");
  write_header(w, n, info);
  write_units(w);
  write_run(w, nodes, info);
  PUT(w, w->vtk, "Version", 2, ((const int64_t[]){1, 0}));
  put_text(w, w->vtk, "Type", "UnstructuredGrid");
  for (int f = 0; f < nodes->n_fields; ++f)
    if (nodes->fields[f]->spec.output != NULL) lay_out_field(w, nodes->fields[f], n);
  lay_out_field(w, &(struct kith_field){.spec = node_flags}, n);
  lay_out_cells(w, n);
  H5Gclose(w->point_data);
  H5Gclose(w->vtk);
  H5Gclose(w->particles);
}

/* An upper bound of the file's size: data, cells, notes, and what HDF5 spends on names and attributes. */
static off_t room_for(const struct kith_nodes *nodes, size_t n, const struct kith_snapshot_info *info) {
  enum { BASE = 1 << 17, PER_FIELD = 1 << 13, CELLS = 17 };
  size_t bytes = BASE;
  for (int f = 0; f < nodes->n_fields; ++f) {
    const size_t columns = KITH_MAX(columns_of(nodes->fields[f]), (size_t)1);
    if (nodes->fields[f]->spec.output != NULL) bytes += PER_FIELD + n * columns * 8;
  }
  for (const struct kith_note *note = info->notes; note != NULL && note->name != NULL; ++note)
    bytes += 2 * strlen(note->text) + PER_FIELD;
  return (off_t)(bytes + n * CELLS);
}

static kith_status reserve(const struct kith_atomic_file *file, off_t bytes) {
  const int error = posix_fallocate(fileno(file->stream), 0, bytes);
  if (error != 0) KITH_FAIL(BAD_FILE, "%s: cannot write: %s", file->path, strerror(error));
  return KITH_OK;
}

/* Gives back what was reserved and not used: the file ends where HDF5 says it does. */
static kith_status trim(struct writer *w) {
  haddr_t end = 0;
  w->now = "the end of the file";
  const hid_t id = H5Fopen(w->out->temporary, H5F_ACC_RDONLY, H5P_DEFAULT);
  H5Fget_eoa(id, &end);
  H5Fclose(id);
  if (w->failed[0] == '\0' && ftruncate(fileno(w->out->stream), (off_t)end) != 0) note_failure(0, w);
  return outcome(w);
}

/* By rank 0. When the disk is full HDF5 1.10 cannot close its file, keeps it, and brings the program down at
 * exit. So the room is reserved before HDF5 begins, and again when it has emptied the file. */
static kith_status lay_out(struct writer *w, const struct kith_nodes *nodes, size_t n,
                           const struct kith_snapshot_info *info) {
  const off_t room = room_for(nodes, n, info);
  KITH_TRY(reserve(w->out, room));
  w->now = "the beginning of the file";
  w->file = H5Fcreate(w->out->temporary, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  KITH_TRY(outcome(w));
  const kith_status status = reserve(w->out, room);
  if (status == KITH_OK) lay_out_all(w, nodes, n, info);
  w->now = "the end of the file";
  H5Fclose(w->file);
  return status == KITH_OK ? trim(w) : status;
}

/* Values, by all ranks: each writes its own rows, which are contiguous in each list, without waiting for
 * others. (A collective write is not faster, and Open MPI 4.1 hangs in it when one rank cannot write.) */

static void write_rows(const struct writer *w, hid_t data, hid_t type, size_t columns, size_t first, size_t n,
                       const void *values) {
  const hsize_t start[2] = {first, 0}, extent[2] = {n, KITH_MAX(columns, (size_t)1)};
  if (n == 0 || w->failed[0] != '\0') return;
  const hid_t there = H5Dget_space(data), here = H5Screate_simple(columns == 0 ? 1 : 2, extent, NULL);
  H5Sselect_hyperslab(there, H5S_SELECT_SET, start, NULL, extent, NULL);
  H5Dwrite(data, type, here, there, H5P_DEFAULT, values);
  H5Sclose(here);
  H5Sclose(there);
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

/* List by list: those of a rank are in one piece. `values` NULL: zero; `first`: rows of the file. */
static void fill_lists(const struct writer *w, const struct kith_nodes *nodes, const struct kith_field *field,
                       const size_t *first, const char *values) {
  const size_t columns = columns_of(field), size = columns > 0 ? 8 * columns : kith_field_node_size(field);
  char path[64];
  if (values == NULL) values = memset(w->room, 0, (size_t)nodes->n_internal * size);
  if (columns > (size_t)field->components && values != w->room) {
    pad(w->room, field, (size_t)nodes->n_internal, columns);
    values = w->room;
  }
  snprintf(path, sizeof path, "PartType0/%s", field->spec.output);
  const hid_t data = H5Dopen2(w->file, path, H5P_DEFAULT);
  for (int l = 0; l < nodes->n_lists; ++l) {
    const struct kith_node_list *list = &nodes->lists[l];
    write_rows(w, data, native_type(field->spec.type), columns, first[l], (size_t)list->count,
               values + (size_t)list->first * size);
  }
  H5Dclose(data);
}

/* The fields of these nodes as far as `like` has them; those that were registered later are zero. */
static void fill_fields(const struct writer *w, const struct kith_nodes *like, const struct kith_nodes *nodes,
                        const size_t *first) {
  for (int k = 0; k < like->n_fields; ++k) {
    if (like->fields[k]->spec.output == NULL) continue;
    const struct kith_field *field = kith_nodes_field_named(nodes, like->fields[k]->spec.name);
    fill_lists(w, nodes, field != NULL ? field : like->fields[k], first, field != NULL ? field->data : NULL);
  }
  const struct kith_field flags = {.spec = node_flags, .components = 1},
                          *barrier = kith_nodes_field_named(nodes, "barrier");
  uint8_t *flag = memset(w->room, nodes != like, (size_t)nodes->n_internal);
  for (kith_index i = 0; i < nodes->n_internal && nodes != like && barrier != NULL; ++i)
    if (barrier->u8[i]) flag[i] = 2;
  fill_lists(w, nodes, &flags, first, w->room);
}

/* Of n nodes from row `first` on; `last`: the end of the last cell too. */
static void fill_cells(const struct writer *w, size_t first, size_t n, bool last) {
  static const char *const names[] = {"VTKHDF/Connectivity", "VTKHDF/Offsets", "VTKHDF/Types"};
  int64_t *number = w->room;
  for (size_t i = 0; i < n + last; ++i) number[i] = (int64_t)(first + i);
  for (int k = 0; k < 3; ++k) {
    const hid_t data = H5Dopen2(w->file, names[k], H5P_DEFAULT);
    if (k == 2) memset(w->room, 1, n);
    write_rows(w, data, k == 2 ? H5T_NATIVE_UINT8 : H5T_NATIVE_INT64, 0, first, n + (k == 1 && last),
               w->room);
    H5Dclose(data);
  }
}

static void fill_all(const struct writer *w, const struct kith_nodes *nodes, const struct kith_nodes *frozen,
                     const struct part *part) {
  const bool writes_all = kith_ranks_rank(nodes->ranks) == 0;
  fill_fields(w, nodes, nodes, part->first);
  for (int l = 0; l < nodes->n_lists; ++l)
    fill_cells(w, part->first[l], (size_t)nodes->lists[l].count, false);
  if (!writes_all) return;
  if (frozen != NULL) fill_fields(w, nodes, frozen, part->frozen);
  for (int l = 0; l < nodes->n_lists && frozen != NULL; ++l)
    fill_cells(w, part->frozen[l], (size_t)frozen->lists[l].count, false);
  fill_cells(w, part->total, 0, true);
}

static kith_status room_to_fill(struct writer *w, const struct kith_nodes *nodes,
                                const struct kith_nodes *frozen) {
  const kith_index held = frozen != NULL ? frozen->n_internal : 0;
  size_t columns = 1;
  for (int k = 0; k < nodes->n_fields; ++k)
    if (nodes->fields[k]->spec.output != NULL) columns = KITH_MAX(columns, columns_of(nodes->fields[k]));
  if (access(w->out->temporary, R_OK | W_OK) != 0)
    KITH_FAIL(BAD_FILE, "%s: cannot write: not there for all ranks", w->out->path);
  return kith_resize(&w->room, 0, (size_t)KITH_MAX(nodes->n_internal, held) * columns + 1, 8);
}

static kith_status fill(struct writer *w, const struct kith_nodes *nodes, const struct kith_nodes *frozen,
                        const struct part *part) {
  KITH_TRY(kith_ranks_allreduce_status(nodes->ranks, room_to_fill(w, nodes, frozen)));
  const hid_t how = H5Pcreate(H5P_FILE_ACCESS);
  /* Nothing is held back in a buffer: what cannot be written is known at once, and the file can be closed. */
  H5Pset_sieve_buf_size(how, 0);
  if (nodes->ranks != NULL)
    H5Pset_fapl_mpio(how, MPI_Comm_f2c(kith_ranks_communicator(nodes->ranks)), MPI_INFO_NULL);
  w->now = "the values";
  w->file = H5Fopen(w->out->temporary, H5F_ACC_RDWR, how);
  H5Pclose(how);
  KITH_TRY(outcome(w));
  fill_all(w, nodes, frozen, part);
  H5Fflush(w->file, H5F_SCOPE_GLOBAL); /* on each machine */
  H5Fclose(w->file);
  return kith_ranks_allreduce_status(nodes->ranks, outcome(w));
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
  struct writer w = {.out = *file, .now = "its start"};
  KITH_TRY(find_part(&part, nodes, info->frozen));
  H5Eset_auto2(H5E_DEFAULT, note_failure, &w);
  kith_status status =
      kith_ranks_allreduce_status(nodes->ranks, first ? lay_out(&w, nodes, part.total, info) : KITH_OK);
  if (status == KITH_OK) status = fill(&w, nodes, info->frozen, &part);
  kith_free(&w.room);
  KITH_TRY(status);
  return kith_ranks_allreduce_status(nodes->ranks, first ? kith_atomic_file_commit(file, false) : KITH_OK);
}

kith_status kith_snapshot_write(const char *path, const struct kith_nodes *nodes,
                                const struct kith_snapshot_info *info) {
  const bool first = kith_ranks_rank(nodes->ranks) == 0;
  struct kith_atomic_file *file;
  H5E_auto2_t print;
  void *with;
  kith_status status = first ? kith_atomic_file_open(&file, path) : kith_atomic_file_join(&file, path);
  status = kith_ranks_allreduce_status(nodes->ranks, status);
  H5Eget_auto2(H5E_DEFAULT, &print, &with);
  if (status == KITH_OK) status = write_file(&file, nodes, info);
  H5Eset_auto2(H5E_DEFAULT, print, with);
  kith_atomic_file_abandon(&file);
  return status;
}
