#!/usr/bin/env bash
# Bundles the viewer into one page: tools/viewer/build.sh [OUT.html]; the default is the committed dist/viewer.html.
set -euo pipefail
cd "$(dirname "$0")"
out=$(realpath -m "${1:-dist/viewer.html}")
if [[ ! -e node_modules/.package-lock.json || package-lock.json -nt node_modules/.package-lock.json ]]; then
  npm ci --ignore-scripts --no-audit --no-fund --silent
  touch node_modules/.package-lock.json
fi
node build.mjs "$out"
