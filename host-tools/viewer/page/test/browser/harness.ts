// What the tests of the page against the mock share: a page with a mock of its own, closed after each test; a page that throws fails it.
import assert from 'node:assert/strict';
import { after, afterEach, before } from 'node:test';
import type { Browser, BrowserContextOptions, Page } from 'playwright-core';

import { Mock, type Options } from '../../mock/server';
import type { PageMessage } from '../../src/protocol';
import { launch, until } from './browser';

export const kForceColor: [number, number, number] = [0xff, 0x7a, 0x00];
const kScale = 0.5; // a processor draws the picture: fewer pixels, more frames

let browser: Browser;
export const open: (() => Promise<void>)[] = [];
before(async () => {
  browser = await launch();
});
after(async () => browser.close());
afterEach(async () => {
  for (const close of open.splice(0).reverse()) await close();
});

export interface Shown {
  page: Page;
  mock: Mock;
}

export async function show(options: Options = {}, context: BrowserContextOptions = {}, token?: string): Promise<Shown> {
  const mock = new Mock(options);
  await mock.start();
  const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: kScale, ...context });
  const errors: string[] = [];
  page.on('console', (message) => {
    if (message.text().includes('Content Security Policy')) errors.push(message.text().slice(0, 200));
  });
  page.on('pageerror', (error) => errors.push(error.message));
  open.push(async () => {
    await page.close();
    await mock.stop();
    assert.deepEqual(errors, [], 'the page threw');
  });
  await page.goto(token === undefined ? mock.url : mock.url.replace(mock.token, token));
  await until('a live link', async () => (await text(page, 'link')) === 'live');
  await until('the scene', async () => (await page.getByTestId('view').getAttribute('data-objects')) !== null);
  return { page, mock };
}

export const said = (mock: Mock, type: PageMessage['type']) => mock.received.filter((it) => it.type === type);
export const text = (page: Page, testid: string) => page.getByTestId(testid).textContent();

export async function arm(page: Page): Promise<void> {
  await page.getByTestId('home').click();
  await until('ready', async () => (await text(page, 'mode')) === 'ready');
  await page.getByTestId('arm').click();
  await until('armed', async () => (await text(page, 'mode')) === 'armed');
}

// Drags the middle of the view by so many pixels, in steps as a hand would.
export async function drag(page: Page, dx: number, dy: number): Promise<void> {
  const box = await page.getByTestId('view').boundingBox();
  assert.ok(box);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 10; ++i) {
    await page.mouse.move(x + (dx * i) / 10, y + (dy * i) / 10);
    await page.waitForTimeout(30);
  }
  await page.mouse.up();
}
