// The page in Chromium, served by the real `thimble view`, with the real controller behind it.
import assert from 'node:assert/strict';
import { cpSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import type { Browser, BrowserContextOptions, Page } from 'playwright-core';

import { launch, number_in, pixels_near, until as until_alone } from '../browser/browser';
import { type View, scene_file, simulator, thimble, view } from './command';
import { Steering, above, by_keys, by_mouse } from './steering';
import { Watcher } from './watcher';

const kForceColor: [number, number, number] = [0xff, 0x7a, 0x00];
const kOnNearBlock_m = [0, -0.03, -0.02] as const; // the middle of its top
const kIn_m = 0.006;
const kTrial = [40, -40, 4] as const; // to the right, up and away: it meets nothing
const kScale = 0.5; // a processor draws the picture: fewer pixels, more frames

let browser: Browser;
let ends: (() => unknown)[] = [];
let watchers: Watcher[] = [];
before(async () => {
  browser = await launch();
});
after(async () => browser.close());
afterEach(async () => {
  const all = ends.reverse();
  ends = [];
  watchers = [];
  for (const end of all) await end();
});

const text = (page: Page, testid: string) => page.getByTestId(testid).textContent();
const says = async (page: Page, testid: string, wanted: string) => (await text(page, testid)) === wanted;

// What the server says is told when the page does not show what is waited for.
const until: typeof until_alone = (...wanted) =>
  until_alone(...wanted).catch((error) => {
    const seen = watchers.map(({ state, events }) => JSON.stringify({ state, events: events.slice(-3) }));
    throw new Error(`${error.message}; ${seen.join('; ')}`);
  });

async function serve(...words: string[]): Promise<View> {
  const it = await view(...words);
  ends.push(() => it.command.stop());
  return it;
}

async function watch(url: string, token = false): Promise<Watcher> {
  const watcher = await Watcher.open(url, token);
  watchers.push(watcher);
  ends.push(() => watcher.close());
  return watcher;
}

async function show(url: string, context: BrowserContextOptions = {}): Promise<Page> {
  const page = await browser.newPage({ viewport: { width: 640, height: 720 }, deviceScaleFactor: kScale, ...context });
  const errors: string[] = [];
  page.on('console', (message) => {
    if (message.text().includes('Content Security Policy')) errors.push(message.text().slice(0, 200));
  });
  page.on('pageerror', (error) => errors.push(error.message));
  ends.push(async () => {
    await page.close();
    assert.deepEqual(errors, [], 'the page threw');
  });
  await page.goto(url);
  await until('a live link', () => says(page, 'link', 'live'));
  return page;
}

// A copy of a scene, whose file may be changed.
function copy_of(name: string): string {
  const folder = mkdtempSync(join(tmpdir(), 'thimble-page-'));
  ends.push(() => rmSync(folder, { recursive: true }));
  const file = join(folder, `${name}.scene.json`);
  cpSync(scene_file(name), file);
  return file;
}

async function armed(page: Page): Promise<void> {
  await until('armed', () => says(page, 'mode', 'armed'));
  await until('the scene', async () => (await page.getByTestId('view').getAttribute('data-objects')) !== null);
}

// Force and depth of a hand at rest: where the force is greatest, because the probes of the encoders take some of it away for a moment.
async function at_rest(page: Page): Promise<{ force: number; depth: number }> {
  let most = { force: 0, depth: 0 };
  await until('a force at rest', async () => {
    const was = most.force;
    most = { force: 0, depth: 0 };
    for (let look = 0; look < 12; ++look) {
      await page.waitForTimeout(70);
      const force = await number_in(page, 'force');
      if (force > most.force) most = { force, depth: await number_in(page, 'depth') };
    }
    return Math.abs(most.force - was) < 0.03;
  });
  return most;
}

test('blocks: dragged onto a block, the hand is pushed back; a softer block pushes less; what is felt is saved', async () => {
  const scene = copy_of('blocks');
  const { url } = await serve('--scene', scene);
  const page = await show(url);
  const watcher = await watch(url);
  await armed(page);
  assert.equal(await text(page, 'scene'), 'blocks');
  await until('blocks in the picker', async () => (await page.getByTestId('scene-picker').inputValue()) === 'blocks');
  assert.equal(await page.getByTestId('view').getAttribute('data-objects'), '3');
  // Those of a Premium, the last one from the elbow to the tip.
  const arm = watcher.state?.arms[0];
  const line = arm?.links_m?.at(-1) ?? [];
  assert.equal(await page.getByTestId('view').getAttribute('data-links'), String(line.length - 1));
  assert.ok(arm && line.length >= 3 && Math.hypot(...line[line.length - 1].map((at, i) => at - arm.tip_m[i])) < 2e-4, `${line}`);

  const mouse = new Steering(by_mouse(page), watcher, kTrial);
  await mouse.lead(0, above(kOnNearBlock_m, 0.012));
  assert.equal(await number_in(page, 'force'), 0);
  await page.waitForTimeout(300);
  const arrow_before = await pixels_near(page, kForceColor);
  await mouse.lead(0, above(kOnNearBlock_m, -kIn_m));
  await until('a force', async () => (await number_in(page, 'force')) > 1);
  const hard = await at_rest(page);
  const arrow = await pixels_near(page, kForceColor);
  assert.ok(arrow > arrow_before + 30, `${arrow_before} pixels of the arrow's colour before, ${arrow} after`);
  assert.equal(await text(page, 'contacts'), '1');
  assert.ok((await number_in(page, 'energy')) < 0, 'the hand has done work');
  assert.ok(Math.abs(hard.force / hard.depth - 1) < 0.03, `${hard.force} N at ${hard.depth} mm, of 1000 N/m`);

  await page.getByTestId('object').selectOption('near block');
  await page.getByTestId('material-stiffness').fill('300');
  await until('the changed material', async () => (await number_in(page, 'force')) < 0.8 * hard.force);
  const soft = await at_rest(page);
  assert.ok(Math.abs(soft.force / soft.depth - 0.3) < 0.01, `${soft.force} N at ${soft.depth} mm, of 300 N/m`);
  assert.ok(soft.force > 0.5, 'it is still touched');
  console.log(`# ${hard.force} N at ${hard.depth} mm, then ${soft.force} N at ${soft.depth} mm; arrow: ${arrow} pixels`);

  const stiffness = () => {
    const { objects, materials } = JSON.parse(readFileSync(scene, 'utf8'));
    return objects.map(
      ({ material }: { material: unknown }) => (typeof material === 'string' ? materials[material] : material).stiffness_N_m,
    );
  };
  const as_it_was = stiffness();
  await page.getByTestId('save').click();
  await until('saved', async () => /saved: .*blocks\.scene\.json/.test((await text(page, 'messages')) ?? ''));
  assert.deepEqual(stiffness(), [as_it_was[0], 300, as_it_was[2]]);
});

test('with --scene, Home brings the hand home, homes the arm and arms it again', async () => {
  const { url } = await serve('--scene', scene_file('blocks'));
  const page = await show(url);
  const watcher = await watch(url);
  await armed(page);
  await new Steering(by_mouse(page), watcher, kTrial).lead(0, [0.03, 0.01, 0.01], 0.003);
  await page.getByTestId('home').click();
  await until('the word', async () => /homed: the hand went home/.test((await text(page, 'messages')) ?? ''));
  await armed(page);
  const arm = watcher.state?.arms[0];
  assert.ok(arm?.hand_m && Math.hypot(...arm.hand_m) < 1e-4, `the hand is at ${arm?.hand_m}`);
  assert.ok(Math.hypot(...arm.tip_m) < 0.0005, `the tip is at ${arm.tip_m}`);
});

test('with the keyboard alone: press a block, soften it, disarm and arm, load another scene', async () => {
  const { url } = await serve('--scene', copy_of('blocks'), '--scenes', join(scene_file('ice'), '..'));
  const page = await show(url);
  const watcher = await watch(url);
  await armed(page);
  const tab_to = async (wanted: string) => {
    for (let i = 0; i < 60; ++i) {
      await page.keyboard.press('Tab');
      if ((await page.evaluate(() => (document.activeElement as HTMLElement).dataset.testid)) === wanted) return;
    }
    throw new Error(`Tab does not reach ${wanted}`);
  };
  await tab_to('view');
  const keys = new Steering(by_keys(page), watcher, [5, 5, 5]);
  await keys.lead(0, above(kOnNearBlock_m, 0.01));
  await keys.lead(0, above(kOnNearBlock_m, -kIn_m));
  await until('a force', async () => (await number_in(page, 'force')) > 1);
  const { force } = await at_rest(page);
  await tab_to('object');
  await page.keyboard.press('n');
  await tab_to('material-stiffness');
  await page.keyboard.press('Home'); // the least
  await until('less force', async () => (await number_in(page, 'force')) < force / 4);
  await tab_to('disarm');
  await page.keyboard.press('Enter');
  await until('disarmed', () => says(page, 'mode', 'ready'));
  await tab_to('arm');
  await page.keyboard.press('Space');
  await until('armed', () => says(page, 'mode', 'armed'));
  await tab_to('scene-picker');
  await page.keyboard.press('i');
  await tab_to('load');
  await page.keyboard.press('Enter');
  await until('ice', () => says(page, 'scene', 'ice'));
  // A new scene begins a new history: let it have a past before it stands still.
  await until('a second of ice', async () => Number(await page.getByTestId('scrubber').getAttribute('min')) < -1);
  await tab_to('pause');
  await page.keyboard.press('Enter');
  await tab_to('scrubber');
  await page.keyboard.press('ArrowLeft');
  await until('the past', async () => /^-\d/.test((await text(page, 'when')) ?? ''));
});

test('two viewers: one leads the hand, the other sees the same and changes nothing; nonsense disturbs neither', async () => {
  const { url } = await serve('--scene', scene_file('blocks'));
  const leads = await show(url);
  const looks = await show(url.replace(/\?.*/, ''), { viewport: { width: 390, height: 844 } });
  const watcher = await watch(url);
  await armed(leads);
  await armed(looks);
  assert.ok(await looks.getByTestId('read-only').isVisible());
  assert.ok(!(await leads.getByTestId('read-only').isVisible()));
  for (const id of ['home', 'arm', 'disarm', 'clear', 'load', 'save', 'material-stiffness'])
    assert.ok(await looks.getByTestId(id).isDisabled(), id);
  const [drag_x, drag_y] = by_mouse(looks);
  await drag_x(100);
  await drag_y(100);
  await looks.waitForTimeout(300);
  assert.deepEqual(watcher.hand_m(0), [0, 0, 0]);

  const nonsense = await watch(url, true);
  for (const it of [
    '',
    '{',
    '[]',
    '{"type":"hand"}',
    '{"type":"hand","arm":7,"position_m":[0,0,0]}',
    'x'.repeat(5000),
    Buffer.from([0, 255, 1]),
  ])
    nonsense.socket.send(it);
  await until('an answer to each', () => nonsense.events.length >= 7);
  assert.ok(nonsense.events.every((event) => event.level === 'error' && event.cause !== '' && event.remedy !== ''));

  const mouse = new Steering(by_mouse(leads), watcher, kTrial);
  await mouse.lead(0, above(kOnNearBlock_m, 0.012)); // from the side it would push the block away
  await mouse.lead(0, above(kOnNearBlock_m, -kIn_m));
  await until('a force', async () => (await number_in(leads, 'force')) > 1);
  const { force } = await at_rest(leads);
  await until('the same force', async () => Math.abs((await number_in(looks, 'force')) - force) < 0.05);
  for (const page of [leads, looks]) {
    assert.equal(await text(page, 'messages'), '', 'what others are told is not for this page');
    assert.equal(await text(page, 'link'), 'live');
  }
});

test('two arms: each hand by itself, a block between them', async () => {
  const { url } = await serve('--scene', scene_file('blocks'), '--arms', '2');
  const page = await show(url);
  const watcher = await watch(url);
  await armed(page);
  const [left, right] = [0, 1].map(() => new Steering(by_mouse(page), watcher, kTrial));
  await left.lead(0, [-0.03, -0.03, -0.035], 0.003);
  await page.getByLabel('arm 1').check();
  await right.lead(1, [0.03, -0.03, -0.035], 0.003);
  await right.lead(1, [0.01, -0.03, -0.035]);
  await page.getByTestId('view').focus();
  await page.keyboard.press('1');
  await left.lead(0, [-0.01, -0.03, -0.035]);
  await until('a force on both', async () => (await number_in(page, 'force')) > 0.5 && (await number_in(page, 'force-1')) > 0.5);
  await at_rest(page);
  const [a, b] = watcher.state?.arms.map((arm) => arm?.force_N?.[0] ?? 0) ?? [];
  assert.ok(a < 0 && b > 0, `${a} N and ${b} N along x: each is pushed outwards`);
  assert.equal(await page.getByTestId('legend-arm-1').isVisible(), true);
});

test('a controller that is killed is said, and the page goes on by itself when it is back', async () => {
  const first = await simulator();
  ends.push(() => first.command.stop('SIGKILL'));
  thimble('upload', scene_file('blocks'), '--device', first.address);
  const { url } = await serve('--device', first.address);
  const page = await show(url);
  await until('blocks', () => says(page, 'scene', 'blocks'));
  assert.ok(!(await page.getByTestId('hand-help').isVisible()), 'a real arm is not moved from a page');
  await page.getByTestId('home').click();
  await until('ready', () => says(page, 'mode', 'ready'));
  await page.getByTestId('arm').click();
  await until('armed', () => says(page, 'mode', 'armed'));
  await until('no homing while armed', () => page.getByTestId('home').isDisabled());
  const second = await show((await serve('--device', first.address)).url);
  await until('the same, in a second thimble view', () => says(second, 'mode', 'armed'));

  const killed_ms = Date.now();
  await first.command.stop('SIGKILL');
  await until('the loss', () => says(page, 'link', 'controller lost'));
  const told_ms = Date.now() - killed_ms;
  assert.ok(await page.getByTestId('notice').isVisible());
  assert.match((await text(page, 'notice')) ?? '', /link to the controller is lost/);
  assert.ok(await page.getByTestId('arm').isDisabled());

  const again = await simulator(Number(first.address.split(':').at(-1)));
  ends.push(() => again.command.stop());
  await until('the return', () => says(page, 'link', 'live'));
  await until('its return to the second', () => says(second, 'link', 'live'));
  assert.ok(!(await page.getByTestId('notice').isVisible()));
  await until('the new one', () => says(page, 'mode', 'disarmed'));
  await page.getByTestId('home').click();
  await until('ready', () => says(page, 'mode', 'ready'));
  console.log(`# told after ${told_ms} ms`);
});

// A processor draws the picture here, so the limit is no promise: it is there to find a queue.
test('how late the picture is', async () => {
  const { url } = await serve('--scene', scene_file('blocks'));
  const page = await show(url, { viewport: { width: 480, height: 480 }, deviceScaleFactor: 1 });
  await armed(page);
  await page.waitForTimeout(5000); // the picture has found its resolution
  // A hand that moves: a picture that does not change is not drawn.
  const leads = await watch(url, true);
  const moving = setInterval(() => {
    const turn = Date.now() / 200;
    leads.socket.send(JSON.stringify({ type: 'hand', arm: 0, position_m: [0.02 * Math.cos(turn), 0.02 * Math.sin(turn), 0.01] }));
  }, 20);
  ends.push(() => clearInterval(moving));
  const offset_ms = Date.now() - Number(process.hrtime.bigint()) / 1e6; // from the machine's monotonic clock to the page's
  const begun: number[][] = await page.evaluate(`new Promise((done) => {
    const canvas = document.querySelector('canvas#view');
    const seen = [];
    let last = '';
    const look = () => {
      // Registered after the page's own callback of the frame, so it runs when the page has drawn it.
      if (canvas.dataset.sinceUs !== last) seen.push([Number((last = canvas.dataset.sinceUs)), Date.now()]);
      if (seen.length < 120) requestAnimationFrame(look);
      else done(seen);
    };
    look();
  })`);
  const late_ms = begun
    .slice(1)
    .map(([since_us, now_ms]) => now_ms - (since_us / 1000 + offset_ms))
    .sort((a, b) => a - b);
  const [median, most] = [late_ms[late_ms.length >> 1], late_ms[Math.floor(late_ms.length * 0.95)]];
  const { framesPerS, workMs } = await page.getByTestId('view').evaluate((canvas: HTMLElement) => ({ ...canvas.dataset }));
  console.log(
    `# from the tick to the frame that is drawn: median ${median.toFixed(1)} ms, 95 % ${most.toFixed(1)} ms;` +
      ` ${framesPerS} frames a second, ${workMs} ms of the page's own work in each`,
  );
  assert.ok(late_ms[0] > 0 && median < 300);
});
