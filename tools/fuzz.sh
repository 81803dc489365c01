#!/usr/bin/env bash
# Fuzzes for SECONDS each (default 60) with libFuzzer, address and undefined-behaviour sanitizers:
#   tools/fuzz.sh [SECONDS] [TARGET...]
# Targets: readers of finite-element files, tables, reduced bodies, models, checkpoints and runs, and the table of a
# plug-in (tools/fuzz/*_targets.cpp); all by default. What they must not do is crash, hang, or take a damaged input as
# good. Wants Clang with its fuzzer runtime (libclang-rt-dev) and the library of the preset `release`, which it builds.
# Inputs that fail are left in build/fuzz/TARGET/; new ones that reach new code in build/fuzz/TARGET/corpus:
#   tools/fuzz.sh minimise [TARGET...]   puts some of those that reach as much as all into tests/data/fuzz/TARGET
#   tools/fuzz.sh coverage [TARGET...]   lines of the sources under attack that the kept inputs reach, as a table
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
all=(calculix matrix_market sid gmsh frd abaqus ansys harwell_boeing nastran op4 csv binary hdf5_table basis
  urdf sdf mjcf adams fmu fmu_package tir checkpoint checkpoint_file run_file run_scene plugin_table)
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")
for target in "${targets[@]}"; do
  case " ${all[*]} " in *" $target "*) ;; *) echo "no such target: $target" >&2; exit 2 ;; esac
done
out=build/fuzz
program=fuzz
[ "$seconds" = coverage ] && program=fuzz_coverage
mkdir -p "$out"
[ -e build/release/build.ninja ] || cmake --preset release >"$out/log"
ninja -C build/release -j "${LITHE_JOBS:-$(nproc)}" "$program" >"$out/log" || { tail -40 "$out/log"; exit 1; }
program=build/release/tools/fuzz/$program

# Files are written for each input: into memory.
[ -d /dev/shm ] && export TMPDIR=${TMPDIR:-/dev/shm}
status=0
for target in "${targets[@]}"; do
  corpus=()
  for folder in "tests/data/fuzz/$target" "tests/data/import/corpus/$target"; do
    [ -d "$folder" ] && corpus+=("$folder")
  done
  mkdir -p "$out/$target/corpus"
  echo "== $target"
  export LITHE_FUZZ_TARGET=$target
  if [ "$seconds" = coverage ]; then
    rm -f "$out/$target"/*.profraw
    find "${corpus[@]}" -type f -print0 |
      LLVM_PROFILE_FILE="$out/$target/%p.profraw" xargs -0 "$program" >"$out/$target/log" 2>&1 ||
      { tail -30 "$out/$target/log"; exit 1; }
    continue
  fi
  if [ "$seconds" = minimise ]; then
    mkdir -p "tests/data/fuzz/$target.new"
    ASAN_OPTIONS=detect_leaks=0 "$program" -merge=1 -max_len=8192 "tests/data/fuzz/$target.new" "$out/$target/corpus" \
      ${corpus[@]+"${corpus[@]}"} >"$out/$target/log" 2>&1 || { tail -30 "$out/$target/log"; exit 1; }
    # Of these some sixteen below 3 kB, evenly by size: for the test that reads them once more.
    mkdir -p "tests/data/fuzz/$target"
    find "tests/data/fuzz/$target" -type f ! -name 'seed*' ! -name 'found*' -delete
    find "tests/data/fuzz/$target.new" -type f -size -6 -printf '%s %p\n' | sort -n | cut -d' ' -f2- |
      awk '{ all[NR] = $0 } END { step = NR / 16; if (step < 1) step = 1; for (i = 1; i <= NR; i += step) print all[int(i)] }' |
      xargs -r cp -t "tests/data/fuzz/$target"
    rm -r "tests/data/fuzz/$target.new"
    continue
  fi
  # HDF5 itself leaks where a file is damaged.
  leaks=1
  case $target in hdf5_table | basis | checkpoint_file | run_file | run_scene) leaks=0 ;; esac
  # Inputs that are choices (tools/fuzz/script.h) want some hundred bytes from the start.
  lengths=(-max_len=32768)
  case $target in checkpoint | plugin_table) lengths=(-max_len=512 -len_control=0) ;; esac
  ASAN_OPTIONS=detect_leaks=$leaks "$program" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 "${lengths[@]}" \
    -print_final_stats=1 -artifact_prefix="$out/$target/" "$out/$target/corpus" ${corpus[@]+"${corpus[@]}"} \
    >"$out/$target/log" 2>&1 || { status=1; tail -40 "$out/$target/log"; continue; }
  grep -E 'number_of_executed|new_units' "$out/$target/log"
done
if [ "$seconds" = coverage ]; then
  llvm-profdata-16 merge -o "$out/profile" $(find "${targets[@]/#/$out/}" -name '*.profraw')
  echo "| source | lines | reached |"
  echo "|---|---|---|"
  llvm-cov-16 export "$program" -instr-profile="$out/profile" -summary-only -ignore-filename-regex='/(usr|tools/fuzz)/' |
    python3 -c '
import json, os, sys
for source in json.load(sys.stdin)["data"][0]["files"]:
    name, lines = os.path.relpath(source["filename"]), source["summary"]["lines"]
    if name.endswith(".cpp"):
        print("| `%s` | %d | %.0f %% |" % (name, lines["count"], lines["percent"]))'
fi
exit $status
