// The Display tab: what each switch draws, the deformation's factor, the legend against the recorded arrays.
import { settle } from './browser.mjs';

/** What a picture consists of with the box unchecked and checked; the box is left as it was. */
const counts = (box) => box.evaluate((one) => {
  const { stage } = window.lithe;
  const was = one.checked;
  const found = [false, true].map((on) => {
    if (one.checked !== on) one.click();
    stage.draw();
    const { triangles, lines } = stage.renderer.info.render;
    return { triangles, lines, names: document.querySelectorAll('.labels span:not([hidden])').length };
  });
  if (one.checked !== was) one.click();
  return found;
});

export async function checkDisplay(page, check) {
  await page.locator('#tab-Display').click();
  const has = await page.evaluate(() => {
    const { lithe } = window;
    lithe.view.set({ selection: null });
    lithe.setTime(lithe.model.start + 0.52 * (lithe.model.end - lithe.model.start));
    const some = (what) => lithe.runs.some(what);
    const { show } = lithe.view;
    lithe.view.set({ show: { ...show, reactions: true, moments: true, contacts: true, contact_shapes: true } });
    const arrows = (kind) => lithe.stage.update() || lithe.stage.runs.some(({ connectors }) => connectors[kind].count > 0);
    const found = {
      // Contact shapes are drawn as bodies where these have nothing else.
      Edges: some(({ bodies }) => bodies.some(({ shapes, mesh }) => mesh || shapes.some(({ kind, role }) => /box|cylinder|cone|half_space/.test(kind) &&
        (role !== 'contact' || shapes.every((one) => one.role === 'contact'))))),
      Elements: some(({ bodies }) => bodies.some(({ mesh }) => mesh?.edges)),
      'Joints and forces': some(({ connectors }) => connectors.some(({ role, markers }) => role !== 'contact' && markers.length)),
      Markers: some(({ markers }) => markers.length),
      Traces: some(({ traces }) => traces.length),
      'Reaction forces': arrows('forces'),
      'Reaction moments': arrows('moments'),
      'Contact forces': arrows('contacts'),
      'Contact shapes': lithe.stage.runs.some(({ bodies }) => bodies.spares.length > 0),
      Names: true,
      Grid: true,
    };
    lithe.view.set({ show });
    return found;
  });
  const kinds = { Edges: 'lines', Elements: 'lines', Markers: 'lines', 'Contact shapes': 'lines', Grid: 'lines', Names: 'names' };
  const wrong = [];
  for (const [name, there] of Object.entries(has)) {
    const box = page.locator('.display fieldset', { hasText: 'Shown' }).getByLabel(name);
    const [off, on] = await counts(box);
    const kind = kinds[name] ?? 'triangles';
    if (there ? !(on[kind] > off[kind]) : on[kind] !== off[kind]) wrong.push(`${name}: ${off[kind]} and ${on[kind]} ${kind}`);
  }
  const drawn = Object.entries(has).filter(([, there]) => there).map(([name]) => name.toLowerCase());
  check(`the switches draw ${drawn.join(', ')}`, wrong.length === 0, wrong.join('; '));
}

/** Meshes of a run with their displacements at a frame, by their arrays alone. For the page: no name from outside. */
function inPage() {
  window.displacementsAt = (mesh, frame) => {
    const n = mesh.points.length;
    const u = new Float64Array(n);
    if (mesh.nodal) return u.map((_, c) => mesh.nodal[frame * n + c] - mesh.points[c]);
    const eta = mesh.coordinates.slice(frame * mesh.modes.length, (frame + 1) * mesh.modes.length);
    eta.forEach((factor, k) => { for (let c = 0; c < n; ++c) u[c] += factor * mesh.shapes[k * n + c]; });
    for (let p = 0; p < (mesh.pairs?.ij.length ?? 0) / 2; ++p) {
      const factor = eta[mesh.pairs.ij[2 * p]] * eta[mesh.pairs.ij[2 * p + 1]];
      for (let c = 0; c < n; ++c) u[c] += factor * mesh.pairs.shapes[p * n + c];
    }
    return u;
  };
  window.lengthsAt = (mesh, frame) => {
    const u = window.displacementsAt(mesh, frame);
    return Array.from({ length: u.length / 3 }, (_, i) => Math.hypot(u[3 * i], u[3 * i + 1], u[3 * i + 2]));
  };
  return window.lithe.runs.some((run) => run.bodies.some(({ mesh }) => mesh));
}

/** The slider at ×8 moves every drawn point by 8 times its displacement. */
export async function checkDeformation(page, check) {
  if (!(await page.evaluate(inPage))) return;
  await page.locator('#tab-Display').click();
  await page.getByLabel('Deformation').fill(String(Math.round(50 * Math.log10(8)) / 50));
  const { off, largest, factor } = await page.evaluate(() => {
    const { lithe } = window;
    let [off, largest] = [0, 0];
    for (const { run, bodies } of lithe.stage.runs) {
      for (const { mesh_body } of bodies.meshes) {
        const { mesh } = mesh_body;
        const frame = Math.floor(0.6 * run.frames);
        lithe.setTime(run.times[frame]);
        const u = window.displacementsAt(mesh, frame);
        const { array } = mesh_body.surface.geometry.attributes.position;
        for (let c = 0; c < u.length; ++c) {
          off = Math.max(off, Math.abs(array[c] - mesh.points[c] - lithe.view.magnification * u[c]));
          largest = Math.max(largest, Math.abs(lithe.view.magnification * u[c]));
        }
      }
    }
    return { off, largest, factor: lithe.view.magnification };
  });
  check(`the deformation's slider moves points by ${factor.toFixed(2)} times their displacement`, factor > 7.5 && factor < 8.5 && largest > 0 && off < 1e-5 * largest + 1e-6, `${off} of ${largest} m`);
  await page.getByLabel('Deformation').fill('0');
}

const kPrefix = { G: 1e9, M: 1e6, k: 1e3, '': 1, m: 1e-3, 'µ': 1e-6, n: 1e-9 };

/** {low, high} that the legend tells, in plain units. */
async function legend(page) {
  const text = await page.locator('.legend').getAttribute('aria-label');
  const [, low, high, prefix] = text.replaceAll('−', '-').match(/: (\S+) to (\S+) ?([GMkmµn]?)(?:m|Pa)?$/);
  return { low: Number(low) * kPrefix[prefix], high: Number(high) * kPrefix[prefix] };
}

/** The legend of displacement has the range of the arrays: at the shown time, or over the whole run. */
export async function checkLegend(page, check) {
  if (!(await page.evaluate(inPage))) return;
  const before = await page.evaluate(() => {
    const { colouring, whole_range } = window.lithe.view;
    window.lithe.view.set({ colouring: 'displacement', whole_range: false });
    return { colouring, whole_range };
  });
  const near = (told, true_range, name) => {
    const size = Math.max(Math.abs(true_range[0]), Math.abs(true_range[1]));
    check(`the legend tells the range ${name}`, Math.abs(told.low - true_range[0]) < 1e-3 * size && Math.abs(told.high - true_range[1]) < 1e-3 * size, `${told.low} to ${told.high} for ${true_range.join(' to ')}`);
  };
  for (const part of [0.2, 0.7]) {
    const range = await page.evaluate((part) => {
      const { lithe } = window;
      const frame = Math.floor(part * (lithe.runs[0].frames - 1));
      lithe.setTime(lithe.runs[0].times[frame]);
      const values = lithe.runs.flatMap((run) => {
        const nearest = run.times.reduce((best, t, i) => (Math.abs(t - lithe.time()) < Math.abs(run.times[best] - lithe.time()) ? i : best), 0);
        return run.bodies.filter(({ mesh }) => mesh).map(({ mesh }) => window.lengthsAt(mesh, nearest));
      });
      return [Math.min(...values.map((list) => list.reduce((a, b) => Math.min(a, b)))), Math.max(...values.map((list) => list.reduce((a, b) => Math.max(a, b))))];
    }, part);
    await settle(page);
    near(await legend(page), range, `at ${part} of the run`);
  }
  await page.locator('#tab-Display').click();
  await page.getByLabel('range of the whole run').check();
  const range = await page.evaluate(() => {
    const { lithe } = window;
    const found = [Infinity, -Infinity];
    let at = 0;
    for (const run of lithe.runs) {
      for (const { mesh } of run.bodies) {
        if (!mesh) continue;
        for (let frame = 0; frame < run.frames; ++frame) {
          for (const value of window.lengthsAt(mesh, frame)) {
            found[0] = Math.min(found[0], value);
            if (value > found[1]) [found[1], at] = [value, run.times[frame]];
          }
        }
      }
    }
    lithe.setTime(at); // long runs are looked at in evenly chosen frames and the shown one
    return found;
  });
  await settle(page);
  near(await legend(page), range, 'of the whole run');
  await page.evaluate((view) => window.lithe.view.set(view), before);
}
