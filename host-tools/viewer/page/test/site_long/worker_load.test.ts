// What the device in the page costs while it runs and nobody touches: the time that its worker has had of a core, by the kernel's account of the thread,
// to the time that it has simulated. Both are of this run, so other work of the machine does not count.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { site_in_chromium } from '../site/chromium';

const kMost = 0.15; // of a core
const kRate_Hz = 4000;
const kRun_ms = 8000;

const site = site_in_chromium();

// Seconds of a core that each worker of the renderer has had, by its thread.
async function workers_s(): Promise<Map<string, number>> {
  const session = await site.browser.newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  await session.detach();
  const threads = processInfo
    .filter(({ type }) => type === 'renderer')
    .flatMap(({ id }) => readdirSync(`/proc/${id}/task`).map((task) => `/proc/${id}/task/${task}`));
  const workers = threads.filter((thread) => readFileSync(`${thread}/comm`, 'utf8').startsWith('DedicatedWorker'));
  return new Map(workers.map((thread) => [thread, Number(readFileSync(`${thread}/schedstat`, 'utf8').split(' ')[0]) / 1e9]));
}
const ticks = async (page: Page): Promise<number> => Number(await page.getByTestId('view').getAttribute('data-tick'));

test(`at rest at ${kRate_Hz} Hz the device takes at most ${100 * kMost} % of a core`, { timeout: 120_000 }, async () => {
  const page = await site.browser.newPage({ viewport: { width: 640, height: 480 } });
  await page.goto(site.address);
  await page.waitForFunction(() => document.querySelector('[data-testid=mode]')?.textContent === 'armed', null, { timeout: 60_000 });
  await page.waitForTimeout(3000); // the engine has compiled what is hot
  const [before_s, before] = [await workers_s(), await ticks(page)];
  await page.waitForTimeout(kRun_ms);
  const [after_s, after] = [await workers_s(), await ticks(page)];
  const simulated_s = (after - before) / kRate_Hz;
  const busy_s = Math.max(...[...after_s].map(([thread, time_s]) => time_s - (before_s.get(thread) ?? 0))); // the compiler's has nothing to do
  const load = await page.evaluate(() => document.documentElement.dataset.load);
  console.log(
    `# ${busy_s.toFixed(3)} s of a core for ${simulated_s.toFixed(2)} s: ${((100 * busy_s) / simulated_s).toFixed(1)} %; by its own clock ${load}`,
  );
  assert.ok(simulated_s > 0.5 * (kRun_ms / 1000) && after_s.size >= 2, `${simulated_s} s, ${after_s.size} workers`);
  assert.ok(busy_s > 0 && busy_s <= kMost * simulated_s, `${busy_s} s of a core in ${simulated_s} s`);
  await page.close();
});
