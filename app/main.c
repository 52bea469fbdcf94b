#include <omp.h>
#include <string.h>
#include "app/options.h"
#include "app/run.h"
#include "app/validate.h"
int main(int argc, char **argv) {
  struct kith_options options;
  kith_options_parse(&options, argc, argv);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  if (strcmp(options.verb, "validate") == 0) return kith_validate(&options);
  return kith_run(&options);
}
