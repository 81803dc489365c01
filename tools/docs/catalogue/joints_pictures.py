"""The joints: two bodies, marker axes as the joint's rows use them, arrows along the freedoms that are left.

Coincident markers are drawn at one point, B turned by what the joint allows.
"""

import numpy as np

from canvas import Picture, turn, vec

E = np.eye(3)
X, Y, Z = E[:, 0], E[:, 1], E[:, 2]
O = vec(0, 0, 0)
SIDEWAYS = np.column_stack([Z, X, Y])  # marker axes with z to the right, x up


def revolute_joint():
    p = Picture("Revolute joint: B turns about the common z axis", centre=(0, 0, 0.25))
    B = turn(Z, 50)
    p.bar(vec(0, -1.5, -0.25), vec(0, -0.2, -0.25), 0.3, "a", Z)
    p.cylinder((0, 0, -0.5), (0, 0, 0), 0.3, "a")
    p.cylinder((0, 0, 0), (0, 0, 0.5), 0.3, "b")
    p.bar(B @ vec(0.28, 0, 0.25), B @ vec(1.1, 0, 0.25), 0.3, "b", Z)
    p.frame(O, E, "A", "a", 1.25, skip="z")
    p.frame(O, B, "B", "b", 1.6, skip="z")
    p.arrow(O, 1.5 * Z, "a")
    p.text(1.68 * Z, "z_A = z_B", "g")
    p.arc(0.95 * Z, Z, X, 0.5, 270, label="")
    p.arc(O, Z, X, 1.0, 50, "m", label="φ", beside=(0, 6))
    return p


def spherical_joint():
    p = Picture("Spherical joint: B turns about the common point", centre=(0, 0, 0.2))
    B = turn((1, 1, 0.4), 35)
    p.bar(-1.5 * Z, -0.45 * Z, 0.24, "a")
    p.arc(O, X, -Y, 0.45, 180, "a w", head=False)
    p.arc(O, Y, X, 0.45, 180, "a w", head=False)
    p.circle(O, Z, 0.45, "a")
    p.sphere(O, 0.34, "b")
    tip = B @ vec(0, 0, 1.6)
    p.bar(0.3 * tip / 1.6, tip, 0.2, "b", X)
    p.frame(O, E, "A", "a", 1.1, skip="z")
    p.frame(O, B, "B", "b", 1.1, skip="z")
    p.arc(0.75 * tip, B[:, 2], X, 0.35, 290)
    p.arc(O, B[:, 0], B[:, 2], 1.75, 32, both=True)
    p.arc(O, B[:, 1], B[:, 2], 1.75, 32, both=True)
    return p


def universal_joint():
    p = Picture("Universal joint: a cross with arms along x of A and y of B", centre=(0, 0, 0.1), azimuth=50)
    B = turn(X, 22) @ turn(Y, 24)
    p.cylinder(-1.7 * Z, -0.85 * Z, 0.16, "a")
    p.line([0.75 * X, 0.75 * X - 0.6 * Z, -0.85 * Z, -0.75 * X - 0.6 * Z, -0.75 * X], "a w")
    p.line([-0.75 * X, 0.75 * X], "a w")
    b = lambda *x: B @ vec(*x)
    p.line([b(0, -0.75, 0), b(0, 0.75, 0)], "b w")
    p.line([b(0, 0.75, 0), b(0, 0.75, 0.6), b(0, 0, 0.85), b(0, -0.75, 0.6), b(0, -0.75, 0)], "b w")
    p.cylinder(b(0, 0, 0.85), b(0, 0, 1.7), 0.16, "b")
    for end in (0.75 * X, -0.75 * X):
        p.dot(end, "a")
    for side in (1, -1):
        p.dot(b(0, 0.75 * side, 0), "b")
    p.arrow(0.75 * X, 1.45 * X, "a", label="x_A")
    p.arrow(b(0, 0.75, 0), b(0, 1.4, 0), "b", label="y_B")
    p.arrow(O, 0.85 * Z, "a", label="z_A", beside=(-10, 4))
    p.arrow(b(0, 0, 1.7), b(0, 0, 2.15), "b", label="z_B")
    p.arc(1.05 * X, X, Y, 0.3, 280, label="")
    p.arc(b(0, 1.05, 0), B[:, 1], X, 0.3, 280)
    return p


def constant_velocity_joint():
    p = Picture("Constant velocity joint: both shafts turn alike at any bend", centre=(0, 0.15, 0.2))
    A = SIDEWAYS
    z_B = turn(X, 35) @ Y
    B = turn(X, 35) @ A
    p.cylinder(-1.9 * Y, -0.35 * Y, 0.17, "a")
    p.cylinder(0.35 * z_B, 1.9 * z_B, 0.17, "b")
    p.sphere(O, 0.4, "g")
    halving = turn(X, 17.5) @ Z
    p.line([-1.1 * halving, 1.2 * halving], "g d")
    p.text(1.38 * halving, "mirror plane", "g", small=True)
    p.arrow(O, 0.95 * Y, "a", label="z_A", beside=(2, 9))
    p.arrow(1.9 * z_B, 2.3 * z_B, "b", label="z_B")
    p.arrow(O, 0.9 * A[:, 0], "a", label="x_A", beside=(-14, 8))
    p.arrow(O, 0.9 * B[:, 0], "b", label="x_B", beside=(-16, 6))
    p.arc(-1.45 * Y, Y, Z, 0.36, 290, label="")
    p.arc(1.3 * z_B, z_B, Z, 0.36, 290)
    p.arc(O, X, Y, 1.05, 35, both=True)
    return p


def cylindrical_joint():
    p = Picture("Cylindrical joint: B slides along the common z axis and turns about it", centre=(0, 0, 0.4))
    B = turn(Z, 50)
    p.box((0, 0, -1.1), (0.9, 0.9, 0.3), "a")
    p.cylinder((0, 0, -0.95), (0, 0, 0.35), 0.16, "a")
    p.cylinder((0, 0, 0.35), (0, 0, 0.95), 0.32, "b")
    p.bar(B @ vec(0.3, 0, 0.65), B @ vec(0.95, 0, 0.65), 0.22, "b", Z)
    p.cylinder((0, 0, 0.95), (0, 0, 1.35), 0.16, "a")
    a = vec(0, 0, -0.6)
    p.frame(a, E, "A", "a", 0.95, skip="z")
    p.frame((0, 0, 0.65), B, "B", "b", 1.45, skip="z")
    p.arrow((0, 0, 1.35), (0, 0, 1.8), "a", label="z_A = z_B")
    p.arc((0, 0, 1.15), Z, X, 0.42, 280)
    p.arrow((-0.2, 0.75, 0.2), (-0.2, 0.75, 1.0), both=True)
    p.dimension(a, (0, 0, 0.65), "s", offset=(-92, 0), beside=(-9, 0))
    return p


def prismatic_joint():
    p = Picture("Prismatic joint: B slides along z of A", centre=(0, 0, 0.25))
    A = SIDEWAYS
    p.box((0, 0, -0.15), (0.5, 3.6, 0.3), "a")
    p.box((0, 0.55, 0.3), (0.7, 0.9, 0.6), "b")
    a, b = vec(0, -1.1, 0), vec(0, 0.55, 0.6)
    p.frame(a, A, "A", "a", 0.85, skip="z")
    p.arrow((0, 1.8, -0.15), (0, 2.2, -0.15), "a", label="z_A ∥ z_B", beside=(24, 4))
    p.frame(b, A, "B", "b", 0.85, skip="z")
    p.arrow((-0.3, 0.75, 1.0), (-0.3, 1.75, 1.0), both=True, size=10)
    p.dimension(vec(0.25, -1.1, -0.3), vec(0.25, 0.55, -0.3), "s = z_A · d", offset=(0, 26), beside=(14, 16))
    return p


def screw_joint():
    p = Picture("Screw joint: displacement and angle belong together", centre=(0, 0, 0.35))
    B = turn(Z, 50)
    p.box((0, 0, -1.15), (0.9, 0.9, 0.25), "a")
    p.cylinder((0, 0, -1.02), (0, 0, 1.25), 0.18, "a")
    t = np.linspace(0, 1, 90)
    helix = [vec(0.18 * np.cos(2 * np.pi * 7 * s), 0.18 * np.sin(2 * np.pi * 7 * s), -0.95 + 2.1 * s) for s in t]
    run = []
    for q in helix + [None]:
        if q is not None and q[:2] @ p.to_eye[:2] > -0.02:
            run.append(q)
        elif run:
            p.line(run, "a n")
            run = []
    p.cylinder((0, 0, 0.2), (0, 0, 0.6), 0.42, "b")
    p.bar(B @ vec(0.4, 0, 0.4), B @ vec(1.0, 0, 0.4), 0.22, "b", Z)
    p.frame((0, 0, -0.85), E, "A", "a", 0.95, skip="z")
    p.frame((0, 0, 0.4), B, "B", "b", 1.5, skip="z")
    p.arrow((0, 0, 1.25), (0, 0, 1.65), "a", label="z_A = z_B")
    p.arc((0, 0, 0.95), Z, X, 0.45, 250, label="")
    p.arrow((-0.2, 0.7, 0.45), (-0.2, 0.7, 1.1), label="lead a turn", beside=(38, 6))
    return p


def planar_joint():
    p = Picture("Planar joint: B slides and turns on the plane of A", centre=(0, 0.1, 0.2), elevation=34)
    p.box((0, 0, -0.08), (2.6, 3.4, 0.16), "a")
    B = turn(Z, -25)
    a, b = vec(0.7, -1.0, 0), vec(-0.25, 0.7, 0)
    p.box(b + vec(0, 0, 0.17), (0.7, 0.9, 0.34), "b", B)
    p.frame(a, E, "A", "a", 0.8, beside={"y": (2, 9)})
    p.frame(b, B, "B", "b", 0.85)
    p.arrow(b + vec(0.62, -0.62, 0), b + vec(1.25, -0.62, 0), both=True)
    p.arrow(b + vec(-0.72, -0.75, 0), b + vec(-0.72, 0.1, 0), both=True)
    p.arc(b + vec(0, 0, 0.62), Z, X, 0.35, 280)
    return p


def fixed_joint():
    p = Picture("Fixed joint: nothing is left free", centre=(0, 0, 0.1))
    p.box((0, -0.8, 0), (0.7, 1.6, 0.7), "a")
    p.box((0, 0.8, 0), (0.7, 1.6, 0.7), "b")
    for s in np.linspace(-0.35, 0.25, 5):
        p.line([(0.35, 0.07, s), (0.35, -0.07, s + 0.1)], "g w")
        p.line([(s + 0.1, 0.07, 0.35), (s, -0.07, 0.35)], "g w")
    origin = vec(0.35, 0, 0.35)
    p.frame(origin, E, "", "g", 0.95, skip="xyz")
    for axis, text, shift in ((X, "x_A = x_B", (0, 6)), (Y, "y_A = y_B", (22, 8)), (Z, "z_A = z_B", (0, 0))):
        p.arrow(origin, origin + 0.95 * axis, "g", label=text, beside=shift)
    p.text((0.35, -1.0, 0.0), "A", "a")
    p.text((0.35, 1.0, 0.0), "B", "b")
    return p


def three_node_fixation():
    p = Picture("Three-node fixation: three nodes keep their place in the holder", centre=(0.1, 0.35, 0.15))
    holder = vec(0.3, -1.35, -0.1)
    p.box((0, -1.5, 0), (1.0, 0.3, 1.3), "a")
    for y in np.linspace(0, 2.2, 5)[:-1]:
        p.box((0, y + 0.275, 0), (0.8, 0.55, 0.9), "b")
    nodes = [vec(0.4, 0, -0.45), vec(0.4, 0, 0.45), vec(-0.4, 0, 0.45)]
    A = turn(Z, -10)
    p.frame(holder, A, "H", "a", 0.75, skip="y", beside={"x": (0, 4)})
    for i, node in enumerate(nodes):
        p.arrow(holder, node, "m", size=8)
        p.dot(node, "b", 4.5)
        p.text(node, f"p_{i + 1}", "b", dx=14, dy=(12, -10, -12)[i])
        p.text(0.45 * holder + 0.55 * node, f"c_{i + 1}", "m", dy=(11, -10, -9)[i], dx=(4, -4, -4)[i])
    return p


def point_on_line_joint():
    p = Picture("Point on a line: B keeps on z of A", centre=(0, 0.1, 0.2))
    A = SIDEWAYS
    p.box((0, -1.75, -0.3), (0.5, 0.3, 1.0), "a")
    p.line([(0, -1.6, 0), (0, 1.9, 0)], "a w")
    b = vec(0, 0.6, 0)
    p.sphere(b, 0.17, "b")
    B = turn((1, 0.3, 0.5), 40) @ A
    p.bar(b + 0.16 * B[:, 0], b + 1.2 * B[:, 0], 0.14, "b", Y)
    p.dot(b, "b")
    p.frame((0, -1.1, 0), A, "A", "a", 0.8, skip="z")
    p.text((0, 2.1, 0), "z_A", "a")
    p.arrow((0, -0.1, -0.3), (0, 1.3, -0.3), both=True)
    p.arc(b + 0.9 * B[:, 0], B[:, 0], Y, 0.3, 290)
    p.arc(b, B[:, 1], B[:, 0], 1.35, 34, both=True)
    p.arc(b, B[:, 2], B[:, 0], 1.35, 34, both=True)
    return p


def sliding_joint():
    p = Picture("Sliding joint: a point on a curve through markers", centre=(0, 0.1, 0.2))
    at = lambda s: vec(0.2 * np.sin(2 * s), -1.6 + 1.6 * s, 0.5 * np.sin(1.9 * s) - 0.1)
    p.line([at(s) for s in np.linspace(0, 2.1, 40)], "a w")
    for s in np.linspace(0, 2.1, 7):
        p.dot(at(s), "a", 4)
    b, t = at(0.92), at(0.93) - at(0.92)
    t = t / np.linalg.norm(t)
    n = np.cross(vec(1, 0, 0), t)
    p.sphere(b, 0.13, "b")
    p.text(b, "p", "b", dx=-14, dy=20)
    p.arrow(b, b + 0.75 * t, "b", both=True)
    p.arrow(b, b + 0.8 * n / np.linalg.norm(n), "f", label="n_2")
    p.text(at(2.1), "r(u)", "a", dx=18)
    p.text(at(0.35), "P_a", "a", dx=2, dy=22)
    return p


def point_on_plane_joint():
    p = Picture("Point on a plane: B keeps in the plane normal to z of A", centre=(0, 0.1, 0.3), elevation=34)
    p.box((0, 0, -0.06), (2.6, 3.4, 0.12), "a")
    b = vec(0, 0.6, 0)
    B = turn((1, 0.3, 0.2), 28)
    p.bar(b + 0.1 * B[:, 2], b + 1.35 * B[:, 2], 0.16, "b", X)
    p.sphere(b, 0.13, "b")
    p.text(b, "p_B", "b", dx=20, dy=8)
    p.frame((0.7, -1.0, 0), E, "A", "a", 0.8, beside={"y": (2, 9)})
    p.arrow(b + vec(0.25, -0.2, 0), b + vec(1.0, -0.2, 0), both=True)
    p.arrow(b + vec(-0.55, -0.5, 0), b + vec(-0.55, 0.6, 0), both=True)
    p.arc(b + 1.05 * B[:, 2], B[:, 2], X, 0.32, 290)
    p.arc(b, B[:, 0], B[:, 2], 1.5, 32, both=True)
    p.arc(b, B[:, 1], B[:, 2], 1.5, 32, both=True)
    return p


def distance_joint():
    p = Picture("Distance joint: a massless rod with a ball at each end", centre=(0, 0, 0.15))
    a, b = vec(0, -1.1, -0.1), vec(0, 1.1, 0.5)
    p.box(a + vec(0, -0.45, -0.1), (0.7, 0.8, 0.6), "a")
    p.box(b + vec(0, 0.45, 0.1), (0.7, 0.8, 0.6), "b", turn((1, 0, 0.6), 20))
    p.line([a, b], "g w")
    p.dot(a, "a", 5)
    p.dot(b, "b", 5)
    p.text(a, "p_A", "a", dx=4, dy=-15)
    p.text(b, "p_B", "b", dx=-8, dy=-15)
    p.dimension(a, b, "L,  d = p_B − p_A", offset=(7, 25), beside=(16, 18))
    p.arc(a, X, b - a, np.linalg.norm(b - a) * 1.0, 16, both=True, head=True)
    p.arc(a, Z, b - a, np.linalg.norm(b - a) * 0.55, 40, both=True)
    return p


def massless_rod():
    p = distance_joint()
    p.title = "Massless rod: the plug-in that ties two points by a rod"
    return p


PICTURES = {
    f.__name__: f
    for f in (
        revolute_joint,
        spherical_joint,
        universal_joint,
        constant_velocity_joint,
        cylindrical_joint,
        prismatic_joint,
        screw_joint,
        planar_joint,
        fixed_joint,
        three_node_fixation,
        point_on_line_joint,
        sliding_joint,
        point_on_plane_joint,
        distance_joint,
        massless_rod,
    )
}