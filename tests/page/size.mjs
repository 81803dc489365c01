// How fast large pages are drawn: node size.mjs PAGE.html... Prints a row a page: pictures a second by the page's own clock,
// CPU time a picture of the page's script and of all drawing (other work on the machine does not count in it), draw calls.
// What does not depend on the machine is checked: draw calls, and that bodies drawn together are where they were recorded.
import { basename, resolve } from 'node:path';
import { openBrowser, openPage } from './browser.mjs';

const kSeconds = Number(process.env.SECONDS_A_PAGE ?? 8);
const kMostCalls = 12;

/** Seconds of CPU of the browser's processes by their kind. */
async function cpu(session) {
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  const sums = {};
  for (const { type, cpuTime } of processInfo) sums[type] = (sums[type] ?? 0) + cpuTime;
  return sums;
}

/** Plays for some seconds; {pictures, seconds, script: ms of the page's thread in drawing}. */
const play = (page, seconds) => page.evaluate((seconds) => new Promise((done) => {
  const { stage, view } = window.lithe;
  const { draw } = stage;
  const start = performance.now();
  let [pictures, script] = [0, 0];
  stage.draw = () => {
    const before = performance.now();
    draw.call(stage);
    script += performance.now() - before;
    ++pictures;
    const passed = (performance.now() - start) / 1000;
    if (passed < seconds || pictures < 4) return;
    delete stage.draw;
    view.set({ playing: false });
    done({ pictures, seconds: passed, script });
  };
  view.set({ playing: true });
}), seconds);

/** The largest distance of drawn shapes from where the run's arrays have their bodies, at a frame. */
const misplaced = (page) => page.evaluate(() => {
  const { lithe } = window;
  const [run] = lithe.runs;
  const frame = Math.floor(run.frames / 2);
  lithe.setTime(run.times[frame]);
  let worst = 0;
  for (const { bodies, matrices } of lithe.stage.runs[0].bodies.instances) {
    bodies.forEach((body, i) => {
      const { position } = run.bodies[body];
      if (position) worst = Math.max(worst, Math.hypot(...[0, 1, 2].map((c) => matrices.array[16 * i + 12 + c] - position[3 * frame + c])));
    });
  }
  return worst;
});

let wrong = 0;
const browser = await openBrowser();
const session = await browser.newBrowserCDPSession();
console.log('page             pictures a s   CPU ms a picture: script, page, drawing   triangles   calls   opened in');
for (const path of process.argv.slice(2)) {
  const begin = Date.now();
  const { page, trouble, close } = await openPage(browser, resolve(path));
  const opened = (Date.now() - begin) / 1000;
  const off = await misplaced(page);
  const before = await cpu(session);
  const { pictures, seconds, script } = await play(page, kSeconds);
  const after = await cpu(session);
  const each = (kind) => ((1000 * (after[kind] - before[kind])) / pictures).toFixed(0);
  const { triangles, calls } = await page.evaluate(() => window.lithe.drawn());
  console.log(`${basename(path).padEnd(16)} ${(pictures / seconds).toFixed(1).padStart(12)}   ${(script / pictures).toFixed(1).padStart(6)} (wall), ${each('renderer')}, ${each('GPU')}`.padEnd(74) +
    `${String(triangles).padStart(9)} ${String(calls).padStart(7)}   ${opened.toFixed(1)} s`);
  for (const [bad, what] of [[calls > kMostCalls, `${calls} draw calls`], [off > 1e-5, `bodies are drawn ${off} m off`], [trouble.length > 0, trouble.join('; ')]]) {
    if (!bad) continue;
    ++wrong;
    console.log(`  FAIL ${what}`);
  }
  await close();
}
await browser.close();
process.exit(wrong ? 1 : 0);
