#!/bin/sh
# wrong.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY: an error in a run of several ranks is reported once, in one
# line; all ranks end, with the exit code of a single process.
mpirun="$1 --quiet" program=$2 scene=$4 out=$5
[ -f "$scene" ] && mkdir -p "$out" || { echo "wrong.sh: wrong words"; exit 1; }
failed=0
expect() { # code, words of the message, command...
  code=$1 message=$2
  shift 2
  timeout 60 "$@" > "$out/out" 2> "$out/err"
  got=$?
  lines=$(grep -c '^kith:' "$out/err")
  [ $got = $code ] && [ "$lines" = 1 ] && grep -q "$message" "$out/err" && return
  echo "$*: code $got (wanted $code), $lines lines with kith:"; cat "$out/err"; failed=1
}
run="$program run $scene --set output.plot=false -q -o $out/run"
expect 2 "'kdd' is not one of" $mpirun -n 3 $run --set partition.name=kdd
expect 2 "means nothing for kd, only for diffusion, hybrid" $mpirun -n 3 $run --set partition.flow=willebeek
expect 2 "'foo' is not one of" $mpirun -n 3 $run --set partition.name=diffusion --set partition.flow=foo
expect 2 "out of range \[1, 1000\]" $mpirun -n 3 $run --set partition.name=hybrid \
  --set partition.iterations=0
expect 2 "3 processes were started" $mpirun -n 3 $run --ranks 2
expect 2 "no such file\|No such file" $mpirun -n 2 $program run "$out/none.yaml"
expect 2 "/proc/none: No such file" $mpirun -n 2 $program run $scene -q -o /proc/none
expect 2 "not a checkpoint\|No such file" $mpirun -n 2 $run --restart "$out/none.kith"
expect 1 \
  "its energy is negative\|is not finite\|does not converge\|collapsed\|far outside\|more than 1000 images" \
  $mpirun -n 3 $run --set scheme.dt=0.05 --set scheme.name=rk4 --set method.energy=thermal
# Images of other ranks do not hide that supports find no neighbors.
expect 1 "does not find its neighbors" $mpirun -n 3 $run --set boundaries.x=periodic --set resolution=10 \
  --set connectivity.exclude=materials:of=gas
# Errors that all ranks find at the same time.
expect 1 "no policy rebuilds the lists in time" $mpirun -n 3 $run --set connectivity.rebuild=never \
  --set connectivity.skin=0.01
expect 1 "no policy rebuilds the lists in time" $mpirun -n 3 $run --set connectivity.rebuild=never \
  --set connectivity.skin=0.01 --set scheme.name=rk2
$program run $scene --set output.plot=false -q -o "$out/first" --overwrite --steps 2 \
  --set output.checkpoint_at_end=true > "$out/out" 2>&1
cp "$out/first/checkpoint.kith" "$out/damaged.kith" &&
  printf 'damage' | dd of="$out/damaged.kith" bs=1 seek=2000 conv=notrunc 2> "$out/err" || failed=1
expect 2 "its checksum is wrong" $mpirun -n 3 $run --restart "$out/damaged.kith"
# Settings that only affect several ranks are checked on one process too.
expect 2 "does not compute values of ghosts" $run --set partition.ghosts=recompute --set method.package=crk
expect 2 "only the owner of a node keeps the history" $run --set partition.ghosts=recompute \
  --set method.viscosity.name=cullen-dehnen
expect 2 "reproducible runs take exchange" $run --set partition.ghosts=recompute --set reproducible=true
# More threads than cores causes one warning, and the run continues; one thread on one core causes none.
core=$(sed -n 's/^Cpus_allowed_list:[^0-9]*\([0-9]*\).*/\1/p' /proc/self/status)
once="--threads 1 --steps 1 --overwrite --set output.plot=false -o $out/bound"
expect 0 "2 ranks of 1 thread share 1 core" $mpirun --bind-to none -n 2 taskset -c "$core" \
  $program run $scene $once
$program run $scene $once 2>&1 | grep -q "^kith: warning" && { echo "a warning of one thread"; failed=1; }
# More ranks than nodes and cells: some ranks have none.
few="$program run $scene --set output.plot=false -q -o $out/few --set resolution=2 --steps 2"
few="$few --set partition.cells=1"
timeout 60 $mpirun -n 7 $few > "$out/out" 2>&1 || { echo "more ranks than nodes:"; cat "$out/out"; failed=1; }
# When rank 0 cannot write a checkpoint, all ranks stop, and none waits for it.
rm -rf "$out/full" && mkdir -p "$out/full/checkpoint.kith.partial" || exit 1
expect 1 "checkpoint.kith: cannot write" $mpirun -n 3 $program run "$scene" --set output.plot=false -q \
  -o "$out/full" --set output.checkpoint=1
exit $failed
