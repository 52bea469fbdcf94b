/* The report of a run: collected from its objects, written as JSON. */
#include "app/output/report.h"

#include <math.h>
#include <omp.h>
#include <string.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>
#include "app/cli/text.h"
#include "app/output/output.h"
#include "lib/core/version.h"

static json_t *text(const char *value) {
  json_t *json = value != NULL ? json_string(value) : NULL;
  return json != NULL ? json : json_null(); /* also for what is not UTF-8 */
}

/* Whole numbers are written without a decimal point. */
static json_t *number(double value) {
  if (!isfinite(value)) return json_null();
  return value == rint(value) && fabs(value) < 0x1p53 ? json_integer((json_int_t)value) : json_real(value);
}

/* Puts a value at a dotted path, whose objects are created. */
static void put(json_t *object, const char *path, json_t *value) {
  const char *dot = strchr(path, '.');
  if (dot == NULL) {
    json_object_set_new(object, path, value);
    return;
  }
  json_t *inner = json_object_getn(object, path, (size_t)(dot - path));
  if (inner == NULL) json_object_setn_new(object, path, (size_t)(dot - path), inner = json_object());
  put(inner, dot + 1, value);
}

static void put_sum(json_t *object, const char *key, struct kith_ranks *ranks, double mine) {
  kith_ranks_sum(ranks, &mine, 1);
  put(object, key, number(mine));
}

/* Writes the counters, then how many lifecycles each reason has caused. */
static void put_counters(json_t *ledger, const struct kith_ledger *l) {
#define X(name, how, doc) put(ledger, #name, number((double)l->name));
  KITH_LEDGER_LIST(X)
#undef X
#define X(name) put(ledger, "rebuilds_because_" #name, number((double)l->because[KITH_BECAUSE_##name]));
  KITH_REBUILD_CAUSE_LIST(X)
  KITH_REBUILD_LIST(X)
#undef X
}

/* Writes what became of the ghosts of each boundary: "boundaries.periodic-x.culled". Two of one name, at both
 * sides of an axis, are summed. */
static void put_boundaries(json_t *ledger, const struct kith_ledger *l, const struct kith_boundaries *all) {
  json_t *boundaries = json_object();
  for (int b = 0; b < all->n; ++b) {
    const struct kith_boundary *boundary = all->boundary[b];
    char name[64];
    snprintf(name, sizeof name, boundary->at_lower || boundary->at_upper ? "%s-%c" : "%s",
             boundary->ops->name, 'x' + boundary->axis);
    const json_t *other = json_object_get(boundaries, name);
    json_t *ghosts = json_object();
#define PUT(key) \
  put(ghosts, #key, number((double)l->boundary[b].key + json_number_value(json_object_get(other, #key))))
    PUT(created), PUT(culled), PUT(kept);
#undef PUT
    put(boundaries, name, ghosts);
  }
  put(ledger, "boundaries", boundaries);
}

static json_t *collect_ledger(const struct kith_simulation *m) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const struct kith_ledger l = kith_ledger_of_all(&m->integrator.ledger, ranks);
  const struct kith_decomposition *decomposition = m->decomposition;
  const struct kith_traffic traffic = kith_ranks_traffic(ranks);
  json_t *ledger = json_object();
  struct kith_bytes bytes[KITH_SIMULATION_STRUCTURES];
  put_counters(ledger, &l);
  put_boundaries(ledger, &l, &m->boundaries);
  put_sum(ledger, "support_iterations", ranks, (double)m->package.support_iterations);
  put_sum(ledger, "gradient_fallbacks", ranks, (double)m->package.fallbacks);
  kith_simulation_bytes(m, bytes);
  for (int k = 0; k < KITH_SIMULATION_STRUCTURES; ++k) {
    char name[64];
    snprintf(name, sizeof name, "bytes_%s", bytes[k].name);
    put_sum(ledger, name, ranks, (double)bytes[k].bytes);
  }
  if (decomposition == NULL) return ledger;
  put_sum(ledger, "messages", ranks, (double)traffic.messages);
  put_sum(ledger, "message_bytes", ranks, (double)traffic.bytes);
  put(ledger, "collective_calls", number((double)traffic.collectives));
  put(ledger, "balance_checks", number((double)decomposition->balance_checks));
  put(ledger, "repartitions", number((double)decomposition->repartitions));
  put(ledger, "work_imbalance", number(decomposition->last_imbalance));
  put(ledger, "cells", number((double)decomposition->cells.n));
  return ledger;
}

kith_status kith_provenance_take(struct kith_provenance *p, char *const *arguments) {
  const time_t now = time(NULL);
  size_t size;
  *p = (struct kith_provenance){.host = ""};
  FILE *f = open_memstream(&p->command, &size);
  gethostname(p->host, sizeof p->host - 1);
  strftime(p->date, sizeof p->date, "%Y-%m-%dT%H:%M:%SZ", gmtime(&now));
  if (f == NULL) KITH_FAIL(NO_MEMORY, "no memory for the command line");
  for (char *const *word = arguments; *word != NULL; ++word) {
    if (word != arguments) fputc(' ', f);
    kith_text_word(f, *word);
  }
  if (fclose(f) != 0 || p->command == NULL) KITH_FAIL(NO_MEMORY, "no memory for the command line");
  return KITH_OK;
}

/* Figures of merit over the steps: set-up, first rates and output are no part of them. */
static struct kith_fom fom_of(const struct kith_simulation *m, double updates, double pairs) {
  const struct kith_stage *stage;
  double seconds = 0, bytes = kith_profile_counted(m->profile, "step/", "bytes");
  for (int n = kith_profile_stages(m->profile, &stage); n-- > 0; ++stage)
    if (strcmp(stage->path, "step") == 0) seconds = stage->seconds;
  kith_ranks_sum(m->nodes->ranks, &bytes, 1);
  const double per_second = 1 / fmax(seconds, 1e-9),
               cores = kith_ranks_size(m->nodes->ranks) * omp_get_max_threads();
  return (struct kith_fom){updates * per_second, updates * per_second / cores, pairs * per_second,
                           bytes / fmax(updates, 1)};
}

void kith_report_collect(struct kith_report *r, const struct kith_simulation *m,
                         const struct kith_conservation_baseline *b, const struct kith_provenance *p,
                         double updates, double pairs, double wall, double cpu) {
  const struct kith_integrator *it = &m->integrator;
  const struct kith_totals now = kith_hydro_totals(&m->hydro);
  const struct kith_nodes *held = kith_boundaries_held(&m->boundaries); /* each rank has all of them */
  double gas = 0;
  for (kith_index i = 0; i < m->nodes->n_internal; ++i) gas += kith_node_is_gas(m->nodes, i);
  double sum[] = {(double)m->nodes->n_internal,
                  (double)it->ledger.last_row_entries,
                  (double)m->package.pair_evaluations,
                  cpu,
                  updates,
                  pairs,
                  gas};
  kith_ranks_sum(m->nodes->ranks, sum, 7);
#define X(kind, member, key, value, unit, doc) .member = (value),
  *r = (struct kith_report){KITH_REPORT_LIST(X).measured = m->scene->measure.wanted,
                            .levels = kith_levels_of_all(&it->levels, m->nodes->ranks),
                            .ledger = collect_ledger(m)};
#undef X
  r->fom = fom_of(m, sum[4], sum[5]);
}

static struct kith_spread spread_of(struct kith_ranks *ranks, double mine) {
  struct kith_spread all = {mine, mine, mine};
  kith_ranks_sum(ranks, &all.mean, 1);
  all.mean /= kith_ranks_size(ranks);
  kith_ranks_min(ranks, &all.min, 1);
  kith_ranks_max(ranks, &all.max, 1);
  return all;
}

static void put_spread(json_t *object, struct kith_spread spread) {
  put(object, "min", number(spread.min));
  put(object, "mean", number(spread.mean));
  put(object, "max", number(spread.max));
}

/* Gives each rank the stages of all ranks. */
static kith_status unite_stages(struct kith_profile *profile, struct kith_ranks *ranks) {
  const struct kith_stage *stage;
  const int n = kith_profile_stages(profile, &stage);
  char *mine = NULL, *all = NULL;
  size_t bytes = 0, *part = NULL;
  for (int k = 0; k < n; ++k) bytes += strlen(stage[k].path) + 1;
  kith_status status = kith_resize(&mine, 0, bytes + 1, 1);
  if (status == KITH_OK) status = kith_resize(&part, 0, (size_t)kith_ranks_size(ranks) + 1, sizeof *part);
  char *end = mine;
  for (int k = 0; k < n && status == KITH_OK; ++k) end = stpcpy(end, stage[k].path) + 1;
  status = kith_ranks_allreduce_status(ranks, status);
  if (status == KITH_OK) status = kith_ranks_gather(ranks, mine, bytes, &all, part);
  for (size_t k = 0; status == KITH_OK && k < part[kith_ranks_size(ranks)]; k += strlen(all + k) + 1)
    status = kith_profile_add(profile, all + k);
  KITH_FREE(&mine, &all, &part);
  return kith_ranks_allreduce_status(ranks, status);
}

/* Collects the seconds of all ranks, one stage after the other: ranks have all stages by now, but may have
 * met them in another order. */
static kith_status spread_stages(struct kith_report *r, struct kith_ranks *ranks) {
  KITH_TRY(kith_ranks_allreduce_status(
      ranks, kith_resize(&r->stage_spread, 0, (size_t)r->n_stages, sizeof *r->stage_spread)));
  for (int s = 0; s < r->n_stages; ++s) {
    char path[256] = "";
    double seconds = 0;
    if (kith_ranks_rank(ranks) == 0) snprintf(path, sizeof path, "%s", r->stages[s].path);
    kith_ranks_broadcast(ranks, path, sizeof path);
    for (int k = 0; k < r->n_stages; ++k)
      if (strncmp(r->stages[k].path, path, sizeof path - 1) == 0) seconds = r->stages[k].seconds;
    r->stage_spread[s] = spread_of(ranks, seconds);
  }
  return KITH_OK;
}

kith_status kith_report_detail_ranks(struct kith_report *r, const struct kith_simulation *m,
                                     const struct kith_traffic *traffic, uint64_t n_steps,
                                     double largest_imbalance) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const struct kith_ledger *l = &m->integrator.ledger;
  const struct kith_decomposition none = {0}, *d = m->decomposition != NULL ? m->decomposition : &none;
  struct kith_ledger_boundary remote = {0};
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const double steps = fmax((double)n_steps, 1),
               ghosts = kith_nodes_count(m->nodes) - kith_nodes_first_remote(m->nodes);
  if (d != &none) remote = l->boundary[m->boundaries.n - 1]; /* the boundary between ranks comes last */
  const struct {
    const char *key;
    double value;
  } of_a_rank[] = {{"nodes", m->nodes->n_internal},
                   {"row_entries", (double)l->last_row_entries},
                   {"remote_ghosts", ghosts},
                   {"peak_memory_bytes", 1024.0 * (double)usage.ru_maxrss},
                   {"messages_per_step", (double)traffic->messages / steps},
                   {"bytes_per_step", (double)traffic->bytes / steps}};
  json_t *detail = r->ranks_detail = json_object();
  for (size_t k = 0; k < sizeof of_a_rank / sizeof *of_a_rank; ++k) {
    json_t *inner = json_object();
    put_spread(inner, spread_of(ranks, of_a_rank[k].value));
    put(detail, of_a_rank[k].key, inner);
  }
  put(detail, "collectives_per_step", number((double)traffic->collectives / steps));
  put_sum(detail, "remote_ghosts_created", ranks, (double)remote.created);
  put_sum(detail, "remote_ghosts_culled", ranks, (double)remote.culled);
  put_sum(detail, "remote_ghosts_kept", ranks, (double)remote.kept);
  put_sum(detail, "nodes_migrated", ranks, (double)d->migrated);
  put(detail, "repartitions", number((double)d->repartitions));
  put(detail, "largest_imbalance", number(largest_imbalance > 0 ? largest_imbalance : NAN));
  if (ranks != NULL) KITH_TRY(unite_stages(m->profile, ranks));
  r->n_stages = kith_profile_stages(m->profile, &r->stages);
  r->n_counters = kith_profile_counters(m->profile, &r->counters);
  return ranks != NULL ? spread_stages(r, ranks) : KITH_OK;
}

void kith_report_clear(struct kith_report *report) {
  json_decref(report->ledger);
  json_decref(report->ranks_detail);
  kith_free(&report->stage_spread);
  report->ledger = report->ranks_detail = NULL;
}

static void put_norms(json_t *root, const struct kith_norms *n) {
#define NUMBER(name) put(root, "norms." #name, number((double)n->name))
#define FIELD(name) NUMBER(name.l1), NUMBER(name.l2), NUMBER(name.linf)
  FIELD(density), FIELD(velocity), FIELD(pressure), FIELD(energy), FIELD(speed);
  NUMBER(nodes), NUMBER(contact_pressure_error), NUMBER(shock_radius), NUMBER(shock_exact);
  NUMBER(shock_offset), NUMBER(shock_swept);
  NUMBER(density_peak), NUMBER(speed_peak);
#undef FIELD
#undef NUMBER
}

/* The stages as JSON: the path of a stage is one key, although it may have dots. */
static json_t *stages_of(const struct kith_report *r) {
  json_t *stages = json_object();
  for (int s = 0; s < r->n_stages; ++s) {
    json_t *stage = json_object();
    put(stage, "seconds", json_real(r->stages[s].seconds));
    put(stage, "calls", json_integer((json_int_t)r->stages[s].calls));
    if (r->stage_spread != NULL) put_spread(stage, r->stage_spread[s]);
    json_object_set_new(stages, r->stages[s].path, stage);
  }
  return stages;
}

/* What block time steps took and saved; null without. */
static json_t *block_steps_of(const struct kith_levels *levels) {
  if (levels->base_steps == 0) return json_null();
  json_t *root = json_object(), *each = json_array();
  const int n = kith_levels_used(levels);
  for (int l = 0; l < n; ++l) {
    const struct kith_level *level = &levels->level[l];
    json_t *object = json_object();
    put(object, "step", number(ldexp(levels->time / levels->base_steps, -l)));
    put(object, "nodes", number(level->held / levels->time));
    put(object, "ticks", number(level->ticks));
    put(object, "updates", number(level->updates));
    put(object, "seconds", number(level->seconds));
    json_array_append_new(each, object);
  }
  put(root, "ideal", number(kith_levels_ideal(levels)));
  put(root, "achieved", number(kith_levels_achieved(levels)));
  put(root, "levels", each);
  return root;
}

static json_t *json_of(const struct kith_report *r) {
  json_t *root = json_object();
#define JSON_TEXT(value) text(value)
#define JSON_COUNT(value) json_integer((json_int_t)(value))
#define JSON_REAL(value) number(value)
#define X(kind, member, key, value, unit, doc) put(root, key, JSON_##kind(r->member));
  KITH_REPORT_LIST(X)
#undef X
  put(root, "fom",
      json_pack("{s:f, s:f, s:f, s:f}", "node_updates_per_second", r->fom.updates_per_second, "per_core",
                r->fom.per_core, "pairs_per_second", r->fom.pairs_per_second, "bytes_per_update",
                r->fom.bytes_per_update));
  put(root, "norms", r->compared ? json_object() : json_null());
  if (r->compared) put_norms(root, &r->norms);
  put(root, "measures", json_object());
  for (int k = 0; k < KITH_N_MEASURES; ++k)
    if (r->measured[k])
      json_object_set_new(json_object_get(root, "measures"), kith_measure_names[k], number(r->measure[k]));
  put(root, "stages", stages_of(r));
  put(root, "block_steps", block_steps_of(&r->levels));
  put(root, "ledger", r->ledger != NULL ? json_incref(r->ledger) : json_object());
  put(root, "ranks_detail", r->ranks_detail != NULL ? json_incref(r->ranks_detail) : json_null());
  return root;
}

kith_status kith_report_write(const struct kith_report *report, const char *path) {
  return kith_json_write(path, json_of(report));
}
