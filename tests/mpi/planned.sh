#!/usr/bin/env bash
# planned.sh MPIRUN PROGRAM COMPARE SCENE DIRECTORY RANKS SETTING...: ghosts, messages and bytes that `plan`
# announces are those of a run; profile and trace of this run include all ranks.
set -euo pipefail
mpirun=$1 program=$2 scene=$4 out=$5 ranks=$6
shift 6
settings=()
for setting in "$@"; do settings+=(--set "$setting"); done
rm -rf "$out" && mkdir -p "$out"
$mpirun -n "$ranks" "$program" run "$scene" "${settings[@]}" --set output.plot=false --steps 4 --quiet \
  --profile --trace "$out/trace.json" -o "$out" >"$out/profile"
"$program" plan "$scene" "${settings[@]}" --ranks "$ranks" >"$out/plan"
# number KEY: a number in the report; of a distribution over ranks, its mean.
number() {
  awk -v key="\"$1\":" '
    $1 == key {inner = $2 == "{"; if (!inner) value = $2}
    inner && $1 == "\"mean\":" {value = $2; inner = 0}
    END {print value + 0}' "$out/report.json"
}
# near WHAT RUN PLAN SHARE MORE: run and plan differ by at most SHARE of the run's number plus MORE.
near() {
  awk -v run="$2" -v plan="$3" -v share="$4" -v more="$5" \
    'BEGIN {d = run - plan; exit !(run > 0 && (d < 0 ? -d : d) <= more + share * run)}' ||
    { echo "$1: $2 in the run, $3 in the plan" && exit 1; }
}
for ((rank = 0; rank < ranks; ++rank)); do
  (($(grep -c "\"ph\":\"X\",\"pid\":$rank,.*\"path\":\"step/lifecycle\"" "$out/trace.json") >= 4)) ||
    { echo "the trace lacks rank $rank" && exit 1; }
done
[[ $(head -1 "$out/trace.json")$(tail -1 "$out/trace.json") == "[]" ]] ||
  { echo "the trace is not whole" && exit 1; }
grep -o '"path":"[^"]*"' "$out/trace.json" | sort -u | sed 's/"path":\(.*\)/\1: {/' >"$out/stages"
while read -r stage; do
  grep -qF "$stage" "$out/report.json" || { echo "the report lacks a stage of a rank: $stage" && exit 1; }
  name=${stage%'": {'} name=${name##*[/\"]}
  grep -qF "\`$name\`" "$(dirname "$0")/../../app/manual/stages.md" ||
    { echo "the manual lacks a stage of a rank: $stage" && exit 1; }
done <"$out/stages"
grep -q '"step/lifecycle/allreduce"' "$out/stages" ||
  { echo "no stage shows the wait for other ranks" && exit 1; }
grep -q "remote_ghosts_kept" "$out/profile" || { echo "the profile lacks the ranks" && exit 1; }
# There are four collective calls per step, and one more in one step of 20, to check the balance.
case "${settings[*]}" in
  *scheme* | *method*) ;;
  *)
    awk -v n="$(number collectives_per_step)" 'BEGIN {exit !(n == 4)}' ||
      { echo "$(number collectives_per_step) collective calls a step" && exit 1; }
    ;;
esac
planned() { awk -v column="$1" '$1 == "kd" {print $column}' "$out/plan"; }
# of_a_list KEY: the number per rank and rebuild of lists.
of_a_list() {
  awk -v all="$(number "$1")" -v lists="$(number lifecycles)" -v n="$ranks" 'BEGIN {print all / lists / n}'
}
# The plan rounds to whole nodes per rank, and steps move about 1 % of the nodes to another rank. Where ghosts
# have rows, and these overlap, a few more ghosts are kept.
share=0.01
[[ ${settings[*]} == *integrated* ]] && share=0.05
near ghosts "$(of_a_list remote_ghosts_kept)" "$(planned 3)" $share 1
# Messages and bytes per rank and step; the plan has none for nodes that move to another rank.
near messages "$(number messages_per_step)" "$(planned 7)" 0.02 1
bytes=$(awk 'BEGIN {unit["B"] = 1; unit["KiB"] = 1024; unit["MiB"] = 1048576}
  $1 == "kd" {print $8 * unit[$9]}' "$out/plan")
near bytes "$(number bytes_per_step)" "$bytes" 0.05 100
