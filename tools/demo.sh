#!/usr/bin/env bash
# Builds and runs the first three examples and the one that writes a page, or those whose numbers are given:
# tools/demo.sh 02 05. Results, charts and pages go to results/.
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
[[ $# -gt 0 ]] || set -- 01 02 03 21
examples=()
for number in "$@"; do
  for source in examples/"$number"_*.cpp; do
    if [[ ! -e $source ]]; then
      echo "error: there is no example $number." >&2
      echo "  fix:  known are $(cd examples && echo [0-9][0-9]_*.cpp)" >&2
      exit 1
    fi
    examples+=("$(basename "$source" .cpp)")
  done
done
stage_count=$((3 + ${#examples[@]}))
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure" cmake --preset release
build "build ${examples[*]}" cmake --build --preset release --parallel "$jobs" --target "${examples[@]}"

mkdir -p results
marker=$(mktemp)  # what is newer than this was written by the examples
trap 'rm -f "$marker"' EXIT
for example in "${examples[@]}"; do
  stage_shown "run $example" build/release/examples/"$example"
done

charts=(-name '*.svg' -o -name '*.png' -o -name '*.pdf')
echo
echo "Charts:"
find results -newer "$marker" -type f \( "${charts[@]}" \) | sort | sed 's/^/  /'
echo "Other results:"
find results -newer "$marker" -type f ! \( "${charts[@]}" \) ! -name '*.vtu' ! -name '*.html' | sort | sed 's/^/  /'

pages=$(find results -newer "$marker" -type f -name '*.html' | sort)
if [[ -n $pages ]]; then
  echo
  echo "Open in any browser:"
  sed 's/^/  /' <<<"$pages"
fi
