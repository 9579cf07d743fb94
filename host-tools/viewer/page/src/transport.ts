// What the page needs of whatever is between it and a device: the server of `thimble view`, the device in the page, or a serial port.
import type { PageMessage, ServerMessage } from './protocol';

// connecting: not yet, or not again. live: states come. silent: the other end is there and sends no state. controller-lost: it said so.
// server-gone: nobody answers.
export type Link = 'connecting' | 'live' | 'silent' | 'controller-lost' | 'server-gone';

export interface Listener {
  on_message(message: ServerMessage): void;
  on_link(link: Link): void;
}

export interface Transport {
  send(message: PageMessage): boolean; // false: there is no connection
  image(): Promise<Uint8Array<ArrayBuffer> | null>; // of the running scene; null: not known. Throws
  scenes(): Promise<string[]>; // to pick from. Throws
  // Leaves the device for a board that the user chooses, where that can be. Rejects with why not.
  choose_board?: () => Promise<void>;
}
