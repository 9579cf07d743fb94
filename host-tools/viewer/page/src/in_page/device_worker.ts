// The worker of the device: what thimble-sim is elsewhere. In real time; a hidden page pauses it, and its clock with it.
import type { TickForces } from '../sound_queue';
import type { Load } from '../transport';
import { Device, type DeviceOptions } from './device';

export interface Begin {
  begin: { compiled: WebAssembly.Module; options: DeviceOptions; number: number }; // number: of the device, told with its jobs
}
export type ToDevice =
  | Begin
  | { post: object }
  | { deliver: { head: string; image: Uint8Array<ArrayBuffer> } }
  | { learn: { head: string; image: Uint8Array<ArrayBuffer> } }
  | { pause: boolean }
  | { port_open: boolean }
  | { port_in: Uint8Array }
  | { sound: MessagePort | null }; // where the forces of all ticks go
export type FromDevice =
  | { message: string }
  | { image: Uint8Array<ArrayBuffer> | null }
  | { recording: Uint8Array<ArrayBuffer> }
  | { compile: { file: string; text?: string }; number: number }
  | { save: { file: string; text: string } }
  | { port_out: Uint8Array<ArrayBuffer>; number: number }
  | { load: Load }
  | { failed: string };

const kRate_Hz = 4000; // of the board, where nothing else is asked for
const kPeriod_ms = 4; // the shortest that a browser's timers have
const kLoadEvery_ms = 1000;

let device: Device | null = null;
let running: DeviceOptions = {};
let running_number = 0;
let sound: MessagePort | null = null;
let timer: ReturnType<typeof setInterval> | undefined;
let hidden_since_ms: number | null = null;
let hidden_ms = 0;
const load = { since_ms: 0, busy_ms: 0, ticks: 0 };

const now_ms = (): number => (hidden_since_ms ?? performance.now()) - hidden_ms;
const tell = (message: FromDevice, transfer: Transferable[] = []): void => postMessage(message, { transfer });

function guarded(work: () => void): void {
  try {
    work();
  } catch (error) {
    clearInterval(timer);
    device = null;
    tell({ failed: error instanceof Error ? error.message : String(error) });
  }
}

function round(): void {
  const begin_ms = performance.now();
  guarded(() => device?.round());
  send_port();
  send_forces();
  count(begin_ms);
}

function send_forces(): void {
  if (sound === null || device === null) return;
  const forces_N = device.forces();
  if (forces_N.length === 0) return;
  const ticks: TickForces = { forces_N, arms: running.arms ?? 1, rate_Hz: running.rate_Hz ?? kRate_Hz };
  sound.postMessage(ticks, [forces_N.buffer]);
}

function send_port(): void {
  const bytes = device?.port_out();
  if (bytes && bytes.length > 0) tell({ port_out: bytes, number: running_number }, [bytes.buffer]);
}

function count(begin_ms: number): void {
  const end_ms = performance.now();
  load.busy_ms += end_ms - begin_ms;
  const span_ms = end_ms - load.since_ms;
  if (span_ms < kLoadEvery_ms || device === null) return;
  const ticks = device.ticks;
  tell({
    load: { ticks: ticks - load.ticks, lost_s: device.skipped_s, busy: load.busy_ms / span_ms, worst_tick_us: device.worst_tick_us() },
  });
  Object.assign(load, { since_ms: end_ms, busy_ms: 0, ticks });
}

function begin({ compiled, options, number }: Begin['begin']): void {
  clearInterval(timer);
  device = new Device(
    compiled,
    options,
    {
      message: (message) => tell({ message }),
      image: (image) => tell({ image }),
      recording: (recording) => tell({ recording }, [recording.buffer]),
      compile: (job) => tell({ compile: job, number }),
      save: (file) => tell({ save: file }),
    },
    now_ms,
  );
  running = options;
  running_number = number;
  device.listen(sound !== null);
  Object.assign(load, { since_ms: performance.now(), busy_ms: 0, ticks: 0 });
  timer = setInterval(round, kPeriod_ms);
}

function pause(hidden: boolean): void {
  if (hidden === (hidden_since_ms !== null)) return;
  if (hidden_since_ms !== null) hidden_ms += performance.now() - hidden_since_ms;
  hidden_since_ms = hidden ? performance.now() : null;
  clearInterval(timer);
  if (!hidden) timer = setInterval(round, kPeriod_ms);
}

onmessage = ({ data }: MessageEvent<ToDevice>) =>
  guarded(() => {
    if ('begin' in data) begin(data.begin);
    else if ('post' in data) device?.post(data.post);
    else if ('deliver' in data) device?.deliver(data.deliver.head, data.deliver.image);
    else if ('learn' in data) device?.learn(data.learn.head, data.learn.image);
    else if ('pause' in data) pause(data.pause);
    else if ('sound' in data) {
      sound?.close();
      sound = data.sound;
      device?.listen(sound !== null);
    } else if ('port_open' in data) device?.port_open(data.port_open);
    else device?.port_in(data.port_in);
    send_port();
  });
