// The row on top: the title, the variants with their switches, theme and help.
import { clear, h, iconButton, lineSample } from '../dom.js';
import { runDash, runDashName, seriesColour } from '../palette.js';

function variant(model, view, r) {
  const run = model.runs[r];
  const change = (part) => view.set({ runs: view.runs.map((one, i) => (i === r ? { ...one, ...part } : one)) });
  const { shown, solid } = view.runs[r];
  return h(`div.variant${shown ? '' : '.off'}`, { role: 'group', 'aria-label': `Variant ${run.name}` },
    h('label', { title: `Show variant ${run.name} (shift+${r + 1}); its lines are ${runDashName(r)}` },
      h('input', { type: 'checkbox', checked: shown, onchange: (event) => change({ shown: event.target.checked }), 'data-focus': `shown${r}` }),
      lineSample(seriesColour(r, view.theme), runDash(r)), run.name),
    h('button.small', {
      type: 'button', 'aria-pressed': String(!solid), onclick: () => change({ solid: !solid }), 'data-focus': `solid${r}`,
      title: solid ? 'Make it translucent' : 'Make it solid',
    }, solid ? 'solid' : 'translucent'));
}

export function header(model, view, { help, toggleSide, toggleCharts, live }) {
  const variants = h('div.variants', {});
  const tell = () => {
    const focus = document.activeElement?.dataset?.focus;
    clear(variants);
    if (model.runs.length > 1) variants.append(...model.runs.map((_, r) => variant(model, view, r)));
    if (focus) variants.querySelector(`[data-focus=${focus}]`)?.focus();
  };
  view.watch(['runs', 'theme'], tell);
  tell();
  const theme = iconButton('theme', 'Light or dark', 't', () => view.set({ theme: view.theme === 'dark' ? 'light' : 'dark' }));
  return h('header.bar', {}, h('h1', { title: model.title }, model.title), variants, live, h('span.gap', {}),
    h('span.faint.made', {}, model.made_by),
    iconButton('chart', 'Charts', 'c', toggleCharts), iconButton('panel', 'Side panel', 'g', toggleSide), theme,
    h('button.icon', { type: 'button', title: 'Keys and help (?)', 'aria-label': 'Keys and help (?)', onclick: help }, '?'));
}
