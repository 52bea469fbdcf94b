/* scene.h - a scene file as plain data, checked: what the rest of the program is built from.
 *
 * Read by scene.c through config.h (YAML with line numbers, overrides by --set key=value). Every key is read
 * in exactly one place, with default, range and doc; from that table come the scene reference (kith list
 * scene), and the error messages. Everything that can be wrong in the file is found here, before anything
 * runs; what needs nodes (empty or overlapping regions) in setup.c. Lengths without a unit: the scene's own.
 * Strings are owned by the scene.
 *
 * One file serves all dimensions: vectors may have more entries than NDIM, axes beyond NDIM are ignored, and
 * any single value may be {1d: .., 2d: .., 3d: ..}. A key without a value (`skin:`, `--set skin=`) is as if
 * it were not given.
 *
 * What the exact solution needs is derived from the scene and replaced by what stands under `exact`:
 *   riemann        two regions that touch along x: gamma, density, pressure, velocity of each; the interface between them.
 *                  One region that ends inside of the domain along x, towards an open face: beyond it is a vacuum
 *   sedov          first region; the only deposit: its center, and E 2^(reflecting faces through the center) as the blast energy
 *                  A density that falls: density and omega must be given
 *   noh            first region; the speed at a point away from the center, which is the origin
 *   gresho         gamma and density of the first region; sides of the domain along periodic axes; the center is the origin
 *   yee            gamma of the first region, period as for gresho; amplitude 5
 *   uniform        first region
 *   acoustic-wave  gamma of the first region; wavelength: the length of the domain along x
 *   entropy-wave   the same, and the pressure and velocity of the first region
 *   square         the first of two regions, a box, and the second, what is around it; period as for gresho
 *   two-blasts     gamma of the first region; end_time: until
 * The rest must be given. Only what is constant can be derived. */
#ifndef KITH_APP_SCENE_H
#define KITH_APP_SCENE_H

#include <stdio.h>
#include "app/config.h"
#include "app/expression.h"
#include "boundaries/boundary.h"
#include "lib/core/vec.h"
#include "lib/neighbor/search.h"
#include "physics/eos.h"
#include "physics/package.h"
#include "validation/exact.h"
#include "validation/measure.h"
#include "validation/norms.h"

/* name, word of the scene, doc */
#define KITH_LATTICE_LIST(X)                                                              \
  X(CUBIC, cubic, "squares, cubes: the only one that continues through reflecting faces") \
  X(BCC, bcc, "body-centered cubic; squares on their tips in 2-D")                        \
  X(FCC, fcc, "face-centered cubic; not in 2-D")                                          \
  X(HCP, hcp, "hexagonal close packing; triangles in 2-D")
enum kith_lattice {
#define X(name, word, doc) KITH_LATTICE_##name,
  KITH_LATTICE_LIST(X)
#undef X
};
enum kith_arrangement { KITH_EQUAL_MASS, KITH_EQUAL_SPACING };

/* Where a region is: all given conditions together; none: the whole domain. Faces of boxes are half-open
 * [lower, upper). */
struct kith_where {
  struct kith_box box;         /* infinite where not given */
  bool has_ball, outside_ball; /* ball: inside, or outside of it */
  double center[NDIM], radius;
  bool has_half_space; /* (x - point) . normal >= 0 */
  double point[NDIM], normal[NDIM];
  struct kith_expression *inside; /* nonzero is inside; NULL if not given */
};

/* A number or an expression in x, y, z, r. */
struct kith_region {
  int material; /* index: node list */
  struct kith_where where;
  enum kith_lattice lattice;
  double jitter; /* largest displacement of a node along an axis, in spacings, [0, 0.5] */
  uint64_t seed;
  struct kith_expression *density, *pressure,
      *energy; /* exactly one of pressure and energy; the other NULL */
  struct kith_expression *velocity[NDIM];
  struct kith_expression *displacement[NDIM]; /* of the sites; NULL: they stay */
  double spacing;                             /* 0: from resolution and arrangement */
  bool frozen;                                /* boundary `constant`: its nodes never move */
  bool barrier;                               /* frozen, and a wall between nodes on both sides of it */
  bool equilibrium;                           /* the pressure holds with the density that the package sums */
  struct kith_place place;                    /* line in the file, for messages of setup */
};

enum kith_deposit_shape { KITH_DEPOSIT_POINT, KITH_DEPOSIT_BALL, KITH_DEPOSIT_KERNEL };
struct kith_deposit { /* blast energy added to the nodes around a center, shared by weight; sums exactly to
                         `energy` */
  double energy;      /* in the whole domain, as the sum over its nodes */
  double center[NDIM];
  enum kith_deposit_shape shape;
  double radius;   /* ball, kernel: radius of the support; */
  double spacings; /* instead of radius: in node spacings at the center (kernel: h, the support is 2 h of a
                      cubic spline) */
  struct kith_place place;
};

struct kith_scene {
  struct kith_config *config; /* owned: the places point into it */
  int dimension;              /* NDIM */
  char *name;
  char *text;        /* the effective scene: file with overrides applied, as YAML; what a checkpoint stores */
  double resolution; /* nodes per unit length in the densest region */
  enum kith_arrangement arrangement;
  struct kith_box domain;
  struct {                                         /* per axis */
    const struct kith_boundary_ops *lower, *upper; /* NULL: open */
    double velocity;                               /* of a piston */
  } boundary[NDIM];
  struct kith_body body; /* force from outside */
  int n_materials;
  char material_name[KITH_MAX_LISTS][32];
  struct kith_material material[KITH_MAX_LISTS];
  int n_regions;
  struct kith_region *region;
  int n_deposits;
  struct kith_deposit *deposit;
  struct {
    char package[32], kernel[32];
    double neighbors; /* 0: the default of kernel and dimension */
    bool compatible;  /* energy: compatible | thermal */
    enum kith_viscosity viscosity;
    enum kith_balsara balsara;
    double alpha, beta, conduction;
    enum kith_faces faces;
    bool closed;
  } method;
  struct {
    char name[32], table[32];
    double cfl, dt; /* dt > 0: fixed step */
    bool adaptive, backward_euler;
    double rtol, atol;
  } scheme;
  struct {
    const struct kith_search_ops *search;
  } neighbor;
  struct {
    char rebuild[128];
    double skin; /* < 0: the default of the policy */
    bool cull;
    int reorder; /* steps between reorderings by curve, 0: never */
  } connectivity;
  bool reproducible;
  struct {
    char name[64]; /* and words: lib/domain/partition.h */
    int every, cells;
    double imbalance;
    bool recompute;
  } partition;
  char traversal[16]; /* "", "pairs", "gather" */
  double until;
  struct {
    const struct kith_exact_ops *ops; /* NULL: no exact solution */
    struct kith_exact_parameters parameters;
    struct kith_window window;
  } exact;
  struct {
    bool wanted[KITH_N_MEASURES];
  } measure;
  struct {
    double every; /* time between snapshots, 0: only first and last */
    bool plot;
    int checkpoint; /* steps between checkpoints, 0: only on a signal */
    bool checkpoint_at_end;
  } output;
};

/* Reads and checks. overrides: n strings "key=value" (dotted keys). BAD_INPUT: one line with file:line, key,
 * value, allowed, nearest. */
kith_status kith_scene_read(struct kith_scene **out, const char *path, int n_overrides,
                            const char *const *overrides);
/* The same from memory; `name` stands for the file. */
kith_status kith_scene_parse(struct kith_scene **out, const char *name, const char *text, size_t length,
                             int n_overrides, const char *const *overrides);
void kith_scene_destroy(struct kith_scene **scene);
/* BAD_INPUT if a piston is through the domain before `until`. */
kith_status kith_scene_lasts(const struct kith_scene *scene, double until);
/* Only the key `dimension` (with overrides): what the program `kith` needs to start the right one. */
kith_status kith_scene_dimension(const char *path, int n_overrides, const char *const *overrides,
                                 int *dimension);
/* Families that the scene does not know (method.package, method.kernel, scheme.name): BAD_INPUT at the line
 * of `key`, with the nearest word, unless `value` is one of `words` (words.h). */
kith_status kith_scene_check_word(const struct kith_scene *scene, const char *key, const char *value,
                                  const char *words);
/* Every key with default, range and meaning, as commented YAML. */
void kith_scene_reference(FILE *file);

#endif
