/* plan.c - `kith plan SCENE`: what a scene will build and why, memory, time step and expected cost; with
 * --ranks N what each partitioner would make of it. Nothing is written.
 *
 * The objects are those of a run, with the rates at the start: FAILED if these cannot be evaluated. Steps and
 * cost are those of a calibration run, with fewer nodes if the scene takes long (calibration.h). */
#include "app/plan/plan_ranks.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"
#include "app/initial/deposits.h"
#include "app/initial/initial_conditions.h"
#include "app/initial/lattice.h"
#include "app/output/output.h"
#include "integrator/window.h"

enum { MOST_NODES = 1 << 21, MODEL_NODES = 100000, TEXT = 1024 };
static const double LEAST_PAIRS = 1e8, MOST_PAIRS = 2e8; /* pair evaluations of calibration: a few seconds */

/* Appends the parameters of a table, without its maps: "gamma 1.4, stiffness 0". */
static void add_settings(char text[TEXT], const struct kith_param *params, const void *settings) {
  char value[64];
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p) {
    if (p->kind == KITH_PARAM_MAP) continue;
    kith_param_format(p, settings, value, sizeof value);
    kith_text_join(text, TEXT, ", ", "%s %s", p->key, value);
  }
}

static void show_materials(const struct kith_plan *plan) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_nodes *nodes = m->nodes, *held = kith_boundaries_held(&m->boundaries);
  for (int l = 0; l < nodes->n_lists; ++l) {
    const kith_index frozen = held != NULL ? held->lists[l].count : 0;
    const struct kith_material *material = &m->scene->material[l];
    char eos[TEXT] = "";
    kith_text_add(eos, TEXT, "%s", material->eos->name);
    add_settings(eos, material->eos->params, material->settings);
    kith_text_line(l == 0 ? "materials" : "", "%-12s %9.0f nodes; %s", nodes->lists[l].name,
                   plan->node_ratio * (nodes->lists[l].count + frozen), eos);
  }
  if (held != NULL)
    kith_text_line("", "%-12s %9.0f of these nodes; they never move", "frozen",
                   plan->node_ratio * held->n_internal);
}

static void structure(const char *name, bool built, int digits, double amount, const char *of,
                      const char *why) {
  char stored[64] = "", label[128];
  if (built) snprintf(stored, sizeof stored, "%.*f %s", digits, amount, of);
  snprintf(label, sizeof label, "    %-13s %-8s  %-17s", name, built ? "built" : "left out", stored);
  kith_text_wrapped(47, label, why);
}

/* Entries of the first n rows: those of internal nodes, without those of ghosts. */
static double entries(const struct kith_rows *rows, kith_index n) {
  return rows->n > 0 ? (double)rows->first[n] : 0;
}

/* Prints the pairwise fields of a list; returns how many there are. */
static int show_pairwise(const struct kith_plan *plan, const struct kith_pairs *pairs) {
  const int n = pairs->fields != NULL ? pairs->fields->n : 0;
  for (int k = 0; k < n; ++k) {
    const struct kith_pairwise *field = &pairs->fields->field[k];
    char why[TEXT] = "";
    char size[32];
    kith_text_add(why, TEXT, "%s: %s",
                  kith_text_bytes(size, plan->node_ratio * (double)(field->capacity * sizeof(double))),
                  field->spec.doc);
    structure(field->spec.name, true, 0, field->spec.components,
              field->spec.components > 1 ? "values a pair" : "value a pair", why);
  }
  return n;
}

/* Rows in the canonical order of a reproducible run are not traversed by pairs. */
static bool by_pairs(const struct kith_plan *plan, const struct kith_package *p) {
  return p->traversal == KITH_TRAVERSE_PAIRS && !plan->scene->reproducible;
}

/* What a package or the lifecycle itself requires of the connectivity, and why. */
struct demand {
  const char *who, *why;
  struct kith_requirements need;
};

static int list_demands(const struct kith_plan *plan, struct demand *demand) {
  int n = 0;
  demand[n++] = (struct demand){"lifecycle", "culling", {.rows = true}};
  for (const struct kith_package *p = &plan->simulation->package; p != NULL; p = p->next)
    demand[n++] = (struct demand){p->ops->name,
                                  p->ops->couple != NULL ? "f_couple"
                                  : by_pairs(plan, p)    ? "pairs"
                                                         : "gather",
                                  kith_package_requirements(p)};
  return n;
}

static void show_requirements(const struct kith_plan *plan) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_connectivity *c = m->connectivity;
  const kith_index internal = m->nodes->n_internal;
  const double n = fmax(internal, 1), pairs = fmax((double)c->pairs.n, 1);
  struct demand demand[2 + KITH_ADDED_PACKAGES];
  const int demands = list_demands(plan, demand);
  const char *absent = "not requested";
  printf("\n  connectivity: only what is required is built\n");
#define SHOW(name, member, amount, of)                                                                     \
  {                                                                                                        \
    char why[TEXT] = "";                                                                                   \
    for (int d = 0; d < demands; ++d)                                                                      \
      if (demand[d].need.member) kith_text_join(why, TEXT, ", ", "%s (%s)", demand[d].who, demand[d].why); \
    if (why[0] == '\0') kith_text_add(why, TEXT, "%s", absent);                                            \
    structure(name, c->built.member, 1, amount, of, why);                                                  \
  }
  SHOW("rows", rows, entries(&c->rows, internal) / n, "a node")
  SHOW("pairs", pairs, (double)c->pairs.n / n, "a node")
  if (plan->scene->partition.recompute) absent = "requested on several ranks (partition.ghosts)";
  SHOW("ghost rows", ghost_rows, (double)m->nodes->n_ghost / n, "a node")
  absent = "not requested";
  SHOW("overlap", overlap, entries(&c->overlap, internal) / n, "a node")
  SHOW("overlap pairs", overlap_pairs, (double)c->overlap_pairs.n / n, "a node")
  SHOW("intersection", intersection, entries(&c->intersection, c->intersection.n) / pairs, "a pair")
#undef SHOW
  if (show_pairwise(plan, &c->pairs) + show_pairwise(plan, &c->overlap_pairs) == 0)
    structure("pairwise", false, 0, 0, "", "no values of pairs are stored");
  putchar('\n');
}

/* Ghosts are those of the lists after the first rates, whose supports have converged; they grow as a surface
 * with the resolution. */
static void show_lifecycle(const struct kith_plan *plan) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_integrator *it = &m->integrator;
  const struct kith_ledger *l = &it->ledger, *started = &plan->started;
  const double lists = fmax((double)(l->lifecycles - started->lifecycles), 1),
               scale = plan->node_ratio / plan->resolution_ratio / lists;
  char text[TEXT] = "";
  kith_text_line("search", "%s: %s", m->search->ops->name, m->search->ops->doc);
  for (int k = 0; k < m->rebuilds.n; ++k)
    kith_text_join(text, TEXT, "; or ", "%s: %s", m->rebuilds.policy[k].ops->name,
                   m->rebuilds.policy[k].ops->doc);
  kith_text_line("rebuild",
                 kith_rebuilds_lasting(&m->rebuilds)
                     ? "%s; skin %.3g of the support"
                     : "%s; %.3g of the support more, should it grow in the step",
                 text, it->skin);
  if (m->boundaries.n == 0)
    kith_text_line("ghosts", "none: no boundary creates any");
  else
    kith_text_line("ghosts", "%.0f created at the start, %.0f culled, %.0f kept%s",
                   scale * (double)(l->ghosts_created - started->ghosts_created),
                   scale * (double)(l->ghosts_culled - started->ghosts_culled),
                   scale * (double)(l->ghosts_kept - started->ghosts_kept),
                   it->cull ? "" : "; culling is off");
  if (it->reorder_every > 0)
    kith_text_line("reordering", "along the space-filling curve, checked every %d lifecycles",
                   it->reorder_every);
  else
    kith_text_line("reordering", "never");
}

/* Prints an evaluation at the start, and what it consists of, in the order of the first call: the passes of
 * packages (stages directly below them), and other stages. They have their parts of its seconds, which are
 * those of the fastest evaluation, and of the processor if there is one thread. */
static void show_evaluation(const struct kith_plan *plan) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(plan->profile, &stage);
  double all = 0;
  char text[TEXT] = "";
  char time[32];
  for (int pass = 0; pass < 2; ++pass)
    for (int s = 0; s < n; ++s) {
      const struct kith_stage *top = stage[s].depth == 1 ? &stage[stage[s].parent] : &stage[s];
      if (!kith_plan_measured(top) || stage[s].depth != (kith_package_find(top->name) != NULL)) continue;
      const uint64_t calls = stage[s].calls / top->calls;
      if (pass == 0) {
        all += stage[s].seconds;
        continue;
      }
      kith_text_join(text, TEXT, ", ", "%s", stage[s].name);
      if (calls > 1) kith_text_add(text, TEXT, " x %d", (int)calls);
      kith_text_join(text, TEXT, " ", "%s",
                     kith_text_seconds(time, plan->evaluation / all * stage[s].seconds));
    }
  kith_text_line("evaluation", "%s at the start: %s", kith_text_seconds(time, plan->evaluation), text);
}

/* Prints the parameters of a package, a line for each map: "viscosity   name limited, alpha 1, beta 2". */
static void show_settings(const char *label, const struct kith_param *params, const void *settings) {
  char text[TEXT] = "";
  for (const struct kith_param *p = params; p != NULL && p->key != NULL; ++p)
    if (p->kind == KITH_PARAM_MAP) show_settings(p->key, p->params, settings);
  add_settings(text, params, settings);
  if (text[0] != '\0') kith_text_line(label, "%s", text);
}

/* Prints whether gas at rest stays on each lattice of the scene, as where kith_lattice_stiffness() > 0, which
 * is that of spherical supports. */
static void show_lattices(const struct kith_plan *plan) {
  const struct kith_scene *scene = plan->simulation->scene;
  const struct kith_package *p = &plan->simulation->package;
  double stiffness[KITH_LATTICES];
  bool used[KITH_LATTICES] = {false};
  char stiff[TEXT] = "";
  if (plan->simulation->nodes->stretched != NULL) return;
  for (int k = 0; k < KITH_LATTICES; ++k) {
    stiffness[k] = kith_lattice_stiffness(k, p->kernel, p->neighbors);
    if (isfinite(stiffness[k]) && stiffness[k] > 0)
      kith_text_join(stiff, TEXT, ", ", "%s", kith_lattice_names[k]);
  }
  for (int r = 0; r < scene->n_regions; ++r) used[scene->region[r].lattice] = true;
  for (int k = 0; k < KITH_LATTICES; ++k) {
    const char *name = kith_lattice_names[k];
    if (!used[k] || !isfinite(stiffness[k])) continue;
    if (stiffness[k] > 0)
      kith_text_line("lattice", "%s: stiff under shear (%.2g), gas at rest stays", name, stiffness[k]);
    else
      kith_text_line("lattice", "%s: gives way under shear (stiffness %.2g), gas at rest moves; stiff: %s",
                     name, stiffness[k], stiff[0] != '\0' ? stiff : "none");
  }
}

static void show_method(const struct kith_plan *plan) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_package *p = &m->package;
  kith_text_line("method", "%s: %s", p->ops->name, p->ops->doc);
  kith_text_line(
      "kernel", "%s, %.4g neighbors (%s)", kith_kernel_facts[p->kernel].name, p->neighbors,
      m->scene->method.neighbors > 0 ? "as the scene says" : "the default of this package and kernel");
  show_settings("settings", p->ops->params, p->settings);
  show_lattices(plan);
  for (const struct kith_package *added = p->next; added != NULL; added = added->next) {
    kith_text_line("added", "%s: %s", added->ops->name, added->ops->doc);
    show_settings("settings", added->ops->params, added->settings);
  }
  kith_text_line("energy", "%s",
                 p->compatible ? "compatible: from the work of pairs, conserved to round-off"
                               : "thermal: its own equation");
  kith_text_line(
      "traversal", "%s (%s)", by_pairs(plan, p) ? "pairs" : "gather",
      m->scene->reproducible           ? "reproducible: rows are summed in the order of the ids of nodes"
      : m->scene->traversal[0] != '\0' ? "as the scene says"
      : NDIM > 1                       ? "the default: a pair within a tile of nodes is evaluated once"
                 : "the default of 1-D: rows are short, and evaluating a pair at both its ends is faster");
  show_evaluation(plan);
  kith_text_line("scheme", "%s: %s", m->integrator.scheme->name, m->integrator.scheme->doc);
}

/* Ghosts grow as a surface with the resolution, and are a smaller part of the nodes of a large scene. */
static void show_memory(const struct kith_plan *plan) {
  struct kith_bytes bytes[KITH_SIMULATION_STRUCTURES];
  const struct kith_nodes *nodes = plan->simulation->nodes;
  const double n = plan->node_ratio * fmax(nodes->n_internal, 1), ghosts = plan->node_ratio * nodes->n_ghost,
               of_all = (n + ghosts / plan->resolution_ratio) / (n + ghosts);
  double total = 0;
  char text[32];
  kith_simulation_bytes(plan->simulation, bytes);
  printf("\n  %-14s  %12s  %14s\n", "memory", "one process", "bytes per node");
  for (int k = 0; k < KITH_SIMULATION_STRUCTURES; ++k) {
    const double b = plan->node_ratio * (double)bytes[k].bytes * (bytes[k].of_ghosts ? of_all : 1);
    total += b;
    printf("    %-12s  %12s  %14.1f\n", bytes[k].name, kith_text_bytes(text, b), b / n);
  }
  printf("    %-12s  %12s  %14.1f\n\n", "sum", kith_text_bytes(text, total), total / n);
}

static void show_dt(const struct kith_plan *plan, double until) {
  const struct kith_integrator *it = &plan->simulation->integrator;
  const struct kith_timestep_limit *limit = &it->timestep_limit;
  const double first = limit->dt / plan->resolution_ratio, release = kith_deposits_next(plan->scene, 0),
               end = fmin(fmin(until, release),
                          kith_output_step_end(plan->scene, kith_output_next(plan->scene, 0), until));
  kith_text_line(
      "Courant", "%.3g (%s)", it->cfl,
      plan->simulation->scene->scheme.cfl > 0 ? "as the scene says" : "the default of this package");
  if (kith_scheme_has_blocks(it->scheme, it->settings))
    kith_text_line("base step",
                   "%.4g at first%s; the shortest step is that of node %lld, which allows %.4g (%s)",
                   fmin(first, end),
                   first <= end     ? ""
                   : end == until   ? ", the whole run"
                   : end == release ? ", until energy is released"
                                    : ", since output is due then (output.every)",
                   (long long)limit->node, plan->full_dt, kith_limit_name(limit->reason));
  else if (it->fixed_dt > 0)
    kith_text_line("first dt", "%.4g, as the scene says; the Courant number would allow %.4g (%s, node %lld)",
                   it->fixed_dt, plan->full_dt, kith_limit_name(limit->reason), (long long)limit->node);
  else
    kith_text_line("first dt", "%.4g: a tenth, for the start, of %.4g that node %lld allows (%s)", first,
                   plan->full_dt, (long long)limit->node, kith_limit_name(limit->reason));
}

/* Number of steps to `until`, which grow as the integrator lets them (KITH_GROWTH) up to the full dt. */
static double expected_steps(double first, double full, double until) {
  double steps = 0, time = 0;
  for (double dt = first; dt < full && time < until; dt *= KITH_GROWTH) time += dt, steps += 1;
  return steps + (time < until ? ceil((until - time) / full) : 0);
}

/* Prints the number of steps, or of updates of a node, and how it was found. */
static void show_steps(const struct kith_plan *plan, const struct kith_calibration *c, kith_status calibrated,
                       double steps, double until) {
  const struct kith_integrator *it = &plan->simulation->integrator;
  const bool parts = it->nodes->activity != NULL; /* not all nodes are updated in each step */
  const char *label = parts ? "updates" : "steps";
  char many[64], reached[32] = "";
  snprintf(many, sizeof many, parts ? "about %.4g of a node to t = %.6g" : "about %.9g to t = %.6g",
           parts ? steps : round(steps), until);
  if (c->reached < until) snprintf(reached, sizeof reached, " to t = %.4g", c->reached);
  if (calibrated != KITH_OK)
    kith_text_line(label, "%s, an estimate: %s; calibration: %s", many,
                   it->fixed_dt > 0 ? "all of the same length"
                   : parts          ? "as many as if all nodes were updated in each step"
                                    : "dt grows by a quarter a step and then stays as it is now",
                   kith_failure());
  else if (c->resolution < plan->scene->resolution || c->reached < until)
    kith_text_line(label, "%s; a calibration run took %.6g at resolution %.4g%s", many, c->steps,
                   c->resolution, reached);
  else
    kith_text_line(label, "%s, counted by running the scene to its end", many);
}

/* Prints steps and cost: the longer the calibration run, the more reliable. */
static void show_cost(struct kith_plan *plan, const struct kith_options *options, double until) {
  const struct kith_integrator *it = &plan->simulation->integrator;
  const bool fixed = it->fixed_dt > 0, blocks = kith_scheme_has_blocks(it->scheme, it->settings),
             parts = it->nodes->activity != NULL; /* not all nodes are updated in each step */
  struct kith_calibration c = {.resolution = plan->scene->resolution}; /* no steps to t = 0 */
  char all[32];
  const double first = fixed    ? it->fixed_dt
                       : blocks ? 0.1 * plan->full_dt
                                : it->timestep_limit.dt / plan->resolution_ratio;
  double steps = expected_steps(first, fixed ? it->fixed_dt : plan->full_dt, until);
  /* Densities take each row entry, forces each pair. */
  const double evaluations = steps * it->evaluations,
               pairs = evaluations * plan->node_ratio * 1.5 * (double)it->ledger.last_row_entries;
  const struct kith_calibration guess = {
      .resolution = plan->scene->resolution, .pairs = pairs, .evaluations = evaluations};
  const double budget = fmin(fmax(0.08 * pairs, LEAST_PAIRS), MOST_PAIRS);
  const kith_status calibrated =
      until > 0 ? kith_calibration_run(&c, options, &guess, until, budget) : KITH_OK;
  plan->growth = calibrated == KITH_OK && c.steps > 0 ? c.growth : 1;
  plan->needed = calibrated == KITH_OK && c.steps > 0 ? c.needed : NAN;
  if (calibrated == KITH_OK && !fixed) steps = c.expected;
  if (calibrated == KITH_OK && fixed && !parts && c.reached > 0)
    steps = c.steps * until / c.reached; /* the same at any resolution */
  show_steps(plan, &c, calibrated, steps, until);
  kith_text_line(
      "cost",
      "about %s: %.3g %s of %d evaluation%s, which take%s %.2f times as long as at the start; %d thread%s",
      kith_text_seconds(all, steps * it->evaluations * plan->evaluation * plan->growth), steps,
      parts ? "updates of all nodes," : "steps", it->evaluations, it->evaluations == 1 ? "" : "s",
      it->evaluations == 1 ? "s" : "", plan->growth, omp_get_max_threads(),
      omp_get_max_threads() == 1 ? "" : "s");
}

/* Can the scene be run with a setting, "key=value: what it does"? */
static bool is_accepted(const struct kith_options *options, const char *told) {
  struct kith_scene *scene = NULL;
  char setting[160];
  snprintf(setting, sizeof setting, "%.*s", (int)strcspn(told, ":"), told);
  kith_status status = kith_scene_read_with(&scene, options, setting);
  if (status == KITH_OK) status = kith_simulation_check(scene);
  kith_scene_destroy(&scene);
  return status == KITH_OK;
}

/* Writes which time steps would save time, "scheme.steps=block" or "=global", why, and their trade-off.
 * Returns false if those of the scene do, or if energies are released later and only the start is known.
 * Block steps pay where steps differ much: a tick costs more than a step of as many nodes, and steps are
 * rounded down. */
static bool suggest_steps(const struct kith_plan *plan, bool late, char text[TEXT]) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_integrator *it = &m->integrator;
  const bool possible = it->scheme->blocks != NULL && it->fixed_dt <= 0 &&
                        kith_package_traits(m->package.ops, m->package.settings).all_rows == NULL,
             known = isfinite(plan->needed);
  const double start = possible ? kith_updates_needed(it) : 1,
               needed = possible && known ? plan->needed : start;
  text[0] = 0;
  kith_text_add(text, TEXT,
                needed < 0.4
                    ? "scheme.steps=block: time steps of nodes differ; %.3g %% of the updates are needed"
                    : "scheme.steps=global: time steps of nodes are alike, %.3g %% of the updates are needed",
                100 * needed);
  if (!known) kith_text_add(text, TEXT, " at the start");
  if (needed < 0.4 && known) kith_text_add(text, TEXT, " (%.3g %% at the start)", 100 * start);
  if (needed < 0.4)
    kith_text_add(text, TEXT,
                  "; errors grow by a few percent, and angular momentum is not conserved to round-off");
  return (known || !late) && kith_scheme_has_blocks(it->scheme, it->settings) != (needed < 0.4);
}

/* Writes "window=follow" and why, if it would save time: if much of the gas stays at rest. */
static bool suggest_window(const struct kith_plan *plan, double until, char text[160]) {
  const struct kith_simulation *m = plan->simulation;
  const struct kith_integrator *it = &m->integrator;
  const struct kith_package_traits traits = kith_package_traits(m->package.ops, m->package.settings);
  const bool possible = it->nodes->activity == NULL && !it->scheme->retries && !it->scheme->implicit &&
                        !kith_rebuilds_lasting(&m->rebuilds) && m->hydro.outside_force == NULL &&
                        traits.all_rows == NULL && traits.history == NULL;
  const double rest = possible ? kith_window_at_rest(it, until) : 0;
  snprintf(text, 160,
           "window=follow: no signal reaches %.0f %% of the nodes; gas at rest costs little until one comes",
           100 * rest);
  return rest >= 0.3;
}

/* Prints settings that would save time, and their trade-off: model no more than a scene needs. If energies
 * are released later, the start does not tell which window saves time. */
static void show_cheaper(const struct kith_plan *plan, const struct kith_options *options, double until) {
  const struct kith_simulation *m = plan->simulation;
  const bool late = isfinite(kith_deposits_next(m->scene, 0)),
             lists = !kith_rebuilds_lasting(&m->rebuilds) && m->nodes->activity == NULL;
  char steps[TEXT], window[160];
  const char *const settings[] = {
      suggest_steps(plan, late, steps) ? steps : NULL,
      !late && suggest_window(plan, until, window) ? window : NULL,
      lists ? "connectivity.rebuild=displacement: Verlet lists, for flow much slower than sound; they cost "
              "time elsewhere; the same forces"
            : NULL,
      kith_package_traits(m->package.ops, m->package.settings).cheaper};
  const char *label = "cheaper";
  for (size_t k = 0; k < sizeof settings / sizeof *settings; ++k)
    if (settings[k] != NULL && is_accepted(options, settings[k]))
      kith_text_line(label, "%s", settings[k]), label = "";
}

static void show(struct kith_plan *plan, const struct kith_options *options, double until) {
  printf("%s, %d-D: what will be built and why; nothing is written\n\n", plan->scene->name, NDIM);
  if (plan->coarse != NULL)
    kith_text_line("simulated",
                   "resolution %.4g, %d nodes; what follows is scaled to %.4g, %.3g times as many",
                   plan->coarse->resolution, plan->simulation->nodes->n_internal, plan->scene->resolution,
                   plan->node_ratio);
  show_materials(plan);
  show_requirements(plan);
  show_lifecycle(plan);
  show_method(plan);
  show_memory(plan);
  show_dt(plan, until);
  show_cost(plan, options, until);
  show_cheaper(plan, options, until);
  fflush(stdout);
  if (options->ranks > 1 && kith_plan_ranks(plan, options) != KITH_OK)
    fprintf(stderr, "kith: warning: ranks: %s\n", kith_failure());
}

/* Reads the scene; if it is too large to lay out here, also at a lower resolution, to be simulated
 * instead. */
static kith_status read_scenes(struct kith_plan *plan, const struct kith_options *o) {
  double *site_volume = NULL, sites = 0, coarse = 0;
  plan->node_ratio = plan->resolution_ratio = 1;
  KITH_TRY(kith_scene_read(&plan->scene, o->subject, o->n_overrides, o->overrides));
  KITH_TRY(kith_resize(&site_volume, 0, (size_t)plan->scene->n_regions + 1, sizeof *site_volume));
  kith_status status = kith_initial_conditions_outline(plan->scene, site_volume, &sites);
  if (status == KITH_OK && sites > MOST_NODES) {
    status = kith_scene_read_at(&plan->coarse, o,
                                2 * ceil(0.5 * plan->scene->resolution * kith_root_dim(MODEL_NODES / sites)));
    if (status == KITH_OK) status = kith_initial_conditions_outline(plan->coarse, site_volume, &coarse);
    if (status == KITH_OK) {
      plan->node_ratio = sites / coarse, plan->resolution_ratio = kith_root_dim(plan->node_ratio);
      for (struct kith_deposit *d = plan->coarse->deposit;
           d < plan->coarse->deposit + plan->coarse->n_deposits; ++d)
        if (!(d->radius > 0))
          d->energy *= plan->node_ratio; /* some nodes get it: each as much as in the scene */
    }
  }
  kith_free(&site_volume);
  return status;
}

/* Evaluates the rates at the start, and measures how long that takes. */
static kith_status prepare(struct kith_plan *plan, const struct kith_options *o, enum kith_exit *code) {
  KITH_TRY(read_scenes(plan, o));
  KITH_TRY(kith_profile_create(&plan->profile, omp_get_max_threads(), false));
  KITH_TRY(kith_simulation_create(&plan->simulation, plan->coarse != NULL ? plan->coarse : plan->scene, NULL,
                                  plan->profile, false));
  struct kith_simulation *m = plan->simulation;
  if (o->threads == 0) kith_share_cores(NULL, m->nodes->n_internal);
  KITH_TRY(kith_forecast_cells(m, KITH_MAX(o->ranks, 1), &plan->cells));
  *code = KITH_EXIT_FAILED;
  KITH_TRY(kith_simulation_start(m));
  plan->full_dt = kith_package_timestep_limit(&m->package, m->integrator.cfl).dt / plan->resolution_ratio;
  kith_simulation_warn(m);
  plan->started = m->integrator.ledger;
  KITH_TRY(kith_evaluation_measure(m, &plan->evaluation));
  plan->evaluation *= plan->node_ratio;
  *code = KITH_EXIT_OK;
  return KITH_OK;
}

enum kith_exit kith_plan(const struct kith_options *options) {
  struct kith_plan plan = {0};
  enum kith_exit code = KITH_EXIT_USAGE;
  const kith_status status = prepare(&plan, options, &code);
  if (status == KITH_NO_MEMORY) code = KITH_EXIT_FAILED;
  if (status == KITH_OK)
    show(&plan, options, options->until >= 0 ? options->until : plan.scene->until);
  else
    fprintf(stderr, "kith: %s\n", kith_failure());
  kith_simulation_destroy(&plan.simulation);
  kith_profile_destroy(&plan.profile);
  kith_scene_destroy(&plan.coarse);
  kith_scene_destroy(&plan.scene);
  return code;
}
