/* Regions: geometry, mean density, displacement, state at a place. */
#include "app/initial/region.h"

#include <stdio.h>
#include <string.h>

const char *kith_point_text(char text[KITH_POINT_TEXT], const double *x) {
  int length = snprintf(text, KITH_POINT_TEXT, "(%.10g", x[0]);
  for (int a = 1; a < NDIM; ++a)
    length += snprintf(text + length, (size_t)(KITH_POINT_TEXT - length), ", %.10g", x[a]);
  snprintf(text + length, (size_t)(KITH_POINT_TEXT - length), ")");
  return text;
}

kith_status kith_region_box(const struct kith_region *region, const struct kith_box *domain,
                            struct kith_box *box) {
  for (int a = 0; a < NDIM; ++a) {
    box->lower[a] = KITH_MAX(region->where.box.lower[a], domain->lower[a]);
    box->upper[a] = KITH_MIN(region->where.box.upper[a], domain->upper[a]);
    if (!(box->lower[a] < box->upper[a]))
      KITH_FAIL_AT(&region->location, "region: no part of it is in the domain");
    if (!isfinite(box->upper[a] - box->lower[a]))
      KITH_FAIL_AT(&region->location, "region: it is not bounded along axis %d", a);
  }
  return KITH_OK;
}

/* One formula at x; a failure gets the region's line and what the formula is for. */
static kith_status value_at(const struct kith_region *region, struct kith_expression *formula,
                            const char *what, const double *x, double *value) {
  if (kith_expression_at(formula, NDIM, x, value) == KITH_OK) return KITH_OK;
  KITH_FAIL_AT(&region->location, "region: %s: %s", what, kith_failure());
}

static kith_status refused(const struct kith_region *region, const char *what, double value,
                           const double *x) {
  char text[KITH_POINT_TEXT];
  KITH_FAIL_AT(&region->location, "region: %s is %g at %s", what, value, kith_point_text(text, x));
}

static bool in_box(const struct kith_box *box, const double *x) {
  for (int a = 0; a < NDIM; ++a)
    if (!(x[a] >= box->lower[a] && x[a] < box->upper[a])) return false;
  return true;
}

static bool in_half_space(const struct kith_where *where, const double *x) {
  double along = 0, leading = 0;
  for (int a = NDIM - 1; a >= 0; --a) {
    along += (x[a] - where->point[a]) * where->normal[a];
    if (where->normal[a] != 0) leading = where->normal[a];
  }
  return along > 0 || (along == 0 && leading > 0);
}

kith_status kith_region_holds(const struct kith_region *region, const double *x, bool *holds) {
  const struct kith_where *where = &region->where;
  *holds = in_box(&where->box, x);
  if (*holds && where->has_ball)
    *holds = (kith_distance2(x, where->center) < where->radius * where->radius) != where->outside_ball;
  if (*holds && where->has_half_space) *holds = in_half_space(where, x);
  if (!*holds || !where->inside) return KITH_OK;
  double value;
  KITH_TRY(value_at(region, where->inside, "where", x, &value));
  *holds = value != 0;
  return KITH_OK;
}

static kith_status density_at(const struct kith_region *region, const double *x, double *density) {
  KITH_TRY(value_at(region, region->density, "density", x, density));
  return *density > 0 ? KITH_OK : refused(region, "density", *density, x);
}

kith_status kith_region_mean_density(const struct kith_region *region, const struct kith_box *box,
                                     double *mean) {
  if (kith_expression_constant(region->density)) return density_at(region, box->lower, mean);
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
    KITH_FAIL_AT(&region->location,
                 "region: too thin in its box to average the density; narrow the box or give `spacing`");
  *mean = sum / inside;
  return KITH_OK;
}

static kith_status displaced(const struct kith_region *region, const double *x, double *out) {
  for (int a = 0; a < NDIM; ++a) {
    double by;
    KITH_TRY(value_at(region, region->displacement[a], "displacement", x, &by));
    out[a] = x[a] + by;
  }
  return KITH_OK;
}

/* Determinant of d[row][column]. */
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
  if (!(*stretch > 0)) return refused(region, "displacement folds the lattice: its stretch", *stretch, x);
  for (int a = 0; a < NDIM; ++a)
    if (!(place[a] >= domain->lower[a] && place[a] <= domain->upper[a]))
      return refused(region, "displacement leaves the domain: the coordinate", place[a], x);
  memcpy(x, place, sizeof place);
  return KITH_OK;
}

kith_status kith_region_state_at(const struct kith_region *region, const struct kith_material *material,
                                 const double *x, struct kith_region_state *state) {
  static const char *const name[3] = {"velocity along x", "velocity along y", "velocity along z"};
  *state = (struct kith_region_state){.pressure = NAN};
  KITH_TRY(density_at(region, x, &state->density));
  for (int a = 0; a < NDIM; ++a)
    if (region->velocity[a]) KITH_TRY(value_at(region, region->velocity[a], name[a], x, &state->velocity[a]));
  if (region->energy) {
    KITH_TRY(value_at(region, region->energy, "energy", x, &state->energy));
  } else {
    KITH_TRY(value_at(region, region->pressure, "pressure", x, &state->pressure));
    if (state->pressure < 0) return refused(region, "pressure", state->pressure, x);
    state->energy = material->eos->energy(material->settings, state->density, state->pressure);
    if (!material->eos->energy_positive &&
        !kith_pressure_holds(kith_material_pressure(material, state->density, state->energy),
                             state->pressure))
      return refused(region, "pressure is not what its eos has at this density: it", state->pressure, x);
  }
  const bool possible = isfinite(state->energy) && (state->energy >= 0 || !material->eos->energy_positive);
  return possible ? KITH_OK : refused(region, "energy", state->energy, x);
}
