#include <omp.h>
#include <stddef.h>
#include <stdio.h>
#include "app/bench.h"
#include "app/chart.h"
#include "app/list.h"
#include "app/options.h"
#include "app/plan.h"
#include "app/run.h"
#include "app/stress.h"
#include "app/validate.h"

static const struct kith_verb verbs[] = {
    {"run", "SCENE", "runs a scene and compares it with its exact solution", kith_run},
    {"plan", "SCENE",
     "what a scene will build and why, memory, time step, cost, cheaper forms; nothing is written",
     kith_plan},
    {"list", "[FAMILY]", "what a scene can choose from; 'list scene': every key of a scene", kith_list},
    {"bench", "[SCENE]",
     "node updates per second, stage by stage, beside reference loops; with --ranks: what ranks cost",
     kith_bench},
    {"validate", "[SUITE]", "runs the scenes with their tolerances; 'validate list': the suites",
     kith_validate},
    {"chart", "SCENE|SUITE", "error against cost, for a matrix of methods; 'chart list': the suites",
     kith_chart},
    {"stress", "[SWEEP]", "where methods stop working, one knob at a time; 'stress list': the sweeps",
     kith_stress},
    {NULL, NULL, NULL, NULL}};

int main(int argc, char **argv) {
  struct kith_options options;
  const struct kith_verb *verb = kith_options_parse(&options, argc, argv, verbs);
  if (options.threads > 0) omp_set_num_threads(options.threads);
  if (options.ranks > 1 && verb->act != kith_run && verb->act != kith_plan && verb->act != kith_bench) {
    fprintf(stderr,
            "kith: --ranks: %s is of one process; run and bench take several, and plan tells of them\n",
            verb->name);
    return KITH_EXIT_USAGE;
  }
  return verb->act(&options);
}
