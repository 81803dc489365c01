// What lies on the 3D view: buttons for the eye, axes, the legend of the field, labels, the note of a mode shape.
import { Vector3 } from 'three';
import { clear, h, iconButton, s, set } from '../dom.js';
import { number, prefixed } from '../format.js';
import { viridisSteps } from '../palette.js';
import { fieldUnit } from '../scene/field.js';
import { kBands } from '../scene/mesh_body.js';
import { bodyPose, locate, markerPose } from '../motion.js';

/** A little cross of the world's axes that turns with the eye. */
function axes() {
  const names = ['x', 'y', 'z'];
  const parts = names.map((name) => ({
    line: s(`line.axis-${name}`, { x1: 0, y1: 0 }),
    text: s('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' }, name),
  }));
  const picture = s('svg.axes', { viewBox: '-32 -32 64 64', width: 64, height: 64, role: 'img', 'aria-label': 'Axes of the world' },
    ...parts.flatMap(({ line, text }) => [line, text]));
  const update = (camera) => {
    parts.forEach(({ line, text }, c) => {
      const p = new Vector3().setComponent(c, 1).transformDirection(camera.matrixWorldInverse);
      set(line, { x2: 20 * p.x, y2: -20 * p.y });
      set(text, { x: 27 * p.x, y: -27 * p.y, opacity: Math.hypot(p.x, p.y) < 0.25 ? 0 : 1 });
    });
  };
  return { picture, update };
}

/** The field's colours with its range. */
function legend(model, view) {
  const element = h('div.legend', { role: 'img', hidden: true });
  let told = '';
  const update = (stage) => {
    const finite = stage.has_field && Number.isFinite(stage.range[0]);
    const key = finite ? [view.colouring, view.bands, view.whole_range, ...stage.range, !view.mode].join() : '';
    if (key === told) return;
    told = key;
    element.hidden = !finite;
    if (!finite) return;
    const [low, high] = stage.range;
    const plain = fieldUnit(view.colouring, model);
    const { factor, unit } = plain ? prefixed(Math.max(Math.abs(low), Math.abs(high)), plain) : { factor: 1, unit: '' };
    const ticks = [0, 0.25, 0.5, 0.75, 1].map((x) => number((low + x * (high - low)) / factor, 4));
    const colours = view.bands
      ? viridisSteps(kBands).map((colour, i) => `${colour} ${i * 10}% ${(i + 1) * 10}%`)
      : viridisSteps(9);
    const when = view.mode ? 'mode shape, relative' : view.whole_range ? 'range of the whole run' : 'range at this time';
    element.setAttribute('aria-label', `${view.colouring}: ${ticks[0]} to ${ticks[4]} ${unit}`);
    clear(element).append(
      h('div.legend-title', {}, h('b', {}, view.colouring), unit && ` in ${unit}`),
      h('div.legend-bar', { style: `background:linear-gradient(90deg,${colours.join(',')})` }),
      h('div.legend-ticks', {}, ticks.map((tick) => h('span', {}, tick))),
      h('div.faint', {}, when));
  };
  return { element, update };
}

/** Names at bodies, or at the selected thing alone. */
function labels(model, view) {
  const layer = h('div.labels', { 'aria-hidden': 'true' });
  const pool = [];
  const update = (stage) => {
    const wanted = [];
    const box = stage.canvas.getBoundingClientRect();
    const add = (entry, kind, selected) => {
      const r = entry.of.findIndex((i, run) => i >= 0 && view.runs[run].shown);
      if (r < 0) return;
      const run = model.runs[r];
      const at = locate(run.times, view.time);
      const item = (kind === 'body' ? run.bodies : run.connectors)[entry.of[r]];
      let point;
      if (kind === 'body') point = bodyPose(item, at).position;
      else if (item.markers.length) point = markerPose(run, run.markers[item.markers[0]], at).position;
      else return;
      const pixel = stage.toPixel(point);
      if (!pixel.behind) wanted.push({ text: entry.name, x: pixel.x - box.left, y: pixel.y - box.top, selected });
    };
    const chosen = model.entry(view.selection);
    if (chosen) add(chosen, view.selection.kind, true);
    if (view.show.labels) {
      for (const entry of model.bodies) if (entry !== chosen && entry.item.kind !== 'Ground') add(entry, 'body', false);
    }
    while (pool.length < wanted.length) layer.append(pool[pool.push(h('span', {})) - 1]);
    pool.forEach((label, i) => {
      label.hidden = i >= wanted.length;
      if (label.hidden) return;
      const { text, x, y, selected } = wanted[i];
      if (label.textContent !== text) label.textContent = text;
      label.className = selected ? 'selected' : '';
      label.style.transform = `translate(${x.toFixed(1)}px,${y.toFixed(1)}px)`;
    });
  };
  return { layer, update };
}

/** Puts all of it over the stage; returns the element. */
export function overlay(model, view, stage, eye) {
  const cross = axes();
  const bar = legend(model, view);
  const names = labels(model, view);
  const grid = h('span.faint', {}, `grid ${prefixedLength(stage.grid_spacing)}`);
  const note = h('div.note', { role: 'status', hidden: true });
  const tellMode = () => {
    note.hidden = !view.mode;
    if (view.mode) note.textContent = view.mode.note;
  };
  view.watch(['mode'], tellMode);
  view.watch(['show'], () => { grid.hidden = !view.show.grid; });
  const text = (label, tip, onclick) => h('button.icon', { type: 'button', title: tip, 'aria-label': tip, onclick }, label);
  const follow = iconButton('follow', 'Follow the selected body', 'w', eye.follow);
  const parallel = text('∥', 'Parallel projection (o)', eye.parallel);
  const tellFollow = () => follow.setAttribute('aria-pressed', view.follow !== null);
  view.watch(['follow'], tellFollow);
  tellFollow();
  stage.after.push(() => {
    cross.update(stage.eye.camera);
    bar.update(stage);
    names.update(stage);
    parallel.setAttribute('aria-pressed', String(stage.eye.camera === stage.eye.parallel));
  });
  return [
    names.layer, note,
    h('div.eye', { role: 'toolbar', 'aria-label': 'Eye' },
      iconButton('fit', 'Fit the view', 'f', eye.fit),
      text('⌂', 'First view (0)', () => eye.home()),
      ...['x', 'y', 'z'].map((axis, c) => text(axis, `View along ${axis} (${c + 1})`, () => eye.along(c))),
      parallel, follow),
    h('div.corner', {}, cross.picture, h('div.corner-text', {}, bar.element, grid)),
  ];
}

function prefixedLength(metres) {
  if (metres >= 1) return `${metres} m`;
  return metres >= 0.001 ? `${number(metres * 1000, 3).replace(/\.0+$/, '')} mm` : `${number(metres * 1e6, 3)} µm`;
}
