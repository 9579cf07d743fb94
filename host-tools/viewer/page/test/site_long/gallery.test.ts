// The site as a new user meets it: the gallery, the task of a scene and the ghost that does it, on a desk and on phones.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';

import type { BrowserContextOptions, Page } from 'playwright-core';

import { moved, moves, violations } from '../browser/page_checks';
import { site_in_chromium } from '../site/chromium';

const kTimeout_ms = 60_000;

const site = site_in_chromium();
const errors: string[] = [];
after(() => assert.deepEqual(errors, []));

async function open(options: BrowserContextOptions): Promise<Page> {
  const page = await site.browser.newPage(options);
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address);
  await shows(page, 'mode', 'armed');
  return page;
}
const shows = (page: Page, id: string, wanted: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent?.startsWith(it), [id, wanted], {
    timeout: kTimeout_ms,
  });

for (const [width, height] of [
  [360, 640],
  [390, 844],
])
  test(`a phone of ${width} x ${height}: force, task and Stop are seen without scrolling`, { timeout: 2 * kTimeout_ms }, async () => {
    const page = await open({ viewport: { width, height }, hasTouch: true, isMobile: true });
    const box = async (id: string) => {
      const it = (await page.getByTestId(id).first().boundingBox())!;
      return { left: it.x, top: it.y, right: it.x + it.width, bottom: it.y + it.height };
    };
    const [stop, view, task, show, force] = await Promise.all(['stop', 'view', 'task', 'show-me', 'view-force'].map(box));
    for (const it of [view, task, show, force])
      assert.ok(it.top >= 0 && it.bottom <= stop.top && it.left >= 0 && it.right <= width, JSON.stringify({ it, stop }));
    assert.ok(stop.bottom <= height && view.bottom - view.top >= 200, JSON.stringify({ stop, view }));
    const text = (await page.getByTestId('task-text').boundingBox())!;
    assert.ok(text.y + text.height <= view.top + 1, 'the task is written over the picture');
    // The gallery begins on the first screen.
    assert.ok((await box('gallery')).top < height);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width);
    assert.deepEqual(await violations(page), []);
    assert.deepEqual(await moved(page), []);
    await page.close();
  });

// Something is felt while it shows.
const led_by_the_ghost = (page: Page, force: string): Promise<unknown> =>
  page.waitForFunction(
    (id) => {
      const force_N = Number.parseFloat(document.querySelector(`[data-testid=${id}]`)?.textContent ?? '');
      return force_N > 0.5 && document.getElementById('task-mark')?.textContent === 'Watch:';
    },
    force,
    { timeout: kTimeout_ms },
  );

test('the ghost shows the task, the user does it, and that is remembered', { timeout: 3 * kTimeout_ms }, async () => {
  const context = await site.browser.newContext({ viewport: { width: 1280, height: 800 } });
  const page = await context.newPage();
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address);
  await shows(page, 'mode', 'armed');
  await page.waitForFunction(() => (document.querySelector('#gallery img') as HTMLImageElement | null)?.naturalWidth);
  assert.equal(await page.locator('#gallery li').count(), 24);
  await page.waitForFunction(() => /^\d+ lost$/.test(document.querySelector('[data-testid=lost-ticks]')?.textContent ?? ''));

  // Another scene from its card; its task is told.
  await page.locator('#gallery [data-scene=deform]').click();
  await shows(page, 'scene', 'deform');
  await shows(page, 'task-text', 'Press a dimple');
  await page.getByTestId('show-me').click();
  await led_by_the_ghost(page, 'force');

  // The user takes over, and does it; what the ghost did was not the user's.
  await page.getByTestId('view').focus();
  await page.keyboard.down('ArrowUp');
  assert.equal(await page.getByTestId('show-me').getAttribute('aria-pressed'), 'false');
  await shows(page, 'force', '0.00');
  await page.keyboard.up('ArrowUp');
  assert.equal(await page.locator('#task-mark').textContent(), 'Task:');
  await page.keyboard.down('ArrowDown');
  await page.waitForFunction(() => document.getElementById('task-mark')?.textContent === '✓ Done:', null, { timeout: kTimeout_ms });
  await page.keyboard.up('ArrowDown');
  assert.equal(await page.locator('#gallery [data-scene=deform] .done').textContent(), '✓ done');

  for (const colorScheme of ['light', 'dark'] as const) {
    await page.emulateMedia({ colorScheme });
    assert.deepEqual(await violations(page), [], colorScheme);
  }

  // Two fingers: another device, with two arms.
  const moved_by_two = await moves(page);
  await page.locator('#gallery [data-scene=blocks]').click();
  await shows(page, 'scene', 'blocks');
  await shows(page, 'mode', 'armed');
  await page.getByTestId('force-1').waitFor();
  assert.deepEqual(await moved_by_two(), [], 'by the scene of two arms');
  await page.getByTestId('show-me').click();
  await led_by_the_ghost(page, 'force-1');
  const view = (await page.getByTestId('view').boundingBox())!;
  await page.mouse.move(view.x + view.width / 2, view.y + view.height / 2);
  await page.mouse.down({ button: 'right' }); // turns the view
  await page.mouse.up({ button: 'right' });
  assert.equal(await page.getByTestId('show-me').getAttribute('aria-pressed'), 'true');
  await page.mouse.down();
  assert.equal(await page.getByTestId('show-me').getAttribute('aria-pressed'), 'false');
  await page.mouse.up();

  // Another scene while the ghost shows this one: it lets the hand go, and another device begins.
  await page.getByTestId('show-me').click();
  assert.equal(await page.getByTestId('show-me').getAttribute('aria-pressed'), 'true'); // the block lies where the user left it
  await page.locator('#gallery [data-scene=walls]').click();
  await shows(page, 'scene', 'walls');
  await shows(page, 'mode', 'armed');
  assert.equal(await page.getByTestId('alert').count(), 0);

  await page.reload();
  await page.waitForFunction(() => document.querySelector('#gallery [data-scene=deform] .done')?.textContent === '✓ done');
  await context.close();
});
