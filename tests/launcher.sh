#!/usr/bin/env bash
# launcher.sh PROGRAM: the launcher ./kith on a small source tree, whose program prints its arguments; then
# which programs `kith` starts, and what it refuses. Nothing is installed.
set -uo pipefail
export KITH_NO_INSTALL=1
unset OMP_NUM_THREADS OMP_PROC_BIND
program=$(readlink -f "$1")
source=$(dirname "$(dirname "$(readlink -f "$0")")")
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
failures=0

# check CODE TEXT COMMAND...: the command ends with CODE, and its output contains TEXT.
check() {
  local code=$1 text=$2 output
  shift 2
  output=$("$@" 2>&1)
  local got=$?
  if ((got != code)) || [[ $output != *"$text"* ]]; then
    printf '%s\n  gave %d, wanted %d with "%s"; output:\n%s\n' "$*" "$got" "$code" "$text" "$output"
    failures=$((failures + 1))
  fi
}

# ---- the launcher; the name of its tree has a blank, so it builds in the cache; it is called from another
# directory
export XDG_CACHE_HOME=$place/cache
tree="$place/a tree"
mkdir -p "$tree" "$place/elsewhere"
cp "$source/kith" "$source/CMakePresets.json" "$tree"
cat >"$tree/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(kith VERSION 9.8.7 LANGUAGES NONE)
add_custom_command(OUTPUT copied DEPENDS program COMMAND mkdir -p bin
  COMMAND cp ${PROJECT_SOURCE_DIR}/program bin/kith COMMAND touch copied
  COMMENT "Building kith")
add_custom_target(kith DEPENDS copied)
foreach(dim 1 2 3)
  add_custom_target(kith-${dim}d COMMAND env >${PROJECT_SOURCE_DIR}/built-${dim})
endforeach()
END
cat >"$tree/program" <<'END'
#!/usr/bin/env bash
[[ $* == *code3* ]] && exit 3
echo "bind $OMP_PROC_BIND in $(basename "$PWD"):$(printf ' [%s]' "$@")"
END
chmod +x "$tree/program"
ln -s "$tree/kith" "$place/link"
cd "$place/elsewhere" || exit 1
kith=$place/link

# Arguments are passed unchanged.
check 0 "bind  in elsewhere:" "$kith"
check 0 "in elsewhere: [--help]" "$kith" --help
check 0 "in elsewhere: [run] [a b.yaml] [--threads] [3] [--set] [x=1] [--ranks=1] [] [--quiet]" \
  "$kith" run "a b.yaml" --threads 3 --set x=1 --ranks=1 '' --quiet
rm -f "$tree"/built-1
check 2 "build: all: only -j N may follow" "$kith" build all
check 2 "build: --ranks: only -j N may follow" "$kith" build -j 2 --ranks 2
for jobs in -j "-j 0" -jx --jobs=; do check 2 "-j N: N is not a number" "$kith" build $jobs; done
check 2 "built" ls "$tree"/built-1
check 0 "in elsewhere: [test] [--help]" "$kith" test --help
check 0 "in elsewhere: [test] [-h]" "$kith" test -h
check 0 "bind close in" env OMP_PROC_BIND=close "$kith" bench
for jobs in "-j 3" -j3 "--jobs 3" --jobs=3; do
  rm -f "$tree"/built-1
  check 0 "programs: $place/cache/kith" "$kith" build $jobs
  check 0 "CMAKE_BUILD_PARALLEL_LEVEL=3" cat "$tree"/built-1
done
check 2 "no such test" "$kith" test quick
check 0 "release" ls "$place/cache/kith"/*
check 2 "build" ls "$tree/build"

# A run or plan of one scene builds the program of its dimension, other verbs build those of all dimensions.
rm -f "$tree"/built-*
printf 'dimension: 2 # as it is\n' >flat.yaml
check 0 "run" "$kith" run flat.yaml --set method.dimension=1
check 0 "2" ls "$tree"/built-*
check 2 "built-1" ls "$tree/built-1"
check 0 "plan" "$kith" plan --set dimension=3 flat.yaml
check 2 "built-1" ls "$tree/built-1"
check 0 "built-3" ls "$tree/built-3"
rm -f "$tree"/built-*
check 0 "run" "$kith" run flat.yaml --set "dimension?=3"
check 0 "built-3" ls "$tree/built-3"
check 0 "run" "$kith" run flat.yaml --set dimension=+1
check 0 "built-1" ls "$tree/built-1"
rm -f "$tree"/built-*
check 0 "run" "$kith" run none.yaml
check 0 "built-1" ls "$tree/built-1"
check 3 "" "$kith" validate code3

# After changes, also in a tree that was moved, the program is built again; output of a failed build is shown.
sed -i 's/echo "bind/echo "now bind/' "$tree/program"
check 0 "building release, which may take some minutes; log: $place/cache/kith" "$kith" build
exec 8>"$(echo "$place"/cache/kith/*/lock)" && flock 8
timeout 1 "$kith" list >waits 2>&1
check 0 "waiting for another build in $place/cache/kith" cat waits
exec 8>&-
check 0 "now bind" "$kith" list
mv "$tree" "$place/moved"
check 0 "now bind" "$place/moved/kith" list
cp -r "$place/moved" "$place/copy"
check 0 "moved or copied: building release again" "$place/copy/kith" list
# In a source tree that cannot be written, programs are built in the cache. Root can write anywhere.
if ((EUID != 0)); then
  rm -rf "$place/copy/build" && chmod -R a-w "$place/copy"
  check 0 "in elsewhere: [list]" "$place/copy/kith" list
  [[ ! -e $place/copy/build ]] || { echo "no build in the cache" && failures=$((failures + 1)); }
  chmod -R u+w "$place/copy"
  mkdir "$place/copy/build" && chmod a-w "$place/copy/build" # as if another user had built it
  check 0 "in elsewhere: [list]" "$place/copy/kith" list
  chmod a-w "$place/cache/kith"/*/release
  check 2 "cannot be written" "$place/copy/kith" list
  chmod -R u+w "$place/copy" "$place/cache"
fi
rm "$place/moved/program"
check 1 "building release failed" "$place/moved/kith" list
check 1 "needed by 'copied'" "$place/moved/kith" build

# ---- the program kith: which program it starts, and what it refuses
cp "$program" kith
for dim in 1 2 3; do
  printf '#!/bin/sh\necho "%dd $* bind $OMP_PROC_BIND"\n' "$dim" >"kith-${dim}d"
  chmod +x "kith-${dim}d"
  printf 'scene: x\ninner: {dimension: 9}\n# dimension: 8\n"dimension": %d # as it is\n' "$dim" >"$dim.yaml"
done
kith=$PWD/kith
for dim in 1 2 3; do
  check 0 "${dim}d run $dim.yaml bind true" "$kith" run $dim.yaml
  check 0 "${dim}d run $dim.yaml --ranks 2 bind " "$kith" run $dim.yaml --ranks 2
  check 0 "${dim}d plan --set a=2.yaml $dim.yaml --thr=1" \
    "$kith" plan --set a=2.yaml $dim.yaml --thr=1
  check 0 "${dim}d run -- $dim.yaml" "$kith" run -- $dim.yaml
  check 0 "${dim}d run" \
    "$kith" run --set dimension=2 3.yaml --set method.dimension=1 --set=dimension=$dim --quiet
done
check 0 "bind close" env OMP_PROC_BIND=close "$kith" run 1.yaml
check 0 "3d list a" "$kith" list a
check 0 "3d bench" "$kith" bench
check 2 "none.yaml: No such file" "$kith" run none.yaml
check 2 "SCENE is missing" "$kith" run
check 2 "4 is out of range [1, 3]" "$kith" run 3.yaml --set dimension=4
printf 'dimension: [3]\n' >wrong.yaml
check 2 "wrong.yaml:1: dimension: " "$kith" run wrong.yaml
printf 'dimension: 3\n  broken: [\n' >wrong.yaml
check 2 "wrong.yaml:2" "$kith" run wrong.yaml
: >wrong.yaml
check 2 "wrong.yaml" "$kith" run wrong.yaml
check 2 "./kith of the source tree" "$kith" build
check 2 "no suite 'no-such'" "$kith" chart no-such
check 2 "no verb" "$kith"

# Each option is refused by verbs that do not take it, and each verb has its help.
for refusal in "list --ranks 2" "chart 1.yaml --until 1" "validate --set a=1" "plan 1.yaml -o x" \
  "bench --restart x" "stress --until 1" "plan 1.yaml --steps 1"; do
  check 2 ": not an option of ${refusal%% *}, but of " "$kith" $refusal
done
check 0 "kith 0." "$kith" --version
check 0 "  stress [SWEEP|FILE]" "$kith" --help
check 0 "usage: kith test [quick]" "$kith" test --help
check 0 "  stress [SWEEP|FILE]" "$kith" help
check 0 "usage: kith test [quick]" "$kith" help test
check 2 "; did you mean 'list'? (see kith --help)" "$kith" lsit
check 0 "--restart FILE" "$kith" run --help
if "$kith" plan --help | grep -q -e --restart; then
  echo "the help of plan shows --restart" && failures=$((failures + 1))
fi
rm kith-3d kith-1d # as with -DKITH_DIMENSIONS=2
check 0 "2d list a" "$kith" list a
check 1 "kith-3d is not built: ./kith build builds all, cmake those of -DKITH_DIMENSIONS" "$kith" run 3.yaml
rm kith-2d
check 1 "kith-1d is not built" "$kith" list

exit $((failures > 0))
