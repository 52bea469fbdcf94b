/* sedov: energy E is released at time 0 on a plane, a line or a point (NDIM = j = 1, 2, 3) of a uniform gas.
 * L. I. Sedov, Similarity and Dimensional Methods in Mechanics, chapter IV; J. Kamm and F. Timmes,
 * LA-UR-07-2849.
 *
 *   R(t) = (E t^2 / (alpha rho0))^(1/(j+2)),  U = 2 R / ((j + 2) t),  x = r / R
 *   velocity = U x V(x),  rho = rho0 g(x),  P = rho0 U^2 h(x);  at the shock V = 2/(gamma+1), g =
 * (gamma+1)/(gamma-1)
 *
 * Mass, momentum and the energy integral (no energy crosses a surface of constant x) leave, with w = gamma V
 * - 1,
 *
 *   d ln w / d ln x = gamma V ((j+2) - V (2 + j (gamma-1))) / (gamma (gamma-1) V^2 - 2 (1-V) w)
 *   d ln g / d ln x = (dV / d ln x + j V) / (1 - V)
 *   h = g x^2 V^2 (1-V) (gamma-1) / (2 w)
 *
 * smooth down to the center, where w and g become powers of x. They are integrated inwards once (gsl_odeiv2),
 * with alpha = (2/(j+2))^2 S_j int (g x^2 V^2 / 2 + h / (gamma-1)) x^(j-1) dx beside them (S_j = 2, 2 pi, 4
 * pi: E counts both sides of a plane), and tabulated in ln x, densely at the shock; state() interpolates with
 * cubics.
 *
 * Limits: the shock is taken as strong: the ambient pressure is returned ahead of it but neglected in the
 * solution. Only the standard case, where gas fills the sphere: gamma < 7 in 3-D, any gamma in 1-D and 2-D.
 * Density falls to 0 at the center and energy diverges there, in 3-D so fast that its L1 norm does: g is
 * floored at 1e-100 and x at e^-30 to keep them finite. Reads gamma[0] > 1, density[0] > 0, pressure[0] >= 0,
 * blast_energy > 0, center. */
#include "validation/exact_parameters.h"
#include "lib/core/vec.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#include <math.h>

enum { ROWS = 4096 };            /* intervals of the table */
static const double depth = 30;  /* the table spans -depth <= ln x <= 0 */
static const double thin = -230; /* ln of the floor of g */

/* At ln x = -depth (k / ROWS)^2: [0] ln w, [1] ln g, and their slopes in ln x. */
struct row {
  double value[2], slope[2];
};

struct sedov {
  double gamma, density, pressure, radius1; /* radius1: R at time 1 */
  double center[NDIM];
  struct row row[ROWS + 1];
};

static double row_place(int k) {
  return -depth * ((double)k / ROWS) * ((double)k / ROWS);
}

/* h at ln x = y. From logarithms: near the center g x^2 / w is a number when its parts are not. */
static double similarity_pressure(double gamma, double y, double ln_w, double ln_g) {
  const double v = (1 + exp(ln_w)) / gamma;
  return exp(ln_g + 2 * y - ln_w) * v * v * (1 - v) * (gamma - 1) / 2;
}

/* q = ln w, ln g, energy integral. */
static int slopes(double y, const double *q, double *dq, void *context) {
  const double gamma = *(const double *)context, j = NDIM;
  const double x = exp(y), w = exp(q[0]), g = exp(q[1]), v = (1 + w) / gamma;
  dq[0] = gamma * v * (j + 2 - v * (2 + j * (gamma - 1))) / (gamma * (gamma - 1) * v * v - 2 * (1 - v) * w);
  dq[1] = (w * dq[0] / gamma + j * v) / (1 - v);
  const double thermal = similarity_pressure(gamma, y, q[0], q[1]) / (gamma - 1);
  dq[2] = (g * x * x * v * v / 2 + thermal) * kith_pow_dim(x);
  return GSL_SUCCESS;
}

static kith_status fill_table(struct sedov *sedov, gsl_odeiv2_driver *driver, double *energy) {
  double gamma = sedov->gamma, y = 0;
  double q[3] = {log((gamma - 1) / (gamma + 1)), log((gamma + 1) / (gamma - 1)), 0};
  for (int k = 0; k <= ROWS; ++k) {
    const int error = k == 0 ? GSL_SUCCESS : gsl_odeiv2_driver_apply(driver, &y, row_place(k), q);
    if (error != GSL_SUCCESS)
      KITH_FAIL(DIVERGED, "exact solution sedov: gamma[0] %g, at ln x = %g: %s", gamma, y,
                gsl_strerror(error));
    double dq[3];
    slopes(y, q, dq, &gamma);
    for (int c = 0; c < 2; ++c) sedov->row[k].value[c] = q[c], sedov->row[k].slope[c] = dq[c];
  }
  *energy = -q[2];
  return KITH_OK;
}

static kith_status integrate(struct sedov *sedov, double *energy) {
  gsl_odeiv2_system system = {slopes, NULL, 3, &sedov->gamma};
  gsl_odeiv2_driver *driver =
      gsl_odeiv2_driver_alloc_y_new(&system, gsl_odeiv2_step_rk8pd, -1e-6, 1e-13, 1e-13);
  if (driver == NULL) KITH_FAIL(NO_MEMORY, "exact solution sedov: no memory for the integrator");
  const kith_status status = fill_table(sedov, driver, energy);
  gsl_odeiv2_driver_free(driver);
  return status;
}

static kith_status check(const struct kith_exact_parameters *p) {
  const char *const member = "sedov";
  KITH_TRY(kith_exact_require(p->gamma[0] > 1, member, "gamma[0]", p->gamma[0], "above 1"));
  KITH_TRY(
      kith_exact_require(NDIM < 3 || p->gamma[0] < 7, member, "gamma[0]", p->gamma[0], "below 7 in 3-D"));
  KITH_TRY(kith_exact_require(p->density[0] > 0, member, "density[0]", p->density[0], "above 0"));
  KITH_TRY(kith_exact_require(p->pressure[0] >= 0, member, "pressure[0]", p->pressure[0], "at least 0"));
  KITH_TRY(kith_exact_require(p->blast_energy > 0, member, "blast_energy", p->blast_energy, "above 0"));
  for (int a = 0; a < NDIM; ++a) KITH_TRY(kith_exact_require(true, member, "center", p->center[a], "finite"));
  return KITH_OK;
}

static kith_status sedov_create(void **self, const struct kith_exact_parameters *p) {
  KITH_TRY(check(p));
  gsl_set_error_handler_off();
  struct sedov *sedov = NULL;
  KITH_TRY(kith_resize(&sedov, 0, 1, sizeof *sedov));
  sedov->gamma = p->gamma[0], sedov->density = p->density[0], sedov->pressure = p->pressure[0];
  for (int a = 0; a < NDIM; ++a) sedov->center[a] = p->center[a];
  double energy = 0;
  const kith_status status = integrate(sedov, &energy);
  if (status != KITH_OK) {
    kith_free(&sedov);
    return status;
  }
  const double sphere = NDIM * kith_ball(), j = NDIM;
  const double alpha = 4 / ((j + 2) * (j + 2)) * sphere * energy;
  sedov->radius1 = pow(p->blast_energy / (alpha * p->density[0]), 1 / (j + 2));
  *self = sedov;
  return KITH_OK;
}

/* Cubic through the values and slopes at two rows of the table. */
static double cubic(const struct row *front, const struct row *back, int c, double s, double length) {
  const double rise = front->value[c] - back->value[c];
  const double a = back->slope[c] * length - rise, b = rise - front->slope[c] * length;
  return back->value[c] + s * (rise + (1 - s) * (a * (1 - s) + b * s));
}

/* ln w and ln g at ln x = y in [-depth, 0]. */
static void look_up(const struct sedov *sedov, double y, double *ln_w, double *ln_g) {
  const int k = KITH_MIN((int)(ROWS * sqrt(-y / depth)), ROWS - 1);
  const double front = row_place(k), back = row_place(k + 1);
  const double s = (y - back) / (front - back);
  *ln_w = cubic(&sedov->row[k], &sedov->row[k + 1], 0, s, front - back);
  *ln_g = cubic(&sedov->row[k], &sedov->row[k + 1], 1, s, front - back);
}

static double sedov_shock(const void *self, double time) {
  return ((const struct sedov *)self)->radius1 * pow(time, 2.0 / (NDIM + 2));
}

static const double *sedov_center(const void *self) {
  return ((const struct sedov *)self)->center;
}

static void sedov_state(const void *self, const double *x, double time, struct kith_exact_state *out) {
  const struct sedov *sedov = self;
  const double r = sqrt(kith_distance2(x, sedov->center)), shock = sedov_shock(self, time);
  *out = (struct kith_exact_state){.density = sedov->density, .pressure = sedov->pressure};
  if (r < shock) {
    const double y = KITH_MAX(log(r / shock), -depth), speed = 2 * shock / ((NDIM + 2) * time);
    double ln_w, ln_g;
    look_up(sedov, y, &ln_w, &ln_g);
    const double v = (1 + exp(ln_w)) / sedov->gamma;
    out->density = sedov->density * exp(KITH_MAX(ln_g, thin));
    out->pressure = sedov->density * speed * speed * similarity_pressure(sedov->gamma, y, ln_w, ln_g);
    for (int a = 0; a < NDIM; ++a) out->velocity[a] = speed * v * (x[a] - sedov->center[a]) / shock;
  }
  out->energy = kith_exact_energy(sedov->gamma, out->density, out->pressure);
}

const struct kith_exact_ops kith_exact_sedov = {
    .name = "sedov",
    .doc = "point explosion in a uniform gas, on a plane, a line or a point",
    .create = sedov_create,
    .destroy = kith_exact_destroy,
    .state = sedov_state,
    .shock = sedov_shock,
    .center = sedov_center,
};
