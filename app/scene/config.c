/* YAML as a tree: messages with file and line, nodes, reading, overrides, bases, writing. */
#include "app/scene/config.h"

#include <ctype.h>
#include <errno.h>
#include <glob.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <yaml.h>
#include "app/cli/text.h"
#include "lib/core/choices.h"

enum { DEEPEST = 32, MOST_KEYS = 256, LARGEST = 1 << 20 };

/* Copies a string to kith_resize memory. */
static kith_status text_copy(char **out, const char *text, size_t length) {
  KITH_TRY(kith_resize(out, 0, length + 1, 1));
  memcpy(*out, text, length);
  return KITH_OK;
}

int kith_path_folder(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash != NULL ? (int)(slash + 1 - path) : 0;
}

void kith_path_stem(const char *path, char *stem, size_t size) {
  const char *name = path + kith_path_folder(path), *dot = strrchr(name, '.');
  snprintf(stem, size, "%.*s", dot != NULL && dot != name ? (int)(dot - name) : (int)strlen(name), name);
}

bool kith_path_is_name(const char *name) {
  bool plain = name[0] != '\0' && name[0] != '.';
  for (const char *c = name; *c != '\0'; ++c) plain = plain && *c != '/' && !iscntrl((unsigned char)*c);
  return plain;
}

void kith_config_path(const struct kith_config_node *node, const char *key, char *path, size_t size) {
  char index[16];
  path[0] = '\0';
  if (node->parent != NULL) {
    snprintf(index, sizeof index, "%d", node->index);
    kith_config_path(node->parent, node->key != NULL ? node->key : index, path, size);
  }
  if (key != NULL) kith_text_add(path, size, "%s%.64s", path[0] != '\0' ? "." : "", key);
}

/* Fails with the message in one line, whatever the file holds: control characters become '?'. */
static kith_status refuse(char *line) {
  for (char *p = line; *p != '\0'; ++p)
    if ((unsigned char)*p < ' ' || *p == 0x7f) *p = '?';
  KITH_FAIL(BAD_INPUT, "%s", line);
}

kith_status kith_config_fail(const struct kith_config_node *node, const char *key, const char *format, ...) {
  char path[256], message[2048], place[256] = "--set", line[2600];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(message, sizeof message, format, arguments);
  va_end(arguments);
  kith_config_path(node, key, path, sizeof path);
  if (node->location.line > 0)
    snprintf(place, sizeof place, "%.200s:%d:", node->location.file, node->location.line);
  snprintf(line, sizeof line, "%s %s%s%s", place, path, path[0] != '\0' ? ": " : "", message);
  return refuse(line);
}

kith_status kith_config_want(const struct kith_config_node *node, enum kith_config_kind kind) {
  static const char *const names[] = {"a single value", "a list", "a map"};
  if (node->kind == kind) return KITH_OK;
  if (node->kind == KITH_CONFIG_SCALAR)
    return kith_config_fail(node, NULL, "'%.60s' where %s belongs", node->null ? "" : node->text,
                            names[kind]);
  const bool formula = node->kind == KITH_CONFIG_MAP && kind == KITH_CONFIG_SCALAR;
  return kith_config_fail(node, NULL, "%s where %s belongs%s", names[node->kind], names[kind],
                          formula ? " (a formula with a colon needs quotes)" : "");
}

/* --- the tree --- */

static void node_destroy(struct kith_config_node **node);

/* The latest layer of the values in a node, without optional ones; INT_MIN: there are none. */
static int last_layer(const struct kith_config_node *node) {
  int last = node->n > 0 || node->location.optional ? INT_MIN : node->location.layer;
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    last = KITH_MAX(last, last_layer(child));
  return last;
}

bool kith_config_is_older(const struct kith_config_node *node, const struct kith_config_node *choice) {
  return last_layer(node) < (choice != NULL ? choice->location.layer : INT_MIN + 1);
}

void kith_config_drop(struct kith_config_node *node) {
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
  kith_config_drop(*node);
  kith_free(&(*node)->key);
  kith_free(node);
}

/* Adds a null to `parent` (NULL: makes a root); `key` is copied. BAD_INPUT if it is nested too deep. */
static kith_status node_add(struct kith_config_node **out, struct kith_config_node *parent, const char *key,
                            size_t length, struct kith_source_location location) {
  int depth = 0;
  *out = NULL;
  for (const struct kith_config_node *above = parent; above != NULL; above = above->parent) ++depth;
  if (depth > DEEPEST) {
    parent->location = location;
    return kith_config_fail(parent, NULL, "nested deeper than 32 levels");
  }
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  **out = (struct kith_config_node){.null = true, .parent = parent, .location = location};
  if (parent == NULL) return KITH_OK;
  (*out)->index = parent->n++;
  if (parent->last != NULL) parent->last->next = *out;
  if (parent->first == NULL) parent->first = *out;
  parent->last = *out;
  return key != NULL ? text_copy(&(*out)->key, key, length) : KITH_OK;
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
  yaml_event_t event; /* the present one; empty before the first is read */
  const char *text;
  size_t length;
  struct kith_source_location start; /* of the text; line 0: an override */
  struct kith_config_node *target;   /* the root of the tree that is read */
};

static struct kith_source_location event_location(const struct reader *r) {
  struct kith_source_location location = r->start;
  if (location.line > 0) location.line = (int)r->event.start_mark.line + 1;
  return location;
}

static kith_status fail_here(const struct reader *r, struct kith_config_node *node, const char *key,
                             const char *what) {
  node->location = event_location(r);
  return kith_config_fail(node, key, "%s", what);
}

/* Copies a line, counted from 0, without the blanks in front. */
static void copy_line(const struct reader *r, size_t line, char *to, size_t size) {
  const char *p = r->text, *const end = r->text + r->length;
  for (; line > 0 && p != NULL; --line) p = memchr(p, '\n', (size_t)(end - p)), p += p != NULL;
  while (p != NULL && p < end && *p == ' ') ++p;
  const size_t length = p != NULL ? KITH_MIN((size_t)(end - p), size - 1) : 0;
  if (length > 0) memcpy(to, p, length);
  to[length] = '\0';
  to[strcspn(to, "\n")] = '\0';
}

/* Fails with libyaml's message and its line. For text that could not be decoded libyaml gives an offset only,
 * up to which lines are counted. */
static kith_status fail_syntax(const struct reader *r) {
  const yaml_parser_t *p = &r->parser;
  if (p->error == YAML_MEMORY_ERROR) KITH_FAIL(NO_MEMORY, "no memory to parse %.200s", r->start.file);
  size_t line = p->problem_mark.line;
  if (p->error == YAML_READER_ERROR) {
    line = 0;
    for (size_t i = 0; i < KITH_MIN(p->problem_offset, r->length); ++i) line += r->text[i] == '\n';
  }
  r->target->location = r->start;
  if (r->start.line > 0) r->target->location.line = (int)line + 1;
  char text[512];
  copy_line(r, line, text, sizeof text);
  if (text[0] == '\t') return kith_config_fail(r->target, NULL, "not YAML: indented by a tab; take blanks");
  return kith_config_fail(r->target, NULL, "not YAML: %s%s%s%s",
                          p->problem != NULL ? p->problem : "cannot be read", p->context != NULL ? " " : "",
                          p->context != NULL ? p->context : "",
                          strstr(text, " ? ") != NULL ? "; a formula with a colon needs quotes" : "");
}

static kith_status next_event(struct reader *r) {
  yaml_event_delete(&r->event);
  return yaml_parser_parse(&r->parser, &r->event) ? KITH_OK : fail_syntax(r);
}

/* Refuses anchors and tags, which come first in the data of events that begin a value, and aliases
 * (anchors). */
static kith_status check_plain(const struct reader *r, struct kith_config_node *node) {
  const yaml_event_t *e = &r->event;
  if (e->data.scalar.anchor != NULL) return fail_here(r, node, NULL, "anchors and aliases are not supported");
  return e->data.scalar.tag != NULL ? fail_here(r, node, NULL, "tags are not supported") : KITH_OK;
}

/* Checks that the event is a key, and one that the map does not have yet. */
static kith_status check_key(const struct reader *r, struct kith_config_node *map) {
  const char *text = (const char *)r->event.data.scalar.value;
  const size_t length = r->event.type == YAML_SCALAR_EVENT ? r->event.data.scalar.length : 0;
  char what[64] = "duplicate key";
  if (length > 0) KITH_TRY(check_plain(r, map));
  if (length == 0 || strlen(text) != length) return fail_here(r, map, NULL, "a key must be a word");
  if (map->n >= MOST_KEYS) return fail_here(r, map, text, "more than 256 keys in one map");
  const struct kith_config_node *first = child_of(map, text, length);
  if (first == NULL) return KITH_OK;
  if (r->start.line > 0) snprintf(what, sizeof what, "duplicate key, first on line %d", first->location.line);
  return fail_here(r, map, text, what);
}

static kith_status read_node(struct reader *r, struct kith_config_node *node);

/* Refuses a key without a value that is a part of a list or of a formula, as in {lower: 0, 0, 0}. */
static kith_status check_value(const struct kith_config_node *child) {
  const bool word =
      child->key[strspn(child->key, "-.0123456789")] != '\0' && strpbrk(child->key, "()") == NULL;
  if (word || !child->null || child->text[0] != '\0') return KITH_OK;
  return kith_config_fail(child, NULL,
                          "has no value; lists stand in brackets, formulas with a comma in quotes");
}

/* Reads the entries of a map or a list, up to its end. */
static kith_status read_children(struct reader *r, struct kith_config_node *node) {
  const bool map = node->kind == KITH_CONFIG_MAP;
  for (;;) {
    struct kith_config_node *child;
    KITH_TRY(next_event(r));
    if (r->event.type == YAML_MAPPING_END_EVENT || r->event.type == YAML_SEQUENCE_END_EVENT) return KITH_OK;
    if (map) KITH_TRY(check_key(r, node));
    KITH_TRY(node_add(&child, node, map ? (const char *)r->event.data.scalar.value : NULL,
                      map ? r->event.data.scalar.length : 0, event_location(r)));
    if (map) KITH_TRY(next_event(r));
    KITH_TRY(read_node(r, child));
    if (map) KITH_TRY(check_value(child));
  }
}

/* Reads the value that the present event begins. */
static kith_status read_node(struct reader *r, struct kith_config_node *node) {
  const yaml_event_t *e = &r->event;
  KITH_TRY(check_plain(r, node));
  if (e->type != YAML_SCALAR_EVENT) {
    node->kind = e->type == YAML_MAPPING_START_EVENT ? KITH_CONFIG_MAP : KITH_CONFIG_LIST;
    node->null = false;
    return read_children(r, node);
  }
  const char *text = (const char *)e->data.scalar.value;
  if (strlen(text) != e->data.scalar.length) return fail_here(r, node, NULL, "a NUL character in a value");
  node->quoted = e->data.scalar.style != YAML_PLAIN_SCALAR_STYLE;
  node->null = !node->quoted && (text[0] == '\0' || strcmp(text, "~") == 0 || strcmp(text, "null") == 0);
  return text_copy(&node->text, text, strlen(text));
}

static kith_status read_stream(struct reader *r, struct kith_config_node *node) {
  int documents = 0;
  do {
    KITH_TRY(next_event(r));
    if (r->event.type != YAML_DOCUMENT_START_EVENT) continue;
    if (++documents > 1) return fail_here(r, node, NULL, "a second document begins; one is read");
    KITH_TRY(next_event(r));
    node->location = event_location(r);
    KITH_TRY(read_node(r, node));
  } while (r->event.type != YAML_STREAM_END_EVENT);
  return KITH_OK;
}

/* Parses the text of the reader into `node`, which holds nothing yet. */
static kith_status read_document(struct reader *r, struct kith_config_node *node) {
  if (!yaml_parser_initialize(&r->parser)) KITH_FAIL(NO_MEMORY, "no memory for a YAML parser");
  yaml_parser_set_input_string(&r->parser, (const unsigned char *)r->text, r->length);
  r->target = node;
  const kith_status status = read_stream(r, node);
  yaml_event_delete(&r->event);
  yaml_parser_delete(&r->parser);
  return status;
}

static kith_status parse(struct kith_config *config, const char *text, size_t length) {
  const struct kith_source_location top = {config->file, 1, 0, false};
  KITH_TRY(node_add(&config->root, NULL, NULL, 0, top));
  struct reader r = {.text = text, .length = length, .start = top};
  KITH_TRY(read_document(&r, config->root));
  if (config->root->null) return kith_config_fail(config->root, NULL, "the file is empty");
  return kith_config_want(config->root, KITH_CONFIG_MAP);
}

kith_status kith_config_parse(struct kith_config **out, const char *name, const char *text, size_t length) {
  *out = NULL;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  kith_status status = text_copy(&(*out)->file, name, strlen(name));
  if (status == KITH_OK) status = parse(*out, text, length);
  if (status != KITH_OK) kith_config_destroy(out);
  return status;
}

void kith_config_destroy(struct kith_config **config) {
  if (*config == NULL) return;
  node_destroy(&(*config)->root);
  kith_config_destroy(&(*config)->base);
  kith_free(&(*config)->file);
  kith_free(config);
}

/* Appends to `line` the scene that was meant by a path where no file is: that of the nearest name, beside it
 * or in inputs. */
static void suggest_scene(const char *path, char *line, size_t size) {
  char stem[128], text[512], names[4096] = "", near[128];
  glob_t found;
  kith_path_stem(path, stem, sizeof stem);
  snprintf(text, sizeof text, "{%.*s,inputs/}*.yaml", KITH_MIN(kith_path_folder(path), 400), path);
  if (glob(text, GLOB_BRACE, NULL, &found) != 0) return;
  for (size_t k = 0; k < found.gl_pathc; ++k) {
    kith_path_stem(found.gl_pathv[k], text, sizeof text);
    kith_text_add(names, sizeof names, "|%s", text);
  }
  const bool any = kith_choices_suggest(names, stem, near, sizeof near);
  for (size_t k = 0; any && k < found.gl_pathc; ++k) {
    kith_path_stem(found.gl_pathv[k], text, sizeof text);
    if (!kith_name_is(text, near, strlen(near))) continue;
    kith_text_add(line, size, "; did you mean '%.150s'?", found.gl_pathv[k]);
    break;
  }
  globfree(&found);
}

static kith_status read_one(struct kith_config **out, const char *path) {
  char *text = NULL, line[512];
  const char *wrong = NULL;
  *out = NULL;
  KITH_TRY(kith_resize(&text, 0, LARGEST + 1, 1));
  FILE *file = fopen(path, "rb");
  const size_t length = file != NULL ? fread(text, 1, LARGEST + 1, file) : 0;
  if (file == NULL || ferror(file))
    wrong = errno == EISDIR ? "is a directory, not a scene" : strerror(errno);
  else if (length > LARGEST)
    wrong = "larger than 1 MiB, too large for a scene";
  if (file != NULL) fclose(file);
  if (wrong != NULL) snprintf(line, sizeof line, "%.300s: %s", path, wrong);
  if (wrong != NULL && access(path, F_OK) != 0) suggest_scene(path, line, sizeof line);
  const kith_status status = wrong != NULL ? refuse(line) : kith_config_parse(out, path, text, length);
  kith_free(&text);
  return status;
}

/* Finds the node at a dotted path, and makes it where it is missing: but entries of a list must exist, and a
 * single value has no keys. *out: NULL if a word of the path is empty. */
static kith_status reach(struct kith_config_node *root, const char *path, size_t length,
                         struct kith_source_location location, struct kith_config_node **out) {
  struct kith_config_node *node = root;
  *out = NULL;
  for (const char *part = path, *end = path + length; part <= end; ++part) {
    const char *dot = memchr(part, '.', (size_t)(end - part));
    const size_t n = (size_t)((dot != NULL ? dot : end) - part);
    if (n == 0) return KITH_OK;
    if (node->null)
      kith_config_drop(node), node->kind = KITH_CONFIG_MAP, node->null = false, node->location = location;
    struct kith_config_node *child = child_of(node, part, n);
    if (child == NULL && node->kind != KITH_CONFIG_MAP) {
      char key[64];
      snprintf(key, sizeof key, "%.*s", (int)n, part);
      node->location = location;
      if (node->kind == KITH_CONFIG_SCALAR)
        return kith_config_fail(node, NULL, "has no keys, it is '%.60s'", node->text);
      return kith_config_fail(node, key, "no such entry, the list has %d (counted from 0)", node->n);
    }
    if (child == NULL) KITH_TRY(node_add(&child, node, part, n, location));
    node = child, part += n;
  }
  *out = node;
  return KITH_OK;
}

kith_status kith_config_override(struct kith_config *config, const char *assignment) {
  const char *equals = strchr(assignment, '=');
  const bool optional = equals != NULL && equals > assignment && equals[-1] == '?';
  const struct kith_source_location place = {"--set", 0, 1, optional};
  struct kith_config_node *node = NULL;
  if (equals != NULL)
    KITH_TRY(reach(config->root, assignment, (size_t)(equals - assignment) - optional, place, &node));
  if (node == NULL) {
    char line[256];
    snprintf(line, sizeof line, "--set %.100s: write it as key=value", assignment);
    return refuse(line);
  }
  kith_config_drop(node);
  node->location = place;
  struct reader r = {.text = equals + 1, .length = strlen(equals + 1), .start = place};
  return read_document(&r, node);
}

/* Moves the value of `from` to `node`; `from` is left a null. */
static void node_take(struct kith_config_node *node, struct kith_config_node *from) {
  kith_config_drop(node);
  node->kind = from->kind, node->null = from->null, node->quoted = from->quoted;
  node->text = from->text, node->first = from->first, node->last = from->last, node->n = from->n;
  node->location = from->location;
  for (struct kith_config_node *child = node->first; child != NULL; child = child->next) child->parent = node;
  from->text = NULL, from->first = from->last = NULL;
  kith_config_drop(from);
}

/* Moves all values of a tree, which is that of a base, to an earlier layer. */
static void demote(struct kith_config_node *node) {
  --node->location.layer;
  for (struct kith_config_node *child = node->first; child != NULL; child = child->next) demote(child);
}

/* Returns the first value in `node` that the file itself has set, not its base; NULL: there is none. */
static const struct kith_config_node *own_value(const struct kith_config_node *node) {
  const struct kith_config_node *own =
      node->kind == KITH_CONFIG_SCALAR && !node->null && node->location.layer == 0 ? node : NULL;
  for (const struct kith_config_node *child = node->first; child != NULL && own == NULL; child = child->next)
    own = own_value(child);
  return own;
}

const char *kith_config_beside(const struct kith_config_node *node, char *path, size_t size) {
  const char *from = node->location.file;
  snprintf(path, size, "%.*s%s", node->text[0] != '/' ? kith_path_folder(from) : 0, from, node->text);
  return path;
}

static kith_status read_with_base(struct kith_config **out, const char *path, int deep);

static kith_status take_base(struct kith_config *config, int deep) {
  enum { LONGEST_CHAIN = 8 };
  struct kith_config_node *name = child_of(config->root, "base", strlen("base"));
  if (name == NULL || name->null) return KITH_OK;
  char path[4096];
  if (name->kind != KITH_CONFIG_SCALAR) return kith_config_fail(name, NULL, "not the name of a file");
  if (deep == LONGEST_CHAIN)
    return kith_config_fail(name, NULL, "the %dth base in a row; do they go round?", LONGEST_CHAIN);
  kith_config_beside(name, path, sizeof path);
  struct stat found;
  if (access(path, R_OK) != 0) return kith_config_fail(name, NULL, "%.200s: %s", path, strerror(errno));
  if (stat(path, &found) == 0 && S_ISDIR(found.st_mode))
    return kith_config_fail(name, NULL, "%.200s is a directory, not a scene", path);
  KITH_TRY(read_with_base(&config->base, path, deep + 1));
  struct kith_config_node *root = config->base->root;
  demote(root);
  for (struct kith_config_node *child = root->first; child != NULL; child = child->next)
    if (strcmp(child->key, "scene") == 0) kith_config_drop(child);
  for (struct kith_config_node *child = config->root->first, *place; child != NULL; child = child->next) {
    if (child == name) continue;
    KITH_TRY(reach(root, child->key, strlen(child->key), child->location, &place));
    if (place == NULL) return kith_config_fail(child, NULL, "an empty word between dots");
    const struct kith_config_node *own = own_value(place);
    if (own != NULL)
      return kith_config_fail(child, NULL, "would replace what line %d says", own->location.line);
    node_take(place, child);
  }
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

/* --- writing: the way back, through a document of libyaml --- */

static int add_text(yaml_document_t *document, const char *text, bool quoted) {
  return yaml_document_add_scalar(document, NULL, (const yaml_char_t *)text, (int)strlen(text),
                                  quoted ? YAML_SINGLE_QUOTED_SCALAR_STYLE : YAML_PLAIN_SCALAR_STYLE);
}

/* Is it a list of single values, which stays on one line? */
static bool flat(const struct kith_config_node *node) {
  for (const struct kith_config_node *child = node->first; child != NULL; child = child->next)
    if (child->kind != KITH_CONFIG_SCALAR) return false;
  return true;
}

/* Adds a node; returns its number in the document, or 0 if there is no memory. */
static int add_node(yaml_document_t *document, const struct kith_config_node *node, bool one_line) {
  const bool map = node->kind == KITH_CONFIG_MAP;
  if (node->kind == KITH_CONFIG_SCALAR)
    return add_text(document, node->null ? "null" : node->text, node->quoted);
  one_line = one_line || (!map && flat(node));
  const int id = map ? yaml_document_add_mapping(
                           document, NULL, one_line ? YAML_FLOW_MAPPING_STYLE : YAML_BLOCK_MAPPING_STYLE)
                     : yaml_document_add_sequence(
                           document, NULL, one_line ? YAML_FLOW_SEQUENCE_STYLE : YAML_BLOCK_SEQUENCE_STYLE);
  for (const struct kith_config_node *child = node->first; id != 0 && child != NULL; child = child->next) {
    const int key = map ? add_text(document, child->key, false) : id,
              value = add_node(document, child, one_line);
    if (key == 0 || value == 0) return 0;
    if (!(map ? yaml_document_append_mapping_pair(document, id, key, value)
              : yaml_document_append_sequence_item(document, id, value)))
      return 0;
  }
  return id;
}

static bool emit(const struct kith_config_node *root, bool one_line, FILE *file) {
  yaml_emitter_t emitter;
  yaml_document_t document;
  if (!yaml_emitter_initialize(&emitter)) return false;
  yaml_emitter_set_output_file(&emitter, file);
  yaml_emitter_set_unicode(&emitter, 1);
  yaml_emitter_set_width(&emitter, -1);
  bool done = yaml_document_initialize(&document, NULL, NULL, NULL, 1, 1);
  if (done && add_node(&document, root, one_line) == 0) yaml_document_delete(&document), done = false;
  done = done && yaml_emitter_dump(&emitter, &document) && yaml_emitter_close(&emitter);
  yaml_emitter_delete(&emitter);
  return done;
}

kith_status kith_config_emit(const struct kith_config_node *root, bool one_line, char **text) {
  size_t length;
  *text = NULL;
  FILE *file = open_memstream(text, &length);
  const bool done = file != NULL && emit(root, one_line, file);
  if (file != NULL && fclose(file) == 0 && done && *text != NULL) return KITH_OK;
  kith_free(text);
  KITH_FAIL(NO_MEMORY, "no memory for the effective scene"); /* what was read can be written */
}
