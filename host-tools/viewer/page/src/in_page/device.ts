// The device module (host-tools/in_page/device.cpp) and its session's thread, which leaves the module where it waits and is entered again:
// Binaryen's Asyncify puts its stack away and back.
import { Module } from './module';

const kStack_bytes = 65536;
const kMostAnswers = 64; // of an upload in a round: the ticks that are due meanwhile are not to be late
enum Stack {
  kUsual,
  kLeaving,
  kEntering,
}

export interface DeviceOptions {
  serial?: boolean;
  arm?: string;
  rate_Hz?: number;
  arms?: number;
  seed?: number;
}

export interface Told {
  message(text: string): void; // JSON, as over the WebSocket of `thimble view`
  image(bytes: Uint8Array<ArrayBuffer> | null): void; // of the scene of the next message
  recording(bytes: Uint8Array<ArrayBuffer>): void; // that the next message is about
  compile(job: { file: string; text?: string }): void;
  save(file: { file: string; text: string }): void;
}

export class Device {
  private readonly module: Module;
  private readonly stack: number;
  private wake_ms = 0; // while the session waits: until then

  // Throws an Error that says why there is no such device.
  constructor(
    compiled: WebAssembly.Module,
    options: DeviceOptions,
    told: Told,
    private readonly now_ms: () => number,
  ) {
    const module = new Module(
      compiled,
      {
        wait: (ms) => this.wait(ms),
        message: (at, size) => told.message(module.text(at, size)),
        image: (at, size) => told.image(size === 0 ? null : module.bytes(at, size)),
        recording: (at, size) => told.recording(module.bytes(at, size)),
        compile: (at, size) => told.compile(JSON.parse(module.text(at, size))),
        save: (at, size) => told.save(JSON.parse(module.text(at, size))),
      },
      now_ms,
    );
    this.module = module;
    this.stack = module.call.device_stack(kStack_bytes);
    module.word(this.stack, this.stack + 8);
    module.word(this.stack + 4, this.stack + kStack_bytes);
    module.put(JSON.stringify(options));
    const why = module.given_text(module.call.device_start());
    if (why !== '') throw new Error(why);
    this.run();
  }

  // The ticks that are due, and what the session has to do.
  round(): void {
    this.module.call.device_round();
    for (let left = kMostAnswers; left > 0 && this.module.call.device_due() !== 0; --left) {
      this.go_on();
      this.module.call.device_round();
    }
    if (this.now_ms() >= this.wake_ms) this.go_on();
  }
  post(message: object): void {
    this.module.put(JSON.stringify(message));
    this.module.call.device_post();
  }
  // What the compiler said of the last job (compiler.cpp).
  deliver(head: string, image: Uint8Array): void {
    const bytes = new TextEncoder().encode(head);
    this.module.put(bytes, image);
    this.module.call.device_deliver(bytes.length);
  }
  // A scene that the session has not asked for. head: that of the compiler with "file", and "draft" where the image is of another text than that
  // of the file.
  learn(head: string, image: Uint8Array): void {
    const bytes = new TextEncoder().encode(head);
    this.module.put(bytes, image);
    this.module.call.device_learn(bytes.length);
  }
  port_open(open: boolean): void {
    this.module.call.device_port_open(open ? 1 : 0);
    this.go_on();
  }
  port_in(bytes: Uint8Array): void {
    this.module.put(bytes);
    this.module.call.device_port_in();
    this.go_on();
  }
  port_out(): Uint8Array<ArrayBuffer> {
    return this.module.given(this.module.call.device_port_out());
  }
  // Of the simulated board: keeps the forces of its ticks from now on, or no more.
  listen(yes: boolean): void {
    this.module.call.device_listen(yes ? 1 : 0);
  }
  // x, y, z of each arm of each tick since the last call, in newtons, on the hand.
  forces(): Float32Array<ArrayBuffer> {
    return new Float32Array(this.module.given(this.module.call.device_forces()).buffer);
  }
  // Since the last call.
  worst_tick_us(): number {
    return this.module.call.device_worst_tick_us();
  }
  get ticks(): number {
    return this.module.call.device_ticks();
  }
  get skipped_s(): number {
    return this.module.call.device_skipped_s();
  }

  private wait(ms: number): void {
    if (this.module.call.asyncify_get_state() === Stack.kEntering) {
      this.module.call.asyncify_stop_rewind();
      return;
    }
    this.wake_ms = this.now_ms() + ms;
    this.module.call.asyncify_start_unwind(this.stack);
  }
  private go_on(): void {
    this.module.call.asyncify_start_rewind(this.stack);
    this.run();
  }
  private run(): void {
    this.module.call.device_run();
    if (this.module.call.asyncify_get_state() === Stack.kLeaving) this.module.call.asyncify_stop_unwind();
    else throw new Error('the session has ended');
  }
}
