#!/usr/bin/env bash
# Writes docs/accuracy.md: the true error of the default integrator over the tolerance asked, on R01 to R17, from the
# tests in tests/reference. Takes some minutes.
set -euo pipefail
cd "$(dirname "$0")/.."

test=${1:-build/release/tests/reference_test}
[[ -x $test ]] || { echo "error: $test is not there; fix: build the tests first (tools/test.sh)" >&2; exit 1; }
lines=$(mktemp)
trap 'rm -f "$lines"' EXIT
# Marks are the tests' business; here expectations at loose tolerances do not count.
LITHE_ACCURACY=$lines "$test" --gtest_filter='*Default*' > /dev/null 2>&1 || true

{
  cat <<'TEXT'
# Error against tolerance

`tools/accuracy.sh` runs the default integrator (`Automatic`) on every rigid benchmark with a trajectory and compares with
the references of tests/data/benchmarks. Each field is the largest true error of the watched quantity, in the size of that
quantity, **divided by the tolerance asked**: below 10 is within what was asked for, and such fields are plain; others are
bold.

TEXT
  awk -F, '
    { key = $1 "," $2; if (!(key in seen)) { order[++count] = key; seen[key] = 1 } value[key, $3] = $4 / $3 }
    END {
      n = split("1e-03 1e-04 1e-05 1e-06 1e-07 1e-08 1e-09 1e-10", tolerances, " ")
      line = "| benchmark | watched |"; rule = "|---|---|"
      for (i = 1; i <= n; ++i) { line = line " " tolerances[i] " |"; rule = rule "---|" }
      print line; print rule
      for (k = 1; k <= count; ++k) {
        split(order[k], name, ",")
        line = "| " name[1] " | " name[2] " |"
        for (i = 1; i <= n; ++i) {
          if (!((order[k], tolerances[i]) in value)) { line = line " - |"; continue }
          x = value[order[k], tolerances[i]]
          text = sprintf(x < 9.5 ? "%.2g" : "%.0f", x)
          line = line (x > 10 ? " **" text "** |" : " " text " |")
        }
        print line
      }
    }' "$lines"
  cat tools/accuracy_notes.md
} > docs/accuracy.md
echo "docs/accuracy.md"
