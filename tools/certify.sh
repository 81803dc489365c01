#!/usr/bin/env bash
# Holds what solve() states against what is so: builds, finds the cheapest settings by hand, runs solve() on every scene
# of tools/certify at 10 %, 1 % and 0.1 %. Writes results/certify/ (tuned.json, summary.json) and in docs/charts
# certify_table.md, certify*.svg, .png. Fails if less than 95 % of the stated errors hold, or their median is five times the
# true one or more. Six minutes after the first build.
#   --keep-tuned    takes results/certify/tuned.json as it is, if it is there: its costs are of then
#   --references    first makes the references anew (tools/certify/references; four more minutes)
#   LITHE_JOBS=2    jobs at once while building
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=${LITHE_JOBS:-$(nproc)}
keep_tuned=no
references=no
for option in "$@"; do
  case $option in
    --keep-tuned) keep_tuned=yes ;;
    --references) references=yes ;;
    *)
      sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
      exit 2
      ;;
  esac
done

results=results/certify
programs=build/release/tools/certify
targets=(certify_certify)
[[ $keep_tuned == yes && -e $results/tuned.json ]] || { keep_tuned=no && targets+=(certify_tuned); }
[[ $references == yes ]] && targets+=(certify_reference)
stage_count=$((3 + ${#targets[@]}))
export LITHE_LOG=${LITHE_LOG:-error}  # scenes with redundant rows would say so at every run
source tools/stages.sh

stage_shown "packages" tools/install_packages.sh
stage "configure release" cmake --preset release
build "build ${targets[*]}" cmake --build --preset release --parallel "$jobs" --target "${targets[@]}"

mkdir -p $results
if [[ $references == yes ]]; then
  stage_shown "references" $programs/reference all tools/certify/references
fi
if [[ $keep_tuned == no ]]; then
  # Under its name only when complete: an interrupted one would be kept.
  stage_shown "settings by hand" $programs/tuned $results/tuned.partial.json
  mv $results/tuned.partial.json $results/tuned.json
fi

rm -f $results/summary.json $results/certify*  # what is there afterwards is of this run
result=0
(stage_shown "solve()" $programs/certify $results $results/tuned.json) || result=$?
[[ -e $results/summary.json ]] || exit "$result"

# What misses its promise is shown all the same.
cp $results/certify*.svg $results/certify*.png docs/charts/
cp $results/certify_table.md docs/charts/
echo
printf '  %s\n' $results/{summary,tuned}.json docs/charts/certify_table.md docs/charts/certify{,_cost}.{svg,png}
exit "$result"
