#!/usr/bin/env bash
# test_validate.sh PROGRAMS: `kith validate` on files of one's own: what passes, what does not, and what is wrong in a file.
inputs=$(readlink -f "$2")
source "$(dirname "$0")/common.sh"
ln -s "$inputs" inputs

row='name: short, dimension: 1, scene: sod, settings: "resolution=50 until=0.05", measure: norms.density.l1'
rows() { printf 'rows:\n' >own.yaml && printf '  - {%s}\n' "$@" >>own.yaml; }

rows "$row, at_most: 0.1, source: a guess" 'name: drift, measure: energy_drift, at_most: 1e-12' 'name: end, measure: time, at_least: 0.05'
ok "$kith" validate own.yaml -o v
grep -q "^3 rows, 0 out of tolerance; 1-D .* s, 2-D 0 s, 3-D 0 s" stdout || wrong "the sums: $(tail -1 stdout)"
[[ $(head -1 v/validation.csv) == row,measured,relation,bound,verdict,seconds,source,density.l1,* ]] || wrong "the table's head"
awk -F, '/^short/ {exit !($2 > 0 && $2 == $8 && $5 == "ok" && $7 == "\"a guess\"")}' v/validation.csv || wrong "the table: $(cat v/validation.csv)"

rows "$row, at_most: 1e-9" "name: twice, dimension: 1, scene: sod, settings: 'resolution=100 until=0.05', measure: norms.density.l1, at_most: 1" \
  'name: slope, measure: order 2, at_least: 0.5' 'name: steep, measure: order 2, at_least: 9'
"$kith" validate own.yaml -o v >stdout 2>stderr && wrong "a bound that is not held is no success"
grep -q "^4 rows, 2 out of tolerance" stdout || wrong "two of four: $(cat stdout)"
grep -q "^slope .* ok" stdout || wrong "an order: $(grep slope stdout)"

rows "${row/norms.density.l1/norms.nothing}, at_most: 1"
"$kith" validate own.yaml -o v >stdout 2>stderr
(($? == 1)) || wrong "a measure that is not in the report"
grep -q "no norms.nothing" stdout || wrong "why: $(cat stdout)"
rows "$row"
stopped 2 "own.yaml:2: rows.0: row short needs one bound, at_most or at_least" "$kith" validate own.yaml
rows "$row, at_most: 1, at_least: 0"
stopped 2 "needs one bound" "$kith" validate own.yaml
rows 'name: drift, measure: energy_drift, at_most: 1e-12'
stopped 2 "there is no run before it" "$kith" validate own.yaml
rows "${row/dimension: 1, /}, at_most: 1"
stopped 2 "scene and dimension come together" "$kith" validate own.yaml
rows "$row, at_moist: 1"
stopped 2 "did you mean 'at_most'" "$kith" validate own.yaml
echo "scene: sod" >own.yaml
stopped 2 "no rows" "$kith" validate own.yaml
stopped 2 "no suite 'quack'; quick, full, gates, ranks, list, or a file of rows" "$kith" validate quack
stopped 2 "missing.yaml: No such file" "$kith" validate missing.yaml

exit $((failures > 0))
