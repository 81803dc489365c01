"""Control diagrams and hydraulics: schematics with the symbols of their equations."""

from canvas import vec
from joints_pictures import Z
from transmissions_pictures import flat


def block(p, x, y, width, text, style="g", height=0.5):
    h = height / 2
    p.line([vec(x, y - h, 0), vec(x + width, y - h, 0), vec(x + width, y + h, 0), vec(x, y + h, 0)], style + "f", True)
    p.text(vec(x + width / 2, y, 0), text, style)


def control_diagram():
    p = flat("A control diagram with states, and a sampled controller with delay", scale=62)
    p.text(vec(-2.85, 0.2, 0), "law", "g")
    p.arrow(vec(-3.1, 0, 0), vec(-2.3, 0, 0), "g")
    p.circle(vec(-2.15, 0, 0), Z, 0.14, "g")
    p.arrow(vec(-2.0, 0, 0), vec(-1.5, 0, 0), "g")
    p.text(vec(-1.75, 0.18, 0), "e", "g")
    block(p, -1.5, 0, 1.35, "z, blocks", "a")
    p.arrow(vec(-0.15, 0, 0), vec(0.3, 0, 0), "g")
    block(p, 0.3, 0, 0.75, "sat", "a")
    p.arrow(vec(1.05, 0, 0), vec(1.7, 0, 0), "f w")
    p.text(vec(1.35, 0.2, 0), "u", "f")
    block(p, 1.7, 0, 0.9, "body", "b")
    p.line([vec(2.6, 0, 0), vec(3.0, 0, 0), vec(3.0, -1.7, 0), vec(2.0, -1.7, 0)], "m")
    p.text(vec(2.85, 0.2, 0), "x, ẋ", "m")
    p.line([vec(3.0, -0.7, 0), vec(-2.15, -0.7, 0)], "m")
    p.arrow(vec(-2.15, -0.7, 0), vec(-2.15, -0.14, 0), "m")
    p.text(vec(-2.33, -0.28, 0), "−", "m")
    p.arrow(vec(2.2, -1.7, 0), vec(2.0, -1.7, 0), "m")
    block(p, 0.7, -1.7, 1.3, "every T", "a")
    p.arrow(vec(0.7, -1.7, 0), vec(0.25, -1.7, 0), "g")
    block(p, -1.25, -1.7, 1.5, "x_k → y_k", "a")
    p.arrow(vec(-1.25, -1.7, 0), vec(-1.6, -1.7, 0), "g")
    block(p, -2.5, -1.7, 0.9, "delay", "a")
    p.line([vec(-2.5, -1.7, 0), vec(-3.1, -1.7, 0)], "f w")
    p.arrow(vec(-2.8, -1.7, 0), vec(-3.1, -1.7, 0), "f w")
    p.text(vec(-2.9, -1.45, 0), "held", "f", small=True)
    return p


def hydraulic_cylinder():
    p = flat("A hydraulic cylinder with its valve", scale=70)
    left, right, half = -1.6, 1.1, 0.4
    p.line([vec(left, -half, 0), vec(0, -half, 0), vec(0, half, 0), vec(left, half, 0)], "af", True)
    p.line([vec(0.2, -half, 0), vec(right, -half, 0), vec(right, half, 0), vec(0.2, half, 0)], "mf", True)
    p.line([vec(0, -half, 0), vec(0.2, -half, 0), vec(0.2, half, 0), vec(0, half, 0)], "bf", True)
    p.line([vec(0.2, -0.13, 0), vec(2.0, -0.13, 0), vec(2.0, 0.13, 0), vec(0.2, 0.13, 0)], "bf", True)
    p.line([vec(left, 0, 0), vec(left - 0.4, 0, 0)], "a w")
    p.dot(vec(left - 0.4, 0, 0), "a", 4)
    p.text(vec(left - 0.4, 0.22, 0), "A", "a")
    p.dot(vec(2.15, 0, 0), "b", 4)
    p.text(vec(2.15, 0.22, 0), "B", "b")
    p.arrow(vec(2.3, 0, 0), vec(2.9, 0, 0), "f w", label="F", beside=(4, 0))
    p.text(vec(-0.85, 0.13, 0), "p_c, V_c", "a")
    p.text(vec(-0.85, -0.17, 0), "A_c", "a")
    p.text(vec(0.68, 0.28, 0), "p_r, A_r", "m", small=True)
    p.dimension(vec(left, 0.75, 0), vec(0, 0.75, 0), "s")
    # The valve.
    for x, style, text in ((-1.3, "a", "Q_c"), (0.85, "m", "Q_r")):
        p.line([vec(x, -half, 0), vec(x, -0.9, 0)], style + " w")
        p.text(vec(x - 0.25, -0.65, 0), text, style)
    p.line([vec(-1.3, -0.9, 0), vec(-0.5, -0.9, 0), vec(-0.5, -1.15, 0)], "a w")
    p.line([vec(0.85, -0.9, 0), vec(0.1, -0.9, 0), vec(0.1, -1.15, 0)], "m w")
    for i in range(3):
        x = -1.4 + 0.8 * i
        p.line([vec(x, -1.75, 0), vec(x + 0.8, -1.75, 0), vec(x + 0.8, -1.15, 0), vec(x, -1.15, 0)], "g", True)
    p.arrow(vec(-1.2, -1.75, 0), vec(-1.2, -1.15, 0), "g")
    p.arrow(vec(-0.8, -1.15, 0), vec(-0.8, -1.75, 0), "g")
    p.arrow(vec(0.4, -1.75, 0), vec(0.8, -1.15, 0), "g")
    p.arrow(vec(0.4, -1.15, 0), vec(0.8, -1.75, 0), "g")
    p.line([vec(-0.5, -1.75, 0), vec(-0.5, -2.05, 0)], "g w")
    p.line([vec(0.1, -1.75, 0), vec(0.1, -2.05, 0)], "g w")
    p.text(vec(-0.5, -2.2, 0), "p_S", "g")
    p.text(vec(0.1, -2.2, 0), "p_T", "g")
    p.arrow(vec(1.6, -1.45, 0), vec(1.05, -1.45, 0), "f w")
    p.text(vec(1.95, -1.45, 0), "x, u", "f")
    return p


PICTURES = {f.__name__: f for f in (control_diagram, hydraulic_cylinder)}
