/* stages.h - a step made by a solver of SUNDIALS: it works on vectors (lib/comm/vector.h) without knowing
 * nodes, evaluates the rates of any state, and may repeat the step with a shorter dt. For arkode.c and
 * implicit.c. Inside a step nodes are neither reordered nor migrated (integrator->holding), so an entry of a
 * vector stays with its node.
 *
 *   kith_stages_begin   keeps the state, and what the lists were made from, which serve the whole step.
 *   kith_stages_rates   the rates of the state in the fields. First guesses (supports, their growth) are
 *                       those of the start, drifted to the time of the state: so rates depend on state and
 *                       time, not on earlier evaluations.
 *   kith_stages_again   another attempt begins: lists as they were at the start. With it a step that is
 *                       repeated is bitwise identical to one taken at once with the shorter dt.
 *   kith_stages_restore the state and the rates as they were at the start, and so the lists. */
#ifndef KITH_INTEGRATOR_SCHEMES_STAGES_H
#define KITH_INTEGRATOR_SCHEMES_STAGES_H

#include "integrator/step.h"
#include "lib/comm/vector.h"
#include "lib/core/param.h"

enum { KITH_MOST_HALVINGS = 10 };

/* Tolerances of errors (arkode) or residuals (implicit): see kith_stages_weights. */
struct kith_tolerances {
  double rtol, atol;
};
/* Rows of a parameter table for the settings `type`, whose member `tolerances` they fill. */
#define KITH_TOLERANCE_PARAMS(type)                                                                \
  {"rtol",                                                                                         \
   KITH_PARAM_NUMBER,                                                                              \
   "1e-4",                                                                                         \
   "[1e-12, 1]",                                                                                   \
   "of errors, and of a thousand residuals of implicit: relative to support, sound speed, energy", \
   KITH_INTO(type, tolerances.rtol)},                                                              \
  {                                                                                                \
    "atol", KITH_PARAM_NUMBER, "1e-5", "[0, 1]",                                                   \
        "the same: relative to the energy per mass of the whole run, and its speed",               \
        KITH_INTO(type, tolerances.atol)                                                           \
  }

struct kith_stages {
  struct kith_field *position, *support, *velocity_divergence, *acceleration, *energy_rate; /* at the start */
  struct kith_built built;                                                                  /* at the start */
  uint64_t lifecycles;                                                                      /* then */
};

kith_status kith_stages_init(struct kith_stages *stages, struct kith_integrator *integrator);
void kith_stages_begin(struct kith_stages *stages, struct kith_integrator *integrator);
/* `time` from the start of the step. */
kith_status kith_stages_rates(struct kith_stages *stages, struct kith_integrator *integrator, double time);
kith_status kith_stages_again(struct kith_stages *stages, struct kith_integrator *integrator);
kith_status kith_stages_restore(struct kith_stages *stages, struct kith_integrator *integrator);

/* The state as a vector: position, velocity and energy of the internal nodes. */
enum { KITH_VECTOR_POSITION, KITH_VECTOR_VELOCITY, KITH_VECTOR_ENERGY, KITH_VECTOR_PARTS };
/* A set whose view is the fields. Collective. */
kith_status kith_stages_vectors(struct kith_vectors **out, const struct kith_hydro *hydro);
/* Is this the set for the nodes that there are, on all ranks? NULL is none. Collective. */
bool kith_stages_fit(const struct kith_vectors *vectors, const struct kith_nodes *nodes);
/* Of the numbers of one vector. */
size_t kith_stages_vector_bytes(const struct kith_hydro *hydro);

/* The rates at hand, as a vector: velocity, acceleration, energy rate. */
void kith_stages_copy_rates(const struct kith_integrator *integrator, N_Vector rates);
/* Weights of errors, 1 / tolerance with tolerances of
 *   position  (rtol + atol) H_i
 *   velocity  rtol c_i + atol V            V^2 = 2 e, e = energy per mass of the whole run where its center
 *             of mass rests
 *   energy    rtol |u_i| + atol e
 * so they do not depend on units and frames; V and e keep the tolerances of cold gas from vanishing. `state`:
 * whose u. */
void kith_stages_weights(const struct kith_integrator *integrator, const struct kith_tolerances *tolerances,
                         N_Vector state, N_Vector weights);

#endif
