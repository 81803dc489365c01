// The arrays of a run that goes on: each state adds a row to all of them.

/** An array that grows; `values` is all of it so far. */
class Growing {
  constructor(values) {
    this.store = values;
    this.length = values.length;
  }

  push(values) {
    const length = this.length + values.length;
    if (length > this.store.length) {
      const store = new this.store.constructor(Math.max(length, 2 * this.store.length));
      store.set(this.values);
      this.store = store;
    }
    this.store.set(values, this.length);
    this.length = length;
  }

  /** Every second row stays. */
  thin(width) {
    const rows = Math.ceil(this.length / width / 2);
    for (let i = 0; i < rows; ++i) this.store.copyWithin(i * width, 2 * i * width, (2 * i + 1) * width);
    this.length = rows * width;
  }

  get values() {
    return this.store.subarray(0, this.length);
  }
}

const kContactWidth = 8; // of a point in contact: state, connector, point, force

export class GrowingRun {
  /** `refs`: what in the page's JSON each array was read from; those of rows tell row and width. */
  constructor(run, refs) {
    this.run = run;
    this.frames = run.frames;
    this.parts = []; // {owner, key, ref, growing} of rows
    this.contacts = run.contacts && Object.fromEntries(Object.entries(run.contacts).map(([key, values]) => [key, new Growing(values)]));
    this.contact_refs = run.contacts && Object.fromEntries(Object.entries(run.contacts).map(([key, values]) => [key, refs.get(values)]));
    this.#find(run, refs);
  }

  #find(owner, refs) {
    for (const [key, value] of Object.entries(owner)) {
      if (ArrayBuffer.isView(value)) {
        const ref = refs.get(value);
        if (ref?.row === undefined) continue;
        this.parts.push({ owner, key, ref, growing: new Growing(value) });
      } else if (value && typeof value === 'object') {
        this.#find(value, refs);
      }
    }
  }

  /** A state: its row, then its points in contact. */
  push(numbers, width) {
    for (const { ref, growing } of this.parts) growing.push(numbers.subarray(ref.row, ref.row + ref.width));
    ++this.frames;
    if (!this.contacts) return;
    const { first, points, forces, pair } = this.contacts;
    for (let at = width; at < numbers.length; at += kContactWidth) {
      pair.push(numbers.subarray(at + 1, at + 2));
      points.push(numbers.subarray(at + 2, at + 5));
      forces.push(numbers.subarray(at + 5, at + 8));
    }
    first.push([pair.length]);
  }

  thin() {
    for (const { ref, growing } of this.parts) growing.thin(ref.width);
    if (this.contacts) this.#thinContacts();
    this.frames = Math.ceil(this.frames / 2);
  }

  #thinContacts() {
    const old = Object.fromEntries(Object.entries(this.contacts).map(([key, growing]) => [key, growing.values.slice()]));
    const { first, points, forces, pair } = this.contacts;
    first.length = 1;
    points.length = forces.length = pair.length = 0;
    for (let frame = 0; frame < this.frames; frame += 2) {
      const [begin, end] = old.first.subarray(frame, frame + 2);
      pair.push(old.pair.subarray(begin, end));
      points.push(old.points.subarray(3 * begin, 3 * end));
      forces.push(old.forces.subarray(3 * begin, 3 * end));
      first.push([pair.length]);
    }
  }

  /** Hands out what has grown. */
  publish() {
    this.run.frames = this.frames;
    for (const { owner, key, growing } of this.parts) owner[key] = growing.values;
    for (const [key, growing] of Object.entries(this.contacts ?? {})) this.run.contacts[key] = growing.values;
  }

  /** The arrays as they are, by their refs. */
  grown() {
    const arrays = new Map(this.parts.map(({ ref, growing }) => [ref, growing.values]));
    for (const [key, growing] of Object.entries(this.contacts ?? {})) arrays.set(this.contact_refs[key], growing.values);
    return arrays;
  }
}
