// Tabs of the side panel; a page is built when it is first shown.
import { h } from '../dom.js';

export function tabs(pages) {
  const panels = pages.map(([name], i) => h('div.tab-page', { role: 'tabpanel', id: `page-${name}`, 'aria-labelledby': `tab-${name}`, hidden: i > 0 }));
  const buttons = pages.map(([name], i) => h('button', { type: 'button', role: 'tab', id: `tab-${name}`, 'aria-controls': `page-${name}`, onclick: () => show(i) }, name));
  const show = (chosen) => {
    if (!panels[chosen].hasChildNodes()) panels[chosen].append(pages[chosen][1]());
    panels.forEach((panel, i) => {
      panel.hidden = i !== chosen;
      buttons[i].setAttribute('aria-selected', i === chosen);
      buttons[i].tabIndex = i === chosen ? 0 : -1;
    });
  };
  const bar = h('div.tabs', { role: 'tablist', 'aria-label': 'System' }, buttons);
  bar.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!step) return;
    event.stopPropagation();
    const next = (buttons.indexOf(document.activeElement) + step + buttons.length) % buttons.length;
    show(next);
    buttons[next].focus();
  });
  show(0);
  const element = h('section.system', { 'aria-label': 'System' }, bar, panels);
  /** Shows the page of that name, and returns it. */
  element.open = (name) => {
    const i = pages.findIndex(([one]) => one === name);
    show(i);
    return panels[i];
  };
  return element;
}
