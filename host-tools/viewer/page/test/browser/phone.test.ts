// The page at the size of a phone, 375 x 667.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';

import { until } from './browser';
import { arm, show, text } from './harness';

const kPhone = { viewport: { width: 375, height: 667 }, hasTouch: true };

const box = async (page: Page, testid: string) => {
  const it = await page.getByTestId(testid).first().boundingBox();
  assert.ok(it, testid);
  return { left: it.x, top: it.y, right: it.x + it.width, bottom: it.y + it.height };
};

for (const arms of [1, 2])
  test(`${arms} arm(s): picture, force, mode and Stop are seen without scrolling, and nothing is wider than the screen`, async () => {
    const { page, mock } = await show({ arms }, kPhone);
    await arm(page);
    mock.touch.move_hand(0, [0, -0.03, -0.03]);
    await until('a force', async () => ((await text(page, 'view-force')) ?? '').startsWith('2.0'));
    const [view, force, stop] = [await box(page, 'view'), await box(page, 'view-force'), await box(page, 'stop')];
    assert.ok(view.bottom <= 667 && view.bottom - view.top >= 220, JSON.stringify(view));
    assert.ok(force.top >= view.top && force.bottom <= view.bottom && force.right <= view.right, JSON.stringify(force));
    // Within reach of the thumb, and beside the picture rather than on it.
    assert.ok(stop.top > 667 / 2 && stop.bottom <= 667 && stop.right <= 375 && stop.bottom - stop.top >= 48, JSON.stringify(stop));
    assert.ok(stop.top >= view.bottom, `Stop begins at ${stop.top}, the picture ends at ${view.bottom}`);
    for (const id of ['mode', 'fault', 'link', 'disarm']) assert.ok((await box(page, id)).bottom <= 667, id);
    const wide = await page.evaluate(() => [document.documentElement.scrollWidth, document.body.scrollWidth, innerWidth]);
    assert.ok(wide[0] <= wide[2] && wide[1] <= wide[2], `${wide}`);
    assert.ok(view.top <= 240, `what is above the picture takes ${view.top} pixels`);
    for (const name of ['first', 'second']) mock.broadcast({ type: 'event', level: 'error', name, cause: 'a cause', remedy: 'a remedy' });
    await until('a banner', async () => /1 more/.test((await text(page, 'alerts-more')) ?? ''));
    const banner = await box(page, 'alert');
    assert.ok(banner.bottom <= stop.top && banner.top > (view.top + view.bottom) / 2, JSON.stringify(banner));
    // The buttons of the camera cover nothing, and nothing covers them.
    for (const button of await page.locator('.turns button').all()) {
      const it = (await button.boundingBox())!;
      assert.ok(it.y >= view.bottom && it.x >= view.left && it.x + it.width <= view.right, JSON.stringify({ it, view }));
      assert.ok(it.y + it.height <= banner.top, JSON.stringify({ it, banner }));
    }
    // The end of the page can be scrolled out from under Stop.
    await page.evaluate(() => window.scrollTo(0, document.body.scrollHeight));
    const end = (await page.locator('aside > section').last().boundingBox())!;
    assert.ok(end.y + end.height <= (await box(page, 'stop')).top, 'the last panel is under Stop');
  });
