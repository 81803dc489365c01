// The system graph: bodies as boxes, connectors as small discs with the letters of their kind.
import { h, s, set } from '../dom.js';
import { kMostDrawnBodies, placeGraph } from './graph_layout.js';

const kShort = {
  revolute: 'R', spherical: 'S', prismatic: 'P', cylindrical: 'C', universal: 'U', fixed: 'F', planar: 'E', screw: 'H',
  threenodefixation: '3N',
};

/** The letters of a kind: R for a revolute joint, SD for a spring-damper. */
export function letters(kind) {
  const word = kind.replace(/Joint$|_joint$/, '');
  const known = kShort[word.toLowerCase().replaceAll('_', '')];
  if (known) return known;
  const initials = word.includes('_') ? word.split('_').map((part) => part[0]) : (word.match(/[A-Z]/g) ?? [word[0] ?? '?']);
  return initials.slice(0, 3).join('').toUpperCase();
}

const short = (name) => (name.length > 18 ? `${name.slice(0, 16)}…` : name);

export function graphView(model, view) {
  if (model.bodies.length > kMostDrawnBodies) {
    return h('p.hint', {}, `${model.bodies.length} bodies are too many to draw as a graph: the list has them all.`);
  }
  const bodies = model.bodies.map((entry) => ({
    kind: 'body', entry, width: 18 + 6.6 * short(entry.name).length, height: 24,
    root: entry.item.kind === 'Ground',
  }));
  const connectors = model.connectors.map((entry) => ({ kind: 'connector', entry, width: 22, height: 22 }));
  const nodes = [...bodies, ...connectors];
  const links = connectors.flatMap((node, i) => node.entry.bodies.map((b) => [b, bodies.length + i]));
  placeGraph(nodes, links);

  const lines = links.map(([b, c]) => {
    const [from, to] = [nodes[b], nodes[c]];
    return s(`line.${to.entry.item.role}`, { x1: from.x, y1: from.y, x2: to.x, y2: to.y });
  });
  const drawn = nodes.map((node) => drawNode(node, view));
  const world = s('g', {}, ...lines, ...drawn);
  const picture = s('svg.graph', { role: 'group', 'aria-label': 'System graph: bodies and connectors', tabindex: '-1' }, world);

  const tell = () => {
    nodes.forEach(({ kind, entry }, i) => {
      const selected = view.selection?.kind === kind && view.selection.index === entry.index;
      drawn[i].classList.toggle('selected', selected);
      drawn[i].setAttribute('aria-pressed', selected);
      drawn[i].classList.toggle('absent', !entry.of.some((index, r) => index >= 0 && view.runs[r].shown));
    });
    lines.forEach((line, i) => {
      const [b, c] = links[i];
      line.classList.toggle('selected', [nodes[b], nodes[c]].some(({ kind, entry }) =>
        view.selection?.kind === kind && view.selection.index === entry.index));
    });
  };
  view.watch(['selection', 'runs'], tell);
  tell();
  walkable(nodes, drawn);
  movable(picture, world, nodes);
  return h('div.graph-frame', {}, picture, h('div.graph-key.faint', { 'aria-hidden': 'true' }, 'wheel: zoom · drag: move · double click: fit'));
}

function drawNode({ kind, entry, x, y, width, height, root }, view) {
  const { item, name, index } = entry;
  const select = () => view.set({ selection: { kind, index } });
  const node = s(`g.node.${kind}`, {
    transform: `translate(${x.toFixed(1)} ${y.toFixed(1)})`, tabindex: -1, role: 'button', 'data-kind': kind,
    'data-name': name, 'aria-label': `${name}, ${item.kind}`, onclick: select,
    onkeydown: (event) => { if (event.key === 'Enter' || event.key === ' ') select(); },
  }, s('title', {}, `${name} · ${item.kind}${item.where ? ` · ${item.where}` : ''}`));
  if (kind === 'body') {
    node.append(s('rect', { x: -width / 2, y: -height / 2, width, height, rx: item.mesh ? 0 : 5 }));
    if (item.mesh) node.append(s('path.mesh', { d: `M${-width / 2} ${height / 2 - 5}h${width}` }));
    if (root) node.append(s('path.ground', { d: hatch(width, height) }));
  } else {
    node.classList.add(item.role);
    node.append(item.role === 'joint' ? s('circle', { r: 11 }) : s('rect', { x: -11, y: -9, width: 22, height: 18, rx: 9 }));
  }
  node.append(s('text', { 'text-anchor': 'middle', dy: '0.34em' }, kind === 'body' ? short(name) : letters(item.kind)));
  return node;
}

/** One stop of the tab key; arrows go to the nearest node that way. */
function walkable(nodes, drawn) {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  drawn[0].setAttribute('tabindex', 0);
  drawn.forEach((element, i) => {
    element.addEventListener('focus', () => drawn.forEach((one) => one.setAttribute('tabindex', one === element ? 0 : -1)));
    element.addEventListener('keydown', (event) => {
      const way = ways[event.key];
      if (!way) return;
      event.preventDefault();
      event.stopPropagation();
      let best = Infinity;
      let next = element;
      nodes.forEach(({ x, y }, j) => {
        const [dx, dy] = [x - nodes[i].x, y - nodes[i].y];
        const along = dx * way[0] + dy * way[1];
        const cost = along + 2 * Math.abs(dx * way[1] + dy * way[0]);
        if (along > 1 && cost < best) [best, next] = [cost, drawn[j]];
      });
      next.focus();
    });
  });
}

/** The draughtsman's sign for what stands still. */
function hatch(width, height) {
  const strokes = [];
  for (let x = -width / 2 + 4; x < width / 2; x += 7) strokes.push(`M${x} ${height / 2}l-4 5`);
  return strokes.join('');
}

/** Wheel, drag and double click on the drawing. */
function movable(picture, world, nodes) {
  let place = { x: 0, y: 0, scale: 1 };
  const apply = () => set(world, { transform: `translate(${place.x} ${place.y}) scale(${place.scale})` });
  const fit = () => {
    const { clientWidth: width, clientHeight: height } = picture;
    if (!width || !nodes.length) return;
    const low = [Math.min(...nodes.map((n) => n.x - n.width / 2)), Math.min(...nodes.map((n) => n.y - n.height / 2))];
    const high = [Math.max(...nodes.map((n) => n.x + n.width / 2)), Math.max(...nodes.map((n) => n.y + n.height / 2))];
    const scale = Math.min(1.15, (width - 24) / (high[0] - low[0]), (height - 30) / (high[1] - low[1]));
    place = { scale, x: width / 2 - (scale * (low[0] + high[0])) / 2, y: (height - 8) / 2 - (scale * (low[1] + high[1])) / 2 };
    apply();
  };
  const zoom = (factor, [x, y]) => {
    place = { scale: place.scale * factor, x: x - factor * (x - place.x), y: y - factor * (y - place.y) };
    apply();
  };
  picture.addEventListener('wheel', (event) => {
    event.preventDefault();
    const box = picture.getBoundingClientRect();
    zoom(Math.exp(-0.0015 * event.deltaY), [event.clientX - box.left, event.clientY - box.top]);
  }, { passive: false });
  picture.addEventListener('keydown', (event) => {
    const factor = { z: 1.25, Z: 0.8 }[event.key];
    if (!factor && event.key !== '0') return;
    event.stopPropagation();
    const [box, node] = [picture.getBoundingClientRect(), event.target.getBoundingClientRect()];
    if (factor) zoom(factor, [node.left + node.width / 2 - box.left, node.top + node.height / 2 - box.top]);
    else fit();
  });
  let from = null;
  picture.addEventListener('pointerdown', (event) => { from = { x: event.clientX - place.x, y: event.clientY - place.y }; });
  picture.addEventListener('pointermove', (event) => {
    if (!from || !(event.buttons & 1)) return;
    place = { ...place, x: event.clientX - from.x, y: event.clientY - from.y };
    apply();
  });
  picture.addEventListener('pointerup', () => { from = null; });
  picture.addEventListener('dblclick', fit);
  new ResizeObserver(fit).observe(picture);
}
