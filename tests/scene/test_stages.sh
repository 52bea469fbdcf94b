#!/usr/bin/env bash
# test_stages.sh PROGRAMS INPUTS: the manual describes every stage that runs go through, the seconds of the
# stages of the first level sum to those of the whole program, and those of some to wall_seconds.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"
page=$inputs/../app/manual/stages.md

# stages NAME WORD...: makes a run of a few steps; all names in its trace must be in the manual.
stages() {
  local name=$1
  shift
  ok "$kith" run "$@" --quiet --steps 3 --trace $name.json -o $name
  grep -o '"ph":"X".*"path":"[^"]*"' $name.json | sed 's/.*"path":"//; s/"$//' | tr / '\n' | sort -u |
    while read -r stage; do grep -q "\`$stage\`" "$page" || echo "$stage"; done >missing
  [[ ! -s missing ]] || wrong "stages that the manual lacks: $(tr '\n' ' ' <missing)"
}
stages gather tiny.yaml
stages pairs tiny.yaml --set traversal=pairs --set method.package=crk
stages faces tiny.yaml --set method.package=mfm --set method.faces=integrated
stages magma2 tiny.yaml --set method.package=magma2
stages remix tiny.yaml --set method.package=remix
stages blocks tiny.yaml --set scheme.steps=block
stages culled "$inputs/plate.yaml" --set resolution=50 --set output.plot=false

# Flattened pairs are counted where lists of them are built.
"$kith" run tiny.yaml --quiet --profile --steps 1 -o unpaired >unpaired.txt
"$kith" run "$inputs/plate.yaml" --quiet --profile --steps 1 -o paired --set output.plot=false >paired.txt
! grep '\. .*pairs' unpaired.txt || wrong "pairs of lists that are not built"
grep -q '\. flattened pairs [1-9]' paired.txt || wrong "no flattened pairs at a barrier"

# The table of the progress: at the end of the run no node limits the step.
"$kith" run tiny.yaml -o gather >stdout 2>stderr
tail -n 1 stderr | grep -qE "^ +[0-9]+ .* end +- +[0-9]+ 100\.0% " || wrong "progress: $(<stderr)"

# The first samples of probes and of a growing mode are output, too.
ok "$kith" run "$inputs/streams.yaml" --quiet --steps 1 -o sampled --set output.plot=false

# About 1 % of the program is in no stage; on a busy machine up to 10 % are allowed.
for run in gather sampled; do
  awk '/"program_seconds"/ {program = $2 + 0}
    /"stages": \{/ {inside = 1}
    inside && /^    "[a-z-]*": \{/ {top = 1}
    inside && /^    "[a-z-]*\// {top = 0}
    top && /"seconds"/ {sum += $2; top = 0}
    END {if (!(sum > 0.9 * program && sum <= program)) print sum " of " program " seconds"}' \
    $run/report.json >differs
  [[ ! -s differs ]] || wrong "stages of the first level of $run: $(<differs)"
done

# wall_seconds are those of start, steps and output. The last snapshot is a third of them here.
awk '/"wall_seconds"/ {wall = $2 + 0}
  /^    "[a-z-]*(\/.*)?": \{/ {part = /"(start|step|output)"/}
  part && /"seconds"/ {sum += $2; part = 0}
  END {if (!(sum > 0.7 * wall && sum < 1.3 * wall)) print sum " of " wall " seconds"}' \
  gather/report.json >differs
[[ ! -s differs ]] || wrong "wall_seconds: $(<differs)"

# Seconds of history.csv count from the start of the program: the last row comes after set-up and steps.
awk -F '[,:]' 'FNR == NR {last = $NF + 0; next}
  /"program_seconds"/ {program = $2 + 0}
  /^    "[a-z-]*(\/.*)?": \{/ {part = /"(set-up|start|step)"/}
  part && /"seconds"/ {sum += $2; part = 0}
  END {if (!(last >= sum && last <= program)) print last ", not in " sum " to " program}' \
  gather/history.csv gather/report.json >differs
[[ ! -s differs ]] || wrong "seconds of history.csv: $(<differs)"

# The levels of block time steps, from the longest step to the shortest: nodes, updates and shares add up, and
# without --profile only what they saved is told.
"$kith" run tiny.yaml --quiet --profile -o levels --set scheme.steps=block --set resolution=400 >levels.txt
awk '/^  level  / {inside = 1; next}
  /^$/ {inside = 0}
  inside {$0 = substr($0, 25); ++n; nodes += $2; updates += $4; share += $5; time += $8
    if (n > 1 && $1 > 0.51 * last) print "steps " last " and " $1
    last = $1}
  / nodes, / {all = $3}
  END {if (n < 3 || nodes < 0.99 * all || nodes > 1.01 * all || share < 99 || share > 101 || time < 99 ||
    time > 101 || updates <= nodes) print n " levels, nodes " nodes " of " all ", shares " share " " time}' \
  levels.txt >differs
[[ ! -s differs ]] || wrong "levels of block time steps: $(<differs)"
"$kith" run tiny.yaml --quiet -o levels --set scheme.steps=block >levels.txt
grep -q 'achieved over ideal' levels.txt || wrong "what block time steps saved is not told"
! grep -q '^  level  ' levels.txt || wrong "levels are told without --profile"
"$kith" run tiny.yaml --quiet --profile -o levels >levels.txt
! grep -q 'block time steps' levels.txt || wrong "a global step has levels"

exit $((failures > 0))
