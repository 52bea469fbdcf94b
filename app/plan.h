/* plan.h - `kith plan SCENE`: what a scene will build and why, what it needs of memory and time, in which cheaper forms it may be had,
 * and with --ranks N what partitioners would make of it (plan_ranks.h). Nothing is written.
 *
 * All is taken from the objects that a run would make: the nodes are laid, and the rates of the start are evaluated, once to have them (dt,
 * neighbors, memory) and up to three times more to time them. Steps and cost: the time of one evaluation, and two short runs of the scene with
 * fewer nodes (pilot.h); for what costs less than a second, dt as the first rates allow it, kept to the end. What costs more than two seconds
 * is offered in cheaper forms (forms.h), unless --quiet. */
#ifndef KITH_APP_PLAN_H
#define KITH_APP_PLAN_H

#include "app/options.h"

/* USAGE with one line if the scene is wrong; FAILED if its rates cannot be evaluated. */
enum kith_exit kith_plan(const struct kith_options *options);

#endif
