/* test_exclude.c - excluders in runs: two gases that exclude each other behave, bitwise, as if the other one
 * were absent; and excluders that are refused. */
#include "tests/unit/scenario.h"

static const char mixture[] = SCENARIO_UNIT
    "resolution: {1d: 30, 2d: 8, 3d: 4}\n"
    "boundaries: {x: periodic, y: reflecting, z: periodic}\n"
    "materials: {light: {gamma: 1.4}, heavy: {gamma: 1.6666666666666667}}\n"
    "regions:\n"
    "  - {material: light, where: {x: [0, 0.5]}, lattice: cubic, jitter: 0.3, seed: 4, density: 1, "
    "pressure: 1, velocity: [1, 0, 0]}\n"
    "  - {material: heavy, lattice: cubic, jitter: 0.3, seed: 5, density: 8, "
    "pressure: 2, velocity: [-1, 0, 0], where: {x: [0.5, SIZE]}}\n"
    "arrangement: equal-spacing\n"
    "reproducible: true\n"
    "scheme: {dt: 0.002}\n"
    "until: 1\n";

/* Counts the light nodes that differ in position, velocity or energy. */
static int differ(const struct scenario *a, const struct scenario *b) {
  const struct kith_nodes *m = a->simulation->nodes, *n = b->simulation->nodes;
  int64_t most;
  kith_index *place = scenario_indices(b, &most);
  int count = 0;
  CHECK(m->lists[0].count == n->lists[0].count && m->lists[0].count > 10);
  for (kith_index i = 0; i < m->lists[0].count; ++i) {
    const kith_index k = place[m->id->i64[i]];
    const double *x = m->position->f64 + (size_t)i * NDIM, *y = n->position->f64 + (size_t)k * NDIM,
                 *u = a->simulation->hydro.velocity->f64 + (size_t)i * NDIM,
                 *v = b->simulation->hydro.velocity->f64 + (size_t)k * NDIM;
    count += memcmp(x, y, NDIM * sizeof *x) != 0 || memcmp(u, v, NDIM * sizeof *u) != 0 ||
             a->simulation->hydro.energy->f64[i] != b->simulation->hydro.energy->f64[k];
  }
  free(place);
  return count;
}

/* `size`: the upper end of the heavy gas. */
static bool run_mixture(struct scenario *s, const char *size, const char *package, const char *exclude) {
  char text[2048];
  snprintf(text, sizeof text, "%s%s%s", mixture, exclude[0] != '\0' ? "connectivity: {exclude: '" : "",
           exclude);
  if (exclude[0] != '\0') strcat(text, "'}\n");
  memcpy(strstr(text, "SIZE"), size, 4);
  return scenario_open(s, text, "method.package=%s", package) && scenario_run(s, 3);
}

/* The light gas is accelerated by the heavy one, unless they are excluded: then it does not matter how much
 * heavy gas there is. */
static void check_apart(const char *package) {
  static const char apart_words[] = "materials:of=light and=heavy";
  struct scenario mixed = {0}, apart = {0}, few = {0};
  if (run_mixture(&mixed, "1.00", package, "") && run_mixture(&apart, "1.00", package, apart_words) &&
      run_mixture(&few, "0.75", package, apart_words)) {
    CHECK(differ(&mixed, &apart) > 10);
    CHECK(differ(&apart, &few) == 0);
  }
  scenario_close(&few);
  scenario_close(&apart);
  scenario_close(&mixed);
}

/* At each of the places where a chain may be refused; conformance_excluder.c has all messages. */
static void check_refused(void) {
  static const struct {
    const char *exclude, *why;
  } wrong[] = {{"materials:of=iron", "there is no material 'iron'"},
               {"symmetric-duplicates", "symmetric-duplicates: packages need each interaction in both rows"},
               {"none", "'none' is not one of self"}};
  char text[2048];
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
    snprintf(text, sizeof text, "%sconnectivity: {exclude: '%s'}\n", mixture, wrong[k].exclude);
    memcpy(strstr(text, "SIZE"), "1.00", 4);
    scenario_refused(text, "", wrong[k].why);
    CHECK(check_says("connectivity.exclude"));
  }
}

int main(void) {
  check_apart("sph");
  check_apart("mfm");
  check_refused();
  return check_failed();
}
