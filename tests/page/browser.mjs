// Opens pages in headless Chromium and looks at them: helpers of check.mjs and pictures.mjs.
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';

const require = createRequire(new URL('../../tools/viewer/package.json', import.meta.url));
const kFlags = [
  '--headless=new', '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--disable-quic',
  '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync',
];
const kPatience = 120000; // ms: software drawing on a busy machine

export async function openBrowser() {
  const { chromium } = require('playwright-core');
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: kFlags, timeout: kPatience });
}

/**
 * A tab of 1280 x 720 with the page ready; `trouble` gathers console errors and requests. `path` is a file, which is
 * opened without a network, or the address of a run that goes on, which asks nobody else. `phone`: a screen to touch.
 */
export async function openPage(browser, path, { dark = false, phone = null } = {}) {
  const live = path.startsWith('http:');
  const context = await browser.newContext({
    viewport: phone ?? { width: 1280, height: 720 }, hasTouch: phone !== null, isMobile: phone !== null, colorScheme: dark ? 'dark' : 'light', reducedMotion: 'reduce', offline: !live,
  });
  const page = await context.newPage();
  page.setDefaultTimeout(kPatience);
  const trouble = [];
  page.on('console', (message) => { if (message.type() === 'error') trouble.push(`console: ${message.text()}`); });
  page.on('pageerror', (error) => trouble.push(`error: ${error.message}`));
  page.on('request', (request) => { if (/^(https?|wss?):/.test(request.url()) && !(live && request.url().startsWith(path))) trouble.push(`asks the network for ${request.url()}`); });
  await page.goto(live ? path : pathToFileURL(path).href, { timeout: kPatience });
  await page.evaluate(() => window.lithe.ready);
  return { page, trouble, close: () => context.close() };
}

/** Two frames drawn, so that what is on the screen is what was set. */
export const settle = (page) => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));

/** Does what looks at no pixel without waiting for software to draw the scene: all but the drawing itself goes on. */
export async function undrawn(page, act) {
  await page.evaluate(() => {
    const { renderer } = window.lithe.stage;
    renderer.kept = renderer.render;
    renderer.render = (scene) => scene.updateMatrixWorld();
  });
  await act();
  await page.evaluate(() => {
    const { stage } = window.lithe;
    stage.renderer.render = stage.renderer.kept;
    stage.draw();
  });
}

/** The drawn pixels of the window: {at(x, y) -> [r, g, b], width, height}. Decoded by the browser itself. */
export async function pixels(page) {
  await settle(page);
  const png = (await page.screenshot({ timeout: kPatience })).toString('base64');
  const { width, height, data } = await page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let out = '';
    for (let i = 0; i < data.length; i += 0x8000) out += String.fromCharCode(...data.subarray(i, i + 0x8000));
    return { width: image.width, height: image.height, data: btoa(out) };
  }, png);
  const raw = Buffer.from(data, 'base64');
  return { width, height, at: (x, y) => { const i = 4 * (Math.round(y) * width + Math.round(x)); return [raw[i], raw[i + 1], raw[i + 2]]; } };
}

/** A world point to CSS pixels by the camera's matrices, apart from the page's own code. */
export function project(camera, point) {
  const times = (m, [x, y, z, w]) => [0, 1, 2, 3].map((r) => m[r] * x + m[4 + r] * y + m[8 + r] * z + m[12 + r] * w);
  const [x, y, , w] = times(camera.projection, times(camera.view, [...point, 1]));
  return { x: camera.left + (0.5 + (0.5 * x) / w) * camera.width, y: camera.top + (0.5 - (0.5 * y) / w) * camera.height };
}
