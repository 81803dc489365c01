#!/usr/bin/env bash
# Measures Lithe, hand-written programs of the same scenes and the engines that Debian packages, all in one go: builds,
# runs them by turns on one core. Tables on stdout, results/bench/summary.json for machines, docs/benchmarks.md for readers.
# About fifteen minutes after the first build.
#   --quick             about four minutes: fewer methods, least of two; writes the same files
#   --install-peers     first installs the peers' packages (tools/bench/peers/packages.txt); without it those there are used
#   --check             only counts instructions and compares them with tools/bench/baseline.json: 1 if over 3 % off
#   --update-baseline   only counts them, and writes that file
#   LITHE_JOBS=2        jobs at once while building;  LITHE_CORE=0  the core to measure on
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
mode=measure
quick=()
install_peers=no
for option in "$@"; do
  case $option in
    --quick) quick=(--quick) ;;
    --install-peers) install_peers=yes ;;
    --check) mode=check ;;
    --update-baseline) mode=update ;;
    *)
      sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
      exit 2
      ;;
  esac
done

counted_programs=(chain explicit_chain pendulum limit_chain limit_explicit limit_flexible beam limit_beam)
# Times are those of the default build, by Clang. Valgrind knows no AVX-512, nor all that Clang makes of x86-64-v3:
# instructions are counted in a build for it by GCC, which also compiles the drivers of robots.
counted=build/count
stage_count=3
[[ $mode == measure ]] && stage_count=5
[[ $install_peers == yes ]] && stage_count=$((stage_count + 1))
export PYTHONDONTWRITEBYTECODE=1
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
if [[ $install_peers == yes ]]; then
  stage_shown "peers' packages" tools/install_packages.sh tools/bench/peers/packages.txt
fi
stage "configure for counting" cmake -S . -B $counted -G Ninja -DCMAKE_BUILD_TYPE=Release -DLITHE_NATIVE=OFF \
  -DCMAKE_C_COMPILER=gcc -DCMAKE_CXX_COMPILER=g++ -DLITHE_ARCH=x86-64-v3 -DLITHE_TESTS=OFF -DLITHE_EXAMPLES=OFF -DLITHE_BENCH=ON
build "build for counting" cmake --build $counted --parallel "$jobs" --target "${counted_programs[@]}"
case $mode in
  check) exec python3 tools/bench/check.py --counted $counted/tools/bench ;;
  update) exec python3 tools/bench/check.py --counted $counted/tools/bench --update ;;
esac

stage "configure" cmake --preset release
build "build" cmake --build --preset release --parallel "$jobs" --target tools/bench/all
python3 tools/bench/benchmarks.py --timed build/release/tools/bench --counted $counted/tools/bench \
  --core "${LITHE_CORE:-0}" "${quick[@]}"
