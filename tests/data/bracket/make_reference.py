#!/usr/bin/env python3
"""Mesh of the bracket (gmsh 4.8.4) and its eigenvalues by CalculiX (ccx 2.20): writes bracket.msh and frequencies.csv.

usage:  python3 make_reference.py [mesh] [frequencies]
"""
import math, os, subprocess, sys, tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
YOUNG, POISSON, DENSITY = 7e10, 0.33, 2700.0
COUNTS = {"free": 16, "clamped": 10}  # clamped: all nodes of the surface "back"


def path(name):
    return os.path.join(HERE, name)


def sections(file):
    blocks, name = {}, None
    for line in open(file):
        line = line.strip()
        if line.startswith("$End"):
            name = None
        elif line.startswith("$"):
            name = line[1:]
            blocks[name] = []
        elif name:
            blocks[name].append(line.split())
    return blocks


def mesh():
    """nine digits a coordinate; without the nodes that no element uses (centres of arcs)"""
    with tempfile.TemporaryDirectory() as folder:
        raw = os.path.join(folder, "bracket.msh")
        subprocess.run(["gmsh", path("bracket.geo"), "-3", "-nt", "1", "-o", raw], check=True, stdout=subprocess.DEVNULL)
        b = sections(raw)
    used = {int(n) for e in b["Elements"][1:] for n in e[3 + int(e[2]):]}
    nodes = [n for n in b["Nodes"][1:] if int(n[0]) in used]
    with open(path("bracket.msh"), "w") as f:
        f.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n")
        f.write("\n".join(" ".join(p) for p in b["PhysicalNames"]) + "\n$EndPhysicalNames\n")
        f.write("$Nodes\n%d\n" % len(nodes))
        for n in nodes:
            f.write(n[0] + "".join(" %.9g" % (0.0 if abs(float(x)) < 1e-15 else float(x)) for x in n[1:]) + "\n")
        f.write("$EndNodes\n$Elements\n" + "\n".join(" ".join(e) for e in b["Elements"]) + "\n$EndElements\n")


def eigenvalues(case):
    """the column of CalculiX that carries seven digits: (2 pi f)^2"""
    b = sections(path("bracket.msh"))
    names = {p[2].strip('"'): (int(p[0]), int(p[1])) for p in b["PhysicalNames"][1:]}
    tets, back = [], set()
    for e in b["Elements"][1:]:
        n = e[3 + int(e[2]):]
        if e[1] == "11":
            tets.append([e[0]] + n[:8] + [n[9], n[8]])  # gmsh ends with the edges 3-4, 2-4; CalculiX 2-4, 3-4
        elif e[1] == "9" and int(e[3]) == names["back"][1]:
            back.update(map(int, n))
    deck = "*NODE\n" + "".join(",".join(n) + "\n" for n in b["Nodes"][1:])
    deck += "*ELEMENT, TYPE=C3D10, ELSET=BODY\n" + "".join(",".join(t) + "\n" for t in tets)
    deck += "*NSET, NSET=BACK\n" + "".join("%d,\n" % n for n in sorted(back))
    deck += "*MATERIAL, NAME=ALUMINIUM\n*ELASTIC\n%r,%r\n*DENSITY\n%r\n" % (YOUNG, POISSON, DENSITY)
    deck += "*SOLID SECTION, ELSET=BODY, MATERIAL=ALUMINIUM\n"
    deck += "*BOUNDARY\nBACK,1,3\n" if case == "clamped" else ""
    deck += "*STEP\n*FREQUENCY\n%d\n*END STEP\n" % COUNTS[case]
    with tempfile.TemporaryDirectory() as folder:
        with open(os.path.join(folder, "job.inp"), "w") as f:
            f.write(deck)
        subprocess.run(["ccx", "job"], cwd=folder, check=True, stdout=subprocess.DEVNULL,
                       env={**os.environ, "OMP_NUM_THREADS": "1"})
        rows, started = [], False
        for line in open(os.path.join(folder, "job.dat")):
            words = line.split()
            started = started or "E I G E N V A L U E   O U T P U T" in line
            if len(words) == 5 and words[0].isdigit():
                rows.append(float(words[1]))
            elif started and "P A R T I C I P A T I O N" in line:
                break
    return rows


def frequencies():
    with open(path("frequencies.csv"), "w") as f:
        f.write("case,mode,eigenvalue,hertz\n")
        for case in COUNTS:
            for k, value in enumerate(eigenvalues(case)):
                f.write("%s,%d,%.6e,%.7g\n" % (case, k + 1, value, math.sqrt(max(value, 0)) / (2 * math.pi)))


if __name__ == "__main__":
    for stage in sys.argv[1:] or ["mesh", "frequencies"]:
        {"mesh": mesh, "frequencies": frequencies}[stage]()
