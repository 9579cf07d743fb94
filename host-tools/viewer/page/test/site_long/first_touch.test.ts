// How soon a new user feels something: from the navigation to the first force after the hand goes down, with nothing cached and the page's thread four
// times slower, as DevTools and Lighthouse slow it: they cannot slow workers. The server is on this machine. The quickest of three runs counts, as other
// programs run beside it.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import type { Page } from 'playwright-core';

import { launch } from '../browser/browser';
import { serve_site } from '../site/serve';

const kMost_ms = 5000;
const kSlower = 4;
const kTries = 3;

let site: Awaited<ReturnType<typeof serve_site>>;
before(async () => {
  site = await serve_site();
});
after(() => site.server.close());

type Times = Record<'live' | 'armed' | 'drawn' | 'down' | 'force', number>;

// Runs in the page before it: notes when it shows what, in ms since the navigation began; and once the scene is drawn and the arm armed, drags the hand
// down at once. A drag by the test would wait for this machine's other work.
function touch_at_once(): void {
  const times: Partial<Times> = {};
  Object.assign(globalThis, { times });
  Element.prototype.setPointerCapture = () => {}; // of a pointer that is none
  const text = (id: string) => document.querySelector(`[data-testid=${id}]`)?.textContent ?? '';
  const drag = (view: HTMLElement) => {
    const box = view.getBoundingClientRect();
    const at = (down_px: number) => ({ clientX: box.x + box.width / 2, clientY: box.y + box.height / 3 + down_px, bubbles: true });
    view.dispatchEvent(new PointerEvent('pointerdown', { ...at(0), pointerId: 1, isPrimary: true, button: 0, buttons: 1 }));
    let down_px = 0;
    const move = () => {
      down_px += 30;
      view.dispatchEvent(new PointerEvent('pointermove', { ...at(down_px), pointerId: 1, isPrimary: true, buttons: 1 }));
      if (down_px < 90) requestAnimationFrame(move);
    };
    requestAnimationFrame(move);
  };
  const look = () => {
    const view = document.querySelector<HTMLElement>('#view');
    if (text('link') === 'live') times.live ??= performance.now();
    if (text('mode') === 'armed') times.armed ??= performance.now();
    if (view?.dataset.objects) times.drawn ??= performance.now();
    if (Number.parseFloat(text('force')) > 0) times.force ??= performance.now();
    if (view === null || !times.armed || !times.drawn || times.down) return;
    times.down = performance.now();
    drag(view);
  };
  const what = { subtree: true, childList: true, characterData: true, attributes: true, attributeFilter: ['data-objects'] };
  new MutationObserver(look).observe(document, what);
}

async function first_touch(page: Page): Promise<Times> {
  await page.addInitScript('globalThis.__name = (it) => it'); // of what tsx makes of a function
  await page.addInitScript(touch_at_once);
  await page.goto(site.address, { waitUntil: 'commit' });
  await page.waitForFunction('times.force', null, { timeout: 60_000, polling: 100 });
  return (await page.evaluate('times')) as Times;
}

test(`${kSlower} times slower, the first force comes in ${kMost_ms} ms`, { timeout: 300_000 }, async () => {
  const all_ms: number[] = [];
  for (let run = 0; run < kTries && !all_ms.some((it) => it <= kMost_ms); ++run) {
    const browser = await launch();
    try {
      const page = await browser.newPage({ viewport: { width: 1280, height: 800 } });
      const session = await page.context().newCDPSession(page);
      await session.send('Emulation.setCPUThrottlingRate', { rate: kSlower });
      const times = await first_touch(page);
      assert.ok(times.force > times.down, 'a force before the hand went down');
      all_ms.push(times.force);
      const said = Object.entries(times).sort(([, a], [, b]) => a - b);
      console.log(`# ${said.map(([name, ms]) => `${name} ${Math.round(ms)}`).join(', ')} ms`);
    } finally {
      await browser.close();
    }
  }
  assert.ok(Math.min(...all_ms) <= kMost_ms, `${all_ms.map(Math.round).join(', ')} ms`);
});
