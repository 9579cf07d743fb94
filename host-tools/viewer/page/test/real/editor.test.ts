// The editor of the page that `thimble view` serves: what it saves is the file, and what another program writes is not lost.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { launch, until as until_soon } from '../browser/browser';
import { scene_file, view } from './command';

const until = (what: string, holds: () => Promise<boolean> | boolean): Promise<void> => until_soon(what, holds, 60_000);

// A page of `thimble view` with a scene of this name and text, in a folder of its own; and the page's errors.
async function viewed(name: string, text: string): Promise<{ page: Page; file: string; errors: string[]; end: () => Promise<void> }> {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-page-'));
  const file = join(folder, `${name}.scene.json`);
  writeFileSync(file, text);
  const server = await view('--scene', file);
  const browser = await launch();
  const page = await browser.newPage({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: 0.5 });
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(error.message));
  await page.goto(server.url);
  const end = async (): Promise<void> => {
    await browser.close();
    await server.command.stop();
    rmSync(folder, { recursive: true });
  };
  return { page, file, errors, end };
}

test("a field is edited, saved with all comments, and a conflict is the user's to decide", { timeout: 240_000 }, async () => {
  const original = `// by hand\n${readFileSync(scene_file('blocks'), 'utf8')}`;
  const { page, file, errors, end } = await viewed('blocks', original);
  try {
    const text = (name: string) => page.getByTestId(name).innerText();
    const runs = () => until('the text to run', async () => (await text('editor-state')).startsWith('Runs'));
    await page.getByTestId('edit').click();
    await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
    await page.getByTestId('editor-objects').selectOption({ index: 1 });
    await page.getByTestId('editor-rotation-2').fill('12');
    await page.getByTestId('editor-rotation-2').press('Enter');
    await runs();
    assert.equal(readFileSync(file, 'utf8'), original, 'nothing is saved yet');
    await page.keyboard.press('Control+s');
    await until('the file', () => readFileSync(file, 'utf8') !== original);
    const saved = readFileSync(file, 'utf8');
    assert.ok(saved.startsWith('// by hand\n') && saved.includes('12]'), saved.slice(0, 400));

    // Another program writes the file while something else is edited here.
    await page.getByTestId('editor-rotation-2').fill('13');
    await page.getByTestId('editor-rotation-2').press('Enter');
    await runs();
    const theirs = saved.replace('// by hand', '// by another hand');
    writeFileSync(file, theirs);
    await until('the question', () => page.getByTestId('editor-conflict').isVisible());
    assert.equal(readFileSync(file, 'utf8'), theirs);
    assert.equal(await page.getByTestId('editor-rotation-2').inputValue(), '13');
    await page.getByTestId('editor-theirs').click();
    await until('the text of the file', async () => (await page.getByTestId('editor-rotation-2').inputValue()) === '12');
    await page.getByTestId('editor-undo').click(); // mine again
    await until('my text', async () => (await page.getByTestId('editor-rotation-2').inputValue()) === '13');
    await runs();
    await page.getByTestId('editor-save').click();
    await until('it to be saved', () => readFileSync(file, 'utf8') === saved.replace('12]', '13]'));
    assert.deepEqual(errors, []);
  } finally {
    await end();
  }
});

test('another scene gives up nothing: what was edited or moved by a slider waits until it is saved', { timeout: 240_000 }, async () => {
  const { page, file, errors, end } = await viewed('mine', readFileSync(scene_file('blocks'), 'utf8'));
  try {
    page.on('dialog', (dialog) => errors.push(dialog.message()));
    const text = (name: string) => page.getByTestId(name).innerText();
    const load = async (scene: string, object: string): Promise<void> => {
      // At once: the picker follows the scene that runs.
      await page.getByTestId('scene-picker').evaluate((list: HTMLSelectElement, name) => {
        list.value = name;
        list.form?.requestSubmit();
      }, scene);
      await until(scene, async () => (await page.getByTestId('object').locator('option').allInnerTexts()).includes(object));
    };
    await until('the scene', async () => (await page.getByTestId('object').locator('option').count()) > 2);
    const object = (await page.getByTestId('object').locator('option').allInnerTexts())[1];

    // With the editor closed.
    await page.getByTestId('object').selectOption(object);
    await page.getByTestId('material-stiffness-value').fill('432');
    await page.getByTestId('material-stiffness-value').press('Enter');
    await page.waitForTimeout(2000); // it runs, and is kept
    await load('walls', 'floor');
    assert.match(await text('messages'), /edits-kept: the edits of "mine" are not saved; this browser keeps them/);
    await page.getByTestId('edit').click();
    await page.getByTestId('editor-load-kept').click();
    await page.getByTestId('editor-restore').click();
    await until('the text to run', async () => (await text('editor-state')) === 'Runs. Not saved.');
    await page.getByTestId('editor-objects').selectOption({ index: 1 });
    assert.equal(await page.getByTestId('editor-stiffness_N_m').inputValue(), '432');

    // And with it open.
    await page.getByTestId('editor-rotation-2').fill('12');
    await page.getByTestId('editor-rotation-2').press('Enter');
    await until('the text to run', async () => (await text('editor-state')) === 'Runs. Not saved.');
    await load('walls', 'floor');
    await page.getByTestId('editor-load-kept').click();
    await page.getByTestId('editor-restore').click();
    await until('the text to run', async () => (await text('editor-state')) === 'Runs. Not saved.');
    await page.getByTestId('editor-save').click();
    await until('it to be saved', () => readFileSync(file, 'utf8').includes('12]'));
    assert.match(readFileSync(file, 'utf8'), /432/);
    await load('walls', 'floor');
    await until('nothing kept', async () => !(await page.getByTestId('editor-kept').isVisible()));
    assert.deepEqual(errors, []);
  } finally {
    await end();
  }
});
