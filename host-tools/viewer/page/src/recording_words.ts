// What the page says of a recording and of its replay.
import type { RecordingState } from './protocol';
import type { Replayed } from './transport';

// docs/recording.md has all of them.
const kMost_bytes = 64 * 2 ** 20; // host-tools/viewer/session_recording.cpp
const kLost = ['link-lost', 'no-answer', 'port-closed', 'bus-off', 'interface-down'];
const kEnds: Record<string, string> = {
  stopped: 'another page or host has ended it',
  taken_over: 'another host records now',
  parameter_written: 'a parameter was written',
  scene_changed: 'another scene or material runs',
  guarded_move: 'a guarded move began',
  placed: 'a host said where an arm is',
  host_forces: 'a host commands the forces',
  tick_lost: 'the loop lost a tick',
  sample_stale: 'an encoder was late',
  counts_jumped: 'an encoder jumped',
  host_silent: 'this page was silent for too long',
};

// asked: the user of this page has ended it.
export function recorded_words(state: RecordingState, asked: boolean): string {
  const { ticks, missing, dropped = 0 } = state;
  const lost = missing === 0 ? 'none lost' : `${missing} lost, ${dropped} of them in the device`;
  return `${ticks} ticks, ${lost}. It has ended: ${end_words(state, asked)}.`;
}

const is_full = ({ bytes = 0 }: Pick<RecordingState, 'bytes'>): boolean => bytes > kMost_bytes;
// Whether it ended by itself: neither this page nor another host has stopped it.
export const ended_by_itself = (state: RecordingState, asked: boolean): boolean =>
  (state.end ?? 'stopped') !== 'stopped' || (!asked && is_full(state));

export function end_words({ end = 'stopped', fault, bytes = 0 }: RecordingState, asked: boolean): string {
  if (fault !== undefined) return `the fault ${fault}`;
  if (end === 'stopped' && asked) return 'as asked for';
  if (end === 'stopped' && is_full({ bytes })) return 'it is as large as a page may make it';
  if (kLost.includes(end)) return `the link to the device was lost (${end})`;
  return kEnds[end] ?? `the error ${end}`;
}

export function replayed_words(it: Replayed): string {
  if (it.error !== undefined) return `No replay: ${it.error.cause}.`;
  const cut = it.end === 'cut_off' ? ' The file was cut off: it has no end.' : '';
  return `${it.scene}: ${verdict_words(it)}${cut}`;
}

function verdict_words(it: Replayed): string {
  if (it.differs_at !== undefined) return `${it.ticks} ticks; the forces differ between tick ${it.exact_to} and tick ${it.differs_at}.`;
  const exact = it.exact_to < it.first_tick ? 'no force could be compared' : `every force up to tick ${it.exact_to} to the bit`;
  if (it.gap_at !== undefined) return `${it.ticks} ticks, ${exact}; tick ${it.gap_at} is missing, and ${it.not_replayed} ticks behind it.`;
  return it.exact_to < it.first_tick ? `${it.ticks} ticks, ${exact}.` : `${it.ticks} ticks, every force to the bit.`;
}

// 75 s: "1:15".
export const minutes = (seconds: number): string => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, '0')}`;

export function recording_file_name(scene: string, at: Date): string {
  const name = scene.replace(/[^\w-]+/g, '-').replace(/^-+|-+$/g, '') || 'scene';
  return `${name}-${at.toISOString().slice(0, 19).replace('T', '-').replaceAll(':', '')}.rec`;
}
