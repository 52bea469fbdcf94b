/* run.h - a scene from start to end: steps, progress, snapshots, history, checkpoints, comparison, report, picture. */
#ifndef KITH_APP_RUN_H
#define KITH_APP_RUN_H

#include "app/options.h"

/* Exit code: 0, 1 (the run failed; a snapshot of where it failed is in the directory) or 2 (scene, files). */
enum kith_exit kith_run(const struct kith_options *options);

#endif
