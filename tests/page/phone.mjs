// The page on a phone: nothing is wider than the screen, the scene has half of it, fingers turn and zoom.
import { openPage, settle, undrawn } from './browser.mjs';

const kPhones = [{ width: 360, height: 740 }, { width: 390, height: 844 }];

/** What stands out at a side, unless it lies in what scrolls. */
const tooWide = (page) => page.evaluate(() => {
  const out = [];
  const scrolls = (one) => { for (let e = one.parentElement; e; e = e.parentElement) if (/auto|scroll|hidden/.test(getComputedStyle(e).overflowX) && e.id !== 'app' && e !== document.body && e !== document.documentElement) return e; return null; };
  for (const one of document.querySelectorAll('#app *')) {
    if (one.closest('dialog:not([open])') || one.closest('.labels')) continue;
    const { left, right, width } = one.getBoundingClientRect();
    if (width && (left < -0.5 || right > innerWidth + 0.5) && !scrolls(one)) out.push(`${one.tagName}.${one.className} to ${right.toFixed(0)}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) out.push(`the page, ${document.documentElement.scrollWidth}`);
  return out;
});

const sceneShare = (page) => page.evaluate(() => {
  const { width, height } = document.querySelector('.scene').getBoundingClientRect();
  return (width * height) / (innerWidth * innerHeight);
});

/** Parts of the page that are tapped are seen: inside the screen and of some height. */
const seen = (page, selector) => page.locator(selector).evaluate((one) => {
  const { top, bottom, width } = one.getBoundingClientRect();
  return width > 100 && bottom - top > 60 && top >= 0 && bottom <= innerHeight + 0.5;
});

async function checkPanels(page, check, screen) {
  const wide = [...await tooWide(page)];
  const shares = [await sceneShare(page)];
  const unseen = [];
  for (const tab of ['Graph', 'List', 'Modes', 'Display']) {
    await page.locator(`#tab-${tab}`).tap();
    if (!(await seen(page, `#page-${tab}`))) unseen.push(tab);
    wide.push(...await tooWide(page));
  }
  await page.locator('#inspector').scrollIntoViewIfNeeded();
  if (!(await seen(page, '.side'))) unseen.push('Selected');
  await page.getByRole('button', { name: 'Charts (c)' }).tap();
  if (!(await seen(page, '.charts')) || await page.locator('.side').isVisible()) unseen.push('Charts');
  wide.push(...await tooWide(page));
  shares.push(await sceneShare(page));
  await page.getByRole('button', { name: 'Keys and help (?)' }).tap();
  wide.push(...await tooWide(page));
  await page.locator('dialog.help button').tap();
  await page.getByRole('button', { name: 'Side panel (g)' }).tap();
  if (!(await seen(page, '.side'))) unseen.push('Side panel');
  check(`${screen}: nothing is wider than the screen`, wide.length === 0, [...new Set(wide)].slice(0, 6).join('; '));
  check(`${screen}: all tabs and the charts are reached by a tap`, unseen.length === 0, unseen.join());
  check(`${screen}: the scene has at least half of the screen`, shares.every((share) => share >= 0.5), shares.map((share) => share.toFixed(3)).join(' and '));
}

async function checkFingers(page, context, check) {
  const touch = await context.newCDPSession(page);
  const send = (type, points) => touch.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
  const eye = () => page.evaluate(() => {
    const { lithe } = window;
    lithe.stage.draw();
    const { camera, target } = lithe.stage.eye;
    return { distance: camera.position.distanceTo(target), view: lithe.camera().view };
  });
  const { left, top, width, height } = await page.evaluate(() => window.lithe.camera());
  const [x, y] = [left + 0.4 * width, top + 0.5 * height];
  const start = await eye();
  await send('touchStart', [[x, y]]);
  for (let i = 1; i <= 4; ++i) await send('touchMove', [[x + 15 * i, y]]);
  await send('touchEnd', []);
  await settle(page);
  const turned = await eye();
  check('one finger turns', Math.abs(turned.distance / start.distance - 1) < 1e-6 && Math.abs(turned.view[0] - start.view[0]) + Math.abs(turned.view[2] - start.view[2]) > 0.05);
  await send('touchStart', [[x - 20, y], [x + 20, y]]);
  for (let i = 1; i <= 4; ++i) await send('touchMove', [[x - 20 - 5 * i, y], [x + 20 + 5 * i, y]]);
  await send('touchEnd', []);
  await settle(page);
  const near = await eye();
  check('two fingers, twice as far apart, bring it twice as near', Math.abs(turned.distance / near.distance - 2) < 0.1, `${turned.distance / near.distance}`);
  await page.keyboard.press('0');
  await settle(page);
  const place = await page.evaluate(() => {
    const { left, top, width, height } = window.lithe.camera();
    const hit = (x, y) => window.lithe.pick(x, y)?.kind === 'body';
    for (let y = Math.ceil(top + 20); y < top + height - 90; y += 3) {
      for (let x = Math.ceil(left + 10); x < left + width - 60; x += 3) if (hit(x, y) && hit(x + 1, y + 1) && hit(x - 1, y - 1)) return [x, y];
    }
    return null;
  });
  await page.touchscreen.tap(...place);
  await settle(page);
  check('a tap selects a body', (await page.evaluate(() => window.lithe.selected()))?.kind === 'body');
}

export async function checkPhone(browser, path, check) {
  for (const screen of kPhones) {
    const { page, trouble, close } = await openPage(browser, path, { phone: screen });
    await undrawn(page, async () => {
      await checkPanels(page, check, `${screen.width} x ${screen.height}`);
      if (screen === kPhones[0]) await checkFingers(page, page.context(), check);
    });
    check('no error in the console', trouble.length === 0, trouble.join('; '));
    await close();
  }
}
