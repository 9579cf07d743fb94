// The hand's wishes: how many leave, and which; the wheel's steps; and both hands together.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { HandControl } from '../../src/hand_control';
import type { Stage } from '../../src/stage';
import type { Vec3 } from '../../src/vector';

for (const display_Hz of [60, 75, 144, 240]) {
  test(`at ${display_Hz} frames a second a hand that moves all the time sends at most 70 wishes a second, and the last one`, () => {
    const listeners = new Map<string, (event: object) => void>();
    const stage = {
      canvas: { addEventListener: (name: string, listener: (event: object) => void) => listeners.set(name, listener) },
      drag_turns: () => {},
      view: () => ({ right: [1, 0, 0], up: [0, 0, 1], away: [0, 1, 0], pixel_m: 1e-4, zoom: 1 }),
    };
    const sent: Vec3[] = [];
    const hand = new HandControl(stage as unknown as Stage, (_, position_m) => sent.push(position_m));
    hand.enable(true);
    hand.follow(0, [0, 0, 0]);
    const turn = { deltaY: -1, deltaMode: 0, preventDefault: () => {}, stopImmediatePropagation: () => {} };
    Object.assign(globalThis, { WheelEvent: { DOM_DELTA_PIXEL: 0 } });
    const frames = 3 * display_Hz;
    for (let i = 0; i < frames; ++i) {
      listeners.get('wheel')?.(turn);
      hand.step(100 + i / display_Hz, 1 / display_Hz);
    }
    assert.ok(sent.length <= 3 * 70 + 1 && sent.length > 3 * Math.min(display_Hz, 70) - 3, `${sent.length} in 3 s`);
    hand.step(104, 0.1);
    assert.ok(Math.abs((sent.at(-1) as Vec3)[1] - frames * 1e-5) < 1e-12);
  });
}

test('a notch of the wheel is a drag of 10 pixels in depth; both hands together keep their distance, and stop together', () => {
  const listeners = new Map<string, (event: object) => void>();
  const stage = {
    canvas: { addEventListener: (name: string, listener: (event: object) => void) => listeners.set(name, listener) },
    drag_turns: () => {},
    view: () => ({ right: [1, 0, 0], up: [0, 0, 1], away: [0, 1, 0], pixel_m: 5e-4, zoom: 1 }),
  };
  const at: Vec3[] = [];
  const hand = new HandControl(stage as unknown as Stage, (arm, position_m) => (at[arm] = position_m));
  hand.enable(true);
  hand.choose([0, 1]);
  const begin: Vec3[] = [
    [-0.05, 0, 0],
    [0.05, 0.01, 0],
  ];
  begin.forEach((place, arm) => hand.follow(arm, place));
  const turn = (deltaY: number, time_s: number): void => {
    listeners.get('wheel')?.({ deltaY, deltaMode: 0, preventDefault: () => {}, stopImmediatePropagation: () => {} });
    hand.step(time_s, 0.01);
  };
  turn(-100, 1); // up
  assert.deepEqual(
    at.map((place, arm) => place.map((value, axis) => Math.round(1e6 * (value - begin[arm][axis])))),
    [
      [0, 5000, 0],
      [0, 5000, 0],
    ],
    'um, away from the user',
  );
  // The server holds one of them back: the other does not go on alone.
  for (let i = 2; i < 60; ++i) {
    hand.follow(0, [...at[0]]);
    turn(-100, i);
  }
  const apart = at[1].map((value, axis) => value - at[0][axis]);
  apart.forEach((value, axis) => assert.ok(Math.abs(value - (begin[1][axis] - begin[0][axis])) < 1e-9, `${apart}`));
  assert.ok(at[1][1] > 0.05 && at[1][1] < 0.12, `${at[1]}`);
});
