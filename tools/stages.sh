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

# A build with the share done: Ninja's one moving line on a terminal, elsewhere a line every ten per cent.
build() {
  local what=$1
  shift
  export NINJA_STATUS="[%p, %f of %t] "
  if [[ -t 1 ]]; then stage_shown "$what" "$@"; else stage_shown "$what" show_share "$@"; fi
}
show_share() {
  local log line share next=0 result=0
  log=$(mktemp)
  "$@" 2>&1 | tee "$log" | while read -r line; do
    [[ $line =~ ^\[\ *([0-9]+)% ]] || continue
    share=${BASH_REMATCH[1]}
    if ((share >= next)); then
      echo "  $share %"
      next=$((share / 10 * 10 + 10))
    fi
  done || result=$?
  [[ $result -eq 0 ]] || cat "$log" >&2
  rm -f "$log"
  return "$result"
}
