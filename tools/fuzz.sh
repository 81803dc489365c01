#!/usr/bin/env bash
# Fuzzes each reader of finite-element files for SECONDS (default 60) with libFuzzer, address and undefined-behaviour
# sanitizers: tools/fuzz.sh [SECONDS] [READER...]. Wants clang++ with its fuzzer runtime (libclang-rt-dev) and Eigen;
# inputs that crash a reader are left in build/fuzz/READER/.
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
readers=("$@")
[ ${#readers[@]} -gt 0 ] || readers=(calculix matrix_market sid gmsh frd abaqus ansys nastran op4)
clang=${CLANG:-$(command -v clang++-16 || command -v clang++)}
out=build/fuzz
mkdir -p "$out/objects"

# What the readers need, compiled once; CHOLMOD, spdlog and the rest of the engine stay out.
flags=(-std=c++20 -O1 -g1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined
  -I. -isystem "${EIGEN:-/usr/include/eigen3}")
sources=(engine/error.cpp engine/output/partial_file.cpp)
for source in bodies/flexible/readers/*.cpp; do
  case $source in */body_formats.cpp | */read_flexible_body.cpp | */unit_system.cpp) ;; *) sources+=("$source") ;; esac
done
objects=()
for source in "${sources[@]}"; do
  object=$out/objects/$(basename "$source" .cpp).o
  [ "$object" -nt "$source" ] || "$clang" "${flags[@]}" -c "$source" -o "$object"
  objects+=("$object")
done

status=0
for reader in "${readers[@]}"; do
  mkdir -p "$out/$reader/corpus"
  "$clang" "${flags[@]}" -fsanitize=fuzzer "-DLITHE_READER=$reader" tools/fuzz/reader_fuzz.cpp "${objects[@]}" \
    -o "$out/$reader/fuzz"
  echo "== $reader"
  "$out/$reader/fuzz" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -max_len=32768 -print_final_stats=1 \
    -artifact_prefix="$out/$reader/" "$out/$reader/corpus" "tests/data/import/corpus/$reader" \
    >"$out/$reader/log" 2>&1 || { status=1; tail -30 "$out/$reader/log"; continue; }
  grep -E 'number_of_executed|new_units' "$out/$reader/log"
done
exit $status
