/* main.c - the program of one dimension: kith-1d, kith-2d, kith-3d. */
#include <stdio.h>
#include <string.h>
#include <omp.h>
#include "app/bench.h"
#include "app/list.h"
#include "app/options.h"
#include "app/plan.h"
#include "app/run.h"
#include "app/validate.h"

int main(int argc, char **argv) {
  static const struct {
    const char *verb;
    enum kith_exit (*act)(const struct kith_options *);
  } verbs[] = {{"run", kith_run}, {"plan", kith_plan}, {"list", kith_list}, {"bench", kith_bench}, {"validate", kith_validate}};
  struct kith_options options;
  kith_options_parse(&options, argc, argv);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  for (size_t k = 0; k < sizeof verbs / sizeof verbs[0]; ++k)
    if (strcmp(options.verb, verbs[k].verb) == 0) return verbs[k].act(&options);
  fprintf(stderr, "kith: %s: no such verb; run, plan, list, bench or validate (see --help)\n", options.verb);
  return KITH_EXIT_USAGE;
}
