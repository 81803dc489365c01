// window.lithe: for tests in a browser, and for whoever likes the console.
import { locate, markerPose, restPoint, bodyPose, worldPoint } from './motion.js';
import { savedPage } from './save.js';

export function hooks({ model, view, clock, stage, charts, live }) {
  /** A point in world axes at the present time: of a marker, a mesh node (index, of body), or a body's frame. */
  const point = (run_index, kind, index, body_index) => {
    const run = model.runs[run_index];
    const at = locate(run.times, view.time);
    if (kind === 'marker') return markerPose(run, run.markers[index], at).position;
    if (kind === 'body') return bodyPose(run.bodies[index], at).position;
    const body = run.bodies[body_index ?? run.bodies.findIndex((one) => one.mesh)];
    return worldPoint(body, at, restPoint(body.mesh, index), index);
  };
  return {
    model,
    runs: model.runs,
    view,
    stage,
    charts: charts.charts,
    savedPage: () => live && savedPage(live.page, live.run),
    setTime: (t) => {
      view.set({ playing: false });
      clock.goTo(t);
      stage?.draw();
    },
    time: () => view.time,
    point,
    project: (run, kind, index, body) => stage?.toPixel(point(run, kind, index, body)) ?? null,
    select: (kind, index) => view.set({ selection: kind ? { kind, index } : null }),
    selected: () => view.selection && { ...view.selection, name: model.entry(view.selection).name },
    pick: (x, y) => stage?.pick(x, y) ?? null,
    drawn: () => ({ triangles: stage?.renderer.info.render.triangles ?? 0, calls: stage?.renderer.info.render.calls ?? 0 }),
    channel: (name, run = 0) => model.channels.find((channel) => channel.name === name)?.series(run) ?? null,
    /** Column-major matrices and the canvas' rectangle: enough to project points without this page's own code. */
    camera: () => {
      const { camera } = stage.eye;
      camera.updateMatrixWorld();
      const { left, top, width, height } = stage.canvas.getBoundingClientRect();
      return { view: camera.matrixWorldInverse.toArray(), projection: camera.projectionMatrix.toArray(), left, top, width, height };
    },
  };
}
