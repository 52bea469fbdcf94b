/* Rows of history.csv, from the list of its columns. */
#include "app/output/history.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>
#include "app/cli/process.h"

#define NAME(name, least, kind, value, unit, doc) \
  if (NDIM >= (least)) strcat(strcat(names, names[0] != '\0' ? "," : ""), #name);

kith_status kith_history_open(struct kith_history *history, const char *directory,
                              const struct kith_simulation *m, bool restarted) {
  char names[1024] = "";
  history->started = kith_seconds() - kith_process_age();
  if (kith_ranks_rank(m->nodes->ranks) != 0) return KITH_OK;
  KITH_HISTORY_LIST(NAME)
  return kith_csv_log_open(&history->steps, directory, "history.csv", names,
                           restarted ? &m->integrator.step : NULL);
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

kith_status kith_history_row(struct kith_history *history, const struct kith_simulation *m) {
  const struct kith_integrator *it = &m->integrator;
  const struct kith_summary *all = &it->summary;
  const struct kith_totals *now = &all->totals;
  const struct kith_decomposition none = {0}, *d = m->decomposition != NULL ? m->decomposition : &none;
  if (d->balance_checks > 1) history->largest_imbalance = fmax(history->largest_imbalance, d->last_imbalance);
  if (kith_ranks_rank(m->nodes->ranks) != 0) return KITH_OK;
  const double seconds = kith_seconds() - history->started;
  const char *comma = "";
  FILE *f = history->steps.file;
  KITH_HISTORY_LIST(PUT)
  return kith_csv_log_row(&history->steps);
}
