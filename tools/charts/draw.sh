#!/usr/bin/env bash
# draw.sh LITHE PROGRAMS [STUDY...]: writes docs/charts/STUDY.svg, .png, .csv and .txt from the repository's root, with the
# command `lithe` and the programs of this folder, built in PROGRAMS. All studies if none is named. tools/charts.sh
# builds them first.
set -euo pipefail
lithe=$1
programs=$2
shift 2
studies=("$@")
[[ ${#studies[@]} -gt 0 ]] ||
  studies=(heavy_top andrews_squeezer chain_16 flyball_governor flexible_pendulum flexible_slider_crank beam_spin_up
    flexible_pendulum_models flexible_models slender_models)

pinned=()
command -v taskset > /dev/null && pinned=(taskset -c 0)
for study in "${studies[@]}"; do
  echo "== $study"
  if [[ $study == *_models ]]; then
    "${pinned[@]}" "$programs/$study" docs/charts
    continue
  fi
  options=(--methods "automatic,Runge-Kutta,Adams,Radau,Lie-group,IDA,index 2" --limit 5
    --tolerances 1e-2,1e-3,1e-4,1e-5,1e-6,1e-7,1e-8,1e-9)
  case $study in
    # The error of the other engines is that of the worst joint at the end.
    chain_16) options+=(--samples 1 --peers tools/charts/chain_16_peers.csv) ;;
  esac
  "${pinned[@]}" "$lithe" chart "examples/studies/$study.cpp" --out docs/charts "${options[@]}"
done
