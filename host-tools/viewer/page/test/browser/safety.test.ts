// What a user must not miss: refusals and faults, old readings, and Stop.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Page } from 'playwright-core';

import { until } from './browser';
import { type Shown, arm, said, show, text } from './harness';
import { moved } from './page_checks';

const kSizes = [
  { width: 375, height: 667 },
  { width: 320, height: 568 },
  { width: 667, height: 375 },
  { width: 820, height: 1180 },
  { width: 1280, height: 800 },
  { width: 1920, height: 1080 },
];

const names = (page: Page) => page.getByTestId('alert').locator('strong').allTextContents();
const refuse = (name: string) => ({ type: 'event', level: 'error', name, cause: `the cause of ${name}`, remedy: 'do this' }) as const;

test('a refusal and a fault stand in a banner in view, newest first, without moving the page, until dismissed or over', async () => {
  const { page, mock } = await show();
  assert.equal(await page.getByTestId('alerts').getAttribute('role'), 'alert');
  await page.getByTestId('arm').click();
  await until('the refusal', async () => (await page.getByTestId('alert').count()) === 1);
  assert.match((await text(page, 'alert')) ?? '', /refused.*arming was refused: not_homed.*home the arm/);
  await page.evaluate(() => window.scrollTo(0, document.body.scrollHeight));
  await arm(page);
  mock.touch.trip(7, 'tip_velocity');
  await until('the fault', async () => (await names(page)).join() === 'tip_velocity,refused');
  for (const alert of await page.getByTestId('alert').all()) {
    const box = await alert.boundingBox();
    assert.ok(box && box.y >= 0 && box.y + box.height <= 800, JSON.stringify(box));
  }
  // The event has better words, and comes after the state.
  mock.broadcast({ type: 'event', level: 'error', name: 'tip_velocity', cause: 'the tip was too fast', remedy: 'clear the fault' });
  await until('the words', async () =>
    /the tip was too fast.*clear the fault/.test((await page.getByTestId('alert').first().textContent()) ?? ''),
  );
  assert.equal((await names(page)).length, 2);
  // What is next is the button that stands out.
  const main = () => page.locator('button.main[data-verb]').allTextContents();
  assert.deepEqual(await main(), ['Clear fault']);
  await page.getByTestId('clear').click();
  await until('the fault is over', async () => (await names(page)).join() === 'refused');
  await until('to arm is next', async () => (await main()).join() === 'Arm');
  assert.match((await text(page, 'messages')) ?? '', /tip_velocity: the tip was too fast/);
  assert.deepEqual(await moved(page), []);

  // What was refused because of a fault is over with it.
  await arm(page);
  mock.touch.trip(7, 'tip_velocity');
  await until('the fault again', async () => (await names(page)).join() === 'tip_velocity,refused');
  mock.broadcast(refuse('device-faulted'));
  await until('both', async () => (await names(page)).join() === 'device-faulted,tip_velocity,refused');
  await page.getByTestId('clear').click();
  await until('both are over', async () => (await names(page)).join() === 'refused');

  mock.broadcast(refuse('second'));
  mock.broadcast(refuse('refused'));
  mock.broadcast(refuse('fourth'));
  mock.broadcast(refuse('fourth'));
  await until('all', async () => /^fourth.*2 times/.test((await page.getByTestId('alert').first().textContent()) ?? ''));
  assert.equal(await page.getByTestId('alert').filter({ visible: true }).count(), 3);
  assert.match((await text(page, 'alerts-more')) ?? '', /1 more/);
  await page.getByTestId('dismiss').first().focus();
  for (let i = 0; i < 4; ++i) await page.keyboard.press('Enter');
  await until('none', async () => (await names(page)).length === 0);
  assert.equal(await page.evaluate(() => document.activeElement?.id), 'view');
  assert.equal(said(mock, 'command').filter((it) => it.type === 'command' && it.verb === 'stop').length, 0);
});

test('a fault that stands before the page comes, and the dead-man switch, are told; a disarm that was asked for is not', async () => {
  const { page, mock } = await show();
  await arm(page);
  await page.getByTestId('disarm').click();
  await until('ready', async () => (await text(page, 'mode')) === 'ready');
  await page.waitForTimeout(200);
  assert.deepEqual(await names(page), []);
  await page.getByTestId('arm').click();
  await until('armed', async () => (await text(page, 'mode')) === 'armed');
  Object.assign(mock.touch, { mode: 'ready', stopped_by: 'dead_man', stopped_by_text: 'the dead-man switch was released' });
  await until('the stop', async () => /dead_man the dead-man switch was released/.test((await text(page, 'alert')) ?? ''));
  mock.touch.trip(3, 'encoder_jump');
  await page.reload();
  await until('the fault', async () => (await names(page)).join() === 'encoder_jump');
});

const color = (page: Page, testid: string) => page.getByTestId(testid).evaluate((it) => getComputedStyle(it).color);

async function looks_old({ page }: Shown, muted: string): Promise<void> {
  await until('an unknown mode', async () => (await text(page, 'mode')) === 'unknown');
  assert.equal(await text(page, 'fault'), 'unknown');
  for (const id of ['mode', 'fault', 'limiter', 'tick-rate', 'worst-tick', 'view-force', 'force', 'depth', 'velocity', 'contacts'])
    assert.equal(await color(page, id), muted, id);
  assert.match((await text(page, 'announce')) ?? '', /Mode unknown: all readings are old/);
  assert.match(await page.getByTestId('view').evaluate((it) => getComputedStyle(it).filter), /grayscale/);
}

test('after the loss of the link no reading looks as if it were now: silent, controller lost, server gone', async () => {
  const shown = await show();
  const { page, mock } = shown;
  await arm(page);
  const muted = await page.locator('#device').evaluate((it) => getComputedStyle(it).color);
  const green = await color(page, 'mode');
  assert.notEqual(green, muted);
  clearInterval(mock.timer);
  await until('silence', async () => (await text(page, 'link')) === 'silent');
  await looks_old(shown, muted);
  mock.run();
  await until('armed again', async () => (await text(page, 'mode')) === 'armed' && (await color(page, 'mode')) === green);
  assert.match((await text(page, 'announce')) ?? '', /Mode armed/);
  mock.set_link(false);
  await until('the loss', async () => (await text(page, 'link')) === 'controller lost');
  await looks_old(shown, muted);
  mock.set_link(true);
  await until('armed again', async () => (await text(page, 'mode')) === 'armed');
  await mock.stop();
  await until('nobody there', async () => (await text(page, 'link')) === 'server gone');
  await looks_old(shown, muted);
});

test('Stop is in view and free at every size, scrolled or not, whatever else is said, and is told from Disarm', async () => {
  const { page, mock } = await show({}, {}, 'wrong'); // which has a banner more
  for (let i = 0; i < 5; ++i) mock.broadcast(refuse(`refusal ${i}`));
  mock.set_link(false);
  await until('all of it', async () => (await text(page, 'link')) === 'controller lost' && (await names(page)).length > 3);
  const free = () =>
    page.getByTestId('stop').evaluate((stop) => {
      const { left, right, top, bottom } = stop.getBoundingClientRect();
      const inside = left >= 0 && top >= 0 && right <= innerWidth && bottom <= innerHeight;
      const places = [left + 12, (left + right) / 2, right - 12].flatMap((x) => [top + 12, bottom - 12].map((y) => [x, y]));
      const hits = places.filter(([x, y]) => stop.contains(document.elementFromPoint(x, y)));
      return { inside, hits: hits.length, of: places.length, place: [left, top, right - left, bottom - top] };
    });
  for (const size of kSizes) {
    await page.setViewportSize(size);
    const places = [];
    for (const scroll of [0, 1e6]) {
      await page.evaluate((y) => window.scrollTo(0, y), scroll);
      const it = await free();
      assert.ok(it.inside && it.hits === it.of, `${size.width} x ${size.height}: ${JSON.stringify(it)}`);
      places.push(it.place);
    }
    assert.deepEqual(places[0], places[1]);
    const look = (id: string) =>
      page.getByTestId(id).evaluate((it) => {
        const style = getComputedStyle(it);
        const { width, height } = it.getBoundingClientRect();
        return { word: it.textContent?.trim(), back: style.backgroundColor, weight: style.fontWeight, area: width * height };
      });
    const [stop, disarm] = [await look('stop'), await look('disarm')];
    assert.match(stop.word ?? '', /^Stop/);
    assert.equal(disarm.word, 'Disarm');
    assert.notEqual(stop.back, disarm.back);
    assert.ok(stop.area > 1.8 * disarm.area && Number(stop.weight) > Number(disarm.weight), `${stop.area} and ${disarm.area} pixels`);
  }
});

test('a worst tick that is at the end of its number is said to be more', async () => {
  const { page, mock } = await show();
  await until('the worst tick', async () => (await text(page, 'worst-tick')) === '12.3 µs');
  mock.touch.worst_tick_s = 6553.5e-6;
  await until('its end', async () => (await text(page, 'worst-tick')) === '> 6.5 ms');
  mock.touch.worst_tick_s = 6553.4e-6;
  await until('a number', async () => (await text(page, 'worst-tick')) === '6553.4 µs');
});
