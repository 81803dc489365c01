"""Beam problems that the beams of other packages are measured with, in their plane: data, answers, errors.

falling_rod: a rubber rod of 1 m falls from a pin, level at first; tests/data/beams/D05_falling_rod.csv.
spin_up:     a hub turns a beam of 10 m up to 6 rad/s in 15 s (J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 849);
             tools/bench/data/beam_spin_up.csv.
The plane is x, y here, gravity along -y. The error is the largest distance of the middle and of the tip from where they
should be, at the instants of `times`, m.
"""
import argparse
import csv
import json
import math
import pathlib

ROOT = pathlib.Path(__file__).resolve().parents[3]


class Problem:
    def __init__(self, name):
        self.name = name
        if name == "falling_rod":
            self.length, self.mass, self.inertia, self.gravity = 1.0, 0.3455751918948773, 8.63937979737193e-6, 9.81
            self.EA, self.GA, self.EI, self.GJ = 1570.796326794897, 471.238898038469, 0.039269908169872414, 0.02618
            self.end, self.period = 1.8, 0.05
            table, columns = ROOT / "tests/data/beams/D05_falling_rod.csv", ("x_mid", "z_mid", "x_tip", "z_tip")
        elif name == "spin_up":
            self.length, self.mass, self.inertia, self.gravity = 10.0, 1.2, 6e-4, 0.0
            self.EA, self.GA, self.EI, self.GJ = 2.8e7, 1e7, 1.4e4, 1.4e4
            self.end, self.period = 15.0, 0.5
            table, columns = ROOT / "tools/bench/data/beam_spin_up.csv", ("x_mid", "y_mid", "x_tip", "y_tip")
        else:
            raise SystemExit(f"no problem {name}; falling_rod and spin_up are")
        self.times = [self.period * (i + 1) for i in range(round(self.end / self.period))]
        with open(table, encoding="utf8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        by_time = {round(float(row["t"]), 6): [float(row[name]) for name in columns] for row in rows}
        self.exact = [by_time[round(t, 6)] for t in self.times]

    def hub_angle(self, t):
        """Of the hub's turn, rad, and its rate."""
        speed, T = 6.0, 15.0
        w = 2 * math.pi / T
        if t >= T:
            return speed * (t - T / 2), speed
        return speed / T * (t * t / 2 + (math.cos(w * t) - 1) / (w * w)), speed / T * (t - math.sin(w * t) / w)

    def error(self, found):
        """found: (x_mid, y_mid, x_tip, y_tip) at each of `times`."""
        worst = 0.0
        for a, b in zip(found, self.exact, strict=True):
            worst = max(worst, math.hypot(a[0] - b[0], a[1] - b[1]), math.hypot(a[2] - b[2], a[3] - b[3]))
        return worst


def arguments(methods):
    """Of every driver: --problem, --method, --n elements, --dt, --repeat."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--problem", default="falling_rod")
    parser.add_argument("--method", choices=methods, default=methods[0])
    parser.add_argument("--n", type=int, default=16)
    parser.add_argument("--dt", type=float, default=1e-3)
    parser.add_argument("--repeat", type=int, default=1)
    return parser.parse_args()


def report(engine, version, given, problem, runs):
    """runs: (CPU seconds, found); the cheapest counts."""
    seconds, found = min(runs, key=lambda run: run[0])
    error = problem.error(found)
    print(json.dumps({"engine": engine, "version": version, "problem": problem.name, "method": given.method,
                      "n": given.n, "dt": given.dt, "steps": round(problem.end / given.dt), "cpu_seconds": seconds,
                      "error": error if math.isfinite(error) else None}))
