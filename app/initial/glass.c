/* A glass: each cube of a periodic cell gets a site at a random place in it. The sites then move down the
 * gradient of the sum over pairs of a Wendland kernel until they are nearly at rest. The density summed with
 * such a kernel is then uniform to 0.3 %, and no direction stands out as in a lattice. */
#include "app/initial/glass.h"

#include <math.h>
#include "lib/core/random.h"

enum { ITERATIONS = 1000, PAIRS = KITH_GLASS_SITES * (NDIM == 3 ? 80 : 20) };
enum { RESTLESS = 20, EVERY = 20 }; /* pairs are found in each of the first iterations, later in every 20th */
static const double support = 2.4, skin = 0.4; /* in mean spacings */
/* A move is `step` times the force and `kept` times the last move: this was fastest in experiments. */
static const double step = 0.3, kept = 0.8;

struct glass {
  double x[KITH_GLASS_SITES][NDIM], move[KITH_GLASS_SITES][NDIM];
  int n_pairs, pair[PAIRS][2];
};

static double separation(const struct glass *g, int i, int j, double *d) {
  double r2 = 0;
  for (int a = 0; a < NDIM; ++a) {
    d[a] = g->x[i][a] - g->x[j][a];
    d[a] -= KITH_GLASS_SIDE * rint(d[a] / KITH_GLASS_SIDE);
    r2 += d[a] * d[a];
  }
  return r2;
}

static void find_pairs(struct glass *g) {
  double d[NDIM];
  g->n_pairs = 0;
  for (int i = 0; i < KITH_GLASS_SITES; ++i)
    for (int j = i + 1; j < KITH_GLASS_SITES; ++j)
      if (separation(g, i, j, d) < (support + skin) * (support + skin) && g->n_pairs < PAIRS) {
        g->pair[g->n_pairs][0] = i, g->pair[g->n_pairs][1] = j;
        ++g->n_pairs;
      }
}

/* Adds - step times the gradient of (1 - q)^4 (1 + 4 q), q = r / support, to the moves of both ends. */
static void push(struct glass *g) {
  for (int p = 0; p < g->n_pairs; ++p) {
    const int i = g->pair[p][0], j = g->pair[p][1];
    double d[NDIM];
    const double left = 1 - sqrt(separation(g, i, j, d)) / support;
    if (left <= 0) continue;
    for (int a = 0; a < NDIM; ++a) {
      const double force = 20 * left * left * left * d[a] / (support * support);
      g->move[i][a] += step * force, g->move[j][a] -= step * force;
    }
  }
}

static void relax(struct glass *g) {
  for (int i = 0; i < KITH_GLASS_SITES; ++i)
    for (int a = 0, rest = i; a < NDIM; ++a, rest /= KITH_GLASS_SIDE)
      g->x[i][a] = rest % KITH_GLASS_SIDE + 0.5 + 0.5 * kith_random(1, i, a);
  for (int k = 0; k < ITERATIONS; ++k) {
    if (k < RESTLESS || k % EVERY == 0) find_pairs(g);
    for (int i = 0; i < KITH_GLASS_SITES; ++i)
      for (int a = 0; a < NDIM; ++a) g->move[i][a] *= kept;
    push(g);
    for (int i = 0; i < KITH_GLASS_SITES; ++i)
      for (int a = 0; a < NDIM; ++a) g->x[i][a] += g->move[i][a];
  }
}

const double (*kith_glass_sites(void))[NDIM] {
  static struct glass glass;
  if (glass.n_pairs > 0) return (const double(*)[NDIM])glass.x;
  relax(&glass);
  for (int i = 0; i < KITH_GLASS_SITES; ++i)
    for (int a = 0; a < NDIM; ++a)
      glass.x[i][a] = glass.x[i][a] / KITH_GLASS_SIDE - floor(glass.x[i][a] / KITH_GLASS_SIDE);
  return (const double(*)[NDIM])glass.x;
}
