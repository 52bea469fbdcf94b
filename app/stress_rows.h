/* stress_rows.h - the sweeps and the methods. Private to stress.c.
 *
 *   name, knob, scene, dimension, settings, metric, gate, bound, reason of the gate, ladder from mild to hard
 *
 * Settings are those of --set, parted by blanks, so their values have none. */
#define X(name) {#name, "method.package=" #name},
const struct kith_stress_method kith_stress_methods[] = {
    KITH_PACKAGE_LIST(X) /* each with its defaults */
    {"sph alpha 1", "method.package=sph method.viscosity.name=monaghan"},
    {"sph switch", "method.package=sph method.viscosity.name=cullen-dehnen"},
    {"mfm closed", "method.package=mfm method.closed=true"},
    {"mfm integrated", "method.package=mfm method.faces=integrated"},
};
#undef X
const int kith_n_stress_methods = sizeof kith_stress_methods / sizeof *kith_stress_methods;

#define RUNG(x, settings) \
  { x, NULL, settings }
#define CFL(x) \
  { x, NULL, "scheme.cfl=" #x }
#define NEIGHBORS(x) \
  { x, NULL, "method.neighbors=" #x }
#define JITTER(x) \
  { x, NULL, "regions.0.jitter=" #x }
#define CFL_LADDER \
  { CFL(0.1), CFL(0.2), CFL(0.3), CFL(0.45), CFL(0.6), CFL(0.8), CFL(1) }
#define NEIGHBORS_LADDER                                                                                     \
  {                                                                                                          \
    NEIGHBORS(12), NEIGHBORS(16), NEIGHBORS(20), NEIGHBORS(28), NEIGHBORS(40), NEIGHBORS(60), NEIGHBORS(90), \
        NEIGHBORS(130)                                                                                       \
  }
/* A tube with both sides at density 1 and the same state but for what a rung says. */
#define TUBE "resolution=200 regions.0.density=1 regions.1.density=1 "
#define CONTACT "resolution=100 regions.0.pressure=1 regions.1.pressure=1 "
#define DENSITY(x) \
  { x, NULL, "regions.1.density=1/" #x }
#define DENSITY_LADDER                                                                                   \
  {                                                                                                      \
    {1, NULL, "regions.1.density=1"}, DENSITY(1.1), DENSITY(1.25), DENSITY(1.5), DENSITY(2), DENSITY(4), \
        DENSITY(8), DENSITY(64), DENSITY(1000)                                                           \
  }
#define PRESSURE(x, p) \
  { x, NULL, "regions.1.pressure=" #p }
#define APART(x, u) \
  { x, NULL, "regions.0.velocity=[-" #u ",0,0] regions.1.velocity=[" #u ",0,0]" }
#define MACH(x, p) \
  { x, NULL, "regions.0.pressure=" #p " regions.1.pressure=" #p }
#define SWIRL "*(x^2+y^2<0.04?5:x^2+y^2<0.16?2/sqrt(x^2+y^2)-5:0)"
#define BOOST(v) \
  { v, NULL, "exact.uniform_velocity=[" #v ",0,0] regions.0.velocity=['" #v "-y" SWIRL "','x" SWIRL "',0]" }
#define SHEAR(v) \
  { v, NULL, "regions.0.velocity=['" #v "*sin(2*pi*y)',0,0]" }
#define SIDE(n) \
  { n, NULL, "resolution=" #n }
#define PAIR(k, energy, balsara, kernel)                                                      \
  {                                                                                           \
    k, energy " " balsara " " kernel,                                                         \
        "method.energy=" energy " method.viscosity.balsara=" balsara " method.kernel=" kernel \
  }

/* clang-format off */
const struct kith_sweep kith_sweeps[] = {
    {"cfl-sod", "Courant number", "sod", 1, "resolution=100", "density.l1", KITH_OF_FIRST, 1.1,
     "steps add less than a tenth to the error of the nodes", CFL_LADDER},
    {"cfl-sedov", "Courant number", "sedov", 2, "resolution=32", "shock", KITH_OF_FIRST, 1.1,
     "steps add less than a tenth to the error of the nodes", CFL_LADDER},
    {"cfl-gresho", "Courant number", "gresho", 2, "resolution=32 until=1", "speed.l1", KITH_OF_FIRST, 1.1,
     "steps add less than a tenth to the error of the nodes", CFL_LADDER},
    {"neighbors-cubic", "neighbors", "noisy-box", 2, "resolution=24 method.kernel=cubic", "velocity_over_sound.end", KITH_AT_MOST,
     0.02, "noise has died out after five crossings of sound", NEIGHBORS_LADDER},
    {"neighbors-quintic", "neighbors", "noisy-box", 2, "resolution=24 method.kernel=quintic", "velocity_over_sound.end",
     KITH_AT_MOST, 0.02, "noise has died out after five crossings of sound", NEIGHBORS_LADDER},
    {"neighbors-wendland-c2", "neighbors", "noisy-box", 2, "resolution=24 method.kernel=wendland-c2", "velocity_over_sound.end",
     KITH_AT_MOST, 0.02, "noise has died out after five crossings of sound", NEIGHBORS_LADDER},
    {"jitter-box", "jitter (spacings)", "noisy-box", 2, "resolution=24 until=1 regions.0.equilibrium=true",
     "velocity_over_sound.largest", KITH_AT_MOST, 0.05, "uniform pressure moves nothing beyond 5 % of sound",
     {RUNG(0, "regions.0.jitter=0"), JITTER(0.05), JITTER(0.1), JITTER(0.2), JITTER(0.3), JITTER(0.45)}},
    {"jitter-wave", "jitter (spacings)", "acoustic-wave", 1, "regions.0.equilibrium=true", "velocity.l1", KITH_AT_MOST, 1e-7,
     "a tenth of the wave's amplitude",
     {RUNG(0, "regions.0.jitter=0"), JITTER(0.05), JITTER(0.1), JITTER(0.2), JITTER(0.3)}},
    {"density-equal-mass", "density ratio", "sod", 1, CONTACT "arrangement=equal-mass", "pressure.linf", KITH_AT_MOST, 0.1,
     "a contact at rest keeps its pressure to 10 %", DENSITY_LADDER},
    {"density-equal-spacing", "density ratio", "sod", 1, CONTACT "arrangement=equal-spacing", "pressure.linf", KITH_AT_MOST, 0.1,
     "a contact at rest keeps its pressure to 10 %", DENSITY_LADDER},
    {"pressure-ratio", "pressure ratio", "sod", 1, TUBE "regions.0.pressure=1 until=0.35", "shock", KITH_AT_MOST, 0.05,
     "the shock is where it belongs to 5 %",
     {PRESSURE(10, 0.1), PRESSURE(100, 1.0e-2), PRESSURE(1e3, 1.0e-3), PRESSURE(1e4, 1.0e-4), PRESSURE(1e5, 1.0e-5),
      PRESSURE(1e7, 1.0e-7), PRESSURE(1e9, 1.0e-9)}},
    {"leblanc", "nodes per unit length", "sod", 1,
     "arrangement=equal-spacing materials.gas.gamma=1.6666666666666667 regions.1.density=1.0e-3 "
     "regions.0.pressure=0.0666666666666667 regions.1.pressure=6.66666666666667e-11 until=0.5",
     "shock", KITH_AT_MOST, 0.06, "the shock, between pressures 1e9 : 1, is where it belongs to 6 %",
     {SIDE(800), SIDE(400), SIDE(200), SIDE(100), SIDE(50)}},
    {"rarefaction", "velocity apart", "sod", 1, TUBE "regions.0.pressure=0.4 regions.1.pressure=0.4 until=0.1", "density.l1",
     KITH_AT_MOST, 0.05, "5 % of the density at the start; a vacuum opens beyond 7.48",
     {APART(1, 0.5), APART(2, 1), APART(4, 2), APART(6, 3), APART(7.2, 3.6), APART(7.86, 3.93)}},
    {"mach", "Mach number of the collision", "sod", 1,
     TUBE "regions.0.velocity=[1,0,0] regions.1.velocity=[-1,0,0] until=0.4 exact.window.x=[-0.3,0.3]", "density.l1",
     KITH_AT_MOST, 0.12, "5 % of the mean density, 2.3",
     {MACH(3, 0.0793650794), MACH(10, 7.14285714e-3), MACH(100, 7.14285714e-5), MACH(1e3, 7.14285714e-7),
      MACH(1e4, 7.14285714e-9)}},
    {"boost", "velocity of the whole", "gresho", 2, "resolution=32 until=1", "speed.l1", KITH_OF_FIRST, 1.01,
     "who moves along sees the same vortex", {BOOST(0), BOOST(1), BOOST(10), BOOST(142)}},
    {"shear", "velocity of the shear over sound", "periodic-drift", 2, "resolution=24 until=1 exact.uniform_velocity=[0,0,0]",
     "kinetic.change", KITH_AT_MOST, 0.1,
     "sliding layers neither lose a tenth of their energy nor make it of heat", {SHEAR(0.03), SHEAR(0.1), SHEAR(0.3), SHEAR(1), SHEAR(3)}},
    {"cells-per-side", "nodes along a periodic side", "periodic-drift", 2, "until=0.1", "density.linf", KITH_OF_FIRST, 1.0001,
     "nobody is counted twice, or left out, in a small box", {SIDE(32), SIDE(16), SIDE(12), SIDE(8), SIDE(6), SIDE(5), SIDE(4), SIDE(3)}},
    {"option-pairs", "options, beside the viscosity of the method", "sedov", 2, "resolution=32", "shock", KITH_AT_MOST, 0.06,
     "a quarter above what the most viscous method has at this resolution: what is beyond has blown up",
     {PAIR(0, "compatible", "none", "wendland-c2"), PAIR(1, "compatible", "none", "quintic"),
      PAIR(2, "compatible", "balsara", "wendland-c2"), PAIR(3, "compatible", "balsara", "quintic"),
      PAIR(4, "compatible", "squared", "wendland-c2"), PAIR(5, "compatible", "squared", "quintic"),
      PAIR(6, "thermal", "none", "wendland-c2"), PAIR(7, "thermal", "none", "quintic"), PAIR(8, "thermal", "balsara", "wendland-c2"),
      PAIR(9, "thermal", "balsara", "quintic"), PAIR(10, "thermal", "squared", "wendland-c2"),
      PAIR(11, "thermal", "squared", "quintic")}},
};
/* clang-format on */
const int kith_n_sweeps = sizeof kith_sweeps / sizeof *kith_sweeps;
