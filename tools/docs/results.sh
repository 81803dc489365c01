#!/usr/bin/env bash
# Runs the examples whose numbers are given, or all, and keeps what the tutorial shows of them: their words and charts, in
# docs/site/tutorial/results; then notes the inputs' hashes in docs/figures.json.
#   LITHE_BUILD=folder   takes the examples from that build instead of building them in build/release
set -euo pipefail
cd "$(dirname "$0")/../.."

build=${LITHE_BUILD:-build/release}
results=docs/site/tutorial/results
mkdir -p "$results"
[[ $# -gt 0 ]] || { cd examples; set -- [0-9][0-9]_*.cpp; cd ..; set -- "${@%%_*}"; }

kept=()
shopt -s nullglob
for number in "$@"; do
  example=$(basename examples/"$number"_*.cpp .cpp)
  if [[ -z ${LITHE_BUILD:-} ]]; then
    cmake --preset release > /dev/null
    cmake --build --preset release --target "$example"
  fi
  program=$(realpath "$build/examples/$example")
  scratch=$(mktemp -d)
  mkdir "$scratch/results"
  # Its own words, without the log and without places of this machine.
  if ! (cd "$scratch" && "$program") > "$scratch/words.txt" 2> "$scratch/log.txt"; then
    cat "$scratch/words.txt" "$scratch/log.txt" >&2
    exit 1
  fi
  sed "s|$scratch/||g; s|[^ ']*/examples/data/|examples/data/|g" "$scratch/words.txt" > "$results/$number.txt"
  page=docs/site/tutorial/$example.md
  # The charts that the page shows, from wherever the example put them.
  for shown in $(grep -o "results/${number}_[a-z0-9_]*\.png" "$page" || true); do
    name=${shown#results/"${number}"_}
    found=$(find "$scratch/results" -name "$name" | head -n 1)
    if [[ -z $found ]]; then
      echo "error: $example draws no chart $name, which $page shows." >&2
      exit 1
    fi
    cp "$found" "docs/site/tutorial/$shown"
  done
  # Those of the front page.
  if [[ $number == 02 ]]; then
    cp "$scratch"/results/flexible_pendulum/{z,dz}.png docs/pictures/
    kept+=(docs/pictures/{z,dz}.png)
  fi
  rm -rf "$scratch"
  kept+=("$results/$number.txt" "$results/${number}"_*.png)
  echo "$example: kept"
done
/usr/bin/python3 -B tools/docs/figures.py note --same "${kept[@]}"
