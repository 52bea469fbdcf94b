#!/usr/bin/env bash
# test_plan.sh PROGRAMS INPUTS: `kith plan` and `kith list` for every scene and family: what they print agrees
# with the scene and with a run, and fits into 100 columns.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"

# shown TEXT COMMAND...: the command ends with 0, its output contains TEXT (with blanks and line ends
# squeezed) and no line above 100 columns, and no file is written. A repeated command is not run again.
previous=
shown() {
  local text=$1
  shift
  if [[ $* == "$previous" ]]; then cp plan.txt stdout; else ok "$@"; fi
  cp stdout plan.txt
  previous=$*
  [[ $(tr -s ' \n' ' ' <stdout) == *"$text"* ]] || wrong "$* lacks '$text'"
  awk 'length > 100 {exit 1}' stdout || wrong "$* has a line beyond 100 columns"
  [[ ! -e out ]] || wrong "$* wrote something"
}

# Until an early time: plan counts the steps by making them, and some exact solutions are runs, too.
for scene in "$inputs"/*.yaml; do
  if [[ $scene == */gresho.yaml || $scene == */yee.yaml ]]; then
    shown "nothing is written" "$kith" plan "$scene" --set resolution=4
    stopped 2 "a vortex needs 2 or 3 dimensions" "$kith" plan "$scene" --set dimension=1
  elif [[ $scene == */four-states.yaml || $scene == */triple-point.yaml ]]; then
    shown "nothing is written" "$kith" plan "$scene" --set resolution=4
    stopped 2 "it holds no node" "$kith" plan "$scene" --set dimension=1
  elif [[ $scene == */richtmyer-meshkov.yaml ]]; then
    shown "nothing is written" "$kith" plan "$scene"
    stopped 2 "overlaps the region of line" "$kith" plan "$scene" --set dimension=1
  elif [[ $scene == */rayleigh-taylor.yaml ]]; then
    shown "nothing is written" "$kith" plan "$scene"
    stopped 2 "along y: there is no such axis in 1-D" "$kith" plan "$scene" --set dimension=1
  else
    shown "nothing is written" "$kith" plan "$scene" --set dimension=1 --set until=0.01
  fi
done
set -- "$kith" plan tiny.yaml
shown "tiny, 1-D" "$@"
shown "gas 56 nodes; ideal, gamma 1.4" "$@"
shown ") pairs left out not requested" "$@"
shown "sph (gather)" "$@"
shown "overlap left out not requested overlap pairs left out not requested" "$@"
shown "overlap pairs built" "$@" --set method.package=mfm --set method.faces=integrated
shown "face_area built 1 value a pair" "$@" --set method.package=mfm --set method.faces=integrated
shown "pairwise left out" "$@"
shown "sph (pairs)" "$@" --set traversal=pairs
shown "as the scene says" "$@" --set traversal=pairs
shown "traversal gather (reproducible:" "$@" --set traversal=pairs --set reproducible=true
shown "search brute:" "$@" --set neighbor.search=brute
shown "culling is off" "$@" --set connectivity.cull=false
shown "steps of 2 evaluations" "$@" --set scheme.name=rk2
shown "steps of 6 evaluations" "$@" --set scheme.name=arkode --set scheme.table=dormand-prince-7-4-5 \
  --set method.energy=thermal
shown "skin 0.15 of the support" "$@" --set connectivity.rebuild=displacement --set connectivity.skin=0.15
shown "about 50 to t = 0.05" "$@" --set scheme.dt=0.001
shown "Courant 0.3 (the default of this package)" "$@"
shown "Courant 0.2 (as the scene says)" "$@" --set scheme.cfl=0.2
shown "0.01 at first, until energy is released;" "$kith" plan "$inputs/sedov.yaml" --set dimension=1 \
  --set energy.time=0.01 --set scheme.steps=block
shown "0.001 at first, since output is due then (output.every);" "$kith" plan "$inputs/sedov.yaml" \
  --set dimension=1 --set output.every=0.001 --set scheme.steps=block
set -- "$kith" plan "$inputs/sod.yaml" --set dimension=3 --set resolution=16
shown "wendland-c2, 60.04 neighbors (the default of this package and kernel)" "$@"
shown "wendland-c2, 55.24 neighbors (the default of this package and kernel)" "$@" --set method.package=mfm
shown "Courant 0.4 (the default of this package)" "$@" --set method.package=mfm
set -- "$kith" plan tiny.yaml
shown "ghosts none" "$@" --set boundaries=
shown "frozen 2000005 of these nodes" "$@" \
  --set resolution=2000000 --set regions.0.frozen=true --set until=1e-9
ok "$@" --ranks 4
table=*"on 4 ranks: 14.0 nodes"*"partitioner imbalance mean most mean most"*"kd 1."*
[[ $(tr -s ' ' <stdout) == $table ]] || wrong "plan --ranks lacks its table"
awk 'length > 100 {exit 1}' stdout || wrong "plan --ranks has a line beyond 100 columns"
[[ $(tr -s ' \n' ' ' <stdout) == *" a rank with kd: of 14 nodes, "*" of the map of cells"* ]] ||
  wrong "plan --ranks lacks the memory of a rank"
for many in "--ranks 20000" "--ranks 2 --set partition.ghosts=recompute"; do
  ok "$@" $many
  (($(grep -c "no forecast" stdout) == 1)) || wrong "plan $many: not one line says why"
done
shown "a message 1 s, its bytes 953.7 MiB a second" "$@" --ranks 4 --set machine.latency=1
shown "machine: of the scene" "$@" --ranks 4 --set partition.name=diffusion --set partition.iterations=3
stopped 2 "out of range [0, inf)" "$@" --ranks 4 --set machine.latency=-1
stopped 1 "a support does not converge" "$@" --set boundaries= --set method.neighbors=300

# Too many neighbors for a kernel cause a warning, and the run continues; default numbers cause none.
for verb in plan "run --quiet"; do
  "$kith" $verb tiny.yaml --set method.kernel=cubic --set method.neighbors=6 >stdout 2>stderr ||
    wrong "$verb stopped at a warning"
  rm -rf out
  pairing="nodes pair up with 6 neighbors under kernel cubic, which carries 4.48 in 1-D; take wendland-c6"
  [[ $(<stderr) == "kith: warning: method.neighbors: $pairing" ]] ||
    wrong "$verb warned: $(<stderr)"
done
for kernel in cubic quartic quintic wendland-c2 wendland-c4 wendland-c6; do
  shown "nothing is written" "$@" --set method.kernel=$kernel
done

"$kith" plan tiny.yaml --set materials.lead={} >stdout 2>stderr ||
  wrong "plan stopped at a material without a region"
[[ $(<stderr) == "kith: warning: materials.lead: no region is of this material" ]] ||
  wrong "plan warned: $(<stderr)"

"$kith" plan tiny.yaml --set 'boundaries={}' --set 'potential={mass: 1, softening: 0.01}' >stdout 2>stderr
[[ $(<stderr) == "kith: warning: potential.softening: 0.01 is less than a spacing, "* ]] ||
  wrong "plan warned: $(<stderr)"

# A Courant number that is too large for the package.
"$kith" plan tiny.yaml --set method.package=mfm --set scheme.cfl=0.5 >stdout 2>stderr ||
  wrong "plan stopped at a large Courant number"
[[ $(<stderr) == \
  "kith: warning: scheme.cfl: 0.5 is beyond 0.38, up to which gas at rest stays so with mfm" ]] ||
  wrong "plan warned: $(<stderr)"

# A lattice that resists shear beside a viscosity; not with a smoother kernel.
wave=("$kith" plan "$inputs/viscous-wave.yaml" --set dimension=2 --set resolution=10)
"${wave[@]}" --set method.kernel=wendland-c2 --set method.neighbors=18 >stdout 2>stderr
elastic="regions.0.lattice: with sph a cubic lattice has a shear stiffness of -0.21 of the pressure, "
[[ $(<stderr) == "kith: warning: $elastic"* ]] ||
  wrong "plan warned: $(<stderr)"
"${wave[@]}" --set method.kernel=quintic --set method.neighbors=23 >stdout 2>stderr
[[ ! -s stderr ]] || wrong "plan warned: $(<stderr)"

# An exact solution with parameters of another scene.
"$kith" run "$inputs/noh.yaml" --quiet --steps 1 --set dimension=1 --set output.plot=false \
  --set exact.velocity=3 >stdout 2>stderr || wrong "run stopped at another exact solution"
rm -rf out
[[ $(<stderr) == \
  "kith: warning: exact: the scene does not start as noh does: the velocity differs by 100 %" ]] ||
  wrong "run warned: $(<stderr)"

# The first dt of the plan is that of the run.
planned=$("$@" | sed -n 's/^  first dt *\([^:]*\):.*/\1/p')
ok "$kith" run tiny.yaml --quiet -o run --steps 1
[[ $planned == "$(awk -F, 'NR == 3 {printf "%.4g", $3}' run/history.csv)" ]] ||
  wrong "the first dt is not $planned"
[[ $(sed -n 2p run/history.csv) == 0,0,0,nothing,* ]] || wrong "no row of the start"

# So are the steps of a scene that takes less than a second, also if they get much shorter later, or end where
# snapshots are due.
for setting in tiny.yaml "tiny.yaml --set output.every=0.001" \
  "tiny.yaml --set output.every=0.001 --set scheme.dt=0.0007" \
  "$inputs/two-blasts.yaml --set dimension=1 --set resolution=60"; do
  shown "counted by running the scene to its end" "$kith" plan $setting --set output.plot=false
  planned=$(sed -n 's/^ *steps *about \([0-9]*\) .*/\1/p' stdout)
  ok "$kith" run $setting --set output.plot=false --quiet -o whole --overwrite
  taken=$(sed -n 's/^ *"steps": \([0-9]*\).*/\1/p' whole/report.json)
  [[ $planned == "$taken" ]] || wrong "$setting: $planned steps planned, $taken taken"
done
shown "a calibration run took" "$kith" plan tiny.yaml --set scheme.dt=1e-7
shown "never reach 1e+300 cost" "$kith" plan tiny.yaml --until 1e300

# So are ghosts and row entries of its lists, without those of the first one, whose supports are guessed, and
# without rows of ghosts.
for faces in one-point integrated; do
  tube=("$inputs/sod.yaml" --set dimension=2 --set resolution=12 --set method.package=mfm
    --set method.faces=$faces)
  ok "$kith" plan "${tube[@]}"
  planned=$(awk '/^    rows / {rows = $3} /^  ghosts/ {print $(NF - 1), rows}' stdout)
  ok "$kith" run "${tube[@]}" --quiet -o lists-$faces --steps 1 --set output.plot=false
  taken=$(python3 - lists-$faces/history.csv <<'END'
import csv, sys
row = list(csv.DictReader(open(sys.argv[1])))[-1]
print(row["ghosts"], "%.1f" % (float(row["entries"]) / float(row["nodes"])))
END
  )
  [[ $planned == "$taken" ]] || wrong "$faces: ghosts and row entries a node are $taken, not $planned"
done

# Ghosts have rows only between ranks if they compute their own values.
shown "ghost rows left out requested on several ranks (partition.ghosts)" \
  "$kith" plan tiny.yaml --set partition.ghosts=recompute

# With a window they are those of all nodes, too.
for window in whole follow; do
  ok "$kith" plan "$inputs/sod.yaml" --set dimension=1 --set window=$window
  grep -E '^    rows |^  ghosts ' stdout >lists-$window
done
[[ -s lists-whole ]] && same lists-whole lists-follow

# Settings that would save time are those which the scene takes.
for scene in copper-piston driven-shock layer; do
  plan=("$kith" plan "$inputs/$scene.yaml" --set dimension=1 --set resolution=40 --set until=0)
  ok "${plan[@]}"
  for setting in $(sed -n '/^  cheaper/,$p' stdout | grep -o '[a-z.]*=[-a-z]*:' | tr -d :); do
    ok "${plan[@]}" --set "$setting"
  done
done

# Block steps are suggested by the updates that the whole run needs, not by those of its first step: for a
# blast, with about as many as a run with them takes. Where all nodes need short steps a global step is.
part() { tr -s ' \n' ' ' <stdout | sed -n "s/.*scheme.steps=$1: [^%]* \([0-9.]*\) % of the updates.*/\1/p"; }
if [[ -x $programs/kith-2d ]]; then
  blast=("$inputs/sedov.yaml" --threads 1 --set dimension=2 --set resolution=40)
  ok "$kith" plan "${blast[@]}"
  planned=$(part block)
  grep -q "angular momentum" stdout || wrong "no word of what block steps give up"
  ok "$kith" run "${blast[@]}" --quiet --set scheme.steps=block --set output.plot=false -o blast
  awk -v planned="$planned" '/"ideal":/ {taken = 100 / $2}
    END {if (!(planned > 0.5 * taken && planned < taken)) print planned " % planned, " taken " taken"}' \
    blast/report.json >differs
  [[ ! -s differs ]] || wrong "updates of a blast: $(<differs)"
  ok "$kith" plan "${blast[@]}" --set scheme.steps=block
  [[ $(<stdout) != *scheme.steps=* ]] || wrong "block steps of a blast are not cheaper"
  ok "$kith" plan "$inputs/kelvin-helmholtz.yaml" --threads 1 --set dimension=2 --set resolution=16 \
    --set scheme.steps=block
  (($(part global | cut -d. -f1) > 90)) || wrong "block steps pay in a shear flow"
  rm -rf blast
fi

# A window is suggested for a long tube, most of which no wave reaches, and not for a blast.
wide=(--set domain.lower=[-2,0,0] --set domain.upper=[2,1,1] --set regions.0.where.x=[-2,0]
  --set regions.1.where.x=[0,2])
shown "window=follow: no signal reaches 76 %" "$kith" plan "$inputs/sod.yaml" --set dimension=1 "${wide[@]}"
ok "$kith" plan "$inputs/sedov.yaml" --set dimension=1
! grep -q window=follow stdout || wrong "a window for a blast"

# A scene that is too large is simulated with fewer nodes; what it prints is scaled.
if [[ -x $programs/kith-2d ]]; then
  large=("$kith" plan "$inputs/faces.yaml" --set dimension=2 --set until=0)
  ok "${large[@]}" --set resolution=2000
  awk '/^  simulated/ {few = $3 + 0} /^    face_area/ {face = $7 " " $8}
    /^    pairwise/ && face != $2 " " $3 ":" {print face, $2, $3}
    /^  ghosts/ {print few, $2 >"ghosts"}' stdout >differs
  [[ ! -s differs ]] || wrong "memory of a pairwise field of a large scene: $(<differs)"
  read -r few planned <ghosts
  ok "${large[@]}" --set resolution="$few"
  awk -v few="$few" -v planned="$planned" \
    '/^  ghosts/ {d = $2 * 2000 / few - planned; exit !(d * d < 4)}' stdout ||
    wrong "$planned ghosts of a large scene, beside $(grep '^  ghosts' stdout) with $few nodes a length"

  # A blast heats as many nodes, so their sound speed rises as the resolution, and steps fall as its square.
  # With fewer ghosts a node takes less memory.
  large=("$kith" plan "$inputs/sedov.yaml" --set dimension=2 --set until=0)
  ok "${large[@]}" --set resolution=2000
  tee all <stdout | grep -q "^  simulated *resolution $few," || wrong "a large blast: $(head -3 stdout)"
  ok "${large[@]}" --set resolution="$few"
  awk -v few="$few" '/^    nodes/ {bytes[++n] = $NF} /^  first dt/ {dt[n] = $3}
    END {d = dt[1] / dt[2] * (2000 / few) ^ 2 - 1
      if (!(d * d < 1e-4 && bytes[1] < 0.99 * bytes[2])) print dt[1], dt[2], bytes[1], bytes[2]}' \
    all stdout >differs
  [[ ! -s differs ]] || wrong "first dt and memory of a large blast: $(<differs)"

  # Which lattices are stiff is known for spherical supports only.
  box=("$kith" plan "$inputs/noisy-box.yaml" --set dimension=2 --set resolution=10 --set until=0
    --set regions.0.lattice=hcp)
  shown "hcp: stiff under shear" "${box[@]}"
  ok "${box[@]}" --set 'method.stretch=[2, 1, 1]'
  ! grep "under shear" stdout || wrong "a lattice said to be stiff between ellipsoids"
fi

# Plans of runs above a second: their number of steps is that of the run within a tenth, and settings that
# save time can be used as they are printed. Not in debug builds, where it takes a minute.
if [[ $("$kith" --version) != *Debug* ]]; then
  tube=("$inputs/sod.yaml" --threads 1 --set dimension=1 --set arrangement=equal-mass
    --set resolution=4000 --set until=0.1)
  shown "about" "$kith" plan "${tube[@]}"
  planned=$(sed -n 's/^ *steps *about \([0-9]*\) .*/\1/p' stdout)
  mapfile -t cheaper < <(grep -o '[a-z]*\.[a-z]*=[-a-z]*:' stdout | tr -d :)
  ((${#cheaper[@]} == 1)) || wrong "cheaper settings: ${cheaper[*]}"
  ok "$kith" run "${tube[@]}" --quiet -o tube --set output.plot=false
  taken=$(sed -n 's/^ *"steps": \([0-9]*\).*/\1/p' tube/report.json)
  ((10 * planned > 9 * taken && 10 * planned < 11 * taken)) || wrong "$planned steps planned, $taken taken"
  for setting in "${cheaper[@]}"; do ok "$kith" run tiny.yaml --quiet -o cheap --set "$setting"; done

  # With block steps it counts updates of a node.
  if [[ -x $programs/kith-2d ]]; then
    blast=("$inputs/sedov.yaml" --threads 1 --set dimension=2 --set resolution=100 --set method.package=mfm
      --set scheme.steps=block)
    ok "$kith" plan "${blast[@]}"
    planned=$(sed -n 's/^ *updates *about \([0-9]*\).*/\1/p' stdout)
    ok "$kith" run "${blast[@]}" --quiet -o blast --set output.plot=false
    taken=$(awk '/"nodes": [0-9]/ && !n {n = $2 + 0}
      /^    "updates":/ {print int($2 / n - 2)}' blast/report.json)
    ((10 * planned > 8 * taken && 10 * planned < 11 * taken)) ||
      wrong "$planned updates planned, $taken taken"
  fi

  # Of a blast steps grow more than the resolution, as it has more room: 40^3 nodes take 65.
  if [[ -x $programs/kith-3d ]]; then
    shown "a calibration run took" "$kith" plan "$inputs/sedov.yaml" --threads 1 --set resolution=40
    planned=$(sed -n 's/^ *steps *about \([0-9]*\) .*/\1/p' stdout)
    ((planned > 60 && planned < 70)) || wrong "$planned steps of a blast planned, 65 taken"
  fi
fi

# The stages of an evaluation add up to it, but for rounding.
ok "$kith" plan tiny.yaml
sed -n '/^  evaluation/,/^  scheme/p' stdout | tr -d , | tr -s ' \n' ' ' |
  awk 'BEGIN {unit["ns"] = 1e-3; unit["us"] = 1; unit["ms"] = 1e3; unit["s"] = 1e6}
    {for (k = 2; k < NF; ++k) if ($(k + 1) in unit) value[++n] = $k * unit[$(k + 1)]}
    END {for (k = 2; k <= n; ++k) sum += value[k]
      if (!(sum > 0.98 * value[1] && sum < 1.02 * value[1])) print sum " of " value[1] " us"}' >differs
[[ ! -s differs ]] || wrong "stages of an evaluation: $(<differs)"

# ---- list
shown "wendland-c2" "$kith" list
for family in package kernel viscosity eos scheme table search rebuild excluder boundary lattice exact; do
  shown " $family " "$kith" list $family
  (($(wc -l <stdout) >= 2)) || wrong "list $family has no member"
  awk '/^ {4}[^ ]/ && NF < 2 {exit 1}' stdout || wrong "list $family: a member without a doc"
done
ok "$kith" list scene # long lines there are comments of a file
for key in resolution method kernel regions until; do
  grep -q "^ *$key:" stdout || wrong "list scene lacks $key"
done
# A key that members mean differently is explained for each.
for text in "gamma: 1.4 # ratio of specific heats (ideal, stiffened" \
  "gamma: 2 # Grueneisen's Gamma0, at rho0 (mie-grueneisen)" \
  "amplitude: # required; of the density, relative (acoustic-wave" \
  "wavelength: # required unless it follows from the scene; along x (acoustic-wave"; do
  [[ $(tr -s ' ' <stdout) == *"$text"* ]] || wrong "list scene lacks '$text'"
done

# ---- help
for verb in run plan list; do
  shown "$verb" "$kith" $verb --help
done
shown "run SCENE" "$kith" --help
shown "kith 0." "$kith" --version
shown "$(sed -nE 's/^ *"commit": "(.*)",/\1/p' run/report.json)" "$kith" --version

# A warning tells that a mirror does not continue the lattice, here the default.
for x in reflecting periodic; do
  "$kith" run "$inputs/sod.yaml" --set dimension=2 --set resolution=16 --set boundaries.x=$x \
    --set regions.0.lattice= --steps 0 --quiet -o mirror --overwrite >stdout 2>$x
done
grep -q "hcp, the default, does not continue through the mirror along x" reflecting ||
  wrong "a mirror: $(<reflecting)"
[[ ! -s periodic ]] || wrong "without a mirror: $(<periodic)"

# Another one tells that a barrier is thinner than a spacing of the gas.
for resolution in 40 50; do
  "$kith" run "$inputs/plate.yaml" --set dimension=1 --set resolution=$resolution --steps 0 --quiet -o plate \
    --overwrite >stdout 2>$resolution
done
grep -q "regions.2.barrier: 0.02 thick along x, gas with a spacing of 0.025 may pass it" 40 ||
  wrong "a thin barrier: $(<40)"
[[ ! -s 50 ]] || wrong "a barrier as thick as a spacing: $(<50)"

exit $((failures > 0))
