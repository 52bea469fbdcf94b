/* block_steps.h - what the force pass needs where nodes have time steps of their own (block time steps,
 * integrator/block_steps.h): weights of pairs, and impulses instead of rates.
 *
 * Times are ticks of the base step. A node that was last active at t took the step d; at its next activity
 * it takes d', a power of two like d. A pair that is evaluated at n, when one of its ends at least is active,
 * acts on both ends for the same time
 *     W_ij = (n - max(t_i, t_j)) - min(d_i, d_j) / 2 + min(d'_i, d'_j) / 2   (d' = d of an inactive end)  (1)
 * which closes the last interval of the pair, by the second half of the shorter of both steps, and opens its
 * next interval, by the first half of the shorter next step. So a step that is cut short needs no correction:
 * what was opened too much is taken back. At the end of a base step the last term is kept apart, as a
 * fraction of the next base step, whose length may still shrink. With the impulses k_i = sum_j W f_ij / m_i,
 * the velocity w that the node drifts with, the predicted velocity p that pairs see, and s g of (1) in
 * package.h, with s from the middle of the step to n,
 *     v = w + k,   m du = sum_j W q_ij - [compatible] m k . (w + s g + k / 2 - p),    (2)
 * first with the closing part, which gives the state at n, then with the opening part. W is symmetric and f
 * antisymmetric, so momentum and energy are conserved to round-off whatever the steps are. Predictions start
 * from the state and the rates of the node at its last activity. A predicted position falls by s (v + p) / 2
 * from t to n, with s = n - t, but the kinetic energy of the node is that of a fall with w + (s - d / 2) g:
 * its internal energy gets g times the difference, so that the total is conserved with uniform gravity,
 * too. */
#ifndef KITH_PHYSICS_BLOCK_STEPS_H
#define KITH_PHYSICS_BLOCK_STEPS_H

#include "lib/nodes/nodes.h"

#define KITH_TICKS 1048576.0 /* ticks of a base step */

struct kith_block_steps {
  double now;  /* n */
  double tick; /* duration of a tick; 0: no step has begun yet */
  bool ends;   /* n is the end of the base step */
  bool alike;  /* all nodes are active with the same t, d and d': one weight for all pairs */
  struct kith_field *last, *step, *next; /* t, d, d': whole numbers of ticks; d = 0: never active (frozen) */
  struct kith_field *velocity, *energy;  /* w and the internal energy with it, to which (2) is added */
  struct kith_field *velocity_last, *energy_last; /* the state at t */
  struct kith_field *rate_last, *rate_slope;      /* du/dt at t, and its slope since the activity before */
  struct kith_field *fall;                        /* sum (n - t) g . k between t and n; NULL: g = 0 */
  struct kith_field *impulse, *heat;              /* closing part, summed over the packages so far */
  struct kith_field *opening, *opening_heat;      /* opening part, per duration of a base step */
  /* The part of `opening` that is by partners that are no gas, as momentum and energy of the node; the
   * closing part is then in outside_force and outside_power of hydro.h. NULL: all nodes are gas. */
  struct kith_field *outside, *outside_power;
};

#endif
