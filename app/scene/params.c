/* Parameters of a scene: maps of the YAML tree, read by tables. */
#include "app/scene/params.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/scene/expression.h"
#include "lib/core/choices.h"

enum { LONGEST_FORMULA = 1000, ROOM = 512 };

static const char *const dimension_keys[] = {"1d", "2d", "3d"};

/* Reads a formula; a single number is passed to the parser with all its digits. */
static kith_status read_expression(const struct kith_config_node *node, void *into) {
  static const struct kith_param number = {.kind = KITH_PARAM_NUMBER, .allowed = ""};
  struct kith_expression *expression = NULL;
  char digits[32] = "";
  if (strlen(node->text) > LONGEST_FORMULA)
    KITH_FAIL(BAD_INPUT, "a formula of more than %d characters", LONGEST_FORMULA);
  if (kith_param_is_number(node->text)) {
    double value;
    KITH_TRY(kith_param_parse(&number, node->text, &value));
    snprintf(digits, sizeof digits, "%.17g", value);
  }
  KITH_TRY(kith_expression_create(&expression, digits[0] != '\0' ? digits : node->text));
  memcpy(into, &expression, sizeof expression);
  return KITH_OK;
}

/* Reads a number, or a formula without variables, as 5/3. */
static kith_status read_number(const struct kith_param *param, const struct kith_config_node *node,
                               void *into) {
  struct kith_expression *formula = NULL;
  char digits[32];
  if (kith_param_is_number(node->text)) return kith_param_parse(param, node->text, into);
  const kith_status status = read_expression(node, &formula);
  if (status == KITH_BAD_INPUT) return kith_param_parse(param, node->text, into); /* its message */
  KITH_TRY(status);
  const double value = kith_expression_constant(formula);
  kith_expression_destroy(&formula);
  if (!isfinite(value))
    KITH_FAIL(BAD_INPUT, "'%.60s' is not a number: it has variables, or is not finite", node->text);
  snprintf(digits, sizeof digits, "%.17g", value);
  return kith_param_parse(param, digits, into);
}

static kith_status read_scalar(const struct kith_param *param, const struct kith_config_node *node,
                               void *into) {
  KITH_TRY(kith_config_want(node, KITH_CONFIG_SCALAR));
  if (node->null) return kith_config_fail(node, NULL, "has no value");
  const kith_status status = param->kind == KITH_PARAM_EXPRESSION ? read_expression(node, into)
                             : param->kind == KITH_PARAM_NUMBER   ? read_number(param, node, into)
                                                                  : kith_param_parse(param, node->text, into);
  return status == KITH_BAD_INPUT ? kith_config_fail(node, NULL, "%s", kith_failure()) : status;
}

/* Reads {1d: .., 2d: .., 3d: ..}: takes the value of this dimension. The others are only checked, and not
 * even that if they are formulas, which need memory. */
static kith_status read_by_dimension(const struct kith_param *param, const struct kith_config_node *node,
                                     void *into) {
  char unused[ROOM];
  const bool owned = param->kind == KITH_PARAM_EXPRESSION;
  const struct kith_config_node *root = node;
  while (root->parent != NULL) root = root->parent;
  if (root->dimension == 0) return kith_config_want(node, KITH_CONFIG_SCALAR);
  const char *key = dimension_keys[root->dimension - 1];
  const struct kith_config_node *mine = kith_config_child(node, key);
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (kith_choices_index("1d|2d|3d", child->key) < 0)
      return strchr(child->key, '?') != NULL
                 ? kith_config_fail(node, NULL, "a formula with a colon needs quotes")
                 : kith_config_fail(child, NULL, "unknown key; 1d, 2d and 3d tell dimensions apart");
    if (child == mine || !(owned || child->null))
      KITH_TRY(read_scalar(param, child, child == mine ? into : unused));
  }
  if (mine != NULL) return KITH_OK;
  return kith_config_fail(node, key, "missing, and the scene is %d-D", root->dimension);
}

/* Reads as many entries as `into` holds. Vectors may have more, up to 3, which are checked and dropped. */
static kith_status read_entries(const struct kith_param *param, const struct kith_config_node *node,
                                void *into) {
  union {
    double number;
    struct kith_expression *formula;
  } *kept = into, unused;
  const bool formulas = param->kind == KITH_PARAM_EXPRESSIONS,
             vector = formulas || param->kind == KITH_PARAM_VECTOR;
  const struct kith_param entry = {.kind = formulas ? KITH_PARAM_EXPRESSION : KITH_PARAM_NUMBER,
                                   .allowed = param->allowed};
  const int n = (int)(param->size / sizeof unused), most = vector ? 3 : n;
  char wanted[16] = "";
  KITH_TRY(kith_config_want(node, KITH_CONFIG_LIST));
  if (n < most) snprintf(wanted, sizeof wanted, "%d to ", n);
  if (node->n < n || node->n > most)
    return kith_config_fail(node, NULL, "%d entries, wanted %s%d", node->n, wanted, most);
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    KITH_TRY(read_scalar(&entry, child, child->index < n ? &kept[child->index] : &unused));
    if (formulas && child->index >= n) kith_expression_destroy(&unused.formula);
  }
  if (param->kind != KITH_PARAM_INTERVAL || kept[0].number < kept[1].number) return KITH_OK;
  return kith_config_fail(node, NULL, "[%g, %g] is empty: the first must be below the second", kept[0].number,
                          kept[1].number);
}

kith_status kith_param_value(const struct kith_param *param, const struct kith_config_node *node,
                             void *into) {
  const bool map = node->kind == KITH_CONFIG_MAP, sides = param->kind == KITH_PARAM_SIDES;
  struct kith_param single = *param;
  if (param->kind >= KITH_PARAM_EXPRESSIONS && param->kind <= KITH_PARAM_SIDES &&
      !(sides && node->kind != KITH_CONFIG_LIST))
    return read_entries(param, node, into);
  if (sides) single.kind = KITH_PARAM_NUMBER;
  KITH_TRY(map ? read_by_dimension(&single, node, into) : read_scalar(&single, node, into));
  if (sides) memcpy((double *)into + 1, into, sizeof(double));
  return KITH_OK;
}

/* The default of a row. If it is {1d: a, 2d: b, 3d: c}, that for the dimension of the scene, copied to
 * `text`. */
static const char *default_of(const struct kith_param *param, const struct kith_config_node *node,
                              char text[64]) {
  if (param->fallback == NULL || param->fallback[0] != '{') return param->fallback;
  while (node->parent != NULL) node = node->parent;
  sscanf(strstr(param->fallback, dimension_keys[node->dimension - 1]), "%*[^:]: %63[^,}]", text);
  return text;
}

kith_status kith_param_read(const struct kith_param *param, const struct kith_config_node *map, void *base) {
  const struct kith_config_node *node = kith_config_child(map, param->key);
  void *into = (char *)base + param->offset;
  if (node == NULL && param->fallback == NULL && map != NULL)
    return kith_config_fail(map, param->key, "missing; it is required");
  if (param->kind == KITH_PARAM_OTHER) return KITH_OK;
  if (param->kind == KITH_PARAM_MAP) return kith_params_read(param->params, node, base);
  if (node != NULL) return kith_param_value(param, node, into);
  const bool formulas = param->kind == KITH_PARAM_EXPRESSION || param->kind == KITH_PARAM_EXPRESSIONS;
  const bool fixed = param->fallback != NULL && param->fallback[0] != '\0' && !formulas;
  char text[64];
  return fixed ? kith_param_parse(param, default_of(param, map, text), into) : KITH_OK;
}

kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension) {
  static const struct kith_param param = {KITH_DIMENSION_PARAM, .size = sizeof(int)};
  struct kith_config *config;
  char near[16];
  KITH_TRY(kith_config_read(&config, path));
  kith_status status = KITH_OK;
  for (int k = 0; k < n_overrides && status == KITH_OK; ++k)
    status = kith_config_override(config, overrides[k]);
  const bool missing = status == KITH_OK && kith_config_child(config->root, param.key) == NULL;
  for (const struct kith_config_node *c = missing ? config->root->first : NULL; c != NULL; c = c->next)
    if (status == KITH_OK && !kith_name_is(c->key, param.key, strlen(param.key)) &&
        kith_choices_suggest(param.key, c->key, near, sizeof near))
      status = kith_config_fail(c, NULL, "unknown key; did you mean '%s'?", near);
  if (status == KITH_OK) status = kith_param_read(&param, config->root, dimension);
  kith_config_destroy(&config);
  return status;
}

void kith_params_clear_formulas(const struct kith_param *params, void *base) {
  for (; base != NULL && params != NULL && params->key != NULL; ++params) {
    if (params->kind == KITH_PARAM_MAP) kith_params_clear_formulas(params->params, base);
    if (params->kind == KITH_PARAM_EXPRESSION || params->kind == KITH_PARAM_EXPRESSIONS)
      for (size_t at = 0; at < params->size; at += sizeof(struct kith_expression *))
        kith_expression_destroy((struct kith_expression **)((char *)base + params->offset + at));
  }
}

static const struct kith_param *find_chooser(const struct kith_param *params) {
  for (; params != NULL && params->key != NULL; ++params)
    if (params->kind == KITH_PARAM_MEMBER) return params;
  return NULL;
}

/* Iterates over all rows that a map may have: of the table, then of each member that can be chosen. */
struct rows {
  const struct kith_param *next;
  kith_family *family; /* NULL: none can be chosen */
  int members;         /* how many were begun */
};

static struct rows rows_of(const struct kith_param *params) {
  const struct kith_param *chooser = find_chooser(params);
  return (struct rows){params, chooser != NULL ? chooser->family : NULL, 0};
}

static const struct kith_param *next_row(struct rows *r) {
  while (r->next == NULL || r->next->key == NULL) {
    if (r->family == NULL || r->family(r->members).name == NULL) return NULL;
    r->next = r->family(r->members++).params;
  }
  return r->next++;
}

/* Adds the maps that have the key, in the table of `map` and below it: "method.viscosity, materials.NAME". */
static void find_maps(const struct kith_param *params, const char *map, const char *key, char *maps,
                      size_t size) {
  static const char *const entry[] = {"", "", ".NAME", ".N"}; /* by form */
  const struct kith_param *p, *last = NULL;
  const char *name = map[0] != '\0' ? map : "the scene itself";
  for (struct rows r = rows_of(params); (p = next_row(&r)) != NULL; last = p->params) {
    char below[ROOM];
    const size_t used = strlen(maps), length = strlen(name);
    const bool told = used >= length && strcmp(maps + used - length, name) == 0;
    if (strcmp(p->key, key) == 0 && !told) kith_text_join(maps, size, ", ", "%s", name);
    if (p->params == NULL || p->params == last) continue; /* the three axes have the same rows */
    snprintf(below, sizeof below, "%s%s%s%s", map, map[0] != '\0' ? "." : "", p->key, entry[p->form]);
    find_maps(p->params, below, key, maps, size);
  }
}

/* Choices are shown with '-', keys are written with '_'. */
static void with_underscores(char *keys) {
  for (; (keys = strchr(keys, '-')) != NULL;) *keys = '_';
}

/* BAD_INPUT for a key that no row has, with the maps of the scene that have it. Members may share keys: the
 * message names each once. */
static kith_status check_key(const struct kith_param *params, const struct kith_config_node *child) {
  char known[512] = "", told[512], maps[ROOM] = "", map[256], why[ROOM + 300] = "unknown key";
  const struct kith_config_node *root = child;
  const struct kith_param *p;
  for (struct rows r = rows_of(params); (p = next_row(&r)) != NULL;) {
    if (strcmp(p->key, child->key) == 0) return KITH_OK;
    if (kith_choices_index(known, p->key) < 0) kith_text_add(known, sizeof known, "|%s", p->key);
  }
  while (root->parent != NULL) root = root->parent;
  find_maps(root->params, "", child->key, maps, sizeof maps);
  kith_config_path(child->parent, NULL, map, sizeof map);
  if (maps[0] != '\0')
    snprintf(why, sizeof why, "not a key of %s, but of %s", map[0] != '\0' ? map : "the scene itself", maps);
  const bool near = kith_choices_suggest(known, child->key, told, sizeof told);
  if (!near) kith_choices_format(known, told, sizeof told);
  with_underscores(told);
  if (near) return kith_config_fail(child, NULL, "%s; did you mean '%s'?", why, told);
  return maps[0] != '\0' ? kith_config_fail(child, NULL, "%s", why)
                         : kith_config_fail(child, NULL, "%s; known are %s", why, told);
}

/* Do two members mean the same by a key? A gamma may be no ratio of specific heats. */
static bool is_alike(const struct kith_param *a, const struct kith_param *b) {
  const char *const one = a->fallback, *const other = b->fallback; /* NULL: required */
  if (one == NULL || other == NULL ? one != other : strcmp(one, other) != 0) return false;
  return strcmp(a->doc, b->doc) == 0 && strcmp(a->allowed, b->allowed) == 0;
}

/* Appends to `names` the members of the family that have the key, "mfm, sph"; if `row` is not NULL only those
 * that mean the same by it. Returns whether `member` is the first of them. */
static bool list_owners(const char *key, const struct kith_param *row, kith_family *family, int member,
                        char *names, size_t size) {
  int first = -1;
  for (int k = 0; family(k).name != NULL; ++k) {
    const struct kith_param *own = kith_params_find(family(k).params, key);
    if (own == NULL || (row != NULL && !is_alike(row, own))) continue;
    if (first < 0) first = k;
    kith_text_join(names, size, ", ", "%s", family(k).name);
  }
  return first == member;
}

/* Checks a value that the chosen member does not have, but other members do. It is refused, unless the member
 * was chosen in a later layer, as by --set: then it is dropped, so that one scene serves all members. */
static kith_status check_other(const struct kith_param *chooser, struct kith_member chosen,
                               const struct kith_config_node *map, struct kith_config_node *child) {
  char owners[ROOM] = "";
  const struct kith_config_node *choice = kith_config_child(map, chooser->key);
  if (child->null || kith_params_find(chosen.params, child->key) != NULL) return KITH_OK;
  list_owners(child->key, NULL, chooser->family, 0, owners, sizeof owners);
  if (owners[0] == '\0') return KITH_OK;
  if (!kith_config_is_older(child, choice))
    return kith_config_fail(child, NULL, "means nothing for %s, only for %s", chosen.name, owners);
  kith_config_drop(child);
  return KITH_OK;
}

/* The row on whose value it depends whether row `p` means something. */
static const struct kith_param *needed_row(const struct kith_param *params, const struct kith_param *p) {
  char key[ROOM];
  snprintf(key, sizeof key, "%.*s", (int)strcspn(p->needs, "!="), p->needs);
  return kith_params_find(params, key);
}
/* Does row `p` mean something if the row that it needs has this value? */
static bool holds(const struct kith_param *p, const char *value) {
  const char *wanted = strchr(p->needs, '=');
  return (strcmp(value, wanted + 1) == 0) == (wanted[-1] != '!');
}

/* Refuses a value that means nothing beside the value of another key, or drops it as check_other does. */
static kith_status check_needs(const struct kith_param *params, const struct kith_config_node *map,
                               const void *base) {
  for (struct kith_config_node *child = map != NULL ? map->first : NULL; child != NULL; child = child->next) {
    const struct kith_param *p = kith_params_find(params, child->key);
    char value[ROOM];
    if (p == NULL || p->needs == NULL || child->null) continue;
    const struct kith_param *other = needed_row(params, p);
    kith_param_format(other, base, value, sizeof value);
    if (holds(p, value)) continue;
    if (!kith_config_is_older(child, kith_config_child(map, other->key)))
      return kith_config_fail(child, NULL, "means nothing with %s: %s", other->key, value);
    kith_config_drop(child);
  }
  return KITH_OK;
}

/* Reads the rows of the chosen member from the same map. */
static kith_status read_member(const struct kith_param *params, const struct kith_param *chooser,
                               const struct kith_config_node *map, struct kith_selected *selected) {
  const struct kith_member chosen = kith_family_member(chooser->family, selected->name);
  for (struct kith_config_node *child = map != NULL ? map->first : NULL; child != NULL; child = child->next)
    if (kith_params_find(params, child->key) == NULL) KITH_TRY(check_other(chooser, chosen, map, child));
  const bool made = selected->settings == NULL;
  if (made) KITH_TRY(kith_settings_create(&selected->settings, chosen, NULL));
  for (const struct kith_param *p = chosen.params; p != NULL && p->key != NULL; ++p)
    if (made || kith_config_child(map, p->key) != NULL) KITH_TRY(kith_param_read(p, map, selected->settings));
  return check_needs(chosen.params, map, selected->settings);
}

kith_status kith_params_want_map(const struct kith_param *params, const struct kith_config_node *node) {
  const struct kith_param *chooser = find_chooser(params);
  char path[256], keys[ROOM] = "", told[ROOM];
  if (node->kind != KITH_CONFIG_SCALAR || node->null) return kith_config_want(node, KITH_CONFIG_MAP);
  kith_config_path(node, chooser != NULL ? chooser->key : NULL, path, sizeof path);
  for (const struct kith_param *p = params; p->key != NULL; ++p)
    kith_text_add(keys, sizeof keys, "|%s", p->key);
  kith_choices_format(keys, told, sizeof told);
  with_underscores(told);
  if (chooser == NULL)
    return kith_config_fail(node, NULL, "'%.60s' where a map belongs; its keys are %s", node->text, told);
  return node->location.line == 0
             ? kith_config_fail(node, NULL, "'%.60s' where a map belongs; write %s=%.60s", node->text, path,
                                node->text)
             : kith_config_fail(node, NULL, "'%.60s' where a map belongs; write {%s: %.60s}", node->text,
                                chooser->key, node->text);
}

kith_status kith_params_read(const struct kith_param *params, const struct kith_config_node *map,
                             void *base) {
  const struct kith_param *chooser = find_chooser(params);
  if (map != NULL && map->kind != KITH_CONFIG_MAP) return kith_params_want_map(params, map);
  for (const struct kith_config_node *child = map != NULL ? map->first : NULL; child != NULL;
       child = child->next)
    KITH_TRY(check_key(params, child));
  for (const struct kith_param *p = params; p->key != NULL; ++p) KITH_TRY(kith_param_read(p, map, base));
  KITH_TRY(check_needs(params, map, base));
  if (chooser == NULL) return KITH_OK;
  return read_member(params, chooser, map, (struct kith_selected *)((char *)base + chooser->offset));
}

static bool same_text(const char *a, const char *b) {
  char *end_a, *end_b;
  const double x = strtod(a, &end_a), y = strtod(b, &end_b);
  const bool numbers = end_a != a && *end_a == '\0' && end_b != b && *end_b == '\0';
  return numbers ? x == y : kith_name_is(a, b, strlen(b));
}

/* Is this list of numbers the default vector? */
static bool is_default_vector(const struct kith_param *row, const struct kith_config_node *list) {
  struct kith_param numbers = *row;
  double given[3] = {0}, fallback[3] = {0};
  char *text = NULL;
  if (row->kind != KITH_PARAM_VECTOR && row->kind != KITH_PARAM_EXPRESSIONS) return false;
  numbers.kind = KITH_PARAM_VECTOR;
  if (kith_config_emit(list, true, &text) != KITH_OK) return false;
  text[strcspn(text, "\n")] = '\0';
  const bool parsed = kith_param_parse(&numbers, text, given) == KITH_OK &&
                      kith_param_parse(&numbers, row->fallback, fallback) == KITH_OK;
  kith_free(&text);
  return parsed && memcmp(given, fallback, sizeof given) == 0;
}

/* Is this value, which the other scene does not give, the default? */
static bool is_default(const struct kith_param *row, const struct kith_config_node *value) {
  if (row == NULL || row->fallback == NULL) return false;
  if (value->kind == KITH_CONFIG_LIST) return is_default_vector(row, value);
  char text[64];
  return value->kind == KITH_CONFIG_SCALAR && same_text(value->text, default_of(row, value, text));
}

/* Finds the row of a key in a map: in its table, or in that of the member that either scene chooses. If a
 * restart may choose another member, the keys of that member have the row of the choice, too. */
static const struct kith_param *row_of_key(const struct kith_param *rows, const char *key,
                                           const struct kith_config_node *a,
                                           const struct kith_config_node *b) {
  const struct kith_param *row = kith_params_find(rows, key), *chooser = find_chooser(rows);
  if (row != NULL || chooser == NULL || chooser->restart_may_change) return row != NULL ? row : chooser;
  const struct kith_config_node *named = kith_config_child(a, chooser->key);
  if (named == NULL) named = kith_config_child(b, chooser->key);
  const char *name = named != NULL ? named->text : chooser->fallback;
  return name != NULL ? kith_params_find(kith_family_member(chooser->family, name).params, key) : NULL;
}

/* Finds the first value in `a` that `b` (NULL: not given) does not have as well. `row` describes both, `rows`
 * the entries below them. Sets found[0] to the node of the value in `a`, and found[1] to that in `b`. */
static bool find_difference(const struct kith_param *rows, const struct kith_param *row,
                            const struct kith_config_node *a, const struct kith_config_node *b,
                            const struct kith_config_node *found[2]) {
  const bool named = row != NULL && row->params != NULL && row->form == KITH_FORM_NAMED; /* keys are names */
  /* A boundary is a map {kind: NAME, ...}, or NAME alone, which is the same as {kind: NAME}. */
  const struct kith_param *kind =
      row != NULL && row->form == KITH_FORM_VALUE ? find_chooser(row->params) : NULL;
  if (a->null || (row != NULL && row->restart_may_change)) return false;
  if (kind != NULL && a->kind == KITH_CONFIG_SCALAR && b != NULL && b->kind == KITH_CONFIG_MAP)
    b = kith_config_child(b, kind->key);
  const bool apart = b == NULL ? a->kind == KITH_CONFIG_LIST
                               : a->kind != b->kind && !(kind != NULL && b->kind == KITH_CONFIG_SCALAR);
  if (a->kind == KITH_CONFIG_SCALAR || apart) {
    found[0] = a, found[1] = b;
    return b == NULL ? !is_default(row, a) : apart || !same_text(a->text, b->text);
  }
  for (const struct kith_config_node *child = a->first; child != NULL; child = child->next) {
    char index[16];
    snprintf(index, sizeof index, "%d", child->index);
    const bool is_kind = kind != NULL && child->key != NULL && strcmp(child->key, kind->key) == 0;
    const struct kith_param *below = is_kind || child->key == NULL ? row
                                     : named                       ? NULL
                                                                   : row_of_key(rows, child->key, a, b);
    const struct kith_config_node *other =
        is_kind && b != NULL && b->kind == KITH_CONFIG_SCALAR
            ? b
            : kith_config_child(b, child->key != NULL ? child->key : index);
    if (find_difference(below != NULL ? below->params : rows, below, child, other, found)) return true;
  }
  return false;
}

/* Writes a value on one line, cut where it is long. */
static void show_value(const struct kith_config_node *node, char text[64]) {
  char *whole = NULL;
  snprintf(text, 64, "%s",
           node == NULL         ? "not given"
           : node->text != NULL ? node->text
                                : "another list or map");
  if (node == NULL || node->text != NULL || kith_config_emit(node, true, &whole) != KITH_OK) return;
  snprintf(text, 64, "%.*s", (int)strcspn(whole, "\n"), whole);
  kith_free(&whole);
}

kith_status kith_config_compare(const struct kith_param *params, const struct kith_config_node *now,
                                const struct kith_config_node *then) {
  char path[512], text[2][64];
  const struct kith_config_node *found[2];
  const bool in_now = find_difference(params, NULL, now, then, found);
  if (!in_now && !find_difference(params, NULL, then, now, found)) return KITH_OK;
  show_value(found[!in_now], text[0]), show_value(found[in_now], text[1]);
  kith_config_path(in_now || found[1] == NULL ? found[0] : found[1], NULL, path, sizeof path);
  KITH_FAIL(BAD_INPUT, "written by another scene or with other settings: %s is %s there, and %s now", path,
            text[1], text[0]);
}

static void print_params(const struct kith_param *params, int indent, bool item, FILE *file);

/* Prints "# required; what it means (a, b); in (0, 1]". derives: of a member that derives it. */
static void print_comment(const struct kith_param *param, const char *owners, bool derives, int written,
                          FILE *file) {
  char members[ROOM] = "", choices[ROOM];
  if (param->family != NULL) kith_family_choices(param->family, members, sizeof members);
  const char *allowed = param->family != NULL ? members : param->allowed;
  const bool range = allowed[0] == '(' || allowed[0] == '[';
  kith_choices_format(allowed, choices, sizeof choices);
  fprintf(file, "%*s# %s%s", KITH_MAX(1, 36 - written), "",
          param->fallback != NULL    ? ""
          : derives && !param->given ? "required unless it follows from the scene; "
                                     : "required; ",
          param->doc);
  if (owners[0] != '\0') fprintf(file, " (%s)", owners);
  fprintf(file, "%s%s\n", allowed[0] == '\0' ? "" : range ? "; in " : "; one of ", choices);
}

/* Prints a key. idle: it means something only if other keys do not have their defaults, so that it is
 * commented out. item: it is the first key of an entry of a list. derives: as in kith_param. */
static void print_param(const struct kith_param *param, const char *owners, bool derives, bool idle,
                        int indent, bool item, FILE *file) {
  const char *value = param->fallback == NULL ? "" : param->fallback;
  const int written = fprintf(file, "%*s%s%s:%s%s", item ? indent - 2 : indent, "",
                              item   ? "- "
                              : idle ? "# "
                                     : "",
                              param->key, value[0] != '\0' ? " " : "", value);
  print_comment(param, owners, derives, written, file);
  if (param->params == NULL || param->form == KITH_FORM_VALUE || idle) return;
  if (param->form == KITH_FORM_NAMED) fprintf(file, "%*sNAME:\n", indent + 2, "");
  print_params(param->params, indent + (param->form == KITH_FORM_MAP ? 2 : 4), param->form == KITH_FORM_LIST,
               file);
}

/* Prints the rows of a table and its members; a key of several members once for each of its meanings. */
static void print_params(const struct kith_param *params, int indent, bool item, FILE *file) {
  const struct kith_param *p, *chooser = find_chooser(params);
  const char *chosen = chooser != NULL && chooser->fallback != NULL ? chooser->fallback : "";
  for (struct rows r = rows_of(params); (p = next_row(&r)) != NULL;) {
    char owners[ROOM] = "";
    const bool of_member = r.members > 0;
    if (of_member && !list_owners(p->key, p, r.family, r.members - 1, owners, sizeof owners)) continue;
    const struct kith_param *table = of_member ? r.family(r.members - 1).params : params;
    const struct kith_param *of_chosen =
        of_member ? kith_params_find(kith_family_member(r.family, chosen).params, p->key) : p;
    const bool idle = (p->needs != NULL && !holds(p, needed_row(table, p)->fallback)) || of_chosen == NULL ||
                      !is_alike(p, of_chosen);
    print_param(p, owners, of_member && chooser->derives, idle, indent, item && p == params, file);
  }
}

void kith_params_reference(const struct kith_param *params, const char *what, FILE *file) {
  fprintf(file, "# Every key of %s: its default, what it means, what it may be.\n", what);
  print_params(params, 0, false, file);
}
