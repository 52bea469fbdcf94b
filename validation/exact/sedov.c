/* sedov: energy E is released on a plane, a line or a point (NDIM = j = 1, 2, 3) of a gas of
 * density D r^-omega. L. I. Sedov, Similarity and Dimensional Methods in Mechanics, chapter IV; J. Kamm and
 * F. Timmes, LA-UR-07-2849.
 *
 *   R(t) = (E t^2 / (alpha D))^(1/n),  n = j + 2 - omega,  U = 2 R / (n t),  x = r / R,  t from the release
 *   velocity = U x V(x),  rho = D R^-omega g(x),  P = D R^-omega U^2 h(x);
 *   at the shock  V = 2/(gamma+1),  g = (gamma+1)/(gamma-1)
 *
 * Mass, momentum and the energy integral (no energy crosses a surface of constant x) leave, with
 * w = gamma V - 1,
 *
 *   d ln w / d ln x = gamma V (n - V (2 + j (gamma-1))) / (gamma (gamma-1) V^2 - 2 (1-V) w)
 *   d ln g / d ln x = (dV / d ln x + j V - omega) / (1 - V)
 *   h = g x^2 V^2 (1-V) (gamma-1) / (2 w)
 *
 * Three cases, by how n compares with (2 + j (gamma-1)) V at the shock:
 *   standard  more:  gas fills the sphere; w and g become powers of x at the center. Tabulated in ln x.
 *   singular  equal: V is the same everywhere, g and h are powers of x.
 *   vacuum    less:  V rises to 1 at some x_v, inside of which there is nothing. Integrated along the path of
 *                    ln x and z = -ln(1-V), which is smooth up to there, and tabulated in ln(ln x - ln x_v),
 *                    of which ln g and z are straight lines near the edge.
 *
 * They are integrated inwards once, with alpha = (2/n)^2 S_j int (g x^2 V^2 / 2 + h / (gamma-1)) x^(j-1) dx
 * beside them (S_j = 2, 2 pi, 4 pi: E counts both sides of a plane); state() interpolates with cubics.
 *
 * The ambient pressure is returned ahead of the shock but neglected in the solution. omega < j, so that mass
 * is finite. At the center energy diverges, in 3-D so fast that its L1 norm does: g is floored at 1e-100 and
 * x at e^-30; so is r of the undisturbed density, at 1e-9. */
#include "lib/core/vec.h"
#include "validation/exact/exact_parameters.h"

#include <arkode/arkode_erkstep.h>
#include <nvector/nvector_serial.h>
#include "lib/comm/vector.h"

struct settings {
  struct kith_exact_gas gas;
  double blast_energy, omega, start;
};
static const struct kith_param params[] = {
    KITH_EXACT_GAMMA,
    KITH_EXACT_DENSITY("D: undisturbed, at r = 1"),
    KITH_EXACT_PRESSURE("[0, inf)", "ahead of the shock"),
    {"blast_energy", KITH_PARAM_NUMBER, NULL, "(0, inf)", "energy E, on all sides of the center",
     KITH_INTO(struct settings, blast_energy)},
    {"omega", KITH_PARAM_NUMBER, "0", "[0, 3)",
     "the undisturbed density falls as r^-omega; below the dimension", KITH_INTO(struct settings, omega)},
    {"start", KITH_PARAM_NUMBER, "0", "[0, inf)", "when the energy is released",
     KITH_INTO(struct settings, start)},
    KITH_EXACT_CENTER,
    {0}};

/* Derives energy, start and center from the only deposit. A mirror through the center doubles the energy. */
static void derive(void *settings, const struct kith_exact_scene *scene) {
  struct settings *s = settings;
  kith_exact_derive_gas(settings, scene);
  if (scene->n_deposits != 1) return;
  s->blast_energy = scene->deposit_energy, s->start = scene->deposit_time;
  for (int a = 0; a < NDIM; ++a) {
    const double lower = scene->lower[a], upper = scene->upper[a], close = 1e-12 * (upper - lower);
    s->gas.center[a] = scene->deposit_center[a];
    if (scene->axis[a].mirror[0] && fabs(s->gas.center[a] - lower) <= close) s->blast_energy *= 2;
    if (scene->axis[a].mirror[1] && fabs(s->gas.center[a] - upper) <= close) s->blast_energy *= 2;
  }
}

enum { ROWS = 4096 };            /* intervals of the table */
static const double depth = 30;  /* the table spans -depth <= ln x <= 0 */
static const double thin = -230; /* ln of the floor of g */
/* vacuum: 1 - V = e^-19 at the end of the table; ln x_v is known to its square */
static const double edge_z = 19;
static const double least_r = 1e-9;

enum kind { STANDARD, SINGULAR, VACUUM };

/* A row of the table at coordinate `at`. [0]: ln w, or z in a vacuum; [1]: ln g; slopes by the coordinate. */
struct row {
  double at, value[2], slope[2];
};

struct sedov {
  struct kith_exact_gas gas;
  enum kind kind;
  double omega, n, start, radius1; /* radius1: R a unit of time after the start */
  double ln_void;                  /* vacuum: ln x_v */
  int rows;                        /* intervals in use */
  struct row row[ROWS + 1];
};

/* h at ln x = y, by logarithms: near the center g x^2 / w is a number when its parts are not. */
static double similarity_pressure(double gamma, double y, double v, double ln_w, double ln_g) {
  return exp(ln_g + 2 * y - ln_w) * v * v * (1 - v) * (gamma - 1) / 2;
}

/* dV / d ln x is w times this. */
static double rise(const struct sedov *s, double v, double w) {
  const double gamma = s->gas.gamma;
  if (s->kind == SINGULAR) return 0; /* rounding would grow */
  return v * (s->n - v * (2 + NDIM * (gamma - 1))) / (gamma * (gamma - 1) * v * v - 2 * (1 - v) * w);
}

/* d(energy integral) / d ln x. */
static double energy_density(const struct sedov *s, double y, double v, double ln_w, double ln_g) {
  const double x = exp(y), thermal = similarity_pressure(s->gas.gamma, y, v, ln_w, ln_g) / (s->gas.gamma - 1);
  return (exp(ln_g) * x * x * v * v / 2 + thermal) * kith_pow_dim(x);
}

/* Slopes by ln x of q: ln w, ln g, energy integral. */
static void slopes(double y, const double *q, double *dq, const struct sedov *s) {
  const double w = exp(q[0]), v = (1 + w) / s->gas.gamma, dv = w * rise(s, v, w);
  dq[0] = s->gas.gamma * rise(s, v, w);
  dq[1] = (dv + NDIM * v - s->omega) / (1 - v);
  dq[2] = energy_density(s, y, v, q[0], q[1]);
}

/* Slopes of q (ln x, ln g, energy integral, z) by the length of a path in ln x and z = -ln(1 - V). Near the
 * singular case x runs while V stands, near the edge V runs while x stands. */
static void slopes_of_void(const double *q, double *dq, const struct sedov *s) {
  const double left = exp(-q[3]), v = 1 - left, w = s->gas.gamma * v - 1, dv = w * rise(s, v, w);
  dq[0] = -left / (left - dv); /* dv < 0: x falls as V rises */
  dq[3] = -dv / (left - dv);
  dq[1] = -(dv + NDIM * v - s->omega) / (left - dv);
  dq[2] = energy_density(s, q[0], v, log(w), q[1]) * dq[0];
}

static int rates(double at, N_Vector state, N_Vector rate, void *context) {
  const struct sedov *s = context;
  const double *q = N_VGetArrayPointer(state);
  double *dq = N_VGetArrayPointer(rate);
  if (s->kind == VACUUM)
    slopes_of_void(q, dq, s);
  else
    slopes(at, q, dq, s);
  return 0;
}

/* An integration by ERKStep of SUNDIALS: the numbers of `state` at `at`. */
struct path {
  SUNContext context;
  N_Vector state;
  void *solver;
  double at;
};

static kith_status advance(struct path *path, const struct sedov *s, double to) {
  if (to == path->at) return KITH_OK;
  int flag = ERKStepSetStopTime(path->solver, to);
  if (flag == ARK_SUCCESS) flag = ERKStepEvolve(path->solver, to, path->state, &path->at, ARK_NORMAL);
  if (flag >= ARK_SUCCESS) return KITH_OK;
  KITH_FAIL(DIVERGED, "exact solution sedov: gamma %g, omega %g, at %g: error %d of ERKStep", s->gas.gamma,
            s->omega, path->at, flag);
}

static kith_status fill_table(struct sedov *s, struct path *path, double *energy) {
  const double *q = N_VGetArrayPointer(path->state);
  for (int k = 0; k <= ROWS; ++k) {
    const double y = -depth * ((double)k / ROWS) * ((double)k / ROWS);
    double dq[3];
    KITH_TRY(advance(path, s, y));
    slopes(y, q, dq, s);
    s->row[k] = (struct row){y, {q[0], q[1]}, {dq[0], dq[1]}};
  }
  s->rows = ROWS;
  *energy = -q[2];
  return KITH_OK;
}

/* Fills the table of a vacuum: rows are first at ln x, then, when the edge is known, at ln(ln x - ln x_v). */
static kith_status fill_void(struct sedov *s, struct path *path, double *energy) {
  const double *q = N_VGetArrayPointer(path->state);
  double dq[4];
  s->rows = -1;
  for (int k = 0; k <= ROWS && q[3] < edge_z; ++k) {
    KITH_TRY(advance(path, s, (depth + edge_z) * k / ROWS));
    slopes_of_void(q, dq, s);
    s->row[k] = (struct row){q[0], {q[3], q[1]}, {dq[3] / dq[0], dq[1] / dq[0]}};
    s->rows = k;
  }
  if (s->rows < 1)
    KITH_FAIL(BAD_INPUT, "exact solution sedov: gamma is %.12g, too close to 1 for the vacuum of omega %.12g",
              s->gas.gamma, s->omega);
  KITH_TRY(advance(path, s, path->at + edge_z));
  s->ln_void = q[0];
  *energy = -q[2];
  for (int k = 0; k <= s->rows; ++k) {
    const double off = s->row[k].at - s->ln_void;
    s->row[k].at = log(off);
    for (int c = 0; c < 2; ++c) s->row[k].slope[c] *= off;
  }
  return KITH_OK;
}

static kith_status integrate(struct sedov *s, double *energy) {
  const double jump = log((s->gas.gamma + 1) / (s->gas.gamma - 1)); /* 1 - V = exp(-jump) at the shock */
  double standard[3] = {-jump, jump, 0}, vacuum[4] = {0, jump, 0, jump};
  const bool empty = s->kind == VACUUM;
  struct path path = {.at = 0};
  kith_status status = KITH_NO_MEMORY;
  if (kith_sundials_create(&path.context)) {
    path.state = N_VMake_Serial(empty ? 4 : 3, empty ? vacuum : standard, path.context);
    path.solver = path.state == NULL ? NULL : ERKStepCreate(rates, 0, path.state, path.context);
  }
  if (path.solver != NULL &&
      (ERKStepSetUserData(path.solver, s) | KITH_QUIET(ERKStepSetErrHandlerFn, path.solver) |
       ERKStepSetOrder(path.solver, 8) | ERKStepSStolerances(path.solver, 1e-13, 1e-13) |
       ERKStepSetMaxNumSteps(path.solver, -1)) == 0)
    status = (empty ? fill_void : fill_table)(s, &path, energy);
  else
    kith_fail(status, "exact solution sedov: no memory for the integrator");
  if (path.solver != NULL) ERKStepFree(&path.solver);
  if (path.state != NULL) N_VDestroy(path.state);
  if (path.context != NULL) SUNContext_Free(&path.context);
  return status;
}

static kith_status check(const void *settings) {
  const struct settings *p = settings;
  if (p->omega < NDIM) return KITH_OK;
  KITH_FAIL(BAD_INPUT, "exact solution sedov: omega is %g, must be at least 0 and below the dimension",
            p->omega);
}

static kith_status sedov_create(void **self, const void *settings) {
  const struct settings *p = settings;
  double energy = 0;
  KITH_TRY(kith_resize(self, 0, 1, sizeof(struct sedov)));
  struct sedov *sedov = *self;
  const double gamma = p->gas.gamma, n = NDIM + 2 - p->omega;
  const double singular_n = 2 * (2 + NDIM * (gamma - 1)) / (gamma + 1); /* n of the singular case */
  sedov->gas = p->gas, sedov->omega = p->omega, sedov->n = n, sedov->start = p->start;
  sedov->kind = fabs(n - singular_n) < 1e-9 * n ? SINGULAR : n > singular_n ? STANDARD : VACUUM;
  const kith_status status = integrate(sedov, &energy);
  const double alpha = 4 / (n * n) * NDIM * kith_ball() * energy;
  sedov->radius1 = pow(p->blast_energy / (alpha * p->gas.density), 1 / n);
  if (status != KITH_OK) kith_free(self);
  return status;
}

/* Interpolates by cubics through values and slopes; beyond the end along its tangent. Coordinates descend. */
static void look_up(const struct sedov *sedov, double at, double value[2]) {
  int low = 0, high = sedov->rows; /* row[low].at >= at > row[high].at */
  const struct row *last = &sedov->row[sedov->rows];
  while (at > last->at && high - low > 1) {
    const int middle = (low + high) / 2;
    *(sedov->row[middle].at >= at ? &low : &high) = middle;
  }
  const struct row *front = &sedov->row[low], *back = &sedov->row[high];
  const double length = front->at - back->at, s = (at - back->at) / length;
  for (int c = 0; c < 2; ++c) {
    const double rise = front->value[c] - back->value[c];
    const double a = back->slope[c] * length - rise, b = rise - front->slope[c] * length;
    value[c] = at > last->at ? back->value[c] + s * (rise + (1 - s) * (a * (1 - s) + b * s))
                             : last->value[c] + (at - last->at) * last->slope[c];
  }
}

/* Finds V, ln w and ln g at ln x = y <= 0; false: there is no gas. */
static bool similarity(const struct sedov *s, double y, double *v, double *ln_w, double *ln_g) {
  double value[2];
  if (s->kind == VACUUM) {
    const double off = y - s->ln_void;
    if (off <= 0) return false;
    look_up(s, log(off), value);
    *v = -expm1(-value[0]);
    *ln_w = log(s->gas.gamma * *v - 1);
  } else {
    look_up(s, KITH_MAX(y, -depth), value);
    *v = (1 + exp(value[0])) / s->gas.gamma;
    *ln_w = value[0];
  }
  *ln_g = value[1];
  return true;
}

static double sedov_shock(const void *self, double time) {
  const struct sedov *sedov = self;
  return sedov->radius1 * pow(fmax(0, time - sedov->start), 2 / sedov->n);
}

static void behind(const struct sedov *s, const double *offset, double r, double shock, double time,
                   struct kith_exact_state *out) {
  const double y = KITH_MAX(log(r / shock), -depth), speed = 2 * shock / (s->n * (time - s->start));
  const double density = s->gas.density * pow(shock, -s->omega);
  double v, ln_w, ln_g;
  *out = (struct kith_exact_state){0};
  if (!similarity(s, y, &v, &ln_w, &ln_g)) return;
  out->density = density * exp(KITH_MAX(ln_g, thin));
  out->pressure = density * speed * speed * similarity_pressure(s->gas.gamma, y, v, ln_w, ln_g);
  for (int a = 0; a < NDIM; ++a) out->velocity[a] = speed * v * offset[a] / shock;
}

static void sedov_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct sedov *sedov = self;
  const struct kith_exact_gas *gas = &sedov->gas;
  double d[3];
  kith_exact_offset(gas, x, time, d);
  const double r = kith_norm(d), shock = sedov_shock(self, time);
  const double crowding = sedov->omega > 0 ? pow(KITH_MAX(r, least_r), -sedov->omega) : 1;
  *out = (struct kith_exact_state){.density = gas->density * crowding, .pressure = gas->pressure};
  if (r < shock) behind(sedov, d, r, shock, time, out);
  out->energy = kith_exact_energy(gas->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_sedov = {
    .name = "sedov",
    .doc = "point explosion on a plane, a line or a point, in gas that is uniform or falls as a power of r",
    KITH_SETTINGS(params, settings),
    .derive = derive,
    .check = check,
    .create = sedov_create,
    .state = sedov_state,
    .shock = sedov_shock,
    .radial = true,
};
