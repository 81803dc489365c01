"""The falling chain: all engines at equal error of the worst joint."""
import pathlib

from search import Variant, cheapest_by_turns, ratio, refine

DATA = pathlib.Path(__file__).parent / "data"
TARGETS = (1e-4, 1e-6)  # m, of the worst joint at 1 s
JOINTS = ("spherical", "revolute")

LITHE = ("automatic", "rk5", "rk8")
# (engine, method, knob, order, {joint: most links}): beyond that a run takes more than some ten seconds.
PEERS = (
    ("Simbody", "simbody", "merson", "tol", 0, {}),
    ("Simbody", "simbody", "feldberg", "tol", 0, {}),
    ("Simbody", "simbody", "cpodes", "tol", 0, {"spherical": 64, "revolute": 64}),
    ("Bullet", "bullet", "rk4", "steps", 4, {}),
    ("Bullet", "bullet", "euler", "steps", 1, {}),
    ("DART", "dart", "euler", "steps", 1, {"spherical": 64, "revolute": 256}),
    ("MuJoCo", "mujoco", "rk4", "steps", 4, {"spherical": 64, "revolute": 256}),
    ("MuJoCo", "mujoco", "euler", "steps", 1, {"spherical": 64, "revolute": 256}),
    ("MuJoCo", "mujoco", "implicit", "steps", 1, {"spherical": 16, "revolute": 64}),
    ("ODE", "ode", "quick", "steps", 1, {"spherical": 64, "revolute": 64}),
    ("ODE", "ode", "world", "steps", 1, {"spherical": 64, "revolute": 64}),
    ("Orocos KDL", "kdl", "rk4", "steps", 4, {"spherical": 0, "revolute": 64}),
)
QUICK = {"Lithe": ("automatic", "rk8"), "Bullet": ("rk4",), "MuJoCo": ("rk4",)}  # among the fastest
CAUSES = {
    "DART": "its set-up grows with the cube of the links",
    "MuJoCo": "its mass matrix is full: the cube of the links a step",
    "ODE": "the direct step costs the cube of the links, the other does not converge on long chains",
    "Orocos KDL": "no spherical joints; a dense mass matrix, the cube of the links a step",
    "Simbody": "CPODES factors a dense Jacobian",
}


def variants(joint, n, quick):
    """Lithe's and the peers' for this chain; and what is left out: [(engine, method)]."""
    problem = ("--problem", "chain", "--n", n, "--joint", joint, "--T", 1, "--reference", DATA / f"chain_{n}.txt")
    own = QUICK["Lithe"] if quick else LITHE
    chosen = [Variant("Lithe", method, "explicit_chain", problem[2:], "tol", 1e-3) for method in own]
    left_out = []
    for engine, driver, method, knob, order, most in PEERS:
        if quick and (method not in QUICK.get(engine, ()) or n > most.get(joint, n)):
            continue
        if n > most.get(joint, n):
            left_out.append((engine, method))
            continue
        start = 1e-3 if knob == "tol" else 1000 if order == 1 else 2 * n**0.5 + 24
        chosen.append(Variant(engine, method, f"{driver}_driver", problem, knob, start, order=order))
    return chosen, left_out


def measure(programs, sizes, rounds, quick, say):
    """Rows of (joint, n, engine, method): the points of the search, and the cheapest run at each target."""
    rows = []
    for joint in JOINTS:
        for n in sizes:
            say(f"chain, {joint} joints, N = {n}")
            chosen, left_out = variants(joint, n, quick)
            chosen = [v for v in chosen if programs.find(v.program)]
            searched = [refine(programs, v, TARGETS, budget=8, bisect=not quick) for v in chosen]
            marks = cheapest_by_turns(programs, [(v, s[0], TARGETS) for v, s in zip(chosen, searched)], rounds)
            rows += [{"joint": joint, "n": n, "engine": v.engine, "method": v.method, "points": points,
                      "remark": remark, "at": at} for v, (points, remark), at in zip(chosen, searched, marks)]
            rows += [{"joint": joint, "n": n, "engine": engine, "method": method, "points": [], "at": {},
                      "remark": CAUSES[engine]} for engine, method in left_out]
    return rows


def ratios(rows, sizes, target):
    """{'spherical 64': how many times faster than the fastest peer, ...}"""
    return {f"{joint} {n}": ratio(rows, target, joint=joint, n=n) for joint in JOINTS for n in sizes}


def least(found, sizes):
    """The least ratio over these sizes and both joints; None without peers."""
    values = [one["ratio"] for key, one in found.items() if int(key.split()[1]) in sizes and one["ratio"] is not None]
    return min(values) if values else None
