/* test_map.c - maps: pixels of a linear field (oracle: the field itself), slices and lines of sight, and
 * regions without nodes. */
#include <math.h>
#include <string.h>
#include "app/output/pictures/map.h"
#include "tests/check.h"

#if NDIM == 1
int main(void) { /* a map needs a plane */
  return 0;
}
#else
enum { SIDE = NDIM == 2 ? 40 : 16 };
static double position[SIDE * SIDE * SIDE * NDIM], one[SIDE * SIDE * SIDE], volume[SIDE * SIDE * SIDE];
static double value[SIDE * SIDE * SIDE];
static float pixel[4096 * 480];

/* A cubic lattice in [0, 1]^d, without its part where x > `end`. */
static struct kith_profile_view lattice(double end) {
  kith_index n = 0;
  for (int k = 0; k < pow(SIDE, NDIM); ++k) {
    double *x = position + (size_t)n * NDIM;
    for (int a = 0, rest = k; a < NDIM; ++a, rest /= SIDE) x[a] = (rest % SIDE + 0.5) / SIDE;
    volume[n] = pow(SIDE, -NDIM), one[n] = 1;
    n += x[0] < end;
  }
  return (struct kith_profile_view){n, position, NULL, volume, one, NULL, NULL, NULL, NULL};
}

/* The largest difference of pixels from c + x c0 + y c1, except those within `edge` of the bounds. */
static double distance(const struct kith_map *map, double edge, double c, double c0, double c1) {
  double most = 0;
  for (int j = 0; j < map->pixels[1]; ++j)
    for (int i = 0; i < map->pixels[0]; ++i) {
      const double x = map->lower[0] + (i + 0.5) * map->size[0], y = map->lower[1] + (j + 0.5) * map->size[1];
      const double d = fabs((double)pixel[j * map->pixels[0] + i] - c - c0 * x - c1 * y);
      if (fmin(fmin(x, 1 - x), fmin(y, 1 - y)) > edge) most = isnan(d) ? INFINITY : fmax(most, d);
    }
  return most;
}

int main(void) {
  struct kith_profile_view nodes = lattice(2);
  const struct kith_map plane = kith_map_of(&nodes, 2, NAN);
  for (kith_index i = 0; i < nodes.n; ++i) value[i] = 1 + position[i * NDIM] - 3 * position[i * NDIM + 1];
  CHECK(plane.pixels[0] == 480 && plane.pixels[1] == 480 && plane.normal == -1);
  CHECK(fabs(plane.lower[0]) < 1e-12 && fabs(plane.lower[0] + 480 * plane.size[0] - 1) < 1e-12);
  CHECK_OK(kith_map_draw(&plane, &nodes, value, pixel));
  /* a linear field, except for the pattern of the lattice */
  CHECK(distance(&plane, 0.15, 1, 1, -3) < 0.1 / SIDE);
  CHECK(distance(&plane, 0, 1, 1, -3) < 4.0 / SIDE); /* at edges nodes are missing on one side */
  value[7] = NAN;                                    /* is ignored */
  CHECK_OK(kith_map_draw(&plane, &nodes, value, pixel));
  CHECK(distance(&plane, 0, 1, 1, -3) < 4.0 / SIDE);
#if NDIM == 3
  for (kith_index i = 0; i < nodes.n; ++i) value[i] = position[i * NDIM + 2] + position[i * NDIM + 1];
  const struct kith_map cut = kith_map_of(&nodes, 0, 0.3); /* y to the right, z upwards */
  CHECK(cut.across[0] == 1 && cut.across[1] == 2 && cut.normal == 0);
  CHECK_OK(kith_map_draw(&cut, &nodes, value, pixel));
  CHECK(distance(&cut, 0.15, 0, 1, 1) < 0.1 / SIDE);
  for (kith_index i = 0; i < nodes.n; ++i) value[i] = position[i * NDIM];
  CHECK_OK(kith_map_draw(&cut, &nodes, value, pixel));
  CHECK(distance(&cut, 0.15, 0.3, 0, 0) < 0.1 / SIDE);
  const struct kith_map sight = kith_map_of(&nodes, 0, NAN); /* the mean of x along x */
  CHECK_OK(kith_map_draw(&sight, &nodes, value, pixel));
  CHECK(distance(&sight, 0, 0.5, 0, 0) < 1e-5);
#endif
  /* Half of the box and a node far away: between them there is nothing. */
  nodes = lattice(0.5);
  position[0] = 1 - 0.5 / SIDE;
  memset(value, 0, sizeof value);
  const struct kith_map half = kith_map_of(&nodes, 2, NAN);
  CHECK_OK(kith_map_draw(&half, &nodes, value, pixel));
  CHECK(isnan(pixel[240 * 480 + 360]) && pixel[240 * 480 + 100] == 0);
  nodes.n = 0;
  const struct kith_map none = kith_map_of(&nodes, 2, NAN);
  CHECK_OK(kith_map_draw(&none, &nodes, value, pixel));
  CHECK(isnan(pixel[0]));
  return check_failed();
}
#endif
