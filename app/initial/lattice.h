/* lattice.h - sites of a lattice that fits a box with a whole number of cells along every axis.
 *
 * Cells are rectangular. With s^NDIM the volume of a node their ideal sides are s in 1-D, and
 *
 *   cubic  s            bcc  2^(1/NDIM) s           fcc  4^(1/3) s
 *   hcp    2-D: a, 3^(1/2) a, a^2 = 2 s^2/3^(1/2), rows along x
 *          3-D: a, 3^(1/2) a, (8/3)^(1/2) a, a = 2^(1/6) s, rows along x, layers along z
 *   glass  10 s along each axis (glass.h); s in 1-D
 *
 * An axis has extent / side cells, rounded, at least 1; cells are stretched to fit. So every lattice
 * continues exactly across periodic faces, and no site is on a face. Layers lie symmetric about the middle of
 * the box: the images of all but cubic in a reflecting face are off sideways. */
#ifndef KITH_APP_INITIAL_LATTICE_H
#define KITH_APP_INITIAL_LATTICE_H

#include "app/scene/scene.h"
#include "physics/kernel.h"

enum { KITH_MAX_SITES = 1000000000 }; /* sites of one fit, and nodes of a scene */

struct kith_lattice_fit {
  enum kith_lattice kind;
  struct kith_box box;
  int64_t cells[NDIM];
  const double (*site)[NDIM]; /* in a cell of side 1 */
  int64_t sites;              /* number of sites in all cells */
  double site_volume;         /* volume of the box / sites */
};

/* Fits cells to a finite box that is not empty, so that a site has about the volume spacing^NDIM. BAD_INPUT
 * beyond KITH_MAX_SITES, or for a lattice that does not exist. */
kith_status kith_lattice_fit(struct kith_lattice_fit *out, enum kith_lattice kind, const struct kith_box *box,
                             double spacing);
/* Brings site_volume closer to `volume` by the number of cells along an axis with more than twice the cells
 * of any other, where the others have at least 2. */
kith_status kith_lattice_balance(struct kith_lattice_fit *fit, double volume);
/* Finds the place of site 0 .. sites - 1. */
void kith_lattice_site(const struct kith_lattice_fit *fit, int64_t site, double *x);
/* Moves x by up to `largest` along each axis, mirrored at the faces. Depends on seed and id only. */
void kith_lattice_jitter(const struct kith_lattice_fit *fit, double largest, uint64_t seed, int64_t id,
                         double *x);

/* How stiff the ideal lattice is under shear: the least second derivative of ln n by a strain that keeps the
 * volume, n the kernel sum at a site. Where it is negative gas at rest lowers its energy by giving way, at a
 * growth rate of some tenths of sound speed / spacing, whatever the viscosity is. (The strains along and
 * between axes: the lattice as a whole, not waves of a few spacings.) INFINITY for what has no shear or no
 * lattice: 1-D, a glass. */
double kith_lattice_stiffness(enum kith_lattice kind, enum kith_kernel kernel, double neighbors);

#endif
