#include "app/validate_rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "app/keys.h"

#define IN(member) KITH_INTO(struct kith_row, member)
static const struct kith_key row_keys[] = {
    {"name", KITH_KEY_NAME, NULL, "", "what it is called, and its directory", IN(name)},
    {"quick", KITH_KEY_BOOL, "false", "", "takes seconds", IN(quick)},
    {"dimension", KITH_KEY_INTEGER, "0", "[0, 3]", "of the scene", IN(dimension)},
    {"scene", KITH_KEY_NAME, "", "", "one of inputs; none: the run of the row before", IN(scene)},
    {"settings", KITH_KEY_NAME, "", "", "key=value, parted by blanks", IN(settings)},
    {"measure", KITH_KEY_NAME, NULL, "", "a key of the report, shock, order N, same, threads or restart N",
     IN(measure)},
    {"at_most", KITH_KEY_NUMBER, "", "", "the bound", IN(at_most)},
    {"at_least", KITH_KEY_NUMBER, "", "", "the bound", IN(at_least)},
    {"source", KITH_KEY_NAME, "", "", "of the bound", IN(source)},
    {0}};

static void read_measure(struct kith_row *row) {
  static const char *const word[] = {"", "shock", "order %d", "same", "threads", "restart %d"};
  row->kind = KITH_ROW_VALUE;
  for (int k = KITH_ROW_SHOCK; k <= KITH_ROW_RESTART; ++k) {
    const bool numbered = strchr(word[k], '%') != NULL;
    if (numbered ? sscanf(row->measure, word[k], &row->number) == 1 : strcmp(row->measure, word[k]) == 0)
      row->kind = (enum kith_row_kind)k;
  }
}

static kith_status read_row(const struct kith_config_node *node, struct kith_row *row) {
  *row = (struct kith_row){.at_most = NAN, .at_least = NAN};
  KITH_TRY(kith_config_want_map(node));
  KITH_TRY(kith_keys_read(row_keys, node, row));
  read_measure(row);
  if (isnan(row->at_most) == isnan(row->at_least))
    return kith_config_fail(node, NULL, "row %s needs one bound, at_most or at_least", row->name);
  if ((row->scene[0] != '\0') != (row->dimension > 0))
    return kith_config_fail(node, NULL, "row %s: scene and dimension come together", row->name);
  if ((row->kind == KITH_ROW_ORDER || row->kind == KITH_ROW_RESTART) && row->number < 1)
    return kith_config_fail(node, "measure", "'%s': the number must be positive", row->measure);
  return KITH_OK;
}

static kith_status read_rows(struct kith_row **rows, int *n, const struct kith_config *config) {
  const struct kith_config_node *list = kith_config_at(config, "rows");
  if (list == NULL)
    return kith_config_fail(config->root, NULL, "no rows: a file for validation has a list of them");
  KITH_TRY(kith_config_want_list(list));
  KITH_TRY(kith_resize(rows, 0, (size_t)list->n, sizeof **rows));
  *n = 0;
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    struct kith_row *row = &(*rows)[(*n)++];
    KITH_TRY(read_row(node, row));
    if (*n == 1 && row->dimension == 0)
      return kith_config_fail(node, NULL, "row %s: there is no run before it", row->name);
  }
  return KITH_OK;
}

kith_status kith_rows_read_file(struct kith_row **rows, int *n, const char *path) {
  struct kith_config *config = NULL;
  *rows = NULL;
  KITH_TRY(kith_config_read(&config, path));
  const kith_status status = read_rows(rows, n, config);
  kith_config_destroy(&config);
  if (status != KITH_OK) kith_free(rows);
  return status;
}
