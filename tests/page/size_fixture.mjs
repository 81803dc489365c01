// Makes pages of a size, from the bundled viewer: node size_fixture.mjs VIEWER.html FOLDER writes bodies.html (10,000 balls
// and cubes on a wave), triangles.html (a rigid ring of a million triangles) and deforming.html (one that bends).
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { Arrays, pageOf } from './fixture.mjs';

const kFrames = 13;
const kAcross = 100; // bodies along either side
const kSides = [1000, 500]; // of the ring, long way and short way round: two triangles each
const times = Array.from({ length: kFrames }, (_, i) => (2 * i) / (kFrames - 1));

const run = (arrays, name, bodies) => ({
  name, gravity: [0, 0, -9.81], times: arrays.add(Float64Array.from(times)), bodies, markers: [], connectors: [], contacts: null, traces: [], channels: [], events: [],
});

function manyBodies() {
  const arrays = new Arrays();
  const bodies = Array.from({ length: kAcross * kAcross }, (_, k) => {
    const [i, j] = [k % kAcross, Math.floor(k / kAcross)];
    return {
      name: `${k % 2 ? 'cube' : 'ball'} ${k}`, kind: 'RigidBody', frame: false, mesh: null,
      position: arrays.add(Float32Array.from(times.flatMap((t) => [i, j, 2 * Math.sin(0.2 * i + 0.1 * j + 3 * t)]))),
      rotation: arrays.add(Float32Array.from(times.flatMap((t) => [Math.cos(t + k), 0, Math.sin(t + k), 0]))),
      shapes: [{ kind: k % 2 ? 'box' : 'sphere', size: k % 2 ? [0.6, 0.6, 0.6] : [0.4], role: 'visual' }],
    };
  });
  return ['bodies', arrays, [run(arrays, 'wave', bodies)]];
}

/** Points and triangles of a ring about z. */
function ring() {
  const [n, m] = kSides;
  const points = new Float32Array(3 * n * m);
  const triangles = new Uint32Array(6 * n * m);
  for (let i = 0; i < n; ++i) {
    for (let j = 0; j < m; ++j) {
      const [a, b] = [(2 * Math.PI * i) / n, (2 * Math.PI * j) / m];
      const reach = 1 + 0.3 * Math.cos(b);
      points.set([reach * Math.cos(a), reach * Math.sin(a), 0.3 * Math.sin(b)], 3 * (i * m + j));
      const [p, q] = [i * m + j, ((i + 1) % n) * m + j];
      const [r, s] = [i * m + ((j + 1) % m), ((i + 1) % n) * m + ((j + 1) % m)];
      triangles.set([p, q, s, p, s, r], 6 * (i * m + j));
    }
  }
  return { points, triangles };
}

const turning = (arrays) => arrays.add(Float32Array.from(times.flatMap((t) => [Math.cos(t), 0, Math.sin(t), 0])));

function rigidRing() {
  const arrays = new Arrays();
  const { points, triangles } = ring();
  const shape = { kind: 'mesh', size: [], role: 'visual', points: arrays.add(points), triangles: arrays.add(triangles) };
  return ['triangles', arrays, [run(arrays, 'ring', [{ name: 'ring', kind: 'RigidBody', frame: false, mesh: null, rotation: turning(arrays), shapes: [shape] }])]];
}

/** Its plane bends to a saddle. */
function bendingRing() {
  const arrays = new Arrays();
  const { points, triangles } = ring();
  const shapes = new Float32Array(points.length);
  for (let i = 0; i < points.length; i += 3) shapes[i + 2] = points[i] ** 2 - points[i + 1] ** 2;
  const mesh = {
    points: arrays.add(points), triangles: arrays.add(triangles), edges: null, modes: [{ name: 'saddle', frequency: 1 }], natural: true, pairs: null, stress: null, fields: [],
    coordinates: arrays.add(Float64Array.from(times, (t) => 0.4 * Math.sin(4 * t))), shapes: arrays.add(shapes),
  };
  return ['deforming', arrays, [run(arrays, 'ring', [{ name: 'ring', kind: 'FlexibleBody', frame: false, shapes: [], mesh, rotation: turning(arrays) }])]];
}

const [viewer, folder] = process.argv.slice(2);
for (const [name, arrays, runs] of [manyBodies(), rigidRing(), bendingRing()]) {
  writeFileSync(join(folder, `${name}.html`), pageOf(readFileSync(viewer, 'utf8'), name, arrays, runs));
}
