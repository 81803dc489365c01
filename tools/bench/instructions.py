#!/usr/bin/env python3
"""Instructions a step, counted by callgrind: the figure that a busy machine cannot blur.

    tools/bench/instructions.py PROGRAM [--n 1000 ...] [--steps 100] [--profile 25]

Two runs, of --steps and of twice as many steps of 1 ms; the difference leaves out reading, drawing and assembling. Valgrind
knows no AVX-512: give it programs built for x86-64-v3 (tools/bench.sh keeps them in build/count). --profile N also lists
where the instructions of the longer run go, function by function.
"""
import argparse
import json
import pathlib
import re
import subprocess
import tempfile


def counted(command, profile=None, more=()):
    """(instructions, the program's own JSON line) of one call."""
    command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile or '/dev/null'}", *more,
               *map(str, command), "--repeat", "1"]
    done = subprocess.run(command, capture_output=True, text=True)
    found = re.search(r"Collected : (\d+)", done.stderr)
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not found or not lines:
        raise SystemExit(f"error: callgrind failed: {' '.join(command)}\n{done.stderr[-2000:]}")
    return int(found[1]), json.loads(lines[-1])


def one_run(program, arguments, steps, profile=None, more=()):
    """The same of so many steps of 1 ms."""
    return counted([program, *arguments, "--dt", "1e-3", "--T", f"{steps * 1e-3:.9g}"], profile, more)


def per_evaluation(program, arguments, evaluations):
    """Instructions for one evaluation of all accelerations."""
    few, many = (counted([program, *arguments, "--evaluations", k])[0] for k in (evaluations, 2 * evaluations))
    return (many - few) / evaluations


def per_step(program, arguments, steps):
    """Instructions a step, and Newton iterations a step in the steps counted."""
    few, first = one_run(program, arguments, steps)
    many, second = one_run(program, arguments, 2 * steps)
    iterations = [run["newton_iterations_per_step"] * run["steps"] for run in (first, second)]
    return {"instructions_per_step": (many - few) / (second["steps"] - first["steps"]),
            "newton_iterations_per_step": (iterations[1] - iterations[0]) / steps}


def print_profile(program, arguments, steps, lines):
    with tempfile.TemporaryDirectory() as folder:
        profile = pathlib.Path(folder) / "callgrind.out"
        one_run(program, arguments, 2 * steps, profile)
        listing = subprocess.run(["callgrind_annotate", str(profile)], capture_output=True, text=True, check=True).stdout
    rows = [line for line in listing.splitlines() if re.match(r"\s*[\d,]+ \(", line)]
    print("\n".join(rows[:lines + 1]))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--profile", type=int, default=0, metavar="N")
    options, arguments = parser.parse_known_args()
    print(json.dumps(per_step(options.program, arguments, options.steps)))
    if options.profile:
        print_profile(options.program, arguments, options.steps, options.profile)


if __name__ == "__main__":
    main()
