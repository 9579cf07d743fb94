// The site as a host serves it that sends no special headers, in a folder.
import { readFileSync, statSync } from 'node:fs';
import { type Server, createServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { extname, join } from 'node:path';

import { kSite } from './modules';

const kTypes: Record<string, string> = { '.html': 'text/html', '.js': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm' };
const kFolder = '/some/folder/';

export async function serve_site(): Promise<{ server: Server; address: string }> {
  const server = createServer((request, answer) => {
    const path = new URL(request.url ?? '/', 'http://site').pathname;
    const file = join(kSite, path.slice(kFolder.length) || 'index.html');
    if (!path.startsWith(kFolder) || !statSync(file, { throwIfNoEntry: false })?.isFile()) return void answer.writeHead(404).end();
    answer.writeHead(200, { 'content-type': kTypes[extname(file)] ?? 'application/octet-stream' }).end(readFileSync(file));
  });
  await new Promise<void>((listening) => server.listen(0, '127.0.0.1', listening));
  return { server, address: `http://127.0.0.1:${(server.address() as AddressInfo).port}${kFolder}` };
}
