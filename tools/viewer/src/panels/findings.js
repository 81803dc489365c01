// What a look at the scene has found: a list whose names select bodies and connectors.
import { h } from '../dom.js';

export function findingsView(model, view) {
  const named = new Map();
  for (const [kind, entries] of [['connector', model.connectors], ['body', model.bodies]]) {
    for (const { name, index } of entries) named.set(name, { kind, index });
  }
  /** The text with a button in place of each 'name' that there is. */
  const linked = (text) => text.split(/('[^']+')/).map((part) => {
    const selection = named.get(part.slice(1, -1));
    return selection ? h('button.link', { type: 'button', onclick: () => view.set({ selection }) }, part.slice(1, -1)) : part;
  });
  return h('div.findings', {}, model.findings.map(({ kind, text, fix, alarm }) =>
    h(`article.finding${alarm ? '.alarm' : ''}`, { 'aria-label': kind },
      h('p', {}, h('b', {}, alarm ? kind : `${kind} (worth knowing)`)),
      h('p', {}, linked(text)),
      fix && h('p.faint', {}, 'fix: ', linked(fix)))));
}
