// The site's controller in a browser: the hashes of its logs against those of `thimble simulate`.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { join } from 'node:path';

import { build } from 'esbuild';

import { kSite } from './modules';
import type { Run } from './runs';

export const kRate_Hz = 4000;

// Serves the module and what it runs.
async function serve(runs: Run[]): Promise<{ address: string; close(): void }> {
  const { outputFiles } = await build({
    entryPoints: [new URL('../../src/in_page/module.ts', import.meta.url).pathname],
    bundle: true,
    format: 'esm',
    write: false,
  });
  const files: Record<string, [string, Uint8Array]> = {
    '/': ['text/html', Buffer.from('<!doctype html><title>modules</title>')],
    '/module.js': ['text/javascript', outputFiles[0].contents],
    '/thimble.wasm': ['application/wasm', readFileSync(join(kSite, 'thimble.wasm'))],
  };
  runs.forEach((run, at) => {
    files[`/${at}/image`] = ['application/octet-stream', run.image];
    files[`/${at}/path`] = ['application/octet-stream', run.path];
  });
  const server = createServer((request, answer) => {
    const [type, bytes] = files[request.url ?? ''] ?? ['text/plain', Buffer.from('')];
    answer.writeHead(request.url !== undefined && request.url in files ? 200 : 404, { 'content-type': type }).end(bytes);
  });
  await new Promise<void>((listening) => server.listen(0, '127.0.0.1', listening));
  return { address: `http://127.0.0.1:${(server.address() as AddressInfo).port}/`, close: () => void server.close() };
}

// In a browser: the hashes of the logs.
const in_browser = (count: number): string => `(async () => {
  const { Module } = await import('/module.js');
  const bytes = async (name) => new Uint8Array(await (await fetch(name)).arrayBuffer());
  const module = new Module(await WebAssembly.compileStreaming(fetch('/thimble.wasm')));
  const hashes = [];
  for (let at = 0; at < ${count}; ++at) {
    const image = await bytes('/' + at + '/image');
    module.put(image, await bytes('/' + at + '/path'));
    const log = module.given(module.call.simulate(image.length, 0, ${kRate_Hz}));
    hashes.push([...new Uint8Array(await crypto.subtle.digest('SHA-256', log))].map((it) => it.toString(16).padStart(2, '0')).join(''));
  }
  return hashes;
})()`;

interface Page {
  goto(address: string): Promise<unknown>;
  evaluate(code: string): Promise<unknown>;
}

export async function same_logs(page: Page, runs: Run[]): Promise<void> {
  const site = await serve(runs);
  try {
    await page.goto(site.address);
    const hashes = (await page.evaluate(in_browser(runs.length))) as string[];
    const others = runs.filter((run, at) => createHash('sha256').update(run.log).digest('hex') !== hashes[at]);
    assert.deepEqual(
      others.map((run) => run.name),
      [],
    );
  } finally {
    site.close();
  }
}
