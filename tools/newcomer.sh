#!/usr/bin/env bash
# A newcomer's hour: does what docs/site/newcomer.md says, and nothing else, in an empty folder that is also $HOME, and
# tells the time of each step.
#   LITHE_BUILD=build/release   takes an existing build instead of building one, and makes no precompiled header
#   LITHE_SCRATCH=folder        works there and leaves it; else a temporary folder
set -euo pipefail
cd "$(dirname "$0")/.."

scratch=${LITHE_SCRATCH:-$(mktemp -d)}
mkdir -p "$scratch"
scratch=$(realpath "$scratch")
[[ -n ${LITHE_SCRATCH:-} ]] || trap 'rm -rf "$scratch" || true' EXIT
home=$scratch/home
rm -rf "$home"
mkdir -p "$home/lithe"

# The checkout as the newcomer has it: links to the sources, and a build folder of its own.
for entry in *; do
  [[ $entry == build || $entry == results ]] || ln -s "$PWD/$entry" "$home/lithe/$entry"
done
built=()
if [[ -n ${LITHE_BUILD:-} ]]; then
  mkdir "$home/lithe/build"
  ln -s "$(realpath "$LITHE_BUILD")" "$home/lithe/build/release"
  built=(--built)
  export LITHE_PRECOMPILED=${LITHE_PRECOMPILED:-off}
fi

python3 -B tools/docs/newcomer.py "${built[@]}" > "$scratch/hour.sh"
started=$SECONDS
(cd "$home" && env HOME="$home" XDG_CACHE_HOME="$home/.cache" said="$scratch/said.txt" bash "$scratch/hour.sh")
echo "A newcomer's hour took $(((SECONDS - started) / 60)) min $(((SECONDS - started) % 60)) s."
