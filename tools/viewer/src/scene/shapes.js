// Geometry of the shapes that bodies wear; z is the axis of cylinders, capsules and cones, as in the data.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, ConeGeometry, CylinderGeometry, EdgesGeometry,
  PlaneGeometry, SphereGeometry,
} from 'three';
import { creaseEdges, welded } from './creases.js';

const cache = new Map();
const kCrease = 35; // degrees
const kMeshCrease = 20;

// Sides of round shapes by how many there are: many are small on the screen.
const kDetails = [
  { most: 256, sphere: [32, 20], round: 40, capsule: [8, 28] },
  { most: 2048, sphere: [16, 10], round: 20, capsule: [5, 16] },
  { most: Infinity, sphere: [10, 6], round: 12, capsule: [3, 12] },
];

/** How finely the round shapes of a run are drawn. */
export function detailOf(run) {
  const count = run.bodies.reduce((sum, { shapes }) => sum + shapes.length, 0);
  return kDetails.find(({ most }) => count <= most);
}

function build(shape, extent, { sphere, round, capsule }) {
  const [a, b, c] = shape.size;
  switch (shape.kind) {
    case 'sphere': return new SphereGeometry(a, ...sphere).rotateX(Math.PI / 2);
    case 'box': return new BoxGeometry(a, b, c);
    case 'cylinder': return new CylinderGeometry(a, a, b, round).rotateX(Math.PI / 2);
    case 'capsule': return new CapsuleGeometry(a, b, ...capsule).rotateX(Math.PI / 2);
    case 'cone': return new ConeGeometry(a, b, round).rotateX(Math.PI / 2);
    case 'half_space': return new PlaneGeometry(2.4 * extent, 2.4 * extent);
    default: return null;
  }
}

/** {surface, edges or null, flat} of a shape, one object for equal ones; null for a kind that has no picture. */
export function shapeGeometry(shape, extent, detail) {
  const key = shape.points && shape.triangles ? shape.points : `${shape.kind} ${shape.size.join(' ')} ${extent} ${detail.round}`;
  if (!cache.has(key)) cache.set(key, shape.points && shape.triangles ? meshGeometry(shape) : solidGeometry(shape, extent, detail));
  return cache.get(key);
}

function solidGeometry(shape, extent, detail) {
  const surface = build(shape, extent, detail);
  const smooth = shape.kind === 'sphere' || shape.kind === 'capsule';
  return surface && { surface, edges: smooth ? null : new EdgesGeometry(surface, kCrease), flat: false };
}

/** Of triangles; its edges take its points. */
function meshGeometry({ points, triangles }) {
  const position = new BufferAttribute(Float32Array.from(points), 3);
  const surface = new BufferGeometry().setAttribute('position', position).setIndex(new BufferAttribute(Uint32Array.from(triangles), 1));
  const sharp = Uint32Array.from(creaseEdges(points, triangles, kMeshCrease, welded(points)));
  const edges = new BufferGeometry().setAttribute('position', position).setIndex(new BufferAttribute(sharp, 1));
  return { surface, edges: sharp.length ? edges : null, flat: true };
}

/** Corners of the shape's box in its own frame; none for what has no end. */
export function shapeCorners(shape) {
  const [a, b, c] = shape.size;
  const boxes = {
    sphere: [a, a, a],
    box: [a / 2, b / 2, c / 2],
    cylinder: [a, a, b / 2],
    capsule: [a, a, b / 2 + a],
    cone: [a, a, b / 2],
  };
  if (shape.points) return boundsCorners(shape.points);
  const half = boxes[shape.kind];
  return half ? corners(half.map((x) => -x), half) : [];
}

export function boundsCorners(points) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return points.length ? corners(low, high) : [];
}

function corners(low, high) {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [0, 1, 2].map((c) => ((bits >> c) & 1 ? high[c] : low[c])));
}
