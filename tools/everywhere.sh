#!/usr/bin/env bash
# tools/test.sh --everywhere[=NAME,...]: builds and tests the configurations below, each a preset of CMakePresets.json,
# goes on after one that fails, and fails in the end if one did. Results: printed, and the rows of docs/hardening.md.
#   LITHE_JOBS=2   jobs at once; all processors by default
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
table=docs/hardening.md
all=(v2 release v4 native o1 gcc asan tsan)
declare -A needs=([release]="avx2 bmi2 fma movbe" [v4]="avx2 bmi2 fma movbe avx512f avx512bw avx512cd avx512dq avx512vl"
                  [o1]="avx2 bmi2 fma movbe")
names=("${all[@]}")
[[ $# -gt 0 && -n $1 ]] && IFS=, read -ra names <<< "$1"
for name in "${names[@]}"; do
  if [[ " ${all[*]} " != *" $name "* ]]; then
    echo "no configuration '$name': give some of ${all[*]}" >&2
    exit 2
  fi
done

processor() { sed -n '/^model name/{s/.*: *//p;q}' /proc/cpuinfo; }

# Why this machine cannot run it; nothing if it can.
obstacle() {
  local flag
  for flag in ${needs[$1]:-}; do
    if ! grep -qw "$flag" /proc/cpuinfo; then
      echo "the processor has no $flag"
      return
    fi
  done
  if [[ $1 != gcc ]] && ! compgen -G '/usr/lib/llvm-1[69]/lib/clang/1[69]/include/omp.h' > /dev/null; then
    echo "it needs clang-16 or clang-19 and, for SUNDIALS, its libomp-dev"
  fi
}

# The row's last cells: processor, tests, what failed.
note() {
  local name=$1 tests=$2 failed=$3
  sed -i "s#^\(| \`$name\` |[^|]*|\).*#\1 $(processor) | $tests | $failed |#" "$table"
}

# All of one configuration, its output in build/everywhere/NAME.log.
tested() {
  local name=$1 log=build/everywhere/$1.log count failed
  echo "$name: building; see $log"
  if ! { cmake --preset "$name" -D LITHE_BENCH=OFF && cmake --build --preset "$name" --parallel "$jobs" -- -k 0; } \
      > "$log" 2>&1; then
    note "$name" - "does not build"
    return 1
  fi
  echo "$name: testing"
  # The command, the package and the pages do not depend on how numbers are rounded: twice is enough.
  local left_out=()
  [[ $name == release || $name == gcc ]] || left_out=(--label-exclude "scripting|package|docs|page")
  ctest --preset "$name" --parallel "$jobs" --no-tests=error "${left_out[@]}" >> "$log" 2>&1 || true
  count=$(sed -n 's/.*tests failed out of \([0-9]*\)$/\1/p' "$log" | tail -1)
  failed=$(sed -n 's/^\t *[0-9]* - \(.*\) (.*)$/\1/p' "$log" | sort -u | paste -sd, | sed 's/,/, /g')
  note "$name" "${count:-none}" "${failed:-none}"
  [[ -n $count && -z $failed ]]
}

tools/install_packages.sh
mkdir -p build/everywhere
bad=0
for name in "${names[@]}"; do
  why=$(obstacle "$name")
  if [[ -n $why ]]; then
    echo "$name: not run, $why"
  else
    tested "$name" || bad=$((bad + 1))
  fi
done
for name in "${names[@]}"; do grep "^| \`$name\` |" "$table"; done
if [[ $bad -gt 0 ]]; then
  echo "$bad of ${#names[@]} configurations failed" >&2
  exit 1
fi
