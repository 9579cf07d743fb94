// The compiler module (host-tools/in_page/compiler.cpp) and the files that it reads: those of the gallery, fetched when a scene names them, and
// those that the user has given.
import { Directory, File, type Inode } from '@bjorn3/browser_wasi_shim';

import { Module } from './module';

export interface Issue {
  name: string;
  cause: string;
  remedy: string;
  pointer: string;
  line: number;
  column: number;
}

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

  constructor(private readonly compiled: WebAssembly.Module) {}

  // path: "/scenes/ring/ring.obj".
  put_file(path: string, bytes: Uint8Array): void {
    const names = path.split('/').filter((name) => name !== '');
    const name = names.pop() as string;
    let folder = this.root;
    for (const one of names) {
      const below = folder.get(one) ?? new Directory(new Map());
      if (!(below instanceof Directory)) throw new Error(`${path}: ${one} is a file`);
      folder.set(one, below);
      folder = below.contents;
    }
    folder.set(name, new File(bytes));
  }

  compile(file: string, text: string): { head: Compiled; image: Uint8Array<ArrayBuffer> } {
    try {
      this.module ??= new Module(this.compiled, undefined, () => performance.now(), this.root);
      const name = new TextEncoder().encode(file);
      this.module.put(name, text);
      const head = JSON.parse(this.module.given_text(this.module.call.compile(name.length))) as Compiled;
      return { head, image: this.module.given(this.module.call.compiled()) };
    } catch (error) {
      this.module = null; // it has trapped: out of memory, say
      const cause = error instanceof Error ? error.message : String(error);
      const issue = { name: 'compiler-failed', cause, remedy: 'make the scene smaller', pointer: '', line: 0, column: 0 };
      return { head: { name: '', objects: [], warnings: [], issues: [issue], more: 0 }, image: new Uint8Array() };
    }
  }
}
