/* riemann: two uniform half spaces meet at x[0] = interface_position at t = 0. E. F. Toro, Riemann Solvers
 * and Numerical Methods for Fluid Dynamics, chapter 4, with a gamma g and a stiffness s for each side (each
 * keeps its own up to the contact): rho c^2 = g (P + s). Below p is P + s.
 *
 * Pressure and velocity are equal on both sides of the contact. Wave K changes the velocity by
 *
 *   p > p_K, a shock:     f_K(p) = (p - p_K) sqrt(A / (p + B)),  A = 2 / ((g + 1) rho_K),
 *                         B = (g - 1) / (g + 1) p_K
 *     of a barotropic one f_K(p) = sqrt((p - p_K) (1 / rho_K - 1 / rho)), rho = rho_K (p / p_K)^(1 / g)
 *   else, a rarefaction:  f_K(p) = 2 c_K / (g - 1) ((p / p_K)^((g - 1) / 2g) - 1);  g = 1: c_K ln(p / p_K)
 *
 * and P solves f_L + f_R + u_R - u_L = 0, which is monotone: bisected in the logarithm of the pressure above
 * the lesser -s. If the left side is not negative at 0 the gases part and leave a vacuum, whose velocity is
 * set to x / t; what is stiff is torn, and refused. Barotropic are isothermal gases (g = 1, s = 0) and those
 * of Tait, on one side or both: their energy, which acts on nothing, takes the work of P and what shocks
 * lose. The left-running wave is the right-running one in the mirror. */
#include "validation/exact/exact_parameters.h"

#include <float.h>
#include <string.h>

struct settings {
  double gamma[2], stiffness[2], density[2], pressure[2], velocity[2], energy[2], interface_position;
  bool barotropic;         /* both sides */
  bool only_barotropic[2]; /* or one of them, which follows from a scene alone, as does */
  double across[2][NDIM]; /* the velocity along other axes than x, which stays with the gas; NaN: not known */
};
#define IN(member) KITH_INTO(struct settings, member)
static const struct kith_param params[] = {
    {"gamma", KITH_PARAM_SIDES, NULL, "[1, inf)",
     "ratio of specific heats, or exponent of the density: [left, right]", IN(gamma)},
    {"stiffness", KITH_PARAM_SIDES, "0", "", "tension at which the sound speed is 0: [left, right]",
     IN(stiffness)},
    {"barotropic", KITH_PARAM_BOOL, "false", "",
     "the pressure depends on the density alone, not on the energy", IN(barotropic)},
    {"energy", KITH_PARAM_SIDES, "0", "", "of barotropic gases, per unit mass at the start: [left, right]",
     IN(energy)},
    {"density", KITH_PARAM_SIDES, NULL, "[0, inf)", "[left, right]; 0: vacuum", IN(density)},
    {"velocity", KITH_PARAM_SIDES, NULL, "", "along x: [left, right]", IN(velocity)},
    {"pressure", KITH_PARAM_SIDES, NULL, "", "[left, right], not below -stiffness; 0 in a vacuum",
     IN(pressure)},
    {"interface_position", KITH_PARAM_NUMBER, NULL, "", "x of the jump", IN(interface_position)},
    {0}};

static void derive_side(struct settings *s, int side, const struct kith_exact_region *region) {
  s->gamma[side] = region->gamma;
  s->stiffness[side] = region->stiffness;
  s->energy[side] = region->barotropic ? region->energy : 0;
  s->density[side] = region->density;
  s->pressure[side] = region->pressure;
  s->velocity[side] = region->velocity[0];
  memcpy(s->across[side], region->velocity, sizeof s->across[side]);
}

/* Derives a vacuum: there is one region, with nothing between it and an open face. */
static void derive_vacuum(struct settings *s, const struct kith_exact_scene *scene) {
  const struct kith_exact_region *gas = &scene->region[0];
  const bool full_below = gas->lower[0] <= scene->lower[0], full_above = gas->upper[0] >= scene->upper[0];
  if (!kith_exact_spans(scene, gas)) return;
  const bool above = full_below && !full_above && scene->axis[0].open[1];
  if (!above && !(full_above && !full_below && scene->axis[0].open[0])) return;
  derive_side(s, above ? 0 : 1, gas);
  const int empty = above ? 1 : 0;
  s->interface_position = above ? gas->upper[0] : gas->lower[0];
  s->barotropic = gas->barotropic;
  s->gamma[empty] = s->gamma[!empty];
  s->density[empty] = s->velocity[empty] = s->pressure[empty] = 0;
}

/* Derives both sides, from two regions that touch along x. */
static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct settings *s = settings;
  const struct kith_exact_region *half[2];
  for (int k = 0; k < 2; ++k) memcpy(s->across[k], scene->region[0].velocity, sizeof s->across[k]);
  if (scene->n_regions == 1) derive_vacuum(s, scene);
  if (!kith_exact_halves(scene, half)) return;
  s->interface_position = half[0]->upper[0];
  derive_side(s, 0, half[0]);
  derive_side(s, 1, half[1]);
  s->barotropic = half[0]->barotropic && half[1]->barotropic;
  for (int k = 0; k < 2; ++k) s->only_barotropic[k] = half[k]->barotropic && !s->barotropic;
}

/* One half space and its wave; velocities are mirrored on the left: positive towards the undisturbed gas.
 * Pressures are P + base, base being the lesser s of both sides; `excess` is the own s beyond base. */
struct side {
  double gamma, density, velocity, pressure, excess, sound, stiffness, energy;
  double across[NDIM]; /* as in the settings */
  bool barotropic;
};

struct riemann {
  struct side side[2];
  bool shock[2];
  double base;                 /* the lesser stiffness of both sides */
  struct kith_exact_star star; /* its pressure is P */
};

static const double mirror[2] = {-1, 1};

/* A relative pressure step below this counts as a sound wave: the star pressure is good to some 1e-15. */
static const double weakest_shock = 1e-9;

static double jump(const struct side *s, double p) {
  const double g = s->gamma, start = s->pressure + s->excess, end = p + s->excess;
  if (p <= s->pressure && start == 0) return 0; /* cold gas does not expand */
  const double ratio = log(end / start);
  if (p <= s->pressure)
    return g > 1 ? 2 * s->sound / (g - 1) * expm1((g - 1) / (2 * g) * ratio) : s->sound * ratio;
  if (s->barotropic) return sqrt((p - s->pressure) * -expm1(-ratio / g) / s->density);
  const double a = 2 / ((g + 1) * s->density), b = (g - 1) / (g + 1) * start;
  return (p - s->pressure) * sqrt(a / (end + b));
}

/* Speed u + c of the inner edge of a rarefaction down to p, where u - 2 c / (g - 1) is kept; p = 0:
 * vacuum. */
static double rarefaction_tail(const struct side *s, double p) {
  return s->velocity + s->sound + (s->gamma + 1) / 2 * jump(s, p);
}

/* Positive if p is above the star pressure. */
static double mismatch(const struct side *side, double p) {
  return jump(&side[0], p) + jump(&side[1], p) + side[0].velocity + side[1].velocity;
}

/* Bisects for the star pressure. False if it is below 1e-260 of the given ones, which no double can serve:
 * *pressure is then above it. */
static bool star_pressure(const struct side *side, double *pressure) {
  const double closing = side[0].velocity + side[1].velocity;
  double scale = KITH_MAX(side[0].pressure, side[1].pressure);
  if (scale == 0) scale = KITH_MIN(side[0].density, side[1].density) * closing * closing;
  double lower = KITH_MAX(-600.0, log(1e-300 / scale)), upper = 600, middle; /* of ln (p / scale) */
  const bool found = mismatch(side, scale * exp(lower)) < 0;
  while (found && (middle = 0.5 * (lower + upper)) > lower && middle < upper)
    *(mismatch(side, scale * exp(middle)) < 0 ? &lower : &upper) = middle;
  *pressure = scale * exp(found ? upper : lower);
  return found;
}

static void finish_side(struct riemann *problem, int k, double p) {
  const struct side *s = &problem->side[k];
  struct kith_exact_star *star = &problem->star;
  const double g = s->gamma, start = s->pressure + s->excess, end = p + s->excess;
  const double push = end * (g + 1) + start * (g - 1);
  problem->shock[k] = end > start * (1 + weakest_shock);
  if (p > s->pressure && !s->barotropic) {
    star->density[k] = s->density * push / (end * (g - 1) + start * (g + 1));
    star->head[k] = star->tail[k] = mirror[k] * (s->velocity + sqrt(push / (2 * s->density)));
  } else if (p > s->pressure) {
    star->density[k] = s->density * pow(end / start, 1 / g);
    star->head[k] = star->tail[k] = mirror[k] * (s->velocity + (p - s->pressure) / (s->density * jump(s, p)));
  } else {
    star->density[k] = s->density * pow(end / start, 1 / g);
    star->head[k] = mirror[k] * (s->velocity + s->sound);
    star->tail[k] = mirror[k] * rarefaction_tail(s, p);
  }
}

/* Sets the star of a vacuum, to which both sides have expanded: down to `least`, which is as good as 0. */
static void finish_vacuum(struct riemann *problem, double least) {
  const struct side *side = problem->side;
  struct kith_exact_star *star = &problem->star;
  for (int k = 0; k < 2; ++k) {
    star->head[k] = mirror[k] * (side[k].velocity + side[k].sound);
    star->tail[k] = side[k].pressure > least ? mirror[k] * rarefaction_tail(&side[k], least) : star->head[k];
  }
  for (int k = 0; k < 2; ++k)
    if (side[k].density == 0) star->head[k] = star->tail[k] = star->tail[!k];
  star->velocity = (star->tail[0] + star->tail[1]) / 2;
}

static kith_status solve(struct riemann *problem) {
  const struct side *side = problem->side;
  double p = 0;
  const bool empty = side[0].density == 0 || side[1].density == 0;
  if (empty || mismatch(side, 0) >= 0 || !star_pressure(side, &p)) {
    if (side[0].stiffness != 0 || side[1].stiffness != 0)
      KITH_FAIL(BAD_INPUT,
                "exact solution riemann: there is a vacuum, and stiffened gas or a liquid would be torn");
    finish_vacuum(problem, p);
    return KITH_OK;
  }
  const double left = side[0].velocity + jump(&side[0], p), right = side[1].velocity + jump(&side[1], p);
  problem->star.velocity = (right - left) / 2;
  problem->star.pressure = p - problem->base;
  for (int k = 0; k < 2; ++k) finish_side(problem, k, p);
  return KITH_OK;
}

static bool is_barotropic(const struct settings *p, int k) {
  return p->barotropic || p->only_barotropic[k];
}

static kith_status check(const void *settings) {
  const struct settings *p = settings;
  for (int k = 0; k < 2; ++k)
    if (p->gamma[k] == 1 && !is_barotropic(p, k))
      KITH_FAIL(BAD_INPUT, "exact solution riemann: gamma[%d] is 1, which only barotropic gases have", k);
    else if (p->density[k] == 0 && p->pressure[k] != 0)
      KITH_FAIL(BAD_INPUT, "exact solution riemann: pressure[%d] is %g, must be 0 where the density is 0", k,
                p->pressure[k]);
    else if (p->density[k] > 0 && p->pressure[k] < -p->stiffness[k])
      KITH_FAIL(BAD_INPUT, "exact solution riemann: pressure[%d] is %g, must be at least -stiffness, %g", k,
                p->pressure[k], 0 - p->stiffness[k]);
    else if (is_barotropic(p, k) && p->density[k] > 0 && p->pressure[k] == -p->stiffness[k])
      KITH_FAIL(BAD_INPUT,
                "exact solution riemann: pressure[%d] is -stiffness, where barotropic gas has no density", k);
  if (p->density[0] > 0 || p->density[1] > 0) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution riemann: density[1] is 0, must be above 0 if density[0] is 0");
}

static kith_status riemann_create(void **self, const void *settings) {
  const struct settings *p = settings;
  KITH_TRY(kith_resize(self, 0, 1, sizeof(struct riemann)));
  struct riemann *problem = *self;
  problem->star.interface = p->interface_position;
  problem->base = KITH_MIN(p->stiffness[0], p->stiffness[1]);
  for (int k = 0; k < 2; ++k) {
    struct side *s = &problem->side[k];
    s->gamma = p->gamma[k], s->density = p->density[k], s->stiffness = p->stiffness[k];
    s->pressure = p->pressure[k] + problem->base, s->excess = s->stiffness - problem->base;
    s->velocity = mirror[k] * p->velocity[k];
    s->sound = s->density > 0 ? sqrt(s->gamma * (p->pressure[k] + s->stiffness) / s->density) : 0;
    s->barotropic = is_barotropic(p, k), s->energy = p->energy[k];
    memcpy(s->across, p->across[k], sizeof s->across);
  }
  const kith_status status = solve(problem);
  if (status != KITH_OK) kith_free(self);
  return status;
}

/* Energy of a side at this density and pressure. A barotropic gas has taken the work: of an isentrope, or, if
 * `shocked`, that of the mean of both pressures. */
static double energy_of(const struct side *s, double density, double pressure, double base, bool shocked) {
  if (density < DBL_MIN) return 0; /* a vacuum, or so close to one that 1 / density overflows */
  const double g = s->gamma, volume = 1 / density, end = pressure + s->stiffness,
               start = s->pressure + s->excess;
  if (!s->barotropic) return kith_exact_energy(g, density, end) + s->stiffness * volume;
  const double from = 1 / s->density, squeeze = from - volume;
  if (shocked) return s->energy + 0.5 * (pressure + s->pressure - base) * squeeze;
  const double work =
      g > 1 ? (end * volume - start * from) / (g - 1) : start * from * log(density / s->density);
  return s->energy + work - s->stiffness * squeeze;
}

/* The state of side k at this speed dx / dt. */
static void sample(const struct riemann *problem, int k, double speed, struct kith_exact_state *out) {
  const struct side *s = &problem->side[k];
  const struct kith_exact_star *star = &problem->star;
  const double xi = mirror[k] * speed, head = mirror[k] * star->head[k], tail = mirror[k] * star->tail[k];
  double density = s->density, velocity = s->velocity, pressure = s->pressure - problem->base;
  if (xi < head && xi > tail) { /* inside a rarefaction */
    const double g = s->gamma, c = 2 / (g + 1) - (g - 1) / (g + 1) * (velocity - xi) / s->sound; /* in c_K */
    const double ratio = KITH_MAX(c, 0.0); /* round-off at the edge of a vacuum */
    velocity = 2 / (g + 1) * (xi - s->sound + (g - 1) / 2 * velocity);
    const double power = g > 1 ? pow(ratio, 2 / (g - 1)) : exp((velocity - s->velocity) / s->sound);
    density *= power;
    pressure = (s->pressure + s->excess) * pow(power, g) - s->stiffness;
  } else if (xi < head) {
    density = star->density[k], pressure = star->pressure;
    velocity = density > 0 ? mirror[k] * star->velocity : xi;
  }
  *out = (struct kith_exact_state){.density = density, .pressure = pressure};
  memcpy(out->velocity, s->across, sizeof s->across);
  out->velocity[0] = mirror[k] * velocity;
  out->energy = energy_of(s, density, pressure, problem->base, xi <= tail && problem->shock[k]);
}

static void riemann_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct riemann *problem = self;
  const double d = x[0] - problem->star.interface;
  if (time > 0)
    sample(problem, d < problem->star.velocity * time ? 0 : 1, d / time, out);
  else
    sample(problem, d < 0 ? 0 : 1, d < 0 ? -INFINITY : INFINITY, out);
}

static double riemann_shock(const void *self, double time) {
  const struct riemann *problem = self;
  for (int k = 1; k >= 0; --k)
    if (problem->shock[k]) return problem->star.interface + problem->star.head[k] * time;
  return 0;
}

static struct kith_exact_star riemann_star(const void *self) {
  return ((const struct riemann *)self)->star;
}

const struct kith_exact_ops kith_exact_riemann = {
    .name = "riemann",
    .doc = "two half spaces of ideal or stiffened gas, isothermal or of Tait, or a vacuum",
    KITH_SETTINGS(params, settings),
    .derive = derive,
    .derived_from =
        "two regions of constant state that touch in a plane x = const and reach across the domain, without "
        "external forces, or of one beside a void",
    .check = check,
    .create = riemann_create,
    .state = riemann_state,
    .shock = riemann_shock,
    .star = riemann_star,
};
