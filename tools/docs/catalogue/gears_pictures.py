"""Gears with teeth, chains."""

import numpy as np

from canvas import vec
from joints_pictures import X, Y, Z
from transmissions_pictures import flat

ALPHA = np.radians(20)


def involute(angle):
    return np.tan(angle) - angle


def teeth(p, centre, z, module, middles, style):
    """Teeth of an external gear, the middle of each at an angle."""
    r, outline = module * z / 2, []
    base = r * np.cos(ALPHA)
    for middle in middles:
        flank = []
        for radius in (r - 1.25 * module, base, r - 0.3 * module, r, r + 0.5 * module, r + module):
            at = np.arccos(min(1, base / max(radius, base)))
            flank.append((radius, np.pi / 2 / z + involute(ALPHA) - involute(at)))
        for radius, half in flank:
            outline.append(vec(centre) + radius * vec(np.cos(middle - half), np.sin(middle - half), 0))
        for radius, half in reversed(flank):
            outline.append(vec(centre) + radius * vec(np.cos(middle + half), np.sin(middle + half), 0))
    p.line(outline, style)


def toothed_gear_pair():
    p = flat("Toothed gears: two flanks press on each other along the line of action")
    m, z_A, z_B = 0.3, 16, 22
    r_A, r_B = m * z_A / 2, m * z_B / 2
    a, b = -r_A * X, r_B * X
    # A pair touches in the pitch point: the middle of A's tooth is half a thickness behind.
    at_A, at_B = -np.pi / 2 / z_A, np.pi - np.pi / 2 / z_B
    teeth(p, a, z_A, m, [at_A + 2 * np.pi * i / z_A for i in range(-2, 4)], "a")
    teeth(p, b, z_B, m, [at_B + 2 * np.pi * i / z_B for i in range(-3, 4)], "b")
    for centre, r, style, way in ((a, r_A, "a n d", 0), (b, r_B, "b n d", np.pi)):
        for radius in (r, r * np.cos(ALPHA)):
            arc = [vec(centre) + radius * vec(np.cos(way + t), np.sin(way + t), 0) for t in np.linspace(-0.75, 0.75, 16)]
            p.line(arc, style)
    n = np.cos(ALPHA) * Y + np.sin(ALPHA) * X
    p.line([-r_A * np.sin(ALPHA) * n, r_B * np.sin(ALPHA) * n], "g n d")
    p.line([-1.3 * Y, 1.6 * Y], "g n d")
    p.dot(vec(0, 0, 0), "f", 3)
    p.arrow(vec(0, 0, 0), 0.8 * n, "f w", label="F on B", beside=(24, -2))
    p.text(-1.45 * X - 0.55 * Y, "A drives", "a", small=True)
    p.text(1.45 * X - 0.55 * Y, "B", "b", small=True)
    p.text(1.5 * Y + 0.25 * X, "α", "g")
    p.text(-r_A * np.sin(ALPHA) * n - 0.85 * Y - 0.3 * X, "line of action", "g", small=True)
    return p


PICTURES = {f.__name__: f for f in (toothed_gear_pair,)}
