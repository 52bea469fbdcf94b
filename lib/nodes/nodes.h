/* nodes.h - node lists and their fields: one index space for all of them.
 *
 *   [ list 0 internal | list 1 internal | ... | ghosts, block by block in creation order ]
 *     0 ............................. n_internal .......................... n_internal + n_ghost
 *
 * A pair is two indices and a field is one array. A node list is one material; `first` and `count` give its
 * range of indices, `list[i]` the list of a node. The 64-bit global id of a node never changes.
 *
 * A field is registered once; deleting, reordering, resizing, ghosts, checkpoint and snapshot act on all
 * registered fields. Arrays are [n][components], 64-byte aligned; they move when the nodes are resized, so
 * hold the `struct kith_field *`, not its data.
 *
 * Generations: counters of changes of positions, of the order of internal nodes and of ghosts. What is made
 * from them stores their values, and using it with other values is KITH_STALE. */
#ifndef KITH_NODES_NODES_H
#define KITH_NODES_NODES_H

#include "lib/core/base.h"
#include "lib/comm/ranks.h"
#include "lib/nodes/shifts.h"

enum { KITH_MAX_LISTS = 64, KITH_MAX_FIELDS = 96 };

/* How a value changes when its node is mirrored or shifted, and how many components it has. */
enum kith_kind {
  KITH_SCALAR,    /* 1; unchanged */
  KITH_VECTOR,    /* NDIM; the component along a mirrored axis flips */
  KITH_TENSOR,    /* NDIM*NDIM, [row][column]; flips once for each index along a mirrored axis */
  KITH_SYMMETRIC, /* NDIM*(NDIM+1)/2, the upper triangle of a symmetric tensor; never in snapshots */
  KITH_POSITION,  /* NDIM; mirrored and shifted */
  KITH_VELOCITY,  /* NDIM; a vector, and the velocity of the image is added */
};
enum kith_type { KITH_F64, KITH_I64, KITH_U8 };
enum kith_role {
  KITH_STATE,    /* evolves: in checkpoint, and new ghosts have it */
  KITH_KEPT,     /* in checkpoint too, but its node's own: ghosts do not have it until it is refreshed */
  KITH_DERIVED,  /* follows from the state: recomputed after a restart */
  KITH_WORK,     /* lives inside a step; ghosts do not have it until it is refreshed */
  KITH_OWN_KEPT, /* as KITH_KEPT, but of internal nodes alone: there is no memory of it for ghosts */
  KITH_OWN_WORK  /* as KITH_WORK, likewise */
};

struct kith_field_spec {
  const char *name; /* unique; [a-z_]+ ; borrowed: a string constant */
  enum kith_kind kind;
  enum kith_type type; /* other than F64 only for scalars */
  enum kith_role role;
  const char *output; /* snapshot data set, NULL: not in snapshots */
  const char *doc;
};
/* The specification of a field of doubles that is not in snapshots: KITH_SPEC(VECTOR, WORK, "name",
 * "doc"). */
#define KITH_SPEC(kind, role, name, doc) \
  { name, KITH_##kind, KITH_F64, KITH_##role, NULL, doc }

struct kith_field {
  struct kith_field_spec spec;
  int components;
  union { /* [capacity][components] of the nodes; without ghosts: [own_capacity][components] */
    double *f64;
    int64_t *i64;
    uint8_t *u8;
    void *data;
  };
};

struct kith_node_list {
  char name[32]; /* the material */
  kith_index first, count;
};

/* The image of a control node: x_ghost[a] = sign[a] * x_control[a] + shift[a], sign = 1 or -1. The mirror may
 * move: the shift grows with `velocity`, which velocities of ghosts have in addition. */
struct kith_image {
  double sign[NDIM], shift[NDIM], velocity[NDIM];
};

enum kith_ghost_kind {
  KITH_GHOST_IMAGE,  /* values follow the control node through `image` */
  KITH_GHOST_FROZEN, /* values stay; every ghost is its own control */
  KITH_GHOST_REMOTE, /* a node or an image of another rank: values come from there (lib/domain/halo.h) */
};

/* Ghosts of one boundary, one list and one image, contiguous from `first`. Controls are of the same list and
 * lie before the block (control[k] < first), so a block can be refreshed by threads. */
struct kith_ghost_block {
  enum kith_ghost_kind kind;
  int boundary; /* its index in the list of boundaries */
  int list;
  kith_index first, count;
  kith_index *control; /* [count], owned; NULL for frozen and remote ghosts */
  struct kith_image image;
};

/* What a node does at this evaluation. */
enum {
  KITH_IDLE,    /* nothing */
  KITH_TOUCHED, /* it receives what active neighbors give it, and no more */
  KITH_ACTIVE   /* it is evaluated */
};

/* What a node is. Totals are of gas alone. */
enum kith_flag {
  KITH_GAS,
  KITH_FROZEN,  /* it never moves */
  KITH_BARRIER, /* it never moves, and is a wall */
  KITH_ZONE     /* KITH_ZONE + 2 axis + side: behind that face, an inflow or outflow (boundaries/flow.h) */
};

struct kith_nodes {
  int n_lists;
  struct kith_node_list lists[KITH_MAX_LISTS];
  kith_index n_internal, n_ghost;
  kith_index capacity, own_capacity; /* of fields with ghosts; of fields of internal nodes alone */

  int n_fields;
  struct kith_field *fields[KITH_MAX_FIELDS]; /* owned; registration order */
  /* Always there: */
  struct kith_field *position;      /* KITH_POSITION, state */
  struct kith_field *support;       /* H: radius of the kernel's support, state */
  struct kith_field *search_radius; /* R >= 0, work: rows are built with it, see connectivity.h */
  struct kith_field *id;            /* I64, state: global, unique, never changes */
  struct kith_field *list;          /* U8, derived: the node's list, ghosts too */
  /* NULL unless kith_nodes_number_images: I64, derived, 0 for a node, for a ghost the number of the image of
   * its node; with the id it identifies every partner, on all ranks. */
  struct kith_field *image;
  /* NULL unless kith_nodes_mark_activity: U8, work, idle, touched or active; a ghost has that of its node. */
  struct kith_field *activity;
  /* NULL unless kith_nodes_flag: U8, state, what the node is (enum kith_flag); a ghost what its node is. */
  struct kith_field *flag;

  /* Supports are ellipsoids, with half axes stretch[a] H >= H; all 1: spheres. What is said of distances of
   * nodes and their supports is then said of `stretched`, x[a] / stretch[a]. */
  double stretch[NDIM], longest, volume; /* half axes, the longest one, their product */
  struct kith_field *stretched;          /* VECTOR, work, of the last update of a search; NULL: spheres */

  int n_blocks;
  size_t blocks_capacity;
  struct kith_ghost_block *blocks; /* creation order */
  struct kith_shifts shifts;       /* images of nodes and ghosts that are no ghosts; go with the ghosts */

  struct kith_work *work; /* owned: kith_nodes_work */

  struct kith_ranks *ranks; /* of the other nodes of the run; NULL: one process has all nodes. Borrowed */

  /* Generations. */
  uint64_t positions; /* to be increased by code that moves nodes or changes supports */
  uint64_t order;     /* internal nodes deleted, added, reordered */
  uint64_t ghosts;    /* as `order`; and ghosts created, dropped, culled */
};

/* An empty set of nodes with `n_lists` lists named by `names` (copied, at most 31 letters of each); the
 * fields that are always there are registered. BAD_INPUT unless there are 1 to KITH_MAX_LISTS lists. */
kith_status kith_nodes_create(struct kith_nodes **out, int n_lists, const char *const *names);
/* A copy of the internal nodes, which belongs to no ranks: with all fields, in the same order, or with those
 * that have an output and those that all nodes have. Its supports are spheres, and its members image,
 * activity and flag are NULL: kith_nodes_field_named finds these fields. */
kith_status kith_nodes_copy(struct kith_nodes **out, const struct kith_nodes *nodes, bool all_fields);
void kith_nodes_destroy(struct kith_nodes **nodes);

static inline kith_index kith_nodes_count(const struct kith_nodes *nodes) {
  return nodes->n_internal + nodes->n_ghost;
}

/* Registers a field, zero for all nodes. INTERNAL if the name is taken with another specification;
 * the same specification again gives the same field, also one that was given ghosts. *out is a view: the
 * nodes own it. */
kith_status kith_nodes_field(struct kith_nodes *nodes, const struct kith_field_spec *spec,
                             struct kith_field **out);
/* A row of a table of fields. */
struct kith_field_row {
  bool wanted; /* false: the field is not registered */
  struct kith_field_spec spec;
  struct kith_field **out; /* where its view goes */
};
/* Registers the wanted fields of a table, which ends with {0}. */
kith_status kith_nodes_fields(struct kith_nodes *nodes, const struct kith_field_row *table);
/* Gives a field of internal nodes memory for ghosts, which get its values when it is refreshed. */
kith_status kith_nodes_give_ghosts(struct kith_nodes *nodes, struct kith_field *field);
/* The field called `name`, or NULL. View. */
struct kith_field *kith_nodes_field_named(const struct kith_nodes *nodes, const char *name);

/* Makes supports ellipsoids with these half axes, at least 1. */
kith_status kith_nodes_stretch(struct kith_nodes *nodes, const double stretch[NDIM]);

/* Registers `image`: n + 2^16 m + 2^32 l for image n along axis 0 of image m along axis 1 of image l along
 * axis 2. */
kith_status kith_nodes_number_images(struct kith_nodes *nodes);

/* Registers `activity`: idle, until it is set. Lists are built, and passes run, for active and touched nodes
 * only. */
kith_status kith_nodes_mark_activity(struct kith_nodes *nodes);
static inline bool kith_node_active(const struct kith_nodes *nodes, kith_index i) {
  return nodes->activity == NULL || nodes->activity->u8[i] == KITH_ACTIVE;
}

/* Registers `flag`: gas, until it is set. */
kith_status kith_nodes_flag(struct kith_nodes *nodes);
static inline bool kith_node_is_gas(const struct kith_nodes *nodes, kith_index i) {
  return nodes->flag == NULL || nodes->flag->u8[i] == KITH_GAS;
}
static inline bool kith_node_is_frozen(const struct kith_nodes *nodes, kith_index i) {
  return nodes->flag != NULL && nodes->flag->u8[i] == KITH_FROZEN;
}

/* The end of the stretch of nodes (KITH_STRETCH) that begins at `begin`, at most `end`; `begin` if all nodes
 * in it are idle. */
static inline kith_index kith_stretch_end(const struct kith_nodes *nodes, kith_index begin, kith_index end) {
  const kith_index stop = KITH_MIN(begin + KITH_STRETCH, end);
  return nodes->activity != NULL && kith_all_zero(nodes->activity->u8, begin, stop) ? begin : stop;
}

/* Is the field in checkpoints? Where nodes have an activity, fields of work are, because idle nodes keep
 * their values from one evaluation to the next. */
static inline bool kith_field_lasts(const struct kith_nodes *nodes, const struct kith_field *field) {
  const enum kith_role role = field->spec.role;
  return role == KITH_STATE || role == KITH_KEPT || role == KITH_OWN_KEPT ||
         (nodes->activity != NULL && (role == KITH_WORK || role == KITH_OWN_WORK));
}
/* Does the field belong to internal nodes alone? */
static inline bool kith_field_is_own(const struct kith_field *field) {
  return field->spec.role == KITH_OWN_KEPT || field->spec.role == KITH_OWN_WORK;
}

/* Bytes of one node's values. */
size_t kith_field_node_size(const struct kith_field *field);

/* Makes room for so many more internal nodes and ghosts. Fields that must be moved for it grow by at least an
 * eighth of their capacity. */
kith_status kith_nodes_grow(struct kith_nodes *nodes, kith_index internal, kith_index ghosts);
/* Gives memory back. Fields keep room for an eighth more than the present nodes and ghosts. */
kith_status kith_nodes_shrink(struct kith_nodes *nodes);
/* Appends `count` internal nodes to list `list` (ghosts are dropped first), all fields zero, ids -1.
 * Later lists move up. *first is the index of the first new node. */
kith_status kith_nodes_append(struct kith_nodes *nodes, int list, kith_index count, kith_index *first);
/* Deletes the internal nodes whose dead[i] != 0 (length n_internal; NULL: all); ghosts are dropped first.
 * Order is kept. */
kith_status kith_nodes_delete(struct kith_nodes *nodes, const uint8_t *dead);
/* New internal node k is old node order[k]: a permutation that keeps every node in its list. Ghosts are
 * dropped. */
kith_status kith_nodes_reorder(struct kith_nodes *nodes, const kith_index *order);
/* Sorts each list by key[n_internal], then id. *sorted (may be NULL): the nodes were in this order already,
 * and nothing was done. */
kith_status kith_nodes_sort(struct kith_nodes *nodes, const uint64_t *key, bool *sorted);

/* Drops all ghosts and shifts. */
void kith_nodes_drop_ghosts(struct kith_nodes *nodes);
/* Appends a block of ghosts. Ownership of `control` passes to the nodes, also on failure. Image ghosts get
 * the fields that new ghosts have; the caller fills frozen ones, which are zero, and remote ones, which have
 * any values. An empty block is not kept. */
kith_status kith_nodes_add_ghosts(struct kith_nodes *nodes, const struct kith_ghost_block *block);
/* The fields that a new ghost has: the state, with the id, and list, image, activity and search radius. Code
 * that reads another field of ghosts must refresh it first. Writes fields[KITH_MAX_FIELDS]; returns how
 * many. */
int kith_nodes_ghost_fields(const struct kith_nodes *nodes, struct kith_field **fields);
/* Gives image ghosts the values of their control nodes, block by block (ghosts of ghosts follow), for these
 * fields. Bitwise identical for any number of threads. Remote ghosts get theirs by kith_halo_refresh, which
 * calls this first. */
void kith_nodes_refresh_images(struct kith_nodes *nodes, struct kith_field *const *fields, int n_fields);
/* All values of internal node i become those of this image of it, in all fields. */
void kith_nodes_map(struct kith_nodes *nodes, kith_index i, const struct kith_image *image);
/* The block of a ghost. */
static inline const struct kith_ghost_block *kith_nodes_ghost_block(const struct kith_nodes *nodes,
                                                                    kith_index ghost) {
  const struct kith_ghost_block *block = nodes->blocks;
  for (int n = nodes->n_blocks; n > 1; n -= n / 2) block += block[n / 2].first <= ghost ? n / 2 : 0;
  return block;
}
/* The first remote ghost; all from here on are. kith_nodes_count if there is none. */
kith_index kith_nodes_first_remote(const struct kith_nodes *nodes);
/* Removes ghosts whose keep[i - n_internal] is 0. keep is completed first: the control of a kept ghost is
 * kept. renumber[i] (length n_internal + n_ghost before, written) is the new index or -1. Order is kept;
 * empty blocks go. */
kith_status kith_nodes_cull_ghosts(struct kith_nodes *nodes, uint8_t *keep, kith_index *renumber);

/* *p: scratch memory with any contents. It is valid until the next call, which gives the same memory to
 * another user: what is needed at different times of a step (candidates of rows, packed particles, images)
 * shares it. */
kith_status kith_nodes_work(const struct kith_nodes *nodes, size_t bytes, void *p);
/* How many bytes kith_nodes_work can give without an allocation. */
size_t kith_nodes_work_bytes(const struct kith_nodes *nodes);
/* Frees that memory until it is needed again. */
void kith_nodes_free_work(const struct kith_nodes *nodes);

size_t kith_nodes_bytes(const struct kith_nodes *nodes);

#endif
