// A board on a serial port of the browser, without hardware: Web Serial is replaced by a port whose bytes go to thimble-sim. Listed, uploaded to,
// homed, armed, watched, stopped; unplugged and plugged in again.
import assert from 'node:assert/strict';
import { type AddressInfo, type Socket, connect } from 'node:net';
import { after, before, test } from 'node:test';

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
  [simulator, lines] = await Command.start(
    'thimble-sim',
    ['--tcp', '0', '--no-pty', '--name', `site-${process.pid}`],
    (line) => line === 'ready',
  );
  const port = Number(/tcp:[\d.]+:(\d+)/.exec(lines.join())?.[1]);
  bridge = new WebSocketServer({ port: 0, host: '127.0.0.1' });
  bridge.on('connection', (web: Peer) => {
    const device: Socket = connect(port, '127.0.0.1');
    web.on('message', (bytes: Buffer) => device.write(bytes));
    device.on('data', (bytes) => web.send(bytes));
    const unplug = (): void => web.close();
    plugged.add(unplug);
    web.on('close', () => (plugged.delete(unplug), device.destroy()));
    device.on('close', () => web.close());
    device.on('error', () => web.close());
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
      });
      this.writable = new WritableStream({ write: (bytes) => socket.send(bytes as Uint8Array<ArrayBuffer>) });
    },
    async close(): Promise<void> {},
  };
  Object.defineProperty(navigator, 'serial', { value: Object.assign(new EventTarget(), { requestPort: async () => port }) });
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
  await page.close();
});
