# shellcheck shell=bash
# Sourced by test.sh and demo.sh: numbered stages, one line each with its time.
#   stage_count=4; stage "build" cmake --build ...; stage_shown "tests" ctest ...
stage_number=0
stage_count=${stage_count:-1}

# Says what runs; its output is kept back, and shown only if it fails.
stage() {
  local what=$1 started=$SECONDS log
  shift
  stage_number=$((stage_number + 1))
  log=$(mktemp)
  echo "[$stage_number/$stage_count] $what ..."
  if "$@" > "$log" 2>&1; then
    echo "[$stage_number/$stage_count] $what: done in $((SECONDS - started)) s"
    rm -f "$log"
  else
    local result=$?
    cat "$log" >&2
    rm -f "$log"
    echo "[$stage_number/$stage_count] $what: FAILED after $((SECONDS - started)) s" >&2
    exit "$result"
  fi
}

# The same with its output visible.
stage_shown() {
  local what=$1 started=$SECONDS result=0
  shift
  stage_number=$((stage_number + 1))
  echo "[$stage_number/$stage_count] $what ..."
  "$@" || result=$?
  if [[ $result -ne 0 ]]; then
    echo "[$stage_number/$stage_count] $what: FAILED after $((SECONDS - started)) s" >&2
    exit "$result"
  fi
  echo "[$stage_number/$stage_count] $what: done in $((SECONDS - started)) s"
}

# Ninja keeps one moving line on a terminal; elsewhere its hundreds of lines matter only if the build fails.
build() {
  local what=$1
  shift
  if [[ -t 1 ]]; then stage_shown "$what" "$@"; else stage "$what" "$@"; fi
}
