// axe-core on the page in both themes at phone and desktop sizes; and that nothing moves while it connects and runs.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { until } from './browser';
import { arm, show, text } from './harness';
import { assert_accessible, moved } from './page_checks';

test('axe finds nothing: at rest, armed and inside, faulted, lost', async () => {
  const { page, mock } = await show({ arms: 2 });
  await page.locator('#parameters-panel summary').click();
  await assert_accessible(page, 'at rest');
  mock.touch.move_hand(0, [0, -0.03, -0.026]);
  await page.waitForTimeout(200);
  await arm(page);
  await until('inside', async () => (await text(page, 'inside')) !== '');
  await assert_accessible(page, 'armed and inside');
  mock.touch.trip(7, 'tip_velocity');
  await until('the banner', async () => (await page.getByTestId('alert').count()) === 1);
  await assert_accessible(page, 'faulted');
  mock.set_link(false);
  await until('the loss', async () => (await text(page, 'mode')) === 'unknown');
  await assert_accessible(page, 'lost');
});

for (const arms of [1, 2])
  for (const viewport of [
    { width: 375, height: 667 },
    { width: 1280, height: 800 },
  ])
    test(`nothing moves while the page connects, runs, is armed, faults and loses its link: ${arms} arms, ${viewport.width} pixels`, async () => {
      const { page, mock } = await show({ arms }, { viewport });
      await arm(page);
      mock.touch.move_hand(0, [0, -0.03, -0.03]);
      await page.waitForTimeout(1000);
      mock.touch.trip(7, 'encoder_frozen');
      await page.waitForTimeout(500);
      mock.set_link(false);
      await until('the loss', async () => (await text(page, 'mode')) === 'unknown');
      assert.deepEqual(await moved(page), []);
    });

test('what can be used has a name, is reached by Tab, and shows the focus', async () => {
  const { page } = await show({ arms: 2 });
  await arm(page);
  const all: string[] = await page.evaluate(() =>
    [...document.querySelectorAll<HTMLElement>('a[href], button, input, select, summary, [tabindex="0"]')]
      .filter((it) => it.checkVisibility() && !(it as HTMLButtonElement).disabled && !it.closest('.skip'))
      // Of radio buttons only the chosen one is reached by Tab, the others by arrows.
      .filter((it) => !(it instanceof HTMLInputElement && it.type === 'radio' && !it.checked))
      .map((it, i) => (it.dataset.stop = `${i}`)),
  );
  const seen = new Set<string>();
  await page.evaluate(() => (document.activeElement as HTMLElement).blur());
  for (let i = 0; i < all.length + 10; ++i) {
    await page.keyboard.press('Tab');
    const now = await page.evaluate(() => {
      const it = document.activeElement as HTMLElement;
      return { stop: it.dataset.stop, outline: getComputedStyle(it).outlineStyle, html: it.outerHTML.slice(0, 80) };
    });
    if (now.stop === undefined) continue;
    assert.notEqual(now.outline, 'none', now.html);
    seen.add(now.stop);
  }
  assert.deepEqual(
    all.filter((stop) => !seen.has(stop)),
    [],
  );
});
