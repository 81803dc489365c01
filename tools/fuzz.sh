#!/usr/bin/env bash
# Fuzzes for SECONDS each (default 60) with libFuzzer, address and undefined-behaviour sanitizers:
#   tools/fuzz.sh [SECONDS] [TARGET...]
# Targets: the readers of finite-element files, tables, reduced bodies and models (tools/fuzz/*_targets.cpp); all by
# default. What they must not do is crash, hang, or take a damaged input as good. Wants clang++ with its fuzzer runtime
# (libclang-rt-dev).
# Inputs that fail are left in build/fuzz/TARGET/; new ones that reach new code in build/fuzz/TARGET/corpus:
#   tools/fuzz.sh minimise [TARGET...]   puts some of those that reach as much as all into tests/data/fuzz/TARGET
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-60}
shift || true
all=(calculix matrix_market sid gmsh frd abaqus ansys harwell_boeing nastran op4 csv binary hdf5_table basis
  urdf sdf mjcf adams fmu fmu_package tir)
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=("${all[@]}")
for target in "${targets[@]}"; do
  case " ${all[*]} " in *" $target "*) ;; *) echo "no such target: $target" >&2; exit 2 ;; esac
done
clang=${CLANG:-$(command -v clang++-16 || command -v clang++)}
out=build/fuzz
mkdir -p "$out/objects"

flags=(-std=c++20 -O1 -g1 -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=undefined -I.
  -isystem "${EIGEN:-/usr/include/eigen3}" $(pkg-config --cflags hdf5-serial 2>/dev/null || pkg-config --cflags hdf5))
hdf5=$(pkg-config --libs hdf5-serial 2>/dev/null || pkg-config --libs hdf5)

# What the readers need; CHOLMOD, spdlog and the rest of the engine stay out.
sources=(engine/base/error.cpp engine/output/{partial_file,table,csv,binary,hdf5_file,hdf5_table}.cpp
  bodies/flexible/basis_file.cpp bodies/flexible/elements/{solid_element,shape_functions}.cpp
  models/{urdf,sdf,mjcf,xml_file,model_description,link_graph,read_tir}.cpp joints/tyre/magic_formula.cpp
  models/adams/{adams_statements,adams_function,adams_words,adams_units,read_adams,read_adams_elements}.cpp
  models/fmu/{fmu_contents,fmu_package}.cpp
  engine/base/{checks,dense,dense_eigen,dense_inverse,math,rotations,temporary_folder}.cpp engine/model/appearance.cpp
  tools/fuzz/{fuzz,targets,body_targets,table_targets,model_targets}.cpp)
for source in bodies/flexible/readers/*.cpp; do
  case $source in */body_formats.cpp | */read_flexible_body.cpp | */unit_system.cpp) ;; *) sources+=("$source") ;; esac
done
objects=()
for source in "${sources[@]}"; do
  object=$out/objects/$(echo "${source%.cpp}" | tr / _).o
  # Compiled again where a file of its list is newer.
  if [ ! -e "$object" ] || [ -n "$(find $(sed 's/^[^:]*://; s/\\$//' "${object%.o}.d") -newer "$object" 2>/dev/null)" ]; then
    "$clang" "${flags[@]}" -MMD -c "$source" -o "$object"
  fi
  objects+=("$object")
done
"$clang" -fsanitize=fuzzer,address,undefined "${objects[@]}" $hdf5 -lpugixml -lzip -o "$out/fuzz"

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
  if [ "$seconds" = minimise ]; then
    mkdir -p "tests/data/fuzz/$target.new"
    ASAN_OPTIONS=detect_leaks=0 "$out/fuzz" -merge=1 -max_len=8192 "tests/data/fuzz/$target.new" "$out/$target/corpus" \
      ${corpus[@]+"${corpus[@]}"} >"$out/$target/log" 2>&1 || { tail -30 "$out/$target/log"; exit 1; }
    # Of these some sixteen below 3 kB, evenly by size: for the test that reads them once more.
    mkdir -p "tests/data/fuzz/$target"
    find "tests/data/fuzz/$target" -type f ! -name seed -delete
    find "tests/data/fuzz/$target.new" -type f -size -6 -printf '%s %p\n' | sort -n | cut -d' ' -f2- |
      awk '{ all[NR] = $0 } END { step = NR / 16; if (step < 1) step = 1; for (i = 1; i <= NR; i += step) print all[int(i)] }' |
      xargs -r cp -t "tests/data/fuzz/$target"
    rm -r "tests/data/fuzz/$target.new"
    continue
  fi
  # HDF5 itself leaks where a file is damaged.
  leaks=1
  case $target in hdf5_table | basis) leaks=0 ;; esac
  ASAN_OPTIONS=detect_leaks=$leaks "$out/fuzz" -max_total_time="$seconds" -timeout=10 -rss_limit_mb=1024 -max_len=32768 \
    -print_final_stats=1 -artifact_prefix="$out/$target/" "$out/$target/corpus" ${corpus[@]+"${corpus[@]}"} \
    >"$out/$target/log" 2>&1 || { status=1; tail -40 "$out/$target/log"; continue; }
  grep -E 'number_of_executed|new_units' "$out/$target/log"
done
exit $status
