// The compiler and the replay of recordings (host-tools/in_page/compiler.cpp, replay.cpp), and the files that they read: those of the gallery, fetched
// when a scene names them, and those that the user has given.
import { Directory, File, type Inode } from '@bjorn3/browser_wasi_shim';

import type { Issue } from '../protocol';
import type { Replayed } from '../transport';
import { Module } from './module';

export interface Compiled {
  name: string;
  objects: string[];
  warnings: string[];
  issues: Issue[]; // without any, there is an image
  more: number;
  crc?: number; // of the image
}

export class Compiler {
  private readonly root = new Map<string, Inode>();
  private module: Module | null = null;
  private log: ((part: Uint8Array<ArrayBuffer>) => void) | null = null;

  constructor(private readonly compiled: WebAssembly.Module) {}

  // path: "/scenes/ring/ring.obj". bytes: null: there is no such file any more.
  put_file(path: string, bytes: Uint8Array | null): void {
    const names = path.split('/').filter((name) => name !== '');
    const name = names.pop() as string;
    let folder = this.root;
    for (const one of names) {
      const below = folder.get(one) ?? new Directory(new Map());
      if (!(below instanceof Directory)) throw new Error(`${path}: ${one} is a file`);
      folder.set(one, below);
      folder = below.contents;
    }
    if (bytes === null) folder.delete(name);
    else folder.set(name, new File(bytes));
  }

  compile(file: string, text: string): { head: Compiled; image: Uint8Array<ArrayBuffer> } {
    try {
      const module = this.open();
      const name = new TextEncoder().encode(file);
      module.put(name, text);
      const head = JSON.parse(module.given_text(module.call.compile(name.length))) as Compiled;
      return { head, image: module.given(module.call.compiled()) };
    } catch (error) {
      const cause = this.close(error);
      const issue = { name: 'compiler-failed', cause, remedy: 'make the scene smaller', pointer: '', line: 0, column: 0 };
      return { head: { name: '', objects: [], warnings: [], issues: [issue], more: 0 }, image: new Uint8Array() };
    }
  }

  // log: takes the parts of the log, CSV; without it there is none.
  replay(name: string, recording: Uint8Array, log?: (part: Uint8Array<ArrayBuffer>) => void): Replayed {
    try {
      const module = this.open();
      const name_bytes = new TextEncoder().encode(name);
      this.log = log ?? null;
      module.put(name_bytes, recording);
      return JSON.parse(module.given_text(module.call.replay(name_bytes.length, log ? 1 : 0))) as Replayed;
    } catch (error) {
      const cause = this.close(error);
      return { error: { name: 'replay-failed', cause, remedy: 'replay it with `thimble replay`' } } as Replayed;
    }
  }

  private open(): Module {
    if (this.module !== null) return this.module;
    const log = (at: number, size: number): void => this.log?.(module.bytes(at, size));
    const module = new Module(this.compiled, { log }, () => performance.now(), this.root);
    return (this.module = module);
  }
  // It has trapped: out of memory, say.
  private close(error: unknown): string {
    this.module = null;
    return error instanceof Error ? error.message : String(error);
  }
}
