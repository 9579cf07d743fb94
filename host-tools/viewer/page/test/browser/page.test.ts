// The page in Chromium against the mock.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Mock } from '../../mock/server';
import type { PageMessage } from '../../src/protocol';
import { number_in, pixels_near, until } from './browser';
import { arm, drag, kForceColor, open, said, show, text } from './harness';
import { covered } from './page_checks';

test('blocks is loaded and shown, with the state in the DOM', async () => {
  const { page, mock } = await show();
  assert.equal(await text(page, 'scene'), 'blocks');
  assert.equal(await text(page, 'mode'), 'disarmed');
  assert.equal(await text(page, 'fault'), 'none');
  assert.equal(await text(page, 'tick-rate'), '4000 Hz');
  assert.equal(await page.getByTestId('view').getAttribute('data-objects'), '3');
  await until('the links of the arm', async () => (await page.getByTestId('view').getAttribute('data-links')) === '2');
  mock.load('walls');
  await until('the other scene', async () => (await text(page, 'scene')) === 'walls');
});

test('the page says why the arm is no longer armed, until it is armed again', async () => {
  const { page, mock } = await show();
  await arm(page);
  assert.equal(await text(page, 'stopped-by'), '');
  mock.touch.mode = 'ready';
  mock.touch.stopped_by_text = 'the dead-man switch was released';
  await until('the reason', async () => (await text(page, 'stopped-by')) === 'the dead-man switch was released');
  assert.equal(await text(page, 'mode'), 'ready');
  assert.match((await page.getByTestId('announce').textContent()) ?? '', /Mode ready\. the dead-man switch was released\./);
  await arm(page);
  assert.equal(await text(page, 'stopped-by'), '');
});

test('dragged onto a block the hand is pushed back: force in the DOM, an arrow in the picture', async () => {
  const { page, mock } = await show();
  await arm(page);
  mock.touch.move_hand(0, [0, -0.03, -0.015]); // above the near block
  await page.waitForTimeout(500);
  assert.equal(await number_in(page, 'force'), 0);
  const before = await pixels_near(page, kForceColor);
  await drag(page, 0, 45);
  await until('a force', async () => (await number_in(page, 'force')) > 0.3);
  assert.ok((await number_in(page, 'depth')) > 0.1);
  await page.waitForTimeout(300);
  const after_it = await pixels_near(page, kForceColor);
  assert.ok(after_it > before + 50, `${before} pixels of the arrow's colour before, ${after_it} after`);
  assert.ok(said(mock, 'hand').length > 3);
});

test('the wheel moves the hand away from the user and back', async () => {
  const { page, mock } = await show({}, { deviceScaleFactor: 1 });
  await page.getByTestId('view').hover();
  await page.mouse.wheel(0, -500);
  await until('a wish', () => said(mock, 'hand').length > 0);
  const far = said(mock, 'hand').at(-1) as Extract<PageMessage, { type: 'hand' }>;
  assert.ok(far.position_m[1] > 0.02 && far.position_m[0] === 0, `${far.position_m}`); // along the grid, 5 notches
  assert.match((await text(page, 'hand-hint')) ?? '', /wheel.*up: away, down: nearer/s);
  await page.waitForTimeout(500);
  // The line along which it moves is in the picture while it does.
  const green = (): Promise<number> => pixels_near(page, [0x4d, 0x7a, 0x00], 45);
  const without = await green();
  await page.mouse.down();
  await until('the line', async () => (await green()) > without + 40);
  await page.mouse.up();
  await page.mouse.wheel(0, 500);
  await until('the way back', () => Math.abs((said(mock, 'hand').at(-1) as typeof far).position_m[1]) < 0.001);
});

test('on a touch screen one finger moves the hand, two move it in depth', async () => {
  const { page, mock } = await show({}, { viewport: { width: 390, height: 844 }, hasTouch: true });
  const box = await page.getByTestId('view').boundingBox();
  assert.ok(box);
  const devtools = await page.context().newCDPSession(page);
  const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', points: [number, number][]) =>
    devtools.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: points.map(([x, y], id) => ({ x: box.x + x, y: box.y + y, id })),
    });
  const swipe = async (from: [number, number][], dx: number, dy: number) => {
    await touch('touchStart', from);
    for (let i = 1; i <= 10; ++i) {
      const moved = from.map(([x, y]): [number, number] => [x + (dx * i) / 10, y + (dy * i) / 10]);
      await touch('touchMove', moved);
      await page.waitForTimeout(30);
    }
    await touch('touchEnd', []);
    await page.waitForTimeout(500);
    return (said(mock, 'hand').at(-1) as Extract<PageMessage, { type: 'hand' }>).position_m;
  };
  const [x, y, z] = await swipe([[150, 250]], 60, 0);
  assert.ok(x > 0.01 && Math.abs(z) < 0.002, `${[x, y, z]}`);
  const two: [number, number][] = [
    [120, 250],
    [240, 250],
  ];
  const [, away] = await swipe(two, 0, -60);
  assert.ok(away > y + 0.01, `${away} after ${y}`);
});

test('a right drag turns the view and leaves the hand where it is', async () => {
  const { page, mock } = await show();
  const box = await page.getByTestId('view').boundingBox();
  assert.ok(box);
  await page.waitForTimeout(300);
  const before = await page.getByTestId('view').screenshot();
  await page.mouse.move(box.x + 300, box.y + 200);
  await page.mouse.down({ button: 'right' });
  await page.mouse.move(box.x + 450, box.y + 200, { steps: 5 });
  await page.mouse.up({ button: 'right' });
  await page.keyboard.down('Shift');
  await page.mouse.down();
  await page.mouse.move(box.x + 500, box.y + 260, { steps: 5 });
  await page.mouse.up();
  await page.keyboard.up('Shift');
  await page.waitForTimeout(500);
  assert.notDeepEqual(await page.getByTestId('view').screenshot(), before);
  assert.equal(said(mock, 'hand').length, 0);
});

test('sliders change the running scene, and the force with it; save asks the server', async () => {
  const { page, mock } = await show();
  await arm(page);
  mock.touch.move_hand(0, [0, -0.03, -0.03]);
  await until('a force', async () => (await number_in(page, 'force')) > 1.9);
  await page.getByTestId('object').selectOption('near block');
  await page.getByTestId('material-stiffness').fill('300');
  await until('a material message', () => said(mock, 'material').length > 0);
  assert.deepEqual(said(mock, 'material').at(-1), { type: 'material', object: 1, key: 'stiffness', value: 300 });
  await until('less force', async () => (await number_in(page, 'force')) < 1.5);
  // The dynamic coefficient may not be above the static one: both go, the lowered one first.
  await page.getByTestId('material-static_friction').fill('0.2');
  await until('both', () => said(mock, 'material').length >= 3);
  assert.deepEqual(
    said(mock, 'material').slice(-2),
    (['dynamic_friction', 'static_friction'] as const).map((key) => ({ type: 'material', object: 1, key, value: 0.2 })),
  );
  await page.getByTestId('save').click();
  await until('saved', async () => ((await text(page, 'messages')) ?? '').includes('saved'));
  assert.equal(said(mock, 'save').length, 1);
});

test('a material that is refused goes back to what runs, also right under the finger', async () => {
  const { page, mock } = await show();
  const value = page.getByTestId('material-stiffness-value');
  await page.getByTestId('object').selectOption('near block');
  const before = await value.inputValue();
  mock.refuses = true;
  await page.getByTestId('material-stiffness').fill('300');
  await until('the message', () => said(mock, 'material').length > 0);
  await until('the old value', async () => (await value.inputValue()) === before);
});

test('another scene ends the pause', async () => {
  const { page, mock } = await show();
  await page.getByTestId('pause').click();
  assert.equal(await text(page, 'pause'), 'Go live');
  mock.load('walls');
  await until('the button', async () => (await text(page, 'pause')) === 'Pause');
});

test('the picker asks for a scene', async () => {
  const { page, mock } = await show();
  await page.getByTestId('scene-picker').selectOption('ice');
  assert.equal(said(mock, 'pick').length, 0);
  await page.getByTestId('load').click();
  await until('ice', async () => (await text(page, 'scene')) === 'ice');
  assert.deepEqual(said(mock, 'pick'), [{ type: 'pick', scene: 'ice' }]);
});

test('the scrubber shows the past while the present goes on', async () => {
  const { page, mock } = await show();
  await arm(page);
  await page.waitForTimeout(1500);
  mock.touch.move_hand(0, [0, -0.03, -0.03]);
  await until('a force', async () => (await number_in(page, 'force')) > 1);
  await page.waitForTimeout(600);
  const now = await pixels_near(page, kForceColor);
  await page.getByTestId('scrubber').focus();
  await page.keyboard.press('ArrowLeft');
  await until('a step back', async () => /^-0\.0\d s$/.test((await text(page, 'when')) ?? ''));
  await page.keyboard.press('Home');
  await until('no force in the past', async () => (await number_in(page, 'force')) === 0);
  assert.match((await text(page, 'when')) ?? '', /^-\d+\.\d\d s$/);
  await page.waitForTimeout(400);
  assert.ok((await pixels_near(page, kForceColor)) < now / 2);
  mock.touch.trip(7, 'tip_velocity');
  await until('the fault of now', async () => (await text(page, 'fault')) === '7 tip_velocity');
  assert.equal(await number_in(page, 'force'), 0);
  await page.getByTestId('pause').click();
  assert.equal(await text(page, 'pause'), 'Pause');
  await until('live', async () => (await text(page, 'when')) === 'live');
});

test('a lost controller and a server that is gone are said, and recovered from', async () => {
  const { page, mock } = await show();
  mock.set_link(false);
  await until('the loss', async () => (await text(page, 'link')) === 'controller lost');
  assert.match((await text(page, 'notice')) ?? '', /link to the controller is lost/);
  assert.ok(await page.getByTestId('notice').isVisible());
  assert.ok(await page.getByTestId('arm').isDisabled());
  assert.match((await text(page, 'messages')) ?? '', /link-lost.*check the cable/);
  mock.set_link(true);
  await until('the return', async () => (await text(page, 'link')) === 'live');
  assert.ok(!(await page.getByTestId('notice').isVisible()));
  const port = mock.port;
  await mock.stop();
  await until('nobody there', async () => (await text(page, 'link')) === 'server gone');
  assert.match((await text(page, 'notice')) ?? '', /server is gone/);
  const again = new Mock();
  await again.start(port);
  open.push(() => again.stop());
  await until('the server again', async () => (await text(page, 'link')) === 'live');
  assert.ok(await page.getByTestId('arm').isEnabled());
});

test('mode and fault are announced, a refusal is written down', async () => {
  const { page, mock } = await show();
  await page.getByTestId('arm').click();
  await until('the refusal', async () => ((await text(page, 'messages')) ?? '').includes('not_homed'));
  await arm(page);
  assert.equal(await page.getByTestId('announce').getAttribute('aria-live'), 'polite');
  await until('armed', async () => (await text(page, 'announce')) === 'Mode armed. No fault.');
  mock.touch.trip(7, 'tip_velocity');
  await until('the fault', async () => (await text(page, 'announce')) === 'Mode faulted. Fault tip_velocity.');
  await page.getByTestId('clear').click();
  await until('cleared', async () => (await text(page, 'fault')) === 'none');
});

test('the token leaves the address, and a reload still controls', async () => {
  const { page, mock } = await show();
  assert.equal(page.url(), mock.url.replace(/\?.*/, ''));
  assert.ok(!(await page.evaluate(() => document.documentElement.outerHTML)).includes(mock.token));
  await page.reload();
  await until('a live link', async () => (await text(page, 'link')) === 'live');
  await arm(page);
});

test('without the token everything is seen and nothing can be changed', async () => {
  const { page, mock } = await show({}, {}, 'wrong');
  assert.ok(await page.getByTestId('read-only').isVisible());
  for (const id of ['home', 'arm', 'disarm', 'clear', 'load', 'scene-picker', 'save', 'material-stiffness', 'parameter-max_force'])
    assert.ok(await page.getByTestId(id).isDisabled(), id);
  await drag(page, 60, 60);
  await page.mouse.wheel(0, 100);
  await page.getByTestId('view').focus();
  await page.keyboard.press('ArrowLeft');
  await page.waitForTimeout(300);
  assert.deepEqual(mock.received, []);
});

test('Esc and the button stop, wherever the page is scrolled, also without the token', async () => {
  for (const token of [undefined, 'wrong']) {
    const { page, mock } = await (token === undefined ? show() : show({}, {}, token));
    for (const press of [() => page.keyboard.press('Escape'), () => page.getByTestId('stop').click()]) {
      mock.touch.fault = 0;
      mock.touch.mode = 'armed';
      await until('armed', async () => (await text(page, 'mode')) === 'armed');
      await page.evaluate(() => window.scrollTo(0, document.body.scrollHeight));
      assert.ok(await page.getByTestId('stop').isEnabled());
      const box = (await page.getByTestId('stop').boundingBox())!;
      const size = page.viewportSize()!;
      assert.ok(box.x >= 0 && box.y >= 0 && box.x + box.width <= size.width && box.y + box.height <= size.height, JSON.stringify(box));
      await press();
      await until('stopped', async () => (await text(page, 'fault')) === '14 host_stop');
    }
  }
});

test('a real device has no hand to drag', async () => {
  const { page, mock } = await show({ simulated: false });
  await drag(page, 60, 60);
  await page.waitForTimeout(200);
  assert.deepEqual(mock.received, []);
  assert.ok(await page.getByTestId('arm').isEnabled());
});

test('with the keyboard alone: home, arm, press a block, load a scene', async () => {
  const { page, mock } = await show();
  const tab_to = async (wanted: string) => {
    for (let i = 0; i < 60; ++i) {
      await page.keyboard.press('Tab');
      const now = await page.evaluate(() => {
        const it = document.activeElement as HTMLElement;
        return { id: it.dataset.testid ?? it.id, outline: getComputedStyle(it).outlineStyle };
      });
      if (now.id !== wanted) continue;
      assert.notEqual(now.outline, 'none', `the focus on ${wanted} cannot be seen`);
      return;
    }
    throw new Error(`Tab does not reach ${wanted}`);
  };
  await tab_to('home');
  await page.keyboard.press('Enter');
  await tab_to('arm');
  await page.keyboard.press('Space');
  await until('armed', async () => (await text(page, 'mode')) === 'armed');
  mock.touch.move_hand(0, [0, -0.03, -0.015]);
  await page.waitForTimeout(400);
  await tab_to('view');
  await page.keyboard.down('ArrowDown');
  await until('a force', async () => (await number_in(page, 'force')) > 0.5);
  await page.keyboard.up('ArrowDown');
  const hands = said(mock, 'hand').length;
  await page.keyboard.press('PageUp');
  await page.keyboard.press('Shift+ArrowRight');
  await until('two more', () => said(mock, 'hand').length >= hands + 1);
  for (const id of ['pause', 'scrubber', 'object', 'material-stiffness', 'material-dynamic_friction-value', 'save']) await tab_to(id);
  await tab_to('scene-picker');
  await page.keyboard.press('i');
  await tab_to('load');
  await page.keyboard.press('Enter');
  await until('ice', async () => (await text(page, 'scene')) === 'ice');
});

test('two arms: readings of both, the chosen one follows the keys', async () => {
  const { page, mock } = await show({ arms: 2 });
  await arm(page);
  mock.touch.move_hand(1, [0, 0.03, -0.03]);
  await until('a force on arm 1', async () => (await number_in(page, 'force-1')) > 1);
  assert.equal(await number_in(page, 'force'), 0);
  await page.getByTestId('view').focus();
  await page.keyboard.press('2');
  await page.keyboard.press('ArrowUp');
  await until('a wish', () => said(mock, 'hand').length > 0);
  assert.ok(said(mock, 'hand').every((it) => it.type === 'hand' && it.arm === 1));
  await page.getByLabel('both').check();
  await page.getByTestId('view').focus();
  const before = said(mock, 'hand').length;
  await page.keyboard.press('ArrowUp');
  await until('a wish of each', () => said(mock, 'hand').length >= before + 2);
  const [first, second] = said(mock, 'hand').slice(-2) as Extract<PageMessage, { type: 'hand' }>[];
  assert.deepEqual([first.arm, second.arm], [0, 1]);
  assert.ok(Math.abs(first.position_m[2] - 0.001) < 1e-9 && second.position_m[2] > -0.03, `${first.position_m}, ${second.position_m}`);
});

test('nothing is wider than the window or under Stop at 390 x 844 and at 1280 x 800, in light and in dark; the help is in view', async () => {
  for (const [width, height] of [
    [390, 844],
    [1280, 800],
  ])
    for (const colorScheme of ['light', 'dark'] as const) {
      const { page } = await show({ arms: 2 }, { viewport: { width, height }, colorScheme });
      const wide = await page.evaluate(() =>
        [...document.querySelectorAll('body, body *:not(.unseen, .skip)')]
          .filter((it) => it.getBoundingClientRect().right > innerWidth + 0.5)
          .map((it) => `${it.tagName} ${it.id} ${it.className}`),
      );
      assert.deepEqual(wide, [], `${width} px`);
      assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
      const help = (await page.locator('#keys').boundingBox())!;
      if (width > 820) assert.ok(help.y + help.height <= height, `the help ends at ${help.y + help.height}`);
      await page.locator('#words summary').click();
      assert.match(await page.locator('#words').innerText(), /encoder check/);
      assert.deepEqual(await covered(page), [], `${width} px`);
      const [back, fore] = await page.evaluate(() => {
        const style = getComputedStyle(document.body);
        return [style.backgroundColor, style.color].map((it) => (it.match(/\d+/g) ?? []).map(Number).reduce((a, b) => a + b, 0));
      });
      assert.ok(colorScheme === 'light' ? back > fore + 300 : fore > back + 300, `${colorScheme}: ${back} behind ${fore}`);
    }
});

test('every scene is shown without a word of complaint', async () => {
  const { page, mock } = await show();
  const names = (await page.getByTestId('scene-picker').locator('option').allTextContents()).filter((name) => name !== 'blocks');
  assert.ok(names.length > 15);
  for (const name of names) {
    mock.load(name);
    await until(
      name,
      async () => (await page.getByTestId('view').getAttribute('data-objects')) === String(mock.touch.scene.objects.length),
    );
    await page.waitForTimeout(150);
  }
  assert.equal(await text(page, 'messages'), '');
});

test('a server that leaves things out, or talks of what is not there, is borne', async () => {
  const { page, mock } = await show();
  clearInterval(mock.timer);
  const state = { type: 'state', time_s: 1e6 };
  const nonsense = [
    '',
    '[]',
    '{"type":"hello","arms":-1}',
    '{"type":"unheard-of"}',
    JSON.stringify({ ...state, arms: 7 }),
    JSON.stringify({ ...state, arms: [] }),
    JSON.stringify({ ...state, arms: [null, {}] }),
    JSON.stringify({ ...state, arms: [{ tip_m: [0, 0, 0], force_N: [0, 0, 0], planes: [] }] }),
    JSON.stringify({
      ...state,
      arms: [{ tip_m: [0, 0, 0] }],
      bodies: [{ object: 99, position_m: [0, 0, 0], rotation: [1, 0, 0, 0] }],
      controls: [{ object: 0, q: 1, on: true }],
      tissues: [{ object: 99, arm: 1, pressed: true, at_m: [0, 0], depth_m: 1 }],
      needles: [{ object: 99, arm: 1, inside: true, at_m: [0, 0], depth_m: 1, torn: 0 }],
    }),
  ];
  for (const message of nonsense) {
    mock.broadcast_text(message);
    await page.waitForTimeout(150);
  }
  await until('no tick rate', async () => (await text(page, 'tick-rate')) === '-');
  await until('no force', async () => (await text(page, 'force')) === '-');
});

test('a parameter goes to the server, and its answer stands in the field', async () => {
  const { page, mock } = await show();
  await page.locator('#parameters-panel summary').click();
  const field = page.getByTestId('parameter-max_force');
  assert.equal(await field.inputValue(), '8');
  await field.fill('3.5');
  await page.getByTestId('pause').focus();
  await until('the message', () => said(mock, 'parameter').length === 1);
  assert.deepEqual(said(mock, 'parameter')[0], { type: 'parameter', name: 'max_force', value: 3.5 });
  await field.fill('99'); // more than it may be
  await page.getByTestId('pause').focus();
  await page.waitForTimeout(300);
  assert.equal(said(mock, 'parameter').length, 1);
});

test('a controller without a scene is no error', async () => {
  const { page, mock } = await show();
  mock.unload();
  await until('nothing', async () => (await text(page, 'scene')) === 'none');
  await until('an empty view', async () => (await page.getByTestId('view').getAttribute('data-objects')) === null);
  assert.ok(await page.getByTestId('save').isDisabled());
  assert.equal(await text(page, 'messages'), '');
});

test('an image that cannot be read is said; tips go on', async () => {
  const { page, mock } = await show();
  await page.route('**/scene.thim*', (route) => route.fulfill({ body: 'not an image' }));
  mock.load('ice');
  await until('the word', async () => /no-scene-image.*no scene image/.test((await text(page, 'messages')) ?? ''));
  assert.equal(await text(page, 'link'), 'live');
});
