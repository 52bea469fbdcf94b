#include "app/validate_cover.h"

/* Values of all factors are numbered through: value v of factor f is first[f] + v. */
struct cover {
  int n, values;
  const int *count;
  int first[KITH_COVER_FACTORS];
  bool *met; /* [values][values] pairs that have occurred */
  int *used; /* [values] */
};

/* Pairs that value v of factor f would add to a row, -1 where it has no value yet. */
static int added(const struct cover *c, const int *row, int f, int v) {
  int n = 0;
  for (int g = 0; g < c->n; ++g)
    n += g != f && row[g] >= 0 && !c->met[(c->first[f] + v) * c->values + c->first[g] + row[g]];
  return n;
}

static int best_value(const struct cover *c, const int *row, int f) {
  int best = 0;
  for (int v = 1; v < c->count[f]; ++v) {
    const int more = added(c, row, f, v) - added(c, row, f, best);
    if (more > 0 || (more == 0 && c->used[c->first[f] + v] < c->used[c->first[f] + best])) best = v;
  }
  return best;
}

/* Begins a row with the first pair that has not occurred. */
static bool begin(const struct cover *c, int *row) {
  for (int f = 0; f < c->n; ++f) row[f] = -1;
  for (int f = 0; f < c->n; ++f)
    for (int v = 0; v < c->count[f]; ++v)
      for (int g = f + 1; g < c->n; ++g)
        for (int w = 0; w < c->count[g]; ++w) {
          if (c->met[(c->first[f] + v) * c->values + c->first[g] + w]) continue;
          row[f] = v, row[g] = w;
          return true;
        }
  return false;
}

static void note(const struct cover *c, const int *row) {
  for (int f = 0; f < c->n; ++f) {
    ++c->used[c->first[f] + row[f]];
    for (int g = 0; g < c->n; ++g) c->met[(c->first[f] + row[f]) * c->values + c->first[g] + row[g]] = true;
  }
}

static kith_status make_rows(const struct cover *c, int **row, int *n_rows) {
  int next[KITH_COVER_FACTORS];
  size_t room = 0;
  *n_rows = 0;
  for (bool more = begin(c, next); more; more = begin(c, next)) {
    for (int f = 0; f < c->n; ++f)
      if (next[f] < 0) next[f] = best_value(c, next, f);
    note(c, next);
    const size_t used = (size_t)*n_rows * (size_t)c->n;
    if (used + (size_t)c->n > room) {
      room = 2 * used + 64;
      KITH_TRY(kith_resize(row, used, room, sizeof **row));
    }
    for (int f = 0; f < c->n; ++f) (*row)[used + (size_t)f] = next[f];
    ++*n_rows;
  }
  return KITH_OK;
}

kith_status kith_cover(int n_factors, const int *count, int **row, int *n_rows) {
  if (n_factors < 2 || n_factors > KITH_COVER_FACTORS)
    KITH_FAIL(BAD_INPUT, "a cover of %d factors: 2 to %d", n_factors, KITH_COVER_FACTORS);
  struct cover c = {.n = n_factors, .count = count};
  for (int f = 0; f < n_factors; ++f) c.first[f] = c.values, c.values += count[f];
  kith_status status = kith_resize(&c.met, 0, (size_t)c.values * (size_t)c.values, sizeof *c.met);
  if (status == KITH_OK) status = kith_resize(&c.used, 0, (size_t)c.values, sizeof *c.used);
  if (status == KITH_OK) status = make_rows(&c, row, n_rows);
  kith_free(&c.met);
  kith_free(&c.used);
  return status;
}
