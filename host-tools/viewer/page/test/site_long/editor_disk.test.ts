// The editor saves to a file on the user's disk, where the browser can: here a file of the browser's own file system, which has the same handles.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { until as until_soon } from '../browser/browser';
import { site_in_chromium } from '../site/chromium';

const until = (what: string, holds: () => Promise<boolean>): Promise<void> => until_soon(what, holds, 60_000);
const site = site_in_chromium();

const text = (page: Page, name: string): Promise<string> => page.getByTestId(name).innerText();
const lines = (page: Page): Promise<string> => page.locator('.cm-content').innerText();
const state = async (page: Page, wanted: string): Promise<void> =>
  until(`the state "${wanted}"`, async () => (await text(page, 'editor-state')) === wanted);

interface Faked {
  asked: string[];
  fails?: string; // with an error of this name
}

// The pickers of the browser choose files of these names.
function fake_pickers(): void {
  const it = {
    faked: { asked: [] } as Faked,
    async choose(name: string): Promise<FileSystemFileHandle> {
      if (it.faked.fails) throw new DOMException('no', it.faked.fails);
      return (await navigator.storage.getDirectory()).getFileHandle(name, { create: true });
    },
    showSaveFilePicker({ suggestedName }: { suggestedName: string }) {
      it.faked.asked.push(suggestedName);
      return it.choose(`mine_${it.faked.asked.length}.scene.json`);
    },
    async showOpenFilePicker() {
      return [await it.choose('mine_1.scene.json')];
    },
  };
  Object.assign(window, it);
}
function no_pickers(): void {
  Object.assign(window, { showSaveFilePicker: undefined, showOpenFilePicker: undefined });
}

async function open(script: () => void): Promise<Page> {
  const context = await site.browser.newContext({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: 0.5, acceptDownloads: true });
  await context.addInitScript(script);
  const page = await context.newPage();
  await page.goto(site.address);
  await page.getByTestId('edit').click();
  await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
  return page;
}
async function move(page: Page, x: number): Promise<void> {
  await page.getByTestId('editor-objects').selectOption({ index: 1 });
  await page.getByTestId('editor-position-0').fill(String(x));
  await page.getByTestId('editor-position-0').press('Enter');
  await until('the text to run', async () => (await text(page, 'editor-state')).startsWith('Runs'));
}
async function load_ring(page: Page): Promise<void> {
  await page.getByTestId('scene-picker').evaluate((list: HTMLSelectElement) => {
    list.value = 'ring';
    list.form?.requestSubmit();
  });
  await until('the other scene', async () => (await text(page, 'scene')) === 'ring on a table');
}
const on_disk = (page: Page, name = 'mine_1.scene.json'): Promise<string> =>
  page.evaluate(
    async (file) => (await (await (await navigator.storage.getDirectory()).getFileHandle(file, { create: true })).getFile()).text(),
    name,
  );
const write_elsewhere = (page: Page, content: string): Promise<void> =>
  page.evaluate(async (it) => {
    const stream = await (await (await navigator.storage.getDirectory()).getFileHandle('mine_1.scene.json')).createWritable();
    await stream.write(it);
    await stream.close();
  }, content);
const asked = (page: Page): Promise<string[]> => page.evaluate(() => (window as unknown as { faked: Faked }).faked.asked);

test('the file is asked for once, and saved to again by button and by key', { timeout: 120_000 }, async () => {
  const page = await open(fake_pickers);
  assert.equal(await page.getByTestId('editor-download').count(), 0);
  assert.equal(await page.getByTestId('editor-save-as').isVisible(), false);
  await move(page, 41);
  await page.getByTestId('editor-save-file').click();
  await state(page, 'Runs. Saved to mine_1.scene.json.');
  assert.match(await on_disk(page), /0\.041/);
  assert.equal(await text(page, 'editor-save-file'), 'Save to mine_1.scene.json');
  await move(page, 42);
  await state(page, 'Runs. Not saved.');
  await page.getByTestId('editor-save-file').click();
  await state(page, 'Runs. Saved to mine_1.scene.json.');
  assert.match(await on_disk(page), /0\.042/);
  await move(page, 43);
  await page.getByTestId('editor-position-0').press('Control+s');
  await state(page, 'Runs. Saved to mine_1.scene.json.');
  assert.match(await on_disk(page), /0\.043/);
  assert.deepEqual(await asked(page), ['buttons.scene.json']);
  await page.getByTestId('editor-save-as').click();
  await state(page, 'Runs. Saved to mine_2.scene.json.');
  assert.equal(await on_disk(page, 'mine_2.scene.json'), await on_disk(page));

  // A saved text is no edit that this browser keeps; another scene has no file yet.
  await load_ring(page);
  await state(page, 'Runs.');
  assert.equal(await page.getByTestId('editor-kept').isVisible(), false);
  assert.equal(await text(page, 'editor-save-file'), 'Save to a file…');
  await page.context().close();
});

test(
  'a scene file that was opened is the one that is saved to, and what another program writes there is not lost',
  { timeout: 120_000 },
  async () => {
    const page = await open(fake_pickers);
    await move(page, 41);
    await page.getByTestId('editor-save-file').click();
    await state(page, 'Runs. Saved to mine_1.scene.json.');
    const theirs = `// theirs\n${await on_disk(page)}`;
    await page.reload();
    await page.getByTestId('edit').click();
    await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
    await page.getByTestId('editor-files').click();
    await state(page, 'Runs. Saved to mine_1.scene.json.');
    await move(page, 42);
    await write_elsewhere(page, theirs);
    await page.getByTestId('editor-save-file').click();
    await until('the question', () => page.getByTestId('editor-conflict').isVisible());
    assert.equal(await on_disk(page), theirs);
    await page.getByTestId('editor-theirs').click();
    await until('their text', async () => (await lines(page)).startsWith('// theirs'));
    await state(page, 'Runs. Saved to mine_1.scene.json.');
    await page.getByTestId('editor-undo').click(); // mine again
    await until('my text', async () => (await page.getByTestId('editor-position-0').inputValue()) === '42');
    await write_elsewhere(page, `${theirs}\n`);
    await page.getByTestId('editor-save-file').click();
    await page.getByTestId('editor-mine').click();
    await state(page, 'Runs. Saved to mine_1.scene.json.');
    assert.match(await on_disk(page), /0\.042/);
    assert.deepEqual(await asked(page), []);
    await page.context().close();
  },
);

test('saves that overlap follow each other, and a file goes with the scene that it was chosen for', { timeout: 120_000 }, async () => {
  const page = await open(fake_pickers);
  await move(page, 41);
  await page.getByTestId('editor-save-file').click();
  await state(page, 'Runs. Saved to mine_1.scene.json.');
  await move(page, 42);
  await page.getByTestId('editor-position-0').focus();
  await page.evaluate(() => {
    const key = { key: 's', ctrlKey: true, bubbles: true, cancelable: true };
    for (let times = 0; times < 10; ++times) document.activeElement?.dispatchEvent(new KeyboardEvent('keydown', key));
  });
  await state(page, 'Runs. Saved to mine_1.scene.json.');
  await page.waitForTimeout(500);
  assert.equal(await page.getByTestId('editor-conflict').isVisible(), false);
  assert.equal(await text(page, 'alerts'), '');

  // Another scene comes while the picker is open.
  await page.evaluate(() => {
    const it = window as unknown as { showSaveFilePicker(options: object): Promise<FileSystemFileHandle>; chosen(): void };
    const { showSaveFilePicker } = it;
    it.showSaveFilePicker = async (options) => {
      await new Promise<void>((chosen) => (it.chosen = chosen));
      return showSaveFilePicker(options);
    };
  });
  await page.getByTestId('editor-save-as').click();
  await load_ring(page);
  await page.evaluate(() => (window as unknown as { chosen(): void }).chosen());
  await until('the file', async () => (await on_disk(page, 'mine_2.scene.json')) === (await on_disk(page)));
  await state(page, 'Runs.');
  assert.equal(await text(page, 'editor-save-file'), 'Save to a file…');
  await page.context().close();
});

test('a picker that is given up changes nothing; a refused one is told', { timeout: 120_000 }, async () => {
  const page = await open(fake_pickers);
  const fail = (name: string): Promise<void> =>
    page.evaluate((it) => void ((window as unknown as { faked: Faked }).faked.fails = it), name);
  await move(page, 41);
  await fail('AbortError');
  await page.getByTestId('editor-save-file').click();
  await page.getByTestId('editor-files').click();
  await page.waitForTimeout(200);
  assert.equal(await text(page, 'alerts'), '');
  assert.equal(await text(page, 'editor-state'), 'Runs. Not saved.');
  await fail('NotAllowedError');
  await page.getByTestId('editor-save-file').click();
  await until('the banner', async () => (await text(page, 'alerts')).includes('not-saved'));
  assert.equal(await text(page, 'editor-state'), 'Runs. Not saved.');
  await page.context().close();
});

test('without the pickers it is a download', { timeout: 120_000 }, async () => {
  const page = await open(no_pickers);
  assert.equal(await page.getByTestId('editor-save-file').count(), 0);
  const download = page.waitForEvent('download');
  await page.getByTestId('editor-download').click();
  assert.equal((await download).suggestedFilename(), 'buttons.scene.json');
  await page.context().close();
});
