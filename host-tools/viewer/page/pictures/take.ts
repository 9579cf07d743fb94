// npm run pictures [-- FOLDER [NAME ...]]: what the page shows of every demonstration, FOLDER/NAME.png; and docs/pictures.md. Each scene is played by
// `thimble view --scene`, in real time, under its own scripted hand, which the page sends as it sends the mouse's.
import { once } from 'node:events';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { WebSocket } from 'ws';

import type { ServerMessage, State } from '../src/protocol';
import { launch, until } from '../test/browser/browser';
import { kTop, scene_file, view } from '../test/real/command';
import { live_address } from '../test/real/watcher';
import { type Picture, kPictures, page_of_pictures } from './list';

type Row = [time_s: number, x_m: number, y_m: number, z_m: number, arm: number];

// The hand that ./demo plays.
function path_of({ scene, folder }: Picture): Row[] {
  const own = join(kTop, 'scenes', folder, `${scene}.stroke.csv`);
  const text = readFileSync(existsSync(own) ? own : join(kTop, 'scenes', folder, 'stroke.csv'), 'utf8');
  return text
    .trim()
    .split('\n')
    .slice(1)
    .map((line) => {
      const [time_s, x_m, y_m, z_m, arm = 0] = line.split(',').map(Number);
      return [time_s, x_m, y_m, z_m, arm];
    });
}

// As a page of its own does it, which draws nothing: 60 times a second.
async function play(url: string, picture: Picture): Promise<State[]> {
  const rows = path_of(picture);
  const arms = [...new Set(rows.map((row) => row[4]))].map((arm) => ({ arm, own: rows.filter((row) => row[4] === arm) }));
  const socket = new WebSocket(live_address(url));
  await once(socket, 'open');
  const states: State[] = [];
  socket.on('message', (data) => {
    const message = JSON.parse(String(data)) as ServerMessage;
    if (message.type === 'state') states.push(message);
  });
  const from_s = picture.from_s ?? 0;
  const begin_ms = performance.now();
  for (let time_s = from_s; time_s < picture.at_s;) {
    time_s = Math.min(from_s + (performance.now() - begin_ms) / 1000, picture.at_s);
    for (const { arm, own } of arms) socket.send(JSON.stringify({ type: 'hand', arm, position_m: at(own, time_s) }));
    await new Promise((resolve) => setTimeout(resolve, 16));
  }
  setTimeout(() => socket.close(), 3000); // states go on coming until the page has been paused
  return states;
}

async function seek_peak(page: Page, states: State[]): Promise<void> {
  const since_us = Number(await page.getByTestId('view').getAttribute('data-since-us'));
  const newest = states.find((state) => state.since_us === since_us);
  const force = (state: State) => Math.hypot(...(state.arms[0]?.force_N ?? [0]));
  const peak = states.reduce((a, b) => (force(b) > force(a) ? b : a));
  if (newest === undefined) throw new Error('the page shows a state that nobody else got');
  await page.getByTestId('scrubber').evaluate(
    (input: HTMLInputElement, offset_s) => {
      input.step = 'any'; // a blow is over within two of its steps
      input.value = String(offset_s);
      input.dispatchEvent(new Event('input'));
    },
    peak.time_s - newest.time_s + 0.02,
  ); // a step of the scrubber later: not before a contact begins
}

function at(rows: Row[], time_s: number): number[] {
  const after = rows.findIndex((row) => row[0] > time_s);
  const [a, b] = after <= 0 ? [rows.at(after)!, rows.at(after)!] : [rows[after - 1], rows[after]];
  const share = b[0] > a[0] ? (time_s - a[0]) / (b[0] - a[0]) : 1;
  return [1, 2, 3].map((i) => a[i] + share * (b[i] - a[i]));
}

const kAfter_ms = 400; // the tip comes after the hand
const kTurns: Record<string, string> = { l: 'left', r: 'right', u: 'up', d: 'down', '+': 'nearer', '-': 'farther' };

async function take(page: Page, url: string, picture: Picture, file: string): Promise<void> {
  await until('armed', async () => (await page.getByTestId('mode').textContent()) === 'armed');
  await until('the scene', async () => (await page.getByTestId('view').getAttribute('data-objects')) !== null);
  for (const turn of picture.turns ?? '')
    await page.locator(`[data-turn=${kTurns[turn]}]`).evaluate((button: HTMLElement) => button.click());
  const states = await play(url, picture);
  await page.waitForTimeout(kAfter_ms);
  await page.getByTestId('pause').click();
  if (picture.peak) await seek_peak(page, states);
  await page.waitForTimeout(1500); // what stands still is drawn finely
  const force = await page.getByTestId('force').textContent();
  await page.screenshot({ path: file });
  console.log(`${picture.scene}: ${force}`);
}

const [folder = join(kTop, 'docs/pictures'), ...names] = process.argv.slice(2);
for (const name of names) if (!kPictures.some((it) => it.scene === name)) throw new Error(`there is no picture of ${name}`);
mkdirSync(folder, { recursive: true });
writeFileSync(join(kTop, 'docs/pictures.md'), page_of_pictures());
const browser = await launch();
try {
  for (const picture of kPictures) {
    if (names.length > 0 && !names.includes(picture.scene)) continue;
    const { url, command } = await view('--scene', scene_file(picture.scene, picture.folder), '--arms', `${picture.arms ?? 1}`);
    const page = await browser.newPage({ viewport: { width: 1280, height: 800 }, deviceScaleFactor: 0.75 });
    try {
      await page.goto(url);
      await take(page, url, picture, join(folder, `${picture.scene}.png`));
    } finally {
      await page.close();
      await command.stop();
    }
  }
} finally {
  await browser.close();
}
