/* lattice.h - sites of a lattice that fits a box with a whole number of cells along every axis.
 *
 * Cells are rectangular. With s^NDIM the volume of a node their ideal sides are s in 1-D, and
 *
 *   cubic  s            bcc  2^(1/NDIM) s           fcc  4^(1/3) s
 *   hcp    2-D: a, 3^(1/2) a, a^2 = 2 s^2/3^(1/2), rows along x
 *          3-D: a, 3^(1/2) a, (8/3)^(1/2) a, a = 2^(1/6) s, rows along x, layers along z
 *   glass  10 s along each axis (glass.h); s in 1-D
 *
 * An axis has extent / side cells, rounded, at least 1, which are stretched to fit. So every lattice
 * continues exactly across periodic faces, and no site is on a face. Layers are symmetric about the middle
 * of the box. Behind a reflecting face only the cubic lattice goes on: the images of others are shifted
 * along the face. */
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
 * if there would be more than KITH_MAX_SITES, or if the lattice does not exist in this dimension. */
kith_status kith_lattice_fit(struct kith_lattice_fit *out, enum kith_lattice kind, const struct kith_box *box,
                             double spacing);
/* Brings site_volume closer to `volume` by changing the number of cells along one axis: that with more than
 * twice the cells of any other. Does nothing if there is no such axis, or if another one has only 1 cell. */
kith_status kith_lattice_balance(struct kith_lattice_fit *fit, double volume);
/* Finds the place of site 0 .. sites - 1. */
void kith_lattice_site(const struct kith_lattice_fit *fit, int64_t site, double *x);
/* Moves x by up to `largest` along each axis, mirrored at the faces. Depends on seed and id only. */
void kith_lattice_jitter(const struct kith_lattice_fit *fit, double largest, uint64_t seed, int64_t id,
                         double *x);

/* How stiff the ideal lattice is under shear: the least second derivative of ln n with respect to a strain
 * that keeps the volume, where n is the kernel sum at a site. If it is negative, gas at rest lowers its
 * energy by shearing, which grows at a rate of some tenths of sound speed / spacing, whatever the viscosity
 * is. The strains are those along axes and along directions halfway between two axes, of the lattice as a
 * whole; waves of a few spacings are not considered. INFINITY in 1-D, and for a glass. */
double kith_lattice_stiffness(enum kith_lattice kind, enum kith_kernel kernel, double neighbors);

#endif
