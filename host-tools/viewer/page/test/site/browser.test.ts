// The site in Chromium, from a folder of a host that sends no special headers: the device starts by itself, a drag down is felt, the page stops, works
// without the network, and loses no ticks that it does not count.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { site_in_chromium } from './chromium';

const kTimeout_ms = 60_000;

const site = site_in_chromium();

const text = (page: Page, name: string): Promise<string> => page.getByTestId(name).innerText();
const mode = (page: Page, wanted: string): Promise<unknown> =>
  page.waitForFunction((it) => document.querySelector('[data-testid=mode]')?.textContent === it, wanted, { timeout: kTimeout_ms });

// Pixels of dragging down from the middle of the view until a force is shown.
async function drag_down(page: Page): Promise<number> {
  const box = await page.getByTestId('view').boundingBox();
  assert.ok(box);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let pixels = 5; pixels <= 120; pixels += 5) {
    await page.mouse.move(x, y + pixels);
    await page.waitForTimeout(60);
    if (Number.parseFloat(await text(page, 'force')) > 0.1) return pixels;
  }
  return Number.POSITIVE_INFINITY;
}

test('the device starts by itself, is felt within 90 px, and stops', { timeout: 2 * kTimeout_ms }, async () => {
  const page = await site.browser.newPage({ viewport: { width: 1280, height: 800 } });
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address);
  await mode(page, 'armed');
  await page.waitForFunction(() => Number(document.querySelector<HTMLElement>('#view')?.dataset.objects) > 0, null, {
    timeout: kTimeout_ms,
  });
  assert.ok((await drag_down(page)) <= 90);
  await page.mouse.up();
  await page.getByTestId('stop').click();
  await page.waitForFunction(() => document.querySelector('[data-testid=mode]')?.textContent !== 'armed', null, { timeout: 5000 });
  assert.equal(await text(page, 'link'), 'live');
  assert.deepEqual(errors, []);
  await page.close();
});

test('it starts again without the network', { timeout: 3 * kTimeout_ms }, async () => {
  const context = await site.browser.newContext();
  const page = await context.newPage();
  await page.goto(site.address);
  await mode(page, 'armed');
  await page.evaluate(() => navigator.serviceWorker.ready);
  await context.setOffline(true);
  await page.reload();
  await mode(page, 'armed');
  await page.getByTestId('scene-picker').selectOption('walls'); // a scene that was not open before
  await page.getByTestId('load').click();
  await page.waitForFunction(() => document.querySelector('[data-testid=scene]')?.textContent === 'walls', null, { timeout: kTimeout_ms });
  await context.close();
});

test('with the second arm chosen, a scene for one arm is felt', { timeout: 3 * kTimeout_ms }, async () => {
  const page = await site.browser.newPage({ viewport: { width: 1280, height: 800 } });
  const load = async (scene: string): Promise<void> => {
    await page.getByTestId('scene-picker').selectOption(scene);
    await page.getByTestId('load').click();
    await page.waitForFunction((it) => document.querySelector('[data-testid=scene]')?.textContent === it, scene, { timeout: kTimeout_ms });
    await mode(page, 'armed');
  };
  await page.goto(site.address);
  await mode(page, 'armed');
  await load('blocks');
  await page.getByLabel('arm 1').check();
  await load('walls');
  assert.ok((await drag_down(page)) <= 90);
  assert.equal(await page.getByTestId('alert').count(), 0);
  await page.close();
});
