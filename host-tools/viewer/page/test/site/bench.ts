// The device of the site in Node.js, with a clock of the test's. The compiler answers when as much of it has passed as it took.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { basename, relative } from 'node:path';

import type { Compiler } from '../../src/in_page/compiler';
import { Device } from '../../src/in_page/device';
import type { Hello, RecordingState, SceneStarted, ServerEvent, ServerMessage, State } from '../../src/protocol';
import { all_files, compiler_of_scenes, kModule, kScenes } from './modules';

const kRound_ms = 4;

// Time passes by run().
let one: Compiler | undefined;
const compiler = (): Compiler => (one ??= compiler_of_scenes());

export class Bench {
  readonly hellos: Hello[] = [];
  readonly scenes: SceneStarted[] = [];
  readonly events: ServerEvent[] = [];
  readonly saved: { file: string; text: string }[] = [];
  readonly recordings: RecordingState[] = [];
  states: State[] = [];
  recorded: Uint8Array<ArrayBuffer> | null = null; // the last file
  image: Uint8Array | null = null;
  readonly own = new Map<string, string>(); // texts of scenes beside those of scenes/, by name
  readonly forces_N: number[] = []; // of every tick since listen()
  compiled_ms = 0; // how long the last compilation took
  private now_ms = 1000;
  private compiled: { due_ms: number; head: string; image: Uint8Array }[] = [];
  private readonly device: Device;

  constructor(options = {}) {
    this.device = new Device(
      kModule,
      options,
      {
        message: (text) => this.take(JSON.parse(text) as ServerMessage),
        image: (bytes) => (this.image = bytes),
        recording: (bytes) => (this.recorded = bytes),
        compile: (job) => this.compile(job),
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
      for (const number of this.device.forces()) this.forces_N.push(number);
      if (this.compiled.length > 0 && this.now_ms >= this.compiled[0].due_ms) {
        const { head, image } = this.compiled.shift()!;
        this.device.deliver(head, image);
      }
    }
  }
  // The hand goes straight from one place to the other.
  go(seconds: number, from_m: readonly number[], to_m: readonly number[], arm = 0): void {
    for (let time_s = 0; time_s < seconds; time_s += kRound_ms / 1000) {
      const position_m = from_m.map((at_m, axis) => at_m + ((to_m[axis] - at_m) * time_s) / seconds);
      this.post({ type: 'hand', arm, position_m });
      this.run(kRound_ms / 1000);
    }
  }
  listen(): void {
    this.device.listen(true);
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
  get clock_ms(): number {
    return this.now_ms;
  }
  get skipped_s(): number {
    return this.device.skipped_s;
  }
  get ticks(): number {
    return this.device.ticks;
  }

  private compile({ file, text }: { file: string; text?: string }): void {
    const name = file.replace('.scene.json', '');
    const path = this.own.has(name) ? `mine/${file}` : relative(kScenes, this.folder_of(file));
    const all = text ?? this.own.get(name) ?? readFileSync(this.folder_of(file), 'utf8');
    const before = process.cpuUsage(); // not the clock: other tests may hold the processors
    const { head, image } = compiler().compile(`/scenes/${path}`, all);
    const { user, system } = process.cpuUsage(before);
    this.compiled_ms = (user + system) / 1000;
    this.compiled.push({ due_ms: this.now_ms + this.compiled_ms, head: JSON.stringify({ ...head, text: all }), image });
  }
  private folder_of(file: string): string {
    const found = all_files(kScenes).find((path) => basename(path) === file);
    assert.ok(found, file);
    return found;
  }
  private take(message: ServerMessage): void {
    if (message.type === 'hello') this.hellos.push(message);
    else if (message.type === 'scene') this.scenes.push(message);
    else if (message.type === 'event') this.events.push(message);
    else if (message.type === 'recording') this.recordings.push(message);
    else if (message.type === 'state') this.states.push(message);
  }
}
