/* test_nodes.c - lists of nodes, fields of all kinds and types, ghosts, reordering and culling. Oracle: a
 * field's value is a function of the id of its node, so that every value shows whether it has followed its
 * node. */
#include "tests/check.h"
#include "lib/core/sfc_key.h"
#include "lib/nodes/nodes.h"
#include <stdlib.h>
#include <string.h>

static const char *const names[] = {"air", "water", "rock", "none"};

struct fixture {
  struct kith_nodes *nodes;
  struct kith_field *mass, *velocity, *gradient, *stress, *counter, *flag;
};

static struct fixture make(int n_lists) {
  struct fixture f = {0};
  const struct kith_field_row table[] = {
      {true, {"mass", KITH_SCALAR, KITH_F64, KITH_STATE, "Masses", "m"}, &f.mass},
      {true, {"velocity", KITH_VECTOR, KITH_F64, KITH_STATE, NULL, "v"}, &f.velocity},
      {true, {"gradient", KITH_TENSOR, KITH_F64, KITH_STATE, NULL, "dv/dx"}, &f.gradient},
      {true, {"stress", KITH_SYMMETRIC, KITH_F64, KITH_STATE, NULL, "s"}, &f.stress},
      {true, {"counter", KITH_SCALAR, KITH_I64, KITH_STATE, NULL, "n"}, &f.counter},
      {true, {"flag", KITH_SCALAR, KITH_U8, KITH_STATE, NULL, "f"}, &f.flag},
      {0}};
  CHECK_OK(kith_nodes_create(&f.nodes, n_lists, names));
  CHECK_OK(kith_nodes_fields(f.nodes, table));
  return f;
}

/* The value of a field of the node with this id. */
static double value(int64_t id, int which, int component) {
  return (double)id * 16 + which + component * 0x1p-8;
}

static void set_values(struct fixture *f, kith_index i, int64_t id) {
  f->nodes->id->i64[i] = id;
  for (int a = 0; a < NDIM; ++a) {
    f->nodes->position->f64[i * NDIM + a] = value(id, 0, a);
    f->velocity->f64[i * NDIM + a] = value(id, 1, a);
  }
  for (int c = 0; c < NDIM * NDIM; ++c) f->gradient->f64[i * NDIM * NDIM + c] = value(id, 2, c);
  for (int c = 0; c < NDIM * (NDIM + 1) / 2; ++c)
    f->stress->f64[i * (NDIM * (NDIM + 1) / 2) + c] = value(id, 6, c);
  f->nodes->support->f64[i] = value(id, 3, 0);
  f->nodes->search_radius->f64[i] = value(id, 4, 0);
  f->mass->f64[i] = value(id, 5, 0);
  f->counter->i64[i] = INT64_MAX - id;
  f->flag->u8[i] = (uint8_t)(id % 251);
}

/* Does node i have the values of its id, seen through sign and shift (NULL: none)? */
static bool has_image_values(const struct fixture *f, kith_index i, const double *sign, const double *shift) {
  const int64_t id = f->nodes->id->i64[i];
  double s[NDIM], t[NDIM];
  for (int a = 0; a < NDIM; ++a) s[a] = sign != NULL ? sign[a] : 1, t[a] = shift != NULL ? shift[a] : 0;
  bool ok = f->counter->i64[i] == INT64_MAX - id && f->flag->u8[i] == (uint8_t)(id % 251);
  ok = ok && f->nodes->support->f64[i] == value(id, 3, 0) &&
       f->nodes->search_radius->f64[i] == value(id, 4, 0);
  ok = ok && f->mass->f64[i] == value(id, 5, 0);
  for (int a = 0; a < NDIM; ++a) {
    ok = ok && f->nodes->position->f64[i * NDIM + a] == s[a] * value(id, 0, a) + t[a];
    ok = ok && f->velocity->f64[i * NDIM + a] == s[a] * value(id, 1, a);
    for (int b = 0; b < NDIM; ++b)
      ok = ok && f->gradient->f64[(i * NDIM + a) * NDIM + b] == s[a] * s[b] * value(id, 2, a * NDIM + b);
  }
  for (int a = 0, c = 0; a < NDIM; ++a)
    for (int b = a; b < NDIM; ++b, ++c)
      ok = ok && f->stress->f64[i * (NDIM * (NDIM + 1) / 2) + c] == s[a] * s[b] * value(id, 6, c);
  return ok;
}

static bool has_values(const struct fixture *f, kith_index i) {
  return has_image_values(f, i, NULL, NULL);
}

static void append(struct fixture *f, int list, kith_index count, int64_t id) {
  kith_index first = -1;
  CHECK_OK(kith_nodes_append(f->nodes, list, count, &first));
  CHECK(first == f->nodes->lists[list].first + f->nodes->lists[list].count - count);
  for (kith_index k = 0; k < count; ++k) {
    CHECK(f->nodes->id->i64[first + k] == -1 && f->mass->f64[first + k] == 0 && f->flag->u8[first + k] == 0);
    CHECK(f->nodes->list->u8[first + k] == list);
    set_values(f, first + k, id + k);
  }
}

/* Lists follow each other from 0, each node is in its list, ghosts are behind, and all values are right. */
static void check_layout(const struct fixture *f) {
  kith_index place = 0;
  for (int l = 0; l < f->nodes->n_lists; ++l) {
    CHECK(f->nodes->lists[l].first == place);
    for (kith_index k = 0; k < f->nodes->lists[l].count; ++k) {
      CHECK(f->nodes->list->u8[place + k] == l);
      CHECK(has_values(f, place + k));
    }
    place += f->nodes->lists[l].count;
  }
  CHECK(place == f->nodes->n_internal);
  for (int b = 0; b < f->nodes->n_blocks; ++b) {
    CHECK(f->nodes->blocks[b].first == place);
    place += f->nodes->blocks[b].count;
  }
  CHECK(place == kith_nodes_count(f->nodes) && place <= f->nodes->capacity);
}

static void check_registration(void) {
  struct kith_nodes *nodes = NULL;
  CHECK_STATUS(KITH_BAD_INPUT, kith_nodes_create(&nodes, 0, names));
  CHECK_STATUS(KITH_BAD_INPUT, kith_nodes_create(&nodes, KITH_MAX_LISTS + 1, names));
  CHECK(nodes == NULL);
  kith_nodes_destroy(&nodes);
  struct fixture f = make(2);
  CHECK(strcmp(f.nodes->lists[1].name, "water") == 0 && f.nodes->n_internal == 0 &&
        f.nodes->lists[1].count == 0);
  CHECK(kith_nodes_field_named(f.nodes, "id") == f.nodes->id &&
        kith_nodes_field_named(f.nodes, "idle") == NULL);
  CHECK(f.velocity->components == NDIM && f.gradient->components == NDIM * NDIM && f.flag->components == 1);
  struct kith_field_spec spec = f.mass->spec;
  struct kith_field *again = NULL;
  CHECK_OK(kith_nodes_field(f.nodes, &spec, &again));
  CHECK(again == f.mass);
  spec.role = KITH_WORK;
  CHECK_STATUS(KITH_INTERNAL, kith_nodes_field(f.nodes, &spec, &again));
  spec = (struct kith_field_spec){"bad", KITH_VECTOR, KITH_I64, KITH_WORK, NULL, ""};
  CHECK_STATUS(KITH_INTERNAL, kith_nodes_field(f.nodes, &spec, &again));
  append(&f, 0, 5, 0);
  spec = (struct kith_field_spec){"late", KITH_VECTOR, KITH_F64, KITH_WORK, NULL, ""};
  CHECK_OK(kith_nodes_field(f.nodes, &spec, &again));
  for (int k = 0; k < 5 * NDIM; ++k) CHECK(again->f64[k] == 0);
  static char text[KITH_MAX_FIELDS][8];
  spec.kind = KITH_SCALAR;
  kith_status status = KITH_OK;
  for (int k = 0; k < KITH_MAX_FIELDS && status == KITH_OK; ++k) {
    snprintf(text[k], sizeof text[k], "f%d", k);
    spec.name = text[k];
    status = kith_nodes_field(f.nodes, &spec, &again);
  }
  CHECK(status == KITH_INTERNAL && f.nodes->n_fields == KITH_MAX_FIELDS);
  kith_nodes_destroy(&f.nodes);
  CHECK(f.nodes == NULL);
}

static void check_growth(void) {
  struct fixture f = make(3);
  append(&f, 1, 0, 0);
  append(&f, 1, 7, 100);
  append(&f, 0, 3, 200);
  append(&f, 2, 1, 300);
  append(&f, 1, 4, 107);
  check_layout(&f);
  CHECK(f.nodes->lists[1].first == 3 && f.nodes->lists[1].count == 11 && f.nodes->lists[2].first == 14);
  int moves = 0;
  /* one node at a time; memory grows by an eighth, so about log(2000 / 16) / log(1.125) = 41 times */
  for (int k = 0; k < 2000; ++k) {
    const kith_index before = f.nodes->capacity;
    append(&f, 0, 1, 1000 + k);
    moves += f.nodes->capacity != before;
  }
  CHECK(moves < 60);
  check_layout(&f);
  const size_t bytes = kith_nodes_bytes(f.nodes);
  CHECK_OK(kith_nodes_grow(f.nodes, 2 * f.nodes->capacity, 0));
  CHECK(kith_nodes_bytes(f.nodes) > 3 * bytes / 2);
  check_layout(&f);
  CHECK_STATUS(KITH_INTERNAL, kith_nodes_append(f.nodes, 3, 1, NULL));
  CHECK_STATUS(KITH_UNSUPPORTED, kith_nodes_append(f.nodes, 0, INT32_MAX, NULL));
  check_layout(&f);
  kith_nodes_destroy(&f.nodes);
}

static void check_delete(void) {
  struct fixture f = make(4);
  append(&f, 0, 100, 0);
  append(&f, 2, 57, 1000);
  append(&f, 3, 5, 2000);
  uint64_t seed = 3;
  for (int round = 0; round < 6; ++round) {
    uint8_t dead[200];
    int64_t left[200];
    kith_index n = 0;
    for (kith_index i = 0; i < f.nodes->n_internal; ++i) {
      dead[i] = round == 0 ? 0 : round == 5 ? 1 : check_random(&seed) < 0.3;
      if (f.nodes->list->u8[i] == 3 && round == 1) dead[i] = 1; /* the list becomes empty */
      if (!dead[i]) left[n++] = f.nodes->id->i64[i];
    }
    CHECK_OK(kith_nodes_delete(f.nodes, dead));
    CHECK(f.nodes->n_internal == n);
    check_layout(&f);
    for (kith_index i = 0; i < n; ++i) CHECK(f.nodes->id->i64[i] == left[i]);
  }
  append(&f, 3, 2, 7);
  check_layout(&f);
  kith_nodes_destroy(&f.nodes);
}

static void check_reorder(void) {
  struct fixture f = make(4);
  append(&f, 0, 3000, 0);
  append(&f, 1, 1, 5000);
  append(&f, 3, 2500, 10000);
  kith_index *order = malloc(sizeof *order * (size_t)f.nodes->n_internal);
  uint64_t seed = 9;
  for (kith_index i = 0; i < f.nodes->n_internal; ++i) order[i] = i;
  for (int l = 0; l < 4; ++l)
    for (kith_index k = f.nodes->lists[l].count - 1; k > 0; --k) {
      const kith_index other = (kith_index)(check_random(&seed) * (k + 1)), first = f.nodes->lists[l].first;
      const kith_index t = order[first + k];
      order[first + k] = order[first + other], order[first + other] = t;
    }
  const uint64_t generation = f.nodes->ghosts;
  CHECK_OK(kith_nodes_reorder(f.nodes, order));
  CHECK(f.nodes->ghosts != generation);
  check_layout(&f);
  for (kith_index k = 0; k < 3000; ++k) CHECK(f.nodes->id->i64[k] == order[k]);
  for (kith_index k = 3001; k < 5501; ++k) CHECK(f.nodes->id->i64[k] == order[k] - 3001 + 10000);
  check_layout(&f);
  free(order);
  kith_nodes_destroy(&f.nodes);
}

/* Sorts the nodes along the curve in the box lower .. upper. Were they in this order already? */
static bool sort_along_curve(struct kith_nodes *nodes, const double *lower, const double *upper) {
  uint64_t *key = malloc(sizeof *key * (size_t)nodes->n_internal);
  bool sorted = false;
  kith_sfc_keys(nodes->position->f64, nodes->n_internal, lower, upper, key);
  CHECK_OK(kith_nodes_sort(nodes, key, &sorted));
  free(key);
  return sorted;
}

/* On a coarse lattice many nodes have the same position, so that ids decide. */
static void check_curve_order(void) {
  struct fixture f = make(3);
  append(&f, 0, 1500, 0);
  append(&f, 2, 700, 5000);
  uint64_t seed = 11;
  double lower[NDIM], upper[NDIM];
  for (int a = 0; a < NDIM; ++a) lower[a] = 0, upper[a] = 1;
  const kith_index n = f.nodes->n_internal;
  for (kith_index i = 0; i < n; ++i) {
    f.nodes->id->i64[i] = (i * INT64_C(7919)) % 100003; /* 100003 is prime: unique */
    for (int a = 0; a < NDIM; ++a)
      f.nodes->position->f64[i * NDIM + a] =
          floor(check_random(&seed) * 6) / 4 - 0.125; /* some lie outside */
  }
  CHECK(!sort_along_curve(f.nodes, lower, upper));
  double inverse[NDIM];
  for (int a = 0; a < NDIM; ++a) inverse[a] = (double)(UINT64_C(1) << KITH_SFC_KEY_BITS);
  int ties = 0;
  for (kith_index i = 1; i < n; ++i) {
    if (f.nodes->list->u8[i] != f.nodes->list->u8[i - 1]) continue;
    const uint64_t before = kith_sfc_key_of_position(f.nodes->position->f64 + (i - 1) * NDIM, lower, inverse);
    const uint64_t here = kith_sfc_key_of_position(f.nodes->position->f64 + i * NDIM, lower, inverse);
    CHECK(before < here || (before == here && f.nodes->id->i64[i - 1] < f.nodes->id->i64[i]));
    ties += before == here;
  }
  CHECK(ties > 100);
  const uint64_t generation = f.nodes->order;
  CHECK(sort_along_curve(f.nodes, lower, upper) && f.nodes->order == generation);
  /* in a flat box ids alone decide */
  CHECK(!sort_along_curve(f.nodes, lower, lower));
  for (kith_index i = 1; i < 1500; ++i) CHECK(f.nodes->id->i64[i - 1] < f.nodes->id->i64[i]);
  kith_nodes_destroy(&f.nodes);
}

/* Adds ghosts: images mirrored on the last axis, images of these shifted on axis 0, frozen ghosts, and an
 * image of one of them. */
static void add_image(struct fixture *f, int list, kith_index count, const kith_index *control,
                      const double *sign, const double *shift) {
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .boundary = 1, .list = list, .count = count};
  CHECK_OK(kith_resize(&block.control, 0, (size_t)count, sizeof *block.control));
  if (count > 0) memcpy(block.control, control, (size_t)count * sizeof *control);
  memcpy(block.image.sign, sign, sizeof block.image.sign);
  memcpy(block.image.shift, shift, sizeof block.image.shift);
  CHECK_OK(kith_nodes_add_ghosts(f->nodes, &block));
}

/* Signs and shifts of these images; both: that of mirrored ones that are shifted. */
static double mirror[NDIM], across[NDIM], one[NDIM], along[NDIM], both[NDIM];

static void set_image_maps(void) {
  for (int a = 0; a < NDIM; ++a) mirror[a] = one[a] = 1;
  mirror[NDIM - 1] = -1;
  across[NDIM - 1] = 64;
  along[0] = -32;
  for (int a = 0; a < NDIM; ++a) both[a] = across[a] + along[a];
}

static void add_chain(struct fixture *f) {
  add_image(f, 1, 4, (const kith_index[]){4, 6, 7, 9}, mirror, across);   /* ghosts 12 .. 15 */
  add_image(f, 1, 5, (const kith_index[]){4, 5, 13, 14, 15}, one, along); /* ghosts 16 .. 20 */
  add_image(f, 1, 0, NULL, one, along);                                   /* not stored */
  add_image(f, 2, 1, (const kith_index[]){11}, one, along);               /* ghost 21 */
  const struct kith_ghost_block frozen = {.kind = KITH_GHOST_FROZEN, .boundary = 2, .list = 0, .count = 3};
  CHECK_OK(kith_nodes_add_ghosts(f->nodes, &frozen)); /* ghosts 22 .. 24 */
  for (kith_index i = 22; i < 25; ++i) {
    CHECK(f->nodes->list->u8[i] == 0 && f->mass->f64[i] == 0);
    set_values(f, i, 500 + i);
  }
  add_image(f, 0, 1, (const kith_index[]){23}, one, along); /* ghost 25, of a frozen ghost */
}

static void check_chain(const struct fixture *f) {
  for (kith_index i = 12; i < 16; ++i)
    CHECK(has_image_values(f, i, mirror, across) && f->nodes->list->u8[i] == 1);
  for (kith_index i = 16; i < 18; ++i) CHECK(has_image_values(f, i, one, along));
  for (kith_index i = 18; i < 21; ++i)
    CHECK(has_image_values(f, i, mirror, both) && f->nodes->list->u8[i] == 1);
  CHECK(has_image_values(f, 21, one, along) && f->nodes->list->u8[21] == 2);
  for (kith_index i = 22; i < 25; ++i) CHECK(has_values(f, i));
  CHECK(has_image_values(f, 25, one, along));
  CHECK(f->nodes->id->i64[18] == f->nodes->id->i64[6] && f->nodes->id->i64[25] == 523);
}

/* A field of nodes only takes no memory for ghosts, and follows deletion and culling; once given to ghosts,
 * it is refreshed like others. */
static void check_own(void) {
  struct fixture f = make(1);
  struct kith_field *own;
  const struct kith_field_spec spec = {"own", KITH_SCALAR, KITH_F64, KITH_OWN_WORK, NULL, "o"};
  const struct kith_ghost_block frozen = {.kind = KITH_GHOST_FROZEN, .count = 1000};
  uint8_t keep[1000] = {0}, dead[8] = {[2] = 1};
  kith_index renumber[1008];
  void *work;
  append(&f, 0, 8, 10);
  CHECK_OK(kith_nodes_field(f.nodes, &spec, &own));
  for (kith_index i = 0; i < 8; ++i) own->f64[i] = 10 + i;
  const void *data = own->data;
  CHECK_OK(kith_nodes_add_ghosts(f.nodes, &frozen));
  CHECK(own->data == data && f.nodes->own_capacity == 8 && f.nodes->capacity >= 1008);
  keep[999] = 1;
  CHECK_OK(kith_nodes_cull_ghosts(f.nodes, keep, renumber));
  CHECK_OK(kith_nodes_delete(f.nodes, dead));
  append(&f, 0, 100, 30);
  for (kith_index i = 0; i < 7; ++i) CHECK(own->f64[i] == (double)f.nodes->id->i64[i]);
  CHECK(own->f64[7] == 0 && own->f64[106] == 0);
  CHECK_OK(kith_nodes_give_ghosts(f.nodes, own));
  struct kith_field *again = NULL;
  CHECK_OK(kith_nodes_field(f.nodes, &spec, &again));
  CHECK(again == own);
  kith_index *control = NULL;
  CHECK_OK(kith_resize(&control, 0, 1, sizeof *control));
  *control = 5;
  struct kith_ghost_block image = {.kind = KITH_GHOST_IMAGE, .count = 1, .control = control};
  for (int a = 0; a < NDIM; ++a) image.image.sign[a] = 1;
  CHECK_OK(kith_nodes_add_ghosts(f.nodes, &image));
  kith_nodes_refresh_images(f.nodes, &own, 1);
  CHECK(own->f64[107] == own->f64[5] && own->f64[5] == 16);
  const size_t bytes = kith_nodes_bytes(f.nodes);
  CHECK_OK(kith_nodes_work(f.nodes, 1 << 20, &work));
  memset(work, 1, 1 << 20);
  CHECK(kith_nodes_bytes(f.nodes) >= bytes + (1 << 20));
  kith_nodes_destroy(&f.nodes);
}

static struct fixture make_chain(void) {
  struct fixture f = make(3);
  append(&f, 0, 4, 10);
  append(&f, 1, 7, 30);
  append(&f, 2, 1, 50);
  add_chain(&f);
  return f;
}

static void check_ghosts(void) {
  struct fixture f = make_chain();
  CHECK(f.nodes->n_ghost == 14 && f.nodes->n_blocks == 5);
  check_layout(&f);
  check_chain(&f);
  for (kith_index i = 0; i < f.nodes->n_internal; ++i) set_values(&f, i, f.nodes->id->i64[i] + 7);
  kith_nodes_refresh_images(f.nodes, f.nodes->fields, f.nodes->n_fields);
  CHECK(f.nodes->id->i64[12] == 37);
  check_chain(&f); /* values follow the new ids; frozen ghosts keep theirs */
  f.mass->f64[4] = -1;
  f.flag->u8[4] = 255;
  kith_nodes_refresh_images(f.nodes, &f.mass, 1); /* only the fields that are named */
  CHECK(f.mass->f64[12] == -1 && f.flag->u8[12] == 37);
  const uint64_t generation = f.nodes->ghosts;
  kith_nodes_drop_ghosts(f.nodes);
  CHECK(f.nodes->n_ghost == 0 && f.nodes->n_blocks == 0 && f.nodes->ghosts == generation + 1);
  kith_nodes_drop_ghosts(f.nodes);
  CHECK(f.nodes->ghosts == generation + 1);
  const struct kith_ghost_block frozen = {.kind = KITH_GHOST_FROZEN, .list = 2, .count = 14};
  CHECK_OK(kith_nodes_add_ghosts(f.nodes, &frozen)); /* zero, though old ghosts have left values there */
  for (kith_index i = 12; i < 26; ++i)
    CHECK(f.mass->f64[i] == 0 && f.counter->i64[i] == 0 && f.nodes->list->u8[i] == 2);
  kith_nodes_destroy(&f.nodes);
}

/* A chain of blocks, each in the reverse order of the one before, so that a thread reads what another one has
 * written. */
static void check_long_chain(void) {
  enum { N = 2048, LINKS = 9 };
  static kith_index control[N];
  struct fixture f = make(1);
  const double zero[NDIM] = {0};
  append(&f, 0, N, 0);
  for (int link = 0; link < LINKS; ++link) {
    for (kith_index k = 0; k < N; ++k) control[k] = (link + 1) * N - 1 - k;
    add_image(&f, 0, N, control, one, zero);
  }
  int wrong = 0;
  for (int round = 1; round <= 100; ++round) {
    for (kith_index i = 0; i < N; ++i) f.mass->f64[i] = i + round * N;
    kith_nodes_refresh_images(f.nodes, &f.mass, 1);
    for (kith_index k = 0; k < N; ++k)
      wrong += f.mass->f64[LINKS * N + k] != N - 1 - k + round * N; /* LINKS is odd */
  }
  CHECK(wrong == 0);
  kith_nodes_destroy(&f.nodes);
}

static void check_bad_ghosts(void) {
  struct fixture f = make_chain();
  const kith_index bad[] = {-1, 26, 0}; /* out of range, not before the block, of another list */
  for (int t = 0; t < 3; ++t) {
    struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .list = 1, .count = 1};
    CHECK_OK(kith_resize(&block.control, 0, 1, sizeof *block.control));
    block.control[0] = bad[t];
    CHECK_STATUS(KITH_INTERNAL, kith_nodes_add_ghosts(f.nodes, &block));
  }
  struct kith_ghost_block block = {.kind = KITH_GHOST_IMAGE, .list = 3, .count = 1};
  CHECK_STATUS(KITH_INTERNAL, kith_nodes_add_ghosts(f.nodes, &block));
  CHECK(f.nodes->n_ghost == 14);
  append(&f, 0, 1, 99); /* appending drops ghosts */
  CHECK(f.nodes->n_ghost == 0);
  check_layout(&f);
  kith_nodes_destroy(&f.nodes);
}

static void check_cull(void) {
  struct fixture f = make_chain();
  uint8_t keep[14] = {0};
  kith_index renumber[26];
  keep[18 - 12] = keep[19 - 12] = 1; /* ghosts of 13 and 14 */
  keep[16 - 12] = 1;
  keep[25 - 12] = 1; /* its control is frozen ghost 23 */
  const uint64_t generation = f.nodes->ghosts;
  CHECK_OK(kith_nodes_cull_ghosts(f.nodes, keep, renumber));
  const kith_index wanted[14] = {-1, 12, 13, -1, 14, -1, 15, 16, -1, -1, -1, 17, -1, 18};
  for (kith_index i = 0; i < 12; ++i) CHECK(renumber[i] == i);
  for (kith_index g = 0; g < 14; ++g) CHECK(renumber[12 + g] == wanted[g] && keep[g] == (wanted[g] >= 0));
  CHECK(f.nodes->ghosts == generation + 1 && f.nodes->n_ghost == 7 && f.nodes->n_blocks == 4);
  check_layout(&f);
  const struct kith_ghost_block *b = f.nodes->blocks;
  CHECK(b[0].count == 2 && b[0].control[0] == 6 && b[0].control[1] == 7);
  CHECK(b[1].count == 3 && b[1].control[0] == 4 && b[1].control[1] == 12 && b[1].control[2] == 13);
  CHECK(b[2].kind == KITH_GHOST_FROZEN && b[2].count == 1 && f.nodes->id->i64[17] == 523 &&
        has_values(&f, 17));
  CHECK(b[3].control[0] == 17);
  for (int round = 0; round < 2; ++round) {
    CHECK(has_image_values(&f, 12, mirror, across) && has_image_values(&f, 13, mirror, across));
    CHECK(has_image_values(&f, 14, one, along) && has_image_values(&f, 15, mirror, both) &&
          has_image_values(&f, 16, mirror, both));
    CHECK(has_image_values(&f, 18, one, along));
    kith_nodes_refresh_images(f.nodes, f.nodes->fields, f.nodes->n_fields);
  }
  memset(keep, 1, sizeof keep);
  CHECK_OK(kith_nodes_cull_ghosts(f.nodes, keep, renumber));
  /* there is nothing to do */
  CHECK(f.nodes->ghosts == generation + 1 && f.nodes->n_ghost == 7 && renumber[18] == 18);
  memset(keep, 0, sizeof keep);
  CHECK_OK(kith_nodes_cull_ghosts(f.nodes, keep, renumber));
  CHECK(f.nodes->n_ghost == 0 && f.nodes->n_blocks == 0);
  kith_nodes_destroy(&f.nodes);
}

int main(void) {
  set_image_maps();
  check_registration();
  check_growth();
  check_own();
  check_delete();
  check_reorder();
  check_curve_order();
  check_ghosts();
  check_long_chain();
  check_bad_ghosts();
  check_cull();
  return check_failed();
}
