#include "app/config.h"
#include "app/words.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <yaml.h>

enum { DEEPEST = 32, MOST_KEYS = 256, LARGEST = 1 << 20 };

kith_status kith_text_copy(char **out, const char *text, size_t length) {
  KITH_TRY(kith_resize(out, 0, length + 1, 1));
  memcpy(*out, text, length);
  return KITH_OK;
}

/* --- messages --- */

static void append_path(const struct kith_config_node *node, char *out, size_t size) {
  if (node->parent == NULL) return;
  append_path(node->parent, out, size);
  const size_t used = strlen(out);
  const char *dot = used > 0 ? "." : "";
  if (node->key != NULL)
    snprintf(out + used, size - used, "%s%.64s", dot, node->key);
  else
    snprintf(out + used, size - used, "%s%d", dot, node->index);
}

/* A message is one line, whatever the file holds. */
static kith_status refuse(char *line) {
  for (char *p = line; *p != '\0'; ++p)
    if ((unsigned char)*p < ' ' || *p == 0x7f) *p = '?';
  KITH_FAIL(BAD_INPUT, "%s", line);
}

static kith_status fail_at(const struct kith_config_node *node, const char *key, const char *format,
                           va_list arguments) {
  char path[256] = "", message[512], line[1024];
  append_path(node, path, sizeof path);
  const size_t used = strlen(path);
  if (key != NULL) snprintf(path + used, sizeof path - used, "%s%.64s", used > 0 ? "." : "", key);
  vsnprintf(message, sizeof message, format, arguments);
  const char *colon = path[0] != '\0' ? ": " : "";
  if (node->place.line > 0)
    snprintf(line, sizeof line, "%.200s:%d: %s%s%s", node->place.file, node->place.line, path, colon,
             message);
  else
    snprintf(line, sizeof line, "--set %s%s%s", path, colon, message);
  return refuse(line);
}

kith_status kith_config_fail(const struct kith_config_node *node, const char *key, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const kith_status status = fail_at(node, key, format, arguments);
  va_end(arguments);
  return status;
}

kith_status kith_config_fail_word(const struct kith_config_node *node, const char *words) {
  char all[256], near[64];
  kith_words_tell(words, all, sizeof all);
  if (kith_words_nearest(words, node->text, near, sizeof near))
    return kith_config_fail(node, NULL, "'%.60s' is not one of %s; did you mean '%s'?", node->text, all,
                            near);
  return kith_config_fail(node, NULL, "'%.60s' is not one of %s", node->text, all);
}

/* --- the tree --- */

static void node_destroy(struct kith_config_node **node);

/* Leaves a null. */
static void node_clear(struct kith_config_node *node) {
  for (struct kith_config_node *child = node->first, *next; child != NULL; child = next) {
    next = child->next;
    node_destroy(&child);
  }
  kith_free(&node->text);
  node->kind = KITH_CONFIG_SCALAR, node->null = true, node->quoted = false;
  node->first = node->last = NULL, node->n = 0;
}

static void node_destroy(struct kith_config_node **node) {
  if (*node == NULL) return;
  node_clear(*node);
  kith_free(&(*node)->key);
  kith_free(node);
}

/* The new child takes *key. */
static kith_status node_add(struct kith_config_node **out, struct kith_config_node *parent,
                            enum kith_config_kind kind, char **key, struct kith_place place) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  **out = (struct kith_config_node){
      .kind = kind, .null = kind == KITH_CONFIG_SCALAR, .parent = parent, .place = place};
  if (parent == NULL) return KITH_OK;
  (*out)->key = *key;
  *key = NULL;
  (*out)->index = parent->n++;
  if (parent->last != NULL) parent->last->next = *out;
  if (parent->first == NULL) parent->first = *out;
  parent->last = *out;
  return KITH_OK;
}

static struct kith_config_node *child_of(const struct kith_config_node *node, const char *key,
                                         size_t length) {
  for (struct kith_config_node *child = node->first; child != NULL; child = child->next) {
    char number[16];
    if (child->key == NULL) snprintf(number, sizeof number, "%d", child->index);
    const char *name = child->key != NULL ? child->key : number;
    if (strncmp(name, key, length) == 0 && name[length] == '\0') return child;
  }
  return NULL;
}

const struct kith_config_node *kith_config_child(const struct kith_config_node *node, const char *key) {
  const struct kith_config_node *child = node == NULL ? NULL : child_of(node, key, strlen(key));
  return child == NULL || child->null ? NULL : child;
}

const struct kith_config_node *kith_config_at(const struct kith_config *config, const char *path) {
  const struct kith_config_node *node = config->root;
  while (node != NULL) {
    const size_t length = strcspn(path, ".");
    node = child_of(node, path, length);
    if (path[length] == '\0') break;
    path += length + 1;
  }
  return node == NULL || node->null ? NULL : node;
}

/* --- parsing: libyaml's events become nodes --- */

struct reader {
  yaml_parser_t parser;
  const char *file; /* of the places */
  bool has_lines;   /* false: an override */
  int depth, documents;
  struct kith_config_node *target; /* gets the document */
  struct kith_config_node *open;   /* the map or list that is being filled */
  char *key;                       /* read, its value is next */
  struct kith_place key_place;
};

static struct kith_place event_place(const struct reader *r, const yaml_event_t *event) {
  return (struct kith_place){r->file, r->has_lines ? (int)event->start_mark.line + 1 : 0};
}

static kith_status fail_event(const struct reader *r, const yaml_event_t *event, const char *what) {
  struct kith_config_node here = r->open != NULL ? *r->open : *r->target;
  here.place = event_place(r, event);
  return kith_config_fail(&here, r->key, "%s", what);
}

static kith_status take_key(struct reader *r, const yaml_event_t *event) {
  const char *text = (const char *)event->data.scalar.value;
  const size_t length = event->data.scalar.length;
  if (strlen(text) != length || length == 0) return fail_event(r, event, "a key must be a word");
  const struct kith_config_node *first = child_of(r->open, text, length);
  KITH_TRY(kith_text_copy(&r->key, text, length));
  r->key_place = event_place(r, event);
  if (r->open->n >= MOST_KEYS) return fail_event(r, event, "more than 256 keys in one map");
  if (first == NULL) return KITH_OK;
  char what[64];
  snprintf(what, sizeof what, "duplicate key, first on line %d", first->place.line);
  return fail_event(r, event, r->has_lines ? what : "duplicate key");
}

static bool is_null(const char *text) {
  return text[0] == '\0' || strcmp(text, "~") == 0 || strcmp(text, "null") == 0;
}

static kith_status take_value(struct reader *r, const yaml_event_t *event, enum kith_config_kind kind,
                              struct kith_config_node **node) {
  if (r->open != NULL)
    return node_add(node, r->open, kind, &r->key, r->key != NULL ? r->key_place : event_place(r, event));
  *node = r->target;
  r->target->kind = kind, r->target->null = false;
  r->target->place = event_place(r, event);
  return KITH_OK;
}

static kith_status check_plain(const struct reader *r, const yaml_event_t *event, const yaml_char_t *anchor,
                               const yaml_char_t *tag) {
  if (anchor != NULL) return fail_event(r, event, "anchors and aliases are not supported");
  return tag != NULL ? fail_event(r, event, "tags are not supported") : KITH_OK;
}

static bool wants_key(const struct reader *r) {
  return r->open != NULL && r->open->kind == KITH_CONFIG_MAP && r->key == NULL;
}

static kith_status take_scalar(struct reader *r, const yaml_event_t *event) {
  const char *text = (const char *)event->data.scalar.value;
  const size_t length = event->data.scalar.length;
  KITH_TRY(check_plain(r, event, event->data.scalar.anchor, event->data.scalar.tag));
  if (wants_key(r)) return take_key(r, event);
  if (strlen(text) != length) return fail_event(r, event, "a NUL character in a value");
  struct kith_config_node *node;
  KITH_TRY(take_value(r, event, KITH_CONFIG_SCALAR, &node));
  node->quoted = event->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
  node->null = !node->quoted && is_null(text);
  return kith_text_copy(&node->text, text, length);
}

static kith_status take_start(struct reader *r, const yaml_event_t *event, enum kith_config_kind kind) {
  if (kind == KITH_CONFIG_MAP)
    KITH_TRY(check_plain(r, event, event->data.mapping_start.anchor, event->data.mapping_start.tag));
  else
    KITH_TRY(check_plain(r, event, event->data.sequence_start.anchor, event->data.sequence_start.tag));
  if (wants_key(r)) return fail_event(r, event, "a key must be a word");
  if (++r->depth > DEEPEST) return fail_event(r, event, "nested deeper than 32 levels");
  struct kith_config_node *node;
  KITH_TRY(take_value(r, event, kind, &node));
  r->open = node;
  return KITH_OK;
}

static kith_status take_event(struct reader *r, const yaml_event_t *event) {
  switch (event->type) {
    case YAML_DOCUMENT_START_EVENT:
      return ++r->documents > 1 ? fail_event(r, event, "a second document begins; one is read") : KITH_OK;
    case YAML_ALIAS_EVENT:
      return fail_event(r, event, "anchors and aliases are not supported");
    case YAML_SCALAR_EVENT:
      return take_scalar(r, event);
    case YAML_MAPPING_START_EVENT:
      return take_start(r, event, KITH_CONFIG_MAP);
    case YAML_SEQUENCE_START_EVENT:
      return take_start(r, event, KITH_CONFIG_LIST);
    case YAML_MAPPING_END_EVENT:
    case YAML_SEQUENCE_END_EVENT:
      --r->depth;
      r->open = r->open == r->target ? NULL : r->open->parent;
      return KITH_OK;
    default:
      return KITH_OK;
  }
}

/* libyaml's complaint with its line; what it could not even decode has an offset only. */
static kith_status fail_syntax(const struct reader *r, const char *text, size_t length) {
  const yaml_parser_t *p = &r->parser;
  if (p->error == YAML_MEMORY_ERROR) KITH_FAIL(NO_MEMORY, "no memory to parse %.200s", r->file);
  size_t line = p->problem_mark.line;
  if (p->error == YAML_READER_ERROR) {
    line = 0;
    for (size_t i = 0; i < KITH_MIN(p->problem_offset, length); ++i) line += text[i] == '\n';
  }
  struct kith_config_node here = *r->target;
  here.place = (struct kith_place){r->file, r->has_lines ? (int)line + 1 : 0};
  const char *problem = p->problem != NULL ? p->problem : "cannot be read";
  return p->context == NULL ? kith_config_fail(&here, NULL, "not YAML: %s", problem)
                            : kith_config_fail(&here, NULL, "not YAML: %s %s", problem, p->context);
}

static kith_status read_events(struct reader *r, const char *text, size_t length) {
  yaml_parser_set_input_string(&r->parser, (const unsigned char *)text, length);
  for (bool more = true; more;) {
    yaml_event_t event;
    if (!yaml_parser_parse(&r->parser, &event)) return fail_syntax(r, text, length);
    more = event.type != YAML_STREAM_END_EVENT;
    const kith_status status = take_event(r, &event);
    yaml_event_delete(&event);
    KITH_TRY(status);
  }
  return KITH_OK;
}

/* Fills the target, which holds nothing yet. */
static kith_status read_document(struct reader *r, const char *text, size_t length) {
  if (!yaml_parser_initialize(&r->parser)) KITH_FAIL(NO_MEMORY, "no memory for a YAML parser");
  const kith_status status = read_events(r, text, length);
  yaml_parser_delete(&r->parser);
  kith_free(&r->key);
  return status;
}

static kith_status parse(struct kith_config *config, const char *text, size_t length) {
  const struct kith_place top = {config->file, 1};
  KITH_TRY(node_add(&config->root, NULL, KITH_CONFIG_SCALAR, NULL, top));
  struct reader r = {.file = config->file, .has_lines = true, .target = config->root};
  KITH_TRY(read_document(&r, text, length));
  if (config->root->null) return kith_config_fail(config->root, NULL, "the scene is empty");
  if (config->root->kind == KITH_CONFIG_MAP) return KITH_OK;
  return kith_config_fail(config->root, NULL, "a %s where a map of keys belongs",
                          config->root->kind == KITH_CONFIG_LIST ? "list" : "single value");
}

kith_status kith_config_parse(struct kith_config **out, const char *name, const char *text, size_t length) {
  *out = NULL;
  struct kith_config *config = NULL;
  KITH_TRY(kith_resize(&config, 0, 1, sizeof *config));
  kith_status status = kith_text_copy(&config->file, name, strlen(name));
  if (status == KITH_OK) status = parse(config, text, length);
  if (status != KITH_OK) kith_config_destroy(&config);
  *out = config;
  return status;
}

void kith_config_destroy(struct kith_config **config) {
  if (*config == NULL) return;
  node_destroy(&(*config)->root);
  kith_config_destroy(&(*config)->base);
  kith_free(&(*config)->file);
  kith_free(config);
}

static kith_status fail_file(const char *path, const char *what) {
  char line[512];
  snprintf(line, sizeof line, "%.300s: %s", path, what);
  return refuse(line);
}

static kith_status read_file(FILE *file, const char *path, char *text, size_t *length) {
  *length = fread(text, 1, LARGEST + 1, file);
  if (ferror(file)) return fail_file(path, "cannot be read");
  return *length > LARGEST ? fail_file(path, "larger than 1 MiB, too large for a scene") : KITH_OK;
}

/* One file, without its base. */
static kith_status read_one(struct kith_config **out, const char *path) {
  *out = NULL;
  struct stat status;
  if (stat(path, &status) != 0) return fail_file(path, strerror(errno));
  if (S_ISDIR(status.st_mode)) return fail_file(path, "is a directory, not a scene");
  FILE *file = fopen(path, "rb");
  if (file == NULL) return fail_file(path, strerror(errno));
  char *text = NULL;
  size_t length = 0;
  kith_status result = kith_resize(&text, 0, LARGEST + 1, 1);
  if (result == KITH_OK) result = read_file(file, path, text, &length);
  fclose(file);
  if (result == KITH_OK) result = kith_config_parse(out, path, text, length);
  kith_free(&text);
  return result;
}

/* --- overrides --- */

static const char override_file[] = "--set";

static const struct kith_place override_place = {override_file, 0};

/* To the entry `part` of a map, made if need be; an entry of a list must be there. Nothing becomes a map. */
static kith_status step(struct kith_config_node **node, const char *part, size_t length,
                        struct kith_place place) {
  struct kith_config_node *here = *node, shown = *here;
  shown.place = place;
  if (here->null) node_clear(here), here->kind = KITH_CONFIG_MAP, here->null = false, here->place = place;
  if (here->kind == KITH_CONFIG_SCALAR)
    return kith_config_fail(&shown, NULL, "has no keys, it is '%.60s'", here->text);
  *node = child_of(here, part, length);
  if (*node != NULL) return KITH_OK;
  char *key = NULL;
  KITH_TRY(kith_text_copy(&key, part, length));
  kith_status status;
  if (here->kind == KITH_CONFIG_LIST)
    status = kith_config_fail(&shown, key, "no such entry, the list has %d (counted from 0)", here->n);
  else
    status = node_add(node, here, KITH_CONFIG_SCALAR, &key, place);
  kith_free(&key);
  return status;
}

kith_status kith_config_override(struct kith_config *config, const char *assignment) {
  char line[256];
  const char *equals = strchr(assignment, '=');
  snprintf(line, sizeof line, "--set %.100s: write it as key=value", assignment);
  if (equals == NULL || equals == assignment) return refuse(line);
  struct kith_config_node *node = config->root;
  int depth = 0;
  for (const char *part = assignment; part <= equals;) {
    const size_t length = strcspn(part, ".=");
    if (length == 0) return refuse(line);
    if (++depth > DEEPEST) return kith_config_fail(node, NULL, "nested deeper than 32 levels");
    KITH_TRY(step(&node, part, length, override_place));
    part += length + 1;
  }
  node_clear(node);
  node->place = override_place;
  struct reader r = {.file = override_file, .depth = depth, .target = node};
  return read_document(&r, equals + 1, strlen(equals + 1));
}

/* --- bases --- */

/* The value of `from`, which is left a null. */
static void node_take(struct kith_config_node *node, struct kith_config_node *from) {
  node_clear(node);
  node->kind = from->kind, node->null = from->null, node->quoted = from->quoted;
  node->text = from->text, node->first = from->first, node->last = from->last, node->n = from->n;
  node->place = from->place;
  for (struct kith_config_node *child = node->first; child != NULL; child = child->next) child->parent = node;
  from->text = NULL, from->first = from->last = NULL;
  node_clear(from);
}

/* A key of a scene with a base: to the place that its dots lead to. */
static kith_status put_over(struct kith_config_node *root, struct kith_config_node *given) {
  struct kith_config_node *node = root;
  for (const char *part = given->key;; ++part) {
    const size_t length = strcspn(part, ".");
    if (length == 0) return kith_config_fail(given, NULL, "an empty word between dots");
    KITH_TRY(step(&node, part, length, given->place));
    part += length;
    if (*part == '\0') break;
  }
  node_take(node, given);
  return KITH_OK;
}

static kith_status read_with_base(struct kith_config **out, const char *path, int deep);

static kith_status take_base(struct kith_config *config, int deep) {
  enum { LONGEST_CHAIN = 8 };
  struct kith_config_node *name = child_of(config->root, "base", strlen("base"));
  if (name == NULL || name->null) return KITH_OK;
  char path[4096];
  const char *slash = strrchr(config->file, '/');
  const int folder = slash != NULL ? (int)(slash + 1 - config->file) : 0;
  if (name->kind != KITH_CONFIG_SCALAR) return kith_config_fail(name, NULL, "not the name of a file");
  if (deep == LONGEST_CHAIN)
    return kith_config_fail(name, NULL, "the %dth base in a row; do they go round?", LONGEST_CHAIN);
  snprintf(path, sizeof path, "%.*s%s", name->text[0] == '/' ? 0 : folder, config->file, name->text);
  if (access(path, R_OK) != 0) return kith_config_fail(name, NULL, "%.200s: %s", path, strerror(errno));
  KITH_TRY(read_with_base(&config->base, path, deep + 1));
  struct kith_config_node *root = config->base->root;
  for (struct kith_config_node *child = root->first; child != NULL; child = child->next)
    if (strcmp(child->key, "scene") == 0) node_clear(child);
  for (struct kith_config_node *child = config->root->first; child != NULL; child = child->next)
    if (child != name) KITH_TRY(put_over(root, child));
  config->base->root = config->root;
  config->root = root;
  return KITH_OK;
}

static kith_status read_with_base(struct kith_config **out, const char *path, int deep) {
  KITH_TRY(read_one(out, path));
  const kith_status status = take_base(*out, deep);
  if (status != KITH_OK) kith_config_destroy(out);
  return status;
}

kith_status kith_config_read(struct kith_config **out, const char *path) {
  return read_with_base(out, path, 0);
}
