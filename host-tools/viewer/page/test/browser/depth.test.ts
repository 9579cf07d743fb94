// How far the tip is from what lies below and around it, in the picture; and the way out of what it is inside of.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';

import { pixels_near, until } from './browser';
import { arm, show, text } from './harness';

// Under the disc of the contact plane, which is translucent.
const kTouch: [number, number, number] = [0xe0, 0x14, 0x7a];
const kWayOut: [number, number, number] = [0xb3, 0x00, 0x1b];

const data = (page: Page) => page.getByTestId('view').evaluate((canvas: HTMLElement) => ({ ...canvas.dataset }));

test('the clearance to the nearest surface, what lies below, and the colour of touching', async () => {
  const { page, mock } = await show({}, { deviceScaleFactor: 1 });
  mock.touch.move_hand(0, [0, -0.03, -0.01]); // 10 mm over the near block
  await until('10 mm', async () => (await data(page)).clearanceMm === '10.00');
  assert.equal((await data(page)).nearest, 'near block');
  assert.equal((await data(page)).below, 'near block');
  mock.touch.move_hand(0, [0.05, -0.06, -0.01]);
  await until('the table below', async () => (await data(page)).below === 'table');
  mock.touch.move_hand(0, [0, -0.03, -0.015]);
  await until('the block again', async () => (await data(page)).below === 'near block');
  await page.waitForTimeout(800);
  const apart = await pixels_near(page, kTouch, 45);
  await arm(page);
  mock.touch.move_hand(0, [0, -0.03, -0.024]);
  await until('it touches', async () => Number((await data(page)).clearanceMm) < 0);
  await page.waitForTimeout(800);
  const touching = await pixels_near(page, kTouch, 45);
  assert.ok(touching > apart + 20, `${apart} pixels of the colour of touching before, ${touching} after`);
});

test('the shadow of the tip is there without the shadows of the light', async () => {
  const { page, mock } = await show({ scene: 'stick-slip' }, { deviceScaleFactor: 1 });
  mock.touch.move_hand(0, [0.04, 0, 0.06]);
  await until('there', async () => Number((await data(page)).clearanceMm) > 20);
  await page.waitForTimeout(800);
  const black = () => pixels_near(page, [0x30, 0x30, 0x30], 60);
  const high = await black();
  const { clearanceMm } = await data(page);
  mock.touch.move_hand(0, [0.04, 0, 0.06 - (Number(clearanceMm) - 4) / 1000]);
  await until('low', async () => Math.abs(Number((await data(page)).clearanceMm) - 4) < 0.1);
  await page.waitForTimeout(800);
  const low = await black();
  assert.ok(low > high + 20, `${high} dark pixels when it is high, ${low} when it is low`);
});

test('a tip inside an object is told the way out, in words and by an arrow', async () => {
  const { page, mock } = await show({}, { deviceScaleFactor: 1 });
  mock.touch.move_hand(0, [0, -0.03, -0.026]);
  await page.waitForTimeout(800);
  const before = await pixels_near(page, kWayOut);
  await arm(page);
  await until('the words', async () => (await text(page, 'inside')) === 'Inside: move up by 6 mm to leave near block.');
  await page.waitForTimeout(800);
  assert.ok((await pixels_near(page, kWayOut)) > before + 15, 'an arrow');
  const [words, frame] = await Promise.all(['inside', 'view'].map((id) => page.getByTestId(id).boundingBox()));
  assert.ok(words && frame && words.y > frame.y && words.y + words.height < frame.y + frame.height, 'in the view');
  mock.touch.move_hand(0, [0, -0.03, -0.01]);
  await until('outside', async () => (await text(page, 'inside')) === '');
});
