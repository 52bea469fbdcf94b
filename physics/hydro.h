/* hydro.h - the state that every hydro package shares: fields over the nodes, an equation of state per node list.
 *
 * State: position, velocity, energy (specific internal), mass, support H.
 * Derived by a package: density, pressure, sound speed. Rates: acceleration, energy_rate.
 * The pressure and the sound speed of internal nodes come from kith_hydro_close; ghosts get theirs by refresh. */
#ifndef KITH_PHYSICS_HYDRO_H
#define KITH_PHYSICS_HYDRO_H

#include "lib/nodes/nodes.h"
#include "physics/body.h"
#include "physics/eos.h"

struct kith_material {
  const struct kith_eos_ops *eos;
  struct kith_eos_parameters parameters;
};

struct kith_hydro {
  struct kith_nodes *nodes;                      /* borrowed */
  struct kith_material material[KITH_MAX_LISTS]; /* of each node list; its name is the list's */
  struct kith_field *mass, *velocity, *energy;   /* state */
  struct kith_field *density, *pressure, *sound_speed;
  struct kith_field *acceleration, *energy_rate; /* state: the next step starts from them */
  /* The caller's to fill, zero until then. */
  double center[NDIM];   /* what the angular momentum is about */
  struct kith_body body; /* force from outside */
  double wall[NDIM];     /* velocity of the one wall that moves along this axis */
};

/* Registers the fields, and clears what is the caller's to fill but the materials. */
kith_status kith_hydro_init(struct kith_hydro *hydro, struct kith_nodes *nodes);

/* Pressure and sound speed of all internal nodes from density and energy. */
void kith_hydro_close(const struct kith_hydro *hydro);
/* The same of all remote ghosts. */
void kith_hydro_close_remote(const struct kith_hydro *hydro);

/* Before rates are made, while what is not finite has not spread to the neighbors: DIVERGED names the first internal node whose
 * position, velocity, energy or support is not finite. */
kith_status kith_hydro_finite(const struct kith_hydro *hydro);

/* Stops a run that left the physical range: DIVERGED names the first internal node with a value that is not finite, or a negative
 * energy where the equation of state forbids it. */
kith_status kith_hydro_physical(const struct kith_hydro *hydro);

/* Sums over internal nodes of all ranks, exact (sum.h): the same for any number of threads and ranks. Collective. Nothing but double, for checkpoints.
 * The angular momentum takes nodes where they are: who crosses a periodic face takes his own to the other side, so that in a periodic
 * box the sum is kept only while what crosses has no momentum along the face, as outside of a vortex. */
struct kith_totals {
  double mass, kinetic, internal, momentum[NDIM];
  double potential; /* of the force from outside */
  double
      work; /* velocity of the wall times momentum: but for a constant the work that it has done, if nothing else gives momentum
                  along its axis. Kinetic + internal + potential - work is kept */
  double angular[3];     /* sum m (x - center) x v; components that a dimension lacks are 0 */
  double momentum_scale; /* sum m |v|, and sum m |(x - center) x v|: what drifts are measured by */
  double angular_scale;
  double velocity_over_sound; /* largest |v| / c of a node; infinite if a node without sound moves */
};
struct kith_totals kith_hydro_totals(const struct kith_hydro *hydro);

#endif
