#include "app/validate_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/keys.h"
#include "app/options.h"
#include "app/validate_cover.h"

#define IN(member) KITH_INTO(struct kith_row, member)
static const struct kith_key row_keys[] = {
    {"name", KITH_KEY_NAME, "", "", "what it is called, and its directory", IN(name)},
    {"quick", KITH_KEY_BOOL, "", "", "takes seconds", IN(quick)},
    {"dimension", KITH_KEY_INTEGER, "", "[0, 3]", "of the scene", IN(dimension)},
    {"scene", KITH_KEY_NAME, "", "", "one of inputs; none: the run of the row before", IN(scene)},
    {"settings", KITH_KEY_NAME, "", "", "key=value, parted by blanks", IN(settings)},
    {"ranks", KITH_KEY_INTEGER, "", "[0, 1000]", "processes", IN(ranks)},
    {"threads", KITH_KEY_INTEGER, "", "[0, 1000]", "threads of each", IN(threads)},
    {"measure", KITH_KEY_NAME, "", "",
     "a key of the report or A / B, shock, order N, same norms, balance, threads or restart N", IN(measure)},
    {"at_most", KITH_KEY_NUMBER, "", "", "the bound", IN(at_most)},
    {"at_least", KITH_KEY_NUMBER, "", "", "the bound", IN(at_least)},
    {"same", KITH_KEY_NAME, "", "", "bits, or a part of the largest value of a field", IN(same)},
    {"like", KITH_KEY_NAME, "", "", "the row whose last snapshot is the same", IN(like)},
    {"source", KITH_KEY_NAME, "", "", "of the bound", IN(source)},
    {"over", KITH_KEY_OTHER, "", "", "of a group: its factors and their values", KITH_BELOW(NULL, MAP)},
    {"rows", KITH_KEY_OTHER, "", "", "of a group: its rows", KITH_BELOW(NULL, LIST)},
    {0}};

/* ---- a row ---- */

static void read_measure(struct kith_row *row) {
  static const char *const word[] = {"",        "shock",   "order %d",   "same norms",
                                     "balance", "threads", "restart %d", ""};
  row->kind = row->measure[0] == '\0' ? KITH_ROW_NOTHING : KITH_ROW_VALUE;
  for (int k = KITH_ROW_SHOCK; k <= KITH_ROW_RESTART; ++k) {
    const bool numbered = strchr(word[k], '%') != NULL;
    if (numbered ? sscanf(row->measure, word[k], &row->number) == 1 : strcmp(row->measure, word[k]) == 0)
      row->kind = (enum kith_row_kind)k;
  }
}

static kith_status read_same(const struct kith_config_node *node, struct kith_row *row) {
  char *end = row->same;
  if (strcmp(row->same, "bits") == 0 || row->same[0] == '\0') return KITH_OK;
  row->tolerance = strtod(row->same, &end);
  if (*end != '\0' || !(row->tolerance > 0 && row->tolerance < 1))
    return kith_config_fail(node, "same", "'%s' is neither bits nor a number between 0 and 1", row->same);
  return KITH_OK;
}

static kith_status check_row(const struct kith_config_node *node, const struct kith_row *row) {
  if (row->name[0] == '\0') return kith_config_fail(node, "name", "missing");
  if (kith_config_child(node, "over") != NULL || kith_config_child(node, "rows") != NULL)
    return kith_config_fail(node, NULL, "row %s is no group: over and rows belong to one", row->name);
  if (row->kind == KITH_ROW_NOTHING && row->same[0] == '\0')
    return kith_config_fail(node, NULL, "row %s needs a measure or same", row->name);
  if (row->kind != KITH_ROW_NOTHING && isnan(row->at_most) == isnan(row->at_least))
    return kith_config_fail(node, NULL, "row %s needs one bound, at_most or at_least", row->name);
  if ((row->scene[0] != '\0') != (row->dimension > 0))
    return kith_config_fail(node, NULL, "row %s: scene and dimension come together", row->name);
  if (row->same[0] != '\0' && (row->kind == KITH_ROW_THREADS || row->kind == KITH_ROW_RESTART))
    return kith_config_fail(node, "same", "'%s' has runs of its own: no one of them is compared",
                            row->measure);
  if ((row->kind == KITH_ROW_ORDER || row->kind == KITH_ROW_RESTART) && row->number < 1)
    return kith_config_fail(node, "measure", "'%s': the number must be positive", row->measure);
  return KITH_OK;
}

/* `row` holds what its group says. */
static kith_status read_row(const struct kith_config_node *node, struct kith_row *row) {
  char settings[512];
  snprintf(settings, sizeof settings, "%s", row->settings);
  row->settings[0] = '\0';
  KITH_TRY(kith_config_want_map(node));
  KITH_TRY(kith_keys_read(row_keys, node, row));
  const size_t length = strlen(settings) + strlen(row->settings) + 2;
  if (length > sizeof settings) return kith_config_fail(node, "settings", "too long with those of its group");
  snprintf(settings + strlen(settings), sizeof settings - strlen(settings), "%s%s",
           settings[0] != '\0' ? " " : "", row->settings);
  memcpy(row->settings, settings, sizeof settings);
  read_measure(row);
  return read_same(node, row);
}

/* ---- a group ---- */

struct rows {
  struct kith_row *row;
  int n, room;
};

static kith_status add_row(struct rows *rows, const struct kith_row *row) {
  if (rows->n == rows->room) {
    rows->room = 2 * rows->room + 64;
    KITH_TRY(kith_resize(&rows->row, (size_t)rows->n, (size_t)rows->room, sizeof *rows->row));
  }
  rows->row[rows->n++] = *row;
  return KITH_OK;
}

/* Gives a row the value of a factor. */
static kith_status vary(struct kith_row *row, const struct kith_config_node *value) {
  static const struct kith_key count = {"", KITH_KEY_INTEGER, NULL, "[1, 1000]", "", 0, sizeof(int), NULL, 0};
  const char *factor = value->parent->key;
  if (value->kind != KITH_CONFIG_SCALAR || value->null)
    return kith_config_fail(value, NULL, "a value of a factor is one word or number");
  if (strcmp(factor, "ranks") == 0) return kith_key_value(&count, value, &row->ranks);
  if (strcmp(factor, "threads") == 0) return kith_key_value(&count, value, &row->threads);
  const size_t settings = strlen(row->settings), varied = strlen(row->varied);
  if (settings + strlen(factor) + strlen(value->text) + 3 > sizeof row->settings ||
      varied + strlen(value->text) + 2 > sizeof row->varied)
    return kith_config_fail(value, NULL, "too much to set in one row");
  snprintf(row->settings + settings, sizeof row->settings - settings, " %s=%s", factor, value->text);
  snprintf(row->varied + varied, sizeof row->varied - varied, "%s%s", varied > 0 ? " " : "", value->text);
  return KITH_OK;
}

/* sod.4x2.kd.grid: a directory too. */
static void name_varied(struct kith_row *row) {
  char *name = row->name;
  const size_t size = sizeof row->name;
  snprintf(name + strlen(name), size - strlen(name), ".%dx%d%s%.60s", row->ranks, row->threads,
           row->varied[0] != '\0' ? "." : "", row->varied);
  for (char *c = name; *c != '\0'; ++c)
    if (*c == ' ' || *c == ':' || *c == ',') *c = '.';
}

static const struct kith_config_node *entry(const struct kith_config_node *list, int index) {
  const struct kith_config_node *child = list->first;
  while (index-- > 0) child = child->next;
  return child;
}

/* One combination: value[f] of each factor. */
static kith_status add_varied(struct rows *rows, const struct kith_row *like,
                              const struct kith_config_node *over, const int *value) {
  struct kith_row row = *like;
  snprintf(row.like, sizeof row.like, "%s", like->name);
  for (const struct kith_config_node *factor = over->first; factor != NULL; factor = factor->next)
    KITH_TRY(vary(&row, entry(factor, *value++)));
  if (strlen(row.name) + strlen(row.varied) + 12 > sizeof row.name)
    return kith_config_fail(over, NULL, "row %s: the name is too long with its values", like->name);
  name_varied(&row);
  return add_row(rows, &row);
}

/* The rows as they are, each with its combinations behind it. */
static kith_status add_covered(struct rows *rows, const struct kith_row *group,
                               const struct kith_config_node *list, const struct kith_config_node *over,
                               const int *cover, int n_cover) {
  const int n = over->n + 1;
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    struct kith_row row = *group;
    KITH_TRY(read_row(node, &row));
    KITH_TRY(check_row(node, &row));
    if (row.dimension == 0) return kith_config_fail(node, "scene", "missing: a row of a group is a run");
    row.ranks = row.threads = 1;
    KITH_TRY(add_row(rows, &row));
    for (int k = 0; k < n_cover; ++k)
      if (cover[k * n] == node->index) KITH_TRY(add_varied(rows, &row, over, cover + k * n + 1));
  }
  return KITH_OK;
}

static kith_status check_group(const struct kith_config_node *node, const struct kith_config_node *list,
                               const struct kith_config_node *over) {
  KITH_TRY(kith_config_want_list(list));
  if (over == NULL) return kith_config_fail(node, "over", "missing: what a group is run over");
  KITH_TRY(kith_config_want_map(over));
  if (list->n == 0 || over->n == 0 || over->n >= KITH_COVER_FACTORS)
    return kith_config_fail(node, NULL, "a group needs rows, and 1 to %d factors", KITH_COVER_FACTORS - 1);
  for (const struct kith_config_node *factor = over->first; factor != NULL; factor = factor->next) {
    KITH_TRY(kith_config_want_list(factor));
    if (factor->n == 0) return kith_config_fail(factor, NULL, "a factor without values");
  }
  return KITH_OK;
}

static kith_status read_group(const struct kith_config_node *node, struct kith_row *group,
                              struct rows *rows) {
  const struct kith_config_node *list = kith_config_child(node, "rows"),
                                *over = kith_config_child(node, "over");
  int count[KITH_COVER_FACTORS], *cover = NULL, n_cover = 0, n = 0;
  KITH_TRY(check_group(node, list, over));
  KITH_TRY(read_row(node, group));
  count[n++] = list->n;
  for (const struct kith_config_node *factor = over->first; factor != NULL; factor = factor->next)
    count[n++] = factor->n;
  kith_status status = kith_cover(n, count, &cover, &n_cover);
  if (status == KITH_OK) status = add_covered(rows, group, list, over, cover, n_cover);
  kith_free(&cover);
  return status;
}

/* ---- a file ---- */

static bool is_there(const struct rows *rows, const char *name) {
  for (int k = 0; k < rows->n; ++k)
    if (strcmp(rows->row[k].name, name) == 0) return true;
  return false;
}

static kith_status read_single(const struct kith_config_node *node, struct kith_row *row, struct rows *rows) {
  KITH_TRY(read_row(node, row));
  KITH_TRY(check_row(node, row));
  if (rows->n == 0 && row->dimension == 0)
    return kith_config_fail(node, NULL, "row %s: there is no run before it", row->name);
  if ((row->same[0] != '\0') != (row->like[0] != '\0'))
    return kith_config_fail(node, NULL, "row %s: same and like come together", row->name);
  if (row->like[0] != '\0' && !is_there(rows, row->like))
    return kith_config_fail(node, "like", "there is no row '%s' above", row->like);
  return add_row(rows, row);
}

static kith_status read_rows(struct rows *rows, const struct kith_config *config) {
  const struct kith_config_node *list = kith_config_at(config, "rows");
  if (list == NULL)
    return kith_config_fail(config->root, NULL, "no rows: a file for validation has a list of them");
  KITH_TRY(kith_config_want_list(list));
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    struct kith_row row = {.at_most = NAN, .at_least = NAN};
    KITH_TRY(kith_config_child(node, "rows") != NULL ? read_group(node, &row, rows)
                                                     : read_single(node, &row, rows));
  }
  return KITH_OK;
}

kith_status kith_rows_read_file(struct kith_row **out, int *n, const char *path) {
  struct kith_config *config = NULL;
  struct rows rows = {0};
  KITH_TRY(kith_config_read(&config, path));
  const kith_status status = read_rows(&rows, config);
  kith_config_destroy(&config);
  if (status != KITH_OK) kith_free(&rows.row);
  *out = rows.row;
  *n = rows.n;
  return status;
}
