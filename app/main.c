#include <omp.h>
#include "app/options.h"
#include "app/run.h"
int main(int argc, char **argv) {
  struct kith_options options;
  kith_options_parse(&options, argc, argv);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  return kith_run(&options);
}
