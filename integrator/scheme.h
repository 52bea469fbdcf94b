/* scheme.h - how the state is advanced by a step: one family, a file each in schemes/.
 *
 * A step is  predict -> is a rebuild due? lifecycle -> advance  (step.h).
 * A scheme of one evaluation predicts the state to the time of its evaluation, and the neighbor lists are
 * made there. A scheme with `stages` evaluates at several times of a step: its lists are made at the start,
 * with search radii that cover the motion within the step, and inner stages only refresh the values of
 * ghosts. */
#ifndef KITH_INTEGRATOR_SCHEME_H
#define KITH_INTEGRATOR_SCHEME_H

#include "lib/core/base.h"
#include "lib/core/param.h"

struct kith_integrator;

struct kith_scheme_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters (integrator->settings), NULL: none */
  size_t settings_size;
  int evaluations;          /* of the rates, per step; a first guess where a solver decides */
  const char *incompatible; /* why a compatible energy would not be kept; NULL: it is */
  bool implicit;            /* Courant numbers above 1 are allowed */
  bool stages;              /* evaluates at several times of a step, by the lists of its start */
  bool retries; /* repeats a step with a shorter dt: lists are made for the longest that may come */
  /* Fields, private state in integrator->self, checks of what depends on several settings (BAD_INPUT, the
   * message begins with the key of the setting: "table: ..."). `destroy`: what the private state owns; it is
   * freed behind that. NULL: nothing of this. */
  kith_status (*create)(struct kith_integrator *integrator);
  void (*destroy)(struct kith_integrator *integrator);
  /* To where the lists are needed, by a step of dt. NULL: they are needed at the start. Gas comes and goes
   * here (flow.h), where a scheme can do with that. */
  kith_status (*predict)(struct kith_integrator *integrator, double dt);
  /* The rest: all state is at time + *dt. It may take a shorter step: then it sets *dt to what it took, and
   * integrator->limiter to why. The rates of the last evaluation are there on entry of a step (and after):
   * those of the present state, unless the scheme evaluates in the middle. */
  kith_status (*advance)(struct kith_integrator *integrator, double *dt);
  /* Do nodes have steps of their own, with these settings? NULL: never. If they do: what follows the first
   * rates, and how long the next step, which is a base step, shall be. */
  bool (*blocks)(const void *settings);
  kith_status (*start)(struct kith_integrator *integrator);
  double (*planned)(const struct kith_integrator *integrator);
  /* Where it keeps what its last error estimate allows for the next step, 0: no opinion. A restart stores it.
   * NULL: it estimates no errors. */
  double *(*accurate_dt)(struct kith_integrator *integrator);
  size_t (*bytes)(const struct kith_integrator *integrator); /* of the private state; NULL: none */
};

/* Do nodes have steps of their own? */
static inline bool kith_scheme_has_blocks(const struct kith_scheme_ops *scheme, const void *settings) {
  return scheme->blocks != NULL && scheme->blocks(settings);
}

#define KITH_SCHEME_LIST(X) X(leapfrog) X(rk2) X(cheap_rk2) X(verlet) X(rk4) X(arkode) X(implicit)
#define X(name) extern const struct kith_scheme_ops kith_scheme_##name;
KITH_SCHEME_LIST(X)
#undef X
KITH_FAMILY_FUNCTIONS(kith_scheme);

#endif
