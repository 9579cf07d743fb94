// What is checked of every page: what axe-core finds, and what moves by itself.
import assert from 'node:assert/strict';

import axe, { type AxeResults } from 'axe-core';
import type { Page } from 'playwright-core';

export async function violations(page: Page): Promise<string[]> {
  if (!(await page.evaluate("'axe' in globalThis"))) await page.evaluate(axe.source);
  const { violations } = (await page.evaluate('axe.run(document, { resultTypes: ["violations"] })')) as AxeResults;
  return violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 120)} ${failureSummary}`));
}

const kPhone = { width: 375, height: 667 };
const kDesk = { width: 1280, height: 800 };
// Each theme and each size; $AXE=all: each theme at each size, as in the long suite.
const kLooks = [
  ['light', kPhone],
  ['dark', kDesk],
  ...(process.env.AXE === 'all' ? ([['light', kDesk], ['dark', kPhone]] as const) : []), // prettier-ignore
] as const;

// In both themes, on a phone and on a desk.
export async function assert_accessible(page: Page, when: string): Promise<void> {
  for (const [colorScheme, size] of kLooks) {
    await page.emulateMedia({ colorScheme });
    await page.setViewportSize(size);
    assert.deepEqual(await violations(page), [], `${when}, ${colorScheme}, ${size.width} x ${size.height}`);
  }
}

// What has moved by itself since the page was loaded, but for the list of banners, which grows upwards, and digits on the right.
export async function moved(page: Page): Promise<string[]> {
  const read = await moves(page);
  return read();
}

// The same, and further on: what is told when it moves has its name also if it is gone later.
export async function moves(page: Page): Promise<() => Promise<string[]>> {
  await page.evaluate(`{
    const all = (globalThis.moved = []);
    const name = ({ node }) => (node ? (node.id || node.className || node.nodeName) : 'gone');
    const seen = new PerformanceObserver((list) => {
      for (const shift of list.getEntries())
        all.push(...shift.sources.filter(({ node }) => node?.nodeType !== Node.TEXT_NODE && !node?.closest?.('#alerts')).map((it) => name(it) + ' by ' + shift.value.toFixed(4)));
    });
    seen.observe({ type: 'layout-shift', buffered: true });
  }`);
  return () => page.evaluate('new Promise((done) => setTimeout(() => done(globalThis.moved), 300))');
}

// What can be operated, and lies under Stop, the header or a banner where it was scrolled into view.
export const covered = (page: Page): Promise<string[]> =>
  page.evaluate(() => {
    const bars = '#stop, header, #alerts';
    const all = [
      ...document.querySelectorAll<HTMLElement>('a[href], button, input, select, summary, textarea, [tabindex="0"], [contenteditable]'),
    ];
    return all
      .filter((it) => it.checkVisibility() && !it.closest('.skip, #stop, .unseen') && it.getBoundingClientRect().width > 1)
      .flatMap((it) => {
        it.scrollIntoView({ block: 'nearest', inline: 'nearest', behavior: 'instant' });
        const { left, right, top, bottom } = it.getBoundingClientRect();
        const over = [left + 3, (left + right) / 2, right - 3]
          .flatMap((x) => [top + 3, (top + bottom) / 2, bottom - 3].map((y) => document.elementFromPoint(x, y)?.closest(bars)))
          .find((bar) => bar && !bar.contains(it));
        return over ? [`${it.dataset.testid ?? it.id} ${it.textContent?.trim().slice(0, 20)} under ${over.id || over.nodeName}`] : [];
      });
  });
