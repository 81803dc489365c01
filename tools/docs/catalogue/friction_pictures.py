"""Friction in joints: charts of its laws."""

import numpy as np

from canvas import Chart


def joint_bristles():
    p = Chart("Bristles: force over the way, to and fro, then beyond breakaway", (-0.5, 7), (-0.85, 1.1), "x / δ", "F / (μ_s N)")
    p.grid([0, 1, 2, 3, 4, 5, 6, 7], [-0.75, -0.5, 0, 0.5, 0.75, 1])
    share, slow, fast = 0.9, 1.0, 0.75  # a; μ(v) / μ_s of a slow and of a fast slide
    ways = (([0.6, -0.5, 0.6, -0.5, 4, 3.2, 7], slow, "slow: breaks away at μ_s N"), ([5, 4, 7], fast, "fast: slides by μ_k N"))
    for line, (turns, level, text) in enumerate(ways):
        x, z = [0.0], [0.0]
        for end in turns:
            way = np.linspace(x[-1], end, 400)
            for step in np.diff(way):
                bent = abs(z[-1]) / level
                wave = 0.5 + 0.5 * np.sin(np.pi * (bent - (1 + share) / 2) / (1 - share))
                alpha = 0 if bent <= share else 1 if bent >= 1 else wave
                x.append(x[-1] + step)
                z.append(z[-1] + step - alpha * max(step * np.sign(z[-1]), 0) * z[-1] / level)
        p.curve(np.array(x), np.array(z), line)
        p.key(text, line, 3.6, -0.3 - 0.16 * line)
    return p


def joint_coulomb_friction():
    p = Chart("Set-valued: any force up to μ_s N at rest, one where it slides", (-1, 1), (-1.2, 1.2), "s", "-F / (μ_s N)")
    p.grid([-1, -0.5, 0, 0.5, 1], [-1, -0.75, 0, 0.75, 1])
    s = np.linspace(0, 1, 200)
    kinetic = 0.75
    level = kinetic + (1 - kinetic) * np.exp(-((4 * s) ** 2))
    p.curve(np.concatenate([-s[::-1], s]), np.concatenate([-level[::-1], level]), 0)
    p.key("set-valued: sticks", 0, 0.5, -0.2)
    way = np.linspace(-1, 1, 400)
    smooth = (kinetic + (1 - kinetic) * np.exp(-((4 * way) ** 2))) * np.tanh(way * 15)
    p.curve(way, smooth, 1)
    p.key("smoothed: creeps", 1, 0.5, -0.42)
    return p


PICTURES = {"joint_bristles": joint_bristles, "joint_coulomb_friction": joint_coulomb_friction}
