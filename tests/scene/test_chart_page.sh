#!/usr/bin/env bash
# test_chart_page.sh PROGRAMS INPUTS: the page of a chart in a real browser. 77 (skipped) where there is no chromium.
inputs=$(readlink -f "$2")
browser=$(command -v chromium || command -v chromium-browser || command -v google-chrome) || exit 77
source "$(dirname "$0")/common.sh"
export HOME=$place

cat >small.yaml <<END_YAML
scene: $inputs/sod.yaml
dimension: 1
methods:
  - {name: sph, settings: {method.package: sph}}
  - {name: blows up, settings: {scheme.dt: 0.05}}
matrix: {resolution: [50, 100]}
norms: [density.l1, velocity.l1]
others: peers.csv
END_YAML
printf 'scene,code,machine,resolution,cpu_seconds,norm,value\nsod,A <code>,m,50,0.05,density.l1,0.03\n' >peers.csv
"$kith" chart small.yaml -q -o out >/dev/null 2>stderr || (($? == 1)) || wrong "no chart: $(<stderr)"

look() { timeout 100 "$browser" --headless --no-sandbox --disable-gpu --disable-dev-shm-usage --hide-scrollbars "$@" 2>/dev/null; }

# What a person would look for, asked of the browser: marks and words inside their pictures, crosses, hollow marks, titles that pop up,
# nothing wider than the window, nothing loaded. Only this copy of the page has a script.
cat >ask.html <<'END_SCRIPT'
<script>
const all = selector => [...document.querySelectorAll(selector)];
let out = 0, words = 0;
for (const svg of all('svg')) {
  const frame = svg.getBoundingClientRect();
  for (const element of svg.querySelectorAll('circle, rect + *, path, text')) {
    const box = element.getBoundingClientRect();
    if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) ++out;
  }
  words += svg.querySelectorAll('text').length;
}
const answer = {pictures: all('svg').length, outside: out, titles: all('svg title').length, fronts: all('path.front').length,
  enough_words: words > 60, hollow: all('circle[fill="#ffffff"]').length, wide: document.documentElement.scrollWidth > innerWidth,
  failed: all('tr.failed').length, ink: getComputedStyle(document.body).color, ground: getComputedStyle(document.body).backgroundColor,
  loaded: performance.getEntriesByType('resource').length};
document.body.setAttribute('data-answer', Object.entries(answer).map(([k, v]) => k + '=' + v).join(';'));
</script>
END_SCRIPT
cat out/chart.html ask.html >asked.html
answer=$(look --window-size=1360,2000 --dump-dom "file://$PWD/asked.html" | grep -o 'data-answer="[^"]*"')
# 2 methods x 2 resolutions x 3 panels x 2 norms, less the crosses of panels that know no cost of a failed run (2 x 2 x 2), and the peer.
for part in 'pictures=2;' 'outside=0;' 'titles=17;' 'fronts=4;' 'enough_words=true;' 'wide=false;' 'failed=2;' 'ink=rgb(31, 35, 40);' \
  'ground=rgb(255, 255, 255);' 'loaded=0"'; do
  [[ $answer == *"$part"* ]] || wrong "the browser does not say '$part': $answer"
done
[[ $answer == *'hollow='[1-9]* ]] || wrong "no hollow marks: $answer"

# It is drawn: a picture of an empty page would be some 10 kB.
look --window-size=1360,2000 --screenshot=page.png "file://$PWD/out/chart.html" >/dev/null
(($(stat -c %s page.png 2>/dev/null || echo 0) > 60000)) || wrong "an empty picture of the page"

# The SVG on its own is strict XML.
drawn=$(look --dump-dom "file://$PWD/out/chart.svg")
[[ $drawn == *'density.l1 against cost'* && $drawn != *parsererror* ]] || wrong "chart.svg is no good XML"

"$kith" stress pressure-ratio --quiet -o ladder --set resolution=60 >/dev/null 2>&1
cat ladder/stress.html ask.html >asked.html
answer=$(look --window-size=1360,2000 --dump-dom "file://$PWD/asked.html" | grep -o 'data-answer="[^"]*"')
[[ $answer == *'pictures=1;outside=0;'*'wide=false;'*'loaded=0"' ]] || wrong "the page of the stress: $answer"

exit $((failures > 0))
