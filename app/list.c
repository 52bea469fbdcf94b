#include "app/list.h"

#include <stdio.h>
#include <string.h>
#include "app/scene.h"
#include "app/text.h"
#include "app/words.h"
#include "integrator/integrator.h"
#include "lib/connectivity/excluder.h"

static void member(const char *name, const char *doc) {
  char label[32] = "    ";
  kith_words_tell(name, label + 4, sizeof label - 4); /* '_' as '-' */
  kith_text_wrapped(stdout, 26, label, doc);
}

#define PRINT_OPS(family)                                                    \
  static void print_##family(void) {                                         \
    for (int k = 0; kith_##family##_all()[k] != NULL; ++k)                   \
      member(kith_##family##_all()[k]->name, kith_##family##_all()[k]->doc); \
  }
PRINT_OPS(search)
PRINT_OPS(partitioner)
PRINT_OPS(rebuild)
PRINT_OPS(boundary)
PRINT_OPS(eos)
PRINT_OPS(package)
PRINT_OPS(scheme)
PRINT_OPS(exact)

static void print_kernel(void) {
  for (int k = 0; k < KITH_N_KERNELS; ++k) member(kith_kernel_facts[k].name, kith_kernel_facts[k].doc);
}

#define MEMBER(name, doc) member(#name, doc);
#define LISTED(name, word, doc) member(#word, doc);
static void print_excluder(void) {
  KITH_EXCLUDER_LIST(MEMBER)
}
static void print_viscosity(void) {
  KITH_VISCOSITY_LIST(LISTED)
}
static void print_balsara(void) {
  KITH_BALSARA_LIST(LISTED)
}
static void print_faces(void) {
  KITH_FACES_LIST(LISTED)
}
static void print_lattice(void) {
  KITH_LATTICE_LIST(LISTED)
}

/* Keys as they are written: with '_'. */
#define KEY(name, doc) kith_text_wrapped(stdout, 26, "    " #name, doc);
static void print_measure(void) {
  KITH_MEASURE_LIST(KEY)
}

static void print_one_table(const char *name) {
  struct kith_table table;
  char doc[64], error[32] = "no error estimate", label[40] = "    ";
  if (kith_table_read(&table, name) != KITH_OK) return;
  if (table.embedded > 0) snprintf(error, sizeof error, "errors by order %d", table.embedded);
  snprintf(doc, sizeof doc, "order %d, %s; %d evaluations a step", table.order, error, table.evaluations);
  kith_words_tell(name, label + 4, sizeof label - 4);
  kith_text_wrapped(stdout, 28, label, doc);
}
#define TABLE(constant, word) print_one_table(#word);
static void print_table(void) {
  KITH_TABLE_LIST(TABLE)
}

static const struct family {
  const char *name, *doc, *key; /* key of a scene that chooses */
  void (*print)(void);
} families[] = {
    {"package", "what is computed on pairs", "method.package", print_package},
    {"kernel", "interpolation", "method.kernel", print_kernel},
    {"viscosity", "what makes shocks", "method.viscosity.name", print_viscosity},
    {"balsara", "what keeps viscosity out of shear", "method.viscosity.balsara", print_balsara},
    {"faces", "between nodes", "method.faces", print_faces},
    {"eos", "equation of state", "materials.NAME.eos", print_eos},
    {"scheme", "how the state is advanced", "scheme.name", print_scheme},
    {"table", "Runge-Kutta tables of arkode", "scheme.table", print_table},
    {"search", "who may be near", "neighbor.search", print_search},
    {"partitioner", "which rank has which cell", "partition.name", print_partitioner},
    {"rebuild", "when lists are made anew, joined by |", "connectivity.rebuild", print_rebuild},
    {"excluder", "who is no neighbor, however near", "for packages", print_excluder},
    {"boundary", "where ghosts come from", "boundaries.x", print_boundary},
    {"lattice", "how a region is filled", "regions.N.lattice", print_lattice},
    {"exact", "what a run is compared with", "exact.name", print_exact},
    {"measure", "what a scene is about, where that is no distance from a solution", "measure.NAME",
     print_measure},
};
enum { FAMILIES = sizeof families / sizeof families[0] };

static void print_family(const struct family *family) {
  printf("  %-11s %s (%s)\n", family->name, family->doc, family->key);
  family->print();
}

static enum kith_exit refuse(const char *name) {
  char words[512] = "", told[512], near[64];
  for (int f = 0; f < FAMILIES; ++f) {
    strcat(words, families[f].name);
    strcat(words, "|");
  }
  strcat(words, "scene");
  if (kith_words_nearest(words, name, near, sizeof near)) {
    fprintf(stderr, "kith: list: '%.60s' is no family; did you mean '%s'?\n", name, near);
  } else {
    kith_words_tell(words, told, sizeof told);
    fprintf(stderr, "kith: list: '%.60s' is no family; there are %s\n", name, told);
  }
  return KITH_EXIT_USAGE;
}

enum kith_exit kith_list(const struct kith_options *options) {
  if (options->subject == NULL) {
    for (int f = 0; f < FAMILIES; ++f) {
      if (f > 0) putchar('\n');
      print_family(&families[f]);
    }
    return KITH_EXIT_OK;
  }
  if (strcmp(options->subject, "scene") == 0) {
    kith_scene_reference(stdout);
    return KITH_EXIT_OK;
  }
  for (int f = 0; f < FAMILIES; ++f) {
    if (strcmp(options->subject, families[f].name) != 0) continue;
    print_family(&families[f]);
    return KITH_EXIT_OK;
  }
  return refuse(options->subject);
}
