// What a commissioning marks in the picture, and says.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Quaternion, Vector3 } from 'three';

import { type ArrowPath, AxisMarks, axis_arrow } from '../../src/axis_marks';
import { kUnread_ms, may_answer, picture_text, prompt_text } from '../../src/commission_view';
import { type CommissionState, parse_message } from '../../src/protocol';
import { kSeat } from '../../src/framing';
import type { Vec3 } from '../../src/vector';

const kSize_m = 0.03;
const kQuiet: CommissionState = { steps: [], doing: '', is_live: true };
const three = (v: Vec3): Vector3 => new Vector3(...v);
const near = (a: Vector3, b: Vector3, what: string) => assert.ok(a.distanceTo(b) < 1e-6, `${what}: ${a.toArray()} is not ${b.toArray()}`);

// The axis at an odd place and in an odd direction; three.js's own rotation is the judge.
const kAxis = {
  name: 'upper',
  slides: false,
  at_m: [0.1, -0.2, 0.05] as Vec3,
  direction: three([0.3, -0.5, 0.8]).normalize().toArray() as Vec3,
};

test('the arrow of an axis that turns follows a point of its link', () => {
  for (const sign of [1, -1]) {
    const path: ArrowPath = axis_arrow(kAxis, sign, kSize_m);
    const from = three(path[0]).sub(three(kAxis.at_m));
    assert.ok(Math.abs(from.length() - kSize_m) < 1e-9);
    assert.ok(Math.abs(from.dot(three(kAxis.direction))) < 1e-9, 'it is square to the axis');
    path.forEach((point, i) => {
      const turned = new Quaternion().setFromAxisAngle(three(kAxis.direction), (sign * 1.5 * Math.PI * i) / (path.length - 1));
      near(three(point).sub(three(kAxis.at_m)), from.clone().applyQuaternion(turned), `point ${i}`);
    });
  }
});

test('the arrow of an axis that slides points along it', () => {
  const path = axis_arrow({ ...kAxis, slides: true }, -1, kSize_m);
  near(three(path[0]), three(kAxis.at_m), 'the beginning');
  near(three(path[1]).sub(three(path[0])).normalize(), three(kAxis.direction).negate(), 'the direction');
});

test('along z, along x and towards the user there is an arrow, too', () => {
  for (const direction of [[0, 0, 1], [0, 0, -1], [1, 0, 0], kSeat.toArray()] as Vec3[])
    for (const point of axis_arrow({ ...kAxis, direction }, 1, kSize_m))
      assert.ok(Math.abs(three(point).distanceTo(three(kAxis.at_m)) - kSize_m) < 1e-9);
});

test('only what the prompt asks for is marked', () => {
  const marks = new AxisMarks();
  const counts = () => marks.group.children.map((part) => part.children.length > 0);
  marks.update(kQuiet, [0, 0, 0], 0.3);
  assert.deepEqual(counts(), [false, false, false]);
  marks.update({ ...kQuiet, axis: kAxis }, [0, 0, 0], 0.3);
  assert.deepEqual(counts(), [true, false, false]);
  marks.update({ ...kQuiet, axis: kAxis, turn: -1, goal_m: [[[0, 0, 0], kAxis.at_m]] }, [0, 0, 0], 0.3);
  assert.deepEqual(counts(), [true, true, true]);
  assert.equal(marks.update({ ...kQuiet, way: [0, 0, 1] }, [0, 0, 0], 0.3), true);
  assert.deepEqual(counts(), [false, true, false]);
  assert.equal(marks.update({ ...kQuiet, way: [0, 0, 1] }, [0, 0, 0], 0.3), false, 'nothing has changed');
});

test('the words for prompt and picture', () => {
  const prompt = { number: 1, text: 'Press the e-stop.', done: 'Done' };
  assert.equal(prompt_text({ ...kQuiet, prompt, doing: 'waits' }), 'Press the e-stop.');
  assert.equal(prompt_text({ ...kQuiet, doing: 'waits' }), 'waits');
  assert.equal(prompt_text({ ...kQuiet, prompt, over: { passed: false, text: 'stopped in step 2' } }), 'stopped in step 2');
  assert.match(picture_text({ ...kQuiet, axis: kAxis, turn: 1 }), /question is upper; .* orange arrow/);
  assert.match(picture_text({ ...kQuiet, is_live: false }), /drawn at home/);
});

test('a second press of a button is no answer to a prompt that nobody has read', () => {
  assert.equal(may_answer(1000, 1000 + kUnread_ms - 1), false);
  assert.equal(may_answer(1000, 1000 + kUnread_ms), true);
});

test('a state whose commissioning has no steps is none', () => {
  const state = (commission: unknown) => parse_message(JSON.stringify({ type: 'state', time_s: 1, arms: [], commission }));
  assert.equal(state({}), null);
  assert.notEqual(state(kQuiet), null);
});
