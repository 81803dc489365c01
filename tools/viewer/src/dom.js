// Small words for building the page.

/** h('button.primary', {title: 'x', onclick: f}, 'text', child): an element with class, attributes and children. */
export function h(tag, attributes, ...children) {
  const [name, ...classes] = tag.split('.');
  const element = document.createElement(name || 'div');
  if (classes.length) element.className = classes.join(' ');
  set(element, attributes ?? {});
  element.append(...children.flat().filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** As h() for SVG. */
export function s(tag, attributes, ...children) {
  const [name, ...classes] = tag.split('.');
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  if (classes.length) element.setAttribute('class', classes.join(' '));
  set(element, attributes ?? {});
  element.append(...children.flat());
  return element;
}

export function set(element, attributes) {
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(key, value);
  }
  return element;
}

const kIcons = {
  play: 'M5 3.2v9.6L13 8z',
  pause: 'M4 3h3v10H4zM9 3h3v10H9z',
  back: 'M10.5 3v10L4.5 8zM3 3h1.4v10H3z',
  forth: 'M5.5 3v10l6-5zM11.6 3H13v10h-1.4z',
  first: 'M12.5 3v10L7 8zM7 3v10L1.5 8z',
  loop: 'M4 5h7V3l3 3-3 3V7H5v2H3V6a1 1 0 0 1 1-1zm8 6H5v2l-3-3 3-3v2h6V7h2v3a1 1 0 0 1-1 1z',
  fit: 'M2 2h4v1.5H3.5V6H2zm8 0h4v4h-1.5V3.5H10zM2 10h1.5v2.5H6V14H2zm10.5 0H14v4h-4v-1.5h2.5zM6 6h4v4H6z',
  follow: 'M8 1v3M8 12v3M1 8h3M12 8h3',
  theme: 'M8 2a6 6 0 1 0 0 12zM8 2a6 6 0 0 1 0 12',
  plus: 'M7.2 3h1.6v4.2H13v1.6H8.8V13H7.2V8.8H3V7.2h4.2z',
  close: 'M4.1 3 8 6.9 11.9 3 13 4.1 9.1 8l3.9 3.9-1.1 1.1L8 9.1 4.1 13 3 11.9 6.9 8 3 4.1z',
  chart: 'M2 2h1.5v10.5H14V14H2zM5 11V7h2v4zm3.5 0V4h2v7zM12 11V6h2v5z',
  panel: 'M2 3h12v10H2zm1.4 1.4v7.2H9V4.4zm7 0v7.2h2.2V4.4z',
};

export function icon(name) {
  const stroked = name === 'follow';
  const path = s('path', { d: kIcons[name], fill: stroked ? 'none' : 'currentColor', 'fill-rule': 'evenodd' });
  const picture = s('svg', { viewBox: '0 0 16 16', width: 16, height: 16, 'aria-hidden': 'true' }, path);
  if (stroked) {
    set(path, { stroke: 'currentColor', 'stroke-width': 1.5 });
    picture.append(s('circle', { cx: 8, cy: 8, r: 3, fill: 'none', stroke: 'currentColor', 'stroke-width': 1.5 }));
  }
  if (name === 'theme') {
    set(path, { d: 'M8 2a6 6 0 1 0 0 12z' });
    picture.append(s('circle', { cx: 8, cy: 8, r: 5.3, fill: 'none', stroke: 'currentColor', 'stroke-width': 1.4 }));
  }
  return picture;
}

/** A button with an icon; `keys` is told in its tip. */
export function iconButton(name, label, keys, onclick) {
  const tip = keys ? `${label} (${keys})` : label;
  return h('button.icon', { type: 'button', title: tip, 'aria-label': tip, onclick }, icon(name));
}

/** Calls `act` a little later, once for all calls till then. */
export function throttled(ms, act) {
  let waiting = 0;
  return () => {
    waiting ||= setTimeout(() => {
      waiting = 0;
      act();
    }, ms);
  };
}

export function clear(element) {
  element.replaceChildren();
  return element;
}

/** A short line of a variant's or channel's colour and dash. */
export function lineSample(colour, dash, width = 26) {
  return s('svg.sample', { width, height: 8, viewBox: `0 0 ${width} 8`, 'aria-hidden': 'true' },
    s('line', { x1: 1, y1: 4, x2: width - 1, y2: 4, stroke: colour, 'stroke-width': 2.2, 'stroke-dasharray': dash.join(' ') }));
}
