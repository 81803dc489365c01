// Checks pages in a real browser: node check.mjs PAGE.html... live:PROGRAM. Exits with 1 and the list of what is wrong.
import { readFileSync, statSync } from 'node:fs';
import { basename, resolve } from 'node:path';
import { openBrowser, openPage, pixels, project, settle, undrawn } from './browser.mjs';
import { checkArrowPixels, checkArrows } from './arrows.mjs';
import { checkFollow, checkTurning, checkZoom } from './camera.mjs';
import { checkDeformation, checkDisplay, checkLegend } from './display.mjs';
import { checkKeyboard } from './keyboard.mjs';
import { checkLive } from './live.mjs';
import { checkPhone } from './phone.mjs';
import { checkSearch } from './search.mjs';

const kMostBytes = 3e6;
const kPixels = 2; // how far a projected tip may be from where it was recorded
let wrong = 0;
let checked = 0;

function check(name, right, told = '') {
  ++checked;
  if (!right) ++wrong;
  console.log(`  ${right ? 'ok  ' : 'FAIL'} ${name}${right || !told ? '' : `: ${told}`}`);
}

const differs = (a, b, by = 24) => a.some((value, c) => Math.abs(value - b[c]) > by);

/** Traces {name, run, points at three times} beside the markers that they record, from the page's arrays. */
async function tips(page) {
  return page.evaluate(() => {
    const { runs } = window.lithe;
    const found = [];
    runs.forEach((run, r) => run.traces.forEach((trace) => {
      // The marker of a trace is the one that is where the trace begins and ends.
      const ends = [0, run.frames - 1, Math.floor(run.frames / 3)];
      let near = run.markers.map((_, m) => m);
      for (const frame of ends) {
        window.lithe.setTime(run.times[frame]);
        const p = Array.from(trace.points.slice(3 * frame, 3 * frame + 3));
        near = near.filter((m) => Math.hypot(...window.lithe.point(r, 'marker', m).map((v, c) => v - p[c])) < 1e-3 + 0.01 * Math.hypot(...p));
      }
      found.push({ run: r, name: trace.name, marker: near[0] ?? -1 });
    }));
    return found;
  });
}

async function checkScene(page) {
  const { triangles, calls } = await page.evaluate(() => window.lithe.drawn());
  check('the scene has triangles', triangles > 0 && calls > 0, `${triangles} triangles in ${calls} calls`);
  const picture = await pixels(page);
  const { left, top, width, height } = await page.evaluate(() => window.lithe.camera());
  const background = picture.at(left + width - 70, top + 6);
  let drawn = 0;
  for (let x = left + 100; x < left + width - 60; x += 3) for (let y = top + 4; y < top + height - 110; y += 3) drawn += differs(picture.at(x, y), background) ? 1 : 0;
  check('pixels of the scene differ from its background', drawn > 150, `${drawn} samples`);
}

/** Moves the slider itself, then compares the marker on the screen with the recorded position. */
async function checkTips(page) {
  const found = (await tips(page)).filter(({ marker }) => marker >= 0);
  const runs = await page.evaluate(() => window.lithe.runs.length);
  if (!found.length) return console.log('  --   no trace: no tip to compare');
  for (let r = 0; r < runs; ++r) {
    const tip = found.find(({ run }) => run === r);
    if (!tip) continue;
    let worst = 0;
    let worst_node = 0;
    for (const part of [0.13, 0.5, 0.871]) {
      await page.locator('#time').evaluate((slider, value) => {
        slider.value = value;
        slider.dispatchEvent(new Event('input', { bubbles: true }));
      }, Math.round(part * 10000));
      await settle(page);
      const seen = await page.evaluate(({ run, marker, name }) => {
        const { lithe } = window;
        const data = lithe.runs[run];
        const t = lithe.time();
        const trace = data.traces.find((one) => one.name === name).points;
        let i = data.times.findIndex((one) => one > t) - 1;
        if (i < 0) i = data.times.length - 2;
        const w = Math.min(1, (t - data.times[i]) / (data.times[i + 1] - data.times[i]));
        const recorded = [0, 1, 2].map((c) => trace[3 * i + c] * (1 - w) + trace[3 * i + 3 + c] * w);
        return { t, recorded, shown: lithe.project(run, 'marker', marker), camera: lithe.camera() };
      }, tip);
      const expected = project(seen.camera, seen.recorded);
      worst = Math.max(worst, Math.hypot(expected.x - seen.shown.x, expected.y - seen.shown.y));
      worst_node = Math.max(worst_node, seen.t);
    }
    check(`moving the slider moves '${tip.name}' of run ${r + 1} to the recorded position (within ${kPixels} pixels, to t = ${worst_node.toFixed(3)} s)`, worst < kPixels, `${worst.toFixed(2)} pixels off`);
  }
}

/** The pixel at the tip is the body: it changes when that run is hidden. Uses the body under the marker. */
async function checkTipPixel(page, must) {
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('0');
  let told = null;
  const before = await page.evaluate(() => ({ runs: window.lithe.view.runs, show: window.lithe.view.show }));
  for (const tip of (await tips(page)).filter(({ marker }) => marker >= 0)) {
    told = await findTip(page, tip);
    if (told.radius !== Infinity) break;
  }
  // A trace may run inside of a body, or in a hole of it: then there is no pixel to look at.
  const back = () => page.evaluate((view) => window.lithe.view.set(view), before);
  if (!told || (told.radius === Infinity && !must)) {
    console.log('  --   no recorded tip is on a visible surface');
    return back();
  }
  check(`the body '${told.name}' is drawn at its tip`, told.radius !== Infinity);
  if (told.radius === Infinity) return back();
  const with_body = (await pixels(page)).at(told.x, told.y);
  await page.evaluate(() => window.lithe.view.set({ runs: window.lithe.view.runs.map(() => ({ shown: false, solid: true })) }));
  const without = (await pixels(page)).at(told.x, told.y);
  await back();
  check(`the pixel at the tip is drawn by '${told.name}'`, differs(with_body, without, 12), `${with_body} with it, ${without} without`);
}

/** Shows the tip's run alone at half time; a pixel near the tip that hits its body, radius infinite if there is none. */
function findTip(page, tip) {
  return page.evaluate(({ run, marker }) => {
    const { lithe } = window;
    const data = lithe.runs[run];
    lithe.view.set({ show: { ...lithe.view.show, traces: false, joints: false, grid: false }, runs: lithe.view.runs.map((_, r) => ({ shown: r === run, solid: true })), selection: null });
    lithe.setTime(data.times[Math.floor(data.frames / 2)]);
    const at = lithe.project(run, 'marker', marker);
    const body = data.bodies[data.markers[marker].body];
    const entry = lithe.model.bodyEntry(run, body.index);
    // A tip may be on the rim: the nearest pixel, within the tolerance and a bit of the body's inside, that hits it.
    for (let radius = 0; radius <= 8; ++radius) {
      for (let step = 0; step < 16; ++step) {
        const [x, y] = [at.x + radius * Math.cos((step * Math.PI) / 8), at.y + radius * Math.sin((step * Math.PI) / 8)];
        const hit = lithe.pick(x, y);
        if (hit?.kind === 'body' && hit.index === entry.index) return { x, y, radius, name: body.name };
      }
    }
    return { ...at, radius: Infinity, name: body.name };
  }, tip);
}

async function checkSelection(page) {
  const nodes = page.locator('.node.body');
  if ((await nodes.count()) === 0) return console.log('  --   no drawn graph: too many bodies');
  const t = await page.evaluate(() => { window.lithe.setTime((window.lithe.model.start + window.lithe.model.end) / 3); return window.lithe.time(); });
  const index = (await nodes.count()) > 1 ? 1 : 0;
  const name = await nodes.nth(index).getAttribute('data-name');
  await nodes.nth(index).click();
  await settle(page);
  const selected = await page.evaluate(() => window.lithe.selected());
  check(`a click in the graph selects '${name}'`, selected?.kind === 'body' && selected.name === name, JSON.stringify(selected));
  const panel = await page.locator('#inspector').innerText();
  const x = await page.evaluate(({ i, time }) => {
    const entry = window.lithe.model.bodies[i];
    const r = entry.of.findIndex((one) => one >= 0);
    const run = window.lithe.runs[r];
    const { position } = run.bodies[entry.of[r]];
    if (!position) return 0;
    let k = run.times.findIndex((one) => one > time) - 1;
    if (k < 0) k = run.times.length - 2;
    const w = (time - run.times[k]) / (run.times[k + 1] - run.times[k]);
    return position[3 * k] * (1 - w) + position[3 * k + 3] * w;
  }, { i: selected?.index ?? 0, time: t });
  const row = panel.split('\n').find((line) => line.startsWith('position x')) ?? '';
  const told = Number((row.match(/position x\s+([−\d.e]+)/)?.[1] ?? 'NaN').replaceAll('−', '-'));
  check('the panel shows its name and coordinates at that time', panel.includes(name) && Math.abs(told - x) <= 1e-4 * Math.abs(x) + 1e-12, `${row} for ${x}`);
  const joint = page.locator('.node.connector').first();
  if (await joint.count()) {
    const joint_name = await joint.getAttribute('data-name');
    await joint.click();
    check(`a click on the connector '${joint_name}' selects it`, (await page.evaluate(() => window.lithe.selected()))?.name === joint_name);
  }
}

async function checkVariants(page) {
  const runs = await page.evaluate(() => window.lithe.runs.map((run) => run.name));
  if (runs.length < 2) return;
  const shown = await page.locator('.variant').allInnerTexts();
  check(`the variants ${runs.join(', ')} are there`, runs.every((name) => shown.some((text) => text.includes(name))), shown.join(' | '));
  const largest = await page.locator('.largest').allInnerTexts();
  check('their difference is charted and its largest value told', largest.some((text) => /\d/.test(text)), largest.join());
  await page.locator('.variant input').last().uncheck();
  const state = await page.evaluate(() => window.lithe.view.runs.map((run) => run.shown));
  check('a variant is switched off', state.at(-1) === false && state[0] === true);
  await page.locator('.variant input').last().check();
}

async function checkCharts(page) {
  const chart = page.locator('.chart').first();
  if (!(await chart.count())) return;
  const place = async () => Number((await chart.locator('.now').evaluate((one) => one.style.transform)).match(/-?[\d.]+/)?.[0]);
  await page.evaluate(() => window.lithe.setTime(window.lithe.model.start));
  const before = await place();
  await page.evaluate(() => window.lithe.setTime(window.lithe.model.end));
  const after = await place();
  check('the charts follow the slider', after - before > 100, `${before} to ${after}`);
  const over = chart.locator('.u-over');
  const box = await over.boundingBox();
  await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
  const { t, middle, span } = await page.evaluate(() => {
    const { model } = window.lithe;
    return { t: window.lithe.time(), middle: (model.start + model.end) / 2, span: model.end - model.start };
  });
  check('a click in a chart sets the time', Math.abs(t - middle) < 0.02 * span, `${t} for ${middle}`);
}

async function checkKeys(page) {
  await page.evaluate(() => { document.activeElement?.blur(); window.lithe.setTime(window.lithe.model.start); });
  await page.keyboard.press('ArrowRight');
  const { t, next } = await page.evaluate(() => ({ t: window.lithe.time(), next: window.lithe.runs[0].times[1] }));
  check('the right arrow goes one frame on', Math.abs(t - next) < 1e-9 * Math.max(1, Math.abs(next)), `${t} for ${next}`);
  await page.keyboard.press('Space');
  const playing = await page.evaluate(() => window.lithe.view.playing);
  await page.keyboard.press('Space');
  check('space plays and pauses', playing && !(await page.evaluate(() => window.lithe.view.playing)));
  const before = await page.evaluate(() => window.lithe.camera().view.join());
  await page.keyboard.press('3');
  await settle(page);
  const view = await page.evaluate(() => window.lithe.camera().view);
  check('3 looks along z', view.join() !== before && Math.abs(Math.abs(view[10]) - 1) < 1e-3, view.map((v) => v.toFixed(2)).join());
  await page.keyboard.press('?');
  check('? opens the sheet of keys', await page.locator('dialog.help').isVisible());
  await page.keyboard.press('Escape');
  await page.keyboard.press('0');
}

async function checkThemes(page) {
  const scene = async () => (await pixels(page)).at(...(await page.evaluate(() => { const { left, top, width } = window.lithe.camera(); return [left + width - 70, top + 6]; })));
  const first = await scene();
  await page.keyboard.press('t');
  const second = await scene();
  check('light and dark differ', Math.abs(first[0] - second[0]) > 100, `${first} and ${second}`);
}

async function checkModes(page) {
  const has = await page.evaluate(() => window.lithe.runs.some((run) => run.bodies.some((body) => body.mesh?.modes.length && body.mesh.natural)));
  if (!has) return;
  await page.locator('#tab-Modes').click();
  const choice = page.locator('.modes select option');
  for (let i = 0; i < (await choice.count()) && !(await page.locator('.modes .row').count()); ++i) await page.locator('.modes select').selectOption({ index: i });
  await page.locator('.modes .row').first().click();
  await page.waitForFunction(() => window.lithe.view.mode !== null);
  await settle(page);
  check('a mode shape swings, with its frequency told', /Hz/.test(await page.locator('.note').innerText()));
  await page.locator('.modes > button').click();
}

const kInDepth = ['known_motion', 'bracket', 'squeezer', 'pile', 'beams', 'contact'];

/** What costs time is looked at on pages that have it all between them. */
async function checkInDepth(page, name) {
  if (!kInDepth.includes(name.replace('.html', ''))) return;
  const known = name === 'known_motion.html';
  await undrawn(page, async () => {
    for (const step of [checkArrows, checkLegend, checkDeformation, checkFollow, checkZoom, checkSearch, checkKeyboard]) await step(page, check, known);
    if (known) await checkTurning(page, check);
  });
  await checkDisplay(page, check);
  if (known) await checkArrowPixels(page, check);
}

async function checkPage(browser, path) {
  console.log(`${basename(path)}: ${(statSync(path).size / 1e6).toFixed(2)} MB`);
  check(`it is below ${kMostBytes / 1e6} MB`, statSync(path).size < kMostBytes);
  check('it names no other file or host to load', !/<(script|link|img)[^>]*\s(src|href)=(?!["']?data:)/.test(readFileSync(path, 'utf8').replace(/<script>[\s\S]*?<\/script>/g, '')));
  const { page, trouble, close } = await openPage(browser, path);
  const failed = await page.evaluate(() => window.lithe.failed);
  check('the page opens its run', !failed, failed);
  if (!failed) {
    const steps = [checkScene, checkTips, checkCharts, checkVariants, checkSelection, checkKeys, checkModes, checkFields, checkFindings, checkTipPixel, checkThemes];
    for (const step of steps) await step(page, basename(path) === 'known_motion.html');
    await checkInDepth(page, basename(path));
  }
  check('no error in the console, nothing asked of a network', trouble.length === 0, trouble.join('; '));
  await close();
}

/** A field that stays the same over the run is offered, and its legend has its range without a unit. */
async function checkFields(page, known) {
  if (!known) return;
  await page.locator('#tab-Display').click();
  const offered = await page.locator('select[aria-label="Colour of finite-element bodies"] option').allTextContents();
  check('the field of the page is offered as a colour', offered.includes('damage'), offered.join());
  const before = await page.evaluate(() => window.lithe.view.colouring);
  await page.evaluate(() => window.lithe.view.set({ colouring: 'damage' }));
  await settle(page);
  const legend = await page.locator('.legend').getAttribute('aria-label');
  check('its legend tells its range', /^damage: 0 to 0\.2500? *$/.test(legend), legend);
  await page.evaluate((colouring) => window.lithe.view.set({ colouring }), before);
}

/** What was found in the scene is listed, and its names select what they name. */
async function checkFindings(page, known) {
  const tab = page.locator('#tab-Findings');
  if (!known) return check('findings have their tab', (await tab.count()) === (await page.evaluate(() => (window.lithe.model.findings.length ? 1 : 0))));
  await tab.click();
  const told = await page.locator('.finding').allInnerTexts();
  check('both findings are listed, text as text', told.length === 2 && /no such body' <b>/.test(told[0]) && /worth knowing/.test(told[1]), told.join(' | '));
  check('the alarm is marked', (await page.locator('.finding.alarm').count()) === 1);
  check('names that there are are links', (await page.locator('.finding .link').allInnerTexts()).join() === 'pin,link,link');
  const selects = async (name) => {
    await page.locator('.finding .link', { hasText: name }).first().click();
    return (await page.evaluate(() => window.lithe.selected()))?.name === name;
  };
  check('a click on a name selects the joint, and the body', (await selects('pin')) && (await selects('link')));
  await page.locator('#tab-Graph').click();
}

/** A page with spoilt numbers says so in the page. */
async function checkBroken(browser, path) {
  console.log(`${basename(path)}, with spoilt numbers`);
  const { page, close } = await openPage(browser, path);
  const text = await page.locator('[role=alert]').innerText();
  check('it says what is wrong and how to fix it', /cannot be unpacked|cannot be shown/.test(text) && /fix:/.test(text), text);
  await close();
}

const browser = await openBrowser();
try {
  for (const path of process.argv.slice(2)) {
    if (path.startsWith('live:')) {
      console.log(`${basename(path)}, followed`);
      await checkLive(browser, resolve(path.slice(5)), check);
    } else if (path.startsWith('broken:')) await checkBroken(browser, resolve(path.slice(7)));
    else {
      await checkPage(browser, resolve(path));
      if (basename(path) === 'known_motion.html') await checkPhone(browser, resolve(path), check);
    }
  }
} finally {
  await browser.close();
}
console.log(`${checked - wrong} passed, ${wrong} failed`);
process.exit(wrong ? 1 : 0);
