// Pictures of pages for the documentation: node pictures.mjs DIR PAGE.html...; each gives DIR/page_NAME.png.
// What is set up for a page, by its name; any other is shown at 40 % of its time.
import { basename, join, resolve } from 'node:path';
import { openBrowser, openPage, settle } from './browser.mjs';

const kScenes = {
  pendulum: { part: 0.4, body: 1 },
  bracket: { part: 0.1, body: 1, show: { reactions: true } },
  squeezer: { part: 0.4, body: 1, dark: true, show: { reactions: true } },
  pile: { part: 0.5, body: 3 },
  car: { part: 0.72, near: 'frame' },
};

const [directory, ...paths] = process.argv.slice(2);
const browser = await openBrowser();
for (const path of paths) {
  const name = basename(path).replace(/\.html$/, '');
  const scene = kScenes[name] ?? { part: 0.4 };
  const { page, close } = await openPage(browser, resolve(path), { dark: scene.dark });
  await page.evaluate((wish) => {
    const { lithe } = window;
    lithe.view.set({ show: { ...lithe.view.show, ...wish.show } });
    lithe.setTime(lithe.model.start + wish.part * (lithe.model.end - lithe.model.start));
    if (wish.near) lithe.select('body', lithe.model.bodies.findIndex((body) => body.name === wish.near));
    if (wish.body !== undefined) lithe.select('body', Math.min(wish.body, lithe.model.bodies.length - 1));
  }, scene);
  await settle(page);
  if (scene.near) await page.keyboard.press('Shift+F');
  await settle(page);
  await page.screenshot({ path: join(directory, `page_${name}.png`) });
  console.log(join(directory, `page_${name}.png`));
  await close();
}
await browser.close();
