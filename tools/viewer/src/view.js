// What is shown at present: one plain state, and those who watch parts of it.

/** set({time: 1}) changes values and tells whoever watches one of them, once. */
export class View {
  #watchers = [];

  constructor(initial) {
    Object.assign(this, initial);
  }

  watch(keys, tell) {
    this.#watchers.push({ keys: new Set(keys), tell });
  }

  set(changes) {
    const changed = Object.keys(changes).filter((key) => this[key] !== changes[key]);
    Object.assign(this, changes);
    for (const { keys, tell } of this.#watchers) {
      if (changed.some((key) => keys.has(key))) tell(this);
    }
  }
}

/** The state in which a page opens. */
export function initialView(model) {
  const any_stress = model.runs.some((run) => run.bodies.some((body) => body.mesh?.stress));
  const many = model.runs.length > 1;
  const deforms = (run) => run.bodies.some((body) => body.mesh?.modes.length);
  const some_deform = model.runs.some(deforms) && !model.runs.every(deforms);
  return new View({
    time: model.start,
    frames: model.runs[0].frames,
    live: null, // of a run that goes on: {state, speed, problem, inputs}
    head: true, // its newest state is shown as it comes
    playing: false,
    speed: 1,
    loop: true,
    selection: null, // {kind: 'body' | 'connector', index} into the model
    theme: matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light',
    runs: model.runs.map((run, i) => ({ shown: true, solid: !many || (some_deform ? deforms(run) : i === 0) })),
    colouring: any_stress ? 'von Mises' : 'plain',
    bands: false,
    whole_range: true,
    magnification: 1,
    arrow_scale: 1,
    glyph_scale: 1,
    show: {
      grid: true,
      edges: true,
      elements: true,
      joints: true,
      markers: false,
      traces: true,
      reactions: false,
      moments: false,
      contacts: true,
      contact_shapes: false,
      labels: false,
    },
    follow: null, // index of a body of the model
    mode: null, // {run, body, mode, amplitude}
    theme_chosen: false,
  });
}
