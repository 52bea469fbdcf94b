/* test_scene_wrong.c - wrong scenes: one message for each error, with its line. */
#include "app/scene/scene.h"
#include <stdio.h>
#include <string.h>
#include "tests/check.h"

static const char *dimension_override(void) {
  return NDIM == 1 ? "dimension=1" : NDIM == 2 ? "dimension=2" : "dimension=3";
}

/* A correct scene. The tables below replace one of its lines, or the empty last one (11); line 2 is the
 * dimension. */
static const char *const lines[] = {
    "scene: base",
    "dimension: {1d: 1, 2d: 2, 3d: 3}",
    "resolution: 20",
    "domain: {lower: [0, 0, 0], upper: [1, 1, 1]}",
    "boundaries: {x: reflecting, y: periodic, z: periodic}",
    "materials: {gas: {gamma: 1.4}}",
    "regions:",
    "  - {material: gas, where: {x: [0, 0.5]}, density: 1, pressure: 1}",
    "  - {material: gas, where: {x: [0.5, 1]}, density: 0.125, pressure: 0.1}",
    "until: 0.2",
    ""};
enum { N_LINES = sizeof lines / sizeof lines[0] };

struct wrong {
  int line;
  const char *text, *message;
};

static void base_with(char *text, size_t size, int line, const char *replacement) {
  size_t used = 0;
  for (int i = 0; i < N_LINES; ++i)
    used += (size_t)snprintf(text + used, size - used, "%s\n", i + 1 == line ? replacement : lines[i]);
}

static void refuse(const struct wrong *wrong, int n) {
  for (int i = 0; i < n; ++i) {
    char text[4096];
    struct kith_scene *scene;
    base_with(text, sizeof text, wrong[i].line, wrong[i].text);
    check_message(wrong[i].text, kith_scene_parse(&scene, "f", text, strlen(text), 0, NULL),
                  wrong[i].message);
    CHECK(scene == NULL);
  }
}
#define REFUSE(table) refuse(table, sizeof(table) / sizeof(table)[0])

static const struct wrong keys[] = {
    {1, "scen: base", "f:1: scen: unknown key; did you mean 'scene'?"},
    {11, "output: {plot: maybe}", "f:11: output.plot: 'maybe' is not one of true, false"},
    {11, "output: {plot: {kind: maps}}",
     "f:11: output.plot.kind: 'maps' is not one of auto, profile, radial, map, slice; did you mean 'map'?"},
    {11, "output: {plot: {field: [density, colour]}}",
     "f:11: output.plot.field.1: 'colour' is not one of density, density-error, velocity, "
     "velocity-error, pressure, pressure-error, "
     "energy, energy-error, velocity-x, velocity-x-error, velocity-y, velocity-y-error, velocity-z, "
     "velocity-z-error"},
    {11, "output: {plot: {field: density-error}}",
     "f:11: output.plot.field: an error, and the scene has no exact solution"},
    {11, "output: {plot: {plane: {x: 1, y: 0}}}",
     "f:11: output.plot.plane: one axis, across which the plane is"},
    {11, "outputs: {}", "f:11: outputs: unknown key; did you mean 'output'?"},
    {11, "method: {kernl: cubic}", "f:11: method.kernl: unknown key; did you mean 'kernel'?"},
    {11, "method:\n  package: sph\n  viscosity:\n    alfa: 1",
     "f:14: method.viscosity.alfa: unknown key; did you mean 'alpha'?"},
    {11, "scheme: {order_of_accuracy: 2}", "f:11: scheme.order_of_accuracy: unknown key; known are name, "},
    {8, "  - {material: gas, densty: 1}", "f:8: regions.0.densty: unknown key; did you mean 'density'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {insid: 1}}",
     "f:8: regions.0.where.insid: unknown key; did you mean 'inside'?"},
    {11, "method: {traversal: pairs}",
     "f:11: method.traversal: not a key of method, but of the scene itself"},
    {11, "alpha: 2", "f:11: alpha: not a key of the scene itself, but of method.viscosity"},
    {11, "package: crk",
     "f:11: package: not a key of the scene itself, but of method; did you mean 'packages'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, gamma: 1.4}",
     "f:8: regions.0.gamma: not a key of regions.0, but of materials.NAME, exact"},
    {5, "boundaries: {w: open}", "f:5: boundaries.w: unknown key; known are x, y, z"},
    {6, "materials: {gas: {gama: 1.4}}", "f:6: materials.gas.gama: unknown key; did you mean 'gamma'?"},
    {11, "energy: {enrgy: 1}", "f:11: energy.enrgy: unknown key; did you mean 'energy'?"},
    {11, "exact: {name: riemann, windw: {}}", "f:11: exact.windw: unknown key; did you mean 'window'?"},
    {3, "resolution: {1d: 1, 2d: 1, 3d: 1, 4d: 1}",
     "f:3: resolution.4d: unknown key; 1d, 2d and 3d tell dimensions apart"},
    {11, "until: 3", "f:11: until: duplicate key, first on line 10"},
    {11, "<<: {a: 1}", "f:11: <<: unknown key; known are base, "},
};

#if NDIM == 1
#define DIMENSIONS "1 to "
#elif NDIM == 2
#define DIMENSIONS "2 to "
#else
#define DIMENSIONS ""
#endif
#define PISTON "{kind: piston, velocity: 1}"
static const struct wrong forces[] = {
    {11, "gravity: -0.5", "f:11: gravity: '-0.5' where a list belongs"},
    {11, "gravity: [0, g, 0]", "f:11: gravity.1: 'g' is not a number"},
#if NDIM == 1
    {11, "gravity: [0, -0.5, 0]", "f:11: gravity: -0.5 along y: there is no such axis in 1-D"},
#else
    {11, "gravity: [0, -0.5, 0]", "f:11: gravity: -0.5 along y, which is periodic: gas would fall for ever"},
#endif
#if NDIM == 2
    {11, "gravity: [0, 0, 9.81]", "f:11: gravity: 9.81 along z: there is no such axis in 2-D"},
#endif
    {11, "potential: {mass: -1}", "f:11: potential.mass: -1 is out of range [0, inf)"},
    {11, "potential: {mass: 1, softening: -0.1}", "f:11: potential.softening: -0.1 is out of range [0, inf)"},
    {11, "potential: {mas: 1}", "f:11: potential.mas: unknown key; did you mean 'mass'?"},
    {5, "boundaries: {x: periodic}\npotential: {mass: 1}",
     "f:6: potential: its force does not repeat, but the domain does along x"},
    {5, "boundaries: {x: piston}", "f:5: boundaries.x: a piston has a velocity: {kind: piston, velocity: 1}"},
    {5, "boundaries: {x: [{kind: piston}, open]}", "f:5: boundaries.x.0.velocity: missing; it is required"},
    {5, "boundaries: {x: [{kind: piston, speed: 1}, open]}",
     "f:5: boundaries.x.0.speed: unknown key; known are kind, "},
    {5, "boundaries: {x: {kind: open, velocity: 1}}",
     "f:5: boundaries.x.velocity: means nothing for open, only for piston, inflow"},
    {5, "boundaries: {x: " PISTON "}",
     "f:5: boundaries.x: piston on both sides; it may be on one, opposite to an open one"},
    {5, "boundaries: {x: [" PISTON ", " PISTON "]}",
     "f:5: boundaries.x: piston on both sides; it may be on one, opposite to an open one"},
    {11, "probes: [{name: a, at: [0, 0, 0]}]\nconnectivity: {storage: half}",
     "f:12: connectivity.storage: half keeps half of the neighbors of a node, and lists of probes and "
     "contacts need all"},
    {5,
     "boundaries: {x: {kind: periodic, images: shifts}}\nprobes: [{name: a, at: [0, 0, 0]}]\n"
     "connectivity: {storage: \"padded:width=9\"}",
     "f:7: connectivity.storage: padded holds no images that are shifts (boundaries.x): take csr"},
    {5, "boundaries: {x: [" PISTON ", reflecting]}",
     "f:5: boundaries.x: a piston with reflecting on the other side: that must be open, or what the piston "
     "does could not be told from it; a region with barrier: true at its end closes a tube"},
    {5, "boundaries: {x: [{kind: piston, velocity: 6}, open]}",
     "f:5: boundaries.x: a piston with velocity 6 is through the domain at time 0.166667, and the run "
     "goes until 0.2"},
    {5, "boundaries: {x: [open, {kind: piston, velocity: -6}]}",
     "f:5: boundaries.x: a piston with velocity -6 is through the domain at time 0.166667, and the run "
     "goes until 0.2"},
    {5, "boundaries: {x: [" PISTON ", open]}\ngravity: [1, 0, 0]",
     "f:6: gravity: not together with a piston along x, whose work could not be told from it"},
    {5, "boundaries: {x: [" PISTON ", open]}\npotential: {mass: 1}",
     "f:6: potential: not together with a piston along x, whose work could not be told from it"},
    {8, "  - {material: gas, density: 1, pressure: 1, displacement: 0.1}",
     "f:8: regions.0.displacement: '0.1' where a list belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, displacement: [0, 0, 0, 0]}",
     "f:8: regions.0.displacement: 4 entries, wanted " DIMENSIONS "3"},
};

static const struct wrong missing[] = {
    {2, "", "f:1: dimension: missing; it is required"},
    {3, "", "f:1: resolution: missing; it is required"},
    {3, "resolution:", "f:1: resolution: missing; it is required"},
    {4, "", "f:1: domain: missing; it is required"},
    {4, "domain: {upper: [1, 1, 1]}", "f:4: domain.lower: missing; it is required"},
    {6, "", "f:1: materials: missing; it is required"},
    {6, "materials: {}", "f:6: materials: no material; one is required"},
    {10, "", "f:1: until: missing; it is required"},
    {8, "  - {density: 1, pressure: 1}", "f:8: regions.0.material: missing; it is required"},
    {9, "  - {material: gas, pressure: 1}", "f:9: regions.1.density: missing; it is required"},
    {9, "  - {material: gas, density: 1}",
     "f:9: regions.1.pressure: missing; pressure or energy is required"},
    {8, "  - {material: gas, density: 1, energy: 1, equilibrium: true}",
     "f:8: regions.0.equilibrium: needs pressure, not energy"},
    {8, "  - {material: gas, density: 1, pressure: 1, equilibrium: true, frozen: true}",
     "f:8: regions.0.equilibrium: not together with frozen: their density stays as given"},
    {8, "  - {material: gas, density: 1, pressure: 1, barrier: true, velocity: [1, 0, 0]}",
     "f:8: regions.0.velocity: not together with barrier, which is a wall at rest"},
    {8, "  - {material: gas, density: 1, pressure: 1, frozen: true, velocity: [1, 0, 0]}",
     "f:8: regions.0.velocity: not together with frozen: its nodes never move; leave it out, or set it to 0"},
    {11, "energy: {center: [0, 0, 0]}", "f:11: energy.energy: missing; it is required"},
    {11, "energy: [{energy: 1, over: ball}]",
     "f:11: energy.0.radius: missing; radius or spacings is required"},
    {11, "exact: {}", "f:11: exact.name: missing; it is required"},
    {11, "packages: [{name: conduction}]", "f:11: packages.0.conductivity: missing; it is required"},
    {11, "packages: [{name: conduction, conductivity: -1}]",
     "f:11: packages.0.conductivity: -1 is out of range [0, inf)"},
    {11, "packages: [{name: conduction, conductivity: [1, -2]}]",
     "f:11: packages.0.conductivity.1: -2 is out of range [0, inf)"},
    {11, "packages: [{name: conduction, conductivity: 1}, {name: conduction, conductivity: 1}]",
     "f:11: packages.1.name: conduction is in the list twice"},
    {11, "packages: [{name: crk}]",
     "f:11: packages.0.name: crk is a hydro package; a run has one, which method.package chooses"},
    {11, "packages: [{conductivity: 1}]", "f:11: packages.0.name: missing; it is required"},
    {11, "packages: [conduction]",
     "f:11: packages.0: 'conduction' where a map belongs; write {name: conduction}"},
    {11, "packages: {name: conduction}", "f:11: packages: a map where a list belongs"},
    {11, "exact: {name: sedov}", "f:11: exact.blast_energy: missing; it does not follow from this scene"},
    {11, "exact: {name: acoustic_wave}", "f:11: exact.density: missing; it is required"},
};

static const struct wrong types[] = {
    {3, "resolution: many", "f:3: resolution: 'many' is not a number"},
    {3, "resolution: 20 cells", "f:3: resolution: '20 cells' is not a number"},
    {3, "resolution: ''", "f:3: resolution: '' is not a number"},
    {3, "resolution: [20]", "f:3: resolution: a list where a single value belongs"},
    {3, "resolution: {1d: [2], 2d: [2], 3d: [2]}", "f:3: resolution.1d: a list where a single value belongs"},
    {3, "resolution: {1d: 2*x, 2d: 2*x, 3d: 2*x}",
     "f:3: resolution.1d: '2*x' is not a number: it has variables, or is not finite"},
    {3, "resolution: 1/0", "f:3: resolution: '1/0' is not a number: it has variables, or is not finite"},
    {3, "resolution: 20/", "f:3: resolution: '20/' is not a number"},
    {3, "resolution: 1-3/2", "f:3: resolution: -0.5 is out of range (0, inf)"},
    {2, "dimension: 2.5", "f:2: dimension: '2.5' is not a whole number"},
    {2, "dimension: two", "f:2: dimension: 'two' is not a number"},
    {2, "dimension: 4/2", "f:2: dimension: '4/2' is not a number"},
    {1, "scene: {a: 1}", "f:1: scene.a: unknown key; 1d, 2d and 3d tell dimensions apart"},
    {4, "domain: [0, 1]", "f:4: domain: a list where a map belongs"},
    {4, "domain: 1", "f:4: domain: '1' where a map belongs; its keys are lower, upper, across"},
    {4, "domain: {lower: 0, upper: [1, 1, 1]}", "f:4: domain.lower: '0' where a list belongs"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, a]}", "f:4: domain.upper.2: 'a' is not a number"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, ~]}", "f:4: domain.upper.2: has no value"},
    {5, "boundaries: reflecting", "f:5: boundaries: 'reflecting' where a map belongs; its keys are x, y, z"},
    {5, "boundaries: {x: {lower: open}}",
     "f:5: boundaries.x.lower: not a key of boundaries.x, but of domain"},
    {5, "boundaries: {x: [open]}", "f:5: boundaries.x: 1 entries, wanted [lower, upper]"},
    {6, "materials: [gas]", "f:6: materials: a list where a map belongs"},
    {6, "materials: {gas: ideal}", "f:6: materials.gas: 'ideal' where a map belongs; write {eos: ideal}"},
    {8, "  - gas",
     "f:8: regions.0: 'gas' where a map belongs; its keys are material, where, lattice, "
     "jitter, seed, density, pressure, energy, velocity, displacement, spacing, frozen, barrier, porosity, "
     "damage, equilibrium"},
    {8, "  -", "f:8: regions.0: '' where a map belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: [0, 1]}",
     "f:8: regions.0.where: a list where a map belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: 0}}",
     "f:8: regions.0.where.x: '0' where a list belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: [0, 1, 2]}}",
     "f:8: regions.0.where.x: 3 entries, wanted 2"},
    {8, "  - {material: gas, density: [1], pressure: 1}",
     "f:8: regions.0.density: a list where a single value belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, velocity: [x<0 ? -1 : 1, 0, 0]}",
     "f:8: regions.0.velocity.0: a map where a single value belongs (a formula with a colon needs quotes)"},
    {8, "  - {material: gas, density: 1, pressure: 1, velocity: 1}",
     "f:8: regions.0.velocity: '1' where a list belongs"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: 1e3}",
     "f:8: regions.0.seed: '1e3' is not a whole number"},
    {8, "  - {material: gas, density: 1, pressure: 1, frozen: 1}",
     "f:8: regions.0.frozen: '1' is not one of true, false"},
    {11, "method: [sph]", "f:11: method: a list where a map belongs"},
    {11, "method: {viscosity: limited}",
     "f:11: method.viscosity: 'limited' where a map belongs; its keys are name, balsara, alpha, beta"},
    {11, "reproducible: treu", "f:11: reproducible: 'treu' is not one of true, false; did you mean 'true'?"},
    {11, "exact: riemann", "f:11: exact: 'riemann' where a map belongs; write {name: riemann}"},
    {11, "exact: {name: riemann, density: [1, 2, 3]}", "f:11: exact.density: 3 entries, wanted 2"},
    {11, "output: {checkpoint: 0.5}", "f:11: output.checkpoint: '0.5' is not a whole number"},
};

static const struct wrong ranges[] = {
    {2, "dimension: 4", "f:2: dimension: 4 is out of range [1, 3]"},
    {3, "resolution: 0", "f:3: resolution: 0 is out of range (0, inf)"},
    {3, "resolution: -20", "f:3: resolution: -20 is out of range (0, inf)"},
    {3, "resolution: .nan", "f:3: resolution: .nan is not a finite number"},
    {3, "resolution: .inf", "f:3: resolution: .inf is not a finite number"},
    {3, "resolution: nan", "f:3: resolution: nan is not a finite number"},
    {3, "resolution: 1e999", "f:3: resolution: 1e999 is not a finite number"},
    {10, "until: -1", "f:10: until: -1 is out of range [0, inf)"},
    {10, "until: -.inf", "f:10: until: -.inf is not a finite number"},
    {4, "domain: {lower: [0, 0, 0], upper: [0, 1, 1]}", "f:4: domain.upper: 0 along x is not above lower, 0"},
    {4, "domain: {lower: [2, 0, 0], upper: [1, 1, 1]}", "f:4: domain.upper: 1 along x is not above lower, 2"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, .inf]}",
     "f:4: domain.upper.2: .inf is not a finite number"},
    {4, "domain: {lower: [0, 0, 0], upper: [1, 1, 1], across: 0}",
     "f:4: domain.across: 0 is out of range [1, inf)"},
    {6, "materials: {gas: {gamma: 1}}", "f:6: materials.gas.gamma: 1 is out of range (1, inf)"},
    {6, "materials: {gas: {eos: isothermal, sound_speed: 0}}",
     "f:6: materials.gas.sound_speed: 0 is out of range (0, inf)"},
    {6, "materials: {gas: {}, a-name-that-is-longer-than-any-other: {}}",
     "f:6: materials.a-name-that-is-longer-than-any-other: a name longer than 31 letters"},
    {6, "materials: {\"gas,air\": {}}",
     "f:6: materials.gas,air: a name has no spaces and none of , ; : = | \" ' /"},
    {8, "  - {material: gas, density: 0, pressure: 1}", "f:8: regions.0.density: 0 is out of range (0, inf)"},
    {8, "  - {material: gas, density: 1e999, pressure: 1}",
     "f:8: regions.0.density: 1e999 is not a finite number"},
    {8, "  - {material: gas, density: 1, pressure: .nan}",
     "f:8: regions.0.pressure: .nan is not a finite number"},
    {8, "  - {material: gas, density: 1, energy: -2}", "f:8: regions.0.energy: -2 is out of range [0, inf)"},
    {8, "  - {material: gas, density: 1, pressure: -1}",
     "f:8: regions.0.pressure: -1 needs a negative energy, -2.5"},
    {6, "materials: {gas: {eos: isothermal, sound_speed: 2}}",
     "f:8: regions.0.pressure: 1 cannot be set: eos isothermal has 4 at this density; give that, or energy: "
     "0"},
    {8, "  - {material: gas, density: 1, pressure: 1, jitter: 0.6}",
     "f:8: regions.0.jitter: 0.6 is out of range [0, 0.5]"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: -1}",
     "f:8: regions.0.seed: -1 is out of range [0, inf)"},
    {8, "  - {material: gas, density: 1, pressure: 1, seed: 99999999999999999999}",
     "f:8: regions.0.seed: 99999999999999999999 does not fit a 64-bit integer"},
    {8, "  - {material: gas, density: 1, pressure: 1, where: {x: [1, 1]}}",
     "f:8: regions.0.where.x: [1, 1] is empty: the first must be below the second"},
    {11, "scheme: {cfl: -1}", "f:11: scheme.cfl: -1 is out of range [0, 1000]"},
    {11, "scheme: {cfl: 1000.1}", "f:11: scheme.cfl: 1000.1 is out of range [0, 1000]"},
    {11, "method: {neighbors: -4}", "f:11: method.neighbors: -4 is out of range [0, 1000]"},
    {11, "connectivity: {reorder: 9999999999}",
     "f:11: connectivity.reorder: 9999999999 does not fit a 32-bit integer"},
    {11, "connectivity: {skin: -1}", "f:11: connectivity.skin: -1 is out of range [0, inf)"},
    {11, "energy: {energy: -1}", "f:11: energy.energy: -1 is out of range [0, inf)"},
    {11, "exact: {name: riemann, gamma: [1.4, 1]}",
     "f:11: exact: exact solution riemann: gamma[1] is 1, which only barotropic gases have"},
    {11, "exact: {name: riemann, window: {r: [-1, 1]}}",
     "f:11: exact.window.r.0: -1 is out of range [0, inf)"},
};

static const struct wrong meanings[] = {
    {5, "boundaries: {x: [periodic, open]}",
     "f:5: boundaries.x: periodic on one side only; it must be on both"},
    {5, "boundaries: {z: [reflecting, periodic]}",
     "f:5: boundaries.z: periodic on one side only; it must be on both"},
    {8, "  - {material: gsa, density: 1, pressure: 1}",
     "f:8: regions.0.material: 'gsa' is not one of gas; did you mean 'gas'?"},
    {8, "  - {material: water, density: 1, pressure: 1}",
     "f:8: regions.0.material: 'water' is not one of gas"},
    {8, "  - {material: gas, density: 1, pressure: 1, lattice: fc}",
     "f:8: regions.0.lattice: 'fc' is not one of cubic, bcc, fcc, hcp, glass; did you mean 'fcc'?"},
    {8, "  - {material: gas, density: 1, pressure: 1, energy: 1}",
     "f:8: regions.0.energy: not together with pressure"},
    {11, "arrangement: equal", "f:11: arrangement: 'equal' is not one of equal-mass, equal-spacing"},
    {11, "traversal: pair", "f:11: traversal: 'pair' is not one of pairs, gather; did you mean 'pairs'?"},
    {11, "method: {energy: thermals}",
     "f:11: method.energy: 'thermals' is not one of thermal, compatible; did you mean 'thermal'?"},
    {11, "method: {viscosity: {name: limted}}",
     "f:11: method.viscosity.name: 'limted' is not one of none, monaghan, limited, cullen-dehnen; did you "
     "mean 'limited'?"},
    {11, "connectivity: {contacts: [{of: gas, with: iron}]}",
     "f:11: connectivity.contacts.0.with: 'iron' is not one of gas"},
    {11, "connectivity: {contacts: [{of: gas, with: gas}]}",
     "f:11: connectivity.contacts.0.with: contacts are between two materials"},
    {11, "probes: [{at: [0, 0, 0]}]", "f:11: probes.0.name: missing; it is required"},
    {11, "probes: [{name: a, at: [0, 0, 0]}, {name: a, at: [0, 0, 0]}]",
     "f:11: probes.1.name: there are two probes 'a'"},
    {11, "probes: [{name: a/b, at: [0, 0, 0]}]",
     "f:11: probes.0.name: 'a/b' cannot name a group: no '/', no '.' in front, no quotes, "
     "no control characters"},
    {11, "probes: [{name: ., at: [0, 0, 0]}]",
     "f:11: probes.0.name: '.' cannot name a group: no '/', no '.' in front, no quotes, "
     "no control characters"},
    {11, "probes: [{name: a, at: [0, 0, 0], plot: [density-error]}]",
     "f:11: probes.0.plot: an error, and the scene has no exact solution"},
    {11, "probes: [{name: a, at: [0, 0, 0], plot: no}]",
     "f:11: probes.0.plot: 'no' is not one of density, density-error, velocity, "
     "velocity-error, pressure, pressure-error, "
     "energy, energy-error, velocity-x, velocity-x-error, velocity-y, velocity-y-error, velocity-z, "
     "velocity-z-error"},
    {11, "probes: [{name: a, at: [0, 0, 0], along: [1, 0, 0], spacing: 1e-9}]",
     "f:11: probes.0: more than 10000000 points"},
    {11, "neighbor: {storage: crs}", "f:11: neighbor.storage: 'crs' is not one of csr; did you mean 'csr'?"},
    {11, "energy: {energy: 1, over: bal, radius: 1}",
     "f:11: energy.over: 'bal' is not one of point, ball, kernel; did you mean 'ball'?"},
    {11, "energy: {energy: 1, radius: 1}",
     "f:11: energy.radius: means nothing for a point; add over: ball or kernel"},
    {11, "energy: {energy: 1, over: ball, radius: 1, spacings: 1}",
     "f:11: energy.spacings: not together with radius"},
};

/* Messages whose text depends on the dimension, or on lists that grow: only their beginning and a part are
 * checked. */
static void refused_at(int line, const char *replacement, const char *start, const char *part) {
  char text[4096];
  struct kith_scene *scene;
  base_with(text, sizeof text, line, replacement);
  CHECK_STATUS(KITH_BAD_INPUT, kith_scene_parse(&scene, "f", text, strlen(text), 0, NULL));
  CHECK(check_says(start) && strncmp(kith_failure(), start, strlen(start)) == 0 && check_says(part));
}

static void refused_elsewhere(void) {
  refused_at(4, "domain: {lower: [0, 0, 0], upper: [1, 1, 1, 1]}", "f:4: domain.upper: 4 entries, wanted ",
             "3");
  refused_at(4, "domain: {lower: [], upper: [1, 1, 1]}", "f:4: domain.lower: 0 entries, wanted ", "3");
  refused_at(5, "boundaries: {y: periodik}", "f:5: boundaries.y: 'periodik' is not one of open, ",
             "; did you mean 'periodic'?");
  refused_at(5, "boundaries: {x: constant}", "f:5: boundaries.x: 'constant' is not one of open, ",
             "periodic");
  refused_at(8, "  - {material: gas, density: 1, pressure: 1, velocity: [1, 0, 0, 0]}",
             "f:8: regions.0.velocity: 4 entries, wanted ", "3");
  refused_at(8, "  - {material: gas, density: '1 +', pressure: 1}", "f:8: regions.0.density: formula '1 +'",
             "");
  refused_at(8, "  - {material: gas, density: q, pressure: 1}", "f:8: regions.0.density: formula 'q'", "");
  refused_at(8, "  - {material: gas, density: '', pressure: 1}", "f:8: regions.0.density: formula ''", "");
  refused_at(8, "  - {material: gas, density: 1, pressure: 1, velocity: [x, y, 'z)']}",
             "f:8: regions.0.velocity.2: formula 'z)'", ""); /* also beyond the dimension */
  refused_at(8, "  - {material: gas, density: 1, pressure: 1,\n     where: {inside: 'x <'}}",
             "f:9: regions.0.where.inside: formula 'x <'", "");
  refused_at(11, "exact: {name: noh}", "f:11: exact.velocity: missing", "");
  refused_at(5, "boundaries: {x: [{kind: pistn, velocity: 1}, open]}",
             "f:5: boundaries.x.0.kind: 'pistn' is not one of ", "did you mean 'piston'?");
  refused_at(6, "materials: {gas: {eos: idael}}", "f:6: materials.gas.eos: 'idael' is not one of ",
             "did you mean 'ideal'?");
  refused_at(11, "connectivity: {rebuild: always | nevr}",
             "f:11: connectivity.rebuild: 'nevr' is not one of ", "did you mean 'never'?");
  refused_at(11, "connectivity: {rebuild: always |}", "f:11: connectivity.rebuild: '' is not one of ", "");
  refused_at(11, "connectivity: {rebuild: always never}",
             "f:11: connectivity.rebuild: 'always never' is not one of ", "");
  refused_at(11, "connectivity: {exclude: selves}", "f:11: connectivity.exclude: 'selves' is not one of ",
             "");
  refused_at(11, "connectivity: {storage: compresed}",
             "f:11: connectivity.storage: 'compresed' is not one of ", "did you mean 'compressed'?");
  refused_at(11, "exact: {name: reimann}", "f:11: exact.name: 'reimann' is not one of ",
             "did you mean 'riemann'?");
  refused_at(11, "neighbor: {search: tre}", "f:11: neighbor.search: 'tre' is not one of ",
             "did you mean 'tree'?");
  refused_at(11, "exact: {name: riemann, density: 1, pressure: [-1, 0]}",
             "f:11: exact: exact solution riemann: pressure[0] is -1, must be at least -stiffness, 0", "");
}

static void refuses_long_formulas(void) {
  char line[2048] = "  - {material: gas, pressure: 1, density: '1";
  for (int i = 0; i < 500; ++i) strcat(line, "+1");
  strcat(line, "'}");
  refused_at(8, line, "f:8: regions.0.density: a formula of more than 1000 characters", "");
}

static void refuses_overrides(void) {
  char text[4096];
  base_with(text, sizeof text, 11, "");
  struct kith_scene *scene;
  const char *wrong = NDIM == 1 ? "dimension=2" : "dimension=1",
             *overrides[] = {wrong, "q=1", "until", "until=-3"};
  char wanted[128];
  snprintf(wanted, sizeof wanted, "--set dimension: %c, but this program is the %d-D one", wrong[10], NDIM);
  check_message(wrong, kith_scene_parse(&scene, "f", text, strlen(text), 1, overrides), wanted);
  overrides[0] = dimension_override();
  check_message("q", kith_scene_parse(&scene, "f", text, strlen(text), 2, overrides),
                "--set q: unknown key; known are base, ");
  overrides[1] = "untill=1";
  check_message("untill", kith_scene_parse(&scene, "f", text, strlen(text), 2, overrides),
                "--set untill: unknown key; did you mean 'until'?");
  check_message("until", kith_scene_parse(&scene, "f", text, strlen(text), 1, overrides + 2),
                "--set until: write it as key=value");
  overrides[2] = dimension_override();
  check_message("until", kith_scene_parse(&scene, "f", text, strlen(text), 2, overrides + 2),
                "--set until: -3 is out of range [0, inf)");
  overrides[3] = "regions=[]";
  check_message("regions", kith_scene_parse(&scene, "f", text, strlen(text), 2, overrides + 2),
                "--set regions: no region; one is required");
}

static void refuses_by_dimension(void) {
  if (NDIM == 2)
    refused_at(9, "  - {material: gas, density: 1, pressure: 1,\n     lattice: fcc}",
               "f:10: regions.1.lattice: fcc does not exist in 2-D; cubic, bcc, hcp and glass do", "");
  refused_at(3, NDIM == 1 ? "resolution: {2d: 1}" : "resolution: {1d: 1}",
             NDIM == 1   ? "f:3: resolution.1d: missing, and the scene is 1-D"
             : NDIM == 2 ? "f:3: resolution.2d: missing, and the scene is 2-D"
                         : "f:3: resolution.3d: missing, and the scene is 3-D",
             "");
  if (NDIM > 1)
    refused_at(4, "domain: {lower: [0, 0, 0], upper: [1, 0, 0]}",
               "f:4: domain.upper: 0 along y is not above lower, 0", "");
}

int main(void) {
  REFUSE(keys);
  REFUSE(missing);
  REFUSE(forces);
  REFUSE(types);
  REFUSE(ranges);
  REFUSE(meanings);
  refused_elsewhere();
  refuses_long_formulas();
  refuses_overrides();
  refuses_by_dimension();
  return check_failed();
}
