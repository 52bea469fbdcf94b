/* plan.h - `kith plan SCENE`: what a scene will build and why, what it needs of memory and time; nothing
 * runs.
 *
 * All is taken from the objects that a run would make: the nodes are laid, and the rates of the start are
 * evaluated, once to have them (dt, neighbors, memory) and up to three times more to time them. Nothing is
 * written. Steps: dt as the first rates allow it, kept to the end, behind the short steps of the start; where
 * a flow makes or loses a shock dt will change, so this is an estimate. Cost: steps times the time of one
 * evaluation. */
#ifndef KITH_APP_PLAN_H
#define KITH_APP_PLAN_H

#include "app/options.h"

/* USAGE with one line if the scene is wrong; FAILED if its rates cannot be evaluated. */
enum kith_exit kith_plan(const struct kith_options *options);

#endif
