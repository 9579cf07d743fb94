// The device of the site in Node.js: the session homes and arms the simulated board, runs a scene, and a hand feels it. The clock is the test's.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import type { Hello, SceneStarted, ServerEvent, ServerMessage, State } from '../../src/protocol';
import { Device } from '../../src/in_page/device';
import { compiler_of_scenes, kModule, kScenes } from './modules';

const kRound_ms = 4;

// A device whose scenes are compiled at once; time passes by run().
class Bench {
  readonly hellos: Hello[] = [];
  readonly scenes: SceneStarted[] = [];
  readonly events: ServerEvent[] = [];
  readonly saved: { file: string; text: string }[] = [];
  states: State[] = [];
  image: Uint8Array | null = null;
  private now_ms = 1000;
  private jobs: { file: string; text?: string }[] = [];
  private readonly compiler = compiler_of_scenes();
  private readonly device: Device;

  constructor(options = {}) {
    this.device = new Device(
      kModule,
      options,
      {
        message: (text) => this.take(JSON.parse(text) as ServerMessage),
        image: (bytes) => (this.image = bytes),
        compile: (job) => void this.jobs.push(job),
        save: (file) => void this.saved.push(file),
      },
      () => this.now_ms,
    );
  }

  post(message: object): void {
    this.device.post(message);
  }
  // Until `done` says so; throws after so many seconds.
  run(seconds: number, done: () => boolean = () => false): void {
    for (const end_ms = this.now_ms + 1000 * seconds; this.now_ms < end_ms && !done(); this.now_ms += kRound_ms) {
      this.device.round();
      for (const job of this.jobs.splice(0)) this.compile(job);
    }
  }
  // Time in which nothing runs.
  pass(seconds: number): void {
    this.now_ms += 1000 * seconds;
  }
  until(what: string, done: () => boolean, seconds = 20): void {
    this.run(seconds, done);
    assert.ok(done(), `${what}: ${JSON.stringify({ events: this.events, state: this.newest })}`);
  }
  get newest(): State | undefined {
    return this.states.at(-1);
  }
  get force_N(): number {
    return Math.hypot(...(this.newest?.arms[0]?.force_N ?? [0]));
  }
  get skipped_s(): number {
    return this.device.skipped_s;
  }
  get ticks(): number {
    return this.device.ticks;
  }

  private compile({ file, text }: { file: string; text?: string }): void {
    const name = file.replace('.scene.json', '');
    const path = `${name}/${file}`;
    const all = text ?? readFileSync(join(kScenes, path), 'utf8');
    const { head, image } = this.compiler.compile(`/scenes/${path}`, all);
    this.device.deliver(JSON.stringify({ ...head, text: all }), image);
  }
  private take(message: ServerMessage): void {
    if (message.type === 'hello') this.hellos.push(message);
    else if (message.type === 'scene') this.scenes.push(message);
    else if (message.type === 'event') this.events.push(message);
    else if (message.type === 'state') this.states.push(message);
  }
}

test('a scene is picked, the arm homed and armed, a wall felt, a material changed, the arm stopped', () => {
  const bench = new Bench();
  bench.post({ type: 'pick', scene: 'walls' });
  bench.until('armed', () => bench.newest?.mode === 'armed');
  assert.equal(bench.hellos[0].simulated, true);
  assert.equal(bench.scenes.at(-1)?.name, 'walls');
  assert.ok(bench.image !== null && bench.image.length > 100);

  for (let z_m = 0; z_m > -0.08 && bench.force_N < 0.5; z_m -= 0.001) {
    bench.post({ type: 'hand', arm: 0, position_m: [0, 0, z_m] });
    bench.run(0.02);
  }
  bench.run(0.3);
  const soft_N = bench.force_N;
  assert.ok(soft_N > 0.3, `the wall is not felt: ${JSON.stringify(bench.newest)}`);

  const objects = bench.scenes.at(-1)?.objects ?? [];
  for (let object = 0; object < objects.length; ++object)
    bench.post({ type: 'material', object, key: 'stiffness', value: objects[object].material.stiffness / 2 });
  bench.until('softer', () => bench.force_N < 0.8 * soft_N);

  bench.post({ type: 'save' });
  bench.until('saved', () => bench.saved.length === 1);
  assert.ok(bench.saved[0].text.includes('"thimble_scene"'));

  bench.post({ type: 'command', verb: 'stop' });
  bench.until('stopped', () => bench.newest?.mode !== 'armed', 1);
  assert.equal(bench.skipped_s, 0);
  assert.deepEqual(
    bench.events.filter((event) => event.level === 'error').map((event) => event.name),
    ['host_stop'],
  );
});

test('a machine that is late loses ticks, and they are counted', () => {
  const bench = new Bench();
  bench.run(1);
  const ticks = bench.ticks;
  bench.run(1);
  assert.ok(Math.abs(bench.ticks - ticks - 4000) <= 16, `${bench.ticks - ticks} ticks in a second`);
  assert.equal(bench.skipped_s, 0);
  bench.pass(0.5);
  bench.run(0.1);
  assert.ok(Math.abs(bench.skipped_s - 0.48) < 0.01, `${bench.skipped_s} s lost`);
});
