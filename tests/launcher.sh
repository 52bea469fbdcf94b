#!/usr/bin/env bash
# launcher.sh PROGRAM: the launcher on a small tree of its own, whose programs print their arguments; then the choice
# of the dimension by the program `kith`. Nothing is installed.
set -uo pipefail
export KITH_NO_INSTALL=1
unset OMP_NUM_THREADS
program=$(readlink -f "$1")
source=$(dirname "$(dirname "$(readlink -f "$0")")")
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
failures=0

# check CODE TEXT COMMAND...: the command ends with CODE, and its output holds TEXT.
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

# ---- the launcher; its tree has a blank in its name, and the caller is elsewhere
tree="$place/a tree"
mkdir -p "$tree" "$place/elsewhere"
cp "$source/kith" "$source/CMakePresets.json" "$tree"
cat >"$tree/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(kith VERSION 9.8.7 LANGUAGES NONE)
add_custom_command(OUTPUT copied DEPENDS program COMMAND mkdir -p bin COMMAND cp ${PROJECT_SOURCE_DIR}/program bin/kith
  COMMAND touch copied)
add_custom_target(kith DEPENDS copied)
foreach(dim 1 2 3)
  add_custom_target(kith-${dim}d)
endforeach()
END
cat >"$tree/program" <<'END'
#!/usr/bin/env bash
[[ $* == *code3* ]] && exit 3
echo "threads $OMP_NUM_THREADS bind $OMP_PROC_BIND in $(basename "$PWD"):$(printf ' [%s]' "$@")"
END
chmod +x "$tree/program"
ln -s "$tree/kith" "$place/link"
cd "$place/elsewhere" || exit 1
kith=$place/link

check 2 "usage: kith VERB" "$kith"
check 0 "usage: kith VERB" "$kith" --help
check 0 "usage: kith VERB" "$kith" run scene.yaml --help
check 0 "kith 9.8.7" "$kith" --version
check 2 "unknown verb 'rum'" "$kith" rum scene.yaml
check 2 "build takes no arguments" "$kith" build all
for bad in 0 -1 x 1.5 '' 1x 99999999999999999999; do
  check 2 "kith: --threads ${bad:-(nothing)}: not a whole number" "$kith" run scene.yaml --threads "$bad"
  check 2 "kith: --ranks ${bad:-(nothing)}: not a whole number" "$kith" run "--ranks=$bad" scene.yaml
done
check 2 "--threads (nothing): not" "$kith" run scene.yaml --threads
if [[ -e $tree/build ]]; then echo "built for nothing" && failures=$((failures + 1)); fi

check 0 "threads 3 bind true in elsewhere: [run] [a b.yaml] [--set] [x=1] [] [--quiet]" \
  "$kith" run "a b.yaml" --threads 3 --set x=1 --ranks=1 '' --quiet
check 0 "threads 1 bind false in elsewhere: [run] [scene.yaml] [--ranks] [1000]" "$kith" run scene.yaml --ranks 1000
check 0 "threads 3 bind false in elsewhere: [run] [--ranks] [2]" "$kith" run --ranks=2 --threads 3
check 0 "threads $(nproc) bind true in elsewhere: [plan] [--ranks] [4096]" "$kith" plan --ranks 4096
check 0 "threads 2 bind true in elsewhere: [plan] [--] [--threads] [5]" "$kith" plan --threads=2 -- --threads 5
check 0 "threads $(nproc) bind true in elsewhere: [list]" "$kith" list
check 0 "threads 2 bind true in elsewhere: [chart] [--threads] [2] [sod]" "$kith" chart --threads 2 sod
check 0 "threads 1 bind true in elsewhere: [stress] [mach] [--threads] [1]" "$kith" stress mach --threads=1
check 0 "threads 7 bind close in" env OMP_NUM_THREADS=7 OMP_PROC_BIND=close "$kith" bench
check 3 "" "$kith" validate code3

# What changed is built, also in a tree that was moved; a failed build is shown.
sed -i 's/threads/now threads/' "$tree/program"
check 0 "now threads" "$kith" list
mv "$tree" "$place/moved"
check 0 "now threads" "$place/moved/kith" list
rm "$place/moved/program"
check 1 "building release failed" "$place/moved/kith" list
check 1 "needed by 'copied'" "$place/moved/kith" build

# ---- the program: the dimension
cp "$program" kith
for dim in 1 2 3; do
  printf '#!/bin/sh\necho "%dd $*"\n' "$dim" >"kith-${dim}d"
  chmod +x "kith-${dim}d"
  printf 'scene: x\ninner: {dimension: 9}\n# dimension: 8\n"dimension": %d # as it is\n' "$dim" >"$dim.yaml"
done
kith=$PWD/kith
for dim in 1 2 3; do
  check 0 "${dim}d run $dim.yaml" "$kith" run $dim.yaml
  check 0 "${dim}d plan -o 2.yaml --trace 1.yaml $dim.yaml 3.yaml" "$kith" plan -o 2.yaml --trace 1.yaml $dim.yaml 3.yaml
  check 0 "${dim}d run -- $dim.yaml" "$kith" run -- $dim.yaml
  check 0 "${dim}d run" "$kith" run --set dimension=2 3.yaml --set method.dimension=1 --set=dimension=$dim --quiet
done
check 0 "1d run none.yaml" "$kith" run none.yaml
check 0 "1d run" "$kith" run
check 0 "1d run" "$kith" run "$PWD" # a folder
check 0 "1d run" "$kith" run 3.yaml --set dimension=4
printf 'dimension: [3]\n' >wrong.yaml
check 0 "1d run" "$kith" run wrong.yaml
printf 'dimension: 3\n  broken: [\n' >wrong.yaml
check 0 "1d run" "$kith" run wrong.yaml
: >wrong.yaml
check 0 "1d run" "$kith" run wrong.yaml
check 0 "1d validate" "$kith" validate
check 0 "1d chart 3.yaml" "$kith" chart 3.yaml
check 0 "1d stress mach" "$kith" stress mach
check 0 "3d list a b" "$kith" list a b
check 0 "3d bench" "$kith" bench
check 0 "3d --version" "$kith" --version
check 0 "3d " "$kith"
rm kith-3d
check 1 "cannot start" "$kith" list

exit $((failures > 0))
