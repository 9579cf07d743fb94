// Drafts on their way to a compiler that takes its time.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Drafts } from '../../src/editor/drafts';
import type { Issue, PageMessage, SceneStarted } from '../../src/protocol';

const kIssue: Issue = { name: 'bad-json', cause: 'no', remedy: 'mend it', pointer: '', line: 1, column: 1 };
const scene = (text_crc: number, pick = 'a'): SceneStarted => ({ type: 'scene', name: pick, pick, crc: 0, text_crc, objects: [] });

class Bench {
  readonly sent: PageMessage[] = [];
  readonly told: string[] = [];
  connected = true;
  readonly drafts = new Drafts(
    (message) => {
      if (this.connected) this.sent.push(message);
      return this.connected;
    },
    {
      take_text: (text, is_new) => this.told.push(`${is_new ? 'new' : 'other'} ${text}`),
      conflict: () => this.told.push('conflict'),
      checked: (answer) => this.told.push(`checked ${answer.number}`),
    },
    0,
  );
  text(text: string, crc: number): void {
    this.drafts.on_text({ type: 'text', file: 'a.scene.json', crc, unsaved: false, text });
  }
  check(number: number, crc: number | null): void {
    const issues = crc === null ? [kIssue] : [];
    this.drafts.on_checked({ type: 'checked', number, issues, more: 0, ...(crc === null ? {} : { crc }) });
  }
  get drafted(): string[] {
    return this.sent.flatMap((message) => (message.type === 'draft' ? [`${message.number} ${message.text}`] : []));
  }
  get asked(): number {
    return this.sent.filter((message) => message.type === 'text').length;
  }
}

function opened(): Bench {
  const bench = new Bench();
  bench.drafts.on_scene(scene(1));
  bench.text('one', 1);
  return bench;
}

test('of many drafts one is under way, and the last follows', () => {
  const bench = opened();
  for (const text of ['a', 'ab', 'abc', 'abcd']) bench.drafts.submit(text);
  assert.deepEqual(bench.drafted, ['1 a']);
  bench.check(1, 2);
  assert.deepEqual(bench.drafted, ['1 a', '2 abcd']);
  bench.check(1, 2); // again: it is none that is waited for
  bench.check(2, 3);
  assert.equal(bench.drafts.busy, false);
  assert.deepEqual(bench.drafted, ['1 a', '2 abcd']);
});

test('its own text is not asked for again, one that was changed elsewhere is', () => {
  const bench = opened();
  bench.drafts.submit('two');
  bench.check(1, 2);
  bench.drafts.on_scene(scene(2));
  assert.equal(bench.asked, 1);
  bench.drafts.on_scene(scene(7));
  assert.equal(bench.asked, 2);
  bench.text('theirs', 7);
  assert.deepEqual(bench.told, ['new one', 'checked 1', 'other theirs']);
});

test('a text with errors is not given up for another', () => {
  const bench = opened();
  bench.drafts.submit('mine {');
  bench.check(1, null);
  assert.equal(bench.drafts.is_ahead, true);
  bench.drafts.on_scene(scene(7));
  bench.text('theirs', 7);
  assert.deepEqual(bench.told.slice(-1), ['conflict']);
  bench.drafts.reload();
  bench.drafts.on_scene(scene(8));
  bench.text('the file', 8);
  assert.deepEqual(bench.told.slice(-1), ['other the file']);
});

test('what is typed meanwhile is not overwritten by an answer that comes late', () => {
  const bench = opened();
  bench.drafts.on_scene(scene(5)); // somebody moves a slider
  bench.drafts.submit('mine');
  bench.text('theirs', 5);
  assert.deepEqual(bench.told, ['new one']);
  assert.deepEqual(bench.drafted, ['1 mine']);
});

test('a text that was checked runs when its scene comes, and not before', () => {
  const bench = opened();
  assert.equal(bench.drafts.is_ahead, false);
  bench.drafts.submit('two');
  bench.check(1, 2);
  assert.equal(bench.drafts.is_ahead, true, 'it is being uploaded');
  bench.drafts.on_scene(scene(2));
  assert.equal(bench.drafts.is_ahead, false);
});

test('errors of a scene are not those of the next one', () => {
  const bench = opened();
  bench.drafts.submit('mine {');
  bench.check(1, null);
  bench.drafts.on_scene(scene(9, 'b'));
  assert.equal(bench.drafts.is_ahead, false);
  bench.text('of b', 9);
  assert.equal(bench.drafts.is_other_text(scene(9, 'b')), false);
  assert.equal(bench.drafts.is_other_text(scene(10, 'b')), true);
});

test('after a lost connection the last text is sent again', () => {
  const bench = opened();
  bench.drafts.submit('a');
  bench.connected = false;
  bench.drafts.submit('b');
  bench.connected = true;
  bench.drafts.restart();
  assert.deepEqual(bench.drafted, ['1 a', '2 b']);
});

test('a draft that was refused is answered, and the next one follows', () => {
  const bench = opened();
  const refuse = (): void => bench.drafts.refuse({ type: 'event', level: 'error', name: 'busy', cause: 'no', remedy: 'wait' });
  refuse();
  assert.deepEqual(bench.told, ['new one'], 'nothing is under way');
  bench.drafts.submit('a');
  refuse();
  assert.deepEqual([bench.told.at(-1), bench.drafts.busy, bench.drafts.is_ahead], ['checked 1', false, true]);
  bench.check(1, 2); // it was another message
  bench.drafts.on_scene(scene(2));
  assert.equal(bench.drafts.is_ahead, false);
  bench.drafts.submit('b');
  assert.deepEqual(bench.drafted, ['1 a', '2 b']);
});

test('the scene is loaded anew while a draft is under way', () => {
  const bench = opened();
  bench.drafts.submit('a');
  bench.drafts.reload();
  assert.equal(bench.drafts.busy, false);
  bench.check(1, null); // that it was dropped
  bench.drafts.on_scene(scene(1));
  bench.text('one', 1);
  assert.deepEqual(bench.told, ['new one', 'other one']);
  bench.drafts.submit('b');
  assert.deepEqual(bench.drafted, ['1 a', '3 b']);
});

test('a scene whose text is not known is another one', () => {
  const bench = opened();
  bench.drafts.submit('a');
  bench.drafts.on_scene({ type: 'scene', name: 'unknown', crc: 5, objects: [] });
  assert.deepEqual([bench.drafts.busy, bench.drafts.is_ready, bench.asked], [false, false, 1]);
  bench.text('one', 1); // late
  assert.equal(bench.drafts.is_ready, false);
  bench.drafts.on_scene(scene(1));
  bench.text('one', 1);
  assert.deepEqual([bench.asked, ...bench.told], [2, 'new one', 'new one']);
});

test('two pages do not take the answers of each other', () => {
  const numbers = Array.from({ length: 2 }, () => {
    const sent: PageMessage[] = [];
    const drafts = new Drafts((message) => sent.push(message) > 0, { take_text() {}, conflict() {}, checked() {} });
    drafts.on_scene(scene(1));
    drafts.on_text({ type: 'text', file: 'a.scene.json', crc: 1, unsaved: false, text: 'one' });
    drafts.submit('a');
    return sent.flatMap((message) => (message.type === 'draft' ? [message.number] : []))[0];
  });
  assert.notEqual(numbers[0], numbers[1]); // but for one run in 500 000
});

test('another scene begins anew', () => {
  const bench = opened();
  bench.drafts.submit('a');
  bench.drafts.on_scene(scene(9, 'b'));
  bench.text('of b', 9);
  assert.deepEqual(bench.told.slice(-1), ['new of b']);
  bench.check(1, 4);
  assert.deepEqual(bench.told.slice(-1), ['new of b'], 'an answer for the scene before');
});

test('what was typed last is saved, not what runs', () => {
  const bench = opened();
  const saves = (): number => bench.sent.filter((message) => message.type === 'save').length;
  bench.drafts.submit('a');
  bench.drafts.save('ab', false);
  bench.check(1, 2);
  assert.deepEqual([bench.drafted, saves()], [['1 a', '2 ab'], 0]);
  bench.check(2, 3);
  assert.deepEqual([bench.sent.at(-1), saves()], [{ type: 'save', replaces: false }, 1]);
  bench.drafts.save('abc', false);
  bench.drafts.on_scene(scene(9, 'b'));
  bench.check(3, 4);
  assert.equal(saves(), 1, 'another scene is here');
});
