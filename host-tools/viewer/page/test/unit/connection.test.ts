// What the page says of its link, with a WebSocket and a clock of the test's.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Connection } from '../../src/connection';
import type { Link } from '../../src/transport';

class Socket {
  static readonly OPEN = 1;
  static all: Socket[] = [];
  readyState = 0;
  onopen: (() => void) | null = null;
  onmessage: ((event: { data: string }) => void) | null = null;
  onclose: (() => void) | null = null;
  constructor() {
    Socket.all.push(this);
  }
  close(): void {
    this.readyState = 2; // the other end never answers
  }
  open(): void {
    this.readyState = Socket.OPEN;
    this.onopen?.();
  }
  say(message: object): void {
    this.onmessage?.({ data: JSON.stringify(message) });
  }
}

const kState = { type: 'state', time_s: 1, arms: [] };

function connect() {
  const links: Link[] = [];
  let now_ms = 0;
  let watch = () => {};
  const later: (() => void)[] = [];
  Socket.all = [];
  Object.assign(globalThis, {
    location: { protocol: 'http:', host: 'test' },
    WebSocket: Socket,
    setInterval: (call: () => void) => void (watch = call),
    setTimeout: (call: () => void) => void later.push(call),
  });
  performance.now = () => now_ms;
  new Connection('', { on_message: () => {}, on_link: (link) => links.push(link) });
  return {
    links,
    later,
    pass(seconds: number, each_s: () => void = () => {}): void {
      for (let i = 0; i < 4 * seconds; ++i) {
        now_ms += 250;
        if (i % 4 === 3) each_s();
        watch();
      }
    },
  };
}

test('the last state of a controller that has gone does not make it live', () => {
  const { links, pass } = connect();
  const [socket] = Socket.all;
  socket.open();
  socket.say({ type: 'link', up: false });
  socket.say(kState);
  pass(3, () => socket.say({ type: 'link', up: false }));
  assert.deepEqual(links, ['controller-lost']);
  socket.say({ type: 'link', up: true });
  socket.say(kState);
  assert.deepEqual(links, ['controller-lost', 'connecting', 'live']);
});

test('a server that only says that it is there is silent, and is kept', () => {
  const { links, pass } = connect();
  const [socket] = Socket.all;
  socket.open();
  socket.say(kState);
  pass(60, () => socket.say({ type: 'link', up: true }));
  assert.deepEqual(links, ['live', 'silent']);
  assert.equal(Socket.all.length, 1);
});

test('a connection that says nothing at all is given up, and another one opened', () => {
  const { links, later, pass } = connect();
  const [dead] = Socket.all;
  dead.open();
  dead.say(kState);
  pass(10);
  assert.deepEqual(links, ['live', 'silent', 'server-gone']);
  assert.equal(later.length, 1);
  later[0]();
  assert.equal(Socket.all.length, 2);
  dead.say(kState); // too late
  assert.equal(links.at(-1), 'server-gone');
  Socket.all[1].open();
  Socket.all[1].say(kState);
  assert.deepEqual(links.slice(3), ['connecting', 'live']);
});
