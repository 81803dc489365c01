// The sheet of keys.
import { h } from '../dom.js';

const kKeys = [
  ['space', 'play, pause'], ['← →', 'a frame back, forth; with shift ten'], ['home end', 'start, end'],
  ['+ −', 'faster, slower'], ['l', 'loop'], ['f', 'fit the whole motion'], ['shift F', 'fit the selected body'],
  ['0', 'first view'], ['z x y v b', 'zoom in, turn, tilt, move right, up; with shift the other way'], ['1 2 3', 'view along x, y, z; again: from the other side'], ['o', 'parallel or perspective'],
  ['w', 'follow the selected body'], ['[ ]', 'select the body before, after'], ['esc', 'select nothing, close'], ['e q j m p', 'edges, elements, joints, markers, traces'],
  ['r k n', 'reactions, contact forces, names'], ['shift 1 …', 'variant on, off'], ['/', 'find a body or connector'], ['a', 'add a channel to the charts'],
  ['c g', 'charts, side panel on, off'], ['t', 'light or dark'], ['?', 'this sheet'],
];

const kMouse = [
  ['keys', 'tab goes through all; arrows go through tabs, graph and lists; enter and space press; z, shift Z and 0 zoom the focused chart or graph'],
  ['touch', 'one finger turns, two zoom and move, a tap selects'],
  ['scene', 'drag turns, wheel zooms, right drag moves, click selects, double click fits a body'],
  ['charts', 'click sets the time, drag zooms, double click shows all'],
  ['graph', 'click selects, wheel zooms, drag moves'],
];

export function helpSheet() {
  const sheet = h('dialog.help', { 'aria-label': 'Keys and help' },
    h('h2', {}, 'Keys'),
    h('dl', {}, kKeys.flatMap(([keys, what]) => [h('dt', {}, keys.split(' ').map((key) => h('kbd', {}, key))), h('dd', {}, what)])),
    h('h2', {}, 'Tab, touch and mouse'),
    h('dl', {}, kMouse.flatMap(([where, what]) => [h('dt', {}, where), h('dd', {}, what)])),
    h('form', { method: 'dialog' }, h('button', {}, 'Close')));
  sheet.addEventListener('click', (event) => { if (event.target === sheet) sheet.close(); });
  return sheet;
}
