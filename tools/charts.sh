#!/usr/bin/env bash
# Draws the project's work-precision charts into docs/charts: all of them, or those named: tools/charts.sh heavy_top.
#   LITHE_JOBS=2    jobs at once while building
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
stage_count=3
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure release" cmake --preset release
build "build release" cmake --build --preset release --parallel "$jobs" --target lithe_command flexible_pendulum_models \
  flexible_models slender_models
exec tools/charts/draw.sh build/release/bin/lithe build/release/tools/charts "$@"
