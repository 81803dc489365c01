// The dock of charts under the scene.
import { h, icon, throttled } from '../dom.js';
import { Chart } from './chart.js';

const kMostCharts = 6;
const kMeanwhile = 200; // ms between drawings of a run that goes on

/** What a page opens with: the first recorded channel, and with variants its difference; else one of another unit. */
function firstCharts(model) {
  const first = model.recorded.find((channel) => channel.group === 'recorded') ?? model.channels[0];
  if (!first) return [];
  if (model.runs.length > 1 && model.runs.every((_, r) => first.series(r))) return [[first, false], [first, true]];
  const groups = ['recorded', 'energy', 'reaction', 'motion'];
  const second = model.channels
    .filter((one) => one !== first && one.unit !== first.unit)
    .sort((a, b) => (groups.indexOf(a.group) + 9) % 9 - ((groups.indexOf(b.group) + 9) % 9))[0];
  return second ? [[first, false], [second, false]] : [[first, false]];
}

export function chartDock(model, view, clock, picker) {
  const charts = [];
  const row = h('div.charts-row', {});
  const dock = {
    goTo: (t) => { view.set({ playing: false }); clock.goTo(t); },
    zoomed: (from, range) => charts.forEach((chart) => { if (chart !== from || range === null) chart.show(range); }),
    remove: (chart) => {
      drop(chart);
      add.focus({ preventScroll: true }); // the pressed button has gone
    },
    add: (chart) => picker.open_for((channel) => show(channel, chart)),
  };
  const drop = (chart) => {
    charts.splice(charts.indexOf(chart), 1);
    chart.plot?.destroy();
    chart.element.remove();
  };
  /** Into the given chart, or one of the same unit, or a new one. */
  const show = (channel, chart = null) => {
    const home = chart && chart.unit === channel.unit ? chart : chart ? null : charts.find((one) => !one.differs && one.unit === channel.unit);
    if (home) {
      if (!home.channels.includes(channel)) home.channels.push(channel);
      home.build();
      home.element.scrollIntoView({ block: 'nearest', inline: 'nearest' });
    } else {
      append(channel, false);
    }
  };
  const append = (channel, differs) => {
    if (charts.length >= kMostCharts) drop(charts[0]);
    const chart = new Chart(model, view, dock, [channel], differs);
    charts.push(chart);
    row.append(chart.element);
    chart.element.scrollIntoView({ block: 'nearest', inline: 'nearest' });
  };
  const pick = () => picker.open_for((channel) => show(channel));
  for (const [channel, differs] of firstCharts(model)) append(channel, differs);
  view.watch(['time'], () => charts.forEach((chart) => chart.tell()));
  view.watch(['frames'], throttled(kMeanwhile, () => charts.forEach((chart) => chart.grow())));
  view.watch(['runs', 'theme'], () => charts.forEach((chart) => chart.build()));
  const add = h('button.add-chart', { type: 'button', title: 'Add a channel (a)', 'aria-label': 'Add a channel (a)', onclick: pick }, icon('plus'), h('span', {}, 'Channel'));
  return { element: h('section.charts', { 'aria-label': 'Charts' }, row, add), show, pick, charts };
}
