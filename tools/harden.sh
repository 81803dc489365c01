#!/usr/bin/env bash
# What is too long for every change, one stage after the other, with a table at its end (docs/hardening.md):
#   tools/harden.sh [STAGE...]
# Stages: the configurations of tools/everywhere.sh (v2 release v4 native o1 gcc asan tsan), and analysers, valgrind,
# fuzz, coverage, endurance, differential. By default: release asan tsan and those.
#   --fuzz=60        seconds a target of the fuzzer
#   --endurance=60   simulated seconds of each scene, and so many restarts
#   --scenes=200     random scenes of the differential fuzzer
#   LITHE_JOBS=2     jobs at once; all processors by default
# Goes on after a stage that fails. The table is build/harden/table.md, what a stage said build/harden/STAGE.log. Exit
# code 1 if one failed.
set -euo pipefail
cd "$(dirname "$0")/.."
configurations=(v2 release v4 native o1 gcc asan tsan)
others=(analysers valgrind fuzz coverage endurance differential)
fuzz=60 endurance=60 scenes=200 stages=()
for word in "$@"; do
  case $word in
    --fuzz=*) fuzz=${word#*=} ;;
    --endurance=*) endurance=${word#*=} ;;
    --scenes=*) scenes=${word#*=} ;;
    *)
      [[ " ${configurations[*]} ${others[*]} " == *" $word "* ]] || { sed -n '2,12s/^# \{0,1\}//p' "$0" >&2; exit 2; }
      stages+=("$word")
      ;;
  esac
done
[[ ${#stages[@]} -gt 0 ]] || stages=(release asan tsan "${others[@]}")
export LITHE_JOBS=${LITHE_JOBS:-$(nproc)}
out=build/harden
mkdir -p "$out/results"
tools/install_packages.sh
tools/install_packages.sh tools/harden_packages.txt

# built PRESET TARGET...
built() {
  cmake --preset "$1"
  cmake --build --preset "$1" --parallel "$LITHE_JOBS" --target "${@:2}"
}

analysers() { tools/analyse.sh; }
valgrind() {
  built v2 engine_test bodies_test joints_test integrators_test models_test gradient_test plugins_test
  tools/valgrind.sh
}
fuzz() { tools/fuzz.sh "$fuzz"; }
coverage() { tools/fuzz.sh coverage; }
endurance() {
  built release endurance
  local program=build/release/tools/endurance/endurance scene bad=0
  for scene in "--bodies 1000" "--flexible 20" "--contacts 1000"; do
    # shellcheck disable=SC2086
    "$program" $scene --duration "$endurance" --results "$out/results" || bad=1
  done
  "$program" --restarts "$endurance" --duration 1 --results "$out/results" || bad=1
  return $bad
}
differential() {
  built release differential
  build/release/tools/differential/differential --scenes "$scenes" --jobs "$LITHE_JOBS"
}

# What a stage said in the end, in a word.
note() {
  case $1 in
    analysers) grep -hE '^(clang-tidy|cppcheck): ' "$2" | paste -sd';' ;;
    valgrind) grep -hE '^[a-z]+: .* ran, ' "$2" | awk '{ n += $2; e += $5 } END { print n " tests, " e " errors" }' ;;
    fuzz) awk '/^== / { n++ } /number_of_executed/ { sum += $2 } END { print n " targets, " sum " inputs" }' "$2" ;;
    endurance) grep -hE '^(ok|GROWS)' "$2" | sed 's/: resident memory//' | paste -sd';' ;;
    *) grep -hv '^ *$' "$2" | tail -1 | cut -c1-120 | tr '|' ' ' ;;
  esac
}

table=$out/table.md
{ echo "| stage | result | minutes | what it says |"; echo "|---|---|---|---|"; } > "$table"
bad=0
for stage in "${stages[@]}"; do
  log=$out/$stage.log started=$SECONDS result=passed
  echo "$stage: see $log"
  if [[ " ${configurations[*]} " == *" $stage "* ]]; then
    tools/everywhere.sh "$stage" > "$log" 2>&1 || result=FAILED
  else
    # Beside this shell, since within a condition a failing command would not end the stage.
    "$stage" > "$log" 2>&1 &
    wait $! || result=FAILED
  fi
  [[ $result != FAILED ]] || bad=1
  echo "| $stage | $result | $(((SECONDS - started + 59) / 60)) | $(note "$stage" "$log") |" >> "$table"
done
cat "$table"
exit $bad
