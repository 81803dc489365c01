// One chart: channels of one unit over time, each variant in its dash; or the variants' difference.
import uPlot from 'uplot';
import { clear, h, icon, lineSample } from '../dom.js';
import { number } from '../format.js';
import { difference } from '../channels.js';
import { kDashes, runDash, seriesColour } from '../palette.js';

export class Chart {
  /** `dock`: {goTo(t), zoomed(chart, range), remove(chart), add(chart)}. */
  constructor(model, view, dock, channels, differs = false) {
    Object.assign(this, { model, view, dock, channels: [...channels], differs });
    this.legend = h('div.chart-legend', {});
    this.frame = h('div.plot', { tabindex: 0, role: 'img', onkeydown: (event) => this.#key(event) });
    this.element = h('article.chart', { 'aria-label': 'Chart' }, this.legend, this.frame);
    this.now = h('div.now', { 'aria-hidden': 'true' });
    new ResizeObserver(() => this.resize()).observe(this.frame);
    this.build();
  }

  get unit() {
    return this.channels[0]?.unit ?? '';
  }

  /** Curves: {channel, run, label, times, values, colour, dash}. */
  #curves() {
    const { view, model, channels } = this;
    const shown = model.runs.map((_, r) => r).filter((r) => view.runs[r].shown);
    const many_runs = model.runs.length > 1;
    if (this.differs) {
      this.largest = [];
      return channels.flatMap((channel, c) => {
        const have = shown.filter((r) => channel.series(r));
        return have.slice(1).map((r, k) => {
          const d = difference(channel.series(have[0]), channel.series(r));
          const label = `${channel.name}: ${model.runs[r].name} − ${model.runs[have[0]].name}`;
          if (d.largest) this.largest.push({ label, ...d.largest });
          return { channel, label, times: d.times, values: d.values, colour: seriesColour(c + k + 2, view.theme), dash: kDashes[k % kDashes.length], largest: d.largest };
        });
      });
    }
    return channels.flatMap((channel, c) => shown.filter((r) => channel.series(r)).map((r) => ({
      channel,
      run: r,
      label: many_runs ? `${channel.name}: ${model.runs[r].name}` : channel.name,
      ...channel.series(r),
      colour: seriesColour(channels.length === 1 && many_runs ? r : c, view.theme),
      dash: runDash(r),
    })));
  }

  build() {
    const zoom = this.plot && this.zoom;
    this.plot?.destroy();
    this.curves = this.#curves();
    this.#buildLegend();
    this.plot = null;
    const { clientWidth: width, clientHeight: height } = this.frame;
    if (!width || height < 40) return;
    const css = getComputedStyle(document.documentElement);
    const ink = css.getPropertyValue('--faint').trim();
    const line = css.getPropertyValue('--grid-line').trim();
    const axis = { stroke: ink, grid: { stroke: line, width: 1 }, ticks: { stroke: line, width: 1, size: 4 }, font: '11px system-ui, sans-serif' };
    const options = {
      width,
      height,
      legend: { show: false },
      padding: [8, 12, 0, 0],
      cursor: { drag: { x: true, y: false, dist: 6 }, points: { size: 6 }, y: false },
      scales: { x: { time: false, range: (_, low, high) => [low, high] } },
      axes: [
        { ...axis, size: 26, space: 60, values: (_, ticks) => ticks.map((t) => String(Number(t.toPrecision(6)))) },
        { ...axis, size: 58, space: 26, values: (_, ticks) => ticks.map((v) => shortNumber(v, ticks)) },
      ],
      series: [{}, ...this.curves.map(({ label, colour, dash }) => ({ label, stroke: colour, width: 1.6, dash, spanGaps: true, points: { show: false } }))],
      hooks: {
        setScale: [(plot, key) => { if (key === 'x') this.#zoomed(plot); }],
        setSize: [() => this.tell()],
        draw: [() => this.tell()],
      },
    };
    this.plot = new uPlot(options, this.#data(), this.frame);
    this.plot.over.append(this.now);
    this.#listen();
    if (zoom) this.show(zoom);
    this.tell();
  }

  #data() {
    const tables = this.curves.map(({ times, values }) => [Array.from(times), Array.from(values, (value) => (Number.isFinite(value) ? value : null))]);
    return tables.length ? uPlot.join(tables) : [[this.model.start, this.model.end]];
  }

  /** The runs have more frames. */
  grow() {
    if (!this.plot) return this.build();
    this.curves = this.#curves();
    this.quiet = true;
    this.plot.setData(this.#data(), !this.zoom);
    queueMicrotask(() => { this.quiet = false; });
    this.tell();
  }

  #listen() {
    const { over } = this.plot;
    let down = null;
    over.addEventListener('pointerdown', (event) => { down = event.clientX; });
    over.addEventListener('click', (event) => {
      if (down === null || Math.abs(event.clientX - down) > 4) return;
      const box = over.getBoundingClientRect();
      this.dock.goTo(this.plot.posToVal(event.clientX - box.left, 'x'));
    });
    over.addEventListener('dblclick', () => this.dock.zoomed(this, null));
  }

  #zoomed(plot) {
    const { min, max } = plot.scales.x;
    const all = [plot.data[0][0], plot.data[0][plot.data[0].length - 1]];
    const zoom = min > all[0] || max < all[1] ? [min, max] : null;
    if (this.quiet || String(zoom) === String(this.zoom ?? null)) return;
    this.zoom = zoom;
    this.dock.zoomed(this, zoom);
  }

  /** z and shift+Z zoom about the present time, 0 shows all. */
  #key(event) {
    const factor = { z: 0.5, Z: 2, 0: Infinity }[event.key];
    if (!factor || !this.plot || event.ctrlKey || event.metaKey || event.altKey) return;
    event.stopPropagation();
    const { min, max } = this.plot.scales.x;
    const [x] = this.plot.data;
    const half = 0.5 * factor * (max - min);
    const range = [Math.max(x[0], this.view.time - half), Math.min(x[x.length - 1], this.view.time + half)];
    const all = range[0] <= x[0] && range[1] >= x[x.length - 1];
    if (!all) this.show(range);
    this.dock.zoomed(this, all ? null : range);
  }

  /** Shows a stretch of time, or all of it. */
  show(range) {
    if (!this.plot) return;
    this.zoom = range;
    this.quiet = true;
    const x = this.plot.data[0];
    this.plot.setScale('x', range ? { min: range[0], max: range[1] } : { min: x[0], max: x[x.length - 1] });
    // uPlot settles its scales in a microtask.
    queueMicrotask(() => { this.quiet = false; });
  }

  #buildLegend() {
    const { model, channels, dock } = this;
    const focused = this.legend.contains(document.activeElement) && document.activeElement.getAttribute('aria-label');
    const button = (name, label, onclick) => h('button.mini', { type: 'button', title: label, 'aria-label': label, onclick }, icon(name));
    clear(this.legend);
    this.values = [];
    for (const curve of this.curves) {
      const value = h('span.number', {});
      this.values.push(value);
      this.legend.append(h('span.curve', { title: curve.label }, lineSample(curve.colour, curve.dash, 22), h('span.name', {}, curve.label), value));
    }
    if (this.differs) {
      for (const { value, time } of this.largest ?? []) {
        this.legend.append(h('span.largest', {}, `largest |Δ| ${number(Math.abs(value), 4)} ${this.unit} at ${number(time, 4)} s`));
      }
    }
    if (!this.curves.length) this.legend.append(h('span.faint', {}, channels.length ? `${channels.map((c) => c.name).join(', ')}: not in the shown variants` : 'No channel yet'));
    const tools = h('span.chart-tools', {});
    if (model.runs.length > 1) {
      tools.append(h('button.mini.delta', {
        type: 'button', 'aria-pressed': String(this.differs), title: 'Difference of the variants', 'aria-label': 'Difference of the variants',
        onclick: () => { this.differs = !this.differs; this.build(); },
      }, 'Δ'));
    }
    tools.append(button('plus', 'Add a channel to this chart', () => dock.add(this)), button('close', 'Remove this chart', () => dock.remove(this)));
    this.legend.append(tools);
    if (focused) [...tools.children].find((one) => one.getAttribute('aria-label') === focused)?.focus();
    const told = `Chart of ${this.curves.map((curve) => curve.label).join(', ') || 'nothing'}`;
    this.element.setAttribute('aria-label', told);
    this.frame.setAttribute('aria-label', `${told}; z, shift Z and 0 zoom its time`);
  }

  /** Moves the line of the present time and tells the values there. */
  tell() {
    const t = this.view.time;
    this.curves.forEach((curve, i) => {
      this.values[i].textContent = `${number(curve.run === undefined ? valueAt(curve, t) : curve.channel.value(curve.run, t), 4)} ${this.unit}`;
    });
    if (!this.plot) return;
    const x = this.plot.valToPos(t, 'x');
    this.now.hidden = !(x >= 0 && x <= this.plot.over.clientWidth);
    this.now.style.transform = `translateX(${x}px)`;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.frame;
    if (!this.plot) this.build();
    else if (width && height >= 40) this.plot.setSize({ width, height });
  }
}

function valueAt({ times, values }, t) {
  if (!times.length || t < times[0] || t > times[times.length - 1]) return null;
  let low = 0;
  let high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  if (high === low || times[high] === times[low]) return values[low];
  return values[low] + ((values[high] - values[low]) * (t - times[low])) / (times[high] - times[low]);
}

/** Axis numbers: all of a kind, without needless digits. */
function shortNumber(value, ticks) {
  const size = Math.max(...ticks.map(Math.abs));
  if (value === 0) return '0';
  const text = size >= 1e5 || size < 1e-3 ? value.toExponential(1).replace('.0e', 'e').replace('e+', 'e') : String(Number(value.toPrecision(5)));
  return text.replace(/-/g, '−');
}
