/* What a state shows of its symmetry, against what was put into it. */
#include <string.h>
#include "app/model.h"
#include "app/symmetry.h"
#include "tests/check.h"

static const char plain[] =
    "scene: symmetry\n"
    "dimension: 3\n"
    "resolution: 8\n"
    "domain: {lower: [-0.5, -0.5, -0.5], upper: [0.5, 0.5, 0.5]}\n"
    "boundaries: {x: periodic, y: periodic, z: periodic}\n"
    "materials: {gas: {eos: ideal, gamma: 1.4}}\n"
    "regions: [{material: gas, lattice: cubic, density: 1, pressure: 1}]\n"
    "until: 0.1\n";

static struct kith_symmetry find(int n, const char *const *more) {
  const char *overrides[8];
  char dimension[32];
  struct kith_scene *scene = NULL;
  struct kith_model *model = NULL;
  struct kith_symmetry symmetry = {.dimension = -1};
  snprintf(dimension, sizeof dimension, "dimension=%d", NDIM);
  overrides[0] = dimension;
  for (int k = 0; k < n; ++k) overrides[k + 1] = more[k];
  CHECK_OK(kith_scene_parse(&scene, "test", plain, strlen(plain), n + 1, overrides));
  CHECK_OK(kith_model_create(&model, scene, NULL, false));
  CHECK_OK(kith_symmetry_find(&symmetry, &model->hydro, &scene->domain));
  kith_model_destroy(&model);
  kith_scene_destroy(&scene);
  return symmetry;
}

/* expected: mirrors as bits, and the dimension in 3-D; in fewer dimensions what is left of both. */
static void expect(int n, const char *const *more, unsigned mirrors, int dimension) {
  const struct kith_symmetry s = find(n, more);
  for (int a = 0; a < NDIM; ++a) CHECK(s.mirrored[a] == (bool)(mirrors >> a & 1));
  CHECK(s.dimension == KITH_MIN(dimension, NDIM));
}

int main(void) {
  expect(0, NULL, 7, 1);                                                        /* uniform */
  expect(1, (const char *[]){"regions.0.pressure='1+0.5*exp(-20*r*r)'"}, 7, 3); /* a ball */
  expect(1, (const char *[]){"regions.0.pressure='x < 0 ? 1 : 0.1'"}, 6, 1);    /* a tube */
  expect(1, (const char *[]){"regions.0.velocity=['-x', '-y', '-z']"}, 7, 3);   /* an implosion */
  expect(1, (const char *[]){"regions.0.velocity=[1, 0, 0]"}, 6, 1);            /* a wind */
  expect(1, (const char *[]){"regions.0.pressure='1+1e-6*x'"}, 6, 1);           /* hardly */
  expect(1, (const char *[]){"regions.0.pressure='1+1e-12*x'"}, 7, 1);          /* round-off */
  expect(1, (const char *[]){"regions.0.jitter=0.2"}, 0, 3);                    /* nothing is left */
  expect(1, (const char *[]){"regions.0.lattice={1d: cubic, 2d: bcc, 3d: bcc}"}, NDIM == 1 ? 7 : 0,
         1); /* rows that alternate */
  if (NDIM > 1) expect(1, (const char *[]){"regions.0.velocity=['-y', 'x', 0]"}, 4, 2); /* a vortex */
  if (NDIM > 2) expect(1, (const char *[]){"regions.0.velocity=[0, 0, 'x']"}, 2, 3);    /* a shear */
  return check_failed();
}
