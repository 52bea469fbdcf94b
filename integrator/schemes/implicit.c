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
static const double residual_part = 1e-3; /* of the tolerances: far below the error of the step */

struct implicit_settings {
  bool backward_euler;
  struct kith_tolerances tolerances;
};
static const struct kith_param params[] = {
    {"method", KITH_PARAM_CHOICE, "crank-nicolson", "crank-nicolson|backward-euler",
     "theta method, theta = 1/2 or 1", KITH_INTO(struct implicit_settings, backward_euler)},
    KITH_TOLERANCE_PARAMS(struct implicit_settings),
    {0}};

/* Vectors: the iterate; what does not change in a solve, y0 + dt (1 - theta) f(y0); 1 / tolerance. */
enum { ITERATE, KNOWN, WEIGHTS, VECTORS };

struct implicit {
  struct kith_stages stages; /* memory: of KINSOL */
  N_Vector vector[VECTORS];
  SUNLinearSolver solver;
  double dt; /* of the present step */
};

static double theta(const struct kith_integrator *it) {
  return ((const struct implicit_settings *)it->settings)->backward_euler ? 1 : 0.5;
}

/* Computes y - known - theta dt f(y). */
static int residual(N_Vector state, N_Vector out, void *integrator) {
  struct kith_integrator *it = integrator;
  struct implicit *m = it->self;
  N_VScale(1, state, m->stages.vectors->view);
  if (kith_stages_rates(it, m->dt) != KITH_OK) return -1;
  kith_stages_copy_rates(it, out);
  double factor[] = {-theta(it) * m->dt, 1, -1};
  N_Vector term[] = {out, state, m->vector[KNOWN]};
  return N_VLinearCombination(3, factor, term, out);
}

static void forget(struct kith_integrator *it) {
  struct implicit *m = it->self;
  if (m->stages.memory != NULL) KINFree(&m->stages.memory);
  if (m->solver != NULL && !m->stages.vectors->lacking) SUNLinSolFree(m->solver);
  m->solver = NULL;
  for (int k = 0; k < VECTORS; ++k) {
    if (m->vector[k] != NULL) N_VDestroy(m->vector[k]);
    m->vector[k] = NULL;
  }
}

static bool set_up(struct kith_integrator *it) {
  struct implicit *m = it->self;
  const struct kith_vectors *vectors = m->stages.vectors;
  for (int k = 0; k < VECTORS; ++k)
    if ((m->vector[k] = kith_vector_clone(vectors)) == NULL) return false;
  m->solver = SUNLinSol_SPGMR(m->vector[ITERATE], SUN_PREC_NONE, KRYLOV, vectors->context);
  void *k = m->stages.memory = KINCreate(vectors->context);
  if (m->solver == NULL || k == NULL) return false;
  int bad = KITH_QUIET(KINSetErrHandlerFn, k) | KINSetUserData(k, it);
  bad |= KINInit(k, residual, m->vector[ITERATE]);
  bad |= KINSetLinearSolver(k, m->solver, NULL) | SUNLinSol_SPGMRSetMaxRestarts(m->solver, RESTARTS);
  return (bad | KINSetNumMaxIters(k, MOST_NEWTON) | KINSetFuncNormTol(k, residual_part)) == 0;
}

/* Solves for the end of the step, from an explicit step as first guess. */
static kith_status solve(struct kith_integrator *it, double *dt) {
  struct implicit *m = it->self;
  struct kith_stages *s = &m->stages;
  N_Vector *v = m->vector;
  m->dt = *dt;
  s->status = KITH_OK;
  kith_stages_copy_rates(it, v[KNOWN]);
  N_VLinearSum(1, s->vectors->view, *dt, v[KNOWN], v[ITERATE]);
  N_VLinearSum(1, s->vectors->view, *dt * (1 - theta(it)), v[KNOWN], v[KNOWN]);
  const int flag = KINSol(s->memory, v[ITERATE], KIN_NONE, v[WEIGHTS], v[WEIGHTS]);
  if (s->status != KITH_OK) return s->status;
  s->vectors->lacking |= flag == KIN_MEM_FAIL || flag == KIN_LINIT_FAIL; /* either may lack memory */
  if (flag == KIN_SUCCESS || flag == KIN_INITIAL_GUESS_OK) {
    N_VScale(1, v[ITERATE], s->vectors->view);
    return KITH_OK;
  }
  char *name = KINGetReturnFlagName(flag);
  const kith_status failed =
      kith_fail(KITH_DIVERGED,
                "the implicit step of %g does not converge: %s; take a shorter scheme.dt, or larger "
                "scheme.rtol and scheme.atol",
                *dt, name != NULL ? name : "?");
  free(name);
  return kith_ranks_allreduce_status(it->nodes->ranks, failed);
}

static const struct kith_solver solver = {"KINSOL", KITH_LIMIT_convergence, set_up, forget, solve};

static kith_status advance(struct kith_integrator *it, double *dt) {
  struct implicit *m = it->self;
  const struct implicit_settings *settings = it->settings;
  KITH_TRY(kith_stages_begin(it));
  kith_stages_weights(it, &settings->tolerances, m->stages.vectors->view, m->vector[WEIGHTS]);
  KITH_TRY(kith_stages_try(it, it->fixed_dt <= 0, dt));
  KITH_TRY(kith_stages_rates(it, *dt));
  kith_through_add(&it->hydro->through, *dt * (1 - theta(it)), &m->stages.through);
  kith_through_add(&it->hydro->through, *dt * theta(it), &it->flow.rate);
  return KITH_OK;
}

static kith_status create(struct kith_integrator *it) {
  return kith_stages_create(it, sizeof(struct implicit), VECTORS + KINSOL_VECTORS + KRYLOV, &solver);
}

const struct kith_scheme_ops kith_scheme_implicit = {
    .name = "implicit",
    .doc =
        "Crank-Nicolson or backward Euler (scheme.method) by KINSOL of SUNDIALS, Newton and GMRES without a "
        "matrix: for smooth slow flows; Courant numbers above 1; thermal energy only",
    KITH_SETTINGS(params, implicit_settings),
    .evaluations = 12,
    .thermal_only = true,
    .implicit = true,
    .create = create,
    .destroy = kith_stages_forget,
    .stages = true,
    .retries = true,
    .advance = advance,
    .bytes = kith_stages_bytes};
