#!/usr/bin/env python3
"""Lithe, the hand-written programs and the packaged peers on the same problems, by turns, pinned to one core.

    tools/bench/benchmarks.py --timed DIR [--counted DIR] [--quick] [--core 0]
    tools/bench/benchmarks.py --report     writes docs/benchmarks.md again from results/bench/

DIR holds the programs of tools/bench (and of tools/bench/peers in its subfolder), built for timing and for valgrind.
Writes results/bench/summary.json and runs.json (every run), docs/benchmarks.md and the charts in docs/benchmarks/.
tools/bench.sh calls it.
"""
import argparse
import json
import pathlib
import time

import chains
import charts
import check
import exudyn_peer
import loops
import machine
import report
import robots
import steps
from programs import Programs
from summary import summary

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
SIZES = (16, 64, 256, 1000)  # links
PROBLEMS = ("andrews", "four_bar", "bricard", "governor", "stiff_chain")


def measure(programs, counted, quick):
    started = time.monotonic()

    def say(what):
        print(f"[{time.monotonic() - started:5.0f} s] {what}", flush=True)

    rounds = 2 if quick else 5
    measured = {
        "machine": machine.describe(programs.folder),
        "quick": quick,
        "sizes": SIZES,
        "fixed": steps.fixed_costs(programs, rounds, say),
        "threads": steps.threads(programs, say),
        "bytes_per_link": steps.bytes_per_link(programs, say),
        "same_answers": steps.same_answers(programs),
        "by_size": steps.by_size(programs, quick, 2 if quick else 3, say),
        "accelerations": steps.accelerations(programs, SIZES, rounds, say),
        "chain_rows": chains.measure(programs, SIZES, rounds, quick, say),
        "loop_rows": loops.measure(programs, PROBLEMS, rounds, quick, say),
        "raw_andrews": loops.raw_andrews(programs),
        "robots": robots.measure(programs, rounds, say),
        "exudyn": exudyn_peer.measure(programs, rounds, quick, say),
        "instructions": {},
    }
    if counted:
        say("instructions")
        measured["instructions"] = check.count(counted, beside_limits=True)
    say("done")
    return measured


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timed", type=pathlib.Path)
    parser.add_argument("--counted", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "results" / "bench")
    parser.add_argument("--docs", type=pathlib.Path, default=ROOT / "docs")
    options = parser.parse_args()
    if not options.report and not options.timed:
        parser.error("--timed DIR, or --report")

    runs_path, summary_path = options.out / "runs.json", options.out / "summary.json"
    if options.report:
        measured = json.loads(runs_path.read_text())
    else:
        # Through JSON, so that a report made now and one made later read the same.
        measured = json.loads(json.dumps(measure(Programs(options.timed, options.core), options.counted,
                                                 options.quick)))
        options.out.mkdir(parents=True, exist_ok=True)
        runs_path.write_text(json.dumps(measured, indent=1) + "\n")
    found = summary(measured)
    summary_path.write_text(json.dumps(found, indent=2) + "\n")
    pictures = charts.draw(measured["chain_rows"], measured["by_size"], options.docs / "benchmarks")
    (options.docs / "benchmarks.md").write_text(report.page(measured, found, pictures))
    print(report.headline(found))
    print(f"{summary_path}, {options.docs / 'benchmarks.md'}")


if __name__ == "__main__":
    main()
