#!/usr/bin/env bash
# Installs what is missing, builds the release preset, runs the tests. A second call rebuilds only what changed.
#   --all              also the longest: four machines, pages in a browser, archives, projects outside, the newcomer's hour, and others
#   LITHE_JOBS=2       jobs at once; all processors by default
#   LITHE_SANITIZE=1   afterwards the same under AddressSanitizer and UndefinedBehaviorSanitizer
# --everywhere[=NAME,...]: builds and tests for other processors, compilers and sanitizers instead; tools/everywhere.sh
set -euo pipefail
cd "$(dirname "$0")/.."
all=no left_out=(--label-exclude '^long$')
case ${1:-} in
  --everywhere) exec tools/everywhere.sh ;;
  --everywhere=*) exec tools/everywhere.sh "${1#--everywhere=}" ;;
  --all) all=yes left_out=() ;;
  ?*)
    sed -n '2,6s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac

jobs=${LITHE_JOBS:-$(nproc)}
presets=(release)
[[ ${LITHE_SANITIZE:-0} == 1 ]] && presets+=(asan)
stage_count=$((1 + 3 * ${#presets[@]}))
[[ $all == no ]] || stage_count=$((stage_count + 1))
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
browser() { tools/install_packages.sh tools/page_packages.txt || echo "without it the page's tests are skipped"; }
[[ $all == no ]] || stage_shown "browser" browser
for preset in "${presets[@]}"; do
  stage "configure $preset" cmake --preset "$preset" -D LITHE_BENCH=OFF  # benchmarks are no tests: tools/bench.sh
  build "build $preset" cmake --build --preset "$preset" --parallel "$jobs"
  # One more than processors: some wait for a socket, a clock or a disk.
  stage_shown "tests $preset" ctest --preset "$preset" --parallel "$((jobs + 1))" --no-tests=error "${left_out[@]}"
done
