"""Bearings: a ball between its grooves, rollers under load, the film of a journal bearing."""

import numpy as np

from canvas import turn, vec
from joints_pictures import O, X, Y, Z
from transmissions_pictures import flat


def groove(p, centre, radius, towards, style):
    """An arc of 100 degrees about the direction, with the ring's body behind it."""
    t = np.radians(np.linspace(-50, 50, 15)) + np.arctan2(towards[1], towards[0])
    arc = [centre + radius * vec(np.cos(x), np.sin(x), 0) for x in t]
    behind = 0.45 * towards / np.linalg.norm(towards)
    p.line([*arc, arc[-1] + behind, arc[0] + behind], style + "f", closed=True)


def ball_bearing():
    p = flat("Ball bearing: a ball in the plane of its grooves", scale=78)
    r, ball, alpha = 1.24, 1.0, np.radians(32)
    d = vec(np.sin(alpha), np.cos(alpha), 0)
    inner, outer = (r - ball) * d, -(r - ball) * d  # the inner groove's centre lies outside
    groove(p, inner, r, -d, "a")
    groove(p, outer, r, d, "b")
    p.circle(O, Z, ball, "g")
    p.line([-1.75 * d, 1.75 * d], "g n d")
    p.line([O, 1.35 * Y], "g n d")
    p.arc(O, Z, d, 1.2, np.degrees(alpha), "m", label="α", beside=(4, -2))
    p.dot(inner, "a", 4)
    p.dot(outer, "b", 4)
    p.arrow(outer, inner, "m w")
    p.text(O + vec(0.22, -0.1, 0), "d", "m")
    p.arrow(inner, inner - r * d, "a n")
    p.text(-0.62 * d + vec(0.2, 0, 0), "r_i", "a")
    p.arrow(outer, outer + r * d, "b n")
    p.text(0.7 * d + vec(-0.2, 0.05, 0), "r_o", "b")
    p.arrow(-1.02 * d, -1.6 * d, "f w", label="Q", beside=(20, -8))
    p.arrow(vec(-1.9, -1.5, 0), vec(-1.2, -1.5, 0), "g", label="z")
    p.arrow(vec(-1.9, -1.5, 0), vec(-1.9, -0.8, 0), "g", label="radial", beside=(8, 0))
    p.text(vec(1.35, -1.15, 0), "inner ring", "a", small=True)
    p.text(vec(-1.25, 1.2, 0), "outer ring", "b", small=True)
    return p


def roller_bearing():
    p = flat("Rolling bearing seen along its axis: elements at their azimuths share a radial load", scale=66)
    pitch, roller, count, turned = 1.2, 0.22, 12, -90 + 8
    p.circle(O, Z, pitch + roller, "b", count=48)
    p.circle(O, Z, pitch + roller + 0.22, "b", count=48)
    p.circle(O, Z, pitch - roller, "a")
    p.circle(O, Z, pitch - roller - 0.3, "a")
    for j in range(count):
        out = turn(Z, turned + 360 * j / count)[:, 0]
        p.circle(pitch * out, Z, roller, "g", count=16)
        load = max(0.0, -out[1] - 0.25)
        if load > 0:
            p.arrow((pitch + roller) * out, (pitch + roller - 0.75 * load) * out, "f w")
    p.arrow(O, 0.55 * X, "b", label="x", beside=(0, 4))
    p.arrow(O, 0.55 * Y, "b", label="y")
    p.arrow(O, -0.6 * Y, "f w", label="F", beside=(14, -8))
    p.arc(O, Z, X, pitch + roller + 0.42, 38, "m", label="ψ", beside=(4, 0))
    p.line([O, 1.9 * turn(Z, 38)[:, 0]], "m n d")
    p.arc(O, Z, turn(Z, 120)[:, 0], 0.75, 50, "m w")
    p.text(0.5 * turn(Z, 150)[:, 0], "φ", "m")
    return p


def journal_bearing():
    p = flat("Journal bearing: the film between journal and bush", scale=80)
    radius, bush, angle = 1.0, 1.36, np.radians(-50)
    line = vec(np.cos(angle), np.sin(angle), 0)
    centre = 0.22 * line
    p.circle(O, Z, bush, "b", count=48)
    p.circle(O, Z, bush + 0.16, "b", count=48)
    p.circle(centre, Z, radius, "a", fill=True, count=48)
    # Pressure over the half of the film that narrows in the sense of ω.
    for i in range(1, 10):
        t = np.radians(18 * i)
        n = turn(Z, np.degrees(t) - 180) @ line
        size = 0.035 * np.sin(t) / (1 + 0.62 * np.cos(t)) ** 3
        p.arrow(centre + (radius + size + 0.02) * n, centre + (radius + 0.02) * n, "f n", size=4)
    p.dot(O, "b", 4)
    p.dot(centre, "a", 4)
    p.line([O, 1.75 * line], "g n d")
    p.line([O, -1.75 * Y], "g n d")
    p.arrow(O, centre, "m w")
    p.text(centre + vec(0.12, 0.12, 0), "e", "m")
    p.arc(O, Z, -Y, 1.62, 40, "m", label="attitude", beside=(4, 4))
    p.arrow(centre, centre - 0.75 * Y, "f w", label="W", beside=(-14, -12))
    p.arc(centre, Z, turn(Z, 130)[:, 0], 0.62, 70, "m w", label="ω", beside=(22, 0))
    p.arrow(O, 0.5 * X, "b", label="x", beside=(0, 2))
    p.arrow(O, 0.5 * Y, "b", label="y")
    p.text(vec(-1.0, 1.25, 0), "bush", "b", small=True, dx=-22)
    return p


PICTURES = {f.__name__: f for f in (ball_bearing, roller_bearing, journal_bearing)}
