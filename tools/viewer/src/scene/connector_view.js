// Connectors of one run: a glyph at the first marker, a link to the others, arrows of what they transmit.
import { DoubleSide, Group, Mesh, MeshLambertMaterial, Quaternion, Vector3, GreaterDepth } from 'three';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { bodyPose, locate, markerPose, vectorAt } from '../motion.js';
import { Arrows } from './arrows.js';
import { glyphGeometry, linkGeometry } from './glyphs.js';
import { setRotation } from './run_scene.js';

const kZ = new Vector3(0, 0, 1);
const kSpans = ['distance', 'rod', 'spring'];
const from = new Vector3();
const along = new Vector3();
const turn = new Quaternion();
const scale = new Vector3();

const size3 = (v) => Math.hypot(v[0], v[1], v[2]);

/** The size that all but the largest tenth of the vectors stay below: one peak must not make all arrows dots. */
export function typicalSize(lists) {
  const sizes = [];
  for (const values of lists) {
    for (let i = 0; i + 2 < values.length; i += 3) {
      const size = Math.hypot(values[i], values[i + 1], values[i + 2]);
      if (Number.isFinite(size) && size > 0) sizes.push(size);
    }
  }
  sizes.sort((a, b) => a - b);
  return sizes.length ? sizes[Math.floor(0.9 * (sizes.length - 1))] : 0;
}

/** A rope: the points of its line at a frame, or between two of them. */
class RopeLine {
  constructor(connector, frames) {
    this.connector = connector;
    this.now = new Float32Array(connector.line.length / frames);
    this.material = new LineMaterial({ linewidth: 3.5, transparent: true });
    this.line = new Line2(new LineGeometry(), this.material);
    this.line.frustumCulled = false;
    this.line.raycast = () => {}; // its glyph is picked
  }

  update({ i, j, w }) {
    const n = this.now.length;
    const points = this.connector.line;
    for (let k = 0; k < n; ++k) this.now[k] = (1 - w) * points[i * n + k] + w * points[j * n + k];
    this.line.geometry.setPositions(this.now);
  }
}

/** A solid that is drawn full where it is seen and faint where something hides it. */
function ghosted(geometry, material, ghost) {
  const group = new Group();
  const shade = new Mesh(geometry, ghost);
  shade.renderOrder = 2;
  group.add(new Mesh(geometry, material), shade);
  return group;
}

export class ConnectorViews {
  constructor(model, run, dim) {
    this.run = run;
    this.group = new Group();
    this.materials = {};
    this.views = run.connectors.filter((one) => one.role !== 'contact' && one.markers.length > 0).map((connector) => {
      const entry = model.connectorEntry(run.index, connector.index);
      const group = new Group();
      group.userData = { kind: 'connector', index: entry.index };
      const material = new MeshLambertMaterial({ side: DoubleSide });
      const ghost = new MeshLambertMaterial({ transparent: true, opacity: 0.35, depthFunc: GreaterDepth, depthWrite: false });
      const glyph = ghosted(glyphGeometry(connector.kind), material, ghost);
      const rope = connector.line ? new RopeLine(connector, run.frames) : null;
      const links = rope ? [] : connector.markers.slice(1).map(() => ghosted(linkGeometry(connector.kind), material, ghost));
      group.add(glyph, ...links);
      if (rope) group.add(rope.line);
      this.group.add(group);
      return { connector, entry, group, glyph, links, rope, material, ghost };
    });
    // Bodies whose poses the glyphs and arrows need: a pile's one contact has markers on all bodies, and no glyph.
    const marked = [...this.views.flatMap(({ connector }) => connector.markers), ...run.connectors.filter(({ reaction }) => reaction).map(({ markers }) => markers[0])];
    this.tied = new Set(marked.filter((i) => run.markers[i]).map((i) => run.markers[i].body));
    const n = Math.max(1, run.connectors.length);
    this.forces = new Arrows(n, false, dim);
    this.moments = new Arrows(n, true, dim);
    this.contacts = new Arrows(1, false, dim);
    for (const arrows of [this.forces, this.moments, this.contacts]) this.group.add(...arrows.meshes);
    this.grow();
  }

  /** Sizes and numbers of the arrows that the run has by now. */
  grow() {
    const { run } = this;
    const most = run.contacts ? run.contacts.first.reduce((max, first, i, all) => (i ? Math.max(max, first - all[i - 1]) : 0), 0) : 0;
    this.contacts.reserve(most);
    const of = (field) => run.connectors.map((one) => one.reaction?.[field]).filter(Boolean);
    this.typical_force = Math.max(typicalSize(of('force')), run.contacts ? typicalSize([run.contacts.forces]) : 0);
    this.typical_moment = typicalSize(of('moment'));
  }

  update(view, sizes) {
    const at = locate(this.run.times, view.time);
    const poses = [];
    for (const i of this.tied) poses[i] = bodyPose(this.run.bodies[i], at);
    const glyph_size = sizes.glyph * view.glyph_scale;
    for (const one of this.views) this.#place(one, at, poses, view, glyph_size);
    this.#arrows(at, poses, view, sizes);
  }

  #place({ connector, group, glyph, links, rope }, at, poses, view, glyph_size) {
    group.visible = view.show.joints || rope !== null;
    glyph.visible = view.show.joints;
    rope?.update(at);
    if (!view.show.joints) return;
    const markers = connector.markers.map((i) => this.run.markers[i]);
    const ends = markers.map((marker) => markerPose(this.run, marker, at, poses[marker.body], view.magnification));
    glyph.position.set(...ends[0].position);
    setRotation(glyph, ends[0].rotation);
    glyph.scale.setScalar(glyph_size);
    const spans = kSpans.some((word) => connector.kind.toLowerCase().includes(word));
    links.forEach((link, i) => {
      from.set(...ends[0].position);
      along.set(...ends[i + 1].position).sub(from);
      const length = along.length();
      link.visible = length > 0.3 * glyph_size;
      if (!link.visible) return;
      link.position.copy(from);
      link.quaternion.copy(turn.setFromUnitVectors(kZ, along.divideScalar(length)));
      const width = glyph_size * (spans ? 1 : 0.5);
      link.scale.copy(scale.set(width, width, length));
    });
  }

  #arrows(at, poses, view, sizes) {
    const { forces, moments, contacts, run } = this;
    for (const arrows of [forces, moments, contacts]) arrows.begin();
    const width = sizes.glyph * 0.28 * Math.min(1.5, view.glyph_scale);
    for (const { reaction, markers } of run.connectors) {
      if (!reaction) continue;
      const marker = run.markers[markers[0]];
      const point = reaction.point ? vectorAt(reaction.point, at)
        : marker ? markerPose(run, marker, at, poses[marker.body], view.magnification).position : null;
      if (!point) continue;
      if (view.show.reactions && reaction.force) {
        const force = vectorAt(reaction.force, at);
        forces.add(point, force, size3(force) * sizes.force, width);
      }
      if (view.show.moments && reaction.moment) {
        const moment = vectorAt(reaction.moment, at);
        moments.add(point, moment, size3(moment) * sizes.moment, width);
      }
    }
    if (view.show.contacts && run.contacts) {
      // Contacts come and go: those of the frame nearest in time.
      const frame = at.w < 0.5 ? at.i : at.j;
      for (let c = run.contacts.first[frame]; c < run.contacts.first[frame + 1]; ++c) {
        const force = run.contacts.forces.subarray(3 * c, 3 * c + 3);
        contacts.add(run.contacts.points.subarray(3 * c, 3 * c + 3), force, size3(force) * sizes.force, width);
      }
    }
    for (const arrows of [forces, moments, contacts]) arrows.end();
  }

  dress(colours, selection, opacity) {
    for (const { connector, entry, rope, material, ghost } of this.views) {
      const selected = selection?.kind === 'connector' && selection.index === entry.index;
      const colour = selected ? colours.accent : (colours[connector.role] ?? colours.joint);
      for (const one of [material, ghost]) one.color.set(colour);
      if (rope) {
        rope.material.color.set(selected ? colours.accent : colours.rope);
        rope.material.opacity = opacity;
      }
      material.emissive.set(selected ? colours.accent : '#000');
      material.transparent = opacity < 1;
      material.opacity = opacity;
      ghost.opacity = selected ? 0.7 : 0.35 * opacity;
    }
    this.forces.material.color.set(colours.reaction);
    this.moments.material.color.set(colours.moment);
    this.contacts.material.color.set(colours.contact);
  }
}

/** Axes of all markers of a run as line segments. */
export function markerAxes(run, at, poses, length, view, out) {
  let n = 0;
  for (const marker of run.markers) {
    const { position, rotation } = markerPose(run, marker, at, poses[marker.body], view.magnification);
    turn.set(rotation[1], rotation[2], rotation[3], rotation[0]);
    for (let axis = 0; axis < 3; ++axis) {
      from.set(axis === 0 ? length : 0, axis === 1 ? length : 0, axis === 2 ? length : 0).applyQuaternion(turn);
      out.set(position, n);
      out.set([position[0] + from.x, position[1] + from.y, position[2] + from.z], n + 3);
      n += 6;
    }
  }
  return n / 3;
}
