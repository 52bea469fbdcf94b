#include "app/suite.h"

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/keys.h"
#include "app/scene.h"
#include "app/words.h"
#include "physics/package.h"

/* What is read through the table; the rest is read by hand. */
struct head {
  char scene[256], others[256], suite[100];
  int dimension;
};
#define IN(member) KITH_INTO(struct head, member)
static const struct kith_key suite_keys[] = {
    {"suite", KITH_KEY_NAME, "", "", "its name; none: the name of the file", IN(suite)},
    {"scene", KITH_KEY_NAME, NULL, "", "a scene of inputs, or a path", IN(scene)},
    {"dimension", KITH_KEY_INTEGER, "0", "[0, 3]", "0: the scene's", IN(dimension)},
    {"settings", KITH_KEY_OTHER, "", "", "for every run", KITH_BELOW(NULL, MAP)},
    {"methods", KITH_KEY_OTHER, "", "", "names for settings", KITH_BELOW(NULL, LIST)},
    {"matrix", KITH_KEY_OTHER, NULL, "", "lists of values, by key", KITH_BELOW(NULL, MAP)},
    {"norms", KITH_KEY_OTHER, "", "", "what is charted", KITH_BELOW(NULL, LIST)},
    {"targets", KITH_KEY_OTHER, "", "", "errors to ask the price of", KITH_BELOW(NULL, LIST)},
    {"others", KITH_KEY_NAME, "", "", "points of other codes", IN(others)},
    {0}};
struct method_head {
  char name[KITH_METHOD_TEXT];
};
static const struct kith_key method_keys[] = {
    {"name", KITH_KEY_NAME, NULL, "", "what it is called", KITH_INTO(struct method_head, name)},
    {"settings", KITH_KEY_OTHER, "", "", "what it sets", KITH_BELOW(NULL, MAP)},
    {0}};

/* --- settings --- */

struct text {
  char *to;
  size_t room;
  bool full;
};

__attribute__((format(printf, 2, 3))) static void put(struct text *t, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int n = vsnprintf(t->to, t->room, format, arguments);
  va_end(arguments);
  if (n < 0 || (size_t)n >= t->room) t->full = true;
  const size_t used = t->full ? t->room - 1 : (size_t)n;
  t->to += used, t->room -= used;
}

/* A value on one line, as YAML has it. */
static void put_value(struct text *t, const struct kith_config_node *node) {
  if (node->kind == KITH_CONFIG_SCALAR) {
    if (!node->quoted) {
      put(t, "%s", node->null ? "null" : node->text);
      return;
    }
    put(t, "'");
    for (const char *c = node->text; *c != '\0'; ++c) put(t, *c == '\'' ? "''" : "%c", *c);
    put(t, "'");
    return;
  }
  const bool map = node->kind == KITH_CONFIG_MAP;
  put(t, map ? "{" : "[");
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (child != node->first) put(t, ", ");
    if (map) put(t, "%s: ", child->key);
    put_value(t, child);
  }
  put(t, map ? "}" : "]");
}

static bool by_dimension(const struct kith_config_node *node) {
  return node->kind == KITH_CONFIG_MAP && node->first != NULL &&
         kith_words_find("1d|2d|3d", node->first->key) >= 0;
}

/* Adds `node` as the value of `key`, or, if it is a map, each of its entries as key.entry. */
static kith_status set_all(struct kith_job *job, const char *key, const struct kith_config_node *node) {
  char text[KITH_JOB_SETTING];
  if (node->kind != KITH_CONFIG_MAP || by_dimension(node)) {
    struct text t = {text, sizeof text, false};
    put_value(&t, node);
    if (t.full) return kith_config_fail(node, NULL, "a value of more than %d letters", KITH_JOB_SETTING);
    return kith_job_set(job, key, text);
  }
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    snprintf(text, sizeof text, "%s%s%s", key, key[0] != '\0' ? "." : "", child->key);
    KITH_TRY(set_all(job, text, child));
  }
  return KITH_OK;
}

/* --- jobs --- */

static const struct kith_config_node *entry(const struct kith_config_node *list, int index) {
  const struct kith_config_node *child = list->first;
  while (index-- > 0) child = child->next;
  return child;
}

int kith_suite_position(const struct kith_suite *s, int64_t m, int axis) {
  for (int a = s->n_axes - 1; a > axis; --a) m /= s->axis[a].list->n;
  return (int)(m % s->axis[axis].list->n);
}

/* "sph", "sph quintic", "sph limited neighbors 50": only what differs between methods. */
static void add_label(char label[KITH_METHOD_TEXT], const struct kith_axis *axis,
                      const struct kith_config_node *value) {
  char text[KITH_METHOD_TEXT];
  const size_t used = strlen(label);
  const char *blank = used > 0 ? " " : "";
  struct text t = {text, sizeof text, false};
  if (axis->key == NULL) {
    snprintf(label + used, KITH_METHOD_TEXT - used, "%s%s", blank, kith_config_child(value, "name")->text);
    return;
  }
  put_value(&t, value);
  const char *dot = strrchr(axis->key, '.'), *key = dot != NULL ? dot + 1 : axis->key;
  const bool word = value->kind == KITH_CONFIG_SCALAR && strspn(text, "0123456789+-.eE") != strlen(text) &&
                    kith_words_find("true|false|yes|no|none", text) < 0;
  snprintf(label + used, KITH_METHOD_TEXT - used, word ? "%s%.0s%s" : "%s%s %s", blank, key, text);
}

kith_status kith_suite_job(const struct kith_suite *s, int64_t m, double resolution, struct kith_job *job) {
  char text[32];
  *job = (struct kith_job){.scene = s->scene, .dimension = s->dimension, .x = resolution};
  const struct kith_config_node *settings = kith_config_at(s->config, "settings");
  if (settings != NULL) KITH_TRY(set_all(job, "", settings));
  for (int k = 0; k < s->n_overrides; ++k) {
    if (strncmp(s->overrides[k], "dimension=", strlen("dimension=")) == 0) continue;
    char key[KITH_JOB_SETTING];
    const char *equals = strchr(s->overrides[k], '=');
    snprintf(key, sizeof key, "%.*s", (int)(equals - s->overrides[k]), s->overrides[k]);
    KITH_TRY(kith_job_set(job, key, equals + 1));
  }
  for (int a = 0; a < s->n_axes; ++a) {
    const struct kith_axis *axis = &s->axis[a];
    const struct kith_config_node *value = entry(axis->list, kith_suite_position(s, m, a));
    const struct kith_config_node *sets = axis->key == NULL ? kith_config_child(value, "settings") : value;
    if (sets != NULL) KITH_TRY(set_all(job, axis->key == NULL ? "" : axis->key, sets));
    if (axis->list->n > 1 || (axis->key == NULL && s->n_methods == 1)) add_label(job->method, axis, value);
  }
  if (job->method[0] == '\0') snprintf(job->method, sizeof job->method, "%.90s", s->scene_name);
  snprintf(text, sizeof text, "%.9g", resolution);
  return kith_job_set(job, "resolution", text);
}

/* --- files --- */

static void folder_of(const char *path, char folder[KITH_PATH]) {
  const char *slash = strrchr(path, '/');
  snprintf(folder, KITH_PATH, "%.*s", slash != NULL ? (int)(slash - path) : 1, slash != NULL ? path : ".");
}

static void stem_of(const char *path, char stem[100]) {
  const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path, *dot = strrchr(name, '.');
  snprintf(stem, 100, "%.*s", dot != NULL && dot != name ? (int)(dot - name) : (int)strlen(name), name);
}

/* "|noh|sedov|sod": the names of the YAML files of a folder, in order of the alphabet. */
static void names_in(const char *folder, char *words, size_t size) {
  struct dirent **entries;
  const int n = scandir(folder, &entries, NULL, alphasort);
  words[0] = '\0';
  for (int k = 0; k < n; ++k) {
    char *dot = strrchr(entries[k]->d_name, '.');
    if (dot != NULL && dot != entries[k]->d_name && strcmp(dot, ".yaml") == 0) {
      *dot = '\0';
      const size_t used = strlen(words);
      snprintf(words + used, size - used, "|%s", entries[k]->d_name);
    }
    free(entries[k]);
  }
  if (n >= 0) free(entries);
}

static bool is_path(const char *name) {
  const char *dot = strrchr(name, '.');
  return strchr(name, '/') != NULL || (dot != NULL && strcmp(dot, ".yaml") == 0);
}

static kith_status find_scene(struct kith_suite *s, const struct kith_programs *programs, const char *name) {
  const struct kith_config_node *node = kith_config_at(s->config, "scene");
  char words[2048], folder[KITH_PATH];
  if (!is_path(name)) {
    names_in(programs->inputs, words, sizeof words);
    if (kith_words_find(words, name) < 0) return kith_config_fail_word(node, words);
    snprintf(s->scene, sizeof s->scene, "%.600s/%.100s.yaml", programs->inputs, name);
    return KITH_OK;
  }
  folder_of(s->config->file, folder);
  snprintf(s->scene, sizeof s->scene, "%.500s%s%.250s", name[0] == '/' ? "" : folder,
           name[0] == '/' ? "" : "/", name);
  if (access(s->scene, R_OK) == 0) return KITH_OK;
  snprintf(s->scene, sizeof s->scene, "%.700s", name);
  if (access(s->scene, R_OK) == 0) return KITH_OK;
  return kith_config_fail(node, NULL, "'%.200s' cannot be read", name);
}

static kith_status find_others(struct kith_suite *s, const char *name) {
  char folder[KITH_PATH];
  if (name[0] == '\0') return KITH_OK;
  folder_of(s->config->file, folder);
  snprintf(s->others, sizeof s->others, "%.500s%s%.250s", name[0] == '/' ? "" : folder,
           name[0] == '/' ? "" : "/", name);
  if (access(s->others, R_OK) != 0) snprintf(s->others, sizeof s->others, "%.700s", name);
  if (access(s->others, R_OK) == 0) return KITH_OK;
  return kith_config_fail(kith_config_at(s->config, "others"), NULL, "'%.200s' cannot be read", name);
}

/* --- reading --- */

static kith_status read_methods(struct kith_suite *s) {
  const struct kith_config_node *list = kith_config_at(s->config, "methods");
  if (list == NULL) return KITH_OK;
  KITH_TRY(kith_config_want_list(list));
  if (list->n == 0) return kith_config_fail(list, NULL, "a list without methods: nothing to run");
  for (const struct kith_config_node *m = list->first; m != NULL; m = m->next) {
    struct method_head head;
    KITH_TRY(kith_keys_read(method_keys, m, &head));
    const struct kith_config_node *settings = kith_config_child(m, "settings");
    if (settings != NULL) KITH_TRY(kith_config_want_map(settings));
    for (const struct kith_config_node *b = list->first; b != m; b = b->next)
      if (strcmp(kith_config_child(b, "name")->text, head.name) == 0)
        return kith_config_fail(m, "name", "'%.60s' is the name of another method", head.name);
  }
  s->axis[s->n_axes++] = (struct kith_axis){list, NULL};
  return KITH_OK;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static kith_status read_resolutions(struct kith_suite *s, const struct kith_config_node *list) {
  static const struct kith_key number = {"", KITH_KEY_NUMBER, NULL, "(0, inf)", "",
                                         0,  sizeof(double),  NULL, 0};
  if (list->n > KITH_SUITE_RESOLUTIONS)
    return kith_config_fail(list, NULL, "more than %d resolutions", KITH_SUITE_RESOLUTIONS);
  for (const struct kith_config_node *r = list->first; r != NULL; r = r->next)
    KITH_TRY(kith_key_value(&number, r, &s->resolution[s->n_resolutions++]));
  qsort(s->resolution, (size_t)s->n_resolutions, sizeof *s->resolution, ascending);
  for (int k = 1; k < s->n_resolutions; ++k)
    if (s->resolution[k] == s->resolution[k - 1])
      return kith_config_fail(list, NULL, "%.9g is there twice", s->resolution[k]);
  return KITH_OK;
}

static kith_status read_matrix(struct kith_suite *s) {
  const struct kith_config_node *matrix = kith_config_at(s->config, "matrix");
  KITH_TRY(kith_config_want_map(matrix));
  for (const struct kith_config_node *list = matrix->first; list != NULL; list = list->next) {
    KITH_TRY(kith_config_want_list(list));
    if (list->n == 0) return kith_config_fail(list, NULL, "an empty list: a matrix of no runs");
    if (strcmp(list->key, "resolution") == 0) {
      KITH_TRY(read_resolutions(s, list));
      continue;
    }
    if (s->n_axes == KITH_SUITE_AXES)
      return kith_config_fail(list, NULL, "more than %d axes", KITH_SUITE_AXES);
    s->axis[s->n_axes++] = (struct kith_axis){list, list->key};
  }
  return s->n_resolutions > 0 ? KITH_OK
                              : kith_config_fail(matrix, "resolution", "missing: a list of resolutions");
}

static kith_status read_norms(struct kith_suite *s) {
  const struct kith_config_node *norms = kith_config_at(s->config, "norms"),
                                *targets = kith_config_at(s->config, "targets");
  static const struct kith_key number = {"", KITH_KEY_NUMBER, NULL, "(0, inf)", "",
                                         0,  sizeof(double),  NULL, 0};
  if (norms == NULL) s->n_norms = 1, s->norm[0] = kith_metric_find("density.l1");
  if (norms != NULL) KITH_TRY(kith_config_want_list(norms));
  if (norms != NULL && (norms->n == 0 || norms->n > KITH_SUITE_NORMS))
    return kith_config_fail(norms, NULL, "%d norms; 1 to %d can be charted", norms->n, KITH_SUITE_NORMS);
  for (const struct kith_config_node *n = norms != NULL ? norms->first : NULL; n != NULL; n = n->next) {
    const int metric = n->kind == KITH_CONFIG_SCALAR ? kith_metric_find(n->text) : -1;
    if (n->kind != KITH_CONFIG_SCALAR) return kith_config_fail(n, NULL, "a norm is a word, as density.l1");
    if (metric < 0) return kith_config_fail_word(n, kith_metric_words);
    s->norm[s->n_norms++] = metric;
  }
  if (targets == NULL) return KITH_OK;
  KITH_TRY(kith_config_want_list(targets));
  if (targets->n != s->n_norms)
    return kith_config_fail(targets, NULL, "%d targets for %d norms", targets->n, s->n_norms);
  for (const struct kith_config_node *t = targets->first; t != NULL; t = t->next)
    KITH_TRY(kith_key_value(&number, t, &s->target[t->index]));
  return KITH_OK;
}

/* More than a million are a slip. */
static kith_status count_methods(struct kith_suite *s) {
  s->n_methods = 1;
  for (int a = 0; a < s->n_axes; ++a) {
    s->n_methods *= s->axis[a].list->n;
    if (s->n_methods * s->n_resolutions > 1000000)
      return kith_config_fail(kith_config_at(s->config, "matrix"), NULL, "more than a million runs");
  }
  return KITH_OK;
}

static kith_status read_suite(struct kith_suite *s, const struct kith_programs *programs) {
  struct head head = {0};
  int scene_dimension;
  KITH_TRY(kith_keys_read(suite_keys, s->config->root, &head));
  if (head.suite[0] != '\0')
    snprintf(s->name, sizeof s->name, "%s", head.suite);
  else
    stem_of(s->config->file, s->name);
  if (strchr(s->name, '/') != NULL || s->name[0] == '.')
    return kith_config_fail(kith_config_at(s->config, "suite"), NULL, "'%.60s' cannot name a directory",
                            s->name);
  KITH_TRY(find_scene(s, programs, head.scene));
  stem_of(s->scene, s->scene_name);
  KITH_TRY(kith_scene_dimension(s->scene, s->n_overrides, s->overrides, &scene_dimension));
  bool given = head.dimension == 0;
  for (int k = 0; k < s->n_overrides; ++k)
    given |= strncmp(s->overrides[k], "dimension=", strlen("dimension=")) == 0;
  s->dimension = given ? scene_dimension : head.dimension;
  const struct kith_config_node *settings = kith_config_at(s->config, "settings");
  if (settings != NULL) KITH_TRY(kith_config_want_map(settings));
  KITH_TRY(read_methods(s));
  KITH_TRY(read_matrix(s));
  KITH_TRY(count_methods(s));
  KITH_TRY(read_norms(s));
  return find_others(s, head.others);
}

/* --- any scene --- */

static kith_status own_resolution(const struct kith_config *scene, int dimension, double *resolution) {
  const char by[4] = {(char)('0' + dimension), 'd', '\0'};
  const struct kith_config_node *node = kith_config_at(scene, "resolution");
  if (node != NULL && node->kind == KITH_CONFIG_MAP) node = kith_config_child(node, by);
  *resolution = node != NULL && node->kind == KITH_CONFIG_SCALAR ? strtod(node->text, NULL) : 0;
  if (*resolution > 0) return KITH_OK;
  return kith_config_fail(scene->root, "resolution", "no number for %d-D", dimension);
}

/* Even numbers: some scenes want a corner of cells in their middle. */
static double even(double x) {
  return fmax(2 * round(x / 2), 2);
}

static kith_status suite_of_scene(struct kith_suite *s, const char *path) {
  char text[2048], packages[128];
  double own;
  int dimension;
  KITH_TRY(kith_scene_dimension(path, s->n_overrides, s->overrides, &dimension));
  KITH_TRY(own_resolution(s->config, dimension, &own));
  const struct kith_config_node *exact = kith_config_at(s->config, "exact.name");
  if (exact == NULL)
    return kith_config_fail(s->config->root, "exact",
                            "none: a scene without an exact solution has no errors to chart");
  const char *norms = strcmp(exact->text, "gresho") == 0          ? "speed.l1, pressure.l1"
                      : strcmp(exact->text, "acoustic-wave") == 0 ? "velocity.l1, pressure.l1"
                                                                  : "density.l1, velocity.l1, pressure.l1";
#define NAME(name) "|" #name
  kith_words_tell("" KITH_PACKAGE_LIST(NAME), packages, sizeof packages);
#undef NAME
  const double factor = dimension == 3 ? sqrt(2) : 2;
  snprintf(
      text, sizeof text,
      "scene: '%.800s'\ndimension: %d\nmatrix: {method.package: [%s], resolution: [%g, %g, %g]}\nnorms: [%s]\n",
      path, dimension, packages, even(own / factor), even(own), even(own * factor), norms);
  if (strchr(path, '\'') != NULL || strlen(path) > 250)
    KITH_FAIL(BAD_INPUT, "%.200s: a path with a quote, or too long", path);
  kith_config_destroy(&s->config);
  return kith_config_parse(&s->config, path, text, strlen(text));
}

/* --- from outside --- */

static kith_status locate(const struct kith_programs *programs, const char *subject, char path[KITH_PATH]) {
  char words[2][2048], all[4096], near[64];
  snprintf(path, KITH_PATH, "%.760s", subject);
  if (is_path(subject) || access(subject, R_OK) == 0) return KITH_OK;
  char folder[KITH_PATH + 16];
  snprintf(folder, sizeof folder, "%s/suites", programs->inputs);
  names_in(folder, words[0], sizeof words[0]);
  names_in(programs->inputs, words[1], sizeof words[1]);
  for (int k = 0; k < 2; ++k) {
    if (kith_words_find(words[k], subject) < 0) continue;
    snprintf(path, KITH_PATH, "%.600s%s/%.100s.yaml", programs->inputs, k == 0 ? "/suites" : "", subject);
    return KITH_OK;
  }
  snprintf(all, sizeof all, "%s%s", words[0], words[1]);
  if (kith_words_nearest(all, subject, near, sizeof near))
    KITH_FAIL(BAD_INPUT, "chart: no suite or scene '%.60s'; did you mean '%s'?", subject, near);
  kith_words_tell(all, words[0], sizeof words[0]);
  KITH_FAIL(BAD_INPUT, "chart: no suite or scene '%.60s'; there are %s", subject, words[0]);
}

kith_status kith_suite_read(struct kith_suite **out, const struct kith_programs *programs,
                            const char *subject, int n_overrides, const char *const *overrides) {
  struct kith_suite *s = NULL;
  char path[KITH_PATH];
  *out = NULL;
  KITH_TRY(locate(programs, subject, path));
  KITH_TRY(kith_resize(&s, 0, 1, sizeof *s));
  s->n_overrides = n_overrides, s->overrides = overrides;
  kith_status status = kith_config_read(&s->config, path);
  if (status == KITH_OK && kith_config_at(s->config, "matrix") == NULL &&
      kith_config_at(s->config, "methods") == NULL && kith_config_at(s->config, "regions") != NULL)
    status = suite_of_scene(s, path);
  if (status == KITH_OK) status = read_suite(s, programs);
  if (status != KITH_OK) kith_suite_destroy(&s);
  *out = s;
  return status;
}

void kith_suite_destroy(struct kith_suite **suite) {
  if (*suite == NULL) return;
  kith_config_destroy(&(*suite)->config);
  kith_free(suite);
}

kith_status kith_suite_list(const struct kith_programs *programs) {
  char folder[KITH_PATH + 16], words[2048], told[2048];
  snprintf(folder, sizeof folder, "%s/suites", programs->inputs);
  names_in(folder, words, sizeof words);
  kith_words_tell(words, told, sizeof told);
  printf("suites  %s\n", told);
  names_in(programs->inputs, words, sizeof words);
  kith_words_tell(words, told, sizeof told);
  printf("scenes  %s: every package at three resolutions\n", told);
  return KITH_OK;
}
