#!/usr/bin/env bash
# test_bench.sh PROGRAMS: the numbers that `kith bench` prints are consistent with each other, in every
# dimension and package, within their last digit. Their size depends on the machine, and is not tested.
source "$(dirname "$0")/common.sh"

resolution=(0 200 20 9)
for dim in 1 2 3; do
  [[ -x $programs/kith-${dim}d ]] || continue
  ok "$programs/kith-${dim}d" bench --set resolution=${resolution[dim]} --steps 2 --threads 1
  grep -q "Sedov, resolution ${resolution[dim]}, " stdout || wrong "bench: which size? $(head -1 stdout)"
  grep -q "triad on 1 thread [0-9.]* GB/s$" stdout || wrong "bench: one triad for one thread"
  awk '
    function half(digits) { return 0.51 * 10 ^ -digits } # what rounding may take
    function near(what, a, b, room) {
      if ((a > b ? a - b : b - a) > room) print package " " what ": " a ", " b
    }
    /triad on 1 thread/ { triad = $6 }
    /self ns/ { package = $1; ++packages; n = sum = moved = plain = 0; next }
    n >= 0 && NF >= 7 && $(NF - 5) ~ /^[0-9.]+$/ && package != "" {
      ns = $(NF - 5); bytes = $(NF - 3)
      if ($1 == "reference:") plain += ns
      else if ($1 == "step") { step = ns; traffic = bytes; over = $NF }
      else { sum += ns; ++n; if (bytes != "-") moved += bytes }
      if ($1 ~ /connectivity\/rows/) rows = ns
      if ($1 ~ /\/force/) force = ns
      if (bytes == "-") next
      near("bytes over ns of " $1, $(NF - 2) * ns, bytes, half(0) + ns * half(2) + $(NF - 2) * half(1))
      near("triad of " $1, $(NF - 1) * triad, $(NF - 2), (1 + $(NF - 1)) * half(2) + triad * half(3))
      time[++counted] = ns; entry[counted] = $(NF - 4)
    }
    / candidates, / {
      candidates = $5 + 0; each = $7; entries = $12; hit = $17 + 0; pairs = $18
      near("entries over candidates", hit * candidates, entries, candidates * half(4) + 2 * half(2))
      near("candidates", each * candidates, rows, half(1) + candidates * half(3) + each * half(2))
      near("sum of stages", sum, step, (n + 1) * half(1))
      near("sum of bytes", moved, traffic, (n + 1) * half(0))
      near("over plain", over * plain, step, half(1) + plain * half(2) + over * 2 * half(1))
      if (!(counted >= 5 && force > 0 && hit > 0 && hit <= 1)) print package ": a figure is missing"
      if (!(pairs > entries)) print package ": " pairs " pair evaluations" # densities alone take each entry
      for (; counted > 0; --counted)
        near("entries", entry[counted] * entries, time[counted],
          half(1) + (entries + entry[counted]) * half(2))
      package = ""
    }
    END { if (packages < 3) print packages + 0 " packages" }' stdout >differs
  [[ ! -s differs ]] || wrong "kith-${dim}d bench: $(<differs)"
done

# A package or a traversal that is set in any way is the one that is named; of block steps only the updates of
# active nodes count.
cases() { sed -n 's/^  \([a-z0-9]*\(, traversal=[a-z]*\)\?\)  *1 .*/\1/p' stdout | sort -u | paste -sd ';'; }
small=("$kith" bench --set resolution=9 --steps 1 --threads 1)
if [[ -x $programs/kith-3d ]]; then
  for set in 'method.package?=crk' 'method={package: crk}'; do
    ok "${small[@]}" --set "$set"
    [[ $(cases) == "crk;crk, traversal=gather" ]] || wrong "bench --set $set: $(cases)"
  done
  ok "${small[@]}" --set traversal=gather --set method.package=mfm
  [[ $(cases) == mfm ]] || wrong "bench with one traversal: $(cases)"
  ok "${small[@]}" --set scheme.steps=block --set method.package=sph --set resolution=16
  awk '/ row entries, / {entries = $12} END {exit !(entries > 50 && entries < 100)}' stdout ||
    wrong "row entries of an update with block steps: $(grep 'row entries' stdout)"
  # Supports of a disordered start take several rebuilds, which are not of the steps.
  ok "${small[@]}" --set regions.0.jitter=0.3 --set method.package=sph
  awk '$1 == "sph" && $2 == 1 {n = $6} END {exit n != 1}' stdout || wrong "rebuilds of a step: $(<stdout)"
fi

# Errors are reported before anything is measured, with code 2.
for dim in 1 2 3; do
  bench=("$programs/kith-${dim}d" bench)
  [[ -x ${bench[0]} ]] || continue
  stopped 2 "--set method.package: 'spf'" "${bench[@]}" --set method.package=spf
  [[ ! -s stdout ]] || wrong "measured before: $(<stdout)"
  stopped 2 "--set foo: unknown key" "${bench[@]}" --set foo=1
  stopped 2 "--steps 0: there is nothing to time" "${bench[@]}" --steps 0
  stopped 2 "--set until 0: there is nothing to time" "${bench[@]}" --set until=0
done

exit $((failures > 0))
