// Fields on a finite-element mesh: displacement and stress, from the modal coordinates; fields that stay the same over a
// run, such as damage.
import { displacements, modalCoordinates } from '../motion.js';

const kComponents = ['σxx', 'σyy', 'σzz', 'τxy', 'τyz', 'τzx'];
const kStresses = ['von Mises', ...kComponents];

/** The fields that the model's meshes can show, 'plain' first. */
export function fieldNames(model) {
  const meshes = model.runs.flatMap((run) => run.bodies.map((body) => body.mesh)).filter(Boolean);
  if (!meshes.length) return ['plain'];
  const stress = meshes.some((mesh) => mesh.stress) ? kStresses : [];
  const constant = meshes.flatMap((mesh) => mesh.fields.map((field) => field.name));
  return ['plain', 'displacement', ...stress, ...new Set(constant)];
}

export function fieldUnit(name, model) {
  if (name === 'displacement') return 'm';
  const fields = model.runs.flatMap((run) => run.bodies.flatMap((body) => body.mesh?.fields ?? []));
  return fields.find((field) => field.name === name)?.unit ?? 'Pa';
}

/** Equivalent stress of von Mises from xx, yy, zz, xy, yz, zx. */
function vonMises(s, at) {
  const [a, b, c] = [s[at] - s[at + 1], s[at + 1] - s[at + 2], s[at + 2] - s[at]];
  const shear = s[at + 3] ** 2 + s[at + 4] ** 2 + s[at + 5] ** 2;
  return Math.sqrt(0.5 * (a * a + b * b + c * c) + 3 * shear);
}

/** Evaluates one field on one mesh; keeps its scratch. */
export class FieldOnMesh {
  constructor(mesh) {
    this.mesh = mesh;
    this.values = new Float32Array(mesh.count);
  }

  has(name) {
    return name === 'displacement' || this.constant(name) !== undefined || (kStresses.includes(name) && this.mesh.stress !== null);
  }

  constant(name) {
    return this.mesh.fields.find((field) => field.name === name);
  }

  /** `u` are the displacements at `eta`, if known already. Returns values a point. */
  evaluate(name, eta, u) {
    const { mesh, values } = this;
    const n = mesh.count;
    if (name === 'displacement') {
      const moved = u ?? displacements(mesh, eta, (this.scratch ??= new Float32Array(n * 3)));
      for (let i = 0; i < n; ++i) values[i] = Math.hypot(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]);
      return values;
    }
    const constant = this.constant(name);
    if (constant) return constant.values;
    const s = (this.stress ??= new Float32Array(n * 6));
    if (mesh.stress.static) s.set(mesh.stress.static);
    else s.fill(0);
    const shapes = mesh.stress.shapes;
    for (let k = 0; k < eta.length; ++k) {
      const factor = eta[k];
      const begin = k * n * 6;
      if (factor !== 0) for (let c = 0; c < n * 6; ++c) s[c] += factor * shapes[begin + c];
    }
    if (name === 'von Mises') {
      for (let i = 0; i < n; ++i) values[i] = vonMises(s, 6 * i);
    } else {
      const component = kComponents.indexOf(name);
      for (let i = 0; i < n; ++i) values[i] = s[6 * i + component];
    }
    return values;
  }

  /** Smallest and largest value over the run: over all frames, or evenly chosen ones where that would take long. */
  range(name) {
    const { mesh } = this;
    const modes = mesh.modes.length;
    const frames = mesh.nodal ? mesh.nodal.length / mesh.points.length : mesh.coordinates ? mesh.coordinates.length / Math.max(1, modes) : 1;
    const affordable = Math.max(20, Math.floor(4e7 / (mesh.count * 6 * Math.max(1, modes))));
    const step = Math.max(1, Math.ceil(frames / affordable));
    const range = [Infinity, -Infinity];
    for (let frame = 0; frame < frames; frame += step) {
      extend(range, this.evaluate(name, modalCoordinates(mesh, { i: frame, j: frame, w: 0 })));
    }
    return range;
  }
}

export function extend(range, values) {
  for (const value of values) {
    if (value < range[0]) range[0] = value;
    if (value > range[1]) range[1] = value;
  }
  return range;
}
