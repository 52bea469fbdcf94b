#include "physics/force.h"

kith_status kith_force_records(struct kith_package *package, int members) {
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

/* One sweep over nodes 0 .. n - 1 under the name of a stage. */
static kith_status sweep(struct kith_force_pass *pass, const kith_chunk_pass *chunk, kith_index n, int lanes,
                         const char *stage) {
  struct kith_package *package = pass->package;
  uint64_t count[4];
  kith_profile_begin(package->profile, stage);
  const kith_status status =
      kith_traverse(n, chunk[package->kernel], pass, lanes, KITH_STRIDE, count, package->profile);
  kith_profile_end(package->profile);
  package->pair_evaluations += count[0];
  return status;
}

kith_status kith_force(struct kith_force_pass *pass, const kith_chunk_pass *pairs,
                       const kith_chunk_pass *nodes, int members, int edges) {
  struct kith_package *package = pass->package;
  const kith_index n = package->hydro->nodes->n_internal;
  const int lanes = members + edges + KITH_FORCE_LANES;
  pass->barrier = package->barrier != NULL ? package->barrier->u8 : NULL;
  pass->work = false;
  if (package->traversal == KITH_TRAVERSE_PAIRS) {
    KITH_TRY(kith_pairwise_prepare(&package->pair, pass->connectivity, KITH_PAIR_VALUES));
    KITH_TRY(sweep(pass, pairs, pass->connectivity->pairs.starts, lanes, "pairs"));
  }
  KITH_TRY(sweep(pass, nodes, n, lanes, "force"));
  if (kith_body_acts(&package->hydro->body))
    kith_body_pull(&package->hydro->body, package->hydro->nodes->n_internal,
                   package->hydro->nodes->position->f64, package->hydro->acceleration->f64);
  if (!package->compatible) return KITH_OK;
  struct kith_field *const kicked[] = {package->velocity_base, package->hydro->acceleration};
  kith_package_refresh(package, 2, kicked);
  pass->work = true;
  return sweep(pass, nodes, n, lanes, "work");
}
