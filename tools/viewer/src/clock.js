// Playing: the time goes on with the wall's clock times the speed.

export const kSpeeds = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20];

export class Clock {
  constructor(model, view) {
    this.model = model;
    this.view = view;
    view.watch(['playing'], () => view.playing && this.#start());
  }

  #start() {
    const { view, model } = this;
    view.set(view.time >= model.end ? { time: model.start, head: false } : { head: false });
    let before = performance.now();
    const tick = (now) => {
      if (!view.playing) return;
      let time = view.time + (Math.max(0, now - before) / 1000) * view.speed;
      before = now;
      if (time > model.end) {
        const span = model.end - model.start;
        if (view.loop && span > 0) time = model.start + ((time - model.start) % span);
        else view.set({ playing: false });
      }
      view.set({ time: Math.min(time, model.end) });
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  toggle() {
    this.view.set({ playing: !this.view.playing });
  }

  goTo(t) {
    this.view.set({ head: t >= this.model.end, time: Math.min(this.model.end, Math.max(this.model.start, t)) });
  }

  /** Frames of the first shown run, forth or back. */
  step(count) {
    const shown = this.view.runs.findIndex((run) => run.shown);
    const { times } = this.model.runs[Math.max(0, shown)];
    const tiny = 1e-9 * Math.max(1e-9, this.model.end - this.model.start);
    let i = times.findIndex((t) => t > this.view.time + tiny);
    i = i < 0 ? times.length : i; // the first frame ahead
    const on_frame = i > 0 && Math.abs(times[i - 1] - this.view.time) <= tiny;
    const target = count > 0 ? i - 1 + count : i - (on_frame ? 1 : 0) + count;
    this.view.set({ playing: false });
    this.goTo(times[Math.min(times.length - 1, Math.max(0, target))]);
  }

  faster(steps) {
    const near = kSpeeds.reduce((best, speed, i) => (Math.abs(Math.log(speed / this.view.speed)) < Math.abs(Math.log(kSpeeds[best] / this.view.speed)) ? i : best), 0);
    this.view.set({ speed: kSpeeds[Math.min(kSpeeds.length - 1, Math.max(0, near + steps))] });
  }
}
