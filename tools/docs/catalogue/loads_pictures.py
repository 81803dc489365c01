"""Loads of the air on a section, and the loads over a cut."""

import numpy as np

from canvas import Picture, turn, vec

X, Y, Z = np.eye(3)


def airfoil_strip():
    p = Picture("Lift, drag and moment on a section", centre=(0, -0.1, 0.1), azimuth=0, elevation=0)
    R = turn(X, 12)  # leading edge to the right, nose up
    s = (1 - np.cos(np.linspace(0, np.pi, 15))) / 2
    half = 0.6 * 3 * (0.2969 * np.sqrt(s) - 0.126 * s - 0.3516 * s**2 + 0.2843 * s**3 - 0.1036 * s**4)
    outline = [vec(0, 0.75 - 3 * a, h) for a, h in zip(s, half)] + [vec(0, 0.75 - 3 * a, -h) for a, h in zip(s, half)][::-1]
    p.line([R @ q for q in outline], "af", closed=True)
    p.line([R @ vec(0, -2.3, 0), R @ vec(0, 1.9, 0)], "g n d")
    p.line([vec(0, 0, 0), vec(0, 1.9, 0)], "g n d")
    p.arc((0, 0, 0), X, Y, 1.75, 12, "m", head=False)
    p.text(vec(0, 2.0, 0.18), "α", "m")
    p.dot((0, 0, 0), "f", 4)
    rear = R @ vec(0, -1.5, 0)
    p.dot(rear, "m", 3.5)
    p.text(rear, "¾ c", "m", dy=22, small=True)
    p.arrow((0, 2.25, -0.55), (0, 1.25, -0.55), "m w", label="u", beside=(0, -14))
    p.arrow((0, 0, 0), (0, 0, 1.45), "f w", label="lift", beside=(22, 2))
    p.arrow((0, 0, 0), (0, -0.8, 0), "f w", label="drag", beside=(-8, -12))
    p.arc((0, 0, 0), X, (0, 0.6, -0.8), 0.62, 75, "f", label="M", beside=(4, 4))
    return p


def cut_load():
    p = Picture("Force and moment over a cut, on the part that is cut off", centre=(0, 0, 0.1), scale=58)
    for first, style in ((-2.1, "a"), (1.5, "b")):
        for i in (0, 1, 2):
            p.box((0, first + 0.5 * i, 0), (0.7, 0.5, 0.5), style)
    cut = vec(0, -0.85, 0)
    for x in (-0.35, 0.35):
        for z in (-0.25, 0.25):
            p.dot(cut + vec(x, 0, z), "a", 3)
    p.arrow(cut, cut + 1.1 * Y, "f w", label="n_1")
    p.arrow(cut, cut - 1.5 * X, "f w", label="n_2")
    p.arrow(cut, cut + 1.15 * Z, "f w", label="n_3")
    p.arc(cut + 0.55 * Y, Y, Z, 0.3, 250, "f", label="m_1", beside=(14, 16))
    p.text((0, -1.6, -0.75), "part", "a")
    p.text((0, 2.0, -0.75), "rest", "b")
    return p


PICTURES = {"airfoil_strip": airfoil_strip, "cut_load": cut_load}
