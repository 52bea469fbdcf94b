#!/usr/bin/env bash
# test_validate.sh PROGRAMS INPUTS: `kith validate` on files of one's own: rows that pass, rows that fail, and
# errors in files.
inputs=$(readlink -f "$2")
# suppresses leaks of MPI, as tests/mpi does
leaks=$(readlink -f "$(dirname "$0")/../mpi/leaks.supp")
export LSAN_OPTIONS=suppressions=$leaks:print_suppressions=0 ASAN_OPTIONS=fast_unwind_on_malloc=0
source "$(dirname "$0")/common.sh"
ln -s "$inputs" inputs

row='name: short, scene: sod, settings: "resolution=50 until=0.05", measure: norms.density.l1'
rows() { printf 'rows:\n' >own.yaml && printf '  - {%s}\n' "$@" >>own.yaml; }

rows "$row, at_most: 0.1, source: a guess" 'name: drift, measure: energy_drift, at_most: 1e-12' \
  'name: end, measure: time, at_least: 0.05'
ok "$kith" validate own.yaml -o v
grep -q "^3 rows, 0 out of tolerance; [0-9]* s; v/validation.csv$" stdout ||
  wrong "the sums: $(tail -1 stdout)"
[[ $(head -1 v/validation.csv) == row,measured,relation,bound,verdict,seconds,source,density.l1,* ]] ||
  wrong "the table's head"
awk -F, '/^"short/ {exit !($2 > 0 && $2 == $8 && $5 == "ok" && $7 == "\"a guess\"")}' v/validation.csv ||
  wrong "the table: $(cat v/validation.csv)"
stopped 2 "kith: v: another run writes there" flock v "$kith" validate own.yaml -o v

touch file
stopped 2 "kith: file/deep: Not a directory" "$kith" validate own.yaml -o file/deep/out
mkdir dotted.suite
stopped 2 "no suite 'dotted.suite'; there are quick" "$kith" validate dotted.suite

# Names and sources with commas and quotes are single columns.
rows "${row/short/\'a, \"b\"\'}, at_most: 1, source: 'so \"they\", say'"
ok "$kith" validate own.yaml -o quoted
grep -q '^"a, ""b""",0\..*,"so ""they"", say",' quoted/validation.csv ||
  wrong "quotes: $(cat quoted/validation.csv)"

# A number as a document prints it passes if the measured value is rounded to it, and fails if its last digit
# is one less.
measured=$(awk -F, '/^"short/ {printf "%.3f", $2}' v/validation.csv)
less=$(awk -F, '/^"short/ {printf "%.3f", $2 - 0.001}' v/validation.csv)
rows "$row, prints: $measured" "${row/short/short2}, prints: 0.5" \
  "${row/short/short3}, prints: 0.5, within: 0.999" "${row/short/short4}, prints: $measured, quick: true" \
  "${row/short/short5}, prints: $less"
"$kith" validate own.yaml -o v >stdout 2>stderr
[[ $? == 3 && $(grep -c "^short.* = .* ok" stdout) == 3 ]] ||
  wrong "figures of a document: $(cat stdout stderr)"

# After a run that fails, rows that need it do not use results of another run or of an earlier validation.
end='output.checkpoint_at_end=true'
after() {
  local short=${row/until=0.05/until=0.05 $end}
  rows "${short/short/coarse}, at_most: 1" "${short/resolution=50/resolution=100$1}, at_most: 1" \
    'name: drift, measure: energy_drift, at_most: 1e-12' 'name: norms, measure: same norms, at_most: 9' \
    'name: slope, measure: order 2, at_least: -9' \
    "name: like, dimension: 1, scene: sod, settings: 'resolution=100 until=0.05', same: 0.5, like: short" \
    "name: on, dimension: 1, scene: sod, settings: 'resolution=100 until=0.05', restart: short,
      measure: time, at_least: 0.05"
  "$kith" validate own.yaml -o after >stdout 2>stderr
}
after '' || wrong "rows that need another one: $(cat stdout stderr)"
after ' scheme.dt=0.05'
(($? == 1)) || wrong "rows after a run that failed: $(cat stdout stderr)"
(($(grep -c ' ok ' stdout) == 1)) || wrong "rows that need a run that failed are ok: $(cat stdout)"
(($(grep -c '^    no results of row short' stdout) == 4)) || wrong "reasons: $(cat stdout)"
grep -q '^    one of the last 2 values is missing' stdout || wrong "an order: $(cat stdout)"

# A scene of one's own, by its path.
cp inputs/sod.yaml my-tube.yaml
rows "${row/sod/my-tube.yaml}, at_most: 0.1" 'name: drift, measure: energy_drift, at_most: 1e-12'
ok "$kith" validate own.yaml -o v
rows "${row/sod/my-tub.yaml}, at_most: 0.1"
stopped 2 "own.yaml:2: rows.0.scene: 'my-tub.yaml' cannot be read" "$kith" validate own.yaml
rows "${row/sod/sodd}, at_most: 0.1"
stopped 2 "rows.0.scene: no scene 'sodd'; did you mean 'sod'" "$kith" validate own.yaml
rows "${row/scene: sod/scene: zzz}, at_most: 0.1"
last=$(basename "$(printf '%s\n' "$inputs"/*.yaml | tail -1)" .yaml)
stopped 2 ", $last" "$kith" validate own.yaml

rows "$row, at_most: 1e-9" \
  "name: twice, dimension: 1, scene: sod, settings: 'resolution=100 until=0.05', measure: norms.density.l1,
    at_most: 1" \
  'name: slope, measure: order 2, at_least: 0.5' 'name: steep, measure: order 2, at_least: 9'
"$kith" validate own.yaml -o v >stdout 2>stderr && wrong "a bound that is not held is no success"
grep -q "^4 rows, 2 out of tolerance" stdout || wrong "two of four: $(cat stdout)"
grep -q "^slope .* ok" stdout || wrong "an order: $(grep slope stdout)"

# Measures that are not in the report, that have no value beside walls, and texts.
rows "${row/norms.density.l1/norms.nothing}, at_most: 1" \
  'name: walls, measure: angular_momentum_drift, at_most: 1' 'name: text, measure: scene, at_most: 1'
"$kith" validate own.yaml -o v >stdout 2>stderr
(($? == 1)) || wrong "a measure that is not in the report"
for why in 'norms.nothing is not there' 'angular_momentum_drift is null' 'scene is not a number'; do
  grep -q "report.json: $why" stdout || wrong "why: $(cat stdout)"
done
for bad in 'energy_drift /' 'energy_drift / steps / time' 'time - 1' 'time / steps - 2'; do
  rows "${row/norms.density.l1/$bad}, at_most: 1"
  stopped 2 "own.yaml:2: rows.0.measure: '$bad' is no measure: A, A / B or A / B - 1" \
    "$kith" validate own.yaml
done
for bad in order 'order 1' 'order 2x'; do
  rows "${row/norms.density.l1/$bad}, at_most: 1"
  stopped 2 "rows.0.measure: '$bad' is not order N, with N at least 2" "$kith" validate own.yaml
done
rows "$row, at_most: 1" 'name: slope, measure: order 2, at_least: 0.5'
stopped 2 "rows.1.measure: 'order 2' of 1 rows above that measure at a resolution" "$kith" validate own.yaml
rows "${row/resolution=50/resolution = 50}, at_most: 1"
stopped 2 "own.yaml:2: rows.0.settings: 'resolution' is not key=value" "$kith" validate own.yaml
# All scenes are checked before the first run.
rows "$row, at_most: 1" \
  "name: wrong, dimension: 1, scene: sod, settings: method.package=foo, measure: steps, at_least: 1, steps: 2"
stopped 2 "own.yaml:3: row wrong: --set method.package: 'foo' is not one of" "$kith" validate own.yaml -o none
[[ ! -e none ]] || wrong "rows before a wrong one ran: $(ls none)"
echo "rows: []" >own.yaml
stopped 2 "own.yaml:1: rows: an empty list" "$kith" validate own.yaml
stopped 2 "/ranks.yaml is quick: leave out -quick" "$kith" validate ranks-quick -o none
rows "$row, at_most: 1"
echo 'row: []' >>own.yaml
stopped 2 "own.yaml:3: row: unknown key; did you mean 'rows'?" "$kith" validate own.yaml
rows "$row"
stopped 2 "own.yaml:2: rows.0: row short needs one bound: at_most, at_least, or prints" \
  "$kith" validate own.yaml
rows "$row, at_most: 1, at_least: 0"
stopped 2 "needs one bound" "$kith" validate own.yaml
rows 'name: drift, measure: energy_drift, at_most: 1e-12'
stopped 2 "there is no run before it" "$kith" validate own.yaml
rows 'name: drift, dimension: 1, measure: energy_drift, at_most: 1e-12'
stopped 2 "own.yaml:2: rows.0.dimension: means nothing without scene" "$kith" validate own.yaml
rows "$row, at_moist: 1"
stopped 2 "did you mean 'at_most'" "$kith" validate own.yaml
echo "scene: sod" >own.yaml
stopped 2 "no rows" "$kith" validate own.yaml
stopped 2 "no suite 'xyzzy'; there are quick, full, gates, ranks, readme, readme-quick, decks" \
  "$kith" validate xyzzy
stopped 2 "no suite 'quik'; did you mean 'quick'?" "$kith" validate quik
stopped 2 "missing.yaml: No such file" "$kith" validate missing.yaml
mkdir -p elsewhere/very/far/bin
cp "$kith" elsewhere/very/far/bin
stopped 2 "no suite 'quick': no folder inputs/validation above the programs, in share/kith" \
  env -C elsewhere very/far/bin/kith validate

# Ratios; runs on several ranks, compared with another run.
tube='dimension: 1, scene: sod, settings: "resolution=50 until=0.05"'
rows "name: short, $tube, measure: steps / lifecycles_are_in_the_ledger, at_most: 1"
"$kith" validate own.yaml -o v >stdout 2>stderr && wrong "a ratio with what is not there"
rows "name: short, $tube, measure: ledger.lifecycles / steps, at_least: 1" \
  "name: two, $tube, ranks: 2, threads: 1, same: 1e-11, like: short" \
  'name: sharper, dimension: 1, scene: sod, settings: "resolution=50 until=0.05 scheme.cfl=0.2", same: 1e-11,
    like: short' \
  'name: sooner, dimension: 1, scene: sod, settings: "resolution=50 until=0.04", same: bits, like: short'
"$kith" validate own.yaml -o v >stdout 2>stderr
(($? == 3)) || wrong "two rows differ: $(cat stdout stderr)"
grep -q "^two .* ok .* same as short" stdout || wrong "two ranks and one: $(grep two stdout)"
grep -q "^sharper .* FAILED .* DIFFERS FROM short by .* in [A-Z]" stdout ||
  wrong "another step: $(grep sharper stdout)"
grep -q "^sooner .* FAILED .* DIFFERS FROM short by inf" stdout || wrong "another time: $(grep sooner stdout)"
grep -q "^1 of 3 runs end in the same state" stdout || wrong "how many are the same: $(tail -1 stdout)"

group() {
  rows "over: {$1}, same: bits, settings: reproducible=true, rows: [{name: a, $tube}, {name: b, $tube}]"
}
# each of 2 rows with each of 3 numbers of ranks
group 'ranks: [1, 2, 3], threads: [1, 2], partition.name: [kd, hilbert]'
ok "$kith" validate own.yaml -o v
grep -q "^6 of 6 runs end in the same state" stdout || wrong "a group: $(tail -1 stdout)"
grep -Eq "^a\.[123]\.[12]\.(kd|hilbert) .* same as a$" stdout || wrong "names of a group: $(cat stdout)"
awk -F, '/^"b\.[123]\./ {n += ($14 > 0 && $15 > 0 && $16 != "\"\"" && $17 == "\"b\"" && $18 == 0)}
  END {exit !(n >= 3)}' v/validation.csv || wrong "the table: $(cat v/validation.csv)"
# A row may require identical bits where its group has a tolerance.
for same in 0.2 bits; do
  rows "over: {scheme.cfl: [0.29]}, same: 0.2, rows: [{name: a, $tube, same: $same}]"
  "$kith" validate own.yaml -o v >stdout 2>stderr
  code=$?
  [[ $code$same == 00.2 || $code$same == 3bits ]] ||
    wrong "another step within 0.2, by $same: $(cat stdout stderr)"
done
rows "name: ../a, $tube, measure: energy_drift, at_most: 1"
stopped 2 "'../a' is no name of a directory" "$kith" validate own.yaml
rows "name: a, $tube, measure: energy_drift, at_most: 1" "name: a, measure: momentum_drift, at_most: 1"
stopped 2 "rows.1.name: there is a row 'a' above" "$kith" validate own.yaml
rows "name: a, $tube, measure: energy_drift, prints: much"
stopped 2 "rows.0.prints: 'much' is no number" "$kith" validate own.yaml
group ''
stopped 2 "a group needs rows and factors" "$kith" validate own.yaml
group 'ranks: []'
stopped 2 "a factor without values" "$kith" validate own.yaml
group 'ranks: [0]'
stopped 2 "rows.0.over.ranks.0: ranks=0: not one of 1 to 4096" "$kith" validate own.yaml
rows "same: bits, rows: [{name: a, $tube}]"
stopped 2 "rows.0.over: missing" "$kith" validate own.yaml
rows "over: {ranks: [2]}, rows: [{name: a, $tube}]"
stopped 2 "row a needs a measure or same" "$kith" validate own.yaml
rows "name: a, $tube, same: bits, like: short"
stopped 2 "there is no row 'short' above" "$kith" validate own.yaml
rows "name: a, $tube, same: bits"
stopped 2 "row a: same and like come together" "$kith" validate own.yaml
rows "over: {ranks: [2]}, same: bits, rows: [{name: a, measure: energy_drift, at_most: 1}]"
stopped 2 "rows.0.rows.0.scene: missing" "$kith" validate own.yaml
tube='dimension: 1, scene: sod, settings: "resolution=50 until=0.05 output.checkpoint_at_end=true"'
rows "name: whole, $tube, measure: steps, at_least: 9" \
  "name: part, $tube, steps: 5, measure: steps, at_most: 5" \
  "name: on, $tube, restart: part, same: bits, like: whole" "name: part2, $tube, same: bits, like: part"
"$kith" validate own.yaml -o v >stdout 2>stderr
(($? == 3)) || wrong "a restart, and a row of fewer steps: $(cat stdout stderr)"
grep -q "^on .* ok .* same as whole" stdout || wrong "a restart: $(cat stdout)"
grep -q "^part2 .* DIFFERS FROM part" stdout || wrong "fewer steps: $(cat stdout)"
rows "name: a, $tube, restart: b, measure: steps, at_least: 9"
stopped 2 "rows.0.restart: there is no row 'b' above" "$kith" validate own.yaml
rows "name: a, $tube, same: about, like: a"
stopped 2 "'about' is neither bits nor a number" "$kith" validate own.yaml
rows "name: a, over: {ranks: [2]}, $tube, same: bits"
stopped 2 "row a is no group" "$kith" validate own.yaml

exit $((failures > 0))
