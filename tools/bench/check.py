#!/usr/bin/env python3
"""Instruction counts against the committed baseline: the speed that a busy machine cannot blur.

    tools/bench/check.py --counted DIR            counts, and ends with 1 where a figure has changed by more than 3 %
    tools/bench/check.py --counted DIR --update   writes the baseline anew

DIR holds the programs built for valgrind (x86-64-v3). tools/bench.sh --check and --update-baseline call it.
"""
import argparse
import json
import pathlib
import sys

from instructions import per_evaluation, per_step
from machine import output

BASELINE = pathlib.Path(__file__).parent / "baseline.json"
TOLERANCE = 0.03
LINKS = 1000


def count(folder, beside_limits=False):
    """{figure: instructions}; with the hand-written programs too if asked."""
    def chain(program, *joint):
        return per_step(folder / program, ["--n", str(LINKS), *joint], 10)["instructions_per_step"] / LINKS

    def explicit(program, *joint):
        return per_evaluation(folder / program, ["--n", str(LINKS), *joint], 10) / LINKS

    def flexible(program, *variant):
        return per_step(folder / program, list(variant), 2000)["instructions_per_step"]

    def beam(program):
        return per_step(folder / program, ["--n", "100"], 100)["instructions_per_step"] / 100

    figures = {
        "implicit step a link, spherical": chain("chain", "--joint", "spherical"),
        "implicit step a link, revolute": chain("chain", "--joint", "revolute"),
        "acceleration a link, spherical": explicit("explicit_chain", "--joint", "spherical"),
        "acceleration a link, revolute": explicit("explicit_chain", "--joint", "revolute"),
        "flexible step, 9 modes": flexible("pendulum"),
        "flexible step, 30 modes": flexible("pendulum", "--modes", "30"),
        "beam step an element": beam("beam"),
    }
    if beside_limits:
        figures["implicit step a link, by hand"] = chain("limit_chain")
        figures["flexible step, 9 modes, by hand"] = flexible("limit_flexible")
        figures["beam step an element, by hand"] = beam("limit_beam")
        if (folder / "limit_explicit").exists():
            figures["acceleration a link, by hand"] = explicit("limit_explicit")
    return figures


def changes(figures, baseline):
    """[(figure, before, now, relative change)] of all; a figure that one side lacks has change None."""
    rows = []
    for name in sorted(figures.keys() | baseline.keys()):
        before, now = baseline.get(name), figures.get(name)
        rows.append((name, before, now, now / before - 1 if before and now else None))
    return rows


def show(rows):
    """Prints the comparison; returns the figures that changed by more than the tolerance."""
    changed = []
    print(f"{'instructions':36}{'baseline':>12}{'now':>12}{'change':>10}")
    for name, before, now, change in rows:
        off = change is None or abs(change) > TOLERANCE
        print(f"{name:36}{f'{before:.0f}' if before else '-':>12}{f'{now:.0f}' if now else '-':>12}"
              f"{f'{100 * change:+.1f} %' if change is not None else '-':>10}{'  CHANGED' if off else ''}")
        if off:
            changed.append(name)
    return changed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--counted", type=pathlib.Path, required=True)
    parser.add_argument("--baseline", type=pathlib.Path, default=BASELINE)
    parser.add_argument("--update", action="store_true")
    options = parser.parse_args()
    compiler = (output("g++", "--version").splitlines() or ["?"])[0]
    if options.update:
        figures = count(options.counted)
        content = {"compiler": compiler, "instructions": {name: round(value, 1) for name, value in figures.items()}}
        options.baseline.write_text(json.dumps(content, indent=2) + "\n")
        print(f"wrote {options.baseline}")
        return
    if not options.baseline.exists():
        raise SystemExit(f"error: there is no {options.baseline}.\n  fix:  tools/bench.sh --update-baseline writes it.")
    baseline = json.loads(options.baseline.read_text())
    changed = show(changes(count(options.counted), baseline["instructions"]))
    if changed:
        if baseline["compiler"] != compiler:
            print(f"note: the baseline is of another compiler, {baseline['compiler']}; here {compiler}", file=sys.stderr)
        print(f"error: changed by more than {100 * TOLERANCE:.0f} %: {', '.join(changed)}.\n  fix:  faster, or meant to "
              "be so: tools/bench.sh --update-baseline, and commit it; else find what costs more by\n  "
              "tools/bench/instructions.py PROGRAM --profile 25.", file=sys.stderr)
        raise SystemExit(1)
    print(f"all within {100 * TOLERANCE:.0f} %")


if __name__ == "__main__":
    main()
