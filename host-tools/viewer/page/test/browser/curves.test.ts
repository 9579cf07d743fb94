// Curves: zoom, values under the cursor, back to live, export; by mouse and by keys.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import type { Page } from 'playwright-core';

import { until } from './browser';
import { type Shown, arm, show, text } from './harness';

const values = async (page: Page): Promise<number[]> =>
  ((await text(page, 'curve-values')) ?? '').match(/-?\d+(\.\d+)?/g)?.map(Number) ?? [];
const lines_of = (csv: string) => csv.trimEnd().split('\n').map((line) => line.split(',')); // prettier-ignore

async function exported(page: Page): Promise<{ head: string[]; rows: number[][]; name: string }> {
  const [file] = await Promise.all([page.waitForEvent('download'), page.getByTestId('curves-export').click()]);
  const [head, ...rows] = lines_of(readFileSync(await file.path(), 'utf8'));
  return { head, rows: rows.map((row) => row.map(Number)), name: file.suggestedFilename() };
}

// Two seconds of nothing, then a force.
async function pressed(arms = 1): Promise<Shown> {
  const shown = await show({ arms });
  const { page, mock } = shown;
  await arm(page);
  for (let i = 0; i < arms; ++i) mock.touch.move_hand(i, [i * 0.05, -0.03, 0]);
  await page.waitForTimeout(2000);
  mock.touch.move_hand(0, [0, -0.03, -0.03]);
  await page.waitForTimeout(1000);
  return shown;
}

async function over(page: Page): Promise<{ x: number; y: number; width: number }> {
  await page.locator('.u-over').first().scrollIntoViewIfNeeded();
  const box = (await page.locator('.u-over').first().boundingBox())!;
  return { x: box.x, y: box.y + box.height / 2, width: box.width };
}

test('the cursor reads all curves at one time; a drag zooms and stands still; the button and a double click go live', async () => {
  const { page } = await pressed();
  const { x, y, width } = await over(page);
  const at = (share: number) => page.mouse.move(x + share * width, y, { steps: 3 });
  await at(0.96); // 0.4 s ago, of 10
  await until('a value of 0.4 s ago', async () => Math.abs((await values(page))[0] + 0.4) < 0.3); // late on a loaded machine
  const [, force_N, depth_mm, speed, energy_mJ] = await values(page);
  assert.ok(
    Math.abs(force_N - 2) < 0.1 && Math.abs(depth_mm - 2) < 0.1 && speed === 0 && energy_mJ < -1,
    (await text(page, 'curve-values')) ?? '',
  );

  for (const back of [() => page.getByTestId('curves-live').click(), () => page.mouse.dblclick(x + width / 2, y)]) {
    await at(0.8);
    await page.mouse.down();
    await at(0.95);
    await page.mouse.up();
    await until('a pause', async () => (await text(page, 'pause')) === 'Go live');
    await page.waitForTimeout(300);
    const { rows } = await exported(page);
    const span_s = rows.at(-1)![0] - rows[0][0];
    assert.ok(span_s > 1.1 && span_s < 1.55, `${span_s} s of a drag across 1.5 s`);
    await page.waitForTimeout(300);
    assert.deepEqual((await exported(page)).rows, rows, 'it stands still');
    await back();
    await until('live', async () => (await text(page, 'pause')) === 'Pause');
    const { y: now } = await over(page);
    assert.equal(now, y);
  }
});

test('by keys alone: the cursor, zoom in and out, live', async () => {
  const { page } = await pressed();
  await page.getByTestId('curves-export').focus();
  await page.keyboard.press('Tab');
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'plots');
  assert.notEqual(await page.getByTestId('plots').evaluate((it) => getComputedStyle(it).outlineStyle), 'none');
  await page.keyboard.press('ArrowLeft');
  await until('a value', async () => (await values(page)).length === 5);
  const [first] = await values(page);
  await page.keyboard.press('Shift+ArrowLeft');
  await until('a second before', async () => Math.abs((await values(page))[0] - first + 1) < 0.3);
  const span = async () => {
    const { rows } = await exported(page);
    await page.getByTestId('plots').focus();
    return rows.at(-1)![0] - rows[0][0];
  };
  await page.keyboard.press('+');
  await page.keyboard.press('+');
  await until('a pause', async () => (await text(page, 'pause')) === 'Go live');
  await page.waitForTimeout(300);
  const near = await span();
  assert.ok(near > 1.8 && near < 2.6, `${near} s of a quarter of 10 s`);
  await page.keyboard.press('-');
  await page.waitForTimeout(300);
  assert.ok((await span()) > near + 0.3);
  await page.keyboard.press('l');
  await until('live', async () => (await text(page, 'pause')) === 'Pause');
});

test('what is exported has a header with units, a line a state, and both arms', async () => {
  const { page } = await pressed(2);
  await page.getByTestId('pause').click();
  await page.waitForTimeout(300);
  const { head, rows, name } = await exported(page);
  assert.equal(name, 'thimble-curves.csv');
  assert.equal(
    head.join(),
    'time_s,force_N,force_1_N,depth_mm,depth_1_mm,speed_mm_per_s,speed_1_mm_per_s,energy_mJ,energy_1_mJ', // prettier-ignore
  );
  assert.ok(rows.length > 60 && rows.every((row) => row.length === head.length && row.every(Number.isFinite)), `${rows.length} rows`);
  assert.ok(rows.every((row, i) => i === 0 || row[0] > rows[i - 1][0]));
  assert.ok(Math.abs(rows.at(-1)![1] - 2) < 0.05 && rows.at(-1)![2] === 0, `${rows.at(-1)}`);
});
