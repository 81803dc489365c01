// The page by the keyboard alone: everything is reached by Tab or arrows, has a name and shows its focus, and does what it is for.
import { settle } from './browser.mjs';

const kMostStops = 400;

/** What has the focus, in words: {path, name, shown}. */
const focused = (page) => page.evaluate(() => {
  const one = document.activeElement;
  if (!one || one === document.body) return null;
  const label = one.labels?.[0]?.innerText ?? one.closest('label')?.innerText;
  const style = getComputedStyle(one);
  const inner = one.querySelector?.('rect, circle');
  const ringed = style.outlineStyle !== 'none' && parseFloat(style.outlineWidth) >= 2;
  return {
    name: (one.getAttribute('aria-label') ?? label ?? one.innerText ?? '').trim(),
    shown: ringed || (one.closest('svg') !== null && inner && parseFloat(getComputedStyle(inner).strokeWidth) > 2.5),
    number: [...document.querySelectorAll('button, input, select, [tabindex]')].indexOf(one),
  };
});

/** All that can be used now, and which of it arrows lead to. */
const usable = (page) => page.evaluate(() => [...document.querySelectorAll('button, input, select, [tabindex]')].map((one, number) => ({
  number,
  name: one.getAttribute('aria-label') ?? one.innerText,
  there: !one.disabled && one.getClientRects().length > 0 && !one.closest('dialog:not([open])') && (one.matches('button, input, select') || one.getAttribute('role') === 'button' || one.tabIndex >= 0),
  by_arrows: one.closest('[role=tablist], [role=listbox], .graph') !== null,
})).filter(({ there }) => there));

async function checkStops(page, check) {
  const wrong = { nameless: [], unseen: [], unreached: [] };
  for (const tab of ['Graph', 'List', 'Modes', 'Display']) {
    await page.locator(`#tab-${tab}`).focus();
    await page.evaluate((name) => document.querySelector(`#tab-${name}`).click(), tab);
    await page.evaluate(() => document.activeElement.blur());
    const reached = new Set();
    let first = null;
    for (let i = 0; i < kMostStops; ++i) {
      await page.keyboard.press('Tab');
      const at = await focused(page);
      if (!at) continue; // the end of the page: goes on at its start
      if (at.number === first) break;
      first ??= at.number;
      reached.add(at.number);
      if (!at.name) wrong.nameless.push(`${tab}: element ${at.number}`);
      if (!at.shown) wrong.unseen.push(`${tab}: ${at.name}`);
    }
    for (const { number, name, by_arrows } of await usable(page)) if (!reached.has(number) && !by_arrows) wrong.unreached.push(`${tab}: ${name}`);
  }
  check('Tab reaches all that can be pressed, chosen or moved', wrong.unreached.length === 0, wrong.unreached.join('; '));
  check('all of it has a name', wrong.nameless.length === 0, wrong.nameless.join('; '));
  check('the focus is seen on all of it', wrong.unseen.length === 0, wrong.unseen.join('; '));
}

/** Tab until what has the focus is of that name; its name. */
async function tabTo(page, name) {
  for (let i = 0; i < kMostStops; ++i) {
    await page.keyboard.press('Tab');
    const at = await focused(page);
    if (at && name.test(at.name)) return at.name;
  }
  return null;
}

const view = (page, what) => page.evaluate((key) => key.split('.').reduce((value, part) => value?.[part], window.lithe.view), what);

async function checkActions(page, check) {
  await page.evaluate(() => { document.activeElement?.blur(); window.lithe.view.set({ selection: null, playing: false }); window.lithe.setTime(window.lithe.model.start); });
  await tabTo(page, /^Play/);
  await page.keyboard.press('Space');
  const playing = await view(page, 'playing');
  await page.keyboard.press('Space');
  check('Space on the button plays and pauses', playing && !(await view(page, 'playing')));

  await tabTo(page, /^(Graph|List|Modes|Display|Inputs)$/);
  const tabs = await page.locator('[role=tab]').count();
  const shown = new Set();
  for (let i = 0; i < tabs; ++i) {
    await page.keyboard.press('ArrowRight');
    shown.add(await page.locator('[role=tab][aria-selected=true]').innerText());
  }
  check('arrows go through all tabs', shown.size === tabs, [...shown].join());
  while ((await page.locator('[role=tab][aria-selected=true]').innerText()) !== 'List') await page.keyboard.press('ArrowRight');

  await tabTo(page, /^Find a body/);
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('Enter');
  const second = await page.locator('.list .row').nth(1).getAttribute('data-name');
  check(`arrows and Enter select '${second}' in the list, which keeps the focus`, (await page.evaluate(() => window.lithe.selected()))?.name === second && (await page.evaluate(() => document.activeElement.dataset.name)) === second);
  await page.keyboard.press('Tab');
  const link = page.locator('#inspector .link').first();
  if (await link.count()) {
    const tied = await link.innerText();
    await page.evaluate(() => document.querySelector('#inspector .link').focus());
    await page.keyboard.press('Enter');
    check(`its link leads to '${tied}', and the focus stays in the panel`, (await page.evaluate(() => window.lithe.selected()))?.name === tied && await page.evaluate(() => document.activeElement.id === 'inspector'));
  }
  await page.keyboard.press('Escape');
  check('Escape selects nothing', (await page.evaluate(() => window.lithe.selected())) === null);

  await page.locator('#tab-List').focus();
  while ((await page.locator('[role=tab][aria-selected=true]').innerText()) !== 'Graph') await page.keyboard.press('ArrowLeft');
  if (await page.locator('.graph').count()) {
    await page.keyboard.press('Tab');
    const first = (await focused(page)).name;
    const ways = [];
    for (const key of ['ArrowDown', 'ArrowUp', 'ArrowRight', 'ArrowLeft']) {
      await page.keyboard.press(key);
      ways.push((await focused(page)).name);
    }
    await page.keyboard.press('Space');
    const selected = (await page.evaluate(() => window.lithe.selected()))?.name;
    check('arrows go through the graph, Space selects', ways.some((name) => name !== first) && ways.at(-1).startsWith(selected), `${first}, ${ways.join()}, ${selected}`);
  }

  await page.locator('#tab-Graph').focus();
  while ((await page.locator('[role=tab][aria-selected=true]').innerText()) !== 'Display') await page.keyboard.press('ArrowRight');
  await tabTo(page, /^Grid/);
  const grid = await view(page, 'show.grid');
  await page.keyboard.press('Space');
  check('Space switches the grid', (await view(page, 'show.grid')) !== grid && !(await view(page, 'playing')));
  await page.keyboard.press('Space');
  await tabTo(page, /^Arrows$/);
  const [size, time] = [await view(page, 'arrow_scale'), await view(page, 'time')];
  await page.keyboard.press('ArrowRight');
  check('an arrow moves a slider and not the time', (await view(page, 'arrow_scale')) > size && (await view(page, 'time')) === time);
  await page.keyboard.press('ArrowLeft');

  await page.evaluate(() => document.activeElement.blur());
  await tabTo(page, /^Keys and help/);
  await page.keyboard.press('Enter');
  const open = await page.locator('dialog.help').isVisible();
  await page.keyboard.press('Escape');
  check('the help opens and closes, and the focus goes back', open && !(await page.locator('dialog.help').isVisible()) && /^Keys and help/.test((await focused(page))?.name));
}

/** z and shift+Z on a focused chart; Δ keeps the focus. */
async function checkChart(page, check) {
  if (!(await page.locator('.chart .u-over').count())) return;
  await page.evaluate(() => document.activeElement.blur());
  await tabTo(page, /zoom its time$/);
  const span = async () => {
    await settle(page);
    const x = await page.locator('.chart .u-over').first().evaluate(() => window.lithe.charts[0].plot.scales.x);
    return x.max - x.min;
  };
  const all = await span();
  await page.evaluate(() => window.lithe.setTime(0.5 * (window.lithe.model.start + window.lithe.model.end)));
  await page.keyboard.press('z');
  const half = await span();
  await page.keyboard.press('0');
  check('z zooms a chart to half its time about the present, 0 shows all', Math.abs(half / all - 0.5) < 0.01 && Math.abs((await span()) - all) < 1e-9, `${half} of ${all}`);
}

export async function checkKeyboard(page, check) {
  await checkStops(page, check);
  await checkActions(page, check);
  await checkChart(page, check);
  await page.keyboard.press('Escape');
}
