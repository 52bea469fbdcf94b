/* package_list.h - names of the packages: hydro packages, of which a run has one, and those added to it. */
#ifndef KITH_PHYSICS_PACKAGE_LIST_H
#define KITH_PHYSICS_PACKAGE_LIST_H

#define KITH_PACKAGE_LIST(X) X(sph) X(crk) X(mfm) X(magma2) X(remix)
#define KITH_ADDED_PACKAGE_LIST(X) X(conduction) X(viscosity) X(coupling)

#endif
