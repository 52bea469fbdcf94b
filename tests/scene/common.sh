#!/usr/bin/env bash
# common.sh PROGRAMS: sourced by the scene tests: a temporary directory, a tiny scene, and checks that count
# failures.
export OMP_NUM_THREADS=1 OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
programs=$(readlink -f "$1")
kith=$programs/kith
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place" || exit 1
failures=0

# Half of a shock tube: 56 nodes, about 20 steps to t = 0.05.
cat >tiny.yaml <<'END'
scene: tiny
dimension: 1
resolution: 50
domain: {lower: [-1, 0, 0], upper: [1, 1, 1]}
boundaries: {x: reflecting, y: periodic, z: periodic}
materials:
  gas: {eos: ideal, gamma: 1.4}
regions:
  - {material: gas, where: {x: [-1, 0]}, density: 1.0, pressure: 1.0}
  - {material: gas, where: {x: [0, 1]}, density: 0.125, pressure: 0.1}
until: 0.05
output: {plot: false}
END

wrong() {
  printf 'FAILED: %s\n' "$*"
  failures=$((failures + 1))
}

# stopped CODE TEXT COMMAND...: the command must end with CODE, and print one line to stderr, which begins
# with "kith: " and contains TEXT.
stopped() {
  local code=$1 text=$2 got lines
  shift 2
  "$@" >stdout 2>stderr
  got=$?
  lines=$(wc -l <stderr)
  if ((got != code || lines != 1)) || [[ $(<stderr) != *"$text"* ]] || [[ $(<stderr) != "kith: "* ]]; then
    wrong "$* ended with $got, wanted $code and one line with '$text'; stderr:"
    head -5 stderr
  fi
}

# refused TEXT COMMAND...: the command must be stopped with code 2, and leave the directory `out` as it was.
refused() {
  local text=$1 before
  shift
  before=$(seen out)
  stopped 2 "$text" "$@"
  [[ $(seen out) == "$before" ]] || wrong "$* left something: $(ls -A out)"
}

# Prints checksums of all files in a directory, and its folders.
seen() {
  [[ ! -e $1 ]] || (cd "$1" && find . -type f -exec cksum {} + | sort && find . -type d | sort)
}

# ok COMMAND...: the command must end with 0, and print nothing to stderr.
ok() {
  "$@" >stdout 2>stderr || wrong "$* ended with $?; stderr: $(<stderr)"
  [[ ! -s stderr ]] || wrong "$* said on stderr: $(<stderr)"
}

same() { cmp "$1" "$2" || wrong "$1 and $2 differ"; }
