// A run that goes on in a program on this machine: its states as they come, and what the page asks of it. The messages
// are told in tools/viewer/README.md.
import { GrowingRun } from './growing.js';

const kFrame = 1;
const kThinned = 2;
const kStatus = 3;
const kTries = 5; // to find the program again

const pause = (ms) => new Promise((done) => { setTimeout(done, ms); });

export class Live {
  #wanted = new Map(); // commands that wait for the one under way: the newest of a kind
  #sending = false;
  #pending = 0;

  constructor(page, model, view) {
    Object.assign(this, { page, model, view });
    this.run = new GrowingRun(page.runs[0], page.refs);
    this.thinned = null; // how often every second state was left out; the program knows
    view.set({ live: { state: 'connecting', speed: 0, problem: '', inputs: [] } });
    this.over = this.#follow();
  }

  /** {do: 'run' | 'pause' | 'step' | 'stop'}, {speed}, {input, value}. */
  send(command) {
    this.#wanted.set(command.input ?? (command.do ? `do ${command.do}` : 'speed'), command);
    if (!this.#sending) this.#sendAll();
  }

  async #sendAll() {
    this.#sending = true;
    try {
      while (this.#wanted.size) {
        const [[kind, command]] = this.#wanted;
        this.#wanted.delete(kind);
        const answer = await fetch('command', { method: 'POST', body: JSON.stringify(command) });
        if (!answer.ok) this.#tell({ problem: await answer.text() });
      }
    } catch {
      this.#wanted.clear(); // the program has gone: #follow() tells it
    }
    this.#sending = false;
  }

  #tell(changes) {
    this.view.set({ live: { ...this.view.live, ...changes } });
  }

  async #follow() {
    for (let tries = 0; tries < kTries; ++tries) {
      const frames = this.run.frames;
      try {
        const known = this.thinned === null ? '' : `&thinned=${this.thinned}`;
        const answer = await fetch(`frames?from=${frames}${known}`);
        if (answer.ok) await this.#read(answer.body.getReader());
      } catch {
        // Tried again below.
      }
      if (this.view.live.state === 'ended') return;
      if (this.run.frames > frames) tries = 0;
      await pause(500);
    }
    this.#tell({ state: 'lost', problem: '' });
  }

  async #read(reader) {
    let bytes = new Uint8Array(0);
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const both = new Uint8Array(bytes.length + value.length);
      both.set(bytes);
      both.set(value, bytes.length);
      bytes = both.subarray(this.#take(both));
    }
  }

  /** All whole messages; returns how many bytes they have. */
  #take(bytes) {
    let at = 0;
    while (bytes.length - at >= 8) {
      const head = new DataView(bytes.buffer, bytes.byteOffset + at, 8);
      const end = at + 8 + head.getUint32(4, true);
      if (end > bytes.length) break;
      this.#takeMessage(head.getUint32(0, true), bytes.slice(at + 8, end));
      at = end;
    }
    return at;
  }

  #takeMessage(kind, bytes) {
    if (kind === kFrame) this.run.push(new Float64Array(bytes.buffer), this.page.live.width);
    if (kind === kThinned) {
      this.run.thin();
      ++this.thinned;
    }
    if (kind === kStatus) {
      const { thinned, ...status } = JSON.parse(new TextDecoder().decode(bytes));
      this.thinned = thinned;
      this.#tell(status);
    }
    // Drawn once a picture, however many have come.
    else if (!this.#pending) this.#pending = requestAnimationFrame(() => this.#publish());
  }

  #publish() {
    this.#pending = 0;
    const { run, model, view } = this;
    run.publish();
    model.grow();
    view.set({ frames: run.frames, ...(view.head ? { time: model.end } : {}) });
  }
}
