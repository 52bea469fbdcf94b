/* keys.h - the keys of a map in a scene, declared once: name, kind, default, range, meaning and where the
 * value goes.
 *
 * A table of rows reads a map, checks it, refuses keys that are not in the table, and prints the reference of
 * the scene. Any single value may also be given by dimension: {1d: 100, 2d: 40, 3d: 20}.
 *
 *   static const struct kith_key scheme_keys[] = {
 *       {"cfl", KITH_KEY_NUMBER, "0.3", "(0, 1]", "Courant number", KITH_INTO(struct kith_scene,
 * scheme.cfl)}, {0}}; */
#ifndef KITH_APP_KEYS_H
#define KITH_APP_KEYS_H

#include <stdio.h>
#include "app/config.h"

enum kith_key_kind {
  KITH_KEY_NUMBER,     /* double: finite, in the range */
  KITH_KEY_INTEGER,    /* int or uint64_t, by size */
  KITH_KEY_BOOL,       /* bool: true or false */
  KITH_KEY_WORD,       /* one of the words: its position as an int or bool (by size) */
  KITH_KEY_NAME,       /* char[]: one of the words, or any name if there are none */
  KITH_KEY_TEXT,       /* char *, kith_resize memory owned by the struct */
  KITH_KEY_EXPRESSION, /* struct kith_expression *, owned by the struct: a number or a formula */
  KITH_KEY_VECTOR,     /* double[NDIM]; NDIM to 3 entries, of which the first NDIM count */
  KITH_KEY_INTERVAL,   /* double[2]: [a, b], a < b */
  KITH_KEY_SIDES,      /* double[2]: a number for both, or [left, right] */
  KITH_KEY_MAP,        /* a map whose rows go into the same struct */
  KITH_KEY_OTHER       /* known and documented here, read by its own code */
};
/* How the reference writes what OTHER stands for. */
enum kith_key_form { KITH_FORM_VALUE, KITH_FORM_MAP, KITH_FORM_NAMED, KITH_FORM_LIST };

struct kith_key {
  const char *key; /* NULL ends a table */
  enum kith_key_kind kind;
  const char *
      fallback; /* default as it would be written; NULL: the key is required; "": the member stays as it is */
  const char *allowed; /* range "(0, 1]" or words "a|b|c"; "": any */
  const char *doc;
  size_t offset, size;
  const struct kith_key *keys; /* MAP: its rows; OTHER: rows for the reference */
  enum kith_key_form form;     /* OTHER with rows: a map of them, a map by name, or a list */
};

/* The ends of a row: where its value goes, or the rows below it. */
#define KITH_INTO(type, member) .offset = offsetof(type, member), .size = sizeof(((type *)0)->member)
#define KITH_BELOW(rows, as) .keys = (rows), .form = KITH_FORM_##as

/* Reads all rows from a map into *base (zero where nothing was read before). map NULL: every default;
 * `parent` is then where a required key is reported missing. Strings and expressions already in *base stay,
 * to be freed by its owner, also after a failure. */
kith_status kith_keys_read(const struct kith_key *keys, const struct kith_config_node *map, void *base);
/* One row of it. */
kith_status kith_key_read(const struct kith_key *key, const struct kith_config_node *map, void *base);
/* The row called `name`. */
const struct kith_key *kith_keys_find(const struct kith_key *keys, const char *name);
/* One value as a row says; also for values that are entries of a list. */
kith_status kith_key_value(const struct kith_key *key, const struct kith_config_node *node, void *into);

/* BAD_INPUT unless it is a map, or a list. NULL is neither. */
kith_status kith_config_want_map(const struct kith_config_node *node);
kith_status kith_config_want_list(const struct kith_config_node *node);

/* Commented YAML: every key with default, range and meaning. It is itself a scene, but for the required keys.
 */
void kith_keys_reference(const struct kith_key *keys, FILE *file);

#endif
