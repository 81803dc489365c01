// Quantities over time: those that the run recorded, and those that follow from the motion in the page.
import { interpolate, locate } from './motion.js';

export class Channel {
  #cache = [];

  /** `make(run)` returns the values at the run's times, or null where the run has no such quantity. */
  constructor({ name, unit, group, subject, runs, make }) {
    Object.assign(this, { name, unit, group, subject, runs, make });
    this.key = `${group}/${name}`;
  }

  static recorded(model, entry) {
    const run = entry.of.findIndex((i) => i >= 0);
    const first = model.runs[run].channels[entry.of[run]];
    let subject = null;
    if (first.body !== null) subject = { kind: 'body', index: model.bodyEntry(run, first.body)?.index };
    if (first.connector !== null) subject = { kind: 'connector', index: model.connectorEntry(run, first.connector)?.index };
    return new Channel({
      name: entry.name,
      unit: first.unit,
      group: first.group,
      subject,
      runs: model.runs,
      make: (r) => model.runs[r].channels[entry.of[r]]?.values ?? null,
    });
  }

  /** The runs have more frames than before. */
  grow() {
    this.#cache = [];
  }

  /** {times, values} of a run, or null. */
  series(run) {
    if (this.#cache[run] === undefined) {
      const values = this.make(run);
      this.#cache[run] = values ? { times: this.runs[run].times, values } : null;
    }
    return this.#cache[run];
  }

  /** The value at a time, linear between frames; null outside of the run. */
  value(run, t) {
    const series = this.series(run);
    if (!series) return null;
    const { times, values } = series;
    if (t < times[0] || t > times[times.length - 1]) return null;
    return interpolate(values, locate(times, t));
  }
}

const column = (values, stride, c) =>
  values && Float64Array.from({ length: values.length / stride }, (_, i) => values[i * stride + c]);
const size = (values) =>
  values && Float64Array.from({ length: values.length / 3 }, (_, i) => Math.hypot(...values.subarray(i * 3, i * 3 + 3)));

/** Positions, modal coordinates and reactions as channels; their values are made when first asked for. */
export function derivedChannels(model) {
  const channels = [];
  const recorded = new Set(model.recorded.map((channel) => channel.name));
  /** `as`: the name under which the engine records the same. */
  const add = (name, as, unit, group, subject, make) => {
    if (!recorded.has(as)) channels.push(new Channel({ name, unit, group, subject, runs: model.runs, make }));
  };

  for (const entry of model.bodies) {
    const subject = { kind: 'body', index: entry.index };
    const body = (r) => model.runs[r].bodies[entry.of[r]];
    if (entry.of.some((_, r) => body(r)?.position)) {
      ['x', 'y', 'z'].forEach((axis, c) => {
        add(`${entry.name}: ${axis}`, `${entry.name}_p_${axis}`, 'm', 'motion', subject, (r) => column(body(r)?.position, 3, c));
      });
    }
    const modes = Math.max(0, ...model.runs.map((_, r) => body(r)?.mesh?.modes.length ?? 0));
    for (let k = 0; k < modes; ++k) {
      const name = `${entry.name}: η${k + 1}`;
      add(name, `${entry.name}_eta_${k + 1}`, '', 'modal', subject, (r) => {
        const mesh = body(r)?.mesh;
        return mesh?.coordinates && k < mesh.modes.length ? column(mesh.coordinates, mesh.modes.length, k) : null;
      });
    }
  }
  for (const entry of model.connectors) {
    const subject = { kind: 'connector', index: entry.index };
    const reaction = (r) => model.runs[r].connectors[entry.of[r]]?.reaction;
    const kinds = [['force', 'N', 'F'], ['moment', 'N m', 'M']];
    for (const [field, unit, letter] of kinds) {
      if (!entry.of.some((_, r) => reaction(r)?.[field])) continue;
      add(`${entry.name}: |${letter}|`, null, unit, 'reaction', subject, (r) => size(reaction(r)?.[field]));
      ['x', 'y', 'z'].forEach((axis, c) => {
        add(`${entry.name}: ${letter}${axis}`, `${entry.name}_${field}_${axis}`, unit, 'reaction', subject, (r) => column(reaction(r)?.[field], 3, c));
      });
    }
  }
  return channels;
}

/** b − a at all times of either that both cover, each linear between its own; and where it is largest. */
export function difference(a, b) {
  const first = Math.max(a.times[0], b.times[0]);
  const last = Math.min(a.times[a.times.length - 1], b.times[b.times.length - 1]);
  const times = [...new Set([...a.times, ...b.times])].filter((t) => t >= first && t <= last).sort((p, q) => p - q);
  const values = times.map((t) => interpolate(b.values, locate(b.times, t)) - interpolate(a.values, locate(a.times, t)));
  let at = -1;
  values.forEach((value, i) => {
    if (Number.isFinite(value) && (at < 0 || Math.abs(value) > Math.abs(values[at]))) at = i;
  });
  return { times, values, largest: at < 0 ? null : { value: values[at], time: times[at] } };
}
