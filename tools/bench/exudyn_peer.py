#!/usr/bin/env python3
"""Lithe beside Exudyn of the Python package index, at equal error: chains, four-bars, the flexible pendulum.

    tools/bench/exudyn_peer.py --timed DIR [--core 0]     a table

The interpreter LITHE_PEERS_PYTHON (python3 without it) has Exudyn and SciPy: pip install exudyn scipy. Errors are those
of chains.py and loops.py. The flexible pendulum has nine modes in both, of a free rod in Exudyn, of a rod held at the
hinge in Lithe, so that each run is compared with its own engine's finest: the error is that of time stepping.
"""
import argparse
import math
import pathlib

import chains
import loops
from programs import Programs, Refused, by_turns
from search import Variant, cheapest_by_turns, ratio, refine

TARGET = 1e-4  # m
FOUR_BAR_TARGET = 1e-3  # m: with finer steps Exudyn stops where the four-bars lie flat
SIZES = (16, 64, 256)
CHAIN_METHODS = {"spherical": (("space_alpha", 2), ("space_trapezoidal", 2)),
                 "revolute": (("plane_alpha", 2), ("plane_trapezoidal", 2), ("tree_rk4", 4), ("tree_dopri5", 0))}
DRIVER = "exudyn_driver.py"


def searched(programs, variants, rounds, quick, budget, target=TARGET, **of):
    found = [refine(programs, v, [target], budget, not quick) for v in variants]
    marks = cheapest_by_turns(programs, [(v, s[0], [target]) for v, s in zip(variants, found)], rounds)
    return [{**of, "engine": v.engine, "method": v.method, "points": points, "remark": remark, "at": at}
            for v, (points, remark), at in zip(variants, found, marks)]


def chain_rows(programs, joint, n, rounds, quick):
    common = ("--n", n, "--joint", joint, "--T", 1, "--reference", chains.DATA / f"chain_{n}.txt")
    variants = [Variant("Lithe", method, "explicit_chain", common, "tol", 1e-3) for method in ("automatic", "rk8")]
    for method, order in CHAIN_METHODS[joint]:
        if method.startswith("tree") and n > 64:
            continue  # a dense mass matrix
        variants.append(Variant("Exudyn", method, DRIVER, ("--problem", "chain", *common), "tol" if order == 0 else "steps",
                                1e-3 if order == 0 else 100, order=order))
    return searched(programs, variants, rounds, quick, 10, problem=f"chain of {n}, {joint}")


def four_bar_rows(programs, rounds, quick):
    end = loops.END["four_bar"]
    own = ("--problem", "four_bar", "--reference", loops.TABLE["four_bar"], "--n", 40)
    variants = [Variant("Lithe", method, "loops", own, "tol", 1e-3, end, error="error")
                for method in loops.LITHE["four_bar"]]
    variants.append(Variant("Exudyn", "plane_alpha", DRIVER, ("--problem", "four_bar", "--n", 40, "--T", end), "steps",
                            7000, end, order=2, error="error"))
    return searched(programs, variants, rounds, quick, 20, FOUR_BAR_TARGET, problem="four-bars, N = 40")


def pendulum_rows(programs, rounds):
    """Fixed steps of generalized-alpha in both."""
    rows = []
    for engine, command in (("Lithe", ("pendulum", "--T", 1, "--repeat", 1)),
                            ("Exudyn", (DRIVER, "--problem", "pendulum", "--n", 9, "--method", "modes_alpha"))):
        def run(steps, command=command):
            return programs.run(command[0], *command[1:], "--dt", repr(1 / steps))
        finest, points = run(32000)["tip"], []
        for level in range(12):
            steps = round(100 * 2 ** (level / 2))
            points.append({"setting": steps, "error": math.dist(run(steps)["tip"], finest)})
            if points[-1]["error"] <= TARGET:
                break
        job = {0: (command[0], (*command[1:], "--dt", repr(1 / steps)))}
        best = by_turns(programs, job, cpu_seconds, max(rounds, 3))[0]
        at = {str(TARGET): {"seconds": cpu_seconds(best), "setting": steps, "extrapolated": False}}
        rows.append({"problem": "flexible pendulum, nine modes", "engine": engine, "method": "alpha", "points": points,
                     "remark": "", "at": at if points[-1]["error"] <= TARGET else {}})
    return rows


def cpu_seconds(row):
    return row["cpu_seconds"] if "cpu_seconds" in row else 1e-6 * row["us_per_step"] * row["steps"]


def measure(programs, rounds, quick, say):
    """Rows of (problem, engine, method) with the cheapest run at the target; none without Exudyn."""
    if not programs.imports("exudyn"):
        return []
    rows = []
    try:
        for joint in chains.JOINTS:
            for n in SIZES:
                say(f"beside Exudyn: chain of {n}, {joint}")
                rows += chain_rows(programs, joint, n, rounds, quick)
        say("beside Exudyn: flexible pendulum, four-bars")
        rows += pendulum_rows(programs, rounds)
        rows += four_bar_rows(programs, rounds, quick)
    except Refused as why:
        say(f"Exudyn: {why}")
    return rows


def ratios(rows):
    """(the least, {problem: how many times faster than Exudyn's fastest}); None without Exudyn."""
    table = {problem: ratio(rows, FOUR_BAR_TARGET if "four" in problem else TARGET, problem=problem)
             for problem in dict.fromkeys(row["problem"] for row in rows)}
    return min((one["ratio"] for one in table.values() if one["ratio"]), default=None), table


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timed", type=pathlib.Path, required=True)
    parser.add_argument("--core", type=int, default=0)
    options = parser.parse_args()
    rows = measure(Programs(options.timed.resolve(), options.core), 3, False, print)
    least, table = ratios(rows)
    for problem, one in table.items():
        print(f"{problem}: {one}")
    for row in rows:
        print(row["problem"], row["engine"], row["method"], row["remark"],
              [f"{p['setting']:.4g}: {p['error']:.1e}" for p in row["points"]])
    print(f"least: {least}")


if __name__ == "__main__":
    main()
