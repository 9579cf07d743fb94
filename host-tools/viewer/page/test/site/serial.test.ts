// A board on a serial port of the browser, without hardware: Web Serial is replaced by a port whose bytes go to the pty of thimble-sim. Listed, uploaded to,
// homed, armed, watched, stopped; unplugged and plugged in again.
import assert from 'node:assert/strict';
import { constants, openSync } from 'node:fs';
import type { AddressInfo } from 'node:net';
import { after, before, test } from 'node:test';
import { ReadStream, WriteStream } from 'node:tty';

import type { Browser, Page } from 'playwright-core';
import { type WebSocket as Peer, WebSocketServer } from 'ws';

import { launch } from '../browser/browser';
import { Command } from '../real/command';
import { serve_site } from './serve';

const kTimeout_ms = 60_000;

let browser: Browser;
let site: Awaited<ReturnType<typeof serve_site>>;
let simulator: Command;
let bridge: WebSocketServer;
const plugged = new Set<() => void>();

before(async () => {
  site = await serve_site();
  browser = await launch();
  let lines: string[];
  [simulator, lines] = await Command.start('thimble-sim', ['--name', `site-${process.pid}`], (line) => line === 'ready');
  const pty = /slcan:([^\s,]+)/.exec(lines.join())?.[1] as string;
  bridge = new WebSocketServer({ port: 0, host: '127.0.0.1' });
  bridge.on('connection', (web: Peer) => {
    const open = (): number => openSync(pty, constants.O_RDWR | constants.O_NOCTTY);
    const [from, to] = [new ReadStream(open()), new WriteStream(open())];
    web.on('message', (bytes: Buffer) => to.write(bytes));
    from.on('data', (bytes) => web.send(bytes));
    const unplug = (): void => web.close();
    plugged.add(unplug);
    web.on('close', () => (plugged.delete(unplug), from.destroy(), to.destroy()));
    from.on('error', () => web.close());
    to.on('error', () => web.close());
  });
});
after(async () => {
  await browser.close();
  site.server.close();
  bridge.close();
  for (const client of bridge.clients) client.terminate();
  await simulator.stop();
});

// Runs in the page before it: a port over a WebSocket.
function replace_serial(address: string): void {
  const port = {
    readable: null as ReadableStream<Uint8Array> | null,
    writable: null as WritableStream<Uint8Array> | null,
    async open(): Promise<void> {
      if (this.readable !== null) throw new DOMException('The port is already open.', 'InvalidStateError');
      const socket = new WebSocket(address);
      socket.binaryType = 'arraybuffer';
      await new Promise((opened, failed) => {
        socket.onopen = opened;
        socket.onerror = failed;
      });
      this.readable = new ReadableStream({
        start(controller) {
          socket.onmessage = ({ data }) => controller.enqueue(new Uint8Array(data as ArrayBuffer));
          socket.onclose = () => controller.error(new DOMException('The device has been lost.', 'NetworkError'));
        },
        cancel: () => socket.close(),
      });
      this.writable = new WritableStream({ write: (bytes) => socket.send(bytes as Uint8Array<ArrayBuffer>) });
    },
    async close(): Promise<void> {
      if (this.readable?.locked || this.writable?.locked) throw new TypeError('The port is in use.');
      this.readable = this.writable = null;
    },
  };
  const requestPort = async (): Promise<object> => {
    if ('cancels' in globalThis) throw new DOMException('No port selected by the user.', 'NotFoundError');
    return port;
  };
  Object.defineProperty(navigator, 'serial', { value: Object.assign(new EventTarget(), { requestPort }) });
}

const text = (page: Page, name: string): Promise<string> => page.getByTestId(name).innerText();
const shows = (page: Page, name: string, wanted: string): Promise<unknown> =>
  page.waitForFunction(([id, it]) => document.querySelector(`[data-testid=${id}]`)?.textContent === it, [name, wanted], {
    timeout: kTimeout_ms,
  });

test('a board on USB with no host software', { timeout: 4 * kTimeout_ms }, async () => {
  const page = await browser.newPage();
  await page.addInitScript('globalThis.__name = (it) => it'); // of what tsx makes of a function
  await page.addInitScript(replace_serial, `ws://127.0.0.1:${(bridge.address() as AddressInfo).port}`);
  await page.goto(site.address);
  await shows(page, 'mode', 'armed'); // the device in the page
  await page.getByTestId('board').click();
  await shows(page, 'mode', 'disarmed');
  assert.ok((await page.locator('#device').innerText()).includes('serial port'));

  await page.getByTestId('scene-picker').selectOption('walls');
  await page.getByTestId('load').click();
  await shows(page, 'scene', 'walls');
  await page.getByTestId('home').click();
  await shows(page, 'mode', 'ready');
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed');
  assert.equal(await text(page, 'link'), 'live');
  await page.getByTestId('stop').click();
  await shows(page, 'mode', 'faulted');

  for (const unplug of plugged) unplug();
  await shows(page, 'link', 'controller lost');
  await shows(page, 'link', 'live'); // the fake is plugged in again at once
  await page.getByTestId('clear').click();
  await shows(page, 'mode', 'ready');

  await page.evaluate('globalThis.cancels = true');
  await page.getByTestId('board').click();
  await page.getByTestId('arm').click();
  await shows(page, 'mode', 'armed'); // who chooses no other board keeps this one
  await page.evaluate('delete globalThis.cancels');
  await page.getByTestId('board').click(); // the same one again
  await shows(page, 'link', 'live');
  await page.getByTestId('disarm').click();
  await shows(page, 'mode', 'ready');
  await page.close();
});
