/* list.c - `kith list`: what a scene can choose from, family by family, with the doc of each member from its
 * own table.
 *
 * Subject: none (all families), the name of a family (with the parameters of its members), or `scene` (every
 * key of a scene). USAGE for anything else. */
#include "app/cli/options.h"

#include <stdio.h>
#include <string.h>
#include "app/scene/scene.h"
#include "app/cli/text.h"
#include "lib/core/choices.h"
#include "integrator/integrator.h"
#include "integrator/schemes/arkode.h"
#include "lib/connectivity/list.h"
#include "physics/passes/viscosity.h"

/* Tables of what is not a family of objects. */
#define NAMED(name, doc) {#name, doc, NULL, 0},
#define LISTED(name, word, doc) {#word, doc, NULL, 0},
#define KERNEL(name, word, doc, ...) {word, doc, NULL, 0},
#define TABLE(constant, word) {#word, "", NULL, 0},
static const struct kith_member kernels[] = {KITH_KERNEL_LIST(KERNEL){0}},
                                viscosities[] = {KITH_VISCOSITY_LIST(LISTED){0}},
                                lattices[] = {KITH_LATTICE_LIST(LISTED){0}},
                                measures[] = {KITH_MEASURE_LIST(NAMED){0}},
                                tables[] = {KITH_TABLE_LIST(TABLE){0}};

static const struct family {
  const char *name, *doc, *key; /* the key of a scene that chooses a member */
  kith_family *family;
  const struct kith_member *members;
} families[] = {
    {"package", "what is computed on pairs", "method.package", .family = kith_package_member},
    {"added", "what acts on top of the package", "packages", .family = kith_added_member},
    {"kernel", "interpolation", "method.kernel", .members = kernels},
    {"viscosity", "artificial viscosity", "method.viscosity.name", .members = viscosities},
    {"eos", "equation of state", "materials.NAME.eos", .family = kith_eos_member},
    {"scheme", "how the state is advanced", "scheme.name", .family = kith_scheme_member},
    {"table", "Runge-Kutta tables of arkode, by stages, order of the error, order", "scheme.table",
     .members = tables},
    {"search", "neighbor search", "neighbor.search", .family = kith_search_member},
    {"partitioner", "which rank has which cell", "partition.name", .family = kith_partitioner_member},
    {"rebuild", "when neighbor lists are rebuilt, joined by |", "connectivity.rebuild",
     .family = kith_rebuild_member},
    {"excluder", "pairs that are left out, joined by |", "connectivity.exclude",
     .family = kith_excluder_member},
    {"storage", "how lists of probes and contacts are kept", "connectivity.storage",
     .family = kith_storage_member},
    {"boundary", "what a side of the domain is", "boundaries.x", .family = kith_scene_side_member},
    {"lattice", "how a region is filled", "regions.N.lattice", .members = lattices},
    {"exact", "what a run is compared with; much of it follows from the scene", "exact.name",
     .family = kith_exact_member},
    {"measure", "what is measured at the end, where no exact solution tells it", "measure.NAME",
     .members = measures},
};
enum { FAMILIES = sizeof families / sizeof families[0] };

static struct kith_member member_of(const struct family *family, int k) {
  return family->members != NULL ? family->members[k] : family->family(k);
}

/* Finds the row of a key in a table or in a map of it; NULL: none. */
static const struct kith_param *find_row(const struct kith_param *params, const char *key) {
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    const struct kith_param *row = p->kind == KITH_PARAM_MAP  ? find_row(p->params, key)
                                   : strcmp(p->key, key) == 0 ? p
                                                              : NULL;
    if (row != NULL) return row;
  }
  return NULL;
}
/* Has the last member above that has the key of `row` explained it in the same words? */
static bool is_explained(const struct family *family, int member, const struct kith_param *row) {
  const struct kith_param *above = NULL;
  for (int k = member - 1; k >= 0 && above == NULL; --k)
    above = find_row(member_of(family, k).params, row->key);
  return above != NULL && strcmp(above->doc, row->doc) == 0;
}

/* Appends "; key (default): what it means" of each parameter, those of a map as "map.key". What has been
 * explained above is only named. */
static void add_params(char *text, size_t size, const struct family *family, int member, const char *map,
                       const struct kith_param *params) {
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    const bool explained = p->kind != KITH_PARAM_MAP && is_explained(family, member, p);
    if (p->kind == KITH_PARAM_MAP)
      add_params(text, size, family, member, p->key, p->params);
    else
      kith_text_add(text, size, "; %s%s%s (%s)%s%s", map, map[0] != '\0' ? "." : "", p->key,
                    p->fallback != NULL ? p->fallback : "required", explained ? "" : ": ",
                    explained ? "" : p->doc);
  }
}

static void print_family(const struct family *family, bool with_params) {
  printf("  %-11s %s (%s)\n", family->name, family->doc, family->key);
  for (int k = 0;; ++k) {
    const struct kith_member m = member_of(family, k);
    char text[1024], label[40];
    if (m.name == NULL) return;
    snprintf(text, sizeof text, "%s", m.doc);
    if (with_params) add_params(text, sizeof text, family, k, "", m.params);
    snprintf(label, sizeof label, "    %s", m.name);
    if (family->members != measures)
      kith_choices_format(m.name, label + 4, sizeof label - 4); /* measures are keys, written as they are */
    kith_text_wrapped(26, label, text);
  }
}

enum kith_exit kith_list(const struct kith_options *options) {
  enum { ALL = -1, SCENE, FAMILY }; /* FAMILY + f: the family f */
  char subjects[512] = "scene";
  const struct kith_param row = {.kind = KITH_PARAM_CHOICE, .allowed = subjects, .size = sizeof(int)};
  int subject = ALL;
  for (int f = 0; f < FAMILIES; ++f) strcat(strcat(subjects, "|"), families[f].name);
  if (options->subject != NULL && kith_param_parse(&row, options->subject, &subject) != KITH_OK) {
    fprintf(stderr, "kith: list: %s\n", kith_failure());
    return KITH_EXIT_USAGE;
  }
  if (subject == SCENE) kith_scene_reference(stdout);
  for (int f = 0; f < FAMILIES; ++f) {
    if (subject == ALL && f > 0) putchar('\n');
    if (subject == ALL || subject == FAMILY + f) print_family(&families[f], subject != ALL);
  }
  return KITH_EXIT_OK;
}
