// The bodies of one run in 3D: shapes that are alike together, finite-element bodies one by one.
import { DoubleSide, Group, LineBasicMaterial, LineSegments, MeshLambertMaterial } from 'three';
import { locate, modalCoordinates, rotationAt, vectorAt } from '../motion.js';
import { Instances } from './instances.js';
import { MeshBody } from './mesh_body.js';
import { detailOf, shapeGeometry } from './shapes.js';

export const setRotation = (object, [w, x, y, z]) => object.quaternion.set(x, y, z, w);

const kBehindLines = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
const at_rest = { position: [0, 0, 0], rotation: [1, 0, 0, 0] };

/** A contact shape is drawn, as lines, where something better is there only when asked for. */
function isSpare(body, shape) {
  return shape.role === 'contact' && (body.mesh !== null || body.shapes.some((one) => one.role !== 'contact'));
}

export class RunScene {
  constructor(model, run, extent) {
    this.run = run;
    this.group = new Group();
    this.owners = run.bodies.map((body) => model.bodyEntry(run.index, body.index).index);
    this.poses = new Float64Array(7 * run.bodies.length);
    this.materials = {
      solid: new MeshLambertMaterial(kBehindLines),
      flat: new MeshLambertMaterial({ ...kBehindLines, flatShading: true, side: DoubleSide }),
      plane: new MeshLambertMaterial({ transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false }),
      edges: new LineBasicMaterial({ transparent: true, opacity: 0.55 }),
      selected: new LineBasicMaterial(),
    };
    this.#addShapes(run, extent);
    this.meshes = run.bodies.filter((body) => body.mesh).map((body) => this.#addMesh(body));
    this.chosen = { body: -1, group: new Group() };
    this.group.add(this.chosen.group);
  }

  #addShapes(run, extent) {
    const detail = detailOf(run);
    const alike = new Map(); // geometry -> members, apart for those that are lines alone
    this.shapes = run.bodies.map(() => []); // {geometry, shape} of a body, for the edges of the selected one
    for (const body of run.bodies) {
      for (const shape of body.shapes) {
        const geometry = shapeGeometry(shape, extent, detail);
        if (!geometry) continue;
        if (!alike.has(geometry)) alike.set(geometry, { kind: shape.kind, solid: [], spare: [] });
        const spare = isSpare(body, shape);
        alike.get(geometry)[spare ? 'spare' : 'solid'].push({ body: body.index, index: this.owners[body.index], position: shape.position, rotation: shape.rotation });
        if (geometry.edges && !spare) this.shapes[body.index].push({ geometry, shape });
      }
    }
    this.instances = [];
    this.spares = [];
    const { solid, flat, plane, edges } = this.materials;
    for (const [geometry, members] of alike) {
      const surface = members.kind === 'half_space' ? plane : geometry.flat ? flat : solid;
      if (members.solid.length) this.instances.push(new Instances(geometry, members.solid, surface, edges));
      if (members.spare.length && geometry.edges) this.spares.push(new Instances(geometry, members.spare, null, edges));
    }
    for (const { parts } of [...this.instances, ...this.spares]) this.group.add(...parts);
  }

  #addMesh(body) {
    const group = new Group();
    group.userData = { kind: 'body', index: this.owners[body.index] };
    const mesh_body = new MeshBody(body.mesh, '#888');
    group.add(...mesh_body.parts);
    this.group.add(group);
    return { body, index: this.owners[body.index], group, mesh_body };
  }

  /** Colours, `of(body of the run)` a body's, and whether one sees through. */
  dress({ of, edge, opacity, selected, accent, field, show }) {
    const see_through = opacity < 1;
    for (const material of [this.materials.solid, this.materials.flat, ...this.meshes.map((one) => one.mesh_body.material)]) {
      if (material.transparent !== see_through) material.needsUpdate = true;
      material.transparent = see_through;
      material.opacity = opacity;
      material.polygonOffsetFactor = see_through ? 4 : 1; // where variants coincide the solid one is in front
    }
    this.materials.edges.color.set(edge);
    this.materials.selected.color.set(accent);
    for (const one of this.instances) {
      one.dress((i) => (this.owners[i] === selected ? of(i).add(accent.clone().multiplyScalar(0.35)) : of(i)));
      if (one.edges) one.edges.visible = show.edges;
    }
    for (const one of this.spares) one.edges.visible = show.contact_shapes;
    for (const one of this.meshes) one.mesh_body.dress({ colour: of(one.body.index), edge, selected: one.index === selected, accent, field, show });
    this.#choose(this.owners.indexOf(selected));
  }

  /** The selected body's edges are drawn beside those of all. */
  #choose(body) {
    if (this.chosen.body === body) return;
    this.chosen.body = body;
    this.chosen.group.clear();
    for (const { geometry, shape } of this.shapes[body] ?? []) {
      const edges = new LineSegments(geometry.edges, this.materials.selected);
      edges.position.set(...shape.position);
      setRotation(edges, shape.rotation);
      edges.raycast = () => {};
      this.chosen.group.add(edges);
    }
  }

  /** `mode`: {body: index in the run, eta} of a mode shape to show instead of the motion, or null. */
  update(view, mode) {
    const { run, poses } = this;
    const at = locate(run.times, view.time);
    for (const { index, position, rotation } of run.bodies) {
      const p = position ? vectorAt(position, at, scratch.position) : at_rest.position;
      const q = rotation ? rotationAt(rotation, at, scratch.rotation) : at_rest.rotation;
      for (let c = 0; c < 3; ++c) poses[7 * index + c] = p[c];
      for (let c = 0; c < 4; ++c) poses[7 * index + 3 + c] = q[c];
    }
    for (const one of this.instances) one.update(poses);
    if (view.show.contact_shapes) for (const one of this.spares) one.update(poses);
    for (const { body, group, mesh_body } of this.meshes) {
      this.#place(group, body.index);
      const shape = mode?.body === body.index ? mode.eta : null;
      mesh_body.deform(shape ?? modalCoordinates(body.mesh, at), shape ? 1 : view.magnification);
    }
    if (this.chosen.body >= 0) this.#place(this.chosen.group, this.chosen.body);
  }

  #place(group, body) {
    group.position.fromArray(this.poses, 7 * body);
    setRotation(group, this.poses.subarray(7 * body + 3, 7 * body + 7));
  }
}

const scratch = { position: [0, 0, 0], rotation: [1, 0, 0, 0] };
