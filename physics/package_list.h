/* package_list.h - the hydro packages by name, for those who need nothing but the names. */
#ifndef KITH_PHYSICS_PACKAGE_LIST_H
#define KITH_PHYSICS_PACKAGE_LIST_H

#define KITH_PACKAGE_LIST(X) X(sph) X(crk) X(mfm)

#endif
