"""Refines a method's tolerance or step until its error meets the targets."""
import dataclasses
import math

from programs import Refused, by_turns, repeats_of, rounds_of


@dataclasses.dataclass(frozen=True)
class Variant:
    """One engine, one method, one problem."""
    engine: str
    method: str
    program: str
    arguments: tuple
    knob: str              # "tol", or "steps": of a fixed length
    start: float           # the first setting
    end: float = 1.0       # s
    order: int = 0         # 1: its cost at the targets is extrapolated from one run, unless that is short
    error: str = "joint_error"

    def command(self, setting, repeat=1):
        given = ("--tol", f"{setting:.4g}") if self.knob == "tol" else ("--dt", repr(self.end / round(setting)))
        return (*self.arguments, "--method", self.method, *given, "--repeat", repeat)

    def refined(self, level):
        """The setting `level` steps finer than the first: tolerances by half decades, steps by the root of two."""
        if self.knob == "tol":
            return self.start * 10 ** (-level / 2)
        return max(1, round(self.start * 2 ** (level / 2)))

    def one(self, programs, level, timeout):
        setting = self.refined(level)
        row = programs.run(self.program, *self.command(setting), timeout=timeout)
        if row["cpu_seconds"] < 0.05:  # warm
            row = programs.run(self.program, *self.command(setting, repeats_of(row["cpu_seconds"])), timeout=timeout)
        error = row.get(self.error)
        return {"level": level, "setting": setting, "seconds": row["cpu_seconds"], "steps": row["steps"],
                "error": error if error is not None and math.isfinite(error) else math.inf,
                "version": row.get("version", ""), "lim_error": row.get("lim_error")}


def refine(programs, variant, targets, budget, bisect=True):
    """(points, remark): runs from coarse to fine until the tightest target is met, it would cost more than `budget`
    seconds, or the error stops falling; one more run between the last miss and the first hit of each target. A run that
    breaks down counts as one of infinite error: a finer one may not."""
    points, breakdowns = [], []

    def add(level):
        try:
            point = variant.one(programs, level, timeout=max(20.0, 4 * budget))
        except Refused as refusal:
            breakdowns.append(str(refusal))
            point = {"level": level, "setting": variant.refined(level), "seconds": 0.0, "steps": 0,
                     "error": math.inf, "version": "", "lim_error": None}
        points.append(point)
        points.sort(key=lambda p: p["level"])
        return point

    def done(remark=""):
        kept = [p for p in points if math.isfinite(p["error"])]
        return kept, remark if kept or not breakdowns else breakdowns[-1]

    point = add(0)
    if variant.order == 1:
        needed = extrapolated([point], max(targets))
        if needed and point["error"] > max(targets) and needed < 0.5:  # cheap enough to be run, not extrapolated
            add(2 * math.log2(1.05 * point["error"] / max(targets)))
        return done()
    if any("known are" in words or "not done" in words for words in breakdowns):
        return done()
    while point["error"] <= max(targets) and point["level"] > -8:  # begun too fine
        point = add(point["level"] - 1)
    point, failures = points[-1], 0
    while point["error"] > min(targets):
        finest = min(p["error"] for p in points)
        if point["seconds"] > budget:
            return done(f"more than {budget:g} s a run")
        point = add(point["level"] + 1)
        failures = failures + 1 if point["error"] >= finest else 0
        if failures == 4 or point["level"] > 24:
            return done(f"the error stays above {finest:.1e}")
    if bisect:
        for target in targets:
            for finer, coarser in zip(points[1:], points):
                if finer["error"] <= target < coarser["error"]:
                    add((finer["level"] + coarser["level"]) / 2)
                    break
    return done()


def cheapest(points, target):
    """The cheapest run that meets the target, or None."""
    met = [p for p in points if p["error"] <= target]
    return min(met, key=lambda p: p["seconds"]) if met else None


def extrapolated(points, target):
    """Seconds of an order-1 method at the target: the error falls with the step. None where its one run is too far off
    to tell."""
    if not points or points[0]["error"] > 0.2:
        return None
    return points[0]["seconds"] * max(1.0, points[0]["error"] / target)


def cheapest_by_turns(programs, searched, rounds):
    """For each (variant, points, targets): {target: the cheapest run, or an extrapolated one}, all timed by turns."""
    found, jobs, often = [], {}, {}
    for index, (variant, points, targets) in enumerate(searched):
        at = {}
        for target in targets:
            point = cheapest(points, target)
            if point:
                at[str(target)] = {**point, "extrapolated": False}
                jobs[index, target] = (variant.program,
                                       variant.command(point["setting"], repeats_of(point["seconds"])))
                often[index, target] = rounds_of(point["seconds"], rounds)
            elif variant.order == 1 and extrapolated(points, target):
                at[str(target)] = {"seconds": extrapolated(points, target), "extrapolated": True}
        found.append(at)
    for (index, target), best in by_turns(programs, jobs, lambda row: row["cpu_seconds"], often).items():
        found[index][str(target)]["seconds"] = best["cpu_seconds"]
    return found


def fastest(rows, target, lithe, **of):
    """The row and its run that meets the target at least cost, of Lithe or of the peers, among rows with these values;
    None if none does."""
    met = [(row, row["at"][str(target)]) for row in rows
           if all(row[key] == value for key, value in of.items()) and (row["engine"] == "Lithe") == lithe and
           str(target) in row["at"] and not row["at"][str(target)]["extrapolated"]]
    return min(met, key=lambda pair: pair[1]["seconds"]) if met else None


def ratio(rows, target, **of):
    """How many times faster than the fastest peer, and which they are; None where a side has no run."""
    out = {"ratio": None}
    for side, lithe in (("lithe", True), ("peer", False)):
        found = fastest(rows, target, lithe, **of)
        out[side] = f"{found[0]['engine']} {found[0]['method']}" if found else None
        out[f"{side}_ms"] = 1e3 * found[1]["seconds"] if found else None
        out[f"{side}_setting"] = found[1]["setting"] if found else None
    if out["lithe"] and out["peer"]:
        out["ratio"] = out["peer_ms"] / out["lithe_ms"]
    return out
