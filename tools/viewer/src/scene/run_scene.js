// The bodies of one run in 3D.
import { DoubleSide, Group, LineBasicMaterial, LineSegments, Mesh, MeshLambertMaterial } from 'three';
import { bodyPose, locate, modalCoordinates, rotate } from '../motion.js';
import { boundsCorners, shapeCorners, shapeGeometry } from './shapes.js';
import { MeshBody } from './mesh_body.js';

export const setRotation = (object, [w, x, y, z]) => object.quaternion.set(x, y, z, w);

/** A point in the frame of a pose, in that pose's outer frame. */
const moved = ({ position, rotation }, point) => rotate(rotation, point).map((value, c) => value + position[c]);

/** Corners of the boxes of all that a body wears, in its own axes. */
function bodyCorners(body) {
  const corners = body.mesh ? boundsCorners(body.mesh.points) : [];
  for (const shape of body.shapes) corners.push(...shapeCorners(shape).map((corner) => moved(shape, corner)));
  return corners;
}

/** Which of a body's shapes are drawn: the contact shapes only where nothing better is there, or when asked for. */
function shapeRole(body, shape) {
  const better = body.mesh || body.shapes.some((one) => one.role !== 'contact');
  return shape.role === 'contact' && better ? 'contact' : 'solid';
}

export class BodyView {
  constructor(entry, body, extent) {
    this.entry = entry;
    this.body = body;
    this.corners = bodyCorners(body);
    this.group = new Group();
    this.group.userData = { kind: 'body', index: entry.index };
    this.material = new MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    this.flat_material = null;
    this.edge_material = new LineBasicMaterial({ transparent: true, opacity: 0.5 });
    this.contact_parts = [];
    this.edge_parts = [];
    for (const shape of body.shapes) this.#addShape(shape, extent);
    this.mesh_body = body.mesh ? new MeshBody(body.mesh, '#888') : null;
    if (this.mesh_body) this.group.add(...this.mesh_body.parts);
  }

  #addShape(shape, extent) {
    const geometry = shapeGeometry(shape, extent);
    if (!geometry) return;
    let material = this.material;
    if (geometry.flat) {
      this.flat_material ??= new MeshLambertMaterial({ flatShading: true, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
      material = this.flat_material;
    }
    const contact = shapeRole(this.body, shape) === 'contact';
    const surface = new Mesh(geometry.surface, material);
    const edges = new LineSegments(geometry.edges, this.edge_material);
    for (const part of contact ? [edges] : [surface, edges]) {
      part.position.set(...shape.position);
      setRotation(part, shape.rotation);
      this.group.add(part);
    }
    if (shape.kind === 'half_space') {
      this.plane_material ??= new MeshLambertMaterial({ transparent: true, opacity: 0.16, side: DoubleSide, depthWrite: false });
      surface.material = this.plane_material;
    }
    (contact ? this.contact_parts : this.edge_parts).push(edges);
  }

  materials() {
    return [this.material, this.flat_material, this.mesh_body?.material].filter(Boolean);
  }

  /** Colours, and whether one sees through. */
  dress({ colour, edge, opacity, selected, accent, field }) {
    for (const material of this.materials()) {
      const painted = material === this.mesh_body?.material && this.mesh_body.field.has(field);
      if (!painted) material.color.set(colour);
      const see_through = opacity < 1;
      if (material.transparent !== see_through) material.needsUpdate = true;
      material.transparent = see_through;
      material.opacity = opacity;
      material.polygonOffsetFactor = see_through ? 4 : 1; // where variants coincide the solid one is in front
      material.emissive.set(selected && !painted ? accent : '#000'); // a field keeps its true colours
      material.emissiveIntensity = 0.35;
    }
    this.plane_material?.color.set(colour);
    this.edge_material.color.set(selected ? accent : edge);
    this.edge_material.opacity = selected ? 1 : 0.55;
    if (!this.mesh_body) return;
    this.mesh_body.colour = colour;
    const { creases, elements } = this.mesh_body;
    creases.material.color.set(selected ? accent : edge);
    creases.material.opacity = selected ? 1 : 0.75;
    elements?.material.color.set(edge);
  }

  showEdges(edges, elements, selected) {
    for (const part of this.edge_parts) part.visible = edges || selected;
    if (!this.mesh_body) return;
    this.mesh_body.creases.visible = edges || selected;
    if (this.mesh_body.elements) this.mesh_body.elements.visible = elements;
  }

  update(at, view, mode) {
    const { position, rotation } = bodyPose(this.body, at);
    this.group.position.set(...position);
    setRotation(this.group, rotation);
    this.mesh_body?.deform(mode ?? modalCoordinates(this.body.mesh, at), mode ? 1 : view.magnification);
  }
}

export class RunScene {
  constructor(model, run, extent) {
    this.run = run;
    this.group = new Group();
    this.bodies = run.bodies.map((body) => new BodyView(model.bodyEntry(run.index, body.index), body, extent));
    for (const body of this.bodies) this.group.add(body.group);
  }

  /** `mode`: {body: index in the run, eta} of a mode shape to show instead of the motion, or null. */
  update(view, mode) {
    const at = locate(this.run.times, view.time);
    for (const body of this.bodies) body.update(at, view, mode?.body === body.body.index ? mode.eta : null);
    this.group.updateMatrixWorld(true);
  }

  /** Corners of all boxes at frame i, world axes, for all bodies or one. */
  cornersAt(frame, only = null) {
    const out = [];
    const at = { i: frame, j: frame, w: 0 };
    for (const { body, corners } of this.bodies) {
      if (only !== null && body.index !== only) continue;
      const pose = bodyPose(body, at);
      for (const point of corners) out.push(moved(pose, point));
    }
    return out;
  }
}
