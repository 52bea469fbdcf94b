/* conformance_boundary.c - every boundary.
 *
 * Ghosts: the oracle lists all images by repeated reflection and shifting, farther than any search radius.
 * Every image that an internal node may interact with is there once, and no image breaks the rule of
 * boundary.h. Boxes are much larger than the supports, as large, and several times thinner; nodes are on
 * faces, edges and corners, outside of the box, or there is one; all combinations of boundaries are tested.
 * Enforcing: every node ends inside of the box, as one of its images. Bad settings are refused. */
#include "tests/check.h"
#include "boundaries/flow.h"
#include "lib/core/param.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NODES = 80, MOST_WORDS = 80, MOST_SIDES = 32 };

/* What an axis may have: side[0] is open, the others are members with faces on the sides where they can
 * be. */
struct side {
  const struct kith_boundary_ops *ops; /* NULL: open */
  bool at_lower, at_upper;
  void *settings;
  double velocity; /* of its face */
};
static struct side side[MOST_SIDES];
static int n_sides;

/* Default settings, and 0.3 for settings without a default. */
static void *settings_of(const struct kith_boundary_ops *ops) {
  char assignments[128] = "";
  void *settings = NULL;
  for (const struct kith_param *p = ops->params; p != NULL && p->key != NULL; ++p)
    if (p->fallback == NULL)
      snprintf(assignments + strlen(assignments), sizeof assignments - strlen(assignments), "%s%s=0.3",
               assignments[0] != '\0' ? " " : "", p->key);
  const struct kith_member member = {ops->name, ops->doc, ops->params, ops->settings_size};
  CHECK_OK(kith_settings_create(&settings, member, assignments));
  return settings;
}

static void add_side(const struct kith_boundary_ops *ops, bool at_lower, bool at_upper) {
  struct side *s = &side[n_sides++];
  *s = (struct side){ops, at_lower, at_upper, settings_of(ops), 0};
  s->velocity = kith_boundary_face_velocity(ops, s->settings);
}

static void list_sides(void) {
  n_sides = 1;
  for (const struct kith_boundary_ops *const *p = kith_boundary_all(); *p != NULL; ++p) {
    if (!(*p)->has_faces) continue;
    CHECK(n_sides + 3 <= MOST_SIDES);
    if (!(*p)->one_side && !kith_boundary_passes(*p)) add_side(*p, true, true);
    if (!(*p)->wraps) add_side(*p, true, false), add_side(*p, false, true);
  }
  CHECK(n_sides > 5);
}

/* An image along one axis, called a word: x -> sign x + shift. `beyond` is -1 or 1 for the face behind which
 * it is, 0 for the node itself. */
struct word {
  double sign, shift;
  int beyond;
};
struct words {
  int n;
  struct word word[MOST_WORDS];
};

static void add_word(struct words *words, double sign, double shift, int beyond) {
  if (words->n < MOST_WORDS) words->word[words->n] = (struct word){sign, shift, beyond};
  ++words->n;
}

/* Adds reflections at one face and the other in turn: r_1 x, r_2 r_1 x, ... An odd number of reflections that
 * starts at the upper face ends above; an even number ends below: x -> 2 u - x -> 2 l - 2 u + x. */
static void add_turns(struct words *words, double lower, double upper, bool start_upper, int turns) {
  double sign = 1, shift = 0;
  bool at_upper = start_upper;
  for (int k = 1; k <= turns; ++k, at_upper = !at_upper) {
    sign = -sign;
    shift = 2 * (at_upper ? upper : lower) - shift;
    add_word(words, sign, shift, (k % 2 == 1) == start_upper ? 1 : -1);
  }
}

static struct words list_words(const struct side *on, double lower, double upper, double search_radius) {
  struct words words = {0};
  const int range = (int)ceil(search_radius / (upper - lower)) + 4;
  add_word(&words, 1, 0, 0);
  for (int k = 1; on->ops != NULL && on->ops->wraps && k <= range; ++k) {
    add_word(&words, 1, k * (upper - lower), 1);
    add_word(&words, 1, -k * (upper - lower), -1);
  }
  /* inflow and outflow zones are empty here */
  if (on->ops != NULL && !on->ops->wraps && !kith_boundary_passes(on->ops)) {
    const int turns = on->at_lower && on->at_upper ? range : 1;
    if (on->at_lower) add_turns(&words, lower, upper, false, turns);
    if (on->at_upper) add_turns(&words, lower, upper, true, turns);
  }
  CHECK(words.n <= MOST_WORDS);
  return words;
}

struct box_scene {
  int side[NDIM]; /* an index of `side` */
  double lower[NDIM], upper[NDIM], factor;
  int n, n_lists;
  double x[MOST_NODES][NDIM], radius[MOST_NODES], v[MOST_NODES][NDIM];
  int list[MOST_NODES]; /* ascending */
  struct words words[NDIM];
};

static struct kith_nodes *make_nodes(const struct box_scene *s) {
  static const char *const names[] = {"a", "b", "c"};
  static const struct kith_field_spec velocity = {"velocity", KITH_VELOCITY, KITH_F64, KITH_STATE, NULL, ""};
  struct kith_nodes *nodes = NULL;
  struct kith_field *v = NULL;
  CHECK_OK(kith_nodes_create(&nodes, s->n_lists, names));
  CHECK_OK(kith_nodes_field(nodes, &velocity, &v));
  for (int i = 0; i < s->n; ++i) {
    kith_index k = -1;
    CHECK_OK(kith_nodes_append(nodes, s->list[i], 1, &k));
    CHECK(k == i);
    memcpy(nodes->position->f64 + k * NDIM, s->x[i], sizeof s->x[i]);
    memcpy(v->f64 + k * NDIM, s->v[i], sizeof s->v[i]);
    nodes->search_radius->f64[k] = s->radius[i];
    nodes->id->i64[k] = i;
  }
  return nodes;
}

static const double now = 0.25; /* the time at which faces are at lower and upper */

/* The order of axes must not matter. */
static struct kith_boundaries make_boundaries(const struct box_scene *s) {
  struct kith_boundaries all = {0};
  for (int a = NDIM - 1; a >= 0; --a) {
    const struct side *on = &side[s->side[a]];
    if (on->ops == NULL) continue;
    const double moved = on->velocity * now;
    CHECK_OK(kith_boundaries_add(&all, on->ops, a, s->lower[a] - (on->at_lower ? moved : 0),
                                 s->upper[a] - (on->at_upper ? moved : 0), on->at_lower, on->at_upper));
    all.boundary[all.n - 1]->settings = on->settings;
  }
  kith_boundaries_move(&all, now);
  return all;
}

/* The node that a ghost is an image of, and its word on each axis. */
struct origin {
  kith_index root;
  double sign[NDIM], shift[NDIM];
};

static void find_origins(const struct kith_nodes *nodes, struct origin *origin) {
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    origin[i].root = i;
    for (int a = 0; a < NDIM; ++a) origin[i].sign[a] = 1, origin[i].shift[a] = 0;
  }
  for (int b = 0; b < nodes->n_blocks; ++b) {
    const struct kith_ghost_block *block = &nodes->blocks[b];
    CHECK(block->count > 0);
    for (kith_index k = 0; k < block->count; ++k) {
      const kith_index c = block->control[k], g = block->first + k;
      CHECK(c < block->first && (k == 0 || block->control[k - 1] < c));
      CHECK(nodes->list->u8[c] == block->list && nodes->list->u8[g] == block->list &&
            nodes->id->i64[g] == nodes->id->i64[c]);
      origin[g].root = origin[c].root;
      for (int a = 0; a < NDIM; ++a) {
        origin[g].sign[a] = block->image.sign[a] * origin[c].sign[a];
        origin[g].shift[a] = block->image.sign[a] * origin[c].shift[a] + block->image.shift[a];
      }
    }
  }
}

/* Finds the word with this sign and shift. 1e-9: rounding of a few shifts of order 10 is far less, and other
 * words are 0.1 away. */
static int find_word(const struct words *words, double sign, double shift) {
  for (int w = 0; w < words->n; ++w)
    if (words->word[w].sign == sign && fabs(words->word[w].shift - shift) < 1e-9) return w;
  return -1;
}

/* Numbers all images: of each root, and of each combination of words along the axes. */
static size_t key_of(const struct box_scene *s, kith_index root, const int *w) {
  size_t key = (size_t)root;
  for (int a = 0; a < NDIM; ++a) key = key * (size_t)s->words[a].n + (size_t)w[a];
  return key;
}

static void count_ghosts(const struct box_scene *s, const struct kith_nodes *nodes, uint8_t *count) {
  const kith_index n = kith_nodes_count(nodes);
  const double *v = kith_nodes_field_named(nodes, "velocity")->f64;
  struct origin *origin = malloc(sizeof *origin * (size_t)n);
  find_origins(nodes, origin);
  int bad = 0;
  for (kith_index g = nodes->n_internal; g < n; ++g) {
    const struct origin *o = &origin[g];
    int w[NDIM];
    bool known = true;
    for (int a = 0; a < NDIM; ++a) {
      w[a] = find_word(&s->words[a], o->sign[a], o->shift[a]);
      known = known && w[a] >= 0;
      const double image = o->sign[a] * s->x[o->root][a] + o->shift[a];
      bad += !(fabs(nodes->position->f64[g * NDIM + a] - image) <= 1e-12); /* few roundings of 10 */
      bad += v[g * NDIM + a] !=
             o->sign[a] * s->v[o->root][a] + (o->sign[a] < 0 ? 2 * side[s->side[a]].velocity : 0);
    }
    bad += !known;
    if (known) ++count[key_of(s, o->root, w)];
  }
  CHECK(bad == 0);
  free(origin);
}

/* Does the rule of boundary.h create this image along axis a? 1: yes, 0: no, -1: too close to tell. */
static int by_rule(const struct box_scene *s, int a, const struct word *word, kith_index root) {
  if (word->beyond == 0) return 1;
  const double face = word->beyond > 0 ? s->upper[a] : s->lower[a];
  const double depth = word->beyond * (word->sign * s->x[root][a] + word->shift - face);
  double out = 0, wanted = -INFINITY;
  for (int i = 0; i < s->n; ++i) {
    const double inside = word->beyond * (face - s->x[i][a]);
    wanted = fmax(wanted, s->factor * s->radius[i] - inside);
    out = fmax(out, -inside);
  }
  const double limit = fmax(s->factor * s->radius[root] + out, wanted);
  return fabs(depth - limit) < 1e-9 ? -1 : depth < limit;
}

static bool is_significant(const struct box_scene *s, const double *x, double radius) {
  for (int i = 0; i < s->n; ++i) {
    const double r = s->factor * fmax(radius, s->radius[i]);
    if (kith_distance2(x, s->x[i]) <= r * r) return true;
  }
  return false;
}

static void check_counts(const struct box_scene *s, const uint8_t *count, size_t n_keys) {
  static int8_t made[MOST_NODES][NDIM][MOST_WORDS];
  for (kith_index root = 0; root < s->n; ++root)
    for (int a = 0; a < NDIM; ++a)
      for (int w = 0; w < s->words[a].n; ++w)
        made[root][a][w] = (int8_t)by_rule(s, a, &s->words[a].word[w], root);
  int missing = 0, wrong = 0;
  size_t key = 0;
  for (kith_index root = 0; root < s->n; ++root) {
    int w[NDIM] = {0};
    bool more = true;
    for (; more; ++key) {
      double x[NDIM];
      bool itself = true;
      int rule = 1;
      for (int a = 0; a < NDIM; ++a) {
        const struct word *word = &s->words[a].word[w[a]];
        x[a] = word->sign * s->x[root][a] + word->shift;
        itself = itself && w[a] == 0;
        const int here = made[root][a][w[a]];
        rule = rule == 0 || here == 0 ? 0 : rule < 0 || here < 0 ? -1 : 1;
      }
      if (itself) rule = 0;
      missing += !itself && count[key] != 1 && is_significant(s, x, s->radius[root]);
      wrong += rule >= 0 ? count[key] != rule : count[key] > 1;
      more = false; /* the next combination of words, last axis fastest */
      for (int a = NDIM - 1; a >= 0 && !more; --a) {
        w[a] = (w[a] + 1) % s->words[a].n;
        more = w[a] != 0;
      }
    }
  }
  CHECK(key == n_keys);
  if (missing + wrong > 0) {
    fprintf(stderr, "factor %g:", s->factor);
    for (int a = 0; a < NDIM; ++a)
      fprintf(stderr, " side %d in %g..%g", s->side[a], s->lower[a], s->upper[a]);
    fprintf(stderr, ": %d missing, %d against the rule\n", missing, wrong);
  }
  CHECK(missing == 0);
  CHECK(wrong == 0);
}

static void check_scene(struct box_scene *s) {
  double most = 0;
  for (int i = 0; i < s->n; ++i) most = fmax(most, s->radius[i]);
  size_t n_keys = (size_t)s->n;
  for (int a = 0; a < NDIM; ++a) {
    s->words[a] = list_words(&side[s->side[a]], s->lower[a], s->upper[a], s->factor * most);
    n_keys *= (size_t)s->words[a].n;
  }
  struct kith_nodes *nodes = make_nodes(s);
  struct kith_boundaries all = make_boundaries(s);
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, s->factor, NULL));
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, s->factor, NULL)); /* replaces the ghosts of the first call */
  uint8_t *count = calloc(n_keys, 1);
  count_ghosts(s, nodes, count);
  check_counts(s, count, n_keys);
  free(count);
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

/* Radii differ by up to 8 : 1. `out`: how far nodes may be outside of the box, in lengths. Every third node
 * is on a face, edge or corner. */
static void fill_random(struct box_scene *s, int n, double search_radius, double out, uint64_t *seed) {
  s->n = n;
  for (int i = 0; i < n; ++i) {
    s->radius[i] = i == 0   ? search_radius
                   : i == 1 ? search_radius / 8
                            : search_radius * (0.125 + 0.875 * check_random(seed));
    for (int a = 0; a < NDIM; ++a) {
      const double u = check_random(seed) * (1 + 2 * out) - out, pick = check_random(seed);
      s->x[i][a] = s->lower[a] + u * (s->upper[a] - s->lower[a]);
      if (i % 3 == 0 && pick < 0.6) s->x[i][a] = pick < 0.3 ? s->lower[a] : s->upper[a];
    }
  }
}

/* 3 nodes along each axis: on the lower face, in the middle and on the upper face. */
static void fill_lattice(struct box_scene *s, double search_radius) {
  s->n = NDIM == 1 ? 3 : NDIM == 2 ? 9 : 27;
  for (int i = 0; i < s->n; ++i) {
    s->radius[i] = i % 5 == 0 ? search_radius : search_radius / 8;
    for (int a = 0, k = i; a < NDIM; ++a, k /= 3)
      s->x[i][a] = s->lower[a] + (s->upper[a] - s->lower[a]) * (k % 3) / 2;
  }
}

static void finish(struct box_scene *s, uint64_t *seed) {
  s->n_lists = 3;
  for (int i = 0; i < s->n; ++i) {
    s->list[i] = 2 * (i > s->n / 2); /* list 1 is empty */
    for (int a = 0; a < NDIM; ++a) s->v[i][a] = check_random(seed) - 0.5;
  }
}

/* In 3-D a fifth of the combinations with a one-sided member suffices. */
static bool is_skipped(const struct box_scene *s, int c) {
  bool one_side = false;
  for (int a = 0; a < NDIM; ++a) one_side = one_side || (s->side[a] > 0 && side[s->side[a]].ops->one_side);
  return NDIM == 3 && one_side && c % 5 != 0;
}

static void check_combinations(void) {
  const double length[] = {20, 1.1, 0.3}; /* supports are up to 1 */
  uint64_t seed = 1;
  int combinations = 1;
  for (int a = 0; a < NDIM; ++a) combinations *= n_sides;
  for (int c = 0; c < combinations; ++c)
    for (int l = 0; l < 3; ++l)
      for (int kind = 0; kind < 4; ++kind) {
        if (NDIM == 3 && l == 2 && (c + kind) % 3 != 0) continue; /* of the most expensive ones a third */
        struct box_scene s = {.factor = 1};
        for (int a = 0, k = c; a < NDIM; ++a, k /= n_sides) {
          s.side[a] = k % n_sides;
          s.lower[a] = a == 0 ? -0.7 : a == 1 ? 0 : 0.1;
          s.upper[a] = s.lower[a] + length[l] * (1 + 0.1 * a);
        }
        if (is_skipped(&s, c)) continue;
        if (kind == 0) fill_random(&s, 8, 1, 0, &seed);
        if (kind == 1) fill_random(&s, 8, 1, l == 0 ? 0.01 : 0.4, &seed);
        /* whole spacings on axis 0: exact ties */
        if (kind == 2) fill_lattice(&s, l == 0 ? 10 : l == 1 ? 0.55 : 0.6);
        if (kind == 3) fill_random(&s, 1, 1, 0, &seed);
        finish(&s, &seed);
        check_scene(&s);
        s.factor = 2;
        if (NDIM < 3 || l < 2 || c % 7 == 0) check_scene(&s);
      }
}

/* Boxes that are thin along one axis and wide along the others. */
static void check_mixed_lengths(void) {
  uint64_t seed = 2;
  for (int thin = 0; thin < NDIM; ++thin)
    for (int k = 0; k < n_sides * n_sides; ++k) {
      struct box_scene s = {.factor = 1};
      for (int a = 0; a < NDIM; ++a) {
        s.side[a] = a == thin ? k / n_sides : k % n_sides;
        s.lower[a] = 0, s.upper[a] = a == thin ? 0.1 : 3;
      }
      fill_random(&s, 12, 1, 0, &seed);
      finish(&s, &seed);
      check_scene(&s);
    }
}

/* All nodes are far below or above the box, so that the first image is not the one that matters. */
static void check_far_out(void) {
  uint64_t seed = 3;
  for (int k = 1; k < n_sides; ++k)
    for (int above = 0; above < 2; ++above) {
      struct box_scene s = {.factor = 1};
      for (int a = 0; a < NDIM; ++a) s.side[a] = k, s.lower[a] = -1, s.upper[a] = 1;
      fill_random(&s, 8, 0.3, 0, &seed);
      for (int i = 0; i < s.n; ++i) s.x[i][0] = above ? 2.7 + 0.1 * s.x[i][0] : -2.7 + 0.1 * s.x[i][0];
      finish(&s, &seed);
      check_scene(&s);
    }
}

/* ---- enforcing ---- */

static kith_status enforce(struct kith_boundaries *all, struct kith_nodes *nodes) {
  KITH_TRY(kith_boundaries_mirror(all, nodes));
  return kith_boundaries_wrap(all, nodes);
}

/* Nodes up to three lengths outside of the box, along the last axis: each ends inside, as the image that is
 * there; nodes that were inside stay. */
static void check_enforce(const struct side *on, uint64_t *seed) {
  enum { N = 40, A = NDIM - 1 };
  struct box_scene s = {.n = N, .n_lists = 1};
  struct kith_boundaries all = {0};
  const double lower = -0.3, upper = 0.9;
  fill_random(&s, 0, 1, 0, seed);
  s.n = N;
  for (int i = 0; i < N; ++i)
    for (int a = 0; a < NDIM; ++a) {
      s.x[i][a] = lower + (upper - lower) * (i % 4 == 0 ? check_random(seed) : 7 * check_random(seed) - 3);
      s.v[i][a] = check_random(seed) - 0.5;
    }
  struct kith_nodes *nodes = make_nodes(&s);
  struct kith_field *v = kith_nodes_field_named(nodes, "velocity");
  CHECK_OK(kith_boundaries_add(&all, on->ops, A, lower, upper, on->at_lower, on->at_upper));
  struct kith_boundary *boundary = all.boundary[0];
  boundary->settings = on->settings;
  const uint64_t generation = nodes->positions;
  CHECK_OK(enforce(&all, nodes));
  CHECK(nodes->positions == generation + 1);
  const struct words words = list_words(on, lower, upper, 3 * (upper - lower));
  for (int i = 0; i < N; ++i) {
    const double x = s.x[i][A], y = nodes->position->f64[i * NDIM + A];
    const bool was_inside = (x >= lower || !on->at_lower) && (x <= upper || !on->at_upper);
    int found = -1;
    for (int w = 0; w < words.n && found < 0; ++w)
      if (fabs(words.word[w].sign * x + words.word[w].shift - y) < 1e-13) found = w;
    CHECK(found >= 0 && (y >= lower || !on->at_lower) && (y <= upper || !on->at_upper));
    if (found < 0) continue;
    const double sign = words.word[found].sign;
    if (was_inside) CHECK(y == x && sign == 1);
    CHECK(v->f64[i * NDIM + A] == sign * s.v[i][A] + (sign < 0 ? 2 * on->velocity : 0));
    for (int a = 0; a < A; ++a)
      CHECK(nodes->position->f64[i * NDIM + a] == s.x[i][a] && v->f64[i * NDIM + a] == s.v[i][a]);
  }
  CHECK_OK(enforce(&all, nodes));
  CHECK(nodes->positions == generation + 1); /* nothing was left to do */
  nodes->position->f64[5 * NDIM + A] = NAN;
  nodes->position->f64[7 * NDIM + A] = on->at_lower ? lower - 0.1 : upper + 0.1;
  CHECK_STATUS(KITH_DIVERGED, enforce(&all, nodes));
  CHECK(strstr(kith_failure(), "node 5") != NULL);
  nodes->position->f64[5 * NDIM + A] = 0;
  const uint64_t before = nodes->positions;
  CHECK_OK(enforce(&all, nodes));
  CHECK(nodes->positions == before); /* the other nodes have been put back */
  if (on->at_lower && on->at_upper) {
    boundary->lower = boundary->upper; /* faces that have met */
    CHECK_STATUS(KITH_DIVERGED, enforce(&all, nodes));
    CHECK(strstr(kith_failure(), "no room") != NULL);
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

/* ---- what all members have in common ---- */

static void check_refused(const struct kith_boundary_ops *ops, int axis, double lower, double upper,
                          bool at_lower, bool at_upper) {
  struct kith_boundaries all = {0};
  CHECK_STATUS(ops->has_faces ? KITH_BAD_INPUT : KITH_OK,
               kith_boundaries_add(&all, ops, axis, lower, upper, at_lower, at_upper));
  CHECK(all.n == !ops->has_faces);
  kith_boundaries_clear(&all);
}

static void check_member(const struct kith_boundary_ops *ops) {
  static const char *const names[] = {"only"};
  struct kith_boundaries all = {0};
  struct kith_nodes *empty = NULL;
  const bool both = !ops->one_side && !kith_boundary_passes(ops);
  void *settings = settings_of(ops);
  CHECK(ops->doc != NULL && kith_boundary_find(ops->name) == ops);
  CHECK(!(ops->wraps && ops->one_side) && (ops->has_faces || !(ops->wraps || ops->one_side)));
  CHECK((ops->enforce != NULL) == (ops->has_faces && !kith_boundary_passes(ops)));
  CHECK(!kith_boundary_passes(ops) || ops->settings_size >= sizeof(struct kith_flow_settings));
  check_refused(ops, NDIM, 0, 1, true, both);
  check_refused(ops, -1, 0, 1, true, both);
  check_refused(ops, 0, 1, 1, true, both);
  check_refused(ops, 0, 1, 0, true, both);
  check_refused(ops, 0, NAN, 1, true, both);
  check_refused(ops, 0, 0, INFINITY, true, both);
  check_refused(ops, 0, 0, 1, false, false);
  if (ops->wraps) check_refused(ops, 0, 0, 1, true, false);
  if (ops->one_side) check_refused(ops, 0, 0, 1, true, true);
  /* A box without nodes; then a second boundary on the same axis. */
  CHECK_OK(kith_nodes_create(&empty, 1, names));
  CHECK_OK(kith_boundaries_add(&all, ops, 0, 0, 1, true, both));
  all.boundary[0]->settings = settings;
  CHECK_OK(kith_boundaries_ghosts(&all, empty, 1, NULL));
  CHECK_OK(enforce(&all, empty));
  CHECK(empty->n_ghost == 0 && empty->n_blocks == 0);
  CHECK_STATUS(ops->has_faces ? KITH_BAD_INPUT : KITH_OK,
               kith_boundaries_add(&all, ops, 0, 0, 1, true, both));
  kith_boundaries_clear(&all);
  CHECK(all.n == 0);
  kith_nodes_destroy(&empty);
  kith_free(&settings);
}

static void check_members(void) {
  struct kith_boundaries all = {0};
  kith_status status = KITH_OK;
  const struct kith_boundary_ops *many = NULL;
  CHECK(kith_boundary_find("perodic") == NULL);
  for (const struct kith_boundary_ops *const *p = kith_boundary_all(); *p != NULL; ++p) {
    check_member(*p);
    if (!(*p)->has_faces) many = *p;
  }
  for (int k = 0; k < 99 && status == KITH_OK; ++k)
    status = kith_boundaries_add(&all, many, 0, 0, 0, false, false);
  CHECK(status == KITH_BAD_INPUT && all.n == 2 * NDIM + 8);
  kith_boundaries_clear(&all);
}

int main(void) {
  uint64_t seed = 12;
  omp_set_num_threads(1); /* for so few nodes */
  list_sides();
  check_members();
  for (int k = 1; k < n_sides; ++k)
    if (side[k].ops->enforce != NULL) check_enforce(&side[k], &seed);
  check_combinations();
  check_mixed_lengths();
  check_far_out();
  for (int k = 0; k < n_sides; ++k) kith_free(&side[k].settings);
  return check_failed();
}
