// A board on a serial port of the browser, without hardware: Web Serial is replaced by a port whose bytes go over a WebSocket to the pty of a
// thimble-sim.
import { constants, openSync } from 'node:fs';
import type { AddressInfo } from 'node:net';
import { ReadStream, WriteStream } from 'node:tty';

import type { Page } from 'playwright-core';
import { type WebSocket as Peer, WebSocketServer } from 'ws';

import { Command } from '../real/command';

export class Board {
  private readonly peers = new Set<Peer>();
  private held: (() => void)[] | null = null; // what the host has sent, while it is held

  private constructor(
    private readonly simulator: Command,
    readonly tcp: string, // for other programs
    private readonly bridge: WebSocketServer,
    private readonly pty: string,
  ) {
    bridge.on('connection', (peer: Peer) => this.connect(peer));
  }

  static async start(...words: string[]): Promise<Board> {
    const all = ['--name', `site-${process.pid}`, '--tcp', '0', ...words];
    const [simulator, lines] = await Command.start('thimble-sim', all, (line) => line === 'ready');
    const said = lines.join('\n');
    const bridge = new WebSocketServer({ port: 0, host: '127.0.0.1' });
    return new Board(simulator, /tcp:[^\s,]+/.exec(said)![0], bridge, /slcan:([^\s,]+)/.exec(said)![1]);
  }
  async stop(): Promise<void> {
    this.bridge.close();
    for (const client of this.bridge.clients) client.terminate();
    await this.simulator.stop();
  }

  // Before the page is loaded.
  async put_into(page: Page): Promise<void> {
    await page.addInitScript('globalThis.__name = (it) => it'); // of what tsx makes of a function
    await page.addInitScript(replace_serial, `ws://127.0.0.1:${(this.bridge.address() as AddressInfo).port}`);
  }
  unplug(): void {
    for (const peer of this.peers) peer.close();
  }
  kill(): Promise<unknown> {
    return this.simulator.stop('SIGKILL');
  }
  // What the host sends comes when it is held no more.
  hold(yes: boolean): void {
    for (const send of this.held ?? []) send();
    this.held = yes ? [] : null;
  }

  private connect(peer: Peer): void {
    const open = (): number => openSync(this.pty, constants.O_RDWR | constants.O_NOCTTY);
    const [from, to] = [new ReadStream(open()), new WriteStream(open())];
    this.peers.add(peer);
    peer.on('message', (bytes: Buffer) => {
      if (this.held) this.held.push(() => to.write(bytes));
      else to.write(bytes);
    });
    from.on('data', (bytes) => peer.send(bytes));
    peer.on('close', () => (this.peers.delete(peer), from.destroy(), to.destroy()));
    from.on('error', () => peer.close());
    to.on('error', () => peer.close());
  }
}

// Runs in the page before it: a port over a WebSocket.
function replace_serial(address: string): void {
  const port = {
    readable: null as ReadableStream<Uint8Array> | null,
    writable: null as WritableStream<Uint8Array> | null,
    async open(): Promise<void> {
      if (this.readable !== null) throw new DOMException('The port is already open.', 'InvalidStateError');
      if ('gone' in globalThis) throw new DOMException('Failed to open serial port.', 'NetworkError');
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
