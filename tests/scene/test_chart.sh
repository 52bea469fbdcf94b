#!/usr/bin/env bash
# test_chart.sh PROGRAMS INPUTS: charts and stresses end to end: a small matrix with a method that fails, what is written, going on after
# a kill, and everything that is refused before anything runs.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"
cp "$inputs/sod.yaml" .

cat >peers.csv <<'END_CSV'
scene,code,machine,resolution,cpu_seconds,norm,value
sod,"A <code> & ""more""",another machine,50,0.05,density.l1,0.03
END_CSV
cat >small.yaml <<'END_YAML'
scene: sod.yaml
dimension: 1
methods:
  - {name: sph, settings: {method.package: sph}}
  - {name: alpha <1>, settings: {method.viscosity: {name: monaghan}}}
  - {name: blows up, settings: {scheme.dt: 0.05}}
matrix: {resolution: [50, 100, 200]}
norms: [density.l1, velocity.l1]
targets: [0.02, 0.05]
others: peers.csv
END_YAML

# ---- refused: one line, code 2, nothing made
# bad TEXT YAML...
bad() {
  printf '%s\n' "${@:2}" >bad.yaml
  refused "$1" "$kith" chart bad.yaml -o out
}
bad "bad.yaml:1: scene: 'sodd' is not one of" 'scene: sodd' 'matrix: {resolution: [50]}'
bad "bad.yaml:2: matrix.method.package.1: --set method.package: 'spf'" 'scene: sod' 'matrix: {method.package: [sph, spf], resolution: [50]}'
bad "bad.yaml:2: methods.1: --set method.viscosity.alfa: unknown key; did you mean 'alpha'?" 'scene: sod' \
  'methods: [{name: a}, {name: b, settings: {method.viscosity.alfa: 1}}]' 'matrix: {resolution: [50]}'
bad "no method can run: --set materials.gas.gama: unknown key" 'scene: sod' 'settings: {materials.gas.gama: 2}' 'matrix: {resolution: [50]}'
bad "an empty list: a matrix of no runs" 'scene: sod' 'matrix: {method.package: [], resolution: [50]}'
printf 'scene,code\n' >short.csv
bad "no column 'machine'" 'scene: sod' 'matrix: {resolution: [50]}' 'others: short.csv'
many=$(seq -s ', ' 1 1000)
bad "more than a million runs" 'scene: sod' "matrix: {regions.0.seed: [$many], regions.1.seed: [$many], resolution: [50, 60]}"
bad "bad: 100000 runs, about " 'scene: sod' 'dimension: 1' "matrix: {regions.0.seed: [$many], scheme.cfl: [0.1, 0.2], resolution: [$(seq -s ', ' 20 69)]}"
refused "did you mean 'sod'?" "$kith" chart sodd
refused "chart: no scene or suite" "$kith" chart
refused "nothere.yaml: No such file" "$kith" chart nothere.yaml
refused "none: a scene without an exact solution" "$kith" chart plate -o out
refused "did you mean 'mach'?" "$kith" stress mack -o out
refused "stress: --set foo: unknown key" "$kith" stress mach --set foo=1 -o out
touch file
refused "Not a directory" "$kith" chart small.yaml -o file
if ((EUID != 0)); then
  mkdir locked && chmod 555 locked
  refused "Permission denied" "$kith" chart small.yaml -o locked/out
fi

# ---- a chart; a method that fails is a point, and the exit code says so
"$kith" chart small.yaml -o out >stdout 2>stderr
code=$?
((code == 1)) || wrong "a chart with failed runs ended with $code: $(<stderr)"
(($(grep -c '^\[[0-9]*/9\]' stderr) == 9)) || wrong "progress: $(<stderr)"
grep -q 'left$' stderr || wrong "no ETA: $(<stderr)"
(($(wc -l <out/points.csv) == 10 && $(wc -l <out/chart.csv) == 10)) || wrong "not 9 points in the tables"
grep -q '^"blows up",50,failed,"step ' out/chart.csv || wrong "no reason for the failed run: $(grep blows out/chart.csv)"
for text in 'sod, 1-D, L1 error of density 0.02: ' 'on the front:' '9 runs, 3 failed; out/chart.html'; do
  [[ $(<stdout) == *"$text"* ]] || wrong "stdout lacks '$text': $(<stdout)"
done
page=$(<out/chart.html)
for text in 'class="front"' 'CPU-seconds' 'pair evaluations' 'resolution (nodes per unit length)' 'alpha &lt;1&gt; at 100' 'target' \
  'blows up at 50 failed: ' 'A &lt;code&gt; &amp; &quot;more&quot;' 'fill="#ffffff" stroke="#666c75"' 'On the front in pair' \
  'Observed orders' 'another machine'; do
  [[ $page == *"$text"* ]] || wrong "the page lacks '$text'"
done
# Nothing from outside, no scripts; the one address is the name of a vocabulary.
if sed 's|http://www.w3.org/2000/svg||g' out/chart.html | grep -Eqi '<script|<link|<img|src=|href=|url\(|https?:|@import'; then
  wrong "the page asks for something from outside"
fi
[[ -s out/chart.svg ]] || wrong "no chart.svg"
if command -v gnuplot >/dev/null && ! head -c 8 out/chart.png | cmp -s - <(printf '\211PNG\r\n\032\n'); then wrong "no chart.png"; fi

# ---- once more: all is there, nothing runs, and the page is the same
cp -r out before
"$kith" chart small.yaml -o out >stdout 2>stderr
[[ ! -s stderr ]] || wrong "something ran again: $(<stderr)"
same before/points.csv out/points.csv
same before/chart.html out/chart.html

# ---- killed on its way, with a half-written line, it goes on with the rest
rm -rf out
"$kith" chart small.yaml -o out >/dev/null 2>&1 &
chart=$!
for ((i = 0; i < 600; ++i)); do
  if [[ -e out/points.csv ]] && (($(wc -l <out/points.csv) >= 4)); then break; fi
  sleep 0.05
done
kill -KILL $chart
wait $chart 2>/dev/null
done=$(($(wc -l <out/points.csv) - 1))
cp out/points.csv earlier.csv
printf '0123456789abcdef,0.1.0,"ha' >>out/points.csv
"$kith" chart small.yaml -o out >stdout 2>stderr
(($(grep -c '^\[' stderr) == 9 - done)) || wrong "after $done points ran: $(<stderr)"
head -n $((done + 1)) out/points.csv | cmp -s - earlier.csv || wrong "earlier points changed"
(($(wc -l <out/points.csv) == 10)) || wrong "$(wc -l <out/points.csv) lines instead of 10"
# What does not depend on the clock is the same as without the kill.
cut -d, -f1,2,3 before/chart.csv | cmp -s - <(cut -d, -f1,2,3 out/chart.csv) || wrong "other points after the kill"
[[ $(grep -o 'density.l1 against work.*</svg>' out/chart.html | head -1) == $(grep -o 'density.l1 against work.*</svg>' before/chart.html | head -1) ]] ||
  wrong "another chart after the kill"

# ---- any scene; its settings may be overridden
ok "$kith" chart sod.yaml -o any --quiet --set resolution=40 --set until=0.05
(($(wc -l <any/chart.csv) >= 4)) || wrong "no matrix for a scene"
ok "$kith" chart list
grep -q sod-1d stdout || wrong "no list of suites"

# ---- stress: one sweep
"$kith" stress pressure-ratio --quiet -o ladder --set resolution=60 >stdout 2>stderr
code=$?
((code == 0 || code == 3)) || wrong "stress ended with $code: $(<stderr)"
grep -q '^pressure-ratio ' stdout || wrong "no table: $(<stdout)"
rungs=$(($(wc -l <ladder/stress.csv) - 1))
((rungs % 7 == 0 && rungs >= 7)) || wrong "$rungs rungs in stress.csv"
[[ $(<ladder/stress.html) == *'gate: below'*'What does not pass'* ]] || wrong "the page of the stress is not whole"
# A run that cannot be is a reason, not an end: no method takes this Courant number.
"$kith" stress cfl-sod --quiet -o ladder --set scheme.cfl=2 >stdout 2>stderr
code=$?
((code == 2)) || wrong "a Courant number of 2 ended with $code: $(<stderr)"
ok "$kith" stress list
grep -q '^cfl-sod ' stdout || wrong "no list of sweeps"

exit $((failures > 0))
