// What makes samples of the forces of ticks: each part alone, and all of them with ticks that stay away. The audio worklet in a browser and the
// device's own forces: test/site_long/sound.test.ts.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { why_silent } from '../../src/sound_button';
import { kLimit, Limiter } from '../../src/sound_limiter';
import { SoundQueue } from '../../src/sound_queue';
import { Resampler } from '../../src/sound_resampler';
import { ForceSignal } from '../../src/sound_signal';
import { amplitude } from '../tone';

const kTick_Hz = 4000;
const kSample_Hz = 48_000;

const largest = (samples: number[]): number => Math.max(...samples.map(Math.abs));
const forces = (ticks: number, of: (time_s: number) => number[]): Float32Array<ArrayBuffer> =>
  new Float32Array(Array.from({ length: ticks }, (_, tick) => of(tick / kTick_Hz)).flat());

function signal_of(all: Float32Array, arms = 1): number[] {
  const signal = new ForceSignal(kTick_Hz, arms);
  return Array.from({ length: all.length / 3 / arms }, (_, tick) => signal.take(all, 3 * arms * tick));
}

test('a change is heard whatever its direction, at its own frequency; a steady push is silent', () => {
  const wave = (time_s: number) => Math.sin(2 * Math.PI * 250 * time_s);
  for (const way of [
    [1, 0, 0],
    [0, 0, 1],
    [0.6, -0.8, 0],
    [-0.577, -0.577, 1.155],
  ]) {
    const heard = signal_of(forces(2000, (time_s) => way.map((part, axis) => part * wave(time_s) + (axis === 2 ? 1 : 0)))).slice(1000);
    const size = Math.hypot(...way);
    assert.ok(Math.abs(amplitude(heard, kTick_Hz, 250) / size - 1) < 0.07, `${way}`);
    assert.ok(amplitude(heard, kTick_Hz, 500) < 0.001 * size, `${way}`);
  }
  const steady = signal_of(forces(4000, () => [0.3, -2, 5]));
  assert.deepEqual(new Set(steady.slice(3000)), new Set([0]));
  const trembling = signal_of(forces(4000, (time_s) => [0, 0, 1 + 0.029 * Math.sign(Math.sin(2 * Math.PI * 30 * time_s))]));
  assert.ok(largest(trembling.slice(1000)) < 1e-5, 'steps of an encoder');
});

test('the other arm is heard too', () => {
  const heard = signal_of(
    forces(2000, (time_s) => [0, 0, Math.sin(2 * Math.PI * 200 * time_s), Math.sin(2 * Math.PI * 700 * time_s), 0, 0]),
    2,
  ).slice(1000);
  for (const frequency_Hz of [200, 700]) assert.ok(amplitude(heard, kTick_Hz, frequency_Hz) > 0.9, `${frequency_Hz} Hz`);
});

test('a tone of the ticks is that tone of the samples, and its images are 70 dB below', () => {
  for (const tone_Hz of [100, 900, 1500]) {
    const resampler = new Resampler();
    let tick = 0;
    const next = (): number => Math.sin((2 * Math.PI * tone_Hz * tick++) / kTick_Hz);
    const heard = Array.from({ length: 9600 }, () => resampler.read(kTick_Hz / kSample_Hz, next)).slice(4800);
    assert.ok(Math.abs(amplitude(heard, kSample_Hz, tone_Hz) - 1) < 0.03, `${tone_Hz} Hz: ${amplitude(heard, kSample_Hz, tone_Hz)}`);
    for (const image_Hz of [kTick_Hz - tone_Hz, kTick_Hz + tone_Hz, 2 * kTick_Hz - tone_Hz])
      assert.ok(amplitude(heard, kSample_Hz, image_Hz) < 10 ** (-70 / 20), `${tone_Hz} Hz at ${image_Hz} Hz`);
  }
});

test('nothing is louder than the limit, and what is softer is left as it is', () => {
  const limiter = new Limiter(kSample_Hz);
  const loud = Array.from({ length: 5000 }, (_, i) => limiter.take(20 * Math.sin(i) * (i % 700 < 20 ? 100 : 1)));
  assert.ok(largest(loud) <= kLimit);
  const soft = new Limiter(kSample_Hz);
  for (let i = 0; i < 1000; ++i) assert.equal(soft.take(0.9 * kLimit * Math.sin(i)), 0.9 * kLimit * Math.sin(i));
});

// Ticks come every 4 ms, as a worker sends them, while `come` says so.
function play(seconds: number, come: (time_s: number) => boolean): { heard: number[]; gaps: number } {
  const queue = new SoundQueue();
  const resampler = new Resampler();
  const heard: number[] = [];
  const every = 0.004 * kSample_Hz;
  for (let part = 0; part < seconds / 0.004; ++part) {
    const from_s = part * 0.004;
    const push = (time_s: number): number[] => [0, 0, 1 + 0.5 * Math.sin(2 * Math.PI * 100 * (from_s + time_s))];
    if (come(from_s)) queue.put({ forces_N: forces(16, push), arms: 1, rate_Hz: kTick_Hz });
    const step = queue.step(kSample_Hz);
    for (let i = 0; i < every; ++i) heard.push(resampler.read(step, () => queue.next()));
  }
  return { heard, gaps: queue.gaps };
}

test('ticks that stay away fade out and in again, without a click', () => {
  const { heard, gaps } = play(1, (time_s) => time_s < 0.4 || time_s > 0.7);
  assert.equal(gaps, 1);
  const at = (time_s: number) => time_s * kSample_Hz;
  assert.ok(amplitude(heard.slice(at(0.2), at(0.4)), kSample_Hz, 100) > 0.4);
  assert.ok(amplitude(heard.slice(at(0.8), at(1)), kSample_Hz, 100) > 0.4);
  assert.deepEqual(new Set(heard.slice(at(0.55), at(0.7)).map((sample) => Math.abs(sample))), new Set([0]));
  // The tone alone has steps of 2 pi 100 Hz x 0.5 N a second. The fade of 5 ms adds its own slope.
  const steps = heard.slice(1).map((sample, i) => sample - heard[i]);
  assert.ok(largest(steps) < 3 * ((2 * Math.PI * 100 * 0.5) / kSample_Hz), `${largest(steps)}`);
});

test('ticks that come all at once are skipped, and the sound goes on', () => {
  const queue = new SoundQueue();
  for (let part = 0; part < 100; ++part) queue.put({ forces_N: forces(16, () => [0, 0, part]), arms: 1, rate_Hz: kTick_Hz });
  let read = 0;
  for (; read < 2000 && queue.next() === 0; ++read);
  assert.ok(read < 2000, 'silent');
});

test('where not every tick comes, the button says so', () => {
  assert.equal(why_silent(true, 100), null);
  assert.match(why_silent(false, 99.6) ?? '', /100 forces a second.*2000/);
});
