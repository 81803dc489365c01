// Finds a channel by its name among all that can be charted.
import { clear, h } from '../dom.js';

const kMostRows = 60;

/** A dialog; open(choose) shows it and hands the chosen channel to `choose`. */
export function channelPicker(model) {
  let choose = () => {};
  const search = h('input', { type: 'search', placeholder: `Find one of ${model.channels.length} channels`, 'aria-label': 'Find a channel' });
  const rows = h('div.rows', { role: 'listbox', 'aria-label': 'Channels' });
  const sheet = h('dialog.picker', { 'aria-label': 'Add a channel' }, search, rows);
  const fill = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = model.channels.filter((one) => words.every((word) => `${one.name} ${one.group} ${one.unit}`.toLowerCase().includes(word)));
    clear(rows).append(...found.slice(0, kMostRows).map((channel) => h('button.row', {
      type: 'button', role: 'option', 'data-name': channel.name,
      onclick: () => { sheet.close(); choose(channel); },
    }, h('span.name', {}, channel.name), h('span.number', {}, channel.unit), h('span.faint', {}, channel.group))));
    if (found.length > kMostRows) rows.append(h('p.hint', {}, `and ${found.length - kMostRows} more: search for them.`));
    if (!found.length) rows.append(h('p.hint', {}, 'No channel of that name.'));
  };
  search.addEventListener('input', fill);
  search.addEventListener('keydown', (event) => {
    if (event.key === 'Enter') rows.querySelector('button')?.click();
    if (event.key === 'ArrowDown') rows.querySelector('button')?.focus();
  });
  rows.addEventListener('keydown', (event) => {
    const step = { ArrowDown: 'nextElementSibling', ArrowUp: 'previousElementSibling' }[event.key];
    if (!step) return;
    event.preventDefault();
    (document.activeElement[step] ?? search).focus();
  });
  sheet.addEventListener('click', (event) => { if (event.target === sheet) sheet.close(); });
  sheet.open_for = (then) => {
    choose = then;
    search.value = '';
    fill();
    sheet.showModal();
    search.focus();
  };
  return sheet;
}
