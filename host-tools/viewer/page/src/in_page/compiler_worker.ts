// The worker of the compiler, which replays recordings too.
import type { Replayed } from '../transport';
import { Compiler } from './compiler';

export type ToCompiler =
  | { begin: WebAssembly.Module }
  | { put: { path: string; bytes: Uint8Array | null } } // null: there is no such file any more
  | { job: { file: string; text: string } }
  | { replay: { name: string; bytes: Uint8Array<ArrayBuffer>; wants_log: boolean } };
export interface CompileDone {
  head: string; // JSON of Compiled, with "text"
  crc: number | null; // of the image; null: there is none
  image: Uint8Array<ArrayBuffer>;
}
export interface ReplayDone {
  replayed: Replayed;
  log: Blob | null; // CSV, if it was wanted
}
export type FromCompiler = CompileDone | ReplayDone;

let compiler: Compiler | null = null;

onmessage = ({ data }: MessageEvent<ToCompiler>) => {
  if ('begin' in data) compiler = new Compiler(data.begin);
  else if ('put' in data) compiler?.put_file(data.put.path, data.put.bytes);
  else if (compiler === null) return;
  else if ('job' in data) {
    const { head, image } = compiler.compile(data.job.file, data.job.text);
    const done: FromCompiler = { head: JSON.stringify({ ...head, text: data.job.text }), crc: head.crc ?? null, image };
    postMessage(done, { transfer: [image.buffer] });
  } else {
    const { name, bytes, wants_log } = data.replay;
    const parts: Uint8Array<ArrayBuffer>[] = [];
    const replayed = compiler.replay(name, bytes, wants_log ? (part) => void parts.push(part) : undefined);
    const done: FromCompiler = { replayed, log: wants_log ? new Blob(parts, { type: 'text/csv' }) : null };
    postMessage(done);
  }
};
