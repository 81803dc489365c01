"""Closed loops and the stiff chain: each engine's cheapest run at the problem's marks."""
import pathlib

from programs import Refused
from search import Variant, cheapest_by_turns, refine

HERE = pathlib.Path(__file__).parent
TABLES = HERE.parent.parent / "tests" / "data" / "benchmarks"
TABLE = {
    "andrews": TABLES / "R03_andrews_squeezer" / "reference.csv",
    "four_bar": TABLES / "R02_n_four_bar" / "reference_N40.csv",
    "bricard": TABLES / "R04_bricard" / "reference.csv",
    "governor": TABLES / "R05_flyball_governor" / "reference.csv",
    "stiff_chain": HERE / "data" / "stiff_chain_16.txt",
}
# Errors to meet; of the chain at the worst joint, of the others as loops.cpp says.
TARGETS = {
    "andrews": (1e-4, 1e-6, 1e-10),
    "four_bar": (1e-4,),
    "bricard": (1e-4,),
    "governor": (1e-4, 1e-6),
    "stiff_chain": (1e-4,),
}
LITHE = {
    "andrews": ("automatic", "rk5", "rk8", "radau"),
    "four_bar": ("automatic", "rk5", "rk8"),
    "bricard": ("automatic", "rk5", "rk8"),
    "governor": ("automatic", "bdf", "radau"),
    "stiff_chain": ("automatic", "bdf", "radau", "alpha"),
}
# (engine, driver, method, knob, first setting, order); what a driver cannot do it says itself. The governor is Lithe's
# alone.
CONTROLLED = tuple(("Simbody", "simbody", method, "tol", 1e-3, 0) for method in ("merson", "feldberg", "cpodes"))
LOOP_PEERS = (*CONTROLLED, ("MuJoCo", "mujoco", "rk4", "steps", 1000, 4), ("DART", "dart", "euler", "steps", 20000, 1),
              ("Bullet", "bullet", "euler", "steps", 20000, 1), ("ODE", "ode", "quick", "steps", 20000, 1),
              ("Orocos KDL", "kdl", "rk4", "steps", 1000, 4))
STIFF_PEERS = (*CONTROLLED, ("MuJoCo", "mujoco", "rk4", "steps", 4000, 4),
               ("MuJoCo", "mujoco", "implicit", "steps", 16000, 1), ("DART", "dart", "euler", "steps", 16000, 1),
               ("Bullet", "bullet", "rk4", "steps", 4000, 4), ("Bullet", "bullet", "euler", "steps", 16000, 1),
               ("ODE", "ode", "world", "steps", 16000, 1), ("Orocos KDL", "kdl", "rk4", "steps", 4000, 4))
# Why a driver has no such problem.
NOT_MODELLED = {
    "DART": "closes loops by impulses, of order 1: only the four-bars are modelled",
    "Bullet": "closes loops by impulses, of order 1: only the four-bars are modelled",
    "ODE": "solves all joints by impulses, of order 1: only the four-bars are modelled",
    "Orocos KDL": "serial chains of hinges alone, without loops and bushings",
}
END = {"andrews": 0.03, "four_bar": 20, "bricard": 10, "governor": 10, "stiff_chain": 1}


QUICK = {"Lithe": ("automatic", "rk8", "bdf"), "Simbody": ("feldberg",), "MuJoCo": ("rk4",)}  # among the fastest


def variants(problem, quick):
    stiff = problem == "stiff_chain"
    common = ("--reference", TABLE[problem], *(("--n", 16) if stiff else ("--n", 40) if problem == "four_bar" else ()))
    own = ("stiff_chain", common) if stiff else ("loops", ("--problem", problem, *common))
    error = "joint_error" if stiff else "error"
    out = [Variant("Lithe", method, *own, "tol", 1e-3, END[problem], error=error) for method in LITHE[problem]]
    peers = () if problem == "governor" else STIFF_PEERS if stiff else LOOP_PEERS
    for engine, driver, method, knob, start, order in peers:
        if problem == "four_bar" and method in ("merson", "cpodes"):
            continue  # seconds a run, and no better than feldberg
        out.append(Variant(engine, method, f"{driver}_driver",
                           ("--problem", problem, *common, "--T", END[problem]), knob, start, END[problem],
                           order=order, error=error))
    return [v for v in out if not quick or v.method in QUICK.get(v.engine, ())]


def measure(programs, problems, rounds, quick, say):
    """Rows of (problem, engine, method) with the cheapest run at each target."""
    rows = []
    for problem in problems:
        say(problem.replace("_", " "))
        chosen = [v for v in variants(problem, quick) if programs.find(v.program)]
        searched = []
        for variant in chosen:
            peer = variant.engine != "Lithe"
            targets = [t for t in TARGETS[problem] if not (peer and t < 1e-6)]
            searched.append((*refine(programs, variant, targets, 5, not quick), targets))
        marks = cheapest_by_turns(programs, [(v, s[0], s[2]) for v, s in zip(chosen, searched)], rounds)
        rows += [{"problem": problem, "engine": v.engine, "method": v.method, "points": s[0], "at": at,
                  "remark": NOT_MODELLED.get(v.engine, s[1]) if "no problem" in s[1] else s[1]}
                 for v, s, at in zip(chosen, searched, marks)]
    return rows


def four_bar_published(rows, mark=1e-3):
    """The cheapest run of N = 40 within the published tolerance, a LIM error of high precision."""
    met = [{"ms": 1e3 * p["seconds"], "method": row["method"], "tol": p["setting"], "lim_error": p["lim_error"]}
           for row in rows if row["problem"] == "four_bar" and row["engine"] == "Lithe" for p in row["points"]
           if p["lim_error"] is not None and p["lim_error"] <= mark]
    return min(met, key=lambda one: one["ms"]) if met else None


def raw_andrews(programs):
    """General solvers on the hand-written equations: [{method, tol, cpu_seconds, digits}]."""
    rows = []
    for method in ("ida_ggl", "ida_index1", "dop853"):
        try:
            rows += programs.lines("andrews_raw", "--method", method, "--repeat", 3)
        except Refused:
            return rows
    return rows


def raw_at(rows, digits):
    """{method: milliseconds of its cheapest run with so many digits}"""
    out = {}
    for row in rows:
        if row["digits"] is not None and row["digits"] >= digits:
            out[row["method"]] = min(out.get(row["method"], 1e300), 1e3 * row["cpu_seconds"])
    return out
