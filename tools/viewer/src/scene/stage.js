// The 3D view: all runs in one space, drawn when something has changed.
import { AmbientLight, Color, DirectionalLight, HemisphereLight, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from 'three';
import { throttled } from '../dom.js';
import { bodyPose, locate } from '../motion.js';
import { runDash, seriesColour } from '../palette.js';
import { Bounds, box } from './bounds.js';
import { ConnectorViews } from './connector_view.js';
import { Eye } from './camera.js';
import { extend } from './field.js';
import { makeGrid, MarkerAxes, Traces } from './lines.js';
import { RunScene } from './run_scene.js';

const kMeanwhile = 400; // ms between looks at all of a run that goes on

/** Index of the axis that gravity points along most, and its sign; z where there is none. */
function upAxis(runs) {
  const gravity = runs.map((run) => run.gravity).find((one) => one.some((value) => value !== 0)) ?? [0, 0, -1];
  const sizes = gravity.map(Math.abs);
  const axis = sizes.indexOf(Math.max(...sizes));
  return { axis, sign: -Math.sign(gravity[axis]) };
}

const size = ([low, high]) => Math.hypot(...high.map((value, c) => value - low[c]));

export class Stage {
  constructor(canvas, model, view, { antialias }) {
    this.canvas = canvas;
    this.model = model;
    this.view = view;
    this.renderer = new WebGLRenderer({ canvas, antialias });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.scene = new Scene();
    this.after = []; // what follows every picture: labels, legend
    this.ranges = new Map();
    const { axis, sign } = upAxis(model.runs);
    this.up_axis = axis;
    const up = new Vector3().setComponent(axis, sign);
    this.eye = new Eye(canvas, up, () => this.touch());
    this.#build();
    this.#light(up);
    view.watch(['time', 'magnification', 'mode', 'show', 'arrow_scale', 'glyph_scale', 'colouring', 'bands', 'whole_range', 'follow'], () => this.touch());
    view.watch(['frames'], throttled(kMeanwhile, () => this.grow()));
    view.watch(['runs', 'selection', 'theme', 'colouring', 'show'], () => this.dress());
    this.dress();
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
    this.fitMotion(this.homeDirection());
  }

  #build() {
    const { model } = this;
    // Planes without end take their size from the rest, so the bodies are measured before they are built.
    this.bounds = model.runs.map((run) => new Bounds(run));
    this.#measure();
    const points = this.motion_points.length ? this.motion_points : [[-1, -1, -1], [1, 1, 1]];
    [this.low, this.high] = box(points);
    this.extent = size([this.low, this.high]) || 1;
    const start = this.bounds.flatMap((bounds) => bounds.at(0));
    this.size = Math.min(this.extent, (start.length && size(box(start))) || this.extent);
    this.runs = model.runs.map((run) => {
      const bodies = new RunScene(model, run, this.extent);
      const connectors = new ConnectorViews(model, run, false);
      const traces = new Traces(run, runDash(run.index));
      const markers = new MarkerAxes(run);
      bodies.group.add(connectors.group, traces.group, markers.lines);
      this.scene.add(bodies.group);
      return { run, bodies, connectors, traces, markers };
    });
    const centre = this.low.map((value, c) => (value + this.high[c]) / 2);
    const below = this.eye.up.getComponent(this.up_axis) > 0 ? this.low : this.high;
    centre[this.up_axis] = below[this.up_axis];
    const { lines, spacing } = makeGrid(this.extent, centre, this.up_axis);
    this.grid = lines;
    this.grid_spacing = spacing;
    this.scene.add(lines);
    this.eye.extent = this.extent;
  }

  #measure() {
    this.motion_points = this.bounds.flatMap((bounds) => bounds.sampled());
  }

  #light(up) {
    this.sky = new HemisphereLight(0xffffff, 0x8a8f98, 1.5);
    this.sky.position.copy(up);
    this.lamp = new DirectionalLight(0xffffff, 1.5);
    this.scene.add(this.sky, new AmbientLight(0xffffff, 0.5), this.lamp, this.lamp.target);
  }

  /** A little from above, in front: the view that shows most of a drawing in any plane. */
  homeDirection() {
    const spread = this.high.map((value, c) => value - this.low[c]);
    const flat = [0, 1, 2].filter((c) => c !== this.up_axis);
    const front = spread[flat[0]] >= spread[flat[1]] ? flat[1] : flat[0];
    const side = flat.find((c) => c !== front);
    const direction = [0, 0, 0];
    direction[front] = front === 1 ? -1 : 1; // x to the right when seen along y
    direction[side] = 0.42;
    const flat_drawing = spread[this.up_axis] < 0.3 * Math.max(spread[front], spread[side]);
    direction[this.up_axis] = (flat_drawing ? 1.1 : 0.32) * this.eye.up.getComponent(this.up_axis);
    return direction;
  }

  /** The run has more frames: what was taken from all of them is taken anew. */
  grow() {
    this.ranges.clear();
    for (const { connectors, traces } of this.runs) {
      connectors.grow();
      traces.grow();
    }
    this.#measure();
    const [low, high] = box([...this.motion_points, this.low, this.high]);
    const extent = size([low, high]);
    const grown = extent > 1.02 * this.eye.extent;
    this.eye.extent = Math.max(this.eye.extent, extent);
    if (grown && !this.eye.by_hand) this.fitMotion();
    this.touch();
  }

  touch() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => this.draw());
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.eye.resize(clientWidth / clientHeight);
    this.draw();
  }

  /** Colours of all things, from the theme, the selection and the variants. */
  dress() {
    const { view, model } = this;
    const css = getComputedStyle(document.documentElement);
    const colour = (name) => css.getPropertyValue(name).trim();
    this.scene.background = new Color(colour('--scene'));
    this.grid.material.color.set(colour('--grid'));
    this.grid.visible = view.show.grid;
    const accent = colour('--accent');
    const roles = { accent };
    for (const role of ['joint', 'force', 'drive', 'contact', 'reaction', 'moment', 'rope']) roles[role] = colour(`--${role}`);
    const many = model.runs.length > 1;
    const pale = new Color(colour('--body-mix'));
    const ground_colour = new Color(colour('--ground'));
    const first = model.bodies[0].item.kind === 'Ground' ? -1 : 0;
    const selected = view.selection?.kind === 'body' ? view.selection.index : -1;
    this.runs.forEach(({ run, bodies, connectors, traces, markers }, r) => {
      const own = view.runs[r];
      bodies.group.visible = own.shown;
      const opacity = own.solid ? 1 : 0.32;
      const run_colour = seriesColour(r, view.theme);
      const of = (i) => (run.bodies[i].kind === 'Ground' ? ground_colour.clone()
        : new Color(many ? run_colour : seriesColour(bodies.owners[i] + first + 70, view.theme)).lerp(pale, 0.38));
      bodies.dress({ of, edge: many ? run_colour : colour('--edge'), opacity, selected, accent: new Color(accent), field: view.colouring, show: view.show });
      connectors.dress(roles, view.selection, own.solid ? 1 : 0.5);
      traces.dress(many ? run_colour : colour('--trace'), this.extent);
      markers.dress([colour('--axis-x'), colour('--axis-y'), colour('--axis-z')]);
    });
    this.touch();
  }

  /** Metres of arrow a newton: the typical largest force is a quarter of the scene. */
  arrowSizes() {
    const largest = (field) => Math.max(...this.runs.map(({ connectors }) => connectors[field]));
    const length = 0.25 * this.size * this.view.arrow_scale;
    return {
      glyph: 0.02 * this.size,
      force: length / (largest('typical_force') || 1),
      moment: length / (largest('typical_moment') || 1),
    };
  }

  update() {
    const { view } = this;
    const sizes = this.arrowSizes();
    for (const { run, bodies, connectors, traces, markers } of this.runs) {
      if (!view.runs[run.index].shown) continue;
      bodies.update(view, view.mode?.run === run.index ? view.mode : null);
      connectors.update(view, sizes);
      traces.update(view);
      markers.update(view, 3 * sizes.glyph);
    }
    this.#paint();
    if (view.follow !== null) {
      const entry = this.model.bodies[view.follow];
      const r = entry.of.findIndex((i, run) => i >= 0 && view.runs[run].shown);
      if (r >= 0) {
        const run = this.model.runs[r];
        this.eye.follow(bodyPose(run.bodies[entry.of[r]], locate(run.times, view.time)).position);
      }
    } else {
      this.eye.follow(null);
    }
  }

  /** Fields on the meshes, all on one range. */
  #paint() {
    const { view } = this;
    const shown = this.runs.filter(({ run }) => view.runs[run.index].shown).flatMap(({ bodies }) => bodies.meshes);
    const values = shown.map((one) => one.mesh_body.values(view.colouring));
    const now = [Infinity, -Infinity];
    for (const one of values) if (one) extend(now, one);
    this.range = view.whole_range && !view.mode ? this.#wholeRange(now) : now;
    shown.forEach((one, i) => one.mesh_body.paint(values[i], this.range, view.bands));
    this.has_field = values.some(Boolean);
  }

  #wholeRange(now) {
    const name = this.view.colouring;
    if (!this.ranges.has(name)) {
      const range = [Infinity, -Infinity];
      for (const { bodies } of this.runs) {
        for (const { mesh_body } of bodies.meshes) {
          if (mesh_body.field.has(name)) extend(range, mesh_body.field.range(name));
        }
      }
      this.ranges.set(name, range);
    }
    return extend(this.ranges.get(name), now);
  }

  draw() {
    cancelAnimationFrame(this.pending);
    this.pending = 0;
    this.update();
    const { camera } = this.eye;
    this.lamp.position.copy(camera.position);
    this.lamp.target.position.copy(this.eye.target);
    this.renderer.render(this.scene, camera);
    for (const tell of this.after) tell(this);
  }

  fitMotion(direction = null) {
    this.eye.fit(this.motion_points, direction);
    this.touch();
  }

  /** The body as it is now, in any of the shown runs. */
  fitBody(index) {
    const points = [];
    for (const { run } of this.runs) {
      const i = this.model.bodies[index].of[run.index];
      const at = locate(run.times, this.view.time);
      if (i >= 0 && this.view.runs[run.index].shown) points.push(...this.bounds[run.index].at(at.w < 0.5 ? at.i : at.j, i));
    }
    if (points.length) this.eye.fit(points);
    this.touch();
  }

  /** From a point in the world to CSS pixels of the window. */
  toPixel(point) {
    const box = this.canvas.getBoundingClientRect();
    const p = new Vector3(...point).project(this.eye.camera);
    return { x: box.left + ((p.x + 1) / 2) * box.width, y: box.top + ((1 - p.y) / 2) * box.height, behind: p.z > 1 };
  }

  /** What is at a CSS pixel of the window: {kind, index}, or null. */
  pick(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2), this.eye.camera);
    ray.params.Line.threshold = 0;
    const groups = this.runs.filter(({ bodies }) => bodies.group.visible).map(({ bodies }) => bodies.group);
    const hits = ray.intersectObjects(groups, true).filter((hit) => this.#owner(hit));
    // A glyph lies on or in a body: it wins when it is about as near.
    const glyph = hits.find((one) => this.#owner(one).kind === 'connector');
    const hit = glyph && glyph.distance - hits[0].distance < 0.06 * this.size ? glyph : hits[0];
    return hit ? { ...this.#owner(hit) } : null;
  }

  /** {kind, index} of what a ray hit; null for what is not shown or belongs to nothing. */
  #owner({ object, instanceId }) {
    let owner = object.userData.owners?.[instanceId] ?? null;
    for (let one = object; one; one = one.parent) {
      if (!one.visible) return null;
      if (one.userData.kind) owner ??= one.userData;
    }
    return owner;
  }
}
