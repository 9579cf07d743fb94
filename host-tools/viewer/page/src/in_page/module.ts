// The WebAssembly module of host-tools/in_page: its files, its clock, and bytes in and out. Runs in workers and in Node.js.
import { ConsoleStdout, Directory, File, type Inode, OpenFile, PreopenDirectory, WASI } from '@bjorn3/browser_wasi_shim';

const kMonotonic = 1;

// What it calls (host-tools/in_page).
export type Imports = Partial<Record<Import, (...numbers: number[]) => void>>;
type Import = 'wait' | 'message' | 'image' | 'recording' | 'compile' | 'save' | 'log';
const kNothing = (): void => {};
const kNoImports: Required<Imports> = {
  wait: kNothing,
  message: kNothing,
  image: kNothing,
  recording: kNothing,
  compile: kNothing,
  save: kNothing,
  log: kNothing,
};
type Exported = Record<string, (...numbers: number[]) => number>;

export class Module {
  readonly call: Exported;
  private readonly memory: WebAssembly.Memory;

  // imports: of the module `page`. now_ms: its monotonic clock. files: its root folder.
  constructor(
    compiled: WebAssembly.Module,
    imports: Imports = {},
    now_ms: () => number = () => performance.now(),
    files: Map<string, Inode> = new Map(),
  ) {
    const say = ConsoleStdout.lineBuffered((line) => console.error(line));
    files.set('dev', new Directory(new Map([['null', new File([])]])));
    const wasi = new WASI([], [], [new OpenFile(new File([])), say, say, new PreopenDirectory('/', files)], { debug: false });
    const clock = wasi.wasiImport.clock_time_get;
    wasi.wasiImport.clock_time_get = (id: number, precision: bigint, at: number): number => {
      if (id !== kMonotonic) return clock(id, precision, at) as number;
      new DataView(this.memory.buffer).setBigUint64(at, BigInt(Math.round(now_ms() * 1e6)), true);
      return 0;
    };
    const instance = new WebAssembly.Instance(compiled, { wasi_snapshot_preview1: wasi.wasiImport, page: { ...kNoImports, ...imports } });
    this.call = instance.exports as Exported;
    this.memory = instance.exports.memory as WebAssembly.Memory;
    wasi.initialize(instance as Parameters<WASI['initialize']>[0]);
  }

  // For the next call.
  put(...parts: (string | Uint8Array)[]): void {
    const bytes = parts.map((part) => (typeof part === 'string' ? new TextEncoder().encode(part) : part));
    let at = this.call.place(bytes.reduce((sum, part) => sum + part.length, 0));
    const all = new Uint8Array(this.memory.buffer);
    for (const part of bytes) {
      all.set(part, at);
      at += part.length;
    }
  }
  // What the last call gave, which returned its size.
  given(size: number): Uint8Array<ArrayBuffer> {
    return this.bytes(this.call.given(), size);
  }
  given_text(size: number): string {
    return new TextDecoder().decode(this.given(size));
  }
  bytes(at: number, size: number): Uint8Array<ArrayBuffer> {
    return new Uint8Array(this.memory.buffer as ArrayBuffer, at, size).slice();
  }
  text(at: number, size: number): string {
    return new TextDecoder().decode(this.bytes(at, size));
  }
  word(at: number, value: number): void {
    new DataView(this.memory.buffer).setUint32(at, value, true);
  }
}
