// The WebSocket to the server. It reconnects by itself and reports the state of the link: to the server, and from there to the controller.
import { type PageMessage, type ServerMessage, parse_message } from './protocol';
import type { Link, Listener, Transport } from './transport';

const kSilent_ms = 1500;
const kLost_ms = 5000; // the server sends something every 2 s, also without a controller
const kFirstWait_ms = 300;
const kLongestWait_ms = 3000;

export class Connection implements Transport {
  private socket: WebSocket | null = null;
  private link: Link = 'connecting';
  private wait_ms = kFirstWait_ms;
  private last_state_ms = 0;
  private last_heard_ms = 0;
  private controller_up = true;

  constructor(
    private readonly query: string, // with the token
    private readonly listener: Listener,
  ) {
    this.open();
    setInterval(() => this.watch(), 250);
  }

  // False if there is no connection.
  send(message: PageMessage): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  async image(): Promise<Uint8Array<ArrayBuffer> | null> {
    const answer = await fetch(`scene.thim${this.query}`, { cache: 'no-store' });
    // No scene, or one without a file; the server reports that itself.
    if (answer.status === 404) return null;
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    return new Uint8Array(await answer.arrayBuffer());
  }

  async recording(): Promise<Uint8Array<ArrayBuffer>> {
    const answer = await fetch(`last.rec${this.query}`, { cache: 'no-store' });
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    return new Uint8Array(await answer.arrayBuffer());
  }

  async scenes(): Promise<string[]> {
    const answer = await fetch(`scenes.json${this.query}`, { cache: 'no-store' });
    const names: unknown = answer.ok ? await answer.json() : [];
    return Array.isArray(names) ? names.map(String) : [];
  }

  async put_file(name: string, bytes: Uint8Array<ArrayBuffer>): Promise<void> {
    const answer = await fetch(`files/${name}${this.query}`, { method: 'PUT', body: bytes });
    if (!answer.ok) throw new Error(`${name}: ${(await answer.text()) || `the server answered ${answer.status}`}`);
  }

  private open(): void {
    const socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/live${this.query}`);
    this.socket = socket;
    socket.onopen = () => {
      this.wait_ms = kFirstWait_ms;
      this.controller_up = true;
      this.last_state_ms = this.last_heard_ms = performance.now();
      this.tell('connecting');
    };
    socket.onmessage = (event) => {
      this.last_heard_ms = performance.now();
      const message = typeof event.data === 'string' ? parse_message(event.data) : null;
      if (message !== null) this.take(message);
    };
    // An error is followed by a close.
    socket.onclose = () => this.open_later();
  }

  private open_later(): void {
    this.tell('server-gone');
    setTimeout(() => this.open(), this.wait_ms);
    this.wait_ms = Math.min(this.wait_ms * 2, kLongestWait_ms);
  }

  private take(message: ServerMessage): void {
    if (message.type === 'state') {
      this.last_state_ms = performance.now();
      // A new page gets the last state also if the controller is lost.
      if (this.controller_up) this.tell('live');
    } else if (message.type === 'link') {
      if (message.up === this.controller_up) return; // a heartbeat of the server
      this.controller_up = message.up;
      this.last_state_ms = performance.now();
      this.tell(message.up ? 'connecting' : 'controller-lost');
    }
    this.listener.on_message(message);
  }

  private watch(): void {
    const socket = this.socket;
    if (socket === null || socket.readyState !== WebSocket.OPEN) return;
    // The connection broke without a close: closing such a socket takes long, so do not wait for it.
    if (performance.now() - this.last_heard_ms > kLost_ms) {
      socket.onopen = socket.onmessage = socket.onclose = null;
      socket.close();
      this.socket = null;
      this.open_later();
      return;
    }
    if (this.controller_up && performance.now() - this.last_state_ms > kSilent_ms) this.tell('silent');
  }

  private tell(link: Link): void {
    if (link === this.link) return;
    this.link = link;
    this.listener.on_link(link);
  }
}

export const open_transport = (query: string, listener: Listener): Transport => new Connection(query, listener);
