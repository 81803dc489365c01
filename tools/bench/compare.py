#!/usr/bin/env python3
"""Lithe beside the hand-written programs: runs both by turns, pinned to one core, and keeps the least time of each.

    tools/bench/compare.py --timed DIR --counted DIR --out summary.json

tools/bench.sh calls it; DIR holds the programs of tools/bench, built for timing and for valgrind.
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess
import time

from instructions import per_step

SIZES = (4, 16, 64, 256, 1000, 4000)  # links, of the exponent
ROUNDS = 5                            # by turns; the least counts


def run(folder, program, *arguments):
    pin = ["taskset", "-c", "0"] if shutil.which("taskset") else []
    done = subprocess.run([*pin, str(folder / program), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        raise SystemExit(f"error: {program} failed: {done.stderr.strip()}")
    return json.loads(done.stdout.splitlines()[-1])


def least(folder, jobs, rounds=ROUNDS):
    """The cheapest run of each job, all of them by turns; a job is a tuple: program, arguments."""
    best = {}
    for _ in range(rounds):
        for name, job in jobs.items():
            row = run(folder, *job, "--repeat", 1)
            if name not in best or row["us_per_step"] < best[name]["us_per_step"]:
                best[name] = row
    return best


def slope(points):
    """Least-squares exponent of time per step over size."""
    x = [math.log(size) for size, _ in points]
    y = [math.log(value) for _, value in points]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def distance(a, b):
    return max(abs(x - y) for x, y in zip(a["tip"], b["tip"]))


def measure(timed, counted):
    n = 1000
    chain = ("--n", n, "--dt", 1e-3, "--T", 1)
    pendulum = ("--dt", 1e-3, "--T", 20)
    rows = least(timed, {
        "limit_chain": ("limit_chain", *chain),
        "chain": ("chain", *chain, "--joint", "spherical"),
        "limit_flexible": ("limit_flexible", *pendulum),
        "pendulum": ("pendulum", *pendulum, "--mesh", "coarse"),
        "pendulum_fine": ("pendulum", *pendulum, "--mesh", "fine"),
    })
    rows |= least(timed, {"chain_revolute": ("chain", *chain, "--joint", "revolute")}, rounds=2)

    # The exponent: as many link-steps for each size, so that short chains are timed as well as long ones.
    lengths = {size: max(50, min(2000, 400000 // size)) for size in SIZES}
    by_size = {}
    for program in ("chain", "limit_chain"):
        found = least(timed, {size: (program, "--n", size, "--dt", 1e-3, "--T", steps * 1e-3)
                              for size, steps in lengths.items()}, rounds=3)
        by_size[program] = [(size, found[size]["us_per_step"]) for size in SIZES]

    # Both must have solved the same equations to the same point.
    tight = {program: run(timed, program, *arguments, "--T", 2, "--newton", 1e-13, "--repeat", 1)
             for program, arguments in (("limit_chain", ("--n", 16)), ("chain", ("--n", 16)),
                                        ("limit_flexible", ()), ("pendulum", ()))}

    count = {
        "limit_chain": per_step(counted / "limit_chain", ["--n", str(n)], 10),
        "chain": per_step(counted / "chain", ["--n", str(n)], 10),
        "limit_flexible": per_step(counted / "limit_flexible", [], 2000),
        "pendulum": per_step(counted / "pendulum", [], 2000),
        "pendulum_fine": per_step(counted / "pendulum", ["--mesh", "fine"], 2000),
    }
    per_iteration = {name: c["instructions_per_step"] / c["newton_iterations_per_step"] for name, c in count.items()}

    def time_ratio(a, b):
        return rows[a]["us_per_step"] / rows[b]["us_per_step"]

    return {
        "us_per_link_step": rows["chain"]["us_per_step"] / n,
        "us_per_link_step_revolute": rows["chain_revolute"]["us_per_step"] / n,
        "chain_over_limit": time_ratio("chain", "limit_chain"),
        "chain_exponent": slope(by_size["chain"]),
        "chain_exponent_range": [SIZES[0], SIZES[-1]],
        "chain_exponent_of_limit": slope(by_size["limit_chain"]),
        "us_per_flexible_step": rows["pendulum"]["us_per_step"],
        "flexible_over_limit": time_ratio("pendulum", "limit_flexible"),
        "mesh_independence": {
            "elements": [16, 4320],
            "time_ratio": time_ratio("pendulum_fine", "pendulum"),
            "instruction_ratio": count["pendulum_fine"]["instructions_per_step"] /
                                 count["pendulum"]["instructions_per_step"],
            "instruction_ratio_per_iteration": per_iteration["pendulum_fine"] / per_iteration["pendulum"],
        },
        "instructions": {
            "chain_per_link_step": count["chain"]["instructions_per_step"] / n,
            "limit_chain_per_link_step": count["limit_chain"]["instructions_per_step"] / n,
            "flexible_per_step": count["pendulum"]["instructions_per_step"],
            "flexible_fine_per_step": count["pendulum_fine"]["instructions_per_step"],
            "limit_flexible_per_step": count["limit_flexible"]["instructions_per_step"],
            "chain_over_limit": count["chain"]["instructions_per_step"] / count["limit_chain"]["instructions_per_step"],
            "flexible_over_limit": count["pendulum"]["instructions_per_step"] /
                                   count["limit_flexible"]["instructions_per_step"],
        },
        "same_answer_m": {"chain": distance(tight["chain"], tight["limit_chain"]),
                          "flexible": distance(tight["pendulum"], tight["limit_flexible"])},
        "us_per_step_by_links": {program: dict(points) for program, points in by_size.items()},
        "runs": rows,
    }


def print_table(s):
    runs = s["runs"]
    print(f"\n{'':34}{'us a step':>12}{'iterations':>12}{'factors':>10}")
    for name, row in runs.items():
        print(f"{name:34}{row['us_per_step']:12.4g}{row['newton_iterations_per_step']:12.3f}"
              f"{row['factorizations_per_step']:10.3f}")
    print(f"\nus a link-step{'':10}" + "".join(f"{f'N = {size}':>11}" for size in SIZES))
    for program, row in s["us_per_step_by_links"].items():
        print(f"{program:24}" + "".join(f"{value / size:11.3f}" for size, value in row.items()))
    mesh, count = s["mesh_independence"], s["instructions"]
    print(f"""
chain, 1000 links        {s['us_per_link_step']:.3f} us a link-step, {s['chain_over_limit']:.2f} times the hand-written program
                         {count['chain_per_link_step']:.0f} instructions a link-step, {count['chain_over_limit']:.2f} times
chain, cost ~ N^p        p = {s['chain_exponent']:.3f} over N = {SIZES[0]} ... {SIZES[-1]} (hand-written: {s['chain_exponent_of_limit']:.3f})
pendulum, nine modes     {s['us_per_flexible_step']:.3f} us a step, {s['flexible_over_limit']:.2f} times the hand-written program
                         {count['flexible_per_step']:.0f} instructions a step, {count['flexible_over_limit']:.2f} times
4,320 or 16 elements     {mesh['time_ratio']:.4f} in time, {mesh['instruction_ratio']:.4f} in instructions a step, \
{mesh['instruction_ratio_per_iteration']:.4f} an iteration
same answers within      {s['same_answer_m']['chain']:.1e} m (tip of 16 links), {s['same_answer_m']['flexible']:.1e} m (pendulum); 2 s, Newton to 1e-13""")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timed", type=pathlib.Path, required=True)
    parser.add_argument("--counted", type=pathlib.Path, required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    started = time.monotonic()
    summary = measure(options.timed, options.counted)
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(summary, indent=2) + "\n")
    print_table(summary)
    print(f"\n{options.out}, after {time.monotonic() - started:.0f} s")


if __name__ == "__main__":
    main()
