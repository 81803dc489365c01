"""Transmissions, rolling, drives, and the plug-ins' joints."""

import numpy as np

from canvas import Chart, Picture, turn, vec
from joints_pictures import E, O, X, Y, Z


def toothed(p, centre, radius, style, teeth, inner=False, phase=0.0):
    """A toothed circle in the xy plane."""
    points = []
    depth = 0.055 * (-1 if inner else 1)
    for i in range(4 * teeth):
        r = radius + (depth if i % 4 < 2 else -depth)
        t = 2 * np.pi * (i + 0.5) / (4 * teeth) + phase
        points.append(vec(centre) + r * vec(np.cos(t), np.sin(t), 0))
    p.line(points, style + "f", closed=True)


def flat(title, **more):
    """Seen along z: x to the right, y up."""
    return Picture(title, azimuth=-90, elevation=90, **more)


def gear_pair():
    p = flat("Gear pair: rolling pitch circles, the force in the pitch point")
    r_A, r_B = 0.8, 1.2
    b = vec(r_A + r_B, 0.0, 0)
    toothed(p, O, r_A, "a", 16)
    toothed(p, b, r_B, "b", 24, phase=np.pi / 24)
    p.circle(O, Z, r_A, "a n d")
    p.circle(b, Z, r_B, "b n d")
    p.line([-1.1 * X, b + 1.5 * X], "g n d")
    A, B = turn(Z, -55), turn(Z, 145)
    p.arrow(O, 0.62 * A[:, 0], "a", label="x_A")
    p.arrow(b, b + 0.85 * B[:, 0], "b", label="x_B")
    p.arc(O, Z, A[:, 0], 0.4, 55, "m", label="φ_A", beside=(4, 0))
    p.arc(b, Z, B[:, 0], 0.5, 35, "m", label="φ_B", beside=(-6, 0))
    p.dot(O, "a")
    p.dot(b, "b")
    pitch = r_A * X
    p.dot(pitch, "f", 4)
    p.arrow(pitch, pitch + 0.6 * Y, "f w", both=False)
    p.arrow(pitch, pitch - 0.6 * Y, "f w")
    p.dimension(O, -r_A * Y, "r_A", beside=(-13, 0))
    p.dimension(b, b - r_B * Y, "r_B", beside=(14, 0))
    p.text(b + vec(0.9, -0.16, 0), "line of centres", "g", small=True)
    return p


def rack_and_pinion():
    p = flat("Rack and pinion: A rolls on B, which runs along its x axis")
    r = 0.8
    pinion = vec(0.4, r, 0)
    toothed(p, pinion, r, "a", 16, phase=-np.pi / 2 + np.pi / 16 - np.pi / 64)
    p.circle(pinion, Z, r, "a n d")
    teeth = [vec(-1.9, -0.35, 0)]
    for i in range(12):
        x = -1.9 + i * 0.314
        teeth += [vec(x, -0.055, 0), vec(x + 0.157, -0.055, 0), vec(x + 0.157, 0.055, 0), vec(x + 0.314, 0.055, 0)]
    teeth += [vec(-1.9 + 12 * 0.314, -0.35, 0)]
    p.line(teeth, "bf", closed=True)
    b = vec(-1.4, -0.2, 0)
    p.arrow(b, b + 0.8 * X, "b", label="x_B", beside=(4, 3))
    p.arrow(b, b + 0.75 * Y, "b", label="y_B")
    A = turn(Z, 40)
    p.arrow(pinion, pinion + 0.62 * A[:, 0], "a", label="x_A")
    p.line([pinion, pinion + 0.62 * X], "g n d")
    p.arc(pinion, Z, X, 0.42, 40, "m", label="φ", beside=(3, 0))
    p.dot(pinion, "a")
    p.dot(b, "b")
    p.dot(0.4 * X, "f", 4)
    p.arrow(0.4 * X, 1.0 * X, "f w")
    p.arrow(0.4 * X, -0.2 * X, "f w")
    p.dimension(pinion, pinion + r * Y, "r", beside=(-9, 0))
    p.dimension(b - 0.45 * Y, vec(pinion[0], b[1] - 0.45, 0), "x_B · (p_A − p_B)", beside=(0, 13))
    return p


def rolling_disc():
    p = Picture("Rolling disc: it touches the plane and does not slip", elevation=24, centre=(0, 0, 0.4))
    p.box((0, 0, -0.05), (2.8, 3.6, 0.1), "a")
    r, lean = 0.85, 20
    B = turn(X, lean) @ np.column_stack([Z, X, Y])  # axle z_B along y, leaning
    axle = B[:, 2]
    u = Z - (Z @ axle) * axle
    u = u / np.linalg.norm(u)
    centre = vec(0, 0.35, 0) + r * u
    p.circle(centre, axle, r, "b", fill=True)
    p.arrow(centre, centre + 1.0 * axle, "b", label="a = z_B", beside=(24, 4))
    p.dot(centre, "b")
    touch = centre - r * u
    p.dot(touch, "m", 4)
    p.text(touch, "c", "m", dx=10, dy=8)
    p.dimension(centre, touch, "r u", beside=(-17, -2))
    p.frame((0.8, -1.1, 0), E, "A", "a", 0.8, beside={"y": (2, 9)})
    p.text((0.8, -1.1, 0.8), "n =", "a", dx=-25, dy=-11)
    p.arrow(touch, touch + vec(1.0, 0, 0), "m w")
    p.arc(centre, axle, -B[:, 0], 1.0, 60, "m w")
    return p


def coordinate_coupling():
    p = flat("Coordinate coupling: a belt ties two angles")
    a, b, r_a, r_b = O, vec(2.4, 0.2, 0), 0.4, 0.85
    p.circle(a, Z, r_a, "a", fill=True)
    p.circle(b, Z, r_b, "b", fill=True)
    d = b - a
    length = np.linalg.norm(d)
    along = np.arctan2(d[1], d[0])
    slope = np.arcsin((r_b - r_a) / length)
    for side in (1, -1):
        t = along + side * (np.pi / 2 + slope)
        n = vec(np.cos(t), np.sin(t), 0)
        p.line([a + r_a * n, b + r_b * n], "g w")
    A, B = turn(Z, 65), turn(Z, 26)
    for centre, R, radius, style, degrees, name in ((a, A, 0.4, "a", 65, "x_1"), (b, B, 0.7, "b", 26, "x_2")):
        p.line([centre, centre + radius * X], "g n d")
        p.arrow(centre, centre + radius * R[:, 0], style)
        p.arc(centre, Z, X, 0.72 * radius, degrees, "m")
        p.dot(centre, style)
        p.text(centre + vec(0, -radius - (0.28 if style == "a" else 0.4), 0), name, "m")
    p.text(vec(1.15, -1.1, 0), "c_1 x_1 + c_2 x_2 = as drawn", "g")
    return p


def coordinate_drive():
    p = Picture("Coordinate drive: an angle follows a law of time", centre=(0, 0, 0.3))
    B = turn(Z, 55)
    p.box((0, 0, -0.35), (0.9, 0.9, 0.7), "a")
    p.text((0.45, 0.05, -0.4), "M", "f")
    p.cylinder((0, 0, 0), (0, 0, 0.35), 0.14, "b")
    p.bar(B @ vec(-0.2, 0, 0.25), B @ vec(1.0, 0, 0.25), 0.2, "b", Z)
    p.frame((0, 0, 0.35), E, "A", "a", 1.15, skip="yz")
    p.frame((0, 0, 0.35), B, "B", "b", 1.5, skip="yz")
    p.arc((0, 0, 0.35), Z, X, 0.95, 55, "m w")
    p.text((0.9, 0.95, 0.0), "x = f(t)", "m", anchor="start")
    p.arrow((0, 0, 0.35), (0, 0, 1.0), "a", label="z_A")
    p.arc((0, 0, 0.7), Z, X, 0.35, 280, "f w", label="")
    p.text((0, 0.62, 0.95), "−λ", "f")
    return p


def motion_laws():
    p = Chart("Motion laws: value over time", (0, 1), (0, 1.1), "t, s", "f(t)")
    t = np.linspace(0, 1, 121)
    p.grid([0, 0.25, 0.5, 0.75, 1], [0, 0.5, 1])
    s = np.clip((t - 0.2) / 0.6, 0, 1)
    p.curve(t, 0.1 + 0.8 * t, 0)
    p.curve(t, 0.5 + 0.3 * np.sin(4 * np.pi * t), 1)
    p.curve(t, 10 * s**3 - 15 * s**4 + 6 * s**5, 2)
    p.curve(t, 0 * t + 0.2, 4)
    for line, (text, x, y) in enumerate(
        (("ramp(0.1, 0.8)", 0.85, 0.62), ("harmonic(0.3, 4π, 0, 0.5)", 0.25, 0.87), ("smooth step(0, 1, 0.2, 0.8)", 0.76, 1.05))
    ):
        p.key(text, line, x, y)
    p.key("constant(0.2)", 4, 0.87, 0.26)
    return p


def cam_follower():
    p = flat("Cam follower: the roller's centre keeps its radius from the profile")
    t = np.linspace(0, 2 * np.pi, 73)[:-1]
    radius = 0.75 + 0.3 * np.exp(-((t - 1.9) ** 2) / 0.35)
    curve = [r * vec(np.cos(x), np.sin(x), 0) for r, x in zip(radius, t)]
    p.line(curve, "af", closed=True)
    i = 17  # where the roller touches
    tangent = curve[i + 1] - curve[i - 1]
    n = vec(tangent[1], -tangent[0], 0) / np.linalg.norm(tangent)
    rho = 0.28
    b = curve[i] + rho * n
    p.circle(b, Z, rho, "b", fill=True)
    p.line([b, b + 1.0 * Y], "b w")
    A = turn(Z, -20)
    p.arrow(O, 0.6 * A[:, 0], "a", label="x_A")
    p.arrow(O, 0.6 * A[:, 1], "a", label="y_A", beside=(-12, 6))
    p.dot(O, "a")
    p.dot(b, "b")
    p.text(b, "p_B", "b", dx=18)
    p.dimension(curve[i], b, "ρ", offset=(-20, 0), beside=(-8, 0))
    p.arrow(curve[i], curve[i] - 0.5 * n, "f w", label="−λ n", beside=(16, 4))
    p.arc(O, Z, X, 1.2, 50, "m w")
    p.text(vec(-0.45, -0.3, 0), "profile", "a", small=True)
    return p


PICTURES = {
    f.__name__: f
    for f in (
        gear_pair,
        rack_and_pinion,
        rolling_disc,
        coordinate_coupling,
        coordinate_drive,
        motion_laws,
        cam_follower,
    )
}
