// Mode shapes of the finite-element bodies, swinging at a pace one can follow.
import { clear, h } from '../dom.js';
import { number } from '../format.js';
import { displacements } from '../motion.js';
import { boundsCorners } from '../scene/shapes.js';

const kPace = 0.8; // swings a second on the screen

/** The η of a mode whose largest displacement is one tenth of the body's size. */
function unitAmplitude(mesh, mode) {
  const eta = new Float64Array(mesh.modes.length);
  eta[mode] = 1;
  const u = displacements({ ...mesh, pairs: null }, eta, new Float32Array(mesh.count * 3));
  let largest = 0;
  for (let i = 0; i < u.length; i += 3) largest = Math.max(largest, Math.hypot(u[i], u[i + 1], u[i + 2]));
  const corners = boundsCorners(mesh.points);
  const size = Math.hypot(...corners[7].map((value, c) => value - corners[0][c]));
  return largest > 0 ? (0.1 * size) / largest : 0;
}

const frequencyText = (mode) => (Number.isFinite(mode.frequency) && mode.frequency !== null ? `${number(mode.frequency, 5)} Hz` : '');

export function modesView(model, view, fit) {
  const bodies = model.runs.flatMap((run) => run.bodies.filter((body) => body.mesh && body.mesh.shapes && body.mesh.modes.length).map((body) => ({ run, body })));
  if (!bodies.length) return h('p.hint', {}, 'No body of this run has mode shapes.');
  const panel = h('div.modes', {});
  const name = ({ run, body }) => (model.runs.length > 1 ? `${body.name} (${run.name})` : body.name);
  const choice = h('select', { 'aria-label': 'Body', onchange: () => { stop(); fill(); } }, bodies.map((one, i) => h('option', { value: i }, name(one))));
  const list = h('div.rows', { role: 'listbox', 'aria-label': 'Modes' });
  const amplitude = h('input', { type: 'range', min: 0, max: 3, step: 0.05, value: 1, 'aria-label': 'Amplitude' });
  const told = h('output', {}, '');
  const note = h('p.hint', {});
  const halt = h('button', { type: 'button', onclick: () => stop(), disabled: true }, 'Stop');
  let shown = null;

  const tellAmplitude = () => { told.textContent = `${number(10 * amplitude.value, 3)} % of the size`; };
  const stop = () => {
    shown = null;
    halt.disabled = true;
    view.set({ mode: null });
    mark();
  };
  const mark = () => [...list.children].forEach((row, k) => {
    const on = shown?.k === k;
    row.classList.toggle('selected', on);
    row.setAttribute('aria-selected', on);
  });
  const play = (k) => {
    const { run, body } = bodies[choice.value];
    const { mesh } = body;
    const mode = mesh.modes[k];
    const mine = { k };
    const unit = unitAmplitude(mesh, k);
    const start = performance.now();
    const starting = shown === null;
    shown = mine;
    halt.disabled = false;
    mark();
    view.set({ playing: false, selection: { kind: 'body', index: model.bodyEntry(run.index, body.index).index } });
    const swing = (now) => {
      if (shown !== mine) return;
      const eta = new Float64Array(mesh.modes.length);
      eta[k] = unit * amplitude.value * Math.sin(2 * Math.PI * kPace * ((now - start) / 1000) + Math.PI / 2);
      view.set({ mode: { run: run.index, body: body.index, eta, note: `${body.name} · ${mode.name || `mode ${k + 1}`} · ${frequencyText(mode)}` } });
      requestAnimationFrame(swing);
    };
    requestAnimationFrame(swing);
    if (starting) fit(model.bodyEntry(run.index, body.index).index);
  };
  const fill = () => {
    const { mesh } = bodies[choice.value].body;
    note.textContent = mesh.natural ? '' : 'These shapes were fitted to the motion: they are no natural modes of the body.';
    note.hidden = mesh.natural;
    clear(list).append(...mesh.modes.map((mode, k) => h('button.row', { type: 'button', role: 'option', onclick: () => (shown?.k === k ? stop() : play(k)) },
      h('span.badge.connector', { 'aria-hidden': 'true' }, String(k + 1)), h('span.name', {}, mode.name || `mode ${k + 1}`), h('span.number', {}, frequencyText(mode)))));
    mark();
  };
  amplitude.addEventListener('input', tellAmplitude);
  // Whoever goes on in time wants to see the motion again.
  view.watch(['playing'], () => { if (view.playing && shown) stop(); });
  tellAmplitude();
  fill();
  panel.append(h('label.wide', {}, 'Body', choice), note, h('div.scale', {}, h('span', {}, 'Amplitude'), amplitude, told), list, halt);
  panel.stop = stop;
  return panel;
}
