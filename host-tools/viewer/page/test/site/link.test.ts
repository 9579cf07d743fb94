// A scene's link in Chromium: it is made, opened, felt, refused where it is damaged or too much, and taken where the page is open already.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import type { Browser, Page } from 'playwright-core';

import { launch } from '../browser/browser';
import { violations } from '../browser/page_checks';
import { scene_fragment } from '../../src/scene_link';
import { serve_site } from './serve';

const kTimeout_ms = 60_000;

let browser: Browser;
let site: Awaited<ReturnType<typeof serve_site>>;

before(async () => {
  site = await serve_site();
  browser = await launch();
});
after(async () => {
  await browser.close();
  site.server.close();
});

const scene = (name: string, shape: object): string =>
  JSON.stringify({ thimble_scene: 1, name, objects: [{ name: 'it', shape, material: { stiffness_N_m: 800, damping_N_s_m: 1 } }] });
const mesh = (file: string) => ({ mesh: { file, scale: 0.001, crease_deg: 40, side: 'outside' } });
const table = { plane: { normal: [0, 0, 1], offset_m: -0.01 } };

const shows = (page: Page, id: string, wanted: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent?.includes(it), [id, wanted], {
    timeout: kTimeout_ms,
  });

test('a link opens its scene, which is felt; another link replaces it; a bad one is told', { timeout: 4 * kTimeout_ms }, async () => {
  const context = await browser.newContext({ permissions: ['clipboard-read', 'clipboard-write'] });
  const page = await context.newPage();
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address + (await scene_fragment({ name: 'table', text: scene('A table of mine', table) })));
  await shows(page, 'scene', 'A table of mine');
  await shows(page, 'mode', 'armed');
  assert.equal(await page.getByTestId('scene-picker').inputValue(), 'table (link)');
  await page.getByTestId('view').focus();
  await page.keyboard.down('ArrowDown');
  await page.waitForFunction(() => Number.parseFloat(document.querySelector('[data-testid=force]')?.textContent ?? '') > 0.3, null, {
    timeout: kTimeout_ms,
  });
  await page.keyboard.up('ArrowDown');

  const go = (fragment: string) => page.evaluate((it) => void (location.hash = it), fragment);
  // Files of the gallery come with the page.
  await go(await scene_fragment({ name: 'ring', folder: 'ring', text: scene('Another ring', mesh('ring.obj')) }));
  await shows(page, 'scene', 'Another ring');
  // What it has not is told by the compiler, as for other scenes.
  await go(await scene_fragment({ name: 'mine', text: scene('None', mesh('mine.obj')) }));
  await shows(page, 'alerts', 'mine.obj');
  await go('#scene=AAAA');
  await shows(page, 'alerts', 'bad-link');
  assert.equal(await page.getByTestId('scene').innerText(), 'Another ring');

  await page.getByTestId('share-link').click();
  await shows(page, 'share-said', 'is copied');
  const copied = await page.evaluate(() => navigator.clipboard.readText());
  assert.equal(copied, await page.getByTestId('share-address').inputValue());
  assert.deepEqual(await violations(page), []);

  // That of an untouched scene of the gallery is that scene; to pick one ends the link.
  await page.getByTestId('scene-picker').selectOption('walls');
  await page.getByTestId('load').click();
  await shows(page, 'scene', 'walls');
  assert.equal(await page.evaluate(() => location.hash), '');
  await context.clearPermissions();
  await page.getByTestId('share-link').click();
  await page.waitForFunction(() => (document.querySelector('[data-testid=share-address]') as HTMLInputElement).value !== '');
  const walls = await page.getByTestId('share-address').inputValue();

  await page.goto('about:blank');
  await page.goto(copied);
  await shows(page, 'scene', 'Another ring');
  await page.evaluate((it) => void (location.href = it), walls);
  await shows(page, 'scene', 'walls');
  assert.equal(await page.getByTestId('scene-picker').inputValue(), 'walls');
  assert.deepEqual(errors, []);
  await context.close();
});
