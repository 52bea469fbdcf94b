/* block_steps.h - what the force pass needs where nodes have time steps of their own (block time steps,
 * integrator/block_steps.h): weights of pairs, and impulses instead of rates.
 *
 * Times are ticks of the base step. A node that was last active at t took the step d; at its next activity
 * it takes d', a power of two like d. A pair that is evaluated at n, when one of its ends at least is active,
 * acts on both ends for the same time
 *     W_ij = (n - max(t_i, t_j)) - min(d_i, d_j) / 2 + min(d'_i, d'_j) / 2   (d' = d of an inactive end)  (1)
 * which closes the pair's last interval, by the second half of the step of its finer end, and opens its next
 * by the first half. A step that was cut short needs nothing else: what was opened too much is taken back. At
 * the end of a base step the last term is kept apart, in shares of the next base step, whose length may still
 * shrink. With the impulses k_i = sum_j W f_ij / m_i, w the velocity that the node drifts with, p the
 * predicted one that pairs see, and s g of (1) in package.h, for s from the middle of the step to n,
 *     v = w + k,   m du = sum_j W q_ij - [compatible] m k . (w + s g + k / 2 - p),    (2)
 * first with the closing part, which makes the state at n, then with the opening one. W is symmetric and f
 * antisymmetric, so momentum and energy are conserved to round-off whatever the steps are. Predictions start
 * from the state and the rates of the node at its last activity. Positions are predicted ones, so one falls
 * s (v + p) / 2 from t to n, with s = n - t, but its kinetic energy is that of a fall with w + (s - d / 2) g:
 * the energy gets g times the difference, and with uniform gravity it is conserved, too. */
#ifndef KITH_PHYSICS_BLOCK_STEPS_H
#define KITH_PHYSICS_BLOCK_STEPS_H

#include "lib/nodes/nodes.h"

#define KITH_TICKS 1048576.0 /* of a base step */

struct kith_block_steps {
  double now;  /* n */
  double tick; /* its length in time; 0: there is no step to end yet */
  bool ends;   /* n is the end of the base step */
  bool alike;  /* t, d and d' are those of all nodes, which are active: one weight */
  struct kith_field *last, *step, *next; /* t, d, d': whole numbers of ticks; d = 0: never active (frozen) */
  struct kith_field *velocity, *energy;  /* w and its energy; (2) is added */
  struct kith_field *velocity_last, *energy_last; /* the state at t */
  struct kith_field *rate_last, *rate_slope;      /* du/dt at t, and its change since the activity before */
  struct kith_field *fall;                        /* sum (n - t) g . k between t and n; NULL: g = 0 */
  struct kith_field *impulse, *heat;              /* closing part, of the packages so far */
  struct kith_field *opening, *opening_heat;      /* opening part, per time of a base step */
  /* What of that is by partners that are no gas: of the node's momentum and energy. The closing part is
   * outside_force and outside_power of hydro.h then. NULL: all is gas. */
  struct kith_field *outside, *outside_power;
};

#endif
