// Phones and gamepads that are told when to shake: fakes that note it.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { State } from '../../src/protocol';
import { type Shaken, Vibration, can_shake } from '../../src/vibration';

const state = (force_N: number): State => ({ type: 'state', time_s: 0, arms: [{ tip_m: [0, 0, 0], force_N: [0, 0, force_N] }] });

function fakes() {
  const pulses_ms: number[] = [];
  const rumbles: number[] = [];
  const actuator = {
    playEffect: async (_: string, { strongMagnitude }: { strongMagnitude: number }) => void rumbles.push(strongMagnitude),
  };
  const shaken: Shaken = {
    maxTouchPoints: 1,
    vibrate: (ms) => pulses_ms.push(ms) > 0,
    getGamepads: () => [null, { vibrationActuator: actuator } as unknown as Gamepad],
  };
  return { pulses_ms, rumbles, shaken };
}

test('a contact shakes, the harder the longer; a steady push and free space do not; nothing before it is asked for', () => {
  const { pulses_ms, rumbles, shaken } = fakes();
  const vibration = new Vibration(shaken);
  let now_ms = 0;
  const feel = (...forces_N: number[]) => forces_N.forEach((force_N) => vibration.take(state(force_N), (now_ms += 100)));
  feel(0, 3, 0);
  assert.deepEqual(pulses_ms, []);
  vibration.on = true;
  feel(0, 0, 0);
  assert.deepEqual(pulses_ms, []);
  feel(0.5, 0.5, 0.55, 0.5);
  assert.equal(pulses_ms.length, 1);
  feel(3);
  assert.equal(pulses_ms.length, 2);
  assert.ok(pulses_ms[1] > pulses_ms[0] && pulses_ms[1] <= 40);
  assert.ok(rumbles.length === 2 && rumbles[0] > 0 && rumbles[1] === 1);
});

test('not more than twenty pulses a second', () => {
  const { pulses_ms, shaken } = fakes();
  const vibration = new Vibration(shaken);
  vibration.on = true;
  for (let i = 0; i < 100; ++i) vibration.take(state(i % 2), 10 * i);
  assert.ok(pulses_ms.length <= 20, `${pulses_ms.length}`);
});

test('a desk without a gamepad has nothing that shakes', () => {
  assert.ok(!can_shake({ maxTouchPoints: 0, vibrate: () => true, getGamepads: () => [null] }));
  assert.ok(can_shake({ maxTouchPoints: 5, vibrate: () => true }));
  assert.ok(can_shake({ ...fakes().shaken, maxTouchPoints: 0 }));
  assert.ok(!can_shake({ maxTouchPoints: 5 }));
});
