#!/usr/bin/env bash
# Measures Lithe beside hand-written programs of the same scenes: builds, runs both by turns on one core, counts their
# instructions; then the time of a step for more chains and pendulums. A table on stdout, results/bench/summary.json for
# machines. About five minutes after the first build.
#   LITHE_JOBS=2    jobs at once while building
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
programs=(limit_chain chain limit_flexible pendulum)
benchmarks=(chain_benchmark pendulum_benchmark)
counted=build/release
stage_count=3
if grep -qw avx512f /proc/cpuinfo; then  # valgrind knows no AVX-512: instructions are counted in a build for x86-64-v3
  counted=build/count
  stage_count=4
fi
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure release" cmake --preset release
build "build release" cmake --build --preset release --parallel "$jobs" --target "${programs[@]}" "${benchmarks[@]}"

if [[ $counted != build/release ]]; then
  cmake -S . -B $counted -G Ninja -DCMAKE_BUILD_TYPE=Release -DLITHE_NATIVE=OFF -DCMAKE_CXX_FLAGS=-march=x86-64-v3 \
    -DLITHE_TESTS=OFF -DLITHE_EXAMPLES=OFF -DLITHE_BENCH=ON > /dev/null
  build "build for counting" cmake --build $counted --parallel "$jobs" --target "${programs[@]}"
fi

mkdir -p results/bench
python3 tools/bench/compare.py --timed build/release/tools/bench --counted $counted/tools/bench \
  --out results/bench/summary.json

pinned=()
command -v taskset > /dev/null && pinned=(taskset -c 0)
for program in "${benchmarks[@]}"; do
  echo
  "${pinned[@]}" build/release/tools/bench/"$program" --benchmark_min_time=0.2 \
    --benchmark_out=results/bench/"$program".json --benchmark_out_format=json 2> results/bench/"$program".log
done
