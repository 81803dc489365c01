// All bodies and connectors as a list that can be searched.
import { clear, h } from '../dom.js';
import { letters } from './graph_view.js';

const kMostRows = 400;

export function listView(model, view) {
  const search = h('input', { type: 'search', placeholder: 'Find a body or connector', 'aria-label': 'Find a body or connector' });
  const rows = h('div.rows', { role: 'listbox', 'aria-label': 'Bodies and connectors' });
  const all = [
    ...model.bodies.map((entry) => ({ kind: 'body', entry })),
    ...model.connectors.map((entry) => ({ kind: 'connector', entry })),
  ];
  const fill = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = all.filter(({ entry }) => words.every((word) => `${entry.name} ${entry.item.kind}`.toLowerCase().includes(word)));
    clear(rows).append(...found.slice(0, kMostRows).map(({ kind, entry }) => {
      const selected = view.selection?.kind === kind && view.selection.index === entry.index;
      return h(`button.row${selected ? '.selected' : ''}`, {
        type: 'button', role: 'option', 'aria-selected': String(selected), 'data-kind': kind, 'data-name': entry.name,
        onclick: () => view.set({ selection: { kind, index: entry.index } }),
      }, h(`span.badge.${kind}`, { 'aria-hidden': 'true' }, kind === 'body' ? (entry.item.mesh ? '▦' : '■') : letters(entry.item.kind)),
      h('span.name', {}, entry.name), h('span.faint', {}, entry.item.kind));
    }));
    if (found.length > kMostRows) rows.append(h('p.hint', {}, `and ${found.length - kMostRows} more: search for them.`));
    if (!found.length) rows.append(h('p.hint', {}, 'Nothing of that name.'));
  };
  search.addEventListener('input', fill);
  view.watch(['selection'], fill);
  fill();
  return h('div.list', {}, search, rows);
}
