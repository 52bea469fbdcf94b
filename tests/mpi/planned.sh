#!/usr/bin/env bash
# planned.sh MPIRUN PROGRAM SCENE RANKS FOLDER SETTING...: the ghosts that `plan --ranks` tells of are those that a run makes.
set -euo pipefail
mpirun=$1 program=$2 scene=$3 ranks=$4 out=$5
shift 5
settings=()
for setting in "$@"; do settings+=(--set "$setting"); done
rm -rf "$out"
$mpirun -n "$ranks" "$program" run "$scene" "${settings[@]}" --set output.plot=false --steps 1 --quiet -o "$out" >/dev/null
made=$(awk -F'[:,]' '/"remote_ghosts_created"/ {made = $2} /"lifecycles"/ {cycles = $2} END {print made / cycles}' "$out/report.json")
planned=$("$program" plan "$scene" "${settings[@]}" --ranks "$ranks" --quiet | awk -v n="$ranks" '$1 == "kd" {print $5 * n}')
# The plan rounds to whole nodes a rank; a step moves a node in a hundred across a face.
awk -v made="$made" -v planned="$planned" -v n="$ranks" 'BEGIN {d = made - planned; exit !(made > 0 && (d < 0 ? -d : d) <= n + 0.01 * made)}' ||
  { echo "made $made, planned $planned"; exit 1; }
