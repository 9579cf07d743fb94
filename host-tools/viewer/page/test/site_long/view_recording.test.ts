// Recordings through the server of `thimble view`, which the site's page replays too; and how they end by themselves.
import assert from 'node:assert/strict';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, afterEach, test } from 'node:test';

import type { Page } from 'playwright-core';

import { type Simulator, type View, scene_file, simulator, thimble, thimble_beside, view } from '../real/command';
import { site_in_chromium } from '../site/chromium';
import { assert_exact, feels, save, shows } from '../site/made_recordings';

const kTimeout_ms = 60_000;
const kScene = scene_file('walls');

const site = site_in_chromium();
const folder = mkdtempSync(join(tmpdir(), 'thimble-view-'));
after(() => rmSync(folder, { recursive: true }));
let ends: (() => unknown)[] = [];
afterEach(async () => {
  for (const end of ends.splice(0).reverse()) await end();
});

async function serve(...words: string[]): Promise<{ server: View; page: Page }> {
  const server = await view(...words);
  ends.push(() => server.command.stop());
  const page = await site.browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: 0.5 });
  ends.push(() => page.close());
  await page.goto(server.url);
  await shows(page, 'link', 'live');
  await shows(page, 'scene', 'walls');
  return { server, page };
}
// A page that records a board, which runs walls.
async function recording(): Promise<{ board: Simulator; server: View; page: Page }> {
  const board = await simulator();
  ends.push(() => board.command.stop('SIGKILL'));
  thimble('upload', kScene, '--device', board.address);
  const { server, page } = await serve('--device', board.address);
  await page.getByTestId('record').click();
  await shows(page, 'recording-mark', 'Recording ');
  await page.waitForTimeout(700);
  return { board, server, page };
}

test('a contact is recorded; the desk and the site replay it to the bit', { timeout: 4 * kTimeout_ms }, async () => {
  const { page } = await serve('--scene', kScene);
  await shows(page, 'mode', 'armed');
  await page.getByTestId('disarm').click();
  await shows(page, 'mode', 'ready');
  assert.equal(await page.getByTestId('replay').isVisible(), false, 'only the site replays');
  await page.getByTestId('record').click();
  await shows(page, 'recording-mark', 'Recording ');
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed');
  await page.getByTestId('view').focus();
  await page.keyboard.down('ArrowDown');
  await feels(page);
  await page.keyboard.up('ArrowDown');
  await page.getByTestId('record').click();
  await shows(page, 'record-said', 'none lost. It has ended: as asked for.');
  const file = await save(page, 'record-save', join(folder, 'view.rec'));
  const { log, said } = assert_exact(file);
  assert.ok(said.contact_ticks > 100, JSON.stringify(said));

  const other = await site.browser.newPage();
  ends.push(() => other.close());
  await other.goto(site.address);
  await shows(other, 'mode', 'armed');
  await other.getByTestId('replay-file').setInputFiles(file);
  await shows(other, 'replay-said', 'every force to the bit.');
  const here = await save(other, 'replay-log', join(folder, 'here.csv'));
  assert.ok(readFileSync(here).equals(log), 'another log than that of the desk');
});

test('a board that is lost: what was recorded is offered, and exact', { timeout: 4 * kTimeout_ms }, async () => {
  const { board, page } = await recording();
  await board.command.stop('SIGKILL');
  await shows(page, 'alerts', 'recording-ended');
  await shows(page, 'record-said', 'It has ended: the link to the device was lost');
  const { said } = assert_exact(await save(page, 'record-save', join(folder, 'lost.rec')));
  assert.ok(said.ticks > 2000, JSON.stringify(said));
});

test('another host takes it over: the user is told, and what was recorded is exact', { timeout: 4 * kTimeout_ms }, async () => {
  const { board, page } = await recording();
  const words = ['record', join(folder, 'taker.rec'), '--force', '--scene', kScene, '--seconds', '3', '--device', board.address];
  const taker = thimble_beside(...words);
  await shows(page, 'record-said', 'It has ended: another');
  await shows(page, 'alerts', 'recording-ended');
  assert.equal(await page.getByTestId('record').getAttribute('aria-pressed'), 'false');
  assert_exact(await save(page, 'record-save', join(folder, 'taken.rec')));
  await taker;
});

test('a server that is killed: the page says that nothing is heard of the recording', { timeout: 4 * kTimeout_ms }, async () => {
  const { server, page } = await recording();
  await server.command.stop('SIGKILL');
  await shows(page, 'record-said', 'Nothing is heard of the recording any more');
  assert.equal(await page.getByTestId('recording-mark').textContent(), '');
});
