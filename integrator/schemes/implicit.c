/* Scheme implicit: theta methods, solved by KINSOL of SUNDIALS.
 *
 *     y1 = y0 + dt ((1 - theta) f(y0) + theta f(y1)),   theta = 1/2 Crank-Nicolson, 1 backward Euler.
 *
 * Newton's method with GMRES; the Jacobian is never formed, its products are differences of rates. All
 * residuals of a step use the lists of its start, and refresh the values of ghosts. The solution is good when
 * the residual is within a thousandth of the tolerances (rtol, atol) at every node. */
#include <kinsol/kinsol.h>
#include <stdlib.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include "integrator/schemes/stages.h"

enum { MOST_NEWTON = 20, KRYLOV = 15, RESTARTS = 5, KINSOL_VECTORS = 8 };
static const double residual_part =
    1e-3; /* of the tolerances: the error of the solver hides behind that of the step */

struct implicit_settings {
  bool backward_euler;
  struct kith_tolerances tolerances;
};
static const struct kith_param params[] = {
    {"method", KITH_PARAM_CHOICE, "crank-nicolson", "crank-nicolson|backward-euler", "theta = 1/2 or 1",
     KITH_INTO(struct implicit_settings, backward_euler)},
    KITH_TOLERANCE_PARAMS(struct implicit_settings),
    {0}};

/* Vectors: the iterate; what does not change in a solve, y0 + dt (1 - theta) f(y0); 1 / tolerance. */
enum { ITERATE, KNOWN, WEIGHTS, VECTORS };

struct implicit {
  struct kith_stages stages;
  struct kith_vectors *vectors; /* NULL: not made yet */
  N_Vector vector[VECTORS];
  void *memory; /* of KINSOL */
  SUNLinearSolver solver;
  double dt;          /* of the step at hand */
  kith_status status; /* of the last rates */
};

static double theta(const struct kith_integrator *it) {
  return ((const struct implicit_settings *)it->settings)->backward_euler ? 1 : 0.5;
}

/* y - known - theta dt f(y). */
static int residual(N_Vector state, N_Vector out, void *integrator) {
  struct kith_integrator *it = integrator;
  struct implicit *m = it->self;
  N_VScale(1, state, m->vectors->view);
  m->status = kith_stages_rates(&m->stages, it, m->dt);
  if (m->status != KITH_OK) return -1;
  kith_stages_copy_rates(it, out);
  double factor[] = {-theta(it) * m->dt, 1, -1};
  N_Vector term[] = {out, state, m->vector[KNOWN]};
  return N_VLinearCombination(3, factor, term, out);
}

static void quiet(int code, const char *module, const char *function, char *message, void *data) {
  (void)code, (void)module, (void)function, (void)message, (void)data;
}

static void forget(struct implicit *m) {
  if (m->memory != NULL) KINFree(&m->memory);
  if (m->solver != NULL) SUNLinSolFree(m->solver);
  m->solver = NULL;
  for (int k = 0; k < VECTORS; ++k) {
    if (m->vector[k] != NULL) N_VDestroy(m->vector[k]);
    m->vector[k] = NULL;
  }
  kith_vectors_destroy(&m->vectors);
}

static bool make_solver(struct kith_integrator *it) {
  struct implicit *m = it->self;
  for (int k = 0; k < VECTORS; ++k)
    if ((m->vector[k] = kith_vector_clone(m->vectors)) == NULL) return false;
  m->solver = SUNLinSol_SPGMR(m->vector[ITERATE], SUN_PREC_NONE, KRYLOV, m->vectors->context);
  m->memory = KINCreate(m->vectors->context);
  if (m->solver == NULL || m->memory == NULL) return false;
  int bad = KINSetErrHandlerFn(m->memory, quiet, NULL) | KINSetUserData(m->memory, it);
  bad |= KINInit(m->memory, residual, m->vector[ITERATE]);
  bad |= KINSetLinearSolver(m->memory, m->solver, NULL) | SUNLinSol_SPGMRSetMaxRestarts(m->solver, RESTARTS);
  return (bad | KINSetNumMaxIters(m->memory, MOST_NEWTON) | KINSetFuncNormTol(m->memory, residual_part)) == 0;
}

/* Vectors and solvers for the nodes there are. */
static kith_status prepare(struct kith_integrator *it) {
  struct implicit *m = it->self;
  if (kith_stages_fit(m->vectors, it->nodes)) return KITH_OK;
  forget(m);
  KITH_TRY(kith_stages_vectors(&m->vectors, it->hydro));
  if (make_solver(it)) return KITH_OK;
  forget(m);
  KITH_FAIL(NO_MEMORY, "KINSOL cannot be set up");
}

/* From the state in the fields and its rates. The first guess is an explicit step. */
static kith_status solve(struct kith_integrator *it, double dt) {
  struct implicit *m = it->self;
  N_Vector *v = m->vector;
  m->dt = dt;
  m->status = KITH_OK;
  kith_stages_copy_rates(it, v[KNOWN]);
  N_VLinearSum(1, m->vectors->view, dt, v[KNOWN], v[ITERATE]);
  N_VLinearSum(1, m->vectors->view, dt * (1 - theta(it)), v[KNOWN], v[KNOWN]);
  const int flag = KINSol(m->memory, v[ITERATE], KIN_NONE, v[WEIGHTS], v[WEIGHTS]);
  if (m->status != KITH_OK) return m->status;
  if (flag == KIN_MEM_FAIL) KITH_FAIL(NO_MEMORY, "no memory for the vectors of KINSOL");
  if (flag == KIN_SUCCESS || flag == KIN_INITIAL_GUESS_OK) {
    N_VScale(1, v[ITERATE], m->vectors->view);
    return KITH_OK;
  }
  char *name = KINGetReturnFlagName(flag);
  const kith_status failed = kith_fail(KITH_DIVERGED, "the implicit step of %g does not converge: %s", dt,
                                       name != NULL ? name : "?");
  free(name);
  return kith_ranks_allreduce_status(it->nodes->ranks, failed);
}

static kith_status try_shorter(struct kith_integrator *it, double *dt) {
  struct implicit *m = it->self;
  const struct implicit_settings *settings = it->settings;
  kith_stages_weights(it, &settings->tolerances, m->vectors->view, m->vector[WEIGHTS]);
  kith_status status = solve(it, *dt);
  for (int k = 0; k < KITH_MOST_HALVINGS && status == KITH_DIVERGED; ++k) {
    KITH_TRY(kith_stages_restore(&m->stages, it));
    *dt *= 0.5;
    it->ledger.rejected_steps += 1;
    it->limiter = KITH_LIMIT_convergence, it->limiting_node = -1;
    status = solve(it, *dt);
  }
  return status;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  struct implicit *m = it->self;
  KITH_TRY(prepare(it)); /* nodes may have gone to other ranks */
  kith_stages_begin(&m->stages, it);
  KITH_TRY(try_shorter(it, dt));
  return kith_stages_rates(&m->stages, it, *dt);
}

static kith_status implicit_create(struct kith_integrator *it) {
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct implicit)));
  struct implicit *m = it->self;
  return kith_stages_init(&m->stages, it);
}

static void implicit_destroy(struct kith_integrator *it) {
  forget(it->self);
  kith_free(&it->self);
}

static size_t implicit_bytes(const struct kith_integrator *it) {
  const struct implicit *m = it->self;
  const size_t expected = kith_stages_vector_bytes(it->hydro) * (VECTORS + KINSOL_VECTORS + KRYLOV);
  return sizeof *m + (m->vectors != NULL ? m->vectors->bytes : expected);
}

const struct kith_scheme_ops kith_scheme_implicit = {
    .name = "implicit",
    .doc =
        "Crank-Nicolson or backward Euler (scheme.method) by KINSOL of SUNDIALS, "
        "Newton and GMRES without a matrix: for smooth slow flows; "
        "Courant numbers above 1; thermal energy only",
    KITH_SETTINGS(params, implicit_settings),
    .evaluations = 12,
    .incompatible =
        "energies that follow from kicks are no rate of the state, and rates are what it solves with",
    .implicit = true,
    .create = implicit_create,
    .destroy = implicit_destroy,
    .stages = true,
    .retries = true,
    .advance = advance,
    .bytes = implicit_bytes};
