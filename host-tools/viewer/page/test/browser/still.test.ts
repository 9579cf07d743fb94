// What is drawn while nothing changes: nothing. A still picture is a full one.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';

import { until } from './browser';
import { show } from './harness';

const data = (page: Page) => page.getByTestId('view').evaluate((canvas: HTMLElement) => ({ ...canvas.dataset }));

async function at_rest(page: Page): Promise<number> {
  let before = -1;
  await until('a still picture', async () => {
    const was = before;
    before = Number((await data(page)).drawn);
    await page.waitForTimeout(1200); // the attributes are written once a second
    return was === before;
  });
  return before;
}

test('states that look the same are not drawn, and the still picture has every pixel', async () => {
  const { page, mock } = await show({}, { deviceScaleFactor: 1 });
  const drawn = await at_rest(page);
  const { tick } = await data(page);
  await page.waitForTimeout(2500);
  const later = await data(page);
  assert.ok(Number(later.tick) > Number(tick) + 4000, `telemetry goes on: tick ${tick}, then ${later.tick}`);
  assert.equal(Number(later.drawn), drawn, 'frames were drawn of a picture that had not changed');
  assert.ok(Number(later.skipped) > 30, `${later.skipped} frames skipped`);
  const size = await page.getByTestId('view').evaluate((it: HTMLCanvasElement) => [it.width, it.clientWidth, it.height, it.clientHeight]);
  assert.deepEqual([size[0], size[2]], [size[1], size[3]], 'pixels of the picture and of the page');

  // Less than is seen: not drawn. What is seen: drawn, with fewer pixels at first, without a graphics processor.
  mock.touch.move_hand(0, [1e-6, 0, 0]);
  assert.equal(await at_rest(page), drawn);
  mock.touch.move_hand(0, [0.01, 0, 0]);
  await until('a new picture', async () => Number((await data(page)).drawn) > drawn);
  await at_rest(page);
  assert.equal((await data(page)).ratio, '1');
  const now = Number((await data(page)).drawn);
  await page.getByLabel('View from further left').click();
  await until('the turned view', async () => Number((await data(page)).drawn) > now);
});
