// How far a drag down is from home to the first force, in the view that a scene begins with.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import type { Browser } from 'playwright-core';

import { launch, number_in, until } from '../browser/browser';
import { scene_file, view } from './command';
import { Watcher } from './watcher';

const kMost_px = 90;
const kStep_px = 5;
const kStart_ms = 60000; // of the first page of a browser, on a loaded machine

let browser: Browser;
before(async () => {
  browser = await launch();
});
after(async () => browser.close());

// Of a mesh, and of two arms; test/unit has every scene, without a browser. $REACH: others, such as "ring walls asteroid".
for (const name of (process.env.REACH ?? 'smooth blocks').split(' '))
  test(`${name}: a drag down is felt within ${kMost_px} pixels, and the way back up ends at home`, async () => {
    const { url, command } = await view('--scene', scene_file(name));
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: 0.5 });
    const watcher = await Watcher.open(url);
    try {
      await page.goto(url);
      await until('armed', async () => (await page.getByTestId('mode').textContent()) === 'armed', kStart_ms);
      await until('the scene', async () => (await page.getByTestId('view').getAttribute('data-objects')) !== null);
      const home = await watcher.hand_at_rest(0);
      const box = await page.getByTestId('view').boundingBox();
      assert.ok(box);
      const [x, y] = [box.x + box.width / 2, box.y + box.height / 4];
      await page.mouse.move(x, y);
      await page.mouse.down();
      let pixels = 0;
      const felt = async () => (await number_in(page, 'force')) > 0;
      while (!(await felt())) {
        pixels += kStep_px;
        assert.ok(pixels <= kMost_px, `nothing is felt after ${pixels - kStep_px} pixels`);
        await page.mouse.move(x, y + pixels);
        await watcher.hand_at_rest(0);
        await page.waitForTimeout(150); // the readings are written every 60 ms
      }
      console.log(`# ${name}: force after ${pixels} pixels`);
      await page.mouse.move(x, y);
      await until('the hand at home', async () => Math.hypot(...(await watcher.hand_at_rest(0)).map((value, i) => value - home[i])) < 1e-4);
      await page.mouse.up();
    } finally {
      watcher.close();
      await page.close();
      await command.stop();
    }
  });
