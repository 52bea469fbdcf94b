/* suite.c - reading suites and sweeps: settings to text, methods and values to jobs. */
#include "app/study/suite.h"

#include <dirent.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/scene/dimension.h"
#include "app/scene/params.h"
#include "lib/core/choices.h"
#include "physics/package_list.h"

/* What all readers of this file share. */
struct context {
  const struct kith_programs *programs;
  int n_overrides;
  const char *const *overrides;
};

/* ---- tables ---- */

#define IN(member) KITH_INTO(struct kith_suite, member)
#define COMMON                                                                             \
  {"scene", KITH_PARAM_NAME, NULL, "", "a scene of inputs, or a path", IN(scene)},         \
      {"dimension", KITH_PARAM_INTEGER, "0", "[0, 3]", "0: the scene's", IN(dimension)}, { \
    "settings", KITH_PARAM_OTHER, "", "", "for every run", KITH_BELOW(NULL, MAP)           \
  }
static const struct kith_param suite_params[] = {
    COMMON,
    {"suite", KITH_PARAM_NAME, "", "", "its name; none: the name of the file", IN(name)},
    {"methods", KITH_PARAM_OTHER, "", "", "names for settings", KITH_BELOW(NULL, LIST)},
    {"resolution", KITH_PARAM_OTHER, NULL, "", "ascending", KITH_BELOW(NULL, LIST)},
    {"norms", KITH_PARAM_OTHER, "", "", "what is charted", KITH_BELOW(NULL, LIST)},
    {"targets", KITH_PARAM_OTHER, "", "", "errors at which costs are compared", KITH_BELOW(NULL, LIST)},
    {"reference_codes", KITH_PARAM_OTHER, "", "", "points of other codes", KITH_BELOW(NULL, LIST)},
    {0}};
static const struct kith_param sweep_params[] = {
    COMMON,
    {"name", KITH_PARAM_NAME, NULL, "", "what it is called", IN(name)},
    {"parameter", KITH_PARAM_NAME, NULL, "", "what is varied", IN(parameter)},
    {"measure", KITH_PARAM_NAME, NULL, "", "of the report", IN(measure[0])},
    {"at_most", KITH_PARAM_NUMBER, "", "", "the bound", IN(at_most)},
    {"at_least", KITH_PARAM_NUMBER, "", "", "the bound", IN(at_least)},
    {"of_first", KITH_PARAM_BOOL, "false", "", "over the measure at the first value", IN(of_first)},
    {"reason", KITH_PARAM_NAME, NULL, "", "of the bound", IN(reason)},
    {"values", KITH_PARAM_OTHER, NULL, "", "a key with values, or a list of settings",
     KITH_BELOW(NULL, LIST)},
    {0}};
static const struct kith_param file_params[] = {
    {"methods", KITH_PARAM_OTHER, "", "", "names for settings", KITH_BELOW(NULL, LIST)},
    {"sweeps", KITH_PARAM_OTHER, NULL, "", "what is varied", KITH_BELOW(NULL, LIST)},
    {0}};
/* A method or a value has a name and settings. */
struct named {
  char name[KITH_JOB_LABEL];
};
static const struct kith_param method_params[] = {
    {"name", KITH_PARAM_NAME, NULL, "", "what it is called", KITH_INTO(struct named, name)},
    {"settings", KITH_PARAM_OTHER, "", "", "what it sets", KITH_BELOW(NULL, MAP)},
    {0}};
static const struct kith_param value_params[] = {
    {"value", KITH_PARAM_NAME, NULL, "", "what it is called", KITH_INTO(struct named, name)},
    {"settings", KITH_PARAM_OTHER, NULL, "", "what it sets", KITH_BELOW(NULL, MAP)},
    {0}};
#define OF_CODE(member) KITH_INTO(struct kith_reference_code, member)
static const struct kith_param code_params[] = {
    {"code", KITH_PARAM_NAME, NULL, "", "its name", OF_CODE(name)},
    {"version", KITH_PARAM_NAME, "", "", "its version", OF_CODE(version)},
    {"machine", KITH_PARAM_NAME, NULL, "", "where it was measured", OF_CODE(machine)},
    {"resolution", KITH_PARAM_NUMBER, NULL, "(0, inf)", "nodes per unit length", OF_CODE(resolution)},
    {"cpu_seconds", KITH_PARAM_NUMBER, NULL, "(0, inf)", "cores times wall time", OF_CODE(cpu_seconds)},
    {"norms", KITH_PARAM_OTHER, NULL, "", "as density.l1", KITH_BELOW(NULL, MAP)},
    {0}};
static const struct kith_param positive = {"", KITH_PARAM_NUMBER,     NULL, "(0, inf)",
                                           "", .size = sizeof(double)};

/* ---- settings ---- */

struct text {
  char *to;
  size_t room;
};

__attribute__((format(printf, 2, 3))) static void put(struct text *t, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int n = vsnprintf(t->to, t->room, format, arguments);
  va_end(arguments);
  const size_t used = KITH_MIN((size_t)KITH_MAX(n, 0), t->room - 1);
  t->to += used, t->room -= used;
}

/* A value on one line, as YAML has it. */
static void put_value(struct text *t, const struct kith_config_node *node) {
  const bool map = node->kind == KITH_CONFIG_MAP;
  if (node->kind == KITH_CONFIG_SCALAR) {
    put(t, "%s", node->quoted ? "'" : node->null ? "null" : "");
    for (const char *c = node->null ? "" : node->text; *c != '\0'; ++c)
      put(t, *c == '\'' && node->quoted ? "''" : "%c", *c);
    put(t, "%s", node->quoted ? "'" : "");
    return;
  }
  put(t, map ? "{" : "[");
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (child != node->first) put(t, ", ");
    if (map) put(t, "%s: ", child->key);
    put_value(t, child);
  }
  put(t, map ? "}" : "]");
}

/* Sets `key` to the value of `node`, or, if that is a map (but no value by dimension), key.entry to each of
 * its entries. */
static kith_status set_all(struct kith_job *job, const char *key, const struct kith_config_node *node) {
  char text[1024];
  const bool by_dimension = node->kind == KITH_CONFIG_MAP && node->first != NULL &&
                            kith_choices_index("1d|2d|3d", node->first->key) >= 0;
  if (node->kind != KITH_CONFIG_MAP || by_dimension) {
    struct text t = {text, sizeof text};
    put(&t, "%s=", key);
    put_value(&t, node);
    if (t.room == 1) return kith_config_fail(node, NULL, "a value of more than a thousand letters");
    return kith_job_set(job, text);
  }
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    snprintf(text, sizeof text, "%s%s%s", key, key[0] != '\0' ? "." : "", child->key);
    KITH_TRY(set_all(job, text, child));
  }
  return KITH_OK;
}

/* What --set sets must not be what is varied (by values of `varied`, if that is not NULL). */
static kith_status apply_overrides(struct kith_job *job, const struct context *c, const char *varied) {
  for (int k = 0; k < c->n_overrides; ++k) {
    const char *text = c->overrides[k];
    if (varied != NULL && strncmp(text, varied, strlen(varied)) == 0 && text[strlen(varied)] == '=')
      KITH_FAIL(BAD_INPUT, "--set %s: this is what is varied", varied);
    if (strncmp(text, "dimension=", strlen("dimension=")) != 0) KITH_TRY(kith_job_set(job, text));
  }
  return KITH_OK;
}

/* ---- methods and values ---- */

/* Entries {name or value, settings}, none called like another. */
static kith_status check_named(const struct kith_config_node *list, const struct kith_param *params,
                               int most) {
  KITH_TRY(kith_config_want_list(list));
  if (list->n == 0) return kith_config_fail(list, NULL, "an empty list");
  if (list->n > most) return kith_config_fail(list, NULL, "more than %d", most);
  for (const struct kith_config_node *one = list->first; one != NULL; one = one->next) {
    struct named head;
    const struct kith_config_node *settings = kith_config_child(one, "settings");
    KITH_TRY(kith_config_want_map(one));
    KITH_TRY(kith_params_read(params, one, &head));
    if (settings != NULL) KITH_TRY(kith_config_want_map(settings));
    for (const struct kith_config_node *before = list->first; before != one; before = before->next)
      if (strcmp(kith_config_child(before, params->key)->text, head.name) == 0)
        return kith_config_fail(one, params->key, "'%s' is there twice", head.name);
  }
  return KITH_OK;
}

static kith_status check_values(const struct kith_config_node *list) {
  KITH_TRY(kith_config_want_list(list));
  if (list->n == 0) return kith_config_fail(list, NULL, "an empty list");
  return list->n > KITH_SUITE_VALUES ? kith_config_fail(list, NULL, "more than %d", KITH_SUITE_VALUES)
                                     : KITH_OK;
}

/* One value: of `key`, or, if that is NULL, with a name and settings. */
static kith_status set_value(struct kith_suite *s, struct kith_job *job, const char *key,
                             const struct kith_config_node *value) {
  struct text t = {job->value, sizeof job->value};
  char *end;
  put_value(&t, key == NULL ? kith_config_child(value, "value") : value);
  job->x = strtod(job->value, &end);
  if (*end != '\0') s->named_values = true, job->x = value->index;
  return set_all(job, key == NULL ? "" : key, key == NULL ? kith_config_child(value, "settings") : value);
}

/* Every method (methods NULL: the scene's) at every value. */
static kith_status make_jobs(struct kith_suite *s, const struct kith_job *common,
                             const struct kith_config_node *methods, const char *key,
                             const struct kith_config_node *values) {
  s->n_methods = methods != NULL ? methods->n : 1, s->n_values = values->n;
  KITH_TRY(kith_resize(&s->job, 0, (size_t)s->n_methods * s->n_values, sizeof *s->job));
  struct kith_job *job = s->job;
  const struct kith_config_node *method = methods != NULL ? methods->first : NULL;
  for (int m = 0; m < s->n_methods; ++m, method = method != NULL ? method->next : NULL)
    for (const struct kith_config_node *value = values->first; value != NULL; value = value->next, ++job) {
      *job = *common;
      snprintf(job->label, sizeof job->label, "%.100s",
               method != NULL ? kith_config_child(method, "name")->text : s->scene);
      job->line = method != NULL ? method->location.line : 0;
      if (method != NULL && kith_config_child(method, "settings") != NULL)
        KITH_TRY(set_all(job, "", kith_config_child(method, "settings")));
      KITH_TRY(set_value(s, job, key, value));
    }
  return KITH_OK;
}

/* ---- scenes ---- */

static void stem_of(const char *path, char *stem, size_t size) {
  const char *slash = strrchr(path, '/'), *name = slash != NULL ? slash + 1 : path, *dot = strrchr(name, '.');
  snprintf(stem, size, "%.*s", dot != NULL && dot != name ? (int)(dot - name) : (int)strlen(name), name);
}

bool kith_suite_is_path(const char *name) {
  const char *dot = strrchr(name, '.');
  return strchr(name, '/') != NULL || (dot != NULL && strcmp(dot, ".yaml") == 0);
}

/* "|noh|sedov|sod": the names of the YAML files of a folder, in alphabetical order. */
static void names_in(const char *folder, char *names, size_t size) {
  struct dirent **entries;
  const int n = scandir(folder, &entries, NULL, alphasort);
  names[0] = '\0';
  for (int k = 0; k < n; ++k) {
    const char *dot = strrchr(entries[k]->d_name, '.');
    const size_t used = strlen(names);
    if (dot != NULL && dot != entries[k]->d_name && strcmp(dot, ".yaml") == 0)
      snprintf(names + used, size - used, "|%.*s", (int)(dot - entries[k]->d_name), entries[k]->d_name);
    free(entries[k]);
  }
  if (n >= 0) free(entries);
}

/* A path is relative to the folder of the file, or to here. */
static kith_status find_scene(const struct kith_config_node *node, const struct context *c, const char *name,
                              char path[KITH_JOB_PATH]) {
  char names[2048];
  const char *from = node->location.file, *slash = strrchr(from, '/');
  if (!kith_suite_is_path(name)) {
    names_in(c->programs->inputs, names, sizeof names);
    if (kith_choices_index(names, name) < 0) return kith_config_fail_word(node, names);
    snprintf(path, KITH_JOB_PATH, "%s/%.100s.yaml", c->programs->inputs, name);
    return KITH_OK;
  }
  snprintf(path, KITH_JOB_PATH, "%.*s%.255s", slash != NULL ? (int)(slash - from) + 1 : 0, from, name);
  if (name[0] == '/' || access(path, R_OK) != 0) snprintf(path, KITH_JOB_PATH, "%.255s", name);
  return access(path, R_OK) == 0 ? KITH_OK : kith_config_fail(node, NULL, "'%s' cannot be read", name);
}

/* The dimension is that of --set, else of the suite, else of the scene. */
static kith_status set_scene(struct kith_suite *s, const struct context *c, struct kith_job *job) {
  int own;
  bool given = s->dimension == 0;
  stem_of(job->scene, s->scene, sizeof s->scene);
  KITH_TRY(kith_scene_dimension(job->scene, c->n_overrides, c->overrides, &own));
  for (int k = 0; k < c->n_overrides; ++k)
    given |= strncmp(c->overrides[k], "dimension=", strlen("dimension=")) == 0;
  if (given) s->dimension = own;
  job->dimension = s->dimension;
  return KITH_OK;
}

/* The job that all have in common: scene, dimension, settings. */
static kith_status make_common(struct kith_suite *s, const struct kith_config_node *map,
                               const struct context *c, struct kith_job *job) {
  const struct kith_config_node *settings = kith_config_child(map, "settings");
  KITH_TRY(find_scene(kith_config_child(map, "scene"), c, s->scene, job->scene));
  KITH_TRY(set_scene(s, c, job));
  if (settings == NULL) return KITH_OK;
  KITH_TRY(kith_config_want_map(settings));
  return set_all(job, "", settings);
}

/* ---- suites ---- */

static kith_status read_norms(struct kith_suite *s, const struct kith_config *config) {
  const struct kith_config_node *norms = kith_config_at(config, "norms"),
                                *targets = kith_config_at(config, "targets");
  if (norms == NULL) snprintf(s->measure[s->n_measures++], sizeof s->measure[0], "norms.density.l1");
  if (norms != NULL) KITH_TRY(kith_config_want_list(norms));
  if (norms != NULL && (norms->n == 0 || norms->n > KITH_SUITE_MEASURES))
    return kith_config_fail(norms, NULL, "%d norms; 1 to %d can be charted", norms->n, KITH_SUITE_MEASURES);
  for (const struct kith_config_node *n = norms != NULL ? norms->first : NULL; n != NULL; n = n->next) {
    if (n->kind != KITH_CONFIG_SCALAR) return kith_config_fail(n, NULL, "a norm is a word, as density.l1");
    if (kith_choices_index(kith_norm_choices, n->text) < 0)
      return kith_config_fail_word(n, kith_norm_choices);
    snprintf(s->measure[s->n_measures++], sizeof s->measure[0], "norms.%s", n->text);
  }
  if (targets == NULL) return KITH_OK;
  KITH_TRY(kith_config_want_list(targets));
  if (targets->n != s->n_measures)
    return kith_config_fail(targets, NULL, "%d targets for %d norms", targets->n, s->n_measures);
  for (const struct kith_config_node *t = targets->first; t != NULL; t = t->next)
    KITH_TRY(kith_param_value(&positive, t, &s->target[t->index]));
  return KITH_OK;
}

static kith_status read_codes(struct kith_suite *s, const struct kith_config_node *list) {
  KITH_TRY(kith_config_want_list(list));
  KITH_TRY(kith_resize(&s->code, 0, (size_t)list->n, sizeof *s->code));
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    struct kith_reference_code *code = &s->code[s->n_codes++];
    const struct kith_config_node *norms = kith_config_child(node, "norms");
    KITH_TRY(kith_config_want_map(node));
    KITH_TRY(kith_params_read(code_params, node, code));
    KITH_TRY(kith_config_want_map(norms));
    for (int k = 0; k < KITH_SUITE_MEASURES; ++k) code->norm[k] = NAN;
    for (const struct kith_config_node *norm = norms->first; norm != NULL; norm = norm->next) {
      double value;
      KITH_TRY(kith_param_value(&positive, norm, &value));
      if (kith_choices_index(kith_norm_choices, norm->key) < 0)
        return kith_config_fail(norm, NULL, "none of our norms, which are as density.l1");
      for (int k = 0; k < s->n_measures; ++k)
        if (strcmp(norm->key, s->measure[k] + strlen("norms.")) == 0) code->norm[k] = value;
    }
  }
  return KITH_OK;
}

static kith_status read_suite(struct kith_suite *s, const struct kith_config *config,
                              const struct context *c) {
  struct kith_job job = {0};
  const struct kith_config_node *methods = kith_config_at(config, "methods"),
                                *resolution = kith_config_at(config, "resolution"),
                                *codes = kith_config_at(config, "reference_codes");
  stem_of(config->file, s->name, sizeof s->name);
  KITH_TRY(kith_params_read(suite_params, config->root, s));
  if (strchr(s->name, '/') != NULL || s->name[0] == '.')
    return kith_config_fail(kith_config_at(config, "suite"), NULL, "'%.60s' cannot name a directory",
                            s->name);
  KITH_TRY(make_common(s, config->root, c, &job));
  KITH_TRY(apply_overrides(&job, c, "resolution"));
  if (methods != NULL) KITH_TRY(check_named(methods, method_params, KITH_SUITE_METHODS));
  KITH_TRY(check_values(resolution));
  double last = 0, next;
  for (const struct kith_config_node *r = resolution->first; r != NULL; r = r->next, last = next) {
    KITH_TRY(kith_param_value(&positive, r, &next));
    if (next <= last) return kith_config_fail(r, NULL, "%g after %g: resolutions ascend", next, last);
  }
  KITH_TRY(make_jobs(s, &job, methods, "resolution", resolution));
  KITH_TRY(read_norms(s, config));
  return codes != NULL ? read_codes(s, codes) : KITH_OK;
}

/* Even numbers: some scenes want a corner of cells in their middle. */
static double even(double x) {
  return fmax(2 * round(x / 2), 2);
}

/* Every package at three resolutions of a scene. */
static kith_status suite_of_scene(struct kith_suite *s, const struct kith_config *config,
                                  const struct context *c) {
#define METHOD(name) "  - {name: " #name ", settings: {method.package: " #name "}}\n"
  static const char format[] =
      "resolution: [%g, %g, %g]\nnorms: [density.l1, velocity.l1, pressure.l1]\nmethods:\n" KITH_PACKAGE_LIST(
          METHOD);
#undef METHOD
  char text[sizeof format + 100];
  struct kith_config *suite = NULL;
  struct kith_job job = {0};
  if (kith_config_at(config, "exact") == NULL)
    return kith_config_fail(config->root, "exact",
                            "none: a scene without an exact solution has no errors to chart");
  snprintf(job.scene, sizeof job.scene, "%s", config->file);
  KITH_TRY(set_scene(s, c, &job));
  KITH_TRY(apply_overrides(&job, c, "resolution"));
  stem_of(config->file, s->name, sizeof s->name);
  const char by[] = {(char)('0' + s->dimension), 'd', '\0'};
  const struct kith_config_node *node = kith_config_at(config, "resolution");
  if (node != NULL && node->kind == KITH_CONFIG_MAP) node = kith_config_child(node, by);
  const double own = node != NULL && node->kind == KITH_CONFIG_SCALAR ? strtod(node->text, NULL) : 0;
  if (!(own > 0)) return kith_config_fail(config->root, "resolution", "no number for %d-D", s->dimension);
  const double factor = s->dimension == 3 ? sqrt(2) : 2;
  snprintf(text, sizeof text, format, even(own / factor), even(own), even(own * factor));
  KITH_TRY(kith_config_parse(&suite, config->file, text, strlen(text)));
  kith_status status =
      make_jobs(s, &job, kith_config_at(suite, "methods"), "resolution", kith_config_at(suite, "resolution"));
  if (status == KITH_OK) status = read_norms(s, suite);
  kith_config_destroy(&suite);
  return status;
}

static kith_status unknown(const char *what, const char *name, const char *choices) {
  char told[4096];
  if (kith_choices_suggest(choices, name, told, sizeof told))
    KITH_FAIL(BAD_INPUT, "%s '%.60s'; did you mean '%s'?", what, name, told);
  kith_choices_format(choices, told, sizeof told);
  KITH_FAIL(BAD_INPUT, "%s '%.60s'; there are %s", what, name, told);
}

/* The names of suites, then of scenes. */
static void all_names(const struct kith_programs *programs, char names[2][2048]) {
  char folder[KITH_PATH + 16];
  snprintf(folder, sizeof folder, "%s/suites", programs->inputs);
  names_in(folder, names[0], sizeof names[0]);
  names_in(programs->inputs, names[1], sizeof names[1]);
}

static kith_status locate(const struct kith_programs *programs, const char *subject,
                          char path[KITH_JOB_PATH]) {
  char names[2][2048], all[4096];
  snprintf(path, KITH_JOB_PATH, "%.760s", subject);
  if (kith_suite_is_path(subject) || access(subject, R_OK) == 0) return KITH_OK;
  all_names(programs, names);
  const bool suite = kith_choices_index(names[0], subject) >= 0;
  if (suite || kith_choices_index(names[1], subject) >= 0) {
    snprintf(path, KITH_JOB_PATH, "%s%s/%.100s.yaml", programs->inputs, suite ? "/suites" : "", subject);
    return KITH_OK;
  }
  snprintf(all, sizeof all, "%s%s", names[0], names[1]);
  return unknown("chart: no suite or scene", subject, all);
}

kith_status kith_suite_read(struct kith_suite *s, const struct kith_programs *programs, const char *subject,
                            int n_overrides, const char *const *overrides) {
  const struct context c = {programs, n_overrides, overrides};
  struct kith_config *config = NULL;
  *s = (struct kith_suite){0};
  KITH_TRY(locate(programs, subject, s->file));
  KITH_TRY(kith_config_read(&config, s->file));
  kith_status status =
      kith_config_at(config, "regions") != NULL ? suite_of_scene(s, config, &c) : read_suite(s, config, &c);
  kith_config_destroy(&config);
  for (int k = 0; k < s->n_methods * s->n_values && status == KITH_OK; ++k)
    s->job[k].weight = pow(s->job[k].x, s->dimension + 1); /* nodes times steps */
  if (status != KITH_OK) kith_suite_clear(s);
  return status;
}

void kith_suite_clear(struct kith_suite *s) {
  kith_free(&s->job);
  kith_free(&s->code);
}

void kith_suite_list(const struct kith_programs *programs) {
  char names[2][2048], told[2048];
  all_names(programs, names);
  kith_choices_format(names[0], told, sizeof told);
  printf("suites  %s\n", told);
  kith_choices_format(names[1], told, sizeof told);
  printf("scenes  %s: every package at three resolutions\n", told);
}

/* ---- sweeps ---- */

static kith_status read_sweep(struct kith_suite *s, const struct kith_config_node *node,
                              const struct kith_config_node *methods, const struct context *c) {
  struct kith_job job = {.weight = 1};
  const struct kith_config_node *values = kith_config_child(node, "values");
  *s = (struct kith_suite){.at_most = NAN, .at_least = NAN, .n_measures = 1};
  KITH_TRY(kith_config_want_map(node));
  KITH_TRY(kith_params_read(sweep_params, node, s));
  if (isnan(s->at_most) == isnan(s->at_least))
    return kith_config_fail(node, NULL, "sweep %s needs one bound, at_most or at_least", s->name);
  KITH_TRY(make_common(s, node, c, &job));
  const bool one_key = values->kind == KITH_CONFIG_MAP;
  if (one_key && values->n != 1)
    return kith_config_fail(values, NULL, "%d keys; a sweep varies one", values->n);
  if (one_key) values = values->first;
  KITH_TRY(one_key ? check_values(values) : check_named(values, value_params, KITH_SUITE_VALUES));
  KITH_TRY(apply_overrides(&job, c, one_key ? values->key : NULL));
  return make_jobs(s, &job, methods, one_key ? values->key : NULL, values);
}

static kith_status read_sweeps(struct kith_suite **sweeps, int *n, const struct kith_config *config,
                               const char *only, const struct context *c) {
  const struct kith_config_node *list = kith_config_at(config, "sweeps"),
                                *methods = kith_config_at(config, "methods");
  char none, names[4096] = "";
  KITH_TRY(kith_params_read(file_params, config->root, &none));
  KITH_TRY(kith_config_want_list(list));
  if (methods != NULL) KITH_TRY(check_named(methods, method_params, KITH_SUITE_METHODS));
  KITH_TRY(kith_resize(sweeps, 0, (size_t)list->n, sizeof **sweeps));
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    const struct kith_config_node *child = kith_config_child(node, "name");
    const char *name = child != NULL && child->text != NULL ? child->text : "";
    const size_t used = strlen(names);
    snprintf(names + used, sizeof names - used, "|%s", name);
    if (only == NULL || strcmp(name, only) == 0) KITH_TRY(read_sweep(&(*sweeps)[(*n)++], node, methods, c));
  }
  return *n > 0 ? KITH_OK : unknown("stress: no sweep", only != NULL ? only : "", names);
}

kith_status kith_sweeps_read(struct kith_suite **sweeps, int *n, const struct kith_programs *programs,
                             const char *path, const char *only, int n_overrides,
                             const char *const *overrides) {
  const struct context c = {programs, n_overrides, overrides};
  struct kith_config *config = NULL;
  KITH_TRY(kith_config_read(&config, path));
  const kith_status status = read_sweeps(sweeps, n, config, only, &c);
  kith_config_destroy(&config);
  return status;
}
