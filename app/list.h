/* list.h - `kith list`: what a scene can choose from, family by family, with the doc of each member from its
 * own table. */
#ifndef KITH_APP_LIST_H
#define KITH_APP_LIST_H

#include "app/options.h"

/* Subject: none (all families), the name of a family, or `scene` (every key of a scene). USAGE for anything
 * else. */
enum kith_exit kith_list(const struct kith_options *options);

#endif
