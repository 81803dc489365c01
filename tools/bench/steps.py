"""Fixed implicit steps: chains, closed structures and the flexible pendulum, and the hand-written programs."""
import math
import os

from programs import by_turns

CHAIN_SIZES = (4, 16, 64, 256, 1000, 4000, 20000, 100000)  # links
BEAM_SIZES = (10, 30, 100, 300, 1000, 3000, 10000)  # elements
STRUCTURE_SIZES = {"ladder": (4, 40, 400, 4000, 10000), "grid": (4, 40, 400, 4000)}  # cells: 5, 9 rods each
PENDULUM = ("--dt", 1e-3, "--T", 20)


def slope(points):
    """Least-squares exponent of time over size."""
    x = [math.log(size) for size, _ in points]
    y = [math.log(value) for _, value in points]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def cost(row):
    return row["us_per_step"]


def scaling(programs, name, command, sizes, rods_a_cell, rounds):
    """[(size, row)]; about as much work for each size, so that short ones are timed as well as long ones."""
    jobs, often = {}, {}
    for size in sizes:
        steps = max(20, min(2000, 200000 // (size * rods_a_cell)))
        jobs[size] = (name, (*command, "--n", size, "--dt", 1e-3, "--T", steps * 1e-3, "--repeat", 2))
        often[size] = rounds if size * rods_a_cell <= 5000 else 1
    found = by_turns(programs, jobs, cost, often)
    return [(size, found[size]) for size in sizes]


def by_size(programs, quick, rounds, say):
    """Time a step by size, of every scene that is measured so: {scene: {sizes, us_per_step, ..., exponent}}."""
    most = 5000 if quick else 100000
    scenes = {
        "chain, spherical": ("chain", ("--joint", "spherical"), CHAIN_SIZES),
        "chain, revolute": ("chain", ("--joint", "revolute"), CHAIN_SIZES),
        "hand-written chain, spherical": ("limit_chain", (), CHAIN_SIZES),
        "ladder": ("structure", ("--shape", "ladder"), STRUCTURE_SIZES["ladder"]),
        "grid": ("structure", ("--shape", "grid", "--m", 4), STRUCTURE_SIZES["grid"]),
        "beam": ("beam", (), BEAM_SIZES),
        "hand-written beam": ("limit_beam", (), BEAM_SIZES),
        "cable": ("beam", ("--as", "cable"), BEAM_SIZES),
    }
    table = {}
    for scene, (program, command, sizes) in scenes.items():
        say(f"time a step by size: {scene}")
        rods_a_cell = {"ladder": 5, "grid": 9}.get(scene, 1)
        sizes = [size for size in sizes if size * rods_a_cell <= most]
        rows = scaling(programs, program, command, sizes, rods_a_cell, rounds)
        rods = [rows_of.get("rods", size) for size, rows_of in rows]
        times = [cost(row) for _, row in rows]
        table[scene] = {"rods": rods, "us_per_step": times, "exponent": slope(list(zip(rods, times))),
                        "newton_iterations_per_step": [row["newton_iterations_per_step"] for _, row in rows]}
    return table


def fixed_costs(programs, rounds, say):
    """The chain of 1,000 links and the pendulums, beside the hand-written programs, by turns."""
    say("chain of 1,000 links and pendulums beside the hand-written programs")
    chain = ("--n", 1000, "--dt", 1e-3, "--T", 1, "--repeat", 1)
    pendulum = (*PENDULUM, "--repeat", 1)
    beam = ("--n", 100, "--dt", 1e-3, "--T", 1, "--repeat", 1)
    return by_turns(programs, {
        "limit_chain": ("limit_chain", chain),
        "chain": ("chain", (*chain, "--joint", "spherical")),
        "chain_revolute": ("chain", (*chain, "--joint", "revolute")),
        "limit_flexible": ("limit_flexible", pendulum),
        "limit_flexible_30": ("limit_flexible_30", pendulum),
        "pendulum": ("pendulum", (*pendulum, "--mesh", "coarse")),
        "pendulum_fine": ("pendulum", (*pendulum, "--mesh", "fine")),
        "pendulum_30": ("pendulum", (*pendulum, "--modes", 30)),
        "limit_beam": ("limit_beam", beam),
        "beam": ("beam", beam),
        "beam_consistent": ("beam", (*beam, "--as", "consistent")),
        "cable": ("beam", (*beam, "--as", "cable")),
    }, cost, rounds)


def threads(programs, say):
    """One scene on two threads against one, beside two scenes at once, by the clock: {scene: row}; none on one processor."""
    if len(os.sched_getaffinity(0)) < 2:
        return {}
    say("one scene on two threads")
    return {scene: programs.run("threads", "--scene", scene, "--repeat", 9, pinned=False) for scene in ("chain", "flexible")}


def bytes_per_link(programs, say):
    """Memory held a link: peak resident size of 20,000 and of 60,000 links, after three steps."""
    say("memory of chains")

    def peak(program, n):
        return programs.run(program, "--n", n, "--dt", 1e-3, "--T", 3e-3, "--repeat", 1)["peak_bytes"]

    return {name: (peak(name, 60000) - peak(name, 20000)) / 40000 for name in ("chain", "limit_chain")}


def same_answers(programs):
    """Distances of the end points, m: both must have solved the same equations, Newton to 1e-13, 2 s."""
    def end(program, *arguments):
        return programs.run(program, *arguments, "--T", 2, "--newton", 1e-13, "--repeat", 1)["tip"]

    def distance(a, b):
        return max(abs(x - y) for x, y in zip(a, b))

    return {"chain": distance(end("chain", "--n", 16), end("limit_chain", "--n", 16)),
            "flexible": distance(end("pendulum"), end("limit_flexible")),
            "flexible_30": distance(end("pendulum", "--modes", 30), end("limit_flexible_30")),
            "beam": distance(end("beam", "--n", 20), end("limit_beam", "--n", 20))}


def accelerations(programs, sizes, rounds, say):
    """Microseconds a link for one evaluation of all accelerations: {'spherical': {n: us}, ..., 'hand-written': ...}"""
    say("accelerations of the chain")
    jobs = {}
    for n in sizes:
        count = ("--n", n, "--evaluations", max(20, 100000 // n), "--repeat", 3)
        jobs["spherical", n] = ("explicit_chain", (*count, "--joint", "spherical"))
        jobs["revolute", n] = ("explicit_chain", (*count, "--joint", "revolute"))
        if programs.find("limit_explicit"):
            jobs["hand-written", n] = ("limit_explicit", count)
    found = by_turns(programs, jobs, lambda row: row["us_per_link_acceleration"], rounds)
    table = {}
    for (what, n), row in found.items():
        table.setdefault(what, {})[str(n)] = row["us_per_link_acceleration"]
    return table
