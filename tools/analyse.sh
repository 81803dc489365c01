#!/usr/bin/env bash
# clang-tidy and cppcheck over sources, the library's, plug-ins' and tools' by default:
#   tools/analyse.sh [FILE...]      LITHE_JOBS=2: sources at once, all processors by default
# Exit code 1 where one of them finds something. Checks, and why some are off: .clang-tidy, tests/support/cppcheck.txt.
# Wants clang-tidy-16 and cppcheck. How each source is compiled by itself is taken from build/analyse, which is
# configured and not built. Findings: build/analyse/{tidy,cppcheck}.log.
set -euo pipefail
cd "$(dirname "$0")/.."
out=build/analyse
jobs=${LITHE_JOBS:-$(nproc)}
for tool in clang-tidy-16 cppcheck; do
  command -v "$tool" >/dev/null || { echo "there is no $tool: apt-get install clang-tidy-16 cppcheck" >&2; exit 2; }
done
if [ ! -e "$out/compile_commands.json" ]; then
  mkdir -p "$out"
  cmake -S . -B "$out" -G Ninja -D CMAKE_BUILD_TYPE=Release -D LITHE_UNITY=OFF -D CMAKE_DISABLE_PRECOMPILE_HEADERS=ON \
    >"$out/cmake.log" 2>&1 || { cat "$out/cmake.log" >&2; exit 2; }
fi
sources=("$@")
[ $# -gt 0 ] || mapfile -t sources < <(git ls-files 'engine/*.cpp' 'bodies/*.cpp' 'joints/*.cpp' 'integrators/*.cpp' \
  'models/*.cpp' 'plugins/*.cpp' 'tools/*.cpp' | grep -v '^tools/cmake/')

result=0
# A source that is in no target of this machine has no command.
printf '%s\n' "${sources[@]}" | while read -r source; do
  if grep -q "\"file\": \".*/$source\"" "$out/compile_commands.json"; then echo "$source"; fi
done | xargs -r -P "$jobs" -n 1 clang-tidy-16 -p "$out" --quiet >"$out/tidy.log" 2>"$out/tidy.err" || result=1
findings=$(grep -cE '(warning|error): ' "$out/tidy.log" || true)
echo "clang-tidy: ${#sources[@]} sources, $findings findings"
grep -E '(warning|error): ' "$out/tidy.log" | sort -u | head -40 || true

cppcheck --quiet -j "$jobs" --std=c++20 --language=c++ -I . --enable=warning,performance,portability --inline-suppr \
  --suppressions-list=tests/support/cppcheck.txt --error-exitcode=1 "${sources[@]}" 2>"$out/cppcheck.log" || result=1
echo "cppcheck: ${#sources[@]} sources, $(grep -cE ': (warning|error|performance|portability):' "$out/cppcheck.log" || true) findings"
head -60 "$out/cppcheck.log"
exit $result
