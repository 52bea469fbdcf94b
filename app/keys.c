#include "app/keys.h"
#include "app/expression.h"
#include "app/words.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST_FORMULA = 1000, ROOM = 256 };

static const char *const dimension_keys[] = {"1d", "2d", "3d"};

/* --- one value --- */

/* Is the text a number, finite or not (.nan, .inf, 1e999)? */
static bool is_number(const char *text, double *value) {
  char *end;
  *value = strtod(text, &end);
  if (end != text && *end == '\0') return true;
  *value = NAN;
  return kith_words_find(".nan|.NaN|.NAN|.inf|.Inf|.INF|-.inf|-.Inf|-.INF|+.inf|+.Inf|+.INF", text) >= 0;
}

static kith_status number_of(const struct kith_config_node *node, double *value) {
  if (!is_number(node->text, value))
    return kith_config_fail(node, NULL, "'%.60s' is not a number", node->text);
  return isfinite(*value) ? KITH_OK
                          : kith_config_fail(node, NULL, "%.60s is not a finite number", node->text);
}

/* Is the value in "(a, b]"? "inf" is a bound that any number keeps. */
static bool in_range(const char *range, double value) {
  if (range[0] != '(' && range[0] != '[') return true;
  char *end;
  const double lower = strtod(range + 1, &end);
  const double upper = strtod(end + 1, &end);
  return (range[0] == '(' ? value > lower : value >= lower) && (*end == ')' ? value < upper : value <= upper);
}

static kith_status check_range(const struct kith_key *key, const struct kith_config_node *node,
                               double value) {
  if (in_range(key->allowed, value)) return KITH_OK;
  return kith_config_fail(node, NULL, "%.60s is out of range %s", node->text, key->allowed);
}

static kith_status read_number(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  double value;
  KITH_TRY(number_of(node, &value));
  KITH_TRY(check_range(key, node, value));
  memcpy(into, &value, sizeof value);
  return KITH_OK;
}

static kith_status read_integer(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  double value;
  char *end;
  KITH_TRY(number_of(node, &value));
  const bool wide = key->size == sizeof(uint64_t);
  errno = 0;
  const unsigned long long large = wide ? strtoull(node->text, &end, 10) : 0;
  const long small = wide ? 0 : strtol(node->text, &end, 10);
  if (*end != '\0') return kith_config_fail(node, NULL, "'%.60s' is not a whole number", node->text);
  KITH_TRY(check_range(key, node, value));
  if (errno != 0 || (wide && value < 0) || small > INT32_MAX || small < INT32_MIN)
    return kith_config_fail(node, NULL, "%.60s does not fit a %d-bit integer", node->text, wide ? 64 : 32);
  if (wide)
    memcpy(into, &(uint64_t){large}, sizeof(uint64_t));
  else
    memcpy(into, &(int){(int)small}, sizeof(int));
  return KITH_OK;
}

static kith_status read_bool(const struct kith_config_node *node, void *into) {
  const int word = kith_words_find("false|true|no|yes", node->text);
  if (word < 0) return kith_config_fail_word(node, "true|false");
  memcpy(into, &(bool){word % 2 == 1}, sizeof(bool));
  return KITH_OK;
}

static kith_status read_word(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  const int word = kith_words_find(key->allowed, node->text);
  if (word < 0) return kith_config_fail_word(node, key->allowed);
  if (key->size == sizeof(bool))
    memcpy(into, &(bool){word == 1}, sizeof(bool));
  else
    memcpy(into, &word, sizeof word);
  return KITH_OK;
}

static kith_status read_name(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  if (key->allowed[0] != '\0' && kith_words_find(key->allowed, node->text) < 0)
    return kith_config_fail_word(node, key->allowed);
  const size_t length = strlen(node->text);
  if (length == 0) return kith_config_fail(node, NULL, "an empty name");
  if (length >= key->size)
    return kith_config_fail(node, NULL, "'%.60s' is longer than %zu letters", node->text, key->size - 1);
  memcpy(into, node->text, length + 1);
  return KITH_OK;
}

/* A struct that was read before owns nothing yet: the old value, if any, goes. */
static kith_status read_text(const struct kith_config_node *node, void *into) {
  kith_free(into);
  return kith_text_copy(into, node->text, strlen(node->text));
}

/* A number is handed on with all its digits. */
static kith_status read_expression(const struct kith_config_node *node, void *into) {
  struct kith_expression *expression = NULL;
  char number[32] = "";
  double value;
  if (is_number(node->text, &value)) {
    KITH_TRY(number_of(node, &value));
    snprintf(number, sizeof number, "%.17g", value);
  }
  if (strlen(node->text) > LONGEST_FORMULA)
    return kith_config_fail(node, NULL, "a formula of more than %d characters", LONGEST_FORMULA);
  if (kith_expression_create(&expression, number[0] != '\0' ? number : node->text) != KITH_OK)
    return kith_config_fail(node, NULL, "%s", kith_failure());
  memcpy(into, &expression, sizeof expression);
  return KITH_OK;
}

static kith_status read_scalar(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  if (node->kind != KITH_CONFIG_SCALAR)
    return kith_config_fail(node, NULL, "a %s where a single value belongs",
                            node->kind == KITH_CONFIG_MAP ? "map" : "list");
  if (node->null) return kith_config_fail(node, NULL, "has no value");
  switch (key->kind) {
    case KITH_KEY_NUMBER:
      return read_number(key, node, into);
    case KITH_KEY_INTEGER:
      return read_integer(key, node, into);
    case KITH_KEY_BOOL:
      return read_bool(node, into);
    case KITH_KEY_WORD:
      return read_word(key, node, into);
    case KITH_KEY_NAME:
      return read_name(key, node, into);
    case KITH_KEY_TEXT:
      return read_text(node, into);
    case KITH_KEY_EXPRESSION:
      return read_expression(node, into);
    default:
      KITH_FAIL(INTERNAL, "%s is not read as a single value", key->key);
  }
}

/* {1d: .., 2d: .., 3d: ..}: the value of this dimension; those of the others are checked as far as they need
 * no memory. */
static kith_status read_by_dimension(const struct kith_key *key, const struct kith_config_node *node,
                                     void *into) {
  char unused[ROOM];
  const bool owned = key->kind == KITH_KEY_TEXT || key->kind == KITH_KEY_EXPRESSION;
  const struct kith_config_node *mine = kith_config_child(node, dimension_keys[NDIM - 1]);
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    if (kith_words_find("1d|2d|3d", child->key) < 0)
      return kith_config_fail(child, NULL, "unknown key; 1d, 2d and 3d tell dimensions apart");
    if (child == mine || !(owned || child->null))
      KITH_TRY(read_scalar(key, child, child == mine ? into : unused));
  }
  if (mine != NULL) return KITH_OK;
  return kith_config_fail(node, dimension_keys[NDIM - 1], "missing, and the scene is %d-D", NDIM);
}

/* --- several numbers --- */

static kith_status want_numbers(const struct kith_config_node *node, int least, int most) {
  KITH_TRY(kith_config_want_list(node));
  if (node->n >= least && node->n <= most) return KITH_OK;
  return least == most ? kith_config_fail(node, NULL, "%d entries, wanted %d", node->n, most)
                       : kith_config_fail(node, NULL, "%d entries, wanted %d to %d", node->n, least, most);
}

/* The first n entries; all are checked. */
static kith_status read_numbers(const struct kith_key *key, const struct kith_config_node *node, int n,
                                double *into) {
  const struct kith_key number = {.key = key->key, .kind = KITH_KEY_NUMBER, .allowed = key->allowed};
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    double value;
    KITH_TRY(read_scalar(&number, child, &value));
    if (child->index < n) into[child->index] = value;
  }
  return KITH_OK;
}

static kith_status read_interval(const struct kith_key *key, const struct kith_config_node *node,
                                 double *into) {
  KITH_TRY(want_numbers(node, 2, 2));
  KITH_TRY(read_numbers(key, node, 2, into));
  if (into[0] < into[1]) return KITH_OK;
  return kith_config_fail(node, NULL, "[%g, %g] is empty: the first must be below the second", into[0],
                          into[1]);
}

static kith_status read_sides(const struct kith_key *key, const struct kith_config_node *node, double *into) {
  if (node->kind == KITH_CONFIG_LIST) {
    KITH_TRY(want_numbers(node, 2, 2));
    return read_numbers(key, node, 2, into);
  }
  struct kith_key number = *key;
  number.kind = KITH_KEY_NUMBER;
  KITH_TRY(kith_key_value(&number, node, into));
  into[1] = into[0];
  return KITH_OK;
}

/* --- rows --- */

kith_status kith_config_want_map(const struct kith_config_node *node) {
  if (node->kind == KITH_CONFIG_MAP) return KITH_OK;
  if (node->kind == KITH_CONFIG_LIST) return kith_config_fail(node, NULL, "a list where a map belongs");
  return kith_config_fail(node, NULL, "'%.60s' where a map belongs", node->null ? "" : node->text);
}

kith_status kith_config_want_list(const struct kith_config_node *node) {
  if (node->kind == KITH_CONFIG_LIST) return KITH_OK;
  if (node->kind == KITH_CONFIG_MAP) return kith_config_fail(node, NULL, "a map where a list belongs");
  return kith_config_fail(node, NULL, "'%.60s' where a list belongs", node->null ? "" : node->text);
}

kith_status kith_key_value(const struct kith_key *key, const struct kith_config_node *node, void *into) {
  switch (key->kind) {
    case KITH_KEY_VECTOR:
      KITH_TRY(want_numbers(node, NDIM, 3));
      return read_numbers(key, node, NDIM, into);
    case KITH_KEY_INTERVAL:
      return read_interval(key, node, into);
    case KITH_KEY_SIDES:
      return read_sides(key, node, into);
    default:
      return node->kind == KITH_CONFIG_MAP ? read_by_dimension(key, node, into)
                                           : read_scalar(key, node, into);
  }
}

static kith_status read_default(const struct kith_key *key, void *into) {
  if (key->fallback[0] == '\0') return KITH_OK;
  if (key->kind == KITH_KEY_VECTOR) { /* the only default of a vector */
    memset(into, 0, key->size);
    return KITH_OK;
  }
  char text[ROOM];
  snprintf(text, sizeof text, "%s", key->fallback);
  struct kith_config_node node = {.kind = KITH_CONFIG_SCALAR, .text = text, .place = {"default", 1}};
  return read_scalar(key, &node, into);
}

kith_status kith_key_read(const struct kith_key *key, const struct kith_config_node *map, void *base) {
  const struct kith_config_node *node = kith_config_child(map, key->key);
  void *into = (char *)base + key->offset;
  if (node == NULL && key->fallback == NULL && map != NULL)
    return kith_config_fail(map, key->key, "missing; it is required");
  if (key->kind == KITH_KEY_OTHER) return KITH_OK;
  if (key->kind == KITH_KEY_MAP) return kith_keys_read(key->keys, node, base);
  return node == NULL ? read_default(key, into) : kith_key_value(key, node, into);
}

/* Words make no difference between '_' and '-'; keys do. */
static const char *spelled(const struct kith_key *keys, const char *word) {
  for (; keys->key != NULL; ++keys)
    if (kith_words_find(keys->key, word) == 0) return keys->key;
  return word;
}

static kith_status refuse_unknown(const struct kith_key *keys, const struct kith_config_node *map) {
  char words[512] = "", all[512] = "", near[64];
  for (const struct kith_key *k = keys; k->key != NULL; ++k) {
    snprintf(words + strlen(words), sizeof words - strlen(words), "|%s", k->key);
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", k > keys ? ", " : "", k->key);
  }
  for (const struct kith_config_node *child = map->first; child != NULL; child = child->next) {
    if (kith_keys_find(keys, child->key) != NULL) continue;
    if (kith_words_nearest(words, child->key, near, sizeof near))
      return kith_config_fail(child, NULL, "unknown key; did you mean '%s'?", spelled(keys, near));
    return kith_config_fail(child, NULL, "unknown key; known are %s", all);
  }
  return KITH_OK;
}

kith_status kith_keys_read(const struct kith_key *keys, const struct kith_config_node *map, void *base) {
  if (map != NULL) {
    KITH_TRY(kith_config_want_map(map));
    KITH_TRY(refuse_unknown(keys, map));
  }
  for (const struct kith_key *k = keys; k->key != NULL; ++k) KITH_TRY(kith_key_read(k, map, base));
  return KITH_OK;
}

const struct kith_key *kith_keys_find(const struct kith_key *keys, const char *name) {
  for (; keys->key != NULL; ++keys)
    if (strcmp(keys->key, name) == 0) return keys;
  return NULL;
}

/* --- the reference --- */

static void print_keys(const struct kith_key *keys, int indent, bool item, FILE *file);

/* "required; what it means; in (0, 1]" */
static void print_comment(const struct kith_key *key, int written, FILE *file) {
  char words[ROOM];
  const bool range = key->allowed[0] == '(' || key->allowed[0] == '[', any = key->allowed[0] == '\0';
  kith_words_tell(key->allowed, words, sizeof words);
  fprintf(file, "%*s# %s%s", KITH_MAX(1, 36 - written), "", key->fallback == NULL ? "required; " : "",
          key->doc);
  fprintf(file, "%s%s\n", any ? "" : range ? "; in " : "; one of ", words);
}

static void print_key(const struct kith_key *key, int indent, bool item, FILE *file) {
  const char *value = key->fallback == NULL ? "" : key->fallback;
  const int written = fprintf(file, "%*s%s%s:%s%s", item ? indent - 2 : indent, "", item ? "- " : "",
                              key->key, value[0] != '\0' ? " " : "", value);
  print_comment(key, written, file);
  if (key->keys == NULL) return;
  if (key->form == KITH_FORM_NAMED) fprintf(file, "%*sNAME:\n", indent + 2, "");
  print_keys(key->keys, key->form == KITH_FORM_MAP || key->form == KITH_FORM_VALUE ? indent + 2 : indent + 4,
             key->form == KITH_FORM_LIST, file);
}

static void print_keys(const struct kith_key *keys, int indent, bool item, FILE *file) {
  for (const struct kith_key *k = keys; k->key != NULL; ++k) print_key(k, indent, item && k == keys, file);
}

void kith_keys_reference(const struct kith_key *keys, FILE *file) {
  print_keys(keys, 0, false, file);
}
