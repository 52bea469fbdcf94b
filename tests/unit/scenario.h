/* scenario.h - for tests: creates a simulation from a few lines of YAML, runs some steps, and compares it
 * with another simulation node by node, matched by id. */
#ifndef KITH_TEST_SCENARIO_H
#define KITH_TEST_SCENARIO_H

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "app/simulation/simulation.h"
#include "tests/check.h"

/* What most scenes begin with: the unit box, and its periodic sides. */
#define SCENARIO_UNIT "scene: scenario\ndimension: 3\ndomain: {lower: [0, 0, 0], upper: [1, 1, 1]}\n"
#define SCENARIO_PERIODIC SCENARIO_UNIT "boundaries: {x: periodic, y: periodic, z: periodic}\n"

/* Owns both. `simulation` is NULL if it could not be created; a failed check then says why. */
struct scenario {
  struct kith_scene *scene;
  struct kith_simulation *simulation;
  struct kith_totals start;
};

enum { SCENARIO_SETTINGS = 16 };

/* Opens a scene with settings "key=value", separated by blanks and formatted as printf does. If a key is set
 * twice, the last value counts. */
static inline bool scenario_open(struct scenario *s, const char *yaml, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Splits `settings`. */
static inline kith_status scenario_create(struct scenario *s, struct kith_ranks *ranks, const char *yaml,
                                          char *settings) {
  const char *overrides[SCENARIO_SETTINGS];
  char dimension[] = "dimension=0", *rest = NULL;
  int n = 0;
  *s = (struct scenario){0};
  dimension[10] = (char)('0' + NDIM);
  overrides[n++] = dimension;
  for (char *word = strtok_r(settings, " ", &rest); word != NULL && n < SCENARIO_SETTINGS;
       word = strtok_r(NULL, " ", &rest))
    overrides[n++] = word;
  KITH_TRY(kith_scene_parse(&s->scene, "scenario.yaml", yaml, strlen(yaml), n, overrides));
  return kith_simulation_create(&s->simulation, s->scene, ranks, NULL, true);
}

static inline bool scenario_make(struct scenario *s, struct kith_ranks *ranks, const char *yaml,
                                 char *settings) {
  CHECK_OK(scenario_create(s, ranks, yaml, settings));
  return s->simulation != NULL;
}

static inline bool scenario_open(struct scenario *s, const char *yaml, const char *format, ...) {
  char settings[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(settings, sizeof settings, format, arguments);
  va_end(arguments);
  return scenario_make(s, NULL, yaml, settings);
}

static inline void scenario_close(struct scenario *s) {
  kith_simulation_destroy(&s->simulation);
  kith_scene_destroy(&s->scene);
}

/* Returns the status of creating a simulation with these settings. */
static inline kith_status scenario_status(const char *yaml, const char *settings) {
  struct scenario s;
  char words[256];
  snprintf(words, sizeof words, "%s", settings);
  const kith_status status = scenario_create(&s, NULL, yaml, words);
  scenario_close(&s);
  return status;
}

/* Checks that a simulation with these settings is refused, with these words in the message. */
static inline void scenario_refused(const char *yaml, const char *settings, const char *message) {
  CHECK_STATUS(KITH_BAD_INPUT, scenario_status(yaml, settings));
  CHECK(check_says(message));
}

/* Computes the first rates and stores the totals that conservation errors refer to. */
static inline kith_status scenario_start(struct scenario *s) {
  const kith_status status = kith_simulation_start(s->simulation);
  s->start = kith_hydro_totals(&s->simulation->hydro);
  return status;
}

/* Makes up to `steps` more steps, until the end of the scene at most. Every eighth step checks the neighbor
 * lists, which takes longer than the step. */
static inline kith_status scenario_steps(struct scenario *s, int steps) {
  struct kith_integrator *it = &s->simulation->integrator;
  for (int k = 0; k < steps && it->time < s->scene->until; ++k) {
    it->check = k % 8 == 0;
    KITH_TRY(kith_simulation_step(s->simulation, s->scene->until));
  }
  return KITH_OK;
}

/* Starts and makes the steps; returns false after a failed check. */
static inline bool scenario_run(struct scenario *s, int steps) {
  if (s->simulation == NULL) return false;
  const int before = check_failures;
  CHECK_OK(scenario_start(s));
  if (check_failures == before) CHECK_OK(scenario_steps(s, steps));
  return check_failures == before;
}

/* Finds a field by name; NULL fails a check. */
static inline struct kith_field *scenario_field(const struct scenario *s, const char *name) {
  struct kith_field *field = kith_nodes_field_named(s->simulation->nodes, name);
  CHECK(field != NULL);
  return field;
}

/* Returns index[id] for ids 0 .. largest id, -1 for ids that no node has. The caller frees it. */
static inline kith_index *scenario_indices(const struct scenario *s, int64_t *most) {
  const struct kith_nodes *nodes = s->simulation->nodes;
  *most = -1;
  for (kith_index i = 0; i < nodes->n_internal; ++i) *most = KITH_MAX(*most, nodes->id->i64[i]);
  kith_index *place = malloc((size_t)(*most + 2) * sizeof *place);
  for (int64_t id = 0; id <= *most; ++id) place[id] = -1;
  for (kith_index i = 0; i < nodes->n_internal; ++i) place[nodes->id->i64[i]] = i;
  return place;
}

/* Returns the name of the first STATE field that is not bitwise identical in nodes of equal id, "id" if the
 * nodes differ, or NULL. Ignores fields that only one of the two simulations has. */
static inline const char *scenario_difference(const struct scenario *a, const struct scenario *b) {
  const struct kith_nodes *m = a->simulation->nodes, *n = b->simulation->nodes;
  const char *different = NULL;
  int64_t most, other;
  kith_index *of_a = scenario_indices(a, &most), *of_b = scenario_indices(b, &other);
  if (most != other || m->n_internal != n->n_internal) different = "id";
  for (int f = 0; f < m->n_fields && different == NULL; ++f) {
    const struct kith_field *x = m->fields[f], *y = kith_nodes_field_named(n, x->spec.name);
    const size_t size = kith_field_node_size(x);
    if (!kith_field_lasts(m, x) || y == NULL) continue;
    for (int64_t id = 0; id <= most && different == NULL; ++id) {
      if ((of_a[id] < 0) != (of_b[id] < 0))
        different = "id";
      else if (of_a[id] >= 0 && memcmp((const char *)x->data + (size_t)of_a[id] * size,
                                       (const char *)y->data + (size_t)of_b[id] * size, size) != 0)
        different = x->spec.name;
    }
  }
  free(of_a);
  free(of_b);
  return different;
}

/* Largest |a - b| of a field over nodes of the same id, divided by the largest |a| (or by 1 if that is 0). */
static inline double scenario_distance(const struct scenario *a, const struct scenario *b, const char *name) {
  const struct kith_field *x = scenario_field(a, name), *y = scenario_field(b, name);
  int64_t most, other;
  kith_index *of_a = scenario_indices(a, &most), *of_b = scenario_indices(b, &other);
  double largest = 0, distance = most == other ? 0 : INFINITY;
  for (int64_t id = 0; id <= most && most == other; ++id)
    for (int c = 0; c < x->components && of_a[id] >= 0; ++c) {
      const double p = x->f64[of_a[id] * x->components + c], q = y->f64[of_b[id] * x->components + c];
      largest = fmax(largest, fabs(p));
      if (!(fabs(p - q) <= distance)) distance = fabs(p - q); /* also true for NaN */
    }
  free(of_a);
  free(of_b);
  return distance / (largest > 0 ? largest : 1);
}

/* Fails, naming the field that differs, unless the simulations are bitwise identical. */
static inline void scenario_identical(const struct scenario *a, const struct scenario *b, const char *what) {
  const char *different = scenario_difference(a, b);
  const bool same_clock = a->simulation->integrator.time == b->simulation->integrator.time &&
                          a->simulation->integrator.dt == b->simulation->integrator.dt &&
                          a->simulation->integrator.step == b->simulation->integrator.step;
  if (different == NULL && same_clock) return;
  ++check_failures;
  fprintf(stderr, "%d-D, %s: %s differs\n", NDIM, what, different != NULL ? different : "the clock");
}

/* The conservation errors |E - E0| / E0, and |p - p0| / sum m max(|v|, c), where p excludes what went through
 * boundaries. */
static inline double scenario_energy_error(const struct scenario *s) {
  const struct kith_totals now = kith_hydro_totals(&s->simulation->hydro);
  const double change = kith_totals_energy(&now) - kith_totals_energy(&s->start);
  return fabs(change) / (s->start.kinetic + s->start.internal);
}
static inline double scenario_momentum_error(const struct scenario *s) {
  const struct kith_totals now = kith_hydro_totals(&s->simulation->hydro);
  double largest = 0;
  for (int a = 0; a < NDIM; ++a)
    largest = fmax(largest, fabs(now.momentum[a] - now.through.momentum[a] - s->start.momentum[a]));
  return largest / fmax(now.momentum_scale, s->start.momentum_scale);
}

#endif
