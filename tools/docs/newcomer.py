"""docs/site/newcomer.md as a shell script on stdout: its files are written, its commands run in one shell, and what they
are said to print is looked for in what they print. newcomer.py [--built]: without the block that builds."""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/site/newcomer.md"
# Runs a step in this shell, so that cd and export last; keeps what it says; tells its time.
FUNCTIONS = r"""set -euo pipefail
begin() { step=$1; started=$SECONDS; echo "== $step"; exec 3>&1 4>&2; exec > >(tee "$said" >&3) 2>&1; }
finish() { exec 1>&3 2>&4 3>&- 4>&-; sleep 0.2; echo "== $step: $((SECONDS - started)) s"; }
expect() {
  grep -qF -- "$1" "$said" && return
  echo "error: the page says that '$step' prints '$1'" >&2
  echo "  at:   docs/site/newcomer.md:$2" >&2
  echo "  fix:  it printed what stands above" >&2
  exit 1
}
trap 'code=$?; [[ $code -eq 0 ]] || echo "error: the page fails at: ${step:-its start} (exit code $code)" >&2' EXIT
"""


def main():
    text = PAGE.read_text()
    built = "--built" in sys.argv
    script, count = [FUNCTIONS], 0
    blocks = list(re.finditer(r"^<!-- newcomer: (\w+)(?: (\S+))? -->\n```\w+\n(.*?)^```$", text, re.M | re.S))
    if len(blocks) != text.count("```") // 2:
        sys.exit("error: a block of docs/site/newcomer.md does not say what it is\n  fix:  <!-- newcomer: run -->")
    for block in blocks:
        kind, argument, code = block.groups()
        line = text[:block.start()].count("\n") + 3
        if kind == "file":
            script.append(f"cat > {argument} <<'END_OF_FILE'\n{code}END_OF_FILE\n")
        elif kind == "run" or (kind == "build" and not built):
            count += 1
            title = code.strip().splitlines()[-1].replace("'", "")
            script.append(f"begin '{count}. {title}'\n{code}finish\n")
        elif kind == "says":
            for number, words in enumerate(code.splitlines()):
                script.append(f"expect '{words.strip()}' {line + number}\n")
        elif kind != "build":
            sys.exit(f"error: nobody knows what '{kind}' is\n  at:   docs/site/newcomer.md:{line}")
    print("".join(script))


if __name__ == "__main__":
    main()
