"""docs/benchmarks.md: the tables of what was measured."""
import pathlib

import chains
import loops
from machine import sentence

NOTES = pathlib.Path(__file__).parent / "notes.md"
TITLES = {"andrews": "Andrews' squeezer, 30 ms (relative error of the worst angle)",
          "four_bar": "four-bar windows, N = 40, 20 s (m, first top joint)",
          "bricard": "Bricard's loop, 10 s (m, P3)",
          "governor": "flyball governor, 10 s (m, slider)",
          "stiff_chain": "stiff chain, N = 16, 1 s (m, worst joint)"}


def figure(value):
    """Three digits, no more."""
    if value is None:
        return "-"
    if value >= 999.5:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def mark(target):
    """1e-4"""
    return f"{target:.0e}".replace("e-0", "e-")


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows]) + "\n"


def milliseconds(run):
    """A run at a target: '~' where it is extrapolated."""
    if run is None:
        return "-"
    return ("~" if run["extrapolated"] else "") + figure(1e3 * run["seconds"])


def times(value):
    return f"{value:.2f}" if value is not None else "-"


def headline_rows(found):
    four_bar, governor = found["four_bar_published"], found["governor_1e6"]
    six, ten = found["andrews_6_digits"], found["andrews_10_digits"]
    stiff, loop_ratios = found["stiff_chain_ratio"]["ratio"], found["loop_ratios"]

    def ms(run):
        return f"{figure(run['ms'])} ms ({run['method']}, {run['tol']:.1e})" if run else "-"

    return [
        ("implicit step of 1,000 links, spherical: µs a link-step", figure(found["us_per_link_step"]), "0.6"),
        ("the same over the hand-written program", times(found["chain_over_limit"]), "1.5"),
        ("hinges over the hand-written program with ball joints", times(found["hinge_over_limit"]), "2.5"),
        ("memory held, bytes a link", f"{found['bytes_per_link']:,.0f}", "2,500"),
        ("cost ~ N^p, chains: spherical, revolute", f"{found['chain_exponent']:.3f}, "
         f"{found['chain_exponent_revolute']:.3f}", "1.05"),
        ("cost ~ N^p, ladders, grids", f"{found['ladder_exponent']:.3f}, {found['grid_exponent']:.3f}", "1.08"),
        ("flexible pendulum, nine modes: µs a step", figure(found["us_per_flexible_step"]), "4.4"),
        ("the same over the hand-written program", times(found["flexible_over_limit"]), "1.2"),
        ("30 modes over the hand-written program", times(found["flexible30_over_limit"]), "1.2"),
        ("30 modes over nine", times(found["flexible_30_over_9"]), "4"),
        ("accelerations, 1,000 links, spherical: µs a link", figure(found["us_per_link_acceleration"]), "0.26"),
        ("the same over the hand-written program", times(found["acceleration_over_limit"]), "1.3"),
        ("robots, forward dynamics over the best of Pinocchio, MuJoCo, dynibo: the worst, compiled",
         f"{times(found['robots_over_best'])}, {times(found['robots_compiled_over_best'])}", "1.0, 0.6"),
        ("eight lanes of compiled robots: times a core's throughput, least", times(found["lanes8"]), "4"),
        ("two threads, times faster by the clock: chain of 5,000 links, 200 flexible bodies",
         f"{times(found['threads2_chain'])}, {times(found['threads2_flexible'])}", "1.7"),
        ("what the machine gives there: two such scenes at once",
         f"{times(found['threads2_chain_by_machine'])}, {times(found['threads2_flexible_by_machine'])}", "-"),
        ("times faster than the fastest peer at 1e-4, N >= 64, least", times(found["ratio_fastest_peer_1e4"]), "3"),
        ("the same at 1e-6", times(found["ratio_fastest_peer_1e6"]), "3"),
        ("times faster at N = 16, 1e-4, least", times(found["ratio_n16_1e4"]), "2"),
        ("the same at 1e-6", times(found["ratio_n16_1e6"]), "2"),
        ("stiff chain: times faster than the fastest peer, 1e-4", times(stiff), "20"),
        ("loops: the same; Andrews, four-bars, Bricard",
         ", ".join(times(loop_ratios[name]["ratio"]) for name in ("andrews", "four_bar", "bricard")), "20"),
        ("times faster than Exudyn at 1e-4, least of chains, four-bars, flexible pendulum", times(found["ratio_exudyn"]), "20"),
        ("Andrews' squeezer, 6 digits", ms(six), "1 ms"),
        ("Andrews' squeezer, 10 digits", ms(ten), "3 ms"),
        ("four-bars N = 40, 20 s, LIM error 1e-3", ms(four_bar), "200 ms"),
        ("governor, 10 s, 1e-6 m", ms(governor), "20 ms"),
    ]


def headline(found):
    return "\n" + "\n".join(f"{what:62}{value:>34}   mark {mark}" for what, value, mark in headline_rows(found)) + "\n"


def chain_section(measured, found):
    text = ""
    for joint in chains.JOINTS:
        rows = [row for row in measured["chain_rows"] if row["joint"] == joint]
        header, body = ["CPU ms"], []
        for n in measured["sizes"]:
            header += [f"{n}: {mark(target)}" for target in chains.TARGETS]
        for engine, method in dict.fromkeys((row["engine"], row["method"]) for row in rows):
            line = [f"{'**' if engine == 'Lithe' else ''}{engine} {method}{'**' if engine == 'Lithe' else ''}"]
            for n in measured["sizes"]:
                row = next((r for r in rows if (r["engine"], r["method"], r["n"]) == (engine, method, n)), None)
                line += [milliseconds(row["at"].get(str(t)) if row else None) for t in chains.TARGETS]
            body.append(line)
        text += f"\n### {joint.capitalize()} joints\n\n{table(header, body)}"
        ratio_rows = []
        for target, name in zip(chains.TARGETS, ("1e4", "1e6")):
            for n in measured["sizes"]:
                one = found[f"ratios_{name}"].get(f"{joint} {n}")
                if one and one["ratio"]:
                    ratio_rows.append([str(n), mark(target), one["lithe"], figure(one["lithe_ms"]), one["peer"],
                                       figure(one["peer_ms"]), f"{one['ratio']:.2f}"])
        if ratio_rows:
            text += "\n" + table(["N", "error, m", "Lithe's cheapest", "ms", "fastest peer", "ms", "times faster"],
                                 ratio_rows)
    left_out = {}
    for row in measured["chain_rows"]:
        if row["remark"]:
            place = left_out.setdefault((row["engine"], row["method"], row["remark"]), {})
            place.setdefault(row["joint"], []).append(row["n"])
    if left_out:
        text += "\nNot there:\n"
    for (engine, method, why), places in left_out.items():
        where = "; ".join(f"{joint}, N = {', '.join(map(str, sizes))}" for joint, sizes in places.items())
        text += f"- {engine} {method} ({where}): {why}.\n"
    return text


def loop_section(measured):
    text = ""
    for problem, title in TITLES.items():
        rows = [row for row in measured["loop_rows"] if row["problem"] == problem]
        targets = loops.TARGETS[problem]
        body, cannot = [], []
        for row in rows:
            name = f"{row['engine']} {row['method']}"
            if row["at"]:
                body.append([f"**{name}**" if row["engine"] == "Lithe" else name,
                             *(milliseconds(row["at"].get(str(t))) for t in targets)])
            else:
                error = f"its error is {figure(row['points'][0]['error'])} at its step" if row["points"] else ""
                cannot.append(f"{name} ({row['remark'].rstrip('.') or error})")
        text += f"\n### {title[0].upper() + title[1:]}\n\n{table(['CPU ms', *(mark(t) for t in targets)], body)}"
        if cannot:
            text += f"\nCannot, or not within the budget of a run: {'; '.join(cannot)}.\n"
    raw = measured["raw_andrews"]
    if raw:
        six, ten = loops.raw_at(raw, 6), loops.raw_at(raw, 10)
        body = [[method, figure(six.get(method)), figure(ten.get(method))]
                for method in dict.fromkeys(row["method"] for row in raw)]
        text += ("\nGeneral solvers on Andrews' equations written by hand (seven angles, six loops; no engine):\n\n" +
                 table(["CPU ms", "6 digits", "10 digits"], body))
    return text


def steps_section(measured):
    by_size = measured["by_size"]
    body = []
    for scene, row in by_size.items():
        cells = "; ".join(f"{rods:,}: {us / rods:.3f}" for rods, us in zip(row["rods"], row["us_per_step"]))
        body.append([scene, cells, f"{row['exponent']:.3f}"])
    text = table(["scene", "rods: µs a rod and step", "p in N^p"], body)
    fixed = measured["fixed"]
    names = {"chain": "chain, 1,000 links, spherical", "chain_revolute": "chain, 1,000 links, revolute",
             "limit_chain": "the spherical chain by hand", "pendulum": "flexible pendulum, nine modes of 16 elements",
             "pendulum_fine": "nine modes of 4,320 elements", "pendulum_30": "30 modes of 16 elements",
             "limit_flexible": "the pendulum with nine modes by hand",
             "limit_flexible_30": "the pendulum with 30 modes by hand", "beam": "beam of 100 elements",
             "beam_consistent": "the same, consistent mass", "limit_beam": "the beam by hand",
             "cable": "cable of 100 elements"}
    text += "\n" + table(["scene", "µs a step", "Newton iterations", "factorizations"],
                         [[names[key], figure(fixed[key]["us_per_step"]),
                           f"{fixed[key]['newton_iterations_per_step']:.2f}",
                           f"{fixed[key]['factorizations_per_step']:.2f}"] for key in names])
    same = measured["same_answers"]
    text += (f"\nBoth sides solve the same equations: after 2 s, Newton to 1e-13, the tips of 16 links differ by "
             f"{same['chain']:.1e} m, of the pendulum by {same['flexible']:.1e} m (30 modes: "
             f"{same['flexible_30']:.1e} m), of the beam by {same['beam']:.1e} m.\n")
    if measured["instructions"]:
        text += "\nInstructions (callgrind, build for x86-64-v3):\n\n" + table(
            ["what", "instructions"], [[name, f"{value:,.0f}"] for name, value in measured["instructions"].items()])
    return text


def accelerations_section(measured):
    sizes = [str(n) for n in measured["sizes"]]
    return table(["µs a link", *(f"N = {n}" for n in sizes)],
                 [[what, *(f"{row[n]:.3f}" if n in row else "-" for n in sizes)]
                  for what, row in measured["accelerations"].items()])


def versions(measured):
    seen = {}
    for row in measured["chain_rows"] + measured["loop_rows"]:
        for point in row["points"]:
            if point["version"]:
                seen[row["engine"]] = point["version"]
    return ", ".join(f"{engine} {version}" for engine, version in seen.items())


def page(measured, found, pictures):
    quick = measured["quick"]
    peers = versions(measured)
    text = f"""# Benchmarks

Written by `tools/bench.sh{' --quick' if quick else ''}`, which measures all of this anew; figures for machines: `results/bench/summary.json`.
{sentence(measured['machine'])} Programs run by turns, pinned to one core; CPU time of the process
without set-up, the least of {'two' if quick else 'five'} (fewer where a run takes seconds).
{'Peers: ' + peers + ', as Debian packages them.' if peers else 'No peer is installed here: Lithe alone (`tools/bench.sh --install-peers`).'}

{table(['what', 'measured', 'mark'], headline_rows(found))}
## The chain at equal error

N slender unit rods (1 m, 1 kg), the first hinged to the ground, released level; 1 s of fall. The error is that of the worst
joint at the end, in metres, against references of another formulation (`tools/bench/data`). Each method is refined
(tolerances by half decades, steps by √2, then once halfway) until it meets 1e-4 and 1e-6 m; the cheapest run that does
counts. Lithe and Simbody control their error and are told a tolerance; the others' fixed steps are the longest that do. `~`: a method of order 1, extrapolated
from one run of 1 ms; `-`: not reached, or not run (below). Lithe's chains of hinges run simplified (`Simplification`,
docs/economy.md): bodies that move in one plane have three coordinates.
"""
    text += chain_section(measured, found)
    for name in pictures:
        if name.startswith("chain"):
            text += f"\n![{name.replace('_', ' ')}](benchmarks/{name}.png)\n<!-- made by: tools/bench.sh -->\n"
    text += "\n## All accelerations of the chain, once\n\n" + accelerations_section(measured)
    text += """
## Closed loops and stiff systems at equal error

All bodies of Andrews' squeezer and of the four-bars move in one plane: Lithe runs them simplified (`Simplification`).
""" + loop_section(measured)
    text += """
## Implicit steps of fixed length

Generalized-alpha, index 3, spectral radius 0.9, 1 ms; Newton until a correction is below 1e-9 (pendulum 1e-10). Ladders: two
rails of hinged rods, tied by a rung every two rods; grids: nets five rods wide with ball joints (`tools/bench/lattice.h`).

""" + steps_section(measured)
    if "time_by_size" in pictures:
        text += "\n![time of a step by size](benchmarks/time_by_size.png)\n<!-- made by: tools/bench.sh -->\n"
    if NOTES.exists():
        text += "\n" + NOTES.read_text()
    return text
