#!/usr/bin/env bash
# test_chart.sh PROGRAMS INPUTS: charts and stress sweeps from end to end: a small suite with a method that
# fails, the files that are written, continuing after a kill, and everything that is refused before a run.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"
cp "$inputs/sod.yaml" .

cat >small.yaml <<'END_YAML'
scene: sod.yaml
dimension: 1
settings: {arrangement: equal-mass}
methods:
  - {name: sph, settings: {method.package: sph}}
  - {name: alpha <1>, settings: {method.viscosity: {name: monaghan}}}
  - {name: blows up, settings: {scheme.dt: 0.05}}
resolution: [50, 100, 200]
norms: [density.l1, velocity.l1]
targets: [0.02, 0.05]
reference_codes:
  - {code: 'A <code> & "more"', machine: another machine, resolution: 50, cpu_seconds: 0.05,
     norms: {density.l1: 0.03}}
END_YAML

# ---- refused with one line and code 2, and nothing is created
# bad TEXT YAML...: a suite of these lines is refused with TEXT
bad() {
  printf '%s\n' "${@:2}" >bad.yaml
  refused "$1" "$kith" chart bad.yaml -o out
}
bad "bad.yaml:2: method b: --set method.package: 'spf'" 'scene: sod' \
  'methods: [{name: a}, {name: b, settings: {method.package: spf}}]' 'resolution: [50]'
bad "bad.yaml:2: method b: --set method.viscosity.alfa: unknown key; did you mean 'alpha'?" 'scene: sod' \
  'methods: [{name: a}, {name: b, settings: {method.viscosity.alfa: 1}}]' 'resolution: [50]'
bad "bad.yaml:3: method sod: --set materials.gas.gama: unknown key" 'scene: sod' \
  'settings: {materials.gas.gama: 2}' 'resolution: [50]'
bad "bad.yaml:1: scene: the scene has no exact solution" 'scene: tiny.yaml' 'resolution: [50]'
bad "bad.yaml:2: methods: more than 100" 'scene: sod' "methods: [$(seq -f '{name: %g}' -s ', ' 1 101)]" \
  'resolution: [50]'
bad "bad.yaml:2: resolution: more than 64" 'scene: sod' "resolution: [$(seq -s ', ' 1 65)]"
bad "bad.yaml:2: methods.0.name: 'a|b': a bar would end a column" 'scene: sod' 'methods: [{name: a|b}]' \
  'resolution: [50]'
bad "bad.yaml:3: reference_codes.0.machine: 'x|y': a bar would end a column" 'scene: sod' 'resolution: [50]' \
  'reference_codes: [{code: x, machine: x|y, resolution: 5, cpu_seconds: 1, norms: {density.l1: 1}}]'
refused "no suite 'sod-1e'; did you mean 'sod-1d'?" "$kith" chart sod-1e
refused "chart: SUITE is missing" "$kith" chart
refused "nothere.yaml: No such file" "$kith" chart nothere.yaml
refused "sod.yaml:3: this is a scene; a chart needs a suite" "$kith" chart sod.yaml -o out
refused "did you mean 'mach'?" "$kith" stress mack -o out
refused "kith: --set foo: unknown key" "$kith" stress mach --set foo=1 -o out
# no method can use this Courant number, but the sweep sets its own
refused "--set scheme.cfl: this is what is varied" "$kith" stress cfl-sod --set scheme.cfl=2 -o out
refused "--set resolution: this is what is varied" "$kith" chart small.yaml --set resolution=40 -o out
refused "--set resolution: this is what is varied" "$kith" chart small.yaml --set 'resolution?=7' -o out
refused "--set method.package: this is what is varied" "$kith" stress mach --set method.package=crk -o out
touch file
for verb in 'chart small.yaml' 'stress pressure-ratio'; do
  stopped 2 "kith: file/deep: Not a directory" "$kith" $verb -o file/deep/out
done
if ((EUID != 0)); then
  mkdir locked && chmod 555 locked
  stopped 2 "locked/out: Permission denied" "$kith" chart small.yaml -o locked/out
fi
# A folder with the name of a suite, as the results may have, is no suite.
mkdir sod-1d
stopped 2 "kith: --set resolution: this is what is varied" "$kith" chart sod-1d --set resolution=40 -o sod-1d

# ---- a chart in which a method fails: its points are marked, and the exit code is 1
"$kith" chart small.yaml -o out >stdout 2>stderr
code=$?
((code == 1)) || wrong "a chart with failed runs ended with $code: $(<stderr)"
(($(grep -c '^\[[0-9]*/9\]' stderr) == 9)) || wrong "progress: $(<stderr)"
(($(wc -l <out/points.csv) == 10)) || wrong "not 9 points in the table"
grep -q '^"blows up","50","failed","step ' out/points.csv ||
  wrong "no reason for the failed run: $(grep blows out/points.csv)"
for text in '9 runs, 3 failed; out/chart.md' '## norms.density.l1' 'CPU-s at error 0.02' \
  'on the front in CPU-s' 'blows up at 50: step '; do
  [[ $(<stdout) == *"$text"* ]] || wrong "stdout lacks '$text': $(<stdout)"
done
grep -q '^| A <code> & "more" |  | 50 | 0.03 | 0.05 | another machine | \(yes\|no\) |$' out/chart.md ||
  wrong "no table of other codes: $(<out/chart.md)"
# The row of a method has two orders, costs at the error, and its runs on the Pareto front; the most accurate
# run is always on it.
number='[0-9.e+-]+'
row="^\| (sph|alpha <1>) \| 0\.[0-9]+ \| 0\.[0-9]+ \| $number \| $number \| [0-9.]+ \|.* 200 \|.* 200 \|$"
grep -Eq "$row" out/chart.md ||
  wrong "no row of a method: $(<out/chart.md)"
if command -v gnuplot >/dev/null; then
  head -c 8 out/chart.png | cmp -s - <(printf '\211PNG\r\n\032\n') || wrong "no chart.png"
  (($(stat -c %s out/chart.png) > 30000)) || wrong "an empty picture"
  for text in 'pair evaluations' 'resolution (nodes per unit length)' 'A <code> & "more"' 'Pareto front'; do
    grep -qF "'$text'" out/chart.gp || wrong "chart.gp lacks '$text'"
  done
  (($(grep -c '^plot .*series3' out/chart.gp) == 4 && $(grep -c '^plot .*series2' out/chart.gp) == 6)) ||
    wrong "not 6 panels with all methods"
  (($(grep -c '^plot .*alpha <1>.*A <code>' out/chart.gp) == 1)) || wrong "not one legend with all"
fi

# ---- a second time nothing runs, and the tables are the same
cp -r out before
"$kith" chart small.yaml -o out >stdout 2>stderr
[[ ! -s stderr ]] || wrong "something ran again: $(<stderr)"
same before/points.csv out/points.csv
same before/chart.md out/chart.md
# A comment in the scene changes nothing; the result of a failed run that was removed is computed again.
sed -i '1i # another text' sod.yaml
rm -r out/runs/blows-up-50-*
"$kith" chart small.yaml -o out >stdout 2>stderr
(($(grep -c '^\[' stderr) == 1)) || wrong "instead of one failed run ran: $(<stderr)"

# ---- after a kill only the missing runs are made
rm -rf out
"$kith" chart small.yaml -o out >/dev/null 2>&1 &
chart=$!
for ((i = 0; i < 600; ++i)); do
  if [[ -e out/points.csv ]] && (($(wc -l <out/points.csv) >= 4)); then break; fi
  sleep 0.05
done
kill -KILL $chart
wait $chart 2>/dev/null
done=$(find out/runs -maxdepth 1 \( -type d -name '*[0-9a-f]' -o -name '*.failed' \) | wc -l)
((done >= 3 && done < 9)) || wrong "$done runs before the kill"
"$kith" chart small.yaml -o out >stdout 2>stderr
(($(grep -c '^\[' stderr) == 9 - done)) || wrong "after $done points ran: $(<stderr)"
# Values that do not depend on the clock are those without the kill.
physics() { sed -E 's/("[^"]*",){2}"(ok|failed)","[^"]*","[^"]*",[^,]*,/&\n/' "$1" | grep -v '^"'; }
physics before/points.csv | cmp -s - <(physics out/points.csv) || wrong "other points after the kill"

# ---- a change of base scenes, tables of materials or programs makes new runs
cp "$inputs/copper.table" .
cp "$inputs"/copper-{piston,table}.yaml . # the second is over the first
printf '%s\n' 'scene: copper-table.yaml' 'dimension: 1' 'settings: {until: 0.01}' 'resolution: [25]' >any.yaml
# again RUNS COMMAND...: the chart makes so many new runs
again() {
  "${@:2}" >stdout 2>stderr
  (($(grep -c '^\[1/1\] .*: norms' stderr) == $1)) || wrong "instead of $1 new runs, ${*:2}: $(<stderr)"
}
again 1 "$kith" chart any.yaml -o again
again 0 "$kith" chart any.yaml -o again
echo 'scheme.cfl: 0.2' >>copper-table.yaml
again 1 "$kith" chart any.yaml -o again
sed -i 's/velocity: 0.5}, open/velocity: 0.51}, open/' copper-piston.yaml
again 1 "$kith" chart any.yaml -o again
echo '# another table' >>copper.table
again 1 "$kith" chart any.yaml -o again
cp copper.table other.table
again 1 "$kith" chart any.yaml -o again --set materials.copper.file=other.table
echo '# another table' >>other.table
again 1 "$kith" chart any.yaml -o again --set materials.copper.file=other.table
mkdir -p programs/bin
cp "$programs"/kith{,-1d} programs/bin
again 0 programs/bin/kith chart any.yaml -o again
echo '{scene: sod, resolution: [50]}' >sod-suite.yaml
stopped 2 "sod-suite.yaml:1: scene: no scene 'sod': no folder inputs above the programs, in share/kith" \
  programs/bin/kith chart sod-suite.yaml
echo >>programs/bin/kith-1d
again 1 programs/bin/kith chart any.yaml -o again

# ---- a run that is killed, or fails without a message, is a failed point of this chart, and is tried again
mv programs/bin/kith-1d programs/bin/real
cat >programs/bin/kith-1d <<'END'
#!/bin/sh
[ "$1 $ends" != "run killed" ] || kill -KILL $$
[ "$1 $ends" != "run silent" ] || exit 1
exec "$(dirname "$0")/real" "$@"
END
chmod +x programs/bin/kith-1d
for ends in killed silent; do
  ends=$ends programs/bin/kith chart any.yaml -o again >stdout 2>stderr
  code=$?
  ((code == 1)) || wrong "a chart whose run was $ends ended with $code: $(cat stdout stderr)"
  grep -Eq 'failed: (killed from outside|exit code 1)$' stderr || wrong "$ends: $(<stderr)"
done
again 1 programs/bin/kith chart any.yaml -o again

# ---- another chart, or a run of one that was killed, still writes there: no point fails by that for good
run=$(find again/runs -maxdepth 1 -type d -name '*-25-*[0-9a-f]' -printf '%T@ %p\n' | sort -n | tail -1)
run=${run#* }
rm -r "$run"
mkdir -p "$run.part"
stopped 2 "kith: again: another run writes there" \
  flock again programs/bin/kith chart any.yaml -o again --quiet
stopped 1 "kith: $run.part: another run writes there" \
  flock "$run.part" programs/bin/kith chart any.yaml -o again --quiet
again 1 programs/bin/kith chart any.yaml -o again

# ---- settings may be overridden; without methods the scene's own method is used
printf '%s\n' 'scene: sod.yaml' 'dimension: 1' 'resolution: [25, 50, 100]' >any.yaml
ok "$kith" chart any.yaml -o any --quiet --set until=0.05 --set scheme.cfl=0.25
(($(wc -l <any/points.csv) == 4)) || wrong "not 3 points for a scene"
# Without targets costs are compared at an error that all methods reach: the largest of their finest runs.
(($(grep -cE '^\|.* (-|0) \|' any/chart.md) == 0)) || wrong "no costs in: $(<any/chart.md)"
ok "$kith" chart list
grep -q sod-1d stdout || wrong "no list of suites"
grep -q "inputs/suites" stdout || wrong "chart list: where are the suites?"

printf '%s\n' 'scene: tiny.yaml' 'settings: {exact.name: riemann}' 'resolution: [50]' >any.yaml
ok "$kith" chart any.yaml -o any --quiet

# ---- over: each method with every combination of values, the last key first
printf '%s\n' 'scene: tiny.yaml' 'settings: {exact.name: riemann}' \
  'over: {method.kernel: [cubic, quartic], scheme.cfl: [0.2, 0.3, 0.4]}' 'resolution: [40, 50]' \
  'methods:' '  - {name: one, settings: {method.package: crk}}' \
  '  - {name: two, settings: {scheme.cfl: 0.1}}' >over.yaml
ok "$kith" chart over.yaml -o over --quiet
cut -d, -f1,2 over/points.csv | sed 1d >names
for resolution in 40 50; do
  for method in one two; do
    for kernel in cubic quartic; do
      for cfl in 0.2 0.3 0.4; do echo "\"$method $kernel $cfl\",\"$resolution\""; done
    done
  done
done | diff names - >differs || wrong "combinations: $(<differs)"
grep -q '^"two quartic 0.3",.* method.kernel=quartic scheme.cfl=0.3 ' over/points.csv || wrong "settings"
stopped 2 'method.kernel: this is what is varied' \
  "$kith" chart over.yaml -o over --set method.kernel=quintic
sed '/methods/,$d' over.yaml >alone.yaml
ok "$kith" chart alone.yaml -o alone --quiet
grep -q '^"cubic 0.2",' alone/points.csv || wrong "names of combinations alone: $(<alone/points.csv)"
sed 's/over:.*/over: {scheme.cfl: 0.1}/' alone.yaml >over.yaml
stopped 2 'over.yaml:3' "$kith" chart over.yaml -o over
sed 's/over:.*/over: {scheme.cfl: [[1]]}/' alone.yaml >over.yaml
stopped 2 'one word or number' "$kith" chart over.yaml -o over
sed "s/over:.*/over: {scheme.cfl: [$(seq -s, 51)], dimension: [1, 2]}/" alone.yaml >over.yaml
stopped 2 'more than 100 methods' "$kith" chart over.yaml -o over

# Without gnuplot there is no picture, and chart.md has no link to it.
PATH=/nowhere "$kith" chart any.yaml -o bare --quiet >stdout 2>stderr
[[ $(<stderr) == *"gnuplot cannot be run"* && ! -e bare/chart.png ]] || wrong "without gnuplot: $(<stderr)"
(($(grep -c 'chart\.png' bare/chart.md) == 0)) || wrong "a link to no picture"

# ---- stress: one sweep
"$kith" stress pressure-ratio --quiet -o sweep --set resolution=60 >stdout 2>stderr
code=$?
((code == 0 || code == 3)) || wrong "stress ended with $code: $(<stderr)"
grep -q '^| pressure-ratio ' stdout || wrong "no table: $(<stdout)"
values=$(($(wc -l <sweep/points.csv) - 1))
((values == 56)) || wrong "$values points instead of 8 methods at 7 values"
[[ $(<sweep/stress.md) == *'## pressure-ratio'*'passes: shock at most 0.05 ('* ]] ||
  wrong "stress.md is not whole: $(<sweep/stress.md)"
cat >own.yaml <<'END_YAML'
methods: [{name: default}, {name: no step, settings: {scheme.dt: 1e-300}}]
sweeps:
  - {name: own, parameter: end, scene: sod.yaml, dimension: 1, settings: {resolution: 50}, measure: time,
     at_most: 0.03,
     reason: none, values: {until: [0.02, 0.03, 0.04]}}
END_YAML
"$kith" stress own.yaml --quiet -o own >stdout 2>stderr
code=$?
((code == 3)) || wrong "a method that fails everywhere ended with $code: $(<stderr)"
grep -Eq '^\| own +\| to 0.03 +\| none +\|$' stdout || wrong "another table: $(<stdout)"
grep -q "^- no step at 0.02: failed, step 1, time 0: the time step collapsed" own/stress.md ||
  wrong "no reason: $(<own/stress.md)"
# A misspelled setting is none that does not pass, whether of a method, of a value or of the sweep.
sed 's/scheme.dt: 1e-300/method.package: xyz/' own.yaml >wrong.yaml
refused "wrong.yaml:5: sweep own at 0.02, method no step: --set method.package: 'xyz' is not one of" \
  "$kith" stress wrong.yaml -o out
b='{value: b, settings: {scheme.clf: 1}}'
sed "s/values:.*/values: [{value: a, settings: {until: 0.02}},\n       $b]}/" own.yaml >wrong.yaml
refused "wrong.yaml:6: sweep own at b, method default: --set scheme.clf: unknown key; did you mean 'cfl'?" \
  "$kith" stress wrong.yaml -o out
sed 's/name: own/name: a|b/' own.yaml >wrong.yaml
refused "wrong.yaml:3: sweeps.0.name: 'a|b': a bar would end a column" "$kith" stress wrong.yaml -o out
# Points of several sweeps say of which they are; those of one need not.
[[ $(head -1 own/points.csv) == method,value,* ]] || wrong "columns of a sweep: $(head -1 own/points.csv)"
(cat own.yaml; tail -3 own.yaml | sed 's/name: own/name: other/') >both.yaml
"$kith" stress both.yaml --quiet -o both >stdout 2>stderr
for sweep in own other; do
  [[ $(head -1 both/points.csv) == sweep,method,value,* ]] &&
    (($(grep -c "^\"$sweep\",\"default\"," both/points.csv) == 3)) || wrong "$sweep: $(<both/points.csv)"
done
# A measure that is not in the report, when the runs exist already.
sed 's/measure: time/measure: norms.densty.l1/' own.yaml >wrong.yaml
"$kith" stress wrong.yaml --quiet -o own >stdout 2>stderr
grep -q "^- default at 0.02: failed, own/.*/report.json: norms.densty.l1 is not there" own/stress.md ||
  wrong "a misspelt measure: $(<own/stress.md)"
sed 's/measure: time/measure: time \//' own.yaml >wrong.yaml
stopped 2 "wrong.yaml:3: sweeps.0.measure: 'time /' is no measure" "$kith" stress wrong.yaml
echo 'sweeps: []' >wrong.yaml
stopped 2 "wrong.yaml:1: sweeps: an empty list" "$kith" stress wrong.yaml
ok "$kith" stress list
grep -q '^cfl-sod ' stdout || wrong "no list of sweeps"

exit $((failures > 0))
