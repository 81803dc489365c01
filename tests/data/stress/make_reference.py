#!/usr/bin/env python3
"""Stresses by CalculiX (ccx 2.20): writes the tables of this folder.

usage:  python3 make_reference.py [static|pendulum]     runs ccx in a temporary folder

static    one small distorted bar a type, clamped at x = 0, forces at its other end: TYPE.inp and TYPE.csv
pendulum  the rod of examples/data/pendulum/hex8i released from rest, nonlinear: pendulum_stress.csv and
          pendulum_displacements.csv (two minutes)
"""
import csv, math, os, subprocess, sys, tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROD = os.path.join(HERE, "../../../examples/data/pendulum/hex8i")
BRICK = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2),
         (1, 0, 0), (2, 1, 0), (1, 2, 0), (0, 1, 0), (1, 0, 2), (2, 1, 2), (1, 2, 2), (0, 1, 2),
         (0, 0, 1), (2, 0, 1), (2, 2, 1), (0, 2, 1)]  # halves of a cell
TETS = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]  # about the diagonal 0-6
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]


def lines(ids, n=8):
    ids = list(ids)
    return "".join(",".join(map(str, ids[k:k + n])) + ",\n" for k in range(0, len(ids), n))


def run(job, deck, folder):
    with open(os.path.join(folder, job + ".inp"), "w") as f:
        f.write(deck)
    r = subprocess.run(["ccx", job], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                       env={**os.environ, "OMP_NUM_THREADS": "1"})
    if r.returncode or "*ERROR" in r.stdout:
        sys.exit(r.stdout[-2000:])


def frd_field(path, name):
    """{node: values} of the last block of that name"""
    values, inside = {}, False
    for line in open(path):
        if line.startswith(" -4"):
            inside = line[5:13].strip() == name
        elif line.startswith(" -3"):
            inside = False
        elif inside and line.startswith(" -1"):
            values[int(line[3:13])] = [float(line[13 + 12 * k:25 + 12 * k]) for k in range((len(line.rstrip()) - 13) // 12)]
    return values


def bar(kind, cells=(4, 2, 2), size=(0.08, 0.02, 0.03)):
    """nodes {id: xyz} and elements of a distorted bar; C3D8I: sheared, each cell alike. CalculiX leaves the factor j0/j
    out of the incompatible shapes, without which bricks other than parallelepipeds fail the patch test."""
    ids, elements = {}, []

    def node(p):  # p in half cells
        return ids.setdefault(tuple(p), len(ids) + 1)
    for i in range(cells[0]):
        for j in range(cells[1]):
            for k in range(cells[2]):
                corner = [2 * i, 2 * j, 2 * k]
                at = [[corner[d] + b[d] for d in range(3)] for b in BRICK]
                if kind in ("C3D8", "C3D8I"):
                    elements.append([node(p) for p in at[:8]])
                elif kind in ("C3D20", "C3D20R"):
                    elements.append([node(p) for p in at])
                else:
                    for tet in TETS:
                        c = [at[a] for a in tet]
                        middles = [[(c[a][d] + c[b][d]) // 2 for d in range(3)] for a, b in EDGES]
                        elements.append([node(p) for p in (c if kind == "C3D4" else c + middles)])
    nodes = {}
    for p, n in ids.items():
        x, y, z = (size[d] * p[d] / (2 * cells[d]) for d in range(3))
        s = x / size[0]
        if kind == "C3D8I":
            nodes[n] = (round(x + 0.2 * z - 0.1 * y, 9), round(y + 0.1 * z, 9), round(z - 0.05 * y + 0.1 * x, 9))
            continue
        nodes[n] = (round(x + 0.15 * s * z - 0.1 * s * y, 9), round(y * (1 - 0.3 * s) + 0.004 * math.sin(3 * s), 9),
                    round(z * (1 + 0.2 * s * s) + 0.1 * s * y, 9))
    return ids, nodes, elements


def static():
    with tempfile.TemporaryDirectory() as folder:
        for kind in ("C3D4", "C3D8", "C3D8I", "C3D10", "C3D20", "C3D20R"):
            ids, nodes, elements = bar(kind)
            last = max(p[0] for p in ids)
            tip = sorted(n for p, n in ids.items() if p[0] == last)
            deck = "** distorted bar, clamped at one end, forces at the other; made by make_reference.py\n*NODE\n"
            deck += "".join("%d,%r,%r,%r\n" % (n, *x) for n, x in sorted(nodes.items()))
            deck += "*ELEMENT, TYPE=%s, ELSET=BAR\n" % kind
            deck += "".join(lines([e + 1] + el, 11).rstrip(",\n") + "\n" for e, el in enumerate(elements))
            deck += "*NSET, NSET=ROOT\n" + lines(sorted(n for p, n in ids.items() if p[0] == 0))
            deck += "*NSET, NSET=TIP\n" + lines(tip)
            deck += "*MATERIAL, NAME=ALUMINIUM\n*ELASTIC\n7.e10,0.33\n*DENSITY\n2700.\n"
            deck += "*SOLID SECTION, ELSET=BAR, MATERIAL=ALUMINIUM\n*BOUNDARY\nROOT,1,3\n*STEP\n*STATIC\n*CLOAD\n"
            deck += "TIP,1,30.\nTIP,2,-10.\nTIP,3,20.\n*NODE FILE\nU\n*EL FILE\nS,E\n*END STEP\n"
            run(kind, deck, folder)
            u, s, e = (frd_field(os.path.join(folder, kind + ".frd"), name) for name in ("DISP", "STRESS", "TOSTRAIN"))
            with open(os.path.join(HERE, kind + ".inp"), "w") as f:
                f.write(deck)
            with open(os.path.join(HERE, kind + ".csv"), "w") as f:
                f.write("node,ux,uy,uz,sxx,syy,szz,sxy,syz,szx,exx,eyy,ezz,exy,eyz,ezx\n")
                for n in sorted(nodes):
                    f.write(",".join(["%d" % n] + ["%.5e" % v for v in u[n][:3] + s[n][:6] + e[n][:6]]) + "\n")


def pendulum(step=2.5e-5, instants=(0.1, 0.15, 0.2)):
    """C3D8I elements without mass carry the stiffness, C3D8 without stiffness the mass and weight: K and M of the body"""
    with open(os.path.join(ROD, "nodes.csv")) as f:
        nodes = [tuple(map(float, row[1:])) for row in list(csv.reader(f))[1:]]
    with open(os.path.join(ROD, "elements.csv")) as f:
        elements = [list(map(int, row[1:9])) for row in list(csv.reader(f))[1:]]
    count, every = len(elements), round(0.05 / step)
    deck = "*NODE, NSET=NALL\n" + "".join("%d,%r,%r,%r\n" % (n + 1, *x) for n, x in enumerate(nodes))
    for first, kind, name in ((1, "C3D8I", "ESTIFF"), (1 + count, "C3D8", "EMASS")):
        deck += "*ELEMENT, TYPE=%s, ELSET=%s\n" % (kind, name)
        deck += "".join(",".join(map(str, [first + e] + el)) + "\n" for e, el in enumerate(elements))
    for name, young, nu, density in (("STIFF", 1e7, 0.49, 1.73333333333333e-6), ("MASS", 1e-3, 0.0, 0.26 / 1.5e-5)):
        deck += "*MATERIAL, NAME=%s\n*ELASTIC\n%r,%r\n*DENSITY\n%r\n*SOLID SECTION, ELSET=E%s, MATERIAL=%s\n" % (
            name, young, nu, density, name, name)
    deck += "*ELSET, ELSET=EALL\nESTIFF,EMASS\n*NSET, NSET=HINGE\n1,2,3\n*BOUNDARY\nHINGE,1,3,0.\n"
    deck += "*STEP, INC=100000000, NLGEOM\n*DYNAMIC, DIRECT, ALPHA=0.\n%r,%r\n" % (step, max(instants))
    deck += "*CONTROLS, PARAMETERS=FIELD\n1.e-8,1.e-6,,,1.e-6,1.e-5,1.e-6,1.e-10\n*DLOAD\nEALL,GRAV,9.81,0.,0.,-1.\n"
    deck += "*NODE PRINT, NSET=NALL, FREQUENCY=%d\nU\n*EL PRINT, ELSET=ESTIFF, FREQUENCY=%d\nS\n*END STEP\n" % (every, every)
    with tempfile.TemporaryDirectory() as folder:
        run("job", deck, folder)
        with open(os.path.join(folder, "job.dat")) as f:
            output = f.readlines()
    stress, moved, block, t = {}, {}, None, None
    for line in output:
        words = line.split()
        if "time" in line:
            t, block = round(float(words[-1]), 9), stress if "stresses" in line else moved
        elif len(words) == 8 and block is stress and t in instants:
            stress[t, int(words[0]), int(words[1])] = words[2:]
        elif len(words) == 4 and block is moved and t in instants:
            moved[t, int(words[0])] = words[1:]
    with open(os.path.join(HERE, "pendulum_stress.csv"), "w") as f:
        f.write("t,element,point,sxx,syy,szz,sxy,sxz,syz\n")
        for (t, e, p), s in stress.items():
            f.write("%g,%d,%d," % (t, e, p) + ",".join("%.6e" % float(v) for v in s) + "\n")
    with open(os.path.join(HERE, "pendulum_displacements.csv"), "w") as f:
        f.write("t,node,ux,uy,uz\n")
        for (t, n), u in moved.items():
            f.write("%g,%d," % (t, n) + ",".join("%.6e" % float(v) for v in u) + "\n")


if __name__ == "__main__":
    for stage in sys.argv[1:] or ["static", "pendulum"]:
        {"static": static, "pendulum": pendulum}[stage]()
