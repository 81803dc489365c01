// Following a body, and zooming by wheel and keys: where things are on the screen, by the camera's matrices.
import { project, settle } from './browser.mjs';

const kPixels = 2;

const camera = (page) => page.evaluate(() => { window.lithe.stage.draw(); return window.lithe.camera(); });

const kParts = [0.1, 0.3, 0.55, 0.8, 1];

const spread = (places) => Math.max(...places.map(({ x, y }) => Math.hypot(x - places[0].x, y - places[0].y)));

/** The body's way over the screen, drawn at each of the times. */
async function travel(page, { run, body }) {
  const seen = await page.evaluate(({ run, body, parts }) => parts.map((part) => {
    const { lithe } = window;
    lithe.setTime(lithe.model.start + part * (lithe.model.end - lithe.model.start));
    return { point: lithe.point(run, 'body', body), camera: lithe.camera() };
  }), { run, body, parts: kParts });
  return spread(seen.map(({ point, camera: eye }) => project(eye, point)));
}

/** {index, name, run, body, moved} of the body that moves farthest over the screen while the eye stands still. */
async function farthestBody(page) {
  const { eye, bodies } = await page.evaluate((parts) => {
    const { lithe } = window;
    const { start, end } = lithe.model;
    const bodies = lithe.model.bodies.map(({ index, name, of }) => {
      const run = of.findIndex((one) => one >= 0);
      return { index, name, run, body: of[run], points: [] };
    });
    for (const part of parts) {
      lithe.view.set({ time: start + part * (end - start) });
      for (const one of bodies) one.points.push(lithe.point(one.run, 'body', one.body));
    }
    lithe.stage.draw();
    return { eye: lithe.camera(), bodies };
  }, kParts);
  return bodies.map(({ points, ...body }) => ({ ...body, moved: spread(points.map((point) => project(eye, point))) }))
    .reduce((best, one) => (one.moved > best.moved ? one : best));
}

export async function checkFollow(page, check, known) {
  await page.evaluate(() => { document.activeElement?.blur(); window.lithe.view.set({ selection: null, follow: null }); });
  await page.keyboard.press('0');
  const farthest = await farthestBody(page);
  if (!(farthest.moved > 15)) return check(`no body moves far across the screen, '${farthest.name}' most`, !known, `${farthest.moved} pixels`);
  await page.evaluate(({ index, part }) => {
    const { lithe } = window;
    lithe.setTime(lithe.model.start + part * (lithe.model.end - lithe.model.start));
    lithe.select('body', index);
  }, { index: farthest.index, part: kParts[0] });
  await page.keyboard.press('w');
  const held = await travel(page, farthest);
  check(`'${farthest.name}' moves by ${farthest.moved.toFixed(0)} pixels, and by ${held.toFixed(2)} while it is followed`, held < kPixels, `${held} pixels`);
  check('the button of the eye tells that it follows', (await page.locator('.eye [aria-label^="Follow"]').getAttribute('aria-pressed')) === 'true');
  await page.keyboard.press('w');
  const free = await travel(page, farthest);
  check('let go, it moves again', free > 0.5 * farthest.moved, `${free} pixels`);
  await page.keyboard.press('Escape');
  await page.keyboard.press('0');
}

/** Two points of the scene that are apart on the screen, at its box's corners. */
async function twoPoints(page) {
  const points = await page.evaluate(() => [window.lithe.stage.low, window.lithe.stage.high]);
  return points.map((point, i) => point.map((value, c) => value + (0.2 + 0.1 * c) * (points[1 - i][c] - value)));
}

const distance = (eye, [a, b]) => Math.hypot(project(eye, a).x - project(eye, b).x, project(eye, a).y - project(eye, b).y);

export async function checkZoom(page, check) {
  const points = await twoPoints(page);
  for (const name of ['perspective', 'parallel']) {
    await page.evaluate(() => document.activeElement?.blur());
    await page.keyboard.press('0');
    const before = await camera(page);
    const { x, y } = project(before, points[0]);
    await page.mouse.move(x, y);
    await page.mouse.wheel(0, -300);
    await settle(page);
    const after = await camera(page);
    const there = project(after, points[0]);
    const off = Math.hypot(there.x - x, there.y - y);
    const grown = distance(after, points) / distance(before, points);
    check(`the wheel magnifies (${name}, ${grown.toFixed(2)}), and the point under the cursor stays`, grown > 1.05 && off < kPixels, `${off.toFixed(2)} pixels off, ${grown}`);
    await page.keyboard.press('0');
    const start = await camera(page);
    for (let i = 0; i < 3; ++i) await page.keyboard.press('z');
    const near = await camera(page);
    const centre = await page.evaluate(() => window.lithe.stage.eye.target.toArray());
    const [c0, c1] = [project(start, centre), project(near, centre)];
    // Seen from a third nearer, what is off the target's plane grows otherwise than it.
    const side = centre.map((value, c) => value + 0.05 * Math.hypot(...points[0].map((p, k) => p - points[1][k])) * near.view[4 * c]);
    const factor = distance(near, [centre, side]) / distance(start, [centre, side]);
    check(`three times z magnify by 1.25³ (${name}), and the target stays`, Math.abs(factor - 1.25 ** 3) < 1e-3 && Math.hypot(c0.x - c1.x, c0.y - c1.y) < 0.1, `${factor}`);
    for (let i = 0; i < 3; ++i) await page.keyboard.press('Shift+Z');
    const back = distance(await camera(page), points) / distance(start, points);
    check('shift+Z goes back', Math.abs(back - 1) < 1e-6, `${back}`);
    await page.keyboard.press('o');
  }
  await page.keyboard.press('0');
}

/** Angle between two views, degrees. */
function angle(a, b) {
  let trace = 0;
  for (let c = 0; c < 3; ++c) for (let r = 0; r < 3; ++r) trace += a.view[4 * c + r] * b.view[4 * c + r];
  return (Math.acos(Math.min(1, (trace - 1) / 2)) * 180) / Math.PI;
}

/** x, y turn by ten degrees to the right and upwards, v and b move by a tenth of the height. */
export async function checkTurning(page, check) {
  await page.evaluate(() => document.activeElement?.blur());
  const home = async () => { await page.keyboard.press('0'); return camera(page); };
  const pressed = async (key) => { await page.keyboard.press(key); return camera(page); };
  const eyeOf = ({ view: v }) => [0, 1, 2].map((c) => -(v[4 * c] * v[12] + v[4 * c + 1] * v[13] + v[4 * c + 2] * v[14]));
  const along = (a, b, row) => eyeOf(b).reduce((sum, value, c) => sum + (value - eyeOf(a)[c]) * a.view[4 * c + row], 0);
  let start = await home();
  const right = await pressed('x');
  const level = Math.hypot(start.view[2], start.view[6], start.view[10]); // 1: a row of a rotation
  check('x goes round to the right', along(start, right, 0) > 0 && angle(start, right) > 8 && angle(start, right) < 10.01 && level > 0.99, `${angle(start, right)} degrees`);
  check('shift+X goes back', angle(start, await pressed('Shift+X')) < 0.01);
  start = await home();
  const up = await pressed('y');
  check('y rises by ten degrees', along(start, up, 1) > 0 && Math.abs(angle(start, up) - 10) < 0.01, `${angle(start, up)} degrees`);
  start = await home();
  const target = await page.evaluate(() => window.lithe.stage.eye.target.toArray());
  const [c0, c1] = [project(start, target), project(await pressed('v'), target)];
  check('v moves the eye right by a tenth of the picture\'s height', Math.abs(c1.x - c0.x + 0.1 * start.height) < 1 && Math.abs(c1.y - c0.y) < 0.5, `${c1.x - c0.x}`);
  const c2 = project(await pressed('b'), target);
  check('b moves it up as far', Math.abs(c2.y - c1.y - 0.1 * start.height) < 1, `${c2.y - c1.y}`);
  await home();
}
