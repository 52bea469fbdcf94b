#include "physics/force.h"

#include "physics/sweep.h"

/* A record for every node and ghost, zero where it grows. */
static kith_status record_room(struct kith_package *package, int members) {
  const kith_index n = kith_nodes_count(package->hydro->nodes);
  if (n > INT32_MAX / members) /* so that loads of several nodes become one gather */
    KITH_FAIL(UNSUPPORTED,
              "%d nodes and ghosts in one process: records are addressed with 32 bits, at most %d", n,
              INT32_MAX / members);
  const size_t wanted = (size_t)n * (size_t)members;
  if (package->record_capacity >= wanted) return KITH_OK;
  const size_t capacity = wanted + wanted / 32; /* ghosts come and go */
  KITH_TRY(kith_resize(&package->record, 0, capacity, sizeof(double)));
  package->record_capacity = capacity;
  return KITH_OK;
}

/* Records of nodes begin .. end - 1. */
static void pack(void *context, kith_index begin, kith_index end) {
  const struct kith_force_pass *pass = context;
  struct kith_package *package = pass->package;
  kith_profile_begin(package->profile, "records");
#pragma omp parallel for schedule(static)
  for (kith_index i = begin; i < end; ++i)
    pass->pack(package, i, package->record + (size_t)i * (size_t)pass->members);
  kith_profile_end(package->profile);
}

/* One sweep under the name of a stage. */
static kith_status sweep(struct kith_force_pass *pass, const kith_chunk_pass *chunk, int lanes,
                         const char *stage) {
  struct kith_package *package = pass->package;
  const struct kith_sweep sweep = {.stage = stage,
                                   .rows = pass->rows,
                                   .chunk = chunk[package->kernel],
                                   .context = pass,
                                   .lanes = lanes,
                                   .width = KITH_STRIDE,
                                   .arrived = pass->work ? NULL : pack};
  uint64_t count[4];
  const kith_status status = kith_package_sweep(package, &sweep, count);
  package->pair_evaluations += count[0];
  return status;
}

/* Canonical pairs: those that start at ghosts, whose values are there. */
struct ghost_pairs {
  struct kith_force_pass *pass;
  kith_chunk_pass chunk;
  kith_index first;
};

static void ghost_pairs_chunk(void *context, kith_index begin, kith_index end, struct kith_scratch *s) {
  const struct ghost_pairs *g = context;
  g->chunk(g->pass, g->first + begin, g->first + end, s);
}

static kith_status pairs_of_ghosts(struct kith_force_pass *pass, const kith_chunk_pass *pairs, int lanes) {
  struct kith_package *package = pass->package;
  struct ghost_pairs ghosts = {pass, pairs[package->kernel], package->hydro->nodes->n_internal};
  const kith_index n = pass->connectivity->pairs.starts - ghosts.first;
  uint64_t count[4];
  if (n == 0) return KITH_OK;
  kith_profile_begin(package->profile, "pairs");
  const kith_status status =
      kith_traverse(n, ghost_pairs_chunk, &ghosts, lanes, KITH_STRIDE, count, package->profile);
  kith_profile_end(package->profile);
  package->pair_evaluations += count[0];
  return status;
}

kith_status kith_force(struct kith_force_pass *pass, const kith_chunk_pass *pairs,
                       const kith_chunk_pass *nodes, int members, int edges) {
  struct kith_package *package = pass->package;
  const struct kith_nodes *all = package->hydro->nodes;
  const int lanes = members + edges + KITH_FORCE_LANES;
  pass->members = members;
  pass->barrier = package->barrier != NULL ? package->barrier->u8 : NULL;
  pass->work = false;
  KITH_TRY(record_room(package, members));
  pack(pass, 0, all->exchange.under_way ? kith_nodes_first_remote(all) : kith_nodes_count(all));
  if (package->traversal == KITH_TRAVERSE_PAIRS) {
    KITH_TRY(kith_pairwise_prepare(&package->pair, pass->connectivity, KITH_PAIR_VALUES));
    KITH_TRY(sweep(pass, pairs, lanes, "pairs"));
    KITH_TRY(pairs_of_ghosts(pass, pairs, lanes));
  }
  KITH_TRY(sweep(pass, nodes, lanes, "force"));
  if (kith_body_acts(&package->hydro->body))
    kith_body_pull(&package->hydro->body, all->n_internal, all->position->f64,
                   package->hydro->acceleration->f64);
  if (!package->compatible) return KITH_OK;
  struct kith_field *const kicked[] = {package->velocity_base, package->hydro->acceleration};
  kith_package_post(package, 2, kicked);
  pass->work = true;
  return sweep(pass, nodes, lanes, "work");
}
