"""Charts by gnuplot: error against cost of all engines on one pair of axes, and time a step by size."""
import shutil
import subprocess

SIZE = "size 1200,750 font 'DejaVu Sans,12'"
# An engine keeps its colour over all charts; its methods differ by their points.
COLOURS = {"Lithe": "#D55E00", "Simbody": "#0072B2", "Bullet": "#009E73", "MuJoCo": "#CC79A7", "DART": "#8C6D1F",
           "ODE": "#666666", "Orocos KDL": "#56B4E9"}
POINTS = (7, 5, 9, 13, 11, 4)


def gnuplot(path, title, x, y, curves, more=""):
    """Writes path.svg and path.png; a curve: (name, colour, point, width, [(x, y)])."""
    blocks, plots = "", []
    for i, (name, colour, point, width, values) in enumerate(curves):
        blocks += f"$curve{i} << EOD\n" + "".join(f"{a:.6g} {b:.6g}\n" for a, b in values) + "EOD\n"
        plots.append(f"$curve{i} using 1:2 with linespoints lc rgb '{colour}' pt {point} ps 1.1 lw {width} "
                     f"title '{name}' noenhanced")
    script = "set encoding utf8\n" + blocks
    for terminal, suffix in ((f"svg {SIZE} fontscale 1.333 background '#FFFFFF'", "svg"),
                             (f"pngcairo {SIZE} background '#FFFFFF'", "png")):
        script += f"""set terminal {terminal}
set output '{path}.{suffix}'
set logscale xy
set format x '10^{{%T}}'
set format y '10^{{%T}}'
set border 3 lw 1.2 lc rgb '#444444'
set tics nomirror out textcolor rgb '#222222'
set grid back lt 1 lw 0.8 lc rgb '#DDDDDD'
set key outside right center vertical Left reverse samplen 2.5 spacing 1.2
set rmargin 28
set title "{title}" noenhanced font ',16'
set xlabel "{x}" noenhanced font ',14'
set ylabel "{y}" noenhanced font ',14'
{more}
plot {', '.join(plots)}
unset output
"""
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def curves_of(rows):
    """Lithe last, so that it lies on top, and thicker."""
    seen, curves = {}, []
    for row in sorted(rows, key=lambda row: row["engine"] == "Lithe"):
        values = [(1e3 * p["seconds"], p["error"]) for p in row["points"] if 0 < p["error"] < 1]
        if not values:
            continue
        index = seen[row["engine"]] = seen.get(row["engine"], -1) + 1
        curves.append((f"{row['engine']} {row['method']}", COLOURS.get(row["engine"], "#000000"),
                       POINTS[index % len(POINTS)], 3 if row["engine"] == "Lithe" else 1.5, values))
    return curves


def draw(chain_rows, by_size, folder):
    """All charts; returns their names, or none where gnuplot is missing."""
    if shutil.which("gnuplot") is None:
        return []
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for joint in ("spherical", "revolute"):
        for n in (16, 1000):
            curves = curves_of([row for row in chain_rows if row["joint"] == joint and row["n"] == n])
            if not curves:
                continue
            names.append(f"chain_{joint}_{n}")
            gnuplot(folder / names[-1], f"Chain of {n} links, {joint} joints, 1 s: error against cost",
                    "CPU time, ms", "error of the worst joint, m", curves)
    if by_size:
        colours = ("#D55E00", "#0072B2", "#666666", "#009E73", "#CC79A7")
        curves = [(scene.replace("hand-written", "by hand:"), colour, point, 2, list(zip(row["rods"], row["us_per_step"])))
                  for (scene, row), colour, point in zip(by_size.items(), colours, POINTS)]
        names.append("time_by_size")
        gnuplot(folder / names[-1], "Time of an implicit step (generalized-alpha, 1 ms)", "rods", "microseconds a step",
                curves, "set yrange [0.5:]")
    return names
