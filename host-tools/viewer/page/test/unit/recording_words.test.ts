// What is said of recordings and replays.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';

import { ended_by_itself, minutes, recorded_words, recording_file_name, replayed_words } from '../../src/recording_words';
import type { Replayed } from '../../src/transport';

const recorded = { type: 'recording', on: false, seconds: 3, ticks: 12006, missing: 0, end: 'stopped' } as const;
const replayed: Replayed = {
  exact: true,
  ticks: 12006,
  contact_ticks: 1,
  end: 'stopped',
  scene: 'walls',
  missing: 0,
  first_tick: 101,
  exact_to: 12100,
  not_replayed: 0,
  cut_bytes: 0,
};

test('a recording tells its ticks, what is lost, and why it has ended', () => {
  assert.equal(recorded_words(recorded, true), '12006 ticks, none lost. It has ended: as asked for.');
  assert.match(recorded_words(recorded, false), /another page or host has ended it/);
  assert.match(recorded_words({ ...recorded, bytes: 64 * 2 ** 20 + 1 }, false), /as large as a page may make it/);
  assert.ok(ended_by_itself({ ...recorded, bytes: 64 * 2 ** 20 + 1 }, false));
  assert.ok(!ended_by_itself(recorded, false));
  const lost = { ...recorded, missing: 5, dropped: 2, end: 'fault', fault: 'host_stop' };
  assert.equal(recorded_words(lost, false), '12006 ticks, 5 lost, 2 of them in the device. It has ended: the fault host_stop.');
  assert.match(recorded_words({ ...recorded, end: 'port-closed' }, true), /the link to the device was lost \(port-closed\)/);
  assert.match(recorded_words({ ...recorded, end: 'new-error' }, false), /the error new-error/);
});

test('each end that docs/recording.md names has words', () => {
  const text = readFileSync(new URL('../../../../../docs/recording.md', import.meta.url), 'utf8');
  const rows = text.split('| `end` in the file | reason |')[1].split('\n\n')[0];
  const names = [...rows.matchAll(/^\|((?: `[a-z_]+`,?)+) \|/gm)].flatMap(([, cell]) =>
    [...cell.matchAll(/[a-z_]+/g)].map(([name]) => name),
  );
  assert.ok(names.length >= 11, names.join());
  for (const end of names.filter((name) => name !== 'fault'))
    assert.ok(!recorded_words({ ...recorded, end }, true).includes('the error'), end);
});

test('a replay tells how far it is exact', () => {
  assert.equal(replayed_words(replayed), 'walls: 12006 ticks, every force to the bit.');
  assert.match(replayed_words({ ...replayed, exact: false, differs_at: 12116 }), /the forces differ between tick 12100 and tick 12116/);
  const gap = replayed_words({ ...replayed, exact: false, gap_at: 12107, not_replayed: 9 });
  assert.equal(gap, 'walls: 12006 ticks, every force up to tick 12100 to the bit; tick 12107 is missing, and 9 ticks behind it.');
  assert.match(replayed_words({ ...replayed, end: 'cut_off' }), /cut off/);
  assert.match(replayed_words({ ...replayed, exact_to: 100 }), /no force could be compared/);
  const error = { name: 'not-a-recording', cause: 'x is no recording', remedy: '' };
  assert.equal(replayed_words({ error } as Replayed), 'No replay: x is no recording.');
});

test('names of files, and times', () => {
  assert.equal(recording_file_name('A ball: (mine)', new Date('2026-11-30T04:05:06Z')), 'A-ball-mine-2026-11-30-040506.rec');
  assert.equal(recording_file_name('../..', new Date('2026-11-30T04:05:06Z')), 'scene-2026-11-30-040506.rec');
  assert.deepEqual([0, 9.9, 75].map(minutes), ['0:00', '0:09', '1:15']);
});
