/* What the formulas of a region give at a point. */
#include "app/initial/region.h"

#include <string.h>

kith_status kith_region_box(const struct kith_region *region, const struct kith_box *domain,
                            struct kith_box *box) {
  for (int a = 0; a < NDIM; ++a) {
    box->lower[a] = KITH_MAX(region->where.extent[a][0], domain->lower[a]);
    box->upper[a] = KITH_MIN(region->where.extent[a][1], domain->upper[a]);
    if (!(box->lower[a] < box->upper[a]))
      return kith_config_fail(region->node, NULL, "no part of it is in the domain");
    if (!isfinite(box->upper[a] - box->lower[a]))
      return kith_config_fail(region->node, NULL, "it is not bounded along axis %d", a);
  }
  return KITH_OK;
}

/* Evaluates one formula at x; a failure gets the region's line and `what` the formula is for. */
static kith_status value_of(const struct kith_region *region, struct kith_expression *formula,
                            const char *what, const double *x, double *value) {
  if (kith_expression_at(formula, NDIM, x, value) == KITH_OK) return KITH_OK;
  return kith_config_fail(region->node, NULL, "%s: %s", what, kith_failure());
}

static kith_status refuse(const struct kith_region *region, const char *what, double value, const double *x) {
  return kith_config_fail(region->node, NULL, "%s is %g at " KITH_PLACE, what, value, KITH_COORDINATES(x));
}

kith_status kith_region_holds(const struct kith_region *region, const double *x, bool *holds) {
  double value = 1;
  *holds = true;
  for (int a = 0; a < NDIM; ++a)
    *holds = *holds && x[a] >= region->where.extent[a][0] && x[a] < region->where.extent[a][1];
  if (*holds && region->where.inside != NULL)
    KITH_TRY(value_of(region, region->where.inside, "where", x, &value));
  *holds = *holds && value != 0;
  return KITH_OK;
}

static kith_status density_at(const struct kith_region *region, const double *x, double *density) {
  KITH_TRY(value_of(region, region->density, "density", x, density));
  return *density > 0 ? KITH_OK : refuse(region, "density", *density, x);
}

kith_status kith_region_mean_density(const struct kith_region *region, const struct kith_box *box,
                                     double *mean) {
  if (!isnan(kith_expression_constant(region->density))) return density_at(region, box->lower, mean);
  const int per_axis = NDIM == 1 ? 4096 : NDIM == 2 ? 128 : 32, samples = (int)kith_pow_dim(per_axis);
  double sum = 0;
  int inside = 0;
  for (int s = 0; s < samples; ++s) {
    double x[NDIM], density;
    for (int a = 0, rest = s; a < NDIM; ++a, rest /= per_axis)
      x[a] = box->lower[a] + (box->upper[a] - box->lower[a]) * (rest % per_axis + 0.5) / per_axis;
    bool holds;
    KITH_TRY(kith_region_holds(region, x, &holds));
    if (!holds) continue;
    KITH_TRY(density_at(region, x, &density));
    sum += density;
    ++inside;
  }
  if (inside == 0)
    return kith_config_fail(region->node, NULL,
                            "too thin in its box to average the density; narrow the box or give `spacing`");
  *mean = sum / inside;
  return KITH_OK;
}

static kith_status displaced(const struct kith_region *region, const double *x, double *out) {
  for (int a = 0; a < NDIM; ++a) {
    double by;
    KITH_TRY(value_of(region, region->displacement[a], "displacement", x, &by));
    out[a] = x[a] + by;
  }
  return KITH_OK;
}

static double determinant(const double d[3][3]) {
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    sum += d[0][a] * (d[1][b] * d[2][c] - d[1][c] * d[2][b]);
  }
  return sum;
}

kith_status kith_region_displace(const struct kith_region *region, const struct kith_box *domain, double step,
                                 double *x, double *stretch) {
  double d[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, side[2][NDIM], place[NDIM];
  *stretch = 1;
  if (region->displacement[0] == NULL) return KITH_OK;
  for (int b = 0; b < NDIM; ++b) {
    for (int k = 0; k < 2; ++k) {
      memcpy(place, x, sizeof place);
      place[b] += (2 * k - 1) * step;
      KITH_TRY(displaced(region, place, side[k]));
    }
    for (int a = 0; a < NDIM; ++a) d[a][b] = (side[1][a] - side[0][a]) / (2 * step);
  }
  *stretch = determinant((const double(*)[3])d);
  KITH_TRY(displaced(region, x, place));
  if (!(*stretch > 0)) return refuse(region, "displacement folds the lattice: its stretch", *stretch, x);
  for (int a = 0; a < NDIM; ++a)
    if (!(place[a] >= domain->lower[a] && place[a] <= domain->upper[a]))
      return refuse(region, "displacement leaves the domain: the coordinate", place[a], x);
  memcpy(x, place, sizeof place);
  return KITH_OK;
}

kith_status kith_region_state(const struct kith_region *region, const struct kith_material *material,
                              const double *x, struct kith_region_state *state) {
  static const char *const name[3] = {"velocity along x", "velocity along y", "velocity along z"};
  double pressure, sound_speed;
  *state = (struct kith_region_state){.pressure = NAN};
  KITH_TRY(density_at(region, x, &state->density));
  for (int a = 0; a < NDIM; ++a)
    if (region->velocity[a]) KITH_TRY(value_of(region, region->velocity[a], name[a], x, &state->velocity[a]));
  if (region->energy) {
    KITH_TRY(value_of(region, region->energy, "energy", x, &state->energy));
  } else {
    KITH_TRY(value_of(region, region->pressure, "pressure", x, &state->pressure));
    state->energy = kith_material_energy(material, state->density, state->pressure);
  }
  kith_material_state(material, 1, &state->density, &state->energy, &pressure, &sound_speed);
  if (state->pressure < 0 && sound_speed == 0) /* a tension that tears the material */
    return refuse(region, "pressure", state->pressure, x);
  if (!region->energy && !kith_pressure_holds(material, state->density, state->energy, state->pressure))
    return refuse(region, "pressure is not what its eos has at this density: it", state->pressure, x);
  const bool possible = isfinite(state->energy) && (state->energy >= 0 || !material->eos->energy_positive);
  if (!possible) return refuse(region, "energy", state->energy, x);
  /* No step checks frozen nodes later, and they would drive the gas beside them without limit. */
  const char *outside = kith_material_outside(material, state->density, state->energy, pressure, sound_speed);
  return outside == NULL ? KITH_OK
                         : kith_config_fail(region->node, NULL, "%s (density %g, energy %g) at " KITH_PLACE,
                                            outside, state->density, state->energy, KITH_COORDINATES(x));
}

kith_status kith_region_damage(const struct kith_region *region, const double *x, double *damage) {
  const double porosity = region->porosity >= 0 ? region->porosity : !region->barrier;
  *damage = 0;
  if (region->damage != NULL) KITH_TRY(value_of(region, region->damage, "damage", x, damage));
  if (!(*damage >= 0 && *damage <= 1)) return refuse(region, "damage, in [0, 1],", *damage, x);
  *damage = 1 - porosity * (1 - *damage);
  return KITH_OK;
}

kith_status kith_region_inflow_state(const struct kith_flow_settings *flow,
                                     const struct kith_material *material,
                                     const struct kith_config_node *node, const double *x,
                                     struct kith_region_state *state) {
  struct kith_region face = {
      .node = node, .density = flow->density, .pressure = flow->pressure, .energy = flow->energy};
  memcpy(face.velocity, flow->velocity, sizeof face.velocity);
  return kith_region_state(&face, material, x, state);
}
