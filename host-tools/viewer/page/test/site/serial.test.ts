// A board on a serial port of the browser (board.ts): listed, uploaded to, homed, armed, watched, stopped; unplugged and plugged in again; and with a
// scene of another host on it.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';

import type { Page } from 'playwright-core';

import { violations } from '../browser/page_checks';
import { scene_file, thimble_beside } from '../real/command';
import { Board } from './board';
import { site_in_chromium } from './chromium';

const kTimeout_ms = 60_000;

const site = site_in_chromium();
let board: Board;
before(async () => {
  board = await Board.start();
});
after(() => board.stop());

async function open_page(): Promise<Page> {
  const page = await site.browser.newPage();
  await board.put_into(page);
  await page.goto(site.address);
  await shows(page, 'mode', 'armed'); // the device in the page
  return page;
}

const text = (page: Page, name: string): Promise<string> => page.getByTestId(name).innerText();
const shows = (page: Page, name: string, wanted: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent === it, [name, wanted], {
    timeout: kTimeout_ms,
  });

test('a board on USB with no host software', { timeout: 4 * kTimeout_ms }, async () => {
  const page = await open_page();
  await page.getByTestId('board').click();
  await shows(page, 'mode', 'disarmed');
  assert.ok((await page.locator('#device').innerText()).includes('serial port'));

  await page.getByTestId('scene-picker').selectOption('walls');
  await page.getByTestId('load').click();
  await shows(page, 'scene', 'walls');
  await page.getByTestId('home').click();
  await shows(page, 'mode', 'ready');
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed');
  assert.equal(await text(page, 'link'), 'live');
  await page.getByTestId('stop').click();
  await shows(page, 'mode', 'faulted');

  board.unplug();
  await shows(page, 'link', 'controller lost');
  await shows(page, 'link', 'live'); // the fake is plugged in again at once
  await page.getByTestId('clear').click();
  await shows(page, 'mode', 'ready');

  await page.evaluate('globalThis.cancels = true');
  await page.getByTestId('board').click();
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed'); // who chooses no other board keeps this one
  await page.evaluate('delete globalThis.cancels');
  await page.getByTestId('board').click(); // the same one again
  await shows(page, 'link', 'live');
  await page.getByTestId('disarm').click();
  await shows(page, 'mode', 'ready');
  await page.close();
});

const shows_part = (page: Page, name: string, part: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent?.includes(it), [name, part], {
    timeout: kTimeout_ms,
  });
const draws = (page: Page, objects: string | null): Promise<unknown> =>
  page.waitForFunction((it) => document.querySelector('[data-testid=view]')?.getAttribute('data-objects') === it, objects, {
    timeout: kTimeout_ms,
  });

test(
  'a scene of the gallery that the board runs already is drawn; of another one the page says that it is not known',
  { timeout: 5 * kTimeout_ms },
  async () => {
    const folder = mkdtempSync(join(tmpdir(), 'thimble-serial-'));
    const upload = (scene: string): Promise<unknown> => thimble_beside('upload', scene, '--device', board.tcp);
    const foreign = (name: string): Promise<unknown> => {
      const file = join(folder, `${name}.scene.json`);
      const floor = {
        name: 'floor',
        shape: { plane: { normal: [0, 0, 1], offset_m: -0.031 } },
        material: { stiffness_N_m: 432, damping_N_s_m: 1 },
      };
      writeFileSync(file, JSON.stringify({ thimble_scene: 1, name, objects: [floor] }));
      return upload(file);
    };
    try {
      await upload(scene_file('ring')); // it names a file
      const page = await open_page();
      const errors: string[] = [];
      page.on('pageerror', (error) => errors.push(String(error)));
      await page.getByTestId('board').click();
      await shows(page, 'scene', 'ring on a table');
      await draws(page, '2');
      assert.equal(await page.getByTestId('scene-picker').inputValue(), 'ring');
      assert.equal(await page.getByTestId('alerts').innerText(), '');
      assert.ok(await page.getByTestId('edit').isEnabled());
      await page.getByTestId('share-link').click();
      await page.waitForFunction(() =>
        (document.querySelector('[data-testid=share-address]') as HTMLInputElement).value.includes('#scene='),
      );
      await page.getByTestId('edit').click();
      await shows(page, 'editor-state', 'Runs.');

      // One that another host gives it meanwhile, and one that has only the name of a scene here.
      for (const name of ['elsewhere', 'walls']) {
        await foreign(name);
        await shows(page, 'scene', name);
        await shows_part(page, 'alerts', `the device runs "${name}", a scene that is not known here`);
        if (name === 'elsewhere') {
          await shows(page, 'editor-state', 'The text of the scene that runs is not known here.');
          await page.getByTestId('editor-close').click();
        }
        await draws(page, null);
        assert.equal(await page.getByTestId('alert').count(), 1, await text(page, 'messages'));
        assert.equal(await page.getByTestId('scene-picker').inputValue(), '');
        assert.ok(await page.getByTestId('edit').isDisabled());
        assert.equal(await text(page, 'link'), 'live');
        const tick = await page.getByTestId('view').getAttribute('data-tick');
        await page.waitForFunction((it) => document.querySelector<HTMLElement>('[data-testid=view]')?.dataset.tick !== it, tick);
      }
      assert.deepEqual(await violations(page), []);
      await page.getByTestId('record').click();
      await shows_part(page, 'alerts', 'a recording contains its scene');

      await page.getByTestId('scene-picker').selectOption('walls');
      await page.getByTestId('load').click();
      await draws(page, '5');
      await page.getByTestId('edit').click();
      await shows(page, 'editor-state', 'Runs.');
      assert.ok(!(await page.getByTestId('alerts').innerText()).includes('scene-unknown'));
      assert.deepEqual(errors, []);
      await page.close();
    } finally {
      rmSync(folder, { recursive: true });
    }
  },
);
