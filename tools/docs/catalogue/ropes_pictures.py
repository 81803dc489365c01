"""A rope over two pulleys, with the symbols of its law."""

import numpy as np

from canvas import turn, vec
from joints_pictures import O, Z
from transmissions_pictures import flat


def arc(centre, radius, start, end):
    return [vec(centre) + radius * vec(np.cos(t), np.sin(t), 0) for t in np.linspace(start, end, 25)]


def reeved_rope():
    p = flat("A rope over two pulleys: spans along tangents, wraps, tensions", scale=78, centre=(0.1, -0.35, 0))
    left, right, r, R = vec(-1.15, 0.35, 0), vec(1.05, -0.25, 0), 0.45, 0.6
    p.circle(left, Z, r, "a", fill=True)
    p.circle(right, Z, R, "b", fill=True)
    p.dot(left, "a", 3.5)
    p.dot(right, "b", 3.5)
    # Clockwise over the left wheel, counter-clockwise under the right one: a crossing tangent.
    d = right - left
    bearing, distance = np.arctan2(d[1], d[0]), np.hypot(d[0], d[1])
    direction = bearing + np.arcsin((-r - R) / distance)
    out, into = direction + np.pi / 2, direction - np.pi / 2
    start, end = vec(-1.6, -1.5, 0), vec(1.65, 0.95, 0)
    p.line([start, *arc(left, r, np.pi, out)], "m w")
    p.line([left + r * vec(np.cos(out), np.sin(out), 0), right + R * vec(np.cos(into), np.sin(into), 0)], "m w")
    p.line([*arc(right, R, into, 0), end], "m w")
    p.arrow(start + vec(0, 0.15, 0), start + vec(0, -0.35, 0), "f w", label="T_0", beside=(14, 4))
    p.arrow(end + vec(0, -0.15, 0), end + vec(0, 0.3, 0), "f w", label="T_2", beside=(14, -2))
    middle = 0.5 * (left + right) + vec(0.1, 0.22, 0)
    p.text(middle, "T_1", "f")
    p.text(left + vec(-0.05, 0.62, 0), "s_1", "m")
    p.text(right + vec(0.25, -0.78, 0), "s_2", "m")
    p.line([left, left + r * turn(Z, 125)[:, 0]], "a n")
    p.text(left + vec(0.0, -0.2, 0), "R < 0", "a", small=True)
    p.line([right, right + R * turn(Z, -60)[:, 0]], "b n")
    p.text(right + vec(-0.15, 0.2, 0), "R > 0", "b", small=True)
    p.text(O + vec(-0.35, -1.15, 0), "T_1 = T_0 e^{z μ α}", "g")
    return p


PICTURES = {f.__name__: f for f in (reeved_rope,)}
