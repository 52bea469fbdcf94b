/* config.h - a YAML file as a tree with line numbers, overrides, and one clear line for what is wrong.
 *
 *   file.yaml:12: method.kernl: unknown key; did you mean 'kernel'?
 *   --set scheme.cfl: -1 is out of range [0, 1000]
 *
 * Parsed by libyaml. Overrides "a.b.c=value" (value is YAML; entries of lists are counted from 0) replace a
 * value or add it. Typed reading is in params.h.
 *
 * A scene may begin with `base: other.yaml` (a path from its own folder): it is then that other scene,
 * without its name, in which every further key sets a value as --set does: `regions.0.pressure: 1000`. No key
 * may replace what another key of the same file has set.
 *
 * Refused: what libyaml refuses, anchors, aliases and tags, a second document, keys that are not words, parts
 * of lists or formulas that became keys, the same key twice, more than 256 keys in a map, nesting deeper than
 * 32, files above 1 MiB. */
#ifndef KITH_APP_SCENE_CONFIG_H
#define KITH_APP_SCENE_CONFIG_H

#include "lib/core/base.h"

struct kith_param;

/* Where a value stands, for messages. The strings belong to the config. */
struct kith_source_location {
  const char *file;
  int line;      /* from 1; 0: not in a file but in an override */
  int layer;     /* later ones replace earlier ones: overrides 1, the file 0, its base -1, ... */
  bool optional; /* of an override KEY?=VALUE: it is dropped if it means nothing */
};

enum kith_config_kind { KITH_CONFIG_SCALAR, KITH_CONFIG_LIST, KITH_CONFIG_MAP };

struct kith_config_node {
  enum kith_config_kind kind;
  char *key;  /* in a map, else NULL */
  char *text; /* of a scalar, else NULL */
  bool null;  /* nothing, ~ or null without quotes: as if it were not given */
  bool quoted;
  int index; /* among the children of the parent */
  int n;     /* children */
  /* Of the root: */
  int dimension; /* which entry of {1d: .., 2d: .., 3d: ..} counts; 0: such maps are refused */
  const struct kith_param *params; /* the table of all keys of a scene, for suggestions; or NULL */
  struct kith_config_node *parent, *first, *last, *next;
  struct kith_source_location location;
};

struct kith_config {
  char *file;
  struct kith_config_node *root; /* a map */
  struct kith_config *base;      /* owned: read from `base`, for locations in its file; NULL: none */
};

/* Reads a config. BAD_INPUT with one line for whatever is wrong, also for a file that cannot be read. */
kith_status kith_config_read(struct kith_config **out, const char *path);
/* Reads a config from memory; `name` stands for the file in messages. */
kith_status kith_config_parse(struct kith_config **out, const char *name, const char *text, size_t length);
void kith_config_destroy(struct kith_config **config);

/* Applies "a.b.c=value", or "a.b.c?=value", which is dropped where the key means nothing. A key that is not
 * known is found when the tree is read. */
kith_status kith_config_override(struct kith_config *config, const char *assignment);
/* Writes a tree as YAML: in file order, each value in one way, without comments; on one line, or with a line
 * for each entry of a map and of a list of maps. *text: kith_resize memory, owned by the caller. */
kith_status kith_config_emit(const struct kith_config_node *root, bool one_line, char **text);

/* Were all values in `node` set in an earlier layer than `choice`, the value of another key, beside which
 * they mean nothing? Then they are no mistake and can be dropped: a file may have settings of a package, and
 * --set chooses another package. If `choice` is NULL, which stands for a default, only optional values are
 * older. */
bool kith_config_is_older(const struct kith_config_node *node, const struct kith_config_node *choice);
/* Makes a node null: as if it were not given. */
void kith_config_drop(struct kith_config_node *node);
/* The child of a map by key, or of a list by number; NULL if it is not there or null, or if `node` is. */
const struct kith_config_node *kith_config_child(const struct kith_config_node *node, const char *key);
/* The value at a dotted path from the root, or NULL. */
const struct kith_config_node *kith_config_at(const struct kith_config *config, const char *path);

/* Writes "regions.0.density": the path of a node, or of its child `key` unless that is NULL. */
void kith_config_path(const struct kith_config_node *node, const char *key, char *path, size_t size);
/* Fails with BAD_INPUT and "location: path: message". `key`: names a child that is not there; NULL: the
 * message is about `node` itself. */
kith_status kith_config_fail(const struct kith_config_node *node, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Fails with BAD_INPUT unless a node is of this kind. */
kith_status kith_config_want(const struct kith_config_node *node, enum kith_config_kind kind);
/* Writes the path of the file that a node names, from the folder of the node's own file; returns it. */
const char *kith_config_beside(const struct kith_config_node *node, char *path, size_t size);
/* Length of a path up to its last '/', which is included; 0: there is none. */
int kith_path_folder(const char *path);
/* Writes the name of a file without folders and ending. */
void kith_path_stem(const char *path, char *stem, size_t size);
/* Can it name a file? It must not be empty, begin with '.', or have '/' or control characters. */
bool kith_path_is_name(const char *name);

#endif
