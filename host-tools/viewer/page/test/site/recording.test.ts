// Recordings both ways: the page's by `thimble replay`, and those of `thimble record` in the page, with the same bytes of the log; the same errors;
// and each recording ends where its counts no longer tell the forces.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { Compiler } from '../../src/in_page/compiler';
import { recorded_words, replayed_words } from '../../src/recording_words';
import { scene_file, simulator, thimble } from '../real/command';
import { Bench } from './bench';
import { kModule, kThimble } from './modules';

const folder = mkdtempSync(join(tmpdir(), 'thimble-recording-'));
after(() => rmSync(folder, { recursive: true }));

const compiler = new Compiler(kModule);

function in_page(file: string, bytes: Uint8Array) {
  const parts: Uint8Array[] = [];
  const said = compiler.replay(file, bytes, (part) => void parts.push(part));
  return { said, log: Buffer.concat(parts) };
}
// What the desk says, and its log.
function at_desk(file: string): { said: Record<string, unknown>; log: Buffer } {
  const log = join(folder, 'desk.csv');
  const said = JSON.parse(execFileSync(kThimble, ['replay', file, '--log', log, '--json'], { encoding: 'utf8' })) as Record<
    string,
    unknown
  >;
  return { said, log: readFileSync(log) };
}
function assert_same(file: string, bytes: Uint8Array): ReturnType<typeof in_page>['said'] {
  const page = in_page(file, bytes);
  const desk = at_desk(file);
  assert.ok(page.log.length > 1000 && page.log.equals(desk.log), `${page.log.length} and ${desk.log.length} bytes of the logs`);
  const { schema: _, verb: __, ...said } = desk.said;
  assert.deepEqual({ ...page.said, ...said, file }, { ...page.said, file });
  return page.said;
}

function recording(options: object, scene: string): Bench {
  const bench = new Bench(options);
  bench.post({ type: 'pick', scene });
  bench.until('armed', () => bench.newest?.mode === 'armed');
  bench.post({ type: 'command', verb: 'disarm' });
  bench.until('disarmed', () => bench.newest?.mode === 'ready');
  bench.post({ type: 'record', on: true });
  bench.until('recording', () => bench.recordings.at(-1)?.on === true);
  return bench;
}
function end(bench: Bench): Uint8Array<ArrayBuffer> {
  bench.until('ended', () => bench.recordings.at(-1)?.on === false);
  assert.ok(bench.recorded !== null);
  assert.equal(bench.recorded.length, bench.recordings.at(-1)?.bytes);
  return bench.recorded;
}

let walls = new Uint8Array();

test('a run in the page: home, arm, contact; replayed to the bit here and at the desk', () => {
  const bench = recording({}, 'walls');
  bench.post({ type: 'command', verb: 'home' });
  bench.until('homed', () => bench.events.at(-1)?.name === 'homed');
  bench.post({ type: 'command', verb: 'arm' });
  bench.until('armed', () => bench.newest?.mode === 'armed');
  bench.go(1, [0, 0, 0], [0, 0, -0.08]);
  assert.ok(bench.force_N > 0.5, `${bench.force_N} N`);
  bench.post({ type: 'record', on: false });
  walls = end(bench);
  const state = bench.recordings.at(-1)!;
  assert.deepEqual([state.end, state.missing, state.dropped, state.fault], ['stopped', 0, 0, undefined]);
  assert.ok(Math.abs(state.seconds * 4000 - state.ticks) < 1 && state.ticks > 5000, JSON.stringify(state));
  assert.equal(bench.newest?.mode, 'armed'); // goes on
  const file = join(folder, 'page.rec');
  writeFileSync(file, walls);
  const said = assert_same(file, walls);
  assert.deepEqual([said.exact, said.ticks, said.missing, said.end], [true, state.ticks, 0, 'stopped']);
  assert.equal(replayed_words(said), `${said.scene}: ${state.ticks} ticks, every force to the bit.`);
  assert.deepEqual(
    bench.events.filter(({ level }) => level === 'error'),
    [],
  );

  // Another one from the same device.
  bench.post({ type: 'record', on: true });
  bench.until('refused', () => bench.events.at(-1)?.name === 'motors-on');
  assert.match(bench.events.at(-1)!.remedy, /disarm/);
  bench.post({ type: 'command', verb: 'disarm' });
  bench.post({ type: 'record', on: true });
  bench.run(0.5);
  bench.post({ type: 'record', on: false });
  writeFileSync(file, end(bench));
  assert.equal(assert_same(file, bench.recorded!).exact, true);
});

test('two arms, of which one presses', () => {
  const bench = recording({ arms: 2 }, 'blocks');
  bench.post({ type: 'command', verb: 'arm' });
  bench.until('armed', () => bench.newest?.mode === 'armed');
  bench.go(0.5, bench.newest!.arms[1]!.tip_m, [0, 0, -0.09], 1);
  bench.post({ type: 'record', on: false });
  const file = join(folder, 'two.rec');
  writeFileSync(file, end(bench));
  const said = assert_same(file, bench.recorded!);
  assert.ok(said.exact && said.ticks > 1500 && said.contact_ticks > 100, JSON.stringify(said));
});

const kEnds: [string, string, (bench: Bench) => void][] = [
  ['scene_changed', 'ready', (bench) => bench.post({ type: 'pick', scene: 'ring' })],
  ['scene_changed', 'armed', (bench) => bench.post({ type: 'material', object: 0, key: 'stiffness', value: 500 })],
  ['parameter_written', 'ready', (bench) => bench.post({ type: 'parameter', name: 'max_force', value: 3 })],
  ['fault', 'armed', (bench) => bench.post({ type: 'command', verb: 'stop' })],
];
for (const [reason, mode, cause] of kEnds)
  test(`${mode}: it ends with ${reason}, and is exact up to there`, () => {
    const bench = recording({}, 'walls');
    if (mode === 'armed') bench.post({ type: 'command', verb: 'arm' });
    bench.until(mode, () => bench.newest?.mode === mode);
    bench.run(0.2);
    cause(bench);
    const said = in_page('it', end(bench)).said;
    const state = bench.recordings.at(-1)!;
    assert.deepEqual([state.end, said.end, said.exact, said.ticks], [reason, reason, true, state.ticks]);
    assert.equal(state.fault, reason === 'fault' ? 'host_stop' : undefined);
    assert.match(recorded_words(state, false), /^\d+ ticks, none lost\. It has ended: /);
    bench.post({ type: 'record', on: false }); // too late, and no error
    bench.run(0.1);
    assert.equal(bench.recordings.filter(({ on }) => !on).length, 1);
    if (reason === 'scene_changed') bench.until('it runs', () => bench.scenes.length >= 2);
  });

test('a damaged and a cut file are told as at the desk', () => {
  const file = join(folder, 'broken.rec');
  const damaged = walls.slice();
  damaged[damaged.length >> 1] ^= 1;
  for (const bytes of [damaged, walls.slice(0, 40), new Uint8Array([1, 2, 3]), new Uint8Array()]) {
    writeFileSync(file, bytes);
    const desk = JSON.parse(spawnSync(kThimble, ['replay', file, '--json'], { encoding: 'utf8' }).stderr);
    const { exit_code: _, ...error } = desk.error;
    const { said, log } = in_page(file, bytes);
    assert.deepEqual([said.error, log.length], [error, 0]);
    assert.equal(replayed_words(said), `No replay: ${error.cause}.`);
  }
  const cut = walls.slice(0, Math.floor(walls.length * 0.75));
  writeFileSync(file, cut);
  const said = assert_same(file, cut);
  assert.deepEqual([said.exact, said.end], [true, 'cut_off']);
  assert.match(replayed_words(said), /every force to the bit\. The file was cut off/);
});

test('a file of `thimble record` is replayed in the page to the bit', { timeout: 60_000 }, async () => {
  const { command, address } = await simulator();
  try {
    const scene = scene_file('walls');
    const file = join(folder, 'desk.rec');
    thimble('upload', scene, '--device', address);
    thimble('record', file, '--scene', scene, '--home', '--arm', '--seconds', '0.5', '--device', address);
    const said = assert_same(file, readFileSync(file));
    assert.ok(said.exact && said.ticks > 2000, JSON.stringify(said));
  } finally {
    await command.stop();
  }
});
