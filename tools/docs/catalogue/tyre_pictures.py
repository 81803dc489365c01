"""Tyres: the contact with its axes and deflections, the Magic Formula's curves, cams over a step."""

import numpy as np

from canvas import Chart, Picture, turn, vec
from joints_pictures import E, X, Y, Z


def tyre():
    p = Picture("Tyre: contact of a cambered wheel with the road, its axes and what deflects", elevation=22, centre=(0, 0, 0.45))
    p.box((0, 0, -0.05), (3.0, 3.4, 0.1), "a")
    radius, loaded = 0.9, 0.82
    lean = turn(X, 12)
    axle = lean @ Y
    down = -(Z - (Z @ axle) * axle)
    down = down / np.linalg.norm(down)
    touch = vec(0, 0.3, 0)
    centre = touch - loaded * down
    p.circle(centre, axle, radius, "b", fill=True)
    p.arrow(centre, centre + 0.9 * axle, "b", label="z_B", beside=(14, 2))
    p.dot(centre, "b")
    p.dot(touch, "m", 4)
    p.dimension(centre, touch, "R_l", beside=(-15, 0))
    p.arrow(touch, touch + 1.3 * X, "f w", label="F_x", beside=(0, 11))
    p.arrow(touch, touch + 1.1 * Y, "f w", label="F_y", beside=(14, 6))
    p.arrow(touch, touch + 0.75 * Z, "f w", label="F_z", beside=(16, 4))
    p.arc(centre, axle, -X, 1.05, 55, "m w", label="Ω", beside=(-4, -6))
    p.frame((0.9, -1.2, 0), E, "A", "a", 0.7)
    return p


def bent(x, B, C, E_):
    return C * np.arctan(B * x - E_ * (B * x - np.arctan(B * x)))


def magic_formula():
    """The shape alone: B C D = 20, C = 1.6, D = 1, E = 0.4, and side forces of combined slip."""
    p = Chart("Longitudinal force over slip, and what it leaves of the side force", (0, 0.5), (0, 1.2), "slip κ", "force / (μ F_z)")
    p.grid([0, 0.1, 0.2, 0.3, 0.4, 0.5], [0, 0.5, 1])
    k = np.linspace(0, 0.5, 120)
    p.curve(k, np.sin(bent(k, 20 / 1.6, 1.6, 0.4)))
    p.curve(k, np.cos(np.arctan(7 * k) * 1.08) * 0.9, 1)
    p.key("F_x", 0)
    p.key("F_y, 5 degrees", 1)
    return p


def tyre_profile():
    a, b, c, length, height = 1.05 * 0.313, 1.1 * 0.313, 1.8, 0.1, 0.08
    p = Chart("Heights of the cams over a step, and the effective road between them", (-0.5, 0.3), (-0.01, 0.14), "x, m", "height, m")
    p.grid([-0.4, -0.2, 0, 0.2], [0, 0.04, 0.08, 0.12])
    x = np.linspace(-0.5, 0.3, 260)

    def cam(at):
        reach = np.clip(-at / a, 0, 1)
        return np.where(at >= 0, height, np.maximum(0, height - b + b * (1 - reach**c) ** (1 / c)))

    p.curve([-0.5, 0, 0.0001, 0.3], [0, 0, height, height], 4)
    p.curve(x, cam(x), 0)
    p.curve(x, 0.5 * (cam(x + length / 2) + cam(x - length / 2)), 1)
    p.key("step", 4)
    p.key("Z, one cam", 0)
    p.key("w, two cams", 1)
    return p


PICTURES = {f.__name__: f for f in (tyre, magic_formula, tyre_profile)}
