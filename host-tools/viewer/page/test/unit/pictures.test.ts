// Every demonstration has its picture, and the page of pictures shows it.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { kPictures, page_of_pictures } from '../../pictures/list';
import { kTop } from '../real/command';

const kSuffix = '.scene.json';
const scenes = readdirSync(join(kTop, 'scenes'), { withFileTypes: true })
  .filter((folder) => folder.isDirectory())
  .flatMap((folder) =>
    readdirSync(join(kTop, 'scenes', folder.name))
      .filter((file) => file.endsWith(kSuffix))
      .map((file) => `${folder.name}/${file.slice(0, -kSuffix.length)}`),
  );

test('the list of pictures has every scene, once', () => {
  assert.ok(scenes.length >= 24);
  assert.deepEqual(kPictures.map(({ folder, scene }) => `${folder}/${scene}`).sort(), scenes.sort());
});

test('docs/pictures.md and its pictures are those of the list', () => {
  assert.equal(readFileSync(join(kTop, 'docs/pictures.md'), 'utf8'), page_of_pictures(), 'run scripts/pictures');
  const pictures = readdirSync(join(kTop, 'docs/pictures')).sort();
  assert.deepEqual(pictures, kPictures.map(({ scene }) => `${scene}.png`).sort());
});

test('every scene has its small picture for the gallery, 60 kB for all of them', () => {
  const sizes = kPictures.map(({ folder, scene }) => statSync(join(kTop, 'scenes', folder, `${scene}.webp`)).size);
  assert.ok(sizes.reduce((sum, size) => sum + size) <= 60_000, `${sizes}`);
});
