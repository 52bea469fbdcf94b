#include "app/plan.h"

#include <math.h>
#include <omp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "app/forms.h"
#include "app/pilot.h"
#include "app/plan_ranks.h"
#include "app/text.h"

struct plan {
  struct kith_scene *scene;
  struct kith_profile *profile;
  struct kith_model *model;
  double full_dt; /* the vote of the first rates, without the caution of the first step */
  struct kith_times times;
  double step, lists; /* seconds of a step of the mean length, and how often it makes lists */
};

/* ---- text ---- */

/* "  label         text". A label "" goes on with the one before. */
__attribute__((format(printf, 2, 3))) static void line(const char *label, const char *format, ...) {
  char text[2048], indented[32];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  snprintf(indented, sizeof indented, "  %s", label);
  kith_text_wrapped(stdout, 16, indented, text);
}

/* Adds to a text, "a, b, c". */
__attribute__((format(printf, 4, 5))) static void add(char *text, size_t size, const char *between,
                                                      const char *format, ...) {
  size_t used = strlen(text);
  va_list arguments;
  if (used > 0) used += (size_t)snprintf(text + used, size - used, "%s", between);
  if (used >= size) return;
  va_start(arguments, format);
  vsnprintf(text + used, size - used, format, arguments);
  va_end(arguments);
}

/* ---- what there will be ---- */

static const char *side_name(const struct kith_boundary_ops *side) {
  return side != NULL ? side->name : "open";
}

static void show_domain(const struct plan *plan) {
  const struct kith_scene *scene = plan->scene;
  for (int a = 0; a < NDIM; ++a) {
    const struct kith_boundary_ops *lower = scene->boundary[a].lower, *upper = scene->boundary[a].upper;
    const bool same = lower == upper;
    line(a == 0 ? "domain" : "", "%c in [%.6g, %.6g], %s%s%s", "xyz"[a], scene -> domain.lower[a],
         scene->domain.upper[a], side_name(lower), same ? "" : " below, ", same ? "" : side_name(upper));
  }
}

static void show_forces(const struct plan *plan) {
  const struct kith_body *body = &plan->scene->body;
  char text[256] = "";
  for (int a = 0; a < NDIM; ++a) {
    const double u = plan->scene->boundary[a].velocity;
    if (body->gravity[a] != 0)
      add(text, sizeof text, "; ", "gravity %.6g along %c", body->gravity[a], "xyz"[a]);
    if (u != 0) add(text, sizeof text, "; ", "the piston goes with %.6g along %c", u, "xyz"[a]);
  }
  if (body->mass > 0)
    add(text, sizeof text, "; ", "the pull of a point, G M = %.6g, softening %.6g", body->mass,
        body->softening);
  if (text[0] != '\0') line("forces", "%s", text);
}

static void show_materials(const struct plan *plan) {
  const struct kith_nodes *nodes = plan->model->nodes;
  for (int l = 0; l < nodes->n_lists; ++l) {
    const struct kith_material *m = &plan->scene->material[l];
    char eos[128];
    snprintf(eos, sizeof eos, "%s", m->eos->name);
    if (strstr(m->eos->doc, "gamma") != NULL) add(eos, sizeof eos, ", ", "gamma %.6g", m->parameters.gamma);
    if (strstr(m->eos->doc, "sound_speed") != NULL)
      add(eos, sizeof eos, ", ", "sound speed %.6g", m->parameters.sound_speed);
    if (strstr(m->eos->doc, "stiffness") != NULL)
      add(eos, sizeof eos, ", ", "stiffness %.6g", m->parameters.stiffness);
    line(l == 0 ? "materials" : "", "%-12s %9d nodes; %s", nodes->lists[l].name, nodes->lists[l].count, eos);
  }
  for (int b = 0; b < plan->model->boundaries.n; ++b) {
    const struct kith_boundary *boundary = plan->model->boundaries.boundary[b];
    const struct kith_nodes *held =
        boundary->ops == &kith_boundary_constant ? kith_constant_nodes(boundary) : NULL;
    if (held != NULL) line("", "%-12s %9d nodes; boundary constant", "frozen", held->n_internal);
  }
}

static void show_regions(const struct plan *plan) {
#define WORD(name, word, doc) #word,
  static const char *const lattice[] = {KITH_LATTICE_LIST(WORD)};
#undef WORD
  const struct kith_scene *scene = plan->scene;
  for (int k = 0; k < scene->n_regions; ++k) {
    const struct kith_region *r = &scene->region[k];
    char spacing[64];
    if (r->spacing > 0)
      snprintf(spacing, sizeof spacing, "spacing %.6g", r->spacing);
    else
      snprintf(spacing, sizeof spacing, "%s",
               scene->arrangement == KITH_EQUAL_MASS ? "equal masses" : "equal spacing");
    char more[64] = "";
    if (r->jitter > 0) snprintf(more, sizeof more, ", jitter %.3g", r->jitter);
    line(k == 0 ? "regions" : "", "%-12s %s, %s%s%s", scene->material_name[r->material], lattice[r->lattice],
         spacing, more,
         r->barrier  ? ", barrier"
         : r->frozen ? ", frozen"
                     : "");
  }
  line("", "%.6g nodes per unit length where it is densest", scene->resolution);
}

/* ---- connectivity ---- */

static bool asks(const struct kith_requirements *need, int what) {
  const bool flag[] = {need->rows, need->pairs, need->ghost_rows, need->overlap, need->intersection};
  return flag[what];
}

/* "lifecycle (why), sph (why)" */
static void askers(const struct plan *plan, int what, char *text, size_t size) {
  struct kith_demand demand[KITH_DEMANDS];
  kith_lifecycle_demands(&plan->model->integrator, demand);
  text[0] = '\0';
  for (int d = 0; d < KITH_DEMANDS; ++d)
    if (asks(&demand[d].need, what)) add(text, size, ", ", "%s (%s)", demand[d].who, demand[d].why);
}

static void structure(const char *name, bool built, const char *amount, const char *who) {
  printf("    %-12s  %-8s  %-17s  %s\n", name, built ? "built" : "left out", built ? amount : "", who);
}

static void show_requirements(const struct plan *plan) {
  static const char *const name[] = {"rows", "pairs", "ghost rows", "overlap", "intersection"};
  const struct kith_connectivity *c = plan->model->connectivity;
  const struct kith_nodes *nodes = plan->model->nodes;
  const double n = fmax(nodes->n_internal, 1), pairs = fmax((double)c->pairs.n, 1);
  const double entries[] = {
      c->rows.n > 0 ? (double)c->rows.first[c->rows.n] / n : 0, (double)c->pairs.n / n,
      (double)nodes->n_ghost / n, c->overlap.n > 0 ? (double)c->overlap.first[c->overlap.n] / n : 0,
      c->intersection.n > 0 ? (double)c->intersection.first[c->intersection.n] / pairs : 0};
  char who[256], amount[64];
  printf("\n  connectivity: nothing is built that no one asked for\n");
  for (int what = 0; what < 5; ++what) {
    askers(plan, what, who, sizeof who);
    snprintf(amount, sizeof amount, "%.1f a %s", entries[what], what == 4 ? "pair" : "node");
    structure(name[what], asks(&c->built, what), amount, who[0] != '\0' ? who : "nobody asked");
  }
  const struct kith_package *p = &plan->model->package;
  const double values = (double)(kith_package_pairwise_bytes(p) / sizeof(double)) / pairs;
  structure("f_couple", c->pairs.f_couple != NULL, "1 factor a pair",
            c->pairs.f_couple != NULL ? "shield (barriers)" : "nobody cuts a pair");
  snprintf(amount, sizeof amount, "%.0f values a pair", floor(values));
  structure("pairwise", values >= 1, amount, values >= 1 ? p->ops->name : "nobody keeps values of pairs");
  putchar('\n');
}

static void show_lifecycle(const struct plan *plan) {
  const struct kith_model *m = plan->model;
  const struct kith_integrator *it = &m->integrator;
  const struct kith_ledger *l = &it->ledger;
  char text[512] = "";
  const double lifecycles = fmax((double)l->lifecycles, 1);
  line("search", "%s: %s", m->search->ops->name, m->search->ops->doc);
  for (int k = 0; k < m->rebuilds.n; ++k)
    add(text, sizeof text, "; or ", "%s: %s", m->rebuilds.policy[k].ops->name,
        m->rebuilds.policy[k].ops->doc);
  line("rebuild", "%s; skin %.3g of the support", text, it->skin);
  if (m->boundaries.n == 0)
    line("ghosts", "none: no boundary makes any");
  else
    line("ghosts", "%.0f made at the start, %.0f culled, %.0f kept%s", (double)l->created / lifecycles,
         (double)l->culled / lifecycles, (double)l->kept / lifecycles, it->cull ? "" : "; culling is off");
  if (it->reorder_every > 0)
    line("reordering", "along the curve, looked at every %d lifecycles", it->reorder_every);
  else
    line("reordering", "never");
}

/* ---- method ---- */

/* Stages below the package's own, in the order of their first call: its passes as they were run, for one
 * evaluation. */
static void show_passes(const struct plan *plan) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(plan->profile, &stage);
  char text[1024] = "", time[32];
  for (int s = 0; s < n; ++s) {
    const int parent = stage[s].parent;
    if (parent < 0 || stage[parent].depth != 0 ||
        strcmp(stage[parent].name, plan->model->package.ops->name) != 0)
      continue;
    add(text, sizeof text, ", ", "%s", stage[s].name);
    const int calls = (int)stage[s].calls / plan->times.evaluations;
    if (calls > 1) add(text, sizeof text, " ", "x %d", calls);
    add(text, sizeof text, " ", "%s", kith_text_seconds(time, stage[s].seconds / plan->times.evaluations));
  }
  line("passes", "%s", text);
}

static const char *traversal_reason(const struct plan *plan) {
  if (plan->scene->traversal[0] != '\0') return "as the scene says";
  if (plan->model->package.ops->dear) return "the default: each force is dear, and kept";
  if (!plan->model->package.compatible) return "the default: each force is needed once";
  return NDIM == 1
             ? "the default: a compatible energy needs each force twice, and with few neighbors keeping is faster"
             : "the default: with many neighbors evaluating twice is faster than keeping";
}

static void show_method(const struct plan *plan) {
#define WORD(name, word, doc) #word,
  static const char *const viscosity[] = {KITH_VISCOSITY_LIST(WORD)};
#undef WORD
  const struct kith_package *p = &plan->model->package;
  const struct kith_scheme_ops *scheme = plan->model->integrator.scheme;
  line("method", "%s: %s", p->ops->name, p->ops->doc);
  line("kernel", "%s, %.4g neighbors (%s)", kith_kernel_facts[p->kernel].name, p->neighbors,
       plan->scene->method.neighbors > 0 ? "as the scene says" : "the default of this kernel");
  line("viscosity", "%s, alpha %.4g, beta %.4g", viscosity[p->viscosity], p->alpha, p->beta);
  line("energy", "%s",
       p->compatible ? "compatible: from the work of pairs, kept to round-off"
                     : "thermal: from its own equation");
  line("traversal", "%s (%s)", p->traversal == KITH_TRAVERSE_PAIRS ? "pairs" : "gather",
       traversal_reason(plan));
  show_passes(plan);
  line("scheme", "%s: %s", scheme->name, scheme->doc);
  if (scheme == &kith_scheme_arkode) line("", "table %s", plan->scene->scheme.table);
}

/* ---- cost ---- */

static void show_memory(const struct plan *plan) {
  struct kith_bytes bytes[KITH_MODEL_STRUCTURES];
  const double n = fmax(plan->model->nodes->n_internal, 1);
  double total = 0;
  char text[32];
  kith_model_bytes(plan->model, bytes);
  printf("\n  %-12s  %12s  %14s\n", "memory", "in all", "bytes per node");
  for (int k = 0; k < KITH_MODEL_STRUCTURES; ++k) {
    total += (double)bytes[k].bytes;
    printf("    %-10s  %12s  %14.1f\n", bytes[k].name, kith_text_bytes(text, (double)bytes[k].bytes),
           (double)bytes[k].bytes / n);
  }
  printf("    %-10s  %12s  %14.1f\n\n", "sum", kith_text_bytes(text, total), total / n);
}

/* Steps that grow by a quarter up to the full dt, which then stays. */
static double expected_steps(double first, double full, double until) {
  double steps = 0, time = 0;
  for (double dt = first; dt < full && time < until; dt *= 1.25) time += dt, steps += 1;
  return steps + (time < until ? ceil((until - time) / full) : 0);
}

static void show_dt(const struct plan *plan) {
  const struct kith_integrator *it = &plan->model->integrator;
  if (it->fixed_dt > 0)
    line("first dt", "%.4g, as the scene says; the Courant number %.3g would allow %.4g (%s, node %lld)",
         it->fixed_dt, it->cfl, plan->full_dt, it->vote.reason, (long long)it->vote.node);
  else
    line("first dt", "%.4g: a tenth, for the start, of %.4g that node %lld allows (%s, Courant number %.3g)",
         it->vote.dt, plan->full_dt, (long long)it->vote.node, it->vote.reason, it->cfl);
}

/* The times of the start, kept to the end: all there is for a scene that costs next to nothing, or that no pilot could run. */
static double show_guess(struct plan *plan, double until, double steps) {
  const struct kith_integrator *it = &plan->model->integrator;
  plan->lists = it->evaluations;
  plan->step = it->evaluations * (plan->times.rates + plan->times.lifecycle);
  const double seconds = steps * it->evaluations * plan->times.rates;
  char time[32], all[32];
  line("steps", "about %.0f to t = %.6g, an estimate: %s", steps, until,
       it->fixed_dt > 0 ? "all of the same length"
                        : "dt grows by a quarter a step and then stays as it is now");
  line("cost", "about %s: %.0f steps of %d evaluation%s of %s, %d thread%s", kith_text_seconds(all, seconds),
       steps, it->evaluations, it->evaluations == 1 ? "" : "s", kith_text_seconds(time, plan->times.rates),
       omp_get_max_threads(), omp_get_max_threads() == 1 ? "" : "s");
  if (kith_rebuilds_lasting(it->rebuilds)) line("", "lists last for several steps; the rebuilds come on top");
  return seconds;
}

static double show_piloted(struct plan *plan, double until, const struct kith_pilot *pilot,
                           double fixed_steps) {
  const struct kith_integrator *it = &plan->model->integrator;
  const double steps = fixed_steps > 0 ? fixed_steps : kith_pilot_steps(pilot, plan->scene->resolution);
  const double evaluation = plan->times.rates + pilot->rebuilds * plan->times.lifecycle;
  const double seconds = steps * it->evaluations * evaluation * pilot->growth;
  plan->lists = it->evaluations * (kith_rebuilds_lasting(it->rebuilds) ? pilot->rebuilds : 1);
  plan->step = it->evaluations * evaluation * pilot->growth;
  char time[32], all[32], lists[96] = "";
  line("steps",
       "about %.0f to t = %.6g, from two runs with fewer nodes: %.0f at resolution %.4g, %.0f at %.4g", steps,
       until, pilot->steps[0], pilot->resolution[0], pilot->steps[1], pilot->resolution[1]);
  if (pilot->rebuilds > 0)
    snprintf(lists, sizeof lists, " (lists made anew for %.0f %% of them)", 100 * pilot->rebuilds);
  line("cost", "about %s: %.0f steps of %d evaluation%s of %s%s, which grow by a factor of %.2f; %d thread%s",
       kith_text_seconds(all, seconds), steps, it->evaluations, it->evaluations == 1 ? "" : "s",
       kith_text_seconds(time, evaluation), lists, pilot->growth, omp_get_max_threads(),
       omp_get_max_threads() == 1 ? "" : "s");
  return seconds;
}

/* What the scene costs, in seconds. */
static double show_cost(struct plan *plan, const struct kith_options *options, double until) {
  const double cheap = 1; /* seconds */
  const struct kith_integrator *it = &plan->model->integrator;
  const bool fixed = it->fixed_dt > 0;
  const double steps =
      expected_steps(fixed ? it->fixed_dt : it->vote.dt, fixed ? it->fixed_dt : plan->full_dt, until);
  const double guess = steps * it->evaluations * (plan->times.rates + plan->times.lifecycle);
  const double budget = fmin(fmax(0.08 * guess, 0.7), 5); /* the larger the pilots the surer */
  struct kith_pilot pilot;
  show_dt(plan);
  if (guess < cheap ||
      kith_pilot_run(&pilot, options, plan->scene->resolution, until, guess, budget) != KITH_OK)
    return show_guess(plan, until, steps);
  return show_piloted(plan, until, &pilot, fixed ? steps : 0);
}

/* Cheaper forms are for what costs more than a few seconds. */
static void show(struct plan *plan, const struct kith_options *options, double until) {
  printf("%s, %d-D: what will be built and why; nothing is written\n\n", plan->scene->name, NDIM);
  show_domain(plan);
  show_forces(plan);
  show_materials(plan);
  show_regions(plan);
  show_requirements(plan);
  show_lifecycle(plan);
  show_method(plan);
  show_memory(plan);
  const double seconds = show_cost(plan, options, until);
  fflush(stdout);
  if (options->ranks > 1 &&
      kith_plan_ranks(plan->model, options->ranks, plan->step, plan->lists, &options->network) != KITH_OK)
    fprintf(stderr, "kith: warning: ranks: %s\n", kith_failure());
  if (options->quiet || seconds < 2) return;
  if (kith_forms_show(options, plan->model, until, seconds) != KITH_OK)
    fprintf(stderr, "kith: warning: cheaper forms: %s\n", kith_failure());
}

/* ---- measuring ---- */

static kith_status make(struct plan *plan, const struct kith_options *o) {
  if (o->subject == NULL) KITH_FAIL(BAD_INPUT, "plan: no scene; for example: kith plan inputs/sod.yaml");
  KITH_TRY(kith_scene_read(&plan->scene, o->subject, o->n_overrides, o->overrides));
  KITH_TRY(kith_profile_create(&plan->profile, omp_get_max_threads(), false));
  return kith_model_create(&plan->model, plan->scene, plan->profile, o->check);
}

/* The rates of the start once to have them, and a few times more to time them. */
static kith_status measure(struct plan *plan) {
  KITH_TRY(kith_model_start(plan->model));
  plan->full_dt = kith_package_vote(plan->model->integrator.package, plan->model->integrator.cfl).dt;
  kith_model_warn(plan->model);
  return kith_times_measure(plan->model, &plan->times);
}

enum kith_exit kith_plan(const struct kith_options *options) {
  struct plan plan = {0};
  enum kith_exit code = KITH_EXIT_USAGE;
  kith_status status = make(&plan, options);
  if (status == KITH_OK) {
    status = measure(&plan);
    code = status == KITH_OK ? KITH_EXIT_OK : KITH_EXIT_FAILED;
  }
  if (status == KITH_OK)
    show(&plan, options, options->until >= 0 ? options->until : plan.scene->until);
  else
    fprintf(stderr, "kith: %s\n", kith_failure());
  kith_model_destroy(&plan.model);
  kith_profile_destroy(&plan.profile);
  kith_scene_destroy(&plan.scene);
  return code;
}
