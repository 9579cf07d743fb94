// A board that runs a scene of another host: one whose file is known here is drawn, of another one every page says that it is not.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import { launch, until as until_soon } from '../browser/browser';
import { violations } from '../browser/page_checks';
import { scene_file, simulator, thimble, view } from './command';

const until = (what: string, holds: () => Promise<boolean> | boolean): Promise<void> => until_soon(what, holds, 60_000);

test("a scene that is not known here is told on every page, also on one that comes late; a known one takes the banner's place", async () => {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-unknown-'));
  const file = join(folder, 'blocks.scene.json');
  const floor = { name: 'floor', shape: { plane: { normal: [0, 0, 1], offset_m: -0.03 } }, material: { stiffness_N_m: 321 } };
  writeFileSync(file, JSON.stringify({ thimble_scene: 1, name: 'blocks', objects: [floor] })); // only the name is that of a known one
  const board = await simulator();
  const browser = await launch();
  thimble('upload', file, '--device', board.address);
  const server = await view('--device', board.address);
  try {
    for (let pages = 0; pages < 2; ++pages) {
      const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: 0.5 });
      await page.goto(server.url);
      await until('the banner', async () => (await page.getByTestId('alert').count()) === 1);
      assert.match(await page.getByTestId('alerts').innerText(), /scene-unknown the device runs "blocks", a scene that is not known here/);
      assert.equal(await page.getByTestId('view').getAttribute('data-objects'), null);
      assert.equal(await page.getByTestId('scene').innerText(), 'blocks');
      assert.equal(await page.getByTestId('scene-picker').inputValue(), '');
      await until('readings of the arm', async () => (await page.getByTestId('force').innerText()) === '0.00 N');
    }
    const [page] = browser.contexts().flatMap((context) => context.pages());
    assert.deepEqual(await violations(page), []);
    thimble('upload', scene_file('blocks'), '--device', board.address);
    for (const one of browser.contexts().flatMap((context) => context.pages())) {
      await until('the blocks', async () => (await one.getByTestId('view').getAttribute('data-objects')) === '3');
      assert.equal(await one.getByTestId('alert').count(), 0);
      assert.equal(await one.getByTestId('scene-picker').inputValue(), 'blocks');
    }
  } finally {
    await browser.close();
    await server.command.stop();
    await board.command.stop();
    rmSync(folder, { recursive: true });
  }
});
