/* stages.h - a step made by a solver of SUNDIALS: it works on vectors (lib/comm/vector.h) without knowing
 * nodes, evaluates the rates of any state, and may repeat the step with a shorter dt. Inside a step nodes are
 * neither reordered nor migrated (integrator->holding), so an entry of a vector stays with its node.
 *
 *   kith_stages_begin   stores the state, and what the lists were made from; they serve the whole step.
 *   kith_stages_try     tries steps, each half as long as the last, until one does not diverge. Before each
 *                       the state, the rates and the lists are as they were at the start: so a step that is
 *                       repeated is bitwise identical to one taken at once with the shorter dt.
 *   kith_stages_rates   computes the rates of the state in the fields. First guesses (supports, their growth)
 *                       are those of the start, drifted to the time of the state: so rates depend on state
 *                       and time, not on earlier evaluations.
 *   kith_stages_again   if the solver repeats a step by itself: makes the lists as they were at the start. */
#ifndef KITH_INTEGRATOR_SCHEMES_STAGES_H
#define KITH_INTEGRATOR_SCHEMES_STAGES_H

#include "integrator/step.h"
#include "lib/comm/vector.h"
#include "lib/core/param.h"

/* Tolerances of errors (arkode) or residuals (implicit): see kith_stages_weights. */
struct kith_tolerances {
  double rtol, atol;
};
/* Rows of the parameter table for settings of `type`, which fill its member `tolerances`. */
#define KITH_TOLERANCE(type, key, value, range, doc) \
  { #key, KITH_PARAM_NUMBER, value, range, doc, KITH_INTO(type, tolerances.key) }
#define KITH_TOLERANCE_PARAMS(type)                                                                     \
  KITH_TOLERANCE(                                                                                       \
      type, rtol, "1e-4", "[1e-12, 1]",                                                                 \
      "tolerance relative to support, sound speed, energy; of errors (implicit: of 1000 residuals)"),   \
      KITH_TOLERANCE(                                                                                   \
          type, atol, "1e-5", "[0, 1]",                                                                 \
          "likewise, relative to the energy per mass of the whole run and the speed that it is worth; " \
          "the two are added, so lower both")

/* The state as a vector: position, velocity and energy of the internal nodes. */
enum { KITH_VECTOR_POSITION, KITH_VECTOR_VELOCITY, KITH_VECTOR_ENERGY, KITH_VECTOR_PARTS };

/* A solver and how the scheme uses it. */
struct kith_solver {
  const char *name;
  enum kith_limit cut; /* what limits a step whose attempt diverged */
  /* Makes the solver for stages->vectors; false if it fails. `forget` frees what was made, complete or
   * not. */
  bool (*set_up)(struct kith_integrator *integrator);
  void (*forget)(struct kith_integrator *integrator);
  /* Tries one step, from the state in the fields and its rates. *dt: the step wanted, then taken. */
  kith_status (*solve)(struct kith_integrator *integrator, double *dt);
};

enum { KITH_START_FIELDS = 8 };
/* The first member of a scheme's private state (integrator->self). */
struct kith_stages {
  const struct kith_solver *solver;
  size_t size;                                                              /* of the private state */
  int n_vectors;                                                            /* that the solver will make */
  struct kith_field *present[KITH_START_FIELDS], *start[KITH_START_FIELDS]; /* now; at the step's start */
  struct kith_built built;                                                  /* at the start */
  struct kith_through through;  /* what the gas gets from outside per time, at the start */
  uint64_t lifecycles;          /* ledger.lifecycles at the start */
  struct kith_vectors *vectors; /* for the present nodes; NULL: not made yet */
  void *memory;                 /* of the solver */
  kith_status status;           /* of the last rates */
};

/* Creates a private state of `size` bytes. n_vectors: that the solver will make. */
kith_status kith_stages_create(struct kith_integrator *integrator, size_t size, int n_vectors,
                               const struct kith_solver *solver);
/* Frees solver and vectors: `destroy` of the scheme. */
void kith_stages_forget(struct kith_integrator *integrator);
/* Returns the memory of the private state and its vectors, also before these are made: `bytes` of the
 * scheme. */
size_t kith_stages_bytes(const struct kith_integrator *integrator);
/* See the top of this file. shorter: may steps that diverge be repeated, at most ten times? *dt: the step
 * wanted, then taken. Collective. */
kith_status kith_stages_begin(struct kith_integrator *integrator);
kith_status kith_stages_try(struct kith_integrator *integrator, bool shorter, double *dt);
/* `time` is counted from the start of the step. */
kith_status kith_stages_rates(struct kith_integrator *integrator, double time);
kith_status kith_stages_again(struct kith_integrator *integrator);

/* Copies the rates at hand into a vector: velocity, acceleration, energy rate. */
void kith_stages_copy_rates(const struct kith_integrator *integrator, N_Vector rates);
/* Writes weights of errors, 1 / tolerance with tolerances of
 *   position  (rtol + atol) H_i
 *   velocity  rtol c_i + atol V            V^2 = 2 e, e = energy per mass of the whole run where its center
 *             of mass rests
 *   energy    rtol |u_i| + atol e, at least 1e-12 c_i^2: an isothermal gas or a liquid may be without energy
 *             and motion, but its heating is rounded as that of any other
 * so they do not depend on units and frames; V and e keep the tolerances of cold gas from vanishing. u is
 * taken from `state`. */
void kith_stages_weights(const struct kith_integrator *integrator, const struct kith_tolerances *tolerances,
                         N_Vector state, N_Vector weights);

#endif
