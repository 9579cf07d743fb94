// The editor and the picture: a selection does not scroll the page.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { until as until_soon } from '../browser/browser';
import { site_in_chromium } from './chromium';

const until = (what: string, holds: () => Promise<boolean>): Promise<void> => until_soon(what, holds, 60_000);
const site = site_in_chromium();

async function open(viewport: { width: number; height: number }): Promise<Page> {
  const context = await site.browser.newContext({ viewport, deviceScaleFactor: 0.5 });
  const page = await context.newPage();
  await page.goto(site.address);
  await until('the scene', async () => (await page.getByTestId('scene').innerText()) === 'buttons');
  await until('the gallery', async () => (await page.getByTestId('gallery').locator('li').count()) > 3);
  return page;
}
async function edit(page: Page): Promise<void> {
  await page.getByTestId('edit').click();
  await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
}
const scrolled = (page: Page): Promise<number> => page.evaluate(() => scrollY);
const text_scrolled = (page: Page): Promise<number> => page.locator('.cm-scroller').evaluate((it) => it.scrollTop);

test('a selection scrolls the text to the object, and not the page', { timeout: 120_000 }, async () => {
  const page = await open({ width: 1280, height: 500 }); // the text is below the fold
  await edit(page);
  const list = page.getByTestId('editor-objects');
  await list.scrollIntoViewIfNeeded();
  const before = await scrolled(page);
  const box = (await page.getByTestId('editor-text').boundingBox())!;
  assert.ok(box.y + box.height > 500, 'the text is not all in view');
  const last = (await list.locator('option').count()) - 1;
  await list.evaluate((it, index) => {
    (it as HTMLSelectElement).selectedIndex = index;
    it.dispatchEvent(new Event('change'));
  }, last);
  await until('the text to be scrolled', async () => (await text_scrolled(page)) > 0);
  await page.waitForTimeout(300);
  assert.equal(await scrolled(page), before);
  // The line of the object is in the part of the text that is shown.
  const [top, bottom, line] = await page.evaluate(() => {
    const text = document.querySelector('.cm-scroller')!.getBoundingClientRect();
    return [text.top, text.bottom, document.querySelector('.cm-activeLine')!.getBoundingClientRect().top];
  });
  assert.ok(line > top && line < bottom, `${line} of ${top} to ${bottom}`);
  // Undo shows what it does in the text alone, too.
  await page.getByTestId('editor-duplicate').click();
  await page.waitForTimeout(300);
  await page.getByTestId('editor-undo').scrollIntoViewIfNeeded();
  const at_undo = await scrolled(page);
  await page.getByTestId('editor-undo').click();
  await page.waitForTimeout(300);
  assert.equal(await scrolled(page), at_undo);
  await page.context().close();
});
