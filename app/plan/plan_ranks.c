/* `kith plan --ranks N`: work, ghosts, messages, time and memory of the ranks. */
#include "app/plan/plan_ranks.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include "app/cli/text.h"
#include "integrator/lifecycle.h"

/* Prints the line of a partitioner, or why there is none. */
static void show_forecast(const char *partitioner, kith_status status, const struct kith_forecast *f) {
  char bytes[32], seconds[32];
  if (status != KITH_OK) {
    kith_text_wrapped(14, "", kith_failure());
    return;
  }
  printf("  %-11s %9.3f %8.0f %7.0f %6.1f %5.0f %9.0f %11s %11s %10.3f\n", partitioner, f->imbalance,
         f->ghosts, f->most_ghosts, f->peers, f->most_peers, f->messages, kith_text_bytes(bytes, f->bytes),
         kith_text_seconds(seconds, f->seconds), f->efficiency);
  fflush(stdout); /* the next one may take seconds */
}

/* Prints the memory of a rank: the bytes that nodes and ghosts have in this process, and those of the map. */
static void show_memory_of_rank(const struct kith_plan *plan, const char *partitioner,
                                const struct kith_forecast *f, int n_ranks) {
  enum { CELL = 16 /* bytes, while the balance is checked */ };
  struct kith_bytes bytes[KITH_SIMULATION_STRUCTURES];
  const struct kith_nodes *nodes = plan->simulation->nodes;
  const double own = plan->node_ratio * nodes->n_internal / n_ranks,
               ghosts = f->ghosts + plan->node_ratio / plan->resolution_ratio * nodes->n_ghost / n_ranks;
  double sum = CELL * f->cells;
  char all[32], map[32];
  kith_simulation_bytes(plan->simulation, bytes);
  for (int k = 0; k < KITH_SIMULATION_STRUCTURES; ++k)
    sum += (double)bytes[k].bytes *
           (bytes[k].of_ghosts ? (own + ghosts) / kith_nodes_count(nodes) : own / nodes->n_internal);
  kith_text_line("memory",
                 "%s a rank with %s: of %.0f nodes, %.0f ghosts and images, and %s of the map of cells",
                 kith_text_bytes(all, sum), partitioner, own, ghosts, kith_text_bytes(map, CELL * f->cells));
}

/* The part of the time at the start that is spent in stages which treat ghosts as nodes: g of forecast.h. */
static double part_of_ghost_stages(const struct kith_plan *plan) {
  static const char *const names[] = {"ghosts", "neighbors", "cull", "patch"};
  const struct kith_stage *stage;
  const int n = kith_profile_stages(plan->profile, &stage);
  double all = 0, items = 0;
  for (int s = 0; s < n; ++s) {
    if (kith_plan_measured(&stage[s])) all += stage[s].seconds;
    for (size_t k = 0; k < sizeof names / sizeof *names && stage[s].depth == 1; ++k)
      if (kith_plan_measured(&stage[stage[s].parent]) && strcmp(stage[s].name, names[k]) == 0)
        items += stage[s].seconds;
  }
  return all > 0 ? items / all : 0;
}

/* Fills in T and the other inputs of forecast.h; some thousand nodes rehearse what ranks tell each other. */
static kith_status cost_of_step(const struct kith_plan *plan, const struct kith_options *options,
                                struct kith_step_cost *cost) {
  enum { REHEARSE_NODES = 2000 };
  const struct kith_simulation *m = plan->simulation;
  const double coarsening = kith_root_dim(fmax(plan->node_ratio * m->nodes->n_internal / REHEARSE_NODES, 1));
  *cost = (struct kith_step_cost){.ghost_stage_part = part_of_ghost_stages(plan),
                                  .images = plan->node_ratio / plan->resolution_ratio * m->nodes->n_ghost,
                                  .machine = plan->scene->machine};
  KITH_TRY(
      kith_rehearsal_run(&cost->rehearsal, options, 2 * ceil(0.5 * plan->scene->resolution / coarsening)));
  cost->seconds = plan->evaluation * plan->growth * cost->rehearsal.evaluations;
  return KITH_OK;
}

/* Lists of all nodes with all images, those too that one process culls: ranks make them. */
static kith_status list_all_images(struct kith_integrator *it) {
  it->cull = false;
  if (it->follows) memset(it->nodes->activity->u8, KITH_ACTIVE, (size_t)it->nodes->n_internal);
  KITH_TRY(kith_lifecycle(it, KITH_BECAUSE_requested));
  return kith_lifecycle_close(it);
}

kith_status kith_plan_ranks(struct kith_plan *plan, const struct kith_options *options) {
  struct kith_simulation *m = plan->simulation;
  const int n_ranks = options->ranks;
  const char *own = plan->scene->partition.member.name;
  char text[128];
  struct kith_step_cost cost;
  struct kith_forecast f = {0}, of_scene = {0};
  char seconds[32], latency[32], collective[32], bandwidth[32];
  KITH_TRY(cost_of_step(plan, options, &cost));
  KITH_TRY(list_all_images(&m->integrator));
  printf("\n  on %d ranks: %.1f nodes and %.0f row entries a rank\n", n_ranks,
         plan->node_ratio * m->nodes->n_internal / n_ranks,
         plan->node_ratio * (double)m->integrator.ledger.last_row_entries / n_ranks);
  kith_text_line("a step",
                 "%s on one rank; %.1f collective calls, %.1f messages to a neighbor, %.1f to a peer",
                 kith_text_seconds(seconds, cost.seconds), cost.rehearsal.collectives, cost.rehearsal.told,
                 cost.rehearsal.created + cost.rehearsal.kept);
  kith_text_line(
      "a message", "%s, its bytes %s a second, a collective call %s log2 N (machine: of the scene)",
      kith_text_seconds(latency, cost.machine.latency), kith_text_bytes(bandwidth, cost.machine.bandwidth),
      kith_text_seconds(collective, cost.machine.collective));
  putchar('\n');
  printf("  %-11s %9s %16s %12s %45s\n", "", "work", "ghosts of a rank", "peers of it", "a step of a rank");
  printf("  %-11s %9s %8s %7s %6s %5s %9s %11s %11s %10s\n", "partitioner", "imbalance", "mean", "most",
         "mean", "most", "messages", "bytes", "time", "efficiency");
  for (const struct kith_partitioner_ops *const *p = kith_partitioner_all(); *p != NULL; ++p) {
    const bool alone = plan->coarse != NULL;
    const bool chosen = *p == kith_partitioner_find(own);
    if ((*p)->needs != NULL || (alone && !chosen)) continue;
    snprintf(text, sizeof text, "%s", (*p)->name);
    if (chosen) kith_scene_partitioner(plan->scene, text, sizeof text);
    const kith_status status =
        kith_forecast_ranks(plan->scene, m, alone ? NULL : &plan->cells, &cost, n_ranks, text, &f);
    show_forecast((*p)->name, status, &f);
    if (chosen && status == KITH_OK) of_scene = f;
    if (status == KITH_BAD_INPUT) break; /* of any partitioner */
  }
  if (of_scene.cells > 0) putchar('\n'), show_memory_of_rank(plan, own, &of_scene, n_ranks);
  return KITH_OK;
}
