#!/bin/sh
# restart_map.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY SETTING...: with every partitioner, the map is looked at, and made anew, whenever lists are: 3 ranks write a
# checkpoint after step 6 and are carried on to step 12, bit for bit as if they had never stopped, map, order of nodes and ledger included: the checkpoints of step
# 12 are the same file.
mpirun=$1 program=$2 compare=$3 scene=$4 out=$5
shift 5
words="--set output.plot=false --set output.checkpoint=6 --set partition.every=1 --set partition.imbalance=1"
for setting; do words="$words --set $setting"; done
[ -f "$scene" ] && mkdir -p "$out" || { echo "restart_map.sh: wrong words"; exit 1; }
run() { # directory words...
  directory=$1
  shift
  rm -rf "$directory"
  $mpirun -n 3 "$program" run "$scene" $words -q -o "$directory" "$@" > "$out/log" 2>&1 && return
  echo "failed: $*"; cat "$out/log"; exit 1
}
last() { ls "$1"/snapshot_*.hdf | tail -1; }
failed=0 tried=0
for name in $("$program" list partitioner | awk '/^    / && !/not available/ {print $1}') diffusion:second-order,fixed,morton; do
  run "$out/whole" --steps 12 --set partition.name=$name
  run "$out/first" --steps 6 --set partition.name=$name
  run "$out/second" --steps 12 --set partition.name=$name --restart "$out/first/checkpoint.kith"
  "$compare" "$(last "$out/whole")" "$(last "$out/second")" 0 > "$out/log" || { echo "$name: the state differs: $(cat "$out/log")"; failed=1; }
  "$compare" "$out/whole/checkpoint.kith" "$out/second/checkpoint.kith" bytes || { echo "$name: the checkpoints differ"; failed=1; }
  made=$(sed -n '/"repartitions"/ {s/.*: \([0-9]*\).*/\1/p; q}' "$out/whole/report.json")
  [ "$made" -eq 0 ] || tried=$((tried + 1)) # cart never makes one, others may be at rest
done
[ $tried -ge 6 ] || { echo "only $tried partitioners made a map"; failed=1; }
exit $failed
