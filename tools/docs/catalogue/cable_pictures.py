"""The cable: nodes, straight elements, what they carry."""

import numpy as np

from bodies_pictures import world
from canvas import Picture, vec


def cable():
    p = Picture("Cable: nodes in world axes, straight elements, curvature at inner nodes", centre=(0, 0, 0.2))
    o = world(p)
    nodes = [vec(0, y, -0.15 + 0.42 * (y + 0.1) ** 2) for y in np.linspace(-1.45, 1.4, 8)]
    p.box(nodes[0] + vec(0, 0, 0.09), (0.3, 0.3, 0.1), "g")
    p.line(nodes, "a w")
    for node in nodes:
        p.dot(node, "b", 4)
    p.arrow(o, nodes[2], "m", size=8)
    p.text(nodes[2], "x_i", "m", dx=-4, dy=22)
    t = nodes[5] - nodes[4]
    p.line([nodes[5], nodes[5] + 1.3 * t], "g n d")
    p.text(nodes[5] + 1.25 * t, "θ", "g", dx=16, dy=-4)
    p.text(0.5 * (nodes[3] + nodes[4]), "N = EA ε", "f", dy=22, small=True)
    p.arrow(nodes[7], nodes[7] + 0.5 * (nodes[7] - nodes[6]) / np.linalg.norm(nodes[7] - nodes[6]), "f", label="f")
    return p


PICTURES = {"cable": cable}
