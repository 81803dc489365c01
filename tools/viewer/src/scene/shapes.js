// Geometry of the shapes that bodies wear; z is the axis of cylinders, capsules and cones, as in the data.
import {
  BoxGeometry, BufferAttribute, BufferGeometry, CapsuleGeometry, ConeGeometry, CylinderGeometry, EdgesGeometry,
  PlaneGeometry, SphereGeometry,
} from 'three';

const cache = new Map();

function build(shape, extent) {
  const [a, b, c] = shape.size;
  switch (shape.kind) {
    case 'sphere': return new SphereGeometry(a, 32, 20).rotateX(Math.PI / 2);
    case 'box': return new BoxGeometry(a, b, c);
    case 'cylinder': return new CylinderGeometry(a, a, b, 40).rotateX(Math.PI / 2);
    case 'capsule': return new CapsuleGeometry(a, b, 8, 28).rotateX(Math.PI / 2);
    case 'cone': return new ConeGeometry(a, b, 40).rotateX(Math.PI / 2);
    case 'half_space': return new PlaneGeometry(2.4 * extent, 2.4 * extent);
    default: return null;
  }
}

/** {surface, edges} of a shape, shared between equal ones; null for a kind that has no picture. */
export function shapeGeometry(shape, extent) {
  if (shape.points && shape.triangles) {
    const surface = new BufferGeometry();
    surface.setAttribute('position', new BufferAttribute(Float32Array.from(shape.points), 3));
    surface.setIndex(new BufferAttribute(Uint32Array.from(shape.triangles), 1));
    surface.computeVertexNormals();
    return { surface, edges: new EdgesGeometry(surface, 20), flat: true };
  }
  const key = `${shape.kind} ${shape.size.join(' ')} ${extent}`;
  if (!cache.has(key)) {
    const surface = build(shape, extent);
    cache.set(key, surface && { surface, edges: new EdgesGeometry(surface, 35), flat: false });
  }
  return cache.get(key);
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
