// A scene as a link and back: the same bytes; what is damaged or too large is refused.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { test } from 'node:test';
import { deflateSync } from 'node:zlib';

import { LinkError, linked_scene, scene_fragment } from '../../src/scene_link';

const kScenes = new URL('../../../../../scenes/', import.meta.url);
const files = readdirSync(kScenes, { recursive: true })
  .map(String)
  .filter((file) => file.endsWith('.scene.json'));

const bad = /damaged/;
const fragment_of = (value: unknown): string => `#scene=${deflateSync(JSON.stringify(value)).toString('base64url')}`;

test('every scene comes back with the same bytes', async () => {
  assert.ok(files.length >= 24);
  for (const file of files) {
    const bytes = readFileSync(new URL(file, kScenes));
    const scene = { name: file, text: bytes.toString() };
    const fragment = await scene_fragment({ ...scene, name: 'it', folder: file.split('/')[0], arms: 2 });
    assert.match(fragment, /^#scene=[\w-]+$/, file);
    assert.ok(fragment.length < 2000, `${file}: ${fragment.length}`);
    const back = await linked_scene(fragment);
    assert.deepEqual(Buffer.from(back.text), bytes, file);
    assert.deepEqual([back.name, back.folder, back.arms], ['it', file.split('/')[0], 2]);
  }
});

test('any text comes back, and another reader of the format understands it', async () => {
  const text = '\uFEFF{ "name": "Ring \u00f8 \u{1F9F5}" } // \r\n\t\0';
  const fragment = await scene_fragment({ name: 'a b', text });
  assert.deepEqual(await linked_scene(fragment), { name: 'a b', folder: undefined, arms: 1, text });
  assert.equal((await linked_scene(fragment_of({ name: 'x', text: 'y' }))).text, 'y');
});

test('a damaged link is refused wherever it is damaged', async () => {
  const fragment = await scene_fragment({ name: 'walls', text: readFileSync(new URL('walls/walls.scene.json', kScenes), 'utf8') });
  // Not the last letter: some of its bits are of no byte.
  for (let at = '#scene='.length; at < fragment.length - 1; at += 7) {
    const letter = fragment[at] === 'A' ? 'B' : 'A';
    await assert.rejects(linked_scene(fragment.slice(0, at) + letter + fragment.slice(at + 1)), bad, `letter ${at}`);
    await assert.rejects(linked_scene(fragment.slice(0, at)), bad, `cut at ${at}`);
  }
  await assert.rejects(linked_scene(`${fragment}%20`), bad);
});

test('what is no scene is refused', async () => {
  const refused = [null, 1, [], {}, { name: 'x' }, { name: '', text: '' }, { name: '../x', text: '' }, { name: '..', text: '' }];
  for (const value of [...refused, { name: 'x', text: '', arms: 3 }, { name: 'x', text: '', folder: 'a/b' }])
    await assert.rejects(linked_scene(fragment_of(value)), bad, JSON.stringify(value));
});

test('what is too large is refused, small as it may be when it is compressed', async () => {
  const large = '[' + '0,'.repeat(1 << 20) + ']';
  await assert.rejects(scene_fragment({ name: 'x', text: large }), /too large/);
  await assert.rejects(linked_scene(fragment_of({ name: 'x', text: large })), LinkError);
  const random = Array.from({ length: 20_000 }, (_, i) => Math.sin(i)).join();
  await assert.rejects(scene_fragment({ name: 'x', text: random }), /too large/);
  await assert.rejects(linked_scene(`#scene=${'A'.repeat(40_000)}`), /too long/);
});
