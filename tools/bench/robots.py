#!/usr/bin/env python3
"""Robots' accelerations beside Pinocchio, MuJoCo and dynibo of the Python package index.

    tools/bench/robots.py --timed DIR [--core 0]     a table

DIR holds the program `robots` of tools/bench. Peers are those that the interpreter LITHE_PEERS_PYTHON (python3 without
it) has: pip install pin cmeel-eigen mujoco dynibo. Pinocchio and MuJoCo are called from C++ drivers, which are compiled
once (Pinocchio's takes two minutes) into DIR/peers; dynibo has no C interface and is called from Python, which costs it
some 0.5 us a call. "compiled": the robot as `lithe compile` writes it, by the compiler of the drivers, alone, and in
eight lanes with the instructions of this machine.
"""
import argparse
import json
import os
import pathlib
import re
import subprocess

from programs import Programs, Refused

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ROBOTS = ROOT / "tests/data/robots"
CASES = (("iiwa", 0), ("hyq", 0), ("hyq", 1), ("anymal_c", 0), ("anymal_c", 1))  # 1: floating base
FLAGS = ["g++", "-std=c++17", "-O3", "-DNDEBUG", "-march=x86-64-v3", "-w", f"-I{ROOT}"]

WHERE = """
import importlib, json, pathlib
found = {}
for name in ("pinocchio", "mujoco", "dynibo"):
    try: found[name] = str(pathlib.Path(importlib.import_module(name).__file__).parent)
    except Exception: pass
print(json.dumps(found))"""
SAVE = """
import sys, pinocchio as pin
file, floating, to = sys.argv[1:]
(pin.buildModelFromUrdf(file, pin.JointModelFreeFlyer()) if int(floating) else pin.buildModelFromUrdf(file)).saveToText(to)"""
DYNIBO = """
import sys, time, json, numpy, dynibo
robot = dynibo.Robot.from_urdf(sys.argv[1])
n = robot.joint_count() if callable(robot.joint_count) else robot.joint_count
q, v, t, least = numpy.full(n, 0.3), numpy.full(n, 0.5), numpy.zeros(n), 1e9
for repeat in range(5):
    start = time.process_time()
    for i in range(20000): robot.forward_dynamics(q, v, t)
    least = min(least, (time.process_time() - start) / 20000)
print(json.dumps({"engine": "dynibo", "us_per_acceleration": 1e6 * least}))"""


class Peers:
    """The engines of the interpreter, and their drivers."""

    def __init__(self, folder, say):
        self.python = os.environ.get("LITHE_PEERS_PYTHON", "python3")
        self.folder = pathlib.Path(folder) / "peers"
        self.folder.mkdir(exist_ok=True)
        self.say = say
        self.homes = json.loads(self.call(WHERE))

    def call(self, script, *arguments):
        done = subprocess.run([self.python, "-c", script, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            raise Refused(done.stderr.strip().splitlines()[-1])
        return done.stdout

    def driver(self, name, *flags):
        program = self.folder / f"robots_{name}"
        source = ROOT / f"tools/bench/peers/robots_{name}.cpp"
        if not program.exists() or program.stat().st_mtime < source.stat().st_mtime:
            self.say(f"compiling the driver of {name}")
            done = subprocess.run([*FLAGS, str(source), "-o", str(program), *flags], capture_output=True, text=True)
            if done.returncode:
                raise Refused(f"its driver does not compile: {done.stderr.strip().splitlines()[0]}")
        return program.name

    def pinocchio(self, programs, robot, floating):
        home = next(p for p in pathlib.Path(self.homes["pinocchio"]).parents if (p / "cmeel.prefix").exists())
        home /= "cmeel.prefix"
        if not (home / "include/eigen3").exists():
            raise Refused("its headers want cmeel-eigen")
        name = self.driver("pinocchio", "-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
                           "-isystem", f"{home}/include", "-isystem", f"{home}/include/eigen3", f"-L{home}/lib",
                           "-lboost_serialization", f"-Wl,-rpath,{home}/lib", f"-Wl,-rpath-link,{home}/lib")
        model = self.folder / f"{robot}_{floating}.txt"
        self.call(SAVE, ROBOTS / f"{robot}.urdf", floating, model)
        return programs.run(name, "--model", model)

    def mujoco(self, programs, robot, floating):
        if floating:
            raise Refused("URDF has no free base in MuJoCo")
        home = pathlib.Path(self.homes["mujoco"])
        library = next(home.glob("libmujoco.so*"))
        name = self.driver("mujoco", f"-I{home}/include", str(library), f"-Wl,-rpath,{home}")
        text = (ROBOTS / f"{robot}.urdf").read_text()
        text = re.sub(r"<(visual|collision)\b.*?</\1>", "", text, flags=re.S)  # meshes that are not there
        text = re.sub(r"(<robot[^>]*>)", r'\1<mujoco><compiler discardvisual="true" fusestatic="true" '
                                         r'balanceinertia="true"/></mujoco>', text, count=1)
        model = self.folder / f"{robot}.urdf"
        model.write_text(text)
        return programs.run(name, "--model", model)

    def dynibo(self, programs, robot, floating):
        if floating:
            raise Refused("timed on fixed bases alone")
        return json.loads(self.call(DYNIBO, ROBOTS / f"{robot}.urdf"))


def compiled(programs, robot, floating):
    """Names of two programs of the compiled scene: as the drivers are compiled, and for this machine."""
    name = f"compiled_{robot}_{floating}"
    folder = programs.folder / "peers" / name
    programs.run("robots", "--model", ROBOTS / f"{robot}.urdf", "--floating", floating, "--compile", folder)
    for suffix, flags in (("", FLAGS), ("_lanes", [*FLAGS, "-march=native"])):
        subprocess.run([*flags, "-ffp-contract=off", str(folder / "robot.cpp"), "-o", f"{folder}_program{suffix}"],
                       check=True)
    return f"{name}_program", f"{name}_program_lanes"


def measure(programs, rounds, say):
    """{robot: {engine: us an acceleration, or why not}}, by turns."""
    say("robots beside Pinocchio, MuJoCo, dynibo")
    peers = Peers(programs.folder, say)
    table = {}
    for robot, floating in CASES:
        row = table.setdefault(f"{robot}, {'floating' if floating else 'fixed'}", {})
        alone, lanes = compiled(programs, robot, floating)
        for turn in range(rounds):
            own = programs.run("robots", "--model", ROBOTS / f"{robot}.urdf", "--floating", floating)
            row["freedoms"] = own["freedoms"]
            row["Lithe"] = min(row.get("Lithe", 1e300), own["us_per_acceleration"])
            by_text = programs.run(alone, "throughput", 20000)["us_per_acceleration"]
            row["compiled"] = min(row.get("compiled", 1e300), by_text)
            row["lanes8"] = max(row.get("lanes8", 0.0), programs.run(lanes, "throughput", 20000)["times_by_8_lanes"])
            for name in peers.homes:
                if isinstance(row.get(name), str):
                    continue
                try:
                    found = getattr(peers, name)(programs, robot, floating)["us_per_acceleration"]
                    row[name] = min(row.get(name, 1e300), found)
                except Refused as why:
                    row[name] = str(why)
    return table


def over_best(table, own="Lithe"):
    """The time of Lithe, or of its compiled scene, over the fastest peer's, of the worst robot; None without peers."""
    ratios = []
    for row in table.values():
        found = [row[name] for name in ("pinocchio", "mujoco", "dynibo") if isinstance(row.get(name), float)]
        if found:
            ratios.append(row[own] / min(found))
    return max(ratios, default=None)


def lanes8(table):
    """How many times a core's throughput eight lanes give, of the worst robot."""
    return min((row["lanes8"] for row in table.values()), default=None)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--timed", type=pathlib.Path, required=True)
    parser.add_argument("--core", type=int, default=0)
    options = parser.parse_args()
    table = measure(Programs(options.timed.resolve(), options.core), 3, print)
    for robot, row in table.items():
        cells = [f"{name} {value:.3f} us" if isinstance(value, float) else f"{name}: {value}"
                 for name, value in row.items() if name not in ("freedoms", "lanes8")]
        print(f"{robot} ({row['freedoms']} freedoms): {', '.join(cells)}; eight lanes {row['lanes8']:.2f} times")
    for own in ("Lithe", "compiled"):
        worst = over_best(table, own)
        print(f"{own} over the fastest peer, worst robot: " + ("no peers" if worst is None else f"{worst:.2f}"))


if __name__ == "__main__":
    main()
