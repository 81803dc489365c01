// The runs as one thing: bodies, connectors and channels of the same name belong together.
import { PageError } from './data.js';
import { derivedChannels, Channel } from './channels.js';

/** Names made unique within a run, so that they can be matched: the second 'pin' is 'pin #2'. */
function keys(items) {
  const seen = new Map();
  return items.map((item) => {
    const count = (seen.get(item.name) ?? 0) + 1;
    seen.set(item.name, count);
    return count === 1 ? item.name : `${item.name} #${count}`;
  });
}

/** One entry a name: {name, index, of: index in every run, or -1}. The first run's indices stay as they are. */
function merged(runs, list) {
  const entries = new Map();
  runs.forEach((run, r) => {
    keys(run[list]).forEach((key, i) => {
      if (!entries.has(key)) entries.set(key, { name: key, index: entries.size, of: runs.map(() => -1) });
      entries.get(key).of[r] = i;
    });
  });
  return [...entries.values()];
}

/** The entries by their index in a run. */
function byIndex(entries, run) {
  const found = [];
  for (const entry of entries) if (entry.of[run] >= 0) found[entry.of[run]] = entry;
  return found;
}

export class Model {
  constructor(page) {
    this.title = page.title;
    this.made_by = page.made_by;
    this.findings = page.findings;
    this.runs = page.runs;
    this.start = Math.min(...this.runs.map((run) => run.times[0]));
    this.end = this.#last();
    this.bodies = merged(this.runs, 'bodies');
    this.connectors = merged(this.runs, 'connectors');
    for (const list of ['bodies', 'connectors']) {
      for (const entry of this[list]) {
        const run = entry.of.findIndex((i) => i >= 0);
        Object.assign(entry, { item: this.runs[run][list][entry.of[run]], run });
      }
    }
    this.entries = Object.fromEntries(['bodies', 'connectors'].map((list) => [list, this.runs.map((_, r) => byIndex(this[list], r))]));
    this.connectors.forEach((entry) => {
      const ends = entry.item.bodies.map((i) => this.bodyEntry(entry.run, i)?.index ?? -1);
      if (ends.includes(-1)) throw new PageError(`connector '${entry.name}' ties a body that is not in the run.`, 'write the page again.');
      entry.bodies = [...new Set(ends)];
    });
    this.recorded = merged(this.runs, 'channels').map((entry) => Channel.recorded(this, entry));
    this.channels = [...this.recorded, ...derivedChannels(this)];
    this.notices = this.#notices();
  }

  #last() {
    return Math.max(...this.runs.map((run) => run.times[run.frames - 1]));
  }

  /** A run that goes on has more frames. */
  grow() {
    this.end = this.#last();
    for (const channel of this.channels) channel.grow();
  }

  /** 'body' or 'connector' and its index in the model. */
  entry(selection) {
    if (!selection) return null;
    return (selection.kind === 'body' ? this.bodies : this.connectors)[selection.index] ?? null;
  }

  bodyEntry(run, index) {
    return this.entries.bodies[run][index];
  }

  connectorEntry(run, index) {
    return this.entries.connectors[run][index];
  }

  /** The first channel that bears one of the names. */
  channel(...names) {
    return this.channels.find((channel) => names.includes(channel.name));
  }

  /** Motion that is no number: said, never hidden. */
  #notices() {
    const notices = [];
    for (const run of this.runs) {
      for (const body of run.bodies) {
        const bad = [body.position, body.rotation, body.mesh?.coordinates].map((values) =>
          values ? values.findIndex((value) => !Number.isFinite(value)) / (values.length / run.frames) : -1);
        const frame = Math.min(...bad.filter((at) => at >= 0).map(Math.floor));
        if (Number.isFinite(frame)) {
          notices.push(`Run '${run.name}': '${body.name}' moves to no number from ${run.times[frame]} s on.`);
        }
      }
    }
    return notices;
  }
}
