// The page in Chromium, served by the real `thimble commission --simulate --page`.
import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import type { Browser, BrowserContextOptions, Page } from 'playwright-core';

import { launch, pixels_near, until } from '../browser/browser';
import { violations } from '../browser/page_checks';
import { Command, kTop } from './command';

const kAxisColor: [number, number, number] = [0xd6, 0x24, 0x9f];
const kWayColor: [number, number, number] = [0xff, 0x7a, 0x00];
const kUnread_ms = 550; // until a new prompt can be answered

let browser: Browser;
let ends: (() => unknown)[] = [];
before(async () => {
  browser = await launch();
});
after(async () => browser.close());
afterEach(async () => {
  const all = ends.reverse();
  ends = [];
  for (const end of all) await end();
});

async function commission(arm: string, ...words: string[]): Promise<{ url: string; command: Command }> {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-commission-'));
  ends.push(() => rmSync(folder, { recursive: true }));
  const file = join(folder, `${arm}.arm.json`);
  cpSync(join(kTop, 'arms', `${arm}.arm.json`), file);
  const all = ['commission', file, '--simulate', '--page', '--no-browser', ...words];
  const [command, lines] = await Command.start('thimble', all, (line) => line.startsWith('page: '), 'stderr');
  ends.push(() => command.stop());
  return { url: lines.at(-1)!.slice('page: '.length), command };
}

async function show(url: string, context: BrowserContextOptions = {}): Promise<Page> {
  const page = await browser.newPage({ viewport: { width: 640, height: 720 }, deviceScaleFactor: 1, ...context });
  const errors: string[] = [];
  page.on('console', (message) => {
    if (message.text().includes('Content Security Policy')) errors.push(message.text().slice(0, 200));
  });
  page.on('pageerror', (error) => errors.push(error.message));
  ends.push(async () => {
    await page.close();
    assert.deepEqual(errors, [], 'the page threw');
  });
  await page.goto(url);
  await until('a prompt', async () => ((await text(page, 'prompt')) ?? '') !== '');
  return page;
}

const text = (page: Page, testid: string) => page.getByTestId(testid).textContent();
const says = (page: Page, wanted: RegExp) => async () => wanted.test((await text(page, 'prompt')) ?? '');

// By the keyboard: the button keeps the focus from prompt to prompt.
async function answer_with_enter(page: Page, next: RegExp): Promise<void> {
  await page.waitForTimeout(kUnread_ms);
  await page.keyboard.press('Enter');
  await until(`${next}`, says(page, next));
}

test('prompts are answered on the page; the axis in question and the way to turn it are in the picture', async () => {
  const { url } = await commission('premium-1.5');
  const page = await show(url);
  await until('the first prompt', says(page, /^Press the e-stop\.$/));
  assert.equal(await page.getByTestId('step-0').getAttribute('data-state'), 'now');
  assert.equal(await page.getByTestId('prompt').getAttribute('aria-live'), 'polite');
  assert.equal(await page.getByTestId('answer-decline').isVisible(), false);
  assert.equal(await page.getByTestId('home').isVisible(), false, 'what is of `thimble view` only');
  await until('the links', async () => Number(await page.getByTestId('view').getAttribute('data-links')) === 2);
  assert.equal(await pixels_near(page, kAxisColor), 0);
  await page.getByTestId('answer-done').focus();
  await answer_with_enter(page, /dead-man/);
  await answer_with_enter(page, /silent/);
  await answer_with_enter(page, /hands off/);
  assert.equal(await page.getByTestId('step-0').getAttribute('data-state'), 'passed');
  await answer_with_enter(page, /'yaw' in the middle.*first so that the tip moves/);
  assert.equal(await page.getByTestId('view').getAttribute('data-axis'), 'yaw');
  assert.match((await text(page, 'picture-text')) ?? '', /The axis in question is yaw/);
  await until(
    'axis and way in the picture',
    async () => (await pixels_near(page, kAxisColor)) > 40 && (await pixels_near(page, kWayColor)) > 40,
  );
  // A prompt that has just come is not answered by a second press.
  await page.waitForTimeout(kUnread_ms);
  await page.keyboard.press('Enter');
  await until('the other way', says(page, /once there and back/));
  const asked = await text(page, 'prompt');
  await page.keyboard.press('Enter');
  await page.waitForTimeout(150);
  assert.equal(await text(page, 'prompt'), asked);
});

test('on a phone the prompt, its button and Stop are in sight; a page without the token may only look and stop', async () => {
  const { url, command } = await commission('paddle');
  const size = { width: 390, height: 700 };
  const owner = await show(url, { viewport: size, deviceScaleFactor: 1 });
  for (const id of ['prompt', 'answer-done', 'stop']) {
    const box = await owner.getByTestId(id).boundingBox();
    assert.ok(box && box.x >= 0 && box.x + box.width <= size.width && box.y >= 0 && box.y + box.height <= size.height, id);
  }
  assert.ok(await owner.evaluate(() => document.documentElement.scrollWidth <= innerWidth), 'nothing is wider than the screen');
  const stranger = await show(url.replace(/token=.*/, ''), { viewport: size });
  assert.ok(await stranger.getByTestId('read-only').isVisible());
  assert.equal(await stranger.getByTestId('answer-done').getAttribute('aria-disabled'), 'true');
  await stranger.getByTestId('stop').click();
  await until('the end', says(owner, /stopped in step 0/));
  await until('the exit', () => command.exit_code !== null);
  assert.equal(command.exit_code, 1);
  await owner.waitForTimeout(400); // the server is gone: no alarm, it was the end
  assert.equal(await owner.getByTestId('notice').isVisible(), false);
  assert.match((await text(owner, 'prompt')) ?? '', /stopped in step 0/);
});

// In both themes, on a phone and on a desk.
async function assert_accessible(page: Page, when: string): Promise<void> {
  for (const colorScheme of ['light', 'dark'] as const)
    for (const size of [
      { width: 375, height: 667 },
      { width: 1280, height: 800 },
    ]) {
      await page.emulateMedia({ colorScheme });
      await page.setViewportSize(size);
      assert.deepEqual(await violations(page), [], `${when}, ${colorScheme}, ${size.width} x ${size.height}`);
    }
}

test('axe finds nothing: at the first prompt, with an axis in question, at the end, and for who may only look', async () => {
  const { url } = await commission('premium-1.5');
  const page = await show(url);
  const stranger = await show(url.replace(/token=.*/, ''));
  await until('the first prompt', says(page, /^Press the e-stop\.$/));
  await assert_accessible(page, 'the first prompt');
  await assert_accessible(stranger, 'without the token');
  await page.getByTestId('answer-done').focus();
  for (const next of [/dead-man/, /silent/, /hands off/, /'yaw' in the middle/]) await answer_with_enter(page, next);
  await assert_accessible(page, 'an axis in question');
  await page.getByTestId('stop').click();
  await until('the end', says(page, /stopped in step/));
  await assert_accessible(page, 'the end');
});
