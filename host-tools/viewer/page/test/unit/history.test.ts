import assert from 'node:assert/strict';
import { test } from 'node:test';

import { History, kSpan_s } from '../../src/history';
import { depth_m, measure } from '../../src/measures';
import { range_of, splits_of } from '../../src/ranges';
import { type State, parse_message } from '../../src/protocol';
import { Timeline } from '../../src/timeline';

const at = (time_s: number, more: Partial<State> = {}): State => ({
  type: 'state',
  time_s,
  tick: Math.round(time_s * 4000),
  mode: 'armed',
  fault: 0,
  fault_name: '',
  limiters: [],
  tick_rate_Hz: 4000,
  worst_tick_s: 1e-5,
  arms: [{ tip_m: [0, 0, 0], force_N: [0, 0, time_s], velocity_m_s: [0, 0, 0], energy_J: 0 }],
  ...more,
});

const filled = (seconds: number, rate = 60): History => {
  const history = new History();
  for (let i = 0; i <= seconds * rate; ++i) history.push(at(i / rate));
  return history;
};

test('it keeps 60 s, no more and no less', () => {
  const history = filled(200);
  assert.equal(history.newest?.time_s, 200);
  assert.ok(Math.abs((history.oldest?.time_s ?? 0) - (200 - kSpan_s)) < 0.02);
  assert.equal(history.size, kSpan_s * 60 + 1);
});

test('the state of a moment is the last one before it', () => {
  const history = filled(10, 10);
  assert.equal(history.at(5.05)?.time_s, 5);
  assert.equal(history.at(5)?.time_s, 5);
  assert.equal(history.at(-3)?.time_s, 0);
  assert.equal(history.at(99)?.time_s, 10);
  assert.equal(new History().at(1), undefined);
});

test('a controller that starts again begins a new history; the same moment twice is one', () => {
  const history = filled(10);
  history.push(at(0.5));
  assert.equal(history.size, 1);
  history.push(at(0.5, { mode: 'ready' }));
  assert.equal(history.size, 1);
  assert.equal(history.newest?.mode, 'ready');
});

test('a curve has a gap where states are missing', () => {
  const history = filled(2, 10);
  history.push(at(5));
  const [times, force] = history.columns('force', 1, 0, 10);
  assert.equal(times.length, 21 + 2);
  assert.equal(force[21], null);
  assert.equal(force[22], 5);
  assert.deepEqual(history.columns('force', 1, 0.95, 1.25)[0], [0.9, 1, 1.1, 1.2]);
});

test('objects that a state does not name stay where they were', () => {
  const history = new History();
  const body = (object: number, x: number) => ({ object, position_m: [x, 0, 0] as const, rotation: [1, 0, 0, 0] as const });
  history.push(at(0, { bodies: [body(1, 0.1), body(2, 0.2)] }));
  history.push(at(1, { bodies: [body(2, 0.3)] }));
  history.push(at(2));
  assert.deepEqual(
    history.newest?.bodies?.map((it) => [it.object, it.position_m[0]]),
    [
      [1, 0.1],
      [2, 0.3],
    ],
  );
});

test('the timeline shows the past while new states come', () => {
  const timeline = new Timeline();
  for (let i = 0; i <= 100; ++i) timeline.live.push(at(i / 10));
  timeline.seek(-4);
  for (let i = 101; i <= 2000; ++i) timeline.live.push(at(i / 10));
  assert.equal(timeline.state?.time_s, 6);
  assert.equal(timeline.offset_s, -4);
  assert.equal(timeline.least_offset_s, -10);
  timeline.seek(-99);
  assert.equal(timeline.state?.time_s, 0);
  timeline.resume();
  assert.equal(timeline.state?.time_s, 200);
});

test('depth is that of the god object, else of tissue or needle', () => {
  const arms: State['arms'] = [{ tip_m: [0, 0, -0.002], god_m: [0, 0, 0], contacts: 1 }];
  assert.equal(depth_m(at(0, { arms }), 0), 0.002);
  const free: State['arms'] = [{ tip_m: [0, 0, -0.002], god_m: [0, 0, 0], contacts: 0 }];
  assert.equal(depth_m(at(0, { arms: free }), 0), 0);
  const needles: State['needles'] = [{ object: 0, arm: 0, inside: true, at_m: [0, 0], depth_m: 0.01, torn: 1 }];
  assert.equal(depth_m(at(0, { arms: free, needles }), 0), 0.01);
  assert.equal(measure(at(0, { arms: [{ tip_m: [0, 0, 0] }] }), 0, 'force'), null);
  assert.equal(measure(at(0), 1, 'force'), null);
});

test('a range ends at 1, 2, 5 times a power of ten', () => {
  assert.deepEqual(range_of([[0.1, 3.2, null]], 0.5), { min: 0, max: 5 });
  assert.deepEqual(range_of([[0, 0.01]], 0.5), { min: 0, max: 0.5 });
  assert.deepEqual(range_of([[-30, 0]], 0.5), { min: -50, max: 0 });
  assert.deepEqual(range_of([[-30, 0.01]], 0.5), { min: -50, max: 20 });
  assert.deepEqual(splits_of(-50, 0), [-50, -25, 0]);
  assert.deepEqual(splits_of(-50, 20), [-50, 0, 20]);
});

test('messages of others are none', () => {
  for (const text of ['', 'null', '[]', '{"type":"other"}', '{"type":"state"}', '{"type":"scene"}'])
    assert.equal(parse_message(text), null);
  assert.equal(parse_message('{"type":"link","up":true}')?.type, 'link');
});
