/* Scheme leapfrog: kick, drift, kick (velocity Verlet). The force sees velocities and energies that are
 * predicted to the end of the step; one evaluation. With a global step, or with block time steps
 * (integrator/block_steps.h). */
#include <math.h>
#include "integrator/block_steps.h"
#include "integrator/flow.h"
#include "integrator/step.h"

struct leapfrog_settings {
  int block, levels, ratio;
  uint64_t seed;
};
static const struct kith_param params[] = {
    {"steps", KITH_PARAM_CHOICE, "global", "global|block",
     "one step for all nodes, or block time steps: each node its own, the base step over a power of two",
     KITH_INTO(struct leapfrog_settings, block)},
    {"levels", KITH_PARAM_INTEGER, "10", "[0, 10]",
     "the base step is at most 2^levels times the shortest step", KITH_INTO(struct leapfrog_settings, levels),
     .needs = "steps=block"},
    {"ratio", KITH_PARAM_CHOICE, "4", "2|4|none",
     "largest ratio of the steps of neighbors; none: no limit, to see what it is for",
     KITH_INTO(struct leapfrog_settings, ratio), .needs = "steps=block"},
    {"random_steps", KITH_PARAM_INTEGER, "0", "[0, inf)",
     "not 0: seed of random steps and wake-ups, for tests of conservation",
     KITH_INTO(struct leapfrog_settings, seed), .needs = "steps=block"},
    {0}};

/* Without settings: global steps. */
static bool blocks(const void *settings) {
  return settings != NULL && ((const struct leapfrog_settings *)settings)->block;
}

static kith_status create(struct kith_integrator *it) {
  const struct leapfrog_settings *settings = it->settings;
  if (!blocks(settings)) return KITH_OK;
  return kith_block_steps_create(
      it, (struct kith_block_settings){.levels = settings->levels,
                                       .ratio = (const double[]){2, 4, INFINITY}[settings->ratio],
                                       .seed = settings->seed});
}

static kith_status predict(struct kith_integrator *it, double dt) {
  kith_status status = KITH_OK;
  kith_profile_begin(it->profile, "kick");
  if (blocks(it->settings)) {
    kith_block_steps_begin(it, dt);
  } else {
    kith_kick(it, 0.5 * dt);
    status = kith_flow_exchange(it);
    kith_predict(it, dt, 0.5 * dt, 0.75 * dt);
  }
  kith_profile_end(it->profile);
  return status;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  if (blocks(it->settings)) return kith_block_steps_advance(it);
  KITH_TRY(kith_integrator_evaluate(it));
  kith_profile_begin(it->profile, "kick");
  kith_correct(it, 0.5 * *dt);
  kith_profile_end(it->profile);
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_leapfrog = {
    .name = "leapfrog",
    .doc = "kick, drift, kick; one evaluation a step, or block time steps",
    .evaluations = 1,
    .blocks = blocks,
    .start = kith_block_steps_start,
    .create = create,
    .destroy = kith_block_steps_destroy,
    .predict = predict,
    .advance = advance,
    KITH_SETTINGS(params, leapfrog_settings)};
