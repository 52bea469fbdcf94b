/* Rows of history.csv and balance.csv, from the lists of their columns. */
#include "app/output/history.h"

#include <inttypes.h>
#include <string.h>

/* Of all ranks; a checked balance has a row. */
struct sums {
  uint64_t nodes, ghosts, row_entries, migrated;
};

#define NAME(name, least, kind, value, unit, doc) \
  if (NDIM >= (least)) strcat(strcat(names, names[0] != '\0' ? "," : ""), #name);

kith_status kith_history_open(struct kith_history *history, const char *directory,
                              const struct kith_simulation *m, bool restarted) {
  const uint64_t *last = restarted ? &m->integrator.step : NULL;
  char path[640], names[1024] = "";
  history->started = kith_seconds();
  history->balance_checks = m->decomposition != NULL ? m->decomposition->balance_checks : 0;
  if (kith_ranks_rank(m->nodes->ranks) != 0) return KITH_OK;
  KITH_HISTORY_LIST(NAME)
  snprintf(path, sizeof path, "%s/history.csv", directory);
  KITH_TRY(kith_csv_log_open(&history->steps, path, names, last));
  snprintf(path, sizeof path, "%s/balance.csv", directory);
  if (m->decomposition == NULL) {
    if (!restarted) remove(path); /* of an earlier run */
    return KITH_OK;
  }
  names[0] = '\0';
  KITH_BALANCE_LIST(NAME)
  return kith_csv_log_open(&history->balance, path, names, last);
}

static double component(const double *vector, int axis) {
  return axis < NDIM ? vector[axis] : 0;
}

#define PUT_COUNT(value) fprintf(f, "%" PRIu64, (uint64_t)(value))
#define PUT_REAL(value) fprintf(f, "%.17g", value)
#define PUT_BRIEF(value) fprintf(f, "%.6g", value)
#define PUT_TEXT(value) fputs(value, f)
#define PUT(name, least, kind, value, unit, doc) \
  if (NDIM >= (least)) fputs(comma, f), PUT_##kind(value), comma = ",";

/* On rank 0; `checked`: the balance. */
static kith_status add_rows(struct kith_history *history, const struct kith_simulation *m,
                            const struct kith_totals *now, const struct sums *all, bool checked) {
  const struct kith_integrator *it = &m->integrator;
  const struct kith_decomposition *d = m->decomposition;
  const double seconds = kith_seconds() - history->started;
  const char *comma = "";
  FILE *f = history->steps.file;
  KITH_HISTORY_LIST(PUT)
  KITH_TRY(kith_csv_log_row(&history->steps));
  if (!checked) return KITH_OK;
  comma = "", f = history->balance.file;
  KITH_BALANCE_LIST(PUT)
  return kith_csv_log_row(&history->balance);
}

kith_status kith_history_step(struct kith_history *history, const struct kith_simulation *m,
                              const struct kith_totals *now) {
  struct kith_ranks *ranks = m->nodes->ranks;
  const struct kith_decomposition *d = m->decomposition;
  const bool checked = d != NULL && d->balance_checks != history->balance_checks;
  uint64_t sum[] = {(uint64_t)m->nodes->n_internal, (uint64_t)m->nodes->n_ghost,
                    m->integrator.ledger.last_row_entries, d != NULL ? d->migrated : 0};
  kith_ranks_sum_counts(ranks, sum, 4);
  const struct sums all = {sum[0], sum[1], sum[2], sum[3]};
  if (checked) history->balance_checks = d->balance_checks;
  return kith_ranks_allreduce_status(
      ranks, kith_ranks_rank(ranks) == 0 ? add_rows(history, m, now, &all, checked) : KITH_OK);
}

kith_status kith_history_close(struct kith_history *history) {
  const kith_status steps = kith_csv_log_close(&history->steps);
  const kith_status balance = kith_csv_log_close(&history->balance);
  return steps != KITH_OK ? steps : balance;
}
