#!/usr/bin/env bash
# test_growth.sh PROGRAMS INPUTS: measures.growth in the report is the rate that follows from growth.csv; a
# restart continues that file; its picture has the curve of linear theory; and there is one movie frame per
# snapshot.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"
[[ -x $programs/kith-2d ]] || exit 0

run() { ok "$kith" run "$inputs/shear-layer.yaml" --quiet --set resolution=12 --set until=0.6 "$@"; }
run -o whole
awk -F, 'NR > 1 {n++; if (NR == 2) first = $3; time = $2; last = $3}
  END {a = last / first; print n, log(a + sqrt(a * a - 1)) / time}' whole/growth.csv >made
read -r n rate <made
reported=$(awk '/"growth":/ {print $2}' whole/report.json)
awk -v a="$rate" -v b="$reported" 'BEGIN {exit !(a > 0 && (a - b) ^ 2 < 1e-12)}' ||
  wrong "growth.csv gives the rate $rate, the report $reported"
((n > 20 && n <= 101)) || wrong "$n samples of the amplitude"
if command -v gnuplot >/dev/null; then
  grep -q 'cosh(0.873 \* x)' whole/growth.gp || wrong "no theory in the picture"
  (($(stat -c %s whole/growth.png) > 10000)) || wrong "an empty picture"
fi

run -o parts --steps 20 --set output.checkpoint_at_end=true
run -o parts --restart parts/checkpoint.kith --set output.checkpoint_at_end=true
same whole/growth.csv parts/growth.csv

# ---- a restart that makes no step, in another directory, has no samples to draw
if command -v gnuplot >/dev/null; then
  run -o elsewhere --restart parts/checkpoint.kith --set measure.rate=
fi

# ---- a mode that shrinks has no rate
ok "$kith" run "$inputs/rayleigh-taylor.yaml" --quiet -o shrinks --set dimension=2 --set resolution=24 \
  --set output.plot=false
grep -q '^    growth none: there is nothing' stdout || wrong "a mode that shrinks: $(grep growth stdout)"

# ---- one frame per snapshot; frames of an earlier, longer run are removed
if command -v gnuplot >/dev/null; then
  run -o movie --set output.every=0.15 --set output.plot.frames=true
  run -o movie --set output.every=0.3 --set output.plot.frames=true
  [[ $(cd movie && echo frame_*.png) == 'frame_0000.png frame_0001.png frame_0002.png' ]] ||
    wrong "frames of three snapshots: $(cd movie && ls)"
fi

exit $((failures > 0))
