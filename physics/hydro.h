/* hydro.h - the state that every hydro package shares: fields over the nodes, an equation of state per node
 * list.
 *
 * State: position, velocity, energy (specific internal), mass, support H.
 * Derived by a package: density, pressure, sound speed. Rates: acceleration, energy_rate.
 * The pressure and the sound speed of internal nodes come from kith_hydro_evaluate_eos; ghosts get theirs by
 * refresh, or remote ones from kith_hydro_evaluate_eos_remote if their density is computed on this rank. */
#ifndef KITH_PHYSICS_HYDRO_H
#define KITH_PHYSICS_HYDRO_H

#include "lib/comm/sum.h"
#include "lib/core/vec.h"
#include "lib/domain/halo.h"
#include "physics/eos.h"

/* An external force on every node: uniform gravity, and the attraction of a point of mass M. With
 * d = x - center:
 *
 *   a   = g - G M d / (d^2 + s^2)^(3/2)            s: softening (Plummer's)
 *   phi = - g . (x - origin) - G M / (d^2 + s^2)^(1/2)
 *
 * The potential is 1/d in 1-D, 2-D and 3-D alike. The force is added after the pair forces are summed
 * (rates.c), independent of packages and schemes. Its work goes into kinetic energy alone. Kinetic + internal
 * + potential energy is conserved as well as the scheme can: to second order in dt for leapfrog, without a
 * trend. */
struct kith_external_force {
  double gravity[NDIM], origin[NDIM];   /* g, and where its potential is 0 */
  double center[NDIM], mass, softening; /* of the point; mass is G M, 0: no point */
};

static inline bool kith_external_force_acts(const struct kith_external_force *external_force) {
  bool acts = external_force->mass > 0;
  for (int a = 0; a < NDIM; ++a) acts = acts || external_force->gravity[a] != 0;
  return acts;
}

/* Returns phi at x[NDIM]. At the center of a point without softening it is -infinity, and the acceleration is
 * not a number. */
double kith_external_force_potential(const struct kith_external_force *external_force, const double *x);
/* Adds a at x[NDIM] to acceleration[NDIM]. */
void kith_external_force_add(const struct kith_external_force *external_force, const double *x,
                             double *acceleration);

/* What the gas got since the start: from nodes that came through faces, from forces and heats of all that is
 * no gas (nodes.h), such as frozen nodes, from mirrors that put nodes back, which may lift them against
 * gravity, and from energies that a scene releases after the start. */
struct kith_through {
  double mass, momentum[NDIM], energy;
};
/* Adds dt times `rate` to momentum and energy of `to`. */
static inline void kith_through_add(struct kith_through *to, double dt, const struct kith_through *rate) {
  to->energy += dt * rate->energy;
  for (int a = 0; a < NDIM; ++a) to->momentum[a] += dt * rate->momentum[a];
}

struct kith_hydro {
  struct kith_nodes *nodes;                      /* borrowed */
  struct kith_material material[KITH_MAX_LISTS]; /* of each node list */
  struct kith_field *mass, *velocity, *energy;   /* state */
  struct kith_field *density, *pressure, *sound_speed;
  struct kith_field *acceleration, *energy_rate; /* state: the next step starts from them */
  /* For gas: the force of all partners that are no gas, and the rate at which they change the energy of the
   * node. NULL unless nodes have flags. */
  struct kith_field *outside_force, *outside_power;
  /* Set by the caller, zero until then. */
  struct kith_halo *halo; /* exchanges values of remote ghosts, borrowed; NULL: one process */
  double center[NDIM];    /* of the angular momentum */
  struct kith_external_force external_force; /* acts on every node */
  /* Set by the integrator, for the limit of displacements (package.c): the velocity, along each axis, of what
   * a node might meet. That of a wall on this axis; 0 with frozen nodes or barriers; else the mean velocity
   * of all gas at the start. */
  double rest_velocity[NDIM];
  double wall[NDIM]; /* velocity of the moving wall along this axis, at most one per axis */
  /* Set by the integrator: from the face of an outflow to the end of the zone behind it, by axis and side;
   * zero where there is none. */
  double zone_ends[NDIM][2][2];
  /* Set by the lifecycle, with several ranks: all internal nodes of all ranks have the same mass. */
  bool equal_masses;
  /* All nodes and ghosts of this process have the same mass; valid while nodes->ghosts equals masses_of. */
  bool equal_here;
  uint64_t masses_of;
  struct kith_through through; /* added up by the integrator */
};

/* Registers the fields. All else is zero afterwards, until it is set. */
kith_status kith_hydro_init(struct kith_hydro *hydro, struct kith_nodes *nodes);

/* Gives nodes flags, and registers outside_force and outside_power. */
kith_status kith_hydro_flag(struct kith_hydro *hydro);

/* Computes pressure and sound speed of all internal nodes from density and energy. Idle ones are skipped by
 * chunks, so some get them. */
void kith_hydro_evaluate_eos(const struct kith_hydro *hydro);
/* The same of internal node i. */
void kith_hydro_evaluate_eos_of(const struct kith_hydro *hydro, kith_index i);
/* Computes pressure and sound speed of all remote ghosts. */
void kith_hydro_evaluate_eos_remote(const struct kith_hydro *hydro);

/* Checks the state before rates are computed, before a value that is not finite can spread to neighbors:
 * DIVERGED names the first internal node whose position, velocity, energy or support is not finite. */
kith_status kith_hydro_finite(const struct kith_hydro *hydro);

/* Returns the round-off of the kinetic energy of node i, with which its internal energy is exchanged: less
 * than that is as good as 0, neither negative nor to be kept from becoming so. */
static inline double kith_hydro_energy_round_off(const struct kith_hydro *hydro, kith_index i) {
  const double *v = hydro->velocity->f64 + (size_t)i * NDIM;
  return 1e-15 * kith_dot(v, v);
}

/* Checks the state after rates are computed, to stop a run that left the physical range: DIVERGED names the
 * first internal node with a value that is not finite, or a state outside of its equation of state. The
 * latter is not asked of nodes at the end of the zone of an outflow, which lack partners and are too far from
 * gas to act on it: their density is too low, and a liquid of that density is torn. */
kith_status kith_hydro_physical(const struct kith_hydro *hydro);

/* Sums over the gas of all ranks. They are exact (sum.h), so bitwise identical for any number of threads and
 * ranks. Collective. All members are double, for checkpoints. The angular momentum uses positions in the box:
 * a node that crosses a periodic face changes it, so in a periodic box it is conserved only while what
 * crosses has no momentum along the face, as outside of a vortex. */
struct kith_totals {
  double mass, kinetic, internal, momentum[NDIM];
  double potential; /* of the external force */
  /* Velocity of the moving wall times the momentum that did not come through faces: up to a constant the work
   * that it has done. */
  double work;
  struct kith_through through;
  double angular[3]; /* sum m (x - center) x v; components that a dimension lacks are 0 */
  /* Sum m max(|v|, c), and sum m |(x - center) x v|: scales of drifts. The forces that cancel are those of
   * the pressure, so c bounds their rounding where the gas hardly moves. */
  double momentum_scale, angular_scale;
  double velocity_over_sound; /* largest |v| / c of a node; infinite if a node without sound moves */
};
/* The energy that is conserved. */
static inline double kith_totals_energy(const struct kith_totals *t) {
  return t->kinetic + t->internal + t->potential - t->work - t->through.energy;
}
struct kith_totals kith_hydro_totals(const struct kith_hydro *hydro);
/* kith_hydro_totals in three parts, for callers that tell other ranks more in the same message: sums of this
 * rank's nodes; list of what ranks agree on (at most KITH_HYDRO_PARTS parts; returns their number); totals
 * from the sums of all ranks. */
enum { KITH_HYDRO_PARTS = 10 + NDIM };
struct kith_hydro_sums {
  struct kith_sum sum[KITH_HYDRO_PARTS];
  double fastest;
};
void kith_hydro_sum(const struct kith_hydro *hydro, struct kith_hydro_sums *mine);
int kith_hydro_share(struct kith_hydro_sums *sums, struct kith_shared *parts);
struct kith_totals kith_hydro_totals_of(const struct kith_hydro *hydro, const struct kith_hydro_sums *all);

#endif
