/* test_boundary_enforce.c - wrapping and reflecting at the limits of rounding (oracle: the exact position),
 * nodes that are lost, frozen nodes of boundary constant, and stages of the profile. */
#include "tests/check.h"
#include "boundaries/boundary.h"
#include <omp.h>
#include <string.h>

static const char *const names[] = {"a", "b"};

static struct kith_nodes *some_nodes(kith_index n0, kith_index n1) {
  struct kith_nodes *nodes = NULL;
  CHECK_OK(kith_nodes_create(&nodes, 2, names));
  CHECK_OK(kith_nodes_append(nodes, 0, n0, NULL));
  CHECK_OK(kith_nodes_append(nodes, 1, n1, NULL));
  for (kith_index i = 0; i < n0 + n1; ++i) nodes->id->i64[i] = 100 + i;
  return nodes;
}

static struct kith_field *add_field(struct kith_nodes *nodes, const char *name, enum kith_kind kind,
                                    enum kith_role role) {
  const struct kith_field_spec spec = {name, kind, KITH_F64, role, NULL, ""};
  struct kith_field *field = NULL;
  CHECK_OK(kith_nodes_field(nodes, &spec, &field));
  return field;
}

static struct kith_boundaries one_boundary(const char *name, int axis, double lower, double upper,
                                           bool at_lower, bool at_upper) {
  struct kith_boundaries all = {0};
  CHECK_OK(kith_boundaries_add(&all, kith_boundary_find(name), axis, lower, upper, at_lower, at_upper));
  return all;
}

static double wrap_one(double x, double lower, double upper, kith_status wanted) {
  struct kith_nodes *nodes = some_nodes(1, 0);
  struct kith_boundaries all = one_boundary("periodic", NDIM - 1, lower, upper, true, true);
  nodes->position->f64[NDIM - 1] = x;
  const bool inside = x >= lower && x < upper;
  /* wrapping breaks neighbor lists, so it waits */
  CHECK_OK(kith_boundaries_mirror(&all, nodes));
  const uint64_t generation = nodes->positions;
  CHECK_STATUS(wanted, kith_boundaries_wrap(&all, nodes));
  const double y = nodes->position->f64[NDIM - 1];
  if (wanted == KITH_OK) {
    CHECK(nodes->positions == generation + !inside);
    CHECK(y >= lower && y < upper);
    const double lengths = (y - x) / (upper - lower);
    CHECK_CLOSE(lengths, round(lengths), 1e-12); /* at most 1000 lengths, rounded to 1e-13 */
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
  return y;
}

static void check_wrap(void) {
  CHECK(wrap_one(1, 0, 1, KITH_OK) == 0);
  CHECK(wrap_one(0, 0, 1, KITH_OK) == 0);
  CHECK(wrap_one(-1e-20, 0, 1, KITH_OK) < 1); /* the sum with 1 is rounded to 1 */
  CHECK(wrap_one(nextafter(1, 0), 0, 1, KITH_OK) == nextafter(1, 0));
  CHECK(wrap_one(1.25, 0, 1, KITH_OK) == 0.25);
  CHECK(wrap_one(-3.75, 0, 1, KITH_OK) == 0.25);
  CHECK(wrap_one(7, -1, 1, KITH_OK) == -1);
  uint64_t seed = 4;
  for (int k = 0; k < 3000; ++k) {
    const double lower = check_random(&seed) - 0.5, upper = lower + 0.1 + check_random(&seed);
    const double whole = floor(check_random(&seed) * 9) - 4, part = k % 2 == 0 ? 0 : check_random(&seed);
    const double x = lower + (whole + part) * (upper - lower); /* half of them are on faces, up to rounding */
    wrap_one(k % 3 == 0 ? nextafter(x, -9) : x, lower, upper, KITH_OK);
  }
  wrap_one(-999, 0, 1, KITH_OK);
  wrap_one(-1500, 0, 1, KITH_DIVERGED);
  CHECK(strstr(kith_failure(), "node 100") != NULL);
  wrap_one(INFINITY, 0, 1, KITH_DIVERGED);
  CHECK(isnan(wrap_one(NAN, 0, 1, KITH_DIVERGED)));
}

struct mirrored {
  double x, v[NDIM];
};

/* Reflects one node with velocity 1, 2, 3 and a tensor along the last axis. */
static struct mirrored mirror_one(double x, double lower, double upper, bool at_lower, bool at_upper,
                                  kith_status wanted) {
  const int axis = NDIM - 1;
  struct kith_nodes *nodes = some_nodes(1, 1);
  struct kith_field *v = add_field(nodes, "velocity", KITH_VECTOR, KITH_STATE);
  struct kith_field *a = add_field(nodes, "velocity_base", KITH_VECTOR, KITH_WORK);
  struct kith_field *start = add_field(nodes, "position_base", KITH_POSITION, KITH_WORK);
  struct kith_field *t = add_field(nodes, "stress", KITH_TENSOR, KITH_STATE);
  struct kith_boundaries all = one_boundary("reflecting", axis, lower, upper, at_lower, at_upper);
  for (int c = 0; c < NDIM; ++c) v->f64[c] = a->f64[c] = c + 1;
  for (int c = 0; c < NDIM * NDIM; ++c) t->f64[c] = c + 1;
  nodes->position->f64[axis] = x;
  start->f64[axis] = (lower + upper) / 2;
  nodes->position->f64[NDIM + axis] = (lower + upper) / 2;
  /* reflecting keeps neighbor lists, so it may happen at any time */
  CHECK_STATUS(wanted, kith_boundaries_mirror(&all, nodes));
  struct mirrored out = {.x = nodes->position->f64[axis]};
  memcpy(out.v, v->f64, sizeof out.v);
  const double sign = v->f64[axis] / NDIM;
  CHECK(sign == 1 || sign == -1);
  for (int c = 0; c < NDIM; ++c)
    CHECK(a->f64[c] == v->f64[c] && v->f64[c] == (c == axis ? sign : 1) * (c + 1));
  if (wanted == KITH_OK) /* a reflected node keeps its path; round-off of a few shifts of up to 1000 */
    CHECK_CLOSE(out.x - start->f64[axis], sign * (x - (lower + upper) / 2), 1e-12 * (1 + fabs(x)));
  for (int r = 0; r < NDIM; ++r)
    for (int c = 0; c < NDIM; ++c)
      CHECK(t->f64[r * NDIM + c] == ((r == axis) != (c == axis) ? sign : 1) * (r * NDIM + c + 1));
  CHECK(nodes->position->f64[NDIM + axis] == (lower + upper) / 2);
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
  return out;
}

static void check_mirror(void) {
  uint64_t seed = 6;
  for (int k = 0; k < 2000; ++k) {
    const double lower = check_random(&seed) - 0.5, length = 0.1 + check_random(&seed),
                 s = 8 * check_random(&seed) - 4;
    const struct mirrored m = mirror_one(lower + s * length, lower, lower + length, true, true, KITH_OK);
    const double t = fmod(fabs(s), 2);                        /* a triangle wave of period 2 L */
    CHECK_CLOSE(m.x, lower + length * fmin(t, 2 - t), 1e-14); /* four reflections of numbers of order 5 */
    CHECK(m.v[NDIM - 1] == (fmod(floor(s) + 4, 2) == 1 ? -NDIM : NDIM));
  }
  CHECK(mirror_one(0, 0, 1, true, true, KITH_OK).v[NDIM - 1] == NDIM); /* nodes on faces stay */
  CHECK(mirror_one(1, 0, 1, true, true, KITH_OK).v[NDIM - 1] == NDIM);
  CHECK(mirror_one(-0.25, 0, 1, true, false, KITH_OK).x == 0.25);
  CHECK(mirror_one(1.25, 0, 1, true, false, KITH_OK).x == 1.25); /* an open side */
  CHECK(mirror_one(-0.25, 0, 1, false, true, KITH_OK).x == -0.25);
  CHECK(mirror_one(1.25, 0, 1, false, true, KITH_OK).x == 0.75);
  CHECK(mirror_one(-1.25, 0, 1, true, false, KITH_OK).x == 1.25);
  /* tolerance: a thousand roundings of 1e-13 */
  CHECK_CLOSE(mirror_one(-999.25, 0, 1, true, true, KITH_OK).x, 0.75, 1e-9);
  mirror_one(-1001, 0, 1, true, true, KITH_DIVERGED);
  mirror_one(NAN, 0, 1, true, true, KITH_DIVERGED);
  mirror_one(NAN, 0, 1, true, false, KITH_DIVERGED);
  mirror_one(INFINITY, 0, 1, true, true, KITH_DIVERGED);
}

/* Search radii above a thousand boxes, and positions that are not finite, are errors, instead of endless
 * ghosts. */
static void check_diverged(void) {
  for (int side = 0; side < 2; ++side) {
    struct kith_nodes *nodes = some_nodes(2, 0);
    struct kith_boundaries all = one_boundary(side == 0 ? "periodic" : "reflecting", 0, 0, 1, true, true);
    nodes->search_radius->f64[0] = 1002;
    CHECK_STATUS(KITH_DIVERGED, kith_boundaries_ghosts(&all, nodes, 1, NULL));
    nodes->search_radius->f64[0] = NAN;
    CHECK_STATUS(KITH_DIVERGED, kith_boundaries_ghosts(&all, nodes, 1, NULL));
    nodes->search_radius->f64[0] = 1;
    nodes->position->f64[NDIM] = NAN;
    CHECK_STATUS(KITH_DIVERGED, kith_boundaries_ghosts(&all, nodes, 1, NULL));
    nodes->position->f64[NDIM] = -5000;
    CHECK_STATUS(KITH_DIVERGED, kith_boundaries_ghosts(&all, nodes, 1, NULL));
    CHECK(nodes->n_ghost == 0);
    nodes->position->f64[NDIM] = 0.5;
    CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, NULL));
    kith_boundaries_clear(&all);
    kith_nodes_destroy(&nodes);
  }
}

/* Every second node of both lists is frozen. They become ghosts list by list, and a periodic boundary makes
 * images of them. */
static struct kith_nodes *freeze_some(struct kith_boundaries *all) {
  struct kith_nodes *nodes = some_nodes(6, 4);
  struct kith_field *v = add_field(nodes, "velocity", KITH_VECTOR, KITH_STATE);
  CHECK_OK(kith_boundaries_add(all, &kith_boundary_constant, 0, 0, 0, false, false));
  CHECK_OK(kith_boundaries_add(all, &kith_boundary_periodic, 0, 0, 10, true, true));
  uint8_t chosen[10];
  for (kith_index i = 0; i < 10; ++i) {
    chosen[i] = i % 2 == 1;
    nodes->position->f64[i * NDIM] = i;
    nodes->support->f64[i] = nodes->search_radius->f64[i] = 1.5;
    v->f64[i * NDIM] = -i;
  }
  CHECK_OK(kith_boundaries_ghosts(all, nodes, 1, NULL)); /* there are no frozen nodes yet */
  CHECK(all->boundary[0]->held == NULL);
  CHECK_STATUS(KITH_INTERNAL, kith_constant_take(all->boundary[1], nodes, chosen));
  nodes->id->i64[3] = -1;
  CHECK_STATUS(KITH_INTERNAL, kith_constant_take(all->boundary[0], nodes, chosen));
  nodes->id->i64[3] = 103;
  CHECK(nodes->n_internal == 10);
  CHECK_OK(kith_constant_take(all->boundary[0], nodes, chosen));
  CHECK_STATUS(KITH_INTERNAL, kith_constant_take(all->boundary[0], nodes, chosen));
  return nodes;
}

static void check_frozen(struct kith_boundaries *all, struct kith_nodes *nodes) {
  CHECK(nodes->n_internal == 5 && nodes->lists[0].count == 3 && nodes->lists[1].count == 2);
  const struct kith_field *v = kith_nodes_field_named(nodes, "velocity");
  for (kith_index i = 0; i < 5; ++i) nodes->search_radius->f64[i] = 3; /* twice the supports */
  CHECK_OK(kith_boundaries_ghosts(all, nodes, 1, NULL));
  CHECK(nodes->n_blocks > 3 && nodes->blocks[0].kind == KITH_GHOST_FROZEN &&
        nodes->blocks[1].kind == KITH_GHOST_FROZEN);
  CHECK(nodes->blocks[0].count == 3 && nodes->blocks[0].list == 0 && nodes->blocks[1].count == 2 &&
        nodes->blocks[1].list == 1);
  for (kith_index g = 0; g < 5; ++g) {
    const kith_index i = 5 + g, was = 2 * g + 1;
    CHECK(nodes->id->i64[i] == 100 + was && nodes->position->f64[i * NDIM] == was &&
          v->f64[i * NDIM] == -was);
    CHECK(nodes->list->u8[i] == (was > 5) && nodes->support->f64[i] == 1.5 &&
          nodes->search_radius->f64[i] == 3);
  }
  bool image_of_held = false; /* 9 - 10 = -1 */
  for (kith_index i = 10; i < kith_nodes_count(nodes); ++i)
    image_of_held = image_of_held || (nodes->id->i64[i] == 109 && nodes->position->f64[i * NDIM] == -1);
  CHECK(image_of_held);
  kith_nodes_refresh_images(nodes, nodes->fields, nodes->n_fields);
  CHECK(nodes->position->f64[5 * NDIM] == 1);
}

static void check_constant(void) {
  struct kith_boundaries all = {0};
  struct kith_nodes *nodes = freeze_some(&all);
  check_frozen(&all, nodes);
  check_frozen(&all, nodes);
  const struct kith_field *late = add_field(nodes, "late", KITH_SCALAR, KITH_WORK);
  for (kith_index i = 0; i < nodes->n_internal; ++i) late->f64[i] = 7;
  check_frozen(&all, nodes);
  CHECK(late->f64[4] == 7 && late->f64[5] == 0);
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

static void check_profile(void) {
  struct kith_profile *profile = NULL;
  struct kith_nodes *nodes = some_nodes(4, 0);
  struct kith_boundaries all = {0};
  for (kith_index i = 0; i < 4; ++i) nodes->search_radius->f64[i] = 0.5;
  CHECK_OK(kith_profile_create(&profile, 1, false));
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(&all, &kith_boundary_periodic, a, 0, 1, true, true));
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, profile));
  const struct kith_counter *counters;
  const struct kith_stage *stages;
  CHECK(kith_profile_stages(profile, &stages) == 1 && strcmp(stages[0].path, "periodic") == 0 &&
        stages[0].calls == NDIM);
  CHECK(kith_profile_counters(profile, &counters) == 1 && strcmp(counters[0].name, "ghosts") == 0);
  CHECK(counters[0].total == nodes->n_ghost && nodes->n_ghost > 0);
  CHECK(nodes->blocks[nodes->n_blocks - 1].boundary == NDIM - 1);
  kith_profile_destroy(&profile);
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

int main(void) {
  omp_set_num_threads(1); /* for so few nodes */
  check_wrap();
  check_mirror();
  check_diverged();
  check_constant();
  check_profile();
  return check_failed();
}
