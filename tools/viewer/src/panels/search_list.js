// A field for words and a list of what they find: by mouse, or by keys alone.
import { clear, h } from '../dom.js';

/**
 * `text(item)` is searched for the words, `row(item)` makes its button. Enter takes the first row, arrows go from the
 * field through the rows, and back; the rows are one stop of the tab key. Returns {search, rows, fill}.
 */
export function searchList({ items, text, row, most, name, placeholder, list_name, nothing }) {
  const search = h('input', { type: 'search', placeholder, 'aria-label': name });
  const rows = h('div.rows', { role: 'listbox', 'aria-label': list_name });
  const buttons = () => [...rows.querySelectorAll('button')];
  const fill = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    const found = items.filter((item) => words.every((word) => text(item).toLowerCase().includes(word)));
    clear(rows).append(...found.slice(0, most).map(row));
    buttons().forEach((button, i) => { button.tabIndex = i ? -1 : 0; });
    if (found.length > most) rows.append(h('p.hint', {}, `and ${found.length - most} more: search for them.`));
    if (!found.length) rows.append(h('p.hint', { role: 'status' }, nothing));
  };
  search.addEventListener('input', fill);
  search.addEventListener('keydown', (event) => {
    const [first] = buttons();
    if (event.key === 'Enter') first?.click();
    if (event.key !== 'ArrowDown') return;
    event.preventDefault();
    first?.focus();
  });
  rows.addEventListener('keydown', (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    const all = buttons();
    const next = all.indexOf(document.activeElement) + step;
    (next < 0 ? search : all[Math.min(next, all.length - 1)]).focus();
  });
  fill();
  return { search, rows, fill };
}
