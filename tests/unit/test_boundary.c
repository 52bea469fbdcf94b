/* Ghosts against all images, listed by repeated reflection and shifting in a range that is larger than any
 * reach: every image that is significant for an internal node is there once, and none is there but by the
 * rule of boundary.h.
 *
 * Boxes much larger than the supports, as large, several times thinner; every combination of boundaries of
 * the axes. */
#include "tests/check.h"
#include "boundaries/boundary.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>

enum side { OPEN, PERIODIC, BOTH, LOWER, UPPER, SIDES };
enum { MOST_NODES = 80, MOST_WORDS = 80 };

/* One image along one axis: x -> sign x + shift; `beyond` is -1 or 1 for the face it lies behind, 0 for the
 * node itself. */
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

/* Reflections in turn at one face, then the other: r_1 x, r_2 r_1 x, ... Those starting at the upper face
 * with an odd number of reflections lie above; with an even number, starting above ends below: x -> 2 u - x
 * -> 2 l - 2 u + x. */
static void add_turns(struct words *words, double lower, double upper, bool start_upper, int turns) {
  double sign = 1, shift = 0;
  bool at_upper = start_upper;
  for (int k = 1; k <= turns; ++k, at_upper = !at_upper) {
    sign = -sign;
    shift = 2 * (at_upper ? upper : lower) - shift;
    add_word(words, sign, shift, (k % 2 == 1) == start_upper ? 1 : -1);
  }
}

static struct words list_words(enum side side, double lower, double upper, double reach) {
  struct words words = {0};
  const int range = (int)ceil(reach / (upper - lower)) + 4;
  add_word(&words, 1, 0, 0);
  if (side == PERIODIC)
    for (int k = 1; k <= range; ++k) {
      add_word(&words, 1, k * (upper - lower), 1);
      add_word(&words, 1, -k * (upper - lower), -1);
    }
  if (side == BOTH)
    add_turns(&words, lower, upper, false, range), add_turns(&words, lower, upper, true, range);
  if (side == LOWER) add_word(&words, -1, 2 * lower, -1);
  if (side == UPPER) add_word(&words, -1, 2 * upper, 1);
  CHECK(words.n <= MOST_WORDS);
  return words;
}

struct scene {
  enum side side[NDIM];
  double lower[NDIM], upper[NDIM], factor;
  int n, n_lists;
  double x[MOST_NODES][NDIM], radius[MOST_NODES], v[MOST_NODES][NDIM];
  int list[MOST_NODES]; /* ascending */
  struct words words[NDIM];
};

static struct kith_nodes *make_nodes(const struct scene *s) {
  static const char *const names[] = {"a", "b", "c"};
  static const struct kith_field_spec velocity = {"velocity", KITH_VECTOR, KITH_F64, KITH_STATE, NULL, ""};
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
    nodes->reach->f64[k] = s->radius[i];
    nodes->id->i64[k] = i;
  }
  return nodes;
}

static struct kith_boundaries make_boundaries(const struct scene *s) {
  struct kith_boundaries all = {0};
  for (int a = NDIM - 1; a >= 0; --a) { /* the order of the axes does not matter */
    const enum side side = s->side[a];
    if (side == OPEN) continue;
    const char *name = side == PERIODIC ? "periodic" : "reflecting";
    CHECK_OK(kith_boundaries_add(&all, kith_boundary_find(name), a, s->lower[a], s->upper[a], side != UPPER,
                                 side != LOWER));
  }
  return all;
}

/* What a ghost is: its root, and its way there as one word per axis. */
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

/* The word with this sign and shift. 1e-9: rounding of a few shifts of order 10 is far less, other words are
 * 0.1 away. */
static int find_word(const struct words *words, double sign, double shift) {
  for (int w = 0; w < words->n; ++w)
    if (words->word[w].sign == sign && fabs(words->word[w].shift - shift) < 1e-9) return w;
  return -1;
}

/* Number of a root and its words. */
static size_t key_of(const struct scene *s, kith_index root, const int *w) {
  size_t key = (size_t)root;
  for (int a = 0; a < NDIM; ++a) key = key * (size_t)s->words[a].n + (size_t)w[a];
  return key;
}

static void count_ghosts(const struct scene *s, const struct kith_nodes *nodes, uint8_t *count) {
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
      const double place = o->sign[a] * s->x[o->root][a] + o->shift[a];
      bad += !(fabs(nodes->position->f64[g * NDIM + a] - place) <=
               1e-12); /* coordinates of order 10, few roundings */
      bad += v[g * NDIM + a] != o->sign[a] * s->v[o->root][a];
    }
    bad += !known;
    if (known) ++count[key_of(s, o->root, w)];
  }
  CHECK(bad == 0);
  free(origin);
}

/* Does the rule of boundary.h make this image on axis a? 1, 0, or -1: too close to tell. */
static int by_rule(const struct scene *s, int a, const struct word *word, kith_index root) {
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

static bool is_significant(const struct scene *s, const double *x, double radius) {
  for (int i = 0; i < s->n; ++i) {
    const double r = s->factor * fmax(radius, s->radius[i]);
    if (kith_distance2(x, s->x[i]) <= r * r) return true;
  }
  return false;
}

static void check_counts(const struct scene *s, const uint8_t *count, size_t n_keys) {
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

static void check_scene(struct scene *s) {
  double most = 0;
  for (int i = 0; i < s->n; ++i) most = fmax(most, s->radius[i]);
  size_t n_keys = (size_t)s->n;
  for (int a = 0; a < NDIM; ++a) {
    s->words[a] = list_words(s->side[a], s->lower[a], s->upper[a], s->factor * most);
    n_keys *= (size_t)s->words[a].n;
  }
  struct kith_nodes *nodes = make_nodes(s);
  struct kith_boundaries all = make_boundaries(s);
  for (int round = 0; round < 2; ++round) { /* the second drops the ghosts of the first */
    CHECK_OK(kith_boundaries_ghosts(&all, nodes, s->factor, NULL));
    uint8_t *count = calloc(n_keys, 1);
    count_ghosts(s, nodes, count);
    if (round == 1) check_counts(s, count, n_keys);
    free(count);
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

/* Radii 8 : 1. `out`: how far nodes may stick out of the box, in lengths. Every third node is on a face, edge
 * or corner. */
static void fill_random(struct scene *s, int n, double reach, double out, uint64_t *seed) {
  s->n = n;
  for (int i = 0; i < n; ++i) {
    s->radius[i] = i == 0 ? reach : i == 1 ? reach / 8 : reach * (0.125 + 0.875 * check_random(seed));
    for (int a = 0; a < NDIM; ++a) {
      const double u = check_random(seed) * (1 + 2 * out) - out, pick = check_random(seed);
      s->x[i][a] = s->lower[a] + u * (s->upper[a] - s->lower[a]);
      if (i % 3 == 0 && pick < 0.6) s->x[i][a] = pick < 0.3 ? s->lower[a] : s->upper[a];
    }
  }
}

/* 3 nodes an axis: lower face, the middle, upper face. */
static void fill_lattice(struct scene *s, double reach) {
  s->n = NDIM == 1 ? 3 : NDIM == 2 ? 9 : 27;
  for (int i = 0; i < s->n; ++i) {
    s->radius[i] = i % 5 == 0 ? reach : reach / 8;
    for (int a = 0, k = i; a < NDIM; ++a, k /= 3)
      s->x[i][a] = s->lower[a] + (s->upper[a] - s->lower[a]) * (k % 3) / 2;
  }
}

static void finish(struct scene *s, uint64_t *seed) {
  s->n_lists = 3;
  for (int i = 0; i < s->n; ++i) {
    s->list[i] = 2 * (i > s->n / 2); /* list 1 is empty */
    for (int a = 0; a < NDIM; ++a) s->v[i][a] = check_random(seed) - 0.5;
  }
}

static void check_combinations(void) {
  const double length[] = {20, 1.1, 0.3}; /* for supports up to 1 */
  uint64_t seed = 1;
  int combinations = 1;
  for (int a = 0; a < NDIM; ++a) combinations *= SIDES;
  for (int c = 0; c < combinations; ++c)
    for (int l = 0; l < 3; ++l)
      for (int kind = 0; kind < 3; ++kind) {
        if (NDIM == 3 && l == 2 && (c + kind) % 3 != 0) continue; /* the dearest ones: a third of them */
        struct scene s = {.factor = 1};
        for (int a = 0, k = c; a < NDIM; ++a, k /= SIDES) {
          s.side[a] = (enum side)(k % SIDES);
          s.lower[a] = a == 0 ? -0.7 : a == 1 ? 0 : 0.1;
          s.upper[a] = s.lower[a] + length[l] * (1 + 0.1 * a);
        }
        if (kind == 0) fill_random(&s, 8, 1, 0, &seed);
        if (kind == 1) fill_random(&s, 8, 1, l == 0 ? 0.01 : 0.4, &seed);
        if (kind == 2)
          fill_lattice(&s, l == 0 ? 10 : l == 1 ? 0.55 : 0.6); /* whole spacings on axis 0: exact ties */
        finish(&s, &seed);
        check_scene(&s);
        s.factor = 2;
        if (NDIM < 3 || l < 2 || c % 7 == 0) check_scene(&s);
      }
}

/* One sheet of mixed boxes: thin on one axis, wide on the others. */
static void check_mixed_lengths(void) {
  uint64_t seed = 2;
  for (int thin = 0; thin < NDIM; ++thin)
    for (int side = 0; side < SIDES; ++side) {
      struct scene s = {.factor = 1};
      for (int a = 0; a < NDIM; ++a) {
        s.side[a] = a == thin ? PERIODIC : (enum side)side;
        s.lower[a] = 0, s.upper[a] = a == thin ? 0.1 : 3;
      }
      fill_random(&s, 12, 1, 0, &seed);
      finish(&s, &seed);
      check_scene(&s);
    }
}

/* All nodes far below the box, or far above it: the image that matters is not the first one. */
static void check_far_out(void) {
  uint64_t seed = 3;
  for (int side = PERIODIC; side < SIDES; ++side)
    for (int above = 0; above < 2; ++above) {
      struct scene s = {.factor = 1};
      for (int a = 0; a < NDIM; ++a) s.side[a] = (enum side)side, s.lower[a] = -1, s.upper[a] = 1;
      fill_random(&s, 8, 0.3, 0, &seed);
      for (int i = 0; i < s.n; ++i) s.x[i][0] = above ? 2.7 + 0.1 * s.x[i][0] : -2.7 + 0.1 * s.x[i][0];
      finish(&s, &seed);
      check_scene(&s);
    }
}

/* sum of (1 - (r/R)^2)^3 over all nodes and ghosts within R of x. */
static double density(const struct kith_nodes *nodes, const double *x, double radius, int *within) {
  double sum = 0;
  *within = 0;
  for (kith_index j = 0; j < kith_nodes_count(nodes); ++j) {
    const double q = kith_distance2(x, nodes->position->f64 + j * NDIM) / (radius * radius);
    if (q > 1) continue;
    sum += (1 - q) * (1 - q) * (1 - q);
    ++*within;
  }
  return sum;
}

/* The same by counting lattice vectors. */
static double lattice_density(double radius, double spacing, int *within) {
  const int range = (int)(radius / spacing) + 1, side = 2 * range + 1;
  double sum = 0;
  *within = 0;
  for (int k = 0; k < (NDIM == 1 ? side : NDIM == 2 ? side * side : side * side * side); ++k) {
    int square = 0;
    for (int a = 0, rest = k; a < NDIM; ++a, rest /= side)
      square += (rest % side - range) * (rest % side - range);
    const double q = square * spacing * spacing / (radius * radius);
    if (q > 1) continue;
    sum += (1 - q) * (1 - q) * (1 - q);
    ++*within;
  }
  return sum;
}

/* A periodic lattice of `cells` nodes an axis: all nodes see the same, as if space were filled. cells = 1 is
 * one node, thinner in every direction than its own support. */
static void check_lattice_density(int cells, double reach) {
  static const char *const names[] = {"only"};
  const double spacing = 1.0 / cells;
  struct kith_nodes *nodes = NULL;
  struct kith_boundaries all = {0};
  CHECK_OK(kith_nodes_create(&nodes, 1, names));
  const kith_index n = NDIM == 1 ? cells : NDIM == 2 ? cells * cells : cells * cells * cells;
  CHECK_OK(kith_nodes_append(nodes, 0, n, NULL));
  for (kith_index i = 0; i < n; ++i) {
    nodes->reach->f64[i] = reach * spacing;
    for (int a = 0, k = i; a < NDIM; ++a, k /= cells)
      nodes->position->f64[i * NDIM + a] = (k % cells) * spacing;
  }
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(&all, &kith_boundary_periodic, a, 0, 1, true, true));
  CHECK_OK(kith_boundaries_ghosts(&all, nodes, 1, NULL));
  int wanted, within;
  const double rho = lattice_density(reach * spacing, spacing, &wanted);
  for (kith_index i = 0; i < n; ++i) {
    CHECK_CLOSE(density(nodes, nodes->position->f64 + i * NDIM, reach * spacing, &within) / rho, 1,
                1e-12); /* round-off of sums */
    CHECK(within == wanted);
  }
  kith_boundaries_clear(&all);
  kith_nodes_destroy(&nodes);
}

/* Values follow moved controls through the chain; ghosts of many chunks are the same with any number of
 * threads. */
static struct kith_nodes *crowd(int threads, struct kith_boundaries *all) {
  static const char *const names[] = {"a", "b", "c"};
  struct kith_nodes *nodes = NULL;
  uint64_t seed = 77;
  omp_set_num_threads(threads);
  CHECK_OK(kith_nodes_create(&nodes, 3, names));
  for (int l = 0; l < 3; ++l) CHECK_OK(kith_nodes_append(nodes, l, 9001, NULL));
  for (kith_index i = 0; i < nodes->n_internal; ++i) {
    nodes->id->i64[i] = i;
    nodes->reach->f64[i] = 0.02 + 0.05 * check_random(&seed);
    for (int a = 0; a < NDIM; ++a) nodes->position->f64[i * NDIM + a] = check_random(&seed);
  }
  for (int a = 0; a < NDIM; ++a)
    CHECK_OK(kith_boundaries_add(all, a == 0 ? &kith_boundary_reflecting : &kith_boundary_periodic, a, 0, 1,
                                 true, true));
  CHECK_OK(kith_boundaries_ghosts(all, nodes, 1, NULL));
  for (kith_index i = 0; i < nodes->n_internal * NDIM; ++i)
    nodes->position->f64[i] += 0.01 * (check_random(&seed) - 0.5);
  kith_nodes_refresh_ghosts(nodes, &nodes->position, 1);
  return nodes;
}

static void check_threads(void) {
  struct kith_boundaries all[2] = {0};
  struct kith_nodes *one = crowd(1, &all[0]), *two = crowd(2, &all[1]);
  const size_t n = (size_t)kith_nodes_count(one);
  CHECK(one->n_ghost > 2000 && one->n_ghost == two->n_ghost && one->n_blocks == two->n_blocks);
  CHECK(memcmp(one->position->f64, two->position->f64, n * NDIM * sizeof(double)) == 0);
  CHECK(memcmp(one->id->i64, two->id->i64, n * sizeof(int64_t)) == 0);
  struct origin *origin = malloc(sizeof *origin * n);
  find_origins(one, origin);
  double worst = 0;
  for (size_t i = 0; i < n; ++i)
    for (int a = 0; a < NDIM; ++a) {
      const double x = one->position->f64[(size_t)origin[i].root * NDIM + a];
      worst =
          fmax(worst, fabs(origin[i].sign[a] * x + origin[i].shift[a] - one->position->f64[i * NDIM + a]));
    }
  CHECK(worst <= 1e-15); /* one rounding of a number below 2 */
  free(origin);
  for (int k = 0; k < 2; ++k) kith_boundaries_clear(&all[k]);
  kith_nodes_destroy(&one);
  kith_nodes_destroy(&two);
}

int main(void) {
  omp_set_num_threads(1); /* small scenes */
  check_combinations();
  check_mixed_lengths();
  check_far_out();
  check_lattice_density(1, 2.5);
  check_lattice_density(1, 0.5);
  check_lattice_density(2, 3.3);
  check_lattice_density(5, 2.43);
  check_lattice_density(7, 1.9);
  check_threads();
  return check_failed();
}
