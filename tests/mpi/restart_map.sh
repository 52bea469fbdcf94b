#!/bin/sh
# restart_map.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY PARTITIONERS SETTING...: restarts where the map of
# cells to ranks changes with every rebuild of lists, for each of the PARTITIONERS (in quotes; "all": those
# that are available). 3 ranks write a checkpoint after step 6. A restart from it to step 12 gives the fields
# of an uninterrupted run bit by bit, and its checkpoint, with map, order of nodes and ledger, is the same
# file.
mpirun=$1 program=$2 compare=$3 scene=$4 out=$5 names=$6
shift 6
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
failed=0 tried=0 count=0
[ "$names" != all ] ||
  names="diffusion,flow=second-order,neighbors=fixed,start=morton $("$program" list partitioner |
    awk '/^    [^ ]/ && !/not available/ {print $1}')"
for words_of_name in $names; do # NAME,KEY=VALUE,KEY=VALUE
  name="${words_of_name%%,*} $(echo "$words_of_name" | sed 's/^[^,]*//; s/,/ --set partition./g')"
  run "$out/whole" --steps 12 --set partition.name=$name
  run "$out/first" --steps 6 --set partition.name=$name
  run "$out/second" --steps 12 --set partition.name=$name --restart "$out/first/checkpoint.kith"
  "$compare" "$(last "$out/whole")" "$(last "$out/second")" 0 > "$out/log" ||
    { echo "$name: the state differs: $(cat "$out/log")"; failed=1; }
  "$compare" "$out/whole/checkpoint.kith" "$out/second/checkpoint.kith" bytes ||
    { echo "$name: the checkpoints differ"; failed=1; }
  made=$(sed -n '/"repartitions"/ {s/.*: \([0-9]*\).*/\1/p; q}' "$out/whole/report.json")
  count=$((count + 1))
  [ "$made" -eq 0 ] || tried=$((tried + 1)) # cart never makes one, and others may have converged
done
[ $tried -ge $((count * 6 / 10)) ] && [ $tried -ge 2 ] ||
  { echo "only $tried partitioners made a map"; failed=1; }
exit $failed
