"""Joints of a few rows, and the point mass."""

from bodies_pictures import world
from canvas import Picture, turn, vec
from joints_pictures import E, O, SIDEWAYS, X, Y, Z


def planar_pin_joint():
    p = Picture("Planar pin: B keeps its place in the plane of A, no other row", centre=(0, 0.2, 0.1), elevation=34)
    p.box((0, 0.1, -0.42), (2.2, 3.4, 0.04), "g")
    p.text((0.85, -1.25, -0.4), "plane", "g", small=True)
    B = turn(Z, 55)
    p.bar(vec(0, -1.5, -0.1), vec(0, 0, -0.1), 0.24, "a", Z)
    p.cylinder((0, 0, -0.22), (0, 0, 0.02), 0.22, "a")
    p.cylinder((0, 0, 0.02), (0, 0, 0.24), 0.22, "b")
    p.bar(B @ vec(0.2, 0, 0.13), B @ vec(1.25, 0, 0.13), 0.24, "b", Z)
    p.frame(O, E, "A", "a", 1.15, skip="z")
    p.frame((0, 0, 0.13), B, "B", "b", 1.6, skip="z")
    p.arrow(O, 0.95 * Z, "a", label="z_A")
    p.arc(0.6 * Z, Z, X, 0.42, 280)
    return p


def parallel_axes_joint():
    p = Picture("Parallel axes: z of B keeps the direction of z of A", centre=(0, 0.1, 0.25))
    B = turn(Z, 40)
    a, b = vec(0, -1.1, -0.2), vec(-0.1, 1.0, 0.1)
    p.box(a + vec(0, 0, -0.2), (0.7, 0.8, 0.4), "a")
    p.box(b + vec(0, 0, -0.2), (0.7, 0.8, 0.4), "b", B)
    p.frame(a, E, "A", "a", 0.75, skip="z")
    p.frame(b, B, "B", "b", 0.75, skip="z")
    p.arrow(a, a + 1.15 * Z, "a", label="z_A")
    p.arrow(b, b + 1.15 * Z, "b", label="z_B ∥ z_A", beside=(14, 0))
    p.arc(b + 0.8 * Z, Z, X, 0.32, 280)
    for axis, low, high in ((Z, 0.25, 0.85), (Y, 0.55, 1.15), (X, 0.5, 1.1)):
        start = b + vec(0, 0.55, -0.35) if axis is not Y else b + vec(0, 0, -0.35)
        p.arrow(start + low * axis, start + high * axis, both=True, size=7)
    return p


def perpendicular_axes_joint():
    p = Picture("Perpendicular axes: z of B stays at right angles to z of A", centre=(0, 0.1, 0.25))
    a, b = vec(0, -1.0, -0.3), vec(0, 0.75, 0.15)
    B = turn(Z, 12) @ SIDEWAYS
    p.box(a + vec(0, 0, -0.2), (0.7, 0.8, 0.4), "a")
    p.cylinder(b - 0.3 * B[:, 2], b + 0.3 * B[:, 2], 0.34, "b")
    p.arrow(a, a + 1.25 * Z, "a", label="z_A")
    p.arrow(b + 0.3 * B[:, 2], b + 1.1 * B[:, 2], "b", label="z_B ⟂ z_A", beside=(6, -12))
    p.line([b - 0.9 * Z, b + 1.0 * Z], "g d")
    p.arc(b + 0.75 * Z, Z, X, 0.36, 280)
    p.arc(b + 0.75 * B[:, 2], B[:, 2], X, 0.36, 280)
    p.arrow(b + vec(0.5, -0.3, -0.6), b + vec(0.5, 0.4, -0.6), both=True, size=7)
    return p


def orientation_joint():
    p = Picture("Orientation joint: B keeps the axes of A and moves anywhere", centre=(0, 0.1, 0.25))
    a, b = vec(0.2, -1.1, -0.2), vec(-0.2, 0.9, 0.3)
    p.box(a + vec(0, 0, -0.2), (0.7, 0.8, 0.4), "a")
    p.box(b + vec(0, 0, -0.2), (0.6, 0.7, 0.4), "b")
    p.frame(a, E, "A", "a", 0.8)
    p.frame(b, E, "B", "b", 0.8)
    p.arrow(a, b, "g", size=7, label="d", beside=(0, 0))
    c = b + vec(0, 0.35, -0.6)
    for axis in (X, Y, Z):
        p.arrow(c - 0.35 * axis, c + 0.35 * axis, both=True, size=7)
    return p


def revolute_spherical_joint():
    p = Picture("Revolute-spherical joint: a massless link with a hinge and a ball", centre=(0, 0.1, 0.2), elevation=34)
    B = turn((1, 0.3, 0.4), 25)
    b = 1.5 * (turn(Z, 18) @ Y)
    p.box((0, -0.45, -0.35), (0.8, 0.9, 0.3), "a")
    p.cylinder((0, 0, -0.2), (0, 0, 0.2), 0.17, "a")
    p.line([0.17 * b / 1.5, b], "g w")
    p.circle(O, Z, 1.5, "g d")
    p.sphere(b, 0.15, "b")
    p.bar(b + 0.15 * B[:, 2], b + 1.05 * B[:, 2], 0.2, "b", X)
    p.arrow((0, 0, 0.2), (0, 0, 0.95), "a", label="z_A")
    p.arrow(O, 0.85 * X, "a", label="x_A")
    p.dimension(O, b, "L", offset=(4, -12), beside=(0, -8))
    p.arc(O, Z, X, 0.62, 106, label="φ", beside=(2, 12))
    p.text(b, "p_B", "b", dx=8, dy=24)
    p.arc(b + 0.75 * B[:, 2], B[:, 2], X, 0.3, 280)
    return p


def point_mass():
    p = Picture("Point mass: a place in the world, no axes", centre=(0, 0, 0.1))
    o = world(p)
    c = vec(0, 0.5, 0.45)
    p.arrow(o, c, "m", size=8)
    p.text(0.5 * (o + c), "p", "m", dy=-10)
    p.sphere(c, 0.16, "a")
    p.dot(c, "a", 4)
    p.text(c, "m", "a", dx=-18, dy=-12)
    p.arrow(c, c + vec(-0.6, 0.55, 0.35), "f", label="f", beside=(8, 0))
    p.arrow(c - 0.16 * Z, c - 0.95 * Z, "f", label="m g", beside=(18, 6))
    return p


PICTURES = {
    f.__name__: f
    for f in (
        planar_pin_joint,
        parallel_axes_joint,
        perpendicular_axes_joint,
        orientation_joint,
        revolute_spherical_joint,
        point_mass,
    )
}
