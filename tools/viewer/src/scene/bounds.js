// Boxes around what bodies wear, before anything is built: for fits, and for the size of planes without end.
import { bodyPose, rotate } from '../motion.js';
import { boundsCorners, shapeCorners } from './shapes.js';

const kMostPoints = 250000; // over the sampled motion
const kSampledFrames = 40;

/** A point in the frame of a pose, in that pose's outer frame. */
const moved = ({ position, rotation }, point) => rotate(rotation, point).map((value, c) => value + position[c]);

/** Corners of the boxes of all that a body wears, in its own axes. */
function bodyCorners(body) {
  const corners = body.mesh ? boundsCorners(body.mesh.points) : [];
  for (const shape of body.shapes) for (const corner of shapeCorners(shape)) corners.push(moved(shape, corner));
  return corners;
}

export class Bounds {
  constructor(run) {
    this.run = run;
    this.corners = run.bodies.map(bodyCorners);
    this.count = this.corners.reduce((sum, list) => sum + list.length, 0);
  }

  /** Corners at frame i, world axes, of all bodies or one; those that are finite. */
  at(frame, only = null) {
    const at = { i: frame, j: frame, w: 0 };
    const out = [];
    for (const body of only === null ? this.run.bodies : [this.run.bodies[only]]) {
      const pose = bodyPose(body, at);
      for (const corner of this.corners[body.index]) {
        const point = moved(pose, corner);
        if (point.every(Number.isFinite)) out.push(point);
      }
    }
    return out;
  }

  /** Corners over the motion: of as many frames as are soon looked at, the first and the last among them. */
  sampled() {
    const last = this.run.frames - 1;
    const frames = Math.max(2, Math.min(kSampledFrames, Math.floor(kMostPoints / (this.count || 1)), last + 1));
    const out = [];
    const seen = new Set(Array.from({ length: frames }, (_, k) => Math.round((k * last) / (frames - 1))));
    for (const frame of seen) for (const point of this.at(frame)) out.push(point);
    return out;
  }
}

/** The least and the largest of each coordinate: [low, high]. */
export function box(points) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const point of points) {
    for (let c = 0; c < 3; ++c) {
      low[c] = Math.min(low[c], point[c]);
      high[c] = Math.max(high[c], point[c]);
    }
  }
  return [low, high];
}
