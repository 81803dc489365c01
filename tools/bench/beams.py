#!/usr/bin/env python3
"""Lithe's beam beside those of Exudyn and PyElastica: error against CPU time of the motions of beam_motion.cpp.

    tools/bench/beams.py BUILD/tools/bench --python VENV/bin/python [--problem spin_up] [--budget 20] [--report]

VENV has the peers: python3 -m venv VENV && VENV/bin/pip install exudyn pyelastica; neither is needed for anything else.
Each variant is run with more and more elements, for each number with finer and finer steps or tolerances until these no
longer matter; then the cheapest run within each target is timed again, all by turns. Writes results/bench/beams.json,
docs/benchmarks/beams.md and its charts; --report: these from the file.
"""
import argparse
import itertools
import json
import os
import pathlib
import subprocess

import charts
from programs import Programs, Refused

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGETS = {"falling_rod": (1e-2, 3e-3, 1e-3), "spin_up": (1e-2, 3e-3, 1e-3)}  # m
TITLES = {"falling_rod": "A rubber rod of 1 m falls from a pin, 1.8 s",
          "spin_up": "A beam of 10 m on a hub that turns up to 6 rad/s, 15 s"}
ELEMENTS = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
# Fixed steps, s, from which each method is refined by halves.
STEPS = {"alpha": 1e-2, "trapezoidal": 1e-2, "verlet": 1e-3}
CLAMPED = {"spin_up": ("plane", "plane3")}  # those of Exudyn's beams whose clamp can be turned


def variants(problem):
    """(engine, method, command of elements and refinement)."""
    reference = ROOT / ("tests/data/beams/D05_falling_rod.csv" if problem == "falling_rod" else
                        "tools/bench/data/beam_spin_up.csv")
    for method, mass in itertools.product(("automatic", "radau", "rk8", "alpha"), ("lumped", "consistent")):
        if problem == "spin_up" and (method == "rk8" or mass == "consistent"):
            continue  # stretch waves hold explicit steps below 50 us; consistent mass costs five times as much

        def command(n, level, method=method, mass=mass):
            return ("beam_motion", "--problem", problem, "--method", method, "--mass", mass, "--n", n,
                    "--tol", f"{1e-2 * 10 ** (-level / 2):.3g}", "--reference", reference)
        yield "Lithe", f"{method}, {mass} mass", command
    exudyn = [f"{element}_alpha" for element in CLAMPED.get(problem, ("plane", "plane3", "ancf", "space"))]
    exudyn += ["plane_trapezoidal", "plane3_trapezoidal"]
    peers = [("Exudyn", "exudyn_beam.py", method) for method in exudyn]
    peers += [("PyElastica", "pyelastica_beam.py", method) for method in ("verlet",)]
    for engine, script, method in peers:
        period = 0.05 if problem == "falling_rod" else 0.5

        def command(n, level, script=script, method=method):
            step = STEPS[method.split("_")[-1]] / 2 ** level
            return (script, "--problem", problem, "--method", method, "--n", n,
                    "--dt", repr(period / max(1, round(period / step))))
        yield engine, method.replace("_", ", "), command


class Runner:
    def __init__(self, programs, python, budget):
        self.programs, self.python, self.budget = programs, python, budget

    def run(self, command, repeat=1, timeout=None):
        command = [*map(str, command), "--repeat", str(repeat)]
        timeout = timeout or 6 * self.budget + 20
        if not command[0].endswith(".py"):
            return self.programs.run(*command, timeout=timeout)
        call = [*self.programs.pin, self.python, str(ROOT / "tools/bench/peers" / command[0]), *command[1:]]
        try:
            done = subprocess.run(call, capture_output=True, text=True, timeout=timeout, check=False,
                                  env={**os.environ, "NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"})
        except subprocess.TimeoutExpired:
            raise Refused(f"not done within {timeout:.0f} s") from None
        lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
        if done.returncode or not lines:
            words = (done.stderr + done.stdout).strip().splitlines()
            raise Refused(words[-1] if words else "no words")
        return json.loads(lines[-1])

    def points(self, command, tightest, say):
        """Runs of one variant; none dearer than the budget, none beyond what the tightest target needs."""
        found, last, begin = [], "", 0
        for n in ELEMENTS:
            best, misses, first = None, 0, None
            for level in range(begin, 14):
                try:
                    row = self.run(command(n, level))
                except Refused as refusal:
                    last = str(refusal)
                    misses += 1
                    if misses > 6 or "not done" in last:
                        break
                    continue
                error = row["error"] if row["error"] is not None and row["error"] < 1e3 else None
                first = first or row["cpu_seconds"]
                if error is None:
                    misses += 1
                    if misses > 8:
                        break
                    continue
                found.append({"n": n, "level": level, "error": error, "seconds": row["cpu_seconds"]})
                settled = best is not None and error > 0.9 * best
                best = error if best is None else min(best, error)
                if settled or row["cpu_seconds"] > self.budget:
                    break
            say(f"    n = {n}: " + (f"{best:.2e} m" if best is not None else last or "unstable"))
            if best is not None and best < tightest / 2:
                break
            if best is not None:  # what was too coarse for fewer elements is so for more
                begin = max(0, min(p["level"] for p in found if p["n"] == n and p["error"] < 2 * best) - 2)
            if first and first > self.budget:
                break
        return found, last


def measure(runner, problem, say):
    rows = []
    for engine, method, command in variants(problem):
        say(f"  {engine} {method}")
        points, words = runner.points(command, min(TARGETS[problem]), say)
        rows.append({"engine": engine, "method": method, "points": points, "words": words, "at": {},
                     "command": command})
    jobs = []
    for row in rows:
        for target in TARGETS[problem]:
            met = [p for p in row["points"] if p["error"] <= target]
            if met:
                jobs.append((row, target, min(met, key=lambda p: p["seconds"])))
    for turn in range(3):
        for row, target, point in jobs:
            if turn and point["seconds"] > 2:
                continue
            again = runner.run(row["command"](point["n"], point["level"]), repeat=3 if point["seconds"] < 0.3 else 1)
            old = row["at"].get(str(target))
            seconds = min(again["cpu_seconds"], old["seconds"] if old else 1e300)
            row["at"][str(target)] = {"seconds": seconds, "error": again["error"], "n": point["n"],
                                      "setting": again.get("tol", again.get("dt"))}
    for row in rows:
        del row["command"]
    return rows


def table(problem, rows):
    targets = [str(t) for t in TARGETS[problem]]
    text = f"## {TITLES[problem]}\n\n"
    text += "| CPU ms (elements; step or tolerance) | " + " | ".join(f"{float(t):g} m" for t in targets) + " |\n"
    text += "|---" * (len(targets) + 1) + "|\n"
    for row in rows:
        name = f"**Lithe** {row['method']}" if row["engine"] == "Lithe" else f"{row['engine']} {row['method']}"
        cells = []
        for t in targets:
            at = row["at"].get(t)
            cells.append(f"{1e3 * at['seconds']:.3g} ({at['n']}; {at['setting']:.2g})" if at else "-")
        text += f"| {name} | " + " | ".join(cells) + " |\n"
    text += "\n| error | Lithe's cheapest, ms | Exudyn's, ms | times faster | PyElastica's, ms | times faster |\n" + \
            "|---" * 6 + "|\n"
    for t in targets:
        def cheapest(engine):
            met = [(r["at"][t]["seconds"], r["method"]) for r in rows if r["engine"] == engine and t in r["at"]]
            return min(met) if met else None
        ours, cells = cheapest("Lithe"), []
        for engine in ("Exudyn", "PyElastica"):
            theirs = cheapest(engine)
            cells += [f"{1e3 * theirs[0]:.3g} ({theirs[1]})" if theirs else "-",
                      f"{theirs[0] / ours[0]:.2f}" if theirs and ours else "-"]
        mine = f"{1e3 * ours[0]:.3g} ({ours[1]})" if ours else "-"
        text += f"| {float(t):g} m | {mine} | " + " | ".join(cells) + " |\n"
    missing = [f"- {r['engine']} {r['method']}: {r['words']}" for r in rows if not r["points"] and r["words"]]
    return text + ("\nDid not run:\n" + "\n".join(missing) + "\n" if missing else "")


def front(points):
    """The runs that no other beats in both error and cost."""
    best, out = 1e300, []
    for p in sorted(points, key=lambda p: p["seconds"]):
        if p["error"] < best:
            best = p["error"]
            out.append(p)
    return out


def report(results, folder):
    charts.COLOURS.update({"Exudyn": "#0072B2", "PyElastica": "#009E73"})
    text = ""
    for problem, rows in results["problems"].items():
        text += table(problem, rows)
        drawn = [{**row, "points": front(row["points"])} for row in rows]
        charts.gnuplot(folder / f"beams_{problem}", TITLES[problem], "CPU time (ms)",
                       "largest error of middle and tip (m)", charts.curves_of(drawn))
        text += f"\n![{problem}](beams_{problem}.png)\n<!-- made by: tools/bench/beams.py -->\n\n"
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="build/release/tools/bench")
    parser.add_argument("--python", default="python3")
    parser.add_argument("--problem", action="append")
    parser.add_argument("--budget", type=float, default=8)
    parser.add_argument("--report", action="store_true")
    given = parser.parse_args()
    path = ROOT / "results/bench/beams.json"
    results = json.loads(path.read_text()) if path.exists() else {"problems": {}}
    if not given.report:
        runner = Runner(Programs(given.folder), given.python, given.budget)
        for problem in given.problem or TARGETS:
            print(problem, flush=True)
            results["problems"][problem] = measure(runner, problem, lambda words: print(words, flush=True))
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(results, indent=1))
    (ROOT / "docs/benchmarks/beams.md").write_text(HEAD + report(results, ROOT / "docs/benchmarks"), encoding="utf8")


HEAD = """# Beams beside those of other packages

Written by `tools/bench/beams.py`: the geometrically exact beam of Lithe (spatial), Exudyn 1.13.6 (planar geometrically
exact beams of two and three nodes, the planar ANCF cable, the spatial geometrically exact beam) and PyElastica 1.0.0
(spatial Cosserat rods), all three from the Python package index. The error is the largest distance of the beam's middle
and tip from a converged solution (tests/data/beams/D05_falling_rod.csv, tools/bench/data/beam_spin_up.csv), the cost is CPU
time of the run without set-up and compilation, on one core, all in one run of the script on a machine that other programs
used at the same time. For each error the cheapest setting counts: elements and steps or tolerances are refined until they
meet it. `-`: not met within the budget.

"""

main()
