#include "app/plan_ranks.h"

#include <stdio.h>

static void print_head(const struct kith_outlook *outlook, const struct kith_model *m, int n_ranks,
                       const struct kith_step_habits *h, const struct kith_network *net) {
  printf(
      "\n  on %d ranks: %lld cells, %.1f nodes and %.0f row entries a rank; a network of %.3g us, %.3g GB/s\n",
      n_ranks, (long long)kith_outlook_cells(outlook), (double)m->nodes->n_internal / n_ranks,
      (double)m->integrator.ledger.last_entries / n_ranks, 1e6 * net->latency, 1e-9 * net->bandwidth);
  printf(
      "  a step: %.3g times new lists, %.0f bytes a new ghost; %.3g refreshes, %.0f bytes a ghost; %.0f collective calls\n\n",
      h->lists, h->creation_bytes, h->refreshes, h->refresh_bytes, h->collectives);
  printf("  %-11s %6s %15s %5s %8s %17s   %s\n", "", "work", "ghosts of a rank", "peers", "messages",
         "KiB sent a step", "ms a step of the busiest rank");
  printf("  %-11s %6s %7s %8s %5s %8s %8s %8s %7s %7s %7s %7s %7s %6s\n", "partitioner", "imbal.", "made",
         "kept", "most", "a step", "mean", "most", "work", "ghosts", "places", "network", "step", "effic.");
}

/* Efficiency: of as many ranks as one process, which has all the work and no ghosts of others. */
static void print_line(const char *name, int n_ranks, double seconds, const struct kith_forecast *f) {
  printf("  %-11s %6.3f %7.0f %8.0f %5.0f %8.1f %8.1f %8.1f %7.3g %7.3g %7.3g %7.3g %7.3g %6.3f\n", name,
         f->imbalance, f->made, f->kept, f->most_peers, f->messages, f->bytes / 1024, f->most_bytes / 1024,
         1e3 * f->seconds.work, 1e3 * f->seconds.ghosts, 1e3 * f->seconds.places, 1e3 * f->seconds.network,
         1e3 * f->seconds.step, seconds / (n_ranks * f->seconds.step));
}

static kith_status show(const struct kith_outlook *outlook, const struct kith_step_habits *habits,
                        const struct kith_costs *costs, int n_ranks, double seconds) {
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    struct kith_forecast f;
    if ((*p)->needs != NULL) continue;
    KITH_TRY(kith_outlook_forecast(outlook, (*p)->name, habits, costs, &f));
    print_line((*p)->name, n_ranks, seconds, &f);
  }
  return KITH_OK;
}

kith_status kith_plan_ranks(struct kith_model *m, int n_ranks, double seconds, double lists,
                            const struct kith_network *network) {
  struct kith_outlook *outlook = NULL;
  struct kith_step_habits habits;
  KITH_TRY(kith_step_habits(m, lists, &habits));
  const struct kith_rows *rows = &m->connectivity->rows;
  const double all = (double)m->nodes->n_internal + (double)rows->first[m->nodes->n_internal];
  const struct kith_costs costs = {seconds / all, KITH_GHOST_WORK * seconds / all, *network};
  KITH_TRY(kith_outlook_create(&outlook, m, n_ranks));
  print_head(outlook, m, n_ranks, &habits, network);
  const kith_status status = show(outlook, &habits, &costs, n_ranks, seconds);
  kith_outlook_destroy(&outlook);
  return status;
}
