// What the page needs of whatever is between it and a device: the server of `thimble view`, the device in the page, or a serial port.
import type { PageMessage, ServerMessage } from './protocol';

// connecting: not yet, or not again. live: states come. silent: the other end is there and sends no state. controller-lost: it said so.
// server-gone: nobody answers.
export type Link = 'connecting' | 'live' | 'silent' | 'controller-lost' | 'server-gone';

// Of a device in the page, in the last second.
export interface Load {
  ticks: number;
  lost_s: number; // since the start: that no tick has simulated, because this machine was late
  busy: number; // part of a core
  worst_tick_us: number; // 0: no ticks run here
}

export interface Listener {
  on_message(message: ServerMessage): void;
  on_link(link: Link): void;
  on_load?(load: Load): void;
}

// The scenes with what shows them to a new user.
export interface SceneGallery {
  pictures(): Promise<{ name: string; picture?: string }[]>; // addresses of pictures. Throws
  hand_path(name: string): Promise<string | null>; // of a scripted hand, CSV; null: there is none. Throws
}

// As `thimble replay --json` says; or why there is none.
export interface Replayed {
  exact: boolean;
  ticks: number;
  contact_ticks: number;
  end: string;
  scene: string;
  missing: number;
  first_tick: number;
  exact_to: number;
  not_replayed: number;
  differs_at?: number;
  gap_at?: number;
  cut_bytes: number;
  error?: { name: string; cause: string; remedy: string };
}
export type Replayer = (
  name: string,
  recording: Uint8Array<ArrayBuffer>,
  wants_log: boolean,
) => Promise<{ replayed: Replayed; log: Blob | null }>;

// A file of the user's that a scene may name.
export interface OwnFile {
  path: string; // "/scenes/ring/part.stl"
  size: number; // bytes
}
export interface OwnFiles {
  readonly all: OwnFile[];
  remove(path: string): Promise<void>;
}

export interface Transport {
  send(message: PageMessage): boolean; // false: there is no connection
  image(): Promise<Uint8Array<ArrayBuffer> | null>; // of the running scene; null: not known. Throws
  scenes(): Promise<string[]>; // to pick from. Throws
  // A file that the scene that runs may name, for this transport to keep as long as the scene runs. Rejects with why not.
  put_file?: (name: string, bytes: Uint8Array<ArrayBuffer>) => Promise<void>;
  readonly own_files?: OwnFiles; // that have been put, where this browser keeps them
  keeps?: string; // what saving a scene does, as the label of a button; without it: the scene's file is written
  restore?: (scene: string) => void; // forgets what was saved of it; before it is opened, if called at once after its pick
  // Leaves the device for a board that the user chooses, where that can be. Rejects with why not.
  choose_board?: () => Promise<void>;
  // The forces of every tick go to this port (TickForces), or no more; where the device is in the page.
  listen?: (port: MessagePort | null) => void;
  readonly gallery?: SceneGallery;
  recording(): Promise<Uint8Array<ArrayBuffer>>; // the file of the last one. Throws
  readonly replay?: Replayer; // where there is one
  // The address that opens the scene that runs. Rejects with a LinkError.
  link_to_scene?: () => Promise<string>;
}
