/* conformance_exact.c - every exact solution: Euler's equations at random positions and times, by differences
 * (for solutions with diffusion test_exact.c has their own laws); states that are gas of an ideal equation of
 * state, or vacuum; settings that are missing, out of range or contradictory, refused by name; and settings
 * derived from a scene. What single members promise is tested by test_exact.c, test_riemann.c and
 * test_sedov.c. */
#include "tests/unit/exact_settings.h"

#include <stdlib.h>

static const struct exact_parameters sample = {.gamma = {1.4, 1.5},
                                               .density = {2, 1},
                                               .velocity = {0.3, -0.2},
                                               .pressure = {5, 4},
                                               .uniform_velocity = {0.7},
                                               .side = {0.5},
                                               .interface_position = 0.1,
                                               .blast_energy = 1.5,
                                               .end_time = 0.01,
                                               .amplitude = 1e-6,
                                               .wavelength = 0.8,
                                               .origin = 0.1,
                                               .focus_time = 0.5};

/* kidder has the gamma of its dimension; all others take this one. */
static double gamma_for(const struct kith_exact_ops *ops, double any) {
  return kith_params_find(ops->params, "focus_time") != NULL ? 1 + 2. / NDIM : any;
}
/* two-blasts stores states up to an end time, from a numerical reference. */
static bool is_stored(const struct kith_exact_ops *ops) {
  return kith_params_find(ops->params, "end_time") != NULL;
}

static struct exact_parameters sample_of(const struct kith_exact_ops *ops) {
  struct exact_parameters p = sample;
  for (int a = 0; a < NDIM; ++a) p.side[a] = 0.5;
  if (kith_params_find(ops->params, "side") != NULL) p.period[0] = 2;
  if (ops->star != NULL) p.velocity[0] = -0.5, p.velocity[1] = 0.5; /* apart: two rarefactions */
  if (ops->star == NULL && kith_params_find(ops->params, "velocity") != NULL)
    p.pressure[0] = 0; /* cold inflow */
  if (ops->vortex && kith_params_find(ops->params, "density") == NULL) p.amplitude = 3;
  p.gamma[0] = gamma_for(ops, p.gamma[0]);
  return p;
}

static bool refused(const struct kith_exact_ops *ops, const void *settings, const char *key) {
  void *self = NULL;
  if (kith_exact_create(&self, ops, settings) == KITH_BAD_INPUT && self == NULL)
    return strstr(kith_failure(), key) != NULL && strstr(kith_failure(), ops->name) != NULL;
  kith_free(&self);
  return false;
}

/* ---- settings ---- */

static double bound(const char *range, bool upper) {
  if (range[0] == '\0') return upper ? INFINITY : -INFINITY;
  return strtod(upper ? strchr(range, ',') + 1 : range + 1, NULL);
}

/* Sets each number in turn to NaN, to infinity, and to values below and above its range. */
static void check_ranges(const struct kith_exact_ops *ops) {
  for (const struct kith_param *p = ops->params; p->key != NULL; ++p) {
    if (p->kind != KITH_PARAM_NUMBER && p->kind != KITH_PARAM_VECTOR && p->kind != KITH_PARAM_SIDES) continue;
    const double lower = bound(p->allowed, false), upper = bound(p->allowed, true);
    const double wrong[] = {NAN, INFINITY, lower - 1e-3, upper + 1e-3};
    for (int k = 0; k < 4; ++k) {
      const struct exact_parameters q = sample_of(ops);
      double settings[EXACT_NUMBERS];
      if (k >= 2 && !isfinite(wrong[k])) continue;
      exact_fill(settings, ops, &q);
      memcpy((char *)settings + p->offset, &wrong[k], sizeof wrong[k]);
      CHECK(refused(ops, settings, p->key));
    }
    CHECK(p->doc[0] != '\0' && (p->fallback == NULL || p->fallback[0] != '\0'));
  }
}

/* Two regions of constant state that touch along x, a deposit in the lower corner, and walls there. */
static struct kith_exact_scene scene_with(double gamma, const double *velocity) {
  struct kith_exact_scene s = {.until = 0.25, .n_regions = 2, .n_deposits = 1, .deposit_energy = 3};
  for (int a = 0; a < NDIM; ++a) {
    s.lower[a] = -1, s.upper[a] = 1, s.deposit_center[a] = -1;
    s.axis[a].mirror[0] = s.axis[a].mirror[1] = a == 0, s.axis[a].periodic = a > 0;
    for (int r = 0; r < 2; ++r) {
      s.region[r].lower[a] = a == 0 && r == 1 ? 0.2 : -1, s.region[r].upper[a] = a == 0 && r == 0 ? 0.2 : 1;
      s.region[r].velocity[a] = velocity[a];
    }
  }
  for (int r = 0; r < 2; ++r)
    s.region[r].gamma = gamma, s.region[r].density = 1 + r, s.region[r].pressure = 0.5 + r;
  return s;
}

/* Parameters that follow from a scene are set; those that do not stay missing, and are refused by name. */
static void check_derived(const struct kith_exact_ops *ops) {
  const double velocity[] = {0.3, 0.4, 0};
  const double gamma = gamma_for(ops, 1.6);
  struct kith_exact_scene scene = scene_with(gamma, velocity);
  void *settings;
  CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_exact_member, ops->name), NULL));
  if (ops->derive != NULL) ops->derive(settings, &scene);
  double own[EXACT_NUMBERS];
  exact_fill(own, ops, &sample);
  for (const struct kith_param *row = ops->params; row->key != NULL; ++row) { /* what does not follow */
    const bool missing = isnan(*(double *)((char *)settings + row->offset));
    CHECK(!row->given || missing);
    if (row->fallback != NULL || !missing) continue;
    /* Hugoniot's velocity is of a piston, which this scene lacks. */
    CHECK(row->given || ops == &kith_exact_hugoniot || ops == &kith_exact_acoustic_wave);
    CHECK(refused(ops, settings, row->key) || (ops->vortex && NDIM == 1));
    memcpy((char *)settings + row->offset, (char *)own + row->offset, row->size);
  }
  void *self = NULL;
  const kith_status status = kith_exact_create(&self, ops, settings);
  if (ops->vortex && NDIM == 1)
    CHECK(status == KITH_BAD_INPUT && strstr(kith_failure(), "a vortex needs 2 or 3 dimensions") != NULL);
  else
    CHECK_OK(status);
  if (status == KITH_OK) kith_free(&self);
  CHECK(exact_parameters_of(ops, settings).gamma[0] == (ops->not_ideal ? 0 : gamma));
  scene = scene_with(NAN, velocity); /* not an ideal gas: nothing is derived */
  if (ops->derive != NULL) ops->derive(settings, &scene);
  if (!ops->not_ideal)
    CHECK(isnan(exact_parameters_of(ops, settings).gamma[0]) && refused(ops, settings, "gamma"));
  kith_free(&settings);
}

/* Derived values, against those of the scene. */
static void check_derived_values(void) {
  const double velocity[] = {0.3, 0.4, 0};
  struct kith_exact_scene scene = scene_with(1.6, velocity);
  for (const struct kith_exact_ops *const *all = kith_exact_all(); *all != NULL; ++all) {
    void *settings;
    CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_exact_member, (*all)->name), NULL));
    if ((*all)->derive != NULL) (*all)->derive(settings, &scene);
    const struct exact_parameters p = exact_parameters_of(*all, settings);
    if (*all == &kith_exact_riemann)
      CHECK(p.interface_position == 0.2 && p.density[1] == 2 && p.pressure[0] == 0.5 && p.velocity[1] == 0.3);
    if (*all == &kith_exact_sedov) CHECK(p.blast_energy == 6 && p.center[0] == -1 && p.omega == 0);
    if (*all == &kith_exact_square)
      CHECK(p.side[0] == 1.2 && p.center[0] == -0.4 && p.density[1] == 2 &&
            p.period[NDIM - 1] == (NDIM > 1 ? 2 : 0));
    if (*all == &kith_exact_gresho || *all == &kith_exact_yee)
      CHECK(p.period[0] == 0 && p.period[NDIM - 1] == (NDIM > 1 ? 2 : 0));
    if (*all == &kith_exact_slabs) CHECK(p.interface_position == 0.2 && p.density[1] == 2);
    if (is_stored(*all)) CHECK(p.end_time == 0.25);
    if (*all == &kith_exact_acoustic_wave || *all == &kith_exact_entropy_wave ||
        *all == &kith_exact_decaying_wave)
      CHECK(p.wavelength == 2);
    if (*all == &kith_exact_acoustic_wave && NDIM > 1)
      CHECK(p.uniform_velocity[0] == 0 && p.uniform_velocity[NDIM > 1] == 0.4);
    if (*all == &kith_exact_uniform) CHECK(p.uniform_velocity[0] == 0.3 && p.density[0] == 1);
    kith_free(&settings);
  }
}

/* Half spaces are told apart by where they are, not by the order in which the scene has them. Regions that do
 * not touch, or do not reach across the domain, or feel a force, are none: nothing follows. */
static void check_derived_halves(void) {
  static const struct kith_exact_ops *const halves[] = {&kith_exact_riemann, &kith_exact_slabs};
  const double velocity[] = {0.3, 0.4, 0};
  for (int k = 0; k < 2; ++k)
    for (int way = 0; way < 8; ++way) {
      struct kith_exact_scene scene = scene_with(1.6, velocity);
      if (way > 0) { /* the other order */
        const struct kith_exact_region first = scene.region[0];
        scene.region[0] = scene.region[1], scene.region[1] = first;
      }
      if (way == 2) scene.region[1].upper[0] -= 0.1; /* a gap */
      if (way == 3) scene.region[1].lower[0] += 0.1; /* an empty end */
      if (way == 4) scene.region[0].upper[0] -= 0.1;
      if (way == 5) scene.region[0].irregular = true;
      if (way == 6) scene.forced = true;
      if (way == 7 && NDIM > 1) scene.region[0].upper[NDIM - 1] -= 0.1; /* half of the height */
      void *settings;
      CHECK_OK(kith_settings_create(&settings, kith_family_member(kith_exact_member, halves[k]->name), NULL));
      halves[k]->derive(settings, &scene);
      const struct exact_parameters p = exact_parameters_of(halves[k], settings);
      kith_free(&settings);
      if (way < 2 || way == 3 || way == 4 || (way == 7 && NDIM == 1))
        CHECK(p.density[0] == 1 && p.density[1] == 2 && p.pressure[0] == 0.5 && p.interface_position == 0.2);
      else
        CHECK(isnan(p.interface_position) && isnan(p.density[0]));
    }
}

/* ---- states ---- */

struct probe {
  const struct kith_exact_ops *ops;
  const void *self;
};

static struct kith_exact_state at(const struct probe *p, const double *x, double time) {
  struct kith_exact_state s;
  p->ops->state(p->self, x, time, &s);
  return s;
}

/* Do rates of density, velocity and pressure, by central differences over h, satisfy Euler's equations,
 * within a fraction of the largest terms and rounding? */
static bool satisfies_euler(const struct probe *p, double gamma, const double *x, double time, double h) {
  const struct kith_exact_state s = at(p, x, time), late = at(p, x, time + h), early = at(p, x, time - h);
  double rate[NDIM + 2], sum[NDIM + 2], size[NDIM + 2], divergence = 0, spread = 0;
  rate[0] = (late.density - early.density) / (2 * h), rate[1] = (late.pressure - early.pressure) / (2 * h);
  for (int a = 0; a < NDIM; ++a) rate[2 + a] = (late.velocity[a] - early.velocity[a]) / (2 * h);
  for (int q = 0; q < NDIM + 2; ++q) sum[q] = rate[q], size[q] = fabs(rate[q]);
  for (int a = 0; a < NDIM; ++a) {
    double y[NDIM];
    memcpy(y, x, sizeof y);
    y[a] = x[a] + h;
    const struct kith_exact_state e = at(p, y, time);
    y[a] = x[a] - h;
    const struct kith_exact_state w = at(p, y, time);
    const double drho = (e.density - w.density) / (2 * h), dp = (e.pressure - w.pressure) / (2 * h);
    divergence += (e.velocity[a] - w.velocity[a]) / (2 * h);
    spread += fabs(e.velocity[a] - w.velocity[a]) / (2 * h);
    sum[0] += s.velocity[a] * drho, size[0] += fabs(s.velocity[a] * drho);
    sum[1] += s.velocity[a] * dp, size[1] += fabs(s.velocity[a] * dp);
    sum[2 + a] += dp / s.density, size[2 + a] += fabs(dp / s.density);
    for (int b = 0; b < NDIM; ++b) {
      const double dv = (e.velocity[b] - w.velocity[b]) / (2 * h);
      sum[2 + b] += s.velocity[a] * dv, size[2 + b] += fabs(s.velocity[a] * dv);
    }
  }
  sum[0] += s.density * divergence, size[0] += s.density * spread;
  sum[1] += gamma * s.pressure * divergence, size[1] += gamma * s.pressure * spread;
  const double rounding = 1e-14 * (s.density + s.pressure + 1) / h;
  for (int q = 0; q < NDIM + 2; ++q)
    if (!(fabs(sum[q]) <= 2e-4 * size[q] + rounding)) return false;
  return true;
}

static void check_states(const struct kith_exact_ops *ops, struct exact_parameters p) {
  enum { PLACES = 400 };
  struct probe probe = {ops, NULL};
  void *self = NULL;
  uint64_t seed = 11;
  int smooth = 0, tried = 0;
  if (ops->vortex && NDIM == 1) return;
  CHECK_OK(exact_create(&self, ops, &p));
  probe.self = self;
  for (int k = 0; k < PLACES && self != NULL; ++k) {
    double x[NDIM];
    const double time = is_stored(ops) ? 0.01 * check_random(&seed) : 0.05 + 0.2 * check_random(&seed);
    for (int a = 0; a < NDIM; ++a) x[a] = 0.02 + 0.9 * check_random(&seed);
    const struct kith_exact_state s = at(&probe, x, time);
    const double gamma = ops->star != NULL && x[0] > p.interface_position + ops->star(self).velocity * time
                             ? p.gamma[1]
                             : p.gamma[0];
    CHECK(isfinite(s.density) && isfinite(s.pressure) && isfinite(s.energy) && s.density >= 0);
    if (!ops->not_ideal)
      CHECK_CLOSE(s.density * s.energy * (gamma - 1), s.pressure, 1e-13 * (s.pressure + 1e-300));
    /* equal positions and times give equal states */
    const struct kith_exact_state again = at(&probe, x, time);
    CHECK(memcmp(&again, &s, sizeof s) == 0);
    ++tried;
    smooth += ops->not_ideal || satisfies_euler(&probe, gamma, x, time, 1e-5);
  }
  /* Except where differences straddle shocks, contacts and kinks. Stored states are not smooth. */
  if (!is_stored(ops)) CHECK(smooth >= tried * 98 / 100);
  if (smooth < tried * 98 / 100 && !is_stored(ops))
    fprintf(stderr, "%s: Euler's equations hold at %d of %d places\n", ops->name, smooth, tried);
  if (ops->shock != NULL) CHECK(isfinite(ops->shock(self, 0.1)));
  if (ops->radial) CHECK(kith_exact_about(ops, self)->center[0] == p.center[0]);
  kith_free(&self);
  CHECK(self == NULL);
}

int main(void) {
  int n = 0;
  for (const struct kith_exact_ops *const *all = kith_exact_all(); *all != NULL; ++all, ++n) {
    CHECK(kith_exact_find((*all)->name) == *all && (*all)->doc[0] != '\0' && (*all)->params != NULL);
    check_ranges(*all);
    check_derived(*all);
    struct exact_parameters p = sample_of(*all);
    check_states(*all, p);
    if (kith_params_find((*all)->params, "focus_time") == NULL) continue;
    p.focus_time = -3; /* it flies apart */
    check_states(*all, p);
    p.focus_time = 0;
    double settings[EXACT_NUMBERS];
    exact_fill(settings, *all, &p);
    CHECK(refused(*all, settings, "focus_time"));
  }
  CHECK(n >= 10 && kith_exact_find("sedo") == NULL && kith_exact_find("sedovv") == NULL &&
        kith_exact_find("") == NULL);
  CHECK(kith_exact_find("acoustic_wave") == kith_exact_find("acoustic-wave"));
  check_derived_values();
  check_derived_halves();
  return check_failed();
}
