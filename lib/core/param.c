/* Parameters by table: text to values and back, defaults, ranges. */
#include "lib/core/param.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "lib/core/choices.h"

enum { LONGEST = 512 };

struct kith_member kith_family_member(kith_family *family, const char *name) {
  int k = 0;
  while (family(k).name != NULL && !kith_name_is(family(k).name, name, strlen(name))) ++k;
  return family(k);
}

void kith_family_choices(kith_family *family, char *choices, size_t size) {
  size_t used = 0;
  choices[0] = '\0';
  for (int k = 0; family(k).name != NULL && used < size; ++k)
    used += (size_t)snprintf(choices + used, size - used, "|%s", family(k).name);
}

const struct kith_param *kith_params_find(const struct kith_param *params, const char *key) {
  for (; params != NULL && params->key != NULL; ++params)
    if (strcmp(params->key, key) == 0) return params;
  return NULL;
}

/* --- text to value --- */

/* Is the value in "(a, b]"? "inf" is a bound that any number keeps. */
static bool in_range(const char *range, double value) {
  if (range[0] != '(' && range[0] != '[') return true;
  char *end;
  const double lower = strtod(range + 1, &end);
  const double upper = strtod(end + 1, &end);
  return (range[0] == '(' ? value > lower : value >= lower) && (*end == ')' ? value < upper : value <= upper);
}

static kith_status check_range(const struct kith_param *param, const char *text, double value) {
  if (in_range(param->allowed, value)) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "%.60s is out of range %s", text, param->allowed);
}

/* Is it one of YAML's words for numbers that are not finite? */
static bool is_special(const char *text) {
  return kith_choices_index(".nan|.NaN|.NAN|.inf|.Inf|.INF|-.inf|-.Inf|-.INF|+.inf|+.Inf|+.INF", text) >= 0;
}

bool kith_param_is_number(const char *text) {
  char *end;
  (void)strtod(text, &end);
  return (end != text && *end == '\0') || is_special(text);
}

static kith_status parse_number(const struct kith_param *param, const char *text, void *into) {
  const double value = strtod(text, NULL);
  if (!kith_param_is_number(text)) KITH_FAIL(BAD_INPUT, "'%.60s' is not a number", text);
  if (is_special(text) || !isfinite(value)) KITH_FAIL(BAD_INPUT, "%.60s is not a finite number", text);
  KITH_TRY(check_range(param, text, value));
  memcpy(into, &value, sizeof value);
  return KITH_OK;
}

static kith_status parse_integer(const struct kith_param *param, const char *text, void *into) {
  const struct kith_param any = {.allowed = ""};
  const bool wide = param->size == sizeof(uint64_t);
  double value;
  char *end;
  KITH_TRY(parse_number(&any, text, &value));
  errno = 0;
  const unsigned long long large = wide ? strtoull(text, &end, 10) : 0;
  const long small = wide ? 0 : strtol(text, &end, 10);
  if (*end != '\0') KITH_FAIL(BAD_INPUT, "'%.60s' is not a whole number", text);
  KITH_TRY(check_range(param, text, value));
  if (errno != 0 || (wide && value < 0) || small > INT32_MAX || small < INT32_MIN)
    KITH_FAIL(BAD_INPUT, "%.60s does not fit a %d-bit integer", text, wide ? 64 : 32);
  if (wide)
    memcpy(into, &(uint64_t){large}, sizeof(uint64_t));
  else
    memcpy(into, &(int){(int)small}, sizeof(int));
  return KITH_OK;
}

/* Position among the choices, or BAD_INPUT with the nearest of them. */
static kith_status find_choice(const char *choices, const char *text, int *index) {
  char all[LONGEST], near[64];
  *index = kith_choices_index(choices, text);
  if (*index >= 0) return KITH_OK;
  kith_choices_format(choices, all, sizeof all);
  if (kith_choices_suggest(choices, text, near, sizeof near))
    KITH_FAIL(BAD_INPUT, "'%.60s' is not one of %s; did you mean '%s'?", text, all, near);
  KITH_FAIL(BAD_INPUT, "'%.60s' is not one of %s", text, all);
}

static kith_status parse_bool(const struct kith_param *param, const char *text, void *into) {
  (void)param;
  int index = kith_choices_index("true|false|yes|no", text);
  if (index < 0) KITH_TRY(find_choice("true|false", text, &index));
  memcpy(into, &(bool){index % 2 == 0}, sizeof(bool));
  return KITH_OK;
}

static kith_status parse_choice(const struct kith_param *param, const char *text, void *into) {
  int index;
  KITH_TRY(find_choice(param->allowed, text, &index));
  if (param->size == sizeof(bool))
    memcpy(into, &(bool){index == 1}, sizeof(bool));
  else
    memcpy(into, &index, sizeof index);
  return KITH_OK;
}

static kith_status find_member(kith_family *family, const char *name, int *member) {
  char choices[LONGEST];
  kith_family_choices(family, choices, sizeof choices);
  return find_choice(choices, name, member);
}

/* The name in "NAME: KEY=VALUE ...", without the blanks around it. Returns what follows the colon. */
static char *split_name(char *text, char **name) {
  char *colon = strchr(text, ':');
  *name = text + strspn(text, " ");
  if (colon != NULL) *colon = '\0';
  for (size_t n = strlen(*name); n > 0 && (*name)[n - 1] == ' ';) (*name)[--n] = '\0';
  return colon != NULL ? colon + 1 : NULL;
}

/* "displacement | entity-change", "padded:width=64". */
static kith_status find_members(kith_family *family, const char *text) {
  char part[LONGEST], *name;
  const char *word;
  size_t length;
  int member;
  while (kith_next_word(&text, &word, &length)) {
    snprintf(part, sizeof part, "%.*s", (int)length, word);
    split_name(part, &name);
    KITH_TRY(find_member(family, name, &member));
  }
  return KITH_OK;
}

static kith_status parse_name(const struct kith_param *param, const char *text, void *into) {
  const size_t length = strlen(text), most = param->kind == KITH_PARAM_MEMBER
                                                 ? sizeof((struct kith_selected *)into)->name - 1
                                                 : param->size - 1;
  int index;
  if (param->kind == KITH_PARAM_MEMBER) KITH_TRY(find_member(param->family, text, &index));
  if (param->kind == KITH_PARAM_NAME && param->family != NULL) KITH_TRY(find_members(param->family, text));
  if (param->allowed[0] != '\0') KITH_TRY(find_choice(param->allowed, text, &index));
  if (length == 0) KITH_FAIL(BAD_INPUT, "an empty name");
  if (length > most) KITH_FAIL(BAD_INPUT, "'%.60s' is longer than %zu letters", text, most);
  memcpy(into, text, length + 1); /* the name of a struct kith_selected stands first */
  return KITH_OK;
}

/* "[a, b]", or without brackets. */
static kith_status parse_numbers(const struct kith_param *param, const char *text, void *values) {
  double *into = values;
  char copy[LONGEST];
  const int wanted = (int)(param->size / sizeof(double));
  int n = 0;
  snprintf(copy, sizeof copy, "%s", text);
  for (char *rest = copy, *word; (word = strtok_r(rest, "[], ", &rest)) != NULL; ++n) {
    double value;
    KITH_TRY(parse_number(param, word, &value));
    if (n < wanted) into[n] = value;
  }
  if (param->kind == KITH_PARAM_SIDES && n == 1) into[1] = into[0], n = 2;
  if (n < wanted || (n > wanted && (param->kind != KITH_PARAM_VECTOR || n > 3)))
    KITH_FAIL(BAD_INPUT, "%d entries, wanted %d", n, wanted);
  if (param->kind == KITH_PARAM_INTERVAL && !(into[0] < into[1]))
    KITH_FAIL(BAD_INPUT, "[%g, %g] is empty: the first must be below the second", into[0], into[1]);
  return KITH_OK;
}

kith_status kith_param_parse(const struct kith_param *param, const char *text, void *into) {
  static kith_status (*const parse[])(const struct kith_param *, const char *, void *) = {
      [KITH_PARAM_NUMBER] = parse_number,  [KITH_PARAM_INTEGER] = parse_integer,
      [KITH_PARAM_BOOL] = parse_bool,      [KITH_PARAM_CHOICE] = parse_choice,
      [KITH_PARAM_NAME] = parse_name,      [KITH_PARAM_MEMBER] = parse_name,
      [KITH_PARAM_VECTOR] = parse_numbers, [KITH_PARAM_INTERVAL] = parse_numbers,
      [KITH_PARAM_SIDES] = parse_numbers,  [KITH_PARAM_OTHER] = NULL};
  if (parse[param->kind] == NULL) KITH_FAIL(INTERNAL, "%s is not read from text", param->key);
  return parse[param->kind](param, text, into);
}

/* --- value to text --- */

/* The shortest text that gives the same double. */
static void format_number(double value, char *text, size_t size) {
  for (int digits = 6; digits <= 17; ++digits) {
    snprintf(text, size, "%.*g", digits, value);
    if (strtod(text, NULL) == value) return;
  }
}

static void format_numbers(int n, const double *value, char *text, size_t size) {
  size_t used = (size_t)snprintf(text, size, "[");
  for (int k = 0; k < n && used + 32 < size; ++k) {
    char number[32];
    format_number(value[k], number, sizeof number);
    used += (size_t)snprintf(text + used, size - used, "%s%s", number, k < n - 1 ? ", " : "]");
  }
}

static void format_choice(const char *choices, int index, char *text, size_t size) {
  const char *p = choices + strspn(choices, "|");
  for (; index > 0; --index) p += strcspn(p, "|"), p += strspn(p, "|");
  snprintf(text, size, "%.*s", (int)strcspn(p, "|"), p);
  for (char *c = text; (c = strchr(c, '_')) != NULL;) *c = '-'; /* as scenes and lists write it */
}

void kith_param_format(const struct kith_param *param, const void *base, char *text, size_t size) {
  const void *value = (const char *)base + param->offset;
  const bool narrow = param->size == sizeof(bool);
  text[0] = '\0';
  if (param->kind == KITH_PARAM_NUMBER)
    format_number(*(const double *)value, text, size);
  else if (param->kind == KITH_PARAM_INTEGER && param->size == sizeof(uint64_t))
    snprintf(text, size, "%llu", (unsigned long long)*(const uint64_t *)value);
  else if (param->kind == KITH_PARAM_INTEGER)
    snprintf(text, size, "%d", *(const int *)value);
  else if (param->kind == KITH_PARAM_BOOL)
    snprintf(text, size, "%s", *(const bool *)value ? "true" : "false");
  else if (param->kind == KITH_PARAM_CHOICE)
    format_choice(param->allowed, narrow ? *(const bool *)value : *(const int *)value, text, size);
  else if (param->kind == KITH_PARAM_NAME || param->kind == KITH_PARAM_MEMBER)
    snprintf(text, size, "%s", (const char *)value); /* the name stands first */
  else if (param->kind >= KITH_PARAM_VECTOR && param->kind <= KITH_PARAM_SIDES)
    format_numbers((int)(param->size / sizeof(double)), value, text, size);
}

/* --- whole tables --- */

static bool is_real(const struct kith_param *param) {
  return param->kind == KITH_PARAM_NUMBER ||
         (param->kind >= KITH_PARAM_VECTOR && param->kind <= KITH_PARAM_SIDES);
}

void kith_params_clear(const struct kith_param *params, void *base) {
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    void *value = (char *)base + p->offset;
    if (p->kind == KITH_PARAM_MAP) kith_params_clear(p->params, base);
    if (p->kind == KITH_PARAM_MEMBER) kith_free(&((struct kith_selected *)value)->settings);
  }
}

kith_status kith_params_defaults(const struct kith_param *params, void *base) {
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    double *number = (double *)((char *)base + p->offset);
    if (p->kind == KITH_PARAM_MAP)
      KITH_TRY(kith_params_defaults(p->params, base));
    else if (p->fallback == NULL && is_real(p))
      for (size_t k = 0; k < p->size / sizeof *number; ++k) number[k] = NAN;
    else if (p->fallback != NULL && p->fallback[0] != '\0' && p->kind < KITH_PARAM_MAP &&
             p->kind != KITH_PARAM_EXPRESSION && p->kind != KITH_PARAM_EXPRESSIONS)
      KITH_TRY(kith_param_parse(p, p->fallback, number));
  }
  return KITH_OK;
}

static kith_status check_numbers(const struct kith_param *param, const char *who, const double *value) {
  for (size_t k = 0; k < param->size / sizeof *value; ++k) {
    if (isfinite(value[k]) && in_range(param->allowed, value[k])) continue;
    char index[24] = "";
    if (param->size > sizeof *value) snprintf(index, sizeof index, "[%zu]", k);
    KITH_FAIL(BAD_INPUT, "%s: %s%s is %g, must be %s%s", who, param->key, index, value[k],
              param->allowed[0] != '\0' ? "in " : "finite", param->allowed);
  }
  return KITH_OK;
}

kith_status kith_params_check(const struct kith_param *params, const char *who, const void *base) {
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    const void *value = (const char *)base + p->offset;
    if (p->kind == KITH_PARAM_MAP) KITH_TRY(kith_params_check(p->params, who, base));
    if (is_real(p)) KITH_TRY(check_numbers(p, who, value));
    if (p->kind == KITH_PARAM_INTEGER && p->size == sizeof(int) && !in_range(p->allowed, *(const int *)value))
      KITH_FAIL(BAD_INPUT, "%s: %s is %d, must be in %s", who, p->key, *(const int *)value, p->allowed);
    if (p->kind == KITH_PARAM_NAME && p->fallback == NULL && *(const char *)value == '\0')
      KITH_FAIL(BAD_INPUT, "%s: %s is missing: %s:%s=...", who, p->key, who, p->key);
  }
  return KITH_OK;
}

static kith_status assign(const struct kith_member *member, char *assignment, void *settings) {
  char *value = strchr(assignment, '=');
  if (value == NULL) KITH_FAIL(BAD_INPUT, "%s: %s: write it as key=value", member->name, assignment);
  *value++ = '\0';
  const struct kith_param *params = member->params, *param;
  char *key = assignment; /* "viscosity.alpha": a row of the map "viscosity" */
  for (char *dot; (dot = strchr(key, '.')) != NULL; *dot = '.', key = dot + 1) {
    *dot = '\0';
    param = kith_params_find(params, key);
    params = param != NULL ? param->params : NULL;
  }
  param = kith_params_find(params, key);
  if (param == NULL) KITH_FAIL(BAD_INPUT, "%s has no parameter %s", member->name, assignment);
  if (kith_param_parse(param, value, (char *)settings + param->offset) == KITH_OK) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "%s: %s: %s", member->name, assignment, kith_failure());
}

kith_status kith_settings_create(void **out, struct kith_member member, const char *assignments) {
  char text[4 * LONGEST];
  kith_status status = KITH_OK;
  *out = NULL;
  if (member.params != NULL) {
    KITH_TRY(kith_resize(out, 0, 1, member.settings_size));
    status = kith_params_defaults(member.params, *out);
  }
  snprintf(text, sizeof text, "%s", assignments != NULL ? assignments : "");
  for (char *rest = text, *word; status == KITH_OK && (word = strtok_r(rest, " ", &rest)) != NULL;)
    status = assign(&member, word, *out);
  if (status == KITH_OK) return KITH_OK;
  kith_params_clear(member.params, *out);
  kith_free(out);
  return status;
}

kith_status kith_family_choose(kith_family *family, const char *what, const char *text, size_t length,
                               int *member, void **settings) {
  char part[4 * LONGEST], *name;
  *settings = NULL;
  snprintf(part, sizeof part, "%.*s", (int)length, text);
  const char *assignments = split_name(part, &name);
  if (find_member(family, name, member) != KITH_OK) KITH_FAIL(BAD_INPUT, "%s: %s", what, kith_failure());
  const struct kith_member chosen = family(*member);
  KITH_TRY(kith_settings_create(settings, chosen, assignments));
  const kith_status status = kith_params_check(chosen.params, chosen.name, *settings);
  if (status != KITH_OK) kith_free(settings);
  return status;
}

void kith_settings_format(struct kith_member member, const void *settings, char *text, size_t size) {
  char value[LONGEST];
  snprintf(text, size, "%s", member.name);
  for (const struct kith_param *p = member.params; p != NULL && p->key != NULL; ++p) {
    const size_t used = strlen(text);
    kith_param_format(p, settings, value, sizeof value);
    snprintf(text + used, size - used, "%s%s=%s", p == member.params ? ":" : " ", p->key, value);
  }
}
