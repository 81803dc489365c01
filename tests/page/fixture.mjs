// Makes a small page of known motion from the bundled viewer, so that the viewer is tested without a run of the engine:
// a pendulum, rigid and flexible, whose tips follow closed formulas. node fixture.mjs VIEWER.html OUT.html [broken]
import { readFileSync, writeFileSync } from 'node:fs';
import { deflateSync } from 'node:zlib';

/** One buffer of arrays, each at a multiple of 8 bytes. */
export class Arrays {
  #chunks = [];
  #size = 0;

  add(array, extra = {}) {
    const type = { Float64Array: 'f64', Float32Array: 'f32', Uint32Array: 'u32', Uint16Array: 'u16', Int16Array: 'i16' }[array.constructor.name];
    const at = this.#size;
    const bytes = Buffer.from(array.buffer, array.byteOffset, array.byteLength);
    const padding = Buffer.alloc((8 - (bytes.length % 8)) % 8);
    this.#chunks.push(bytes, padding);
    this.#size += bytes.length + padding.length;
    return { at, n: array.length, type, ...extra };
  }

  packed() {
    return deflateSync(Buffer.concat(this.#chunks)).toString('base64');
  }
}

const kLength = 1;
const kFrames = 101;
export const kEnd = 2;

/** Angle of the pendulum below the horizontal. */
export const angle = (t, flexible) => 1.2 * Math.sin(3 * t) * (flexible ? Math.exp(-0.05 * t) : 1) + 0.3 * t;
/** First modal coordinate of the flexible one, and the second. */
export const eta = (t) => [0.06 * Math.sin(9 * t), 0.02 * Math.sin(31 * t)];
/** Deflection of mode k at the part x of the length. */
const bend = [(x) => x * x * (3 - x) / 2, (x) => x * x * (x - 0.62) * 2.6];

/** A bar of n_x x n_y x n_z bricks: its boundary as points, triangles and edges. */
function bar(nx, ny, nz, [lx, ly, lz]) {
  const index = new Map();
  const points = [];
  const triangles = [];
  const edges = new Set();
  const node = (i, j, k) => {
    const key = `${i},${j},${k}`;
    if (!index.has(key)) {
      index.set(key, points.length / 3);
      points.push((i / nx) * lx, (j / ny - 0.5) * ly, (k / nz - 0.5) * lz);
    }
    return index.get(key);
  };
  const quad = (a, b, c, d) => {
    triangles.push(a, b, c, a, c, d);
    for (const [p, q] of [[a, b], [b, c], [c, d], [d, a]]) edges.add(p < q ? `${p},${q}` : `${q},${p}`);
  };
  for (let i = 0; i < nx; ++i) {
    for (let j = 0; j < ny; ++j) {
      quad(node(i, j, 0), node(i, j + 1, 0), node(i + 1, j + 1, 0), node(i + 1, j, 0));
      quad(node(i, j, nz), node(i + 1, j, nz), node(i + 1, j + 1, nz), node(i, j + 1, nz));
    }
    for (let k = 0; k < nz; ++k) {
      quad(node(i, 0, k), node(i + 1, 0, k), node(i + 1, 0, k + 1), node(i, 0, k + 1));
      quad(node(i, ny, k), node(i, ny, k + 1), node(i + 1, ny, k + 1), node(i + 1, ny, k));
    }
  }
  for (let j = 0; j < ny; ++j) {
    for (let k = 0; k < nz; ++k) {
      quad(node(0, j, k), node(0, j, k + 1), node(0, j + 1, k + 1), node(0, j + 1, k));
      quad(node(nx, j, k), node(nx, j + 1, k), node(nx, j + 1, k + 1), node(nx, j, k + 1));
    }
  }
  return { points, triangles, edges: [...edges].flatMap((pair) => pair.split(',').map(Number)), node };
}

const quantised = (arrays, values) => {
  const scale = Math.max(...values.map(Math.abs)) / 32767 || 1;
  return arrays.add(Int16Array.from(values, (value) => Math.round(value / scale)), { scale });
};

const kHinge = [Math.SQRT1_2, -Math.SQRT1_2, 0, 0]; // takes z to y

function flexibleMesh(arrays, times) {
  const { points, triangles, edges, node } = bar(40, 2, 2, [kLength, 0.05, 0.05]);
  const n = points.length / 3;
  const shapes = bend.flatMap((w) => Array.from({ length: n }, (_, i) => [0, 0, w(points[3 * i] / kLength)]).flat());
  const stress = bend.flatMap((w) => Array.from({ length: n }, (_, i) => {
    const x = points[3 * i] / kLength;
    const h = 1e-3;
    const curvature = (w(x + h) - 2 * w(x) + w(x - h)) / (h * h);
    return [-2.1e11 * points[3 * i + 2] * curvature * 1e-3, 0, 0, 0, 0, 1e4 * (1 - x)];
  }).flat());
  return {
    tip: node(40, 1, 1),
    mesh: {
      points: arrays.add(Float32Array.from(points)),
      triangles: arrays.add(Uint32Array.from(triangles)),
      edges: arrays.add(Uint32Array.from(edges)),
      coordinates: arrays.add(Float64Array.from(times.flatMap(eta))),
      shapes: arrays.add(Float32Array.from(shapes)),
      modes: [{ name: 'mode 1', frequency: 42.13 }, { name: 'mode 2', frequency: 261.9 }],
      natural: true,
      pairs: null,
      stress: { unit: 'Pa', shapes: quantised(arrays, stress), static: null },
      fields: [{ name: 'damage', unit: '', values: arrays.add(Float32Array.from({ length: n }, (_, i) => 0.25 * (points[3 * i] / kLength))) }],
    },
  };
}

/** None, one, two points in touch, and again; forces turn and grow. */
function contacts(arrays, times) {
  const first = [0];
  const [points, forces] = [[], []];
  times.forEach((t, i) => {
    for (let c = 0; c < i % 3; ++c) {
      points.push(0.3 + 0.3 * c, 0, -0.5);
      forces.push((c + 1) * 3, 2 * Math.sin(3 * t), (c + 1) * (6 + 3 * Math.cos(2 * t)));
    }
    first.push(points.length / 3);
  });
  return {
    first: arrays.add(Uint32Array.from(first)), points: arrays.add(Float32Array.from(points)), forces: arrays.add(Float32Array.from(forces)),
    pair: arrays.add(new Uint16Array(points.length / 3).fill(1)),
  };
}

function makeRun(arrays, name, flexible) {
  const times = Array.from({ length: kFrames }, (_, i) => (kEnd * i) / (kFrames - 1));
  const angles = times.map((t) => angle(t, flexible));
  const flexible_part = flexible ? flexibleMesh(arrays, times) : null;
  // The frame sits in the pin; x along the bar, turned by the angle about y.
  const pose = {
    position: arrays.add(new Float32Array(kFrames * 3)),
    rotation: arrays.add(Float32Array.from(angles.flatMap((a) => [Math.cos(a / 2), 0, Math.sin(a / 2), 0]))),
  };
  const tip = times.map((t, i) => {
    const w = flexible ? eta(t)[0] * bend[0](1) + eta(t)[1] * bend[1](1) : 0;
    const [c, s] = [Math.cos(angles[i]), Math.sin(angles[i])];
    return [kLength * c + w * s, 0, -kLength * s + w * c];
  });
  const touch = contacts(arrays, times);
  const force = times.flatMap((t) => [5 * Math.sin(3 * t), 0, 9.81 + 6 * Math.cos(6 * t)]);
  return {
    name,
    gravity: [0, 0, -9.81],
    times: arrays.add(Float64Array.from(times)),
    bodies: [
      { name: 'ground', kind: 'Ground', frame: false, shapes: [] },
      { name: 'link', kind: flexible ? 'FlexibleBody' : 'RigidBody', frame: false, ...pose,
        shapes: flexible ? [] : [
          { kind: 'box', size: [kLength, 0.05, 0.05], position: [kLength / 2, 0, 0], rotation: [1, 0, 0, 0], role: 'visual' },
          { kind: 'box', size: [0.1, 0.1, 0.1], position: [kLength, 0, 0], rotation: [1, 0, 0, 0], role: 'contact' },
        ],
        mesh: flexible_part?.mesh ?? null },
      // A ball behind the tip: what moves by its frame.
      { name: 'ball', kind: 'RigidBody', frame: false, mesh: null, position: arrays.add(Float32Array.from(tip.flatMap(([x, y, z]) => [x, y + 0.3, z]))),
        shapes: [{ kind: 'sphere', size: [0.04], position: [0, 0, 0], rotation: [1, 0, 0, 0], role: 'visual' }] },
    ],
    markers: [
      { name: 'ground', body: 0, position: [0, 0, 0], rotation: kHinge, node: null },
      { name: 'root', body: 1, position: [0, 0, 0], rotation: kHinge, node: null },
      { name: 'tip', body: 1, position: [kLength, 0, 0], rotation: [1, 0, 0, 0], node: flexible_part?.tip ?? null },
    ],
    connectors: [{
      name: 'pin', kind: 'RevoluteJoint', role: 'joint', bodies: [0, 1], markers: [0, 1], where: 'fixture.mjs:1',
      reaction: {
        point: arrays.add(new Float32Array(kFrames * 3)),
        force: arrays.add(Float32Array.from(force)),
        moment: arrays.add(Float32Array.from(times.flatMap((t) => [0, 0, Math.sin(t)]))),
      },
    }, { name: 'touch', kind: 'Contact', role: 'contact', bodies: [0, 1], markers: [0, 1], where: 'fixture.mjs:2' }],
    contacts: touch,
    traces: [{ name: 'tip', points: arrays.add(Float32Array.from(tip.flat())) }],
    channels: ['x', 'y', 'z'].map((axis, c) => ({
      name: `tip_${axis}`, unit: 'm', group: 'recorded', body: 1, connector: null, values: arrays.add(Float64Array.from(tip.map((p) => p[c]))),
    })).concat([
      { name: 'pin residual', unit: 'm', group: 'residual', body: null, connector: 0, values: arrays.add(Float64Array.from(times.map((t) => 1e-12 * Math.sin(20 * t)))) },
      { name: 'energy', unit: 'J', group: 'energy', body: null, connector: null, values: arrays.add(Float64Array.from(times.map((t) => 1 - 1e-4 * t))) },
    ]),
    events: [{ time: 0.75, name: 'released' }],
  };
}

/** A page as text, from the viewer as text; `keep` cuts its numbers. */
export function pageOf(viewer, title, arrays, runs, { keep = Infinity, findings = [] } = {}) {
  const scene = JSON.stringify({ format: 'lithe-page', version: 1, title, made_by: 'fixture', findings, runs }).replaceAll('<', '\\u003c');
  return viewer.replace('<!--LITHE-DATA-->', () =>
    `<script type="application/json" id="lithe-scene">${scene}</script>\n<script type="text/plain" id="lithe-data">${arrays.packed().slice(0, keep)}</script>`);
}

/** The pendulums' page. `broken` spoils the numbers. */
export function fixturePage(viewer, broken = false) {
  const arrays = new Arrays();
  const runs = [makeRun(arrays, 'rigid', false), makeRun(arrays, 'flexible', true)];
  const findings = [
    { kind: 'open joint', text: "'pin' is open by 2 mm between 'link' and 'no such body' <b>", fix: "move the marker of 'link'", alarm: true },
    { kind: 'redundant rows', text: 'one row repeats another', fix: '', alarm: false },
  ];
  return pageOf(viewer, 'Pendulum of known motion', arrays, runs, { keep: broken ? 400 : Infinity, findings });
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const [viewer, out, broken] = process.argv.slice(2);
  writeFileSync(out, fixturePage(readFileSync(viewer, 'utf8'), broken === 'broken'));
}
