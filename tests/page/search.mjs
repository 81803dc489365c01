// Search: names find bodies, joints and channels; Enter takes the first; what finds nothing says so.
import { settle } from './browser.mjs';

const kMostRows = 400;

/** A word that finds few of the names, and how many have it. */
function word(names) {
  const lower = names.map((name) => name.toLowerCase());
  const whole = lower.at(-1);
  return { text: whole, name: names.at(-1), words: whole.split(/\s+/) };
}

export async function checkSearch(page, check) {
  await page.evaluate(() => { document.activeElement?.blur(); window.lithe.view.set({ selection: null }); });
  await page.keyboard.press('/');
  const { bodies, connectors, all } = await page.evaluate(() => {
    const { bodies, connectors } = window.lithe.model;
    return { bodies: bodies.map(({ name }) => name), connectors: connectors.map(({ name }) => name), all: [...bodies, ...connectors].map(({ name, item }) => `${name} ${item.kind}`.toLowerCase()) };
  });
  for (const [kind, names] of [['body', bodies], ['connector', connectors]]) {
    if (!names.length) continue;
    const { text, name, words } = word(names);
    await page.keyboard.press('Control+a');
    await page.keyboard.type(text);
    const rows = await page.locator('.list .row').evaluateAll((list) => list.map((row) => row.dataset.name));
    const expected = all.filter((one) => words.every((part) => one.includes(part))).length;
    check(`'${text}' finds ${expected} of ${all.length}`, rows.length === Math.min(expected, kMostRows) && rows.includes(name), rows.slice(0, 5).join());
    await page.keyboard.press('Enter');
    const selected = await page.evaluate(() => window.lithe.selected());
    check(`Enter selects the first, '${selected?.name}'`, selected?.name === rows[0]);
    check('it is marked, and the field keeps the focus', await page.evaluate(() => document.querySelector('.list .row')?.getAttribute('aria-selected') === 'true' && document.activeElement?.type === 'search'));
  }
  await page.keyboard.press('Control+a');
  await page.keyboard.type('no such thing');
  check('what finds nothing says so', (await page.locator('.list .rows').innerText()).includes('Nothing of that name'));
  await page.keyboard.press('Control+a');
  await page.keyboard.press('Backspace');
  await page.keyboard.press('Escape');

  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('a');
  const channels = await page.evaluate(() => window.lithe.model.channels.map(({ name, group, unit }) => ({ name, all: `${name} ${group} ${unit}`.toLowerCase() })));
  if (channels.length) {
    const { text, words } = word(channels.map(({ name }) => name));
    await page.keyboard.type(text);
    const expected = channels.filter(({ all }) => words.every((part) => all.includes(part)));
    const count = await page.locator('.picker .row').count();
    check(`'${text}' finds ${expected.length} of ${channels.length} channels`, count === Math.min(expected.length, 60), `${count} rows`);
    await page.keyboard.press('Enter');
    await settle(page);
    const charted = await page.locator('.chart').evaluateAll((list) => list.map((one) => one.getAttribute('aria-label')));
    check('Enter charts the first', charted.some((label) => label.includes(expected[0].name)), charted.join(' | '));
    await page.keyboard.press('a');
  }
  await page.keyboard.type('no such thing');
  check('no channel of that name says so', (await page.locator('.picker .rows').innerText()).includes('No channel of that name'));
  await page.keyboard.press('Escape'); // clears the words
  await page.keyboard.press('Escape');
  check('Escape closes the sheet', !(await page.locator('dialog.picker').isVisible()));
}
