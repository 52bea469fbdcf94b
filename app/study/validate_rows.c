/* validate_rows.c - reads rows and groups of rows. */
#include "app/study/validate_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/scene/params.h"

/* What the table reads of a row; the settings and the scene then go into the job. */
struct entry {
  struct kith_row row;
  char scene[256], settings[512];
};
#define IN(member) KITH_INTO(struct entry, member)
static const struct kith_param row_params[] = {
    {"name", KITH_PARAM_NAME, "", "", "what it is called, and its directory", IN(row.job.label)},
    {"quick", KITH_PARAM_BOOL, "", "", "takes seconds: a row of the quick suite", IN(row.quick)},
    {"scene", KITH_PARAM_NAME, "", "",
     "a scene of inputs, or a path from the folder of this file; none: measures the run of the row before",
     IN(scene)},
    {"dimension", KITH_PARAM_INTEGER, "", "[0, 3]", "none: the scene's", IN(row.job.dimension)},
    {"settings", KITH_PARAM_NAME, "", "", "those of --set, separated by blanks", IN(settings)},
    {"ranks", KITH_PARAM_INTEGER, "", "[0, 1000]", "processes", IN(row.job.ranks)},
    {"threads", KITH_PARAM_INTEGER, "", "[0, 1000]", "threads of each", IN(row.job.threads)},
    {"steps", KITH_PARAM_INTEGER, "", "[0, inf)", "ends the run after so many", IN(row.job.steps)},
    {"restart", KITH_PARAM_NAME, "", "", "the row above whose last checkpoint it continues", IN(row.restart)},
    {"measure", KITH_PARAM_NAME, "", "", "what is measured", IN(row.measure)},
    {"at_most", KITH_PARAM_NUMBER, "", "", "the bound; this, at_least or prints", IN(row.at_most)},
    {"at_least", KITH_PARAM_NUMBER, "", "", "the bound", IN(row.at_least)},
    {"prints", KITH_PARAM_NAME, "", "", "the figure that a document prints: holds to its last digit",
     IN(row.prints)},
    {"within", KITH_PARAM_NUMBER, "", "(0, 1)", "the part by which it may differ instead", IN(row.within)},
    {"same", KITH_PARAM_NAME, "", "",
     "how far the last snapshot is that of the row like: bits, or a fraction of the largest value of a field",
     IN(row.same)},
    {"like", KITH_PARAM_NAME, "", "", "a row above", IN(row.like)},
    {"source", KITH_PARAM_NAME, "", "", "where the bound is from", IN(row.source)},
    {"over", KITH_PARAM_OTHER, "", "", "of a group: its factors, each with a list of values",
     KITH_BELOW(NULL, MAP)},
    {"rows", KITH_PARAM_OTHER, "", "", "of a group: its rows", KITH_BELOW(NULL, LIST)},
    {0}};

static const struct kith_param file_params[] = {
    {"rows", KITH_PARAM_OTHER, NULL, "", "what is validated", KITH_BELOW(row_params, LIST)}, {0}};

void kith_rows_reference(void) {
  kith_params_reference(file_params, "a file for kith validate", stdout);
}

struct rows {
  const struct kith_programs *programs;
  struct kith_row *row;
  int n;
  size_t capacity;
};

static void read_measure(struct kith_row *row) {
  const char *text = row->measure;
  int end = 0;
  row->kind = text[0] == '\0'                   ? KITH_ROW_NOTHING
              : strcmp(text, "same norms") == 0 ? KITH_ROW_SAME_NORMS
              : strncmp(text, "order", 5) == 0  ? KITH_ROW_ORDER
                                                : KITH_ROW_VALUE;
  if (sscanf(text, "order %d%n", &row->number, &end) != 1 || text[end] != '\0') row->number = 0;
}

/* Checks a row, and sets its dimension, unless it is given, to that of the scene. */
static kith_status check_row(const struct kith_config_node *node, struct kith_row *row) {
  const char *name = row->job.label;
  if (name[0] == '\0') return kith_config_fail(node, "name", "missing");
  if (kith_config_child(node, "over") != NULL || kith_config_child(node, "rows") != NULL)
    return kith_config_fail(node, NULL, "row %s is no group: over and rows belong to one", name);
  if (row->kind == KITH_ROW_NOTHING && row->same[0] == '\0')
    return kith_config_fail(node, NULL, "row %s needs a measure or same", name);
  const int bounds = !isnan(row->at_most) + !isnan(row->at_least) + (row->prints[0] != '\0');
  if (row->kind != KITH_ROW_NOTHING && bounds != 1)
    return kith_config_fail(node, NULL, "row %s needs one bound: at_most, at_least, or prints", name);
  const bool scene = row->job.scene[0] != '\0', dimension = row->job.dimension > 0;
  if (dimension && !scene) return kith_config_fail(node, "dimension", "means nothing without scene");
  if (scene && !dimension) KITH_TRY(kith_scene_dimension(row->job.scene, 0, NULL, &row->job.dimension));
  char *end;
  strtod(row->prints, &end);
  if (*end != '\0') return kith_config_fail(node, "prints", "'%s' is no number", row->prints);
  if (row->kind == KITH_ROW_ORDER && row->number < 2)
    return kith_config_fail(node, "measure", "'%s' is not order N, with N at least 2", row->measure);
  char key[2][128];
  if (row->kind == KITH_ROW_VALUE && kith_measure_parse(row->measure, key) == 0)
    return kith_config_fail(node, "measure", "'%s' is no measure: A, A / B or A / B - 1", row->measure);
  return KITH_OK;
}

/* Reads a row; `row` holds what its group says. */
static kith_status read_row(const struct rows *rows, const struct kith_config_node *node,
                            struct kith_row *row) {
  struct entry entry = {.row = *row};
  KITH_TRY(kith_config_want(node, KITH_CONFIG_MAP));
  KITH_TRY(kith_params_read(row_params, node, &entry));
  *row = entry.row;
  if (entry.scene[0] != '\0')
    KITH_TRY(
        kith_programs_scene(rows->programs, kith_config_child(node, "scene"), entry.scene, row->job.scene));
  char *rest = entry.settings;
  for (const char *word; (word = strsep(&rest, " ")) != NULL;)
    if (word[0] != '\0' && kith_job_set(&row->job, word) != KITH_OK)
      return kith_config_fail(node, "settings", "%s", kith_failure());
  row->job.line = node->location.line;
  read_measure(row);
  row->tolerance = 0; /* not the tolerance of the group */
  if (strcmp(row->same, "bits") == 0 || row->same[0] == '\0') return KITH_OK;
  char *end;
  row->tolerance = strtod(row->same, &end);
  if (*end != '\0' || !(row->tolerance > 0 && row->tolerance < 1))
    return kith_config_fail(node, "same", "'%s' is neither bits nor a number between 0 and 1", row->same);
  return KITH_OK;
}

/* Appends a row. Its name is that of its directory, which is emptied before it runs. */
static kith_status add_row(struct rows *rows, const struct kith_config_node *node,
                           const struct kith_row *row) {
  const size_t n = (size_t)rows->n;
  const char *name = row->job.label;
  int measured = 0; /* rows above that measure at a resolution */
  if (name[0] == '.' || strchr(name, '/') != NULL)
    return kith_config_fail(node, "name", "'%s' is no name of a directory: without '/', not begun with '.'",
                            name);
  for (int k = 0; k < rows->n; ++k)
    if (strcmp(rows->row[k].job.label, name) == 0)
      return kith_config_fail(node, "name", "there is a row '%s' above", name);
  for (int k = 0; k < rows->n; ++k)
    measured +=
        rows->row[k].kind == KITH_ROW_VALUE && strstr(rows->row[k].job.settings, "resolution=") != NULL;
  if (row->kind == KITH_ROW_ORDER && measured < row->number)
    return kith_config_fail(node, "measure", "'%s' of %d rows above that measure at a resolution",
                            row->measure, measured);
  KITH_TRY(kith_grow(&rows->row, &rows->capacity, n, n + 1, sizeof *rows->row));
  rows->row[rows->n++] = *row;
  return KITH_OK;
}

/* Gives a row the value of a factor, and adds that to its name, which is also the name of a directory. */
static kith_status vary(struct kith_row *row, const struct kith_config_node *value) {
  const char *factor = value->parent->key;
  char text[160], *name = row->job.label;
  if (value->kind != KITH_CONFIG_SCALAR || value->null)
    return kith_config_fail(value, NULL, "a value of a factor is one word or number");
  const size_t used = strlen(row->varied), named = strlen(name), length = strlen(value->text);
  if (used + length + 2 > sizeof row->varied || named + length + 2 > sizeof row->job.label ||
      strlen(factor) > 80)
    return kith_config_fail(value, NULL, "too much to set in one row");
  kith_text_join(row->varied, sizeof row->varied, " ", "%s", value->text);
  kith_text_add(name, sizeof row->job.label, ".%s", value->text);
  for (char *c = name + named; *c != '\0'; ++c)
    if (strchr(" :,/", *c) != NULL) *c = '.';
  snprintf(text, sizeof text, "%s=%s", factor, value->text);
  return kith_job_set(&row->job, text) == KITH_OK ? KITH_OK
                                                  : kith_config_fail(value, NULL, "%s", kith_failure());
}

/* Adds run k of row i of a group (validate_rows.h). */
static kith_status add_varied(struct rows *rows, const struct kith_row *like, int i, int k,
                              const struct kith_config_node *over, const struct kith_config_node *longest) {
  struct kith_row row = *like;
  snprintf(row.like, sizeof row.like, "%s", like->job.label);
  for (const struct kith_config_node *factor = over->first; factor != NULL; factor = factor->next) {
    const struct kith_config_node *value = factor->first;
    for (int skip = (factor == longest ? k : i + k) % factor->n; skip > 0; --skip) value = value->next;
    KITH_TRY(vary(&row, value));
  }
  return add_row(rows, over, &row);
}

static kith_status read_group(const struct kith_config_node *node, struct kith_row *group,
                              struct rows *rows) {
  const struct kith_config_node *list = kith_config_child(node, "rows"),
                                *over = kith_config_child(node, "over");
  KITH_TRY(kith_config_want(list, KITH_CONFIG_LIST));
  if (over == NULL) return kith_config_fail(node, "over", "missing: what a group is run over");
  KITH_TRY(kith_config_want(over, KITH_CONFIG_MAP));
  if (list->n == 0 || over->n == 0) return kith_config_fail(node, NULL, "a group needs rows and factors");
  const struct kith_config_node *longest = over->first;
  for (const struct kith_config_node *factor = over->first; factor != NULL; factor = factor->next) {
    KITH_TRY(kith_config_want(factor, KITH_CONFIG_LIST));
    if (factor->n == 0) return kith_config_fail(factor, NULL, "a factor without values");
    if (factor->n > longest->n) longest = factor;
  }
  KITH_TRY(read_row(rows, node, group));
  for (const struct kith_config_node *child = list->first; child != NULL; child = child->next) {
    struct kith_row row = *group;
    KITH_TRY(read_row(rows, child, &row));
    KITH_TRY(check_row(child, &row));
    if (row.job.dimension == 0) return kith_config_fail(child, "scene", "missing: a row of a group is a run");
    row.job.ranks = row.job.threads = 1;
    KITH_TRY(add_row(rows, child, &row));
    for (int k = 0; k < longest->n; ++k) KITH_TRY(add_varied(rows, &row, child->index, k, over, longest));
  }
  return KITH_OK;
}

static kith_status check_above(const struct rows *rows, const struct kith_config_node *node, const char *key,
                               const char *name) {
  bool found = name[0] == '\0';
  for (int k = 0; k < rows->n && !found; ++k) found = strcmp(rows->row[k].job.label, name) == 0;
  return found ? KITH_OK : kith_config_fail(node, key, "there is no row '%s' above", name);
}

static kith_status read_single(const struct kith_config_node *node, struct kith_row *row, struct rows *rows) {
  KITH_TRY(read_row(rows, node, row));
  KITH_TRY(check_row(node, row));
  if (rows->n == 0 && row->job.dimension == 0)
    return kith_config_fail(node, NULL, "row %s: there is no run before it", row->job.label);
  if ((row->same[0] != '\0') != (row->like[0] != '\0'))
    return kith_config_fail(node, NULL, "row %s: same and like come together", row->job.label);
  KITH_TRY(check_above(rows, node, "like", row->like));
  KITH_TRY(check_above(rows, node, "restart", row->restart));
  return add_row(rows, node, row);
}

static kith_status read_rows(const struct kith_config *config, struct rows *rows) {
  const struct kith_config_node *list = kith_config_at(config, "rows");
  if (list == NULL)
    return kith_config_fail(config->root, NULL, "no rows: a file for validation has a list of them");
  char none;
  KITH_TRY(kith_params_read(file_params, config->root, &none));
  KITH_TRY(kith_config_want(list, KITH_CONFIG_LIST));
  if (list->n == 0) return kith_config_fail(list, NULL, "an empty list");
  for (const struct kith_config_node *node = list->first; node != NULL; node = node->next) {
    struct kith_row row = {.at_most = NAN, .at_least = NAN};
    const bool group = kith_config_child(node, "rows") != NULL;
    KITH_TRY(group ? read_group(node, &row, rows) : read_single(node, &row, rows));
  }
  return KITH_OK;
}

kith_status kith_rows_read_file(struct kith_row **out, int *n, const char *path,
                                const struct kith_programs *programs) {
  struct kith_config *config = NULL;
  struct rows rows = {.programs = programs};
  KITH_TRY(kith_config_read(&config, path));
  const kith_status status = read_rows(config, &rows);
  kith_config_destroy(&config);
  *out = rows.row;
  *n = rows.n;
  return status;
}
