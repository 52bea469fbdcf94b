/* param.h - parameters: what can be set, declared once, in a table beside the struct that it fills.
 *
 * From the table come reading a scene (app/scene/params.h), its reference (kith list scene), the error
 * messages, and what library users set by hand.
 *
 * A member of a family declares its own parameters in its own file and nowhere else:
 *
 *   struct stiffened {double gamma, stiffness;};                    // known to this file only
 *   static const struct kith_param params[] = {
 *       {"gamma", KITH_PARAM_NUMBER, "1.4", "(1, inf)", "ratio of specific heats",
 *        KITH_INTO(struct stiffened, gamma)},
 *       {"stiffness", KITH_PARAM_NUMBER, "0", "[0, inf)", "P0", KITH_INTO(struct stiffened, stiffness)},
 *       {0}};
 *   const struct kith_eos_ops kith_eos_stiffened = {..., KITH_SETTINGS(params, stiffened)};
 *
 * A table that lets the user choose a member has a row of kind MEMBER; reading it reads the member's own rows
 * too, from the same map, into the settings of a struct kith_selected. An object of the family holds `const
 * void *settings`, borrowed: the scene owns the memory and outlives the objects made from it. Settings that
 * were read are within their ranges: `create` of a member checks only what depends on more than one value,
 * and calls kith_params_check if its settings may have been filled by hand. A member without parameters has
 * params NULL, and its settings are NULL.
 *
 * Nothing here knows YAML, and nothing depends on NDIM: the length of a vector is the size of its member. */
#ifndef KITH_CORE_PARAM_H
#define KITH_CORE_PARAM_H

#include "lib/core/base.h"

struct kith_param;

enum kith_param_kind {
  KITH_PARAM_NUMBER,      /* double: finite, in the range */
  KITH_PARAM_INTEGER,     /* int or uint64_t, by size */
  KITH_PARAM_BOOL,        /* bool: true or false */
  KITH_PARAM_CHOICE,      /* one of the choices: its position as an int or bool, by size */
  KITH_PARAM_NAME,        /* char[]: one of the choices, or any name if there are none; with row.family, one
                          * or more of its members joined by '|', which may have options after a colon */
  KITH_PARAM_EXPRESSION,  /* struct kith_expression *, owned by the struct: a number or a formula; NULL: none,
                           * what its default says is for the reader to do */
  KITH_PARAM_EXPRESSIONS, /* struct kith_expression *[n], owned: n to 3 of them, of which the first n count */
  KITH_PARAM_VECTOR,      /* double[n]: n to 3 entries, of which the first n count */
  KITH_PARAM_INTERVAL,    /* double[2]: [a, b], a < b */
  KITH_PARAM_SIDES,       /* double[2]: a number for both, or [left, right] */
  KITH_PARAM_MEMBER,      /* struct kith_selected: a member of row.family by name; its own parameters stand in
                          * the same map, beside the rows of this table (one such row in a table) */
  KITH_PARAM_MAP,         /* a map whose rows go into the same struct */
  KITH_PARAM_OTHER        /* known and documented here, read by its own code */
};
/* What an OTHER row with rows below it is: a single value, a map of them, maps by name, or a list of maps. */
enum kith_param_form { KITH_FORM_VALUE, KITH_FORM_MAP, KITH_FORM_NAMED, KITH_FORM_LIST };

/* What is the same for a member of any family; family.h gives kith_<family>_member(k). */
struct kith_member {
  const char *name, *doc; /* name NULL: there is no member k */
  const struct kith_param *params;
  size_t settings_size;
};
#define KITH_MEMBER(ops) ((struct kith_member){(ops)->name, (ops)->doc, (ops)->params, (ops)->settings_size})
typedef struct kith_member kith_family(int k);
/* What the header of a family declares and family.h defines: the member called `name` ('-' and '_' are the
 * same; NULL: there is none), all members (ended by NULL), and member k as one of any family. */
#define KITH_FAMILY_FUNCTIONS(prefix) KITH_FAMILY_FUNCTIONS_OF(prefix, prefix##_ops)
/* For members of type struct TYPE. */
#define KITH_FAMILY_FUNCTIONS_OF(prefix, type)        \
  const struct type *prefix##_find(const char *name); \
  const struct type *const *prefix##_all(void);       \
  struct kith_member prefix##_member(int k)
/* A member chosen by name, with its settings: kith_resize memory owned by this struct, or NULL. */
struct kith_selected {
  char name[32];
  void *settings;
};

struct kith_param {
  const char *key; /* NULL ends a table */
  enum kith_param_kind kind;
  const char *fallback; /* default, as it is written, in a scene also {1d: a, 2d: b, 3d: c}; NULL: required;
                         * "": the value stays as it is */
  const char *allowed;  /* range "(0, 1]" or choices "a|b|c"; "": any */
  const char *doc;
  size_t offset, size;
  const struct kith_param *params; /* MAP: its rows; OTHER: rows for the reference */
  enum kith_param_form form;
  kith_family *family;     /* MEMBER, NAME: who can be chosen; NULL: none */
  bool derives;            /* MEMBER: what a member requires need not be given if it follows from the scene */
  bool given;              /* a required row of such a member that never follows: it must be given */
  bool restart_may_change; /* the state does not depend on it; of a map: nor on anything in it */
  const char *needs;       /* "steps=block", "name!=none": the row means nothing unless another row has this
                              * value, or has another value than this */
};

/* A row ends with one of these: where its value goes, or the rows below it. */
#define KITH_INTO(type, member) .offset = offsetof(type, member), .size = sizeof(((type *)0)->member)
#define KITH_BELOW(rows, as) .params = (rows), .form = KITH_FORM_##as

/* In the ops of a member: its table, and the struct that the table fills. */
#define KITH_SETTINGS(table, tag) .params = (table), .settings_size = sizeof(struct tag)

/* The member called `name` ('-' and '_' are the same); its name is NULL if there is none. */
struct kith_member kith_family_member(kith_family *family, const char *name);

/* The row called `key`, or NULL. */
const struct kith_param *kith_params_find(const struct kith_param *params, const char *key);

/* One value from text: numbers and names of any kind but EXPRESSION(S), MAP and OTHER; entries of VECTOR,
 * INTERVAL and SIDES stand between commas, brackets may be around them; MEMBER gets the name only. BAD_INPUT
 * with what is wrong with the text, without saying where it was. */
kith_status kith_param_parse(const struct kith_param *param, const char *text, void *into);
/* Is the text a number, finite or not? */
bool kith_param_is_number(const char *text);
/* The value in the struct at `base` as text that kith_param_parse reads back; doubles with all digits that
 * they need. Empty for EXPRESSION(S), MAP and OTHER. */
void kith_param_format(const struct kith_param *param, const void *base, char *text, size_t size);

/* "|a|b|c": the names of all members. */
void kith_family_choices(kith_family *family, char *choices, size_t size);
/* Sets all values that have a default; required numbers become NaN, so that kith_params_check finds them. */
kith_status kith_params_defaults(const struct kith_param *params, void *base);
/* BAD_INPUT "WHO: KEY is VALUE, must be in RANGE" for the first number that is not in its range. */
kith_status kith_params_check(const struct kith_param *params, const char *who, const void *base);

/* Frees the settings that the struct at `base` owns through rows of kind MEMBER. */
void kith_params_clear(const struct kith_param *params, void *base);

/* Settings of a member in kith_resize memory, owned by the caller: defaults, and over these "key=value" pairs
 * parted by blanks (NULL: none). *out is NULL for a member without parameters. */
kith_status kith_settings_create(void **out, struct kith_member member, const char *assignments);
/* The number in its family of the member that the first `length` letters of a text choose, and its settings:
 * "NAME", or "NAME: KEY=VALUE KEY=VALUE". BAD_INPUT "WHAT: ..." if there is none of that name. */
kith_status kith_family_choose(kith_family *family, const char *what, const char *text, size_t length,
                               int *member, void **settings);
/* "name:key=value key=value": all single values of a member, or its name if it has none. */
void kith_settings_format(struct kith_member member, const void *settings, char *text, size_t size);

#endif
