#!/usr/bin/env bash
# test_life.sh PROGRAMS: runs that diverge, are stopped or killed, or fill the disk; and restarts, whose
# fields, snapshots, reports and histories must be those of an uninterrupted run, byte by byte.
source "$(dirname "$0")/common.sh"

# ---- the run leaves the physical range: code 1, one line with node and reason, and a snapshot of the state
# diverged TEXT SETTING...
diverged() {
  local text=$1 settings=() snapshot
  shift
  for setting; do settings+=(--set "$setting"); done
  rm -rf out
  stopped 1 "$text" "$kith" run tiny.yaml --quiet -o out --until 0.5 "${settings[@]}"
  snapshot=$(sed -n 's/.*its state is in \([^,]*\).*$/\1/p' stderr)
  [[ -s $snapshot && $snapshot == "$(printf '%s\n' out/snapshot_*.hdf | tail -1)" ]] ||
    wrong "$*: no snapshot '$snapshot'"
  grep -q "${snapshot##*/}" out/snapshots.hdf.series || wrong "$*: the series lacks $snapshot"
  ! grep -q "node [0-9]" stderr || [[ -s out/offenders.hdf ]] || wrong "$*: no offenders.hdf"
  ! grep -q offenders stderr || grep -q "node [0-9].*; its state" stderr || wrong "$*: which node?"
}
diverged "its energy is negative" scheme.dt=0.2
diverged "its energy is negative" scheme.dt=0.05 method.energy=thermal
diverged "far outside of" scheme.dt=0.2 "regions.1.velocity=[9e30]"
diverged "a support does not converge" boundaries= method.neighbors=300
diverged "the time step collapsed to 1e-30 at time 0: fixed; such" scheme.dt=1e-30
diverged "the time step collapsed to 1.57415e-23 at time 0: node" "regions.1.velocity=[1e20]"
diverged "time 0." scheme.dt=0.02 # not in the first step
diverged "a node in it needs partners up to" "boundaries.x=[{kind: inflow, depth: 1}, outflow]" \
  "regions.0.velocity=[1]" method.neighbors=10 # this message names no node

# The state of gas that will sleep is checked at the start, too: summed densities may be outside of the table.
printf '%s\n' '1 2 3 4' '1 2 3 4' '1 2 3 4' '2 4 6 8' '3 6 9 12' '4 8 12 16' >linear.table
for window in whole follow; do
  [[ -x $programs/kith-2d ]] || break
  diverged "its density is outside of the table (density 4.0001, energy 2)" window=$window dimension=2 \
    resolution=20 "materials={gas: {eos: table, file: linear.table}}" \
    "regions=[{material: gas, density: 4, energy: 2}]" boundaries.x=periodic
done

# ---- results of an earlier run do not stay beside those of a run that fails
rm -rf out
ok "$kith" run tiny.yaml --quiet -o out
touch out/{plot,growth,probe_p}.{gp,png,pdf} out/{contacts,growth}.csv out/plot_of_mine.png
touch out/{snapshot_0010,snapshot_10000}.hdf out/frame_{0010,10000}.png
touch out/snapshot_99.hdf # no run writes this name
stopped 1 "the time step collapsed" "$kith" run tiny.yaml --quiet -o out --set scheme.dt=1e-30
[[ $(echo $(ls out)) == "history.csv plot_of_mine.png snapshot_0000.hdf snapshot_0001.hdf \
snapshot_99.hdf snapshots.hdf.series" ]] || wrong "beside a run that failed: $(ls out)"

# ---- in isothermal gas the energy has no effect on the pressure, and may become negative
ok "$kith" run tiny.yaml --quiet -o out --until 0.2 --set materials.gas.eos=isothermal \
  --set regions.1.pressure=0.125
rm -rf out

# ---- gas that has left a periodic box since lists were made, or within a base step, is put back
for scheme in scheme.steps=block scheme.name=rk2; do
  "$kith" run tiny.yaml --quiet -o out --until 0.1 --set "$scheme" --set boundaries.x=periodic \
    --set output.plot=true --set "regions.0.velocity=[40]" --set "regions.1.velocity=[40]" >stdout 2>&1
  awk '$1 < -1 || $1 > 1 {++outside} END {exit outside > 0 || NR < 56}' <(grep -v '^#' out/profile.dat) ||
    wrong "$scheme: compared outside of the box: $(sort -g out/profile.dat | tail -1)"
  rm -rf out
done

# ---- a run that fails leaves a complete trace
stopped 1 "energy is negative" "$kith" run tiny.yaml --quiet -o out --set scheme.dt=0.04 --trace out.json
[[ $(head -1 out.json)$(tail -1 out.json) == "[]" ]] && grep -q '"path":"step/control"' out.json ||
  wrong "the trace of a run that failed is not whole"
rm -rf out

# ---- a parent process that ignores SIGCHLD
ok env --ignore-signal=CHLD "$kith" run tiny.yaml --quiet -o out
rm -rf out

# ---- what is no number of threads leaves the default, of a thread for 2000 nodes
for threads in '' 0 many -1; do
  OMP_NUM_THREADS=$threads "$kith" run tiny.yaml --quiet -o out >stdout 2>stderr || wrong "threads '$threads'"
  grep -q '"threads": 1,' out/report.json || wrong "'$threads': $(grep threads out/report.json)"
  rm -rf out
done

# Reports count the threads that there are.
for threads in '' 4; do
  OMP_THREAD_LIMIT=2 OMP_NUM_THREADS=$threads "$kith" run tiny.yaml --quiet -o out --set resolution=9000 \
    --steps 1 ${threads:+--threads $threads} >stdout 2>stderr || wrong "a limit of two threads: $(<stderr)"
  grep -q '"threads": [12],' out/report.json || wrong "limit of 2: $(grep threads out/report.json)"
  rm -rf out
done

# ---- the wall time is over
stopped 1 "stopped; go on with the same command and --restart out/checkpoint.kith" \
  "$kith" run tiny.yaml --quiet -o out --set resolution=2000 --walltime 0.001
stopped 1 "and --restart 'an out/checkpoint.kith'" \
  "$kith" run tiny.yaml --quiet -o 'an out' --set resolution=2000 --walltime 0.001
rm -rf out 'an out'

# ---- with inflow and outflow, the nodes that each step reports are those that were updated
ok "$kith" run tiny.yaml --quiet -o out --until 0.5 --set boundaries.x=[inflow,outflow] \
  --set regions.0.velocity=[1] --set regions.1.velocity=[1]
number() { sed -n "s/^  \"$1\": \(.*\),$/\1/p" out/report.json; }
awk -F, -v reported="$(number node_updates_per_second)" -v seconds="$(number wall_seconds)" '
  NR == 1 {for (k = 1; k <= NF; ++k) if ($k == "nodes") at = k}
  NR == 3 {first = $at}
  NR > 2 {sum += $at; last = $at}
  END {exit !(last > 1.2 * first && (reported * seconds - sum) ^ 2 < 1e-6)}' \
  out/history.csv || wrong "updates of nodes that come and go"
rm -rf out

# ---- a restart that makes no step, in another directory, has no samples of probes to draw
from=()
for directory in out elsewhere; do
  "$kith" run tiny.yaml --quiet -o "$directory" --until 0.01 --set output.checkpoint_at_end=true \
    --set output.plot=true --set "probes=[{name: p, at: [0, 0, 0]}]" "${from[@]}" >stdout 2>stderr ||
    wrong "probes in $directory: $(<stderr)"
  ! grep -q "probes.h5" stderr || wrong "pictures of probes in $directory: $(<stderr)"
  from=(--restart out/checkpoint.kith)
done
[[ ! -e elsewhere/probes.h5 ]] || wrong "a restart without a step has samples"
rm -rf out elsewhere

# ---- walls give angular momentum to the gas, so no error is reported
cat >walls.yaml <<'END'
scene: walls
dimension: 2
resolution: 8
domain: {lower: [-1, -1, 0], upper: [1, 1, 1]}
boundaries: {x: periodic, y: periodic, z: periodic}
materials: {gas: {}}
regions:
  - {material: gas, where: {x: [-1, 0.5]}, density: 1, pressure: 1, velocity: [-y, x]}
  - {material: gas, where: {x: [0.5, 1]}, density: 1, pressure: 1, barrier: true}
until: 0.01
output: {plot: false}
END
ok "$kith" run walls.yaml --quiet -o out
[[ $(number angular_momentum_drift) == null ]] || wrong "angular momentum beside walls"
grep -q "2-D, $(number gas_nodes) nodes and $(number frozen_nodes) frozen, " stdout ||
  wrong "nodes: $(head -1 stdout)"
ok "$kith" run walls.yaml --quiet -o out --overwrite --set regions.1.barrier=false
[[ $(number angular_momentum_drift) != null ]] || wrong "angular momentum without walls"
rm -rf out

# ---- restarts, against the uninterrupted run
# Prints what a report holds, except date, command, seconds, bytes and the calls of stages, which a restart
# counts from its own start.
counts() {
  sed '/"stages": {/,/^  }/d; /"peak_memory_bytes": {/,/}/d' "$1/report.json" |
    grep -v 'second\|bytes\|date\|command\|per_core'
}

# same_run A B: two directories hold the same results, except for these.
same_run() {
  local file
  for file in $(cd "$1" && ls snapshot_*.hdf) snapshots.hdf.series checkpoint.kith; do
    same "$1/$file" "$2/$file"
  done
  [[ $(ls "$1") == "$(ls "$2")" ]] || wrong "$2 holds other files than $1: $(ls "$2")"
  if ! diff <(sed 's/,[^,]*$//' "$1/history.csv") <(sed 's/,[^,]*$//' "$2/history.csv") >difference; then
    wrong "the histories of $1 and $2 differ: $(head -4 difference)"
  fi
  if ! diff <(counts "$1") <(counts "$2") >difference; then
    wrong "the reports of $1 and $2 differ: $(head -4 difference)"
  fi
}

# rows DIRECTORY N PROCESS: waits until the history of a run has N rows, or the run has ended.
rows() {
  local n=0
  while ((n < $2)) && kill -0 "$3" 2>/dev/null; do
    if [[ -e $1/history.csv ]]; then n=$(wc -l <"$1/history.csv"); fi
  done
}

for rebuild in always displacement; do
  set -- --quiet --set output.every=0.03 --set output.checkpoint=5 --set output.checkpoint_at_end=true \
    --set until=0.2 \
    --set resolution=600 --set connectivity.rebuild=$rebuild --set connectivity.reorder=7
  rm -rf whole
  ok "$kith" run tiny.yaml "$@" -o whole

  # Stopped after a number of steps.
  rm -rf parts
  for steps in 0 1 7 8 40; do
    restart=()
    if [[ -e parts ]]; then restart=(--restart parts/checkpoint.kith); fi
    ok "$kith" run tiny.yaml "$@" -o parts --steps $steps "${restart[@]}"
    # A checkpoint that is read and written at once is the same file.
    rm -rf other
    ok "$kith" run tiny.yaml "$@" -o other --steps $steps --restart parts/checkpoint.kith
    same parts/checkpoint.kith other/checkpoint.kith
  done
  ok "$kith" run tiny.yaml "$@" -o parts --restart parts/checkpoint.kith
  same_run whole parts

  # Stopped by a signal, twice.
  rm -rf parts
  "$kith" run tiny.yaml "$@" -o parts >stdout 2>stderr &
  rows parts 20 $! && kill -TERM $! && kill -USR1 $! # both signals count as one
  wait $!
  code=$?
  [[ $code == 1 &&
    $(<stderr) == "kith: stopped; go on with the same command and --restart parts/checkpoint.kith" ]] ||
    wrong "SIGTERM gave $code, $(<stderr)"
  before=$(wc -l <parts/history.csv)
  "$kith" run tiny.yaml "$@" -o parts --restart parts/checkpoint.kith >stdout 2>stderr &
  rows parts $((before + 20)) $! && kill -INT $!
  kill -TERM $! 2>/dev/null # INT is ignored by background jobs of a script
  wait $! && wrong "the second run was not stopped"
  ok "$kith" run tiny.yaml "$@" -o parts --restart parts/checkpoint.kith
  same_run whole parts

  # Killed repeatedly, at any place.
  rm -rf parts
  restart=()
  for kill in 1 2 3 4; do
    "$kith" run tiny.yaml "$@" -o parts "${restart[@]}" >stdout 2>stderr &
    rows parts $((kill * 25)) $!
    kill -KILL $!
    wait $! 2>/dev/null
    [[ -e parts/checkpoint.kith ]] || wrong "killed after $((kill * 25)) rows: no checkpoint"
    restart=(--restart parts/checkpoint.kith)
  done
  ok "$kith" run tiny.yaml "$@" -o parts "${restart[@]}"
  rm -f parts/*.partial
  same_run whole parts
done

# The other schemes.
for scheme in rk2 cheap-rk2 verlet arkode; do
  energy=compatible
  [[ $scheme == arkode ]] && energy=thermal
  rm -rf whole parts
  set -- --quiet --set output.every=0.03 --set output.checkpoint_at_end=true --set until=0.2 \
    --set resolution=200 \
    --set connectivity.rebuild=displacement --set scheme.name=$scheme --set method.energy=$energy
  ok "$kith" run tiny.yaml "$@" -o whole
  for steps in 7 20; do
    ok "$kith" run tiny.yaml "$@" -o parts --overwrite --steps $steps
    ok "$kith" run tiny.yaml "$@" -o parts --restart parts/checkpoint.kith
    rm -f parts/*.previous
    same_run whole parts
  done
done

# Only one run at a time may write to a directory, and no run may overwrite a checkpoint without --overwrite.
rm -rf parts
"$kith" run tiny.yaml "$@" -o parts >stdout 2>stderr &
rows parts 5 $!
kill -STOP $! # so that it does not end meanwhile
stopped 2 "parts: another run writes there" "$kith" run tiny.yaml "$@" -o parts
kill -CONT $!
wait $!
stopped 2 "parts: there is the checkpoint of an earlier run" "$kith" run tiny.yaml "$@" -o parts
old=(parts/snapshot_0123.hdf parts/frame_0123{.gp,.png,_map_1.bin,_profile.dat,_exact.dat,_mean.dat}
  parts/{map_1.bin,profile.dat,exact.dat,mean.dat,plot.gp,probe_line.dat,probe_plane_2.bin})
mine=(parts/{snapshot_of_mine.hdf,frame_0123_of_mine.dat,map_of_mine.bin,profile.dat.mine})
touch "${old[@]}" "${mine[@]}"
ok "$kith" run tiny.yaml "$@" -o parts --overwrite --steps 3
for file in "${old[@]}"; do [[ ! -e $file ]] || wrong "$file of an earlier run stays"; done
for file in "${mine[@]}"; do [[ -e $file ]] || wrong "$file goes"; done

# A restart into another directory does not change the first one, and lists only snapshots that are there.
rm -rf other parts
ok "$kith" run tiny.yaml "$@" --steps 30 -o parts
before=$(seen parts)
ok "$kith" run tiny.yaml "$@" -o other --restart parts/checkpoint.kith
[[ $(seen parts) == "$before" ]] || wrong "a restart changed the directory it came from"
same whole/checkpoint.kith other/checkpoint.kith
for file in $(grep -o 'snapshot_[0-9]*.hdf' other/snapshots.hdf.series); do
  [[ -e other/$file ]] || wrong "the series in another directory lists $file, which is not there"
done

# It does not continue tables and snapshots of a run that is already there.
stopped 2 "other: there is the checkpoint of an earlier run" \
  "$kith" run tiny.yaml "$@" -o other --restart parts/checkpoint.kith
ok "$kith" run tiny.yaml "$@" -o mixed --set resolution=100
ok "$kith" run tiny.yaml "$@" -o mixed --overwrite --restart parts/checkpoint.kith
for run in other mixed; do # without the seconds
  cut -d, -f1-20 $run/history.csv | cat - $run/snapshots.hdf.series >$run.rows
done
diff other.rows mixed.rows >difference ||
  wrong "a restart into the directory of another run: $(head -4 difference)"

# With another output.every, snapshots are at its multiples. That of the end of the first run is not kept.
rm -rf parts
ok "$kith" run tiny.yaml --quiet -o parts --set output.every=0.1 --set output.checkpoint_at_end=true \
  --until 0.05
ok "$kith" run tiny.yaml --quiet -o parts --set output.every=0.07 --restart parts/checkpoint.kith \
  --until 0.2
times=$(sed -n 's/.*"time": *//p' parts/snapshots.hdf.series | xargs printf '%.4g ')
[[ $times == "0 0.07 0.14 0.2 " ]] || wrong "a restart with another output.every has snapshots at $times"

# A restart that makes no step: snapshots after its checkpoint go, and the series does not list them. The
# checkpoint may be named by its directory.
set -- --quiet -o parts --set output.every=0.02
ok "$kith" run tiny.yaml "$@" --overwrite --until 0.04 --set output.checkpoint_at_end=true
ok "$kith" run tiny.yaml "$@" --until 0.09 --restart parts
ok "$kith" run tiny.yaml "$@" --until 0.04 --restart parts
[[ $(grep -o 'snapshot_[0-9]*.hdf' parts/snapshots.hdf.series) == "$(cd parts && ls snapshot_*.hdf)" ]] ||
  wrong "the series after a restart without a step: $(<parts/snapshots.hdf.series)"

# ---- a crash: one line and code 1, or a core where one is wanted; sanitizers have their own handlers
if ! ldd "$programs/kith-1d" | grep -qE 'lib(asan|tsan|ubsan)'; then
  for limit in 0 "$(ulimit -Hc)"; do
    rm -rf crash && mkdir crash
    (cd crash && ulimit -c "$limit" && exec "$programs/kith-1d" run ../tiny.yaml -o out --quiet \
      --set resolution=600 --until 20) >stdout 2>stderr &
    rows crash/out 20 $! && kill -SEGV $!
    wait $!
    code=$?
    [[ $code == $([[ $limit == 0 ]] && echo 1 || echo 139) && $(wc -l <stderr) == 1 &&
      $(<stderr) == "kith: crashed with signal SEGV, perhaps for want of memory; "* ]] ||
      wrong "a crash with a limit of cores of $limit gave $code, $(<stderr)"
  done
fi

# ---- steps of equal length
ok "$kith" run tiny.yaml --set scheme.dt=0.0025 --set until=0.05 --quiet -o equal
grep -q ", 20 steps to t = 0.05" stdout ||
  wrong "20 equal steps: $(grep "steps to" stdout)"

# ---- a full disk
rm -rf whole
set -- --quiet --set output.every=0.05 --set output.checkpoint=5 --set output.checkpoint_at_end=true \
  --set until=0.2 \
  --set scheme.dt=0.0001 --steps 1600
ok "$kith" run tiny.yaml "$@" -o whole

# stopped_full WHAT CODE TEXT: the run ended with one line, left no partial file, and continues from the last
# checkpoint, if there is one.
stopped_full() {
  local what=$1 code=$2 text=$3
  if ((code != 1)) || [[ $(wc -l <stderr) != 1 ]] ||
    [[ $(<stderr) != "kith: after step "*": parts/"*"$text" ]]; then
    wrong "$what: ended with $code: $(<stderr)"
  fi
  if compgen -G 'parts/*.partial' >/dev/null; then wrong "$what: half-written: $(ls parts/*.partial)"; fi
  [[ -e parts/checkpoint.kith ]] || return
  resumed=$((resumed + 1))
  ok "$kith" run tiny.yaml "${settings[@]}" -o parts --restart parts/checkpoint.kith
  same_run whole parts
}
settings=("$@") resumed=0

# Limits the size of files: first a snapshot is too large (its room is reserved ahead), later the history.
for ((limit = 1; resumed < 2 && limit < 500; limit += 1 + limit / 4)); do
  rm -rf parts
  (ulimit -f $limit && exec "$kith" run tiny.yaml "$@" -o parts) >/dev/null 2>stderr
  stopped_full "files of at most $limit KiB" $? "cannot write: File too large"
done
((resumed == 2)) || wrong "the history never was too large"

# Standard output cannot be written.
for words in "run tiny.yaml --quiet -o full" "plan tiny.yaml" "list" "validate list" "run --help"; do
  "$kith" $words >/dev/full 2>stderr
  code=$?
  ((code == 1)) && [[ $(<stderr) == "kith: standard output cannot be written" ]] ||
    wrong "kith $words >/dev/full ended with $code; stderr: $(<stderr)"
done

# A file system of limited size, where one can be mounted.
if unshare -rm true 2>/dev/null; then
  used=$(du -sk whole | cut -f1)
  for room in 100 $((used / 2)) $((used * 3 / 4)); do
    rm -rf parts small && mkdir small
    unshare -rm bash -c 'mount -t tmpfs -o size=$1k tmpfs small && cd small && shift || exit 9
      "$@"; code=$?; cp -r parts ..
      exit $code' - "$room" "$kith" run ../tiny.yaml "$@" -o parts >/dev/null 2>stderr
    code=$?
    ((code == 9)) && break # no tmpfs here
    stopped_full "a disk of $room KiB" $code "No space left on device"
  done
fi

exit $((failures > 0))
