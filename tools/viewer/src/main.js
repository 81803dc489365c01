// Opens the page: reads the run, builds the panels, ties them together.
import { Clock } from './clock.js';
import { PageError, readPage } from './data.js';
import { clear, h } from './dom.js';
import { hooks } from './hooks.js';
import { listenToKeys } from './keys.js';
import { Live } from './live.js';
import { Model } from './model.js';
import { chartDock } from './panels/charts.js';
import { displayView } from './panels/display.js';
import { findingsView } from './panels/findings.js';
import { graphView } from './panels/graph_view.js';
import { header } from './panels/header.js';
import { helpSheet } from './panels/help.js';
import { inspector } from './panels/inspector.js';
import { listView } from './panels/list.js';
import { inputsView, liveBar } from './panels/live.js';
import { modesView } from './panels/modes.js';
import { overlay } from './panels/overlay.js';
import { channelPicker } from './panels/picker.js';
import { tabs } from './panels/tabs.js';
import { transport } from './panels/transport.js';
import { Stage } from './scene/stage.js';
import { initialView } from './view.js';

const small = matchMedia('(max-width: 700px), (max-height: 480px)');

/** Charts and side panel on or off; on a small screen one of them at a time. */
function toggle(app, name) {
  const hidden = app.classList.toggle(name);
  if (small.matches && !hidden) app.classList.add(name === 'no-side' ? 'no-charts' : 'no-side');
}

function showTrouble(app, error) {
  const fix = error instanceof PageError ? error.fix : 'open the browser\'s console for the place, and report it.';
  clear(app).append(h('div.trouble', { role: 'alert' }, h('h1', {}, 'This run cannot be shown'), h('p', {}, error.message), h('p.faint', {}, `fix: ${fix}`)));
}

const kManyTriangles = 100000;

/** Of meshes, and about a hundred a shape. */
function triangleCount({ runs }) {
  const bodies = runs.flatMap((run) => run.bodies);
  const of = (item) => (item?.triangles ? item.triangles.length / 3 : 0);
  return bodies.reduce((sum, { mesh, shapes }) => sum + of(mesh) + shapes.reduce((part, shape) => part + (of(shape) || 100), 0), 0);
}

/** The 3D view, or null and a word in its place where the browser has no WebGL: the rest of the page still serves. */
function makeStage(place, model, view) {
  const canvas = h('canvas', { tabindex: 0, role: 'img', 'aria-label': `3D view of ${model.title}; the list has its bodies and joints` });
  place.append(canvas);
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe) {
    canvas.remove();
    place.append(h('div.no-webgl', { role: 'alert' }, h('b', {}, 'No 3D view'), h('p', {}, 'This browser offers no WebGL 2. Charts, graph and numbers work all the same.'),
      h('p.faint', {}, 'fix: switch on hardware acceleration, or open the page in another browser.')));
    return null;
  }
  const names = probe.getExtension('WEBGL_debug_renderer_info');
  const drawn_by = names ? probe.getParameter(names.UNMASKED_RENDERER_WEBGL) : '';
  probe.getExtension('WEBGL_lose_context')?.loseContext();
  // Without a graphics processor smooth edges take more than half of the time of small triangles.
  const slow = /swiftshader|llvmpipe|software|basic render/i.test(drawn_by) && triangleCount(model) > kManyTriangles;
  return new Stage(canvas, model, view, { antialias: !slow });
}

function eyeActions(model, view, stage) {
  let last_axis = null;
  const move = (how) => {
    if (!stage) return;
    how(stage.eye);
    stage.touch();
  };
  return {
    fit: () => stage?.fitMotion(),
    fitSelected: () => (view.selection?.kind === 'body' ? stage?.fitBody(view.selection.index) : stage?.fitMotion()),
    home: () => { last_axis = null; stage?.fitMotion(stage.homeDirection()); },
    along: (axis) => {
      // Seen from the side where the next axis points right: x from +x, y from −y, z from above.
      const first = axis === 1 ? -1 : 1;
      const sign = last_axis?.axis === axis ? -last_axis.sign : first;
      last_axis = { axis, sign };
      const direction = [0, 0, 0];
      direction[axis] = sign;
      stage?.fitMotion(direction);
    },
    parallel: () => move((eye) => eye.setParallel(eye.camera !== eye.parallel)),
    zoom: (factor) => move((eye) => eye.zoom(factor)),
    turn: (side, up) => move((eye) => eye.turn(side, up)),
    slide: (right, up) => move((eye) => eye.slide(right, up)),
    follow: () => view.set({ follow: view.follow === null && view.selection?.kind === 'body' ? view.selection.index : null }),
  };
}

/** A click that is no drag selects; a double click fits. */
function listenToScene(stage, view) {
  let down = null;
  stage.canvas.addEventListener('pointerdown', (event) => { down = { x: event.clientX, y: event.clientY }; });
  stage.canvas.addEventListener('click', (event) => {
    if (!down || Math.hypot(event.clientX - down.x, event.clientY - down.y) > 4) return;
    view.set({ selection: stage.pick(event.clientX, event.clientY) });
  });
  stage.canvas.addEventListener('dblclick', (event) => {
    const hit = stage.pick(event.clientX, event.clientY);
    if (hit?.kind === 'body') stage.fitBody(hit.index);
  });
}

async function open(app) {
  const page = await readPage();
  document.title = page.title;
  const model = new Model(page);
  const view = initialView(model);
  const root = document.documentElement;
  const setTheme = () => { root.dataset.theme = view.theme; };
  setTheme();
  view.watch(['theme'], setTheme); // first of all watchers, so that the others read the new colours
  const clock = new Clock(model, view);
  const live = page.live ? new Live(page, model, view) : null;

  const scene = h('section.scene', { 'aria-label': 'Scene' });
  const help = helpSheet();
  const picker = channelPicker(model);
  const toggleSide = () => toggle(app, 'no-side');
  const toggleCharts = () => toggle(app, 'no-charts');
  const share = () => app.classList.toggle('no-charts', small.matches);
  small.addEventListener('change', share);
  share();
  clear(app).append(header(model, view, { help: () => help.showModal(), toggleSide, toggleCharts, live: live && liveBar(live, view) }), scene, transport(model, view, clock));
  const stage = makeStage(scene, model, view);
  const eye = eyeActions(model, view, stage);
  if (stage) {
    scene.append(...overlay(model, view, stage, eye));
    listenToScene(stage, view);
  }
  const charts = chartDock(model, view, clock, picker);
  const system = tabs([
    ...(live ? [['Inputs', () => inputsView(live, view)]] : []),
    ['Graph', () => graphView(model, view)],
    ['List', () => listView(model, view)],
    ['Modes', () => modesView(model, view, (index) => stage?.fitBody(index))],
    ['Display', () => displayView(model, view, stage)],
    ...(model.findings.length ? [['Findings', () => findingsView(model, view)]] : []),
  ]);
  const side = h('aside.side', { 'aria-label': 'System and selected' }, system,
    inspector(model, view, { chart: charts.show, fit: (index) => stage?.fitBody(index), follow: eye.follow }));
  app.append(charts.element, side, help, picker);
  if (model.notices.length) app.append(h('div.notices', { role: 'alert' }, model.notices.map((notice) => h('p', {}, notice)),
    h('button', { type: 'button', onclick: (event) => event.target.parentElement.remove() }, 'Close')));

  listenToKeys(view, model, {
    ...eye,
    toggle: () => clock.toggle(),
    step: (count) => clock.step(count),
    first: () => clock.goTo(model.start),
    last: () => clock.goTo(model.end),
    faster: (steps) => clock.faster(steps),
    next: (step) => {
      const n = model.bodies.length;
      const now = view.selection?.kind === 'body' ? view.selection.index : step > 0 ? -1 : n;
      view.set({ selection: { kind: 'body', index: (now + step + n) % n } });
    },
    nothing: () => view.set({ selection: null }),
    addChannel: charts.pick,
    find: () => {
      if (app.classList.contains('no-side')) toggleSide();
      system.open('List').querySelector('input').focus();
    },
    toggleCharts,
    toggleSide,
    help: () => help.showModal(),
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', (event) => view.set({ theme: event.matches ? 'dark' : 'light' }));
  stage?.draw();
  return { model, view, clock, stage, charts, live };
}

const app = document.getElementById('app');
window.lithe = {
  ready: open(app).then(
    (parts) => Object.assign(window.lithe, hooks(parts)),
    (error) => {
      window.lithe.failed = error.message;
      showTrouble(app, error);
    },
  ),
};
