"""The integrators: what a step of length h does to an undamped oscillation of frequency ω, computed from the methods."""

import math
import pathlib
import re

import numpy as np

from canvas import Chart, vec
from joints_pictures import O, X, Y, Z
from transmissions_pictures import flat

ROOT = pathlib.Path(__file__).resolve().parents[3]


def spectral_radius(matrix):
    return max(abs(np.linalg.eigvals(matrix)))


def chart(title, names, radius, limits=(0.01, 100), y=(0, 1.1), y_label="spectral radius", where=None, y_ticks=None):
    """One curve a name of radius(name, hω), over a logarithmic axis."""
    low, high = limits
    p = Chart(title, limits, y, "h ω", y_label, log_x=True)
    p.grid([t for t in (0.01, 0.1, 1, 10, 100, 1000) if low <= t <= high], y_ticks or [0, 0.25, 0.5, 0.75, 1])
    x = np.geomspace(low, high, 240)
    for line, name in enumerate(names):
        p.curve(x, [radius(name, v) for v in x], line)
        if where:
            p.key(str(name), line, *where[line])
        else:
            p.key(str(name), line)
    return p


def tableau(letter):
    """Rows of the array kA5 or kA8 of integrators/runge_kutta_tableau.cpp."""
    text = (ROOT / "integrators/runge_kutta_tableau.cpp").read_text()
    text = re.search(rf"kA{letter} = {{{{(.*?)}}}};", text, re.S)[1]
    rows = []
    for row in re.findall(r"{([^{}]*)}", text):
        numbers = []
        for entry in row.replace("\n", " ").split(","):
            if entry.strip():
                top, _, bottom = entry.partition("/")
                numbers.append(float(top) / (float(bottom) if bottom else 1))
        rows.append(numbers)
    return rows


def runge_kutta(letter, stages):
    rows = tableau(letter)
    A = np.zeros((stages, stages))
    for i, row in enumerate(rows[:stages]):
        A[i, : len(row)] = row
    b = np.zeros(stages)
    b[: len(rows[stages])] = rows[stages]
    one = np.ones(stages)
    return lambda z: 1 + z * (b @ np.linalg.solve(np.eye(stages) - z * A, one))


def explicit_runge_kutta():
    methods = {"5(4)": runge_kutta("5", 6), "8(5,3)": runge_kutta("8", 12)}
    p = Chart("Explicit Runge-Kutta: growth a step, undamped (lines) and of a damper (dashes)", (0, 8), (0, 1.5), "h ω, or h |λ| of a damper", "growth a step")
    p.grid([0, 2, 4, 6, 8], [0, 0.5, 1, 1.5])
    x = np.linspace(0, 8, 321)
    for line, (name, R) in enumerate(methods.items()):
        p.curve(x, [abs(R(1j * v)) for v in x], line)
        p.curve(x, [abs(R(-v)) for v in x], line + 5)
        p.key(name, line, (2.3, 6.9)[line], 1.38)
    p.curve([0, 8], [1, 1], 4)
    return p


def alpha_matrix(am, af, x):
    """(q, h v, h² a) of the generalized-alpha method over one step, v̇ = -ω² q, x = h ω."""
    gamma = 0.5 + af - am
    beta = 0.25 * (gamma + 0.5) ** 2
    # unknowns q', v', a'; rows: the three relations of integrators/generalized_alpha.h
    left = np.array([[1, 0, -beta], [0, 1, -gamma], [(1 - af) * x * x, 0, 1 - am]])
    right = np.array([[1, 1, 0.5 - beta], [0, 1, 1 - gamma], [-af * x * x, 0, -am]])
    return np.linalg.solve(left, right)


def generalized_alpha():
    p = Chart("Generalized-alpha: spectral radius over h ω", (0.01, 100), (0, 1.1), "h ω", "spectral radius", log_x=True)
    p.grid([0.01, 0.1, 1, 10, 100], [0, 0.25, 0.5, 0.75, 1])
    x = np.geomspace(0.01, 100, 240)
    for line, rho in enumerate((0.9, 0.8, 0.5, 0.0)):
        p.curve(x, [spectral_radius(alpha_matrix((2 * rho - 1) / (rho + 1), rho / (rho + 1), v)) for v in x], line)
        p.key(f"ρ = {rho:g}", line, 0.03, 0.6 - 0.1 * line)
    return p


def hht():
    p = Chart("HHT-I3: spectral radius over h ω", (0.01, 100), (0, 1.1), "h ω", "spectral radius", log_x=True)
    p.grid([0.01, 0.1, 1, 10, 100], [0, 0.25, 0.5, 0.75, 1])
    x = np.geomspace(0.01, 100, 240)
    for line, (alpha, text) in enumerate(((0.0, "α = 0"), (-0.05, "−0.05"), (-0.2, "−0.2"), (-1 / 3, "−1/3"))):
        p.curve(x, [spectral_radius(alpha_matrix(0, -alpha, v)) for v in x], line)
        p.key(text, line, 0.03, 0.6 - 0.1 * line)
    return p


def bdf_radius(order, x, imaginary=True):
    """Σ_{j=1..k} 1/j ∇^j y = z y."""
    coefficients = np.zeros(order + 1)
    for j in range(1, order + 1):
        for i in range(j + 1):
            coefficients[i] += (-1) ** i * math.comb(j, i) / j
    polynomial = coefficients.astype(complex)
    polynomial[0] -= 1j * x if imaginary else -x
    return max(abs(np.roots(polynomial)))


def lie_bdf():
    return chart("BDF of order 1 to 5: growth a step of an undamped oscillation", [1, 2, 3, 4, 5], bdf_radius, (0.1, 100), (0, 1.4))


def ida():
    def growth(order, x):
        return bdf_radius(order, x, imaginary=False)

    return chart("BDF of order 1 to 5: growth a step of a damper", [1, 2, 3, 4, 5], growth, (0.1, 100), (0, 1.1))


def adams():
    """Adams-Moulton of orders 2, 4, 8, 12: weights of the polynomial through the last derivatives."""

    def weights(order):
        nodes = np.array([1.0 - i for i in range(order)])  # t in steps: 1, 0, -1 …
        powers = np.vander(nodes, increasing=True).T
        return np.linalg.solve(powers, [1 / (k + 1) for k in range(order)])

    def radius(order, x):
        beta = weights(order)
        polynomial = np.zeros(max(order, 2), dtype=complex)
        polynomial[0], polynomial[1] = 1, -1
        polynomial[: len(beta)] -= 1j * x * beta
        return max(abs(np.roots(polynomial)))

    return chart("Adams-Moulton: growth a step of an undamped oscillation", [2, 4, 8, 12], radius, (0.05, 3), (0.8, 1.4),
                 y_ticks=[0.8, 1, 1.2, 1.4])


def radau():
    def R(z):
        return (1 + 2 * z / 5 + z * z / 20) / (1 - 3 * z / 5 + 3 * z * z / 20 - z**3 / 60)

    p = Chart("Radau IIA: growth a step over h ω", (0.1, 1000), (0, 1.1), "h ω, or h |λ| of a damper", "growth a step", log_x=True)
    p.grid([0.1, 1, 10, 100, 1000], [0, 0.25, 0.5, 0.75, 1])
    x = np.geomspace(0.1, 1000, 240)
    p.curve(x, [abs(R(1j * v)) for v in x], 0)
    p.curve(x, [abs(R(-v)) for v in x], 1)
    p.key("undamped oscillation", 0)
    p.key("damper", 1)
    return p


def frequency_chart(title, angle, limit, name):
    p = Chart(title, (0, 4), (0, 1.8), "h ω", "frequency, of the true one")
    p.grid([0, 1, 2, 3, 4], [0, 0.5, 1, 1.5])
    x = np.linspace(0.02, limit, 160)
    p.curve(x, [angle(v) / v for v in x], 0)
    p.curve([0, 4], [1, 1], 4)
    p.key(name, 0, 2.9, 1.35 if limit < 4 else 0.35)
    if limit < 4:
        p.curve([limit, limit], [0, math.pi / 2], 5)
    return p


def rattle():
    return frequency_chart(
        "RATTLE: frequency of an oscillation, and the limit h ω = 2", lambda x: math.acos(max(-1, 1 - x * x / 2)), 2.0, "h ω < 2; no damping"
    )


def energy_momentum():
    return frequency_chart("Midpoint rule: frequency of an oscillation", lambda x: 2 * math.atan(x / 2), 4.0, "any h ω; no damping")


def linearly_implicit():
    def euler(x):
        return np.array([[1, x], [-x, 1]]) / (1 + x * x)

    def radius(order, x):
        return spectral_radius(euler(x) if order == 1 else 2 * euler(x / 2) @ euler(x / 2) - euler(x))

    p = chart("Linearly implicit Euler: spectral radius over h ω", [1, 2], radius, where=[(0.25, 0.75), (2.2, 0.98)])
    return p


def moreau_jean():
    """A ball dropped from 0.3 m, restitution 0.8, steps of 20 ms: each impact at its time within the step."""
    g, e, h = 9.81, 0.8, 0.02
    p = Chart("Moreau-Jean: a bouncing ball; dots are ends of steps of 20 ms", (0, 1.4), (0, 0.32), "t, s", "gap, m")
    p.grid([0, 0.4, 0.8, 1.2], [0, 0.1, 0.2, 0.3])
    q, v, t = 0.3, 0.0, 0.0
    fine_t, fine_q = [], []
    while t < 1.4 - 1e-9:
        for _ in range(8):
            dt = h / 8
            left = dt
            while True:
                meet = (v + math.sqrt(v * v + 2 * g * q)) / g
                if meet >= left:
                    break
                v = e * (g * meet - v)
                q, left = 0.0, left - meet
            q, v = q + v * left - g * left * left / 2, v - g * left
            t += dt
            fine_t.append(t)
            fine_q.append(q)
    p.curve(fine_t, fine_q, 0)
    for i in range(7, len(fine_t), 8):
        x, y = p.place(fine_t[i], fine_q[i])
        p.raw(f'<circle class="bt" cx="{x:.0f}" cy="{y:.0f}" r="2"/>')
    return p


def blocks(title, rows, both=False):
    """Boxes from left to right: (text, second line, colour)."""
    p = flat(title)
    p.scale = 62
    x = -3.2
    for i, (first, second, style) in enumerate(rows):
        w = 2.05
        p.line([vec(x, -0.42, 0), vec(x + w, -0.42, 0), vec(x + w, 0.42, 0), vec(x, 0.42, 0)], style + "f", True)
        p.text(vec(x + w / 2, 0.15, 0), first, style, small=True)
        p.text(vec(x + w / 2, -0.17, 0), second, "g", small=True)
        if i + 1 < len(rows):
            p.arrow(vec(x + w, 0, 0), vec(x + w + 0.4, 0, 0), "g", both=both)
        x += w + 0.4
    return p


def nonsmooth_generalized_alpha():
    return blocks(
        "Nonsmooth generalized-alpha: the parts of a step",
        (("smooth motion", "generalized-alpha", "a"), ("impulses", "S in the middle", "f"), ("joints closed", "history anew", "b")),
    )


def automatic():
    p = blocks(
        "Automatic: three methods, chosen by trial",
        (("8(5,3)", "smooth, soft", "a"), ("Lie-group BDF", "stiff, damped", "b"), ("Radau IIA 5", "stiff, undamped", "m")),
        both=True,
    )
    p.line([vec(-2.2, -0.42, 0), vec(-2.2, -0.85, 0), vec(2.7, -0.85, 0), vec(2.7, -0.42, 0)], "g d")
    p.text(vec(0.25, -1.05, 0), "tried for a few steps each; who gets furthest for the same work keeps the scene", "g", small=True)
    return p


def around():
    p = Chart("A mode that is frozen while it is quiet and let go by a push", (0, 10), (-1.2, 1.2), "t", "modal coordinate")
    p.grid([0, 2, 4, 6, 8, 10], [-1, 0, 1])
    t = np.linspace(0, 4, 161)
    p.curve(t, 0.9 * np.exp(-0.9 * t) * np.cos(6 * t), 0)
    p.curve([4, 7], [0, 0], 1)
    t = np.linspace(7, 10, 121)
    p.curve(t, 0.8 * np.exp(-0.5 * (t - 7)) * np.sin(6 * (t - 7)), 0)
    p.curve([0, 10], [0.15, 0.15], 5)
    p.curve([0, 10], [-0.15, -0.15], 5)
    p.key("frozen: costs nothing", 1, 5.5, -0.4)
    p.key("displacement", 4, 9.0, 0.32)
    return p


def kinematics():
    p = flat("Kinematic analysis: a driven slider-crank, solved at each time")
    a = vec(0.6 * math.cos(1.0), 0.6 * math.sin(1.0), 0)
    b = vec(a[0] + math.sqrt(1.9**2 - a[1] ** 2), 0, 0)
    p.ground(vec(0, -0.12, 0), Y, X, 0.6)
    p.ground(vec(b[0] + 0.05, -0.24, 0), Y, X, 1.6)
    p.bar(O, a, 0.14, "a", Z)
    p.bar(a, b, 0.12, "b", Z)
    p.line([b + vec(*q, 0) for q in ((-0.3, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.3, 0.2))], "af", True)
    for q in (O, a, b):
        p.dot(q, "g", 4)
    p.arc(O, Z, X, 0.42, 57, "m w", label="f(t)", beside=(10, 2))
    p.text(vec(1.2, -0.65, 0), "g(q, t) = 0,  G v = −∂g/∂t,  G v̇ = γ,  M v̇ + G^Tλ = f", "g", small=True)
    return p


def campbell():
    """A rigid disc that tilts on an isotropic spring: J_d w² ∓ J_p Ω w - k = 0, J_p = 1.6 J_d, sqrt(k/J_d) = 10 Hz."""
    p = Chart("Campbell diagram: whirl of a disc over its speed", (0, 12), (0, 30), "speed, Hz", "frequency, Hz")
    p.grid([0, 4, 8, 12], [0, 10, 20, 30])
    speed = np.linspace(0, 12, 100)
    gyro = 1.6 * speed
    p.curve(speed, [g / 2 + math.sqrt(g * g / 4 + 100) for g in gyro], 0)
    p.curve(speed, [-g / 2 + math.sqrt(g * g / 4 + 100) for g in gyro], 1)
    p.curve(speed, speed, 4)
    p.key("forward", 0, 9, 20)
    p.key("backward", 1, 10, 7)
    p.key("order 1", 4, 10.8, 13)
    return p


PICTURES = {
    f.__name__: f
    for f in (
        automatic,
        explicit_runge_kutta,
        lie_bdf,
        radau,
        generalized_alpha,
        hht,
        adams,
        ida,
        rattle,
        energy_momentum,
        linearly_implicit,
        moreau_jean,
        nonsmooth_generalized_alpha,
        around,
        kinematics,
        campbell,
    )
}
