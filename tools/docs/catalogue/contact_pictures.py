"""Contact: shapes, frames of a point, laws."""

import numpy as np

from canvas import Chart, Picture, vec
from joints_pictures import Z
from transmissions_pictures import flat


def contact_point():
    p = flat("A contact point: gap and normal between two surfaces, velocity across, cone of friction")
    t = np.linspace(0.15, np.pi - 0.15, 40)
    p.line([vec(1.8 * np.cos(s), -1.95 + 1.5 * np.sin(s), 0) for s in t], "a w")
    p.line([vec(1.5 * np.cos(s), 1.75 - 1.5 * np.sin(s), 0) for s in t], "b w")
    p.text(vec(-1.15, -1.05, 0), "A", "a")
    p.text(vec(-1.0, 1.25, 0), "B", "b")
    p.line([vec(0, -0.45, 0), vec(0, 0.25, 0)], "g n d")
    p.dot(vec(0, -0.1, 0), "g", 4)
    p.arrow(vec(0, -0.1, 0), vec(0, 0.75, 0), "g", label="n")
    p.dimension(vec(0, -0.45, 0), vec(0, 0.25, 0), "gap", offset=(-60, 0), beside=(-20, 0))
    p.arrow(vec(0, -0.1, 0), vec(0.85, -0.1, 0), "m w", label="v across", beside=(28, 0))
    for side in (1, -1):
        p.line([vec(0, 0.25, 0), vec(0.42 * side, 1.35, 0)], "f n")
    p.line([vec(0.42 * np.cos(s), 1.35 + 0.1 * np.sin(s), 0) for s in np.linspace(0, 2 * np.pi, 24)], "f n", True)
    p.arrow(vec(0, 0.25, 0), vec(-0.42, 1.35, 0), "f w", label="r", beside=(-4, -2))
    p.text(vec(0.75, 1.35, 0), "μ r_n", "f", small=True)
    return p


def shapes():
    p = Picture("Shapes: sphere, box, cylinder, capsule, cone, hull, half space, mesh", scale=44)
    p.scale = 46
    p.sphere((0, -3.2, 1.0), 0.5, "a")
    p.text((0, -3.2, 0.05), "sphere", "g", small=True)
    p.box((0, -1.6, 1.0), (0.9, 0.8, 0.8), "a")
    p.text((0, -1.6, 0.05), "box", "g", small=True)
    p.cylinder((0, 0, 0.6), (0, 0, 1.5), 0.42, "a")
    p.text((0, 0, 0.05), "cylinder", "g", small=True)
    x, y = p.at((0, 1.6, 1.05))
    s = p.scale
    outline = [(x + 0.36 * s * np.cos(t), y - 0.3 * s - 0.36 * s * np.sin(t)) for t in np.linspace(0, np.pi, 14)]
    outline += [(x - 0.36 * s * np.cos(t), y + 0.3 * s + 0.36 * s * np.sin(t)) for t in np.linspace(0, np.pi, 14)]
    p.trace(outline, "af", True)
    p.text((0, 1.6, 0.05), "capsule", "g", small=True)
    c = vec(0, 3.2, 0.6)
    p.circle(c, Z, 0.5, "a", fill=True)
    for side in (1, -1):
        p.line([c + 0.95 * Z, c + side * 0.5 * p.right], "a")
    p.text((0, 3.2, 0.05), "cone", "g", small=True)
    hull = [vec(0, -3.6, -1.7), vec(0, -3.0, -1.85), vec(0, -2.7, -1.3), vec(0, -3.0, -0.8), vec(0, -3.55, -1.0)]
    p.line(hull, "af", True)
    for q in (hull[0], hull[2], hull[4]):
        p.line([q, vec(0, -3.15, -1.35)], "a n")
    p.text((0, -3.2, -2.2), "convex hull", "g", small=True)
    p.box((0, -1.5, -1.6), (0.9, 1.3, 0.05), "a")
    p.arrow((0, -1.5, -1.55), (0, -1.5, -0.8), "a", label="z")
    p.text((0, -1.5, -2.2), "half space", "g", small=True)
    grid = [[vec(0.45 - 0.45 * i, -0.5 + 0.5 * j, -1.5 + 0.25 * np.sin(1.7 * j + 1.2 * i)) for j in range(5)] for i in range(3)]
    for i in range(3):
        p.line(grid[i], "a")
    for j in range(5):
        p.line([grid[i][j] for i in range(3)], "a")
    for i in range(2):
        for j in range(4):
            p.line([grid[i][j], grid[i + 1][j + 1]], "a n")
    p.text((0, 0.5, -2.2), "mesh, height field", "g", small=True)
    y = np.linspace(2.2, 4.0, 8)
    top = [vec(0, v, -1.2 + 0.12 * (v - 2.2) ** 2) for v in y]
    low = [vec(0, v, -1.6 + 0.12 * (v - 2.2) ** 2) for v in y]
    p.line(top, "b")
    p.line(low, "b w")
    for a, b in zip(top, low):
        p.line([a, b], "b n")
        p.dot(b, "b", 2.5)
    p.text((0, 3.1, -2.2), "surface of nodes", "g", small=True)
    return p


def damping_number(e):
    """x = D v with (1 + e) x = ln((1 + x) / (1 - e x)), as joints/contact/laws.cpp finds it."""
    x = min(1.6 * (1 - e), 1 - 1e-9) / e
    for _ in range(60):
        f = np.log1p(x) - np.log1p(-e * x) - (1 + e) * x
        slope = 1 / (1 + x) + e / (1 - e * x) - (1 + e)
        x -= f / slope
    return x


def contact_laws():
    """Force over depth of one impact: m = 1 kg, v = 1 m/s, k so that the elastic depth is 1 mm, restitution 0.5."""
    p = Chart("Compliant impact with restitution 0.5: force over depth by each dissipation", (0, 1.05), (0, 1.45), "depth, of the elastic one", "force, of the elastic one")
    p.grid([0, 0.25, 0.5, 0.75, 1], [0, 0.5, 1])
    e, n = 0.5, 1.5
    k = (n + 1) / 2
    peak = k
    numbers = (("elastic", 0.0), ("Hunt & Crossley", 1.5 * (1 - e)), ("Flores", 1.6 * (1 - e) / e), ("exact", damping_number(e)))
    for line, (name, D) in enumerate(numbers):
        d, v, h = 0.0, 1.0, 5e-4
        ds, fs = [0.0], [0.0]

        def rate(d, v):
            return -k * max(d, 0) ** n * max(0.0, 1 + D * v)

        while len(ds) < 12000:
            a1 = rate(d, v)
            a2 = rate(d + h / 2 * v, v + h / 2 * a1)
            a3 = rate(d + h / 2 * v + h * h / 4 * a1, v + h / 2 * a2)
            a4 = rate(d + h * v + h * h / 2 * a2, v + h * a3)
            d, v = d + h * v + h * h / 6 * (a1 + a2 + a3), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
            if d <= 0:
                break
            ds.append(d)
            fs.append(-rate(d, v) / peak)
        p.curve(ds, fs, line)
        p.key(f"{name}: r = {-v:.2f}", line, 0.27, 1.37 - 0.12 * line)
    return p


def friction_laws():
    p = Chart("Friction force over normal force: regularised and with bristles, at the start of sliding", (0, 40), (0, 0.45), "way, µm (at 10 mm/s)", "force / N")
    p.grid([0, 10, 20, 30, 40], [0, 0.1, 0.2, 0.3, 0.4])
    speed, kinetic, still, sigma, stribeck, creep = 0.01, 0.3, 0.3, 5e4, 1e-3, 1e-3
    way = np.linspace(0, 40e-6, 200)
    p.curve(way * 1e6, 0 * way + kinetic * np.tanh(3 * speed / creep), 1)
    z = kinetic / sigma * (1 - np.exp(-way * sigma / kinetic))
    p.curve(way * 1e6, sigma * z, 0)
    p.key("bristles: σ_0 z, a spring at first", 0, 24, 0.21)
    p.key("regularised: at once μ tanh(3 v/v_c)", 1, 24, 0.35)
    return p


def impulses():
    p = flat("Rigid surfaces: complementarity along the normal, Coulomb's cone across")
    p.arrow(vec(-2.6, 0, 0), vec(-0.7, 0, 0), "g", label="u_n", beside=(8, 0))
    p.arrow(vec(-2.4, -0.3, 0), vec(-2.4, 1.4, 0), "g", label="r_n")
    p.line([vec(-2.4, 1.15, 0), vec(-2.4, 0, 0), vec(-0.95, 0, 0)], "f w")
    p.text(vec(-1.5, -0.35, 0), "pushes, or parts", "g", small=True)
    c = vec(1.3, 0.45, 0)
    p.circle(c, Z, 0.85, "f")
    p.dot(c, "g", 3)
    p.arrow(c, c + 0.85 * vec(np.cos(2.5), np.sin(2.5), 0), "f w", label="r_t", beside=(-4, -4))
    d = vec(np.cos(2.5 + np.pi), np.sin(2.5 + np.pi), 0)
    p.arrow(c, c + 1.25 * d, "m w", label="u_t", beside=(6, 4))
    p.dot(c + vec(0.25, 0.35, 0), "f", 3)
    p.text(c + vec(0.25, 0.55, 0), "sticks", "f", small=True)
    p.dimension(c, c + vec(-0.5, -0.69, 0), "μ r_n", beside=(-18, 6))
    p.text(c + vec(0, -1.15, 0), "slides: against u_t, at the rim", "g", small=True)
    return p


PICTURES = {
    f.__name__: f for f in (contact_point, shapes, contact_laws, friction_laws, impulses)
}
