// What is checked of every page: what axe-core finds, and what moves by itself.
import axe, { type AxeResults } from 'axe-core';
import type { Page } from 'playwright-core';

export async function violations(page: Page): Promise<string[]> {
  await page.evaluate(axe.source);
  const { violations } = (await page.evaluate('axe.run(document, { resultTypes: ["violations"] })')) as AxeResults;
  return violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 120)} ${failureSummary}`));
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
