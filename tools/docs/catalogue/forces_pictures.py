"""The forces: schematics with the symbols of their laws, and charts of the laws themselves."""

import numpy as np

from canvas import Chart, Picture, turn, vec
from joints_pictures import E, O, X, Y, Z
from transmissions_pictures import flat


def spring_damper():
    p = Picture("Spring and damper along the line between two markers", centre=(0, 0, 0.1))
    a, b = vec(0, -1.3, -0.15), vec(0, 1.3, 0.45)
    p.box(a + vec(0, -0.45, -0.05), (0.7, 0.8, 0.7), "a")
    p.box(b + vec(0, 0.45, 0.05), (0.7, 0.8, 0.7), "b", turn((1, 0, 0.6), 18))
    shift = 0.17 * Z
    d = (b - a) / np.linalg.norm(b - a)
    p.line([a, a + 0.15 * d], "g")
    p.line([b, b - 0.15 * d], "g")
    for side in (1, -1):
        p.line([a + 0.15 * d, a + 0.15 * d + side * shift], "g")
        p.line([b - 0.15 * d, b - 0.15 * d + side * shift], "g")
    p.spring(a + 0.15 * d + shift, b - 0.15 * d + shift)
    p.damper(a + 0.15 * d - shift, b - 0.15 * d - shift)
    p.dot(a, "a", 4)
    p.dot(b, "b", 4)
    p.text((a + b) / 2 + 1.6 * shift, "k, l_0", "g", dy=-8)
    p.text((a + b) / 2 - 1.6 * shift, "c", "g", dy=6)
    p.arrow(a - 0.5 * Z, a - 0.5 * Z + 0.7 * d, "f w", label="σ", beside=(2, 8))
    p.arrow(b - 0.5 * Z, b - 0.5 * Z - 0.7 * d, "f w", label="σ", beside=(-4, 8))
    p.dimension(a, b, "l", offset=(0, 72), beside=(4, 11))
    return p


def coordinate_spring():
    p = flat("Torsional spring and damper on the angle of a hinge")
    B = turn(Z, 50)
    t = np.linspace(0, 5.5 * np.pi, 90)
    p.line([(0.16 + 0.023 * s) * vec(np.cos(s + 0.9), np.sin(s + 0.9), 0) for s in t], "g")
    p.bar(-0.1 * B[:, 0], 1.3 * B[:, 0], 0.2, "b", Z)
    p.frame(O, E, "A", "a", 1.45, skip="yz")
    p.frame(O, B, "B", "b", 1.65, skip="yz")
    p.line([1.25 * turn(Z, 15)[:, 0], O], "g n d")
    p.text(1.45 * turn(Z, 15)[:, 0], "x_0", "g")
    p.arc(O, Z, X, 1.2, 50, "m w", label="x", beside=(4, 8))
    p.arc(O, Z, B[:, 0], 0.85, -33, "f w", label="σ", beside=(-14, -6))
    p.text(vec(0.0, -0.85, 0), "σ = k (x − x_0) + c ẋ + σ_0", "g")
    return p


def coordinate_motor():
    p = Picture("Motor: a torque or force on a coordinate by a law", centre=(0, 0, 0.3))
    B = turn(Z, 50)
    p.box((0, 0, -0.35), (0.9, 0.9, 0.7), "a")
    p.cylinder((0, 0, 0), (0, 0, 0.5), 0.14, "b")
    p.bar(B @ vec(-0.2, 0, 0.4), B @ vec(1.0, 0, 0.4), 0.2, "b", Z)
    p.arc((0, 0, 0.9), Z, X, 0.42, 290, "f w")
    p.text((0, 0.62, 1.05), "effort(t, x, ẋ)", "f", anchor="start")
    p.arc((0, 0, 0.5), Z, X, 1.1, 50, "m", label="x", beside=(0, 10))
    p.arrow((0, 0, 0.5), (1.25, 0, 0.5), "a", label="x_A")
    p.arrow((0, 0, 0.5), 0.5 * Z + 1.45 * B[:, 0], "b", label="x_B")
    return p


def coordinate_stop():
    p = Chart("Stop: force over the coordinate beyond a limit, closing and parting", (-0.6, 1), (0, 1.5), "x − upper, mm", "push, kN")
    p.grid([-0.5, 0, 0.5, 1], [0, 0.5, 1, 1.5])
    x = np.linspace(-0.6, 1, 161)
    elastic = np.where(x > 0, np.maximum(x, 0) ** 1.5, 0)
    for line, (factor, text) in enumerate(((1.4, "closing: 1 + d δ̇ = 1.4"), (1.0, "at rest"), (0.6, "parting: 0.6"))):
        p.curve(x, elastic * factor, line)
        p.key(text, line, -0.25, 1.3 - 0.14 * line)
    return p


def joint_friction():
    p = Chart("Friction: coefficient over sliding speed, from −0.3 to 0.3 m/s", (-0.3, 0.3), (-0.35, 0.35), "s, m/s", "μ(s)")
    p.grid([-0.3, -0.2, -0.1, 0, 0.1, 0.2, 0.3], [-0.3, -0.2, 0, 0.2, 0.3])
    s = np.linspace(-0.3, 0.3, 601)
    for line, (still, text) in enumerate(((0.3, "μ_s = 0.3, μ_k = 0.2"), (0.2, "μ_s = μ_k = 0.2"))):
        mu = (0.2 + (still - 0.2) * np.exp(-((s / 0.1) ** 2))) * np.tanh(s / 5e-3)
        p.curve(s, mu, line)
        p.key(text, line, 0.17, -0.1 - 0.06 * line)
    p.key("v_s = 0.1 m/s, v_c = 15 mm/s", 4, 0.17, -0.22)
    return p


def bushing():
    p = Picture("Bushing: six coupled springs and dampers between two markers", centre=(0, 0, 0.1))
    p.cylinder((0, -0.9, 0), (0, 0.9, 0), 0.75, "a")
    p.circle((0, 0.9, 0), Y, 0.35, "b", fill=True)
    p.cylinder((0, -1.5, 0), (0, 1.5, 0), 0.3, "b")
    end = vec(0, 0.9, 0)
    for t in np.linspace(0, 2 * np.pi, 9)[:-1]:
        n = vec(np.sin(t), 0, np.cos(t))
        p.spring(end + 0.32 * n, end + 0.74 * n, "g n", coils=3, half=3.5, lead=0.1)
    p.arrow((0, 1.5, 0), (0, 2.1, 0), "m w", both=False)
    p.arc((0, 1.75, 0), Y, Z, 0.35, 250)
    p.text((0, 1.7, -0.75), "e: 3 displacements, 3 rotations", "m")
    p.text((0, -0.95, 0.95), "A", "a")
    p.text((0, -1.6, 0.35), "B", "b")
    return p


def point_force():
    p = Picture("Force and torque at a marker, dead or following", centre=(0, 0, 0.2))
    p.box(O, (0.7, 2.0, 0.6), "a", turn((1, 0, 0.3), 15))
    m = turn((1, 0, 0.3), 15) @ vec(0, 1.0, 0)
    R = turn((1, 0, 0.3), 15)
    p.dot(m, "a", 4)
    p.frame(m, R, "", "a", 0.6, beside={"y": (2, 6)})
    p.arrow(m + vec(0, 0, 1.3), m + vec(0, 0, 0.12), "f w")
    p.text(m + vec(0, 0, 1.42), "F, dead", "f")
    p.arrow(m + 1.2 * R[:, 1] + 0.9 * R[:, 2], m + 0.15 * R[:, 1] + 0.1 * R[:, 2], "f w d")
    p.text(m + 1.35 * R[:, 1] + 1.0 * R[:, 2], "R F, following", "f", dx=14)
    p.arc(m + 0.1 * X, X, Z, 0.42, 240, "f w", label="")
    p.text(m + vec(0.3, 0.1, -0.65), "T", "f")
    return p


def distributed_load():
    p = Picture("A load spread over nodes, and the forces on means that do the same work", centre=(0, 0, 0.25))
    for y in np.linspace(-1.5, 0.9, 5):
        p.box((0, y + 0.3, 0), (0.8, 0.6, 0.3), "a")
    for i, y in enumerate(np.linspace(-1.5, 1.5, 6)):
        size = 0.25 + 0.5 * np.sin(np.pi * (i + 0.5) / 6.5) ** 2
        for x in (-0.4, 0.4):
            q = vec(x, y, 0.15)
            p.dot(q, "a", 2.5)
            p.arrow(q + size * Z, q + 0.05 * Z, "f", size=6)
    mean = vec(0, 0.1, 0.15)
    p.arrow(mean + 1.5 * Z, mean + 0.12 * Z, "f w", size=11)
    p.text(mean + 1.62 * Z, "Σ |f_b| e_b", "f")
    p.text((0, -1.75, 0.75), "f_i", "f")
    return p


def line_load():
    p = Picture("Loads along two bent beams: dead ones keep their direction, following ones turn with the sections", centre=(0, 0, 0.1))

    def bent(y, s):  # a quarter of a circle in the plane x = y, and the direction across it
        angle = 1.1 * s / 1.6
        return vec(0, y + 1.45 * np.sin(angle), 0.9 - 1.45 * (1 - np.cos(angle))), vec(0, np.sin(angle), np.cos(angle))

    for y, name in ((-2.0, "f, dead"), (0.45, "R f, following")):
        p.line([bent(y, s)[0] for s in np.linspace(0, 1.6, 17)], "a w")
        p.box((0, y - 0.06, 0.9), (0.5, 0.12, 0.7), "g")
        tops = []
        for s in np.linspace(0.4, 1.6, 7):
            q, across = bent(y, s)
            size = (0.15 + 0.35 * (s - 0.4)) * (Z if y < 0 else across)
            tops.append(q + size + 0.08 * across)
            p.arrow(tops[-1], q + 0.05 * across, "f", size=6)
        p.line(tops, "f")
        p.text((0, y + 0.75, 1.75), name, "f")
    p.text((0, -1.72, 0.55), "from", "m", small=True)
    p.text((0, -0.7, -0.08), "to", "m", small=True)
    return p


def user_force():
    p = Picture("A wrench by a function of time and of the marker's motion", centre=(0, 0, 0.2))
    R = turn((1, 0.2, 0.3), 20)
    p.box(O, (0.8, 1.4, 0.6), "a", R)
    m = R @ vec(0, 0.7, 0)
    p.dot(m, "a", 4)
    p.arrow(m, m + vec(0, 1.0, 0.55), "f w", label="force, torque", beside=(34, -4))
    p.arrow(m, m + vec(0, 0.9, -0.45), "m", label="v", beside=(4, 2))
    p.text((0, 0.5, -0.95), "law(t, p, R, v, ω)", "g")
    return p


def pid_controller():
    p = flat("PID controller: from the error to the force on a coordinate", scale=62)
    p.scale = 62

    def block(x, y, w, text, style="g"):
        p.line([vec(x, y - 0.25, 0), vec(x + w, y - 0.25, 0), vec(x + w, y + 0.25, 0), vec(x, y + 0.25, 0)], style + "f", True)
        p.text(vec(x + w / 2, y, 0), text, style)

    p.arrow(vec(-2.9, 0, 0), vec(-2.25, 0, 0), "g")
    p.text(vec(-2.75, 0.2, 0), "w(t)", "g")
    p.circle(vec(-2.1, 0, 0), Z, 0.14, "g")
    p.line([vec(-1.96, 0, 0), vec(-1.5, 0, 0)], "g")
    p.text(vec(-1.72, 0.17, 0), "e", "g")
    for y, text in ((0.75, "k_p e"), (0, "k_i ∫ e dt"), (-0.75, "k_d ė")):
        p.line([vec(-1.5, 0, 0), vec(-1.5, y, 0)], "g")
        p.arrow(vec(-1.5, y, 0), vec(-1.15, y, 0), "g")
        block(-1.15, y, 1.3, text, "a")
        p.line([vec(0.15, y, 0), vec(0.5, y, 0), vec(0.5, 0, 0)], "g")
    p.arrow(vec(0.5, 0, 0), vec(0.85, 0, 0), "g")
    block(0.85, 0, 1.0, "|F| ≤ limit", "f")
    p.arrow(vec(1.85, 0, 0), vec(2.35, 0, 0), "f w")
    p.text(vec(2.1, 0.2, 0), "F", "f")
    block(2.35, 0, 1.0, "body", "b")
    p.line([vec(3.35, 0, 0), vec(3.7, 0, 0), vec(3.7, -1.3, 0), vec(-2.1, -1.3, 0)], "m")
    p.arrow(vec(-2.1, -1.3, 0), vec(-2.1, -0.14, 0), "m")
    p.text(vec(3.55, 0.2, 0), "x", "m")
    p.text(vec(-2.28, -0.28, 0), "−", "m")
    p.line([vec(1.35, 0.25, 0), vec(1.35, 1.2, 0), vec(-0.5, 1.2, 0)], "g n d")
    p.text(vec(0.55, 1.38, 0), "limited: the integral waits", "g", small=True)
    return p


PICTURES = {
    f.__name__: f
    for f in (
        spring_damper,
        coordinate_spring,
        coordinate_motor,
        coordinate_stop,
        joint_friction,
        bushing,
        point_force,
        distributed_load,
        line_load,
        user_force,
        pid_controller,
    )
}
