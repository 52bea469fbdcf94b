/* Scheme arkode: explicit embedded Runge-Kutta steps by ERKStep of SUNDIALS.
 *
 * ERKStep works on the view: it writes the state of a stage into the fields of the nodes, where the rates are
 * made; only rates are copied, into its vectors. One step of ours is one step of ERKStep that starts from
 * nothing: after boundaries have put nodes back its history would be of other nodes, and a restart would have
 * lost it. So the length of the next step must follow from the last error alone, which is what the I
 * controller does. The rates of the first stage are those of the last step's end. */
#include <arkode/arkode_erkstep.h>
#include <ctype.h>
#include <string.h>
#include <strings.h>
#include "integrator/schemes/arkode.h"
#include "integrator/schemes/stages.h"
#include "lib/core/choices.h"

enum { ERKSTEP_VECTORS = 8 }; /* beside the rates of the stages */

struct arkode_settings {
  char table[32];
  bool adaptive;
  struct kith_tolerances tolerances;
};
static const struct kith_param params[] = {
    {"table", KITH_PARAM_NAME, "bogacki-shampine-4-2-3", "", "Runge-Kutta table (kith list table)",
     KITH_INTO(struct arkode_settings, table)},
    {"adaptive", KITH_PARAM_BOOL, "true", "", "dt by the error estimate too, unless dt is given",
     KITH_INTO(struct arkode_settings, adaptive)},
    KITH_TOLERANCE_PARAMS(struct arkode_settings),
    {0}};

struct arkode {
  struct kith_stages stages;
  struct kith_table table;
  struct kith_vectors *vectors; /* NULL: not made yet */
  void *memory;                 /* of ERKStep */
  /* Of the step at hand: ERKStep has had the rates of its start; it has made its end. */
  bool started, ended;
  long attempts;      /* of ERKStep, begun */
  double stable;      /* what the stability function said last */
  kith_status status; /* of the last rates */
};

/* ---- tables ---- */

#define AS_CHOICE(constant, word) "|" #word
static const char table_words[] = KITH_TABLE_LIST(AS_CHOICE);
#define AS_ID(constant, word) ARKODE_##constant,
static const ARKODE_ERKTableID table_ids[] = {KITH_TABLE_LIST(AS_ID)};

/* As the list has it: lower case, without ARKODE_ in front. */
static void spell(const char *name, char word[64]) {
  if (strncasecmp(name, "arkode", 6) == 0 && (name[6] == '_' || name[6] == '-')) name += 7;
  snprintf(word, 64, "%s", name);
  for (char *c = word; *c != '\0'; ++c) *c = (char)tolower((unsigned char)*c);
}

static ARKODE_ERKTableID table_id(const char *name) {
  char word[64];
  spell(name, word);
  const int index = kith_choices_index(table_words, word);
  return index < 0 ? ARKODE_ERK_NONE : table_ids[index];
}

static kith_status refuse_table(const char *name) {
  char word[64], near[64];
  spell(name, word);
  if (!kith_choices_suggest(table_words, word, near, sizeof near))
    KITH_FAIL(BAD_INPUT, "table: '%.60s' is no table of ARKODE (kith list table)", name);
  KITH_FAIL(BAD_INPUT, "table: '%.60s' is no table of ARKODE (kith list table); did you mean '%s'?", name,
            near);
}

kith_status kith_table_read(struct kith_table *table, const char *name) {
  const ARKODE_ERKTableID id = table_id(name);
  if (id == ARKODE_ERK_NONE) return refuse_table(name);
  ARKodeButcherTable t = ARKodeButcherTable_LoadERK(id);
  if (t == NULL) KITH_FAIL(NO_MEMORY, "no memory for the Runge-Kutta table %.60s", name);
  *table = (struct kith_table){.stages = t->stages, .order = t->q, .embedded = t->p, .ends = true};
  for (int k = 0; k < t->stages; ++k) table->ends = table->ends && t->b[k] == t->A[t->stages - 1][k];
  table->evaluations = table->ends ? t->stages - 1 : t->stages;
  ARKodeButcherTable_Free(t);
  return KITH_OK;
}

/* ---- what ERKStep calls ---- */

/* It begins another attempt: nothing may be left of the last one. */
static kith_status follow_attempts(struct kith_integrator *it) {
  struct arkode *a = it->self;
  long attempts = 0;
  ERKStepGetNumStepAttempts(a->memory, &attempts);
  if (attempts == a->attempts) return KITH_OK;
  a->attempts = attempts;
  return attempts > 1 ? kith_stages_again(&a->stages, it) : KITH_OK;
}

/* Those of the start are at hand; those of the end are made when ERKStep is done, and nodes may be put
 * back. */
static int rates(double time, N_Vector state, N_Vector rate, void *integrator) {
  struct kith_integrator *it = integrator;
  struct arkode *a = it->self;
  if (a->ended) return 0;
  if (a->started) {
    if (state != a->vectors->view)
      a->status = kith_fail(KITH_INTERNAL, "ERKStep requests rates of a state that is not in the fields");
    else
      a->status = follow_attempts(it);
    if (a->status == KITH_OK) a->status = kith_stages_rates(&a->stages, it, time);
    if (a->status != KITH_OK) return -1;
  }
  a->started = true;
  kith_stages_copy_rates(it, rate);
  return 0;
}

static int end_of_step(double time, N_Vector state, void *integrator) {
  (void)time, (void)state;
  struct arkode *a = ((struct kith_integrator *)integrator)->self;
  a->ended = true;
  return 0;
}

/* The time-step limit by the rates of the last stage, but no less than at the start: an attempt that fails
 * may end anywhere. ERKStep takes half of what it is told. */
static int stable_step(N_Vector state, double time, double *dt, void *integrator) {
  (void)time, (void)state;
  struct kith_integrator *it = integrator;
  struct arkode *a = it->self;
  a->stable =
      KITH_MAX(it->timestep_limit.dt, kith_package_timestep_limit(it->package, &it->kick, it->cfl).dt);
  *dt = 2 * a->stable;
  return 0;
}

static int weights_of(N_Vector state, N_Vector weights, void *integrator) {
  const struct kith_integrator *it = integrator;
  const struct arkode_settings *settings = it->settings;
  kith_stages_weights(it, &settings->tolerances, state, weights);
  return 0;
}

static void quiet(int code, const char *module, const char *function, char *message, void *data) {
  (void)code, (void)module, (void)function, (void)message, (void)data;
}

/* ---- a step ---- */

static bool is_adaptive(const struct kith_integrator *it) {
  return ((const struct arkode_settings *)it->settings)->adaptive && it->fixed_dt <= 0;
}

static void forget(struct arkode *a) {
  if (a->memory != NULL) ERKStepFree(&a->memory);
  kith_vectors_destroy(&a->vectors);
}

static int set_up(struct kith_integrator *it) {
  struct arkode *a = it->self;
  const struct arkode_settings *settings = it->settings;
  void *m = a->memory;
  double no_parameters[3];
  int bad = ERKStepSetUserData(m, it) | ERKStepSetErrHandlerFn(m, quiet, NULL);
  bad |= ERKStepSetTableNum(m, table_id(settings->table)) | ERKStepSetPostprocessStepFn(m, end_of_step);
  bad |= ERKStepSetInterpolantType(m, ARK_INTERP_LAGRANGE) | ERKStepSetInterpolantDegree(m, 0); /* unused */
  bad |= ERKStepWFtolerances(m, weights_of) | ERKStepSetStabilityFn(m, stable_step, it);
  bad |= ERKStepSetAdaptivityMethod(m, ARK_ADAPT_I, 1, 0, no_parameters);
  return bad | ERKStepSetFixedStepBounds(m, 1, 1) | ERKStepSetSafetyFactor(m, 0.9);
}

/* Vectors and ERKStep for the nodes there are. */
static kith_status prepare(struct kith_integrator *it) {
  struct arkode *a = it->self;
  if (kith_stages_fit(a->vectors, it->nodes)) return KITH_OK;
  forget(a);
  KITH_TRY(kith_stages_vectors(&a->vectors, it->hydro));
  a->memory = ERKStepCreate(rates, 0, a->vectors->view, a->vectors->context);
  if (a->memory != NULL && set_up(it) == 0) return KITH_OK;
  forget(a);
  KITH_FAIL(NO_MEMORY, "ERKStep cannot be set up");
}

/* From the state in the fields; *dt: the step that was taken. */
static kith_status evolve(struct kith_integrator *it, double *dt) {
  struct arkode *a = it->self;
  double time = 0;
  a->started = a->ended = false;
  a->attempts = 0;
  a->status = KITH_OK;
  int flag = ERKStepReInit(a->memory, rates, 0, a->vectors->view);
  if (flag == ARK_SUCCESS)
    flag = is_adaptive(it) ? ERKStepSetInitStep(a->memory, *dt) : ERKStepSetFixedStep(a->memory, *dt);
  if (flag == ARK_SUCCESS) flag = ERKStepEvolve(a->memory, *dt, a->vectors->view, &time, ARK_ONE_STEP);
  it->ledger.rejected_steps += a->attempts > 1 ? (uint64_t)(a->attempts - 1) : 0;
  if (a->status != KITH_OK) return a->status;
  if (flag == ARK_MEM_FAIL) KITH_FAIL(NO_MEMORY, "no memory for the vectors of ERKStep");
  if (flag != ARK_SUCCESS)
    return kith_ranks_allreduce_status(
        it->nodes->ranks,
        kith_fail(KITH_DIVERGED,
                  "ERKStep finds no step of the required accuracy: error %d after %ld attempts", flag,
                  a->attempts));
  if (time < *dt) it->limiter = KITH_LIMIT_accuracy, it->limiting_node = -1;
  *dt = time;
  return KITH_OK;
}

/* The length of the next step by the error of this one, unless stability limits it more: that is the
 * time-step limit of the state. */
static void look_ahead(struct kith_integrator *it) {
  const struct arkode *a = it->self;
  double next = 0;
  it->accurate_dt = 0;
  if (!is_adaptive(it)) return;
  ERKStepGetCurrentStep(a->memory, &next);
  if (next < (1 - 1e-9) * a->stable) it->accurate_dt = next; /* it rounds too */
}

/* A stage that leaves the physical range is a step that was too long. */
static kith_status try_shorter(struct kith_integrator *it, double *dt) {
  struct arkode *a = it->self;
  kith_status status = evolve(it, dt);
  for (int k = 0; k < KITH_MOST_HALVINGS && status == KITH_DIVERGED && is_adaptive(it); ++k) {
    KITH_TRY(kith_stages_restore(&a->stages, it));
    *dt *= 0.5;
    it->ledger.rejected_steps += 1;
    status = evolve(it, dt);
    it->limiter = KITH_LIMIT_accuracy, it->limiting_node = -1;
  }
  return status;
}

static kith_status advance(struct kith_integrator *it, double *dt) {
  struct arkode *a = it->self;
  KITH_TRY(prepare(it)); /* nodes may have gone to other ranks */
  kith_stages_begin(&a->stages, it);
  KITH_TRY(try_shorter(it, dt));
  look_ahead(it);
  return a->table.ends ? KITH_OK : kith_stages_rates(&a->stages, it, *dt);
}

static kith_status arkode_create(struct kith_integrator *it) {
  const struct arkode_settings *settings = it->settings;
  KITH_TRY(kith_resize(&it->self, 0, 1, sizeof(struct arkode)));
  struct arkode *a = it->self;
  KITH_TRY(kith_table_read(&a->table, settings->table));
  if (is_adaptive(it) && a->table.embedded == 0)
    KITH_FAIL(BAD_INPUT, "table: %s has no error estimate; give it scheme.adaptive=false", settings->table);
  it->evaluations = a->table.evaluations;
  return kith_stages_init(&a->stages, it);
}

static void arkode_destroy(struct kith_integrator *it) {
  forget(it->self);
  kith_free(&it->self);
}

static size_t arkode_bytes(const struct kith_integrator *it) {
  const struct arkode *a = it->self;
  const size_t expected = kith_stages_vector_bytes(it->hydro) * (size_t)(a->table.stages + ERKSTEP_VECTORS);
  return sizeof *a + (a->vectors != NULL ? a->vectors->bytes : expected);
}

const struct kith_scheme_ops kith_scheme_arkode = {
    .name = "arkode",
    KITH_SETTINGS(params, arkode_settings),
    .doc =
        "explicit Runge-Kutta by ERKStep of SUNDIALS: any of its tables (kith list table); "
        "dt by the error and the Courant number, or fixed; thermal energy only",
    .evaluations = 3,
    .incompatible =
        "energies that follow from kicks are no rate of the state, and rates are what it combines",
    .create = arkode_create,
    .destroy = arkode_destroy,
    .stages = true,
    .retries = true,
    .advance = advance,
    .bytes = arkode_bytes};
