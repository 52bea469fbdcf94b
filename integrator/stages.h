/* stages.h - a step whose solver is not ours: it works on vectors that know nothing of nodes, asks for rates where it likes and may
 * give up and try again. For arkode.c and implicit.c.
 *
 *   kith_stages_begin   nodes are put back and reordered now, if the lists will not last the step: while vectors are held
 *                       (integrator->holding) neither happens, so a number of a vector stays with its node.
 *   kith_stages_rates   the rates of the state in the fields. All that is guessed (supports, their growth) is that of the start,
 *                       drifted to the time asked for: so rates depend on state and time, not on what was evaluated before.
 *   kith_stages_again   another attempt begins: lists as they were at the start. With it a step that is tried again is, to the
 *                       last bit, the step that would have been taken at once with the shorter dt.
 *   kith_stages_restore the state and the rates as they were at the start, and so the lists.
 *   kith_stages_end     back to normal. */
#ifndef KITH_INTEGRATOR_STAGES_H
#define KITH_INTEGRATOR_STAGES_H

#include "integrator/integrator.h"
#include "integrator/vector.h"

enum { KITH_MOST_HALVINGS = 10 };

struct kith_stages {
  struct kith_field *position, *support, *expansion, *acceleration, *energy_rate; /* at the start */
  struct kith_field *built[NDIM], *built_reach, *built_support;                   /* NULL unless lists last */
  const char *due;     /* integrator->due at the start */
  uint64_t lifecycles; /* then */
};

kith_status kith_stages_init(struct kith_stages *stages, struct kith_integrator *integrator);
kith_status kith_stages_begin(struct kith_stages *stages, struct kith_integrator *integrator);
/* `time` from the start of the step. */
kith_status kith_stages_rates(struct kith_stages *stages, struct kith_integrator *integrator, double time);
kith_status kith_stages_again(struct kith_stages *stages, struct kith_integrator *integrator);
kith_status kith_stages_restore(struct kith_stages *stages, struct kith_integrator *integrator);
void kith_stages_end(struct kith_integrator *integrator);

/* The rates at hand, as a vector: velocity, acceleration, energy rate. */
void kith_stages_copy_rates(const struct kith_integrator *integrator, N_Vector rates);
/* Weights of errors, 1 / tolerance with tolerances of
 *   position  (rtol + atol) H_i
 *   velocity  rtol c_i + atol V            V^2 = 2 e, e = energy per mass of the whole run where its center of mass rests
 *   energy    rtol |u_i| + atol e
 * so they do not depend on units and frames; V and e keep cold gas from asking for what nobody sees. `state`: whose u. */
void kith_stages_weights(const struct kith_integrator *integrator, N_Vector state, N_Vector weights);

#endif
