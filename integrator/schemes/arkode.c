/* Scheme arkode: explicit embedded Runge-Kutta steps by ERKStep of SUNDIALS.
 *
 * ERKStep works on a view of the fields: it writes the state of a stage into the fields of the nodes, from
 * which rates are computed; only rates are copied, into its vectors. One step is one step of ERKStep without
 * history: boundaries may have put nodes back, and a restart would not have the history. So the length of the
 * next step must follow from the last error alone, as with the I controller. The rates of the first stage are
 * those of the end of the last step. */
#include <arkode/arkode_erkstep.h>
#include "integrator/schemes/arkode.h"
#include "integrator/schemes/stages.h"

enum { ERKSTEP_VECTORS = 8 }; /* vectors of ERKStep besides the rates of the stages */

#define AS_ID(constant, word) ARKODE_##constant,
static const ARKODE_ERKTableID table_ids[] = {KITH_TABLE_LIST(AS_ID)};
#define AS_CHOICE(constant, word) "|" #word

struct arkode_settings {
  int table; /* index into table_ids */
  bool adaptive;
  struct kith_tolerances tolerances;
};
static const struct kith_param params[] = {
    {"table", KITH_PARAM_CHOICE, "bogacki-shampine-4-2-3", KITH_TABLE_LIST(AS_CHOICE),
     "Runge-Kutta table (kith list table)", KITH_INTO(struct arkode_settings, table)},
    {"adaptive", KITH_PARAM_BOOL, "true", "", "dt by the error estimate too, unless dt is given",
     KITH_INTO(struct arkode_settings, adaptive)},
    KITH_TOLERANCE_PARAMS(struct arkode_settings),
    {0}};

enum { MOST_STAGES = 13 };
struct table {
  int stages;
  bool estimates;  /* it has an embedded scheme, which estimates the error */
  int evaluations; /* of the rates per step: the first stage reuses those of the end of the last step */
  bool ends;       /* the state of its last stage is that of the end of the step */
  double weight[MOST_STAGES]; /* of the rates of the stages */
};

struct arkode {
  struct kith_stages stages; /* memory: of ERKStep */
  struct table table;
  /* Of the present attempt: number of stages whose rates ERKStep has, what the gas gets from outside by these
   * per time, and whether the end of the step is reached. */
  int stage;
  struct kith_through through;
  bool ended;
  long attempts; /* attempts that ERKStep has begun */
  double stable; /* step that stable_step allowed last */
};

static kith_status read_table(struct table *table, int row) {
  ARKodeButcherTable t = ARKodeButcherTable_LoadERK(table_ids[row]);
  if (t == NULL) KITH_FAIL(NO_MEMORY, "no memory for a Runge-Kutta table");
  *table = (struct table){.stages = t->stages, .estimates = t->p > 0, .ends = true};
  for (int k = 0; k < t->stages; ++k) {
    table->ends = table->ends && t->b[k] == t->A[t->stages - 1][k];
    table->weight[k] = t->b[k];
  }
  table->evaluations = table->ends ? t->stages - 1 : t->stages;
  ARKodeButcherTable_Free(t);
  return KITH_OK;
}

/* Adds what the gas gets from outside by the rates of a stage. */
static void add_stage(struct arkode *a, int stage, const struct kith_through *rate) {
  kith_through_add(&a->through, a->table.weight[stage], rate);
  a->stage = stage + 1;
}

/* Resets what depends on the attempt if ERKStep has begun another one. */
static kith_status follow_attempts(struct kith_integrator *it) {
  struct arkode *a = it->self;
  const long before = a->attempts;
  ERKStepGetNumStepAttempts(a->stages.memory, &a->attempts);
  if (a->attempts <= 1 || a->attempts == before) return KITH_OK;
  a->through = (struct kith_through){0};
  add_stage(a, 0, &a->stages.through);
  return kith_stages_again(it);
}

/* Computes the rates of a stage. Those of the start are at hand; those of the end are made in `advance`, as
 * nodes may be put back. */
static int rates(double time, N_Vector state, N_Vector rate, void *integrator) {
  struct kith_integrator *it = integrator;
  struct arkode *a = it->self;
  if (a->ended) return 0;
  if (a->stage > 0) {
    a->stages.status =
        state == a->stages.vectors->view
            ? follow_attempts(it)
            : kith_fail(KITH_INTERNAL, "ERKStep requests rates of a state that is not in the fields");
    if (a->stages.status != KITH_OK || kith_stages_rates(it, time) != KITH_OK) return -1;
  }
  add_stage(a, a->stage, &it->flow.rate);
  kith_stages_copy_rates(it, rate);
  return 0;
}

static int end_of_step(double time, N_Vector state, void *integrator) {
  (void)time, (void)state;
  struct arkode *a = ((struct kith_integrator *)integrator)->self;
  a->ended = true;
  return 0;
}

/* Sets *dt to twice the time-step limit by the rates of the last stage (ERKStep takes half of it), but no
 * less than at the start, since an attempt that fails may end anywhere. */
static int stable_step(N_Vector state, double time, double *dt, void *integrator) {
  (void)time, (void)state;
  struct kith_integrator *it = integrator;
  struct arkode *a = it->self;
  a->stable = KITH_MAX(it->timestep_limit.dt, kith_package_timestep_limit(it->package, it->cfl).dt);
  *dt = 2 * a->stable;
  return 0;
}

static int weights_of(N_Vector state, N_Vector weights, void *integrator) {
  const struct kith_integrator *it = integrator;
  const struct arkode_settings *settings = it->settings;
  kith_stages_weights(it, &settings->tolerances, state, weights);
  return 0;
}

static bool is_adaptive(const struct kith_integrator *it) {
  return ((const struct arkode_settings *)it->settings)->adaptive && it->fixed_dt <= 0;
}

static void forget(struct kith_integrator *it) {
  struct arkode *a = it->self;
  if (a->stages.memory != NULL) ERKStepFree(&a->stages.memory);
}

static bool set_up(struct kith_integrator *it) {
  struct kith_stages *s = it->self;
  const struct arkode_settings *settings = it->settings;
  double no_parameters[3];
  void *m = s->memory = ERKStepCreate(rates, 0, s->vectors->view, s->vectors->context);
  if (m == NULL) return false;
  int bad = ERKStepSetUserData(m, it) | KITH_QUIET(ERKStepSetErrHandlerFn, m);
  bad |= ERKStepSetTableNum(m, table_ids[settings->table]) | ERKStepSetPostprocessStepFn(m, end_of_step);
  bad |= ERKStepSetInterpolantType(m, ARK_INTERP_LAGRANGE) | ERKStepSetInterpolantDegree(m, 0); /* unused */
  bad |= ERKStepWFtolerances(m, weights_of) | ERKStepSetStabilityFn(m, stable_step, it);
  bad |= ERKStepSetAdaptivityMethod(m, ARK_ADAPT_I, 1, 0, no_parameters);
  return (bad | ERKStepSetFixedStepBounds(m, 1, 1) | ERKStepSetSafetyFactor(m, 0.9)) == 0;
}

/* Takes one step. If a stage leaves the physical range, the step was too long. */
static kith_status solve(struct kith_integrator *it, double *dt) {
  struct arkode *a = it->self;
  struct kith_stages *s = &a->stages;
  double time = 0;
  a->ended = false;
  a->stage = 0;
  a->through = (struct kith_through){0};
  a->attempts = 0;
  s->status = KITH_OK;
  int flag = ERKStepReInit(s->memory, rates, 0, s->vectors->view);
  if (flag == ARK_SUCCESS)
    flag = is_adaptive(it) ? ERKStepSetInitStep(s->memory, *dt) : ERKStepSetFixedStep(s->memory, *dt);
  if (flag == ARK_SUCCESS) flag = ERKStepEvolve(s->memory, *dt, s->vectors->view, &time, ARK_ONE_STEP);
  it->ledger.rejected_steps += a->attempts > 1 ? (uint64_t)(a->attempts - 1) : 0;
  if (s->status != KITH_OK) return s->status;
  s->vectors->lacking |= flag == ARK_MEM_FAIL;
  if (flag != ARK_SUCCESS)
    return kith_ranks_allreduce_status(
        it->nodes->ranks,
        kith_fail(KITH_DIVERGED,
                  "ERKStep finds no step of the required accuracy: error %d after %ld attempts", flag,
                  a->attempts));
  kith_through_add(&it->hydro->through, time, &a->through);
  if (time < *dt) it->limiter = KITH_LIMIT_accuracy, it->limiting_node = -1;
  *dt = time;
  return KITH_OK;
}

static const struct kith_solver solver = {"ERKStep", KITH_LIMIT_accuracy, set_up, forget, solve};

/* Sets it->accurate_dt to the next step by the error of this one, unless stability limits it more: that is
 * the time-step limit of the state. */
static void set_accurate_dt(struct kith_integrator *it) {
  struct arkode *a = it->self;
  double next = 0;
  it->accurate_dt = 0;
  if (!is_adaptive(it)) return;
  ERKStepGetCurrentStep(a->stages.memory, &next);
  if (next < (1 - 1e-9) * a->stable) it->accurate_dt = next; /* ERKStep rounds, too */
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  struct arkode *a = it->self;
  KITH_TRY(kith_stages_begin(it));
  KITH_TRY(kith_stages_try(it, is_adaptive(it), dt));
  set_accurate_dt(it);
  return a->table.ends ? KITH_OK : kith_stages_rates(it, *dt);
}

static kith_status create(struct kith_integrator *it) {
  const struct arkode_settings *settings = it->settings;
  struct table table;
  KITH_TRY(read_table(&table, settings->table));
  if (is_adaptive(it) && !table.estimates)
    KITH_FAIL(BAD_INPUT, "table: it has no error estimate; give it scheme.adaptive=false");
  KITH_TRY(kith_stages_create(it, sizeof(struct arkode), table.stages + ERKSTEP_VECTORS, &solver));
  ((struct arkode *)it->self)->table = table;
  it->evaluations = table.evaluations;
  return KITH_OK;
}

const struct kith_scheme_ops kith_scheme_arkode = {
    .name = "arkode",
    KITH_SETTINGS(params, arkode_settings),
    .doc =
        "explicit Runge-Kutta by ERKStep of SUNDIALS: any of its tables (kith list table); "
        "dt by the error and the Courant number, or fixed; thermal energy only",
    .evaluations = 3,
    .thermal_only = true,
    .create = create,
    .destroy = kith_stages_forget,
    .stages = true,
    .retries = true,
    .advance = advance,
    .bytes = kith_stages_bytes};
