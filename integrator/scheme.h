/* scheme.h - time integration schemes: one family, a file each in schemes/.
 *
 * A step is  predict -> is a rebuild due? lifecycle -> advance  (step.h).
 * A scheme with one evaluation per step predicts the state at its time, and makes the neighbor lists there. A
 * scheme with `stages` evaluates at several times of a step: its lists are made at the start, with search
 * radii that cover the motion within the step, and later stages only refresh ghost values. */
#ifndef KITH_INTEGRATOR_SCHEME_H
#define KITH_INTEGRATOR_SCHEME_H

#include "lib/core/base.h"
#include "lib/core/param.h"

struct kith_integrator;

struct kith_scheme_ops {
  const char *name, *doc;
  const struct kith_param *params; /* its own parameters (integrator->settings), NULL: none */
  size_t settings_size;
  int evaluations;   /* of the rates, per step; a guess where a solver decides */
  bool thermal_only; /* it needs du/dt as a function of the state: no compatible energy (package.h) */
  bool implicit;     /* Courant numbers above 1 are allowed */
  bool stages;       /* evaluates several times per step, with the lists of its start */
  bool retries;      /* may repeat a step with a shorter dt: lists are made for the longest dt */
  /* create: registers fields, allocates private state in integrator->self, checks what depends on several
   * settings (BAD_INPUT, the message begins with the key of the setting: "table: ..."). destroy: frees what
   * the private state owns; the caller then frees the state itself. NULL: nothing to do. */
  kith_status (*create)(struct kith_integrator *integrator);
  void (*destroy)(struct kith_integrator *integrator);
  /* Predicts the state at which lists are needed, for a step of dt. NULL: they are needed at the start. Gas
   * enters and leaves here (flow.h), in schemes that support that. */
  kith_status (*predict)(struct kith_integrator *integrator, double dt);
  /* Does the rest of the step: all state is at time + *dt afterwards. It may take a shorter step: then it
   * sets *dt to what it took, and integrator->limiter to why. On entry of a step (and after it) the rates of
   * the last evaluation are at hand: those of the present state, unless the scheme evaluates in the
   * middle. */
  kith_status (*advance)(struct kith_integrator *integrator, double *dt);
  /* blocks: do nodes have steps of their own with these settings? NULL: never. If so, start follows the first
   * rates, and integrator->planned is the length of the next base step. */
  bool (*blocks)(const void *settings);
  kith_status (*start)(struct kith_integrator *integrator);
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
