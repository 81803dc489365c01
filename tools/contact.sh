#!/usr/bin/env bash
# Measures piles of rigid bodies by Bullet, by BulletStepper and by the engine's own time stepping, and draws work against
# precision on motions with contact whose end is known. Writes results/contact/ and in docs/benchmarks
# contact_table.md, contact_*.svg, .png.
#   LITHE_JOBS=2    jobs at once while building
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
results=results/contact
programs=build/release/tools/contact
stage_count=5
export LITHE_LOG=${LITHE_LOG:-error}
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure release" cmake --preset release
build "build contact_bench contact_chart" cmake --build --preset release --parallel "$jobs" --target contact_bench \
  contact_chart

mkdir -p $results
rm -f $results/contact*  # what is there afterwards is of this run
pinned=()
command -v taskset > /dev/null && pinned=(taskset -c 0)
stage_shown "piles" "${pinned[@]}" $programs/contact_bench --out $results
stage_shown "known motions" "${pinned[@]}" $programs/contact_chart --out $results
cp $results/contact_table.md $results/contact_*.svg $results/contact_*.png docs/benchmarks/
printf '  %s\n' $results/contact.json docs/benchmarks/contact_table.md docs/benchmarks/contact_*.svg
