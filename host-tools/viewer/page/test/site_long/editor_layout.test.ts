// The editor and the picture: a selection does not scroll the page, and a phone has room for both.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { until as until_soon } from '../browser/browser';
import { site_in_chromium } from '../site/chromium';

const until = (what: string, holds: () => Promise<boolean>): Promise<void> => until_soon(what, holds, 60_000);
const site = site_in_chromium();

const kPhone = { width: 390, height: 844 };

async function open(viewport: { width: number; height: number }, hasTouch = false): Promise<Page> {
  const context = await site.browser.newContext({ viewport, hasTouch, deviceScaleFactor: 0.5 });
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

// In the document, not the window.
const places = (page: Page): Promise<Record<string, string>> =>
  page.evaluate(() => {
    const parts = ['header', '#edit', '#stop', '.status', '#task', '#view', '.legend', '.scrub', '#gallery', '#readings', '#messages'];
    return Object.fromEntries(
      parts.map((part) => {
        const it = document.querySelector(part)!;
        const { x, y, width, height } = it.getBoundingClientRect();
        const top = getComputedStyle(it).position === 'fixed' ? 0 : scrollY;
        return [part, [x, y + top, width, height].map(Math.round).join(' ')];
      }),
    );
  });
const box_of = (page: Page, testid: string): Promise<{ top: number; bottom: number; left: number; right: number }> =>
  page.getByTestId(testid).evaluate((it) => it.getBoundingClientRect().toJSON());

for (const size of [kPhone, { width: 360, height: 640 }])
  test(
    `a phone of ${size.width} x ${size.height}: the editor opens, is used under the picture, and closes`,
    { timeout: 120_000 },
    async () => {
      const page = await open(size, true);
      const before = await places(page);
      await page.getByTestId('edit').tap();
      await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
      assert.deepEqual(await places(page), before, 'opened');
      const [view, editor] = [await box_of(page, 'view'), await box_of(page, 'editor')];
      assert.ok(view.top >= -1 && view.bottom <= editor.top + 1, `view ${view.top} to ${view.bottom}, editor from ${editor.top}`);
      const list = await box_of(page, 'editor-objects');
      assert.ok(list.bottom - list.top >= 100 && list.bottom <= size.height, 'the list shows some objects');
      assert.ok(editor.left >= 0 && editor.right <= size.width && editor.bottom <= size.height);
      const stop_is_free = (): Promise<boolean> =>
        page.getByTestId('stop').evaluate((it) => {
          const { left, right, top, bottom } = it.getBoundingClientRect();
          const at = document.elementFromPoint((left + right) / 2, (top + bottom) / 2);
          return bottom <= innerHeight && it.contains(at);
        });
      assert.ok(await stop_is_free());

      await page.getByTestId('editor-objects').selectOption({ index: 1 });
      await page.getByTestId('editor-position-0').fill('41');
      await page.getByTestId('editor-position-0').press('Enter');
      await until('the text to run', async () => (await page.getByTestId('editor-state').innerText()).startsWith('Runs'));
      await until('it in the text', async () => (await page.locator('.cm-content').innerText()).includes('0.041'));
      assert.ok((await box_of(page, 'view')).top >= -1, 'the picture is still in view');
      // Its end comes out from under Stop.
      await page.getByTestId('editor').evaluate((it) => it.scrollTo(0, it.scrollHeight));
      assert.ok((await box_of(page, 'editor-text')).bottom <= (await box_of(page, 'stop')).top);
      assert.ok(await stop_is_free());
      assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), size.width);
      assert.deepEqual(await places(page), before, 'used');

      await page.getByTestId('editor-close').tap();
      assert.equal(await page.getByTestId('editor').isVisible(), false);
      assert.deepEqual(await places(page), before, 'closed');
      await page.context().close();
    },
  );
