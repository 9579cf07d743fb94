// Links and recordings in Chromium. A link is made, opened, felt, refused where it is damaged, and taken where the page is open already. A recording
// is made, saved and replayed.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { test } from 'node:test';

import type { Download, Page } from 'playwright-core';

import { moved, violations } from '../browser/page_checks';
import { scene_fragment } from '../../src/scene_link';
import { site_in_chromium } from '../site/chromium';
import { bumpy_ball, kFormats } from '../site/mesh_files';
import { kThimble } from '../site/modules';

const kTimeout_ms = 60_000;

const site = site_in_chromium();

const scene = (name: string, shape: object): string =>
  JSON.stringify({ thimble_scene: 1, name, objects: [{ name: 'it', shape, material: { stiffness_N_m: 800, damping_N_s_m: 1 } }] });
const mesh = (file: string) => ({ mesh: { file, scale: 0.001, crease_deg: 40, side: 'outside' } });
const table = { plane: { normal: [0, 0, 1], offset_m: -0.01 } };

const shows = (page: Page, id: string, wanted: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent?.includes(it), [id, wanted], {
    timeout: kTimeout_ms,
  });

test('a link opens its scene, which is felt; another link replaces it; a bad one is told', { timeout: 4 * kTimeout_ms }, async () => {
  const context = await site.browser.newContext({ permissions: ['clipboard-read', 'clipboard-write'] });
  const page = await context.newPage();
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address + (await scene_fragment({ name: 'table', text: scene('A table of mine', table) })));
  await shows(page, 'scene', 'A table of mine');
  await shows(page, 'mode', 'armed');
  assert.match(await page.getByTestId('scene-picker').inputValue(), /^table \(link .{4}\)$/);
  await page.getByTestId('view').focus();
  await page.keyboard.down('ArrowDown');
  await page.waitForFunction(() => Number.parseFloat(document.querySelector('[data-testid=force]')?.textContent ?? '') > 0.3, null, {
    timeout: kTimeout_ms,
  });
  await page.keyboard.up('ArrowDown');

  const go = (fragment: string) => page.evaluate((it) => void (location.hash = it), fragment);
  // Files of the gallery come with the page.
  await go(await scene_fragment({ name: 'ring', folder: 'ring', text: scene('Another ring', mesh('ring.obj')) }));
  await shows(page, 'scene', 'Another ring');
  // What it has not is told by the compiler, as for other scenes.
  await go(await scene_fragment({ name: 'mine', text: scene('None', mesh('mine.obj')) }));
  await shows(page, 'alerts', 'mine.obj');
  await go('#scene=AAAA');
  await shows(page, 'alerts', 'bad-link');
  assert.equal(await page.getByTestId('scene').innerText(), 'Another ring');

  await page.getByTestId('share-link').click();
  await shows(page, 'share-said', 'is copied');
  const copied = await page.evaluate(() => navigator.clipboard.readText());
  assert.equal(copied, await page.getByTestId('share-address').inputValue());
  assert.deepEqual(await violations(page), []);

  // That of an untouched scene of the gallery is that scene; to pick one ends the link.
  await page.getByTestId('scene-picker').selectOption('walls');
  await page.getByTestId('load').click();
  await shows(page, 'scene', 'walls');
  assert.equal(await page.evaluate(() => location.hash), '');
  await context.clearPermissions();
  await page.getByTestId('share-link').click();
  await page.waitForFunction(() => (document.querySelector('[data-testid=share-address]') as HTMLInputElement).value !== '');
  const walls = await page.getByTestId('share-address').inputValue();

  await page.goto('about:blank');
  await page.goto(copied);
  await shows(page, 'scene', 'Another ring');
  await page.evaluate((it) => void (location.href = it), walls);
  await shows(page, 'scene', 'walls');
  assert.equal(await page.getByTestId('scene-picker').inputValue(), 'walls');
  assert.deepEqual(errors, []);
  await context.close();
});

test(
  'a link to a scene with files of the user is refused with their names, until it names them no more',
  { timeout: 4 * kTimeout_ms },
  async () => {
    const page = await site.browser.newPage({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: 0.5 });
    const errors: string[] = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    await page.goto(site.address + (await scene_fragment({ name: 'ring', folder: 'ring', text: scene('Mine', mesh('ring.obj')) })));
    await shows(page, 'scene', 'Mine');
    await page.getByTestId('edit').click();
    const ball = (name: string) => ({ name, mimeType: 'model/obj', buffer: kFormats['ball.obj'].bytes(bumpy_ball(6)) });
    // A file of the gallery stays what it is.
    await page.getByTestId('editor-file').setInputFiles([ball('ring.obj')]);
    await shows(page, 'alerts', 'ring.obj is another file, of the gallery');
    await page.getByTestId('dismiss').click();
    await page.getByTestId('editor-file').setInputFiles([ball('my_ball.obj')]);
    await page.waitForFunction(() => document.querySelector('[data-testid=view]')?.getAttribute('data-objects') === '2', null, {
      timeout: kTimeout_ms,
    });
    await page.getByTestId('share-link').click();
    await shows(page, 'share-said', 'No link: the scene names my_ball.obj, and a link carries no files.');
    await shows(page, 'alerts', 'send the scene with its files, or use those of the gallery');
    assert.equal(await page.getByTestId('share-address').inputValue(), '');
    assert.deepEqual(await violations(page), []);

    await page.getByTestId('editor-objects').selectOption({ index: 1 });
    await page.getByTestId('editor-objects').press('Delete');
    await page.waitForFunction(() => document.querySelector('[data-testid=view]')?.getAttribute('data-objects') === '1', null, {
      timeout: kTimeout_ms,
    });
    await page.getByTestId('share-link').click();
    await page.waitForFunction(() => (document.querySelector('[data-testid=share-address]') as HTMLInputElement).value.includes('#scene='));
    assert.deepEqual(errors, []);
    await page.close();
  },
);

test('a recording is made, saved and replayed, with the log of the desk', { timeout: 4 * kTimeout_ms }, async () => {
  const page = await site.browser.newPage({ viewport: { width: 1280, height: 800 } });
  const errors: string[] = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  await page.goto(site.address + (await scene_fragment({ name: 'my table', text: scene('A table of mine', table) })));
  await shows(page, 'mode', 'armed');
  await page.getByTestId('record').click();
  await shows(page, 'alerts', 'motors-on');
  await page.getByTestId('dismiss').click();
  await page.getByTestId('disarm').click();
  await shows(page, 'mode', 'ready');
  await page.getByTestId('record').click();
  await shows(page, 'recording-mark', 'Recording 0:00');
  assert.equal(await page.getByTestId('record').getAttribute('aria-pressed'), 'true');
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed');
  await page.getByTestId('view').focus();
  await page.keyboard.down('ArrowDown');
  await page.waitForFunction(() => Number.parseFloat(document.querySelector('[data-testid=force]')?.textContent ?? '') > 0.3, null, {
    timeout: kTimeout_ms,
  });
  await page.keyboard.up('ArrowDown');
  await shows(page, 'recording-mark', 'Recording 0:01');
  assert.deepEqual(await violations(page), []);
  await page.getByTestId('record').click();
  await shows(page, 'record-said', 'none lost. It has ended: as asked for.');
  assert.equal(await page.getByTestId('recording-mark').textContent(), '');

  const folder = mkdtempSync(join(tmpdir(), 'thimble-share-'));
  try {
    const saved = async (button: string): Promise<[Download, Buffer]> => {
      const [download] = await Promise.all([page.waitForEvent('download'), page.getByTestId(button).click()]);
      const file = join(folder, button);
      await download.saveAs(file);
      return [download, readFileSync(file)];
    };
    const [recording, bytes] = await saved('record-save');
    assert.match(recording.suggestedFilename(), /^my-table-link-[\w-]+\.rec$/);
    await page.getByTestId('replay-last').click();
    await shows(page, 'replay-said', 'every force to the bit.');
    const [log, rows] = await saved('replay-log');
    assert.equal(log.suggestedFilename(), recording.suggestedFilename().replace('.rec', '.csv'));
    execFileSync(kThimble, ['replay', join(folder, 'record-save'), '--log', join(folder, 'desk.csv')], { stdio: 'ignore' });
    assert.ok(rows.length > 100_000 && rows.equals(readFileSync(join(folder, 'desk.csv'))), 'another log than that of the desk');

    // One that is dropped, and one that is chosen and damaged.
    const transfer = await page.evaluateHandle((base64) => {
      const data = new DataTransfer();
      data.items.add(new File([Uint8Array.from(atob(base64), (it) => it.charCodeAt(0))], 'dropped.rec'));
      return data;
    }, bytes.toString('base64'));
    const said = await page.getByTestId('replay-said').textContent();
    await page.evaluate(() => document.getElementById('replay-said')!.replaceChildren());
    await page.dispatchEvent('main', 'drop', { dataTransfer: transfer });
    await shows(page, 'replay-said', said!);
    bytes[bytes.length >> 1] ^= 1;
    writeFileSync(join(folder, 'damaged.rec'), bytes);
    await page.getByTestId('replay-file').setInputFiles(join(folder, 'damaged.rec'));
    await shows(page, 'alerts', 'broken-recording');
    await shows(page, 'replay-said', 'No replay: damaged.rec has a message whose CRC-32');
  } finally {
    rmSync(folder, { recursive: true });
  }
  assert.deepEqual(await moved(page), []);
  assert.deepEqual(errors, []);
  await page.close();
});
