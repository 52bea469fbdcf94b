/* model.h - all objects of a run, made from a scene: nodes, boundaries, search, connectivity, package, integrator. */
#ifndef KITH_APP_MODEL_H
#define KITH_APP_MODEL_H

#include "app/scene.h"
#include "integrator/integrator.h"

struct kith_model {
  const struct kith_scene *scene; /* borrowed */
  struct kith_nodes *nodes;
  struct kith_hydro hydro;
  struct kith_package package;
  struct kith_boundaries boundaries;
  struct kith_search *search;
  struct kith_connectivity *connectivity;
  struct kith_rebuilds rebuilds;
  struct kith_integrator integrator;
  struct kith_share *share;     /* NULL: all nodes are in this process */
  struct kith_profile *profile; /* NULL: not profiled */
};

/* Makes everything, in memory that *out owns; the nodes stand at their start. Call kith_model_start, or restore and resume.
 * `profile` is borrowed and may be NULL. BAD_INPUT with file and line for what only shows when nodes are laid. */
kith_status kith_model_create(struct kith_model **out, const struct kith_scene *scene,
                              struct kith_profile *profile, bool check);
/* Of a fresh model, on every rank of a run: keeps what is this rank's, and joins the others. All ranks laid out the same scene. No communication,
 * but everything after it is collective. NULL ranks: nothing happens. */
kith_status kith_model_share(struct kith_model *model, struct kith_ranks *ranks);
/* First rates, and what waited for them (setup.h: regions in equilibrium). DIVERGED as a step. */
kith_status kith_model_start(struct kith_model *model);
/* To stderr, one line: what may go wrong with this model and still may be wanted. */
void kith_model_warn(const struct kith_model *model);
void kith_model_destroy(struct kith_model **model);

/* Bytes by structure, for plan, report and bench. */
struct kith_bytes {
  const char *name;
  size_t bytes;
};
enum { KITH_MODEL_STRUCTURES = 6 };
void kith_model_bytes(const struct kith_model *model, struct kith_bytes out[KITH_MODEL_STRUCTURES]);

#endif
