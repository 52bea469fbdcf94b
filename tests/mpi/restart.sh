#!/bin/sh
# restart.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY SETTING...: 3 ranks write a checkpoint after step 10, and
# runs restart from it and continue to step 20. On 3 ranks their fields are those of an uninterrupted run, bit
# by bit; on 1 and 4 ranks to round-off, or bit by bit if SETTINGs have reproducible=true. The progress shows
# the ghosts of all ranks, as the history does.
mpirun=$1 program=$2 compare=$3 scene=$4 out=$5
shift 5
words=
for setting; do words="$words --set $setting"; done
[ -f "$scene" ] && mkdir -p "$out" || { echo "restart.sh: wrong words"; exit 1; }
run() { # directory ranks words...
  directory=$1 ranks=$2
  shift 2
  rm -f "$directory"/snapshot_*.hdf
  $mpirun -n "$ranks" "$program" run "$scene" --set output.plot=false --set output.checkpoint=10 $words \
    --overwrite -o "$directory" "$@" > "$directory.log" 2>&1 && return
  echo "failed: $ranks ranks $*"; cat "$directory.log"; exit 1
}
last() { ls "$1"/snapshot_*.hdf | tail -1; }
run "$out/whole" 3 --steps 20
shown=$(awk '$7 ~ /^[0-9.]+%$/ {ghosts = $6} END {print ghosts}' "$out/whole.log")
ghosts=$(awk -F, 'NR == 1 {while ($++at != "ghosts");} END {print $at}' "$out/whole/history.csv")
[ "$shown" = "$ghosts" ] || { echo "progress: '$shown' ghosts of $ghosts"; exit 1; }
run "$out/first" 3 --steps 10
for ranks in 3 1 4; do
  run "$out/on$ranks" $ranks --steps 20 --restart "$out/first/checkpoint.kith"
  tolerance=1e-11
  [ $ranks = 3 ] && tolerance=0
  case " $words " in *" reproducible=true "*) tolerance=0 ;; esac
  "$compare" "$(last "$out/whole")" "$(last "$out/on$ranks")" $tolerance ||
    { echo "restart on $ranks ranks differs"; exit 1; }
done
