/* What a chart says in words: the same sentences for the screen and for the page. */
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include "app/chart.h"

const int kith_cost_metrics[KITH_COSTS] = {0, 2};

__attribute__((format(printf, 2, 3))) static void add(char text[KITH_CHART_TEXT], const char *format, ...) {
  const size_t used = strlen(text);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text + used, KITH_CHART_TEXT - used, format, arguments);
  va_end(arguments);
}

const struct kith_point *kith_chart_point(const struct kith_chart *c, int m, int r) {
  return &c->point[(size_t)m * c->suite->n_resolutions + r];
}

void kith_chart_values(const struct kith_chart *c, int metric, double *values) {
  const size_t n = (size_t)c->n_methods * c->suite->n_resolutions;
  for (size_t k = 0; k < n; ++k) values[k] = c->point[k].failed ? NAN : c->point[k].value[metric];
}

/* Errors and costs of all points in one block, errors first. */
static kith_status values_of(const struct kith_chart *c, int norm, int cost, double **both) {
  const size_t n = (size_t)c->n_methods * c->suite->n_resolutions;
  *both = NULL;
  KITH_TRY(kith_resize(both, 0, 2 * n, sizeof **both));
  kith_chart_values(c, c->suite->norm[norm], *both);
  kith_chart_values(c, kith_cost_metrics[cost], *both + n);
  return KITH_OK;
}

kith_status kith_chart_front(const struct kith_chart *c, int norm, int cost, bool *on) {
  const int n = c->n_methods * c->suite->n_resolutions;
  double *both;
  KITH_TRY(values_of(c, norm, cost, &both));
  const kith_status status = kith_front(n, both + n, both, on);
  kith_free(&both);
  return status;
}

void kith_chart_order(const struct kith_chart *c, int m, int norm, double *all, double *last) {
  double error[KITH_SUITE_RESOLUTIONS] = {0};
  const int n = c->suite->n_resolutions;
  for (int r = 0; r < n; ++r) {
    const struct kith_point *p = kith_chart_point(c, m, r);
    error[r] = p->failed ? NAN : p->value[c->suite->norm[norm]];
  }
  *all = kith_order(n, c->suite->resolution, error);
  *last = n >= 2 ? kith_order(2, c->suite->resolution + n - 2, error + n - 2) : NAN;
}

/* --- prices --- */

struct offer {
  int method;
  struct kith_price price;
};

static int cheaper(const void *a, const void *b) {
  const double x = ((const struct offer *)a)->price.cost, y = ((const struct offer *)b)->price.cost;
  return (x > y) - (x < y);
}

/* Who reaches the target, the cheapest first. */
static int offers_of(const struct kith_chart *c, const double *both, double target, struct offer *offer) {
  const int n = c->suite->n_resolutions, all = c->n_methods * n;
  int count = 0;
  for (int m = 0; m < c->n_methods; ++m) {
    const struct kith_price price =
        kith_price_of(n, c->suite->resolution, both + all + (size_t)m * n, both + (size_t)m * n, target);
    if (isfinite(price.cost)) offer[count++] = (struct offer){m, price};
  }
  qsort(offer, (size_t)count, sizeof *offer, cheaper);
  return count;
}

static void add_cost(char text[KITH_CHART_TEXT], int cost, double value) {
  add(text, cost == 0 ? "%.3g CPU-s" : "%.3g pair evaluations", value);
}

/* "mfm, resolution about 130, 3.1 CPU-s; then sph, 5.2 CPU-s (1.7 times)" */
static void add_offers(const struct kith_chart *c, char text[KITH_CHART_TEXT], int cost,
                       const struct offer *offer, int n) {
  const struct kith_price *best = &offer[0].price;
  add(text, "%s at resolution %s%.3g%s, ", c->label[offer[0].method], best->between ? "about " : "",
      best->resolution, best->between ? "" : " (its coarsest)");
  add_cost(text, cost, best->cost);
  for (int k = 1; k < KITH_MIN(n, 4); ++k) {
    add(text, k == 1 ? "; then %s, " : ", %s, ", c->label[offer[k].method]);
    add_cost(text, cost, offer[k].price.cost);
    add(text, " (%.3g times)", offer[k].price.cost / best->cost);
  }
  if (n > 4) add(text, ", and %d more", n - 4);
}

static void add_absent(const struct kith_chart *c, char text[KITH_CHART_TEXT], const struct offer *offer,
                       int n) {
  int absent = 0;
  for (int m = 0; m < c->n_methods; ++m) {
    bool there = false;
    for (int k = 0; k < n; ++k) there |= offer[k].method == m;
    if (!there && ++absent <= 4) add(text, absent == 1 ? ". Not reached by %s" : ", %s", c->label[m]);
  }
  if (absent > 4) add(text, " and %d more", absent - 4);
}

static kith_status tell(const struct kith_chart *c, int norm, double *both, struct offer *offer,
                        char text[KITH_CHART_TEXT]) {
  const int n = c->suite->n_resolutions;
  const char *what = kith_metrics[c->suite->norm[norm]].doc;
  double target = c->suite->target[norm];
  kith_chart_values(c, c->suite->norm[norm], both);
  if (!(target > 0)) target = kith_target(c->n_methods, n, both);
  snprintf(text, KITH_CHART_TEXT, "%s, %d-D, %s", c->suite->scene_name, c->suite->dimension, what);
  if (!(target > 0)) {
    add(text, ": no error that a method crosses; more resolutions would show prices.");
    return KITH_OK;
  }
  add(text, " %.3g: ", target);
  for (int cost = 0; cost < KITH_COSTS; ++cost) {
    kith_chart_values(c, kith_cost_metrics[cost], both + (size_t)c->n_methods * n);
    const int count = offers_of(c, both, target, offer);
    if (count == 0) {
      add(text, "reached by none.");
      return KITH_OK;
    }
    if (cost > 0) add(text, ". In work, whatever the machine: ");
    add_offers(c, text, cost, offer, count);
    if (cost == KITH_COSTS - 1) add_absent(c, text, offer, count);
  }
  add(text, ".");
  return KITH_OK;
}

kith_status kith_chart_sentence(const struct kith_chart *c, int norm, char text[KITH_CHART_TEXT]) {
  const size_t n = (size_t)c->n_methods * c->suite->n_resolutions;
  double *both = NULL;
  struct offer *offer = NULL;
  kith_status status = kith_resize(&both, 0, 2 * n, sizeof *both);
  if (status == KITH_OK) status = kith_resize(&offer, 0, (size_t)c->n_methods, sizeof *offer);
  if (status == KITH_OK) status = tell(c, norm, both, offer, text);
  kith_free(&both);
  kith_free(&offer);
  return status;
}

kith_status kith_chart_front_names(const struct kith_chart *c, int norm, int cost,
                                   char text[KITH_CHART_TEXT]) {
  const int n = c->suite->n_resolutions;
  bool *on = NULL;
  text[0] = '\0';
  KITH_TRY(kith_resize(&on, 0, (size_t)c->n_methods * n, sizeof *on));
  const kith_status status = kith_chart_front(c, norm, cost, on);
  for (int m = 0; status == KITH_OK && m < c->n_methods; ++m) {
    int count = 0;
    for (int r = 0; r < n; ++r) {
      if (!on[(size_t)m * n + r]) continue;
      if (count++ == 0) add(text, "%s%s at ", text[0] != '\0' ? "; " : "", c->label[m]);
      add(text, "%s%.4g", count > 1 ? ", " : "", c->suite->resolution[r]);
    }
  }
  kith_free(&on);
  return status;
}

/* Is a point of ours no dearer and no worse? */
static bool beaten(const struct kith_chart *c, int metric, const struct kith_other *o) {
  const int n = c->n_methods * c->suite->n_resolutions;
  for (int k = 0; k < n; ++k) {
    const struct kith_point *p = &c->point[k];
    if (!p->failed && p->value[0] <= o->cpu_seconds && p->value[metric] <= o->value) return true;
  }
  return false;
}

void kith_chart_others_sentence(const struct kith_chart *c, int norm, char text[KITH_CHART_TEXT]) {
  static const char *const heads[] = {"Points of other codes that lie above the front: ",
                                      "Points that do not, more accurate at their price than all here: "};
  const int metric = c->suite->norm[norm];
  text[0] = '\0';
  for (int above = 1; above >= 0; --above) {
    const char *last = "";
    for (int k = 0; k < c->others.n; ++k) {
      const struct kith_other *o = &c->others.other[k];
      if (strcmp(o->norm, kith_metrics[metric].name) != 0 || beaten(c, metric, o) != (above == 1)) continue;
      if (last[0] == '\0')
        add(text, "%s%s%s at %.4g", text[0] != '\0' ? ". " : "", heads[1 - above], o->code, o->resolution);
      else if (strcmp(last, o->code) == 0)
        add(text, ", %.4g", o->resolution);
      else
        add(text, "; %s at %.4g", o->code, o->resolution);
      last = o->code;
    }
  }
  if (text[0] != '\0') add(text, ".");
}
