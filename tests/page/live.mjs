// Checks the page that follows a run, of the program tests/page/live_pendulum.cpp.
import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { GrowingRun } from '../../tools/viewer/src/growing.js';
import { openPage } from './browser.mjs';

/** Starts it; {address, over: promise of {code, output}}. */
function start(program) {
  const child = spawn(program);
  let output = '';
  return new Promise((done, fail) => {
    const over = new Promise((told) => { child.on('close', (code) => told({ code, output })); });
    child.on('error', fail);
    child.stdout.on('data', (text) => { output += text; });
    child.stderr.on('data', (text) => {
      const address = /http:\S+/.exec(text)?.[0];
      if (address) done({ address, over, end: () => child.kill() });
    });
  });
}

/** Frame i has the numbers i, 10 i, 10 i + 1, and i points in contact whose forces are i: grown and thinned, each keeps its own. */
export function checkGrowing(check) {
  const frame = (i) => {
    const contact = [-1, 7, i, i, i, i, 0, 0];
    return Float64Array.from([i, 10 * i, 10 * i + 1, ...Array.from({ length: i }, () => contact).flat()]);
  };
  const run = {
    frames: 1, times: Float64Array.of(0), bodies: [{ pair: Float32Array.of(0, 1), fixed: Float32Array.of(5) }],
    contacts: { first: Uint32Array.of(0, 0), points: new Float32Array(0), forces: new Float32Array(0), pair: new Uint16Array(0) },
  };
  const refs = new Map([[run.times, { row: 0, width: 1 }], [run.bodies[0].pair, { row: 1, width: 2 }], [run.bodies[0].fixed, {}]]);
  const growing = new GrowingRun(run, refs);
  const told = () => {
    growing.publish();
    const { first, forces, pair, points } = run.contacts;
    const right = Array.from(run.times, (t, i) => run.bodies[0].pair[2 * i] === 10 * t && run.bodies[0].pair[2 * i + 1] === 10 * t + 1 &&
      first[i + 1] - first[i] === t && forces.subarray(3 * first[i], 3 * first[i + 1]).every((f, c) => f === (c % 3 ? 0 : t)));
    const whole = run.frames === run.times.length && first.length === run.frames + 1 && points.length === forces.length && pair.every((one) => one === 7);
    return { right: right.every(Boolean) && whole && run.bodies[0].fixed[0] === 5, times: run.times.join() };
  };
  for (let i = 1; i <= 6; ++i) growing.push(frame(i), 3);
  const grown = told();
  growing.thin();
  const once = told();
  for (const i of [8, 10]) growing.push(frame(i), 3);
  growing.thin();
  const twice = told();
  check('arrays grow by a state at a time', grown.right && grown.times === '0,1,2,3,4,5,6', grown.times);
  check('every second state is left out', once.right && once.times === '0,2,4,6', once.times);
  check('and again', twice.right && twice.times === '0,4,8', twice.times);
}

export async function checkLive(browser, program, check) {
  checkGrowing(check);
  const { address, over, end } = await start(program);
  const { page, trouble, close } = await openPage(browser, address);
  const look = () => page.evaluate(() => {
    const { lithe } = window;
    const angle = lithe.channel('angle').values;
    return { frames: lithe.runs[0].frames, time: lithe.time(), end: lithe.model.end, state: lithe.view.live.state, angle: angle[angle.length - 1] };
  });
  const until = (what, argument) => page.waitForFunction(what, argument, { timeout: 60000 });
  await until(() => window.lithe.runs[0].frames > 20);
  const first = await look();
  check('frames come, the newest is shown, and nothing moves a pendulum at rest', first.time === first.end && Math.abs(first.angle) < 1e-9, JSON.stringify(first));

  await page.locator('.live .run').click();
  await until(() => window.lithe.view.live.state === 'paused');
  await page.waitForTimeout(300);
  const held = await look();
  await page.waitForTimeout(500);
  check('a pause holds the time', (await look()).frames === held.frames);
  await page.getByRole('button', { name: 'Step' }).click();
  await until((n) => window.lithe.runs[0].frames > n, held.frames);
  await page.waitForTimeout(300);
  const stepped = await look();
  check('a step is one state', stepped.frames === held.frames + 1 && Math.abs(stepped.end - held.end - 0.02) < 1e-9, JSON.stringify(stepped));

  await page.locator('[data-input=torque]').fill('3');
  await page.locator('.live .run').click();
  await until((t) => window.lithe.model.end > t + 0.5, stepped.end);
  const moved = await look();
  check('the slider of an input moves the pendulum its way', moved.angle > 0.1, JSON.stringify(moved));
  check('the slider tells the value', (await page.locator('.inputs legend').innerText()).includes('3.0000 N m'));
  await page.locator('.inputs input[type=number]').fill('99');
  await page.locator('.inputs input[type=number]').press('Enter');
  await page.locator('.problem').waitFor();
  check('a value out of bounds is refused in words', /outside its bounds -5 to 5/.test(await page.locator('.problem').innerText()));

  await page.getByRole('button', { name: 'End', exact: true }).click();
  const { code, output } = await over;
  await until(() => window.lithe.view.live.state === 'ended');
  await page.waitForTimeout(300);
  const ended = await look();
  check('the page ends the run, and the program goes on behind it', code === 0 && output.includes(`${ended.frames} states, ended by the page`), output);
  check('the page has it all', ended.end > moved.end, JSON.stringify(ended));

  // Saved by the page when the program has gone.
  const folder = mkdtempSync(join(tmpdir(), 'lithe_live_'));
  try {
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save' }).click();
    await (await download).saveAs(join(folder, 'saved.html'));
    const saved = await openPage(browser, join(folder, 'saved.html'));
    const values = (one) => one.evaluate(() => Array.from(window.lithe.channel('angle').values).join());
    check('it saves itself as a page that opens alone', (await values(saved.page)) === (await values(page)) && saved.trouble.length === 0, saved.trouble.join('; '));
    check('which follows nothing', await saved.page.evaluate(() => window.lithe.view.live === null && !document.querySelector('.live')));
    await saved.close();
  } finally {
    rmSync(folder, { recursive: true });
  }
  check('no error in the console', trouble.length === 0, trouble.join('; '));
  await close();
  end();
}
