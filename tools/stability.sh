#!/usr/bin/env bash
# The stability laboratory: builds it and runs every scene with every method, those that must fail too. A line a cell on
# stdout; results/stability/: summary.json, table.md, map.svg, map.png. Fails where an outcome is not the published one.
# tools/stability.sh S05 S24 runs those scenes alone.
#   LITHE_JOBS=2    jobs at once while building
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
stage_count=4
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure release" cmake --preset release -D LITHE_STABILITY=ON
build "build" cmake --build --preset release --parallel "$jobs" --target stability
stage_shown "scenes x methods" build/release/tools/stability/stability \
  --expected tests/data/stability/expected.json --expected tests/data/stability/own.json \
  --out results/stability "$@"
