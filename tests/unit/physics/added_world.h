/* added_world.h - for tests: a world (sph_world.h) with packages that add to the rates of its hydro package,
 * and the comparison of a package of diffusion with sums over all images of all nodes. */
#ifndef KITH_TEST_PHYSICS_ADDED_WORLD_H
#define KITH_TEST_PHYSICS_ADDED_WORLD_H

#include "tests/unit/physics/sph_world.h"

struct added {
  struct kith_package package;
  void *settings;
};

/* Appends a package to those of the world. It must come after the last change of w->package. */
static inline void added_attach(struct added *added, struct world *w, const char *name,
                                const char *assignments) {
  struct kith_package *last = &w->package;
  while (last->next != NULL) last = last->next;
  CHECK_OK(kith_settings_create(&added->settings, kith_family_member(kith_added_member, name), assignments));
  added->package = (struct kith_package){.ops = kith_added_find(name),
                                         .hydro = &w->hydro,
                                         .kernel = last->kernel,
                                         .neighbors = last->neighbors,
                                         .compatible = last->compatible,
                                         .settings = added->settings,
                                         .traversal = last->traversal};
  CHECK_OK(kith_package_init(&added->package));
  last->next = &added->package;
}

/* Removes all added packages. */
static inline void added_detach(struct world *w, int n, struct added *added) {
  w->package.next = NULL;
  for (int k = 0; k < n; ++k) {
    kith_package_clear(&added[k].package);
    kith_free(&added[k].settings);
  }
}

/* The diffusion between node i and its partner over the difference that drives it: 4 k_i k_j / (k_i + k_j)
 * V_i V_j (dW/dr) / r, the mean of both supports, over the mass of i; `value` is k by list. Its normalization
 * is that of kernel.h, which test_kernel.c tests. */
static inline double truth_diffusion(const struct world *w, const struct truth *t, int i,
                                     const struct partner *p, const double *value) {
  const int j = p->node;
  const double hi = t->support[i], hj = t->support[j];
  const double ki = value[w->nodes->list->u8[i]], kj = value[w->nodes->list->u8[j]];
  double slope = 0;
  if (p->r < hi) slope += 0.5 * w->kernel.constant / pow(hi, NDIM + 2) * oracle_g(&w->kernel, p->r / hi);
  if (p->r < hj) slope += 0.5 * w->kernel.constant / pow(hj, NDIM + 2) * oracle_g(&w->kernel, p->r / hj);
  return 4 * ki * kj / (ki + kj) * w->hydro.mass->f64[j] / (t->density[i] * t->density[j]) * slope /
         kith_kernel_gradient_sum(w->package.kernel, w->package.neighbors);
}

/* Compares rates with the truth, to which `add` adds what the package does to node i by one partner. */
static inline void added_check_sums(const char *name, const char *settings,
                                    void (*add)(const struct world *w, struct truth *t, int i,
                                                const struct partner *p)) {
  const int cells[3] = {NDIM == 1 ? 14 : NDIM == 2 ? 7 : 5, NDIM == 2 ? 6 : 4, 3};
  const double round_off = 1e-11; /* sums of a few hundred terms, as for package sph */
  for (int side = OPEN; side <= REFLECTING; ++side)
    for (int pairs = 0; pairs < 2; ++pairs) {
      const enum kith_traversal traversal = pairs ? KITH_TRAVERSE_PAIRS : KITH_TRAVERSE_GATHER;
      const struct method m = {KITH_KERNEL_wendland_c2, KITH_VISCOSITY_NONE, traversal, true, 0, 0,
                               KITH_BALSARA_NONE};
      struct added added;
      struct world w;
      struct truth t = {0};
      world_create(&w, cells, (enum side)side, 0.3, &m, 5);
      added_attach(&added, &w, name, settings);
      truth_density(&w, &t);
      world_root(&w, &t);
      world_base(&w);
      truth_all(&w, &t);
      for (int i = 0; i < w.nodes->n_internal; ++i)
        for (size_t e = t.partners.first[i]; e < t.partners.first[i + 1]; ++e)
          add(&w, &t, i, &t.partners.partner[e]);
      CHECK_OK(world_evaluate(&w));
      CHECK_OK(kith_package_evaluate(&w.package, w.connectivity, &w.it.kick));
      CHECK_FIELD(w.hydro.acceleration->f64, &t.acceleration[0][0], w.nodes->n_internal * NDIM, round_off);
      CHECK_FIELD(w.hydro.energy_rate->f64, t.rate, w.nodes->n_internal, round_off);
      truth_clear(&t);
      added_detach(&w, 1, &added);
      world_destroy(&w);
    }
}

#endif
