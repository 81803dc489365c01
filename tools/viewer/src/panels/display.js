// Switches and scales of the 3D view.
import { h } from '../dom.js';
import { number } from '../format.js';
import { fieldNames } from '../scene/field.js';

const kSwitches = [
  ['edges', 'Edges', 'e'], ['elements', 'Elements', 'q'], ['joints', 'Joints and forces', 'j'], ['markers', 'Markers', 'm'], ['traces', 'Traces', 'p'],
  ['reactions', 'Reaction forces', 'r'], ['moments', 'Reaction moments', ''], ['contacts', 'Contact forces', 'k'],
  ['contact_shapes', 'Contact shapes', ''], ['labels', 'Names', 'n'], ['grid', 'Grid', ''],
];

/** A slider over powers of ten, 1 in the middle. */
function scale(label, view, key, told) {
  const text = h('output', {});
  const slider = h('input', { type: 'range', min: -2, max: 2, step: 0.02, 'aria-label': label, oninput: () => view.set({ [key]: 10 ** slider.value }) });
  const tell = () => {
    slider.value = Math.log10(view[key]);
    text.textContent = told();
  };
  view.watch([key], tell);
  tell();
  return h('div.scale', {}, h('span', {}, label), slider, text);
}

export function displayView(model, view, stage) {
  const fields = fieldNames(model);
  const colouring = h('select', { 'aria-label': 'Colour of finite-element bodies', onchange: () => view.set({ colouring: colouring.value }) },
    fields.map((name) => h('option', { value: name }, name)));
  const check = (label, key) => {
    const box = h('input', { type: 'checkbox', onchange: () => view.set({ [key]: box.checked }) });
    view.watch([key], () => { box.checked = view[key]; });
    box.checked = view[key];
    return h('label', {}, box, label);
  };
  view.watch(['colouring'], () => { colouring.value = view.colouring; });
  colouring.value = view.colouring;
  const switches = kSwitches.map(([key, label, keys]) => {
    const box = h('input', { type: 'checkbox', onchange: () => view.set({ show: { ...view.show, [key]: box.checked } }) });
    const tell = () => { box.checked = view.show[key]; };
    view.watch(['show'], tell);
    tell();
    return h('label', {}, box, label, keys && h('kbd', {}, keys));
  });
  const notes = [...new Set(model.runs.flatMap((run) => run.notes))];
  const sizes = () => stage?.arrowSizes() ?? { force: 1, moment: 1 };
  const arrows = () => `${number(0.1 / sizes().force, 3)} N : 100 mm`;
  return h('div.display', {},
    fields.length > 1 && h('fieldset', {}, h('legend', {}, 'Finite-element bodies'),
      h('label.wide', {}, 'Colour', colouring), h('div.pair', {}, check('in bands', 'bands'), check('range of the whole run', 'whole_range')),
      scale('Deformation', view, 'magnification', () => `× ${number(view.magnification, 3)}`)),
    h('fieldset', {}, h('legend', {}, 'Shown'), h('div.pair', {}, switches)),
    h('fieldset', {}, h('legend', {}, 'Sizes'),
      scale('Arrows', view, 'arrow_scale', arrows),
      scale('Joints', view, 'glyph_scale', () => `× ${number(view.glyph_scale, 3)}`)),
    notes.length > 0 && h('fieldset', {}, h('legend', {}, 'Not drawn'), notes.map((note) => h('p.faint', {}, note))));
}
