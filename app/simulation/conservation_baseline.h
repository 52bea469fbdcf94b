/* conservation_baseline.h - what a run started from, and how far it has moved away: the drifts of a report.
 *
 *   energy    |E - E0| / max(|E0|, |W - W0|),   E = kinetic + internal + potential - W, W the work of pistons
 *   momentum  max_a |p_a - p0_a| / max(S, S0),  S = sum m |v|; axes without walls and external forces only
 *   angular   |L - L0| / max(S, S0),            L about the center (hydro.h), S = sum m |r x v|; NaN in 1-D,
 *             with walls or uniform gravity, and with frozen nodes, which give angular momentum to the gas
 *   rebound   largest rise of the kinetic energy above its minimum until then: a flow that nothing drives
 *             must not speed up */
#ifndef KITH_APP_SIMULATION_CONSERVATION_BASELINE_H
#define KITH_APP_SIMULATION_CONSERVATION_BASELINE_H

#include "app/simulation/simulation.h"
#include "validation/measure.h"

/* Kept over restarts. Only double: checkpoints store it as numbers. */
struct kith_conservation_baseline {
  struct kith_totals totals;
  double energy_drift, momentum_drift, angular_drift; /* largest so far */
  double kinetic_least, kinetic_rebound;
  double velocity_over_sound;      /* largest |v| / c so far */
  double measure[KITH_N_MEASURES]; /* at the start: what measures are compared with */
};

/* Of a run that begins with these totals. */
struct kith_conservation_baseline kith_conservation_baseline_of(const struct kith_totals *first);
void kith_conservation_baseline_update(struct kith_conservation_baseline *baseline,
                                       const struct kith_simulation *simulation,
                                       const struct kith_totals *now);

#endif
