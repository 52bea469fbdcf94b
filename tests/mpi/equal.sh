#!/bin/sh
# equal.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY TOLERANCE RANKS SETTING...: runs a scene on one process and
# on each number of RANKS (in quotes). The last snapshots must agree, node by node, within TOLERANCE; with
# "bytes", first and last snapshots, norms, measures, probes and contacts must be identical. If energy is
# conserved by construction, it must be so to 1e-12 on every number of ranks.
mpirun=$1 program=$2 compare=$3 scene=$4 out=$5 tolerance=$6 counts=$7
shift 7
words=
for setting; do words="$words --set $setting"; done
run() { # directory command...
  directory=$1
  shift
  rm -f "$directory"/snapshot_*.hdf
  "$@" run "$scene" --set output.plot=false $words -q -o "$directory" > "$directory.log" 2>&1 && return
  echo "failed: $*"; cat "$directory.log"; exit 1
}
[ -f "$scene" ] && mkdir -p "$out" || { echo "equal.sh: wrong words"; exit 1; }
run "$out/1" "$program"
for n in $counts; do
  run "$out/$n" $mpirun -n "$n" "$program"
  last=$(ls "$out/$n"/snapshot_*.hdf | tail -1)
  "$compare" "$out/1/${last##*/}" "$last" "$tolerance" || { echo "$n ranks differ from one process"; exit 1; }
  for k in 1 "$n"; do
    sed -n '/^  "norms": {$/,/^  }/p;/^  "measures": {$/,/^  }/p' "$out/$k/report.json" > "$out/$k/compared"
  done
  for file in snapshot_0000.hdf compared probes.h5 contacts.csv; do
    [ "$tolerance" = bytes ] && [ -f "$out/1/$file" ] || continue
    cmp "$out/1/$file" "$out/$n/$file" || { echo "$n ranks: $file differs from one process"; exit 1; }
  done
  drift=$(sed -n 's/.*"energy_drift": \([^,]*\),.*/\1/p' "$out/$n/report.json")
  case " $* " in *method.energy=thermal*) continue ;; esac
  awk "BEGIN { exit !($drift <= 1e-12) }" || { echo "$n ranks: energy conservation error $drift"; exit 1; }
done
