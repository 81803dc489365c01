// Small solids that tell a connector's kind by their form, about one unit in size, the joint's axis along z.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, OctahedronGeometry, SphereGeometry,
  TorusGeometry,
} from 'three';
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';

const rod = (radius, length, x = 0, y = 0, z = 0) =>
  new CylinderGeometry(radius, radius, length, 20).rotateX(Math.PI / 2).translate(x, y, z);
const ball = (radius) => new SphereGeometry(radius, 20, 14);
const box = (x, y, z) => new BoxGeometry(x, y, z);
const ring = (radius, tube, arc = 2 * Math.PI, z = 0) =>
  new TorusGeometry(radius, tube, 10, 36, arc).translate(0, 0, z);

const turned = () => [
  ring(0.75, 0.1, 1.6 * Math.PI),
  new ConeGeometry(0.26, 0.5, 16).rotateZ(1.6 * Math.PI).translate(0.75 * Math.cos(1.66 * Math.PI), 0.75 * Math.sin(1.66 * Math.PI), 0),
];

// The first word found in the type's name decides.
const kForms = [
  ['revolute', () => [rod(0.42, 1.1), rod(0.07, 2.4)]],
  ['spherical', () => [ball(0.5), ring(0.62, 0.06)]],
  ['screw', () => [rod(0.3, 1.8), rod(0.07, 3.2), ring(0.34, 0.08, 2 * Math.PI, -0.5), ring(0.34, 0.08), ring(0.34, 0.08, 2 * Math.PI, 0.5)]],
  ['cylindrical', () => [rod(0.34, 1.8), rod(0.12, 3.2)]],
  ['prismatic', () => [box(0.62, 0.62, 1.6), box(0.16, 0.16, 3.2)]],
  ['universal', () => [rod(0.14, 1.7).rotateY(Math.PI / 2), rod(0.14, 1.7).rotateX(Math.PI / 2), ball(0.3)]],
  ['constantvelocity', () => [ball(0.36), rod(0.5, 0.5)]],
  ['planar', () => [box(1.9, 1.9, 0.12), rod(0.08, 1.2, 0, 0, 0.6)]],
  ['pointonline', () => [ball(0.34), rod(0.07, 3.2)]],
  ['pointonplane', () => [ball(0.3).translate(0, 0, 0.3), box(1.9, 1.9, 0.08)]],
  ['threenode', () => [box(0.6, 0.6, 0.6)]],
  ['fixed', () => [box(0.7, 0.7, 0.7)]],
  ['gear', () => [ring(0.8, 0.14), rod(0.2, 0.4)]],
  ['rack', () => [ring(0.8, 0.14), box(2.4, 0.2, 0.3).translate(0, -0.95, 0)]],
  ['rolling', () => [ring(0.8, 0.1)]],
  ['bushing', () => [ring(0.5, 0.24)]],
  ['friction', () => [ring(0.55, 0.12)]],
  ['drive', turned],
  ['motor', turned],
  ['controller', turned],
  ['distance', () => [ball(0.3)]],
  ['rod', () => [ball(0.3)]],
  ['spring', () => [ball(0.26)]],
];

const forms = new Map();

/** The solid of a type of connector; an octahedron for one that has no form of its own. */
export function glyphGeometry(kind) {
  const word = kind.toLowerCase().replaceAll('_', '');
  const key = kForms.find(([name]) => word.includes(name))?.[0] ?? '';
  if (!forms.has(key)) {
    const parts = key ? kForms.find(([name]) => name === key)[1]() : [new OctahedronGeometry(0.55)];
    forms.set(key, mergeGeometries(parts.map((part) => (part.index ? part.toNonIndexed() : part))));
  }
  return forms.get(key);
}

/** A line from 0 to z = 1: a coil for springs, else a rod; to be scaled to its ends. */
export function linkGeometry(kind) {
  const coil = kind.toLowerCase().includes('spring');
  const key = coil ? 'coil' : 'link';
  if (!forms.has(key)) forms.set(key, coil ? coilGeometry() : rod(0.1, 1, 0, 0, 0.5));
  return forms.get(key);
}

/** A helix of eight turns with straight ends, as a tube of little squares. */
function coilGeometry() {
  const path = [];
  const kTurns = 8;
  const kWire = 0.07;
  const kSteps = 14 * kTurns;
  path.push([0, 0, 0], [0, 0, 0.12]);
  for (let i = 0; i <= kSteps; ++i) {
    const angle = (2 * Math.PI * kTurns * i) / kSteps;
    path.push([0.4 * Math.cos(angle), 0.4 * Math.sin(angle), 0.16 + (0.68 * i) / kSteps]);
  }
  path.push([0, 0, 0.88], [0, 0, 1]);
  const points = [];
  const index = [];
  path.forEach(([x, y, z], i) => {
    const radius = Math.hypot(x, y);
    // Corners across the wire: outwards and along z; the coil is stretched along z alone, so z is kept thin.
    const [a, b] = radius > 0 ? [[(kWire * x) / radius, (kWire * y) / radius, 0], [0, 0, 0.012]] : [[kWire, 0, 0], [0, kWire, 0]];
    for (const [side, sign] of [[a, 1], [b, 1], [a, -1], [b, -1]]) points.push(x + sign * side[0], y + sign * side[1], z + sign * side[2]);
    if (i === 0) return;
    for (let side = 0; side < 4; ++side) {
      const [one, next] = [4 * (i - 1) + side, 4 * (i - 1) + ((side + 1) % 4)];
      index.push(one, next, one + 4, next, next + 4, one + 4);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
  return geometry;
}
