"""The bodies: their coordinates."""

import numpy as np

from canvas import Picture, turn, vec
from joints_pictures import E, O, X, Y, Z
from transmissions_pictures import flat


def world(p, at=(0.9, -1.5, -0.5), length=0.65):
    p.frame(at, E, "", "g", length)
    return vec(at)


def ground():
    p = Picture("Ground: markers fixed in the world", centre=(0, 0, 0.1))
    p.box((0, 0, -0.06), (2.2, 3.0, 0.12), "g")
    world(p, (0.7, -1.0, 0))
    R = turn((1, 0, 0), -35)
    p.frame((-0.4, 0.6, 0.1), R, "", "a", 0.65)
    p.arrow((0.7, -1.0, 0), (-0.4, 0.6, 0.1), "m", size=7)
    p.text((0.15, -0.1, 0.2), "position", "m", small=True)
    p.text((-0.4, 0.5, -0.25), "orientation", "a", small=True)
    return p


def blob(p, R, at, style="a", bend=0.0, scale=1.0):
    t = np.linspace(0, 2 * np.pi, 40)
    outline = []
    for s in t:
        y, z = 1.15 * np.cos(s), 0.45 * np.sin(s) + 0.05 * np.sin(2 * s)
        outline.append(vec(at) + R @ (scale * vec(0, y, z + bend * (y + 1.15) ** 2)))
    p.line(outline[:-1], style, closed=True)


def rigid_body():
    p = Picture("Rigid body: centre of mass, body axes, a marker", centre=(0, 0, 0.15))
    o = world(p)
    R = turn((1, 0.2, 0.1), 25)
    c = vec(0, 0.3, 0.4)
    blob(p, R, c, "af", scale=1.15)
    p.frame(c, R, "", "a", 0.75)
    p.dot(c, "a", 4)
    p.arrow(o, c, "m", size=8)
    p.text(0.5 * (o + c), "p", "m", dy=-10)
    m = c + R @ vec(0, 1.0, 0.15)
    p.dot(m, "b", 4)
    p.arrow(c, m, "b", size=7)
    p.text(m, "marker", "b", dx=30, dy=-8, small=True)
    p.text(c + vec(0, -0.55, 0.1), "A(e), ω", "a", dy=-4)
    return p


def flexible_body():
    p = Picture("Flexible body: floating frame, undeformed place r of a node, deformation B η", centre=(0, 0, 0.15))
    o = world(p)
    R = turn((1, 0, 0.1), 8)
    f = vec(0, -0.95, 0.25)
    ys = np.linspace(0, 2.4, 9)
    for bend, style in ((0.0, "g n d"), (0.13, "a")):
        top = [f + R @ vec(0, y, 0.16 + bend * y**2) for y in ys]
        low = [f + R @ vec(0, y, -0.16 + bend * y**2) for y in ys]
        p.line(top, style)
        p.line(low, style)
        for a, b in zip(top, low):
            p.line([a, b], style)
    p.frame(f, R, "", "a", 0.6, skip="")
    p.arrow(o, f, "m", size=8)
    p.text(0.5 * (o + f), "x_0", "m", dx=-14)
    tip0, tip = f + R @ vec(0, 2.4, -0.16), f + R @ vec(0, 2.4, -0.16 + 0.13 * 5.76)
    p.arrow(f, tip0, "g", size=7)
    p.text(0.5 * (f + tip0), "r_0", "g", dy=13)
    p.arrow(tip0, tip, "f w", label="", size=8)
    p.text(0.5 * (tip0 + tip), "B η", "f", dx=18)
    p.dot(tip, "b", 4)
    p.text(tip, "node", "b", dx=24, dy=2, small=True)
    return p


def beam():
    p = Picture("Beam: rigid nodes with section axes, elements between them", centre=(0, 0, 0.3))
    world(p)
    places = [vec(0, -0.9 + 1.3 * s, -0.1 + 0.32 * s**2) for s in np.linspace(0, 2, 33)]
    axes = []
    for i in range(33):
        ahead = places[min(i + 1, 32)] - places[max(i - 1, 0)]
        e1 = ahead / np.linalg.norm(ahead)
        axes.append(np.column_stack([e1, -X, np.cross(e1, -X)]))
    for side in (0.13, -0.13):
        p.line([q + side * R[:, 2] for q, R in zip(places, axes)], "a")
    p.line(places, "g n d")
    for i in (0, 8, 16, 24, 32):
        p.line([places[i] - 0.13 * axes[i][:, 2], places[i] + 0.13 * axes[i][:, 2]], "a n")
        p.dot(places[i], "b", 4)
    for i in (0, 16):
        for k in range(3):
            end = places[i] + 0.6 * axes[i][:, k]
            p.arrow(places[i], end, "a", size=7)
            p.text(places[i] + 0.74 * axes[i][:, k], str(k + 1), "a", small=True)
    p.text(places[26], "element: Γ, K", "f", dx=44, dy=30, small=True)
    p.text(places[8], "node", "b", dx=2, dy=26, small=True)
    return p


def slender_body():
    p = flat("SlenderBody: rigid, modes or exact elements, from one drawing", scale=56)
    p.scale = 60
    for k, (bend, nodes, what) in enumerate(((0, 0, "rigid"), (0.12, 0, "modes"), (0.45, 6, "exact"))):
        y0 = 0.9 - 0.75 * k
        s = np.linspace(0, 1, 25)
        curve = [vec(-1.9 + 3.2 * a - 0.5 * bend * a**3, y0 - bend * a**2 * (1.5 - 0.5 * a), 0) for a in s]
        p.line([vec(-1.9, y0, 0), vec(1.3, y0, 0)], "g n d")
        p.line(curve, "a w")
        p.line([vec(-1.9, y0 - 0.18, 0), vec(-1.9, y0 + 0.18, 0)], "g w")
        for i in range(nodes + 1 if nodes else 0):
            p.dot(curve[4 * i], "b", 4)
        p.text(vec(1.62, y0, 0), what, "m", dx=22, small=True)
    return p


def modes():
    p = flat("Reduction: from all nodes to a few modes", scale=56)
    p.scale = 60
    for k, (x0, wave) in enumerate(((0, 1), (0, 2), (0, 3))):
        y0 = 0.8 - 0.85 * k
        s = np.linspace(0, 1, 13)
        betas = (4.7300, 7.8532, 10.9956)
        b = betas[k]
        shape = np.cosh(b * s) + np.cos(b * s) - (np.cosh(b) - np.cos(b)) / (np.sinh(b) - np.sin(b)) * (
            np.sinh(b * s) + np.sin(b * s)
        )
        for half in (0.06, -0.06):
            p.line([vec(-2.6 + 3 * x, y0 + 0.14 * v + half, 0) for x, v in zip(s, shape)], "a")
        for x, v in zip(s, shape):
            p.line([vec(-2.6 + 3 * x, y0 + 0.14 * v - 0.06, 0), vec(-2.6 + 3 * x, y0 + 0.14 * v + 0.06, 0)], "a n")
        p.line([vec(-2.6, y0, 0), vec(0.4, y0, 0)], "g n d")
        p.text(vec(0.75, y0, 0), f"η_{k + 1}", "f")
        p.text(vec(-2.85, y0, 0), f"{k + 1}", "g", small=True)
    p.line([vec(1.2, -0.75, 0), vec(1.2, 0.1, 0), vec(2.7, 0.1, 0)], "b w")
    p.text(vec(2.0, 0.32, 0), "static modes", "b", small=True)
    p.line([vec(1.2 + 1.5 * x, 0.1 - 0.5 * x**2 * (3 - x) / 2, 0) for x in np.linspace(0, 1, 12)], "b")
    p.arrow(vec(2.7, -0.4, 0), vec(2.7, -0.8, 0), "f w")
    p.text(vec(2.7, -0.98, 0), "loaded", "b", small=True)
    return p


def integral_state():
    p = flat("Integral state: a coordinate whose rate is an integral", scale=60)
    p.scale = 64
    p.line([vec(-1.8, 0, 0), vec(1.9, 0, 0)], "g n")
    p.ground(vec(-1.8, 0, 0), X, Y, 0.9)
    p.line([vec(0.2, 0, 0), vec(0.9, 0, 0), vec(0.9, 0.5, 0), vec(0.2, 0.5, 0)], "af", True)
    p.text(vec(0.55, 0.25, 0), "1", "a")
    p.dimension(vec(-1.8, -0.1, 0), vec(0.2, -0.1, 0), "q", offset=(0, 14), beside=(0, 12))
    p.arrow(vec(0.9, 0.25, 0), vec(1.6, 0.25, 0), "f w", label="e(t)", beside=(10, 0))
    p.text(vec(0.1, 0.95, 0), "q̈ = e,   q̇ = ∫ e dt", "g")
    return p


def inertial_body():
    p = Picture("Inertial body: nodal positions of bricks in world axes", centre=(0, 0.2, 0.2))
    o = world(p)
    angles = np.linspace(0, 1.15, 6)
    radius = 2.1

    def place(i, across, up):
        t = angles[i]
        return vec(across, -0.8 + (radius - up) * np.sin(t), -0.35 + radius - (radius - up) * np.cos(t))

    for i in range(5):
        for up in (0.0, 0.4):
            p.line([place(i, 0.3, up), place(i + 1, 0.3, up)], "a")
        p.line([place(i, -0.3, 0.4), place(i + 1, -0.3, 0.4)], "a")
    for i in range(6):
        p.line([place(i, 0.3, 0), place(i, 0.3, 0.4), place(i, -0.3, 0.4)], "a")
        for q in (place(i, 0.3, 0), place(i, 0.3, 0.4), place(i, -0.3, 0.4)):
            p.dot(q, "a", 2.6)
    p.line([place(5, 0.3, 0), place(5, -0.3, 0), place(5, -0.3, 0.4)], "a")
    node = place(3, 0.3, 0)
    p.arrow(o, node, "m", size=8)
    p.text(node, "q_i", "m", dx=10, dy=14)
    return p


PICTURES = {f.__name__: f for f in (ground, rigid_body, beam, slender_body, flexible_body, modes, integral_state, inertial_body)}
