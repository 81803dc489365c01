#!/usr/bin/env bash
# Tests the run's page in headless Chromium: tests/page/run.sh [PAGE.html... live:PROGRAM]; a page of known motion is always among
# them, and the committed bundle must be what its sources give. Exits with 77 where Chromium or npm's packages are not
# to be had. Pictures for the documentation: tests/page/run.sh --pictures DIR PAGE.html...; how fast 10,000 bodies and a
# million triangles are drawn: tests/page/run.sh --size
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
viewer=$here/../../tools/viewer

skip() {
  echo "skipped: $1"
  exit 77
}
command -v node >/dev/null || skip "node is missing (apt-get install nodejs npm)"
command -v npm >/dev/null || skip "npm is missing (apt-get install npm)"
[[ -x ${CHROMIUM:-/usr/bin/chromium} ]] || skip "Chromium is missing (apt-get install chromium)"

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! "$viewer/build.sh" "$work/viewer.html" >"$work/build.log" 2>&1; then
  [[ -e $viewer/node_modules/esbuild ]] || skip "npm's packages cannot be had: $(tail -1 "$work/build.log")"
  cat "$work/build.log" >&2
  exit 1
fi

if [[ ${1:-} == --pictures ]]; then
  mkdir -p "$2"
  node "$here/pictures.mjs" "${@:2}"
  exit
fi

if ! cmp -s "$work/viewer.html" "$viewer/dist/viewer.html"; then
  echo "FAIL: tools/viewer/dist/viewer.html is not what tools/viewer/src gives." >&2
  echo "  fix:  run tools/viewer/build.sh and commit the result." >&2
  exit 1
fi
if [[ ${1:-} == --size ]]; then
  node "$here/size_fixture.mjs" "$viewer/dist/viewer.html" "$work"
  node "$here/size.mjs" "$work"/{bodies,triangles,deforming}.html
  exit
fi
node "$here/fixture.mjs" "$viewer/dist/viewer.html" "$work/known_motion.html"
node "$here/fixture.mjs" "$viewer/dist/viewer.html" "$work/spoilt.html" broken
node "$here/check.mjs" "$work/known_motion.html" "broken:$work/spoilt.html" "$@"
