/* suite.c - reading suites and sweeps: settings to text, methods and values to jobs. */
#include "app/study/study.h"

#include <fnmatch.h>
#include <glob.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/scene/params.h"
#include "lib/core/choices.h"

/* Name and settings of a method or a value. */
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
    {"norms", KITH_PARAM_OTHER, NULL, "", "errors by norm: {density.l1: 0.1}", KITH_BELOW(NULL, MAP)},
    {0}};
#define IN(member) KITH_INTO(struct kith_suite, member)
#define COMMON                                                                                               \
  {"scene",  KITH_PARAM_NAME, NULL, "", "a scene of inputs, or a path from the folder of this file",         \
   IN(scene)},                                                                                               \
      {"dimension", KITH_PARAM_INTEGER, "0", "[0, 3]", "0: the scene's", IN(dimension)}, {                   \
    "settings", KITH_PARAM_OTHER, "", "", "for every run: keys as in --set, or nested; also ranks, threads", \
        KITH_BELOW(NULL, MAP)                                                                                \
  }
#define METHODS                                                                        \
  {                                                                                    \
    "methods", KITH_PARAM_OTHER, "", "", "names for settings; none: one, the scene's", \
        KITH_BELOW(method_params, LIST)                                                \
  }
static const struct kith_param suite_params[] = {
    COMMON,
    METHODS,
    {"over", KITH_PARAM_OTHER, "", "",
     "keys of the scene, each with a list of values: each method is run with every combination of these",
     KITH_BELOW(NULL, MAP)},
    {"resolution", KITH_PARAM_OTHER, NULL, "", "list of nodes per unit length, ascending",
     KITH_BELOW(NULL, LIST)},
    {"norms", KITH_PARAM_OTHER, "", "", "list of the norms that are charted; none: [density.l1]",
     KITH_BELOW(NULL, LIST)},
    {"targets", KITH_PARAM_OTHER, "", "",
     "for each norm the error at which costs are compared; none: the largest at the finest resolution",
     KITH_BELOW(NULL, LIST)},
    {"reference_codes", KITH_PARAM_OTHER, "", "", "points of other codes, measured elsewhere",
     KITH_BELOW(code_params, LIST)},
    {0}};
static const struct kith_param sweep_params[] = {
    {"name", KITH_PARAM_NAME, NULL, "", "what it is called", IN(name)},
    COMMON,
    {"parameter", KITH_PARAM_NAME, NULL, "", "what is varied, in words", IN(parameter)},
    {"measure", KITH_PARAM_NAME, NULL, "", "what is judged", IN(measure[0])},
    {"at_most", KITH_PARAM_NUMBER, "", "", "what still counts as working; this or at_least", IN(at_most)},
    {"at_least", KITH_PARAM_NUMBER, "", "", "what still counts as working", IN(at_least)},
    {"of_first", KITH_PARAM_BOOL, "false", "",
     "the measure is divided by that at the first value, with the same method", IN(of_first)},
    {"reason", KITH_PARAM_NAME, NULL, "", "why this bound", IN(reason)},
    {"values", KITH_PARAM_OTHER, NULL, "",
     "from mild to hard: {scheme.cfl: [0.1, 0.2]}, or a list of names with settings",
     KITH_BELOW(value_params, LIST)},
    {0}};
static const struct kith_param file_params[] = {
    METHODS, {"sweeps", KITH_PARAM_OTHER, NULL, "", "what is varied", KITH_BELOW(sweep_params, LIST)}, {0}};
static const struct kith_param positive = {"resolution", KITH_PARAM_NUMBER,     NULL, "(0, inf)",
                                           "",           .size = sizeof(double)};
static const char norm_choices[] =
    "density.l1|density.l2|density.linf|velocity.l1|velocity.l2|velocity.linf|pressure.l1|pressure.l2|"
    "pressure.linf|energy.l1|energy.l2|energy.linf|speed.l1|speed.l2|speed.linf|"
    "contact_pressure_error|density_peak";
static const struct kith_param norm_param = {"", KITH_PARAM_NAME, NULL, norm_choices, "", .size = 32};

/* Adds the setting of `key` to the value of `node`, or, if that is a map, those of key.ENTRY to each of its
 * entries. sign: "=", or "?=" for a setting that may mean nothing to some of the methods. */
static kith_status set_all(struct kith_job *job, const char *key, const char *sign,
                           const struct kith_config_node *node) {
  char text[1024], *value;
  if (node->kind != KITH_CONFIG_MAP) {
    KITH_TRY(kith_config_emit(node, true, &value));
    const size_t length = strcspn(value, "\n"); /* the end of the document follows a plain value */
    const int written = snprintf(text, sizeof text, "%s%s%.*s", key, sign, (int)length, value);
    const bool whole = value[length + 1] == '\0' || strcmp(value + length, "\n...\n") == 0;
    kith_free(&value);
    if (!whole || written >= (int)sizeof text) return kith_config_fail(node, NULL, "a setting is too long");
    return kith_job_set(job, text) == KITH_OK ? KITH_OK : kith_config_fail(node, NULL, "%s", kith_failure());
  }
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    snprintf(text, sizeof text, "%s%s%s", key, key[0] != '\0' ? "." : "", child->key);
    KITH_TRY(set_all(job, text, sign, child));
  }
  return KITH_OK;
}

/* Adds the settings of a suite, a method or a value, if it has some. `map` may be NULL. */
static kith_status apply_settings(struct kith_job *job, const char *sign,
                                  const struct kith_config_node *map) {
  const struct kith_config_node *settings = kith_config_child(map, "settings");
  if (settings == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(settings, KITH_CONFIG_MAP));
  return set_all(job, "", sign, settings);
}

static bool sets(const char *settings, const char *key, size_t length) {
  for (const char *s = settings; *s != '\0'; s += strcspn(s, "\n") + 1)
    if (strcspn(s, "?=") == length && strncmp(s, key, length) == 0) return true;
  return false;
}

/* Refuses a --set that has no effect, because the method or the value of each job sets the same key after it.
 * common: the length of the settings with which all jobs begin. */
static kith_status check_overrides(const struct kith_suite *s, size_t common,
                                   const struct kith_options *options) {
  for (int k = 0; k < options->n_overrides; ++k) {
    const size_t length = strcspn(options->overrides[k], "?=");
    int n = 0;
    for (int j = 0; j < s->n_methods * s->n_values; ++j)
      n += sets(s->job[j].settings + common, options->overrides[k], length);
    if (n == s->n_methods * s->n_values)
      KITH_FAIL(BAD_INPUT, "--set %.*s: this is what is varied", (int)length, options->overrides[k]);
  }
  return KITH_OK;
}

/* Refuses a name with a bar, which would end a column of the tables in Markdown. */
static kith_status check_cell(const struct kith_config_node *map, const char *key) {
  const struct kith_config_node *name = kith_config_child(map, key);
  if (name == NULL || name->text == NULL || strchr(name->text, '|') == NULL) return KITH_OK;
  return kith_config_fail(name, NULL, "'%.60s': a bar would end a column of the tables", name->text);
}

/* Checks that a list has 1 to `most` entries. If `params` is not NULL, they are maps with these keys, of
 * which the first is a name, and no two entries may have the same. */
static kith_status check_list(const struct kith_config_node *list, const struct kith_param *params,
                              int most) {
  KITH_TRY(kith_config_want(list, KITH_CONFIG_LIST));
  if (list->n == 0) return kith_config_fail(list, NULL, "an empty list");
  if (list->n > most) return kith_config_fail(list, NULL, "more than %d", most);
  if (params == NULL) return KITH_OK;
  for (const struct kith_config_node *one = list->first; one != NULL; one = one->next) {
    struct named head;
    KITH_TRY(kith_params_read(params, one, &head));
    KITH_TRY(check_cell(one, params->key));
    for (const struct kith_config_node *before = list->first; before != one; before = before->next)
      if (strcmp(kith_config_child(before, params->key)->text, head.name) == 0)
        return kith_config_fail(one, params->key, "'%s' is there twice", head.name);
  }
  return KITH_OK;
}

/* Applies one value of a list: that of `key`, or, if `key` is NULL, a map with a name and settings. */
static kith_status set_value(struct kith_suite *s, struct kith_job *job, const char *key,
                             const struct kith_config_node *value) {
  const struct kith_config_node *shown = key == NULL ? kith_config_child(value, "value") : value;
  const size_t size = sizeof job->value;
  char *end;
  if (shown->text == NULL || (size_t)snprintf(job->value, size, "%s", shown->text) >= size)
    return kith_config_fail(shown, NULL, "a value is one word or number of at most %zu letters", size - 1);
  job->x = strtod(job->value, &end);
  if (*end != '\0') s->named_values = true, job->x = value->index;
  return key == NULL ? apply_settings(job, "?=", value) : set_all(job, key, "=", value);
}

/* Multiplies *n by the number of values of each key of a map of lists; NULL: there are none. */
static kith_status count_over(const struct kith_config_node *over, int *n) {
  if (over == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(over, KITH_CONFIG_MAP));
  for (const struct kith_config_node *key = over->first; key != NULL; key = key->next) {
    KITH_TRY(check_list(key, NULL, KITH_SUITE_METHODS));
    for (const struct kith_config_node *value = key->first; value != NULL; value = value->next)
      if (value->text == NULL || strchr(value->text, '|') != NULL)
        return kith_config_fail(value, NULL, "a value of `over` is one word or number");
    *n *= key->n;
    if (*n > KITH_SUITE_METHODS)
      return kith_config_fail(over, NULL, "more than %d methods, with all combinations", KITH_SUITE_METHODS);
  }
  return KITH_OK;
}

/* Applies combination k of the values, of which those of the last key change first, and adds them to the
 * label. The job has its label by then, which is dropped if `only`. */
static kith_status apply_over(struct kith_job *job, const struct kith_config_node *over, int k, bool only) {
  int rest = 1;
  count_over(over, &rest); /* has succeeded before */
  if (over != NULL && over->first != NULL && only) job->label[0] = '\0';
  for (const struct kith_config_node *key = over != NULL ? over->first : NULL; key != NULL; key = key->next) {
    const struct kith_config_node *value = key->first;
    rest /= key->n;
    for (int skip = k / rest % key->n; skip > 0; --skip) value = value->next;
    kith_text_add(job->label, sizeof job->label, "%s%s", job->label[0] != '\0' ? " " : "", value->text);
    KITH_TRY(set_all(job, key->key, "=", value));
  }
  return KITH_OK;
}

/* Makes the jobs of a suite from the common one: every method, with every combination of the values of
 * `over`, at every value. If `methods` is NULL, there is one method, that of the scene; if `over` is NULL
 * nothing is combined. `key` is as in set_value. */
static kith_status make_jobs(struct kith_suite *s, const struct kith_study *c, struct kith_job *common,
                             const struct kith_config_node *methods, const struct kith_config_node *over,
                             const char *key, const struct kith_config_node *values) {
  int combinations = 1;
  for (int k = 0; k < c->options->n_overrides; ++k)
    if (strncmp(c->options->overrides[k], "dimension=", strlen("dimension=")) != 0)
      KITH_TRY(kith_job_set(common, c->options->overrides[k]));
  if (methods != NULL) KITH_TRY(check_list(methods, method_params, KITH_SUITE_METHODS));
  KITH_TRY(check_list(values, key != NULL ? NULL : value_params, KITH_SUITE_VALUES));
  KITH_TRY(count_over(over, &combinations));
  s->n_methods = methods != NULL ? methods->n : 1, s->n_values = values->n;
  if (combinations * s->n_methods > KITH_SUITE_METHODS)
    return kith_config_fail(over, NULL, "more than %d methods, with all combinations", KITH_SUITE_METHODS);
  s->n_methods *= combinations;
  const size_t n_jobs = (size_t)s->n_methods * (size_t)s->n_values;
  KITH_TRY(kith_resize(&s->job, 0, n_jobs, sizeof *s->job));
  KITH_TRY(kith_resize(&s->point, 0, n_jobs, sizeof *s->point));
  const struct kith_config_node *method = methods != NULL ? methods->first : NULL, *value = values->first;
  int combination = 0;
  for (struct kith_job *job = s->job; job < s->job + n_jobs; ++job) {
    const struct kith_config_node *name = kith_config_child(method, "name");
    *job = *common;
    snprintf(job->label, sizeof job->label, "%.100s", name != NULL ? name->text : s->scene);
    job->line = (s->parameter[0] != '\0' || method == NULL ? value : method)->location.line;
    KITH_TRY(apply_settings(job, "=", method));
    KITH_TRY(apply_over(job, over, combination, name == NULL));
    KITH_TRY(set_value(s, job, key, value));
    value = value->next;
    if (value != NULL) continue;
    value = values->first;
    if (++combination < combinations) continue;
    combination = 0;
    if (method != NULL) method = method->next;
  }
  return check_overrides(s, strlen(common->settings), c->options);
}

bool kith_suite_is_path(const char *name) {
  return strchr(name, '/') != NULL || fnmatch("*.yaml", name, 0) == 0;
}

/* Adds "|noh|sedov|sod" to names: the YAML files of a folder below inputs, in alphabetical order. */
static void add_names(const struct kith_programs *programs, const char *folder, char *names, size_t size) {
  char text[KITH_PATH + 32];
  glob_t found;
  snprintf(text, sizeof text, "%s%s/*.yaml", programs->inputs, folder);
  if (glob(text, 0, NULL, &found) != 0) return;
  for (size_t k = 0; k < found.gl_pathc; ++k) {
    kith_path_stem(found.gl_pathv[k], text, sizeof text);
    kith_text_add(names, size, "|%s", text);
  }
  globfree(&found);
}

kith_status kith_study_unknown(const char *what, const char *name, const char *choices) {
  char told[4096];
  if (kith_choices_suggest(choices, name, told, sizeof told))
    KITH_FAIL(BAD_INPUT, "%s '%.60s'; did you mean '%s'?", what, name, told);
  kith_choices_format(choices, told, sizeof told);
  KITH_FAIL(BAD_INPUT, "%s '%.60s'; there are %s", what, name, told);
}

kith_status kith_study_inputs(const struct kith_programs *programs, const char *folder, const char *what,
                              const char *name) {
  char path[KITH_PATH + 32];
  snprintf(path, sizeof path, "%s%s", programs->inputs, folder);
  if (access(path, R_OK) == 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT,
            "%s '%.60s': no folder inputs%s above the programs, in share/kith beside them, or here", what,
            name, folder);
}

/* Finds NAME.yaml of the folder. */
static kith_status find_input(const struct kith_programs *programs, const char *folder, const char *what,
                              const char *name, char path[KITH_JOB_PATH]) {
  char names[4096] = "";
  KITH_TRY(kith_study_inputs(programs, folder, what, name));
  snprintf(path, KITH_JOB_PATH, "%s%s/%.100s.yaml", programs->inputs, folder, name);
  if (access(path, R_OK) == 0) return KITH_OK;
  add_names(programs, folder, names, sizeof names);
  return kith_study_unknown(what, name, names);
}

kith_status kith_programs_scene(const struct kith_programs *programs, const struct kith_config_node *node,
                                const char *name, char path[KITH_JOB_PATH]) {
  const char *from = node->location.file;
  if (!kith_suite_is_path(name))
    return find_input(programs, "", "no scene", name, path) == KITH_OK
               ? KITH_OK
               : kith_config_fail(node, NULL, "%s", kith_failure());
  snprintf(path, KITH_JOB_PATH, "%.*s%.255s", kith_path_folder(from), from, name);
  if (name[0] == '/' || access(path, R_OK) != 0) snprintf(path, KITH_JOB_PATH, "%.255s", name);
  return access(path, R_OK) == 0 ? KITH_OK : kith_config_fail(node, NULL, "'%s' cannot be read", name);
}

/* Sets scene and dimension; the dimension is that of --set, else of the suite, else of the scene. */
static kith_status set_scene(struct kith_suite *s, const struct kith_study *c, struct kith_job *job) {
  const char *overrides[KITH_MAX_OVERRIDES + 1];
  char own[32];
  const int first = s->dimension > 0;
  snprintf(own, sizeof own, "dimension=%d", s->dimension);
  overrides[0] = own;
  memcpy(overrides + first, c->options->overrides, sizeof c->options->overrides);
  kith_path_stem(job->scene, s->scene, sizeof s->scene);
  KITH_TRY(kith_scene_dimension(job->scene, first + c->options->n_overrides, overrides, &s->dimension));
  job->dimension = s->dimension;
  return KITH_OK;
}

/* Reads the keys that suites and sweeps have in common, and makes the job that all jobs start from: its
 * scene, dimension and settings. */
static kith_status read_common(struct kith_suite *s, const struct kith_param *params,
                               const struct kith_config_node *map, const struct kith_study *c,
                               struct kith_job *job) {
  *job = (struct kith_job){0};
  KITH_TRY(kith_params_read(params, map, s));
  KITH_TRY(kith_programs_scene(&c->programs, kith_config_child(map, "scene"), s->scene, job->scene));
  KITH_TRY(set_scene(s, c, job));
  return apply_settings(job, "=", map);
}

/* Reads norms and targets; without `norms`: that of the density. */
static kith_status read_norms(struct kith_suite *s, const struct kith_config *config) {
  const struct kith_config_node *norms = kith_config_at(config, "norms"),
                                *targets = kith_config_at(config, "targets");
  s->n_measures = norms != NULL ? norms->n : 1;
  snprintf(s->measure[0], sizeof s->measure[0], "norms.density.l1");
  if (norms != NULL) KITH_TRY(check_list(norms, NULL, KITH_SUITE_MEASURES));
  for (const struct kith_config_node *n = norms != NULL ? norms->first : NULL; n != NULL; n = n->next) {
    char norm[32];
    KITH_TRY(kith_param_value(&norm_param, n, norm));
    snprintf(s->measure[n->index], sizeof s->measure[0], "norms.%s", norm);
  }
  if (targets == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(targets, KITH_CONFIG_LIST));
  if (targets->n != s->n_measures)
    return kith_config_fail(targets, NULL, "%d targets for %d norms", targets->n, s->n_measures);
  for (const struct kith_config_node *t = targets->first; t != NULL; t = t->next)
    KITH_TRY(kith_param_value(&positive, t, &s->target[t->index]));
  return KITH_OK;
}

static kith_status read_code(const struct kith_suite *s, const struct kith_config_node *node,
                             struct kith_reference_code *code) {
  const struct kith_config_node *norms = kith_config_child(node, "norms");
  KITH_TRY(kith_params_read(code_params, node, code));
  for (const struct kith_param *p = code_params; p->kind == KITH_PARAM_NAME; ++p)
    KITH_TRY(check_cell(node, p->key));
  KITH_TRY(kith_config_want(norms, KITH_CONFIG_MAP));
  for (int k = 0; k < KITH_SUITE_MEASURES; ++k) code->norm[k] = NAN;
  for (const struct kith_config_node *norm = norms->first; norm != NULL; norm = norm->next) {
    double value;
    KITH_TRY(kith_param_value(&positive, norm, &value));
    if (kith_choices_index(norm_choices, norm->key) < 0)
      return kith_config_fail(norm, NULL, "none of our norms, which are as density.l1");
    for (int k = 0; k < s->n_measures; ++k)
      if (strcmp(norm->key, s->measure[k] + strlen("norms.")) == 0) code->norm[k] = value;
  }
  return KITH_OK;
}

/* Checks that the scene or the settings name an exact solution, which errors are from. */
static kith_status check_exact(const struct kith_job *job, const struct kith_config_node *suite) {
  struct kith_config *scene;
  KITH_TRY(kith_config_read(&scene, job->scene));
  const bool exact = kith_config_at(scene, "exact") != NULL || strncmp(job->settings, "exact", 5) == 0 ||
                     strstr(job->settings, "\nexact") != NULL;
  kith_config_destroy(&scene);
  if (exact) return KITH_OK;
  return kith_config_fail(kith_config_child(suite, "scene"), NULL,
                          "the scene has no exact solution, from which errors could be charted");
}

static kith_status read_suite(struct kith_suite *s, const struct kith_config *config,
                              const struct kith_study *c) {
  struct kith_job job;
  const struct kith_config_node *codes = kith_config_at(config, "reference_codes"),
                                *resolution = kith_config_at(config, "resolution");
  double last = 0, next;
  KITH_TRY(read_common(s, suite_params, config->root, c, &job));
  for (const struct kith_config_node *r = resolution->first; r != NULL; r = r->next, last = next) {
    KITH_TRY(kith_param_value(&positive, r, &next));
    if (next <= last) return kith_config_fail(r, NULL, "%g after %g: resolutions ascend", next, last);
  }
  KITH_TRY(make_jobs(s, c, &job, kith_config_at(config, "methods"), kith_config_at(config, "over"),
                     "resolution", resolution));
  KITH_TRY(check_exact(s->job, config->root));
  KITH_TRY(read_norms(s, config));
  if (codes == NULL) return KITH_OK;
  KITH_TRY(kith_config_want(codes, KITH_CONFIG_LIST));
  KITH_TRY(kith_resize(&s->code, 0, (size_t)codes->n, sizeof *s->code));
  for (const struct kith_config_node *node = codes->first; node != NULL; node = node->next)
    KITH_TRY(read_code(s, node, &s->code[s->n_codes++]));
  return KITH_OK;
}

kith_status kith_suite_read(struct kith_study *c, const char *subject) {
  struct kith_config *config = NULL;
  KITH_TRY(kith_resize(&c->suite, 0, 1, sizeof *c->suite));
  struct kith_suite *s = &c->suite[c->n++];
  if (kith_suite_is_path(subject))
    snprintf(s->file, sizeof s->file, "%.760s", subject);
  else
    KITH_TRY(find_input(&c->programs, "/suites", "chart: no suite", subject, s->file));
  kith_path_stem(s->file, s->name, sizeof s->name);
  KITH_TRY(kith_config_read(&config, s->file));
  const kith_status status =
      kith_config_at(config, "regions") == NULL
          ? read_suite(s, config, c)
          : kith_config_fail(config->root, NULL,
                             "this is a scene; a chart needs a suite (see kith chart list)");
  kith_config_destroy(&config);
  return status;
}

kith_status kith_suite_list(struct kith_study *study) {
  char names[2048] = "", told[2048];
  add_names(&study->programs, "/suites", names, sizeof names);
  kith_choices_format(names, told, sizeof told);
  printf("%s\nThe first lines of each file in inputs/suites say what it shows and how long it takes.\n\n",
         told);
  kith_params_reference(suite_params, "a file for kith chart", stdout);
  return KITH_OK;
}

static kith_status read_sweep(struct kith_suite *s, const struct kith_config_node *node,
                              const struct kith_config_node *methods, const struct kith_study *c) {
  struct kith_job job;
  *s = (struct kith_suite){.at_most = NAN, .at_least = NAN, .n_measures = 1};
  KITH_TRY(read_common(s, sweep_params, node, c, &job));
  KITH_TRY(check_cell(node, "name"));
  if (isnan(s->at_most) == isnan(s->at_least))
    return kith_config_fail(node, NULL, "sweep %s needs one bound, at_most or at_least", s->name);
  char key[2][128];
  if (kith_measure_parse(s->measure[0], key) == 0)
    return kith_config_fail(kith_config_child(node, "measure"), NULL,
                            "'%s' is no measure: A, A / B or A / B - 1", s->measure[0]);
  const struct kith_config_node *values = kith_config_child(node, "values");
  if (values->kind != KITH_CONFIG_MAP) return make_jobs(s, c, &job, methods, NULL, NULL, values);
  if (values->n != 1) return kith_config_fail(values, NULL, "%d keys; a sweep varies one", values->n);
  return make_jobs(s, c, &job, methods, NULL, values->first->key, values->first);
}

static kith_status read_sweeps(struct kith_study *c, const struct kith_config *config, const char *only) {
  const struct kith_config_node *list = kith_config_at(config, "sweeps"),
                                *methods = kith_config_at(config, "methods");
  char none, names[4096] = "";
  KITH_TRY(kith_params_read(file_params, config->root, &none));
  KITH_TRY(check_list(list, NULL, INT_MAX));
  KITH_TRY(kith_resize(&c->suite, 0, (size_t)list->n, sizeof *c->suite));
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    const struct kith_config_node *child = kith_config_child(node, "name");
    const char *name = child != NULL && child->text != NULL ? child->text : "";
    kith_text_add(names, sizeof names, "|%s", name);
    if (only == NULL || strcmp(name, only) == 0) KITH_TRY(read_sweep(&c->suite[c->n++], node, methods, c));
  }
  return c->n > 0 ? KITH_OK : kith_study_unknown("stress: no sweep", only != NULL ? only : "", names);
}

void kith_sweeps_reference(void) {
  kith_params_reference(file_params, "a file for kith stress", stdout);
}

kith_status kith_sweeps_read(struct kith_study *study, const char *path, const char *only) {
  struct kith_config *config = NULL;
  KITH_TRY(kith_config_read(&config, path));
  const kith_status status = read_sweeps(study, config, only);
  kith_config_destroy(&config);
  return status;
}
