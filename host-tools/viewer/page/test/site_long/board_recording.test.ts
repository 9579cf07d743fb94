// Recordings of a board on USB (board.ts), and how they end by themselves: the page says so, and offers what was recorded.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';

import type { Page } from 'playwright-core';

import { scene_file, thimble_beside } from '../real/command';
import { Board } from '../site/board';
import { site_in_chromium } from '../site/chromium';
import { assert_exact, feels, save, shows } from '../site/made_recordings';

const kTimeout_ms = 60_000;
const kScene = scene_file('walls');

const site = site_in_chromium();
let board: Board;
const folder = mkdtempSync(join(tmpdir(), 'thimble-usb-'));
before(async () => {
  // At this rate the pty loses nothing on a busy machine.
  board = await Board.start('--rate', '1000', '--hand', join(kScene, '../stroke.csv'), '--loop');
});
// Two pages would share the pty.
afterEach(() => Promise.all(site.browser.contexts().map((context) => context.close())));
after(async () => {
  await board.stop();
  rmSync(folder, { recursive: true });
});

// A page that records the board, which runs walls and is homed.
async function recording(): Promise<Page> {
  const page = await site.browser.newPage({ viewport: { width: 1280, height: 800 } });
  await board.put_into(page);
  await page.goto(site.address);
  await shows(page, 'mode', 'armed');
  await page.getByTestId('board').click();
  await page.waitForFunction(() => document.getElementById('device')?.textContent?.includes('serial port'), null, { timeout: kTimeout_ms });
  await page.waitForFunction(() => document.getElementById('scene')?.textContent !== 'buttons'); // that of the device in the page
  await page.getByTestId('scene-picker').selectOption('walls');
  await page.getByTestId('load').click();
  await shows(page, 'scene', 'walls');
  await page.waitForFunction(() => document.querySelector('[data-testid=view]')?.getAttribute('data-objects') === '5');
  await page.getByTestId('record').click();
  await shows(page, 'recording-mark', 'Recording ');
  return page;
}

test('home, arm and contact are recorded, and replayed to the bit here and at the desk', { timeout: 4 * kTimeout_ms }, async () => {
  const page = await recording();
  await page.getByTestId('home').click();
  await shows(page, 'mode', 'ready');
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed');
  await feels(page);
  await page.getByTestId('record').click();
  await shows(page, 'record-said', 'none lost. It has ended: as asked for.');
  assert.equal(await page.getByTestId('alerts').innerText(), '');
  await page.getByTestId('disarm').click();
  await page.getByTestId('replay-last').click();
  await shows(page, 'replay-said', 'every force to the bit.');
  const file = await save(page, 'record-save', join(folder, 'usb.rec'));
  const { log, said } = assert_exact(file);
  assert.ok(said.contact_ticks > 20, JSON.stringify(said));
  const here = await save(page, 'replay-log', join(folder, 'here.csv'));
  assert.ok(readFileSync(here).equals(log), 'another log than that of the desk');
});

const kEnds: [string, RegExp, (page: Page) => unknown][] = [
  [
    'host_silent',
    /this page was silent for too long/,
    async () => {
      board.hold(true);
      await new Promise((later) => setTimeout(later, 1300)); // link_timeout is 1 s
      board.hold(false);
    },
  ],
  [
    'taken_over',
    /another (page or host has ended it|host records now)/,
    () => thimble_beside('record', join(folder, 'taker.rec'), '--force', '--scene', kScene, '--seconds', '3', '--device', board.tcp),
  ],
  ['port-closed', /the link to the device was lost \(port-closed\)/, () => board.unplug()],
];
for (const [name, words, cause] of kEnds)
  test(`${name}: it ends, the page says why, and what was recorded is exact`, { timeout: 4 * kTimeout_ms }, async () => {
    const page = await recording();
    await page.waitForTimeout(700);
    const done = cause(page);
    await shows(page, 'record-said', 'It has ended');
    assert.match(await page.getByTestId('record-said').innerText(), words);
    assert.equal(await page.getByTestId('recording-mark').textContent(), '');
    assert.equal(await page.getByTestId('record').getAttribute('aria-pressed'), 'false');
    await shows(page, 'alerts', 'recording-ended');
    const { said } = assert_exact(await save(page, 'record-save', join(folder, `${name}.rec`)));
    assert.ok(said.ticks > 500, JSON.stringify(said));
    if (name !== 'taken_over') assert.equal(said.end, name);
    await done;
  });
