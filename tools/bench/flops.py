#!/usr/bin/env python3
"""Floating-point operations a step, counted: how often callgrind saw each instruction, times what it computes.

    tools/bench/flops.py PROGRAM [--n 1000 ...] [--steps 10]

Two runs, as instructions.py; the program must be built for x86-64-v3. Counts additions, multiplications, divisions and
roots of doubles (a fused multiply-add is two), each lane of a vector; and the bytes of vector and scalar doubles moved
between registers and memory, which caches serve mostly. Code of shared libraries is left out.
"""
import argparse
import json
import pathlib
import re
import subprocess
import tempfile

from instructions import one_run

ARITHMETIC = re.compile(r"v?(f?n?m(?:add|sub)\d*|fm(?:addsub|subadd)\d*|add|sub|mul|div|sqrt|addsub|hadd)([ps]d)$")


def lanes(operands, packed):
    return 1 if not packed else 4 if "%ymm" in operands else 2


def weights(program):
    """{address: (flops, bytes)} of the instructions that have any."""
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", str(program)], capture_output=True, text=True,
                             check=True).stdout
    out = {}
    for address, name, operands in re.findall(r"^\s+([0-9a-f]+):\s+(\S+)\s*(.*)$", listing, re.MULTILINE):
        if not name.startswith("v") or not re.search(r"%[xy]mm", operands):
            continue
        flops = moved = 0
        found = ARITHMETIC.match(name.replace("vf", "f", 1) if name.startswith("vf") else name)
        if found:
            flops = lanes(operands, found[2] == "pd") * (2 if found[1].startswith("f") else 1)
        if "(" in operands:
            moved = 32 if "%ymm" in operands else 8 if name.endswith(("sd", "q")) else 16
        if flops or moved:
            out[int(address, 16)] = (flops, moved)
    return out


def executed(profile):
    """{address: times} of all instructions, from callgrind's file with --dump-instr=yes."""
    counts, skip = {}, False
    for line in profile.read_text().splitlines():
        if line.startswith("calls="):
            skip = True  # the next line is what the callee cost
        elif line.startswith("0x"):
            if not skip:
                address, _, times = line.split()[:3]
                counts[int(address, 16)] = counts.get(int(address, 16), 0) + int(times)
            skip = False
    return counts


def of_run(program, arguments, steps, table):
    with tempfile.TemporaryDirectory() as folder:
        profile = pathlib.Path(folder) / "callgrind.out"
        one_run(program, arguments, steps, profile,
                more=("--dump-instr=yes", "--compress-pos=no", "--compress-strings=no"))
        counts = executed(profile)
    # Addresses of a position-independent program are its file's plus where it was loaded.
    shift = load_address(counts, table)
    flops = moved = 0
    for address, times in counts.items():
        one = table.get(address - shift)
        if one:
            flops += times * one[0]
            moved += times * one[1]
    return flops, moved


def load_address(counts, table):
    """Where the program lay: the page that makes most executions fall on instructions of the table."""
    pages = (0, *range(0x100000, 0x120000, 0x1000), *range(0x400000, 0x410000, 0x1000))
    return max(pages, key=lambda page: sum(times for address, times in counts.items() if address - page in table))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--steps", type=int, default=10)
    options, arguments = parser.parse_known_args()
    table = weights(options.program)
    few, many = (of_run(options.program, arguments, k * options.steps, table) for k in (1, 2))
    print(json.dumps({"flops_per_step": (many[0] - few[0]) / options.steps,
                      "bytes_moved_per_step": (many[1] - few[1]) / options.steps}))


if __name__ == "__main__":
    main()
