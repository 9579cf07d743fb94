// By what the page sees that a task is done, and the paths of the ghost. Every task with the device: test/site_long/tasks.test.ts.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Ghost } from '../../src/ghost';
import { HandPath } from '../../src/hand_path';
import type { State } from '../../src/protocol';
import { TaskWatch } from '../../src/task_watch';
import { type Goal, kTasks } from '../../src/tasks';
import type { Vec3 } from '../../src/vector';

const state = (tip_m: Vec3, force_N = 0, more: Partial<State> = {}): State => ({
  type: 'state',
  time_s: 0,
  mode: 'armed',
  arms: [{ tip_m, force_N: [0, 0, force_N], contacts: force_N > 0 ? 1 : 0 }],
  ...more,
});
const watch = (goal: Goal, names: string[] = []) => new TaskWatch({ line: '', task: '', goals: [goal] }, names);
const done = (it: TaskWatch, ...states: State[]): boolean => {
  for (const one of states) it.take(one);
  return it.done;
};

test('a stroke is the way in one touch; letting go begins again', () => {
  const along = (from: number, to: number) => Array.from({ length: 11 }, (_, i) => state([from + ((to - from) * i) / 10, 0, 0], 1));
  assert.ok(done(watch({ stroked_m: 0.03 }), ...along(0, 0.031)));
  assert.ok(!done(watch({ stroked_m: 0.03 }), ...along(0, 0.02), state([0.02, 0, 0.01]), ...along(0.02, 0.04)));
  const rest = Array.from({ length: 1000 }, (_, i) => state([0.0001 * (i % 2), 0, 0], 1));
  assert.ok(!done(watch({ stroked_m: 0.03 }), ...rest), 'a tip at rest');
});

test('what holds from the start on counts when it has ended and holds again', () => {
  const it = watch({ force_N: 1 });
  assert.ok(!done(it, state([0, 0, 0], 2), state([0, 0, 0], 2)));
  assert.ok(done(it, state([0, 0, 0], 0), state([0, 0, 0], 1.5)));
});

test('only an armed arm does anything', () => {
  assert.ok(!done(watch({ force_N: 1 }), state([0, 0, 0], 0, { mode: 'ready' }), state([0, 0, 0], 2, { mode: 'ready' })));
});

test('objects are found by their names, and compared with where they were', () => {
  const body = (z: number, turn = 0): Partial<State> => ({
    bodies: [{ object: 1, position_m: [0, 0, z], rotation: [Math.cos(turn / 2), 0, 0, Math.sin(turn / 2)] }],
  });
  const names = ['table', 'block'];
  assert.ok(
    done(watch({ body: { object: 'block', raised_m: 0.01 } }, names), state([0, 0, 0], 0, body(0)), state([0, 0, 0], 0, body(0.02))),
  );
  assert.ok(
    !done(watch({ body: { object: 'table', raised_m: 0.01 } }, names), state([0, 0, 0], 0, body(0)), state([0, 0, 0], 0, body(0.02))),
  );
  assert.ok(
    done(watch({ body: { object: 'block', turned_deg: 20 } }, names), state([0, 0, 0], 0, body(0)), state([0, 0, 0], 0, body(0, 0.4))),
  );
  assert.ok(
    !done(watch({ body: { object: 'block', turned_deg: 20 } }, names), state([0, 0, 0], 0, body(0)), state([0, 0, 0], 0, body(0, 0.3))),
  );
  const control = (q: number, on: boolean): Partial<State> => ({ controls: [{ object: 0, q, on }] });
  const snapped = { control: { object: 'table', on: true } };
  assert.ok(done(watch(snapped, names), state([0, 0, 0], 0, control(0, false)), state([0, 0, 0], 0, control(0.002, true))));
  assert.ok(!done(watch(snapped, names), state([0, 0, 0], 0, control(0, false)), state([0, 0, 0], 0, control(0.002, false))));
});

test('either block counts as lifted as high as one finger alone lifts it, also if it was held up when the task began', () => {
  const held = (z: number, object = 1): State =>
    state([0, 0, 0], 4, {
      arms: [1, 2].map(() => ({ tip_m: [0, 0, 0], force_N: [0, 0, 4], contacts: 1 })),
      bodies: [{ object, position_m: [0, 0, z], rotation: [1, 0, 0, 0] }],
    });
  const names = ['table', 'near block', 'far block'];
  const task = () => new TaskWatch(kTasks.blocks, names);
  assert.ok(done(task(), held(-0.035), held(-0.029)));
  assert.ok(done(task(), held(-0.035, 2), held(-0.029, 2)));
  assert.ok(!done(task(), held(-0.035), held(-0.032)), 'pressed, not lifted');
  assert.ok(!done(task(), held(0.02), held(0.02), held(-0.035)), 'let down');
  assert.ok(done(task(), held(0.02), held(-0.035), held(-0.025)), 'let down and lifted');
});

test('a path has its points at their times, for each arm', () => {
  const path = HandPath.parse('# made\ntime_s,x_m,y_m,z_m,arm\n0,0,0,0,0\n0,1,0,0,1\n2,4,0,-2,0\n2,1,2,0,1\n');
  assert.equal(path.arm_count, 2);
  assert.deepEqual(path.at(0, 1), [2, 0, -1]);
  assert.deepEqual(path.at(1, 9), [1, 2, 0]);
  assert.deepEqual(path.at(1, -1), [1, 0, 0]);
});

test('a ghost that is cut short goes up and back to where it began', () => {
  const path = HandPath.parse('time_s,x_m,y_m,z_m\n0,0,0,0\n1,0.1,0,-0.1\n5,0.3,0,-0.3\n');
  const went: Vec3[] = [];
  const ghost = new Ghost(path, 1, (_, at) => went.push(at));
  let time_s = 10;
  while (ghost.step(time_s, [[0.02, 0, 0]])) time_s += 0.02;
  assert.deepEqual(went[0], [0.02, 0, 0]);
  const lowest = went.findIndex((at) => at[2] <= -0.0999);
  assert.ok(lowest > 0 && went.every((at) => at[0] <= 0.1001));
  assert.ok(
    went.slice(lowest).every((at) => at[0] > 0.0999 || at[2] > -0.001),
    'up first',
  );
  assert.ok(Math.hypot(...(went.at(-1) as Vec3)) < 0.01);
});
