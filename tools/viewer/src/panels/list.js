// All bodies and connectors as a list that can be searched.
import { h } from '../dom.js';
import { letters } from './graph_view.js';
import { searchList } from './search_list.js';

export function listView(model, view) {
  const { search, rows } = searchList({
    items: [
      ...model.bodies.map((entry) => ({ kind: 'body', entry })),
      ...model.connectors.map((entry) => ({ kind: 'connector', entry })),
    ],
    text: ({ entry }) => `${entry.name} ${entry.item.kind}`,
    row: ({ kind, entry }) => mark(h('button.row', {
      type: 'button', role: 'option', 'data-kind': kind, 'data-name': entry.name, 'data-index': entry.index,
      onclick: () => view.set({ selection: { kind, index: entry.index } }),
    }, h(`span.badge.${kind}`, { 'aria-hidden': 'true' }, kind === 'body' ? (entry.item.mesh ? '▦' : '■') : letters(entry.item.kind)),
    h('span.name', {}, entry.name), h('span.faint', {}, entry.item.kind))),
    most: 400, name: 'Find a body or connector', placeholder: 'Find a body or connector (/)', list_name: 'Bodies and connectors', nothing: 'Nothing of that name.',
  });
  function mark(button) {
    const { kind, index } = button.dataset;
    const selected = view.selection?.kind === kind && view.selection.index === Number(index);
    button.classList.toggle('selected', selected);
    button.setAttribute('aria-selected', selected);
    return button;
  }
  view.watch(['selection'], () => rows.querySelectorAll('button').forEach(mark));
  return h('div.list', {}, search, rows);
}
