// The messages between page and server: JSON text over the WebSocket /live. The server's part of this contract is host-tools/viewer.
import type { Quat, Vec3 } from './vector';

export interface Parameter {
  name: string;
  value: number;
  unit: string;
  min: number;
  max: number;
  writable: boolean;
  text: string;
}

export interface Hello {
  type: 'hello';
  version: string;
  simulated: boolean;
  may_control: boolean;
  arms: number;
  device?: { address?: string; board?: string; firmware?: string; arm?: string };
  parameters?: Parameter[];
  commission?: { steps: { name: string; text: string }[] }; // of `thimble commission --page`
}

export type MaterialKey = 'stiffness' | 'damping' | 'static_friction' | 'dynamic_friction';
export type Material = Record<MaterialKey, number>;

export interface SceneStarted {
  type: 'scene';
  name: string;
  pick?: string; // under which it is among the scenes to pick, if it is
  crc: number;
  text_crc?: number; // of the text that it was compiled of, where its file is known
  unsaved?: boolean; // that text is not in the file
  sought?: boolean; // it is unknown, and the page looks for it
  objects: { name: string; material: Material }[];
}
// Only its name is known.
export const is_unknown = ({ name, pick, objects }: SceneStarted): boolean => name !== '' && pick === undefined && objects.length === 0;
// Its name among the scenes to pick; empty: that is not known.
export const known_as = (scene: SceneStarted): string => scene.pick ?? (is_unknown(scene) ? '' : scene.name);

export interface ArmState {
  tip_m: Vec3;
  god_m?: Vec3;
  force_N?: Vec3;
  velocity_m_s?: Vec3;
  contacts?: number;
  planes?: { normal: Vec3 }[];
  inside?: number[]; // objects that the tip was in when its contacts began: not felt until it has left them
  hand_m?: Vec3;
  links_m?: Vec3[][]; // lines from joint to joint, from the base on; where the device tells the angles of its joints
  energy_J?: number;
}

// Of `thimble commission --page`.
export interface CommissionState {
  steps: { state: 'not yet' | 'now' | 'passed' | 'found'; findings: { name: string; text: string }[]; notes: string[] }[];
  doing: string; // while nothing is asked
  prompt?: { number: number; text: string; done: string; decline?: string }; // the words of the buttons
  axis?: { name: string; slides: boolean; at_m: Vec3; direction: Vec3 }; // in question: a positive motion turns about this line, or slides along it
  turn?: number; // the way that the axis is to go first: 1 or -1
  way?: Vec3; // that the tip is to go, of length 1
  goal_m?: Vec3[][]; // links where the arm is to be
  is_live: boolean; // otherwise the arm is drawn at home
  over?: { passed: boolean; text: string };
}

// Unknown values are left out.
export interface State {
  type: 'state';
  time_s: number;
  tick?: number;
  since_us?: number; // when the ticks that are shown began, on the server's monotonic clock
  mode?: string;
  stopped_by?: string; // why it is no longer armed: its name, and a sentence
  stopped_by_text?: string;
  fault?: number;
  fault_name?: string;
  limiters?: string[];
  put_off?: { object: number; ticks: number }; // the work of ticks was spent on this object: what is left of rendering comes later
  tick_rate_Hz?: number;
  worst_tick_s?: number;
  arms: (ArmState | null)[]; // null: nothing is known of where its tip is
  bodies?: { object: number; position_m: Vec3; rotation: Quat }[];
  controls?: { object: number; q: number; on: boolean }[];
  tissues?: { object: number; arm: number; pressed: boolean; at_m: readonly [number, number]; depth_m: number }[];
  needles?: { object: number; arm: number; inside: boolean; at_m: readonly [number, number]; depth_m: number; torn: number }[];
  commission?: CommissionState;
}

export interface ServerEvent {
  type: 'event';
  level: 'info' | 'error';
  name: string;
  cause: string;
  remedy: string;
}

// What the compiler found in a text; the place is counted from 1, the column in characters.
export interface Issue {
  name: string;
  cause: string;
  remedy: string;
  pointer: string;
  line: number;
  column: number;
}

// The text of the running scene, as asked for.
export interface SceneText {
  type: 'text';
  file: string;
  crc: number;
  unsaved: boolean;
  text: string;
}

// What came of the draft with this number. Without issues it runs.
export interface Checked {
  type: 'checked';
  number: number;
  crc?: number; // of its text, if it runs
  issues: Issue[];
  more: number; // issues beyond these
}

// Each half second while it records, and once with what came of it.
export interface RecordingState {
  type: 'recording';
  on: boolean;
  seconds: number;
  ticks: number;
  missing: number; // ticks that are lost
  dropped?: number; // of those, by the device
  end?: string; // why it has ended: a name (docs/recording.md)
  fault?: string;
  bytes?: number; // of the file
}

export interface LinkChange {
  type: 'link';
  up: boolean;
}

export type ServerMessage = Hello | SceneStarted | State | ServerEvent | LinkChange | SceneText | Checked | RecordingState;

export type Verb = 'home' | 'arm' | 'disarm' | 'clear' | 'stop';

export type PageMessage =
  | { type: 'hand'; arm: number; position_m: Vec3 }
  | { type: 'command'; verb: Verb }
  | { type: 'pick'; scene: string }
  | { type: 'parameter'; name: string; value: number }
  | { type: 'material'; object: number; key: MaterialKey; value: number }
  | { type: 'text' }
  | { type: 'draft'; number: number; text: string }
  | { type: 'save'; replaces?: boolean }
  | { type: 'record'; on: boolean }
  | { type: 'answer'; prompt: number; answer: 'done' | 'decline' };

const kMostArms = 2;
const kTypes = new Set(['hello', 'scene', 'state', 'event', 'link', 'text', 'checked', 'recording']);

// The message of a text; null if the type is unknown, as a newer server may send.
export function parse_message(text: string): ServerMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof value !== 'object' || value === null || !('type' in value) || !kTypes.has(String(value.type))) return null;
  const message = value as ServerMessage;
  if (message.type === 'state') {
    if (!Number.isFinite(message.time_s) || !Array.isArray(message.arms)) return null;
    if (message.commission !== undefined && !Array.isArray(message.commission.steps)) return null;
    message.arms = message.arms.map((arm) => (Array.isArray(arm?.tip_m) ? arm : null));
  }
  if (message.type === 'text' && typeof message.text !== 'string') return null;
  if (message.type === 'checked' && !Array.isArray(message.issues)) return null;
  if (message.type === 'scene' && !Array.isArray(message.objects)) return null;
  if (message.type === 'hello' && !(Number.isInteger(message.arms) && message.arms >= 1 && message.arms <= kMostArms)) return null;
  return message;
}
