// What the server says, beside a page: a WebSocket without the token, which may only look.
import { once } from 'node:events';
import { WebSocket } from 'ws';

import type { ServerEvent, ServerMessage, State } from '../../src/protocol';
import type { Vec3 } from '../../src/vector';
import { until } from '../browser/browser';

export const live_address = (url: string): string => url.replace('http', 'ws').replace(/\/(\?|$)/, '/live$1');

export class Watcher {
  state: State | undefined;
  states = 0; // so many have come
  readonly events: ServerEvent[] = [];

  private constructor(readonly socket: WebSocket) {
    socket.on('message', (data) => {
      const message = JSON.parse(String(data)) as ServerMessage;
      if (message.type === 'state') {
        this.state = message;
        ++this.states;
      }
      if (message.type === 'event') this.events.push(message);
    });
  }

  // `token`: as the address of the page has it; without it the watcher may only look.
  static async open(url: string, token = false): Promise<Watcher> {
    const socket = new WebSocket(live_address(token ? url : url.replace(/\?.*/, '')));
    const watcher = new Watcher(socket);
    await once(socket, 'open');
    await until('a state', () => watcher.state !== undefined);
    return watcher;
  }

  close(): void {
    this.socket.close();
  }

  hand_m(arm: number): Vec3 {
    const hand_m = this.state?.arms[arm]?.hand_m;
    if (hand_m === undefined) throw new Error(`nothing is known of hand ${arm}`);
    return hand_m;
  }

  // Where the hand is when it has come to rest. Counted in states, because a loaded machine takes its time, and sends fewer of them.
  async hand_at_rest(arm: number): Promise<Vec3> {
    await this.next(3);
    let before: Vec3 | undefined;
    await until('a hand at rest', async () => {
      before = this.hand_m(arm);
      await this.next(3);
      return before.every((value, i) => Math.abs(value - this.hand_m(arm)[i]) < 1e-5);
    });
    return this.hand_m(arm);
  }

  private async next(states: number): Promise<void> {
    const wanted = this.states + states;
    while (this.states < wanted && this.socket.readyState === WebSocket.OPEN) await once(this.socket, 'message');
  }
}
