#!/usr/bin/env bash
# failures.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY CASE: when one of 3 ranks fails in the middle of a run,
# all of them end within seconds, and restarts from the last checkpoint, on 2 ranks and on 1, give the fields
# of an uninterrupted run to round-off. Skipped (77) where a case is impossible.
#   full-disk   the file system is full while a snapshot or a checkpoint is written
#   file-size   the same, by a limit on the size of files
#   no-memory   a rank gets no more memory
#   killed      a rank is killed
#   waiting     a rank is suspended: the others report it (--watchdog), and continue when it does
#   stopped     the program starts mpirun itself, and gets signals, or one of its ranks is killed
mpirun=$1 program=$2 compare=$3 scene=$4 out=$5/$6
source_of_scene=$(cd "$(dirname "$scene")" && pwd)/$(basename "$scene")
rm -rf "$out" && mkdir -p "$out" && cd "$out" || exit 1
failures=0
settings=(--set output.plot=false --set resolution=8000 --set until=1 --set scheme.dt=5e-6 -q)
wrong() {
  echo "$*"
  failures=1
}
skip() {
  echo "$*"
  exit 77
}

# go RANKS DIRECTORY WORDS...: a run that must succeed.
go() {
  local ranks=$1 directory=$2
  shift 2
  timeout 100 $mpirun -n "$ranks" "$program" run "$source_of_scene" "${settings[@]}" -o "$directory" "$@" \
    >log 2>&1 ||
    wrong "failed on $ranks ranks: $* $(cat log)"
}
step_of() { tail -1 "$1/history.csv" | cut -d, -f1; }
last() { ls "$1"/snapshot_*.hdf | tail -1; }

# ended WHAT CODE TEXT: the run ended with code 1 and one line on stderr, and left no partial file.
ended() {
  [[ $2 == 1 && $(grep -c '^kith:' stderr) == 1 ]] && grep -q "^kith:.*$3" stderr ||
    wrong "$1: ended with $2: $(<stderr)"
  ! compgen -G 'run/*.partial' >/dev/null || wrong "$1: half-written: $(ls run/*.partial)"
}

# goes_on WHAT: continues from the checkpoint of `run` on each number of ranks in `restarts`, and compares
# with an uninterrupted run. Both sum in different orders: 1e-11 allows for round-off.
restarts="2 1"
goes_on() {
  [[ -s run/checkpoint.kith ]] || { wrong "$1: no checkpoint"; return; }
  local steps=$(($(step_of run) + 20)) ranks
  go 3 whole --steps "$steps" "${@:2}"
  for ranks in $restarts; do
    rm -rf again
    go $ranks again --steps "$steps" --restart run/checkpoint.kith "${@:2}"
    "$compare" "$(last whole)" "$(last again)" 1e-11 >log 2>&1 ||
      wrong "$1: the restart on $ranks ranks differs: $(cat log)"
  done
  rm -rf whole again
}

# Writes the process id, and becomes the program.
self='echo $$ >pid.$OMPI_COMM_WORLD_RANK; exec "$@"'
start() {
  rm -rf run pid.*
  timeout 100 $mpirun --quiet -n 3 sh -c "$self" sh "$program" run "$source_of_scene" "${settings[@]}" \
    -o run "$@" >stdout 2>stderr &
  job=$!
}
# Waits until the run has written a checkpoint, and made some more steps.
wait_for_steps() {
  while kill -0 $job 2>/dev/null && [[ ! -s run/checkpoint.kith ]]; do sleep 0.05; done
  local now
  now=$(step_of run)
  while kill -0 $job 2>/dev/null && [[ $(step_of run) -le $((now + 2)) ]]; do sleep 0.02; done
  kill -0 $job 2>/dev/null || wrong "the run ended by itself: $(<stderr)"
}
# Suspends rank 0, which writes the history, between two outputs (these are 20 steps apart), so that a limit
# that is set now meets the next output from its first byte.
hold_between_outputs() {
  local step process
  process=$(<pid.0)
  while kill -STOP "$process" 2>/dev/null; do
    while is_there "$process" && ! grep -q '^State:[[:space:]]*T' "/proc/$process/status"; do sleep 0.01; done
    step=$(step_of run)
    ((step % 20 > 2 && step % 20 < 18)) && return
    kill -CONT "$process"
    sleep 0.01
  done
  wrong "the run ended by itself: $(<stderr)"
}
# is_there PROCESS: a process that was killed but not yet waited for does not count.
is_there() { grep -q '^State:[[:space:]]*[^ZX]' "/proc/$1/status" 2>/dev/null; }
# finish WHAT: all ranks must end within 20 seconds; sets `code`.
finish() {
  local rank tries
  (sleep 20 && kill $job) >/dev/null 2>&1 &
  local watch=$!
  wait $job
  code=$?
  kill $watch 2>/dev/null || wrong "$1: not over within 20 seconds"
  for rank in 0 1 2; do
    for ((tries = 0; tries < 50; ++tries)); do # mpirun ends before the processes that it kills
      is_there "$(<pid.$rank)" && sleep 0.1
    done
    ! is_there "$(<pid.$rank)" || wrong "$1: rank $rank is still there"
  done
}

# full WHAT KIB SETTING...: a run on a file system of so many KiB.
full() {
  local what=$1 room=$2 words=()
  shift 2
  for setting; do words+=(--set "$setting"); done
  rm -rf run small && mkdir small
  timeout 60 unshare -rm bash -c 'mount -t tmpfs -o size=$1k tmpfs small && cd small && shift || exit 77
    "$@"; code=$?; cp -r run ..; exit $code' - "$room" $mpirun --quiet -n 3 "$program" run \
    "$source_of_scene" "${settings[@]}" -o run \
    "${words[@]}" >stdout 2>stderr
  local code=$?
  [[ $code != 77 ]] || skip "no tmpfs here"
  ended "$what" $code "$what.*: cannot write: No space left on device"
  goes_on "$what" "${words[@]}"
}
# limited RANK WHAT TEXT SETTING...: in the middle of a run, files of one rank are limited to 128 KiB.
limited() {
  local rank=$1 what=$2 text=$3 words=()
  shift 3
  for setting; do words+=(--set "$setting"); done
  start "${words[@]}"
  wait_for_steps
  hold_between_outputs
  prlimit --pid "$(<pid.$rank)" --fsize=131072 || skip "no limits here"
  kill -CONT "$(<pid.0)"
  finish "$what"
  ended "$what on rank $rank" $code "rank $rank: .*$what.*: cannot write: $text"
  goes_on "$what on rank $rank" "${words[@]}"
}

case $6 in
  full-disk)
    unshare -rm true 2>/dev/null || skip "no namespaces here"
    go 3 sizes --steps 4 --set output.checkpoint=2
    snapshot=$(du -k "$(last sizes)" | cut -f1) checkpoint=$(du -k sizes/checkpoint.kith | cut -f1)
    # Enough for the first snapshot and two and a half checkpoints: the third one fails.
    full checkpoint.kith $((16 + snapshot + checkpoint * 5 / 2)) output.checkpoint=20
    # Enough for two and a half snapshots; each is larger than a checkpoint.
    full snapshot_ $((16 + snapshot * 5 / 2 + checkpoint * 5 / 2)) output.checkpoint=20 output.every=1.1e-4
    ;;
  file-size)
    command -v prlimit >/dev/null || skip "no prlimit here"
    limited 0 checkpoint.kith "File too large" output.checkpoint=20
    restarts=2 # the checkpoint was written before the snapshot failed, as in any run
    limited 0 snapshot_ "File too large" output.checkpoint=20 output.every=1e-4 until=0.9
    limited 1 snapshot_ "File too large" output.checkpoint=20 output.every=1e-4 until=0.9
    ;;
  no-memory)
    command -v prlimit >/dev/null || skip "no prlimit here"
    # Two thirds of the nodes are in the dense half of the tube: with every balance check rank 2 gets more
    # nodes.
    grow=(--set output.checkpoint=20 --set resolution=40000 --set scheme.dt=1e-6
      --set partition.name=diffusion --set partition.every=1
      --set partition.imbalance=1 --set partition.cells=100)
    start "${grow[@]}"
    wait_for_steps
    size=$(awk '/^VmSize/ {print $2}' "/proc/$(<pid.2)/status")
    prlimit --pid "$(<pid.2)" --as=$((size * 1024 + 1000000)) || skip "no limits here"
    finish "no memory"
    ended "no memory" $code "rank 2: cannot get [0-9]* bytes of memory"
    goes_on "no memory" "${grow[@]}"
    ;;
  killed)
    start --set output.checkpoint=20
    wait_for_steps
    kill -KILL "$(<pid.1)"
    finish "a killed rank"
    [[ $code != 0 && $code != 143 ]] || wrong "a killed rank: code $code"
    goes_on "a killed rank" --set output.checkpoint=20
    ;;
  waiting)
    start --watchdog 1 --set output.checkpoint=20
    wait_for_steps
    kill -STOP "$(<pid.1)"
    sleep 3
    now=$(step_of run)
    kill -CONT "$(<pid.1)"
    for ((tries = 0; tries < 200; ++tries)); do (($(step_of run) > now)) || sleep 0.05; done
    (($(step_of run) > now)) || wrong "it does not go on"
    for rank in 0 2; do
      grep -q "^kith: rank $rank has waited 1 s for .* in [a-z]" stderr || wrong "rank $rank: $(<stderr)"
    done
    kill $job
    finish "a rank that stood still"
    ;;
  stopped)
    # stop WHAT SIGNAL...: a run on 3 ranks gets the signals; "rank" kills one of its ranks. Sets `code`.
    stop() {
      local what=$1
      shift
      rm -rf run
      timeout 100 "$program" run "$source_of_scene" --ranks 3 "${settings[@]}" -o run \
        --set output.checkpoint=20 >stdout 2>stderr &
      job=$!
      wait_for_steps
      ruler=$(pgrep -P $job) # a signal to `timeout` itself would end the run differently
      for signal; do
        [[ $signal == rank ]] || kill "-$signal" "$ruler"
        [[ $signal != rank ]] || pkill -KILL -n -f "$source_of_scene --ranks 3"
      done
      wait $job
      code=$?
      [[ $code == 1 ]] || wrong "$what: ended with $code: $(<stderr)"
    }
    stop "a signal" TERM
    ended "a signal" $code "stopped; go on with the same command and --restart run/checkpoint.kith"
    goes_on "a signal" --set output.checkpoint=20
    stop "two signals" INT TERM
    grep -q "^kith: stopped" stderr || wrong "two signals: $(<stderr)" # in time, or at once
    stop "a killed rank" rank
    grep -q "^kith: a rank was ended by signal 9" stderr || wrong "a killed rank: $(<stderr)"
    ;;
  *) wrong "unknown case $6" ;;
esac
exit $failures
