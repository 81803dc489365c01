// What is known of the selected body or connector at the present time, a column a variant.
import { clear, h, iconButton, icon, lineSample } from '../dom.js';
import { number } from '../format.js';
import { bodyPose, locate, modalCoordinates, vectorAt } from '../motion.js';
import { runDash, seriesColour } from '../palette.js';

const kMostModes = 24;
const kRedrawGap = 60; // ms between updates of the numbers while playing

/** Rows of numbers: {label, unit, value(run, t), channel?}. */
function bodyRows(model, entry) {
  const body = (r) => model.runs[r].bodies[entry.of[r]];
  const at = (r, t) => locate(model.runs[r].times, t);
  const rows = [];
  ['x', 'y', 'z'].forEach((axis, c) => rows.push({
    section: 'Coordinates', label: `position ${axis}`, unit: 'm',
    channel: model.channel(`${entry.name}: ${axis}`, `${entry.name}_p_${axis}`),
    value: (r, t) => (body(r) ? bodyPose(body(r), at(r, t)).position[c] : null),
  }));
  ['w', 'x', 'y', 'z'].forEach((axis, c) => rows.push({
    section: 'Coordinates', label: `rotation ${axis}`, unit: '', channel: model.channel(`${entry.name}_e_${axis}`),
    value: (r, t) => (body(r) ? bodyPose(body(r), at(r, t)).rotation[c] : null),
  }));
  const modes = Math.max(0, ...model.runs.map((_, r) => body(r)?.mesh?.modes.length ?? 0));
  for (let k = 0; k < Math.min(modes, kMostModes); ++k) {
    rows.push({
      section: 'Modal coordinates', label: `η${k + 1}`, unit: '',
      channel: model.channel(`${entry.name}: η${k + 1}`, `${entry.name}_eta_${k + 1}`),
      value: (r, t) => {
        const mesh = body(r)?.mesh;
        return mesh && k < mesh.modes.length ? modalCoordinates(mesh, at(r, t))[k] : null;
      },
    });
  }
  return rows;
}

function connectorRows(model, entry) {
  const rows = [];
  const reaction = (r) => model.runs[r].connectors[entry.of[r]]?.reaction;
  for (const [field, letter, unit] of [['force', 'F', 'N'], ['moment', 'M', 'N m']]) {
    if (!model.runs.some((_, r) => reaction(r)?.[field])) continue;
    const vector = (r, t) => (reaction(r)?.[field] ? vectorAt(reaction(r)[field], locate(model.runs[r].times, t)) : null);
    ['x', 'y', 'z'].forEach((axis, c) => rows.push({
      section: 'Reaction, world axes', label: `${letter}${axis}`, unit,
      channel: model.channel(`${entry.name}: ${letter}${axis}`, `${entry.name}_${field}_${axis}`),
      value: (r, t) => vector(r, t)?.[c] ?? null,
    }));
    rows.push({
      section: 'Reaction, world axes', label: `|${letter}|`, unit,
      channel: model.channel(`${entry.name}: |${letter}|`),
      value: (r, t) => { const v = vector(r, t); return v ? Math.hypot(...v) : null; },
    });
  }
  return rows;
}

const kSections = { residual: 'Residual', reaction: 'Reactions', coordinate: 'Velocities and further coordinates', energy: 'Energy', recorded: 'Recorded' };

/** What was recorded of it, less what the rows above tell already. */
function recordedRows(model, kind, entry, told) {
  return model.recorded
    .filter((channel) => channel.subject?.kind === kind && channel.subject.index === entry.index && !told.has(channel))
    .map((channel) => ({
      section: kSections[channel.group] ?? 'Recorded', label: channel.name, unit: channel.unit, channel,
      value: (r, t) => channel.value(r, t),
    }));
}

export function inspector(model, view, { chart, fit, follow }) {
  const panel = h('section.inspector', { 'aria-label': 'Selected', id: 'inspector', tabindex: -1 });
  let cells = [];
  let last = 0;

  const tell = () => {
    for (const { node, row, r } of cells) {
      const text = number(row.value(r, view.time));
      if (node.textContent !== text) node.textContent = text;
    }
    last = performance.now();
  };

  const link = (kind, entry) => h('button.link', { type: 'button', onclick: () => view.set({ selection: { kind, index: entry.index } }) }, entry.name);

  const build = () => {
    const entry = model.entry(view.selection);
    cells = [];
    if (panel.contains(document.activeElement)) panel.focus(); // what had the focus goes
    clear(panel);
    if (!entry) {
      panel.append(h('p.hint', {}, 'Click a body or joint, in the scene, the graph or the list, to see its coordinates, reactions and residual.'));
      return;
    }
    const { kind } = view.selection;
    const { item } = entry;
    const runs = model.runs.map((_, r) => r).filter((r) => view.runs[r].shown && entry.of[r] >= 0);
    const kinds = [...new Set(runs.map((r) => model.runs[r][kind === 'body' ? 'bodies' : 'connectors'][entry.of[r]].kind))];
    panel.append(h('div.inspector-head', {},
      h('h2', {}, entry.name), h('span.faint', {}, (kinds.length ? kinds : [item.kind]).join(' / ')), h('span.gap', {}),
      kind === 'body' && iconButton('fit', 'Fit this body', 'shift+f', () => fit(entry.index)),
      kind === 'body' && iconButton('follow', 'Follow it', 'w', follow),
      iconButton('close', 'Select nothing', 'esc', () => view.set({ selection: null }))));
    if (item.where) panel.append(h('div.faint.where', { title: 'Where it was added' }, item.where));
    const tied = kind === 'body' ? model.connectors.filter((one) => one.bodies.includes(entry.index)) : entry.bodies.map((i) => model.bodies[i]);
    if (tied.length) {
      panel.append(h('p.ties', {}, kind === 'body' ? 'tied by ' : 'ties ',
        tied.slice(0, 12).flatMap((one, i) => [i ? ', ' : '', link(kind === 'body' ? 'connector' : 'body', one)]),
        tied.length > 12 ? ` and ${tied.length - 12} more` : ''));
    }
    const own = kind === 'body' ? bodyRows(model, entry) : connectorRows(model, entry);
    const rows = [...own, ...recordedRows(model, kind, entry, new Set(own.map((row) => row.channel)))];
    const body = h('tbody', {});
    let section = '';
    for (const row of rows) {
      if (row.section !== section) body.append(h('tr.section', {}, h('th', { colspan: runs.length + 3, scope: 'rowgroup' }, row.section)));
      section = row.section;
      const label = row.label.startsWith(`${entry.name}`) ? row.label.slice(entry.name.length).replace(/^[:. _]+/, '') || row.label : row.label;
      body.append(h('tr', {}, h('th', { scope: 'row', title: row.label }, label),
        runs.map((r) => {
          const node = h('td', {});
          cells.push({ node, row, r });
          return node;
        }),
        h('td.unit', {}, row.unit),
        h('td.act', {}, row.channel && h('button.mini', { type: 'button', title: `Chart ${row.channel.name}`, 'aria-label': `Chart ${row.channel.name}`, onclick: () => chart(row.channel) }, icon('plus')))));
    }
    const head = runs.length > 1 && h('thead', {}, h('tr', {}, h('th', {}),
      runs.map((r) => h('th', { scope: 'col' }, lineSample(seriesColour(r, view.theme), runDash(r), 20), ` ${model.runs[r].name}`)), h('td', {}), h('td', {})));
    panel.append(h('table.values', {}, ...[head, body].filter(Boolean)));
    if (!rows.length) panel.append(h('p.hint', {}, 'Nothing was recorded of it.'));
    tell();
  };

  view.watch(['selection', 'runs', 'theme'], build);
  view.watch(['time'], () => {
    if (!view.playing || performance.now() - last > kRedrawGap) tell();
  });
  view.watch(['playing'], tell);
  build();
  return panel;
}
