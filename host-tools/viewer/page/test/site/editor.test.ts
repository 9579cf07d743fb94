// The editor on the site: what is edited by mouse, by fields and as text is felt, and what is not edited goes on.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';

import axe, { type AxeResults } from 'axe-core';
import { type Browser, type Page } from 'playwright-core';

import { launch, until } from '../browser/browser';
import { serve_site } from './serve';

const kTimeout_ms = 60_000;

let browser: Browser;
let site: Awaited<ReturnType<typeof serve_site>>;
let page: Page;
const errors: string[] = [];

before(async () => {
  site = await serve_site();
  browser = await launch();
  page = await browser.newPage({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: 0.5 });
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address);
  await until('an armed arm', async () => (await text('mode')) === 'armed', kTimeout_ms);
  await until('the scene', async () => (await shown_objects()) > 0, kTimeout_ms);
});
after(async () => {
  await browser.close();
  site.server.close();
  assert.deepEqual(errors, []);
});

const text = (name: string): Promise<string> => page.getByTestId(name).innerText();
const shown_objects = async (): Promise<number> => Number(await page.getByTestId('view').getAttribute('data-objects'));
const force_N = async (): Promise<number> => Number.parseFloat(await text('force'));
const objects = (): Promise<string[]> => page.getByTestId('editor-objects').locator('option').allInnerTexts();
const selected = (): Promise<string> =>
  page.getByTestId('editor-objects').evaluate((list) => (list as HTMLSelectElement).selectedOptions[0]?.text ?? '');
const position_mm = async (): Promise<number[]> =>
  Promise.all([0, 1, 2].map(async (axis) => Number(await page.getByTestId(`editor-position-${axis}`).inputValue())));
const lines = (): Promise<string> => page.getByTestId('editor-text').locator('.cm-content').innerText();
const runs = (): Promise<void> => until('the text to run', async () => (await text('editor-state')).startsWith('Runs'));

// A whole text in place of that in the editor.
async function write(scene: object): Promise<void> {
  await page.getByTestId('editor-text').locator('.cm-content').click();
  await page.keyboard.press('Control+a');
  await page.evaluate(
    (json) => {
      const data = new DataTransfer();
      data.setData('text/plain', json);
      document.activeElement?.dispatchEvent(new ClipboardEvent('paste', { clipboardData: data, bubbles: true, cancelable: true }));
    },
    JSON.stringify(scene, null, 2),
  );
  await runs();
}

async function field(name: string, value: number): Promise<void> {
  await page.getByTestId(name).fill(String(value));
  await page.getByTestId(name).press('Enter');
  await runs();
}

// Steps of the hand until the force is as wanted; how far a key moves it depends on how busy this machine is.
async function step(key: 'ArrowUp' | 'ArrowDown', wanted: (force_N: number) => boolean): Promise<void> {
  await page.getByTestId('view').focus();
  for (let presses = 0; !wanted(await force_N()); ++presses) {
    assert.ok(presses < 100, `${key} leads to no such force`);
    await page.keyboard.press(key);
    await page.waitForTimeout(60);
  }
}

const kMaterial = { stiffness_N_m: 500, damping_N_s_m: 1 };
const kScene = {
  thimble_scene: 1,
  name: 'edited',
  objects: [
    { name: 'floor', shape: { plane: { normal: [0, 0, 1], offset_m: -0.005 } }, material: kMaterial },
    { name: 'far ball', shape: { sphere: { radius_m: 0.01 } }, pose: { position_m: [0.06, 0.02, 0.02] }, material: kMaterial },
  ],
};

test('it opens by keyboard, and shows the objects and the text of the scene', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('edit').focus();
  await page.keyboard.press('Enter');
  await until('the objects', async () => (await objects()).length > 5);
  assert.equal((await objects())[0], 'panel (plane)');
  assert.ok((await lines()).includes('"thimble_scene": 1'));
  await write(kScene);
  assert.deepEqual(await objects(), ['floor (plane)', 'far ball (sphere)']);
  await until('the picture', async () => (await shown_objects()) === 2);
});

test('what is pressed on is felt on while something else is edited', { timeout: kTimeout_ms }, async () => {
  await step('ArrowDown', (force) => force > 1);
  await page.waitForTimeout(300); // the hand's spring settles
  const pressed_N = await force_N();
  await page.getByTestId('editor-objects').selectOption({ index: 1 });
  await field('editor-position-0', 40);
  await field('editor-size-0', 8);
  await until('the same force', async () => Math.abs((await force_N()) - pressed_N) < 0.1 * pressed_N);
  assert.equal(await text('inside'), '');
  assert.match(await lines(), /\[\s*0\.04,\s*0\.02,\s*0\.02\s*\]/);
});

test('undo and redo by key and button', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('editor-undo').click();
  await page.getByTestId('editor-objects').press('Control+z');
  assert.ok((await lines()).includes('0.06'));
  await page.getByTestId('editor-redo').click();
  await runs();
  assert.equal((await position_mm())[0], 40);
});

test('a sphere that is added is felt where it is, and not where it was', { timeout: kTimeout_ms }, async () => {
  await step('ArrowUp', (force) => force === 0);
  for (let i = 0; i < 12; ++i) await page.keyboard.press('ArrowUp');
  await page.getByTestId('editor-part').selectOption('sphere');
  await page.getByTestId('editor-add').click();
  await runs();
  assert.equal(await selected(), 'sphere (sphere)');
  await field('editor-position-2', -15); // its top is 5 mm above home
  await step('ArrowDown', (force) => force > 0.3);
  await field('editor-position-0', -60);
  await until('no force', async () => (await force_N()) === 0);
});

test('a click selects, and a handle moves what is selected', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('editor-objects').selectOption({ label: 'sphere (sphere)' });
  await field('editor-position-0', -60); // away from the handles of the other
  await field('editor-position-2', 25); // above the floor, which would hide its middle
  const [x, y] = ((await page.getByTestId('view').getAttribute('data-handles')) ?? '').split(' ').map(Number);
  const before_mm = await position_mm();
  await page.getByTestId('editor-objects').selectOption({ label: 'far ball (sphere)' });
  const text_at = (): Promise<number> => page.locator('.cm-scroller').evaluate((it) => it.scrollTop);
  const [page_before, text_before] = [await page.evaluate(() => scrollY), await text_at()];
  await page.getByTestId('view').click({ position: { x, y } });
  await until('the sphere to be selected', async () => (await selected()) === 'sphere (sphere)');
  await until('its text', async () => (await text_at()) !== text_before);
  await page.waitForTimeout(300);
  assert.equal(await page.evaluate(() => scrollY), page_before, 'the picture stays where it is');
  const box = await page.getByTestId('view').boundingBox();
  assert.ok(box);
  const middle = { x: box.x + x, y: box.y + y };
  // The middle of the handles moves along the screen.
  await page.mouse.move(middle.x + 1, middle.y);
  await until('a handle', async () => (await page.getByTestId('view').getAttribute('data-handle')) !== null);
  await page.mouse.down();
  for (let i = 1; i <= 5; ++i) await page.mouse.move(middle.x + 6 * i, middle.y - 2 * i);
  await page.mouse.up();
  await runs();
  const after_mm = await position_mm();
  assert.ok(Math.hypot(...after_mm.map((at, i) => at - before_mm[i])) > 3, `${before_mm} to ${after_mm}`);
  await page.getByTestId('editor-undo').click();
  await runs();
  assert.deepEqual(await position_mm(), before_mm, 'one step of the history');
});

test('an error is told in line and in the list, and the scene runs on', { timeout: kTimeout_ms }, async () => {
  const count = await shown_objects();
  await page.getByTestId('editor-size-0').fill('-1');
  await page.getByTestId('editor-size-0').press('Enter');
  await until('the error', async () => (await text('editor-issues')).includes('radius_m'));
  assert.equal(await page.locator('.cm-lintRange-error').count(), 1);
  assert.ok((await text('editor-state')).startsWith('Errors'));
  assert.equal(await shown_objects(), count);
  assert.equal(await text('mode'), 'armed');
  await page.getByTestId('editor-undo').click();
  await runs();
  assert.equal(await text('editor-issues'), '');
});

const kCube_mm = [-10, 10].flatMap((x) => [-10, 10].flatMap((y) => [-10, 10].map((z) => `v ${x} ${y} ${z}`)));
const kFaces = ['1 2 4 3', '5 7 8 6', '1 5 6 2', '3 4 8 7', '1 3 7 5', '2 6 8 4'];

test('a mesh that is dropped is an object, in a size that can be felt', { timeout: kTimeout_ms }, async () => {
  const obj = [...kCube_mm, ...kFaces.map((face) => `f ${face}`)].join('\n');
  await page.evaluate((content) => {
    const data = new DataTransfer();
    data.items.add(new File([content], 'cube.obj'));
    document
      .querySelector('[data-testid=view]')
      ?.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
  }, obj);
  await until('the object', async () => (await objects()).includes('cube (mesh)'));
  await until(
    'its place below the tip',
    async () => (await lines()).includes('"file": "cube.obj", "scale": 0.001') && (await position_mm())[2] === -30,
  );
  await runs();
  assert.equal(await text('editor-issues'), '');
});

test('axe finds nothing in either theme, and a phone shows all of it', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('editor-size-0').fill('-1');
  await page.getByTestId('editor-size-0').press('Enter');
  await until('the error', async () => (await text('editor-issues')) !== '');
  await page.evaluate(axe.source);
  for (const colorScheme of ['light', 'dark'] as const) {
    await page.emulateMedia({ colorScheme });
    const { violations } = (await page.evaluate('axe.run("#editor", { resultTypes: ["violations"] })')) as AxeResults;
    assert.deepEqual(
      violations.flatMap(({ id, nodes }) => nodes.map(({ html, failureSummary }) => `${id}: ${html.slice(0, 160)} ${failureSummary}`)),
      [],
      colorScheme,
    );
  }
  await page.setViewportSize({ width: 360, height: 640 });
  const [wide, stop] = await page.evaluate(() => {
    const button = document.querySelector('[data-testid=stop]')?.getBoundingClientRect();
    return [document.documentElement.scrollWidth, button?.bottom ?? Infinity];
  });
  assert.ok(wide <= 360, `${wide}`);
  assert.ok(stop <= 640, `${stop}`);
  await page.setViewportSize({ width: 1280, height: 900 });
  await page.getByTestId('editor-undo').click();
  await runs();
});

test('keyboard alone: duplicate, delete', { timeout: kTimeout_ms }, async () => {
  const list = page.getByTestId('editor-objects');
  await list.selectOption({ index: 0 });
  await list.focus();
  await page.keyboard.press('ArrowDown');
  assert.equal(await selected(), 'far ball (sphere)');
  const names = await objects();
  await page.keyboard.press('Control+d');
  await runs();
  assert.equal(await selected(), 'far ball 2 (sphere)');
  await list.focus();
  await page.keyboard.press('Delete');
  await runs();
  assert.deepEqual(await objects(), names);
});

test('a kept scene is there when it is loaded again, until its original is wanted', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('editor-save').click();
  await until('it to be saved', async () => (await text('editor-state')) === 'Runs.');
  await page.getByTestId('load').click();
  await until('the kept scene', async () => (await text('scene')) === 'edited');
  await page.getByTestId('editor-original').click();
  await until('the original', async () => (await text('scene')) === 'buttons');
  await until('its text', async () => (await objects())[0] === 'panel (plane)');
});

test('it closes, and leaves the page as it was', { timeout: kTimeout_ms }, async () => {
  await page.getByTestId('edit').click();
  assert.equal(await page.getByTestId('editor').isVisible(), false);
  assert.equal(await page.getByTestId('edit').getAttribute('aria-expanded'), 'false');
});
