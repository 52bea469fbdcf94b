/* scene_data.h - what a scene says, as plain data: the structs that reading a scene fills.
 *
 * Units are the scene's own. The scene owns strings, expressions and settings, and outlives what it makes. */
#ifndef KITH_APP_SCENE_SCENE_DATA_H
#define KITH_APP_SCENE_SCENE_DATA_H

#include "app/scene/config.h"
#include "app/scene/expression.h"
#include "app/scene/picture.h"
#include "boundaries/flow.h"
#include "lib/core/vec.h"
#include "lib/neighbor/search.h"
#include "physics/eos.h"
#include "physics/package.h"
#include "validation/exact/exact.h"
#include "validation/measure.h"
#include "validation/norms.h"

/* name, word of the scene, doc */
#define KITH_LATTICE_LIST(X)                                                              \
  X(CUBIC, cubic, "squares, cubes: the only one that continues through reflecting faces") \
  X(BCC, bcc, "body-centered cubic; squares on their tips in 2-D")                        \
  X(FCC, fcc, "face-centered cubic; not in 2-D")                                          \
  X(HCP, hcp, "hexagonal close packing; triangles in 2-D")                                \
  X(GLASS, glass,                                                                         \
    "relaxed from random places: no direction is special; whole cells of 10 spacings, to a tenth")
enum kith_lattice {
#define X(name, word, doc) KITH_LATTICE_##name,
  KITH_LATTICE_LIST(X)
#undef X
      KITH_LATTICES
};
extern const char *const kith_lattice_names[];
enum kith_arrangement { KITH_EQUAL_MASS, KITH_EQUAL_SPACING };

/* Where a region is: the places that meet all given conditions; without any, the whole domain. */
struct kith_where {
  double extent[3][2];            /* [lower, upper) along each axis, infinite where not given */
  struct kith_expression *inside; /* nonzero is inside; NULL if not given */
};

/* A part of the domain, and what fills it. Formulas are in x, y, z, r. */
struct kith_region {
  int material; /* index: node list */
  struct kith_where where;
  enum kith_lattice lattice;
  double jitter; /* largest displacement of a node along an axis, in spacings, [0, 0.5] */
  uint64_t seed;
  struct kith_expression *density, *pressure,
      *energy;                                /* exactly one of pressure and energy; the other NULL */
  struct kith_expression *velocity[NDIM];     /* NULL: at rest */
  struct kith_expression *displacement[NDIM]; /* of the lattice sites; NULL: they stay */
  double spacing;                             /* 0: from resolution and arrangement */
  bool frozen;                                /* boundary `constant`: its nodes never move */
  bool barrier;                               /* frozen, and a wall between nodes on both sides of it */
  double porosity;                            /* < 0: not given, which is 0 for a barrier and 1 for others */
  struct kith_expression *damage;             /* NULL: none */
  bool equilibrium; /* energies are set so that `pressure` holds with the density that the package sums */
  const struct kith_config_node *node; /* where it stands, for messages */
};

/* Do its nodes stay where they are? Every rank holds all of them. */
static inline bool kith_region_stays(const struct kith_region *region) {
  return region->frozen || region->barrier;
}

/* Does it damp what passes? Nodes have a field of damage if some region has damage or a porosity. */
static inline bool kith_region_damaged(const struct kith_region *region) {
  return region->porosity >= 0 || region->damage != NULL;
}

static inline double kith_material_pressure(const struct kith_material *material, double density,
                                            double energy) {
  double pressure, sound_speed;
  kith_material_state(material, 1, &density, &energy, &pressure, &sound_speed);
  return pressure;
}
/* Is the pressure the one asked for? Some equations of state take nothing from the energy. */
static inline bool kith_pressure_holds(const struct kith_material *material, double density, double energy,
                                       double asked) {
  return !material->eos->barotropic ||
         !(fabs(kith_material_pressure(material, density, energy) - asked) > 1e-9 * fabs(asked));
}

enum kith_deposit_shape { KITH_DEPOSIT_POINT, KITH_DEPOSIT_BALL, KITH_DEPOSIT_KERNEL };
/* Blast energy added to the nodes around a center, shared by weight. */
struct kith_deposit {
  double energy; /* in the whole domain, as the sum over its nodes */
  double center[NDIM];
  enum kith_deposit_shape shape;
  double radius;   /* ball, kernel: radius of the support */
  double spacings; /* instead of radius, in node spacings at the center: of the ball, or half the support */
  double time;     /* when it is released */
  const struct kith_config_node *node; /* where it stands, for messages */
};

/* Points at + s edge[0] + t edge[1] + u edge[2], with s, t and u from 0 to 1: a point, or the points of a
 * line, a plane or a grid. */
struct kith_probe {
  char name[32];
  double at[NDIM], edge[3][NDIM]; /* a zero edge: none */
  double spacing;                 /* between points, as wanted; 0: 1 / resolution */
  int points[3];                  /* along each edge, 1 where there is none */
  int every;                      /* steps between samples */
  bool gradients;
  struct kith_picture_fields picture;  /* none: no picture */
  const struct kith_config_node *node; /* where it stands, for messages */
};
enum { KITH_MOST_PROBES = 10000000 }; /* points of one probe */
/* Position of point i of a probe; the last edge is the fastest. */
static inline void kith_probe_point(const struct kith_probe *probe, int i, double *x) {
  const int *n = probe->points, at[3] = {i / (n[1] * n[2]), i / n[2] % n[1], i % n[2]};
  for (int a = 0; a < NDIM; ++a) {
    x[a] = probe->at[a];
    for (int k = 0; k < 3; ++k)
      if (n[k] > 1) x[a] += at[k] * probe->edge[k][a] / (n[k] - 1);
  }
}

/* Two materials, by their node lists, whose nodes near each other are counted. */
struct kith_contact {
  int of, with;
};

/* Can powers of lengths and velocities be summed without overflow and underflow, if this is the largest? */
static inline bool kith_scene_unit_holds(double largest) {
  return largest >= 1e-31 && largest <= 1e31;
}

struct kith_scene {
  struct kith_config *config; /* owned: source locations point into it */
  int dimension;              /* NDIM */
  char name[101];
  char *text;        /* the effective scene: file with overrides applied, as YAML; what a checkpoint stores */
  double resolution; /* nodes per unit length in the densest region */
  enum kith_arrangement arrangement;
  struct kith_box domain;
  double period[NDIM]; /* side of the domain along axes that are periodic, else 0 */
  int across;          /* spacings of the domain along the axes other than x; 0: upper as given */
  struct {             /* per axis; [0]: of its lower side, [1]: of the upper one */
    const struct kith_boundary_ops *side[2]; /* NULL: open */
    double face[2];                          /* positions of the faces along the axis */
    void *settings[2];                       /* NULL: none; owned */
    double velocity;                         /* of a face that moves, else 0 */
  } boundary[NDIM];
  bool unsteady; /* the state at the face of an inflow varies with place or time */
  bool follows;  /* window: follow; gas that no signal has reached sleeps */
  struct kith_external_force external_force; /* gravity and point mass */
  int n_materials;
  char material_name[KITH_MAX_LISTS][32];
  struct kith_material material[KITH_MAX_LISTS]; /* settings owned */
  int n_regions;
  struct kith_region *region;
  bool equilibrium; /* some region is in equilibrium */
  int n_deposits;
  struct kith_deposit *deposit;
  struct {
    struct kith_selected package;
    enum kith_kernel kernel;
    double neighbors; /* 0: the default of the package, for the kernel */
    bool compatible;  /* energy: compatible | thermal */
  } method;
  int n_added; /* packages added to the hydro package, in their order */
  struct kith_selected added[KITH_ADDED_PACKAGES + 1]; /* room for one too many, until it is refused */
  struct {
    struct kith_selected member;
    double cfl, dt; /* cfl 0: the default of the package; dt > 0: fixed step */
  } scheme;
  struct {
    struct kith_selected search;
    int storage; /* csr is the only one */
  } neighbor;
  struct {
    char rebuild[128];
    double skin; /* < 0: the default of the policy */
    bool cull;
    int reorder;                    /* lifecycles between reorderings by curve, 0: never */
    char exclude[256], storage[64]; /* lib/connectivity: excluders/excluder.h, storage/storage.h */
  } connectivity;
  int n_contacts;
  struct kith_contact *contact;
  int n_probes;
  struct kith_probe *probe;
  bool reproducible;
  struct {
    struct kith_selected member;
    int every, cells;
    double imbalance;
    bool recompute;
  } partition;
  struct kith_machine {
    double latency, bandwidth; /* of a rank's messages: seconds, bytes a second */
    double collective;         /* seconds of a collective call, for each doubling of the ranks */
    int cores;                 /* 0: as many as ranks */
  } machine;
  char traversal[16]; /* "", "pairs", "gather" */
  double until;
  struct {
    const struct kith_exact_ops *ops; /* NULL: no exact solution */
    const void *settings;             /* owned */
    void *solution;                   /* owned: made with them */
    struct kith_window window;
  } exact;
  struct {
    bool wanted[KITH_N_MEASURES];
    double rate; /* growth rate by linear theory; 0: not known */
  } measure;
  struct {
    double every; /* time between snapshots, 0: only first and last */
    bool plot;
    struct kith_picture picture;
    int checkpoint;            /* steps between checkpoints; 0: by time only */
    double checkpoint_minutes; /* minutes between them; 0: by steps only */
    bool checkpoint_at_end;
  } output;
};

/* The distance of two places by the shortest way, which may pass through periodic faces. If half_axes is not
 * NULL, distances along axis a are in units of half_axes[a]. */
static inline double kith_scene_distance(const struct kith_scene *scene, const double *x, const double *y,
                                         const double *half_axes) {
  double sum = 0;
  for (int a = 0; a < NDIM; ++a) {
    double d = x[a] - y[a];
    if (scene->period[a] > 0) d -= scene->period[a] * round(d / scene->period[a]);
    if (half_axes != NULL) d /= half_axes[a];
    sum += d * d;
  }
  return sqrt(sum);
}

/* Does gas pass a face of this axis? */
static inline bool kith_scene_passes(const struct kith_scene *scene, int axis) {
  return kith_boundary_passes(scene->boundary[axis].side[0]) ||
         kith_boundary_passes(scene->boundary[axis].side[1]);
}

/* The value of boundaries.x, .y or .z in the file, for messages; NULL if it is not given. */
const struct kith_config_node *kith_scene_boundary_node(const struct kith_scene *scene, int axis);
/* Member k of the family of what a side of the domain can be: open, or a boundary that acts on sides. */
struct kith_member kith_scene_side_member(int k);

#endif
