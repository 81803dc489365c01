// What a run that goes on can be asked for: to run, to pause, a step, the end, its pace, its inputs; and to be saved.
import { clear, h, icon } from '../dom.js';
import { number } from '../format.js';
import { savedPage } from '../save.js';

const kPaces = [0, 0.01, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const kStates = {
  connecting: 'connecting', running: 'running', paused: 'paused', stopping: 'ending', ended: 'the run has ended',
  lost: 'the program has gone',
};
const kOver = ['ended', 'lost'];

/** The buttons at the head of the page. */
export function liveBar(live, view) {
  const button = (name, label, onclick) => h('button', { type: 'button', title: label, onclick }, name);
  const run = h('button.run', { type: 'button', onclick: () => live.send({ do: view.live.state === 'paused' ? 'run' : 'pause' }) });
  const step = button('Step', 'To the next observed state', () => { view.set({ head: true }); live.send({ do: 'step' }); });
  const stop = button('End', 'Ends the run here, its results kept', () => live.send({ do: 'stop' }));
  const pace = h('select', { 'aria-label': 'Pace of the run', title: 'Pace of the run: simulated seconds a second', onchange: () => live.send({ speed: Number(pace.value) }) });
  const state = h('output.live-state', { role: 'status' });
  const head = button('Newest', 'Show the newest state as it comes', () => view.set({ head: true, playing: false, time: live.model.end }));
  const save = button('Save', 'Save all states so far as a page that needs no program', async () => {
    const url = URL.createObjectURL(new Blob([await savedPage(live.page, live.run)], { type: 'text/html' }));
    h('a', { href: url, download: `${live.model.title}.html` }).click();
    setTimeout(() => URL.revokeObjectURL(url), 60000);
  });
  const tell = () => {
    const { state: now, speed } = view.live;
    const paused = now === 'paused';
    clear(run).append(icon(paused ? 'play' : 'pause'), paused ? 'Run' : 'Pause');
    state.textContent = kStates[now];
    for (const one of [run, step, stop, pace]) one.disabled = kOver.includes(now) || now === 'stopping';
    const paces = kPaces.includes(speed) ? kPaces : [...kPaces, speed].sort((a, b) => a - b);
    if (pace.options.length !== paces.length) clear(pace).append(...paces.map((value) => h('option', { value }, value ? `${value}× real time` : 'as fast as possible')));
    pace.value = speed;
  };
  const tellHead = () => head.setAttribute('aria-pressed', String(view.head));
  view.watch(['live'], tell);
  view.watch(['head'], tellHead);
  tell();
  tellHead();
  return h('div.live', { role: 'group', 'aria-label': 'The run' }, state, run, step, stop, pace, head, save);
}

/** One slider an input. */
export function inputsView(live, view) {
  const problem = h('p.problem', { role: 'alert', hidden: true });
  const rows = h('div.inputs', {});
  let known = null;
  let sliders = [];
  const tell = () => {
    const { inputs, problem: what, state } = view.live;
    const names = inputs.map((input) => input.name).join('\n');
    if (names !== known) {
      known = names;
      sliders = inputs.map((input) => inputRow(live, input));
      clear(rows).append(...sliders.map((one) => one.element));
      if (!inputs.length) rows.append(h('p.hint', {}, 'The scene has no inputs: graph.add<Input>(…) draws one.'));
    }
    sliders.forEach((slider, i) => slider.tell(inputs[i], kOver.includes(state)));
    problem.hidden = !what;
    problem.textContent = what;
  };
  view.watch(['live'], tell);
  tell();
  return h('div.display', {}, problem, rows);
}

function inputRow(live, { name, unit, description, lower, upper, value }) {
  const reach = Math.max(1, 2 * Math.abs(value));
  const [low, high] = [lower ?? value - reach, upper ?? value + reach];
  const send = (wish) => live.send({ input: name, value: wish });
  const slider = h('input', {
    type: 'range', min: low, max: high, step: (high - low) / 1000 || 1, 'aria-label': name, 'data-input': name,
    oninput: () => { field.value = Number(slider.value); send(Number(slider.value)); },
  });
  const field = h('input', {
    type: 'number', step: 'any', 'aria-label': `${name}, as a number`,
    onchange: () => Number.isFinite(field.valueAsNumber) && send(field.valueAsNumber),
  });
  let held = false; // by a hand: what comes back meanwhile is older
  slider.addEventListener('pointerdown', () => { held = true; });
  window.addEventListener('pointerup', () => { held = false; });
  const now = h('output', {});
  const tell = (input, over) => {
    now.textContent = `${number(input.value)} ${unit}`;
    for (const one of [slider, field]) one.disabled = over;
    if (held || document.activeElement === field) return;
    slider.value = input.value;
    field.value = Number(input.value.toPrecision(6));
  };
  return { tell, element: h('fieldset', {}, h('legend', { title: description }, name, ' ', now), h('div.input', {}, slider, field)) };
}
