"""Two formulations of a geometrically exact beam, and their versions of order four, on equal problems.

  se3        two nodes, the helix of SE(3) between them: the element of bodies/beam (Sonneville, Cardona, Bruls 2014)
  se3 x      two of its meshes, n and n/2, extrapolated: (4 tip(n) - tip(n/2))/3
  linear     two nodes, positions and relative rotation vectors interpolated (Crisfield & Jelenic 1999), one Gauss point
  quadratic  the same with three nodes and two Gauss points (reduced integration)

Equilibrium of cantilevers: error of the tip over the length, by elements, and the work that an accuracy costs. Work is
counted in multiplications of a Newton iteration, as compiled code would do them: 6 x 6 blocks of a chain, middle nodes
condensed. Energies alone are coded: forces by complex steps, tangents by differences of these.

  python3 tools/bench/beam_elements.py [rolled | elastica | 45]
"""
import sys

import numpy as np

STEP = 1e-30  # of complex steps


def skew(a):
    z = np.zeros_like(a[..., 0])
    return np.stack([np.stack([z, -a[..., 2], a[..., 1]], -1), np.stack([a[..., 2], z, -a[..., 0]], -1),
                     np.stack([-a[..., 1], a[..., 0], z], -1)], -2)


def apply(m, x):
    return np.einsum('...ij,...j->...i', m, x)


def product(p, q):
    """Of quaternions (w, x, y, z)."""
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], -1, keepdims=True)
    return np.concatenate([w, p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])], -1)


def conjugate(q):
    return np.concatenate([q[..., :1], -q[..., 1:]], -1)


def quaternion(phi):
    t = np.sum(phi * phi, -1, keepdims=True)
    small = abs(t) < 1e-6
    half = 0.5 * np.sqrt(np.where(small, 1, t))
    return np.concatenate([np.where(small, 1 - t / 8 + t * t / 384, np.cos(half)),
                           np.where(small, 0.5 - t / 48 + t * t / 3840, np.sin(half) / (2 * half)) * phi], -1)


def logarithm(q):
    q = np.where(q[..., :1].real < 0, -q, q)
    v, w = q[..., 1:], q[..., :1]
    t = np.sum(v * v, -1, keepdims=True) / (w * w)
    small = abs(t) < 1e-5
    x = np.sqrt(np.where(small, 1, t))
    return 2 * v / w * np.where(small, 1 - t / 3 + t * t / 5 - t**3 / 7, np.arctan(x) / x)


def rotate_back(q, x):
    return product(product(conjugate(q), np.concatenate([np.zeros_like(x[..., :1]), x], -1)), q)[..., 1:]


def right_jacobian(phi, x):
    t = np.sum(phi * phi, -1, keepdims=True)
    small = abs(t) < 1e-4
    a = np.sqrt(np.where(small, 1, t))
    c1 = np.where(small, 0.5 - t / 24 + t * t / 720, (1 - np.cos(a)) / a**2)
    c2 = np.where(small, 1 / 6 - t / 120 + t * t / 5040, (a - np.sin(a)) / a**3)
    once = np.cross(phi, x)
    return x - c1 * once + c2 * np.cross(phi, once)


def left_jacobian_inverse(phi, x):
    t = np.sum(phi * phi, -1, keepdims=True)
    small = abs(t) < 1e-3
    a = np.sqrt(np.where(small, 1, t))
    k = np.where(small, 1 / 12 + t / 720 + t * t / 30240 + t**3 / 1209600, (1 - a / 2 / np.tan(a / 2)) / a**2)
    once = np.cross(phi, x)
    return x - 0.5 * once + k * np.cross(phi, once)


def strains_se3(p, q, length):
    phi = logarithm(product(conjugate(q[..., 0, :]), q[..., 1, :]))
    u = left_jacobian_inverse(phi, rotate_back(q[..., 0, :], p[..., 1, :] - p[..., 0, :]))
    return [(np.concatenate([u, phi], -1) / length, 1.0)]


def interpolated(reference, points):
    """Points (weight, N_i, dN_i/dxi) on -1 <= xi <= 1, rotations relative to a reference node."""
    def strains(p, q, length):
        back = conjugate(q[..., reference, :])
        phi = [logarithm(product(back, q[..., i, :])) for i in range(p.shape[-2])]
        out = []
        for weight, N, dN in points:
            angle = sum(n * f for n, f in zip(N, phi))
            rate = sum(n * f for n, f in zip(dN, phi)) * 2 / length
            slope = sum(n * p[..., i, :] for i, n in enumerate(dN)) * 2 / length
            here = product(q[..., reference, :], quaternion(angle))
            out.append((np.concatenate([rotate_back(here, slope), right_jacobian(angle, rate)], -1), weight))
        return out
    return strains


G = 1 / np.sqrt(3)
QUADRATIC = [(0.5, ((x * x - x) / 2, 1 - x * x, (x * x + x) / 2), (x - 0.5, -2 * x, x + 0.5)) for x in (-G, G)]
# nodes of an element, strains, multiplications of its tangent, of its share of the factor
#   tangent: B (6 x 6m) of a Gauss point from closed forms, C B, B^T C B; factor: a 6 x 6 block of a chain 6^3 (1/6 + 1 +
#   1/2), and once more to condense a middle node with its two neighbours 6^3 (1/6 + 2 + 3)
CHAIN, CONDENSED = 216 * (1 / 6 + 1 + 0.5), 216 * (1 / 6 + 2 + 3)
ELEMENTS = {
    'se3': (2, strains_se3, 300 + 6 * 6 * 12 + 6 * 12 * 12, CHAIN),
    'linear': (2, interpolated(0, [(1.0, (0.5, 0.5), (-0.5, 0.5))]), 300 + 6 * 6 * 12 + 6 * 12 * 12, CHAIN),
    'quadratic': (3, interpolated(1, QUADRATIC), 2 * (400 + 6 * 6 * 18 + 6 * 18 * 18), CHAIN + CONDENSED),
}


class Beam:
    def __init__(self, kind, n, length, pose, stiffness):
        self.m, self.strains, tangent, factor = ELEMENTS[kind]
        self.work = n * (tangent + factor)
        count = n * (self.m - 1) + 1
        poses = [pose(length * i / (count - 1)) for i in range(count)]
        self.p, self.q = np.array([x for x, _ in poses]), np.array([q for _, q in poses])
        self.nodes = np.array([[e * (self.m - 1) + i for i in range(self.m)] for e in range(n)])
        self.length, self.C = length / n, stiffness
        self.drawn = [s.real for s, _ in self.strains(self.p[self.nodes], self.q[self.nodes], self.length)]

    def forces(self, dp, dq):
        """Gradient of each element's energy by shifts and turns (own axes) of its nodes, at moved places."""
        k = 6 * self.m
        x = np.concatenate([dp, dq], -1).reshape(dp.shape[:-2] + (k,)).astype(complex)
        x = x[..., None, :] + 1j * STEP * np.eye(k)
        x = x.reshape(x.shape[:-1] + (self.m, 6))
        p = self.p[self.nodes][:, None] + x[..., :3]
        q = product(self.q[self.nodes][:, None] + 0j * x[..., :1], quaternion(x[..., 3:]))
        energy = 0
        for (strain, weight), drawn in zip(self.strains(p, q, self.length), self.drawn):
            e = strain - drawn[:, None]
            energy = energy + 0.5 * weight * self.length * np.sum(e * e * self.C, -1)
        return energy.imag / STEP

    def settle(self, force, moment, steps):
        n = len(self.p)
        zero = np.zeros((len(self.nodes), self.m, 3))
        iterations = 0
        for load in range(1, steps + 1):
            for _ in range(60):
                f = self.forces(zero, zero)
                r, K = np.zeros(6 * n), np.zeros((6 * n, 6 * n))
                columns = []
                for j in range(6 * self.m):
                    d = np.zeros((len(self.nodes), 6 * self.m))
                    h = 1e-5
                    d[:, j] = h
                    d = d.reshape(len(self.nodes), self.m, 6)
                    columns.append((self.forces(d[..., :3], d[..., 3:]) - self.forces(-d[..., :3], -d[..., 3:])) / (2 * h))
                block = np.stack(columns, -1)
                for e, nodes in enumerate(self.nodes):
                    at = (6 * nodes[:, None] + np.arange(6)).ravel()
                    r[at] += f[e]
                    K[np.ix_(at, at)] += block[e]
                r[-6:-3] -= force * load / steps
                r[-3:] -= moment * load / steps  # in a plane: the same in all axes
                d = np.zeros(6 * n)
                d[6:] = np.linalg.solve(K[6:, 6:], -r[6:])
                turn = np.abs(d.reshape(n, 6)[:, 3:]).max()
                d *= min(1, 0.5 / turn) if turn > 0 else 1
                self.p = self.p + d.reshape(n, 6)[:, :3]
                self.q = product(self.q, quaternion(d.reshape(n, 6)[:, 3:]).real)
                self.q /= np.linalg.norm(self.q, axis=-1, keepdims=True)
                iterations += 1
                if np.abs(d).max() < 1e-9 * len(self.nodes) * self.length:
                    break
            else:
                raise RuntimeError('no equilibrium')
        return self.p[-1], iterations


def straight(length):
    return lambda s: (np.array([s, 0, 0]), np.array([1.0, 0, 0, 0]))


def arc(radius):  # in the xy plane, from the origin along x, towards y
    return lambda s: (radius * np.array([np.sin(s / radius), 1 - np.cos(s / radius), 0]),
                      quaternion(np.array([0, 0, s / radius])).real)


def section(h, E, G):
    k = 5 / 6  # shear
    return np.array([E * h * h, k * G * h * h, k * G * h * h, 0.1408 * G * h**4, E * h**4 / 12, E * h**4 / 12])


SLIM = section(0.01, 2.1e11, 0.8e11)
BEND = np.array([1e7, 5e6, 5e6, 5e6 / 6, 1e7 / 12, 1e7 / 12])  # Bathe & Bolourchi 1979, as taken since
PROBLEMS = {
    'rolled up': dict(length=1.0, pose=straight(1), C=SLIM, force=np.zeros(3), moment=np.array([0, 0, 2 * np.pi * SLIM[5]]),
                      steps=6),
    'elastica': dict(length=1.0, pose=straight(1), C=SLIM, force=np.array([0, 10 * SLIM[5], 0]), moment=np.zeros(3),
                     steps=4),
    '45 degrees': dict(length=100 * np.pi / 4, pose=arc(100.0), C=BEND, force=np.array([0, 0, 600.0]),
                       moment=np.zeros(3), steps=8),
}


def main():
    meshes = {'se3': [4, 8, 16, 32, 64], 'linear': [4, 8, 16, 32, 64], 'quadratic': [2, 4, 8, 16, 32]}
    for name, case in PROBLEMS.items():
        if not name.startswith(tuple(sys.argv[1:]) or ''):
            continue

        def tip(kind, n):
            beam = Beam(kind, n, case['length'], case['pose'], case['C'])
            place, iterations = beam.settle(case['force'], case['moment'], case['steps'])
            return place, beam.work, iterations
        tips = {kind: {n: tip(kind, n) for n in counts} for kind, counts in meshes.items()}
        fine, half = tips['quadratic'][32][0], tips['quadratic'][16][0]
        exact = np.zeros(3) if name == 'rolled up' else fine + (fine - half) / 15
        print(f'\n{name}: tip ' + ' '.join(f'{x:.9f}' for x in exact))
        lines = {}
        for kind, counts in meshes.items():
            for n in counts:
                place, work, iterations = tips[kind][n]
                lines.setdefault(kind, []).append((n, np.linalg.norm(place - exact) / case['length'], work, iterations))
        for n in meshes['se3'][1:]:
            a, b = tips['se3'][n // 2], tips['se3'][n]
            place = (4 * b[0] - a[0]) / 3
            lines.setdefault('se3 x', []).append((n, np.linalg.norm(place - exact) / case['length'], a[1] + b[1], b[2]))
        for kind, rows in lines.items():
            for n, error, work, iterations in rows:
                print(f'  {kind:10s} {n:3d} elements  error/L {error:9.2e}  work {work / 1e3:8.1f} k  {iterations} iterations')
        if name == 'rolled up':
            continue
        print('  work for an error of  ' + '  '.join(f'{e:7.0e}' for e in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)))
        for kind, rows in lines.items():
            e, w = np.log([r[1] for r in rows]), np.log([r[2] for r in rows])
            cost = []
            for wanted in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
                x = np.log(wanted)
                i = min(max(np.searchsorted(-e, -x), 1), len(e) - 1)  # between two meshes, or along the last slope
                cost.append(np.exp(w[i - 1] + (x - e[i - 1]) * (w[i] - w[i - 1]) / (e[i] - e[i - 1])) / 1e3)
            print(f'  {kind:20s}  ' + '  '.join(f'{c:7.0f}' for c in cost))


if __name__ == '__main__':
    main()
