/* simulation.h - all objects of a run, created from a scene: nodes, boundaries, search, connectivity,
 * package, integrator; and how well they conserve. */
#ifndef KITH_APP_SIMULATION_SIMULATION_H
#define KITH_APP_SIMULATION_SIMULATION_H

#include "app/scene/scene.h"
#include "integrator/step.h"
#include "validation/measure.h"

struct kith_simulation {
  const struct kith_scene *scene; /* borrowed */
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
  struct kith_package package, added[KITH_ADDED_PACKAGES]; /* linked from `package` on */
  char packages[80];                                       /* their names */
  double zone[NDIM][2][NDIM]; /* of faces that gas passes, by axis and side: kith_boundary.zone */
  struct kith_boundaries boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  struct kith_rebuilds rebuilds;
  struct kith_excluders excluders;
  struct kith_integrator integrator;
  struct kith_decomposition *decomposition; /* NULL: all nodes are in this process */
  struct kith_halo *halo;                   /* NULL: all nodes are in this process */
  struct kith_profile *profile;             /* NULL: not profiled */
};

/* BAD_INPUT if settings of a scene cannot work together; nothing is made. */
kith_status kith_simulation_check(const struct kith_scene *scene);
/* Creates everything, with the initial state; kith_simulation_start, or restore and resume, must follow.
 * `ranks` (NULL: one process) and `profile` (NULL: none) are borrowed. Collective; each rank makes its share
 * of the nodes, which then go to the ranks that own their cells. BAD_INPUT with file and line for what only
 * shows when nodes are created. */
kith_status kith_simulation_create(struct kith_simulation **out, const struct kith_scene *scene,
                                   struct kith_ranks *ranks, struct kith_profile *profile, bool check);
/* Evaluates the first rates, and sets the energies that need them (initial_conditions.h: regions in
 * equilibrium). Fails with DIVERGED as a step does. */
kith_status kith_simulation_start(struct kith_simulation *simulation);
/* Takes a step that ends at `until` at the latest, or when energies are released (deposits.h): then it adds
 * these, and evaluates the rates anew. */
kith_status kith_simulation_step(struct kith_simulation *simulation, double until);
/* Prints a line on stderr for settings that are allowed but likely to go wrong. */
void kith_simulation_warn(const struct kith_simulation *simulation);
void kith_simulation_destroy(struct kith_simulation **simulation);

/* Sets the number of threads of this process, unless OMP_NUM_THREADS has one: the ranks of a computer share
 * its cores, and each thread has at least 2000 of this rank's nodes. With fewer, threads that wait for each
 * other cost more than they save. */
void kith_share_cores(const struct kith_ranks *ranks, kith_index n_nodes);

/* Memory of a structure, for plan and report. */
struct kith_bytes {
  const char *name;
  bool of_ghosts; /* has places for ghosts, as many as for other nodes */
  size_t bytes;
};
enum { KITH_SIMULATION_STRUCTURES = 6 };
void kith_simulation_bytes(const struct kith_simulation *simulation,
                           struct kith_bytes out[KITH_SIMULATION_STRUCTURES]);

/* What a run started from, and how far it has moved away: the drifts of a report.
 *
 *   energy    |E - E0| / max(|E0|, |W - W0|, |T|, kinetic energy),
 *             E = kinetic + internal + potential - W - T, W the work of pistons, T the energy that came
 *             through (hydro.h); E0 may be next to 0 in cold gas, where the pressure takes nothing from the
 *             energy, or where potential energies cancel it
 *   momentum  max_a |p_a - p0_a| / max(S, S0),  S = sum m max(|v|, c), p without what came through;
 *             axes without walls and external forces only; 0 if there is none
 *   angular   |L - L0| / max(S, S0),            L about the center (hydro.h), S = sum m |r x v|; NaN in 1-D,
 *             with walls or uniform gravity, and with frozen nodes, which give angular momentum to the gas
 *   rebound   largest rise of the kinetic energy above its minimum until then
 *
 * Kept over restarts. Only double: checkpoints store it as numbers. */
struct kith_conservation_baseline {
  struct kith_totals totals;
  double energy_drift, momentum_drift, angular_drift; /* largest so far */
  double kinetic_least, kinetic_rebound;
  double velocity_over_sound;      /* largest |v| / c so far */
  double measure[KITH_N_MEASURES]; /* at the start: what measures are compared with */
};

/* Returns the baseline of a run that begins with these totals. */
struct kith_conservation_baseline kith_conservation_baseline_of(const struct kith_totals *first);
void kith_conservation_baseline_update(struct kith_conservation_baseline *baseline,
                                       const struct kith_simulation *simulation,
                                       const struct kith_totals *now);
/* Returns the number of axes along which neither walls nor an external force change the momentum. */
int kith_simulation_momentum_axes(const struct kith_simulation *simulation);

#endif
