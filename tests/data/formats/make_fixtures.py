#!/usr/bin/env python3
"""Writes the pendulum 'hex8i' of examples/data in the file formats of ANSYS, Abaqus and Nastran, and a small matrix in
every variant of OUTPUT4. Usage: make_fixtures.py (needs numpy). See README.md for what is known of the formats."""
import struct
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SOURCE = HERE / "../../../examples/data/pendulum/hex8i"


def matrix_market(path):
    lines = [line for line in open(path) if not line.startswith("%")]
    A = np.zeros([int(lines[0].split()[0])] * 2)
    for line in lines[1:]:
        i, j, value = line.split()
        A[int(i) - 1, int(j) - 1] = A[int(j) - 1, int(i) - 1] = float(value)
    return A


def write(name, lines):
    path = HERE / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def columns(values, per_line, form):
    return ["".join(form(v) for v in values[k:k + per_line]) for k in range(0, len(values), per_line)]


def lower(A):
    """Row and column numbers of the lower triangle, column by column."""
    j, i = np.nonzero(np.tril(A).T)
    return i, j


def harwell_boeing(name, A, integers_a_line, value_format, values_a_line, value):
    i, j = lower(A)
    pointers = np.concatenate([[1], 1 + np.cumsum(np.bincount(j, minlength=len(A)))])
    width = 14 if integers_a_line == 1 else 8
    integers = f"({integers_a_line if integers_a_line > 1 else ''}I{width})"
    blocks = [columns(pointers, integers_a_line, lambda v: f"{v:{width}d}"),
              columns(i + 1, integers_a_line, lambda v: f"{v:{width}d}"), columns(A[i, j], values_a_line, value)]
    counts = [len(block) for block in blocks]
    header = [f"{'Matrix from ANSYS FULL file dumped into Harwell-Boeing format':80s}", "".join(f"{c:14d}" for c in [sum(counts), *counts, 0]),
              f"{'RSA':14s}{len(A):14d}{len(A):14d}{len(i):14d}{0:14d}", f"{integers:16s}{integers:16s}{value_format:20s}{value_format:20s}"]
    write(name, header + sum(blocks, []))


def ansys(K, M, nodes, elements):
    order = np.random.default_rng(7).permutation(len(nodes))  # the solver's order of nodes
    rows = (3 * order[:, None] + np.arange(3)).ravel()
    K, M = K[np.ix_(rows, rows)], M[np.ix_(rows, rows)]
    # Stiffness as HBMAT lays it out, mass in another of the layouts that the format knows.
    harwell_boeing("ansys/stiffness.matrix", K, 1, "(d25.15)", 1, zero_first)
    harwell_boeing("ansys/mass.matrix", M, 10, "(1P,3E26.18)", 3, lambda v: f"{v:26.18E}")
    labels = ["UX", "UY", "UZ"]
    write("ansys/pendulum.mapping", ["    Matrix Eqn          Node    DOF     "] +
          [f"{k + 1:14d}{row // 3 + 1:14d}    {labels[row % 3]:4s}" for k, row in enumerate(rows)])
    for name, A in [("stiffness", K), ("mass", M)]:
        i, j = lower(A)
        write(f"ansys/{name}.mmf", ["%%MatrixMarket matrix coordinate real symmetric ", "% Creator: ANSYS Inc",
                                    f"{len(A)} {len(A)} {len(i)}"] +
              [f"{a + 1} {b + 1} {three_digits(A[a, b], 15)}" for a, b in zip(i, j)])
    write("ansys/mapping.mmf", ["%%MatrixMarket matrix array integer general", f"{len(order)} 1"] +
          [str(node + 1) for node in order])
    write("ansys/nodes.cdb", ["/COM,pendulum hex8i", f"NBLOCK,6,SOLID,{len(nodes):10d},{len(nodes):10d}",
                              "(3i9,6e21.13e3)"] +
          [f"{k + 1:9d}{0:9d}{0:9d}" + "".join(three_digits(x, 13).rjust(21) for x in r) for k, r in enumerate(nodes)] +
          ["N,R5.3,LOC,       -1,", "ET,        1,185", f"EBLOCK,19,SOLID,{len(elements):10d},{len(elements):10d}",
           "(19i9)"] +
          ["".join(f"{n:9d}" for n in [1, 1, 1, 1, 0, 0, 0, 0, 8, 0, *element]) for element in elements] +
          ["       -1", "CMBLOCK,HINGE   ,NODE,       2  ! users node component definition", "(8i10)",
           f"{1:10d}{-3:10d}", "FINISH"])
    # NWRITE leaves out zeros at the end of a line.
    table = []
    for k, r in enumerate(nodes):
        last = max((n + 1 for n in range(3) if r[n] != 0), default=0)
        table.append(f"{k + 1:8d}" + "".join(f"{x:20.13f}" for x in r[:last]))
    write("ansys/nodes.node", table)


def three_digits(value, digits):
    """Three digits of exponent."""
    mantissa, exponent = f"{value:.{digits}E}".split("E")
    return f"{mantissa}E{int(exponent):+04d}"


def zero_first(value):
    """D25.15 without a scale factor: 0.123D+01."""
    mantissa, exponent = f"{value:.14E}".split("E")
    digits = mantissa.lstrip("-").replace(".", "")
    power = int(exponent) + 1 if value != 0 else 0
    return f"{'-' if value < 0 else ''}0.{digits}D{power:+03d}".rjust(25)


def abaqus(K, M):
    for name, A in [("STIF1", K), ("MASS1", M)]:
        i, j = np.nonzero(np.tril(A))
        write(f"abaqus/coordinate_{name}.mtx", [f"{a + 1} {b + 1} {A[a, b]:.16e}" for a, b in zip(i, j)])
        write(f"abaqus/labels_{name}.mtx",
              [f"{a // 3 + 1},{a % 3 + 1}, {b // 3 + 1},{b % 3 + 1}, {A[a, b]:.16e}" for a, b in zip(i, j)])


def nastran_number(value, width=16):
    """As many digits as a field holds: the exponent goes without its letter."""
    for digits in range(15, 0, -1):
        mantissa, exponent = f"{value:.{digits}E}".split("E")
        text = f"{mantissa}{int(exponent):+d}"
        if len(text) <= width:
            return text.rjust(width)
    raise ValueError(value)


def nastran(K, M, nodes, elements):
    deck = ["SOL 103", "CEND", "BEGIN BULK"]
    for k, r in enumerate(nodes):
        x = [nastran_number(value) for value in r]
        deck += [f"{'GRID*':8s}{k + 1:16d}{'':16s}{x[0]}{x[1]}", f"{'*':8s}{x[2]}"]
    for element in elements:
        fields = [f"{n:8d}" for n in [element[0], 1, *element[1:]]]
        deck += [f"{'CHEXA':8s}" + "".join(fields[:8]), f"{'+':8s}" + "".join(fields[8:])]
    write("nastran/pendulum.bdf", deck + ["ENDDATA"])

    lines = []
    for name, A in [("KAAX", K), ("MAAX", M)]:
        lines.append(f"{'DMIG':8s}{name:8s}{0:8d}{6:8d}{2:8d}{0:8d}{'':16s}{len(A):8d}")
        for b in range(len(A)):
            lines.append(f"{'DMIG*':8s}{name:16s}{b // 3 + 1:16d}{b % 3 + 1:16d}")
            lines += [f"{'*':8s}{a // 3 + 1:16d}{a % 3 + 1:16d}{A[a, b]:16.9E}".replace("E", "D")
                      for a in range(b + 1) if A[a, b] != 0]
    write("nastran/pendulum.pch", lines)

    rows = (6 * (np.arange(len(K)) // 3) + np.arange(len(K)) % 3)  # rotations without stiffness and mass
    grid_set = []
    for A in (K, M):
        G = np.zeros((2 * len(A), 2 * len(A)))
        G[np.ix_(rows, rows)] = A
        grid_set.append(G)
    matrices = list(zip(["KGG", "MGG"], grid_set))
    write("nastran/pendulum_text.op4", sum([op4_text(n, A, "sparse") for n, A in matrices], []))
    (HERE / "nastran/pendulum_binary.op4").write_bytes(
        b"".join(op4_binary(n, A, "bigmat") for n, A in matrices))

    # Every variant, on one element's worth of a chain of three springs.
    A = np.diag([2.0, 3.0, 0.0, 5.0, 7.0]) + np.diag([-1.5, 0, 0, -0.25], 1) + np.diag([-1.5, 0, 0, -0.25], -1)
    A[0, 4] = A[4, 0] = 0.125
    for layout in ["dense", "sparse", "bigmat"]:
        write(f"nastran/small_text_{layout}.op4", op4_text("KAA", A, layout))
        for single in [True, False]:
            for order in "<>":
                for word in [4, 8]:
                    name = f"small_{layout}_{'single' if single else 'double'}_{'le' if order == '<' else 'be'}_{8 * word}"
                    (HERE / f"nastran/{name}.op4").write_bytes(op4_binary("KAA", A, layout, single, order, word))


def runs(column):
    """First row and values of each run of entries that are not zero."""
    found, k = [], 0
    while k < len(column):
        if column[k] != 0:
            end = k
            while end < len(column) and column[end] != 0:
                end += 1
            found.append((k + 1, column[k:end]))
            k = end
        k += 1
    return found


def op4_text(name, A, layout):
    number = lambda v: f"{v:23.16E}"
    words = 2  # of a double, in the counts of sparse columns
    lines = [f"{len(A):8d}{-len(A) if layout == 'bigmat' else len(A):8d}{6:8d}{2:8d}{name:8s}1P,3E23.16"]
    for j, column in enumerate(A.T):
        found = runs(column)
        if not found:
            continue
        if layout == "dense":
            first, last = found[0][0], found[-1][0] + len(found[-1][1]) - 1
            lines += [f"{j + 1:8d}{first:8d}{last - first + 1:8d}"] + columns(column[first - 1:last], 3, number)
            continue
        header = 2 if layout == "bigmat" else 1
        lines.append(f"{j + 1:8d}{0:8d}{sum(header + words * len(v) for _, v in found):8d}")
        for first, values in found:
            length = words * len(values) + 1
            lines.append(f"{length:8d}{first:8d}" if layout == "bigmat" else f"{first + 65536 * length:12d}")
            lines += columns(values, 3, number)
    return lines + [f"{len(A) + 1:8d}{1:8d}{1:8d}", number(1.0)]


def op4_binary(name, A, layout, single=False, order="<", word=4):
    integer, real = ("q" if word == 8 else "i"), ("f" if single and word == 4 else "d")
    words = struct.calcsize(real) // word
    record = lambda data: struct.pack(order + "i", len(data)) + data + struct.pack(order + "i", len(data))
    pack = lambda *values: struct.pack(f"{order}{len(values)}{integer}", *values)
    numbers = lambda values: struct.pack(f"{order}{len(values)}{real}", *values)
    data = record(pack(len(A), -len(A) if layout == "bigmat" else len(A), 6, 1 if single else 2) +
                  name.ljust(2 * word).encode())
    for j, column in enumerate(A.T):
        found = runs(column)
        if not found:
            continue
        if layout == "dense":
            first, last = found[0][0], found[-1][0] + len(found[-1][1]) - 1
            data += record(pack(j + 1, first, words * (last - first + 1)) + numbers(column[first - 1:last]))
            continue
        body = b""
        for first, values in found:
            length = words * len(values) + 1
            body += pack(length, first) if layout == "bigmat" else pack(first + 65536 * length)
            body += numbers(values)
        data += record(pack(j + 1, 0, len(body) // word) + body)
    return data + record(pack(len(A) + 1, 1, words) + numbers([1.0]))


def main():
    K, M = matrix_market(SOURCE / "K.mtx"), matrix_market(SOURCE / "M.mtx")
    table = lambda name: [line.strip().split(",") for line in open(SOURCE / name).readlines()[1:]]
    nodes = [[float(x) for x in row[1:]] for row in table("nodes.csv")]
    elements = [[int(n) for n in row] for row in table("elements.csv")]
    ansys(K, M, nodes, elements)
    abaqus(K, M)
    nastran(K, M, nodes, elements)


main()
