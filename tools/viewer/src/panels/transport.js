// The row under the scene: play, step, time slider with events, speed, loop.
import { clear, h, icon, iconButton, set } from '../dom.js';
import { timeText } from '../format.js';
import { kSpeeds } from '../clock.js';

const kSteps = 10000; // of the slider

export function transport(model, view, clock) {
  const span = () => model.end - model.start;
  const play = iconButton('play', 'Play', 'space', () => clock.toggle());
  const slider = h('input.time', { type: 'range', min: 0, max: kSteps, step: 1, value: 0, 'aria-label': 'Time', id: 'time' });
  slider.addEventListener('input', () => {
    view.set({ playing: false });
    clock.goTo(model.start + (span() * slider.value) / kSteps);
  });
  const shown = h('output.clock', { for: 'time', 'aria-live': 'off' });
  const speed = h('select', { 'aria-label': 'Speed', title: 'Speed: simulated seconds a second (+ and −)', onchange: () => view.set({ speed: Number(speed.value) }) },
    kSpeeds.map((value) => h('option', { value }, `${value}×`)));
  const loop = iconButton('loop', 'Loop', 'l', () => view.set({ loop: !view.loop }));
  const events = model.runs.flatMap((run) => run.events.map((event) => ({ ...event, run })));
  const ticks = h('div.ticks', { 'aria-hidden': 'true' }, events.slice(0, 400).map((event) =>
    h('i', { style: `left:${(100 * (event.time - model.start)) / (span() || 1)}%`, title: `${event.name} at ${event.time} s` })));

  const tell = () => {
    slider.value = Math.round((kSteps * (view.time - model.start)) / (span() || 1));
    slider.style.setProperty('--part', `${(100 * (view.time - model.start)) / (span() || 1)}%`);
    set(slider, { 'aria-valuetext': `${timeText(view.time, span())} seconds` });
    shown.textContent = `${timeText(view.time, span())} s`;
  };
  const end = h('span.faint.end', { title: 'End of the run' });
  const tellEnd = () => {
    end.textContent = `/ ${timeText(model.end, span())} s`;
    tell();
  };
  const tellPlaying = () => {
    clear(play).append(icon(view.playing ? 'pause' : 'play'));
    const label = `${view.playing ? 'Pause' : 'Play'} (space)`;
    set(play, { title: label, 'aria-label': label });
    speed.value = view.speed;
    loop.setAttribute('aria-pressed', view.loop);
  };
  view.watch(['time'], tell);
  view.watch(['frames'], tellEnd);
  view.watch(['playing', 'speed', 'loop'], tellPlaying);
  tellEnd();
  tellPlaying();
  return h('section.transport', { 'aria-label': 'Time' },
    iconButton('first', 'To the start', 'home', () => clock.goTo(model.start)),
    iconButton('back', 'Frame back', '←', () => clock.step(-1)), play,
    iconButton('forth', 'Frame forth', '→', () => clock.step(1)),
    h('div.slider', {}, slider, ticks), shown,
    end, speed, loop);
}
