/* package_list.h - the packages by name, for those who need nothing but the names: hydro packages, of which a
 * run has one, and those that act on its pairs. */
#ifndef KITH_PHYSICS_PACKAGE_LIST_H
#define KITH_PHYSICS_PACKAGE_LIST_H

#define KITH_PACKAGE_LIST(X) X(sph) X(crk) X(mfm) X(magma2) X(remix)
#define KITH_ADDED_PACKAGE_LIST(X) X(conduction) X(viscosity) X(coupling)

#endif
