// The worker of the compiler.
import { Compiler } from './compiler';

export type ToCompiler =
  { begin: WebAssembly.Module } | { put: { path: string; bytes: Uint8Array } } | { job: { file: string; text: string } };
export interface FromCompiler {
  head: string; // JSON of Compiled, with "text"
  crc: number | null; // of the image; null: there is none
  image: Uint8Array<ArrayBuffer>;
}

let compiler: Compiler | null = null;

onmessage = ({ data }: MessageEvent<ToCompiler>) => {
  if ('begin' in data) compiler = new Compiler(data.begin);
  else if ('put' in data) compiler?.put_file(data.put.path, data.put.bytes);
  else if (compiler !== null) {
    const { head, image } = compiler.compile(data.job.file, data.job.text);
    const done: FromCompiler = { head: JSON.stringify({ ...head, text: data.job.text }), crc: head.crc ?? null, image };
    postMessage(done, { transfer: [image.buffer] });
  }
};
