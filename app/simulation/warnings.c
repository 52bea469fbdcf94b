/* Warnings of scenes that can run, but not as they are likely meant. */
#include "app/simulation/simulation.h"

#include <math.h>
#include <stdio.h>
#include "app/initial/lattice.h"

/* Warns of lattices beside mirrors: a mirror continues cubic lattices only; the layers of others are shifted
 * sideways in it, and gas at rest beside it moves. */
static void warn_of_mirrors(const struct kith_scene *scene) {
  for (int r = 0; NDIM > 1 && r < scene->n_regions; ++r)
    for (int a = 0; a < NDIM; ++a) {
      const struct kith_region *region = &scene->region[r];
      const struct kith_boundary_ops *lower = scene->boundary[a].side[0], *upper = scene->boundary[a].side[1];
      const bool ordered = region->lattice != KITH_LATTICE_CUBIC && region->lattice != KITH_LATTICE_GLASS;
      const bool at_lower =
                     lower != NULL && lower->mirrors && region->where.extent[a][0] <= scene->domain.lower[a],
                 at_upper =
                     upper != NULL && upper->mirrors && region->where.extent[a][1] >= scene->domain.upper[a];
      if (!ordered || !(at_lower || at_upper)) continue;
      fprintf(stderr,
              "kith: warning: regions.%d.lattice: %s%s does not continue through the mirror along %c, gas at "
              "rest beside it moves; take cubic, a periodic axis, or frozen nodes\n",
              r, kith_lattice_names[region->lattice],
              kith_config_child(region->node, "lattice") == NULL ? ", the default," : "", "xyz"[a]);
      return;
    }
}

/* Warns of barriers that gas may pass: one is as thick as a spacing of the gas that presses on it, here at
 * least the finest. What bounds them in a formula is not seen. */
static void warn_of_barriers(const struct kith_scene *scene) {
  double finest = INFINITY;
  for (int r = 0; r < scene->n_regions; ++r) {
    const struct kith_region *gas = &scene->region[r];
    if (!kith_region_stays(gas))
      finest = KITH_MIN(finest, gas->spacing > 0 ? gas->spacing : 1 / scene->resolution);
  }
  for (int r = 0; r < scene->n_regions; ++r)
    for (int a = 0; scene->region[r].barrier && a < NDIM; ++a) {
      const double *extent = scene->region[r].where.extent[a], thickness = extent[1] - extent[0];
      const bool inside = extent[0] > scene->domain.lower[a] && extent[1] < scene->domain.upper[a];
      if (inside && thickness < (1 - 1e-9) * finest)
        fprintf(
            stderr,
            "kith: warning: regions.%d.barrier: %g thick along %c, gas with a spacing of %g may pass it\n", r,
            thickness, "xyz"[a], finest);
    }
}

static void warn_of_materials(const struct kith_scene *scene) {
  for (int m = 0; m < scene->n_materials; ++m) {
    bool used = false;
    for (int r = 0; r < scene->n_regions; ++r) used |= scene->region[r].material == m;
    if (!used)
      fprintf(stderr, "kith: warning: materials.%s: no region is of this material\n",
              scene->material_name[m]);
  }
}

static void warn_of_deposits(const struct kith_scene *scene) {
  for (int k = 0; k < scene->n_deposits; ++k)
    if (scene->deposit[k].time > scene->until)
      fprintf(stderr, "kith: warning: energy: %g is released at time %g, after the end of the run at %g\n",
              scene->deposit[k].energy, scene->deposit[k].time, scene->until);
}

static void warn_of_courant(const struct kith_simulation *m) {
  const struct kith_package_ops *ops = m->package.ops;
  const bool limits = m->integrator.fixed_dt == 0 && !m->integrator.scheme->implicit && ops->stable_cfl > 0;
  if (limits && m->integrator.cfl > ops->stable_cfl)
    fprintf(stderr, "kith: warning: scheme.cfl: %g is beyond %g, up to which gas at rest stays so with %s\n",
            m->integrator.cfl, ops->stable_cfl, ops->name);
}

static void warn_of_point(const struct kith_scene *scene) {
  const double spacing = 1 / scene->resolution, softening = scene->external_force.softening;
  if (scene->external_force.mass > 0 && softening < spacing)
    fprintf(
        stderr,
        "kith: warning: potential.softening: %g is less than a spacing, %.3g: the energy of gas that comes "
        "so near to the point is wrong\n",
        softening, spacing);
}

static void warn_of_neighbors(const struct kith_package *p) {
  const double most = kith_kernel_most_neighbors(p->kernel);
  if (p->neighbors <= most) return;
  fprintf(stderr,
          "kith: warning: method.neighbors: nodes pair up with %.4g neighbors under kernel %s, which carries "
          "%.3g in %d-D; take %s\n",
          p->neighbors, kith_kernel_facts[p->kernel].name, most, NDIM,
          kith_kernel_facts[kith_kernel_unpaired(p->neighbors)].name);
}

/* Warns of a viscous package on a lattice that resists shear itself, or gives way to it. */
static void warn_of_viscosity(const struct kith_simulation *m) {
  const double most = 0.03; /* quintic splines have 0.02 with the default neighbors */
  const struct kith_package *hydro = &m->package;
  bool viscous = false;
  for (const struct kith_package *p = hydro->next; p != NULL; p = p->next)
    viscous = viscous || kith_package_traits(p->ops, p->settings).viscous;
  if (!viscous || !kith_package_traits(hydro->ops, hydro->settings).elastic) return;
  for (int r = 0; r < m->scene->n_regions; ++r) {
    const enum kith_lattice lattice = m->scene->region[r].lattice;
    const double stiffness = kith_lattice_stiffness(lattice, hydro->kernel, hydro->neighbors);
    if (!isfinite(stiffness) || fabs(stiffness) < most) continue;
    fprintf(stderr,
            "kith: warning: regions.%d.lattice: with %s a %s lattice has a shear stiffness of %.2g of the "
            "pressure, so gas is not as viscous as `packages` says; take kernel quintic, more neighbors, or "
            "another package\n",
            r, hydro->ops->name, kith_lattice_names[lattice], stiffness);
    return;
  }
}

void kith_simulation_warn(const struct kith_simulation *m) {
  warn_of_mirrors(m->scene);
  warn_of_barriers(m->scene);
  warn_of_materials(m->scene);
  warn_of_deposits(m->scene);
  warn_of_point(m->scene);
  warn_of_courant(m);
  warn_of_neighbors(&m->package);
  warn_of_viscosity(m);
}
