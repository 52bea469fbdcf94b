/* contacts.c - statistics of nodes of one material near those of another. */
#include "app/output/contacts.h"

#include <math.h>
#include "lib/io/csv.h"

struct kith_contacts {
  const struct kith_simulation *simulation; /* borrowed */
  struct kith_search *search;
  struct kith_list **list;   /* [scene->n_contacts] */
  struct kith_csv_log table; /* on rank 0 */
};

/* Indices of what is reduced over the nodes. */
enum { NODES, PAIRS, DISTANCE, APPROACH, REDUCERS };

/* Tallies the neighbors that share a support with the node now; lists that are kept longer hold more. */
static void tally_contacts(void *context, const struct kith_neighbors *neighbors, struct kith_tally *tally) {
  const struct kith_simulation *m = context;
  const double *x = m->nodes->position->f64, *v = m->hydro.velocity->f64, *h = m->nodes->support->f64;
  const struct kith_shifts *shifts = &m->nodes->shifts;
  const size_t i = (size_t)neighbors->node;
  bool meets = false;
  for (size_t k = 0; k < neighbors->n; ++k) {
    const size_t j = (size_t)neighbors->source[k];
    double d[NDIM], stretched[NDIM]; /* stretched: in units of the half axes of supports */
    for (int a = 0; a < NDIM; ++a) {
      d[a] = x[j * NDIM + a] + (neighbors->shift != NULL ? shifts->by[neighbors->shift[k]][a] : 0);
      d[a] = x[i * NDIM + a] - d[a];
      stretched[a] = d[a] / m->nodes->stretch[a];
    }
    const double r = kith_norm(d);
    if (!(kith_norm(stretched) <= KITH_MAX(h[i], h[j]))) continue;
    double closing = 0;
    for (int a = 0; a < NDIM; ++a) closing -= d[a] * (v[i * NDIM + a] - v[j * NDIM + a]);
    meets = true;
    kith_tally_add(tally, PAIRS, 1);
    kith_tally_add(tally, DISTANCE, r);
    kith_tally_add(tally, APPROACH, r > 0 ? closing / r : 0);
  }
  if (meets) kith_tally_add(tally, NODES, 1);
}

kith_status kith_contacts_create(struct kith_contacts **out, const struct kith_simulation *m,
                                 const char *directory, bool restarted) {
  const struct kith_scene *scene = m->scene;
  *out = NULL;
  if (scene->n_contacts == 0) return KITH_OK;
  KITH_TRY(kith_resize(out, 0, 1, sizeof **out));
  struct kith_contacts *c = *out;
  c->simulation = m;
  KITH_TRY(kith_resize(&c->list, 0, (size_t)scene->n_contacts, sizeof *c->list));
  KITH_TRY(kith_search_create(&c->search, m->search->ops, m->nodes));
  for (int k = 0; k < scene->n_contacts; ++k) {
    const struct kith_contact *contact = &scene->contact[k];
    const struct kith_list_spec spec = {
        .targets = {m->nodes, c->search, .lists = UINT64_C(1) << contact->of},
        .sources = {m->nodes, c->search, .lists = UINT64_C(1) << contact->with},
        .cutoff = KITH_CUTOFF_gather_scatter,
        .radius = m->nodes->search_radius->spec.name,
        .storage = scene->connectivity.storage,
        .rebuild = scene->connectivity.rebuild,
        .period = scene->period};
    KITH_TRY(kith_list_create(&c->list[k], &spec));
  }
  if (kith_ranks_rank(m->nodes->ranks) != 0) return KITH_OK;
  return kith_csv_log_open(&c->table, directory, "contacts.csv",
                           "step,time,of,with,nodes,pairs,distance,approach,builds,why",
                           restarted ? &m->integrator.step : NULL);
}

static kith_status add_row(struct kith_contacts *c, int k, const struct kith_reducer *found,
                           enum kith_rebuild_reason why) {
  const struct kith_integrator *it = &c->simulation->integrator;
  const struct kith_scene *scene = c->simulation->scene;
  const struct kith_contact *contact = &scene->contact[k];
  fprintf(c->table.file, "%llu,%.17g,%s,%s,%.0f,%.0f,%.17g,%.17g,%llu,%s", (unsigned long long)it->step,
          it->time, scene->material_name[contact->of], scene->material_name[contact->with],
          found[NODES].value, found[PAIRS].value, found[PAIRS].value > 0 ? found[DISTANCE].value : NAN,
          found[PAIRS].value > 0 ? found[APPROACH].value : NAN, (unsigned long long)c->list[k]->builds,
          kith_rebuild_reason_name(why));
  return kith_csv_log_row(&c->table);
}

kith_status kith_contacts_sample(struct kith_contacts *c) {
  if (c == NULL) return KITH_OK;
  const struct kith_simulation *m = c->simulation;
  struct kith_ranks *ranks = m->nodes->ranks;
  struct kith_field *const changed[] = {m->nodes->position, m->nodes->support, m->hydro.velocity};
  /* Ghosts have the values of the last evaluation, but nodes have moved on since. */
  kith_halo_refresh(m->hydro.halo, m->nodes, changed, 3);
  for (int k = 0; k < m->scene->n_contacts; ++k) {
    struct kith_reducer found[REDUCERS] = {[NODES] = {KITH_COUNT, 0},
                                           [PAIRS] = {KITH_COUNT, 0},
                                           [DISTANCE] = {KITH_LEAST, 0},
                                           [APPROACH] = {KITH_MOST, 0}};
    enum kith_rebuild_reason why;
    KITH_TRY(kith_list_update(c->list[k], &why));
    KITH_TRY(kith_list_visit_all(c->list[k], tally_contacts, (void *)(uintptr_t)m, found, REDUCERS));
    const kith_status status = kith_ranks_rank(ranks) == 0 ? add_row(c, k, found, why) : KITH_OK;
    KITH_TRY(kith_ranks_allreduce_status(ranks, status));
  }
  return KITH_OK;
}

kith_status kith_contacts_sync(struct kith_contacts *c) {
  return c != NULL ? kith_csv_log_sync(&c->table) : KITH_OK;
}

kith_status kith_contacts_destroy(struct kith_contacts **contacts) {
  struct kith_contacts *c = *contacts;
  if (c == NULL) return KITH_OK;
  const kith_status status = kith_csv_log_close(&c->table);
  for (int k = 0; c->list != NULL && k < c->simulation->scene->n_contacts; ++k)
    kith_list_destroy(&c->list[k]);
  kith_free(&c->list);
  kith_search_destroy(&c->search);
  kith_free(contacts);
  return status;
}
