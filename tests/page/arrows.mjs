// Arrows of reactions, moments and contacts against the recorded vectors: place, direction, length, and that they are seen.
import { pixels, project, settle } from './browser.mjs';

/** [from, to] of the drawn arrows of a kind, from the matrices that the picture is drawn with. */
const drawn = (page, run, kind) => page.evaluate(({ run, kind }) => {
  const { shafts, heads } = window.lithe.stage.runs[run].connectors[kind];
  const at = (mesh, i) => Array.from(mesh.instanceMatrix.array.slice(16 * i + 12, 16 * i + 15));
  return Array.from({ length: shafts.visible ? shafts.count : 0 }, (_, i) => [at(shafts, i), at(heads, i)]);
}, { run, kind });

/** Vectors {point, vector} that the run recorded for the time, linear between frames; contacts of the nearest frame. */
const recorded = (page, run, t) => page.evaluate(({ run, t }) => {
  const { times, connectors, contacts } = window.lithe.runs[run];
  let j = times.findIndex((one) => one >= t);
  j = j < 1 ? 1 : j;
  const w = (t - times[j - 1]) / (times[j] - times[j - 1]);
  const at = (values) => [0, 1, 2].map((c) => values[3 * (j - 1) + c] * (1 - w) + values[3 * j + c] * w);
  const of = (field) => connectors.filter(({ reaction }) => reaction?.[field] && reaction.point)
    .map(({ reaction }) => ({ point: at(reaction.point), vector: at(reaction[field]) }));
  const near = w < 0.5 ? j - 1 : j;
  const touching = [];
  for (let c = contacts?.first[near]; c < contacts?.first[near + 1]; ++c) {
    touching.push({ point: Array.from(contacts.points.slice(3 * c, 3 * c + 3)), vector: Array.from(contacts.forces.slice(3 * c, 3 * c + 3)) });
  }
  return { forces: of('force'), moments: of('moment'), contacts: touching };
}, { run, t });

const length = (v) => Math.hypot(...v);
const less = (a, b) => a.map((value, c) => value - b[c]);

/** The largest error of the arrows as a part of their length, infinite where one is missing; `scale` in metres a unit. */
function error(arrows, vectors, scale, thinnest) {
  let worst = 0;
  let expected = 0;
  for (const { point, vector } of vectors) {
    if (!(length(vector) * scale > thinnest)) continue;
    ++expected;
    const errors = arrows.map(([from, to]) => (length(less(from, point)) + length(less(less(to, from), vector.map((x) => x * scale)))) / (length(vector) * scale));
    worst = Math.max(worst, Math.min(Infinity, ...errors));
  }
  return expected === arrows.length ? worst : Infinity;
}

export async function checkArrows(page, check, known) {
  const before = await page.evaluate(() => {
    const { lithe } = window;
    const { show } = lithe.view;
    lithe.view.set({ show: { ...show, reactions: true, moments: true, contacts: true } });
    return show;
  });
  await page.locator('#tab-Display').click();
  // The scale that the page tells a reader: so many newtons are 100 mm.
  const told = await page.locator('.scale output', { hasText: 'N :' }).innerText();
  const scale = 0.1 / Number(told.split(' ')[0].replace('−', '-'));
  const runs = await page.evaluate(() => window.lithe.runs.length);
  const seen = { forces: 0, moments: 0, contacts: 0 };
  const worst = { forces: 0, moments: 0, contacts: 0 };
  for (let run = 0; run < runs; ++run) {
    for (const part of [0.131, 0.52, 0.877]) {
      const { t, thinnest, moment } = await page.evaluate((part) => {
        const { lithe } = window;
        lithe.setTime(lithe.model.start + part * (lithe.model.end - lithe.model.start));
        const { glyph, moment } = lithe.stage.arrowSizes();
        return { t: lithe.time(), thinnest: 0.28 * glyph, moment };
      }, part);
      const vectors = await recorded(page, run, t);
      for (const kind of Object.keys(seen)) {
        const arrows = await drawn(page, run, kind);
        // Of vectors from recorded points alone: others begin at a marker.
        if (kind !== 'contacts' && arrows.length > vectors[kind].length) continue;
        seen[kind] += arrows.length;
        worst[kind] = Math.max(worst[kind], error(arrows, vectors[kind], kind === 'moments' ? moment : scale, thinnest));
      }
    }
  }
  for (const [kind, count] of Object.entries(seen)) {
    if (!count && !known) continue;
    check(`${count} arrows of ${kind} are as long and point as recorded, at ${told}`, count > 0 && worst[kind] < 0.01, `off by ${worst[kind].toFixed(4)} of their length`);
  }
  await page.evaluate((show) => window.lithe.view.set({ show }), before);
}

/** Pixels in the middle of a reaction's arrow, which is some two pixels thick, are drawn by it. */
export async function checkArrowPixels(page, check) {
  await page.evaluate(() => {
    window.lithe.view.set({ selection: null, show: { ...window.lithe.view.show, reactions: true } });
    window.lithe.setTime(0.27);
  });
  const [[from, to]] = await drawn(page, 0, 'forces');
  const at = project(await page.evaluate(() => window.lithe.camera()), from.map((x, c) => 0.5 * (x + to[c])));
  const shot = async (reactions) => {
    await page.evaluate((on) => window.lithe.view.set({ show: { ...window.lithe.view.show, reactions: on } }), reactions);
    await settle(page);
    const picture = await pixels(page);
    return [-2, -1, 0, 1, 2].flatMap((dx) => [-2, -1, 0, 1, 2].map((dy) => picture.at(at.x + dx, at.y + dy)));
  };
  const [on, off] = [await shot(true), await shot(false)];
  const changed = on.filter((pixel, i) => pixel.some((value, c) => Math.abs(value - off[i][c]) > 40)).length;
  check('pixels in the middle of an arrow are drawn by it', changed >= 5, `${changed} of 25 at ${at.x.toFixed(1)}, ${at.y.toFixed(1)}`);
}
