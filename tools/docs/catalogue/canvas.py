"""Line drawings in three dimensions as small SVG files, and plain charts.

A Picture projects points of space (x to the lower left, y to the right, z up) onto paper and draws in the order of the
calls. Colours are of middle lightness: they stand out from white paper and from a dark page alike. First bodies and
markers are blue, second ones orange, motions green, forces purple; letters tell the same without colour.
"""

import math

import numpy as np

COLOURS = {"a": "#2479b9", "b": "#b9641a", "m": "#15875a", "f": "#9457b8", "g": "#767676"}
STYLE = "".join(
    f".{k}{{stroke:{c}}}.{k}t{{fill:{c};stroke:none}}.{k}f{{stroke:{c};fill:{c};fill-opacity:.16}}"
    for k, c in COLOURS.items()
)
COMMON = (
    "*{stroke-width:1.5;fill:none;stroke-linecap:round;stroke-linejoin:round}"
    "text,tspan{font-family:sans-serif;font-size:14px}.s,.s tspan{font-size:12px}.u{font-size:10px}"
    "tspan{fill:inherit;stroke:none}.w{stroke-width:2.6}.n{stroke-width:1}.d{stroke-dasharray:4 4}"
)


def vec(*x):
    return np.array(x[0] if len(x) == 1 else x, dtype=float)


def turn(axis, degrees):
    """Rotation matrix about an axis."""
    k = vec(axis) / np.linalg.norm(axis)
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    a = math.radians(degrees)
    return np.eye(3) + math.sin(a) * K + (1 - math.cos(a)) * K @ K


def axes_with_z(z, x=None):
    """Right-handed axes, columns x, y, z, with the given z and x as near as can be."""
    z = vec(z) / np.linalg.norm(z)
    if x is None or np.linalg.norm(np.cross(z, x)) < 1e-6:
        x = vec(1, 0, 0) if abs(z[0]) < 0.9 else vec(0, 1, 0)
    x = vec(x)
    x = x - z * (x @ z)
    x = x / np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def number(value):
    text = f"{value:.1f}"
    return text[:-2] if text.endswith(".0") else text


class Picture:
    def __init__(self, title, scale=70, width=360, height=260, centre=(0, 0, 0), azimuth=35, elevation=28):
        self.title, self.width, self.height, self.scale = title, width, height, scale
        a, e = math.radians(azimuth), math.radians(elevation)
        self.right = vec(-math.sin(a), math.cos(a), 0)
        self.up = vec(-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e))
        self.to_eye = vec(math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e))
        self.centre = vec(centre)
        self.items = []
        self.low, self.high = vec(1e9, 1e9), vec(-1e9, -1e9)  # what is drawn on

    def occupy(self, x, y, margin_x=2, margin_y=2):
        self.low = np.minimum(self.low, (x - margin_x, y - margin_y))
        self.high = np.maximum(self.high, (x + margin_x, y + margin_y))

    # ---- paper ----
    def at(self, p):
        d = vec(p) - self.centre
        return (self.width / 2 + self.scale * (d @ self.right), self.height / 2 - self.scale * (d @ self.up))

    def raw(self, text):
        self.items.append(text)

    def trace(self, paper_points, style, closed=False):
        words, last = [], None
        for x, y in paper_points:
            self.occupy(x, y)
            here = (number(x), number(y))
            if here != last:
                words.append(("M" if not words else "L") + " ".join(here))
            last = here
        self.raw(f'<path class="{style}" d="{"".join(words)}{"Z" if closed else ""}"/>')

    def head(self, tip, direction, style, size=9):
        d = vec(direction)
        length = np.linalg.norm(d)
        if length < 1e-9:
            return
        d = d / length
        n = vec(-d[1], d[0])
        t = vec(tip)
        back = t - size * d
        self.trace([tuple(back + 0.38 * size * n), tuple(t), tuple(back - 0.38 * size * n)], style)

    def label(self, paper, text, style="g", anchor="middle", small=False, dx=0, dy=0):
        """Text; `_` sets the next word or {group} lower, `^` likewise higher."""
        out, i, level = "", 0, 0
        while i < len(text):
            if text[i] in "_^":
                shift = 4 if text[i] == "_" else -5
                if i + 1 < len(text) and text[i + 1] == "{":
                    end = text.index("}", i)
                    part, i = text[i + 2 : end], end + 1
                else:
                    part, i = text[i + 1], i + 2
                out += f'<tspan class="u" dy="{shift - level}">{part}</tspan>'
                level = shift
            else:
                j = i
                while j < len(text) and text[j] not in "_^":
                    j += 1
                part = text[i:j].replace("&", "&amp;").replace("<", "&lt;")
                out += f'<tspan dy="{-level}">{part}</tspan>' if level else part
                level, i = 0, j
        x, y = paper[0] + dx, paper[1] + 5 + dy
        size = " s" if small else ""
        wide = 7.2 * len(text.replace("_", "").replace("{", "").replace("}", ""))
        middle = x + {"start": wide / 2, "middle": 0, "end": -wide / 2}[anchor]
        self.occupy(middle, y - 5, wide / 2, 9)
        self.raw(f'<text class="{style}t{size}" x="{number(x)}" y="{number(y)}" text-anchor="{anchor}">{out}</text>')

    # ---- space ----
    def line(self, points, style="g", closed=False):
        self.trace([self.at(p) for p in points], style, closed)

    def text(self, p, text, style="g", **more):
        self.label(self.at(p), text, style, **more)

    def arrow(self, p, q, style="m w", both=False, label=None, beside=(0, 0), size=9):
        P, Q = self.at(p), self.at(q)
        self.trace([P, Q], style)
        d = vec(Q) - vec(P)
        self.head(Q, d, style, size)
        if both:
            self.head(P, -d, style, size)
        if label:
            n = d / max(np.linalg.norm(d), 1e-9)
            self.label((Q[0] + 12 * n[0], Q[1] + 12 * n[1]), label, style.split()[0], dx=beside[0], dy=beside[1])

    def arc(self, centre, axis, start, radius, degrees, style="m w", both=False, label=None, beside=(0, 0), head=True):
        """From direction `start`, right-handed about `axis`."""
        R = axes_with_z(axis, start)
        count = max(8, int(abs(degrees) / 9))
        points = []
        for i in range(count + 1):
            t = math.radians(degrees * i / count)
            points.append(vec(centre) + radius * (math.cos(t) * R[:, 0] + math.sin(t) * R[:, 1]))
        paper = [self.at(p) for p in points]
        self.trace(paper, style)
        if head:
            self.head(paper[-1], vec(paper[-1]) - vec(paper[-2]), style)
        if both:
            self.head(paper[0], vec(paper[0]) - vec(paper[1]), style)
        if label:
            t = math.radians(degrees / 2)
            out = vec(centre) + (radius + 0.16) * (math.cos(t) * R[:, 0] + math.sin(t) * R[:, 1])
            self.text(out, label, style.split()[0], dx=beside[0], dy=beside[1])

    def frame(self, p, R, name, style, length=0.8, skip="", beside=None):
        """Marker axes; `skip` names those that are not labelled or drawn."""
        for i, letter in enumerate("xyz"):
            if letter in skip:
                continue
            tip = vec(p) + length * R[:, i]
            shift = (beside or {}).get(letter, (0, 0))
            text = f"{letter}_{name}" if name else letter
            self.arrow(p, tip, style, label=text, beside=shift, size=7)

    def dot(self, p, style="g", radius=3.2):
        x, y = self.at(p)
        self.raw(f'<circle class="{style}t" cx="{number(x)}" cy="{number(y)}" r="{radius}"/>')

    def circle(self, centre, axis, radius, style="g", fill=False, count=28):
        R = axes_with_z(axis)
        t = np.linspace(0, 2 * np.pi, count, endpoint=False)
        points = [vec(centre) + radius * (math.cos(x) * R[:, 0] + math.sin(x) * R[:, 1]) for x in t]
        self.line(points, style.split()[0] + "f" if fill else style, closed=True)

    def sphere(self, centre, radius, style="b"):
        x, y = self.at(centre)
        r = radius * self.scale
        self.occupy(x, y, r, r)
        self.raw(f'<circle class="{style}f" cx="{number(x)}" cy="{number(y)}" r="{number(r)}"/>')

    def box(self, centre, size, style="a", R=np.eye(3)):
        """Full edge lengths along the columns of R; hidden edges are left out."""
        h = vec(size) / 2
        for axis in range(3):
            for side in (1, -1):
                n = side * R[:, axis]
                if n @ self.to_eye <= 1e-9:
                    continue
                i, j = (axis + 1) % 3, (axis + 2) % 3
                middle = vec(centre) + h[axis] * n
                corners = [
                    middle + s * h[i] * R[:, i] + t * h[j] * R[:, j] for s, t in ((1, 1), (-1, 1), (-1, -1), (1, -1))
                ]
                self.line(corners, style + "f", closed=True)

    def cylinder(self, start, end, radius, style="a"):
        a, b = vec(start), vec(end)
        axis = (b - a) / np.linalg.norm(b - a)
        if axis @ self.to_eye < 0:
            a, b, axis = b, a, -axis  # b is the visible end
        side = np.cross(axis, self.to_eye)
        if np.linalg.norm(side) < 1e-6:
            return self.circle(b, axis, radius, style, fill=True)
        side = side / np.linalg.norm(side)
        back = np.cross(axis, side)  # on paper along the axis
        if (vec(self.at(back)) - self.at((0, 0, 0))) @ (vec(self.at(axis)) - self.at((0, 0, 0))) < 0:
            back = -back
        half = np.linspace(0, np.pi, 15)
        base = [a + radius * (math.cos(x) * side - math.sin(x) * back) for x in half]
        rim = [b + radius * (math.cos(x) * side + math.sin(x) * back) for x in half[::-1]]
        top = [b + radius * (math.cos(x) * side + math.sin(x) * back) for x in np.linspace(0, 2 * np.pi, 28, False)]
        self.line([*base, *rim], style + "f", closed=True)
        self.line(top, style, closed=True)

    def bar(self, p, q, width=0.14, style="a", up=(0, 0, 1)):
        """A box from p to q."""
        p, q = vec(p), vec(q)
        R = axes_with_z(q - p, up)
        self.box((p + q) / 2, (width, width, np.linalg.norm(q - p)), style, R)

    def ground(self, p, normal=(0, 0, 1), along=(0, 1, 0), width=0.8, style="g"):
        """A hatched line through p: what does not move."""
        n, t = vec(normal), vec(along) / np.linalg.norm(along)
        self.line([vec(p) - width / 2 * t, vec(p) + width / 2 * t], style)
        for i in range(7):
            q = vec(p) + (i / 6 - 0.5) * width * t
            self.line([q, q - 0.12 * n - 0.08 * t], style + " n")

    # ---- on paper alone: springs and dampers between two points of space ----
    def spring(self, p, q, style="g", coils=6, half=7, lead=0.18):
        P, Q = vec(self.at(p)), vec(self.at(q))
        d = Q - P
        n = vec(-d[1], d[0]) / np.linalg.norm(d) * half
        points = [P, P + lead * d]
        for i in range(2 * coils):
            s = lead + (1 - 2 * lead) * (i + 0.5) / (2 * coils)
            points.append(P + s * d + (n if i % 2 else -n))
        points += [Q - lead * d, Q]
        self.trace([tuple(x) for x in points], style)

    def damper(self, p, q, style="g", half=7):
        P, Q = vec(self.at(p)), vec(self.at(q))
        d = Q - P
        n = vec(-d[1], d[0]) / np.linalg.norm(d) * half
        a, b = P + 0.36 * d, P + 0.66 * d
        self.trace([tuple(P), tuple(a)], style)
        self.trace([tuple(b + n), tuple(a + n), tuple(a - n), tuple(b - n)], style)
        self.trace([tuple(P + 0.53 * d + 0.8 * n), tuple(P + 0.53 * d - 0.8 * n)], style)
        self.trace([tuple(P + 0.53 * d), tuple(Q)], style)

    def dimension(self, p, q, label, offset=(0, 0), style="g", beside=(0, -9)):
        """A thin double arrow between two points, moved by `offset` on paper."""
        P, Q = vec(self.at(p)) + offset, vec(self.at(q)) + offset
        self.trace([tuple(P), tuple(Q)], style + " n")
        self.head(Q, Q - P, style + " n", 7)
        self.head(P, P - Q, style + " n", 7)
        middle = (P + Q) / 2
        self.label((middle[0] + beside[0], middle[1] + beside[1]), label, style)

    def svg(self):
        body = "\n".join(self.items)
        low, size = np.floor(self.low - 6), np.ceil(self.high - self.low + 12)
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{low[0]:g} {low[1]:g} {size[0]:g} {size[1]:g}" '
            f'width="{1.15 * size[0]:g}" height="{1.15 * size[1]:g}" role="img">\n<title>{self.title}</title>\n<style>{COMMON}{STYLE}</style>\n{body}\n'
            "</svg>\n"
        )


class Chart(Picture):
    """Lines over an x axis, linear or logarithmic; each line is named at its end or in a key."""

    LINES = (("a", ""), ("b", ""), ("m", ""), ("f", ""), ("g", ""), ("a", " d"), ("b", " d"), ("m", " d"))

    def __init__(self, title, x_range, y_range, x_label, y_label, log_x=False, log_y=False, width=420, height=270):
        super().__init__(title, 1, width, height)
        self.x_range, self.y_range, self.log_x, self.log_y = x_range, y_range, log_x, log_y
        self.left, self.bottom, self.top, self.side = 52, 40, 14, 14
        self.keys = 0
        self.plot_right, self.plot_low = width - self.side, height - self.bottom
        self.x_label, self.y_label = x_label, y_label

    def place(self, x, y):
        def share(value, limits, log):
            if log:
                value, limits = math.log10(max(value, 1e-300)), [math.log10(l) for l in limits]
            return (value - limits[0]) / (limits[1] - limits[0])

        return (
            self.left + share(x, self.x_range, self.log_x) * (self.plot_right - self.left),
            self.plot_low - share(y, self.y_range, self.log_y) * (self.plot_low - self.top),
        )

    def grid(self, x_ticks, y_ticks):
        for x in x_ticks:
            px = self.place(x, self.y_range[0])[0]
            self.trace([(px, self.plot_low), (px, self.plot_low + 4)], "g n")
            self.label((px, self.plot_low + 13), tick(x), small=True)
        for y in y_ticks:
            py = self.place(self.x_range[0], y)[1]
            self.trace([(self.left - 4, py), (self.left, py)], "g n")
            self.label((self.left - 7, py - 1), tick(y), anchor="end", small=True)
        self.trace(
            [(self.left, self.top), (self.left, self.plot_low), (self.plot_right, self.plot_low)], "g n"
        )
        self.label(((self.left + self.plot_right) / 2, self.height - 11), self.x_label)
        x, y = 13, (self.top + self.plot_low) / 2
        self.occupy(x - 8, y)
        self.raw(
            f'<text class="gt" text-anchor="middle" transform="translate({number(x)} {number(y)}) rotate(-90)">'
            f"{self.y_label}</text>"
        )

    def curve(self, xs, ys, line=0, closed=False):
        """Cut where it leaves the frame."""
        colour, dash = self.LINES[line]
        run = []
        for x, y in zip(xs, ys):
            inside = self.x_range[0] <= x <= self.x_range[1] and self.y_range[0] <= y <= self.y_range[1]
            if inside and np.isfinite(y):
                run.append(self.place(x, y))
            elif run:
                self.polish(run, colour + dash)
                run = []
        if run:
            self.polish(run, colour + dash, closed)

    def polish(self, run, style, closed=False):
        """Leaves out points that a straight line shows as well."""
        kept = [run[0]]
        anchor = 0
        for i in range(2, len(run)):
            a, b = vec(run[anchor]), vec(run[i])
            d = b - a
            length = np.linalg.norm(d)
            worst = max(
                (abs(d[0] * (p[1] - a[1]) - d[1] * (p[0] - a[0])) / length if length > 0 else 0) for p in run[anchor + 1 : i]
            )
            if worst > 0.25 or i - anchor > 60:
                anchor = i - 1
                kept.append(run[anchor])
        kept.append(run[-1])
        self.trace(kept, style + " w", closed)

    def key(self, text, line=0, x=None, y=None):
        """A line's name; without a place in a column at the upper right."""
        colour, dash = self.LINES[line]
        if x is None:
            px, py = self.plot_right - 118, self.top + 10 + 17 * self.keys
            self.keys += 1
            self.trace([(px - 26, py), (px - 6, py)], colour + dash + " w")
            self.label((px, py), text, colour, anchor="start", small=True)
        else:
            self.label(self.place(x, y), text, colour, small=True)


def tick(value):
    if value != 0 and (abs(value) >= 1e4 or abs(value) < 1e-2):
        exponent = round(math.log10(abs(value)))
        return f"10^{{{'−' if exponent < 0 else ''}{abs(exponent)}}}"
    return f"{value:g}".replace("-", "−")
