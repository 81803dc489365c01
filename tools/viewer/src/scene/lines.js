// Traces, marker axes and the grid: what is drawn as lines.
import { BufferAttribute, BufferGeometry, Color, Group, LineBasicMaterial, LineSegments } from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { bodyPose, locate } from '../motion.js';
import { niceBelow } from '../format.js';
import { markerAxes } from './connector_view.js';

/** Recorded paths: what is behind in full, what is ahead faint; each variant with its own dash. */
export class Traces {
  constructor(run, dash) {
    this.run = run;
    this.group = new Group();
    this.materials = [0, 1].map((ahead) => new LineMaterial({ linewidth: ahead ? 1.2 : 2.2, dashed: dash.length > 0, transparent: true, opacity: ahead ? 0.35 : 1 }));
    this.lines = [];
    for (const trace of run.traces) {
      const pair = this.materials.map((material) => new Line2(new LineGeometry(), material));
      for (const line of pair) {
        line.frustumCulled = false;
        line.raycast = () => {}; // not picked
        this.group.add(line);
      }
      this.lines.push({ trace, pair });
    }
    this.dash = dash;
    this.grow();
  }

  /** Takes the paths as they are by now. */
  grow() {
    for (const { trace, pair } of this.lines) {
      for (const line of pair) {
        line.visible = this.run.frames > 1;
        if (!line.visible) continue;
        line.geometry.dispose();
        line.geometry = new LineGeometry().setPositions(trace.points);
        line.computeLineDistances();
      }
    }
    this.frames = this.run.frames;
  }

  update(view) {
    this.group.visible = view.show.traces;
    const { i } = locate(this.run.times, view.time);
    for (const { pair: [behind, ahead] } of this.lines) {
      behind.geometry.instanceCount = Math.min(i, this.frames - 1);
      ahead.geometry.instanceCount = this.frames - 1;
    }
  }

  dress(colour, extent) {
    for (const material of this.materials) {
      material.color.set(colour);
      if (!this.dash.length) continue;
      material.dashSize = extent * 0.0028 * this.dash[0];
      material.gapSize = extent * 0.0028 * this.dash[1];
    }
  }
}

/** Axes x, y, z of every marker. */
export class MarkerAxes {
  constructor(run) {
    this.run = run;
    this.array = new Float32Array(run.markers.length * 18);
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(this.array, 3));
    this.colours = new BufferAttribute(new Float32Array(run.markers.length * 18), 3);
    geometry.setAttribute('color', this.colours);
    this.lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true, depthTest: false, transparent: true }));
    this.lines.frustumCulled = false;
    this.lines.renderOrder = 3;
    this.lines.raycast = () => {}; // not picked
  }

  update(view, length) {
    this.lines.visible = view.show.markers;
    if (!view.show.markers) return;
    const at = locate(this.run.times, view.time);
    const poses = this.run.bodies.map((body) => bodyPose(body, at));
    markerAxes(this.run, at, poses, length, view, this.array);
    this.lines.geometry.attributes.position.needsUpdate = true;
  }

  dress(axis_colours) {
    const colours = axis_colours.map((one) => new Color(one));
    for (let i = 0; i < this.colours.count; ++i) {
      const colour = colours[Math.floor(i / 2) % 3];
      this.colours.setXYZ(i, colour.r, colour.g, colour.b);
    }
    this.colours.needsUpdate = true;
  }
}

/** A square of lines across `up` through `centre`; returns the lines and their spacing in metres. */
export function makeGrid(extent, centre, up) {
  const spacing = niceBelow(extent / 8);
  const half = Math.ceil((0.75 * extent) / spacing);
  const a = up === 0 ? 1 : 0;
  const b = up === 2 ? 1 : 2;
  const at = [...centre];
  at[a] = Math.round(centre[a] / spacing) * spacing;
  at[b] = Math.round(centre[b] / spacing) * spacing;
  const points = [];
  const push = (da, db) => {
    const point = [...at];
    point[a] += da * spacing;
    point[b] += db * spacing;
    points.push(...point);
  };
  for (let i = -half; i <= half; ++i) {
    push(i, -half);
    push(i, half);
    push(-half, i);
    push(half, i);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  const lines = new LineSegments(geometry, new LineBasicMaterial({ transparent: true, opacity: 0.9, depthWrite: false }));
  return { lines, spacing };
}

