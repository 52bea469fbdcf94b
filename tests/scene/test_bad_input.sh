#!/usr/bin/env bash
# test_bad_input.sh PROGRAMS INPUTS: whatever is wrong with the command line, the scene, the output directory
# or the checkpoint gives one line on stderr and code 2, and nothing is created or changed.
source "$(dirname "$0")/common.sh"

# ---- the command line
refused "no verb; one of run, plan, bench, list" "$kith"
refused "verb 'rum' is not one of run, plan" "$kith" rum tiny.yaml
refused "verb 'xyzzy' is not one of run, plan" "$kith" xyzzy
refused "run: SCENE is missing" "$kith" run
refused "plan: SCENE is missing" "$kith" plan
refused "b: one argument too many" "$kith" run tiny.yaml b
refused "--stesp: unknown option; did you mean '--steps'?" "$kith" run tiny.yaml --stesp 3
refused "--xyzzy: unknown option" "$kith" run tiny.yaml --xyzzy=1
refused "-z: unknown option" "$kith" run tiny.yaml -z
refused "--until: its value is missing" "$kith" run tiny.yaml --until
refused "-o: its value is missing" "$kith" run tiny.yaml -o
for option in output restart trace; do
  refused "kith: --$option: an empty name" "$kith" run tiny.yaml --$option ''
done
refused "kith: run: an empty argument" "$kith" run ''
refused "this option takes no value" "$kith" run tiny.yaml --quiet=yes
refused "--set: 'until' is not KEY=VALUE" "$kith" run tiny.yaml --set until
refused "--set =3: write it as key=value" "$kith" run tiny.yaml --set =3
for bad in nan inf -1 x 1x ''; do
  refused "--until: '$bad' is not a number of at least 0" "$kith" run tiny.yaml "--until=$bad"
  refused "--steps: '$bad' is not a number of at least 0" "$kith" run tiny.yaml "--steps=$bad"
done
refused "--steps: '1.5' is not a whole number" "$kith" run tiny.yaml --steps 1.5
refused "--threads: '0' is not a number of at least 1" "$kith" run tiny.yaml --threads 0
refused "--threads: '1e9' is more than 1024" "$kith" run tiny.yaml --threads 1e9
refused "tiny.yaml: one argument too many" "$kith" bench tiny.yaml
refused "--ranks: not an option of bench, but of run, plan" "$kith" bench --ranks 2
if ldd "$programs/kith-1d" | grep -q libmpi; then
  refused "kith: --ranks: 100000 is more than 4096" "$kith" run tiny.yaml --ranks 100000
  # mpirun would wait for ever
  refused "kith: --ranks 100: mpirun needs 550 open files, and 200 are allowed" \
    bash -c 'ulimit -n 200; exec "$@"' - "$kith" run tiny.yaml --ranks 100
fi
for threads in 90000 2147483648; do
  refused "OMP_NUM_THREADS: more than 1024" env OMP_NUM_THREADS=$threads "$kith" run tiny.yaml
done
refused "list: 'kernl' is not one of scene, package" "$kith" list kernl
refused "list: 'xyzzy' is not one of scene, package, added, kernel," "$kith" list xyzzy

refused "is through the domain at time 2, and the run goes until 3" "$kith" run tiny.yaml \
  --set 'boundaries.x=[{kind: piston, velocity: 1}, open]' --until 3

refused "connectivity.contacts.0.with: no region is of material 'water'" "$kith" run tiny.yaml \
  --set materials.water.eos=ideal --set materials.water.gamma=1.4 \
  --set 'connectivity.contacts=[{of: gas, with: water}]'
refused "probes: all regions are barriers" "$kith" run tiny.yaml \
  --set regions.0.barrier=true --set regions.1.barrier=true --set 'probes=[{name: p, at: [0, 0, 0]}]'
refused "connectivity.contacts.0.of: all nodes of 'wall' are frozen" "$kith" run tiny.yaml \
  --set 'materials={gas: {}, wall: {}}' --set regions.1.material=wall --set regions.1.frozen=true \
  --set 'connectivity.contacts=[{of: wall, with: gas}]'

# ---- the scene: key=value | what the line must hold; more of them: tests/unit/app/scene/test_scene_wrong.c
while IFS='|' read -r set text; do
  refused "$text" "$kith" run tiny.yaml --quiet -o out --set "$set"
  refused "$text" "$kith" plan tiny.yaml --set "$set"
done <<'END'
methd.kernel=cubic|--set methd: unknown key; did you mean 'method'?
xyzzy=1|--set xyzzy: unknown key; known are base, scene, dimension,
a..b=3|--set a..b=3: write it as key=value
method.package=spf|--set method.package: 'spf' is not one of sph
method.kernel=cubik|did you mean 'cubic'?
method.package=SPH|; did you mean 'sph'?
method=crk|--set method: 'crk' where a map belongs; write method.package=crk
scheme=rk2|--set scheme: 'rk2' where a map belongs; write scheme.name=rk2
materials.gas=tait|--set materials.gas: 'tait' where a map belongs; write materials.gas.eos=tait
ranks=4|--set ranks=4: not a key of a scene, but an option: --ranks 4
steps=4|--set steps=4: not a key of a scene, but an option: --steps 4
profile=true|--set profile=true: not a key of a scene, but an option: --profile
steps=block|--set steps: not a key of the scene itself, but of scheme
regions.0.pressure=1 bar|Unexpected token "bar" found at position 2. It may have numbers without units
regions.0.pressure=pow(x,2)|+ - * / ^ < <= > >= == != && || ? : (), x, y, z, r, pi, e, sin, cos, tan
regions.0.pressure=Sin(x)|Unexpected token "Sin" found at position 0. Did you mean 'sin'?
connectivity.rebuild=always:x=1|--set connectivity.rebuild: always has no parameter x
connectivity.exclude=materials|--set connectivity.exclude: materials: of is missing: materials:of=...
connectivity.exclude=connected|--set connectivity.exclude: connected: field is missing
connectivity.rebuild=displacement, always|--set connectivity.rebuild
boundaries.x={knd: piston, velocity: 1}|--set boundaries.x.knd: unknown key; did you mean 'kind'?
boundaries.x=[{lower: piston}, open]|--set boundaries.x.0.lower: not a key of boundaries.x.0, but of domain
boundaries.x={velocity: 1}|--set boundaries.x.kind: missing; it is required
boundaries.x={1d: periodic, 4d: open}|--set boundaries.x.4d: unknown key; 1d, 2d and 3d tell dimensions apart
regions.0.density=x < 0 ? 1 : 2|--set regions.0.density: a formula with a colon needs quotes
resolution=1e12|1e+12 nodes are more than the 1e+09 allowed
resolution=1e30|1e+18 nodes are more than the 1e+09 allowed
resolution=1e400|1e400 is not a finite number
dimension=|missing
scheme.name=rk4|--set scheme.name: rk4 cannot keep energy compatible: that energy follows from the kicks
scheme={name: arkode, table: [1]}|--set scheme.table: a list where a single value belongs
scheme={name: implicit, method: crank-nicholson}|did you mean 'crank-nicolson'?
scheme={name: implicit, rtol: 0}|0 is out of range [1e-12, 1]
scheme.rtol=0.1|--set scheme.rtol: means nothing for leapfrog, only for arkode, implicit
method.faces=integrated|--set method.faces: means nothing for sph, only for mfm
method={package: mfm, viscosity: {alpha: 1}}|--set method.viscosity: means nothing for mfm, only for sph, crk
method.viscosity={name: none, alpha: 1}|--set method.viscosity.alpha: means nothing with name: none
scheme={dt: 0.001, cfl: 0.2}|--set scheme.cfl: means nothing with dt: 0.001
connectivity.skin=0.1|--set connectivity.skin: means nothing with rebuild: always
connectivity.storage=padded|--set connectivity.storage: means nothing without probes or contacts
partition={every: 0, imbalance: 2}|--set partition.imbalance: means nothing with every: 0
potential.softening=1|--set potential.softening: means nothing with mass: 0
regions.0.seed=3|--set regions.0.seed: means nothing with jitter: 0
measure.growth=true|--set measure.growth: means nothing in 1-D: it is of a flow along x and y
measure.asymmetry=true|--set measure.asymmetry: means nothing in 1-D
output.plot={kind: slice}|--set output.plot.kind: a slice is of a 3-D scene
output.plot={kind: map}|--set output.plot.kind: a map is of a 2-D or 3-D scene
output.plot={plane: {z: 0}}|--set output.plot.plane: means nothing but for a slice or a map of a 3-D scene
output.plot={range: [0, 1]}|--set output.plot.range: means nothing without a map
measure.rate=2|--set measure.rate: means nothing without growth or mcnally
probes=[{name: .., at: [0, 0, 0]}]|--set probes.0.name: '..' cannot name a group
probes=[{name: "a\tb", at: [0, 0, 0]}]|cannot name a group
probes=[{name: p, at: [0, 0, 0], spacing: 0.1}]|--set probes.0.spacing: means nothing for one point
scheme.dt=-1|-1 is out of range [0, inf)
method.neighbors=1|--set method.neighbors: 1 is too few for kernel wendland-c2
output.every=-1|out of range
scene=../elsewhere|cannot name a directory
scene=a/b|cannot name a directory
scene="a\tb"|cannot name a directory
regions.0.where.x=[-1, 0.1]|regions.0: overlaps the region of line 10, at
regions.0.where.x=[-3, -2]|regions.0: no part of it is in the domain
regions.0.where.x=[-1, .inf]|not a finite number
regions.0.where={inside: "x > 5"}|holds no node: it is outside of the domain or thinner than a spacing; in 1-D
regions.0.density=1 + |--set regions.0.density: formula '1 +': Unexpected end
regions.0.density=1 + t|--set regions.0.density: t means nothing at the start; variables are x, y, z, r
regions.0.velocity=[sin(t)]|--set regions.0.velocity: t means nothing at the start
regions.0.where.inside=x < t|--set regions.0.where.inside: t means nothing at the start
regions.0.density=1/(x - x)|density
domain={lower: [1e12, 0, 0], upper: [1000000000001, 1, 1]}|a million of that: shift the domain towards 0
END

# ---- units whose values are each in range, but not their products
for value in 1e-137 1e137; do
  refused "regions: a pressure of about" "$kith" plan tiny.yaml --set "regions.0.density=${value/137/85}" \
    --set "regions.1.density=${value/137/86}" --set "regions.0.pressure=$value" \
    --set "regions.1.pressure=$value"
done
refused "regions: a force of about 2.8" "$kith" plan tiny.yaml --set dimension=2 --set resolution=50e24 \
  --set 'domain={lower: [-1e-24, 0, 0], upper: [1e-24, 2e-25, 1]}' --set 'regions.0.where.x=[-1e-24, 0]' \
  --set 'regions.1.where.x=[0, 1e-24]' --set regions.0.density=1e-40 --set regions.1.density=1e-41 \
  --set regions.0.pressure=1e-86 --set regions.1.pressure=1e-87
refused "regions: a density of about 1e-110" "$kith" plan tiny.yaml --set resolution=50e-25 \
  --set 'domain={lower: [-1e25, 0, 0], upper: [1e25, 1, 1]}' --set 'regions.0.where.x=[-1e25, 0]' \
  --set 'regions.1.where.x=[0, 1e25]' --set regions.0.density=1e-110 --set regions.1.density=1e-111 \
  --set regions.0.pressure=1e-110 --set regions.1.pressure=1e-111

# ---- settings of list storages, which are read when results are opened
while IFS='|' read -r storage text; do
  refused "--set connectivity.storage: $text" "$kith" run tiny.yaml --quiet -o out \
    --set 'probes=[{name: p, at: [0, 0, 0]}]' --set "connectivity.storage=$storage"
done <<'END'
padded:foo=1|padded has no parameter foo
padded:width=-1|padded: width: -1 is out of range [0, inf)
padded:width|padded: width: write it as key=value
csr:width=1|csr has no parameter width
csr, padded|'csr, padded' is not one of csr, 
half|half keeps half of the neighbors of a node
END

# ---- a glass that would be squeezed by whole cells
refused "regions.0: lattice glass: a cell is 10 spacings, 0.2, and the region has 0.5 of them along y" \
  "$kith" plan tiny.yaml --set dimension=2 --set 'domain.upper=[1, 0.1, 1]' --set regions.0.lattice=glass

# ---- settings that cannot be used together
refused "damage act; take one-point faces" "$kith" plan "$2/layer.yaml" --set method.package=mfm \
  --set method.faces=integrated
refused "--set method.faces: integrated faces leave the side of a barrier open" "$kith" plan "$2/plate.yaml" \
  --set method.package=mfm --set method.faces=integrated
for layer in plate layer; do
  refused "--set method.stretch: ellipsoids do not tell what is between" "$kith" plan "$2/$layer.yaml" \
    --set 'method.stretch=[1, 2, 1]' --set dimension=2
done
refused "--set method.stretch: conduction and viscosity would differ along" "$kith" plan "$2/heat-wave.yaml" \
  --set 'method.stretch=[1, 2, 1]' --set dimension=2
refused "--set arrangement: means nothing without two regions" "$kith" plan tiny.yaml \
  --set arrangement=equal-mass --set regions.1.spacing=0.01
refused "exact.density: missing; it does not follow from this scene, only from one of two regions" \
  "$kith" plan "$2/sod.yaml" --set dimension=1 --set regions.0.density=1+x
refused "exact.energy: missing; it is required" "$kith" plan "$2/slabs.yaml" --set 'exact={name: slabs}'
refused "--set energy: no node takes it: all are frozen, or of barriers" "$kith" run tiny.yaml \
  --quiet -o out --set 'energy={energy: 1}' --set regions.0.frozen=true --set regions.1.frozen=true
refused "--set packages: coupling has nothing to couple" \
  "$kith" plan tiny.yaml --set 'packages=[{name: coupling}]'
refused "coupling is in the list twice" "$kith" plan "$2/layer.yaml" \
  --set 'packages=[{name: coupling}, {name: coupling}]'
refused "porosity: 1.5 is out of range [0, 1]" "$kith" plan "$2/layer.yaml" --set regions.1.porosity=1.5
refused "damage: -0.1 is out of range [0, 1]" "$kith" plan "$2/layer.yaml" --set regions.1.damage=-0.1
refused "damage, in [0, 1], is 1.9" "$kith" plan "$2/layer.yaml" --set 'regions.0.damage=1 - x'
refused "cullen-dehnen has a history, and arkode may reject a step" "$kith" plan tiny.yaml \
  --set scheme.name=arkode --set method.energy=thermal \
  --set method.viscosity.name=cullen-dehnen
refused "--set boundaries.x.a: unknown key" "$kith" run tiny.yaml --quiet --set 'boundaries.x={a: 1}'

# errors in the file itself are reported with line and key
sed 's/gamma: 1.4/gama: 1.4/' tiny.yaml >wrong.yaml
refused "wrong.yaml:7: materials.gas.gama: unknown key; did you mean 'gamma'?" "$kith" run wrong.yaml
sed 's/x: \[0, 1\]/x: [-0.5, 1]/' tiny.yaml >wrong.yaml
refused "wrong.yaml:9: regions.0: overlaps the region of line 10" "$kith" run wrong.yaml
sed '/^resolution/d' tiny.yaml >wrong.yaml
refused "resolution: missing; it is required" "$kith" run wrong.yaml
# a periodic axis without length
sed 's/x: reflecting/x: periodic/; s/upper: \[1,/upper: [-1,/' tiny.yaml >wrong.yaml
refused "wrong.yaml:4: domain.upper: -1 along x is not above lower" "$kith" run wrong.yaml
printf 'until: [\n' >wrong.yaml
refused "wrong.yaml:2: not YAML" "$kith" run wrong.yaml
printf 'base: tiny.yaml\nmethod.kernel: cubic\nmethod: {package: mfm}\n' >wrong.yaml
refused "wrong.yaml:3: method: would replace what line 2 says" "$kith" run wrong.yaml
printf 'base: tiny.yaml\nmethod: {kernel: cubic}\nmethod.kernel: wendland-c4\n' >wrong.yaml
refused "wrong.yaml:3: method.kernel: would replace what line 2 says" "$kith" run wrong.yaml
printf 'until: 1\nuntil: 2\n' >wrong.yaml
refused "wrong.yaml:2: until: " "$kith" run wrong.yaml
refused "kith: /dev/stdin:2: until: " bash -c 'cat wrong.yaml | "$1" run /dev/stdin' - "$kith"
sed 's/^dimension:/dimensions:/' tiny.yaml >wrong.yaml
refused "wrong.yaml:2: dimensions: unknown key; did you mean 'dimension'?" "$kith" run wrong.yaml
: >wrong.yaml
refused "wrong.yaml:1: the file is empty" "$kith" validate wrong.yaml
refused "wrong.yaml:1: the file is empty" "$kith" run wrong.yaml
printf '\177ELF\002\001\001\000\000' >wrong.yaml
refused "wrong.yaml:1: not YAML" "$kith" run wrong.yaml
head -c 2000000 /dev/zero >wrong.yaml
refused "wrong.yaml" "$kith" run wrong.yaml
mkdir folder
refused "folder: is a directory, not a scene" "$kith" run folder
refused "missing.yaml: No such file or directory" "$kith" run missing.yaml
refused "tin.yaml: No such file or directory; did you mean 'tiny.yaml'?" "$kith" run tin.yaml
echo 'base: .' > folder.yaml
refused "folder.yaml:1: base: . is a directory, not a scene" "$kith" run folder.yaml
refused "tiny.yaml:2: dimension: 1, but this program is the 2-D one" "$programs/kith-2d" run tiny.yaml
refused "tiny.yaml:2: dimension: 1, but this program is the 3-D one" "$programs/kith-3d" plan tiny.yaml

# ---- output directories; root may write nearly anywhere, but not below a file, nor in /proc
for bad in tiny.yaml tiny.yaml/out /proc/kith /dev/null/out; do
  refused "" "$kith" run tiny.yaml --quiet -o "$bad"
done
refused "cannot write" "$kith" run tiny.yaml --quiet -o /proc
mkdir read-only && chmod a-w read-only
if ((EUID != 0)); then refused "read-only" "$kith" run tiny.yaml --quiet -o read-only; fi
mkdir out
for bad in missing/trace tiny.yaml/trace folder; do
  refused "cannot write" "$kith" run tiny.yaml --quiet -o out --trace $bad
done
# what a run writes itself, also if the directory is not there yet or is named otherwise
for bad in out/history.csv out/report.json out/snapshot_0001.hdf "$PWD/out/plot.png" out/checkpoint.kith; do
  refused "kith: --trace: $bad may be the name of a result; in the directory of the results" \
    "$kith" run tiny.yaml --quiet -o out --trace "$bad"
done
refused "may be the name of a result" "$kith" run tiny.yaml --quiet -o "$PWD" --trace history.csv
refused "may be the name of a result" "$kith" run tiny.yaml --quiet -o no/such --trace no/such/history.csv
[[ ! -e no ]] || wrong "a refused trace left a directory"
ok "$kith" run tiny.yaml --quiet -o no/such --trace ./no/such/trace.json
ok "$kith" run tiny.yaml --quiet -o "$PWD/no/such/" --trace no/such/trace.json
[[ -s no/such/trace.json ]] || wrong "no trace in the directory of the results"

cp tiny.yaml kept.yaml
echo 'base: tiny.yaml' >over.yaml
ln -s tiny.yaml link.yaml
for scene in tiny over; do
  for bad in tiny.yaml ./tiny.yaml link.yaml; do
    refused "kith: --trace: $bad is the file tiny.yaml, which" "$kith" run $scene.yaml --quiet -o out \
      --trace $bad
  done
done
same tiny.yaml kept.yaml

# ---- checkpoints; the files in the directory stay as they are
ok "$kith" run tiny.yaml --quiet -o out --set output.checkpoint=5
refused "which this run reads" "$kith" run tiny.yaml --quiet -o out --restart out/checkpoint.kith \
  --trace out/checkpoint.kith
[[ -e out/checkpoint.kith && -e out/checkpoint.kith.previous ]] || wrong "there are no two checkpoints"
set -- --quiet -o out --set output.checkpoint=5 --restart
good=out/checkpoint.kith
size=$(stat -c %s $good)
for ((cut = 0; cut < size; cut += 397)); do
  head -c $cut $good >cut.kith
  refused "cut.kith: " "$kith" run tiny.yaml "$@" cut.kith
done
for ((at = 70; at < size; at += 997)); do # one byte changed
  cp $good changed.kith
  printf '\x5a\xa5' | dd of=changed.kith bs=1 seek=$at conv=notrunc status=none
  refused "changed.kith: " "$kith" run tiny.yaml "$@" changed.kith
done
refused "missing.kith: cannot read: No such file" "$kith" run tiny.yaml "$@" missing.kith
refused "tiny.yaml: not a checkpoint" "$kith" run tiny.yaml "$@" tiny.yaml
refused "snapshot_0000.hdf: not a checkpoint" "$kith" run tiny.yaml "$@" out/snapshot_0000.hdf
refused "folder/checkpoint.kith: cannot read: No such file" "$kith" run tiny.yaml "$@" folder
refused "/dev/null: not a regular file" "$kith" run tiny.yaml "$@" /dev/null
refused "a 1-D checkpoint, this program is 2-D" "$kith" run tiny.yaml "$@" $good --set dimension=2
refused "by another scene or with other settings: regions.0.density is 1.0 there, and 2 now" "$kith" run \
  tiny.yaml "$@" $good --set regions.0.density=2
refused "kith: --until: 0.01 is in the past of the checkpoint, which is at time" "$kith" run tiny.yaml "$@" \
  $good --until 0.01
refused "kith: --steps: 1 is in the past of the checkpoint, which is at step" "$kith" run tiny.yaml "$@" \
  $good --steps 1
cp out/history.csv kept.csv
printf 'not a history\n' >out/history.csv
refused "history.csv: its columns are not step,time,dt," "$kith" run tiny.yaml "$@" $good
mv kept.csv out/history.csv
ok "$kith" run tiny.yaml "$@" $good
# Settings that do not affect the state may change.
ok "$kith" run tiny.yaml "$@" $good --set until=0.06 --set output.every=0.01 --set neighbor.search=grid \
  --set partition.name=morton --set resolution=50.0

exit $((failures > 0))
